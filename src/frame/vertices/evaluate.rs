//! Lattice lines and single parameters -> surface points and unit normals, four at a time.
//!
//! Per outer line the patch is contracted to a curve and its cross derivative, then that curve is evaluated at blocks
//! of inner lines (tensor-product evaluation as in Kumar & Manocha 1995, §3.3, with the basis of a line computed once
//! per lattice). Every lane does the same arithmetic in the same order, so the bits of a point do not depend on the
//! other lanes.

use crate::math::bernstein;
use crate::math::lanes::widest;
use crate::prepare::internals::decompose::{BezierPatches, Piece, locate};
use glam::{DVec2, DVec3, DVec4};

/// Inner lines per block. 8 wastes half of the lanes on the short runs that patches of real models have; 2 leaves the
/// divisions unpaired.
const LANES: usize = 4;
/// Ratio of squared lengths below which a derivative counts as vanishing, or two derivatives as parallel.
const DEGENERATE: f64 = 1e-20;

/// The place of lattice points that [`evaluate_lattice`] leaves out.
pub const UNWANTED: u32 = u32::MAX;

/// Buffers that the evaluators reuse. They do not affect results.
#[derive(Default, Debug)]
pub struct EvaluateScratch {
    /// Basis row and derivative row of each outer line.
    outer: Vec<f64>,
    /// Patch index of each outer line, and its parameter in the patch.
    places: Vec<(usize, f64)>,
    blocks: Vec<Block>,
    /// Per block the basis of its lanes, then its derivative, `inner degree + 1` rows each.
    inner: Vec<[f64; LANES]>,
    /// The contracted curve and its cross derivative.
    curve: Vec<[f64; 4]>,
}

/// Up to [`LANES`] neighbouring inner lines of one patch.
#[derive(Clone, Copy, Debug)]
struct Block {
    patch: usize,
    first: usize,
    count: usize,
    places: [f64; LANES],
}

/// How u and v map to the kernel's outer and inner direction. The higher degree is inside, where more lines are
/// expected. Depends on the surface alone, so that bits do not depend on the lattice.
#[derive(Clone, Copy)]
struct Roles {
    inner_is_v: bool,
    outer_points: usize,
    inner_points: usize,
    stride_outer: usize,
    stride_inner: usize,
}

impl Roles {
    /// Degree 1 in u and 2 in v, and the reverse: parts of cylinders and cones.
    const WIDE: Self = Self { inner_is_v: true, outer_points: 2, inner_points: 3, stride_outer: 3, stride_inner: 1 };
    const TALL: Self = Self { inner_is_v: false, outer_points: 2, inner_points: 3, stride_outer: 1, stride_inner: 2 };

    /// As many control points in u as in v.
    const fn square(n: usize) -> Self {
        Self { inner_is_v: true, outer_points: n, inner_points: n, stride_outer: n, stride_inner: 1 }
    }

    fn of(patches: &BezierPatches) -> Self {
        let (nu, nv) = (patches.degree_u + 1, patches.degree_v + 1);
        if patches.degree_v >= patches.degree_u {
            Self { inner_is_v: true, outer_points: nu, inner_points: nv, stride_outer: nv, stride_inner: 1 }
        } else {
            Self { inner_is_v: false, outer_points: nv, inner_points: nu, stride_outer: 1, stride_inner: nv }
        }
    }

