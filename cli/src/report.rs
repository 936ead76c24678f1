//! A finished frame -> the report: counts per instance, diagnostics per placed face, seconds, memory.

use crate::closedness::{self, Closedness, Fill, placed_fills};
use crate::levels::LevelRow;
use crate::limits::peak_memory;
use crate::outputs::Outputs;
use crate::rounded::{ReadBackRow, words};
use crate::{Common, Done, Failure};
use serde::Serialize;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::time::Instant;
use trimtess::audit::{DeviationReport, EconomyReport};
use trimtess::frame::{Ladder, Rung};
use trimtess::mesh::{FrameView, MemorySink, Scene, SceneInstance};
use trimtess::model::{Diagnostic, PartId, Severity};
use trimtess::parallel::FrameReport;
use trimtess::prepare::Prepared;

/// The code of the warning that a mesh is coarser than asked.
const COARSER: &str = "plan-coarser";

/// Maximum number of diagnostics printed to standard error without `-v`. The rest is only counted.
const PRINTED: usize = 12;

/// Seconds per stage, from where the command begins its work.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Seconds {
    pub(crate) read: f64,
    pub(crate) prepare: f64,
    pub(crate) tessellate: f64,
    /// `None` without `--check`.
    pub(crate) check: Option<f64>,
    pub(crate) write: f64,
    /// Their sum.
    total: f64,
}

impl Seconds {
    pub(crate) fn new([read, prepare, tessellate, write]: [f64; 4], check: Option<f64>) -> Self {
        let total = read + prepare + tessellate + check.unwrap_or(0.0) + write;
        Self { read, prepare, tessellate, check, write, total }
    }
}

/// Ends a stage: its seconds since `begun`, when the next one begins.
pub(crate) fn lap(begun: &mut Instant) -> f64 {
    let before = std::mem::replace(begun, Instant::now());
    (*begun - before).as_secs_f64()
}

/// A reported diagnostic.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Entry {
    #[serde(serialize_with = "by_name")]
    pub(crate) severity: Severity,
    /// The face, numbered across all instances, as in a PLY file.
    pub(crate) face_id: Option<u64>,
    pub(crate) part: Option<u32>,
    /// The face's number within its part, as in `info`.
    pub(crate) face: Option<u32>,
    pub(crate) entity: Option<u64>,
    /// Position in the model, millimetres; without a face, that of the part's first instance.
    pub(crate) place: Option<[f64; 3]>,
    /// Stable code, listed in `docs/diagnostics.md`.
    pub(crate) code: &'static str,
    pub(crate) reason: String,
}

/// The report of a frame. Counts are per instance: a part placed twice counts twice.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Report {
    pub(crate) input: String,
    pub(crate) output: String,
    pub(crate) parts: usize,
    pub(crate) instances: usize,
    pub(crate) faces: u64,
    pub(crate) faces_without_triangles: u64,
    /// Number of faces per rung of the ladder of fallbacks.
    #[serde(serialize_with = "by_rung")]
    pub(crate) ladder: Ladder,
    pub(crate) diagnostics: Vec<Entry>,
    /// Triangles in the file.
    pub(crate) triangles: u64,
    /// Triangles left out of the file, because corners of them round to one position.
    pub(crate) collapsed_triangles: u64,
    /// Upper bound on the distance that the file's numbers move a vertex, millimetres.
    pub(crate) rounding_mm: f64,
    /// Add this to positions in the file to get those of the model, millimetres. Zero without `--recenter`.
    pub(crate) offset_mm: [f64; 3],
    /// What the written file holds. With `--check`; null if the output is a device or a pipe.
    pub(crate) read_back: Option<ReadBackRow>,
    pub(crate) vertices: u64,
    /// Coarser levels of detail in the file, finest first.
    pub(crate) levels: Vec<LevelRow>,
    /// Slivers: triangles that only close a face.
    pub(crate) slivers: u64,
    /// Faces with slivers, or with area whose winding number is not 1.
    pub(crate) fills: Vec<Fill>,
    /// Mesh edges whose directed uses do not cancel. With `--check`.
    pub(crate) unbalanced_edges: Option<u64>,
    /// Mesh edges with one triangle. With `--check`.
    pub(crate) open_edges: Option<u64>,
    /// Cracks: unbalanced edges where the file has no free edge. With `--check`.
    pub(crate) defects: Option<u64>,
    /// Closedness of each part in the file and in the mesh. With `--check`.
    pub(crate) closedness: Option<Vec<Closedness>>,
    /// Maximum distance between mesh and exact geometry beyond the gaps in the file, divided by the chord tolerance.
    /// With `--check`; null if nothing was measured.
    pub(crate) max_deviation_over_tolerance: Option<f64>,
    /// The 99.9th percentile of that distance.
    pub(crate) p999_deviation_over_tolerance: Option<f64>,
    /// Maximum distance between edge polylines and their curves, divided by the chord tolerance.
    pub(crate) max_edge_deviation_over_tolerance: Option<f64>,
    /// Triangles made on curved tiles, per triangle that their boundary or the smallest uniform lattice needs.
    pub(crate) triangles_per_needed: Option<f64>,
    /// Triangles made on curved tiles, per triangle of the smallest uniform lattices alone.
    pub(crate) triangles_per_lattice: Option<f64>,
    /// The measurements behind these numbers.
    #[serde(skip)]
    pub(crate) deviation: Option<DeviationReport>,
    #[serde(skip)]
    pub(crate) economy: Option<EconomyReport>,
    pub(crate) chord_mm: Option<f64>,
    pub(crate) angle_deg: Option<f64>,
    pub(crate) diagonal_mm: f64,
    /// Threads.
    pub(crate) workers: usize,
    pub(crate) seconds: Seconds,
    /// Peak resident memory of the process; null if unknown.
    pub(crate) peak_memory_bytes: Option<u64>,
}

