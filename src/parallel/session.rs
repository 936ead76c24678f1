//! Prepared model -> a session: frames for a plan or for views, made by workers on anybody's threads, committed on the
//! caller's thread.

use super::commit::FrameReport;
use super::edits::{Edited, Edits};
use super::engine::{Degraded, Engine, FinishedFrame, SessionOptions};
use super::error::{FrameError, Lost};
use super::flight::{Flight, Orders};
use super::handoff::DegradedTile;
use super::metrics::SessionMemory;
use super::scene_keys::SceneKeys;
use crate::control::{Control, Jobs, StartError, WithCaller, WithHelpers};
use crate::frame::internals::{InstanceLook, Levels, PlanModel, add_level, completed, plan_of_view};
use crate::frame::{Plan, PlanLimits, Shortfall, Tolerance, plan_on};
use crate::mesh::{InstanceKey, MeshSink, Scene, TileMemory, VertexLayout};
use crate::model::PartId;
use crate::prepare::Prepared;
use crate::view::View;
use smallvec::SmallVec;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// A prepared model with workers. Sessions are independent of each other, also those of one prepared model.
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
/// let report = session.frame(frame::plan(&prepared, &tolerance), &mut sink)?;
/// assert_eq!(report.batches, sink.batches.len());
/// # Ok(())
/// # }
/// ```
///
/// Frames run on threads of the session's own, or on a pool ([`start_on`](Self::start_on)); and on the caller's in
/// [`view`](Self::view), [`frame`](Self::frame), [`finish`](Self::finish) and other calls that wait for a frame.
pub struct Session {
    /// With the parts of all [`Levels`] that the engine had when it landed.
    prepared: Arc<Prepared>,
    /// The same with those that came since, once someone asks for it.
    pub(super) grown: OnceLock<Arc<Prepared>>,
    jobs: Arc<WithHelpers>,
    /// Without them.
    pub(super) model: Arc<Prepared>,
    /// What plans for one view read of `model`; made by the first.
    plan_model: OnceLock<Arc<PlanModel>>,
    pub(super) scene: Scene,
    pub(super) keys: SceneKeys,
    workers: usize,
    engine: EngineState,
    /// Of the engine on its way.
    orders: Arc<Orders<FrameOrder>>,
    /// The plan of the last frame of views that was made.
    plan: Option<Arc<Plan>>,
    /// Of plans.
    limits: PlanLimits,
    degraded: Degraded,
    pub(super) edits: Edits,
}

/// Where the engine is.
enum EngineState {
    /// Here, with a frame that is made and not committed.
    Idle(Box<Engine>, Option<FinishedFrame>),
    /// On its way.
    Busy(Flight<FlightResult>, Control),
    /// Lost to an internal error, with its message.
    Lost(String),
}

/// An engine, and the frame that it made last.
type FlightResult = (Box<Engine>, Option<FinishedFrame>);

/// A frame to make.
struct FrameOrder {
    edited: Edited,
    views: SmallVec<[View; 2]>,
    control: Control,
}

impl Session {
    /// Deals the tiles, and starts threads for them, one less than [`SessionOptions::threads`], but at least one. They
    /// end when the session is dropped. A caller who never helps ([`finish_within`](Self::finish_within)) gets
    /// all threads by [`start_on`](Self::start_on) with [`Threads`](crate::control::Threads).
    ///
    /// # Errors
    /// When the system refuses a thread.
    pub fn start(prepared: Arc<Prepared>, options: &SessionOptions) -> Result<Self, StartError> {
        let threads = WithCaller::start(options.threads)?;
        Ok(Self::start_on(Arc::new(threads), prepared, options))
    }

