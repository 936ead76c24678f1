//! The patches of the Utah teapot -> two models with free trims, after Figures 18 and 19 of Kumar & Manocha 1995:
//! letters and large loops cut out of body, lid and spout, and flowers cut out of every patch.
//!
//! The patches have no topology. A loop across a common border is given as one open curve per side; both end at the
//! same parameters of the border.

use crate::teapot::nets;
use glam::DVec2;
use std::f64::consts::{FRAC_PI_4, PI, TAU};
use trimtess::model::{
    Frame3, FreeTrims, NurbsCurve, NurbsCurve2, NurbsCurve3, NurbsSurface, Part, PartBuilder, ShellKind, Surface,
    TrimCurve, TrimPiece, TrimRule,
};

/// Millimetres per published unit.
const SCALE: f64 = 20.0;

/// Patches around the axis in each band of body, rim, lid and bottom. Within a band, v continues from patch to patch.
const QUARTERS: usize = 4;

/// The teapot with letters U, N and C cut out of both sides of the body, four ellipses out of its lower half, four
/// across the borders of the lid's patches, and two out of the spout. The N lies across the border of two patches.
pub(crate) fn unc() -> Part {
    trimmed("trimmed-teapot", |patch, _| match (patch / QUARTERS, patch % QUARTERS) {
        (1, quarter) => letters(quarter % 2),
        (2, _) => vec![ellipse(DVec2::new(0.36, 0.5), DVec2::new(0.24, 0.34))],
        (4, _) => [0.0, 1.0].map(|v| half_ellipse(DVec2::new(0.52, v), DVec2::new(0.3, 0.3))).to_vec(),
        (7, side) if side < 2 => vec![ellipse(DVec2::new(0.3, 0.5), DVec2::new(0.2, 0.34))],
        _ => Vec::new(),
    })
}

/// The teapot with flowers cut out of every patch, made of polylines, Bézier curves and closed B-splines. Many cross
/// each other, and four lie across the border of two patches.
pub(crate) fn flowers() -> Part {
    trimmed("flower-teapot", |patch, surface| {
        let bed = Bed { surface };
        let mut curves = match patch % 4 {
            0 => vec![bed.petals(0.5, 0.5, 0.4, 6), bed.disk(0.5, 0.76, 0.1), bed.points(0.82, 0.18, 0.13)],
            1 => vec![bed.points(0.34, 0.5, 0.3), bed.spline(0.62, 0.5, 0.3)],
            2 => vec![bed.spline(0.5, 0.42, 0.36), bed.points(0.56, 0.8, 0.16)],
            _ => vec![bed.points(0.5, 0.36, 0.28), bed.points(0.5, 0.66, 0.26), bed.petals(0.2, 0.5, 0.16, 5)],
        };
        if patch / QUARTERS == 2 {
            // Half a flower on both borders of the lower body; the neighbours have the other halves.
            curves.extend([0.0, 1.0].map(|v| bed.half(0.5, v, 0.2)));
        }
        curves
    })
}

/// The patches of the teapot, each with the curves that `trims` returns for its number and surface.
fn trimmed(name: &str, trims: impl Fn(usize, &NurbsSurface) -> Vec<TrimCurve>) -> Part {
    let mut part = PartBuilder::new(name);
    let shell = part.plain_shell(ShellKind::Open);
    for (patch, (net, reversed)) in nets().into_iter().enumerate() {
        let points = net.as_flattened().iter().map(|&p| p * SCALE).collect();
        let surface = NurbsSurface::bezier((3, 3), points, Vec::new());
        let curves = trims(patch, &surface);
        let surface = Surface::Nurbs(surface);
        if curves.is_empty() {
            part.plain_face(surface, shell, Vec::new(), reversed);
        } else {
            part.trimmed_face(surface, shell, FreeTrims { rule: TrimRule::Handedness, curves }, reversed);
        }
    }
    part.finish().expect("the trimmed teapots are stated soundly")
}

/// An elliptic hole with half axes `size` along u and v.
fn ellipse(centre: DVec2, size: DVec2) -> TrimCurve {
    TrimCurve::ellipse(centre, DVec2::X * size.x, DVec2::NEG_Y * size.y)
}

