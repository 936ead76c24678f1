//! Options of a session, and what a frame of views changes in it: plans and residency. The job that makes a frame has
//! all of it, and gives it back.

use super::commit::{Feed, FrameReport, Rows, commit, refusal, sink_panicked};
use super::edits::Edited;
use super::error::FrameError;
use super::handoff::{DegradedTile, Delivery, Hand, Seat, Watch};
use super::metrics::{Laps, SessionMemory};
use super::owners::{Owners, hands, workers_on};
use super::residency::{Due, Residency};
use super::worker::{Crew, Order, Work};
use super::writer::Writer;
use crate::control::{Call, Control, Jobs, map, width};
use crate::frame::internals::{Levels, PlacedInstances, Planner, free};
use crate::frame::{Plan, PlannerOptions};
use crate::mesh::{
    Batch, MeshLists, MeshSink, Scene, SceneChanges, SceneInstance, SinkError, TileMemory, VertexLayout, successors,
};
use crate::model::{PartId, TileId};
use crate::prepare::Prepared;
use crate::view::View;
use glam::DAffine3;
use std::collections::BTreeMap;
use std::num::NonZeroU32;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

/// Options of a [`Session`](super::Session).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SessionOptions {
    /// Number of threads that make a frame, the caller's included; 0 = one per core, see
    /// [`Threads::start`](crate::control::Threads::start). [`Session::start`](super::Session::start) starts one less,
    /// but at least one. After [`begin`](super::Session::begin) these make the frame alone, until the caller waits for
    /// it. [`Session::start_on`](super::Session::start_on) starts none.
    pub threads: usize,
    /// Number of workers of a session, which own the tiles; more than [`MOST_WORKERS`](Self::MOST_WORKERS) count as
    /// that many. Workers in excess of the tiles stay idle.
    ///
    /// 0 = one on a pool of one thread, else four per thread: a thread whose tiles cost less than expected then takes
    /// another worker.
    pub workers: usize,
    /// Whether sinks get the polylines of B-rep edges too. Frames of views have those of parts that a view has shown.
    /// On by default; off in sessions of C and Python.
    pub edge_lines: bool,
    /// Options of the planner, for frames of views.
    pub planner: PlannerOptions,
    /// Maximum number of LODs per instanced part in frames of views. 0 is treated as 1.
    pub levels: usize,
    /// Bytes of tiles that a sink of frames of views may hold, as they were sent; `None` = no limit.
    ///
    /// Beyond it, each frame evicts tiles that no view draws, in the order of parts: first those that were drawn
    /// neither in the current 64 frames nor in the 64 before, then those drawn in the 64 before, then the others. Tiles
    /// that are drawn stay. A frame does not count the tiles that it sends itself.
    pub resident_bytes: Option<u64>,
    /// Rebalance tiles between workers every N frames of views, using measured tile times. `None` disables rebalancing.
    pub rebalance_every: Option<NonZeroU32>,
}

impl SessionOptions {
    /// The most workers of a session.
    pub const MOST_WORKERS: usize = 1 << 12;

    /// One thread per core, four workers per thread, edge lines, up to 4 LODs per part, no rebalancing.
    pub const DEFAULT: Self = Self {
        threads: 0,
        workers: 0,
        edge_lines: true,
        planner: PlannerOptions::DEFAULT,
        levels: 4,
        resident_bytes: None,
        rebalance_every: None,
    };

    /// Sets [`rebalance_every`](Self::rebalance_every); 0 `frames` disable it.
    #[must_use]
    pub const fn with_rebalance_every(self, frames: u32) -> Self {
        Self { rebalance_every: NonZeroU32::new(frames), ..self }
    }
}

options! {
    SessionOptions:
    with_threads(threads: usize);
    with_workers(workers: usize);
    with_edge_lines(edge_lines: bool);
    with_levels(levels: usize);
    with_resident_bytes(resident_bytes: Option<u64>);
    with_planner(planner: PlannerOptions);
}

