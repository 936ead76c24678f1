//! Self-crossing loops -> loops that keep every lobe: lobes that run backwards, outside all others, are reversed.
//!
//! A loop is cut at its crossings and reconnected there the other way (Seifert's smoothing of a diagram). That leaves
//! loops without crossings, with the same winding numbers. A figure eight becomes its two lobes, in opposite
//! directions. A star becomes its outline and its core, in the same direction.

use crate::prepare::uv::polygon::winding_about;
use crate::prepare::uv::projector::Projector;
use crate::prepare::uv::uv_curve::{SAME_SHARE, UvSample, newton_meeting};
use crate::prepare::uv::uv_loop::{Along, LoopPlace, Passed, Piece, Region, UvLoop};
use glam::DVec2;

/// A loop with more segments stays as it is: every pair of segments whose boxes overlap is tested.
const MAX_SEGMENTS: usize = 20_000;

/// A loop with more crossings is a scribble without meaningful lobes.
const MAX_CROSSINGS: usize = 64;

/// The lobes that were reversed.
pub(crate) struct TurnedLobes {
    pub(crate) lobes: usize,
    /// Their area, mm². Accurate to a few per cent.
    pub(crate) area: f64,
    pub(crate) cuts: Vec<LobeCut>,
}

/// A point that a loop passes twice, where it was cut.
pub(crate) struct LobeCut {
    /// Edge and parameter of both passes; `None` along a pole.
    pub(crate) passes: [Option<(u32, f64)>; 2],
    pub(crate) uv: DVec2,
}

/// Whether a loop stays as it is because one of its edges is `shared`.
pub(crate) fn stays(l: &UvLoop, shared: &[bool]) -> bool {
    l.pieces.iter().any(|p| matches!(p.along, Along::Edge(edge) if shared[edge as usize]))
}

/// Reverses lobes of a region's loops that run backwards outside their other lobes. `None` if there are none. Loops
/// along edges that are `shared` stay as they are, since the adjacent faces keep theirs.
pub(crate) fn turn(region: &mut Region, projector: &Projector<'_>, shared: &[bool]) -> Option<TurnedLobes> {
    if region.wraps != [false, false] {
        return None;
    }
    let mut done = TurnedLobes { lobes: 0, area: 0.0, cuts: Vec::new() };
    let mut loops = Vec::with_capacity(region.loops.len());
    let polygons: Vec<Vec<DVec2>> = region.loops.iter().map(UvLoop::polyline).collect();
    for (k, l) in std::mem::take(&mut region.loops).into_iter().enumerate() {
        if stays(&l, shared) {
            loops.push(l);
            continue;
        }
        let extent = |axis: usize| region.bounds[axis].1 - region.bounds[axis].0;
        let near = SAME_SHARE * extent(0).max(extent(1));
        let outside = || {
            let around = |o: &usize| *o != k && winding_about(&polygons[*o], polygons[k][polygons[k].len() / 2]) != 0;
            (0..polygons.len()).filter(around).count() % 2 == 0
        };
        // Lobes of equal size cancel, which leaves an area without a meaningful sign.
        let area = l.double_area();
        let positive = if area.abs() > near * near { area > 0.0 } else { outside() };
        match lobes(&l, positive, near, projector, &mut done) {
            Some(parts) => loops.extend(parts),
            None => loops.push(l),
        }
    }
    region.loops = loops;
    (done.lobes > 0).then_some(done)
}

/// The simple loops of one loop, reversed where they run backwards. `None` if none does.
fn lobes(
    l: &UvLoop,
    positive: bool,
    near: f64,
    projector: &Projector<'_>,
    done: &mut TurnedLobes,
) -> Option<Vec<UvLoop>> {
    let crossings = crossings(l, near)?;
    // Both passes of every crossing, in loop order, with the number of the crossing.
    let mut passes: Vec<(LoopPlace, usize)> =
        crossings.iter().enumerate().flat_map(|(k, c)| c.at.map(|at| (at, k))).collect();
    let along = |at: LoopPlace| (at.piece, if l.pieces[at.piece].reversed { -at.t } else { at.t });
    passes.sort_by(|a, b| {
        let ((p, t), (q, s)) = (along(a.0), along(b.0));
        p.cmp(&q).then(t.total_cmp(&s)).then(a.1.cmp(&b.1))
    });
    let count = passes.len();
    let partner = |k: usize| (0..count).find(|&j| j != k && passes[j].1 == passes[k].1).unwrap_or(k);
    let mut used = vec![false; count];
    let mut parts: Vec<UvLoop> = Vec::new();
    for first in 0..count {
        let mut pieces = Vec::new();
        let mut k = first;
        while !used[k] {
            used[k] = true;
            let (from, to) = (&passes[k], &passes[(k + 1) % count]);
            let ends = [crossings[from.1].uv, crossings[to.1].uv];
            append_stretch(l, [from.0, to.0], k + 1 == count, ends, &mut pieces);
            k = partner((k + 1) % count);
        }
        if !pieces.is_empty() {
            parts.push(UvLoop { pieces, winding: [0, 0] });
        }
    }
    let polygons: Vec<Vec<DVec2>> = parts.iter().map(UvLoop::polyline).collect();
    let areas: Vec<f64> = parts.iter().map(UvLoop::double_area).collect();
    let alike = |k: usize| areas[k] == 0.0 || (areas[k] > 0.0) == positive;
    let within = |k: usize| {
        let probe = 0.5 * (polygons[k][0] + polygons[k][1 % polygons[k].len()]);
        (0..parts.len()).any(|o| o != k && alike(o) && winding_about(&polygons[o], probe) != 0)
    };
    let backwards: Vec<usize> = (0..parts.len()).filter(|&k| !alike(k) && !within(k)).collect();
    for &k in &backwards {
        parts[k].reverse();
        let middle = polygons[k].iter().sum::<DVec2>() / polygons[k].len() as f64;
        done.lobes += 1;
        done.area += 0.5 * areas[k].abs() * projector.area(middle);
    }
    if backwards.is_empty() {
        return None;
    }
    let pass = |at: LoopPlace| Some((l.pieces[at.piece].along.edge()?, at.t));
    done.cuts.extend(crossings.iter().map(|c| LobeCut { passes: c.at.map(pass), uv: c.uv }));
    Some(parts)
}

