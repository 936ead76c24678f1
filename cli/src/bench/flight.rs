//! A sequence of views through a session -> times of each frame by stage and worker.

use super::uploads::{Size, Uploads};
use crate::{Common, Failure};
use std::sync::Arc;
use std::time::{Duration, Instant};
use trimtess::mesh::VertexLayout;
use trimtess::parallel::{FrameReport, Session};
use trimtess::prepare::Prepared;
use trimtess::view::View;

/// What a frame reuses of the last one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Coherence {
    /// Nothing: make the plan and all tiles from scratch.
    #[default]
    Off,
    /// Update the plan; rebuild all visible tiles.
    Plan,
    /// Update the plan; keep unchanged tiles and rebuild changed ones.
    On,
}

/// Arguments of [`fly`].
pub(super) struct Order<'a> {
    pub(super) prepared: &'a Arc<Prepared>,
    pub(super) views: &'a [View],
    pub(super) threads: usize,
    /// 0: as many as sessions have on these threads.
    pub(super) workers: usize,
    pub(super) coherence: Coherence,
    /// Whether workers write vertices of 16 bytes into the sink's memory, in place of meshes.
    pub(super) written: bool,
    /// Number of flights. Each frame's times are the minimum over all flights.
    pub(super) rounds: usize,
}

/// Milliseconds of one frame, or of one worker in it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Times {
    /// From the view to the plan.
    pub(super) plan: f64,
    /// From the plan to the last delivery.
    pub(super) make: f64,
    /// From the last delivery to the end of the commit.
    pub(super) commit: f64,
    /// From the view to the end of the commit.
    pub(super) frame: f64,
    /// Plan and commit.
    pub(super) around: f64,
    /// Busy time of each worker.
    pub(super) busy: Vec<f64>,
    /// Processor time of each worker.
    pub(super) cpu: Vec<f64>,
}

impl Times {
    fn of(report: &FrameReport, frame: Duration, workers: usize) -> Self {
        let (mut busy, mut cpu) = (vec![0.0; workers], vec![0.0; workers]);
        for worker in &report.workers {
            busy[worker.worker as usize] = ms(worker.busy());
            cpu[worker.worker as usize] = ms(worker.cpu);
        }
        Self {
            plan: ms(report.planned_in),
            make: ms(report.made_in),
            commit: ms(report.committed_in),
            frame: ms(frame),
            around: ms(report.planned_in + report.committed_in),
            busy,
            cpu,
        }
    }

    fn least(&mut self, other: &Self) {
        let least = |a: &mut f64, b: &f64| *a = a.min(*b);
        least(&mut self.plan, &other.plan);
        least(&mut self.make, &other.make);
        least(&mut self.commit, &other.commit);
        least(&mut self.frame, &other.frame);
        least(&mut self.around, &other.around);
        self.busy.iter_mut().zip(&other.busy).for_each(|(a, b)| least(a, b));
        self.cpu.iter_mut().zip(&other.cpu).for_each(|(a, b)| least(a, b));
    }

    /// Estimated frame time on an otherwise idle machine: plan, commit, and the longest processor time of a worker.
    pub(super) fn undisturbed(&self) -> f64 {
        self.around + self.cpu.iter().copied().fold(0.0, f64::max)
    }
}

/// Output of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct FrameOutput {
    /// Tiles that were made.
    pub(super) tiles: u64,
    /// Bytes of batches.
    pub(super) uploaded: u64,
    /// What a renderer holds after the frame.
    pub(super) held: Size,
}

/// Results of flying a path.
#[derive(Clone, Debug, Default)]
pub(super) struct Flight {
    pub(super) workers: usize,
    pub(super) coherence: Coherence,
    pub(super) times: Vec<Times>,
    /// Output per frame, in the last round.
    pub(super) made: Vec<FrameOutput>,
    /// Resident memory of the process after the first and the last frame, bytes.
    pub(super) resident: [Option<u64>; 2],
    /// Duration of all rounds.
    pub(super) seconds: f64,
}

pub(super) fn fly(order: &Order<'_>, common: &Common) -> Result<Flight, Failure> {
    let start = Instant::now();
    let options = common.limits.session().with_edge_lines(false);
    let options = options.with_threads(order.threads).with_workers(order.workers);
    let mut session = Session::start(Arc::clone(order.prepared), &options).map_err(Failure::cannot)?;
    let workers = session.workers();
    let mut flight = Flight { workers, coherence: order.coherence, ..Flight::default() };
    let mut sink = if order.written {
        Uploads::written_by(&mut session, VertexLayout::COMPACT)
    } else {
        Uploads::of(session.prepared())
    };
    for round in 0..order.rounds {
        session.forget();
        for (k, view) in order.views.iter().enumerate() {
            sink.next_frame();
            let begun = Instant::now();
            let report = if order.coherence == Coherence::Off {
                anew(&mut session, view, &mut sink, common)?
            } else {
                if order.coherence == Coherence::Plan {
                    session.forget();
                }
                session.view(&[*view], &mut sink).map_err(Failure::cannot)?
            };
            let frame = begun.elapsed();
            common.limits.check(session.shortfall())?;
            let times = Times::of(&report, frame, workers);
            let made = FrameOutput { tiles: report.tiles as u64, uploaded: sink.uploaded, held: sink.held() };
            if round == 0 {
                flight.times.push(times);
                flight.made.push(made);
            } else {
                flight.times[k].least(&times);
                flight.made[k] = made;
            }
            if round == 0 && k == 0 {
                flight.resident[0] = crate::limits::resident_memory();
            }
        }
    }
    flight.resident[1] = crate::limits::resident_memory();
    flight.seconds = start.elapsed().as_secs_f64();
    Ok(flight)
}

/// Makes a frame that reuses nothing.
pub(super) fn anew(
    session: &mut Session,
    view: &View,
    sink: &mut Uploads,
    common: &Common,
) -> Result<FrameReport, Failure> {
    let begun = Instant::now();
    let plan = tracing::debug_span!("plan").in_scope(|| session.plan_for_view(view, &common.limits.plan()));
    let planned_in = begun.elapsed();
    common.limits.check(plan.shortfall.as_ref())?;
    let mut report = session.frame(plan, sink).map_err(Failure::cannot)?;
    report.planned_in = planned_in;
    Ok(report)
}

pub(super) fn ms(duration: Duration) -> f64 {
    1e3 * duration.as_secs_f64()
}
