//! Loops of a region and a grid -> winding numbers of the loops around each corner of the grid.
//!
//! Along a line the number changes by one at each crossing, so the number of one corner determines all others.

use super::grid::{Grid, LineCrossing};
use crate::math::boxes::around;
use crate::prepare::report::Tangled;
use crate::prepare::uv::polygon::winding_about;
use crate::prepare::uv::uv_loop::{Region, UvLoop};
use glam::DVec2;
use std::collections::BTreeMap;

/// Winding numbers of the region at the corners of the grid, and the crossings along its lines.
pub(crate) struct Windings {
    pub(crate) corners: BTreeMap<(usize, usize), i32>,
    /// By axis, and by line and strip: crossings in order of the running coordinate.
    pub(crate) crossings: [Vec<Vec<usize>>; 2],
}

impl Windings {
    pub(crate) fn of(region: &Region, grid: &Grid, all: &[LineCrossing]) -> Result<Self, Tangled> {
        let count = [grid.count(0), grid.count(1)];
        let mut crossings = [0, 1].map(|axis| vec![Vec::new(); (count[axis] + 1) * count[1 - axis]]);
        for (k, c) in all.iter().enumerate() {
            let line = if grid.wraps[c.axis] { c.line.rem_euclid(count[c.axis] as i64) } else { c.line };
            crossings[c.axis][line as usize * count[1 - c.axis] + c.strip].push(k);
        }
        for on_line in crossings.iter_mut().flatten() {
            on_line.sort_by(|&a, &b| all[a].at.total_cmp(&all[b].at));
        }
        let mut out = Self { corners: BTreeMap::new(), crossings };
        let base = match grid.wraps {
            [true, true] => region.base + out.at_first_corner(region, grid, all)?,
            // In a direction that does not wrap, the first corner lies beyond all loops.
            _ => region.base,
        };
        out.corners.insert((0, 0), base);
        let mut stack = vec![(0, 0)];
        while let Some(from) = stack.pop() {
            let here = out.corners[&from];
            for axis in 0..2 {
                let (line, k) = if axis == 0 { from } else { (from.1, from.0) };
                for strip in [Some(k), k.checked_sub(1), (k == 0).then(|| count[1 - axis] - 1)] {
                    let Some(strip) = strip.filter(|&s| s < count[1 - axis]) else { continue };
                    let ends = [0, 1].map(|end| grid.corner(axis, line, strip + end));
                    let on_line = &out.crossings[axis][line * count[1 - axis] + strip];
                    let rise: i32 = on_line.iter().map(|&c| all[c].step()).sum();
                    for (a, b, rise) in [(ends[0], ends[1], rise), (ends[1], ends[0], -rise)] {
                        if a != from {
                            continue;
                        }
                        let known = *out.corners.entry(b).or_insert_with(|| {
                            stack.push(b);
                            here + rise
                        });
                        if known != here + rise {
                            let [x, y] = [b.0, b.1];
                            return Err(Tangled { at: DVec2::new(grid.lines[0][x], grid.lines[1][y]) });
                        }
                    }
                }
            }
        }
        Ok(out)
    }

    /// Winding number of the loops around the first corner, for a region that wraps both ways. Counted at the middle of
    /// the longest stretch of the corner's line, then carried along the line.
    ///
    /// # Errors
    /// If the loops go round so often that counting takes too long.
    fn at_first_corner(&self, region: &Region, grid: &Grid, all: &[LineCrossing]) -> Result<i32, Tangled> {
        /// Maximum images of a loop times its points: the time that this takes. Real loops have a few images.
        const MAX_WORK: f64 = (1 << 26) as f64;
        let mut stops = vec![(grid.lines[1][0], 0)];
        let mut sum = 0;
        for on_line in &self.crossings[0][..grid.count(1)] {
            for &k in on_line {
                sum += all[k].step();
                stops.push((all[k].at, sum));
            }
        }
        stops.push((grid.lines[1][grid.count(1)], sum));
        let longest = stops.windows(2).max_by(|a, b| (a[1].0 - a[0].0).total_cmp(&(b[1].0 - b[0].0)));
        let Some([a, b]) = longest.map(|w| [w[0], w[1]]) else { return Ok(0) };
        let middle = DVec2::new(grid.lines[0][0], 0.5 * (a.0 + b.0));
        let period = DVec2::new(grid.period(0), grid.period(1));
        let around = |l: &UvLoop| {
            let polygon = l.polyline();
            let [low, high] = around(polygon.iter().copied());
            let [from, to] = [(low - middle) / period, (high - middle) / period].map(|p| (p.x.floor(), p.y.floor()));
            let work = (to.0 - from.0 + 2.0) * (to.1 - from.1 + 2.0) * polygon.len() as f64;
            if work.is_nan() || work > MAX_WORK {
                return Err(Tangled { at: middle });
            }
            let images = |from: f64, to: f64| from as i64..=to as i64 + 1;
            let winding = images(from.0, to.0)
                .flat_map(|i| images(from.1, to.1).map(move |j| DVec2::new(i as f64, j as f64)))
                .map(|by| winding_about(&polygon, middle + by * period))
                .sum::<i32>();
            Ok(winding)
        };
        Ok(region.loops.iter().map(around).sum::<Result<i32, Tangled>>()? - a.1)
    }
}
