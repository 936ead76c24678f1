//! Diagrams in the parameter plane as SVG: how a tile came to its triangles, and what trimming curves keep under a rule.
//!
//! They show what the pipeline itself decided ([`frame::internals::record_tile`],
//! [`prepare::FreeRegion`]), and decide nothing. u runs to the right and v up. The paper's Figures
//! 7 to 12, of a tile of this crate:
//!
#![doc = include_str!("../../docs/figures/tile.svg")]
//!
#![doc = include_str!("../../docs/figures/cell.svg")]

mod page;

mod path;

mod region;
pub use region::{RegionPanel, regions};

mod tile;
pub use tile::{TileDiagram, TileView, tile};
