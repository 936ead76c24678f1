//! Lattice lines -> surface points and unit normals, four at a time.
//!
//! Per outer line the patch is contracted to a curve and its cross derivative, then that curve is evaluated at blocks
//! of inner lines (tensor-product evaluation as in Kumar & Manocha 1995, §3.3, with the basis of a line computed once
//! per lattice).

use super::evaluate::{Found, LANES, LinePlace, Points, Roles, limit_normal, points, set_lane};
use crate::frame::trim::input::NONE;
use crate::math::bernstein;
use crate::math::lanes::{Lanes, Work, in_fours};
use crate::prepare::internals::decompose::{BezierPatches, Piece};
use glam::DVec3;

/// The place of lattice points that [`evaluate_lattice`] leaves out.
pub const UNWANTED: u32 = NONE;

/// Buffers that the evaluators reuse. They do not affect results.
#[derive(Default, Debug)]
pub struct EvaluateScratch {
    outer: Lines,
    inner: Lines,
    /// How many inner blocks each patch has, in order.
    stretches: Vec<usize>,
    /// The contracted curve and its cross derivative.
    curve: Vec<[f64; 4]>,
}

/// Lines of one direction with their bases.
#[derive(Default, Debug)]
struct Lines {
    blocks: Vec<Block>,
    /// Per block the basis of its lanes, then its derivative, `degree + 1` rows each.
    bases: Vec<[f64; LANES]>,
}

/// Up to [`LANES`] neighbouring lines of one patch.
#[derive(Clone, Copy, Debug)]
struct Block {
    patch: usize,
    first: usize,
    count: usize,
    /// In the patch, 0 to 1.
    places: [f64; LANES],
}

impl Lines {
    /// Groups lines into blocks and sets their bases. Blocks end where the patch changes; short ones repeat their last
    /// line.
    #[inline(always)]
    fn set(&mut self, degree: usize, breaks: &[f64], lines: &[f64]) {
        self.blocks.clear();
        self.bases.clear();
        let mut piece = Piece::at(breaks, lines.first().copied().unwrap_or_default());
        let mut first = 0;
        while let Some(&t) = lines.get(first) {
            if !piece.contains(t) {
                piece = Piece::at(breaks, t);
            }
            let mut ts = [t; LANES];
            let mut count = 1;
            while count < LANES && lines.get(first + count).is_some_and(|&t| piece.contains(t)) {
                ts[count..].fill(lines[first + count]);
                count += 1;
            }
            let places = piece.locals(ts);
            self.blocks.push(Block { patch: piece.index, first, count, places });
            first += count;
            match degree {
                1 => self.push(bernstein::constant_basis_and_slopes::<2, LANES>(places)),
                2 => self.push(bernstein::constant_basis_and_slopes::<3, LANES>(places)),
                3 => self.push(bernstein::constant_basis_and_slopes::<4, LANES>(places)),
                _ => {
                    let start = self.bases.len();
                    self.bases.resize(start + 2 * (degree + 1), [0.0; LANES]);
                    bernstein::basis_and_slopes(degree, places, &mut self.bases[start..]);
                }
            }
        }
    }

    #[inline(always)]
    fn push<const N: usize>(&mut self, rows: [[[f64; LANES]; N]; 2]) {
        self.bases.extend_from_slice(rows.as_flattened());
    }
}

/// Calls `put` with the points and unit normals (along `S_u × S_v`) at the crossings of the lines `us` and `vs`
/// (non-decreasing), in any order. The first argument is the place of the point at `us[i]` and `vs[j]`, which is
/// `places[j * us.len() + i]`, and [`UNWANTED`] for points to leave out.
///
/// At poles and collapsed borders the normal is its limit from inside the patch. Returns the number of normals that do
/// not exist even there; they are +z. 5-15 ns per point up to degree (3, 3); allocates only to grow the buffers.
pub fn evaluate_lattice(
    patches: &BezierPatches,
    us: &[f64],
    vs: &[f64],
    places: &[u32],
    scratch: &mut EvaluateScratch,
    put: impl FnMut(usize, DVec3, DVec3),
) -> usize {
    let roles = Roles::of(patches);
    let (outer, outer_breaks, inner, inner_breaks) = if roles.inner_is_v {
        (us, &patches.breaks_u, vs, &patches.breaks_v)
    } else {
        (vs, &patches.breaks_v, us, &patches.breaks_u)
    };
    in_fours(Lattice {
        patches,
        roles,
        outer,
        outer_breaks,
        inner,
        inner_breaks,
        width: us.len(),
        places,
        scratch,
        put,
    })
}

