//! Bézier patches and segments -> where they are cut into the sub-boxes and strips that bounds are made for.
//!
//! Bounds of a rational net are as slack as its weights differ. The weights of a part of it lie within those of the
//! whole, so cutting helps: a bicubic patch with weights from 0.03 to 30 has forty times fewer triangles with strips
//! that [`ALIKE`] allows than with two strips. Strips in which the normal turns far are halved, too, once their bounds
//! tell.

use super::decompose::{BezierPatches, BezierSpline3};
use crate::math::bernstein;
use crate::math::lanes::{larger, smaller, widest};
use glam::DVec4;
use smallvec::SmallVec;

/// A strip is halved while weights along it differ by more than this factor. Halves of arcs of 120 degrees are below.
const ALIKE: f64 = 1.5;
/// Limit of strips for that, times pieces, times control points of a patch or segment.
const WORK: usize = 512;
/// Limit of strips for that in one piece.
const STRIPS: usize = 64;
/// Limit of strips in one piece that turns.
const BENT: usize = 16;
/// Surfaces of more pieces are cut finely as they are: one strip for each piece, unless weights ask for more.
const FEW_PIECES: usize = 64;

/// Part of a piece along one parameter.
#[derive(Clone, Copy)]
pub(super) struct Cut {
    pub(super) piece: usize,
    /// The local parameters of its ends, from 0 to 1.
    pub(super) ends: (f64, f64),
}

/// Weights of lines along one parameter: the first of all lines, then their second ones, and so on.
struct Weights {
    lines: usize,
    values: SmallVec<[f64; 16]>,
}

/// The cuts of a surface along u or v (`axis` 0 or 1), in order.
pub(super) fn of_surface(patches: &BezierPatches, axis: usize) -> Vec<Cut> {
    let counts = <[usize; 2]>::from(patches.counts());
    let degrees = [patches.degree_u, patches.degree_v];
    let points = points(patches);
    let weights = |piece: usize| {
        let columns = degrees[1] + 1;
        let patch = |k: usize| if axis == 0 { patches.patch(piece, k) } else { patches.patch(k, piece) };
        let at = |k: usize, along: usize, across: usize| {
            patch(k)[if axis == 0 { along * columns + across } else { across * columns + along }].w
        };
        let lines = || (0..counts[1 - axis]).flat_map(|k| (0..=degrees[1 - axis]).map(move |across| (k, across)));
        let all = (0..=degrees[axis]).flat_map(|along| lines().map(move |(k, across)| (k, along, across)));
        Weights { lines: lines().count(), values: all.map(|(k, along, across)| at(k, along, across)).collect() }
    };
    let least = parts(degrees[axis], counts[axis], points);
    let mut all = Vec::with_capacity(counts[axis] * least);
    for piece in 0..counts[axis] {
        let of_piece = || patches.rational.then(|| weights(piece));
        cut(piece, (least, most(counts[axis] * points)), of_piece, |cut| all.push(cut));
    }
    all
}

/// The cuts of a segment of a curve, in order.
pub(super) fn of_segment(spline: &BezierSpline3, k: usize) -> SmallVec<[Cut; 4]> {
    let weights = || Some(Weights { lines: 1, values: spline.segment(k).iter().map(|c| c.w).collect() });
    let mut all = SmallVec::new();
    let counts = (parts(spline.degree, spline.segments(), 1), most(spline.segments() * (spline.degree + 1)));
    cut(k, counts, weights, |cut| all.push(cut));
    all
}

/// The cuts of [`of_surface`] with those halved that ask for it, as far as limits allow.
pub(super) fn halved(patches: &BezierPatches, axis: usize, cuts: &[Cut], asks: &[bool]) -> Vec<Cut> {
    let pieces = <[usize; 2]>::from(patches.counts())[axis];
    let points = points(patches);
    let is_small = pieces <= FEW_PIECES;
    // At most 256 strips in all, so that noise costs little.
    let most = most(pieces * points.max(2)).min(BENT);
    let least = if is_small { 2.0 / most as f64 } else { f64::INFINITY };
    let mut all = Vec::with_capacity(2 * cuts.len());
    for (&cut, &asks) in cuts.iter().zip(asks) {
        let (a, b) = cut.ends;
        if b - a >= least && asks {
            let middle = 0.5 * (a + b);
            all.extend([(a, middle), (middle, b)].map(|ends| Cut { ends, ..cut }));
        } else {
            all.push(cut);
        }
    }
    all
}

/// Control points of a patch by which the work per sub-box grows.
fn points(patches: &BezierPatches) -> usize {
    if patches.rational { (patches.degree_u + 1) * (patches.degree_v + 1) } else { 1 }
}

