//! Preprocessing, once per model: Bézier patches, pcurves, tiles, shared edges, bounds. Parallel over faces (rayon).
//!
//! The folders are listed in the order of the work. Each may `use` only folders above it (`tests/layers.rs`).

mod surface;
/// Converts NURBS to Bézier pieces.
pub use surface::decompose;
pub use surface::decompose::{BezierPatches, BezierSpline3};
pub use surface::tables::{Bend, BoundingBox, BoxBounds, CurveBounds, StripBounds, SurfaceBounds};

mod uv;
pub use uv::uv_curve::{UvCurve, UvSample};

mod report;
pub(crate) use report::guard::panic_message;
pub use report::refusals::NoRegion;

mod trims;
pub use trims::free_region::{FreeRegion, TrimNote};
pub use trims::intersect::{CurveMeeting, CurvePlace, MeetingKind, intersections};
pub use trims::spans::UvDomain;

mod wires;

mod sew;

mod regions;

mod tiles;

mod join;
pub(crate) use join::images::EdgeImage;
pub use join::images::EdgeImages;
pub use join::limits::{PrepareError, PrepareLimits};
pub use join::prepared::{
    Break, EdgeShape, EdgeUse, OpenEdges, Prepared, PreparedEdge, PreparedFace, PreparedPart, Tile, TileUse,
};
pub use join::shells::Shells;

mod whole;
pub use whole::prepare::{PrepareOptions, prepare};
pub(crate) use whole::weight::nanoseconds;
