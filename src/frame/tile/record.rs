//! A tile and a plan -> its triangles and all intermediate decisions, for diagrams.

use super::job::tessellate_tile;
use super::outcome::TileOutcome;
use crate::frame::plan::output::{Plan, TileLattice, cell_coordinate};
use crate::frame::trim::input::TrimInput;
use crate::frame::trim::output::TrimStats;
use crate::frame::trim::record::TrimRecord;
use crate::frame::vertices::{Scratch, cell_size};
use crate::mesh::MeshLists;
use crate::model::{PartId, SurfaceKind, TileId};
use crate::prepare::Prepared;
use glam::DVec2;

/// The tessellation of one tile, with its intermediate steps.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct TileRecord {
    /// Kind of the face's surface, as in the model.
    pub kind: SurfaceKind,
    /// Whether the outside of the face is opposite to the normal `S_u × S_v`.
    pub reversed: bool,
    /// The tile's lattice, in the parameters of its face's patches.
    pub lattice: TileLattice,
    /// What [`tessellate_tile`] returned.
    pub outcome: TileOutcome,
    /// Positions of the mesh's vertices in cell units, tessellants first.
    pub places: Vec<DVec2>,
    /// Index of each loop's first tessellant, then the number of tessellants.
    pub loop_starts: Vec<u32>,
    /// The upper corner of the tile in cell units; the lower one is the origin. A tile of a single cell has the
    /// proportions that it has in space, with 1 for the longer side.
    pub extent: DVec2,
    /// Cells that were split by a diagonal.
    pub full_cells: Vec<[u32; 2]>,
    /// Counts of the trim stage.
    pub stats: TrimStats,
    /// Decisions of the trim stage.
    pub trim: TrimRecord,
}

/// Tessellates one tile as [`tessellate_tile`] does, and reads the intermediate steps from its work space.
///
/// Does not slow down frames, since it only reads what is there anyway. Cost: about twice that of the tile.
#[must_use]
pub fn record_tile(prepared: &Prepared, plan: &Plan, part: PartId, tile: TileId) -> TileRecord {
    let mut scratch = Scratch::default();
    let outcome = tessellate_tile(prepared, plan, (part, tile), MeshLists::ALL, &mut scratch);
    let rows = &prepared.parts[part.index()];
    let row = &rows.tiles[tile.0 as usize];
    let face = rows.face_of(row);
    let lattice = TileLattice::clone(&plan.parts[part.index()].tiles[tile.0 as usize]);
    let cells = lattice.cells();
    let Scratch { cells: mut places, uvs, loop_starts, trim, trimmed, .. } = scratch;
    let tessellants = loop_starts.last().map_or(0, |&end| end as usize);
    let input = TrimInput { cells, points: &places[..tessellants], loop_starts: &loop_starts, places: &[] };
    let trim = trim.record(&input, &trimmed.stats);
    let size = cell_size(row, &lattice);
    let extent = DVec2::new(f64::from(cells.0), f64::from(cells.1)) * size;
    let to_cells =
        |uv: &DVec2| DVec2::new(cell_coordinate(&lattice.us, uv.x), cell_coordinate(&lattice.vs, uv.y)) * size;
    // Points that split a triangle have parameters only.
    places.extend(uvs[places.len()..].iter().map(to_cells));
    let (full_cells, stats) = (trimmed.full_cells, trimmed.stats);
    let (kind, reversed) = (face.kind, face.reversed);
    TileRecord { kind, reversed, lattice, outcome, places, loop_starts, extent, full_cells, stats, trim }
}
