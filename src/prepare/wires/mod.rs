//! Wires that have gaps or are out of order -> wires that close.

pub(super) mod chain;
pub(super) mod ends;
pub(super) mod heal;
pub(super) mod order;
