//! A camera and a box of a part -> pixels per millimetre, which turn screen-space error into an object-space tolerance.
//! This is the paper's object-to-screen factor (section 3), made conservative over boxes.
//!
//! The camera projects a point at depth z, at the angle θ off its axis, by (x/z, y/z). The largest singular value of
//! the Jacobian is 1/(z cos θ). Over a box it is at most the value at the box's least depth and widest angle. Boxes
//! are convex, so two points of a box are at most that factor times their distance apart in the image.

use crate::math::lanes::{larger, smaller};
use crate::math::sphere_tree::Sphere;
use crate::mesh::{SceneInstance, uniform_scale};
use crate::prepare::internals::BoundingBox;
use crate::view::{Projection, View};
use glam::{DAffine3, DVec3};

/// Least depth at which a box is planned, as a fraction of half its diagonal; it also applies to boxes around the
/// camera. Without it the cost of a box would be unbounded, for surface that the camera is about to pass.
const NEAREST: f64 = 0.05;

/// One camera in the coordinates of one instance.
#[derive(Clone, Debug)]
pub(crate) struct PartCamera {
    /// The camera's axes (right, up, forward), mapped to the part: their dot products with a point,
    axes: [DVec3; 3],
    /// plus this offset, are the point's camera coordinates.
    origin: DVec3,
    /// Scale of the instance.
    scale: f64,
    lens: SightLens,
}

/// Where a camera is and where it looks, in the coordinates of one instance: which surface shows its back.
#[derive(Clone, Debug)]
pub(crate) struct PartEye {
    place: DVec3,
    forward: DVec3,
    lens: SightLens,
}

/// Projection to pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SightLens {
    Perspective {
        /// Pixels per millimetre on the axis, at a depth of 1 mm.
        focal: f64,
        /// Tangents of half the horizontal and vertical field of view.
        slopes: [f64; 2],
        near: f64,
    },
    Orthographic {
        pixels_per_length: f64,
        /// Half of the image's width and height, millimetres.
        sides: [f64; 2],
    },
}

/// Pixels per millimetre of a box in the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PixelScale {
    /// Upper bound: [`PartCamera::pixels_per_length`].
    pub(crate) most: f64,
    /// Lower bound on `most` of any box inside this one.
    pub(crate) least: f64,
}

impl PixelScale {
    /// The larger of each pair: bounds over several images.
    pub(crate) fn max(self, other: Self) -> Self {
        Self { most: larger(other.most, self.most), least: larger(other.least, self.least) }
    }
}

impl PartCamera {
    /// Upper bound on the pixels per millimetre of the part within a box, where that is in the image. 0 for boxes
    /// nearer than the near plane or behind the camera.
    pub(crate) fn pixels_per_length(&self, place: &BoundingBox) -> f64 {
        self.pixels(self.placed(place))
    }

    /// As [`Self::pixels_per_length`], for centre and half extents of a box in camera coordinates.
    fn pixels(&self, (middle, reach): (DVec3, DVec3)) -> f64 {
        let (focal, slopes, near) = match self.lens {
            SightLens::Orthographic { pixels_per_length, .. } => return self.scale * pixels_per_length,
            SightLens::Perspective { focal, slopes, near } => (focal, slopes, near),
        };
        // An empty box of a table has a NaN centre.
        if middle.z + reach.z < near || middle.z + reach.z <= 0.0 || middle.is_nan() {
            return 0.0;
        }
        // A point off the axis is in the image only at depths where the frustum is wide enough.
        let entry = |axis: usize| (middle[axis].abs() - reach[axis]) / slopes[axis];
        let depth = larger(larger(middle.z - reach.z, near), larger(entry(0), entry(1)));
        let depth = larger(depth, NEAREST * reach.length());
        let per_depth = depth.recip();
        let slope = |axis: usize| smaller((middle[axis].abs() + reach[axis]) * per_depth, slopes[axis]);
        self.scale * focal * (1.0 + slope(0).powi(2) + slope(1).powi(2)).sqrt() * per_depth
    }