/// The half inside the domain of an elliptic hole with its centre on the border v = 0 or v = 1.
fn half_ellipse(centre: DVec2, size: DVec2) -> TrimCurve {
    // Clockwise around the hole: over its top from left to right, or this rotated by half a turn.
    let turned = if centre.y < 0.5 { 1.0 } else { -1.0 };
    let half = arc(DVec2::ZERO, 1.0, 0.0, PI, true);
    let on_border = |p: DVec2| DVec2::new(p.x, if p.y.abs() < 1e-12 { 0.0 } else { p.y });
    moved(&half.into(), |p| centre + on_border(p) * size * turned)
}

/// The letters of the body's upper band on its right (0) and left (1) patch, seen from outside.
///
/// From there, v points left and u down, so a letter drawn counter-clockwise with the ink on its left becomes a hole.
fn letters(patch: usize) -> Vec<TrimCurve> {
    const SIZE: DVec2 = DVec2::new(0.17, 0.29);
    let letter = |curve: &TrimCurve, v: f64| moved(curve, |p| DVec2::new(0.5 - SIZE.y * p.y, v - SIZE.x * p.x));
    match patch {
        0 => vec![letter(&letter_c(), 0.52), letter(&half_n(1.0), 1.0)],
        _ => vec![letter(&half_n(-1.0), 0.0), letter(&letter_u(), 0.48)],
    }
}

/// Stroke width of the letters, which are two wide and two high about the origin.
const STROKE: f64 = 0.5;

fn letter_u() -> TrimCurve {
    let (inner, foot) = (1.0 - STROKE, DVec2::new(0.0, -0.2));
    let line = |points: &[(f64, f64)]| TrimPiece::Polyline(points.iter().map(|&p| p.into()).collect());
    // The bowl is between an ellipse of 1 by 0.8 and one smaller by the stroke.
    let bowl = |radius: f64, back: bool| {
        let arc = arc(DVec2::ZERO, 1.0, PI, TAU, back);
        moved(&arc.into(), |p| foot + p * DVec2::new(radius, radius - 0.2)).pieces
    };
    let pieces = [
        vec![line(&[(-1.0, 1.0), (-1.0, -0.2)])],
        bowl(1.0, false),
        vec![line(&[(1.0, -0.2), (1.0, 1.0), (inner, 1.0), (inner, -0.2)])],
        bowl(inner, true),
        vec![line(&[(-inner, -0.2), (-inner, 1.0), (-1.0, 1.0)])],
    ];
    TrimCurve { pieces: pieces.concat() }
}

fn letter_c() -> TrimCurve {
    let (from, to) = (FRAC_PI_4, TAU - FRAC_PI_4);
    let ends = |a: f64| [1.0, 1.0 - STROKE].map(|r| DVec2::from_angle(a) * r);
    let [[a, b], [c, d]] = [ends(from), ends(to)];
    let line = |a, b| TrimPiece::Polyline(vec![a, b]);
    let (outer, inner) = (arc(DVec2::ZERO, 1.0, from, to, false), arc(DVec2::ZERO, 1.0 - STROKE, from, to, true));
    TrimCurve { pieces: vec![outer, line(c, d), inner, line(b, a)] }
}

/// The half of an N right of the middle (`side` 1) or left of it (-1). An N is symmetric under half a turn.
fn half_n(side: f64) -> TrimCurve {
    const HEIGHT: f64 = 0.2;
    let (bar, middle) = (1.0 - STROKE, 0.5 * (1.0 - HEIGHT));
    let corners = [(0.0, -middle), (bar, -1.0), (1.0, -1.0), (1.0, 1.0), (bar, 1.0), (bar, -HEIGHT), (0.0, middle)];
    TrimCurve::polyline(corners.map(|p| DVec2::from(p) * side).to_vec())
}

/// A patch to cut flowers out of. Sizes are fractions of the side of the domain that is shorter in space.
struct Bed<'a> {
    surface: &'a NurbsSurface,
}

