//! Deliveries of all workers -> one frame in the sink, in (part, tile) order for any number of workers.

use super::error::FrameError;
use super::handoff::{DegradedTile, Delivery, FaceFill, FaceRung, LostLine, MadeTile};
use super::metrics::{Laps, WorkerMetrics};
use super::writer::Writer;
use crate::control::Control;
use crate::frame::{Ladder, Rung};
use crate::mesh::{Batch, DrawnTiles, EdgeLine, MeshSink, NotWritten, Scene, SinkError, TileMesh, WrittenTile};
use crate::model::{FaceId, PartId, TileId};
use crate::prepare::internals::panic_message;
use std::any::Any;
use std::collections::{BTreeMap, BTreeSet};
use std::hint::black_box;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

/// Report of a committed frame.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct FrameReport {
    /// Number of the frame within its session, from 0.
    pub frame: u64,
    /// Whether the sink got a whole frame rather than changes.
    pub whole: bool,
    /// Tiles made.
    pub tiles: usize,
    /// Batches with triangles sent to the sink, and tiles written into its memory.
    pub batches: usize,
    /// Triangles of all batches, each part counted once.
    pub triangles: u64,
    /// Outdated off-screen tiles evicted from the sink, by empty batches.
    pub forgotten: usize,
    /// Tiles whose change of level waits for the next frame because the budget was spent.
    pub deferred: u32,
    /// Degraded tiles, ascending by (part, tile).
    pub degraded: Vec<DegradedTile>,
    /// Faces off the normal path, ascending by (part, face). Frames made by [`Session::frame`](super::Session::frame)
    /// or [`serial`](super::serial) include faces without triangles.
    pub rungs: Vec<FaceRung>,
    /// All faces by rung, each part counted once. Frames of views only count rebuilt faces off the normal path.
    pub ladder: Ladder,
    /// Triangles that only close boundaries, each part counted once.
    pub slivers: u64,
    /// Faces with such triangles, or that their boundary does not wind around exactly once, ascending by (part, face).
    pub fills: Vec<FaceFill>,
    /// Edges without polyline, ascending by (part, edge).
    pub lost_lines: Vec<LostLine>,
    /// Metrics of each worker, ascending. Workers without an order are left out.
    pub workers: Vec<WorkerMetrics>,
    /// Time to make the plan; zero where the caller passed it.
    pub planned_in: Duration,
    /// Time from the order to the last delivery.
    pub made_in: Duration,
    /// Time from the last delivery to the end of the commit.
    pub committed_in: Duration,
}

/// How a frame is committed.
#[derive(Clone, Copy)]
pub(super) enum Feed<'a> {
    /// As a whole frame, all of it drawn, unless it is cancelled.
    All(&'a Control),
    /// As a frame of views.
    Views {
        /// Whether to send a whole frame rather than changes.
        whole: bool,
        /// For changes of another model than the sink has.
        from: Option<&'a [Option<PartId>]>,
        drawn: &'a DrawnTiles,
        /// Tiles to evict from the sink, ascending.
        forgotten: &'a [(PartId, TileId, FaceId)],
    },
}

/// What a sink is fed. Kept from frame to frame for its room.
#[derive(Default)]
pub(super) struct Rows {
    /// The batches of each delivery; last those of tiles to evict.
    pub(super) batches: Vec<Vec<Batch>>,
    /// Instead of batches.
    written: Vec<Vec<WrittenTile>>,
    /// What to send, ascending by tile. Batches are large, and stay where they are.
    order: Vec<Place>,
    sorter: Sorter,
    lines: Vec<EdgeLine>,
    /// The tiles that were made, by delivery.
    pub(super) made: Vec<Vec<MadeTile>>,
    /// Rows of `order` that the sink was given.
    given: usize,
    rungs: Vec<FaceRung>,
    fills: Vec<(TileId, FaceFill)>,
}

/// Where the batch or the room of a tile is.
#[derive(Clone, Copy)]
struct Place {
    tile: (PartId, TileId),
    face: FaceId,
    list: u32,
    row: u32,
}

