//! Dimensions -> a caliper around the rotor's edge with bores for four pistons, a piston, and a pad.

use super::body::{Body, SideId};
use super::path::Path;
use super::rotor::FACES;
use super::{CAST_PAINTED, LINING, STEEL};
use glam::DVec3;
use trimtess::model::{Frame3, Part};

/// Thicknesses outwards from the rotor's faces: lining, its plate, gap to the caliper.
pub(super) const LINING_DEPTH: f64 = 10.0;
pub(super) const PLATE: f64 = 6.0;
const GAP: f64 = 1.0;
/// Heights of the arms' inner faces, which are towards the rotor.
const ARMS: [f64; 2] = [FACES[0] - LINING_DEPTH - PLATE - GAP, FACES[3] + LINING_DEPTH + PLATE + GAP];
/// Heights of the arms' outer faces.
pub(super) const OUTER: [f64; 2] = [ARMS[0] - 32.0, ARMS[1] + 30.0];
/// Position of the pistons (distance from the rotor's axis along x, and along y), and their radius.
pub(super) const PISTONS: [f64; 2] = [123.0, 26.0];
const PISTON: f64 = 19.0;
/// Position of the caliper bolts: distance from the rotor's axis along x, and along y.
pub(super) const SCREWS: [f64; 2] = [166.0, 40.0];
/// Depth of the counterbores for their heads.
pub(super) const SUNK: f64 = 4.0;

/// The caliper around the rotor's edge in the x direction: two arms, joined by two bridges with fillets.
pub(super) fn caliper() -> Part {
    const ROOT: f64 = 3.0;
    let mut body = Body::new("caliper", CAST_PAINTED);
    let frame = Frame3::WORLD;
    let arm = Path::closed(&[
        (97.0, -46.0, 8.0),
        (150.0, -66.0, 16.0),
        (180.0, -50.0, 16.0),
        (188.0, 0.0, 80.0),
        (180.0, 50.0, 16.0),
        (150.0, 66.0, 16.0),
        (97.0, 46.0, 8.0),
    ]);
    let [outer, inner] = [(OUTER, [DVec3::NEG_Z, DVec3::Z]), (ARMS, [DVec3::Z, DVec3::NEG_Z])]
        .map(|(heights, outwards)| [0, 1].map(|k| body.flat(DVec3::Z * heights[k], outwards[k])));
    for k in 0..2 {
        // The profile runs upwards: from the outer face of the lower arm, from the inner face of the upper one.
        let (low, high) = if k == 0 { (OUTER[0], ARMS[0]) } else { (ARMS[1], OUTER[1]) };
        let (below, above) = if k == 0 { (outer[0], inner[0]) } else { (inner[1], outer[1]) };
        let [foot, head] = if k == 0 { [6.0, 2.0] } else { [2.0, 6.0] };
        let rim = Path::open(&[(-foot, low, 0.0), (0.0, low, foot), (0.0, high, head), (-head, high, 0.0)]);
        let mut rim = body.sweep(&frame, &arm, &rim);
        body.join(&mut rim, Some(below), Some(above));
    }
    let [low, high] = ARMS;
    let side = Path::open(&[(ROOT, low, 0.0), (0.0, low, ROOT), (0.0, high, ROOT), (ROOT, high, 0.0)]);
    for sign in [1.0, -1.0] {
        let corners = [(157.0, 26.0, 6.0), (176.0, 26.0, 6.0), (172.0, 48.0, 6.0), (157.0, 54.0, 6.0)];
        let mut corners = corners.map(|(x, y, radius)| (x, sign * y, radius));
        if sign < 0.0 {
            corners.reverse();
        }
        let mut bridge = body.sweep(&frame, &Path::closed(&corners), &side);
        body.join(&mut bridge, Some(inner[0]), Some(inner[1]));
    }
    for (arm, z, up) in [(inner[0], low, 1.0), (inner[1], high, -1.0)] {
        for y in [-PISTONS[1], PISTONS[1]] {
            bore(&mut body, DVec3::new(PISTONS[0], y, z), up, arm);
        }
    }
    screws(&mut body, outer);
    body.finish()
}

