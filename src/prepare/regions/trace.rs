//! Coedges of a loop -> their pcurves on the surface, connected from edge to edge and along poles.

use crate::model::{Coedge, Edge, Part, RegionError};
use crate::prepare::uv::pcurve::Projector;
use crate::prepare::uv::uv_curve::UvSample;
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

/// Traces a loop over the surface, from the coedge that leaves the smallest gap where the loop closes. The second value
/// is that gap, mm, if the loop does not close. Raises `gap` to the largest distance between edge and surface.
pub(crate) fn trace_loop(
    part: &Part,
    coedges: &[Coedge],
    projector: &Projector<'_>,
    gap: &mut f64,
    passages: &Passages,
) -> Result<(UvLoop, Option<f64>), RegionError> {
    /// First coedges tried while a loop does not close. One that is clear of a seam suffices.
    const TRIES: usize = 6;
    let start_point = |c: &Coedge| {
        let e = &part.edges[c.edge.index()];
        part.vertices[if c.reversed { e.end } else { e.start }.index()]
    };
    if coedges.is_empty() {
        return Err(RegionError::EmptyLoop);
    }
    let coedges = &without_spikes(part, coedges, projector)[..];
    let closes = |miss: f64| miss <= 100.0 * projector.tolerance;
    let is_clear = |k: &usize| projector.pole_at(start_point(&coedges[*k])).is_none();
    let mut firsts: SmallVec<[usize; TRIES]> = (0..coedges.len()).filter(is_clear).take(TRIES).collect();
    if firsts.is_empty() {
        firsts.push(0);
    }
    let mut best: Option<(f64, f64, UvLoop)> = None;
    for first in firsts {
        let mut loop_gap = 0.0;
        let (traced, miss) = match trace_from(part, coedges, first, projector, &mut loop_gap, passages) {
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

/// Traces a loop from its coedge `first`. The second value is the distance in space by which it fails to close.
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
                        let middle = |piece: &Piece| piece.samples[piece.samples.len() / 2].uv;
                        let inside = [pieces.last().map_or(end, middle) - end, middle(&piece) - piece.start()];
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
    // If there is one jump at a pole, closing the loop determines how far it goes round.
    if let ([jump], true) = (&jumps[..], winding != [0, 0]) {
        let mut by = DVec2::ZERO;
        for axis in 0..2 {
            by[axis] = -f64::from(winding[axis]) * projector.period[axis].unwrap_or(0.0);
        }
        turn_at_pole(&mut pieces, *jump, by, projector);
        winding = [0, 0];
    }
    Ok((UvLoop { pieces, winding }, miss))
}

/// Where the loop continues after touching a pole. The kept side is on the left, which determines the way around. A loop
/// that goes on beyond the pole takes the shortest way. `inside` leads from the pole into the pieces before and after.
fn jump_target(projector: &Projector<'_>, pole: usize, inside: [DVec2; 2], from: DVec2, to: DVec2) -> DVec2 {
    let pole = &projector.poles[pole];
    let fixed = pole.axis;
    let run = 1 - fixed;
    let mut target = projector.unwrap(to, from);
    let Some(p) = projector.period[run] else { return target };
    let [before, after] = inside.map(|way| way[fixed]);
    let through = before * after < 0.0;
    // If the kept side is below a pole line v = at, the loop runs towards -u; if it is right of u = at, towards -v.
    let positive = (before < 0.0) != (fixed == 1);
    let mut by = (to[run] - from[run]).rem_euclid(p);
    if by < 1e-6 * p || by > (1.0 - 1e-6) * p {
        by = 0.0;
    }
    let by = match (through, positive, by == 0.0) {
        (true, ..) => by - p * (by / p).round(),
        (false, true, true) => p,
        (false, true, false) => by,
        (false, false, true) => -p,
        (false, false, false) => by - p,
    };
    target[run] = from[run] + by;
    target
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
        let mut d = DVec2::ZERO;
        d[run] = 1.0;
        UvSample { t, uv, d }
    };
    Some(Piece { along: Along::Pole(pole), reversed: a > b, samples: vec![sample(a.min(b)), sample(a.max(b))] })
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