    /// Centre and half extents, in camera coordinates, of a box around a box of the part.
    fn placed(&self, place: &BoundingBox) -> (DVec3, DVec3) {
        let (centre, half) = (0.5 * (place.low + place.high), 0.5 * (place.high - place.low));
        let middle = DVec3::from(self.axes.map(|axis| axis.dot(centre))) + self.origin;
        (middle, DVec3::from(self.axes.map(|axis| axis.abs().dot(half))))
    }

    /// Pixels per millimetre of a box; `None` if the box is certainly outside the view frustum.
    pub(crate) fn look(&self, place: &BoundingBox) -> Option<PixelScale> {
        let (middle, reach) = self.placed(place);
        let is_off = |axis: usize, side: f64| middle[axis].abs() - reach[axis] > side;
        match self.lens {
            SightLens::Orthographic { sides, .. } => {
                let outside = is_off(0, sides[0]) || is_off(1, sides[1]) || middle.is_nan();
                (!outside).then(|| self.scales((middle, reach)))
            }
            SightLens::Perspective { slopes, .. } => {
                let furthest = middle.z + reach.z;
                let outside = is_off(0, slopes[0] * furthest) || is_off(1, slopes[1] * furthest);
                if outside { None } else { Some(self.scales((middle, reach))).filter(|scale| scale.most > 0.0) }
            }
        }
    }

    /// Bounds on what [`look`](Self::look) finds for every box within a box, if it certainly finds all of them.
    pub(crate) fn look_within(&self, place: &BoundingBox) -> Option<PixelScale> {
        /// Share of a scale or a coordinate, for rounding.
        const ROUNDING: f64 = 1e-9;
        /// The same of the numbers that cancel in the coordinates of what is near the camera.
        const CANCELLED: f64 = 1e-12;
        /// How many times the depth these may be, for the scale to be as good.
        const FAR: f64 = 1e5;
        let (middle, reach) = self.placed(place);
        let corner = place.low.abs().max(place.high.abs());
        let terms = self.origin.abs().max_element() + self.axes[2].abs().element_sum() * corner.element_sum();
        let error = ROUNDING * (middle.abs() + reach) + CANCELLED * terms;
        let furthest = middle.abs() + reach + error;
        let is_inside = match self.lens {
            SightLens::Orthographic { sides, .. } => furthest.x < sides[0] && furthest.y < sides[1],
            SightLens::Perspective { slopes, near, .. } => {
                let nearest = middle.z - reach.z - error.z;
                let in_front = nearest > near && terms < FAR * nearest;
                // Of a box so long, one inside may be planned at a smaller depth.
                let is_short = nearest > NEAREST * reach.length();
                in_front && is_short && furthest.x < slopes[0] * nearest && furthest.y < slopes[1] * nearest
            }
        };
        is_inside.then(|| {
            let PixelScale { most, least } = self.scales((middle, reach));
            PixelScale { most: most * (1.0 + ROUNDING), least: least * (1.0 - ROUNDING) }
        })
    }

    /// Pixels per millimetre of a box, wherever it is.
    pub(crate) fn pixel_scale(&self, place: &BoundingBox) -> PixelScale {
        self.scales(self.placed(place))
    }

    fn scales(&self, (middle, reach): (DVec3, DVec3)) -> PixelScale {
        let most = self.pixels((middle, reach));
        let (focal, slopes, near) = match self.lens {
            SightLens::Orthographic { .. } => return PixelScale { most, least: most },
            SightLens::Perspective { focal, slopes, near } => (focal, slopes, near),
        };
        if most == 0.0 || middle.z - reach.z < near {
            return PixelScale { most, least: 0.0 };
        }
        // Largest depth and least slopes that `pixels` can use for a box inside this one.
        let aside = |axis: usize| (middle[axis].abs() + reach[axis]) / slopes[axis];
        let depth = larger(larger(aside(0), aside(1)), larger(middle.z + reach.z, NEAREST * reach.length()));
        let per_depth = depth.recip();
        let slope = |axis: usize| smaller(larger(middle[axis].abs() - reach[axis], 0.0) * per_depth, slopes[axis]);
        let least = self.scale * focal * (1.0 + slope(0).powi(2) + slope(1).powi(2)).sqrt() * per_depth;
        PixelScale { most, least }
    }

