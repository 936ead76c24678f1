//! Faces of closed surfaces whose wires run the wrong way -> wires in the other direction.
//!
//! On a closed surface, the direction of the wires says which of two sides is the face. If a flag of the file is wrong,
//! the other side would be taken. Three things tell that it is. In a closed shell, two faces run along their common
//! edge in opposite directions. Wires of planes and cylinders run counter-clockwise: if none of a shell's does, all
//! wires run the wrong way. And no face lies on its neighbours along all its edges.

use super::chains::{Sum, TurnedFace, sums};
use crate::math::keyed::Buckets;
use crate::model::{
    Coedge, EdgeId, Face, FaceError, Frame3, Loop, Part, Severity, ShellKind, Surface, SurfaceKind, WireTrouble,
};
use crate::prepare::report::Finding;
use crate::prepare::tiles::draft::FaceDraft;
use crate::prepare::trims::free_edges::{FreeFaces, free_face};
use crate::prepare::wires::boundary::{Chain, boundary, of_boundary};
use crate::prepare::wires::heal::Healing;
use glam::DVec3;
use std::borrow::Cow;
use std::cell::LazyCell;

/// The part with the wires of such faces reversed.
///
/// Cost: that of [`sums`], for parts with closed shells and surfaces that may be closed.
pub(crate) fn with_turned_wires<'a>(
    mut part: Cow<'a, Part>,
    free: &FreeFaces,
    done: &mut Vec<Healing>,
) -> Cow<'a, Part> {
    if !part.faces.iter().any(|face| may_have_two_sides(&part, face)) {
        return part;
    }
    for (face, told) in wrong_faces(&part, free) {
        done.push(Healing { face, severity: Severity::Warning, told: Finding::new(None, told) });
        turn_wires(&mut part.to_mut().faces[face]);
    }
    part
}

/// Reverses the wires of a face.
fn turn_wires(face: &mut Face) {
    for l in &mut face.loops {
        if let Loop::Edges(coedges) = l {
            coedges.reverse();
            coedges.iter_mut().for_each(|c| c.reversed = !c.reversed);
        }
    }
}

/// The faces of a shell that may be the other side of their wires.
pub(crate) fn unsure_faces(part: &Part, shell: u32) -> Vec<usize> {
    let is_unsure = |f: &Face| f.shell == shell && may_have_two_sides(part, f) && !has_seam(f) && is_closed(&f.surface);
    part.faces.iter().enumerate().filter(|(_, f)| is_unsure(f)).map(|(face, _)| face).collect()
}

/// Where the wires of the only plane or cylinder of a shell run clockwise, takes the other side of the wires of a face
/// that has one and was flipped, too: all flags are wrong. `reversed`: whether outward normals of faces are opposite to
/// `S_u × S_v`. Returns whether a face has a new draft, and the faces that may be the other side, too.
pub(crate) fn take_other_sides(
    part: &mut Cow<'_, Part>,
    drafts: &mut [Option<FaceDraft>],
    reversed: &[bool],
    draft: impl Fn(&Part, &Face) -> Result<FaceDraft, FaceError>,
) -> (bool, Vec<usize>) {
    let (mut found, mut others) = (false, Vec::new());
    if !part.faces.iter().any(|face| may_have_two_sides(part, face)) {
        return (found, others);
    }
    for (shell, clockwise) in (0..).zip(clockwise_faces(part)) {
        let Some(faces @ 1..LEAST_CLOCKWISE) = clockwise else { continue };
        for k in unsure_faces(part, shell) {
            let mut face = part.faces[k].clone();
            turn_wires(&mut face);
            let again = if reversed[k] == face.reversed { None } else { draft(part, &face).ok() };
            let Some(mut again) = again else {
                others.push(k);
                continue;
            };
            again.repairs.push(Finding::new(None, WireTrouble::AgainstPlanes { faces }));
            drafts[k] = Some(again);
            part.to_mut().faces[k] = face;
            found = true;
        }
    }
    (found, others)
}

