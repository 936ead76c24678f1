//! Models, drafts and prepared models -> their memory in bytes, estimated from counts; limits on memory and patches,
//! checked face by face during the work.

use super::kept::KeptFace;
use super::prepared::{
    Break, EdgeShape, EdgeUse, ImageSpan, PartCost, PartFacts, Prepared, PreparedEdge, PreparedFace, PreparedPart, Tile,
};
use super::sample_images::STEPS;
use crate::control::{Call, Counter, Stage};
use crate::mesh::{SceneInstance, ScenePart};
use crate::model::{Coedge, Edge, Face, Instance, Loop, Model, NurbsCurve3, Part, Surface, TrimPiece};
use crate::prepare::report::Room;
use crate::prepare::surface::decompose::{BezierPatches, BezierSpline3};
use crate::prepare::surface::tables::{BoundingBox, BoxBounds, CurveBounds, StripBounds, SurfaceBounds};
use crate::prepare::tiles::draft::{DraftBorder, DraftShape, DraftTile, DraftUse, FaceDraft};
use crate::prepare::tiles::extent::patches_of;
use crate::prepare::trims::spans::Span;
use crate::prepare::uv::uv_curve::{UvCurve, UvSample};
use crate::prepare::uv::uv_loop::Piece;
use glam::{DVec2, DVec3, DVec4};
use std::sync::atomic::{AtomicU64, Ordering};

/// Bytes of an allocation besides its contents: rounding up, and the allocator's own.
const ALLOCATION: usize = 16;

/// What an edge of a model takes once it is prepared: the edge with the bounds of one strip and two uses, its breaks,
/// and the lists of its curve without their contents.
const PREPARED_EDGE: usize = size_of::<PreparedEdge>() + 2 * size_of::<Break>() + 3 * ALLOCATION;

/// What a use of an edge takes in a prepared part, besides the use: its image, with samples and a rate in three strips.
const PREPARED_USE: usize = size_of::<ImageSpan>() + 3 * (STEPS + 1) * size_of::<[f32; 2]>() + 2 * ALLOCATION;

/// Bounds of a strip of a curve.
const STRIP: usize = size_of::<(StripBounds, f64)>();

/// A model that prepare has not touched yet, with the edges and scene that prepare makes of it.
fn of_model(model: &Model) -> usize {
    let instances = model.instances.len() * (size_of::<Instance>() + size_of::<SceneInstance>());
    instances + model.parts.iter().map(of_part).sum::<usize>()
}

fn of_part(part: &Part) -> usize {
    let edges = part.edges.iter().map(|edge| {
        let points = edge.curve.points.len();
        size_of::<Edge>() + of_curve(&edge.curve) + PREPARED_EDGE + points * (size_of::<DVec4>() + STRIP)
    });
    part.vertices.len() * size_of::<DVec3>() + edges.sum::<usize>() + part.faces.iter().map(of_face).sum::<usize>()
}

fn of_face(face: &Face) -> usize {
    let surface = match &face.surface {
        Surface::Nurbs(net) => {
            net.points.len() * (size_of::<DVec3>() + 8) + 8 * (net.knots_u.len() + net.knots_v.len())
        }
        Surface::Extrusion { curve, .. } | Surface::Revolution { curve, .. } => of_curve(curve),
        _ => 0,
    };
    let loops = face.loops.iter().map(|of| match of {
        Loop::Edges(uses) => size_of::<Loop>() + ALLOCATION + uses.len() * size_of::<Coedge>(),
        Loop::Vertex(_) => size_of::<Loop>(),
    });
    let trims = face.trims.iter().flat_map(|trims| &trims.curves).flat_map(|curve| &curve.pieces).map(of_trim);
    // Colours and rows of faces stay when the model goes.
    size_of::<Face>() + face.name.len() + surface + loops.sum::<usize>() + trims.sum::<usize>() + 3 * ALLOCATION
}

