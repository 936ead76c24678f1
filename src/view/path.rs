//! A model's bounding box -> views along a camera path around, into or through it, for benchmarks and viewers.

use super::camera::{Camera, Projection, View};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_4, FRAC_PI_6, TAU};
use std::str::FromStr;

/// Full vertical field of view of every path, radians.
const FOV_Y: f64 = FRAC_PI_4;
/// Depth of the near plane, as a fraction of the box's diagonal; [`CameraPath::Glu`] has its own.
const NEAR: f64 = 1e-3;

/// A closed camera path, fitted to the bounding box of a model. z is up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum CameraPath {
    /// Once around the model, with all of it in the image.
    Orbit,
    /// From 4 times the distance that shows the whole model to 1/8 of that distance and back, by a constant factor per
    /// frame.
    Zoom,
    /// Once along an ellipse inside the box (around it, where it is flat), rising and sinking twice, looking ahead.
    Walk,
    /// Once around the model at varying height and distance: the path of the comparison with libGLU
    /// (`docs/benchmarks.md`), made for the Utah teapot. Other models get the same path, scaled to their box.
    Glu,
}

/// The fields that all views of a path share: see [`View`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Picture {
    /// [`View::size`].
    pub size: (u32, u32),
    /// [`View::deviation_px`].
    pub deviation_px: f64,
    /// [`View::size_px`].
    pub size_px: Option<f64>,
    /// [`View::angle`].
    pub angle: f64,
}

/// Position, direction and near plane of a camera.
struct Pose {
    eye: DVec3,
    forward: DVec3,
    near: f64,
}

impl CameraPath {
    /// All paths, in the order of declaration.
    pub const ALL: &'static [Self] = &[Self::Orbit, Self::Zoom, Self::Walk, Self::Glu];

    /// The path as one lower-case word, which [`CameraPath::from_str`] parses.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Orbit => "orbit",
            Self::Zoom => "zoom",
            Self::Walk => "walk",
            Self::Glu => "glu",
        }
    }

    /// View `k` of `frames` along the path; view `frames` is view 0 again.
    ///
    /// `bounds` are the lower and upper corner of the model's bounding box
    /// ([`Prepared::bounds`](crate::prepare::Prepared::bounds)). A box without extent is treated as one with a diagonal
    /// of 1 mm.
    #[must_use]
    pub fn view(&self, bounds: [DVec3; 2], k: usize, frames: usize, picture: &Picture) -> View {
        let turn = TAU * (k % frames.max(1)) as f64 / frames.max(1) as f64;
        let Pose { eye, forward, near } = match self {
            Self::Orbit => orbit(bounds, turn),
            Self::Zoom => zoom(bounds, turn),
            Self::Walk => walk(bounds, turn),
            Self::Glu => glu(bounds, turn),
        };
        View {
            camera: Camera { eye, forward, up: DVec3::Z, projection: Projection::Perspective { fov_y: FOV_Y, near } },
            size: picture.size,
            deviation_px: picture.deviation_px,
            size_px: picture.size_px,
            angle: picture.angle,
        }
    }

    /// All views of the path, in order.
    #[must_use]
    pub fn views(&self, bounds: [DVec3; 2], frames: usize, picture: &Picture) -> Vec<View> {
        (0..frames).map(|k| self.view(bounds, k, frames, picture)).collect()
    }
}

/// Centre and diagonal of a box; a diagonal of 0 becomes 1.
fn middle([low, high]: [DVec3; 2]) -> (DVec3, f64) {
    let diagonal = (high - low).length();
    (0.5 * (low + high), if diagonal > 0.0 { diagonal } else { 1.0 })
}

/// A pose that looks at `target` from `distance`, at an azimuth about z and an elevation.
fn towards(target: DVec3, [turned, risen]: [f64; 2], distance: f64, near: f64) -> Pose {
    let ((turned_sin, turned_cos), (risen_sin, risen_cos)) = (turned.sin_cos(), risen.sin_cos());
    let back = DVec3::new(turned_cos * risen_cos, turned_sin * risen_cos, risen_sin);
    Pose { eye: target + distance * back, forward: -back, near }
}

/// Distance at which the bounding sphere of a box with this diagonal fills the height of the image.
fn fitting(diagonal: f64) -> f64 {
    0.5 * diagonal / (0.5 * FOV_Y).sin()
}

