//! Borders of spline surfaces, and ends of swept curves, that coincide within the file's tolerance -> coincide.
//!
//! Files round each row of control points by itself. A closed surface whose two borders differ would have no period,
//! and a border that is nearly a point would be no pole: the loops on it would be read as those of another face.

use super::spline;
use crate::model::{NurbsCurve3, NurbsSurface};
use glam::DVec3;

/// Borders that are farther apart than this share of the way between them, over the surface, are two: a strip as narrow
/// as the tolerance is not closed.
const NEAR: f64 = 1e-4;
/// Weights within this share of each other are one.
const SAME_WEIGHT: f64 = 1e-9;

/// Moves both ends of a curve to their middle if they are within `tolerance` of each other.
pub(super) fn curve(curve: NurbsCurve3, tolerance: f64) -> NurbsCurve3 {
    let (a, b) = curve.domain();
    let way: f64 = curve.points.windows(2).map(|w| w[0].distance(w[1])).sum();
    let (start, end) = (curve.point(a), curve.point(b));
    if start == end || start.distance(end) > tolerance.min(NEAR * way) {
        return curve;
    }
    let mut curve = if is_clamped(curve.degree, &curve.knots) { curve } else { spline::piece(&curve, a, b) };
    if let [first, .., last] = &mut curve.points[..] {
        let middle = 0.5 * (start + end);
        (*first, *last) = (middle, middle);
    }
    curve
}

/// Moves border rows of a net that are within `tolerance` of a point to that point, and both border rows of a direction
/// within `tolerance` of each other to the row between them. `closed`: directions that the file does not call open.
/// Their rows may also be as far apart as rounding explains. So may the points of a row that closes be from a pole.
pub(super) fn net(mut net: NurbsSurface, closed: [bool; 2], tolerance: f64) -> NurbsSurface {
    let weld = |net: &mut NurbsSurface| {
        // The points of a pole are rounded, too: those of rows that close may be as far apart as the rows were.
        let joined = [0, 1].map(|axis| close(net, axis, closed[axis], tolerance));
        let collapsed = [0, 1].map(|axis| collapse(net, axis, joined[1 - axis], tolerance));
        joined.iter().flatten().any(|gap| *gap > 0.0) || collapsed.contains(&true)
    };
    if is_clamped(net.degree_u, &net.knots_u) && is_clamped(net.degree_v, &net.knots_v) {
        weld(&mut net);
        return net;
    }
    // Its border rows are no rows of control points.
    let (u, v) = net.domain();
    let mut clamped = spline::patch(&net, u, v);
    if weld(&mut clamped) { clamped } else { net }
}

/// Whether a curve starts and ends in its first and last control point.
fn is_clamped(degree: usize, knots: &[f64]) -> bool {
    let last = knots.len() - 1;
    knots[0] == knots[degree] && knots[last] == knots[last - degree]
}

/// Rows of a net across an axis: how many, their length, and where their points are.
struct Rows {
    count: usize,
    length: usize,
    axis: usize,
}

impl Rows {
    fn of(net: &NurbsSurface, axis: usize) -> Self {
        let [count, length] = if axis == 0 { [net.count_u(), net.count_v()] } else { [net.count_v(), net.count_u()] };
        Self { count, length, axis }
    }

    fn at(&self, row: usize, k: usize) -> usize {
        if self.axis == 0 { row * self.length + k } else { k * self.count + row }
    }
}

/// Moves border rows that are nearly points to those points. `joined`: how far apart their ends were, if they close.
fn collapse(net: &mut NurbsSurface, axis: usize, joined: Option<f64>, tolerance: f64) -> bool {
    let rows = Rows::of(net, axis);
    let point = |net: &NurbsSurface, row: usize, k: usize| net.points[rows.at(row, k)];
    let along =
        |row: usize| -> f64 { (1..rows.length).map(|k| point(net, row, k - 1).distance(point(net, row, k))).sum() };
    let most = (0..rows.count).map(along).fold(0.0, f64::max);
    let rounded = joined.map_or(0.0, |gap| gap.max(spline::ROUNDED * most));
    let near = tolerance.max(rounded).min(NEAR * most);
    let mut moved = false;
    for row in [0, rows.count - 1] {
        let first = point(net, row, 0);
        let spread = (1..rows.length).map(|k| point(net, row, k).distance(first)).fold(0.0, f64::max);
        if spread > 0.0 && spread <= near {
            let middle = (0..rows.length).map(|k| point(net, row, k)).sum::<DVec3>() / rows.length as f64;
            (0..rows.length).for_each(|k| net.points[rows.at(row, k)] = middle);
            moved = true;
        }
    }
    moved
}

