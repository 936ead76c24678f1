//! Loops of one tile -> triangles of the whole tile at once. The cells that a loop touches are one zone, triangulated
//! by a constrained Delaunay triangulation whose constraints are the tessellant segments and the lattice edges towards
//! untouched, kept cells. No cell polygons, no snapping: slow, but with a short proof, so it is the last rung of the
//! ladder and the oracle of the tests.
//!
//! It is conforming because no segment touches an edge towards a full cell and no vertex lies on one, and because
//! corners close to a segment are not vertices, so that no lattice corner can split one.

use super::cdt::{self, AtCrossings, Segment};
use super::distinct::{Distinct, by_distinct};
use super::input::{CORNER_CLEARANCE, NONE, TrimInput, TrimInputError};
use super::output::{TrimOutcome, TrimOutput};
use glam::DVec2;

/// Marks cells of the zone, and dropped corners.
const ZONE: i32 = i32::MIN;

/// Triangulates the trimmed part of one tile without any of the fast stages. Cost: a few microseconds per tessellant.
///
/// # Errors
/// Those of [`trim_tile`](super::climb::trim_tile).
pub fn trim_tile_reference(input: &TrimInput<'_>, out: &mut TrimOutput) -> Result<TrimOutcome, TrimInputError> {
    by_distinct(input, &mut Distinct::default(), out, |tile, out| {
        out.stats.whole_tile = true;
        triangulate_tile(tile, out)
    })
}

/// [`trim_tile_reference`] for valid input without repeated points. Overwrites triangles, cells, layers and extra
/// points.
pub(crate) fn triangulate_tile(input: &TrimInput<'_>, out: &mut TrimOutput) -> TrimOutcome {
    let zone = Zone::mark(input);
    let mut sites = input.points.to_vec();
    let mut ids: Vec<u32> = (0..sites.len() as u32).collect();
    let mut segments: Vec<Segment> = input.segments().map(|(a, b)| Segment { ends: [a, b], weight: 1 }).collect();

    let (nu, nv) = input.cells;
    let mut site_of_corner = vec![NONE; ((nu + 1) * (nv + 1)) as usize];
    let mut corner = |i: u32, j: u32| {
        let slot = &mut site_of_corner[(j * (nu + 1) + i) as usize];
        if *slot == NONE {
            *slot = sites.len() as u32;
            sites.push(DVec2::new(f64::from(i), f64::from(j)));
            ids.push(input.corner_id(i, j));
        }
        *slot
    };
    out.triangles.clear();
    out.full_cells.clear();
    out.layers.clear();
    out.extra_points.clear();
    for j in 0..nv {
        for i in 0..nu {
            let number = zone.cell(i, j);
            if number == ZONE {
                for (a, b) in [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)] {
                    if zone.keeps_corner(a, b) {
                        corner(a, b);
                    }
                }
                continue;
            }
            if number == 0 {
                continue;
            }
            add_cell(input, [i, j], number, out);
            // Clockwise around the full cell: the zone lies to the left, and `number` layers of it end here.
            for (from, to, across) in [
                ((i + 1, j), (i, j), (i, j.wrapping_sub(1))),
                ((i + 1, j + 1), (i + 1, j), (i + 1, j)),
                ((i, j + 1), (i + 1, j + 1), (i, j + 1)),
                ((i, j), (i, j + 1), (i.wrapping_sub(1), j)),
            ] {
                if across.0 < nu && across.1 < nv && zone.cell(across.0, across.1) == ZONE {
                    let ends = [corner(from.0, from.1), corner(to.0, to.1)];
                    segments.push(Segment { ends, weight: number });
                }
            }
        }
    }
    // `spade` refuses coordinates that are not finite or beyond its range; validated points are neither. Closing adds
    // what the region lacks, all of it if necessary.
    let region = cdt::triangulate(&sites, &segments, AtCrossings::Split).unwrap_or_default();
    let first_extra = input.corner_id(nu, nv) + 1;
    let id = |site: u32| ids.get(site as usize).copied().unwrap_or_else(|| first_extra + site - ids.len() as u32);
    out.triangles.extend(region.triangles.iter().map(|t| t.map(id)));
    out.layers.extend(region.layers.iter().map(|&(t, times)| (t.map(id), times)));
    out.extra_points.extend_from_slice(&region.crossings);
    out.stats.led = region.led;
    if !region.layers.is_empty() || region.split > 0 {
        TrimOutcome::Repaired { split: region.split }
    } else {
        TrimOutcome::Cdt
    }
}

/// Adds a cell that no segment comes near to, and that the loops wind around `number` times.
fn add_cell(input: &TrimInput<'_>, [i, j]: [u32; 2], number: i32, out: &mut TrimOutput) {
    if number > 0 {
        out.full_cells.push([i, j]);
    }
    let more = if number > 0 { number - 1 } else { number };
    if more != 0 {
        let [a, b, c, d] = input.cell_corners([i, j]);
        out.layers.extend([([a, b, c], more), ([a, c, d], more)]);
    }
}

