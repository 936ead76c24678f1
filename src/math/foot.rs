//! Derivatives of a squared distance -> the parameter at which it is least, by Newton's method.

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
