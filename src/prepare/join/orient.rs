//! Loops that run counter-clockwise in (u,v) -> faces that all point outwards.
//!
//! Neighbours that run along their common edge in opposite directions are oriented alike. That determines each
//! connected group up to a sign. The volume decides the sign of groups that bound a solid, the file that of others.

use super::rays::{self, RayBody, RayFace, plane_polygon, region};
use super::shells::connected;
use crate::control::Call;
use crate::model::{Part, ShellKind};
use crate::prepare::surface::decompose::BezierPatches;
use crate::prepare::tiles::draft::{DraftAlong, DraftTile, DraftUse, FaceDraft};
use crate::prepare::uv::polygon::area;
use crate::prepare::wires::boundary::sign;
use glam::{DVec2, DVec3};
use smallvec::SmallVec;
use std::cell::Cell;

/// A group of faces that should bound a solid, but does not as stated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Orientation {
    /// One of its faces.
    pub(crate) face: usize,
    /// How many faces it has.
    pub(crate) faces: usize,
    pub(crate) fault: Fault,
}

/// Why a group of faces does not bound a solid as stated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fault {
    /// The sign of its volume was wrong, so it was flipped.
    InsideOut {
        /// As stated, mm³.
        volume: f64,
    },
    /// It is a void that lies outside of the outer shell before it. It was oriented as a body.
    VoidOutside,
    /// It encloses nothing.
    NoVolume,
}

/// Returns for each face whether its outward normal is opposite to `S_u × S_v`. Groups with faults are appended to
/// `told`.
///
/// Loops already run counter-clockwise in (u,v). Two faces are oriented alike exactly when, once flipped, they run
/// along their common edge in opposite directions. Once the call is cancelled, the result means nothing.
pub(crate) fn orient(
    call: Call<'_>,
    part: &Part,
    drafts: &[Option<FaceDraft>],
    told: &mut Vec<Orientation>,
) -> Vec<bool> {
    let mut reversed: Vec<bool> = part.faces.iter().map(|f| f.reversed).collect();
    let mut uses: Vec<SmallVec<[(usize, bool); 2]>> = vec![SmallVec::new(); part.edges.len()];
    for (k, draft) in drafts.iter().enumerate().take_while(|_| !call.is_cancelled()) {
        let Some(draft) = draft else { continue };
        // Each direction once, however many pieces the edge was cut into.
        for u in draft.tiles.iter().flat_map(|t| &t.loops).flatten() {
            if let DraftAlong::Edge(e) = u.along {
                let entry = (k, u.from < u.to);
                let mut of_face = uses[e as usize].iter().rev().take_while(|(face, _)| *face == k);
                if of_face.all(|known| *known != entry) {
                    uses[e as usize].push(entry);
                }
            }
        }
    }
    // For each face its neighbours, and whether both are flipped alike; and whether all its edges have a counterpart.
    // Where bodies touch, an edge has more than two uses, but two per shell.
    let mut neighbours: Vec<Vec<(usize, bool)>> = vec![Vec::new(); part.faces.len()];
    let mut whole: Vec<bool> = drafts.iter().map(Option::is_some).collect();
    for all in &mut uses {
        all.sort_by_key(|&(face, _)| part.faces[face].shell);
        for of_shell in all.chunk_by(|a, b| part.faces[a.0].shell == part.faces[b.0].shell) {
            match *of_shell {
                [(a, forward_a), (b, forward_b)] if a != b => {
                    neighbours[a].push((b, forward_a != forward_b));
                    neighbours[b].push((a, forward_a != forward_b));
                }
                [(a, _), (b, _)] if a == b => {}
                _ => of_shell.iter().for_each(|&(face, _)| whole[face] = false),
            }
        }
    }
    let mut seen = vec![false; part.faces.len()];
    let mut voids = Voids { call, part, drafts, whole: &whole, outer: None, left: Cell::new(MOST_TESTS) };
    for start in 0..part.faces.len() {
        if seen[start] {
            continue;
        }
        let group = connected(&neighbours, (start, reversed[start]), &mut seen);
        let disagree = group.iter().filter(|(face, turned)| *turned != part.faces[*face].reversed).count();
        let flip = 2 * disagree > group.len();
        for (face, turned) in &group {
            reversed[*face] = *turned != flip;
        }
        let Some(wanted) = wanted_sign(part, part.faces[start].shell) else { continue };
        // Only a group without free edges has a volume.
        if !group.iter().all(|(face, _)| whole[*face]) {
            continue;
        }
        let outside = wanted < 0.0 && voids.is_outside(&group, &reversed);
        let wanted = if outside { 1.0 } else { wanted };
        let wrong = wrong_volume(call, drafts, &group, &reversed, wanted);
        let fault = match wrong {
            Some(0.0) => Fault::NoVolume,
            _ if outside => Fault::VoidOutside,
            Some(volume) => Fault::InsideOut { volume },
            None => continue,
        };
        told.push(Orientation { face: start, faces: group.len(), fault });
        for (face, _) in group.iter().filter(|_| wrong.is_some_and(|volume| volume != 0.0)) {
            reversed[*face] = !reversed[*face];
        }
    }
    reversed
}

