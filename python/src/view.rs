//! Cameras with a screen-space error, from Python.

use crate::errors;
use pyo3::prelude::*;
use trimtess::glam::{DMat4, DVec3};
use trimtess::view::{self, Camera, Projection};

/// A camera, the size of its picture, and how exactly the picture shows the model.
#[pyclass(frozen, module = "trimtess")]
#[derive(Clone, Copy)]
pub(crate) struct View(pub(crate) view::View);

impl View {
    /// Checks a view. The `RangeError` says what is wrong with it.
    pub(crate) fn checked(py: Python<'_>, view: view::View) -> PyResult<Self> {
        view.check().map_err(|why| errors::unfit(py, "the view", &why, "one that a camera can have"))?;
        Ok(Self(view))
    }
}

#[pymethods]
impl View {
    /// A camera at `eye` that looks at `target`.
    ///
    /// Args:
    ///     eye: Position of the camera, millimetres.
    ///     target: Point in the middle of the picture.
    ///     up: Direction that points up in the picture.
    ///     fov: Full vertical field of view, degrees. Not used if `height` is given.
    ///     height: Height of what an orthographic camera sees, millimetres; the camera is a perspective one if None.
    ///     near: Depth of the near plane of a perspective camera, millimetres.
    ///     size: Width and height of the picture, pixels.
    ///     deviation_px: Largest screen-space error, pixels.
    ///     size_px: Longest diagonal of a lattice cell on the screen, pixels; no limit if None.
    ///     angle: Largest angle by which the normal turns across a lattice cell, degrees.
    ///
    /// Raises:
    ///     RangeError: There is no such camera: the picture has no pixels, `eye` is `target`, `up` points along the
    ///     line
    ///         of sight, or a number is not finite or not above 0.
    #[new]
    #[pyo3(signature = (eye, target, *, up=[0.0, 0.0, 1.0], fov=30.0, height=None, near=0.0, size=(1280, 960),
                        deviation_px=0.5, size_px=None, angle=30.0))]
    #[allow(clippy::too_many_arguments, reason = "keywords of Python")]
    fn new(
        py: Python<'_>,
        eye: [f64; 3],
        target: [f64; 3],
        up: [f64; 3],
        fov: f64,
        height: Option<f64>,
        near: f64,
        size: (u32, u32),
        deviation_px: f64,
        size_px: Option<f64>,
        angle: f64,
    ) -> PyResult<Self> {
        let projection = match height {
            Some(height) => Projection::Orthographic { height },
            None => Projection::Perspective { fov_y: fov.to_radians(), near },
        };
        let [eye, target, up] = [eye, target, up].map(DVec3::from);
        let camera = Camera::looking_at(eye, target, up, projection);
        Self::checked(py, view::View { camera, size, deviation_px, size_px, angle: angle.to_radians() })
    }

    /// The camera of an engine.
    ///
    /// Args:
    ///     matrix: Rows of the 4 x 4 matrix, projection times view: `matrix @ (x, y, z, 1)` takes millimetres in the
    ///         world to clip space, where x points right, y up and w forwards. The row of z is not read.
    ///     size: Width and height of the engine's picture, pixels.
    ///     near: Depth of the near plane of a perspective camera, millimetres.
    ///     deviation_px: Largest screen-space error, pixels.
    ///     size_px: Longest diagonal of a lattice cell on the screen, pixels; no limit if None.
    ///     angle: Largest angle by which the normal turns across a lattice cell, degrees.
    ///
    /// Returns:
    ///     The view. The middle of the engine's picture may be off the axis, as for an eye of a headset: the view's
    ///     picture is one around it, about the axis, with pixels of the same size.
    ///
    /// Raises:
    ///     RangeError: The matrix is not that of a camera, or a number is out of range.
    #[staticmethod]
    #[pyo3(signature = (matrix, size, *, near=0.0, deviation_px=0.5, size_px=None, angle=30.0))]
    fn from_matrix(
        py: Python<'_>,
        matrix: [[f64; 4]; 4],
        size: (u32, u32),
        near: f64,
        deviation_px: f64,
        size_px: Option<f64>,
        angle: f64,
    ) -> PyResult<Self> {
        let matrix = DMat4::from_cols_array_2d(&matrix).transpose();
        let found = view::View::from_matrix(matrix, size);
        let found = found.map_err(|why| errors::unfit(py, "the view", &why, "one that a camera can have"))?;
        let mut camera = found.camera;
        if let Projection::Perspective { near: depth, .. } = &mut camera.projection {
            *depth = near;
        }
        Self::checked(py, view::View { camera, deviation_px, size_px, angle: angle.to_radians(), ..found })
    }

    /// Position of the camera, millimetres.
    #[getter]
    fn eye(&self) -> (f64, f64, f64) {
        self.0.camera.eye.into()
    }

    /// The point that the camera looks at.
    #[getter]
    fn target(&self) -> (f64, f64, f64) {
        self.0.camera.target().into()
    }

    /// Direction that points up in the picture.
    #[getter]
    fn up(&self) -> (f64, f64, f64) {
        self.0.camera.up.into()
    }

    /// Full vertical field of view, degrees; None for an orthographic camera.
    #[getter]
    fn fov(&self) -> Option<f64> {
        match self.0.camera.projection {
            Projection::Perspective { fov_y, .. } => Some(fov_y.to_degrees()),
            Projection::Orthographic { .. } => None,
        }
    }

    /// Height of what an orthographic camera sees, millimetres; None for a perspective one.
    #[getter]
    fn height(&self) -> Option<f64> {
        match self.0.camera.projection {
            Projection::Perspective { .. } => None,
            Projection::Orthographic { height } => Some(height),
        }
    }

    /// Width and height of the picture, pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        self.0.size
    }

    /// Largest screen-space error, pixels.
    #[getter]
    fn deviation_px(&self) -> f64 {
        self.0.deviation_px
    }

    fn __repr__(&self) -> String {
        let (view::View { size: (width, height), deviation_px, .. }, camera) = (self.0, self.0.camera);
        format!("<View from {} at {}: {width} x {height}, {deviation_px} px>", camera.eye, camera.target())
    }
}
