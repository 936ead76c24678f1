//! Words, floats and points by their bits: which are set, hashes of them, and an integer in the order of floats.

use glam::DVec3;
use std::hash::Hasher;

/// The numbers of the bits that are set, ascending.
#[inline]
pub(crate) fn ones(word: impl Into<u64>) -> impl Iterator<Item = usize> {
    let mut word = word.into();
    std::iter::from_fn(move || {
        let bit = (word != 0).then(|| word.trailing_zeros())?;
        word &= word - 1;
        Some(bit as usize)
    })
}

/// The bits of a point's coordinates, the same for equal points: -0.0 counts as 0.0.
#[inline]
pub(crate) fn of_point(point: DVec3) -> [u64; 3] {
    (point + DVec3::ZERO).to_array().map(f64::to_bits) // -0.0 + 0.0 = 0.0
}

/// Multiplicative hash for numbers that count from 0. The high half, which depends on all bits, is folded down at the
/// end.
#[derive(Default)]
pub(crate) struct BitMix(u64);

impl Hasher for BitMix {
    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 32)
    }

    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.write_u64(u64::from_le_bytes(word));
        }
    }

    fn write_u32(&mut self, word: u32) {
        self.write_u64(word.into());
    }

    fn write_u64(&mut self, word: u64) {
        self.0 = (self.0.rotate_left(23) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
}

/// An integer in the order of [`f64::total_cmp`].
#[inline(always)]
pub(crate) fn ordered(x: f64) -> i64 {
    let bits = x.to_bits().cast_signed();
    bits ^ ((bits >> 63).cast_unsigned() >> 1).cast_signed()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ordered_integers_compare_as_floats_do() {
        let floats = [f64::NEG_INFINITY, -1.0, -f64::MIN_POSITIVE, -0.0, 0.0, f64::MIN_POSITIVE, 1.0, f64::INFINITY];
        assert!(floats.map(ordered).is_sorted_by(|a, b| a < b));
        assert!(ordered(f64::NAN) > ordered(f64::INFINITY) && ordered(-f64::NAN) < ordered(f64::NEG_INFINITY));
    }

    #[test]
    fn ones_are_the_bits_that_are_set() {
        for word in [0, 1, 0b1010, 1 << 63, u64::MAX, 0x8000_0001_0000_0001] {
            assert!(ones(word).eq((0..64).filter(|bit| word >> bit & 1 == 1)), "{word:b}");
        }
        assert!(ones(u32::MAX).eq(0..32));
    }

    #[test]
    fn equal_points_have_the_same_bits() {
        assert_eq!(of_point(DVec3::new(-0.0, 1.0, -0.0)), of_point(DVec3::new(0.0, 1.0, 0.0)));
        assert_ne!(of_point(DVec3::X), of_point(DVec3::NEG_X));
    }
}
