//! Bounds against dense sampling: never too low, and not far too high.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "common/bumpy.rs"]
mod bumpy;
#[path = "sequence/random.rs"]
mod random;

use glam::DVec3;
use random::SplitMix;
use std::f64::consts::{FRAC_PI_2, TAU};
use trimtess::math::bounds::{NetBounds, patch_bounds};
use trimtess::model::{Frame3, NurbsCurve3, NurbsSurface, Surface};
use trimtess::prepare::internals::{Bend, BezierPatches, BezierSpline3, BoxBounds, CurveBounds, SurfaceBounds};

fn bumpy(degree_u: usize, degree_v: usize, weight: f64) -> NurbsSurface {
    let knots = |degree: usize| [vec![0.0; degree + 1], vec![0.8], vec![2.0; degree + 1]].concat();
    let degrees = [degree_u, degree_v];
    let uneven = |x: f64, y: f64| weight.powf((2.1 * x - 1.3 * y).cos());
    bumpy::bumpy(degrees, degrees.map(knots), if weight == 1.0 { None } else { Some(&uneven) })
}

/// Name, surface, and the largest allowed ratio of bound to sampled supremum, for first and second derivatives.
fn cases() -> Vec<(&'static str, NurbsSurface, f64)> {
    let frame = Frame3::from_axis(DVec3::new(40.0, -20.0, 70.0), DVec3::new(1.0, 2.0, 3.0), DVec3::Y).unwrap();
    let turn = (0.0, TAU);
    let cut = |s: Surface, u, v| s.to_nurbs(u, v).0;
    vec![
        ("cylinder", cut(Surface::Cylinder { frame, radius: 2.0 }, turn, (0.0, 30.0)), 1.01),
        ("cone", cut(Surface::Cone { frame, radius: 2.0, half_angle: 0.5 }, turn, (0.0, 3.0)), 1.01),
        ("sphere", cut(Surface::Sphere { frame, radius: 2.0 }, turn, (-FRAC_PI_2, FRAC_PI_2)), 1.05),
        ("torus", cut(Surface::Torus { frame, major: 5.0, minor: 1.0 }, turn, turn), 1.05),
        ("bilinear", bumpy(1, 1, 1.0), 1.001),
        ("bicubic", bumpy(3, 3, 1.0), 1.02),
        ("mixed", bumpy(2, 5, 1.0), 1.03),
        ("rational bilinear", bumpy(1, 1, 1.3), 1.15),
        ("rational bicubic .8-1.25", bumpy(3, 3, 1.25), 1.05),
        ("rational bicubic .5-2", bumpy(3, 3, 2.0), 1.15),
        ("rational mixed", bumpy(4, 2, 1.25), 1.06),
    ]
}

/// Suprema of the derivatives over a box by sampling, in the order uu, uv, vv, u, v.
fn sampled(patches: &BezierPatches, u: (f64, f64), v: (f64, f64)) -> [f64; 5] {
    let mut most = [0.0_f64; 5];
    let at = |(a, b): (f64, f64), i: usize| a + (b - a) * (1e-9 + (1.0 - 2e-9) * i as f64 / 24.0);
    for i in 0..=24 {
        for j in 0..=24 {
            let d = patches.derivatives(at(u, i), at(v, j));
            for (m, x) in most.iter_mut().zip([d.duu, d.duv, d.dvv, d.du, d.dv]) {
                *m = m.max(x.length());
            }
        }
    }
    most
}

/// The turn of the normal along a straight path in parameters, by 200 steps.
fn turning(patches: &BezierPatches, from: (f64, f64), to: (f64, f64)) -> f64 {
    let normal = |k: usize| {
        let s = 1e-5 + (1.0 - 2e-5) * k as f64 / 200.0;
        let d = patches.derivatives(from.0 + (to.0 - from.0) * s, from.1 + (to.1 - from.1) * s);
        d.du.cross(d.dv).normalize()
    };
    (0..200).map(|k| 2.0 * (0.5 * normal(k).distance(normal(k + 1))).asin()).sum()
}

fn list(b: &BoxBounds) -> [f64; 5] {
    [b.uu.norm, b.uv.norm, b.vv.norm, b.u, b.v]
}

/// The sub-boxes of a table: ends in u and in v, and bounds.
fn cells(bounds: &SurfaceBounds) -> impl Iterator<Item = ((f64, f64), (f64, f64), &BoxBounds)> {
    let ends = |breaks: &[f64], k: usize| (breaks[k], breaks[k + 1]);
    let count_v = bounds.breaks_v.len() - 1;
    let number = bounds.cells.iter().enumerate().map(move |(k, cell)| (k / count_v, k % count_v, cell));
    number.map(move |(i, j, cell)| (ends(&bounds.breaks_u, i), ends(&bounds.breaks_v, j), cell))
}

