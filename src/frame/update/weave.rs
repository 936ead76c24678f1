//! Triangles of a region, and new tessellants along parts of its boundary -> its triangles, reused away from changes.
//!
//! Triangles at removed tessellants are removed, then those whose circumcircles contain an added tessellant (A. Bowyer,
//! *Computing Dirichlet tessellations*, 1981; D. F. Watson, *Computing the n-dimensional Delaunay tessellation*, 1981).
//! No other triangle of a Delaunay triangulation changes. The hole, with the new boundary along it, is triangulated
//! like any region. The chains around the removed and the new triangles differ only by the changed parts of the
//! boundary, so the boundary of all triangles is that of the new loops.

use crate::frame::trim::chain::Fingerprint;
use crate::frame::trim::climb::{TrimScratch, trim_tile};
use crate::frame::trim::flip::in_circle;
use crate::frame::trim::input::{NONE, TrimInput, next_in};
use crate::frame::trim::output::{TrimOutcome, TrimOutput};
use crate::math::buckets::Buckets;
use crate::math::predicates::orient2d;
use glam::DVec2;

/// Attempts to fill the holes, each wider than the last.
const ATTEMPTS: usize = 3;

/// Triangles with adjacency, of a region without inner vertices.
#[derive(Clone, Debug, Default)]
pub(crate) struct Weave {
    /// Counter-clockwise.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Adjacent triangle across the side from corner k to the next; [`NONE`] along the boundary.
    beside: Vec<[u32; 3]>,
    /// The triangle left of the segment that starts at each tessellant.
    first: Vec<u32>,
}

/// A tile, and how its tessellants correspond to the old ones.
#[derive(Clone, Copy)]
pub(crate) struct LoopMapping<'a> {
    /// The new tile.
    pub(crate) tile: TrimInput<'a>,
    /// Loop starts of the old tile, which has the same loops in the same order.
    pub(crate) old_starts: &'a [u32],
    /// Old index of each tessellant; [`NONE`] for new ones. Tessellants that stay keep their order.
    pub(crate) from: &'a [u32],
}

/// Work space of [`Weave::update`]. Does not affect results.
#[derive(Default)]
pub(crate) struct WeaveScratch {
    /// New index of each old tessellant, or [`NONE`].
    to: Vec<u32>,
    /// By triangle: whether it is removed.
    out: Vec<bool>,
    /// The removed triangles.
    taken: Vec<u32>,
    stack: Vec<u32>,
    /// The last run that visited each triangle.
    seen: Vec<u32>,
    /// Tessellants that a run adds.
    added: Vec<DVec2>,
    runs: Vec<BoundaryRun>,
    /// By triangle: sides on the outline that were visited, a bit each.
    walked: Vec<u8>,
    /// The hole to be filled: tessellants, their points, and what is across the side that starts there.
    ids: Vec<u32>,
    points: Vec<DVec2>,
    across: Vec<TriangleSide>,
    starts: Vec<u32>,
    /// Triangles that fill the holes, and their adjacency.
    made: Vec<[u32; 3]>,
    links: Vec<[Link; 3]>,
    filled: TrimOutput,
}

/// A changed part of a loop, between two consecutive tessellants that stay.
#[derive(Clone, Copy)]
struct BoundaryRun {
    /// Old index of its start.
    old: u32,
    /// New index of its start, and the number of new tessellants between its ends.
    new: u32,
    between: u32,
}

/// A side of a triangle; none if `triangle` is [`NONE`].
#[derive(Clone, Copy)]
struct TriangleSide {
    triangle: u32,
    corner: u8,
}

/// What is across a side of a new triangle.
#[derive(Clone, Copy)]
enum Link {
    /// Another new triangle.
    Made(u32),
    /// A triangle that stays.
    Kept(TriangleSide),
    Boundary,
}