/// A point that a loop passes twice.
struct LobeCrossing {
    at: [LoopPlace; 2],
    uv: DVec2,
}

/// Where a loop crosses itself, or passes a vertex twice. `None` if nowhere, or too often.
fn crossings(l: &UvLoop, near: f64) -> Option<Vec<LobeCrossing>> {
    let mut points: Vec<(LoopPlace, DVec2)> = Vec::new();
    for (piece, p) in l.pieces.iter().enumerate() {
        let n = p.samples.len();
        for k in 0..n - 1 {
            let (a, b) = if p.reversed { (n - 1 - k, n - 2 - k) } else { (k, k + 1) };
            let (from, to) = (&p.samples[a], &p.samples[b]);
            // Two samples at one place mark a kink.
            if (to.t - from.t).abs() <= SAME_SHARE * (p.samples[n - 1].t - p.samples[0].t) {
                continue;
            }
            points.push((LoopPlace { piece, t: from.t }, from.uv));
            let middle = 0.5 * (from.t + to.t);
            points.push((LoopPlace { piece, t: middle }, UvSample::on(&p.samples, middle).uv));
        }
    }
    let count = points.len();
    if count > MAX_SEGMENTS {
        return None;
    }
    let end = |k: usize| points[(k + 1) % count].1;
    let mut order: Vec<usize> = (0..count).collect();
    let low = |k: usize| points[k].1.x.min(end(k).x);
    order.sort_by(|&a, &b| low(a).total_cmp(&low(b)));
    let mut out: Vec<LobeCrossing> = Vec::new();
    for (n, &i) in order.iter().enumerate() {
        let (p, q) = (points[i].1, end(i));
        for &j in order[n + 1..].iter().take_while(|&&j| low(j) <= p.x.max(q.x)) {
            let (r, s) = (points[j].1, end(j));
            let apart = p.y.min(q.y) > r.y.max(s.y) || r.y.min(s.y) > p.y.max(q.y);
            let follows = (i + 1) % count == j || (j + 1) % count == i;
            if apart {
                continue;
            }
            if p.distance(r) <= near {
                out.push(LobeCrossing { at: [points[i].0, points[j].0], uv: p });
            } else if !follows && let Some(shares) = cross([p, q], [r, s]) {
                out.extend(settle(l, [i, j], shares, &points, near));
            }
            if out.len() > MAX_CROSSINGS {
                return None;
            }
        }
    }
    (!out.is_empty()).then_some(out)
}

/// Shares of two segments at which they cross, other than at their ends.
fn cross([p, q]: [DVec2; 2], [r, s]: [DVec2; 2]) -> Option<[f64; 2]> {
    let (d, e) = (q - p, s - r);
    let at = [(r - p).perp_dot(e), (r - p).perp_dot(d)].map(|x| x / d.perp_dot(e));
    at.iter().all(|x| *x > 0.0 && *x < 1.0).then_some(at)
}

/// The crossing of the pcurves near that of two of their chords. `None` if they do not meet within both segments.
fn settle(
    l: &UvLoop,
    segments: [usize; 2],
    shares: [f64; 2],
    points: &[(LoopPlace, DVec2)],
    near: f64,
) -> Option<LobeCrossing> {
    let piece = |k: usize| &l.pieces[points[segments[k]].0.piece];
    let limits = [0, 1].map(|k| {
        let (here, next) = (points[segments[k]].0, points[(segments[k] + 1) % points.len()].0);
        let last = piece(k).ends()[1];
        [here.t, if next.piece == here.piece && segments[k] + 1 < points.len() { next.t } else { last.t }]
    });
    let start = [0, 1].map(|k| limits[k][0] + (limits[k][1] - limits[k][0]) * shares[k]);
    let sample = |k: usize, t: f64| UvSample::on(&piece(k).samples, t);
    let t = newton_meeting(sample, DVec2::ONE, limits.map(|[a, b]| [a.min(b), a.max(b)]), start, near);
    let [x, y] = [0, 1].map(|k| sample(k, t[k]).uv);
    let at = [0, 1].map(|k| LoopPlace { piece: points[segments[k]].0.piece, t: t[k] });
    (x.distance(y) <= 10.0 * near).then_some(LobeCrossing { at, uv: x })
}

/// Appends the pieces of a loop between two points, past its start if it `wraps`. The outermost points become `ends`.
fn append_stretch(l: &UvLoop, between: [LoopPlace; 2], wraps: bool, ends: [DVec2; 2], out: &mut Vec<Piece>) {
    for Passed { piece: p, range: [a, b], is_first, is_last, .. } in l.between(between, wraps) {
        if a == b {
            continue;
        }
        let mut samples = UvSample::within(&p.samples, [a.min(b), a.max(b)]);
        let last = samples.len() - 1;
        let [start, end] = if p.reversed { [last, 0] } else { [0, last] };
        if is_first {
            samples[start].uv = ends[0];
        }
        if is_last {
            samples[end].uv = ends[1];
        }
        out.push(Piece { along: p.along, reversed: p.reversed, samples });
    }
}
