//! Flags of lattice edges, corners or cells -> words of 64, to read 64 flags of a row at a time.

/// Rows of bits.
#[derive(Default)]
pub(crate) struct Bits {
    words_per_row: usize,
    words: Vec<u64>,
}

impl Bits {
    pub(crate) fn reset(&mut self, columns: usize, rows: usize) {
        self.words_per_row = columns.div_ceil(64);
        self.words.clear();
        self.words.resize(self.words_per_row * rows, 0);
    }

    #[inline(always)]
    pub(crate) fn get(&self, column: usize, row: usize) -> bool {
        self.words[row * self.words_per_row + (column >> 6)] >> (column & 63) & 1 != 0
    }

    /// Sets the bit and returns its old value.
    #[inline(always)]
    pub(crate) fn set(&mut self, column: usize, row: usize) -> bool {
        let word = &mut self.words[row * self.words_per_row + (column >> 6)];
        let old = *word >> (column & 63) & 1 != 0;
        *word |= 1 << (column & 63);
        old
    }

    #[inline(always)]
    pub(crate) fn flip(&mut self, column: usize, row: usize) {
        self.words[row * self.words_per_row + (column >> 6)] ^= 1 << (column & 63);
    }

    /// Bits `64 * word ..` of the row.
    #[inline(always)]
    pub(crate) fn word(&self, word: usize, row: usize) -> u64 {
        self.words[row * self.words_per_row + word]
    }

    /// Bits `64 * word + 1 ..` of the row.
    #[inline(always)]
    pub(crate) fn word_after(&self, word: usize, row: usize) -> u64 {
        let carry = if word + 1 < self.words_per_row { self.word(word + 1, row) << 63 } else { 0 };
        self.word(word, row) >> 1 | carry
    }

    /// Sets each bit `c` of a row to the parity of the bits before `c` in that row of `of`, which must be as wide.
    pub(crate) fn set_to_parity_before(&mut self, row: usize, of: &Self) {
        let mut carry = 0u64;
        for word in 0..self.words_per_row {
            let mut parity = of.word(word, row);
            for shift in [1, 2, 4, 8, 16, 32] {
                parity ^= parity << shift;
            }
            parity ^= carry;
            // Bit i is the parity of bits 0..=i, all those before bit i + 1.
            self.words[row * self.words_per_row + word] = parity << 1 | carry & 1;
            carry = if parity >> 63 == 1 { u64::MAX } else { 0 };
        }
    }

    /// Number of set bits.
    pub(crate) fn count(&self) -> u64 {
        self.words.iter().map(|word| u64::from(word.count_ones())).sum()
    }

    pub(crate) fn words_per_row(&self) -> usize {
        self.words_per_row
    }
}
