//! Attributes of parts and instances: visibility, colour, tolerance, priority; alone, together, and while instances,
//! views and models change.

use super::counted::{CountedJobs, Counting};
use super::frames::{balanced, drawn, from_scratch, options, path};
use super::{prepared, shape};
use crate::random::SplitMix;
use glam::{DAffine3, DVec3};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;
use trimtess::control::Threads;
use trimtess::frame::{Attributes, PlanLimits, PlannerOptions};
use trimtess::mesh::{Batch, InstanceKey, MemorySink, SceneInstance, TileMesh};
use trimtess::model::{Colour, Instance, Model, PartId, TileId};
use trimtess::parallel::{EditError, Session};
use trimtess::prepare::{PrepareOptions, Prepared};
use trimtess::view::View;

const RED: Colour = [1.0, 0.0, 0.0, 1.0];
const GREEN: Colour = [0.0, 1.0, 0.0, 0.5];
const BLUE: Colour = [0.0, 0.0, 1.0, 1.0];
const PLAIN: Attributes = Attributes::DEFAULT;
const HIDDEN: Attributes = PLAIN.with_visible(false);

/// A torus, a washer placed twice and a sphere, named "0" to "3". The last instance is green.
fn trio() -> Model {
    let part = |name: &str| trimtess_models::by_name(name).unwrap().parts.swap_remove(0);
    let place = |(k, part): (usize, u32)| {
        let transform = DAffine3::from_translation(DVec3::new(14.0 * k as f64, 9.0 * (k * k) as f64, 2.0 * k as f64));
        let colour = (k == 3).then_some(GREEN);
        Instance { colour, name: k.to_string().into(), ..Instance::new(PartId(part), transform) }
    };
    Model {
        parts: ["torus", "washer", "sphere"].map(part).into(),
        instances: [0, 1, 1, 2].into_iter().enumerate().map(place).collect(),
        ..Model::default()
    }
}

/// The same without some instances.
fn without(names: &[&str]) -> Arc<Prepared> {
    let mut model = trio();
    model.instances.retain(|instance| !names.contains(&&*instance.name));
    prepared(model)
}

fn start(prepared: &Arc<Prepared>) -> Session {
    Session::start(Arc::clone(prepared), &options(2)).unwrap()
}

fn key(session: &Session, row: usize) -> InstanceKey {
    session.instance_key(row).unwrap()
}

/// The tiles that each instance draws in the first view, by its name.
fn pictured(sink: &MemorySink) -> BTreeMap<String, Vec<(TileId, &TileMesh)>> {
    let of_row = |row: usize| {
        let instance = &sink.scene.instances[row];
        let tiles = sink.batches.iter().filter(|b| b.part == instance.part && sink.drawn.contains(0, row, b.tile));
        (instance.name.to_string(), tiles.map(|batch| (batch.tile, &batch.mesh)).collect())
    };
    sink.drawn.instances(0).map(of_row).collect()
}

fn colours(sink: &MemorySink) -> Vec<Option<Colour>> {
    sink.scene.instances.iter().map(|instance| instance.colour).collect()
}

fn views(prepared: &Prepared, count: usize) -> Vec<View> {
    path(&mut SplitMix(31), prepared.bounds.unwrap(), count)
}

#[test]
fn what_is_hidden_is_as_if_it_were_not_there() {
    let all = without(&[]);
    let views = views(&all, 12);
    for names in [&["0"][..], &["1"], &["1", "2"], &["0", "3"], &["0", "1", "2", "3"]] {
        let lacking = without(names);
        for by_part in [false, true] {
            let (mut session, mut other) = (start(&all), start(&lacking));
            for name in names {
                let row: usize = name.parse().unwrap();
                match (by_part, row) {
                    (true, 0 | 3) => session.set_part(PartId([0, 1, 1, 2][row]), &HIDDEN).unwrap(),
                    (true, 1) if names.contains(&"2") => session.set_part(PartId(1), &HIDDEN).unwrap(),
                    _ => session.set_instance(key(&session, row), &HIDDEN).unwrap(),
                }
            }
            let (mut sink, mut fewer) = <(MemorySink, MemorySink)>::default();
            for (k, view) in views.iter().enumerate() {
                let reports = [session.view(&[*view], &mut sink), other.view(&[*view], &mut fewer)];
                let [tiles, expected] = reports.map(|report| report.unwrap().tiles);
                // The first frame of both is whole; later ones make nothing for what is hidden.
                assert_eq!(tiles, expected, "{names:?} {k}");
                assert!(pictured(&sink) == pictured(&fewer), "{names:?} {k}");
                let visible: Vec<bool> = sink.scene.instances.iter().map(|instance| instance.visible).collect();
                assert!(visible.iter().enumerate().all(|(row, &is)| is != names.contains(&&*row.to_string())));
            }
            assert!(pictured(&fewer).is_empty() == (names.len() == 4));
        }
    }
}

