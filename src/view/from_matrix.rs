//! The matrix of an engine's camera -> a view.

use super::{Camera, InvalidView, Projection, View};
use glam::{DMat3, DMat4, DVec3, DVec4};

/// Largest difference between a matrix and that of the nearest camera, as a share of its rows: jitter of half a pixel is
/// less, an eye of a headset is more.
const SAME: f64 = 1e-3;

impl View {
    /// Screen-space error that suits pictures, pixels.
    pub const DEVIATION_PX: f64 = 0.5;

    /// A view with the usual limits: [`DEVIATION_PX`](Self::DEVIATION_PX), [`ANGLE`](Self::ANGLE) and no limit on the
    /// length of edges. `size`: width and height in pixels.
    #[must_use]
    pub const fn new(camera: Camera, size: (u32, u32)) -> Self {
        Self { camera, size, deviation_px: Self::DEVIATION_PX, size_px: None, angle: Self::ANGLE }
    }

    /// As [`new`](Self::new), for the camera of an engine: `matrix` takes millimetres in the world to clip space, where x
    /// points right, y up and w forwards (projection times view; columns, as in glam). The row of z is not read: depth may
    /// have any convention. So nothing in front of the eye is culled. Set `near` of
    /// [`Projection::Perspective`] for less work near the eye.
    ///
    /// For an engine in metres, multiply by a scale of 0.001 on the right. For one whose y points down in clip space,
    /// negate the row of y.
    ///
    /// # Errors
    /// [`InvalidView::Size`] for a picture without pixels. [`InvalidView::Matrix`] if no [`Camera`] has this matrix:
    /// * pixels are not square,
    /// * the middle of the picture is off the axis, as for an eye of a headset,
    /// * the matrix shears, or it has perspective and mirrors. A mirrored one without perspective is that of a camera on
    ///   the other side.
    pub fn from_matrix(matrix: DMat4, size: (u32, u32)) -> Result<Self, InvalidView> {
        let (width, height) = size;
        if width == 0 || height == 0 {
            return Err(InvalidView::Size { width, height });
        }
        let [x, y, _, w] = [0, 1, 2, 3].map(|row| matrix.row(row));
        let camera = camera_of([x, y, w]).ok_or(InvalidView::Matrix { off: f64::INFINITY })?;
        let view = Self::new(camera, size);
        let aspect = f64::from(width) / f64::from(height);
        // Near and far planes appear in the row of z alone.
        let same = camera.projection_matrix(aspect, 1.0, 2.0) * camera.view_matrix();
        let (unit, of_same) = (scale([x, y, w]), scale([same.row(0), same.row(1), same.row(3)]));
        let off = |row: usize| {
            let (given, wanted) = (matrix.row(row) / unit, same.row(row) / of_same);
            (given - wanted).truncate().length() / wanted.truncate().length().max(1e-9)
        };
        let off = off(0).max(off(1));
        if off <= SAME { Ok(view) } else { Err(InvalidView::Matrix { off }) }
    }
}

/// What all rows may be divided by: the length of w's direction, or w itself where it has none.
fn scale([_, _, w]: [DVec4; 3]) -> f64 {
    if is_parallel(w) { w.w } else { w.truncate().length() }
}

fn is_parallel(w: DVec4) -> bool {
    w.truncate() == DVec3::ZERO
}

