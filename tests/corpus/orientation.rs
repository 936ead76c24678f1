//! Orientation of all files' meshes: solids have a positive volume, neighbours agree, no triangle looks inwards.

use crate::flipped::{disagreeing, flipped};
use crate::mesh::mesh;
use crate::read::read;
use crate::reference::{Corpus, corpora, value};
use trimtess::mesh::check_scene;

/// Files whose surfaces fold over themselves, so that their normals look both ways.
const FOLDED: [(&str, &str); 1] =
    [("supersonic_vsp.stp", "plane caps of wing tips run back by 5 mm in their last tenth")];

/// Faces (part, face) of which a triangle or two look inwards: where threads run out, between the last points of two edges.
const NARROW: [(&str, &[(u32, u32)]); 1] =
    [("cable_inlet_threads.stp", &[(0, 59), (0, 60), (0, 62), (0, 64), (0, 65), (0, 68)])];

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
            let excused = NARROW.iter().find(|(name, _)| *name == file).map_or(&[][..], |(_, faces)| *faces);
            let flipped = flipped(&prepared, &sink, &report.fills, excused);
            if let Some((count, worst)) = flipped.filter(|_| !folded) {
                complain(format!("{count} of {} triangles flipped, such as {worst}", total.triangles));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
