//! Cones and countersinks: faces that other kernels leave without triangles, some only at fine tolerances.

use crate::body::{Body, frame, frustum, level, through};
use crate::ladder::Ladder;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_4, PI, SQRT_2, TAU};
use trimtess::model::{Frame3, Loop, Part, Surface};

/// The cone about z through the circles of radius `low` at z = 0 and `high` at z = `height`.
fn side(low: f64, high: f64, height: f64) -> Surface {
    Surface::Cone { frame: Frame3::WORLD, radius: low, half_angle: ((high - low) / height).atan() }
}

#[test]
fn a_countersink_of_90_degrees_in_a_plate() {
    let mut body = Body::solid();
    let [top, middle, bottom] = [(6.0, 4.0), (4.0, 2.0), (0.0, 2.0)].map(|(z, radius)| body.circle(&level(z), radius));
    body.cuboid(
        DVec3::new(-10.0, -10.0, 0.0),
        DVec3::new(10.0, 10.0, 6.0),
        vec![vec![top.against()]],
        vec![vec![bottom.along()]],
    );
    let sink = Surface::Cone { frame: level(4.0), radius: 2.0, half_angle: FRAC_PI_4 };
    body.face(sink, vec![vec![middle.along()], vec![top.against()]], true);
    let bore = Surface::Cylinder { frame: Frame3::WORLD, radius: 2.0 };
    body.face(bore, vec![vec![bottom.along()], vec![middle.against()]], true);
    let (cone, cone_side) = frustum(2.0, 4.0, 2.0);
    let volume = 2400.0 - cone - PI * 16.0;
    let area = 800.0 - PI * (16.0 + 4.0) + 480.0 + cone_side + TAU * 2.0 * 4.0;
    Ladder::solid(body.finish(), volume, area).assert_climbs();
}

#[test]
fn a_blind_hole_ends_in_the_drills_point() {
    let (radius, depth) = (3.0, 10.0);
    let point = radius / 59.0_f64.to_radians().tan();
    let mut body = Body::solid();
    let [mouth, ground] = [20.0, 20.0 - depth].map(|z| body.circle(&level(z), radius));
    body.cuboid(DVec3::new(-8.0, -8.0, 0.0), DVec3::new(8.0, 8.0, 20.0), vec![vec![mouth.against()]], Vec::new());
    let wall = Surface::Cylinder { frame: Frame3::WORLD, radius };
    body.face(wall, vec![vec![ground.along()], vec![mouth.against()]], true);
    let tip = body.vertex(DVec3::Z * (20.0 - depth - point));
    let cone = Surface::Cone { frame: level(20.0 - depth), radius, half_angle: (radius / point).atan() };
    body.part.plain_face(cone, body.shell, vec![Loop::Edges(vec![ground.against()]), Loop::Vertex(tip)], true);
    let (cone, cone_side) = frustum(radius, 0.0, point);
    let area = 2.0 * 256.0 + 4.0 * 16.0 * 20.0 - PI * 9.0 + TAU * radius * depth + cone_side;
    Ladder::solid(body.finish(), 256.0 * 20.0 - PI * 9.0 * depth - cone, area).assert_climbs();
}

#[test]
fn frustums_with_and_without_a_seam_either_way_up() {
    for (low, high) in [(4.0, 1.0), (1.0, 4.0), (4.0, 3.999), (4.0, 1e-3)] {
        for seam in [true, false] {
            let height = 5.0;
            let mut body = Body::solid();
            let [foot, head] = [(0.0, low), (height, high)].map(|(z, radius)| body.circle(&level(z), radius));
            let loops = if seam {
                let line = body.line(DVec3::X * low, DVec3::new(high, 0.0, height));
                vec![vec![foot.along(), line, head.against(), line.edge.against()]]
            } else {
                vec![vec![foot.along()], vec![head.against()]]
            };
            body.face(side(low, high, height), loops, false);
            body.flat(level(height), vec![vec![head.along()]]);
            body.face(Surface::Plane { frame: Frame3::WORLD }, vec![vec![foot.along()]], true);
            let (volume, area) = frustum(low, high, height);
            Ladder::solid(body.finish(), volume, area + PI * (low * low + high * high)).assert_climbs();
        }
    }
}

