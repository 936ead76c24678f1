//! Regions of the unrolled parameter plane that loops bound.

use super::uv_curve::UvSample;
use super::uv_loop::UvLoop;
use glam::DVec2;

/// The part of the unrolled plane that a face covers.
#[derive(Clone, Debug)]
pub(crate) struct Region {
    pub(crate) loops: Vec<UvLoop>,
    /// Directions in which it spans a whole period and has to be cut open.
    pub(crate) wraps: [bool; 2],
    /// Its box. In a direction that wraps: one period, from any start.
    pub(crate) bounds: [(f64, f64); 2],
    /// Winding number where the loops add nothing: beyond the low end of the box in a direction that does not wrap.
    /// Loops of a region that wraps both ways are counted from it.
    pub(crate) base: i32,
    /// Direction and parameter of the border of the surface that bounds the region where no loop does. Not a pole.
    pub(crate) unbounded: Option<(usize, f64)>,
}

/// Exact bounding box of the loops' pcurves, including the extremes of every Hermite piece.
pub(crate) fn loops_box(loops: &[UvLoop]) -> [(f64, f64); 2] {
    let mut b = [(f64::INFINITY, f64::NEG_INFINITY); 2];
    let mut add = |p: DVec2| {
        for (range, x) in b.iter_mut().zip(p.to_array()) {
            *range = (if x < range.0 { x } else { range.0 }, if x > range.1 { x } else { range.1 });
        }
    };
    for samples in loops.iter().flat_map(|l| &l.pieces).map(|p| &p.samples) {
        samples.iter().for_each(|s| add(s.uv));
        for w in samples.windows(2) {
            for axis in 0..2 {
                UvSample::extremes(&w[0], &w[1], axis, |t| add(UvSample::interpolate(&w[0], &w[1], t)));
            }
        }
    }
    b
}