/// Joins both border rows of a direction, and returns how far apart they were. `None` if they stay apart.
fn close(net: &mut NurbsSurface, axis: usize, closed: bool, tolerance: f64) -> Option<f64> {
    let rows = Rows::of(net, axis);
    let ends = |k: usize| [rows.at(0, k), rows.at(rows.count - 1, k)];
    let gap = |k: usize| {
        let [a, b] = ends(k).map(|at| net.points[at]);
        a.distance(b)
    };
    let way = |k: usize| -> f64 {
        let point = |row: usize| net.points[rows.at(row, k)];
        (1..rows.count).map(|row| point(row - 1).distance(point(row))).sum()
    };
    let most = |of: &dyn Fn(usize) -> f64| (0..rows.length).map(of).fold(0.0, f64::max);
    let weighs_same = |k: usize| {
        let [a, b] = ends(k).map(|at| net.weights.get(at).copied().unwrap_or(1.0));
        (a - b).abs() <= SAME_WEIGHT * a
    };
    let (wide, way) = (most(&gap), most(&way));
    let near = tolerance.max(if closed { spline::ROUNDED * way } else { 0.0 }).min(NEAR * way);
    let closes = wide <= near && (0..rows.length).all(weighs_same);
    if closes && wide > 0.0 {
        for [a, b] in (0..rows.length).map(ends) {
            let middle = 0.5 * (net.points[a] + net.points[b]);
            (net.points[a], net.points[b]) = (middle, middle);
        }
    }
    closes.then_some(wide)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A tube of radius 1 about z from 0 to `height`, with `turn` of a full turn in u, whose last row is moved by
    /// `gap`.
    fn tube(turn: f64, height: f64, gap: f64) -> NurbsSurface {
        let row = |i: u32| {
            let angle = TAU * turn * f64::from(i) / 8.0;
            let off = if i == 8 { gap } else { 0.0 };
            [0.0, height].map(|z| DVec3::new(angle.cos() + off, angle.sin(), z))
        };
        let knots_u = [vec![0.0], (0..9).map(f64::from).collect(), vec![8.0]].concat();
        let points = (0..9).flat_map(row).collect();
        NurbsSurface {
            degree_u: 1,
            degree_v: 1,
            knots_u,
            knots_v: vec![0.0, 0.0, 1.0, 1.0],
            points,
            weights: Vec::new(),
        }
    }

    fn gap_of(surface: NurbsSurface, closed: bool) -> f64 {
        let surface = net(surface, [closed, false], 1e-5);
        surface.points[0].distance(surface.points[16])
    }

    #[test]
    fn rows_within_the_tolerance_are_one() {
        assert_eq!(gap_of(tube(1.0, 3.0, 8e-6), false), 0.0);
        assert!(gap_of(tube(1.0, 3.0, 3e-5), false) > 2e-5);
        assert_eq!(gap_of(tube(1.0, 3.0, 3e-5), true), 0.0, "the file calls it closed");
        assert!(gap_of(tube(1.0, 3.0, 3e-4), true) > 2e-4, "and is wrong");
        let mut unclamped = tube(1.0, 3.0, 8e-6);
        (unclamped.knots_u[0], unclamped.knots_u[10]) = (-1.0, 9.0);
        assert_eq!(gap_of(unclamped, false), 0.0);
        // As wide as the tolerance, but no way leads around it.
        assert!(gap_of(tube(1e-6, 3.0, 0.0), true) > 1e-6);
    }

    fn ends_in_a_point(cone: &NurbsSurface) -> bool {
        cone.points.iter().skip(1).step_by(2).all(|p| *p == cone.points[1])
    }

    #[test]
    fn a_row_within_the_tolerance_of_a_point_is_a_pole() {
        // As far from it as rounding explains, if the row closes.
        for (turn, spread, collapses) in [(1.0, 4e-6, true), (1.0, 2e-5, true), (0.5, 2e-5, false), (1.0, 1e-3, false)]
        {
            let mut cone = tube(turn, 3.0, 0.0);
            for row in cone.points.chunks_mut(2) {
                row[1] = DVec3::new(row[0].x * spread, row[0].y * spread, 3.0);
            }
            assert_eq!(ends_in_a_point(&net(cone, [false; 2], 1e-5)), collapses, "{turn} {spread}");
        }
    }

    #[test]
    fn a_pole_is_one_where_the_surface_is_as_open_as_rounding_explains() {
        for (gap, is_pole) in [(3e-5, true), (3e-4, false)] {
            let mut cone = tube(1.0, 3.0, gap);
            for (i, row) in cone.points.chunks_mut(2).enumerate() {
                row[1] = DVec3::new(if i == 8 { gap } else { 0.0 }, 0.0, 3.0);
            }
            assert_eq!(ends_in_a_point(&net(cone, [true, false], 1e-5)), is_pole, "{gap}");
        }
    }

    #[test]
    fn ends_of_a_curve_within_the_tolerance_are_one() {
        for (off, closes) in [(8e-6, true), (3e-5, false)] {
            let points = tube(1.0, 3.0, off).points.into_iter().step_by(2).collect();
            let knots = tube(1.0, 3.0, off).knots_u;
            let around = curve(NurbsCurve3 { degree: 1, knots, points, weights: Vec::new() }, 1e-5);
            assert_eq!(around.points[0] == around.points[8], closes, "{off}");
        }
    }
}