/// The sign of a volume of few samples counts above this share of the absolute contributions.
const DECISIVE: f64 = 0.3;

/// The same for the volume of most samples, if it differs from that of fewer by a third of itself at most.
const SLIGHT: f64 = 0.01;

/// Share of the cube of a group's size below which a volume is only rounding.
const ROUNDING: f64 = 1e-9;

/// The sign of the volume that the faces of a shell enclose, if the file says it.
pub(crate) fn wanted_sign(part: &Part, shell: u32) -> Option<f64> {
    match part.shells.get(shell as usize)?.kind {
        ShellKind::Outer => Some(1.0),
        ShellKind::Void => Some(-1.0),
        ShellKind::Open => None,
    }
}

/// Maximum tests of a line against a face's box, for all voids of a part together: half a second.
const MOST_TESTS: usize = 1 << 27;

/// Compares voids with the shells that they should hollow out.
struct Voids<'a> {
    call: Call<'a>,
    part: &'a Part,
    drafts: &'a [Option<FaceDraft>],
    /// Whether all edges of a face have a counterpart.
    whole: &'a [bool],
    /// The outer shell that was looked at last, and its faces: none unless it is closed.
    outer: Option<(u32, RayBody<'a>)>,
    /// Tests that may still be made, of [`MOST_TESTS`].
    left: Cell<usize>,
}

impl Voids<'_> {
    /// Whether a group of faces of a void lies outside of the last outer shell before its own. Not if that is not
    /// certain, or takes too long.
    fn is_outside(&mut self, group: &[(usize, bool)], reversed: &[bool]) -> bool {
        let shell = |face: usize| self.part.faces[face].shell;
        let Some(void) = group.first().map(|(face, _)| shell(*face)) else { return false };
        let is_outer = |shell: &u32| self.part.shells[*shell as usize].kind == ShellKind::Outer;
        let Some(outer) = (0..void).rev().find(is_outer) else { return false };
        let ray_face = |face: usize| Some(RayFace::new(self.drafts[face].as_ref()?, reversed[face]));
        if self.outer.as_ref().is_none_or(|(last, _)| *last != outer) {
            self.left.set(self.left.get().saturating_sub(self.part.faces.len()));
            let all: Vec<usize> = (0..self.part.faces.len()).filter(|face| shell(*face) == outer).collect();
            let closed = self.left.get() > 0 && all.iter().all(|face| self.whole[*face]);
            let faces = if closed { all.into_iter().filter_map(ray_face).collect() } else { Vec::new() };
            self.outer = Some((outer, RayBody::new(faces)));
        }
        let Some((_, around)) = self.outer.as_ref().filter(|(_, body)| !body.faces.is_empty()) else { return false };
        let own: Vec<RayFace<'_>> = group.iter().filter_map(|(face, _)| ray_face(*face)).collect();
        rays::lie_outside(self.call, &own, around, &self.left) == Some(true)
    }
}

