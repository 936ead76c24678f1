//! Prepared model -> a session: deals tiles to workers, broadcasts plans, commits frames on the caller's thread.

use super::commit::{Feed, FrameReport, commit};
use super::crew::{Crew, FrameInFlight, Work};
use super::error::{FrameError, StartError};
use super::handoff::{Hand, Watch};
use super::metrics::Laps;
use super::owners::{Owners, hands};
use super::residency::{Due, Residency};
use super::worker::{Stages, Worker};
use crate::control::Control;
use crate::frame::internals::{
    Levels, Planner, TileCache, TileOutcome, UpdateScratch, edge_line, fill_tile, tessellate_tile, update_tile,
};
use crate::frame::{Plan, PlannerOptions, Reuse};
use crate::mesh::{EdgeLine, MeshSink, Scene, SceneInstance, TileMesh};
use crate::model::{EdgeId, PartId, TileId};
use crate::prepare::Prepared;
use crate::view::View;
use std::num::NonZeroU32;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

/// Options of a [`Session`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SessionOptions {
    /// Number of worker threads; 0 = one per core available to the process. Workers in excess of the tiles stay idle.
    pub workers: usize,
    /// Whether sinks get the polylines of B-rep edges too.
    pub edge_lines: bool,
    /// Options of the planner, for frames of views.
    pub planner: PlannerOptions,
    /// Maximum number of LODs per instanced part in frames of views ([`Levels`]). 0 is treated as 1.
    pub levels: usize,
    /// Rebalance tiles between workers every N frames of views, using measured tile times. `None` disables rebalancing.
    pub rebalance_every: Option<NonZeroU32>,
    /// What workers cache per tile for incremental updates in frames of views.
    ///
    /// Except with [`Reuse::NONE`], how the inside of a tile is cut into triangles depends on the views before. With
    /// [`rebalance_every`](Self::rebalance_every) it also depends on measured times and on the number of workers.
    pub reuse: Reuse,
    /// Whether to pin each worker to one core, where the system allows it. For machines that do nothing else. Ignored
    /// without the feature `affinity`.
    pub pin: bool,
}

impl SessionOptions {
    /// One worker per core, edge lines, up to 4 LODs per part, no rebalancing, no pinning.
    pub const DEFAULT: Self = Self {
        workers: 0,
        edge_lines: true,
        planner: PlannerOptions::DEFAULT,
        levels: 4,
        rebalance_every: None,
        reuse: Reuse::DEFAULT,
        pin: false,
    };

    /// Sets [`workers`](Self::workers).
    #[must_use]
    pub const fn with_workers(self, workers: usize) -> Self {
        Self { workers, ..self }
    }

    /// Sets [`edge_lines`](Self::edge_lines).
    #[must_use]
    pub const fn with_edge_lines(self, edge_lines: bool) -> Self {
        Self { edge_lines, ..self }
    }

    /// Sets [`levels`](Self::levels).
    #[must_use]
    pub const fn with_levels(self, levels: usize) -> Self {
        Self { levels, ..self }
    }

    /// Sets [`rebalance_every`](Self::rebalance_every); 0 `frames` disable it.
    #[must_use]
    pub const fn with_rebalance_every(self, frames: u32) -> Self {
        Self { rebalance_every: NonZeroU32::new(frames), ..self }
    }

    /// Sets [`reuse`](Self::reuse).
    #[must_use]
    pub const fn with_reuse(self, reuse: Reuse) -> Self {
        Self { reuse, ..self }
    }

    /// Sets [`pin`](Self::pin).
    #[must_use]
    pub const fn with_pin(self, pin: bool) -> Self {
        Self { pin, ..self }
    }

    /// Sets [`planner`](Self::planner).
    #[must_use]
    pub const fn with_planner(self, planner: PlannerOptions) -> Self {
        Self { planner, ..self }
    }
}

impl Default for SessionOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Stages for Prepared {
    type Plan = Plan;
    type Scratch = UpdateScratch;
    type Cache = TileCache;

    fn reuse(scratch: &mut UpdateScratch, mesh: TileMesh) {
        scratch.reuse(mesh);
    }

