//! Exchange structures of ISO 10303-21 editions 2 and 3: anchors, references, signatures, several data sections. None
//! of them costs more than what the file lacks.

use crate::products::product;
use crate::{BALLS, faces, file, world};
use trimtess::import::step::{StepOptions, read};
use trimtess::model::{DiagnosticKind, Model, Severity, StepOutcome, StepTrouble};

fn sound() -> String {
    file(&(world() + BALLS))
}

fn model(text: &str) -> Model {
    read(text.as_bytes(), &StepOptions::default()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn told(model: &Model, least: Severity) -> Vec<(u64, DiagnosticKind)> {
    let told = model.diagnostics.iter().filter(|d| d.severity >= least);
    told.map(|d| (d.entity, d.kind.clone())).collect()
}

#[test]
fn anchors_and_references_before_the_data_are_skipped() {
    for sections in [
        "ANCHOR;\n<top>=#60;\nENDSEC;\n",
        "ANCHOR;\nENDSEC;\nREFERENCE;\n#900=<other.stp#top>;\nENDSEC;\n",
        // Names, values, lists and tags of edition 3, and a name that looks like a section.
        "ANCHOR;\n<a>=#60{tag:'ENDSEC;'};\n<b>=@5;\n<c>=(1.,'x',$);\n<DATA>=\"0F\";\n<ENDSEC>=.T.;\n<e>=#PI;\n\
         ENDSEC;\n",
        "ANCHOR;\n<it's>=#60;\nENDSEC;\nREFERENCE;\n/* DATA; */\n@7=<other.stp#DATA>;\n#901=<#here>;\nENDSEC;\n",
        "SIGNATURE;\nMIIBb+/=\nENDSEC;\n",
        "anchor;\n<top>=#60;\nendsec;\n",
    ] {
        let model = model(&sound().replace("ENDSEC;\nDATA;", &format!("ENDSEC;\n{sections}DATA;")));
        assert_eq!(faces(&model), 2, "{sections}: {:?}", model.diagnostics);
        assert!(told(&model, Severity::Error).is_empty(), "{sections}: {:?}", model.diagnostics);
    }
}

#[test]
fn an_instance_of_another_file_costs_what_uses_it() {
    let text = sound()
        .replace("ENDSEC;\nDATA;", "ENDSEC;\nREFERENCE;\n#73=<other.stp#ball>;\nENDSEC;\nDATA;")
        .replace("#73=SPHERICAL_SURFACE('',#20,2.);\n", "");
    let model = model(&text);
    assert_eq!((faces(&model), model.parts[0].faces.len()), (1, 2));
    let errors = told(&model, Severity::Error);
    assert!(
        errors.len() == 1
            && errors[0].0 == 72
            && matches!(
                errors[0].1.step_trouble(),
                Some(StepTrouble::Elsewhere { place, .. }) if place.contains("other.stp#ball")
            ),
        "{errors:?}"
    );
    assert!(
        told(&model, Severity::Note).iter().any(|(_, kind)| *kind == StepOutcome::ForeignInstances { count: 1 }.into())
    );
}

#[test]
fn files_of_components_are_told() {
    let document = |id: u32, name: &str| format!("#{id}=DOCUMENT_FILE('{name}','','',#99,'',$);\n");
    let documents = document(100, "Wheel.STP") + &document(101, "axle.step") + &document(102, "axle.step");
    let bare = product(200, "wheel", 150) + "#150=SHAPE_REPRESENTATION('',(#20),#1);\n";
    // If all products have a shape, nothing is missing.
    for (more, severity) in [(bare.as_str(), Severity::Warning), ("", Severity::Note)] {
        let data = "DATA;\n".to_owned() + &documents + &document(103, "drawing.pdf") + more;
        let model = model(&sound().replace("DATA;\n", &data));
        let first = vec!["Wheel.STP".to_owned(), "axle.step".to_owned()];
        let files = StepOutcome::ForeignFiles { count: 2, first };
        assert_eq!(files.to_string(), "2 other STEP files are referred to; they are not read: Wheel.STP, axle.step");
        assert_eq!(told(&model, Severity::Note), [(0, files.into())]);
        assert_eq!(model.diagnostics[0].severity, severity);
    }
}

#[test]
fn signatures_are_not_verified() {
    for body in ["MIIBcAYJKoZIhvcNAQcC+/oIIB==\n", "'", "", "'ISO-10303-21;\n#60=A();"] {
        let model = model(&(sound() + "SIGNATURE;\n" + body + "ENDSEC;\nSIGNATURE;\nAA==\nENDSEC;\n"));
        assert_eq!(faces(&model), 2, "{body}");
        assert!(told(&model, Severity::Warning).is_empty(), "{body}: {:?}", model.diagnostics);
        assert!(told(&model, Severity::Note).iter().any(|(_, kind)| *kind == StepOutcome::Signature.into()), "{body}");
    }
    // Longer than the range searched in advance.
    let long = model(&(sound() + "SIGNATURE;\n" + &"AAAA\n".repeat(300_000) + "ENDSEC;\n"));
    assert_eq!((faces(&long), told(&long, Severity::Warning)), (2, Vec::new()));
    // Other text after the end is cut with a warning.
    for more in ["\0\0", "#73=A();", "a second file"] {
        let model = model(&(sound() + more));
        assert_eq!((faces(&model), told(&model, Severity::Error).len()), (2, 0), "{more}: {:?}", model.diagnostics);
        assert!(
            told(&model, Severity::Warning).iter().any(|(_, kind)| *kind == StepOutcome::BehindEnd.into()),
            "{more}"
        );
    }
}

#[test]
fn several_data_sections_are_one() {
    let joined = sound().replace("#70=", "ENDSEC;\nDATA('second; DATA',('AUTOMOTIVE_DESIGN'));\n#70=");
    for text in [joined.clone(), joined.replace("\nDATA;\n", "\nDATA('first',('AUTOMOTIVE_DESIGN'));\n")] {
        let model = model(&text);
        assert_eq!((faces(&model), told(&model, Severity::Warning)), (2, Vec::new()), "{:?}", model.diagnostics);
    }
}

#[test]
fn values_defined_in_other_files_are_unset() {
    let text = sound().replace("#20,2.)", "#20,@12)").replace("#20,1.)", "#20,#PI)");
    let unset = model(&text);
    assert_eq!((faces(&unset), unset.parts[0].faces.len()), (0, 2));
    let warnings = told(&unset, Severity::Warning);
    assert!(
        warnings
            .iter()
            .any(|(_, kind)| matches!(kind, DiagnosticKind::Step(StepOutcome::ForeignValues { count: 2, .. }))),
        "{warnings:?}"
    );
    assert_eq!(warnings.iter().filter(|(entity, _)| [62, 72].contains(entity)).count(), 2, "{warnings:?}");
    let resource = model(&sound().replace("#20,2.)", "#20,<it's;2>)").replace("#20,1.)", "#20,<)"));
    assert_eq!((faces(&resource), resource.parts[0].faces.len()), (0, 2), "{:?}", resource.diagnostics);
    // Within strings they are text.
    let name = sound().replace("('',#20,2.)", "('a<b',#20,2.)").replace("('',#20,1.)", "('<it''s>@1 #PI',#20,1.)");
    assert_eq!((faces(&model(&name)), told(&model(&name), Severity::Note)), (2, Vec::new()));
    // In any number.
    let many: String = (0..100).map(|i| format!("#{}=CARTESIAN_POINT('@1',(@{i},@E,0.));\n", 500 + i)).collect();
    assert_eq!(faces(&crate::editions::model(&file(&(world() + &many + BALLS)))), 2);
}
