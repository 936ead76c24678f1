//! Options that `render` and `view` share: camera, colours, lines, screen-space error.

use crate::Failure;
use crate::tessellate::positive;
use std::path::Path;
use trimtess::glam::DVec3;
use trimtess::out::wgpu::{ColourBy, RenderOptions};
use trimtess::view::{Camera, View, ViewPoint};

/// Refuses an output that is not called `.png`.
pub(crate) fn require_png(output: &Path) -> Result<(), Failure> {
    if output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
        return Ok(());
    }
    Err(Failure::Usage(format!("{}: the output must be a .png file", output.display())))
}

/// Options of a picture.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct PictureArgs {
    /// Maximum screen-space error, pixels. Half a pixel is below what 4× multisampling shows.
    #[arg(long, value_name = "P", value_parser = positive, default_value_t = 0.5)]
    pub(crate) deviation_px: f64,
    /// Maximum length of lattice cell sides and edge segments on the screen, pixels.
    #[arg(long, value_name = "S", value_parser = positive)]
    pub(crate) size_px: Option<f64>,
    /// View point: iso, front, back, left, right, top, bottom, or yaw,pitch,distance (angles in degrees; at distance 1
    /// the model just fits).
    #[arg(long, value_name = "FROM", default_value = "iso", allow_hyphen_values = true)]
    pub(crate) camera: ViewPoint,
    /// Use an orthographic camera instead of a perspective one.
    #[arg(long)]
    pub(crate) orthographic: bool,
    /// Colour by: model, part, face, tile, worker, or rate (lattice cells per tile).
    #[arg(long, value_name = "WHAT", default_value = "model")]
    pub(crate) color_by: ColourBy,
    /// Draw triangle edges.
    #[arg(long)]
    pub(crate) wireframe: bool,
    /// Draw the lattice lines of tiles.
    #[arg(long)]
    pub(crate) lattice: bool,
    /// Draw the model's B-rep edges.
    #[arg(long)]
    pub(crate) edges: bool,
    /// Draw back-facing surfaces in magenta.
    #[arg(long)]
    pub(crate) backfaces: bool,
}

impl PictureArgs {
    /// Fits the camera to these points, seen from the selected view point.
    pub(crate) fn fit(&self, points: impl IntoIterator<Item = DVec3>, aspect: f64) -> Camera {
        fit(&self.camera, self.orthographic, points, aspect)
    }

    /// Render options for a picture of `size` pixels seen by `camera`.
    pub(crate) fn options(&self, camera: Camera, size: (u32, u32)) -> RenderOptions {
        RenderOptions::DEFAULT
            .with_size(size)
            .with_camera(Some(camera))
            .with_colour_by(self.color_by)
            .with_wireframe(self.wireframe)
            .with_lattice(self.lattice)
            .with_edges(self.edges)
            .with_backfaces(self.backfaces)
    }

    /// The view that the frame is planned for.
    pub(crate) fn view(&self, camera: &Camera, size: (u32, u32)) -> View {
        View { camera: *camera, size, deviation_px: self.deviation_px, size_px: self.size_px, angle: View::ANGLE }
    }
}

/// Fits an orthographic or perspective camera to these points.
pub(crate) fn fit(
    from: &ViewPoint,
    orthographic: bool,
    points: impl IntoIterator<Item = DVec3>,
    aspect: f64,
) -> Camera {
    if orthographic { from.fit_orthographic(points, aspect) } else { from.fit(points, aspect) }
}
