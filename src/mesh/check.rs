//! Batches -> facts: whether a mesh is closed, consistently oriented and finite, and its size.
//!
//! Half-edge pairing: directed edge uses are summed over vertices welded by their exact bits, never by distance. Where
//! uses do not cancel, the cause is a free edge of the file, a non-orientable edge, or a defect of the mesh. Tests,
//! `--check` and the examples share this check.

use super::packed::lines_of;
use super::{Batch, BatchView, EdgeLine, FrameView, SceneInstance, ScenePart};
use crate::math::boxes::around;
use crate::math::graph::DisjointSets;
use crate::math::keyed::Buckets;
use crate::math::{Seeded, bits};
use crate::model::{EdgeId, FaceId, PartId};
use glam::DVec3;
use std::collections::HashMap;
use std::fmt;

/// Why the directed uses of a mesh edge do not cancel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Cause {
    /// A crack in the mesh: the file's shell continues here.
    Defect,
    /// On an edge whose faces cannot be oriented consistently ([`ScenePart::not_orientable`]).
    NotOrientable(EdgeId),
    /// On a free edge of the file, where a sheet ends ([`ScenePart::free_edges`]).
    FreeEdge(EdgeId),
}

/// Segments of a part's free and non-orientable edges, keyed by the bits of their ends. They need not be balanced.
///
/// Taken from the edges' polylines, not from vertex origins: a vertex at a corner names only one of its edges.
#[derive(Default)]
struct ExpectedUnbalanced(HashMap<[[u64; 3]; 2], Cause, Seeded>);

impl ExpectedUnbalanced {
    /// `lines` are the part's edge lines, ascending by edge. An edge without a line excuses nothing.
    fn of(part: &ScenePart, lines: &[EdgeLine]) -> Self {
        let mut segments = HashMap::default();
        let free = part.free_edges.iter().map(|&edge| Cause::FreeEdge(edge));
        for cause in free.chain(part.not_orientable.iter().map(|&edge| Cause::NotOrientable(edge))) {
            let (Cause::FreeEdge(edge) | Cause::NotOrientable(edge)) = cause else { continue };
            let Ok(line) = lines.binary_search_by_key(&edge, |line| line.edge) else { continue };
            let mut points: Vec<_> = lines[line].points.iter().map(|&point| bits::of_point(point)).collect();
            points.dedup();
            segments.extend(points.windows(2).map(|ends| (sorted([ends[0], ends[1]]), cause)));
        }
        Self(segments)
    }

    fn cause(&self, from: DVec3, to: DVec3) -> Cause {
        if self.0.is_empty() {
            return Cause::Defect;
        }
        self.0.get(&sorted([bits::of_point(from), bits::of_point(to)])).copied().unwrap_or(Cause::Defect)
    }
}

fn sorted(mut ends: [[u64; 3]; 2]) -> [[u64; 3]; 2] {
    ends.sort_unstable();
    ends
}

/// Most bad edges listed as examples per part: defects before others, longest first.
const EXAMPLES: usize = 8;

/// An edge whose directed uses do not cancel.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BadEdge {
    /// The part.
    pub part: PartId,
    /// One end, millimetres, part coordinates.
    pub from: DVec3,
    /// The other end.
    pub to: DVec3,
    /// Uses `from → to` minus uses `to → from`; positive.
    pub balance: u32,
    /// Triangles that use the edge, in either direction.
    pub uses: u32,
    /// Faces of these triangles, ascending, without repeats.
    pub faces: Vec<FaceId>,
    /// Why the uses do not cancel.
    pub cause: Cause,
}

/// Counts and measures of a mesh.
///
/// A closed, consistently oriented mesh has zero `open_edges`, `unbalanced_edges`, `collapsed`, `non_finite` and
/// `bad_indices`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshFacts {
    /// Triangles, collapsed ones included.
    pub triangles: u64,
    /// Distinct vertex positions (-0.0 equals 0.0).
    pub vertices: u64,
    /// Triangles with two corners at the same position. Of the other counts, only `triangles` includes them.
    pub collapsed: u64,
    /// Other triangles of exactly zero area.
    pub zero_area: u64,
    /// Vertices whose position or normal is NaN or infinite.
    pub non_finite: u64,
    /// Triangles with a vertex index out of range. Of the other counts, only `triangles` includes them.
    pub bad_indices: u64,
    /// Edges used by one triangle.
    pub open_edges: u64,
    /// Edges used by more than two triangles.
    pub nonmanifold_edges: u64,
    /// Edges whose directed uses do not cancel; open edges are among them.
    pub unbalanced_edges: u64,
    /// Length of the unbalanced edges, each times its balance, millimetres.
    pub unbalanced_length: f64,
    /// Unbalanced edges on free edges of the file.
    pub free_edges: u64,
    /// Unbalanced edges on edges of the file whose faces cannot be oriented consistently.
    pub not_orientable: u64,
    /// All other unbalanced edges: cracks, which no mesh should have.
    pub defects: u64,
    /// Length of the defects, each times its balance, millimetres.
    pub defect_length: f64,
    /// Faces along defects, ascending; empty in sums over parts.
    pub defect_faces: Vec<FaceId>,
    /// Connected components of the welded mesh.
    pub components: u64,
    /// Components of negative volume: voids, or pieces turned inside out.
    pub negative_components: u64,
    /// Sum of the triangles' areas, mm².
    pub area: f64,
    /// Volume by the divergence theorem about the box's centre, mm³. Meaningful only if no edge is unbalanced.
    pub volume: f64,
    /// Up to 8 unbalanced edges: defects first, then longest first.
    pub examples: Vec<BadEdge>,
}