#[test]
fn what_is_shown_again_has_the_tiles_that_the_sink_still_has() {
    let all = without(&[]);
    let view = all_in_view(&all);
    let (mut session, mut sink) = (start(&all), Counting::default());
    session.view(&[view], &mut sink).unwrap();
    let before = sink.sink.drawn.clone();
    let second = key(&session, 1);
    for hide in [true, false, true, false] {
        session.set_part(PartId(0), &PLAIN.with_visible(!hide)).unwrap();
        session.set_instance(second, &PLAIN.with_visible(!hide)).unwrap();
        let report = session.view(&[view], &mut sink).unwrap();
        assert_eq!((report.tiles, report.evicted, report.whole), (0, 0, false));
        let shown: Vec<usize> = sink.sink.drawn.instances(0).collect();
        assert_eq!(shown, if hide { vec![2, 3] } else { vec![0, 1, 2, 3] });
        assert_eq!(drawn(&sink.sink), drawn(&from_scratch(&session)));
    }
    assert!(sink.sink.drawn == before && sink.frames == 5);
    // Where the camera went on meanwhile, the tiles are made that need it.
    session.set_part(PartId(0), &HIDDEN).unwrap();
    let mut closer = view;
    closer.camera.eye += 0.5 * view.camera.forward;
    session.view(&[closer], &mut sink).unwrap();
    session.set_part(PartId(0), &PLAIN).unwrap();
    assert!(session.view(&[closer], &mut sink).unwrap().tiles > 0);
    assert_eq!(drawn(&sink.sink), drawn(&from_scratch(&session)));
}

/// A view that shows every instance.
fn all_in_view(prepared: &Prepared) -> View {
    let [low, high] = prepared.bounds.unwrap();
    let (middle, size) = (0.5 * (low + high), (high - low).length());
    let mut view = views(prepared, 1)[0];
    view.camera.eye = middle + size * DVec3::new(0.3, -1.4, 0.9);
    view.camera.forward = middle - view.camera.eye;
    view
}

#[test]
fn a_scaled_tolerance_is_that_of_views_with_a_scaled_deviation() {
    for (name, size_px) in [("torus", None), ("brake-hub", None), ("washer", Some(40.0))] {
        let prepared = shape(name);
        for (of_part, of_instance) in [(0.5, 1.0), (1.0, 3.0), (0.37, 0.8), (4.0, 0.25)] {
            let (mut session, mut other) = (start(&prepared), start(&prepared));
            session.set_part(PartId(0), &PLAIN.with_tolerance_scale(of_part)).unwrap();
            session.set_instance(key(&session, 0), &PLAIN.with_tolerance_scale(of_instance)).unwrap();
            let (mut sink, mut expected, mut plain) = <(MemorySink, MemorySink, MemorySink)>::default();
            let by = of_part * of_instance;
            for (k, view) in views(&prepared, 10).into_iter().enumerate() {
                let view = View { size_px, ..view };
                let scaled = View { deviation_px: view.deviation_px * by, size_px: size_px.map(|s| s * by), ..view };
                let report = session.view(&[view], &mut sink).unwrap();
                let told = other.view(&[scaled], &mut expected).unwrap();
                // Powers of two, or no lengths: the tolerances are the same bits.
                if size_px.is_none() || by.log2().fract() == 0.0 {
                    assert_eq!((report.tiles, report.triangles), (told.tiles, told.triangles), "{name} {by} {k}");
                    assert!(drawn(&sink) == drawn(&expected), "{name} {by} {k}");
                }
            }
            let last = *views(&prepared, 10).last().unwrap();
            start(&prepared).view(&[View { size_px, ..last }], &mut plain).unwrap();
            let count = |sink: &MemorySink| drawn(sink).iter().map(|b| b.mesh.triangles.len()).sum::<usize>();
            let (scaled, plain) = (count(&sink), count(&plain));
            assert!((scaled > plain) == (by < 1.0) || by == 1.0, "{name}: {scaled} for {by}, {plain} for 1");
        }
    }
}

