//! Tiles of a face -> the parameters without which coarse polylines would cross, and where loops meet.

use super::critical::critical;
use super::draft::DraftTile;
use super::joints::{ends, joint};
use super::meeting::{WorkLeft, fold, touching};
use super::traced::Traced;
use crate::model::{AxisMap, FaceTrouble};
use crate::prepare::regions::mend::Tangle;
use crate::prepare::report::finding::Finding;
use glam::{DVec2, DVec3};

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
