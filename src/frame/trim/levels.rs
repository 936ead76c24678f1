//! Loops in a plane -> nearly Delaunay triangles with the same boundary, from coarse to fine; or a refusal.
//!
//! Method: every other vertex is left out where loops are smooth, again and again, while they have many. Where little is
//! smooth, corners that point out of the region are left out too: without the tips of its teeth a loop may be smooth. The
//! sweep triangulates the coarsest level. Then the vertices return, level by level. Each comes between its neighbours,
//! and edges around it are flipped: few, because older vertices lie on all sides of it. If vertices came in the order of
//! a line, or all at once, each would take flips in proportion to the number of all.
//!
//! Coarse loops may cross where the loops do not. Nothing has to foresee that. The boundary of the triangles is the
//! loops all the same. A triangle that cannot be made positive is found at once, and a finer level is swept. Cost: that
//! of the sweep for a share of the vertices, and about 1.4 flips and three tests of edges for each of the others.

use super::sweep::{NotSimple, Sweep};
use glam::DVec2;

/// Loops with fewer vertices in all are swept.
const FEW: usize = 12;

/// Loops with fewer vertices keep them all.
const LEAST: usize = 6;

/// Tangent of the largest turn at a vertex that is left out: circles become hexagons or squares.
const SMOOTH: f64 = 1.2;

/// Levels with fewer vertices keep their teeth.
const MANY: usize = 64;

/// A level has at most 7/8 of the vertices of the one before, or it is not worth its pass.
const SHARE: usize = 8;

/// Levels that are given up when the sweep refuses one: the next has up to four times the vertices.
const AT_ONCE: usize = 2;

/// Work space of [`Levels::triangulate`].
#[derive(Default)]
pub(crate) struct Levels {
    /// The vertices of all levels, the finest level first, loop by loop.
    ids: Vec<u32>,
    /// By level and loop, where its vertices begin among those of the level.
    starts: Vec<u32>,
    /// By level, the vertices that the next one lacks, each between its neighbours.
    ears: Vec<[u32; 3]>,
    levels: Vec<Level>,
    /// By vertex, the side of the boundary that starts from it.
    sides: Vec<u32>,
    sweep: Sweep,
}

/// Where a level begins in each list.
#[derive(Clone, Copy)]
struct Level {
    ids: usize,
    starts: usize,
    ears: usize,
}

