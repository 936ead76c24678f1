//! An edge, its tolerance and the lattices of its tiles -> its tessellants.

use super::density::Density;
use super::output::{CellWalk, EdgePolyline, TileLattice, is_even, most_lines};
use super::rows::PlanRows;
use crate::frame::tolerance::{BoxTolerances, Tolerance, dilate, most_touched};
use crate::math::lanes::{larger, smaller};
use crate::model::TileId;
use crate::prepare::internals::{EdgeImage, EdgeShape, PreparedEdge, StripBounds, TileUse};
use smallvec::SmallVec;
use std::f64::consts::FRAC_PI_2;

/// Maximum number of segments of one edge, over all its breaks. A thread of five thousand turns needs half of them;
/// more need only curves whose speed varies by many decades, and that is noise.
const SEGMENTS_OF_EDGE: usize = 1 << 18;
/// Number of segments that an edge may always have between two breaks, however many these are.
const LEAST_LIMIT: usize = 64;

/// Makes polylines, in reused buffers. Results do not depend on earlier calls.
#[derive(Default)]
pub(crate) struct Tessellants {
    shares: Vec<f64>,
    /// Densities of the strips of the edge's bounds, and of the finer strips of its images.
    of_bounds: Vec<f64>,
    rates: Vec<f64>,
    wanted: Vec<f64>,
    ts: Vec<f64>,
}

/// Whether the breaks alone meet any chord and angle tolerance: those of a straight edge whose tiles have one cell
/// each. Not those of a closed edge.
pub(crate) fn is_bare(edge: &PreparedEdge, tiles: &PlanRows<TileLattice>) -> bool {
    let single = |tile: TileId| tiles[tile.0 as usize].cells() == (1, 1);
    edge.straight && !is_closed(edge) && edge.uses.iter().all(|place| single(place.tile))
}

/// The breaks alone, where [`is_bare`] says that they are enough.
pub(crate) fn bare(edge: &PreparedEdge, tiles: &PlanRows<TileLattice>) -> Option<EdgePolyline> {
    is_bare(edge, tiles).then(|| breaks_alone(edge))
}

/// The breaks without anything between. None for an edge that no tile uses.
fn breaks_alone(edge: &PreparedEdge) -> EdgePolyline {
    match &edge.breaks[..] {
        _ if edge.uses.is_empty() => EdgePolyline::default(),
        // Nearly all edges have two. This takes a tenth of the time.
        [start, end] => EdgePolyline {
            ts: SmallVec::from_buf([start.t, end.t]),
            breaks: SmallVec::from_buf_and_len([0, 1, 0, 0], 2),
        },
        breaks => EdgePolyline { ts: breaks.iter().map(|b| b.t).collect(), breaks: (0..breaks.len() as u32).collect() },
    }
}

/// Whether the angle tolerance alone needs as many segments in every strip as both tolerances do. Then a coarser chord
/// tolerance changes nothing.
pub(crate) fn turns_more_than_bends(edge: &PreparedEdge, tolerance: &Tolerance) -> bool {
    let own = OwnDensity::of(edge, tolerance, 1.0);
    own.strips.iter().enumerate().all(|(k, &StripBounds { second, turn, .. })| {
        second * own.per_second * own.width(k).powi(2) <= (turn * own.per_turn).powi(2)
    })
}

/// Whether the edge is a curve that ends where it begins, without breaks between.
fn is_closed(edge: &PreparedEdge) -> bool {
    let ends = if let [start, end] = &edge.breaks[..] { start.point == end.point } else { false };
    ends && matches!(edge.shape, EdgeShape::Curve(_))
}

impl Tessellants {
    /// Tessellants of an edge, and whether they meet the density that the tolerance needs, times `factor`. A segment
    /// spans at most one cell of any lattice along the edge.
    pub(crate) fn polyline(
        &mut self,
        edge: &PreparedEdge,
        cells: &mut NarrowestCells<'_>,
        need: &BoxTolerances,
        factor: f64,
    ) -> (EdgePolyline, bool) {
        let own = OwnDensity::of(edge, &need.tolerance, factor);
        if edge.uses.is_empty() || one_is_enough(edge, &own, cells) {
            return (breaks_alone(edge), true);
        }
        let most = most_lines(need.tolerance.around(need.radius, true));
        let mut shares = std::mem::take(&mut self.shares);
        let mut reach = usize::from(!need.is_even());
        let made = loop {
            // A segment in several strips must meet the tolerances of all of them.
            dilate(&need.shares, need.shares.len().max(1), reach, &mut shares);
            let made = self.spread(edge, cells, &own, (&shares, most));
            let touched = if reach == 0 { 1 } else { most_touched(&edge.bounds.breaks, &made.0.ts) };
            if touched <= reach + 1 {
                break made;
            }
            reach = touched - 1;
        };
        self.shares = shares;
        made
    }

