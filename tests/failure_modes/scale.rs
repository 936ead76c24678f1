//! Sizes, places and tolerances far apart: from a micrometre to a kilometre, near the origin and far from it.

use crate::body::{Body, frame};
use crate::common::{prepared, whole_frame};
use crate::ladder::Ladder;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_4, PI, TAU};
use trimtess::frame::{PlanLimits, Tolerance, plan, plan_within};
use trimtess::mesh::check_scene;
use trimtess::model::{Frame3, Part, Surface};

/// A block of 20 × 20 × 6 with a countersunk hole and a half ball on top, scaled by `size` and placed at `place`.
fn block(size: f64, place: DVec3) -> (Part, f64, f64) {
    let mut body = Body::solid();
    let lift = |z: f64| Frame3 { origin: place + DVec3::new(-4.0, 0.0, z) * size, ..Frame3::WORLD };
    let [top, middle, bottom] = [(6.0, 4.0), (4.0, 2.0), (0.0, 2.0)].map(|(z, r)| body.circle(&lift(z), r * size));
    let dome = Frame3 { origin: place + DVec3::new(6.0, 3.0, 6.0) * size, ..Frame3::WORLD };
    let rim = body.circle(&dome, 3.0 * size);
    let corner = |x: f64, y: f64, z: f64| place + DVec3::new(x, y, z) * size;
    body.cuboid(
        corner(-10.0, -10.0, 0.0),
        corner(10.0, 10.0, 6.0),
        vec![vec![top.against()], vec![rim.against()]],
        vec![vec![bottom.along()]],
    );
    let sink = Surface::Cone { frame: lift(4.0), radius: 2.0 * size, half_angle: FRAC_PI_4 };
    body.face(sink, vec![vec![middle.along()], vec![top.against()]], true);
    let bore = Surface::Cylinder { frame: lift(0.0), radius: 2.0 * size };
    body.face(bore, vec![vec![bottom.along()], vec![middle.against()]], true);
    body.face(Surface::Sphere { frame: dome, radius: 3.0 * size }, vec![vec![rim.along()]], false);
    let cone = PI * 2.0 / 3.0 * (16.0 + 8.0 + 4.0);
    let volume = 2400.0 - 16.0 * PI - cone + 18.0 * PI;
    let area = 800.0 + 480.0 - PI * (16.0 + 4.0 + 9.0) + PI * 6.0 * 8.0_f64.sqrt() + TAU * 8.0 + 18.0 * PI;
    (body.finish(), volume * size.powi(3), area * size * size)
}

#[test]
fn sizes_from_a_micrometre_to_a_kilometre() {
    for size in [1e-5, 1e-3, 1.0, 1e3, 1e6] {
        let (part, volume, area) = block(size, DVec3::ZERO);
        Ladder::solid(part, volume, area).pieces(1).named(size).assert_climbs();
    }
}

#[test]
fn a_kilometre_from_the_origin() {
    for size in [1e-3, 1e-1, 1.0, 1e3] {
        for place in [DVec3::new(1e6, 0.0, 0.0), DVec3::new(-1e6, 1e6, 1e6)] {
            let (part, volume, area) = block(size, place);
            Ladder::solid(part, volume, area).pieces(1).named((size, place)).assert_climbs();
        }
    }
}

#[test]
fn turned_away_from_all_axes() {
    // A pin through a slanted block's frame: nothing is parallel to an axis.
    for size in [1e-3, 1e3] {
        let axis = DVec3::new(0.3, -0.5, 0.81);
        let foot = frame(DVec3::new(11.0, 7.0, -3.0) * size, axis, DVec3::X);
        let head = Frame3 { origin: foot.origin + foot.z * (9.0 * size), ..foot };
        let mut body = Body::solid();
        let [low, high] = [foot, head].map(|f| body.circle(&f, 2.0 * size));
        let side = Surface::Cylinder { frame: foot, radius: 2.0 * size };
        body.face(side, vec![vec![low.along()], vec![high.against()]], false);
        body.face(Surface::Plane { frame: foot }, vec![vec![low.along()]], true);
        body.flat(head, vec![vec![high.along()]]);
        let (volume, area) = (36.0 * PI * size.powi(3), (36.0 + 8.0) * PI * size * size);
        Ladder::solid(body.finish(), volume, area).named(size).assert_climbs();
    }
}

#[test]
fn a_tolerance_far_larger_than_the_part() {
    for size in [1e-3, 1.0, 1e3] {
        let (part, volume, area) = block(size, DVec3::ZERO);
        Ladder::solid(part, volume, area).chord(1e6 * size).angles_only().named(size).assert_climbs();
    }
}

#[test]
fn the_coarsest_mesh_keeps_every_face_of_every_shape() {
    // Infinite chord, any angle.
    for name in trimtess_models::names() {
        let prepared = prepared(trimtess_models::by_name(name).expect("a shape"));
        let plan = plan(&prepared, &Tolerance { chord: f64::INFINITY, angle: 9.0, max_edge: None });
        let facts = check_scene(&whole_frame(&prepared, &plan, false));
        let total = facts.total;
        assert!(facts.faces_without_triangles.is_empty() && total.is_well_formed(), "{name}: {total}");
        let open = ["square", "wave", "flower"].contains(&name) || name.contains("teapot");
        assert!(open || total.is_closed() && total.volume > 0.0, "{name}: {total}");
    }
}

#[test]
fn a_tolerance_far_smaller_than_rounding_is_reported() {
    let (part, volume, _) = block(1.0, DVec3::ZERO);
    let prepared = prepared(part);
    let limits = PlanLimits::DEFAULT.with_triangles_per_tile(20_000).with_triangles(200_000);
    for chord in [1e-7, 1e-12, 0.0] {
        let plan = plan_within(&prepared, &Tolerance { chord, angle: 0.5, max_edge: None }, &limits);
        assert!(plan.shortfall.is_some(), "chord {chord}");
        let facts = check_scene(&whole_frame(&prepared, &plan, false)).total;
        assert!(facts.is_closed() && (facts.volume / volume - 1.0).abs() < 1e-3, "chord {chord}: {facts}");
    }
}
