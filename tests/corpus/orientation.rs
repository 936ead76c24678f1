//! Orientation of all files' meshes: solids have positive volume, neighbours agree, no triangle looks inwards.

use crate::common::{frame, prepared};
use crate::flipped::{disagreeing, flipped};
use crate::mesh::mesh;
use crate::read::read;
use crate::reference::{Corpus, corpora, value};
use glam::DVec3;
use trimtess::frame::{Tolerance, plan};
use trimtess::mesh::check_scene;
use trimtess::model::{Frame3, Loop, Model, PartBuilder, ShellKind, Surface};

/// Files whose surfaces fold over themselves, so that their normals look both ways.
const FOLDED: [(&str, &str); 1] =
    [("supersonic_vsp.stp", "plane caps of wing tips run back by 5 mm in their last tenth")];

#[test]
fn every_file_is_turned_outwards_and_no_triangle_is_flipped() {
    let (mut wrong, corpora) = (Vec::new(), corpora());
    for (file, facts, path) in corpora.iter().flat_map(Corpus::files) {
        for relative in [1e-2, 1e-3] {
            let (prepared, sink, report) = mesh(&path, relative);
            let total = check_scene(&sink).total;
            let mut complain = |what: String| wrong.push(format!("{file} at {relative}: {what}"));
            if value(facts, "closed") == Some("true") && (total.volume <= 0.0 || total.volume.is_nan()) {
                complain(format!("volume {}", total.volume));
            }
            let disagreeing = disagreeing(&read(&path), &sink, &report.fills);
            if !disagreeing.is_empty() {
                complain(format!("neighbours disagree about {disagreeing:?}"));
            }
            let folded = FOLDED.iter().any(|(name, _)| *name == file);
            let flipped = flipped(&prepared, &sink, &report.fills);
            if let Some((count, worst)) = flipped.filter(|_| !folded) {
                complain(format!("{count} of {} triangles flipped, the largest: {worst}", total.triangles));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn an_avoidable_fold_is_found() {
    // A quadrilateral with a reflex corner, cut along the wrong diagonal: the same boundary, and one triangle is
    // reversed.
    let mut part = PartBuilder::new("dart");
    let shell = part.plain_shell(ShellKind::Open);
    let corners = [(0.0, 0.0), (4.0, -3.0), (1.0, 0.0), (4.0, 3.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let wire = Loop::Edges(part.polygon(&corners));
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, vec![wire], false);
    let parts = vec![part.finish().expect("a sound part")];
    let model = Model { parts, ..Model::default() };
    let prepared = prepared(model);
    let plan = plan(&prepared, &Tolerance { chord: 0.1, angle: 0.5, max_edge: None });
    let (mut sink, report) = frame(&prepared, &plan, false);
    assert_eq!(flipped(&prepared, &sink, &report.fills), None);
    let mesh = &mut sink.batches[0].mesh;
    let [a, b, c, d] = corners.map(|p| mesh.positions.iter().position(|q| *q == p).expect("a corner") as u32);
    mesh.triangles = vec![[a, b, d], [b, c, d]];
    let count = flipped(&prepared, &sink, &report.fills).map(|(count, _)| count);
    assert_eq!(count, Some(1));
}
