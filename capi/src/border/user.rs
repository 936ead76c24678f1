//! The pointer that a caller wants back in every callback.

use std::ffi::c_void;

/// A pointer that is passed on and never followed.
#[derive(Clone, Copy)]
pub(crate) struct User(*mut c_void);

// SAFETY: this library only passes it on. The header tells which callbacks run on which threads, and the caller's
// promise is that what it points to may be used there.
unsafe impl Send for User {}

// SAFETY: as above.
unsafe impl Sync for User {}

impl User {
    pub(crate) fn of(pointer: *mut c_void) -> Self {
        Self(pointer)
    }

    pub(crate) fn get(self) -> *mut c_void {
        self.0
    }
}
