//! Spheres and tori: seams, poles, whole surfaces, holes across all of them.

use crate::body::{Body, ball, cap, frame, integral, level, through};
use crate::common::prepared;
use crate::ladder::Ladder;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use trimtess::model::{Coedge, EdgeId, Frame3, Loop, NurbsCurve3, Severity, ShellKind, Surface};

fn sphere(radius: f64) -> Surface {
    Surface::Sphere { frame: Frame3::WORLD, radius }
}

/// The frame of circles in the plane of x and z that run from the south pole over +x to the north pole.
fn meridian() -> Frame3 {
    Frame3 { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Z, z: -DVec3::Y }
}

/// The half circle from pole to pole at u = 0.
fn seam(body: &mut Body, radius: f64) -> EdgeId {
    body.arc(&meridian(), radius, -FRAC_PI_2, FRAC_PI_2)
}

#[test]
fn whole_spheres_of_any_radius() {
    for radius in [1e-2, 1.0, 1e4] {
        for relative in [0.05, 0.017] {
            for with_seam in [false, true] {
                let mut body = Body::solid();
                let loops = if with_seam {
                    let seam = seam(&mut body, radius);
                    vec![vec![seam.along(), seam.against()]]
                } else {
                    Vec::new()
                };
                body.face(sphere(radius), loops, false);
                let ladder = Ladder::solid(body.finish(), ball(radius), 4.0 * PI * radius * radius);
                ladder.chord(relative * radius).pieces(1).assert_climbs();
            }
        }
    }
}

#[test]
fn half_spheres_above_an_equator_and_between_meridians() {
    let radius = 5.0;
    // The seam of the upper half runs from the equator to the pole and back.
    for with_seam in [false, true] {
        let mut body = Body::solid();
        let equator = body.circle(&Frame3::WORLD, radius);
        let mut round = vec![equator.along()];
        if with_seam {
            let seam = body.arc(&meridian(), radius, 0.0, FRAC_PI_2);
            round.extend([seam.along(), seam.against()]);
        }
        body.face(sphere(radius), vec![round], false);
        body.face(Surface::Plane { frame: Frame3::WORLD }, vec![vec![equator.along()]], true);
        Ladder::solid(body.finish(), 0.5 * ball(radius), 3.0 * PI * radius * radius).assert_climbs();
    }
    // Half a ball between two meridians, each its own edge, at any angle to the seam.
    for turn in [0.0, 1.0, FRAC_PI_2, 3.0] {
        let mut body = Body::solid();
        let out = DVec3::new(f64::cos(turn), f64::sin(turn), 0.0);
        let frames = [out, -out].map(|x| Frame3 { origin: DVec3::ZERO, x, y: DVec3::Z, z: x.cross(DVec3::Z) });
        let [a, b] = frames.map(|f| body.arc(&f, radius, -FRAC_PI_2, FRAC_PI_2));
        body.face(sphere(radius), vec![vec![a.along(), b.against()]], false);
        let inwards = frame(DVec3::ZERO, -out.cross(DVec3::Z), out);
        body.flat(frame(DVec3::ZERO, -inwards.z, out), vec![vec![a.along(), b.against()]]);
        Ladder::solid(body.finish(), 0.5 * ball(radius), 3.0 * PI * radius * radius).assert_climbs();
    }
}

