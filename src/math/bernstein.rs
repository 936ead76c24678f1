//! Bernstein polynomials on [0, 1]: basis values, derivatives, restriction to a sub-interval, by de Casteljau's
//! triangle.

use super::lanes::{Lanes, Work, in_fours};
use smallvec::{SmallVec, smallvec};
use std::ops::{Add, Mul};

/// Degrees up to this are evaluated without allocating.
pub const STACK_DEGREE: usize = 25;

/// Calls `work` with zeroed room for three basis rows of `degree + 1` numbers, on the stack up to [`STACK_DEGREE`].
pub fn with_rows<R>(degree: usize, work: impl FnOnce(&mut [f64]) -> R) -> R {
    with_lanes::<3, 1, _>(degree, |rows| work(rows.as_flattened_mut()))
}

/// Calls `work` with zeroed room for `ROWS` basis rows of `degree + 1` values at `L` places, on the stack up to
/// [`STACK_DEGREE`].
#[inline(always)]
pub fn with_lanes<const ROWS: usize, const L: usize, R>(degree: usize, work: impl FnOnce(&mut [[f64; L]]) -> R) -> R {
    /// Most curves and surfaces have degree 3 or less: zeroing room for degree 25 would cost as much as their basis.
    const USUAL_DEGREE: usize = 3;
    let (mut small, mut large, mut heap);
    let rows: &mut [[[f64; L]; ROWS]] = if degree <= USUAL_DEGREE {
        small = [[[0.0; L]; ROWS]; USUAL_DEGREE + 1];
        &mut small[..=degree]
    } else if degree <= STACK_DEGREE {
        large = [[[0.0; L]; ROWS]; STACK_DEGREE + 1];
        &mut large[..=degree]
    } else {
        heap = vec![[[0.0; L]; ROWS]; degree + 1];
        &mut heap
    };
    work(rows.as_flattened_mut())
}

/// Writes the basis of degree `n.len() - 1` at `x` to `n`. Exactly a unit vector at 0 and 1.
#[inline]
pub fn basis(x: f64, n: &mut [f64]) {
    // Constant degrees, so that the compiler unrolls the loops.
    match n.len() {
        2 => fill_basis(x, &mut n[..2]),
        3 => fill_basis(x, &mut n[..3]),
        4 => fill_basis(x, &mut n[..4]),
        length if (LANES_FROM + 1..=STACK_DEGREE + 1).contains(&length) => raise_in_lanes(length - 1, x, n),
        _ => fill_basis(x, n),
    }
}

#[inline(always)]
fn fill_basis(x: f64, n: &mut [f64]) {
    let y = 1.0 - x;
    n[0] = 1.0;
    for k in 1..n.len() {
        let mut carry = 0.0;
        for value in &mut n[..k] {
            let old = *value;
            *value = carry + y * old;
            carry = x * old;
        }
        n[k] = carry;
    }
}

/// Writes the basis and its first derivatives at `L` places at once to `rows`, two rows of `degree + 1` numbers.
///
/// Bit-identical to [`basis_with_derivatives`] at each place.
#[inline(always)]
pub fn basis_and_slopes<const L: usize>(degree: usize, x: [f64; L], rows: &mut [[f64; L]]) {
    match degree {
        1 => rows.copy_from_slice(constant_basis_and_slopes::<2, L>(x).as_flattened()),
        2 => rows.copy_from_slice(constant_basis_and_slopes::<3, L>(x).as_flattened()),
        3 => rows.copy_from_slice(constant_basis_and_slopes::<4, L>(x).as_flattened()),
        _ => {
            let (n, slopes) = rows.split_at_mut(degree + 1);
            n[0] = [1.0; L];
            (1..degree).for_each(|k| raise(&x, k, n));
            differences(degree, n, slopes);
            raise(&x, degree, n);
        }
    }
}

/// The basis of degree `N - 1`, at most 3, at `L` places, bit-identical to [`basis`] at each.
#[inline(always)]
pub fn constant_basis<const N: usize, const L: usize>(x: [f64; L]) -> [[f64; L]; N] {
    let mut n = constant_basis_below(&x);
    raise(&x, N - 1, &mut n);
    n
}

/// [`basis_and_slopes`] of degree `N - 1`, at most 3.
#[inline(always)]
pub fn constant_basis_and_slopes<const N: usize, const L: usize>(x: [f64; L]) -> [[[f64; L]; N]; 2] {
    let mut n = constant_basis_below(&x);
    let mut slopes = [[0.0; L]; N];
    differences(N - 1, &n, &mut slopes);
    raise(&x, N - 1, &mut n);
    [n, slopes]
}

/// The basis of degree `N - 2`, and a last number without meaning.
#[inline(always)]
fn constant_basis_below<const N: usize, const L: usize>(x: &[f64; L]) -> [[f64; L]; N] {
    const { assert!(2 <= N && N <= 4) };
    let mut n = [[0.0; L]; N];
    n[0] = [1.0; L];
    // One after the other, because the compiler unrolls no loop over loops of different lengths.
    if N > 2 {
        raise(x, 1, &mut n);
    }
    if N > 3 {
        raise(x, 2, &mut n);
    }
    n
}

