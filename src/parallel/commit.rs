//! Deliveries of all workers -> one frame in the sink: batches in (part, tile) order for any number of workers, tiles
//! in its own memory by worker.

use super::error::FrameError;
use super::handoff::{DegradedTile, Delivery, FaceFill, FaceRung, LostLine, MadeTile, Notes, Seat, Seats};
use super::metrics::{Laps, WorkerMetrics};
use super::writer::Writer;
use crate::control::Control;
use crate::frame::{Ladder, Rung};
use crate::mesh::{
    Batch, DrawnTiles, EdgeLine, MeshSink, NotWritten, Scene, SceneChanges, SinkError, TileMesh, WrittenTile,
};
use crate::model::{FaceId, PartId, TileId};
use crate::prepare::internals::panic_message;
use std::any::Any;
use std::cmp::Reverse;
use std::hint::black_box;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::slice::Iter;
use std::time::Duration;

/// Report of a committed frame.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct FrameReport {
    /// Number of the frame within its session, from 0. Frames that change something have numbers of their own. One in
    /// which nothing changes has the number of the next one that does.
    pub frame: u64,
    /// Whether the sink got a whole frame rather than changes.
    pub whole: bool,
    /// Tiles made.
    pub tiles: usize,
    /// Batches with triangles sent to the sink, and tiles written into its memory.
    pub batches: usize,
    /// Triangles of all batches, each part counted once.
    pub triangles: u64,
    /// Tiles evicted from the sink that no view draws: outdated ones, those beyond
    /// [`SessionOptions::resident_bytes`](super::SessionOptions::resident_bytes), and those not drawn for long. The
    /// sink gets them without triangles, by [`MeshSink::batch`] or [`MeshSink::written`].
    pub evicted: usize,
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
    /// As a whole frame of everything that workers own, all of it drawn, unless it is cancelled.
    All(&'a Control, &'a Seats),
    /// As a frame of views.
    Views {
        /// Whether to send a whole frame rather than changes.
        whole: bool,
        /// Of the scene since the last frame.
        changes: SceneChanges<'a>,
        /// For changes of another model than the sink has.
        from: Option<&'a [Option<PartId>]>,
        /// And those before.
        drawn: [&'a DrawnTiles; 2],
        evicted: Gone<'a>,
    },
}

impl Feed<'_> {
    /// Whether the sink is to be given more.
    fn goes_on(self) -> Result<(), FrameError> {
        match self {
            Self::All(control, _) if control.is_cancelled() => Err(FrameError::Cancelled),
            _ => Ok(()),
        }
    }
}

/// Seats of which the tiles are fetched at a time.
const FETCHED: usize = 8;

/// What a sink is fed. Kept from frame to frame for its room.
#[derive(Default)]
pub(super) struct Rows {
    /// By worker.
    pub(super) batches: Vec<Vec<Batch>>,
    /// Instead of batches.
    pub(super) written: Vec<Vec<WrittenTile>>,
    lines: Vec<EdgeLine>,
    /// The tiles of batches, by delivery.
    made: Vec<Vec<MadeTile>>,
    /// Tiles that the sink took, of those that were written.
    taken: usize,
    rungs: Vec<FaceRung>,
    fills: Vec<(TileId, FaceFill)>,
}

