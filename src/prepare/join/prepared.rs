//! The prepared model: faces cut into tiles, edges with their breaks, and all else that frames need.

use super::chains::Closedness;
use super::content::ContentHash;
use super::kept::KeptFace;
use crate::control::Call;
use crate::mesh::Scene;
use crate::model::{AxisMap, Diagnostic, EdgeId, FaceId, PartId, RowId, SurfaceKind, TileId};
use crate::prepare::surface::decompose::{BezierPatches, BezierSpline3};
use crate::prepare::surface::tables::{BoundingBox, CurveBounds, SurfaceBounds};
use crate::prepare::uv::uv_curve::UvCurve;
use glam::{DVec2, DVec3};
use smallvec::SmallVec;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// A face ready for tessellation.
#[derive(Clone, Debug)]
pub struct PreparedFace {
    /// Kind of the surface before it was cut into Bézier pieces.
    pub kind: SurfaceKind,
    /// Entity number of the face in the source file, 0 if none.
    pub entity: u64,
    /// Whether the face is not quite as stated: its boundary crossed or overlapped itself, or had gaps, or it was
    /// filled. A diagnostic says where.
    pub repaired: bool,
    /// Whether the plane that fits its loops best replaces the file's surface.
    pub filled: bool,
    /// Whether a diagnostic reports that its boundary crosses or overlaps itself.
    pub crosses: bool,
    /// Bézier pieces over the face's parameter box.
    pub patches: Arc<BezierPatches>,
    /// Derivative bounds per sub-box.
    pub bounds: Arc<SurfaceBounds>,
    /// Maps from the surface's natural parameters to those of `patches`.
    pub maps: [AxisMap; 2],
    /// Parameters in u and in v where the surface has a crease. Every lattice has a line there.
    pub creases: [Vec<f64>; 2],
    /// Whether the normal turns by more than 0.05 radians at a crease. It does not where lines bend within the surface.
    pub sharp: bool,
    /// Whether the outward normal is opposite to `S_u × S_v`, so that triangles are flipped.
    pub reversed: bool,
    /// The unit normal along `S_u × S_v` of a plane; `None` of other surfaces.
    pub plane_normal: Option<DVec3>,
    /// Largest distance between the surface and the face's edges, millimetres: the gap that the file itself leaves.
    pub gap: f64,
    /// Number of critical parameters: breaks without which coarse polylines could cross where the curves do not.
    pub critical: u32,
    /// Number of points where its boundary meets itself other than at common ends. Both edges have a break there.
    pub meetings: u32,
    /// The face's range of [`PreparedPart::tiles`].
    pub tiles: Range<u32>,
}

impl PreparedFace {
    /// The parameters of `patches` at the surface's natural ones, which meshes have.
    #[must_use]
    pub fn to_patches(&self, natural: DVec2) -> DVec2 {
        DVec2::new(self.maps[0].to_nurbs(natural.x), self.maps[1].to_nurbs(natural.y))
    }
}

/// Geometry of an edge.
#[derive(Clone, Debug)]
pub enum EdgeShape {
    /// A curve in space.
    Curve(BezierSpline3),
    /// A border that collapses to a pole or apex.
    Point(DVec3),
}

/// A parameter of an edge that every tessellation of it contains.
#[derive(Clone, Copy, Debug)]
pub struct Break {
    /// The edge's parameter.
    pub t: f64,
    /// The point there: a B-rep vertex, a crossing with a tile border or a critical point. Meshes use this exact value.
    pub point: DVec3,
}

/// Index of an [`EdgeUse`] in the tiles of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileUse {
    /// The tile.
    pub tile: TileId,
    /// Index of the loop in the tile.
    pub of_loop: u32,
    /// Index of the use in the loop.
    pub index: u32,
}

impl TileUse {
    /// The use, of the part's tiles.
    pub(crate) fn of(self, tiles: &[Tile]) -> &EdgeUse {
        &tiles[self.tile.index()].loops[self.of_loop as usize][self.index as usize]
    }
}

/// A B-rep edge, or a border between tiles: one curve, shared by the tiles along it.
#[derive(Clone, Debug)]
pub struct PreparedEdge {
    /// Its geometry.
    pub shape: EdgeShape,
    /// Breaks, increasing in `t`; the first and the last are the ends.
    pub breaks: Vec<Break>,
    /// Derivative bounds per strip.
    pub bounds: CurveBounds,
    /// Whether one segment between breaks meets every tolerance.
    pub straight: bool,
    /// Where tiles use it.
    pub uses: SmallVec<[TileUse; 2]>,
    /// Samples of its pcurves in those tiles.
    pub images: EdgeImages,
}

