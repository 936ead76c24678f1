//! Measurements of a mesh: closedness, size, and deviation from the exact surfaces.

use pyo3::prelude::*;
use trimtess::audit::{self, DeviationReport};
use trimtess::mesh::{MeshFacts, Scene, SceneFacts, ScenePart};
use trimtess::prepare::Shells;

/// Whether a mesh is closed and consistent, and its size. Counts and measures are over all instances.
#[pyclass(frozen, get_all, module = "trimtess")]
pub(crate) struct Check {
    /// Whether every mesh edge is used as often one way as the other, and no triangle is malformed.
    closed: bool,
    /// What is wrong, one sentence per fault. Empty for a sound mesh; edges that are free in the file are no fault.
    faults: Vec<String>,
    /// Triangles.
    triangles: u64,
    /// Distinct vertex positions.
    vertices: u64,
    /// Mesh edges used by one triangle.
    open_edges: u64,
    /// Mesh edges whose directed uses do not cancel; open edges are among them. The next three add up to it.
    unbalanced_edges: u64,
    /// Unbalanced edges where the file's sheet ends.
    free_edges: u64,
    /// Unbalanced edges where the file's faces cannot be oriented consistently.
    not_orientable: u64,
    /// All other unbalanced edges: cracks, which no mesh should have.
    defects: u64,
    /// Length of the cracks, millimetres.
    defect_length: f64,
    /// Mesh edges used by more than two triangles.
    nonmanifold_edges: u64,
    /// Connected components.
    components: u64,
    /// Components of negative volume: voids, or pieces turned inside out.
    negative_components: u64,
    /// Area, mm².
    area: f64,
    /// Volume, mm³. Meaningful only if the mesh is closed.
    volume: f64,
    /// Faces without triangles.
    faces_without_triangles: u64,
    /// Each part, in its own coordinates.
    parts: Vec<Py<PartCheck>>,
}

/// Closedness of a part in the file and in the mesh, in the part's coordinates.
#[pyclass(frozen, get_all, module = "trimtess")]
pub(crate) struct PartCheck {
    /// Name of the part.
    name: String,
    /// Whether the part is closed in the file. Then its mesh is closed too.
    closed_in_file: bool,
    /// Edges of the file where a sheet ends.
    free_edges: usize,
    /// Edges of the file whose faces cannot be oriented consistently.
    not_orientable: usize,
    /// Whether the directed uses of every mesh edge cancel.
    closed_in_mesh: bool,
    /// Cracks: mesh edges whose uses do not cancel, where the file has no free edge.
    defects: u64,
    /// The part's faces along the cracks.
    defect_faces: Vec<u32>,
    /// Triangles.
    triangles: u64,
    /// Area, mm².
    area: f64,
    /// Volume, mm³. Meaningful only if the mesh is closed.
    volume: f64,
}

impl Check {
    pub(crate) fn of(py: Python<'_>, scene: &Scene, facts: &SceneFacts, shells: &[Shells]) -> PyResult<Self> {
        let total = &facts.total;
        let parts = scene.parts.iter().zip(&facts.parts);
        Ok(Self {
            closed: total.is_closed(),
            faults: audit::mesh_faults(scene, facts, shells),
            triangles: total.triangles,
            vertices: total.vertices,
            open_edges: total.open_edges,
            unbalanced_edges: total.unbalanced_edges,
            free_edges: total.free_edges,
            not_orientable: total.not_orientable,
            defects: total.defects,
            defect_length: total.defect_length,
            nonmanifold_edges: total.nonmanifold_edges,
            components: total.components,
            negative_components: total.negative_components,
            area: total.area,
            volume: total.volume,
            faces_without_triangles: facts.placed_faces_without_triangles,
            parts: parts.map(|(part, mesh)| Py::new(py, PartCheck::of(part, mesh))).collect::<PyResult<_>>()?,
        })
    }
}

impl PartCheck {
    fn of(part: &ScenePart, mesh: &MeshFacts) -> Self {
        Self {
            name: part.name.clone(),
            closed_in_file: part.closed,
            free_edges: part.free_edges.len(),
            not_orientable: part.not_orientable.len(),
            closed_in_mesh: mesh.unbalanced_edges == 0,
            defects: mesh.defects,
            defect_faces: mesh.defect_faces.iter().map(|face| face.0).collect(),
            triangles: mesh.triangles,
            area: mesh.area,
            volume: mesh.volume,
        }
    }
}

