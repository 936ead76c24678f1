//! Which library this is, and how many of its objects are alive.

use crate::border::handles;
use std::ffi::c_char;

/// Version of this header. `tt_version` has that of the library. While the first number is 0, programs need a library
/// of the same first and second number.
#[allow(dead_code, reason = "for the header; tests/header.rs compares it with the package")]
pub const TT_VERSION_MAJOR: u32 = 0;
#[allow(dead_code, reason = "as above")]
pub const TT_VERSION_MINOR: u32 = 1;
#[allow(dead_code, reason = "as above")]
pub const TT_VERSION_PATCH: u32 = 0;

/// "None" where a number of 32 bits stands for a part, face, edge or entity.
pub const TT_NONE: u32 = u32::MAX;

/// Version of the library, as "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn tt_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// Number of handles that were given and not freed, of all kinds and threads: 0 at the end of a program without leaks.
#[unsafe(no_mangle)]
pub extern "C" fn tt_live_handles() -> u64 {
    handles::live()
}