impl MeshFacts {
    /// Whether every edge's directed uses cancel and the mesh [is well formed](Self::is_well_formed).
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.unbalanced_edges == 0 && self.is_well_formed()
    }

    /// Whether all indices are in range, all vertices finite, and no triangle collapsed. Holds for open sheets too.
    #[must_use]
    pub fn is_well_formed(&self) -> bool {
        self.collapsed == 0 && self.non_finite == 0 && self.bad_indices == 0
    }

    /// Adds one instance of `part`. `det` is the determinant of its transform, a uniform scale; a negative one mirrors.
    fn add_placed(&mut self, part: &Self, det: f64) {
        let scale = libm::cbrt(det.abs());
        self.triangles += part.triangles;
        self.vertices += part.vertices;
        self.collapsed += part.collapsed;
        self.zero_area += part.zero_area;
        self.non_finite += part.non_finite;
        self.bad_indices += part.bad_indices;
        self.open_edges += part.open_edges;
        self.nonmanifold_edges += part.nonmanifold_edges;
        self.unbalanced_edges += part.unbalanced_edges;
        self.unbalanced_length += part.unbalanced_length * scale;
        self.free_edges += part.free_edges;
        self.not_orientable += part.not_orientable;
        self.defects += part.defects;
        self.defect_length += part.defect_length * scale;
        self.components += part.components;
        self.negative_components += part.negative_components;
        self.area += part.area * scale * scale;
        self.volume += part.volume * det.abs();
    }
}

impl fmt::Display for MeshFacts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { triangles, vertices, area, volume, components, negative_components, .. } = self;
        let Self { open_edges, unbalanced_edges, unbalanced_length, free_edges, not_orientable, defects, .. } = self;
        let Self { nonmanifold_edges, collapsed, zero_area, non_finite, bad_indices, .. } = self;
        write!(
            f,
            "{triangles} triangles, {vertices} vertices, area {area:.9e} mm², volume {volume:.9e} mm³, {components} \
             pieces ({negative_components} of negative volume); open {open_edges}, unbalanced {unbalanced_edges} \
             ({unbalanced_length:.3e} mm; {free_edges} on free edges, {not_orientable} not orientable, {defects} \
             defects), non-manifold {nonmanifold_edges}, collapsed {collapsed}, zero area {zero_area}, not finite \
             {non_finite}, bad indices {bad_indices}"
        )?;
        for BadEdge { part, from, to, balance, uses, faces, cause } in &self.examples {
            let (part, faces) = (part.0, faces.iter().map(|face| face.0).collect::<Vec<_>>());
            write!(
                f,
                "\n  part {part} edge {from} → {to} used {uses} times, balance {balance}, faces {faces:?}, {cause:?}"
            )?;
        }
        Ok(())
    }
}

/// [`MeshFacts`] of a whole scene.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct SceneFacts {
    /// Facts of each part in its own coordinates, in the order of the scene.
    pub parts: Vec<MeshFacts>,
    /// Sum over instances: a part placed twice counts twice, a part without instances does not count. Lengths, areas
    /// and volumes are scaled as placed. Examples are the first of all parts' examples, in part coordinates.
    pub total: MeshFacts,
    /// Faces without triangles, by (part, face), each part once.
    pub faces_without_triangles: Vec<(PartId, FaceId)>,
    /// Faces without triangles, counted per instance.
    pub placed_faces_without_triangles: u64,
}

/// Checks every part of a finished frame. O(triangles), about 0.4 µs each.
///
/// Needs the frame's edge lines to find the [`Cause`] of unbalanced edges. Without them, all count as defects.
#[must_use]
pub fn check_scene<'a>(frame: impl Into<FrameView<'a>>) -> SceneFacts {
    facts_of(&frame.into())
}

