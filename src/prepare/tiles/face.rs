//! One face of a model to patches, tiles and borders: everything that needs no other face.

use super::arrangement::{Arrangement, arrange};
use super::crossings::{Crossings, common_point};
use super::draft::{FaceDraft, borders, tiles};
use super::extent::Patched;
use super::grid::{Grid, coarse_grids, grid_for};
use super::traced::{self, Traced};
use crate::model::{Coedge, Face, FaceError, FaceTrouble, Part, Surface};
use crate::prepare::regions::mend::{MAX_TANGLES, Tangle, Way};
use crate::prepare::regions::unroll::region;
use crate::prepare::regions::{lobes, mend};
use crate::prepare::report::{Finding, Room};
use crate::prepare::trims::free_edges::FreeFace;
use crate::prepare::uv::projector::Projector;
use crate::prepare::uv::uv_loop::{Region, UvLoop};
use crate::prepare::wires::boundary::{self, Chain};
use crate::prepare::wires::heal::without_seams;
use glam::DVec3;

/// Share of a face's size by which its edges may miss its surface without a diagnostic. Files print six to fifteen
/// digits, and intersection curves are good to 1e-5 of a face; more is a fault of the file, or of the projection.
const GAP_SHARE: f64 = 1e-4;

/// Share of a face's size by which its edges may miss its surface, or a loop its start, before the face counts as
/// repaired.
const FAR_SHARE: f64 = 0.05;

/// Share of a face's size by which the image of an edge may be moved for it not to cross another.
const MEND_SHARE: f64 = 1e-3;

/// Maximum number of common points of crossing edges, two per crossing. A boundary with more has no meaningful lobes.
const MAX_JOINTS: usize = 256;

/// Prepares a face by itself. `free` is the outcome of its free trims, if it has any. `size` is the diagonal of the
/// part's box. `shared` marks edges that have other faces. `room`: memory that it may take.
///
/// If the boundary crosses itself, tries in turn: without the seams that the file states, which other loops may cross;
/// with the images of edges moved apart where they cross; with lobes that run backwards reversed.
pub(crate) fn draft(
    part: &Part,
    face: &Face,
    free: Option<&Result<FreeFace, FaceError>>,
    size: f64,
    shared: &[bool],
    room: &Room,
) -> Result<FaceDraft, FaceError> {
    room.ask(boundary_memory(part, face))?;
    let traced = Traced::of(part, face, free, size, room);
    let stated = traced.as_ref().map_err(Clone::clone).and_then(|traced| draft_traced(traced, Loops::Nested));
    if free.is_some() {
        // Free trims are separated already.
        return stated;
    }
    if stated.as_ref().map_or_else(FaceError::may_be_seams, |draft| draft.crosses) {
        if let Some(loops) = without_seams(part, face) {
            // Its seams count towards its size, if nothing is left without them.
            let size = traced::face_extent(part, face).unwrap_or(size);
            let face = Face { loops, ..face.clone() };
            let again = Traced::of(part, &face, None, size, room);
            let again = again.and_then(|traced| draft_traced(&traced, Loops::Nested));
            if let Some(mut draft) = again.ok().filter(|draft| !draft.crosses) {
                draft.notes.push(FaceTrouble::BothWays);
                return Ok(draft);
            }
        }
        if let (Ok(traced), Ok(stated)) = (&traced, &stated) {
            if let Some(draft) = mended(traced, &stated.tangles) {
                return Ok(draft);
            }
            // The faces beyond shared edges would not reverse the lobe.
            let may_turn = stated.joints.len() <= MAX_JOINTS && traced.loops.iter().any(|l| !lobes::stays(l, shared));
            if let Some(draft) = may_turn.then(|| draft_traced(traced, Loops::ByLobes(shared))).and_then(Result::ok) {
                return Ok(draft);
            }
        }
    }
    stated
}

/// Memory that a face's boundary may take for a moment, bytes: images of its edges, arcs of them, pairs of arcs.
fn boundary_memory(part: &Part, face: &Face) -> usize {
    const PER_USE: usize = 2 << 10;
    const PER_POINT: usize = 6 << 10;
    let points = |c: &Coedge| part.edges.get(c.edge.index()).map_or(0, |edge| edge.curve.points.len());
    face.wires().flatten().map(|c| PER_USE + PER_POINT * points(c)).fold(0, usize::saturating_add)
}