impl Bed<'_> {
    /// Makes a hole of half size `size` about (u, v) from a curve drawn counter-clockwise in the unit circle.
    fn planted(&self, curve: &TrimCurve, u: f64, v: f64, size: f64) -> TrimCurve {
        let at = self.surface.derivatives(u, v);
        let lengths = DVec2::new(at.du.length(), at.dv.length());
        // Halfway between round in (u,v) and round in space.
        let size = (DVec2::splat(lengths.min_element()) / lengths).powf(0.5) * size;
        moved(&curve.reversed(), |p| DVec2::new(u, v) + p * size)
    }

    /// A flower of cubic Bézier petals.
    fn petals(&self, u: f64, v: f64, size: f64, count: usize) -> TrimCurve {
        let pieces = (0..count).map(|k| petal(k, count)).collect();
        self.planted(&TrimCurve { pieces }, u, v, size)
    }

    /// The inner half of a flower of four petals about a point of the border v = 0 or v = 1.
    fn half(&self, u: f64, v: f64, size: f64) -> TrimCurve {
        let first = if v < 0.5 { 0 } else { 2 };
        let pieces = vec![petal(first, 4), petal(first + 1, 4)];
        self.planted(&TrimCurve { pieces }, u, v, size)
    }

    /// A closed B-spline whose control points lie on two circles, two on each in turn.
    fn spline(&self, u: f64, v: f64, size: f64) -> TrimCurve {
        const CONTROLS: usize = 24;
        let control = |k: usize| {
            let radius = if k % 4 < 2 { 1.0 } else { 0.4 };
            DVec2::from_angle(TAU * (k % CONTROLS) as f64 / CONTROLS as f64) * radius
        };
        let knots = (0..CONTROLS + 7).map(|k| k as f64).collect();
        let points = (0..CONTROLS + 3).map(control).collect();
        self.planted(&TrimCurve::nurbs(NurbsCurve { degree: 3, knots, points, weights: Vec::new() }), u, v, size)
    }

    /// A flower of five petals as a polyline of 60 points.
    fn points(&self, u: f64, v: f64, size: f64) -> TrimCurve {
        let point = |k: u32| {
            let angle = TAU * f64::from(k) / 60.0;
            DVec2::from_angle(angle) * (0.7 + 0.3 * (5.0 * angle).cos())
        };
        self.planted(&TrimCurve::polygon((0..60).map(point).collect()), u, v, size)
    }

    /// A round hole.
    fn disk(&self, u: f64, v: f64, size: f64) -> TrimCurve {
        self.planted(&TrimCurve::circle(DVec2::ZERO, 1.0), u, v, size)
    }
}

/// Petal `k` of `count`, starting and ending on the inner circle. Petal 0 starts on the x axis.
fn petal(k: usize, count: usize) -> TrimPiece {
    // Half flowers must end exactly on the axes.
    let exact = |x: f64| if x.abs() < 1e-12 { 0.0 } else { x };
    let ray = |turn: f64, radius: f64| {
        let p = DVec2::from_angle(TAU * turn / count as f64) * radius;
        DVec2::new(exact(p.x), exact(p.y))
    };
    let k = k as f64;
    TrimPiece::bezier(vec![ray(k, 0.4), ray(k + 0.1, 1.2), ray(k + 0.9, 1.2), ray(k + 1.0, 0.4)], Vec::new())
}

/// A circular arc, reversed if `back`.
fn arc(centre: DVec2, radius: f64, from: f64, to: f64, back: bool) -> TrimPiece {
    let unit = NurbsCurve3::arc(&Frame3::WORLD, 1.0, 1.0, from, to);
    let points = unit.points.iter().map(|ray| centre + ray.truncate() * radius).collect();
    let curve = NurbsCurve2 { degree: unit.degree, knots: unit.knots, points, weights: unit.weights };
    TrimPiece::Nurbs(if back { curve.reversed() } else { curve })
}

/// Maps a curve by an affine map.
fn moved(curve: &TrimCurve, map: impl Fn(DVec2) -> DVec2) -> TrimCurve {
    let all = |points: &[DVec2]| points.iter().map(|&p| map(p)).collect();
    let piece = |piece: &TrimPiece| match piece {
        TrimPiece::Nurbs(curve) => TrimPiece::Nurbs(NurbsCurve2 { points: all(&curve.points), ..curve.clone() }),
        TrimPiece::Polyline(points) => TrimPiece::Polyline(all(points)),
    };
    TrimCurve { pieces: curve.pieces.iter().map(piece).collect() }
}