    /// The outer and the inner parameter of a point.
    #[inline(always)]
    fn split(&self, p: DVec2) -> [f64; 2] {
        if self.inner_is_v { [p.x, p.y] } else { [p.y, p.x] }
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
    mut put: impl FnMut(usize, DVec3, DVec3),
) -> usize {
    let roles = Roles::of(patches);
    let (outer, outer_breaks, inner, inner_breaks) = if roles.inner_is_v {
        (us, &patches.breaks_u, vs, &patches.breaks_v)
    } else {
        (vs, &patches.breaks_v, us, &patches.breaks_u)
    };
    let (row, step) = if roles.inner_is_v { (1, us.len()) } else { (us.len(), 1) };
    let (n, m) = (roles.outer_points, roles.inner_points);
    let mut lost = 0;
    widest(
        #[inline(always)]
        || {
            scratch.outer_lines(roles.outer_points - 1, outer_breaks, outer);
            scratch.inner_lines(roles.inner_points - 1, inner_breaks, inner);
            for o in 0..outer.len() {
                let (patch_outer, x) = scratch.places[o];
                let basis = &scratch.outer[o * 2 * n..(o + 1) * 2 * n];
                let mut contracted = usize::MAX;
                for (k, block) in scratch.blocks.iter().enumerate() {
                    let here = places[o * row + block.first * step..].iter().step_by(step);
                    let (mut wanted, mut all) = ([UNWANTED; LANES], UNWANTED);
                    for (at, &place) in wanted[..block.count].iter_mut().zip(here) {
                        *at = place;
                        all &= place;
                    }
                    // One by one: numbers that were stored one by one are slow to load together.
                    if all == UNWANTED {
                        continue;
                    }
                    if contracted != block.patch {
                        contract(patches, roles, patch_outer, block.patch, basis, &mut scratch.curve);
                        contracted = block.patch;
                    }
                    let lanes = &scratch.inner[k * 2 * m..(k + 1) * 2 * m];
                    let mut points = evaluate_block(patches.rational, roles.inner_is_v, &scratch.curve, lanes);
                    for (lane, _) in wanted.iter().enumerate().filter(|&(_, &at)| at != UNWANTED) {
                        if !points.regular[lane] {
                            let patch = [patch_outer, block.patch];
                            let place = LinePlace { patch, outer: x, inner: block.places[lane] };
                            points.set_normal(lane, limit_normal(patches, roles, place, &mut lost));
                        }
                    }
                    for (lane, &at) in wanted.iter().enumerate().filter(|&(_, &at)| at != UNWANTED) {
                        put(at as usize, points.position(lane), points.normal(lane));
                    }
                }
            }
        },
    );
    lost
}

/// Up to four points and their unit normals.
///
/// Handed over together: numbers that are stored one by one and loaded together at once make the processor wait.
pub struct PointBlock {
    count: usize,
    points: Points<LANES>,
}

impl PointBlock {
    /// The points with their normals, in order.
    #[inline(always)]
    pub fn iter(&self) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
        (0..self.count.min(LANES)).map(|lane| (self.points.position(lane), self.points.normal(lane)))
    }

    #[inline(always)]
    fn load<const L: usize>(&mut self, points: &Points<L>) {
        for c in 0..3 {
            self.points.position[c][..L].copy_from_slice(&points.position[c]);
            self.points.normal[c][..L].copy_from_slice(&points.normal[c]);
        }
    }
}

/// Calls `put` with the points and unit normals at single parameters, in order, and the index of the first of them.
/// Same bits, limits and result as [`evaluate_lattice`].
///
/// Up to degree (3, 3) about 40 ns per point if neighbours are in the same patch, else 100 ns.
// Not generic: the loops for all degrees and registers take 300 KB of code, which would be there for each caller.
pub fn evaluate_points(patches: &BezierPatches, at: &[DVec2], put: &mut dyn FnMut(usize, &PointBlock)) -> usize {
    let roles = Roles::of(patches);
    let mut lost = 0;
    widest(
        #[inline(always)]
        || {
            let mut place = PatchPlace::of(patches, roles, at.first().copied().unwrap_or_default());
            let mut block = PointBlock { count: 0, points: Points::ZERO };
            let mut done = 0;
            while let Some(&first) = at.get(done) {
                if !place.contains(roles, first) {
                    place = PatchPlace::of(patches, roles, first);
                }
                let [outer, inner] = roles.split(first);
                let (mut outer, mut inner) = ([outer; LANES], [inner; LANES]);
                let mut count = 1;
                while count < LANES && at.get(done + count).is_some_and(|&p| place.contains(roles, p)) {
                    [outer[count], inner[count]] = roles.split(at[done + count]);
                    count += 1;
                }
                block.count = count;
                // One lane is faster than four copies of it.
                if count == 1 {
                    block.load(&place.evaluate(patches, roles, [[outer[0]], [inner[0]]], 1, &mut lost));
                } else {
                    block.points = place.evaluate(patches, roles, [outer, inner], count, &mut lost);
                }
                put(done, &block);
                done += count;
            }
        },
    );
    lost
}