/// Borders of cuts in the parameters of `breaks`, between which the pieces lie.
pub(super) fn borders(cuts: &[Cut], breaks: &[f64]) -> Vec<f64> {
    let first = |cut: &Cut| {
        let (a, b) = (breaks[cut.piece], breaks[cut.piece + 1]);
        if cut.ends.0 == 0.0 { a } else { a + (b - a) * cut.ends.0 }
    };
    cuts.iter().map(first).chain(breaks.last().copied()).collect()
}

/// Most strips of one piece, given the number of pieces times control points.
fn most(points: usize) -> usize {
    (WORK / points).min(STRIPS)
}

/// Cuts a piece into `least` equal parts, and these into up to `most` in all where the weights ask for it.
fn cut(
    piece: usize,
    (least, most): (usize, usize),
    weights: impl FnOnce() -> Option<Weights>,
    mut add: impl FnMut(Cut),
) {
    let may_be_halved = 2 * least <= most;
    let uneven = may_be_halved.then(weights).flatten().filter(Weights::differ);
    for k in 0..least {
        let part = Cut { piece, ends: (k as f64 / least as f64, (k + 1) as f64 / least as f64) };
        match &uneven {
            Some(weights) => weights.restricted(part.ends).halve(part, most / least, &mut add),
            None => add(part),
        }
    }
}

impl Weights {
    /// Whether any line has weights that are not [`ALIKE`].
    fn differ(&self) -> bool {
        let line = |k: usize| self.values[k..].iter().step_by(self.lines).copied();
        (0..self.lines).any(|k| line(k).fold(0.0, larger) > ALIKE * line(k).fold(f64::INFINITY, smaller))
    }

    fn restricted(&self, (x0, x1): (f64, f64)) -> Self {
        let mut values = self.values.clone();
        bernstein::restrict_rows(&mut values, self.lines, x0, x1);
        Self { values, ..*self }
    }

    /// Gives a cut, of which these are the weights, in at most `most` parts.
    fn halve(&self, cut: Cut, most: usize, add: &mut impl FnMut(Cut)) {
        if most < 2 || !self.differ() {
            return add(cut);
        }
        let (a, b) = cut.ends;
        let middle = 0.5 * (a + b);
        self.restricted((0.0, 0.5)).halve(Cut { ends: (a, middle), ..cut }, most / 2, add);
        self.restricted((0.5, 1.0)).halve(Cut { ends: (middle, b), ..cut }, most / 2, add);
    }
}

/// Sub-boxes per piece and direction. More if there are few pieces, because one may then fill the screen. Fewer for
/// rational nets of many control points: `cost` is their number.
fn parts(degree: usize, pieces: usize, cost: usize) -> usize {
    match (degree, pieces, cost) {
        (1, ..) => 1,
        (_, 0..=16, 0..=6) => 4,
        (_, 0..=FEW_PIECES, _) => 2,
        _ => 1,
    }
}

/// The nets of all sub-boxes of a surface.
pub(super) struct SubNets<'a> {
    patches: &'a BezierPatches,
    /// In u and v.
    cuts: [&'a [Cut]; 2],
    /// A row of patches, and its nets cut along v.
    row: Option<usize>,
    cut: Vec<DVec4>,
    net: Vec<DVec4>,
}

impl<'a> SubNets<'a> {
    pub(super) fn new(patches: &'a BezierPatches, cuts: [&'a [Cut]; 2]) -> Self {
        Self { patches, cuts, row: None, cut: Vec::new(), net: Vec::new() }
    }

    /// The net of sub-box (i, j), u-major. Rows in turn are cheap: sub-boxes of a row of patches share the cuts along
    /// v.
    pub(super) fn at(&mut self, i: usize, j: usize) -> &[DVec4] {
        let Self { patches, cuts: [cuts_u, cuts_v], row, cut, net } = self;
        let (nu, nv) = (patches.degree_u + 1, patches.degree_v + 1);
        let Cut { piece, ends: (x0, x1) } = cuts_u[i];
        widest(
            #[inline(always)]
            || {
                if row.replace(piece) != Some(piece) {
                    cut.clear();
                    for &Cut { piece: column, ends: (y0, y1) } in *cuts_v {
                        let first = cut.len();
                        cut.extend_from_slice(patches.patch(piece, column));
                        cut[first..].chunks_exact_mut(nv).for_each(|line| bernstein::restrict_rows(line, 1, y0, y1));
                    }
                }
                net.clear();
                net.extend_from_slice(&cut[j * nu * nv..(j + 1) * nu * nv]);
                bernstein::restrict_rows(net, nv, x0, x1);
            },
        );
        net
    }
}