/// Feeds a complete frame to the sink: `begin`, tiles, edge lines by (part, edge), the drawn tiles, `end`; `abort`
/// after the first refusal, or when cancelled. Leaves the frame's tiles in `rows`.
///
/// `seats`: where batches are, ascending. `writer`: where the tiles were written, if they were.
pub(super) fn commit(
    (deliveries, seats): (Vec<Delivery>, &[Seat]),
    (scene, writer): (&Scene, Option<&Writer>),
    feed: Feed<'_>,
    (rows, sink): (&mut Rows, &mut dyn MeshSink),
) -> Result<FrameReport, FrameError> {
    let _span = tracing::debug_span!("commit").entered();
    let mut laps = Laps::start();
    let whole = !matches!(feed, Feed::Views { whole: false, .. });
    let mut report = FrameReport { whole, workers: Vec::with_capacity(deliveries.len()), ..FrameReport::default() };
    rows.clear();
    let mut bare = Vec::new();
    for mut delivery in deliveries {
        report.tiles += delivery.metrics.tiles as usize;
        report.triangles += delivery.metrics.triangles;
        report.workers.push(delivery.metrics);
        if let Some(mut notes) = delivery.notes.take() {
            report.degraded.append(&mut notes.degraded);
            report.lost_lines.append(&mut notes.lost_lines);
            bare.append(&mut notes.bare);
            rows.note(*notes);
        }
        rows.take(delivery);
    }
    report.batches = report.tiles - bare.len();
    report.workers.sort_unstable_by_key(|metrics| metrics.worker);
    if let Feed::Views { evicted, .. } = feed {
        report.evicted = evicted.len();
    }
    rows.lines.sort_by_key(|l| (l.part, l.edge));
    report.degraded.sort_unstable_by_key(|d| (d.part, d.tile));
    report.lost_lines.sort_unstable_by_key(|l| (l.part, l.edge));
    report.fills = by_face(&mut rows.fills);
    report.slivers = report.fills.iter().map(|fill| u64::from(fill.slivers)).sum();
    let all = match feed {
        Feed::All(_, seats) => Some((scene, seats)),
        Feed::Views { .. } => None,
    };
    (report.rungs, report.ladder) = climbed(all, bare, &rows.rungs);
    // A sink that panics has refused: the session goes on, with a whole frame.
    let fed = catch_unwind(AssertUnwindSafe(|| rows.feed(scene, seats, (report.whole, feed), (writer, sink))));
    let fed = fed.unwrap_or_else(|panic| Err(sink_panicked(&*panic)));
    if let Err(error) = fed {
        if let Some(writer) = writer {
            let left = rows.written.iter().flatten().skip(rows.taken);
            // The sink must hear of the end whatever its memory does.
            let _ = catch_unwind(AssertUnwindSafe(|| writer.release(left)));
        }
        // Whatever it does now, the frame is over, and its batches go.
        let _ = catch_unwind(AssertUnwindSafe(|| sink.abort()));
        rows.clear();
        return Err(error);
    }
    report.committed_in = laps.lap();
    Ok(report)
}

impl Rows {
    fn clear(&mut self) {
        self.batches.clear();
        self.written.clear();
        self.lines.clear();
        self.made.clear();
        self.rungs.clear();
        self.fills.clear();
        self.taken = 0;
    }

    /// The tiles that were made.
    pub(super) fn made(&self) -> impl Iterator<Item = MadeTile> {
        let of_batches = self.made.iter().flatten().copied();
        of_batches.chain(self.written.iter().flatten().map(MadeTile::of))
    }

    /// Takes what is fed of a delivery, but for its notes.
    fn take(&mut self, mut delivery: Delivery) {
        let worker = delivery.metrics.worker as usize;
        if self.batches.len() <= worker {
            self.batches.resize_with(worker + 1, Vec::new);
            self.written.resize_with(worker + 1, Vec::new);
        }
        self.batches[worker] = delivery.batches;
        self.written[worker] = delivery.written.take();
        self.made.push(delivery.made);
    }

    /// Takes what is fed of notes.
    fn note(&mut self, mut notes: Notes) {
        self.lines.append(&mut notes.lines);
        self.rungs.append(&mut notes.rungs);
        self.fills.append(&mut notes.fills);
    }

