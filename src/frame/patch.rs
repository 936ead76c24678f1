//! One tile as it was and a plan -> the same tile by that plan, patched up where little of it changed (Kumar and Manocha 1995,
//! §5.2): samples, crossings and triangles far from what changed are kept.
//!
//! Vertices, boundary edges and area are those of the tile made from nothing; how the inside is cut into triangles depends on
//! what was there before. What is doubtful is made from nothing.

use super::plan::Plan;
use super::samples::Samples;
use super::tile::{Job, Kept, Scratch, TileOutcome, tessellate_tile, trace_loops};
use super::trim::weave::{Changed, Weave, WeaveScratch};
use super::trim::{TrimInput, TrimOutcome, TrimStats};
use crate::mesh::{PatchMesh, TileId};
use crate::model::{PartId, SurfaceKind};
use crate::prepare::Prepared;

/// What of tiles that change is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Patch {
    /// Places and normals of the tessellants and lattice points that were there before.
    pub samples: bool,
    /// Crossings of segments with lattice lines where both were there before (§5.2.1).
    pub trace: bool,
    /// Triangles beside which nothing changed (§5.2.2).
    pub triangles: bool,
}

impl Patch {
    /// Nothing: every tile is a function of model and plan alone.
    pub const NONE: Self = Self { samples: false, trace: false, triangles: false };
    /// All of it.
    pub const ALL: Self = Self { samples: true, trace: true, triangles: true };
    /// What is faster (docs/decisions/027).
    pub const DEFAULT: Self = Self { samples: true, trace: false, triangles: true };
}

impl Default for Patch {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What is kept of a tile to patch it up with. Empty to begin with.
#[derive(Default)]
pub struct TileMemory {
    /// There are samples.
    holds: bool,
    samples: Samples,
    triangles: Triangles,
    outcome: TrimOutcome,
    stats: TrimStats,
}

/// Triangles of a tile that may be kept.
#[derive(Default)]
enum Triangles {
    #[default]
    None,
    /// Of one cell, as they were made.
    OneCell(Vec<[u32; 3]>),
    /// Of one cell, with neighbours: it has been patched before.
    Weave(Weave),
}

impl TileMemory {
    /// Bytes that it holds.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let triangles = match &self.triangles {
            Triangles::None => 0,
            Triangles::OneCell(triangles) => size_of::<[u32; 3]>() * triangles.capacity(),
            Triangles::Weave(weave) => weave.bytes(),
        };
        size_of::<Self>() + self.samples.bytes() + triangles
    }

    /// Patches up the triangles of one cell, into the scratch.
    fn patch_one_cell(&mut self, job: &Job<'_>, from: &[u32], changed: usize, s: &mut Scratch) -> bool {
        if job.lattice.cells() != (1, 1) || changed > from.len() / LEAST_KEPT {
            return false;
        }
        let weave = match std::mem::take(&mut self.triangles) {
            Triangles::OneCell(triangles) => Weave::of(&triangles, &self.samples.loop_starts),
            Triangles::Weave(weave) => Some(weave),
            Triangles::None => None,
        };
        let Some(mut weave) = weave else { return false };
        let tile = TrimInput { cells: (1, 1), points: &s.cells, loop_starts: &s.loop_starts };
        let changed = Changed { tile, old_starts: &self.samples.loop_starts, from };
        let most = weave.triangles.len() / LEAST_KEPT;
        if weave.patch(&changed, most, &mut s.trim, &mut s.patch.weave).is_none() {
            return false;
        }
        s.trimmed.reset(self.stats);
        s.trimmed.triangles.extend_from_slice(&weave.triangles);
        self.triangles = Triangles::Weave(weave);
        true
    }
}

/// Of tessellants and triangles of a tile, one over this must stay at least.
const LEAST_KEPT: usize = 1;

/// Work space of [`patch_tile`].
#[derive(Default)]
pub(super) struct PatchScratch {
    from: Vec<u32>,
    weave: WeaveScratch,
}

/// Tessellates one tile under a plan as [`tessellate_tile`] does, but starts from what `memory` has of it (made by
/// another plan of the same model, from the same call), and leaves there what the next call starts from.
///
/// The vertices, which sides of triangles are the tile's boundary, and the area are the same as from nothing; so are order and bits
/// of the vertices. The triangles between them depend on the calls before.
#[must_use]
pub fn patch_tile(
    (prepared, plan): (&Prepared, &Plan),
    (part, tile): (PartId, TileId),
    patch: Patch,
    memory: &mut TileMemory,
    scratch: &mut Scratch,
) -> TileOutcome {
    let job = Job::of(prepared, plan, part, tile);
    if patch == Patch::NONE || !is_kept(&job) {
        *memory = TileMemory::default();
        return tessellate_tile(prepared, plan, part, tile, scratch);
    }
    let mut mesh = scratch.spare();
    let mut from = std::mem::take(&mut scratch.patch.from);
    let is_known = std::mem::take(&mut memory.holds);
    let mut patched = false;
    if is_known {
        let row = (job.part, job.plan, job.tile, &**job.lattice, job.face);
        let (new, gone) = memory.samples.trace_loops(row, patch.samples, &mut from, scratch, &mut mesh);
        patched = patch.triangles && memory.patch_one_cell(&job, &from, new.max(gone), scratch);
    } else {
        trace_loops(job.part, job.plan, job.tile, job.lattice, job.face, scratch, &mut mesh);
    }
    let trimmed = if patched { Ok(memory.outcome) } else { job.trim(scratch) };
    let outcome = match trimmed {
        Ok(outcome) => outcome,
        Err(lost) => return lost,
    };
    let mut kept = Kept { samples: &memory.samples, from: &mut from, fresh: usize::MAX };
    let kept = (is_known && patch.samples).then_some(&mut kept);
    let (made, as_trimmed) = job.finish(outcome, kept, scratch, mesh);
    scratch.patch.from = from;
    memory.remember(&job, patch, outcome, (patched, as_trimmed), scratch, &made.mesh);
    made
}

/// Whether a tile is worth keeping.
fn is_kept(_job: &Job<'_>) -> bool {
    true
}

impl TileMemory {
    fn remember(
        &mut self,
        job: &Job<'_>,
        patch: Patch,
        outcome: TrimOutcome,
        (patched, as_trimmed): (bool, bool),
        s: &mut Scratch,
        mesh: &PatchMesh,
    ) {
        self.samples.keep((job.plan, job.tile, job.lattice), s, mesh);
        self.holds = true;
        (self.outcome, self.stats) = (outcome, s.trimmed.stats);
        if patched {
            return;
        }
        let sound = as_trimmed && !job.tile.entangled && !matches!(outcome, TrimOutcome::Repaired { .. });
        let one_cell = job.lattice.cells() == (1, 1) && job.face.kind == SurfaceKind::Plane;
        self.triangles = if patch.triangles && sound && one_cell {
            Triangles::OneCell(s.trimmed.triangles.clone())
        } else {
            Triangles::None
        };
    }
}