impl Report {
    /// Counts a frame and collects its diagnostics. Every face without triangles gets one.
    pub(crate) fn of(frame: &MemorySink, prepared: &Prepared, made: &FrameReport) -> Self {
        let scene = &frame.scene;
        let mut sizes = vec![(0_u64, 0_u64); scene.parts.len()];
        let view = FrameView::from(frame);
        let meshed = view.meshed();
        for batch in &frame.batches {
            let (triangles, vertices) = &mut sizes[batch.part.index()];
            *triangles += batch.mesh.triangles.len() as u64;
            *vertices += batch.mesh.positions.len() as u64;
        }
        let mut report = Self { parts: scene.parts.len(), instances: scene.instances.len(), ..Self::default() };
        for instance in &scene.instances {
            let part = instance.part.index();
            report.faces += meshed[part].len() as u64;
            report.faces_without_triangles += meshed[part].iter().filter(|meshed| !**meshed).count() as u64;
            report.triangles += sizes[part].0;
            report.vertices += sizes[part].1;
            let off_normal = rows_of(&made.rungs, instance.part, |face| face.part);
            let normal = off_normal.iter().fold(meshed[part].len() as u64, |normal, face| {
                report.ladder.add(face.rung, 1);
                normal.saturating_sub(1)
            });
            report.ladder.add(Rung::Normal, normal);
        }
        report.diagnostics = placed(&made.diagnostics(&view, prepared), scene);
        report.fills = placed_fills(made, scene);
        report.slivers = report.fills.iter().map(|fill| u64::from(fill.slivers)).sum();
        report
    }

    /// `WithDiagnostics` if there is an error, a warning about a face, or no face at all.
    pub(crate) fn done(&self) -> Done {
        let counts = |entry: &Entry| entry.severity.is_fault(entry.face_id.is_some());
        if self.faces == 0 || self.diagnostics.iter().any(counts) { Done::WithDiagnostics } else { Done::Clean }
    }

    /// Adds an error of `--check`.
    pub(crate) fn add_error(&mut self, reason: String) {
        self.add(Severity::Error, None, "check-failed", reason);
    }

    /// Adds a diagnostic that only the program reports.
    pub(crate) fn add(&mut self, severity: Severity, face_id: Option<u64>, code: &'static str, reason: String) {
        let (part, face, entity, place) = (None, None, None, None);
        self.diagnostics.push(Entry { severity, face_id, part, face, entity, place, code, reason });
    }

    /// Adds the results of the audit.
    pub(crate) fn book(&mut self, deviation: DeviationReport, economy: EconomyReport) {
        let measured = || [deviation.beyond_gap, deviation.edges].into_iter().filter(|spread| spread.samples > 0);
        self.max_deviation_over_tolerance = measured().map(|spread| spread.worst).reduce(f64::max);
        self.p999_deviation_over_tolerance = measured().map(|spread| spread.p999).reduce(f64::max);
        self.max_edge_deviation_over_tolerance = Some(deviation.edges).filter(|e| e.samples > 0).map(|e| e.worst);
        self.triangles_per_needed = (!economy.tiles.is_empty()).then(|| economy.mean());
        self.triangles_per_lattice = (!economy.tiles.is_empty()).then(|| economy.lattice_mean());
        self.deviation = Some(deviation);
        self.economy = Some(economy);
    }

