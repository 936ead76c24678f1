//! A face's loops to a region of its unrolled parameter plane.
//!
//! On periodic surfaces a loop is followed by continuity, so it may end a whole number of periods from its start (its
//! winding). Areas, nesting and windings decide the orientation. Only on closed surfaces, where both sides of a loop
//! are bounded, does the file's orientation decide.

use super::trace::{pole_piece, turn_at_pole};
use crate::math::boxes::BoxTree;
use crate::model::{MOST_TURNS, MOST_TURNS_BOTH_WAYS, RegionError};
use crate::prepare::uv::polygon::Polygon;
use crate::prepare::uv::projector::Projector;
use crate::prepare::uv::uv_curve::step_along;
use crate::prepare::uv::uv_loop::{Along, Piece, Region, UvLoop, loops_box};
use glam::DVec2;
use std::collections::HashMap;

/// The region that the loops bound. `named_pole` is the pole at which the file has a vertex loop. With `turn`, loops
/// are oriented by their nesting; otherwise they run as stated.
pub(crate) fn region(
    mut loops: Vec<UvLoop>,
    named_pole: Option<usize>,
    projector: &Projector<'_>,
    turn: bool,
) -> Result<Region, RegionError> {
    let bounds = loops_box(&loops);
    for (axis, (lo, hi)) in bounds.into_iter().enumerate() {
        let periods = projector.period[axis].map_or(0.0, |p| (hi - lo) / p);
        let sound = (hi - lo).is_finite() && periods <= most_turns(projector);
        if !(loops.is_empty() || sound) {
            return Err(RegionError::Runaway { axis, periods });
        }
    }
    if let Some(axis) = (0..2).find(|&a| loops.iter().any(|l| l.winding[a] != 0)) {
        let other = turn_back(&loops, axis, projector);
        go_round_poles(&mut loops, projector);
        let stated = band(loops, axis, named_pole, projector, turn);
        return match (stated, other) {
            (Err(RegionError::OneSided { .. }), Some(other)) => region(other, named_pole, projector, turn),
            (stated, _) => stated,
        };
    }
    let periodic = projector.period.map(|p| p.is_some());
    if loops.is_empty() {
        for axis in 0..2 {
            let (lo, hi) = projector.domain[axis];
            if !(lo.is_finite() && hi.is_finite()) {
                return Err(RegionError::Unbounded { axis });
            }
        }
        return Ok(Region { loops, wraps: periodic, bounds: projector.domain, base: 1, unbounded: None });
    }
    let mut polylines: Vec<Vec<DVec2>> = loops.iter().map(UvLoop::polyline).collect();
    let areas: Vec<f64> = loops.iter().map(UvLoop::double_area).collect();
    let closed = closes(projector);
    // A loop with a seam lies around what it keeps, whichever way it runs: the seam is in no other region.
    if closed && areas.iter().all(|&a| a < 0.0) && !(turn && loops.iter().any(|l| has_seam(l, projector))) {
        if let Some(axis) = go_round_poles(&mut loops, projector) {
            return band(loops, axis, named_pole, projector, turn);
        }
        return Ok(Region { loops, wraps: periodic, bounds: projector.domain, base: 1, unbounded: None });
    }
    let moved = periodic != [false, false] && gather(&mut loops, &mut polylines, &areas, projector);
    let bounds = if moved { loops_box(&loops) } else { bounds };
    if turn {
        nest(&mut loops, polylines, &areas);
    }
    Ok(Region { loops, wraps: [false, false], bounds, base: 0, unbounded: None })
}

/// Whether a loop runs along an edge in both directions, a period apart.
fn has_seam(l: &UvLoop, projector: &Projector<'_>) -> bool {
    let mut known: HashMap<u32, &Piece> = HashMap::new();
    l.pieces.iter().any(|piece| {
        let before = piece.along.edge().and_then(|edge| known.insert(edge, piece));
        before.is_some_and(|other| {
            let apart = piece.start() - other.end();
            let is_apart = |axis: usize| projector.period[axis].is_some_and(|period| apart[axis].abs() > 0.5 * period);
            other.reversed != piece.reversed && (0..2).any(is_apart)
        })
    })
}

