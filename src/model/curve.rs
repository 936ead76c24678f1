//! NURBS curves in space and in a surface's parameter plane.

use glam::{DVec2, DVec3};

/// A NURBS curve. `P` is [`DVec3`] for curves in space, [`DVec2`] for pcurves.
///
/// `degree ≥ 1`; `knots.len() == points.len() + degree + 1`, finite, non-decreasing, interior multiplicity ≤ degree
/// (clamped or not); `weights` is empty (all 1) or one positive number per control point.
/// Domain: `[knots[degree], knots[points.len()]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsCurve<P> {
    /// Polynomial degree.
    pub degree: usize,
    /// Knot vector with multiplicities written out.
    pub knots: Vec<f64>,
    /// Control points (Euclidean, not multiplied by weights).
    pub points: Vec<P>,
    /// Weights, or empty for a polynomial curve.
    pub weights: Vec<f64>,
}

/// A curve in space.
pub type NurbsCurve3 = NurbsCurve<DVec3>;
/// A curve in a surface's parameter plane.
pub type NurbsCurve2 = NurbsCurve<DVec2>;