    /// The same camera with screen-space errors weighted by `by`.
    pub(crate) fn weighed(self, by: f64) -> Self {
        Self { scale: self.scale * by, ..self }
    }
}

impl PartEye {
    /// Whether a surface within a box is back-facing everywhere, if its outward normals are within `half_angle` of
    /// `axis` (part coordinates, unit length). True for any instance transform: none moves the eye to the other
    /// side of a plane.
    pub(crate) fn sees_back(&self, place: &BoundingBox, axis: DVec3, half_angle: f64) -> bool {
        let (centre, radius) = (0.5 * (place.low + place.high), 0.5 * place.high.distance(place.low));
        let (line, spread) = match self.lens {
            SightLens::Orthographic { .. } => (self.forward, 0.0),
            SightLens::Perspective { .. } => {
                let line = centre - self.place;
                (line, libm::asin((radius / line.length()).min(1.0)))
            }
        };
        let allowed = std::f64::consts::FRAC_PI_2 - half_angle - spread;
        allowed > 0.0 && line.dot(axis) > line.length() * libm::cos(allowed)
    }
}

/// A sphere around a box of an instance. All of space if the box is empty or not finite.
pub(crate) fn sphere_around(place: &BoundingBox, transform: &DAffine3) -> Sphere {
    /// Share of the radius by which the sphere is enlarged, for scales that are not quite uniform.
    const UNEVEN: f64 = 1e-3;
    let centre = transform.transform_point3(0.5 * (place.low + place.high));
    let scale = transform.matrix3.x_axis.length_squared().max(transform.matrix3.y_axis.length_squared()).sqrt();
    Sphere::new(centre, 0.5 * place.high.distance(place.low) * scale * (1.0 + UNEVEN))
}

impl View {
    /// Axes (right, up, forward) and projection; `None` if the view is invalid.
    pub(crate) fn lens(&self) -> Option<([DVec3; 3], SightLens)> {
        self.check_camera().ok()?;
        let (width, height) = (f64::from(self.size.0), f64::from(self.size.1));
        let aspect = width / height;
        let lens = match self.camera.projection {
            Projection::Perspective { fov_y, near } => {
                let slope = libm::tan(0.5 * fov_y);
                SightLens::Perspective { focal: 0.5 * height / slope, slopes: [slope * aspect, slope], near }
            }
            Projection::Orthographic { height: shown } => {
                let pixels_per_length = height / shown;
                SightLens::Orthographic { pixels_per_length, sides: [0.5 * shown * aspect, 0.5 * shown] }
            }
        };
        Some((self.camera.frame()?, lens))
    }

    /// As [`Self::lens`]; `None` too if a limit of the screen-space error is not above 0.
    pub(crate) fn usable_lens(&self) -> Option<([DVec3; 3], SightLens)> {
        self.check().ok()?;
        self.lens()
    }

    /// Whether anything within a sphere may be in the view frustum. Never false for a sphere that contains one for
    /// which it is true.
    pub(crate) fn may_show(&self, (axes, lens): ([DVec3; 3], SightLens), sphere: &Sphere) -> bool {
        /// Share of the distance from the eye, for rounding.
        const ROUNDING: f64 = 1e-9;
        let centre = sphere.centre - self.camera.eye;
        let radius = sphere.radius + ROUNDING * (centre.length() + sphere.radius);
        let [x, y, z] = axes.map(|axis| axis.dot(centre));
        let off = match lens {
            SightLens::Orthographic { sides, .. } => x.abs() - radius > sides[0] || y.abs() - radius > sides[1],
            SightLens::Perspective { slopes, .. } => {
                // The distance from the plane of a side is this over the length of the plane's normal.
                let beyond = |x: f64, slope: f64| x.abs() - slope * z > radius * (1.0 + slope * slope).sqrt();
                z < -radius || beyond(x, slopes[0]) || beyond(y, slopes[1])
            }
        };
        !off
    }

