//! Point and starting parameters -> nearest point of a surface or a curve, by Newton's method held to the parameter box
//! (Piegl & Tiller, The NURBS Book, §6.1).

use crate::math::solve::solve_symmetric;
use crate::model::{CurveDerivatives, SurfaceDerivatives};
use crate::prepare::internals::{BezierPatches, BezierSpline3};
use glam::{DVec2, DVec3};

/// A walk ends when its next step is below this fraction of the distance, which then changes by less than 0.13 %.
const CLOSE: f64 = 0.05;
/// Maximum number of steps of a walk. Samples start near their foot point: two or three are common, more only at folds.
const STEPS: usize = 16;
/// How often a step that increases the distance is cut to a quarter.
const CUTS: i32 = 5;
/// How far a step that is stopped at a break enters the next piece, as a fraction of the piece.
const ACROSS: f64 = 1e-3;
/// Fraction of the product of squared derivative lengths below which their determinant counts as zero.
const SINGULAR: f64 = 1e-9;

/// Minimum number of starts of a search per direction, and starts per piece.
const STARTS: usize = 6;
const PER_PIECE: usize = 3;
/// Number of best starts that are walked from.
const BEST: usize = 8;
/// Maximum number of starts of a search per direction.
const MOST_STARTS: usize = 32;

/// The end of a walk.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot<T> {
    /// Distance to the given point, the minimum along the walk. Infinite if that point is not finite.
    pub(super) distance: f64,
    /// Parameters of the foot point.
    pub(super) at: T,
}

impl<T> Foot<T> {
    fn new(distance: f64, at: T) -> Self {
        Self { distance: if distance.is_nan() { f64::INFINITY } else { distance }, at }
    }
}

/// Walks over the surface towards `p`. Stops at a distance of at most `enough`.
pub(super) fn walk_surface(patches: &BezierPatches, p: DVec3, start: DVec2, enough: f64) -> Foot<DVec2> {
    let derivatives = |at: DVec2| patches.derivatives(at.x, at.y);
    walk(derivatives, [&patches.breaks_u, &patches.breaks_v], p, start, parameter_box(patches), enough)
}

/// Walks over a surface between breaks, within the parameters from `low` to `high`.
fn walk(
    derivatives: impl Fn(DVec2) -> SurfaceDerivatives,
    [breaks_u, breaks_v]: [&[f64]; 2],
    p: DVec3,
    start: DVec2,
    (low, high): (DVec2, DVec2),
    enough: f64,
) -> Foot<DVec2> {
    let mut at = start.clamp(low, high);
    let mut here = derivatives(at);
    let mut distance = here.point.distance(p);
    for _ in 0..STEPS {
        if distance <= enough {
            break;
        }
        let step = surface_step(&here, p, at, low, high);
        if (here.du * step.x + here.dv * step.y).length() <= CLOSE * distance {
            break;
        }
        let nearer = |step: DVec2| {
            let whole = (at + step).clamp(low, high);
            let share = hold(breaks_u, at.x, whole.x).min(hold(breaks_v, at.y, whole.y));
            (0..=CUTS).find_map(|cut| {
                let to = if cut == 0 { whole } else { at + (whole - at) * (share * 0.25_f64.powi(cut - 1)) };
                let there = derivatives(to);
                (there.point.distance(p) < distance).then_some((to, there))
            })
        };
        // At a crease, steps from both sides may lead back to it: then walk along it.
        let [along_u, along_v] = single_steps(&here, p);
        let Some((to, there)) = nearer(step).or_else(|| nearer(along_v)).or_else(|| nearer(along_u)) else { break };
        (at, here, distance) = (to, there, there.point.distance(p));
    }
    Foot::new(distance, at)
}

/// Walks from the [`BEST`] of a grid of starts over the box from `low` to `high`: [`STARTS`] per direction, or
/// [`PER_PIECE`] per piece if that is more. The nearest start alone may lead to another local minimum on long, narrow
/// surfaces.
pub(super) fn search_surface(
    patches: &BezierPatches,
    p: DVec3,
    (low, high): (DVec2, DVec2),
    enough: f64,
) -> Foot<DVec2> {
    let mut starts = Vec::new();
    let vs = start_parameters(&patches.breaks_v, low.y, high.y);
    for u in start_parameters(&patches.breaks_u, low.x, high.x) {
        for &v in &vs {
            starts.push(Foot::new(patches.point(u, v).distance(p), DVec2::new(u, v)));
        }
    }
    starts.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    let mut best = Foot { distance: f64::INFINITY, at: low };
    for start in starts.iter().take(BEST) {
        let foot = walk_surface(patches, p, start.at, enough);
        if foot.distance < best.distance {
            best = foot;
        }
        if best.distance <= enough {
            break;
        }
    }
    best
}

/// Start parameters between `low` and `high`, equally many per piece because lengths of pieces may differ a
/// billionfold.
fn start_parameters(breaks: &[f64], low: f64, high: f64) -> Vec<f64> {
    let inner = breaks.iter().copied().filter(|&b| b > low && b < high);
    let stops: Vec<f64> = std::iter::once(low).chain(inner).chain([high]).collect();
    let pieces = stops.len() - 1;
    let count = (PER_PIECE * pieces).clamp(STARTS, MOST_STARTS);
    let parameter = |k: usize| {
        let x = (k as f64 + 0.5) / count as f64 * pieces as f64;
        let piece = (x as usize).min(pieces - 1);
        stops[piece] + (stops[piece + 1] - stops[piece]) * (x - piece as f64)
    };
    (0..count).map(parameter).collect()
}

