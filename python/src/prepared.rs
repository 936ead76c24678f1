//! A prepared model -> meshes and pictures.

use crate::diagnostic::{self, Diagnostic};
use crate::errors;
use crate::job::{Job, threads};
use crate::mesh::Mesh;
use crate::session::Session;
use crate::view::View;
use pyo3::prelude::*;
use std::sync::{Arc, OnceLock};
use std::time::Duration;
use trimtess::control::Rayon;
use trimtess::frame::{PlanLimits, PlannerOptions, Shortfall, Tolerance, plan_on};
use trimtess::mesh::PackedFrame;
use trimtess::parallel::{SessionOptions, coarse_points, tessellate_on};
use trimtess::prepare::{self, Shells};
use trimtess::view::{self, ViewPoint};

/// A model that is ready for tessellation.
#[pyclass(frozen, module = "trimtess")]
pub(crate) struct Prepared {
    pub(crate) prepared: Arc<prepare::Prepared>,
    /// Shells of each part as the file states them.
    pub(crate) shells: Arc<Vec<Shells>>,
    /// Memory of each stage at most, bytes.
    pub(crate) max_memory: u64,
}

impl Prepared {
    /// Limits of meshes.
    pub(crate) fn limits(&self, max_memory: Option<u64>) -> PlanLimits {
        PlanLimits::DEFAULT.with_bytes(max_memory.unwrap_or(self.max_memory))
    }
}

#[pymethods]
impl Prepared {
    /// Name of the model.
    #[getter]
    fn name(&self) -> &str {
        &self.prepared.scene.name
    }

    /// Lower and upper corner of the box around the trimmed, placed model, millimetres; None if it is empty.
    #[getter]
    #[allow(clippy::type_complexity, reason = "two corners")]
    fn bounds(&self) -> Option<((f64, f64, f64), (f64, f64, f64))> {
        self.prepared.bounds.map(|[low, high]| (low.into(), high.into()))
    }

    /// Diagonal of that box, millimetres.
    #[getter]
    fn diagonal(&self) -> f64 {
        self.prepared.diagonal
    }

    /// What reading and preparing repaired, approximated or lost.
    #[getter]
    fn diagnostics(&self) -> Vec<Diagnostic> {
        diagnostic::list(&self.prepared.diagnostics)
    }