impl Weave {
    /// Finds the adjacency of triangles. `None` unless each segment of the loops is a side of one triangle, and all
    /// other sides match in pairs.
    pub(crate) fn of(triangles: &[[u32; 3]], loop_starts: &[u32]) -> Option<Self> {
        let count = *loop_starts.last()? as usize;
        // Triangles by corner. A side is searched at the end with fewer triangles.
        if triangles.iter().flatten().any(|&v| v as usize >= count) {
            return None;
        }
        let corners = (0..).zip(triangles).flat_map(|(t, corners)| corners.map(|v| (v, t)));
        let around = Buckets::of(count, corners);
        let of = |v: u32| around.at(v);
        let mut weave = Self {
            triangles: triangles.to_vec(),
            beside: Vec::with_capacity(triangles.len()),
            first: vec![NONE; count],
        };
        let mut boundary = 0;
        for (t, corners) in (0_u32..).zip(triangles) {
            let mut beside = [NONE; 3];
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                let fewer = if of(a).len() < of(b).len() { of(a) } else { of(b) };
                let runs = |t: u32, from: u32, to: u32| {
                    let [p, q, r] = triangles[t as usize];
                    [(p, q), (q, r), (r, p)].contains(&(from, to))
                };
                if fewer.iter().any(|&other| other != t && runs(other, a, b)) {
                    return None;
                }
                match fewer.iter().find(|&&other| runs(other, b, a)) {
                    Some(&other) => beside[k] = other,
                    None => {
                        let l = loop_starts.partition_point(|&start| start <= a) - 1;
                        if next_in(&loop_starts[l..], a) != b {
                            return None;
                        }
                        weave.first[a as usize] = t;
                        boundary += 1;
                    }
                }
            }
            weave.beside.push(beside);
        }
        (boundary == count).then_some(weave)
    }

    /// Heap size, bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of::<[u32; 3]>() * (self.triangles.capacity() + self.beside.capacity()) + 4 * self.first.capacity()
    }

    /// Updates the triangles for new tessellants. `None` if impossible or doubtful; the triangles are unusable then.
    ///
    /// Cost: about 30 ns per tessellant, and half a microsecond for each that is added or removed.
    pub(crate) fn update(
        &mut self,
        changed: &LoopMapping<'_>,
        trim: &mut TrimScratch,
        s: &mut WeaveScratch,
    ) -> Option<()> {
        s.to.clear();
        s.to.resize(*changed.old_starts.last()? as usize, NONE);
        for (new, &old) in (0_u32..).zip(changed.from) {
            if old != NONE {
                s.to[old as usize] = new;
            }
        }
        s.find_runs(changed)?;
        s.out.clear();
        s.out.resize(self.triangles.len(), false);
        s.seen.clear();
        s.seen.resize(self.triangles.len(), NONE);
        s.taken.clear();
        for run in 0..s.runs.len() {
            self.take_out(changed, run, s);
        }
        for run in 0..s.runs.len() {
            if meets_others(changed, &s.runs[run]) {
                return None;
            }
        }
        for attempt in 1.. {
            if self.fill(changed, trim, s).is_some() {
                break;
            }
            if attempt == ATTEMPTS || !self.take_out_more(s) {
                return None;
            }
        }
        self.put_in(changed, s)?;
        self.covers(&changed.tile).then_some(())
    }

    /// Which corner of triangle `t` is `v`.
    fn corner(&self, t: u32, v: u32) -> Option<usize> {
        self.triangles[t as usize].iter().position(|&corner| corner == v)
    }

    /// Removes the triangles along an old run, those around removed tessellants, and those near added ones.
    fn take_out(&self, changed: &LoopMapping<'_>, run: usize, s: &mut WeaveScratch) {
        let BoundaryRun { old, new, between } = s.runs[run];
        let l = changed.old_starts.partition_point(|&start| start <= old) - 1;
        let l_new = &changed.tile.loop_starts[l..];
        s.added.clear();
        let mut v = new;
        for _ in 0..between {
            v = next_in(l_new, v);
            s.added.push(changed.tile.points[v as usize]);
        }
        s.stack.clear();
        let mut v = old;
        loop {
            let first = self.first[v as usize];
            s.see(run, first);
            if v != old {
                // All triangles around a removed tessellant.
                let mut t = first;
                while let Some(k) = self.corner(t, v) {
                    t = self.beside[t as usize][(k + 2) % 3];
                    if t == NONE {
                        break;
                    }
                    s.see(run, t);
                }
            }
            v = next_in(&changed.old_starts[l..], v);
            if s.to[v as usize] != NONE {
                break;
            }
        }
        while let Some(t) = s.stack.pop() {
            if !s.out[t as usize] {
                s.out[t as usize] = true;
                s.taken.push(t);
            }
            for &other in &self.beside[t as usize] {
                if other == NONE || s.seen[other as usize] == run as u32 {
                    continue;
                }
                // A triangle at a removed tessellant is on that tessellant's run, which removes it.
                let corners = self.triangles[other as usize].map(|v| s.to[v as usize]);
                if corners.contains(&NONE) {
                    continue;
                }
                let [a, b, c] = corners.map(|v| changed.tile.points[v as usize]);
                if s.added.iter().any(|&p| in_circle(a, b, c, p) > 0.0) {
                    s.see(run, other);
                }
            }
        }
    }

    /// Also removes all neighbours of removed triangles. Returns whether there were any.
    fn take_out_more(&self, s: &mut WeaveScratch) -> bool {
        let before = s.taken.len();
        for k in 0..before {
            for &other in &self.beside[s.taken[k] as usize] {
                if other != NONE && !s.out[other as usize] {
                    s.out[other as usize] = true;
                    s.taken.push(other);
                }
            }
        }
        s.taken.len() > before
    }

    /// Fills the holes, each with the new runs along it.
    fn fill(&self, changed: &LoopMapping<'_>, trim: &mut TrimScratch, s: &mut WeaveScratch) -> Option<()> {
        s.made.clear();
        s.links.clear();
        s.walked.clear();
        s.walked.resize(self.triangles.len(), 0);
        s.seen.fill(NONE);
        for k in 0..s.taken.len() {
            if s.seen[s.taken[k] as usize] != NONE {
                continue;
            }
            s.ids.clear();
            s.points.clear();
            s.across.clear();
            s.starts.clear();
            s.starts.push(0);
            s.stack.clear();
            s.see(0, s.taken[k]);
            while let Some(t) = s.stack.pop() {
                for corner in 0..3 {
                    let other = self.beside[t as usize][corner];
                    if other != NONE && s.out[other as usize] {
                        if s.seen[other as usize] == NONE {
                            s.see(0, other);
                        }
                    } else if s.walked[t as usize] & (1 << corner) == 0
                        && s.to[self.triangles[t as usize][corner] as usize] != NONE
                    {
                        self.walk(changed, TriangleSide { triangle: t, corner: corner as u8 }, s)?;
                    }
                }
            }
            s.fill_region(trim)?;
        }
        Some(())
    }

    /// Collects one outline of a hole, with new runs in place of the old ones.
    fn walk(&self, changed: &LoopMapping<'_>, start: TriangleSide, s: &mut WeaveScratch) -> Option<()> {
        let from = s.ids.len();
        let mut at = start;
        loop {
            let (t, k) = (at.triangle as usize, usize::from(at.corner));
            s.walked[t] |= 1 << k;
            let (a, other) = (self.triangles[t][k], self.beside[t][k]);
            let mut v = s.to[a as usize];
            if other != NONE {
                let side = TriangleSide { triangle: other, corner: self.side_towards(other, at.triangle)? };
                if v == NONE {
                    return None;
                }
                s.add(changed, v, side);
            } else if v != NONE {
                let l = changed.old_starts.partition_point(|&start| start <= a) - 1;
                loop {
                    s.add(changed, v, TriangleSide { triangle: NONE, corner: 0 });
                    v = next_in(&changed.tile.loop_starts[l..], v);
                    if changed.from[v as usize] != NONE {
                        break;
                    }
                }
            }
            let b = self.triangles[t][(k + 1) % 3];
            let mut next = (at.triangle, (k + 1) % 3);
            loop {
                let other = self.beside[next.0 as usize][next.1];
                if other == NONE || !s.out[other as usize] {
                    break;
                }
                next = (other, self.corner(other, b)?);
            }
            at = TriangleSide { triangle: next.0, corner: next.1 as u8 };
            if (at.triangle, at.corner) == (start.triangle, start.corner) {
                break;
            }
            if s.walked[next.0 as usize] & (1 << next.1) != 0 {
                return None;
            }
        }
        s.starts.push(s.ids.len() as u32);
        (s.ids.len() >= from + 3).then_some(())
    }

    /// Which side of `t` is adjacent to `other`.
    fn side_towards(&self, t: u32, other: u32) -> Option<u8> {
        self.beside[t as usize].iter().position(|&beside| beside == other).map(|k| k as u8)
    }

    /// Inserts the new triangles in place of the removed ones, and renumbers all tessellants.
    fn put_in(&mut self, changed: &LoopMapping<'_>, s: &mut WeaveScratch) -> Option<()> {
        for (corners, &out) in self.triangles.iter_mut().zip(&s.out) {
            if !out {
                *corners = corners.map(|v| s.to[v as usize]);
                if corners.contains(&NONE) {
                    return None;
                }
            }
        }
        let stays = |&old: &u32| {
            let first = if old == NONE { NONE } else { self.first[old as usize] };
            if first != NONE && s.out[first as usize] { NONE } else { first }
        };
        let mut first: Vec<u32> = changed.from.iter().map(stays).collect();
        let old = self.triangles.len();
        let slot = |made: usize| s.taken.get(made).copied().unwrap_or_else(|| (old + made - s.taken.len()) as u32);
        for (k, (&corners, links)) in s.made.iter().zip(&s.links).enumerate() {
            let here = slot(k);
            let mut beside = [NONE; 3];
            for (corner, link) in links.iter().enumerate() {
                match *link {
                    Link::Made(other) => beside[corner] = slot(other as usize),
                    Link::Kept(side) => {
                        beside[corner] = side.triangle;
                        self.beside[side.triangle as usize][usize::from(side.corner)] = here;
                    }
                    Link::Boundary => first[corners[corner] as usize] = here,
                }
            }
            if here as usize == self.triangles.len() {
                self.triangles.push(corners);
                self.beside.push(beside);
            } else {
                (self.triangles[here as usize], self.beside[here as usize]) = (corners, beside);
            }
        }
        // If fewer triangles were made than removed, the last ones move into the empty slots.
        let filled = s.made.len().min(s.taken.len());
        let empty = &mut s.taken[filled..];
        empty.sort_unstable();
        for &slot in empty.iter().rev() {
            let last = self.triangles.len() as u32 - 1;
            self.triangles.swap_remove(slot as usize);
            self.beside.swap_remove(slot as usize);
            if slot == last {
                continue;
            }
            for k in 0..3 {
                match self.beside[slot as usize][k] {
                    NONE => first[self.triangles[slot as usize][k] as usize] = slot,
                    other => {
                        let side = self.side_towards(other, last)?;
                        self.beside[other as usize][usize::from(side)] = slot;
                    }
                }
            }
        }
        self.first = first;
        (!self.first.contains(&NONE)).then_some(())
    }

    /// Whether the boundary of the triangles is the loops.
    fn covers(&self, tile: &TrimInput<'_>) -> bool {
        let mut boundary = Fingerprint::default();
        self.triangles.iter().for_each(|&t| boundary.add_triangle(t));
        boundary == Fingerprint::of_loops(tile)
    }
}

