//! Slots, fillets and drilled walls: long thin faces, intersection curves, and many equal ones.

use crate::body::{Body, frame, integral, level, through};
use crate::ladder::Ladder;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use trimtess::model::{Coedge, Frame3, Surface};

fn at(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

#[test]
fn four_slots_with_round_ends() {
    let (thick, radius, length) = (3.0, 2.0, 9.0);
    let mut body = Body::solid();
    let (mut top, mut bottom) = (Vec::new(), Vec::new());
    for k in 0..4 {
        // The right end's axis, then the left end's, each slot turned by a little.
        let middle = at(0.0, 8.0 * f64::from(k) - 12.0, 0.0);
        let along = at((0.1 * f64::from(k)).cos(), (0.1 * f64::from(k)).sin(), 0.0);
        let across = DVec3::Z.cross(along);
        let ends = [along, -along].map(|x| frame(middle + x * (0.5 * length), DVec3::Z, x));
        let mut rims: Vec<Vec<Coedge>> = vec![Vec::new(), Vec::new()];
        for (e, end) in ends.iter().enumerate() {
            // Counter-clockwise: the half circle, then the straight side to the other end.
            let arcs = [0.0, thick].map(|z| {
                let f = Frame3 { origin: end.origin + DVec3::Z * z, ..*end };
                body.arc(&f, radius, -FRAC_PI_2, FRAC_PI_2)
            });
            let sign = if e == 0 { 1.0 } else { -1.0 };
            let side = across * (sign * radius);
            let (from, to) = (end.origin + side, ends[1 - e].origin + side);
            let lift = DVec3::Z * thick;
            let lines = [DVec3::ZERO, lift].map(|up| body.line(from + up, to + up));
            let (west, east) = (body.line(from, from + lift), body.line(to, to + lift));
            let start = end.origin - side;
            let south = body.line(start, start + lift);
            let wall = Surface::Cylinder { frame: *end, radius };
            let round = vec![arcs[0].along(), west, arcs[1].against(), south.edge.against()];
            body.face(wall, vec![round], true);
            let plane = frame(from, -across * sign, to - from);
            let flat = [lines[0], east, turned(&lines[1]), turned(&west)];
            body.flat(plane, vec![flat.iter().rev().map(turned).collect()]);
            for (rim, (arc, line)) in rims.iter_mut().zip(arcs.iter().zip(&lines)) {
                rim.extend([arc.along(), *line]);
            }
        }
        bottom.push(rims[0].clone());
        top.push(rims[1].iter().rev().map(turned).collect());
    }
    body.cuboid(at(-10.0, -20.0, 0.0), at(10.0, 20.0, thick), top, bottom);
    let slot = 2.0 * radius * length + PI * radius * radius;
    let around = 2.0 * length + TAU * radius;
    let area = 2.0 * (800.0 - 4.0 * slot) + 120.0 * thick + 4.0 * around * thick;
    Ladder::solid(body.finish(), (800.0 - 4.0 * slot) * thick, area).assert_climbs();
}

/// The same edge in the other direction.
fn turned(c: &Coedge) -> Coedge {
    Coedge { reversed: !c.reversed, ..*c }
}

#[test]
fn a_block_with_all_edges_and_corners_rounded() {
    for radius in [1e-2, 1.0, 20.0] {
        let size = at(100.0, 60.0, 50.0);
        let mut body = Body::solid();
        let inner = size - DVec3::splat(2.0 * radius);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        // The centre of the corner ball at the given signs.
        let centre = |s: DVec3| 0.5 * inner * s;
        let signs = [-1.0, 1.0];
        // One quarter arc for each corner and each axis it turns about, from the next axis to the one after.
        let mut arcs = std::collections::BTreeMap::new();
        let key = |s: DVec3| s.to_array().map(|x| x > 0.0);
        let corners: Vec<DVec3> = (0..8).map(|k| at(signs[k & 1], signs[k >> 1 & 1], signs[k >> 2])).collect();
        for &s in &corners {
            for a in 0..3 {
                let (b, c) = ((a + 1) % 3, (a + 2) % 3);
                let (x, y) = (axes[b] * s[b], axes[c] * s[c]);
                let f = Frame3 { origin: centre(s), x, y, z: x.cross(y) };
                arcs.insert((key(s), a), body.arc(&f, radius, 0.0, FRAC_PI_2));
            }
        }
        for &s in &corners {
            let ball = Surface::Sphere { frame: Frame3 { origin: centre(s), ..Frame3::WORLD }, radius };
            let odd = s.x * s.y * s.z < 0.0;
            let mut round: Vec<Coedge> = (0..3).map(|a| arcs[&(key(s), (a + 2) % 3)].along()).collect();
            if odd {
                round = round.iter().rev().map(turned).collect();
            }
            body.face(ball, vec![round], false);
        }
        for a in 0..3 {
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            for (sb, sc) in [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
                let mut s = axes[b] * sb + axes[c] * sc - axes[a];
                let low = s;
                s[a] = 1.0;
                let strip = Surface::Cylinder { frame: frame(centre(low), axes[a], axes[b]), radius };
                let (x, y) = (axes[b] * (sb * radius), axes[c] * (sc * radius));
                let (first, second) =
                    (body.line(centre(low) + x, centre(s) + x), body.line(centre(low) + y, centre(s) + y));
                let (foot, head) = (arcs[&(key(low), a)], arcs[&(key(s), a)]);
                let mut round = vec![foot.along(), second, head.against(), turned(&first)];
                if sb * sc < 0.0 {
                    round = round.iter().rev().map(turned).collect();
                }
                body.face(strip, vec![round], false);
            }
            for sign in signs {
                let corner =
                    |p: f64, q: f64| centre(axes[a] * sign + axes[b] * p + axes[c] * q) + axes[a] * (sign * radius);
                let mut corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
                if sign < 0.0 {
                    corners.reverse();
                }
                body.side(&corners, Vec::new());
            }
        }
        // Steiner's formula for the set of points within the radius of the inner box.
        let (faces, edges) = (inner.x * inner.y + inner.y * inner.z + inner.z * inner.x, inner.x + inner.y + inner.z);
        let volume = inner.x * inner.y * inner.z
            + 2.0 * faces * radius
            + PI * edges * radius * radius
            + 4.0 / 3.0 * PI * radius.powi(3);
        let area = 2.0 * faces + TAU * edges * radius + 4.0 * PI * radius * radius;
        Ladder::solid(body.finish(), volume, area).named(radius).assert_climbs();
    }
}

#[test]
fn a_pin_with_a_tiny_round_at_its_rim() {
    // A quarter of a torus, five thousand times as long as wide. Long pins are cut open at their rounds, but locate
    // points on the common circle less precisely.
    for (big, small, height) in
        [(50.0, 1e-2, 30.0), (50.0, 1e-4, 30.0), (5.0, 4.999, 8.0), (5.0, 0.5, 107.1), (5.0, 0.5, 1000.0)]
    {
        let mut body = Body::solid();
        let [foot, shoulder] = [0.0, height - small].map(|z| body.circle(&level(z), big));
        let rim = body.circle(&level(height), big - small);
        let wall = Surface::Cylinder { frame: Frame3::WORLD, radius: big };
        body.face(wall, vec![vec![foot.along()], vec![shoulder.against()]], false);
        let round = Surface::Torus { frame: level(height - small), major: big - small, minor: small };
        body.face(round, vec![vec![shoulder.along()], vec![rim.against()]], false);
        body.face(Surface::Plane { frame: Frame3::WORLD }, vec![vec![foot.along()]], true);
        body.flat(level(height), vec![vec![rim.along()]]);
        let rho = |z: f64| big - small + (small * small - z * z).max(0.0).sqrt();
        let turned = integral(|t: f64| PI * rho(small * t.sin()).powi(2) * small * t.cos(), (0.0, FRAC_PI_2));
        let side = integral(|t: f64| TAU * (big - small + small * t.cos()) * small, (0.0, FRAC_PI_2));
        let area = TAU * big * (height - small) + side + PI * (big * big + (big - small).powi(2));
        let volume = PI * big * big * (height - small) + turned;
        Ladder::solid(body.finish(), volume, area).named((big, small)).assert_climbs();
    }
}

/// The volume that a hole of radius `r` straight through a rod of radius `big` removes.
fn drilled(big: f64, r: f64) -> f64 {
    // 8 ∫ √(R² - y²) √(r² - y²) dy, with y = r sin t.
    8.0 * integral(|t| (big * big - (r * t.sin()).powi(2)).sqrt() * (r * t.cos()).powi(2), (0.0, FRAC_PI_2))
}

#[test]
fn a_hole_drilled_through_the_wall_of_a_rod() {
    // Both rims are splines that lie on two cylinders; each face has its own images of them.
    for (big, r, length) in [(10.0, 3.0, 40.0), (10.0, 9.9, 40.0), (10.0, 0.05, 40.0)] {
        for turn in [0.0, 1.0, FRAC_PI_2] {
            let mut body = Body::solid();
            let (out, across) = (at(f64::cos(turn), f64::sin(turn), 0.0), at(-f64::sin(turn), f64::cos(turn), 0.0));
            let [foot, head] = [-0.5 * length, 0.5 * length].map(|z| body.circle(&level(z), big));
            let rim = |sign: f64| {
                move |t: f64| {
                    let y = r * t.sin();
                    out * (sign * (big * big - y * y).sqrt()) + across * y + DVec3::Z * (r * t.cos())
                }
            };
            let count = if r > 9.0 { 512 } else { 64 };
            let [front, back] = [1.0, -1.0].map(|s| body.spline(through(rim(s), (0.0, TAU), count)));
            let rod = Surface::Cylinder { frame: Frame3::WORLD, radius: big };
            // Seen from outside, the front rim runs clockwise.
            let loops = vec![vec![foot.along()], vec![head.against()], vec![front.along()], vec![back.against()]];
            body.face(rod, loops, false);
            let bore = Surface::Cylinder { frame: frame(DVec3::ZERO, out, DVec3::Z), radius: r };
            body.face(bore, vec![vec![front.against()], vec![back.along()]], true);
            body.face(Surface::Plane { frame: level(-0.5 * length) }, vec![vec![foot.along()]], true);
            body.flat(level(0.5 * length), vec![vec![head.along()]]);
            let volume = PI * big * big * length - drilled(big, r);
            // The bore's wall is 2 √(R² - y²) long; the window in the rod is as high as the bore at each angle.
            let bore = integral(|t| 2.0 * (big * big - (r * t.sin()).powi(2)).sqrt() * r, (0.0, TAU));
            let window = integral(
                |t| 4.0 * big * r * r * t.cos().powi(2) / (big * big - (r * t.sin()).powi(2)).sqrt(),
                (0.0, FRAC_PI_2),
            );
            let area = TAU * big * (length + big) + bore - 2.0 * window;
            Ladder::solid(body.finish(), volume, area).named((big, r, turn)).assert_climbs();
        }
    }
}

#[test]
fn a_fillet_around_a_cylinder_continues_its_neighbours_whatever_its_sense() {
    let (radius, small, height) = (5.0, 1.0, 9.0);
    let major = radius - small;
    // Its sense and its wires may be as they should, or not.
    for [sense, wires] in [[false, false], [true, true], [false, true]] {
        let mut body = Body::solid();
        let foot = body.circle(&Frame3::WORLD, radius);
        let rim = body.circle(&level(height), radius);
        let top = body.circle(&level(height + small), major);
        body.flat(frame(DVec3::ZERO, -DVec3::Z, DVec3::X), vec![vec![foot.against()]]);
        let wall = Surface::Cylinder { frame: Frame3::WORLD, radius };
        body.face(wall, vec![vec![foot.along()], vec![rim.against()]], false);
        let loops = if wires { [rim.against(), top.along()] } else { [rim.along(), top.against()] };
        let fillet = Surface::Torus { frame: level(height), major, minor: small };
        body.face(fillet, loops.map(|c| vec![c]).to_vec(), sense);
        body.flat(level(height + small), vec![vec![top.along()]]);
        let ring = major * major + FRAC_PI_2 * major * small + 2.0 / 3.0 * small * small;
        let volume = PI * (radius * radius * height + ring * small);
        let sides = radius * radius + 2.0 * radius * height + major * major;
        let area = PI * sides + TAU * small * (major * FRAC_PI_2 + small);
        let told: &[&str] = if wires { &["wire-folds-back"] } else { &[] };
        Ladder::solid(body.finish(), volume, area).named([sense, wires]).told(told).assert_climbs();
    }
}

#[test]
fn a_shallow_lens_is_no_fillet_that_lies_on_its_neighbour() {
    let aperture: f64 = 5.0;
    for turn in [0.1_f64, 0.02] {
        let radius = aperture / turn.sin();
        let mut body = Body::solid();
        let rim = [0.0, PI].map(|from| body.arc(&Frame3::WORLD, aperture, from, from + PI));
        let back = vec![rim[1].against(), rim[0].against()];
        body.flat(frame(DVec3::ZERO, -DVec3::Z, DVec3::X), vec![back]);
        let ball = Surface::Sphere { frame: level(-radius * turn.cos()), radius };
        body.face(ball, vec![rim.map(|arc| arc.along()).to_vec()], false);
        let height = radius * (1.0 - turn.cos());
        let volume = PI * height * height * (radius - height / 3.0);
        let area = PI * aperture * aperture + TAU * radius * height;
        Ladder::solid(body.finish(), volume, area).named(turn).assert_climbs();
    }
}