#[test]
fn a_frustum_may_end_in_a_circle_much_smaller_than_the_face() {
    let (low, height) = (5.0, 10.0);
    for high in [1e-4, 1e-5, 1e-6] {
        for (arcs, seam) in [(1, true), (1, false), (2, true), (2, false)] {
            let mut body = Body::solid();
            let foot = body.circle(&Frame3::WORLD, low);
            let at = |k: i32| TAU * f64::from(k) / f64::from(arcs);
            let head: Vec<_> = (0..arcs).map(|k| body.arc(&level(height), high, at(k), at(k + 1))).collect();
            let [along, against] =
                [head.iter().map(|e| e.along()).collect(), head.iter().rev().map(|e| e.against()).collect::<Vec<_>>()];
            let loops = if seam {
                let line = body.line(DVec3::X * low, DVec3::new(high, 0.0, height));
                vec![[vec![foot.along(), line], against, vec![line.edge.against()]].concat()]
            } else {
                vec![vec![foot.along()], against]
            };
            body.face(side(low, high, height), loops, false);
            body.flat(level(height), vec![along]);
            body.face(Surface::Plane { frame: Frame3::WORLD }, vec![vec![foot.along()]], true);
            let (volume, area) = frustum(low, high, height);
            let area = area + PI * (low * low + high * high);
            Ladder::solid(body.finish(), volume, area).named((high, arcs, seam)).assert_climbs();
        }
    }
}

#[test]
fn a_seam_runs_up_to_the_apex_and_down_again() {
    for (radius, height) in [(5.0, 5.0), (0.1, 10.0), (50.0, 1.0)] {
        let mut body = Body::solid();
        let foot = body.circle(&Frame3::WORLD, radius);
        let seam = body.line(DVec3::X * radius, DVec3::Z * height);
        let down = seam.edge.against();
        body.face(side(radius, 0.0, height), vec![vec![foot.along(), seam, down]], false);
        body.face(Surface::Plane { frame: Frame3::WORLD }, vec![vec![foot.along()]], true);
        let (volume, area) = frustum(radius, 0.0, height);
        Ladder::solid(body.finish(), volume, area + PI * radius * radius).assert_climbs();
    }
}

#[test]
fn a_seam_runs_up_to_an_apex_that_the_loop_passes_closely() {
    // A plane cuts the cone so close to its axis that a short stretch of the seam, up to the apex, is on this side.
    let (radius, height) = (5.0, 20.0);
    let apex = DVec3::Z * height;
    for off in [1e-4, 1e-5, 1e-6, 1e-7].map(|share| share * height) {
        let mut body = Body::sheet();
        let turn = (off / radius).asin();
        let arc = body.arc(&Frame3::WORLD, radius, PI - turn, TAU + turn);
        let cut = |t: f64| DVec3::new(off * t.sinh(), off, height - height / radius * off * t.cosh());
        let reach = (radius * turn.cos() / off).asinh();
        let [right, left] = [(reach, 0.0), (0.0, -reach)].map(|(from, to)| {
            let along = move |share: f64| cut(from + (to - from) * share);
            body.spline(through(along, (0.0, 1.0), 400))
        });
        let (up, down) = (body.line(cut(0.0), apex), body.line(apex, cut(0.0)));
        let boundary = vec![arc.along(), right.along(), up, down, left.along()];
        body.face(side(radius, 0.0, height), vec![boundary], false);
        let below = radius * radius * (PI - (off / radius).acos()) + off * radius * turn.cos();
        Ladder::sheet(body.finish(), below * radius.hypot(height) / radius).named(off).assert_climbs();
    }
}

