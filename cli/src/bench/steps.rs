//! A flight on one thread, recorded by the spans of the library -> the time of each step of a frame on any number of
//! threads. All times are by the clock: to ask the system for a thread's own time takes 0.8 µs, and a frame has 600
//! calls. A call that another process interrupts would seem to hold up all others, so the quickest of several rounds
//! counts.

use super::costs::hand_off;
use super::flight::{anew, ms};
use super::uploads::Uploads;
use crate::{Common, Failure};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tracing::span::{Attributes, Id, Record as Values};
use tracing::{Dispatch, Event, Metadata, Subscriber, dispatcher};
use trimtess::control::{Job, Jobs, Priority};
use trimtess::mesh::VertexLayout;
use trimtess::parallel::Session;
use trimtess::prepare::Prepared;
use trimtess::view::View;

/// Spans of a frame's steps, in their order; then those of a loop and its calls, within them.
const STEPS: [&str; 13] =
    ["show", "plan", "see", "look", "defer", "lattices", "tessellants", "owe", "tiles", "commit", "free", LOOP, CALL];
const LOOP: &str = "loop";
const CALL: &str = "call";
/// What is in no step.
const REST: &str = "rest";

/// Numbers of threads for which frames are computed.
pub(super) const THREADS: [usize; 6] = [1, 2, 4, 8, 16, 32];

/// Times of a frame on numbers of threads, computed from the times of its steps and of their calls on one thread.
/// Milliseconds, means over the frames of a flight.
#[derive(Serialize)]
pub(super) struct Replayed {
    /// `cold` or `coherent`.
    coherence: &'static str,
    frames: usize,
    threads: Vec<usize>,
    steps: Vec<StepTimes>,
    /// All steps.
    frame_ms: Vec<f64>,
    /// What one thread does while the others wait.
    not_divided_ms: Vec<f64>,
    /// What all threads do together.
    work_ms: Vec<f64>,
    speedup: Vec<f64>,
    /// How long the calls of all loops wait for threads, as measured for a loop without work. Not in the other times.
    hand_offs_ms: Vec<f64>,
    /// By the clock, where this machine has as many threads.
    measured_ms: Vec<Option<f64>>,
}

/// A step's time by the number of threads.
#[derive(Serialize)]
struct StepTimes {
    name: &'static str,
    ms: Vec<f64>,
    not_divided_ms: Vec<f64>,
}

/// What one step did in a frame.
#[derive(Clone, Debug, Default, PartialEq)]
struct Step {
    /// Outside of calls.
    alone: Duration,
    /// The calls of each loop, in their order.
    loops: Vec<Vec<Duration>>,
}

type Frame = BTreeMap<&'static str, Step>;

/// A span that is open.
struct Open {
    name: &'static str,
    begun: Instant,
    /// Time in spans within.
    inside: Duration,
    /// The calls of a loop.
    calls: Vec<Duration>,
    /// When the last of them ended.
    called: Option<Instant>,
}

/// Adds up the spans of one thread.
#[derive(Clone, Default)]
struct Recorder(Arc<Mutex<Record>>);

#[derive(Default)]
struct Record {
    open: Vec<Open>,
    frame: Frame,
}

impl Recorder {
    fn open(&self) -> MutexGuard<'_, Record> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What was recorded since the last call, with `whole` as the time of all of it.
    fn take(&self, whole: Duration) -> Frame {
        let mut frame = std::mem::take(&mut self.open().frame);
        let known: Duration = frame.values().map(Step::work).sum();
        frame.entry(REST).or_default().alone += whole.saturating_sub(known);
        frame
    }
}

impl Record {
    /// A call begins where the one before it ends: each thread goes on to its next call by itself.
    fn enter(&mut self, name: &'static str) {
        let called = self.open.last().and_then(|around| around.called.filter(|_| name == CALL));
        let begun = called.unwrap_or_else(Instant::now);
        self.open.push(Open { name, begun, inside: Duration::ZERO, calls: Vec::new(), called: None });
    }

    fn exit(&mut self) {
        let Some(Open { name, begun, inside, calls, .. }) = self.open.pop() else { return };
        let ended = Instant::now();
        let took = ended - begun;
        if let Some(around) = self.open.last_mut() {
            around.inside += took;
            if name == CALL {
                around.calls.push(took);
                around.called = Some(ended);
                return;
            }
        }
        let step = if name == LOOP { self.open.last().map_or(REST, |around| around.name) } else { name };
        let step = self.frame.entry(step).or_default();
        step.alone += took.saturating_sub(inside);
        if name == LOOP {
            step.loops.push(calls);
        }
    }
}

/// Keeps no list of spans: to look one up, between calls that fill the caches, takes longer than what is measured.
///
/// A span counts from when it is made to when it is closed, a call from the end of the one before it: what tracing does
/// for a call is part of it.
impl Subscriber for Recorder {
    fn enabled(&self, of: &Metadata<'_>) -> bool {
        // Asked for every call of every loop.
        of.is_span() && (of.name() == CALL || STEPS.contains(&of.name()))
    }

