//! Systems of two equations, and what comes nearest to their solution.

use glam::{DVec2, DVec3};

/// The solution of `[[e, f], [f, g]] x = y`. `None` unless the matrix is positive definite with a determinant above
/// `least` times `e * g`.
pub(crate) fn solve_symmetric([e, f, g]: [f64; 3], y: DVec2, least: f64) -> Option<DVec2> {
    let det = e * g - f * f;
    let is_definite = e > 0.0 && g > 0.0 && det > least * e * g;
    is_definite.then(|| DVec2::new((g * y.x - f * y.y) / det, (e * y.y - f * y.x) / det))
}

/// The step (du, dv) that brings `a du + b dv` nearest to `r`. Where `a` and `b` are parallel, a step along the longer
/// one.
pub(crate) fn least_squares(a: DVec3, b: DVec3, r: DVec3) -> DVec2 {
    let (e, f, g) = (a.length_squared(), a.dot(b), b.length_squared());
    let along = DVec2::new(r.dot(a), r.dot(b));
    solve_symmetric([e, f, g], along, 1e-14).unwrap_or_else(|| {
        if e >= g && e > 0.0 {
            DVec2::new(along.x / e, 0.0)
        } else if g > 0.0 {
            DVec2::new(0.0, along.y / g)
        } else {
            DVec2::ZERO
        }
    })
}
