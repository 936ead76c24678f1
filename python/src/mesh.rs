//! A finished mesh: arrays of its parts, instances, measurements, files.

use crate::array;
use crate::check::{Check, Deviation};
use crate::diagnostic::{self, Diagnostic};
use crate::errors;
use crate::flat::Flat;
use crate::job::Job;
use crate::model::{Instance, Rgba, rgba};
use crate::save::{How, Saved, save};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};
use trimtess::audit;
use trimtess::frame::Tolerance;
use trimtess::mesh::{PackedFrame, PartMesh, ScenePart, check_scene};
use trimtess::model::{self, PartId};
use trimtess::prepare::{Prepared, Shells};

/// A mesh within a tolerance.
#[pyclass(frozen, module = "trimtess")]
pub(crate) struct Mesh {
    pub(crate) frame: Arc<PackedFrame>,
    pub(crate) prepared: Arc<Prepared>,
    pub(crate) shells: Arc<Vec<Shells>>,
    pub(crate) diagnostics: Arc<Vec<model::Diagnostic>>,
    /// Why the mesh is coarser than asked; None if it is not.
    #[pyo3(get)]
    pub(crate) shortfall: Option<String>,
    pub(crate) tolerance: Tolerance,
    /// Made when first asked for.
    pub(crate) flat: OnceLock<Flat>,
}

impl Mesh {
    fn flat(&self, py: Python<'_>) -> PyResult<&Flat> {
        match self.flat.get() {
            Some(flat) => Ok(flat),
            None => {
                let flat = Flat::of(py, &self.frame)?;
                Ok(self.flat.get_or_init(|| flat))
            }
        }
    }

    fn placed(&self, count: impl Fn(&PartMesh) -> usize) -> usize {
        let parts = self.frame.scene.instances.iter().filter_map(|i| self.frame.parts.get(i.part.index()));
        parts.map(count).sum()
    }
}

#[pymethods]
impl Mesh {
    /// Name of the model.
    #[getter]
    fn name(&self) -> &str {
        &self.frame.scene.name
    }

    /// The mesh of each part of the model, in the part's coordinates.
    #[getter]
    fn parts(&self) -> Vec<MeshPart> {
        (0..self.frame.parts.len()).map(|index| MeshPart { frame: Arc::clone(&self.frame), index }).collect()
    }

    /// Placed parts.
    #[getter]
    fn instances(&self) -> Vec<Instance> {
        self.frame.scene.instances.iter().map(Instance::of_scene).collect()
    }

    /// All instances as one mesh in world coordinates. Made once; the memory of the part where there is one instance at
    /// the identity.
    fn flattened(&self, py: Python<'_>) -> PyResult<Flat> {
        self.flat(py).cloned()
    }