#[test]
fn a_cone_in_two_halves_and_in_three_thirds() {
    let (radius, height) = (4.0, 7.0);
    // Where a file rounds its numbers, the vertex is not quite the apex.
    let offs = [DVec3::ZERO, DVec3::X * 2e-4, DVec3::new(1e-4, -8e-4, 0.0), DVec3::Z * 5e-4, DVec3::Z * -9e-4];
    for (count, off) in [2, 3].into_iter().flat_map(|count| offs.map(|off| (count, off))) {
        let apex = DVec3::Z * height + off;
        let mut body = Body::solid();
        let at = |k: i32| TAU * f64::from(k) / f64::from(count);
        let arcs: Vec<_> = (0..count).map(|k| body.arc(&Frame3::WORLD, radius, at(k), at(k + 1))).collect();
        for (k, arc) in (0..count).zip(&arcs) {
            let [a, b] = [at(k), at(k + 1)].map(|angle| radius * DVec3::new(angle.cos(), angle.sin(), 0.0));
            let (up, down) = (body.line(b, apex), body.line(apex, a));
            body.face(side(radius, 0.0, height), vec![vec![arc.along(), up, down]], false);
        }
        let foot = arcs.iter().rev().map(|arc| arc.against()).collect();
        body.flat(frame(DVec3::ZERO, -DVec3::Z, DVec3::X), vec![foot]);
        let part = Part { tolerance: 1e-3, ..body.finish() };
        let (volume, area) = frustum(radius, 0.0, height);
        Ladder::solid(part, volume, area + PI * radius * radius).named((count, off)).assert_climbs();
    }
}

#[test]
fn wedges_are_cut_out_of_the_point() {
    let (radius, height) = (4.0, 6.0);
    let (_, whole) = frustum(radius, 0.0, height);
    let wedges: [&[(f64, f64)]; 8] = [
        &[(0.3, 1.5)],
        &[(-0.5, 1.0)],
        &[(2.0, 4.5)],
        &[(0.0, PI)],
        &[(0.3, 1.5), (3.0, 1.0)],
        &[(3.0, 1.0), (0.3, 1.5)],
        &[(-0.5, 1.0), (4.0, 0.5), (2.0, 0.5)],
        &[(0.0, 0.5 * PI), (PI, 0.5 * PI)],
    ];
    for wedges in wedges {
        let mut body = Body::sheet();
        let mut loops = vec![vec![body.circle(&Frame3::WORLD, radius).along()]];
        for &(from, turn) in wedges {
            let arc = body.arc(&level(0.5 * height), 0.5 * radius, from, from + turn);
            let [start, end] =
                [from, from + turn].map(|angle| 0.5 * DVec3::new(angle.cos(), angle.sin(), 0.0) * radius);
            let [start, end] = [start, end].map(|p| p + 0.5 * height * DVec3::Z);
            loops.push(vec![arc.against(), body.line(start, DVec3::Z * height), body.line(DVec3::Z * height, end)]);
        }
        body.face(side(radius, 0.0, height), loops, false);
        // The point is a quarter of the whole.
        let turn: f64 = wedges.iter().map(|wedge| wedge.1).sum();
        Ladder::sheet(body.finish(), whole * (1.0 - 0.25 * turn / TAU)).named(wedges).assert_climbs();
    }
}

