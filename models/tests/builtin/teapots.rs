//! The teapots with free trims.

use crate::{meshed, patches, prepared};

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

#[test]
fn what_is_cut_out_of_the_trimmed_teapot_is_gone_from_both_sides_of_a_border() {
    let prepared = prepared("trimmed-teapot");
    let whole = crate::prepared("teapot");
    let [(_, cut, _), (_, full, _)] = [&prepared, &whole].map(|p| meshed(p, 1e-4));
    let lost = full.total.area - cut.total.area;
    // Letters and ellipses take about a sixth of the area.
    assert!((0.1..0.3).contains(&(lost / full.total.area)), "{lost} of {}", full.total.area);
}
