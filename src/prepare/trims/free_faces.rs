//! Regions made from the free trims of faces.

use crate::model::{FaceError, FaceTrouble};
use crate::prepare::report::finding::Finding;
use crate::prepare::uv::uv_loop::Region;

/// A face's region, with notes and repairs to report.
#[derive(Clone, Debug)]
pub(crate) struct FreeFace {
    pub(crate) region: Region,
    /// Largest distance of its edges from the surface. Shared edges may be curves of another face.
    pub(crate) gap: f64,
    pub(crate) notes: Vec<FaceTrouble>,
    pub(crate) repairs: Vec<Finding>,
}

/// The region or error of each face; `None` for a face without free trims.
pub(crate) type FreeFaces = Vec<Option<Result<FreeFace, FaceError>>>;
