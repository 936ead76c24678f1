//! Deliveries of all workers -> one frame in the sink, in (part, tile) order whatever the number of workers.

use super::handoff::{DegradedTile, Delivery, FaceFill, FaceRung, LostLine};
use super::metrics::{Laps, WorkerMetrics};
use crate::frame::{Ladder, Rung};
use crate::mesh::{Batch, Drawn, MeshSink, Scene, SinkError, TileMesh};
use crate::model::{FaceId, PartId, TileId};
use crossbeam_channel::Receiver;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::time::Duration;

/// A committed frame.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct FrameReport {
    /// Number of the frame within its session, from 0.
    pub frame: u64,
    /// Whether the sink got all there is, and not only what changed since the last frame.
    pub whole: bool,
    /// Tiles that were made.
    pub tiles: usize,
    /// Tiles with triangles that the sink got.
    pub batches: usize,
    /// Triangles of all batches, each part counted once.
    pub triangles: u64,
    /// Tiles whose triangles the sink was told to forget: out of the picture, and no more what the plan says.
    pub forgotten: usize,
    /// Tiles that should have changed their rates and wait for the next frame, because the budget was spent.
    pub deferred: u32,
    /// Tiles that came out less than as stated, ascending by (part, tile).
    pub degraded: Vec<DegradedTile>,
    /// Faces off the normal path, ascending by (part, face); in whole frames made without a view, those without triangles are among
    /// them.
    pub rungs: Vec<FaceRung>,
    /// All faces by the rung that they needed, each part counted once; in frames of views, those made that left the normal path.
    pub ladder: Ladder,
    /// Triangles that only close boundaries, each part counted once.
    pub slivers: u64,
    /// Faces that hold such triangles, or are wound otherwise than once, ascending by (part, face).
    pub fills: Vec<FaceFill>,
    /// Edges without polyline, ascending by (part, edge).
    pub lost_lines: Vec<LostLine>,
    /// What each worker did, by number; those that had nothing to do are left out.
    pub workers: Vec<WorkerMetrics>,
    /// What the master took to make the plan; nothing where it was given.
    pub planned_in: Duration,
    /// From the order to the last delivery.
    pub made_in: Duration,
    /// From there until the sink had everything.
    pub committed_in: Duration,
}

/// Why a frame was not committed. The sink has been told to abort if it had begun.
#[derive(Debug)]
#[non_exhaustive]
pub enum FrameError {
    /// The sink refused.
    Sink(SinkError),
    /// A worker's thread is gone: the session is over.
    WorkerLost {
        /// Its number.
        worker: usize,
    },
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sink(error) => error.fmt(f),
            Self::WorkerLost { worker } => write!(f, "the thread of worker {worker} ended before its frame was made"),
        }
    }
}

impl std::error::Error for FrameError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Sink(error) => Some(error),
            Self::WorkerLost { .. } => None,
        }
    }
}

/// Takes from each worker that was asked what belongs to `frame`; a late delivery of an earlier frame is dropped.
pub(super) fn gather(queues: &[Receiver<Delivery>], asked: &[bool], frame: u64) -> Result<Vec<Delivery>, FrameError> {
    let mut deliveries = Vec::with_capacity(queues.len());
    for (worker, queue) in queues.iter().enumerate().filter(|(worker, _)| asked[*worker]) {
        let delivery = loop {
            let delivery = queue.recv().map_err(|_| FrameError::WorkerLost { worker })?;
            if delivery.frame == frame {
                break delivery;
            }
        };
        deliveries.push(delivery);
    }
    Ok(deliveries)
}

/// What a sink gets beside what the workers made.
#[derive(Clone, Copy)]
pub(super) enum Feed<'a> {
    /// Everything there is, and all of it is drawn.
    All,
    /// What is drawn for views.
    Views {
        /// Whether the sink has nothing yet that holds.
        whole: bool,
        drawn: &'a Drawn,
        /// Tiles that it has and shall forget, ascending.
        forgotten: &'a [(PartId, TileId, FaceId)],
    },
}