impl PreparedEdge {
    /// An edge that no tile uses yet.
    pub(crate) fn new(shape: EdgeShape, bounds: CurveBounds, breaks: Vec<Break>, straight: bool) -> Self {
        Self { shape, breaks, bounds, straight, uses: SmallVec::new(), images: EdgeImages::default() }
    }
}

/// A stretch of an edge as one tile's trim loop uses it.
#[derive(Clone, Debug)]
pub struct EdgeUse {
    /// Index into [`PreparedPart::edges`].
    pub edge: RowId,
    /// Index of the break where the stretch starts, in loop direction.
    pub from: u32,
    /// Index of the break where it ends; less than `from` if the loop runs against the edge.
    pub to: u32,
    /// The pcurve in the tile's (u,v). It may extend beyond the stretch.
    pub uv: UvCurve,
    /// The piece of the pcurve where the stretch starts.
    pub piece: u32,
    /// The point of the break where the stretch starts, and of the pcurve there. A stretch without tessellants between
    /// its breaks needs nothing else of the edge and of the pcurve, which are in other places of memory.
    pub start: (DVec3, DVec2),
}

impl EdgeUse {
    /// Creates the use of a stretch of `edge`, which has these breaks, from one of them to another.
    pub(crate) fn new(edge: RowId, breaks: &[Break], [from, to]: [u32; 2], uv: UvCurve) -> Self {
        let Break { t, point } = breaks[from as usize];
        let piece = uv.piece(t);
        Self { edge, from, to, piece, start: (point, uv.point(t, &mut (piece as usize))), uv }
    }
}

/// Samples of an edge's images: its pcurves in the tiles that use it.
#[derive(Clone, Debug, Default)]
pub struct EdgeImages {
    /// Ends of the strips; empty if they are those of the edge's bounds.
    pub(crate) cuts: Vec<f64>,
    /// One per use of the edge.
    pub(crate) spans: Vec<ImageSpan>,
    pub(crate) places: Vec<[f32; 2]>,
    /// One per use and strip, see [`EdgeImage::rates`].
    pub(crate) rates: Vec<[f32; 2]>,
}

/// The stretch of an edge that a use covers, and where its samples are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImageSpan {
    pub(crate) ends: [f64; 2],
    /// Indices of its first strip and its first place.
    pub(crate) strip: u32,
    pub(crate) place: u32,
    /// Steps per strip.
    pub(crate) steps: u32,
    /// Index of the rates of its first strip.
    pub(crate) rate: u32,
    /// The largest of its [`EdgeImage::rates`], in u and in v.
    pub(crate) fastest: [f32; 2],
    /// See [`EdgeImage::ways`].
    pub(crate) ways: [f32; 2],
}

/// An image of an edge: the sampled pcurve of one use.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeImage<'a> {
    /// First and last parameter.
    pub(crate) ends: [f64; 2],
    /// Index of the first strip that it runs through.
    pub(crate) strip: usize,
    /// Places as shares of the tile in u and in v, at even steps within each strip, which `ends` may shorten. Includes
    /// the ends of strips, once each.
    pub(crate) places: &'a [[f32; 2]],
    pub(crate) steps: usize,
    /// Strip by strip: how often the image would cross the tile in u and in v per unit of the edge's parameter if all
    /// steps were as long as the longest one. Outside the tile it does not move.
    pub(crate) rates: &'a [[f32; 2]],
    /// The sum of that over all strips: a number of crossings in u and in v.
    pub(crate) ways: [f32; 2],
}

impl<'a> EdgeImage<'a> {
    /// The first place, and the following places strip by strip; `None` if the image has no strips.
    pub(crate) fn steps(&self) -> Option<([f32; 2], std::slice::ChunksExact<'a, [f32; 2]>)> {
        let (first, rest) = self.places.split_first()?;
        Some((*first, rest.chunks_exact(self.steps))).filter(|(_, strips)| strips.len() > 0)
    }
}

impl EdgeImages {
    /// Ends of the strips. They include those of the edge's bounds.
    pub(crate) fn strips<'a>(&'a self, bounds: &'a CurveBounds) -> &'a [f64] {
        if self.cuts.is_empty() { &bounds.breaks } else { &self.cuts }
    }

    /// The image of the edge's use `k`.
    pub(crate) fn image(&self, k: usize) -> EdgeImage<'_> {
        let ImageSpan { ends, strip, place, steps, rate, ways, .. } = self.spans[k];
        let (places_end, rates_end) = match self.spans.get(k + 1) {
            Some(next) => (next.place as usize, next.rate as usize),
            None => (self.places.len(), self.rates.len()),
        };
        EdgeImage {
            ends,
            strip: strip as usize,
            places: &self.places[place as usize..places_end],
            steps: steps as usize,
            rates: &self.rates[rate as usize..rates_end],
            ways,
        }
    }
}

