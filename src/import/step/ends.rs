//! Two vertices of an edge -> whether the edge covers a whole closed curve.

use super::units::Units;
use glam::DVec3;

/// Rounding error of a coordinate, as a share of the numbers from which it is computed.
pub(super) const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Ends of an `EDGE_CURVE`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends {
    pub(super) start: DVec3,
    pub(super) end: DVec3,
    pub(super) whole: Whole,
}

/// When an edge on a closed curve covers the whole curve, rather than the short arc between its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Whole {
    /// Never: two different vertices bound an arc, however short.
    Never,
    /// If its two vertices coincide up to rounding. The loop runs along a seam and back, so the edge between must be a
    /// full turn.
    BesideSeam,
    /// If its two vertices are within the file's tolerance. A line between them is the rest of the loop.
    BesideLine,
    /// If its two vertices are one corner, or as close as ends of closed curves of its size. The edge is the whole loop,
    /// and a short arc encloses nothing.
    Alone,
    /// Always: start and end are one vertex.
    OneVertex,
}

impl Whole {
    /// Whether an edge with this chord covers a whole curve. Ends of closed curves of its size are one within `near`.
    pub(super) fn holds(self, chord: f64, near: f64, rounding: f64, units: Units) -> bool {
        match self {
            Self::Never => false,
            Self::BesideSeam => chord <= rounding,
            Self::BesideLine => chord <= units.tolerance.max(rounding),
            Self::Alone => chord <= units.corner().max(near).max(rounding),
            Self::OneVertex => true,
        }
    }
}

/// Distance up to which rounding may move two points apart, if they are computed from numbers up to `size`.
pub(super) fn rounding([a, b]: [DVec3; 2], size: f64) -> f64 {
    ROUNDING * (a.abs().max(b.abs()).max_element() + size)
}