/// Converts holes that touch a pole, as a wedge cut out of a dome does, into one loop that goes round it, and returns
/// the direction in which it does. `None` if there are no such holes. The loop follows the holes' boundaries and the
/// pole line between them. The rest of the pole line bounds nothing.
fn go_round_poles(loops: &mut Vec<UvLoop>, projector: &Projector<'_>) -> Option<usize> {
    let mut round = None;
    for (k, pole) in projector.poles.iter().enumerate() {
        let run = 1 - pole.axis;
        let Some(period) = projector.period[run] else { continue };
        let touches = |l: &UvLoop| l.winding == [0, 0] && l.pieces.iter().any(|p| p.along == Along::Pole(k));
        let touching: Vec<usize> = (0..loops.len()).filter(|&i| touches(&loops[i])).collect();
        let holes: Option<Vec<Gap>> = touching.iter().map(|&i| Gap::of(&loops[i], run)).collect();
        let Some(joined) = holes.and_then(|holes| join(holes, k, period, projector)) else { continue };
        loops[touching[0]] = joined;
        touching[1..].iter().rev().for_each(|&i| drop(loops.remove(i)));
        round = Some(run);
    }
    round
}

/// A hole that touches a pole along one stretch.
struct Gap {
    /// The hole's boundary from the end of that stretch to its start.
    pieces: Vec<Piece>,
    /// The direction along the pole in which a loop goes from one hole to the next: 1 or -1.
    turns: i32,
    /// Where the stretch ends, and its length, in that direction.
    from: f64,
    length: f64,
}

impl Gap {
    /// `None` if the loop is no such hole.
    fn of(l: &UvLoop, run: usize) -> Option<Self> {
        let mut along_poles = (0..l.pieces.len()).filter(|&i| matches!(l.pieces[i].along, Along::Pole(_)));
        let (Some(jump), None) = (along_poles.next(), along_poles.next()) else { return None };
        if l.double_area() > 0.0 {
            return None;
        }
        let (start, end) = (l.pieces[jump].start()[run], l.pieces[jump].end()[run]);
        let turns = if end > start { -1 } else { 1 };
        let pieces = [&l.pieces[jump + 1..], &l.pieces[..jump]].concat();
        Some(Self { pieces, turns, from: f64::from(turns) * end, length: (end - start).abs() })
    }
}

/// The loop round pole `k` along the boundaries of holes and the pole line between them. `None` if there are no holes,
/// or if they overlap.
fn join(mut holes: Vec<Gap>, k: usize, period: f64, projector: &Projector<'_>) -> Option<UvLoop> {
    let run = 1 - projector.poles[k].axis;
    let Gap { turns, from: first, .. } = *holes.first()?;
    if holes.iter().any(|hole| hole.turns != turns) {
        return None;
    }
    for hole in &mut holes {
        // All within one period from the first.
        let from = first + (hole.from - first).rem_euclid(period);
        let by = step_along(run, f64::from(turns) * (from - hole.from));
        hole.pieces.iter_mut().for_each(|piece| piece.shift(by));
        hole.from = from;
    }
    holes.sort_by(|a, b| a.from.total_cmp(&b.from));
    let next = |i: usize| holes.get(i + 1).map_or(first + period, |hole| hole.from);
    if (0..holes.len()).any(|i| holes[i].from + holes[i].length > next(i) + 1e-9 * period) {
        return None;
    }
    let mut pieces = Vec::new();
    for (i, hole) in holes.iter().enumerate() {
        pieces.extend_from_slice(&hole.pieces);
        let from = hole.pieces.last()?.end();
        let mut to = from;
        to[run] = f64::from(turns) * next(i);
        pieces.extend(pole_piece(projector, k, from, to));
    }
    let mut winding = [0, 0];
    winding[run] = turns;
    Some(UvLoop { pieces, winding })
}

/// The loops with one that goes round in direction `axis` turned back at a pole. `None` if no loop reaches a pole.
///
/// Along a pole a loop runs in the direction that keeps its left side. If noise exchanges the directions in which two
/// edges arrive there, it runs all the way round instead of a short way back, and no loop bounds its other side.
fn turn_back(loops: &[UvLoop], axis: usize, projector: &Projector<'_>) -> Option<Vec<UvLoop>> {
    let period = projector.period[axis]?;
    let along = |p: &Piece| {
        let Along::Pole(pole) = p.along else { return None };
        (projector.poles[pole].axis != axis).then(|| (p.end() - p.start())[axis])
    };
    let all = loops.iter().enumerate().filter(|(_, l)| l.winding[axis] != 0);
    let jumps = all.flat_map(|(k, l)| {
        let signum = f64::from(l.winding[axis].signum());
        l.pieces.iter().enumerate().filter_map(move |(i, p)| Some((k, i, signum * along(p)?)))
    });
    let (k, i, way) = jumps.max_by(|a, b| a.2.total_cmp(&b.2))?;
    if way <= 0.5 * period {
        return None;
    }
    let mut loops = loops.to_vec();
    let l = &mut loops[k];
    let turn = l.winding[axis].signum();
    turn_at_pole(&mut l.pieces, i, step_along(axis, -f64::from(turn) * period), projector);
    l.winding[axis] -= turn;
    Some(loops)
}