#[test]
fn a_lune_whose_sides_touch_at_both_poles_and_the_rest() {
    // The second side leaves the meridian as the square of the distance from the pole. Directions there are noise.
    let radius: f64 = 5.0;
    for (turn, bulge) in [(0.0, 1.0), (0.0, -1.0), (1.0, 0.3), (FRAC_PI_2, -0.05), (3.0, 2.0)] {
        for rest in [false, true] {
            let mut body = Body::sheet();
            let at = |u: f64, v: f64| radius * DVec3::new(v.cos() * u.cos(), v.cos() * u.sin(), v.sin());
            let out = DVec3::new(f64::cos(turn), f64::sin(turn), 0.0);
            let meridian = Frame3 { origin: DVec3::ZERO, x: out, y: DVec3::Z, z: out.cross(DVec3::Z) };
            let straight = body.arc(&meridian, radius, -FRAC_PI_2, FRAC_PI_2);
            let side = |v: f64| at(turn + bulge * v.cos().powi(2), v);
            let curved = body.spline(through(side, (-FRAC_PI_2, FRAC_PI_2), 64));
            let [east, west] = if (bulge > 0.0) != rest { [curved, straight] } else { [straight, curved] };
            body.face(sphere(radius), vec![vec![east.along(), west.against()]], false);
            let lune = radius * radius * bulge.abs() * 4.0 / 3.0;
            let area = if rest { 4.0 * PI * radius * radius - lune } else { lune };
            Ladder::sheet(body.finish(), area).named((turn, bulge, rest)).assert_climbs();
        }
    }
}

#[test]
fn caps_through_the_pole_and_near_it() {
    // A plane section whose circle passes through the north pole, or misses it by a little on either side.
    let radius: f64 = 5.0;
    let tilt: f64 = 0.6;
    for miss in [0.0, 1e-7, -1e-7, 1e-2, -1e-2] {
        let axis = DVec3::new(tilt.sin(), 0.0, tilt.cos());
        let h = radius * (tilt + miss).cos();
        let plane = frame(axis * h, axis, DVec3::Y);
        for keep_cap in [true, false] {
            let mut body = Body::solid();
            let ring = (radius * radius - h * h).sqrt();
            let circle = body.circle(&plane, ring);
            let (round, flat) = if keep_cap { (circle.along(), plane) } else { (circle.against(), plane) };
            body.face(sphere(radius), vec![vec![round]], false);
            body.face(Surface::Plane { frame: flat }, vec![vec![circle.along()]], keep_cap);
            let small = cap(radius, radius - h);
            let volume = if keep_cap { small } else { ball(radius) - small };
            let zone = TAU * radius * if keep_cap { radius - h } else { radius + h };
            Ladder::solid(body.finish(), volume, zone + PI * ring * ring).named((miss, keep_cap)).assert_climbs();
        }
    }
}

#[test]
fn thin_belts_past_both_poles() {
    let radius: f64 = 10.0;
    for (half, x) in [(0.05, DVec3::Z), (0.005, DVec3::Z), (0.002, DVec3::X)] {
        let mut body = Body::solid();
        let rim = (radius * radius - half * half).sqrt();
        let [low, high] = [-half, half].map(|y| body.circle(&frame(DVec3::Y * y, DVec3::Y, x), rim));
        body.face(sphere(radius), vec![vec![low.along()], vec![high.against()]], false);
        body.flat(frame(DVec3::Y * half, DVec3::Y, x), vec![vec![high.along()]]);
        body.flat(frame(DVec3::Y * -half, DVec3::NEG_Y, x), vec![vec![low.against()]]);
        let volume = TAU * half * (radius * radius - half * half / 3.0);
        let area = 2.0 * TAU * radius * half + TAU * rim * rim;
        Ladder::solid(body.finish(), volume, area).named((half, x)).chord(1e-3 * radius).assert_climbs();
    }
}

#[test]
fn antipodal_holes_over_the_poles_across_the_seam_and_oblique() {
    let (radius, bore): (f64, f64) = (5.0, 2.0);
    let h = (radius * radius - bore * bore).sqrt();
    for axis in [DVec3::Z, DVec3::X, -DVec3::Y, DVec3::new(0.4, 0.1, 0.9), DVec3::new(0.3, 0.0, 1.0)] {
        let axis = axis.normalize();
        let reference = axis.any_orthonormal_vector();
        let ends = [h, -h].map(|z| frame(axis * z, axis, reference));
        let mut body = Body::solid();
        let [top, bottom] = ends.map(|f| body.circle(&f, bore));
        body.face(sphere(radius), vec![vec![top.against()], vec![bottom.along()]], false);
        let bore_side = Surface::Cylinder { frame: frame(DVec3::ZERO, axis, reference), radius: bore };
        body.face(bore_side, vec![vec![bottom.along()], vec![top.against()]], true);
        // The napkin ring: its volume is that of a ball of its height.
        Ladder::solid(body.finish(), ball(h), 4.0 * PI * radius * h + TAU * bore * 2.0 * h).assert_climbs();
    }
}

