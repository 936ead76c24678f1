//! Cameras that move around files of the corpus: no cracks, and every tile within the screen-space error.

use super::frames::{balanced_as, options, path};
use super::{flights, of_corpus};
use crate::blocks::{BlockSink, Blocks, decoded};
use crate::random::SplitMix;
use glam::DVec3;
use std::sync::Arc;
use trimtess::mesh::{Batch, VertexLayout};
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
        let views = path(&mut SplitMix(40 + k as u64), prepared.bounds.unwrap(), 24);
        let (most, made) = flights::flown(name, &prepared, &views, 1);
        println!("{name}: at most {most} of the tolerance, {made} tiles");
        assert!(most > 0.1, "{name}: {most}");
    }
}

/// The meshes that the bytes of the drawn tiles mean, with positions relative to their parts.
fn packed(sink: &BlockSink, session: &Session) -> Vec<Batch> {
    let instances = || session.scene().instances.iter().enumerate();
    let shows = |part, tile| instances().any(|(i, of)| of.part == part && sink.drawn.contains(0, i, tile));
    let tiles = sink.tiles.values().filter(|tile| shows(tile.part, tile.tile));
    let read = |tile| decoded(tile, &sink.memory.room(tile), DVec3::ZERO).0;
    tiles.map(|tile| Batch { part: tile.part, face: tile.face, tile: tile.tile, worker: 0, mesh: read(tile) }).collect()
}

#[test]
fn packed_vertices_of_large_files_leave_no_border_open() {
    for (k, name) in ["tri_zero_skirts.step", "odrive_pcb_v35.step"].into_iter().enumerate() {
        let Some(prepared) = of_corpus(name) else { continue };
        let mut session = Session::start(Arc::clone(&prepared), &options(2)).unwrap();
        let mut sink = BlockSink::default();
        session.write_into(VertexLayout::COMPACT, Arc::<Blocks>::clone(&sink.memory));
        // Three frames in a row, and a jump.
        let whole = path(&mut SplitMix(80 + k as u64), prepared.bounds.unwrap(), 120);
        let views = whole.chunks(30).flat_map(|flight| &flight[..3]);
        let (mut stretches, mut rebuilt) = (0, 0);
        for (f, view) in views.enumerate() {
            let report = session.view(&[*view], &mut sink).unwrap();
            assert!(report.whole == (f == 0), "{name} {f}");
            rebuilt += usize::from(f > 0) * report.tiles;
            let scene = session.scene();
            let rounded = |p: usize, point: DVec3| (point - scene.parts[p].centre).as_vec3().as_dvec3();
            let (model, plan, case) = (session.prepared(), session.plan().unwrap(), format!("{name} {f}"));
            stretches += balanced_as(model, &plan, &packed(&sink, &session), rounded, &case);
        }
        println!("{name}: {stretches} edge segments, {rebuilt} tiles rebuilt");
        assert!(stretches > 10_000 && rebuilt > 100, "{name}: {stretches}, {rebuilt}");
    }
}
