//! One tile as it was and a plan -> the same tile by that plan, patched up where little of it changed (Kumar and Manocha 1995,
//! §5.2): samples, crossings and triangles far from what changed are kept.
//!
//! Vertices, boundary edges and area are those of the tile made from nothing; how the inside is cut into triangles depends on
//! what was there before. What is doubtful is made from nothing.

use super::plan::Plan;
use super::samples::Samples;
use super::tile::{Job, Kept, Scratch, TileOutcome, tessellate_tile, trace_loops};
use super::trim::again::{Cells, Moved, strips};
use super::trim::weave::{Changed, Weave, WeaveScratch};
use super::trim::{TrimInput, TrimOutcome, TrimStats};
use crate::mesh::TileId;
use crate::model::{PartId, SurfaceKind};
use crate::prepare::{EdgeUse, Prepared};

/// What of tiles that change is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Patch {
    /// Places and normals of the tessellants and lattice points that were there before.
    pub samples: bool,
    /// Crossings of segments with lattice lines where both were there before (§5.2.1).
    pub trace: bool,
    /// Triangles beside which nothing changed (§5.2.2).
    pub triangles: bool,
    /// Also of tiles where keeping is not faster (docs/decisions/027), or has not been measured to be.
    pub everywhere: bool,
}

impl Patch {
    /// Nothing: every tile is a function of model and plan alone.
    pub const NONE: Self = Self { samples: false, trace: false, triangles: false, everywhere: false };
    /// All of it, for tests and to measure.
    pub const ALL: Self = Self { samples: true, trace: true, triangles: true, everywhere: true };
    /// What is faster (docs/decisions/027).
    pub const DEFAULT: Self = Self { samples: true, trace: true, triangles: true, everywhere: false };
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
    /// Of a lattice, cell by cell.
    Cells(Cells),
}

impl TileMemory {
    /// Bytes that it holds.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let triangles = match &self.triangles {
            Triangles::None => 0,
            Triangles::OneCell(triangles) => size_of::<[u32; 3]>() * triangles.capacity(),
            Triangles::Weave(weave) => weave.bytes(),
            Triangles::Cells(cells) => cells.bytes(),
        };
        size_of::<Self>() + self.samples.bytes() + triangles
    }

    /// Triangulates the loops in the scratch, as far as it can be from what is kept. Returns how that went and how many triangles are
    /// new; `None` where all have to be made.
    fn trim(&mut self, job: &Job<'_>, patch: Patch, from: &[u32], s: &mut Scratch) -> Option<(TrimOutcome, usize)> {
        let cells = job.lattice.cells();
        let tile = TrimInput { cells, points: &s.cells, loop_starts: &s.loop_starts };
        let old_starts = &self.samples.loop_starts[..];
        let weave = match std::mem::take(&mut self.triangles) {
            Triangles::None => None,
            Triangles::OneCell(triangles) => Weave::of(&triangles, old_starts),
            Triangles::Weave(weave) => Some(weave),
            Triangles::Cells(cells) => {
                let PatchScratch { columns, rows, .. } = &mut s.patch;
                strips(&self.samples.lattice.us, &job.lattice.us, columns);
                strips(&self.samples.lattice.vs, &job.lattice.vs, rows);
                let moved = Moved { tile, old_starts, from, columns, rows };
                let again = s.trim.again(&cells, &moved, (patch.trace, patch.triangles), &mut s.trimmed);
                // Its memory is used again.
                self.triangles = Triangles::Cells(cells);
                let (outcome, fresh) = again?;
                s.trimmed.stats.outcome = outcome;
                // What is kept was held against another chord.
                return Some((
                    outcome,
                    if job.lattice.chord < self.samples.lattice.chord { usize::MAX } else { fresh },
                ));
            }
        };
        let mut weave = weave.filter(|_| cells == (1, 1))?;
        let changed = Changed { tile, old_starts, from };
        let most = if patch.everywhere { usize::MAX } else { weave.triangles.len() * MOST_TAKEN / 100 };
        weave.patch(&changed, most, &mut s.trim, &mut s.patch.weave)?;
        s.trimmed.reset(self.stats);
        s.trimmed.triangles.extend_from_slice(&weave.triangles);
        self.triangles = Triangles::Weave(weave);
        Some((self.outcome, usize::MAX))
    }

    /// Keeps triangles as the trim stage made them, if that is sound.
    fn keep_triangles(&mut self, job: &Job<'_>, patch: Patch, outcome: TrimOutcome, patched: bool, s: &mut Scratch) {
        let cells = job.lattice.cells();
        let one_cell = cells == (1, 1);
        if job.tile.entangled || matches!(outcome, TrimOutcome::Repaired { .. }) {
            self.triangles = Triangles::None;
        } else if one_cell && job.face.kind == SurfaceKind::Plane && patch.triangles {
            if !patched {
                self.triangles = Triangles::OneCell(s.trimmed.triangles.clone());
            }
        } else if !one_cell && patch.everywhere && (patch.triangles || patch.trace) {
            let mut kept = match std::mem::take(&mut self.triangles) {
                Triangles::Cells(kept) => kept,
                _ => Cells::default(),
            };
            let tile = TrimInput { cells, points: &s.cells, loop_starts: &s.loop_starts };
            if s.trim.keep(&tile, &s.trimmed, &mut kept) {
                self.triangles = Triangles::Cells(kept);
            }
        } else {
            self.triangles = Triangles::None;
        }
    }
}