#[test]
fn many_holes_in_different_places() {
    // Over both poles, across the seam, next to it, tangent to the seam from both sides.
    let radius: f64 = 5.0;
    let open: f64 = 0.25;
    let spots = [
        (0.0, FRAC_PI_2),
        (0.0, -FRAC_PI_2),
        (0.0, 0.0),
        (0.25, 0.8),
        (TAU - 0.25, -0.8),
        (PI, 0.1),
        (2.0, 1.0),
        (4.0, -1.0),
    ];
    let mut body = Body::solid();
    let mut loops = Vec::new();
    for (u, v) in spots {
        let axis = DVec3::new(f64::cos(u) * f64::cos(v), f64::sin(u) * f64::cos(v), f64::sin(v));
        let plane = frame(axis * radius * open.cos(), axis, axis.any_orthonormal_vector());
        let circle = body.circle(&plane, radius * open.sin());
        loops.push(vec![circle.against()]);
        body.flat(plane, vec![vec![circle.along()]]);
    }
    body.face(sphere(radius), loops, false);
    let count = spots.len() as f64;
    let height = radius * (1.0 - open.cos());
    let volume = ball(radius) - count * cap(radius, height);
    let area = 4.0 * PI * radius * radius + count * (PI * (radius * open.sin()).powi(2) - TAU * radius * height);
    Ladder::solid(body.finish(), volume, area).assert_climbs();
}

fn torus(major: f64, minor: f64) -> Surface {
    Surface::Torus { frame: Frame3::WORLD, major, minor }
}

/// The circle v ↦ S(u, v) of a torus.
fn tube_circle(body: &mut Body, major: f64, minor: f64, u: f64) -> EdgeId {
    let out = DVec3::new(u.cos(), u.sin(), 0.0);
    let f = Frame3 { origin: out * major, x: out, y: DVec3::Z, z: out.cross(DVec3::Z) };
    body.circle(&f, minor)
}

#[test]
fn whole_tori_thin_and_fat_with_and_without_edges() {
    for (major, minor) in [(8.0, 3.0), (1000.0, 1.0), (1.0, 0.999), (1e-2, 4e-3)] {
        for with_seams in [false, true] {
            let mut body = Body::solid();
            let loops = if with_seams {
                let tube = tube_circle(&mut body, major, minor, 0.0);
                let ring = body.circle(&Frame3::WORLD, major + minor);
                vec![vec![ring.along(), tube.along(), ring.against(), tube.against()]]
            } else {
                Vec::new()
            };
            body.face(torus(major, minor), loops, false);
            let (volume, area) = (TAU * PI * major * minor * minor, TAU * TAU * major * minor);
            Ladder::solid(body.finish(), volume, area)
                .chord(0.2 * minor)
                .pieces(1)
                .named((major, minor))
                .assert_climbs();
        }
    }
}

