//! Circular arcs, planes, cylinders, cones, spheres and tori -> derivative bounds in closed form.
//!
//! A rational quadratic arc of angle `step` has φ(s) = 2 atan(k s), k = tan(step/4), s in [-1, 1] across the span. All
//! derivatives of these surfaces are products of radii and derivatives of one or two such arcs. Bounds therefore need
//! no control nets: they are tight, and cost nanoseconds instead of microseconds. Second derivatives are split into the
//! part along the normal, which lifts the surface off its triangles, and the rest.

use super::decompose::BezierPatches;
use super::tables::{Bend, BoundingBox, BoxBounds, StripBounds, SurfaceBounds};
use crate::math::solve::equal_pieces;
use crate::model::{AxisMap, Surface};
use glam::DVec4;
use smallvec::{SmallVec, smallvec};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Strips per span of an arc. φ' varies by 17 % along a span of a quarter turn. It is symmetric about the middle, so
/// both halves have the same bounds of φ' and |φ''|: they differ in their angles only.
const PARTS: usize = 2;

/// Bounds on the angle φ of a unit arc as a function of the parameter, over one strip.
#[derive(Clone, Copy, Debug)]
struct ArcStrip {
    /// sup φ'.
    first: f64,
    /// sup |φ''|.
    second: f64,
    /// Angles at the ends, radians.
    angles: (f64, f64),
}

impl ArcStrip {
    /// The halves of a span of `step` radians that starts at angle `start` and is `width` wide in the parameter.
    fn halves(start: f64, step: f64, width: f64) -> [Self; PARTS] {
        let k = libm::tan(0.25 * step);
        // φ' falls with |s|: largest at 0. |φ''| grows with |s| while k²s² < 1/3, for all steps up to 120°: largest at
        // 1.
        let (first, second) = (4.0 * k / width, 16.0 * k.powi(3) / (1.0 + k.powi(2)).powi(2) / (width * width));
        let (middle, half) = (start + 0.5 * step, 2.0 * libm::atan(k));
        let ends = [(middle - half, middle), (middle, middle + half)];
        ends.map(|angles| Self { first, second, angles })
    }

    /// Bounds `reach · e''`, where e is the unit vector at angle φ. The share `level` of the centripetal part lies
    /// along the surface's normal, the share `across` in the tangent plane.
    fn acceleration(&self, reach: f64, level: f64, across: f64) -> Bend {
        let centripetal = self.first.powi(2);
        Bend {
            norm: reach * libm::hypot(centripetal, self.second),
            lift: reach * centripetal * level,
            slide: reach * libm::hypot(centripetal * across, self.second),
        }
    }

    fn turn(&self) -> f64 {
        self.angles.1 - self.angles.0
    }

    /// Whether it contains `angle` plus a multiple of `period`.
    fn contains(&self, angle: f64, period: f64) -> bool {
        let (a, b) = self.angles;
        ((b - angle) / period).floor() * period + angle >= a
    }

    /// sup |cos φ| and sup |sin φ|.
    fn extremes(&self) -> (f64, f64) {
        let (a, b) = self.angles;
        let cos = if self.contains(0.0, PI) { 1.0 } else { libm::cos(a).abs().max(libm::cos(b).abs()) };
        let sin = if self.contains(FRAC_PI_2, PI) { 1.0 } else { libm::sin(a).abs().max(libm::sin(b).abs()) };
        (cos, sin)
    }
}

/// Strip borders in patch parameters, and the strips, of an arc axis; `None` for a straight axis.
fn swings(map: &AxisMap, breaks: &[f64]) -> Option<(Vec<f64>, Vec<ArcStrip>)> {
    let AxisMap::Arc { start, step, spans } = *map else { return None };
    if breaks.len() != spans as usize + 1 {
        return None;
    }
    let mut borders = Vec::with_capacity(PARTS * spans as usize + 1);
    borders.extend(equal_pieces(breaks, PARTS).chain(breaks.last().copied()));
    let mut out = Vec::with_capacity(PARTS * spans as usize);
    for (k, w) in breaks.windows(2).enumerate() {
        out.extend(ArcStrip::halves(start + step * k as f64, step, w[1] - w[0]));
    }
    Some((borders, out))
}

