//! What a frame tells of its tiles and edges -> diagnostics of faces. No face without triangles goes unexplained.

use glam::DVec3;
use std::collections::{BTreeMap, HashSet};
use trimtess::frame::Degradation;
use trimtess::model::{Diagnostic, DiagnosticKind, FaceId, PartId, Severity, TileTrouble};
use trimtess::parallel::{DegradedTile, FrameReport};
use trimtess::prepare::Prepared;
use trimtess::prepare::internals::PreparedFace;

/// Adds one diagnostic per face and severity, with the trouble of the first tile and the number of the others.
pub(crate) fn add_degraded(all: &mut Vec<Diagnostic>, made: &FrameReport, meshed: &[Vec<bool>], prepared: &Prepared) {
    let mut told: BTreeMap<(PartId, FaceId, Severity), (&DegradedTile, u32)> = BTreeMap::new();
    for tile in &made.degraded {
        let lost = !meshed[tile.part.index()][tile.face.index()];
        let severity = match &tile.degradation {
            // Prepare reports the same crossing.
            Degradation::NotSimple { .. } if row_of(prepared, tile.part, tile.face).is_some_and(|row| row.crosses) => {
                continue;
            }
            Degradation::NotSimple { .. } | Degradation::Filled(_) => Severity::Warning,
            Degradation::Empty if lost && !has_no_area(prepared, tile.part, tile.face) => Severity::Warning,
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

/// Whether prepare found that the face is a point or a curve.
fn has_no_area(prepared: &Prepared, part: PartId, face: FaceId) -> bool {
    prepared.scene.parts.get(part.index()).is_some_and(|part| part.without_area.binary_search(&face).is_ok())
}

/// The prepared face; `None` if prepare could not use it.
fn row_of(prepared: &Prepared, part: PartId, face: FaceId) -> Option<&PreparedFace> {
    prepared.parts.get(part.index())?.face(face)
}

/// A point near the middle of a face's first tile, part coordinates.
pub(crate) fn tile_centre(prepared: &Prepared, part: PartId, face: FaceId) -> Option<DVec3> {
    let tile = row_of(prepared, part, face)?.tiles.start;
    Some(prepared.parts[part.index()].tiles.get(tile as usize)?.centre)
}

/// Entity number of a prepared face; 0 if unknown.
pub(crate) fn entity_of(prepared: &Prepared, part: PartId, face: FaceId) -> u64 {
    row_of(prepared, part, face).map_or(0, |row| row.entity)
}

/// Adds an error per edge without a polyline, at the first face that uses it.
pub(crate) fn add_lost_lines(all: &mut Vec<Diagnostic>, made: &FrameReport, prepared: &Prepared) {
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
pub(crate) fn add_unexplained(all: &mut Vec<Diagnostic>, meshed: &[Vec<bool>], prepared: &Prepared) {
    let told = all.iter().filter_map(|d| Some((d.severity, &d.kind, d.part.zip(d.face)?)));
    let explains = |severity, kind: &DiagnosticKind, (part, face)| {
        severity > Severity::Note || NO_AREA.contains(&kind.code()) || has_no_area(prepared, part, face)
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
