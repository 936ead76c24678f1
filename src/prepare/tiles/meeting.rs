//! Stretches of trim arcs that cannot be separated -> the points where they meet, added to both pcurves.
//! Chords are intersected, and Newton steps on the pcurves lead to the point itself. A point in (u,v) that two edges
//! share to the bit is one vertex to the trim stage. One that they share in space is one vertex to adjacent faces.

use super::arcs::ArcSpan;
use super::draft::{DraftTile, DraftUse};
use crate::math;
use crate::math::solve::bisected;
use crate::prepare::uv::polygon::winding_about;
use crate::prepare::uv::uv_curve::{SAME_SHARE, UvCurve, UvSample, newton_meeting};
use glam::DVec2;
use smallvec::SmallVec;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Distance, in tiles, below which two points of (u,v) coincide: pcurves of planes are exact to rounding.
const TOUCH: f64 = 1e-9;

/// Distance, in tiles, below which curves side by side touch: pcurves are accurate to a few millionths of a face.
const TANGENT: f64 = 1e-5;

/// Sine of the angle below which two curves that come together run side by side.
const SIDE_BY_SIDE: f64 = 0.1;

/// Remaining budget of a tile or face, in points.
pub(crate) struct WorkLeft(pub(crate) usize);

impl WorkLeft {
    /// Spends `points`. Returns whether anything is left.
    pub(crate) fn takes(&mut self, points: usize) -> bool {
        self.0 = self.0.saturating_sub(points);
        self.0 > 0
    }
}

/// A point of (u,v) that two stretches of a tile's loops have in common.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    /// Loop, use within the loop, and parameter, for both.
    pub(crate) at: [((usize, usize), f64); 2],
    /// Where, in the tile's (u,v).
    pub(crate) uv: DVec2,
    /// Difference up to which parameters of each stretch are the same.
    same: [f64; 2],
    /// Whether the curves run side by side there.
    pub(crate) tangent: bool,
}

impl Meeting {
    /// Whether both are the same meeting.
    pub(crate) fn is(&self, other: &Self) -> bool {
        (0..2).all(|k| self.at[k].0 == other.at[k].0 && (self.at[k].1 - other.at[k].1).abs() <= self.same[k])
    }

    /// Whether another meeting of the same curves is too near to this one, where they touch, to mean anything.
    pub(crate) fn blurs(&self, other: &Self, tile: &DraftTile) -> bool {
        let apart = (self.uv - other.uv) / (tile.max - tile.min);
        let same = (0..2).all(|k| other.at.iter().any(|at| at.0 == self.at[k].0));
        self.tangent && same && apart.length() <= 10.0 * TANGENT
    }
}

/// Where two stretches meet, other than at common ends: at most one point, or two ends of a common stretch.
pub(crate) fn meet(tile: &DraftTile, a: ArcSpan<'_>, b: ArcSpan<'_>) -> Vec<Meeting> {
    let starts = chords_meet(a, b);
    // Chords of curves that touch need not cross.
    if starts.is_empty() && (a.is_curved() || b.is_curved()) {
        let [d, e] = [a, b].map(|s| s.chord());
        let side_by_side = d.perp_dot(e).abs() <= SIDE_BY_SIDE * d.length() * e.length();
        return side_by_side.then(|| settle(tile, a, b, None)).flatten().into_iter().collect();
    }
    starts.into_iter().filter_map(|at| settle(tile, a, b, Some(at))).collect()
}

/// Where the chords of two stretches meet, as shares of both: at most one point, or the ends of a common stretch.
pub(crate) fn chords_meet(a: ArcSpan<'_>, b: ArcSpan<'_>) -> SmallVec<[[f64; 2]; 4]> {
    let ([p, q], [r, s]) = (a.ends(), b.ends());
    let (d, e) = (a.chord(), b.chord());
    let (length_a, length_b) = (d.length(), e.length());
    let cross = d.perp_dot(e);
    let within = |x: f64, length: f64| x * length >= -TOUCH && (x - 1.0) * length <= TOUCH;
    let mut meetings = SmallVec::new();
    if cross.abs() > 1e-9 * length_a * length_b {
        let at = [(r - p).perp_dot(e) / cross, (r - p).perp_dot(d) / cross];
        if within(at[0], length_a) && within(at[1], length_b) {
            meetings.push(at);
        }
    } else if length_a > 0.0 && length_b > 0.0 {
        let on_a = (p, d, length_a, [r, s]);
        let on_b = (r, e, length_b, [p, q]);
        for (k, (from, along, length, ends)) in [on_a, on_b].into_iter().enumerate() {
            for (end, x) in [0.0, 1.0].into_iter().zip(ends) {
                let at = (x - from).dot(along) / along.length_squared();
                let off = (x - from).perp_dot(along).abs() / length;
                if within(at, length) && off <= TOUCH {
                    meetings.push(if k == 0 { [at, end] } else { [end, at] });
                }
            }
        }
    }
    meetings
}

