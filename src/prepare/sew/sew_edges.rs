//! Adjacent faces without common edges -> faces that share edges.
//!
//! Some writers give every face its own edges, and patches without topology have only their own borders. Free edges of
//! one shell that coincide within the tolerance, in whole or in part, are cut into pieces that match piece by piece.
//! Matching pieces become one edge: the first one's curve, with a pcurve on each face. Their vertices merge, too.

use super::overlap::{CurveQuery, Overlap, carry};
use super::pairs::{Candidate, EDGES_AT_ONCE, EdgeInUse, LeftOut, MOST_PARTNERS, SliverCheck, is_sound, pairs, uses};
use crate::control::Call;
use crate::math::graph::DisjointSets;
use crate::model::{
    BorderTrouble, Coedge, Edge, EdgeId, Face, Loop, NurbsCurve3, Part, Severity, ShellKind, VertexId, of_pieces,
};
use crate::prepare::report::Finding;
use crate::prepare::surface::decompose::BezierSpline3;
use crate::prepare::trims::free_edges::FreeFaces;
use crate::prepare::uv::uv_curve::UvSample;
use crate::prepare::uv::uv_loop::{Along, Piece};
use crate::prepare::wires::heal::{Healing, end_at_roots};
use glam::DVec3;
use std::borrow::Cow;
use std::collections::BTreeSet;

/// A shell is sewn within this part of the least distance between the ends of an edge, so that none vanishes.
const OF_SHORTEST: f64 = 0.125;

/// Largest distance, in tolerances, between the ends of matching pieces: each may have been cut by a different edge.
const SAME_END: f64 = 4.0;

/// Maximum edges of one face in a group of merged pieces that are checked against a further edge.
const OF_ONE_FACE: usize = 8;

/// Maximum rounds of passing the cuts of an edge on to the edges along it.
const ROUNDS: usize = 16;

/// Pairs that a thread takes at a time: about 10 µs each.
const SHARE: usize = 8;

/// Summary of the merged borders.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SewSummary {
    /// Pairs of borders of faces without topology.
    pub(crate) pairs: usize,
    /// Largest distance within a pair, mm.
    pub(crate) width: f64,
}

/// A stretch that two candidates have in common.
struct Contact {
    pair: [usize; 2],
    stretch: Overlap,
    tolerance: f64,
}

/// A piece of an edge, and what replaces it.
struct Replacement {
    /// The edge that replaces it, and whether in the opposite direction.
    edge: u32,
    against: bool,
    /// Whether that edge has the old edge's curve and parameter.
    own: bool,
    /// The piece's range in the parameter of the old edge.
    range: [f64; 2],
    width: f64,
}