    /// Tessellants at `shares[k]` of the tolerance in strip k, or without shares at all of it; at most so many segments
    /// between two breaks.
    fn spread(
        &mut self,
        edge: &PreparedEdge,
        cells: &mut NarrowestCells<'_>,
        own: &OwnDensity<'_>,
        (shares, most): (&[f64], usize),
    ) -> (EdgePolyline, bool) {
        let Self { of_bounds, rates, wanted, ts, .. } = self;
        let bounds = &edge.bounds;
        of_bounds.clear();
        of_bounds.extend((0..own.strips.len()).map(|k| own.strip(k, shares.get(k).copied().unwrap_or(1.0))));
        let breaks = edge.images.strips(bounds);
        refine(&bounds.breaks, of_bounds, breaks, rates);
        for (k, TileUse { tile, .. }) in edge.uses.iter().enumerate() {
            let lattice = &cells.tiles[tile.0 as usize];
            if lattice.us.len() > 2 || lattice.vs.len() > 2 {
                let narrowest = |axis: usize| cells.narrowest(k, *tile, axis);
                limit_to_cells(&edge.images.image(k), (lattice, narrowest), breaks, rates, wanted);
            }
        }
        if is_closed(edge) {
            // At least three segments.
            let closed = 3.0 / (edge.breaks[1].t - edge.breaks[0].t);
            rates.iter_mut().for_each(|rate| *rate = rate.max(closed));
        }
        let density = Density { breaks, rates };
        ts.clear();
        ts.push(edge.breaks[0].t);
        let mut at = SmallVec::with_capacity(edge.breaks.len());
        at.push(0);
        let mut kept = true;
        let limit = (SEGMENTS_OF_EDGE / (edge.breaks.len() - 1)).clamp(LEAST_LIMIT, most);
        for w in edge.breaks.windows(2) {
            kept &= density.spread(w[0].t, w[1].t, limit, ts);
            at.push(u32::try_from(ts.len() - 1).unwrap_or(u32::MAX));
        }
        (EdgePolyline { ts: SmallVec::from_slice(ts), breaks: at }, kept)
    }
}

/// The density of tessellants that an edge needs for its own sake.
struct OwnDensity<'a> {
    strips: &'a [StripBounds],
    /// Borders of the strips.
    borders: &'a [f64],
    /// What the chord asks: the square of the density, for a second derivative of 1.
    per_second: f64,
    /// What the angle asks: the density times the strip's width, for a turn of 1 radian. At any tolerance at least one
    /// segment per right angle: one that turns by more has another shape, and may cross itself.
    per_turn: f64,
    /// What the length of segments asks: the density, for a first derivative of 1.
    per_first: f64,
}

impl<'a> OwnDensity<'a> {
    /// For a tolerance, with its density times `factor`.
    fn of(edge: &'a PreparedEdge, tolerance: &Tolerance, factor: f64) -> Self {
        let per_turn = larger(factor / tolerance.angle.min(FRAC_PI_2), 1.0 / FRAC_PI_2);
        let per_first = tolerance.max_edge.map_or(0.0, |m| factor / m);
        // A straight edge bends and turns by rounding only. Its length still counts.
        let [per_second, per_turn] =
            if edge.straight { [0.0; 2] } else { [factor * factor / (8.0 * tolerance.chord), per_turn] };
        let (strips, borders) = (&edge.bounds.strips[..], &edge.bounds.breaks[..]);
        Self { strips, borders, per_second, per_turn, per_first }
    }

