//! A face's loops to a region of its unrolled parameter plane.
//!
//! On periodic surfaces a loop is followed by continuity, so it may end a whole number of periods from where it began
//! (its winding). Orientation is derived from areas, nesting and windings wherever they decide; the file's word counts
//! only on closed surfaces, where both sides of a loop are bounded.

use crate::math::box_tree::BoxTree;
use crate::model::{Coedge, Edge, Part, RegionError};
use crate::prepare::uv::pcurve::Projector;
use crate::prepare::uv::polygon::Polygon;
use crate::prepare::uv::region::{Region, loops_box};
use crate::prepare::uv::uv_curve::UvSample;
use crate::prepare::uv::uv_loop::{Along, Piece, UvLoop, area2};
use glam::{DVec2, DVec3};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Where edges of a face run through poles: parameter and point, as every tessellation of the edge has it.
pub(crate) type Passages = BTreeMap<u32, Vec<(f64, DVec3)>>;

/// A coedge's edge in loop order, split where it runs through a pole, with the points at the ends of each stretch.
fn stretches<'a>(part: &'a Part, c: &Coedge, passages: &Passages) -> Vec<(Cow<'a, Edge>, [DVec3; 2])> {
    let edge = &part.edges[c.edge.index()];
    let ends = [part.vertices[edge.start.index()], part.vertices[edge.end.index()]];
    let Some(stops) = passages.get(&c.edge.0) else {
        return vec![(Cow::Borrowed(edge), ends)];
    };
    let mut marks = vec![(edge.range.0, ends[0])];
    marks.extend(stops);
    marks.push((edge.range.1, ends[1]));
    let mut out: Vec<_> = marks
        .windows(2)
        .map(|w| (Cow::Owned(Edge { range: (w[0].0, w[1].0), ..edge.clone() }), [w[0].1, w[1].1]))
        .collect();
    if c.reversed {
        out.reverse();
    }
    out
}

/// Follows a loop over the surface, from the coedge that leaves the smallest gap where the loop closes. The second value
/// is that gap, millimetres, where it is more than a loop that closes has.
pub(crate) fn trace_loop(
    part: &Part,
    coedges: &[Coedge],
    projector: &Projector<'_>,
    gap: &mut f64,
    passages: &Passages,
) -> Result<(UvLoop, Option<f64>), RegionError> {
    /// First coedges tried when a loop does not close. The first that lies clear of a seam will do.
    const TRIES: usize = 6;
    let start_point = |c: &Coedge| {
        let e = &part.edges[c.edge.index()];
        part.vertices[if c.reversed { e.end } else { e.start }.index()]
    };
    if coedges.is_empty() {
        return Err(RegionError::EmptyLoop);
    }
    let closes = |miss: f64| miss <= 100.0 * projector.tolerance;
    let mut firsts: Vec<usize> =
        (0..coedges.len()).filter(|&k| projector.pole_at(start_point(&coedges[k])).is_none()).collect();
    if firsts.is_empty() {
        firsts.push(0);
    }
    let mut best: Option<(f64, f64, UvLoop)> = None;
    for &first in firsts.iter().take(TRIES) {
        let mut loop_gap = 0.0;
        let (traced, miss) = trace_from(part, coedges, first, projector, &mut loop_gap, passages)?;
        if best.as_ref().is_none_or(|b| miss < b.0) {
            best = Some((miss, loop_gap, traced));
        }
        if closes(miss) {
            break;
        }
    }
    let (miss, loop_gap, traced) = best.ok_or(RegionError::NotFinite)?;
    *gap = gap.max(loop_gap);
    Ok((traced, (!closes(miss)).then_some(miss)))
}