/// The cells of a valid input that segments come near to. All others are split along a diagonal.
pub(crate) fn zone(input: &TrimInput<'_>) -> Vec<[u32; 2]> {
    let zone = Zone::mark(input);
    let cells = (0..input.cells.1).flat_map(|j| (0..input.cells.0).map(move |i| [i, j]));
    cells.filter(|&[i, j]| zone.cell(i, j) == ZONE).collect()
}

/// Which cells and corners the segments come near to, and the winding numbers of the others.
struct Zone {
    cells: (u32, u32),
    /// Winding number per cell, or [`ZONE`].
    cell: Vec<i32>,
    /// Winding number per corner, or [`ZONE`] when it is dropped.
    corner: Vec<i32>,
}

impl Zone {
    fn cell(&self, i: u32, j: u32) -> i32 {
        self.cell[(j * self.cells.0 + i) as usize]
    }

    /// Whether a corner is a vertex. Corners on the tile border never are, whatever lies on the border itself.
    fn keeps_corner(&self, i: u32, j: u32) -> bool {
        let (nu, nv) = self.cells;
        i > 0 && j > 0 && i < nu && j < nv && ![0, ZONE].contains(&self.corner[(j * (nu + 1) + i) as usize])
    }

    fn mark(input: &TrimInput<'_>) -> Self {
        let (nu, nv) = input.cells;
        let mut zone = Self {
            cells: input.cells,
            cell: vec![0; nu as usize * nv as usize],
            corner: vec![0; (nu as usize + 1) * (nv as usize + 1)],
        };
        let segments = || input.segments().map(|(a, b)| (input.points[a as usize], input.points[b as usize]));
        for (a, b) in segments() {
            zone.add_winding(a, b);
        }
        zone.cell.chunks_exact_mut(nu as usize).for_each(prefix_sum);
        zone.corner.chunks_exact_mut(nu as usize + 1).for_each(prefix_sum);
        for (a, b) in segments() {
            zone.touch(a, b);
        }
        zone
    }

    /// Adds the changes of winding numbers at a segment, to be summed along rows. Where it crosses the centre line of a
    /// row of cells, the number changes for all cells to the right; where it crosses a lattice line, for all corners to
    /// the right. Rounding can misplace a change only by one cell or corner that the segment comes near to, and those
    /// become zone.
    fn add_winding(&mut self, a: DVec2, b: DVec2) {
        let nu = self.cells.0 as usize;
        let (low, high, sign) = if a.y < b.y { (a, b, -1) } else { (b, a, 1) };
        let x_at = |y: f64| (low.x + (high.x - low.x) * ((y - low.y) / (high.y - low.y))).clamp(0.0, nu as f64);
        // Half-open: a row's line y counts when low.y <= y < high.y.
        for (line, width, numbers) in [(0.5, nu, &mut self.cell), (0.0, nu + 1, &mut self.corner)] {
            let first = (low.y - line).ceil().max(0.0) as usize;
            for (j, row) in numbers.chunks_exact_mut(width).enumerate().skip(first) {
                let y = j as f64 + line;
                if y >= high.y {
                    break;
                }
                let i = x_at(y).floor() as usize + 1;
                row.get_mut(i).into_iter().for_each(|number| *number += sign);
            }
        }
    }

    /// Marks the cells within twice the clearance of the segment, and drops the corners within the clearance.
    fn touch(&mut self, a: DVec2, b: DVec2) {
        let (nu, nv) = (self.cells.0 as usize, self.cells.1 as usize);
        let reach = 2.0 * CORNER_CLEARANCE;
        let (low, high) = if a.y < b.y { (a, b) } else { (b, a) };
        let first = (low.y - reach).max(0.0).floor() as usize;
        let last = ((high.y + reach).floor() as usize).min(nv - 1);
        let slope = (high.x - low.x) / (high.y - low.y);
        let x_at = |y: f64| {
            // A level segment spans its whole width in every row it reaches.
            let x = low.x + (y.clamp(low.y, high.y) - low.y) * slope;
            if slope.is_finite() { x.clamp(low.x.min(high.x), low.x.max(high.x)) } else { f64::NAN }
        };
        for j in first..=last {
            let (from, to) = (x_at(j as f64 - reach), x_at(j as f64 + 1.0 + reach));
            let (from, to) = if from.is_nan() || to.is_nan() { (low.x, high.x) } else { (from, to) };
            let left = (from.min(to) - reach).max(0.0).floor() as usize;
            let right = ((from.max(to) + reach).floor() as usize).min(nu - 1);
            for i in left..=right {
                self.cell[j * nu + i] = ZONE;
                for (ci, cj) in [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)] {
                    let p = DVec2::new(ci as f64, cj as f64);
                    if distance_squared(p, a, b) <= CORNER_CLEARANCE * CORNER_CLEARANCE {
                        self.corner[cj * (nu + 1) + ci] = ZONE;
                    }
                }
            }
        }
    }
}

fn prefix_sum(row: &mut [i32]) {
    let mut sum = 0;
    for value in row {
        sum += *value;
        *value = sum;
    }
}

/// Squared distance of `p` to the segment from `a` to `b`.
fn distance_squared(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let d = b - a;
    let length = d.length_squared();
    let t = if length > 0.0 { ((p - a).dot(d) / length).clamp(0.0, 1.0) } else { 0.0 };
    (a + d * t - p).length_squared()
}
