//! Levels of detail of a GLB: coarser meshes of the same model, each made, checked and reported like the finest.

use crate::limits::LimitArgs;
use crate::report::{Entry, Report, millimetres};
use crate::rounded::ReadBackRow;
use crate::{Failure, made};
use serde::Serialize;
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;
use std::fmt;
use std::sync::Arc;
use trimtess::frame::{self, Tolerance};
use trimtess::mesh::{MemorySink, MeshLists};
use trimtess::prepare::Prepared;

/// Chord tolerance of a level, in units of that of the level before. A curve takes half as many segments, a surface
/// curved both ways a quarter of the triangles.
const COARSER: f64 = 4.0;

/// Maximum number of levels: the last has a chord tolerance 65 536 times that of the mesh.
pub(crate) const MOST: u8 = 8;

/// What the report tells about a level.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct LevelRow {
    chord_mm: f64,
    angle_deg: f64,
    /// Triangles in the file.
    triangles: u64,
    collapsed_triangles: u64,
    rounding_mm: f64,
    /// With `--check`, as those of the report.
    unbalanced_edges: Option<u64>,
    p999_deviation_over_tolerance: Option<f64>,
    read_back: Option<ReadBackRow>,
}

impl fmt::Display for LevelRow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { angle_deg, triangles, .. } = self;
        let chord = millimetres(self.chord_mm);
        write!(f, "  level of detail: {triangles} triangles; chord {chord} mm, angle {angle_deg}°")?;
        if let (Some(unbalanced), Some(p999)) = (self.unbalanced_edges, self.p999_deviation_over_tolerance) {
            write!(f, "; {unbalanced} unbalanced edges, deviation {p999:.3} of its tolerance in 99.9 % of samples")?;
        }
        writeln!(f)
    }
}

/// A mesh of the model: the finest, or a level of detail.
pub(crate) struct Level {
    pub(crate) tolerance: Tolerance,
    pub(crate) frame: MemorySink,
    /// About this mesh alone.
    pub(crate) report: Report,
}

impl Level {
    /// Makes level `number` of a model whose finest mesh, level 0, has this tolerance. `max_edge` grows with the angle.
    pub(crate) fn make(
        prepared: &Arc<Prepared>,
        finest: &Tolerance,
        number: u8,
        lists: (bool, MeshLists),
        limits: &LimitArgs,
    ) -> Result<Self, Failure> {
        let mut tolerance = *finest;
        if number > 0 {
            let chord = COARSER.powi(i32::from(number));
            tolerance.chord *= chord;
            // More than a quarter turn counts as one.
            tolerance.angle = (tolerance.angle * chord.sqrt()).min(FRAC_PI_2);
            tolerance.max_edge = tolerance.max_edge.map(|length| length * chord.sqrt());
        }
        let plan = Arc::new(frame::plan_within(prepared, &tolerance, &limits.plan()));
        let (frame, mut report) = made::make(prepared, &plan, lists, limits)?;
        report.diagonal_mm = prepared.diagonal;
        if number == 0 {
            // Without coarser levels the process exits soon: dropping large structures would only delay it.
            std::mem::forget(plan);
        }
        Ok(Self { tolerance, frame, report })
    }

    /// Adds the level to the report: its row, and the diagnostics that the report does not have yet.
    pub(crate) fn add_to(self, report: &mut Report, number: usize) {
        let told = self.report;
        report.levels.push(LevelRow {
            chord_mm: self.tolerance.chord,
            angle_deg: self.tolerance.angle.to_degrees(),
            triangles: told.triangles,
            collapsed_triangles: told.collapsed_triangles,
            rounding_mm: told.rounding_mm,
            unbalanced_edges: told.unbalanced_edges,
            p999_deviation_over_tolerance: told.p999_deviation_over_tolerance,
            read_back: told.read_back,
        });
        let known: BTreeSet<(&str, Option<u64>)> =
            report.diagnostics.iter().map(|known| (known.code, known.face_id)).collect();
        let is_new = |entry: &Entry| entry.face_id.is_none() || !known.contains(&(entry.code, entry.face_id));
        // What reading and preparing told of no face is not of this level.
        let reasons: BTreeSet<&str> =
            report.diagnostics.iter().filter(|known| known.face_id.is_none()).map(|known| &known.reason[..]).collect();
        let of_model = |entry: &Entry| entry.face_id.is_none() && reasons.contains(&entry.reason[..]);
        let new: Vec<Entry> = told.diagnostics.into_iter().filter(|entry| is_new(entry) && !of_model(entry)).collect();
        report.diagnostics.extend(new.into_iter().map(|mut entry| {
            entry.reason = format!("level {number}: {}", entry.reason);
            entry
        }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trimtess::model::Severity;

    #[test]
    fn diagnostics_of_a_level_are_told_unless_its_face_or_the_model_has_them() {
        let mut finest = Report::default();
        finest.add(Severity::Note, None, "of-model", "the model".to_owned());
        finest.add(Severity::Warning, Some(3), "tile-empty", "nothing is left".to_owned());
        let mut report = finest.clone();
        report.add(Severity::Warning, Some(7), "tile-empty", "nothing is left".to_owned());
        let tolerance = Tolerance { chord: 1.0, angle: 0.5, max_edge: None };
        Level { tolerance, frame: MemorySink::default(), report }.add_to(&mut finest, 1);
        let told: Vec<_> = finest.diagnostics.iter().map(|entry| (entry.face_id, &entry.reason[..])).collect();
        let expected = [(None, "the model"), (Some(3), "nothing is left"), (Some(7), "level 1: nothing is left")];
        assert_eq!(told, expected);
    }
}
