//! Derivative bounds and a tolerance to the lattice lines of a tile.
//!
//! Deviation: the theorem of Filip, Magedson and Markot (CAGD 3(4), 1986) in its form for any triangle whose box is
//! h_u × h_v: ⅛ (M₁h_u² + 2M₂h_u h_v + M₃h_v²). The mixed term is split between the directions by
//! 2M₂h_u h_v ≤ M₂(r h_u² + h_v²/r), r = h_v/h_u of the cheapest uniform lattice, so that each direction has a density of
//! lines of its own that follows the bounds along it.

use super::plan::{MAX_LINES, TileLattice, Tolerance};
use crate::prepare::{BoxBounds, PreparedFace, Tile};
use std::f64::consts::FRAC_PI_2;

/// A piecewise constant density of lines along one parameter.
pub(super) struct Density {
    /// Strip borders.
    pub(super) breaks: Vec<f64>,
    /// Lines per unit of parameter in each strip.
    pub(super) rates: Vec<f64>,
}

impl Density {
    /// The largest density between `a` and `b`.
    fn most(&self, a: f64, b: f64) -> f64 {
        let first = self.breaks.partition_point(|&x| x <= a).saturating_sub(1);
        self.rates[first..]
            .iter()
            .zip(&self.breaks[first..])
            .take_while(|&(_, &start)| start < b)
            .fold(0.0, |m, (&r, _)| f64::max(m, r))
    }

    /// The furthest `b ≤ end` with `(b − a)·ρ ≤ 1` for the largest ρ on the way.
    fn stride(&self, a: f64, end: f64, scale: f64) -> f64 {
        let mut k = self.breaks.partition_point(|&x| x <= a).saturating_sub(1).min(self.rates.len() - 1);
        let mut most = 0.0_f64;
        loop {
            most = most.max(self.rates[k] * scale);
            let reach = if most > 0.0 { a + 1.0 / most } else { f64::INFINITY };
            let strip_end = if k + 1 == self.rates.len() { f64::INFINITY } else { self.breaks[k + 1] };
            if reach <= strip_end || strip_end >= end {
                // A denser strip may begin before the reach is used up: stop at its border at the earliest.
                return reach.min(end).max(if most > 0.0 { f64::MIN_POSITIVE + a } else { a });
            }
            let next = self.rates[k + 1] * scale;
            if next > most && a + 1.0 / next <= strip_end {
                return strip_end;
            }
            k += 1;
        }
    }

    fn count(&self, a: f64, b: f64, scale: f64, limit: usize) -> (usize, f64) {
        let mut x = a;
        let mut n = 0;
        let mut fill = 1.0;
        while x < b && n < limit {
            let next = self.stride(x, b, scale);
            fill = (next - x) * self.most(x, next) * scale;
            x = next;
            n += 1;
        }
        (n, fill)
    }

    /// Parameters from `a` to `b` so dense that no gap is longer than 1/ρ anywhere in it; as even as that allows.
    /// At least `least` gaps. Appends all but `a`.
    pub(super) fn spread(&self, a: f64, b: f64, least: usize, out: &mut Vec<f64>) {
        let most = self.most(a, b);
        let uniform =
            self.rates.iter().zip(self.breaks.windows(2)).all(|(&r, w)| w[1] <= a || w[0] >= b || r >= 0.999 * most);
        let even = (most * (b - a) * (1.0 - 1e-12)).ceil().max(1.0).min(MAX_LINES as f64) as usize;
        if uniform || even <= least.max(1) {
            let n = even.max(least);
            out.extend((1..n).map(|k| a + (b - a) * k as f64 / n as f64));
            out.push(b);
            return;
        }
        let (n, _) = self.count(a, b, 1.0, MAX_LINES);
        if n < least {
            out.extend((1..least).map(|k| a + (b - a) * k as f64 / least as f64));
            out.push(b);
            return;
        }
        // The largest density factor that needs no more lines makes the last gap as full as the others.
        let (mut low, mut high) = (1.0, 2.0);
        for _ in 0..8 {
            let mid = 0.5 * (low + high);
            if self.count(a, b, mid, n + 1).0 <= n { low = mid } else { high = mid }
        }
        let mut x = a;
        for _ in 0..n {
            x = self.stride(x, b, low);
            if b - x <= 1e-9 * (b - a) {
                break;
            }
            out.push(x);
        }
        out.push(b);
    }
}

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

/// Lattice lines of `tile` for a tolerance: a pure function of its arguments.
pub(super) fn lattice(face: &PreparedFace, tile: &Tile, tolerance: &Tolerance) -> TileLattice {
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
        *rate = tolerance.max_edge.map_or(*rate, |m| rate.max(std::f64::consts::SQRT_2 * b.u / m));
    }
    for (k, (rate, b)) in sv.clone().zip(rv.iter_mut().zip(&rows)) {
        *rate = rate.max(b.turn_v / angle / strip(&table.breaks_v, k));
        *rate = tolerance.max_edge.map_or(*rate, |m| rate.max(std::f64::consts::SQRT_2 * b.v / m));
    }
    TileLattice {
        us: lines(&table.breaks_u[su.start..=su.end], ru, tile.min.x, tile.max.x, &face.creases[0]),
        vs: lines(&table.breaks_v[sv.start..=sv.end], rv, tile.min.y, tile.max.y, &face.creases[1]),
    }
}

fn lines(breaks: &[f64], rates: Vec<f64>, lo: f64, hi: f64, creases: &[f64]) -> Vec<f64> {
    let density = Density { breaks: breaks.to_vec(), rates };
    let mut out = vec![lo];
    let mut from = lo;
    for &x in creases.iter().filter(|&&x| x > lo && x < hi).chain([&hi]) {
        density.spread(from, x, 1, &mut out);
        from = x;
    }
    out
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