/// Follows a loop from its coedge `first`; the second value is the distance in space by which it fails to close.
fn trace_from(
    part: &Part,
    coedges: &[Coedge],
    first: usize,
    projector: &Projector<'_>,
    gap: &mut f64,
    passages: &Passages,
) -> Result<(UvLoop, f64), RegionError> {
    let mut pieces: Vec<Piece> = Vec::with_capacity(coedges.len() + 1);
    let mut jumps = Vec::new();
    for c in coedges[first..].iter().chain(&coedges[..first]) {
        for (edge, ends) in stretches(part, c, passages) {
            let runs = edge.range.0 < edge.range.1;
            if !runs {
                return Err(RegionError::EmptyEdge { edge: c.edge, range: edge.range });
            }
            let previous_end = pieces.last().map(Piece::end);
            let m = projector.march(&edge, ends, c.reversed, previous_end);
            if m.samples.iter().any(|s| !s.uv.is_finite()) {
                return Err(RegionError::NotFinite);
            }
            *gap = gap.max(m.gap);
            let mut piece = Piece { along: Along::Edge(c.edge.0), reversed: c.reversed, samples: m.samples };
            if let Some(end) = previous_end {
                match m.poles[usize::from(c.reversed)] {
                    Some(pole) => {
                        let inside = pieces.last().map_or(end, |p| p.samples[p.samples.len() / 2].uv);
                        let to = jump_target(projector, pole, inside, end, piece.start());
                        piece.shift(to - piece.start());
                        if let Some(jump) = pole_piece(projector, pole, end, to) {
                            jumps.push(pieces.len());
                            pieces.push(jump);
                        }
                    }
                    None => {
                        let by = projector.unwrap(piece.start(), end) - piece.start();
                        piece.shift(by);
                    }
                }
            }
            pieces.push(piece);
        }
    }
    let (start, end) = (pieces[0].start(), pieces[pieces.len() - 1].end());
    let edge = &part.edges[coedges[first].edge.index()];
    let start_point = part.vertices[if coedges[first].reversed { edge.end } else { edge.start }.index()];
    if let Some(pole) = projector.pole_at(start_point) {
        if let Some(jump) = pole_piece(projector, pole, end, start) {
            pieces.push(jump);
        }
        return Ok((UvLoop { pieces, winding: [0, 0] }, 0.0));
    }
    let mut winding = [0, 0];
    let mut miss = end - start;
    for axis in 0..2 {
        if let Some(p) = projector.period[axis] {
            let k = (miss[axis] / p).round();
            #[allow(clippy::cast_possible_truncation, reason = "a handful of turns")]
            {
                winding[axis] = k as i32;
            }
            miss[axis] -= k * p;
        }
    }
    let miss = projector.length(start, miss);
    // One jump at a pole: how far it goes round follows from closing the loop.
    if let ([jump], true) = (&jumps[..], winding != [0, 0]) {
        let mut by = DVec2::ZERO;
        for axis in 0..2 {
            by[axis] = -f64::from(winding[axis]) * projector.period[axis].unwrap_or(0.0);
        }
        let Along::Pole(pole) = pieces[*jump].along else { return Err(RegionError::Winding { winding }) };
        let (from, to) = (pieces[*jump - 1].end(), pieces[*jump].end() + by);
        pieces[jump + 1..].iter_mut().for_each(|p| p.shift(by));
        match pole_piece(projector, pole, from, to) {
            Some(piece) => pieces[*jump] = piece,
            None => {
                pieces.remove(*jump);
            }
        }
        winding = [0, 0];
    }
    Ok((UvLoop { pieces, winding }, miss))
}

/// Where the loop continues after touching a pole: kept side left means that it goes round one given way.
fn jump_target(projector: &Projector<'_>, pole: usize, inside: DVec2, from: DVec2, to: DVec2) -> DVec2 {
    let pole = &projector.poles[pole];
    let fixed = pole.axis;
    let run = 1 - fixed;
    let mut target = projector.unwrap(to, from);
    let Some(p) = projector.period[run] else { return target };
    // The kept side below a pole line v = at: the loop runs towards -u there; right of u = at: towards -v.
    let below = inside[fixed] < from[fixed];
    let positive = below != (fixed == 1);
    let mut by = (to[run] - from[run]).rem_euclid(p);
    if by < 1e-6 * p || by > (1.0 - 1e-6) * p {
        by = 0.0;
    }
    let by = match (positive, by == 0.0) {
        (true, true) => p,
        (true, false) => by,
        (false, true) => -p,
        (false, false) => by - p,
    };
    target[run] = from[run] + by;
    target
}

/// The stretch along a pole line; none where it has no length.
fn pole_piece(projector: &Projector<'_>, pole: usize, from: DVec2, to: DVec2) -> Option<Piece> {
    let fixed = projector.poles[pole].axis;
    let run = 1 - fixed;
    let (a, b) = (from[run], to[run]);
    if (a - b).abs() <= 1e-12 * (1.0 + a.abs() + b.abs()) {
        return None;
    }
    let sample = |t: f64| {
        let mut uv = DVec2::splat(from[fixed]);
        uv[run] = t;
        let mut d = DVec2::ZERO;
        d[run] = 1.0;
        UvSample { t, uv, d }
    };
    Some(Piece { along: Along::Pole(pole), reversed: a > b, samples: vec![sample(a.min(b)), sample(a.max(b))] })
}

