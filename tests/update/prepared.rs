//! Prepared models after edits: the same as prepared from nothing, and nothing that was there is prepared again.

use crate::edits::Edit;
use crate::random::SplitMix;
use crate::{built, common, edits, models, pool};
use glam::DVec3;
use std::sync::Arc;
use trimtess::control::{Alone, Control};
use trimtess::frame::{Tolerance, plan};
use trimtess::mesh::Batch;
use trimtess::model::Model;
use trimtess::prepare::{PrepareError, PrepareLimits, PrepareOptions, Prepared, prepare, prepare_on};

pub(crate) const OPTIONS: PrepareOptions = PrepareOptions::DEFAULT.with_keep_faces(true);

/// The parts of `new` that are not shared with `old`.
pub(crate) fn changed(old: &Prepared, new: &Prepared) -> Vec<usize> {
    let shared = |row: &usize| old.parts.iter().any(|part| Arc::ptr_eq(part, &new.parts[*row]));
    (0..new.parts.len()).filter(|row| !shared(row)).collect()
}

/// Everything about a prepared model but its geometry, which meshes tell.
fn told(prepared: &Prepared) -> String {
    let Prepared { scene, diagnostics, bounds, diagonal, .. } = prepared;
    format!("{scene:?} {diagnostics:?} {bounds:?} {diagonal:?} {:?}", prepared.memory())
}

fn mesh(prepared: &Arc<Prepared>) -> (Vec<Batch>, String) {
    let tolerance = Tolerance { chord: 2e-3 * prepared.diagonal, angle: 0.6, max_edge: None };
    let (sink, report) = common::frame(prepared, &plan(prepared, &tolerance), true);
    let lines = format!("{:?} {:?} {:?}", sink.edge_lines, report.rungs, report.degraded);
    (sink.batches, lines)
}

pub(crate) fn assert_same(updated: &Arc<Prepared>, model: &Model, what: &str) {
    assert_same_with(updated, model, &OPTIONS, what);
}

fn assert_same_with(updated: &Arc<Prepared>, model: &Model, options: &PrepareOptions, what: &str) {
    let fresh = Arc::new(prepare_on(&Alone, model, options, &Control::default()).unwrap());
    assert_eq!(told(updated), told(&fresh), "{what}");
    // No `assert_eq`: it would print all vertices.
    assert!(mesh(updated) == mesh(&fresh), "{what}: meshes differ");
}

#[test]
fn after_random_edits_an_update_equals_preparing_from_nothing() {
    let models = models();
    let (count, pool) = (edits() / models.len() as u64, pool());
    let (mut made, mut all) = (0, 0);
    for (k, mut model) in models.into_iter().enumerate() {
        let mut draw = SplitMix(k as u64);
        let options = OPTIONS.with_keep_faces(k % 2 == 0);
        let mut prepared = Arc::new(prepare(model.clone(), &options).unwrap());
        for number in 0..count {
            let edit = Edit::ALL[draw.below(Edit::ALL.len() as u64) as usize];
            let most = edit.apply(&mut model, &pool, &mut draw);
            let updated = Arc::new(prepared.update_on(&Alone, &model, &options, &Control::default()).unwrap());
            let new = changed(&prepared, &updated).len();
            let what = format!("{} {number}: {edit:?}", model.name);
            assert!(new <= most, "{what}: {new} parts prepared, not {most}");
            assert_same_with(&updated, &model, &options, &what);
            (made, all) = (made + new, all + updated.parts.len());
            prepared = updated;
        }
    }
    println!("{made} of {all} parts prepared in {edits} edits", edits = edits());
    assert!(made > 0 && 4 * made < all, "{made} of {all}");
}

