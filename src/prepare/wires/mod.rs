//! Wires that have gaps or are out of order -> wires that close.

pub(super) mod chain;
pub(super) mod ends;
pub(super) mod order;
pub(super) mod tally;
pub(super) mod heal;