/// Whether loops cut holes into a surface that closes: the face is all of the rest.
pub(crate) fn are_holes(loops: &[UvLoop], projector: &Projector<'_>) -> bool {
    closes(projector) && !loops.is_empty() && loops.iter().all(|l| l.winding == [0, 0] && l.double_area() < 0.0)
}

/// Whether the surface closes in both directions, by a period or by poles.
fn closes(projector: &Projector<'_>) -> bool {
    let periodic = projector.period.map(|p| p.is_some());
    periodic != [false, false] && (0..2).all(|a| periodic[a] || both_poles(projector, a))
}

fn both_poles(projector: &Projector<'_>, axis: usize) -> bool {
    let (lo, hi) = projector.domain[axis];
    let is_pole = |x: f64| projector.poles.iter().any(|p| p.axis == axis && (p.at - x).abs() < 1e-12);
    lo.is_finite() && hi.is_finite() && is_pole(lo) && is_pole(hi)
}

/// Maximum number of turns of a face around the surface, in each direction.
fn most_turns(projector: &Projector<'_>) -> f64 {
    if projector.period.iter().all(Option::is_some) { MOST_TURNS_BOTH_WAYS } else { MOST_TURNS }
}

/// Number of points of a loop to test. One may lie on the other loop, at a common vertex.
const PROBES: usize = 5;

/// Points of a loop, for the question in which other it lies.
fn probes(points: &[DVec2]) -> [DVec2; PROBES] {
    let n = points.len();
    std::array::from_fn(|i| points[(i * n / PROBES + i) % n])
}

/// Moves loops and their polylines by whole periods so that all lie in or around the largest one. Whether any moved.
fn gather(loops: &mut [UvLoop], polylines: &mut [Vec<DVec2>], areas: &[f64], projector: &Projector<'_>) -> bool {
    let largest = (0..loops.len()).max_by(|&a, &b| areas[a].abs().total_cmp(&areas[b].abs()));
    let Some(outer) = largest.filter(|_| loops.len() > 1) else { return false };
    // Turns that are looked at in each direction.
    let most = most_turns(projector);
    let polygon = Polygon::new(polylines[outer].clone());
    let [low, high] = polygon.bounds;
    let mut moved = false;
    for (k, l) in loops.iter_mut().enumerate() {
        if k == outer {
            continue;
        }
        // One may lie on the largest loop, and several if an edge runs along its seam.
        let probes = probes(&polylines[k]);
        let probe = probes[0];
        // The loop may lie at any turn of the largest loop.
        let steps = |axis: usize| {
            let Some(period) = projector.period[axis] else { return 0..=0 };
            let turns = |x: f64| (x - probe[axis]) / period;
            let turns = [turns(low[axis]).floor(), turns(high[axis]).ceil()].map(|turns| turns.clamp(-most, most));
            (turns[0] as i64).min(-3)..=(turns[1] as i64).max(3)
        };
        let mut found = (0, DVec2::ZERO);
        for (i, j) in steps(0).flat_map(|i| steps(1).map(move |j| (i, j))) {
            let by = projector.turns([i as f64, j as f64]);
            let held = probes.iter().filter(|probe| polygon.holds(**probe + by)).count();
            if held > found.0 {
                found = (held, by);
            }
            if held == PROBES {
                break;
            }
        }
        let (_, by) = found;
        if by != DVec2::ZERO {
            l.shift(by);
            polylines[k] = l.polyline();
            moved = true;
        }
    }
    moved
}

