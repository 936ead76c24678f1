//! Images of edges that cross by less than the edges are accurate -> images that do not cross.
//! Edges that lie off their surface, end off their vertices, or are tangent to each other at a vertex may have images
//! (pcurves) that cross near the vertex, though the edges do not. An image only decides the layout of triangles: their
//! corners lie on the edge. So of two edges that share a vertex, one follows the other side by side up to where they
//! separate, and an edge that meets itself is straightened.

use crate::math::solve::bisected;
use crate::model::{CurveKind, Part, VertexId};
use crate::prepare::uv::projector::Projector;
use crate::prepare::uv::uv_curve::UvSample;
use crate::prepare::uv::uv_loop::{Along, Piece, UvLoop};
use glam::DVec2;

/// A place where two stretches of a face's boundary meet: edge and parameter of both.
pub(crate) type Tangle = [(u32, f64); 2];

/// How images are kept from crossing near a vertex: straight if they leave it at an angle, else side by side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
    Straight,
    Beside,
}

/// A change to the image of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Mend {
    /// Straightens it between two parameters.
    Straight { edge: u32, from: f64, to: f64 },
    /// Lays it next to another edge with a common end, from that end up to a parameter, at a growing distance.
    Beside { edge: End, to: f64, along: End },
}

/// An end of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct End {
    edge: u32,
    /// Whether it is the end with the least parameter.
    first: bool,
}

/// A boundary with more tangles is not worth mending.
pub(crate) const MAX_TANGLES: usize = 24;

/// The mends for `tangles`. `None` if edges without a common vertex meet.
/// Two edges with a common vertex change from there up to `reach` times the distance at which they meet. Both become
/// straight, or one follows the other side by side. An edge that meets itself becomes straight there.
pub(crate) fn about(part: &Part, tangles: &[Tangle], way: Way, reach: f64) -> Option<Vec<Mend>> {
    let mut straight: Vec<(u32, f64, f64)> = Vec::new();
    let mut beside: Vec<(End, f64, End)> = Vec::new();
    for &tangle in tangles {
        let [(a, s), (b, t)] = tangle;
        match common_end(part, tangle) {
            Some((ends, vertex)) if ends[0] != ends[1] => {
                let far =
                    |e: u32, t: f64| part.edges[e as usize].curve.point(t).distance(part.vertices[vertex.index()]);
                let radius = reach * far(a, s).max(far(b, t));
                if way == Way::Straight {
                    straight.extend([(ends[0], s), (ends[1], t)].map(|(end, t)| from_end(part, end, t, radius)));
                    continue;
                }
                let [edge, along] = if rank(part, a) < rank(part, b) { [ends[1], ends[0]] } else { ends };
                let to = parameter_at(part, edge, if edge == ends[0] { s } else { t }, radius);
                match beside.iter_mut().find(|known| known.0 == edge && known.2 == along) {
                    Some(known) if edge.first => known.1 = known.1.max(to),
                    Some(known) => known.1 = known.1.min(to),
                    None => beside.push((edge, to, along)),
                }
            }
            _ if a == b => straight.push(about_itself(part, a, [s, t], reach)),
            _ => return None,
        }
    }
    straight.sort_by(|a, b| (a.0, a.1).partial_cmp(&(b.0, b.1)).unwrap_or(std::cmp::Ordering::Equal));
    straight.dedup_by(|next, last| {
        let overlap = last.0 == next.0 && next.1 <= last.2;
        if overlap {
            last.2 = last.2.max(next.2);
        }
        overlap
    });
    let merged = straight.into_iter().map(|(edge, from, to)| Mend::Straight { edge, from, to });
    Some(merged.chain(beside.into_iter().map(|(edge, to, along)| Mend::Beside { edge, to, along })).collect())
}

/// The stretch from the end of an edge, past a parameter, to where the edge is `radius` away from the end.
fn from_end(part: &Part, end: End, t: f64, radius: f64) -> (u32, f64, f64) {
    let (low, high) = part.edges[end.edge as usize].range;
    let to = parameter_at(part, end, t, radius);
    let (start, back) = if end.first { (low, high) } else { (high, low) };
    // Take the whole edge if little is left: the rest would have to bend back to where it was.
    let to = if (to - start).abs() > 0.75 * (high - low) { back } else { to };
    (end.edge, start.min(to), start.max(to))
}

/// The edge of higher rank follows the other. Simpler curves rank lower: they are likely to be more accurate.
fn rank(part: &Part, edge: u32) -> (u8, u32) {
    let kind = match part.edges[edge as usize].kind {
        CurveKind::Line => 0,
        CurveKind::Circle => 1,
        CurveKind::Conic => 2,
        CurveKind::Spline => 3,
        CurveKind::Polyline => 4,
    };
    (kind, edge)
}

