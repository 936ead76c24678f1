//! A surface and the box of its tiles -> Bézier patches over it, their bounds and creases.

use super::arrangement::ArrangedTile;
use super::grid::spans;
use crate::math::boxes::around;
use crate::math::solve::equal_pieces;
use crate::model::{AxisMap, FaceError, NurbsSurface, Surface};
use crate::prepare::report::Room;
use crate::prepare::surface::arc_bounds;
use crate::prepare::surface::decompose::BezierPatches;
use crate::prepare::surface::tables::SurfaceBounds;
use glam::{DVec2, DVec3, DVec4};
use std::cell::LazyCell;
use std::sync::Arc;

/// A surface over the box of a face's tiles.
#[derive(Clone, Debug)]
pub(crate) struct Patched {
    pub(crate) patches: Arc<BezierPatches>,
    pub(crate) bounds: Arc<SurfaceBounds>,
    /// From natural parameters to those of the patches.
    pub(crate) maps: [AxisMap; 2],
    /// Parameters of the patches where the tangent breaks.
    pub(crate) creases: [Vec<f64>; 2],
    /// Whether the normal turns by more than [`BLUNT`] at one of them.
    pub(crate) sharp: bool,
}

impl Patched {
    /// # Errors
    /// If the tiles' box, or the surface over it, has no area that `f64` resolves, or if `room` does not hold it.
    pub(super) fn over(surface: &Surface, tiles: &[ArrangedTile], room: &Room) -> Result<Self, FaceError> {
        let [low, high] = around(tiles.iter().flat_map(|tile| [tile.min, tile.max]));
        for axis in 0..2 {
            let extent = high[axis] - low[axis];
            if !(extent > 0.0 && extent.is_finite()) {
                return Err(FaceError::Thin { axis, extent });
            }
        }
        room.ask(patches_within(surface, low, high).saturating_mul(BYTES_PER_PATCH))?;
        let (nurbs, maps) = surface.to_nurbs((low.x, high.x), (low.y, high.y));
        let box_u = (maps[0].to_nurbs(low.x), maps[0].to_nurbs(high.x));
        let box_v = (maps[1].to_nurbs(low.y), maps[1].to_nurbs(high.y));
        let patches = BezierPatches::over(&nurbs, box_u, box_v);
        let analytic = arc_bounds::analytic(surface, &maps, &patches);
        // Analytic surfaces are smooth, and their tangents perpendicular.
        let is_analytic = analytic.is_some();
        let bounds = analytic.unwrap_or_else(|| SurfaceBounds::new(&patches));
        check_area(&patches, &bounds, high - low, is_analytic)?;
        let mut sharp = false;
        let creases = [0, 1].map(|axis| {
            let creases = if is_analytic { Vec::new() } else { creases(&nurbs, &patches, axis) };
            sharp |= creases.iter().any(|(_, turn)| *turn > BLUNT);
            creases.into_iter().map(|(at, _)| at).collect()
        });
        Ok(Self { patches: Arc::new(patches), bounds: Arc::new(bounds), maps, creases, sharp })
    }
}

/// Memory of a bicubic patch, bytes, with its bounds, and what cutting it off takes for a moment: four times its net.
const BYTES_PER_PATCH: usize = 4 * 16 * size_of::<DVec4>();

/// Number of patches of a surface over a box. A closed spline may go round several times.
fn patches_within(surface: &Surface, low: DVec2, high: DVec2) -> usize {
    let domain = surface.natural_domain();
    let along = |axis: usize| {
        let ((a, b), extent) = (domain[axis], high[axis] - low[axis]);
        // The period of a spline is the length of its domain. Whether it has one takes many points.
        if surface.knots(axis).is_some() && extent > b - a && surface.period()[axis].is_some() {
            spans(surface, axis, a, b).saturating_mul((extent / (b - a)).ceil() as usize)
        } else {
            spans(surface, axis, low[axis], high[axis])
        }
    };
    along(0).saturating_mul(along(1))
}

/// Number of patches of a whole surface; each quarter turn counts as one.
pub(crate) fn patches_of(surface: &Surface) -> usize {
    let [(u0, u1), (v0, v1)] = surface.natural_domain();
    patches_within(surface, DVec2::new(u0, v0), DVec2::new(u1, v1))
}

/// Least size of a face, in roundings of its coordinates: with fewer places its edges cross at random.
const RESOLVED: f64 = 1024.0;