#[test]
fn instances_of_a_part_have_levels_by_their_own_tolerance() {
    let all = without(&[]);
    let view = all_in_view(&all);
    let (mut session, mut sink) = (start(&all), MemorySink::default());
    let triangles = |sink: &MemorySink, name: &str| -> usize {
        pictured(sink)[name].iter().map(|(_, mesh)| mesh.triangles.len()).sum()
    };
    session.view(&[view], &mut sink).unwrap();
    let before = ["1", "2"].map(|name| triangles(&sink, name));
    session.set_instance(key(&session, 1), &PLAIN.with_tolerance_scale(1.0 / 64.0)).unwrap();
    session.view(&[view], &mut sink).unwrap();
    let after = ["1", "2"].map(|name| triangles(&sink, name));
    assert!(after[0] > 3 * before[0] && after[1] == before[1], "{before:?} {after:?}");
    assert_ne!(sink.scene.instances[1].part, sink.scene.instances[2].part);
    assert_eq!(drawn(&sink), drawn(&from_scratch(&session)));
    balanced(session.prepared(), &session.plan().unwrap(), &drawn(&sink), "levels");
}

/// Two equal parts, side by side.
fn twins() -> Arc<Prepared> {
    let part = trimtess_models::by_name("brake-hub").unwrap().parts.swap_remove(0);
    let place = |k: u32| {
        let aside = DAffine3::from_translation(DVec3::X * 250.0 * f64::from(k));
        Instance { name: k.to_string().into(), ..Instance::new(PartId(k), aside) }
    };
    let parts = vec![part.clone(), part];
    prepared(Model { parts, instances: vec![place(0), place(1)], ..Model::default() })
}

#[test]
fn parts_of_high_priority_come_first_within_a_budget() {
    let prepared = twins();
    let view = all_in_view(&prepared);
    let planner = PlannerOptions::DEFAULT.with_budget(Some(Duration::from_micros(250)));
    // By part, by instance, and by both, where they are multiplied.
    for (first, by_part, by_instance) in [(0, 1e9, 1.0), (1, 1e9, 1.0), (0, 1.0, 1e9), (1, 1e-5, 1e14)] {
        let mut session = Session::start(Arc::clone(&prepared), &options(2).with_planner(planner)).unwrap();
        session.set_part(PartId(first), &PLAIN.with_priority(by_part)).unwrap();
        session.set_instance(key(&session, first as usize), &PLAIN.with_priority(by_instance)).unwrap();
        let mut sink = MemorySink::default();
        let (mut changed, mut frame, mut plan) = ([Vec::new(), Vec::new()], 0, None);
        loop {
            let report = session.view(&[view], &mut sink).unwrap();
            let now = session.plan().unwrap();
            if frame % 4 == 0 {
                balanced(session.prepared(), &now, &drawn(&sink), &format!("{first} {frame}"));
            }
            if let Some(before) = plan.replace(Arc::clone(&now)) {
                let differs = |p: &usize| before.parts[*p] != now.parts[*p];
                (0..2).filter(differs).for_each(|p| changed[p].push(frame));
            }
            if report.deferred == 0 {
                break;
            }
            frame += 1;
            assert!(frame < 1000, "{} tiles still wait", report.deferred);
        }
        let [one, other] = [first as usize, 1 - first as usize].map(|p| &changed[p]);
        let [end, begin] = [one.last().unwrap(), other.first().unwrap()];
        assert!(one.len() > 2 && other.len() > 2 && end <= begin, "{first}: {one:?} {other:?}");
        // Both are as exact as without priorities in the end.
        let mut whole = MemorySink::default();
        start(&prepared).view(&[view], &mut whole).unwrap();
        assert!(pictured(&sink) == pictured(&whole), "{first}");
    }
}