#[test]
fn derivative_bounds_hold_and_are_tight() {
    // Bounded by bilinear fits.
    let large = ("rational large", bumpy(5, 4, 1.25), 1.4);
    for (name, surface, limit) in cases().into_iter().chain([large]) {
        let patches = BezierPatches::new(&surface);
        let bounds = SurfaceBounds::new(&patches);
        let mut worst = [1.0_f64; 5];
        // Only where a derivative is near its maximum: near its zeros the ratio means nothing.
        let scale = bounds.cells.iter().fold([0.0_f64; 5], |most, b| std::array::from_fn(|k| most[k].max(list(b)[k])));
        for (u, v, cell) in cells(&bounds) {
            let (found, sampled) = (list(cell), sampled(&patches, u, v));
            for k in 0..5 {
                assert!(found[k] >= sampled[k] * (1.0 - 1e-9) - 1e-9, "{name}: {found:?} below {sampled:?}");
                if sampled[k] > 0.5 * scale[k] && scale[k] > 0.0 {
                    worst[k] = worst[k].max(found[k] / sampled[k]);
                }
            }
        }
        println!("{name}: bound / sampled, worst box: {worst:.4?}");
        assert!(worst.iter().all(|&w| w <= limit), "{name}: {worst:?} over {limit}");
    }
}

#[test]
fn derivative_bounds_hold_for_any_weights() {
    let mut draw = SplitMix(11);
    for (degree_u, degree_v) in (1..=5).flat_map(|u| (1..=4).map(move |v| (u, v))) {
        let count = (degree_u + 1) * (degree_v + 1);
        let points = (0..count).map(|_| DVec3::from_array([(); 3].map(|()| draw.range(-5.0, 5.0)))).collect();
        let weights = (0..count).map(|_| draw.range(-3.0, 3.0).exp()).collect();
        let patches = BezierPatches::new(&NurbsSurface::bezier((degree_u, degree_v), points, weights));
        let NetBounds { du, dv, duu, duv, dvv } = patch_bounds(degree_u + 1, patches.patch(0, 0), true);
        let (found, sampled) = ([duu, duv, dvv, du, dv], sampled(&patches, (0.0, 1.0), (0.0, 1.0)));
        let holds = (0..5).all(|k| found[k] >= sampled[k] * (1.0 - 1e-9));
        assert!(holds, "{degree_u} {degree_v}: {found:?} below {sampled:?}");
    }
}

/// Largest components of `S_uu`, `S_uv`, `S_vv` along and across the normal over a box, by sampling.
fn sampled_parts(patches: &BezierPatches, u: (f64, f64), v: (f64, f64)) -> [[f64; 2]; 3] {
    let mut most = [[0.0_f64; 2]; 3];
    let at = |(a, b): (f64, f64), i: usize| a + (b - a) * (1e-5 + (1.0 - 2e-5) * i as f64 / 40.0);
    for (i, j) in (0..=40).flat_map(|i| (0..=40).map(move |j| (i, j))) {
        let d = patches.derivatives(at(u, i), at(v, j));
        let normal = d.du.cross(d.dv).normalize();
        for (most, x) in most.iter_mut().zip([d.duu, d.duv, d.dvv]) {
            let lift = x.dot(normal);
            most[0] = most[0].max(lift.abs());
            most[1] = most[1].max((x - lift * normal).length());
        }
    }
    most
}

#[test]
fn lifts_and_slides_hold_and_are_tight() {
    for (name, surface, _) in cases() {
        let patches = BezierPatches::new(&surface);
        let bounds = SurfaceBounds::new(&patches);
        let scale = bounds.cells.iter().fold(0.0_f64, |most, b| most.max(b.uu.norm).max(b.uv.norm).max(b.vv.norm));
        for (u, v, cell) in cells(&bounds) {
            let found = [cell.uu, cell.uv, cell.vv].map(|b| [b.lift, b.slide]);
            let sampled = sampled_parts(&patches, u, v);
            for (found, sampled) in found.iter().flatten().zip(sampled.iter().flatten()) {
                assert!(*found >= sampled * (1.0 - 1e-4) - 1e-6 * scale, "{name}: {found} below {sampled}");
                assert!(*found <= 1.25 * sampled + 0.05 * scale, "{name}: {found} for {sampled} of {scale}");
            }
        }
    }
}

