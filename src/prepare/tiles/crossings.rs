//! Tiles of a face -> the parameters without which coarse polylines would cross, and where loops meet, with points in
//! space that both edges contain.

use super::critical::critical;
use super::draft::{DraftAlong, DraftTile};
use super::meeting::{Meeting, WorkLeft, fold, touching};
use super::traced::Traced;
use crate::model::{AxisMap, FaceTrouble, Part};
use crate::prepare::regions::lobes::LobeCut;
use crate::prepare::regions::mend::Tangle;
use crate::prepare::report::Finding;
use crate::prepare::uv::projector::Projector;
use crate::prepare::uv::uv_curve::SAME_SHARE;
use glam::{DVec2, DVec3};

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
fn ends(part: &Part, tile: &DraftTile, m: &Meeting) -> [(u32, f64, DVec3); 2] {
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
fn joint(part: &Part, [a, b]: [(u32, f64, DVec3); 2], near: f64) -> Vec<(u32, f64, DVec3)> {
    if a.2.distance(b.2) > near {
        return Vec::new();
    }
    let (from, to) = part.edges[b.0 as usize].range;
    let point = if b.1 == from || b.1 == to { b.2 } else { a.2 };
    vec![(a.0, a.1, point), (b.0, b.1, point)]
}

/// Maximum meetings of a face's loops times the points of the tiles that they are in: the time that judging them takes.
/// Real faces need a hundredth.
const FOLD_WORK: usize = 1 << 24;

/// How the loops of a face's tiles meet.
#[derive(Default)]
pub(super) struct Crossings {
    /// Parameters of B-rep edges at which every polyline has a point: critical ones, and those where two edges meet.
    pub(super) breaks: Vec<(u32, f64)>,
    /// The parameters where two edges meet, each with the common point.
    pub(super) joints: Vec<(u32, f64, DVec3)>,
    /// The pairs of B-rep edges that meet. Empty if a tile has too many meetings to list.
    pub(super) tangles: Vec<Tangle>,
    /// Numbers of critical parameters and of meetings.
    pub(super) critical: usize,
    pub(super) meetings: usize,
    /// The first place where a boundary crosses or overlaps itself.
    pub(super) crossed: Option<Finding>,
    /// The first tile with too many meetings to list.
    pub(super) scribble: Option<Finding>,
}

impl Crossings {
    /// Marks tiles whose loops meet as entangled. `exact` states that the loops come from free trims, which are
    /// separated already.
    pub(super) fn of(traced: &Traced<'_>, tiles: &mut [DraftTile], exact: bool, maps: &[AxisMap; 2]) -> Self {
        let mut out = Self::default();
        let mut work = WorkLeft(FOLD_WORK);
        for tile in tiles {
            let before = out.breaks.len();
            let (meetings, all) = critical(tile, exact, &mut out.breaks);
            out.critical += out.breaks.len() - before;
            out.meetings += meetings.len();
            if exact && all {
                // Free trims are separated already, touching ones too.
                continue;
            }
            for m in &meetings {
                let ends = ends(traced.part, tile, m);
                let places = ends.map(|(edge, t, _)| (edge, t));
                out.tangles.push(places);
                out.breaks.extend(places);
                out.joints.extend(joint(traced.part, ends, 10.0 * traced.projector.tolerance));
            }
            let folded = if tile.entangled { meetings.first().copied() } else { fold(tile, &meetings, &mut work) };
            // Loops that only touch may also wind twice.
            let folded = folded.or_else(|| fold(tile, &touching(tile), &mut work));
            let middle = || {
                let middle = 0.5 * (tile.min + tile.max);
                traced.projector.point(DVec2::new(maps[0].to_natural(middle.x), maps[1].to_natural(middle.y)))
            };
            if tile.entangled || folded.is_some() {
                let place = folded.map_or_else(middle, |m| ends(traced.part, tile, &m)[0].2);
                out.crossed.get_or_insert(Finding::new(Some(place), FaceTrouble::Crosses));
            }
            if !all && out.scribble.is_none() {
                out.scribble = Some(Finding::new(Some(middle()), FaceTrouble::Scribble));
            }
            tile.entangled |= folded.is_some() || !meetings.is_empty() || !all;
        }
        if out.scribble.is_some() {
            // Without all meetings the images cannot be moved apart.
            out.tangles.clear();
        }
        out
    }
}
