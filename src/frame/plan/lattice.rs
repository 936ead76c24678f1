//! Derivative bounds and a tolerance -> the lattice lines of a tile.

use super::density::Density;
use super::directions::{Directions, Strip};
use super::output::{LINES_OF_TILE, TileLattice, most_lines};
use crate::frame::tolerance::{BoxTolerances, dilate, is_steep, most_touched};
use crate::math::lanes::{larger, smaller};
use crate::model::SurfaceKind;
use crate::prepare::internals::{Bend, BoundingBox, PreparedFace, Tile};
use smallvec::SmallVec;
use std::borrow::Cow;
use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

/// Maximum number of cells of a tile whose lines reach [`most_lines`]. Where no number of lines is enough, more cells
/// follow noise: one coordinate of 1e9 mm in a part of 100 mm asks for as many as all limits allow.
const CELLS_BEYOND_LINES: u64 = 1 << 20;
/// Maximum number of times that a lattice over its limits is made coarser; each time brings it down to about the limit.
const COARSER: usize = 8;

/// Least cell length that the angle tolerance can require in tiles whose loops meet themselves, as a multiple of the
/// gap between edges and surface. Such tiles are noise: a fillet whose points moved by a fraction of its radius turns
/// twenty times where it turned by a right angle, and lines at each turn do not follow its shape. The chord tolerance
/// still holds; noisy fillets keep a few cells across.
const GAPS_PER_CELL: f64 = 16.0;

/// The boxes of a face's table under a tile, strip by strip in u: the order of [`BoxTolerances::shares`].
pub(crate) fn places<'a>(
    face: &'a PreparedFace,
    tile: &Tile,
) -> impl Iterator<Item = &'a BoundingBox> + Clone + use<'a> {
    let (table, [su, sv]) = (&face.bounds, strips_under(face, tile));
    let columns = table.breaks_v.len() - 1;
    su.flat_map(move |i| &table.places[i * columns + sv.start..i * columns + sv.end])
}

/// Strips of the bounds table under the tile, along u and along v.
pub(crate) fn strips_under(face: &PreparedFace, tile: &Tile) -> [Range<usize>; 2] {
    let table = &face.bounds;
    [strips(&table.breaks_u, tile.min.x, tile.max.x), strips(&table.breaks_v, tile.min.y, tile.max.y)]
}

/// Strips between breaks under `[lo, hi]`.
pub(super) fn strips(breaks: &[f64], lo: f64, hi: f64) -> Range<usize> {
    let n = breaks.len() - 1;
    let first = breaks.partition_point(|&x| x <= lo).saturating_sub(1).min(n - 1);
    let last = breaks.partition_point(|&x| x < hi).clamp(first + 1, n);
    first..last
}

/// Whether a lattice is as dense as required; if not, which limit made it coarser.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DensityMet {
    /// False if the limits on lines made it coarser, or if more lines would follow noise.
    pub(crate) lines: bool,
    /// False if the limit on cells made it coarser.
    pub(crate) cells: bool,
}

/// Whether tiles of a face have one cell at any tolerance: on planes, unless the length of edges is limited.
pub(crate) fn is_single(face: &PreparedFace, max_edge: Option<f64>) -> bool {
    face.kind == SurfaceKind::Plane && max_edge.is_none()
}

/// Whether the derivative bounds of a face are those of a plain shape.
pub(crate) fn is_exact(face: &PreparedFace) -> bool {
    !matches!(face.kind, SurfaceKind::Extrusion | SurfaceKind::Revolution | SurfaceKind::Nurbs)
}

/// Makes lattices, in reused buffers. Results do not depend on earlier calls.
#[derive(Default)]
pub(crate) struct Lattices {
    shares: Vec<f64>,
    /// Across u and v.
    strips: [Vec<Strip>; 2],
    /// Densities of lines, strip by strip.
    wanted: [Vec<f64>; 2],
    lines: Vec<f64>,
}

/// A tile and what its lattice must meet.
#[derive(Clone, Copy)]
pub(crate) struct LatticeRequest<'a> {
    pub(crate) face: &'a PreparedFace,
    pub(crate) tile: &'a Tile,
    pub(crate) need: &'a BoxTolerances,
    /// Lines are this many times as dense as the tolerance needs.
    pub(crate) factor: f64,
    pub(crate) most_cells: u64,
}

