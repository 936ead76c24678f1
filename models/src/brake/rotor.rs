//! Dimensions -> a ventilated brake disc: two friction rings with drilled channels and curved vanes between them, and a
//! bell.

use super::body::{Body, SideId};
use super::path::Path;
use super::{BOLT_CIRCLE, BOLTS, CAST};
use glam::DVec2;
use std::f64::consts::{PI, TAU};
use trimtess::model::{Frame3, Part};

/// Radius of the disc.
pub(super) const RADIUS: f64 = 150.0;
/// Heights of the friction faces and of the faces between them.
pub(super) const FACES: [f64; 4] = [0.0, 8.0, 20.0, 28.0];
/// Heights of the bell's inner and outer face.
pub(super) const BELL: [f64; 2] = [52.0, 60.0];
/// Radius of the bore in the bell.
pub(super) const BORE: f64 = 34.0;
const VANES: u32 = 36;
/// Radius of the fillets where vanes meet the rings.
const ROOT: f64 = 2.0;
/// Half the thickness of a vane.
const HALF: f64 = 2.5;
/// Distances of the drilled holes of a channel from the axis.
const DRILLED: [f64; 3] = [112.0, 126.0, 140.0];

/// The rotor about z, with the inboard friction face in the plane z = 0 and the bell above.
pub(crate) fn rotor() -> Part {
    let mut body = Body::new("brake rotor", CAST);
    let frame = Frame3::WORLD;
    let [low, inner, upper, high] = FACES;
    let ring = Path::closed(&[(88.0, low, 1.5), (RADIUS, low, 1.0), (RADIUS, inner, 1.0), (88.0, inner, 1.0)]);
    let sides = body.turn(&frame, &ring).sides;
    let side_at = |sides: &[SideId], path: &Path, r, z| sides[path.piece_through(r, z)];
    let inboard = [side_at(&sides, &ring, 120.0, inner), side_at(&sides, &ring, 120.0, low)];

    let [inside, outside] = BELL;
    let bell = Path::closed(&[
        (71.0, upper, 1.0),
        (RADIUS, upper, 1.0),
        (RADIUS, high, 1.0),
        (78.0, high, 6.0),
        (78.0, outside, 6.0),
        (BORE, outside, 1.0),
        (BORE, inside, 1.0),
        (71.0, inside, 3.0),
    ]);
    let sides = body.turn(&frame, &bell).sides;
    let outboard = [side_at(&sides, &bell, 120.0, high), side_at(&sides, &bell, 120.0, upper)];
    let mount = [side_at(&sides, &bell, 50.0, outside), side_at(&sides, &bell, 50.0, inside)];

    vanes(&mut body, [inboard[0], outboard[1]]);
    channels(&mut body, inboard, outboard);
    mounting(&mut body, mount);
    body.finish()
}

/// The centre line of a vane: centre of its arc, its ends, and the angle between them.
fn camber() -> (DVec2, [DVec2; 2], f64) {
    const CURVATURE: f64 = 80.0;
    let ends = [DVec2::new(95.0, 0.0), DVec2::from_angle(0.2) * 143.0];
    let chord = ends[1] - ends[0];
    let sagitta = (CURVATURE * CURVATURE - 0.25 * chord.length_squared()).sqrt();
    let centre = 0.5 * (ends[0] + ends[1]) + chord.perp().normalize() * sagitta;
    (centre, ends, (ends[0] - centre).angle_to(ends[1] - centre))
}

/// Adds the vanes between the faces below and above them.
fn vanes(body: &mut Body, [below, above]: [SideId; 2]) {
    let (centre, ends, turn) = camber();
    let mut outline = Path::from(ends[0] + (ends[0] - centre).normalize() * HALF);
    outline.arc(centre, turn).arc(ends[1], PI).arc(centre, -turn).arc(ends[0], PI);
    let outline = outline.close();
    let [_, low, high, _] = FACES;
    let profile = Path::open(&[(ROOT, low, 0.0), (0.0, low, ROOT), (0.0, high, ROOT), (ROOT, high, 0.0)]);
    for k in 0..VANES {
        let outline = outline.turned(TAU * f64::from(k) / f64::from(VANES));
        let mut vane = body.sweep(&Frame3::WORLD, &outline, &profile);
        body.join(&mut vane, Some(below), Some(above));
    }
}

