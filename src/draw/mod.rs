//! Diagrams of the parameter plane as SVG: the stages of triangulating a tile, and the region that trimming curves
//! keep.
//!
//! Diagrams show recorded decisions of the pipeline (`record_tile`, `prepare::FreeRegion`) and make none. u points
//! right and v up.
//! Figures 7 to 12 of the paper, for a tile of this crate:
//!
#![doc = include_str!("../../docs/figures/tile.svg")]
//!
#![doc = include_str!("../../docs/figures/cell.svg")]

mod page;

mod region;
pub use region::{RegionPanel, regions};

mod tile;
pub use tile::{TileDiagram, TileView, tile};
