//! What prepare leaves behind: faces cut into tiles, edges with their breaks, everything the frame needs and no more.

use super::images::EdgeImages;
use crate::mesh::Scene;
use crate::model::{AxisMap, Diagnostic, EdgeId, FaceId, PartId, RowId, SurfaceKind, TileId};
use crate::prepare::surface::decompose::{BezierPatches, BezierSpline3};
use crate::prepare::surface::tables::{CurveBounds, SurfaceBounds};
use crate::prepare::uv::uv_curve::UvCurve;
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// A face ready for tessellation.
#[derive(Clone, Debug)]
pub struct PreparedFace {
    /// What the surface was before it became Bézier pieces.
    pub kind: SurfaceKind,
    /// Entity number of the face in the source file, 0 if none.
    pub entity: u64,
    /// Whether its boundary is not quite as stated: it crossed or overlapped itself, or had gaps. A diagnostic says where.
    pub repaired: bool,
    /// Whether its surface is not the file's but the plane that its loops fit best, as they have no region there.
    pub filled: bool,
    /// Whether a diagnostic says that its boundary crosses or overlaps itself.
    pub crosses: bool,
    /// Bézier pieces over the face's parameter box.
    pub patches: BezierPatches,
    /// Derivative bounds per sub-box.
    pub bounds: SurfaceBounds,
    /// From the surface's natural parameters to those of `patches`.
    pub maps: [AxisMap; 2],
    /// Parameters in u and in v where the surface has a crease: lattice lines always run there.
    pub creases: [Vec<f64>; 2],
    /// Whether triangles are turned over: outward normal opposite to `S_u × S_v`.
    pub reversed: bool,
    /// Largest distance between the surface and the face's edges: the gap that the file itself leaves, millimetres.
    pub gap: f64,
    /// Critical parameters: what its tiles ask of its edges, so that coarse polylines do not cross where the curves do not.
    pub critical: u32,
    /// Points where its boundary meets itself other than at common ends; they are points of both edges.
    pub meetings: u32,
    /// The face's tiles within [`PreparedPart::tiles`].
    pub tiles: std::ops::Range<u32>,
}

/// What an edge's points are.
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
    /// The point there: a B-rep vertex, a crossing with a tile border, a critical point. Meshes use this very value.
    pub point: DVec3,
}

/// A place in a tile's loops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileUse {
    /// The tile.
    pub tile: TileId,
    /// Which of its loops.
    pub of_loop: u32,
    /// Which stretch of the loop.
    pub index: u32,
}

/// A B-rep edge, or a border between tiles: one curve, shared by the tiles along it.
#[derive(Clone, Debug)]
pub struct PreparedEdge {
    /// Its points.
    pub shape: EdgeShape,
    /// First and last are the ends; increasing in `t`.
    pub breaks: Vec<Break>,
    /// Derivative bounds per strip.
    pub bounds: CurveBounds,
    /// Straight: one segment between breaks keeps every tolerance.
    pub straight: bool,
    /// Where tiles use it.
    pub uses: Vec<TileUse>,
    /// Where it runs in those tiles.
    pub images: EdgeImages,
}

/// A stretch of an edge as one tile's trim loop uses it.
#[derive(Clone, Debug)]
pub struct EdgeUse {
    /// A row of [`PreparedPart::edges`].
    pub edge: RowId,
    /// Break where the stretch starts, in loop direction.
    pub from: u32,
    /// Break where it ends; less than `from` when the loop runs against the edge.
    pub to: u32,
    /// The stretch in the tile's (u,v).
    pub uv: UvCurve,
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
    /// Trim loops, kept side left; each a closed chain of edge stretches.
    pub loops: Vec<Vec<EdgeUse>>,
    /// Whether the loops meet themselves or each other, or wind around a part of the border more than once or backwards:
    /// their region is what they wind around a positive number of times, and is found by counting.
    pub entangled: bool,
    /// Expected cost where the model fills a screen, nanoseconds on the machine of docs/benchmarks.md; above 0, finite. What it is made
    /// of: cells, boundary, and how crowded that is.
    pub weight: f64,
    /// A point near the middle, part coordinates.
    pub centre: DVec3,
}

