//! Instances that come and go by the hundred: as one by one, and refused without a change.

use super::frames::{drawn, from_scratch, options, path};
use crate::common::prepared;
use crate::random::SplitMix;
use glam::{DAffine3, DVec3};
use std::sync::Arc;
use trimtess::mesh::{InstanceKey, MemorySink, SceneInstance};
use trimtess::model::{ModelBuilder, PartId};
use trimtess::parallel::{EditError, Session};
use trimtess::prepare::Prepared;

/// Parts in a row, each placed once.
fn parts() -> Arc<Prepared> {
    let mut model = ModelBuilder::new("parts");
    for (k, name) in ["box", "torus", "washer", "sphere"].into_iter().enumerate() {
        let part = model.part(trimtess_models::by_name(name).unwrap().parts.swap_remove(0));
        model.place(part, DAffine3::from_translation(DVec3::X * (80.0 * k as f64)));
    }
    prepared(model.finish().unwrap())
}

fn rows(session: &Session) -> Vec<(PartId, DVec3, bool, u32, Option<InstanceKey>)> {
    let rows = session.scene().instances.iter().enumerate();
    let of_row = |(row, placed): (usize, &SceneInstance)| {
        let place = placed.transform.translation;
        (placed.part, place, placed.visible, placed.first_face, session.instance_key(row))
    };
    rows.map(of_row).collect()
}

#[test]
fn instances_that_go_together_leave_the_same_as_one_by_one() {
    let prepared = parts();
    let view = path(&mut SplitMix(1), prepared.bounds.unwrap(), 1)[0];
    let mut sessions: Vec<Session> =
        (0..2).map(|_| Session::start(Arc::clone(&prepared), &options(2)).unwrap()).collect();
    let mut sinks = [MemorySink::default(), MemorySink::default()];
    let mut keys = Vec::new();
    for (session, sink) in sessions.iter_mut().zip(&mut sinks) {
        session.view(&[view], sink).unwrap();
        keys = (0..4).map(|row| session.instance_key(row).unwrap()).collect();
        for k in 0..200 {
            let instance = &prepared.scene.instances[k % 4];
            let transform = DAffine3::from_translation(DVec3::Y * (60.0 * k as f64)) * instance.transform;
            keys.push(
                session.add_instance(SceneInstance { transform, visible: k % 7 > 0, ..instance.clone() }).unwrap(),
            );
            // Parts have the levels of their instances at once, whoever asks.
            let scene = session.scene();
            assert!(k % 50 > 0 || session.prepared().parts.len() == scene.parts.len());
            assert!(k % 50 > 0 || session.prepared().scene.parts.len() == scene.parts.len());
        }
        session.view(&[view], sink).unwrap();
        assert_eq!(drawn(sink), drawn(&from_scratch(session)));
        assert_eq!(session.prepared().parts.len(), 16);
    }
    let mut draw = SplitMix(5);
    let mut going: Vec<InstanceKey> = keys.iter().copied().filter(|_| draw.unit() < 0.6).collect();
    going.reverse();
    let before = rows(&sessions[0]);
    let twice = [going[3], going[5], going[3]];
    assert_eq!(sessions[0].remove_instances(&twice).unwrap_err(), EditError::NoInstance { key: going[3] });
    assert!(sessions[0].remove_instances(&[]).unwrap().is_empty() && rows(&sessions[0]) == before);
    let together = sessions[0].remove_instances(&going).unwrap();
    let single: Vec<SceneInstance> = going.iter().map(|key| sessions[1].remove_instance(*key).unwrap()).collect();
    for (a, b) in together.iter().zip(&single) {
        assert_eq!((a.part, a.transform, a.visible, a.colour), (b.part, b.transform, b.visible, b.colour));
    }
    assert_eq!((together.len(), rows(&sessions[0])), (single.len(), rows(&sessions[1])));
    let gone = sessions[0].remove_instances(&[going[0]]).unwrap_err();
    assert_eq!(gone, EditError::NoInstance { key: going[0] });
    for key in &keys {
        let row = sessions[0].instance_row(*key);
        assert_eq!((row, row.is_none()), (sessions[1].instance_row(*key), going.contains(key)));
    }
    for (session, sink) in sessions.iter_mut().zip(&mut sinks) {
        session.view(&[view], sink).unwrap();
        assert_eq!(drawn(sink), drawn(&from_scratch(session)));
    }
    assert_eq!(drawn(&sinks[0]), drawn(&sinks[1]));
}

#[test]
fn instances_in_colours_that_are_none_are_refused() {
    let prepared = parts();
    let mut session = Session::start(Arc::clone(&prepared), &options(1)).unwrap();
    for colour in [[f32::NAN, 0.0, 0.0, 1.0], [0.0, 1.5, 0.0, 1.0], [0.0, 0.0, -0.1, 1.0]] {
        let new = SceneInstance { colour: Some(colour), ..prepared.scene.instances[0].clone() };
        let error = session.add_instance(new).unwrap_err();
        assert_eq!(error.to_string(), format!("the colour is {colour:?}; its numbers must be from 0 to 1"));
    }
    assert_eq!(session.scene().instances.len(), 4);
    let new = SceneInstance { colour: Some([0.0, 0.5, 1.0, 1.0]), ..prepared.scene.instances[0].clone() };
    assert!(session.add_instance(new).is_ok());
}
