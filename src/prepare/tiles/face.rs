//! One face of a model to patches, tiles and borders: everything that needs no other face.

use super::arrangement::{Arranged, Border, GridNode, LoopStretch, arrange};
use super::critical::critical;
use super::cuts::{coarse_grids, grid_for};
use super::draft::{DraftAlong, DraftBorder, DraftEnd, DraftShape, DraftTile, DraftUse, FaceDraft};
use super::grid::{Grid, LineCrossing};
use super::joints::{Joiner, common_point};
use super::meeting::{fold, touching};
use crate::model::{AxisMap, Coedge, Face, FaceError, FaceTrouble, Loop, NurbsSurface, Part, RegionError, Surface};
use crate::prepare::regions::mend::{MAX_TANGLES, Mend, Tangle, Way};
use crate::prepare::regions::trace::{Passages, trace_loop};
use crate::prepare::regions::unroll::region;
use crate::prepare::regions::{boundary, lobes, mend};
use crate::prepare::report::told::Told;
use crate::prepare::surface::arc_bounds;
use crate::prepare::surface::decompose::{BezierPatches, BezierSpline3};
use crate::prepare::surface::tables::SurfaceBounds;
use crate::prepare::trims::free_faces::FreeFace;
use crate::prepare::uv::pcurve::Projector;
use crate::prepare::uv::region::Region;
use crate::prepare::uv::uv_curve::{UvCurve, UvSample};
use crate::prepare::uv::uv_loop::{Along, UvLoop};
use crate::prepare::wires::order::{Given, without_seams};
use glam::{DVec2, DVec3};

/// A point of a face: its first vertex, or the middle of a surface kept whole.
pub(crate) fn somewhere(part: &Part, face: &Face) -> Option<DVec3> {
    let vertex = boundary_points(part, face).find(|p| p.is_finite());
    vertex.or_else(|| {
        let middle = face.surface.natural_domain().map(|(a, b)| 0.5 * (a + b));
        let point = middle.iter().all(|x| x.is_finite()).then(|| face.surface.point(middle[0], middle[1]));
        point.filter(|p| p.is_finite() && !face.lost)
    })
}

/// Share of a face's size by which its edges may miss its surface before that is told. Files print six to fifteen digits,
/// and intersection curves are good to 1e-5 of a face; more is a fault of the file, or of the projection.
const GAP_SHARE: f64 = 1e-4;

/// Share of a face's size by which its edges may miss its surface before the face counts as repaired.
const FAR_SHARE: f64 = 0.05;

/// Share of a face's size by which its edges may miss its surface at all. The image of an edge further away is noise: it
/// bounds nothing, and resolving its crossings can take minutes. Nearer ones bound what they do when seen along the normals.
const LOST_SHARE: f64 = 0.25;

/// Share of a face's size by which the image of an edge may be moved for it not to cross another.
const MEND_SHARE: f64 = 1e-3;

/// Common points of crossing edges, two for each crossing, beyond which a boundary is a scribble that has no lobes to speak of.
const MAX_JOINTS: usize = 256;

/// Prepares a face by itself. `free`: what became of its free trims, if it has any. `size` is the diagonal of the part's box.
/// `shared`: which edges have other faces.
///
/// Where the boundary crosses itself, again without the seams that the file states, which other loops may cross; again with
/// the images of edges apart where they cross; and again with lobes that run backwards turned.
pub(crate) fn draft(
    part: &Part,
    face: &Face,
    free: Option<&Result<FreeFace, FaceError>>,
    size: f64,
    shared: &[bool],
) -> Result<FaceDraft, FaceError> {
    let traced = Traced::of(part, face, free, size);
    let stated = traced.as_ref().map_err(Clone::clone).and_then(|traced| traced.draft(Loops::Nested, &[]));
    if free.is_some() {
        // Free trims were told apart already.
        return stated;
    }
    if stated.as_ref().map_or_else(FaceError::may_be_seams, |draft| draft.crosses) {
        if let Some(loops) = without_seams(part, face) {
            let face = Face { loops, ..face.clone() };
            let again = Traced::of(part, &face, None, size).and_then(|traced| traced.draft(Loops::Nested, &[])).ok();
            if let Some(mut draft) = again.filter(|draft| !draft.crosses) {
                draft.notes.push(FaceTrouble::BothWays);
                return Ok(draft);
            }
        }
        if let (Ok(traced), Ok(stated)) = (&traced, &stated) {
            if let Some(draft) = traced.mended(&stated.tangles) {
                return Ok(draft);
            }
            // The faces beyond shared edges would not know of lobes that are turned.
            let may_turn = stated.joints.len() <= MAX_JOINTS && traced.loops.iter().any(|l| !lobes::stays(l, shared));
            if let Some(draft) = may_turn.then(|| traced.draft(Loops::ByLobes(shared), &[])).and_then(Result::ok) {
                return Ok(draft);
            }
        }
    }
    stated
}

