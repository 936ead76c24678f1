//! Lattice lines and single parameters -> surface points and unit normals, four at a time.
//!
//! Per outer line the patch is contracted to a curve and its cross derivative, then that curve is evaluated at blocks
//! of inner lines (tensor-product evaluation as in Kumar & Manocha 1995, §3.3, with the basis of a line computed once
//! per lattice). Every lane does the same arithmetic in the same order, so the bits of a point do not depend on the
//! other lanes.

use crate::math::bernstein;
use crate::math::lanes::widest;
use crate::prepare::internals::decompose::{BezierPatches, locate};
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
}

/// Calls `put` with the points and unit normals (along `S_u × S_v`) at the crossings of the lines `us` and `vs`
/// (non-decreasing), in any order. The first argument is `place(i, j)` of the point at `us[i]` and `vs[j]`, which is
/// [`UNWANTED`] for points to leave out.
///
/// At poles and collapsed borders the normal is its limit from inside the patch. Returns the number of normals that do
/// not exist even there; they are +z. 5-15 ns per point up to degree (3, 3); allocates only to grow the buffers.
pub fn evaluate_lattice(
    patches: &BezierPatches,
    us: &[f64],
    vs: &[f64],
    place: impl Fn(usize, usize) -> u32,
    scratch: &mut EvaluateScratch,
    mut put: impl FnMut(usize, DVec3, DVec3),
) -> usize {
    let roles = Roles::of(patches);
    let (outer, outer_breaks, inner, inner_breaks) = if roles.inner_is_v {
        (us, &patches.breaks_u, vs, &patches.breaks_v)
    } else {
        (vs, &patches.breaks_v, us, &patches.breaks_u)
    };
    let place = |o: usize, i: usize| if roles.inner_is_v { place(o, i) } else { place(i, o) };
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
                    let mut places = [UNWANTED; LANES];
                    for (at, i) in places.iter_mut().zip(block.first..block.first + block.count) {
                        *at = place(o, i);
                    }
                    if places == [UNWANTED; LANES] {
                        continue;
                    }
                    if contracted != block.patch {
                        contract(patches, roles, patch_outer, block.patch, basis, &mut scratch.curve);
                        contracted = block.patch;
                    }
                    let lanes = &scratch.inner[k * 2 * m..(k + 1) * 2 * m];
                    let points = evaluate_block(patches.rational, roles.inner_is_v, &scratch.curve, lanes);
                    for (lane, &at) in places.iter().enumerate().filter(|&(_, &at)| at != UNWANTED) {
                        let normal = if points.regular[lane] {
                            points.normal(lane)
                        } else {
                            let place =
                                LinePlace { patch: [patch_outer, block.patch], outer: x, inner: block.places[lane] };
                            limit_normal(patches, roles, place, &mut lost)
                        };
                        put(at as usize, points.position(lane), normal);
                    }
                }
            }
        },
    );
    lost
}

/// Calls `put` with the points and unit normals at single parameters, in order. Same bits, limits and result as
/// [`evaluate_lattice`].
///
/// Up to degree (3, 3) about 40 ns per point if neighbours are in the same patch, else 100 ns.
// Not generic: the loops for all degrees and registers take 300 KB of code, which would be there for each caller.
pub fn evaluate_points(patches: &BezierPatches, at: &[DVec2], put: &mut dyn FnMut(usize, DVec3, DVec3)) -> usize {
    let roles = Roles::of(patches);
    let mut lost = 0;
    widest(
        #[inline(always)]
        || {
            let mut rest = at.iter().map(
                #[inline(always)]
                |&p| LinePlace::of(patches, roles, p),
            );
            let mut next = rest.next();
            let mut at = 0;
            while let Some(first) = next {
                let (mut outer, mut inner) = ([first.outer; LANES], [first.inner; LANES]);
                let mut count = 1;
                loop {
                    next = rest.next();
                    match next {
                        Some(next) if count < LANES && next.patch == first.patch => {
                            (outer[count], inner[count]) = (next.outer, next.inner);
                            count += 1;
                        }
                        _ => break,
                    }
                }
                let mut put_lane = |position: DVec3, normal: DVec3| {
                    put(at, position, normal);
                    at += 1;
                };
                // One lane is faster than four copies of it.
                if count == 1 {
                    let points = evaluate_lanes(patches, roles, first.patch, [first.outer], [first.inner]);
                    let normal = if points.regular[0] {
                        points.normal(0)
                    } else {
                        limit_normal(patches, roles, first, &mut lost)
                    };
                    put_lane(points.position(0), normal);
                    continue;
                }
                let points = evaluate_lanes(patches, roles, first.patch, outer, inner);
                for lane in 0..count {
                    let normal = if points.regular[lane] {
                        points.normal(lane)
                    } else {
                        let place = LinePlace { outer: outer[lane], inner: inner[lane], ..first };
                        limit_normal(patches, roles, place, &mut lost)
                    };
                    put_lane(points.position(lane), normal);
                }
            }
        },
    );
    lost
}

