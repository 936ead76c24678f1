//! What is wrong with a view.

use super::{Camera, Projection, View};
use glam::DVec3;
use std::f64::consts::PI;

/// What is wrong with a view: nothing can be planned or drawn for it.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InvalidView {
    /// The picture has no pixels.
    #[error("the picture has {width} x {height} pixels")]
    Size {
        /// Pixels.
        width: u32,
        /// Pixels.
        height: u32,
    },
    /// The camera is nowhere: a coordinate is NaN or infinite.
    #[error("the camera is at {0}")]
    Eye(DVec3),
    /// The camera looks nowhere: the direction is zero, or not finite.
    #[error("the camera looks along {0}")]
    Forward(DVec3),
    /// No direction is up in the picture: it is zero, not finite, or parallel to `forward`.
    #[error("{up} is not up for a camera that looks along {forward}")]
    Up {
        /// The direction that points up.
        up: DVec3,
        /// The viewing direction.
        forward: DVec3,
    },
    /// A number of the projection is out of its range.
    #[error("{}", range_fault(.0))]
    Projection(Projection),
    /// The matrix is not that of any camera.
    #[error(
        "the matrix differs from that of a camera with square pixels by {off:.3e} of its rows (wanted: at most 1e-3)"
    )]
    Matrix {
        /// The difference to that of the nearest camera, as a share of the rows of x and y. Infinite if there is no
        /// such camera.
        off: f64,
    },
    /// A limit of the screen-space error is not above 0.
    #[error("{name} is {value} (wanted: above 0)")]
    Limit {
        /// The field of [`View`].
        name: &'static str,
        /// Its value.
        value: f64,
    },
}

fn range_fault(projection: &Projection) -> String {
    match projection {
        Projection::Perspective { fov_y, near } => {
            format!("a field of view of {fov_y} rad from a depth of {near} mm (wanted: above 0, below pi; 0 or more)")
        }
        Projection::Orthographic { height } => format!("a picture of {height} mm"),
    }
}

impl Camera {
    /// Unit vectors to the right, up and forwards; `None` if `forward` and `up` do not span a plane.
    pub(crate) fn frame(&self) -> Option<[DVec3; 3]> {
        let forward = self.forward.try_normalize()?;
        // Parallel within rounding spans none.
        let right = forward.cross(self.up.try_normalize()?);
        let right = (right.length() > 1e-9).then(|| right.normalize())?;
        Some([right, right.cross(forward), forward])
    }
}

impl View {
    /// Whether a picture can be made of this view.
    ///
    /// # Errors
    /// The first fault, in the order size, eye, directions, projection, limits.
    pub fn check(&self) -> Result<(), InvalidView> {
        self.check_camera()?;
        let limits =
            [("deviation_px", Some(self.deviation_px)), ("angle", Some(self.angle)), ("size_px", self.size_px)];
        for (name, value) in limits {
            if let Some(value) = value.filter(|value| value.is_nan() || *value <= 0.0) {
                return Err(InvalidView::Limit { name, value });
            }
        }
        Ok(())
    }

    /// [`check`](Self::check) without the limits.
    pub(crate) fn check_camera(&self) -> Result<(), InvalidView> {
        let Camera { eye, forward, up, projection } = self.camera;
        let (width, height) = self.size;
        if width == 0 || height == 0 {
            return Err(InvalidView::Size { width, height });
        }
        if !eye.is_finite() {
            return Err(InvalidView::Eye(eye));
        }
        if forward.try_normalize().is_none() {
            return Err(InvalidView::Forward(forward));
        }
        if self.camera.frame().is_none() {
            return Err(InvalidView::Up { up, forward });
        }
        let known = |x: f64| x > 0.0 && x.is_finite();
        let is_sound = match projection {
            Projection::Perspective { fov_y, near } => {
                fov_y > 0.0 && fov_y < PI && known((0.5 * fov_y).tan()) && near >= 0.0 && near.is_finite()
            }
            Projection::Orthographic { height: shown } => known(shown) && known(f64::from(height) / shown),
        };
        if is_sound { Ok(()) } else { Err(InvalidView::Projection(projection)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_is_named_with_its_numbers() {
        let projection = Projection::Perspective { fov_y: 0.8, near: 1.0 };
        let camera = Camera { eye: DVec3::ZERO, forward: DVec3::Y, up: DVec3::Z, projection };
        let good = View { camera, size: (4, 3), deviation_px: 0.5, size_px: None, angle: 0.5 };
        assert_eq!(good.check(), Ok(()));
        let of = |camera| View { camera, ..good };
        let seen = |projection| of(Camera { projection, ..camera });
        for (bad, told) in [
            (View { size: (0, 3), ..good }, "the picture has 0 x 3 pixels"),
            (of(Camera { eye: DVec3::INFINITY, ..camera }), "the camera is at [inf, inf, inf]"),
            (of(Camera { forward: DVec3::ZERO, ..camera }), "the camera looks along [0, 0, 0]"),
            (
                of(Camera { up: DVec3::new(0.0, -1.0, 0.0), ..camera }),
                "[0, -1, 0] is not up for a camera that looks along [0, 1, 0]",
            ),
            (
                seen(Projection::Perspective { fov_y: 3.2, near: 1.0 }),
                "a field of view of 3.2 rad from a depth of 1 mm",
            ),
            // Its tangent is above 0.
            (
                seen(Projection::Perspective { fov_y: -6.0, near: 1.0 }),
                "a field of view of -6 rad from a depth of 1 mm",
            ),
            (
                seen(Projection::Perspective { fov_y: 1.0, near: -1.0 }),
                "a field of view of 1 rad from a depth of -1 mm",
            ),
            (seen(Projection::Orthographic { height: 0.0 }), "a picture of 0 mm"),
            (View { deviation_px: 0.0, ..good }, "deviation_px is 0 (wanted: above 0)"),
            (View { angle: f64::NAN, ..good }, "angle is NaN (wanted: above 0)"),
            (View { size_px: Some(-1.0), ..good }, "size_px is -1 (wanted: above 0)"),
        ] {
            let why = bad.check().expect_err(told).to_string();
            assert!(why.starts_with(told), "{why}");
        }
    }
}
