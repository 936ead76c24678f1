//! Derivative bounds and a tolerance to the lattice lines of a tile.
//!
//! Deviation: the theorem of Filip, Magedson and Markot (CAGD 3(4), 1986) in its form for any triangle whose box is
//! h_u × h_v: ⅛ (M₁h_u² + 2M₂h_u h_v + M₃h_v²). The mixed term is split between the directions by
//! 2M₂h_u h_v ≤ M₂(r h_u² + h_v²/r), r = h_v/h_u of the cheapest uniform lattice, so that each direction has a density of
//! lines of its own that follows the bounds along it.

use super::density::Density;
use super::plan::{MAX_LINES, TileLattice};
use super::tolerance::Tolerance;
use crate::prepare::{BoxBounds, PreparedFace, Tile};
use std::f64::consts::FRAC_PI_2;

/// Most lines of one tile in one direction, over all stretches between creases.
const LINES_OF_TILE: f64 = 32768.0;
/// Times that a lattice over its limits is made coarser; each time brings it down to about the limit.
const COARSER: usize = 8;

/// Largest bounds of the boxes under a tile.
fn worst(boxes: impl Iterator<Item = BoxBounds>) -> BoxBounds {
    boxes.fold(BoxBounds::default(), |m, b| BoxBounds {
        uu: m.uu.max(b.uu),
        uv: m.uv.max(b.uv),
        vv: m.vv.max(b.vv),
        u: m.u.max(b.u),
        v: m.v.max(b.v),
        turn_u: m.turn_u.max(b.turn_u),
        turn_v: m.turn_v.max(b.turn_v),
    })
}

/// Strips of the bounds table under `[lo, hi]`.
fn strips(breaks: &[f64], lo: f64, hi: f64) -> std::ops::Range<usize> {
    let n = breaks.len() - 1;
    let first = breaks.partition_point(|&x| x <= lo).saturating_sub(1).min(n - 1);
    let last = breaks.partition_point(|&x| x < hi).clamp(first + 1, n);
    first..last
}

/// Whether a lattice is as dense as it was asked to be, or what made it coarser.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Kept {
    /// The limits on lines did not.
    pub(super) lines: bool,
    /// The limit on cells did not.
    pub(super) cells: bool,
}

/// Lattice lines of `tile` at `factor` times the density that a tolerance needs, and whether they are that dense: they are
/// not where [`MAX_LINES`] or `most_cells` forbid it. A pure function of its arguments.
pub(super) fn lattice(
    face: &PreparedFace,
    tile: &Tile,
    tolerance: &Tolerance,
    factor: f64,
    most_cells: u64,
) -> (TileLattice, Kept) {
    let table = &face.bounds;
    let (su, sv) = (strips(&table.breaks_u, tile.min.x, tile.max.x), strips(&table.breaks_v, tile.min.y, tile.max.y));
    let columns: Vec<BoxBounds> = su.clone().map(|i| worst(sv.clone().map(|j| table.cell(i, j)))).collect();
    let rows: Vec<BoxBounds> = sv.clone().map(|j| worst(su.clone().map(|i| table.cell(i, j)))).collect();
    let all = worst(columns.iter().copied());
    let width = tile.max - tile.min;
    let budget = 8.0 * tolerance.chord;
    let (mut ru, mut rv) = chord_rates(&columns, &rows, &all, [width.x, width.y], budget);
    let angle = tolerance.angle.min(FRAC_PI_2);
    let strip = |breaks: &[f64], k: usize| breaks[k + 1] - breaks[k];
    for (k, (rate, b)) in su.clone().zip(ru.iter_mut().zip(&columns)) {
        *rate = rate.max(b.turn_u / angle / strip(&table.breaks_u, k));
        *rate = factor * tolerance.max_edge.map_or(*rate, |m| rate.max(std::f64::consts::SQRT_2 * b.u / m));
    }
    for (k, (rate, b)) in sv.clone().zip(rv.iter_mut().zip(&rows)) {
        *rate = rate.max(b.turn_v / angle / strip(&table.breaks_v, k));
        *rate = factor * tolerance.max_edge.map_or(*rate, |m| rate.max(std::f64::consts::SQRT_2 * b.v / m));
    }
    let mut u = Density { breaks: table.breaks_u[su.start..=su.end].to_vec(), rates: ru };
    let mut v = Density { breaks: table.breaks_v[sv.start..=sv.end].to_vec(), rates: rv };
    let mut kept = Kept { lines: true, cells: true };
    let mut round = 0;
    loop {
        let (us, kept_u) = lines(&u, tile.min.x, tile.max.x, &face.creases[0]);
        let (vs, kept_v) = lines(&v, tile.min.y, tile.max.y, &face.creases[1]);
        kept.lines &= kept_u && kept_v;
        let (nu, nv) = ((us.len() - 1) as f64, (vs.len() - 1) as f64);
        // How much too dense in u and in v. A direction of one cell cannot give.
        let over = nu * nv / most_cells as f64;
        let share = |n: f64, other: f64| (if other > 1.0 { over.sqrt() } else { over }).max(n / LINES_OF_TILE).max(1.0);
        let (too_u, too_v) = (share(nu, nv), share(nv, nu));
        if (too_u <= 1.0 && too_v <= 1.0) || round == COARSER {
            return (TileLattice { us, vs }, kept);
        }
        kept.cells &= over <= 1.0;
        kept.lines &= nu.max(nv) <= LINES_OF_TILE;
        round += 1;
        coarsen(&mut u, (tile.min.x, tile.max.x), nu, too_u);
        coarsen(&mut v, (tile.min.y, tile.max.y), nv, too_v);
    }
}

