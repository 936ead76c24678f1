//! A model and its parts, faces, edges and instances, as data.

use crate::array;
use crate::diagnostic::{self, Diagnostic};
use crate::errors;
use crate::job::{Job, threads};
use crate::prepared::Prepared;
use pyo3::prelude::*;
use std::sync::Arc;
use trimtess::control::Rayon;
use trimtess::model::{self, Colour, Loop};
use trimtess::prepare::{PrepareLimits, PrepareOptions, Shells};

/// Red, green, blue (sRGB) and opacity, each from 0 to 1.
pub(crate) type Rgba = (f32, f32, f32, f32);

pub(crate) fn rgba(colour: Option<Colour>) -> Option<Rgba> {
    colour.map(|[r, g, b, a]| (r, g, b, a))
}

/// A model: parts (B-reps) and their instances. Lengths are millimetres.
#[pyclass(frozen, module = "trimtess")]
pub(crate) struct Model {
    pub(crate) model: Arc<model::Model>,
    /// Memory of each stage at most, bytes; of `read`.
    pub(crate) max_memory: u64,
}

#[pymethods]
impl Model {
    /// Name: the file's without its ending, or what `read` was given.
    #[getter]
    fn name(&self) -> &str {
        &self.model.name
    }

    /// Parts.
    #[getter]
    fn parts(&self) -> Vec<Part> {
        let part = |index| Part { model: Arc::clone(&self.model), index };
        (0..self.model.parts.len()).map(part).collect()
    }

    /// Placed parts.
    #[getter]
    fn instances(&self) -> Vec<Instance> {
        self.model.instances.iter().map(|stated| Instance::of_scene(&stated.into())).collect()
    }

    /// Number of faces, each part once.
    #[getter]
    fn face_count(&self) -> usize {
        self.model.parts.iter().map(|part| part.faces.len()).sum()
    }

    /// Number of edges, each part once.
    #[getter]
    fn edge_count(&self) -> usize {
        self.model.parts.iter().map(|part| part.edges.len()).sum()
    }

    /// Length unit of the file, millimetres. Lengths of the model are already millimetres.
    #[getter]
    fn millimetres_per_unit(&self) -> f64 {
        self.model.millimetres_per_unit
    }

    /// What reading repaired, approximated or lost.
    #[getter]
    fn diagnostics(&self) -> Vec<Diagnostic> {
        diagnostic::list(&self.model.diagnostics)
    }

