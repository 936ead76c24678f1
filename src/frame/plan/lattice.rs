//! Derivative bounds and a tolerance -> the lattice lines of a tile.
//!
//! Deviation: the theorem of Filip, Magedson and Markot (CAGD 3(4), 1986) in its form for any triangle whose box is
//! h_u × h_v: ⅛ (M₁h_u² + 2M₂h_u h_v + M₃h_v²). The mixed term is split between the directions by
//! 2M₂h_u h_v ≤ M₂(r h_u² + h_v²/r), with r = h_v/h_u of the cheapest uniform lattice. Each direction then has
//! its own density of lines, which follows the bounds along it.

use super::density::{Criteria, Density, FollowLines};
use super::output::{MAX_LINES, TileLattice};
use crate::frame::tolerance::box_tolerance::{BoxTolerances, dilate, is_steep, most_touched};
use crate::frame::tolerance::object_tolerance::Tolerance;
use crate::math::Elementary as _;
use crate::model::SurfaceKind;
use crate::prepare::internals::{Bend, BoundingBox, BoxBounds, PreparedFace, Tile};
use std::borrow::Cow;
use std::f64::consts::FRAC_PI_2;

/// Maximum number of lines of one tile in one direction, over all stretches between creases.
const LINES_OF_TILE: f64 = 32768.0;
/// Maximum number of cells of a tile whose lines reach a limit. Where no number of lines is enough, more cells follow
/// noise: one coordinate of 1e9 mm in a part of 100 mm asks for as many as all limits allow.
const CELLS_BEYOND_LINES: u64 = 1 << 20;
/// Maximum number of times that a lattice over its limits is made coarser; each time brings it down to about the limit.
const COARSER: usize = 8;

/// Least cell length that the angle tolerance can require in tiles whose loops meet themselves, as a multiple of the
/// gap between edges and surface. Such tiles are noise: a fillet whose points moved by a fraction of its radius turns
/// twenty times where it turned by a right angle, and lines at each turn do not follow its shape. The chord tolerance
/// still holds; noisy fillets keep a few cells across.
const GAPS_PER_CELL: f64 = 16.0;

/// Requirements on the cells of a strip of a tile, from the bounds of the boxes under it.
#[derive(Clone, Copy, Default)]
struct Needs {
    bounds: BoxBounds,
    /// u-lines and v-lines per unit of parameter that keep the parametrisation even within a cell.
    even: [f64; 2],
    /// u-lines and v-lines per unit of parameter beyond which cells follow noise.
    densest: [f64; 2],
}

/// Componentwise maximum over the boxes under a strip.
fn worst(boxes: impl Iterator<Item = Needs>) -> Needs {
    boxes.fold(Needs::default(), |m, n| {
        let (a, b) = (&m.bounds, &n.bounds);
        let bounds = BoxBounds {
            uu: a.uu.max(b.uu),
            uv: a.uv.max(b.uv),
            vv: a.vv.max(b.vv),
            u: a.u.max(b.u),
            v: a.v.max(b.v),
            turn_u: a.turn_u.max(b.turn_u),
            turn_v: a.turn_v.max(b.turn_v),
        };
        let most = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].max(b[1])];
        Needs { bounds, even: most(m.even, n.even), densest: most(m.densest, n.densest) }
    })
}

/// Maximum change of a first derivative along the surface across a cell, as a multiple of its largest length there.
/// Where the derivative reverses, triangles that are positive in (u,v) fold over. At 1 a side can shrink to a point;
/// the rest allows for the slack of the bounds.
const UNEVEN: f64 = 1.25;

