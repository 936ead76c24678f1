//! Prepared model + worker count -> a session: tiles dealt once, plans broadcast, frames committed on the caller's thread.

use super::commit::{Feed, FrameError, FrameReport, commit};
use super::crew::{Crew, StartError, Underway, Work};
use super::handoff::Hand;
use super::metrics::Laps;
use super::owners::{Owners, hands};
use super::upkeep::{Due, Upkeep};
use super::worker::{Stages, Worker};
use crate::frame::{Plan, PlannerOptions, Reuse, View};
use crate::frame::internals::{Levels, Planner, TileCache, TileOutcome, UpdateScratch, edge_line, fill_tile, tessellate_tile, update_tile};
use crate::mesh::{EdgeLine, MeshSink, Scene, SceneInstance, TileMesh};
use crate::model::{EdgeId, PartId, TileId};
use crate::prepare::Prepared;
use std::num::NonZeroU32;
use std::sync::Arc;
use std::thread;
use std::time::Duration;

/// Knobs of a [`Session`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SessionOptions {
    /// Worker threads; 0 = one per core that the process may use. More than there are tiles is a waste, not an error.
    pub workers: usize,
    /// Whether sinks get the polylines of B-rep edges too.
    pub edge_lines: bool,
    /// How views become plans.
    pub planner: PlannerOptions,
    /// Meshes that a part which the model places more than once may have in frames of views, for instances at different
    /// distances ([`Levels`]); 0 is taken as 1.
    pub levels: usize,
    /// Frames of views after which the master deals the tiles anew, by the time that they took in these; `None`: never.
    pub redeal: Option<NonZeroU32>,
    /// What workers keep of tiles in frames of views, to patch them up with when they change. With anything but [`Reuse::NONE`] the
    /// triangles between the vertices of a tile depend on the views before (and with [`redeal`](Self::redeal) on what was measured), though not on
    /// the number of workers.
    pub reuse: Reuse,
    /// Whether each worker stays on one core, where the system allows that: for machines that do nothing else. Ignored
    /// without the feature `affinity`.
    pub pin: bool,
}

impl SessionOptions {
    /// One worker per core, with edge lines.
    pub const DEFAULT: Self = Self {
        workers: 0,
        edge_lines: true,
        planner: PlannerOptions::DEFAULT,
        levels: 4,
        redeal: None,
        reuse: Reuse::DEFAULT,
        pin: false,
    };

    /// The same with `workers` threads.
    #[must_use]
    pub const fn with_workers(self, workers: usize) -> Self {
        Self { workers, ..self }
    }

    /// The same with or without edge lines.
    #[must_use]
    pub const fn with_edge_lines(self, edge_lines: bool) -> Self {
        Self { edge_lines, ..self }
    }

    /// The same with up to `levels` meshes of each part.
    #[must_use]
    pub const fn with_levels(self, levels: usize) -> Self {
        Self { levels, ..self }
    }

    /// The same, dealing anew every `frames` frames of views; 0: never.
    #[must_use]
    pub const fn with_redeal(self, frames: u32) -> Self {
        Self { redeal: NonZeroU32::new(frames), ..self }
    }

    /// The same, keeping of tiles what `patch` says.
    #[must_use]
    pub const fn with_reuse(self, reuse: Reuse) -> Self {
        Self { reuse, ..self }
    }

    /// The same with workers pinned to cores, or not.
    #[must_use]
    pub const fn with_pin(self, pin: bool) -> Self {
        Self { pin, ..self }
    }