impl Lattices {
    /// Lattice lines of a tile, and whether they are as dense as asked: [`most_lines`] and `most_cells` may prevent it.
    /// A pure function of the request.
    pub(crate) fn lattice(&mut self, request: &LatticeRequest<'_>) -> (TileLattice, DensityMet) {
        let LatticeRequest { face, tile, need, .. } = *request;
        if is_single(face, need.tolerance.max_edge) {
            let single = TileLattice {
                us: [tile.min.x, tile.max.x].into(),
                vs: [tile.min.y, tile.max.y].into(),
                chord: need.tolerance.chord,
                loosest: need.loosest_chord(),
            };
            return (single, DensityMet { lines: true, cells: true });
        }
        let (table, [su, sv]) = (&face.bounds, strips_under(face, tile));
        let breaks = [&table.breaks_u[su.start..=su.end], &table.breaks_v[sv.start..=sv.end]];
        // A cell in several boxes must meet the tolerances of all of them. Where these differ strongly, as they do
        // close to the eye, lines run along the borders of boxes, so that no cell is in two.
        let steep = is_steep(&need.shares, sv.len());
        let mut reach = usize::from(!steep);
        loop {
            dilate(&need.shares, sv.len(), reach, &mut self.shares);
            let all = self.gather(face, (su.clone(), sv.clone()), breaks);
            let noisy = self.set_densities(request, (breaks, steep), all);
            let (lattice, kept) = self.spread(request, breaks, (steep, noisy));
            if self.shares.iter().all(|&share| share == 1.0) {
                return (lattice, kept);
            }
            let touched = most_touched(&table.breaks_u, &lattice.us).max(most_touched(&table.breaks_v, &lattice.vs));
            if touched <= reach + 1 {
                return (lattice, kept);
            }
            reach = touched - 1;
        }
    }

    /// Joins the boxes under a tile strip by strip. Returns the largest second derivatives of all: uu, uv, vv.
    fn gather(
        &mut self,
        face: &PreparedFace,
        (su, sv): (Range<usize>, Range<usize>),
        breaks: [&[f64]; 2],
    ) -> [Bend; 3] {
        let Self { shares, strips: [columns, rows], .. } = self;
        for (strips, breaks) in [&mut *columns, &mut *rows].into_iter().zip(breaks) {
            strips.clear();
            strips.extend(breaks.windows(2).map(|w| Strip { width: w[1] - w[0], ..Strip::default() }));
        }
        let mut shares = shares.iter().copied();
        for (i, column) in su.zip(&mut *columns) {
            for (j, row) in sv.clone().zip(&mut *rows) {
                let [in_column, in_row] = Strip::of(&face.bounds.cell(i, j), shares.next().unwrap_or(1.0));
                column.join(&in_column);
                row.join(&in_row);
            }
        }
        let most = |strips: &[Strip], of: fn(&Strip) -> Bend| {
            strips.iter().fold(Bend::default(), |most, strip| most.max(of(strip)))
        };
        let all = [most(columns, |s| s.own), most(columns, |s| s.mixed), most(rows, |s| s.own)];
        columns.iter_mut().chain(rows).for_each(|strip| strip.turn /= strip.width);
        all
    }

    /// Sets the densities of lines. Returns whether they are less than the angle tolerance requires, because that would
    /// follow noise.
    fn set_densities(
        &mut self,
        request: &LatticeRequest<'_>,
        (breaks, steep): ([&[f64]; 2], bool),
        all: [Bend; 3],
    ) -> bool {
        let LatticeRequest { face, tile, need: BoxTolerances { tolerance, .. }, factor, .. } = *request;
        let Self { strips, wanted, .. } = self;
        let noise = if tile.entangled { GAPS_PER_CELL * face.gap } else { 0.0 };
        // Lines per unit of parameter beyond which cells follow noise.
        let densest = |strip: &Strip| if noise > 0.0 { strip.fastest / noise } else { f64::INFINITY };
        let angle = tolerance.angle.min(FRAC_PI_2);
        let width = (tile.max - tile.min).to_array();
        // What a strip needs besides the chord tolerance.
        let others = |strip: &Strip| {
            let long = tolerance.max_edge.map_or(0.0, |m| std::f64::consts::SQRT_2 * strip.speed / m);
            let smooth = smaller(larger(strip.turn / angle, strip.even), densest(strip));
            larger(smooth, long)
        };
        let ends = [0, 1].map(|axis| (tile.min[axis], tile.max[axis]));
        let creased = |axis: usize| face.creases[axis].iter().any(|&x| x > ends[axis].0 && x < ends[axis].1);
        let directions = Directions {
            strips: [&strips[0], &strips[1]],
            breaks,
            ends,
            all,
            budget: 8.0 * tolerance.chord,
            others: [0, 1].map(|axis| strips[axis].iter().map(others).collect()),
            // Lines between borders and creases are not even.
            round: [0, 1].map(|axis| !steep && !creased(axis)),
        };
        // Normals turn the most on the largest cells, those that lifts alone would allow. A tangential derivative at
        // one end of a cell lifts the surface at the other end by at most that turn, and by half of it on average
        // (decision 019).
        let mut share = 0.0;
        loop {
            directions.rates(share, wanted);
            let [turn_u, turn_v] = [0, 1].map(|axis| most_turn(&strips[axis], &wanted[axis]));
            let turned = (0.5 * libm::hypot(turn_u, turn_v)).min(1.0);
            if turned <= share {
                break;
            }
            // With whole numbers of gaps, a direction may have longer ones at a larger share.
            share = if share == 0.0 { turned } else { (1.05 * turned).min(1.0) };
        }
        wanted.iter_mut().flatten().for_each(|rate| *rate *= factor);
        (0..2).any(|axis| {
            strips[axis].iter().zip(&wanted[axis]).any(|(strip, rate)| {
                let smooth = factor * (strip.turn / angle).max(strip.even);
                smooth > *rate && smooth * width[axis] > 1.0
            })
        })
    }