    /// As [`start`](Self::start), on the threads of an engine, or on none ([`Alone`](crate::control::Alone)). Starts no
    /// thread.
    ///
    /// [`finish`](Self::finish) may be called from within a job: what no thread has begun is made by the caller.
    #[must_use]
    pub fn start_on(jobs: Arc<dyn Jobs>, prepared: Arc<Prepared>, options: &SessionOptions) -> Self {
        let model = prepared;
        let (prepared, levels) = Levels::of(&model, options.levels);
        let jobs = Arc::new(WithHelpers::of(jobs));
        let engine = Engine::new(Arc::clone(&prepared), levels, Arc::<WithHelpers>::clone(&jobs), options);
        let mut scene = prepared.scene.clone();
        let keys = SceneKeys::of(&mut scene);
        let edits = Edits::of(&scene, BTreeMap::new());
        let workers = engine.workers();
        Self {
            prepared,
            grown: OnceLock::new(),
            jobs,
            model,
            plan_model: OnceLock::new(),
            scene,
            keys,
            workers,
            engine: EngineState::Idle(Box::new(engine), None),
            orders: Arc::new(Orders::new()),
            plan: None,
            limits: options.planner.limits,
            degraded: Degraded::new(),
            edits,
        }
    }

    /// Has workers write tiles into the memory of a sink, in its layout, from the next frame on. The caller's thread
    /// then moves no vertices: the sink gets [`MeshSink::written`] instead of [`MeshSink::batch`]. Cancels a frame that
    /// was begun, and waits for its tiles in progress; the next frame of views is a whole one.
    ///
    /// Buffers of triangles stay with the threads and are filled again for every tile.
    pub fn write_into(&mut self, layout: VertexLayout, memory: Arc<dyn TileMemory>) {
        self.cancel();
        if let Ok((engine, _)) = self.wait() {
            engine.write_into(layout, memory);
        }
    }

    /// Number of workers.
    #[must_use]
    pub fn workers(&self) -> usize {
        self.workers
    }

    /// Estimates the memory that the session takes besides its prepared model. Waits for a frame that was begun. Cost:
    /// one pass over all tiles and edges.
    ///
    /// # Errors
    /// After an internal error: the session is over.
    pub fn memory(&mut self) -> Result<SessionMemory, FrameError> {
        let of_plans = self.plan_model.get().map_or(0, |model| model.memory());
        let (engine, _) = self.wait()?;
        let SessionMemory { plans, scene } = engine.memory();
        Ok(SessionMemory { plans, scene: scene + of_plans as u64 })
    }

    /// The scene of frames of views: the model's parts, then one more part for each further LOD, and the current
    /// instances.
    ///
    /// Transforms, colours and visibility are those of the last frame waited for, cancelled or not; LODs those of the
    /// last frame that was not cancelled. Calls that add or remove an instance, or update the model, bring them up to
    /// date.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The plan of the last frame of views that was made; `None` before the first. Parts that no view has shown have
    /// their coarsest plan, which each call makes: a few microseconds per tile and per edge of these, divided among
    /// threads.
    #[must_use]
    pub fn plan(&self) -> Option<Arc<Plan>> {
        self.plan.as_ref().map(|plan| completed(&*self.jobs, plan, self.prepared(), &self.limits))
    }

    /// What limits made coarser in the last frame of views that was made; `None` if nothing, and before the first.
    #[must_use]
    pub fn shortfall(&self) -> Option<&Shortfall> {
        self.plan.as_ref()?.shortfall.as_ref()
    }

    /// The degraded tiles that the sink of frames of views has, ascending by (part, tile), numbered as the sink does.
    pub fn degraded(&self) -> impl Iterator<Item = &DegradedTile> {
        self.degraded.values()
    }

    /// The prepared model. Further LODs of a part are parts of their own, after all parts of the model. Those of
    /// instances that were added since the last frame of views cost the first call a pass over the parts.
    #[must_use]
    pub fn prepared(&self) -> &Arc<Prepared> {
        let new = &self.scene.parts[self.prepared.parts.len()..];
        if new.is_empty() {
            return &self.prepared;
        }
        self.grown.get_or_init(|| {
            let mut grown = Prepared::clone(&self.prepared);
            new.iter().filter_map(|part| part.mesh_of).for_each(|part| _ = add_level(&mut grown, part));
            Arc::new(grown)
        })
    }

