//! Cached tessellants and lattice points -> those of the new plan, with positions and normals reused or evaluated.
//!
//! A tessellant is reused if the old polyline has its parameter, a lattice point if both its lines are old ones. The
//! same parameters give the same bits, so reuse does not affect results.

use super::memory::keep;
use crate::frame::plan::output::{EdgePolyline, PartPlan, TileLattice};
use crate::frame::trim::input::NONE;
use crate::frame::vertices::boundary::{Spot, edge_point, origin, steps, steps_with_breaks};
use crate::frame::vertices::evaluate::{evaluate_lattice, evaluate_points};
use crate::frame::vertices::places::{LATTICE_FROM, LATTICE_SHARE};
use crate::frame::vertices::scratch::Scratch;
use crate::mesh::{Origin, TileMesh};
use crate::prepare::internals::{PreparedFace, PreparedPart, Tile};
use glam::{DVec2, DVec3, Vec3};
use std::sync::Arc;

/// The cached vertices of a tile.
#[derive(Default)]
pub(crate) struct SampleCache {
    lattice: Option<Arc<TileLattice>>,
    /// Polyline of each edge use, loop after loop.
    lines: Vec<Arc<EdgePolyline>>,
    pub(crate) loop_starts: Vec<u32>,
    /// By vertex: tessellants, then the used lattice points.
    uvs: Vec<DVec2>,
    positions: Vec<DVec3>,
    /// By vertex; a single one if the face is planar.
    normals: Vec<Vec3>,
    /// Vertex of each lattice point, or [`NONE`].
    corners: Vec<u32>,
}

impl SampleCache {
    /// Caches the tile that was just made in the scratch and the mesh, without crossings and inner points.
    pub(crate) fn keep(
        &mut self,
        (plan, tile, lattice, is_plane): (&PartPlan, &Tile, &Arc<TileLattice>, bool),
        s: &Scratch,
        mesh: &TileMesh,
    ) {
        self.lattice = Some(Arc::clone(lattice));
        self.lines.clear();
        self.lines.extend(tile.loops.iter().flatten().map(|u| Arc::clone(&plan.edges[u.edge.index()])));
        keep(&mut self.loop_starts, &s.loop_starts);
        keep(&mut self.corners, &s.corners);
        let inner = |o: &Origin| matches!(o, Origin::Crossing { .. } | Origin::Inner { .. });
        let mut count = mesh.origins.len();
        while count > 0 && inner(&mesh.origins[count - 1]) {
            count -= 1;
        }
        keep(&mut self.uvs, &s.uvs[..count]);
        keep(&mut self.positions, &mesh.positions[..count]);
        let normals = if is_plane { count.min(1) } else { count };
        keep(&mut self.normals, &mesh.normals[..normals]);
    }

    /// The cached u-lines and v-lines; empty if nothing is cached.
    pub(crate) fn lines(&self) -> [&[f64]; 2] {
        self.lattice.as_ref().map_or([&[], &[]], |lattice| [&lattice.us, &lattice.vs])
    }

    /// The chord tolerance that the cached triangles keep.
    pub(crate) fn chord(&self) -> f64 {
        self.lattice.as_ref().map_or(f64::INFINITY, |lattice| lattice.chord)
    }

