//! Triangles with common edges -> triangles of the same boundary that come close to Delaunay's, by flips.
//!
//! Method: Lawson, "Software for C1 surface interpolation", 1977. A flip is made only where the circle test exceeds what
//! its rounding could change. So each one is a true step towards the Delaunay triangulation, which ends.

use super::input::NONE;
use crate::math::lanes::widest;
use crate::math::order::larger;
use crate::math::predicates::orient2d;
use glam::DVec2;

/// Stands for an edge of the boundary.
pub(crate) const BORDER: u32 = u32::MAX;

/// Circle tests below this share of the fourth power of the distances count as zero. Rounding changes them by less than
/// 3e-15; corners of regular shapes, which lie on a circle, stay as they are.
const COCIRCULAR: f64 = 1e-13;

/// Most flips per edge. Round regions of hundreds of corners need more to become Delaunay: the number grows with the
/// corners. By then no triangle is thin by much (bench `one_cell`).
const FLIPS_PER_EDGE: usize = 6;

/// Triangles, and which of them have an edge in common.
#[derive(Default)]
pub(crate) struct Mesh {
    triangles: Vec<Triangle>,
    /// By edge, its sides: four times a triangle plus the corner that the side starts from.
    sides: Vec<[u32; 2]>,
    /// Edges that were or will be tested, in order, and by edge, whether it will be.
    queue: Vec<u32>,
    waits: Vec<bool>,
}

/// Counter-clockwise corners, and the edge from each to the next. The fourth place stays free: no index needs a check.
#[derive(Clone, Copy)]
struct Triangle {
    corners: [u32; 4],
    edges: [u32; 4],
}

impl Triangle {
    fn new([a, b, c]: [u32; 3], [ab, bc, ca]: [u32; 3]) -> Self {
        Self { corners: [a, b, c, NONE], edges: [ab, bc, ca, NONE] }
    }
}

impl Mesh {
    pub(crate) fn clear(&mut self) {
        self.triangles.clear();
        self.sides.clear();
    }

    pub(crate) fn triangles(&self) -> impl ExactSizeIterator<Item = [u32; 3]> + '_ {
        self.triangles.iter().map(|&Triangle { corners: [a, b, c, _], .. }| [a, b, c])
    }

    /// Adds an edge that has no sides yet.
    pub(crate) fn add_edge(&mut self) -> u32 {
        self.sides.push([NONE; 2]);
        self.sides.len() as u32 - 1
    }

    /// Adds a triangle with the edges from each of its corners to the next.
    #[inline(always)]
    pub(crate) fn add(&mut self, corners: [u32; 3], edges: [u32; 3]) {
        let first = 4 * self.triangles.len() as u32;
        self.triangles.push(Triangle::new(corners, edges));
        for (side, edge) in (first..).zip(edges) {
            self.replace(edge, NONE, side);
        }
    }

    #[inline(always)]
    fn replace(&mut self, edge: u32, old: u32, new: u32) {
        if edge != BORDER {
            let sides = &mut self.sides[edge as usize];
            let at = usize::from(sides[0] != old);
            sides[at] = new;
        }
    }

    /// Flips edges until none has a vertex inside a circle through its other side, or there were too many flips. First
    /// come first served: it takes three quarters of the flips that the last first takes.
    pub(crate) fn flip(&mut self, points: &[DVec2]) {
        let count = self.sides.len();
        self.queue.clear();
        self.queue.extend(0..count as u32);
        self.waits.clear();
        self.waits.resize(count, true);
        let (mut at, mut left) = (0, FLIPS_PER_EDGE * count);
        widest(
            #[inline(always)]
            || {
                while at < self.queue.len() && left > 0 {
                    let edge = self.queue[at];
                    self.waits[edge as usize] = false;
                    left -= usize::from(self.flip_edge(points, edge));
                    at += 1;
                }
            },
        );
    }

    /// Flips one edge, if that is better, and puts the edges around it into the queue. Returns whether it did.
    #[inline(always)]
    fn flip_edge(&mut self, points: &[DVec2], edge: u32) -> bool {
        let [first, second] = self.sides[edge as usize];
        if second == NONE {
            return false;
        }
        let [t, s] = [first, second].map(|side| (side / 4) as usize);
        let [k, l] = [first, second].map(|side| (side % 4) as usize);
        let (one, other) = (self.triangles[t], self.triangles[s]);
        let [a, b, c] = [k, AFTER[k], BEFORE[k]].map(|x| one.corners[x]);
        let d = other.corners[BEFORE[l]];
        let [pa, pb, pc, pd] = [a, b, c, d].map(|v| points[v as usize]);
        let [reach_a, reach_b, reach_c] = [pa, pb, pc].map(|p| (p - pd).length_squared());
        let reach = larger(larger(reach_a, reach_b), reach_c);
        if in_circle(pa, pb, pc, pd) <= COCIRCULAR * reach * reach
            || orient2d(pc, pa, pd) <= 0.0
            || orient2d(pd, pb, pc) <= 0.0
        {
            return false;
        }
        let [bc, ca] = [AFTER[k], BEFORE[k]].map(|x| one.edges[x]);
        let [ad, db] = [AFTER[l], BEFORE[l]].map(|x| other.edges[x]);
        let (of_t, of_s) = (first - k as u32, second - l as u32);
        self.replace(ca, of_t + BEFORE[k] as u32, of_t);
        self.replace(ad, of_s + AFTER[l] as u32, of_t + 1);
        self.replace(db, of_s + BEFORE[l] as u32, of_s);
        self.replace(bc, of_t + AFTER[k] as u32, of_s + 1);
        self.sides[edge as usize] = [of_t + 2, of_s + 2];
        self.triangles[t] = Triangle::new([c, a, d], [ca, ad, edge]);
        self.triangles[s] = Triangle::new([d, b, c], [db, bc, edge]);
        for around in [ca, ad, db, bc] {
            if around != BORDER && !self.waits[around as usize] {
                self.waits[around as usize] = true;
                self.queue.push(around);
            }
        }
        true
    }
}

const AFTER: [usize; 4] = [1, 2, 0, 0];
const BEFORE: [usize; 4] = [2, 0, 1, 0];

/// Positive when `p` lies inside the circle through the counter-clockwise `a`, `b`, `c`. Rounded: it only guides
/// quality.
#[inline(always)]
pub(crate) fn in_circle(a: DVec2, b: DVec2, c: DVec2, p: DVec2) -> f64 {
    let (a, b, c) = (a - p, b - p, c - p);
    a.length_squared() * b.perp_dot(c) - b.length_squared() * a.perp_dot(c) + c.length_squared() * a.perp_dot(b)
}