    fn feed(
        &mut self,
        scene: &Scene,
        seats: &[Seat],
        (whole, feed): (bool, Feed<'_>),
        (writer, sink): (Option<&Writer>, &mut dyn MeshSink),
    ) -> Result<(), FrameError> {
        match feed {
            Feed::Views { whole: false, changes, from: Some(from), .. } => sink.begin_update(scene, &changes, from),
            Feed::Views { whole: false, changes, from: None, .. } => sink.begin_changes(scene, &changes),
            _ => sink.begin(scene),
        }?;
        let gone = match feed {
            Feed::Views { evicted, .. } => evicted,
            Feed::All(..) => &[],
        };
        match writer {
            Some(writer) => self.send_written(gone, (feed, writer), sink)?,
            None => self.send_batches(seats, gone, (whole, feed), sink)?,
        }
        for line in self.lines.drain(..) {
            feed.goes_on()?;
            sink.edge_line(line)?;
        }
        feed.goes_on()?;
        if let Feed::Views { drawn: [drawn, before], .. } = feed {
            sink.drawn(drawn, before)?;
        }
        Ok(sink.end()?)
    }

    /// Tells the sink which tiles are gone, and gives it those of each worker.
    fn send_written(
        &mut self,
        gone: Gone<'_>,
        (feed, writer): (Feed<'_>, &Writer),
        sink: &mut dyn MeshSink,
    ) -> Result<(), FrameError> {
        let gone = gone.iter().map(|&(part, tile, face)| WrittenTile::gone((part, face, tile), writer.layout()));
        // They have no room that could be given back.
        give(&gone.collect::<Vec<_>>(), &mut 0, sink)?;
        for tiles in &self.written {
            feed.goes_on()?;
            give(tiles, &mut self.taken, sink)?;
        }
        Ok(())
    }

    /// Gives the sink the batches of all seats, each after the tiles before it that are gone. A whole frame has no need
    /// of batches without triangles.
    fn send_batches(
        &mut self,
        seats: &[Seat],
        mut gone: Gone<'_>,
        (whole, feed): (bool, Feed<'_>),
        sink: &mut dyn MeshSink,
    ) -> Result<(), FrameError> {
        for seats in seats.chunks(FETCHED) {
            self.fetch(seats);
            for seat in seats {
                for batch in &mut self.batches[seat.worker as usize][seat.rows()] {
                    feed.goes_on()?;
                    if !gone.is_empty() {
                        evict(before(&mut gone, (batch.part, batch.tile)), sink)?;
                    }
                    if !whole || !batch.mesh.triangles.is_empty() {
                        sink.batch(batch)?;
                    }
                }
            }
        }
        evict(gone, sink)
    }

    /// Reads the batches of some seats: the processor waits for many at the same time here, and for one at a time in
    /// the sink.
    fn fetch(&self, seats: &[Seat]) {
        let of_mesh = |mesh: &TileMesh| mesh.positions.len() ^ mesh.triangles.len();
        let of_batch = |batch: &Batch| batch.tile.0 as usize ^ of_mesh(&batch.mesh);
        let batches = seats.iter().flat_map(|seat| &self.batches[seat.worker as usize][seat.rows()]);
        black_box(batches.map(of_batch).fold(0, |a, b| a ^ b));
    }
}

/// Tiles to evict from the sink, ascending.
type Gone<'a> = &'a [(PartId, TileId, FaceId)];

/// Takes those before `tile`.
fn before<'a>(gone: &mut Gone<'a>, tile: (PartId, TileId)) -> Gone<'a> {
    let count = gone.iter().take_while(|(part, evicted, _)| (*part, *evicted) < tile).count();
    let (before, others) = gone.split_at(count);
    *gone = others;
    before
}

/// Tiles that a sink takes. Counts them, also if it panics.
struct Taking<'a> {
    left: Iter<'a, WrittenTile>,
    taken: &'a mut usize,
}

impl Drop for Taking<'_> {
    fn drop(&mut self) {
        // A sink may leave more than it was given.
        *self.taken = self.taken.saturating_sub(self.left.len());
    }
}