/// Workers, and the state between frames.
pub(super) struct Engine {
    /// With the parts of all [`Levels`].
    pub(super) prepared: Arc<Prepared>,
    pub(super) jobs: Arc<dyn Jobs>,
    levels: Levels,
    /// As the frame in progress places them, with the LODs that it selects.
    pub(super) placed: PlacedInstances,
    crew: Crew,
    owners: Owners,
    options: SessionOptions,
    /// Writes tiles into the memory of the sink, if it wants that.
    writer: Option<Arc<Writer>>,
    /// Lists of meshes that the sink of the last commit reads; all of them for a sink that is not known yet.
    reads: MeshLists,
    /// Of the last commit.
    rows: Rows,
    /// Made with the first frame of views.
    live: Option<Live>,
    /// Whether the sink has the last frame, and the same views would change nothing.
    rests: bool,
    last: LastFrame,
    /// Number of the next frame.
    next: u64,
}

/// The degraded tiles that a sink has.
pub(super) type Degraded = BTreeMap<(PartId, TileId), DegradedTile>;

/// What has become of the last frame of views.
enum LastFrame {
    /// It is history, or has left no trace.
    Settled,
    /// It is planned, or more. The engine rested before it, or not.
    Planned { rested: bool },
    /// It is history from the next frame on.
    Committed,
}

/// State between frames of views.
struct Live {
    planner: Planner,
    residency: Residency,
}

/// A frame of views that is made and not committed.
pub(super) struct FinishedFrame {
    pub(super) plan: Arc<Plan>,
    due: Due,
    deliveries: Vec<Delivery>,
    /// Where the tiles that are due are made.
    seats: Vec<Seat>,
    planned_in: Duration,
    made_in: Duration,
    deferred: u32,
    /// Lists of meshes that were made.
    lists: MeshLists,
}

impl Engine {
    /// Deals the tiles of `prepared`, which has the parts of all `levels`.
    pub(super) fn new(prepared: Arc<Prepared>, levels: Levels, jobs: Arc<dyn Jobs>, options: &SessionOptions) -> Self {
        let threads = width(&*jobs);
        let workers = if options.workers == 0 { workers_on(threads) } else { options.workers };
        let workers = workers.min(SessionOptions::MOST_WORKERS);
        let hands = hands(&prepared, (workers, threads), options.edge_lines);
        let owners = Owners::of(&prepared, (&hands, threads), options.rebalance_every);
        let crew = Crew::of(&prepared, hands);
        let placed = PlacedInstances::of(&prepared);
        Self {
            prepared,
            jobs,
            levels,
            placed,
            crew,
            owners,
            options: options.clone(),
            writer: None,
            reads: MeshLists::ALL,
            rows: Rows::default(),
            live: None,
            rests: false,
            last: LastFrame::Settled,
            next: 0,
        }
    }

    /// Makes the last frame of views history if it was committed. If not, takes it back: later frames do not depend on
    /// it.
    ///
    /// Frames begin with this, so that a commit has less to do.
    pub(super) fn settle(&mut self) {
        let Self { jobs, levels, placed, live: Some(Live { planner, residency }), .. } = self else { return };
        match std::mem::replace(&mut self.last, LastFrame::Settled) {
            LastFrame::Settled => {}
            LastFrame::Planned { rested } => {
                levels.revert(placed);
                residency.revert(&planner.changes().parts);
                planner.revert(&**jobs);
                self.rests = rested;
            }
            LastFrame::Committed => {
                planner.keep();
                residency.keep();
            }
        }
    }

    /// Adds an instance of a part of the model. Returns whether that takes one more LOD, which is the last part of
    /// `prepared` from the next frame of views on.
    pub(super) fn add_instance(&mut self, instance: SceneInstance) -> bool {
        self.rests = false;
        let part = instance.part;
        self.placed.push(instance);
        self.levels.push(part)
    }

    /// Appends the LODs of instances that were added since the last frame of views, all at once: this takes a pass over
    /// the parts.
    fn add_levels(&mut self) {
        let Some((prepared, parts)) = self.levels.grown(&self.prepared) else { return };
        self.prepared = prepared;
        self.placed.add_parts(&self.prepared);
        self.crew.set_prepared(&self.prepared);
        parts.into_iter().for_each(|part| self.owners.add_level(part));
        if let Some(writer) = &mut self.writer {
            Arc::make_mut(writer).set_prepared(&self.prepared);
        }
        if let Some(Live { planner, residency }) = &mut self.live {
            planner.add_parts(Arc::clone(&self.prepared));
            residency.add_parts(&self.prepared);
        }
    }

