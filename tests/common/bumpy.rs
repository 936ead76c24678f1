//! A NURBS surface with bumps, of any degrees and knots.

use glam::DVec3;
use trimtess::model::NurbsSurface;

/// `weight` gives that of the control point (i, j). Without it all weights are 1.
pub(crate) fn bumpy(
    [degree_u, degree_v]: [usize; 2],
    [knots_u, knots_v]: [Vec<f64>; 2],
    weight: Option<&dyn Fn(f64, f64) -> f64>,
) -> NurbsSurface {
    let (count_u, count_v) = (knots_u.len() - degree_u - 1, knots_v.len() - degree_v - 1);
    let grid = || (0..count_u).flat_map(|i| (0..count_v).map(move |j| (i as f64, j as f64)));
    let points = grid().map(|(x, y)| DVec3::new(x + 0.2 * y.sin(), y, (1.7 * x + 0.9 * y).sin())).collect();
    let weights = weight.map_or_else(Vec::new, |weight| grid().map(|(x, y)| weight(x, y)).collect());
    NurbsSurface { degree_u, degree_v, knots_u, knots_v, points, weights }
}