/// Prepares a face by itself whose loops run as they are stated, whatever lies inside what.
pub(crate) fn draft_as_stated(part: &Part, face: &Face, size: f64) -> Result<FaceDraft, FaceError> {
    Traced::of(part, face, None, size)?.draft(Loops::AsStated, &[])
}

/// Which way loops run.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Loops<'a> {
    /// Outlines counter-clockwise, holes clockwise, by what lies inside what.
    Nested,
    /// The same; and lobes of loops that run backwards are turned, where none of the loop's edges is one of these, which have other
    /// faces. Without any there is no face.
    ByLobes(&'a [bool]),
    /// As stated.
    AsStated,
}

/// A face whose loops are followed over its surface: what every way to prepare it starts from.
struct Traced<'a> {
    part: &'a Part,
    face: &'a Face,
    free: Option<&'a Result<FreeFace, FaceError>>,
    projector: Projector<'a>,
    passages: Passages,
    /// Size of the face.
    extent: f64,
    loops: Vec<UvLoop>,
    /// The pole at which the file puts a vertex loop.
    named_pole: Option<usize>,
    /// Largest distance between edges and surface.
    gap: f64,
    notes: Vec<FaceTrouble>,
    repairs: Vec<Told>,
}

impl<'a> Traced<'a> {
    fn of(
        part: &'a Part,
        face: &'a Face,
        free: Option<&'a Result<FreeFace, FaceError>>,
        size: f64,
    ) -> Result<Self, FaceError> {
        if let Some(cause) = &face.refused {
            return Err(FaceError::Refused(cause.clone()));
        }
        // The fields of models are open, and NaN passes every comparison below.
        face.surface.check().map_err(FaceError::Surface)?;
        if !boundary_points(part, face).all(DVec3::is_finite) {
            return Err(RegionError::NotFinite.into());
        }
        let extent = face_extent(part, face).unwrap_or(size);
        let mut projector = Projector::new(&face.surface, 1e-6 * extent);
        let passages = passages(part, face, &projector);
        projector.adopt(boundary_points(part, face));
        if let Some(Ok(free)) = free {
            let edges = free.region.loops.iter().flat_map(|l| &l.pieces).filter_map(|piece| match piece.along {
                Along::Edge(edge) => Some(&part.edges[edge as usize]),
                Along::Pole(_) => None,
            });
            projector.adopt(edges.flat_map(|e| [e.start, e.end]).map(|v| part.vertices[v.index()]));
        }
        projector.adopt(passages.values().flatten().map(|p| p.1));
        let loops = Vec::with_capacity(face.loops.len());
        let (notes, repairs) = (Vec::new(), Vec::new());
        let mut out =
            Self { part, face, free, projector, passages, extent, loops, named_pole: None, gap: 0.0, notes, repairs };
        out.trace()?;
        Ok(out)
    }

