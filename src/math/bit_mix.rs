//! Numbers of vertices, parts and tiles -> hashes, for hot maps.

use std::hash::Hasher;

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
