//! Faces of closed surfaces whose wires run against those of all their neighbours -> wires in the other direction.
//!
//! In a closed shell, two faces run along their common edge in opposite directions. On a closed surface, the direction
//! of the wires says which of two sides is the face. If one flag of a file is wrong, the other side would be taken.

use super::heal::Healing;
use crate::model::{Face, Loop, Part, Severity, ShellKind, Surface, WireTrouble};
use crate::prepare::report::finding::Finding;
use std::borrow::Cow;

/// Neighbours of a face along edges that two faces of its shell use.
#[derive(Clone, Default)]
struct Sides {
    /// Number of edges along which both faces run in opposite directions.
    alike: usize,
    /// The other faces along which it runs in the same direction.
    against: Vec<usize>,
}

/// The part with the wires of such faces reversed, if their neighbours agree with all others.
pub(crate) fn with_turned_wires<'a>(mut part: Cow<'a, Part>, done: &mut Vec<Healing>) -> Cow<'a, Part> {
    if !part.faces.iter().any(|face| is_in_question(&part, face)) {
        return part;
    }
    let sides = sides(&part);
    let agrees = |face: usize, but: usize| sides[face].alike > 0 && sides[face].against.iter().all(|&g| g == but);
    let is_wrong = |&face: &usize| {
        let Sides { alike, against } = &sides[face];
        let alone = *alike == 0 && !against.is_empty() && against.iter().all(|&g| agrees(g, face));
        alone && is_in_question(&part, &part.faces[face])
    };
    let wrong: Vec<usize> = (0..part.faces.len()).filter(is_wrong).collect();
    for face in wrong {
        let what = WireTrouble::AgainstNeighbours { edges: sides[face].against.len() };
        done.push(Healing { face, severity: Severity::Warning, told: Finding::new(None, what) });
        for l in &mut part.to_mut().faces[face].loops {
            if let Loop::Edges(coedges) = l {
                coedges.reverse();
                coedges.iter_mut().for_each(|c| c.reversed = !c.reversed);
            }
        }
    }
    part
}

/// Whether a face is part of a closed shell, and the direction of its wires alone says which side of them it is.
fn is_in_question(part: &Part, face: &Face) -> bool {
    let is_closed = |surface: &Surface| match surface {
        Surface::Sphere { .. } | Surface::Torus { .. } => true,
        Surface::Revolution { .. } | Surface::Nurbs(_) => {
            let closed = surface.period().map(|period| period.is_some());
            closed == [true; 2] || closed != [false; 2] && surface.poles().len() == 2
        }
        _ => false,
    };
    let solid = part.shells.get(face.shell as usize).is_some_and(|shell| shell.kind != ShellKind::Open);
    solid
        && !face.lost
        && face.refused.is_none()
        && !face.loops.is_empty()
        && face.surface.check().is_ok()
        && is_closed(&face.surface)
}

/// What each face has in common with its neighbours.
fn sides(part: &Part) -> Vec<Sides> {
    // Face, and whether it runs against the edge, seen from outside.
    let mut uses: Vec<Vec<(usize, bool)>> = vec![Vec::new(); part.edges.len()];
    for (index, face) in part.faces.iter().enumerate().filter(|(_, face)| !face.lost) {
        for l in &face.loops {
            let Loop::Edges(coedges) = l else { continue };
            for c in coedges {
                if let Some(uses) = uses.get_mut(c.edge.index()) {
                    uses.push((index, c.reversed != face.reversed));
                }
            }
        }
    }
    let mut sides = vec![Sides::default(); part.faces.len()];
    for uses in &mut uses {
        uses.sort_by_key(|&(face, _)| part.faces[face].shell);
        for of_shell in uses.chunk_by(|a, b| part.faces[a.0].shell == part.faces[b.0].shell) {
            let [(a, way_a), (b, way_b)] = *of_shell else { continue };
            if a == b {
                continue;
            }
            if way_a != way_b {
                sides[a].alike += 1;
                sides[b].alike += 1;
            } else {
                sides[a].against.push(b);
                sides[b].against.push(a);
            }
        }
    }
    sides
}
