//! Surfaces in their natural parameters -> points, partial derivatives, normals (closed forms of ISO 10303-42).

use super::{Frame3, Surface, SurfaceDerivatives, knots};
use glam::DVec3;

impl Surface {
    /// `S(u,v)` in natural parameters.
    ///
    /// Analytic surfaces are defined everywhere. Parameters of curves and NURBS are clamped to the domain, not wrapped.
    #[must_use]
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        match self {
            Self::Extrusion { curve, direction } => curve.point(u) + *direction * v,
            Self::Revolution { curve, frame } => turned_point(&Spin::new(frame, u), curve.point(v) - frame.origin),
            Self::Nurbs(surface) => surface.point(u, v),
            _ => self.evaluated(u, v).point,
        }
    }

    /// The points at all pairs of `us` and `vs`, u-major, bit-identical to [`point`](Self::point).
    pub(crate) fn lattice(&self, us: &[f64], vs: &[f64]) -> Vec<DVec3> {
        match self {
            Self::Nurbs(surface) => surface.lattice(us, vs),
            Self::Extrusion { curve, direction } => {
                let points = us.iter().map(|&u| curve.point(u));
                points.flat_map(|point| vs.iter().map(move |&v| point + *direction * v)).collect()
            }
            Self::Revolution { curve, frame } => {
                let arms: Vec<DVec3> = vs.iter().map(|&v| curve.point(v) - frame.origin).collect();
                let spins = us.iter().map(|&u| Spin::new(frame, u));
                spins.flat_map(|spin| arms.iter().map(move |&arm| turned_point(&spin, arm))).collect()
            }
            _ => us.iter().flat_map(|&u| vs.iter().map(move |&v| self.point(u, v))).collect(),
        }
    }

    /// `S(u,v)`, `S_u`, `S_v`, bit-identical to [`derivatives`](Self::derivatives).
    #[must_use]
    pub fn tangents(&self, u: f64, v: f64) -> [DVec3; 3] {
        match self {
            Self::Extrusion { curve, direction } => {
                let [point, du] = curve.tangent(u);
                [point + *direction * v, du, *direction]
            }
            Self::Revolution { curve, frame } => {
                let [point, slope] = curve.tangent(v);
                let (spin, arm) = (Spin::new(frame, u), point - frame.origin);
                [turned_point(&spin, arm), spin.rate(arm), spin.turn(slope)]
            }
            Self::Nurbs(surface) => surface.tangents(u, v),
            _ => {
                let SurfaceDerivatives { point, du, dv, .. } = self.evaluated(u, v);
                [point, du, dv]
            }
        }
    }

    /// Whether `S_u` and `S_v` are continuous, as far as knots tell. `periods`: its [`period`](Self::period). A spline
    /// that closes may have a crease there.
    #[must_use]
    pub(crate) fn is_smooth(&self, periods: [Option<f64>; 2]) -> bool {
        (0..2).all(|axis| {
            let spline = self.knots(axis);
            spline.is_none_or(|(degree, knots)| periods[axis].is_none() && knots::is_smooth(degree, knots))
        })
    }

    /// The point and its five partial derivatives by the natural parameters.
    #[must_use]
    pub fn derivatives(&self, u: f64, v: f64) -> SurfaceDerivatives {
        self.evaluated(u, v)
    }

    /// [`derivatives`](Self::derivatives), inlined into callers that need some of them only.
    #[inline(always)]
    fn evaluated(&self, u: f64, v: f64) -> SurfaceDerivatives {
        match self {
            Self::Plane { frame } => SurfaceDerivatives {
                point: frame.origin + frame.x * u + frame.y * v,
                du: frame.x,
                dv: frame.y,
                duu: DVec3::ZERO,
                duv: DVec3::ZERO,
                dvv: DVec3::ZERO,
            },
            Self::Cylinder { frame, radius } => turned(frame, u, [*radius, 0.0, 0.0], [v, 1.0, 0.0]),
            Self::Cone { frame, radius, half_angle } => {
                let slope = libm::tan(*half_angle);
                turned(frame, u, [radius + v * slope, slope, 0.0], [v, 1.0, 0.0])
            }
            Self::Sphere { frame, radius } => {
                let (s, c) = libm::sincos(v);
                turned(frame, u, [radius * c, -radius * s, -radius * c], [radius * s, radius * c, -radius * s])
            }
            Self::Torus { frame, major, minor } => {
                let (s, c) = libm::sincos(v);
                turned(frame, u, [major + minor * c, -minor * s, -minor * c], [minor * s, minor * c, -minor * s])
            }
            Self::Extrusion { curve, direction } => {
                let c = curve.derivatives(u);
                SurfaceDerivatives {
                    point: c.point + *direction * v,
                    du: c.d1,
                    dv: *direction,
                    duu: c.d2,
                    duv: DVec3::ZERO,
                    dvv: DVec3::ZERO,
                }
            }
            Self::Revolution { curve, frame } => {
                let c = curve.derivatives(v);
                let spin = Spin::new(frame, u);
                let arm = c.point - frame.origin;
                SurfaceDerivatives {
                    point: frame.origin + spin.turn(arm),
                    du: spin.rate(arm),
                    dv: spin.turn(c.d1),
                    duu: spin.bend(arm),
                    duv: spin.rate(c.d1),
                    dvv: spin.turn(c.d2),
                }
            }
            Self::Nurbs(surface) => surface.derivatives(u, v),
        }
    }

    /// The unit normal along `S_u × S_v`; at poles and collapsed borders, the normal a little inside the domain.
    ///
    /// `None` if the surface has no tangent plane nearby (a net collapsed to a curve or a point).
    #[must_use]
    pub fn normal(&self, u: f64, v: f64) -> Option<DVec3> {
        match self {
            Self::Plane { frame } => Some(frame.z),
            Self::Cylinder { frame, .. } => Some(Spin::new(frame, u).outward()),
            Self::Cone { frame, radius, half_angle } => {
                let (s, c) = libm::sincos(*half_angle);
                let normal = Spin::new(frame, u).outward() * c - frame.z * s;
                // Beyond the apex S_u flips, and the normal with it.
                Some(if radius + v * libm::tan(*half_angle) < 0.0 { -normal } else { normal })
            }
            Self::Sphere { frame, .. } => {
                let (s, c) = libm::sincos(v);
                Some(Spin::new(frame, u).outward() * c + frame.z * s)
            }
            Self::Torus { frame, major, minor } => {
                let (s, c) = libm::sincos(v);
                let normal = Spin::new(frame, u).outward() * c + frame.z * s;
                Some(if major + minor * c < 0.0 { -normal } else { normal })
            }
            Self::Extrusion { .. } | Self::Revolution { .. } | Self::Nurbs(_) => self.nudged_normal(u, v),
        }
    }

    /// The normal at (u,v), else at the first regular point of up to three nearer and nearer to the middle of the
    /// domain.
    fn nudged_normal(&self, u: f64, v: f64) -> Option<DVec3> {
        let [(u0, u1), (v0, v1)] = self.natural_domain();
        let middle = |a: f64, b: f64, t: f64| if (b - a).is_finite() { 0.5 * (a + b) } else { t };
        let (mu, mv) = (middle(u0, u1, u), middle(v0, v1, v));
        let (range_u, range_v) = (spread(u0, u1), spread(v0, v1));
        [0.0, 1e-6, 1e-4, 1e-2].into_iter().find_map(|step| {
            let [_, du, dv] = self.tangents(u + (mu - u) * step, v + (mv - v) * step);
            // Scaled to the whole domain, so that lengths in both directions compare.
            let (du, dv) = (du * range_u, dv * range_v);
            let (lu, lv) = (du.length(), dv.length());
            let area = du.cross(dv);
            let regular = lu.min(lv) > 1e-9 * lu.max(lv) && area.length() > 1e-9 * lu * lv;
            if regular { area.try_normalize() } else { None }
        })
    }
}

