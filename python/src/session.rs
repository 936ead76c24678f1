//! Frames of views from Python: each call returns what has changed, as arrays that share the memory of the tiles.

use crate::array;
use crate::attributes::{Attributes, attributes, edit_error};
use crate::errors;
use crate::job::HEARD_EVERY;
use crate::model::Instance;
use crate::prepared::Prepared;
use crate::view::View;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};
use trimtess::control::{StartError, Threads};
use trimtess::glam::{DAffine3, DMat4};
use trimtess::mesh::{
    Batch, DrawnTiles, EdgeLine, InstanceKey, MeshLists, MeshSink, Scene, SceneChanges, SceneInstance, SinkError,
};
use trimtess::model::PartId;
use trimtess::parallel::{self, FrameReport, SessionOptions};
use trimtess::prepare;

/// What a frame changes. Arrays keep their tile alive, not the frame.
#[derive(Default)]
struct Changes {
    /// Those without triangles are tiles to remove.
    batches: Vec<Arc<Batch>>,
    lines: Vec<Arc<EdgeLine>>,
    /// Kept from the frame before where nothing was sent.
    drawn: Arc<DrawnTiles>,
    instances: Arc<Vec<SceneInstance>>,
    /// After an update: the parts of which tiles are kept, and what they were.
    from: Option<Vec<Option<PartId>>>,
    /// Keys of instances.
    added: Vec<u64>,
    changed: Vec<u64>,
    removed: Vec<u64>,
    appeared: DrawnTiles,
    disappeared: DrawnTiles,
}

fn keys<'a>(instances: impl Iterator<Item = &'a SceneInstance>) -> Vec<u64> {
    instances.filter_map(|instance| instance.key).map(InstanceKey::to_bits).collect()
}

impl MeshSink for Changes {
    /// What a `Tile` has.
    fn reads(&self) -> MeshLists {
        MeshLists { uvs: true, ..MeshLists::NONE }
    }

    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        // Whatever was before: changes of an empty scene look like none.
        self.instances = Arc::default();
        self.begin_changes(scene, &SceneChanges::default())
    }

    fn begin_changes(&mut self, scene: &Scene, changes: &SceneChanges<'_>) -> Result<(), SinkError> {
        if !changes.keep_instances(scene) {
            self.instances = Arc::new(scene.instances.clone());
        }
        self.added = keys(scene.instances.iter().skip(changes.first_instance));
        self.changed = keys(changes.changed.iter().map(|row| &scene.instances[*row]));
        self.removed = changes.removed.iter().map(|key| key.to_bits()).collect();
        Ok(())
    }

    fn begin_update(
        &mut self,
        scene: &Scene,
        changes: &SceneChanges<'_>,
        from: &[Option<PartId>],
    ) -> Result<(), SinkError> {
        self.from = Some(from.to_vec());
        self.begin_changes(scene, changes)
    }

    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError> {
        self.batches.push(Arc::new(Batch { mesh: std::mem::take(&mut batch.mesh), ..*batch }));
        Ok(())
    }

    fn edge_line(&mut self, line: EdgeLine) -> Result<(), SinkError> {
        self.lines.push(Arc::new(line));
        Ok(())
    }

    fn drawn(&mut self, drawn: &DrawnTiles, before: &DrawnTiles) -> Result<(), SinkError> {
        self.drawn = Arc::new(drawn.clone());
        self.appeared.set_difference(drawn, before);
        self.disappeared.set_difference(before, drawn);
        Ok(())
    }

    fn abort(&mut self) {
        *self = Self::default();
    }
}

/// A session, and what the last frame showed.
struct State {
    session: parallel::Session,
    drawn: Arc<DrawnTiles>,
    instances: Arc<Vec<SceneInstance>>,
}

/// A prepared model with workers, for a moving camera.
#[pyclass(frozen, module = "trimtess")]
pub(crate) struct Session(Mutex<State>);

impl Session {
    pub(crate) fn start(py: Python<'_>, prepared: &Arc<prepare::Prepared>, options: &SessionOptions) -> PyResult<Self> {
        // All threads work: the caller's only waits for interrupts.
        let session = py.detach(|| {
            let threads = Arc::new(Threads::start(options.threads)?);
            Ok::<_, StartError>(parallel::Session::start_on(threads, Arc::clone(prepared), options))
        });
        let session = session.map_err(|failure| errors::no_threads(py, &failure))?;
        let instances = Arc::new(session.scene().instances.clone());
        Ok(Self(Mutex::new(State { session, drawn: Arc::default(), instances })))
    }

