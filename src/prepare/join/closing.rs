//! Tiles of a face -> tiles whose loops are closed chains of points and sum to the face's chain of edges.
//! A tile's mesh ends at its loops, so this keeps neighbours together. It is checked in integers and, for points, bit
//! by bit. Breaks are found by parameter, so a use may start or end at a break next to its neighbour's: a straight edge
//! then joins both. The remaining difference to the chain is added as further loops.

use super::prepared::{Break, EdgeShape, EdgeUse, PreparedEdge, Tile};
use crate::math::bits::of_point;
use crate::math::graph::Links;
use crate::model::{NurbsCurve3, RowId};
use crate::prepare::surface::decompose::BezierSpline3;
use crate::prepare::surface::tables::CurveBounds;
use crate::prepare::uv::uv_curve::{UvCurve, UvSample};
use crate::prepare::wires::boundary::Chain;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;

/// What the loops of a face must sum to.
pub(crate) struct Wanted<'a> {
    /// Their sum on the part's edges.
    pub(crate) chain: &'a Chain,
    /// Number of the part's edges. The edges after them are borders, on which the sum is 0.
    pub(crate) brep_edges: usize,
    /// Edges of loops with reversed lobes, which no other face uses. Their uses must match in number, not in direction.
    pub(crate) lobed: &'a [u32],
    /// Whether the face may end where its surface does, along a border that is used once.
    pub(crate) may_end: bool,
}

/// What was added to a face's loops.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Closure {
    /// Number of straight edges that join ends, and the length of the longest.
    pub(crate) joints: usize,
    pub(crate) longest: f64,
    /// Number of loops that correct the sum.
    pub(crate) loops: usize,
    /// A point where something was added.
    pub(crate) place: Option<DVec3>,
}

/// A stretch of an edge from one break to another, in that direction.
#[derive(Clone, Copy)]
struct BreakRun {
    edge: u32,
    from: u32,
    to: u32,
}

/// A stretch of an edge: edge, first break, last break, and uses along the edge minus uses against it.
type BreakSpan = (u32, u32, u32, i32);

/// Closes the loops of a face's tiles. `None` if they are closed already; to find that costs about 10 ns per use.
///
/// # Errors
/// If there is no tile, or a point is not finite.
pub(crate) fn close(
    tiles: &mut [Tile],
    edges: &mut Vec<PreparedEdge>,
    wanted: &Wanted<'_>,
) -> Result<Option<Closure>, ()> {
    let joined = are_joined(tiles, edges);
    if joined && residue(tiles, edges, wanted).is_empty() {
        return Ok(None);
    }
    let finite = |u: &EdgeUse| [u.from, u.to].iter().all(|&b| break_point(edges, u.edge, b).is_finite());
    if tiles.is_empty() || !tiles.iter().flat_map(|t| &t.loops).flatten().all(finite) {
        return Err(());
    }
    let mut closer = Closer { edges, known: BTreeMap::new(), added: Closure::default() };
    if !joined {
        for tile in &mut *tiles {
            for l in &mut tile.loops {
                tile.entangled |= closer.join(l);
            }
        }
    }
    let mut runs = residue(tiles, closer.edges, wanted);
    let mut walks = closer.walks(&runs);
    if !wanted.lobed.is_empty() && !walks.all_closed {
        // Turn back lobes that do not end in one point: no loop can cancel the joints between their ends.
        runs = residue(tiles, closer.edges, &Wanted { lobed: &[], ..*wanted });
        walks = closer.walks(&runs);
    }
    for walk in walks.chains {
        closer.add(tiles, walk.into_iter().map(|k| runs[k]).collect());
    }
    Ok(Some(closer.added))
}

fn break_point(edges: &[PreparedEdge], edge: RowId, at: u32) -> DVec3 {
    edges[edge.index()].breaks[at as usize].point
}

/// Whether each use starts at the point where the previous one ends.
fn are_joined(tiles: &[Tile], edges: &[PreparedEdge]) -> bool {
    tiles.iter().flat_map(|t| &t.loops).all(|l| {
        let mut at = l.last().map(|u| break_point(edges, u.edge, u.to));
        l.iter().all(|u| {
            let joins = at == Some(break_point(edges, u.edge, u.from));
            at = Some(break_point(edges, u.edge, u.to));
            joins
        })
    })
}

