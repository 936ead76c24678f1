//! Curves and surfaces of C -> those of the library. Their numbers are checked when a model is finished.

use crate::border::{Caller, versioned};
use crate::limits::{choice, finite};
use crate::status::Failure;
use trimtess::glam::{DVec2, DVec3};
use trimtess::model::{Frame3, NurbsCurve, NurbsSurface, Surface};

/// A NURBS curve. Knots are finite and do not decrease, inner ones repeat at most `degree` times. Weights are above 0.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_curve {
    /// `sizeof(tt_curve)`.
    pub size: u32,
    /// 1 to 60.
    pub degree: u32,
    /// `count + degree + 1` of them, repeated by multiplicity.
    pub knots: *const f64,
    /// `count` control points, not multiplied by weights: 3 numbers each in space, 2 in (u,v).
    pub points: *const f64,
    /// `count` weights from 1e-30 to 1e30, or null for a polynomial curve.
    pub weights: *const f64,
    /// Number of control points.
    pub count: usize,
}
versioned!(tt_curve);

/// Kinds of surfaces. `O` is the origin; x, y and z are the axes of the frame; angles are radians.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum tt_surface_kind {
    /// `S(u,v) = O + u x + v y`; the normal is z.
    TT_PLANE = 0,
    /// `S(u,v) = O + r (cos u x + sin u y) + v z`; the normal points outwards.
    TT_CYLINDER = 1,
    /// `S(u,v) = O + (r + v tan a) (cos u x + sin u y) + v z`, with `a` the half angle.
    TT_CONE = 2,
    /// `S(u,v) = O + r cos v (cos u x + sin u y) + r sin v z`.
    TT_SPHERE = 3,
    /// `S(u,v) = O + (R + r cos v) (cos u x + sin u y) + r sin v z`, with `r` the minor radius.
    TT_TORUS = 4,
    /// `S(u,v) = C(u) + v d`, with `d` the direction.
    TT_EXTRUSION = 5,
    /// `S(u,v)` is `C(v)`, turned by the angle u about z through `O`.
    TT_REVOLUTION = 6,
    /// A B-spline surface, rational or not.
    TT_NURBS = 7,
}

/// The surface of a face. Fields that its kind does not name are not read.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_surface {
    /// `sizeof(tt_surface)`.
    pub size: u32,
    /// A `tt_surface_kind`.
    pub kind: u32,
    /// All kinds but extrusions and B-splines: where the frame is, millimetres.
    pub origin: [f64; 3],
    /// As `origin`: the z axis, of any length above 0.
    pub axis: [f64; 3],
    /// As `origin`: the x axis, or any direction nearest to it. Where it is along z, any perpendicular is taken.
    pub reference: [f64; 3],
    /// Cylinders and spheres: above 0. Cones: at v = 0, 0 or more. Tori: of the ring, R, 0 or more.
    pub radius: f64,
    /// Tori: of the tube, above 0.
    pub minor_radius: f64,
    /// Cones: between -pi/2 and pi/2, not 0.
    pub half_angle: f64,
    /// Extrusions: the sweep per unit of v.
    pub direction: [f64; 3],
    /// Extrusions and revolutions: the curve in space.
    pub curve: *const tt_curve,
    /// B-splines: 1 to 60.
    pub degree_u: u32,
    /// B-splines: 1 to 60.
    pub degree_v: u32,
    /// B-splines: `count_u + degree_u + 1` knots.
    pub knots_u: *const f64,
    /// B-splines: `count_v + degree_v + 1` knots.
    pub knots_v: *const f64,
    /// B-splines: `count_u * count_v` control points of 3 numbers. Point (i, j) is number `i * count_v + j`.
    pub points: *const f64,
    /// B-splines: weights in the same order, from 1e-30 to 1e30, or null.
    pub weights: *const f64,
    /// B-splines: number of control points along u.
    pub count_u: usize,
    /// B-splines: number of control points along v.
    pub count_v: usize,
}
versioned!(tt_surface);

