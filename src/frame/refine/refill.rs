//! The triangles around a fold -> their outline, retriangulated in projection along the surface's normal.
//!
//! Some folds only disappear when several edges are flipped at once. Then growing neighbourhoods of the fold are
//! removed, and their outline is filled by a constrained Delaunay triangulation (L. P. Chew, *Constrained Delaunay
//! triangulations*, 1989) of its projection. Points outside the projected outline, such as those beyond a boundary's
//! chord, are dropped.

use super::web::{Change, GONE, Web};
use crate::frame::trim::cdt::{AtCrossings, Segment, triangulate};
use crate::mesh::Origin;
use glam::{DVec2, DVec3};

/// Number of neighbourhoods tried, each wider than the last.
const RINGS: usize = 6;
/// Most triangles in a neighbourhood.
const MOST: usize = 256;
/// Least cosine between the direction of projection and the surface's normals.
const LEAST_COSINE: f64 = 0.3;

impl Web<'_> {
    /// Ways to retriangulate the neighbourhood of triangle `t`, the smallest first. It grows by turns to the triangles
    /// around its inner points and to adjacent triangles.
    /// `uvs`: parameters of the vertices.
    pub(crate) fn refills<'a>(&'a self, t: usize, uvs: &'a [DVec2]) -> impl Iterator<Item = Change> + 'a {
        let mut patch = vec![t];
        let grown = (0..RINGS).map(move |k| {
            let found: Vec<usize> =
                patch.iter().flat_map(|&t| if k % 2 == 0 { self.around(t) } else { self.beside(t) }).collect();
            for other in found {
                if !patch.contains(&other) {
                    patch.push(other);
                }
            }
            patch.clone()
        });
        grown.take_while(|patch| patch.len() <= MOST).filter_map(|patch| self.refill(&patch, uvs))
    }

    /// The triangles adjacent to `t`.
    pub(crate) fn beside(&self, t: usize) -> Vec<usize> {
        let [a, b, c] = self.mesh.triangles[t];
        [(b, a), (c, b), (a, c)].into_iter().filter_map(|(a, b)| self.left_of(a, b)).collect()
    }

    /// The triangles around the inner points of `t`.
    fn around(&self, t: usize) -> Vec<usize> {
        let inner = |v: &u32| matches!(self.mesh.origins[*v as usize], Origin::Lattice { .. } | Origin::Inner { .. });
        self.mesh.triangles[t]
            .into_iter()
            .filter(inner)
            .filter_map(|v| self.fan(t, v))
            .flatten()
            .map(|(t, _)| t)
            .collect()
    }

    /// Retriangulates the outline of `patch`. `None` if its projection crosses itself, the normals vary too much, or an
    /// edge would get more than two triangles.
    fn refill(&self, patch: &[usize], uvs: &[DVec2]) -> Option<Change> {
        let old = || patch.iter().flat_map(|&t| self.mesh.triangles[t]);
        let normal = |v: u32| self.mesh.normals[v as usize].as_dvec3();
        let view = old().map(normal).sum::<DVec3>().try_normalize()?;
        if old().any(|v| normal(v).dot(view) < LEAST_COSINE) {
            return None;
        }
        let mut vertices: Vec<u32> = old().map(|v| self.one(v)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let (x, y) = view.any_orthonormal_pair();
        let origin = self.mesh.positions[vertices[0] as usize];
        let seen = |v: u32| {
            let p = self.mesh.positions[v as usize] - origin;
            DVec2::new(p.dot(x), p.dot(y))
        };
        let sites: Vec<DVec2> = vertices.iter().map(|&v| seen(v)).collect();
        let site = |v: u32| vertices.partition_point(|&other| other < v) as u32;
        let within = |a: u32, b: u32| self.left_of(a, b).is_some_and(|t| patch.contains(&t));
        let sides = patch.iter().flat_map(|&t| {
            let [a, b, c] = self.mesh.triangles[t].map(|v| self.one(v));
            [(a, b), (b, c), (c, a)]
        });
        let outline: Vec<Segment> = sides
            .filter(|&(a, b)| !within(b, a))
            .map(|(a, b)| Segment { ends: [site(a), site(b)], weight: 1 })
            .collect();
        let filled = triangulate(&sites, &outline, AtCrossings::Refuse).ok()?;
        if !filled.layers.is_empty() || filled.triangles.len() > patch.len() {
            return None;
        }
        let new: Vec<[u32; 3]> = filled.triangles.iter().map(|t| t.map(|site| vertices[site as usize])).collect();
        // An edge that triangles outside the patch already have would get more than two triangles.
        let taken = |a: u32, b: u32| self.left_of(a, b).is_some() && !within(a, b);
        if new.iter().any(|&[a, b, c]| taken(a, b) || taken(b, c) || taken(c, a)) {
            return None;
        }
        let new = new.into_iter().map(|corners| self.with_near_parameters(corners, uvs)).chain(std::iter::repeat(GONE));
        Some(Change { triangles: patch.iter().copied().zip(new).collect() })
    }
}