/// The runs that the loops lack for the wanted sum.
fn residue(tiles: &[Tile], edges: &[PreparedEdge], wanted: &Wanted<'_>) -> Vec<BreakRun> {
    let loops = || tiles.iter().flat_map(|t| &t.loops);
    let mut spans: Vec<BreakSpan> = Vec::with_capacity(loops().map(Vec::len).sum::<usize>() + wanted.chain.len());
    for u in loops().flatten() {
        spans.push(if u.from < u.to { (u.edge.0, u.from, u.to, 1) } else { (u.edge.0, u.to, u.from, -1) });
    }
    let last = |edge: u32| edges[edge as usize].breaks.len().saturating_sub(1) as u32;
    spans.extend(wanted.chain.iter().map(|&(edge, count)| (edge, 0, last(edge), -count)));
    spans.sort_unstable_by_key(|s| s.0);
    let mut runs = Vec::new();
    for of_edge in spans.chunk_by(|a, b| a.0 == b.0) {
        let first = of_edge[0];
        let alike = of_edge.iter().all(|s| (s.1, s.2) == (first.1, first.2));
        if alike && of_edge.iter().map(|s| s.3).sum::<i32>() == 0 {
            continue;
        }
        let is_border = first.0 as usize >= wanted.brep_edges;
        if is_border && (wanted.may_end || is_closed(&edges[first.0 as usize], of_edge)) {
            continue;
        }
        let mut sums = vec![0_i32; last(first.0) as usize];
        for &(_, from, to, count) in of_edge {
            sums[from as usize..to as usize].iter_mut().for_each(|s| *s += count);
        }
        if wanted.lobed.binary_search(&first.0).is_ok() {
            let count = wanted.chain.iter().find(|c| c.0 == first.0).map_or(0, |c| c.1);
            if sums.iter().all(|s| (s + count).abs() == count.abs()) {
                continue;
            }
        }
        let mut at = 0;
        for of_run in sums.chunk_by(|a, b| a == b) {
            let ends = [at, at + of_run.len() as u32];
            at = ends[1];
            let [from, to] = if of_run[0] < 0 { ends } else { [ends[1], ends[0]] };
            runs.extend((0..of_run[0].unsigned_abs()).map(|_| BreakRun { edge: first.0, from, to }));
        }
    }
    runs
}

/// Whether a border is a pole and all of its stretches return to their start, so that nothing has to be added.
fn is_closed(border: &PreparedEdge, stretches: &[BreakSpan]) -> bool {
    let point = |at: u32| border.breaks[at as usize].point;
    let whole = |s: &BreakSpan| s.1 == 0 && s.2 as usize + 1 == border.breaks.len();
    let all_one = || border.breaks.iter().all(|b| b.point == point(0));
    matches!(border.shape, EdgeShape::Point(_))
        && stretches.iter().all(|s| point(s.1) == point(s.2))
        && (stretches.iter().all(whole) || all_one())
}

struct Closer<'a> {
    edges: &'a mut Vec<PreparedEdge>,
    /// Straight edges by their ends.
    known: BTreeMap<[[u64; 3]; 2], u32>,
    added: Closure,
}

