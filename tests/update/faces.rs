//! Faces that are kept: a part that changes costs the faces that differ, and their neighbours.

use crate::edits::{move_hole, shift};
use crate::models;
use crate::prepared::{OPTIONS, assert_same};
use glam::DVec3;
use std::collections::{BTreeSet, HashSet};
use std::sync::Arc;
use trimtess::control::{Alone, Control};
use trimtess::model::{EdgeId, FaceId, Loop, Model, Part};
use trimtess::prepare::{PrepareOptions, Prepared, prepare};

fn update(prepared: &Prepared, model: &Model, options: &PrepareOptions) -> Arc<Prepared> {
    Arc::new(prepared.update_on(&Alone, model, options, &Control::default()).unwrap())
}

fn edges(part: &Part, face: usize) -> Vec<EdgeId> {
    let wires =
        part.faces[face].loops.iter().filter_map(|of| if let Loop::Edges(uses) = of { Some(uses) } else { None });
    wires.flatten().map(|coedge| coedge.edge).collect()
}

/// The faces of a part of `new` that share nothing with a face of `old`.
fn drafted(old: &Prepared, new: &Prepared, part: usize) -> BTreeSet<usize> {
    let known: HashSet<_> =
        old.parts.iter().flat_map(|part| &part.faces).map(|face| Arc::as_ptr(&face.patches)).collect();
    let is_new = |face: &usize| {
        new.parts[part].face(FaceId::new(*face)).is_none_or(|face| !known.contains(&Arc::as_ptr(&face.patches)))
    };
    (0..new.parts[part].face_rows.len()).filter(is_new).collect()
}

#[test]
fn a_moved_hole_costs_its_faces_and_their_neighbours() {
    let (mut all, mut again) = (0, 0);
    for before in models() {
        let prepared = Arc::new(prepare(before.clone(), &OPTIONS).unwrap());
        for part in 0..before.parts.len() {
            let mut model = before.clone();
            if !move_hole(&mut model.parts[part], 1e-3 * DVec3::new(1.0, 2.0, 3.0), part) {
                continue;
            }
            let [old, new] = [&before, &model].map(|model| &model.parts[part]);
            let free = |face: usize| new.faces[face].trims.is_some();
            let edge = |part: &Part, edge: &EdgeId| format!("{:?}", part.edges[edge.index()]);
            let moved = |id: &EdgeId| edge(old, id) != edge(new, id);
            let touched = |face: &usize| {
                free(*face)
                    || old.faces[*face].surface != new.faces[*face].surface
                    || edges(new, *face).iter().any(moved)
            };
            let touched: BTreeSet<usize> = (0..new.faces.len()).filter(touched).collect();
            let updated = update(&prepared, &model, &OPTIONS);
            let drafted = drafted(&prepared, &updated, part);
            assert!(drafted.is_subset(&touched), "{} {part}: {drafted:?}, not {touched:?}", model.name);
            assert_same(&updated, &model, &format!("{} {part}", model.name));
            (all, again) = (all + new.faces.len(), again + drafted.len());
        }
    }
    println!("{again} of {all} faces drafted");
    assert!(again > 0 && 2 * again < all, "{again} of {all}");
}

/// An edge that comes elsewhere in the part gives all others new numbers.
#[test]
fn other_numbers_of_edges_and_vertices_cost_no_face() {
    for before in models() {
        let prepared = Arc::new(prepare(before.clone(), &OPTIONS).unwrap());
        let mut model = before.clone();
        model.parts.iter_mut().for_each(shift);
        let updated = update(&prepared, &model, &OPTIONS);
        for (part, stated) in model.parts.iter().enumerate() {
            let drafted = drafted(&prepared, &updated, part);
            let made: BTreeSet<usize> =
                (0..stated.faces.len()).filter(|&face| stated.faces[face].trims.is_some()).collect();
            assert!(drafted.is_subset(&made), "{} {part}: {drafted:?}", model.name);
        }
        assert_same(&updated, &model, &model.name);
    }
}

#[test]
fn faces_are_taken_over_only_where_they_are_kept() {
    let before = models().swap_remove(1);
    let mut model = before.clone();
    let part = (0..model.parts.len()).find(|&part| move_hole(&mut model.parts[part], DVec3::splat(1e-3), 0)).unwrap();
    let faces = model.parts[part].faces.len();
    for (kept, takes) in [(false, true), (true, false)] {
        let prepared = Arc::new(prepare(before.clone(), &PrepareOptions::DEFAULT.with_keep_faces(kept)).unwrap());
        let updated = update(&prepared, &model, &PrepareOptions::DEFAULT.with_keep_faces(takes));
        assert_eq!(drafted(&prepared, &updated, part).len(), faces);
    }
    let memory = |keep| prepare(before.clone(), &PrepareOptions::DEFAULT.with_keep_faces(keep)).unwrap().memory();
    let [without, with] = [false, true].map(memory);
    assert!(with.update > without.update && with.faces == without.faces);
}