/// The length of a domain, 1 where it is unbounded.
fn spread(a: f64, b: f64) -> f64 {
    let d = b - a;
    if d.is_finite() && d > 0.0 { d } else { 1.0 }
}

/// Rotation about a frame's z axis by one angle, with derivatives by the angle.
struct Spin<'a> {
    frame: &'a Frame3,
    sin: f64,
    cos: f64,
}

impl<'a> Spin<'a> {
    fn new(frame: &'a Frame3, angle: f64) -> Self {
        let (sin, cos) = libm::sincos(angle);
        Self { frame, sin, cos }
    }

    /// The unit vector away from the axis.
    fn outward(&self) -> DVec3 {
        self.frame.x * self.cos + self.frame.y * self.sin
    }

    /// The unit vector of increasing angle.
    fn around(&self) -> DVec3 {
        self.frame.y * self.cos - self.frame.x * self.sin
    }

    /// Rotates `d`.
    fn turn(&self, d: DVec3) -> DVec3 {
        self.outward() * d.dot(self.frame.x) + self.around() * d.dot(self.frame.y) + self.frame.z * d.dot(self.frame.z)
    }

    /// The first derivative of [`turn`](Self::turn).
    fn rate(&self, d: DVec3) -> DVec3 {
        self.around() * d.dot(self.frame.x) - self.outward() * d.dot(self.frame.y)
    }

    /// The second derivative of [`turn`](Self::turn).
    fn bend(&self, d: DVec3) -> DVec3 {
        -self.outward() * d.dot(self.frame.x) - self.around() * d.dot(self.frame.y)
    }
}

/// The point at `arm` from the frame's origin, rotated.
fn turned_point(spin: &Spin<'_>, arm: DVec3) -> DVec3 {
    spin.frame.origin + spin.turn(arm)
}

/// A surface of revolution at angle `u`. Meridian: distance from the axis and height, each with two derivatives by v.
#[inline(always)]
fn turned(frame: &Frame3, u: f64, distance: [f64; 3], height: [f64; 3]) -> SurfaceDerivatives {
    let spin = Spin::new(frame, u);
    let (out, around) = (spin.outward(), spin.around());
    SurfaceDerivatives {
        point: frame.origin + out * distance[0] + frame.z * height[0],
        du: around * distance[0],
        dv: out * distance[1] + frame.z * height[1],
        duu: -out * distance[0],
        duv: around * distance[1],
        dvv: out * distance[2] + frame.z * height[2],
    }
}