/// Orients loops by nesting: outermost counter-clockwise, holes clockwise, islands counter-clockwise.
///
/// A loop that crosses the largest one is a hole if its stated direction is opposite. Other loops that cross are not
/// inside each other. Of two that coincide, the smaller one is a hole if its stated direction is opposite.
fn nest(loops: &mut [UvLoop], polylines: Vec<Vec<DVec2>>, areas: &[f64]) {
    let turn = |l: &mut UvLoop, area: f64, depth: usize| {
        if (area > 0.0) != depth.is_multiple_of(2) {
            l.reverse();
        }
    };
    if let [only] = loops {
        turn(only, areas[0], 0);
        return;
    }
    let polygons: Vec<Polygon> = polylines.into_iter().map(Polygon::new).collect();
    let boxes: Vec<[DVec2; 2]> = polygons.iter().map(|p| p.bounds).collect();
    let tree = BoxTree::new(&boxes);
    let largest = (0..areas.len()).max_by(|&a, &b| areas[a].abs().total_cmp(&areas[b].abs()));
    for (k, l) in loops.iter_mut().enumerate() {
        let probes = probes(&polygons[k].points);
        let holds = |o: usize| {
            if o == k {
                return false;
            }
            let opposite = (areas[k] > 0.0) != (areas[o] > 0.0);
            if coincide(boxes[o], areas[o], boxes[k], areas[k]) {
                // Points of one may be on either side of the other: a ring may be as thin as polygons are exact.
                return opposite && (areas[o].abs(), o) > (areas[k].abs(), k);
            }
            match probes.iter().filter(|q| polygons[o].holds(**q)).count() {
                0 | 1 => false,
                count if count + 1 >= PROBES => true,
                _ => largest == Some(o) && opposite,
            }
        };
        let mut depth = 0;
        tree.meeting(boxes[k], |o| depth += usize::from(holds(o)));
        turn(l, areas[k], depth);
    }
}

/// Whether two loops are the same, judged by their boxes and areas.
fn coincide(box_a: [DVec2; 2], area_a: f64, box_b: [DVec2; 2], area_b: f64) -> bool {
    const SAME: f64 = 1e-6;
    let near = SAME * (box_a[1] - box_a[0]).max_element();
    let boxes = (0..2).all(|k| box_a[k].distance(box_b[k]) <= near);
    boxes && (area_a.abs() - area_b.abs()).abs() <= SAME * area_a.abs()
}

/// The region between loops that go round in direction `axis`. They bound it alternately from below and from above.
fn band(
    mut loops: Vec<UvLoop>,
    axis: usize,
    named_pole: Option<usize>,
    projector: &Projector<'_>,
    turn: bool,
) -> Result<Region, RegionError> {
    let across = 1 - axis;
    if let Some(l) = loops.iter().find(|l| l.winding[across] != 0) {
        return Err(RegionError::Winding { winding: l.winding });
    }
    let (mut round, inner): (Vec<UvLoop>, Vec<UvLoop>) = loops.drain(..).partition(|l| l.winding[axis] != 0);
    let ends = if let Some(period) = projector.period[across] {
        pair_up(&mut round, axis, period, turn)?;
        [f64::NAN; 2]
    } else {
        stack(&mut round, axis, named_pole, projector, turn)?
    };
    let mut bounds = loops_box(&round);
    let to_ends = [!round.first().is_none_or(|l| is_lower(l, axis)), round.last().is_some_and(|l| is_lower(l, axis))];
    if to_ends[0] {
        bounds[across].0 = ends[0];
    }
    if to_ends[1] {
        bounds[across].1 = ends[1];
    }
    if !bounds.iter().all(|(low, high)| low.is_finite() && high.is_finite()) {
        // Loops that run as stated may need an end that the surface does not have.
        return Err(RegionError::OneSided { loops: round.len() });
    }
    // The winding number below the lowest loop is 1 if the region reaches the low end of the surface. Otherwise it is
    // such that neither side beyond an end is kept, or the one beyond the high end once if the region reaches that.
    let rise: i32 = round.iter().map(|l| l.winding[axis] * lower(axis)).sum();
    let base = if to_ends[0] { 1 } else { (i32::from(to_ends[1]) - rise).min(0) };
    let border = [bounds[across].0, bounds[across].1];
    let is_open = |&k: &usize| to_ends[k] && pole_along(projector, across, border[k]).is_none();
    let unbounded = (0..2).find(is_open).map(|k| (across, border[k]));
    let period = projector.period[axis].ok_or(RegionError::OneSided { loops: round.len() })?;
    bounds[axis] = (bounds[axis].0, bounds[axis].0 + period);
    round.extend(inner.into_iter().map(|l| hole(l, across, bounds[across], projector, turn)));
    let mut wraps = [false, false];
    wraps[axis] = true;
    Ok(Region { loops: round, wraps, bounds, base, unbounded })
}

