//! What workers are asked for, and what they deliver.

use super::metrics::WorkerMetrics;
use super::writer::Rooms;
use crate::control::{Control, Counter, Stage};
use crate::frame::{Degradation, Rung};
use crate::mesh::{Batch, EdgeLine, NotWritten, WrittenTile};
use crate::model::{EdgeId, FaceId, PartId, TileId};
use std::sync::Arc;
use std::time::Duration;

/// Tiles and edges of one worker: all that it owns, or those to make in a frame. Ascending.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Hand {
    /// Tiles with their faces.
    pub(super) tiles: Vec<(PartId, TileId, FaceId)>,
    /// Edges whose polylines the worker makes.
    pub(super) edges: Vec<(PartId, EdgeId)>,
}

impl Hand {
    /// Whether there is nothing to make.
    pub(super) fn is_empty(&self) -> bool {
        self.tiles.is_empty() && self.edges.is_empty()
    }
}

/// What workers tell the caller of a frame, and hear from it, between tiles.
#[derive(Clone)]
pub(super) struct Watch {
    control: Control,
    /// Tiles made by all workers, if that is reported.
    made: Option<Arc<Counter>>,
}

impl Watch {
    pub(super) fn new(control: &Control, tiles: u64) -> Self {
        let made = Counter::start(control, Stage::Tessellate, tiles);
        Self { control: control.clone(), made: Some(Arc::new(made)) }
    }

    /// Reports no progress.
    pub(super) fn of(control: &Control) -> Self {
        Self { control: control.clone(), made: None }
    }

    pub(super) fn is_cancelled(&self) -> bool {
        self.control.is_cancelled()
    }

    /// Counts a tile.
    pub(super) fn advance(&self) {
        self.made.iter().for_each(|made| made.advance());
    }
}

/// Everything that a worker made for one frame. Few bytes, because it moves from a thread to the commit.
#[derive(Default)]
pub(super) struct Delivery {
    /// Counts and times.
    pub(super) metrics: WorkerMetrics,
    /// The tiles of the hand, ascending by (part, tile); empty with a writer.
    pub(super) made: Vec<MadeTile>,
    /// The batch of each tile, likewise.
    pub(super) batches: Vec<Batch>,
    /// The room of each tile, with a writer.
    pub(super) written: Rooms,
    /// `None` if there are none.
    pub(super) notes: Option<Box<Notes>>,
}

impl Delivery {
    /// Its notes; from now on it has some.
    pub(super) fn note(&mut self) -> &mut Notes {
        self.notes.get_or_insert_default()
    }
}

/// What most deliveries have none of, where no lines of edges are asked for.
#[derive(Default)]
pub(super) struct Notes {
    /// The faces of the tiles without triangles.
    pub(super) bare: Vec<(PartId, FaceId)>,
    /// The tile that could not be written. The worker stopped there.
    pub(super) refused: Option<(PartId, TileId, NotWritten)>,
    /// Time of each tile, if they were measured.
    pub(super) times: Vec<(PartId, TileId, Duration)>,
    /// Edge polylines, ascending by (part, edge).
    pub(super) lines: Vec<EdgeLine>,
    /// Degraded tiles, ascending by (part, tile).
    pub(super) degraded: Vec<DegradedTile>,
    /// Rungs of tiles off the normal path, ascending by (part, tile).
    pub(super) rungs: Vec<FaceRung>,
    /// Fills of tiles with more than what their loops wind around once, ascending by (part, tile).
    pub(super) fills: Vec<(TileId, FaceFill)>,
    /// Edges without polyline, ascending by (part, edge).
    pub(super) lost_lines: Vec<LostLine>,
}

/// What the residency of a sink knows of a tile, without its batch.
#[derive(Clone, Copy, Debug)]
pub(super) struct MadeTile {
    pub(super) part: PartId,
    pub(super) tile: TileId,
    pub(super) triangles: u32,
    /// What it takes in the sink.
    pub(super) bytes: u32,
}

impl MadeTile {
    pub(super) fn new(part: PartId, tile: TileId, (triangles, bytes): (u32, usize)) -> Self {
        Self { part, tile, triangles, bytes: bytes.try_into().unwrap_or(u32::MAX) }
    }

    pub(super) fn of(written: &WrittenTile) -> Self {
        let bytes = written.vertex_bytes() + written.index_bytes();
        Self::new(written.part, written.tile, (written.triangles, bytes))
    }
}

/// A tile with a [`Degradation`].
#[derive(Clone, Debug, PartialEq)]
pub struct DegradedTile {
    /// The part.
    pub part: PartId,
    /// The face within the part.
    pub face: FaceId,
    /// The tile within the part.
    pub tile: TileId,
    /// What happened to it.
    pub degradation: Degradation,
}

/// The [`Rung`] that a face needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaceRung {
    /// The part.
    pub part: PartId,
    /// The face within the part.
    pub face: FaceId,
    /// The worst rung of its tiles; [`Rung::Lost`] or [`Rung::NoArea`] if it has no triangles at all.
    pub rung: Rung,
}

/// Triangles of a face besides those that its boundary winds around exactly once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceFill {
    /// The part.
    pub part: PartId,
    /// The face within the part.
    pub face: FaceId,
    /// Triangles that only close the boundary. If the boundary is not simple, also triangles without area.
    pub slivers: u32,
    /// Area that the boundary winds around, but not exactly once, mm².
    pub rewound: f64,
}

impl FaceFill {
    /// Adds the fill of another tile of the face.
    pub(super) fn add(&mut self, other: &Self) {
        self.slivers += other.slivers;
        self.rewound += other.rewound;
    }
}

/// A B-rep edge without a polyline. Triangles are not affected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LostLine {
    /// The part.
    pub part: PartId,
    /// The edge within the part.
    pub edge: EdgeId,
    /// What happened to it.
    pub why: String,
}