    /// The model's part of the instance in this row of [`scene`](Self::scene), whatever its current LOD. `None` if out
    /// of range.
    #[must_use]
    pub fn part_of(&self, row: usize) -> Option<PartId> {
        self.scene.instances.get(row).map(|instance| self.scene.of_model(instance.part))
    }

    /// The key of the instance in this row of [`scene`](Self::scene). `None` if out of range.
    #[must_use]
    pub fn instance_key(&self, row: usize) -> Option<InstanceKey> {
        self.scene.instances.get(row)?.key
    }

    /// The row of an instance in [`scene`](Self::scene), from the next frame of views on. `None` if it was removed.
    #[must_use]
    pub fn instance_row(&self, key: InstanceKey) -> Option<usize> {
        self.keys.row(key)
    }

    /// A plan for [`frame`](Self::frame), for a tolerance everywhere ([`plan_within`](crate::frame::plan_within())),
    /// made on the session's threads. [`plan_on`] can be cancelled.
    #[must_use]
    pub fn plan_within(&self, tolerance: &Tolerance, limits: &PlanLimits) -> Plan {
        plan_on(&*self.jobs, &self.model, tolerance, limits, &Control::default()).unwrap_or_default()
    }

    /// A plan for [`frame`](Self::frame), for one view
    /// ([`plan_for_view_within`](crate::frame::plan_for_view_within())), made on the session's threads. The first call,
    /// and the first after an update, stores what plans read of the model: 96 bytes per instance, and 52 per part.
    #[must_use]
    pub fn plan_for_view(&self, view: &View, limits: &PlanLimits) -> Plan {
        let model = self.plan_model.get_or_init(|| Arc::new(PlanModel::of(&self.model)));
        plan_of_view(&*self.jobs, model, view, limits, &Control::default()).unwrap_or_default()
    }

    /// Switches to another model from the next frame on: usually an [update](Prepared::update) of this one, whose file
    /// has changed. The next frame of views sends only what differs, by [`MeshSink::begin_update`]. Until it is
    /// committed, the sink keeps the last frame, whole.
    ///
    /// Parts with the same content keep their levels, and their tiles stay in the sink; they are made again only where
    /// the views ask for it, as ever. Parts are numbered as in the new model. Its instances replace all others, those
    /// added or moved at run time too: keys from before name none, and their attributes end. Those of parts with the
    /// same content go on, others are the default. Instances of such a part keep LODs by their order. Plans from before
    /// are void.
    ///
    /// The sink then has the tiles, byte for byte, that a new session with this model would give it for the same views.
    /// Exceptions: [`Batch::worker`](crate::mesh::Batch::worker), and levels that hysteresis holds where views or
    /// instances moved.
    ///
    /// Cancels a frame of views that was begun, and waits for the tiles in progress. Cost on this thread: about a
    /// microsecond per tile to deal them, and a few per tile and edge of new parts, divided among threads.
    ///
    /// # Errors
    /// After an internal error: the session is over.
    pub fn update(&mut self, prepared: Arc<Prepared>) -> Result<(), FrameError> {
        // Its rows are changed in place if nobody else has it.
        self.plan = None;
        let engine = self.edited()?;
        let from = engine.update(&prepared);
        let (parts, looks) = (engine.placed.part_attributes().clone(), engine.placed.take_looks());
        self.prepared = Arc::clone(&engine.prepared);
        self.grown = OnceLock::new();
        self.model = prepared;
        self.plan_model = OnceLock::new();
        let before = std::mem::replace(&mut self.scene, self.prepared.scene.clone());
        self.keys.update(&before, &mut self.scene, &from);
        self.edits = Edits::of(&self.scene, parts);
        self.repaint(looks);
        Ok(())
    }

    /// Draws instances as the engine says.
    pub(super) fn repaint(&mut self, looks: Vec<(usize, InstanceLook)>) {
        self.keys.change(looks.iter().map(|(row, _)| *row));
        for (row, InstanceLook { transform, visible, colour }) in looks {
            let instance = &mut self.scene.instances[row];
            (instance.transform, instance.visible, instance.colour) = (transform, visible, colour);
        }
    }

