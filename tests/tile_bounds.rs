//! Boxes of tiles and parts contain the triangles at every tolerance, and are not much larger.
#![cfg(feature = "step")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::DVec3;
use std::sync::Arc;
use trimtess::frame::{Tolerance, plan};
use trimtess::import::step::{StepOptions, read};
use trimtess::mesh::MemorySink;
use trimtess::model::{Model, PartId, TileId, shapes};
use trimtess::parallel::serial;
use trimtess::prepare::{PrepareOptions, prepare};

fn models() -> Vec<Model> {
    let named = shapes::NAMES.iter().filter_map(|name| shapes::by_name(name));
    let text = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/nist_ctc05.step")).unwrap();
    named.chain([read(&text, &StepOptions::DEFAULT).unwrap()]).collect()
}

fn is_in([low, high]: [DVec3; 2], point: DVec3) -> bool {
    low.cmple(point).all() && point.cmple(high).all()
}

#[test]
fn triangles_are_in_the_boxes_of_their_tiles_at_every_tolerance() {
    for model in models() {
        let prepared = Arc::new(prepare(model, &PrepareOptions::DEFAULT).unwrap());
        let parts: Vec<PartId> = (0..prepared.scene.parts.len()).map(PartId::new).collect();
        let mut around = vec![[DVec3::INFINITY, DVec3::NEG_INFINITY]; parts.len()];
        for chord_rel in [0.1, 1e-2, 1e-3, 1e-4] {
            let tolerance = Tolerance { angle: 1.5, ..Tolerance::relative(chord_rel, prepared.diagonal) };
            let mut frame = MemorySink::default();
            serial(&prepared, &Arc::new(plan(&prepared, &tolerance)), true, &mut frame).unwrap();
            for batch in &frame.batches {
                let bounds = prepared.tile_bounds(batch.part, batch.tile).unwrap();
                let of_part = prepared.part_bounds(batch.part).unwrap();
                assert!(bounds.iter().all(|&corner| is_in(of_part, corner)));
                let [low, high] = &mut around[batch.part.index()];
                for &point in &batch.mesh.positions {
                    assert!(is_in(bounds, point), "{:?} {chord_rel}: {point} {bounds:?}", batch.tile);
                    (*low, *high) = (low.min(point), high.max(point));
                }
            }
            for line in &frame.edge_lines {
                let of_part = prepared.part_bounds(line.part).unwrap();
                assert!(line.points.iter().all(|&point| is_in(of_part, point)));
            }
        }
        for (part, [low, high]) in parts.into_iter().zip(around) {
            let [least, most] = prepared.part_bounds(part).unwrap();
            let size = (high - low).length();
            assert!((most - least).length() < 1.5 * size, "{part:?}: {least} {most} around {low} {high}");
        }
        assert_eq!(prepared.tile_bounds(PartId(0), TileId(u32::MAX)), None);
        assert_eq!(prepared.part_bounds(PartId(u32::MAX)), None);
    }
}