/// The meeting of two stretches near a `crossing` of their chords, given as shares of these; without one, a place where
/// they touch. `None` if there is no meeting, or if it is a common end of both arcs.
fn settle(tile: &DraftTile, a: ArcSpan<'_>, b: ArcSpan<'_>, crossing: Option<[f64; 2]>) -> Option<Meeting> {
    let at = crossing.unwrap_or([0.5; 2]);
    let spans = [a, b];
    let scale = (tile.max - tile.min).recip();
    let uses = spans.map(|s| &tile.loops[s.arc.of.0][s.arc.of.1]);
    let limits = spans.map(|s| [s.arc.points[0].0, s.arc.points[s.arc.points.len() - 1].0]);
    let same = limits.map(|[from, to]| SAME_SHARE * (to - from));
    let mut t = [0, 1].map(|k| {
        let [from, to] = spans[k].range();
        (from + (to - from) * at[k]).clamp(limits[k][0], limits[k][1])
    });
    let mut touch = TOUCH;
    let tangent = if a.is_curved() || b.is_curved() { tangency(uses, scale, [a.range(), b.range()], t) } else { None };
    if let Some(tangent) = tangent {
        (t, touch) = (tangent, TANGENT);
    } else if crossing.is_none() {
        return None;
    } else {
        t = newton_meeting(|k, t| sample(uses[k], t), scale, limits, t, TOUCH);
    }
    let mut at_end = [false; 2];
    for k in 0..2 {
        if let Some(&end) = limits[k].iter().find(|&&end| (end - t[k]).abs() <= same[k]) {
            (t[k], at_end[k]) = (end, true);
        }
    }
    let [x, y] = [0, 1].map(|k| sample(uses[k], t[k]).uv);
    let apart = ((y - x) * scale).length() > touch;
    let itself = a.arc.of == b.arc.of && (t[0] - t[1]).abs() <= same[0];
    if apart || itself || at_end == [true; 2] {
        return None;
    }
    let uv = if at_end[1] { y } else { x };
    Some(Meeting { at: [0, 1].map(|k| (spans[k].arc.of, t[k])), uv, same, tangent: touch == TANGENT })
}

/// Parameters at which two stretches touch without crossing, starting from a guess: where they are parallel, if they
/// are as near there as pcurves are accurate.
fn tangency(uses: [&DraftUse; 2], scale: DVec2, ranges: [[f64; 2]; 2], guess: [f64; 2]) -> Option<[f64; 2]> {
    let at = |k: usize, t: f64| {
        let s = sample(uses[k], t);
        (s.uv * scale, s.d * scale)
    };
    // Stretches end where they could not be separated, not where they touch.
    let wide = ranges.map(|[a, b]| [a - (b - a), b + (b - a)]);
    let limits = [0, 1].map(|k| {
        let (from, to) = (uses[k].from.min(uses[k].to), uses[k].from.max(uses[k].to));
        wide[k].map(|t| t.clamp(from, to))
    });
    // The foot of a point of one curve on the other, its distance, and the sine of the angle between the curves there.
    let foot = |k: usize, t: f64| {
        let other = 1 - k;
        let [from, to] = limits[other];
        let (p, d) = at(k, t);
        let s = math::solve::foot(guess[other], (from, to), SAME_SHARE * (to - from), |s| {
            let (q, e) = at(other, s);
            let square = e.length_squared();
            [(q - p).dot(e), square, square]
        });
        let (q, e) = at(other, s);
        (s, p.distance(q), d.perp_dot(e) / (d.length() * e.length()))
    };
    // An end of either that touches the other.
    for k in 0..2 {
        for end in limits[k].into_iter().filter(|&t| t == uses[k].from || t == uses[k].to) {
            let (s, distance, sine) = foot(k, end);
            if distance <= TANGENT && sine.abs() <= SIDE_BY_SIDE {
                return Some(if k == 0 { [end, s] } else { [s, end] });
            }
        }
    }
    let foot = |t: f64| foot(0, t);
    let (start, end) = (foot(limits[0][0]).2, foot(limits[0][1]).2);
    if !(start.abs().max(end.abs()) <= SIDE_BY_SIDE && start * end < 0.0) {
        return None;
    }
    let [low, _] = bisected(limits[0], 60, |t| (foot(t).2 > 0.0) == (start > 0.0));
    let (s, distance, _) = foot(low);
    (distance <= TANGENT).then_some([low, s])
}

