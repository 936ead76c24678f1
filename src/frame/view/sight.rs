//! A camera and deviations in pixels to tolerances in object space, each box of the model by itself: the paper's
//! object-to-screen factor (section 3), made conservative over boxes.
//!
//! A camera sees a point at depth z, at the angle θ off its axis, by the Jacobian of (x/z, y/z), whose largest singular value is
//! 1/(z cos θ). Over a box that is at most what its least depth and its widest angle make together, and two points of a
//! (convex) box are at most that many times their distance apart in the picture.

use super::camera::{Projection, View};
use crate::mesh::SceneInstance;
use crate::prepare::internals::BoundingBox;
use glam::DVec3;

/// A box nearer than this fraction of half its diagonal (or around the camera) is planned as if it were so far away: finer would
/// cost without end and show nothing but what is about to be passed.
const NEAREST: f64 = 0.05;

/// How one camera sees the boxes of one instance.
#[derive(Clone, Debug)]
pub(crate) struct Sight {
    /// The camera's axes (right, up, forward) as the part's coordinates see them: x, y, z are their products with a point...
    axes: [DVec3; 3],
    /// ...plus these.
    origin: DVec3,
    /// How much larger the part is in the world.
    scale: f64,
    lens: SightLens,
    /// Where the camera is and looks, in the part's coordinates.
    eye: DVec3,
    forward: DVec3,
}

/// A camera's numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SightLens {
    Perspective {
        /// Pixels of a millimetre on the axis, at a depth of one.
        focal: f64,
        /// Tangents of the angles between the axis and the picture's right and upper side.
        slopes: [f64; 2],
        near: f64,
    },
    Orthographic {
        pixels_per_length: f64,
        /// Half of the picture's width and height, millimetres.
        sides: [f64; 2],
    },
}

/// What a camera sees of a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seen {
    /// Pixels that a millimetre covers at most where the box is in the picture, as [`Sight::pixels_per_length`].
    pub(crate) most: f64,
    /// No more than that of any box within the box.
    pub(crate) least: f64,
}

impl Sight {
    /// Pixels that a millimetre of the part covers at most within a box, where that is in the picture; 0 for what is nearer
    /// than the near plane or behind.
    pub(crate) fn pixels_per_length(&self, place: &BoundingBox) -> f64 {
        match self.lens {
            SightLens::Orthographic { pixels_per_length, .. } => self.scale * pixels_per_length,
            SightLens::Perspective { .. } => self.pixels(self.placed(place)),
        }
    }

    /// The same of a box along the camera's axes.
    fn pixels(&self, (middle, reach): (DVec3, DVec3)) -> f64 {
        let (focal, slopes, near) = match self.lens {
            SightLens::Orthographic { pixels_per_length, .. } => return self.scale * pixels_per_length,
            SightLens::Perspective { focal, slopes, near } => (focal, slopes, near),
        };
        // A table's box without anything in it has no place.
        if middle.z + reach.z < near || middle.z + reach.z <= 0.0 || middle.is_nan() {
            return 0.0;
        }
        // What is beside the axis is in the picture only where it is as deep as the picture's sides are there.
        let beside = |axis: usize| (middle[axis].abs() - reach[axis]) / slopes[axis];
        let depth = (middle.z - reach.z).max(near).max(NEAREST * reach.length()).max(beside(0)).max(beside(1));
        let per_depth = depth.recip();
        let slope = |axis: usize| ((middle[axis].abs() + reach[axis]) * per_depth).min(slopes[axis]);
        self.scale * focal * (1.0 + slope(0).powi(2) + slope(1).powi(2)).sqrt() * per_depth
    }
}

impl Sight {
    /// Middle and half sides of the box, along the camera's axes, around a box of the part.
    fn placed(&self, place: &BoundingBox) -> (DVec3, DVec3) {
        let (centre, half) = (0.5 * (place.low + place.high), 0.5 * (place.high - place.low));
        let middle = DVec3::from(self.axes.map(|axis| axis.dot(centre))) + self.origin;
        (middle, DVec3::from(self.axes.map(|axis| axis.abs().dot(half))))
    }

