//! Polygons -> their areas.

use glam::DVec2;

/// Twice the signed area of a closed polygon.
pub(crate) fn double_area(p: &[DVec2]) -> f64 {
    let Some(&o) = p.first() else { return 0.0 };
    (0..p.len()).map(|i| (p[i] - o).perp_dot(p[(i + 1) % p.len()] - o)).sum()
}