    fn trace(&mut self) -> Result<(), FaceError> {
        let part = self.part;
        let mut given = Given::default();
        for l in &self.face.loops {
            match l {
                Loop::Edges(coedges) => {
                    if !given.is_first(coedges) {
                        let place = coedges.first().map(|c| part.vertices[part.edges[c.edge.index()].start.index()]);
                        self.repairs.push(Told::new(place, FaceTrouble::LoopTwice));
                        continue;
                    }
                    let (traced, miss) = trace_loop(part, coedges, &self.projector, &mut self.gap, &self.passages)?;
                    self.loops.push(traced);
                    self.notes.extend(miss.map(|gap_mm| FaceTrouble::LoopMissesStart { gap_mm }));
                }
                Loop::Vertex(v) => self.named_pole = self.projector.pole_at(part.vertices[v.index()]),
            }
        }
        let near = self.gap <= LOST_SHARE * self.extent;
        if !near {
            return Err(FaceError::OffSurface { gap_mm: self.gap, extent_mm: self.extent });
        }
        Ok(())
    }

    /// The face with the images of its edges mended about `tangles`, where they meet; none where they still do then. Each time
    /// about all that were met so far, and farther.
    fn mended(&self, tangles: &[Tangle]) -> Option<FaceDraft> {
        let mut tangles = tangles.to_vec();
        for (way, reach) in [(Way::Straight, 4.0), (Way::Beside, 2.0), (Way::Straight, 16.0), (Way::Beside, 8.0)] {
            if tangles.is_empty() || tangles.len() > MAX_TANGLES {
                return None;
            }
            let mends = mend::about(self.part, &tangles, way, reach)?;
            let draft = self.draft(Loops::Nested, &mends).ok()?;
            if !draft.crosses {
                return Some(draft);
            }
            tangles.extend(draft.tangles);
        }
        None
    }

    fn draft(&self, way: Loops<'_>, mends: &[Mend]) -> Result<FaceDraft, FaceError> {
        draft_traced(self, way, mends)
    }
}