/// Prepares a face by itself with loops that run as stated, however they are nested.
pub(crate) fn draft_as_stated(part: &Part, face: &Face, size: f64) -> Result<FaceDraft, FaceError> {
    draft_traced(&Traced::of(part, face, None, size, &Room::new(u64::MAX))?, Loops::AsStated)
}

/// Which way loops run.
enum Loops<'a> {
    /// Outlines counter-clockwise, holes clockwise, by what lies inside what.
    Nested,
    /// Like `Nested`, with the images of edges moved apart, by at most so many mm.
    Moved(Vec<UvLoop>, f64),
    /// Like `Nested`, with lobes that run backwards reversed in loops none of whose edges is marked: marked edges have
    /// other faces. Fails if there is no such lobe.
    ByLobes(&'a [bool]),
    /// As stated.
    AsStated,
}

/// Drafts the face with the images of its edges moved apart around `tangles`, where they meet. Each attempt moves them
/// around all meetings found so far, over a longer stretch. `None` if they still meet.
fn mended(traced: &Traced<'_>, stated: &[Tangle]) -> Option<FaceDraft> {
    let mut tangles = stated.to_vec();
    for (way, reach) in [(Way::Straight, 4.0), (Way::Beside, 2.0), (Way::Straight, 16.0), (Way::Beside, 8.0)] {
        if tangles.is_empty() || tangles.len() > MAX_TANGLES {
            return None;
        }
        let (mends, most) = (mend::about(traced.part, &tangles, way, reach)?, MEND_SHARE * traced.extent);
        let mut loops = traced.loops.clone();
        let by = loops.iter_mut().map(|l| mend::mend(l, &mends, most, &traced.projector)).fold(0.0, f64::max);
        if by == 0.0 {
            // The images meet where they met.
            tangles.extend(stated);
            continue;
        }
        let draft = draft_traced(traced, Loops::Moved(loops, by)).ok()?;
        if !draft.crosses {
            return Some(draft);
        }
        tangles.extend(draft.tangles);
    }
    None
}

/// What a face keeps of its surface's parameters, and what has become of its loops.
struct FaceOutline {
    region: Region,
    /// Largest distance between edges and surface.
    gap: f64,
    chain: Chain,
    /// Parameters at which every polyline of a B-rep edge has a point.
    breaks: Vec<(u32, f64)>,
    joints: Vec<(u32, f64, DVec3)>,
    /// Edges of loops of which lobes were turned.
    lobed: Vec<u32>,
    notes: Vec<FaceTrouble>,
    repairs: Vec<Finding>,
}

impl FaceOutline {
    fn of(traced: &Traced<'_>, way: Loops<'_>) -> Result<Self, FaceError> {
        let is_far = |told: &FaceTrouble| match told {
            FaceTrouble::LoopMissesStart { gap_mm } => *gap_mm > FAR_SHARE * traced.extent,
            _ => false,
        };
        let (far, mut notes): (Vec<_>, Vec<_>) = traced.notes.iter().cloned().partition(is_far);
        let mut repairs: Vec<Finding> = far.into_iter().map(|told| Finding::new(None, told)).collect();
        // Edges that run through one pole have its point in common.
        let joints: Vec<(u32, f64, DVec3)> = traced
            .passages
            .iter()
            .flat_map(|(&edge, stops)| stops.iter().map(move |&(t, point)| (edge, t, point)))
            .collect();
        let (breaks, lobed) = (joints.iter().map(|&(edge, t, _)| (edge, t)).collect(), Vec::new());
        let turn = !matches!(way, Loops::AsStated);
        let shared = if let Loops::ByLobes(shared) = way { Some(shared) } else { None };
        let mut out = match traced.free {
            Some(free) => {
                let free = free.as_ref().map_err(Clone::clone)?;
                let chain = boundary::of_boundary(&boundary::boundary(traced.face, Some(free)));
                notes.extend_from_slice(&free.notes);
                repairs.extend(free.repairs.iter().cloned());
                let (region, gap) = (free.region.clone(), free.gap);
                Self { region, gap, chain, breaks, joints, lobed, notes, repairs }
            }
            None => {
                let loops = match way {
                    Loops::Moved(loops, by_mm) => {
                        notes.push(FaceTrouble::ImagesMoved { by_mm });
                        loops
                    }
                    _ => traced.loops.clone(),
                };
                let region = region(loops, traced.named_pole, &traced.projector, turn)?;
                let chain = boundary::of_region(traced.part, &region.loops);
                Self { region, gap: traced.gap, chain, breaks, joints, lobed, notes, repairs }
            }
        };
        if let Some(shared) = shared {
            out.turn_lobes(traced, shared)?;
        }
        if let Some((axis, at)) = out.region.unbounded {
            let place = out.region.loops.first().map(|l| {
                let mut uv = l.pieces[0].start();
                uv[axis] = at;
                traced.projector.point(uv)
            });
            out.repairs.push(Finding::new(place, FaceTrouble::EndsWithSurface { axis, at }));
        }
        Ok(out)
    }