    /// Prepares the model for tessellation, once for all tolerances. The model stays as it is.
    ///
    /// Args:
    ///     max_memory: Memory at most, bytes; that of `read` if None.
    ///     max_patches: Bézier patches at most (default 16 million).
    ///     border_tolerance: Distance up to which borders of faces without edges, and edges of faces in open shells,
    ///         are sewn, as a fraction of the part's diagonal, from 0 to 1 (default 1e-6).
    ///     like: Another prepared model. Parts that both have are taken over from it, which is faster and the same.
    ///     keep_faces: Whether to keep the drafts of faces, and to take over those of `like` for faces of a changed
    ///     part.
    ///         Costs memory: a seventh of the prepared model.
    ///     workers: Threads at most; one per core if None or 0.
    ///     progress: Called as `progress("prepare", done, total)` with faces, on this thread.
    ///
    /// Raises:
    ///     LimitError: A limit is exceeded.
    #[pyo3(signature = (
        *, max_memory=None, max_patches=None, border_tolerance=None, like=None, keep_faces=false, workers=None,
        progress=None
    ))]
    #[allow(clippy::too_many_arguments, reason = "keywords of Python")]
    fn prepare(
        &self,
        py: Python<'_>,
        max_memory: Option<u64>,
        max_patches: Option<u64>,
        border_tolerance: Option<f64>,
        like: Option<PyRef<'_, Prepared>>,
        keep_faces: bool,
        workers: Option<usize>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Prepared> {
        let max_memory = max_memory.unwrap_or(self.max_memory);
        let limits = PrepareLimits::DEFAULT.with_bytes(max_memory);
        let limits = limits.with_patches(max_patches.unwrap_or(limits.patches));
        let border = border_tolerance.unwrap_or(PrepareOptions::DEFAULT.border_tolerance);
        if !(0.0..=1.0).contains(&border) {
            return Err(errors::out_of_range(py, "border_tolerance", border, "from 0 to 1"));
        }
        let options = PrepareOptions::DEFAULT.with_limits(limits).with_border_tolerance(border);
        let options = options.with_keep_faces(keep_faces);
        let like = like.map(|like| Arc::clone(&like.prepared)).unwrap_or_default();
        let job = Job { py, stage: "prepare", progress, workers: threads(py, workers)? };
        let (prepared, shells) = job
            .run(|control| {
                let prepared = like.update_on(&Rayon, &self.model, &options, control);
                prepared.map(|prepared| (prepared, self.model.parts.iter().map(Shells::of).collect()))
            })?
            .map_err(|failure| errors::unprepared(py, &failure))?;
        Ok(Prepared { prepared: Arc::new(prepared), shells: Arc::new(shells), max_memory })
    }

    fn __repr__(&self) -> String {
        let (parts, instances) = (self.model.parts.len(), self.model.instances.len());
        format!("<Model {:?}: {parts} parts, {instances} instances, {} faces>", self.model.name, self.face_count())
    }

    fn _repr_html_(&self) -> String {
        let facts = [
            ("parts", self.model.parts.len().to_string()),
            ("instances", self.model.instances.len().to_string()),
            ("faces", self.face_count().to_string()),
            ("edges", self.edge_count().to_string()),
            ("unit", format!("{} mm", self.model.millimetres_per_unit)),
            ("diagnostics", diagnostic::counts(&self.model.diagnostics)),
        ];
        diagnostic::html(&format!("Model {}", self.model.name), &facts)
    }
}

/// A B-rep in its own coordinates.
#[pyclass(frozen, module = "trimtess")]
pub(crate) struct Part {
    model: Arc<model::Model>,
    /// Index within the model.
    #[pyo3(get)]
    index: usize,
}

impl Part {
    fn part(&self) -> &model::Part {
        &self.model.parts[self.index]
    }
}

#[pymethods]
impl Part {
    /// Name, empty if none.
    #[getter]
    fn name(&self) -> &str {
        &self.part().name
    }

    /// Colour of faces that have none.
    #[getter]
    fn colour(&self) -> Option<Rgba> {
        rgba(self.part().colour)
    }

    /// Positions of the vertices, millimetres: an (n, 3) array of doubles.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::view(py, &self.model, &self.part().vertices)
    }

    /// Trimmed surfaces.
    #[getter]
    fn faces(&self) -> Vec<Face> {
        (0..).zip(&self.part().faces).map(|(index, face)| Face::of(index, face)).collect()
    }

    /// Edges.
    #[getter]
    fn edges(&self) -> Vec<Edge> {
        (0..).zip(&self.part().edges).map(|(index, edge)| Edge::of(index, edge)).collect()
    }

    fn __repr__(&self) -> String {
        let model::Part { name, faces, edges, .. } = self.part();
        format!("<Part {} {name:?}: {} faces, {} edges>", self.index, faces.len(), edges.len())
    }
}

/// A trimmed surface.
#[pyclass(frozen, get_all, module = "trimtess")]
pub(crate) struct Face {
    /// Index within the part.
    index: u32,
    /// Name, empty if none.
    name: String,
    /// Kind of surface, as "plane" or "B-spline"; "unreadable" if it could not be read.
    surface: &'static str,
    /// Own colour.
    colour: Option<Rgba>,
    /// Whether the outward normal is opposite to that of the surface.
    reversed: bool,
    /// Boundaries: each the edges along it, as (index within the part, whether it runs against the edge).
    loops: Vec<Vec<(u32, bool)>>,
    /// Number of the entity in the file.
    entity: Option<u64>,
}

