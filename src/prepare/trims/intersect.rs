//! Free trimming curves -> all points at which they meet each other and themselves.
//!
//! Curves are chains of monotone arcs ([`spans`](super::spans)), so a curve meets itself where two of its arcs do. Each
//! pair of arcs whose boxes meet is searched for ends that lie on the other arc, then for common stretches, and the
//! rest by halving:
//!
//! * Halves are disjoint if their boxes are, or the strips along their chords.
//! * If the cones of their tangents are disjoint they meet at most once, and Newton's method finds the point (Sederberg
//!   & Meyers, "Loop detection in surface patch intersections", CAGD 5, 1988).
//! * Halves that are straight within the tolerance, and still undecided, touch where they are parallel and nearest.

use super::chains::{SpanChain, SpanPlace, TOUCH};
use super::spans::Span;
use crate::control::Call;
use crate::math;
use crate::math::bernstein::restrict;
use crate::math::boxes::BoxTree;
use crate::prepare::uv::uv_curve::{UvSample, newton_meeting};
use glam::{DMat2, DVec2, DVec3};

/// Distance below which two meetings are one.
pub(crate) const SAME: f64 = 10.0 * TOUCH;

/// Most pairs of halves examined per pair of arcs. Crossings need 10 to 100, touches a few hundred.
const MAX_PAIRS: usize = 20_000;
/// Spans that a thread compares at a time with those after them.
const SHARE: usize = 16;

/// A crossing below this sine of the angle may belong to a touch.
const SHALLOW: f64 = 1e-3;

/// A point that two spans have in common.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpanContact {
    pub(crate) at: [SpanPlace; 2],
    pub(crate) point: DVec2,
}

/// All points where spans meet, within [`TOUCH`], except the joints of successive spans. A common stretch counts as two
/// points, its ends.
///
/// Cost: O(n log n) to sort all spans, then about 10 µs for each pair whose boxes meet.
pub(crate) fn meetings(call: Call<'_>, chains: &[&SpanChain]) -> Vec<SpanContact> {
    let name = |c: usize| (0..chains[c].spans.len()).map(move |k| (c, k));
    let names: Vec<(usize, usize)> = (0..chains.len()).flat_map(name).collect();
    let span = |(c, k): (usize, usize)| &chains[c].spans[k];
    let boxes: Vec<[DVec2; 2]> = names.iter().map(|&n| [span(n).low(), span(n).high()]).collect();
    let tree = BoxTree::new(&boxes);
    let with_later = |k: usize| {
        let mut near: Vec<usize> = Vec::new();
        let [low, high] = boxes[k];
        tree.meeting([low - TOUCH, high + TOUCH], |other| near.extend((other > k).then_some(other)));
        near.sort_unstable();
        let mut out = Vec::new();
        let a = names[k];
        for b in near.into_iter().map(|other| names[other]) {
            for m in meet(span(a), span(b)) {
                let joins = a.0 == b.0 && chains[a.0].joint(a.1, b.1).any(|p| p.distance(m.point) <= SAME);
                if !joins {
                    let at = [(a, m.at[0]), (b, m.at[1])].map(|(x, s)| SpanPlace { chain: x.0, span: x.1, s });
                    out.push(SpanContact { at, point: m.point });
                }
            }
        }
        out
    };
    call.each(SHARE, 0..names.len(), with_later).into_iter().flatten().collect()
}

/// Where two spans meet.
struct SpanMeeting {
    at: [f64; 2],
    point: DVec2,
}

/// Parameter and distance of the point of a span nearest to `p`. Reliable only if `p` is near the span.
fn foot(span: &Span, p: DVec2) -> (f64, f64) {
    /// Steps of this share of a span end the search. The next one would have about its square.
    const STILL: f64 = 1e-9;
    let (low, high) = (span.low(), span.high());
    let size = high - low;
    let axis = usize::from(size.y > size.x);
    let rising = span.ends[1][axis] > span.ends[0][axis];
    let start = match p[axis] {
        x if x <= low[axis] => f64::from(u8::from(!rising)),
        x if x >= high[axis] => f64::from(u8::from(rising)),
        x => span.at(axis, x),
    };
    let s = math::solve::foot(start, (0.0, 1.0), STILL, |s| {
        let [q, d1, d2] = span.derivatives(s);
        let square = d1.length_squared();
        [(q - p).dot(d1), square + (q - p).dot(d2), square]
    });
    let ends = [0.0, 1.0].map(|end| (end, span.point(end).distance(p)));
    let inside = (s, span.point(s).distance(p));
    // Prefer an end of the span to a place next to it.
    ends.into_iter().filter(|e| e.1 <= TOUCH).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or(inside)
}