/// Makes a density that gave `n` gaps as much coarser as they are `too_many` times too many: a little more, so that
/// rounding up does not undo it, and from what the gaps are, since more may have been asked than lines are limited to.
fn coarsen(density: &mut Density, (lo, hi): (f64, f64), n: f64, too_many: f64) {
    let mass = density.mass(lo, hi);
    let by = if mass > n { n / mass } else { 1.0 } / (1.01 * too_many);
    density.rates.iter_mut().for_each(|rate| *rate *= by);
}

fn lines(density: &Density, lo: f64, hi: f64, creases: &[f64]) -> (Vec<f64>, bool) {
    let mut out = vec![lo];
    let mut from = lo;
    let mut kept = true;
    for &x in creases.iter().filter(|&&x| x > lo && x < hi).chain([&hi]) {
        kept &= density.spread(from, x, MAX_LINES, &mut out);
        from = x;
    }
    (out, kept)
}

/// Densities of u- and v-lines that keep the deviation, per strip.
fn chord_rates(
    columns: &[BoxBounds],
    rows: &[BoxBounds],
    all: &BoxBounds,
    width: [f64; 2],
    budget: f64,
) -> (Vec<f64>, Vec<f64>) {
    let none = || (vec![0.0; columns.len()], vec![0.0; rows.len()]);
    if all.uu == 0.0 && all.uv == 0.0 && all.vv == 0.0 {
        return none();
    }
    // Straight in one direction: one cell that way, and the other takes the whole budget.
    let ruled = |bounds: &[BoxBounds], second: fn(&BoxBounds) -> f64, across: f64| -> Vec<f64> {
        bounds
            .iter()
            .map(|b| {
                let (m, c) = (second(b), b.uv * across);
                if m > 0.0 { m / ((c * c + budget * m).sqrt() - c) } else { 2.0 * c / budget }
            })
            .collect()
    };
    if all.uu == 0.0 && all.vv > 0.0 {
        return (vec![0.0; columns.len()], ruled(rows, |b| b.vv, width[0]));
    }
    if all.vv == 0.0 && all.uu > 0.0 {
        return (ruled(columns, |b| b.uu, width[1]), vec![0.0; rows.len()]);
    }
    let r = if all.uu > 0.0 { (all.uu / all.vv).sqrt() } else { width[1] / width[0] };
    let need_u = |b: &BoxBounds| b.uu + r * b.uv;
    let need_v = |b: &BoxBounds| b.vv + b.uv / r;
    let share = |need: f64, width: f64| need * width * width / budget;
    // A direction that one cell satisfies leaves the rest of the budget to the other.
    let (one_u, one_v) = (share(need_u(all), width[0]), share(need_v(all), width[1]));
    let share_u = if one_v <= 0.5 {
        1.0 - one_v
    } else if one_u <= 0.5 {
        one_u.max(f64::MIN_POSITIVE)
    } else {
        0.5
    };
    let rate = |need: f64, share: f64| (need / (budget * share)).sqrt();
    (
        columns.iter().map(|b| rate(need_u(b), share_u)).collect(),
        rows.iter().map(|b| rate(need_v(b), (1.0 - share_u).max(one_v.min(0.5)))).collect(),
    )
}
