//! Points in space -> their order along a Hilbert curve, on which neighbours are near each other.
//!
//! Index: J. Skilling, *Programming the Hilbert curve*, AIP Conf. Proc. 707 (2004), 381.

use super::boxes::around;
use glam::DVec3;

/// Bits per axis of a Hilbert index: three axes fill 63 of 64 bits.
const BITS: u32 = 21;

/// Indices of `points`, sorted along a Hilbert curve that fills the cube around them. Points that are not finite have a
/// place, too.
pub(crate) fn along_curve(points: impl Iterator<Item = DVec3> + Clone) -> Vec<usize> {
    let [low, high] = around(points.clone());
    let steps = f64::from((1_u32 << BITS) - 1);
    let side = (high - low).max_element();
    let scale = if side > 0.0 { steps / side } else { 0.0 };
    let of_point = |(index, point): (usize, DVec3)| {
        let cell = ((point - low) * scale).clamp(DVec3::ZERO, DVec3::splat(steps));
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to 0..2^21 above")]
        let axes = [cell.x as u32, cell.y as u32, cell.z as u32];
        (hilbert_index(axes, BITS), index)
    };
    let mut keyed: Vec<(u64, usize)> = points.enumerate().map(of_point).collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, index)| index).collect()
}

/// Position of a lattice cell along the Hilbert curve that fills a cube of `2^bits` cells a side.
///
/// `axes` are below `2^bits`, `1 ≤ bits ≤ 21`. Cells with consecutive indices share a side.
fn hilbert_index(mut axes: [u32; 3], bits: u32) -> u64 {
    // Undo, from the coarsest level down, the reflections and axis exchanges that the curve makes in each octant ...
    for level in (1..bits).rev() {
        let bit = 1_u32 << level;
        let finer = bit - 1;
        for k in 0..3 {
            if axes[k] & bit == 0 {
                let differing = (axes[0] ^ axes[k]) & finer;
                axes[0] ^= differing;
                axes[k] ^= differing;
            } else {
                axes[0] ^= finer;
            }
        }
    }
    // ... which leaves a Gray code whose digits are the axes' bits, level by level.
    axes[1] ^= axes[0];
    axes[2] ^= axes[1];
    let mut correction = 0;
    for level in 1..bits {
        if axes[2] & (1 << level) != 0 {
            correction ^= (1_u32 << level) - 1;
        }
    }
    (0..bits).rev().fold(0, |index, level| {
        axes.iter().fold(index, |index, axis| (index << 1) | u64::from(((axis ^ correction) >> level) & 1))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hilbert_curve_visits_every_cell_and_steps_to_neighbours() {
        for bits in 1..=4 {
            let side = 1_u32 << bits;
            let mut cells: Vec<(u64, [u32; 3])> = Vec::new();
            for x in 0..side {
                for y in 0..side {
                    cells.extend((0..side).map(|z| (hilbert_index([x, y, z], bits), [x, y, z])));
                }
            }
            cells.sort_unstable();
            for (expected, (index, _)) in cells.iter().enumerate() {
                assert_eq!(*index, expected as u64, "{bits} bits");
            }
            for pair in cells.windows(2) {
                let step: u32 = (0..3).map(|k| pair[0].1[k].abs_diff(pair[1].1[k])).sum();
                assert_eq!(step, 1, "{bits} bits: {pair:?}");
            }
        }
    }
}