/// Sorts rows by tile. Kept from frame to frame for its room.
#[derive(Default)]
struct Sorter {
    /// Of each part, where its tiles begin in `rows`.
    starts: Vec<usize>,
    /// The row of each tile of these parts.
    rows: Vec<u32>,
    sorted: Vec<Place>,
}

/// Feeds a complete frame to the sink: `begin`, tiles by (part, tile), edge lines by (part, edge), the drawn tiles, `end`;
/// `abort` after the first refusal, or when cancelled. Leaves the frame's tiles in `rows`.
///
/// `writer`: where the tiles were written, if they were.
pub(super) fn commit(
    deliveries: Vec<Delivery>,
    (scene, writer): (&Scene, Option<&Writer>),
    feed: Feed<'_>,
    (rows, sink): (&mut Rows, &mut dyn MeshSink),
) -> Result<FrameReport, FrameError> {
    let _span = tracing::debug_span!("commit").entered();
    let mut laps = Laps::start();
    let whole = !matches!(feed, Feed::Views { whole: false, .. });
    let mut report = FrameReport { whole, workers: Vec::with_capacity(deliveries.len()), ..FrameReport::default() };
    rows.clear();
    rows.order.reserve(deliveries.iter().map(|delivery| delivery.made.len()).sum());
    for mut delivery in deliveries {
        report.tiles += delivery.metrics.tiles as usize;
        report.triangles += delivery.metrics.triangles;
        report.workers.push(delivery.metrics);
        report.degraded.extend(delivery.degraded);
        report.lost_lines.extend(delivery.lost_lines);
        rows.rungs.extend(delivery.rungs);
        rows.fills.extend(delivery.fills);
        let list = rows.batches.len() as u32;
        for (row, &MadeTile { part, tile, face, triangles, .. }) in (0..).zip(&delivery.made) {
            report.batches += usize::from(triangles > 0);
            // A whole frame has no need of tiles without triangles.
            if !whole || triangles > 0 {
                rows.order.push(Place { tile: (part, tile), face, list, row });
            }
        }
        rows.made.push(delivery.made);
        rows.batches.push(delivery.batches);
        rows.written.push(delivery.written.take());
        rows.lines.extend(delivery.lines);
    }
    if let Feed::Views { forgotten, .. } = feed {
        report.forgotten = forgotten.len();
        rows.evict(forgotten, writer);
    }
    rows.sorter.sort(&mut rows.order);
    rows.lines.sort_by_key(|l| (l.part, l.edge));
    report.degraded.sort_unstable_by_key(|d| (d.part, d.tile));
    report.lost_lines.sort_unstable_by_key(|l| (l.part, l.edge));
    report.fills = by_face(&mut rows.fills);
    report.slivers = report.fills.iter().map(|fill| u64::from(fill.slivers)).sum();
    let all = matches!(feed, Feed::All(_));
    let faces = rows.order.iter().map(|place| (place.tile.0, place.face));
    (report.rungs, report.ladder) = climbed(all.then_some(scene), faces, &rows.rungs);
    // A sink that panics has refused: the session goes on, with a whole frame.
    let fed = catch_unwind(AssertUnwindSafe(|| rows.feed(scene, (report.whole, feed), (writer.is_some(), sink))));
    let fed = fed.unwrap_or_else(|panic| Err(sink_panicked(&*panic)));
    if let Err(error) = fed {
        if let Some(writer) = writer {
            let left = rows.order[rows.given..].iter();
            let left = left.map(|place| &rows.written[place.list as usize][place.row as usize]);
            // The sink must hear of the end whatever its memory does.
            let _ = catch_unwind(AssertUnwindSafe(|| writer.release(left)));
        }
        // Whatever it does now, the frame is over.
        let _ = catch_unwind(AssertUnwindSafe(|| sink.abort()));
        return Err(error);
    }
    report.committed_in = laps.lap();
    Ok(report)
}

