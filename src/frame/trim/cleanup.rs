//! Rings that failed, and loops inside one cell -> triangles, by joining them with their surroundings.
//!
//! A ring that failed is first merged with one neighbour. The rest forms clusters. The boundaries of a cluster's
//! members are summed (opposite edges cancel) and constrain a Delaunay triangulation, which is accepted if its region's
//! boundary is exactly that sum. A refused cluster grows by its neighbours. Growth ends: the boundary of all pieces
//! together is that of the tile's region.

use super::cdt::{self, AtCrossings, Segment};
use super::input::TrimInput;
use super::output::TrimOutput;
use super::rings::{Ring, RingOrigin, Rings, corner_after, next_chain};
use super::trace::{InCellLoop, Trace};
use super::triangulate::Polygon;
use crate::math::predicates::orient2d;
use crate::math::sets::DisjointSets;
use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;

/// Refusals after which a cluster takes in full cells together with other neighbours.
const FULL_CELLS_AFTER: u32 = 3;
/// Refusals after which the whole tile is triangulated instead: by then the cluster holds most of the tile, or the
/// loops are not simple.
const GIVE_UP_AFTER: u32 = 24;

/// Most vertices of two rings that are merged: which of their edges cancel is found edge by edge.
const MOST_MERGED: usize = 96;

/// Marks triangles that were replaced.
const DEAD: [u32; 3] = [u32::MAX; 3];

/// The state of one tile's cleanup. Allocates: it runs for few tiles.
struct Cleanup<'a> {
    tile: &'a TrimInput<'a>,
    trace: &'a Trace,
    rings: &'a mut Rings,
    polygon: &'a mut Polygon,
    out: &'a mut TrimOutput,
    /// The in-cell loops, by cell.
    loops: Vec<InCellLoop>,
    /// Union-find over the rings: a cluster is a tree. `members` and `refusals` are up to date at roots only.
    sets: DisjointSets,
    members: Vec<Vec<u32>>,
    refusals: Vec<u32>,
    /// Rings made of a cell's corners, by cell.
    cell_rings: BTreeMap<u32, u32>,
    /// Former full cells that became rings here.
    taken_cells: Vec<u32>,
}

/// Solves all unsolved rings and in-cell loops. `None` if no union of pieces could be triangulated: the loops are not
/// simple. The content of `out` is unspecified then.
#[cold]
#[inline(never)]
pub(crate) fn clean_up(
    tile: &TrimInput<'_>,
    trace: &Trace,
    rings: &mut Rings,
    polygon: &mut Polygon,
    out: &mut TrimOutput,
) -> Option<()> {
    let mut loops = trace.in_cell_loops.clone();
    loops.sort_unstable();
    let count = rings.rings.len();
    let mut cell_rings = BTreeMap::new();
    for (index, ring) in rings.rings.iter().enumerate() {
        if let RingOrigin::Cell(cell) = ring.origin {
            cell_rings.insert(cell, index as u32);
        }
    }
    let mut cleanup = Cleanup {
        tile,
        trace,
        rings,
        polygon,
        out,
        loops,
        sets: DisjointSets::new(count),
        members: vec![Vec::new(); count],
        refusals: vec![0; count],
        cell_rings,
        taken_cells: Vec::new(),
    };
    cleanup.group_loops();
    for ring in 0..count as u32 {
        cleanup.merge_with_neighbour(ring);
    }
    cleanup.solve_clusters()?;
    let roots = (0..cleanup.sets.len() as u32).map(|piece| cleanup.sets.root(piece)).collect();
    let Cleanup { rings, out, taken_cells, .. } = cleanup;
    rings.roots = roots;
    out.triangles.retain(|t| *t != DEAD);
    if !taken_cells.is_empty() {
        let taken: std::collections::BTreeSet<u32> = taken_cells.into_iter().collect();
        out.full_cells.retain(|&[i, j]| !taken.contains(&(j * tile.cells.0 + i)));
    }
    Some(())
}

