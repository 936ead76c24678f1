//! Faces of closed surfaces whose wires run against those of all their neighbours -> wires in the other direction.
//!
//! In a closed shell, two faces run along their common edge in opposite directions. On a closed surface, the direction
//! of the wires says which of two sides is the face. If one flag of a file is wrong, the other side would be taken.

use super::chains::{Sum, TurnedFace, sums};
use crate::model::{Face, Loop, Part, Severity, ShellKind, Surface, SurfaceKind, WireTrouble};
use crate::prepare::regions::boundary::{boundary, of_boundary};
use crate::prepare::report::finding::Finding;
use crate::prepare::trims::free_faces::FreeFaces;
use crate::prepare::wires::chain::Chain;
use crate::prepare::wires::heal::Healing;
use std::borrow::Cow;

/// The part with the wires of such faces reversed, if their neighbours agree with all others.
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
    let free_face = |face: usize| free.get(face)?.as_ref()?.as_ref().ok();
    let chain =
        |(k, face): (usize, &Face)| if face.lost { Chain::new() } else { of_boundary(&boundary(face, free_face(k))) };
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
    let is_wrong = |&face: &usize| {
        let alone = !of_faces[face].is_empty() && !has_even(face);
        let only_it = alone && against(face).count() > 0 && against(face).all(|other| agrees(other, face));
        only_it && may_have_two_sides(&part, &part.faces[face]) && is_closed(&part.faces[face].surface)
    };
    let wrong: Vec<(usize, usize)> =
        (0..part.faces.len()).filter(is_wrong).map(|face| (face, against(face).count())).collect();
    for (face, edges) in wrong {
        let told = Finding::new(None, WireTrouble::AgainstNeighbours { edges });
        done.push(Healing { face, severity: Severity::Warning, told });
        for l in &mut part.to_mut().faces[face].loops {
            if let Loop::Edges(coedges) = l {
                coedges.reverse();
                coedges.iter_mut().for_each(|c| c.reversed = !c.reversed);
            }
        }
    }
    part
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
