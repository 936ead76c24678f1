//! What the master decides for a frame: lattice lines per tile, tessellants per edge. The only state both sides of an edge share.

use crate::prepare::Prepared;

/// What a mesh must keep, in object space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Largest distance between triangles and surface, and between polylines and edges, millimetres.
    pub chord: f64,
    /// Largest turning of the normal across a cell and of the tangent along a segment, radians.
    pub angle: f64,
    /// Largest length of a cell's side or an edge's segment, millimetres.
    pub max_edge: Option<f64>,
}

/// Lattice lines of one tile, in the parameters of its face's patches; first and last are the tile's border.
#[derive(Clone, Debug, PartialEq)]
pub struct TileLattice {
    /// u-lines, strictly increasing.
    pub us: Vec<f64>,
    /// v-lines, strictly increasing.
    pub vs: Vec<f64>,
}

/// Tessellants of one edge.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgePolyline {
    /// Parameters, strictly increasing; contains all breaks.
    pub ts: Vec<f64>,
    /// Where each break stands in `ts`.
    pub breaks: Vec<u32>,
}

/// The plan of one part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PartPlan {
    /// One per tile.
    pub tiles: Vec<TileLattice>,
    /// One per prepared edge (empty for edges that no tile uses).
    pub edges: Vec<EdgePolyline>,
}

/// The plan of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// One per part.
    pub parts: Vec<PartPlan>,
}

/// Rates for a tolerance in object space.
#[must_use]
pub fn plan(prepared: &Prepared, tolerance: &Tolerance) -> Plan {
    let _ = (prepared, tolerance);
    unimplemented!("lands next")
}