/// The region that the loops bound. `named_pole`: the one at which the file puts a vertex loop. `turn`: whether loops are turned by
/// where they lie; else they run as they are.
pub(crate) fn region(
    mut loops: Vec<UvLoop>,
    named_pole: Option<usize>,
    projector: &Projector<'_>,
    turn: bool,
) -> Result<Region, RegionError> {
    /// Turns of a boundary around a periodic surface: springs have tens, threads and coils hundreds. More are noise.
    const MAX_PERIODS: f64 = 20_000.0;
    for (axis, (lo, hi)) in loops_box(&loops).into_iter().enumerate() {
        let periods = projector.period[axis].map_or(0.0, |p| (hi - lo) / p);
        let sound = (hi - lo).is_finite() && periods <= MAX_PERIODS;
        if !(loops.is_empty() || sound) {
            return Err(RegionError::Runaway { axis, periods });
        }
    }
    if let Some(axis) = (0..2).find(|&a| loops.iter().any(|l| l.winding[a] != 0)) {
        return band(loops, axis, named_pole, projector, turn);
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
    let areas: Vec<f64> = loops.iter().map(|l| area2(&l.polyline())).collect();
    let closed = (0..2).all(|a| periodic[a] || both_poles(projector, a)) && periodic != [false, false];
    if closed && areas.iter().all(|&a| a < 0.0) {
        if let Some(axis) = go_round_poles(&mut loops, projector) {
            return band(loops, axis, named_pole, projector, turn);
        }
        return Ok(Region { loops, wraps: periodic, bounds: projector.domain, base: 1, unbounded: None });
    }
    gather(&mut loops, &areas, projector);
    if turn {
        nest(&mut loops, &areas);
    }
    let bounds = loops_box(&loops);
    Ok(Region { loops, wraps: [false, false], bounds, base: 0, unbounded: None })
}

/// Turns holes that touch a pole into loops that go round it, and says in which direction they do; none if there are none.
///
/// What such a hole leaves of the pole line is the rest of its turn: the kept side is bounded by that.
fn go_round_poles(loops: &mut [UvLoop], projector: &Projector<'_>) -> Option<usize> {
    let mut round = None;
    for (k, pole) in projector.poles.iter().enumerate() {
        let run = 1 - pole.axis;
        let touches = |p: &Piece| p.along == Along::Pole(k);
        let mut touching = loops.iter_mut().filter(|l| l.pieces.iter().any(touches));
        let (Some(l), None, Some(period)) = (touching.next(), touching.next(), projector.period[run]) else { continue };
        let mut along_poles = (0..l.pieces.len()).filter(|&i| matches!(l.pieces[i].along, Along::Pole(_)));
        let (Some(jump), None) = (along_poles.next(), along_poles.next()) else { continue };
        let (from, to) = (l.pieces[jump].start(), l.pieces[jump].end());
        let turns = if to[run] > from[run] { -1 } else { 1 };
        let mut by = DVec2::ZERO;
        by[run] = f64::from(turns) * period;
        let Some(rest) = pole_piece(projector, k, from, to + by) else { continue };
        l.pieces[jump] = rest;
        l.pieces[jump + 1..].iter_mut().for_each(|p| p.shift(by));
        l.winding[run] = turns;
        round = Some(run);
    }
    round
}

fn both_poles(projector: &Projector<'_>, axis: usize) -> bool {
    let (lo, hi) = projector.domain[axis];
    let is_pole = |x: f64| projector.poles.iter().any(|p| p.axis == axis && (p.at - x).abs() < 1e-12);
    lo.is_finite() && hi.is_finite() && is_pole(lo) && is_pole(hi)
}

/// Moves loops by whole periods so that all lie in or around the largest one.
fn gather(loops: &mut [UvLoop], areas: &[f64], projector: &Projector<'_>) {
    if projector.period == [None, None] {
        return;
    }
    let Some(outer) = (0..loops.len()).max_by(|&a, &b| areas[a].abs().total_cmp(&areas[b].abs())) else { return };
    let polygon = Polygon::new(loops[outer].polyline());
    let [low, high] = polygon.bounds;
    for (k, l) in loops.iter_mut().enumerate() {
        if k == outer {
            continue;
        }
        let probe = l.pieces[0].samples[l.pieces[0].samples.len() / 2].uv;
        // As many turns as there are of the largest loop, whichever of them this one is at.
        let steps = |axis: usize| {
            let turns = |x: f64| projector.period[axis].map_or(0.0, |p| (x - probe[axis]) / p);
            (turns(low[axis]).floor() as i64).min(-3)..=(turns(high[axis]).ceil() as i64).max(3)
        };
        let found = steps(0).flat_map(|i| steps(1).map(move |j| (i, j))).find_map(|(i, j)| {
            let turns = DVec2::new(i as f64, j as f64);
            let by = turns * DVec2::from_array(projector.period.map(|p| p.unwrap_or(0.0)));
            polygon.holds(probe + by).then_some(by)
        });
        if let Some(by) = found {
            l.shift(by);
        }
    }
}

/// Orients loops by nesting: outermost counter-clockwise, holes clockwise, islands counter-clockwise.
///
/// A loop that crosses the largest one is a hole if the file runs it the other way; loops that cross others are not inside
/// them.
fn nest(loops: &mut [UvLoop], areas: &[f64]) {
    /// Points of a loop that are looked at: it may touch another at a vertex, so one of them does not count.
    const PROBES: usize = 5;
    let polygons: Vec<Polygon> = loops.iter().map(|l| Polygon::new(l.polyline())).collect();
    let boxes: Vec<[DVec2; 2]> = polygons.iter().map(|p| p.bounds).collect();
    let tree = BoxTree::new(&boxes);
    let largest = (0..areas.len()).max_by(|&a, &b| areas[a].abs().total_cmp(&areas[b].abs()));
    for (k, l) in loops.iter_mut().enumerate() {
        let points = &polygons[k].points;
        let n = points.len();
        let probes: [DVec2; PROBES] = std::array::from_fn(|i| points[(i * n / PROBES + i) % n]);
        let holds = |o: usize| {
            o != k
                && match probes.iter().filter(|q| polygons[o].holds(**q)).count() {
                    0 | 1 => false,
                    _ if coincide(boxes[o], areas[o], boxes[k], areas[k]) => false,
                    count if count + 1 >= PROBES => true,
                    _ => largest == Some(o) && (areas[k] > 0.0) != (areas[o] > 0.0),
                }
        };
        let mut depth = 0;
        tree.meeting(boxes[k], |o| depth += usize::from(holds(o)));
        if (areas[k] > 0.0) != (depth % 2 == 0) {
            l.reverse();
        }
    }
}

/// Whether two loops are one given twice, for all that boxes and areas tell.
fn coincide(box_a: [DVec2; 2], area_a: f64, box_b: [DVec2; 2], area_b: f64) -> bool {
    const SAME: f64 = 1e-6;
    let near = SAME * (box_a[1] - box_a[0]).max_element();
    let boxes = (0..2).all(|k| box_a[k].distance(box_b[k]) <= near);
    boxes && (area_a.abs() - area_b.abs()).abs() <= SAME * area_a.abs()
}

/// Loops that go round in direction `axis`: they bound the region across, alternately from below and from above.
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
    let lower = if axis == 0 { 1 } else { -1 };
    // A loop may go round more than once: it crosses itself then, and the winding numbers say what it keeps.
    let is_lower = |l: &UvLoop| l.winding[axis].signum() == lower;
    let (mut round, mut inner): (Vec<UvLoop>, Vec<UvLoop>) = loops.drain(..).partition(|l| l.winding[axis] != 0);
    let mean = |l: &UvLoop| {
        let p = l.polyline();
        p.iter().map(|q| q[across]).sum::<f64>() / p.len() as f64
    };
    let (lo, hi) = projector.domain[across];
    let mut ends = [lo, hi].map(|x| if projector.period[across].is_some() { f64::NAN } else { x });
    if let Some(p) = projector.period[across] {
        if round.len() != 2 {
            return Err(RegionError::OneSided { loops: round.len() });
        }
        if turn && is_lower(&round[0]) == is_lower(&round[1]) {
            round[1].reverse();
        }
        round.sort_by_key(|l| !is_lower(l));
        let up = (mean(&round[1]) - mean(&round[0])).rem_euclid(p) - (mean(&round[1]) - mean(&round[0]));
        let mut by = DVec2::ZERO;
        by[across] = up;
        round[1].shift(by);
    } else {
        round.sort_by(|a, b| mean(a).total_cmp(&mean(b)));
        // A pole ends the surface as well (the apex of a cone).
        let (first, last) = (mean(&round[0]), mean(&round[round.len() - 1]));
        for p in projector.poles.iter().filter(|p| p.axis == across) {
            if p.at < first {
                ends[0] = ends[0].max(p.at);
            } else if p.at > last {
                ends[1] = ends[1].min(p.at);
            }
        }
        let sides: Vec<bool> = round.iter().map(is_lower).collect();
        let fits = |first_is_lower: bool| sides.iter().enumerate().all(|(k, &s)| s == (first_is_lower == (k % 2 == 0)));
        let possible = |first_is_lower: bool| {
            let last_is_lower = first_is_lower == (round.len() % 2 == 1);
            (first_is_lower || ends[0].is_finite()) && (!last_is_lower || ends[1].is_finite())
        };
        let named = named_pole.map(|k| &projector.poles[k]).filter(|p| p.axis == across && round.len() == 1);
        let first_is_lower = match (fits(true) && possible(true), fits(false) && possible(false)) {
            // A vertex loop says which end of the surface is kept.
            _ if named.is_some_and(|p| possible(p.at > first)) => named.is_some_and(|p| p.at > first),
            (true, _) => true,
            (_, true) => false,
            // The stated orientation cannot be: the one that closes without the surface's own ends is right.
            _ if round.len() % 2 == 0 => true,
            _ if possible(true) => true,
            _ if possible(false) => false,
            _ => return Err(RegionError::OneSided { loops: round.len() }),
        };
        for (k, l) in round.iter_mut().enumerate() {
            if turn && is_lower(l) != (first_is_lower == (k % 2 == 0)) {
                l.reverse();
            }
        }
    }
    let mut bounds = loops_box(&round);
    let to_ends = [!round.first().is_none_or(is_lower), round.last().is_some_and(is_lower)];
    if to_ends[0] {
        bounds[across].0 = ends[0];
    }
    if to_ends[1] {
        bounds[across].1 = ends[1];
    }
    if !bounds.iter().all(|(low, high)| low.is_finite() && high.is_finite()) {
        // Loops that were not turned may ask for an end where there is none.
        return Err(RegionError::OneSided { loops: round.len() });
    }
    // Kept once beyond the low end if the surface ends there; else such that nothing is kept beyond either end, or once
    // beyond the high one if the surface ends there.
    let rise: i32 = round.iter().map(|l| l.winding[axis] * lower).sum();
    let base = if to_ends[0] { 1 } else { (i32::from(to_ends[1]) - rise).min(0) };
    let is_pole =
        |x: f64| projector.poles.iter().any(|p| p.axis == across && (p.at - x).abs() <= 1e-9 * (1.0 + x.abs()));
    let border = [bounds[across].0, bounds[across].1];
    let unbounded = (0..2).find(|&k| to_ends[k] && !is_pole(border[k])).map(|k| (across, border[k]));
    let period = projector.period[axis].ok_or(RegionError::OneSided { loops: round.len() })?;
    bounds[axis] = (bounds[axis].0, bounds[axis].0 + period);
    // Loops that do not go round are holes.
    for l in &mut inner {
        if turn && area2(&l.polyline()) > 0.0 {
            l.reverse();
        }
        if let Some(p) = projector.period[across] {
            let c = l.pieces[0].start()[across];
            let mut by = DVec2::ZERO;
            by[across] = p * ((0.5 * (bounds[across].0 + bounds[across].1) - c) / p).round();
            l.shift(by);
        }
    }
    round.append(&mut inner);
    let mut wraps = [false, false];
    wraps[axis] = true;
    Ok(Region { loops: round, wraps, bounds, base, unbounded })
}