#[test]
fn colours_reach_the_sink_without_tiles() {
    let all = without(&[]);
    let view = all_in_view(&all);
    let (mut session, mut sink) = (start(&all), Counting::default());
    session.view(&[view], &mut sink).unwrap();
    let second = key(&session, 1);
    let painted = |colour| PLAIN.with_colour(colour);
    let steps = [
        (Some(RED), None, [None, Some(RED), Some(RED), Some(GREEN)]),
        (Some(RED), Some(BLUE), [None, Some(BLUE), Some(RED), Some(GREEN)]),
        (None, Some(BLUE), [None, Some(BLUE), None, Some(GREEN)]),
        (Some(BLUE), None, [None, Some(BLUE), Some(BLUE), Some(GREEN)]),
        (None, None, [None, None, None, Some(GREEN)]),
    ];
    for (k, (part, instance, expected)) in steps.into_iter().enumerate() {
        session.set_part(PartId(1), &painted(part)).unwrap();
        session.set_instance(second, &painted(instance)).unwrap();
        let report = session.view(&[view], &mut sink).unwrap();
        assert_eq!((report.tiles, report.whole, colours(&sink.sink)), (0, false, expected.to_vec()), "{k}");
        assert_eq!((sink.frames, session.scene().instances[1].colour), (k + 2, expected[1]));
    }
    // A colour of the model is overridden, and comes back.
    for (colour, seen) in [(Some(RED), RED), (None, GREEN)] {
        session.set_part(PartId(2), &painted(colour)).unwrap();
        session.view(&[view], &mut sink).unwrap();
        assert_eq!(colours(&sink.sink)[3], Some(seen));
    }
}

#[test]
fn a_frame_in_which_nothing_changes_makes_no_calls() {
    let all = without(&[]);
    let view = all_in_view(&all);
    let jobs = Arc::new(CountedJobs(Threads::start(2).unwrap(), AtomicUsize::new(0)));
    let mut session = Session::start_on(Arc::<CountedJobs>::clone(&jobs), Arc::clone(&all), &options(2));
    let mut sink = Counting::default();
    session.view(&[view], &mut sink).unwrap();
    let first = key(&session, 0);
    let edits: [&dyn Fn(&mut Session); 4] = [
        &|session| session.set_part(PartId(0), &PLAIN).unwrap(),
        &|session| {
            session.set_instance(first, &HIDDEN.with_colour(Some(RED))).unwrap();
            session.set_instance(first, &PLAIN).unwrap();
        },
        // Without a budget, nothing waits.
        &|session| session.set_part(PartId(1), &PLAIN.with_priority(7.0)).unwrap(),
        &|session| session.set_part(PartId(1), &PLAIN.with_priority(7.0)).unwrap(),
    ];
    for (k, edit) in edits.into_iter().enumerate() {
        edit(&mut session);
        let spawned = jobs.1.load(Ordering::Relaxed);
        session.begin(&[view]).unwrap();
        // Attributes that are as they were begin nothing, and those that are set back begin a frame without news.
        assert_eq!(jobs.1.load(Ordering::Relaxed) > spawned, k % 3 != 0, "{k}");
        let report = session.finish(&mut sink).unwrap();
        assert_eq!((report.tiles, sink.frames), (0, 1), "{k}");
    }
    // What is said between two frames is news to the next one, whatever becomes of the first.
    session.set_instance(first, &PLAIN.with_colour(Some(RED))).unwrap();
    session.begin(&[view]).unwrap();
    session.cancel();
    session.finish(&mut sink).unwrap();
    assert_eq!(colours(&sink.sink)[0], None);
    session.view(&[view], &mut sink).unwrap();
    assert_eq!((sink.frames, colours(&sink.sink)[0]), (2, Some(RED)));
    session.begin(&[view]).unwrap();
    session.set_instance(first, &PLAIN.with_colour(Some(BLUE))).unwrap();
    session.finish(&mut sink).unwrap();
    assert_eq!((sink.frames, colours(&sink.sink)[0]), (2, Some(RED)), "a frame that was begun goes on without it");
    sink.refuses = true;
    assert!(session.view(&[view], &mut sink).is_err());
    sink.refuses = false;
    assert!(session.view(&[view], &mut sink).unwrap().whole);
    assert_eq!(colours(&sink.sink)[0], Some(BLUE));
}