/// Merges edges that coincide: those of faces with topology within the part's own tolerance, in open shells of these
/// alone also within `reach`, millimetres; those of faces without topology within the part's tolerance or, if it states
/// none, `reach`.
///
/// Cost: a count of uses if all edges are used in pairs. Otherwise about 10 µs per edge that has a neighbour and 1 µs
/// per knot of it. Identical edges count once, and others have at most [`MOST_PARTNERS`] neighbours of their kind.
pub(crate) fn sew<'a>(
    call: Call<'_>,
    part: Cow<'a, Part>,
    free: &mut FreeFaces,
    reach: f64,
    done: &mut Vec<Healing>,
) -> (Cow<'a, Part>, SewSummary) {
    let candidates = candidates(call, &part, free, reach);
    let (pairs, left_out) = pairs(call, &part, &candidates);
    let mut is_paired = vec![false; candidates.len()];
    pairs.iter().flatten().for_each(|&k| is_paired[k] = true);
    let courses: Vec<Option<CurveQuery>> =
        call.each(EDGES_AT_ONCE, candidates.iter().zip(is_paired), |(candidate, is_paired)| {
            let edge = &part.edges[candidate.used.edge as usize];
            (is_paired && !call.is_cancelled()).then(|| CurveQuery::new(edge))
        });
    if call.is_cancelled() {
        return (part, SewSummary::default());
    }
    let course = |k: usize| courses[k].as_ref().expect("only candidates of pairs are asked for");
    let contacts: Vec<Vec<Contact>> = call.each(SHARE, pairs, |pair| {
        if call.is_cancelled() {
            return Vec::new();
        }
        let [a, b] = pair.map(course);
        let tolerance = candidates[pair[0]].tolerance;
        a.common(b, tolerance).into_iter().map(|stretch| Contact { pair, stretch, tolerance }).collect()
    });
    let mut contacts: Vec<Contact> = contacts.into_iter().flatten().collect();
    let mut thin = SliverCheck::new(&part, free);
    let mut may_join = |pair: [usize; 2], width: f64| {
        let [a, b] = pair.map(|k| &candidates[k].used);
        a.face != b.face || thin.may_join(a.face, [a.edge, b.edge], width, candidates[pair[0]].tolerance)
    };
    contacts.retain(|Contact { pair, stretch, .. }| {
        let [a, b] = pair.map(|k| &candidates[k]);
        a.may_adjoin(b, stretch.b[0] < stretch.b[1]) && may_join(*pair, stretch.width)
    });
    // Merge the nearest first: across a thin face, the further edge is the wrong one.
    contacts.sort_by(|a, b| a.stretch.width.total_cmp(&b.stretch.width));
    let cuts = cuts(candidates.len(), &contacts, &course);
    let mut pieces = PieceGroups::new(&part, &candidates, cuts, &course);
    let mut sewn = SewSummary::default();
    // By shell: shell, candidate of the widest pair, number of pairs, width.
    let mut widest: Vec<(u32, usize, usize, f64)> = Vec::new();
    for contact in contacts.iter().take_while(|_| !call.is_cancelled()) {
        let count = pieces.join(contact, &course, &mut may_join);
        let (first, width) = (&candidates[contact.pair[0]].used, contact.stretch.width);
        if count > 0 && contact.pair.iter().any(|&k| candidates[k].used.untold) {
            sewn = SewSummary { pairs: sewn.pairs + count, width: sewn.width.max(width) };
        } else if count > 0 {
            match widest.iter_mut().find(|t| t.0 == first.shell) {
                Some(t) if t.3 >= width => t.2 += count,
                Some(t) => *t = (first.shell, contact.pair[0], t.2 + count, width),
                None => widest.push((first.shell, contact.pair[0], count, width)),
            }
        }
    }
    for (_, candidate, count, width) in widest {
        let Candidate { used: EdgeInUse { edge, face, .. }, tolerance, .. } = candidates[candidate];
        let what = BorderTrouble::Sewn { pairs: count, width_mm: width, tolerance_mm: tolerance };
        done.push(Healing { face, severity: Severity::Note, told: Finding::at_edge(&part, edge, what) });
    }
    done.extend(thin.kept.into_iter().map(|(face, tolerance_mm)| {
        let told = Finding::new(None, BorderTrouble::ThinFace { tolerance_mm });
        Healing { face, severity: Severity::Note, told }
    }));
    done.extend(left_out.into_values().map(|LeftOut { first, count }| {
        let EdgeInUse { edge, face, .. } = candidates[first].used;
        let what = BorderTrouble::NotCompared { pairs: count, limit: MOST_PARTNERS };
        Healing { face, severity: Severity::Note, told: Finding::at_edge(&part, edge, what) }
    }));
    if contacts.is_empty() || call.is_cancelled() {
        return (part, SewSummary::default());
    }
    let mut part = part.into_owned();
    let replaced = pieces.into_edges(&mut part);
    replace(call, &mut part, free, &replaced);
    (Cow::Owned(part), sewn)
}

/// Free edges, by shell. In shells with faces without topology, all edges of these faces as well.
fn candidates(call: Call<'_>, part: &Part, free: &FreeFaces, reach: f64) -> Vec<Candidate> {
    let may_sew = part.tolerance > 0.0 || free.iter().any(|made| matches!(made, Some(Ok(_))));
    if !may_sew {
        // Faces with topology are sewn within the part's own tolerance only.
        return Vec::new();
    }
    let uses = uses(part, free);
    let shell_of = |shell: u32| part.shells.get(shell as usize);
    let ends = |e: &Edge| Some([*part.vertices.get(e.start.index())?, *part.vertices.get(e.end.index())?]);
    let mut out = Vec::new();
    for of_shell in uses.chunk_by(|a, b| a.shell == b.shell) {
        let untold = of_shell.iter().any(|u| u.untold);
        let open = shell_of(of_shell[0].shell).is_some_and(|s| s.kind == ShellKind::Open);
        let tolerance = if part.tolerance > 0.0 || !untold { part.tolerance } else { reach };
        // Sheets that miss each other by more overlap or gape, and nothing says which of them end where they meet.
        let tolerance = if open && !untold { tolerance.min(reach) } else { tolerance };
        if tolerance <= 0.0 || of_shell.iter().all(|u| u.count != 1 && !u.untold) {
            continue;
        }
        let length = |e: &Edge| ends(e).map_or(0.0, |[a, b]| a.distance(b));
        let told = of_shell.iter().filter(|u| !u.untold).filter_map(|u| part.edges.get(u.edge as usize));
        let shortest = told.filter(|e| e.start != e.end).map(length).fold(f64::INFINITY, f64::min);
        let tolerance = if untold { tolerance } else { tolerance.min(OF_SHORTEST * shortest) };
        if tolerance == 0.0 {
            continue;
        }
        let wanted = of_shell.iter().filter(|u| u.count == 1 || u.untold);
        let usable = call.each(EDGES_AT_ONCE, wanted, |u| {
            let is_usable = is_sound(part, part.edges.get(u.edge as usize)?);
            is_usable.then_some(Candidate { used: *u, tolerance, open: open && !u.untold })
        });
        out.extend(usable.into_iter().flatten());
    }
    out
}

