//! Faces that are drafted already -> their drafts, for faces with the same content.
//!
//! [`face::draft`](crate::prepare::tiles::face::draft) reads a face, its edges and vertices, which of the edges other
//! faces use, and the face's size. All of it is hashed here, after the part was healed and sewn. An edge is identified
//! by its rank among the face's edges, ascending by number; so is a vertex. An edge that comes or goes elsewhere in the
//! part gives all others new numbers, and no other rank.

use super::content::{Content, ContentHash, Digest};
use crate::model::{Coedge, Edge, EdgeId, Face, Loop, Part, VertexId};
use crate::prepare::tiles::draft::FaceDraft;
use crate::prepare::tiles::traced;
use glam::DVec3;
use std::collections::HashMap;
use std::sync::Arc;

/// The draft of a face, in which the number of an edge is its rank.
#[derive(Clone, Debug)]
pub(crate) struct KeptFace {
    hash: ContentHash,
    pub(super) draft: Arc<FaceDraft>,
}

/// Drafts by the content of their faces.
pub(crate) type KeptFaces<'a> = HashMap<ContentHash, &'a KeptFace>;

/// Finds drafts by their content.
pub(crate) fn by_content<'a>(kept: impl Iterator<Item = &'a KeptFace>) -> KeptFaces<'a> {
    kept.map(|face| (face.hash, face)).collect()
}

/// Hash of what the draft of a face without free trims reads.
pub(crate) struct FaceContent {
    hash: ContentHash,
    /// Its edges, ascending.
    edges: Vec<u32>,
}

impl FaceContent {
    /// `shared` marks edges that have other faces. `size` is that of the part. `None` if an edge or a vertex is not in
    /// the part.
    pub(crate) fn of(part: &Part, face: &Face, shared: &[bool], size: f64) -> Option<Self> {
        let edges = ascending(face.wires().flatten().map(|used| used.edge.0).collect());
        let rows: Vec<(&Edge, bool)> = edges
            .iter()
            .map(|&edge| Some((part.edges.get(edge as usize)?, *shared.get(edge as usize)?)))
            .collect::<Option<_>>()?;
        let poles =
            face.loops.iter().filter_map(|of| if let Loop::Vertex(vertex) = of { Some(vertex.0) } else { None });
        let ends = rows.iter().flat_map(|(edge, _)| [edge.start.0, edge.end.0]);
        let vertices = ascending(ends.chain(poles).collect());
        let points = vertices.iter().map(|&vertex| part.vertices.get(vertex as usize).copied());
        let points: Vec<DVec3> = points.collect::<Option<_>>()?;
        let vertex = |id: VertexId| vertices.binary_search(&id.0).unwrap_or(usize::MAX);
        let place = |id: EdgeId| edges.binary_search(&id.0).unwrap_or(usize::MAX);

        let mut digest = Digest::new();
        traced::face_extent(part, face).unwrap_or(size).feed(&mut digest);
        part.tolerance.feed(&mut digest);
        points.feed(&mut digest);
        rows.len().feed(&mut digest);
        for (Edge { curve, range, start, end, kind, entity: _ }, shared) in rows {
            (curve, *range).feed(&mut digest);
            (vertex(*start), vertex(*end)).feed(&mut digest);
            (*kind, shared).feed(&mut digest);
        }
        let Face { surface, loops, reversed, trims, shell: _, lost, refused, colour: _, name: _, entity: _ } = face;
        (surface, *reversed).feed(&mut digest);
        (trims, (*lost, refused)).feed(&mut digest);
        loops.len().feed(&mut digest);
        for of in loops {
            match of {
                Loop::Edges(uses) => {
                    uses.len().feed(&mut digest);
                    for Coedge { edge, reversed } in uses {
                        (place(*edge), *reversed).feed(&mut digest);
                    }
                }
                // No list is as long.
                Loop::Vertex(pole) => (usize::MAX, vertex(*pole)).feed(&mut digest),
            }
        }
        Some(Self { hash: digest.finish(), edges })
    }

