//! Face drafts of a part -> one table of edges: breaks from all faces, borders numbered, loops of tiles closed.

use super::closing::{Closure, Wanted, close};
use super::prepared::{
    Break, EDGES_PER_BOX, EdgeShape, EdgeUse, PreparedEdge, PreparedFace, PreparedPart, Tile, TileUse,
};
use super::sample_images;
use crate::control::Call;
use crate::model::{CurveKind, Edge, FaceError, FaceId, Part, RowId, SurfaceKind, TileId};
use crate::prepare::report::guarded;
use crate::prepare::surface::decompose::BezierSpline3;
use crate::prepare::surface::tables::{BoundingBox, CurveBounds};
use crate::prepare::tiles::draft::{DraftAlong, DraftBorder, DraftEnd, DraftShape, DraftUse, FaceDraft};
use crate::prepare::tiles::extent::Patched;
use crate::prepare::uv::uv_curve::SAME_SHARE;
use crate::prepare::wires::boundary::Chain;
use glam::{DVec2, DVec3};

/// Edges that a thread takes at a time: a few microseconds each.
const SHARE: usize = 16;

/// How the loops of a face were closed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ClosingOutcome {
    /// By adding joints or loops.
    Closure(Closure),
    /// By filling the stated loops in space, for this reason.
    Filled(Unclosed),
    /// Not at all, for this reason: the face is lost.
    Lost(Unclosed),
}

/// Why the loops of a face's tiles could not be closed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Unclosed {
    /// There is no tile, or a point is not finite.
    Loops,
    /// A panic, with its message.
    Panic(FaceError),
}

/// Assembles the drafts of a part's faces, `None` for faces that could not be used.
///
/// `finely_cut`: index of the first edge whose curve is cut much finer than it bends. `reversed`: which faces are
/// flipped. `refill`: makes another draft, of the given chain, for a face whose loops cannot be closed, or that panics.
/// Faces whose loops had to be closed are appended to `told`. Stops early if the call is cancelled.
pub(crate) fn assemble(
    call: Call<'_>,
    part: &Part,
    finely_cut: usize,
    drafts: Vec<Option<FaceDraft>>,
    reversed: &[bool],
    refill: impl Fn(usize, &Chain) -> Option<FaceDraft>,
    told: &mut Vec<(usize, ClosingOutcome)>,
) -> PreparedPart {
    let mut edges = brep_edges(call, part, finely_cut, &drafts);
    let mut out = PreparedPart { brep_edges: part.edges.len(), ..PreparedPart::default() };
    out.tiles.reserve(drafts.iter().flatten().map(|draft| draft.tiles.len()).sum());
    out.faces.reserve(drafts.len());
    out.face_rows.reserve(drafts.len());
    // A panic is an error, so that a bug in this crate costs no other face.
    let add = |k: usize, draft: &mut FaceDraft, edges: &mut Vec<PreparedEdge>, tiles: &mut Vec<Tile>| {
        let added = guarded(|| Ok(add_tiles(k, draft, edges, tiles, part.edges.len())));
        added.map_err(Unclosed::Panic)?.map_err(|()| Unclosed::Loops)
    };
    let mut drafts = drafts.into_iter().enumerate();
    while let Some((k, draft)) = drafts.next() {
        if call.is_cancelled() {
            call.discard(drafts.collect());
            out.edges = edges;
            return out;
        }
        let Some(mut draft) = draft else {
            out.face_rows.push(None);
            continue;
        };
        let first = (out.tiles.len(), edges.len());
        let mut closed = add(k, &mut draft, &mut edges, &mut out.tiles);
        let refilled = closed.is_err();
        if let Err(why) = &closed {
            // What the face added so far is all that it changed: borders and tiles.
            out.tiles.truncate(first.0);
            edges.truncate(first.1);
            let why = why.clone();
            if let Some(filled) = refill(k, &draft.chain) {
                draft = filled;
                use_edges(part, &draft, &mut edges);
                closed = add(k, &mut draft, &mut edges, &mut out.tiles);
            }
            told.push((k, if closed.is_ok() { ClosingOutcome::Filled(why) } else { ClosingOutcome::Lost(why) }));
        }
        let Ok(added) = closed else {
            out.tiles.truncate(first.0);
            edges.truncate(first.1);
            out.face_rows.push(None);
            continue;
        };
        told.extend(added.map(|added| (k, ClosingOutcome::Closure(added))));
        out.face_rows.push(Some(id(out.faces.len())));
        let kind = if draft.filled { SurfaceKind::Plane } else { part.faces[k].surface.kind() };
        let Patched { patches, bounds, maps, creases, sharp } = draft.surface;
        let plane_normal = (kind == SurfaceKind::Plane).then(|| {
            let [_, du, dv] = patches.tangents(patches.breaks_u[0], patches.breaks_v[0]);
            du.cross(dv).try_normalize().unwrap_or(DVec3::Z)
        });
        out.faces.push(PreparedFace {
            kind,
            entity: part.faces[k].entity,
            repaired: refilled || !draft.repairs.is_empty() || added.is_some_and(|added| added.loops > 0),
            filled: draft.filled,
            crosses: draft.crosses,
            patches,
            bounds,
            maps,
            creases,
            sharp,
            reversed: reversed[k],
            plane_normal,
            gap: draft.gap,
            critical: draft.critical,
            meetings: draft.meetings,
            tiles: id(first.0)..id(out.tiles.len()),
        });
    }
    for (k, tile) in out.tiles.iter_mut().enumerate() {
        for (l, uses) in tile.loops.iter_mut().enumerate() {
            for (u, edge_use) in uses.iter_mut().enumerate() {
                let edge = &mut edges[edge_use.edge.index()];
                // The ends of poles have moved since.
                edge_use.start.0 = edge.breaks[edge_use.from as usize].point;
                edge.uses.push(TileUse { tile: TileId(id(k)), of_loop: id(l), index: id(u) });
            }
        }
    }
    sample_images::sample(call, &mut edges, &out.tiles);
    let around = |edges: &[PreparedEdge]| {
        let places = edges.iter().flat_map(|edge| edge.bounds.places());
        places.fold(BoundingBox::EMPTY, |all, place| all.with(place))
    };
    out.edge_boxes = edges.chunks(EDGES_PER_BOX).map(around).collect();
    out.edges = edges;
    out
}