/// A rectangle of a face's parameter plane with its trim loops.
#[derive(Clone, Debug)]
pub struct Tile {
    /// The face.
    pub face: FaceId,
    /// Lower corner, in the parameters of the face's patches.
    pub min: DVec2,
    /// Upper corner.
    pub max: DVec2,
    /// Trim loops, with the kept side on the left. Each is a closed chain of edge stretches.
    pub loops: Vec<Vec<EdgeUse>>,
    /// Whether the loops meet themselves or each other, or wind around a part of the tile's border more than once or
    /// backwards. Such a tile is triangulated by winding numbers: each point is covered as often as the loops wind
    /// around it, reversed where that is negative.
    pub entangled: bool,
    /// Expected nanoseconds where the model fills a screen, on the machine of docs/benchmarks.md. Finite, above 0.
    /// Estimated from lattice cells, boundary tessellants and their ratio. A part that an update takes over may keep
    /// the weights that it had.
    pub weight: f64,
    /// A point near the middle, part coordinates.
    pub centre: DVec3,
    /// Length in space along u and v through the middle, relative to the longer one; at least 1e-6.
    pub proportions: DVec2,
}

/// What [`Prepared::update`](Prepared::update) needs of a part that it takes over, besides the part.
#[derive(Clone, Debug, Default)]
pub(crate) struct PartFacts {
    /// Hash of the model's part: parts with the same one are the same, but for entity numbers and the weights of tiles.
    pub(crate) hash: ContentHash,
    /// Entity numbers of the model's faces, then of its shells.
    pub(crate) entities: Vec<u64>,
    /// Diagnostics of prepare. They name the part that it was first.
    pub(crate) diagnostics: Vec<Diagnostic>,
    /// Faces on surfaces without area, ascending.
    pub(crate) without_area: Vec<FaceId>,
    pub(crate) closedness: Closedness,
    /// The model's [`Part::tolerance`](crate::model::Part::tolerance).
    pub(crate) coincidence: f64,
    /// What it counts towards the limits of prepare.
    pub(crate) cost: PartCost,
    /// Points that span its box in any placement.
    pub(crate) cloud: Vec<DVec3>,
    /// Drafts of faces, where they are kept.
    pub(crate) kept: Vec<KeptFace>,
}

/// What a part counts towards the limits of prepare.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PartCost {
    /// Bézier patches.
    pub(crate) patches: u64,
    /// Bytes.
    pub(crate) bytes: usize,
}

/// Edges per box of `edge_boxes`. Blocks of a plan have as many.
pub(crate) const EDGES_PER_BOX: usize = 64;

/// A part ready for tessellation.
#[derive(Clone, Debug, Default)]
pub struct PreparedPart {
    /// Usable faces, in the model's order.
    pub faces: Vec<PreparedFace>,
    /// Row in `faces` of each face of the model's part; `None` if it could not be used (a diagnostic says why).
    pub face_rows: Vec<Option<u32>>,
    /// Tiles, sorted by face.
    pub tiles: Vec<Tile>,
    /// First the edges of faces: B-rep edges in the model's order, edges made for faces that have none (untrimmed, or
    /// with free trims), edges that close gaps in loops, and pieces of edges that coincide in part. Then the borders of
    /// tiles, and straight edges that join the loops of tiles. An edge that was replaced by another has no uses.
    pub edges: Vec<PreparedEdge>,
    /// Number of `edges` that come before the borders of tiles.
    pub brep_edges: usize,
    /// The box of each run of [`EDGES_PER_BOX`] `edges`; the last run may be shorter.
    pub(crate) edge_boxes: Vec<BoundingBox>,
    /// What [`Prepared::update`] and diagnostics need of it.
    pub(crate) facts: PartFacts,
}

/// A model ready for tessellation.
#[derive(Clone, Debug, Default)]
pub struct Prepared {
    /// Parts in the model's order. Levels of detail of a part share its data. Shared, so that the jobs of a plan take one
    /// reference instead of one per part.
    #[doc(hidden)]
    pub parts: Arc<Vec<Arc<PreparedPart>>>,
    /// Names, colours and instances, for sinks.
    pub scene: Scene,
    /// The model's diagnostics and prepare's own.
    pub diagnostics: Vec<Diagnostic>,
    /// Lower and upper corner of the trimmed, placed model's box, mm. Accurate to about 0.1 %. `None` if nothing is
    /// placed.
    pub bounds: Option<[DVec3; 2]>,
    /// Diagonal of that box; 0 without one.
    pub diagonal: f64,
}

