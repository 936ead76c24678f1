//! A polygon -> strictly positive triangles with the same boundary, or a refusal.
//!
//! Methods: two chains that face each other are zipped, and the in-circle test chooses the side to advance. Other
//! polygons lose their best ear first; an ear whose circumcircle holds another vertex waits. Both come close to the
//! Delaunay triangulation at a fraction of its cost.

use crate::math::predicates::orient2d;
use glam::DVec2;

/// Largest polygon for ear clipping, which takes quadratic time: 0.05 us per vertex at 16 vertices, 0.11 at 40, 0.27 to
/// 0.44 at 96 (bench `one_cell`, round and spiky polygons). The constrained Delaunay triangulation takes 0.3 to 0.6 at
/// any size. Half the limit would double the time of polygons in between; twice the limit would make spiky ones twice
/// as slow as that triangulation.
pub(crate) const EAR_LIMIT: usize = 96;

/// Factor on the quality of an ear whose circumcircle is not empty: it waits for all Delaunay ears.
const NOT_DELAUNAY: f64 = 1e-9;

/// In-circle determinants below this count as empty, so that cocircular corners of regular shapes do not wait.
const COCIRCULAR: f64 = 1e-12;

/// A polygon under construction, and the buffers to triangulate it.
#[derive(Default)]
pub(crate) struct EarPolygon {
    pub(crate) ids: Vec<u32>,
    pub(crate) points: Vec<DVec2>,
    /// The first `zip` vertices and the others are two chains that face each other; 0 if they are not.
    pub(crate) zip: usize,
    ears: Ears,
}

/// Linked polygon vertices with the turn and the quality of the ear at each.
struct Ears {
    next: [u8; EAR_LIMIT],
    prev: [u8; EAR_LIMIT],
    turn: [f64; EAR_LIMIT],
    quality: [f64; EAR_LIMIT],
}

impl Default for Ears {
    fn default() -> Self {
        Self { next: [0; EAR_LIMIT], prev: [0; EAR_LIMIT], turn: [0.0; EAR_LIMIT], quality: [0.0; EAR_LIMIT] }
    }
}

/// Quality where no positive triangle can be cut off.
const NO_EAR: f64 = -1.0;
/// Quality of an ear that holds a vertex. It is rated again after the next ear is cut.
const BLOCKED: f64 = -2.0;

impl EarPolygon {
    pub(crate) fn clear(&mut self) {
        self.ids.clear();
        self.points.clear();
        self.zip = 0;
    }

    /// Appends a vertex; a repeated vertex is skipped, and a spike v, w, v becomes v. Neither changes the boundary as a
    /// chain.
    #[inline(always)]
    pub(crate) fn push(&mut self, id: u32, point: DVec2) {
        let n = self.ids.len();
        if n > 0 && self.ids[n - 1] == id {
            return;
        }
        if n > 1 && self.ids[n - 2] == id {
            self.ids.pop();
            self.points.pop();
            return;
        }
        self.push_distinct(id, point);
    }

    /// Appends a vertex known to differ from the last two.
    #[inline(always)]
    pub(crate) fn push_distinct(&mut self, id: u32, point: DVec2) {
        self.ids.push(id);
        self.points.push(point);
    }

    /// Removes repeated vertices and spikes across the closing edge. Clears a polygon of fewer than three vertices.
    #[inline(always)]
    pub(crate) fn close(&mut self) {
        loop {
            let n = self.ids.len();
            if n < 3 {
                self.clear();
                return;
            }
            let drop_last = if self.ids[n - 1] == self.ids[0] {
                1
            } else if self.ids[n - 2] == self.ids[0] {
                2
            } else if self.ids[n - 1] == self.ids[1] {
                self.ids.remove(0);
                self.points.remove(0);
                1
            } else {
                return;
            };
            let n = self.ids.len();
            self.ids.truncate(n - drop_last);
            self.points.truncate(n - drop_last);
        }
    }

