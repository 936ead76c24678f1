//! Paid once per model: Bézier patches, pcurves, tiles, shared edges, bounds.

mod bounds;
pub use bounds::{CurveBounds, SurfaceBounds};

mod decompose;
pub use decompose::{BezierPatches, BezierSpline3};

mod prepared;
pub use prepared::{Break, EdgeShape, EdgeUse, Prepared, PreparedEdge, PreparedFace, PreparedPart, Shape, Tile};

mod uv_curve;
pub use uv_curve::{UvCurve, UvSample};

use crate::model::Model;

/// Knobs of [`prepare`].
#[derive(Clone, Debug, PartialEq)]
pub struct PrepareOptions {
    /// Threads to use; `None` = the pool the caller is in.
    pub threads: Option<usize>,
}

impl PrepareOptions {
    /// The caller's rayon pool.
    pub const DEFAULT: Self = Self { threads: None };
}

/// Makes a model ready for tessellation. Never fails as a whole: a face that cannot be used becomes a diagnostic.
#[must_use]
pub fn prepare(model: Model, options: &PrepareOptions) -> Prepared {
    let _ = (model, options);
    unimplemented!("lands next")
}
