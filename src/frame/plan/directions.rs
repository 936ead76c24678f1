//! A chord tolerance -> how dense lines across u and across v must be.
//!
//! Deviation: the theorem of Filip, Magedson and Markot (CAGD 3(4), 1986) in its form for any triangle whose box is
//! h_u × h_v: ⅛ (M₁h_u² + 2M₂h_u h_v + M₃h_v²). Each direction has its own density of lines, which follows the bounds
//! along it. The mixed term is split between the directions by 2M₂h_u h_v ≤ M₂(r h_u² + h_v²/r), with r = h_v/h_u of
//! the cheapest uniform lattice; or, once the gaps of one direction are known, the other one's follow from the whole.
//! The tolerance goes to whichever direction makes use of it (decision 071).

use super::density::Density;
use super::output::MAX_LINES;
use crate::math::lanes::{larger, smaller};
use crate::prepare::internals::{Bend, BoxBounds};
use smallvec::SmallVec;

/// Maximum change of a first derivative along the surface across a cell, as a multiple of its largest length there.
/// Where the derivative reverses, triangles that are positive in (u,v) fold over. At 1 a side can shrink to a point;
/// the rest allows for the slack of the bounds.
const UNEVEN: f64 = 1.25;

/// What lines across one parameter, u or v, must meet in a strip of a tile: the largest of the boxes under it.
#[derive(Clone, Copy, Default)]
pub(super) struct Strip {
    /// Its width.
    pub(super) width: f64,
    /// Second derivative by that parameter, and by both.
    pub(super) own: Bend,
    pub(super) mixed: Bend,
    /// First derivative, also without regard to tolerances.
    pub(super) speed: f64,
    pub(super) fastest: f64,
    /// Turn of the normal along a box; once all boxes have joined, per unit of parameter.
    pub(super) turn: f64,
    /// Lines per unit of parameter that keep the parametrisation even within a cell.
    pub(super) even: f64,
}

impl Strip {
    /// The strips across u and v of a single box. `share` is the tile's tolerance as a fraction of the box's own.
    #[inline(always)]
    pub(super) fn of(BoxBounds { uu, uv, vv, u, v, turn_u, turn_v }: &BoxBounds, share: f64) -> [Self; 2] {
        let ratio = |change: f64, of: f64| if of > 0.0 { change / (UNEVEN * of) } else { 0.0 };
        let even = |own: &Bend, speed: f64, other: f64| larger(ratio(uv.slide, other), ratio(own.slide, speed));
        // A larger tolerance for a box counts as smaller derivatives.
        let strip = |own: &Bend, speed: f64, turn: f64, even: f64| Self {
            width: 0.0,
            own: own.scaled(share),
            mixed: uv.scaled(share),
            speed: speed * share,
            fastest: speed,
            turn,
            even,
        };
        [strip(uu, *u, *turn_u, even(uu, *u, *v)), strip(vv, *v, *turn_v, even(vv, *v, *u))]
    }

    #[inline(always)]
    pub(super) fn join(&mut self, other: &Self) {
        self.own = self.own.max(other.own);
        self.mixed = self.mixed.max(other.mixed);
        self.speed = larger(other.speed, self.speed);
        self.fastest = larger(other.fastest, self.fastest);
        self.turn = larger(other.turn, self.turn);
        self.even = larger(other.even, self.even);
    }
}

/// How much of the budget the second derivative across rulings may take from the twist, as a share of the twist's.
const BENT: f64 = 0.05;

/// Number of cells along the rulings of a tile.
///
/// The twist lifts the surface by the product of a cell's sides, so that the number of cells hardly depends on their
/// shape. With one cell along a ruling, normals and areas would not converge with the tolerance, as on Schwarz's
/// lantern. Cells become as short along the rulings as costs a twentieth more of them, but not shorter than there are
/// rows across.
fn cells_along_rulings(twist: f64, bend: f64, along: f64, across: f64, budget: f64) -> f64 {
    let even = (2.0 * twist * along * across / budget).sqrt();
    let cheap = twist * along * (4.0 * BENT / (budget * bend)).sqrt();
    let most = smaller(even, cheap).floor();
    if most > 1.0 { most } else { 1.0 }
}

/// Numbers of gaps up to which all ways to round them are compared: beyond, rounding saves little.
const FEW: usize = 24;

/// Lines per unit of parameter, strip by strip.
pub(super) type Rates = SmallVec<[f64; 8]>;