/// A cylinder with a round edge below. The round part of a torus has a seam, and its loop may run either way:
/// OpenCASCADE writes it clockwise.
#[test]
fn a_loop_with_a_seam_lies_around_what_it_keeps() {
    let (radius, round, height) = (5.0, 2.0, 10.0);
    for backwards in [false, true] {
        let mut body = Body::solid();
        let circles = [(0.0, radius - round), (round, radius), (height, radius)];
        let [low, middle, high] = circles.map(|(z, radius)| body.circle(&level(z), radius));
        let profile = Frame3 { y: DVec3::Z, z: -DVec3::Y, ..level(round) };
        let profile = Frame3 { origin: profile.origin + DVec3::X * (radius - round), ..profile };
        let seam = body.arc(&profile, round, -FRAC_PI_2, 0.0);
        let mut around = vec![low.along(), seam.along(), middle.against(), seam.against()];
        if backwards {
            around.reverse();
            around.iter_mut().for_each(|c| c.reversed ^= true);
        }
        let tube = Surface::Torus { frame: level(round), major: radius - round, minor: round };
        body.face(tube, vec![around], false);
        let side = Surface::Cylinder { frame: Frame3::WORLD, radius };
        body.face(side, vec![vec![middle.along()], vec![high.against()]], false);
        body.face(Surface::Plane { frame: level(0.0) }, vec![vec![low.against()]], true);
        body.face(Surface::Plane { frame: level(height) }, vec![vec![high.along()]], false);
        let (volume, area) = (PI * (223.0 + 1.0 / 3.0 + 6.0 * PI), 122.0 * PI + 6.0 * PI * PI);
        Ladder::solid(body.finish(), volume, area).pieces(1).named(backwards).assert_climbs();
    }
}