/// What [`evaluate_lattice`] does.
struct Lattice<'a, P> {
    patches: &'a BezierPatches,
    roles: Roles,
    outer: &'a [f64],
    outer_breaks: &'a [f64],
    inner: &'a [f64],
    inner_breaks: &'a [f64],
    width: usize,
    places: &'a [u32],
    scratch: &'a mut EvaluateScratch,
    put: P,
}

impl<P: FnMut(usize, DVec3, DVec3)> Work for Lattice<'_, P> {
    type Output = usize;

    #[inline(always)]
    fn run<F: Lanes<LANES>>(self, zero: F) -> usize {
        let Self { patches, roles, outer, outer_breaks, inner, inner_breaks, width, places, scratch, mut put } = self;
        let (row, step) = if roles.inner_is_v { (1, width) } else { (width, 1) };
        let (n, m) = (roles.outer_points, roles.inner_points);
        let EvaluateScratch { outer: outer_lines, inner: inner_lines, stretches, curve } = scratch;
        outer_lines.set(n - 1, outer_breaks, outer);
        inner_lines.set(m - 1, inner_breaks, inner);
        stretches.clear();
        stretches.extend(inner_lines.blocks.chunk_by(|a, b| a.patch == b.patch).map(<[Block]>::len));
        let mut lost = 0;
        for (block, bases) in outer_lines.blocks.iter().zip(outer_lines.bases.chunks_exact(2 * n)) {
            for lane in 0..block.count {
                let places = &places[(block.first + lane) * row..];
                let mut rest = (&inner_lines.blocks[..], &inner_lines.bases[..]);
                for &length in &*stretches {
                    let ((blocks, more), (lanes, more_lanes)) =
                        (rest.0.split_at(length), rest.1.split_at(2 * m * length));
                    rest = (more, more_lanes);
                    let stretch = Stretch { patches, roles, line: (block, lane), bases, blocks, lanes, places, step };
                    let to = (&mut *curve, &mut put, &mut lost);
                    // Degrees 1 to 3 get loops of constant length, with the same sums.
                    match (patches.rational, m) {
                        (false, 2) => stretch.evaluate::<F, false>(zero, 2, to),
                        (false, 3) => stretch.evaluate::<F, false>(zero, 3, to),
                        (false, 4) => stretch.evaluate::<F, false>(zero, 4, to),
                        (false, m) => stretch.evaluate::<F, false>(zero, m, to),
                        (true, 2) => stretch.evaluate::<F, true>(zero, 2, to),
                        (true, 3) => stretch.evaluate::<F, true>(zero, 3, to),
                        (true, 4) => stretch.evaluate::<F, true>(zero, 4, to),
                        (true, m) => stretch.evaluate::<F, true>(zero, m, to),
                    }
                }
            }
        }
        lost
    }
}

/// The part of an outer line in one patch.
#[derive(Clone, Copy)]
struct Stretch<'a> {
    patches: &'a BezierPatches,
    roles: Roles,
    /// The outer line, by block and lane.
    line: (&'a Block, usize),
    /// Of the line's block, as in [`Lines`].
    bases: &'a [[f64; LANES]],
    blocks: &'a [Block],
    /// Of each block, as in [`Lines`].
    lanes: &'a [[f64; LANES]],
    /// Places from the outer line's first point.
    places: &'a [u32],
    /// From one inner line to the next in them.
    step: usize,
}

