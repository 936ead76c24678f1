//! Narrow faces: crescents, open rings, slots and bends whose two sides are far closer than they are long.

#[path = "../sequence/random.rs"]
mod random;

use crate::common::{prepared, prepared_clean};
use crate::{CHORDS, mesh};
use glam::DVec3;
use random::SplitMix;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use trimtess::model::{Coedge, CurveKind, Frame3, Loop, NurbsCurve3, Part, PartBuilder, ShellKind, Surface};
use trimtess::prepare::Prepared;

#[test]
fn a_thin_crescent_survives_coarse_tolerances() {
    // Two arcs with common ends: without critical parameters both would be the same chord.
    let frame = |y: f64| Frame3 { origin: DVec3::new(0.0, y, 0.0), ..Frame3::WORLD };
    let mut part = PartBuilder::new("crescent");
    let ends = [DVec3::X * 3.0, DVec3::X * -3.0].map(|p| part.vertex(p));
    let mut arc = |below: f64| {
        let r = 3.0_f64.hypot(below);
        let a = (below / 3.0).atan();
        let curve = NurbsCurve3::arc(&frame(-below), r, r, a, PI - a);
        part.curve(curve, CurveKind::Circle, ends[0], ends[1])
    };
    let (high, low) = (arc(4.0), arc(8.0));
    let shell = part.plain_shell(ShellKind::Open);
    let boundary = vec![Loop::Edges(vec![high.along(), low.against()])];
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, boundary, false);
    let prepared = prepared(part.finish().expect("a valid part"));
    let segment = |below: f64| {
        let r = 3.0_f64.hypot(below);
        let half = (3.0 / r).asin();
        r * r * (half - half.sin() * half.cos())
    };
    let exact = segment(4.0) - segment(8.0);
    for (chord, slack) in [(10.0, 0.6), (0.01, 0.1), (1e-4, 1e-3)] {
        let area = mesh(&prepared, chord).area;
        assert!((area / exact - 1.0).abs() < slack, "chord {chord}: area {area} of {exact}");
    }
}

/// A ring cut open: two arcs about the same centre, `gap` apart, and a line at either end.
fn open_ring(radius: f64, gap: f64, turn: f64) -> Part {
    let mut part = PartBuilder::new("ring");
    let shell = part.plain_shell(ShellKind::Open);
    let boundary = ring_loop(&mut part, radius, gap, turn);
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, vec![Loop::Edges(boundary)], false);
    part.finish().expect("a valid part")
}

/// The boundary of an open ring.
fn ring_loop(part: &mut PartBuilder, radius: f64, gap: f64, turn: f64) -> Vec<Coedge> {
    let at = |radius: f64, angle: f64| Frame3::WORLD.place(DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.0));
    let radii = [radius, radius - gap];
    let ends = radii.map(|r| [0.0, turn].map(|angle| part.vertex(at(r, angle))));
    let arcs = [0, 1].map(|k| {
        let curve = NurbsCurve3::arc(&Frame3::WORLD, radii[k], radii[k], 0.0, turn);
        part.curve(curve, CurveKind::Circle, ends[k][0], ends[k][1])
    });
    let there = part.line(ends[0][1], ends[1][1]);
    let back = part.line(ends[1][0], ends[0][0]);
    vec![arcs[0].along(), there.along(), arcs[1].against(), back.along()]
}

#[test]
fn slots_side_by_side_are_kept_apart() {
    // The points opposite to those that keep three slots apart would be more than there may be.
    let (radius, gap, turn) = (5.25, 0.00025, 3.82);
    let mut part = PartBuilder::new("slots");
    let start = part.vertex(DVec3::X * 2.0 * radius);
    let curve = NurbsCurve3::arc(&Frame3::WORLD, 2.0 * radius, 2.0 * radius, 0.0, TAU);
    let rim = part.curve(curve, CurveKind::Circle, start, start);
    let mut boundary = vec![Loop::Edges(vec![rim.along()])];
    for k in 0..3 {
        let slot = ring_loop(&mut part, radius - 2.0 * gap * f64::from(k), gap, turn);
        let back = slot.iter().rev().map(|coedge| Coedge { reversed: !coedge.reversed, ..*coedge });
        boundary.push(Loop::Edges(back.collect()));
    }
    let shell = part.plain_shell(ShellKind::Open);
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, boundary, false);
    let prepared = prepared_clean(part.finish().expect("a valid part"));
    let breaks: usize = prepared.parts[0].edges.iter().map(|edge| edge.breaks.len()).sum();
    assert!(breaks > 1000, "{breaks} points");
}

