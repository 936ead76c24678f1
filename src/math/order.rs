//! The order of floats in few instructions.
//!
//! [`f64::max`] and [`f64::min`] take four each, for the sake of NaN; [`larger`] and [`smaller`] take one.

/// `a` if it is larger than `b`, else `b`. So NaN as `a` is ignored.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// `a` if it is smaller than `b`, else `b`. So NaN as `a` is ignored.
#[inline(always)]
pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// An integer in the order of [`f64::total_cmp`].
#[inline(always)]
pub(crate) fn ordered(x: f64) -> i64 {
    let bits = x.to_bits().cast_signed();
    bits ^ ((bits >> 63).cast_unsigned() >> 1).cast_signed()
}