impl Sorter {
    /// No tile has two rows, so there are no ties for the number of workers to decide.
    fn sort(&mut self, order: &mut Vec<Place>) {
        /// Up to this many tiles for a row, a table of all tiles costs less than comparisons.
        const SPARSE: usize = 8;
        const NONE: u32 = u32::MAX;
        let Self { starts, rows, sorted } = self;
        starts.clear();
        for &Place { tile: (part, tile), .. } in &*order {
            if starts.len() <= part.index() {
                starts.resize(part.index() + 1, 0);
            }
            starts[part.index()] = starts[part.index()].max(tile.0 as usize + 1);
        }
        let mut tiles = 0;
        for start in &mut *starts {
            tiles += std::mem::replace(start, tiles);
        }
        if tiles > SPARSE * order.len() {
            order.sort_unstable_by_key(|place| place.tile);
            return;
        }
        rows.clear();
        rows.resize(tiles, NONE);
        for (row, &Place { tile: (part, tile), .. }) in (0..).zip(&*order) {
            rows[starts[part.index()] + tile.0 as usize] = row;
        }
        sorted.clear();
        sorted.extend(rows.iter().filter(|row| **row != NONE).map(|&row| order[row as usize]));
        std::mem::swap(order, sorted);
    }
}

impl Rows {
    fn clear(&mut self) {
        self.batches.clear();
        self.written.clear();
        self.order.clear();
        self.lines.clear();
        self.made.clear();
        self.rungs.clear();
        self.fills.clear();
        self.given = 0;
    }

    /// Adds the tiles to evict.
    fn evict(&mut self, forgotten: &[(PartId, TileId, FaceId)], writer: Option<&Writer>) {
        let list = self.batches.len() as u32;
        let place = |(row, &(part, tile, face))| Place { tile: (part, tile), face, list, row };
        self.order.extend((0..).zip(forgotten).map(place));
        if let Some(writer) = writer {
            let gone = |&(part, tile, face)| WrittenTile::gone((part, face, tile), writer.layout());
            self.written.push(forgotten.iter().map(gone).collect());
        } else {
            let empty = |&(part, tile, face)| Batch { part, face, tile, worker: 0, mesh: TileMesh::default() };
            self.batches.push(forgotten.iter().map(empty).collect());
        }
    }

