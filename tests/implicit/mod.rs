//! Intersections of two Bézier curves by implicitisation and generalised eigenvalues (Manocha & Demmel, "Algorithms
//! for intersecting parametric and algebraic curves", ACM TOG 13(1), 1994): an independent check of the crate's
//! subdivision.

use crate::common::elevated;
use faer::Mat;
use glam::{DMat2, DVec2, DVec3};

/// The point at `t` of a rational Bézier curve, from its control points `(w x, w y, w)`.
pub(crate) fn point(control: &[DVec3], t: f64) -> DVec2 {
    let mut rest = control.to_vec();
    while rest.len() > 1 {
        rest = rest.windows(2).map(|w| w[0].lerp(w[1], t)).collect();
    }
    rest[0].truncate() / rest[0].z
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |b, i| b * (n - i) as f64 / (i + 1) as f64)
}

/// Control points times binomials: coefficients by powers of t / (1 - t).
fn scaled(control: &[DVec3]) -> Vec<DVec3> {
    let n = control.len() - 1;
    control.iter().enumerate().map(|(i, &c)| c * binomial(n, i)).collect()
}

/// Bézout's matrix of two polynomials of degree n.
fn bezout(f: &[f64], g: &[f64]) -> Mat<f64> {
    let n = f.len() - 1;
    Mat::from_fn(n, n, |i, j| (0..=i.min(n - 1 - j)).map(|k| f[j + k + 1] * g[i - k] - f[i - k] * g[j + k + 1]).sum())
}

/// All intersections of two Bézier curves. `a` is implicitised as the determinant of Bézout's matrix at a point; with
/// `b` substituted, the roots are the generalised eigenvalues of a companion pencil.
pub(crate) fn by_eigenvalues(a: &[DVec3], b: &[DVec3]) -> Vec<[f64; 2]> {
    /// Minimum rows of a pencil: with fewer, faer 0.24 exceeds the buffer size it requested.
    const LEAST: usize = 4;
    if (a.len() - 1) * (b.len() - 1) < LEAST {
        return by_eigenvalues(a, &elevated(b));
    }
    let (n, m) = (a.len() - 1, b.len() - 1);
    let (of_a, of_b) = (scaled(a), scaled(b));
    let coordinate = |k: usize| of_a.iter().map(|c| c[k]).collect::<Vec<f64>>();
    let (x, y, w) = (coordinate(0), coordinate(1), coordinate(2));
    let (xy, wy, xw) = (bezout(&x, &y), bezout(&w, &y), bezout(&x, &w));
    let powers: Vec<Mat<f64>> = of_b
        .iter()
        .map(|c| Mat::from_fn(n, n, |i, j| c.z * xy[(i, j)] - c.x * wy[(i, j)] - c.y * xw[(i, j)]))
        .collect();
    let size = n * m;
    let shift = |i: usize, j: usize| f64::from(u8::from(j == i + n));
    let left =
        Mat::from_fn(
            size,
            size,
            |i, j| {
                if i < size - n { shift(i, j) } else { -powers[j / n][(i - (size - n), j % n)] }
            },
        );
    let right = Mat::from_fn(size, size, |i, j| {
        if i < size - n {
            f64::from(u8::from(i == j))
        } else if j >= size - n {
            powers[m][(i - (size - n), j - (size - n))]
        } else {
            0.0
        }
    });
    let Ok(pencil) = left.generalized_eigen(&right) else { return Vec::new() };
    let mut out: Vec<[f64; 2]> = Vec::new();
    for k in 0..size {
        let (alpha, beta) = (pencil.S_a().column_vector()[k], pencil.S_b().column_vector()[k]);
        let s = alpha / (alpha + beta);
        // Roots near each other lose half their digits.
        if !(s.im.abs() <= 1e-5 && (-1e-5..=1.0 + 1e-5).contains(&s.re)) {
            continue;
        }
        // The kernel of Bézout's matrix contains the powers of t / (1 - t).
        let vector = pencil.U().col(k);
        let t = if n == 1 {
            along(a, point(b, s.re))
        } else {
            // Blocks are multiplied by powers of s / (1 - s): the largest has the most digits.
            let size = |k: usize| (0..n).map(|i| vector[k * n + i].norm()).sum::<f64>();
            let block = (0..m).max_by(|&a, &b| size(a).total_cmp(&size(b))).unwrap();
            let entry = |i: usize| vector[block * n + i];
            let pair = (0..n - 1).max_by(|&a, &b| {
                let size = |i: usize| entry(i).norm() + entry(i + 1).norm();
                size(a).total_cmp(&size(b))
            });
            let i = pair.unwrap();
            (entry(i + 1) / (entry(i) + entry(i + 1))).re
        };
        if (-1e-3..=1.0 + 1e-3).contains(&t) {
            out.extend(polished(a, b, [t, s.re]));
        }
    }
    out
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
