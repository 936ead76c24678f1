//! What a frame reports of its tiles and edges -> diagnostics of faces. No face without triangles goes unexplained.

use super::commit::FrameReport;
use super::handoff::{DegradedTile, FaceFill};
use crate::frame::Degradation;
use crate::mesh::FrameView;
use crate::model::{Diagnostic, DiagnosticKind, FaceId, PartId, Severity, TileTrouble};
use crate::prepare::Prepared;
use crate::prepare::internals::PreparedFace;
use glam::DVec3;
use std::collections::{BTreeMap, HashSet};

/// Fraction of a face's area that may have a winding number other than 1 without a warning. Noise in boundaries stays
/// far below.
const TOLERATED: f64 = 1e-4;
/// Side of a square, as a share of the model's diagonal, whose area is rounding of the file's numbers.
const ROUNDING: f64 = 1e-7;

impl FrameReport {
    /// All diagnostics of `frame`, which this report is of: those of reading and preparing, then those of its faces and
    /// edges. Every face without triangles has one, or is in
    /// [`ScenePart::without_area`](crate::mesh::ScenePart::without_area). Each part counts once. O(triangles of faces
    /// with [`fills`](Self::fills)).
    #[must_use]
    pub fn diagnostics<'a>(&self, frame: impl Into<FrameView<'a>>, prepared: &Prepared) -> Vec<Diagnostic> {
        let frame = &frame.into();
        let meshed = frame.meshed();
        let mut all = prepared.diagnostics.clone();
        add_degraded(&mut all, self, &meshed, prepared);
        add_lost_lines(&mut all, self, prepared);
        add_rewound(&mut all, self, frame, prepared);
        add_unexplained(&mut all, &meshed, prepared);
        all
    }
}

/// Adds one diagnostic per face and severity, with the trouble of the first tile and the number of the others.
fn add_degraded(all: &mut Vec<Diagnostic>, made: &FrameReport, meshed: &[Vec<bool>], prepared: &Prepared) {
    let mut told: BTreeMap<(PartId, FaceId, Severity), (&DegradedTile, u32)> = BTreeMap::new();
    for tile in &made.degraded {
        let lost =
            !meshed.get(tile.part.index()).and_then(|faces| faces.get(tile.face.index())).is_some_and(|face| *face);
        let severity = match &tile.degradation {
            // Prepare reports the same crossing.
            Degradation::NotSimple { .. } if row_of(prepared, tile.part, tile.face).is_some_and(|row| row.crosses) => {
                continue;
            }
            Degradation::NotSimple { .. } if !is_deep(tile, prepared) => Severity::Note,
            Degradation::NotSimple { .. } | Degradation::Filled(_) => Severity::Warning,
            Degradation::Empty if lost && !prepared.scene.has_no_area(tile.part, tile.face) => Severity::Warning,
            // The tile is thinner than the tolerance; its neighbours close over it.
            Degradation::Empty => continue,
            // Degradations added by later versions of the library.
            _ => Severity::Error,
        };
        told.entry((tile.part, tile.face, severity)).and_modify(|(_, others)| *others += 1).or_insert((tile, 0));
    }
    all.extend(told.into_iter().map(|((part, face, severity), (tile, others))| {
        let kind = DiagnosticKind::Tile { first: tile.degradation.trouble(), others };
        let crossing = match tile.degradation {
            Degradation::NotSimple { place, .. } => place,
            _ => None,
        };
        let rows = prepared.parts.get(part.index());
        let centre = || rows.and_then(|rows| rows.tiles.get(tile.tile.0 as usize)).map(|row| row.centre);
        let (part, entity) = (Some(part), entity_of(prepared, part, face));
        let place = crossing.or_else(centre);
        Diagnostic { part, face: Some(face), entity, place, ..Diagnostic::new(severity, kind) }
    }));
}

/// Whether loops of the tile overlap by more than the chord tolerance, and more than what the file treats as one point.
/// Chords of curves that are tangent in a corner may cross where the curves do not: the mesh is within the tolerance.
fn is_deep(tile: &DegradedTile, prepared: &Prepared) -> bool {
    let coincidence = prepared.parts.get(tile.part.index()).map_or(0.0, |rows| rows.facts.coincidence);
    matches!(tile.degradation, Degradation::NotSimple { depth, chord, .. } if depth > coincidence.max(chord))
}

/// The prepared face; `None` if prepare could not use it.
fn row_of(prepared: &Prepared, part: PartId, face: FaceId) -> Option<&PreparedFace> {
    prepared.parts.get(part.index())?.face(face)
}

/// A point near the middle of a face's first tile, part coordinates.
fn tile_centre(prepared: &Prepared, part: PartId, face: FaceId) -> Option<DVec3> {
    let tile = row_of(prepared, part, face)?.tiles.start;
    Some(prepared.parts[part.index()].tiles.get(tile as usize)?.centre)
}