/// For each candidate, the parameters at which it starts, is cut, and ends. It is cut where a stretch in common with
/// another edge ends, and where the other edge is cut. Empty for candidates without contacts.
fn cuts<'c>(count: usize, contacts: &[Contact], course: &impl Fn(usize) -> &'c CurveQuery) -> Vec<Vec<f64>> {
    let mut cuts: Vec<Vec<f64>> = vec![Vec::new(); count];
    for &k in contacts.iter().flat_map(|c| &c.pair) {
        if cuts[k].is_empty() {
            cuts[k].extend(course(k).range());
        }
    }
    for _ in 0..ROUNDS {
        let mut grown = false;
        for Contact { pair, stretch, tolerance } in contacts {
            for (side, range) in [stretch.a, stretch.b].into_iter().enumerate() {
                let [own, other] = [pair[side], pair[1 - side]];
                let opposite = if side == 0 { stretch.b } else { stretch.a };
                let (low, high) = (range[0].min(range[1]), range[0].max(range[1]));
                let from = cuts[own].partition_point(|&t| t <= low);
                let to = cuts[own].partition_point(|&t| t < high).max(from);
                let feet = cuts[own][from..to].iter().map(|&t| course(other).foot(course(own).point(t)).0);
                let marks: Vec<f64> = feet.chain(opposite).collect();
                for t in marks {
                    grown |= add_cut(&mut cuts[other], course(other), t, *tolerance);
                }
            }
        }
        if !grown {
            break;
        }
    }
    cuts
}

/// Adds a cut unless there is one at that place. Returns whether it did.
fn add_cut(cuts: &mut Vec<f64>, course: &CurveQuery, t: f64, tolerance: f64) -> bool {
    let k = cuts.partition_point(|&c| c < t);
    let mut beside = [k.checked_sub(1), Some(k)].into_iter().flatten().filter_map(|k| cuts.get(k));
    if beside.any(|&c| course.one_place(c, t, tolerance.min(course.length() / 8.0))) {
        return false;
    }
    cuts.insert(k, t);
    true
}

/// The pieces between cuts, in groups that merge.
struct PieceGroups<'a> {
    candidates: &'a [Candidate],
    cuts: Vec<Vec<f64>>,
    /// Index of each candidate's first piece.
    first: Vec<usize>,
    /// Each piece's parent (an earlier piece, or itself), whether the two run in opposite directions, and their
    /// distance.
    same: Vec<(usize, bool, f64)>,
    /// For the root of each group, the faces and candidates of all its pieces.
    members: Vec<BTreeSet<(usize, usize)>>,
    /// For each candidate the vertices at its cuts.
    vertices: Vec<Vec<usize>>,
    /// Points of all vertices, and which vertices merge.
    points: Vec<DVec3>,
    merged: DisjointSets,
}