#[test]
fn instances_come_move_and_go_with_attributes() {
    let all = without(&[]);
    let view = all_in_view(&all);
    let (mut session, mut sink) = (start(&all), MemorySink::default());
    session.set_part(PartId(1), &PLAIN.with_colour(Some(RED))).unwrap();
    session.set_instance(key(&session, 3), &HIDDEN.with_colour(Some(BLUE))).unwrap();
    session.view(&[view], &mut sink).unwrap();
    let new = |part: u32, visible: bool| SceneInstance {
        part: PartId(part),
        visible,
        colour: (part == 0).then_some(GREEN),
        name: "new".into(),
        ..all.scene.instances[0].clone()
    };
    let [seen, unseen] = [(1, true), (0, false)].map(|(part, seen)| session.add_instance(new(part, seen)).unwrap());
    assert_eq!(session.instance_attributes(unseen), Ok(HIDDEN));
    session.view(&[view], &mut sink).unwrap();
    assert_eq!(colours(&sink)[4..], [Some(RED), Some(GREEN)]);
    assert_eq!(sink.drawn.instances(0).collect::<Vec<_>>(), [0, 1, 2, 4]);
    // Rows shift, attributes stay with their keys; also those that no frame has seen yet.
    let (third, last) = (key(&session, 2), key(&session, 3));
    session.set_instance(third, &HIDDEN).unwrap();
    session.set_instance(unseen, &PLAIN.with_colour(Some(BLUE))).unwrap();
    let gone = session.remove_instance(key(&session, 1)).unwrap();
    assert_eq!((gone.part, gone.colour, gone.visible, &*gone.name), (PartId(1), None, true, "1"));
    session.move_instance(third, DAffine3::IDENTITY).unwrap();
    session.view(&[view], &mut sink).unwrap();
    assert_eq!(sink.drawn.instances(0).collect::<Vec<_>>(), [0, 3, 4]);
    assert_eq!(colours(&sink)[1..], [Some(RED), Some(BLUE), Some(RED), Some(BLUE)]);
    assert_eq!(drawn(&sink), drawn(&from_scratch(&session)));
    let gone = session.remove_instance(last).unwrap();
    assert_eq!((gone.colour, gone.visible), (Some(GREEN), false));
    assert_eq!(session.instance_attributes(last), Err(EditError::NoInstance { key: last }));
    // One that moved while it was hidden is where it is now.
    session.set_instance(third, &PLAIN).unwrap();
    session.view(&[view], &mut sink).unwrap();
    assert_eq!(sink.drawn.instances(0).collect::<Vec<_>>(), [0, 1, 2, 3]);
    assert_eq!(sink.scene.instances[1].transform, DAffine3::IDENTITY);
    assert_eq!(drawn(&sink), drawn(&from_scratch(&session)));
    assert_eq!(session.instance_attributes(seen), Ok(PLAIN));
}

#[test]
fn a_scene_that_hides_instances_starts_so() {
    let mut all = Prepared::clone(&without(&[]));
    all.scene.instances[2].visible = false;
    let all = Arc::new(all);
    let (mut session, mut sink) = (start(&all), MemorySink::default());
    let view = all_in_view(&all);
    session.view(&[view], &mut sink).unwrap();
    assert_eq!(sink.drawn.instances(0).collect::<Vec<_>>(), [0, 1, 3]);
    let third = key(&session, 2);
    assert_eq!(session.instance_attributes(third), Ok(HIDDEN));
    session.set_instance(third, &PLAIN).unwrap();
    session.view(&[view], &mut sink).unwrap();
    assert_eq!(sink.drawn.instances(0).count(), 4);
}

