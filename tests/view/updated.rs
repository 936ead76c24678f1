//! Tiles updated incrementally from frame to frame: the same vertices, boundaries and areas as made without history,
//! whatever the path, the number of workers and the cancelled frames.

use super::frames::{balanced, drawn, from_scratch, path};
use super::{of_corpus, shape};
use crate::random::SplitMix;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use trimtess::control::Alone;
use trimtess::frame::internals::{
    PlacedInstances, Planner, Scratch, TileCache, UpdateScratch, tessellate_tile, update_tile,
};
use trimtess::frame::{PlannerOptions, Reuse};
use trimtess::mesh::{Batch, MemorySink, Origin, TileMesh};
use trimtess::model::{PartId, SurfaceKind, TileId};
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::Prepared;

const SOME: [Reuse; 5] = [
    Reuse::DEFAULT,
    Reuse::ALL,
    Reuse { trace: false, triangles: false, ..Reuse::ALL },
    Reuse { samples: false, triangles: false, ..Reuse::ALL },
    Reuse { samples: false, trace: false, ..Reuse::ALL },
];

/// Sides of triangles that no other triangle uses in reverse, in ascending order.
fn boundary(mesh: &TileMesh) -> Vec<(u32, u32)> {
    let mut sides: BTreeMap<(u32, u32), i32> = BTreeMap::new();
    for &[a, b, c] in &mesh.triangles {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            *sides.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
    }
    let directed = |((a, b), n): ((u32, u32), i32)| match n {
        0 => None,
        1 => Some((a, b)),
        -1 => Some((b, a)),
        _ => panic!("side {a} {b} has {n} triangles on one side"),
    };
    sides.into_iter().filter_map(directed).collect()
}

/// Twice the areas in space and in (u,v); the latter is signed.
fn areas(mesh: &TileMesh) -> (f64, f64) {
    let p = |v: u32| mesh.positions[v as usize];
    let q = |v: u32| mesh.uvs[v as usize].as_dvec2();
    let area = |&[a, b, c]: &[u32; 3]| ((p(b) - p(a)).cross(p(c) - p(a)).length(), (q(b) - q(a)).perp_dot(q(c) - q(a)));
    mesh.triangles.iter().map(area).fold((0.0, 0.0), |sum, area| (sum.0 + area.0, sum.1 + area.1))
}

/// The same mesh with its lattice points in lattice order, which updated tiles do not keep.
fn in_order(mesh: &TileMesh) -> TileMesh {
    let key = |v: &usize| match mesh.origins[*v] {
        Origin::Edge { .. } | Origin::Border { .. } => (0, 0, *v as u32),
        Origin::Lattice { i, j } => (1, j, i),
        Origin::Crossing { k } => (2, 0, k),
        Origin::Inner { .. } => (3, 0, *v as u32),
    };
    let mut order: Vec<usize> = (0..mesh.origins.len()).collect();
    order.sort_by_key(key);
    let mut now = vec![0; order.len()];
    order.iter().enumerate().for_each(|(new, &old)| now[old] = new as u32);
    TileMesh {
        positions: order.iter().map(|&v| mesh.positions[v]).collect(),
        normals: order.iter().map(|&v| mesh.normals[v]).collect(),
        uvs: order.iter().map(|&v| mesh.uvs[v]).collect(),
        origins: order.iter().map(|&v| mesh.origins[v]).collect(),
        triangles: mesh.triangles.iter().map(|t| t.map(|v| now[v as usize])).collect(),
        lines: mesh.lines.clone(),
    }
}

/// Asserts that two meshes of a tile differ at most in the triangulation of their inside. Returns whether they differ
/// in that.
fn same_but_inside(kind: SurfaceKind, patched: &TileMesh, made: &TileMesh, case: &str) -> bool {
    let (patched, made) = (&in_order(patched), &in_order(made));
    assert!(
        patched.positions == made.positions
            && patched.normals == made.normals
            && patched.uvs == made.uvs
            && patched.lines == made.lines
            && patched.origins == made.origins,
        "{case}: other vertices"
    );
    assert_eq!(patched.triangles.len(), made.triangles.len(), "{case}");
    assert_eq!(boundary(patched), boundary(made), "{case}");
    let used = |mesh: &TileMesh| {
        let mut used = vec![false; mesh.positions.len()];
        mesh.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        used
    };
    assert_eq!(used(patched), used(made), "{case}");
    let ((space, plane), (space_made, plane_made)) = (areas(patched), areas(made));
    assert!((plane - plane_made).abs() <= 1e-6 * plane_made.abs(), "{case}: {plane} {plane_made}");
    if kind == SurfaceKind::Plane {
        assert!((space - space_made).abs() <= 1e-12 * space_made, "{case}: {space} {space_made}");
        for &[a, b, c] in &patched.triangles {
            let [p, q, r] = [a, b, c].map(|v| patched.positions[v as usize]);
            let up = (q - p).cross(r - p).dot(patched.normals[a as usize].as_dvec3());
            assert!(up > 0.0, "{case}: {up}");
        }
    }
    let sorted = |mesh: &TileMesh| {
        let mut all = mesh.triangles.clone();
        all.iter_mut().for_each(|t| {
            let least = (0..3).min_by_key(|&k| t[k]).unwrap_or(0);
            t.rotate_left(least);
        });
        all.sort_unstable();
        all
    };
    sorted(patched) != sorted(made)
}