impl Prepared {
    /// Centre of [`bounds`](Self::bounds); the origin if there are none.
    #[must_use]
    pub fn centre(&self) -> DVec3 {
        self.bounds.map_or(DVec3::ZERO, |[low, high]| 0.5 * low + 0.5 * high)
    }

    /// What is known of a face of a part. `None` if there is no such face, or if prepare could not use it.
    #[must_use]
    pub fn face_facts(&self, part: PartId, face: FaceId) -> Option<FaceFacts> {
        let face = self.parts.get(part.index())?.face(face)?;
        let (across, along) = face.patches.counts();
        let &PreparedFace { kind, entity, gap, repaired, filled, .. } = face;
        Some(FaceFacts { kind, entity, tiles: face.tiles.clone(), pieces: [across, along], gap, repaired, filled })
    }

    /// All tiles, each with its part and its index in that.
    pub fn tiles(&self) -> impl Iterator<Item = (PartId, TileId, &Tile)> {
        self.parts.iter().enumerate().flat_map(|(p, part)| {
            part.tiles.iter().enumerate().map(move |(t, tile)| (PartId::new(p), TileId(t as u32), tile))
        })
    }

    /// All edges of faces that some tile uses, each with its part and its index in that. Excludes borders of tiles.
    pub fn brep_edges(&self) -> impl Iterator<Item = (PartId, EdgeId)> {
        let parts = self.parts.iter().enumerate();
        parts.flat_map(|(p, part)| part.edges_of_faces().map(move |edge| (PartId::new(p), edge)))
    }
}

/// What is known of a face that can be tessellated.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FaceFacts {
    /// Kind of its surface in the file.
    pub kind: SurfaceKind,
    /// Entity number in the source file, 0 if none.
    pub entity: u64,
    /// Its [tiles](TileId) within the part.
    pub tiles: Range<u32>,
    /// Number of Bézier pieces in u and in v.
    pub pieces: [usize; 2],
    /// Largest distance between the surface and the face's edges, millimetres: the gap that the file itself leaves.
    pub gap: f64,
    /// Whether the face is not quite as stated: its boundary crossed or overlapped itself, or had gaps, or it was
    /// filled. A diagnostic says where.
    pub repaired: bool,
    /// Whether the plane that fits its loops best replaces the file's surface.
    pub filled: bool,
}

impl FaceFacts {
    /// The facts as viewers list them: names and values.
    #[must_use]
    pub fn rows(&self) -> Vec<(&'static str, String)> {
        let Self { kind, entity, tiles, pieces: [across, along], gap, repaired, .. } = self;
        let mut rows = vec![("surface", kind.name().to_owned())];
        rows.extend((*entity != 0).then(|| ("entity", format!("#{entity}"))));
        rows.push(("tiles", tiles.len().to_string()));
        rows.push(("Bézier pieces", format!("{across} × {along}")));
        rows.push(("edge gap", format!("{gap:.2e} mm")));
        rows.extend(repaired.then(|| ("boundary", "repaired".to_owned())));
        rows
    }
}

/// Edges, or stretches of edges, that have a face on one side only.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OpenEdges {
    /// Number of edges.
    pub count: usize,
    /// Their total length, millimetres. Accurate to about a thousandth.
    pub length: f64,
    /// A point on one of them, part coordinates.
    pub place: Option<DVec3>,
}

impl PreparedPart {
    /// Parts with the same content have the same tiles and edges, bit by bit.
    pub(crate) fn content(&self) -> ContentHash {
        self.facts.hash
    }

    /// The same part with other entity numbers. `None` if its diagnostics do not tell which is which: entities that had
    /// the same number have several now.
    pub(crate) fn renumbered(self: &Arc<Self>, entities: Vec<u64>) -> Option<Arc<Self>> {
        if self.facts.entities == entities {
            return Some(Arc::clone(self));
        }
        let mut new = BTreeMap::from([(0, 0)]);
        for (before, now) in self.facts.entities.iter().zip(&entities) {
            if new.insert(*before, *now).is_some_and(|other| other != *now) {
                return None;
            }
        }
        let mut part = Self::clone(self);
        for (row, entity) in part.face_rows.iter().zip(&entities) {
            row.iter().for_each(|row| part.faces[*row as usize].entity = *entity);
        }
        for told in &mut part.facts.diagnostics {
            told.entity = *new.get(&told.entity)?;
        }
        part.facts.entities = entities;
        Some(Arc::new(part))
    }

