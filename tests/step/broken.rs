//! Broken and hostile files: a message or a diagnostic, never a panic, and nothing else lost.

use crate::{BALLS, faces, file, model, only_part, point, world};
use std::fs;
use std::path::Path;
use trimtess::import::step::{BYTES_PER_BYTE, StepError, StepOptions, read, read_file};
use trimtess::model::{Model, Severity, Surface};

fn try_read(text: &str) -> Result<Model, StepError> {
    read(text.as_bytes(), &StepOptions::default())
}

fn errors(model: &Model) -> Vec<String> {
    let lost = model.diagnostics.iter().filter(|d| d.severity == Severity::Error);
    lost.map(|d| d.kind.to_string()).collect()
}

#[test]
fn a_syntax_error_costs_one_instance() {
    let text = file(&(world() + BALLS));
    assert_eq!(faces(&try_read(&text).expect("sound")), 2);
    for (good, bad) in [
        ("#73=SPHERICAL_SURFACE('',#20,2.)", "#73=SPHERICAL_SURFACE('',#20,?2.)"),
        ("#73=SPHERICAL_SURFACE('',#20,2.)", "#73=SPHERICAL_SURFACE('',#20,2.))"),
        ("#73=SPHERICAL_SURFACE('',#20,2.)", "#63=SPHERICAL_SURFACE('',#20,2.)"),
        ("#73=SPHERICAL_SURFACE('',#20,2.);", "#73=SPHERICAL_SURFACE('',#20,2."),
    ] {
        let broken = text.replace(good, bad);
        let model = try_read(&broken).unwrap_or_else(|e| panic!("{bad}: {e}"));
        assert_eq!(faces(&model), 1, "{bad}: {:?}", model.diagnostics);
        let errors = errors(&model);
        assert!(errors.iter().any(|e| e.contains("was left out") && e.contains("line")), "{bad}: {errors:?}");
        assert!(errors.iter().any(|e| e.contains("#73")), "{bad}: {errors:?}");
    }
}

#[test]
fn a_broken_header_is_replaced() {
    let text = file(&(world() + BALLS));
    for (good, bad) in [("(''),'2;1')", "(''',;1')"), ("FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));", ""), ("FILE_NAME", "!")] {
        let model = try_read(&text.replace(good, bad)).unwrap_or_else(|e| panic!("{bad}: {e}"));
        assert_eq!(faces(&model), 2, "{bad}");
        assert!(errors(&model).iter().any(|e| e.contains("header")), "{bad}: {:?}", model.diagnostics);
    }
}

#[test]
fn a_stray_quote_does_not_swallow_the_file() {
    // Empty names look like quotes within the string, so that it only ends at the next non-empty name.
    let names: String = (200..260).map(|id| format!("#{id}=CARTESIAN_POINT('',(0.,0.,0.));\n")).collect();
    let text = file(&(world() + &names + BALLS)).replace("#71=CLOSED_SHELL('',", "#71=CLOSED_SHELL('named',");
    let model = try_read(&text.replace("#205=CARTESIAN_POINT('',", "#205=CARTESIAN_POINT(''',")).expect("mended");
    assert_eq!(faces(&model), 2);
    assert!(errors(&model).len() == 1 && errors(&model)[0].contains("#205 was left out"), "{:?}", errors(&model));
}

#[test]
fn an_end_within_the_data_costs_no_instance_behind_it() {
    let text = file(&(world() + BALLS));
    for end in ["ENDSEC;", "END-ISO-10303-21;", "ENDSEC; /* and */"] {
        let model = try_read(&text.replace("#70=", &format!("{end}\n#70="))).unwrap_or_else(|e| panic!("{end}: {e}"));
        assert_eq!((faces(&model), errors(&model).len()), (2, 1), "{end}: {:?}", model.diagnostics);
    }
    // Another file behind the end is not read with the first.
    let ended = text.replace("ENDSEC;\nEND-ISO", "END-ISO");
    assert_ne!(ended, text);
    let model = try_read(&(ended + &text)).expect("the first file");
    assert_eq!((faces(&model), errors(&model).len()), (2, 1), "{:?}", model.diagnostics);
}