    /// Tessellates the whole model by `plan` and feeds it to `sink` on this thread. The sink gets the same calls with
    /// the same bytes for any number of workers and threads, except for
    /// [`Batch::worker`](crate::mesh::Batch::worker) and the order of tiles [in its memory](Self::write_into).
    ///
    /// The frame has the instances of [`Prepared::scene`], whatever was added, moved, removed or set at run time.
    ///
    /// Cancels a frame of views that was begun. The next frame of views is a whole one. A plan of which the caller
    /// keeps no other handle is freed on the session's threads.
    ///
    /// # Errors
    /// * [`FrameError::Plan`] if the plan is one of another model, or was stored and damaged: the sink was not touched.
    /// * [`FrameError::Grid`] if a tile does not fit the grid of the sink's layout
    ///   ([`write_into`](Self::write_into)): the sink was not touched.
    /// * [`FrameError::Sink`] if the sink refuses or panics: its `abort` was called. If its memory does: the sink was
    ///   not touched.
    /// * [`FrameError::Lost`] after an internal error. The session is over; after the others it can go on.
    pub fn frame(&mut self, plan: impl Into<Arc<Plan>>, sink: &mut dyn MeshSink) -> Result<FrameReport, FrameError> {
        self.frame_controlled(plan, &Control::default(), sink)
    }

    /// As [`frame`](Self::frame), with progress and cancellation between tiles.
    ///
    /// # Errors
    /// As [`frame`](Self::frame), and [`FrameError::Cancelled`]: the sink was not touched, or its `abort` was called.
    pub fn frame_controlled(
        &mut self,
        plan: impl Into<Arc<Plan>>,
        control: &Control,
        sink: &mut dyn MeshSink,
    ) -> Result<FrameReport, FrameError> {
        self.forget();
        let model = Arc::clone(&self.model);
        let (engine, _) = self.wait()?;
        engine.whole(plan.into(), (&model.scene, control), sink)
    }

    /// Updates `sink` for all of these views together: one picture, both eyes, shadow maps. `sink` must be the one of
    /// the last frame of views. The caller makes the frame and threads help, unless a job makes the one before.
    ///
    /// The first frame is whole. Later frames send the tiles that changed and [`MeshSink::drawn`]. If nothing changed,
    /// not even the drawn tiles, the sink gets no calls.
    ///
    /// Tiles that leave the view stay resident until they are outdated. Every 64 frames, if more than half of the
    /// resident triangles are not drawn, tiles that were not drawn in the last 128 frames are evicted.
    ///
    /// Drawn tiles have no cracks between them, in every frame. The sink gets the same calls for any number of
    /// workers and threads, with the exceptions of [`frame`](Self::frame).
    ///
    /// # Errors
    /// As [`begin`](Self::begin) and [`finish`](Self::finish).
    pub fn view(&mut self, views: &[View], sink: &mut dyn MeshSink) -> Result<FrameReport, FrameError> {
        self.order(views)?;
        self.finish(sink)
    }

    /// Begins a frame of views: a job plans and makes it. Returns at once, unless [`Jobs::spawn`] runs the job itself,
    /// as that of [`Alone`](crate::control::Alone) does. Cancels an unfinished frame: what was set or moved before it
    /// becomes part of this one, and nothing else of it. If the sink already shows these views, nothing is left to
    /// refine and the [limit](SessionOptions::resident_bytes) is kept, no job is spawned.
    ///
    /// Cost on this thread: a copy of the views, and of what was set or moved since the last call.
    ///
    /// # Errors
    /// [`FrameError::View`] if a view is invalid: nothing changes, and a frame that was begun goes on.
    /// [`FrameError::Lost`] after an internal error: the session is over.
    pub fn begin(&mut self, views: &[View]) -> Result<(), FrameError> {
        self.order(views)?;
        if let EngineState::Busy(flight, _) = &self.engine {
            flight.spawn(&*self.jobs);
        }
        Ok(())
    }

