//! The record of a tile -> a diagram in cell units, after Figures 7 to 12 of Kumar and Manocha.
//!
//! Colours show the class of things, the legend their number. Each class is one path, so a lattice of ten thousand
//! cells takes some hundred kilobytes.

use super::page::{Entry, Panel, Path, Style, Symbol, UNIT, page};
use crate::frame::internals::TileRecord;
use crate::mesh::Origin;
use glam::DVec2;
use std::collections::BTreeSet;

/// The longer side of the drawing, pixels.
const SIDE: f64 = 900.0;
/// Maximum aspect ratio of the drawing. Longer strips of cells are stretched.
const ASPECT: f64 = 3.0;
/// Number of neighbouring cells shown around a selected cell.
const AROUND: f64 = 1.0;
/// Distance of arrow heads along a loop, pixels.
const ARROWS: f64 = 90.0;

/// Options of a tile diagram.
#[derive(Clone, Debug, Default)]
pub struct TileView {
    /// Lines of text above the drawing.
    pub title: Vec<String>,
    /// Column and row of a cell to zoom in on; `None` draws the whole tile.
    ///
    /// With a cell, only it and its neighbours are drawn, and in-points, exit points and external points are those of
    /// the cell. Without, each end of a segment that leaves a cell counts as an exit point of its cell.
    pub cell: Option<[u32; 2]>,
}

/// A diagram, and the number of things of each kind in it.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct TileDiagram {
    /// The SVG document.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub svg: String,
    /// Columns and rows of the lattice.
    pub cells: [u32; 2],
    /// Cells split by a diagonal.
    pub full_cells: usize,
    /// Cells that loops pass through, with a part inside the region.
    pub prime_active_cells: usize,
    /// Cells that loops pass through, without a part inside the region.
    pub pseudo_active_cells: usize,
    /// Cells that were triangulated together.
    pub merged_cells: usize,
    /// Cells of the zone, if the whole tile was triangulated at once.
    pub zone_cells: usize,
    /// Crossings of loops with lattice lines, each snapped to a tessellant.
    pub crossings: usize,
    /// Tessellants whose neighbours are in the same cell.
    pub in_points: usize,
    /// Ends of segments that leave a cell: the ends within their cell, or within the selected cell.
    pub exit_points: usize,
    /// Other ends of the segments that leave the selected cell; 0 without one.
    pub external_points: usize,
    /// Lattice corners inside the region.
    pub kept_corners: usize,
    /// Lattice corners inside the region that were snapped to a tessellant.
    pub moved_corners: usize,
    /// Points that are neither lattice points nor tessellants.
    pub other_points: usize,
    /// Triangles.
    pub triangles: usize,
}

/// Draws a tile. A selected cell outside of the lattice gives an empty drawing.
#[must_use]
pub fn tile(record: &TileRecord, view: &TileView) -> TileDiagram {
    let mut sketch = Sketch::new(record, view);
    sketch.cells();
    sketch.lattice();
    sketch.triangles();
    sketch.merged();
    sketch.loops();
    sketch.corners();
    sketch.crossings();
    sketch.points();
    sketch.finish()
}

struct Sketch<'a> {
    record: &'a TileRecord,
    view: &'a TileView,
    panel: Panel,
    legend: Vec<Entry>,
    /// Size of the smallest distinguishable detail, pixels. Scales symbols and lines.
    detail: f64,
    told: TileDiagram,
}

impl<'a> Sketch<'a> {
    fn new(record: &'a TileRecord, view: &'a TileView) -> Self {
        let (low, high) = match view.cell.map(corner) {
            Some(corner) => (corner - AROUND, corner + 1.0 + AROUND),
            // A little more than the tile, because its border is a line, too.
            None => (-0.01 * record.extent, 1.01 * record.extent),
        };
        let size = high - low;
        let sides = (size / size.max_element()).max(DVec2::splat(1.0 / ASPECT)) * SIDE;
        let panel = Panel::new(low, high, sides);
        let cell = panel.scale().min_element();
        let mut lengths: Vec<f64> = segments(record)
            .filter(|&(a, b)| panel.shows(record.places[a], record.places[b]))
            .map(|(a, b)| panel.place(record.places[a]).distance(panel.place(record.places[b])) / UNIT)
            .collect();
        lengths.sort_by(f64::total_cmp);
        let short = lengths.get(lengths.len() / 4).copied().unwrap_or(cell);
        let detail = if view.cell.is_some() { 60.0 } else { cell.min(2.0 * short).clamp(2.0, 60.0) };
        let (nu, nv) = record.lattice.cells();
        let told = TileDiagram { cells: [nu, nv], ..TileDiagram::default() };
        Self { record, view, panel, legend: Vec::new(), detail, told }
    }

