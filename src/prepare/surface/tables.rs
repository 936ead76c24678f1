//! Tables of bounds over the sub-boxes of a surface and the strips of a curve.

use super::decompose::BezierPatches;
use glam::{DVec3, DVec4};

/// A box in space, by the axes of the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingBox {
    /// Lower corner.
    pub low: DVec3,
    /// Upper corner.
    pub high: DVec3,
}

impl BoundingBox {
    /// Holds nothing.
    pub const EMPTY: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    /// Of a Bézier net, and so of what it makes: weights are positive.
    #[must_use]
    pub fn of_net(net: &[DVec4]) -> Self {
        let points = net.iter().map(|c| c.truncate() / c.w);
        points.fold(Self::EMPTY, |all, p| all.with(&Self { low: p, high: p }))
    }

    /// The box of both.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Per sub-box the box of the whole Bézier piece that it is a part of, where pieces are cut evenly into tables of `size`.
    #[must_use]
    pub(crate) fn of_pieces(patches: &BezierPatches, size: [usize; 2]) -> Vec<Self> {
        let (count_u, count_v) = patches.counts();
        let pieces: Vec<Self> =
            (0..count_u * count_v).map(|k| Self::of_net(patches.patch(k / count_v, k % count_v))).collect();
        let piece = |i: usize, j: usize| pieces[i * count_u / size[0] * count_v + j * count_v / size[1]];
        (0..size[0]).flat_map(|i| (0..size[1]).map(move |j| (i, j))).map(|(i, j)| piece(i, j)).collect()
    }
}

/// Upper bounds of a second derivative over a sub-box.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bend {
    /// Of its length.
    pub norm: f64,
    /// Of its part along the surface's normal, which lifts the surface off its triangles.
    pub lift: f64,
    /// Of its part in the tangent plane, which moves points along the surface.
    pub slide: f64,
}

impl Bend {
    /// The larger of each bound.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        let Self { norm, lift, slide } = self;
        Self { norm: norm.max(other.norm), lift: lift.max(other.lift), slide: slide.max(other.slide) }
    }

    /// All bounds times `factor`.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self { norm: self.norm * factor, lift: self.lift * factor, slide: self.slide * factor }
    }

    /// The part along any direction whose angle to the normal has at most the sine `share`.
    #[must_use]
    pub fn along(&self, share: f64) -> f64 {
        self.norm.min(self.lift + share * self.slide)
    }
}

/// What a sub-box of a surface can do at most, by the NURBS parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BoxBounds {
    /// `S_uu`; exactly 0 where the surface is straight and even in u, its lift where it is flat.
    pub uu: Bend,
    /// `S_uv`; exactly 0 on planes and extrusions, its lift where the surface is flat.
    pub uv: Bend,
    /// `S_vv`; exactly 0 where the surface is straight and even in v, its lift where it is flat.
    pub vv: Bend,
    /// sup ‖S_u‖.
    pub u: f64,
    /// sup ‖S_v‖.
    pub v: f64,
    /// The most that the unit normal turns along a u-line of the box, radians.
    pub turn_u: f64,
    /// The same along v-lines.
    pub turn_v: f64,
}

/// Bounds of a surface, sub-box by sub-box.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceBounds {
    /// Borders of sub-boxes in u, increasing; all patch borders are among them.
    pub breaks_u: Vec<f64>,
    /// Borders of sub-boxes in v.
    pub breaks_v: Vec<f64>,
    /// Box (i, j) at `i * (breaks_v.len() - 1) + j`.
    pub cells: Vec<BoxBounds>,
    /// Where each sub-box is in space, in the same order.
    pub places: Vec<BoundingBox>,
}

/// What a strip of a curve can do at most, by its parameter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StripBounds {
    /// sup ‖C'‖.
    pub first: f64,
    /// sup ‖C''‖; exactly 0 where the curve is straight and even.
    pub second: f64,
    /// How far the tangent turns, radians.
    pub turn: f64,
}

/// Bounds of a curve, strip by strip.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurveBounds {
    /// Borders of strips, increasing; all segment borders are among them.
    pub breaks: Vec<f64>,
    /// One per strip.
    pub strips: Vec<StripBounds>,
    /// Where each strip is in space.
    pub places: Vec<BoundingBox>,
}
