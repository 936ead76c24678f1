//! Feet of points on a spline and off it, against samples.

use super::{MAX_STEPS, Projector};
use crate::model::{NurbsCurve, NurbsSurface, Surface};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Two by two bicubic pieces of different sizes, rational or not.
fn bumpy(weight: f64) -> Surface {
    let knots = [0.0, 0.0, 0.0, 0.0, 0.8, 2.0, 2.0, 2.0, 2.0].to_vec();
    let grid = || (0..5).flat_map(|i| (0..5).map(move |j| (f64::from(i), f64::from(j))));
    Surface::Nurbs(NurbsSurface {
        degree_u: 3,
        degree_v: 3,
        knots_u: knots.clone(),
        knots_v: knots,
        points: grid().map(|(x, y)| DVec3::new(x + 0.2 * y.sin(), y, (1.7 * x + 0.9 * y).sin())).collect(),
        weights: if weight == 1.0 {
            Vec::new()
        } else {
            grid().map(|(x, y)| weight.powf((2.1 * x - 1.3 * y).cos())).collect()
        },
    })
}

fn parameters(count: u32) -> impl Iterator<Item = DVec2> + Clone {
    let at = move |k: u32| 2.0 * f64::from(k) / f64::from(count);
    (0..=count).flat_map(move |i| (0..=count).map(move |j| DVec2::new(at(i), at(j))))
}

#[test]
fn no_point_is_nearer_than_a_foot() {
    for weight in [1.0, 2.0] {
        let surface = bumpy(weight);
        let samples: Vec<(DVec2, DVec3)> = parameters(80).map(|uv| (uv, surface.point(uv.x, uv.y))).collect();
        // On the surface, off it, and beyond its centres of curvature.
        for off in [0.0, 1e-9, 1e-4, 0.02, -0.02, 0.3, -0.3, 1.5, -1.5] {
            for uv in parameters(11) {
                let [point, du, dv] = surface.tangents(uv.x, uv.y);
                let p = point + off * du.cross(dv).normalize();
                let (seed, nearest) = samples
                    .iter()
                    .map(|(uv, sample)| (*uv, sample.distance(p)))
                    .fold((DVec2::ZERO, f64::INFINITY), |a, b| if b.1 < a.1 { b } else { a });
                let foot = Projector::new(&surface, 1e-6).foot(p, Some(seed));
                assert!(foot.off <= nearest, "{off} {uv}: {} instead of {nearest}", foot.off);
                // Beyond centres of curvature the steps may end before they get to the foot.
                if off.abs() > 0.3 {
                    continue;
                }
                for step in [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y, DVec2::ONE, DVec2::NEG_ONE] {
                    let aside = (foot.uv + 1e-4 * step).clamp(DVec2::ZERO, DVec2::splat(2.0));
                    let there = surface.point(aside.x, aside.y).distance(p);
                    assert!(there >= foot.off - 1e-9, "{off} {uv}: {there} at {aside}, {} at {}", foot.off, foot.uv);
                }
            }
        }
    }
}

/// A sheet along y over a cubic that closes in a crease, and one over two lines.
fn creased() -> [Surface; 2] {
    let over = |degree: usize, knots: Vec<f64>, points: Vec<DVec3>| Surface::Extrusion {
        curve: NurbsCurve { degree, knots, points, weights: Vec::new() },
        direction: DVec3::Y,
    };
    let wing = [(0.0, 0.0), (2.0, 1.0), (4.0, 0.0), (2.0, -1.0), (0.0, 0.0)].map(|(x, z)| DVec3::new(x, 0.0, z));
    let fold = [(0.0, 0.0), (1.0, 0.0), (0.0, 0.01)].map(|(x, z)| DVec3::new(x, 0.0, z));
    [
        over(3, vec![0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0, 2.0], wing.to_vec()),
        over(1, vec![0.0, 0.0, 1.0, 2.0, 2.0], fold.to_vec()),
    ]
}