fn draft_traced(traced: &Traced<'_>, way: Loops<'_>, mends: &[Mend]) -> Result<FaceDraft, FaceError> {
    let Traced { part, face, free, projector, passages, extent, named_pole, .. } = traced;
    let (part, face, free, extent) = (*part, *face, *free, *extent);
    let (mut gap, mut notes, mut repairs) = (traced.gap, traced.notes.clone(), traced.repairs.clone());
    let mut breaks: Vec<(u32, f64)> =
        passages.iter().flat_map(|(&edge, stops)| stops.iter().map(move |p| (edge, p.0))).collect();
    let mut loops = if free.is_some() { Vec::new() } else { traced.loops.clone() };
    let moved = loops.iter_mut().map(|l| mend::mend(l, mends, MEND_SHARE * extent, projector)).fold(0.0, f64::max);
    if moved > 0.0 {
        notes.push(FaceTrouble::ImagesMoved { by_mm: moved });
    }
    let mut region = match free {
        Some(free) => {
            let free = free.clone()?;
            gap = free.gap;
            notes.extend(free.notes);
            repairs.extend(free.repairs);
            free.region
        }
        None => region(loops, *named_pole, projector, way != Loops::AsStated)?,
    };
    let chain = match free {
        Some(Ok(free)) => boundary::of_boundary(&boundary::boundary(face, Some(free))),
        _ => boundary::of_region(part, &region.loops),
    };
    let mut joints = Vec::new();
    let mut lobed = Vec::new();
    if let Loops::ByLobes(shared) = way {
        lobed.extend(chain.iter().map(|c| c.0).filter(|&edge| !shared[edge as usize]));
        let turned = lobes::turn(&mut region, projector, shared).ok_or(FaceError::NoLobes)?;
        breaks.extend(turned.cuts.iter().flat_map(|cut| cut.passes).flatten());
        let place = turned.cuts.first().map(|cut| projector.point(cut.uv));
        for cut in &turned.cuts {
            let point = common_point(part, cut, projector).ok_or(FaceError::NoLobes)?;
            joints.extend(cut.passes.into_iter().flatten().map(|(edge, t)| (edge, t, point)));
        }
        let what = FaceTrouble::LobesTurned { lobes: turned.lobes, area_mm2: turned.area };
        repairs.push(Told::new(place, what));
    }
    if let Some((across, at)) = region.unbounded {
        let place = region.loops.first().map(|l| {
            let mut uv = l.pieces[0].start();
            uv[across] = at;
            projector.point(uv)
        });
        repairs.push(Told::new(place, FaceTrouble::EndsWithSurface { axis: across, at }));
    }
    let (grid, arranged) = cut(&region, &face.surface, projector, &mut notes)?;
    let mut low = DVec2::INFINITY;
    let mut high = DVec2::NEG_INFINITY;
    for tile in &arranged.tiles {
        low = low.min(tile.min);
        high = high.max(tile.max);
    }
    for axis in 0..2 {
        let extent = high[axis] - low[axis];
        if !(extent > 0.0 && extent.is_finite()) {
            return Err(FaceError::Thin { axis, extent });
        }
    }
    let (nurbs, maps) = face.surface.to_nurbs((low.x, high.x), (low.y, high.y));
    let box_u = (maps[0].to_nurbs(low.x), maps[0].to_nurbs(high.x));
    let box_v = (maps[1].to_nurbs(low.y), maps[1].to_nurbs(high.y));
    let patches = BezierPatches::over(&nurbs, box_u, box_v);
    let bounds = arc_bounds::analytic(&face.surface, &maps, &patches).unwrap_or_else(|| SurfaceBounds::new(&patches));
    let speed = bounds.cells.iter().fold(DVec2::ZERO, |m, b| m.max(DVec2::new(b.u, b.v)));
    let reach = speed * (high - low);
    let coordinates =
        patches.control.iter().fold(0.0_f64, |most, c| most.max((c.truncate() / c.w).abs().max_element()));
    if !(reach.is_finite() && coordinates.is_finite()) {
        return Err(FaceError::TooLarge { coordinates_mm: coordinates });
    }
    // By its own size: what else the part contains is not its fault.
    if reach.min_element() <= 1e-12 * reach.max_element() || is_curve(&patches) {
        return Err(FaceError::NoArea { size_mm: reach.max_element() });
    }
    if reach.min_element() <= f64::EPSILON * coordinates {
        return Err(FaceError::Unresolved { size_mm: reach.min_element(), coordinates_mm: coordinates });
    }
    let creases = [0, 1].map(|axis| creases(&nurbs, &patches, axis));
    let to_patch = |p: DVec2| DVec2::new(maps[0].to_nurbs(p.x), maps[1].to_nurbs(p.y));
    let maker = BorderMaker {
        arranged: &arranged,
        grid: &grid,
        projector,
        patches: &patches,
        maps: &maps,
        creases: &creases,
        passages,
    };
    let borders = arranged.borders.iter().map(|b| maker.make(b)).collect();
    let mut tiles: Vec<DraftTile> = arranged
        .tiles
        .iter()
        .map(|t| DraftTile {
            min: to_patch(t.min),
            max: to_patch(t.max),
            loops: t.loops.iter().map(|l| l.iter().map(|s| stretch(s, &arranged.borders, &maps)).collect()).collect(),
            entangled: t.layered,
        })
        .collect();
    breaks.extend(arranged.crossings.iter().filter_map(|c| match c.along {
        Along::Edge(e) => Some((e, c.t)),
        Along::Pole(_) => None,
    }));
    // Not where free trims end on the edges of other faces, which are as good as those are.
    let exact = free.is_some() && gap == 0.0;
    let mut crossed = None;
    let mut scribble = None;
    let mut tangles: Vec<Tangle> = Vec::new();
    let (mut critical_count, mut meetings_count) = (0, 0);
    for tile in &mut tiles {
        let others = breaks.len();
        let (meetings, all) = critical(tile, exact, &mut breaks);
        critical_count += breaks.len() - others;
        meetings_count += meetings.len();
        if exact && all {
            // Free trims were told apart already, touching ones too.
            continue;
        }
        let join = Joiner { part, tile, near: 10.0 * projector.tolerance };
        for m in &meetings {
            tangles.push(join.ends(m).map(|(edge, t, _)| (edge, t)));
            breaks.extend(join.ends(m).map(|(edge, t, _)| (edge, t)));
            joints.extend(join.joint(m));
        }
        let folded = if tile.entangled { meetings.first().copied() } else { fold(tile, &meetings) };
        // Loops that only touch may wind twice as well.
        let folded = folded.or_else(|| fold(tile, &touching(tile)));
        let place = folded.map(|m| join.ends(&m)[0].2);
        if tile.entangled || folded.is_some() {
            let middle = || projector.point(arranged_middle(tile, &maps));
            let place = Some(place.unwrap_or_else(middle));
            crossed.get_or_insert(Told::new(place, FaceTrouble::Crosses));
        }
        if !all && scribble.is_none() {
            let place = Some(projector.point(arranged_middle(tile, &maps)));
            scribble = Some(Told::new(place, FaceTrouble::Scribble));
        }
        tile.entangled |= folded.is_some() || !meetings.is_empty() || !all;
    }
    let crosses = crossed.is_some();
    if scribble.is_some() {
        // What cannot be told cannot be mended.
        tangles.clear();
    }
    tangles.retain(|tangle| tangle.iter().all(|side| (side.0 as usize) < part.edges.len()));
    repairs.extend(crossed.into_iter().chain(scribble));
    if gap > GAP_SHARE * extent {
        let off = FaceTrouble::EdgesOffSurface { gap_mm: gap };
        if gap > FAR_SHARE * extent {
            repairs.push(Told::new(None, off));
        } else {
            notes.push(off);
        }
    }
    let [critical, meetings] = [critical_count, meetings_count].map(|count| u32::try_from(count).unwrap_or(u32::MAX));
    Ok(FaceDraft {
        patches,
        bounds,
        maps,
        creases,
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
        tangles,
    })
}

