//! Deliveries of all workers -> one frame in the sink, in (part, tile) order whatever the number of workers.

use super::handoff::{DegradedTile, Delivery, FaceRung, LostLine};
use super::metrics::{Laps, WorkerMetrics};
use crate::frame::{Ladder, Rung};
use crate::mesh::{Batch, MeshSink, Scene, SinkError};
use crate::model::{FaceId, PartId};
use crossbeam::channel::Receiver;
use std::collections::BTreeMap;
use std::fmt;
use std::time::Duration;

/// A committed frame.
#[derive(Clone, Debug, Default)]
pub struct FrameReport {
    /// Number of the frame within its session, from 0.
    pub frame: u64,
    /// Tiles with triangles.
    pub batches: usize,
    /// Triangles of all batches, each part counted once.
    pub triangles: u64,
    /// Tiles that came out less than as stated, ascending by (part, tile).
    pub degraded: Vec<DegradedTile>,
    /// Faces off the normal path, ascending by (part, face); those without triangles are among them.
    pub rungs: Vec<FaceRung>,
    /// All faces by the rung that they needed, each part counted once.
    pub ladder: Ladder,
    /// Edges without polyline, ascending by (part, edge).
    pub lost_lines: Vec<LostLine>,
    /// What each worker did, by number.
    pub workers: Vec<WorkerMetrics>,
    /// From the order to the last delivery.
    pub made_in: Duration,
    /// From there until the sink had everything.
    pub committed_in: Duration,
}

/// Why a frame was not committed. The sink has been told to abort if it had begun.
#[derive(Debug)]
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

/// Takes worker by worker what belongs to `frame`; a late delivery of an earlier frame is dropped.
pub(super) fn gather(queues: &[Receiver<Delivery>], frame: u64) -> Result<Vec<Delivery>, FrameError> {
    let mut deliveries = Vec::with_capacity(queues.len());
    for (worker, queue) in queues.iter().enumerate() {
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

/// Feeds the sink with a frame that all workers have reported: `begin`, batches by (part, tile), edge lines by
/// (part, edge), `end`; `abort` after the first refusal. `laps` started with the order.
pub(super) fn commit(
    deliveries: Vec<Delivery>,
    scene: &Scene,
    sink: &mut dyn MeshSink,
    mut laps: Laps,
) -> Result<FrameReport, FrameError> {
    let _span = tracing::debug_span!("commit").entered();
    let mut report = FrameReport { made_in: laps.lap(), ..FrameReport::default() };
    let (mut batches, mut lines, mut rungs) = (Vec::new(), Vec::new(), Vec::new());
    for delivery in deliveries {
        report.frame = delivery.frame;
        report.triangles += delivery.metrics.triangles;
        report.workers.push(delivery.metrics);
        report.degraded.extend(delivery.degraded);
        report.lost_lines.extend(delivery.lost_lines);
        rungs.extend(delivery.rungs);
        batches.extend(delivery.batches);
        lines.extend(delivery.lines);
    }
    // The keys are unique: no ties that the number of workers could decide.
    batches.sort_unstable_by_key(|b| (b.part, b.tile));
    lines.sort_unstable_by_key(|l| (l.part, l.edge));
    report.degraded.sort_unstable_by_key(|d| (d.part, d.tile));
    report.lost_lines.sort_unstable_by_key(|l| (l.part, l.edge));
    report.batches = batches.len();
    (report.rungs, report.ladder) = climbed(scene, &batches, rungs);
    let fed = sink
        .begin(scene)
        .and_then(|()| batches.iter_mut().try_for_each(|batch| sink.batch(batch)))
        .and_then(|()| lines.into_iter().try_for_each(|line| sink.edge_line(line)))
        .and_then(|()| sink.end());
    if let Err(error) = fed {
        sink.abort();
        return Err(FrameError::Sink(error));
    }
    report.committed_in = laps.lap();
    Ok(report)
}

/// The worst rung of each face that left the normal path, and all faces counted by rung.
fn climbed(scene: &Scene, batches: &[Batch], tiles: Vec<FaceRung>) -> (Vec<FaceRung>, Ladder) {
    let mut worst: BTreeMap<(PartId, FaceId), Rung> = BTreeMap::new();
    for tile in tiles {
        let rung = worst.entry((tile.part, tile.face)).or_default();
        *rung = tile.rung.max(*rung);
    }
    let mut meshed: Vec<Vec<bool>> = scene.parts.iter().map(|part| vec![false; part.face_colours.len()]).collect();
    for batch in batches {
        if let Some(meshed) = meshed.get_mut(batch.part.index()).and_then(|part| part.get_mut(batch.face.index())) {
            *meshed = true;
        }
    }
    for (part, faces) in meshed.iter().enumerate() {
        for (face, _) in faces.iter().enumerate().filter(|(_, meshed)| !**meshed) {
            let face = FaceId::new(face);
            let no_area = scene.parts[part].without_area.binary_search(&face).is_ok();
            worst.insert((PartId::new(part), face), if no_area { Rung::NoArea } else { Rung::Lost });
        }
    }
    let mut ladder = Ladder::default();
    worst.values().for_each(|rung| ladder.add(*rung, 1));
    let faces: usize = meshed.iter().map(Vec::len).sum();
    ladder.add(Rung::Normal, faces.saturating_sub(worst.len()) as u64);
    (worst.into_iter().map(|((part, face), rung)| FaceRung { part, face, rung }).collect(), ladder)
}
