//! A file that is made in pieces, and then written: its caller's threads and request to stop, and progress.

use super::save_error::SaveError;
use crate::control::{Call, Counter, Stage};
use std::io::{self, Write};

/// The bytes of a file, in pieces.
pub(super) type Pieces = Vec<Vec<u8>>;

/// Bytes between two looks whether the caller asks to stop. Disks take a few milliseconds for them.
const WRITTEN_AT_ONCE: usize = 1 << 20;

/// A call that makes a file and writes it. Progress counts the tiles of the file twice: when their bytes are made, and
/// when they are written.
pub(super) struct Making<'a> {
    pub(super) call: Call<'a>,
    tiles: u64,
    counter: Counter,
}

impl<'a> Making<'a> {
    /// Starts a file that has so many tiles.
    pub(super) fn start(call: Call<'a>, tiles: usize) -> Self {
        let tiles = tiles as u64;
        Self { call, tiles, counter: Counter::start(call.control, Stage::Write, 2 * tiles) }
    }

    /// An error once the caller asked to stop.
    pub(super) fn goes_on(&self) -> Result<(), SaveError> {
        self.call.goes_on().ok_or(SaveError::Cancelled)
    }

    /// Counts tiles whose bytes are made.
    pub(super) fn made(&self, tiles: usize) {
        self.counter.advance_by(tiles as u64);
    }

    /// Writes the pieces, which are all, unless cancelled, and frees them on all threads.
    pub(super) fn write(&self, pieces: Pieces, file: &mut (impl Write + ?Sized)) -> io::Result<()> {
        let all: u64 = pieces.iter().map(|piece| piece.len() as u64).sum();
        let (mut bytes, mut tiles) = (0, 0);
        let mut write = |some: &[u8]| {
            file.write_all(some)?;
            bytes += some.len() as u64;
            let share = u128::from(self.tiles) * u128::from(bytes) / u128::from(all);
            self.counter.advance_by(share as u64 - tiles);
            tiles = share as u64;
            Ok(())
        };
        let chunks = pieces.iter().flat_map(|piece| piece.chunks(WRITTEN_AT_ONCE));
        let written = chunks.take_while(|_| !self.call.is_cancelled()).try_for_each(&mut write);
        self.call.discard(pieces);
        written
    }
}

/// Collects the bytes of a text, and refuses more once the caller asked to stop.
#[cfg(feature = "glb")]
pub(super) struct Text<'a> {
    pub(super) bytes: Vec<u8>,
    pub(super) call: Call<'a>,
}

#[cfg(feature = "glb")]
impl Write for Text<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.write_all(bytes).map(|()| bytes.len())
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        /// Texts are written word by word.
        const LOOK_EVERY: usize = 1 << 12;
        let before = self.bytes.len() / LOOK_EVERY;
        self.bytes.extend_from_slice(bytes);
        if self.bytes.len() / LOOK_EVERY > before && self.call.is_cancelled() {
            return Err(io::Error::other("cancelled"));
        }
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
