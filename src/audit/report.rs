//! The report of the deviation audit, as data, as a table, and as faults in words. Percentiles are taken from a
//! logarithmic histogram, in constant memory.

use crate::mesh::{MeshFacts, Scene, SceneFacts, ScenePart};
use crate::model::{EdgeId, FaceId, PartId, SurfaceKind, TileId};
use crate::prepare::Shells;
use glam::DVec3;
use std::fmt;

/// Ratios up to this one share the first bin.
const LEAST: f64 = 1e-6;
/// Bins per factor e. Percentiles are at most 1 % too high.
const BINS_PER_E: f64 = 100.0;
/// Bins up to a ratio of about 1e6. Larger ones share the last.
const BINS: usize = 2764;

/// Distribution of ratios of deviation to tolerance. All zero without samples. Percentiles are up to 1 % too high, and
/// at most about 1e6.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Number of samples.
    pub samples: u64,
    /// Number of samples above 1.
    pub over: u64,
    /// Median.
    pub median: f64,
    /// 99th percentile.
    pub p99: f64,
    /// 99.9th percentile.
    pub p999: f64,
    /// Maximum. Infinite if a position is not finite.
    pub worst: f64,
}

impl fmt::Display for Spread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { samples, over, median, p99, p999, worst } = self;
        write!(f, "{samples:>10} {over:>8} {median:>8.4} {p99:>8.4} {p999:>8.4} {worst:>8.4}")
    }
}

/// A histogram of ratios.
#[derive(Clone, Debug)]
pub(super) struct Tally {
    bins: Vec<u64>,
    over: u64,
    worst: f64,
}

impl Default for Tally {
    fn default() -> Self {
        Self { bins: vec![0; BINS], over: 0, worst: 0.0 }
    }
}

impl Tally {
    /// Adds a ratio. NaN counts as infinite.
    pub(super) fn add(&mut self, ratio: f64) {
        let ratio = if ratio.is_nan() { f64::INFINITY } else { ratio };
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the bins")]
        let bin = ((ratio / LEAST).ln() * BINS_PER_E).ceil().clamp(0.0, (BINS - 1) as f64) as usize;
        self.bins[bin] += 1;
        self.over += u64::from(ratio > 1.0);
        self.worst = self.worst.max(ratio);
    }

    pub(super) fn join(&mut self, other: &Self) {
        self.bins.iter_mut().zip(&other.bins).for_each(|(mine, theirs)| *mine += theirs);
        self.over += other.over;
        self.worst = self.worst.max(other.worst);
    }

    /// The distribution so far.
    pub(super) fn spread(&self) -> Spread {
        let samples: u64 = self.bins.iter().sum();
        let percentile = |share: f64| {
            let mut left = samples as f64 * share;
            let bin = self.bins.iter().position(|&count| {
                left -= count as f64;
                left <= 0.0
            });
            bin.map_or(self.worst, |bin| (LEAST * (bin as f64 / BINS_PER_E).exp()).min(self.worst))
        };
        let (median, p99, p999) = (percentile(0.5), percentile(0.99), percentile(0.999));
        Spread { samples, over: self.over, median, p99, p999, worst: self.worst }
    }
}

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
            let (part, face, kind, tile) = (part.0, face.0, kind.name(), tile.0);
            writeln!(
                f,
                "  {over_tolerance:.4} at part {part} face {face} ({kind}, gap {gap:.1e}) tile {tile} triangle \
                 {triangle}, {point:.6}"
            )?;
        }
        for EdgePlace { part, edge, point, over_tolerance } in &self.worst_edges {
            writeln!(f, "  {over_tolerance:.4} at part {} edge {}, {point:.6}", part.0, edge.0)?;
        }
        let Self { faces_over, measured, triangles, .. } = self;
        let each = self.samples_per_triangle();
        write!(f, "  {faces_over} faces over; measured {measured} of {triangles} triangles, {each:.1} samples each")
    }
}

/// Fraction of the chord tolerance that edge polylines may reach. Edges are refined by an upper bound on the deviation,
/// so only rounding needs an allowance.
const EDGE_LIMIT: f64 = 1.05;

/// What is wrong with a mesh, given its check and the shells of the file's parts: malformed triangles, cracks, parts
/// that are turned inside out. Empty for a sound mesh. One sentence per fault, those of parts with the part's number.
#[must_use]
pub fn mesh_faults(scene: &Scene, facts: &SceneFacts, shells: &[Shells]) -> Vec<String> {
    let malformed = (!facts.total.is_well_formed()).then(|| format!("the mesh is malformed: {}", facts.total));
    let parts = scene.parts.iter().zip(&facts.parts).zip(shells).enumerate();
    let of_parts = parts.flat_map(|(number, ((part, mesh), shells))| {
        part_faults(part, mesh, shells).map(move |fault| format!("part {number}: {fault}"))
    });
    malformed.into_iter().chain(of_parts).collect()
}

/// Faults of a part's mesh, given the edges and shells of the file.
fn part_faults(part: &ScenePart, mesh: &MeshFacts, shells: &Shells) -> impl Iterator<Item = String> {
    let cracked = (mesh.defects > 0).then(|| {
        let (count, length) = (mesh.defects, mesh.defect_length);
        let file = if part.closed { "closed in the file" } else { "open elsewhere in the file" };
        format!("{file}, but its mesh has {count} unbalanced edges ({length:.3e} mm)")
    });
    let solid = shells.open == 0;
    let expected = (shells.voids + shells.undirected) as u64;
    let inverted = (solid && mesh.negative_components > expected).then(|| {
        let (count, voids) = (mesh.negative_components, shells.voids);
        format!("{count} components of its mesh have negative volume, but the file has {voids} voids: inside out")
    });
    cracked.into_iter().chain(inverted)
}

impl DeviationReport {
    /// Violations of the tolerance: more than one sample in a thousand over it, or an edge by more than 5 %. One
    /// sentence each.
    pub fn faults(&self) -> impl Iterator<Item = String> + use<> {
        let (surfaces, edges) = (self.beyond_gap, self.edges);
        let off = (surfaces.p999 > 1.0).then(|| {
            let (over, samples, worst) = (surfaces.over, surfaces.samples, surfaces.worst);
            format!("{over} of {samples} mesh samples exceed the chord tolerance, the worst by a factor of {worst:.3}")
        });
        let edges_off = (edges.worst > EDGE_LIMIT).then(|| {
            let (over, samples, worst) = (edges.over, edges.samples, edges.worst);
            format!(
                "{over} of {samples} samples of edges exceed the chord tolerance, the worst by a factor of {worst:.3}"
            )
        });
        off.into_iter().chain(edges_off)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_at_most_one_percent_too_high() {
        let mut tally = Tally::default();
        (1..=10_000).for_each(|k| tally.add(f64::from(k) * 2e-4));
        let spread = tally.spread();
        assert_eq!((spread.samples, spread.over), (10_000, 5_000));
        for (got, exact) in [(spread.median, 1.0), (spread.p99, 1.98), (spread.p999, 1.998), (spread.worst, 2.0)] {
            assert!(got >= exact * (1.0 - 1e-12) && got <= 1.01 * exact + 1e-12, "{got} for {exact}");
        }
    }

    #[test]
    fn empty_tallies_are_zero_and_nan_is_infinite() {
        assert_eq!(Tally::default().spread(), Spread::default());
        let mut tally = Tally::default();
        tally.add(f64::NAN);
        tally.add(0.0);
        assert_eq!((tally.spread().worst, tally.spread().over, tally.spread().median), (f64::INFINITY, 1, LEAST));
    }
}