/// The camera whose matrix has about these rows, of x, y and w. `None` if the rows determine none.
fn camera_of([x, y, w]: [DVec4; 3]) -> Option<Camera> {
    let unit = scale([x, y, w]);
    let (right, up) = (x.truncate() / unit, y.truncate() / unit);
    let forward = if is_parallel(w) { up.cross(right) } else { w.truncate() / unit }.try_normalize()?;
    let height = 2.0 / up.length();
    let projection = match is_parallel(w) {
        true => Projection::Orthographic { height },
        false => Projection::Perspective { fov_y: 2.0 * libm::atan(0.5 * height), near: 0.0 },
    };
    // Where x and y are in the middle, and w is 0 or the point is the nearest to the origin.
    let rows = DMat3::from_cols(right, up, forward).transpose();
    let depth = if is_parallel(w) { 0.0 } else { -w.w / unit };
    let eye = (rows.determinant() != 0.0).then(|| rows.inverse() * DVec3::new(-x.w / unit, -y.w / unit, depth))?;
    let is_sound = eye.is_finite() && height > 0.0 && height.is_finite();
    is_sound.then(|| Camera { eye, forward, up: up.normalize(), projection })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dcamera::rh;

    const SIZE: (u32, u32) = (1280, 720);
    const ASPECT: f64 = 1280.0 / 720.0;
    const TARGET: DVec3 = DVec3::new(1.0, 2.0, 3.0);

    fn cameras() -> impl Iterator<Item = Camera> {
        let eyes = [DVec3::new(300.0, -200.0, 150.0), DVec3::new(-1e5, 3.0, 2e4), DVec3::new(1.0, 0.0, 1.0)];
        let projections = [
            Projection::Perspective { fov_y: 0.6, near: 0.0 },
            Projection::Perspective { fov_y: 2.0, near: 0.0 },
            Projection::Orthographic { height: 120.0 },
        ];
        eyes.into_iter()
            .flat_map(move |eye| projections.map(|projection| Camera::looking_at(eye, TARGET, DVec3::Z, projection)))
    }

    #[test]
    fn the_camera_of_a_matrix_has_that_matrix_whatever_its_depth() {
        for camera in cameras() {
            let view = camera.view_matrix();
            let (Projection::Perspective { fov_y: y, .. } | Projection::Orthographic { height: y }) = camera.projection;
            let (wide, high) = (0.5 * ASPECT * y, 0.5 * y);
            let projections = match camera.is_orthographic() {
                false => [
                    camera.projection_matrix(ASPECT, 0.1, 0.0),
                    rh::proj::opengl::perspective(y, ASPECT, 0.5, 1e4),
                    rh::proj::directx::perspective(y, ASPECT, 0.5, 1e4),
                ],
                true => [
                    camera.projection_matrix(ASPECT, 0.1, 10.0),
                    rh::proj::opengl::orthographic(-wide, wide, -high, high, 0.5, 1e4),
                    rh::proj::directx::orthographic(-wide, wide, -high, high, 0.5, 1e4),
                ],
            };
            for projection in projections {
                // Engines have single precision, and may scale all of a matrix.
                for scale in [1.0, 3.0] {
                    let matrix = (scale * (projection * view)).as_mat4().as_dmat4();
                    let found = View::from_matrix(matrix, SIZE).expect("a camera");
                    assert_eq!((found.size, found.check()), (SIZE, Ok(())));
                    let again = found.camera.projection_matrix(ASPECT, 0.1, 10.0) * found.camera.view_matrix();
                    let wanted = camera.projection_matrix(ASPECT, 0.1, 10.0) * view;
                    for aside in [DVec3::ZERO, DVec3::new(0.5, 0.3, 0.1), DVec3::new(-0.2, 0.4, -0.5)] {
                        let [again, wanted] = [again, wanted].map(|matrix| matrix.project_point3(TARGET + aside));
                        assert!((again - wanted).truncate().length() < 1e-6, "{camera:?} {again} {wanted}");
                    }
                }
            }
        }
    }

    #[test]
    fn matrices_of_other_cameras_are_refused() {
        for camera in cameras() {
            let matrix = camera.projection_matrix(ASPECT, 0.1, 10.0) * camera.view_matrix();
            let refused = |matrix, size| matches!(View::from_matrix(matrix, size), Err(InvalidView::Matrix { .. }));
            assert!(refused(matrix, (720, 720)), "pixels that are not square");
            assert!(refused(DMat4::ZERO, SIZE) && refused(matrix * f64::NAN, SIZE));
            assert!(refused(DMat4::from_mat3(DMat3::from_rotation_z(0.1)) * matrix, SIZE), "it shears");
            if !camera.is_orthographic() {
                let mut aside = matrix;
                (0..4).for_each(|column| aside.col_mut(column).x += 0.2 * matrix.col(column).w);
                assert!(refused(aside, SIZE), "an eye of a headset");
                assert!(refused(DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0)) * matrix, SIZE), "y that points down");
            }
            assert_eq!(View::from_matrix(matrix, (0, 7)), Err(InvalidView::Size { width: 0, height: 7 }));
        }
    }
}
