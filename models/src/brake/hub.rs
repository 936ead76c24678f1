//! Dimensions -> a wheel hub: a lobed flange for the bolts on a turned body with a splined bore and a toothed ring.

use super::body::Body;
use super::path::Path;
use super::rotor::{BELL, BORE};
use super::{BOLT_CIRCLE, BOLTS, FORGED};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use trimtess::model::{Frame3, Part};

/// Heights of the ends of the hub.
const ENDS: [f64; 2] = [-12.0, 66.0];
/// Heights of the flange, which carries the bell of the rotor.
pub(super) const FLANGE: [f64; 2] = [40.0, BELL[0]];
/// Heights of the toothed ring.
const TEETH: [f64; 2] = [20.0, 26.0];
/// Height of the floor of the recess for the axle's nut.
const FLOOR: f64 = 58.0;
/// Radius of the body between the toothed ring and the flange.
const NECK: f64 = 33.0;
/// Radius of the end that centres the rotor's bell.
const PILOT: f64 = BORE - 0.05;

/// The hub about z.
pub(crate) fn hub() -> Part {
    let mut body = Body::new("brake hub", FORGED);
    let frame = Frame3::WORLD;
    let plane = |body: &mut Body, z: f64, outwards: DVec3| body.flat(DVec3::Z * z, outwards);
    let [ring_top, flange_top, end_top, floor] =
        [TEETH[1], FLANGE[1], ENDS[1], FLOOR].map(|z| plane(&mut body, z, DVec3::Z));
    let [end_low, ring_low, flange_low] = [ENDS[0], TEETH[0], FLANGE[0]].map(|z| plane(&mut body, z, DVec3::NEG_Z));

    // From the inner end to the toothed ring: a chamfer, the bearing seat, a free-form shoulder.
    let mut seat = Path::from((26.5, ENDS[0]));
    seat.line((28.0, ENDS[0] + 1.5)).line((28.0, 4.0));
    seat.cubic([(28.0, 9.0), (NECK, 9.0)], (NECK, 14.0)).line((NECK, TEETH[0]));
    let mut seat = body.turn(&frame, &seat);
    body.join(&mut seat, Some(end_low), Some(ring_low));

    let neck = Path::open(&[
        (NECK + 1.0, TEETH[1], 0.0),
        (NECK, TEETH[1], 1.0),
        (NECK, FLANGE[0], 5.0),
        (NECK + 5.0, FLANGE[0], 0.0),
    ]);
    let mut neck = body.turn(&frame, &neck);
    body.join(&mut neck, Some(ring_top), Some(flange_low));

    let pilot = Path::open(&[(PILOT, FLANGE[1], 0.0), (PILOT, ENDS[1] - 1.5, 0.0), (PILOT - 1.5, ENDS[1], 0.0)]);
    let mut pilot = body.turn(&frame, &pilot);
    body.join(&mut pilot, Some(flange_top), Some(end_top));

    // The recess for the axle's nut.
    let recess =
        Path::open(&[(25.0, ENDS[1], 0.0), (24.0, ENDS[1] - 1.0, 0.0), (24.0, FLOOR, 2.0), (22.0, FLOOR, 0.0)]);
    let mut recess = body.turn(&frame, &recess);
    body.join(&mut recess, Some(end_top), Some(floor));

    let mut through = Path::from((0.0, ENDS[0]));
    through.line((0.0, FLOOR));
    let mut splines = body.sweep(&frame, &gear(30, [16.5, 18.0], [0.2, 0.35]).reversed(), &through);
    body.join(&mut splines, Some(end_low), Some(floor));

    let mut across = Path::from((0.0, TEETH[0]));
    across.line((0.0, TEETH[1]));
    let mut teeth = body.sweep(&frame, &gear(48, [37.0, 40.0], [0.25, 0.25]), &across);
    body.join(&mut teeth, Some(ring_low), Some(ring_top));

    let rim =
        Path::open(&[(-2.0, FLANGE[0], 0.0), (0.0, FLANGE[0], 2.0), (0.0, FLANGE[1], 2.0), (-2.0, FLANGE[1], 0.0)]);
    let mut rim = body.sweep(&frame, &lobes(), &rim);
    body.join(&mut rim, Some(flange_low), Some(flange_top));

    let hole = Path::open(&[
        (7.0, FLANGE[1], 0.0),
        (6.2, FLANGE[1] - 0.8, 0.0),
        (6.2, FLANGE[0] + 0.8, 0.0),
        (7.0, FLANGE[0], 0.0),
    ]);
    for k in 0..BOLTS {
        let place = DVec2::from_angle(TAU * f64::from(k) / f64::from(BOLTS)) * BOLT_CIRCLE;
        let frame = Frame3 { origin: place.extend(0.0), ..frame };
        let mut hole = body.turn(&frame, &hole);
        body.join(&mut hole, Some(flange_top), Some(flange_low));
    }
    body.finish()
}

/// The outline of a gear, counter-clockwise: straight flanks, and arcs at tips and feet with these fractions of a
/// pitch.
fn gear(count: u32, [foot, tip]: [f64; 2], shares: [f64; 2]) -> Path {
    let pitch = TAU / f64::from(count);
    let [crest, gap] = shares.map(|share| share * pitch);
    let flank = 0.5 * (pitch - crest - gap);
    let at = |angle: f64, radius: f64| DVec2::from_angle(angle) * radius;
    let mut path = Path::from(at(0.0, tip));
    for k in 0..count {
        let start = pitch * f64::from(k);
        path.arc((0.0, 0.0), crest);
        path.line(at(start + crest + flank, foot));
        path.arc((0.0, 0.0), gap);
        path.line(at(start + pitch, tip));
    }
    path.close()
}

/// The outline of the flange: an arc around each bolt, joined tangentially by arcs between the bolts.
fn lobes() -> Path {
    const LOBE: f64 = 11.0;
    const WAIST: f64 = 42.0;
    let step = TAU / f64::from(BOLTS);
    // The arc between two bolts has its centre at distance d and radius d - WAIST, and touches the bolt's circle of
    // radius LOBE: (d - WAIST + LOBE)² = d² + BOLT_CIRCLE² - 2 d BOLT_CIRCLE cos(step / 2).
    let slack = WAIST - LOBE;
    let far = (BOLT_CIRCLE * BOLT_CIRCLE - slack * slack) / (2.0 * (BOLT_CIRCLE * (0.5 * step).cos() - slack));
    let bolt = |k: f64| DVec2::from_angle(step * k) * BOLT_CIRCLE;
    let between = |k: f64| DVec2::from_angle(step * (k + 0.5)) * far;
    // End of the arc before a bolt.
    let touch = |k: f64| bolt(k) + (between(k - 1.0) - bolt(k)).normalize() * LOBE;
    let mut path = Path::from(touch(0.0));
    let turn_at = |centre: DVec2, from: DVec2, to: DVec2| (from - centre).angle_to(to - centre);
    for k in 0..BOLTS {
        let k = f64::from(k);
        let leave = bolt(k) + (between(k) - bolt(k)).normalize() * LOBE;
        path.arc(bolt(k), turn_at(bolt(k), touch(k), leave).rem_euclid(2.0 * PI));
        path.arc(between(k), turn_at(between(k), leave, touch(k + 1.0)));
    }
    path.close()
}