/// What decides how dense the lines of a tile are in each direction: across u, and across v.
pub(super) struct Directions<'a> {
    pub(super) strips: [&'a [Strip]; 2],
    /// Borders of the strips, and of the tile.
    pub(super) breaks: [&'a [f64]; 2],
    pub(super) ends: [(f64, f64); 2],
    /// Largest second derivatives: uu, uv, vv.
    pub(super) all: [Bend; 3],
    /// Eight times the chord tolerance.
    pub(super) budget: f64,
    /// What other criteria ask for.
    pub(super) others: [Rates; 2],
    /// Whether the number of gaps may be rounded.
    pub(super) round: [bool; 2],
}

impl Directions<'_> {
    /// Sets the densities of lines that meet the chord tolerance where normals turn within a cell by at most the arc
    /// sine of `share`, and that are at least what other criteria ask for. Numbers of gaps are rounded so that there
    /// are few cells.
    pub(super) fn rates(&self, share: f64, out: &mut [Vec<f64>; 2]) {
        let (first, [rates, second]) = self.split(share);
        for (axis, rates) in [(first, rates), (1 - first, second)] {
            out[axis].clear();
            out[axis].extend_from_slice(&rates);
        }
    }

    /// A direction, its densities, and those of the other.
    fn split(&self, share: f64) -> (usize, [Rates; 2]) {
        let [uu, uv, vv] = self.all.map(|bend| bend.along(share));
        if self.budget == f64::INFINITY || uu == 0.0 && uv == 0.0 && vv == 0.0 {
            return (0, self.others.clone());
        }
        let ratio = if uu > 0.0 || vv > 0.0 {
            [(uu / vv).sqrt(), (vv / uu).sqrt()]
        } else {
            let longest =
                |axis: usize| self.gaps(axis, &self.others[axis]).fold(0.0, |most, (_, gap)| larger(gap, most));
            let [u, v] = [longest(0), longest(1)];
            [v / u, u / v]
        };
        let needs = Needs { directions: self, share, ratio };
        // A direction that is straight where the other is not takes nothing.
        let straight = |axis: usize| [uu, vv][axis] == 0.0 && [vv, uu][axis] > 0.0;
        let modest = (0..2).find(|&axis| straight(axis)).or_else(|| (0..2).find(|&axis| needs.is_modest(axis)));
        if let Some(first) = modest {
            let mut rates = self.others[first].clone();
            let width = [0, 1].map(|axis| self.width(axis));
            let twist = self.all[1].lift;
            let cells = cells_along_rulings(twist, [vv, uu][first], width[first], width[1 - first], self.budget);
            if cells > 1.0 {
                rates.iter_mut().for_each(|rate| *rate = larger(*rate, cells / width[first]));
            }
            let ((_, rates), _) = self.rounded(first, rates);
            let second = needs.second(first, &rates);
            return (first, [rates, second]);
        }
        self.fewest_cells(&needs)
    }

    /// The densities with the fewest cells, of those where one direction takes about half of the tolerance, with its
    /// gaps rounded, and the other has the rest.
    fn fewest_cells(&self, needs: &Needs<'_>) -> (usize, [Rates; 2]) {
        let mut best = (0, [Rates::new(), Rates::new()]);
        let mut least = usize::MAX;
        for first in 0..2 {
            let (up, down) = self.rounded(first, needs.half(first));
            for (gaps, rates) in [Some(up), down].into_iter().flatten() {
                let second = needs.second(first, &rates);
                let (lo, hi) = self.ends[1 - first];
                // Counts no further than to what is best so far.
                let limit = least.div_ceil(gaps).min(MAX_LINES);
                let cells = gaps * self.density(1 - first, &second).fewest(lo, hi, limit);
                if cells < least {
                    least = cells;
                    best = (first, [rates, second]);
                }
            }
        }
        best
    }

    /// The densities of a direction, scaled to a whole number of gaps that are all full if such a scale is found, and
    /// this number; and the same for one gap less, unless there are many gaps or other criteria ask for more.
    fn rounded(&self, axis: usize, rates: Rates) -> ((usize, Rates), Option<(usize, Rates)>) {
        let (lo, hi) = self.ends[axis];
        let (n, full) = self.density(axis, &rates).fewest_and_full(lo, hi, MAX_LINES);
        if !self.round[axis] || full == 0.0 || n > FEW {
            return ((n, rates), None);
        }
        let scaled = |n: usize, least: &[f64]| {
            let scaled: Rates = rates.iter().map(|rate| rate * (n as f64 / full)).collect();
            let is_enough = scaled.iter().zip(least).all(|(rate, least)| rate >= least);
            (n > 0 && is_enough && self.density(axis, &scaled).fewest(lo, hi, n + 1) <= n).then_some((n, scaled))
        };
        let (up, down) = (scaled(n, &[]), scaled(n - 1, &self.others[axis]));
        (up.unwrap_or((n, rates)), down)
    }

    fn width(&self, axis: usize) -> f64 {
        self.ends[axis].1 - self.ends[axis].0
    }

    fn density<'r>(&'r self, axis: usize, rates: &'r [f64]) -> Density<'r> {
        Density { breaks: self.breaks[axis], rates }
    }

    /// The strips of a direction, and the longest gap in each at these densities.
    fn gaps<'r>(&'r self, axis: usize, rates: &'r [f64]) -> impl Iterator<Item = (&'r Strip, f64)> {
        let width = self.width(axis);
        self.strips[axis].iter().zip(rates).map(move |(strip, rate)| (strip, smaller(1.0 / rate, width)))
    }
}

