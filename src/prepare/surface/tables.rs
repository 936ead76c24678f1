//! Tables of bounds over the sub-boxes of a surface and the strips of a curve.

use super::decompose::BezierPatches;
use crate::math::lanes::{larger, smaller};
use glam::{DVec3, DVec4};
use smallvec::SmallVec;

/// A box in space, aligned to the axes of the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingBox {
    /// Lower corner.
    pub low: DVec3,
    /// Upper corner.
    pub high: DVec3,
}

impl Default for BoundingBox {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl BoundingBox {
    /// The box that contains no point.
    pub const EMPTY: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    /// The box of a Bézier net. It contains the curve or surface, because all weights are positive.
    #[must_use]
    pub fn of_net(net: &[DVec4]) -> Self {
        let points = net.iter().map(|c| c.truncate() / c.w);
        points.fold(Self::EMPTY, |all, p| all.with(&Self { low: p, high: p }))
    }

    /// The smallest box that contains both.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        let axis = |k: usize| (smaller(other.low[k], self.low[k]), larger(other.high[k], self.high[k]));
        let [x, y, z] = [0, 1, 2].map(axis);
        Self { low: DVec3::new(x.0, y.0, z.0), high: DVec3::new(x.1, y.1, z.1) }
    }

    /// For each sub-box of a table of `size` that cuts all patches evenly: the box of the whole patch that contains it.
    #[must_use]
    pub(crate) fn of_pieces(patches: &BezierPatches, size: [usize; 2]) -> Vec<Self> {
        let (count_u, count_v) = patches.counts();
        let pieces: Vec<Self> =
            (0..count_u * count_v).map(|k| Self::of_net(patches.patch(k / count_v, k % count_v))).collect();
        let piece = |i: usize, j: usize| pieces[i * count_u / size[0] * count_v + j * count_v / size[1]];
        (0..size[0]).flat_map(|i| (0..size[1]).map(move |j| (i, j))).map(|(i, j)| piece(i, j)).collect()
    }
}

/// Upper bounds on a second derivative over a sub-box.
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bend {
    /// Bounds its length.
    pub norm: f64,
    /// Bounds its part along the surface's normal, which lifts the surface off its triangles.
    pub lift: f64,
    /// Bounds its part in the tangent plane, which moves points along the surface.
    pub slide: f64,
}

impl Bend {
    /// The larger of each pair of bounds.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        let most = |of: fn(&Self) -> f64| larger(of(&other), of(&self));
        Self { norm: most(|bend| bend.norm), lift: most(|bend| bend.lift), slide: most(|bend| bend.slide) }
    }

    /// All bounds times `factor`.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self { norm: self.norm * factor, lift: self.lift * factor, slide: self.slide * factor }
    }

    /// Bounds the part along any direction whose angle to the normal has at most the sine `share`.
    #[must_use]
    pub fn along(&self, share: f64) -> f64 {
        self.norm.min(self.lift + share * self.slide)
    }
}

/// Upper bounds over a sub-box of a surface, by the NURBS parameters.
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BoxBounds {
    /// `S_uu`. Exactly 0 where u-lines are straight and of constant speed; `lift` is exactly 0 where the surface is
    /// flat.
    pub uu: Bend,
    /// `S_uv`. Exactly 0 on planes and extrusions; `lift` is exactly 0 where the surface is flat.
    pub uv: Bend,
    /// `S_vv`. Exactly 0 where v-lines are straight and of constant speed; `lift` is exactly 0 where the surface is
    /// flat.
    pub vv: Bend,
    /// sup ‖S_u‖.
    pub u: f64,
    /// sup ‖S_v‖.
    pub v: f64,
    /// How far the unit normal turns at most along a u-line of the box, radians.
    pub turn_u: f64,
    /// How far the unit normal turns at most along a v-line of the box, radians.
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
    /// Bounding box of each sub-box in space, in the order of `cells`.
    pub places: Vec<BoundingBox>,
}

/// Upper bounds over a strip of a curve, by its parameter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StripBounds {
    /// sup ‖C'‖.
    pub first: f64,
    /// sup ‖C''‖; exactly 0 if the curve is straight, whatever its speed.
    pub second: f64,
    /// How far the tangent turns at most, radians.
    pub turn: f64,
    /// Its bounding box in space.
    pub place: BoundingBox,
}

/// Bounds of a curve, strip by strip. Those of a line, which has one strip, need no allocation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurveBounds {
    /// Borders of strips, increasing; all segment borders are among them.
    pub breaks: SmallVec<[f64; 2]>,
    /// One per strip.
    pub strips: SmallVec<[StripBounds; 1]>,
}
