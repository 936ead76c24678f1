//! What became of the free trims of faces.

use crate::model::{FaceError, FaceTrouble};
use crate::prepare::report::told::Told;
use crate::prepare::uv::region::Region;

/// A face's region, and what there is to tell of it.
#[derive(Clone, Debug)]
pub(crate) struct FreeFace {
    pub(crate) region: Region,
    /// How far its edges may be off the surface: those that it shares are other faces' curves.
    pub(crate) gap: f64,
    pub(crate) notes: Vec<FaceTrouble>,
    pub(crate) repairs: Vec<Told>,
}

/// What became of each face's free trims; none for a face without.
pub(crate) type FreeFaces = Vec<Option<Result<FreeFace, FaceError>>>;