fn facts_of(frame: &FrameView<'_>) -> SceneFacts {
    let mut facts = SceneFacts::default();
    let mut missing = vec![0_u64; frame.scene.parts.len()];
    let by_part = frame.batches_by_part().into_iter().zip(frame.meshed());
    for (index, (part, (batches, meshed))) in frame.scene.parts.iter().zip(by_part).enumerate() {
        let id = PartId::new(index);
        let empty = meshed.iter().enumerate().filter(|(_, meshed)| !**meshed).map(|(face, _)| (id, FaceId::new(face)));
        let before = facts.faces_without_triangles.len();
        facts.faces_without_triangles.extend(empty);
        missing[index] = (facts.faces_without_triangles.len() - before) as u64;
        let lines = lines_of(frame.edge_lines, id);
        facts.parts.push(check_batches(batches.into_iter().copied(), &ExpectedUnbalanced::of(part, lines)));
    }
    for SceneInstance { part, transform, .. } in &frame.scene.instances {
        if let Some(part_facts) = facts.parts.get(part.index()) {
            facts.total.add_placed(part_facts, transform.matrix3.determinant());
            facts.placed_faces_without_triangles += missing[part.index()];
        }
    }
    let examples = facts.parts.iter().flat_map(|part| &part.examples).take(EXAMPLES).cloned();
    facts.total.examples = examples.collect();
    facts
}

/// Checks the batches of one part, in its coordinates. Counts every unbalanced edge as a defect.
#[must_use]
pub fn check_part<'a>(batches: impl IntoIterator<Item = &'a Batch>) -> MeshFacts {
    check_batches(batches.into_iter().map(BatchView::from), &ExpectedUnbalanced::default())
}

fn check_batches<'a>(batches: impl IntoIterator<Item = BatchView<'a>>, excused: &ExpectedUnbalanced) -> MeshFacts {
    let mut facts = MeshFacts::default();
    let soup = Soup::weld(batches, &mut facts);
    facts.vertices = soup.points.len() as u64;
    soup.measure(&mut facts);
    soup.pair_edges(&mut facts, excused);
    facts
}

/// Triangles over welded vertices.
struct Soup<'a> {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// (first triangle, batch), ascending, to find a triangle's batch.
    owners: Vec<(usize, BatchView<'a>)>,
}

impl<'a> Soup<'a> {
    fn weld(batches: impl IntoIterator<Item = BatchView<'a>>, facts: &mut MeshFacts) -> Self {
        let mut soup = Self { points: Vec::new(), triangles: Vec::new(), owners: Vec::new() };
        let mut known: HashMap<[u64; 3], u32, Seeded> = HashMap::default();
        let mut ids = Vec::new();
        for batch in batches {
            let mesh = batch.mesh;
            let broken_normal = |k: usize| mesh.normals.get(k).is_some_and(|normal| !normal.is_finite());
            let broken = |&(k, point): &(usize, &DVec3)| !point.is_finite() || broken_normal(k);
            facts.non_finite += mesh.positions.iter().enumerate().filter(broken).count() as u64;
            ids.clear();
            ids.extend(mesh.positions.iter().map(|&point| {
                let fresh = u32::try_from(soup.points.len()).unwrap_or(u32::MAX);
                *known.entry(bits::of_point(point)).or_insert_with(|| {
                    soup.points.push(point + DVec3::ZERO);
                    fresh
                })
            }));
            soup.owners.push((soup.triangles.len(), batch));
            facts.triangles += mesh.triangles.len() as u64;
            for corners in mesh.triangles.iter() {
                let [Some(&a), Some(&b), Some(&c)] = corners.map(|corner| ids.get(corner as usize)) else {
                    facts.bad_indices += 1;
                    continue;
                };
                if a == b || b == c || c == a {
                    facts.collapsed += 1;
                } else {
                    soup.triangles.push([a, b, c]);
                }
            }
        }
        soup
    }

    fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|corner| self.points[corner as usize])
    }

    /// Area, volume and components.
    fn measure(&self, facts: &mut MeshFacts) {
        /// Thickness that rounding gives to a flat component, as a share of the largest coordinates.
        const ROUNDING: f64 = 32.0 * f64::EPSILON;
        let [low, high] = around(self.points.iter().copied());
        let centre = if self.points.is_empty() { DVec3::ZERO } else { 0.5 * (low + high) };
        let thickness = ROUNDING * low.abs().max(high.abs()).length();
        let mut pieces = DisjointSets::new(self.points.len());
        for &[a, b, c] in &self.triangles {
            pieces.join(a, b);
            pieces.join(b, c);
        }
        let mut volumes = vec![0.0; self.points.len()];
        let mut areas = vec![0.0; self.points.len()];
        let mut used = vec![false; self.points.len()];
        let mut total = 0.0;
        for &triangle in &self.triangles {
            let [a, b, c] = self.corners(triangle).map(|point| point - centre);
            let area = 0.5 * (b - a).cross(c - a).length();
            facts.zero_area += u64::from(area == 0.0);
            facts.area += area;
            let volume = a.dot(b.cross(c)) / 6.0;
            total += volume;
            let root = pieces.root(triangle[0]) as usize;
            volumes[root] += volume;
            areas[root] += area;
            used[root] = true;
        }
        facts.volume = total;
        facts.components = used.iter().filter(|used| **used).count() as u64;
        // A component that is flat in the mesh, because it is thinner than the tolerance, faces both ways.
        let inwards = volumes.iter().zip(&areas).filter(|(volume, area)| **volume < -thickness * **area);
        facts.negative_components = inwards.count() as u64;
    }

    /// Groups the directed uses of each edge: a counting sort by the lower vertex, then a sort of each short list.
    fn pair_edges(&self, facts: &mut MeshFacts, excused: &ExpectedUnbalanced) {
        let uses = || {
            self.triangles.iter().enumerate().flat_map(|(index, &[a, b, c])| {
                [(a, b), (b, c), (c, a)].map(|(from, to)| (from.min(to), (from.max(to), from < to, index)))
            })
        };
        let mut sorted = Buckets::of(self.points.len(), uses());
        let mut unbalanced = Vec::new();
        for low in 0..self.points.len() as u32 {
            sorted.at_mut(low).sort_unstable();
        }
        for (low, &from) in (0..).zip(&self.points) {
            for group in sorted.at(low).chunk_by(|x, y| x.0 == y.0) {
                let forward = group.iter().filter(|(_, forward, _)| *forward).count();
                let balance = (2 * forward).abs_diff(group.len());
                facts.open_edges += u64::from(group.len() == 1);
                facts.nonmanifold_edges += u64::from(group.len() > 2);
                if balance != 0 {
                    let to = self.points[group[0].0 as usize];
                    let (from, to) = if 2 * forward > group.len() { (from, to) } else { (to, from) };
                    unbalanced.push(Unbalanced { from, to, balance, cause: excused.cause(from, to), group });
                }
            }
        }
        self.tell(unbalanced, facts);
    }

    /// Counts unbalanced edges by cause and lists the worst as examples.
    fn tell(&self, mut unbalanced: Vec<Unbalanced<'_>>, facts: &mut MeshFacts) {
        let faces_of = |edge: &Unbalanced| {
            let mut faces: Vec<_> = edge.group.iter().filter_map(|used| Some(self.owner(used.2)?.face)).collect();
            faces.sort_unstable();
            faces.dedup();
            faces
        };
        facts.unbalanced_edges = unbalanced.len() as u64;
        for edge in &unbalanced {
            facts.unbalanced_length += edge.length();
            match edge.cause {
                Cause::FreeEdge(_) => facts.free_edges += 1,
                Cause::NotOrientable(_) => facts.not_orientable += 1,
                Cause::Defect => {
                    facts.defects += 1;
                    facts.defect_length += edge.length();
                    facts.defect_faces.extend(faces_of(edge));
                }
            }
        }
        facts.defect_faces.sort_unstable();
        facts.defect_faces.dedup();
        let is_defect = |edge: &Unbalanced| edge.cause == Cause::Defect;
        // Stable: ties stay in vertex order.
        let length = |edge: &Unbalanced| edge.from.distance(edge.to);
        unbalanced.sort_by(|x, y| is_defect(y).cmp(&is_defect(x)).then(length(y).total_cmp(&length(x))));
        let example = |edge: &Unbalanced| {
            let &Unbalanced { from, to, balance, cause, group } = edge;
            let part = self.owner(group[0].2)?.part;
            let (balance, uses, faces) = (balance as u32, group.len() as u32, faces_of(edge));
            Some(BadEdge { part, from, to, balance, uses, faces, cause })
        };
        facts.examples = unbalanced.iter().take(EXAMPLES).filter_map(example).collect();
    }

    fn owner(&self, triangle: usize) -> Option<BatchView<'a>> {
        let after = self.owners.partition_point(|(first, _)| *first <= triangle);
        self.owners[..after].last().map(|(_, batch)| *batch)
    }
}

/// A mesh edge whose directed uses do not cancel.
struct Unbalanced<'a> {
    from: DVec3,
    to: DVec3,
    balance: usize,
    cause: Cause,
    /// Its uses: (higher vertex, whether the use starts at the lower vertex, triangle).
    group: &'a [(u32, bool, usize)],
}

impl Unbalanced<'_> {
    fn length(&self) -> f64 {
        self.from.distance(self.to) * self.balance as f64
    }
}