/// A frame from an origin, a z axis, and a direction near its x axis.
pub(crate) fn frame(origin: [f64; 3], axis: [f64; 3], reference: [f64; 3]) -> Result<Frame3, Failure> {
    let [origin, axis] = [finite("origin", origin)?, finite("axis", axis)?].map(DVec3::from);
    let reference = DVec3::from(finite("reference", reference)?);
    Frame3::from_axis(origin, axis, reference).ok_or_else(|| Failure::argument("axis has no direction"))
}

/// `a + b + 1`, if there is such a number.
fn knots(count: usize, degree: u32) -> Result<usize, Failure> {
    let knots = count.checked_add(degree as usize).and_then(|sum| sum.checked_add(1));
    knots.ok_or_else(|| Failure::argument(format!("{count} control points do not fit into memory")))
}

fn product(a: usize, b: usize) -> Result<usize, Failure> {
    a.checked_mul(b).ok_or_else(|| Failure::argument(format!("{a} times {b} numbers do not fit into memory")))
}

/// Weights, none if null.
fn weights(c: &Caller, weights: *const f64, count: usize) -> Result<Vec<f64>, Failure> {
    let count = if weights.is_null() { 0 } else { count };
    c.slice("weights", weights, count).map(<[f64]>::to_vec)
}

/// A curve with `N` numbers per point.
pub(crate) fn curve<const N: usize, P: From<[f64; N]>>(
    c: &Caller,
    from: *const tt_curve,
) -> Result<NurbsCurve<P>, Failure> {
    let from = c.read("curve", from)?;
    let (numbers, _) = c.slice("curve.points", from.points, product(from.count, N)?)?.as_chunks::<N>();
    Ok(NurbsCurve {
        degree: from.degree as usize,
        knots: c.slice("curve.knots", from.knots, knots(from.count, from.degree)?)?.to_vec(),
        points: numbers.iter().map(|&point| point.into()).collect(),
        weights: weights(c, from.weights, from.count)?,
    })
}

fn nurbs(c: &Caller, from: &tt_surface) -> Result<NurbsSurface, Failure> {
    let count = product(from.count_u, from.count_v)?;
    let (numbers, _) = c.slice("surface.points", from.points, product(count, 3)?)?.as_chunks::<3>();
    Ok(NurbsSurface {
        degree_u: from.degree_u as usize,
        degree_v: from.degree_v as usize,
        knots_u: c.slice("surface.knots_u", from.knots_u, knots(from.count_u, from.degree_u)?)?.to_vec(),
        knots_v: c.slice("surface.knots_v", from.knots_v, knots(from.count_v, from.degree_v)?)?.to_vec(),
        points: numbers.iter().copied().map(DVec3::from).collect(),
        weights: weights(c, from.weights, count)?,
    })
}

/// The surface of a face.
pub(crate) fn surface(c: &Caller, from: *const tt_surface) -> Result<Surface, Failure> {
    let from = c.read("surface", from)?;
    let frame = || frame(from.origin, from.axis, from.reference);
    let curve = || curve::<3, DVec3>(c, from.curve);
    let (radius, minor, direction) = (from.radius, from.minor_radius, from.direction.into());
    Ok(choice!("kind of surface", from.kind, tt_surface_kind {
        TT_PLANE => Surface::Plane { frame: frame()? },
        TT_CYLINDER => Surface::Cylinder { frame: frame()?, radius },
        TT_CONE => Surface::Cone { frame: frame()?, radius, half_angle: from.half_angle },
        TT_SPHERE => Surface::Sphere { frame: frame()?, radius },
        TT_TORUS => Surface::Torus { frame: frame()?, major: radius, minor },
        TT_EXTRUSION => Surface::Extrusion { curve: curve()?, direction },
        TT_REVOLUTION => Surface::Revolution { curve: curve()?, frame: frame()? },
        TT_NURBS => Surface::Nurbs(nurbs(c, &from)?),
    }))
}

/// Points in (u,v), 2 numbers each.
pub(crate) fn points_in_plane(c: &Caller, points: *const f64, count: usize) -> Result<Vec<DVec2>, Failure> {
    let (numbers, _) = c.slice("points", points, product(count, 2)?)?.as_chunks::<2>();
    Ok(numbers.iter().copied().map(DVec2::from).collect())
}