impl WeaveScratch {
    /// Pushes a triangle to the stack unless this run visited it.
    fn see(&mut self, run: usize, t: u32) {
        if self.seen[t as usize] != run as u32 {
            self.seen[t as usize] = run as u32;
            self.stack.push(t);
        }
    }

    fn add(&mut self, changed: &LoopMapping<'_>, v: u32, across: TriangleSide) {
        self.ids.push(v);
        self.points.push(changed.tile.points[v as usize]);
        self.across.push(across);
    }

    /// Finds the runs. `None` if a loop keeps none of its tessellants, or their order changed.
    fn find_runs(&mut self, changed: &LoopMapping<'_>) -> Option<()> {
        let LoopMapping { tile, old_starts, from } = *changed;
        self.runs.clear();
        if old_starts.len() != tile.loop_starts.len() {
            return None;
        }
        for l in 0..old_starts.len() - 1 {
            let range = tile.loop_starts[l]..tile.loop_starts[l + 1];
            let old_length = old_starts[l + 1] - old_starts[l];
            let Some(start) = range.clone().find(|&v| from[v as usize] != NONE) else {
                if range.is_empty() && old_length == 0 {
                    continue;
                }
                return None;
            };
            let (mut at, mut passed) = (start, 0);
            loop {
                let (mut v, mut between) = (next_in(&tile.loop_starts[l..], at), 0);
                while from[v as usize] == NONE {
                    (v, between) = (next_in(&tile.loop_starts[l..], v), between + 1);
                }
                let (a, b) = (from[at as usize], from[v as usize]);
                // If only one stays, the run goes once around.
                let length = if a == b { old_length } else { (b + old_length - a) % old_length };
                passed += length;
                if between > 0 || length != 1 {
                    self.runs.push(BoundaryRun { old: a, new: at, between });
                }
                at = v;
                if at == start {
                    break;
                }
            }
            if passed != old_length {
                return None;
            }
        }
        Some(())
    }