    /// Switches to another model, and its instances. What parts of both have is kept. Returns the part before of each.
    pub(super) fn update(&mut self, model: &Arc<Prepared>) -> Vec<Option<PartId>> {
        self.rests = false;
        self.add_levels();
        let (prepared, from) = self.levels.update(&self.prepared, model);
        self.prepared = prepared;
        let SessionOptions { edge_lines, rebalance_every, .. } = self.options;
        let threads = self.owners.threads;
        let hands = hands(&self.prepared, (self.crew.len(), threads), edge_lines);
        self.owners = Owners::of(&self.prepared, (&hands, threads), rebalance_every);
        self.crew = Crew::of(&self.prepared, hands);
        self.placed.update(&self.prepared, &from);
        if let Some(writer) = &mut self.writer {
            *writer = Arc::new(writer.of_model(&self.prepared));
        }
        if let Some(Live { planner, residency }) = &mut self.live {
            planner.update(Arc::clone(&self.prepared), &from);
            residency.update(&self.prepared, &from);
        }
        from
    }

    /// Removes instances, whose rows ascend, and returns them in the colours of the model. The rows of later ones
    /// decrease.
    pub(super) fn remove_instances(&mut self, rows: &[usize]) -> Vec<SceneInstance> {
        self.rests = false;
        self.levels.remove(rows);
        self.live.iter_mut().for_each(|live| live.residency.remove_instances(rows));
        self.placed.remove(rows)
    }

    /// Moves instances, and sets attributes.
    pub(super) fn apply(&mut self, edited: Edited) {
        self.settle();
        self.rests &= edited.is_empty();
        edited.moved.into_iter().for_each(|(row, transform)| self.placed.move_to(row, transform));
        self.placed.set_attributes(&edited.parts, &edited.instances);
    }

    /// Has workers write tiles into the memory of a sink. The next frame of views is a whole one.
    pub(super) fn write_into(&mut self, layout: VertexLayout, memory: Arc<dyn TileMemory>) {
        self.writer = Some(Arc::new(Writer::new(layout, memory, &self.prepared)));
        self.forget();
    }

    /// What it takes besides the prepared model.
    pub(super) fn memory(&self) -> SessionMemory {
        /// Copies of the list of instances: the caller's, this one's, and that of the model with its levels of detail;
        /// and the place, sphere, key and row of each.
        const INSTANCE: usize = 3 * size_of::<SceneInstance>() + size_of::<DAffine3>() + 128;
        let live = self.live.as_ref().map_or((0, 0), |live| (live.planner.memory(), live.residency.memory()));
        let instances = self.placed.instances().len() * INSTANCE + self.placed.memory();
        SessionMemory { plans: live.0 as u64, scene: (instances + live.1) as u64 }
    }

    pub(super) fn workers(&self) -> usize {
        self.crew.len()
    }

    /// Whether the sink shows these views of the instances as they were last, and nothing is left to refine.
    pub(super) fn shows(&self, views: &[View]) -> bool {
        self.rests && self.live.as_ref().is_some_and(|live| live.planner.has_settled_on(views))
    }

    /// The report of a frame in which nothing changes.
    pub(super) fn unchanged(&self) -> FrameReport {
        FrameReport { frame: self.next, ..FrameReport::default() }
    }

    /// Makes a frame of views, after [`apply`](Self::apply). `None` once it is cancelled: it leaves no trace.
    pub(super) fn make(&mut self, views: &[View], control: &Control) -> Option<FinishedFrame> {
        let _span = tracing::debug_span!("make").entered();
        let made = self.planned_and_made(views, control);
        if made.is_none() {
            self.settle();
        }
        made
    }