    fn tile(&self, plan: &Plan, part: PartId, tile: TileId, scratch: &mut UpdateScratch) -> TileOutcome {
        tessellate_tile(self, plan, part, tile, scratch.tile())
    }

    fn update(
        &self,
        plan: &Plan,
        tile: (PartId, TileId),
        reuse: Reuse,
        memory: &mut TileCache,
        scratch: &mut UpdateScratch,
    ) -> (TileOutcome, usize) {
        let outcome = update_tile((self, plan), tile, reuse, memory, scratch);
        (outcome, memory.bytes())
    }

    fn fill(&self, plan: &Plan, part: PartId, tile: TileId, why: String) -> TileOutcome {
        fill_tile(self, plan, part, tile, why)
    }

    fn edge_line(&self, plan: &Plan, part: PartId, edge: EdgeId) -> EdgeLine {
        edge_line(self, plan, part, edge)
    }
}

/// A prepared model with worker threads, which end when the session is dropped. Sessions are independent of each other,
/// also those of one prepared model.
///
/// For a moving camera, [`view`](Self::view) updates a sink frame by frame:
///
/// ```no_run
/// use std::sync::Arc;
/// use trimtess::{glam::DVec3, mesh::MemorySink, parallel, prepare, view};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let model = trimtess::model::Model::default();
/// let prepared = Arc::new(prepare::prepare(model, &prepare::PrepareOptions::DEFAULT)?);
/// let mut session = parallel::Session::start(prepared, &parallel::SessionOptions::DEFAULT)?;
/// let projection = view::Projection::Perspective { fov_y: 0.8, near: 1.0 };
/// let mut view = view::View {
///     camera: view::Camera::looking_at(DVec3::new(0.0, -300.0, 0.0), DVec3::ZERO, DVec3::Z, projection),
///     size: (1920, 1080),
///     deviation_px: 0.5,
///     size_px: None,
///     angle: 0.5,
/// };
/// let mut sink = MemorySink::default();
/// for _ in 0..100 {
///     let report = session.view(&[view], &mut sink)?;
///     println!("{} tiles rebuilt", report.tiles);
///     view.camera.eye.y += 1.0;
/// }
/// # Ok(())
/// # }
/// ```
///
/// For a mesh within a tolerance everywhere, [`frame`](Self::frame) tessellates the whole model by a plan:
///
/// ```no_run
/// # use std::sync::Arc;
/// # use trimtess::{frame, mesh::MemorySink, parallel, prepare};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let model = trimtess::model::Model::default();
/// # let prepared = Arc::new(prepare::prepare(model, &prepare::PrepareOptions::DEFAULT)?);
/// let tolerance = frame::Tolerance { chord: 0.1, angle: 0.35, max_edge: None };
/// let mut session = parallel::Session::start(Arc::clone(&prepared), &parallel::SessionOptions::DEFAULT)?;
/// let mut sink = MemorySink::default();
/// let report = session.frame(&Arc::new(frame::plan(&prepared, &tolerance)), &mut sink)?;
/// assert_eq!(report.batches, sink.batches.len());
/// # Ok(())
/// # }
/// ```
///
/// Provisional: the frame protocol is to change, so that frames also run on the threads of an engine.
pub struct Session {
    /// With the parts of all [`Levels`].
    prepared: Arc<Prepared>,
    model: Scene,
    scene: Scene,
    levels: Levels,
    crew: Crew<Prepared>,
    owners: Owners,
    options: SessionOptions,
    /// Created with the first frame of views.
    live: Option<Live>,
}

/// State between frames of views.
struct Live {
    planner: Planner,
    residency: Residency,
    begun: Option<PendingFrame>,
}

/// A frame that was begun and not yet finished.
struct PendingFrame {
    plan: Arc<Plan>,
    due: Due,
    /// `None` if nothing has to be made.
    underway: Option<FrameInFlight>,
    planned_in: Duration,
    deferred: u32,
}