/// Turns the basis of degree `k - 1` in `n` into that of degree `k`.
#[inline(always)]
fn raise<const L: usize>(x: &[f64; L], k: usize, n: &mut [[f64; L]]) {
    let mut carry = [0.0; L];
    for n in &mut n[..k] {
        for l in 0..L {
            let old = n[l];
            n[l] = carry[l] + (1.0 - x[l]) * old;
            carry[l] = x[l] * old;
        }
    }
    n[k] = carry;
}

/// Derivatives of the basis of `degree`, by the basis of the degree below in `n`.
#[inline(always)]
fn differences<const L: usize>(degree: usize, n: &[[f64; L]], slopes: &mut [[f64; L]]) {
    let times = degree as f64;
    let mut before = [0.0; L];
    for (slope, n) in slopes[..degree].iter_mut().zip(n) {
        for l in 0..L {
            let first = times * n[l];
            slope[l] = before[l] - first;
            before[l] = first;
        }
    }
    slopes[degree] = before;
}

/// Writes the basis with its first and second derivatives to `rows`, three rows of `degree + 1` numbers.
#[inline]
pub fn basis_with_derivatives(degree: usize, x: f64, rows: &mut [f64]) {
    raise_piece::<3>(degree, x, 1.0, rows);
}

/// [`raise_all`] of a Bézier piece, all of whose terms have the same quotient.
#[inline(always)]
pub fn raise_piece<const ROWS: usize>(degree: usize, x: f64, width: f64, rows: &mut [f64]) {
    match degree {
        1 => raise_all::<ROWS>(1, rows, |_, _| (x, width)),
        2 => raise_all::<ROWS>(2, rows, |_, _| (x, width)),
        3 => raise_all::<ROWS>(3, rows, |_, _| (x, width)),
        LANES_FROM..=STACK_DEGREE => {
            let below = degree + 1 - ROWS;
            raise_in_lanes(below, x, rows);
            raise_from::<ROWS>(below + 1, degree, rows, |_, _| (x, width));
        }
        _ => raise_all::<ROWS>(degree, rows, |_, _| (x, width)),
    }
}

/// Raises the B-spline basis of a span from degree 0 to `degree`, with first (`ROWS` 2) and second (`ROWS` 3)
/// derivatives, in three rows of `degree + 1` numbers. `term(k, i)`: where the parameter is between the knots of term
/// `i` of degree `k`, as a share of their distance, and that distance.
///
/// A share by a true division is exactly 0 and 1 at the ends, so end points are exact to the last bit.
#[inline(always)]
pub fn raise_all<const ROWS: usize>(degree: usize, rows: &mut [f64], term: impl Fn(usize, usize) -> (f64, f64)) {
    rows[0] = 1.0;
    raise_from::<ROWS>(1, degree, rows, term);
}

/// The last steps of [`raise_all`], from degree `first` on. `rows` begins with the basis of the degree below.
#[inline(always)]
fn raise_from<const ROWS: usize>(
    first: usize,
    degree: usize,
    rows: &mut [f64],
    term: impl Fn(usize, usize) -> (f64, f64),
) {
    let (n, rest) = rows[..3 * (degree + 1)].split_at_mut(degree + 1);
    let (d1, d2) = rest.split_at_mut(degree + 1);
    for k in first..=degree {
        let (mut carry_n, mut carry_1, mut carry_2) = (0.0, 0.0, 0.0);
        let raise = k as f64;
        let terms = n[..k].iter_mut().zip(&mut d1[..k]).zip(&mut d2[..k]).enumerate();
        for (i, ((n, d1), d2)) in terms {
            let (x, width) = term(k, i);
            let old = *n;
            // Each degree replaces the derivatives of the one before, and only the last ones are wanted.
            if ROWS > 2 && k == degree {
                let second = raise * *d1 / width;
                *d2 = carry_2 - second;
                carry_2 = second;
            }
            if ROWS > 1 && k + ROWS > degree + 1 {
                let first = raise * old / width;
                *d1 = carry_1 - first;
                carry_1 = first;
            }
            *n = carry_n + (1.0 - x) * old;
            carry_n = x * old;
        }
        d2[k] = carry_2;
        d1[k] = carry_1;
        n[k] = carry_n;
    }
}

/// From this degree on, four terms of a basis are raised at once.
const LANES_FROM: usize = 8;

/// Writes the basis of `degree`, at most [`STACK_DEGREE`], to `n`, with the bits of [`basis`].
fn raise_in_lanes(degree: usize, x: f64, n: &mut [f64]) {
    let n = &mut n[..=degree];
    if degree < 12 { in_fours(Raise::<3> { degree, x, n }) } else { in_fours(Raise::<7> { degree, x, n }) }
}

