//! Wires that have gaps, are out of order or given twice -> wires that close and bound something.

pub(super) mod heal;
pub(super) mod boundary;