    /// Adds a warning that the plan is coarser than the tolerance.
    pub(crate) fn add_warning(&mut self, reason: String) {
        self.add(Severity::Warning, None, COARSER, reason);
    }

    /// Prints the first diagnostics to standard error, adds the report file and the summary or JSON to the
    /// outputs.
    pub(crate) fn publish(
        &mut self,
        common: &Common,
        as_json: bool,
        file: Option<&Path>,
        outputs: &mut Outputs,
    ) -> Result<Done, Failure> {
        self.peak_memory_bytes = peak_memory();
        // Worst first, otherwise in the order of arrival.
        self.diagnostics.sort_by_key(|entry| std::cmp::Reverse(entry.severity));
        let least = match (common.quiet, common.verbose) {
            (true, _) => Severity::Error,
            (false, 0) => Severity::Warning,
            (false, _) => Severity::Note,
        };
        // A closed standard error is not an error.
        let _ = std::io::stderr().write_all(self.told_diagnostics(least).as_bytes());
        if let Some(path) = file {
            outputs.write_json(path, self)?;
        }
        if as_json {
            outputs.tell_json(self)?;
        } else if !common.quiet {
            outputs.tell(&self.summary());
        }
        Ok(self.done())
    }

    /// The first diagnostics of at least this severity; all of them if notes are asked for.
    fn told_diagnostics(&self, least: Severity) -> String {
        let mut text = String::new();
        let told: Vec<&Entry> = self.diagnostics.iter().filter(|entry| entry.severity >= least).collect();
        let most = if least == Severity::Note { told.len() } else { PRINTED };
        for entry in told.iter().take(most) {
            let _ = writeln!(text, "{entry}");
        }
        if told.len() > most {
            let _ = writeln!(text, "… and {} more (-v prints all, --report writes all)", told.len() - most);
        }
        text
    }

    /// The summary for people.
    pub(crate) fn summary(&self) -> String {
        let mut text = String::new();
        let _ = writeln!(text, "{} -> {}", self.input, self.output);
        let _ = writeln!(
            text,
            "  {} faces in {} parts, {} instances; {} faces without triangles",
            self.faces, self.parts, self.instances, self.faces_without_triangles,
        );
        let _ = writeln!(text, "  diagnostics: {}", counted(self.diagnostics.iter().map(|entry| entry.severity)));
        let _ = writeln!(text, "  ladder: {}", self.ladder);
        let _ = write!(text, "  {} triangles, {} vertices", self.triangles, self.vertices);
        text += &words(self);
        if self.slivers > 0 {
            // Other fills have rewound area alone.
            let faces = self.fills.iter().filter(|fill| fill.slivers > 0).count();
            let _ = write!(text, ", {} slivers that only close {faces} faces", self.slivers);
        }
        if let (Some(chord), Some(angle)) = (self.chord_mm, self.angle_deg) {
            let relative = if self.diagonal_mm > 0.0 { chord / self.diagonal_mm } else { 0.0 };
            let chord = millimetres(chord);
            let _ = write!(text, "; chord {chord} mm ({relative:.1e} of the diagonal), angle {angle}°");
            if self.diagnostics.iter().any(|entry| entry.code == COARSER) {
                text += " asked, and not kept everywhere";
            }
        }
        text.push('\n');
        text += &self.levels.iter().map(ToString::to_string).collect::<String>();
        if let (Some(open), Some(unbalanced)) = (self.open_edges, self.unbalanced_edges) {
            let _ = write!(
                text,
                "  check: {open} open edges, {unbalanced} unbalanced, {} cracks",
                self.defects.unwrap_or(0)
            );
            if let (Some(worst), Some(p999)) = (self.max_deviation_over_tolerance, self.p999_deviation_over_tolerance) {
                let _ =
                    write!(text, "; deviation {worst:.3} of the tolerance at worst, {p999:.3} in 99.9 % of samples");
            }
            text.push('\n');
            text += &closedness::lines(self.closedness.as_deref().unwrap_or_default());
        }
        if let Some(deviation) = &self.deviation {
            // The table without the places that follow it, which -v logs.
            for line in deviation.to_string().lines().take(deviation.kinds.len() + 4) {
                let _ = writeln!(text, "  {line}");
            }
        }
        if let Some(line) = self.economy.as_ref().filter(|e| !e.tiles.is_empty()).map(ToString::to_string) {
            let _ = writeln!(text, "  {}", line.lines().next().unwrap_or_default());
        }
        let Seconds { read, prepare, tessellate, check, write, total } = self.seconds;
        let _ = write!(text, "  seconds: read {read:.3}, prepare {prepare:.3}, tessellate {tessellate:.3}, ");
        if let Some(check) = check {
            let _ = write!(text, "check {check:.3}, ");
        }
        let _ = write!(text, "write {write:.3}, total {total:.3}");
        if let Some(bytes) = self.peak_memory_bytes {
            let _ = write!(text, "; peak memory {} MiB", bytes >> 20);
        }
        text.push('\n');
        text
    }
}

