//! Images of edges, against samples of the edges.

use crate::model::{CurveKind, Edge, Frame3, NurbsCurve3, NurbsSurface, Surface, VertexId};
use crate::prepare::uv::projector::Projector;
use crate::prepare::uv::uv_curve::UvSample;
use crate::sequence::random::SplitMix;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// An edge along all of a curve, and its ends.
fn edge(curve: NurbsCurve3, kind: CurveKind) -> (Edge, [DVec3; 2]) {
    let range = curve.domain();
    let ends = [range.0, range.1].map(|t| curve.point(t));
    (Edge { curve, range, start: VertexId(0), end: VertexId(1), kind, entity: 0 }, ends)
}

/// A straight edge along a sheet of two mirrored spans or of one, each almost at rest at both of its ends: the curve in
/// parameters is odd about the middles of pieces.
#[test]
fn images_that_are_right_in_the_middle_only_are_refined() {
    for (slow, kind) in
        [0.5, 0.1, 0.02].into_iter().flat_map(|slow| [(slow, CurveKind::Line), (slow, CurveKind::Polyline)])
    {
        // A line begins as two pieces, a segment of a polyline as one.
        let two = [0.0, slow, 5.0 - slow, 5.0, 5.0 + slow, 10.0 - slow, 10.0];
        let one = [0.0, slow, 10.0 - slow, 10.0];
        let (across, inner) = if kind == CurveKind::Line { (&two[..], 3) } else { (&one[..], 0) };
        let point = |x: f64| [0.0, 10.0].map(|y| DVec3::new(x, y, 0.0));
        let surface = Surface::Nurbs(NurbsSurface {
            degree_u: 3,
            degree_v: 1,
            knots_u: [0.0; 4].into_iter().chain(vec![1.0; inner]).chain([2.0; 4]).collect(),
            knots_v: vec![0.0, 0.0, 1.0, 1.0],
            points: across.iter().copied().flat_map(point).collect(),
            weights: Vec::new(),
        });
        let (edge, ends) = edge(NurbsCurve3::bezier(vec![DVec3::ZERO, 10.0 * DVec3::X], Vec::new()), kind);
        let image = Projector::new(&surface, 1e-6).march(&edge, ends, false, None).samples;
        for k in 0..=1000 {
            let t = f64::from(k) / 1000.0;
            let uv = UvSample::on(&image, t).uv;
            let off = surface.point(uv.x, uv.y).distance(edge.curve.point(t));
            assert!(off < 1e-4, "{slow}: {off} at {t}");
        }
    }
}

/// The corners of a polygon are on the surface, its sides are not.
#[test]
fn chords_of_a_circle_are_off_the_surface_between_their_ends() {
    let (radius, sides) = (5.0_f64, 40);
    let turn = |k: u32| TAU * f64::from(k) / f64::from(sides);
    let corners: Vec<DVec3> = (0..=sides / 2).map(|k| radius * DVec3::new(turn(k).cos(), turn(k).sin(), 0.0)).collect();
    let knots: Vec<f64> = (0..corners.len() as u32).map(f64::from).collect();
    let knots = [&knots[..1], &knots[..], &knots[knots.len() - 1..]].concat();
    let curve = NurbsCurve3 { degree: 1, knots, points: corners, weights: Vec::new() };
    let (edge, ends) = edge(curve, CurveKind::Polyline);
    let surface = Surface::Cylinder { frame: Frame3::WORLD, radius };
    let gap = Projector::new(&surface, 1e-6).march(&edge, ends, false, None).gap;
    let height = radius * (1.0 - (0.5 * turn(1)).cos());
    assert!((gap - height).abs() < 1e-9, "{gap} instead of {height}");
}

/// Circles of all sizes in planes, and along one parameter of round surfaces. Pieces whose halves are taken unseen fit.
#[test]
fn images_of_circles_are_within_the_tolerance_everywhere() {
    let frame = Frame3::WORLD;
    for size in (0..24).map(|k| 0.01 * 1.5_f64.powi(k)) {
        let around = |radius: f64, height: f64| (Frame3 { origin: height * DVec3::Z, ..frame }, radius * size);
        let tube = Frame3 { origin: 3.0 * size * DVec3::X, x: DVec3::X, y: DVec3::Z, z: DVec3::NEG_Y };
        let cases = [
            (Surface::Plane { frame }, around(1.0, 0.0)),
            (Surface::Cylinder { frame, radius: size }, around(1.0, 0.5)),
            (Surface::Cone { frame, radius: size, half_angle: 0.5 }, around(1.0, 0.0)),
            (Surface::Sphere { frame, radius: size }, around(1.0, 0.0)),
            (Surface::Torus { frame, major: 3.0 * size, minor: size }, around(4.0, 0.0)),
            (Surface::Torus { frame, major: 3.0 * size, minor: size }, (tube, size)),
        ];
        for (surface, (place, radius)) in cases {
            for (from, to) in [(0.0, TAU), (0.3, 0.3 + FRAC_PI_2), (1.0, 2.0), (0.1, 0.4)] {
                let (edge, ends) = edge(NurbsCurve3::arc(&place, radius, radius, from, to), CurveKind::Circle);
                let image = Projector::new(&surface, 1e-6).march(&edge, ends, false, None).samples;
                for k in 0..=400 {
                    let t = edge.range.0 + (edge.range.1 - edge.range.0) * f64::from(k) / 400.0;
                    let uv = UvSample::on(&image, t).uv;
                    let off = surface.point(uv.x, uv.y).distance(edge.curve.point(t));
                    assert!(off < 4.4e-6, "{surface:?} {radius} {from}: {off} at {t}");
                }
            }
        }
    }
}

/// A circle close to a pole turns its image by half a turn within a short way, and the walk may begin on the other
/// side.
#[test]
fn images_that_pass_a_pole_do_not_leap() {
    let surface = Surface::Sphere { frame: Frame3::WORLD, radius: 1.0 };
    let mut draw = SplitMix(5);
    for _ in 0..400 {
        let (off, from) = (draw.range(-0.02, 0.02), draw.range(-3.0, 1.0));
        let place = Frame3 { origin: off * DVec3::X, x: DVec3::Y, y: DVec3::Z, z: DVec3::X };
        let radius = (1.0 - off * off).sqrt();
        let curve = NurbsCurve3::arc(&place, radius, radius, from, from + draw.range(1.0, 4.0));
        let (edge, ends) = edge(curve, CurveKind::Circle);
        let leap = Projector::new(&surface, 1e-6).march(&edge, ends, false, None).leap;
        assert!(leap == 0.0, "{off} {from} {:?}: {leap}", edge.range);
    }
}
