//! The report of the deviation audit, as data and as a table.

use super::Spread;
use crate::model::{EdgeId, FaceId, PartId, SurfaceKind, TileId};
use glam::DVec3;
use std::fmt;

/// A point of the mesh and its distance to the surface of its face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The part.
    pub part: PartId,
    /// The face within the part.
    pub face: FaceId,
    /// The tile within the part.
    pub tile: TileId,
    /// The triangle within the tile's batch.
    pub triangle: usize,
    /// The surface's kind.
    pub kind: SurfaceKind,
    /// The point on the triangle, in part coordinates, millimetres.
    pub point: DVec3,
    /// Distance to the surface minus the gap allowed there, divided by the chord tolerance.
    pub over_tolerance: f64,
    /// Gap in the file between surface and edges, and between edges and vertices, millimetres.
    pub gap: f64,
}

/// A point on an edge and the distance between its polyline and its curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgePlace {
    /// The part.
    pub part: PartId,
    /// The edge within the part.
    pub edge: EdgeId,
    /// The point on the polyline or the curve, in part coordinates, millimetres.
    pub point: DVec3,
    /// Distance minus the gap between vertex and curve end in the file, divided by the chord tolerance.
    pub over_tolerance: f64,
}

/// Deviation of a mesh from its exact geometry, as fractions of the chord tolerance.
///
/// Each part counts once, however often it is placed, at its largest scale.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct DeviationReport {
    /// The chord tolerance that all ratios refer to, millimetres of the placed model.
    pub chord: f64,
    /// Distances from triangles to surfaces.
    pub raw: Spread,
    /// Distances from triangles to surfaces, minus the gaps in the file between surface, edges and vertices of the
    /// face. Triangles with lattice points for all corners get no allowance for gaps.
    pub beyond_gap: Spread,
    /// [`beyond_gap`](Self::beyond_gap) per kind of surface. Kinds without samples are missing.
    pub kinds: Vec<(SurfaceKind, Spread)>,
    /// The worst place beyond the gap of each of the worst faces, worst first, at most [`Self::PLACES`].
    pub worst: Vec<Place>,
    /// Number of faces with a sample over the tolerance.
    pub faces_over: usize,
    /// Distances between edge polylines and curves, both ways, minus the gaps between vertices and curve ends.
    pub edges: Spread,
    /// The worst place of each of the worst edges, worst first, at most [`Self::PLACES`].
    pub worst_edges: Vec<EdgePlace>,
    /// Number of triangles of the mesh.
    pub triangles: u64,
    /// Number of measured triangles: all up to four million, else every k-th; without those of tiles that were skipped.
    pub measured: u64,
}

impl DeviationReport {
    /// Maximum length of [`worst`](Self::worst) and of [`worst_edges`](Self::worst_edges).
    pub const PLACES: usize = 8;

    /// Mean number of samples per measured triangle.
    #[must_use]
    pub fn samples_per_triangle(&self) -> f64 {
        self.raw.samples as f64 / self.measured.max(1) as f64
    }
}

impl fmt::Display for DeviationReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "deviation / {:.4e} mm    samples     over   median      99%    99.9%    worst", self.chord)?;
        for (kind, spread) in &self.kinds {
            writeln!(f, "  {:<22}{spread}", kind.name())?;
        }
        writeln!(f, "  {:<22}{}", "all", self.beyond_gap)?;
        writeln!(f, "  {:<22}{}", "all, gaps included", self.raw)?;
        writeln!(f, "  {:<22}{}", "edges", self.edges)?;
        for place in &self.worst {
            let Place { part, face, tile, triangle, kind, point, over_tolerance, gap } = place;
            writeln!(
                f,
                "  {over_tolerance:.4} at part {} face {} ({}, gap {gap:.1e}) tile {} triangle {triangle}, {point:.6}",
                part.0,
                face.0,
                kind.name(),
                tile.0
            )?;
        }
        for EdgePlace { part, edge, point, over_tolerance } in &self.worst_edges {
            writeln!(f, "  {over_tolerance:.4} at part {} edge {}, {point:.6}", part.0, edge.0)?;
        }
        write!(
            f,
            "  {} faces over; measured {} of {} triangles, {:.1} samples each",
            self.faces_over,
            self.measured,
            self.triangles,
            self.samples_per_triangle()
        )
    }
}
