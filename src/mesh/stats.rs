//! Batches -> counts and triangle quality, as the ratio of shortest height to longest edge.

use super::Batch;
use std::fmt;

/// Size and quality of a mesh.
///
/// Thinness is the shortest height over the longest edge: 0.866 for an equilateral triangle. Below
/// [`MeshStats::SLIVER`] a triangle counts as a sliver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshStats {
    /// Triangles.
    pub triangles: u64,
    /// Vertices as batches hold them: a vertex shared by two tiles counts twice.
    pub vertices: u64,
    /// Batches with at least one triangle.
    pub batches: u64,
    /// Triangles thinner than [`MeshStats::SLIVER`].
    pub slivers: u64,
    /// Least thinness of a triangle; 1 if there are no triangles.
    pub min_thinness: f64,
    /// Mean over all triangles; 0 if there are no triangles.
    pub mean_thinness: f64,
}

impl MeshStats {
    /// Thinness below which a triangle is a sliver.
    pub const SLIVER: f64 = 0.01;

    /// Measures `batches`. O(triangles).
    #[must_use]
    pub fn of<'a>(batches: impl IntoIterator<Item = &'a Batch>) -> Self {
        let mut stats =
            Self { triangles: 0, vertices: 0, batches: 0, slivers: 0, min_thinness: 1.0, mean_thinness: 0.0 };
        for Batch { mesh, .. } in batches {
            stats.triangles += mesh.triangles.len() as u64;
            stats.vertices += mesh.positions.len() as u64;
            stats.batches += u64::from(!mesh.triangles.is_empty());
            for corners in &mesh.triangles {
                let [Some(&a), Some(&b), Some(&c)] = corners.map(|corner| mesh.positions.get(corner as usize)) else {
                    continue;
                };
                let longest_squared =
                    (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
                let twice_area = (b - a).cross(c - a).length();
                let thinness = if longest_squared > 0.0 { twice_area / longest_squared } else { 0.0 };
                stats.slivers += u64::from(thinness < Self::SLIVER);
                stats.min_thinness = stats.min_thinness.min(thinness);
                stats.mean_thinness += thinness;
            }
        }
        stats.mean_thinness /= stats.triangles.max(1) as f64;
        stats
    }
}

impl fmt::Display for MeshStats {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} triangles and {} vertices in {} batches, thinness {:.3} mean, {:.2e} least, {} slivers",
            self.triangles, self.vertices, self.batches, self.mean_thinness, self.min_thinness, self.slivers
        )
    }
}