    /// This camera in the coordinates of an instance with this transform.
    pub(crate) fn sight(&self, (axes, lens): ([DVec3; 3], SightLens), transform: &DAffine3) -> PartCamera {
        let to_part = transform.matrix3.transpose();
        let place = transform.translation - self.camera.eye;
        let origin = DVec3::from(axes.map(|axis| axis.dot(place)));
        PartCamera { axes: axes.map(|axis| to_part * axis), origin, scale: uniform_scale(transform), lens }
    }

    /// Where this camera is in the coordinates of an instance.
    pub(crate) fn eye(&self, ([.., forward], lens): ([DVec3; 3], SightLens), instance: &SceneInstance) -> PartEye {
        let back = instance.transform.inverse();
        PartEye { place: back.transform_point3(self.camera.eye), forward: back.transform_vector3(forward), lens }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::judge;
    use crate::sequence::random::SplitMix;
    use crate::view::Camera;
    use arbitrary::Unstructured;
    use glam::DQuat;

    const CAMERA: Camera = Camera {
        eye: DVec3::new(0.0, 0.0, 100.0),
        forward: DVec3::NEG_Z,
        up: DVec3::Y,
        projection: Projection::Perspective { fov_y: 0.6, near: 5.0 },
    };

    const VIEW: View = View { camera: CAMERA, size: (800, 600), deviation_px: 0.5, size_px: None, angle: 0.3 };

    fn sight(view: &View, transform: DAffine3) -> PartCamera {
        let lens = view.lens().unwrap_or_else(|| panic!("invalid view: {view:?}"));
        view.sight(lens, &transform)
    }

    /// Projection of a point, pixels.
    fn project(point: DVec3) -> [f64; 2] {
        let local = point - CAMERA.eye;
        let focal = 0.5 * f64::from(VIEW.size.1) / 0.3_f64.tan();
        [focal * local.x / -local.z, focal * local.y / -local.z]
    }

    #[test]
    fn pixels_per_length_bounds_distances_in_the_image() {
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
                let depth = |p: DVec3| CAMERA.eye.z - p.z * scale;
                if depth(p).min(depth(q)) < 5.0 || !shown(a) || !shown(b) {
                    continue;
                }
                let (pixels, length) = ((a[0] - b[0]).hypot(a[1] - b[1]), p.distance(q));
                assert!(
                    pixels <= most * length * (1.0 + 1e-9),
                    "{pixels} pixels exceed the bound of {} in {place:?}",
                    most * length
                );
            }
            Ok(())
        };
        judge!(5_000, 600, |bytes: &[u8]| property(&mut Unstructured::new(bytes)).is_ok());
    }

    #[test]
    fn boxes_inside_a_box_are_within_its_scales() {
        let (mut draw, mut close, mut within) = (SplitMix(11), 0, 0);
        for _ in 0..20_000 {
            let mut vector = |size: f64| DVec3::from([0; 3].map(|_| draw.range(-size, size)));
            let (centre, half) = (vector(80.0), vector(12.0).abs());
            let (from, to) = (vector(1.0), vector(1.0));
            let place = BoundingBox { low: centre - half, high: centre + half };
            let inner = BoundingBox { low: centre + half * from.min(to), high: centre + half * from.max(to) };
            for projection in [CAMERA.projection, Projection::Orthographic { height: 150.0 }] {
                let view = View { camera: Camera { projection, ..CAMERA }, ..VIEW };
                let camera = sight(&view, DAffine3::from_scale(DVec3::splat(1.5)));
                let (PixelScale { most, least }, inside) =
                    (camera.pixel_scale(&place), camera.pixels_per_length(&inner));
                let rounding = 1e-9 * most;
                assert!(least - rounding <= inside && inside <= most + rounding, "{least} {inside} {most} {place:?}");
                close += usize::from(least > 0.8 * most);
                if let Some(PixelScale { most, least }) = camera.look_within(&place) {
                    let inner = camera.look(&inner).expect("in the frustum");
                    assert!(least <= inner.least && inner.most <= most, "{least} {inner:?} {most} {place:?}");
                    within += 1;
                }
            }
        }
        assert!(close > 21_000 && within > 5_000, "{close} {within}");
    }

    #[test]
    fn no_sphere_hides_a_box_that_is_seen() {
        let (mut hidden, mut shown, mut draw) = (0, 0, SplitMix(3));
        for _ in 0..10_000 {
            let mut vector = |size: f64| DVec3::from([0; 3].map(|_| draw.range(-size, size)));
            let (centre, half) = (vector(100.0), vector(1.0).abs());
            let place = BoundingBox { low: centre - half, high: centre + half };
            let (turn, scale) = (DQuat::from_scaled_axis(vector(3.0)), DVec3::splat(1.5 + vector(1.0).x));
            let placed = DAffine3::from_scale_rotation_translation(scale, turn, vector(300.0));
            for projection in [CAMERA.projection, Projection::Orthographic { height: 150.0 }] {
                let view = View { camera: Camera { projection, ..CAMERA }, ..VIEW };
                let may = view.may_show(view.lens().expect("a valid view"), &sphere_around(&place, &placed));
                let is_seen = sight(&view, placed).look(&place).is_some();
                assert!(may || !is_seen, "{place:?} {placed:?}");
                (hidden, shown) = (hidden + usize::from(!may), shown + usize::from(is_seen));
            }
        }
        assert!(hidden > 1000 && shown > 1000, "{hidden} {shown}");
    }

    #[test]
    fn small_boxes_have_the_scale_of_their_centre() {
        let at = |p: DVec3| sight(&VIEW, DAffine3::IDENTITY).pixels_per_length(&BoundingBox { low: p, high: p });
        let focal = 300.0 / 0.3_f64.tan();
        assert!((at(DVec3::ZERO) - focal / 100.0).abs() < 1e-9);
        let slope = 0.3_f64.tan() * 4.0 / 3.0;
        let aside = DVec3::new(10.0, 20.0, 0.0);
        assert!((at(aside) - focal / 100.0 * (1.0_f64 + 0.01 + 0.04).sqrt()).abs() < 1e-9);
        // Behind the camera and nearer than the near plane: 0. Off-screen: as deep as the frustum has to be.
        assert_eq!(at(DVec3::Z * 101.0), 0.0);
        assert_eq!(at(DVec3::Z * 96.0), 0.0);
        assert!((at(DVec3::X * 1e3) - focal * (1.0 + slope * slope).sqrt() * slope / 1e3).abs() < 1e-9);
    }

    #[test]
    fn boxes_around_the_eye_have_a_finite_scale() {
        let projection = Projection::Perspective { fov_y: 0.6, near: 0.0 };
        let near = View { camera: Camera { projection, ..CAMERA }, ..VIEW };
        let place = BoundingBox { low: CAMERA.eye - 10.0, high: CAMERA.eye + 10.0 };
        let pixels = sight(&near, DAffine3::IDENTITY).pixels_per_length(&place);
        let focal = 300.0 / 0.3_f64.tan();
        assert!(pixels > focal && pixels < 2.0 * focal / (NEAREST * 17.3), "{pixels}");
        assert_eq!(sight(&near, DAffine3::IDENTITY).pixels_per_length(&BoundingBox::EMPTY), 0.0);
    }
}