    /// The same with other knobs of the planner.
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

/// A prepared model with its workers. Threads start here and end when the session is dropped. Several sessions of one prepared
/// model, or of several, know nothing of each other.
///
/// For a camera, [`view`](Self::view) brings a sink up to date, frame after frame:
///
/// ```no_run
/// use std::sync::Arc;
/// use trimtess::{frame, glam::DVec3, mesh::MemorySink, parallel, prepare};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let model = trimtess::model::Model::default();
/// let prepared = Arc::new(prepare::prepare(model, &prepare::PrepareOptions::DEFAULT)?);
/// let mut session = parallel::Session::start(prepared, &parallel::SessionOptions::DEFAULT)?;
/// let mut view = frame::View {
///     eye: DVec3::new(0.0, -300.0, 0.0),
///     forward: DVec3::Y,
///     up: DVec3::Z,
///     projection: frame::Projection::Perspective { fov_y: 0.8, near: 1.0 },
///     size: (1920, 1080),
///     deviation_px: 0.5,
///     size_px: None,
///     angle: 0.5,
/// };
/// let mut sink = MemorySink::default();
/// for _ in 0..100 {
///     let report = session.view(&[view], &mut sink)?;
///     println!("{} of the tiles were made anew", report.tiles);
///     view.eye.y += 1.0;
/// }
/// # Ok(())
/// # }
/// ```
///
/// For a mesh that keeps a tolerance everywhere, [`frame`](Self::frame) makes all of it by a plan:
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
pub struct Session {
    /// With further rows of parts for their [`Levels`].
    prepared: Arc<Prepared>,
    model: Scene,
    scene: Scene,
    levels: Levels,
    crew: Crew<Prepared>,
    owners: Owners,
    options: SessionOptions,
    /// Made with the first view.
    live: Option<Live>,
}

/// What a session keeps between the frames of views.
struct Live {
    planner: Planner,
    upkeep: Upkeep,
    begun: Option<Begun>,
}

/// A frame that was begun.
struct Begun {
    plan: Arc<Plan>,
    due: Due,
    /// `None` where nothing has to be made.
    underway: Option<Underway>,
    planned_in: Duration,
    deferred: u32,
}

impl Session {
    /// Deals the tiles and starts the workers.
    ///
    /// # Errors
    /// When the system refuses a thread; none is left behind.
    pub fn start(prepared: Arc<Prepared>, options: &SessionOptions) -> Result<Self, StartError> {
        let workers = match options.workers {
            0 => thread::available_parallelism().map_or(1, usize::from),
            workers => workers,
        };
        let model = prepared.scene.clone();
        let (prepared, levels) = Levels::of(&prepared, options.levels);
        let hands = hands(&prepared, workers, options.edge_lines);
        let owners = Owners::of(&prepared, &hands, options.redeal);
        let crew = Crew::start(&prepared, hands, options.reuse, options.pin)?;
        let scene = prepared.scene.clone();
        Ok(Self { prepared, model, scene, levels, crew, owners, options: options.clone(), live: None })
    }

    /// How many workers there are.
    #[must_use]
    pub fn workers(&self) -> usize {
        self.crew.len()
    }

    /// What frames of views show: the model's parts, then further rows of those that have several meshes; and its instances as
    /// they were added, moved and removed since, each with the row that it had in the last frame.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The plan of the last frame of views; `None` before the first.
    #[must_use]
    pub fn plan(&self) -> Option<&Arc<Plan>> {
        self.live.as_ref().map(|live| live.planner.last())
    }

    /// The prepared model as plans of frames of views see it: with further rows for parts that have several meshes.
    #[must_use]
    pub fn prepared(&self) -> &Arc<Prepared> {
        &self.prepared
    }

    /// The part of the model that an instance is of; `None` if there is no such row.
    #[must_use]
    pub fn part_of(&self, row: usize) -> Option<PartId> {
        self.levels.part_of(row)
    }

    /// Places a part of the model once more, from the next frame of views on. Returns the row of the new instance, the last; `None` if there is
    /// no such part.
    pub fn add_instance(&mut self, instance: SceneInstance) -> Option<usize> {
        self.model.parts.get(instance.part.index())?;
        self.levels.push(instance.part);
        self.scene.instances.push(instance);
        self.number_faces();
        Some(self.scene.instances.len() - 1)
    }

    /// Takes an instance away from the next frame of views on; those after it move up a row. `None` if there is no such row.
    pub fn remove_instance(&mut self, row: usize) -> Option<SceneInstance> {
        let part = self.levels.part_of(row)?;
        self.levels.remove(row);
        let gone = self.scene.instances.remove(row);
        self.number_faces();
        Some(SceneInstance { part, ..gone })
    }

    /// Places an instance elsewhere from the next frame of views on. `false` if there is no such row.
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

    /// Makes one whole frame of the prepared model by `plan` and feeds it to `sink`, from this thread. The sink sees the same
    /// calls with the same bytes for any number of workers ([`Batch::worker`](crate::mesh::Batch::worker) excepted).
    ///
    /// A frame of views that was begun is left; the next one is whole.
    ///
    /// # Errors
    /// When the sink refuses (it has been told to abort; the session goes on) or a worker is gone (the session is over).
    pub fn frame(&mut self, plan: &Arc<Plan>, sink: &mut dyn MeshSink) -> Result<FrameReport, FrameError> {
        self.forget();
        self.crew.frame(plan, self.model.parts.len(), &self.model, sink)
    }

    /// Brings `sink`, which must be the one of the last frame of views, up to date for what these views show together: shadow maps,
    /// both eyes, or one picture. The first frame is whole; then batches of tiles that changed follow, and [`MeshSink::drawn`]. Where
    /// nothing changed, not even what is drawn, the sink hears nothing.
    ///
    /// What is not drawn stays in the sink for when it is again, as long as that is not outdated; where it is more than half of what the
    /// sink has, what was not drawn for 64 frames or more is forgotten.
    ///
    /// Everything that is drawn has no cracks, in every frame. The sink sees the same for any number of workers.
    ///
    /// # Errors
    /// As [`frame`](Self::frame).
    pub fn view(&mut self, views: &[View], sink: &mut dyn MeshSink) -> Result<FrameReport, FrameError> {
        self.begin(views)?;
        self.finish(sink)
    }