impl Cleanup<'_> {
    // -- pieces and clusters

    fn add_piece(&mut self, origin: RingOrigin) -> u32 {
        let index = self.rings.rings.len() as u32;
        self.rings.rings.push(Ring { origin, triangles: [0, 0], solved: false });
        self.sets.push();
        self.members.push(Vec::new());
        self.refusals.push(0);
        index
    }

    /// Joins two clusters into one without triangles. Returns false if they are the same.
    fn join(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.sets.root(a), self.sets.root(b));
        if a == b {
            return false;
        }
        for root in [a, b] {
            let ring = &mut self.rings.rings[root as usize];
            let [from, to] = std::mem::take(&mut ring.triangles);
            ring.solved = false;
            self.out.triangles[from as usize..to as usize].fill(DEAD);
        }
        let (large, small) =
            if self.members[a as usize].len() < self.members[b as usize].len() { (b, a) } else { (a, b) };
        let moved = std::mem::take(&mut self.members[small as usize]);
        let members = &mut self.members[large as usize];
        members.push(small);
        members.extend(moved);
        self.sets.join_under(large, small);
        self.refusals[large as usize] = self.refusals[large as usize].max(self.refusals[small as usize]);
        true
    }

    fn is_alone(&mut self, piece: u32) -> bool {
        self.sets.root(piece) == piece && self.members[piece as usize].is_empty()
    }

    // -- loops inside one cell

    /// Joins the loops of each cell with each other and with the rings of that cell.
    fn group_loops(&mut self) {
        let mut from = 0;
        while from < self.loops.len() {
            let cell = self.loops[from].cell;
            let to = from + self.loops[from..].iter().take_while(|l| l.cell == cell).count();
            let surroundings = self.rings_of_cell(cell);
            let piece = self.add_piece(RingOrigin::Loops(from as u32, to as u32));
            let triangles = self.triangulate_with_rings(from..to, &surroundings);
            for ring in surroundings {
                self.join(piece, ring);
            }
            if let Some(triangles) = triangles {
                let root = self.sets.root(piece);
                self.solve(root, &triangles);
            }
            from = to;
        }
    }

    fn triangulate_with_rings(&mut self, loops: Range<usize>, surroundings: &[u32]) -> Option<Vec<[u32; 3]>> {
        let mut rings = Vec::with_capacity(surroundings.len());
        for &ring in surroundings {
            self.reload(ring);
            rings.push((self.polygon.ids.clone(), self.polygon.points.clone()));
        }
        self.polygon.clear();
        for (ids, points) in rings {
            self.polygon.begin_loop();
            self.polygon.ids.extend(ids);
            self.polygon.points.extend(points);
        }
        self.loops[loops].iter().for_each(|l| self.polygon.add_loop(self.tile, l.loop_index));
        let mut triangles = Vec::new();
        self.polygon.triangulate(&mut triangles).then_some(triangles)
    }

    /// The rings of a cell: those of the chains that cross its sides, or that of its corners.
    fn rings_of_cell(&self, cell: u32) -> Vec<u32> {
        let [i, j] = self.tile.cell(cell).map(|k| k as usize);
        let mut rings: Vec<u32> = self.cell_rings.get(&cell).copied().into_iter().collect();
        for side in 0..4 {
            let mut next = self.trace.first_on_side(i, j, side);
            while let Some(k) = next {
                let crossing = &self.trace.crossings[k as usize];
                let leaves = crossing.side == side && crossing.cell == [i as u16, j as u16];
                let chain = if leaves { self.trace.chain_before(k) } else { k };
                rings.push(self.rings.ring_of[chain as usize]);
                let onward = if side < 2 { crossing.above } else { crossing.below };
                next = (onward != super::input::NONE).then_some(onward);
            }
        }
        rings.sort_unstable();
        rings.dedup();
        rings
    }

    // -- stage 1: one neighbour

    /// Merges a failed ring with the neighbour that makes the largest triangle smallest.
    fn merge_with_neighbour(&mut self, ring: u32) {
        let Ring { origin: RingOrigin::Chain(_), solved: false, .. } = self.rings.rings[ring as usize] else { return };
        if !self.is_alone(ring) {
            return;
        }
        let mut best: Option<(f64, u32, Vec<[u32; 3]>)> = None;
        for neighbour in self.neighbours(ring, false) {
            if neighbour == ring || !self.is_alone(neighbour) || !self.merge_polygons(ring, neighbour) {
                continue;
            }
            let mut triangles = Vec::new();
            if self.polygon.triangulate(&mut triangles) {
                let size = triangles.iter().map(|t| self.box_size(*t)).fold(0.0, f64::max);
                if best.as_ref().is_none_or(|b| size < b.0) {
                    best = Some((size, neighbour, triangles));
                }
            }
        }
        if let Some((_, neighbour, triangles)) = best {
            self.join(ring, neighbour);
            let root = self.sets.root(ring);
            self.solve(root, &triangles);
            self.out.stats.merged_rings += 1;
        }
    }

    /// Loads the polygon of two rings together. Returns false if it is not one simple loop, or would lose a kept
    /// corner.
    fn merge_polygons(&mut self, a: u32, b: u32) -> bool {
        let mut edges: Vec<[u32; 2]> = Vec::new();
        let mut corners: Vec<u32> = Vec::new();
        let mut cancelled = false;
        for ring in [a, b] {
            self.reload(ring);
            let ids = &self.polygon.ids;
            if edges.len() + ids.len() > MOST_MERGED {
                return false;
            }
            for (k, &id) in ids.iter().enumerate() {
                if id as usize >= self.tile.points.len() {
                    corners.push(id);
                }
                let to = ids[(k + 1) % ids.len()];
                if let Some(at) = edges.iter().position(|e| *e == [to, id]) {
                    edges.swap_remove(at);
                    cancelled = true;
                } else {
                    edges.push([id, to]);
                }
            }
        }
        self.polygon.clear();
        let Some(&[start, _]) = edges.first() else { return cancelled };
        let mut at = start;
        for _ in 0..edges.len() {
            let mut onward = edges.iter().filter(|e| e[0] == at);
            let (Some(edge), None) = (onward.next(), onward.next()) else { return false };
            let point = self.tile.point(at);
            self.polygon.push_distinct(at, point);
            at = edge[1];
            if at == start {
                break;
            }
        }
        let ids = &self.polygon.ids;
        cancelled && at == start && ids.len() == edges.len() && corners.iter().all(|c| ids.contains(c))
    }

    fn box_size(&self, triangle: [u32; 3]) -> f64 {
        let [a, b, c] = triangle.map(|v| self.tile.point(v));
        (a.max(b).max(c) - a.min(b).min(c)).max_element()
    }

    // -- stage 2: clusters

    fn solve_clusters(&mut self) -> Option<()> {
        let unsolved = |r: &(usize, &Ring)| !r.1.solved;
        let mut queue: VecDeque<u32> =
            self.rings.rings.iter().enumerate().filter(unsolved).map(|(index, _)| index as u32).collect();
        while let Some(piece) = queue.pop_front() {
            let root = self.sets.root(piece);
            if self.rings.rings[root as usize].solved {
                continue;
            }
            if let Some(triangles) = self.triangulate_cluster(root) {
                self.solve(root, &triangles);
                self.out.stats.clusters += 1;
                continue;
            }
            self.refusals[root as usize] += 1;
            if self.refusals[root as usize] > GIVE_UP_AFTER || !self.grow(root) {
                return None;
            }
            queue.push_back(root);
        }
        Some(())
    }

    fn solve(&mut self, root: u32, triangles: &[[u32; 3]]) {
        let from = self.out.triangles.len() as u32;
        self.out.triangles.extend_from_slice(triangles);
        let ring = &mut self.rings.rings[root as usize];
        ring.triangles = [from, from + triangles.len() as u32];
        ring.solved = true;
    }

    /// Takes in the neighbours of all members. Returns false if there are none left.
    fn grow(&mut self, root: u32) -> bool {
        let mut members = self.members[root as usize].clone();
        members.push(root);
        let refusals = self.refusals[root as usize];
        let mut grown = false;
        for full_cells in [false, true] {
            for &member in &members {
                for neighbour in self.neighbours(member, full_cells) {
                    grown |= self.join(neighbour, root);
                }
            }
            if grown && refusals <= FULL_CELLS_AFTER {
                break;
            }
        }
        grown
    }

    /// The rings on the other side of a ring's chains and lattice edges. With `full_cells`, makes rings of full cells
    /// beyond lattice edges too.
    fn neighbours(&mut self, piece: u32, full_cells: bool) -> Vec<u32> {
        let mut found = Vec::new();
        let mut edges: Vec<(usize, usize, u8)> = Vec::new();
        match self.rings.rings[piece as usize].origin {
            RingOrigin::Loops(..) => {}
            RingOrigin::Cell(cell) => {
                let [i, j] = self.tile.cell(cell).map(|k| k as usize);
                edges.extend((0..4).map(|side| (i, j, side)));
            }
            RingOrigin::Chain(first) => {
                let mut k = first;
                loop {
                    found.push(self.rings.ring_of[self.trace.chain_before(k) as usize]);
                    let crossing = self.trace.crossings[k as usize].next;
                    found.push(self.rings.ring_of[crossing as usize]);
                    let c = &self.trace.crossings[crossing as usize];
                    let (i, j) = (c.cell[0] as usize, c.cell[1] as usize);
                    let mut corners: Vec<(usize, usize)> = Vec::new();
                    let Ok(next) = next_chain(self.trace, crossing, |ci, cj| corners.push((ci, cj))) else { break };
                    // The sides between two consecutive corners have no crossings.
                    for side in 0..4u8 {
                        let ends = [corner_after(i, j, (side + 3) & 3), corner_after(i, j, side)];
                        if corners.windows(2).any(|w| w == ends) {
                            edges.push((i, j, side));
                        }
                    }
                    k = next;
                    if k == first {
                        break;
                    }
                }
            }
        }
        for (i, j, side) in edges {
            found.extend(self.ring_across(i, j, side, full_cells));
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The ring beyond a side that has no crossings and kept ends: the ring that the first crossing further around that
    /// cell enters, or the ring of the cell itself.
    fn ring_across(&mut self, i: usize, j: usize, side: u8, full_cells: bool) -> Option<u32> {
        let (i, j) = match side {
            0 => (i, j.checked_sub(1)?),
            1 => (i + 1, j),
            2 => (i, j + 1),
            _ => (i.checked_sub(1)?, j),
        };
        if i >= self.tile.cells.0 as usize || j >= self.tile.cells.1 as usize {
            return None;
        }
        for turn in 3..6 {
            if let Some(k) = self.trace.first_on_side(i, j, (side + turn) & 3) {
                return Some(self.rings.ring_of[k as usize]);
            }
        }
        let cell = j as u32 * self.tile.cells.0 + i as u32;
        if let Some(&ring) = self.cell_rings.get(&cell) {
            return Some(ring);
        }
        if !full_cells {
            return None;
        }
        let ring = self.add_piece(RingOrigin::Cell(cell));
        self.cell_rings.insert(cell, ring);
        self.taken_cells.push(cell);
        Some(ring)
    }

    /// The cluster's triangles, or `None` if its boundary does not bound a region.
    fn triangulate_cluster(&mut self, root: u32) -> Option<Vec<[u32; 3]>> {
        let mut edges: Vec<[u32; 2]> = Vec::new();
        let mut members = self.members[root as usize].clone();
        members.push(root);
        for member in members {
            self.append_edges(member, &mut edges);
        }
        let mut sites: Vec<u32> = edges.iter().map(|e| e[0]).collect();
        cancel_opposites(&mut edges)?;
        // Tessellants stay only as ends of segments. Kept corners inside stay as free vertices, to keep triangles
        // small.
        let mut on_boundary: Vec<u32> = edges.iter().flatten().copied().collect();
        on_boundary.sort_unstable();
        on_boundary.dedup();
        sites.retain(|&v| v as usize >= self.tile.points.len());
        sites.extend_from_slice(&on_boundary);
        sites.sort_unstable();
        sites.dedup();
        let points: Vec<_> = sites.iter().map(|&v| self.tile.point(v)).collect();
        let local = |v: u32| sites.binary_search(&v).map(|k| k as u32).ok();
        let mut segments = Vec::with_capacity(edges.len());
        for [a, b] in edges {
            segments.push(Segment { ends: [local(a)?, local(b)?], weight: 1 });
        }
        let region = cdt::triangulate(&points, &segments, AtCrossings::Refuse).ok()?;
        if !region.layers.is_empty() {
            return None;
        }
        let positive = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| points[v as usize]);
            orient2d(a, b, c) > 0.0
        };
        region
            .triangles
            .iter()
            .all(positive)
            .then(|| region.triangles.iter().map(|t| t.map(|v| sites[v as usize])).collect())
    }

    fn append_edges(&mut self, piece: u32, edges: &mut Vec<[u32; 2]>) {
        if let RingOrigin::Loops(from, to) = self.rings.rings[piece as usize].origin {
            for index in from..to {
                let l = self.loops[index as usize].loop_index;
                let [start, end] = self.tile.ends(l);
                edges.extend((start..end).map(|v| [v, self.tile.next(l, v)]));
            }
            return;
        }
        self.reload(piece);
        let ids = &self.polygon.ids;
        edges.extend(ids.iter().enumerate().map(|(k, &v)| [v, ids[(k + 1) % ids.len()]]));
    }

    fn reload(&mut self, piece: u32) {
        let origin = self.rings.rings[piece as usize].origin;
        self.rings.reload(self.tile, self.trace, origin, self.polygon);
    }
}

/// Removes pairs of opposite edges. `None` if more than one edge remains in one direction.
fn cancel_opposites(edges: &mut Vec<[u32; 2]>) -> Option<()> {
    let line = |e: &[u32; 2]| [e[0].min(e[1]), e[0].max(e[1])];
    edges.sort_unstable_by_key(|e| (line(e), e[0]));
    let mut left = Vec::with_capacity(edges.len());
    for group in edges.chunk_by(|a, b| line(a) == line(b)) {
        let forward = group.iter().filter(|e| e[0] < e[1]).count();
        let backward = group.len() - forward;
        match forward.abs_diff(backward) {
            0 => {}
            1 => left.push(if forward > backward { line(&group[0]) } else { [line(&group[0])[1], line(&group[0])[0]] }),
            _ => return None,
        }
    }
    *edges = left;
    Some(())
}