/// Bounds of an analytic surface over its patches; `None` for other kinds of surfaces.
pub(crate) fn analytic(surface: &Surface, maps: &[AxisMap; 2], patches: &BezierPatches) -> Option<SurfaceBounds> {
    let flat = || patches.breaks_v.clone();
    let ends = (patches.breaks_v[0], patches.breaks_v[patches.breaks_v.len() - 1]);
    match *surface {
        Surface::Plane { .. } => {
            let cell = BoxBounds { u: 1.0, v: 1.0, ..BoxBounds::default() };
            let cells = vec![cell; (patches.breaks_u.len() - 1) * (patches.breaks_v.len() - 1)];
            Some(table(patches, patches.breaks_u.clone(), flat(), cells))
        }
        Surface::Cylinder { radius, .. } => ruled(maps, patches, radius, 0.0),
        Surface::Cone { radius, half_angle, .. } => {
            let slope = libm::tan(half_angle);
            let reach = (radius + ends.0 * slope).abs().max((radius + ends.1 * slope).abs());
            ruled(maps, patches, reach, half_angle)
        }
        Surface::Sphere { radius, .. } => tube(maps, patches, 0.0, radius),
        Surface::Torus { major, minor, .. } => tube(maps, patches, major, minor),
        _ => None,
    }
}

fn table(patches: &BezierPatches, breaks_u: Vec<f64>, breaks_v: Vec<f64>, cells: Vec<BoxBounds>) -> SurfaceBounds {
    let places = BoundingBox::of_pieces(patches, [breaks_u.len() - 1, breaks_v.len() - 1]);
    SurfaceBounds { breaks_u, breaks_v, cells, places }
}

/// Bounds of a derivative that lies in the tangent plane.
fn tangential(length: f64) -> Bend {
    Bend { norm: length, lift: 0.0, slide: length }
}

/// Cylinders and cones: `reach` is the largest radius.
fn ruled(maps: &[AxisMap; 2], patches: &BezierPatches, reach: f64, half_angle: f64) -> Option<SurfaceBounds> {
    if maps[1] != AxisMap::Identity || patches.breaks_v.len() != 2 {
        return None;
    }
    let (breaks_u, around) = swings(&maps[0], &patches.breaks_u)?;
    let (sine, cosine) = (libm::sin(half_angle), libm::cos(half_angle));
    let slope = libm::tan(half_angle).abs();
    let cells = around
        .iter()
        .map(|s| BoxBounds {
            uu: s.acceleration(reach, cosine, sine.abs()),
            uv: tangential(slope * s.first),
            vv: Bend::default(),
            u: reach * s.first,
            v: 1.0 / cosine,
            turn_u: 2.0 * libm::asin(cosine * libm::sin(0.5 * s.turn())),
            turn_v: 0.0,
        })
        .collect();
    Some(table(patches, breaks_u, patches.breaks_v.clone(), cells))
}

/// Tori, and spheres as tori without a hole.
fn tube(maps: &[AxisMap; 2], patches: &BezierPatches, major: f64, minor: f64) -> Option<SurfaceBounds> {
    let (breaks_u, around) = swings(&maps[0], &patches.breaks_u)?;
    let (breaks_v, across) = swings(&maps[1], &patches.breaks_v)?;
    let of_strip = |t: &ArcStrip| {
        let (cos, sin) = t.extremes();
        // The distance from the axis is largest at an end of the strip, or where cos v is extreme within it.
        let extremes = [(0.0, major + minor), (PI, (major - minor).abs())];
        let within = extremes.into_iter().filter(|&(v, _)| t.contains(v, TAU)).map(|(_, reach)| reach);
        let ends = [t.angles.0, t.angles.1].map(|v| (major + minor * libm::cos(v)).abs());
        let reach = within.fold(ends[0].max(ends[1]), f64::max);
        (cos, sin, reach, t.acceleration(minor, 1.0, 0.0))
    };
    let constants: Vec<(f64, f64, f64, Bend)> = across.iter().map(of_strip).collect();
    let mut cells = Vec::with_capacity(around.len() * across.len());
    for s in &around {
        for (t, &(cos, sin, reach, vv)) in across.iter().zip(&constants) {
            cells.push(BoxBounds {
                uu: s.acceleration(reach, cos, sin),
                uv: tangential(minor * sin * s.first * t.first),
                vv,
                u: reach * s.first,
                v: minor * t.first,
                turn_u: cos * s.turn(),
                turn_v: t.turn(),
            });
        }
    }
    Some(table(patches, breaks_u, breaks_v, cells))
}