/// Whether both derivatives point the same way everywhere that is looked at: then the surface runs along one curve.
fn is_curve(patches: &BezierPatches) -> bool {
    /// Places per piece and direction. One that has area ends the search, so only surfaces without cost more than one.
    const PLACES: usize = 5;
    /// Sine of an angle that is rounding.
    const PARALLEL: f64 = 1e-9;
    let places = |breaks: &[f64]| -> Vec<f64> {
        let share = |k: usize| (k as f64 + 0.5) / PLACES as f64;
        breaks.windows(2).flat_map(|w| (0..PLACES).map(move |k| w[0] + (w[1] - w[0]) * share(k))).collect()
    };
    let vs = places(&patches.breaks_v);
    places(&patches.breaks_u).into_iter().flat_map(|u| vs.iter().map(move |&v| (u, v))).all(|(u, v)| {
        let d = patches.derivatives(u, v);
        d.du.cross(d.dv).length() <= PARALLEL * d.du.length() * d.dv.length()
    })
}

/// Cuts a region along the first grid that works: the one wanted, or one of those with as few lines as can be.
fn cut(
    region: &Region,
    surface: &Surface,
    projector: &Projector<'_>,
    notes: &mut Vec<FaceTrouble>,
) -> Result<(Grid, Arranged), FaceError> {
    let wanted = grid_for(region, surface);
    let refused = match arrange(region, &wanted, projector) {
        Ok(arranged) => return Ok((wanted, arranged)),
        Err(refused) => refused,
    };
    for grid in coarse_grids(region) {
        if let Ok(arranged) = arrange(region, &grid, projector) {
            notes.push(FaceTrouble::FewerTiles { at: refused.at });
            return Ok((grid, arranged));
        }
    }
    Err(FaceError::Tangled { at: refused.at, place: projector.point(refused.at) })
}

/// Middle of a tile in natural parameters.
fn arranged_middle(tile: &DraftTile, maps: &[AxisMap; 2]) -> DVec2 {
    let middle = 0.5 * (tile.min + tile.max);
    DVec2::new(maps[0].to_natural(middle.x), maps[1].to_natural(middle.y))
}

