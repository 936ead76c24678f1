//! The teapots with free trims.

use crate::{meshed, patches, prepared};
use glam::DVec3;
use std::sync::Arc;
use trimtess::frame::{self, Tolerance};
use trimtess::mesh::MemorySink;
use trimtess::parallel::serial;

#[test]
fn trimmed_teapots_keep_every_patch_and_the_tolerance() {
    for name in ["trimmed-teapot", "flower-teapot"] {
        let prepared = prepared(name);
        assert_eq!(patches(&prepared), 32);
        for share in [1e-2, 1e-3, 1e-4] {
            let (_, facts, deviation) = meshed(&prepared, share);
            assert!(facts.total.is_well_formed(), "{name} at {share}: {}", facts.total);
            let worst = deviation.beyond_gap.worst.max(deviation.edges.worst);
            assert!(worst <= 1.0, "{name} at {share}: {deviation}");
        }
    }
}

#[test]
fn what_patches_have_in_common_is_shared_up_to_the_loops_across_it() {
    let shared = |name| {
        let prepared = prepared(name);
        prepared.parts[0].edges.iter().filter(|edge| edge.uses.len() == 2).count()
    };
    // An N splits two borders of the body, an ellipse each of the lid's four, and a flower each of the lower body's
    // four.
    assert_eq!(["teapot", "trimmed-teapot", "flower-teapot"].map(shared), [52, 52 + 2 + 4, 52 + 4]);
}

/// Whether a triangle covers a point near it.
fn covers(frame: &MemorySink, p: DVec3) -> bool {
    frame.batches.iter().any(|batch| {
        let mut triangles = batch.mesh.triangles.iter().map(|t| t.map(|k| batch.mesh.positions[k as usize]));
        triangles.any(|[a, b, c]| {
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let inside = |a: DVec3, b: DVec3| (b - a).cross(p - a).dot(normal) >= 0.0;
            (p - a).dot(normal).abs() <= 0.1 && inside(a, b) && inside(b, c) && inside(c, a)
        })
    })
}

#[test]
fn what_is_cut_out_of_the_trimmed_teapot_is_gone_from_both_sides_of_a_border() {
    let (whole, cut) = (prepared("teapot"), prepared("trimmed-teapot"));
    let [whole, cut] = [whole, cut].map(|prepared| {
        let plan = frame::plan(&prepared, &Tolerance { chord: 0.01, angle: 0.5, max_edge: None });
        let mut sink = MemorySink::default();
        serial(&prepared, &Arc::new(plan), false, &mut sink).unwrap();
        sink
    });
    let part = trimtess_models::by_name("trimmed-teapot").unwrap().parts.remove(0);
    // The outer bars of both Ns, each across the border of a patch and the next, and both ends of the lid's patches,
    // which have the halves of four ellipses.
    let bars = [(4, 0.8725), (5, 0.1275), (6, 0.8725), (7, 0.1275)].map(|(face, v)| (face, 0.5, v));
    let halves = (16..20).flat_map(|face| [(face, 0.52, 0.1), (face, 0.52, 0.9)]);
    for (face, u, v) in bars.into_iter().chain(halves) {
        let p = part.faces[face].surface.point(u, v);
        assert!(covers(&whole, p) && !covers(&cut, p), "face {face} at ({u}, {v})");
    }
}

#[test]
fn letters_and_ellipses_take_a_sixth_of_the_trimmed_teapot() {
    let prepared = prepared("trimmed-teapot");
    let whole = crate::prepared("teapot");
    let [(_, cut, _), (_, full, _)] = [&prepared, &whole].map(|p| meshed(p, 1e-4));
    let lost = full.total.area - cut.total.area;
    assert!((0.1..0.3).contains(&(lost / full.total.area)), "{lost} of {}", full.total.area);
}