/// A blind bore for a piston, with a groove for its seal.
fn bore(body: &mut Body, mouth: DVec3, up: f64, arm: SideId) {
    let frame = Frame3 { origin: mouth, x: DVec3::X, y: DVec3::Y * up, z: DVec3::Z * up };
    let path = Path::open(&[
        (PISTON + 1.0, 0.0, 0.0),
        (PISTON, -1.0, 0.0),
        (PISTON, -5.0, 0.0),
        (PISTON + 2.5, -5.0, 0.0),
        (PISTON + 2.5, -8.0, 0.0),
        (PISTON, -8.0, 0.0),
        (PISTON, -24.0, 2.0),
        (0.0, -24.0, 0.0),
    ]);
    let mut hole = body.turn(&frame, &path);
    body.join(&mut hole, Some(arm), None);
}

/// Bolt holes through the bridges along the rotor's axis, from the outer face of one arm to that of the other.
fn screws(body: &mut Body, [below, above]: [SideId; 2]) {
    const HOLE: f64 = 5.25;
    const SEAT: f64 = 9.0;
    let [low, high] = OUTER;
    let path = Path::open(&[
        (SEAT, high, 0.0),
        (SEAT, high - SUNK, 0.0),
        (HOLE, high - SUNK, 0.0),
        (HOLE, low + 1.0, 0.0),
        (HOLE + 1.0, low, 0.0),
    ]);
    for y in [-SCREWS[1], SCREWS[1]] {
        let frame = Frame3 { origin: DVec3::new(SCREWS[0], y, 0.0), ..Frame3::WORLD };
        let mut hole = body.turn(&frame, &path);
        body.join(&mut hole, Some(above), Some(below));
    }
}

/// A piston along z, with its mouth in the plane z = 0 and its body below.
pub(super) fn piston() -> Part {
    const OUT: f64 = PISTON - 0.05;
    let mut body = Body::new("piston", STEEL);
    let path = Path::open(&[
        (0.0, -22.0, 0.0),
        (OUT, -22.0, 2.0),
        (OUT, -5.0, 0.0),
        (OUT - 1.5, -5.0, 0.5),
        (OUT - 1.5, -3.0, 0.5),
        (OUT, -3.0, 0.0),
        (OUT, 0.0, 1.0),
        (13.0, 0.0, 0.5),
        (13.0, -16.0, 3.0),
        (0.0, -16.0, 0.0),
    ]);
    body.turn(&Frame3::WORLD, &path);
    body.finish()
}

/// The pad below the rotor's face z = 0: two blocks of lining on a plate.
pub(super) fn pad() -> Part {
    const CHAMFER: f64 = 1.5;
    let mut body = Body::new("pad", STEEL);
    let [back, front] = [-LINING_DEPTH - PLATE, -LINING_DEPTH];
    let plate = Path::closed(&[(98.0, -38.0, 6.0), (140.0, -48.0, 6.0), (140.0, 48.0, 6.0), (98.0, 38.0, 6.0)]);
    let rim = Path::open(&[(-1.0, back, 0.0), (0.0, back, 1.0), (0.0, front, 1.0), (-1.0, front, 0.0)]);
    let ends = [body.flat(DVec3::Z * back, DVec3::NEG_Z), body.flat(DVec3::Z * front, DVec3::Z)];
    let mut plate = body.sweep(&Frame3::WORLD, &plate, &rim);
    body.join(&mut plate, Some(ends[0]), Some(ends[1]));

    body.paint(LINING);
    let side = Path::open(&[(0.0, front, 0.0), (0.0, -CHAMFER, 0.0), (-CHAMFER, 0.0, 0.0)]);
    let upper = [(102.0, 2.0, 4.0), (136.0, 2.0, 4.0), (136.0, 43.0, 4.0), (102.0, 35.0, 4.0)];
    let lower = [(102.0, -35.0, 4.0), (136.0, -43.0, 4.0), (136.0, -2.0, 4.0), (102.0, -2.0, 4.0)];
    for block in [upper, lower] {
        let face = body.flat(DVec3::ZERO, DVec3::Z);
        let mut block = body.sweep(&Frame3::WORLD, &Path::closed(&block), &side);
        body.join(&mut block, Some(ends[1]), Some(face));
    }
    body.finish()
}
