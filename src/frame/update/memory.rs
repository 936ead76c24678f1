//! Buffers that are cached for thousands of tiles.

/// Copies `from` into `to`, and shrinks its capacity to twice the length: thousands of tiles have such buffers.
pub(crate) fn keep<T: Copy>(to: &mut Vec<T>, from: &[T]) {
    to.clear();
    to.shrink_to(2 * from.len());
    to.reserve_exact(from.len());
    to.extend_from_slice(from);
}
