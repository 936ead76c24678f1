//! Places where the images of edges meet -> points in space that both edges contain.

use super::draft::{DraftAlong, DraftTile};
use super::meeting::Meeting;
use crate::model::Part;
use crate::prepare::regions::lobes::LobeCut;
use crate::prepare::uv::projector::Projector;
use crate::prepare::uv::uv_curve::SAME_SHARE;
use glam::DVec3;

/// The common point in space of both edges where a loop is cut; `None` if they are too far apart. A lobe between two
/// distinct points cannot be reversed: their joint would be used twice, and by no other face.
pub(super) fn common_point(part: &Part, cut: &LobeCut, projector: &Projector<'_>) -> Option<DVec3> {
    // Vertices and poles stay where they are.
    let [(a, a_stays), (b, b_stays)] = cut.passes.map(|pass| {
        let Some((edge, t)) = pass else { return (projector.point(cut.uv), true) };
        let edge = &part.edges[edge as usize];
        let (t0, t1) = edge.range;
        let close = SAME_SHARE * (t1 - t0);
        match t {
            _ if t - t0 <= close => (part.vertices[edge.start.index()], true),
            _ if t1 - t <= close => (part.vertices[edge.end.index()], true),
            _ => (edge.curve.point(t), false),
        }
    });
    let may_meet = if a_stays && b_stays { a == b } else { a.distance(b) <= 10.0 * projector.tolerance };
    may_meet.then_some(if b_stays { b } else { a })
}

/// Edge, parameter and point in space of both sides of a meeting of a tile's loops.
pub(super) fn ends(part: &Part, tile: &DraftTile, m: &Meeting) -> [(u32, f64, DVec3); 2] {
    m.at.map(|((l, k), t)| {
        let DraftAlong::Edge(e) = tile.loops[l][k].along else {
            unreachable!("meetings are of Hermite images, which only edges have")
        };
        let edge = &part.edges[e as usize];
        let point = match t {
            _ if t == edge.range.0 => part.vertices[edge.start.index()],
            _ if t == edge.range.1 => part.vertices[edge.end.index()],
            _ => edge.curve.point(t),
        };
        (e, t, point)
    })
}

/// The common point for both edges that meet with these [`ends`]: a vertex if either ends there. Empty if they are
/// further apart in space than `near`.
pub(super) fn joint(part: &Part, [a, b]: [(u32, f64, DVec3); 2], near: f64) -> Vec<(u32, f64, DVec3)> {
    if a.2.distance(b.2) > near {
        return Vec::new();
    }
    let (from, to) = part.edges[b.0 as usize].range;
    let point = if b.1 == from || b.1 == to { b.2 } else { a.2 };
    vec![(a.0, a.1, point), (b.0, b.1, point)]
}