impl<'a> PieceGroups<'a> {
    fn new<'c>(
        part: &Part,
        candidates: &'a [Candidate],
        cuts: Vec<Vec<f64>>,
        course: &impl Fn(usize) -> &'c CurveQuery,
    ) -> Self {
        let mut points = part.vertices.clone();
        let mut first = Vec::with_capacity(cuts.len());
        let mut vertices = Vec::with_capacity(cuts.len());
        let mut count = 0;
        for (k, of_edge) in cuts.iter().enumerate() {
            first.push(count);
            count += of_edge.len().saturating_sub(1);
            let edge = &part.edges[candidates[k].used.edge as usize];
            let last = of_edge.len().saturating_sub(1);
            let vertex = |(i, &t): (usize, &f64)| {
                if i == 0 {
                    edge.start.index()
                } else if i == last {
                    edge.end.index()
                } else {
                    points.push(course(k).point(t));
                    points.len() - 1
                }
            };
            vertices.push(of_edge.iter().enumerate().map(vertex).collect());
        }
        let same = (0..count).map(|k| (k, false, 0.0)).collect();
        let of_candidate = |(k, cuts): (usize, &Vec<f64>)| {
            std::iter::repeat_n(BTreeSet::from([(candidates[k].used.face, k)]), cuts.len().saturating_sub(1))
        };
        let members = cuts.iter().enumerate().flat_map(of_candidate).collect();
        let merged = DisjointSets::new(points.len());
        Self { candidates, cuts, first, same, members, vertices, points, merged }
    }

    /// The root of a piece's group, whether the piece runs against it, and a bound on their distance.
    fn root(&self, mut piece: usize) -> (usize, bool, f64) {
        let (mut against, mut width) = (false, 0.0_f64);
        while self.same[piece].0 != piece {
            let (next, turned, off) = self.same[piece];
            (piece, against, width) = (next, against != turned, width + off);
        }
        (piece, against, width)
    }

    /// Unites two groups unless that merges edges of one face that must stay apart, or of three faces of an open shell.
    /// Returns whether it did.
    fn unite(&mut self, [p, q]: [usize; 2], mut may_join: impl FnMut([usize; 2]) -> bool) -> bool {
        let [small, large] = if self.members[p].len() <= self.members[q].len() { [p, q] } else { [q, p] };
        let [few, mut many] = [small, large].map(|k| std::mem::take(&mut self.members[k]));
        // Of three faces at a border of an open shell, nothing says which two belong together.
        let is_third = few.len() + many.len() > 2 && few.iter().any(|&(_, k)| self.candidates[k].open);
        let may = !is_third
            && few.iter().all(|&(face, k)| {
                let of_face = many.range((face, 0)..=(face, usize::MAX)).take(OF_ONE_FACE);
                of_face.copied().all(|(_, l)| may_join([k, l]))
            });
        if may {
            many.extend(few);
            self.members[p.min(q)] = many;
        } else {
            [self.members[small], self.members[large]] = [few, many];
        }
        may
    }

    /// Merges matching pieces along a stretch unless edges of one face must stay apart. Returns the number of pairs.
    fn join<'c>(
        &mut self,
        contact: &Contact,
        course: &impl Fn(usize) -> &'c CurveQuery,
        may_join: &mut impl FnMut([usize; 2], f64) -> bool,
    ) -> usize {
        let Contact { pair: [a, b], stretch, tolerance } = *contact;
        let against = stretch.b[1] < stretch.b[0];
        let middle = |cuts: &[f64], k: usize| 0.5 * (cuts[k] + cuts[k + 1]);
        let within = |range: [f64; 2], t: f64| t > range[0].min(range[1]) && t < range[0].max(range[1]);
        let of_range = |cuts: &[f64], range: [f64; 2]| -> Vec<usize> {
            (0..cuts.len() - 1).filter(|&k| within(range, middle(cuts, k))).collect()
        };
        let [of_a, of_b] = [of_range(&self.cuts[a], stretch.a), of_range(&self.cuts[b], stretch.b)];
        let mut count = 0;
        for i in of_a {
            let beside = || {
                let foot = course(b).foot(course(a).point(middle(&self.cuts[a], i))).0;
                of_b.iter().copied().find(|&j| within([self.cuts[b][j], self.cuts[b][j + 1]], foot))
            };
            let found = if let [only] = of_b[..] { Some(only) } else { beside() };
            let Some(j) = found else { continue };
            let ends = |k: usize, i: usize| [i, i + 1].map(|i| course(k).point(self.cuts[k][i]));
            let ([s, e], [p, q]) = (ends(a, i), ends(b, j));
            let apart = if against { s.distance(q).max(e.distance(p)) } else { s.distance(p).max(e.distance(q)) };
            if apart > SAME_END * tolerance {
                continue;
            }
            let (p, turned_p, off_p) = self.root(self.first[a] + i);
            let (q, turned_q, off_q) = self.root(self.first[b] + j);
            let width = |pair: [usize; 2]| if pair == [a, b] || pair == [b, a] { stretch.width } else { f64::INFINITY };
            if p == q || !self.unite([p, q], |pair| may_join(pair, width(pair))) {
                continue;
            }
            let turned = against != (turned_p != turned_q);
            self.same[p.max(q)] = (p.min(q), turned, stretch.width + off_p + off_q);
            let opposite = if against { [j + 1, j] } else { [j, j + 1] };
            for (v, w) in [i, i + 1].into_iter().zip(opposite) {
                let (v, w) = (self.vertices[a][v], self.vertices[b][w]);
                self.merged.join(v as u32, w as u32);
            }
            count += 1;
        }
        count
    }

    /// Writes the merged vertices and new edges to the part. Returns the pieces that replace edges.
    fn into_edges(mut self, part: &mut Part) -> Vec<Option<Vec<Replacement>>> {
        let stated = part.edges.len();
        // The edge of each piece that is a root.
        let mut numbers: Vec<u32> = Vec::with_capacity(self.same.len());
        for (k, cuts) in self.cuts.iter().enumerate() {
            let whole = self.candidates[k].used.edge;
            for (i, w) in cuts.windows(2).enumerate() {
                let piece = self.first[k] + i;
                if cuts.len() == 2 || self.same[piece].0 != piece {
                    numbers.push(whole);
                    continue;
                }
                let edge = &part.edges[whole as usize];
                let [start, end] = [i, i + 1].map(|i| VertexId::new(self.vertices[k][i]));
                let curve = restricted(&edge.curve, (w[0], w[1]));
                let edge = Edge { curve, range: (w[0], w[1]), start, end, kind: edge.kind, entity: edge.entity };
                numbers.push(EdgeId::new(part.edges.len()).0);
                part.edges.push(edge);
            }
        }
        let mut out: Vec<Option<Vec<Replacement>>> = (0..stated).map(|_| None).collect();
        for (k, cuts) in self.cuts.iter().enumerate() {
            let whole = self.candidates[k].used.edge;
            let replaced = cuts.windows(2).enumerate().map(|(i, w)| {
                let piece = self.first[k] + i;
                let (root, against, width) = self.root(piece);
                Replacement { edge: numbers[root], against, own: root == piece, range: [w[0], w[1]], width }
            });
            let replaced: Vec<Replacement> = replaced.collect();
            if replaced.len() > 1 || replaced.iter().any(|r| r.edge != whole) {
                out[whole as usize] = Some(replaced);
            }
        }
        part.vertices.clone_from(&self.points);
        end_at_roots(&mut part.edges, &mut self.merged);
        out
    }
}