/// The volume of a closed group if its sign is not `wanted`; zero if it is only rounding.
///
/// Where all faces are flat, the cones over the boundaries are the volume. Curved faces, and flat ones that do not
/// confirm the sign, are integrated over.
pub(crate) fn wrong_volume(
    call: Call<'_>,
    drafts: &[Option<FaceDraft>],
    group: &[(usize, bool)],
    reversed: &[bool],
    wanted: f64,
) -> Option<f64> {
    let group = group.iter().take_while(|_| !call.is_cancelled());
    let faces: Vec<(&FaceDraft, bool)> =
        group.filter_map(|(face, _)| Some((drafts[*face].as_ref()?, reversed[*face]))).collect();
    let polygons: Vec<(Vec<DVec3>, f64)> = faces
        .iter()
        .flat_map(|(draft, reversed)| draft.tiles.iter().flat_map(|t| &t.loops).map(move |l| (draft, l, *reversed)))
        .map(|(draft, l, reversed)| (space_polygon(draft, l), f64::from(sign(reversed))))
        .collect();
    let points = || polygons.iter().flat_map(|p| &p.0);
    let origin = points().sum::<DVec3>() / points().count().max(1) as f64;
    // The boundary of an untrimmed surface runs forth and back, or is a single point. Its cones sum to rounding only.
    let size = points().map(|p| p.distance(origin)).fold(ROUNDING * origin.abs().max_element(), f64::max);
    if faces.iter().all(|(draft, _)| draft.surface.bounds.is_affine()) {
        let (mut cones, mut parts) = (0.0, ROUNDING * size.powi(3));
        for (polygon, sign) in &polygons {
            let first = polygon[0] - origin;
            let fan = |w: &[DVec3]| first.dot((w[0] - origin).cross(w[1] - origin)) / 6.0;
            let cone: f64 = polygon.windows(2).map(fan).sum();
            cones += sign * cone;
            parts += cone.abs();
        }
        if cones * wanted > DECISIVE * parts {
            return None;
        }
    }
    wrong_sampled_volume(call, &faces, (origin, size), wanted)
}

/// [`wrong_volume`] of faces that are not all flat, or enclose little. `place`: a point near them, and their size.
///
/// Nearly all solids are right, and their parts hardly cancel: a few samples decide. The volume of a thin body is a
/// small difference of large numbers, of which samples may give any sign. There, lines through the faces decide. They
/// see one side of a boundary that crosses itself, so a volume that more samples confirm comes before them.
fn wrong_sampled_volume(call: Call<'_>, faces: &[(&FaceDraft, bool)], place: (DVec3, f64), wanted: f64) -> Option<f64> {
    const FEW: Sampling = Sampling { lattice: 2, outline: 8 };
    const MANY: Sampling = Sampling { lattice: 8, outline: usize::MAX };
    const MOST: Sampling = Sampling { lattice: 32, outline: usize::MAX };
    let (origin, size) = place;
    // The volume by its wanted sign.
    let summed = |samples: Sampling| {
        faces.iter().take_while(|_| !call.is_cancelled()).fold((0.0, 0.0), |(volume, parts), (draft, reversed)| {
            let [sum, absolute] = flux(draft, origin, samples);
            (volume + wanted * f64::from(sign(*reversed)) * sum / 3.0, parts + absolute / 3.0)
        })
    };
    let (volume, parts) = summed(FEW);
    if volume > DECISIVE * parts {
        return None;
    }
    let ray_faces: Vec<RayFace<'_>> = faces.iter().map(|&(draft, reversed)| RayFace::new(draft, reversed)).collect();
    let is_right = rays::look_outwards(call, &ray_faces).map(|outwards| outwards == (wanted > 0.0));
    if is_right == Some(true) && volume > 0.0 {
        return None;
    }
    let (volume, parts) = summed(MANY);
    if is_right.is_none() {
        // The faces cancel each other, or all lie in one plane.
        if volume.abs() <= ROUNDING * parts.max(size.powi(3)) {
            return Some(0.0);
        }
        if volume > -SLIGHT * parts {
            return None;
        }
        if volume < -DECISIVE * parts {
            return Some(wanted * volume);
        }
    }
    let (finer, parts) = summed(MOST);
    let is_certain = finer.abs() > (3.0 * (finer - volume).abs()).max(SLIGHT * parts);
    let is_wrong = if is_certain { finer < 0.0 } else { is_right == Some(false) };
    is_wrong.then(|| -wanted * finer.abs())
}

/// Points along a loop, on the surface.
fn space_polygon(draft: &FaceDraft, uses: &[DraftUse]) -> Vec<DVec3> {
    /// Maximum points per use: a fan over them has a circle's area within 3 %.
    const MOST: usize = 8;
    let patches = &*draft.surface.patches;
    // The image of a circle may be straight, too.
    if draft.surface.bounds.is_affine() {
        let point = affine(patches);
        return plane_polygon(uses, MOST, true).into_iter().map(point).collect();
    }
    plane_polygon(uses, MOST, false).into_iter().map(|p| patches.point(p.x, p.y)).collect()
}

