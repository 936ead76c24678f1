//! Options that `render` and `view` share: camera, colours, lines, screen-space error.

use crate::Failure;
use crate::tessellate::positive;
use std::path::Path;
use std::str::FromStr;
use trimtess::glam::DVec3;
use trimtess::out::wgpu::{ColourBy, RenderOptions, Section};
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
    /// Maximum length of lattice cell diagonals and edge segments on the screen, pixels.
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
    /// Cut the model open: x, y or z for the middle of its box, with the share at which to cut (x:0.3); -x cuts away the
    /// lower side.
    #[arg(long, value_name = "AXIS[:SHARE]", allow_hyphen_values = true)]
    pub(crate) section: Option<Cut>,
}

/// Where a section cuts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cut {
    /// 0 to 2.
    pub(crate) axis: usize,
    /// Of the model's box along the axis, 0 to 1.
    pub(crate) share: f64,
    /// Whether the lower side is cut away.
    pub(crate) flipped: bool,
}

impl Cut {
    /// Through the middle.
    pub(crate) const MIDDLE: Self = Self { axis: 0, share: 0.5, flipped: false };
}

impl FromStr for Cut {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (axis, share) = text.split_once(':').unwrap_or((text, "0.5"));
        let (flipped, axis) = axis.strip_prefix('-').map_or((false, axis), |axis| (true, axis));
        let axis = ["x", "y", "z"].iter().position(|name| *name == axis);
        let share = share.parse().ok().filter(|share| (0.0..=1.0).contains(share));
        let (Some(axis), Some(share)) = (axis, share) else {
            return Err("an axis (x, y, z, -x, -y or -z), and a share from 0 to 1 after a colon".to_owned());
        };
        Ok(Self { axis, share, flipped })
    }
}

impl PictureArgs {
    /// Fits the camera to these points, seen from the selected view point.
    pub(crate) fn fit(&self, points: impl IntoIterator<Item = DVec3>, aspect: f64) -> Camera {
        self.camera.fit_as(self.orthographic, points, aspect)
    }

    /// Render options for a picture of `size` pixels of a model within `bounds`, seen by `camera`.
    pub(crate) fn options(&self, camera: Camera, size: (u32, u32), bounds: Option<[DVec3; 2]>) -> RenderOptions {
        let section = self.section.zip(bounds).map(|(cut, bounds)| {
            let section = Section::across(bounds, cut.axis, cut.share);
            if cut.flipped { section.flipped() } else { section }
        });
        RenderOptions::DEFAULT
            .with_size(size)
            .with_camera(Some(camera))
            .with_colour_by(self.color_by)
            .with_wireframe(self.wireframe)
            .with_lattice(self.lattice)
            .with_edges(self.edges)
            .with_backfaces(self.backfaces)
            .with_section(section)
    }

    /// The view that the frame is planned for.
    pub(crate) fn view(&self, camera: &Camera, size: (u32, u32)) -> View {
        View { camera: *camera, size, deviation_px: self.deviation_px, size_px: self.size_px, angle: View::ANGLE }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_has_an_axis_and_a_share() {
        assert_eq!("x".parse(), Ok(Cut::MIDDLE));
        assert_eq!("-z:0.25".parse(), Ok(Cut { axis: 2, share: 0.25, flipped: true }));
        for bad in ["", "w", "x:", "x:2", "x:nan", "x:-0.1", "--x", "xy", "x:0.5:0.5"] {
            assert!(bad.parse::<Cut>().is_err(), "{bad}");
        }
    }
}
