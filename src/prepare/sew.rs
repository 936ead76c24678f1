//! Faces of a solid that lie side by side without a common edge -> faces that share it, within the file's own tolerance.
//!
//! Files of some writers give every face its own edges. Two free edges of one shell are one if their ends and their curves
//! are nowhere further apart than the length up to which the file calls points one; all their vertices follow.

use super::face::Told;
use super::heal::Healing;
use super::shells::uses;
use crate::model::{Edge, EdgeId, Loop, Part, Severity, ShellKind, VertexId};
use glam::DVec3;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Points of an edge, besides its ends, that are looked for on the other.
const PLACES: u32 = 5;

/// Samples of an edge from which the foot of a point is looked for, and Newton steps to it.
const SEEDS: u32 = 32;
const STEPS: usize = 8;

/// Distance between the ends of edges, in tolerances, below which nothing is sewn: an edge might vanish.
const SHORTEST: f64 = 8.0;

/// A free edge that another one replaces.
struct Match {
    dropped: u32,
    kept: u32,
    /// Whether they run in opposite directions.
    against: bool,
    width: f64,
}

/// Makes edges of solids that coincide one. Costs a count of the edges' uses where all are used in pairs.
pub(super) fn sew<'a>(part: Cow<'a, Part>, done: &mut Vec<Healing>) -> Cow<'a, Part> {
    let tolerance = part.tolerance;
    let solid = |shell: u32| part.shells.get(shell as usize).is_some_and(|s| s.kind != ShellKind::Open);
    let free: Vec<(u32, u32, usize)> = uses(&part)
        .into_iter()
        .filter(|((shell, _), (count, _))| *count == 1 && solid(*shell))
        .map(|((shell, edge), (_, face))| (shell, edge, face))
        .collect();
    if free.is_empty() || tolerance <= 0.0 {
        return part;
    }
    let ends = |e: &Edge| Some([*part.vertices.get(e.start.index())?, *part.vertices.get(e.end.index())?]);
    let length = |e: &Edge| ends(e).map_or(0.0, |[a, b]| a.distance(b));
    let shortest = part.edges.iter().filter(|e| e.start != e.end).map(length).fold(f64::INFINITY, f64::min);
    if shortest <= SHORTEST * tolerance {
        return part;
    }
    let found = matches(&part, &free, tolerance);
    let Some(widest) = found.iter().max_by(|a, b| a.width.total_cmp(&b.width)) else { return part };
    let kept = &part.edges[widest.kept as usize];
    let face = free.iter().find(|f| f.1 == widest.kept).map_or(0, |f| f.2);
    let what = format!(
        "{} pairs of edges of its shell, up to {:.3e} mm apart, became one: gaps within the tolerance of {tolerance:.1e} mm",
        found.len(),
        widest.width
    );
    let told = Told { place: part.vertices.get(kept.start.index()).copied(), what };
    done.push(Healing { face, severity: Severity::Note, told });
    Cow::Owned(joined(part.into_owned(), &found))
}

/// Pairs of free edges that coincide, each edge in one pair at most.
fn matches(part: &Part, free: &[(u32, u32, usize)], tolerance: f64) -> Vec<Match> {
    // Sorted by the middle between the ends, which is the same for both.
    let mut sorted: Vec<(f64, [DVec3; 2], u32, u32)> = free
        .iter()
        .filter_map(|&(shell, edge, _)| {
            let e = part.edges.get(edge as usize).filter(|e| e.range.0 < e.range.1 && e.curve.check().is_ok())?;
            let ends = [*part.vertices.get(e.start.index())?, *part.vertices.get(e.end.index())?];
            Some((0.5 * (ends[0].x + ends[1].x), ends, shell, edge))
        })
        .collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.3.cmp(&b.3)));
    let mut used = vec![false; sorted.len()];
    let mut out = Vec::new();
    for (k, a) in sorted.iter().enumerate() {
        if used[k] {
            continue;
        }
        let near = sorted[k + 1..].iter().zip(k + 1..).take_while(|(b, _)| b.0 - a.0 <= tolerance);
        let found = near.filter(|(b, j)| !used[*j] && b.2 == a.2).find_map(|(b, j)| {
            let [p, q] = a.1;
            let apart = |[r, s]: [DVec3; 2]| p.distance(r).max(q.distance(s));
            let (along, against) = (apart(b.1), apart([b.1[1], b.1[0]]));
            let (kept, other) = (&part.edges[a.3 as usize], &part.edges[b.3 as usize]);
            let width = along.min(against).max(if along.min(against) <= tolerance { width(kept, other) } else { 0.0 });
            let coincide = width <= tolerance;
            coincide.then_some((j, Match { dropped: b.3, kept: a.3, against: against < along, width }))
        });
        if let Some((j, found)) = found {
            used[j] = true;
            out.push(found);
        }
    }
    out
}

/// How far points of one edge are off another.
fn width(a: &Edge, b: &Edge) -> f64 {
    let at = |e: &Edge, share: f64| e.range.0 + (e.range.1 - e.range.0) * share;
    let off = |p: DVec3| {
        let seeds = (0..=SEEDS).map(|k| at(b, f64::from(k) / f64::from(SEEDS)));
        let far = |t: f64| b.curve.point(t).distance(p);
        let mut t = seeds.min_by(|s, t| far(*s).total_cmp(&far(*t))).unwrap_or(b.range.0);
        let mut best = far(t);
        for _ in 0..STEPS {
            let d = b.curve.derivatives(t);
            let step = (p - d.point).dot(d.d1) / d.d1.length_squared();
            t = (t + if step.is_finite() { step } else { 0.0 }).clamp(b.range.0, b.range.1);
            best = best.min(far(t));
        }
        best
    };
    (1..=PLACES).map(|k| off(a.curve.point(at(a, f64::from(k) / f64::from(PLACES + 1))))).fold(0.0, f64::max)
}

/// The part with every pair replaced by the edge that is kept.
fn joined(mut part: Part, found: &[Match]) -> Part {
    fn root(parent: &mut [usize], mut at: usize) -> usize {
        while parent[at] != at {
            parent[at] = parent[parent[at]];
            at = parent[at];
        }
        at
    }
    let mut parent: Vec<usize> = (0..part.vertices.len()).collect();
    for m in found {
        let [kept, dropped] = [m.kept, m.dropped].map(|e| &part.edges[e as usize]);
        let others = if m.against { [dropped.end, dropped.start] } else { [dropped.start, dropped.end] };
        for (a, b) in [kept.start, kept.end].into_iter().zip(others) {
            let [a, b] = [a, b].map(|v| root(&mut parent, v.index()));
            parent[a.max(b)] = a.min(b);
        }
    }
    for v in part.edges.iter_mut().flat_map(|e| [&mut e.start, &mut e.end]) {
        if v.index() < parent.len() {
            *v = VertexId::new(root(&mut parent, v.index()));
        }
    }
    let by_edge: BTreeMap<u32, &Match> = found.iter().map(|m| (m.dropped, m)).collect();
    for l in part.faces.iter_mut().flat_map(|f| &mut f.loops) {
        let Loop::Edges(coedges) = l else { continue };
        for c in coedges {
            if let Some(m) = by_edge.get(&c.edge.0) {
                // A pcurve is in the parameter of the edge that is gone.
                (c.edge, c.reversed, c.pcurve) = (EdgeId(m.kept), c.reversed != m.against, None);
            }
        }
    }
    part
}
