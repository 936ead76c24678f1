//! A view point's name to a camera that just holds a set of points.

use glam::{DMat4, DVec3, dcamera};
use std::fmt;
use std::str::FromStr;

/// Where a scene is looked at from; z is up, the front looks along +y.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ViewPoint {
    /// Degrees about z, from the front (eye at -y) counter-clockwise seen from above: 90 is the right side (eye at +x).
    pub yaw: f64,
    /// Degrees above the horizon: 90 looks down, -90 up.
    pub pitch: f64,
    /// Distance to the middle of the scene, as a multiple of the one from which the scene just fits. Above 0.
    pub distance: f64,
}

impl ViewPoint {
    /// The corner view: all three axes are shortened alike.
    pub const ISO: Self = Self { yaw: 45.0, pitch: 35.264_389_682_754_654, distance: 1.0 };

    /// Names that [`ViewPoint::from_str`] takes besides `yaw,pitch,distance`.
    pub const NAMED: [(&'static str, Self); 7] = [
        ("iso", Self::ISO),
        ("front", Self { yaw: 0.0, pitch: 0.0, distance: 1.0 }),
        ("back", Self { yaw: 180.0, pitch: 0.0, distance: 1.0 }),
        ("left", Self { yaw: -90.0, pitch: 0.0, distance: 1.0 }),
        ("right", Self { yaw: 90.0, pitch: 0.0, distance: 1.0 }),
        ("top", Self { yaw: 0.0, pitch: 90.0, distance: 1.0 }),
        ("bottom", Self { yaw: 0.0, pitch: -90.0, distance: 1.0 }),
    ];

    /// What is right, up and towards the eye in its pictures.
    fn axes(&self) -> [DVec3; 3] {
        let (yaw_sin, yaw_cos) = self.yaw.to_radians().sin_cos();
        let (pitch_sin, pitch_cos) = self.pitch.to_radians().sin_cos();
        let back = DVec3::new(yaw_sin * pitch_cos, -yaw_cos * pitch_cos, pitch_sin);
        let up = DVec3::new(-yaw_sin * pitch_sin, yaw_cos * pitch_sin, pitch_cos);
        [DVec3::new(yaw_cos, yaw_sin, 0.0), up, back]
    }

    /// The perspective camera that sees all `points` in a picture `aspect` times as wide as high, with a small margin, when
    /// `distance` is 1. Exact for the points given (a box's corners suffice, vertices make the tightest picture). O(points).
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
        let lens = Lens::Perspective { fov_y: Camera::FOV_Y };
        Camera { eye: target + self.distance * distance * back, target, up, lens }
    }

    /// The same for lines of sight that are parallel. `distance` widens what is seen.
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
        let lens = Lens::Orthographic { height };
        Camera { eye: target + (size.z + height) * back, target, up, lens }
    }
}

/// Free room on each side of a fitted scene, as a fraction of the picture.
const MARGIN: f64 = 0.06;

/// What is not a view point.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct BadViewPoint {
    /// The text.
    pub text: String,
}

impl fmt::Display for BadViewPoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no view point: {:?}; known are", self.text)?;
        for (name, _) in ViewPoint::NAMED {
            write!(f, " {name},")?;
        }
        f.write_str(" or yaw,pitch,distance: degrees, and a multiple (above 0) of the distance that shows all")
    }
}

impl std::error::Error for BadViewPoint {}

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

/// How a camera makes its picture.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Lens {
    /// Lines of sight meet in the eye.
    Perspective {
        /// The full angle between the picture's top and bottom, radians, above 0 and below π.
        fov_y: f64,
    },
    /// Lines of sight are parallel: how far things are from the eye does not matter, nor on which side of it they are.
    Orthographic {
        /// How much of the world is between the picture's top and bottom, millimetres, above 0.
        height: f64,
    },
}

/// A camera in world coordinates, millimetres.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Camera {
    /// Where it is.
    pub eye: DVec3,
    /// What it looks at; not the eye.
    pub target: DVec3,
    /// What points up in the picture; not along the line of sight.
    pub up: DVec3,
    /// How it makes its picture.
    pub lens: Lens,
}

impl Camera {
    /// The angle that fitted cameras have: 30°, a long lens, as CAD drawings like it.
    pub const FOV_Y: f64 = std::f64::consts::FRAC_PI_6;

    /// The same camera with parallel lines of sight: what is as deep as the target keeps its size.
    #[must_use]
    pub fn orthographic(&self) -> Self {
        let height = self.height_at((self.eye - self.target).length());
        Self { lens: Lens::Orthographic { height }, ..*self }
    }

    /// The other way round, with the angle [`FOV_Y`](Self::FOV_Y) and the eye where that shows the target in the same size.
    #[must_use]
    pub fn perspective(&self) -> Self {
        let Lens::Orthographic { height } = self.lens else { return *self };
        let [.., back] = self.axes();
        let distance = 0.5 * height / (0.5 * Self::FOV_Y).tan();
        Self { eye: self.target + distance * back, lens: Lens::Perspective { fov_y: Self::FOV_Y }, ..*self }
    }

    /// World to camera: x right, y up, z towards the eye.
    #[must_use]
    pub fn view(&self) -> DMat4 {
        dcamera::rh::view::look_at_mat4(self.eye, self.target, self.up)
    }

    /// Camera to clip space with y up and depth 1 at `near`; depth 0 is at infinity, and with parallel lines of sight, which may
    /// have a `near` below 0, at `far`.
    #[must_use]
    pub fn projection(&self, aspect: f64, near: f64, far: f64) -> DMat4 {
        match self.lens {
            Lens::Perspective { fov_y } => {
                dcamera::rh::proj::directx::perspective_infinite_reverse(fov_y, aspect, near)
            }
            Lens::Orthographic { height } => {
                let (x, y) = (0.5 * aspect * height, 0.5 * height);
                dcamera::rh::proj::directx::orthographic(-x, x, -y, y, far, near)
            }
        }
    }

    /// How much of the world is between the picture's top and bottom at this distance before the eye, above 0.
    pub(super) fn height_at(&self, depth: f64) -> f64 {
        match self.lens {
            Lens::Perspective { fov_y } => 2.0 * (0.5 * fov_y).tan() * depth,
            Lens::Orthographic { height } => height,
        }
    }

    /// The line of sight through the centre of a pixel, `x` from the left and `y` from the top, of a picture of so many pixels: a
    /// point of it, and its direction of length 1.
    #[must_use]
    pub fn ray(&self, (x, y): (u32, u32), (width, height): (u32, u32)) -> (DVec3, DVec3) {
        self.line_of_sight([f64::from(x) + 0.5, f64::from(y) + 0.5], [f64::from(width), f64::from(height)])
    }

    /// The same for any place of the picture, in pixels from its upper left corner. The point is the eye, and with parallel
    /// lines of sight as deep as the eye.
    #[must_use]
    pub fn line_of_sight(&self, [x, y]: [f64; 2], [width, height]: [f64; 2]) -> (DVec3, DVec3) {
        let place = DVec3::new(x - 0.5 * width, 0.5 * height - y, 0.0) * (self.height_at(1.0) / height);
        let world = self.view().inverse();
        match self.lens {
            Lens::Perspective { .. } => (self.eye, world.transform_vector3(place - DVec3::Z).normalize()),
            Lens::Orthographic { .. } => {
                (self.eye + world.transform_vector3(place), world.transform_vector3(DVec3::NEG_Z))
            }
        }
    }
}
