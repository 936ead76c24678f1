//! Triangles with common edges -> triangles of the same boundary that come close to Delaunay's, by flips; and more
//! vertices for them.
//!
//! Method: Lawson, "Software for C1 surface interpolation", 1977. A flip is made only where the angles across from an
//! edge exceed half a turn by more than rounding could change. So each one is a true step towards the Delaunay
//! triangulation, which ends.

use super::input::NONE;
use crate::math::lanes::widest;
use crate::math::predicates::orient2d;
use glam::DVec2;
use std::ops::Range;

/// Stands for the other side of an edge of the boundary, and of an edge with one triangle so far.
pub(crate) const BORDER: u32 = u32::MAX;

/// An edge is flipped where the cotangents of the angles across from it add up to less than minus this. They add up to
/// zero where four corners lie on a circle: those of regular shapes stay as they are. So do others nearly on a circle,
/// where a flip gains little.
const GAIN: f64 = 1.0 / 32.0;

/// The share of a cosine that is added to its sine. [`GAIN`] times its square is 2.8e-13 of the product of the sides'
/// lengths. Rounding changes the test by less than 2.5e-15 of it: sines and cosines by 4 units in the last place each,
/// and their products. So each flip is a true step however thin the triangles are, and leaves positive triangles.
const TINY: f64 = 3e-6;

/// Exceeds what is lost where products are smaller than the least number, at distances below 1e-72.
const UNDERFLOW: f64 = 1e-290;

/// Most flips per edge, over all batches so far: the last batch joins sides of the border, and may need many. Long
/// regions between straight borders need more to become Delaunay: the number grows with the corners.
const FLIPS_PER_EDGE: usize = 6;

/// The edges of this many triangles are flipped before the next are looked at: with their points they fit the second
/// cache.
const AT_ONCE: usize = 4096;

/// Sides in the queue, a power of two. Should there be more, the oldest are not tested.
const QUEUE: usize = 1 << 14;

/// Triangles, and which of them have an edge in common. A *side* is an edge as seen from one of its triangles: four
/// times the triangle plus the corner that the side starts from.
#[derive(Default)]
pub(crate) struct Mesh {
    triangles: Vec<Triangle>,
    /// By edge that had no triangles when it was added, the first side that it got.
    open: Vec<u32>,
    /// `None` until something is flipped.
    queue: Option<Box<[u32; QUEUE]>>,
    /// Sides around a vertex that are still to be tested.
    around: Vec<u32>,
}

/// Counter-clockwise corners, and by side, from each corner to the next, the same edge's side in the next triangle.
/// With four places no index needs a check.
#[derive(Clone, Copy)]
struct Triangle {
    /// The fourth is a set of bits: the sides that are in the queue.
    corners: [u32; 4],
    twins: [u32; 4],
}

/// The place in [`Triangle::corners`] of the sides that are in the queue.
const WAITS: usize = 3;

impl Mesh {
    pub(crate) fn clear(&mut self) {
        self.triangles.clear();
        self.open.clear();
    }