#[test]
fn a_flat_spline_is_flat_however_it_is_parametrised() {
    let flat = |p: &DVec3| DVec3::new(p.x + 0.3 * p.z, p.y, 7.0);
    let mut surface = bumpy(3, 3, 1.25);
    surface.points = surface.points.iter().map(flat).collect();
    for cell in SurfaceBounds::new(&BezierPatches::new(&surface)).cells {
        assert!(cell.uu.slide > 0.0 && cell.vv.slide > 0.0);
        assert_eq!([cell.uu.lift, cell.uv.lift, cell.vv.lift], [0.0; 3]);
    }
}

#[test]
fn turning_is_an_upper_bound_and_exact_on_arcs() {
    for (name, surface, _) in cases() {
        let patches = BezierPatches::new(&surface);
        let bounds = SurfaceBounds::new(&patches);
        for (u, v, cell) in cells(&bounds) {
            for k in 0..=10 {
                let s = 1e-5 + (1.0 - 2e-5) * k as f64 / 10.0;
                let (mu, mv) = (u.0 + (u.1 - u.0) * s, v.0 + (v.1 - v.0) * s);
                let (along_u, along_v) =
                    (turning(&patches, (u.0, mv), (u.1, mv)), turning(&patches, (mu, v.0), (mu, v.1)));
                let slack = |theta: f64| theta * 1.01 + 1e-6;
                assert!(along_u <= slack(cell.turn_u), "{name}: {along_u} > {}", cell.turn_u);
                assert!(along_v <= slack(cell.turn_v), "{name}: {along_v} > {}", cell.turn_v);
            }
        }
    }
    let cylinder = Surface::Cylinder { frame: Frame3::WORLD, radius: 2.0 }.to_nurbs((0.0, TAU), (0.0, 9.0)).0;
    let bounds = SurfaceBounds::new(&BezierPatches::new(&cylinder));
    let around: f64 = bounds.cells.iter().map(|c| c.turn_u).sum();
    assert!((around - TAU).abs() < 1e-3 * TAU, "{around}");
}

#[test]
fn straight_directions_are_exactly_zero() {
    let frame = Frame3::from_axis(DVec3::new(1e4, -2e4, 7.0), DVec3::new(1.0, 2.0, 3.0), DVec3::Y).unwrap();
    let curve = NurbsCurve3::arc(&frame, 3.0, 2.0, 0.1, 5.0);
    let skewed = Frame3 { origin: frame.origin + DVec3::new(7.0, 1.0, 2.0), ..frame };
    let table = |s: Surface, u, v| SurfaceBounds::new(&BezierPatches::new(&s.to_nurbs(u, v).0));
    let (cylinder, cone) =
        (Surface::Cylinder { frame, radius: 2.0 }, Surface::Cone { frame: skewed, radius: 2.0, half_angle: -0.7 });
    let tube = Surface::Extrusion { curve, direction: DVec3::new(0.3, 5.0, -1.0) };
    for (surface, u, v) in
        [(cylinder, (0.3, 4.0), (-3.0, 1e3)), (cone, (0.0, TAU), (-4.0, 2.0)), (tube, (0.1, 5.0), (0.2, 7.0))]
    {
        let twisted = matches!(surface, Surface::Cone { .. });
        for cell in table(surface.clone(), u, v).cells {
            assert_eq!(cell.vv, Bend::default());
            assert!(cell.uu.lift > 0.0 && (cell.uv.slide > 0.0) == twisted);
            assert!(cell.uv.lift < 1e-6 * cell.uu.lift, "on a cone S_uv has no normal component");
            assert!(cell.turn_v < 1e-6 && cell.turn_u > 0.1);
        }
    }
    let plane = table(Surface::Plane { frame }, (-300.0, 200.0), (1.0, 5.0));
    assert_eq!(plane.cells.len(), 1);
    let none = Bend::default();
    assert_eq!((plane.cells[0].uu, plane.cells[0].uv, plane.cells[0].vv), (none, none, none));
    assert_eq!((plane.cells[0].turn_u, plane.cells[0].turn_v), (0.0, 0.0));
    assert!((plane.cells[0].u - 1.0).abs() < 1e-12 && (plane.cells[0].v - 1.0).abs() < 1e-12);
}