/// Points at three parameters with their unit normals, zero where there is none. Same bits as [`evaluate_points`].
pub(crate) fn evaluate_three(patches: &BezierPatches, at: [DVec2; 3]) -> [(DVec3, DVec3); 3] {
    let roles = Roles::of(patches);
    let of = |points: &Points<4>, lane: usize| {
        let normal = if points.regular[lane] { points.normal(lane) } else { DVec3::ZERO };
        (points.position(lane), normal)
    };
    let together = |place: PatchPlace, [a, b, c]: [DVec2; 3]| {
        let [[a, x], [b, y], [c, z]] = [a, b, c].map(|p| roles.split(p));
        widest(
            #[inline(always)]
            || place.points(patches, roles, [[a, b, c, c], [x, y, z, z]]),
        )
    };
    let place = PatchPlace::of(patches, roles, at[0]);
    if place.contains(roles, at[1]) && place.contains(roles, at[2]) {
        let points = together(place, at);
        return [0, 1, 2].map(|lane| of(&points, lane));
    }
    at.map(|p| of(&together(PatchPlace::of(patches, roles, p), [p; 3]), 0))
}

/// The place of a patch: its pieces of the outer and of the inner direction.
#[derive(Clone, Copy)]
struct PatchPlace {
    outer: Piece,
    inner: Piece,
}

impl PatchPlace {
    #[inline(always)]
    fn of(patches: &BezierPatches, roles: Roles, p: DVec2) -> Self {
        let (u, v) = (Piece::at(&patches.breaks_u, p.x), Piece::at(&patches.breaks_v, p.y));
        if roles.inner_is_v { Self { outer: u, inner: v } } else { Self { outer: v, inner: u } }
    }

    #[inline(always)]
    fn contains(&self, roles: Roles, p: DVec2) -> bool {
        let [outer, inner] = roles.split(p);
        self.outer.contains(outer) && self.inner.contains(inner)
    }

    /// Points at parameters of the outer and of the inner direction.
    #[inline(always)]
    fn points<const L: usize>(&self, patches: &BezierPatches, roles: Roles, at: [[f64; L]; 2]) -> Points<L> {
        evaluate_lanes(patches, roles, self.indices(), self.locals(at))
    }

    #[inline(always)]
    fn indices(&self) -> [usize; 2] {
        [self.outer.index, self.inner.index]
    }

    #[inline(always)]
    fn locals<const L: usize>(&self, at: [[f64; L]; 2]) -> [[f64; L]; 2] {
        [self.outer.locals(at[0]), self.inner.locals(at[1])]
    }

    /// The points; the first `count` of them have the limit of the normals around them where they are singular.
    #[inline(always)]
    fn evaluate<const L: usize>(
        &self,
        patches: &BezierPatches,
        roles: Roles,
        at: [[f64; L]; 2],
        count: usize,
        lost: &mut usize,
    ) -> Points<L> {
        let mut points = self.points(patches, roles, at);
        for lane in 0..count {
            if !points.regular[lane] {
                let [[outer], [inner]] = self.locals(at.map(|lanes| [lanes[lane]]));
                let place = LinePlace { patch: self.indices(), outer, inner };
                points.set_normal(lane, limit_normal(patches, roles, place, lost));
            }
        }
        points
    }
}

/// A point of the domain: its patch, and its parameters in the patch, 0 to 1.
#[derive(Clone, Copy)]
struct LinePlace {
    /// Patch index in the outer and in the inner direction.
    patch: [usize; 2],
    outer: f64,
    inner: f64,
}