    /// Does not wait: the thread that has the session may be waiting for the interpreter's lock.
    fn state(&self) -> PyResult<MutexGuard<'_, State>> {
        match self.0.try_lock() {
            Ok(state) => Ok(state),
            Err(TryLockError::Poisoned(state)) => Ok(state.into_inner()),
            Err(TryLockError::WouldBlock) => Err(PyRuntimeError::new_err("another thread is using the session")),
        }
    }
}

#[pymethods]
impl Session {
    /// Makes what these views need together, and returns what has changed since the last frame: one picture, both eyes,
    /// shadow maps. The first frame is whole. Same bytes for any number of workers.
    ///
    /// Drawn tiles have no cracks between them. Ctrl-C cancels the frame after the tiles in hand; the next one is as if
    /// it had not been begun.
    ///
    /// Args:
    ///     views: `View`s. Tiles that none of them shows are not drawn.
    ///
    /// Raises:
    ///     InternalError: An internal error ended the session.
    ///     RuntimeError: Another thread is using the session.
    #[pyo3(signature = (*views))]
    fn view(&self, py: Python<'_>, views: Vec<PyRef<'_, View>>) -> PyResult<Frame> {
        let mut state = self.state()?;
        let State { session, drawn, instances } = &mut *state;
        let views: Vec<_> = views.iter().map(|view| view.0).collect();
        let unmade = |failure| errors::unmade(py, &failure);
        session.begin(&views).map_err(unmade)?;
        let mut changes = Changes { drawn: Arc::clone(drawn), instances: Arc::clone(instances), ..Changes::default() };
        let report = loop {
            if let Some(report) = py.detach(|| session.finish_within(HEARD_EVERY, &mut changes)).map_err(unmade)? {
                break report;
            }
            if let Err(raised) = py.check_signals() {
                session.cancel();
                // It was cancelled, so the sink gets no calls.
                py.detach(|| session.finish(&mut changes)).map_err(unmade)?;
                return Err(raised);
            }
        };
        (*drawn, *instances) = (Arc::clone(&changes.drawn), Arc::clone(&changes.instances));
        Ok(Frame { changes, report, shortfall: session.shortfall().map(ToString::to_string) })
    }

    /// Goes on with another prepared model: one of a file that has changed, prepared with `like`. The next frame has
    /// the tiles that differ, and tells by `renumbered` which parts are which. Instances are those of the new model;
    /// keys from before name none.
    ///
    /// Args:
    ///     prepared: The model.
    ///
    /// Raises:
    ///     InternalError: An internal error ended the session.
    ///     RuntimeError: Another thread is using the session.
    fn update(&self, py: Python<'_>, prepared: PyRef<'_, Prepared>) -> PyResult<()> {
        let model = Arc::clone(&prepared.prepared);
        let mut state = self.state()?;
        let session = &mut state.session;
        py.detach(|| session.update(model)).map_err(|failure| errors::unmade(py, &failure))
    }

    /// Makes the next frame a whole one.
    fn forget(&self, py: Python<'_>) -> PyResult<()> {
        let mut state = self.state()?;
        let session = &mut state.session;
        py.detach(|| session.forget());
        Ok(())
    }

    /// Keys of the instances, in the order of `Frame.instances` from the next frame on.
    #[getter]
    fn keys(&self) -> PyResult<Vec<u64>> {
        let state = self.state()?;
        let rows = 0..state.session.scene().instances.len();
        Ok(rows.filter_map(|row| state.session.instance_key(row)).map(InstanceKey::to_bits).collect())
    }

    /// Adds an instance from the next frame on, and returns its key.
    ///
    /// Args:
    ///     part: Index of a part of the model.
    ///     transform: Part to world: (4, 4) numbers that multiply columns (x, y, z, 1), a rigid motion with an optional
    ///         reflection and uniform scale; the identity if None.
    ///     name: Its name.
    ///
    /// Raises:
    ///     RangeError: There is no such part, or the transform is another one.
    #[pyo3(signature = (part, transform=None, *, name=""))]
    fn add_instance(&self, py: Python<'_>, part: u32, transform: Option<[[f64; 4]; 4]>, name: &str) -> PyResult<u64> {
        let transform = transform.map_or(Ok(DAffine3::IDENTITY), |rows| affine(py, rows))?;
        let new = SceneInstance { name: name.into(), ..SceneInstance::new(PartId(part), transform) };
        let mut state = self.state()?;
        let session = &mut state.session;
        let added = py.detach(|| session.add_instance(new));
        added.map(InstanceKey::to_bits).map_err(|failure| edit_error(py, &failure))
    }

