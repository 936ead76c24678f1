//! Parameters at which something changes -> samples between them.

/// Where the `each` equal pieces of every stretch between neighbouring `stops` start, in their order.
pub(crate) fn equal_pieces(stops: &[f64], each: usize) -> impl Iterator<Item = f64> {
    let pieces = move |w: &[f64]| {
        let [a, b] = [w[0], w[1]];
        (0..each).map(move |k| a + (b - a) * k as f64 / each as f64)
    };
    stops.windows(2).flat_map(pieces)
}
