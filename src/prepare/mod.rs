//! Preprocessing, once per model: Bézier patches, pcurves, tiles, shared edges, bounds. Parallel over faces.
//!
//! The folders are listed in the order of the work. Each may `use` only folders above it (`tests/circles`).

mod surface;

mod uv;

mod report;
pub use report::NoRegion;

mod trims;
pub use trims::free_region::{FreeRegion, TrimNote};
pub use trims::spans::UvDomain;

mod wires;

mod sew;

mod regions;

mod tiles;

mod join;
pub use join::memory::{PrepareError, PrepareLimits, PreparedMemory};
pub use join::prepared::{FaceFacts, Prepared};
pub use join::shells::Shells;

mod whole;
pub use whole::prepare::{PrepareOptions, prepare, prepare_on};

/// What this project's own program, benches and tests use of the stages. Not part of the stable interface.
#[doc(hidden)]
pub mod internals {
    pub use super::join::prepared::{
        Break, EdgeImages, EdgeShape, EdgeUse, OpenEdges, PreparedEdge, PreparedFace, PreparedPart, Tile, TileUse,
    };
    pub(crate) use super::join::prepared::{EDGES_PER_BOX, EdgeImage};
    pub(crate) use super::report::panic_message;
    pub use super::surface::decompose::{self, BezierPatches, BezierSpline3};
    pub use super::surface::tables::{Bend, BoundingBox, BoxBounds, CurveBounds, StripBounds, SurfaceBounds};
    pub(crate) use super::uv::foot::newton_step;
    pub use super::uv::uv_curve::{UvCurve, UvSample};
    pub(crate) use super::whole::weight::nanoseconds;
}