impl EvaluateScratch {
    /// Sets places and bases of the outer lines.
    #[inline(always)]
    fn outer_lines(&mut self, degree: usize, breaks: &[f64], lines: &[f64]) {
        self.places.clear();
        self.outer.clear();
        for &t in lines {
            let place = locate(breaks, t);
            self.places.push(place);
            bernstein::with_lanes(
                degree,
                #[inline(always)]
                |rows| {
                    bernstein::basis_and_slopes(degree, [place.1], rows);
                    self.outer.extend_from_slice(rows.as_flattened());
                },
            );
        }
    }

    /// Groups inner lines into blocks and sets their bases. Blocks end where the patch changes; short ones repeat their
    /// last line.
    #[inline(always)]
    fn inner_lines(&mut self, degree: usize, breaks: &[f64], lines: &[f64]) {
        self.blocks.clear();
        self.inner.clear();
        for (i, &t) in lines.iter().enumerate() {
            let (patch, x) = locate(breaks, t);
            match self.blocks.last_mut() {
                Some(block) if block.patch == patch && block.count < LANES => {
                    block.places[block.count..].fill(x);
                    block.count += 1;
                }
                _ => self.blocks.push(Block { patch, first: i, count: 1, places: [x; LANES] }),
            }
        }
        let size = 2 * (degree + 1);
        for block in &self.blocks {
            let start = self.inner.len();
            self.inner.resize(start + size, [0.0; LANES]);
            bernstein::basis_and_slopes(degree, block.places, &mut self.inner[start..]);
        }
    }
}

/// Contracts a patch along the outer direction: the curve's control points, then those of its outer derivative.
#[inline(always)]
fn contract(
    patches: &BezierPatches,
    roles: Roles,
    outer: usize,
    inner: usize,
    basis: &[f64],
    curve: &mut Vec<[f64; 4]>,
) {
    let patch = if roles.inner_is_v { patches.patch(outer, inner) } else { patches.patch(inner, outer) };
    let (n, m) = (roles.outer_points, roles.inner_points);
    curve.clear();
    curve.resize(2 * m, [0.0; 4]);
    let (value, slope) = curve.split_at_mut(m);
    for a in 0..n {
        let (f, d) = (basis[a], basis[n + a]);
        for (b, (q, dq)) in value.iter_mut().zip(slope.iter_mut()).enumerate() {
            let c = patch[a * roles.stride_outer + b * roles.stride_inner].to_array();
            for k in 0..4 {
                q[k] += f * c[k];
                dq[k] += d * c[k];
            }
        }
    }
}

/// Results of a block, lane by lane.
struct Points<const L: usize> {
    position: [[f64; L]; 3],
    normal: [[f64; L]; 3],
    regular: [bool; L],
}

impl<const L: usize> Points<L> {
    const ZERO: Self = Self { position: [[0.0; L]; 3], normal: [[0.0; L]; 3], regular: [false; L] };

    #[inline(always)]
    fn position(&self, lane: usize) -> DVec3 {
        DVec3::new(self.position[0][lane], self.position[1][lane], self.position[2][lane])
    }

    #[inline(always)]
    fn normal(&self, lane: usize) -> DVec3 {
        DVec3::new(self.normal[0][lane], self.normal[1][lane], self.normal[2][lane])
    }

    #[inline(always)]
    fn set_normal(&mut self, lane: usize, normal: DVec3) {
        self.normal.iter_mut().zip(normal.to_array()).for_each(|(row, x)| row[lane] = x);
    }
}

/// Evaluates the contracted curve at the inner lanes. Degrees 1 to 3 get loops of constant length, with the same sums.
#[inline(always)]
fn evaluate_block<const L: usize>(
    rational: bool,
    inner_is_v: bool,
    curve: &[[f64; 4]],
    lanes: &[[f64; L]],
) -> Points<L> {
    match (rational, curve.len()) {
        (false, 4) => kernel::<L, false>(inner_is_v, &curve[..4], &lanes[..4], 2),
        (false, 6) => kernel::<L, false>(inner_is_v, &curve[..6], &lanes[..6], 3),
        (false, 8) => kernel::<L, false>(inner_is_v, &curve[..8], &lanes[..8], 4),
        (false, n) => kernel::<L, false>(inner_is_v, curve, lanes, n / 2),
        (true, 4) => kernel::<L, true>(inner_is_v, &curve[..4], &lanes[..4], 2),
        (true, 6) => kernel::<L, true>(inner_is_v, &curve[..6], &lanes[..6], 3),
        (true, 8) => kernel::<L, true>(inner_is_v, &curve[..8], &lanes[..8], 4),
        (true, n) => kernel::<L, true>(inner_is_v, curve, lanes, n / 2),
    }
}

