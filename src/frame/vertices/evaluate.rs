//! Single parameters -> surface points and unit normals, four at a time, and what lattices share with them.
//!
//! Every lane does the same arithmetic in the same order, so the bits of a point do not depend on the other lanes.

use crate::math::bernstein;
use crate::math::lanes::{Lanes, Plain, Work, in_fours};
use crate::prepare::internals::decompose::{BezierPatches, Piece};
use glam::{DVec2, DVec3, DVec4};

/// Inner lines per block. 8 wastes half of the lanes on the short runs that patches of real models have; 2 leaves the
/// divisions unpaired.
pub(super) const LANES: usize = 4;
/// Ratio of squared lengths below which a derivative counts as vanishing, or two derivatives as parallel.
const DEGENERATE: f64 = 1e-20;

/// How u and v map to the kernel's outer and inner direction. The higher degree is inside, where more lines are
/// expected. Depends on the surface alone, so that bits do not depend on the lattice.
#[derive(Clone, Copy)]
pub(super) struct Roles {
    pub(super) inner_is_v: bool,
    pub(super) outer_points: usize,
    pub(super) inner_points: usize,
    pub(super) stride_outer: usize,
    pub(super) stride_inner: usize,
    /// Of the normal: -1 where the cross product of outer and inner derivative points against it.
    pub(super) sign: f64,
}

impl Roles {
    pub(super) fn of(patches: &BezierPatches) -> Self {
        Self::with(patches.degree_u + 1, patches.degree_v + 1)
    }

    /// Those of patches with `nu` × `nv` control points.
    const fn with(nu: usize, nv: usize) -> Self {
        if nv >= nu {
            Self { inner_is_v: true, outer_points: nu, inner_points: nv, stride_outer: nv, stride_inner: 1, sign: 1.0 }
        } else {
            Self {
                inner_is_v: false,
                outer_points: nv,
                inner_points: nu,
                stride_outer: 1,
                stride_inner: nv,
                sign: -1.0,
            }
        }
    }

    /// The outer and the inner parameter of a point.
    #[inline(always)]
    fn split(&self, p: DVec2) -> [f64; 2] {
        if self.inner_is_v { [p.x, p.y] } else { [p.y, p.x] }
    }
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
/// Same bits, limits and result as [`evaluate_lattice`](super::lattice::evaluate_lattice).
///
/// Up to degree (3, 3) about 30 ns per point if neighbours are in the same patch, else 100 ns.
// Not generic: the loops for all degrees and registers take 300 KB of code, which would be there for each caller.
pub fn evaluate_points(patches: &BezierPatches, at: &[DVec2], put: &mut dyn FnMut(usize, &PointBlock)) -> usize {
    if at.is_empty() {
        return 0;
    }
    in_fours(SinglePoints { patches, at, put })
}

/// What [`evaluate_points`] does.
struct SinglePoints<'a> {
    patches: &'a BezierPatches,
    at: &'a [DVec2],
    put: &'a mut dyn FnMut(usize, &PointBlock),
}

impl Work for SinglePoints<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<F: Lanes<LANES>>(self, zero: F) -> usize {
        let Self { patches, at, put } = self;
        let roles = Roles::of(patches);
        let mut lost = 0;
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
                let at = [[outer[0]], [inner[0]]];
                block.load(&place.evaluate(Plain([0.0]), patches, roles, at, 1, &mut lost));
            } else {
                block.points = place.evaluate(zero, patches, roles, [outer, inner], count, &mut lost);
            }
            put(done, &block);
            done += count;
        }
        lost
    }
}

/// Points at three parameters with their unit normals, zero where there is none. Same bits as [`evaluate_points`].
pub(crate) fn evaluate_three(patches: &BezierPatches, at: [DVec2; 3]) -> [(DVec3, DVec3); 3] {
    let roles = Roles::of(patches);
    let of = |points: &Points<LANES>, lane: usize| {
        let normal = if points.is_regular(lane) { points.normal(lane) } else { DVec3::ZERO };
        (points.position(lane), normal)
    };
    if let Some(three) = ThreePoints::of(patches, at) {
        let points = in_fours(three);
        return [0, 1, 2].map(|lane| of(&points, lane));
    }
    at.map(|p| of(&in_fours(ThreePoints { patches, roles, place: PatchPlace::of(patches, roles, p), at: [p; 3] }), 0))
}