/// Faces whose wires run the wrong way, and what tells it.
fn wrong_faces(part: &Part, free: &FreeFaces) -> Vec<(usize, WireTrouble)> {
    let chain = |(k, face): (usize, &Face)| {
        if face.lost { Chain::new() } else { of_boundary(&boundary(face, free_face(free, k))) }
    };
    let chains: Vec<Chain> = part.faces.iter().enumerate().map(chain).collect();
    let faces = part.faces.iter().zip(&chains).enumerate();
    let turned = faces.map(|(face, (f, chain))| TurnedFace { face, shell: f.shell, reversed: f.reversed, chain });
    let uneven = sums(part.edges.len(), turned);
    let mut of_faces: Vec<Vec<&Sum>> = vec![Vec::new(); part.faces.len()];
    for sum in &uneven {
        let [first, last] = sum.faces.map(|face| face as usize);
        of_faces[first].push(sum);
        if first != last {
            of_faces[last].push(sum);
        }
    }
    // Two faces run in the same direction.
    let against = |face: usize| of_faces[face].iter().filter(|sum| sum.uses == 2).map(move |sum| sum.other(face));
    let has_even = |face: usize| chains[face].len() > of_faces[face].len();
    let agrees = |face: usize, but: usize| has_even(face) && against(face).all(|other| other == but);
    let clockwise = clockwise_faces(part);
    let users = LazyCell::new(|| edge_users(part));
    let mut wrong = Vec::new();
    for (face, f) in part.faces.iter().enumerate().filter(|(_, f)| may_have_two_sides(part, f)) {
        let alone = !of_faces[face].is_empty() && !has_even(face);
        let of_shell = clockwise.get(f.shell as usize).copied().flatten().filter(|&count| count >= LEAST_CLOCKWISE);
        let told = if alone && against(face).count() > 0 && against(face).all(|other| agrees(other, face)) {
            WireTrouble::AgainstNeighbours { edges: against(face).count() }
        } else if let Some(faces) = of_shell {
            // A seam says on which side the face is.
            if !of_faces[face].is_empty() || has_seam(f) {
                continue;
            }
            WireTrouble::AgainstPlanes { faces }
        } else if matches!(f.surface.kind(), SurfaceKind::Sphere | SurfaceKind::Torus)
            && let Some(edges) = lies_on_neighbours(part, face, &users)
        {
            WireTrouble::FoldsBack { edges }
        } else {
            continue;
        };
        if is_closed(&f.surface) {
            wrong.push((face, told));
        }
    }
    wrong
}

/// Whether a face uses an edge more than once.
fn has_seam(face: &Face) -> bool {
    let mut edges: Vec<EdgeId> = face.wires().flatten().map(|c| c.edge).collect();
    edges.sort_unstable();
    edges.windows(2).any(|pair| pair[0] == pair[1])
}

/// Fewer planes and cylinders whose wires run clockwise may have flags of their own that are wrong.
const LEAST_CLOCKWISE: usize = 2;

/// By shell, how many planes and cylinders have wires that run clockwise; `None` if those of another do not.
fn clockwise_faces(part: &Part) -> Vec<Option<usize>> {
    let mut shells = vec![Some(0); part.shells.len()];
    for face in &part.faces {
        let Some(of_shell @ Some(_)) = shells.get_mut(face.shell as usize) else { continue };
        match runs_around(part, face) {
            Some(true) => *of_shell = None,
            Some(false) => *of_shell = of_shell.map(|count| count + 1),
            None => {}
        }
    }
    shells
}

/// Whether the wires of a plane or a cylinder run counter-clockwise around its area. `None` for other faces, without
/// area, and if the wires go around the cylinder together: they bound no area then.
fn runs_around(part: &Part, face: &Face) -> Option<bool> {
    /// Points per edge.
    const POINTS: u32 = 8;
    let (frame, radius) = match &face.surface {
        Surface::Plane { frame } => (frame, None),
        Surface::Cylinder { frame, radius } => (frame, Some(*radius)),
        _ => return None,
    };
    let (mut area, mut around, mut size) = (0.0, 0.0, 0.0_f64);
    for wire in face.wires().filter(|_| !face.lost && face.refused.is_none()) {
        let points: Vec<DVec3> = wire
            .iter()
            .flat_map(|c| (0..POINTS).map(move |k| (c, f64::from(k) / f64::from(POINTS))))
            .filter_map(|(c, share)| Some(point_on(part, c, share)?[0]))
            .map(|p| frame.local(p))
            .collect();
        for (p, q) in points.iter().zip(points.iter().cycle().skip(1)) {
            let across = p.x * q.y - p.y * q.x;
            area += match radius {
                None => across,
                Some(radius) => {
                    let turn = radius * libm::atan2(across, p.x * q.x + p.y * q.y);
                    around += turn;
                    -(p.z + q.z) * turn
                }
            };
        }
        size = points.iter().map(|p| p.distance_squared(points[0])).fold(size, f64::max);
    }
    (area.abs() > 1e-6 * size && around * around <= 1e-6 * size).then_some(area > 0.0)
}