/// Gives the sink written tiles, if there are any. Adds those that it takes to `taken`.
fn give(tiles: &[WrittenTile], taken: &mut usize, sink: &mut dyn MeshSink) -> Result<(), FrameError> {
    if tiles.is_empty() {
        return Ok(());
    }
    *taken += tiles.len();
    let mut taking = Taking { left: tiles.iter(), taken };
    sink.written(&mut taking.left)?;
    match taking.left.len() {
        0 => Ok(()),
        left => {
            let context = format!("{left} of {} written tiles were left by the sink", tiles.len());
            Err(SinkError::new(context, std::io::ErrorKind::InvalidInput).into())
        }
    }
}

/// Tells a sink of batches that tiles are gone.
fn evict(tiles: Gone<'_>, sink: &mut dyn MeshSink) -> Result<(), FrameError> {
    for &(part, tile, face) in tiles {
        let mut batch = Batch { part, face, tile, worker: 0, mesh: TileMesh::default() };
        sink.batch(&mut batch)?;
    }
    Ok(())
}

/// The error of a sink that panicked.
pub(super) fn sink_panicked(payload: &(dyn Any + Send)) -> FrameError {
    let cause = std::io::Error::other(panic_message(payload));
    SinkError::new("the sink panicked", cause).into()
}

/// Why a tile could not be written, if any could not. The frame must then be dropped before the sink hears of it.
pub(super) fn refusal(deliveries: &mut [Delivery]) -> Option<FrameError> {
    let notes = deliveries.iter_mut().filter_map(|delivery| delivery.notes.as_mut());
    let refused = notes.filter_map(|notes| notes.refused.take());
    // The first one, whoever made it.
    let (_, _, why) = refused.min_by_key(|&(part, tile, _)| (part, tile))?;
    Some(match why {
        NotWritten::Sink(error) => error.into(),
        NotWritten::Grid(error) => error.into(),
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

/// The worst rung of each face that left the normal path, and the number of faces per rung. `all`: the scene and its
/// seats, if all of it was made; then all faces are counted. `bare`: the faces of the tiles without triangles.
fn climbed(all: Option<(&Scene, &Seats)>, bare: Vec<(PartId, FaceId)>, tiles: &[FaceRung]) -> (Vec<FaceRung>, Ladder) {
    let scene = all.map(|(scene, _)| scene);
    let of_all = |(scene, seats): (&Scene, &Seats)| {
        let parts = scene.parts.len();
        (seats.faces(parts), seats.without_triangles(parts, bare))
    };
    let (faces, empty) = all.map(of_all).unwrap_or_default();
    let has_no_area = |part: PartId, face: FaceId| scene.is_some_and(|scene| scene.has_no_area(part, face));
    // A tile without area does not affect a face that has other tiles.
    let is_vanished = |tile: &&FaceRung| tile.rung == Rung::NoArea;
    let mut vanished: Vec<_> = tiles.iter().filter(is_vanished).map(|tile| (tile.part, tile.face)).collect();
    vanished.sort_unstable();
    let left = tiles.iter().filter(|tile| !is_vanished(tile)).map(|&FaceRung { part, face, rung }| {
        let rung = if has_no_area(part, face) { Rung::NoArea } else { rung };
        FaceRung { part, face, rung }
    });
    let empty = empty.into_iter().map(|(part, face)| {
        let no_area = has_no_area(part, face) || vanished.binary_search(&(part, face)).is_ok();
        FaceRung { part, face, rung: if no_area { Rung::NoArea } else { Rung::Lost } }
    });
    let mut worst: Vec<FaceRung> = left.chain(empty).collect();
    worst.sort_unstable_by_key(|tile| (tile.part, tile.face, Reverse(tile.rung)));
    worst.dedup_by_key(|tile| (tile.part, tile.face));
    let mut ladder = Ladder::default();
    worst.iter().for_each(|face| ladder.add(face.rung, 1));
    ladder.add(Rung::Normal, faces.saturating_sub(worst.len()) as u64);
    (worst, ladder)
}
