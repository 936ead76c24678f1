//! A limit on the bytes that a sink holds.

use super::counted::Counting;
use super::frames::{balanced, drawn, from_scratch, options, path};
use super::shape;
use crate::random::SplitMix;
use std::sync::Arc;
use trimtess::mesh::{Batch, MemorySink};
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::Prepared;
use trimtess::view::View;

fn bytes(batches: &[Batch]) -> u64 {
    batches.iter().map(|batch| batch.mesh.bytes() as u64).sum()
}

fn close_ups(prepared: &Prepared) -> Vec<View> {
    let mut draw = SplitMix(11);
    path(&mut draw, prepared.bounds.unwrap(), 150)
}

fn start(prepared: &Arc<Prepared>, options: SessionOptions, most: Option<u64>) -> Session {
    Session::start(Arc::clone(prepared), &options.with_resident_bytes(most)).unwrap()
}

#[test]
fn a_sink_holds_no_more_than_it_may_and_what_is_drawn_and_new() {
    for name in ["trimmed-teapot", "brake-hub"] {
        let prepared = shape(name);
        let views = close_ups(&prepared);
        let mut free = MemorySink::default();
        let mut session = start(&prepared, options(2), None);
        let mut peak = 0;
        for &view in &views {
            session.view(&[view], &mut free).unwrap();
            peak = peak.max(bytes(&free.batches));
        }
        // A camera that jumps and rests there: what it saw before goes.
        for (&from, &to) in views.iter().zip(&views[75..]).step_by(10) {
            let (mut session, mut sink) = (start(&prepared, options(2), Some(0)), MemorySink::default());
            for view in [from, to, to] {
                session.view(&[view], &mut sink).unwrap();
            }
            assert_eq!(bytes(&sink.batches), bytes(&drawn(&sink)), "{name}");
        }
        let mut evicted = 0;
        for most in [0, peak / 4, peak / 2, peak] {
            let mut session = start(&prepared, options(2), Some(most));
            let mut sink = Counting::default();
            for (k, &view) in views.iter().enumerate() {
                sink.sent = 0;
                let report = session.view(&[view], &mut sink).unwrap();
                let shown = drawn(&sink.sink);
                let (held, shown_bytes) = (bytes(&sink.sink.batches), bytes(&shown));
                assert!(held <= most.max(shown_bytes) + sink.sent, "{name} {most} {k}: {held}, {shown_bytes} drawn");
                assert!(shown == drawn(&from_scratch(&session)), "{name} {most} {k}");
                balanced(&prepared, &session.plan().unwrap(), &shown, &format!("{name} {most} {k}"));
                evicted += report.evicted;
            }
            // A still camera: what was over goes, then nothing happens.
            let last = *views.last().unwrap();
            session.view(&[last], &mut sink).unwrap();
            let shown = bytes(&drawn(&sink.sink));
            assert!(bytes(&sink.sink.batches) <= most.max(shown), "{name} {most}");
            sink.sent = 0;
            let still = session.view(&[last], &mut sink).unwrap();
            assert_eq!((still.evicted, sink.sent), (0, 0), "{name} {most}");
        }
        assert!(evicted > 0, "{name}");
    }
}

#[test]
fn what_is_evicted_does_not_depend_on_workers() {
    let prepared = shape("trimmed-teapot");
    let views = close_ups(&prepared);
    let held = |workers: usize| {
        let mut session = start(&prepared, options(workers), Some(200_000));
        let mut sink = MemorySink::default();
        let tiles = |sink: &MemorySink| sink.batches.iter().map(|batch| (batch.part, batch.tile)).collect::<Vec<_>>();
        let frames = views.iter().map(|&view| {
            session.view(&[view], &mut sink).unwrap();
            tiles(&sink)
        });
        frames.collect::<Vec<_>>()
    };
    let one = held(1);
    assert!(held(2) == one && held(7) == one);
}
