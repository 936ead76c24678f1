//! All instances of a mesh in one set of arrays, in world coordinates.

use crate::array;
use crate::errors;
use crate::job::Job;
use pyo3::prelude::*;
use std::sync::Arc;
use trimtess::glam::DAffine3;
use trimtess::mesh::{FlatMesh, PackedFrame};
use trimtess::model::PartId;

/// Where the arrays are.
#[derive(Clone)]
enum Store {
    /// In arrays made for this purpose.
    Own(Arc<FlatMesh>),
    /// In those of the only part, which is placed where it is stated.
    Part(Arc<PackedFrame>, PartId),
}

/// All instances as one mesh in world coordinates, millimetres.
#[pyclass(frozen, module = "trimtess")]
#[derive(Clone)]
pub(crate) struct Flat(Store);

/// A view of the list of this name, wherever it is.
macro_rules! column {
    ($self:ident, $py:ident, $field:ident) => {
        match &$self.0 {
            Store::Own(flat) => array::view($py, flat, &flat.$field),
            Store::Part(frame, part) => array::view($py, frame, &frame.parts[part.index()].$field),
        }
    };
}

impl Flat {
    /// Places all instances; shares the memory of a single one that is placed where it is stated.
    pub(crate) fn of(py: Python<'_>, frame: &Arc<PackedFrame>) -> PyResult<Self> {
        if let [only] = &*frame.scene.instances
            && only.transform == DAffine3::IDENTITY
            && only.part.index() < frame.parts.len()
        {
            return Ok(Self(Store::Part(Arc::clone(frame), only.part)));
        }
        let job = Job { py, stage: "flatten", progress: None, workers: 1 };
        let flat = job.run(|_| FlatMesh::of(frame))?;
        let flat = flat.map_err(|failure| errors::too_many(py, &failure))?;
        Ok(Self(Store::Own(Arc::new(flat))))
    }
}

#[pymethods]
impl Flat {
    /// Positions, millimetres: an (n, 3) array of doubles.
    #[getter]
    pub(crate) fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        column!(self, py, positions)
    }

    /// Unit normals that point outwards: an (n, 3) array of floats.
    #[getter]
    pub(crate) fn normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        column!(self, py, normals)
    }

    /// Parameters of each vertex on the surface of its face: an (n, 2) array of floats.
    #[getter]
    pub(crate) fn uv<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        column!(self, py, uvs)
    }

    /// Indices into `positions`, counter-clockwise seen from outside: an (m, 3) array of 32-bit unsigned integers.
    #[getter]
    pub(crate) fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        column!(self, py, triangles)
    }

    /// Face of each triangle, numbered across all instances: an (m,) array of 32-bit unsigned integers.
    #[getter]
    pub(crate) fn face_ids<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        column!(self, py, face_ids)
    }

    /// Polylines of the edges: a list of (k, 3) arrays of doubles, millimetres.
    #[getter]
    pub(crate) fn edges<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        match &self.0 {
            Store::Part(frame, part) => {
                frame.edge_lines_of(*part).iter().map(|line| array::view(py, frame, &line.points)).collect()
            }
            Store::Own(flat) => {
                let ends = flat.edge_starts.windows(2);
                ends.map(|ends| array::view(py, flat, &flat.edge_points[ends[0] as usize..ends[1] as usize])).collect()
            }
        }
    }

    fn __repr__(&self) -> String {
        let (vertices, triangles) = match &self.0 {
            Store::Own(flat) => (flat.positions.len(), flat.triangles.len()),
            Store::Part(frame, part) => {
                let part = &frame.parts[part.index()];
                (part.positions.len(), part.triangles.len())
            }
        };
        format!("<Flat: {triangles} triangles, {vertices} vertices>")
    }
}
