//! Intersections of trimming curves, against closed forms and against implicitisation and generalised eigenvalues
//! (Manocha & Demmel, "Algorithms for intersecting parametric and algebraic curves", ACM TOG 13(1), 1994).

#[path = "../../../../tests/implicit/mod.rs"]
mod implicit;

use super::*;
use crate::control::{Alone, Control};
use crate::model::{NurbsCurve2, TrimCurve, TrimPiece};
use crate::prepare::trims::spans::UvDomain;
use crate::sequence::random::SplitMix;
use implicit::by_eigenvalues;
use std::f64::consts::TAU;

/// A point that two curves, or two places on one curve, have in common.
#[derive(Debug)]
struct CurveMeeting {
    curves: [usize; 2],
    uv: DVec2,
    /// Whether both have one tangent there.
    is_parallel: bool,
}

fn point(curve: &TrimCurve, piece: usize, t: f64) -> DVec2 {
    match &curve.pieces[piece] {
        TrimPiece::Nurbs(nurbs) => nurbs.point(t),
        TrimPiece::Polyline(points) => {
            let k = (t.floor() as usize).min(points.len() - 2);
            points[k].lerp(points[k + 1], t - k as f64)
        }
    }
}

/// All meetings, one for each pair of curves and point; asserts that each lies on both curves.
fn met(curves: &[TrimCurve]) -> Vec<CurveMeeting> {
    let chains: Vec<SpanChain> =
        curves.iter().map(|curve| SpanChain::of(curve, &UvDomain::new(DVec2::ZERO, DVec2::ONE))).collect();
    let control = Control::default();
    let mut found: Vec<CurveMeeting> = Vec::new();
    for m in meetings(Call::new(&Alone, &control), &chains.iter().collect::<Vec<_>>()) {
        let spans = m.at.map(|p| &chains[p.chain].spans[p.span]);
        for (place, span) in m.at.iter().zip(spans) {
            let p = point(&curves[place.chain], span.piece, span.parameter(place.s));
            assert!(p.distance(m.point) <= 2e-9, "{m:?}: {p}");
        }
        let is_parallel = sine(spans[0], spans[1], m.at.map(|p| p.s)) <= 1e-6;
        let curves = m.at.map(|p| p.chain);
        if found.iter().all(|k| k.curves != curves || k.uv.distance(m.point) > SAME) {
            found.push(CurveMeeting { curves, uv: m.point, is_parallel });
        }
    }
    found
}

/// Numbers of crossings, and of places with one tangent.
fn kinds(found: &[CurveMeeting]) -> [usize; 2] {
    [false, true].map(|parallel| found.iter().filter(|m| m.is_parallel == parallel).count())
}

fn circle(x: f64, y: f64, r: f64) -> TrimCurve {
    TrimCurve::circle(DVec2::new(x, y), r)
}

#[test]
fn circles_meet_where_they_must() {
    for k in 0..100 {
        let turn = TAU * f64::from(k) / 100.0;
        let step = DVec2::from_angle(turn);
        let (a, r) = (DVec2::splat(0.5), 0.2);
        for d in [1e-3, 0.05, 0.2, 0.35, 0.399, 0.399_999_9] {
            let b = a + step * d;
            let found = met(&[TrimCurve::circle(a, r), TrimCurve::circle(b, r)]);
            assert_eq!(kinds(&found), [2, 0], "{k} {d}");
            let reach = (r * r - 0.25 * d * d).sqrt();
            for side in [1.0, -1.0] {
                let want = a + step * (0.5 * d) + step.perp() * (side * reach);
                let near = found.iter().map(|m| m.uv.distance(want)).fold(f64::INFINITY, f64::min);
                assert!(near <= 1e-9, "{k} {d}: {near:e}");
            }
        }
        assert!(met(&[TrimCurve::circle(a, r), TrimCurve::circle(a + step * 0.401, r)]).is_empty());
        assert!(met(&[TrimCurve::circle(a, r), TrimCurve::circle(a, 0.15)]).is_empty());
    }
}

#[test]
fn touching_circles_meet_once() {
    for k in 0..100 {
        let step = DVec2::from_angle(TAU * f64::from(k) / 100.0 + 0.01);
        let a = DVec2::splat(0.5);
        for (d, r) in [(0.3, 0.1), (0.1, 0.1), (0.19, 0.01), (0.35, 0.15)] {
            let found = met(&[TrimCurve::circle(a, 0.2), TrimCurve::circle(a + step * d, r)]);
            assert_eq!(kinds(&found), [0, 1], "{k} {d} {r}: {found:?}");
            // Touching curves are within a billionth of each other over a stretch as long as its square root.
            assert!(found[0].uv.distance(a + step * 0.2) <= 1e-5, "{found:?}");
        }
    }
}