fn meet(a: &Span, b: &Span) -> Vec<SpanMeeting> {
    let mut out: Vec<SpanMeeting> = Vec::new();
    // Ends on the other span.
    let mut marks: Vec<[f64; 2]> = Vec::new();
    let mut mark = |s: f64, t: f64| {
        let p = a.point(s);
        if marks.iter().all(|m| a.point(m[0]).distance(p) > SAME) {
            marks.push([s, t]);
        }
    };
    for (k, (one, other)) in [(a, b), (b, a)].into_iter().enumerate() {
        for (end, p) in [0.0, 1.0].into_iter().zip(one.ends) {
            let (at, distance) = foot(other, p);
            if distance <= TOUCH {
                let [s, t] = if k == 0 { [end, at] } else { [at, end] };
                mark(s, t);
            }
        }
    }
    marks.sort_by(|x, y| x[0].total_cmp(&y[0]));
    let both = marks.windows(2).map(|w| [w[0], w[1]]);
    let common: Vec<[[f64; 2]; 2]> = both.filter(|&[from, to]| coincide(a, b, from, to)).collect();
    for m in &marks {
        // Use the end of a span as it is, so that all spans that meet there share its bits.
        let point = if m[1] == 0.0 || m[1] == 1.0 { b.point(m[1]) } else { a.point(m[0]) };
        out.push(SpanMeeting { at: *m, point });
    }
    let straight = a.control.len() == 2 && b.control.len() == 2;
    if straight && !marks.is_empty() {
        // Two lines meet once, or along a stretch between two ends.
        return out;
    }
    let rest = |k: usize| {
        let mut cuts: Vec<[f64; 2]> = common.iter().map(|c| [c[0][k].min(c[1][k]), c[0][k].max(c[1][k])]).collect();
        cuts.sort_by(|x, y| x[0].total_cmp(&y[0]));
        let mut from = 0.0;
        let mut out = Vec::new();
        for [low, high] in cuts {
            out.push([from, low]);
            from = high;
        }
        out.push([from, 1.0]);
        out.retain(|r| r[1] - r[0] > 1e-12);
        out
    };
    for range_a in rest(0) {
        for range_b in rest(1) {
            halve(a, b, range_a, range_b, &mut out);
        }
    }
    out
}

/// The sine of the angle between two spans; 0 where one of them has no tangent.
fn sine(a: &Span, b: &Span, at: [f64; 2]) -> f64 {
    let (d, e) = (a.derivatives(at[0])[1], b.derivatives(at[1])[1]);
    d.normalize_or_zero().perp_dot(e.normalize_or_zero()).abs()
}

/// Whether two spans coincide between two common points, tested at eight places.
fn coincide(a: &Span, b: &Span, from: [f64; 2], to: [f64; 2]) -> bool {
    const PROBES: usize = 9;
    let (low, high) = (from[1].min(to[1]), from[1].max(to[1]));
    (1..PROBES).all(|k| {
        let share = k as f64 / PROBES as f64;
        let (t, distance) = foot(b, a.point(from[0] + (to[0] - from[0]) * share));
        distance <= 2.0 * TOUCH && t >= low - 1e-6 && t <= high + 1e-6
    })
}

/// A part of a span, with the control points of that part.
#[derive(Clone)]
struct SpanPart {
    control: Vec<DVec3>,
    range: [f64; 2],
}

impl SpanPart {
    /// The part `share` of a net. `range`: its parameters, of the span.
    fn of(net: &[DVec3], share: [f64; 2], range: [f64; 2]) -> Self {
        let mut control = net.to_vec();
        restrict(&mut control, share[0], share[1]);
        Self { control, range }
    }

    fn points(&self) -> impl Iterator<Item = DVec2> + Clone + '_ {
        self.control.iter().map(|c| c.truncate() / c.z)
    }

    fn ends(&self) -> [DVec2; 2] {
        [self.control[0], self.control[self.control.len() - 1]].map(|c| c.truncate() / c.z)
    }

    fn halves(&self) -> [Self; 2] {
        let [from, to] = self.range;
        let middle = 0.5 * (from + to);
        let halves = [([0.0, 0.5], [from, middle]), ([0.5, 1.0], [middle, to])];
        halves.map(|(share, range)| Self::of(&self.control, share, range))
    }

    /// Least and largest projection of the control points onto `n`.
    fn along(&self, n: DVec2) -> [f64; 2] {
        self.points().map(|p| n.dot(p)).fold([f64::INFINITY, f64::NEG_INFINITY], |r, x| [r[0].min(x), r[1].max(x)])
    }

    /// Bounds the angle between chord and tangents by the legs of the control polygon: with positive weights, tangents
    /// are sums of legs with positive factors.
    fn cone(&self) -> f64 {
        let [p, q] = self.ends();
        let chord = q - p;
        let mut from = p;
        let mut widest = 0.0_f64;
        for to in self.points().skip(1) {
            if to != from {
                widest = widest.max(chord.angle_to(to - from).abs());
            }
            from = to;
        }
        widest
    }
}