    fn planned_and_made(&mut self, views: &[View], control: &Control) -> Option<FinishedFrame> {
        let jobs = Arc::clone(&self.jobs);
        let call = Call::new(&*jobs, control);
        call.goes_on()?;
        let mut laps = Laps::start();
        self.last = LastFrame::Planned { rested: std::mem::take(&mut self.rests) };
        self.add_levels();
        let lists = self.lists();
        let Self { prepared, placed, .. } = self;
        let Live { planner, residency } = self.live.get_or_insert_with(|| Live {
            planner: Planner::new(Arc::clone(prepared), &self.options.planner),
            residency: Residency::new(prepared, self.options.resident_bytes, self.options.edge_lines),
        });
        let shown = tracing::trace_span!("show").in_scope(|| {
            let shown = placed.shown_by(views, self.options.planner.cull_back_faces);
            self.levels.assign(placed, &shown);
            shown
        });
        let plan = Arc::clone(planner.plan_on(call, placed, (views, shown))?);
        let owing = tracing::trace_span!("owe").entered();
        let changes = planner.changes();
        residency.outdate(prepared, changes);
        let deferred = changes.deferred;
        let due = residency.due(prepared, placed.instances(), &plan.drawn);
        call.goes_on()?;
        let planned_in = laps.lap();
        let (hands, seats) = self.owners.share(prepared, &due);
        let idle = hands.iter().all(Hand::is_empty);
        let work = Work::Some(hands, self.owners.wants_times());
        drop(owing);
        let watch = Watch::of(control);
        let order = Order { plan: Arc::clone(&plan), watch: watch.clone(), writer: self.writer.clone(), lists };
        let written = &mut self.rows.written;
        let deliveries = if idle { Vec::new() } else { self.crew.make(&*jobs, order, work, written) };
        let frame = FinishedFrame { plan, due, deliveries, seats, planned_in, made_in: laps.lap(), deferred, lists };
        (!watch.is_cancelled()).then_some(frame)
    }

    /// Makes the next frame of views a whole one.
    pub(super) fn forget(&mut self) {
        self.settle();
        self.rests = false;
        self.reads = MeshLists::ALL;
        self.live.iter_mut().for_each(|live| live.residency.forget());
    }

    /// Lists of meshes that are read of frames of views.
    fn lists(&self) -> MeshLists {
        self.writer.as_ref().map_or(self.reads, |writer| writer.lists())
    }

