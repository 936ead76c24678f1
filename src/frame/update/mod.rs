//! A tile's cache and a new plan -> the tile, rebuilt only where it changed (Kumar and Manocha 1995, §5.2).

pub(super) mod memory;
pub(super) mod samples;
pub(super) mod cells;
pub(super) mod weave;
pub(super) mod tile;