    /// As [`begin`](Self::begin), for whoever waits for the frame at once: no job is spawned.
    fn order(&mut self, views: &[View]) -> Result<(), FrameError> {
        let _span = tracing::debug_span!("begin").entered();
        for (k, view) in views.iter().enumerate() {
            view.check().map_err(|why| FrameError::View { view: k, why })?;
        }
        if let EngineState::Idle(engine, None) = &self.engine
            && self.edits.is_empty()
            && engine.shows(views)
        {
            return Ok(());
        }
        self.cancel();
        let (edited, views, control) = (self.edits.take(&self.keys), SmallVec::from_slice(views), Control::default());
        let is_lost = matches!(self.engine, EngineState::Lost(_));
        let is_served = !is_lost && self.orders.add(FrameOrder { edited, views, control: control.clone() });
        let landed = match std::mem::replace(&mut self.engine, EngineState::Lost(String::new())) {
            EngineState::Busy(flight, _) if is_served => {
                self.engine = EngineState::Busy(flight, control);
                return Ok(());
            }
            EngineState::Busy(flight, _) => flight.land().map(|(engine, _)| engine),
            EngineState::Idle(engine, _) => Ok(engine),
            EngineState::Lost(why) => Err(why),
        };
        let mut engine = match landed {
            Ok(engine) => engine,
            Err(why) => {
                self.engine = EngineState::Lost(why.clone());
                return Err(FrameError::Lost { why });
            }
        };
        let orders = Arc::clone(&self.orders);
        let make = move || {
            let mut frame = None;
            while let Some(FrameOrder { edited, views, control }) = orders.next() {
                // It holds the plan, which is taken back.
                drop(frame.take());
                engine.apply(edited);
                frame = engine.make(&views, &control);
            }
            (engine, frame)
        };
        self.engine = EngineState::Busy(Flight::of(self.jobs.helpers(), make), control);
        Ok(())
    }

    /// Whether [`finish`](Self::finish) would return without waiting: the frame is made, or none was begun. Spawns its
    /// job again if the pool has dropped it.
    #[must_use]
    pub fn is_made(&self) -> bool {
        match &self.engine {
            EngineState::Busy(flight, _) => flight.has_landed(&*self.jobs),
            EngineState::Idle(..) | EngineState::Lost(_) => true,
        }
    }

    /// Cancels the frame that was begun, if any: later frames are as if it had not been. Levels follow committed frames
    /// alone, whenever others were cancelled. Tiles in progress are made to their end.
    pub fn cancel(&mut self) {
        match &mut self.engine {
            EngineState::Busy(_, control) => control.cancel(),
            EngineState::Idle(engine, frame) => {
                if frame.take().is_some() {
                    engine.settle();
                    select((&mut self.scene, &mut self.keys), engine);
                }
            }
            EngineState::Lost(_) => {}
        }
    }

    /// Makes the next frame of views a whole one, for a new or emptied sink. Cancels a frame that was begun, and waits
    /// for its tiles in progress.
    pub fn forget(&mut self) {
        self.cancel();
        if let Ok((engine, _)) = self.wait() {
            engine.forget();
        }
    }

    /// Makes the frame that was begun, or helps, then updates `sink` as [`view`](Self::view) does. Without one, does
    /// nothing.
    ///
    /// # Errors
    /// * [`FrameError::Sink`] if the sink [reads](MeshSink::reads) more than was made: it was not touched, and the next
    ///   frame of views is a whole one.
    /// * [`FrameError::Grid`], [`FrameError::Sink`] and [`FrameError::Lost`] as in [`frame`](Self::frame).
    pub fn finish(&mut self, sink: &mut dyn MeshSink) -> Result<FrameReport, FrameError> {
        self.wait()?;
        match &mut self.engine {
            EngineState::Idle(engine, frame) => match frame.take() {
                Some(frame) => {
                    let scene = (&self.scene, self.keys.changes());
                    let report = engine.commit(frame, scene, &mut self.degraded, sink);
                    match report {
                        Ok(_) => self.keys.committed(&self.scene),
                        // The LODs that it selected are taken back.
                        Err(_) => select((&mut self.scene, &mut self.keys), engine),
                    }
                    report
                }
                None => Ok(engine.unchanged()),
            },
            EngineState::Busy(..) => Err(FrameError::Lost { why: "the engine is not back".into() }),
            EngineState::Lost(why) => Err(FrameError::Lost { why: why.clone() }),
        }
    }

