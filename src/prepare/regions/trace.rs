//! Coedges of a loop -> their pcurves on the surface, connected from edge to edge and along poles.

use crate::math::lanes::larger;
use crate::model::{Coedge, Edge, Part, Pole, RegionError};
use crate::prepare::uv::projector::Projector;
use crate::prepare::uv::uv_curve::{UvSample, step_along};
use crate::prepare::uv::uv_loop::{Along, Piece, UvLoop};
use glam::{DVec2, DVec3};
use smallvec::{SmallVec, smallvec};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Where edges of a face run through poles: parameter and point, which every tessellation of the edge contains.
pub(crate) type Passages = BTreeMap<u32, Vec<(f64, DVec3)>>;

/// Stretches of an edge, nearly always one.
type Stretches<'a> = SmallVec<[(Cow<'a, Edge>, [DVec3; 2]); 1]>;

/// A coedge's edge, split where it runs through a pole: stretches in loop order, with their end points.
fn stretches<'a>(part: &'a Part, c: &Coedge, passages: &Passages) -> Stretches<'a> {
    let edge = &part.edges[c.edge.index()];
    let ends = [part.vertices[edge.start.index()], part.vertices[edge.end.index()]];
    let Some(stops) = passages.get(&c.edge.0) else {
        return smallvec![(Cow::Borrowed(edge), ends)];
    };
    let mut marks = vec![(edge.range.0, ends[0])];
    marks.extend(stops);
    marks.push((edge.range.1, ends[1]));
    let mut out: Stretches<'a> = marks
        .windows(2)
        .map(|w| (Cow::Owned(Edge { range: (w[0].0, w[1].0), ..edge.clone() }), [w[0].1, w[1].1]))
        .collect();
    if c.reversed {
        out.reverse();
    }
    out
}

/// Directions at a pole that differ by less than this share of a turn may be the same.
const SAME_DIRECTION: f64 = 0.01;

