//! A polygon, with loops inside it if it has any -> strictly positive triangles with the same boundary, or a refusal.
//!
//! Methods: two chains that face each other are zipped, and the in-circle test chooses the side to advance. Others are
//! swept.

use super::input::TrimInput;
use super::levels::Levels;
use crate::math::lanes::smaller;
use crate::math::predicates::orient2d;
use glam::DVec2;

/// A vertex of a polygon.
#[derive(Clone, Copy)]
pub(crate) struct Corner {
    pub(crate) id: u32,
    point: DVec2,
}

/// A polygon under construction, and the buffers to triangulate it.
#[derive(Default)]
pub(crate) struct Polygon {
    pub(crate) corners: Vec<Corner>,
    /// The first `zip` vertices and the others are two chains that face each other; 0 if they are not.
    pub(crate) zip: usize,
    /// Where each loop starts.
    starts: Vec<u32>,
    /// The points of the corners, for the sweep.
    points: Vec<DVec2>,
    levels: Levels,
}

/// Quality where no positive triangle can be cut off.
const NO_EAR: f64 = -1.0;
impl Polygon {
    pub(crate) fn clear(&mut self) {
        self.corners.clear();
        self.starts.clear();
        self.zip = 0;
    }

    /// Begins another loop: a hole in the region so far, an island in a hole, or a region beside it.
    pub(crate) fn begin_loop(&mut self) {
        self.starts.push(self.corners.len() as u32);
        self.zip = 0;
    }

    /// Adds a loop of the tile's.
    pub(crate) fn add_loop(&mut self, tile: &TrimInput<'_>, index: u32) {
        let [start, end] = tile.ends(index);
        self.begin_loop();
        self.corners.extend((start..end).map(|id| Corner { id, point: tile.points[id as usize] }));
    }

    /// Appends a vertex; a repeated vertex is skipped, and a spike v, w, v becomes v. Neither changes the boundary as a
    /// chain.
    #[inline(always)]
    pub(crate) fn push(&mut self, id: u32, point: DVec2) {
        let n = self.corners.len();
        if n > 0 && self.corners[n - 1].id == id {
            return;
        }
        if n > 1 && self.corners[n - 2].id == id {
            self.corners.pop();
            return;
        }
        self.push_distinct(id, point);
    }

    /// Appends a vertex known to differ from the last two.
    #[inline(always)]
    pub(crate) fn push_distinct(&mut self, id: u32, point: DVec2) {
        self.corners.push(Corner { id, point });
    }

    /// Removes repeated vertices and spikes across the closing edge. Clears a polygon of fewer than three vertices.
    #[inline(always)]
    pub(crate) fn close(&mut self) {
        loop {
            let n = self.corners.len();
            if n < 3 {
                self.clear();
                return;
            }
            let id = |k: usize| self.corners[k].id;
            let drop_last = if id(n - 1) == id(0) {
                1
            } else if id(n - 2) == id(0) {
                2
            } else if id(n - 1) == id(1) {
                self.corners.remove(0);
                1
            } else {
                return;
            };
            self.corners.truncate(self.corners.len() - drop_last);
        }
    }

    /// Appends strictly positive triangles whose boundary is the polygon's. Returns false, and appends nothing, if that
    /// fails. A polygon without vertices has no triangles.
    #[inline]
    pub(crate) fn triangulate(&mut self, out: &mut Vec<[u32; 3]>) -> bool {
        if self.zip > 0 && self.corners.len() > 4 {
            let before = out.len();
            if self.zipper(out) {
                return true;
            }
            out.truncate(before);
        }
        let Self { corners, starts, points, levels, .. } = self;
        let corners = &corners[..];
        let name = |v: u32| corners[v as usize].id;
        triangulate_few((corners.len(), starts.len()), |v| corners[v].point, name, out).unwrap_or_else(|| {
            points.clear();
            points.extend(corners.iter().map(|corner| corner.point));
            let starts = if starts.is_empty() { &[0][..] } else { &starts[..] };
            sweep(levels, (points, starts), name, out)
        })
    }

    /// As [`triangulate`](Self::triangulate), for all loops of a tile.
    pub(crate) fn triangulate_tile(&mut self, tile: &TrimInput<'_>, out: &mut Vec<[u32; 3]>) -> bool {
        let starts = &tile.loop_starts[..tile.loop_starts.len() - 1];
        let points = tile.points;
        triangulate_few((points.len(), starts.len()), |v| points[v], |v| v, out)
            .unwrap_or_else(|| sweep(&mut self.levels, (points, starts), |v| v, out))
    }

    /// Advances along both chains from the edge between them, cutting off a positive triangle at each step.
    #[inline(always)]
    fn zipper(&self, out: &mut Vec<[u32; 3]>) -> bool {
        let corners = &self.corners[..];
        let n = corners.len();
        let p = |k: usize| corners[k].point;
        let (mut i, mut j) = (self.zip - 1, self.zip);
        let (mut a, mut b) = (p(i), p(j));
        loop {
            let (left, right) = (i > 0, j + 1 < n);
            if !left && !right {
                return true;
            }
            let left_turn = if left { orient2d(p(i - 1), a, b) } else { NO_EAR };
            let right_turn = if right { orient2d(a, b, p(j + 1)) } else { NO_EAR };
            let advance_left = if left_turn > 0.0 && right_turn > 0.0 {
                in_circle(p(i - 1), a, b, p(j + 1)) <= 0.0
            } else if left_turn > 0.0 || right_turn > 0.0 {
                left_turn > 0.0
            } else {
                return false;
            };
            if advance_left {
                out.push([i - 1, i, j].map(|k| corners[k].id));
                i -= 1;
                a = p(i);
            } else {
                out.push([i, j, j + 1].map(|k| corners[k].id));
                j += 1;
                b = p(j);
            }
        }
    }
}