    /// The draft of a face with this content, with the numbers of this face's edges.
    pub(crate) fn find<'a>(&self, kept: &KeptFaces<'a>) -> Option<(FaceDraft, &'a KeptFace)> {
        let face = *kept.get(&self.hash)?;
        Some((face.draft.renumbered(|place| self.edges.get(place as usize).copied())?, face))
    }

    /// Keeps the draft of the face.
    pub(crate) fn keep(&self, draft: &FaceDraft) -> Option<KeptFace> {
        let place = |edge: u32| u32::try_from(self.edges.binary_search(&edge).ok()?).ok();
        Some(KeptFace { hash: self.hash, draft: Arc::new(draft.renumbered(place)?) })
    }
}

fn ascending(mut ids: Vec<u32>) -> Vec<u32> {
    ids.sort_unstable();
    ids.dedup();
    ids
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{CurveKind, Frame3, Surface, shapes};
    use crate::prepare::wires::boundary::shared_edges;

    fn hash(part: &Part, face: usize) -> ContentHash {
        let free: Vec<_> = part.faces.iter().map(|_| None).collect();
        FaceContent::of(part, &part.faces[face], &shared_edges(part, &free), 7.0).expect("all edges").hash
    }

    fn uses(part: &mut Part) -> &mut Vec<Coedge> {
        let Loop::Edges(uses) = &mut part.faces[2].loops[0] else { panic!("a wire") };
        uses
    }

    /// The first edge of the face.
    fn edge(part: &mut Part) -> &mut Edge {
        let edge = uses(part)[0].edge;
        &mut part.edges[edge.index()]
    }

    /// Every change that the draft of a face may see changes the hash, and no two of them have the same one.
    #[test]
    fn whatever_a_draft_reads_is_hashed() {
        let part = || shapes::by_name("box").expect("a shape").parts.remove(0);
        let changes: Vec<fn(&mut Part)> = vec![
            |_| {},
            |part| part.faces[2].reversed ^= true,
            |part| part.faces[2].surface = Surface::Cylinder { frame: Frame3::WORLD, radius: 1.0 },
            |part| part.faces[2].loops.push(Loop::Vertex(VertexId(0))),
            |part| uses(part)[0].reversed ^= true,
            |part| uses(part).rotate_left(1),
            |part| _ = uses(part).pop(),
            |part| part.tolerance += 1e-3,
            |part| edge(part).range.1 *= 0.5,
            |part| edge(part).kind = CurveKind::Circle,
            |part| edge(part).curve.points[0].x += 1.0,
            |part| edge(part).start = edge(part).end,
            |part| {
                let start = edge(part).start.index();
                part.vertices[start].z += 1.0;
            },
            // Only a neighbour goes.
            |part| {
                let edge = uses(part)[0].edge;
                let of = |face: &Face| face.wires().flatten().any(|used| used.edge == edge);
                let neighbour = (0..part.faces.len()).find(|&k| k != 2 && of(&part.faces[k])).expect("a neighbour");
                part.faces[neighbour].loops.clear();
            },
        ];
        let hashed = |change: &fn(&mut Part)| {
            let mut part = part();
            change(&mut part);
            hash(&part, 2)
        };
        let hashes: Vec<ContentHash> = changes.iter().map(hashed).collect();
        for (k, hash) in hashes.iter().enumerate() {
            assert_eq!(hashes.iter().position(|other| other == hash), Some(k));
        }
    }

    #[test]
    fn a_face_without_edges_depends_on_the_size_of_the_part() {
        let mut part = shapes::by_name("box").expect("a shape").parts.remove(0);
        part.faces[0].loops.clear();
        let of = |size| FaceContent::of(&part, &part.faces[0], &[], size).expect("no edges").hash;
        assert_ne!(of(1.0), of(2.0));
    }

    #[test]
    fn a_face_of_unknown_edges_has_no_content() {
        let mut part = shapes::by_name("box").expect("a shape").parts.remove(0);
        part.edges.clear();
        assert!(FaceContent::of(&part, &part.faces[0], &[], 1.0).is_none());
    }
}