impl Needs {
    /// `share` is the tile's tolerance as a fraction of the box's own.
    fn of(bounds: BoxBounds, share: f64, densest: impl Fn(f64) -> f64) -> Self {
        let ratio = |change: f64, of: f64| if of > 0.0 { change / (UNEVEN * of) } else { 0.0 };
        let along = |own: &Bend, speed: f64, other: f64| ratio(own.slide, speed).max(ratio(bounds.uv.slide, other));
        let even = [along(&bounds.uu, bounds.u, bounds.v), along(&bounds.vv, bounds.v, bounds.u)];
        let densest = [bounds.u, bounds.v].map(densest);
        // A larger tolerance for a box counts as smaller derivatives.
        let BoxBounds { uu, uv, vv, u, v, .. } = bounds;
        let [uu, uv, vv] = [uu, uv, vv].map(|bend| bend.scaled(share));
        Self { bounds: BoxBounds { uu, uv, vv, u: u * share, v: v * share, ..bounds }, even, densest }
    }

    /// Second derivatives that count for the chord, where normals turn within a cell by at most the arc sine of
    /// `share`.
    fn second(&self, share: f64) -> Second {
        let BoxBounds { uu, uv, vv, .. } = &self.bounds;
        Second { uu: uu.along(share), uv: uv.along(share), vv: vv.along(share) }
    }
}

/// Bounds on the second derivatives that lift the surface off its triangles.
struct Second {
    uu: f64,
    uv: f64,
    vv: f64,
}

/// The boxes of a face's table under a tile, strip by strip in u: the order of [`BoxTolerances::shares`].
pub(crate) fn places<'a>(
    face: &'a PreparedFace,
    tile: &Tile,
) -> impl ExactSizeIterator<Item = &'a BoundingBox> + use<'a> {
    let table = &face.bounds;
    let (su, sv) = (strips(&table.breaks_u, tile.min.x, tile.max.x), strips(&table.breaks_v, tile.min.y, tile.max.y));
    let (columns, first, rows) = (table.breaks_v.len() - 1, su.start, sv.len());
    (0..su.len() * rows).map(move |k| &table.places[(first + k / rows) * columns + sv.start + k % rows])
}

/// Strips of the bounds table under `[lo, hi]`.
pub(crate) fn strips(breaks: &[f64], lo: f64, hi: f64) -> std::ops::Range<usize> {
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

/// Lattice lines of `tile` at `factor` times the density that a tolerance needs, and whether they are that dense:
/// [`MAX_LINES`] and `most_cells` may prevent it. Lines of `before` are reused where they fit. A pure function of its
/// arguments.
pub(crate) fn lattice(
    face: &PreparedFace,
    tile: &Tile,
    need: &BoxTolerances,
    factor: f64,
    most_cells: u64,
    before: Option<&dyn FollowLines>,
) -> (TileLattice, DensityMet) {
    if is_single(face, need.tolerance.max_edge) {
        let single = TileLattice {
            us: [tile.min.x, tile.max.x].into(),
            vs: [tile.min.y, tile.max.y].into(),
            chord: need.tolerance.chord,
        };
        return (single, DensityMet { lines: true, cells: true });
    }
    let table = &face.bounds;
    let (su, sv) = (strips(&table.breaks_u, tile.min.x, tile.max.x), strips(&table.breaks_v, tile.min.y, tile.max.y));
    let boxes: Vec<(usize, usize)> = su.clone().flat_map(|i| sv.clone().map(move |j| (i, j))).collect();
    let mut shares = Vec::new();
    let noise = if tile.entangled { GAPS_PER_CELL * face.gap } else { 0.0 };
    let densest = |speed: f64| if noise > 0.0 { speed / noise } else { f64::INFINITY };
    // A cell in several boxes must meet the tolerances of all of them. Where these differ strongly, as they do close to
    // the eye, lines run along the borders of boxes, so that no cell is in two.
    let steep = is_steep(&need.shares, sv.len());
    let mut reach = usize::from(!steep);
    loop {
        dilate(&need.shares, sv.len(), reach, &mut shares);
        let needs: Vec<Needs> =
            boxes.iter().zip(&shares).map(|(&(i, j), &share)| Needs::of(table.cell(i, j), share, densest)).collect();
        let under = Under { face, tile, strips: [su.clone(), sv.clone()], needs: &needs };
        let (lattice, kept) = spread(&under, steep, &need.tolerance, factor, most_cells, before);
        let touched = most_touched(&table.breaks_u, &lattice.us).max(most_touched(&table.breaks_v, &lattice.vs));
        if touched <= reach + 1 || shares.iter().all(|&share| share == 1.0) {
            return (lattice, kept);
        }
        reach = touched - 1;
    }
}

/// The boxes under a tile.
struct Under<'a> {
    face: &'a PreparedFace,
    tile: &'a Tile,
    /// Their strips in u and in v.
    strips: [std::ops::Range<usize>; 2],
    /// Their requirements, strip by strip in u.
    needs: &'a [Needs],
}