#[test]
fn holes_near_the_apex_and_around_it() {
    // On the 45° cone rolled out flat: a disc about a point at slant distance `s` from the apex.
    let turns = 1.0 / SQRT_2;
    let rolled = |s: f64, radius: f64| {
        move |t: f64| {
            let (x, y) = (s + radius * t.cos(), radius * t.sin());
            let (slant, angle) = (x.hypot(y), y.atan2(x) / turns);
            DVec3::new(slant * turns * angle.cos(), slant * turns * angle.sin(), -slant * turns)
        }
    };
    let slant = 10.0;
    // A spline through so few points that it leaves the cone near the apex is accepted, with a diagnostic.
    let coarse = |points: u32| (1.0, 0.999, points);
    for (s, radius, points) in
        [(1.0, 0.9, 2048), (5.0, 2.0, 2048), (1e-2, 9e-3, 2048), coarse(2048), coarse(256), coarse(64)]
    {
        let mut body = Body::sheet();
        let foot = body.circle(&level(-slant * turns), slant * turns);
        let hole = body.spline(through(rolled(s, radius), (0.0, TAU), points));
        let apex = body.vertex(DVec3::ZERO);
        let loops = vec![Loop::Edges(vec![foot.along()]), Loop::Vertex(apex), Loop::Edges(vec![hole.against()])];
        let cone = Surface::Cone { frame: Frame3::WORLD, radius: 0.0, half_angle: -FRAC_PI_4 };
        body.part.plain_face(cone, body.shell, loops, false);
        Ladder::sheet(body.finish(), PI * slant * slant * turns - PI * radius * radius)
            .named((s, radius, points))
            .told(if points == 64 { &["edges-off-surface"] } else { &[] })
            .assert_climbs();
    }
}

#[test]
fn both_nappes_of_one_cone() {
    // An hourglass: two faces of one surface meet in the apex.
    let mut body = Body::solid();
    let rims = [-3.0, 3.0].map(|z| body.circle(&level(z), 3.0));
    let apex = body.vertex(DVec3::ZERO);
    let cone = Surface::Cone { frame: Frame3::WORLD, radius: 0.0, half_angle: FRAC_PI_4 };
    for coedge in [rims[0].along(), rims[1].against()] {
        let loops = vec![Loop::Edges(vec![coedge]), Loop::Vertex(apex)];
        body.part.plain_face(cone.clone(), body.shell, loops, false);
    }
    body.flat(level(3.0), vec![vec![rims[1].along()]]);
    body.face(Surface::Plane { frame: level(-3.0) }, vec![vec![rims[0].along()]], true);
    let (volume, area) = frustum(3.0, 0.0, 3.0);
    Ladder::solid(body.finish(), 2.0 * volume, 2.0 * area + 18.0 * PI).assert_climbs();
}

#[test]
fn one_face_through_the_apex() {
    let mut body = Body::sheet();
    let rims = [-3.0, 3.0].map(|z| body.circle(&level(z), 3.0));
    let cone = Surface::Cone { frame: Frame3::WORLD, radius: 0.0, half_angle: FRAC_PI_4 };
    body.face(cone, vec![vec![rims[0].along()], vec![rims[1].against()]], false);
    Ladder::sheet(body.finish(), 2.0 * frustum(3.0, 0.0, 3.0).1).assert_climbs();
}

#[test]
fn a_band_through_the_apex_turns_on_its_way() {
    let (half_angle, length) = (0.5_f64, 4.0);
    for (wide, turn) in [(4.0, 0.3), (4.0, 1.0), (2.0, 2.0)] {
        let mut body = Body::sheet();
        let radius = length * half_angle.tan();
        let path = |from: f64| {
            move |v: f64| {
                let (angle, out) = (from + turn * v / length, v * half_angle.tan());
                DVec3::new(out * angle.cos(), out * angle.sin(), v)
            }
        };
        let [left, right] = [0.0, wide].map(|from| body.spline(through(path(from), (-length, length), 200)));
        // The parameter of the lower nappe is half a turn off the angle.
        let low = body.arc(&level(-length), radius, PI - turn, PI - turn + wide);
        let high = body.arc(&level(length), radius, turn, turn + wide);
        let cone = Surface::Cone { frame: Frame3::WORLD, radius: 0.0, half_angle };
        body.face(cone, vec![vec![low.along(), right.along(), high.against(), left.against()]], false);
        let area = wide * half_angle.tan() * length * length / half_angle.cos();
        Ladder::sheet(body.finish(), area).named((wide, turn)).assert_climbs();
    }
}
