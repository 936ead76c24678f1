//! Arcs of hyperbolas and parabolas -> exact quadratic B-splines. Classical construction: end points, and the
//! intersection of the end tangents, weighted with the hyperbolic cosine of half the span (1 for the parabola).

use crate::model::NurbsCurve3;
use glam::DVec3;

/// Maximum number of spans of a hyperbolic arc. Files need one or two; a hostile one could ask for any number.
const MAX_SPANS: f64 = 64.0;

/// `C + x cosh t + y sinh t` for `t0 < t < t1`. Knots are values of t; spans are equal and at most 1 long, up to 64
/// spans.
pub(super) fn hyperbolic_arc(centre: DVec3, x: DVec3, y: DVec3, (t0, t1): (f64, f64)) -> NurbsCurve3 {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 1 and 64")]
    let spans = ((t1 - t0).ceil().clamp(1.0, MAX_SPANS) as usize).max(1);
    let step = (t1 - t0) / spans as f64;
    let weight = libm::cosh(0.5 * step);
    let at = |t: f64| x * libm::cosh(t) + y * libm::sinh(t);
    let mut curve = NurbsCurve3 { degree: 2, knots: vec![t0; 3], points: vec![centre + at(t0)], weights: vec![1.0] };
    for span in 0..spans {
        let from = t0 + step * span as f64;
        let to = if span + 1 == spans { t1 } else { from + step };
        curve.points.extend([centre + at(0.5 * (from + to)) / weight, centre + at(to)]);
        curve.weights.extend([weight, 1.0]);
        curve.knots.extend([to, to]);
    }
    curve.knots.push(t1);
    curve
}

/// `C + x t² + 2 y t` for `t0 < t < t1`, as a polynomial curve.
pub(super) fn parabolic_arc(centre: DVec3, x: DVec3, y: DVec3, (t0, t1): (f64, f64)) -> NurbsCurve3 {
    let at = |t: f64| centre + x * (t * t) + y * (2.0 * t);
    NurbsCurve3 {
        degree: 2,
        knots: vec![t0, t0, t0, t1, t1, t1],
        points: vec![at(t0), centre + x * (t0 * t1) + y * (t0 + t1), at(t1)],
        weights: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arcs_lie_on_their_conics() {
        let c = DVec3::new(1.0, -2.0, 0.5);
        let hyperbola = hyperbolic_arc(c, DVec3::X * 3.0, DVec3::Y * 2.0, (-1.7, 2.4));
        let parabola = parabolic_arc(c, DVec3::X * 3.0, DVec3::Y * 3.0, (-2.0, 1.5));
        for i in 0..=40 {
            let s = f64::from(i) / 40.0;
            let p = hyperbola.point(-1.7 + 4.1 * s) - c;
            assert!(((p.x / 3.0).powi(2) - (p.y / 2.0).powi(2) - 1.0).abs() < 1e-11, "{p}");
            let q = parabola.point(-2.0 + 3.5 * s) - c;
            assert!((q.x / 3.0 - (q.y / 6.0).powi(2)).abs() < 1e-12, "{q}");
        }
        assert!((hyperbola.point(2.4) - c).distance(DVec3::new(3.0 * 2.4f64.cosh(), 2.0 * 2.4f64.sinh(), 0.0)) < 1e-12);
    }
}