    /// Heap size, bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of::<DVec2>() * self.uvs.capacity()
            + size_of::<DVec3>() * self.positions.capacity()
            + size_of::<Vec3>() * self.normals.capacity()
            + size_of::<Arc<EdgePolyline>>() * self.lines.capacity()
            + 4 * (self.corners.capacity() + self.loop_starts.capacity())
    }

    /// Makes the tessellants of the tile's loops by a new plan, as
    /// [`trace_loops`](crate::frame::vertices::boundary::trace_loops) does. Sets `from` to the old index of each, or
    /// [`NONE`]. With `keeps`, reuses positions and parameters.
    pub(crate) fn trace_loops(
        &self,
        (part, plan, tile, lattice, face): (&PreparedPart, &PartPlan, &Tile, &TileLattice, &PreparedFace),
        keeps: bool,
        from: &mut Vec<u32>,
        s: &mut Scratch,
        mesh: &mut TileMesh,
    ) {
        s.cells.clear();
        s.uvs.clear();
        s.loop_starts.clear();
        s.loop_starts.push(0);
        from.clear();
        let mut spot = Spot::of(face, tile, lattice);
        let (mut old, mut line) = (0_usize, 0);
        for l in &tile.loops {
            for u in l {
                let edge = &part.edges[u.edge.index()];
                let (is, was) = (&plan.edges[u.edge.index()], &self.lines[line]);
                line += 1;
                let all = steps(u, &was.breaks).count();
                if Arc::ptr_eq(is, was) && keeps {
                    let range = old..old + all;
                    from.extend(range.clone().map(|v| v as u32));
                    s.uvs.extend_from_slice(&self.uvs[range.clone()]);
                    s.cells.extend(self.uvs[range.clone()].iter().map(|&uv| spot.cell(uv)));
                    mesh.positions.extend_from_slice(&self.positions[range]);
                    mesh.origins.extend(steps(u, &is.breaks).map(|k| origin(part, u.edge, k as u32)));
                    old += all;
                    continue;
                }
                let forward = u.from < u.to;
                let mut before = steps(u, &was.breaks).map(|k| was.ts[k]).zip(old..).peekable();
                let mut hint = 0;
                for (k, at_break) in steps_with_breaks(u, &is.breaks) {
                    let t = is.ts[k];
                    while before.next_if(|&(old, _)| if forward { old < t } else { old > t }).is_some() {}
                    let known = before.next_if(|&(old, _)| old == t).map(|(_, v)| v);
                    from.push(known.map_or(NONE, |v| v as u32));
                    let known = known.filter(|_| keeps);
                    let uv = known.map_or_else(|| u.uv.point(t, &mut hint), |v| self.uvs[v]);
                    s.uvs.push(uv);
                    s.cells.push(spot.cell(uv));
                    mesh.positions.push(known.map_or_else(|| edge_point(edge, at_break, t), |v| self.positions[v]));
                    mesh.origins.push(origin(part, u.edge, k as u32));
                }
                old += all;
            }
            s.loop_starts.push(s.cells.len() as u32);
        }
    }

    /// Appends to `from` the old vertex of each lattice point in use, or [`NONE`], in the order of the vertices.
    pub(crate) fn find_corners(&self, lattice: &TileLattice, s: &Scratch, from: &mut Vec<u32>) {
        let tessellants = from.len();
        let used = s.uvs.len() - tessellants;
        let of_lines = |new: &[f64], old: &[f64]| -> Vec<u32> {
            let mut k = 0;
            let place = |&x: &f64| {
                while k < old.len() && old[k] < x {
                    k += 1;
                }
                if k < old.len() && old[k] == x { k as u32 } else { NONE }
            };
            new.iter().map(place).collect()
        };
        let [old_us, old_vs] = self.lines();
        let (us, vs) = (of_lines(&lattice.us, old_us), of_lines(&lattice.vs, old_vs));
        let (width, old_width) = (lattice.us.len(), old_us.len());
        from.resize(tessellants + used, NONE);
        for (c, &vertex) in s.corners.iter().enumerate().filter(|&(_, &vertex)| vertex != NONE) {
            let (i, j) = (us[c % width], vs[c / width]);
            if i != NONE && j != NONE {
                from[vertex as usize] = self.corners[j as usize * old_width + i as usize];
            }
        }
    }

    /// Appends positions of lattice points and crossings, and normals of all vertices. Reuses those of old vertices.
    pub(crate) fn evaluate(
        &self,
        face: &PreparedFace,
        lattice: &TileLattice,
        from: &[u32],
        s: &mut Scratch,
        mesh: &mut TileMesh,
    ) {
        let (tessellants, last) = (mesh.positions.len(), self.normals.len().saturating_sub(1));
        let side = if face.reversed { -1.0 } else { 1.0 };
        let oriented = |n: DVec3| (n * side).as_vec3();
        for (v, &old) in from.iter().enumerate() {
            mesh.normals.push(if old == NONE { Vec3::ZERO } else { self.normals[(old as usize).min(last)] });
            if v >= tessellants {
                mesh.positions.push(if old == NONE { DVec3::ZERO } else { self.positions[old as usize] });
            }
        }
        let on_lattice = mesh.origins[tessellants..].iter().take_while(|o| matches!(o, Origin::Lattice { .. }));
        let lattice_end = (tessellants + on_lattice.count()) as u32;
        let Scratch { uvs, corners, points, normals, evaluate, lattice: on_lattice, .. } = s;
        let missing = |v: &u32| from[*v as usize] == NONE;
        let mut single: Vec<u32> = (0..tessellants as u32).filter(missing).collect();
        single.extend(lattice_end..from.len() as u32);
        let on_lines = (tessellants as u32..lattice_end).filter(missing).count();
        if on_lines < LATTICE_FROM || on_lines * LATTICE_SHARE < corners.len() {
            single.extend((tessellants as u32..lattice_end).filter(missing));
        } else {
            let width = lattice.us.len();
            let wanted = |i: usize, j: usize| {
                let vertex = corners[j * width + i];
                vertex != NONE && missing(&vertex)
            };
            let (all_points, all_normals) = on_lattice;
            evaluate_lattice(&face.patches, &lattice.us, &lattice.vs, wanted, evaluate, all_points, all_normals);
            let height = lattice.vs.len();
            for (c, &vertex) in corners.iter().enumerate().filter(|&(_, v)| *v != NONE && missing(v)) {
                let at = c % width * height + c / width;
                mesh.positions[vertex as usize] = all_points[at];
                mesh.normals[vertex as usize] = oriented(all_normals[at]);
            }
        }
        if single.is_empty() {
            return;
        }
        let at: Vec<DVec2> = single.iter().map(|&v| uvs[v as usize]).collect();
        evaluate_points(&face.patches, &at, points, normals);
        for (k, &v) in single.iter().enumerate() {
            mesh.normals[v as usize] = oriented(normals[k]);
            if v as usize >= tessellants {
                mesh.positions[v as usize] = points[k];
            }
        }
    }
}
