//! Bézier pieces against the NURBS that they are cut from.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "common/bumpy.rs"]
mod bumpy;

use glam::DVec3;
use std::f64::consts::TAU;
use trimtess::model::{Frame3, NurbsCurve3, NurbsSurface, Surface};
use trimtess::prepare::internals::{BezierPatches, BezierSpline3};

fn curve(degree: usize, knots: Vec<f64>, rational: bool) -> NurbsCurve3 {
    let count = knots.len() - degree - 1;
    let at = |i: usize| i as f64;
    let points = (0..count).map(|i| DVec3::new(at(i), (1.3 * at(i)).sin(), (0.7 * at(i)).cos())).collect();
    let weights = if rational { (0..count).map(|i| 1.2 + (2.0 * at(i)).sin()).collect() } else { Vec::new() };
    NurbsCurve3 { degree, knots, points, weights }
}

fn curves() -> Vec<NurbsCurve3> {
    let uneven = vec![0.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.7, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0];
    let open = vec![-1.0, 0.0, 0.3, 0.9, 1.0, 1.7, 2.0, 3.0, 3.5];
    vec![
        curve(3, uneven.clone(), false),
        curve(3, uneven, true),
        curve(2, open.clone(), true),
        curve(3, open, false),
        curve(1, vec![0.0, 0.0, 1.0, 4.0, 4.0], false),
        NurbsCurve3::arc(&Frame3::WORLD, 2.0, 1.0, 0.0, TAU),
    ]
}

#[test]
fn segments_equal_the_curve() {
    for curve in curves() {
        let (a, b) = curve.domain();
        for range in [(a, b), (a + 0.13 * (b - a), a + 0.91 * (b - a)), (a + 0.4 * (b - a), a + 0.41 * (b - a))] {
            let spline = BezierSpline3::new(&curve, range);
            assert_eq!(spline.range(), range);
            for i in 0..=200 {
                let t = range.0 + (range.1 - range.0) * i as f64 / 200.0;
                let (exact, found) = (curve.derivatives(t), spline.derivatives(t));
                assert!(found.point.distance(exact.point) < 1e-13 && spline.point(t).distance(exact.point) < 1e-13);
                if curve.knots.iter().all(|k| (k - t).abs() > 1e-9) {
                    assert!(found.d1.distance(exact.d1) < 1e-11 * (1.0 + exact.d1.length()));
                    assert!(found.d2.distance(exact.d2) < 1e-9 * (1.0 + exact.d2.length()));
                }
            }
        }
    }
}

#[test]
fn neighbours_share_their_joint_bit_for_bit() {
    for curve in curves() {
        let spline = BezierSpline3::new(&curve, curve.domain());
        for i in 1..spline.segments() {
            assert_eq!(spline.segment(i - 1).last(), spline.segment(i).first());
            let joint = spline.segment(i)[0];
            assert_eq!(spline.point(spline.breaks[i]), joint.truncate() / joint.w);
        }
    }
}

fn surfaces() -> Vec<NurbsSurface> {
    let (knots_u, knots_v) =
        (vec![0.0, 0.0, 0.0, 0.0, 0.7, 1.1, 1.1, 2.0, 2.0, 2.0, 2.0], vec![-1.0, -0.8, -0.5, 0.0, 0.7, 1.0, 1.5, 2.0]);
    let uneven = |x: f64, y: f64| 1.0 + 0.5 * (2.1 * x - y).cos();
    let rational = bumpy::bumpy([3, 2], [knots_u, knots_v], Some(&uneven));
    let plain = NurbsSurface { weights: Vec::new(), ..rational.clone() };
    let even = NurbsSurface { weights: vec![0.25; 35], ..plain.clone() };
    let torus = Surface::Torus { frame: Frame3::WORLD, major: 3.0, minor: 1.0 };
    vec![rational, plain, even, torus.to_nurbs((0.0, TAU), (0.0, 4.0)).0]
}

#[test]
fn patches_equal_the_surface() {
    for surface in surfaces() {
        let patches = BezierPatches::new(&surface);
        assert_eq!(patches.rational, surface.weights.windows(2).any(|w| w[0] != w[1]));
        let ((u0, u1), (v0, v1)) = surface.domain();
        for i in 0..=30 {
            for j in 0..=30 {
                let (u, v) = (u0 + (u1 - u0) * i as f64 / 30.0, v0 + (v1 - v0) * j as f64 / 30.0);
                let (exact, found) = (surface.derivatives(u, v), patches.derivatives(u, v));
                assert_eq!(patches.point(u, v), found.point);
                assert!(found.point.distance(exact.point) < 1e-13);
                let near = |k: &f64, t: f64| (k - t).abs() < 1e-9;
                if surface.knots_u.iter().any(|k| near(k, u)) || surface.knots_v.iter().any(|k| near(k, v)) {
                    continue;
                }
                for (a, b) in [
                    (found.du, exact.du),
                    (found.dv, exact.dv),
                    (found.duu, exact.duu),
                    (found.duv, exact.duv),
                    (found.dvv, exact.dvv),
                ] {
                    assert!(a.distance(b) < 1e-10 * (1.0 + b.length()), "{u} {v}: {a} {b}");
                }
            }
        }
        let part = BezierPatches::over(&surface, (u0 + 0.1, u1 - 0.3), (v0 + 0.2, v1 - 0.1));
        assert!(part.derivatives(u0 + 0.4, v0 + 0.5).point.distance(surface.point(u0 + 0.4, v0 + 0.5)) < 1e-13);
        assert_eq!(part.breaks_u[0], u0 + 0.1);
    }
}

#[test]
fn neighbouring_patches_share_their_border_bit_for_bit() {
    for surface in surfaces() {
        let patches = BezierPatches::new(&surface);
        let (nu, nv) = patches.counts();
        let (p, q) = (patches.degree_u, patches.degree_v);
        for i in 0..nu {
            for j in 0..nv {
                for b in (0..=q).filter(|_| i > 0) {
                    assert_eq!(patches.patch(i, j)[b], patches.patch(i - 1, j)[p * (q + 1) + b]);
                }
                for a in (0..=p).filter(|_| j > 0) {
                    assert_eq!(patches.patch(i, j)[a * (q + 1)], patches.patch(i, j - 1)[a * (q + 1) + q]);
                }
            }
        }
    }
}

#[test]
fn iso_curves_lie_on_the_surface() {
    for surface in surfaces() {
        let patches = BezierPatches::new(&surface);
        let (u, v) = surface.domain();
        for (axis, (a, b), (c, d)) in [(0, u, v), (1, v, u)] {
            for at in [a, a + 0.37 * (b - a), b] {
                for range in [(c, d), (c + 0.11 * (d - c), c + 0.77 * (d - c))] {
                    let iso = patches.iso_curve(axis, at, range);
                    assert_eq!(iso.range(), range);
                    for i in 0..=100 {
                        let t = range.0 + (range.1 - range.0) * i as f64 / 100.0;
                        let exact = if axis == 0 { surface.point(at, t) } else { surface.point(t, at) };
                        assert!(iso.point(t).distance(exact) < 1e-13, "axis {axis} at {at} {t}");
                    }
                }
            }
        }
    }
}
