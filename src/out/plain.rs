//! A frame to the pieces of a file with every instance in world coordinates, made in runs on all threads, and to what
//! rounding costs.

use super::making::Making;
use super::placed::{Placement, cut, distinct, placed};
use super::rounding::{Rounding, RoundingCount};
use super::single::{BeyondSingle, single};
use crate::control::Call;
use crate::mesh::{BatchView, FrameView, SceneInstance};
use crate::model::FaceId;
use glam::{DAffine3, DVec3, Vec3};

/// Batches of an instance that follow each other.
pub(super) struct Run<'a> {
    call: Call<'a>,
    pub(super) instance: &'a SceneInstance,
    pub(super) placement: Placement,
    batches: &'a [&'a BatchView<'a>],
    /// The face of the batch before these, of the same instance.
    pub(super) before: Option<FaceId>,
    /// Number of vertices in the file before these.
    pub(super) first: u64,
}

impl Run<'_> {
    /// Rounds the positions of each batch by `round`, which also returns the distance, and passes them to `write` with
    /// the triangles whose corners stay apart, all of which it takes. Passes fewer, once cancelled.
    pub(super) fn round<P: PartialEq>(
        &self,
        round: impl Fn(DVec3) -> Result<(P, f64), BeyondSingle>,
        mut write: impl FnMut(&BatchView<'_>, &[P], &mut dyn Iterator<Item = [u32; 3]>),
    ) -> Result<RoundingCount, BeyondSingle> {
        let arithmetic = Arithmetic::of(&self.instance.transform);
        let (mut count, mut rounded) = (RoundingCount::default(), Vec::new());
        for batch in self.batches {
            rounded.clear();
            for &point in self.call.while_wanted(batch.mesh.positions.iter()) {
                let (position, moved) = round(self.placement.position(point))?;
                count.point(point, moved + arithmetic.moved(point));
                rounded.push(position);
            }
            let mut kept = 0;
            let triangles = self.call.while_wanted(distinct(&batch.mesh, &rounded)).inspect(|_| kept += 1);
            write(batch, &rounded, &mut triangles.map(|corners| self.placement.winding(corners)));
            count.triangles(batch.face, batch.mesh.triangles.len(), kept);
        }
        Ok(count)
    }
}

/// Number of tiles that [`pieces`] makes the bytes of.
pub(super) fn tiles(frame: &FrameView<'_>) -> usize {
    let by_part = frame.batches_by_part();
    placed(frame, &by_part).map(|(_, _, batches)| batches.len()).sum()
}

/// Calls `piece` with each run, and returns its results in order, with what rounding costs: none once cancelled. An
/// instance without batches has a run without any: there are files that name it.
pub(super) fn pieces<T: Default + Send>(
    making: &Making<'_>,
    frame: &FrameView<'_>,
    piece: impl Fn(&Run<'_>) -> Result<(T, RoundingCount), BeyondSingle> + Sync,
) -> Result<(Vec<T>, Rounding), BeyondSingle> {
    let by_part = frame.batches_by_part();
    let vertices = |batch: &&BatchView<'_>| batch.mesh.positions.len();
    let (mut runs, mut first) = (Vec::new(), 0);
    for (instance, placement, batches) in placed(frame, &by_part) {
        let mut before = None;
        for batches in cut(batches, vertices).chain(batches.is_empty().then_some(batches)) {
            runs.push(Run { call: making.call, instance, placement, batches, before, first });
            before = batches.last().map(|batch| batch.face);
            first += batches.iter().map(vertices).sum::<usize>() as u64;
        }
    }
    let made = making.call.each(1, &runs, |run| {
        if making.call.is_cancelled() {
            return Ok(Default::default());
        }
        let made = piece(run);
        making.made(run.batches.len());
        made
    });
    if making.call.is_cancelled() {
        making.call.discard(made);
        return Ok(Default::default());
    }
    let (mut pieces, mut rounding) = (Vec::with_capacity(runs.len()), Rounding::default());
    let mut count = RoundingCount::default();
    for (k, (run, made)) in runs.iter().zip(made).enumerate() {
        let (piece, of_run) = made?;
        pieces.push(piece);
        count.add(of_run);
        if runs.get(k + 1).is_none_or(|next| next.before.is_none()) {
            rounding.add_placed(run.instance, &std::mem::take(&mut count), &run.placement);
        }
    }
    Ok((pieces, rounding))
}

/// Rounds to single precision.
pub(super) fn to_single(exact: DVec3) -> Result<(Vec3, f64), BeyondSingle> {
    let rounded = single(exact)?;
    Ok((rounded, (rounded.as_dvec3() - exact).length()))
}

/// Keeps double precision.
pub(super) fn to_double(exact: DVec3) -> Result<(DVec3, f64), BeyondSingle> {
    Ok((exact, 0.0))
}

/// Bounds the error of transforming points in double precision.
struct Arithmetic {
    /// Error per length of a point, and of the translation.
    per_length: f64,
    translation: f64,
}

impl Arithmetic {
    fn of(transform: &DAffine3) -> Self {
        if *transform == DAffine3::IDENTITY {
            return Self { per_length: 0.0, translation: 0.0 };
        }
        // Three products and three sums, each rounded by half an epsilon.
        const ROUNDED: f64 = 4.0 * f64::EPSILON;
        let m = transform.matrix3;
        let norm = m.x_axis.length() + m.y_axis.length() + m.z_axis.length();
        Self { per_length: ROUNDED * norm, translation: ROUNDED * transform.translation.length() }
    }

    fn moved(&self, point: DVec3) -> f64 {
        self.per_length * point.length() + self.translation
    }
}