    /// What is seen of a box; `None` where certainly nothing of it is in the picture.
    pub(crate) fn look(&self, place: &BoundingBox) -> Option<Seen> {
        let (middle, reach) = self.placed(place);
        let beside = |axis: usize, side: f64| middle[axis].abs() - reach[axis] > side;
        match self.lens {
            SightLens::Orthographic { sides, .. } => {
                let most = self.pixels((middle, reach));
                let outside = beside(0, sides[0]) || beside(1, sides[1]) || middle.is_nan();
                (!outside).then_some(Seen { most, least: most })
            }
            SightLens::Perspective { focal, slopes, near } => {
                let furthest = middle.z + reach.z;
                let outside = beside(0, slopes[0] * furthest) || beside(1, slopes[1] * furthest);
                if outside {
                    return None;
                }
                let most = self.pixels((middle, reach));
                if most == 0.0 {
                    return None;
                }
                let aside = |axis: usize| (middle[axis].abs() + reach[axis]) / slopes[axis];
                let depth = furthest.max(aside(0)).max(aside(1)).max(NEAREST * reach.length());
                let least = if middle.z - reach.z < near { 0.0 } else { self.scale * focal / depth };
                Some(Seen { most, least })
            }
        }
    }

    /// The same camera for deviations that count `by` times as much.
    pub(crate) fn weighed(self, by: f64) -> Self {
        Self { scale: self.scale * by, ..self }
    }

    /// Whether a surface within a box turns its back to the camera everywhere, if its outward normals are within `half_angle` of
    /// `axis` (part coordinates, of length 1). Which side of a plane the eye is on stays the same under any placing.
    pub(crate) fn sees_back(&self, place: &BoundingBox, axis: DVec3, half_angle: f64) -> bool {
        let (centre, radius) = (0.5 * (place.low + place.high), 0.5 * place.high.distance(place.low));
        let (line, spread) = match self.lens {
            SightLens::Orthographic { .. } => (self.forward, 0.0),
            SightLens::Perspective { .. } => {
                let line = centre - self.eye;
                (line, (radius / line.length()).min(1.0).asin())
            }
        };
        let allowed = std::f64::consts::FRAC_PI_2 - half_angle - spread;
        allowed > 0.0 && line.dot(axis) > line.length() * allowed.cos()
    }
}

impl View {
    /// The camera's axes and numbers; `None` where they are no camera's.
    pub(crate) fn lens(&self) -> Option<([DVec3; 3], SightLens)> {
        let forward = self.forward.try_normalize()?;
        // Two directions closer than rounding span no plane.
        let right = forward.cross(self.up.try_normalize()?);
        let right = (right.length() > 1e-9).then(|| right.normalize())?;
        let (width, height) = (f64::from(self.size.0), f64::from(self.size.1));
        let known = |x: f64| (x > 0.0 && x.is_finite()).then_some(x);
        let aspect = known(width / height)?;
        let lens = match self.projection {
            Projection::Perspective { fov_y, near } => {
                let slope = known((0.5 * fov_y).tan())?;
                let near = (near >= 0.0 && near.is_finite()).then_some(near)?;
                SightLens::Perspective { focal: 0.5 * height / slope, slopes: [slope * aspect, slope], near }
            }
            Projection::Orthographic { height: shown } => {
                let pixels_per_length = height / known(shown)?;
                SightLens::Orthographic { pixels_per_length, sides: [0.5 * shown * aspect, 0.5 * shown] }
            }
        };
        self.eye.is_finite().then_some(([right, right.cross(forward), forward], lens))
    }

