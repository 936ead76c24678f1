//! Saved plans -> the same frames.

use super::frames::{drawn, options, path};
use super::shape;
use crate::random::SplitMix;
use std::sync::Arc;
use trimtess::frame::Plan;
use trimtess::mesh::MemorySink;
use trimtess::parallel::Session;

#[test]
fn saved_plans_make_the_same_frames_again() {
    let prepared = shape("brake-hub");
    let mut session = Session::start(Arc::clone(&prepared), &options(2)).unwrap();
    let mut sink = MemorySink::default();
    let mut kept = Vec::new();
    for view in path(&mut SplitMix(11), prepared.bounds.unwrap(), 20) {
        session.view(&[view], &mut sink).unwrap();
        let mut bytes = Vec::new();
        ciborium::into_writer(&*session.plan().unwrap(), &mut bytes).unwrap();
        kept.push((bytes, session.plan().unwrap(), drawn(&sink)));
    }
    assert!(kept.windows(2).any(|pair| pair[0].1.parts != pair[1].1.parts));
    let mut session = Session::start(prepared, &options(3)).unwrap();
    for (bytes, plan, batches) in kept {
        let again: Plan = ciborium::from_reader(&bytes[..]).unwrap();
        assert_eq!(again, *plan);
        let mut sink = MemorySink::default();
        session.frame(again, &mut sink).unwrap();
        sink.drawn = plan.drawn.clone();
        assert_eq!(drawn(&sink), batches);
    }
}