/// Percent of the triangles of a plane that may be taken out: with more, what takes their place costs what all do.
const MOST_TAKEN: usize = 80;
/// Tessellants from which on a plane's triangles are kept: below, ears are cut faster than triangles are kept.
const LEAST_TESSELLANTS: usize = 48;
/// Vertices that a lattice has at least whose samples are kept.
const LEAST_LATTICE: usize = 256;

/// Work space of [`patch_tile`].
#[derive(Default)]
pub(super) struct PatchScratch {
    from: Vec<u32>,
    columns: Vec<u32>,
    rows: Vec<u32>,
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
    if patch == Patch::NONE || !is_kept(&job, patch) {
        *memory = TileMemory::default();
        return tessellate_tile(prepared, plan, part, tile, scratch);
    }
    let mut mesh = scratch.spare();
    let mut from = std::mem::take(&mut scratch.patch.from);
    let is_known = std::mem::take(&mut memory.holds);
    let mut trimmed = None;
    if is_known {
        let row = (job.part, job.plan, job.tile, &**job.lattice, job.face);
        memory.samples.trace_loops(row, patch.samples, &mut from, scratch, &mut mesh);
        trimmed = memory.trim(&job, patch, &from, scratch);
    } else {
        trace_loops(job.part, job.plan, job.tile, job.lattice, job.face, scratch, &mut mesh);
    }
    let patched = trimmed.is_some();
    let (outcome, fresh) = match trimmed.map_or_else(|| job.trim(scratch).map(|outcome| (outcome, usize::MAX)), Ok) {
        Ok(trimmed) => trimmed,
        Err(lost) => return lost,
    };
    memory.keep_triangles(&job, patch, outcome, patched, scratch);
    let mut kept = Kept { samples: &memory.samples, from: &mut from, fresh };
    let kept = (is_known && patch.samples).then_some(&mut kept);
    let (made, as_trimmed) = job.finish(outcome, kept, scratch, mesh);
    scratch.patch.from = from;
    if !as_trimmed {
        memory.triangles = Triangles::None;
    }
    (memory.outcome, memory.stats) = (outcome, scratch.trimmed.stats);
    memory.samples.keep((job.plan, job.tile, job.lattice), scratch, &made.mesh);
    memory.holds = true;
    made
}

/// Whether a tile is worth keeping.
fn is_kept(job: &Job<'_>, patch: Patch) -> bool {
    let cells = job.lattice.cells();
    if patch.everywhere {
        true
    } else if cells != (1, 1) {
        patch.samples && job.lattice.us.len() * job.lattice.vs.len() >= LEAST_LATTICE
    } else {
        let line = |u: &EdgeUse| &job.plan.edges[u.edge as usize].breaks;
        let count = |u: &EdgeUse| line(u)[u.from as usize].abs_diff(line(u)[u.to as usize]) as usize;
        let uses = job.tile.loops.iter().flatten();
        job.face.kind == SurfaceKind::Plane && uses.map(count).sum::<usize>() >= LEAST_TESSELLANTS
    }
}