#[test]
fn tangents_of_a_foot_are_those_at_its_parameters() {
    let [wing, fold] = creased();
    for (surface, crease) in [(bumpy(1.0), 0.8), (bumpy(2.0), 0.8), (wing, 0.0), (fold, 1.0)] {
        let projector = Projector::new(&surface, 1e-6);
        for at in [crease, crease + 1e-13, crease + 1e-3, crease + 0.3] {
            let p = projector.point(DVec2::new(at, 0.5));
            // From both sides, near and far.
            for from in [-0.1, -1e-4, -1e-9, 0.0, 1e-9, 1e-4, 0.1] {
                let foot = projector.foot(p, Some(DVec2::new(at + from, 0.45)));
                let [_, du, dv] = projector.tangents(foot.uv);
                let off = (foot.tangents[1] - du).length() + (foot.tangents[2] - dv).length();
                assert!(off <= 1e-6 * du.length(), "{at} {from}: {off}");
            }
        }
    }
}

/// A flattened ball whose circles are three pieces and whose seam is at y = 0, as OpenCASCADE writes them.
fn flattened_ball() -> Surface {
    let (third, half) = (TAU / 3.0, 0.5_f64.sqrt());
    let (radius, centre, high) = (1.5, DVec3::new(-3.0, 0.0, 0.534_576_060_619), 1.768_990_253_964);
    let corner = |i: u32| {
        let stretch = if i.is_multiple_of(2) { 1.0 } else { 2.0 };
        let turn = DVec2::from_angle(0.5 * third * f64::from(i)) * stretch * radius;
        DVec3::new(turn.x, 0.465_530_645_1 * turn.y, 0.0)
    };
    let profile = [(0.0, -high), (1.0, -high), (1.0, 0.0), (1.0, high), (0.0, high)];
    let rows = || (0..7).flat_map(|i| (0..5).map(move |j| (i, j)));
    let weight = |k: u32, middle: f64| if k.is_multiple_of(2) { 1.0 } else { middle };
    Surface::Nurbs(NurbsSurface {
        degree_u: 2,
        degree_v: 2,
        knots_u: [-1, 0, 0, 1, 1, 2, 2, 3, 3, 4].map(|k| third * f64::from(k)).to_vec(),
        knots_v: [-1, -1, -1, 0, 0, 1, 1, 1].map(|k| FRAC_PI_2 * f64::from(k)).to_vec(),
        points: rows()
            .map(|(i, j)| centre + corner(i) * profile[j as usize].0 + DVec3::Z * profile[j as usize].1)
            .collect(),
        weights: rows().map(|(i, j)| weight(i, 0.5) * weight(j, half)).collect(),
    })
}

#[test]
fn feet_near_poles_stay_within_the_steps_that_are_taken() {
    let surface = flattened_ball();
    let projector = Projector::new(&surface, 1e-6);
    assert_eq!(projector.poles.len(), 2);
    for pole in [-FRAC_PI_2, FRAC_PI_2] {
        for k in 0..2000 {
            let away = 0.1 * 0.99_f64.powi(k);
            let (u, v) = (0.05 * TAU * f64::from(k % 20), pole - pole.signum() * away);
            let p = surface.point(u, v);
            // On a pole line the steps do not end at the foot: they start in any direction.
            let seeds = [(None, 1e-6), (Some(DVec2::new(u + 0.3, v)), 1e-6), (Some(DVec2::new(u - 1.5, pole)), 0.2)];
            for (seed, off) in seeds {
                let foot = projector.foot(p, seed);
                let turns = (foot.uv.x - u).abs() / TAU;
                let most = 1.0 + 0.25 * f64::from(MAX_STEPS);
                assert!(turns <= most && foot.off < off, "{u} {v} from {seed:?}: {turns} turns, {} mm", foot.off);
            }
        }
    }
}