    /// Tessellates the model within a tolerance. The mesh is the same for any number of workers.
    ///
    /// Args:
    ///     chord: Largest distance between triangles and surface, millimetres.
    ///     chord_rel: The same as a fraction of the diagonal (default 1e-3). Not with `chord`.
    ///     angle: Largest angle by which the normal turns across a lattice cell, degrees (default 20).
    ///     max_edge: Longest diagonal of a lattice cell and segment of an edge, millimetres; no limit if None.
    ///     max_memory: Memory at most, bytes; that of `prepare` and `read` if None.
    ///     max_triangles: Triangles at most, as counted before meshing: two per lattice cell and two per point of an
    ///         edge, each part once; meshes have about half as many (default 64 million).
    ///     max_tile_triangles: Triangles of a piece of a face at most (default 8 million).
    ///     coarsen: Whether to make a coarser mesh where a limit is exceeded, and say so in `Mesh.shortfall`.
    ///     workers: Threads at most; one per core if None or 0.
    ///     progress: Called as `progress("tessellate", done, total)` with pieces of faces, on this thread.
    ///
    /// Raises:
    ///     RangeError: A tolerance is not a finite number above 0 or too small for the model, or `workers` is too
    ///     large. LimitError: A limit is exceeded.
    #[pyo3(signature = (*, chord=None, chord_rel=None, angle=None, max_edge=None, max_memory=None, max_triangles=None,
                        max_tile_triangles=None, coarsen=false, workers=None, progress=None))]
    #[allow(clippy::too_many_arguments, reason = "keywords of Python")]
    fn tessellate(
        &self,
        py: Python<'_>,
        chord: Option<f64>,
        chord_rel: Option<f64>,
        angle: Option<f64>,
        max_edge: Option<f64>,
        max_memory: Option<u64>,
        max_triangles: Option<u64>,
        max_tile_triangles: Option<u64>,
        coarsen: bool,
        workers: Option<usize>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Mesh> {
        let chord = errors::positive(py, "chord", chord)?;
        let chord_rel = errors::positive(py, "chord_rel", chord_rel)?;
        let angle = errors::positive(py, "angle", angle)?.unwrap_or(Tolerance::DEFAULT_ANGLE_DEGREES);
        let max_edge = errors::positive(py, "max_edge", max_edge)?;
        if let (Some(chord), Some(_)) = (chord, chord_rel) {
            return Err(errors::out_of_range(py, "chord", chord, "None, as chord_rel is given"));
        }
        let fraction = chord_rel.unwrap_or(Tolerance::DEFAULT_CHORD_REL);
        let chord = chord.unwrap_or(Tolerance::relative(fraction, self.prepared.diagonal).chord);
        let tolerance = Tolerance { chord, angle: angle.to_radians(), max_edge };
        let limits = self.limits(max_memory);
        let limits = limits
            .with_triangles(max_triangles.unwrap_or(limits.triangles))
            .with_triangles_per_tile(max_tile_triangles.unwrap_or(limits.triangles_per_tile));
        let workers = threads(py, workers)?;
        let job = Job { py, stage: "tessellate", progress, workers };
        let made = job.run(|control| -> Result<_, Shortfall> {
            let plan = match plan_on(&Rayon, &self.prepared, &tolerance, &limits, control) {
                Ok(plan) => plan,
                Err(cancelled) => return Ok(Err(cancelled.into())),
            };
            let plan = Arc::new(if coarsen { plan } else { plan.require_full()? });
            let mut frame = PackedFrame::default();
            let made = tessellate_on(&Rayon, &self.prepared, &plan, true, control, &mut frame);
            Ok(made.map(|report| {
                let diagnostics = report.diagnostics(&frame, &self.prepared);
                (frame, diagnostics, plan.shortfall.as_ref().map(ToString::to_string))
            }))
        })?;
        let hint = |limit: &str| (format!("use a larger tolerance, a larger {limit}, or coarsen=True"), true);
        let made = made.map_err(|short| errors::short(py, &short, hint))?;
        let (frame, diagnostics, shortfall) = made.map_err(|failure| errors::unmade(py, &failure))?;
        Ok(Mesh {
            frame: Arc::new(frame),
            prepared: Arc::clone(&self.prepared),
            shells: Arc::clone(&self.shells),
            diagnostics: Arc::new(diagnostics),
            shortfall,
            tolerance,
            flat: OnceLock::new(),
        })
    }

    /// Starts a session: frames of views that follow a moving camera. Its threads end with it, so a process must not
    /// fork while one lives.
    ///
    /// Args:
    ///     workers: Threads; one per core if None or 0.
    ///     edges: Whether frames have the polylines of edges.
    ///     levels: Levels of detail of a part with several instances at most.
    ///     budget_ms: Time for the tiles of a frame, in milliseconds of one worker; what exceeds it waits for later
    ///     frames.
    ///         No limit if None.
    ///     max_memory: Memory of a frame at most, bytes; that of `prepare` and `read` if None.
    ///     resident_bytes: Bytes of tiles that are kept, as `tile` arrays have them. Beyond it, tiles that no view
    ///     draws are
    ///         evicted, the oldest first, in steps of 64 frames. No limit if None.
    ///
    /// Raises:
    ///     RangeError: The budget is not a finite number above 0, or `workers` is too large.
    #[pyo3(signature = (*, workers=None, edges=false, levels=4, budget_ms=None, max_memory=None, resident_bytes=None))]
    #[allow(clippy::too_many_arguments, reason = "keywords of Python")]
    fn session(
        &self,
        py: Python<'_>,
        workers: Option<usize>,
        edges: bool,
        levels: usize,
        budget_ms: Option<f64>,
        max_memory: Option<u64>,
        resident_bytes: Option<u64>,
    ) -> PyResult<Session> {
        let budget = errors::positive(py, "budget_ms", budget_ms)?;
        let budget = budget.map(|ms| Duration::try_from_secs_f64(1e-3 * ms).unwrap_or(Duration::MAX));
        let planner = PlannerOptions::DEFAULT.with_limits(self.limits(max_memory)).with_budget(budget);
        let options = SessionOptions::DEFAULT.with_threads(threads(py, workers)?).with_edge_lines(edges);
        let options = options.with_levels(levels).with_planner(planner).with_resident_bytes(resident_bytes);
        Session::start(py, &self.prepared, &options)
    }

    /// A view in which the whole model fits.
    ///
    /// Args:
    ///     view: As that of `render`.
    ///     size: Width and height of the picture, pixels.
    ///     orthographic: Whether the camera is orthographic.
    ///     deviation_px: Largest screen-space error, pixels.
    ///     size_px: Longest diagonal of a lattice cell on the screen, pixels; no limit if None.
    ///
    /// Raises:
    ///     RangeError: An argument is out of range.
    #[pyo3(signature = (view="iso", *, size=(1280, 960), orthographic=false, deviation_px=0.5, size_px=None))]
    fn view(
        &self,
        py: Python<'_>,
        view: &str,
        size: (u32, u32),
        orthographic: bool,
        deviation_px: f64,
        size_px: Option<f64>,
    ) -> PyResult<View> {
        let from: ViewPoint = view.parse().map_err(|e| errors::out_of_range(py, "view", view, &format!("{e}")))?;
        let job = Job { py, stage: "view", progress: None, workers: 0 };
        let points = job.run(|control| coarse_points(&Rayon, &self.prepared, &self.limits(None), control))?;
        let points = points.map_err(|failure| errors::unmade(py, &failure))?;
        let aspect = f64::from(size.0) / f64::from(size.1.max(1));
        let camera = from.fit_as(orthographic, points, aspect);
        View::checked(py, view::View { camera, size, deviation_px, size_px, angle: view::View::ANGLE })
    }

    /// Draws the model within a screen-space error, as a (height, width, 4) array of bytes: red, green, blue (sRGB) and
    /// opacity, from the top left.
    ///
    /// Args:
    ///     width: Pixels, 1 to 32768 as far as the adapter allows.
    ///     height: Pixels, as `width`.
    ///     view: "iso", "front", "back", "left", "right", "top", "bottom", or "yaw,pitch,distance" in degrees and
    ///         multiples of the distance at which the model just fits.
    ///     deviation_px: Largest screen-space error, pixels.
    ///     size_px: Longest diagonal of a lattice cell on the screen, pixels; no limit if None.
    ///     orthographic: Whether the camera is orthographic.
    ///     color_by: "model", "part", "face", "tile", "worker" or "rate".
    ///     wireframe: Whether to draw the edges of triangles.
    ///     lattice: Whether to draw the lattice lines of tiles.
    ///     edges: Whether to draw the edges of the model.
    ///     backfaces: Whether to draw back-facing surfaces in magenta.
    ///     workers: Threads at most; one per core if None or 0.
    ///     progress: Called as `progress("render", done, total)` with pieces of faces, on this thread.
    ///
    /// Raises:
    ///     NoAdapterError: There is no graphics adapter.
    ///     RenderError: The picture is larger than the adapter allows, or the device fails.
    ///     LimitError: The picture needs more triangles or memory than the limits allow.
    ///     RangeError: An argument is out of range.
    #[cfg(feature = "wgpu")]
    #[pyo3(signature = (width=1280, height=960, *, view="iso", deviation_px=0.5, size_px=None, orthographic=false,
                        color_by="model", wireframe=false, lattice=false, edges=false, backfaces=false, workers=None,
                        progress=None))]
    #[allow(clippy::too_many_arguments, clippy::fn_params_excessive_bools, reason = "keywords of Python")]
    fn render<'py>(
        &self,
        py: Python<'py>,
        width: u32,
        height: u32,
        view: &str,
        deviation_px: f64,
        size_px: Option<f64>,
        orthographic: bool,
        color_by: &str,
        wireframe: bool,
        lattice: bool,
        edges: bool,
        backfaces: bool,
        workers: Option<usize>,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let options = crate::picture::options(py, (width, height), color_by)?
            .with_wireframe(wireframe)
            .with_lattice(lattice)
            .with_edges(edges)
            .with_backfaces(backfaces);
        let deviation_px = errors::positive(py, "deviation_px", Some(deviation_px))?.unwrap_or(0.5);
        let size_px = errors::positive(py, "size_px", size_px)?;
        let from = crate::picture::view_point(py, view)?;
        let aim = crate::picture::Aim { from, orthographic, deviation_px, size_px };
        let job = Job { py, stage: "render", progress, workers: threads(py, workers)? };
        let image = crate::picture::draw(&job, &self.prepared, &aim, options, self.limits(None))?;
        crate::picture::pixels(py, image)
    }

    fn __repr__(&self) -> String {
        let scene = &self.prepared.scene;
        let (parts, instances) = (scene.parts.len(), scene.instances.len());
        let diagonal = self.prepared.diagonal;
        format!("<Prepared {:?}: {parts} parts, {instances} instances, diagonal {diagonal:.6} mm>", scene.name)
    }

    fn _repr_html_(&self) -> String {
        let scene = &self.prepared.scene;
        let facts = [
            ("parts", scene.parts.len().to_string()),
            ("instances", scene.instances.len().to_string()),
            ("faces", scene.parts.iter().map(|part| part.face_colours.len()).sum::<usize>().to_string()),
            ("closed parts", scene.parts.iter().filter(|part| part.closed).count().to_string()),
            ("diagonal", format!("{:.6} mm", self.prepared.diagonal)),
            ("diagnostics", diagnostic::counts(&self.prepared.diagnostics)),
        ];
        diagnostic::html(&format!("Prepared {}", scene.name), &facts)
    }

    /// A picture, where there is an adapter.
    #[cfg(feature = "wgpu")]
    fn _repr_png_(&self, py: Python<'_>) -> PyResult<Option<Vec<u8>>> {
        crate::picture::png(py, &self.prepared, self.limits(None))
    }
}