#[test]
fn too_many_syntax_errors_give_the_file_up() {
    let text = file(&(world() + BALLS + &"#9=?;\n".repeat(3)));
    let options = StepOptions::DEFAULT.with_max_syntax_repairs(2);
    let error = read(text.as_bytes(), &options).expect_err("three errors");
    assert!(matches!(error, StepError::Syntax { repairs: 2, .. }), "{error}");
    assert!(error.to_string().contains("line"), "{error}");
}

#[test]
fn a_truncated_file_yields_its_complete_instances() {
    let text = file(&(world() + BALLS));
    let cut = text.find("#73=").expect("there");
    for extra in [0, 8, 25] {
        let model = try_read(&text[..cut + extra]).expect("a truncated file is still read");
        assert_eq!(faces(&model), 1, "cut {extra} bytes into #73");
    }
}

#[test]
fn other_files_are_named() {
    for (bytes, word) in [
        (&b""[..], "empty"),
        (b"PK\x03\x04....", "ZIP"),
        (b"\x1f\x8b...", "gzip"),
        (b"\xff\xfeI\0S\0O\0", "UTF-16"),
        (b"solid cube\nfacet", "STL"),
        (b"\nCASCADE Topology V1, (c) Matra-Datavision\n", "BREP"),
        (b"DBRep_DrawableShape\n\nCASCADE Topology V1, (c) Matra-Datavision\n", "BREP"),
        (b"hello", "no Part 21"),
    ] {
        let error = read(bytes, &StepOptions::default()).expect_err("not STEP");
        assert!(error.to_string().contains(word), "{error}");
    }
    let iges = format!("{:72}S      1\n", "");
    assert!(try_read(&iges).expect_err("IGES").to_string().contains("IGES"));
    let error = read_file("does/not/exist.stp".as_ref(), &StepOptions::default()).expect_err("absent");
    assert!(error.to_string().contains("does/not/exist.stp"), "{error}");
    for asked in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = read(b"ISO-10303-21;", &StepOptions::DEFAULT.with_fit_tolerance(asked)).unwrap_err();
        assert_eq!(error.to_string(), StepError::FitTolerance { asked }.to_string());
    }
    let options = StepOptions::DEFAULT.with_max_bytes(10);
    assert!(matches!(read(b"ISO-10303-21;", &options), Err(StepError::TooLarge { bytes: 13, limit: 10 })));
}

