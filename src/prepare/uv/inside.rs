//! A tile's loops -> polygons, and lattices of sample parameters, for estimates that need a few per cent, not exact
//! signs.

use super::uv_curve::UvCurve;
use super::uv_loop::winding_about;
use crate::prepare::surface::decompose::BezierPatches;
use glam::DVec2;

/// Appends points of a pcurve from `from` to `to`, without the last: twice as many as it has pieces, at most `most`;
/// one for an isoparametric line.
pub(crate) fn points_along(uv: &UvCurve, from: f64, to: f64, most: usize, out: &mut Vec<DVec2>) {
    let n = match uv {
        UvCurve::Hermite(samples) => (2 * (samples.len() - 1)).min(most),
        UvCurve::Iso { .. } => 1,
    };
    let mut hint = 0;
    out.extend((0..n).map(|k| uv.point(from + (to - from) * k as f64 / n as f64, &mut hint)));
}

/// The region of a tile, as polygons.
pub(crate) struct TileRegion<'a> {
    pub(crate) patches: &'a BezierPatches,
    pub(crate) min: DVec2,
    pub(crate) max: DVec2,
    pub(crate) loops: Vec<Vec<DVec2>>,
}

impl TileRegion<'_> {
    /// The total winding number of the loops about `uv`. Meshes cover a point as often, reversed where it is negative.
    pub(crate) fn winding(&self, uv: DVec2) -> i32 {
        self.loops.iter().map(|l| winding_about(l, uv)).sum()
    }

    /// Area in (u,v), each point as often as the loops wind around it.
    pub(crate) fn area(&self) -> f64 {
        let fan = |l: &[DVec2]| l.windows(2).map(|w| (w[0] - l[0]).perp_dot(w[1] - l[0])).sum::<f64>();
        self.loops.iter().map(|l| 0.5 * fan(l)).sum()
    }

    /// Cell size and cell centres of an even lattice over the tile with `per_piece` cells per Bézier piece and
    /// direction (at most 16 pieces count). Centres may lie outside the loops.
    pub(crate) fn lattice(&self, per_piece: usize) -> (DVec2, impl Iterator<Item = DVec2> + '_) {
        let count = |breaks: &[f64], a: f64, b: f64| {
            per_piece * breaks.windows(2).filter(|w| w[1] > a && w[0] < b).count().clamp(1, 16)
        };
        let nu = count(&self.patches.breaks_u, self.min.x, self.max.x);
        let nv = count(&self.patches.breaks_v, self.min.y, self.max.y);
        let step = (self.max - self.min) / DVec2::new(nu as f64, nv as f64);
        let middles = (0..nu)
            .flat_map(move |i| (0..nv).map(move |j| self.min + step * DVec2::new(i as f64 + 0.5, j as f64 + 0.5)));
        (step, middles)
    }
}