impl Session {
    /// Deals the tiles and starts the workers.
    ///
    /// # Errors
    /// When the system refuses a thread. Threads already started are joined first.
    pub fn start(prepared: Arc<Prepared>, options: &SessionOptions) -> Result<Self, StartError> {
        let workers = match options.workers {
            0 => thread::available_parallelism().map_or(1, usize::from),
            workers => workers,
        };
        let model = prepared.scene.clone();
        let (prepared, levels) = Levels::of(&prepared, options.levels);
        let hands = hands(&prepared, workers, options.edge_lines);
        let owners = Owners::of(&prepared, &hands, options.rebalance_every);
        let crew = Crew::start(&prepared, hands, options.reuse, options.pin)?;
        let scene = prepared.scene.clone();
        Ok(Self { prepared, model, scene, levels, crew, owners, options: options.clone(), live: None })
    }

    /// Number of workers.
    #[must_use]
    pub fn workers(&self) -> usize {
        self.crew.len()
    }

    /// The scene of frames of views: the model's parts, then one more part for each further LOD, and the current
    /// instances. Each instance names the LOD that it used in the last frame.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The plan of the last frame of views; `None` before the first.
    #[must_use]
    pub fn plan(&self) -> Option<&Arc<Plan>> {
        self.live.as_ref().map(|live| live.planner.last())
    }

    /// The prepared model. Further LODs of a part are parts of their own, after all parts of the model.
    #[must_use]
    pub fn prepared(&self) -> &Arc<Prepared> {
        &self.prepared
    }

    /// The model's part of instance `row`, whatever its current LOD. `None` if out of range.
    #[must_use]
    pub fn part_of(&self, row: usize) -> Option<PartId> {
        self.levels.part_of(row)
    }

    /// Adds an instance of a part of the model, from the next frame of views on. Returns its index, which is the last.
    /// `None` if there is no such part.
    pub fn add_instance(&mut self, instance: SceneInstance) -> Option<usize> {
        self.model.parts.get(instance.part.index())?;
        self.levels.push(instance.part);
        self.scene.instances.push(instance);
        self.number_faces();
        Some(self.scene.instances.len() - 1)
    }

    /// Removes an instance from the next frame of views on. The indices of later instances decrease by one. `None` if
    /// out of range.
    pub fn remove_instance(&mut self, row: usize) -> Option<SceneInstance> {
        let part = self.levels.part_of(row)?;
        self.levels.remove(row);
        let gone = self.scene.instances.remove(row);
        self.number_faces();
        Some(SceneInstance { part, ..gone })
    }

    /// Moves an instance from the next frame of views on. Returns `false` if out of range.
    pub fn move_instance(&mut self, row: usize, transform: glam::DAffine3) -> bool {
        let instance = self.scene.instances.get_mut(row);
        instance.map(|instance| instance.transform = transform).is_some()
    }

    fn number_faces(&mut self) {
        let mut first = 0;
        for instance in &mut self.scene.instances {
            instance.first_face = first;
            first += self.scene.parts[instance.part.index()].face_colours.len() as u32;
        }
    }

    /// Tessellates the whole model by `plan` and feeds it to `sink` on this thread. The sink gets the same calls with
    /// the same bytes for any number of workers, except for [`Batch::worker`](crate::mesh::Batch::worker).
    ///
    /// Cancels a frame of views that was begun. The next frame of views is a whole one.
    ///
    /// # Errors
    /// When the sink refuses: `abort` was called, the session can go on. When a worker is lost: the session is over.
    pub fn frame(&mut self, plan: &Arc<Plan>, sink: &mut dyn MeshSink) -> Result<FrameReport, FrameError> {
        self.frame_controlled(plan, &Control::default(), sink)
    }

    /// As [`frame`](Self::frame), with progress and cancellation between tiles.
    ///
    /// # Errors
    /// As [`frame`](Self::frame). When cancelled, before the sink is touched: the session can go on.
    pub fn frame_controlled(
        &mut self,
        plan: &Arc<Plan>,
        control: &Control,
        sink: &mut dyn MeshSink,
    ) -> Result<FrameReport, FrameError> {
        self.forget();
        let parts = self.model.parts.len();
        let watch = Watch::new(control, tiles_of(&self.prepared, parts));
        self.crew.frame(plan, parts, (&self.model, &watch), sink)
    }

