//! A model -> meshes at four tolerances, each checked against everything that must hold.

use crate::common::{frame, prepared};
use crate::flipped::{disagreeing, flipped};
use std::collections::BTreeSet;
use std::sync::Arc;
use trimtess::audit;
use trimtess::frame::{Degradation, Tolerance, plan};
use trimtess::mesh::{SceneFacts, check_scene};
use trimtess::model::{FaceId, Model, Part};
use trimtess::prepare::Prepared;

/// Chord tolerances as fractions of the first.
const RUNGS: [f64; 4] = [1.0, 1.0 / 4.0, 1.0 / 16.0, 1.0 / 32.0];
/// Largest turn of the normal across a cell, radians.
const ANGLE: f64 = 0.5;

/// A model and its expected results.
#[derive(Default)]
pub(crate) struct Ladder {
    model: Model,
    /// Names the input within its test.
    name: String,
    closed: bool,
    /// First chord tolerance, millimetres; `None` is a hundredth of the diagonal.
    chord: Option<f64>,
    area: Option<f64>,
    volume: Option<f64>,
    pieces: Option<u64>,
    /// Codes of expected diagnostics.
    told: Vec<&'static str>,
    lost: BTreeSet<FaceId>,
    /// Pieces of negative volume.
    voids: u64,
    /// Whether loops touch each other within segments, which is reported and repaired.
    touching: bool,
    /// Whether the chord tolerance is so large that only angles limit the mesh; the bounds on volume are loose then.
    angles_only: bool,
}

impl Ladder {
    fn new(model: Model, closed: bool) -> Self {
        Self { model, closed, ..Self::default() }
    }

    /// A solid with the given volume and area.
    pub(crate) fn solid(part: Part, volume: f64, area: f64) -> Self {
        Self { volume: Some(volume), area: Some(area), ..Self::new(part.into(), true) }
    }

    /// An open shell with the given area.
    pub(crate) fn sheet(part: Part, area: f64) -> Self {
        Self { area: Some(area), ..Self::new(part.into(), false) }
    }

    /// Names the input within its test.
    pub(crate) fn named(self, name: impl std::fmt::Debug) -> Self {
        Self { name: format!("{name:?}"), ..self }
    }

    /// Sets the first chord tolerance, millimetres.
    pub(crate) fn chord(self, chord: f64) -> Self {
        Self { chord: Some(chord), ..self }
    }

    /// Sets the number of connected pieces.
    pub(crate) fn pieces(self, pieces: u64) -> Self {
        Self { pieces: Some(pieces), ..self }
    }

    /// An open shell, by its model.
    pub(crate) fn open(model: Model, area: f64) -> Self {
        Self { area: Some(area), ..Self::new(model, false) }
    }

    /// A closed shell, by its model.
    pub(crate) fn closed(model: Model, area: f64) -> Self {
        Self { area: Some(area), ..Self::new(model, true) }
    }

    /// Sets how many of the pieces are voids.
    pub(crate) fn voids(self, voids: u64) -> Self {
        Self { voids, ..self }
    }

    /// Allows loops to touch each other where one of them has no vertex: segments are split there, and that is
    /// reported.
    pub(crate) fn touching(self) -> Self {
        Self { touching: true, ..self }
    }

    /// Marks the chord tolerance as too large to limit the mesh.
    pub(crate) fn angles_only(self) -> Self {
        Self { angles_only: true, ..self }
    }

