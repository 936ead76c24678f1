//! Solids without explicit faces (primitives, sweeps, triangulations) -> faces and edges of a part.

use super::contents::{BodyUse, PartContents, ShellUse, Source};
use super::kinds::BodyKind;
use super::reader::Reader;
use super::table::{Read, Trouble};
use super::tessellated::Loss;
use super::{csg, sweep, tessellated};
use crate::model::{
    Coedge, DiagnosticKind, EdgeId, Face, Loop, Part, ShellKind, StepCause, StepOutcome, StepTrouble, VertexId,
};

impl Reader<'_> {
    /// Makes a part of a body's faces. Also returns what was left out.
    pub(super) fn body(&self, body: &BodyUse) -> Read<(Part, Vec<Loss>)> {
        let geometry = self.geometry(body.units);
        let item = geometry.get(body.entity)?;
        let mut lost = Vec::new();
        let mut part = match body.kind {
            BodyKind::Primitive => csg::primitive(&geometry, item)?,
            BodyKind::Tessellated => {
                let (part, left_out) = tessellated::triangles(&geometry, item)?;
                lost = left_out;
                part
            }
            BodyKind::Sweep => {
                let sweep = sweep::Sweep::read(&geometry, item)?;
                sweep.solid(&self.profile(sweep.profile, body)?)?
            }
        };
        for face in &mut part.faces {
            face.entity = body.entity;
            face.colour = body.colour;
        }
        part.shells.iter_mut().for_each(|shell| shell.entity = body.entity);
        part.check().map_err(|error| Trouble::new(body.entity, error))?;
        Ok((part, lost))
    }

    /// Reads the swept area or face, as the only face of a part.
    fn profile(&self, source: Source, body: &BodyUse) -> Read<Part> {
        let faces = vec![(source, false)];
        let shell = ShellUse { kind: ShellKind::Open, entity: source.id(), faces, colour: None, units: body.units };
        let gathered = PartContents { shells: vec![shell], ..PartContents::default() };
        let (part, diagnostics) = self.part(String::new(), &gathered, None);
        if part.faces.iter().all(|face| !face.lost) {
            return Ok(part);
        }
        let cause = diagnostics.into_iter().find_map(|d| match d.kind {
            DiagnosticKind::Step(StepOutcome::FaceLeftOut(cause)) => Some(cause),
            _ => None,
        });
        Err(match cause {
            Some(StepCause { entity, trouble }) => Trouble { entity: entity.unwrap_or(source.id()), what: trouble },
            None => Trouble::new(source.id(), StepTrouble::Unread { what: "the profile" }),
        })
    }
}

/// Appends `from` to `into` and renumbers its ids.
pub(super) fn append(into: &mut Part, from: Part) {
    let (vertices, edges) = (into.vertices.len(), into.edges.len());
    let shells = u32::try_from(into.shells.len()).unwrap_or(u32::MAX);
    let vertex = |id: VertexId| VertexId::new(vertices + id.index());
    into.vertices.extend(from.vertices);
    into.edges.extend(from.edges.into_iter().map(|mut edge| {
        (edge.start, edge.end) = (vertex(edge.start), vertex(edge.end));
        edge
    }));
    into.shells.extend(from.shells);
    let renumbered = |bound: Loop| match bound {
        Loop::Vertex(id) => Loop::Vertex(vertex(id)),
        Loop::Edges(uses) => Loop::Edges(
            uses.into_iter().map(|use_| Coedge { edge: EdgeId::new(edges + use_.edge.index()), ..use_ }).collect(),
        ),
    };
    into.faces.extend(from.faces.into_iter().map(|face| Face {
        loops: face.loops.into_iter().map(renumbered).collect(),
        shell: face.shell.saturating_add(shells),
        ..face
    }));
}