fn orbit(bounds: [DVec3; 2], turn: f64) -> Pose {
    let (middle, diagonal) = middle(bounds);
    towards(middle, [turn, FRAC_PI_6], fitting(diagonal), NEAR * diagonal)
}

fn zoom(bounds: [DVec3; 2], turn: f64) -> Pose {
    /// Octaves between the largest and the smallest distance.
    const OCTAVES: f64 = 5.0;
    let (middle, diagonal) = middle(bounds);
    // There and back at the same speed.
    let way = 1.0 - (2.0 * turn / TAU - 1.0).abs();
    let distance = 4.0 * fitting(diagonal) * (-OCTAVES * way).exp2();
    towards(middle, [-FRAC_PI_4, FRAC_PI_6], distance, NEAR * diagonal)
}

fn walk(bounds: [DVec3; 2], turn: f64) -> Pose {
    /// Semi-axes of the ellipse and amplitude in z, as fractions of half the box.
    const REACH: DVec3 = DVec3::new(0.7, 0.7, 0.5);
    /// Least half extent, as a fraction of the diagonal. At the ends of a thinner ellipse the camera would turn around
    /// within one frame.
    const LEAST: f64 = 0.1;
    /// Largest slope of the viewing direction.
    const NOD: f64 = 0.3;
    let (middle, diagonal) = middle(bounds);
    let half = (0.5 * (bounds[1] - bounds[0])).max(DVec3::splat(LEAST * diagonal)) * REACH;
    let eye = middle + half * DVec3::new(turn.cos(), turn.sin(), (2.0 * turn).sin());
    let ahead = DVec3::new(-half.x * turn.sin(), half.y * turn.cos(), 0.0).normalize_or(DVec3::Y);
    Pose { eye, forward: ahead + DVec3::Z * NOD * (2.0 * turn).cos(), near: NEAR * diagonal }
}

fn glu(bounds: [DVec3; 2], turn: f64) -> Pose {
    /// Unit of the published teapot as a fraction of its box's diagonal: 20 mm of 164.096 mm.
    const UNIT: f64 = 20.0 / 164.096_138;
    /// Target of the camera, 1.2 units above the centre of the teapot's base, in fractions of the teapot's box.
    const MIDDLE: DVec3 = DVec3::new(60.0 / 128.68, 0.5, 24.0 / 63.0);
    let (_, diagonal) = middle(bounds);
    let unit = UNIT * diagonal;
    let target = bounds[0] + MIDDLE * (bounds[1] - bounds[0]);
    let risen = 0.35 + 0.15 * (2.0 * turn).sin();
    towards(target, [turn, risen], (8.0 + 3.0 * turn.cos()) * unit, 0.5 * unit)
}

/// Error of parsing a name that is not a [`CameraPath`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "unknown camera path {text:?}: expected one of {}",
    CameraPath::ALL.iter().map(|path| path.name()).collect::<Vec<_>>().join(", ")
)]
#[non_exhaustive]
pub struct UnknownPath {
    /// The text that was parsed.
    pub text: String,
}

impl FromStr for CameraPath {
    type Err = UnknownPath;