#[test]
fn two_close_bends_to_both_sides_have_the_same_critical_points() {
    let gap = 0.03;
    let mut part = PartBuilder::new("strip");
    // The weights change the parameter, not the curve.
    let [lower, upper] = [(0.0, 1.0_f64), (gap, 1.5)].map(|(y, weight)| {
        let weights = (0..4).map(|k| weight.powi(k)).collect();
        let points = [(0.0, 0.0), (6.0, 0.0), (4.0, 5.0), (10.0, 5.0)].map(|p| DVec3::new(p.0, p.1 + y, 0.0)).to_vec();
        let ends = [points[0], points[3]].map(|end| part.vertex(end));
        let curve = NurbsCurve3::bezier(points, weights);
        (ends, part.curve(curve, CurveKind::Spline, ends[0], ends[1]))
    });
    let (there, back) = (part.line(lower.0[1], upper.0[1]), part.line(upper.0[0], lower.0[0]));
    let boundary = vec![lower.1.along(), there.along(), upper.1.against(), back.along()];
    let shell = part.plain_shell(ShellKind::Open);
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, vec![Loop::Edges(boundary)], false);
    // Points of different parameters do not pair up everywhere. Without pairs, the area is twice as large.
    assert_keeps_width(&prepared(part.finish().expect("a valid part")), 10.0 * gap, 0.15);
}

/// Whether a strip has its area to a share: sides with chords of their own make it as wide as the tolerance.
fn assert_keeps_width(prepared: &Arc<Prepared>, area: f64, share: f64) {
    for chord in CHORDS {
        let facts = mesh(prepared, chord);
        assert!(facts.is_well_formed(), "chord {chord}: {facts}");
        assert!((facts.area / area - 1.0).abs() < share, "chord {chord}: {} for {area}", facts.area);
    }
}

#[test]
fn two_close_arcs_have_the_same_critical_points() {
    // The can of a capacitor: two micrometres of plane next to a rounded edge. The outer arc needs 70 chords, 128 after
    // halving.
    let (radius, gap, turn) = (5.25, 0.002, 3.82);
    let prepared = prepared(open_ring(radius, gap, turn));
    let points = |edge: usize| prepared.parts[0].edges[edge].breaks.len();
    assert!((71..=129).contains(&points(0)), "{} on the outer arc", points(0));
    assert_eq!(points(1), points(0), "on the inner arc");
    let ring = |radius: f64, gap: f64, turn: f64| 0.5 * turn * (radius * radius - (radius - gap) * (radius - gap));
    assert_keeps_width(&prepared, ring(radius, gap, turn), 0.05);
    // Its tile is 16 times as long as wide.
    let (radius, gap, turn) = (5.25, 5e-4, 0.1);
    assert_keeps_width(&self::prepared(open_ring(radius, gap, turn)), ring(radius, gap, turn), 0.05);
}

#[test]
fn edges_that_are_noise_have_few_critical_points() {
    // Two splines that cross again and again: no points can keep their polylines apart.
    let mut part = PartBuilder::new("noise");
    let mut random = SplitMix(1);
    let mut noise = move || random.range(-0.5, 0.5);
    let corners = [0.0, 100.0].map(|x| part.vertex(DVec3::X * x));
    let mut spline = || {
        let mut points: Vec<DVec3> = (0..100).map(|k| DVec3::new(f64::from(k) + noise(), noise(), 0.0)).collect();
        (points[0], points[99]) = (DVec3::ZERO, DVec3::X * 100.0);
        let inner = (1..97).map(f64::from);
        let knots = [0.0; 4].into_iter().chain(inner).chain([97.0; 4]).collect();
        let curve = NurbsCurve3 { degree: 3, knots, points, weights: Vec::new() };
        part.curve(curve, CurveKind::Spline, corners[0], corners[1])
    };
    let (low, high) = (spline(), spline());
    let shell = part.plain_shell(ShellKind::Open);
    let boundary = vec![Loop::Edges(vec![low.along(), high.against()])];
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, boundary, false);
    let part = part.finish().expect("a valid part");
    let prepared = prepared(part);
    let breaks: usize = prepared.parts[0].edges.iter().map(|edge| edge.breaks.len()).sum();
    assert!(breaks <= 1200, "{breaks} points");
}
