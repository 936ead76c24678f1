//! Surfaces of CAD models, in their natural parameters.
//!
//! Natural parameters follow ISO 10303-42: angles in radians, lengths in the part's unit.

use super::{Frame3, NurbsCurve3, knots};
use glam::DVec3;

/// A NURBS surface. Control point `(i, j)` (i along u) is `points[i * count_v + j]`.
///
/// Degrees, knots and weights follow the rules of [`NurbsCurve`](super::NurbsCurve) in each direction.
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsSurface {
    /// Degree in u.
    pub degree_u: usize,
    /// Degree in v.
    pub degree_v: usize,
    /// Knots in u, repeated by multiplicity; `count_u + degree_u + 1` of them.
    pub knots_u: Vec<f64>,
    /// Knots in v, repeated by multiplicity; `count_v + degree_v + 1` of them.
    pub knots_v: Vec<f64>,
    /// Control points, u-major.
    pub points: Vec<DVec3>,
    /// Weights in the same order, or empty for a polynomial surface.
    pub weights: Vec<f64>,
}

/// The surface of a face.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// `S(u,v) = O + u·x + v·y`; normal z.
    Plane {
        /// Placement.
        frame: Frame3,
    },
    /// `S(u,v) = O + r(cos u·x + sin u·y) + v·z`; normal outwards.
    Cylinder {
        /// Placement; z is the axis.
        frame: Frame3,
        /// Radius > 0.
        radius: f64,
    },
    /// `S(u,v) = O + (r + v·tan a)(cos u·x + sin u·y) + v·z`; the apex is at `v = -r / tan a`.
    Cone {
        /// Placement; z is the axis.
        frame: Frame3,
        /// Radius at v = 0, ≥ 0.
        radius: f64,
        /// Half angle a, radians, in (-π/2, π/2), not 0.
        half_angle: f64,
    },
    /// `S(u,v) = O + r cos v (cos u·x + sin u·y) + r sin v·z`, v in [-π/2, π/2].
    Sphere {
        /// Placement.
        frame: Frame3,
        /// Radius > 0.
        radius: f64,
    },
    /// `S(u,v) = O + (R + r cos v)(cos u·x + sin u·y) + r sin v·z`.
    ///
    /// With `minor > major` the torus intersects itself; faces use its lemon or apple part.
    Torus {
        /// Placement; z is the axis.
        frame: Frame3,
        /// R ≥ 0.
        major: f64,
        /// r > 0.
        minor: f64,
    },
    /// `S(u,v) = C(u) + v·d` (d not necessarily unit).
    Extrusion {
        /// The swept curve.
        curve: NurbsCurve3,
        /// Sweep vector per unit of v.
        direction: DVec3,
    },
    /// `S(u,v)` = C(v) rotated by the angle u about the frame's z axis through its origin.
    Revolution {
        /// The rotated curve.
        curve: NurbsCurve3,
        /// Placement; z is the axis.
        frame: Frame3,
    },
    /// A B-spline surface as given.
    Nurbs(NurbsSurface),
}

/// Kind of a [`Surface`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SurfaceKind {
    /// [`Surface::Plane`]
    Plane,
    /// [`Surface::Cylinder`]
    Cylinder,
    /// [`Surface::Cone`]
    Cone,
    /// [`Surface::Sphere`]
    Sphere,
    /// [`Surface::Torus`]
    Torus,
    /// [`Surface::Extrusion`]
    Extrusion,
    /// [`Surface::Revolution`]
    Revolution,
    /// [`Surface::Nurbs`]
    Nurbs,
}

impl SurfaceKind {
    /// All kinds, in the order of declaration.
    pub const ALL: &'static [Self] = &[
        Self::Plane,
        Self::Cylinder,
        Self::Cone,
        Self::Sphere,
        Self::Torus,
        Self::Extrusion,
        Self::Revolution,
        Self::Nurbs,
    ];

    /// The kind as one lower-case word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Plane => "plane",
            Self::Cylinder => "cylinder",
            Self::Cone => "cone",
            Self::Sphere => "sphere",
            Self::Torus => "torus",
            Self::Extrusion => "extrusion",
            Self::Revolution => "revolution",
            Self::Nurbs => "nurbs",
        }
    }
}

impl Surface {
    /// Degree and knots along an axis in which the surface is a spline: 0 for u, 1 for v.
    pub(crate) fn knots(&self, axis: usize) -> Option<(usize, &[f64])> {
        match (self, axis) {
            (Self::Nurbs(s), 0) => Some((s.degree_u, &s.knots_u)),
            (Self::Nurbs(s), _) => Some((s.degree_v, &s.knots_v)),
            (Self::Extrusion { curve, .. }, 0) | (Self::Revolution { curve, .. }, 1) => {
                Some((curve.degree, &curve.knots))
            }
            _ => None,
        }
    }

    /// The distinct knots of the domain along u and along v; none where the surface is no spline.
    pub(crate) fn breaks(&self) -> [Vec<f64>; 2] {
        [0, 1].map(|axis| self.knots(axis).map_or_else(Vec::new, |(degree, knots)| knots::breaks(degree, knots)))
    }

    /// Kind of this surface.
    #[must_use]
    pub const fn kind(&self) -> SurfaceKind {
        match self {
            Self::Plane { .. } => SurfaceKind::Plane,
            Self::Cylinder { .. } => SurfaceKind::Cylinder,
            Self::Cone { .. } => SurfaceKind::Cone,
            Self::Sphere { .. } => SurfaceKind::Sphere,
            Self::Torus { .. } => SurfaceKind::Torus,
            Self::Extrusion { .. } => SurfaceKind::Extrusion,
            Self::Revolution { .. } => SurfaceKind::Revolution,
            Self::Nurbs(_) => SurfaceKind::Nurbs,
        }
    }

    /// Whether the whole surface has a border: a side of its domain that is neither a pole nor the same line as the
    /// opposite side. The surface must pass [`check`](Self::check).
    pub(crate) fn has_border(&self) -> bool {
        let (period, domain, poles) = (self.period(), self.natural_domain(), self.poles());
        let is_pole = |axis: usize, at: f64| poles.iter().any(|pole| pole.axis == axis && pole.at == at);
        let ends = |axis: usize| [domain[axis].0, domain[axis].1];
        (0..2).any(|axis| period[axis].is_none() && ends(axis).iter().any(|&at| !is_pole(axis, at)))
    }
}
