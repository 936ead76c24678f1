//! Meshes of all files: no face lost, no crack, correct areas, within the tolerance.

use crate::common::prepared;
use crate::read::read;
use crate::reference::{corpora, value};
use std::path::Path;
use std::sync::Arc;
use trimtess::audit;
use trimtess::frame::{Tolerance, plan};
use trimtess::mesh::{MemorySink, MeshFacts, ScenePart, check_scene};
use trimtess::model::FaceId;
use trimtess::parallel::{FrameReport, Session, SessionOptions};
use trimtess::prepare::Prepared;

pub(crate) fn mesh(path: &Path, relative: f64) -> (Arc<Prepared>, MemorySink, FrameReport) {
    let prepared = prepared(read(path));
    let chord = relative * prepared.diagonal;
    let plan = Arc::new(plan(&prepared, &Tolerance { chord, angle: 30.0_f64.to_radians(), max_edge: None }));
    let mut sink = MemorySink::default();
    let mut session =
        Session::start(Arc::clone(&prepared), &SessionOptions::DEFAULT.with_edge_lines(true)).expect("threads");
    let report = session.frame(plan, &mut sink).expect("a frame");
    (prepared, sink, report)
}

#[test]
fn every_file_is_meshed_whole_and_within_tolerance() {
    let (mut wrong, corpora) = (Vec::new(), corpora());
    for (corpus, (file, facts, path)) in corpora.iter().flat_map(|corpus| corpus.files().map(move |f| (corpus, f))) {
        if value(facts, "status") != Some("ok") {
            continue;
        }
        let (prepared, sink, _) = mesh(&path, 1e-3);
        let chord = 1e-3 * prepared.diagonal;
        let found = check_scene(&sink);
        let mut complain = |what: String| wrong.push(format!("{file}: {what}"));
        if !found.total.is_well_formed() {
            complain(format!("malformed: {}", found.total));
        }
        let open = |(part, mesh): (&ScenePart, &MeshFacts)| part.closed && mesh.unbalanced_edges > 0;
        let closed = value(facts, "closed") == Some("true");
        if closed && found.total.unbalanced_edges > 0 || sink.scene.parts.iter().zip(&found.parts).any(open) {
            complain(format!("{} unbalanced edges", found.total.unbalanced_edges));
        }
        if found.total.defects > 0 {
            complain(format!("{} unbalanced edges where the file does not end", found.total.defects));
        }
        if closed && sink.scene.parts.iter().any(|part| !part.closed) {
            complain("closed in the reference, open by prepare".to_owned());
        }
        let area: f64 = value(facts, "area").and_then(|a| a.parse().ok()).unwrap_or(0.0);
        if !corpus.excepts(file, "area") && (found.total.area / area - 1.0).abs() > 0.02 {
            complain(format!("area {} of {area}", found.total.area));
        }
        for (part, face) in &found.faces_without_triangles {
            let told = |f: &Option<FaceId>| *f == Some(*face);
            if !prepared.diagnostics.iter().any(|d| d.part == Some(*part) && told(&d.face)) {
                complain(format!("face {face:?} of {part:?} is lost without a diagnostic"));
            }
        }
        let deviation = audit::deviation(&prepared, &sink, chord);
        let worst = deviation.beyond_gap.worst.max(deviation.edges.worst);
        if deviation.beyond_gap.p999 > 1.0 || worst > 1.5 {
            complain(format!("deviation is {worst} of the tolerance"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