/// Prepares the edges of a face that no other face has used so far.
fn use_edges(part: &Part, draft: &FaceDraft, edges: &mut [PreparedEdge]) {
    for edge in draft.edges().map(|edge| edge as usize) {
        if edges[edge].breaks.is_empty() {
            edges[edge] = brep_edge(part, &part.edges[edge], Vec::new(), true);
        }
    }
}

/// Numbers the borders and breaks of face `k`, appends its tiles and closes their loops. Returns what was added.
///
/// # Errors
/// As [`close`].
fn add_tiles(
    k: usize,
    draft: &mut FaceDraft,
    edges: &mut Vec<PreparedEdge>,
    tiles: &mut Vec<Tile>,
    brep_edges: usize,
) -> Result<Option<Closure>, ()> {
    let (first_tile, first_border) = (tiles.len(), edges.len());
    for b in std::mem::take(&mut draft.borders) {
        let border = border(b, edges);
        edges.push(border);
    }
    for t in std::mem::take(&mut draft.tiles) {
        let edge_use = |u: DraftUse| {
            let edge = match u.along {
                DraftAlong::Edge(e) => e as usize,
                DraftAlong::Border(b) => first_border + b as usize,
            };
            let breaks = &edges[edge].breaks;
            let (from, to) = (nearest_break(breaks, u.from), nearest_break(breaks, u.to));
            (from != to).then(|| EdgeUse::new(RowId(id(edge)), breaks, [from, to].map(id), u.uv))
        };
        let loops = t.loops.into_iter().map(|l| l.into_iter().filter_map(edge_use).collect::<Vec<_>>());
        let loops = loops.filter(|l| !l.is_empty()).collect();
        let middle = 0.5 * (t.min + t.max);
        let [centre, du, dv] = draft.surface.patches.tangents(middle.x, middle.y);
        tiles.push(Tile {
            face: FaceId::new(k),
            min: t.min,
            max: t.max,
            loops,
            entangled: t.entangled,
            // Set once the model's size is known.
            weight: 0.0,
            centre,
            proportions: proportions([du, dv], t.max - t.min),
        });
    }
    end_poles(&tiles[first_tile..], edges);
    let FaceDraft { chain, lobed, ends_with_surface: may_end, .. } = &*draft;
    let wanted = Wanted { chain, brep_edges, lobed, may_end: *may_end };
    close(&mut tiles[first_tile..], edges, &wanted)
}

/// Lengths of a parameter rectangle of this size in space, by the derivatives in its middle: relative to the longer
/// one.
fn proportions([du, dv]: [DVec3; 2], size: DVec2) -> DVec2 {
    /// Less is noise.
    const LEAST: f64 = 1e-6;
    let lengths = DVec2::new(du.length(), dv.length()) * size;
    let longest = lengths.max_element();
    if longest > 0.0 && longest.is_finite() { (lengths / longest).max(DVec2::splat(LEAST)) } else { DVec2::ONE }
}