impl Stretch<'_> {
    /// Evaluates it on a patch of `m` control points in the inner direction.
    #[inline(always)]
    fn evaluate<F: Lanes<LANES>, const RATIONAL: bool>(
        self,
        zero: F,
        m: usize,
        (room, put, lost): (&mut Vec<[f64; 4]>, &mut impl FnMut(usize, DVec3, DVec3), &mut usize),
    ) {
        let (mut room, mut curve): (_, &[[f64; 4]]) = (Some(room), &[]);
        for (block, lanes) in self.blocks.iter().zip(self.lanes.chunks_exact(2 * m)) {
            let wanted = self.wanted(block);
            if wanted[0] & wanted[1] & wanted[2] & wanted[3] == UNWANTED {
                continue;
            }
            if let Some(room) = room.take() {
                curve = self.contract(m, room);
            }
            let found = kernel::<F, RATIONAL>(zero, self.roles.sign, &curve[..2 * m], lanes, m);
            if found.regular == (1 << LANES) - 1 {
                put_wanted(wanted, &found.to_points(), put);
            } else {
                let mut points = found.to_points();
                points.normal = self.limit_normals(block, points.regular, points.normal, lost);
                put_wanted(wanted, &points, put);
            }
        }
    }

    /// Contracts the patch along the outer direction: the curve's `m` control points, then those of its outer
    /// derivative.
    #[inline(always)]
    fn contract<'r>(&self, m: usize, room: &'r mut Vec<[f64; 4]>) -> &'r [[f64; 4]] {
        room.resize(2 * m, [0.0; 4]);
        // Constant lengths again. The inner degree is the higher one.
        match self.roles.outer_points {
            2 => self.contract_into(2, m, room),
            3 if m >= 3 => self.contract_into(3, m, room),
            4 if m >= 4 => self.contract_into(4, m, room),
            n => self.contract_into(n, m, room),
        }
        room
    }

    #[inline(always)]
    fn contract_into(&self, n: usize, m: usize, curve: &mut [[f64; 4]]) {
        let (outer, inner) = (self.line.0.patch, self.blocks[0].patch);
        let roles = self.roles;
        let patch = if roles.inner_is_v { self.patches.patch(outer, inner) } else { self.patches.patch(inner, outer) };
        let (basis, rates) = self.bases[..2 * n].split_at(n);
        let (value, slope) = curve[..2 * m].split_at_mut(m);
        for b in 0..m {
            let (mut q, mut dq) = ([0.0; 4], [0.0; 4]);
            for a in 0..n {
                let (f, d) = (basis[a][self.line.1], rates[a][self.line.1]);
                let c: &[f64; 4] = patch[a * roles.stride_outer + b * roles.stride_inner].as_ref();
                for k in 0..4 {
                    q[k] += f * c[k];
                    dq[k] += d * c[k];
                }
            }
            (value[b], slope[b]) = (q, dq);
        }
    }

    /// The places of a block's points. One by one: numbers that were stored one by one are slow to load together.
    #[inline(always)]
    fn wanted(&self, block: &Block) -> [u32; LANES] {
        let here = &self.places[block.first * self.step..];
        let place = |lane: usize| here[lane * self.step];
        match block.count {
            LANES => [place(0), place(1), place(2), place(3)],
            3 => [place(0), place(1), place(2), UNWANTED],
            2 => [place(0), place(1), UNWANTED, UNWANTED],
            _ => [place(0), UNWANTED, UNWANTED, UNWANTED],
        }
    }

    /// A block's normals, with limits in place of those that do not exist.
    // Not given `put`: slices that a call could change are loaded again for each point.
    #[cold]
    #[inline(never)]
    fn limit_normals(
        self,
        block: &Block,
        regular: u32,
        mut normals: [[f64; LANES]; 3],
        lost: &mut usize,
    ) -> [[f64; LANES]; 3] {
        let wanted = self.wanted(block);
        for lane in (0..LANES).filter(|&lane| wanted[lane] != UNWANTED && regular >> lane & 1 == 0) {
            let (outer, outer_lane) = self.line;
            let patch = [outer.patch, block.patch];
            let place = LinePlace { patch, outer: outer.places[outer_lane], inner: block.places[lane] };
            let normal = limit_normal(self.patches, self.roles, place, lost);
            set_lane(&mut normals, lane, normal);
        }
        normals
    }
}

#[inline(always)]
fn put_wanted(wanted: [u32; LANES], points: &Points<LANES>, put: &mut impl FnMut(usize, DVec3, DVec3)) {
    for (lane, &at) in wanted.iter().enumerate().filter(|&(_, &at)| at != UNWANTED) {
        put(at as usize, points.position(lane), points.normal(lane));
    }
}

/// Evaluates the contracted curve of `m` control points at the inner lanes.
#[inline(always)]
fn kernel<F: Lanes<LANES>, const RATIONAL: bool>(
    zero: F,
    sign: f64,
    curve: &[[f64; 4]],
    lanes: &[[f64; LANES]],
    m: usize,
) -> Found<F> {
    let (value, slope) = curve.split_at(m);
    let (basis, rate) = lanes.split_at(m);
    points::<LANES, F, RATIONAL>(
        zero,
        sign,
        #[inline(always)]
        |c| {
            let (mut f, mut out, mut inn) = (zero, zero, zero);
            for k in 0..m {
                let (q, dq) = (zero.splat(value[k][c]), zero.splat(slope[k][c]));
                let (basis, rate) = (zero.load(&basis[k]), zero.load(&rate[k]));
                f = f + q * basis;
                out = out + dq * basis;
                inn = inn + q * rate;
            }
            [f, out, inn]
        },
    )
}