/// The ends of two edges at a common vertex: the one nearest to where they meet.
fn common_end(part: &Part, [(a, s), (b, t)]: Tangle) -> Option<([End; 2], VertexId)> {
    let ends = |edge: u32| {
        let e = &part.edges[edge as usize];
        [(End { edge, first: true }, e.start), (End { edge, first: false }, e.end)]
    };
    let p = part.edges[a as usize].curve.point(s).midpoint(part.edges[b as usize].curve.point(t));
    // A closed edge has both ends there. Take the one nearer to the place.
    let aside = |end: End, t: f64| {
        let (low, high) = part.edges[end.edge as usize].range;
        if end.first { t - low } else { high - t }
    };
    let pairs = ends(a).into_iter().flat_map(|x| ends(b).map(|y| (x, y))).filter(|(x, y)| x.1 == y.1);
    let far = |(x, y): &((End, VertexId), (End, VertexId))| {
        (part.vertices[x.1.index()].distance(p), aside(x.0, s) + aside(y.0, t))
    };
    let best = pairs.min_by(|a, b| far(a).partial_cmp(&far(b)).unwrap_or(std::cmp::Ordering::Equal))?;
    Some(([best.0.0, best.1.0], best.0.1))
}

/// The stretch between the two parameters at which an edge meets itself, with a margin.
fn about_itself(part: &Part, edge: u32, at: [f64; 2], reach: f64) -> (u32, f64, f64) {
    let (low, high) = part.edges[edge as usize].range;
    let [from, to] = [at[0].min(at[1]), at[0].max(at[1])];
    let more = 0.5 * reach * (to - from);
    // A shorter rest would be no more than a corner.
    let from = if from - low <= 2.0 * more { low } else { from - more };
    let to = if high - to <= 2.0 * more { high } else { to + more };
    (edge, from, to)
}

/// The parameter beyond `t`, seen from an end of an edge, at which the edge is `radius` away from that end.
fn parameter_at(part: &Part, end: End, t: f64, radius: f64) -> f64 {
    /// Ratio between the distances of successive steps from the end.
    const GROWTH: f64 = 1.25;
    let e = &part.edges[end.edge as usize];
    let (low, high) = e.range;
    let (from, length) = if end.first { (low, high - low) } else { (high, low - high) };
    let vertex = part.vertices[if end.first { e.start } else { e.end }.index()];
    let mut share = ((t - from) / length).max(1e-9);
    while share < 1.0 && e.curve.point(from + share * length).distance(vertex) < radius {
        share *= GROWTH;
    }
    from + share.min(1.0) * length
}

/// Mends the images of a loop's edges, except where one would move by more than `most` mm. Returns the largest move.
pub(crate) fn mend(l: &mut UvLoop, mends: &[Mend], most: f64, projector: &Projector<'_>) -> f64 {
    let mut moved = 0.0_f64;
    for mend in mends {
        let (Mend::Straight { edge, .. } | Mend::Beside { edge: End { edge, .. }, .. }) = *mend;
        for k in 0..l.pieces.len() {
            if l.pieces[k].along != Along::Edge(edge) {
                continue;
            }
            let old = &l.pieces[k].samples;
            let new = match *mend {
                Mend::Straight { from, to, .. } => straight(old, from.max(old[0].t), to.min(old[old.len() - 1].t)),
                Mend::Beside { edge, to, along } => {
                    let end = at_end(old, edge).uv;
                    let ends_there = |p: &&Piece| {
                        let off = at_end(&p.samples, along).uv - end;
                        p.along == Along::Edge(along.edge) && projector.length(end, off) <= 10.0 * projector.tolerance
                    };
                    let other = l.pieces.iter().find(ends_there);
                    other.and_then(|other| beside(old, (edge, to), &other.samples, along, projector))
                }
            };
            let Some(new) = new else { continue };
            let by = farthest(old, &new, projector);
            if by <= most {
                l.pieces[k].samples = new;
                moved = moved.max(by);
            }
        }
    }
    moved
}

/// Largest sideways move of an image, mm. Moves along it do not count: triangles do not depend on its speed.
fn farthest(old: &[UvSample], new: &[UvSample], projector: &Projector<'_>) -> f64 {
    let places = new.windows(2).flat_map(|w| [0.25, 0.5, 0.75].map(|share| w[0].t + (w[1].t - w[0].t) * share));
    let off = |t: f64| {
        let (a, b) = (UvSample::on(old, t), UvSample::on(new, t));
        let (along, step) = (a.d.normalize_or_zero(), b.uv - a.uv);
        projector.length(a.uv, step - along * step.dot(along))
    };
    places.map(off).fold(0.0, f64::max)
}

fn at_end(samples: &[UvSample], end: End) -> UvSample {
    samples[if end.first { 0 } else { samples.len() - 1 }]
}

