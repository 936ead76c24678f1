//! Bytes -> numbers, and lists that print as source code.

use arbitrary::{Result, Unstructured};
use std::fmt;
use std::ops::Deref;

/// A vector that prints as `list([…])`.
#[derive(Clone, PartialEq, Default)]
pub(crate) struct List<T>(pub(crate) Vec<T>);

/// A list of these items.
pub(crate) fn list<T, const N: usize>(items: [T; N]) -> List<T> {
    List(items.into())
}

impl<T: fmt::Debug> fmt::Debug for List<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "list({:?})", self.0)
    }
}

impl<T> Deref for List<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        &self.0
    }
}

impl<T> FromIterator<T> for List<T> {
    fn from_iter<I: IntoIterator<Item = T>>(items: I) -> Self {
        Self(items.into_iter().collect())
    }
}

/// An integer below `n`.
pub(crate) fn below(u: &mut Unstructured<'_>, n: usize) -> Result<usize> {
    u.int_in_range(0..=n - 1)
}

/// One of 256 evenly spaced numbers in `low..=high`: takes few bytes and prints short.
pub(crate) fn range(u: &mut Unstructured<'_>, low: f64, high: f64) -> Result<f64> {
    let share = f64::from(u.arbitrary::<u8>()?) / 255.0;
    Ok(round(low + (high - low) * share))
}

/// A number in `low..=high`, uniform in its logarithm. Both ends are positive.
pub(crate) fn log_range(u: &mut Unstructured<'_>, low: f64, high: f64) -> Result<f64> {
    let share = f64::from(u.arbitrary::<u8>()?) / 255.0;
    Ok(round(low * (high / low).powf(share)))
}

/// `x` to four significant digits.
pub(crate) fn round(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}

/// `count` results of `item`.
pub(crate) fn repeat<T>(count: usize, item: impl FnMut() -> Result<T>) -> Result<List<T>> {
    std::iter::repeat_with(item).take(count).collect::<Result<Vec<T>>>().map(List)
}