impl Closer<'_> {
    /// Joins consecutive uses of a loop that do not meet. Returns whether there were any.
    fn join(&mut self, l: &mut Vec<EdgeUse>) -> bool {
        let before = self.added.joints;
        let mut out = Vec::with_capacity(l.len() + 1);
        for k in 0..l.len() {
            let [end, start] = [(&l[k], l[k].to), (&l[(k + 1) % l.len()], l[(k + 1) % l.len()].from)].map(|(u, at)| {
                let Break { t, point } = self.edges[u.edge.index()].breaks[at as usize];
                (point, u.uv.point(t, &mut 0))
            });
            out.push(l[k].clone());
            if end.0 != start.0 {
                out.push(self.straight(end, start));
            }
        }
        *l = out;
        self.added.joints > before
    }

    /// A loop's use of a straight edge between two points, each given with its (u,v).
    fn straight(&mut self, from: (DVec3, DVec2), to: (DVec3, DVec2)) -> EdgeUse {
        let reversed = of_point(to.0) < of_point(from.0);
        let [a, b] = if reversed { [to, from] } else { [from, to] };
        let edges = &mut *self.edges;
        let edge = *self.known.entry([of_point(a.0), of_point(b.0)]).or_insert_with(|| {
            edges.push(line([(0.0, a.0), (1.0, b.0)].map(|(t, point)| Break { t, point }).to_vec()));
            edges.len() as u32 - 1
        });
        self.added.joints += 1;
        self.added.longest = self.added.longest.max(a.0.distance(b.0));
        self.added.place.get_or_insert(a.0);
        let d = b.1 - a.1;
        let uv = UvCurve::Hermite([(0.0, a.1), (1.0, b.1)].map(|(t, uv)| UvSample { t, uv, d }).into());
        let ends = if reversed { [1, 0] } else { [0, 1] };
        EdgeUse::new(RowId(edge), &self.edges[edge as usize].breaks, ends, uv)
    }

    /// Links runs to walks, closed where as many runs enter each point as leave it.
    fn walks(&self, runs: &[BreakRun]) -> Links {
        let ends = |run: &BreakRun| [run.from, run.to].map(|at| of_point(break_point(self.edges, RowId(run.edge), at)));
        Links::of(&runs.iter().map(ends).collect::<Vec<_>>())
    }

    /// Adds a walk as a loop to a tile that uses one of its edges, or else to the first tile.
    fn add(&mut self, tiles: &mut [Tile], walk: Vec<BreakRun>) {
        let has = |tile: &Tile, edge: u32| tile.loops.iter().flatten().any(|u| u.edge.0 == edge);
        let found = walk.iter().find_map(|run| tiles.iter().position(|tile| has(tile, run.edge)));
        let tile = &mut tiles[found.unwrap_or(0)];
        let mut place = 0.5 * (tile.min + tile.max);
        let mut l = Vec::with_capacity(walk.len() + 1);
        for BreakRun { edge, from, to } in walk {
            let known = tile.loops.iter().flatten().find(|u| u.edge.0 == edge);
            let breaks = &self.edges[edge as usize].breaks;
            let uv = known.map(|u| u.uv.clone()).unwrap_or_else(|| {
                let sample = |t: f64| UvSample { t, uv: place, d: DVec2::ZERO };
                UvCurve::Hermite([sample(breaks[0].t), sample(breaks[breaks.len() - 1].t)].into())
            });
            place = uv.point(breaks[to as usize].t, &mut 0);
            self.added.place.get_or_insert(breaks[from as usize].point);
            l.push(EdgeUse::new(RowId(edge), breaks, [from, to], uv));
        }
        self.added.loops += 1;
        self.join(&mut l);
        tile.loops.push(l);
        tile.entangled = true;
    }
}

/// The edge from the first of `breaks` to the last, in a line.
fn line(breaks: Vec<Break>) -> PreparedEdge {
    let line = NurbsCurve3::line(breaks[0].point, breaks[breaks.len() - 1].point);
    let line = BezierSpline3::new(&line, (0.0, 1.0));
    let bounds = CurveBounds::new(&line);
    PreparedEdge::new(EdgeShape::Curve(line), bounds, breaks, true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::FaceId;

    fn edge(points: &[DVec3]) -> PreparedEdge {
        let share = |k: usize| k as f64 / (points.len() - 1) as f64;
        line(points.iter().enumerate().map(|(k, &point)| Break { t: share(k), point }).collect())
    }

    /// A bow tie whose crossing edges pass each other at a distance, with one lobe reversed.
    #[test]
    fn a_lobe_that_does_not_end_in_one_point_is_turned_back() {
        let [a, b, c, d] = [(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let [below, above] = [0.0, 0.1].map(|z| DVec3::new(1.0, 1.0, z));
        let mut edges = vec![edge(&[a, below, b]), edge(&[b, c]), edge(&[c, above, d]), edge(&[d, a])];
        let chain: Chain = (0..4).map(|edge| (edge, 1)).collect();
        let edge_use = |(edge, from, to): (u32, u32, u32)| {
            let sample = |t: f64| UvSample { t, uv: DVec2::ZERO, d: DVec2::ZERO };
            let uv = UvCurve::Hermite([sample(0.0), sample(1.0)].into());
            EdgeUse::new(RowId(edge), &edges[edge as usize].breaks, [from, to], uv)
        };
        let loops = [[(0, 0, 1), (2, 1, 2), (3, 0, 1)], [(2, 1, 0), (1, 1, 0), (0, 2, 1)]];
        let mut tiles = [Tile {
            face: FaceId(0),
            min: DVec2::ZERO,
            max: DVec2::ONE,
            loops: loops.map(|l| l.map(edge_use).to_vec()).to_vec(),
            entangled: false,
            weight: 0.0,
            centre: DVec3::ZERO,
            proportions: DVec2::ONE,
        }];
        let wanted = Wanted { chain: &chain, brep_edges: 4, lobed: &[0, 1, 2, 3], may_end: false };
        let added = close(&mut tiles, &mut edges, &wanted);
        assert!(added.is_ok_and(|added| added.is_some_and(|added| added.loops > 0)));
        assert!(are_joined(&tiles, &edges));
        let stated = Wanted { lobed: &[], ..wanted };
        assert_eq!(residue(&tiles, &edges, &stated).len(), 0);
    }
}
