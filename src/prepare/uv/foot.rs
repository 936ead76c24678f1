//! Foot points of a projection, and what a step in space is in (u,v) there.

use crate::math::solve::solve_symmetric;
use crate::model::SurfaceDerivatives;
use glam::{DVec2, DVec3};

/// A point of the surface near a point in space.
#[derive(Clone, Copy)]
pub(super) struct Foot {
    /// Periodic parameters may lie outside the domain.
    pub(super) uv: DVec2,
    /// Distance in space.
    pub(super) off: f64,
    /// The surface's point and its derivatives by u and v.
    pub(super) tangents: [DVec3; 3],
}

impl Foot {
    /// No foot yet: any other is nearer.
    pub(super) fn none(uv: DVec2) -> Self {
        Self { uv, off: f64::INFINITY, tangents: [DVec3::NAN; 3] }
    }

    /// The foot of `p` at `uv`, where the surface has these tangents.
    pub(super) fn new(uv: DVec2, p: DVec3, tangents: [DVec3; 3]) -> Self {
        Self { uv, off: p.distance(tangents[0]), tangents }
    }
}

/// The step of Newton's method to the point nearest to the one that lies at `r` from here. Converges quadratically where
/// that is off the surface, while `least_squares` gains a fixed share of the distance per step. `None` where the
/// distance is not convex, or hardly.
pub(crate) fn newton_step(here: &SurfaceDerivatives, r: DVec3) -> Option<DVec2> {
    let SurfaceDerivatives { du, dv, duu, duv, dvv, .. } = *here;
    let matrix = [du.length_squared() - r.dot(duu), du.dot(dv) - r.dot(duv), dv.length_squared() - r.dot(dvv)];
    solve_symmetric(matrix, DVec2::new(r.dot(du), r.dot(dv)), 1e-3)
}

/// The velocity in (u,v) of a point that moves with velocity `c` in space; NaN where the surface is singular.
pub(super) fn jacobian_solve(a: DVec3, b: DVec3, c: DVec3) -> DVec2 {
    let (e, f, g) = (a.length_squared(), a.dot(b), b.length_squared());
    let is_even = e > 1e-18 * g && g > 1e-18 * e;
    let velocity = is_even.then(|| solve_symmetric([e, f, g], DVec2::new(c.dot(a), c.dot(b)), 1e-12));
    velocity.flatten().unwrap_or(DVec2::NAN)
}
