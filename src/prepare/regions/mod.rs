//! A face's loops -> a region of its unrolled parameter plane.

pub(super) mod trace;
pub(super) mod unroll;
pub(super) mod lobes;
pub(super) mod mend;
