//! What is asked of a part, and where a box of it is -> the tolerance that holds in the box.

use super::sight::Sight;
use super::tolerance::Tolerance;
use crate::prepare::internals::BoundingBox;

/// Boxes whose tolerances are at least this share of each other count as even: lines differ by a twentieth at most.
const ALIKE: f64 = 0.9;

/// What is asked of one tile or edge, box by box.
#[derive(Clone, Debug)]
pub(crate) struct Need {
    /// The strictest tolerance within any of its boxes.
    pub(crate) tolerance: Tolerance,
    /// What share that is of each box's own: at most 1, and 0 for a box that is not seen.
    pub(crate) shares: Vec<f64>,
}

impl Default for Need {
    /// Of nothing.
    fn default() -> Self {
        let tolerance = Tolerance { chord: f64::INFINITY, angle: f64::INFINITY, max_edge: None };
        Self { tolerance, shares: Vec::new() }
    }
}

impl Need {
    /// Whether all boxes have the same tolerance.
    pub(crate) fn is_even(&self) -> bool {
        self.shares.iter().all(|&share| share == 1.0)
    }
}

/// What a part must keep: one tolerance everywhere, or in each box what its instances show of it.
pub(crate) struct Asked {
    /// In the part's own millimetres; for a part that is seen, what it would be where a millimetre is a pixel.
    tolerance: Tolerance,
    /// One per instance; none for a tolerance that holds everywhere.
    seen: Vec<Sight>,
    radius: f64,
    /// Whether the numbers asked for were replaced by ones that can be kept.
    pub(crate) unusable: bool,
}

impl Asked {
    /// One tolerance for a part of this radius.
    pub(crate) fn everywhere(tolerance: &Tolerance, radius: f64) -> Self {
        let usable = tolerance.usable(radius);
        Self { unusable: usable != *tolerance, tolerance: usable, seen: Vec::new(), radius }
    }

    /// For a part that is seen: `per_pixel` is what it must keep where one of its millimetres is a pixel.
    pub(crate) fn seen(per_pixel: &Tolerance, seen: Vec<Sight>, radius: f64) -> Self {
        let known = |x: f64| x > 0.0;
        let unusable = !(known(per_pixel.chord) && known(per_pixel.angle) && per_pixel.max_edge.is_none_or(known));
        Self { tolerance: *per_pixel, seen, radius, unusable }
    }

    /// Whether edges may only be so long.
    pub(crate) fn limits_length(&self) -> bool {
        self.tolerance.max_edge.is_some()
    }

    /// What is asked of a tile or an edge with these boxes, into `need`.
    pub(crate) fn over<'a>(&self, places: impl ExactSizeIterator<Item = &'a BoundingBox>, need: &mut Need) {
        let Need { tolerance, shares } = need;
        shares.clear();
        if self.seen.is_empty() {
            *tolerance = self.tolerance;
            shares.resize(places.len(), 1.0);
            return;
        }
        let nearest = |place: &BoundingBox| self.seen.iter().map(|s| s.pixels_per_length(place)).fold(0.0, f64::max);
        shares.extend(places.map(nearest));
        let most = shares.iter().copied().fold(0.0, f64::max);
        let least = shares.iter().copied().fold(most, f64::min);
        if least >= ALIKE * most {
            shares.fill(1.0);
        } else {
            shares.iter_mut().for_each(|p| *p /= most);
        }
        let Tolerance { chord, angle, max_edge } = self.tolerance;
        let seen = Tolerance { chord: chord / most, angle, max_edge: max_edge.map(|m| m / most) };
        *tolerance = seen.usable(self.radius);
    }
}

/// Whether one of two neighbours in rows of `columns` is more than twice the other.
pub(crate) fn is_steep(of: &[f64], columns: usize) -> bool {
    let apart = |a: f64, b: f64| a > 2.0 * b || b > 2.0 * a;
    let beside = of.chunks(columns).any(|row| row.windows(2).any(|w| apart(w[0], w[1])));
    beside || of.iter().zip(&of[columns.min(of.len())..]).any(|(&a, &b)| apart(a, b))
}

/// Numbers in rows of `columns`, each replaced by the largest that is at most `reach` rows and columns away, into `out`.
pub(crate) fn dilate(of: &[f64], columns: usize, reach: usize, out: &mut Vec<f64>) {
    out.clear();
    if reach == 0 {
        out.extend_from_slice(of);
        return;
    }
    let largest = |of: &[f64]| of.iter().copied().fold(0.0, f64::max);
    if columns == 1 {
        out.extend((0..of.len()).map(|k| largest(&of[k.saturating_sub(reach)..(k + reach + 1).min(of.len())])));
        return;
    }
    let rows = of.len() / columns;
    let window = |k: usize, n: usize| k.saturating_sub(reach)..(k + reach + 1).min(n);
    let most = |i: usize, j: usize| {
        let near = window(i, rows).flat_map(|i| &of[i * columns..][window(j, columns)]);
        near.copied().fold(0.0, f64::max)
    };
    out.extend((0..of.len()).map(|k| most(k / columns, k % columns)));
}

/// The most strips that lie under a gap between two of `lines`.
pub(crate) fn most_touched(breaks: &[f64], lines: &[f64]) -> usize {
    let strips = breaks.len() - 1;
    let mut first = 0;
    let mut most = 1;
    for gap in lines.windows(2) {
        while first + 1 < strips && breaks[first + 1] <= gap[0] {
            first += 1;
        }
        let under = breaks[first + 1..strips].iter().take_while(|&&b| b < gap[1]).count();
        most = most.max(1 + under);
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_number_nearby_wins() {
        let of = [0.1, 0.2, 0.3, 0.9, 0.1, 0.1];
        let dilated = |of: &[f64], columns, reach| {
            let mut out = vec![7.0];
            dilate(of, columns, reach, &mut out);
            out
        };
        assert_eq!(dilated(&of, 3, 0), of);
        assert_eq!(dilated(&of, 3, 1), [0.9, 0.9, 0.3, 0.9, 0.9, 0.3]);
        assert_eq!(dilated(&of, 1, 1), [0.2, 0.3, 0.9, 0.9, 0.9, 0.1]);
        assert_eq!(dilated(&of, 3, 9), [0.9; 6]);
    }

    #[test]
    fn neighbours_are_compared_along_and_across_rows() {
        assert!(!is_steep(&[0.5, 1.0, 0.5, 0.5, 0.5, 0.5], 3) && !is_steep(&[0.0; 4], 2) && !is_steep(&[1.0], 1));
        assert!(is_steep(&[0.4, 1.0, 0.5, 0.5, 0.5, 0.5], 3));
        assert!(is_steep(&[0.5, 1.0, 0.5, 0.5, 0.5, 0.2], 3));
        assert!(!is_steep(&[0.5, 0.5, 1.0, 0.3, 0.6, 0.7], 3) && is_steep(&[0.1, 0.3, 0.3, 0.4], 1));
    }

    #[test]
    fn gaps_are_counted_by_the_strips_under_them() {
        let breaks = [0.0, 1.0, 2.0, 3.0, 4.0];
        assert_eq!(most_touched(&breaks, &[0.0, 1.0, 2.0, 2.5, 4.0]), 2);
        assert_eq!(most_touched(&breaks, &[0.0, 0.5, 3.5, 4.0]), 4);
        assert_eq!(most_touched(&breaks, &[1.0, 1.5, 2.0]), 1);
        // Edges may be longer than their table, by rounding.
        assert_eq!(most_touched(&breaks, &[-1e-9, 4.0 + 1e-9]), 4);
    }
}
