//! Chains and cycles of references, ten thousand long: read to the end or reported, without a stack overflow.

use crate::products::product;
use crate::{file, placement, vertex, world};
use trimtess::import::step::{StepOptions, read};
use trimtess::model::{Model, Severity};

const LENGTH: u32 = 10_000;

/// A ball as solid #60 and what it needs.
const BALL: &str = "#60=MANIFOLD_SOLID_BREP('',#61);\n#61=CLOSED_SHELL('',(#62));\n#62=ADVANCED_FACE('',(),#63,.T.);\n\
    #63=SPHERICAL_SURFACE('',#20,1.);\n";

/// Reads a file with this data; an empty model if the file is refused, which is a valid answer.
fn answered(data: &str) -> Model {
    read(file(data).as_bytes(), &StepOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// Asserts that the model contains the ball, or that an error reports something left out.
fn ball_or_error(model: &Model) {
    let placed = model.instances.iter().any(|i| model.parts[i.part.index()].faces.iter().any(|f| !f.lost));
    let told = model.diagnostics.iter().any(|d| d.severity == Severity::Error);
    assert!(placed || told, "{:?}", model.diagnostics);
}

#[test]
fn nested_assemblies() {
    let mut text = world() + BALL + "#50=SHAPE_REPRESENTATION('',(#20,#60),#1);#51=SHAPE_REPRESENTATION('',(#20),#1);";
    for level in 0..LENGTH {
        let id = 1000 + 10 * level;
        let shape = if level + 1 == LENGTH { 50 } else { 51 };
        text += &product(id, "p", shape);
        if level + 1 < LENGTH {
            text += &format!("#{}=NEXT_ASSEMBLY_USAGE_OCCURRENCE('','','',#{id},#{},$);\n", id + 5, id + 10);
        }
    }
    ball_or_error(&answered(&text));
}

#[test]
fn nested_mapped_items() {
    let mut text = world() + BALL + &placement(30, [1e-3, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
    text += "#999=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#60),#1);\n";
    for level in 0..LENGTH {
        let id = 1000 + 3 * level;
        text += &format!(
            "#{id}=REPRESENTATION_MAP(#20,#{});#{}=MAPPED_ITEM('',#{id},#30);#{}=SHAPE_REPRESENTATION('',(#{}),#1);\n",
            id - 1,
            id + 1,
            id + 2,
            id + 1
        );
    }
    ball_or_error(&answered(&text));
}

#[test]
fn surfaces_curves_shells_and_faces_wrapped_over_and_over() {
    let wrap = |kind: &dyn Fn(u32) -> String, last: u32| -> String {
        let chain = (0..LENGTH).map(|k| {
            let next = if k + 1 == LENGTH { last } else { 1001 + k };
            format!("#{}={};\n", 1000 + k, kind(next))
        });
        chain.collect()
    };
    let line =
        "#64=LINE('',#21,#65);#65=VECTOR('',#23,1.);".to_owned() + &vertex(40, [0.0; 3]) + &vertex(42, [1.0, 0.0, 0.0]);
    let loose = |bound: &str| format!("#80=ADVANCED_FACE('',({bound}),#81,.T.);#81=PLANE('',#20);");
    let edge = "#82=FACE_BOUND('',#83,.T.);#83=EDGE_LOOP('',(#84));#84=ORIENTED_EDGE('',*,*,#85,.T.);\
                #85=EDGE_CURVE('',#40,#42,#1000,.T.);";
    let cases: Vec<(&str, String)> = vec![
        (
            "offset surfaces",
            wrap(&|n| format!("OFFSET_SURFACE('',#{n},1.E-6,.F.)"), 63) + "#80=ADVANCED_FACE('',(),#1000,.T.);",
        ),
        (
            "rectangular trims",
            wrap(&|n| format!("RECTANGULAR_TRIMMED_SURFACE('',#{n},0.,1.,0.,1.,.T.,.T.)"), 63)
                + "#80=ADVANCED_FACE('',(),#1000,.T.);",
        ),
        (
            "trimmed curves",
            wrap(
                &|n| format!("TRIMMED_CURVE('',#{n},(PARAMETER_VALUE(0.)),(PARAMETER_VALUE(1.)),.T.,.PARAMETER.)"),
                64,
            ) + &line
                + &loose("#82")
                + edge,
        ),
        (
            "surface curves",
            wrap(&|n| format!("SURFACE_CURVE('',#{n},(),.CURVE_3D.)"), 64) + &line + &loose("#82") + edge,
        ),
        (
            "composite curves",
            (0..LENGTH)
                .map(|k| {
                    let next = if k + 1 == LENGTH { 64 } else { 1000 + 2 * (k + 1) };
                    format!(
                        "#{}=COMPOSITE_CURVE('',(#{}),.F.);#{}=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#{next});\n",
                        1000 + 2 * k,
                        1001 + 2 * k,
                        1001 + 2 * k
                    )
                })
                .collect::<String>()
                + &line
                + &loose("#82")
                + edge,
        ),
        (
            "oriented edges",
            wrap(&|n| format!("ORIENTED_EDGE('',*,*,#{n},.T.)"), 85)
                + &line
                + &loose("#82")
                + &edge.replace("(#84)", "(#1000)").replace("#1000,.T.);", "#64,.T.);"),
        ),
        ("oriented faces", wrap(&|n| format!("ORIENTED_FACE('',*,#{n},.T.)"), 62) + "#80=OPEN_SHELL('',(#1000));"),
        (
            "oriented shells",
            wrap(&|n| format!("ORIENTED_CLOSED_SHELL('',*,#{n},.F.)"), 61) + "#80=MANIFOLD_SOLID_BREP('',#1000);",
        ),
        (
            "styles",
            wrap(&|n| format!("PRESENTATION_STYLE_ASSIGNMENT((#{n}))"), 86)
                + "#86=COLOUR_RGB('',1.,0.,0.);#87=STYLED_ITEM('',(#1000),#60);",
        ),
    ];
    for (name, text) in cases {
        let text = world() + BALL + "#50=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#60),#1);\n" + &text;
        let model = answered(&text);
        let balls = model.parts.iter().flat_map(|p| &p.faces).filter(|f| !f.lost && f.entity == 62).count();
        assert!(balls > 0, "{name}: {:?}", model.diagnostics);
    }
}

#[test]
fn parentheses_within_parentheses() {
    let deep = "(".repeat(100_000) + &")".repeat(100_000);
    let text = world() + BALL + &format!("#90=CARTESIAN_POINT('',{deep});\n");
    let answer = read(file(&text).as_bytes(), &StepOptions::default());
    // Refused, or read without that instance.
    if let Ok(model) = answer {
        ball_or_error(&model);
    }
}

#[test]
fn shells_and_representations_that_contain_each_other() {
    let circles = "#70=SHELL_BASED_SURFACE_MODEL('',(#71));#71=OPEN_SHELL('',(#72));#72=ORIENTED_FACE('',*,#73,.T.);\
        #73=ORIENTED_FACE('',*,#72,.F.);#74=BREP_WITH_VOIDS('',#75,(#75));#75=ORIENTED_CLOSED_SHELL('',*,#76,.T.);\
        #76=ORIENTED_CLOSED_SHELL('',*,#75,.T.);#77=REPRESENTATION_MAP(#20,#78);#78=SHAPE_REPRESENTATION('',(#79),#1);\
        #79=MAPPED_ITEM('',#77,#20);#80=GEOMETRIC_SET('',(#80));#81=COMPOUND_REPRESENTATION_ITEM('',(#81));\
        #50=SHAPE_REPRESENTATION('',(#60,#70,#74,#79,#80,#81),#1);";
    let model = answered(&(world() + BALL + circles));
    let balls = model.parts.iter().flat_map(|p| &p.faces).filter(|f| !f.lost).count();
    assert!(balls > 0, "{:?}", model.diagnostics);
    assert!(model.diagnostics.iter().any(|d| d.severity == Severity::Error));
}
