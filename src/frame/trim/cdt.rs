//! Directed segments with multiplicities -> triangles by their winding numbers, in a constrained Delaunay triangulation
//! (`spade`). Segments that cross are split where they meet, or, if they cross too often, routed along edges nearby.

use glam::DVec2;
use spade::handles::{DirectedEdgeHandle, FixedDirectedEdgeHandle, FixedVertexHandle, VertexHandle};
use spade::{
    CdtEdge, ConstrainedDelaunayTriangulation, HasPosition, HierarchyHintGenerator, Intersection,
    LineIntersectionIterator, Point2, Triangulation,
};
use std::collections::HashMap;

/// A constraint: crossing it from right to left raises the winding number by `weight`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    /// Vertex ids, indices into the site list.
    pub(crate) ends: [u32; 2],
    pub(crate) weight: i32,
}

/// Result of [`triangulate`].
#[derive(Clone, Default, Debug)]
pub(crate) struct CdtRegion {
    /// Counter-clockwise triangles of positive winding number, by site index; indices from the number of sites on point
    /// into `crossings`.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Counter-clockwise triangles of winding numbers other than 0 and 1, with how many more times each is used,
    /// reversed if negative.
    pub(crate) layers: Vec<([u32; 3], i32)>,
    /// Points where segments had to be split.
    pub(crate) crossings: Vec<DVec2>,
    /// Number of segments that are not one edge.
    pub(crate) split: u32,
    /// Number of pieces routed along edges nearby.
    pub(crate) led: u32,
}

/// What to do where segments cross, or pass through a vertex.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum AtCrossings {
    /// Split them there.
    Split,
    /// Give up.
    Refuse,
}

/// The segments cross, or a coordinate lies outside the range of `spade`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Refused;

/// Rounds of triangulation after which segments that still cross are routed around each other. A round sees only
/// crossings with segments that are already in, and the next round those that rounding made. Random self-crossing loops
/// need three to seven rounds, dense scribbles a few more.
const MAX_ROUNDS: usize = 12;

/// At most [`FEW_CROSSINGS`] crossings are split, plus this many for each segment. Loops of real files have a handful;
/// n segments of noise have n² of them, and are routed along edges nearby.
const CROSSINGS_PER_SEGMENT: usize = 1;
const FEW_CROSSINGS: usize = 1024;

/// If segments cross, one that meets more edges of the triangulation than this is routed along edges nearby: inserting
/// it can cost the cube of their number (33 s for a few that met up to 5 000).
const MOST_EDGES: usize = 512;

/// Smallest magnitude `spade` accepts, other than zero.
const SMALLEST: f64 = 1.8e-43;

/// Triangulates the region that the segments wind around.
///
/// `sites` may repeat coordinates: one vertex then has several indices, and a triangle names the one whose segment
/// starts the sector it lies in. Sites without segments are allowed.
pub(crate) fn triangulate(
    sites: &[DVec2],
    segments: &[Segment],
    at_crossings: AtCrossings,
) -> Result<CdtRegion, Refused> {
    let classes = Classes::of(sites);
    let mut positions: Vec<Point2<f64>> = classes.first.iter().map(|&s| snapped(sites[s as usize])).collect();
    let mut parts: Vec<SegmentPart> = Vec::with_capacity(segments.len());
    for (index, segment) in segments.iter().enumerate() {
        let ends = segment.ends.map(|v| classes.of_site[v as usize]);
        if ends[0] != ends[1] {
            parts.push(SegmentPart { ends, weight: segment.weight, owner: index as u32 });
        }
    }
    let (whole, real) = (parts.len(), positions.len());
    let most = FEW_CROSSINGS + CROSSINGS_PER_SEGMENT * whole;
    let (mut rounds, mut crossings) = (1, 0);
    // Parts to route along edges nearby.
    let mut long: Vec<SegmentPart> = Vec::new();
    let mut bare = Cdt::default();
    let cdt = loop {
        bare.insert(&positions)?;
        let last = rounds == MAX_ROUNDS || crossings >= most;
        // If nothing crosses, the first round is the last.
        let mut cdt = if rounds == 1 || last { std::mem::take(&mut bare) } else { bare.clone() };
        let most_now = if last { 0 } else { most };
        let mut added = add_constraints(&mut cdt, &parts, MOST_EDGES, most_now, &mut crossings);
        if rounds == 1 && added.conflicts.is_empty() {
            let rest = add_constraints(&mut cdt, &added.long, usize::MAX, most_now, &mut crossings);
            added.parts.extend(rest.parts);
            added = Added { parts: added.parts, ..rest };
        }
        let conflicts = added.conflicts;
        parts = added.parts;
        long.extend(added.long);
        if at_crossings == AtCrossings::Refuse && (!conflicts.is_empty() || parts.len() != whole) {
            return Err(Refused);
        }
        if last || conflicts.is_empty() {
            long.extend(conflicts.iter().map(|(part, _)| *part));
            parts.extend(long.iter().flat_map(|part| cdt.lead(part)));
            break cdt;
        }
        parts.extend(conflicts.iter().map(|(part, _)| *part));
        split(&mut positions, &mut parts, &conflicts);
        rounds += 1;
    };
    let mut region = CdtRegion { led: long.len() as u32, ..label(&cdt, &parts, segments.len()) };
    region.crossings.extend(positions[real..].iter().map(|p| DVec2::new(p.x, p.y)));
    classes.name_corners(&mut region, &cdt, &parts, segments, sites.len());
    Ok(region)
}