/// What the chord tolerance needs where normals turn within a cell by at most a given angle.
struct Needs<'a> {
    directions: &'a Directions<'a>,
    /// The sine of that angle.
    share: f64,
    /// r, and 1/r.
    ratio: [f64; 2],
}

impl Needs<'_> {
    fn own(&self, strip: &Strip) -> f64 {
        strip.own.along(self.share)
    }

    fn mixed(&self, strip: &Strip) -> f64 {
        strip.mixed.along(self.share)
    }

    /// A direction's second derivative with its part of the mixed one.
    fn whole(&self, axis: usize, strip: &Strip) -> f64 {
        self.own(strip) + self.ratio[axis] * self.mixed(strip)
    }

    /// Whether the longest gaps that other criteria allow take at most half of the budget. They then cost less than
    /// shorter ones would: the other direction has the rest.
    fn is_modest(&self, axis: usize) -> bool {
        let take = |most, (strip, gap): (&Strip, f64)| larger(self.whole(axis, strip) * gap * gap, most);
        self.directions.gaps(axis, &self.directions.others[axis]).fold(0.0, take) <= 0.5 * self.directions.budget
    }

    /// Densities of a direction that take half of the budget.
    fn half(&self, axis: usize) -> Rates {
        let rate = |strip: &Strip| (self.whole(axis, strip) / (0.5 * self.directions.budget)).sqrt();
        let strips = self.directions.strips[axis].iter().zip(&self.directions.others[axis]);
        strips.map(|(strip, other)| larger(rate(strip), *other)).collect()
    }

    /// Densities of the other direction, which has what the first leaves at its densities `rates`.
    fn second(&self, first: usize, rates: &[f64]) -> Rates {
        // What the gaps of the first direction take, without and with their part of the mixed term.
        let (mut alone, mut whole, mut across) = (0.0, 0.0, 0.0);
        for (strip, gap) in self.directions.gaps(first, rates) {
            alone = larger(self.own(strip) * gap * gap, alone);
            whole = larger(self.whole(first, strip) * gap * gap, whole);
            across = larger(gap, across);
        }
        let (alone, whole) = (self.directions.budget - alone, self.directions.budget - whole);
        let second = 1 - first;
        // Either bound holds at each point by itself, so that each strip takes the better one.
        let rate = |strip: &Strip| {
            let (own, c) = (self.own(strip), self.mixed(strip) * across);
            let exact = if alone > 0.0 { (c + (c * c + alone * own).sqrt()) / alone } else { f64::INFINITY };
            let split = if whole > 0.0 { (self.whole(second, strip) / whole).sqrt() } else { f64::INFINITY };
            smaller(split, exact)
        };
        let strips = self.directions.strips[second].iter().zip(&self.directions.others[second]);
        strips.map(|(strip, other)| larger(rate(strip), *other)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::judge;
    use arbitrary::Unstructured;

    /// A tile of boxes of length 1, row by row in u: their lifts uu, uv and vv. `others`: the same density everywhere.
    fn rates(boxes: &[&[[f64; 3]]], others: [f64; 2]) -> [Vec<f64>; 2] {
        let mut strips = [vec![Strip::default(); boxes.len()], vec![Strip::default(); boxes[0].len()]];
        for (i, row) in boxes.iter().enumerate() {
            for (j, lifts) in row.iter().enumerate() {
                let [uu, uv, vv] = lifts.map(|lift| Bend { norm: lift, lift, slide: 0.0 });
                let [column, row] = Strip::of(&BoxBounds { uu, uv, vv, ..BoxBounds::default() }, 1.0);
                strips[0][i].join(&column);
                strips[1][j].join(&row);
            }
        }
        let most = |k: usize| {
            let lift = boxes.iter().copied().flatten().fold(0.0, |most, lifts| larger(lifts[k], most));
            Bend { norm: lift, lift, slide: 0.0 }
        };
        let breaks = strips.each_ref().map(|strips| (0..=strips.len()).map(|k| k as f64).collect::<Vec<_>>());
        let directions = Directions {
            strips: [&strips[0], &strips[1]],
            breaks: [&breaks[0], &breaks[1]],
            ends: breaks.each_ref().map(|breaks| (0.0, breaks[breaks.len() - 1])),
            all: [most(0), most(1), most(2)],
            budget: 1.0,
            others: [0, 1].map(|axis| Rates::from_elem(others[axis], strips[axis].len())),
            round: [true; 2],
        };
        let mut out = [Vec::new(), Vec::new()];
        directions.rates(0.0, &mut out);
        out
    }

    #[test]
    fn every_box_keeps_the_tolerance() {
        let property = |u: &mut Unstructured<'_>| -> arbitrary::Result<()> {
            let (columns, rows) = (u.int_in_range(1..=4_usize)?, u.int_in_range(1..=4_usize)?);
            let size = |u: &mut Unstructured<'_>| -> arbitrary::Result<f64> {
                Ok(f64::from(u.int_in_range(0..=9_u8)?) * 10.0_f64.powi(u.int_in_range(-6..=4)?))
            };
            let mut boxes = vec![Vec::new(); columns];
            for column in &mut boxes {
                for _ in 0..rows {
                    column.push([size(u)?, size(u)?, size(u)?]);
                }
            }
            let others = [size(u)?, size(u)?];
            let boxes: Vec<&[[f64; 3]]> = boxes.iter().map(Vec::as_slice).collect();
            let rates = rates(&boxes, others);
            let longest = |axis: usize, k: usize, width: usize| (1.0 / rates[axis][k]).min(width as f64);
            for (i, column) in boxes.iter().enumerate() {
                for (j, [uu, uv, vv]) in column.iter().enumerate() {
                    let (h, k) = (longest(0, i, columns), longest(1, j, rows));
                    let lift = uu * h * h + 2.0 * uv * h * k + vv * k * k;
                    assert!(lift <= 1.0 + 1e-9, "{boxes:?} {others:?} {lift}");
                    // What makes gaps whole is a division: it may round.
                    let least = |axis: usize| others[axis] * (1.0 - 1e-12);
                    assert!(rates[0][i] >= least(0) && rates[1][j] >= least(1), "{boxes:?} {others:?}");
                }
            }
            Ok(())
        };
        judge!(10_000, 512, |bytes: &[u8]| property(&mut Unstructured::new(bytes)).is_ok());
    }

    #[test]
    fn a_direction_has_what_the_other_leaves() {
        // Gaps of a tenth, for the sake of angles, take a hundredth.
        let [_, v] = rates(&[&[[1.0, 0.0, 100.0]]], [10.0, 0.0]);
        assert!((v[0] - (100.0_f64 / 0.99).sqrt()).abs() < 1e-9, "{v:?}");
        // Of two and a half gaps each way, two and four make eight cells; three and three would make nine.
        let [u, v] = rates(&[&[[3.125, 0.0, 3.125]]], [0.0; 2]);
        assert!(u == [2.0] && (v[0] - (3.125_f64 / (1.0 - 3.125 / 4.0)).sqrt()).abs() < 1e-9, "{u:?} {v:?}");
        // Of 1.2 each way, two and one make two cells.
        let [u, v] = rates(&[&[[0.72, 0.0, 0.72]]], [0.0; 2]);
        assert!(u[0].ceil() * v[0].ceil() == 2.0, "{u:?} {v:?}");
    }

    #[test]
    fn a_straight_direction_takes_nothing() {
        // As on a cone: the mixed derivative is tangential, and one strip has none at all.
        for boxes in [[[0.0, 1.0, 4.0], [0.0, 0.0, 4.0]], [[0.0, 0.0, 4.0], [0.0, 1e-9, 4.0]]] {
            let [u, v] = rates(&[&boxes[..1], &boxes[1..]], [0.0; 2]);
            assert!(u.iter().all(|rate| *rate <= 0.5), "{u:?}");
            assert!(v[0] >= 2.0 && v[0] < 5.0, "{v:?}");
        }
    }
}
