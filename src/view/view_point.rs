//! View points by name or angle to cameras that fit a set of points.

use super::camera::{Camera, Projection};
use glam::DVec3;
use std::str::FromStr;

/// The direction a scene is viewed from. z is up; the front view looks along +y.
#[derive(Clone, Copy, PartialEq, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct ViewPoint {
    /// Degrees about z, counter-clockwise seen from above. 0 is the front (eye at -y), 90 the right side (eye at +x).
    pub yaw: f64,
    /// Degrees above the horizon. 90 looks down, -90 up.
    pub pitch: f64,
    /// Distance to the middle of the scene, as a multiple of the distance at which the scene just fits. Above 0.
    pub distance: f64,
}

impl ViewPoint {
    /// The isometric view: all three axes are foreshortened equally.
    pub const ISO: Self = Self { yaw: 45.0, pitch: 35.264_389_682_754_654, distance: 1.0 };

    /// Names that [`ViewPoint::from_str`] accepts besides `yaw,pitch,distance`.
    pub const NAMED: &'static [(&'static str, Self)] = &[
        ("iso", Self::ISO),
        ("front", Self { yaw: 0.0, pitch: 0.0, distance: 1.0 }),
        ("back", Self { yaw: 180.0, pitch: 0.0, distance: 1.0 }),
        ("left", Self { yaw: -90.0, pitch: 0.0, distance: 1.0 }),
        ("right", Self { yaw: 90.0, pitch: 0.0, distance: 1.0 }),
        ("top", Self { yaw: 0.0, pitch: 90.0, distance: 1.0 }),
        ("bottom", Self { yaw: 0.0, pitch: -90.0, distance: 1.0 }),
    ];

    /// Unit vectors to the right, up and towards the eye.
    fn axes(&self) -> [DVec3; 3] {
        let (yaw_sin, yaw_cos) = self.yaw.to_radians().sin_cos();
        let (pitch_sin, pitch_cos) = self.pitch.to_radians().sin_cos();
        let back = DVec3::new(yaw_sin * pitch_cos, -yaw_cos * pitch_cos, pitch_sin);
        let up = DVec3::new(-yaw_sin * pitch_sin, yaw_cos * pitch_sin, pitch_cos);
        [DVec3::new(yaw_cos, yaw_sin, 0.0), up, back]
    }

    /// Fits a perspective camera to `points` for a picture of aspect ratio `aspect` (width over height).
    ///
    /// At `distance` 1 all points are in view with a small margin. The fit is exact: the corners of a bounding box
    /// suffice, mesh vertices fit tighter. O(points).
    #[must_use]
    pub fn fit(&self, points: impl IntoIterator<Item = DVec3>, aspect: f64) -> Camera {
        let [right, up, back] = self.axes();
        let slope_y = (0.5 * Camera::FOV_Y).tan() / (1.0 + MARGIN);
        let slope_x = slope_y * aspect;
        // In (right, up, back) a point is inside the right plane when eye.x + slope·eye.z ≥ x + slope·z, and so on.
        let mut planes = [f64::NEG_INFINITY; 4];
        let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
        for point in points {
            let (x, y, z) = (point.dot(right), point.dot(up), point.dot(back));
            let reach = [x + slope_x * z, slope_x * z - x, y + slope_y * z, slope_y * z - y];
            planes = std::array::from_fn(|side| planes[side].max(reach[side]));
            (near, far) = (near.max(z), far.min(z));
        }
        if near < far {
            (planes, near, far) = ([0.0; 4], 0.0, 0.0); // no points
        }
        let [right_of, left_of, above, below] = planes;
        let fitting = (0.5 * (right_of + left_of) / slope_x).max(0.5 * (above + below) / slope_y);
        let middle = 0.5 * (near + far);
        let distance = if fitting > near { fitting - middle } else { near - middle + 1.0 };
        let target = 0.5 * (right_of - left_of) * right + 0.5 * (above - below) * up + middle * back;
        let projection = Projection::Perspective { fov_y: Camera::FOV_Y, near: 0.0 };
        Camera::looking_at(target + self.distance * distance * back, target, up, projection)
    }

    /// Fits an orthographic camera, see [`fit`](Self::fit). `distance` scales the height of the view.
    #[must_use]
    pub fn fit_orthographic(&self, points: impl IntoIterator<Item = DVec3>, aspect: f64) -> Camera {
        let axes = self.axes();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for point in points {
            let at = DVec3::from(axes.map(|axis| axis.dot(point)));
            (low, high) = (low.min(at), high.max(at));
        }
        if low.x > high.x {
            (low, high) = (DVec3::ZERO, DVec3::ZERO); // no points
        }
        let (middle, size) = (0.5 * (low + high), high - low);
        let tight = (1.0 + MARGIN) * size.y.max(size.x / aspect);
        let height = self.distance * if tight > 0.0 { tight } else { 1.0 };
        let [right, up, back] = axes;
        let target = middle.x * right + middle.y * up + middle.z * back;
        let projection = Projection::Orthographic { height };
        Camera::looking_at(target + (size.z + height) * back, target, up, projection)
    }

    /// Fits a camera as [`fit`](Self::fit) does, or an orthographic one.
    #[must_use]
    pub fn fit_as(&self, orthographic: bool, points: impl IntoIterator<Item = DVec3>, aspect: f64) -> Camera {
        if orthographic { self.fit_orthographic(points, aspect) } else { self.fit(points, aspect) }
    }
}

/// Margin of a fitted scene, both sides together, as a fraction of its size.
const MARGIN: f64 = 0.06;

/// A text that is not a view point.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error(
    "unknown view point {text:?}; known are {}, or yaw,pitch,distance: degrees, distance above 0 as a multiple of the one \
     that shows all",
    ViewPoint::NAMED.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
)]
pub struct BadViewPoint {
    /// The text.
    pub text: String,
}

impl FromStr for ViewPoint {
    type Err = BadViewPoint;

    /// A name, or `yaw,pitch`, or `yaw,pitch,distance`.
    fn from_str(text: &str) -> Result<Self, BadViewPoint> {
        if let Some((_, named)) = Self::NAMED.iter().find(|(name, _)| *name == text) {
            return Ok(*named);
        }
        let numbers: Vec<Option<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
        let view = match numbers.as_slice() {
            [Some(yaw), Some(pitch)] => Self { yaw: *yaw, pitch: *pitch, distance: 1.0 },
            [Some(yaw), Some(pitch), Some(distance)] => Self { yaw: *yaw, pitch: *pitch, distance: *distance },
            _ => return Err(BadViewPoint { text: text.to_owned() }),
        };
        let sound = view.yaw.is_finite() && view.pitch.is_finite() && view.distance.is_finite() && view.distance > 0.0;
        if sound { Ok(view) } else { Err(BadViewPoint { text: text.to_owned() }) }
    }
}
