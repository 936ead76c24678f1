//! Boxes in the plane and in space.

use glam::{DVec2, DVec3};
use std::ops::{Add, Index};

/// Lower and upper corner.
pub(crate) type Aabb = [DVec3; 2];

/// A point of which each coordinate has a minimum and a maximum.
pub(crate) trait Corner: Copy + Add<Output = Self> + Index<usize, Output = f64> {
    /// Number of coordinates.
    const AXES: usize;
    /// The box that contains no point.
    const NOTHING: [Self; 2];
    /// The smallest box that contains both another and `self`.
    fn added(self, to: [Self; 2]) -> [Self; 2];
    /// Whether two boxes overlap or touch.
    fn meet(a: &[Self; 2], b: &[Self; 2]) -> bool;
}

macro_rules! corner {
    ($($point:ident: $axes:literal),*) => {
        $(impl Corner for $point {
            const AXES: usize = $axes;
            const NOTHING: [Self; 2] = [Self::INFINITY, Self::NEG_INFINITY];
            fn added(self, [low, high]: [Self; 2]) -> [Self; 2] {
                [low.min(self), high.max(self)]
            }
            fn meet(a: &[Self; 2], b: &[Self; 2]) -> bool {
                !(a[0].cmpgt(b[1]).any() || a[1].cmplt(b[0]).any())
            }
        })*
    };
}
corner!(DVec2: 2, DVec3: 3);

/// Lower and upper corner of the smallest box around points; `[+∞, -∞]` without any.
pub(crate) fn around<P: Corner>(points: impl IntoIterator<Item = P>) -> [P; 2] {
    points.into_iter().fold(P::NOTHING, |all, p| p.added(all))
}

/// The squared distance of a point from a box; 0 within.
pub(crate) fn distance_squared([low, high]: Aabb, p: DVec3) -> f64 {
    p.distance_squared(p.clamp(low, high))
}