    /// Moves an instance from the next frame on.
    ///
    /// Args:
    ///     key: Its key.
    ///     transform: As that of `add_instance`.
    ///
    /// Raises:
    ///     RangeError: The key names no instance, or the transform is another one.
    fn move_instance(&self, py: Python<'_>, key: u64, transform: [[f64; 4]; 4]) -> PyResult<()> {
        let transform = affine(py, transform)?;
        let moved = self.state()?.session.move_instance(InstanceKey::from_bits(key), transform);
        moved.map_err(|failure| edit_error(py, &failure))
    }

    /// Removes an instance from the next frame on. The rows of later ones decrease by one, and keys stay.
    ///
    /// Args:
    ///     key: Its key.
    ///
    /// Raises:
    ///     RangeError: The key names no instance.
    fn remove_instance(&self, py: Python<'_>, key: u64) -> PyResult<()> {
        let mut state = self.state()?;
        let session = &mut state.session;
        let removed = py.detach(|| session.remove_instance(InstanceKey::from_bits(key)));
        removed.map(drop).map_err(|failure| edit_error(py, &failure))
    }

    /// Removes instances in one pass, as `remove_instance` removes one.
    ///
    /// Args:
    ///     keys: Their keys.
    ///
    /// Raises:
    ///     RangeError: A key names no instance, or one is named twice. Nothing changes.
    fn remove_instances(&self, py: Python<'_>, keys: Vec<u64>) -> PyResult<()> {
        let mut state = self.state()?;
        let session = &mut state.session;
        let keys: Vec<InstanceKey> = keys.into_iter().map(InstanceKey::from_bits).collect();
        let removed = py.detach(|| session.remove_instances(&keys));
        removed.map(drop).map_err(|failure| edit_error(py, &failure))
    }

    /// Sets how views draw a part of the model, from the next frame on: all its instances, together with their own
    /// attributes. Replaces what was set before.
    ///
    /// Args:
    ///     part: Index of a part of the model.
    ///     visible: Whether views draw it. An instance is drawn if it and its part are visible.
    ///     colour: Red, green, blue (sRGB) and opacity (1 if not given), 0 to 1, instead of the colours of the model.
    ///     An
    ///         instance's overrides its part's. A colour costs no tile.
    ///     tolerance_scale: Factor on `deviation_px` and `size_px` of all views, not on `angle`: 0.5 is twice as fine.
    ///         Those of an instance and its part are multiplied; products below 1e-6 and above 1e6 count as these.
    ///         Instances that share a level of detail are as fine as the strictest of them needs.
    ///     priority: Factor on the error by which tiles are ordered while `budget_ms` defers some. Those of an instance
    ///         and its part are multiplied. Instances that share a level of detail share the largest of those in view.
    ///
    /// Raises:
    ///     RangeError: There is no such part, or a value is out of range.
    #[pyo3(signature = (part, *, visible=true, colour=None, tolerance_scale=1.0, priority=1.0))]
    fn set_part(
        &self,
        py: Python<'_>,
        part: u32,
        visible: bool,
        colour: Option<Vec<f32>>,
        tolerance_scale: f64,
        priority: f64,
    ) -> PyResult<()> {
        let attributes = attributes(py, (visible, colour), (tolerance_scale, priority))?;
        self.state()?.session.set_part(PartId(part), &attributes).map_err(|failure| edit_error(py, &failure))
    }

    /// Sets how views draw an instance, from the next frame on, as `set_part` does for all instances of a part.
    ///
    /// Args:
    ///     key: Its key.
    ///     visible: As that of `set_part`.
    ///     colour: As that of `set_part`.
    ///     tolerance_scale: As that of `set_part`.
    ///     priority: As that of `set_part`.
    ///
    /// Raises:
    ///     RangeError: The key names no instance, or a value is out of range.
    #[pyo3(signature = (key, *, visible=true, colour=None, tolerance_scale=1.0, priority=1.0))]
    fn set_instance(
        &self,
        py: Python<'_>,
        key: u64,
        visible: bool,
        colour: Option<Vec<f32>>,
        tolerance_scale: f64,
        priority: f64,
    ) -> PyResult<()> {
        let key = InstanceKey::from_bits(key);
        let attributes = attributes(py, (visible, colour), (tolerance_scale, priority))?;
        self.state()?.session.set_instance(key, &attributes).map_err(|failure| edit_error(py, &failure))
    }