    /// Sets the codes of expected diagnostics; each of them must occur.
    pub(crate) fn told(self, codes: &[&'static str]) -> Self {
        Self { told: codes.to_vec(), ..self }
    }

    /// Sets the faces that have no triangles and must be reported.
    pub(crate) fn lost(self, faces: &[u32]) -> Self {
        Self { lost: faces.iter().map(|&f| FaceId(f)).collect(), ..self }
    }

    /// Prepares the model and checks it at every rung.
    pub(crate) fn assert_climbs(&self) {
        let prepared = prepared(self.model.clone());
        let wrong = self.wrong_told(&prepared);
        assert!(wrong.is_empty(), "{} {wrong:#?}\n{:?}", self.name, prepared.diagnostics);
        let first = self.chord.unwrap_or(0.01 * prepared.diagonal);
        for share in RUNGS {
            let wrong = self.wrong_at(&prepared, first * share);
            assert!(wrong.is_empty(), "{} chord {:.3e}: {wrong:#?}", self.name, first * share);
        }
    }

    fn wrong_told(&self, prepared: &Prepared) -> Vec<String> {
        let mut wrong = Vec::new();
        for d in &prepared.diagnostics {
            if !self.told.contains(&d.kind.code()) {
                wrong.push(format!("unexpected: {}", d.kind));
            }
        }
        for code in &self.told {
            if !prepared.diagnostics.iter().any(|d| d.kind.code() == *code) {
                wrong.push(format!("missing diagnostic: {code}"));
            }
        }
        for face in &self.lost {
            if !prepared.diagnostics.iter().any(|d| d.face == Some(*face)) {
                wrong.push(format!("face {} is lost without a diagnostic", face.0));
            }
        }
        wrong
    }

    fn wrong_at(&self, prepared: &Arc<Prepared>, chord: f64) -> Vec<String> {
        let plan = plan(prepared, &Tolerance { chord, angle: ANGLE, max_edge: None });
        let (sink, report) = frame(prepared, &plan, true);
        let mut wrong = Vec::new();
        if let Some(shortfall) = &plan.shortfall {
            wrong.push(shortfall.to_string());
        }
        let split = |d: &Degradation| self.touching && matches!(d, Degradation::NotSimple { .. });
        let degraded = report.degraded.iter().filter(|d| !split(&d.degradation));
        wrong.extend(degraded.map(|d| format!("face {}: {}", d.face.0, d.degradation)));
        wrong.extend(report.lost_lines.iter().map(|l| format!("edge {}: {}", l.edge.0, l.why)));
        let lengths = sink.edge_lines.iter().flat_map(|l| l.points.windows(2)).map(|w| w[0].distance(w[1]));
        let strips = if self.angles_only { 0.0 } else { chord * lengths.sum::<f64>() };
        self.wrong_facts(&check_scene(&sink), chord, strips, &mut wrong);
        let disagreeing = disagreeing(&self.model, &sink, &report.fills);
        if !disagreeing.is_empty() {
            wrong.push(format!("neighbours disagree about {disagreeing:?}"));
        }
        wrong.extend(
            flipped(prepared, &sink, &report.fills)
                .map(|(count, worst)| format!("{count} flipped, the largest: {worst}")),
        );
        let deviation = audit::deviation(prepared, &sink, chord);
        let worst = deviation.beyond_gap.worst.max(deviation.edges.worst);
        if deviation.beyond_gap.p999 > 1.0 || worst > 1.5 {
            wrong.push(deviation.to_string());
        }
        wrong
    }

    fn wrong_facts(&self, facts: &SceneFacts, chord: f64, strips: f64, wrong: &mut Vec<String>) {
        let total = &facts.total;
        let empty: BTreeSet<FaceId> = facts.faces_without_triangles.iter().map(|f| f.1).collect();
        if empty != self.lost {
            wrong.push(format!("faces without triangles: {empty:?}"));
        }
        if !total.is_well_formed() || total.zero_area > 0 {
            wrong.push(format!("malformed: {total}"));
        }
        if self.closed && total.unbalanced_edges > 0 {
            wrong.push(format!("open: {total}"));
        }
        if self.closed && total.negative_components != self.voids {
            wrong.push(format!("inside out: {total}"));
        }
        if let Some(volume) = self.volume {
            // No point is further from the surface than the tolerance, twice that around bends.
            let slack = if self.angles_only { 0.1 * volume } else { 2.0 * chord * total.area + 1e-9 * volume.abs() };
            if (total.volume - volume).abs() > slack {
                wrong.push(format!("volume {} of {volume}", total.volume));
            }
        }
        if let Some(area) = self.area {
            // Inscribed triangles have less area, by the square of the angle; and chords cut strips off along edges.
            let (least, most) = (0.25 * ANGLE * ANGLE * area + strips, 0.02 * area + strips);
            if total.area < area - least || total.area > area + most {
                wrong.push(format!("area {} of {area}", total.area));
            }
        }
        if self.pieces.is_some_and(|pieces| pieces != total.components) {
            wrong.push(format!("{} pieces", total.components));
        }
    }
}