/// Sign of the winding along `axis` of a loop that bounds a band from below.
fn lower(axis: usize) -> i32 {
    if axis == 0 { 1 } else { -1 }
}

/// Whether a loop bounds a band from below. A loop that goes round more than once crosses itself; winding numbers then
/// decide what it keeps.
fn is_lower(l: &UvLoop, axis: usize) -> bool {
    l.winding[axis].signum() == lower(axis)
}

/// Orders the two loops of a band on a surface that is periodic across it: the lower one, then the other one less than
/// a period above it.
fn pair_up(round: &mut [UvLoop], axis: usize, period: f64, turn: bool) -> Result<(), RegionError> {
    let across = 1 - axis;
    let [first, second] = round else { return Err(RegionError::OneSided { loops: round.len() }) };
    if turn && is_lower(first, axis) == is_lower(second, axis) {
        second.reverse();
    }
    round.sort_by_key(|l| !is_lower(l, axis));
    let rise = round[1].mean(across) - round[0].mean(across);
    round[1].shift(step_along(across, rise.rem_euclid(period) - rise));
    Ok(())
}

/// Orders the loops that go round a surface that is not periodic across them, and orients them alternately as lower and
/// upper bounds. Returns both ends of the surface.
fn stack(
    round: &mut [UvLoop],
    axis: usize,
    named_pole: Option<usize>,
    projector: &Projector<'_>,
    turn: bool,
) -> Result<[f64; 2], RegionError> {
    let across = 1 - axis;
    let (lo, hi) = projector.domain[across];
    let mut ends = [lo, hi];
    round.sort_by(|a, b| a.mean(across).total_cmp(&b.mean(across)));
    // A pole ends the surface as well (the apex of a cone).
    let (first, last) = (round[0].mean(across), round[round.len() - 1].mean(across));
    for p in projector.poles.iter().filter(|p| p.axis == across) {
        if p.at < first {
            ends[0] = ends[0].max(p.at);
        } else if p.at > last {
            ends[1] = ends[1].min(p.at);
        }
    }
    let sides: Vec<bool> = round.iter().map(|l| is_lower(l, axis)).collect();
    let fits = |first_is_lower: bool| sides.iter().enumerate().all(|(k, &s)| s == (first_is_lower == (k % 2 == 0)));
    let may_end = |first_is_lower: bool, at: [bool; 2]| {
        let last_is_lower = first_is_lower == (round.len() % 2 == 1);
        (first_is_lower || at[0]) && (!last_is_lower || at[1])
    };
    let possible = |first_is_lower: bool| may_end(first_is_lower, ends.map(f64::is_finite));
    let is_pole = ends.map(|end| projector.poles.iter().any(|p| p.axis == across && p.at == end));
    let closes = |first_is_lower: bool| may_end(first_is_lower, is_pole);
    let named = named_pole.map(|k| &projector.poles[k]).filter(|p| p.axis == across && round.len() == 1);
    let first_is_lower = match [true, false].into_iter().find(|&side| fits(side) && possible(side)) {
        // A vertex loop states which end of the surface is kept.
        _ if named.is_some_and(|p| possible(p.at > first)) => named.is_some_and(|p| p.at > first),
        // A face ends with its surface only if it has to.
        Some(stated) => stated == (closes(stated) || !closes(!stated)),
        // The stated orientation is impossible: prefer the one that needs no end of the surface.
        None if round.len().is_multiple_of(2) => true,
        None if possible(true) => true,
        None if possible(false) => false,
        None => return Err(RegionError::OneSided { loops: round.len() }),
    };
    for (k, l) in round.iter_mut().enumerate() {
        if turn && is_lower(l, axis) != (first_is_lower == (k % 2 == 0)) {
            l.reverse();
        }
    }
    Ok(ends)
}