/// A part ready for tessellation.
#[derive(Clone, Debug, Default)]
pub struct PreparedPart {
    /// Faces, as in the model's part.
    pub faces: Vec<PreparedFace>,
    /// For each face of the model's part its row in `faces`; `None` when prepare could not use it (a diagnostic says why).
    pub face_rows: Vec<Option<u32>>,
    /// Tiles, sorted by face.
    pub tiles: Vec<Tile>,
    /// B-rep edges in the model's order, those made for faces that have none (with free trims, or kept whole), edges that close
    /// gaps in loops, and pieces of edges that coincide in part; then borders of tiles. An edge that another one replaced
    /// has no uses.
    pub edges: Vec<PreparedEdge>,
    /// How many of `edges` are no borders of tiles.
    pub brep_edges: usize,
}

/// A model ready for tessellation.
#[derive(Clone, Debug, Default)]
pub struct Prepared {
    /// Parts, as in the model. A part that stands here twice is one object.
    pub parts: Vec<Arc<PreparedPart>>,
    /// Names, colours, instances: what sinks are told.
    pub scene: Scene,
    /// The model's diagnostics and prepare's own.
    pub diagnostics: Vec<Diagnostic>,
    /// Lower and upper corner of the box of the trimmed, placed model, millimetres, within about 0.1 %; `None` if nothing
    /// is placed.
    pub bounds: Option<[DVec3; 2]>,
    /// Diagonal of that box; 0 without one.
    pub diagonal: f64,
}

impl Prepared {
    /// Every tile: its part, its number within the part, and the tile.
    pub fn tiles(&self) -> impl Iterator<Item = (PartId, TileId, &Tile)> {
        self.parts.iter().enumerate().flat_map(|(p, part)| {
            part.tiles.iter().enumerate().map(move |(t, tile)| (PartId::new(p), TileId(t as u32), tile))
        })
    }

    /// Every edge of faces, other than borders between tiles, that some tile uses: its part and its number within the part.
    pub fn brep_edges(&self) -> impl Iterator<Item = (PartId, EdgeId)> {
        self.parts.iter().enumerate().flat_map(|(p, part)| {
            (0..part.brep_edges)
                .filter(|&e| !part.edges[e].uses.is_empty())
                .map(move |e| (PartId::new(p), EdgeId::new(e)))
        })
    }
}

/// Edges, or stretches of them, that have a face on one side only.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OpenEdges {
    /// How many edges.
    pub count: usize,
    /// How long they are together, millimetres, within about a thousandth.
    pub length: f64,
    /// A point of one, part coordinates.
    pub place: Option<DVec3>,
}

impl PreparedPart {
    /// The edges at which its faces end: used, or used in a stretch, an odd number of times. A sheet's outline, and the gaps
    /// of what should be closed. Borders between tiles are in pairs. Cost: a look at all edges.
    #[must_use]
    pub fn open_edges(&self) -> OpenEdges {
        /// Chords per Bézier piece that a length is measured by.
        const CHORDS: usize = 16;
        let mut open = OpenEdges::default();
        for edge in &self.edges[..self.brep_edges] {
            let EdgeShape::Curve(curve) = &edge.shape else { continue };
            let mut odd = vec![false; edge.breaks.len().saturating_sub(1)];
            for &TileUse { tile, of_loop: l, index: u } in &edge.uses {
                let used = &self.tiles[tile.0 as usize].loops[l as usize][u as usize];
                let (from, to) = (used.from.min(used.to), used.from.max(used.to));
                odd[from as usize..to as usize].iter_mut().for_each(|o| *o = !*o);
            }
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

    /// Row of a tile's face in [`faces`](Self::faces).
    ///
    /// # Panics
    /// Never for tiles of this part: prepare makes tiles only for faces that have a row.
    #[must_use]
    pub fn face_of(&self, tile: &Tile) -> usize {
        self.face_rows[tile.face.index()].expect("a tile's face has a row") as usize
    }
}
