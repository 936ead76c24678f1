//! A name and a number -> a sequence of random numbers.
#![allow(dead_code, reason = "not every test uses all of it")]

/// Xorshift64*: good enough to choose places, and the same on all platforms.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(name: &str, number: u64) -> Self {
        // FNV-1a: stable across compiler releases.
        let bytes = name.bytes().chain(number.to_le_bytes());
        let hash =
            bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
        Self(hash | 1)
    }

    /// A number below `n`, which must not be 0.
    pub(crate) fn below(&mut self, n: u64) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 1) % n
    }

    /// A number from -1 to 1, uniform.
    pub(crate) fn signed(&mut self) -> f64 {
        const STEPS: u64 = 1 << 53;
        2.0 * self.below(STEPS) as f64 / STEPS as f64 - 1.0
    }

    /// A random element.
    pub(crate) fn choose<'a, T>(&mut self, all: &'a [T]) -> Option<&'a T> {
        all.get(self.below(all.len().max(1) as u64) as usize)
    }
}