    pub(crate) fn triangles(&self) -> impl ExactSizeIterator<Item = [u32; 3]> + '_ {
        self.triangles.iter().map(|&Triangle { corners: [a, b, c, _], .. }| [a, b, c])
    }

    pub(crate) fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Gives the vertices other names.
    pub(crate) fn rename(&mut self, name: impl Fn(u32) -> u32) {
        for Triangle { corners: [a, b, c, _], .. } in &mut self.triangles {
            [*a, *b, *c] = [*a, *b, *c].map(&name);
        }
    }

    /// Writes each side of the boundary to the place of the vertex that it starts from.
    pub(crate) fn list_border(&self, sides: &mut [u32]) {
        for (t, triangle) in self.triangles.iter().enumerate() {
            for k in (0..3).filter(|&k| triangle.twins[k] == BORDER) {
                sides[triangle.corners[k] as usize] = (4 * t + k) as u32;
            }
        }
    }

    /// Adds an edge that has no triangles yet. What it returns stands for both of its sides.
    pub(crate) fn add_edge(&mut self) -> u32 {
        self.open.push(NONE);
        4 * (self.open.len() as u32 - 1) + 3
    }

    /// Adds a triangle. `ab` and `bc` are the other sides of its first edges. Returns its third side.
    #[inline(always)]
    pub(crate) fn add(&mut self, [a, b, c]: [u32; 3], [ab, bc]: [u32; 2]) -> u32 {
        let first = 4 * self.triangles.len() as u32;
        let twins = [self.join(ab, first), self.join(bc, first + 1), BORDER, BORDER];
        self.triangles.push(Triangle { corners: [a, b, c, 0], twins });
        first + 2
    }

    /// Makes `side` the twin of a side, or the first side of an edge. Returns its own twin.
    #[inline(always)]
    fn join(&mut self, mut other: u32, side: u32) -> u32 {
        if other % 4 == 3 && other != BORDER {
            other = std::mem::replace(&mut self.open[(other / 4) as usize], side);
        }
        if other != BORDER {
            let (t, k) = place(other);
            self.triangles[t].twins[k] = side;
        }
        other
    }

    /// Adds triangles of a vertex between two others that follow each other on the boundary. `sides` are as from
    /// [`list_border`](Self::list_border), and are brought up to date.
    pub(crate) fn add_ears(&mut self, ears: &[[u32; 3]], sides: &mut [u32]) {
        for &[u, v, w] in ears {
            let first = 4 * self.triangles.len() as u32;
            let base = std::mem::replace(&mut sides[u as usize], first);
            sides[v as usize] = first + 1;
            let (t, k) = place(base);
            self.triangles[t].twins[k] = first + 2;
            self.triangles.push(Triangle { corners: [u, v, w, 0], twins: [BORDER, BORDER, base, BORDER] });
        }
    }

    /// Makes ears positive, one after the other, and flips edges of these and of the triangles before them until none
    /// gains by it, or there were too many flips. Returns false if one cannot be.
    pub(crate) fn insert_ears(&mut self, ears: Range<usize>, points: &[DVec2]) -> bool {
        let Self { triangles, around, .. } = self;
        let mut left = FLIPS_PER_EDGE * 2 * ears.len();
        widest(
            #[inline(always)]
            || {
                for t in ears {
                    if !insert_ear(triangles, points, t, around, &mut left) {
                        return false;
                    }
                }
                true
            },
        )
    }

    /// Flips edges until none gains by it, or there are too many flips. With `may_stop`, returns false as soon as there
    /// are too many; without, always true, and edges that wait then are not tested again.
    pub(crate) fn flip(&mut self, points: &[DVec2], may_stop: bool) -> bool {
        let Self { triangles, queue, .. } = self;
        let queue = queue.get_or_insert_with(|| Box::new([0; QUEUE]));
        widest(
            #[inline(always)]
            || {
                let mut left = 0;
                for start in (0..triangles.len()).step_by(AT_ONCE) {
                    let end = triangles.len().min(start + AT_ONCE);
                    if !flip_some(triangles, points, queue, start..end, &mut left) && may_stop {
                        return false;
                    }
                }
                true
            },
        )
    }
}

