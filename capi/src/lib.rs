//! The C interface of `trimtess`: opaque handles, structs that state their size, status codes with words.
//!
//! Every function is one entry ([`border::call`]): it checks its arguments, catches panics and returns a
//! [`status::tt_status`]. Handles are numbers in tables ([`border::handles`]), so one that is null, freed or of another
//! kind is an error and not undefined behaviour. All that reads or writes memory of C stands in [`border`].
//!
//! `include/trimtess.h` is made of the sources by cbindgen (`tests/header.rs`); their comments are its documentation.
//! Modules are in the order in which the header has them.
#![allow(unsafe_code, reason = "functions that C can find have names without mangling, and take raw pointers")]
#![deny(unsafe_op_in_unsafe_fn)]
#![allow(non_camel_case_types, reason = "types have their names of C")]
#![allow(clippy::missing_safety_doc, reason = "the header states one rule of pointers for all functions, at its head")]
#![allow(unreachable_pub, reason = "cbindgen puts into the header what is `pub`")]

mod border;

mod status;

mod version;

mod log;

mod control;

mod diagnostic;

mod model;

mod read;

mod geometry;

mod builder;

mod prepared;

mod threads;

mod limits;

mod mesh;

mod view;

mod layout;

mod memory;

mod sink;

mod jobs;

mod options;

mod session;

mod attributes;

#[cfg(test)]
mod tests;
