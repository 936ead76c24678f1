//! Unknowns of one or two numbers -> their values: by halving an interval, by Newton's method, by least squares;
//! stretches -> their equal pieces.

use glam::{DVec2, DVec3};

/// Halves the interval `steps` times, and keeps the half that contains the change from numbers for which `is_before`
/// holds to others. Stops early if no number lies between the ends.
///
/// `is_before` is taken to hold at the first end and not at the second. These may be in either order.
pub(crate) fn bisected([mut low, mut high]: [f64; 2], steps: usize, is_before: impl Fn(f64) -> bool) -> [f64; 2] {
    for _ in 0..steps {
        let middle = 0.5 * (low + high);
        if middle == low || middle == high {
            break;
        }
        if is_before(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    [low, high]
}

/// The parameter from `low` to `high` of the curve point nearest to a given one, by Newton's method from `start`. Stops
/// at steps of at most `still`. Without convergence it may be further away than `start`.
///
/// `orders`: of half the squared distance at a parameter, the first and the second derivative, and the second one
/// without the curve's bend, which is the squared speed. Where the second derivative leads uphill, the squared speed
/// still descends (Gauss–Newton).
pub(crate) fn foot(start: f64, (low, high): (f64, f64), still: f64, orders: impl Fn(f64) -> [f64; 3]) -> f64 {
    const STEPS: usize = 24;
    let mut t = start;
    for _ in 0..STEPS {
        let [slope, bend, square] = orders(t);
        let step = slope / if bend > 0.0 { bend } else { square };
        if !step.is_finite() {
            break;
        }
        let next = (t - step).clamp(low, high);
        let is_done = (next - t).abs() <= still;
        t = next;
        if is_done {
            break;
        }
    }
    t
}

/// The solution of `[[e, f], [f, g]] x = y`. `None` unless the matrix is positive definite with a determinant above
/// `least` times `e * g`.
pub(crate) fn solve_symmetric([e, f, g]: [f64; 3], y: DVec2, least: f64) -> Option<DVec2> {
    let det = e * g - f * f;
    let is_definite = e > 0.0 && g > 0.0 && det > least * e * g;
    is_definite.then(|| DVec2::new((g * y.x - f * y.y) / det, (e * y.y - f * y.x) / det))
}

/// The step (du, dv) that brings `a du + b dv` nearest to `r`. Where `a` and `b` are parallel, a step along the longer
/// one.
pub(crate) fn least_squares(a: DVec3, b: DVec3, r: DVec3) -> DVec2 {
    let (e, f, g) = (a.length_squared(), a.dot(b), b.length_squared());
    let along = DVec2::new(r.dot(a), r.dot(b));
    solve_symmetric([e, f, g], along, 1e-14).unwrap_or_else(|| {
        if e >= g && e > 0.0 {
            DVec2::new(along.x / e, 0.0)
        } else if g > 0.0 {
            DVec2::new(0.0, along.y / g)
        } else {
            DVec2::ZERO
        }
    })
}

/// Where the `each` equal pieces of every stretch between neighbouring `stops` start, in their order.
pub(crate) fn equal_pieces(stops: &[f64], each: usize) -> impl Iterator<Item = f64> {
    let pieces = move |w: &[f64]| {
        let [a, b] = [w[0], w[1]];
        (0..each).map(move |k| a + (b - a) * k as f64 / each as f64)
    };
    stops.windows(2).flat_map(pieces)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_foot_is_the_nearest_point_and_stays_in_the_range() {
        // Half the squared distance of (1, y) from the parabola (t, t²).
        let orders = |y: f64| {
            move |t: f64| {
                let (speed, square) = (2.0 * t, 1.0 + 4.0 * t * t);
                [(t - 1.0) + (t * t - y) * speed, square + 2.0 * (t * t - y), square]
            }
        };
        assert!((foot(0.2, (-2.0, 2.0), 1e-12, orders(1.0)) - 1.0).abs() < 1e-12);
        // Uphill by the second derivative at the start.
        assert!(orders(9.0)(0.0)[1] < 0.0);
        let t = foot(0.0, (-4.0, 4.0), 1e-12, orders(9.0));
        assert!(orders(9.0)(t)[0].abs() < 1e-9 && t > 2.9, "{t}");
        assert_eq!(foot(0.2, (0.0, 0.5), 1e-12, orders(1.0)), 0.5);
    }

    #[test]
    fn least_squares_solve_what_can_be_solved() {
        let (a, b) = (DVec3::new(2.0, 0.0, 1.0), DVec3::new(0.0, 3.0, 1.0));
        let normal = a.cross(b);
        assert!((least_squares(a, b, 2.0 * a - b + normal) - DVec2::new(2.0, -1.0)).length() < 1e-14);
        assert_eq!(least_squares(a, 0.5 * a, a), DVec2::X);
        assert_eq!(least_squares(0.5 * a, a, a), DVec2::Y);
        assert_eq!(least_squares(DVec3::ZERO, DVec3::ZERO, a), DVec2::ZERO);
        assert_eq!(solve_symmetric([1.0, 2.0, 1.0], DVec2::ONE, 0.0), None);
    }

    #[test]
    fn stretches_are_cut_evenly() {
        assert!(equal_pieces(&[0.0, 1.0, 3.0], 2).eq([0.0, 0.5, 1.0, 2.0]));
    }

    #[test]
    fn intervals_in_either_order_close_in_on_the_change() {
        let [low, high] = bisected([0.0, 1.0], 60, |x| x * x < 0.5);
        assert!(low * low < 0.5 && high * high >= 0.5 && high == low.next_up(), "{low} {high}");
        let [high, low] = bisected([1.0, 0.0], 60, |x| x * x >= 0.5);
        assert!(low * low < 0.5 && high * high >= 0.5 && high == low.next_up(), "{low} {high}");
        assert_eq!(bisected([0.0, 1.0], 2, |x| x < 0.3), [0.25, 0.5]);
        assert_eq!(bisected([1.0, 1.0], 60, |_| true), [1.0, 1.0]);
    }
}
