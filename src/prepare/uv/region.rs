//! What loops in the unrolled parameter plane keep.

use super::uv_curve::UvSample;
use super::uv_loop::UvLoop;
use glam::DVec2;

/// The kept part of the unrolled plane.
#[derive(Clone, Debug)]
pub(crate) struct Region {
    pub(crate) loops: Vec<UvLoop>,
    /// Directions in which it goes all the way round and must be cut open.
    pub(crate) wraps: [bool; 2],
    /// Its box; in a direction that wraps, one period wherever it starts.
    pub(crate) bounds: [(f64, f64); 2],
    /// Winding number of the region where the loops do not wind: beyond the low end of the box in a direction that does
    /// not wrap, and what the loops of a region that wraps both ways are counted from.
    pub(crate) base: i32,
    /// Direction and parameter of the surface's own end, not a pole, that bounds it because no loop does.
    pub(crate) unbounded: Option<(usize, f64)>,
}

/// Box of the loops' pcurves, with the extremes of every Hermite piece.
pub(crate) fn loops_box(loops: &[UvLoop]) -> [(f64, f64); 2] {
    let mut b = [(f64::INFINITY, f64::NEG_INFINITY); 2];
    let mut add = |p: DVec2| {
        for (range, x) in b.iter_mut().zip(p.to_array()) {
            *range = (range.0.min(x), range.1.max(x));
        }
    };
    for w in loops.iter().flat_map(|l| &l.pieces).flat_map(|p| p.samples.windows(2)) {
        add(w[0].uv);
        add(w[1].uv);
        for axis in 0..2 {
            for t in UvSample::extremes(&w[0], &w[1], axis) {
                add(UvSample::between(&w[0], &w[1], t));
            }
        }
    }
    b
}
