//! NURBS curves against closed forms and finite differences.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "sequence/random.rs"]
mod random;

use glam::{DVec2, DVec3};
use random::SplitMix;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use trimtess::model::{Frame3, NurbsCurve, NurbsCurve2, NurbsCurve3};

/// A wavy curve of the given degree with uneven knots, clamped or not.
fn wavy(degree: usize, spans: usize, rational: bool, clamped: bool, noise: &mut SplitMix) -> NurbsCurve3 {
    let count = degree + spans;
    let mut knots = Vec::new();
    let mut t = -1.0;
    for i in 0..count + degree + 1 {
        if !clamped || (i > degree && i <= count) {
            t += 0.2 + noise.unit();
        }
        knots.push(t);
    }
    let points = (0..count).map(|i| DVec3::new(i as f64, noise.unit() * 3.0, noise.unit() * 3.0)).collect();
    let weights = if rational { (0..count).map(|_| 0.5 + 1.5 * noise.unit()).collect() } else { Vec::new() };
    NurbsCurve { degree, knots, points, weights }
}

#[test]
fn derivatives_match_finite_differences() {
    let mut noise = SplitMix(7);
    for degree in [1, 2, 3, 5, 9, 25, 27] {
        for (rational, clamped) in [(false, true), (true, true), (true, false)] {
            let curve = wavy(degree, 4, rational, clamped, &mut noise);
            let (a, b) = curve.domain();
            for i in 0..40 {
                let t = a + (b - a) * (i as f64 + 0.37) / 40.0;
                let h = 1e-5;
                if curve.knots.iter().any(|k| (k - t).abs() < 3.0 * h) {
                    continue;
                }
                let (l, m, r) = (curve.point(t - h), curve.derivatives(t), curve.point(t + h));
                assert!(m.d1.distance((r - l) / (2.0 * h)) < 1e-6 * (1.0 + m.d1.length()), "degree {degree} at {t}");
                let second = (curve.derivatives(t + h).d1 - curve.derivatives(t - h).d1) / (2.0 * h);
                assert!(m.d2.distance(second) < 1e-5 * (1.0 + m.d2.length()), "degree {degree} at {t}");
            }
        }
    }
}

#[test]
fn bezier_of_a_monomial_is_that_monomial() {
    // t^4 in Bernstein form has the single coefficient 1 at the end.
    let mut points = vec![DVec2::ZERO; 5];
    points[4] = DVec2::new(1.0, 2.0);
    let knots = [vec![0.0; 5], vec![1.0; 5]].concat();
    let curve = NurbsCurve2 { degree: 4, knots, points, weights: Vec::new() };
    let d = curve.derivatives(0.7);
    assert!((d.point.x - 0.7_f64.powi(4)).abs() < 1e-15);
    assert!((d.d1.y - 8.0 * 0.7_f64.powi(3)).abs() < 1e-14);
    assert!((d.d2.x - 12.0 * 0.49).abs() < 1e-14);
}

#[test]
fn outside_the_domain_means_its_end() {
    let curve = wavy(3, 5, true, true, &mut SplitMix(3));
    let (a, b) = curve.domain();
    assert_eq!(curve.point(a - 1.0), curve.point(a));
    assert_eq!(curve.point(b + 1.0), curve.point(b));
    assert!(curve.point(b).distance(*curve.points.last().unwrap()) < 1e-14);
}

#[test]
fn reversal_keeps_the_points() {
    for clamped in [true, false] {
        let curve = wavy(4, 6, true, clamped, &mut SplitMix(11));
        let back = curve.reversed();
        let (a, b) = curve.domain();
        assert_eq!(back.domain(), (a, b));
        for i in 0..=20 {
            let t = a + (b - a) * i as f64 / 20.0;
            assert!(back.point(a + b - t).distance(curve.point(t)) < 1e-12);
        }
        assert!(back.reversed().point(0.3 * a + 0.7 * b).distance(curve.point(0.3 * a + 0.7 * b)) < 1e-12);
    }
}

#[test]
fn arcs_are_exact_and_meet_their_angles() {
    let frame = Frame3::from_axis(DVec3::new(1.0, 2.0, 3.0), DVec3::new(1.0, 1.0, 2.0), DVec3::X).unwrap();
    for (a0, a1, spans) in [(0.0, TAU, 4), (-1.0, 0.2, 1), (0.5, 0.5 + FRAC_PI_2, 1), (2.0, 2.0 + PI, 2), (-PI, 4.0, 5)]
    {
        let arc = NurbsCurve3::arc(&frame, 3.0, 2.0, a0, a1);
        assert_eq!(arc.points.len(), 2 * spans + 1);
        assert_eq!(arc.domain(), (a0, a1));
        for i in 0..=64 {
            let t = a0 + (a1 - a0) * i as f64 / 64.0;
            let local = frame.local(arc.point(t));
            assert!(((local.x / 3.0).powi(2) + (local.y / 2.0).powi(2) - 1.0).abs() < 1e-14);
            assert!(local.z.abs() < 1e-14);
        }
        for i in 0..=spans {
            let angle = a0 + (a1 - a0) * i as f64 / spans as f64;
            let expected = frame.place(DVec3::new(3.0 * angle.cos(), 2.0 * angle.sin(), 0.0));
            assert!(arc.point(angle).distance(expected) < 1e-14);
        }
        assert!(arc.kinks().is_empty(), "arc joints are smooth");
    }
    let circle = NurbsCurve3::arc(&frame, 3.0, 3.0, 0.0, TAU);
    assert_eq!(circle.points.first(), circle.points.last());
}

#[test]
fn kinks_are_found_where_the_direction_breaks() {
    let corner = |y: f64| NurbsCurve3 {
        degree: 2,
        knots: vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0],
        points: [(0.0, 0.0), (1.0, 1.0), (2.0, 0.0), (3.0, y), (4.0, 0.0)].map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec(),
        weights: Vec::new(),
    };
    assert_eq!(corner(1.0).kinks(), vec![1.0]);
    assert!(corner(-1.0).kinks().is_empty());
    assert!(corner(-1.0 + 1e-7).kinks().is_empty());
    assert_eq!(corner(-1.0 + 1e-4).kinks(), vec![1.0]);
    // A polyline bends at every inner knot that is not collinear with its neighbours.
    let polyline = NurbsCurve3 {
        degree: 1,
        knots: vec![0.0, 0.0, 1.0, 2.0, 3.0, 3.0],
        points: vec![DVec3::ZERO, DVec3::X, 2.0 * DVec3::X, DVec3::ONE],
        weights: Vec::new(),
    };
    assert_eq!(polyline.kinks(), vec![2.0]);
    // A control point that coincides with the joint hides the tangent, not the corner.
    let mut stalled = corner(1.0);
    stalled.points[3] = stalled.points[2];
    assert_eq!(stalled.kinks(), vec![1.0]);
}