/// A piece of a segment between two vertices.
#[derive(Clone, Copy)]
struct SegmentPart {
    ends: [u32; 2],
    weight: i32,
    /// Index of the segment.
    owner: u32,
}

fn snapped(p: DVec2) -> Point2<f64> {
    // Adding zero turns -0.0 into 0.0.
    let f = |x: f64| if x.abs() < SMALLEST { 0.0 } else { x + 0.0 };
    Point2::new(f(p.x), f(p.y))
}

/// A position and its index.
#[derive(Clone)]
struct CdtVertex {
    at: Point2<f64>,
    index: u32,
}

impl HasPosition for CdtVertex {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.at
    }
}

type Spade = ConstrainedDelaunayTriangulation<CdtVertex, (), (), (), HierarchyHintGenerator<f64>>;
type EdgeHandle<'a> = DirectedEdgeHandle<'a, CdtVertex, (), CdtEdge<()>, ()>;

/// A triangulation of positions, with vertices by their index there.
#[derive(Clone, Default)]
struct Cdt {
    spade: Spade,
    handle: Vec<FixedVertexHandle>,
}

impl Cdt {
    /// Inserts the positions that are not in it yet, one by one and in a pseudo-random order.
    ///
    /// Bulk loading along a sweep (`bulk_load`) is no faster at the sizes that occur. It takes minutes where 30 000
    /// positions lie along one curve, since each then flips most of the edges so far. `bulk_load_cdt` breaks ties of
    /// cocircular positions by the order of a hash set.
    fn insert(&mut self, positions: &[Point2<f64>]) -> Result<(), Refused> {
        let mut order: Vec<u32> = (self.handle.len() as u32..positions.len() as u32).collect();
        order.sort_unstable_by_key(|&index| shuffled(index));
        self.handle.resize(positions.len(), FixedVertexHandle::from_index(0));
        for index in order {
            let at = positions[index as usize];
            self.handle[index as usize] = self.spade.insert(CdtVertex { at, index }).map_err(|_| Refused)?;
        }
        Ok(())
    }

    fn vertex(&self, index: u32) -> FixedVertexHandle {
        self.handle[index as usize]
    }