#[inline(always)]
fn kernel<const L: usize, const RATIONAL: bool>(
    inner_is_v: bool,
    curve: &[[f64; 4]],
    lanes: &[[f64; L]],
    m: usize,
) -> Points<L> {
    // Homogeneous value, outer derivative, inner derivative.
    let mut f = [[0.0; L]; 4];
    let mut out = [[0.0; L]; 4];
    let mut inn = [[0.0; L]; 4];
    let components = if RATIONAL { 4 } else { 3 };
    let (value, slope) = curve.split_at(m);
    let (basis, rate) = lanes.split_at(m);
    for c in 0..components {
        for k in 0..m {
            let (q, dq) = (value[k][c], slope[k][c]);
            for l in 0..L {
                f[c][l] += q * basis[k][l];
                out[c][l] += dq * basis[k][l];
                inn[c][l] += q * rate[k][l];
            }
        }
    }
    points::<L, RATIONAL>(inner_is_v, &f, &out, &inn)
}

/// Points and normals from homogeneous values, outer and inner derivatives.
#[inline(always)]
fn points<const L: usize, const RATIONAL: bool>(
    inner_is_v: bool,
    f: &[[f64; L]; 4],
    out: &[[f64; L]; 4],
    inn: &[[f64; L]; 4],
) -> Points<L> {
    let mut points = Points::ZERO;
    for l in 0..L {
        let mut p = [f[0][l], f[1][l], f[2][l]];
        // Derivatives up to the common positive factor 1/w.
        let mut a = [out[0][l], out[1][l], out[2][l]];
        let mut b = [inn[0][l], inn[1][l], inn[2][l]];
        if RATIONAL {
            let per = 1.0 / f[3][l];
            for c in 0..3 {
                p[c] *= per;
                a[c] -= p[c] * out[3][l];
                b[c] -= p[c] * inn[3][l];
            }
        }
        let n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        let aa = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
        let bb = b[0] * b[0] + b[1] * b[1] + b[2] * b[2];
        let nn = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
        let sign = if inner_is_v { 1.0 } else { -1.0 };
        let unit = sign / nn.sqrt();
        for c in 0..3 {
            points.position[c][l] = p[c];
            points.normal[c][l] = n[c] * unit;
        }
        points.regular[l] =
            (nn > DEGENERATE * aa * bb) & (aa > DEGENERATE * bb) & (bb > DEGENERATE * aa) & (nn < f64::INFINITY);
    }
    points
}

/// Evaluates points in one patch, one per lane, at parameters of the outer and of the inner direction.
#[inline(always)]
fn evaluate_lanes<const L: usize>(
    patches: &BezierPatches,
    roles: Roles,
    [outer, inner]: [usize; 2],
    at: [[f64; L]; 2],
) -> Points<L> {
    let patch = if roles.inner_is_v { patches.patch(outer, inner) } else { patches.patch(inner, outer) };
    // Constant sizes, so that the compiler unrolls the loops. Where degrees are equal, v is inside.
    match (patches.rational, roles.outer_points, roles.inner_points) {
        (false, 2, 2) => in_constant_patch::<L, false, 2, 2>(patch, Roles::square(2), at),
        (false, 4, 4) => in_constant_patch::<L, false, 4, 4>(patch, Roles::square(4), at),
        (true, 3, 3) => in_constant_patch::<L, true, 3, 3>(patch, Roles::square(3), at),
        (true, 4, 4) => in_constant_patch::<L, true, 4, 4>(patch, Roles::square(4), at),
        (true, 2, 3) if roles.inner_is_v => in_constant_patch::<L, true, 2, 3>(patch, Roles::WIDE, at),
        (true, 2, 3) => in_constant_patch::<L, true, 2, 3>(patch, Roles::TALL, at),
        (rational, n, m) => bernstein::with_lanes(
            n - 1,
            #[inline(always)]
            |outer| {
                bernstein::basis_and_slopes(n - 1, at[0], outer);
                bernstein::with_lanes(
                    m - 1,
                    #[inline(always)]
                    |inner| {
                        bernstein::basis_and_slopes(m - 1, at[1], inner);
                        let (outer, inner) = (outer.split_at(n), inner.split_at(m));
                        if rational {
                            in_patch::<L, true>(patch, roles, outer, inner)
                        } else {
                            in_patch::<L, false>(patch, roles, outer, inner)
                        }
                    },
                )
            },
        ),
    }
}

