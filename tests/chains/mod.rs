//! A prepared part -> whether every mesh made from it ends only where it should: loops against their points, sums of
//! tiles against edges. Meshing cannot repair such faults.

use std::collections::BTreeMap;
use trimtess::mesh::ScenePart;
use trimtess::model::{EdgeId, RowId};
use trimtess::prepare::Prepared;
use trimtess::prepare::internals::{EdgeShape, PreparedPart};

/// Panics if [`chain_faults`] finds something.
#[allow(dead_code, reason = "not every test that includes this file asserts")]
pub(crate) fn assert_chains_close(prepared: &Prepared) {
    let faults = all_faults(prepared);
    assert!(faults.is_empty(), "{faults:#?}");
}

/// The faults of all parts.
pub(crate) fn all_faults(prepared: &Prepared) -> Vec<String> {
    let parts = prepared.parts.iter().zip(&prepared.scene.parts).enumerate();
    parts
        .flat_map(|(k, (part, scene))| chain_faults(part, scene).into_iter().map(move |f| format!("part {k}: {f}")))
        .collect()
}

/// Loops that do not close, and edge intervals whose uses do not cancel although they are neither free nor listed as
/// not orientable.
pub(crate) fn chain_faults(part: &PreparedPart, scene: &ScenePart) -> Vec<String> {
    let mut faults = Vec::new();
    let mut sums: BTreeMap<(u32, u32), i32> = BTreeMap::new();
    for (number, tile) in part.tiles.iter().enumerate() {
        let face = part.face_of(tile);
        let sign = if face.reversed { -1 } else { 1 };
        for (index, l) in tile.loops.iter().enumerate() {
            let point = |edge: RowId, at: u32| part.edges[edge.index()].breaks[at as usize].point;
            for (a, b) in l.iter().zip(l.iter().cycle().skip(1)) {
                let (end, start) = (point(a.edge, a.to), point(b.edge, b.from));
                if end != start {
                    let whose = format!("face {} tile {number} loop {index}", tile.face.0);
                    faults
                        .push(format!("{whose}: edge {} ends at {end}, edge {} starts at {start}", a.edge.0, b.edge.0));
                }
            }
            for u in l {
                let breaks = &part.edges[u.edge.index()].breaks;
                let is_pole = matches!(part.edges[u.edge.index()].shape, EdgeShape::Point(_));
                if is_pole && breaks[u.from as usize].point == breaks[u.to as usize].point {
                    continue;
                }
                let along = if u.from < u.to { sign } else { -sign };
                (u.from.min(u.to)..u.from.max(u.to)).for_each(|k| *sums.entry((u.edge.0, k)).or_default() += along);
            }
        }
    }
    let listed = |edge: u32| {
        let is_in = |list: &[EdgeId]| list.binary_search(&EdgeId(edge)).is_ok();
        is_in(&scene.free_edges) || is_in(&scene.not_orientable)
    };
    for ((edge, interval), sum) in sums.into_iter().filter(|s| s.1 != 0) {
        let is_border = edge as usize >= part.brep_edges;
        if scene.closed || !(is_border || listed(edge)) {
            let uses = &part.edges[edge as usize].uses;
            let faces: Vec<u32> = uses.iter().map(|u| part.tiles[u.tile.index()].face.0).collect();
            faults.push(format!("edge {edge} interval {interval} sums to {sum}; its faces are {faces:?}"));
        }
    }
    if scene.closed && !(scene.free_edges.is_empty() && scene.not_orientable.is_empty()) {
        faults.push("closed, but has free or non-orientable edges".to_owned());
    }
    faults
}
