//! What workers are asked for, what they deliver, and the order in which a commit takes their tiles.

use super::metrics::WorkerMetrics;
use super::writer::Rooms;
use crate::control::{Control, Counter, Stage};
use crate::frame::{Degradation, Rung};
use crate::mesh::{Batch, EdgeLine, NotWritten, Scene, WrittenTile};
use crate::model::{EdgeId, FaceId, PartId, TileId};
use std::ops::Range;
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

/// Where tiles that follow each other in a frame are made, and then found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Seat {
    pub(super) worker: u32,
    /// Of the first one in the worker's hand, and in its delivery.
    first: u32,
    count: u32,
}

impl Seat {
    /// Appends a tile, which `worker` makes as its tile `row`.
    pub(super) fn push(seats: &mut Vec<Self>, worker: u32, row: u32) {
        match seats.last_mut() {
            Some(last) if last.worker == worker && last.first + last.count == row => {
                last.count += 1;
            }
            _ => seats.push(Self { worker, first: row, count: 1 }),
        }
    }

    /// Rows of the tiles.
    pub(super) fn rows(&self) -> Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// All tiles that workers own. Known when they are dealt, so that no frame has to sort what it made.
#[derive(Debug, Default)]
pub(super) struct Seats {
    /// Ascending by (part, tile); none has tiles of two parts.
    seats: Vec<Seat>,
    /// By part.
    parts: Vec<PartSeats>,
}

#[derive(Debug)]
struct PartSeats {
    /// Where its seats end.
    end: usize,
    /// Number of the tiles of each face.
    tiles: Vec<u32>,
    /// The faces that have none.
    without: Vec<FaceId>,
}

impl Seats {
    /// The tiles of `hands`, which are those of the parts of `scene`.
    pub(super) fn of(hands: &[Hand], scene: &Scene) -> Self {
        let tiles = (0..).zip(hands).flat_map(|(worker, hand): (u32, &Hand)| {
            let rows = (0_u32..).zip(&hand.tiles);
            rows.map(move |(row, &(part, tile, face))| ((part, tile), face, (worker, row)))
        });
        let mut tiles: Vec<_> = tiles.collect();
        // Hands are ascending: a stable sort merges them.
        tiles.sort();
        let (mut all, mut left) = (Self::default(), &tiles[..]);
        for (part, of_scene) in scene.parts.iter().enumerate() {
            let count = left.partition_point(|((of, _), ..)| of.index() == part);
            let (of_part, others) = left.split_at(count);
            left = others;
            let (mut seats, mut tiles) = (Vec::new(), vec![0; of_scene.face_colours.len()]);
            for &(_, face, (worker, row)) in of_part {
                tiles.resize(tiles.len().max(face.index() + 1), 0);
                tiles[face.index()] += 1;
                Seat::push(&mut seats, worker, row);
            }
            all.seats.append(&mut seats);
            let without = (0..tiles.len()).filter(|&face| tiles[face] == 0).map(FaceId::new).collect();
            all.parts.push(PartSeats { end: all.seats.len(), tiles, without });
        }
        all
    }

    /// The seats of the first `parts` parts.
    pub(super) fn of_first(&self, parts: usize) -> &[Seat] {
        &self.seats[..self.parts[..parts].last().map_or(0, |part| part.end)]
    }

    /// Number of the faces of the first `parts` parts.
    pub(super) fn faces(&self, parts: usize) -> usize {
        self.parts[..parts].iter().map(|of_part| of_part.tiles.len()).sum()
    }

    /// The faces of the first `parts` parts without triangles, if these are the faces of all tiles that have none.
    pub(super) fn without_triangles(&self, parts: usize, mut of_bare: Vec<(PartId, FaceId)>) -> Vec<(PartId, FaceId)> {
        of_bare.sort_unstable();
        let tiles = |(part, face): (PartId, FaceId)| self.parts[part.index()].tiles[face.index()] as usize;
        let bare = of_bare.chunk_by(|a, b| a == b).filter(|of_face| of_face.len() == tiles(of_face[0]));
        let mut faces: Vec<_> = bare.map(|of_face| of_face[0]).collect();
        for (part, of_part) in self.parts[..parts].iter().enumerate() {
            faces.extend(of_part.without.iter().map(|&face| (PartId::new(part), face)));
        }
        faces
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::ScenePart;
    use crate::model::TileId;

    #[test]
    fn seats_are_in_the_order_of_tiles_and_count_those_of_faces() {
        let row = |part, tile, face| (PartId(part), TileId(tile), FaceId(face));
        let tiles = [
            vec![row(0, 1, 0), row(1, 5, 2)],
            vec![row(0, 0, 0), row(0, 2, 2), row(0, 3, 3), row(1, 3, 0)],
            vec![],
            vec![row(1, 4, 2)],
        ];
        let hands = tiles.clone().map(|tiles| Hand { tiles, edges: Vec::new() });
        let part = |faces| ScenePart { face_colours: vec![None; faces], ..ScenePart::default() };
        let scene = Scene { parts: vec![part(4), part(4), part(0)], ..Scene::default() };
        let seats = Seats::of(&hands, &scene);
        let found = |parts| {
            let of = |seat: &Seat| &tiles[seat.worker as usize][seat.rows()];
            seats.of_first(parts).iter().flat_map(of).copied().collect::<Vec<_>>()
        };
        let mut all = tiles.concat();
        all.sort_unstable();
        assert_eq!(found(3), all);
        assert_eq!(found(1), all[..4]);
        assert_eq!(found(0), []);
        assert_eq!(seats.of_first(3).iter().map(|seat| seat.rows().len()).collect::<Vec<_>>(), [1, 1, 2, 1, 1, 1]);

        assert_eq!([0, 1, 2, 3].map(|parts| seats.faces(parts)), [0, 4, 8, 8]);
        let face = |part, face| (PartId(part), FaceId(face));
        let never = [face(0, 1), face(1, 1), face(1, 3)];
        let mut bare = seats.without_triangles(3, vec![face(1, 2), face(0, 2), face(0, 0)]);
        bare.sort_unstable();
        assert_eq!(bare, [vec![never[0], face(0, 2)], never[1..].to_vec()].concat());
        assert_eq!(seats.without_triangles(3, vec![face(1, 2); 2]), [&[face(1, 2)][..], &never].concat());
    }
}
