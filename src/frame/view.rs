//! A camera and deviations in pixels to tolerances in object space, one per part: the paper's object-to-screen factor
//! (section 3), taken where each part is nearest.

use super::plan::plan_parts;
use super::{Plan, PlanLimits, Tolerance};
use crate::mesh::{SceneInstance, ScenePart};
use crate::prepare::Prepared;
use glam::DVec3;

/// A part nearer than this fraction of its radius (or around the camera) is planned as if it were so far away: finer would
/// cost without end and show nothing but what is about to be passed.
const NEAREST: f64 = 0.02;

/// One perspective camera, and what it may show wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Where the camera is, world, millimetres.
    pub eye: DVec3,
    /// The full angle between the picture's top and bottom, radians, below π.
    pub fov_y: f64,
    /// Width and height of the picture in pixels, above 0.
    pub size: (u32, u32),
    /// Largest distance in the picture between triangles and exact surface, pixels, above 0.
    pub deviation_px: f64,
    /// Largest length in the picture of a cell's side or an edge's segment, pixels; `None` = no limit.
    pub size_px: Option<f64>,
    /// Largest turning of the normal across a cell, radians.
    pub angle: f64,
}

impl View {
    /// Length that covers a pixel at least anywhere in the picture, per distance from the eye.
    ///
    /// A length δ at distance d and angle θ off the axis covers at most `δ f / (d cos² θ)` pixels, with f the picture's height
    /// over `2 tan(fov/2)`; θ is largest in the corners.
    fn length_per_pixel_and_distance(&self) -> f64 {
        let (width, height) = (f64::from(self.size.0), f64::from(self.size.1));
        let slope = (0.5 * self.fov_y).tan();
        let corner_squared = slope * slope * (1.0 + (width / height).powi(2));
        2.0 * slope / height / (1.0 + corner_squared)
    }

    /// Tolerance for a part, in its own millimetres: the finest that any of its instances needs; `None` if it has none.
    fn tolerance(&self, part: &ScenePart, instances: &[&SceneInstance]) -> Option<Tolerance> {
        let reach = |instance: &&SceneInstance| {
            let scale = instance.scale();
            let centre = instance.transform.transform_point3(part.centre);
            // Distances in the part's own millimetres, as the tolerance is.
            (self.eye.distance(centre) / scale - part.radius).max(NEAREST * part.radius)
        };
        let distance = instances.iter().map(reach).min_by(f64::total_cmp)?;
        let pixel = self.length_per_pixel_and_distance() * distance;
        let usable = pixel.is_finite() && pixel > 0.0;
        usable.then(|| Tolerance {
            chord: self.deviation_px * pixel,
            angle: self.angle,
            max_edge: self.size_px.map(|size| size * pixel),
        })
    }
}

/// Rates for one camera: [`plan`](super::plan()) with a tolerance of its own for each part, and the same limits. Cost: as that.
///
/// Holds wherever the camera turns, since it depends on distances only. Parts that are not placed are planned as coarse
/// as angles allow.
#[must_use]
pub fn plan_for_view(prepared: &Prepared, view: &View) -> Plan {
    plan_for_view_within(prepared, view, &PlanLimits::DEFAULT)
}

