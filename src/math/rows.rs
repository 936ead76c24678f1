//! Rows of lists that go together.

/// Removes the rows with these numbers, which ascend, and returns them. Later rows move up. Numbers beyond the end are
/// skipped. Cost: one pass from the first of them.
pub(crate) fn take_rows<T>(list: &mut Vec<T>, rows: &[usize]) -> Vec<T> {
    let Some(&first) = rows.first().filter(|first| **first < list.len()) else { return Vec::new() };
    let (mut row, mut left) = (first, rows.iter().peekable());
    let goes = |_: &mut T| {
        row += 1;
        left.next_if(|gone| **gone + 1 == row).is_some()
    };
    list.extract_if(first.., goes).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_go_in_one_pass() {
        for (rows, gone, left) in [
            (&[][..], &[][..], &[10, 11, 12, 13][..]),
            (&[0], &[10], &[11, 12, 13]),
            (&[1, 2], &[11, 12], &[10, 13]),
            (&[0, 3, 7], &[10, 13], &[11, 12]),
            (&[4], &[], &[10, 11, 12, 13]),
        ] {
            let mut list = vec![10, 11, 12, 13];
            assert_eq!(take_rows(&mut list, rows), gone);
            assert_eq!(list, left);
        }
    }
}
