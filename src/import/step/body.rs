//! Solids without explicit faces (primitives, sweeps, triangulations) -> faces and edges of a part.

use super::contents::{BodyUse, PartContents, ShellUse, Source};
use super::face_surface::Reader;
use super::kinds::BodyKind;
use super::table::{Read, Trouble};
use super::{csg, sweep, tessellated};
use crate::model::{
    Coedge, Diagnostic, DiagnosticKind, EdgeId, Face, Loop, Part, Severity, ShellKind, StepCause, StepOutcome,
    StepTrouble, VertexId,
};
use glam::DVec3;

impl Reader<'_> {
    /// Makes a part of a body's faces, with diagnostics of what was left out. If that is all of it, the part is empty.
    pub(super) fn body(&self, body: &BodyUse) -> (Part, Vec<Diagnostic>) {
        self.read_body(body).unwrap_or_else(|trouble| {
            let place = self.geometry(body.units).place_near(body.entity);
            (Part::default(), vec![lost(body, place, StepOutcome::BodyLeftOut(cause(trouble)))])
        })
    }

    fn read_body(&self, body: &BodyUse) -> Read<(Part, Vec<Diagnostic>)> {
        let geometry = self.geometry(body.units);
        let item = geometry.get(body.entity)?;
        let (mut part, diagnostics) = match body.kind {
            BodyKind::Primitive => (csg::primitive(&geometry, item)?, Vec::new()),
            BodyKind::Tessellated => {
                let (part, left_out) = tessellated::triangles(&geometry, item)?;
                let told = |(trouble, place)| lost(body, place, StepOutcome::LeftOutOfBody(cause(trouble)));
                (part, left_out.into_iter().map(told).collect())
            }
            BodyKind::Sweep => {
                let sweep = sweep::Sweep::read(&geometry, item)?;
                let (profile, diagnostics) = self.profile(sweep.profile, body)?;
                (sweep.solid(&profile)?, diagnostics)
            }
        };
        for face in &mut part.faces {
            // A triangle has the number of the face that lists it.
            let own = Some(face.entity).filter(|entity| *entity != 0);
            face.entity = own.unwrap_or(body.entity);
            face.colour = own.and_then(|entity| self.styles.of(entity)).or(body.colour);
        }
        part.shells.iter_mut().for_each(|shell| shell.entity = body.entity);
        Ok((part, diagnostics))
    }

    /// Reads the swept area or face, as the only face of a part. The diagnostics name no face or edge, since those of
    /// the solid have other numbers.
    fn profile(&self, source: Source, body: &BodyUse) -> Read<(Part, Vec<Diagnostic>)> {
        let faces = vec![(source, false)];
        let shell = ShellUse { kind: ShellKind::Open, entity: source.id(), faces, colour: None, units: body.units };
        let gathered = PartContents { shells: vec![shell], ..PartContents::default() };
        let (part, diagnostics) = self.part("", &gathered, None);
        let trouble = |StepCause { entity, trouble }| Trouble { entity: entity.unwrap_or(source.id()), what: trouble };
        // Such a face has a surface that stands in for its own.
        if let Some(cause) = part.faces.iter().find_map(|face| face.refused.clone()) {
            return Err(trouble(cause));
        }
        if part.faces.iter().all(|face| !face.lost) {
            let of_solid = |told| Diagnostic { face: None, edge: None, ..told };
            return Ok((part, diagnostics.into_iter().map(of_solid).collect()));
        }
        let cause = diagnostics.into_iter().find_map(|d| match d.kind {
            DiagnosticKind::Step(StepOutcome::FaceLeftOut(cause)) => Some(cause),
            _ => None,
        });
        let unread = || Trouble::new(source.id(), StepTrouble::Unread { what: "the profile" });
        Err(cause.map_or_else(unread, trouble))
    }
}

fn cause(trouble: Trouble) -> StepCause {
    StepCause { entity: Some(trouble.entity), trouble: trouble.what }
}

/// The diagnostic that a body, or some of it, was left out.
fn lost(body: &BodyUse, place: Option<DVec3>, what: StepOutcome) -> Diagnostic {
    Diagnostic { entity: body.entity, place, ..Diagnostic::new(Severity::Error, what) }
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