    /// As [`finish`](Self::finish), but waits for the frame no longer than `at_most`: `None` if it is not made by then,
    /// and the sink keeps the last frame. Never makes it on this thread; spawns its job again if the pool has dropped
    /// it.
    ///
    /// # Errors
    /// As [`finish`](Self::finish).
    pub fn finish_within(
        &mut self,
        at_most: Duration,
        sink: &mut dyn MeshSink,
    ) -> Result<Option<FrameReport>, FrameError> {
        if let EngineState::Busy(flight, _) = &mut self.engine
            && !flight.lands_within(&*self.jobs, at_most)
        {
            return Ok(None);
        }
        self.finish(sink).map(Some)
    }

    /// Waits for the engine, and helps meanwhile. A frame that was cancelled while it was made is discarded.
    fn wait(&mut self) -> Result<(&mut Engine, &mut Option<FinishedFrame>), Lost> {
        if matches!(self.engine, EngineState::Busy(..))
            && let EngineState::Busy(flight, control) =
                std::mem::replace(&mut self.engine, EngineState::Lost(String::new()))
        {
            self.engine = match flight.land() {
                Ok((engine, frame)) => self.landed(engine, frame, &control),
                Err(why) => EngineState::Lost(why),
            };
        }
        match &mut self.engine {
            EngineState::Idle(engine, frame) => Ok((engine, frame)),
            EngineState::Lost(why) => Err(Lost(why.clone())),
            EngineState::Busy(..) => Err(Lost(String::new())),
        }
    }

    /// The engine, with what was set or moved since the last call. A frame that was begun is cancelled.
    pub(super) fn edited(&mut self) -> Result<&mut Engine, Lost> {
        self.cancel();
        let edited = self.edits.take(&self.keys);
        let (engine, _) = self.wait()?;
        engine.apply(edited);
        Ok(engine)
    }

    fn landed(&mut self, mut engine: Box<Engine>, frame: Option<FinishedFrame>, control: &Control) -> EngineState {
        let frame = frame.filter(|_| !control.is_cancelled());
        if frame.is_none() {
            // It may have been made before it was cancelled.
            engine.settle();
        }
        select((&mut self.scene, &mut self.keys), &mut engine);
        self.repaint(engine.placed.take_looks());
        self.prepared = Arc::clone(&engine.prepared);
        self.grown = OnceLock::new();
        self.plan = frame.as_ref().map(|frame| Arc::clone(&frame.plan)).or(self.plan.take());
        EngineState::Idle(engine, frame)
    }
}

/// Takes over the LODs that the engine has selected.
fn select((scene, keys): (&mut Scene, &mut SceneKeys), engine: &mut Engine) {
    let selected = engine.placed.take_selected();
    keys.change(selected.iter().map(|(row, _)| *row));
    selected.into_iter().for_each(|(row, part)| scene.instances[row].part = part);
}

impl fmt::Debug for Session {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Scene { name, parts, instances } = &self.scene;
        let state = match &self.engine {
            EngineState::Idle(_, None) => "idle",
            EngineState::Idle(_, Some(_)) => "made",
            EngineState::Busy(..) => "busy",
            EngineState::Lost(_) => "lost",
        };
        let mut session = f.debug_struct("Session");
        session.field("model", name).field("parts", &parts.len()).field("instances", &instances.len());
        session.field("workers", &self.workers).field("state", &state).finish_non_exhaustive()
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        // Nothing of the session outlives it.
        self.cancel();
        let _ = self.wait();
    }
}
