//! A prepared model -> pixels, through the graphics adapter.

use crate::errors;
use crate::job::Job;
use pyo3::prelude::*;
use std::sync::Arc;
use trimtess::control::{Control, Rayon};
use trimtess::frame::{PlanLimits, Shortfall, plan_for_view_within};
use trimtess::mesh::MemorySink;
use trimtess::out::wgpu::{Image, RenderError, RenderOptions, Renderer};
use trimtess::parallel::{FrameError, coarse_points, tessellate_on};
use trimtess::prepare::Prepared;
use trimtess::view::{View, ViewPoint};

/// Largest side of a picture, pixels. No adapter has larger textures.
const MOST_PIXELS: u32 = 32_768;

/// Size of pictures in notebooks, pixels.
const SHOWN: (u32, u32) = (640, 480);

/// Where a picture is seen from, and how exactly.
pub(crate) struct Aim {
    pub(crate) from: ViewPoint,
    pub(crate) orthographic: bool,
    pub(crate) deviation_px: f64,
    pub(crate) size_px: Option<f64>,
}

/// Why there is no picture.
enum Failure {
    NoAdapter(String),
    Limits(Box<Shortfall>),
    Frame(FrameError),
    Render(RenderError),
}

/// Options of a picture of this size and colouring.
pub(crate) fn options(py: Python<'_>, size: (u32, u32), colour_by: &str) -> PyResult<RenderOptions> {
    for (name, side) in [("width", size.0), ("height", size.1)] {
        if !(1..=MOST_PIXELS).contains(&side) {
            return Err(errors::out_of_range(py, name, side, &format!("from 1 to {MOST_PIXELS}")));
        }
    }
    let colour_by = colour_by.parse().map_err(|e| errors::out_of_range(py, "color_by", colour_by, &format!("{e}")))?;
    Ok(RenderOptions::DEFAULT.with_size(size).with_colour_by(colour_by))
}

/// A view point by name, or as "yaw,pitch,distance".
pub(crate) fn view_point(py: Python<'_>, text: &str) -> PyResult<ViewPoint> {
    text.parse().map_err(|e| errors::out_of_range(py, "view", text, &format!("{e}")))
}

/// Draws the model.
pub(crate) fn draw(
    job: &Job<'_>,
    prepared: &Arc<Prepared>,
    aim: &Aim,
    options: RenderOptions,
    limits: PlanLimits,
) -> PyResult<Image> {
    let drawn = job.run(|control| {
        // First, because it is quick and fails early.
        let renderer = Renderer::new().map_err(|e| Failure::NoAdapter(e.to_string()))?;
        // Too quick to report, and its tiles would be counted twice.
        let points = coarse_points(&Rayon, prepared, &limits, &Control::default()).map_err(Failure::Frame)?;
        let aspect = f64::from(options.size.0) / f64::from(options.size.1);
        let camera = aim.from.fit_as(aim.orthographic, points, aspect);
        let (deviation_px, size_px) = (aim.deviation_px, aim.size_px);
        let view = View { camera, size: options.size, deviation_px, size_px, angle: View::ANGLE };
        let plan = plan_for_view_within(prepared, &view, &limits).require_full();
        let plan = Arc::new(plan.map_err(|short| Failure::Limits(Box::new(short)))?);
        let mut frame = MemorySink::default();
        tessellate_on(&Rayon, prepared, &plan, options.edges, control, &mut frame).map_err(Failure::Frame)?;
        renderer.render(&frame, &options.with_camera(Some(camera))).map_err(Failure::Render)
    })?;
    drawn.map_err(|failure| match failure {
        Failure::NoAdapter(why) => errors::error!(job.py, "NoAdapterError", why),
        Failure::Limits(short) => {
            errors::short(job.py, &short, |_| ("use a larger deviation_px or size_px".into(), false))
        }
        Failure::Frame(failure) => errors::unmade(job.py, &failure),
        Failure::Render(why) => errors::error!(job.py, "RenderError", why.to_string()),
    })
}

/// A (height, width, 4) array of bytes.
pub(crate) fn pixels(py: Python<'_>, image: Image) -> PyResult<Bound<'_, PyAny>> {
    let shape = (image.height, image.width, 4);
    let owner = Arc::new(image);
    crate::array::view(py, &owner, &owner.pixels)?.call_method1("reshape", (shape,))
}

/// The bytes of a PNG file; `None` without an adapter.
pub(crate) fn png(py: Python<'_>, prepared: &Arc<Prepared>, limits: PlanLimits) -> PyResult<Option<Vec<u8>>> {
    let aim = Aim { from: ViewPoint::ISO, orthographic: false, deviation_px: 0.5, size_px: None };
    let job = Job { py, stage: "render", progress: None, workers: 0 };
    let options = RenderOptions::DEFAULT.with_size(SHOWN).with_edges(true);
    let image = match draw(&job, prepared, &aim, options, limits) {
        Ok(image) => image,
        Err(failure) if failure.get_type(py).name().is_ok_and(|name| name == "NoAdapterError") => return Ok(None),
        Err(failure) => return Err(failure),
    };
    let mut bytes = Vec::new();
    image.encode(&mut bytes).map_err(|e| errors::internal(py, e.to_string()))?;
    Ok(Some(bytes))
}