/// As [`evaluate_three`], in less than half of the time, without normals. `None` if the points are in several patches.
pub(crate) fn three_positions(patches: &BezierPatches, at: [DVec2; 3]) -> Option<[DVec3; 3]> {
    let [x, y, z] = in_fours(ThreePositions(ThreePoints::of(patches, at)?));
    Some([0, 1, 2].map(|lane| DVec3::new(x[lane], y[lane], z[lane])))
}

/// What [`evaluate_three`] does in one patch.
struct ThreePoints<'a> {
    patches: &'a BezierPatches,
    roles: Roles,
    place: PatchPlace,
    at: [DVec2; 3],
}

impl<'a> ThreePoints<'a> {
    /// `None` if they are in several patches.
    #[inline(always)]
    fn of(patches: &'a BezierPatches, at: [DVec2; 3]) -> Option<Self> {
        let roles = Roles::of(patches);
        let place = PatchPlace::of(patches, roles, at[0]);
        (place.contains(roles, at[1]) && place.contains(roles, at[2])).then_some(Self { patches, roles, place, at })
    }
}

impl Work for ThreePoints<'_> {
    type Output = Points<LANES>;

    #[inline(always)]
    fn run<F: Lanes<LANES>>(self, zero: F) -> Points<LANES> {
        let Self { patches, roles, place, at } = self;
        let [[a, x], [b, y], [c, z]] = at.map(|p| roles.split(p));
        place.points(zero, patches, roles, [[a, b, c, c], [x, y, z, z]])
    }
}

/// What [`three_positions`] does. The compiler leaves out what only normals need.
struct ThreePositions<'a>(ThreePoints<'a>);

impl Work for ThreePositions<'_> {
    type Output = [[f64; LANES]; 3];

    #[inline(always)]
    fn run<F: Lanes<LANES>>(self, zero: F) -> [[f64; LANES]; 3] {
        self.0.run(zero).position
    }
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
    fn points<const L: usize, F: Lanes<L>>(
        &self,
        zero: F,
        patches: &BezierPatches,
        roles: Roles,
        at: [[f64; L]; 2],
    ) -> Points<L> {
        evaluate_lanes(zero, patches, roles, self.indices(), self.locals(at))
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
    fn evaluate<const L: usize, F: Lanes<L>>(
        &self,
        zero: F,
        patches: &BezierPatches,
        roles: Roles,
        at: [[f64; L]; 2],
        count: usize,
        lost: &mut usize,
    ) -> Points<L> {
        let mut points = self.points(zero, patches, roles, at);
        for lane in 0..count {
            if !points.is_regular(lane) {
                let [[outer], [inner]] = self.locals(at.map(|lanes| [lanes[lane]]));
                let place = LinePlace { patch: self.indices(), outer, inner };
                set_lane(&mut points.normal, lane, limit_normal(patches, roles, place, lost));
            }
        }
        points
    }
}

/// A point of the domain: its patch, and its parameters in the patch, 0 to 1.
#[derive(Clone, Copy)]
pub(super) struct LinePlace {
    /// Patch index in the outer and in the inner direction.
    pub(super) patch: [usize; 2],
    pub(super) outer: f64,
    pub(super) inner: f64,
}

/// Points and normals in registers.
pub(super) struct Found<F> {
    pub(super) position: [F; 3],
    pub(super) normal: [F; 3],
    pub(super) regular: u32,
}

impl<F> Found<F> {
    #[inline(always)]
    pub(super) fn to_points<const L: usize>(&self) -> Points<L>
    where
        F: Lanes<L>,
    {
        let ([x, y, z], [a, b, c]) = (self.position, self.normal);
        Points {
            position: [x.to_array(), y.to_array(), z.to_array()],
            normal: [a.to_array(), b.to_array(), c.to_array()],
            regular: self.regular,
        }
    }
}