/// Traces a loop over the surface, from the coedge that leaves the smallest gap where the loop closes. If none closes
/// it, also from each sheet of the surface at their starts. The second value is that gap, mm, or the longest leap of a
/// pcurve, if the loop does not close. Raises `gap` to the largest distance between edge and surface.
pub(crate) fn trace_loop(
    part: &Part,
    coedges: &[Coedge],
    projector: &Projector<'_>,
    gap: &mut f64,
    passages: &Passages,
) -> Result<(UvLoop, Option<f64>), RegionError> {
    /// First coedges tried while a loop does not close. One that is clear of a seam suffices.
    const TRIES: usize = 6;
    if coedges.is_empty() {
        return Err(RegionError::EmptyLoop);
    }
    let coedges = &without_spikes(part, coedges, projector)[..];
    let closes = |miss: f64| miss <= 100.0 * projector.tolerance;
    let is_clear = |k: &usize| projector.pole_at(start_point(part, &coedges[*k])).is_none();
    let mut firsts: SmallVec<[usize; TRIES]> = (0..coedges.len()).filter(is_clear).take(TRIES).collect();
    if firsts.is_empty() {
        firsts.push(0);
    }
    let on_sheets = |&first: &usize| {
        let sheets = projector.sheets_at(start_point(part, &coedges[first]));
        // The only one was tried.
        let count = if sheets.len() > 1 { sheets.len() } else { 0 };
        sheets.into_iter().take(count).map(move |uv| (first, Some(uv)))
    };
    let mut best: Option<(f64, f64, UvLoop)> = None;
    for (first, seed) in firsts.iter().map(|&first| (first, None)).chain(firsts.iter().flat_map(on_sheets)) {
        let mut loop_gap = 0.0;
        let (traced, miss) = match trace_from(part, coedges, (first, seed), projector, &mut loop_gap, passages) {
            Ok(traced) => traced,
            // An earlier try is usable.
            Err(_) if best.is_some() => continue,
            Err(error) => return Err(error),
        };
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

/// The coedges without edges there and back within the reach of a pole, unless there are no others. Programs draw a
/// cone's seam up to its apex, though the loop passes within that reach of it.
fn without_spikes<'a>(part: &Part, coedges: &'a [Coedge], projector: &Projector<'_>) -> Cow<'a, [Coedge]> {
    let n = coedges.len();
    let is_spike = |k: usize| {
        let (there, back) = (&coedges[k % n], &coedges[(k + 1) % n]);
        let stays = || {
            let edge = &part.edges[there.edge.index()];
            let [start, end] = [edge.start, edge.end].map(|v| part.vertices[v.index()]);
            let middle = edge.curve.point(0.5 * (edge.range.0 + edge.range.1));
            let at = projector.pole_at(middle);
            at.is_some() && [start, end].into_iter().all(|point| projector.pole_at(point) == at)
        };
        there.edge == back.edge && there.reversed != back.reversed && stays()
    };
    if projector.poles.is_empty() || n < 3 || !(0..n).any(is_spike) {
        return Cow::Borrowed(coedges);
    }
    let others: Vec<Coedge> = (0..n).filter(|&k| !is_spike(k) && !is_spike(k + n - 1)).map(|k| coedges[k]).collect();
    if others.is_empty() { Cow::Borrowed(coedges) } else { Cow::Owned(others) }
}

/// Traces a loop from its coedge `first`. The second value is the distance in space by which it fails to close, or the
/// longest leap within an edge.
fn trace_from(
    part: &Part,
    coedges: &[Coedge],
    (first, seed): (usize, Option<DVec2>),
    projector: &Projector<'_>,
    gap: &mut f64,
    passages: &Passages,
) -> Result<(UvLoop, f64), RegionError> {
    let mut pieces: Vec<Piece> = Vec::with_capacity(coedges.len() + 1);
    let mut jumps = Vec::new();
    let mut leap = 0.0;
    for c in coedges[first..].iter().chain(&coedges[..first]) {
        for (edge, ends) in stretches(part, c, passages) {
            let runs = edge.range.0 < edge.range.1;
            if !runs {
                return Err(RegionError::EmptyEdge { edge: c.edge, range: edge.range });
            }
            let previous_end = pieces.last().map(Piece::end);
            let m = projector.march(&edge, ends, c.reversed, previous_end.or(seed));
            if m.samples.iter().any(|s| !s.uv.is_finite()) {
                return Err(RegionError::NotFinite);
            }
            *gap = gap.max(m.gap);
            leap = larger(m.leap, leap);
            let mut piece = Piece { along: Along::Edge(c.edge.0), reversed: c.reversed, samples: m.samples };
            if let Some(end) = previous_end {
                match m.poles[usize::from(c.reversed)] {
                    Some(pole) => {
                        let before = pieces.last_mut();
                        if let Some(jump) = before.and_then(|before| join(projector, pole, [before, &mut piece])) {
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
    if let Some(pole) = projector.pole_at(start_point(part, &coedges[first])) {
        // Both ends stay where they are, but for noise.
        let last = pieces.len() - 1;
        if let ([after, ..], [before]) = pieces.split_at_mut(last) {
            _ = target_without_noise(projector, pole, [before, after]);
        }
        let closing = pole_piece(projector, pole, pieces[last].end(), pieces[0].start());
        pieces.extend(closing);
        return Ok((UvLoop { pieces, winding: [0, 0] }, leap));
    }
    let (start, end) = (pieces[0].start(), pieces[pieces.len() - 1].end());
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
    let miss = larger(projector.length(start, miss), leap);
    // If there is one jump at a pole, closing the loop determines how far it goes round.
    if let ([jump], true) = (&jumps[..], winding != [0, 0]) {
        turn_at_pole(&mut pieces, *jump, -projector.turns(winding.map(f64::from)), projector);
        winding = [0, 0];
    }
    Ok((UvLoop { pieces, winding }, miss))
}

/// Joins two pieces at a pole: shifts the second one, and returns the stretch along the pole between them, if it has
/// any length.
fn join(projector: &Projector<'_>, pole: usize, [before, after]: [&mut Piece; 2]) -> Option<Piece> {
    let to = target_without_noise(projector, pole, [before, after]);
    after.shift(to - after.start());
    pole_piece(projector, pole, before.end(), after.start())
}

/// [`jump_target`]. Where the two pieces would cross next to the pole, because their directions there are noise, one
/// gets that of the other: the one that turns less there has the better one.
fn target_without_noise(projector: &Projector<'_>, pole: usize, [before, after]: [&mut Piece; 2]) -> DVec2 {
    let run = 1 - projector.poles[pole].axis;
    let (mut to, is_noise) = jump_target(projector, pole, [before, after]);
    if is_noise {
        let noise = (to - before.end())[run];
        let turns = |[end, next]: [&UvSample; 2]| (end.uv - next.uv)[run].abs();
        if turns(next_to_end(before, true)) <= turns(next_to_end(after, false)) {
            move_end(after, false, run, -noise);
            to[run] -= noise;
        } else {
            move_end(before, true, run, noise);
        }
    }
    to
}

/// Where the loop continues after touching a pole, between these two pieces. The kept side is on the left, which
/// determines the way around. A loop that goes on beyond the pole takes the shortest way.
///
/// The second value is true if the directions at the pole are noise: they say that the pieces cross next to it.
fn jump_target(projector: &Projector<'_>, pole: usize, pieces: [&Piece; 2]) -> (DVec2, bool) {
    let pole = &projector.poles[pole];
    let fixed = pole.axis;
    let run = 1 - fixed;
    let (from, to) = (pieces[0].end(), pieces[1].start());
    let mut target = projector.unwrap(to, from);
    let Some(p) = projector.period[run] else { return (target, false) };
    let middle = |piece: &Piece| piece.samples[piece.samples.len() / 2].uv;
    let [before, after] = [middle(pieces[0]) - from, middle(pieces[1]) - to].map(|way| way[fixed]);
    let by = (to[run] - from[run]) - p * ((to[run] - from[run]) / p).round();
    let mut by = if by.abs() < 1e-6 * p { 0.0 } else { by };
    let mut is_noise = false;
    if before * after >= 0.0 {
        // If the kept side is below a pole line v = at, the loop runs towards -u; if it is right of u = at, towards -v.
        let way = if (before < 0.0) != (fixed == 1) { 1.0 } else { -1.0 };
        let apart = if by.abs() < SAME_DIRECTION * p { beside(projector, pole, pieces, by) } else { None };
        // If it leaves on the way on which it came, it goes all around the pole.
        let is_short = apart.unwrap_or(by) * way > 0.0;
        is_noise = is_short && by * way < 0.0;
        by += if is_short { 0.0 } else { way * p };
    }
    target[run] = from[run] + by;
    (target, is_noise)
}

/// The sample at the end of a piece (or at its start), and the one next to it.
fn next_to_end(piece: &Piece, ends: bool) -> [&UvSample; 2] {
    let (s, last) = (&piece.samples, piece.samples.len() - 1);
    if piece.reversed == ends { [&s[0], &s[1]] } else { [&s[last], &s[last - 1]] }
}

/// Moves the end of a piece (or its start) along the pole there, and lets it arrive straight.
fn move_end(piece: &mut Piece, ends: bool, run: usize, by: f64) {
    let [end, next] = next_to_end(piece, ends);
    let at = end.uv[run] + by;
    let slope = (at - next.uv[run]) / (end.t - next.t);
    let k = if piece.reversed == ends { 0 } else { piece.samples.len() - 1 };
    piece.samples[k].uv[run] = at;
    piece.samples[k].d[run] = slope;
}

/// How far along the pole line the second piece is from the first one, where the two are farthest apart in space. They
/// meet at the pole in almost one direction, which may be noise; `by` is how far apart they are there. `None` if they
/// are nowhere apart.
fn beside(projector: &Projector<'_>, pole: &Pole, [before, after]: [&Piece; 2], by: f64) -> Option<f64> {
    /// Number of distances from the pole that are compared.
    const STEPS: usize = 16;
    let run = 1 - pole.axis;
    let [back, forth] = [(before, true), (after, false)].map(|(piece, ends)| away(piece, ends, pole.axis));
    let farthest = |way: &[DVec2]| (way[way.len() - 1] - way[0])[pole.axis].abs();
    let common = farthest(&back).min(farthest(&forth));
    if common == 0.0 {
        return None;
    }
    let mut widest = (10.0 * projector.tolerance, None);
    for k in 1..=STEPS {
        let distance = common * k as f64 / STEPS as f64;
        let [came, leaves] = [&back, &forth].map(|way| at_distance(way, distance, pole.axis));
        let step = by + (leaves - forth[0])[run] - (came - back[0])[run];
        let apart = projector.length(came, step_along(run, step));
        if apart > widest.0 {
            widest = (apart, Some(step));
        }
    }
    widest.1
}

/// Points of a piece from its end (or start) at a pole, as long as they lead away from it.
fn away(piece: &Piece, ends: bool, fixed: usize) -> Vec<DVec2> {
    /// Number of points for each sample.
    const FINE: usize = 8;
    let spans = piece.samples.windows(2).flat_map(|w| {
        let at = move |k: usize| w[0].t + (w[1].t - w[0].t) * k as f64 / FINE as f64;
        (0..FINE).map(move |k| UvSample::interpolate(&w[0], &w[1], at(k)))
    });
    let mut points: Vec<DVec2> = spans.chain([piece.samples[piece.samples.len() - 1].uv]).collect();
    if piece.reversed != ends {
        points.reverse();
    }
    let distance = |p: DVec2| (p - points[0])[fixed].abs();
    let count = points.windows(2).take_while(|w| distance(w[1]) > distance(w[0])).count();
    points.truncate(1 + count);
    points
}

/// The point of a way from a pole at a distance from it, which the way has.
fn at_distance(way: &[DVec2], distance: f64, fixed: usize) -> DVec2 {
    let distance_of = |p: DVec2| (p - way[0])[fixed].abs();
    let k = way.partition_point(|p| distance_of(*p) < distance).clamp(1, way.len() - 1);
    let [a, b] = [way[k - 1], way[k]];
    a.lerp(b, ((distance - distance_of(a)) / (distance_of(b) - distance_of(a))).clamp(0.0, 1.0))
}

/// The stretch along a pole line; `None` if it has no length.
pub(crate) fn pole_piece(projector: &Projector<'_>, pole: usize, from: DVec2, to: DVec2) -> Option<Piece> {
    let fixed = projector.poles[pole].axis;
    let run = 1 - fixed;
    let (a, b) = (from[run], to[run]);
    if (a - b).abs() <= 1e-12 * (1.0 + a.abs() + b.abs()) {
        return None;
    }
    let sample = |t: f64| {
        let mut uv = DVec2::splat(from[fixed]);
        uv[run] = t;
        UvSample::along(run, uv)
    };
    Some(Piece { along: Along::Pole(pole), reversed: a > b, samples: vec![sample(a.min(b)), sample(a.max(b))] })
}

/// The point of the vertex where a coedge starts.
fn start_point(part: &Part, coedge: &Coedge) -> DVec3 {
    let [start, _] = part.edges[coedge.edge.index()].ends(coedge.reversed);
    part.vertices[start.index()]
}

/// Shifts the pieces after the stretch `jump` along a pole and extends it to them. Removes it at length 0.
pub(crate) fn turn_at_pole(pieces: &mut Vec<Piece>, jump: usize, by: DVec2, projector: &Projector<'_>) {
    let Along::Pole(pole) = pieces[jump].along else { return };
    let (from, to) = (pieces[jump].start(), pieces[jump].end() + by);
    pieces[jump + 1..].iter_mut().for_each(|p| p.shift(by));
    match pole_piece(projector, pole, from, to) {
        Some(piece) => pieces[jump] = piece,
        None => drop(pieces.remove(jump)),
    }
}