    /// Frees a part that nobody will see on all threads.
    pub(crate) fn discard(self, call: Call<'_>) {
        call.discard(self.faces);
        call.discard(self.tiles);
        call.discard(self.edges);
        call.discard(self.facts.kept);
    }

    /// Measures the edges where faces end: the outline of a sheet, or gaps in a solid.
    ///
    /// An edge counts if tiles use it, or a stretch of it, an odd number of times. Borders between tiles cancel; those
    /// along which a face ends because its surface does count. Cost: one pass over all edges.
    #[must_use]
    pub fn open_edges(&self) -> OpenEdges {
        /// Chords per Bézier piece for measuring length.
        const CHORDS: usize = 16;
        let mut open = OpenEdges::default();
        for edge in &self.edges {
            let EdgeShape::Curve(curve) = &edge.shape else { continue };
            let odd = self.odd_stretches(edge);
            let mut stretches = odd.iter().enumerate().filter(|(_, o)| **o).map(|(k, _)| k).peekable();
            if let Some(&k) = stretches.peek() {
                open.count += 1;
                open.place.get_or_insert(edge.breaks[k].point);
            }
            for k in stretches {
                let (from, to) = (edge.breaks[k].t, edge.breaks[k + 1].t);
                let chords = CHORDS * curve.breaks.iter().filter(|&&t| t > from && t < to).count().max(1);
                let at = |i: usize| curve.point(from + (to - from) * i as f64 / chords as f64);
                open.length += (0..chords).map(|i| at(i).distance(at(i + 1))).sum::<f64>();
            }
        }
        open
    }

    /// Whether there are no [open edges](Self::open_edges). Cost: a pass over the edges, up to the first open one.
    pub(crate) fn is_closed(&self) -> bool {
        let is_open = |edge: &PreparedEdge| self.odd_stretches(edge).contains(&true);
        !self.edges.iter().any(|edge| matches!(edge.shape, EdgeShape::Curve(_)) && is_open(edge))
    }

    /// For each stretch of an edge between breaks: whether tiles use it an odd number of times.
    fn odd_stretches(&self, edge: &PreparedEdge) -> SmallVec<[bool; 4]> {
        let stretches = edge.breaks.len().saturating_sub(1);
        if stretches == 1 {
            // Every use has all of it, so no tile has to be looked at. Most edges are of this kind.
            return SmallVec::from_elem(edge.uses.len() % 2 == 1, 1);
        }
        let mut odd = SmallVec::from_elem(false, stretches);
        for place in &edge.uses {
            let used = place.of(&self.tiles);
            let (from, to) = (used.from.min(used.to), used.from.max(used.to));
            odd[from as usize..to as usize].iter_mut().for_each(|o: &mut bool| *o = !*o);
        }
        odd
    }

    /// The prepared face; `None` if prepare could not use it, or the number is unknown.
    #[must_use]
    pub fn face(&self, face: FaceId) -> Option<&PreparedFace> {
        let row = (*self.face_rows.get(face.index())?)?;
        self.faces.get(row as usize)
    }

    /// The edges of faces that some tile uses.
    pub(crate) fn edges_of_faces(&self) -> impl Iterator<Item = EdgeId> {
        (0..self.brep_edges).filter(|&edge| !self.edges[edge].uses.is_empty()).map(EdgeId::new)
    }

    /// The prepared face of a tile.
    ///
    /// # Panics
    /// Never for tiles of this part: only faces that have a row get tiles.
    #[must_use]
    pub fn face_of(&self, tile: &Tile) -> &PreparedFace {
        self.face(tile.face).expect("a tile's face has a row")
    }
}

#[cfg(test)]
mod tests {
    use crate::model::shapes;
    use crate::prepare::{PrepareOptions, prepare};

    #[test]
    fn closed_parts_have_no_open_edges() {
        for (name, is_closed) in [("box", true), ("torus", true), ("washer", true), ("square", false), ("wave", false)]
        {
            let model = shapes::by_name(name).expect("a shape");
            let prepared = prepare(model, &PrepareOptions::DEFAULT).expect("within the limits");
            let part = &prepared.parts[0];
            assert_eq!((part.is_closed(), part.open_edges().count == 0), (is_closed, is_closed), "{name}");
            // Edges with one stretch are not looked at: each of their uses has all of it.
            let uses = part.tiles.iter().flat_map(|tile| tile.loops.iter().flatten());
            let of_one = uses.filter(|used| part.edges[used.edge.index()].breaks.len() == 2);
            assert!(
                of_one.clone().count() > 0 && of_one.clone().all(|used| used.from.abs_diff(used.to) == 1),
                "{name}"
            );
        }
    }
}