/// The poles at the ends of the region's box, by axis and side (0 low, 1 high).
pub(crate) fn pole_sides(region: &Region, projector: &Projector<'_>) -> [[Option<usize>; 2]; 2] {
    let at = |axis: usize, x: f64| {
        let scale = 1e-9 * (1.0 + x.abs());
        projector.poles.iter().position(|p| p.axis == axis && (p.at - x).abs() <= scale)
    };
    [0, 1].map(|axis| [at(axis, region.bounds[axis].0), at(axis, region.bounds[axis].1)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::uv::uv_loop::winding_about;

    /// The polygon as a loop of one piece, forwards or backwards.
    fn ring(points: &[DVec2], reversed: bool) -> UvLoop {
        let n = points.len();
        let sample = |k: usize| UvSample { t: k as f64, uv: points[k % n], d: DVec2::ZERO };
        let piece = Piece { along: Along::Edge(0), reversed, samples: (0..=n).map(sample).collect() };
        UvLoop { pieces: vec![piece], winding: [0, 0] }
    }

    #[test]
    fn holes_and_islands_are_those_that_a_look_at_all_loops_finds() {
        let mut state = 7_u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        // Stars in the quarters of stars, some of them with more corners than are looked at one by one.
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
        let areas: Vec<f64> = loops.iter().map(|l| area2(&l.polyline())).collect();
        nest(&mut loops, &areas);
        for (k, l) in loops.iter().enumerate() {
            let depth = (0..stars.len()).filter(|&o| o != k && winding_about(&stars[o], stars[k][0]) != 0).count();
            assert_eq!(area2(&l.polyline()) > 0.0, depth % 2 == 0, "loop {k}, inside {depth} others");
        }
    }
}