fn kind(prepared: &Prepared, part: PartId, tile: TileId) -> SurfaceKind {
    let rows = &prepared.parts[part.index()];
    rows.faces[rows.face_of(&rows.tiles[tile.0 as usize])].kind
}

#[test]
fn updated_tiles_equal_those_made_without_history_except_inside() {
    for name in ["torus", "washer", "flower", "brake-hub", "brake-rotor", "trimmed-teapot"] {
        let prepared = shape(name);
        for (k, patch) in SOME.into_iter().enumerate() {
            let mut planner = Planner::new(&Alone, Arc::clone(&prepared), &PlannerOptions::DEFAULT);
            let mut placed = PlacedInstances::of(&prepared);
            let mut memories: HashMap<(PartId, TileId), TileCache> = HashMap::new();
            let (mut scratch, mut other) = (UpdateScratch::default(), Scratch::default());
            for (f, view) in path(&mut SplitMix(k as u64), prepared.bounds.unwrap(), 50).into_iter().enumerate() {
                let plan = Arc::clone(planner.plan(&mut placed, &[view]));
                let all = prepared.tiles().map(|(part, tile, _)| (part, tile));
                let changed: Vec<_> = if f == 0 { all.collect() } else { planner.changes().tiles.clone() };
                for (part, tile) in changed {
                    // Skips some frames.
                    if f % 7 == 3 && tile.0 % 2 == 0 {
                        continue;
                    }
                    let memory = memories.entry((part, tile)).or_default();
                    let patched = update_tile((&prepared, &plan), (part, tile), patch, memory, &mut scratch);
                    let made = tessellate_tile(&prepared, &plan, part, tile, &mut other);
                    let case = format!("{name} {f} tile {tile:?} {patch:?}");
                    assert_eq!(patched.degradation, made.degradation, "{case}");
                    same_but_inside(kind(&prepared, part, tile), &patched.mesh, &made.mesh, &case);
                }
            }
        }
    }
}

/// Files of the corpus with planes of many holes, folds, poles and loops within one cell.
const FILES: [&str; 4] = ["mini_heatsink.stp", "as1_oc_214.stp", "periodic_pole_solid.stp", "tank_torus_sphere.stp"];

#[test]
fn sessions_that_update_tiles_have_no_cracks() {
    let mut differ = 0;
    let files = FILES.into_iter().filter_map(|name| Some((name, of_corpus(name)?)));
    for (name, prepared) in ["brake-hub", "trimmed-teapot"].map(|name| (name, shape(name))).into_iter().chain(files) {
        let options = SessionOptions::DEFAULT.with_workers(2).with_edge_lines(false).with_reuse(Reuse::ALL);
        let mut session = Session::start(Arc::clone(&prepared), &options).unwrap();
        let mut sink = MemorySink::default();
        let (mut stretches, mut kept) = (0, 0);
        for (f, view) in path(&mut SplitMix(17), prepared.bounds.unwrap(), 40).into_iter().enumerate() {
            let report = session.view(&[view], &mut sink).unwrap();
            assert!(report.lost_lines.is_empty(), "{name} {f}: {:?}", report.lost_lines);
            kept = report.workers.iter().map(|w| w.kept).max().unwrap_or(kept);
            let (batches, made) = (drawn(&sink), drawn(&from_scratch(&session)));
            assert_eq!(batches.len(), made.len(), "{name} {f}");
            for (a, b) in batches.iter().zip(&made) {
                assert_eq!((a.part, a.tile, a.face), (b.part, b.tile, b.face));
                let case = format!("{name} {f} tile {:?}", a.tile);
                let kind = kind(session.prepared(), a.part, a.tile);
                differ += usize::from(same_but_inside(kind, &a.mesh, &b.mesh, &case));
            }
            stretches += balanced(session.prepared(), session.plan().unwrap(), &batches, &format!("{name} {f}"));
        }
        assert!(stretches > 1000 && kept > 0, "{name}: {stretches} {kept}");
    }
    assert!(differ > 0, "no tile was updated incrementally");
}

#[test]
fn neither_the_number_of_workers_nor_cancelled_frames_change_updated_tiles() {
    let prepared = shape("brake-hub");
    let views = path(&mut SplitMix(23), prepared.bounds.unwrap(), 60);
    let frames = |workers: usize, pause: bool| {
        let options = SessionOptions::DEFAULT.with_workers(workers).with_reuse(Reuse::ALL);
        let mut session = Session::start(Arc::clone(&prepared), &options).unwrap();
        let mut sink = MemorySink::default();
        let mut frames = Vec::new();
        for (f, view) in views.iter().enumerate() {
            session.begin(&[*view]).unwrap();
            if f % 6 == 5 {
                // Cancelled at any stage: how far the frame had come must not matter.
                while pause && !session.is_made() {
                    std::thread::yield_now();
                }
                session.cancel();
                continue;
            }
            if f == 40 {
                session.forget();
                session.begin(&[*view]).unwrap();
            }
            session.finish(&mut sink).unwrap();
            let batches: Vec<Batch> = sink.batches.iter().cloned().map(|b| Batch { worker: 0, ..b }).collect();
            frames.push((batches, sink.drawn.clone()));
        }
        frames
    };
    let one = frames(1, false);
    for (workers, pause) in [(1, true), (2, false), (3, true), (8, true), (8, false)] {
        assert!(frames(workers, pause) == one, "{workers} workers, {pause}");
    }
}
