//! Buffers that are kept for thousands of tiles.

/// Copies into as much memory as that takes, or at most twice as much: there are thousands of tiles.
pub(crate) fn keep<T: Copy>(to: &mut Vec<T>, from: &[T]) {
    to.clear();
    to.shrink_to(2 * from.len());
    to.reserve_exact(from.len());
    to.extend_from_slice(from);
}