/// Densities of lines for a tolerance, strip by strip of a tile, in u and in v.
struct Densities {
    wanted: [Vec<f64>; 2],
    /// Least densities at which triangles do not fold over, at any tolerance; for lines that follow others.
    least: Option<[Vec<f64>; 2]>,
    /// Whether `wanted` is less than the angle tolerance requires, because that would follow noise.
    noisy: bool,
}

impl Densities {
    fn of(under: &Under<'_>, tolerance: &Tolerance, factor: f64, follows: bool) -> Self {
        let Under { face, tile, strips: [su, sv], needs } = under;
        let table = &face.bounds;
        let cell = |i: usize, j: usize| needs[(i - su.start) * sv.len() + (j - sv.start)];
        let columns: Vec<Needs> = su.clone().map(|i| worst(sv.clone().map(|j| cell(i, j)))).collect();
        let rows: Vec<Needs> = sv.clone().map(|j| worst(su.clone().map(|i| cell(i, j)))).collect();
        let width = tile.max - tile.min;
        let sides = [(&table.breaks_u, su.clone(), &columns), (&table.breaks_v, sv.clone(), &rows)];
        let angle = tolerance.angle.min(FRAC_PI_2);
        // Turn of the normal per unit of parameter.
        let turning = [0, 1].map(|axis: usize| {
            let (breaks, strips, needs) = &sides[axis];
            let turn = |n: &Needs| if axis == 0 { n.bounds.turn_u } else { n.bounds.turn_v };
            strips.clone().zip(needs.iter()).map(|(k, n)| turn(n) / (breaks[k + 1] - breaks[k])).collect::<Vec<f64>>()
        });
        let rates = |share: f64| {
            let chord = chord_rates(&columns, &rows, share, [width.x, width.y], 8.0 * tolerance.chord);
            let finish = |axis: usize, chord: Vec<f64>| {
                let speed = |n: &Needs| if axis == 0 { n.bounds.u } else { n.bounds.v };
                let long = |n: &Needs| tolerance.max_edge.map_or(0.0, |m| std::f64::consts::SQRT_2 * speed(n) / m);
                let all = chord.into_iter().zip(sides[axis].2).zip(&turning[axis]);
                all.map(|((rate, n), turn)| {
                    let smooth = (turn / angle).max(n.even[axis]).min(n.densest[axis]);
                    rate.max(smooth).max(long(n))
                })
                .collect::<Vec<f64>>()
            };
            [finish(0, chord.0), finish(1, chord.1)]
        };
        // Normals turn the most on the largest cells, those that lifts alone would allow. A tangential derivative at
        // one end of a cell lifts the surface at the other end by at most that turn, and by half of it on average
        // (decision 019).
        let largest = rates(0.0);
        let turn = |axis: usize| {
            let (breaks, strips, _) = &sides[axis];
            most_turn((breaks, strips.clone()), &largest[axis], &turning[axis])
        };
        let share = (0.5 * turn(0).hypotenuse(turn(1))).min(1.0);
        let mut wanted = if share > 0.0 { rates(share) } else { largest };
        wanted.iter_mut().flatten().for_each(|rate| *rate *= factor);
        let least = |axis: usize| -> Vec<f64> {
            let rates = sides[axis].2.iter().zip(&turning[axis]);
            let rates = rates.map(|(n, turn)| (turn / FRAC_PI_2).max(n.even[axis]).min(n.densest[axis]));
            rates.map(|rate| rate * factor).collect()
        };
        let noisy = |axis: usize| {
            let mut asked = sides[axis].2.iter().zip(&turning[axis]).zip(&wanted[axis]);
            asked.any(|((n, turn), rate)| {
                let smooth = factor * (turn / angle).max(n.even[axis]);
                smooth > *rate && smooth * width[axis] > 1.0
            })
        };
        let noisy = noisy(0) || noisy(1);
        Self { wanted, least: follows.then(|| [0, 1].map(least)), noisy }
    }
}