#[test]
fn files_are_read_beyond_the_bytes_that_say_what_they_are() {
    let text = file(&(world() + BALLS));
    let text = text.trim_end();
    for length in [4095, 4096, 4097] {
        let comment = format!("/*{:1$}*/#70=", "", length - text.len() - 4);
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{length}_bytes.stp"));
        fs::write(&path, text.replace("#70=", &comment)).expect("a file");
        assert_eq!(fs::metadata(&path).expect("a file").len(), length as u64);
        let model = read_file(&path, &StepOptions::DEFAULT).unwrap_or_else(|e| panic!("{length}: {e}"));
        assert_eq!((faces(&model), &model.diagnostics[..]), (2, &[][..]), "{length}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn endless_files_are_not_read_to_the_end() {
    // The first bytes decide.
    let error = read_file("/dev/zero".as_ref(), &StepOptions::DEFAULT).expect_err("zeros");
    assert!(matches!(error, StepError::NotStep { .. }), "{error}");
}

#[test]
fn limits_are_named_with_what_would_be_needed() {
    let text = file(&(world() + BALLS));
    let read = |options: StepOptions| read(text.as_bytes(), &options);
    let entities = text.matches("=").count() as u64;
    assert!(read(StepOptions::DEFAULT.with_max_entities(entities)).is_ok());
    let error = read(StepOptions::DEFAULT.with_max_entities(entities - 1)).expect_err("one too many");
    assert!(
        matches!(error, StepError::TooManyEntities { entities: n, limit } if n == entities && limit == n - 1),
        "{error}"
    );
    let needed = BYTES_PER_BYTE * text.len() as u64;
    let error = read(StepOptions::DEFAULT.with_max_memory(needed - 1)).expect_err("one byte too many");
    assert!(matches!(error, StepError::TooMuchMemory { needed: n, .. } if n == needed), "{error}");
    assert!(error.to_string().contains("max_memory") && error.to_string().contains(&needed.to_string()), "{error}");
    // Lists, faces and edges count, too.
    assert!(read(StepOptions::DEFAULT.with_max_memory(10 * needed)).is_ok());
}

#[test]
fn memory_is_counted_before_it_is_allocated() {
    let refused = |items: &str, limit: u64| match read(file(&(world() + items)).as_bytes(), &with_memory(limit)) {
        Err(StepError::TooMuchMemory { needed, .. }) => Some(needed),
        _ => None,
    };
    // A list of digits takes 55 bytes per byte, a list of blanks 107.
    let digits = format!("#100=A(({}1));\n", "1,".repeat(100_000));
    assert!(refused(&digits, 4_000_000).is_some_and(|needed| needed > 9_000_000));
    let blanks = format!("#100=A(({}));\n", ",".repeat(100_000));
    assert!(refused(&blanks, 8_000_000).is_some_and(|needed| needed > 10_000_000));
    // A triangle becomes a face, of ten bytes of text.
    let triangles = vec!["(1,2,3)"; 20_000].join(",");
    let body = format!(
        "#100=COORDINATES_LIST('',3,((0.,0.,0.),(1.,0.,0.),(0.,1.,0.)));\n\
         #101=TRIANGULATED_FACE('',#100,3,((0.,0.,1.)),$,(),({triangles}));\n\
         #102=TESSELLATED_SHAPE_REPRESENTATION('',(#101),#3);\n"
    );
    assert!(refused(&body, 20_000_000).is_some_and(|needed| needed > 30_000_000));
    assert_eq!(refused(&body, 100_000_000), None);
}

fn with_memory(limit: u64) -> StepOptions {
    StepOptions::DEFAULT.with_max_memory(limit)
}

#[test]
fn styles_that_fan_out_are_followed_once() {
    // Ten levels of sixteen references each: 16^10 paths to the colour.
    let mut text = "#103=STYLED_ITEM('',(#200),#60);#210=COLOUR_RGB('',1.,0.5,0.);".to_owned();
    for level in 200..210 {
        let next = vec![format!("#{}", level + 1); 16].join(",");
        text += &format!("#{level}=PRESENTATION_STYLE_ASSIGNMENT(({next}));");
    }
    for (item, colour) in [("#210=COLOUR_RGB('',1.,0.5,0.)", Some([1.0, 0.5, 0.0, 1.0])), ("#210=POINT_STYLE()", None)]
    {
        let text = text.replace("#210=COLOUR_RGB('',1.,0.5,0.)", item);
        let model = model(&(world() + BALLS + &text));
        assert_eq!(only_part(&model).faces[0].colour, colour);
    }
}

#[test]
fn a_file_without_faces_is_an_empty_model_with_a_warning() {
    let model = model(&world());
    assert!(model.parts.is_empty() && model.instances.is_empty());
    assert!(model.diagnostics.iter().any(|d| d.kind.code() == "step-no-faces"), "{:?}", model.diagnostics);
}

#[test]
fn references_in_circles_end() {
    let circles = "#80=TRIMMED_CURVE('',#80,(PARAMETER_VALUE(0.)),(PARAMETER_VALUE(1.)),.T.,.PARAMETER.);\
        #81=SURFACE_CURVE('',#81,(),.CURVE_3D.);#82=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#83);\
        #83=COMPOSITE_CURVE('',(#82,#82,#82),.F.);#84=OFFSET_SURFACE('',#84,1.,.F.);\
        #85=ORIENTED_CLOSED_SHELL('',*,#85,.F.);#86=MANIFOLD_SOLID_BREP('',#85);#87=ORIENTED_FACE('',*,#87,.T.);\
        #88=ORIENTED_EDGE('',*,*,#88,.T.);#89=EDGE_LOOP('',(#88));#90=FACE_BOUND('',#89,.T.);\
        #91=ADVANCED_FACE('',(#90),#84,.T.);#92=ADVANCED_FACE('',(),#84,.T.);\
        #93=SURFACE_OF_LINEAR_EXTRUSION('',#80,#94);#94=VECTOR('',#23,1.);#95=ADVANCED_FACE('',(),#93,.T.);\
        #96=SURFACE_OF_REVOLUTION('',#83,#20);#97=ADVANCED_FACE('',(),#96,.T.);\
        #98=SURFACE_OF_REVOLUTION('',#81,#20);#99=ADVANCED_FACE('',(),#98,.T.);\
        #100=CLOSED_SHELL('',(#91,#92,#95,#97,#99,#87));#101=MANIFOLD_SOLID_BREP('',#100);\
        #102=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#86,#101,#60),#1);\
        #103=STYLED_ITEM('',(#104),#60);#104=PRESENTATION_STYLE_ASSIGNMENT((#104));";
    let model = model(&(world() + BALLS + circles));
    assert_eq!(faces(&model), 2, "the two balls: {:?}", model.diagnostics);
    assert!(errors(&model).len() >= 7, "{:?}", errors(&model));
}

#[test]
fn nonsense_numbers_cost_their_face() {
    for bad in [
        "#73=SPHERICAL_SURFACE('',#20,0.)",
        "#73=SPHERICAL_SURFACE('',#20,-1.)",
        "#73=SPHERICAL_SURFACE('',#20,$)",
        "#73=SPHERICAL_SURFACE('',#9999,1.)",
        "#73=SPHERICAL_SURFACE('',#73,1.)",
        "#73=SPHERICAL_SURFACE()",
        "#73=CONICAL_SURFACE('',#20,1.,1.5707963267948966)",
        "#73=NO_SUCH_SURFACE('',#20,1.)",
        "#73=B_SPLINE_SURFACE_WITH_KNOTS('',1,1,((#21,#21),(#21,#21)),.U.,.F.,.F.,.F.,(9000000000000000000,2),(2,2),\
         (0.,1.),(0.,1.),.U.)",
        "#73=B_SPLINE_SURFACE_WITH_KNOTS('',1,1,((#21,#21),(#21,#21)),.U.,.F.,.F.,.F.,(2,2),(2,2),(1.,0.),(0.,1.),.U.)",
        "#73=B_SPLINE_SURFACE_WITH_KNOTS('',1,1,((#21,#21),(#21,#21)),.U.,.F.,.F.,.F.,(2,2),(2,2),(1.,1.),(0.,1.),.U.)",
        "#73=B_SPLINE_SURFACE_WITH_KNOTS('',900000,1,((#21,#21),(#21,#21)),.U.,.F.,.F.,.F.,(2,2),(2,2),\
         (0.,1.),(0.,1.),.U.)",
        "#73=B_SPLINE_SURFACE_WITH_KNOTS('',1,1,((#21,#21),(#21)),.U.,.F.,.F.,.F.,(2,2),(2,2),(0.,1.),(0.,1.),.U.)",
        "#73=BEZIER_SURFACE('',0,0,((#21)),.U.,.F.,.F.,.F.)",
        "#73=BEZIER_SURFACE('',1,1,(),.U.,.F.,.F.,.F.)",
    ] {
        let model = model(&(world() + &BALLS.replace("#73=SPHERICAL_SURFACE('',#20,2.)", bad)));
        assert_eq!((faces(&model), only_part(&model).faces.len()), (1, 2), "{bad}: {:?}", model.diagnostics);
        let lost = model.diagnostics.iter().filter(|d| d.severity == Severity::Error && d.entity == 72).count();
        assert_eq!(lost, 1, "{bad}: {:?}", model.diagnostics);
    }
}

#[test]
fn faults_of_splines_are_told_with_their_numbers() {
    let points: String = [0.0, 1.0].iter().zip(81..).map(|(&x, id)| point(id, [x, 0.0, 0.0])).collect();
    let form = ".U.,.F.,.F.,.F.";
    let net = |rows: &str| format!("({rows}),{form}");
    let two = net("(#81,#82),(#81,#82)");
    let knots = |degree: u32, net: &str, u: &str| {
        let (counts, values) = u.split_once(' ').expect("counts and values");
        format!("B_SPLINE_SURFACE_WITH_KNOTS('',{degree},1,{net},({counts}),(2,2),({values}),(0.,1.),.U.)")
    };
    let rational = format!(
        "(BOUNDED_SURFACE()B_SPLINE_SURFACE(1,1,{two})B_SPLINE_SURFACE_WITH_KNOTS((2,2),(2,2),(0.,1.),(0.,1.),.U.)\
         GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_SURFACE(((1.,1.),(1.,-1.)))REPRESENTATION_ITEM('')SURFACE())"
    );
    let apart = net("(#81,#82),(#81,#82),(#82,#81),(#82,#81)");
    for (bad, code, words) in [
        (knots(1, &two, "2,2 1.,0."), "step-spline", "knot 1 is 0, less than 1 before it"),
        (knots(1, &two, "2,2 1.,1."), "step-spline", "the domain is the single parameter 1"),
        (knots(1, &two, "2,3 0.,1."), "step-spline", "5 knots do not fit 2 control points of degree 1"),
        (knots(61, &two, "2,2 0.,1."), "step-spline", "degree 61 is not in 1..=60"),
        (knots(1, &apart, "2,2,2 0.,1.,2."), "step-spline", "it jumps at knot 1"),
        (rational, "step-spline", "weight 3 is -1, not within 1e-30 to 1e30"),
        (format!("BEZIER_SURFACE('',2,1,{two})"), "step-spline", "2 control points are too few for degree 2"),
        (format!("BEZIER_SURFACE('',2,1,{apart})"), "step-spline", "4 control points are not a chain of Bézier pieces"),
        (knots(1, &net("(#81,#82),(#81)"), "2,2 0.,1."), "step-layout", ""),
        (knots(1, &two, "2,2,2 0.,1."), "step-layout", ""),
    ] {
        let sphere = "SPHERICAL_SURFACE('',#20,2.)";
        let model = model(&(world() + &points + &BALLS.replace(sphere, &bad)));
        let troubles: Vec<_> = model.diagnostics.iter().filter_map(|d| d.kind.step_trouble()).collect();
        let told = troubles.iter().any(|trouble| trouble.code() == code && trouble.to_string().contains(words));
        assert!(told, "{bad}: {troubles:?}");
    }
}

#[test]
fn a_length_unit_beyond_all_numbers_is_named_and_read_as_millimetres() {
    let metre = "#300=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT($,.METRE.));\n";
    let unit = "#301=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E306),#300);\n\
        #302=(CONVERSION_BASED_UNIT('X',#301)LENGTH_UNIT()NAMED_UNIT(#13));\n\
        #303=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#302))REPRESENTATION_CONTEXT('',''));\n";
    let circle = "#310=CIRCLE('',#20,1.);\n#312=EDGE_CURVE('',#30,#30,#310,.T.);\n\
        #313=ORIENTED_EDGE('',*,*,#312,.T.);\n\
        #314=EDGE_LOOP('',(#313));\n#315=FACE_OUTER_BOUND('',#314,.T.);\n#316=PLANE('',#20);\n";
    let face = crate::shell("ADVANCED_FACE('',(#315),#316,.T.)", 303);
    let model = crate::model(&(crate::world() + metre + unit + &crate::vertex(30, [1.0, 0.0, 0.0]) + circle + &face));
    let told = model.diagnostics.iter().find(|d| d.kind.code() == "step-unit-out-of-range").expect("a diagnostic");
    assert_eq!((told.entity, told.severity), (303, Severity::Error));
    assert!(!crate::only_face(&model).lost);
}

#[test]
fn a_unit_that_cannot_be_read_is_named() {
    for (unit, angle) in [
        ("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILI.,.METRE.))", "#6"),
        ("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METER.))", "#6"),
        ("(CONVERSION_BASED_UNIT('INCH',#399)LENGTH_UNIT()NAMED_UNIT(#13))", "#6"),
        ("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))", "#302"),
    ] {
        let units = format!(
            "#301={unit};\n#302=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.DEGREE.));\n\
             #303=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#301,{angle},#7))\
             REPRESENTATION_CONTEXT('',''));\n"
        );
        let model = model(&(world() + &units + &BALLS.replace("#70),#1)", "#70),#303)")));
        let told: Vec<_> = model.diagnostics.iter().map(|d| (d.kind.code(), d.severity, d.entity)).collect();
        let wrong = if angle == "#6" { 301 } else { 302 };
        assert_eq!(told, [("step-unit-not-read", Severity::Error, wrong)], "{unit}");
    }
}

#[test]
fn an_angle_unit_is_read_beside_a_length_unit_that_is_not() {
    let units = "#301=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILI.,.METRE.));\n\
        #302=(CONVERSION_BASED_UNIT('DEGREE',#304)NAMED_UNIT(#13)PLANE_ANGLE_UNIT());\n\
        #304=PLANE_ANGLE_MEASURE_WITH_UNIT(PLANE_ANGLE_MEASURE(0.017453292519943295),#6);\n\
        #303=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#301,#302))REPRESENTATION_CONTEXT('',''));\n";
    let circle = "#310=CIRCLE('',#20,1.);\n#312=EDGE_CURVE('',#30,#30,#310,.T.);\n\
        #313=ORIENTED_EDGE('',*,*,#312,.T.);\n\
        #314=EDGE_LOOP('',(#313));\n#315=FACE_OUTER_BOUND('',#314,.T.);\n#316=CONICAL_SURFACE('',#20,1.,45.);\n";
    let face = crate::shell("ADVANCED_FACE('',(#315),#316,.T.)", 303);
    let model = crate::model(&(crate::world() + units + &crate::vertex(30, [1.0, 0.0, 0.0]) + circle + &face));
    assert!(model.diagnostics.iter().any(|d| d.kind.code() == "step-unit-not-read" && d.entity == 301));
    let surface = &crate::only_face(&model).surface;
    let Surface::Cone { half_angle, radius, .. } = surface else { panic!("{surface:?}") };
    assert!((half_angle.to_degrees() - 45.0).abs() < 1e-9 && (radius - 1.0).abs() < 1e-12, "{surface:?}");
}

#[test]
fn coordinates_beyond_all_numbers_in_millimetres_are_named() {
    let line = "#40=LINE('',#31,#41);\n#41=VECTOR('',#22,1.);\n";
    let ends = crate::vertex(30, [0.0; 3]) + "#32=VERTEX_POINT('',#33);\n#33=CARTESIAN_POINT('',(1.E308,0.,0.));\n";
    let edge = "#42=EDGE_CURVE('',#30,#32,#40,.T.);\n#43=ORIENTED_EDGE('',*,*,#42,.T.);\n#44=EDGE_LOOP('',(#43));\n\
        #45=FACE_OUTER_BOUND('',#44,.T.);\n#46=PLANE('',#20);\n";
    let face = crate::shell("ADVANCED_FACE('',(#45),#46,.T.)", 3);
    let model = crate::model(&(crate::world() + &ends + line + edge + &face));
    let told = |t: &trimtess::model::StepTrouble| matches!(t, trimtess::model::StepTrouble::NotFinite { .. });
    assert!(model.diagnostics.iter().any(|d| crate::is(d, told)), "{:?}", model.diagnostics);
}
