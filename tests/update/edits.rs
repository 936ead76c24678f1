//! Random edits of a model: holes moved, faces recoloured, parts swapped, replaced, added, removed.

use crate::random::SplitMix;
use glam::{DAffine3, DVec3};
use std::collections::BTreeSet;
use trimtess::model::{CurveKind, Edge, Instance, Loop, Model, NurbsCurve3, Part, PartId, Surface, VertexId};

/// Parts of a model, at most.
const MOST: usize = 24;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Edit {
    /// A hole of a part moves, or a part has none.
    MoveHole,
    /// Faces, parts and instances get other colours and names.
    Recolour,
    /// Two parts change their numbers.
    Swap,
    /// A part becomes another one.
    Replace,
    /// A part comes, with an instance, anywhere in the list.
    Add,
    /// A part goes, with its instances.
    Remove,
    /// A part comes that another one equals.
    Copy,
    /// All edges and vertices of a part get other numbers.
    Shift,
}

impl Edit {
    pub(crate) const ALL: [Self; 8] =
        [Self::MoveHole, Self::Recolour, Self::Swap, Self::Replace, Self::Add, Self::Remove, Self::Copy, Self::Shift];

    /// Those after which no two parts are equal, if none were before. Of equal ones it does not matter which is taken
    /// over for which, but levels that hysteresis holds may then be those of the other one.
    pub(crate) const DISTINCT: [Self; 6] =
        [Self::MoveHole, Self::Recolour, Self::Swap, Self::Replace, Self::Add, Self::Remove];

    /// Edits `model` with parts of `pool`. Returns how many parts change at most.
    pub(crate) fn apply(self, model: &mut Model, pool: &[Part], draw: &mut SplitMix) -> usize {
        let count = model.parts.len();
        let part = draw.below(count.max(1) as u64) as usize;
        // Like no other one.
        let any = |draw: &mut SplitMix| {
            let part = pool[draw.below(pool.len() as u64) as usize].clone();
            Part { tolerance: 1e-12 * draw.unit(), ..part }
        };
        match self {
            Self::Add | Self::Copy if count < MOST => {
                let at = draw.below(count as u64 + 1) as usize;
                let new = if self == Self::Add { any(draw) } else { model.parts[part].clone() };
                model.parts.insert(at, new);
                model.instances.iter_mut().for_each(|i| i.part.0 += u32::from(i.part.index() >= at));
                let place = DVec3::new(draw.range(-60.0, 60.0), draw.range(-60.0, 60.0), draw.range(-20.0, 20.0));
                let transform = DAffine3::from_translation(place);
                let new = Instance { name: "new".into(), ..Instance::new(PartId::new(at), transform) };
                let row = draw.below(model.instances.len() as u64 + 1) as usize;
                model.instances.insert(row, new);
                1
            }
            Self::Remove if count > 2 => {
                model.parts.remove(part);
                model.instances.retain(|i| i.part.index() != part);
                model.instances.iter_mut().for_each(|i| i.part.0 -= u32::from(i.part.index() > part));
                0
            }
            Self::Swap => {
                let other = draw.below(count as u64) as usize;
                model.parts.swap(part, other);
                let swapped = |p: usize| if p == part { other } else { part };
                let both = model.instances.iter_mut().filter(|i| [part, other].contains(&i.part.index()));
                both.for_each(|i| i.part = PartId::new(swapped(i.part.index())));
                0
            }
            Self::Replace | Self::Remove => {
                model.parts[part] = any(draw);
                1
            }
            Self::Recolour | Self::Add | Self::Copy => {
                recolour(model, part, draw);
                0
            }
            Self::Shift => {
                shift(&mut model.parts[part]);
                1
            }
            Self::MoveHole => {
                let part = &mut model.parts[part];
                let size = part.vertices.iter().fold(0.0_f64, |most, p| most.max(p.abs().max_element()));
                let mut by = || 1e-3 * size * draw.range(-1.0, 1.0);
                let by = DVec3::new(by(), by(), by());
                usize::from(move_hole(part, by, draw.below(u64::MAX) as usize))
            }
        }
    }
}

/// Adds a vertex and an edge that nothing uses before all others.
pub(crate) fn shift(part: &mut Part) {
    let point = part.vertices.first().copied().unwrap_or_default();
    part.vertices.insert(0, point);
    let curve = NurbsCurve3::line(point, point + DVec3::X);
    let unused =
        Edge { range: curve.domain(), curve, start: VertexId(0), end: VertexId(0), kind: CurveKind::Line, entity: 0 };
    for edge in &mut part.edges {
        edge.start.0 += 1;
        edge.end.0 += 1;
    }
    part.edges.insert(0, unused);
    for of in part.faces.iter_mut().flat_map(|face| &mut face.loops) {
        match of {
            Loop::Edges(uses) => uses.iter_mut().for_each(|coedge| coedge.edge.0 += 1),
            Loop::Vertex(vertex) => vertex.0 += 1,
        }
    }
}

fn recolour(model: &mut Model, part: usize, draw: &mut SplitMix) {
    let mut colour = || Some([0; 4].map(|_| draw.unit() as f32));
    let of_part = &mut model.parts[part];
    of_part.colour = colour();
    of_part.name.push('\'');
    of_part.faces.iter_mut().step_by(3).for_each(|face| {
        face.colour = colour();
        face.name.push('\'');
    });
    if let Some(instance) = model.instances.iter_mut().find(|i| i.part.index() == part) {
        (instance.colour, instance.name) = (colour(), "painted".into());
    }
}

/// Moves a cylinder of a part, with its edges and vertices, across its axis: one of them by `which`. Returns whether
/// there is one.
pub(crate) fn move_hole(part: &mut Part, by: DVec3, which: usize) -> bool {
    let cylinder = |surface: &Surface| match surface {
        Surface::Cylinder { frame, radius } => Some((*frame, *radius)),
        _ => None,
    };
    let all: Vec<_> = part.faces.iter().filter_map(|face| cylinder(&face.surface)).collect();
    let Some(&(chosen, wide)) = all.get(which % all.len().max(1)) else { return false };
    let by = by - by.dot(chosen.z) * chosen.z;
    let (mut edges, mut vertices) = (BTreeSet::new(), BTreeSet::new());
    // A hole may be two halves of a cylinder.
    let half = |surface: &Surface| {
        cylinder(surface).is_some_and(|(frame, radius)| {
            radius == wide && (frame.origin - chosen.origin).cross(chosen.z).length() < 1e-6 * wide
        })
    };
    for face in part.faces.iter_mut().filter(|face| half(&face.surface)) {
        if let Surface::Cylinder { frame, .. } = &mut face.surface {
            frame.origin += by;
        }
        for boundary in &face.loops {
            match boundary {
                Loop::Edges(uses) => edges.extend(uses.iter().map(|coedge| coedge.edge)),
                Loop::Vertex(vertex) => _ = vertices.insert(*vertex),
            }
        }
    }
    for edge in &edges {
        let edge = &mut part.edges[edge.index()];
        edge.curve.points.iter_mut().for_each(|point| *point += by);
        vertices.extend([edge.start, edge.end]);
    }
    vertices.iter().for_each(|vertex| part.vertices[vertex.index()] += by);
    true
}