/// Largest turn of the normal across a cell of these densities, from its turn per unit of parameter in each strip.
fn most_turn((breaks, strips): (&[f64], std::ops::Range<usize>), rates: &[f64], turning: &[f64]) -> f64 {
    let mut all = 0.0;
    let mut most = 0.0_f64;
    for (k, (rate, per_unit)) in strips.zip(rates.iter().zip(turning)) {
        let whole = per_unit * (breaks[k + 1] - breaks[k]);
        all += whole;
        // A box that turns by more than a right angle may do so at a single point, where the surface folds.
        most = most.max(if whole > FRAC_PI_2 {
            whole
        } else if *per_unit > 0.0 {
            per_unit / rate
        } else {
            0.0
        });
    }
    most.min(all)
}

/// Lattice lines for a tolerance; with `split`, along the borders of boxes too.
fn spread(
    under: &Under<'_>,
    split: bool,
    tolerance: &Tolerance,
    factor: f64,
    most_cells: u64,
    mut before: Option<&dyn FollowLines>,
) -> (TileLattice, DensityMet) {
    let Under { face, tile, strips: [su, sv], .. } = under;
    let (breaks_u, breaks_v) = (&face.bounds.breaks_u[su.start..=su.end], &face.bounds.breaks_v[sv.start..=sv.end]);
    let Densities { wanted: [mut ru, mut rv], least, noisy } =
        Densities::of(under, tolerance, factor, before.is_some());
    let mut creases = [Cow::Borrowed(&face.creases[0]), Cow::Borrowed(&face.creases[1])];
    if split {
        for (creases, breaks) in creases.iter_mut().zip([breaks_u, breaks_v]) {
            let creases = creases.to_mut();
            creases.extend(breaks);
            creases.sort_by(f64::total_cmp);
            creases.dedup();
        }
    }
    let mut kept = DensityMet { lines: !noisy, cells: true };
    let (mut round, mut beyond) = (0, false);
    loop {
        let (u, v) = (Density { breaks: breaks_u, rates: &ru }, Density { breaks: breaks_v, rates: &rv });
        let follow = |axis: usize| {
            let (before, least) = (before?, least.as_ref()?);
            Some((before, axis, Density { breaks: [breaks_u, breaks_v][axis], rates: &least[axis] }))
        };
        let (us, kept_u) = lines(&u, tile.min.x, tile.max.x, &creases[0], follow(0));
        let (vs, kept_v) = lines(&v, tile.min.y, tile.max.y, &creases[1], follow(1));
        let (nu, nv) = ((us.len() - 1) as f64, (vs.len() - 1) as f64);
        beyond |= !(kept_u && kept_v);
        let most = if beyond { most_cells.min(CELLS_BEYOND_LINES) } else { most_cells };
        // By how much u and v are too dense. A direction with one cell cannot become coarser.
        let over = nu * nv / most as f64;
        let share = |n: f64, other: f64| (if other > 1.0 { over.sqrt() } else { over }).max(n / LINES_OF_TILE).max(1.0);
        let (too_u, too_v) = (share(nu, nv), share(nv, nu));
        let fits = too_u <= 1.0 && too_v <= 1.0;
        if !fits && before.take().is_some() {
            // Before lowering the density, try without the earlier lines.
            continue;
        }
        kept.lines &= kept_u && kept_v;
        if fits || round == COARSER {
            return (TileLattice { us: us.into(), vs: vs.into(), chord: tolerance.chord }, kept);
        }
        kept.cells &= nu * nv <= most_cells as f64;
        kept.lines &= nu.max(nv) <= LINES_OF_TILE;
        round += 1;
        let (by_u, by_v) =
            (coarser(&u, (tile.min.x, tile.max.x), nu, too_u), coarser(&v, (tile.min.y, tile.max.y), nv, too_v));
        ru.iter_mut().for_each(|rate| *rate *= by_u);
        rv.iter_mut().for_each(|rate| *rate *= by_v);
    }
}