    fn turn_lobes(&mut self, traced: &Traced<'_>, shared: &[bool]) -> Result<(), FaceError> {
        let projector = &traced.projector;
        self.lobed.extend(self.chain.iter().map(|c| c.0).filter(|&edge| !shared[edge as usize]));
        let turned = lobes::turn(&mut self.region, projector, shared).ok_or(FaceError::NoLobes)?;
        self.breaks.extend(turned.cuts.iter().flat_map(|cut| cut.passes).flatten());
        for cut in &turned.cuts {
            let point = common_point(traced.part, cut, projector).ok_or(FaceError::NoLobes)?;
            self.joints.extend(cut.passes.into_iter().flatten().map(|(edge, t)| (edge, t, point)));
        }
        let place = turned.cuts.first().map(|cut| projector.point(cut.uv));
        let what = FaceTrouble::LobesTurned { lobes: turned.lobes, area_mm2: turned.area };
        self.repairs.push(Finding::new(place, what));
        Ok(())
    }
}

fn draft_traced(traced: &Traced<'_>, way: Loops<'_>) -> Result<FaceDraft, FaceError> {
    let Traced { face, projector, .. } = traced;
    let mut outline = FaceOutline::of(traced, way)?;
    let (grid, arranged) = cut(&outline.region, &face.surface, projector, &mut outline.notes)?;
    // The images are in the tiles now: where a boundary runs along itself thousands of times, copies count.
    drop(std::mem::take(&mut outline.region.loops));
    let surface = Patched::over(&face.surface, &arranged.tiles, traced.room)?;
    let borders = borders(traced, &surface, &grid, &arranged);
    outline.breaks.extend(arranged.crossings.iter().filter_map(|c| Some((c.along.edge()?, c.t))));
    let mut tiles = tiles(arranged, &surface.maps);
    // Not where free trims end on the edges of other faces, which are as good as those are.
    let exact = traced.free.is_some() && outline.gap == 0.0;
    let found = Crossings::of(traced, &mut tiles, exact, &surface.maps);
    outline.breaks.extend(found.breaks);
    outline.joints.extend(found.joints);
    let crosses = found.crossed.is_some();
    outline.repairs.extend(found.crossed.into_iter().chain(found.scribble));
    let off = FaceTrouble::EdgesOffSurface { gap_mm: outline.gap };
    if outline.gap > FAR_SHARE * traced.extent {
        outline.repairs.push(Finding::new(None, off));
    } else if outline.gap > GAP_SHARE * traced.extent {
        outline.notes.push(off);
    }
    let [critical, meetings] = [found.critical, found.meetings].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
    let FaceOutline { region, gap, chain, breaks, joints, lobed, notes, repairs } = outline;
    Ok(FaceDraft {
        surface,
        gap,
        critical,
        meetings,
        tiles,
        borders,
        chain,
        breaks,
        joints,
        notes,
        repairs,
        crosses,
        filled: false,
        lobed,
        ends_with_surface: region.unbounded.is_some(),
        tangles: found.tangles,
    })
}

/// Cuts a region along the first grid that works: the one wanted, or one of those with as few lines as can be.
fn cut(
    region: &Region,
    surface: &Surface,
    projector: &Projector<'_>,
    notes: &mut Vec<FaceTrouble>,
) -> Result<(Grid, Arrangement), FaceError> {
    let wanted = grid_for(region, surface);
    let refused = match arrange(region, &wanted, projector) {
        Ok(arranged) => return Ok((wanted, arranged)),
        Err(refused) => refused,
    };
    for grid in coarse_grids(region, surface) {
        if let Ok(arranged) = arrange(region, &grid, projector) {
            notes.push(FaceTrouble::FewerTiles { at: refused.at });
            return Ok((grid, arranged));
        }
    }
    Err(FaceError::Tangled { at: refused.at, place: projector.point(refused.at) })
}
