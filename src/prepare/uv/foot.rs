//! Foot points of a projection, and what a step in space is in (u,v) there.

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
    /// The foot of `p` at `uv`, where the surface has these tangents.
    pub(super) fn new(uv: DVec2, p: DVec3, tangents: [DVec3; 3]) -> Self {
        Self { uv, off: p.distance(tangents[0]), tangents }
    }
}

/// The step (du, dv) that brings `a du + b dv` nearest to `r`. Where `a` and `b` are parallel, a step along the longer
/// one.
pub(super) fn least_squares(a: DVec3, b: DVec3, r: DVec3) -> DVec2 {
    let (e, f, g) = (a.length_squared(), a.dot(b), b.length_squared());
    let det = e * g - f * f;
    if det > 1e-14 * e * g {
        return DVec2::new((g * r.dot(a) - f * r.dot(b)) / det, (e * r.dot(b) - f * r.dot(a)) / det);
    }
    if e >= g && e > 0.0 {
        DVec2::new(r.dot(a) / e, 0.0)
    } else if g > 0.0 {
        DVec2::new(0.0, r.dot(b) / g)
    } else {
        DVec2::ZERO
    }
}

/// The step of Newton's method to the point nearest to the one that lies at `r` from here. Converges quadratically where
/// that is off the surface, while [`least_squares`] gains a fixed share of the distance per step. `None` where the
/// distance is not convex, or hardly.
pub(crate) fn newton_step(here: &SurfaceDerivatives, r: DVec3) -> Option<DVec2> {
    let SurfaceDerivatives { du, dv, duu, duv, dvv, .. } = *here;
    let (e, f, g) = (du.length_squared() - r.dot(duu), du.dot(dv) - r.dot(duv), dv.length_squared() - r.dot(dvv));
    let det = e * g - f * f;
    let is_convex = e > 0.0 && g > 0.0 && det > 1e-3 * e * g;
    let (along_u, along_v) = (r.dot(du), r.dot(dv));
    is_convex.then(|| DVec2::new((g * along_u - f * along_v) / det, (e * along_v - f * along_u) / det))
}

/// The velocity in (u,v) of a point that moves with velocity `c` in space; NaN where the surface is singular.
pub(super) fn jacobian_solve(a: DVec3, b: DVec3, c: DVec3) -> DVec2 {
    let (e, f, g) = (a.length_squared(), a.dot(b), b.length_squared());
    let det = e * g - f * f;
    if det > 1e-12 * e * g && e > 1e-18 * g && g > 1e-18 * e {
        DVec2::new((g * c.dot(a) - f * c.dot(b)) / det, (e * c.dot(b) - f * c.dot(a)) / det)
    } else {
        DVec2::NAN
    }
}
