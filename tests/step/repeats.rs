//! Lists of lists that name shared items: each item once, or a limit is named.

#![allow(clippy::unwrap_used, reason = "writing to a string does not fail")]

use crate::{attacks, faces, file, is, model, model_of_file, only_part, world};
use std::fmt::Write as _;
use trimtess::control::{Alone, Control, Jobs, Threads};
use trimtess::import::step::{StepError, StepOptions, read, read_on};
use trimtess::model::{Colour, Loop, Part, StepOutcome, StepTrouble};

/// Ten references to `id`.
fn ten(id: u32) -> String {
    vec![format!("#{id}"); 10].join(",")
}

/// A triangle as #101, of the coordinates #100.
const TRIANGLE: &str = "#100=COORDINATES_LIST('',3,((0.,0.,0.),(1.,0.,0.),(0.,1.,0.)));\n\
    #101=TRIANGULATED_FACE('',#100,3,((0.,0.,1.)),$,(1,2,3),((1,2,3)));\n";

#[test]
fn a_tessellated_face_is_one_face_however_often_sets_list_it() {
    assert_eq!(only_part(&model_of_file(&attacks::tessellated_sets(20))).faces.len(), 1);
}

#[test]
fn tessellated_sets_at_too_many_places_name_the_limit() {
    // Each set has the one below twice, as it is and moved twice as far as on the level below.
    let mut text = world() + TRIANGLE;
    let mut below = "#101".to_owned();
    for level in 0..18_u32 {
        let (id, place) = (200 + 2 * level, 400 + 4 * level);
        text += &crate::placement(place, [f64::from(1 << level), 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
        let moved = format!("REPOSITIONED_TESSELLATED_ITEM(#{place})REPRESENTATION_ITEM('')TESSELLATED_ITEM()");
        writeln!(text, "#{id}=TESSELLATED_GEOMETRIC_SET('',({below}));").unwrap();
        writeln!(text, "#{}=({moved}TESSELLATED_GEOMETRIC_SET(({below})));", id + 1).unwrap();
        below = format!("#{id},#{}", id + 1);
    }
    text += "#300=TESSELLATED_SHAPE_REPRESENTATION('',(#234),#1);\n";
    let model = model(&text);
    let told = |d: &&_| is(d, |t| matches!(t, StepTrouble::TooManyVisits { what: "tessellated items", .. }));
    let inside =
        |d: &&trimtess::model::Diagnostic| d.kind.to_string().contains("tessellated items are listed more than");
    assert!(model.diagnostics.iter().any(|d| told(&d) || inside(&d)), "{:?}", model.diagnostics);
}

/// A solid as #60, of the shell #61 of the face #62.
const SOLID: &str = "#60=MANIFOLD_SOLID_BREP('',#61);#61=CLOSED_SHELL('',(#62));#62=ADVANCED_FACE('',(),#63,.T.);\
    #63=SPHERICAL_SURFACE('',#20,1.);";

#[test]
fn a_shell_that_only_lists_faces_of_solids_again_is_no_part() {
    let product = crate::products::product(100, "ball", 50);
    let shells = ["OPEN_SHELL('',(#62))", "CLOSED_SHELL('',(#62))", "CONNECTED_FACE_SET('',(#62))"];
    let users = [
        "",
        "#71=SHAPE_REPRESENTATION('',(#70),#1);",
        "#71=SHELL_BASED_SURFACE_MODEL('',(#70,#61));",
        "#71=SHAPE_REPRESENTATION('',(#72),#1);#72=SHELL_BASED_SURFACE_MODEL('',(#70,#70));",
    ];
    for (shell, user) in shells.into_iter().flat_map(|shell| users.map(|user| (shell, user))) {
        for of_product in ["#60", "#60,#70", "#70,#60"] {
            let shape = format!("#50=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#20,{of_product}),#1);");
            let model = model(&(world() + SOLID + &shape + &product + "#70=" + shell + ";" + user));
            let case = format!("{shell} {user} {of_product}");
            assert_eq!((model.parts.len(), model.instances.len(), faces(&model)), (1, 1, 1), "{case}");
            let told: Vec<_> = model.diagnostics.iter().map(|d| d.kind.clone()).collect();
            assert_eq!(told, [StepOutcome::FacesAgain { faces: 1 }.into()], "{case}");
        }
    }
}

#[test]
fn representations_that_are_placed_may_share_a_solid() {
    let text = world()
        + SOLID
        + &crate::placement(30, [5.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
        + "#40=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#20,#60),#1);#41=REPRESENTATION_MAP(#20,#40);\
           #42=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#20,#60),#1);#43=REPRESENTATION_MAP(#20,#42);\
           #44=MAPPED_ITEM('',#41,#20);#45=MAPPED_ITEM('',#43,#30);#50=SHAPE_REPRESENTATION('',(#44,#45),#1);"
        + &crate::products::product(100, "balls", 50);
    let model = model(&text);
    let mut places: Vec<f64> = model.instances.iter().map(|i| i.transform.translation.x).collect();
    places.sort_by(f64::total_cmp);
    assert_eq!(places, [0.0, 5.0]);
    crate::clean(&model);
}

#[test]
fn a_representation_without_a_product_that_places_solids_of_one_is_no_part() {
    let shape = "#50=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#20,#60),#1);";
    let placing = "#42=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#20,#60),#1);#43=REPRESENTATION_MAP(#20,#42);\
                   #45=MAPPED_ITEM('',#43,#30);#51=SHAPE_REPRESENTATION('',(#45),#1);";
    let place = crate::placement(30, [5.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
    let model = model(&(world() + SOLID + shape + &crate::products::product(100, "ball", 50) + &place + placing));
    let places: Vec<f64> = model.instances.iter().map(|i| i.transform.translation.x).collect();
    assert_eq!(places, [0.0]);
}

#[test]
fn composite_curves_of_composite_curves_name_the_limit() {
    for levels in [8, 20] {
        let model = model_of_file(&attacks::composites(levels));
        let told = |t: &StepTrouble| matches!(t, StepTrouble::TooManyVisits { what: "segments of curves", .. });
        assert!(model.diagnostics.iter().any(|d| is(d, told)), "{:?}", model.diagnostics);
    }
    let model = model_of_file(&attacks::composites(2));
    assert_eq!(only_part(&model).edges[0].curve.points.len(), 201);
}

#[test]
fn a_face_is_one_face_however_often_open_shells_list_it() {
    let mut text = world()
        + "#100=PLANE('',#20);\n#101=CIRCLE('',#20,1.);\n#102=CARTESIAN_POINT('',(1.,0.,0.));\n\
           #103=VERTEX_POINT('',#102);\n#104=EDGE_CURVE('',#103,#103,#101,.T.);\n#105=ORIENTED_EDGE('',*,*,#104,.T.);\n\
           #106=EDGE_LOOP('',(#105));\n#107=FACE_OUTER_BOUND('',#106,.T.);\n#108=ADVANCED_FACE('',(#107),#100,.T.);\n";
    let mut shells = Vec::new();
    for id in 200..210 {
        writeln!(text, "#{id}=OPEN_SHELL('',({}));", ten(108)).unwrap();
        shells.push(format!("#{id}"));
    }
    let shells = shells.join(",");
    text += &format!(
        "#110=SHELL_BASED_SURFACE_MODEL('',({shells}));\n#111=MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',(#110),#1);\n"
    );
    let model = model(&text);
    assert_eq!(only_part(&model).faces.len(), 1);
    let again = StepOutcome::FacesAgain { faces: 99 };
    assert!(model.diagnostics.iter().any(|d| d.kind == again.clone().into()), "{:?}", model.diagnostics);
}

/// A disc of this radius in the plane z = 0 as face `id`, of the 8 instances after it.
fn disc(id: u32, radius: f64) -> String {
    let [plane, circle, point, vertex, edge, used, wire, bound] = [1, 2, 3, 4, 5, 6, 7, 8].map(|k| id + k);
    format!(
        "#{id}=ADVANCED_FACE('disc {id}',(#{bound}),#{plane},.T.);#{plane}=PLANE('',#20);\n\
         #{circle}=CIRCLE('',#20,{radius:?});#{point}=CARTESIAN_POINT('',({radius:?},0.,0.));\n\
         #{vertex}=VERTEX_POINT('',#{point});#{edge}=EDGE_CURVE('',#{vertex},#{vertex},#{circle},.T.);\n\
         #{used}=ORIENTED_EDGE('',*,*,#{edge},.T.);#{wire}=EDGE_LOOP('',(#{used}));\n\
         #{bound}=FACE_OUTER_BOUND('',#{wire},.T.);\n"
    )
}

/// The faces of a part, with their colours.
type Painted = Vec<(u64, Option<Colour>)>;

/// A sheet of the face #100; the discs #200 and #300 copy it, #400 is larger. With styles, and what is told.
fn copied(styles: &str) -> (Vec<Painted>, Vec<(u64, &'static str)>) {
    let text = world()
        + &disc(100, 1.0)
        + &disc(200, 1.0)
        + &disc(300, 1.0)
        + &disc(400, 2.0)
        + "#60=OPEN_SHELL('',(#100));#61=SHELL_BASED_SURFACE_MODEL('',(#60));\n\
           #62=MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',(#61),#1);\n\
           #70=COLOUR_RGB('',1.,0.5,0.);#71=COLOUR_RGB('',0.,0.5,1.);\n"
        + styles;
    let model = model(&text);
    let of_part = |part: &Part| part.faces.iter().map(|f| (f.entity, f.colour)).collect();
    let told = model.diagnostics.iter().map(|d| (d.entity, d.kind.code()));
    (model.parts.iter().map(of_part).collect(), told.collect())
}

#[test]
fn a_face_has_the_colour_of_a_copy_that_belongs_to_no_shape() {
    let [orange, blue] = [Some([1.0, 0.5, 0.0, 1.0]), Some([0.0, 0.5, 1.0, 1.0])];
    for (styles, colour) in [
        ("#80=STYLED_ITEM('',(#70),#200);", orange),
        ("#80=STYLED_ITEM('',(#70),#300);#81=STYLED_ITEM('',(#71),#200);", blue),
        ("#80=STYLED_ITEM('',(#70),#100);#81=STYLED_ITEM('',(#71),#200);", orange),
        ("", None),
    ] {
        let (faces, told) = copied(styles);
        // The larger disc is no copy.
        assert_eq!(faces, [vec![(100, colour)], vec![(400, None)]], "{styles}");
        assert_eq!(told, [(200, "step-faces-copied")], "{styles}");
    }
}

#[test]
fn faces_that_refer_to_themselves_copy_nothing() {
    let text = world()
        + &disc(100, 1.0)
        + "#60=OPEN_SHELL('',(#100));#61=SHELL_BASED_SURFACE_MODEL('',(#60));\n\
           #62=MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',(#61),#1);\n\
           #200=ADVANCED_FACE('',(#200),#101,.T.);#201=ADVANCED_FACE('',(#999),#101,.T.);";
    let model = model(&text);
    assert!(model.diagnostics.iter().all(|d| d.kind.code() != "step-faces-copied"), "{:?}", model.diagnostics);
}

#[test]
fn a_loop_has_a_use_of_an_edge_once_however_often_it_lists_it() {
    // A disc whose loop lists its circle ten times, and a triangle whose points are listed ten times.
    let mut text = world()
        + "#101=CIRCLE('',#20,1.);\n#102=CARTESIAN_POINT('',(1.,0.,0.));\n#103=VERTEX_POINT('',#102);\n\
           #104=EDGE_CURVE('',#103,#103,#101,.T.);\n#105=ORIENTED_EDGE('',*,*,#104,.T.);\n#108=PLANE('',#20);\n";
    writeln!(text, "#106=EDGE_LOOP('',({}));\n#107=FACE_OUTER_BOUND('',#106,.T.);", ten(105)).unwrap();
    text += "#120=CARTESIAN_POINT('',(5.,0.,0.));\n#121=CARTESIAN_POINT('',(6.,0.,0.));\n\
             #122=CARTESIAN_POINT('',(5.,1.,0.));\n";
    let around = ["#120,#121,#122"; 10].join(",");
    writeln!(text, "#123=POLY_LOOP('',({around}));\n#124=FACE_OUTER_BOUND('',#123,.T.);").unwrap();
    text += "#109=ADVANCED_FACE('',(#107),#108,.T.);\n#125=ADVANCED_FACE('',(#124),#108,.T.);\n\
             #110=OPEN_SHELL('',(#109,#125));\n#111=SHELL_BASED_SURFACE_MODEL('',(#110));\n\
             #112=MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',(#111),#1);\n";
    let model = model(&text);
    let uses = |l: &Loop| if let Loop::Edges(uses) = l { uses.len() } else { 0 };
    let of_faces = only_part(&model).faces.iter().map(|face| face.loops.iter().map(uses).sum::<usize>());
    assert_eq!(of_faces.collect::<Vec<_>>(), [1, 3]);
    for again in [9, 27] {
        let again = StepOutcome::EdgesAgain { uses: again };
        assert!(model.diagnostics.iter().any(|d| d.kind == again.clone().into()), "{:?}", model.diagnostics);
    }
}

#[test]
fn closed_shells_that_many_solids_share_name_the_limit() {
    // A ball; the solids that list its shell again are more than the visits that the file may ask for.
    let mut text = world() + "#62=ADVANCED_FACE('',(),#63,.T.);\n#63=SPHERICAL_SURFACE('',#20,1.);\n";
    let faces: Vec<String> = (0..400).map(|k| format!("#{}", 1000 + k)).collect();
    for face in &faces {
        writeln!(text, "{face}=ADVANCED_FACE('',(),#63,.T.);").unwrap();
    }
    writeln!(text, "#61=CLOSED_SHELL('',({}));", faces.join(",")).unwrap();
    let solids: Vec<String> = (0..400).map(|k| format!("#{}", 2000 + k)).collect();
    for solid in &solids {
        writeln!(text, "{solid}=MANIFOLD_SOLID_BREP('',#61);").unwrap();
    }
    writeln!(text, "#90=ADVANCED_BREP_SHAPE_REPRESENTATION('',({}),#1);", solids.join(",")).unwrap();
    let whole = file(&text);
    let model = read(whole.as_bytes(), &StepOptions::default()).expect("a readable file");
    assert!(model.parts[0].faces.len() <= whole.len() + 4096);
    let told = |t: &StepTrouble| matches!(t, StepTrouble::TooManyVisits { what: "faces of shells", .. });
    assert!(model.diagnostics.iter().any(|d| is(d, told)), "{:?}", model.diagnostics);
}

#[test]
fn a_surface_that_many_faces_share_names_the_limit() {
    let model = model_of_file(&attacks::shared_surface(16, 1000));
    let faces = &only_part(&model).faces;
    let read = faces.iter().filter(|face| !face.lost).count();
    assert!((200..1000).contains(&read), "{read}");
    let told = |t: &StepTrouble| matches!(t, StepTrouble::TooManyVisits { what: "points of shared surfaces", .. });
    assert_eq!(model.diagnostics.iter().filter(|d| is(d, told)).count(), faces.len() - read);
}

#[test]
fn which_points_are_too_many_does_not_depend_on_threads() {
    const SURFACES: usize = 64;
    const FACES: usize = 150;
    let ids = |from: usize, count: usize| (from..from + count).map(|id| format!("#{id}")).collect::<Vec<_>>().join(",");
    let mut text = world();
    for k in 0..16 {
        writeln!(text, "#{}=CARTESIAN_POINT('',({}.,{}.,0.));", 1000 + k, k / 4, k % 4).unwrap();
    }
    // 16 × 16 points of 4 × 4 places, over and over.
    let row = (0..4).map(|_| ids(1000, 4)).collect::<Vec<_>>().join(",");
    let (rows, ends) = (vec![format!("({row})"); 16].join(","), format!("(4{},4)", ",1".repeat(12)));
    let knots = format!("({})", (0..14).map(|k| format!("{k}.")).collect::<Vec<_>>().join(","));
    for surface in 0..SURFACES {
        writeln!(
            text,
            "#{}=B_SPLINE_SURFACE_WITH_KNOTS('',3,3,({rows}),.UNSPECIFIED.,.F.,.F.,.F.,{ends},{ends},{knots},{knots},\
             .UNSPECIFIED.);",
            2000 + surface
        )
        .unwrap();
    }
    let all = SURFACES * FACES;
    (0..all).for_each(|k| writeln!(text, "#{}=ADVANCED_FACE('',(),#{},.T.);", 9000 + k, 2000 + k % SURFACES).unwrap());
    text += &format!(
        "#110=OPEN_SHELL('',({}));\n#111=SHELL_BASED_SURFACE_MODEL('',(#110));\n\
         #112=MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',(#111),#1);\n",
        ids(9000, all)
    );
    let text = file(&text);
    let told = |jobs: &dyn Jobs| -> Vec<String> {
        let model =
            read_on(jobs, text.as_bytes(), &StepOptions::default(), &Control::default()).expect("a readable file");
        model.diagnostics.iter().map(ToString::to_string).collect()
    };
    let alone = told(&Alone);
    assert!((100..all).contains(&alone.len()), "{}", alone.len());
    for threads in [2, 8] {
        assert!(told(&Threads::start(threads).expect("threads")) == alone, "{threads} threads");
    }
}

#[test]
fn a_curve_that_many_segments_share_names_the_limit() {
    const COUNT: usize = 1000;
    let mut text = world() + "#100=PLANE('',#20);";
    for k in 0..COUNT {
        writeln!(text, "#{}=CARTESIAN_POINT('',({k}.,{}.,0.));", 1000 + k, k % 2).unwrap();
        writeln!(text, "#{}=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#101);", 3000 + k).unwrap();
    }
    let ids = |from: usize| (from..from + COUNT).map(|id| format!("#{id}")).collect::<Vec<_>>().join(",");
    let (ends, knots) = (format!("(2{},2)", ",1".repeat(COUNT - 2)), (0..COUNT).map(|k| format!("{k}.")));
    let knots = format!("({})", knots.collect::<Vec<_>>().join(","));
    writeln!(text, "#101=B_SPLINE_CURVE_WITH_KNOTS('',1,({}),.U.,.F.,.F.,{ends},{knots},.U.);", ids(1000)).unwrap();
    writeln!(text, "#102=BOUNDARY_CURVE('',({}),.F.);#103=CURVE_BOUNDED_SURFACE('',#100,(#102),.F.);", ids(3000))
        .unwrap();
    text += "#104=GEOMETRIC_SET('',(#103));#105=GEOMETRICALLY_BOUNDED_SURFACE_SHAPE_REPRESENTATION('',(#104),#1);";
    let told = |t: &StepTrouble| matches!(t, StepTrouble::TooManyVisits { what: "points of shared curves", .. });
    let model = model(&text);
    assert!(model.diagnostics.iter().any(|d| is(d, told)), "{:?}", model.diagnostics);
}

#[test]
fn a_representation_that_many_products_share_names_the_limit() {
    let model = model_of_file(&attacks::shared_representation(400));
    let told = |t: &StepTrouble| {
        matches!(t, StepTrouble::TooManyVisits { what: "items of representations that products share", .. })
    };
    assert_eq!(model.diagnostics.iter().filter(|d| is(d, told)).count(), 1, "{:?}", model.diagnostics);
    assert!((1..400).contains(&model.parts.len()), "{}", model.parts.len());
}

#[test]
fn assemblies_of_assemblies_name_the_limit_of_a_file_of_their_size() {
    let mut text = world() + "#62=ADVANCED_FACE('',(),#63,.T.);\n#63=SPHERICAL_SURFACE('',#20,1.);\n";
    text += "#64=OPEN_SHELL('',(#62));\n#65=SHELL_BASED_SURFACE_MODEL('',(#64));\n\
        #66=MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',(#65),#1);\n";
    let mut below = 66;
    for id in (200..).step_by(5).take(20) {
        writeln!(text, "#{id}=REPRESENTATION_MAP(#20,#{below});").unwrap();
        writeln!(text, "#{}=MAPPED_ITEM('',#{id},#20);\n#{}=MAPPED_ITEM('',#{id},#20);", id + 1, id + 2).unwrap();
        writeln!(text, "#{}=SHAPE_REPRESENTATION('',(#{},#{}),#1);", id + 3, id + 1, id + 2).unwrap();
        below = id + 3;
    }
    let error = read(file(&text).as_bytes(), &StepOptions::default()).expect_err("a million occurrences");
    assert!(matches!(error, StepError::TooManyOccurrences { limit: 32_768..100_000, .. }), "{error}");
}