    fn edge(&self, ends: [u32; 2]) -> Option<EdgeHandle<'_>> {
        self.spade.get_edge_from_neighbors(self.vertex(ends[0]), self.vertex(ends[1]))
    }

    /// Whether a line between two vertices meets more than `most` edges and vertices.
    fn meets(&self, ends: [u32; 2], most: usize) -> bool {
        let [from, to] = ends.map(|v| self.vertex(v));
        LineIntersectionIterator::new_from_handles(&self.spade, from, to).nth(most).is_some()
    }

    /// Routes a part that crosses constraints along edges from its start to its end, by the nearer end of each edge
    /// that it crosses. Two edges crossed one after the other are sides of one triangle, so an edge joins their ends.
    fn lead(&self, part: &SegmentPart) -> Vec<SegmentPart> {
        let [from, to] = part.ends;
        let [a, b] = part.ends.map(|v| self.spade.vertex(self.vertex(v)).position());
        let off = |v: VertexHandle<'_, CdtVertex, (), CdtEdge<()>, ()>| {
            let p = v.position();
            ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)).abs()
        };
        let mut path = vec![from];
        for met in LineIntersectionIterator::new_from_handles(&self.spade, self.vertex(from), self.vertex(to)) {
            let next = match met {
                Intersection::VertexIntersection(v) => index(v),
                Intersection::EdgeIntersection(edge) => {
                    let [v, w] = [edge.from(), edge.to()];
                    let nearer = off(v).total_cmp(&off(w)).then(index(v).cmp(&index(w))).is_le();
                    index(if nearer { v } else { w })
                }
                Intersection::EdgeOverlap(_) => continue,
            };
            if path.last() != Some(&next) {
                path.push(next);
            }
        }
        path.windows(2).map(|w| SegmentPart { ends: [w[0], w[1]], ..*part }).collect()
    }
}

/// A pseudo-random permutation of the 32-bit numbers: the last steps of MurmurHash3.
fn shuffled(x: u32) -> u32 {
    let x = (x ^ (x >> 16)).wrapping_mul(0x85eb_ca6b);
    let x = (x ^ (x >> 13)).wrapping_mul(0xc2b2_ae35);
    x ^ (x >> 16)
}

fn index(vertex: VertexHandle<'_, CdtVertex, (), CdtEdge<()>, ()>) -> u32 {
    vertex.data().index
}

fn ends(edge: EdgeHandle<'_>) -> [u32; 2] {
    [index(edge.from()), index(edge.to())]
}

/// Result of [`add_constraints`].
struct Added {
    /// Parts that are edges now.
    parts: Vec<SegmentPart>,
    /// Parts that cross constraints, with the constraint edges that each crosses.
    conflicts: Vec<(SegmentPart, Vec<[u32; 2]>)>,
    /// Parts left out because they meet too many edges.
    long: Vec<SegmentPart>,
}

/// Makes parts edges, and splits those that pass through vertices. Leaves out parts that cross constraints, and parts
/// that meet more than `most_edges` edges. Adds the edges of the conflicts to `crossings`, and stops listing them once
/// it reaches `most`.
fn add_constraints(
    cdt: &mut Cdt,
    parts: &[SegmentPart],
    most_edges: usize,
    most: usize,
    crossings: &mut usize,
) -> Added {
    let mut added = Added { parts: Vec::with_capacity(parts.len()), conflicts: Vec::new(), long: Vec::new() };
    let some_are_long = cdt.spade.num_undirected_edges() > most_edges;
    for &part in parts {
        if some_are_long && cdt.meets(part.ends, most_edges) {
            added.long.push(part);
            continue;
        }
        let [a, b] = part.ends.map(|v| cdt.vertex(v));
        let chain = cdt.spade.try_add_constraint(a, b);
        if chain.is_empty() {
            let mut crossed = Vec::new();
            if *crossings < most {
                crossed.extend(cdt.spade.get_conflicting_edges_between_vertices(a, b).map(ends));
                *crossings += crossed.len();
            }
            added.conflicts.push((part, crossed));
            continue;
        }
        added
            .parts
            .extend(chain.into_iter().map(|edge| SegmentPart { ends: ends(cdt.spade.directed_edge(edge)), ..part }));
    }
    added
}

/// Crossings lie on multiples of this, in cells. A vertex on the same multiple is used instead, so that lines that run
/// along each other or through one point share their crossings. A power of two, so that lattice lines are multiples
/// too.
const CROSSING_GRAIN: f64 = 1.0 / (1u64 << 40) as f64;