    /// Updates `sink` for all of these views together: one picture, both eyes, shadow maps. `sink` must be the one of
    /// the last frame of views.
    ///
    /// The first frame is whole. Later frames send the tiles that changed and [`MeshSink::drawn`]. If nothing changed,
    /// not even the drawn tiles, the sink gets no calls.
    ///
    /// Tiles that leave the view stay resident until they are outdated. Every 64 frames, if more than half of the
    /// resident triangles are not drawn, tiles that were not drawn in the last 128 frames are evicted.
    ///
    /// Drawn tiles have no cracks between them, in every frame. Without [`SessionOptions::rebalance_every`], the sink
    /// gets the same calls for any number of workers.
    ///
    /// # Errors
    /// As [`frame`](Self::frame).
    pub fn view(&mut self, views: &[View], sink: &mut dyn MeshSink) -> Result<FrameReport, FrameError> {
        self.begin(views)?;
        self.finish(sink)
    }

    /// Begins a frame of views and returns while the workers make it. Cancels an unfinished frame; its changes become
    /// part of this one.
    ///
    /// # Errors
    /// When a worker is lost: the session is over.
    pub fn begin(&mut self, views: &[View]) -> Result<(), FrameError> {
        let _span = tracing::debug_span!("begin").entered();
        self.cancel();
        let mut laps = Laps::start();
        let live = self.live.get_or_insert_with(|| Live {
            planner: Planner::new(Arc::clone(&self.prepared), &self.options.planner),
            residency: Residency::new(&self.prepared),
            begun: None,
        });
        self.levels.assign(&mut self.scene.instances, views);
        let plan = Arc::clone(live.planner.plan(&self.scene.instances, views));
        let changes = live.planner.changes();
        live.residency.outdate(&self.prepared, changes);
        let deferred = changes.deferred;
        let mut due = live.residency.due(&self.prepared, &self.scene.instances, &plan.drawn);
        if !self.options.edge_lines {
            due.edges.clear();
        }
        let planned_in = laps.lap();
        let hands = self.owners.share(&self.prepared, &due);
        let idle = hands.iter().all(Hand::is_empty);
        let underway = if idle {
            None
        } else {
            Some(self.crew.give(&plan, Work::Some(hands), self.owners.wants_times(), &Watch::default())?)
        };
        live.begun = Some(PendingFrame { plan, due, underway, planned_in, deferred });
        Ok(())
    }

    /// Whether [`finish`](Self::finish) would return without waiting: the workers are done, or no frame was begun.
    #[must_use]
    pub fn is_made(&self) -> bool {
        let underway =
            self.live.as_ref().and_then(|live| live.begun.as_ref()).and_then(|begun| begun.underway.as_ref());
        underway.is_none_or(|underway| self.crew.is_made(underway))
    }

    /// Cancels the frame that was begun, if any. Workers stop after their current tile.
    pub fn cancel(&mut self) {
        if let Some(live) = &mut self.live
            && let Some(PendingFrame { due, underway: Some(_), .. }) = live.begun.take()
        {
            self.crew.cancel();
            // How far the workers got is a matter of timing and must not affect later frames.
            self.owners.forget(due.tiles.iter().copied());
        }
    }

    /// Makes the next frame of views a whole one, for a new or emptied sink. Cancels a frame that was begun.
    pub fn forget(&mut self) {
        self.cancel();
        if let Some(live) = &mut self.live {
            live.residency.forget();
        }
        self.owners.forget_all();
    }

