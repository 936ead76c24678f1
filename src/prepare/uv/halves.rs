//! Images of circles -> whether the cubics of both halves of a piece fit, by how well that of the whole piece does.

use super::uv_curve::UvSample;
use crate::model::Surface;
use glam::DVec2;

/// How many times nearer the cubics of both halves are, at least: 10.6, and 16 in the limit. The piece is of half a span of
/// an arc or less, from an end or the middle of the span.
const BY_HALVING: f64 = 10.0;

/// Largest change of a parameter that counts as constant, as a share of the tolerance.
const STEADY: f64 = 0.05;

/// Whether the halves of a piece between two samples of a circle's image fit within `tolerance`, where the whole misses
/// the middle sample by `off`. `speeds`: lengths of the surface's derivatives there.
///
/// Known for circles in planes, and where one parameter is constant and the other an angle. Not next to a pole, where
/// slopes are NaN.
pub(super) fn halves_fit(surface: &Surface, samples: [&UvSample; 3], speeds: DVec2, off: f64, tolerance: f64) -> bool {
    let [a, _, b] = samples;
    let moves = |s: &UvSample, axis: usize| (s.uv - a.uv)[axis].abs() + (s.d[axis] * (b.t - a.t)).abs();
    let is_steady = |axis: usize| samples.iter().all(|s| speeds[axis] * moves(s, axis) <= STEADY * tolerance);
    off <= BY_HALVING * tolerance
        && match surface {
            Surface::Plane { .. } => true,
            Surface::Cylinder { .. } | Surface::Cone { .. } => is_steady(1),
            Surface::Sphere { .. } | Surface::Torus { .. } => is_steady(0) || is_steady(1),
            Surface::Extrusion { .. } | Surface::Revolution { .. } | Surface::Nurbs(_) => false,
        }
}
