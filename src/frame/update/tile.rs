//! A tile's cache and a new plan -> the tile by that plan, updated incrementally (Kumar and Manocha 1995, §5.2):
//! samples, crossings and triangles away from changes are reused.
//!
//! Vertices, boundary edges and area are those of the tile rebuilt from scratch. How its inside is cut into triangles
//! may depend on the cache. Doubtful cases are rebuilt from scratch.

use super::cells::{AgainScratch, CellCache, CellMapping, strips};
use super::samples::SampleCache;
use super::weave::{LoopMapping, Weave, WeaveScratch};
use crate::frame::plan::output::Plan;
use crate::frame::tile::job::{Job, Trimmed, tessellate_tile};
use crate::frame::tile::outcome::TileOutcome;
use crate::frame::trim::input::{NONE, TrimInput};
use crate::frame::trim::output::{TrimOutcome, TrimStats};
use crate::frame::vertices::boundary::trace_loops;
use crate::frame::vertices::places::evaluate_vertices;
use crate::frame::vertices::scratch::Scratch;
use crate::mesh::TileMesh;
use crate::model::{PartId, SurfaceKind, TileId};
use crate::prepare::Prepared;

/// What tiles cache and reuse when they change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Reuse {
    /// Positions and normals of tessellants and lattice points that stay.
    pub samples: bool,
    /// Crossings of segments with lattice lines where both stay (§5.2.1).
    pub trace: bool,
    /// Triangles with no change next to them (§5.2.2).
    pub triangles: bool,
    /// Also in tiles where reuse is not faster (docs/decisions/027), or not measured to be.
    pub everywhere: bool,
}

impl Reuse {
    /// Reuses nothing: every tile is a function of model and plan alone.
    pub const NONE: Self = Self { samples: false, trace: false, triangles: false, everywhere: false };
    /// Reuses everything, for tests and measurements.
    pub const ALL: Self = Self { samples: true, trace: true, triangles: true, everywhere: true };
    /// Reuses what is faster to reuse than to rebuild (docs/decisions/027).
    pub const DEFAULT: Self = Self { samples: true, trace: false, triangles: true, everywhere: false };
}

impl Default for Reuse {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Cache of one tile for incremental updates. Empty by default.
#[derive(Default)]
pub struct TileCache {
    /// Whether there are samples.
    holds: bool,
    samples: SampleCache,
    triangles: Triangles,
    outcome: TrimOutcome,
    stats: TrimStats,
}

/// Cached triangles of a tile.
#[derive(Default)]
enum Triangles {
    #[default]
    None,
    /// Of a single cell, as made by the trim stage.
    OneCell(Vec<[u32; 3]>),
    /// Of a single cell, with adjacency, after an incremental update.
    Weave(Weave),
    /// Of a lattice, cell by cell.
    CellCache(CellCache),
}

impl TileCache {
    /// Size of the cache, bytes. 0 if nothing is cached, as for tiles that are faster to rebuild.
    #[must_use]
    pub fn bytes(&self) -> usize {
        if !self.holds {
            return 0;
        }
        let triangles = match &self.triangles {
            Triangles::None => 0,
            Triangles::OneCell(triangles) => size_of::<[u32; 3]>() * triangles.capacity(),
            Triangles::Weave(weave) => weave.bytes(),
            Triangles::CellCache(cells) => cells.bytes(),
        };
        size_of::<Self>() + self.samples.bytes() + triangles
    }