/// A piece of a trimming curve, with what is made of it before anything else counts memory: monotone spans, and an edge
/// along each.
fn of_trim(piece: &TrimPiece) -> usize {
    /// Control points and knots of the curve along a span that one cubic follows.
    const CUBIC: usize = 4 * (size_of::<DVec3>() + size_of::<DVec4>() + STRIP) + 8 * 8 + 3 * ALLOCATION;
    /// Such an edge with its image in (u,v), and a vertex.
    const EDGE: usize = size_of::<Edge>()
        + CUBIC
        + PREPARED_EDGE
        + size_of::<DVec3>()
        + size_of::<Piece>()
        + 2 * size_of::<UvSample>()
        + ALLOCATION;
    let (stated, spans, order) = match piece {
        TrimPiece::Polyline(points) => (size_of_val(&points[..]), points.len(), 2),
        TrimPiece::Nurbs(curve) => {
            let lists = curve.points.len() * size_of::<DVec2>() + 8 * (curve.knots.len() + curve.weights.len());
            (lists, curve.points.len(), curve.degree.saturating_add(1))
        }
    };
    // Points of a spline of few spans count for the extremes at which these are cut.
    let span = size_of::<Span>() + order.saturating_mul(size_of::<DVec3>()) + ALLOCATION + EDGE;
    stated.saturating_add(spans.saturating_mul(span)) + 3 * ALLOCATION
}

fn of_curve(curve: &NurbsCurve3) -> usize {
    curve.points.len() * size_of::<DVec3>() + 8 * (curve.knots.len() + curve.weights.len()) + 3 * ALLOCATION
}

/// A face's draft, and what its tiles add to a part.
fn of_draft(draft: &FaceDraft) -> usize {
    let tiles = draft.tiles.iter().map(|tile| {
        let uses = tile.loops.iter().flatten().map(|u| size_of::<DraftUse>() + of_image(&u.uv) + PREPARED_USE);
        size_of::<DraftTile>() + size_of::<Tile>() + tile.loops.len() * (24 + ALLOCATION) + uses.sum::<usize>()
    });
    let borders = draft.borders.iter().map(|border| {
        let curve = of_shape(&border.shape);
        size_of::<DraftBorder>() + curve + PREPARED_EDGE + curve / size_of::<DVec4>() * STRIP
    });
    let breaks = draft.breaks.len() * (size_of::<Break>() + 24) + draft.joints.len() * 48 + draft.tangles.len() * 32;
    let own = size_of::<FaceDraft>() + size_of::<PreparedFace>() + 12 * ALLOCATION;
    own + of_patches(&draft.surface.patches, &draft.surface.bounds)
        + tiles.sum::<usize>()
        + borders.sum::<usize>()
        + breaks
}

fn of_shape(shape: &DraftShape) -> usize {
    if let DraftShape::Curve(curve) = shape { of_spline(curve) } else { 0 }
}

/// A draft that is kept, besides what it shares with the part: patches, bounds and images of edges.
fn of_kept(draft: &FaceDraft) -> usize {
    let tiles = draft.tiles.iter().map(|tile| {
        let uses = tile.loops.iter().map(|of| ALLOCATION + size_of_val(of) + size_of_val(&of[..]));
        size_of::<DraftTile>() + uses.sum::<usize>()
    });
    let borders = draft.borders.iter().map(|border| size_of::<DraftBorder>() + of_shape(&border.shape));
    let lists = size_of_val(&draft.breaks[..]) + size_of_val(&draft.joints[..]) + size_of_val(&draft.chain[..]);
    let told = size_of_val(&draft.notes[..]) + size_of_val(&draft.repairs[..]) + size_of_val(&draft.lobed[..]);
    let own = size_of::<KeptFace>() + size_of::<FaceDraft>() + 6 * ALLOCATION;
    own + tiles.sum::<usize>() + borders.sum::<usize>() + lists + told
}

fn of_patches(patches: &BezierPatches, bounds: &SurfaceBounds) -> usize {
    patches.control.len() * size_of::<DVec4>() + bounds.cells.len() * size_of::<(BoxBounds, BoundingBox)>()
}

fn of_spline(spline: &BezierSpline3) -> usize {
    spline.control.len() * size_of::<DVec4>() + 8 * spline.breaks.len() + 2 * ALLOCATION
}

fn of_image(uv: &UvCurve) -> usize {
    match uv {
        UvCurve::Hermite(samples) => samples.len() * size_of::<UvSample>() + ALLOCATION,
        UvCurve::Iso { .. } => 0,
    }
}