/// A curve restricted to a part of its domain.
fn restricted(curve: &NurbsCurve3, range: (f64, f64)) -> NurbsCurve3 {
    let BezierSpline3 { degree, breaks, control } = BezierSpline3::new(curve, range);
    of_pieces(degree, &breaks, &control, control.iter().any(|c| c.w != 1.0))
}

/// Makes all faces use the edges that replace others.
fn replace(call: Call<'_>, part: &mut Part, free: &mut FreeFaces, replaced: &[Option<Vec<Replacement>>]) {
    let of = |edge: u32| replaced.get(edge as usize).and_then(Option::as_ref);
    for l in part.faces.iter_mut().flat_map(|f: &mut Face| &mut f.loops) {
        let Loop::Edges(coedges) = l else { continue };
        splice(coedges, |c| {
            let own = |r: &Replacement| Coedge { edge: EdgeId(r.edge), reversed: c.reversed != r.against };
            Some((of(c.edge.0)?.iter().map(own).collect(), c.reversed))
        });
    }
    let edges = &part.edges;
    call.each(1, free.iter_mut().filter_map(|f| f.as_mut()?.as_mut().ok()), |face| {
        for l in &mut face.region.loops {
            splice(&mut l.pieces, |piece| {
                let old = piece.along.edge()?;
                let pieces = of(old)?;
                face.gap = pieces.iter().map(|r| r.width).fold(face.gap, f64::max);
                Some((pieces.iter().map(|r| moved(edges, piece, old, r)).collect(), piece.reversed))
            });
        }
    });
}

/// Replaces items of a loop by others, in reverse where the second value says so. `None`: the item stays.
fn splice<T>(items: &mut Vec<T>, mut others: impl FnMut(&T) -> Option<(Vec<T>, bool)>) {
    let mut all = Vec::with_capacity(items.len() + 1);
    for item in items.drain(..) {
        match others(&item) {
            Some((others, true)) => all.extend(others.into_iter().rev()),
            Some((others, false)) => all.extend(others),
            None => all.push(item),
        }
    }
    *items = all;
}

/// The part of a loop's piece along one piece of its edge, moved to the edge that replaces it.
fn moved(edges: &[Edge], piece: &Piece, old: u32, r: &Replacement) -> Piece {
    let mut samples = UvSample::within(&piece.samples, r.range);
    if !r.own {
        let own = CurveQuery::over(&edges[old as usize].curve, (r.range[0], r.range[1]));
        let kept = CurveQuery::new(&edges[r.edge as usize]);
        samples = carry(&samples, &own, &kept, r.against, r.width);
    }
    Piece { along: Along::Edge(r.edge), reversed: piece.reversed != r.against, samples }
}