/// Splits the crossing parts and the parts they cross at new vertices.
fn split(positions: &mut Vec<Point2<f64>>, parts: &mut Vec<SegmentPart>, conflicts: &[(SegmentPart, Vec<[u32; 2]>)]) {
    let grain = |x: f64| (x / CROSSING_GRAIN).round();
    let key = |p: Point2<f64>| (grain(p.x) as i64, grain(p.y) as i64);
    let mut known: HashMap<(i64, i64), u32> = HashMap::new();
    for (index, &p) in positions.iter().enumerate() {
        known.entry(key(p)).or_insert(index as u32);
    }
    let undirected = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    let mut cuts: HashMap<[u32; 2], Vec<u32>> = HashMap::new();
    for (part, crossed) in conflicts {
        for &edge in crossed {
            let lines = [undirected(part.ends), undirected(edge)];
            let [a, b] = lines[0].map(|v| positions[v as usize]);
            let [c, d] = lines[1].map(|v| positions[v as usize]);
            let (ab, cd) = (DVec2::new(b.x - a.x, b.y - a.y), DVec2::new(d.x - c.x, d.y - c.y));
            let t = DVec2::new(c.x - a.x, c.y - a.y).perp_dot(cd) / ab.perp_dot(cd);
            let t = if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.5 };
            let round = |x: f64| grain(x) * CROSSING_GRAIN;
            let point = snapped(DVec2::new(round(a.x + t * ab.x), round(a.y + t * ab.y)));
            let index = *known.entry(key(point)).or_insert_with(|| {
                positions.push(point);
                positions.len() as u32 - 1
            });
            for line in lines {
                cuts.entry(line).or_default().push(index);
            }
        }
    }
    let mut done = Vec::with_capacity(parts.len() + 2 * conflicts.len());
    for &part in parts.iter() {
        let Some(at) = cuts.get(&undirected(part.ends)) else {
            done.push(part);
            continue;
        };
        let [a, b] = part.ends.map(|v| positions[v as usize]);
        let along = |v: u32| {
            let p = positions[v as usize];
            (p.x - a.x) * (b.x - a.x) + (p.y - a.y) * (b.y - a.y)
        };
        let mut at = at.clone();
        at.sort_unstable_by(|&p, &q| along(p).total_cmp(&along(q)).then(p.cmp(&q)));
        at.push(part.ends[1]);
        let mut from = part.ends[0];
        for to in at {
            if to != from {
                done.push(SegmentPart { ends: [from, to], ..part });
                from = to;
            }
        }
    }
    *parts = done;
}

/// Collects the triangles by their winding numbers, and counts the segments that are split.
fn label(cdt: &Cdt, parts: &[SegmentPart], segments: usize) -> CdtRegion {
    let mut region = CdtRegion::default();
    // By edge, in its normalized direction: the rise of the winding number from right to left.
    let mut rises = vec![0; cdt.spade.num_undirected_edges()];
    let mut pieces = vec![0_u32; segments];
    for part in parts {
        pieces[part.owner as usize] += 1;
        if let Some(edge) = cdt.edge(part.ends) {
            let undirected = edge.as_undirected().fix();
            let forward = undirected.as_directed() == edge.fix();
            rises[undirected.index()] += if forward { part.weight } else { -part.weight };
        }
    }
    region.split = pieces.iter().filter(|&&n| n > 1).count() as u32;
    let winding = winding_numbers(&cdt.spade, &rises);
    for face in cdt.spade.inner_faces() {
        let number = winding[face.index()];
        if number == 0 {
            continue;
        }
        let mut triangle = face.vertices().map(index);
        let first = (0..3).min_by_key(|&corner| triangle[corner]).unwrap_or(0);
        triangle.rotate_left(first);
        if number > 0 {
            region.triangles.push(triangle);
        }
        let more = if number > 0 { number - 1 } else { number };
        if more != 0 {
            region.layers.push((triangle, more));
        }
    }
    // In the order of the sites, not in that of insertion.
    region.triangles.sort_unstable();
    region.layers.sort_unstable();
    region
}

/// Winding numbers by face, spread from the outer face, where the number is 0.
fn winding_numbers(cdt: &Spade, rises: &[i32]) -> Vec<i32> {
    const UNSEEN: i32 = i32::MIN;
    let mut winding = vec![UNSEEN; cdt.num_all_faces()];
    winding[cdt.outer_face().index()] = 0;
    let rise = |edge: FixedDirectedEdgeHandle| {
        let undirected = edge.as_undirected();
        let rise = rises[undirected.index()];
        if undirected.as_directed() == edge { rise } else { -rise }
    };
    // Edges with a face on their left whose number is known: at first the hull's, which have the outer face there.
    let mut stack: Vec<FixedDirectedEdgeHandle> = cdt.convex_hull().map(|edge| edge.fix()).collect();
    while let Some(edge) = stack.pop() {
        let known = cdt.directed_edge(edge);
        if let Some(next) = known.rev().face().as_inner()
            && winding[next.index()] == UNSEEN
        {
            winding[next.index()] = winding[known.face().index()] - rise(edge);
            stack.extend(next.adjacent_edges().map(|edge| edge.fix()));
        }
    }
    winding
}