    fn new_span(&self, span: &Attributes<'_>) -> Id {
        self.open().enter(span.metadata().name());
        Id::from_u64(1)
    }

    fn try_close(&self, _: Id) -> bool {
        self.open().exit();
        true
    }

    fn enter(&self, _: &Id) {}

    fn exit(&self, _: &Id) {}

    fn record(&self, _: &Id, _: &Values<'_>) {}

    fn record_follows_from(&self, _: &Id, _: &Id) {}

    fn event(&self, _: &Event<'_>) {}
}

/// Cuts work for many threads, and has the caller do all of it.
struct OneOf(usize);

impl Jobs for OneOf {
    fn width(&self) -> usize {
        self.0
    }

    fn spawn(&self, _: Priority, _: Job) {}
}

/// The time in which `threads` threads make the calls of a loop: each takes the next call as soon as it is free.
fn makespan(calls: &[Duration], threads: usize) -> Duration {
    let mut free = vec![Duration::ZERO; threads.max(1)];
    for call in calls {
        if let Some(first) = free.iter_mut().min() {
            *first += *call;
        }
    }
    free.into_iter().max().unwrap_or_default()
}

impl Step {
    fn work(&self) -> Duration {
        self.alone + self.loops.iter().flatten().sum::<Duration>()
    }

    fn on(&self, threads: usize) -> Duration {
        self.alone + self.loops.iter().map(|calls| makespan(calls, threads)).sum::<Duration>()
    }
}

/// A flight on one thread, with work cut for many.
struct Column {
    recorder: Recorder,
    spans: Dispatch,
    session: Session,
    sink: Uploads,
    /// Of each frame the quickest round, with its time.
    frames: Vec<(Duration, Frame)>,
}

impl Column {
    fn of(prepared: &Arc<Prepared>, threads: usize, common: &Common) -> Self {
        let recorder = Recorder::default();
        let spans = Dispatch::new(recorder.clone());
        let options = common.limits.session().with_edge_lines(false);
        let mut session = Session::start_on(Arc::new(OneOf(threads)), Arc::clone(prepared), &options);
        let sink = Uploads::written_by(&mut session, VertexLayout::COMPACT);
        Self { recorder, spans, session, sink, frames: Vec::new() }
    }

    /// Flies once more.
    fn fly(&mut self, views: &[View], cold: bool, common: &Common) -> Result<(), Failure> {
        let Self { recorder, spans, session, sink, frames } = self;
        session.forget();
        for (k, view) in views.iter().enumerate() {
            sink.next_frame();
            let begun = Instant::now();
            dispatcher::with_default(spans, || {
                if cold {
                    anew(session, view, sink, common).map(drop)
                } else {
                    session.view(&[*view], sink).map(drop).map_err(Failure::cannot)
                }
            })?;
            let whole = begun.elapsed();
            let frame = (whole, recorder.take(whole));
            match frames.get_mut(k) {
                Some(known) if known.0 > whole => *known = frame,
                None => frames.push(frame),
                Some(_) => {}
            }
        }
        Ok(())
    }
}

/// Flies on one thread, with work cut for 1, 2, 4 … threads. Each round flies all of them in turn, so that a machine
/// that is slower for a while is slower for all.
fn flown(
    (prepared, views, rounds): (&Arc<Prepared>, &[View], u32),
    cold: bool,
    common: &Common,
) -> Result<Vec<Vec<Frame>>, Failure> {
    let mut columns = THREADS.map(|threads| Column::of(prepared, threads, common));
    for _ in 0..rounds {
        columns.iter_mut().try_for_each(|column| column.fly(views, cold, common))?;
    }
    // A session's first frame is whole, however the others are made.
    let first = usize::from(!cold && views.len() > 1);
    let frames = |column: Column| column.frames.into_iter().skip(first).map(|(_, frame)| frame).collect();
    Ok(columns.into_iter().map(frames).collect())
}

/// Computes the frames of a flight. `measured`: frames by the clock, by the number of threads.
pub(super) fn replay(
    flight: (&Arc<Prepared>, &[View], u32),
    cold: bool,
    measured: &[(usize, f64)],
    common: &Common,
) -> Result<Replayed, Failure> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = THREADS.to_vec();
    let mut steps: BTreeMap<&'static str, StepTimes> = BTreeMap::new();
    let (mut work_ms, mut hand_offs_ms, mut measured_ms, mut count) = (Vec::new(), Vec::new(), Vec::new(), 0);
    for (column, (&n, frames)) in threads.iter().zip(flown(flight, cold, common)?).enumerate() {
        count = frames.len();
        let mean = |sum: Duration| ms(sum) / count.max(1) as f64;
        for (name, step) in frames.iter().flatten() {
            let empty = || StepTimes { name, ms: vec![0.0; threads.len()], not_divided_ms: vec![0.0; threads.len()] };
            let times = steps.entry(name).or_insert_with(empty);
            times.ms[column] += mean(step.on(n));
            times.not_divided_ms[column] += mean(step.alone);
        }
        work_ms.push(mean(frames.iter().flat_map(BTreeMap::values).map(Step::work).sum()));
        let loops: usize = frames.iter().flat_map(BTreeMap::values).map(|step| step.loops.len()).sum();
        let one = if n == 1 { 0.0 } else { hand_off(n.min(cores))? };
        hand_offs_ms.push(one * loops as f64 / count.max(1) as f64);
        measured_ms.push(measured.iter().find(|(threads, _)| *threads == n).map(|(_, ms)| *ms));
    }
    let order = |name: &str| STEPS.iter().position(|step| *step == name).unwrap_or(STEPS.len());
    let mut steps: Vec<StepTimes> = steps.into_values().collect();
    steps.sort_by_key(|step| order(step.name));
    let sums = |of: fn(&StepTimes) -> &[f64]| -> Vec<f64> {
        (0..threads.len()).map(|column| steps.iter().map(|step| of(step)[column]).sum()).collect()
    };
    let (frame_ms, not_divided_ms) = (sums(|step| &step.ms), sums(|step| &step.not_divided_ms));
    let speedup = frame_ms.iter().map(|ms| frame_ms[0] / ms).collect();
    let coherence = if cold { "cold" } else { "coherent" };
    Ok(Replayed {
        coherence,
        frames: count,
        threads,
        steps,
        frame_ms,
        not_divided_ms,
        work_ms,
        speedup,
        hand_offs_ms,
        measured_ms,
    })
}

impl Replayed {
    /// The times as a table.
    pub(super) fn tell(&self, text: &mut String) {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{} frames, computed from {} frames on one thread: ms (of that, what is not divided)",
            self.coherence, self.frames
        );
        let _ = write!(text, "{:<16}", "threads");
        self.threads.iter().for_each(|n| _ = write!(text, " {n:>16}"));
        let steps = self.steps.iter().map(|step| (step.name, &step.ms, &step.not_divided_ms));
        for (name, ms, alone) in steps.chain([("frame", &self.frame_ms, &self.not_divided_ms)]) {
            let _ = write!(text, "\n{name:<16}");
            ms.iter().zip(alone).for_each(|(ms, alone)| _ = write!(text, " {ms:>8.3} ({alone:>5.3})"));
        }
        let rows = [("speedup", &self.speedup, 2), ("work", &self.work_ms, 3), ("hand-offs", &self.hand_offs_ms, 3)];
        for (name, cells, digits) in rows {
            let _ = write!(text, "\n{name:<16}");
            cells.iter().for_each(|x| _ = write!(text, " {x:>16.digits$}"));
        }
        let _ = write!(text, "\n{:<16}", "by the clock");
        for ms in &self.measured_ms {
            let _ = write!(text, " {:>16}", ms.map_or_else(|| "-".to_owned(), |ms| format!("{ms:.3}")));
        }
        text.push('\n');
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_take_the_next_call_when_they_are_free() {
        let calls = [3, 1, 1, 1, 4].map(Duration::from_millis);
        let of = |threads| makespan(&calls, threads).as_millis();
        assert_eq!([of(1), of(2), of(3), of(5), of(9)], [10, 7, 5, 4, 4]);
        assert_eq!(makespan(&[], 4), Duration::ZERO);
        let step = Step { alone: Duration::from_millis(2), loops: vec![calls.to_vec(), calls[..2].to_vec()] };
        assert_eq!(step.on(2), Duration::from_millis(2 + 7 + 3));
        assert_eq!(step.work(), Duration::from_millis(2 + 10 + 4));
    }

    #[test]
    fn spans_are_added_up_by_step() {
        let recorder = Recorder::default();
        let spans = Dispatch::new(recorder.clone());
        dispatcher::with_default(&spans, || {
            tracing::trace_span!("plan").in_scope(|| {
                tracing::trace_span!("look").in_scope(|| {
                    for calls in [2, 3] {
                        tracing::trace_span!("loop").in_scope(|| {
                            (0..calls).for_each(|_| tracing::trace_span!("call").in_scope(|| ()));
                        });
                    }
                });
            });
        });
        let frame = recorder.take(Duration::from_secs(1));
        assert_eq!(frame.keys().copied().collect::<Vec<_>>(), ["look", "plan", REST]);
        assert_eq!(frame["look"].loops.iter().map(Vec::len).collect::<Vec<_>>(), [2, 3]);
        let all: Duration = frame.values().map(|step| step.on(1)).sum();
        assert_eq!(all, Duration::from_secs(1));
        assert!(recorder.take(Duration::ZERO).len() == 1 && recorder.open().open.is_empty());
    }
}