/// Feeds the sink with a frame that all workers have reported: `begin`, batches by (part, tile), edge lines by
/// (part, edge), what is drawn, `end`; `abort` after the first refusal. `laps` started with the order. Returns what the sink left
/// of the batches, too.
pub(super) fn commit(
    deliveries: Vec<Delivery>,
    scene: &Scene,
    feed: Feed<'_>,
    sink: &mut dyn MeshSink,
    laps: &mut Laps,
) -> Result<(FrameReport, Vec<Batch>), FrameError> {
    let _span = tracing::debug_span!("commit").entered();
    let mut report = FrameReport { made_in: laps.lap(), ..FrameReport::default() };
    let (mut batches, mut lines, mut rungs) = (Vec::new(), Vec::new(), Vec::new());
    let mut fills = Vec::new();
    for delivery in deliveries {
        report.frame = delivery.frame;
        report.tiles += delivery.metrics.tiles as usize;
        report.triangles += delivery.metrics.triangles;
        report.workers.push(delivery.metrics);
        report.degraded.extend(delivery.degraded);
        report.lost_lines.extend(delivery.lost_lines);
        rungs.extend(delivery.rungs);
        fills.extend(delivery.fills);
        batches.extend(delivery.batches);
        lines.extend(delivery.lines);
    }
    report.batches = batches.iter().filter(|batch| !batch.mesh.triangles.is_empty()).count();
    if let Feed::Views { whole, forgotten, .. } = feed {
        if whole {
            batches.retain(|batch| !batch.mesh.triangles.is_empty());
        }
        let empty = |&(part, tile, face)| Batch { part, face, tile, worker: 0, mesh: TileMesh::default() };
        batches.extend(forgotten.iter().map(empty));
        report.forgotten = forgotten.len();
    }
    // The keys are unique: no ties that the number of workers could decide.
    batches.sort_unstable_by_key(|b| (b.part, b.tile));
    lines.sort_unstable_by_key(|l| (l.part, l.edge));
    report.degraded.sort_unstable_by_key(|d| (d.part, d.tile));
    report.lost_lines.sort_unstable_by_key(|l| (l.part, l.edge));
    report.fills = by_face(fills);
    report.slivers = report.fills.iter().map(|fill| u64::from(fill.slivers)).sum();
    let all = matches!(feed, Feed::All);
    report.whole = !matches!(feed, Feed::Views { whole: false, .. });
    (report.rungs, report.ladder) = climbed(all.then_some(scene), &batches, rungs);
    let begun = if report.whole { sink.begin(scene) } else { sink.begin_changes(scene) };
    let fed = begun
        .and_then(|()| batches.iter_mut().try_for_each(|batch| sink.batch(batch)))
        .and_then(|()| lines.into_iter().try_for_each(|line| sink.edge_line(line)))
        .and_then(|()| if let Feed::Views { drawn, .. } = feed { sink.drawn(drawn) } else { Ok(()) })
        .and_then(|()| sink.end());
    if let Err(error) = fed {
        sink.abort();
        return Err(FrameError::Sink(error));
    }
    report.committed_in = laps.lap();
    Ok((report, batches))
}

/// What faces hold, from what their tiles hold: in the order of the tiles, which decides how areas round.
fn by_face(mut tiles: Vec<(TileId, FaceFill)>) -> Vec<FaceFill> {
    tiles.sort_unstable_by_key(|(tile, fill)| (fill.part, *tile));
    let mut faces: BTreeMap<(PartId, FaceId), FaceFill> = BTreeMap::new();
    for (_, fill) in tiles {
        faces.entry((fill.part, fill.face)).and_modify(|sum| sum.add(&fill)).or_insert(fill);
    }
    faces.into_values().collect()
}

/// The worst rung of each face that left the normal path, and faces counted by rung: all faces of `scene`, if all of it was made.
fn climbed(scene: Option<&Scene>, batches: &[Batch], tiles: Vec<FaceRung>) -> (Vec<FaceRung>, Ladder) {
    let mut worst: BTreeMap<(PartId, FaceId), Rung> = BTreeMap::new();
    // A tile that vanishes is nothing to a face with other tiles.
    let (vanished, tiles): (Vec<_>, Vec<_>) = tiles.into_iter().partition(|tile| tile.rung == Rung::NoArea);
    let vanished: BTreeSet<(PartId, FaceId)> = vanished.iter().map(|tile| (tile.part, tile.face)).collect();
    let parts = scene.map_or(&[][..], |scene| &scene.parts);
    let has_no_area = |part: PartId, face: FaceId| {
        parts.get(part.index()).is_some_and(|part| part.without_area.binary_search(&face).is_ok())
    };
    for tile in tiles {
        let rung = if has_no_area(tile.part, tile.face) { Rung::NoArea } else { tile.rung };
        let worst = worst.entry((tile.part, tile.face)).or_default();
        *worst = rung.max(*worst);
    }
    let mut meshed: Vec<Vec<bool>> = parts.iter().map(|part| vec![false; part.face_colours.len()]).collect();
    for batch in batches {
        if let Some(meshed) = meshed.get_mut(batch.part.index()).and_then(|part| part.get_mut(batch.face.index())) {
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