    /// As `flattened().positions`.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.flat(py)?.positions(py)
    }

    /// As `flattened().normals`.
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.flat(py)?.normals(py)
    }

    /// As `flattened().uv`.
    #[getter]
    fn uv<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.flat(py)?.uv(py)
    }

    /// As `flattened().triangles`.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.flat(py)?.triangles(py)
    }

    /// As `flattened().face_ids`.
    #[getter]
    fn face_ids<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.flat(py)?.face_ids(py)
    }

    /// As `flattened().edges`.
    #[getter]
    fn edges<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        self.flat(py)?.edges(py)
    }

    /// Number of triangles over all instances.
    #[getter]
    fn triangle_count(&self) -> usize {
        self.placed(|part| part.triangles.len())
    }

    /// Number of vertices over all instances.
    #[getter]
    fn vertex_count(&self) -> usize {
        self.placed(|part| part.positions.len())
    }

    /// Number of faces over all instances.
    #[getter]
    fn face_count(&self) -> usize {
        let scene = &self.frame.scene;
        let parts = scene.instances.iter().filter_map(|i| scene.parts.get(i.part.index()));
        parts.map(|part| part.face_colours.len()).sum()
    }

    /// Chord tolerance, millimetres.
    #[getter]
    fn chord(&self) -> f64 {
        self.tolerance.chord
    }

    /// Angle tolerance, degrees.
    #[getter]
    fn angle(&self) -> f64 {
        self.tolerance.angle.to_degrees()
    }

    /// What reading, preparing and tessellating repaired, approximated or lost. Each part counts once.
    #[getter]
    fn diagnostics(&self) -> Vec<Diagnostic> {
        diagnostic::list(&self.diagnostics)
    }

    /// What the exit status of the program would be: 0, or 3 if there are no faces or a diagnostic is a fault.
    #[getter]
    fn status(&self) -> u8 {
        let faulty = self.face_count() == 0 || self.diagnostics.iter().any(model::Diagnostic::is_fault);
        if faulty { 3 } else { 0 }
    }

    /// Writes a file in the format of its ending: glb, ply, obj or stl. It appears whole or not at all, and equals what
    /// the program writes.
    ///
    /// Args:
    ///     path: The file. A replaced file keeps its mode, links are followed.
    ///     recenter: Whether to move the centre of the model to the origin. Formats in single precision (GLB, STL) lose
    ///         digits far from it.
    ///     glb: What a GLB asks of its readers, so that it is smaller: "instanced" (EXT_mesh_gpu_instancing),
    ///     "quantized"
    ///         (KHR_mesh_quantization), "compressed" (EXT_meshopt_compression).
    ///     levels: Coarser meshes of the same model, finest first: levels of detail of a GLB (MSFT_lod), with the share
    ///     of
    ///         the screen at which the chord tolerance of each is a pixel.
    ///     progress: Called with "write", what is done and what there is to do, on the caller's thread. If it raises,
    ///     no
    ///         file is left.
    ///
    /// Raises:
    ///     ValueError: `glb` or `levels` are for another format, `glb` names something else, or `levels` are meshes of
    ///         another model or not coarser one by one.
    ///     FormatError: The ending is unknown.
    ///     RoundingError: The format's numbers would move a vertex by more than a tenth of the chord tolerance.
    ///     SaveError: The file cannot be written.
    #[pyo3(signature = (path, *, recenter=false, glb=Vec::new(), levels=Vec::new(), progress=None))]
    fn save<'py>(
        &self,
        py: Python<'py>,
        path: PathBuf,
        recenter: bool,
        glb: Vec<String>,
        levels: Vec<PyRef<'_, Self>>,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Saved> {
        let job = Job { py, stage: "write", progress, workers: 1 };
        let status = levels.iter().map(|mesh| mesh.status()).fold(self.status(), u8::max);
        let levels = levels.iter().map(|mesh| (Arc::clone(&mesh.frame), mesh.tolerance.chord)).collect();
        let how = How { chord: self.tolerance.chord, recenter, glb: &glb, levels };
        save(&job, (&self.frame, &self.prepared), &path, how, status)
    }

    /// Checks whether the mesh is closed and consistent, and measures area and volume. About 0.4 µs per triangle.
    fn check(&self, py: Python<'_>) -> PyResult<Check> {
        let job = Job { py, stage: "check", progress: None, workers: 1 };
        let facts = job.run(|_| check_scene(&*self.frame))?;
        Check::of(py, &self.frame.scene, &facts, &self.shells)
    }

    /// Measures the distance to the exact surfaces and edges by dense sampling. About a second.
    ///
    /// Args:
    ///     chord: Chord tolerance to compare with, millimetres; that of the mesh if None.
    #[pyo3(signature = (*, chord=None))]
    fn deviation(&self, py: Python<'_>, chord: Option<f64>) -> PyResult<Deviation> {
        let chord = errors::positive(py, "chord", chord)?.unwrap_or(self.tolerance.chord);
        let job = Job { py, stage: "deviation", progress: None, workers: 1 };
        job.run(|_| audit::deviation(&self.prepared, &*self.frame, chord)).map(Deviation)
    }

    fn __repr__(&self) -> String {
        let (triangles, parts) = (self.triangle_count(), self.frame.parts.len());
        let (instances, status) = (self.frame.scene.instances.len(), self.status());
        let name = &self.frame.scene.name;
        format!("<Mesh {name:?}: {triangles} triangles, {parts} parts, {instances} instances, status {status}>")
    }

    fn _repr_html_(&self) -> String {
        let facts = [
            ("triangles", self.triangle_count().to_string()),
            ("vertices", self.vertex_count().to_string()),
            ("parts", self.frame.parts.len().to_string()),
            ("instances", self.frame.scene.instances.len().to_string()),
            ("faces", self.face_count().to_string()),
            ("chord", format!("{:.4e} mm", self.tolerance.chord)),
            ("angle", format!("{:.2}°", self.angle())),
            ("diagnostics", diagnostic::counts(&self.diagnostics)),
            ("status", self.status().to_string()),
        ];
        diagnostic::html(&format!("Mesh {}", self.frame.scene.name), &facts)
    }

    /// A picture of the model, where there is an adapter.
    #[cfg(feature = "wgpu")]
    fn _repr_png_(&self, py: Python<'_>) -> PyResult<Option<Vec<u8>>> {
        crate::picture::png(py, &self.prepared, trimtess::frame::PlanLimits::DEFAULT)
    }
}

