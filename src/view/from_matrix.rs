//! The matrix of an engine's camera -> a view.

use super::{Camera, InvalidView, Projection, View};
use glam::{DMat3, DMat4, DVec3, DVec4};

/// Largest difference between a matrix and that of the nearest camera, as a share of its rows.
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

    /// As [`new`](Self::new), for the camera of an engine: `matrix` takes millimetres in the world to clip space, where
    /// x points right, y up and w forwards (projection times view; columns, as in glam). The row of z is not read:
    /// depth may have any convention. So nothing in front of the eye is culled. Set `near` of
    /// [`Projection::Perspective`] for less work near the eye.
    ///
    /// For an engine in metres, multiply by a scale of 0.001 on the right. For one whose y points down in clip space,
    /// negate the row of y.
    ///
    /// The middle of the picture may be off the axis, as for an eye of a headset or a tile of a large picture. The
    /// view's picture is then one around it, about the axis, with pixels of the same size: [`size`](Self::size) is
    /// larger than `size`, by steps of 16 pixels, so that jitter seldom changes it. Jitter by half a pixel alone
    /// changes nothing. A tile at the corner of a large picture is planned as all of that picture.
    ///
    /// # Errors
    /// [`InvalidView::Size`] for a picture without pixels. [`InvalidView::Matrix`] if no [`Camera`] has this matrix:
    /// * pixels are not square,
    /// * the middle of the picture is so far off the axis that the picture around it has more than 2³² pixels a side,
    /// * the matrix shears, or it has perspective and mirrors. A mirrored one without perspective is that of a camera
    ///   on the other side.
    pub fn from_matrix(matrix: DMat4, size: (u32, u32)) -> Result<Self, InvalidView> {
        let (width, height) = size;
        if width == 0 || height == 0 {
            return Err(InvalidView::Size { width, height });
        }
        let none = InvalidView::Matrix { off: f64::INFINITY };
        let [x, y, _, w] = [0, 1, 2, 3].map(|row| matrix.row(row));
        let (x, width) = around_the_axis(x, w, width).ok_or(none)?;
        let (y, height) = around_the_axis(y, w, height).ok_or(none)?;
        let view = Self::new(camera_of([x, y, w]).ok_or(none)?, (width, height));
        let aspect = f64::from(width) / f64::from(height);
        // Near and far planes appear in the row of z alone.
        let same = view.camera.projection_matrix(aspect, 1.0, 2.0) * view.camera.view_matrix();
        let (unit, of_same) = (scale(w), scale(same.row(3)));
        let off = |given: DVec4, wanted: DVec4| {
            let (given, wanted) = (given / unit, wanted / of_same);
            (given - wanted).truncate().length() / wanted.truncate().length().max(1e-9)
        };
        let off = off(x, same.row(0)).max(off(y, same.row(1)));
        if off <= SAME { Ok(view) } else { Err(InvalidView::Matrix { off }) }
    }
}

/// The row of x or y, and the number of pixels, of the smallest picture about the axis that contains one with this row
/// and number. `None` if it is too large.
fn around_the_axis(row: DVec4, w: DVec4, pixels: u32) -> Option<(DVec4, u32)> {
    /// In pixels: jitter of half a pixel to both sides, and rounding to single precision.
    const JITTER: f64 = 1.01;
    const STEP: f64 = 16.0;
    if is_parallel(w) {
        return Some((row, pixels)); // the camera stands in the middle
    }
    // The middle of the picture, in halves of it.
    let middle = row.truncate().dot(w.truncate()) / w.truncate().length_squared();
    let missing = f64::from(pixels) * middle.abs();
    let steps = if missing <= JITTER { 0.0 } else { (missing / STEP).ceil() };
    let all = f64::from(pixels) + STEP * steps;
    (all <= f64::from(u32::MAX)).then(|| ((row - middle * w) * (f64::from(pixels) / all), all as u32))
}

/// What all rows may be divided by: the length of w's direction, or w itself where it has none.
fn scale(w: DVec4) -> f64 {
    if is_parallel(w) { w.w } else { w.truncate().length() }
}

fn is_parallel(w: DVec4) -> bool {
    w.truncate() == DVec3::ZERO
}

/// The camera whose matrix has about these rows, of x, y and w. `None` if the rows determine none.
fn camera_of([x, y, w]: [DVec4; 3]) -> Option<Camera> {
    let unit = scale(w);
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
    use glam::{DVec2, Vec2, dcamera::rh};

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

    /// The matrix of a picture whose middle is off the axis, in halves of the picture.
    fn aside(mut matrix: DMat4, middle: DVec2) -> DMat4 {
        for column in [0, 1, 2, 3] {
            let column = matrix.col_mut(column);
            (column.x, column.y) = (column.x + middle.x * column.w, column.y + middle.y * column.w);
        }
        matrix
    }

    #[test]
    fn pictures_off_the_axis_are_within_that_of_the_view_with_the_same_pixels() {
        for (camera, middle) in cameras().filter(|camera| !camera.is_orthographic()).flat_map(|camera| {
            [(0.0, 0.0), (0.21, 0.0), (-0.31, 0.1), (0.0, -3.01), (7.01, 5.01)].map(|at| (camera, DVec2::from(at)))
        }) {
            let whole = camera.projection_matrix(ASPECT, 0.1, 10.0) * camera.view_matrix();
            // These sizes do not change by jitter of half a pixel.
            let jitter = Vec2::new(1.0, -1.0) / Vec2::new(SIZE.0 as f32, SIZE.1 as f32);
            let [view, with_jitter] = [middle, middle + jitter.as_dvec2()]
                .map(|middle| View::from_matrix(aside(whole, middle), SIZE).expect("a camera"));
            assert_eq!((view.size, view.check()), (with_jitter.size, Ok(())));
            let sides = |(width, height): (u32, u32)| DVec2::new(f64::from(width), f64::from(height));
            let (given, size) = (sides(SIZE), sides(view.size));
            assert!(((1.0 + middle.abs()) * given).cmple(size + 1e-3).all(), "{middle} {size}");
            assert!(size.cmple((1.0 + middle.abs()) * given + 16.0).all(), "{middle} {size}");
            let found = view.camera.projection_matrix(size.x / size.y, 0.1, 10.0) * view.camera.view_matrix();
            for corner in [(-1.0, -1.0), (1.0, -1.0), (0.3, 1.0)].map(DVec2::from) {
                // In pixels from the axis.
                let place = whole.inverse().project_point3((corner - middle).extend(0.5));
                let [seen, wanted] = [(found, size), (whole, given)]
                    .map(|(matrix, size)| 0.5 * size * matrix.project_point3(place).truncate());
                assert!((seen - wanted).length() < 1e-2, "{camera:?} {middle}: {seen} {wanted}");
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
                assert!(refused(aside(matrix, DVec2::new(4e6, 0.0)), SIZE), "a picture out of sight");
                assert!(refused(DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0)) * matrix, SIZE), "y that points down");
            }
            assert_eq!(View::from_matrix(matrix, (0, 7)), Err(InvalidView::Size { width: 0, height: 7 }));
        }
    }
}
