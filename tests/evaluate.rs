//! Lattice evaluation against the surface.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "common/bumpy.rs"]
mod bumpy;

use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, TAU};
use trimtess::frame::internals::evaluate::evaluate_points;
use trimtess::frame::internals::lattice::{EvaluateScratch, UNWANTED, evaluate_lattice};
use trimtess::model::{Frame3, NurbsSurface, Surface};
use trimtess::prepare::internals::BezierPatches;

fn bumpy(degree_u: usize, degree_v: usize, rational: bool) -> NurbsSurface {
    let knots = |degree: usize| [vec![0.0; degree + 1], vec![0.6, 1.0], vec![2.0; degree + 1]].concat();
    let uneven = |x: f64, y: f64| 1.0 + 0.4 * (2.1 * x - y).cos();
    let degrees = [degree_u, degree_v];
    bumpy::bumpy(degrees, degrees.map(knots), if rational { Some(&uneven) } else { None })
}

fn lines(a: f64, b: f64, n: usize) -> Vec<f64> {
    (0..=n).map(|i| if i == n { b } else { a + (b - a) * i as f64 / n as f64 }).collect()
}

fn all(patches: &BezierPatches, us: &[f64], vs: &[f64]) -> (Vec<DVec3>, Vec<DVec3>, usize) {
    let (mut p, mut n) = none(us.len() * vs.len());
    let places = places(us.len(), vs.len(), |i, j| (i * vs.len() + j) as u32);
    let lost = evaluate_lattice(patches, us, vs, &places, &mut EvaluateScratch::default(), |k, position, normal| {
        (p[k], n[k]) = (position, normal);
    });
    (p, n, lost)
}

/// The places of the points of a lattice.
fn places(width: usize, height: usize, place: impl Fn(usize, usize) -> u32) -> Vec<u32> {
    (0..width * height).map(|k| place(k % width, k / width)).collect()
}

/// Room for points and normals.
fn none(count: usize) -> (Vec<DVec3>, Vec<DVec3>) {
    (vec![DVec3::NAN; count], vec![DVec3::NAN; count])
}

#[test]
fn lattice_equals_the_surface() {
    for (degree_u, degree_v) in [(1, 1), (2, 1), (1, 3), (3, 3), (2, 5), (6, 4), (27, 2)] {
        for rational in [false, true] {
            let surface = bumpy(degree_u, degree_v, rational);
            let patches = BezierPatches::new(&surface);
            let (us, vs) = (lines(0.0, 2.0, 13), lines(0.1, 1.9, 6));
            let (positions, normals, lost) = all(&patches, &us, &vs);
            assert_eq!((positions.len(), normals.len(), lost), (us.len() * vs.len(), us.len() * vs.len(), 0));
            for (i, &u) in us.iter().enumerate() {
                for (j, &v) in vs.iter().enumerate() {
                    let exact = surface.derivatives(u, v);
                    assert!(positions[i * vs.len() + j].distance(exact.point) < 1e-12);
                    let normal = exact.du.cross(exact.dv).normalize();
                    assert!(normals[i * vs.len() + j].distance(normal) < 1e-11, "({degree_u},{degree_v}) {u} {v}");
                }
            }
        }
    }
}

#[test]
fn a_point_has_the_same_bits_in_any_company() {
    let degrees = [(3, 3, true), (2, 1, true), (1, 2, true), (2, 2, true), (1, 2, false), (1, 1, false), (3, 3, false)];
    for (degree_u, degree_v, rational) in degrees.into_iter().chain([(4, 2, true)]) {
        let patches = BezierPatches::new(&bumpy(degree_u, degree_v, rational));
        let (us, vs) = (lines(0.0, 2.0, 20), lines(0.0, 2.0, 17));
        let (positions, normals, _) = all(&patches, &us, &vs);
        let mut scratch = EvaluateScratch::default();
        // Every third u, every second v, and only a checkerboard of them.
        let wanted = |i: usize, j: usize| (i + j).is_multiple_of(2);
        let (some_u, some_v): (Vec<_>, Vec<_>) =
            (us.iter().copied().step_by(3).collect(), vs.iter().copied().skip(1).step_by(2).collect());
        let (mut p, mut n) = none(some_u.len() * some_v.len());
        let place = |i: usize, j: usize| if wanted(i, j) { (i * some_v.len() + j) as u32 } else { UNWANTED };
        let places = places(some_u.len(), some_v.len(), place);
        evaluate_lattice(&patches, &some_u, &some_v, &places, &mut scratch, |k, position, normal| {
            (p[k], n[k]) = (position, normal);
        });
        let left_out = p.iter().filter(|p| p.is_nan()).count();
        assert_eq!(left_out, p.len() / 2, "only wanted points have a place");
        for i in 0..some_u.len() {
            for j in (0..some_v.len()).filter(|&j| wanted(i, j)) {
                let (here, there) = (i * some_v.len() + j, 3 * i * vs.len() + 2 * j + 1);
                assert_eq!((p[here], n[here]), (positions[there], normals[there]));
            }
        }
        let single: Vec<_> = us.iter().flat_map(|&u| vs.iter().map(move |&v| DVec2::new(u, v))).collect();
        let (mut p, mut n) = none(single.len());
        evaluate_points(&patches, &single, &mut |first, points| {
            (first..).zip(points.iter()).for_each(|(k, point)| (p[k], n[k]) = point);
        });
        assert_eq!((&p, &n), (&positions, &normals));
    }
}

#[test]
fn normals_at_poles_are_limits() {
    let sphere = Surface::Sphere { frame: Frame3::WORLD, radius: 2.0 };
    let (nurbs, _) = sphere.to_nurbs((0.0, TAU), (-FRAC_PI_2, FRAC_PI_2));
    let patches = BezierPatches::new(&nurbs);
    let (us, vs) = (lines(0.0, TAU, 16), lines(-FRAC_PI_2, FRAC_PI_2, 8));
    let (positions, normals, lost) = all(&patches, &us, &vs);
    assert_eq!(lost, 0);
    for (p, n) in positions.iter().zip(&normals) {
        assert!(n.distance(*p / 2.0) < 1e-6, "{p} {n}");
    }
}

#[test]
fn collapsed_nets_are_counted_and_finite() {
    let mut surface = bumpy(3, 2, true);
    surface.points.iter_mut().for_each(|p| *p = DVec3::X * p.x);
    let (positions, normals, lost) = all(&BezierPatches::new(&surface), &lines(0.0, 2.0, 5), &lines(0.0, 2.0, 5));
    assert_eq!(lost, 36);
    assert!(normals.iter().all(|&n| n == DVec3::Z) && positions.iter().all(|p| p.is_finite()));
    surface.points.iter_mut().for_each(|p| *p = DVec3::ONE);
    assert_eq!(all(&BezierPatches::new(&surface), &[0.3], &[0.7]).2, 1);
}