/// [`in_patch`] for a patch of `N` × `M` control points.
#[inline(always)]
fn in_constant_patch<const L: usize, const RATIONAL: bool, const N: usize, const M: usize>(
    patch: &[DVec4],
    roles: Roles,
    at: [[f64; L]; 2],
) -> Points<L> {
    let [values, slopes] = bernstein::constant_basis_and_slopes::<N, L>(at[0]);
    let [basis, rates] = bernstein::constant_basis_and_slopes::<M, L>(at[1]);
    in_patch::<L, RATIONAL>(&patch[..N * M], roles, (&values, &slopes), (&basis, &rates))
}

/// Evaluates a patch at the lanes of both directions, given by basis and slopes. The sums are those of [`contract`] and
/// [`kernel`], component by component, so that few numbers are alive at a time.
#[inline(always)]
fn in_patch<const L: usize, const RATIONAL: bool>(
    patch: &[DVec4],
    roles: Roles,
    (values, slopes): (&[[f64; L]], &[[f64; L]]),
    (basis, rates): (&[[f64; L]], &[[f64; L]]),
) -> Points<L> {
    let components = if RATIONAL { 4 } else { 3 };
    let (mut f, mut out, mut inn) = ([[0.0; L]; 4], [[0.0; L]; 4], [[0.0; L]; 4]);
    for k in 0..components {
        for b in 0..basis.len() {
            // These sums begin with their first product instead of zero. Only the sign of a zero may differ, which is
            // lost in the sums below.
            let (mut q, mut dq) = ([0.0; L], [0.0; L]);
            for a in 0..values.len() {
                let control: &[f64; 4] = patch[a * roles.stride_outer + b * roles.stride_inner].as_ref();
                let c = control[k];
                for l in 0..L {
                    let (value, slope) = (values[a][l] * c, slopes[a][l] * c);
                    (q[l], dq[l]) = if a == 0 { (value, slope) } else { (q[l] + value, dq[l] + slope) };
                }
            }
            for l in 0..L {
                f[k][l] += q[l] * basis[b][l];
                out[k][l] += dq[l] * basis[b][l];
                inn[k][l] += q[l] * rates[b][l];
            }
        }
    }
    points::<L, RATIONAL>(roles.inner_is_v, &f, &out, &inn)
}

/// The normal where derivatives vanish or are parallel: that of the first regular point, of four, on the way to the
/// middle of the patch. If there is none, +z, which `lost` counts.
#[cold]
fn limit_normal(patches: &BezierPatches, roles: Roles, at: LinePlace, lost: &mut usize) -> DVec3 {
    let towards = |x: f64, step: f64| x + (0.5 - x) * step;
    let found = [1e-6, 1e-4, 1e-2, 0.3].into_iter().find_map(|step| {
        let points = evaluate_lanes(patches, roles, at.patch, [[towards(at.outer, step)], [towards(at.inner, step)]]);
        points.regular[0].then(|| points.normal(0))
    });
    found.unwrap_or_else(|| {
        *lost += 1;
        DVec3::Z
    })
}
