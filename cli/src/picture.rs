//! What `render` and `view` have in common: what is seen, how, and how exactly.

use crate::tessellate::positive;
use trimtess::frame::{Projection, View};
use trimtess::glam::DVec3;
use trimtess::out::wgpu::{ColourBy, RenderOptions};
use trimtess::out::{Camera, Lens, ViewPoint};

/// Angle tolerance in pictures, degrees. Normals are exact at vertices; this keeps what is interpolated between them close.
pub(crate) const ANGLE: f64 = 30.0;

/// How a picture looks.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct PictureArgs {
    /// Largest distance between picture and exact surface, pixels: half a pixel is below what 4× multisampling shows.
    #[arg(long, value_name = "P", value_parser = positive, default_value_t = 0.5)]
    pub(crate) deviation_px: f64,
    /// Largest length of a triangle's edge, pixels.
    #[arg(long, value_name = "S", value_parser = positive)]
    pub(crate) size_px: Option<f64>,
    /// From where: iso, front, back, left, right, top, bottom, or yaw,pitch,distance (degrees; 1 = all fits).
    #[arg(long, value_name = "FROM", default_value = "iso", allow_hyphen_values = true)]
    pub(crate) camera: ViewPoint,
    /// Parallel lines of sight instead of a perspective.
    #[arg(long)]
    pub(crate) orthographic: bool,
    /// What colours tell: model, part, face, tile, worker, rate.
    #[arg(long, value_name = "WHAT", default_value = "model")]
    pub(crate) color_by: ColourBy,
    /// Draw the edges of triangles.
    #[arg(long)]
    pub(crate) wireframe: bool,
    /// Draw the lattice lines of tiles.
    #[arg(long)]
    pub(crate) lattice: bool,
    /// Draw the edges of the model.
    #[arg(long)]
    pub(crate) edges: bool,
    /// Draw surfaces seen from behind in magenta.
    #[arg(long)]
    pub(crate) backfaces: bool,
}

impl PictureArgs {
    /// The camera that holds these points, from where it was asked for.
    pub(crate) fn fit(&self, points: impl IntoIterator<Item = DVec3>, aspect: f64) -> Camera {
        fit(&self.camera, self.orthographic, points, aspect)
    }

    /// What a picture of so many pixels looks like, seen by `camera`.
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

    /// What a camera's picture asks for.
    pub(crate) fn view(&self, camera: &Camera, size: (u32, u32)) -> View {
        let projection = match camera.lens {
            Lens::Perspective { fov_y } => Projection::Perspective { fov_y, near: 0.0 },
            Lens::Orthographic { height } => Projection::Orthographic { height },
        };
        View {
            eye: camera.eye,
            forward: camera.target - camera.eye,
            up: camera.up,
            projection,
            size,
            deviation_px: self.deviation_px,
            size_px: self.size_px,
            angle: ANGLE.to_radians(),
        }
    }
}

/// The camera, with parallel lines of sight or not, that holds these points.
pub(crate) fn fit(
    from: &ViewPoint,
    orthographic: bool,
    points: impl IntoIterator<Item = DVec3>,
    aspect: f64,
) -> Camera {
    if orthographic { from.fit_orthographic(points, aspect) } else { from.fit(points, aspect) }
}
