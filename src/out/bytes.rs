//! Bytes of a written file to numbers.

use glam::{DVec3, Vec3};
use std::io;

/// A triangle in a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct FileTriangle {
    /// The face's number across all instances; 0 in formats that do not store it.
    pub(super) face: u32,
    /// Millimetres, world coordinates, +Z up, counter-clockwise seen from outside.
    pub(super) corners: [DVec3; 3],
}

pub(super) fn bad(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, format!("the file reads back as {what}"))
}

/// The `N` bytes at `at`.
pub(super) fn bytes_at<const N: usize>(bytes: &[u8], at: usize) -> io::Result<[u8; N]> {
    let found = bytes.get(at..).and_then(|rest| rest.first_chunk::<N>());
    found.copied().ok_or_else(|| bad("shorter than its header says"))
}

/// Three single-precision numbers at `at`.
pub(super) fn vector(bytes: &[u8], at: usize) -> io::Result<Vec3> {
    let number = |axis: usize| bytes_at(bytes, at + 4 * axis).map(f32::from_le_bytes);
    Ok(Vec3::new(number(0)?, number(1)?, number(2)?))
}