#[test]
fn parts_that_go_on_keep_their_attributes_in_an_updated_model() {
    let mut model = trio();
    let before = prepared(model.clone());
    let (mut session, mut sink) = (start(&before), Counting::default());
    let red = PLAIN.with_colour(Some(RED)).with_tolerance_scale(0.25);
    session.set_part(PartId(1), &red).unwrap();
    session.set_part(PartId(2), &HIDDEN).unwrap();
    let view = all_in_view(&before);
    session.view(&[view], &mut sink).unwrap();
    // Said, but not yet seen by a frame.
    let blue = PLAIN.with_colour(Some(BLUE));
    session.set_part(PartId(0), &blue).unwrap();
    let second = key(&session, 1);
    session.set_instance(second, &HIDDEN).unwrap();
    // Another part first; the torus is replaced by another one.
    let new = |name: &str| trimtess_models::by_name(name).unwrap().parts.swap_remove(0);
    model.parts.insert(0, new("cone"));
    model.parts[1] = new("box");
    model.instances.iter_mut().for_each(|instance| instance.part.0 += 1);
    let after = Arc::new(before.update(model, &PrepareOptions::DEFAULT).unwrap());
    session.update(Arc::clone(&after)).unwrap();
    let attributes = [0, 1, 2, 3].map(|part| session.part_attributes(PartId(part)).unwrap());
    assert_eq!(attributes, [PLAIN, PLAIN, red, HIDDEN]);
    assert_eq!(session.instance_attributes(second), Err(EditError::NoInstance { key: second }));
    assert_eq!(session.instance_attributes(key(&session, 1)), Ok(PLAIN));
    let report = session.view(&[view], &mut sink).unwrap();
    assert!(!report.whole && sink.sink.drawn.instances(0).eq([0, 1, 2]));
    assert_eq!(colours(&sink.sink), [None, Some(RED), Some(RED), Some(GREEN)]);
    assert_eq!(drawn(&sink.sink), drawn(&from_scratch(&session)));
    let (mut fresh, mut other) = (start(&after), MemorySink::default());
    fresh.set_part(PartId(2), &red).unwrap();
    fresh.set_part(PartId(3), &HIDDEN).unwrap();
    fresh.view(&[view], &mut other).unwrap();
    assert!(pictured(&sink.sink) == pictured(&other));
    // The cleared ones are forgotten for good.
    session.set_part(PartId(3), &PLAIN).unwrap();
    session.view(&[view], &mut sink).unwrap();
    assert_eq!(sink.sink.drawn.instances(0).count(), 4);
}

#[test]
fn what_cannot_be_is_refused_with_numbers_and_changes_nothing() {
    let all = without(&[]);
    let view = all_in_view(&all);
    let (mut session, mut sink) = (start(&all), Counting::default());
    session.view(&[view], &mut sink).unwrap();
    let first = key(&session, 0);
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for (name, wrong) in
            [("tolerance_scale", HIDDEN.with_tolerance_scale(value)), ("priority", HIDDEN.with_priority(value))]
        {
            for error in [session.set_part(PartId(0), &wrong), session.set_instance(first, &wrong)] {
                let error = error.unwrap_err();
                assert!(matches!(error, EditError::Factor { name: of, .. } if of == name), "{error}");
                assert_eq!(error.to_string(), format!("{name} is {value}; it must be finite and above 0"));
            }
        }
    }
    for colour in [[0.0, 0.0, 0.0, 1.1], [-0.1, 0.0, 0.0, 1.0], [0.0, f32::NAN, 0.0, 1.0]] {
        let error = session.set_part(PartId(0), &PLAIN.with_colour(Some(colour))).unwrap_err();
        assert!(matches!(error, EditError::Colour { .. }) && error.to_string().contains("from 0 to 1"), "{error}");
    }
    let none = EditError::NoPart { part: PartId(3), count: 3 };
    assert_eq!(none.to_string(), "no part 3; the model has 3");
    assert_eq!(session.set_part(PartId(3), &PLAIN), Err(none.clone()));
    assert_eq!(session.part_attributes(PartId(3)), Err(none));
    assert!(session.scene().parts.len() > 3, "a level of detail is no part of the model");
    session.remove_instance(first).unwrap();
    let none = EditError::NoInstance { key: first };
    assert_eq!(session.set_instance(first, &PLAIN), Err(none.clone()));
    assert!(none.to_string().contains("removed"));
    session.view(&[view], &mut sink).unwrap();
    assert_eq!(sink.sink.drawn.instances(0).count(), 3);
}

