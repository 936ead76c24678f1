//! A model -> its mesh and the oracle's verdict.

use crate::chains::all_faults;
use std::sync::Arc;
use trimtess::audit::{self, DeviationReport};
use trimtess::frame::{PlanLimits, Tolerance, plan_within};
use trimtess::mesh::{MemorySink, SceneFacts, check_scene};
use trimtess::model::{Diagnostic, FaceError, Model, Severity};
use trimtess::parallel::{FrameReport, serial};
use trimtess::prepare::internals::EdgeShape;
use trimtess::prepare::{PrepareOptions, Prepared, prepare};

/// Limits of a case: the tests look for degenerate models, not for large ones.
const LIMITS: PlanLimits = PlanLimits::DEFAULT.with_triangles_per_tile(1 << 13).with_triangles(1 << 16);
/// Largest angle between neighbouring triangles, radians.
const ANGLE: f64 = 0.5;

/// A model that has been meshed.
pub(crate) struct Meshed {
    pub(crate) prepared: Arc<Prepared>,
    pub(crate) chord: f64,
    /// Whether the plan is coarser than requested.
    pub(crate) short: bool,
    pub(crate) report: FrameReport,
    pub(crate) mesh: MemorySink,
    pub(crate) facts: SceneFacts,
    /// Segments of B-rep edges and borders that only one tile uses.
    boundary: u64,
}

impl Meshed {
    /// Meshes a model within `chord_rel` of its diagonal.
    pub(crate) fn new(model: Model, chord_rel: f64) -> Result<Self, String> {
        let prepared = Arc::new(prepare(model, &PrepareOptions::DEFAULT).map_err(|error| error.to_string())?);
        let chord = chord_rel * prepared.diagonal;
        let plan = Arc::new(plan_within(&prepared, &Tolerance { chord, angle: ANGLE, max_edge: None }, &LIMITS));
        let mut mesh = MemorySink::default();
        let report = serial(&prepared, &plan, true, &mut mesh).map_err(|error| error.to_string())?;
        let facts = check_scene(&mesh);
        let lines = prepared.parts.iter().zip(&plan.parts).flat_map(|(part, plan)| part.edges.iter().zip(&plan.edges));
        let once = lines.filter(|(edge, _)| edge.uses.len() == 1);
        let segments = once.map(|(edge, line)| match edge.shape {
            EdgeShape::Curve(_) => line.ts.len().saturating_sub(1),
            // A pole has length only where its adjacent edges end near it.
            EdgeShape::Point(pole) => edge.breaks.iter().filter(|end| end.point != pole).count(),
        });
        let boundary = segments.sum::<usize>() as u64;
        Ok(Self { prepared, chord, short: plan.shortfall.is_some(), report, mesh, facts, boundary })
    }

    /// Checks what holds for any model, however broken: the mesh is well formed, and nothing is lost without a
    /// diagnostic.
    pub(crate) fn holds(&self) -> Result<(), String> {
        if !self.facts.total.is_well_formed() {
            return Err(format!("malformed: {}", self.facts.total));
        }
        if let Some(fault) = all_faults(&self.prepared).first() {
            return Err(format!("loops that do not close: {fault}"));
        }
        let told =
            self.prepared.diagnostics.iter().find(|d| matches!(d.kind.face_error(), Some(FaceError::Internal(_))));
        let mut degraded = self.report.degraded.iter().map(|tile| tile.degradation.to_string());
        let panic = told.map(ToString::to_string).or_else(|| degraded.find(|why| why.contains("internal error")));
        if let Some(panic) = panic {
            return Err(format!("a panic inside: {panic}"));
        }
        if let Some(lost) = self.report.lost_lines.first() {
            return Err(format!("no polyline for edge {}: {}", lost.edge.0, lost.why));
        }
        for &(part, face) in &self.facts.faces_without_triangles {
            // Notes and warnings are about faces that have triangles.
            let of_face = |d: &&Diagnostic| d.part == Some(part) && d.face == Some(face);
            let refused = self.prepared.diagnostics.iter().filter(of_face).any(|d| d.severity == Severity::Error);
            let without_area = self.prepared.scene.parts[part.index()].without_area.contains(&face);
            let degraded = self.report.degraded.iter().any(|t| t.part == part && t.face == face);
            if !(refused || without_area || degraded) {
                return Err(format!("face {} of part {} is lost without a diagnostic", face.0, part.0));
            }
        }
        Ok(())
    }

    /// Also checks one face: without a diagnostic, only its open edges are open. Fewer edges may be open, since those
    /// of a broken face may coincide.
    pub(crate) fn is_whole(&self) -> Result<(), String> {
        self.holds()?;
        if self.is_told() || self.facts.total.unbalanced_edges <= self.boundary {
            return Ok(());
        }
        Err(format!("{} open segments are stated: {}", self.boundary, self.facts.total))
    }

    /// Whether a diagnostic calls a face lost or changed.
    fn is_told(&self) -> bool {
        let tells = |d: &Diagnostic| d.severity == Severity::Error || (d.severity > Severity::Note && d.face.is_some());
        self.prepared.diagnostics.iter().any(tells) || !self.report.degraded.is_empty()
    }

    /// Also checks what holds for sound models: nothing lost or doubtful, only the open edges are open, the tolerance
    /// holds. Of a solid that is stated inside out, a warning may say so: if it is a ball cut by a plane, one wrong
    /// sense could be the cause as well.
    pub(crate) fn is_sound(&self, is_inverted: bool) -> Result<(), String> {
        self.holds()?;
        let is_told = |d: &Diagnostic| is_inverted && d.kind.code() == "shell-inside-out";
        let is_doubt = |d: &&Diagnostic| d.severity > Severity::Note && !is_told(d);
        if let Some(told) = self.prepared.diagnostics.iter().find(is_doubt) {
            return Err(format!("{:?}: {}", told.severity, told.kind));
        }
        if let Some(tile) = self.report.degraded.first() {
            return Err(format!("tile {} of face {}: {}", tile.tile.0, tile.face.0, tile.degradation));
        }
        let total = &self.facts.total;
        if total.unbalanced_edges != self.boundary {
            return Err(format!("{} open segments are stated: {total}", self.boundary));
        }
        self.keeps_tolerance()
    }

    /// Checks that the triangles keep the tolerance, unless the plan reached its limits.
    pub(crate) fn keeps_tolerance(&self) -> Result<(), String> {
        if self.short {
            return Ok(());
        }
        let deviation: DeviationReport = audit::deviation(&self.prepared, &self.mesh, self.chord);
        let (surfaces, edges) = (deviation.beyond_gap, deviation.edges);
        let kept = surfaces.p999 <= 1.0 && surfaces.worst <= 1.5 && edges.worst <= 1.05;
        if kept { Ok(()) } else { Err(format!("not within the tolerance: {deviation}")) }
    }
}