/// Checks that patches over a box of parameters of size `size` have an area that `f64` resolves.
fn check_area(
    patches: &BezierPatches,
    bounds: &SurfaceBounds,
    size: DVec2,
    is_analytic: bool,
) -> Result<(), FaceError> {
    let speed = bounds.cells.iter().fold(DVec2::ZERO, |m, b| m.max(DVec2::new(b.u, b.v)));
    let reach = speed * size;
    let coordinates =
        patches.control.iter().fold(0.0_f64, |most, c| most.max((c.truncate() / c.w).abs().max_element()));
    if !(reach.is_finite() && coordinates.is_finite()) {
        return Err(FaceError::TooLarge { coordinates_mm: coordinates });
    }
    // Relative to the face's own size, so that the rest of the part has no influence.
    if reach.min_element() <= 1e-12 * reach.max_element() || !is_analytic && is_curve(patches) {
        return Err(FaceError::NoArea { size_mm: reach.max_element() });
    }
    if reach.min_element() <= RESOLVED * f64::EPSILON * coordinates {
        return Err(FaceError::Unresolved { size_mm: reach.min_element(), coordinates_mm: coordinates });
    }
    Ok(())
}

/// Whether both derivatives are parallel at all sampled points: the surface is then a curve.
fn is_curve(patches: &BezierPatches) -> bool {
    /// Samples per piece and direction. The first with an area ends the search.
    const PLACES: usize = 5;
    /// Sine of the largest angle that counts as rounding.
    const PARALLEL: f64 = 1e-9;
    let places = |breaks: &[f64]| -> Vec<f64> {
        let share = |k: usize| (k as f64 + 0.5) / PLACES as f64;
        breaks.windows(2).flat_map(|w| (0..PLACES).map(move |k| w[0] + (w[1] - w[0]) * share(k))).collect()
    };
    let vs = places(&patches.breaks_v);
    places(&patches.breaks_u).into_iter().flat_map(|u| vs.iter().map(move |&v| (u, v))).all(|(u, v)| {
        let [_, du, dv] = patches.tangents(u, v);
        du.cross(dv).length() <= PARALLEL * du.length() * dv.length()
    })
}

/// Largest turn of the normal across a crease, radians, at which triangles on both sides may be judged by either
/// normal: triangles count as steep before they are that close to perpendicular.
const BLUNT: f64 = 0.05;

/// Where the tangent across a knot of full multiplicity breaks, and the largest turn of the normal there, radians: none
/// where lines bend within the surface.
fn creases(nurbs: &NurbsSurface, patches: &BezierPatches, axis: usize) -> Vec<(f64, f64)> {
    /// Radians. Files write spline knots with 5 to 15 digits.
    const BREAK: f64 = 1e-3;
    /// Share of the longest tangent along a knot below which a tangent has no direction, as on a pole.
    const NO_TANGENT: f64 = 1e-9;
    let (knots, degree, breaks, across) = if axis == 0 {
        (&nurbs.knots_u, nurbs.degree_u, &patches.breaks_u, &patches.breaks_v)
    } else {
        (&nurbs.knots_v, nurbs.degree_v, &patches.breaks_v, &patches.breaks_u)
    };
    let tangent_and_normal = |x: f64, y: f64| {
        let [_, du, dv] = if axis == 0 { patches.tangents(x, y) } else { patches.tangents(y, x) };
        [if axis == 0 { du } else { dv }, du.cross(dv)]
    };
    // A crease may be as short as one piece: three samples per piece, and the end.
    let places = LazyCell::new(|| equal_pieces(across, 3).chain(across.last().copied()).collect::<Vec<f64>>());
    let crease = |k: usize| {
        let step = 1e-6 * (breaks[k] - breaks[k - 1]).min(breaks[k + 1] - breaks[k]);
        let sides: Vec<[[DVec3; 2]; 2]> =
            places.iter().map(|&y| [-step, step].map(|step| tangent_and_normal(breaks[k] + step, y))).collect();
        // The largest turn of the tangent or of the normal.
        let most = |of: usize| {
            let longest = sides.as_flattened().iter().map(|side| side[of].length()).fold(0.0, f64::max);
            let is_long = |v: DVec3| v.length() > NO_TANGENT * longest;
            let turn = |a: DVec3, b: DVec3| libm::atan2(a.cross(b).length(), a.dot(b));
            let turns = sides.iter().map(|[a, b]| [a[of], b[of]]).filter(|ends| ends.iter().all(|&v| is_long(v)));
            turns.map(|[a, b]| turn(a, b)).fold(0.0, f64::max)
        };
        (most(0) > BREAK).then(|| (breaks[k], most(1)))
    };
    let has_full_multiplicity = |k: usize| {
        let slack = 1e-12 * (1.0 + breaks[k].abs());
        let first = knots.partition_point(|x| *x < breaks[k] - slack);
        knots[first..].iter().take_while(|x| **x <= breaks[k] + slack).count() >= degree
    };
    (1..breaks.len() - 1).filter(|&k| has_full_multiplicity(k)).filter_map(crease).collect()
}