/// Points at three parameters with their unit normals, zero where there is none. Same bits as [`evaluate_points`].
pub(crate) fn evaluate_three(patches: &BezierPatches, at: [DVec2; 3]) -> [(DVec3, DVec3); 3] {
    let roles = Roles::of(patches);
    let [a, b, c] = at.map(|p| LinePlace::of(patches, roles, p));
    let of = |points: &Points<4>, lane: usize| {
        let normal = if points.regular[lane] { points.normal(lane) } else { DVec3::ZERO };
        (points.position(lane), normal)
    };
    let together = |[a, b, c]: [LinePlace; 3]| {
        let lanes = |x: fn(LinePlace) -> f64| [x(a), x(b), x(c), x(c)];
        widest(
            #[inline(always)]
            || evaluate_lanes(patches, roles, a.patch, lanes(|p| p.outer), lanes(|p| p.inner)),
        )
    };
    if a.patch == b.patch && b.patch == c.patch {
        let points = together([a, b, c]);
        return [0, 1, 2].map(|lane| of(&points, lane));
    }
    [a, b, c].map(|p| of(&together([p; 3]), 0))
}

/// A point of the domain: its patch, and its parameters in the patch, 0 to 1.
#[derive(Clone, Copy)]
struct LinePlace {
    /// Patch index in the outer and in the inner direction.
    patch: [usize; 2],
    outer: f64,
    inner: f64,
}

impl LinePlace {
    #[inline(always)]
    fn of(patches: &BezierPatches, roles: Roles, DVec2 { x: u, y: v }: DVec2) -> Self {
        let (in_u, in_v) = (locate(&patches.breaks_u, u), locate(&patches.breaks_v, v));
        let (outer, inner) = if roles.inner_is_v { (in_u, in_v) } else { (in_v, in_u) };
        Self { patch: [outer.0, inner.0], outer: outer.1, inner: inner.1 }
    }
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
    #[inline(always)]
    fn position(&self, lane: usize) -> DVec3 {
        DVec3::new(self.position[0][lane], self.position[1][lane], self.position[2][lane])
    }

    #[inline(always)]
    fn normal(&self, lane: usize) -> DVec3 {
        DVec3::new(self.normal[0][lane], self.normal[1][lane], self.normal[2][lane])
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
    let mut points = Points { position: [[0.0; L]; 3], normal: [[0.0; L]; 3], regular: [false; L] };
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

/// Evaluates points in one patch, one per lane.
#[inline(always)]
fn evaluate_lanes<const L: usize>(
    patches: &BezierPatches,
    roles: Roles,
    [outer, inner]: [usize; 2],
    in_outer: [f64; L],
    in_inner: [f64; L],
) -> Points<L> {
    let patch = if roles.inner_is_v { patches.patch(outer, inner) } else { patches.patch(inner, outer) };
    let (n, m) = (roles.outer_points, roles.inner_points);
    // Inlined, so that they are compiled for the registers of the caller.
    bernstein::with_lanes(
        n - 1,
        #[inline(always)]
        |outer| {
            bernstein::basis_and_slopes(n - 1, in_outer, outer);
            bernstein::with_lanes(
                m - 1,
                #[inline(always)]
                |inner| {
                    bernstein::basis_and_slopes(m - 1, in_inner, inner);
                    // Constant sizes, so that the compiler unrolls the loops. Where degrees are equal, v is inside.
                    match (patches.rational, n, m) {
                        (false, 2, 2) => in_patch::<L, false>(&patch[..4], Roles::square(2), outer, inner),
                        (false, 4, 4) => in_patch::<L, false>(&patch[..16], Roles::square(4), outer, inner),
                        (true, 3, 3) => in_patch::<L, true>(&patch[..9], Roles::square(3), outer, inner),
                        (true, 4, 4) => in_patch::<L, true>(&patch[..16], Roles::square(4), outer, inner),
                        (true, 2, 3) if roles.inner_is_v => in_patch::<L, true>(&patch[..6], Roles::WIDE, outer, inner),
                        (true, 2, 3) => in_patch::<L, true>(&patch[..6], Roles::TALL, outer, inner),
                        (false, ..) => in_patch::<L, false>(patch, roles, outer, inner),
                        (true, ..) => in_patch::<L, true>(patch, roles, outer, inner),
                    }
                },
            )
        },
    )
}

/// Evaluates a patch at the lanes of both directions, with the same sums as [`contract`] and [`kernel`].
#[inline(always)]
fn in_patch<const L: usize, const RATIONAL: bool>(
    patch: &[DVec4],
    roles: Roles,
    outer: &[[f64; L]],
    inner: &[[f64; L]],
) -> Points<L> {
    let (n, m) = (roles.outer_points, roles.inner_points);
    let components = if RATIONAL { 4 } else { 3 };
    let (mut f, mut out, mut inn) = ([[0.0; L]; 4], [[0.0; L]; 4], [[0.0; L]; 4]);
    let ((values, slopes), (basis, rate)) = (outer.split_at(n), inner.split_at(m));
    for b in 0..m {
        let (mut q, mut dq) = ([[0.0; L]; 4], [[0.0; L]; 4]);
        for a in 0..n {
            let c = patch[a * roles.stride_outer + b * roles.stride_inner].to_array();
            for k in 0..components {
                for l in 0..L {
                    q[k][l] += values[a][l] * c[k];
                    dq[k][l] += slopes[a][l] * c[k];
                }
            }
        }
        for k in 0..components {
            for l in 0..L {
                f[k][l] += q[k][l] * basis[b][l];
                out[k][l] += dq[k][l] * basis[b][l];
                inn[k][l] += q[k][l] * rate[b][l];
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
        let points = evaluate_lanes(patches, roles, at.patch, [towards(at.outer, step)], [towards(at.inner, step)]);
        points.regular[0].then(|| points.normal(0))
    });
    found.unwrap_or_else(|| {
        *lost += 1;
        DVec3::Z
    })
}