/// A point of a coedge and its direction there, by the share of its way. `None` if there is no such edge.
fn point_on(part: &Part, c: &Coedge, share: f64) -> Option<[DVec3; 2]> {
    let edge = part.edges.get(c.edge.index())?;
    let (from, to) = if c.reversed { (edge.range.1, edge.range.0) } else { edge.range };
    let [point, along] = edge.curve.tangent(from + share * (to - from));
    Some([point, if c.reversed { -along } else { along }])
}

/// By edge, the faces that use it, and whether against it.
fn edge_users(part: &Part) -> Buckets<(u32, bool)> {
    let count = part.edges.len();
    let mut uses = Vec::new();
    for (face, k) in part.faces.iter().zip(0..) {
        let known = face.wires().flatten().filter(|c| c.edge.index() < count);
        uses.extend(known.map(|c| (c.edge.0, (k, c.reversed))));
    }
    Buckets::of(count, uses.into_iter())
}

/// The number of a face's edges, if it lies on its neighbours along all of them: it leaves each on the side on which
/// the neighbour lies, and in its direction. There are two neighbours at least: a lens, however shallow, has one.
fn lies_on_neighbours(part: &Part, face: usize, users: &Buckets<(u32, bool)>) -> Option<usize> {
    /// Largest angle between two faces that lie on each other at their edge, radians.
    const SAME: f64 = 1e-3;
    let mut neighbours = Vec::new();
    for edge in part.faces[face].wires().flatten().map(|c| c.edge) {
        let &[one, other] = users.at(edge.0) else { return None };
        let inwards = |(face, reversed): (u32, bool)| {
            let [point, along] = point_on(part, &Coedge { edge, reversed }, 0.5)?;
            normal(&part.faces[face as usize].surface, point)?.cross(along).try_normalize()
        };
        if one.0 == other.0 || inwards(one)?.distance(inwards(other)?) > SAME {
            return None;
        }
        neighbours.push(if one.0 as usize == face { other.0 } else { one.0 });
    }
    let edges = neighbours.len();
    let has_two = neighbours.iter().any(|neighbour| *neighbour != neighbours[0]);
    has_two.then_some(edges)
}

/// The direction of `S_u × S_v` at a point of a surface with a closed form for it.
fn normal(surface: &Surface, p: DVec3) -> Option<DVec3> {
    let out = |frame: &Frame3| (p - frame.origin).reject_from_normalized(frame.z);
    match surface {
        Surface::Plane { frame } => Some(frame.z),
        Surface::Cylinder { frame, .. } => out(frame).try_normalize(),
        Surface::Sphere { frame, .. } => (p - frame.origin).try_normalize(),
        Surface::Torus { frame, major, .. } => {
            (p - frame.origin - out(frame).try_normalize()? * *major).try_normalize()
        }
        _ => None,
    }
}

/// Whether a face is part of a closed shell, and its kind of surface may have two bounded sides of its wires.
fn may_have_two_sides(part: &Part, face: &Face) -> bool {
    use SurfaceKind::{Nurbs, Revolution, Sphere, Torus};
    let solid = part.shells.get(face.shell as usize).is_some_and(|shell| shell.kind != ShellKind::Open);
    let is_read = !face.lost && face.refused.is_none() && !face.loops.is_empty();
    solid && is_read && matches!(face.surface.kind(), Sphere | Torus | Revolution | Nurbs)
}

/// Whether both sides of wires on a surface are bounded.
fn is_closed(surface: &Surface) -> bool {
    surface.check().is_ok() && !surface.has_border()
}