/// Factor that makes a density `too_many` times coarser, where it gave `n` gaps. It goes 1 % further, so that rounding
/// up does not undo it, and starts from the actual gaps, since limits may allow fewer than the density asks for.
fn coarser(density: &Density<'_>, (lo, hi): (f64, f64), n: f64, too_many: f64) -> f64 {
    let mass = density.mass(lo, hi);
    let by = if mass > n { n / mass } else { 1.0 };
    by / (1.01 * too_many)
}

fn lines(
    density: &Density<'_>,
    lo: f64,
    hi: f64,
    creases: &[f64],
    follow: Option<(&dyn FollowLines, usize, Density<'_>)>,
) -> (Vec<f64>, bool) {
    let mut out = vec![lo];
    let mut from = lo;
    let mut kept = true;
    for &x in creases.iter().filter(|&&x| x > lo && x < hi).chain([&hi]) {
        kept &= match follow {
            Some((before, axis, least)) => {
                before.follow(axis, Criteria { density: *density, least }, (from, x), MAX_LINES, &mut out)
            }
            None => density.spread(from, x, MAX_LINES, &mut out),
        };
        from = x;
    }
    (out, kept)
}

/// Densities of u- and v-lines per strip that meet the chord tolerance; `budget` is eight times that tolerance.
fn chord_rates(columns: &[Needs], rows: &[Needs], share: f64, width: [f64; 2], budget: f64) -> (Vec<f64>, Vec<f64>) {
    let all = worst(columns.iter().copied()).second(share);
    let second = |needs: &[Needs]| needs.iter().map(|n| n.second(share)).collect::<Vec<_>>();
    let (columns, rows) = (second(columns), second(rows));
    let none = |strips: &[Second]| vec![0.0; strips.len()];
    if budget == f64::INFINITY || all.uu == 0.0 && all.uv == 0.0 && all.vv == 0.0 {
        return (none(&columns), none(&rows));
    }
    // Straight in one direction: one cell that way, and the other takes the whole budget.
    let ruled = |bounds: &[Second], own: fn(&Second) -> f64, across: f64| -> Vec<f64> {
        bounds
            .iter()
            .map(|b| {
                let (m, c) = (own(b), b.uv * across);
                if m > 0.0 { m / ((c * c + budget * m).sqrt() - c) } else { 2.0 * c / budget }
            })
            .collect()
    };
    if all.uu == 0.0 && all.vv > 0.0 {
        return (none(&columns), ruled(&rows, |b| b.vv, width[0]));
    }
    if all.vv == 0.0 && all.uu > 0.0 {
        return (ruled(&columns, |b| b.uu, width[1]), none(&rows));
    }
    let r = if all.uu > 0.0 { (all.uu / all.vv).sqrt() } else { width[1] / width[0] };
    let need_u = |b: &Second| b.uu + r * b.uv;
    let need_v = |b: &Second| b.vv + b.uv / r;
    let part = |need: f64, width: f64| need * width * width / budget;
    // A direction that one cell satisfies leaves the rest of the budget to the other.
    let (one_u, one_v) = (part(need_u(&all), width[0]), part(need_v(&all), width[1]));
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
