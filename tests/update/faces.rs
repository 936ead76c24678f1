//! Faces that are kept: a part that changes costs the faces that differ, and their neighbours.

use crate::edits::{move_hole, shift};
use crate::models;
use crate::prepared::{OPTIONS, assert_same};
use glam::DVec3;
use std::collections::{BTreeSet, HashSet};
use std::sync::Arc;
use trimtess::control::{Alone, Control};
use trimtess::model::{
    EdgeId, FaceId, Frame3, Loop, Model, NurbsCurve3, Part, PartBuilder, ShellKind, Surface, VertexId,
};
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
            let moved = |edge: &EdgeId| old.edges[edge.index()] != new.edges[edge.index()];
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

/// A sheet of plane faces, each at its own height: one that crosses itself, one with a gap in its wire, one with a hole
/// that touches its border, and a square.
fn odd_faces() -> Model {
    let mut part = PartBuilder::new("odd");
    let shell = part.plain_shell(ShellKind::Open);
    let plane = |z: f64| Surface::Plane { frame: Frame3 { origin: DVec3::Z * z, ..Frame3::WORLD } };
    let polygon = |part: &mut PartBuilder, z: f64, corners: &[(f64, f64)]| {
        part.polygon(&corners.iter().map(|&(x, y)| DVec3::new(x, y, z)).collect::<Vec<_>>())
    };
    let square = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)];
    let eight = polygon(&mut part, 0.0, &[(0.0, 0.0), (10.0, 8.0), (10.0, 0.0), (0.0, 8.0)]);
    part.plain_face(plane(0.0), shell, vec![Loop::Edges(eight)], false);
    let ends = |x: f64, y: f64| DVec3::new(x, y, 5.0);
    let corners = [ends(0.0, 0.0), ends(10.0, 0.0), ends(10.0, 0.0), ends(10.0, 10.0), ends(0.0, 10.0)];
    let [a, b, c, d, e] = corners.map(|corner| part.vertex(corner));
    let open = [(a, b), (c, d), (d, e), (e, a)].map(|(from, to)| part.line(from, to).along());
    part.plain_face(plane(5.0), shell, vec![Loop::Edges(open.to_vec())], false);
    let border = polygon(&mut part, 10.0, &square);
    let mut hole = polygon(&mut part, 10.0, &[(0.0, 5.0), (5.0, 3.0), (5.0, 7.0)]);
    hole.reverse();
    hole.iter_mut().for_each(|coedge| coedge.reversed = !coedge.reversed);
    part.plain_face(plane(10.0), shell, vec![Loop::Edges(border), Loop::Edges(hole)], false);
    let plain = polygon(&mut part, 15.0, &square);
    part.plain_face(plane(15.0), shell, vec![Loop::Edges(plain)], false);
    let mut part = part.finish().unwrap();
    // Builders refuse gaps.
    move_vertex(&mut part, c, DVec3::Y * 0.3);
    part.into()
}

/// Moves a vertex of straight edges.
fn move_vertex(part: &mut Part, vertex: VertexId, by: DVec3) {
    part.vertices[vertex.index()] += by;
    for edge in part.edges.iter_mut().filter(|edge| [edge.start, edge.end].contains(&vertex)) {
        let [from, to] = [edge.start, edge.end].map(|vertex| part.vertices[vertex.index()]);
        edge.curve = NurbsCurve3::line(from, to);
        edge.range = edge.curve.domain();
    }
}

/// Drafts that hold more than a border: turned lobes, bridged gaps, points where loops meet. Their edges get other
/// numbers, and one more face is drafted again.
#[test]
fn faces_that_were_mended_are_taken_over_with_what_was_done() {
    let before = odd_faces();
    let prepared = Arc::new(prepare(before.clone(), &OPTIONS).unwrap());
    let kinds: BTreeSet<&str> = prepared.diagnostics.iter().map(|diagnostic| diagnostic.kind.code()).collect();
    assert!(kinds.contains("loop-lobes-turned") && kinds.iter().any(|kind| kind.starts_with("wire-gap")), "{kinds:?}");
    let mut model = before.clone();
    let last = VertexId::new(model.parts[0].vertices.len() - 1);
    move_vertex(&mut model.parts[0], last, -DVec3::X);
    for shifts in 0..2 {
        let updated = update(&prepared, &model, &OPTIONS);
        assert_eq!(drafted(&prepared, &updated, 0), BTreeSet::from([3]), "{shifts}");
        assert_same(&updated, &model, &format!("shifted {shifts} times"));
        shift(&mut model.parts[0]);
    }
}