#[test]
fn closed_surfaces_cut_along_one_circle_have_a_loop_for_each_side() {
    let (major, minor) = (8.0, 3.0);
    let ring = (torus(major, minor), TAU * PI * major * minor * minor, TAU * TAU * major * minor);
    let whole = (sphere(minor), ball(minor), 4.0 * PI * minor * minor);
    type Cut = fn(&mut Body, f64, f64) -> EdgeId;
    let cuts: [(&'static str, _, Cut); 4] = [
        ("tube", ring.clone(), |body, major, minor| tube_circle(body, major, minor, 0.0)),
        ("tube off the seam", ring.clone(), |body, major, minor| tube_circle(body, major, minor, 2.0)),
        ("ring", ring, |body, major, minor| body.circle(&Frame3::WORLD, major + minor)),
        ("equator", whole, |body, _, minor| body.circle(&Frame3::WORLD, minor)),
    ];
    for (name, (surface, volume, area), cut) in cuts {
        for swapped in [false, true] {
            let mut body = Body::solid();
            let circle = cut(&mut body, major, minor);
            let mut loops = vec![vec![circle.along()], vec![circle.against()]];
            if swapped {
                loops.reverse();
            }
            body.face(surface.clone(), loops, false);
            let ladder = Ladder::solid(body.finish(), volume, area).pieces(1).named((name, swapped));
            ladder.told(&["edges-run-both-ways"]).assert_climbs();
        }
    }
}

#[test]
fn a_line_marked_on_a_face_bounds_nothing() {
    let (radius, size) = (1.0, DVec3::new(8.0, 6.0, 2.0));
    let mut body = Body::solid();
    let circles = [-2.0, 2.0].map(|x| {
        let frame = Frame3 { origin: DVec3::new(4.0 + x, 3.0, size.z), ..Frame3::WORLD };
        body.circle(&frame, radius)
    });
    let marks = circles.iter().flat_map(|circle| [vec![circle.against()], vec![circle.along()]]).collect();
    body.cuboid(DVec3::ZERO, size, marks, Vec::new());
    let area = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
    Ladder::solid(body.finish(), size.element_product(), area).pieces(1).told(&["edges-run-both-ways"]).assert_climbs();
    // Two cuts, and nothing else that bounds the surface.
    let mut body = Body::solid();
    let tropics = [-1.0, 1.0].map(|z| body.circle(&level(z), 8.0_f64.sqrt()));
    let cuts = tropics.iter().flat_map(|circle| [vec![circle.along()], vec![circle.against()]]).collect();
    body.face(sphere(3.0), cuts, false);
    Ladder::solid(body.finish(), ball(3.0), 36.0 * PI).pieces(1).told(&["edges-run-both-ways"]).assert_climbs();
}

#[test]
fn a_tube_cut_around_its_middle_is_one_band() {
    let (radius, height) = (3.0, 10.0);
    let mut body = Body::solid();
    let [low, middle, high] = [0.0, 4.0, height].map(|z| body.circle(&level(z), radius));
    let loops = [low.along(), middle.against(), middle.along(), high.against()].map(|c| vec![c]).to_vec();
    body.face(Surface::Cylinder { frame: Frame3::WORLD, radius }, loops, false);
    body.face(Surface::Plane { frame: level(0.0) }, vec![vec![low.against()]], true);
    body.face(Surface::Plane { frame: level(height) }, vec![vec![high.along()]], false);
    let (volume, area) = (PI * radius * radius * height, TAU * radius * (height + radius));
    Ladder::solid(body.finish(), volume, area).pieces(1).told(&["edges-run-both-ways"]).assert_climbs();
}

#[test]
fn pipe_bends_across_the_seam_and_next_to_it() {
    let (major, minor) = (8.0, 3.0);
    for (from, to) in [(0.0, FRAC_PI_2), (-1.0, 1.0), (5.0, 5.5), (1.0, 1.0 + 0.9 * TAU), (0.0, PI)] {
        let mut body = Body::solid();
        let [a, b] = [from, to].map(|u| tube_circle(&mut body, major, minor, u));
        body.face(torus(major, minor), vec![vec![a.against()], vec![b.along()]], false);
        for (circle, u, sign) in [(a, from, -1.0), (b, to, 1.0)] {
            let out = DVec3::new(f64::cos(u), f64::sin(u), 0.0);
            let coedge: Coedge = if sign > 0.0 { circle.against() } else { circle.along() };
            body.flat(frame(out * major, DVec3::Z.cross(out) * sign, out), vec![vec![coedge]]);
        }
        let turned = to - from;
        let area = turned * major * TAU * minor + TAU * minor * minor;
        Ladder::solid(body.finish(), turned * major * PI * minor * minor, area).assert_climbs();
    }
}

#[test]
fn rings_cut_once_around() {
    // The upper half, the outer half, and a narrow strip of a torus, each closed by planes or ruled surfaces.
    let (major, minor) = (8.0, 3.0);
    let mut body = Body::solid();
    let [inner, outer] = [major - minor, major + minor].map(|r| body.circle(&Frame3::WORLD, r));
    body.face(torus(major, minor), vec![vec![outer.along()], vec![inner.against()]], false);
    body.face(Surface::Plane { frame: Frame3::WORLD }, vec![vec![outer.along()], vec![inner.against()]], true);
    let (volume, area) = (TAU * PI * major * minor * minor, TAU * TAU * major * minor);
    Ladder::solid(body.finish(), 0.5 * volume, 0.5 * area + TAU * 2.0 * major * minor).assert_climbs();

    let mut body = Body::solid();
    let [low, high] = [-minor, minor].map(|z| body.circle(&level(z), major));
    body.face(torus(major, minor), vec![vec![low.along()], vec![high.against()]], false);
    let core = Surface::Cylinder { frame: Frame3::WORLD, radius: major };
    body.face(core, vec![vec![low.along()], vec![high.against()]], true);
    // The centroid of the half disc lies 4 r / 3π from its straight side, that of the half circle 2 r / π.
    let volume = TAU * (major + 4.0 * minor / (3.0 * PI)) * 0.5 * PI * minor * minor;
    let area = TAU * (major + 2.0 * minor / PI) * PI * minor + TAU * major * 2.0 * minor;
    Ladder::solid(body.finish(), volume, area).assert_climbs();
}

#[test]
fn windows_in_a_torus_anywhere() {
    // A window between four parameter lines across no seam, one seam, or both; with and without seam edges.
    let (major, minor): (f64, f64) = (8.0, 3.0);
    let places = [(1.0, 1.0), (-0.3, 1.0), (1.0, -0.4), (-0.3, -0.4), (3.0, 3.0)];
    for ((u0, v0), with_seams) in places.into_iter().flat_map(|place| [(place, false), (place, true)]) {
        let (u1, v1) = (u0 + 0.8, v0 + 0.9);
        let mut body = Body::sheet();
        let ring = |body: &mut Body, v: f64| {
            let f = level(minor * v.sin());
            body.arc(&f, major + minor * v.cos(), u0, u1)
        };
        let tube = |body: &mut Body, u: f64| {
            let out = DVec3::new(u.cos(), u.sin(), 0.0);
            let f = Frame3 { origin: out * major, x: out, y: DVec3::Z, z: out.cross(DVec3::Z) };
            body.arc(&f, minor, v0, v1)
        };
        let (south, north) = (ring(&mut body, v0), ring(&mut body, v1));
        let (west, east) = (tube(&mut body, u0), tube(&mut body, u1));
        let window = vec![west.along(), north.along(), east.against(), south.against()];
        let mut loops = vec![window];
        if with_seams {
            let [tube, ring] = [tube_circle(&mut body, major, minor, 0.0), body.circle(&Frame3::WORLD, major + minor)];
            loops.insert(0, vec![ring.along(), tube.along(), ring.against(), tube.against()]);
        }
        body.face(torus(major, minor), loops, false);
        let told: &[&'static str] = if with_seams && (u0 < 0.0 || v0 < 0.0) { &["edges-run-both-ways"] } else { &[] };
        let hole = (u1 - u0) * minor * (major * (v1 - v0) + minor * (v1.sin() - v0.sin()));
        Ladder::sheet(body.finish(), TAU * TAU * major * minor - hole).named((u0, v0)).told(told).assert_climbs();
    }
}

#[test]
fn windows_in_a_cylinder_and_a_sphere_across_a_stated_seam() {
    let (radius, height) = (5.0, 12.0);
    // Two windows have a side on the seam, with which their wires may begin.
    let sides = [0.4, -0.4].into_iter().flat_map(|u| (0..4).map(move |first| (u, first)));
    for (u, first) in [(0.0, 0), (0.2, 0), (2.0, 0)].into_iter().chain(sides) {
        let mut body = Body::sheet();
        let [low, high] = [0.0, height].map(|z| body.circle(&level(z), radius));
        let seam = body.line(DVec3::X * radius, DVec3::new(radius, 0.0, height));
        let back = Coedge { reversed: !seam.reversed, ..seam };
        let mut window = body.window(radius, (u - 0.4, u + 0.4), (3.0, 7.0));
        window.rotate_left(first);
        let loops = vec![vec![low.along(), seam, high.against(), back], window];
        body.face(Surface::Cylinder { frame: Frame3::WORLD, radius }, loops, false);
        let told: &[&'static str] = if u.abs() < 0.4 { &["edges-run-both-ways"] } else { &[] };
        let area = TAU * radius * height - 0.8 * radius * 4.0;
        Ladder::sheet(body.finish(), area).named((u, first)).told(told).assert_climbs();
    }
    // A round window about the end of the x axis, across the middle of a sphere's seam.
    let mut body = Body::sheet();
    let half = seam(&mut body, radius);
    let window = body.circle(&frame(DVec3::X * 4.0, DVec3::X, DVec3::Y), 3.0);
    body.face(sphere(radius), vec![vec![half.along(), half.against()], vec![window.against()]], false);
    Ladder::sheet(body.finish(), 4.0 * PI * radius * radius - TAU * radius)
        .told(&["edges-run-both-ways"])
        .assert_climbs();
}

/// A meridian arc about (x = `major`, z = 0), turned about z. Volume and area by integration.
fn turned_arc(major: f64, minor: f64, from: f64, to: f64) -> (Surface, f64, f64) {
    let f = Frame3 { origin: DVec3::X * major, x: DVec3::X, y: DVec3::Z, z: -DVec3::Y };
    let surface = Surface::Revolution { curve: NurbsCurve3::arc(&f, minor, minor, from, to), frame: Frame3::WORLD };
    let rho = |t: f64| major + minor * t.cos();
    let volume = integral(|t| PI * rho(t) * rho(t) * minor * t.cos(), (from, to));
    (surface, volume, integral(|t| TAU * rho(t).abs() * minor, (from, to)))
}

#[test]
fn apples_lemons_and_horns() {
    // The outer part of a self-intersecting torus, its inner part, and the torus that touches itself.
    let (major, minor): (f64, f64) = (2.0, 3.0);
    let rim = PI - (major / minor).acos();
    for (major, minor, from, to) in
        [(major, minor, -rim, rim), (-major, minor, rim - PI, PI - rim), (3.0, 3.0, -PI, PI)]
    {
        let mut body = Body::new(ShellKind::Outer);
        let (surface, volume, area) = turned_arc(major, minor, from, to);
        body.face(surface, Vec::new(), false);
        Ladder::solid(body.finish(), volume, area).pieces(1).assert_climbs();
    }
}

#[test]
fn a_ring_wound_past_its_start() {
    // Either end lies on the other turn, too, and nearer to the middle of a span there.
    let (major, minor) = (20.0, 5.0);
    for past in [0.3, 0.9, 2.0, 6.0] {
        let turn = TAU + past;
        let (surface, _) = torus(major, minor).to_nurbs((0.0, turn), (0.0, TAU));
        let row = surface.count_v();
        let seam = NurbsCurve3 {
            degree: surface.degree_u,
            knots: surface.knots_u.clone(),
            points: surface.points.iter().step_by(row).copied().collect(),
            weights: surface.weights.iter().step_by(row).copied().collect(),
        };
        let mut body = Body::solid();
        let [first, end] = [0.0, turn].map(|u| tube_circle(&mut body, major, minor, u));
        let seam = body.spline(seam);
        let around = vec![seam.along(), end.along(), seam.against(), first.against()];
        body.face(Surface::Nurbs(surface), vec![around], false);
        for (u, sign, circle) in [(0.0_f64, -1.0, first.along()), (turn, 1.0, end.against())] {
            let (out, along) = (DVec3::new(u.cos(), u.sin(), 0.0), DVec3::new(-u.sin(), u.cos(), 0.0));
            body.flat(frame(major * out, sign * along, out), vec![vec![circle]]);
        }
        let (volume, area) = (PI * minor * minor * major * turn, TAU * minor * (major * turn + minor));
        Ladder::solid(body.finish(), volume, area).named(past).assert_climbs();
    }
}

#[test]
fn circles_around_a_ring_without_period_do_not_close() {
    // Each ends one turn further than it starts, at the same point of space; or at the end of the surface it leaps back
    // by a turn.
    let (major, minor) = (20.0, 5.0);
    for (turns, start) in [(2.0, 0.5), (3.0, 0.5), (3.0, 3.0), (3.0, 5.0), (1.0 + 2.0 / TAU, 0.5)] {
        let (surface, _) = torus(major, minor).to_nurbs((0.0, turns * TAU), (0.0, TAU));
        let mut body = Body::sheet();
        let [low, high] = [-0.5_f64, 0.5].map(|v| {
            let turned = DVec3::new(f64::cos(start), f64::sin(start), 0.0);
            body.circle(&frame(DVec3::Z * minor * v.sin(), DVec3::Z, turned), major + minor * v.cos())
        });
        body.face(Surface::Nurbs(surface), vec![vec![low.along()], vec![high.against()]], false);
        let prepared = prepared(body.finish());
        let misses = prepared.diagnostics.iter().filter(|d| d.kind.code() == "loop-misses-start");
        let told: Vec<Severity> = misses.map(|d| d.severity).collect();
        assert_eq!(told, [Severity::Warning; 2], "{turns} {start} {:#?}", prepared.diagnostics);
    }
}

#[test]
fn a_horn_torus_stated_as_a_torus() {
    let mut body = Body::solid();
    body.face(torus(3.0, 3.0), Vec::new(), false);
    Ladder::solid(body.finish(), TAU * PI * 27.0, TAU * TAU * 9.0).assert_climbs();
}

#[test]
fn halves_of_a_horn_with_a_loop_at_the_cusp() {
    // Both ends of the profile are there. Which of them a half ends at, the direction of its rim tells.
    let mut body = Body::solid();
    let (surface, volume, area) = turned_arc(3.0, 3.0, -PI, PI);
    let (rim, cusp) = (body.circle(&Frame3::WORLD, 6.0), body.vertex(DVec3::ZERO));
    for rim in [rim.along(), rim.against()] {
        body.part.plain_face(surface.clone(), body.shell, vec![Loop::Edges(vec![rim]), Loop::Vertex(cusp)], false);
    }
    Ladder::solid(body.finish(), volume, area).assert_climbs();
}

#[test]
fn a_line_across_the_pole_of_a_disc_of_revolution() {
    let radial = NurbsCurve3 {
        degree: 1,
        knots: vec![0.0, 0.0, 3.0, 3.0],
        points: vec![DVec3::ZERO, DVec3::X * 3.0],
        weights: Vec::new(),
    };
    for angle in [0.3_f64, 1.0, 2.5] {
        let mut body = Body::sheet();
        let end = 3.0 * DVec3::new(angle.cos(), angle.sin(), 0.0);
        let arc = body.arc(&Frame3::WORLD, 3.0, angle, angle + PI);
        let line = body.line(-end, end);
        let disc = Surface::Revolution { curve: radial.clone(), frame: Frame3::WORLD };
        body.face(disc, vec![vec![arc.along(), line]], false);
        Ladder::sheet(body.finish(), 4.5 * PI).named(angle).assert_climbs();
    }
}

#[test]
fn wires_that_run_the_wrong_way_bound_what_ends_with_no_border() {
    // A tube and a dome of surfaces that go on beyond their wires. What lies there would end with the surface.
    let (radius, height) = (3.0, 4.0);
    for wrong in [false, true] {
        let mut body = Body::solid();
        let [foot, top] = [0.0, height].map(|z| body.circle(&level(z), radius));
        let side = DVec3::X * radius;
        let curve = NurbsCurve3::line(side - DVec3::Z, side + DVec3::Z * (height + 1.0));
        let wires = if wrong { [foot.against(), top.along()] } else { [foot.along(), top.against()] };
        let tube = Surface::Revolution { curve, frame: Frame3::WORLD };
        body.face(tube, wires.map(|c| vec![c]).to_vec(), false);
        body.flat(frame(DVec3::ZERO, -DVec3::Z, DVec3::X), vec![vec![foot.against()]]);
        body.flat(level(height), vec![vec![top.along()]]);
        let area = TAU * radius * (height + radius);
        Ladder::solid(body.finish(), PI * radius * radius * height, area).named(("tube", wrong)).assert_climbs();

        let mut body = Body::solid();
        let equator = body.circle(&Frame3::WORLD, radius);
        let curve = NurbsCurve3::arc(&meridian(), radius, radius, -0.5, FRAC_PI_2);
        let wire = if wrong { equator.against() } else { equator.along() };
        body.face(Surface::Revolution { curve, frame: Frame3::WORLD }, vec![vec![wire]], false);
        body.flat(frame(DVec3::ZERO, -DVec3::Z, DVec3::X), vec![vec![equator.against()]]);
        Ladder::solid(body.finish(), 0.5 * ball(radius), 3.0 * PI * radius * radius)
            .named(("dome", wrong))
            .assert_climbs();
    }
}