#[test]
fn factors_of_any_size_draw_all_that_is_visible() {
    let all = without(&[]);
    let view = all_in_view(&all);
    let limits = PlanLimits::DEFAULT.with_triangles(20_000);
    let planner = PlannerOptions::DEFAULT.with_limits(limits).with_budget(Some(Duration::from_millis(1)));
    for far in [f64::MIN_POSITIVE, 1e-9, 1e9, f64::MAX] {
        let mut session = Session::start(Arc::clone(&all), &options(2).with_planner(planner)).unwrap();
        let mut sink = MemorySink::default();
        for scale in [far, 1.0, 1.0 / far] {
            let attributes = PLAIN.with_tolerance_scale(scale).with_priority(far);
            session.set_part(PartId(1), &attributes).unwrap();
            session.set_instance(key(&session, 1), &attributes).unwrap();
            for _ in 0..3 {
                session.view(&[view], &mut sink).unwrap();
            }
            assert_eq!(sink.drawn.instances(0).count(), 4, "{far} {scale}");
            assert_eq!(drawn(&sink), drawn(&from_scratch(&session)), "{far} {scale}");
            balanced(session.prepared(), &session.plan().unwrap(), &drawn(&sink), &format!("{far} {scale}"));
        }
    }
}

/// Random attributes, of which a third are hidden.
fn random(draw: &mut SplitMix) -> Attributes {
    let colours = [None, Some(RED), Some(BLUE)];
    PLAIN
        .with_visible(draw.below(3) > 0)
        .with_colour(colours[draw.below(3) as usize])
        .with_tolerance_scale(draw.range(-2.0, 2.0).exp2())
        .with_priority(draw.range(-8.0, 8.0).exp2())
}

/// Edits a session at random: attributes, and sometimes instances. The same for the same numbers.
fn edit(session: &mut Session, draw: &mut SplitMix) {
    for _ in 0..draw.below(4) {
        let row = draw.below(session.scene().instances.len() as u64) as usize;
        let of_row = key(session, row);
        match draw.below(8) {
            0..3 => session.set_instance(of_row, &random(draw)).unwrap(),
            3..6 => session.set_part(PartId(draw.below(3) as u32), &random(draw)).unwrap(),
            6 => {
                let aside = DAffine3::from_translation(DVec3::from([0; 3].map(|_| draw.range(-40.0, 40.0))));
                session.move_instance(of_row, aside).unwrap();
            }
            _ if draw.below(2) == 0 && row > 2 => _ = session.remove_instance(of_row).unwrap(),
            _ => {
                let part = session.part_of(row).unwrap();
                let visible = draw.below(2) == 0;
                let new = SceneInstance { part, visible, ..session.scene().instances[row].clone() };
                session.add_instance(new).unwrap();
            }
        }
    }
}

#[test]
fn random_attributes_leave_no_crack_and_do_not_depend_on_workers() {
    let all = without(&[]);
    let views = views(&all, 40);
    for budget in [None, Some(Duration::from_micros(300))] {
        let planner = PlannerOptions::DEFAULT.with_budget(budget);
        let frames = |workers: usize| {
            let options = options(workers).with_planner(planner).with_edge_lines(true);
            let mut session = Session::start(Arc::clone(&all), &options).unwrap();
            let (mut sink, mut draw, mut frames) = (MemorySink::default(), SplitMix(77), Vec::new());
            for (k, view) in views.iter().enumerate() {
                edit(&mut session, &mut draw);
                if draw.below(5) == 0 {
                    session.begin(&[*view]).unwrap();
                    session.cancel();
                }
                session.view(&[*view], &mut sink).unwrap();
                let rows = session.scene().instances.len();
                let shows = |row: usize| {
                    let of_part = session.part_attributes(session.part_of(row).unwrap()).unwrap();
                    session.instance_attributes(key(&session, row)).unwrap().visible && of_part.visible
                };
                assert!(sink.drawn.instances(0).all(shows), "{k}");
                assert!((0..rows).all(|row| sink.scene.instances[row].visible == shows(row)), "{k}");
                if workers == 1 {
                    let batches = drawn(&sink);
                    assert_eq!(batches, drawn(&from_scratch(&session)), "{k}");
                    balanced(session.prepared(), &session.plan().unwrap(), &batches, &format!("{k}"));
                }
                let batches: Vec<Batch> = sink.batches.iter().cloned().map(|b| Batch { worker: 0, ..b }).collect();
                frames.push((batches, sink.edge_lines.clone(), sink.drawn.clone(), sink.scene.clone()));
            }
            frames
        };
        let one = frames(1);
        for workers in [2, 3, 8] {
            assert!(frames(workers) == one, "{workers} workers");
        }
    }
}
