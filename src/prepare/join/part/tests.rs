//! What panics cost, which no file can cause: the tests cause them, or call what follows.

use super::super::memory::PrepareLimits;
use super::*;
use crate::control::{Alone, Control};
use crate::model::shapes;
use crate::prepare::tiles::draft::DraftAlong;

/// The preparation of a part that needs no healing or sewing.
fn maker<'a>(part: &'a Part, call: Call<'a>) -> PartPreparation<'a> {
    PartPreparation {
        call,
        id: PartId(0),
        free: part.faces.iter().map(|_| None).collect(),
        size: 1.0,
        gap_edges: part.edges.len()..part.edges.len(),
        finely_cut: part.edges.len(),
        part: Cow::Borrowed(part),
        diagnostics: Vec::new(),
    }
}

fn cuboid() -> Part {
    shapes::by_name("box").expect("a shape").parts.remove(0)
}

#[test]
fn a_panic_while_a_face_is_assembled_costs_no_other_face() {
    let (part, control) = (cuboid(), Control::default());
    let call = Call::new(&Alone, &control);
    let mut maker = maker(&part, call);
    let budget = PrepareBudget::new(PrepareLimits::DEFAULT, 6, call);
    let mut faces = maker.fill(maker.draft(None, &budget).results);
    let directed = maker.direct(&mut faces);
    let broken = faces.drafts[2].as_mut().expect("a draft");
    broken.tiles[0].loops[0][0].along = DraftAlong::Border(1000);
    let (prepared, lost) = maker.assemble(faces.drafts, &directed.reversed).expect("no panic");
    let filled: Vec<bool> = prepared.faces.iter().map(|face| face.filled).collect();
    assert_eq!((filled, lost), (vec![false, false, true, false, false, false], Vec::new()));
    assert_eq!(prepared.open_edges().count, 0);
    let told: Vec<_> = maker.diagnostics.iter().map(|d| (d.severity, d.face, d.kind.code())).collect();
    assert_eq!(told, [(Severity::Warning, Some(FaceId(2)), "face-internal-error")]);
}

#[test]
fn a_face_that_cannot_be_filled_is_told_as_lost() {
    let (mut part, control) = (cuboid(), Control::default());
    part.faces[1].loops.clear();
    let mut maker = maker(&part, Call::new(&Alone, &control));
    let cause = FaceError::Internal("why".to_owned());
    let faces = maker.fill_all(&[true, true, false, false, false, false], &cause);
    let filled: Vec<bool> = faces.drafts.iter().map(Option::is_some).collect();
    assert_eq!(filled, [true, false, false, false, false, false]);
    let told = maker.diagnostics.iter().map(|d| (d.severity, d.face, d.kind.to_string().contains("filled")));
    let told: Vec<_> = told.collect();
    assert_eq!(told, [(Severity::Warning, Some(FaceId(0)), true), (Severity::Error, Some(FaceId(1)), false)]);
}