    /// Begins a frame of views and returns while workers are at it. A frame that was begun before and not finished is left: what it
    /// would have brought is part of this one.
    ///
    /// # Errors
    /// When a worker is gone: the session is over.
    pub fn begin(&mut self, views: &[View]) -> Result<(), FrameError> {
        let _span = tracing::debug_span!("begin").entered();
        self.cancel();
        let mut laps = Laps::start();
        let live = self.live.get_or_insert_with(|| Live {
            planner: Planner::new(Arc::clone(&self.prepared), &self.options.planner),
            upkeep: Upkeep::new(&self.prepared),
            begun: None,
        });
        self.levels.assign(&mut self.scene.instances, views);
        let plan = Arc::clone(live.planner.plan(&self.scene.instances, views));
        let changes = live.planner.changes();
        live.upkeep.outdate(&self.prepared, changes);
        let deferred = changes.deferred;
        let mut due = live.upkeep.due(&self.prepared, &self.scene.instances, &plan.drawn);
        if !self.options.edge_lines {
            due.edges.clear();
        }
        let planned_in = laps.lap();
        let hands = self.owners.share(&self.prepared, &due);
        let idle = hands.iter().all(Hand::is_empty);
        let underway =
            if idle { None } else { Some(self.crew.give(&plan, Work::Some(hands), self.owners.wants_times())?) };
        live.begun = Some(Begun { plan, due, underway, planned_in, deferred });
        Ok(())
    }

    /// Whether [`finish`](Self::finish) would not wait: the workers are done, or no frame was begun.
    #[must_use]
    pub fn is_made(&self) -> bool {
        let underway =
            self.live.as_ref().and_then(|live| live.begun.as_ref()).and_then(|begun| begun.underway.as_ref());
        underway.is_none_or(|underway| self.crew.is_made(underway))
    }

    /// Leaves a frame that was begun; workers stop after the tile that they are at. Does nothing if there is none.
    pub fn cancel(&mut self) {
        if let Some(live) = &mut self.live
            && let Some(Begun { due, underway: Some(_), .. }) = live.begun.take()
        {
            self.crew.cancel();
            // How far workers came is chance, and must not show.
            self.owners.forget(due.tiles.iter().copied());
        }
    }

    /// Has the next frame of views be a whole one, for a sink that has nothing of the last.
    pub fn forget(&mut self) {
        self.cancel();
        if let Some(live) = &mut self.live {
            live.upkeep.forget();
        }
        self.owners.forget_all();
    }

    /// Waits for the frame that was begun and brings `sink` up to date, as [`view`](Self::view). Without a frame begun it does
    /// nothing.
    ///
    /// # Errors
    /// As [`frame`](Self::frame).
    pub fn finish(&mut self, sink: &mut dyn MeshSink) -> Result<FrameReport, FrameError> {
        let Some(live) = &mut self.live else { return Ok(FrameReport::default()) };
        let Some(Begun { plan, due, underway, planned_in, deferred }) = live.begun.take() else {
            return Ok(FrameReport::default());
        };
        let (deliveries, mut laps) = match underway {
            Some(underway) => (self.crew.take(&underway)?, underway.laps),
            None => (Vec::new(), Laps::start()),
        };
        let still = deliveries.is_empty() && !due.whole && due.forgotten.is_empty();
        if still && live.upkeep.shows(&plan.drawn, &self.scene.instances) {
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
                live.upkeep.forget();
                self.owners.forget_all();
                return Err(error);
            }
        };
        self.owners.forget(due.forgotten.iter().map(|&(part, tile, _)| (part, tile)));
        live.upkeep.committed(&due, &triangles, &plan.drawn, &self.scene.instances);
        (report.planned_in, report.deferred) = (planned_in, deferred);
        self.crew.recycle(batches);
        Ok(report)
    }
}

/// The same frame with no thread but the caller's: the stages of [`Session::frame`], called in order.
///
/// # Errors
/// When the sink refuses; it has been told to abort.
pub fn serial(
    prepared: &Arc<Prepared>,
    plan: &Plan,
    edge_lines: bool,
    sink: &mut dyn MeshSink,
) -> Result<FrameReport, FrameError> {
    let mut laps = Laps::start();
    let deliveries = hands(prepared, 1, edge_lines)
        .into_iter()
        .map(|hand| {
            let mut worker = Worker::new(0, Arc::clone(prepared), hand, Reuse::NONE, Arc::default());
            worker.make_all(0, plan, prepared.parts.len())
        })
        .collect();
    Ok(commit(deliveries, &prepared.scene, Feed::All, sink, &mut laps)?.0)
}