    /// Adds a path and its line of the legend, unless the path is empty.
    fn draw(&mut self, path: Path, style: Style, symbol: Symbol, words: String) {
        if !path.is_empty() {
            self.panel.draw(path, &style);
            // Symbols stay legible in fine drawings.
            let width = if symbol == Symbol::Dot { style.width.max(7.0) } else { style.width.clamp(1.0, 3.0) };
            self.legend.push(Entry { style: Style { width, class: "symbol", ..style }, symbol, words });
        }
    }

    fn cell_path(&self, cells: &[[u32; 2]]) -> (Path, usize) {
        let mut path = Path::default();
        for &cell in cells {
            let a = corner(cell);
            // A tile without inner lines is smaller than a cell.
            let b = (a + 1.0).min(self.record.extent);
            if self.panel.shows_area(a, b) {
                let [a, b] = [a, b].map(|p| self.panel.place(p));
                path.polygon([a, DVec2::new(b.x, a.y), b, DVec2::new(a.x, b.y)]);
            }
        }
        let count = path.closed;
        (path, count)
    }

    fn cells(&mut self) {
        let (record, trim) = (self.record, &self.record.trim);
        let kinds = [
            (&record.full_cells, "full", "#dff0d8", "active cell", "split by a diagonal"),
            (&trim.prime_cells, "prime", "#fde5c0", "prime-active cell", "with crossings or a loop"),
            (&trim.pseudo_cells, "pseudo", "#ececec", "pseudo-active cell", "nothing left of it"),
            (&trim.zone_cells, "zone", "#f3d9ee", "cell of the zone", "whole tile at once"),
        ];
        let counts = kinds.map(|(cells, class, fill, noun, remark)| {
            let (path, count) = self.cell_path(cells);
            let words = counted(count, noun, remark);
            self.draw(path, Style { class, fill, ..Style::default() }, Symbol::Area, words);
            count
        });
        let told = &mut self.told;
        [told.full_cells, told.prime_active_cells, told.pseudo_active_cells, told.zone_cells] = counts;
    }

    fn lattice(&mut self) {
        let mut path = Path::default();
        let (nu, nv) = self.record.lattice.cells();
        let extent = self.record.extent;
        let mut line = |a: DVec2, b: DVec2| {
            if self.panel.shows(a, b) {
                path.line(self.panel.place(a), self.panel.place(b));
            }
        };
        for i in 0..=nu {
            let x = f64::from(i).min(extent.x);
            line(DVec2::new(x, 0.0), DVec2::new(x, extent.y));
        }
        for j in 0..=nv {
            let y = f64::from(j).min(extent.y);
            line(DVec2::new(0.0, y), DVec2::new(extent.x, y));
        }
        let width = (0.04 * self.detail).clamp(0.25, 1.0);
        let style = Style { class: "lattice", stroke: "#b0b0b0", width, ..Style::default() };
        self.draw(path, style, Symbol::Line, format!("lattice of {nu} × {nv} cells"));
    }

    fn triangles(&mut self) {
        let mut path = Path::default();
        let places = &self.record.places;
        for t in &self.record.outcome.mesh.triangles {
            let [a, b, c] = t.map(|v| places[v as usize]);
            if self.panel.shows_area(a.min(b).min(c), a.max(b).max(c)) {
                path.polygon([a, b, c].map(|p| self.panel.place(p)));
            }
        }
        self.told.triangles = path.closed;
        let width = (0.03 * self.detail).clamp(0.2, 0.9);
        let style = Style { class: "triangles", stroke: "#3b76b5", width, ..Style::default() };
        let words = counted(self.told.triangles, "triangle", "");
        self.draw(path, style, Symbol::Triangle, words);
    }

    fn merged(&mut self) {
        let (path, count) = self.cell_path(&self.record.trim.merged_cells);
        self.told.merged_cells = count;
        let width = (0.1 * self.detail).clamp(0.5, 2.5);
        let style =
            Style { class: "merged", fill: "#8e44ad", stroke: "#8e44ad", width, opacity: 0.35, ..Style::default() };
        let words = counted(count, "merged cell", "triangulated together");
        self.draw(path, style, Symbol::Area, words);
    }