    fn from_str(text: &str) -> Result<Self, UnknownPath> {
        let named = Self::ALL.iter().find(|path| path.name() == text);
        named.copied().ok_or_else(|| UnknownPath { text: text.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PICTURE: Picture = Picture { size: (1920, 1080), deviation_px: 0.5, size_px: None, angle: 0.5 };
    const FRAMES: usize = 300;

    /// A box, a plate on each of its three sides, a rod, a point.
    fn boxes() -> [[DVec3; 2]; 6] {
        let high = [[9.0, 4.0, 2.0], [9.0, 4.0, 0.0], [9.0, 0.0, 2.0], [0.0, 4.0, 2.0], [0.0, 0.0, 7.0], [0.0; 3]];
        high.map(|high| [DVec3::ZERO, DVec3::from(high)].map(|corner| corner + DVec3::new(100.0, -50.0, 3.0)))
    }

    #[test]
    fn views_are_valid_and_paths_are_closed_and_without_leaps() {
        for bounds in boxes() {
            for path in CameraPath::ALL {
                let name = path.name();
                let views = path.views(bounds, FRAMES, &PICTURE);
                assert_eq!(views.len(), FRAMES);
                assert_eq!(path.view(bounds, FRAMES, FRAMES, &PICTURE), views[0], "{name}");
                let reach = 12.0 * (bounds[1] - bounds[0]).length().max(1.0);
                for (from, to) in views.iter().zip(views.iter().cycle().skip(1)) {
                    assert!(from.camera.eye.is_finite() && from.camera.forward.is_finite(), "{name}: {from:?}");
                    assert!(from.camera.forward.normalize().cross(from.camera.up).length() > 0.1, "{name}: {from:?}");
                    assert!(from.camera.eye.distance(to.camera.eye) < 0.05 * reach, "{name}: {from:?} to {to:?}");
                    assert!(from.camera.forward.angle_between(to.camera.forward) < 0.25, "{name}: {from:?} to {to:?}");
                }
            }
        }
    }

    #[test]
    fn an_orbit_shows_the_whole_box_and_a_walk_stays_within_it() {
        let bounds = boxes()[0];
        for view in CameraPath::Orbit.views(bounds, FRAMES, &PICTURE) {
            for corner in crate::view::box_corners(bounds) {
                let off = (corner - view.camera.eye).angle_between(view.camera.forward);
                assert!(off <= 0.5 * FOV_Y + 1e-9, "{corner} is {off} off the axis of {view:?}");
            }
        }
        let inside = |view: &View| view.camera.eye.cmpgt(bounds[0]).all() && view.camera.eye.cmplt(bounds[1]).all();
        assert!(CameraPath::Walk.views(bounds, FRAMES, &PICTURE).iter().all(inside));
    }

    #[test]
    fn a_zoom_changes_the_distance_by_a_constant_factor() {
        let bounds = boxes()[0];
        let (middle, diagonal) = middle(bounds);
        let distances = CameraPath::Zoom.views(bounds, FRAMES, &PICTURE);
        let distances: Vec<f64> = distances.iter().map(|view| view.camera.eye.distance(middle)).collect();
        let half = FRAMES / 2;
        assert!((distances[0] / distances[half] - 32.0).abs() < 1e-9);
        assert!((distances[0] / fitting(diagonal) - 4.0).abs() < 1e-9);
        let factor = distances[1] / distances[0];
        for (k, pair) in distances.windows(2).enumerate() {
            let expected = if k < half { factor } else { 1.0 / factor };
            assert!((pair[1] / pair[0] - expected).abs() < 1e-9, "frame {k}");
        }
    }

    #[test]
    fn the_glu_path_matches_the_published_one_on_the_teapot() {
        // The box of builtin:teapot; the camera in the published teapot's units, 20 mm.
        let teapot = [DVec3::new(-60.0, -40.0, 0.0), DVec3::new(68.68, 40.0, 63.0)];
        for (k, view) in CameraPath::Glu.views(teapot, FRAMES, &PICTURE).iter().enumerate() {
            let a = TAU * k as f64 / FRAMES as f64;
            let (e, d) = (0.35 + 0.15 * (2.0 * a).sin(), 8.0 + 3.0 * a.cos());
            let eye = DVec3::new(d * a.cos() * e.cos(), d * a.sin() * e.cos(), 1.2 + d * e.sin());
            assert!(view.camera.eye.distance(eye * 20.0) < 1e-3, "{k}: {} and {}", view.camera.eye, eye * 20.0);
            assert!((view.camera.eye + view.camera.forward * d * 20.0).distance(DVec3::Z * 24.0) < 1e-3);
            let Projection::Perspective { fov_y, near } = view.camera.projection else { panic!("{view:?}") };
            assert!(fov_y == FRAC_PI_4 && (near - 10.0).abs() < 1e-3);
        }
    }

    #[test]
    fn names_are_parsed() {
        for path in CameraPath::ALL {
            assert_eq!(path.name().parse(), Ok(*path));
        }
        let error = "spiral".parse::<CameraPath>().unwrap_err();
        assert_eq!(error.to_string(), "unknown camera path \"spiral\": expected one of orbit, zoom, walk, glu");
    }

    #[cfg(feature = "serde")]
    #[test]
    fn paths_are_stored_by_name() {
        for path in CameraPath::ALL {
            let mut bytes = Vec::new();
            ciborium::into_writer(path, &mut bytes).expect("room");
            assert_eq!(&bytes[1..], path.name().as_bytes());
            assert_eq!(ciborium::from_reader::<CameraPath, _>(&bytes[..]).expect("a path"), *path);
        }
    }
}