/// Appends the meetings of two spans within the given ranges, by halving. The ranges have no stretch in common.
fn halve(a: &Span, b: &Span, range_a: [f64; 2], range_b: [f64; 2], out: &mut Vec<SpanMeeting>) {
    let whole = |span: &Span, range: [f64; 2]| SpanPart::of(&span.control, range, range);
    let mut stack = vec![(whole(a, range_a), whole(b, range_b))];
    let mut looked = 0;
    while let Some((x, y)) = stack.pop() {
        looked += 1;
        let ([p, q], [r, s]) = (x.ends(), y.ends());
        let apart = |n: DVec2| {
            let (of_x, of_y) = (x.along(n), y.along(n));
            of_x[0] > of_y[1] + TOUCH || of_y[0] > of_x[1] + TOUCH
        };
        let (d, e) = (q - p, s - r);
        let (length_x, length_y) = (d.length(), e.length());
        let normals = [d, e].map(|c| c.perp().normalize_or_zero());
        if apart(DVec2::X) || apart(DVec2::Y) || normals.into_iter().any(|n| n != DVec2::ZERO && apart(n)) {
            continue;
        }
        let small = length_x.max(length_y) <= TOUCH || looked > MAX_PAIRS;
        let between = libm::atan2(d.perp_dot(e).abs(), d.dot(e).abs());
        if !small && between > x.cone() + y.cone() {
            if let Some(at) = crossing(a, b, [x.range, y.range]) {
                // Near a touch the curves are equal to rounding and may seem to cross.
                let touch = Some(at).filter(|&at| sine(a, b, at) <= SHALLOW).and_then(|at| touch(a, b, at));
                add(a, b, touch.unwrap_or(at), out);
                continue;
            }
        } else {
            let thick = |z: &SpanPart, n: DVec2| {
                let [low, high] = z.along(n);
                high - low
            };
            if small || (thick(&x, normals[0]) <= 0.25 * TOUCH && thick(&y, normals[1]) <= 0.25 * TOUCH) {
                let middle = [&x, &y].map(|z| 0.5 * (z.range[0] + z.range[1]));
                let near = |at: &[f64; 2]| a.point(at[0]).distance(b.point(at[1])) <= 4.0 * TOUCH;
                // If they are nearest beyond an end, they meet at the end or not at all.
                let found =
                    if tangency(a, b, middle).is_some() { touch(a, b, middle) } else { Some(middle).filter(near) };
                if let Some(at) = found {
                    add(a, b, at, out);
                }
                continue;
            }
        }
        if length_x >= length_y {
            x.halves().into_iter().for_each(|half| stack.push((half, y.clone())));
        } else {
            y.halves().into_iter().for_each(|half| stack.push((x.clone(), half)));
        }
    }
}

fn add(a: &Span, b: &Span, at: [f64; 2], out: &mut Vec<SpanMeeting>) {
    let point = 0.5 * (a.point(at[0]) + b.point(at[1]));
    if out.iter().all(|m| m.point.distance(point) > SAME) {
        out.push(SpanMeeting { at, point });
    }
}

/// The crossing of two spans within `ranges`; `None` if Newton's method finds none.
fn crossing(a: &Span, b: &Span, ranges: [[f64; 2]; 2]) -> Option<[f64; 2]> {
    let limits = ranges.map(|[from, to]| [from - 1e-3 * (to - from), to + 1e-3 * (to - from)]);
    let sample = |k: usize, t: f64| {
        let [uv, d, _] = [a, b][k].derivatives(t);
        UvSample { t, uv, d }
    };
    let at = newton_meeting(sample, DVec2::ONE, limits, ranges.map(|[from, to]| 0.5 * (from + to)), 0.1 * TOUCH);
    let at = [0, 1].map(|k| at[k].clamp(ranges[k][0], ranges[k][1]));
    (a.point(at[0]).distance(b.point(at[1])) <= 1e-3 * TOUCH).then_some(at)
}

/// Where two spans touch near `at`; `None` if they do not.
fn touch(a: &Span, b: &Span, at: [f64; 2]) -> Option<[f64; 2]> {
    let at = tangency(a, b, at).filter(|at| at.iter().all(|t| (-1e-9..=1.0 + 1e-9).contains(t)))?;
    let at = at.map(|t| t.clamp(0.0, 1.0));
    (a.point(at[0]).distance(b.point(at[1])) <= 4.0 * TOUCH).then_some(at)
}

/// Where two spans, or their continuations, are parallel and opposite each other; `None` if Newton's method does not
/// converge.
fn tangency(a: &Span, b: &Span, mut at: [f64; 2]) -> Option<[f64; 2]> {
    const STEPS: usize = 30;
    for _ in 0..STEPS {
        let ([p, d, d2], [q, e, e2]) = (a.derivatives(at[0]), b.derivatives(at[1]));
        let f = DVec2::new(d.perp_dot(e), (p - q).dot(d));
        let rate = DMat2::from_cols(
            DVec2::new(d2.perp_dot(e), d.length_squared() + (p - q).dot(d2)),
            DVec2::new(d.perp_dot(e2), -e.dot(d)),
        );
        let step = rate.inverse() * f;
        if !step.is_finite() {
            return None;
        }
        at = [0, 1].map(|k| at[k] - step[k]);
        if step.abs().max_element() <= 1e-12 {
            return Some(at);
        }
    }
    None
}

#[cfg(test)]
mod tests;