    /// Appends strictly positive triangles whose boundary is the polygon's. Returns false, and appends nothing, if that
    /// fails. A polygon without vertices has no triangles.
    #[inline]
    pub(crate) fn triangulate(&mut self, out: &mut Vec<[u32; 3]>) -> bool {
        let n = self.ids.len();
        match n {
            0..=2 => return true,
            3 => {
                let is_positive = orient2d(self.points[0], self.points[1], self.points[2]) > 0.0;
                if is_positive {
                    self.emit(out, 0, 1, 2);
                }
                return is_positive;
            }
            4 => return self.quad(out, [0, 1, 2, 3]),
            _ => {}
        }
        let before = out.len();
        if self.zip > 0 {
            if self.zipper(out) {
                return true;
            }
            out.truncate(before);
        }
        let done = n <= EAR_LIMIT && self.clip_ears(out);
        if !done {
            out.truncate(before);
        }
        done
    }

    #[inline(always)]
    fn emit(&self, out: &mut Vec<[u32; 3]>, a: usize, b: usize, c: usize) {
        out.push([self.ids[a], self.ids[b], self.ids[c]]);
    }

    /// Splits a quadrilateral along the better diagonal, judged by its worse triangle.
    #[inline(always)]
    fn quad(&self, out: &mut Vec<[u32; 3]>, corners: [usize; 4]) -> bool {
        let [a, b, c, d] = corners;
        let [pa, pb, pc, pd] = corners.map(|k| self.points[k]);
        let (abc, acd) = (orient2d(pa, pb, pc), orient2d(pa, pc, pd));
        let (bcd, bda) = (orient2d(pb, pc, pd), orient2d(pb, pd, pa));
        let worse = |t: f64, u: f64, t_quality: f64, u_quality: f64| {
            if t > 0.0 && u > 0.0 { t_quality.min(u_quality) } else { NO_EAR }
        };
        let first = worse(abc, acd, quality(pa, pb, pc, abc), quality(pa, pc, pd, acd));
        let second = worse(bcd, bda, quality(pb, pc, pd, bcd), quality(pb, pd, pa, bda));
        if first < 0.0 && second < 0.0 {
            return false;
        }
        if first >= second {
            self.emit(out, a, b, c);
            self.emit(out, a, c, d);
        } else {
            self.emit(out, b, c, d);
            self.emit(out, b, d, a);
        }
        true
    }

    /// Advances along both chains from the edge between them, cutting off a positive triangle at each step.
    #[inline(always)]
    fn zipper(&self, out: &mut Vec<[u32; 3]>) -> bool {
        let n = self.ids.len();
        let (p, ids) = (&self.points[..n], &self.ids[..n]);
        let (mut i, mut j) = (self.zip - 1, self.zip);
        let (mut a, mut b) = (p[i], p[j]);
        loop {
            let (left, right) = (i > 0, j + 1 < n);
            if !left && !right {
                return true;
            }
            let left_turn = if left { orient2d(p[i - 1], a, b) } else { NO_EAR };
            let right_turn = if right { orient2d(a, b, p[j + 1]) } else { NO_EAR };
            let advance_left = if left_turn > 0.0 && right_turn > 0.0 {
                in_circle(p[i - 1], a, b, p[j + 1]) <= 0.0
            } else if left_turn > 0.0 || right_turn > 0.0 {
                left_turn > 0.0
            } else {
                return false;
            };
            if advance_left {
                out.push([ids[i - 1], ids[i], ids[j]]);
                i -= 1;
                a = p[i];
            } else {
                out.push([ids[i], ids[j], ids[j + 1]]);
                j += 1;
                b = p[j];
            }
        }
    }

