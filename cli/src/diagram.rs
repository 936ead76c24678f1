//! `trimtess info --svg`: one tile as it is tessellated, as a diagram of all decisions.

use crate::outputs::Outputs;
use crate::tessellate::ToleranceArgs;
use crate::{Common, Failure};
use serde::Serialize;
use std::path::PathBuf;
use trimtess::draw::{TileDiagram, TileView, tile};
use trimtess::frame::internals::record_tile;
use trimtess::frame::plan_within;
use trimtess::model::{PartId, TileId};
use trimtess::prepare::Prepared;

/// Options of a tile diagram.
#[derive(clap::Args)]
#[command(next_help_heading = "Drawing a tile", mut_group("ToleranceArgs", |tolerance| tolerance.requires("svg")))]
pub(crate) struct DiagramArgs {
    /// Draw how a tile is tessellated: lattice, cells, crossings, in-points, exit and external points, triangles.
    #[arg(long, value_name = "OUT.svg")]
    pub(crate) svg: Option<PathBuf>,
    /// Part number, as in diagnostics.
    #[arg(long, value_name = "N", default_value_t = 0, requires = "svg")]
    part: usize,
    /// Face number within the part, as in diagnostics.
    #[arg(long, value_name = "N", default_value_t = 0, requires = "svg")]
    face: usize,
    /// Tile number within the face.
    #[arg(long, value_name = "N", default_value_t = 0, requires = "svg")]
    tile: usize,
    /// Zoom in on a cell of the tile, given by column and row.
    #[arg(long, value_name = "I,J", value_parser = cell, requires = "svg")]
    cell: Option<[u32; 2]>,
    #[command(flatten)]
    tolerance: ToleranceArgs,
}

/// Facts of a drawn tile.
#[derive(Serialize)]
pub(crate) struct Drawn {
    file: String,
    part: usize,
    face: usize,
    tile: usize,
    chord_mm: f64,
    #[serde(flatten)]
    counts: TileDiagram,
}

/// Parses a column and a row.
fn cell(text: &str) -> Result<[u32; 2], String> {
    let numbers = text.split_once(',').map(|(i, j)| (i.trim().parse(), j.trim().parse()));
    match numbers {
        Some((Ok(i), Ok(j))) => Ok([i, j]),
        _ => Err("expected column and row, as in 3,7".into()),
    }
}

impl DiagramArgs {
    /// Draws the tile selected by the options, if `--svg` is given.
    pub(crate) fn draw(
        &self,
        prepared: &Prepared,
        input: &str,
        common: &Common,
        outputs: &mut Outputs,
    ) -> Result<Option<Drawn>, Failure> {
        let Some(path) = &self.svg else { return Ok(None) };
        let (part, face) = (self.part, self.face);
        let usage = |message: String| Err(Failure::Usage(message));
        let Some(rows) = prepared.parts.get(part) else {
            return usage(format!("--part {part}: there are {} parts, numbered from 0", prepared.parts.len()));
        };
        let Some(row) = rows.face_rows.get(face) else {
            return usage(format!("--face {face}: part {part} has {} faces, numbered from 0", rows.face_rows.len()));
        };
        let Some(row) = row.map(|row| &rows.faces[row as usize]) else {
            return Err(Failure::Cannot(format!("face {face} of part {part} is not usable; see its diagnostic (-v)")));
        };
        let Some(id) = row.tiles.clone().nth(self.tile) else {
            return usage(format!("--tile {}: the face has {} tiles, numbered from 0", self.tile, row.tiles.len()));
        };
        let tolerance = self.tolerance.resolve(prepared.diagonal);
        let plan = plan_within(prepared, &tolerance, &common.limits.plan());
        common.limits.check(plan.shortfall.as_ref())?;
        let record = record_tile(prepared, &plan, PartId::new(part), TileId(id));
        let (nu, nv) = record.lattice.cells();
        if let Some([i, j]) = self.cell
            && (i >= nu || j >= nv)
        {
            return usage(format!("--cell {i},{j}: the tile has {nu} × {nv} cells, numbered from 0"));
        }
        let entity = if row.entity == 0 { String::new() } else { format!(" (#{})", row.entity) };
        let chord = tolerance.chord;
        let title = vec![format!(
            "{input}, part {part}, face {face}{entity}, tile {} of {}, chord {chord:.3e} mm",
            self.tile,
            row.tiles.len()
        )];
        let counts = tile(&record, &TileView { title, cell: self.cell });
        outputs.write(path, |file| file.write_all(counts.svg.as_bytes()))?;
        let file = path.display().to_string();
        Ok(Some(Drawn { file, part, face, tile: self.tile, chord_mm: chord, counts }))
    }
}

impl Drawn {
    /// The facts as text.
    pub(crate) fn text(&self) -> String {
        let TileDiagram { cells: [nu, nv], triangles, crossings, prime_active_cells, .. } = self.counts;
        format!(
            "{}: face {} tile {}, {nu} × {nv} cells, {prime_active_cells} of them prime-active, \
             {crossings} crossings, {triangles} triangles",
            self.file, self.face, self.tile
        )
    }
}