    /// Triangulates the hole whose outlines were collected.
    fn fill_region(&mut self, trim: &mut TrimScratch) -> Option<()> {
        let region = TrimInput { cells: (1, 1), points: &self.points, loop_starts: &self.starts, places: &[] };
        let outcome = trim_tile(&region, trim, &mut self.filled).ok()?;
        let TrimOutput { triangles, full_cells, .. } = &self.filled;
        if matches!(outcome, TrimOutcome::Repaired { .. }) || !full_cells.is_empty() {
            return None;
        }
        let weave = Weave::of(triangles, &self.starts)?;
        let before = self.made.len() as u32;
        for (corners, beside) in weave.triangles.iter().zip(&weave.beside) {
            self.made.push(corners.map(|v| self.ids[v as usize]));
            let link = |k: usize| match (beside[k], self.across[corners[k] as usize]) {
                (NONE, TriangleSide { triangle: NONE, .. }) => Link::Boundary,
                (NONE, side) => Link::Kept(side),
                (other, _) => Link::Made(before + other),
            };
            self.links.push([link(0), link(1), link(2)]);
        }
        Some(())
    }
}

/// Whether a segment of a new run meets any other segment, except at common ends.
fn meets_others(changed: &LoopMapping<'_>, run: &BoundaryRun) -> bool {
    let tile = &changed.tile;
    let l = tile.loop_starts.partition_point(|&start| start <= run.new) - 1;
    let mut path = vec![run.new];
    for _ in 0..=run.between {
        path.push(next_in(&tile.loop_starts[l..], path[path.len() - 1]));
    }
    let at = |v: u32| tile.points[v as usize];
    let (low, high) = path.iter().map(|&v| at(v)).fold((at(run.new), at(run.new)), |(l, h), p| (l.min(p), h.max(p)));
    let apart = |low: DVec2, high: DVec2, a: DVec2, b: DVec2| {
        let (l, h) = (a.min(b), a.max(b));
        l.x > high.x || l.y > high.y || h.x < low.x || h.y < low.y
    };
    tile.segments().filter(|&(c, d)| !apart(low, high, at(c), at(d))).any(|(c, d)| {
        path.windows(2).any(|w| {
            let (a, b) = (w[0], w[1]);
            let (p, q, r, t) = (at(a), at(b), at(c), at(d));
            if (a, b) == (c, d) || apart(p.min(q), p.max(q), r, t) {
                return false;
            }
            if a == d || b == c {
                // Neighbours meet at one end only, unless one goes back along the other.
                let (end, here, there) = if a == d { (a, b, c) } else { (b, a, d) };
                let (e, f) = (at(here) - at(end), at(there) - at(end));
                return here == there || orient2d(at(end), at(here), at(there)) == 0.0 && e.dot(f) > 0.0;
            }
            let sides = |a: f64, b: f64| a > 0.0 && b > 0.0 || a < 0.0 && b < 0.0;
            !sides(orient2d(p, q, r), orient2d(p, q, t)) && !sides(orient2d(r, t, p), orient2d(r, t, q))
        })
    })
}

#[cfg(test)]
mod tests;