/// Parameters where the tangent across a knot of full multiplicity breaks.
fn creases(nurbs: &NurbsSurface, patches: &BezierPatches, axis: usize) -> Vec<f64> {
    /// Radians. Arcs of analytic surfaces meet within 1e-9; files write spline knots with 5 to 15 digits.
    const BREAK: f64 = 1e-3;
    /// Share of the longest tangent along a knot below which one is rounding: on a pole it has no direction.
    const NO_TANGENT: f64 = 1e-9;
    let (knots, degree, breaks, across) = if axis == 0 {
        (&nurbs.knots_u, nurbs.degree_u, &patches.breaks_u, &patches.breaks_v)
    } else {
        (&nurbs.knots_v, nurbs.degree_v, &patches.breaks_v, &patches.breaks_u)
    };
    let tangent = |x: f64, y: f64| {
        let d = if axis == 0 { patches.derivatives(x, y) } else { patches.derivatives(y, x) };
        if axis == 0 { d.du } else { d.dv }
    };
    // A crease may be as short as one piece: three places of each, and the end.
    let places = across.windows(2).flat_map(|w| [0.0, 1.0, 2.0].map(|third| w[0] + (w[1] - w[0]) * third / 3.0));
    let places: Vec<f64> = places.chain(across.last().copied()).collect();
    let is_crease = |k: usize| {
        let step = 1e-6 * (breaks[k] - breaks[k - 1]).min(breaks[k + 1] - breaks[k]);
        let sides: Vec<[DVec3; 2]> =
            places.iter().map(|&y| [-step, step].map(|step| tangent(breaks[k] + step, y))).collect();
        let longest = sides.as_flattened().iter().map(|t| t.length()).fold(0.0, f64::max);
        let has_tangent = |t: &DVec3| t.length() > NO_TANGENT * longest;
        sides.iter().any(|[a, b]| has_tangent(a) && has_tangent(b) && a.angle_between(*b) > BREAK)
    };
    (1..breaks.len() - 1)
        .filter(|&k| knots.iter().filter(|&&x| (x - breaks[k]).abs() <= 1e-12 * (1.0 + x.abs())).count() >= degree)
        .filter(|&k| is_crease(k))
        .map(|k| breaks[k])
        .collect()
}

/// The B-rep vertices on a face's boundary.
fn boundary_points<'a>(part: &'a Part, face: &'a Face) -> impl Iterator<Item = DVec3> + 'a {
    face.loops.iter().flat_map(move |l| {
        let (coedges, single): (&[Coedge], _) = match l {
            Loop::Edges(coedges) => (coedges, None),
            Loop::Vertex(v) => (&[], Some(*v)),
        };
        let ends = |c: &Coedge| part.edges.get(c.edge.index()).map(|e| [e.start, e.end]);
        let vertices = coedges.iter().filter_map(ends).flatten().chain(single);
        vertices.filter_map(|v| part.vertices.get(v.index()).copied())
    })
}

/// Where edges of a face run through poles.
fn passages(part: &Part, face: &Face, projector: &Projector<'_>) -> Passages {
    let mut out = Passages::new();
    if projector.poles.is_empty() {
        return out;
    }
    for l in &face.loops {
        let Loop::Edges(coedges) = l else { continue };
        for c in coedges {
            let edge = &part.edges[c.edge.index()];
            let stops = projector.pole_passages(edge);
            if !stops.is_empty() {
                let curve = BezierSpline3::new(&edge.curve, edge.range);
                out.insert(c.edge.0, stops.into_iter().map(|t| (t, curve.point(t))).collect());
            }
        }
    }
    out
}

/// Diagonal of the box of the face's edges; none for a face without edges.
fn face_extent(part: &Part, face: &Face) -> Option<f64> {
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    for l in &face.loops {
        if let Loop::Edges(coedges) = l {
            for p in coedges.iter().flat_map(|c| &part.edges[c.edge.index()].curve.points) {
                low = low.min(*p);
                high = high.max(*p);
            }
        }
    }
    let d = (high - low).length();
    (d.is_finite() && d > 0.0).then_some(d)
}