    /// What an instance shows.
    pub(crate) fn sight(&self, (axes, lens): ([DVec3; 3], SightLens), instance: &SceneInstance) -> Sight {
        let back = instance.transform.inverse();
        let (to_part, place) = (instance.transform.matrix3.transpose(), instance.transform.translation - self.eye);
        Sight {
            axes: axes.map(|axis| to_part * axis),
            origin: DVec3::from(axes.map(|axis| axis.dot(place))),
            scale: instance.scale(),
            lens,
            eye: back.transform_point3(self.eye),
            forward: back.transform_vector3(axes[2]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::judge;
    use arbitrary::Unstructured;
    use glam::DAffine3;

    const VIEW: View = View {
        eye: DVec3::new(0.0, 0.0, 100.0),
        forward: DVec3::NEG_Z,
        up: DVec3::Y,
        projection: Projection::Perspective { fov_y: 0.6, near: 5.0 },
        size: (800, 600),
        deviation_px: 0.5,
        size_px: None,
        angle: 0.3,
    };

    fn sight(view: &View, transform: DAffine3) -> Sight {
        let lens = view.lens().unwrap_or_else(|| panic!("no camera: {view:?}"));
        view.sight(
            lens,
            &SceneInstance {
                part: crate::model::PartId(0),
                transform,
                colour: None,
                name: String::new(),
                first_face: 0,
            },
        )
    }

    /// Pixels of a point's picture.
    fn project(point: DVec3) -> [f64; 2] {
        let local = point - VIEW.eye;
        let focal = 0.5 * f64::from(VIEW.size.1) / 0.3_f64.tan();
        [focal * local.x / -local.z, focal * local.y / -local.z]
    }

    #[test]
    fn two_points_of_a_box_are_no_further_apart_in_the_picture_than_it_says() {
        let property = |u: &mut Unstructured<'_>| -> arbitrary::Result<()> {
            let mut unit = || Ok(f64::from(u.int_in_range(-1_000_000..=1_000_000_i32)?) * 1e-6);
            let centre = DVec3::new(60.0 * unit()?, 60.0 * unit()?, 60.0 * unit()?);
            let half = DVec3::new(unit()?, unit()?, unit()?).abs() * 30.0 * unit()?.abs();
            let place = BoundingBox { low: centre - half, high: centre + half };
            let scale = 1.5;
            let placed = DAffine3::from_scale(DVec3::splat(scale));
            let most = sight(&VIEW, placed).pixels_per_length(&place);
            for _ in 0..20 {
                let mut inside = || Ok(centre + half * DVec3::new(unit()?, unit()?, unit()?));
                let (p, q) = (inside()?, inside()?);
                let (a, b) = (project(p * scale), project(q * scale));
                let shown = |x: [f64; 2]| x[0].abs() <= 400.0 && x[1].abs() <= 300.0;
                let depth = |p: DVec3| VIEW.eye.z - p.z * scale;
                if depth(p).min(depth(q)) < 5.0 || !shown(a) || !shown(b) {
                    continue;
                }
                let (pixels, length) = ((a[0] - b[0]).hypot(a[1] - b[1]), p.distance(q));
                assert!(
                    pixels <= most * length * (1.0 + 1e-9),
                    "{pixels} pixels, {} said, in {place:?}",
                    most * length
                );
            }
            Ok(())
        };
        judge!(5_000, 600, |bytes: &[u8]| property(&mut Unstructured::new(bytes)).is_ok());
    }

    #[test]
    fn small_boxes_are_seen_as_their_middle_is() {
        let at = |p: DVec3| sight(&VIEW, DAffine3::IDENTITY).pixels_per_length(&BoundingBox { low: p, high: p });
        let focal = 300.0 / 0.3_f64.tan();
        assert!((at(DVec3::ZERO) - focal / 100.0).abs() < 1e-9);
        let slope = 0.3_f64.tan() * 4.0 / 3.0;
        let aside = DVec3::new(10.0, 20.0, 0.0);
        assert!((at(aside) - focal / 100.0 * (1.0_f64 + 0.01 + 0.04).sqrt()).abs() < 1e-9);
        // Behind, and nearer than the near plane: not seen. Beside the picture: as deep as it must be.
        assert_eq!(at(DVec3::Z * 101.0), 0.0);
        assert_eq!(at(DVec3::Z * 96.0), 0.0);
        assert!((at(DVec3::X * 1e3) - focal * (1.0 + slope * slope).sqrt() * slope / 1e3).abs() < 1e-9);
    }

    #[test]
    fn around_the_eye_it_is_finite() {
        let near = View { projection: Projection::Perspective { fov_y: 0.6, near: 0.0 }, ..VIEW };
        let place = BoundingBox { low: VIEW.eye - 10.0, high: VIEW.eye + 10.0 };
        let pixels = sight(&near, DAffine3::IDENTITY).pixels_per_length(&place);
        let focal = 300.0 / 0.3_f64.tan();
        assert!(pixels > focal && pixels < 2.0 * focal / (NEAREST * 17.3), "{pixels}");
        assert_eq!(sight(&near, DAffine3::IDENTITY).pixels_per_length(&BoundingBox::EMPTY), 0.0);
    }
}