    /// Lattice lines at the densities; if `steep`, along the borders of boxes too.
    fn spread(
        &mut self,
        request: &LatticeRequest<'_>,
        breaks: [&[f64]; 2],
        (steep, noisy): (bool, bool),
    ) -> (TileLattice, DensityMet) {
        let LatticeRequest { face, tile, need, most_cells, .. } = *request;
        let Self { wanted, lines: buffer, .. } = self;
        let mut creases = [Cow::Borrowed(&face.creases[0]), Cow::Borrowed(&face.creases[1])];
        if steep {
            for (creases, breaks) in creases.iter_mut().zip(breaks) {
                let creases = creases.to_mut();
                creases.extend(breaks);
                creases.sort_by(f64::total_cmp);
                creases.dedup();
            }
        }
        let ends = [0, 1].map(|axis| (tile.min[axis], tile.max[axis]));
        let mut kept = DensityMet { lines: !noisy, cells: true };
        let most_lines = most_lines(need.tolerance.around(need.radius, is_exact(face)));
        let (mut round, mut beyond) = (0, false);
        loop {
            let density = |axis: usize| Density { breaks: breaks[axis], rates: &wanted[axis] };
            let mut placed = |axis: usize| lines(density(axis), ends[axis], (&creases[axis], most_lines), buffer);
            let ((us, kept_u), (vs, kept_v)) = (placed(0), placed(1));
            let (nu, nv) = ((us.len() - 1) as f64, (vs.len() - 1) as f64);
            beyond |= !(kept_u && kept_v);
            let most = if beyond { most_cells.min(CELLS_BEYOND_LINES) } else { most_cells };
            // By how much u and v are too dense. A direction with one cell cannot become coarser.
            let over = nu * nv / most as f64;
            let share = |n: f64, other: f64| {
                (if other > 1.0 { over.sqrt() } else { over }).max(n / LINES_OF_TILE as f64).max(1.0)
            };
            let (too_u, too_v) = (share(nu, nv), share(nv, nu));
            let fits = too_u <= 1.0 && too_v <= 1.0;
            kept.lines &= kept_u && kept_v;
            if fits || round == COARSER {
                let (chord, loosest) = (need.tolerance.chord, need.loosest_chord());
                return (TileLattice { us, vs, chord, loosest }, kept);
            }
            kept.cells &= nu * nv <= most_cells as f64;
            kept.lines &= nu.max(nv) <= LINES_OF_TILE as f64;
            round += 1;
            let by = [coarser(&density(0), ends[0], nu, too_u), coarser(&density(1), ends[1], nv, too_v)];
            for (rates, by) in wanted.iter_mut().zip(by) {
                rates.iter_mut().for_each(|rate| *rate *= by);
            }
        }
    }
}

/// Largest turn of the normal across a cell of these densities.
fn most_turn(strips: &[Strip], rates: &[f64]) -> f64 {
    let mut all = 0.0;
    let mut most = 0.0_f64;
    for (Strip { turn, width, .. }, rate) in strips.iter().zip(rates) {
        let whole = turn * width;
        all += whole;
        // A box that turns by more than a right angle may do so at a single point, where the surface folds.
        most = most.max(if whole > FRAC_PI_2 {
            whole
        } else if *turn > 0.0 {
            turn / rate
        } else {
            0.0
        });
    }
    most.min(all)
}

/// Factor that makes a density `too_many` times coarser, where it gave `n` gaps. It goes 1 % further, so that rounding
/// up does not undo it, and starts from the actual gaps, since limits may allow fewer than the density asks for.
fn coarser(density: &Density<'_>, (lo, hi): (f64, f64), n: f64, too_many: f64) -> f64 {
    let mass = density.mass(lo, hi);
    let by = if mass > n { n / mass } else { 1.0 };
    by / (1.01 * too_many)
}

/// Lines from `lo` to `hi`, at all creases between and at most so many from one to the next, and whether they meet the
/// density. `buffer` is room for them.
fn lines(
    density: Density<'_>,
    (lo, hi): (f64, f64),
    (creases, most): (&[f64], usize),
    buffer: &mut Vec<f64>,
) -> (SmallVec<[f64; 2]>, bool) {
    buffer.clear();
    buffer.push(lo);
    let mut from = lo;
    let mut kept = true;
    for &x in creases.iter().filter(|&&x| x > lo && x < hi).chain([&hi]) {
        kept &= density.spread(from, x, most, buffer);
        from = x;
    }
    (SmallVec::from_slice(buffer), kept)
}