/// Puts the second corner of triangle `t` between the others, which are the ends of an edge of the boundary of those
/// before it. Then flips edges across from it where that gains. Cost: constant on average if the vertices come
/// in random order (Guibas, Knuth and Sharir, "Randomized incremental construction of Delaunay and Voronoi diagrams",
/// 1992); nearly so in halving steps along loops.
///
/// A triangle that is not positive covers what is outside: its edge has to be flipped. One of the two triangles that
/// come of it may not be positive either, if the vertex lies beyond the triangle behind the edge. Returns false if both
/// are not, or the edge has no triangle behind it.
#[inline(always)]
fn insert_ear(triangles: &mut [Triangle], points: &[DVec2], t: usize, around: &mut Vec<u32>, left: &mut usize) -> bool {
    let after = 4 * t as u32 + 4;
    let at = |v: u32| points[v as usize];
    let [pu, pv, pw] = [0, 1, 2].map(|k| at(triangles[t].corners[k]));
    // All sides from here on are across from the vertex.
    let mut side = after - 2;
    let mut is_positive = orient2d(pu, pv, pw) > 0.0;
    around.clear();
    while !is_positive {
        let (t, k) = place(side);
        let twin = triangles[t].twins[k];
        if twin >= after || *left == 0 {
            return false;
        }
        *left -= 1;
        let [pa, pb] = [k, AFTER[k]].map(|k| at(triangles[t].corners[k]));
        let next = flip_sides(triangles, side, twin);
        let pd = at(triangles[t].corners[k]);
        let halves = [orient2d(pd, pb, pv) > 0.0, orient2d(pv, pa, pd) > 0.0];
        if halves == [false; 2] {
            return false;
        }
        is_positive = halves == [true; 2];
        let [this, that] = if halves[0] { [next, side] } else { [side, next] };
        around.push(that);
        side = this;
    }
    loop {
        let (t, k) = place(side);
        let twin = triangles[t].twins[k];
        if twin < after && *left > 0 {
            let (s, l) = place(twin);
            let [pa, pb] = [k, AFTER[k]].map(|k| at(triangles[t].corners[k]));
            if is_better([pa, pb, pv], at(triangles[s].corners[BEFORE[l]])) {
                *left -= 1;
                around.push(flip_sides(triangles, side, twin));
                continue;
            }
        }
        let Some(next) = around.pop() else { return true };
        side = next;
    }
}

/// Flips edges among some triangles and those before them. First come first served: it takes three quarters of the
/// flips that the last first takes. Returns false if there are too many. `left`: flips left over by earlier batches.
///
/// Numbers of triangles are loaded and stored one by one: a load of a whole triangle would wait for the stores.
#[inline(always)]
fn flip_some(
    triangles: &mut [Triangle],
    points: &[DVec2],
    queue: &mut [u32; QUEUE],
    some: Range<usize>,
    left: &mut usize,
) -> bool {
    let mut queue = Queue { sides: queue, head: 0, tail: 0 };
    // Each edge once, when both of its triangles are there.
    for t in some {
        let mut waits = 0;
        for k in 0..3 {
            let side = 4 * t as u32 + k;
            let is_second = triangles[t].twins[k as usize] < side;
            queue.push_if(is_second, side);
            waits |= u32::from(is_second) << k;
        }
        triangles[t].corners[WAITS] = waits;
    }
    *left += FLIPS_PER_EDGE * queue.tail;
    while queue.head < queue.tail && *left > 0 {
        let side = queue.pop();
        if flip_edge(triangles, points, side, &mut queue) {
            *left -= 1;
        }
    }
    queue.head == queue.tail
}

/// Sides in order; the oldest are lost when there are too many.
struct Queue<'a> {
    sides: &'a mut [u32; QUEUE],
    head: usize,
    tail: usize,
}

impl Queue<'_> {
    #[inline(always)]
    fn push_if(&mut self, condition: bool, side: u32) {
        self.sides[self.tail % QUEUE] = side;
        self.tail += usize::from(condition);
    }

    /// The next side. There has to be one.
    #[inline(always)]
    fn pop(&mut self) -> u32 {
        let side = self.sides[self.head % QUEUE];
        self.head += 1;
        side
    }
}

/// Takes the edge of a side out of the queue. Flips it if that is better, and puts those around it into the queue.
/// Returns whether it did. Does nothing if the side is not in the queue: its edge moved, or was tested from its other
/// side.
#[inline(always)]
fn flip_edge(triangles: &mut [Triangle], points: &[DVec2], side: u32, queue: &mut Queue<'_>) -> bool {
    let (t, k) = place(side);
    let one = &mut triangles[t];
    if one.corners[WAITS] >> k & 1 == 0 {
        return false;
    }
    one.corners[WAITS] ^= 1 << k;
    let twin = one.twins[k];
    let corners = [k, AFTER[k], BEFORE[k]].map(|k| points[one.corners[k] as usize]);
    let (s, l) = place(twin);
    let other = &mut triangles[s];
    other.corners[WAITS] &= !(1 << l);
    if !is_better(corners, points[other.corners[BEFORE[l]] as usize]) {
        return false;
    }
    flip_sides(triangles, side, twin);
    for side in [side, twin] {
        let (t, k) = place(side);
        let triangle = &mut triangles[t];
        let mut waits = u32::from(triangle.twins[AFTER[k]] != BORDER) << AFTER[k];
        queue.push_if(waits & !triangle.corners[WAITS] != 0, side - k as u32 + AFTER[k] as u32);
        if triangle.twins[k] != BORDER {
            waits |= 1 << k;
            queue.push_if(true, side);
        }
        triangle.corners[WAITS] = waits;
    }
    true
}