/// The mesh of one part, in the part's coordinates.
#[pyclass(frozen, module = "trimtess")]
pub(crate) struct MeshPart {
    frame: Arc<PackedFrame>,
    /// Index of the part.
    #[pyo3(get)]
    index: usize,
}

impl MeshPart {
    fn mesh(&self) -> &PartMesh {
        &self.frame.parts[self.index]
    }

    fn part(&self) -> &ScenePart {
        &self.frame.scene.parts[self.index]
    }
}

#[pymethods]
impl MeshPart {
    /// Name of the part, empty if none.
    #[getter]
    fn name(&self) -> &str {
        &self.part().name
    }

    /// Whether the part is closed in the file, and so in the mesh.
    #[getter]
    fn closed(&self) -> bool {
        self.part().closed
    }

    /// Colour of each face; None where the file gives none.
    #[getter]
    fn face_colours(&self) -> Vec<Option<Rgba>> {
        self.part().face_colours.iter().copied().map(rgba).collect()
    }

    /// Positions, millimetres: an (n, 3) array of doubles.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::view(py, &self.frame, &self.mesh().positions)
    }

    /// Unit normals that point outwards: an (n, 3) array of floats.
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::view(py, &self.frame, &self.mesh().normals)
    }

    /// Parameters of each vertex on the surface of its face: an (n, 2) array of floats.
    #[getter]
    fn uv<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::view(py, &self.frame, &self.mesh().uvs)
    }

    /// Indices into `positions`, counter-clockwise seen from outside: an (m, 3) array of 32-bit unsigned integers.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::view(py, &self.frame, &self.mesh().triangles)
    }

    /// Face of each triangle, as index within the part: an (m,) array of 32-bit unsigned integers.
    #[getter]
    fn face_ids<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array::view(py, &self.frame, &self.mesh().face_ids)
    }

    /// Polylines of the edges: a list of (k, 3) arrays of doubles, millimetres. `edge_ids` says of which edges.
    #[getter]
    fn edges<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let lines = self.frame.edge_lines_of(PartId::new(self.index));
        lines.iter().map(|line| array::view(py, &self.frame, &line.points)).collect()
    }

    /// Index within the part of the edge of each polyline of `edges`.
    #[getter]
    fn edge_ids(&self) -> Vec<u32> {
        self.frame.edge_lines_of(PartId::new(self.index)).iter().map(|line| line.edge.0).collect()
    }

    fn __repr__(&self) -> String {
        let PartMesh { triangles, positions, .. } = self.mesh();
        let (triangles, vertices) = (triangles.len(), positions.len());
        format!("<MeshPart {} {:?}: {triangles} triangles, {vertices} vertices>", self.index, self.part().name)
    }
}