    /// In strip `k`, at `share` of the tolerance. What is not a number asks nothing.
    #[inline(always)]
    fn strip(&self, k: usize, share: f64) -> f64 {
        let StripBounds { first, second, turn, .. } = self.strips[k];
        let by_chord = larger((second * share * self.per_second).sqrt(), 0.0);
        let by_turn = larger(turn * self.per_turn / self.width(k), by_chord);
        larger(first * share * self.per_first, by_turn)
    }

    #[inline(always)]
    fn width(&self, k: usize) -> f64 {
        self.borders[k + 1] - self.borders[k]
    }

    /// Whether a segment of this length meets the densities of all strips, at the whole tolerance.
    #[inline(always)]
    fn allows(&self, length: f64) -> bool {
        self.strips.iter().enumerate().all(|(k, &StripBounds { first, second, turn, .. })| {
            second * self.per_second * (length * length) <= 1.0
                && turn * self.per_turn * length <= self.width(k)
                && first * self.per_first * length <= 1.0
        })
    }
}

/// The breaks alone, if one segment certainly meets this tolerance, with its density times `factor`, all along the
/// edge. [`Tessellants::polyline`] makes the same at any larger tolerance.
pub(crate) fn bare_within(
    edge: &PreparedEdge,
    cells: &mut NarrowestCells<'_>,
    tolerance: &Tolerance,
    factor: f64,
) -> Option<EdgePolyline> {
    one_is_enough(edge, &OwnDensity::of(edge, tolerance, factor), cells).then(|| breaks_alone(edge))
}

/// Whether one segment certainly meets all densities, up to the rounding of [`EdgeImage::rates`]. `false` says nothing:
/// each cell counts as the narrowest of its lattice.
fn one_is_enough(edge: &PreparedEdge, own: &OwnDensity<'_>, cells: &mut NarrowestCells<'_>) -> bool {
    let [start, end] = &edge.breaks[..] else { return false };
    let (length, tiles) = (end.t - start.t, cells.tiles);
    !is_closed(edge)
        && own.allows(length)
        && edge.uses.iter().enumerate().all(|(k, place)| {
            let TileLattice { us, vs, .. } = &*tiles[place.tile.0 as usize];
            if us.len() == 2 && vs.len() == 2 {
                return true;
            }
            let fastest = edge.images.spans[k].fastest;
            let mut fits = |axis: usize, lines: &[f64]| {
                let share = f64::from(fastest[axis]) * length;
                // The narrowest cell is no wider than the mean.
                share * (lines.len() - 1) as f64 <= 1.0 && share <= cells.narrowest(k, place.tile, axis)
            };
            fits(0, us) && fits(1, vs)
        })
}

/// The narrowest gaps of the lattices of a part. Edges that follow each other mostly run through the same tile.
pub(crate) struct NarrowestCells<'a> {
    tiles: &'a PlanRows<TileLattice>,
    /// The last tile, and its gaps in u and in v, NaN where they are not known. One entry for even numbers of uses, one
    /// for odd ones: most edges have two uses.
    last: [(TileId, [f64; 2]); 2],
}

impl<'a> NarrowestCells<'a> {
    /// Of these tiles.
    pub(crate) fn of(tiles: &'a PlanRows<TileLattice>) -> Self {
        Self { tiles, last: [(TileId(0), [f64::NAN; 2]); 2] }
    }

    /// The narrowest gap along an axis of a tile, for an edge's use `k`.
    fn narrowest(&mut self, k: usize, tile: TileId, axis: usize) -> f64 {
        let (last, known) = &mut self.last[k & 1];
        if *last != tile {
            (*last, *known) = (tile, [f64::NAN; 2]);
        }
        if known[axis].is_nan() {
            let TileLattice { us, vs, .. } = &*self.tiles[tile.0 as usize];
            known[axis] = narrowest([us, vs][axis]);
        }
        known[axis]
    }
}

/// The narrowest gap, as a share of the way from the first line to the last.
fn narrowest(lines: &[f64]) -> f64 {
    let (inner, last) = (&lines[1..], lines.len() - 1);
    let least = lines.iter().zip(inner).fold(f64::INFINITY, |least, (a, b)| smaller(b - a, least));
    least / (lines[last] - lines[0])
}