fn stretch(s: &LoopStretch, borders: &[Border], maps: &[AxisMap; 2]) -> DraftUse {
    match s {
        LoopStretch::Edge { edge, from, to, samples } => {
            // It ends on the cuts that end it. Between samples the images of natural and of NURBS parameters differ by what
            // both may be off; what lies that near to a cut (the break of a neighbour's cut) would be beyond it.
            let (low, high, last) = (from.min(*to), from.max(*to), samples.len() - 1);
            let ends = |k: usize| match k {
                0 if samples[0].t < low => UvSample::at(&samples[0], &samples[1], low),
                _ if k == last && samples[last].t > high => UvSample::at(&samples[last - 1], &samples[last], high),
                _ => samples[k],
            };
            let samples: Box<[UvSample]> = (0..=last)
                .map(ends)
                .map(|s| UvSample {
                    t: s.t,
                    uv: DVec2::new(maps[0].to_nurbs(s.uv.x), maps[1].to_nurbs(s.uv.y)),
                    d: DVec2::new(s.d.x * maps[0].rate(s.uv.x), s.d.y * maps[1].rate(s.uv.y)),
                })
                .collect();
            DraftUse { along: DraftAlong::Edge(*edge), from: *from, to: *to, uv: UvCurve::Hermite(samples) }
        }
        LoopStretch::Border { border, reversed, at } => {
            let b = &borders[*border];
            let run = &maps[1 - b.axis];
            let (lo, hi) = (run.to_nurbs(b.range.0), run.to_nurbs(b.range.1));
            let (from, to) = if *reversed { (hi, lo) } else { (lo, hi) };
            let uv = UvCurve::Iso { axis: u8::from(b.axis == 1), at: maps[b.axis].to_nurbs(*at) };
            #[allow(clippy::cast_possible_truncation, reason = "a face has far fewer borders")]
            DraftUse { along: DraftAlong::Border(*border as u32), from, to, uv }
        }
    }
}

/// What a face's borders are made from.
struct BorderMaker<'a> {
    arranged: &'a Arranged,
    grid: &'a Grid,
    projector: &'a Projector<'a>,
    patches: &'a BezierPatches,
    maps: &'a [AxisMap; 2],
    creases: &'a [Vec<f64>; 2],
    passages: &'a Passages,
}

impl BorderMaker<'_> {
    fn make(&self, b: &Border) -> DraftBorder {
        let run = &self.maps[1 - b.axis];
        let range = (run.to_nurbs(b.range.0), run.to_nurbs(b.range.1));
        let at = self.maps[b.axis].to_nurbs(b.at);
        let pole_end = |pole: usize| {
            let point = self.projector.poles[pole].point;
            // Where an edge runs through the pole, its tessellant there is the pole for all faces.
            let passing = self.passages.iter().find_map(|(&edge, stops)| {
                stops.iter().find(|stop| stop.1 == point).map(|stop| DraftEnd::OnEdge(edge, stop.0))
            });
            passing.unwrap_or(DraftEnd::Point(point))
        };
        let shape = match b.pole {
            Some(pole) => DraftShape::Pole(pole_end(pole)),
            None => DraftShape::Curve(self.patches.iso_curve(b.axis, at, range)),
        };
        let ends = b.nodes.map(|node| match node {
            GridNode::Pole(pole) => pole_end(pole),
            GridNode::LineCrossing(k) => match self.arranged.crossings[k] {
                LineCrossing { along: Along::Edge(e), t, .. } => DraftEnd::OnEdge(e, t),
                LineCrossing { along: Along::Pole(pole), .. } => pole_end(pole),
            },
            GridNode::Corner(i, j) => {
                let (pole, crossing) =
                    (self.arranged.pole_corners.get(&(i, j)), self.arranged.crossed_corners.get(&(i, j)));
                match (pole, crossing.map(|&k| &self.arranged.crossings[k])) {
                    (Some(&pole), _) | (_, Some(&LineCrossing { along: Along::Pole(pole), .. })) => pole_end(pole),
                    (_, Some(&LineCrossing { along: Along::Edge(e), t, .. })) => DraftEnd::OnEdge(e, t),
                    _ => {
                        let (u, v) = (
                            self.maps[0].to_nurbs(self.grid.lines[0][i]),
                            self.maps[1].to_nurbs(self.grid.lines[1][j]),
                        );
                        DraftEnd::Point(self.patches.point(u, v))
                    }
                }
            }
        });
        let creases = self.creases[1 - b.axis].iter().copied().filter(|&t| t > range.0 && t < range.1).collect();
        DraftBorder { shape, range, ends, creases }
    }
}
