//! A tile's loops -> polygons, and lattices of sample parameters, for estimates that need a few per cent, not exact
//! signs.

use super::uv_curve::{SAME_SHARE, UvCurve, UvSample};
use super::uv_loop::winding_about;
use crate::prepare::surface::decompose::BezierPatches;
use glam::DVec2;

/// Appends points of a pcurve over `range`, without the last: twice as many as it has pieces, at most `most`; one for
/// an isoparametric line and, if `flat`, for any straight line.
pub(crate) fn points_along(uv: &UvCurve, range: (f64, f64), most: usize, flat: bool, out: &mut Vec<DVec2>) {
    let (from, to) = range;
    let n = match uv {
        UvCurve::Hermite(samples) if flat && is_straight(samples) => 1,
        UvCurve::Hermite(samples) => (2 * (samples.len() - 1)).min(most),
        UvCurve::Iso { .. } => 1,
    };
    let mut hint = 0;
    out.extend((0..n).map(|k| uv.point(from + (to - from) * k as f64 / n as f64, &mut hint)));
}

/// Whether there is one piece, and its slopes have the direction of its chord, to [`SAME_SHARE`].
fn is_straight(samples: &[UvSample]) -> bool {
    let [a, b] = samples else { return false };
    let chord = b.uv - a.uv;
    chord != DVec2::ZERO && [a.d, b.d].iter().all(|d| chord.perp_dot(*d).abs() <= SAME_SHARE * chord.dot(*d))
}

/// The area of closed polygons, each point as often as they wind around it.
pub(crate) fn area(loops: &[Vec<DVec2>]) -> f64 {
    let fan = |l: &[DVec2]| l.windows(2).map(|w| (w[0] - l[0]).perp_dot(w[1] - l[0])).sum::<f64>();
    loops.iter().map(|l| 0.5 * fan(l)).sum()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_count_as_often_as_loops_wind_around_them() {
        let square = |side: f64| vec![DVec2::ZERO, DVec2::X * side, DVec2::splat(side), DVec2::Y * side];
        let hole: Vec<DVec2> = square(2.0).into_iter().rev().map(|p| p + DVec2::ONE).collect();
        for (loops, expected) in [
            (vec![square(4.0), hole], 12.0),
            (vec![square(4.0), square(2.0)], 20.0),
            (vec![Vec::new(), vec![DVec2::ONE]], 0.0),
        ] {
            assert_eq!(area(&loops), expected);
        }
    }
}
