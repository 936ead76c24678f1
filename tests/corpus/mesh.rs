//! Meshes of all files: nothing lost, no crack, areas right, the tolerance kept.

use crate::folder::corpus;
use crate::read::read;
use crate::reference::{files, value};
use std::path::Path;
use std::sync::Arc;
use trimtess::audit;
use trimtess::frame::{Tolerance, plan};
use trimtess::mesh::{MemorySink, check_scene};
use trimtess::model::FaceId;
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::{PrepareOptions, Prepared, prepare};

/// Files whose reference area is wrong, and why.
const OTHER_AREA: [(&str, &str); 1] =
    [("thor_gear_motor.step", "the reference holds faces several times as large as the cylinder they lie on")];

pub(crate) fn mesh(path: &Path, relative: f64) -> (Arc<Prepared>, MemorySink, f64) {
    let prepared = Arc::new(prepare(read(path), &PrepareOptions::DEFAULT).expect("within the limits"));
    let chord = relative * prepared.diagonal;
    let plan = Arc::new(plan(&prepared, &Tolerance { chord, angle: 30.0_f64.to_radians(), max_edge: None }));
    let mut sink = MemorySink::default();
    let mut session = Session::start(Arc::clone(&prepared), &SessionOptions::DEFAULT).expect("threads");
    session.frame(&plan, &mut sink).expect("a frame");
    (prepared, sink, chord)
}

#[test]
fn every_file_is_meshed_whole_and_within_tolerance() {
    let Some(corpus) = corpus() else { return };
    let reference = std::fs::read_to_string(corpus.join("reference.jsonl")).expect("reference.jsonl");
    let mut wrong = Vec::new();
    for (file, facts) in files(&reference) {
        if value(facts, "status") != Some("ok") {
            continue;
        }
        let (prepared, sink, chord) = mesh(&corpus.join(file), 1e-3);
        let found = check_scene(&sink);
        let mut complain = |what: String| wrong.push(format!("{file}: {what}"));
        if !found.total.is_well_formed() {
            complain(format!("malformed: {}", found.total));
        }
        if value(facts, "closed") == Some("true") && found.total.unbalanced_edges > 0 {
            complain(format!("{} unbalanced edges", found.total.unbalanced_edges));
        }
        let area: f64 = value(facts, "area").and_then(|a| a.parse().ok()).unwrap_or(0.0);
        let judged = OTHER_AREA.iter().all(|(name, _)| *name != file);
        if judged && (found.total.area / area - 1.0).abs() > 0.02 {
            complain(format!("area {} of {area}", found.total.area));
        }
        for (part, face) in &found.faces_without_triangles {
            let told = |f: &Option<FaceId>| *f == Some(*face);
            if !prepared.diagnostics.iter().any(|d| d.part == Some(*part) && told(&d.face)) {
                complain(format!("face {face:?} of {part:?} is lost in silence"));
            }
        }
        let deviation = audit::deviation(&prepared, &sink, chord);
        let worst = deviation.beyond_gap.worst.max(deviation.edges.worst);
        if deviation.beyond_gap.p999 > 1.0 || worst > 1.5 {
            complain(format!("deviation {worst} of the tolerance"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