#[pymethods]
impl Check {
    fn __repr__(&self) -> String {
        let Self { triangles, open_edges, defects, .. } = self;
        let state = if self.closed { "closed" } else { "open" };
        format!("<Check: {state}, {triangles} triangles, {open_edges} open edges, {defects} cracks>")
    }
}

#[pymethods]
impl PartCheck {
    fn __repr__(&self) -> String {
        let state = |closed| if closed { "closed" } else { "open" };
        let (file, mesh) = (state(self.closed_in_file), state(self.closed_in_mesh));
        format!("<PartCheck {:?}: {file} in the file, {mesh} in the mesh, {} cracks>", self.name, self.defects)
    }
}

/// A distribution of distances, as fractions of the chord tolerance. All zero without samples.
#[pyclass(frozen, get_all, module = "trimtess")]
#[derive(Clone)]
pub(crate) struct Spread {
    /// Number of samples.
    samples: u64,
    /// Number of samples above 1.
    over: u64,
    /// Median.
    median: f64,
    /// 99th percentile.
    p99: f64,
    /// 99.9th percentile.
    p999: f64,
    /// Maximum.
    worst: f64,
}

impl From<&audit::Spread> for Spread {
    fn from(spread: &audit::Spread) -> Self {
        let audit::Spread { samples, over, median, p99, p999, worst } = *spread;
        Self { samples, over, median, p99, p999, worst }
    }
}

#[pymethods]
impl Spread {
    fn __repr__(&self) -> String {
        let Self { samples, median, p999, worst, .. } = self;
        format!("<Spread: {samples} samples, median {median:.4}, 99.9 % {p999:.4}, worst {worst:.4}>")
    }
}

/// Deviation of a mesh from the exact surfaces and edges of the file, by dense sampling.
#[pyclass(frozen, module = "trimtess")]
pub(crate) struct Deviation(pub(crate) DeviationReport);

#[pymethods]
impl Deviation {
    /// The chord tolerance that all ratios refer to, millimetres.
    #[getter]
    fn chord(&self) -> f64 {
        self.0.chord
    }

    /// Distances from triangles to surfaces, minus the gaps that the file leaves between surface, edges and vertices.
    #[getter]
    fn surfaces(&self) -> Spread {
        Spread::from(&self.0.beyond_gap)
    }

    /// Distances from triangles to surfaces, gaps of the file included.
    #[getter]
    fn raw(&self) -> Spread {
        Spread::from(&self.0.raw)
    }

    /// Distances between the polylines of edges and their curves.
    #[getter]
    fn edges(&self) -> Spread {
        Spread::from(&self.0.edges)
    }

    /// `surfaces` by kind of surface.
    #[getter]
    fn kinds(&self) -> std::collections::BTreeMap<&'static str, Spread> {
        self.0.kinds.iter().map(|(kind, spread)| (kind.name(), Spread::from(spread))).collect()
    }

    /// Number of faces with a sample over the tolerance.
    #[getter]
    fn faces_over(&self) -> usize {
        self.0.faces_over
    }

    /// Largest distance of surfaces and edges, millimetres.
    #[getter]
    fn worst_mm(&self) -> f64 {
        self.0.chord * self.0.beyond_gap.worst.max(self.0.edges.worst)
    }

    /// Violations of the tolerance, one sentence each: more than one sample in a thousand over it, or an edge by 5 %.
    #[getter]
    fn faults(&self) -> Vec<String> {
        self.0.faults().collect()
    }

    /// The report as a table.
    fn __str__(&self) -> String {
        self.0.to_string()
    }

    fn __repr__(&self) -> String {
        let DeviationReport { chord, beyond_gap, edges, .. } = &self.0;
        let (worst, p999, edges) = (beyond_gap.worst, beyond_gap.p999, edges.worst);
        format!("<Deviation: worst {worst:.4} of {chord:.4e} mm, 99.9 % {p999:.4}, edges {edges:.4}>")
    }
}
