//! Three points of the plane, or two and a direction -> the exact sign of their turn.
//!
//! A floating-point filter decides nearly every call. The rest go to the adaptive predicate of Shewchuk, "Adaptive
//! Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997, in the crate `robust`.

use glam::DVec2;

/// A difference of two rounded products whose magnitude exceeds this share of the products' sum has the right sign.
/// Shewchuk's constant is (3 + 16 eps) eps = 3.3307e-16; this is larger because the bound itself is rounded.
const FILTER: f64 = 4.5e-16;

/// Twice the signed area of the triangle `a`, `b`, `c`: positive if counter-clockwise.
///
/// The sign is exact (0.0 if and only if the points are collinear) for finite coordinates whose products neither
/// overflow nor underflow, the magnitude is rounded.
#[inline]
pub fn orient2d(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let left = (a.x - c.x) * (b.y - c.y);
    let right = (a.y - c.y) * (b.x - c.x);
    let det = left - right;
    if det.abs() > FILTER * (left.abs() + right.abs()) { det } else { orient2d_adaptive(a, b, c) }
}

/// Not inlined: the filter decides nearly every call, and callers stay small.
#[cold]
#[inline(never)]
fn orient2d_adaptive(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let coord = |p: DVec2| robust::Coord { x: p.x, y: p.y };
    robust::orient2d(coord(a), coord(b), coord(c))
}

/// How far `b` is from `a` to the right of a direction, times the direction's length. The sign is exact, as that of
/// [`orient2d`].
#[inline]
pub(crate) fn across(a: DVec2, b: DVec2, direction: DVec2) -> f64 {
    let left = (b.x - a.x) * direction.y;
    let right = (b.y - a.y) * direction.x;
    let det = left - right;
    if det.abs() > FILTER * (left.abs() + right.abs()) { det } else { across_adaptive(a, b, direction) }
}

/// The orientation of two points and the infinite point of the direction, in homogeneous coordinates.
#[cold]
#[inline(never)]
fn across_adaptive(a: DVec2, b: DVec2, direction: DVec2) -> f64 {
    let coord = |p: DVec2, z: f64| robust::Coord3D { x: p.x, y: p.y, z };
    robust::orient3d(coord(a, 1.0), coord(b, 1.0), coord(direction, 0.0), coord(DVec2::ZERO, 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The exact turn of points with the given grid indices.
    fn exact(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i128 {
        let d = |p: i64, q: i64| i128::from(p) - i128::from(q);
        d(a[0], c[0]) * d(b[1], c[1]) - d(a[1], c[1]) * d(b[0], c[0])
    }

    #[test]
    fn sign_is_exact_on_the_finest_grid_around_a_diagonal() {
        let step = f64::EPSILON / 2.0;
        let point = |k: [i64; 2]| DVec2::new(0.5 + k[0] as f64 * step, 0.5 + k[1] as f64 * step);
        let far = 1i64 << 52;
        let (b, c) = ([far * 23, far * 23], [far * 47, far * 47]);
        let mut on = 0;
        for i in 0..40 {
            for j in 0..40 {
                let a = [i, j];
                let want = exact(a, b, c).signum();
                let got = orient2d(point(a), DVec2::splat(12.0), DVec2::splat(24.0));
                assert_eq!(got.partial_cmp(&0.0), Some(want.cmp(&0)), "{i} {j}");
                on += u32::from(want == 0);
            }
        }
        assert_eq!(on, 40);
    }

    #[test]
    fn a_point_near_a_line_is_on_its_side() {
        let (a, b) = (DVec2::ZERO, DVec2::X);
        assert!(orient2d(a, b, DVec2::new(0.3, 1e-300)) > 0.0);
        assert!(orient2d(a, b, DVec2::new(0.3, -1e-300)) < 0.0);
        assert_eq!([DVec2::new(7.0, 0.0), a, b].map(|p| orient2d(a, b, p)), [0.0; 3]);
        assert_eq!(orient2d(a, a, DVec2::Y), 0.0);
    }

    #[test]
    fn what_is_to_the_right_of_a_direction_is_exact() {
        // Whole units: products are of at most 106 bits.
        let unit = f64::EPSILON / 2.0;
        let direction = [0.618_033_988_749_894_9, -0.3].map(|x: f64| (x / unit) as i64);
        let point = |[x, y]: [i64; 2]| DVec2::new(x as f64 * unit, y as f64 * unit);
        let far = 1i64 << 52;
        for k in 0..400 {
            // Far along the direction, and a few units from there.
            let a = [far / 7 + k % 20, far / 3 - k / 20];
            let share = |x: i64| (i128::from(x) * i128::from(k) / 400) as i64;
            let b = [a[0] + share(direction[0]), a[1] + share(direction[1])];
            let want =
                i128::from(b[0] - a[0]) * i128::from(direction[1]) - i128::from(b[1] - a[1]) * i128::from(direction[0]);
            let got = across(point(a), point(b), point(direction));
            assert_eq!(got.partial_cmp(&0.0), Some(want.cmp(&0)), "{k}");
        }
        assert_eq!(across(DVec2::ONE, DVec2::ONE, DVec2::new(-0.3, 0.7)), 0.0);
        // Differences of coordinates that are rounded have no sign, or the other one.
        for tiny in [1e-20, -1e-20] {
            let (near, sign) = (DVec2::new(tiny, 0.0), tiny.partial_cmp(&0.0));
            assert_eq!(across(DVec2::ONE, near, DVec2::ONE).partial_cmp(&0.0), sign);
            assert_eq!((-across(near, DVec2::ONE, DVec2::ONE)).partial_cmp(&0.0), sign);
        }
    }

    #[test]
    fn rotating_the_points_keeps_the_sign() {
        let p = [DVec2::new(0.1, 0.1), DVec2::new(0.2, 0.2), DVec2::new(0.3, 0.3 + f64::EPSILON / 8.0)];
        let s = |i: usize| orient2d(p[i], p[(i + 1) % 3], p[(i + 2) % 3]).partial_cmp(&0.0);
        assert_eq!(s(0), s(1));
        assert_eq!(s(1), s(2));
    }
}