    /// Triangulates the loops in the scratch from cached triangles. Returns the outcome and the number of new
    /// triangles, which come first. `None` if the tile has to be rebuilt.
    fn trim(
        &mut self,
        (job, reuse): (&Job<'_>, Reuse),
        from: &[u32],
        (s, b): (&mut Scratch, &mut Buffers),
        mesh: &TileMesh,
    ) -> Option<(TrimOutcome, usize)> {
        let (cells, places) = (job.lattice.cells(), &mesh.positions[..]);
        let tile = TrimInput { cells, points: &s.cells, loop_starts: &s.loop_starts, places };
        let old_starts = &self.samples.loop_starts[..];
        let (old, new) = (*old_starts.last()? as usize, from.iter().filter(|&&v| v == NONE).count());
        let changed = new.max(old + new - from.len());
        let is_little = reuse.everywhere || 100 * changed <= MOST_CHANGED * old.max(from.len());
        let mut weave = match std::mem::take(&mut self.triangles) {
            Triangles::CellCache(kept) => {
                let Buffers { columns, rows, again, .. } = b;
                let [us, vs] = self.samples.lines();
                strips(us, &job.lattice.us, columns);
                strips(vs, &job.lattice.vs, rows);
                let moved = CellMapping { tile, old_starts, from, columns, rows };
                let made = kept.again(&moved, (&mut s.trim, again), (reuse.trace, reuse.triangles), &mut s.trimmed);
                // Put back, so that its memory is reused.
                self.triangles = Triangles::CellCache(kept);
                let (outcome, fresh) = made?;
                s.trimmed.stats.outcome = outcome;
                // With a stricter chord than before, reused triangles have to be checked again.
                let holds = job.lattice.chord >= self.samples.chord();
                return Some((outcome, if holds { fresh } else { usize::MAX }));
            }
            Triangles::OneCell(triangles) if is_little => Weave::of(&triangles, old_starts)?,
            Triangles::Weave(weave) if is_little => weave,
            _ => return None,
        };
        let changed = LoopMapping { tile, old_starts, from };
        weave.update(&changed, &mut s.trim, &mut b.weave)?;
        s.trimmed.reset(self.stats);
        s.trimmed.triangles.extend_from_slice(&weave.triangles);
        self.triangles = Triangles::Weave(weave);
        Some((self.outcome, usize::MAX))
    }

    /// Caches the trim stage's triangles if they can be updated later.
    fn keep_triangles(
        &mut self,
        job: &Job<'_>,
        reuse: Reuse,
        (outcome, patched): (TrimOutcome, bool),
        (s, b): (&Scratch, &Buffers),
    ) {
        let cells = job.lattice.cells();
        let one_cell = cells == (1, 1);
        if job.tile.entangled || matches!(outcome, TrimOutcome::Repaired { .. }) {
            self.triangles = Triangles::None;
        } else if one_cell && job.face.kind == SurfaceKind::Plane && reuse.triangles {
            if !patched {
                self.triangles = Triangles::OneCell(s.trimmed.triangles.clone());
            }
        } else if !one_cell && (reuse.triangles || reuse.trace) {
            let mut kept = match std::mem::take(&mut self.triangles) {
                Triangles::CellCache(kept) => kept,
                _ => CellCache::default(),
            };
            let tile = TrimInput { cells, points: &s.cells, loop_starts: &s.loop_starts, places: &[] };
            if kept.keep((&s.trim, patched.then_some(&b.again)), &tile, &s.trimmed) {
                self.triangles = Triangles::CellCache(kept);
            }
        } else {
            self.triangles = Triangles::None;
        }
    }
}

/// Most changed tessellants of a plane, percent. Beyond that, an update costs as much as a rebuild.
const MOST_CHANGED: usize = 50;
/// Fewest lattice points of a cached tile. Smaller ones are rebuilt as fast as updated.
const LEAST_LATTICE: usize = 256;

/// Work space of [`update_tile`]. Does not affect results.
#[derive(Default)]
pub struct UpdateScratch {
    tile: Scratch,
    buffers: Buffers,
}

impl UpdateScratch {
    /// As [`Scratch::reuse`].
    pub fn reuse(&mut self, mesh: TileMesh) {
        self.tile.reuse(mesh);
    }