/// Results of a block, lane by lane.
pub(super) struct Points<const L: usize> {
    pub(super) position: [[f64; L]; 3],
    pub(super) normal: [[f64; L]; 3],
    /// Bit by lane, whether the normal exists.
    pub(super) regular: u32,
}

impl<const L: usize> Points<L> {
    const ZERO: Self = Self { position: [[0.0; L]; 3], normal: [[0.0; L]; 3], regular: 0 };

    #[inline(always)]
    fn is_regular(&self, lane: usize) -> bool {
        self.regular >> lane & 1 == 1
    }

    #[inline(always)]
    pub(super) fn position(&self, lane: usize) -> DVec3 {
        DVec3::new(self.position[0][lane], self.position[1][lane], self.position[2][lane])
    }

    #[inline(always)]
    pub(super) fn normal(&self, lane: usize) -> DVec3 {
        DVec3::new(self.normal[0][lane], self.normal[1][lane], self.normal[2][lane])
    }
}

/// Writes a vector to one lane of its components.
#[inline(always)]
pub(super) fn set_lane<const L: usize>(components: &mut [[f64; L]; 3], lane: usize, x: DVec3) {
    components.iter_mut().zip(x.to_array()).for_each(|(row, x)| row[lane] = x);
}

/// Points and normals from components of homogeneous values, outer and inner derivatives.
#[inline(always)]
pub(super) fn points<const L: usize, F: Lanes<L>, const RATIONAL: bool>(
    zero: F,
    sign: f64,
    component: impl Fn(usize) -> [F; 3],
) -> Found<F> {
    // Derivatives up to the common positive factor 1/w.
    let (mut p, mut a, mut b) = ([zero; 3], [zero; 3], [zero; 3]);
    if RATIONAL {
        // The quotient takes longest, so it comes first.
        let [w, out, inn] = component(3);
        let per = zero.splat(1.0) / w;
        for c in 0..3 {
            let [f, x, y] = component(c);
            p[c] = f * per;
            (a[c], b[c]) = (x - p[c] * out, y - p[c] * inn);
        }
    } else {
        for c in 0..3 {
            [p[c], a[c], b[c]] = component(c);
        }
    }
    let n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let nn = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    let unit = zero.splat(sign) / nn.sqrt();
    let aa = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
    let bb = b[0] * b[0] + b[1] * b[1] + b[2] * b[2];
    let degenerate = zero.splat(DEGENERATE);
    let regular = (degenerate * aa * bb).below(nn)
        & (degenerate * bb).below(aa)
        & (degenerate * aa).below(bb)
        & nn.below(zero.splat(f64::INFINITY));
    Found { position: p, normal: [n[0] * unit, n[1] * unit, n[2] * unit], regular }
}

/// Evaluates points in one patch, one per lane, at parameters of the outer and of the inner direction.
#[inline(always)]
fn evaluate_lanes<const L: usize, F: Lanes<L>>(
    zero: F,
    patches: &BezierPatches,
    roles: Roles,
    [outer, inner]: [usize; 2],
    at: [[f64; L]; 2],
) -> Points<L> {
    let patch = if roles.inner_is_v { patches.patch(outer, inner) } else { patches.patch(inner, outer) };
    // Constant sizes, so that the compiler unrolls the loops. Where degrees are equal, v is inside.
    match (patches.rational, roles.outer_points, roles.inner_points) {
        (false, 4, 4) => in_constant_patch::<L, F, false, 4, 4>(zero, patch, const { Roles::with(4, 4) }, at),
        (true, 3, 3) => in_constant_patch::<L, F, true, 3, 3>(zero, patch, const { Roles::with(3, 3) }, at),
        (true, 2, 3) if roles.inner_is_v => {
            in_constant_patch::<L, F, true, 2, 3>(zero, patch, const { Roles::with(2, 3) }, at)
        }
        (true, 2, 3) => in_constant_patch::<L, F, true, 2, 3>(zero, patch, const { Roles::with(3, 2) }, at),
        (rational, n, m) => bernstein::with_lanes::<2, L, _>(
            n - 1,
            #[inline(always)]
            |outer| {
                bernstein::basis_and_slopes(n - 1, at[0], outer);
                bernstein::with_lanes::<2, L, _>(
                    m - 1,
                    #[inline(always)]
                    |inner| {
                        bernstein::basis_and_slopes(m - 1, at[1], inner);
                        let (outer, inner) = (outer.split_at(n), inner.split_at(m));
                        if rational {
                            in_patch::<L, F, true>(zero, patch, roles, outer, inner)
                        } else {
                            in_patch::<L, F, false>(zero, patch, roles, outer, inner)
                        }
                    },
                )
            },
        ),
    }
}

