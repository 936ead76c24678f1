//! Structs that may grow: the first field states how many bytes the caller's version of them has.

use crate::status::Failure;
use std::mem::MaybeUninit;
use std::ptr;

/// Largest size that a caller may state. A larger one is a number that nobody has set.
const MOST: usize = 4096;

/// A struct of the interface whose first field is `size`, a `u32`.
///
/// # Safety
/// `repr(C)`, begins with a `u32`, and consists of numbers, pointers and optional functions: zeros are a value.
pub(crate) unsafe trait Versioned: Copy {
    /// Size in the first version of the interface that has it.
    const FIRST: usize;

    fn size(&self) -> u32;

    /// What must be 0, so that later versions can use it.
    fn reserved(&self) -> u32;
}

/// A struct whose version is the first; `reserved` if it has such a field.
macro_rules! versioned {
    ($name:ident $(, $reserved:ident)?) => {
        // SAFETY: `repr(C)`, with `size` first, of numbers, pointers and optional functions.
        unsafe impl $crate::border::Versioned for $name {
            const FIRST: usize = size_of::<Self>();

            fn size(&self) -> u32 {
                self.size
            }

            fn reserved(&self) -> u32 {
                0 $(| self.$reserved)?
            }
        }
    };
}
pub(crate) use versioned;

/// The size that a caller states, if it can be one.
pub(super) fn check<T: Versioned>(name: &str, size: u32) -> Result<usize, Failure> {
    let stated = size as usize;
    if (T::FIRST..=MOST).contains(&stated) {
        return Ok(stated);
    }
    let known = size_of::<T>();
    Err(Failure::argument(format!("{name}.size is {size}; the struct of this version has {known} bytes")))
}

/// A struct of zeros: all fields have their defaults.
pub(crate) fn zeros<T: Versioned>() -> T {
    // SAFETY: by the trait's rule.
    unsafe { MaybeUninit::zeroed().assume_init() }
}

/// Reads a struct as far as both sides know it. Refuses one with values that only the caller knows.
///
/// # Safety
/// `from` is aligned, and valid for reads of as many bytes as its `size` states.
pub(super) unsafe fn read<T: Versioned>(name: &str, from: *const T) -> Result<T, Failure> {
    // SAFETY: the struct begins with its size.
    let size = check::<T>(name, unsafe { from.cast::<u32>().read() })?;
    let known = size_of::<T>();
    // SAFETY: bytes beyond what this version knows, within what the caller states.
    let unknown = (known..size).any(|k| unsafe { from.cast::<u8>().add(k).read() } != 0);
    if unknown {
        return Err(Failure::argument(format!(
            "{name} has fields after its first {known} bytes, which are all known here"
        )));
    }
    let mut value: T = zeros();
    // SAFETY: `from` has `size` bytes, `value` has `known`; they do not overlap.
    unsafe { ptr::copy_nonoverlapping(from.cast::<u8>(), (&raw mut value).cast(), size.min(known)) };
    if value.reserved() != 0 {
        return Err(Failure::argument(format!("{name}.reserved is {}; it must be 0", value.reserved())));
    }
    Ok(value)
}
