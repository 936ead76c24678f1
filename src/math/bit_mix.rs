//! Coordinate bits and indices -> hashes, for hot maps whose keys no attacker chooses.

use std::hash::Hasher;

/// Multiplicative hash for coordinate bits and vertex indices. The low bits of coordinates are often zero, so the high
/// half is folded down at the end.
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
