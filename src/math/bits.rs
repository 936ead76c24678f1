//! Words -> their bits that are set; points -> bits to look them up by.

use glam::DVec3;

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

#[cfg(test)]
mod tests {
    use super::*;

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
