//! One tile, one thread: prepared tile and plan in, triangles out.

use super::Plan;
use crate::mesh::{EdgeLine, PatchMesh, TileId};
use crate::model::{EdgeId, FaceId, PartId};
use crate::prepare::Prepared;

/// Buffers that one worker reuses for all its tiles. Leaves no trace in results.
#[derive(Default, Debug)]
pub struct Scratch {}

/// How a tile fell short of the normal path.
#[derive(Clone, Debug, PartialEq)]
pub enum Degradation {
    /// The trim polygon crosses itself; it was resolved by winding.
    NotSimple {
        /// How many points had to be added where segments cross.
        crossings: u32,
    },
    /// Nothing is left of the tile at this tolerance.
    Empty,
    /// The tile could not be triangulated.
    Failed(String),
}

/// A tile's triangles and how they came about.
#[derive(Clone, Debug)]
pub struct TileOutcome {
    /// The face.
    pub face: FaceId,
    /// The triangles.
    pub mesh: PatchMesh,
    /// What went wrong, if anything did.
    pub degradation: Option<Degradation>,
}

/// Tessellates one tile under a plan.
#[must_use]
pub fn tessellate_tile(
    prepared: &Prepared,
    plan: &Plan,
    part: PartId,
    tile: TileId,
    scratch: &mut Scratch,
) -> TileOutcome {
    let _ = (prepared, plan, part, tile, scratch);
    unimplemented!("lands next")
}

/// The polyline of a B-rep edge under a plan.
#[must_use]
pub fn edge_line(prepared: &Prepared, plan: &Plan, part: PartId, edge: EdgeId) -> EdgeLine {
    let _ = (prepared, plan, part, edge);
    unimplemented!("lands next")
}