    /// Updates `sink`, and the degraded tiles that it has. Without changes, does not touch it. The frame is history if
    /// this succeeds.
    pub(super) fn commit(
        &mut self,
        frame: FinishedFrame,
        scene: (&Scene, SceneChanges<'_>),
        degraded: &mut Degraded,
        sink: &mut dyn MeshSink,
    ) -> Result<FrameReport, FrameError> {
        let report = self.feed(frame, scene, degraded, sink);
        match report {
            Ok(_) => self.last = LastFrame::Committed,
            Err(_) => self.settle(),
        }
        report
    }

    fn feed(
        &mut self,
        mut frame: FinishedFrame,
        (scene, changes): (&Scene, SceneChanges<'_>),
        degraded: &mut Degraded,
        sink: &mut dyn MeshSink,
    ) -> Result<FrameReport, FrameError> {
        if let Some(error) = refusal(&mut frame.deliveries) {
            return Err(error);
        }
        let FinishedFrame { plan, due, deliveries, seats, planned_in, made_in, deferred, lists } = frame;
        let reads = lists_of(sink)?;
        if self.writer.is_none() && !lists.contain(reads) {
            self.forget();
            let context = format!("a frame with {lists:?}, made for another sink; this one reads {reads:?}");
            return Err(SinkError::new(context, std::io::ErrorKind::InvalidInput).into());
        }
        let Some(Live { residency, .. }) = &mut self.live else {
            return Err(FrameError::Lost { why: "a frame of views without a plan".into() });
        };
        let still = deliveries.is_empty() && !due.whole && due.from.is_none() && due.evicted.is_empty();
        if still && residency.shows(&plan.drawn, self.placed.scene_version()) {
            self.rests = true;
            return Ok(FrameReport { planned_in, deferred, ..self.unchanged() });
        }
        let notes = deliveries.iter().filter_map(|delivery| delivery.notes.as_ref());
        let times: Vec<_> = notes.flat_map(|notes| notes.times.iter().copied()).collect();
        let from = due.from.as_deref();
        let drawn = [&plan.drawn, residency.shown()];
        let feed = Feed::Views { whole: due.whole, changes, from, drawn, evicted: &due.evicted };
        let made = (deliveries, &seats[..]);
        let report = match commit(made, (scene, self.writer.as_deref()), feed, (&mut self.rows, sink)) {
            Ok(report) => report,
            Err(error) => {
                self.forget();
                return Err(error);
            }
        };
        self.reads = reads;
        self.owners.book(&self.prepared, times.into_iter());
        if let (Some(from), false) = (from, degraded.is_empty()) {
            let new = successors(from);
            let renumbered = |((part, tile), row): ((PartId, TileId), DegradedTile)| {
                let part = *new.get(&part)?;
                Some(((part, tile), DegradedTile { part, ..row }))
            };
            *degraded = std::mem::take(degraded).into_iter().filter_map(renumbered).collect();
        }
        if due.whole {
            degraded.clear();
        } else if !degraded.is_empty() {
            let evicted = due.evicted.iter().map(|&(part, tile, _)| (part, tile));
            let gone = self.rows.made().map(|made| (made.part, made.tile)).chain(evicted);
            gone.for_each(|tile| _ = degraded.remove(&tile));
        }
        degraded.extend(report.degraded.iter().map(|tile| ((tile.part, tile.tile), tile.clone())));
        residency.committed(&due, self.rows.made(), (&plan.drawn, self.placed.scene_version()));
        // The next frame evicts what is too much.
        self.rests = !residency.is_full();
        free_batches(&*self.jobs, &mut self.rows.batches);
        Ok(FrameReport { frame: self.count(), planned_in, made_in, deferred, ..report })
    }

    /// Makes a whole frame of the parts of `scene`, which are the first ones, and feeds it to the sink.
    pub(super) fn whole(
        &mut self,
        plan: Arc<Plan>,
        (scene, control): (&Scene, &Control),
        sink: &mut dyn MeshSink,
    ) -> Result<FrameReport, FrameError> {
        let _span = tracing::debug_span!("frame", number = self.next).entered();
        plan.check(&self.prepared.parts[..scene.parts.len()])?;
        let with = (&*self.jobs, &*self.prepared, self.writer.as_ref());
        let report = whole_frame((&mut self.crew, &mut self.rows), with, &plan, (scene, control), sink)?;
        // The caller may keep it.
        Arc::into_inner(plan).into_iter().for_each(|plan| free(&*self.jobs, plan.parts));
        Ok(FrameReport { frame: self.count(), ..report })
    }

    fn count(&mut self) -> u64 {
        self.next += 1;
        self.next - 1
    }
}

/// The lists that a sink reads.
fn lists_of(sink: &dyn MeshSink) -> Result<MeshLists, FrameError> {
    catch_unwind(AssertUnwindSafe(|| sink.reads())).map_err(|panic| sink_panicked(&*panic))
}

/// Frees what a sink left of its batches; those of many tiles on all threads.
fn free_batches(jobs: &dyn Jobs, lists: &mut Vec<Vec<Batch>>) {
    const FEW: usize = 256;
    let _span = tracing::trace_span!("free").entered();
    if lists.iter().map(Vec::len).sum::<usize>() > FEW {
        map(jobs, std::mem::take(lists), drop);
    }
    lists.clear();
}

/// Makes a whole frame of the parts of `scene`, which are the first ones of `prepared`, and feeds it to the sink.
pub(super) fn whole_frame(
    (crew, rows): (&mut Crew, &mut Rows),
    (jobs, prepared, writer): (&dyn Jobs, &Prepared, Option<&Arc<Writer>>),
    plan: &Arc<Plan>,
    (scene, control): (&Scene, &Control),
    sink: &mut dyn MeshSink,
) -> Result<FrameReport, FrameError> {
    let mut laps = Laps::start();
    let parts = scene.parts.len();
    let tiles = prepared.parts.iter().take(parts).map(|part| part.tiles.len() as u64).sum();
    let watch = Watch::new(control, tiles);
    let lists = writer.map_or_else(|| lists_of(sink), |writer| Ok(writer.lists()))?;
    let order = Order { plan: Arc::clone(plan), watch: watch.clone(), writer: writer.cloned(), lists };
    let mut deliveries = crew.make(jobs, order, Work::All(parts), &mut rows.written);
    let cancelled = watch.is_cancelled().then_some(FrameError::Cancelled);
    if let Some(error) = cancelled.or_else(|| refusal(&mut deliveries)) {
        return Err(error);
    }
    let made_in = laps.lap();
    let made = (deliveries, crew.seats().of_first(parts));
    let feed = Feed::All(control, crew.seats());
    let report = commit(made, (scene, writer.map(|writer| &**writer)), feed, (&mut *rows, sink))?;
    free_batches(jobs, &mut rows.batches);
    Ok(FrameReport { made_in, ..report })
}