    fn feed(
        &mut self,
        scene: &Scene,
        (whole, feed): (bool, Feed<'_>),
        (is_written, sink): (bool, &mut dyn MeshSink),
    ) -> Result<(), FrameError> {
        /// Batches that are fetched at a time.
        const FETCHED: usize = 16;
        match feed {
            _ if whole => sink.begin(scene),
            Feed::Views { from: Some(from), .. } => sink.begin_update(scene, from),
            _ => sink.begin_changes(scene),
        }
        .map_err(FrameError::Sink)?;
        let goes_on = || match feed {
            Feed::All(control) if control.is_cancelled() => Err(FrameError::Cancelled),
            _ => Ok(()),
        };
        for places in self.order.chunks(FETCHED) {
            if !is_written {
                // Batches of neighbouring tiles are far apart. The processor waits for many at the same time here, and
                // for one at a time in the sink.
                let fetch = |sum: usize, place: &Place| {
                    let Batch { tile, mesh, .. } = &self.batches[place.list as usize][place.row as usize];
                    sum ^ tile.0 as usize ^ mesh.positions.len() ^ mesh.triangles.len()
                };
                black_box(places.iter().fold(0, fetch));
            }
            for &Place { list, row, .. } in places {
                goes_on()?;
                self.given += 1;
                let (list, row) = (list as usize, row as usize);
                if is_written {
                    sink.written(&self.written[list][row])
                } else {
                    sink.batch(&mut self.batches[list][row])
                }
                .map_err(FrameError::Sink)?;
            }
        }
        for line in self.lines.drain(..) {
            goes_on()?;
            sink.edge_line(line).map_err(FrameError::Sink)?;
        }
        goes_on()?;
        if let Feed::Views { drawn, .. } = feed {
            sink.drawn(drawn).map_err(FrameError::Sink)?;
        }
        sink.end().map_err(FrameError::Sink)
    }
}

/// The error of a sink that panicked.
pub(super) fn sink_panicked(payload: &(dyn Any + Send)) -> FrameError {
    let cause = std::io::Error::other(panic_message(payload));
    FrameError::Sink(SinkError { context: "the sink panicked".into(), cause })
}

/// Why a tile could not be written, if any could not. The frame must then be dropped before the sink hears of it.
pub(super) fn refusal(deliveries: &mut [Delivery]) -> Option<FrameError> {
    let refused = deliveries.iter_mut().filter_map(|delivery| delivery.refused.take());
    // The first one, whoever made it.
    let (_, _, why) = refused.min_by_key(|&(part, tile, _)| (part, tile))?;
    Some(match why {
        NotWritten::Sink(error) => FrameError::Sink(error),
        NotWritten::Grid(error) => FrameError::Grid(error),
    })
}

/// Sums the fills of tiles by face, in the order of the tiles: areas round the same for any number of workers.
fn by_face(tiles: &mut [(TileId, FaceFill)]) -> Vec<FaceFill> {
    tiles.sort_unstable_by_key(|(tile, fill)| (fill.part, fill.face, *tile));
    let mut faces: Vec<FaceFill> = Vec::new();
    for (_, fill) in tiles {
        match faces.last_mut() {
            Some(sum) if (sum.part, sum.face) == (fill.part, fill.face) => sum.add(fill),
            _ => faces.push(*fill),
        }
    }
    faces
}

/// The worst rung of each face that left the normal path, and the number of faces per rung. `scene` is given if all of
/// it was made: then all its faces are counted. `with_triangles`: the faces of the tiles that were made.
fn climbed(
    scene: Option<&Scene>,
    with_triangles: impl Iterator<Item = (PartId, FaceId)>,
    tiles: &[FaceRung],
) -> (Vec<FaceRung>, Ladder) {
    let mut worst: BTreeMap<(PartId, FaceId), Rung> = BTreeMap::new();
    // A tile without area does not affect a face that has other tiles.
    let vanished = |tile: &&FaceRung| tile.rung == Rung::NoArea;
    let tiles_left = tiles.iter().filter(|tile| !vanished(tile));
    let vanished: BTreeSet<(PartId, FaceId)> =
        tiles.iter().filter(vanished).map(|tile| (tile.part, tile.face)).collect();
    let parts = scene.map_or(&[][..], |scene| &scene.parts);
    let has_no_area = |part: PartId, face: FaceId| {
        parts.get(part.index()).is_some_and(|part| part.without_area.binary_search(&face).is_ok())
    };
    for tile in tiles_left {
        let rung = if has_no_area(tile.part, tile.face) { Rung::NoArea } else { tile.rung };
        let worst = worst.entry((tile.part, tile.face)).or_default();
        *worst = rung.max(*worst);
    }
    let mut meshed: Vec<Vec<bool>> = parts.iter().map(|part| vec![false; part.face_colours.len()]).collect();
    for (part, face) in with_triangles {
        if let Some(meshed) = meshed.get_mut(part.index()).and_then(|part| part.get_mut(face.index())) {
            *meshed = true;
        }
    }
    for (part, faces) in meshed.iter().enumerate() {
        for (face, _) in faces.iter().enumerate().filter(|(_, meshed)| !**meshed) {
            let face = FaceId::new(face);
            let key = (PartId::new(part), face);
            let no_area = has_no_area(key.0, key.1) || vanished.contains(&key);
            let rung = if no_area { Rung::NoArea } else { Rung::Lost };
            worst.entry(key).and_modify(|worst| *worst = rung.max(*worst)).or_insert(rung);
        }
    }
    let mut ladder = Ladder::default();
    worst.values().for_each(|rung| ladder.add(*rung, 1));
    let faces: usize = meshed.iter().map(Vec::len).sum();
    ladder.add(Rung::Normal, faces.saturating_sub(worst.len()) as u64);
    (worst.into_iter().map(|((part, face), rung)| FaceRung { part, face, rung }).collect(), ladder)
}