/// Errors, warnings and notes, counted in words.
pub(crate) fn counted(severities: impl Iterator<Item = Severity> + Clone) -> String {
    let count = |of: Severity| severities.clone().filter(|severity| *severity == of).count();
    let [errors, warnings, notes] = [Severity::Error, Severity::Warning, Severity::Note].map(count);
    format!("{errors} errors, {warnings} warnings, {notes} notes")
}

/// A length with four decimals, or with an exponent if it is too small or too large for them.
pub(crate) fn millimetres(length: f64) -> String {
    if length == 0.0 || (1e-3..1e7).contains(&length.abs()) { format!("{length:.4}") } else { format!("{length:.3e}") }
}

impl std::fmt::Display for Entry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.severity.name(), subject(self.part, self.face, self.entity))?;
        // Another number only where parts or instances come before it.
        if let Some(face_id) = self.face_id.filter(|id| self.face.map(u64::from) != Some(*id)) {
            write!(f, "face_id {face_id}: ")?;
        }
        f.write_str(&self.reason)?;
        match self.place {
            Some([x, y, z]) => write!(f, ", at ({x:.4}, {y:.4}, {z:.4})"),
            None => Ok(()),
        }
    }
}

/// What a diagnostic concerns, with a colon after it; empty if it is the model.
pub(crate) fn subject(part: Option<u32>, face: Option<u32>, entity: Option<u64>) -> String {
    let part = part.map(|part| format!("part {part}"));
    let face = face.map(|face| format!("face {face}"));
    let entity = entity.map(|entity| format!("(#{entity})"));
    let names: Vec<String> = [part, face, entity].into_iter().flatten().collect();
    if names.is_empty() { String::new() } else { names.join(" ") + ": " }
}

/// Serializes a ladder as an object of counts by rung name.
fn by_rung<S: serde::Serializer>(ladder: &Ladder, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(Rung::ALL.iter().map(|rung| (rung.to_string().replace(' ', "_"), ladder.count(*rung))))
}

/// Serializes a severity as its name.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
pub(crate) fn by_name<S: serde::Serializer>(severity: &Severity, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(severity.name())
}

/// The rows of a part, in a list that is sorted by part.
pub(crate) fn rows_of<T>(sorted: &[T], part: PartId, of: impl Fn(&T) -> PartId) -> &[T] {
    let from = &sorted[sorted.partition_point(|row| of(row) < part)..];
    &from[..from.partition_point(|row| of(row) == part)]
}

