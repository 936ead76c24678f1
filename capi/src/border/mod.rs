//! The border to C: the only place that follows its pointers. Each is checked for null and alignment, each struct for
//! its size; that it points to what its type says is the caller's promise.

pub(crate) mod handles;

mod sized;
pub(crate) use sized::{Versioned, versioned, zeros};

mod user;
pub(crate) use user::User;

use crate::jobs::tt_body;
use crate::status::{Failure, tell, tt_status};
use std::any::Any;
use std::ffi::{CStr, c_char, c_void};
use std::marker::PhantomData;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::{ptr, slice};

/// Proof that C made this call, and keeps the header's rule of pointers. Pointers are only followed through it.
pub(crate) struct Caller(());

/// Runs the body of a function of the interface: a failure becomes its status, and words for `tt_last_error`; so does a
/// panic.
///
/// # Safety
/// Pointers that `body` hands to the [`Caller`] are those that C passed, and C keeps the header's rule of pointers.
pub(crate) unsafe fn call<R: Into<tt_status>>(body: impl FnOnce(&Caller) -> Result<R, Failure>) -> tt_status {
    match catch_unwind(AssertUnwindSafe(|| body(&Caller(())))) {
        Ok(Ok(done)) => done.into(),
        Ok(Err(failure)) => tell(failure),
        Err(panic) => tell(Failure::panic(&message(&*panic))),
    }
}

/// [`call`] as the body of a function that C calls.
macro_rules! entry {
    ($caller:ident => $body:expr) => {
        // SAFETY: only C calls these functions, whose header states the rule of pointers.
        unsafe { $crate::border::call(|$caller: &$crate::border::Caller| $body) }
    };
}
pub(crate) use entry;

/// The text of a panic.
pub(crate) fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default()
}

/// Types without rules about their bits, of which C passes arrays.
///
/// # Safety
/// Every sequence of bytes is a value, and there is no padding.
pub(crate) unsafe trait Plain: Copy {}

macro_rules! plain {
    ($($name:ty),*) => {
        $(
            // SAFETY: numbers, and structs of numbers of equal size.
            unsafe impl Plain for $name {}
        )*
    };
}
plain!(u8, u32, u64, f64, crate::builder::tt_coedge);

/// Where a result goes: not null, aligned.
pub(crate) struct Out<'a, T>(*mut T, PhantomData<&'a mut T>);

impl<T> Out<'_, T> {
    /// Writes the result.
    pub(crate) fn give(self, value: T) {
        // SAFETY: a `Caller` checked the pointer, and its promise is that there is room for a `T`.
        unsafe { self.0.write(value) }
    }
}

/// Where a struct that states its size goes.
pub(crate) struct OutStruct<'a, T>(Out<'a, T>, usize);

impl<T: Versioned> OutStruct<'_, T> {
    /// Writes the struct as far as the caller knows it, and zeros where the caller knows more.
    pub(crate) fn give(self, value: &T) {
        let (to, from, known) = (self.0.0.cast::<u8>(), ptr::from_ref(value).cast::<u8>(), size_of::<T>());
        // The caller's `size` stays as it is.
        let (start, end) = (size_of::<u32>(), self.1.min(known));
        // SAFETY: `size` bytes are the caller's struct, as a `Caller` checked; `end` are within both.
        unsafe {
            ptr::copy_nonoverlapping(from.add(start), to.add(start), end - start);
            ptr::write_bytes(to.add(end), 0, self.1 - end);
        }
    }
}

fn not_null<T>(name: &str, pointer: *const T) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::argument(format!("{name} is null")));
    }
    if !pointer.is_aligned() {
        return Err(Failure::argument(format!("{name} is not a multiple of {}", align_of::<T>())));
    }
    Ok(())
}

impl Caller {
    /// A text that ends with a zero byte.
    pub(crate) fn text(&self, name: &str, text: *const c_char) -> Result<&str, Failure> {
        not_null(name, text)?;
        // SAFETY: not null; the caller's promise is that a zero byte ends it.
        let text = unsafe { CStr::from_ptr(text) };
        let not = |error: std::str::Utf8Error| {
            Failure::argument(format!("{name} is not UTF-8 after {} bytes", error.valid_up_to()))
        };
        text.to_str().map_err(not)
    }

    /// A text, empty if null.
    pub(crate) fn text_or_empty(&self, name: &str, text: *const c_char) -> Result<&str, Failure> {
        if text.is_null() { Ok("") } else { self.text(name, text) }
    }

    /// An array of `count`. It may be null if it is empty.
    pub(crate) fn slice<T: Plain>(&self, name: &str, items: *const T, count: usize) -> Result<&[T], Failure> {
        if count == 0 {
            return Ok(&[]);
        }
        not_null(name, items)?;
        if count > isize::MAX as usize / size_of::<T>() {
            return Err(Failure::argument(format!("{name}: {count} do not fit into memory")));
        }
        // SAFETY: not null, aligned, and no longer than memory; the caller's promise is that there are `count`.
        Ok(unsafe { slice::from_raw_parts(items, count) })
    }

    /// A struct that states its size.
    pub(crate) fn read<T: Versioned>(&self, name: &str, from: *const T) -> Result<T, Failure> {
        not_null(name, from)?;
        // SAFETY: not null, aligned; the caller's promise is that `size` tells its length.
        unsafe { sized::read(name, from) }
    }