/// [`in_patch`] for a patch of `N` × `M` control points.
#[inline(always)]
fn in_constant_patch<const L: usize, F: Lanes<L>, const RATIONAL: bool, const N: usize, const M: usize>(
    zero: F,
    patch: &[DVec4],
    roles: Roles,
    at: [[f64; L]; 2],
) -> Points<L> {
    let [values, slopes] = bernstein::constant_basis_and_slopes::<N, L>(at[0]);
    let [basis, rates] = bernstein::constant_basis_and_slopes::<M, L>(at[1]);
    in_patch::<L, F, RATIONAL>(zero, &patch[..N * M], roles, (&values, &slopes), (&basis, &rates))
}

/// Evaluates a patch at the lanes of both directions, given by basis and slopes. The sums are those of lattices,
/// component by component, so that few numbers are alive at a time.
#[inline(always)]
fn in_patch<const L: usize, F: Lanes<L>, const RATIONAL: bool>(
    zero: F,
    patch: &[DVec4],
    roles: Roles,
    (values, slopes): (&[[f64; L]], &[[f64; L]]),
    (basis, rates): (&[[f64; L]], &[[f64; L]]),
) -> Points<L> {
    points::<L, F, RATIONAL>(
        zero,
        roles.sign,
        #[inline(always)]
        |k| {
            let (mut f, mut out, mut inn) = (zero, zero, zero);
            for b in 0..basis.len() {
                // These sums begin with their first product instead of zero. Only the sign of a zero may differ, which
                // is lost in the sums below.
                let (mut q, mut dq) = (zero, zero);
                for a in 0..values.len() {
                    let control: &[f64; 4] = patch[a * roles.stride_outer + b * roles.stride_inner].as_ref();
                    let c = zero.splat(control[k]);
                    let (value, slope) = (zero.load(&values[a]) * c, zero.load(&slopes[a]) * c);
                    (q, dq) = if a == 0 { (value, slope) } else { (q + value, dq + slope) };
                }
                let (basis, rate) = (zero.load(&basis[b]), zero.load(&rates[b]));
                f = f + q * basis;
                out = out + dq * basis;
                inn = inn + q * rate;
            }
            [f, out, inn]
        },
    )
    .to_points()
}

/// The normal where derivatives vanish or are parallel: that of the first regular point, of four, on the way to the
/// middle of the patch. If there is none, +z, which `lost` counts.
#[cold]
pub(super) fn limit_normal(patches: &BezierPatches, roles: Roles, at: LinePlace, lost: &mut usize) -> DVec3 {
    let towards = |x: f64, step: f64| x + (0.5 - x) * step;
    let found = [1e-6, 1e-4, 1e-2, 0.3].into_iter().find_map(|step| {
        let points = evaluate_lanes(
            Plain([0.0]),
            patches,
            roles,
            at.patch,
            [[towards(at.outer, step)], [towards(at.inner, step)]],
        );
        points.is_regular(0).then(|| points.normal(0))
    });
    found.unwrap_or_else(|| {
        *lost += 1;
        DVec3::Z
    })
}