    /// Cuts ears off, and splits the quadrilateral that is left.
    fn clip_ears(&mut self, out: &mut Vec<[u32; 3]>) -> bool {
        let n = self.ids.len();
        let mut not_convex = 0;
        for b in 0..n {
            self.ears.prev[b] = (if b == 0 { n - 1 } else { b - 1 }) as u8;
            self.ears.next[b] = (if b + 1 == n { 0 } else { b + 1 }) as u8;
            self.rate(b);
            not_convex += usize::from(self.ears.turn[b] <= 0.0);
        }
        let (mut start, mut left) = (0, n);
        while left > 4 {
            let Some(best) = self.best_ear(start, left) else { return false };
            let (a, c) = (self.prev(best), self.next(best));
            if not_convex > 0 && self.holds_vertex(a, best, c) {
                self.ears.quality[best] = BLOCKED;
                continue;
            }
            if self.ears.quality[best] > NOT_DELAUNAY && self.circle_holds_vertex(a, best, c) {
                self.ears.quality[best] *= NOT_DELAUNAY;
                continue;
            }
            self.emit(out, a, best, c);
            self.ears.next[a] = c as u8;
            self.ears.prev[c] = a as u8;
            (start, left) = (c, left - 1);
            for b in [a, c] {
                not_convex -= usize::from(self.ears.turn[b] <= 0.0);
                self.rate(b);
                not_convex += usize::from(self.ears.turn[b] <= 0.0);
            }
            self.unblock(start, left);
        }
        let (b, d) = (self.next(start), self.prev(start));
        self.quad(out, [start, b, self.next(b), d])
    }

    fn next(&self, k: usize) -> usize {
        usize::from(self.ears.next[k])
    }

    fn prev(&self, k: usize) -> usize {
        usize::from(self.ears.prev[k])
    }

    /// Updates turn and quality of the ear at `b`.
    fn rate(&mut self, b: usize) {
        let (pa, pb, pc) = (self.points[self.prev(b)], self.points[b], self.points[self.next(b)]);
        let turn = orient2d(pa, pb, pc);
        self.ears.turn[b] = turn;
        self.ears.quality[b] = if turn > 0.0 { quality(pa, pb, pc, turn) } else { NO_EAR };
    }

    fn best_ear(&self, start: usize, left: usize) -> Option<usize> {
        let (mut best, mut best_quality) = (None, 0.0);
        let mut b = start;
        for _ in 0..left {
            if self.ears.quality[b] > best_quality {
                (best, best_quality) = (Some(b), self.ears.quality[b]);
            }
            b = self.next(b);
        }
        best
    }

    /// Whether a vertex that is not convex lies in the closed ear. Repetitions of the ear's own vertices do not count.
    fn holds_vertex(&self, a: usize, b: usize, c: usize) -> bool {
        let [pa, pb, pc] = [a, b, c].map(|k| self.points[k]);
        let mut r = self.next(c);
        while r != a {
            let (p, id) = (self.points[r], self.ids[r]);
            if self.ears.turn[r] <= 0.0
                && id != self.ids[a]
                && id != self.ids[b]
                && id != self.ids[c]
                && orient2d(pc, pa, p) >= 0.0
                && orient2d(pa, pb, p) >= 0.0
                && orient2d(pb, pc, p) >= 0.0
            {
                return true;
            }
            r = self.next(r);
        }
        false
    }

    fn circle_holds_vertex(&self, a: usize, b: usize, c: usize) -> bool {
        let [pa, pb, pc] = [a, b, c].map(|k| self.points[k]);
        let mut r = self.next(c);
        while r != a {
            if in_circle(pa, pb, pc, self.points[r]) > COCIRCULAR {
                return true;
            }
            r = self.next(r);
        }
        false
    }

    fn unblock(&mut self, start: usize, left: usize) {
        let mut b = start;
        for _ in 0..left {
            if self.ears.quality[b] == BLOCKED {
                self.rate(b);
            }
            b = self.next(b);
        }
    }
}

/// Twice the area over the sum of the squared sides: largest for the equilateral triangle.
#[inline(always)]
fn quality(a: DVec2, b: DVec2, c: DVec2, turn: f64) -> f64 {
    turn / (a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a))
}

