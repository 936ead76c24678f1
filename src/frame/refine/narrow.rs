//! A tile's triangles -> the same, with those that are wider than a cell brought within the chord tolerance.
//!
//! Crossings are replaced by tessellants, so triangles between tessellants may reach from one cell into the next, where
//! the lattice's bounds do not hold for them. While they are too far from the surface, edges are flipped that reduce
//! the distance (C. L. Lawson, *Software for C1 surface interpolation*, 1977). If no flip does, an edge is split at a
//! point of the surface. That point is inside the tile, so neighbours are not affected.

use super::lift::FaceSurface;
use super::web::{Change, TriangleShape, Web};
use crate::math::lanes::{larger, smaller, widest};
use crate::mesh::{Origin, TileMesh};
use glam::DVec2;

/// Rounding allowed in the width of a triangle, in cells.
const HAIR: f64 = 1e-9;
/// Least share of the deviation that a flip must remove, so that flips terminate.
const LEAST_GAIN: f64 = 1e-3;
/// Most flips and splits per wide triangle.
const CHANGES: usize = 16;

/// Changes triangles that are wider than a cell, among the first `count`, until none deviates by more than the
/// surface's chord or nothing helps. `cells`: positions of the vertices in cells.
///
/// Cost: a few nanoseconds for each of these triangles, and up to half a microsecond for each that is wider than a
/// cell. If one deviates too far, also a few nanoseconds for every triangle of the tile.
pub(crate) fn narrow(mesh: &mut TileMesh, count: usize, surface: &mut FaceSurface<'_>, cells: &[DVec2]) {
    let is_wider = |corners: [u32; 3]| {
        let [a, b, c] = corners.map(|v| cells[v as usize].to_array());
        let [x, y] = [0, 1].map(|k| larger(larger(a[k], b[k]), c[k]) - smaller(smaller(a[k], b[k]), c[k]));
        (x > 1.0 + HAIR) | (y > 1.0 + HAIR)
    };
    let (triangles, mut wide) = (&mesh.triangles[..count], Vec::new());
    widest(
        #[inline(always)]
        || {
            for (k, &corners) in triangles.iter().enumerate() {
                if is_wider(corners) {
                    wide.push(k);
                }
            }
        },
    );
    wide.retain(|&k| surface.exceeds(mesh, mesh.triangles[k]));
    if wide.is_empty() {
        return;
    }
    let mut web = Web::new(mesh);
    let mut left = CHANGES * wide.len();
    while let (Some(t), 1..) = (wide.pop(), left) {
        // In a row of vertices at a pole, the middles of sides that lead to a far one are off in (u,v) alone.
        web.mesh.triangles[t] = web.with_near_parameters(web.mesh.triangles[t], surface.uvs);
        let off = surface.deviation(web.mesh, web.mesh.triangles[t]);
        if off <= surface.chord {
            continue;
        }
        let best = web.flips(t).into_iter().filter_map(|flip| Some((surface.gain(&web, &flip, off)?, flip)));
        let change = best.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, flip)| flip);
        let Some(change) = change.or_else(|| surface.split(&mut web, t)) else { continue };
        left -= 1;
        web.apply(&change);
        wide.extend(change.triangles.iter().map(|(t, _)| *t));
    }
}

impl FaceSurface<'_> {
    /// Splits the side of triangle `t` that is furthest from the surface by a new vertex in its middle. `None` if that
    /// side is on the tile's boundary, or if a triangle would face inwards or be flat.
    fn split(&mut self, web: &mut Web<'_>, t: usize) -> Option<Change> {
        let corners = web.mesh.triangles[t];
        let edge = |k: usize| (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
        let lifts = self.lifts(web.mesh, corners).map(f64::abs);
        let (a, b, c) = edge((0..3).max_by(|&i, &j| lifts[i].total_cmp(&lifts[j]))?);
        let other = web.left_of(b, a)?;
        let d = web.third(other, a, b)?;
        let uv = self.middle(a, b);
        let [point, du, dv] = self.face.patches.tangents(uv.x, uv.y);
        let mesh = &mut *web.mesh;
        let m = mesh.positions.len() as u32;
        let outwards = du.cross(dv).normalize_or_zero() * if self.face.reversed { -1.0 } else { 1.0 };
        mesh.positions.push(point);
        mesh.normals.push(outwards.as_vec3());
        mesh.origins.push(Origin::Inner { k: m });
        self.uvs.push(uv);
        let next = mesh.triangles.len();
        let triangles = vec![(t, [a, m, c]), (other, [m, a, d]), (next, [m, b, c]), (next + 1, [b, m, d])];
        let change = Change { triangles };
        let follow = change.triangles.iter().all(|(_, corners)| follows(web.mesh, *corners));
        if !(follow && web.keeps_outline(&change)) {
            let mesh = &mut *web.mesh;
            mesh.positions.pop();
            mesh.normals.pop();
            mesh.origins.pop();
            self.uvs.pop();
            return None;
        }
        Some(change)
    }

    /// How much a flip reduces the deviation, which is `off` for the first of its triangles. `None` if it does not, or
    /// makes triangles that face inwards or are flat.
    fn gain(&self, web: &Web<'_>, flip: &Change, off: f64) -> Option<f64> {
        let mesh = &*web.mesh;
        if !(flip.made().all(|corners| follows(mesh, corners)) && web.keeps_outline(flip)) {
            return None;
        }
        let others = flip.triangles[1..].iter().map(|(t, _)| self.deviation(mesh, mesh.triangles[*t]));
        let before = others.fold(off, f64::max);
        let gain = before - flip.made().map(|corners| self.deviation(mesh, corners)).fold(0.0, f64::max);
        (gain > LEAST_GAIN * before).then_some(gain)
    }
}

/// Whether a triangle faces outwards and is not flat.
fn follows(mesh: &TileMesh, corners: [u32; 3]) -> bool {
    let shape = TriangleShape::of(mesh, corners);
    shape.outwards > 0.0 && !shape.is_flat(mesh)
}