/// Maps parameters to points of a surface that is one parallelogram, to rounding: its volume asks for no more.
fn affine(patches: &BezierPatches) -> impl Fn(DVec2) -> DVec3 {
    let BezierPatches { breaks_u, breaks_v, control, degree_u, degree_v, .. } = patches;
    let corner = |k: usize| control[k].truncate() / control[k].w;
    let (from, [u, v]) = (corner(0), [degree_u * (degree_v + 1), *degree_v].map(corner));
    let (du, dv) = ((u - from) / (breaks_u[1] - breaks_u[0]), (v - from) / (breaks_v[1] - breaks_v[0]));
    let low = DVec2::new(breaks_u[0], breaks_v[0]);
    move |p| from + du * (p.x - low.x) + dv * (p.y - low.y)
}

/// Sampling density of a face.
#[derive(Clone, Copy)]
struct Sampling {
    /// Samples per Bézier piece and direction.
    lattice: usize,
    /// Maximum points per edge of a loop.
    outline: usize,
}

/// Integral of (x - origin)·n over a face by sampling, each point as often as the loops wind around it, and that of its
/// absolute value. Accurate to a few per cent with 8 samples per piece and axis. A plane takes one sample: the flux is
/// even over it.
fn flux(draft: &FaceDraft, origin: DVec3, samples: Sampling) -> [f64; 2] {
    let at = |uv: DVec2| {
        let [point, du, dv] = draft.surface.patches.tangents(uv.x, uv.y);
        (point - origin).dot(du.cross(dv))
    };
    let of_tile = |tile: &DraftTile| {
        let inside = region(draft, tile, samples.outline);
        if draft.surface.bounds.is_affine() {
            let flux = area(&inside.loops) * at(tile.min);
            return [flux, flux.abs()];
        }
        let (step, lattice) = inside.lattice(samples.lattice);
        let covered = lattice.map(|uv| (uv, inside.winding(uv))).filter(|(_, winding)| *winding != 0);
        let of_sample = |(uv, winding)| f64::from(winding) * at(uv);
        let sums = covered.map(of_sample).fold([0.0; 2], |sums, flux| [sums[0] + flux, sums[1] + flux.abs()]);
        sums.map(|sum| sum * step.x * step.y)
    };
    draft.tiles.iter().map(of_tile).fold([0.0; 2], |sums, of_tile| [sums[0] + of_tile[0], sums[1] + of_tile[1]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Surface, shapes};
    use crate::prepare::report::Room;
    use crate::prepare::tiles::face;
    use crate::prepare::wires::boundary::shared_edges;

    #[test]
    fn lobes_of_negative_winding_count_against_the_volume() {
        // A plane, and the side of a cylinder.
        for (shape, is_wanted) in [
            ("box", (|surface| matches!(surface, Surface::Plane { .. })) as fn(&Surface) -> bool),
            ("cylinder", |surface| matches!(surface, Surface::Cylinder { .. })),
        ] {
            let part = shapes::by_name(shape).expect("a shape").parts.remove(0);
            let face = part.faces.iter().find(|face| is_wanted(&face.surface)).expect("a face");
            let free: Vec<_> = part.faces.iter().map(|_| None).collect();
            let (shared, room) = (shared_edges(&part, &free), Room::new(u64::MAX));
            let mut draft = face::draft(&part, face, None, 1.0, &shared, &room).expect("a draft");
            let origin = DVec3::new(1.0, 2.0, 3.0);
            let volume = |draft: &FaceDraft| flux(draft, origin, Sampling { lattice: 8, outline: 8 })[0];
            let stated = volume(&draft);
            for l in draft.tiles.iter_mut().flat_map(|tile| &mut tile.loops) {
                l.reverse();
                l.iter_mut().for_each(|u| std::mem::swap(&mut u.from, &mut u.to));
            }
            let turned = volume(&draft);
            assert!(stated != 0.0 && (turned + stated).abs() <= 1e-9 * stated.abs(), "{shape}: {stated} {turned}");
        }
    }
}