/// The fraction of the way from `from` to `to` that ends just across the next break. The parametric speed may jump a
/// thousandfold there, so a step computed in a slow piece is meaningless in a fast one.
fn hold(breaks: &[f64], from: f64, to: f64) -> f64 {
    let across = if to > from {
        let next = breaks.partition_point(|&b| b <= from);
        breaks.get(next..next + 2).map(|piece| piece[0] + ACROSS * (piece[1] - piece[0]))
    } else {
        let next = breaks.partition_point(|&b| b < from);
        let piece = next.checked_sub(2).and_then(|start| breaks.get(start..next));
        piece.map(|piece| piece[1] - ACROSS * (piece[1] - piece[0]))
    };
    // If `from` equals `to` the fraction is NaN, which `min` drops.
    across.map_or(1.0, |across| ((across - from) / (to - from)).abs().min(1.0))
}

/// Lower and upper corner of the parameter box.
pub(super) fn parameter_box(patches: &BezierPatches) -> (DVec2, DVec2) {
    let ends = |breaks: &[f64]| (breaks[0], breaks[breaks.len() - 1]);
    let ((u0, u1), (v0, v1)) = (ends(&patches.breaks_u), ends(&patches.breaks_v));
    (DVec2::new(u0, v0), DVec2::new(u1, v1))
}

/// Newton step for the squared distance. Falls back to a Gauss-Newton step if the Hessian is not positive definite, and
/// to the better single direction at poles. A coordinate that the box holds is not stepped.
fn surface_step(here: &SurfaceDerivatives, p: DVec3, at: DVec2, low: DVec2, high: DVec2) -> DVec2 {
    let r = here.point - p;
    let slope = DVec2::new(here.du.dot(r), here.dv.dot(r));
    let held = |x: f64, low: f64, high: f64, slope: f64| (x <= low && slope >= 0.0) || (x >= high && slope <= 0.0);
    let (uu, uv, vv) = (here.du.length_squared(), here.du.dot(here.dv), here.dv.length_squared());
    let (exact_uu, exact_uv, exact_vv) = (uu + r.dot(here.duu), uv + r.dot(here.duv), vv + r.dot(here.dvv));
    let along = single_steps(here, p);
    match (held(at.x, low.x, high.x, slope.x), held(at.y, low.y, high.y, slope.y)) {
        (true, true) => return DVec2::ZERO,
        (true, false) => return along[1],
        (false, true) => return along[0],
        (false, false) => {}
    }
    let solve = |matrix| solve_symmetric(matrix, -slope, SINGULAR);
    solve([exact_uu, exact_uv, exact_vv])
        .or_else(|| solve([uu, uv, vv]))
        .unwrap_or_else(|| if slope.dot(along[0]) < slope.dot(along[1]) { along[0] } else { along[1] })
}

/// Newton steps for the squared distance along u alone and along v alone.
fn single_steps(here: &SurfaceDerivatives, p: DVec3) -> [DVec2; 2] {
    let r = here.point - p;
    let step = |d: DVec3, dd: DVec3| {
        let square = d.length_squared();
        if square > 0.0 { -d.dot(r) / (square + r.dot(dd)).max(0.25 * square) } else { 0.0 }
    };
    [DVec2::new(step(here.du, here.duu), 0.0), DVec2::new(0.0, step(here.dv, here.dvv))]
}

/// Walks along the curve towards `p`, within the parameters `low` to `high`. Stops at a distance of at most `enough`.
pub(super) fn walk_curve(
    curve: &BezierSpline3,
    p: DVec3,
    start: f64,
    (low, high): (f64, f64),
    enough: f64,
) -> Foot<f64> {
    // A surface of which the other parameter is fixed.
    let derivatives = |at: DVec2| {
        let CurveDerivatives { point, d1, d2 } = curve.derivatives(at.x);
        SurfaceDerivatives { point, du: d1, dv: DVec3::ZERO, duu: d2, duv: DVec3::ZERO, dvv: DVec3::ZERO }
    };
    let [start, low, high] = [start, low, high].map(|t| DVec2::new(t, 0.0));
    let found = walk(derivatives, [&curve.breaks, &[]], p, start, (low, high), enough);
    Foot { distance: found.distance, at: found.at.x }
}

/// Walks from the best of `steps + 1` starts from `low` to `high`.
pub(super) fn search_curve(
    curve: &BezierSpline3,
    p: DVec3,
    (low, high): (f64, f64),
    steps: u32,
    enough: f64,
) -> Foot<f64> {
    let mut best = Foot { distance: f64::INFINITY, at: low };
    for i in 0..=steps {
        let at = low + (high - low) * f64::from(i) / f64::from(steps);
        let distance = curve.point(at).distance(p);
        if distance < best.distance {
            best = Foot { distance, at };
        }
    }
    walk_curve(curve, p, best.at, (low, high), enough)
}