/// Whether the edge from `a` to `b`, with `c` on its left and `d` on its right, is better flipped. Both triangles are
/// positive then: the angles at `c` and `d` exceed half a turn, so those at `a` and `b` do not.
#[inline(always)]
fn is_better([a, b, c]: [DVec2; 3], d: DVec2) -> bool {
    let (ca, cb, da, db) = (a - c, b - c, a - d, b - d);
    let (sin_c, cos_c) = (ca.perp_dot(cb), ca.dot(cb));
    let (sin_d, cos_d) = (db.perp_dot(da), db.dot(da));
    let least = GAIN * (sin_c + TINY * cos_c.abs()) * (sin_d + TINY * cos_d.abs());
    sin_c * cos_d + cos_c * sin_d < -least - UNDERFLOW
}

/// Flips the edge of two sides. Each triangle keeps the side after the edge's, and `side` is then across from the
/// corner that it was across from. Returns the other side that is.
#[inline(always)]
fn flip_sides(triangles: &mut [Triangle], side: u32, twin: u32) -> u32 {
    let ((t, k), (s, l)) = (place(side), place(twin));
    let d = triangles[s].corners[BEFORE[l]];
    let one = &mut triangles[t];
    let (c, ca) = (one.corners[BEFORE[k]], one.twins[BEFORE[k]]);
    one.corners[k] = d;
    one.twins[BEFORE[k]] = twin - l as u32 + BEFORE[l] as u32;
    let other = &mut triangles[s];
    let db = other.twins[BEFORE[l]];
    other.corners[l] = c;
    other.twins[BEFORE[l]] = side - k as u32 + BEFORE[k] as u32;
    // The edge's side gets one of the other triangle.
    for (t, k, side, outer) in [(t, k, side, db), (s, l, twin, ca)] {
        triangles[t].twins[k] = outer;
        if outer != BORDER {
            let (t, k) = place(outer);
            triangles[t].twins[k] = side;
        }
    }
    twin - l as u32 + AFTER[l] as u32
}

/// A side's triangle, and the corner that it starts from.
#[inline(always)]
fn place(side: u32) -> (usize, usize) {
    ((side / 4) as usize, (side % 4) as usize)
}

const AFTER: [usize; 4] = [1, 2, 0, 0];
const BEFORE: [usize; 4] = [2, 0, 1, 0];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::random::SplitMix;

    #[test]
    fn flips_of_thin_quadrilaterals_leave_positive_triangles_and_stay() {
        let mut draw = SplitMix(3);
        let mut random = || draw.unit();
        let mut flips = 0;
        for _ in 0..200_000 {
            // Corners near a line of any direction, down to where the line bends by rounding alone.
            let (thin, along) = (f64::exp2(-54.0 * random()), DVec2::from_angle(random()));
            let mut near = |from: f64| along * (from + random()) + along.perp() * thin * (random() - 0.5);
            let [a, b, c, d] = [0.0, 1.0, 0.5, 0.5].map(&mut near);
            if orient2d(a, b, c) > 0.0 && orient2d(b, a, d) > 0.0 && is_better([a, b, c], d) {
                assert!(orient2d(c, a, d) > 0.0 && orient2d(b, c, d) > 0.0, "{a}, {b}, {c}, {d}");
                assert!(!is_better([d, c, a], b), "{a}, {b}, {c}, {d}");
                flips += 1;
            }
        }
        assert!(flips > 20_000, "{flips}");
    }
}
