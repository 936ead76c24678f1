//! Lists that are sorted by part.

use trimtess::model::PartId;

/// The rows of a part, in a list that is sorted by part.
pub(crate) fn rows_of<T>(sorted: &[T], part: PartId, of: impl Fn(&T) -> PartId) -> &[T] {
    let from = &sorted[sorted.partition_point(|row| of(row) < part)..];
    &from[..from.partition_point(|row| of(row) == part)]
}