/// Copies the densities of the strips `of` to the finer strips `into`.
fn refine(of: &[f64], rates: &[f64], into: &[f64], out: &mut Vec<f64>) {
    out.clear();
    if into.len() == of.len() {
        out.extend_from_slice(rates);
        return;
    }
    let mut k = 0;
    out.extend(into.windows(2).map(|strip| {
        while k + 1 < rates.len() && of[k + 1] <= strip[0] {
            k += 1;
        }
        rates[k]
    }));
}

/// A place in a tile, by its shares of the way across: in cells along u and along v. 0 where nothing moves.
#[inline(always)]
fn cells_at([along_u, along_v]: &mut [Option<CellWalk<'_>>; 2], [u, v]: [f32; 2]) -> (f64, f64) {
    let at = |along: &mut Option<CellWalk<'_>>, share: f32| {
        along.as_mut().map_or(0.0, |along| along.at_share(f64::from(share)))
    };
    (at(along_u, u), at(along_v, v))
}

/// Raises `rates` so that a segment spans at most one cell of `lattice` in each direction.
///
/// An image that runs back and forth over the lattice far more often than any real edge is noise. It gets as many
/// segments as 64 traversals of the lattice. `narrowest`: the narrowest gap of the lattice along an axis.
fn limit_to_cells(
    image: &EdgeImage<'_>,
    (lattice, narrowest): (&TileLattice, impl FnMut(usize) -> f64),
    breaks: &[f64],
    rates: &mut [f64],
    wanted: &mut Vec<f64>,
) {
    /// Maximum number of traversals of the lattice by one edge. The outline of a gear or a word as one spline has a few
    /// dozen.
    const TRAVERSALS: f64 = 64.0;
    /// What rounding may add: a share of rates, which are of single precision, and as much of a cell.
    const ROUNDING: f64 = 1e-6;
    let (nu, nv) = lattice.cells();
    let (nu, nv) = (f64::from(nu), f64::from(nv));
    let real = image.ways.iter().all(|&ways| f64::from(ways) <= TRAVERSALS);
    if real && is_even(&lattice.us) && is_even(&lattice.vs) {
        for (rate, &[u, v]) in rates.iter_mut().skip(image.strip).zip(image.rates) {
            *rate = larger(larger(f64::from(u) * nu, f64::from(v) * nv), *rate);
        }
        return;
    }
    let Some((start, strips)) = image.steps() else { return };
    // The images of borders between tiles move along one axis.
    let walk = |axis: usize, lines| (image.ways[axis] != 0.0).then(|| CellWalk::from_share(lines, start[axis]));
    let mut along = [walk(0, &lattice.us), walk(1, &lattice.vs)];
    let length_of = |ends: &[f64]| smaller(ends[1], image.ends[1]) - larger(ends[0], image.ends[0]);
    // The most cells that a step crosses per share of the tile.
    let per = [0, 1].map(narrowest).map(|gap| (1.0 + ROUNDING) / gap);
    let strips = strips.zip(breaks[image.strip..].windows(2));
    let is_noise = f64::from(image.ways[0]) * per[0] + f64::from(image.ways[1]) * per[1] > TRAVERSALS * (nu + nv);
    wanted.clear();
    let (mut total, mut last, mut from) = (0.0, start, None);
    for ((rate, &[u, v]), (steps, ends)) in rates.iter().skip(image.strip).zip(image.rates).zip(strips) {
        let length = length_of(ends);
        let bound = larger(f64::from(u) * per[0], f64::from(v) * per[1]);
        if !is_noise && bound * length + ROUNDING <= *rate * length {
            // Cells limit segments less than the rest does.
            wanted.push(0.0);
            from = None;
        } else {
            let begin = from.unwrap_or_else(|| cells_at(&mut along, last));
            let (most, end) = longest_step(&mut along, begin, steps);
            let cells = image.steps as f64 * most;
            wanted.push(cells / length);
            total += cells;
            from = Some(end);
        }
        last = steps[steps.len() - 1];
    }
    let share = if is_noise { (TRAVERSALS * (nu + nv) / total).min(1.0) } else { 1.0 };
    for (rate, wanted) in rates.iter_mut().skip(image.strip).zip(&*wanted) {
        *rate = larger(*wanted * share, *rate);
    }
}

