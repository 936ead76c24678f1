//! A condition that holds up to some number -> that number, by halving an interval.

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

#[cfg(test)]
mod tests {
    use super::*;

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