impl Levels {
    /// Triangulates the region to the left of loops of vertices: loop k has the indices from `starts[k]` to the next
    /// start, or to the end.
    pub(crate) fn triangulate(
        &mut self,
        points: &[DVec2],
        starts: &[u32],
    ) -> Result<impl ExactSizeIterator<Item = [u32; 3]> + '_, NotSimple> {
        self.thin_all(points, starts);
        while let Err(finer) = self.triangulate_from_last(points) {
            if self.levels.len() == 1 {
                return Err(NotSimple);
            }
            self.truncate(finer);
        }
        Ok(self.sweep.mesh().triangles())
    }

    /// Makes all levels.
    fn thin_all(&mut self, points: &[DVec2], starts: &[u32]) {
        self.ids.clear();
        self.starts.clear();
        self.ears.clear();
        self.levels.clear();
        self.ids.extend(0..points.len() as u32);
        self.starts.extend_from_slice(starts);
        let mut level = Level { ids: 0, starts: 0, ears: 0 };
        self.levels.push(level);
        let mut with_tips = false;
        loop {
            let mut next = Level { ids: self.ids.len(), starts: self.starts.len(), ears: 0 };
            let count = next.ids - level.ids;
            if count < FEW {
                return;
            }
            for k in level.starts..next.starts {
                let from = level.ids + self.starts[k] as usize;
                let to = if k + 1 < next.starts { level.ids + self.starts[k + 1] as usize } else { next.ids };
                self.starts.push((self.ids.len() - next.ids) as u32);
                self.thin(points, (from, to), with_tips);
            }
            next.ears = self.ears.len();
            self.levels.push(next);
            if SHARE * (next.ears - level.ears) >= count {
                (level, with_tips) = (next, false);
                continue;
            }
            self.truncate(self.levels.len() - 1);
            if with_tips || count < MANY {
                return;
            }
            with_tips = true;
        }
    }

    /// Appends to the level in the making what it keeps of a loop: no two neighbours are left out. `with_tips`: also
    /// leaves out corners that point out of the region, whose triangles add to it when they return.
    #[inline(always)]
    fn thin(&mut self, points: &[DVec2], (from, to): (usize, usize), with_tips: bool) {
        if to - from < LEAST {
            self.ids.extend_from_within(from..to);
            return;
        }
        let first = self.ids[from];
        self.ids.push(first);
        let (mut before, mut at) = (first, from + 1);
        while at < to {
            let v = self.ids[at];
            let after = if at + 1 < to { self.ids[at + 1] } else { first };
            let [a, b, c] = [before, v, after].map(|v| points[v as usize]);
            let (ahead, aside) = ((b - a).dot(c - b), (b - a).perp_dot(c - b));
            let is_left_out = ahead > 0.0 && aside.abs() <= SMOOTH * ahead || with_tips && aside > 0.0;
            if is_left_out {
                self.ears.push([before, v, after]);
                at += 1;
            }
            before = if is_left_out { after } else { v };
            if at < to {
                self.ids.push(before);
            }
            at += 1;
        }
    }

    /// Keeps the first levels.
    fn truncate(&mut self, count: usize) {
        let Level { ids, starts, .. } = self.levels[count];
        self.ids.truncate(ids);
        self.starts.truncate(starts);
        self.levels.truncate(count);
        self.ears.truncate(self.levels[count - 1].ears);
    }

    /// Sweeps the last level and adds the vertices of the others. If that fails, returns how many levels to keep.
    fn triangulate_from_last(&mut self, points: &[DVec2]) -> Result<(), usize> {
        let Self { ids, starts, ears, levels, sides, sweep } = self;
        let last = levels.len() - 1;
        let Level { ids: first_id, starts: first_start, .. } = levels[last];
        let swept = sweep.triangulate(points, &ids[first_id..], &starts[first_start..]);
        let mesh = swept.map_err(|NotSimple| levels.len().saturating_sub(AT_ONCE).max(1))?;
        if last == 0 {
            return Ok(());
        }
        sides.resize(points.len(), 0);
        mesh.list_border(sides);
        let mut first = mesh.len();
        let of_level = |l: usize| levels[l].ears..levels[l + 1].ears;
        for l in (0..last).rev() {
            mesh.add_ears(&ears[of_level(l)], sides);
        }
        for l in (0..last).rev() {
            let next = first + of_level(l).len();
            if !mesh.insert_ears(first..next, points) {
                return Err(l + 1);
            }
            first = next;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::trim::cdt::{self, AtCrossings, Segment};
    use crate::frame::trim::sweep::{SWEEPS, prove, rounds};
    use crate::sequence::random::SplitMix;

    fn proven(points: &[DVec2], starts: &[u32]) -> Result<Vec<[u32; 3]>, NotSimple> {
        let triangles: Vec<_> = Levels::default().triangulate(points, starts)?.collect();
        prove(points, starts, &triangles);
        Ok(triangles)
    }

    /// The deciles of the triangles' smallest angles, and the length of all sides.
    fn shapes(points: &[DVec2], triangles: &[[u32; 3]]) -> (Vec<f64>, f64) {
        let mut length = 0.0;
        let mut smallest: Vec<f64> = Vec::new();
        for triangle in triangles {
            let corners = triangle.map(|v| points[v as usize]);
            let angles = [0, 1, 2].map(|k| {
                let [a, b, c] = [k, (k + 1) % 3, (k + 2) % 3].map(|at| corners[at]);
                length += a.distance(b);
                (b - a).angle_to(c - a).abs()
            });
            smallest.push(angles.into_iter().fold(f64::INFINITY, f64::min));
        }
        smallest.sort_by(f64::total_cmp);
        ((1..10).map(|k| smallest[k * smallest.len() / 10]).collect(), length)
    }

    #[test]
    fn triangles_have_the_shapes_of_delaunay() {
        let disc = |corners: i32| vec![(0.0, 0.0, corners, 1.0)];
        let ring = |corners: i32, inner: f64| vec![(0.0, 0.0, corners, 1.0), (0.0, 0.0, -corners, inner)];
        let hole = |k: i32| (f64::from(k % 5) * 4.0 - 8.0, f64::from(k / 5) * 4.0 - 8.0, -24, 1.2);
        let plate = |hole: &mut dyn FnMut(i32) -> (f64, f64, i32, f64)| {
            std::iter::once((0.0, 0.0, 90, 18.0)).chain((0..25).map(hole)).collect::<Vec<_>>()
        };
        let mut draw = SplitMix(1);
        let mut random = || draw.unit();
        let mut of_any_size = |k: i32| {
            let (x, y, ..) = hole(k);
            (x + random() - 0.5, y + random() - 0.5, -8 - (40.0 * random()) as i32, 0.1 + 1.1 * random())
        };
        let discs = [40, 256, 2_000, 4_096].map(disc);
        let rings = [ring(300, 0.9), ring(2_000, 0.9), ring(1_000, 0.3)];
        let plates =
            [plate(&mut { hole }), plate(&mut of_any_size), plate(&mut |k| (of_any_size(k).0, hole(k).1, -4, 1.2))];
        for loops in discs.into_iter().chain(rings).chain(plates) {
            let (points, starts) = rounds(&loops);
            assert_shapes_of_delaunay(&points, &starts);
        }
    }

    /// A square plate with rows of equal holes. Every other row is moved by `stagger` steps. The plate is rotated and
    /// scaled so that the x axis becomes `turn`.
    fn rows_of_holes(hole: &[[f64; 2]], stagger: f64, turn: [f64; 2]) -> (Vec<DVec2>, Vec<u32>) {
        const ROWS: u32 = 40;
        let most = f64::from(ROWS) + 1.0;
        let mut points = vec![DVec2::splat(-1.0), DVec2::new(most, -1.0), DVec2::splat(most), DVec2::new(-1.0, most)];
        let mut starts = vec![0];
        for (row, column) in (0..ROWS).flat_map(|row| (0..ROWS).map(move |column| (row, column))) {
            let corner = DVec2::new(f64::from(column) + f64::from(row % 2) * stagger, f64::from(row));
            starts.push(points.len() as u32);
            points.extend(hole.iter().map(|&p| corner + DVec2::from_array(p)));
        }
        let turn = DVec2::from_array(turn);
        (points.into_iter().map(|p| turn.rotate(p)).collect(), starts)
    }

    #[test]
    fn plates_with_rows_of_holes_have_the_shapes_of_delaunay() {
        let square = &[[0.25, 0.25], [0.25, 0.75], [0.75, 0.75], [0.75, 0.25]][..];
        let slot = &[[0.125, 0.375], [0.125, 0.625], [0.875, 0.625], [0.875, 0.375]][..];
        let triangle = &[[0.25, 0.25], [0.5, 0.75], [0.75, 0.25]][..];
        for (hole, stagger) in [(square, 0.0), (slot, 0.5), (triangle, 0.0)] {
            // Columns along a line that does not lean, along those that do and their mirror images, and nearly along a
            // line that does not lean.
            let [first, second] = SWEEPS.map(|(lean, _)| lean);
            for lean in [0.0, first, second, -first, -second, 1.0 / 57.0] {
                let (points, starts) = rows_of_holes(hole, stagger, [1.0, lean]);
                assert_shapes_of_delaunay(&points, &starts);
            }
        }
    }

    #[test]
    fn gears_have_the_shapes_of_delaunay() {
        for (corners_of_tooth, root) in [(2, 0.9), (2, 0.98), (4, 0.98), (10, 0.5), (20, 0.98), (50, 0.98)] {
            let radius = |k: u32| if (2 * k / corners_of_tooth).is_multiple_of(2) { 1.0 } else { root };
            let point = |k: u32| DVec2::from_angle(std::f64::consts::TAU * f64::from(k) / 2000.0) * radius(k);
            assert_shapes_of_delaunay(&(0..2000).map(point).collect::<Vec<_>>(), &[0]);
        }
    }

    #[test]
    fn discs_of_many_waves_have_the_shapes_of_delaunay() {
        let point = |k: u32| {
            let angle = std::f64::consts::TAU * f64::from(k) / 4096.0;
            DVec2::from_angle(angle) * (1.0 + 0.3 * (13.0 * angle).sin())
        };
        assert_shapes_of_delaunay(&(0..4096).map(point).collect::<Vec<_>>(), &[0]);
    }

    fn assert_shapes_of_delaunay(points: &[DVec2], starts: &[u32]) {
        let ours = proven(points, starts).expect("simple");
        let ends = starts.iter().skip(1).copied().chain([points.len() as u32]);
        let loops = starts
            .iter()
            .zip(ends)
            .flat_map(|(&start, end)| (start..end).map(move |v| [v, if v + 1 == end { start } else { v + 1 }]));
        let segments: Vec<_> = loops.map(|ends| Segment { ends, weight: 1 }).collect();
        let delaunay = cdt::triangulate(points, &segments, AtCrossings::Refuse).expect("simple").triangles;
        assert_eq!(ours.len(), delaunay.len());
        let ((ours, length), (theirs, least)) = (shapes(points, &ours), shapes(points, &delaunay));
        let last = points[points.len() - 1];
        assert!(length <= 1.01 * least, "{starts:?} to {last}: {length} and {least}");
        assert!(
            ours.iter().zip(&theirs).all(|(a, b)| a >= &(0.95 * b)),
            "{starts:?} to {last}: {ours:?} and {theirs:?}"
        );
    }

    #[test]
    fn loops_that_cross_where_few_vertices_are_left() {
        // The ring is thinner than what circles of a dozen corners lose, and so is what is between a hole and the disc.
        let thin = [(0.0, 0.0, 2_000, 1.0), (0.0, 0.0, -1_500, 0.999)];
        let near = [(0.0, 0.0, 2_000, 1.0), (0.97, 0.0, -200, 0.001), (-0.97, 0.0, -6, 0.001)];
        // An island nearly fills the hole.
        let island = [(0.0, 0.0, 2_000, 1.0), (0.0, 0.0, -1_000, 0.95), (0.0, 0.0, 1_000, 0.949)];
        for (loops, count) in [(&thin[..], 3_500), (&near, 2_208), (&island, 3_998)] {
            let (points, starts) = rounds(loops);
            let triangles = proven(&points, &starts).map(|triangles| triangles.len());
            assert_eq!(triangles.ok(), Some(count), "{loops:?}");
        }
    }

    #[test]
    fn what_the_sweep_takes_is_taken() {
        let mut sweep = Sweep::default();
        let mut levels = Levels::default();
        let (mut taken, mut finer) = (0, 0);
        for seed in 0..4_000 {
            let mut draw = SplitMix(seed);
            let mut random = || draw.unit();
            let (mut loops, count) = (Vec::new(), 1 + (5.0 * random()) as u32);
            for k in 0..count {
                let sign = if k % 2 == 0 { 1 } else { -1 };
                let corners = sign * (3 + (300.0 * random() * random()) as i32);
                // Around each other, or anywhere.
                loops.push(match seed % 2 {
                    0 => (0.0, 0.0, corners, 1.0 - f64::from(k) * 0.2 * random()),
                    _ if k == 0 => (0.0, 0.0, corners.max(40), 1.0),
                    _ => (1.2 * random() - 0.6, 1.2 * random() - 0.6, -corners.abs(), 0.3 * random()),
                });
            }
            let (mut points, starts) = rounds(&loops);
            let noise = if seed % 5 == 0 { 0.02 } else { 0.0 };
            points.iter_mut().for_each(|p| *p += noise * DVec2::new(random(), random()));
            let ids: Vec<u32> = (0..points.len() as u32).collect();
            let is_swept = sweep.triangulate(&points, &ids, &starts).is_ok();
            let triangles: Option<Vec<_>> = levels.triangulate(&points, &starts).ok().map(Iterator::collect);
            assert!(triangles.is_some() || !is_swept, "{loops:?}");
            if let Some(triangles) = triangles {
                prove(&points, &starts, &triangles);
                taken += 1;
                finer += u32::from(levels.levels.len() > 1);
            }
        }
        assert!(taken > 1_000 && finer > 900, "{taken} and {finer}");
    }
}