impl Face {
    fn of(index: u32, face: &model::Face) -> Self {
        let unread = face.lost || face.refused.is_some();
        let edges = |of: &Loop| match of {
            Loop::Edges(coedges) => coedges.iter().map(|coedge| (coedge.edge.0, coedge.reversed)).collect(),
            Loop::Vertex(_) => Vec::new(),
        };
        Self {
            index,
            name: face.name.clone(),
            surface: if unread { "unreadable" } else { face.surface.kind().name() },
            colour: rgba(face.colour),
            reversed: face.reversed,
            loops: face.loops.iter().map(edges).collect(),
            entity: Some(face.entity).filter(|&entity| entity != 0),
        }
    }
}

#[pymethods]
impl Face {
    fn __repr__(&self) -> String {
        format!("<Face {} {:?}: {}, {} loops>", self.index, self.name, self.surface, self.loops.len())
    }
}

/// An edge: one curve in space, shared by the faces that meet there.
#[pyclass(frozen, get_all, module = "trimtess")]
pub(crate) struct Edge {
    /// Index within the part.
    index: u32,
    /// Kind of curve: "line", "circle", "conic", "spline" or "polyline".
    curve: &'static str,
    /// Index of the first vertex.
    start: u32,
    /// Index of the last vertex; equal to `start` for a closed edge.
    end: u32,
    /// Number of the entity in the file.
    entity: Option<u64>,
}

impl Edge {
    fn of(index: u32, edge: &model::Edge) -> Self {
        let curve = match edge.kind {
            model::CurveKind::Line => "line",
            model::CurveKind::Circle => "circle",
            model::CurveKind::Conic => "conic",
            model::CurveKind::Spline => "spline",
            model::CurveKind::Polyline => "polyline",
        };
        let entity = Some(edge.entity).filter(|&entity| entity != 0);
        Self { index, curve, start: edge.start.0, end: edge.end.0, entity }
    }
}

#[pymethods]
impl Edge {
    fn __repr__(&self) -> String {
        format!("<Edge {}: {}, vertex {} to {}>", self.index, self.curve, self.start, self.end)
    }
}

/// A placed part.
#[pyclass(frozen, module = "trimtess")]
pub(crate) struct Instance {
    /// Index of the part.
    #[pyo3(get)]
    part: u32,
    /// Name, empty if none.
    #[pyo3(get)]
    name: String,
    /// Overrides the colours of the part and its faces.
    #[pyo3(get)]
    colour: Option<Rgba>,
    /// Whether views draw it: `Session.set_instance`, `Session.set_part`.
    #[pyo3(get)]
    visible: bool,
    /// Its key in the session; None elsewhere.
    #[pyo3(get)]
    key: Option<u64>,
    assembly: Option<Arc<model::Assembly>>,
    transform: trimtess::glam::DAffine3,
}

impl Instance {
    /// As sinks see it.
    pub(crate) fn of_scene(instance: &trimtess::mesh::SceneInstance) -> Self {
        Self {
            part: instance.part.0,
            name: instance.name.to_string(),
            colour: rgba(instance.colour),
            visible: instance.visible,
            assembly: instance.assembly.clone(),
            transform: instance.transform,
            key: instance.key.map(trimtess::mesh::InstanceKey::to_bits),
        }
    }
}

#[pymethods]
impl Instance {
    /// Names of the assemblies that it stands in, the root first.
    #[getter]
    fn assemblies(&self) -> Vec<&str> {
        let mut names: Vec<&str> =
            self.assembly.iter().flat_map(|assembly| assembly.ancestors()).map(|assembly| &*assembly.name).collect();
        names.reverse();
        names
    }

    /// Part to world: a (4, 4) array of doubles that multiplies columns (x, y, z, 1), millimetres.
    #[getter]
    fn transform<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::matrix(py, &self.transform)
    }

    fn __repr__(&self) -> String {
        format!("<Instance {:?} of part {}>", self.name, self.part)
    }
}