/// Memory of a [`Prepared`] by kind, bytes, estimated from counts. Other prepared models may share parts of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct PreparedMemory {
    /// Faces: Bézier patches and derivative bounds.
    pub faces: u64,
    /// Edges: curves, breaks, derivative bounds.
    pub edges: u64,
    /// Tiles: loops, and images of edges in them.
    pub tiles: u64,
    /// Names of parts, colours, instances. Without names of instances, which they share with each other and the model.
    pub scene: u64,
    /// What only an [update](Prepared::update) reads: a hash and points of each part, its diagnostics, and what
    /// [is kept of faces](crate::prepare::PrepareOptions::keep_faces).
    pub update: u64,
}

impl PreparedMemory {
    /// The sum.
    #[must_use]
    pub const fn total(&self) -> u64 {
        let Self { faces, edges, tiles, scene, update } = *self;
        faces + edges + tiles + scene + update
    }

    fn add(&mut self, part: &PreparedPart) {
        let faces = part.faces.iter().map(|face| size_of::<PreparedFace>() + of_patches(&face.patches, &face.bounds));
        self.faces += faces.sum::<usize>() as u64;
        let edges = part.edges.iter().map(|edge| {
            let curve = if let EdgeShape::Curve(curve) = &edge.shape { of_spline(curve) } else { 0 };
            size_of::<PreparedEdge>() + curve + edge.breaks.len() * size_of::<Break>() + of_bounds(&edge.bounds)
        });
        self.edges += (edges.sum::<usize>() + size_of_val(&part.edge_boxes[..])) as u64;
        let uses = part.tiles.iter().flat_map(|tile| &tile.loops).flatten();
        let uses = uses.map(|u| size_of::<EdgeUse>() + of_image(&u.uv) + PREPARED_USE).sum::<usize>();
        self.tiles += (part.tiles.len() * (size_of::<Tile>() + 24 + 2 * ALLOCATION) + uses) as u64;
        let PartFacts { entities, diagnostics, without_area, cloud, kept, .. } = &part.facts;
        let told = size_of_val(&diagnostics[..]) + size_of_val(&without_area[..]) + size_of_val(&entities[..]);
        let kept = kept.iter().map(|face| of_kept(&face.draft)).sum::<usize>();
        self.update += (size_of::<PartFacts>() + told + size_of_val(&cloud[..]) + kept) as u64;
    }
}

impl Prepared {
    /// Estimates the memory that it takes. Cost: one pass over all edges and tiles.
    #[must_use]
    pub fn memory(&self) -> PreparedMemory {
        let instances = self.scene.instances.len() * size_of::<SceneInstance>();
        let colours = self.scene.parts.iter().map(|part| part.name.len() + size_of_val(&part.face_colours[..]));
        let parts = self.scene.parts.len() * size_of::<ScenePart>();
        let scene = parts + instances + colours.sum::<usize>();
        let mut memory = PreparedMemory { scene: scene as u64, ..PreparedMemory::default() };
        // Levels of detail share the data of their part.
        let own = self.parts.iter().zip(&self.scene.parts).filter(|(_, part)| part.mesh_of.is_none());
        own.for_each(|(part, _)| memory.add(part));
        memory
    }
}

fn of_bounds(bounds: &CurveBounds) -> usize {
    if bounds.strips.len() > 1 { bounds.strips.len() * STRIP + 2 * ALLOCATION } else { 0 }
}

/// Upper limits for [`prepare`](crate::prepare::prepare()).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PrepareLimits {
    /// Bézier patches of all faces together.
    pub patches: u64,
    /// Memory of the model and of its patches, derivative bounds, tiles and edges, bytes, estimated from counts.
    pub bytes: u64,
}

impl PrepareLimits {
    /// 16 million patches, 16 GiB. The largest real files have thousands of patches.
    pub const DEFAULT: Self = Self { patches: 1 << 24, bytes: 16 << 30 };
}

options! {
    PrepareLimits:
    with_patches(patches: u64);
    with_bytes(bytes: u64);
}

