//! Loops in a plane -> Delaunay triangles with the same boundary, from coarse to fine; or a refusal.
//!
//! Method: every other vertex is left out where loops are smooth, again and again, while they have many. The sweep
//! triangulates what is left. Then the vertices return, each between its neighbours, and edges around it are flipped: few
//! of them, as it is one in two wherever it is. Vertices that come in the order of the sweep, or all at once, take flips
//! in proportion to their number, each.
//!
//! Loops that few vertices remain of may cross where those of all do not. Nothing has to foresee that. The boundary of
//! the triangles is the loops all the same, and a triangle that cannot be made positive is found at once. The sweep
//! then begins at a finer level. Cost: that of the sweep for a share of the vertices, and for each of the others one and
//! a half flips and three circle tests.

use super::sweep::{NotSimple, Sweep};
use glam::DVec2;

/// Loops with fewer vertices in all are swept.
const FEW: usize = 12;

/// The indices of few vertices.
const FIRST: [u32; FEW] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];

/// Loops with fewer vertices keep them all.
const LEAST: usize = 6;

/// Tangent of the largest turn at a vertex that is left out: circles become hexagons or squares.
const SMOOTH: f64 = 1.2;

/// A level has at most 7/8 of the vertices of the one before, or it is not worth its pass.
const SHARE: usize = 8;

/// Levels that are given up when the sweep refuses one: the next has about four times the vertices.
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
        if points.len() < FEW {
            return Ok(self.sweep.triangulate(points, &FIRST[..points.len()], starts)?.triangles());
        }
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
                self.thin(points, from, to);
            }
            next.ears = self.ears.len();
            self.levels.push(next);
            if SHARE * (next.ears - level.ears) < count {
                self.truncate(self.levels.len() - 1);
                return;
            }
            level = next;
        }
    }

    /// Appends to the level in the making what it keeps of a loop: no two neighbours are left out.
    #[inline(always)]
    fn thin(&mut self, points: &[DVec2], from: usize, to: usize) {
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
            let is_smooth = ahead > 0.0 && aside.abs() <= SMOOTH * ahead;
            if is_smooth {
                self.ears.push([before, v, after]);
                at += 1;
            }
            before = if is_smooth { after } else { v };
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