    /// The work space for [`tessellate_tile`].
    pub fn tile(&mut self) -> &mut Scratch {
        &mut self.tile
    }
}

/// Additional work space for updates.
#[derive(Default)]
struct Buffers {
    from: Vec<u32>,
    columns: Vec<u32>,
    rows: Vec<u32>,
    weave: WeaveScratch,
    again: AgainScratch,
}

/// Tessellates one tile by a plan as [`tessellate_tile`] does, but incrementally from its cache `memory`. Updates the
/// cache for the next call. The cache must be empty or come from the same tile of the same model.
///
/// Vertices (bit by bit), the order of the tessellants, the boundary edges and the area in (u,v) are the same as by
/// [`tessellate_tile`]. The order of lattice points and, in planes, how triangles join the vertices depend on earlier
/// calls.
#[must_use]
pub fn update_tile(
    (prepared, plan): (&Prepared, &Plan),
    (part, tile): (PartId, TileId),
    reuse: Reuse,
    memory: &mut TileCache,
    scratch: &mut UpdateScratch,
) -> TileOutcome {
    let job = Job::of(prepared, plan, part, tile);
    let UpdateScratch { tile: scratch, buffers } = scratch;
    if reuse == Reuse::NONE {
        *memory = TileCache::default();
        return tessellate_tile(prepared, plan, part, tile, scratch);
    }
    let mut mesh = scratch.spare();
    let mut from = std::mem::take(&mut buffers.from);
    let is_known = std::mem::take(&mut memory.holds);
    let mut trimmed = None;
    if is_known {
        let row = (job.part, job.plan, job.tile, &**job.lattice, job.face);
        memory.samples.trace_loops(row, reuse.samples, &mut from, scratch, &mut mesh);
        trimmed = memory.trim((&job, reuse), &from, (scratch, buffers), &mesh);
    } else {
        trace_loops(job.part, job.plan, job.tile, job.lattice, job.face, scratch, &mut mesh);
    }
    let patched = trimmed.is_some();
    let (trimmed, fresh) = match trimmed {
        Some((outcome, fresh)) => (Trimmed::By(outcome), fresh),
        None => (job.trim(scratch, &mesh), usize::MAX),
    };
    let outcome = scratch.trimmed.stats.outcome;
    let keeps = is_kept(&job, reuse, &scratch.trimmed.stats);
    if keeps {
        memory.keep_triangles(&job, reuse, (outcome, patched), (scratch, buffers));
    }
    let (face, lattice) = (job.face, &**job.lattice);
    let (made, as_trimmed) = if is_known && reuse.samples {
        let vertices = |_: usize, s: &mut Scratch, mesh: &mut TileMesh| {
            memory.samples.find_corners(lattice, s, &mut from);
            memory.samples.evaluate(face, lattice, &from, s, mesh);
            fresh
        };
        job.finish(trimmed, vertices, scratch, mesh)
    } else {
        let vertices = |corners_used: usize, s: &mut Scratch, mesh: &mut TileMesh| {
            evaluate_vertices(face, lattice, corners_used, s, mesh);
            usize::MAX
        };
        job.finish(trimmed, vertices, scratch, mesh)
    };
    buffers.from = from;
    if !keeps {
        *memory = TileCache::default();
        return made;
    }
    if !as_trimmed {
        memory.triangles = Triangles::None;
    }
    (memory.outcome, memory.stats) = (outcome, scratch.trimmed.stats);
    let is_plane = job.face.kind == SurfaceKind::Plane;
    memory.samples.keep((job.plan, job.tile, job.lattice, is_plane), scratch, &made.mesh);
    memory.holds = true;
    made
}

/// Whether a tile that was just made is worth caching: planes that needed a cluster, and large lattices.
fn is_kept(job: &Job<'_>, reuse: Reuse, stats: &TrimStats) -> bool {
    if reuse.everywhere {
        true
    } else if job.lattice.cells() == (1, 1) {
        job.face.kind == SurfaceKind::Plane && (stats.clusters > 0 || stats.whole_tile)
    } else {
        job.lattice.us.len() * job.lattice.vs.len() >= LEAST_LATTICE
    }
}