/// Sites with equal coordinates.
struct Classes {
    of_site: Vec<u32>,
    /// The site of least index of each class.
    first: Vec<u32>,
    /// By class, whether it has several members.
    shared: Vec<bool>,
}

impl Classes {
    fn of(sites: &[DVec2]) -> Self {
        let key = |s: u32| {
            let p = snapped(sites[s as usize]);
            (p.x, p.y)
        };
        let mut order: Vec<u32> = (0..sites.len() as u32).collect();
        order.sort_unstable_by(|&s, &t| {
            let ((ax, ay), (bx, by)) = (key(s), key(t));
            ax.total_cmp(&bx).then(ay.total_cmp(&by)).then(s.cmp(&t))
        });
        // The leader of a class is its least site; classes are then numbered in site order.
        let mut leader = vec![0u32; sites.len()];
        for (at, &site) in order.iter().enumerate() {
            leader[site as usize] =
                if at > 0 && key(order[at - 1]) == key(site) { leader[order[at - 1] as usize] } else { site };
        }
        let mut classes = Self { of_site: vec![0; sites.len()], first: Vec::new(), shared: Vec::new() };
        for (site, &leader) in leader.iter().enumerate() {
            if leader as usize == site {
                classes.of_site[site] = classes.first.len() as u32;
                classes.first.push(leader);
                classes.shared.push(false);
            } else {
                let class = classes.of_site[leader as usize];
                classes.of_site[site] = class;
                classes.shared[class as usize] = true;
            }
        }
        classes
    }

    /// Replaces class indices in the triangles by site indices; crossings follow after the sites.
    fn name_corners(
        &self,
        region: &mut CdtRegion,
        cdt: &Cdt,
        parts: &[SegmentPart],
        segments: &[Segment],
        sites: usize,
    ) {
        let real = self.first.len() as u32;
        let shared = |class: u32| class < real && self.shared[class as usize];
        // Outgoing constraint edges of shared vertices, and the site their segment starts from.
        let mut tails: HashMap<[u32; 2], u32> = HashMap::new();
        for part in parts {
            let site = segments[part.owner as usize].ends[0];
            if shared(part.ends[0]) && self.of_site[site as usize] == part.ends[0] {
                tails.entry(part.ends).or_insert(site);
            }
        }
        for triangle in region.triangles.iter_mut().chain(region.layers.iter_mut().map(|(t, _)| t)) {
            let classes = *triangle;
            for corner in 0..3 {
                let (class, next) = (classes[corner], classes[(corner + 1) % 3]);
                triangle[corner] = if class >= real {
                    sites as u32 + class - real
                } else if !shared(class) {
                    self.first[class as usize]
                } else {
                    sector_start(cdt, class, next, &tails).unwrap_or(self.first[class as usize])
                };
            }
        }
    }
}