    /// Waits for the frame that was begun and updates `sink` as [`view`](Self::view) does. Without one, does nothing.
    ///
    /// # Errors
    /// As [`frame`](Self::frame).
    pub fn finish(&mut self, sink: &mut dyn MeshSink) -> Result<FrameReport, FrameError> {
        let Some(live) = &mut self.live else { return Ok(FrameReport::default()) };
        let Some(PendingFrame { plan, due, underway, planned_in, deferred }) = live.begun.take() else {
            return Ok(FrameReport::default());
        };
        let (deliveries, mut laps) = match underway {
            Some(underway) => (self.crew.take(&underway)?, underway.laps),
            None => (Vec::new(), Laps::start()),
        };
        let still = deliveries.is_empty() && !due.whole && due.forgotten.is_empty();
        if still && live.residency.shows(&plan.drawn, &self.scene.instances) {
            let frame = self.crew.next_frame();
            return Ok(FrameReport { frame, planned_in, deferred, ..FrameReport::default() });
        }
        let times = deliveries.iter().flat_map(|delivery| delivery.times.iter().copied());
        self.owners.book(&self.prepared, times);
        let batches = deliveries.iter().flat_map(|delivery| &delivery.batches);
        let triangles: Vec<_> = batches.map(|b| (b.part, b.tile, b.mesh.triangles.len() as u32)).collect();
        let feed = Feed::Views { whole: due.whole, drawn: &plan.drawn, forgotten: &due.forgotten };
        let made = commit(deliveries, &self.scene, feed, sink, &mut laps);
        let (mut report, batches) = match made {
            Ok(made) => made,
            Err(error) => {
                live.residency.forget();
                self.owners.forget_all();
                return Err(error);
            }
        };
        self.owners.forget(due.forgotten.iter().map(|&(part, tile, _)| (part, tile)));
        live.residency.committed(&due, &triangles, &plan.drawn, &self.scene.instances);
        (report.planned_in, report.deferred) = (planned_in, deferred);
        self.crew.recycle(batches);
        Ok(report)
    }
}

/// Makes the same frame as [`Session::frame`] on the caller's thread alone.
///
/// # Errors
/// When the sink refuses; its `abort` was called.
pub fn serial(
    prepared: &Arc<Prepared>,
    plan: &Plan,
    edge_lines: bool,
    sink: &mut dyn MeshSink,
) -> Result<FrameReport, FrameError> {
    serial_controlled(prepared, plan, edge_lines, &Control::default(), sink)
}

/// As [`serial`], with progress and cancellation between tiles.
///
/// # Errors
/// As [`serial`]. When cancelled, before the sink is touched.
pub fn serial_controlled(
    prepared: &Arc<Prepared>,
    plan: &Plan,
    edge_lines: bool,
    control: &Control,
    sink: &mut dyn MeshSink,
) -> Result<FrameReport, FrameError> {
    let mut laps = Laps::start();
    let watch = Watch::new(control, tiles_of(prepared, prepared.parts.len()));
    let deliveries = hands(prepared, 1, edge_lines)
        .into_iter()
        .map(|hand| {
            let mut worker = Worker::new(0, Arc::clone(prepared), hand, Reuse::NONE, Arc::default());
            worker.make_all(0, plan, prepared.parts.len(), &watch)
        })
        .collect();
    if watch.is_cancelled() {
        return Err(FrameError::Cancelled);
    }
    Ok(commit(deliveries, &prepared.scene, Feed::All, sink, &mut laps)?.0)
}

/// Tiles of the first `parts` parts.
fn tiles_of(prepared: &Prepared, parts: usize) -> u64 {
    prepared.parts.iter().take(parts).map(|part| part.tiles.len() as u64).sum()
}

/// Tessellates the whole model by `plan`, once. A single worker works on the caller's thread. The sink gets the same
/// calls for any number of workers.
///
/// # Errors
/// As [`Session::start`] and [`Session::frame_controlled`].
pub fn tessellate(
    prepared: &Arc<Prepared>,
    plan: &Arc<Plan>,
    options: &SessionOptions,
    control: &Control,
    sink: &mut dyn MeshSink,
) -> Result<FrameReport, FrameError> {
    if options.workers == 1 {
        // Another thread would only be waited for.
        return serial_controlled(prepared, plan, options.edge_lines, control, sink);
    }
    let mut session = Session::start(Arc::clone(prepared), options).map_err(FrameError::Start)?;
    session.frame_controlled(plan, control, sink)
}
