//! A tile and a plan -> its triangles, and everything that was decided on the way to them: what a diagram of it shows.

use super::job::tessellate_tile;
use super::outcome::TileOutcome;
use crate::frame::plan::planned::{Plan, TileLattice, cell_coordinate};
use crate::frame::trim::input::TrimInput;
use crate::frame::trim::output::TrimStats;
use crate::frame::trim::record::TrimRecord;
use crate::frame::vertices::boundary::cell_size;
use crate::frame::vertices::scratch::Scratch;
use crate::mesh::Origin;
use crate::model::{PartId, SurfaceKind, TileId};
use crate::prepare::Prepared;
use glam::DVec2;

/// How one tile was tessellated.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct TileRecord {
    /// What its face's surface was before it became Bézier pieces.
    pub kind: SurfaceKind,
    /// Whether the triangles look at the other side than (u,v) does.
    pub reversed: bool,
    /// Its lattice, in the parameters of its face's patches.
    pub lattice: TileLattice,
    /// What [`tessellate_tile`] returned.
    pub outcome: TileOutcome,
    /// Where the vertices of the mesh are, in cell units, tessellants first.
    pub places: Vec<DVec2>,
    /// Where each loop of tessellants starts, and after the last one how many there are.
    pub loop_starts: Vec<u32>,
    /// The upper corner of the tile in cell units; the lower one is the origin. Below 1 where a tile of one cell keeps the
    /// proportions that it has in space.
    pub extent: DVec2,
    /// Cells that were split by a diagonal.
    pub full_cells: Vec<[u32; 2]>,
    /// Counts of the trim stage.
    pub stats: TrimStats,
    /// What the trim stage decided.
    pub trim: TrimRecord,
}

/// Tessellates one tile as [`tessellate_tile`] does, and reads from its work space how that went.
///
/// Frames pay nothing for it: the work space is there anyway, and is looked at afterwards. Cost: that of the tile, and about
/// as much again.
#[must_use]
pub fn record_tile(prepared: &Prepared, plan: &Plan, part: PartId, tile: TileId) -> TileRecord {
    let mut scratch = Scratch::default();
    let outcome = tessellate_tile(prepared, plan, part, tile, &mut scratch);
    let rows = &prepared.parts[part.index()];
    let row = &rows.tiles[tile.0 as usize];
    let face = &rows.faces[rows.face_of(row)];
    let lattice = TileLattice::clone(&plan.parts[part.index()].tiles[tile.0 as usize]);
    let cells = lattice.cells();
    let Scratch { cells: points, uvs, loop_starts, trim, trimmed, .. } = scratch;
    let input = TrimInput { cells, points: &points, loop_starts: &loop_starts, places: &[] };
    let trim = trim.record(&input, &trimmed.stats);
    let size = cell_size(face, row, &lattice);
    let extent = DVec2::new(f64::from(cells.0), f64::from(cells.1)) * size;
    let to_cells = |uv: DVec2| {
        let cell = DVec2::new(cell_coordinate(&lattice.us, uv.x), cell_coordinate(&lattice.vs, uv.y));
        cell * size
    };
    // Tessellants stand where the triangulation saw them; the others where their parameters are.
    let others = uvs.iter().skip(points.len()).map(|uv| to_cells(*uv));
    let mut places: Vec<DVec2> = points.iter().copied().chain(others).collect();
    places.truncate(if outcome.mesh.origins.is_empty() { points.len() } else { outcome.mesh.origins.len() });
    for (place, origin) in places.iter_mut().zip(&outcome.mesh.origins) {
        match *origin {
            Origin::Lattice { i, j } => *place = DVec2::new(f64::from(i), f64::from(j)) * size,
            Origin::Crossing { k } => *place = trimmed.extra_points[k as usize],
            _ => {}
        }
    }
    let (full_cells, stats) = (trimmed.full_cells, trimmed.stats);
    let (kind, reversed) = (face.kind, face.reversed);
    TileRecord { kind, reversed, lattice, outcome, places, loop_starts, extent, full_cells, stats, trim }
}