/// The same within limits of the caller's.
#[must_use]
pub fn plan_for_view_within(prepared: &Prepared, view: &View, limits: &PlanLimits) -> Plan {
    let mut placed: Vec<Vec<&SceneInstance>> = vec![Vec::new(); prepared.parts.len()];
    for instance in &prepared.scene.instances {
        placed[instance.part as usize].push(instance);
    }
    let unseen = Tolerance { chord: f64::INFINITY, angle: view.angle, max_edge: None };
    let parts = prepared.scene.parts.iter().zip(&placed);
    let tolerances: Vec<Tolerance> =
        parts.map(|(part, instances)| view.tolerance(part, instances).unwrap_or(unseen)).collect();
    plan_parts(prepared, &tolerances, limits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::judge;
    use arbitrary::Unstructured;
    use glam::{DAffine3, DQuat};

    const VIEW: View = View {
        eye: DVec3::new(0.0, 0.0, 100.0),
        fov_y: 0.6,
        size: (800, 600),
        deviation_px: 0.5,
        size_px: Some(20.0),
        angle: 0.3,
    };

    fn part(radius: f64) -> ScenePart {
        ScenePart { radius, ..ScenePart::default() }
    }

    fn instance(transform: DAffine3) -> SceneInstance {
        SceneInstance { part: 0, transform, colour: None, name: String::new(), first_face: 0 }
    }

    fn tolerance(part: &ScenePart, transforms: &[DAffine3]) -> Tolerance {
        let instances: Vec<_> = transforms.iter().copied().map(instance).collect();
        let tolerance = VIEW.tolerance(part, &instances.iter().collect::<Vec<_>>());
        tolerance.unwrap_or_else(|| panic!("no tolerance for {part:?}"))
    }

    /// Pixels of a point's picture, the camera looking along -z.
    fn project(point: DVec3) -> [f64; 2] {
        let local = point - VIEW.eye;
        let focal = 0.5 * f64::from(VIEW.size.1) / (0.5 * VIEW.fov_y).tan();
        [focal * local.x / -local.z, focal * local.y / -local.z]
    }

    #[test]
    fn a_chord_anywhere_in_the_picture_covers_no_more_than_the_pixels_asked_for() {
        let sphere = part(10.0);
        let corner = DVec3::new(0.0, 0.0, 0.0);
        let Tolerance { chord, max_edge, .. } = tolerance(&sphere, &[DAffine3::from_translation(corner)]);
        assert!((max_edge.unwrap_or(0.0) / chord - 40.0).abs() < 1e-9, "size and deviation share one factor");
        let property = |u: &mut Unstructured<'_>| -> arbitrary::Result<()> {
            let mut unit = || Ok(f64::from(u.int_in_range(-1_000_000..=1_000_000_i32)?) * 1e-6);
            // A point of the picture, at any depth at least as far from the eye as the sphere is.
            let (x, y, depth) = (unit()?, unit()?, 2.0 + unit()?);
            let slope = (0.5 * VIEW.fov_y).tan();
            let ray = DVec3::new(x * slope * 4.0 / 3.0, y * slope, -1.0).normalize();
            let point = VIEW.eye + ray * (90.0 * depth.max(1.0));
            let step = DVec3::new(unit()?, unit()?, unit()?).normalize_or_zero() * chord;
            let (a, b) = (project(point), project(point + step));
            let pixels = (a[0] - b[0]).hypot(a[1] - b[1]);
            assert!(pixels <= 0.5 * (1.0 + 1e-3), "{pixels} pixels at {point} by {step}");
            Ok(())
        };
        judge!(20_000, 64, |bytes: &[u8]| property(&mut Unstructured::new(bytes)).is_ok());
    }

    #[test]
    fn the_nearest_instance_decides_and_scale_is_undone() {
        let far = DAffine3::from_translation(DVec3::Z * -100.0);
        let near = DAffine3::from_rotation_translation(DQuat::from_rotation_x(1.0), DVec3::Z * 50.0);
        let sphere = part(10.0);
        let [alone, both] = [tolerance(&sphere, &[far]), tolerance(&sphere, &[far, near])];
        assert!((alone.chord / both.chord - 190.0 / 40.0).abs() < 1e-9);
        // Ten times larger and as far in units of itself: the same tolerance in the part's own millimetres.
        let scaled = DAffine3 { translation: DVec3::Z * (100.0 - 500.0), ..DAffine3::from_scale(DVec3::splat(10.0)) };
        assert!((tolerance(&sphere, &[scaled]).chord / both.chord - 1.0).abs() < 1e-9);
        // Around the eye: finite.
        assert!(tolerance(&sphere, &[DAffine3::from_translation(VIEW.eye)]).chord > 0.0);
    }
}