    /// A struct that states its size; one of zeros if null.
    pub(crate) fn read_or_zeros<T: Versioned>(&self, name: &str, from: *const T) -> Result<T, Failure> {
        if from.is_null() { Ok(zeros()) } else { self.read(name, from) }
    }

    /// An array of structs that state their size, all the same.
    pub(crate) fn structs<T: Versioned>(&self, name: &str, from: *const T, count: usize) -> Result<Vec<T>, Failure> {
        if count == 0 {
            return Ok(Vec::new());
        }
        let first = self.read(name, from)?;
        let stride = first.size() as usize;
        if !stride.is_multiple_of(align_of::<T>()) || count > isize::MAX as usize / stride {
            return Err(Failure::argument(format!("{name}: {count} structs of {stride} bytes do not stand in a row")));
        }
        let mut all = vec![first];
        for k in 1..count {
            let name = format!("{name}[{k}]");
            let next = from.wrapping_byte_add(k * stride);
            // SAFETY: within the array that the caller promises, aligned as the first one is.
            let item: T = unsafe { sized::read(&name, next)? };
            if item.size() != first.size() {
                return Err(Failure::argument(format!(
                    "{name}.size is {}, that of the first is {stride}",
                    item.size()
                )));
            }
            all.push(item);
        }
        Ok(all)
    }

    /// Where to write a result.
    pub(crate) fn out<T>(&self, name: &str, to: *mut T) -> Result<Out<'_, T>, Failure> {
        not_null(name, to)?;
        Ok(Out(to, PhantomData))
    }

    /// Where to write, if anywhere.
    pub(crate) fn out_if<T>(&self, name: &str, to: *mut T) -> Result<Option<Out<'_, T>>, Failure> {
        if to.is_null() { Ok(None) } else { self.out(name, to).map(Some) }
    }

    /// Where to write a struct that states its size.
    pub(crate) fn out_struct<T: Versioned>(&self, name: &str, to: *mut T) -> Result<OutStruct<'_, T>, Failure> {
        not_null(name, to)?;
        // SAFETY: not null, aligned; every such struct begins with its size.
        let size = unsafe { to.cast::<u32>().read() };
        let size = sized::check::<T>(name, size)?;
        Ok(OutStruct(Out(to, PhantomData), size))
    }

    /// Where to write a struct that states its size, if anywhere.
    pub(crate) fn out_struct_if<T: Versioned>(
        &self,
        name: &str,
        to: *mut T,
    ) -> Result<Option<OutStruct<'_, T>>, Failure> {
        if to.is_null() { Ok(None) } else { self.out_struct(name, to).map(Some) }
    }

    /// Copies `from` into a buffer of `capacity` bytes, cut between characters, with a zero byte at the end. `length`
    /// gets the bytes of all of it, without that one.
    pub(crate) fn give_text(
        &self,
        from: &str,
        to: *mut c_char,
        capacity: usize,
        length: *mut usize,
    ) -> Result<(), Failure> {
        if capacity > 0 {
            not_null("text", to)?;
            let most = from.len().min(capacity - 1);
            let cut = (0..=most).rev().find(|&k| from.is_char_boundary(k)).unwrap_or(0);
            // SAFETY: not null; the caller's promise is that there is room for `capacity` bytes.
            unsafe {
                ptr::copy_nonoverlapping(from.as_ptr(), to.cast(), cut);
                to.add(cut).write(0);
            }
        }
        if !length.is_null() {
            self.out("length", length)?.give(from.len());
        }
        Ok(())
    }
}

/// Lends the memory that C gave for a tile.
///
/// # Safety
/// Both are valid for writes of so many bytes, and nobody else uses them until `fill` returns.
pub(crate) unsafe fn lend(
    (vertices, vertex_bytes): (*mut u8, usize),
    (indices, index_bytes): (*mut u8, usize),
    fill: &mut dyn FnMut(&mut [u8], &mut [u8]),
) {
    // SAFETY: by this function's own rule. What the bytes were does not matter: `fill` reads none.
    let (vertices, indices) =
        unsafe { (slice::from_raw_parts_mut(vertices, vertex_bytes), slice::from_raw_parts_mut(indices, index_bytes)) };
    fill(vertices, indices);
}

/// The body of a loop, and its numbers.
struct Body<'a> {
    count: usize,
    call: &'a (dyn Fn(usize) + Sync),
}

/// Lends the body of a loop to C, which calls it while `to` runs. `body` does not panic.
pub(crate) fn lend_body(count: usize, body: &(dyn Fn(usize) + Sync), to: impl FnOnce(tt_body, *mut c_void)) {
    extern "C" fn call(of: *mut c_void, number: u32) {
        if of.is_null() {
            return;
        }
        // SAFETY: C passes on the pointer that it got below, and the header's rule is that all calls have returned when
        // the loop does, so what it points to is alive. It is shared, and never changed.
        let body = unsafe { &*of.cast_const().cast::<Body<'_>>() };
        let number = number as usize;
        if number < body.count {
            (body.call)(number);
        }
    }
    let body = Body { count, call: body };
    to(call, ptr::from_ref(&body).cast_mut().cast());
}