#[test]
fn other_options_take_nothing_over_and_nothing_gives_everything() {
    let model = built();
    let prepared = common::prepared(model.clone());
    let again = prepared.update(model.clone(), &OPTIONS).unwrap();
    assert!(changed(&prepared, &again).is_empty());
    let other = OPTIONS.with_border_tolerance(1e-5);
    let all: Vec<usize> = (0..model.parts.len()).collect();
    assert_eq!(changed(&prepared, &prepared.update(model.clone(), &other).unwrap()), all);
    assert_eq!(changed(&prepared, &Prepared::default().update(model.clone(), &OPTIONS).unwrap()), all);
    // Nothing of the old model is left where the new one is empty.
    let empty = prepared.update(Model::default(), &OPTIONS).unwrap();
    assert_eq!((empty.parts.len(), empty.memory().faces, empty.memory().edges), (0, 0, 0));
    assert!(prepared.memory().total() > empty.memory().total());
}

#[test]
fn parts_that_are_taken_over_count_towards_the_limits() {
    let mut model = built();
    let prepared = common::prepared(model.clone());
    model.parts[0].vertices[0] += DVec3::splat(1e-9);
    let patches = |most| OPTIONS.with_limits(PrepareLimits::DEFAULT.with_patches(most));
    let fits = |most: &u64| prepare(model.clone(), &patches(*most)).is_ok();
    let least = (1..1000).find(fits).unwrap();
    assert!(prepared.update(model.clone(), &patches(least)).is_ok());
    let refused = prepared.update(model.clone(), &patches(least - 1)).unwrap_err();
    assert_eq!(refused, prepare(model.clone(), &patches(least - 1)).unwrap_err());
    assert!(matches!(refused, PrepareError::TooManyPatches { limit, .. } if limit == least - 1));
}

#[test]
fn a_cancelled_update_changes_nothing() {
    let mut model = built();
    let prepared = prepare(model.clone(), &OPTIONS).unwrap();
    let before = told(&prepared);
    model.parts.reverse();
    model.parts[0].tolerance = 1e-9;
    let control = Control::default();
    control.cancel();
    assert_eq!(prepared.update_on(&Alone, &model, &OPTIONS, &control).unwrap_err(), PrepareError::Cancelled);
    assert_eq!(told(&prepared), before);
    let updated = Arc::new(prepared.update_on(&Alone, &model, &OPTIONS, &Control::default()).unwrap());
    assert_eq!(changed(&prepared, &updated), [0]);
    assert_same(&updated, &model, "after a cancelled update");
}

/// The model as another program would save it: every entity has another number.
fn saved_again(model: &Model) -> Model {
    let mut other = model.clone();
    let numbers = other.parts.iter_mut().flat_map(|part| {
        let of_faces = part.faces.iter_mut().map(|face| &mut face.entity);
        let of_edges = part.edges.iter_mut().map(|edge| &mut edge.entity);
        of_faces.chain(of_edges).chain(part.shells.iter_mut().map(|shell| &mut shell.entity))
    });
    numbers.filter(|number| **number != 0).for_each(|number| *number = 3 * *number + 1);
    other
}

#[test]
fn entity_numbers_are_those_of_the_new_model_and_nothing_is_prepared_for_them() {
    for mut model in models() {
        // Faces with diagnostics tell their numbers.
        let part = model.parts.iter_mut().max_by_key(|part| part.faces.len()).unwrap();
        part.faces.pop();
        for (number, face) in (1..).zip(&mut part.faces) {
            face.entity = 10 * number;
        }
        part.shells.iter_mut().for_each(|shell| shell.entity = 5);
        let kept = |model: Model| Arc::new(prepare(model, &OPTIONS).unwrap());
        let (prepared, other) = (kept(model.clone()), saved_again(&model));
        let control = Control::default();
        let updated = Arc::new(prepared.update_on(&Alone, &other, &OPTIONS, &control).unwrap());
        assert_same(&updated, &other, &model.name);
        assert!(updated.diagnostics.iter().any(|told| told.entity != 0), "{:?}", updated.diagnostics);
        let faces =
            |prepared: &Prepared| format!("{:?}", prepared.parts.iter().map(|part| &part.faces).collect::<Vec<_>>());
        assert_eq!(faces(&updated), faces(&kept(other)), "{}", model.name);
        let view = crate::sessions::view_of(&prepared);
        assert_eq!(crate::sessions::tiles_of_update(&prepared, &updated, &view), 0, "{}", model.name);
    }
}