/// The samples with a straight piece between two parameters, and smooth transitions before and after it.
fn straight(samples: &[UvSample], from: f64, to: f64) -> Option<Vec<UvSample>> {
    if from >= to {
        return None;
    }
    let (low, high) = (samples[0].t, samples[samples.len() - 1].t);
    let [a, b] = [from, to].map(|t| UvSample::on(samples, t).uv);
    let d = (b - a) / (to - from);
    let beside = 0.5 * (to - from);
    let mut out = Vec::with_capacity(samples.len() + 4);
    if from > low {
        let before = (from - beside).max(low);
        out.extend(samples.iter().copied().filter(|s| s.t < before));
        out.push(UvSample::on(samples, before));
    }
    out.push(UvSample { t: from, uv: a, d });
    out.push(UvSample { t: to, uv: b, d });
    if to < high {
        let after = (to + beside).min(high);
        out.push(UvSample::on(samples, after));
        out.extend(samples.iter().copied().filter(|s| s.t > after));
    }
    Some(out)
}

/// An image laid next to another one from their common end up to parameter `to`, where it keeps its place. In between,
/// their distance is proportional to that from the end.
fn beside(
    samples: &[UvSample],
    (end, to): (End, f64),
    other: &[UvSample],
    along: End,
    projector: &Projector<'_>,
) -> Option<Vec<UvSample>> {
    /// Pieces of the new stretch: so many cubics follow a quarter turn to a billionth.
    const PIECES: usize = 24;
    /// Least speed of an image, as a share of its mean speed.
    const HESITATION: f64 = 0.05;
    let corner = at_end(samples, end);
    let length = projector.lengths(corner.uv);
    let far = |uv: DVec2| length(uv - corner.uv);
    // The point of the other image at distance `radius` from the corner.
    let (start, back) = (at_end(other, along).t, at_end(other, End { first: !along.first, ..along }).t);
    let off = |share: f64| far(UvSample::on(other, start + (back - start) * share).uv);
    let shares = (1..=64).map(|k| libm::pow(0.5, 0.5 * f64::from(64 - k)));
    let beyond: Vec<(f64, f64)> = shares.map(|share| (share, off(share))).collect();
    let other_at = |radius: f64| {
        let &(share, _) = beyond.iter().find(|(_, off)| *off >= radius)?;
        let [_, high] = bisected([0.0, share], 48, |share| off(share) < radius);
        Some(UvSample::on(other, start + (back - start) * high).uv)
    };
    let last = UvSample::on(samples, to);
    let reach = far(last.uv);
    let apart = last.uv - other_at(reach)?;
    let laid = |share: f64| {
        // As far from the corner as before, but at no less than the least speed.
        let was = far(UvSample::on(samples, corner.t + (to - corner.t) * share).uv);
        let radius = was.max(HESITATION * share * reach).min(reach);
        other_at(radius).map(|uv| uv + apart * (radius / reach))
    };
    let share = |k: usize| k as f64 / PIECES as f64;
    let mut new = Vec::with_capacity(samples.len() + PIECES);
    for k in 0..PIECES {
        let t = corner.t + (to - corner.t) * share(k);
        let small = 1e-3 / PIECES as f64;
        let [before, after] = [(share(k) - small).max(0.0), share(k) + small];
        let uv = if k == 0 { corner.uv } else { laid(share(k))? };
        let from = if k == 0 { corner.uv } else { laid(before)? };
        new.push(UvSample { t, uv, d: (laid(after)? - from) / ((after - before) * (to - corner.t)) });
    }
    new.push(last);
    if end.first {
        new.extend(samples.iter().copied().filter(|s| s.t > to));
    } else {
        new.reverse();
        new.splice(0..0, samples.iter().copied().filter(|s| s.t < to));
    }
    new.iter().all(|s| s.uv.is_finite() && s.d.is_finite()).then_some(new)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stretch_becomes_straight_and_the_rest_stays() {
        // A parabola, straightened in its first, middle or last fifth, or as a whole.
        let sample = |k: i32| {
            let t = f64::from(k) / 10.0;
            UvSample { t, uv: DVec2::new(t, t * t), d: DVec2::new(1.0, 2.0 * t) }
        };
        let samples: Vec<UvSample> = (0..=10).map(sample).collect();
        for [from, to] in [[0.0, 0.2], [0.4, 0.6], [0.8, 1.0], [0.0, 1.0]] {
            let new = straight(&samples, from, to).expect("a stretch");
            assert!(new.windows(2).all(|w| w[0].t < w[1].t), "{from} to {to}: {new:?}");
            for k in 0..=100 {
                let t = f64::from(k) / 100.0;
                let (was, is) = (UvSample::on(&samples, t).uv, UvSample::on(&new, t).uv);
                let beside = 0.5 * (to - from);
                if (from..=to).contains(&t) {
                    let [a, b] = [from, to].map(|t| DVec2::new(t, t * t));
                    assert!((b - a).perp_dot(is - a).abs() < 1e-12, "{from} to {to} at {t}: {is}");
                } else if t <= from - beside || t >= to + beside {
                    assert!(was.distance(is) < 1e-12, "{from} to {to} at {t}: {was}, {is}");
                } else {
                    assert!(was.distance(is) < 0.02, "{from} to {to} at {t}: {was}, {is}");
                }
            }
        }
    }
}
