//! Cameras and the screen-space error of their pictures.

use crate::border::{entry, versioned};
use crate::limits::{finite, positive};
use crate::prepared::{self, tt_prepared};
use crate::status::{Failure, tt_status};
use std::ffi::c_char;
use trimtess::glam::{DMat4, DVec3};
use trimtess::view::{Camera, CameraPath, Picture, Projection, View};

/// A camera in world coordinates, millimetres, and the error that its picture may have. All views of a call have the
/// same value in the field `size`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_view {
    /// `sizeof(tt_view)`.
    pub size: u32,
    /// 1 for a parallel projection, 0 for perspective.
    pub orthographic: u32,
    /// Where the camera is.
    pub eye: [f64; 3],
    /// Where it looks to: a direction of any length above 0.
    pub forward: [f64; 3],
    /// What is up in the picture: a direction, not parallel to `forward`.
    pub up: [f64; 3],
    /// Perspective: full vertical field of view, radians, above 0 and below pi.
    pub fov_y: f64,
    /// Perspective: depth of the near plane, 0 or more.
    pub near: f64,
    /// Parallel: height of the visible part of the world, above 0.
    pub height: f64,
    /// Size of the picture, pixels, above 0.
    pub width_px: u32,
    pub height_px: u32,
    /// Largest distance in the picture between triangles and surface, pixels; 0 = 0.5.
    pub deviation_px: f64,
    /// Longest diagonal of a cell or segment of an edge in the picture, pixels; 0 = any.
    pub size_px: f64,
    /// Largest turn of the normal across a cell, radians; 0 = 30 degrees.
    pub angle: f64,
}
versioned!(tt_view);

const DEVIATION: f64 = 0.5;

/// A view of C. What is wrong with its camera is told when it is used.
pub(crate) fn view(name: &str, from: &tt_view) -> Result<View, Failure> {
    let projection = if from.orthographic != 0 {
        Projection::Orthographic { height: from.height }
    } else {
        Projection::Perspective { fov_y: from.fov_y, near: from.near }
    };
    let [eye, forward, up] = [from.eye, from.forward, from.up].map(DVec3::from);
    let number = |field: &str, value| positive(&format!("{name}.{field}"), value);
    Ok(View {
        camera: Camera { eye, forward, up, projection },
        size: (from.width_px, from.height_px),
        deviation_px: number("deviation_px", from.deviation_px)?.unwrap_or(DEVIATION),
        size_px: number("size_px", from.size_px)?,
        angle: number("angle", from.angle)?.unwrap_or(View::ANGLE),
    })
}

/// Sets the camera of `view` to place `frame` of `frames` along a closed path around a prepared model: "orbit", "zoom",
/// "walk" or "glu", those of the program `trimtess bench`. Its picture stays as it is; only `size` has to be set
/// before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_view_along_path(
    prepared: tt_prepared,
    path: *const c_char,
    frame: u32,
    frames: u32,
    view: *mut tt_view,
) -> tt_status {
    entry!(c => {
        let prepared = prepared::get(prepared)?;
        let path: CameraPath = c.text("path", path)?.parse().map_err(|e| Failure::argument(format!("{e}")))?;
        let (before, out) = (c.read("view", view.cast_const())?, c.out_struct("view", view)?);
        let bounds = prepared.bounds.ok_or_else(|| Failure::argument("nothing of the model is placed"))?;
        let picture = Picture { size: (1, 1), deviation_px: DEVIATION, size_px: None, angle: View::ANGLE };
        let camera = path.view(bounds, frame as usize, frames as usize, &picture).camera;
        out.give(&with_camera(before, camera)?);
        Ok(())
    })
}

/// Sets the camera and the picture of `view` to those of an engine. Its limits of errors stay; only `size` has to be
/// set before.
///
/// `matrix` has 16 numbers, column after column: projection times view, from millimetres in the world to clip space,
/// where x points right, y up and w forwards. The row of z is not read: depth may have any convention, and `near` is 0.
/// For metres, multiply by a scale of 0.001 on the right; for a y that points down, negate the row of y.
///
/// The middle of the picture may be off the axis, as for an eye of a headset: `view` has the picture about the axis
/// around it, of pixels of the same size. It is larger, by steps of 16 pixels.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_view_from_matrix(
    matrix: *const f64,
    width_px: u32,
    height_px: u32,
    view: *mut tt_view,
) -> tt_status {
    entry!(c => {
        let matrix = DMat4::from_cols_slice(c.slice("matrix", matrix, 16)?);
        let (before, out) = (c.read("view", view.cast_const())?, c.out_struct("view", view)?);
        let found = View::from_matrix(matrix, (width_px, height_px)).map_err(|e| Failure::argument(e.to_string()))?;
        let (width_px, height_px) = found.size;
        out.give(&tt_view { width_px, height_px, ..with_camera(before, found.camera)? });
        Ok(())
    })
}

/// The same view with another camera.
fn with_camera(before: tt_view, camera: Camera) -> Result<tt_view, Failure> {
    let Camera { eye, forward, up, projection } = camera;
    let (eye, forward, up) = (finite("eye", eye.to_array())?, forward.to_array(), up.to_array());
    let view = tt_view { eye, forward, up, ..before };
    Ok(match projection {
        Projection::Perspective { fov_y, near } => tt_view { orthographic: 0, fov_y, near, ..view },
        Projection::Orthographic { height } => tt_view { orthographic: 1, height, ..view },
    })
}