/// Adds the drilled holes through both friction rings, in the middle of the channels between the vanes. Each ring is
/// given by its two faces, upper face first.
fn channels(body: &mut Body, inboard: [SideId; 2], outboard: [SideId; 2]) {
    const HOLE: f64 = 3.0;
    const CHAMFER: f64 = 1.0;
    let (centre, ends, _) = camber();
    let [low, inner, upper, high] = FACES;
    let from_below = Path::open(&[(HOLE, inner, 0.0), (HOLE, low + CHAMFER, 0.0), (HOLE + CHAMFER, low, 0.0)]);
    let from_above = Path::open(&[(HOLE + CHAMFER, high, 0.0), (HOLE, high - CHAMFER, 0.0), (HOLE, upper, 0.0)]);
    for radius in DRILLED {
        // The point of the centre line at this radius: a triangle of known sides with the axis and the arc's centre.
        let (far, arm) = (centre.length(), centre.distance(ends[0]));
        let cosine = (radius * radius + far * far - arm * arm) / (2.0 * radius * far);
        let middle = centre.to_angle() - cosine.acos();
        for k in 0..VANES {
            let angle = middle + TAU * (f64::from(k) + 0.5) / f64::from(VANES);
            let frame = Frame3 { origin: (DVec2::from_angle(angle) * radius).extend(0.0), ..Frame3::WORLD };
            for (path, [start, end]) in [(&from_below, inboard), (&from_above, outboard)] {
                let mut hole = body.turn(&frame, path);
                body.join(&mut hole, Some(start), Some(end));
            }
        }
    }
}

/// Adds the holes in the bell: for the wheel bolts, for two screws that hold the rotor, and windows between the bolts.
fn mounting(body: &mut Body, [outside, inside]: [SideId; 2]) {
    let [low, high] = BELL;
    let frame =
        |radius: f64, angle: f64| Frame3 { origin: (DVec2::from_angle(angle) * radius).extend(0.0), ..Frame3::WORLD };
    let step = TAU / f64::from(BOLTS);
    let bolt = Path::open(&[(7.0, high, 0.0), (6.5, high - 0.5, 0.0), (6.5, low + 0.5, 0.0), (7.0, low, 0.0)]);
    let screw = Path::open(&[(6.0, high, 0.0), (3.2, high - 2.8, 0.0), (3.2, low, 0.0)]);
    for k in 0..BOLTS {
        let mut hole = body.turn(&frame(BOLT_CIRCLE, step * f64::from(k)), &bolt);
        body.join(&mut hole, Some(outside), Some(inside));
    }
    for angle in [0.5 * step, 0.5 * step + 2.0 * step] {
        let mut hole = body.turn(&frame(BOLT_CIRCLE, angle), &screw);
        body.join(&mut hole, Some(outside), Some(inside));
    }
    // Windows with spline outlines, clockwise because the material is outside.
    let window: Vec<DVec2> = [(-9.0, -6.0), (9.0, -6.0), (14.0, 4.0), (5.0, 9.0), (-5.0, 9.0), (-14.0, 4.0)]
        .map(|(x, y)| DVec2::new(BOLT_CIRCLE + y, x))
        .to_vec();
    let mut through = Path::from((0.0, low));
    through.line((0.0, high));
    for k in [1, 3, 4] {
        let outline = Path::spline(&window).turned(step * (f64::from(k) + 0.5));
        let mut hole = body.sweep(&Frame3::WORLD, &outline, &through);
        body.join(&mut hole, Some(inside), Some(outside));
    }
}
