//! Intersections of two Bézier curves by implicitisation and generalised eigenvalues (Manocha & Demmel, "Algorithms
//! for intersecting parametric and algebraic curves", ACM TOG 13(1), 1994): an independent check of the crate's
//! subdivision.

use glam::{DMat2, DVec2, DVec3};
use nalgebra::{Complex, DMatrix, Schur, SymmetricEigen};

/// The point at `t` of a rational Bézier curve, from its control points `(w x, w y, w)`.
pub(crate) fn point(control: &[DVec3], t: f64) -> DVec2 {
    let p = homogeneous_point(control, t);
    p.truncate() / p.z
}

/// The same point as `(w x, w y, w)`.
fn homogeneous_point(control: &[DVec3], t: f64) -> DVec3 {
    let mut rest = control.to_vec();
    while rest.len() > 1 {
        rest = rest.windows(2).map(|w| w[0].lerp(w[1], t)).collect();
    }
    rest[0]
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |b, i| b * (n - i) as f64 / (i + 1) as f64)
}

/// Control points times binomials: coefficients by powers of t / (1 - t).
fn scaled(control: &[DVec3]) -> Vec<DVec3> {
    let n = control.len() - 1;
    control.iter().enumerate().map(|(i, &c)| c * binomial(n, i)).collect()
}

/// Bézout's matrix of two polynomials of degree n. It is symmetric.
fn bezout(f: &[f64], g: &[f64]) -> DMatrix<f64> {
    let n = f.len() - 1;
    let entry =
        |i: usize, j: usize| (0..=i.min(n - 1 - j)).map(|k| f[j + k + 1] * g[i - k] - f[i - k] * g[j + k + 1]).sum();
    DMatrix::from_fn(n, n, entry)
}

/// A Bézier curve as the points at which Bézout's matrix is singular. The matrix is linear in the point.
struct Implicit {
    xy: DMatrix<f64>,
    wy: DMatrix<f64>,
    xw: DMatrix<f64>,
}

impl Implicit {
    fn new(curve: &[DVec3]) -> Self {
        let scaled = scaled(curve);
        let coordinate = |k: usize| scaled.iter().map(|c| c[k]).collect::<Vec<f64>>();
        let (x, y, w) = (coordinate(0), coordinate(1), coordinate(2));
        Self { xy: bezout(&x, &y), wy: bezout(&w, &y), xw: bezout(&x, &w) }
    }

    /// The matrix at `(w x, w y, w)`. Its kernel at a point of the curve contains the powers of t / (1 - t).
    fn at(&self, p: DVec3) -> DMatrix<f64> {
        &self.xy * p.z - &self.wy * p.x - &self.xw * p.y
    }
}

/// The s at which the matrix polynomial with these coefficients, by powers of s / (1 - s), is singular: the generalised
/// eigenvalues of a companion pencil. Panics if it is singular everywhere.
fn singular(coefficients: &[DMatrix<f64>]) -> Vec<Complex<f64>> {
    /// Values of s / (1 - s) far from those in question, and not special, so that hardly a root is near. With nalgebra
    /// 0.35, the iteration for the eigenvalues of a few matrices in a million goes round in circles.
    const SHIFTS: [f64; 3] = [-0.7, -0.6, -0.8];
    let (n, m) = (coefficients[0].nrows(), coefficients.len() - 1);
    let (size, last) = (n * m, n * (m - 1));
    let mut left = DMatrix::zeros(size, size);
    left.view_mut((0, n), (last, last)).fill_with_identity();
    for (k, c) in coefficients[..m].iter().enumerate() {
        left.view_mut((last, k * n), (n, n)).copy_from(&-c);
    }
    let mut right = DMatrix::identity(size, size);
    right.view_mut((last, last), (n, n)).copy_from(&coefficients[m]);
    let by_shift = |shift: f64| {
        // One matrix with the eigenvalues 1 / (s / (1 - s) - shift), which are finite at both ends.
        let matrix = (&left - &right * shift).lu().solve(&right)?;
        let eigenvalues = Schur::try_new(matrix, f64::EPSILON, 30 * size)?.complex_eigenvalues();
        Some(eigenvalues.iter().map(|v| (v * shift + 1.0) / (v * (shift + 1.0) + 1.0)).collect())
    };
    SHIFTS.into_iter().find_map(by_shift).expect("curves without a component in common")
}

/// All intersections of two Bézier curves. `a` is implicitised as the determinant of Bézout's matrix at a point; with
/// `b` substituted, the roots are the generalised eigenvalues of a companion pencil.
pub(crate) fn by_eigenvalues(a: &[DVec3], b: &[DVec3]) -> Vec<[f64; 2]> {
    let implicit = Implicit::new(a);
    let coefficients: Vec<DMatrix<f64>> = scaled(b).into_iter().map(|c| implicit.at(c)).collect();
    let mut out = Vec::new();
    for s in singular(&coefficients) {
        // Roots near each other lose half their digits.
        if !(s.im.abs() <= 1e-5 && (-1e-5..=1.0 + 1e-5).contains(&s.re)) {
            continue;
        }
        let p = homogeneous_point(b, s.re);
        let t = if a.len() == 2 { along(a, p.truncate() / p.z) } else { parameter(&implicit, p) };
        if (-1e-3..=1.0 + 1e-3).contains(&t) {
            out.extend(polished(a, b, [t, s.re]));
        }
    }
    out
}

/// Parameter of the point `(w x, w y, w)` of a curve of degree 2 or more.
fn parameter(curve: &Implicit, p: DVec3) -> f64 {
    let matrix = curve.at(p);
    let most = 30 * matrix.nrows();
    let eigen = SymmetricEigen::try_new(matrix, f64::EPSILON, most).expect("converges");
    let kernel = eigen.eigenvectors.column(eigen.eigenvalues.iamin());
    let size = |i: usize| kernel[i].abs() + kernel[i + 1].abs();
    // The largest two adjacent powers have the most digits.
    let i = (0..kernel.len() - 1).max_by(|&i, &j| size(i).total_cmp(&size(j))).unwrap();
    kernel[i + 1] / (kernel[i] + kernel[i + 1])
}

/// Parameter of the point of a straight line nearest to `p`.
fn along(line: &[DVec3], p: DVec2) -> f64 {
    let [from, to] = [point(line, 0.0), point(line, 1.0)];
    (p - from).dot(to - from) / (to - from).length_squared()
}

/// Refines an intersection to the last digits by Newton's method; `None` if the curves only come near each other.
fn polished(a: &[DVec3], b: &[DVec3], mut at: [f64; 2]) -> Option<[f64; 2]> {
    const STEP: f64 = 1e-6;
    let tangent = |c: &[DVec3], t: f64| (point(c, t + STEP) - point(c, t - STEP)) / (2.0 * STEP);
    for _ in 0..20 {
        let rate = DMat2::from_cols(tangent(a, at[0]), -tangent(b, at[1]));
        let step = rate.inverse() * (point(b, at[1]) - point(a, at[0]));
        if !step.is_finite() || step.abs().max_element() > 0.1 {
            break;
        }
        at = [at[0] + step.x, at[1] + step.y];
        if step.abs().max_element() <= 1e-15 {
            break;
        }
    }
    let is_inside = at.iter().all(|t| (-1e-9..=1.0 + 1e-9).contains(t));
    let at = at.map(|t| t.clamp(0.0, 1.0));
    (is_inside && point(a, at[0]).distance(point(b, at[1])) <= 1e-9).then_some(at)
}
