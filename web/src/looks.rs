//! Settings of the picture and of the camera, as JavaScript states them.

use serde::Deserialize;
use trimtess::glam::DVec3;
use trimtess::out::wgpu::{BadColourBy, ColourBy, RenderOptions, Section};
use trimtess::view::{Camera, Projection, View};
use tsify::Tsify;

/// Settings of the picture. What is left out stays.
#[derive(Default, Deserialize, Tsify)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Settings {
    /// Largest screen distance between surface and triangles, pixels, above 0. 0.5 at first.
    #[tsify(optional)]
    deviation_px: Option<f64>,
    /// What triangles are coloured by: model, part, face, tile or rate.
    #[tsify(optional)]
    colour_by: Option<String>,
    /// Draws triangle edges.
    #[tsify(optional)]
    wireframe: Option<bool>,
    /// Draws the edges of faces.
    #[tsify(optional)]
    edges: Option<bool>,
    /// Draws the lattice lines of tiles.
    #[tsify(optional)]
    lattice: Option<bool>,
    /// Paints back-facing surfaces magenta.
    #[tsify(optional)]
    backfaces: Option<bool>,
    /// Where the model is cut open.
    #[tsify(optional)]
    section: Option<SectionSetting>,
    /// sRGB colours at the top and the bottom.
    #[tsify(optional, type = "[[number, number, number, number], [number, number, number, number]]")]
    background: Option<[[f32; 4]; 2]>,
}

/// A cut across an axis of the model's box.
#[derive(Clone, Copy, Deserialize, Tsify)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SectionSetting {
    /// x, y or z, or none.
    axis: Axis,
    /// Where in the box, 0 to 1.
    share: f64,
    /// Cuts away the lower side.
    flipped: bool,
}

/// An axis, or none.
#[derive(Clone, Copy, PartialEq, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub enum Axis {
    None,
    X,
    Y,
    Z,
}

/// Options of the picture and its deviation.
#[derive(Clone, Copy)]
pub(crate) struct Looks {
    pub(crate) options: RenderOptions,
    section: Option<SectionSetting>,
    deviation_px: f64,
}

impl Default for Looks {
    fn default() -> Self {
        Self { options: RenderOptions::DEFAULT.with_edges(true), section: None, deviation_px: 0.5 }
    }
}

impl Looks {
    /// Takes over what the settings state.
    pub(crate) fn set(&mut self, settings: Settings) -> Result<(), BadColourBy> {
        if let Some(by) = settings.colour_by {
            self.options.colour_by = by.parse::<ColourBy>()?;
        }
        if let Some(deviation) = settings.deviation_px.filter(|deviation| deviation.is_finite() && *deviation > 0.0) {
            self.deviation_px = deviation;
        }
        let options = &mut self.options;
        let flags = [
            (settings.wireframe, &mut options.wireframe),
            (settings.edges, &mut options.edges),
            (settings.lattice, &mut options.lattice),
            (settings.backfaces, &mut options.backfaces),
        ];
        for (stated, flag) in flags {
            *flag = stated.unwrap_or(*flag);
        }
        options.background = settings.background.unwrap_or(options.background);
        self.section = settings.section.or(self.section);
        Ok(())
    }

    /// Options for a picture of `size` pixels of a model within `bounds`, seen by `camera`.
    pub(crate) fn options(&self, camera: Camera, size: (u32, u32), bounds: Option<[DVec3; 2]>) -> RenderOptions {
        let section = self.section.zip(bounds).and_then(|(SectionSetting { axis, share, flipped }, bounds)| {
            let axis = [Axis::X, Axis::Y, Axis::Z].iter().position(|known| *known == axis)?;
            let section = Section::across(bounds, axis, share);
            Some(if flipped { section.flipped() } else { section })
        });
        self.options.with_camera(Some(camera)).with_size(size).with_section(section)
    }

    /// The view that the frame is planned for.
    pub(crate) fn view(&self, camera: Camera, size: (u32, u32)) -> View {
        View { camera, size, deviation_px: self.deviation_px, size_px: None, angle: View::ANGLE }
    }
}

/// A camera as eleven numbers: eye, direction, up, 1 for an orthographic one, and its height or angle.
pub(crate) fn numbers(camera: &Camera) -> Vec<f64> {
    let (orthographic, size) = match camera.projection {
        Projection::Perspective { fov_y, .. } => (0.0, fov_y),
        Projection::Orthographic { height } => (1.0, height),
    };
    let points = [camera.eye, camera.forward, camera.up];
    points.iter().flat_map(DVec3::to_array).chain([orthographic, size]).collect()
}

/// The camera of eleven numbers; `None` if they are not one's.
pub(crate) fn camera(numbers: &[f64]) -> Option<Camera> {
    let &[ex, ey, ez, fx, fy, fz, ux, uy, uz, orthographic, size] = numbers else { return None };
    let projection = if orthographic > 0.0 {
        Projection::Orthographic { height: size }
    } else {
        Projection::Perspective { fov_y: size, near: 0.0 }
    };
    let [eye, forward, up] = [[ex, ey, ez], [fx, fy, fz], [ux, uy, uz]].map(DVec3::from);
    let camera = Camera { eye, forward, up, projection };
    let view = View { camera, size: (1, 1), deviation_px: 1.0, size_px: None, angle: View::ANGLE };
    view.check().ok().map(|()| camera)
}