/// The most cells along u or v between two of these places in a tile, the first of them `from`; and the last place.
#[inline(always)]
fn longest_step(along: &mut [Option<CellWalk<'_>>; 2], mut from: (f64, f64), places: &[[f32; 2]]) -> (f64, (f64, f64)) {
    let mut most = 0.0_f64;
    for &place in places {
        let to = cells_at(along, place);
        most = larger((to.1 - from.1).abs(), larger((to.0 - from.0).abs(), most));
        from = to;
    }
    (most, from)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::plan::limits::PlanLimits;
    use crate::frame::plan::make::plan_within;
    use crate::frame::plan::output::{MAX_LINES, PartPlan, cell_coordinate};
    use crate::model::{FreeTrims, Model, PartBuilder, ShellKind, TrimCurve, TrimRule, shapes};
    use crate::prepare::{PrepareOptions, prepare};
    use crate::sequence::random::SplitMix;
    use glam::DVec2;
    use std::f64::consts::TAU;

    /// A bent sheet with a hole of many short sides.
    fn sheet() -> Model {
        let side = |k: u32| DVec2::splat(0.5) + DVec2::from_angle(TAU * f64::from(k) / 64.0) * 0.3;
        let curves = vec![TrimCurve::polygon((0..64).map(side).collect()).reversed()];
        let mut part = PartBuilder::new("sheet");
        let shell = part.plain_shell(ShellKind::Open);
        let surface = shapes::wave().faces.swap_remove(0).surface;
        part.trimmed_face(surface, shell, FreeTrims { rule: TrimRule::Handedness, curves }, false);
        part.finish().unwrap().into()
    }

    #[test]
    fn one_segment_is_what_the_densities_give() {
        let (mut one, mut others) = (0, 0);
        for model in shapes::NAMES.iter().filter_map(|name| shapes::by_name(name)).chain([sheet()]) {
            let prepared = prepare(model, &PrepareOptions::DEFAULT).unwrap();
            for (chord, angle, max_edge) in [(1.0, 1.5, None), (0.05, 0.5, None), (0.01, 0.1, Some(5.0))] {
                let tolerance = Tolerance { chord, angle, max_edge };
                let plan = plan_within(&prepared, &tolerance, &PlanLimits::DEFAULT);
                for (part, PartPlan { tiles, .. }) in prepared.parts.iter().zip(&plan.parts) {
                    let mut cells = NarrowestCells::of(tiles);
                    // A factor makes the edge coarser or finer. The lattices stay.
                    let edges = part.edges.iter().filter(|edge| !edge.uses.is_empty());
                    for (edge, factor) in edges.flat_map(|edge| [0.01, 1.0, 3.0].map(|factor| (edge, factor))) {
                        let own = OwnDensity::of(edge, &tolerance, factor);
                        let made = Tessellants::default().spread(edge, &mut cells, &own, (&[], MAX_LINES));
                        if one_is_enough(edge, &own, &mut cells) {
                            assert_eq!(made, (breaks_alone(edge), true), "{tolerance:?}, {factor}");
                            one += usize::from(!edge.straight);
                        } else {
                            others += usize::from(made.0.ts.len() > 2);
                        }
                    }
                }
            }
        }
        assert!(one > 100 && others > 100, "{one} bent edges of one segment, {others} of several");
    }

    /// Rates from all steps of an image that is no noise.
    fn rates_by_all_steps(image: &EdgeImage<'_>, lattice: &TileLattice, breaks: &[f64], own: f64) -> Vec<f64> {
        let lines = [&lattice.us[..], &lattice.vs[..]];
        let cell = |axis: usize, place: [f32; 2]| {
            let ends = [lines[axis][0], lines[axis][lines[axis].len() - 1]];
            cell_coordinate(lines[axis], ends[0] + f64::from(place[axis]) * (ends[1] - ends[0]))
        };
        let most = |places: &[[f32; 2]]| {
            let steps = places.windows(2).flat_map(|w| [0, 1].map(|axis| (cell(axis, w[1]) - cell(axis, w[0])).abs()));
            image.steps as f64 * steps.fold(0.0, f64::max)
        };
        let count = image.rates.len();
        let cells = (0..count).map(|k| most(&image.places[k * image.steps..=(k + 1) * image.steps]));
        let mut rates = vec![own; breaks.len() - 1];
        for (k, cells) in cells.enumerate() {
            let strip = image.strip + k;
            let length = breaks[strip + 1].min(image.ends[1]) - breaks[strip].max(image.ends[0]);
            rates[strip] = (cells / length).max(own);
        }
        rates
    }

    #[test]
    fn cells_limit_each_strip_by_its_longest_step() {
        let (mut draw, mut raised, mut kept) = (SplitMix(7), 0, 0);
        for model in shapes::NAMES.iter().filter_map(|name| shapes::by_name(name)).chain([sheet()]) {
            let prepared = prepare(model, &PrepareOptions::DEFAULT).unwrap();
            let edges = prepared.parts.iter().flat_map(|part| part.edges.iter().map(move |edge| (part, edge)));
            for (part, edge) in edges {
                let breaks = edge.images.strips(&edge.bounds);
                for (k, place) in edge.uses.iter().enumerate() {
                    let tile = &part.tiles[place.tile.index()];
                    let mut lines = |from: f64, to: f64| {
                        let mut lines: SmallVec<[f64; 2]> = (0..9).map(|_| draw.range(from, to)).collect();
                        lines.extend([from, to]);
                        lines.sort_by(f64::total_cmp);
                        lines
                    };
                    let (us, vs) = (lines(tile.min.x, tile.max.x), lines(tile.min.y, tile.max.y));
                    let lattice = TileLattice { us, vs, chord: 1.0, loosest: 1.0 };
                    let image = edge.images.image(k);
                    let length = edge.breaks[edge.breaks.len() - 1].t - edge.breaks[0].t;
                    for own in [0.0, 1.0, 8.0, 64.0, 512.0].map(|segments| segments / length) {
                        let mut rates = vec![own; breaks.len() - 1];
                        limit_to_cells(&image, (&lattice, gaps(&lattice)), breaks, &mut rates, &mut Vec::new());
                        assert_eq!(rates, rates_by_all_steps(&image, &lattice, breaks, own));
                        raised += rates.iter().filter(|rate| **rate > own).count();
                        kept += rates.iter().filter(|rate| **rate == own).count();
                    }
                }
            }
        }
        assert!(raised > 100 && kept > 100, "{raised} strips that cells limit, {kept} others");
    }

    /// The narrowest gap along an axis.
    fn gaps(lattice: &TileLattice) -> impl FnMut(usize) -> f64 {
        |axis| narrowest([&lattice.us, &lattice.vs][axis])
    }

    #[test]
    fn images_that_run_back_and_forth_get_64_traversals() {
        let lines = |count: u32| (0..=count).map(|k| f64::from(k * (k + 9)) / f64::from(count * (count + 9))).collect();
        let lattice = TileLattice { us: lines(8), vs: lines(1), chord: 1.0, loosest: 1.0 };
        // Four traversals a strip. The last strips have half of a traversal in each of their steps.
        let segments = |strips: usize, halves: usize| {
            let turn = |k: usize| if k < 4 * strips { (k % 2) as f32 } else { (k % 2) as f32 / 2.0 };
            let places: Vec<_> = (0..=4 * (strips + halves)).map(|k| [turn(k), 0.0]).collect();
            let steps = std::iter::repeat_n([4.0, 0.0], strips).chain(std::iter::repeat_n([2.0, 0.0], halves));
            let (rates, ends) = (steps.collect::<Vec<_>>(), [0.0, (strips + halves) as f64]);
            let ways = [(4 * strips + 2 * halves) as f32, 0.0];
            let image = EdgeImage { ends, strip: 0, places: &places, steps: 4, rates: &rates, ways };
            let breaks: Vec<f64> = (0..=strips + halves).map(|k| k as f64).collect();
            let mut rates = vec![0.5; strips + halves];
            limit_to_cells(&image, (&lattice, gaps(&lattice)), &breaks, &mut rates, &mut Vec::new());
            rates
        };
        // As many traversals as may be, each of eight cells; and twice as many.
        assert_eq!(segments(8, 0), [32.0; 8]);
        let noise = segments(100, 100);
        assert!((noise.iter().sum::<f64>() - 64.0 * 9.0).abs() < 1e-9, "{noise:?}");
        let least = cell_coordinate(&lattice.us, 0.5) / 8.0;
        assert!((noise[150] - least * noise[50]).abs() < 1e-9, "{noise:?}");
    }
}