/// Triangulates a loop of three or four points, which has these places and names; fewer points have no triangles.
/// Returns whether that succeeds, `None` if there are more points or more loops: the sweep takes these.
#[inline(always)]
fn triangulate_few(
    (points, loops): (usize, usize),
    at: impl Fn(usize) -> DVec2,
    name: impl Fn(u32) -> u32,
    out: &mut Vec<[u32; 3]>,
) -> Option<bool> {
    match (points, loops) {
        (0..=2, _) => Some(true),
        (3, 0..=1) => {
            let is_positive = orient2d(at(0), at(1), at(2)) > 0.0;
            out.extend(is_positive.then(|| [0, 1, 2].map(name)));
            Some(is_positive)
        }
        (4, 0..=1) => {
            let halves = quad([0, 1, 2, 3].map(at));
            if let Some(halves) = halves {
                halves.iter().for_each(|t| out.push(t.map(&name)));
            }
            Some(halves.is_some())
        }
        _ => None,
    }
}

/// Triangulates the region of loops of points that start at `starts`, with these names for their points.
fn sweep(
    levels: &mut Levels,
    (points, starts): (&[DVec2], &[u32]),
    name: impl Fn(u32) -> u32,
    out: &mut Vec<[u32; 3]>,
) -> bool {
    levels.triangulate(points, starts).is_ok_and(|triangles| {
        out.extend(triangles.map(|t| t.map(&name)));
        true
    })
}

/// Splits a quadrilateral along the better diagonal, judged by its worse triangle. `None` if both have one that is not
/// positive.
#[inline(always)]
fn quad([a, b, c, d]: [DVec2; 4]) -> Option<[[u32; 3]; 2]> {
    let (abc, acd) = (orient2d(a, b, c), orient2d(a, c, d));
    let (bcd, bda) = (orient2d(b, c, d), orient2d(b, d, a));
    let [ab, bc, cd, da] = [(a, b), (b, c), (c, d), (d, a)].map(|(from, to)| from.distance_squared(to));
    let (ca, db) = (c.distance_squared(a), d.distance_squared(b));
    // Twice the area over the sum of the squared sides: largest for the equilateral triangle.
    let worse = |(t, t_sides): (f64, f64), (u, u_sides): (f64, f64)| {
        if t > 0.0 && u > 0.0 { smaller(t / t_sides, u / u_sides) } else { NO_EAR }
    };
    let first = worse((abc, ab + bc + ca), (acd, ca + cd + da));
    let second = worse((bcd, bc + cd + db), (bda, db + da + ab));
    if first < 0.0 && second < 0.0 {
        return None;
    }
    Some(if first >= second { [[0, 1, 2], [0, 2, 3]] } else { [[1, 2, 3], [1, 3, 0]] })
}

/// Positive when `p` lies inside the circle through the counter-clockwise `a`, `b`, `c`. Rounded: it only guides
/// quality.
#[inline(always)]
fn in_circle(a: DVec2, b: DVec2, c: DVec2, p: DVec2) -> f64 {
    let (a, b, c) = (a - p, b - p, c - p);
    a.length_squared() * b.perp_dot(c) - b.length_squared() * a.perp_dot(c) + c.length_squared() * a.perp_dot(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(points: &[(f64, f64)]) -> Polygon {
        let mut polygon = Polygon::default();
        for (id, &(x, y)) in points.iter().enumerate() {
            polygon.push(id as u32, DVec2::new(x, y));
        }
        polygon.close();
        polygon
    }

    #[test]
    fn spikes_and_repeats_vanish() {
        let mut polygon = Polygon::default();
        for id in [3, 1, 1, 2, 1, 4, 5, 4, 3, 9, 3] {
            polygon.push(id, DVec2::new(f64::from(id), f64::from(id * id)));
        }
        polygon.close();
        assert_eq!(polygon.corners.iter().map(|corner| corner.id).collect::<Vec<_>>(), [3, 1, 4]);
        polygon.clear();
        for id in [7, 8, 7] {
            polygon.push(id, DVec2::ZERO);
        }
        polygon.close();
        assert!(polygon.corners.is_empty());
    }

    #[test]
    fn triangles_have_the_area_of_the_polygon() {
        let arrow = [(0.0, 0.0), (4.0, 1.0), (0.0, 2.0), (1.5, 1.2), (1.0, 1.0), (1.5, 0.8)];
        for count in 3..=arrow.len() {
            let mut out = Vec::new();
            let mut polygon = polygon(&arrow[..count]);
            let at = |k: usize| polygon.corners[k].point;
            let want: f64 = (0..count).map(|k| at(k).perp_dot(at((k + 1) % count))).sum();
            assert!(polygon.triangulate(&mut out), "simple and counter-clockwise");
            let turn = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|v| polygon.corners[v as usize].point);
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
        let count = 400;
        let mut polygon = Polygon::default();
        let half = count / 2;
        for k in 0..half {
            polygon.push(k as u32, DVec2::new(k as f64, 0.1 * (k as f64).sin()));
        }
        for k in (0..half).rev() {
            polygon.push((count - 1 - k) as u32, DVec2::new(k as f64 + 0.3, 1.0 + 0.1 * (k as f64).cos()));
        }
        let mut out = Vec::new();
        polygon.zip = half;
        assert!(polygon.zipper(&mut out));
        assert_eq!(out.len(), count - 2);
    }
}
