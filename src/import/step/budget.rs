//! What reading a file costs, counted by all threads, and its limits.

use crate::control::Control;
use crate::model::StepTrouble;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

/// Visits of shared items that files of any length may ask for.
const FREE_VISITS: usize = 4096;

/// Control points of curves and of surfaces that shared geometry may come to: so many per byte of the file, and a
/// constant. Files that share nothing have one per 30 bytes.
const POINTS_PER_BYTE: [usize; 2] = [1, 4];
const FREE_POINTS: [usize; 2] = [1 << 12, 1 << 13];

/// Placed parts and assemblies: so many per byte of the file, and a constant. Real files have one per 10 bytes or more.
const OCCURRENCES_PER_BYTE: u64 = 8;
const FREE_OCCURRENCES: u64 = 1 << 15;

/// Memory per control point, bytes: its coordinates, weight and knots, and the copy that becomes part of the model.
const BYTES_PER_POINT: usize = 64;

/// Counts of the whole file.
pub(super) struct ReadBudget {
    /// Length of the text, bytes.
    length: usize,
    /// Maximum memory, bytes.
    limit: u64,
    spent: AtomicU64,
    /// Control points of curves and of surfaces in parts.
    points: [AtomicUsize; 2],
    control: Control,
}

/// Geometry whose control points are counted.
#[derive(Clone, Copy)]
pub(super) enum Net {
    Curve,
    Surface,
}

impl ReadBudget {
    /// For a text of `length` bytes whose instances take `spent` bytes of memory. Nothing is left of it once `control`
    /// is cancelled.
    pub(super) fn new(length: usize, spent: u64, limit: u64, control: &Control) -> Self {
        Self { length, limit, spent: AtomicU64::new(spent), points: Default::default(), control: control.clone() }
    }

    /// How many items lists may name, each counted as often as lists lead to it.
    ///
    /// Lists without shared items stay below the length of the file. Lists of lists that share items grow as a power
    /// of it.
    pub(super) fn max_visits(&self) -> usize {
        self.length.saturating_add(FREE_VISITS)
    }

    /// How many parts and assemblies a file of this length may place. Assemblies of assemblies place as many as a power
    /// of its length.
    pub(super) fn max_occurrences(&self) -> u64 {
        (self.length as u64).saturating_mul(OCCURRENCES_PER_BYTE).saturating_add(FREE_OCCURRENCES)
    }

    /// Adds memory, before it is allocated. Returns whether all of it is within the limit.
    pub(super) fn spend(&self, bytes: usize) -> bool {
        let before = self.spent.fetch_add(bytes as u64, Ordering::Relaxed);
        before.saturating_add(bytes as u64) <= self.limit && !self.is_cancelled()
    }

    /// Whether reading is cancelled: what it makes from now on is not looked at.
    pub(super) fn is_cancelled(&self) -> bool {
        self.control.is_cancelled()
    }

    /// Memory needed so far, bytes, if that is beyond the limit. Reading can then stop.
    pub(super) fn exceeded(&self) -> Option<u64> {
        Some(self.spent.load(Ordering::Relaxed)).filter(|spent| *spent > self.limit)
    }

    /// What is counted so far: memory, and control points of curves and of surfaces.
    pub(super) fn so_far(&self) -> (u64, [usize; 2]) {
        (self.spent.load(Ordering::Relaxed), self.points.each_ref().map(|points| points.load(Ordering::Relaxed)))
    }

    /// Forgets what was counted since.
    pub(super) fn go_back(&self, (spent, points): (u64, [usize; 2])) {
        self.spent.store(spent, Ordering::Relaxed);
        self.points.iter().zip(points).for_each(|(now, then)| now.store(then, Ordering::Relaxed));
    }

    /// Whether [`net`](Self::net) refused points as too many. With several threads, their timing decides which.
    pub(super) fn has_refused_points(&self) -> bool {
        [Net::Curve, Net::Surface].into_iter().any(|net| self.so_far().1[net as usize] > self.max_points(net))
    }

    /// How many points of this kind a file of this length may come to.
    fn max_points(&self, net: Net) -> usize {
        let kind = net as usize;
        POINTS_PER_BYTE[kind].saturating_mul(self.length).saturating_add(FREE_POINTS[kind])
    }

    /// Adds `count` control points of a curve or surface. Once the limit is passed, or reading is cancelled, `count` 0
    /// fails, too: nothing more need be read.
    ///
    /// # Errors
    /// If geometry that edges or faces share comes to more points than a file of this length may have.
    pub(super) fn net(&self, net: Net, count: usize) -> Result<(), StepTrouble> {
        let (kind, limit) = (net as usize, self.max_points(net));
        let before = self.points[kind].fetch_add(count, Ordering::Relaxed);
        self.spend(count.saturating_mul(BYTES_PER_POINT));
        let what = ["points of shared curves", "points of shared surfaces"][kind];
        let passed = before.saturating_add(count) > limit || self.is_cancelled();
        if passed { Err(StepTrouble::TooManyVisits { what, limit }) } else { Ok(()) }
    }
}