/// Repeats diagnostics of faces per instance, with the face's number in the scene.
fn placed(all: &[Diagnostic], scene: &Scene) -> Vec<Entry> {
    let mut instances: Vec<&SceneInstance> = scene.instances.iter().collect();
    // Stable: the instances of a part stay in the order of the scene.
    instances.sort_by_key(|instance| instance.part);
    let mut entries = Vec::with_capacity(all.len());
    for diagnostic in all {
        let entity = Some(diagnostic.entity).filter(|&entity| entity != 0);
        let entry = |instance: Option<&SceneInstance>, face_id| Entry {
            severity: diagnostic.severity,
            face_id,
            part: diagnostic.part.map(|part| part.0),
            face: diagnostic.face.map(|face| face.0),
            entity,
            place: diagnostic.place.map(|p| instance.map_or(p, |i| i.transform.transform_point3(p)).to_array()),
            code: diagnostic.kind.code(),
            reason: diagnostic.kind.to_string(),
        };
        let of_part = diagnostic.part.map_or(&[][..], |part| rows_of(&instances, part, |instance| instance.part));
        match diagnostic.face {
            Some(face) => entries.extend(of_part.iter().map(|i| entry(Some(i), Some(i.face_number(face).into())))),
            None => entries.push(entry(of_part.first().copied(), None)),
        }
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DAffine3, DVec3};
    use trimtess::frame::Degradation;
    use trimtess::mesh::{Batch, ScenePart, TileMesh};
    use trimtess::model::EdgeId;
    use trimtess::model::{DiagnosticKind, FaceError, FaceId, FaceTrouble, TileId, TileTrouble};
    use trimtess::parallel::DegradedTile;

    /// Part 0 with three faces, placed twice; part 1 with one face, placed once. Faces 0 and 2 of part 0 have a
    /// triangle.
    fn frame() -> MemorySink {
        let part = |faces: usize| ScenePart { face_colours: vec![None; faces], ..ScenePart::default() };
        let instance = |part: u32, first_face: u32| SceneInstance {
            first_face,
            ..SceneInstance::new(PartId(part), DAffine3::IDENTITY)
        };
        let batch = |face: u32| Batch {
            part: PartId(0),
            face: FaceId(face),
            tile: TileId(face),
            worker: 0,
            mesh: TileMesh { positions: vec![glam::DVec3::ZERO; 4], triangles: vec![[0, 1, 2]], ..TileMesh::default() },
        };
        let instances = vec![instance(0, 0), instance(1, 3), instance(0, 4)];
        let scene = Scene { name: String::new(), parts: vec![part(3), part(1)], instances };
        MemorySink::of(scene, vec![batch(0), batch(2)], Vec::new())
    }

    fn diagnostic(severity: Severity, face: Option<u32>) -> Diagnostic {
        let told = Diagnostic::new(severity, TileTrouble::Failed { why: "why".to_owned() });
        Diagnostic { part: Some(PartId(0)), face: face.map(FaceId), entity: 7, ..told }
    }

    fn prepared(told: Diagnostic) -> Prepared {
        Prepared { diagnostics: vec![told], ..Prepared::default() }
    }

    #[test]
    fn only_a_note_that_a_face_has_no_area_explains_it() {
        let unexplained = |kind: DiagnosticKind| {
            let note = Diagnostic { kind, ..diagnostic(Severity::Note, Some(1)) };
            let report = Report::of(&frame(), &prepared(note), &FrameReport::default());
            report.diagnostics.iter().filter(|entry| entry.reason.contains("no stage")).count()
        };
        assert_eq!(unexplained(TileTrouble::Empty.into()), 3, "face 1 twice, face 3 once");
        assert_eq!(unexplained(FaceTrouble::Unusable(FaceError::NothingKept).into()), 1);
    }

    #[test]
    fn a_scene_without_faces_is_not_clean() {
        assert_eq!(Report::default().done(), Done::WithDiagnostics);
    }

    #[test]
    fn counts_are_per_instance_and_no_face_is_lost_silently() {
        let report = Report::of(&frame(), &Prepared::default(), &FrameReport::default());
        assert_eq!((report.faces, report.faces_without_triangles), (7, 3));
        assert_eq!((report.triangles, report.vertices), (4, 16));
        let faces: Vec<_> = report.diagnostics.iter().map(|entry| entry.face_id).collect();
        assert_eq!(faces, [Some(1), Some(5), Some(3)]);
        assert_eq!(report.done(), Done::WithDiagnostics);
    }

    #[test]
    fn explained_faces_get_no_second_diagnostic() {
        let report = Report::of(&frame(), &prepared(diagnostic(Severity::Error, Some(1))), &FrameReport::default());
        let told: Vec<_> = report.diagnostics.iter().map(|e| (e.face_id, e.entity, e.reason.as_str())).collect();
        let unexplained = (Some(3), None, "no triangles, and no stage said why");
        assert_eq!(
            told,
            [(Some(1), Some(7), "no triangles: why"), (Some(5), Some(7), "no triangles: why"), unexplained]
        );
    }

    #[test]
    fn many_bad_tiles_of_a_face_are_one_diagnostic() {
        let bad = |face: u32, degradation: Degradation, tile: u32| DegradedTile {
            part: PartId(0),
            face: FaceId(face),
            tile: TileId(tile),
            degradation,
        };
        let degraded = vec![
            bad(0, Degradation::NotSimple { split: 1, depth: 1.0, chord: 0.5, place: None }, 0),
            bad(0, Degradation::NotSimple { split: 2, depth: 1.0, chord: 0.5, place: None }, 1),
            bad(1, Degradation::Empty, 2),
            bad(2, Degradation::Empty, 3),
        ];
        let mut made = FrameReport::default();
        made.degraded = degraded;
        let report = Report::of(&frame(), &Prepared::default(), &made);
        let of =
            |face: u64| report.diagnostics.iter().filter(|e| e.face_id == Some(face)).map(|e| e.severity).collect();
        let told: [Vec<Severity>; 3] = [of(0), of(1), of(2)];
        assert_eq!(
            told,
            [vec![Severity::Warning], vec![Severity::Warning], vec![]],
            "an empty tile of a meshed face is not reported"
        );
    }

    #[test]
    fn failed_tiles_and_edges_are_reported_with_face_entity_and_place() {
        use trimtess::model::shapes;
        use trimtess::parallel::{FaceRung, LostLine};
        use trimtess::prepare::{PrepareOptions, prepare};
        let mut model = shapes::by_name("box").expect("a shape");
        model.parts[0].faces[4].entity = 77;
        let prepared = prepare(model, &PrepareOptions::DEFAULT).expect("within the limits");
        let (part, face, tile) = (PartId(0), FaceId(4), TileId(4));
        assert_eq!(prepared.parts[0].tiles[4].face, face);
        let edge = EdgeId(prepared.parts[0].tiles[4].loops[0][0].edge.0);
        let degradation = Degradation::Failed("internal error: bad".into());
        let mut made = FrameReport::default();
        made.degraded = vec![DegradedTile { part, face, tile, degradation }];
        made.rungs = vec![FaceRung { part, face, rung: Rung::Lost }];
        made.lost_lines = vec![LostLine { part, edge, why: "internal error: worse".into() }];
        let faces = (0..6).map(FaceId).filter(|&f| f != face);
        let batch = |face: FaceId| Batch {
            part,
            face,
            tile: TileId(face.0),
            worker: 0,
            mesh: TileMesh { triangles: vec![[0, 1, 2]], ..TileMesh::default() },
        };
        let sink = MemorySink::of(prepared.scene.clone(), faces.map(batch).collect(), Vec::new());
        let report = Report::of(&sink, &prepared, &made);
        let told = &report.diagnostics;
        assert_eq!(told.len(), 2, "{told:?}");
        assert_eq!((told[0].face_id, told[0].entity), (Some(4), Some(77)));
        assert!(told[0].place.is_some() && told[0].reason.contains("bad"), "{told:?}");
        assert!(told[1].face_id.is_some() && told[1].place.is_some() && told[1].reason.contains("worse"), "{told:?}");
        assert_eq!((report.ladder.count(Rung::Normal), report.ladder.count(Rung::Lost)), (5, 1));
        let json = serde_json::to_value(&report).expect("a report");
        assert_eq!(json["ladder"]["lost"], 1);
    }

    #[test]
    fn crossing_wires_and_their_area_are_reported_once() {
        use trimtess::model::{Frame3, Loop, PartBuilder, ShellKind, Surface};
        let mut part = PartBuilder::new("bitten");
        let shell = part.plain_shell(ShellKind::Open);
        // The hole extends beyond the outer wire.
        let square = |a: f64, b: f64| [(a, a), (b, a), (b, b), (a, b)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let (outer, inner) = (part.polygon(&square(0.0, 6.0)), part.polygon(&square(3.0, 8.0)));
        let wires = vec![Loop::Edges(outer), Loop::Edges(inner)];
        part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, wires, false);
        let (prepared, sink, made) = crate::made::meshed(part.finish().expect("a sound part").into(), 0.1);
        assert_eq!(made.degraded.len(), 1, "the tile reports it, too");
        let report = Report::of(&sink, &prepared, &made);
        let told: Vec<_> = report.diagnostics.iter().map(|e| (e.severity, e.face_id)).collect();
        assert_eq!(told, [(Severity::Warning, Some(0)); 2], "{:?}", report.diagnostics);
        let reasons = [0, 1].map(|k| &report.diagnostics[k].reason);
        assert!(reasons[0].contains("crosses") && reasons[1].starts_with("9.000e0 mm²"), "{reasons:?}");
    }

    #[test]
    fn notes_and_warnings_without_a_face_leave_the_status_clean() {
        let mut report = Report { faces: 1, ..Report::default() };
        for (severity, face, done) in [
            (Severity::Note, Some(0), Done::Clean),
            (Severity::Warning, None, Done::Clean),
            (Severity::Warning, Some(0), Done::WithDiagnostics),
            (Severity::Error, None, Done::WithDiagnostics),
        ] {
            report.diagnostics = placed(&[diagnostic(severity, face)], &frame().scene);
            assert_eq!(report.done(), done, "{severity:?} {face:?}");
        }
    }
}