/// Parameters around the points at which curves touch, at the same distances on all curves. Polylines through these
/// stay side by side, as the curves do.
pub(crate) fn beside(tile: &DraftTile, meetings: &[Meeting]) -> Vec<((usize, usize), f64)> {
    /// Number of distances, each half of the previous one.
    const HALVINGS: i32 = 8;
    let scale = (tile.max - tile.min).recip();
    let mut out = Vec::new();
    for m in meetings.iter().filter(|m| m.tangent) {
        let far = |of: (usize, usize), t: f64| ((sample(&tile.loops[of.0][of.1], t).uv - m.uv) * scale).length();
        // The four ways to go, each to the next sample.
        let mut ways: Vec<((usize, usize), f64, f64)> = Vec::new();
        for (of, t) in m.at {
            let u = &tile.loops[of.0][of.1];
            let UvCurve::Hermite(samples) = &u.uv else { continue };
            let (low, high) = (u.from.min(u.to), u.from.max(u.to));
            let before = samples.iter().rev().map(|s| s.t).find(|&s| s < t).map_or(low, |s| s.max(low));
            let after = samples.iter().map(|s| s.t).find(|&s| s > t).map_or(high, |s| s.min(high));
            ways.extend([before, after].into_iter().filter(|&end| end != t).map(|end| (of, t, end)));
        }
        let reach = ways.iter().map(|&(of, _, end)| far(of, end)).fold(f64::INFINITY, f64::min);
        for &(of, t, end) in &ways {
            out.extend((0..HALVINGS).map(|k| {
                let wanted = reach * 0.5_f64.powi(k);
                (of, bisected([t, end], 50, |t| far(of, t) < wanted)[0])
            }));
        }
    }
    out
}

/// A pcurve's point and slope.
fn sample(u: &DraftUse, t: f64) -> UvSample {
    let UvCurve::Hermite(samples) = &u.uv else { return UvSample { t, uv: DVec2::NAN, d: DVec2::NAN } };
    UvSample::on(samples, t)
}

/// Adds the point of every meeting to both pcurves as a sample.
pub(crate) fn weld(tile: &mut DraftTile, meetings: &[Meeting]) {
    for m in meetings {
        for (k, ((l, u), t)) in m.at.into_iter().enumerate() {
            let used = &mut tile.loops[l][u];
            let mut new = sample(used, t);
            new.uv = m.uv;
            let UvCurve::Hermite(samples) = &mut used.uv else { continue };
            match Arc::make_mut(samples).iter_mut().find(|s| (s.t - t).abs() <= 1e-3 * m.same[k]) {
                Some(known) if known.t == t => known.uv = m.uv,
                // A sample next to it would make a piece without length.
                Some(known) => *known = new,
                None => {
                    let mut all = samples.to_vec();
                    all.insert(all.partition_point(|s| s.t < t), new);
                    *samples = all.into();
                }
            }
        }
    }
}

