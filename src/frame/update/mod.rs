//! Tiles as they were -> tiles as they are, made again only where they changed (Kumar and Manocha 1995, §5.2).

pub(super) mod again;
pub(super) mod memory;
pub(super) mod samples;
pub(super) mod tile;
pub(super) mod weave;