/// A loop that does not go round is a hole: it runs clockwise, in the period nearest to the band.
fn hole(mut l: UvLoop, across: usize, (low, high): (f64, f64), projector: &Projector<'_>, turn: bool) -> UvLoop {
    if turn && l.double_area() > 0.0 {
        l.reverse();
    }
    if let Some(period) = projector.period[across] {
        let turns = ((0.5 * (low + high) - l.pieces[0].start()[across]) / period).round();
        l.shift(step_along(across, period * turns));
    }
    l
}

/// The poles at the ends of the region's box, by axis and side (0 low, 1 high).
pub(crate) fn pole_sides(region: &Region, projector: &Projector<'_>) -> [[Option<usize>; 2]; 2] {
    [0, 1].map(|axis| <[f64; 2]>::from(region.bounds[axis]).map(|x| pole_along(projector, axis, x)))
}

/// The pole along the parameter line at `x`.
fn pole_along(projector: &Projector<'_>, axis: usize, x: f64) -> Option<usize> {
    projector.poles.iter().position(|p| p.axis == axis && (p.at - x).abs() <= 1e-9 * (1.0 + x.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::uv::polygon::winding_about;
    use crate::prepare::uv::uv_curve::UvSample;
    use crate::sequence::random::SplitMix;

    /// The polygon as a loop of one piece, forwards or backwards.
    fn ring(points: &[DVec2], reversed: bool) -> UvLoop {
        let n = points.len();
        let sample = |k: usize| UvSample { t: k as f64, uv: points[k % n], d: DVec2::ZERO };
        let piece = Piece { along: Along::Edge(0), reversed, samples: (0..=n).map(sample).collect() };
        UvLoop { pieces: vec![piece], winding: [0, 0] }
    }

    #[test]
    fn a_ring_is_one_however_thin_it_is() {
        for wall in [1e-3, 1e-5, 1e-7, 1e-9, 0.0] {
            // Both rims, and which of them is stated backwards.
            for (backwards, expected) in [([false, true], [true, false]), ([true, false], [true, false])] {
                let rim = |radius: f64, turned: bool| {
                    let corner = |k: u32| radius * DVec2::from_angle(f64::from(k) * std::f64::consts::TAU / 64.0);
                    ring(&(0..64).map(corner).collect::<Vec<_>>(), turned)
                };
                let mut loops = [rim(1.0 + wall, backwards[0]), rim(1.0, backwards[1])];
                let polylines = loops.iter().map(UvLoop::polyline).collect();
                let areas = loops.each_ref().map(UvLoop::double_area);
                nest(&mut loops, polylines, &areas);
                let outlines = loops.each_ref().map(|l| l.double_area() > 0.0);
                let is_ring = if wall > 0.0 { outlines == expected } else { outlines[0] != outlines[1] };
                assert!(is_ring, "{wall} {backwards:?}: {outlines:?}");
            }
        }
    }

    #[test]
    fn holes_and_islands_are_those_that_a_look_at_all_loops_finds() {
        let mut random = SplitMix(7);
        let mut unit = || random.unit();
        // Stars in the quarters of stars, some with more corners than are tested one by one.
        let mut open = vec![(DVec2::ZERO, 1.0, 0)];
        let mut stars: Vec<Vec<DVec2>> = Vec::new();
        while let Some((centre, radius, depth)) = open.pop() {
            let corners = if unit() < 0.2 { 200 } else { 5 + (8.0 * unit()) as u32 };
            let corner = |k: u32| DVec2::from_angle(f64::from(k) * std::f64::consts::TAU / f64::from(corners));
            stars.push((0..corners).map(|k| centre + radius * (0.8 + 0.2 * unit()) * corner(k)).collect());
            for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
                if depth < 5 && unit() < 0.8 {
                    open.push((centre + 0.25 * radius * DVec2::new(x, y), 0.2 * radius, depth + 1));
                }
            }
        }
        assert!(stars.len() > 100);
        let mut loops: Vec<UvLoop> = stars.iter().map(|star| ring(star, unit() < 0.5)).collect();
        let polylines: Vec<Vec<DVec2>> = loops.iter().map(UvLoop::polyline).collect();
        let areas: Vec<f64> = loops.iter().map(UvLoop::double_area).collect();
        nest(&mut loops, polylines, &areas);
        for (k, l) in loops.iter().enumerate() {
            let depth = (0..stars.len()).filter(|&o| o != k && winding_about(&stars[o], stars[k][0]) != 0).count();
            assert_eq!(l.double_area() > 0.0, depth % 2 == 0, "loop {k}, inside {depth} others");
        }
    }
}
