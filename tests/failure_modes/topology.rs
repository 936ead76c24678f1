//! How bodies are composed: edges of many faces, coincident faces, lost faces, tiny faces.

use crate::body::{Body, ball, cap, frame, level};
use crate::common::{self, prepared};
use crate::ladder::Ladder;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use trimtess::frame::{Tolerance, plan};
use trimtess::mesh::check_scene;
use trimtess::model::{Coedge, EdgeId, Face, FaceId, Frame3, Loop, Model, NurbsSurface, Part, ShellKind, Surface};

fn at(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn block(body: &mut Body, low: DVec3, high: DVec3) {
    body.cuboid(low, high, Vec::new(), Vec::new());
}

#[test]
fn fins_that_share_one_edge() {
    for count in [3, 4, 7] {
        let mut body = Body::sheet();
        for k in 0..count {
            let angle = TAU * f64::from(k) / f64::from(count);
            let out = at(3.0 * angle.cos(), 3.0 * angle.sin(), 0.0);
            let up = DVec3::Z * 5.0;
            body.side(&[DVec3::ZERO, out, out + up, up], Vec::new());
        }
        Ladder::sheet(body.finish(), 15.0 * f64::from(count)).pieces(1).named(count).assert_climbs();
    }
}

#[test]
fn an_edge_used_four_times_within_one_shell() {
    // Two blocks that touch along an edge, stated as one body.
    let mut body = Body::solid();
    block(&mut body, at(0.0, 0.0, 0.0), at(1.0, 1.0, 1.0));
    block(&mut body, at(1.0, 1.0, 0.0), at(3.0, 2.0, 1.0));
    let part = body.finish();
    assert_eq!(part.edges.len(), 23);
    Ladder::solid(part, 3.0, 6.0 + 10.0).assert_climbs();
}

#[test]
fn solids_that_touch_in_a_face() {
    // With separate edges, and with common ones: then the edges around the common face have four uses.
    for common in [false, true] {
        let mut body = Body::solid();
        block(&mut body, at(0.0, 0.0, 0.0), at(4.0, 3.0, 2.0));
        body.shell = body.part.plain_shell(ShellKind::Outer);
        if !common {
            body.forget();
        }
        block(&mut body, at(0.0, 0.0, 2.0), at(4.0, 3.0, 7.0));
        Ladder::solid(body.finish(), 84.0, 52.0 + 94.0).named(common).assert_climbs();
    }
}

#[test]
fn a_ball_within_a_void_within_a_block() {
    let mut body = Body::solid();
    block(&mut body, at(-5.0, -5.0, -5.0), at(5.0, 5.0, 5.0));
    body.shell = body.part.plain_shell(ShellKind::Void);
    body.face(Surface::Sphere { frame: Frame3::WORLD, radius: 3.0 }, Vec::new(), true);
    body.shell = body.part.plain_shell(ShellKind::Outer);
    body.face(Surface::Sphere { frame: Frame3::WORLD, radius: 1.0 }, Vec::new(), false);
    let volume = 1000.0 - 4.0 / 3.0 * PI * (27.0 - 1.0);
    Ladder::solid(body.finish(), volume, 600.0 + 4.0 * PI * 10.0).pieces(3).voids(1).assert_climbs();
}

#[test]
fn a_void_that_lies_beside_its_solid_is_a_body() {
    // The stated void lies in the box around two blocks, and outside of both.
    let mut body = Body::solid();
    block(&mut body, at(0.0, 0.0, 0.0), at(1.0, 9.0, 1.0));
    block(&mut body, at(1.5, 8.0, 0.0), at(9.0, 9.0, 1.0));
    body.shell = body.part.plain_shell(ShellKind::Void);
    block(&mut body, at(3.0, 2.0, 0.2), at(5.0, 4.0, 0.8));
    let (volume, area) = (9.0 + 7.5 + 2.4, 38.0 + 32.0 + 12.8);
    Ladder::solid(body.finish(), volume, area).pieces(3).told(&["shell-void-outside"]).assert_climbs();
    // It may be stated as a void, too.
    let mut body = Body::solid();
    block(&mut body, at(0.0, 0.0, 0.0), at(9.0, 9.0, 1.0));
    body.shell = body.part.plain_shell(ShellKind::Void);
    let ball = Frame3 { origin: at(13.0, 4.0, 0.0), ..Frame3::WORLD };
    body.face(Surface::Sphere { frame: ball, radius: 2.0 }, Vec::new(), true);
    let (volume, area) = (81.0 + 32.0 / 3.0 * PI, 198.0 + 16.0 * PI);
    Ladder::solid(body.finish(), volume, area).pieces(2).told(&["shell-void-outside"]).assert_climbs();
    // Within its solid, the same void is inside out.
    let mut body = Body::solid();
    block(&mut body, at(0.0, 0.0, 0.0), at(9.0, 9.0, 1.0));
    body.shell = body.part.plain_shell(ShellKind::Void);
    block(&mut body, at(3.0, 2.0, 0.2), at(5.0, 4.0, 0.8));
    let (volume, area) = (81.0 - 2.4, 198.0 + 12.8);
    Ladder::solid(body.finish(), volume, area).pieces(2).voids(1).told(&["shell-inside-out"]).assert_climbs();
    // Without a solid before it, a void is one wherever it lies.
    let mut body = Body::new(ShellKind::Void);
    block(&mut body, at(13.0, 2.0, 0.2), at(15.0, 4.0, 0.8));
    body.shell = body.part.plain_shell(ShellKind::Outer);
    block(&mut body, at(0.0, 0.0, 0.0), at(9.0, 9.0, 1.0));
    Ladder::solid(body.finish(), volume, area).pieces(2).voids(1).told(&["shell-inside-out"]).assert_climbs();
}

#[test]
fn a_bevel_a_millionth_of_its_block() {
    for bevel in [1e-2, 1e-4, 1e-6] {
        let size = 100.0;
        let mut body = Body::solid();
        // The profile of the block in x and z, its corner at (size, size) cut off, swept along y.
        let profile = [(0.0, 0.0), (size, 0.0), (size, size - bevel), (size - bevel, size), (0.0, size)];
        let p = |k: usize, y: f64| at(profile[k % 5].0, y, profile[k % 5].1);
        for k in 0..5 {
            body.side(&[p(k, size), p(k + 1, size), p(k + 1, 0.0), p(k, 0.0)], Vec::new());
        }
        let ends = |y: f64| (0..5).map(|k| p(k, y)).collect::<Vec<_>>();
        body.side(&ends(0.0), Vec::new());
        body.side(&ends(size).into_iter().rev().collect::<Vec<_>>(), Vec::new());
        let cut = 0.5 * bevel * bevel;
        let area = 6.0 * size * size - 2.0 * cut - 2.0 * bevel * size + bevel * std::f64::consts::SQRT_2 * size;
        Ladder::solid(body.finish(), size.powi(3) - cut * size, area).named(bevel).assert_climbs();
    }
}

#[test]
fn a_loop_of_ten_thousand_edges_and_a_prism_on_it() {
    let count = 10_000_u32;
    let corner = |k: u32, z: f64| {
        let angle = TAU * f64::from(k) / f64::from(count);
        // A gear: every other corner lies further in.
        let radius = if k.is_multiple_of(2) { 100.0 } else { 99.9 };
        at(radius * angle.cos(), radius * angle.sin(), z)
    };
    let area = 0.5 * f64::from(count) * 100.0 * 99.9 * (TAU / f64::from(count)).sin();
    let mut part = trimtess::model::PartBuilder::new("gear");
    let shell = part.plain_shell(ShellKind::Outer);
    let rings = [0.0, 5.0].map(|z| part.polygon(&(0..count).map(|k| corner(k, z)).collect::<Vec<_>>()));
    let start = |part: &trimtess::model::PartBuilder, edge: EdgeId| part.part().edges[edge.index()].start;
    let ups: Vec<EdgeId> = (0..count as usize)
        .map(|k| {
            let ends = [&rings[0], &rings[1]].map(|ring| start(&part, ring[k].edge));
            part.line(ends[0], ends[1])
        })
        .collect();
    for k in 0..count as usize {
        let next = (k + 1) % count as usize;
        let (a, b) = (corner(k as u32, 0.0), corner(next as u32, 0.0));
        let plane = Surface::Plane { frame: frame(a, (b - a).cross(DVec3::Z), b - a) };
        let round = vec![rings[0][k], ups[next].along(), rings[1][k].edge.against(), ups[k].against()];
        part.plain_face(plane, shell, vec![Loop::Edges(round)], false);
    }
    for (z, ring) in [(0.0, &rings[0]), (5.0, &rings[1])] {
        let plane = Surface::Plane { frame: crate::body::level(z) };
        part.plain_face(plane, shell, vec![Loop::Edges(ring.clone())], z == 0.0);
    }
    let side = f64::from(count) * corner(0, 0.0).distance(corner(1, 0.0)) * 5.0;
    Ladder::solid(part.finish().expect("a valid part"), area * 5.0, 2.0 * area + side).assert_climbs();
}

/// A block of 4 × 3 × 2 with a hole; its faces have entity numbers from 70.
fn numbered() -> Part {
    let mut body = Body::solid();
    let [top, bottom] = [2.0, 0.0].map(|z| {
        let f = Frame3 { origin: at(2.0, 1.5, z), ..Frame3::WORLD };
        body.circle(&f, 1.0)
    });
    body.cuboid(DVec3::ZERO, at(4.0, 3.0, 2.0), vec![vec![top.against()]], vec![vec![bottom.along()]]);
    let bore = Frame3 { origin: at(2.0, 1.5, 0.0), ..Frame3::WORLD };
    body.face(Surface::Cylinder { frame: bore, radius: 1.0 }, vec![vec![bottom.along()], vec![top.against()]], true);
    let mut part = body.finish();
    for (k, face) in part.faces.iter_mut().enumerate() {
        face.entity = 70 + k as u64;
    }
    part
}

/// A surface without control points.
fn unsound() -> Surface {
    Surface::Nurbs(NurbsSurface::bezier((1, 1), Vec::new(), Vec::new()))
}

#[test]
fn one_broken_face_loses_only_its_surface_and_is_reported_by_entity() {
    type Break = fn(&mut Part);
    let breaks: [(&'static str, Break); 6] = [
        ("face-off-surface", |p| {
            p.faces[0].surface = Surface::Plane { frame: Frame3 { origin: DVec3::Z * 9.0, ..Frame3::WORLD } };
        }),
        ("face-surface-unsound", |p| p.faces[0].surface = Surface::Sphere { frame: Frame3::WORLD, radius: f64::NAN }),
        ("face-surface-unsound", |p| {
            let frame = Frame3 { x: DVec3::ZERO, y: DVec3::ZERO, z: DVec3::ZERO, ..Frame3::WORLD };
            p.faces[0].surface = Surface::Plane { frame };
        }),
        ("loop-without-edges", |p| p.faces[0].loops = vec![Loop::Edges(Vec::new())]),
        ("face-surface-unsound", |p| p.faces[0].surface = unsound()),
        ("face-surface-unsound", |p| {
            p.faces[0].surface = unsound();
            p.faces[0].loops.clear();
        }),
    ];
    let all = 2.0 * (12.0 - PI) + 28.0 + TAU * 2.0;
    for (number, (code, broken)) in breaks.into_iter().enumerate() {
        let mut model = Model::from(numbered());
        broken(&mut model.parts[0]);
        let Face { entity, loops, .. } = &model.parts[0].faces[0];
        let (entity, filled) = (*entity, matches!(loops.first(), Some(Loop::Edges(edges)) if !edges.is_empty()));
        let prepared = prepared(model.clone());
        let told = prepared.diagnostics.iter().find(|d| d.face == Some(FaceId(0)));
        let told = told.unwrap_or_else(|| panic!("case {number}: {:?}", prepared.diagnostics));
        assert!(told.entity == entity && told.kind.code() == code, "case {number}: {told:?}");
        // Its loops are filled; without loops it is lost.
        let ladder = match filled {
            true => Ladder::closed(model, all),
            false => Ladder::open(model, all - (12.0 - PI)).lost(&[0]),
        };
        ladder.pieces(1).named(number).told(&[code]).assert_climbs();
    }
}

#[test]
fn a_gap_in_a_loop_on_an_unsound_surface_is_bridged_by_a_line() {
    let mut model = Model::from(numbered());
    let face = &mut model.parts[0].faces[0];
    face.surface = unsound();
    let Loop::Edges(coedges) = &mut face.loops[0] else { panic!("a loop of edges") };
    coedges.pop();
    let prepared = prepared(model.clone());
    let codes: Vec<&str> = prepared.diagnostics.iter().map(|d| d.kind.code()).collect();
    assert!(codes.contains(&"face-surface-unsound"), "{codes:?}");
    let all = 2.0 * (12.0 - PI) + 28.0 + TAU * 2.0;
    Ladder::open(model, all).told(&codes).assert_climbs();
}

#[test]
fn a_one_sided_strip_is_meshed() {
    // Eight bilinear pieces around a circle, with one half twist: no orientation fits.
    let count = 8;
    let mut body = Body::sheet();
    let rung = |k: i32| {
        let angle = TAU * f64::from(k) / f64::from(count);
        let (out, half) = (at(angle.cos(), angle.sin(), 0.0), 0.5 * angle);
        let across = out * half.cos() + DVec3::Z * half.sin();
        [out * 10.0 - across * 2.0, out * 10.0 + across * 2.0]
    };
    for k in 0..count {
        let [a, b] = rung(k);
        let mut next = rung((k + 1) % count);
        if k + 1 == count {
            next.reverse();
        }
        let [d, c] = next;
        let piece = NurbsSurface::bezier((1, 1), vec![a, b, d, c], Vec::new());
        let round = body.polygon(&[a, d, c, b]);
        body.face(Surface::Nurbs(piece), vec![round], false);
    }
    let prepared = prepared(body.finish());
    let plan = plan(&prepared, &Tolerance { chord: 0.05, angle: 0.5, max_edge: None });
    let facts = check_scene(&common::frame(&prepared, &plan, true).0);
    assert!(facts.total.is_well_formed() && facts.faces_without_triangles.is_empty(), "{}", facts.total);
    // Neighbours disagree across one of the rungs and nowhere else.
    let rungs = facts.total.unbalanced_edges - facts.total.open_edges;
    assert!((1..=16).contains(&rungs), "{}", facts.total);
    assert_eq!(facts.total.components, 1);
}

/// An eighth of a ball, whose arc to the pole has a vertex `split` radians before it. Of the sphere, the other seven
/// eighths have the same boundary. Wires of planes and of the sphere run as they should or, if `wrong`, against it.
fn eighth(radius: f64, split: f64, wrong: [bool; 2]) -> Part {
    let mut body = Body::solid();
    let turned = |wire: Vec<Coedge>, wrong: bool| {
        let back = |c: &Coedge| Coedge { reversed: !c.reversed, ..*c };
        if wrong { wire.iter().rev().map(back).collect() } else { wire }
    };
    let corners = DVec3::AXES.map(|axis| axis * radius);
    let mut around = Vec::new();
    for k in 0..3 {
        let (from, to) = (corners[k], corners[(k + 1) % 3]);
        let round = frame(DVec3::ZERO, from.cross(to), from);
        let marks = if k == 1 && split > 0.0 { vec![0.0, FRAC_PI_2 - split, FRAC_PI_2] } else { vec![0.0, FRAC_PI_2] };
        let arcs: Vec<EdgeId> = marks.windows(2).map(|w| body.arc(&round, radius, w[0], w[1])).collect();
        let mut side = vec![body.line(DVec3::ZERO, to)];
        side.extend(arcs.iter().rev().map(|arc| arc.against()));
        side.push(body.line(from, DVec3::ZERO));
        body.flat(frame(DVec3::ZERO, -round.z, from), vec![turned(side, wrong[0])]);
        around.extend(arcs.into_iter().map(EdgeId::along));
    }
    body.face(Surface::Sphere { frame: Frame3::WORLD, radius }, vec![turned(around, wrong[1])], false);
    body.finish()
}

#[test]
fn wires_of_a_sphere_run_as_those_of_neighbours_and_planes_say() {
    let radius: f64 = 4.0;
    for (wrong, told) in [
        ([false, false], None),
        ([false, true], Some("wire-against-neighbours")),
        ([true, true], Some("wire-against-planes")),
    ] {
        let solid = Ladder::solid(eighth(radius, 0.0, wrong), ball(radius) / 8.0, 5.0 / 4.0 * PI * radius * radius);
        solid.named(wrong).told(told.as_slice()).assert_climbs();
    }
}

#[test]
fn a_dome_whose_flags_are_all_wrong() {
    // A cap of height 2 of a ball of radius 5, on a disc of radius 4.
    let (whole, area) = (ball(5.0), 16.0 * PI);
    for (reversed, told, volume, round) in [
        // All senses: the face of the sphere would have its stated sense on neither side of the disc but this one.
        (true, vec!["wire-against-planes", "shell-inside-out"], cap(5.0, 2.0), 20.0 * PI),
        // All bounds, or the sense of the disc.
        (false, vec!["wire-side-unsure"], whole - cap(5.0, 2.0), 80.0 * PI),
    ] {
        let mut body = Body::solid();
        let rim = body.circle(&level(3.0), 4.0);
        body.face(Surface::Sphere { frame: Frame3::WORLD, radius: 5.0 }, vec![vec![rim.against()]], reversed);
        let disc = Surface::Plane { frame: frame(DVec3::Z * 3.0, -DVec3::Z, DVec3::X) };
        body.face(disc, vec![vec![rim.along()]], reversed);
        Ladder::solid(body.finish(), volume, area + round).named(reversed).told(&told).assert_climbs();
    }
}

#[test]
fn an_edge_that_ends_at_a_pole_may_be_tiny() {
    let radius: f64 = 4.0;
    for split in [1e-3, 1e-5, 1e-6, 1e-7] {
        let part = eighth(radius, split, [false; 2]);
        let solid = Ladder::solid(part, ball(radius) / 8.0, 5.0 / 4.0 * PI * radius * radius);
        solid.named(split).assert_climbs();
    }
}
