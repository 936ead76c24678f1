//! A polygon and its holes -> one polygon, by slits: edges there and back between a vertex of a hole and one of the
//! polygon.
//!
//! Slits are the shortest connections that grow a tree from the outer polygon (Prim, "Shortest connection networks and
//! some generalizations", 1957), so they are edges of the vertices' Delaunay triangulation. They may cross other edges
//! without being checked: their two directions cancel, so if all triangles are positive the region is covered once in
//! any case.

use super::input::{NONE, TrimInput};
use super::triangulate::{EAR_LIMIT, EarPolygon};
use crate::math::polygon::double_area;
use crate::math::predicates::{Side, side_of};
use glam::DVec2;
use std::ops::Range;

/// Largest polygon with holes, slits counted twice. With holes, ear clipping costs 0.20 us per vertex at 28 vertices,
/// 0.27 at 44 and 0.5 at 80 (one or nine round holes in a plane); the constrained Delaunay triangulation costs 0.45 to
/// 0.6.
const SLIT_LIMIT: usize = 72;

/// Work space of [`Slits::join_holes`].
#[derive(Default)]
pub(crate) struct Slits {
    holes: Vec<Range<u32>>,
    /// By hole vertex, in the order of `holes`: the nearest vertex of the polygon.
    nearest: Vec<Nearest>,
}

#[derive(Clone, Copy)]
struct Nearest {
    /// Squared.
    distance: f64,
    polygon_id: u32,
    /// The tessellant, and its loop as an index into `holes`.
    tessellant: u32,
    hole: u32,
}

impl Slits {
    /// Joins the loops to the polygon that surrounds them. An empty polygon starts as the one loop that runs
    /// counter-clockwise.
    ///
    /// Returns false if there is no such loop, if there is another counter-clockwise one, or if there are too many
    /// vertices for ear clipping. The content of the polygon is then unspecified.
    pub(crate) fn join_holes(
        &mut self,
        tile: &TrimInput<'_>,
        loops: impl Iterator<Item = u32>,
        polygon: &mut EarPolygon,
    ) -> bool {
        self.holes.clear();
        let mut vertices = polygon.ids.len();
        polygon.zip = 0;
        for l in loops {
            let ends = tile.loop_starts[l as usize]..tile.loop_starts[l as usize + 1];
            let points = &tile.points[ends.start as usize..ends.end as usize];
            vertices += points.len() + 2;
            if vertices > EAR_LIMIT {
                return false;
            }
            if double_area(points) < 0.0 {
                self.holes.push(ends);
            } else if polygon.ids.is_empty() {
                for (id, &point) in ends.zip(points) {
                    polygon.push_distinct(id, point);
                }
            } else {
                return false;
            }
        }
        if polygon.ids.is_empty() || (vertices > SLIT_LIMIT && !self.holes.is_empty()) {
            return false;
        }
        self.nearest.clear();
        for (hole, ends) in self.holes.iter().enumerate() {
            let far = |tessellant| Nearest { distance: f64::INFINITY, polygon_id: NONE, tessellant, hole: hole as u32 };
            self.nearest.extend(ends.clone().map(far));
        }
        let mut fresh = 0..polygon.ids.len();
        while !self.nearest.is_empty() {
            let Some(slit) = self.shortest(tile, polygon, fresh) else { return false };
            let at = occurrence(polygon, slit.polygon_id, tile.points[slit.tessellant as usize]);
            let ends = self.holes[slit.hole as usize].clone();
            fresh = splice(tile, polygon, at, ends, slit.tessellant);
            self.nearest.retain(|n| n.hole != slit.hole);
        }
        true
    }

    /// Compares the vertices of the remaining holes with the `fresh` part of the polygon, and returns the nearest of
    /// all.
    fn shortest(&mut self, tile: &TrimInput<'_>, polygon: &EarPolygon, fresh: Range<usize>) -> Option<Nearest> {
        let mut shortest: Option<Nearest> = None;
        for nearest in &mut self.nearest {
            let from = tile.points[nearest.tessellant as usize];
            for at in fresh.clone() {
                let distance = from.distance_squared(polygon.points[at]);
                if distance < nearest.distance {
                    (nearest.distance, nearest.polygon_id) = (distance, polygon.ids[at]);
                }
            }
            if shortest.is_none_or(|s| nearest.distance < s.distance) {
                shortest = Some(*nearest);
            }
        }
        shortest
    }
}

/// Index of a vertex in the polygon. Slits make it occur several times: this is the one whose inner angle contains
/// `towards`.
fn occurrence(polygon: &EarPolygon, id: u32, towards: DVec2) -> usize {
    let n = polygon.ids.len();
    let faces = |at: usize| {
        let [prev, here, next] = [(at + n - 1) % n, at, (at + 1) % n].map(|k| polygon.points[k]);
        let left_of_in = side_of(prev, here, towards) == Side::Left;
        let left_of_out = side_of(here, next, towards) == Side::Left;
        if side_of(prev, here, next) == Side::Left { left_of_in && left_of_out } else { left_of_in || left_of_out }
    };
    let mut places = (0..n).filter(|&at| polygon.ids[at] == id);
    let first = places.next().unwrap_or(0);
    if faces(first) { first } else { places.find(|&at| faces(at)).unwrap_or(first) }
}

/// Inserts the hole after vertex `at`: from its vertex `entry` around to `entry` and back to `at`. Returns the range of
/// its vertices.
fn splice(tile: &TrimInput<'_>, polygon: &mut EarPolygon, at: usize, hole: Range<u32>, entry: u32) -> Range<usize> {
    let (id, point) = (polygon.ids[at], polygon.points[at]);
    let around = (entry..hole.end).chain(hole.start..=entry);
    for v in around {
        polygon.push_distinct(v, tile.points[v as usize]);
    }
    polygon.push_distinct(id, point);
    let added = hole.len() + 2;
    polygon.ids[at + 1..].rotate_right(added);
    polygon.points[at + 1..].rotate_right(added);
    at + 1..at + 1 + hole.len()
}