#[test]
fn curve_bounds_hold_and_are_tight() {
    let frame = Frame3::WORLD;
    let wavy = |degree: usize, weights: Vec<f64>| NurbsCurve3 {
        degree,
        knots: [vec![0.0; degree + 1], vec![0.8], vec![2.0; degree + 1]].concat(),
        points: (0..degree + 2).map(|i| DVec3::new(i as f64, (1.7 * i as f64).sin(), (i as f64).cos())).collect(),
        weights,
    };
    let cases = [
        (NurbsCurve3::arc(&frame, 3.0, 3.0, 0.0, TAU), 1.06),
        (NurbsCurve3::arc(&frame, 3.0, 0.5, 0.3, 2.0), 1.06),
        (wavy(3, Vec::new()), 1.02),
        (wavy(5, Vec::new()), 1.03),
        (wavy(3, vec![0.7, 1.3, 1.0, 0.8, 1.2]), 1.06),
    ];
    for (curve, limit) in cases {
        let spline = BezierSpline3::new(&curve, curve.domain());
        let bounds = CurveBounds::new(&spline);
        assert_eq!(bounds.strips.len() + 1, bounds.breaks.len());
        let most = bounds.strips.iter().fold(0.0_f64, |most, s| most.max(s.second));
        for (strip, ends) in bounds.strips.iter().zip(bounds.breaks.windows(2)) {
            let samples: Vec<_> = (0..=200)
                .map(|k| spline.derivatives(ends[0] + (ends[1] - ends[0]) * (1e-9 + (1.0 - 2e-9) * k as f64 / 200.0)))
                .collect();
            let first = samples.iter().fold(0.0_f64, |m, d| m.max(d.d1.length()));
            let second = samples.iter().fold(0.0_f64, |m, d| m.max(d.d2.length()));
            let turned: f64 =
                samples.windows(2).map(|d| d[0].d1.angle_between(d[1].d1)).filter(|a| a.is_finite()).sum();
            assert!(strip.first >= first * (1.0 - 1e-9) && strip.first <= limit * first);
            assert!(strip.second >= second * (1.0 - 1e-9) && (strip.second <= limit * second || second < 0.2 * most));
            assert!(
                strip.turn >= 0.99 * turned - 1e-6 && strip.turn <= 1.15 * turned + 1e-3,
                "{} {turned}",
                strip.turn
            );
        }
    }
    let line = NurbsCurve3::line(DVec3::new(1e3, 2.0, 3.0), DVec3::new(1e3 + 1.0, 2.5, 3.7));
    let bounds = CurveBounds::new(&BezierSpline3::new(&line, (0.2, 0.9)));
    assert!(bounds.is_straight());
    assert_eq!((bounds.strips.len(), bounds.strips[0].second, bounds.strips[0].turn), (1, 0.0, 0.0));
}

#[test]
fn a_straight_curve_of_uneven_speed_needs_no_strips() {
    let (from, to) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, -2.0, 8.0));
    let at = |share: f64| from.lerp(to, share);
    let bounds = |points: [DVec3; 4], weights: &[f64]| {
        let curve = NurbsCurve3::bezier(points.to_vec(), weights.to_vec());
        CurveBounds::new(&BezierSpline3::new(&curve, (0.0, 1.0)))
    };
    for weights in [&[][..], &[1.0, 5.0, 0.2, 1.0]] {
        for shares in [[0.0, 0.0, 1.0, 1.0], [0.0, 0.1, 0.2, 1.0]] {
            let even = bounds(shares.map(at), weights);
            assert!(even.is_straight() && even.strips.len() == 1, "{shares:?} {weights:?}");
        }
        // One that runs beyond its end and back, and one that bends.
        let bent = [from, at(0.3) + DVec3::splat(1e-6), at(0.6), to];
        for points in [[0.0, 0.4, 1.6, 1.0].map(at), bent] {
            assert!(!bounds(points, weights).is_straight(), "{points:?} {weights:?}");
        }
    }
}

#[test]
fn finely_cut_surfaces_get_small_tables() {
    let n = 80;
    let knots: Vec<f64> = [vec![0.0; 3], (0..=n).map(f64::from).collect(), vec![f64::from(n); 3]].concat();
    let count = n as usize + 3;
    let points = (0..count * 2).map(|k| DVec3::new((k / 2) as f64, (k % 2) as f64, (k as f64).sin())).collect();
    let surface = NurbsSurface {
        degree_u: 3,
        degree_v: 1,
        knots_u: knots,
        knots_v: vec![0.0, 0.0, 1.0, 1.0],
        points,
        weights: Vec::new(),
    };
    assert_eq!(SurfaceBounds::new(&BezierPatches::new(&surface)).cells.len(), n as usize);
}