/// Entity number of a prepared face; 0 if unknown.
fn entity_of(prepared: &Prepared, part: PartId, face: FaceId) -> u64 {
    row_of(prepared, part, face).map_or(0, |row| row.entity)
}

/// Adds an error per edge without a polyline, at the first face that uses it.
fn add_lost_lines(all: &mut Vec<Diagnostic>, made: &FrameReport, prepared: &Prepared) {
    for lost in &made.lost_lines {
        let rows = prepared.parts.get(lost.part.index());
        let edge = rows.and_then(|rows| rows.edges.get(lost.edge.index()));
        let tile = edge.and_then(|edge| edge.uses.first()).map(|used| used.tile);
        let face = tile.and_then(|tile| Some(rows?.tiles.get(tile.0 as usize)?.face));
        let kind = TileTrouble::NoPolyline { part: lost.part, edge: lost.edge, why: lost.why.clone() };
        all.push(Diagnostic {
            part: Some(lost.part),
            face,
            edge: Some(lost.edge),
            entity: face.map_or(0, |face| entity_of(prepared, lost.part, face)),
            place: edge.and_then(|edge| edge.breaks.first()).map(|end| end.point),
            ..Diagnostic::new(Severity::Error, kind)
        });
    }
}

/// Codes of notes that say why a face has no area. Other notes do not explain a face without triangles.
const NO_AREA: [&str; 3] = ["face-without-area", "face-thin", "trims-keep-nothing"];

/// Adds an error for each face without triangles that no stage explained. A note explains a face only if it
/// says that the face has no area.
fn add_unexplained(all: &mut Vec<Diagnostic>, meshed: &[Vec<bool>], prepared: &Prepared) {
    let told = all.iter().filter_map(|d| Some((d.severity, &d.kind, d.part.zip(d.face)?)));
    let explains = |severity, kind: &DiagnosticKind, (part, face)| {
        severity > Severity::Note || NO_AREA.contains(&kind.code()) || prepared.scene.has_no_area(part, face)
    };
    let explained: HashSet<_> =
        told.filter(|(severity, kind, at)| explains(*severity, kind, *at)).map(|(_, _, at)| at).collect();
    for (part, faces) in meshed.iter().enumerate() {
        for face in (0..faces.len()).filter(|&face| !faces[face]) {
            let (part, face) = (PartId::new(part), FaceId::new(face));
            if !explained.contains(&(part, face)) {
                let entity = entity_of(prepared, part, face);
                let (part, face) = (Some(part), Some(face));
                let told = Diagnostic::new(Severity::Error, TileTrouble::Unexplained);
                all.push(Diagnostic { part, face, entity, ..told });
            }
        }
    }
}

/// Adds a warning for each face with rewound area above [`TOLERATED`] and beyond [`ROUNDING`], unless its loops are known
/// to overlap within the tolerance.
fn add_rewound(all: &mut Vec<Diagnostic>, made: &FrameReport, frame: &FrameView<'_>, prepared: &Prepared) {
    // By face with loops that overlap, whether they do so deeply.
    let mut deep: BTreeMap<(PartId, FaceId), bool> = BTreeMap::new();
    for tile in made.degraded.iter().filter(|tile| matches!(tile.degradation, Degradation::NotSimple { .. })) {
        *deep.entry((tile.part, tile.face)).or_default() |= is_deep(tile, prepared);
    }
    let is_slight = |fill: &FaceFill| deep.get(&(fill.part, fill.face)) == Some(&false);
    let rewound = || made.fills.iter().filter(|fill| fill.rewound > 0.0 && !is_slight(fill));
    let mut areas: BTreeMap<(PartId, FaceId), f64> = rewound().map(|fill| ((fill.part, fill.face), 0.0)).collect();
    for batch in &frame.batches {
        let Some(area) = areas.get_mut(&(batch.part, batch.face)) else { continue };
        let at = |corner: u32| batch.mesh.positions[corner as usize];
        let triangles = batch.mesh.triangles.iter().map(|corners| corners.map(at));
        *area += triangles.map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum::<f64>();
    }
    let visible = rewound().map(|fill| (fill, areas[&(fill.part, fill.face)]));
    let least = (ROUNDING * prepared.diagonal).powi(2);
    all.extend(visible.filter(|(fill, area)| fill.rewound > least.max(TOLERATED * area)).map(|(fill, area_mm2)| {
        let kind = TileTrouble::Rewound { rewound_mm2: fill.rewound, area_mm2 };
        Diagnostic {
            part: Some(fill.part),
            face: Some(fill.face),
            entity: entity_of(prepared, fill.part, fill.face),
            place: tile_centre(prepared, fill.part, fill.face),
            ..Diagnostic::new(Severity::Warning, kind)
        }
    }));
}