    /// What `set_part` set last.
    ///
    /// Args:
    ///     part: Index of a part of the model.
    ///
    /// Raises:
    ///     RangeError: There is no such part.
    fn part_attributes(&self, py: Python<'_>, part: u32) -> PyResult<Attributes> {
        let told = self.state()?.session.part_attributes(PartId(part));
        told.map(Attributes::from).map_err(|failure| edit_error(py, &failure))
    }

    /// What `set_instance` set last.
    ///
    /// Args:
    ///     key: Its key.
    ///
    /// Raises:
    ///     RangeError: The key names no instance.
    fn instance_attributes(&self, py: Python<'_>, key: u64) -> PyResult<Attributes> {
        let told = self.state()?.session.instance_attributes(InstanceKey::from_bits(key));
        told.map(Attributes::from).map_err(|failure| edit_error(py, &failure))
    }

    fn __repr__(&self) -> String {
        // Debuggers ask at any time.
        let Ok(state) = self.state() else { return "<Session in use by another thread>".to_owned() };
        let scene = state.session.scene();
        format!("<Session of {:?}: {} instances>", scene.name, scene.instances.len())
    }
}

fn affine(py: Python<'_>, rows: [[f64; 4]; 4]) -> PyResult<DAffine3> {
    if rows[3] != [0.0, 0.0, 0.0, 1.0] {
        let last = format!("{:?}", rows[3]);
        return Err(errors::out_of_range(py, "the last row of transform", last, "(0, 0, 0, 1)"));
    }
    Ok(DAffine3::from_mat4(DMat4::from_cols_array_2d(&rows).transpose()))
}

/// What a frame of views changes, and what it draws.
#[pyclass(frozen, module = "trimtess")]
pub(crate) struct Frame {
    changes: Changes,
    report: FrameReport,
    /// Why it is coarser than its views ask; None if it is not. `max_memory` of the session, and the limits on
    /// triangles that `tessellate` has, hold for frames, too.
    #[pyo3(get)]
    shortfall: Option<String>,
}

/// A row of `Frame.instances`, and tiles.
type TilesOf<'py> = (usize, Bound<'py, PyAny>);

impl Frame {
    fn listed<'py>(&self, py: Python<'py>, view: usize, tiles: &DrawnTiles) -> PyResult<Vec<TilesOf<'py>>> {
        let views = self.changes.drawn.views();
        if view >= views {
            return Err(errors::out_of_range(py, "view", view, &format!("below {views}, the number of views")));
        }
        let of = |instance| {
            let tiles: Arc<Vec<u32>> = Arc::new(tiles.tiles(view, instance).map(|tile| tile.0).collect());
            Ok((instance, array::view(py, &tiles, &tiles)?))
        };
        tiles.instances(view).map(of).collect()
    }
}

#[pymethods]
impl Frame {
    /// Whether it replaces everything before it, rather than changing some tiles.
    #[getter]
    fn whole(&self) -> bool {
        self.report.whole
    }

    /// After `Session.update`: the part's new number by the one before, for parts whose tiles are kept. Renumber these,
    /// and drop those of all other parts. None otherwise.
    #[getter]
    fn renumbered(&self) -> Option<BTreeMap<u32, u32>> {
        let from = self.changes.from.as_ref()?;
        let kept = (0..).zip(from).filter_map(|(part, from)| Some((from.as_ref()?.0, part)));
        Some(kept.collect())
    }

    /// Tiles that are new or replace the tile with the same key, ascending by key.
    #[getter]
    fn changed(&self) -> Vec<Tile> {
        let some = self.changes.batches.iter().filter(|batch| !batch.mesh.triangles.is_empty());
        some.map(|batch| Tile(Arc::clone(batch))).collect()
    }

    /// Keys of tiles that are gone, ascending: (part, tile).
    #[getter]
    fn removed(&self) -> Vec<(u32, u32)> {
        let none = self.changes.batches.iter().filter(|batch| batch.mesh.triangles.is_empty());
        none.map(|batch| (batch.part.0, batch.tile.0)).collect()
    }