/// The model exceeds [`PrepareLimits`], or an option is out of range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PrepareError {
    /// [`PrepareOptions::border_tolerance`](crate::prepare::PrepareOptions::border_tolerance) is out of range.
    #[error("the border tolerance is {asked}, not from 0 to 1 (PrepareOptions::border_tolerance)")]
    BorderTolerance {
        /// Its value.
        asked: f64,
    },
    /// More patches than [`PrepareLimits::patches`].
    #[error("the model needs up to {needed} Bézier patches, the limit is {limit} (PrepareLimits::patches)")]
    TooManyPatches {
        /// The limit.
        limit: u64,
        /// Knot spans of all surfaces: the patches needed if every face used all of its surface.
        needed: u64,
    },
    /// More memory than [`PrepareLimits::bytes`].
    #[error(
        "preparing the model (up to {patches} Bézier patches) needs more memory than the limit of {limit} bytes \
         (PrepareLimits::bytes)"
    )]
    TooMuchMemory {
        /// The limit, bytes.
        limit: u64,
        /// Knot spans of all surfaces.
        patches: u64,
    },
    /// The work was [cancelled](crate::control::Control::cancel).
    #[error("preparing was cancelled")]
    Cancelled,
}

/// Adds what the allocator rounds up and has not given back to the system yet: half as much.
fn with_slack(bytes: usize) -> usize {
    bytes.saturating_add(bytes / 2)
}

impl PartCost {
    /// What a face adds to its part, and the draft of it that is kept.
    pub(crate) fn of(draft: &FaceDraft, kept: Option<&KeptFace>) -> Self {
        let (u, v) = draft.surface.patches.counts();
        let bytes = of_draft(draft) + kept.map_or(0, |kept| of_kept(&kept.draft));
        Self { patches: u as u64 * v as u64, bytes: with_slack(bytes) }
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        Self { patches: self.patches + other.patches, bytes: self.bytes.saturating_add(other.bytes) }
    }
}

/// Patches and bytes spent so far by all threads, and whether to go on.
pub(crate) struct PrepareBudget<'a> {
    limits: PrepareLimits,
    patches: AtomicU64,
    pub(crate) call: Call<'a>,
    /// Faces drafted.
    drafted: Counter,
    pub(crate) room: Room,
}

impl<'a> PrepareBudget<'a> {
    /// For `faces` faces to prepare.
    pub(crate) fn new(limits: PrepareLimits, faces: u64, call: Call<'a>) -> Self {
        let drafted = Counter::start(call.control, Stage::Prepare, faces);
        Self { limits, patches: AtomicU64::new(0), call, drafted, room: Room::new(limits.bytes) }
    }

    /// Adds the cost of a model, which is held until all of it is prepared.
    pub(crate) fn hold(&self, model: &Model) {
        self.room.spend(with_slack(of_model(model)));
    }

    /// Adds the cost of a face, or of a part that is taken over.
    pub(crate) fn spend(&self, cost: PartCost) {
        self.patches.fetch_add(cost.patches, Ordering::Relaxed);
        self.room.spend(cost.bytes);
    }

    /// Counts a face that was drafted, or cannot be.
    pub(crate) fn advance(&self) {
        self.drafted.advance();
    }

    /// Whether a limit is exceeded, or the work is cancelled. The remaining faces can then be skipped.
    pub(crate) fn exceeded(&self) -> bool {
        self.call.is_cancelled() || self.patches.load(Ordering::Relaxed) > self.limits.patches || self.room.exceeded()
    }

    /// The error for `model` once a limit is exceeded or the work is cancelled.
    pub(crate) fn error(&self, model: &Model) -> PrepareError {
        if self.call.is_cancelled() {
            return PrepareError::Cancelled;
        }
        let faces = model.parts.iter().flat_map(|part| &part.faces).filter(|face| !face.lost && face.refused.is_none());
        let needed = faces.map(|face| patches_of(&face.surface) as u64).sum();
        if self.patches.load(Ordering::Relaxed) > self.limits.patches {
            return PrepareError::TooManyPatches { limit: self.limits.patches, needed };
        }
        PrepareError::TooMuchMemory { limit: self.limits.bytes, patches: needed }
    }
}
