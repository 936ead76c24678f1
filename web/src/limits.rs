//! What a stage may cost in a module with 32-bit addresses.

/// Memory that a stage may take, bytes, estimated from counts: 3 of the 4 GiB that a module has.
pub(crate) const MEMORY: u64 = 3 << 30;