    /// Polylines of edges that are new or replace that of the same edge, ascending: part, edge, and a (n, 3) array of
    /// doubles, millimetres in the part's coordinates. Empty unless the session has edges.
    #[getter]
    fn edges<'py>(&self, py: Python<'py>) -> PyResult<Vec<(u32, u32, Bound<'py, PyAny>)>> {
        let lines = self.changes.lines.iter();
        lines.map(|line| Ok((line.part.0, line.edge.0, array::view(py, line, &line.points)?))).collect()
    }

    /// Placed parts. A part of which coarser levels of detail are drawn has further parts, after those of the model.
    #[getter]
    fn instances(&self) -> Vec<Instance> {
        self.changes.instances.iter().map(Instance::of_scene).collect()
    }

    /// What to draw: rows of `instances`, ascending, each with the tiles of its part to draw, an ascending array of
    /// 32-bit unsigned integers. Instances that draw nothing are left out.
    ///
    /// Args:
    ///     view: Which of the views.
    ///
    /// Raises:
    ///     RangeError: There is no such view.
    #[pyo3(signature = (view=0))]
    fn drawn<'py>(&self, py: Python<'py>, view: usize) -> PyResult<Vec<TilesOf<'py>>> {
        self.listed(py, view, &self.changes.drawn)
    }

    /// The tiles of `drawn` that the frame before did not draw, in the same form.
    ///
    /// Args:
    ///     view: Which of the views.
    ///
    /// Raises:
    ///     RangeError: There is no such view.
    #[pyo3(signature = (view=0))]
    fn appeared<'py>(&self, py: Python<'py>, view: usize) -> PyResult<Vec<TilesOf<'py>>> {
        self.listed(py, view, &self.changes.appeared)
    }

    /// The tiles that the frame before drew and this one does not, in the form of `drawn`: those of instances that
    /// there still are, by their rows now. An instance of `changed_instances` may draw another level of detail: then
    /// its tiles are others, also those in neither list.
    ///
    /// Args:
    ///     view: Which of the views.
    ///
    /// Raises:
    ///     RangeError: There is no such view.
    #[pyo3(signature = (view=0))]
    fn disappeared<'py>(&self, py: Python<'py>, view: usize) -> PyResult<Vec<TilesOf<'py>>> {
        self.listed(py, view, &self.changes.disappeared)
    }

    /// Keys of instances that the frame before did not have, in the order of `instances`, whose last rows they are. All
    /// of them in a whole frame.
    #[getter]
    fn added_instances(&self) -> Vec<u64> {
        self.changes.added.clone()
    }

    /// Keys of instances of the frame before whose level of detail, transform, colour or visibility may differ.
    #[getter]
    fn changed_instances(&self) -> Vec<u64> {
        self.changes.changed.clone()
    }

    /// Keys of instances of the frame before that are gone; none in a whole frame, which replaces all.
    #[getter]
    fn removed_instances(&self) -> Vec<u64> {
        self.changes.removed.clone()
    }

    /// Number of triangles in `changed`.
    #[getter]
    fn triangle_count(&self) -> u64 {
        self.report.triangles
    }

    /// Tiles of this frame whose boundary crosses itself, was filled or vanished, ascending: (part, tile, why).
    #[getter]
    fn degraded(&self) -> Vec<(u32, u32, String)> {
        let rows = self.report.degraded.iter();
        rows.map(|row| (row.part.0, row.tile.0, row.degradation.to_string())).collect()
    }

    /// Tiles whose change waits for a later frame, because the budget was spent.
    #[getter]
    fn deferred(&self) -> u32 {
        self.report.deferred
    }

    fn __repr__(&self) -> String {
        let (kind, tiles) = (if self.report.whole { "whole" } else { "changes" }, self.report.batches);
        format!("<Frame {}, {kind}: {tiles} tiles, {} triangles>", self.report.frame, self.report.triangles)
    }
}

/// The triangles of one tile of a face. Instances share those of their part.
#[pyclass(frozen, module = "trimtess")]
pub(crate) struct Tile(Arc<Batch>);

#[pymethods]
impl Tile {
    /// What names it in the session: (part, tile).
    #[getter]
    fn key(&self) -> (u32, u32) {
        (self.0.part.0, self.0.tile.0)
    }

    /// Index of the face within the part.
    #[getter]
    fn face(&self) -> u32 {
        self.0.face.0
    }

    /// (n, 3) doubles, millimetres in the part's coordinates. Points on borders that tiles share have equal bits.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::view(py, &self.0, &self.0.mesh.positions)
    }

    /// (n, 3) floats: unit normals that point outwards.
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::view(py, &self.0, &self.0.mesh.normals)
    }

    /// (n, 2) floats: parameters on the face's surface.
    #[getter]
    fn uv<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::view(py, &self.0, &self.0.mesh.uvs)
    }

    /// (m, 3) 32-bit unsigned indices of vertices, counter-clockwise seen from outside.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::view(py, &self.0, &self.0.mesh.triangles)
    }

    fn __repr__(&self) -> String {
        let (batch, count) = (&self.0, self.0.mesh.triangles.len());
        format!("<Tile {} of part {}, face {}: {count} triangles>", batch.tile.0, batch.part.0, batch.face.0)
    }
}