    fn loops(&mut self) {
        let record = self.record;
        let mut paths = [Path::default(), Path::default()];
        let mut heads = Path::default();
        for ends in record.loop_starts.windows(2) {
            let (start, end) = (ends[0] as usize, ends[1] as usize);
            let mut since = 0.5 * ARROWS;
            let mut last = [None; 2];
            for v in start..end {
                let next = if v + 1 == end { start } else { v + 1 };
                let (a, b) = (record.places[v], record.places[next]);
                if !self.panel.shows(a, b) {
                    continue;
                }
                let (p, q) = (self.panel.place(a), self.panel.place(b));
                let kind = usize::from(matches!(record.outcome.mesh.origins.get(v), Some(Origin::Border { .. })));
                if last[kind] != Some(v) {
                    paths[kind].move_to(p);
                }
                paths[kind].line_to(q);
                last[kind] = Some(next);
                let length = p.distance(q) / UNIT;
                since += length;
                if since >= ARROWS {
                    since %= ARROWS;
                    heads.arrow_head(0.5 * (p + q), q - p, (0.35 * self.detail).clamp(5.0, 12.0) * UNIT);
                }
            }
        }
        let [trims, borders] = paths;
        let width = (0.08 * self.detail).clamp(0.6, 2.5);
        let line = |class, stroke| Style { class, stroke, width, round: true, ..Style::default() };
        self.draw(borders, line("borders", "#555555"), Symbol::Line, "the tile's own borders".into());
        self.draw(trims, line("trims", "#b03a2e"), Symbol::Line, "trimming curves and edges".into());
        let style = Style { class: "directions", fill: "#7b241c", ..Style::default() };
        self.draw(heads, style, Symbol::Arrow, "direction: what is kept lies left".into());
    }

    fn corners(&mut self) {
        let trim = &self.record.trim;
        let radius = (0.06 * self.detail).clamp(0.3, 2.5);
        let mut kept = Path::default();
        let active: BTreeSet<[u32; 2]> = trim.prime_cells.iter().chain(&trim.zone_cells).copied().collect();
        for &[i, j] in trim.kept_corners.iter().filter(|&&c| self.panel.shows(corner(c), corner(c))) {
            self.told.kept_corners += 1;
            // Elsewhere the colour of the cells shows that the corner is kept.
            if [[i - 1, j - 1], [i, j - 1], [i - 1, j], [i, j]].iter().any(|cell| active.contains(cell)) {
                kept.square(self.panel.place(corner([i, j])), radius * UNIT);
            }
        }
        let mut moved = Path::default();
        for &(c, vertex) in &trim.moved_corners {
            let (a, b) = (corner(c), self.record.places[vertex as usize]);
            if self.panel.shows(a, b) {
                moved.square(self.panel.place(a), 2.5 * radius * UNIT);
            }
        }
        self.told.moved_corners = moved.closed;
        let style = Style { class: "kept-corners", fill: "#2e7d32", ..Style::default() };
        let words = counted(kept.closed, "kept corner", "of prime-active cells");
        self.draw(kept, style, Symbol::Square, words);
        let style = Style { class: "moved-corners", stroke: "#2e7d32", width: 0.6 * radius, ..Style::default() };
        let words = counted(self.told.moved_corners, "snapped corner", "a tessellant stands for it");
        self.draw(moved, style, Symbol::Square, words);
    }

    fn crossings(&mut self) {
        let mut marks = Path::default();
        let mut snaps = Path::default();
        for crossing in &self.record.trim.crossings {
            let end = self.record.places[crossing.snap as usize];
            let near = self.view.cell.is_none_or(|cell| crossing.cells.contains(&cell));
            if near && self.panel.shows(crossing.at, crossing.at) {
                let at = self.panel.place(crossing.at);
                marks.diamond(at, (0.14 * self.detail).clamp(0.8, 6.0) * UNIT);
                snaps.line(at, self.panel.place(end));
            }
        }
        self.told.crossings = marks.closed;
        let width = (0.14 * self.detail).clamp(0.6, 4.0);
        let style = Style { class: "snaps", stroke: "#f39c12", width, opacity: 0.8, ..Style::default() };
        self.draw(snaps, style, Symbol::Line, "from a crossing to the tessellant it is snapped to".into());
        let style =
            Style { class: "crossings", fill: "#ffffff", stroke: "#111111", width: 0.3 * width, ..Style::default() };
        let words = counted(self.told.crossings, "crossing", "with lattice lines");
        self.draw(marks, style, Symbol::Diamond, words);
    }

