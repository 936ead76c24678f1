//! What there is to tell of a face, before it has a number and a severity.

use glam::DVec3;

/// Something told of a face, and where.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Told {
    pub(crate) place: Option<DVec3>,
    pub(crate) what: String,
}