/// Work of [`raise_in_lanes`], for up to `4 · STEPS` terms. Lane `l` has `STEPS` terms from `STEPS · l` on: so the next
/// term is in the same lane, but for one in `STEPS`.
struct Raise<'a, const STEPS: usize> {
    degree: usize,
    x: f64,
    n: &'a mut [f64],
}

impl<const STEPS: usize> Work for Raise<'_, STEPS> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes<4>>(self, zero: F) {
        let mut terms = [zero; STEPS];
        terms[0] = zero.load(&[1.0, 0.0, 0.0, 0.0]);
        let (x, y) = (zero.splat(self.x), zero.splat(1.0 - self.x));
        for _ in 0..self.degree {
            let [a, b, c, _] = terms[STEPS - 1].to_array();
            let mut carry = x * zero.load(&[0.0, a, b, c]);
            for term in &mut terms {
                let old = *term;
                *term = carry + y * old;
                carry = x * old;
            }
        }
        let terms = terms.map(F::to_array);
        for (lane, n) in self.n.chunks_mut(STEPS).enumerate() {
            n.iter_mut().zip(&terms).for_each(|(n, term)| *n = term[lane]);
        }
    }
}

/// The sum of points, each times its factor.
#[inline]
pub(crate) fn dot<T: Copy + Default + Add<Output = T> + Mul<f64, Output = T>>(factors: &[f64], points: &[T]) -> T {
    factors.iter().zip(points).fold(T::default(), |sum, (&f, &p)| sum + p * f)
}

/// The binomial coefficients `C(n, 0..=n)`.
#[must_use]
pub fn binomials(n: usize) -> SmallVec<[f64; 8]> {
    let mut row = smallvec![1.0; n + 1];
    for k in 1..n {
        row[k] = row[k - 1] * (n + 1 - k) as f64 / k as f64;
    }
    row
}

/// Replaces coefficients over [0, 1] by those of the same polynomial over `[x0, x1]`.
///
/// An end that stays (0 or 1) keeps its coefficient bit for bit.
pub fn restrict<T: Copy + Add<Output = T> + Mul<f64, Output = T>>(c: &mut [T], x0: f64, x1: f64) {
    restrict_rows(c, 1, x0, x1);
}

/// [`restrict`] of `width` polynomials at once. `c`: first the first coefficients of all, then their second ones, and
/// so on.
#[inline(always)]
pub fn restrict_rows<T: Copy + Add<Output = T> + Mul<f64, Output = T>>(c: &mut [T], width: usize, x0: f64, x1: f64) {
    let n = c.len() / width;
    if x1 < 1.0 {
        // The left part of the split at x1. Each pass fixes one more coefficient from the left.
        for pass in 1..n {
            for j in (pass..n).rev() {
                let (left, right) = c.split_at_mut(j * width);
                for (b, a) in right[..width].iter_mut().zip(&left[(j - 1) * width..]) {
                    *b = *a * (1.0 - x1) + *b * x1;
                }
            }
        }
    }
    if x0 > 0.0 {
        let x = if x1 > 0.0 { (x0 / x1).min(1.0) } else { 0.0 };
        for pass in 1..n {
            for j in 0..n - pass {
                let (left, right) = c.split_at_mut((j + 1) * width);
                for (a, b) in left[j * width..].iter_mut().zip(&right[..width]) {
                    *a = *a * (1.0 - x) + *b * x;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::random::SplitMix;

    #[test]
    fn bases_raised_in_lanes_have_the_same_bits() {
        let bits = |n: &[f64]| n.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        for degree in 0..=STACK_DEGREE {
            for x in [0.0, 1e-300, 0.1, 0.5, 0.7, 1.0 - f64::EPSILON, 1.0, 1.25] {
                let [mut plain, mut lanes] = [(); 2].map(|()| vec![f64::NAN; degree + 1]);
                fill_basis(x, &mut plain);
                raise_in_lanes(degree, x, &mut lanes);
                assert_eq!(bits(&lanes), bits(&plain), "degree {degree} at {x}");
            }
        }
    }

    #[test]
    fn rows_are_restricted_as_each_of_their_polynomials() {
        let mut draw = SplitMix(3);
        for (width, n) in [(1, 4), (3, 2), (4, 4), (5, 7)] {
            let rows: Vec<f64> = (0..width * n).map(|_| draw.range(-1.0, 1.0)).collect();
            for (x0, x1) in [(0.0, 1.0), (0.0, 0.25), (0.25, 0.5), (0.75, 1.0)] {
                let mut together = rows.clone();
                restrict_rows(&mut together, width, x0, x1);
                for k in 0..width {
                    let of = |rows: &[f64]| -> Vec<f64> { rows[k..].iter().step_by(width).copied().collect() };
                    let mut single = of(&rows);
                    restrict(&mut single, x0, x1);
                    assert_eq!(of(&together), single, "{width} {n} {x0} {x1}");
                }
            }
        }
    }
}