#[test]
fn common_stretches_end_in_two_points() {
    let arc = |from: f64, to: f64| {
        let half = 0.5 * (to - from);
        let at = |t: f64, r: f64| DVec2::splat(0.5) + DVec2::from_angle(t) * r;
        let points = vec![at(from, 0.3), at(from + half, 0.3 / half.cos()), at(to, 0.3)];
        TrimCurve::bezier(points, vec![1.0, half.cos(), 1.0])
    };
    for (b0, b1) in [(0.6, 1.9), (1.9, 0.6), (0.9, 1.0), (0.1, 1.3)] {
        let (a, b) = (arc(0.2, 1.5), arc(b0, b1));
        let found = met(&[a, b]);
        assert_eq!(kinds(&found), [0, 2], "{b0} {b1}: {found:?}");
    }
    // The same line, stated with another degree.
    let line = TrimCurve::polyline(vec![DVec2::new(0.1, 0.2), DVec2::new(0.9, 0.6)]);
    let p = |s: f64| DVec2::new(0.1, 0.2).lerp(DVec2::new(0.9, 0.6), s);
    let cubic = TrimCurve::bezier(vec![p(0.3), p(0.35), p(0.6), p(0.7)], Vec::new());
    assert_eq!(kinds(&met(&[line, cubic])), [0, 2]);
}

#[test]
fn ends_on_curves_and_crossings_at_joints_are_found_once() {
    // A line that ends on a circle, at a joint of its quarters and elsewhere.
    for angle in [0.0, 0.3, TAU / 4.0, 2.0] {
        let a = DVec2::splat(0.5);
        let way = DVec2::from_angle(angle);
        let ends = TrimCurve::polyline(vec![a + way * 0.2, a + way * 0.45]);
        assert_eq!(kinds(&met(&[circle(0.5, 0.5, 0.2), ends])), [1, 0], "{angle}");
        let through = TrimCurve::polyline(vec![a, a + way * 0.45]);
        assert_eq!(kinds(&met(&[circle(0.5, 0.5, 0.2), through])), [1, 0], "{angle}");
    }
}

#[test]
fn curves_meet_themselves_at_loops_only() {
    let p = DVec2::new;
    let looped = TrimCurve::bezier(vec![p(0.1, 0.1), p(1.3, 0.9), p(-0.3, 0.9), p(0.9, 0.1)], Vec::new());
    let found = met(&[looped]);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!((found[0].uv.x - 0.5).abs() <= 1e-9, "symmetric about its middle: {found:?}");
    let simple = TrimCurve::bezier(vec![p(0.1, 0.1), p(0.4, 0.9), p(0.6, 0.9), p(0.9, 0.1)], Vec::new());
    assert!(met(&[simple]).is_empty());
    assert!(met(&[circle(0.5, 0.5, 0.3)]).is_empty());
    let eight = TrimCurve::polygon(vec![p(0.2, 0.2), p(0.8, 0.8), p(0.8, 0.2), p(0.2, 0.8)]);
    assert_eq!(kinds(&met(&[eight])), [1, 0]);
}

// --- implicitisation and eigenvalues

impl SplitMix {
    fn bezier(&mut self, degree: usize, rational: bool) -> NurbsCurve2 {
        let points = (0..=degree).map(|_| DVec2::new(self.unit(), self.unit())).collect();
        let weights = if rational { (0..=degree).map(|_| 0.5 + self.unit()).collect() } else { Vec::new() };
        NurbsCurve2::bezier(points, weights)
    }
}

/// `(w x, w y, w)` of the control points.
fn homogeneous(curve: &NurbsCurve2) -> Vec<DVec3> {
    let weight = |i: usize| curve.weights.get(i).copied().unwrap_or(1.0);
    curve.points.iter().enumerate().map(|(i, &p)| (p * weight(i)).extend(weight(i))).collect()
}

#[test]
fn random_bezier_curves_meet_where_eigenvalues_say() {
    let mut draw = SplitMix(7);
    let mut points = 0;
    for degree_a in 2..=5 {
        for degree_b in 2..=5 {
            for k in 0..100 {
                let (a, b) = (draw.bezier(degree_a, k % 2 == 1), draw.bezier(degree_b, k % 3 == 1));
                let found = met(&[TrimCurve::nurbs(a.clone()), TrimCurve::nurbs(b.clone())]);
                let found: Vec<_> = found.into_iter().filter(|m| m.curves[0] != m.curves[1]).collect();
                let other = by_eigenvalues(&homogeneous(&a), &homogeneous(&b));
                let case = format!("{degree_a} {degree_b} {k}: {found:?}\n{other:?}");
                for [t, s] in &other {
                    let p = a.point(*t).midpoint(b.point(*s));
                    assert!(found.iter().any(|m| m.uv.distance(p) <= 1e-6), "missed {p} of {case}");
                }
                for m in &found {
                    assert!(other.iter().any(|[t, _]| a.point(*t).distance(m.uv) <= 1e-6), "spurious {m:?} in {case}");
                }
                points += found.len();
            }
        }
    }
    assert!(points > 1000, "{points}");
}