    fn points(&mut self) {
        let record = self.record;
        let mut exits: Vec<u32> = Vec::new();
        let mut externals: Vec<u32> = Vec::new();
        for crossing in &record.trim.crossings {
            let [a, b] = crossing.segment;
            match self.view.cell {
                None => exits.extend([a, b]),
                Some(cell) if crossing.cells[0] == cell => {
                    externals.push(b);
                    exits.push(a);
                }
                Some(cell) if crossing.cells[1] == cell => {
                    externals.push(a);
                    exits.push(b);
                }
                Some(_) => {}
            }
        }
        let inside = |v: &u32| self.view.cell.is_none_or(|cell| record.trim.cell_of[*v as usize] == Some(cell));
        exits.retain(inside);
        // A segment that crosses the whole cell has no exit point here, and two external ones.
        externals.retain(|v| !inside(v));
        for list in [&mut exits, &mut externals] {
            list.sort_unstable();
            list.dedup();
        }
        let tessellants = record.loop_starts.last().map_or(0, |&count| count);
        let plain: Vec<u32> = (0..tessellants).filter(|v| inside(v) && exits.binary_search(v).is_err()).collect();
        let mesh = &record.outcome.mesh;
        let other: Vec<u32> = (tessellants..mesh.origins.len() as u32)
            .filter(|&v| !matches!(mesh.origins[v as usize], Origin::Lattice { .. }))
            .collect();
        let dots = |vertices: &[u32]| {
            let mut path = Path::default();
            for p in vertices.iter().map(|&v| record.places[v as usize]).filter(|&p| self.panel.shows(p, p)) {
                path.dot(self.panel.place(p));
            }
            path
        };
        let paths = [dots(&plain), dots(&exits), dots(&externals), dots(&other)];
        let counts = [0, 1, 2, 3].map(|k: usize| paths[k].closed);
        [self.told.in_points, self.told.exit_points, self.told.external_points, self.told.other_points] = counts;
        let width = (0.16 * self.detail).clamp(0.7, 6.0);
        let dot = |class, stroke| Style { class, stroke, width, round: true, ..Style::default() };
        let [plain, exits, externals, other] = paths;
        self.draw(plain, dot("in-points", "#111111"), Symbol::Dot, counted(counts[0], "in-point", "of its cell only"));
        let role = if self.view.cell.is_some() { "of the cell" } else { "external to the next cell" };
        self.draw(exits, dot("exit-points", "#1e8449"), Symbol::Dot, counted(counts[1], "exit point", role));
        self.draw(externals, dot("external-points", "#c0392b"), Symbol::Dot, counted(counts[2], "external point", ""));
        let role = "off lattice and loops";
        self.draw(other, dot("other-points", "#8e44ad"), Symbol::Dot, counted(counts[3], "point", role));
    }

    fn finish(mut self) -> TileDiagram {
        let record = self.record;
        if let Some(cell) = self.view.cell {
            let (path, _) = self.cell_path(&[cell]);
            let style = Style { class: "cell", stroke: "#111111", width: 2.0, dash: Some(6.0), ..Style::default() };
            self.draw(path, style, Symbol::Line, format!("cell {}, {}", cell[0], cell[1]));
        }
        let range = |lines: &[f64]| format!("{:.6} … {:.6}", lines[0], lines[lines.len() - 1]);
        let (us, vs) = (range(&record.lattice.us), range(&record.lattice.vs));
        self.panel.caption(format!("right: u = {us}; up: v = {vs} of the tile; lines are drawn evenly"));
        let mut title = self.view.title.clone();
        let (rung, stats) = (record.outcome.rung, &record.stats);
        let mut how = format!("{}, {rung}", record.kind.name());
        if stats.failed_rings > 0 {
            how += &format!(", {} cell polygons failed", stats.failed_rings);
        }
        if let Some(degradation) = &record.outcome.degradation {
            how += &format!("; {degradation}");
        }
        title.push(how);
        let mut told = self.told;
        told.svg = page(&title, vec![self.panel], &self.legend);
        told
    }
}

/// The segments of all loops, as indices of places.
fn segments(record: &TileRecord) -> impl Iterator<Item = (usize, usize)> {
    record.loop_starts.windows(2).flat_map(|ends| {
        let (start, end) = (ends[0] as usize, ends[1] as usize);
        (start..end).map(move |v| (v, if v + 1 == end { start } else { v + 1 }))
    })
}

fn corner([i, j]: [u32; 2]) -> DVec2 {
    DVec2::new(f64::from(i), f64::from(j))
}

/// Formats a count with its noun and a remark: "3 merged cells: triangulated together".
fn counted(count: usize, noun: &str, remark: &str) -> String {
    let noun = match noun.strip_prefix("cell of") {
        Some(rest) if count != 1 => format!("cells of{rest}"),
        _ if count == 1 => noun.to_owned(),
        _ => format!("{noun}s"),
    };
    if remark.is_empty() { format!("{count} {noun}") } else { format!("{count} {noun}: {remark}") }
}