/// Points that the loops of a tile pass twice and that are ends of their stretches: common vertices.
pub(crate) fn touching(tile: &DraftTile) -> Vec<Meeting> {
    let mut starts: Vec<(DVec2, (usize, usize), f64)> = Vec::new();
    for (l, uses) in tile.loops.iter().enumerate() {
        for (k, u) in uses.iter().enumerate().filter(|(_, u)| matches!(u.uv, UvCurve::Hermite(_))) {
            starts.push((u.uv.point(u.from, &mut 0), (l, k), u.from));
        }
    }
    starts.sort_by(|a, b| a.0.x.total_cmp(&b.0.x).then(a.0.y.total_cmp(&b.0.y)));
    let twice = starts.windows(2).filter(|w| w[0].0 == w[1].0);
    let meeting = |w: &[(DVec2, (usize, usize), f64)]| Meeting {
        at: [(w[0].1, w[0].2), (w[1].1, w[1].2)],
        uv: w[0].0,
        same: [0.0; 2],
        tangent: false,
    };
    twice.map(meeting).collect()
}

/// Parameters by the use (loop, and index in the loop) that has them.
pub(crate) fn by_use(of: impl Iterator<Item = ((usize, usize), f64)>) -> BTreeMap<(usize, usize), Vec<f64>> {
    let mut out: BTreeMap<_, Vec<f64>> = BTreeMap::new();
    of.for_each(|(of, t)| out.entry(of).or_default().push(t));
    out
}

/// The first meeting where the loops of a tile cross or overlap rather than touch. Next to it they wind more than once,
/// or backwards, or have the kept side on their right only. The first meeting of all once `work`, in points of loops
/// visited, is spent.
pub(crate) fn fold(tile: &DraftTile, meetings: &[Meeting], work: &mut WorkLeft) -> Option<Meeting> {
    /// Distances from a chord, in chords, at which winding numbers are evaluated: in general, and along a spike.
    const BESIDE: [f64; 2] = [1e-3, 1e-7];
    if meetings.is_empty() {
        return None;
    }
    let whole: Vec<Vec<DVec2>> = tile.loops.iter().map(|l| l.iter().flat_map(points).map(|p| p.1).collect()).collect();
    if !work.takes(whole.iter().map(Vec::len).sum::<usize>().saturating_mul(meetings.len())) {
        return meetings.first().copied();
    }
    let winding = |p: DVec2| whole.iter().map(|l| winding_about(l, p)).sum::<i32>();
    let around = |a: DVec2, b: DVec2, beside: f64| {
        let (middle, left) = (0.5 * (a + b), (b - a).perp() * beside);
        (winding(middle + left), winding(middle - left))
    };
    let sound = |a: DVec2, b: DVec2| match around(a, b, BESIDE[0]) {
        (1, 0..=1) => true,
        // A spike without width keeps nothing on either side, however near.
        (0, 0) => a == b || around(a, b, BESIDE[1]) == (0, 0),
        _ => a == b,
    };
    let met = by_use(meetings.iter().flat_map(|m| m.at));
    meetings.iter().copied().find(|m| {
        m.at.into_iter().any(|((l, k), t)| {
            let u = &tile.loops[l][k];
            let forward = u.from < u.to;
            let mut stops = vec![u.from.min(u.to), u.from.max(u.to)];
            stops.extend(met.get(&(l, k)).into_iter().flatten());
            let before = stops.iter().copied().filter(|&s| s < t).reduce(f64::max);
            let after = stops.iter().copied().filter(|&s| s > t).reduce(f64::min);
            let points = points(u);
            [before, after].into_iter().flatten().any(|stop| {
                let middle = 0.5 * (stop + t);
                // The chord around the middle of the stretch, in loop order.
                let next = points.iter().position(|p| if forward { p.0 > middle } else { p.0 < middle });
                let next = next.unwrap_or(points.len());
                let to = points.get(next).map_or_else(|| sample(u, u.to).uv, |p| p.1);
                next > 0 && !sound(points[next - 1].1, to)
            })
        })
    })
}

/// Points along a use with their parameters, without the last: the samples of its pcurve and middles between them.
fn points(u: &DraftUse) -> Vec<(f64, DVec2)> {
    let mut ts = vec![u.from];
    if let UvCurve::Hermite(samples) = &u.uv {
        let (a, b) = (u.from.min(u.to), u.from.max(u.to));
        let middles = samples.windows(2).flat_map(|w| [w[0].t, 0.5 * (w[0].t + w[1].t)]);
        ts.extend(middles.filter(|&t| t > a && t < b));
        if u.from > u.to {
            ts[1..].reverse();
        }
    }
    let mut hint = 0;
    ts.into_iter().map(|t| (t, u.uv.point(t, &mut hint))).collect()
}
