//! Supplemental geometry, from which a shape was constructed: left out with one note per representation, or read on
//! demand.

use crate::{clean, file, point, vertex, world};
use trimtess::import::step::{StepOptions, read};
use trimtess::model::{Model, Severity};

/// A ball in representation #50, and the supplemental items `items` in the linked representation #51.
fn constructed(items: &str, more: &str) -> String {
    world()
        + &point(40, [1.0, 0.0, 0.0])
        + "#50=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#60),#1);#60=MANIFOLD_SOLID_BREP('',#61);\
           #61=CLOSED_SHELL('',(#62));\
           #62=ADVANCED_FACE('',(),#63,.T.);#63=SPHERICAL_SURFACE('',#20,1.);\
           #52=CONSTRUCTIVE_GEOMETRY_REPRESENTATION_RELATIONSHIP('','',#50,#51);\
           #70=PLANE('',#20);#71=CYLINDRICAL_SURFACE('',#20,3.);#72=LINE('',#21,#73);#73=VECTOR('',#22,1.);\
           #74=SPHERICAL_SURFACE('',#20,2.);#75=ADVANCED_FACE('',(),#74,.T.);#76=OPEN_SHELL('',(#75));\
           #77=GEOMETRIC_SET('',(#70,#71));"
        + &format!("#51=CONSTRUCTIVE_GEOMETRY_REPRESENTATION('',({items}),#1);{more}")
}

fn with(text: &str, supplemental: bool) -> Model {
    let options = StepOptions::DEFAULT.with_supplemental(supplemental);
    read(file(text).as_bytes(), &options).expect("a readable file")
}

fn told(model: &Model, severity: Severity) -> Vec<(u64, String)> {
    model.diagnostics.iter().filter(|d| d.severity == severity).map(|d| (d.entity, d.kind.to_string())).collect()
}

fn faces(model: &Model) -> Vec<Vec<u64>> {
    model.parts.iter().map(|part| part.faces.iter().map(|face| face.entity).collect()).collect()
}

#[test]
fn supplemental_geometry_is_left_out_with_one_note() {
    for (items, counts) in [
        ("#70", "1 PLANE"),
        ("#70,#71,#72,#40", "1 CARTESIAN_POINT, 1 CYLINDRICAL_SURFACE, 1 LINE, 1 PLANE"),
        ("#75", "1 ADVANCED_FACE"),
        ("#76", "1 OPEN_SHELL"),
        ("#77", "1 GEOMETRIC_SET"),
        ("#99", "1 missing"),
    ] {
        let model = with(&constructed(items, ""), false);
        clean(&model);
        // Where only the shell or the face is missing from the list, it has no owner.
        assert_eq!(faces(&model)[0], [62], "{items}");
        let notes = told(&model, Severity::Note);
        assert!(notes.len() == 1 && notes[0].0 == 51 && notes[0].1.contains(counts), "{items}: {notes:?}");
        assert!(notes[0].1.contains("--supplemental"), "{notes:?}");
    }
    // The face of an omitted shell is omitted too.
    assert_eq!(faces(&with(&constructed("#76", ""), false)), [[62]]);
}

#[test]
fn supplemental_geometry_is_read_on_demand() {
    let model = with(&constructed("#74,#76,#72", ""), true);
    clean(&model);
    assert_eq!(faces(&model), [[62, 74, 75]], "one part: {:?}", model.diagnostics);
    let notes = told(&model, Severity::Note);
    assert!(notes.len() == 1 && notes[0].0 == 51 && notes[0].1.contains("1 LINE"), "{notes:?}");
    // Unbounded entities are reported by number.
    for items in ["#70,#71", "#77"] {
        let model = with(&constructed(items, ""), true);
        let warnings = told(&model, Severity::Warning);
        let entities: Vec<u64> = warnings.iter().map(|(entity, _)| *entity).collect();
        assert_eq!(entities, [70, 71], "{warnings:?}");
        assert!(warnings.iter().all(|(_, reason)| reason.contains("without bounds")), "{warnings:?}");
        assert_eq!(faces(&model)[0], [62]);
        assert!(told(&model, Severity::Error).is_empty());
    }
}

#[test]
fn supplemental_geometry_in_cycles_and_mapped_terminates() {
    // Two supplemental representations linked to each other, one of them mapped.
    let more = "#53=CONSTRUCTIVE_GEOMETRY_REPRESENTATION('',(#71),#1);\
                #54=CONSTRUCTIVE_GEOMETRY_REPRESENTATION_RELATIONSHIP('','',#51,#53);\
                #55=CONSTRUCTIVE_GEOMETRY_REPRESENTATION_RELATIONSHIP('','',#53,#51);\
                #56=REPRESENTATION_MAP(#20,#53);#57=MAPPED_ITEM('',#56,#20);#58=SHAPE_REPRESENTATION('',(#57,#60),#1);";
    let model = with(&constructed("#70", more), false);
    clean(&model);
    let notes: Vec<u64> = told(&model, Severity::Note).into_iter().map(|(entity, _)| entity).collect();
    assert_eq!(notes, [51, 53]);
    let all = with(&constructed("#70", more), true);
    assert_eq!(told(&all, Severity::Warning).len(), 2, "{:?}", all.diagnostics);
}

#[test]
fn surfaces_without_bounds_beside_a_shape_are_counted() {
    let beside = constructed("#72", "").replace("('',(#60),#1)", "('',(#70,#71,#60,#77),#1)");
    let model = with(&beside, false);
    clean(&model);
    assert_eq!(faces(&model)[0], [62]);
    let notes = told(&model, Severity::Note);
    assert!(notes.len() == 2 && notes[0].0 == 50, "{notes:?}");
    assert!(notes[0].1.contains("1 CYLINDRICAL_SURFACE, 1 PLANE"), "{notes:?}");
    let model = with(&beside, true);
    assert_eq!(told(&model, Severity::Warning).len(), 2, "{:?}", model.diagnostics);
}

#[test]
fn a_supplemental_face_keeps_its_edges() {
    let disc = vertex(30, [2.0, 0.0, 0.0])
        + "#64=CIRCLE('',#20,2.);#65=EDGE_CURVE('',#30,#30,#64,.T.);#66=ORIENTED_EDGE('',*,*,#65,.T.);\
           #67=EDGE_LOOP('',(#66));#68=FACE_OUTER_BOUND('',#67,.T.);#69=FACE_SURFACE('',(#68),#70,.T.);";
    let model = with(&constructed("#69", &disc), true);
    clean(&model);
    assert_eq!((&faces(&model)[0], model.parts[0].edges.len()), (&vec![62, 69], 1));
}