/// The edge for a border of a face, with its ends on breaks of edges.
fn border(b: DraftBorder, edges: &[PreparedEdge]) -> PreparedEdge {
    let place = |end: DraftEnd| match end {
        DraftEnd::Point(p) => p,
        DraftEnd::OnEdge(e, t) => {
            let breaks = &edges[e as usize].breaks;
            breaks[nearest_break(breaks, t)].point
        }
    };
    let ends = b.ends.map(place);
    let (shape, bounds) = match b.shape {
        DraftShape::Curve(c) => {
            let bounds = CurveBounds::new(&c);
            (EdgeShape::Curve(c), bounds)
        }
        DraftShape::Pole(end) => (EdgeShape::Point(place(end)), CurveBounds::none(b.range)),
    };
    let straight = bounds.is_straight();
    let mut breaks = vec![Break { t: b.range.0, point: ends[0] }];
    breaks.extend(b.creases.iter().map(|&t| match &shape {
        EdgeShape::Curve(c) => Break { t, point: c.point(t) },
        EdgeShape::Point(point) => Break { t, point: *point },
    }));
    breaks.push(Break { t: b.range.1, point: ends[1] });
    PreparedEdge::new(shape, bounds, breaks, straight)
}

/// Moves the ends of borders along poles to the ends of the adjacent edges. A file may have several vertices close to a
/// pole, and the faces beyond those edges use them.
fn end_poles(tiles: &[Tile], edges: &mut [PreparedEdge]) {
    for uses in tiles.iter().flat_map(|tile| &tile.loops) {
        for (before, after) in uses.iter().zip(uses.iter().cycle().skip(1)) {
            let ends = [(before.edge.index(), before.to as usize), (after.edge.index(), after.from as usize)];
            let along_pole = ends.map(|(edge, _)| matches!(edges[edge].shape, EdgeShape::Point(_)));
            let (pole, beside) = match along_pole {
                [true, _] => (ends[0], ends[1]),
                [false, true] => (ends[1], ends[0]),
                [false, false] => continue,
            };
            edges[pole.0].breaks[pole.1].point = edges[beside.0].breaks[beside.1].point;
        }
    }
}

fn id(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}

/// The edges of a part, with the breaks and joints of all its faces, and room for the faces' borders.
fn brep_edges(call: Call<'_>, part: &Part, finely_cut: usize, drafts: &[Option<FaceDraft>]) -> Vec<PreparedEdge> {
    let faces = || drafts.iter().flatten();
    let mut wanted: Vec<Vec<f64>> = vec![Vec::new(); part.edges.len()];
    for (edge, t) in faces().flat_map(|d| &d.breaks) {
        wanted[*edge as usize].push(*t);
    }
    let mut used = vec![false; part.edges.len()];
    for draft in faces() {
        draft.edges().chain(draft.chain.iter().map(|c| c.0)).for_each(|edge| used[edge as usize] = true);
    }
    let borders: usize = faces().map(|draft| draft.borders.len()).sum();
    let mut edges: Vec<PreparedEdge> = Vec::with_capacity(part.edges.len() + borders);
    let stated = part.edges.iter().zip(wanted).zip(used).enumerate();
    edges.extend(call.each(SHARE, stated, |(k, ((e, ts), used))| {
        let mut edge = brep_edge(part, e, ts, used && !call.is_cancelled());
        if k >= finely_cut {
            edge.bounds = edge.bounds.merged();
        }
        edge
    }));
    if call.is_cancelled() {
        return edges;
    }
    for (edge, t, point) in faces().flat_map(|d| &d.joints) {
        let breaks = &mut edges[*edge as usize].breaks;
        let k = nearest_break(breaks, *t);
        // The ends are vertices, which other faces use too.
        if k > 0 && k + 1 < breaks.len() {
            breaks[k].point = *point;
        }
    }
    edges
}

/// Index of the break nearest to a parameter.
fn nearest_break(breaks: &[Break], t: f64) -> usize {
    let k = breaks.partition_point(|b| b.t < t);
    let is_next = k == 0 || k < breaks.len() && breaks[k].t - t < t - breaks[k - 1].t;
    if is_next { k } else { k - 1 }
}

fn brep_edge(part: &Part, e: &Edge, mut ts: Vec<f64>, used: bool) -> PreparedEdge {
    let (t0, t1) = e.range;
    if !used {
        let shape = EdgeShape::Point(part.vertices.get(e.start.index()).copied().unwrap_or_default());
        return PreparedEdge::new(shape, CurveBounds::none(e.range), Vec::new(), true);
    }
    let curve = BezierSpline3::new(&e.curve, e.range);
    let bounds = CurveBounds::new(&curve);
    let straight = e.kind == CurveKind::Line || bounds.is_straight();
    ts.extend(e.curve.kinks().into_iter().filter(|&k| k > t0 && k < t1));
    let close = SAME_SHARE * (t1 - t0);
    ts.retain(|t| t - t0 > close && t1 - t > close);
    ts.sort_by(f64::total_cmp);
    ts.dedup_by(|b, a| *b - *a <= close);
    let mut breaks = Vec::with_capacity(ts.len() + 2);
    breaks.push(Break { t: t0, point: part.vertices[e.start.index()] });
    breaks.extend(ts.into_iter().map(|t| Break { t, point: curve.point(t) }));
    breaks.push(Break { t: t1, point: part.vertices[e.end.index()] });
    PreparedEdge::new(EdgeShape::Curve(curve), bounds, breaks, straight)
}