/// Strips of a segment: up to four.
pub(crate) type Strips = SmallVec<[StripBounds; 4]>;

/// Bounds of a Bézier segment that is `width` wide in the parameter, one per strip.
///
/// `None` unless it is a straight line of constant speed or a circular arc of at most 120°.
pub(crate) fn segment(net: &[DVec4], width: f64) -> Option<Strips> {
    match *net {
        [a, b] if a.w == b.w => {
            let first = (b - a).truncate().length() / a.w / width;
            Some(smallvec![StripBounds { first, second: 0.0, turn: 0.0, place: BoundingBox::of_net(net) }])
        }
        [a, b, c] if a.w == c.w && b.w > 0.0 && b.w < a.w => {
            let [p, q, r] = [a, b, c].map(|x| x.truncate() / x.w);
            let (legs, chord) = ((q - p, r - q), r - p);
            let length = legs.0.length();
            let half = libm::acos(b.w / a.w);
            let is_arc = (legs.1.length() - length).abs() <= 1e-9 * length
                && (chord.length() - 2.0 * length * libm::cos(half)).abs() <= 1e-9 * length
                && half <= std::f64::consts::FRAC_PI_3;
            if !is_arc {
                return None;
            }
            let (radius, place) = (length / libm::tan(half), BoundingBox::of_net(net));
            let strip = |s: ArcStrip| StripBounds {
                first: radius * s.first,
                second: radius * libm::hypot(s.first.powi(2), s.second),
                turn: s.turn(),
                place,
            };
            Some(ArcStrip::halves(0.0, 2.0 * half, width).map(strip).into_iter().collect())
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Frame3;

    #[test]
    fn strips_of_a_torus_reach_as_far_as_they_do() {
        let (major, minor) = (10.0, 8.0);
        let torus = Surface::Torus { frame: Frame3::WORLD, major, minor };
        // Those of fillets begin and end at the innermost or the outermost circle.
        for v in [(PI, 1.5 * PI), (0.75 * PI, 1.25 * PI), (-PI, 0.0), (0.0, 0.5 * PI), (3.0 * PI, 7.0 * PI), (1.0, 2.0)]
        {
            let (nurbs, maps) = torus.to_nurbs((0.0, 1.0), v);
            let patches = BezierPatches::new(&nurbs);
            let bounds = analytic(&torus, &maps, &patches).expect("a torus");
            let natural = maps[1].naturals();
            let reaches = bounds.breaks_v.windows(2).map(|w| {
                let at = |k: u32| natural(w[0] + (w[1] - w[0]) * f64::from(k) / 500.0);
                (0..=500).map(|k| major + minor * libm::cos(at(k))).fold(0.0, f64::max)
            });
            let reaches: Vec<f64> = reaches.collect();
            for (j, reach) in reaches.iter().enumerate() {
                let ratio = bounds.cell(0, j).u / bounds.cell(0, 0).u;
                assert!((ratio - reach / reaches[0]).abs() < 1e-4, "{v:?} {j}: {ratio}, {reaches:?}");
            }
            assert!((bounds.cell(0, 0).u / reaches[0] - bounds.cell(1, 0).u / reaches[0]).abs() < 1e-9);
        }
    }
}
