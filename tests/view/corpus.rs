//! Cameras that move around files of the corpus: no cracks, and every tile within the screen-space error.

use super::frames::{balanced, drawn, from_scratch, options, path};
use super::pixels::measured;
use super::{lines, of_corpus};
use crate::random::SplitMix;
use std::sync::Arc;
use trimtess::mesh::MemorySink;
use trimtess::parallel::Session;

/// Whole solids of all kinds of surfaces, with few enough triangles to measure each.
const FILES: [&str; 7] = [
    "screw.step",
    "io1_cm_214.stp",
    "dm1_id_214.stp",
    "mini_heatsink.stp",
    "tank_torus_sphere.stp",
    "periodic_pole_solid.stp",
    "as1_oc_214.stp",
];

#[test]
fn files_keep_the_screen_space_error_in_every_frame() {
    for (k, name) in FILES.iter().enumerate() {
        let Some(prepared) = of_corpus(name) else { continue };
        let mut session = Session::start(Arc::clone(&prepared), &options(2)).unwrap();
        let mut sink = MemorySink::default();
        let (mut most, mut stretches) = (0.0_f64, 0);
        let views = path(&mut SplitMix(40 + k as u64), prepared.bounds.unwrap(), 24);
        for (f, view) in views.into_iter().enumerate() {
            let report = session.view(&[view], &mut sink).unwrap();
            assert!(report.degraded.is_empty(), "{name} {f}: {:?}", report.degraded);
            let batches = drawn(&sink);
            assert_eq!(batches, drawn(&from_scratch(&session)), "{name} {f}");
            stretches += balanced(session.prepared(), &session.plan().unwrap(), &batches, &format!("{name} {f}"));
            let frame = MemorySink::of(sink.scene.clone(), batches, Vec::new());
            let near = 0.05 * prepared.scene.parts.iter().map(|part| part.radius).fold(0.0, f64::max);
            let (share, _) = measured(session.prepared(), &view, near, &frame);
            assert!(share <= 1.0, "{name} {f}: {share} times the tolerance");
            most = most.max(share);
        }
        println!("{name}: at most {most} of the tolerance, {stretches} edge segments");
        assert!(most > 0.1 && stretches > 1000, "{name}: {most}, {stretches}");
    }
}

#[test]
fn files_stay_closed_and_within_the_stated_error_with_split_lines() {
    for (k, name) in FILES.iter().enumerate() {
        let Some(prepared) = of_corpus(name) else { continue };
        let views = path(&mut SplitMix(60 + k as u64), prepared.bounds.unwrap(), 20);
        for lines in [lines::CRITERION, lines::RENDERING] {
            let (most, made) = lines::flown(name, &prepared, lines, &views);
            println!("{name}, {lines:?}: at most {most} of the tolerance, {made} tiles");
        }
    }
}