/// Turns clockwise about `class` from the edge to `next` to the first outgoing segment, which starts the sector.
/// Returns the site that the segment starts from.
fn sector_start(cdt: &Cdt, class: u32, next: u32, tails: &HashMap<[u32; 2], u32>) -> Option<u32> {
    let first = cdt.edge([class, next])?;
    let mut edge = first;
    loop {
        if let Some(&site) = tails.get(&ends(edge)) {
            return Some(site);
        }
        edge = edge.cw();
        if edge == first {
            return None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(low: f64, high: f64) -> [DVec2; 4] {
        [DVec2::splat(low), DVec2::new(high, low), DVec2::splat(high), DVec2::new(low, high)]
    }

    fn ring(first: u32, count: u32) -> impl Iterator<Item = Segment> {
        (0..count).map(move |k| Segment { ends: [first + k, first + (k + 1) % count], weight: 1 })
    }

    #[test]
    fn crossings_are_refused_or_split() {
        let sites = [square(0.0, 2.0), square(1.0, 3.0)].concat();
        let segments: Vec<Segment> = ring(0, 4).chain(ring(4, 4)).collect();
        assert!(triangulate(&sites, &segments, AtCrossings::Refuse).is_err());
        let region = triangulate(&sites, &segments, AtCrossings::Split).expect("finite coordinates");
        assert_eq!(region.crossings.len(), 2);
        assert_eq!(region.split, 4);
        assert_eq!(region.layers.iter().map(|&(_, times)| times).collect::<Vec<_>>(), [1, 1], "the squares' overlap");
        let position = |v: u32| sites.get(v as usize).copied().unwrap_or_else(|| region.crossings[v as usize - 8]);
        let area = |t: &[u32; 3]| (position(t[1]) - position(t[0])).perp_dot(position(t[2]) - position(t[0]));
        assert_eq!(region.triangles.iter().map(area).sum::<f64>(), 14.0);
    }

    #[test]
    fn holes_stay_empty_and_free_vertices_are_used() {
        // A frame around an empty square, and a vertex without segments.
        let mut sites = [square(0.0, 4.0), square(1.0, 2.0)].concat();
        sites.push(DVec2::splat(3.0));
        let inner = ring(4, 4).map(|s| Segment { ends: [s.ends[1], s.ends[0]], weight: 1 });
        let segments: Vec<Segment> = ring(0, 4).chain(inner).collect();
        let region = triangulate(&sites, &segments, AtCrossings::Refuse).expect("simple");
        assert!(region.layers.is_empty() && region.split == 0);
        // Triangles of a region with one hole: vertices on the boundary, plus two per inner vertex.
        assert_eq!(region.triangles.len(), 8 + 2);
        assert!(region.triangles.iter().flatten().any(|&v| v == 8));
    }

    #[test]
    fn many_lines_through_one_point_terminate() {
        // Their crossings round to different points, which cross again.
        let count = 12;
        let point =
            |k: u32| DVec2::new(0.1, 0.7) + DVec2::from_angle(0.37 + f64::from(k) * std::f64::consts::TAU / 24.0);
        let sites: Vec<DVec2> = (0..2 * count).map(point).collect();
        let segments: Vec<Segment> = (0..count).map(|k| Segment { ends: [k, k + count], weight: 1 }).collect();
        let region = triangulate(&sites, &segments, AtCrossings::Split).expect("finite coordinates");
        assert!(region.crossings.len() < 100, "{}", region.crossings.len());
        assert_eq!(region.split, count);
    }

    #[test]
    fn segments_that_meet_many_edges_are_routed_only_if_others_cross() {
        // A line through a strip of points, and two squares that may overlap.
        for (other, led) in [(square(5.0, 7.0), 0), (square(4.0, 6.0), 1)] {
            let count = 2 * MOST_EDGES as u32;
            let strip = (0..=count).map(|k| DVec2::new(f64::from(k), if k % 2 == 0 { 1.0 } else { -1.0 }));
            let ends = [DVec2::new(-1.0, 0.0), DVec2::new(f64::from(count) + 1.0, 0.0)];
            let mut sites: Vec<DVec2> = ends.into_iter().chain(strip).collect();
            let first = sites.len() as u32;
            sites.extend(square(3.0, 5.0).iter().chain(&other).map(|&p| p + DVec2::splat(10.0)));
            let mut segments = vec![Segment { ends: [0, 1], weight: 1 }, Segment { ends: [1, 0], weight: 1 }];
            segments.extend(ring(first, 4).chain(ring(first + 4, 4)));
            let region = triangulate(&sites, &segments, AtCrossings::Split).expect("finite coordinates");
            assert_eq!(region.led, 2 * led, "both ways along the line");
        }
    }

    #[test]
    fn coordinates_beyond_the_range_of_spade_are_refused() {
        let sites = square(-1e300, 1e300);
        assert!(triangulate(&sites, &ring(0, 4).collect::<Vec<_>>(), AtCrossings::Split).is_err());
        let mut sites = square(0.0, 1.0);
        sites[0] = DVec2::splat(1e-300);
        assert!(triangulate(&sites, &ring(0, 4).collect::<Vec<_>>(), AtCrossings::Refuse).is_ok());
    }
}