/// Positive when `p` lies inside the circle through the counter-clockwise `a`, `b`, `c`. Rounded: it only guides
/// quality.
#[inline(always)]
pub(crate) fn in_circle(a: DVec2, b: DVec2, c: DVec2, p: DVec2) -> f64 {
    let (a, b, c) = (a - p, b - p, c - p);
    a.length_squared() * b.perp_dot(c) - b.length_squared() * a.perp_dot(c) + c.length_squared() * a.perp_dot(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(points: &[(f64, f64)]) -> EarPolygon {
        let mut polygon = EarPolygon::default();
        for (id, &(x, y)) in points.iter().enumerate() {
            polygon.push(id as u32, DVec2::new(x, y));
        }
        polygon.close();
        polygon
    }

    #[test]
    fn spikes_and_repeats_vanish() {
        let mut polygon = EarPolygon::default();
        for id in [3, 1, 1, 2, 1, 4, 5, 4, 3, 9, 3] {
            polygon.push(id, DVec2::new(f64::from(id), f64::from(id * id)));
        }
        polygon.close();
        assert_eq!(polygon.ids, [3, 1, 4]);
        polygon.clear();
        for id in [7, 8, 7] {
            polygon.push(id, DVec2::ZERO);
        }
        polygon.close();
        assert!(polygon.ids.is_empty() && polygon.points.is_empty());
    }

    #[test]
    fn triangles_have_the_area_of_the_polygon() {
        let arrow = [(0.0, 0.0), (4.0, 1.0), (0.0, 2.0), (1.5, 1.2), (1.0, 1.0), (1.5, 0.8)];
        for count in 3..=arrow.len() {
            let mut out = Vec::new();
            let mut polygon = polygon(&arrow[..count]);
            let want: f64 = (0..count).map(|k| polygon.points[k].perp_dot(polygon.points[(k + 1) % count])).sum();
            assert!(polygon.triangulate(&mut out), "simple and counter-clockwise");
            let turn = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|v| polygon.points[v as usize]);
                (b - a).perp_dot(c - a)
            };
            let area: f64 = out.iter().map(turn).sum();
            assert!((area - want).abs() < 1e-12, "{area} instead of {want}");
            assert_eq!(out.len(), count - 2);
        }
    }

    #[test]
    fn polygons_that_are_not_simple_are_refused_and_append_nothing() {
        let clockwise = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.5, 0.5), (1.0, 0.0)];
        let bow_tie = [(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)];
        let flat = [(0.0, 0.0), (1.0, 0.0), (3.0, 0.0), (2.0, 0.0), (1.5, 0.0)];
        for points in [&clockwise[..], &clockwise[..4], &clockwise[..3], &bow_tie, &flat, &flat[..4], &flat[..3]] {
            for zip in [0, 2] {
                let mut polygon = polygon(points);
                polygon.zip = zip;
                let mut out = vec![[9; 3]];
                assert!(!polygon.triangulate(&mut out), "{points:?}");
                assert_eq!(out, [[9; 3]]);
            }
        }
    }

    #[test]
    fn chains_are_zipped_whatever_their_length() {
        let count = 4 * EAR_LIMIT;
        let mut polygon = EarPolygon::default();
        let half = count / 2;
        for k in 0..half {
            polygon.push(k as u32, DVec2::new(k as f64, 0.1 * (k as f64).sin()));
        }
        for k in (0..half).rev() {
            polygon.push((count - 1 - k) as u32, DVec2::new(k as f64 + 0.3, 1.0 + 0.1 * (k as f64).cos()));
        }
        let mut out = Vec::new();
        assert!(!polygon.triangulate(&mut out), "too long for ears");
        polygon.zip = half;
        assert!(polygon.triangulate(&mut out));
        assert_eq!(out.len(), count - 2);
    }
}
