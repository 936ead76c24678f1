//! Bodies without stated faces: primitives, sweeps, triangles, replicas. Their volumes have closed forms.

use crate::common::prepared;
use crate::products::paint;
use crate::{clean, is, model, placement, point, world};
use std::f64::consts::PI;
use std::sync::Arc;
use trimtess::frame::{self, Tolerance};
use trimtess::mesh::{MemorySink, MeshFacts, check_scene};
use trimtess::model::{BodyRefusal, DiagnosticKind, Model, Severity, SolidTrouble, StepOutcome, StepTrouble, Surface};
use trimtess::parallel::{Session, SessionOptions};

/// A representation of `items` in context 1.
fn holding(items: &str) -> String {
    format!("#92=SHAPE_REPRESENTATION('',({items}),#1);")
}

/// Facts of the mesh of all instances at a fine tolerance.
pub(crate) fn facts(model: Model) -> MeshFacts {
    let prepared = prepared(model);
    assert!(prepared.diagnostics.iter().all(|d| d.severity < Severity::Warning), "{:?}", prepared.diagnostics);
    let tolerance = Tolerance { chord: 1e-4, angle: 0.2, max_edge: None };
    let plan = Arc::new(frame::plan(&prepared, &tolerance));
    let mut sink = MemorySink::default();
    let options = SessionOptions::DEFAULT.with_workers(1).with_edge_lines(false);
    let mut session = Session::start(Arc::clone(&prepared), &options).expect("a thread");
    let report = session.frame(plan, &mut sink).expect("a frame");
    assert!(report.degraded.is_empty(), "{:?}", report.degraded);
    check_scene(&sink).total
}

/// Reads a body and asserts its numbers of faces and edges and its volume.
fn solid(text: &str, items: &str, faces: usize, edges: usize, volume: f64) {
    let model = model(&(text.to_owned() + &holding(items)));
    clean(&model);
    let part = &model.parts[0];
    assert_eq!((part.faces.len(), part.edges.len()), (faces, edges), "{text}");
    let facts = facts(model);
    assert!(facts.is_closed(), "{text}: {facts}");
    assert!((facts.volume - volume).abs() < 1e-3 * volume.abs(), "{text}: {} is not {volume}", facts.volume);
}

#[test]
fn primitives_are_what_the_standard_says() {
    let axis = "#26=AXIS1_PLACEMENT('',#21,#22);";
    let of = |text: &str, faces, edges, volume| solid(&(world() + axis + text), "#60", faces, edges, volume);
    of("#60=BLOCK('',#20,2.,3.,4.);", 6, 12, 24.0);
    of("#60=RIGHT_ANGULAR_WEDGE('',#20,4.,3.,2.,1.);", 6, 12, 2.5 * 3.0 * 2.0);
    of("#60=RIGHT_ANGULAR_WEDGE('',#20,4.,3.,2.,0.);", 5, 9, 12.0);
    of("#60=RECTANGULAR_PYRAMID('',#20,2.,3.,4.);", 5, 8, 8.0);
    of("#60=SPHERE('',2.,#21);", 1, 0, 4.0 / 3.0 * PI * 8.0);
    of("#60=TORUS('',#26,5.,2.);", 1, 0, 2.0 * PI * PI * 5.0 * 4.0);
    of("#60=RIGHT_CIRCULAR_CYLINDER('',#26,5.,2.);", 3, 2, 20.0 * PI);
    let slope = 0.5_f64.tan();
    let far = 1.0 + 3.0 * slope;
    of("#60=RIGHT_CIRCULAR_CONE('',#26,3.,1.,0.5);", 3, 2, PI * (1.0 + far + far * far));
    of("#60=RIGHT_CIRCULAR_CONE('',#26,3.,0.,0.5);", 2, 1, PI * (3.0 * slope).powi(2));
    of("#60=CSG_SOLID('',#61);#61=SPHERE('',1.,#21);", 1, 0, 4.0 / 3.0 * PI);
    let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
    let corners: String = corners.into_iter().zip(40..).map(|(p, id)| point(id, p)).collect();
    of(&(corners + "#60=TETRAHEDRON('',(#40,#41,#42,#43));"), 4, 6, 1.0 / 6.0);
}

#[test]
fn what_would_need_intersections_is_refused_by_name() {
    let text = world()
        + "#60=CSG_SOLID('',#61);#61=BOOLEAN_RESULT('',.DIFFERENCE.,#62,#63);#62=BLOCK('',#20,2.,3.,4.);\
           #63=BOOLEAN_RESULT('',.UNION.,#64,#65);#64=SPHERE('',1.,#21);#65=SPHERE('',2.,#21);";
    for file in [text.clone() + &holding("#60"), text] {
        let model = model(&file);
        let told: Vec<_> = model.diagnostics.iter().filter(|d| d.severity == Severity::Error).collect();
        assert!(model.parts.is_empty() && told.len() == 1 && told[0].entity == 61, "{:?}", model.diagnostics);
        let StepTrouble::BodyNotRead { keyword, operator, why: BodyRefusal::Intersects } =
            told[0].kind.step_trouble().expect("a trouble")
        else {
            panic!("{told:?}")
        };
        assert_eq!((keyword.as_str(), operator.as_str()), ("BOOLEAN_RESULT", "DIFFERENCE"));
    }
}

/// A curve-bounded area #70 in the plane of placement #20: the rectangle from (x, 0) to (x + 2, 1).
fn rectangle(x: f64) -> String {
    let corners = [[x, 0.0, 0.0], [x + 2.0, 0.0, 0.0], [x + 2.0, 1.0, 0.0], [x, 1.0, 0.0], [x, 0.0, 0.0]];
    let points: String = corners.into_iter().zip(40..).map(|(p, id)| point(id, p)).collect();
    let sides: String = (0..4)
        .map(|k| {
            format!(
                "#{}=POLYLINE('',(#{},#{}));#{}=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#{});",
                50 + k,
                40 + k,
                41 + k,
                60 + k,
                50 + k
            )
        })
        .collect();
    world()
        + &points
        + &sides
        + "#69=OUTER_BOUNDARY_CURVE('',(#60,#61,#62,#63),.F.);#68=PLANE('',#20);\
           #70=CURVE_BOUNDED_SURFACE('',#68,(#69),.F.);"
}

/// The disc of radius 1 about (3, 0) as face #70, with an optional square hole.
fn disc() -> String {
    world()
        + &placement(30, [3.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
        + &crate::vertex(40, [4.0, 0.0, 0.0])
        + "#50=CIRCLE('',#30,1.);#51=EDGE_CURVE('',#40,#40,#50,.T.);#52=ORIENTED_EDGE('',*,*,#51,.T.);\
           #53=EDGE_LOOP('',(#52));#54=FACE_OUTER_BOUND('',#53,.T.);#68=PLANE('',#20);\
           #70=FACE_SURFACE('',(#54),#68,.T.);"
}

#[test]
fn areas_and_faces_are_extruded() {
    let up = "#80=DIRECTION('',(0.,0.,2.));#81=DIRECTION('',(0.,3.,-4.));";
    let area = |solid: &str| rectangle(1.0) + up + solid;
    solid(&area("#90=EXTRUDED_AREA_SOLID('',#70,#80,3.);"), "#90", 6, 12, 6.0);
    solid(&area("#90=EXTRUDED_AREA_SOLID('',#70,#81,5.);"), "#90", 6, 12, 8.0);
    solid(&(disc() + up + "#90=EXTRUDED_FACE_SOLID('',#70,#80,3.);"), "#90", 3, 3, 3.0 * PI);
    let flat = model(&(area("#90=EXTRUDED_AREA_SOLID('',#70,#82,3.);#82=DIRECTION('',(1.,0.,0.));") + &holding("#90")));
    assert!(
        flat.diagnostics.iter().any(|d| d.entity == 90 && is(d, |t| *t == SolidTrouble::AlongProfile.into())),
        "{:?}",
        flat.diagnostics
    );
}

#[test]
fn what_a_profile_lacks_is_reported_with_its_solid() {
    let sweep = "#80=DIRECTION('',(0.,0.,2.));#90=EXTRUDED_FACE_SOLID('',#70,#80,3.);".to_owned() + &holding("#90");
    // Without its surface, a profile has edges but no plane.
    let without = model(&(disc().replace("PLANE('',#20)", "PLANE('',#99)") + &sweep));
    assert!(without.parts[0].faces.is_empty(), "{:?}", without.diagnostics);
    let told: Vec<_> = without.diagnostics.iter().filter(|d| d.severity == Severity::Error).collect();
    assert!(told.len() == 1 && told[0].entity == 90, "{told:?}");
    assert!(is(told[0], |t| *t == StepTrouble::NotInFile { entity: 99 }), "{told:?}");
    // The edge of the hole is not in the file.
    let hole = "#55=FACE_BOUND('',#56,.T.);#56=EDGE_LOOP('',(#57));#57=ORIENTED_EDGE('',*,*,#99,.T.);";
    let holed = model(&(disc().replace("(#54),#68", "(#54,#55),#68") + hole + &sweep));
    assert_eq!(holed.parts[0].faces.len(), 3, "{:?}", holed.diagnostics);
    let told: Vec<_> = holed.diagnostics.iter().filter(|d| d.severity == Severity::Error).collect();
    assert!(
        told.len() == 1
            && told[0].entity == 70
            && (told[0].face, told[0].edge) == (None, None)
            && matches!(told[0].kind, DiagnosticKind::Step(StepOutcome::LoopLeftOut(_))),
        "{told:?}"
    );
}

#[test]
fn areas_and_faces_are_revolved() {
    // About the y axis, through the origin, in both directions.
    let axes = "#80=DIRECTION('',(0.,1.,0.));#81=AXIS1_PLACEMENT('',#21,#80);\
                #82=DIRECTION('',(0.,-1.,0.));#83=AXIS1_PLACEMENT('',#21,#82);";
    let area = |x, solid: &str| rectangle(x) + axes + solid;
    // A ring: centre at radius 2, area 2.
    solid(&area(1.0, "#90=REVOLVED_AREA_SOLID('',#70,#81,6.283185307179586);"), "#90", 4, 4, 8.0 * PI);
    // 360 degrees of a unit that is printed with nine digits.
    solid(&area(1.0, "#90=REVOLVED_AREA_SOLID('',#70,#81,6.28318548);"), "#90", 4, 4, 8.0 * PI);
    solid(&area(1.0, "#90=REVOLVED_AREA_SOLID('',#70,#81,6.2831852);"), "#90", 4, 4, 8.0 * PI);
    solid(&area(1.0, "#90=REVOLVED_AREA_SOLID('',#70,#81,1.5);"), "#90", 6, 12, 6.0);
    solid(&area(1.0, "#90=REVOLVED_AREA_SOLID('',#70,#83,1.5);"), "#90", 6, 12, 6.0);
    solid(&area(1.0, "#90=REVOLVED_AREA_SOLID('',#70,#81,-1.5);"), "#90", 6, 12, 6.0);
    // With one side on the axis: a cylinder, and a slice of it whose two ends share the axis.
    solid(&area(0.0, "#90=REVOLVED_AREA_SOLID('',#70,#81,6.283185307179586);"), "#90", 3, 2, 4.0 * PI);
    solid(&area(0.0, "#90=REVOLVED_AREA_SOLID('',#70,#81,1.5);"), "#90", 5, 9, 3.0);
    solid(&(disc() + axes + "#90=REVOLVED_FACE_SOLID('',#70,#81,6.283185307179586);"), "#90", 1, 0, 6.0 * PI * PI);
    solid(&(disc() + axes + "#90=REVOLVED_FACE_SOLID('',#70,#81,2.);"), "#90", 3, 3, 6.0 * PI);
    let across = model(&(area(-1.0, "#90=REVOLVED_AREA_SOLID('',#70,#81,2.);") + &holding("#90")));
    assert!(across.diagnostics.iter().any(|d| d.entity == 90 && is(d, |t| *t == SolidTrouble::AcrossAxis.into())));
}

#[test]
fn replicas_are_placed_like_occurrences() {
    let text = world()
        + &point(40, [10.0, 0.0, 0.0])
        + "#60=BLOCK('',#20,1.,1.,1.);#61=SOLID_REPLICA('twice as large',#60,#62);\
           #62=CARTESIAN_TRANSFORMATION_OPERATOR_3D('','',$,$,$,#40,2.,$);\
           #63=SOLID_REPLICA('mirrored',#61,#64);#65=DIRECTION('',(0.,-1.,0.));\
           #64=CARTESIAN_TRANSFORMATION_OPERATOR_3D('','',$,$,#65,#21,1.,$);";
    let model = model(&(text + &holding("#60,#61,#63")));
    clean(&model);
    assert_eq!(model.instances.len(), 3);
    let facts = facts(model);
    assert!(facts.is_closed() && (facts.volume - 17.0).abs() < 1e-9, "{facts}");
}

/// A tetrahedron of two tessellated faces over one list of coordinates: a strip of three triangles and a triangle.
fn tetrahedron(faces: &str) -> String {
    world()
        + "#40=COORDINATES_LIST('',5,((9.,9.,9.),(0.,0.,0.),(1.,0.,0.),(0.,1.,0.),(0.,0.,1.)));\
           #41=COMPLEX_TRIANGULATED_FACE('',#40,4,(),$,(2,3,4,5),((3,4,1,2)),((3,2,4)));\
           #42=TRIANGULATED_FACE('',#40,4,(),$,(),((2,4,3)));"
        + faces
}

#[test]
fn triangles_share_their_edges() {
    // Strip 3,4,1,2 of the used points: (3,4,1), (1,4,2); fan 3,2,4: one triangle.
    solid(&tetrahedron("#50=TESSELLATED_SOLID('',(#41,#42),$);"), "#50", 4, 6, 1.0 / 6.0);
    let inches = world()
        + "#40=COORDINATES_LIST('',3,((0.,0.,0.),(1.,0.,0.),(0.,1.,0.)));\
           #41=TRIANGULATED_SURFACE_SET('',#40,3,(),(),((1,2,3),(1,1,3)));#50=TESSELLATED_GEOMETRIC_SET('',(#41));\
           #92=TESSELLATED_SHAPE_REPRESENTATION('',(#50),#3);";
    let model = model(&inches);
    clean(&model);
    assert_eq!(model.parts[0].faces.len(), 1);
    assert!((facts(model).area - 0.5 * 25.4 * 25.4).abs() < 1e-9);
}

#[test]
fn triangles_have_the_colours_of_their_faces() {
    let text = tetrahedron("#50=TESSELLATED_SOLID('',(#41,#42),$);")
        + &holding("#50")
        + &paint(300, [1.0, 0.0, 0.5])
        + "#330=STYLED_ITEM('',(#300),#42);";
    let faces: Vec<_> = model(&text).parts[0].faces.iter().map(|face| (face.entity, face.colour)).collect();
    let red = Some([1.0, 0.0, 0.5, 1.0]);
    assert_eq!(faces, [(41, None), (41, None), (41, None), (42, red)]);
}

#[test]
fn a_repositioned_set_of_triangles_is_moved() {
    let moved = "REPOSITIONED_TESSELLATED_ITEM(#30)REPRESENTATION_ITEM('')TESSELLATED_ITEM()";
    let text = world()
        + &placement(30, [0.0, 0.0, 5.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
        + "#40=COORDINATES_LIST('',3,((0.,0.,0.),(1.,0.,0.),(0.,1.,0.)));"
        + &format!(
            "#50=(GEOMETRIC_REPRESENTATION_ITEM(){moved}TESSELLATED_SURFACE_SET(#40,3,())\
             TRIANGULATED_SURFACE_SET((),((1,2,3))));"
        );
    let model = model(&(text + &holding("#50")));
    clean(&model);
    let Surface::Plane { frame } = model.parts[0].faces[0].surface else { panic!("no plane") };
    assert_eq!(frame.origin.z, 5.0);
}

#[test]
fn tessellations_of_exact_geometry_are_not_drawn_twice() {
    let block = "#60=BLOCK('',#20,1.,1.,1.);";
    let solid = "#50=TESSELLATED_SOLID('',(#41,#42),$);";
    // In one representation; linked from another one; as an annotation; separate, without an owner.
    let apart = "#93=TESSELLATED_SHAPE_REPRESENTATION('',(#50),#1);";
    let linked = "#50=TESSELLATED_SOLID('',(#41,#42),#60);".to_owned() + apart;
    let drawn = "#51=TESSELLATED_ANNOTATION_OCCURRENCE('',(),#50);".to_owned() + solid + apart;
    for (text, items) in [(solid, "#60,#50"), (linked.as_str(), "#60"), (drawn.as_str(), "#60"), (solid, "#60")] {
        let model = model(&(tetrahedron(block) + text + &holding(items)));
        let faces: usize = model.parts.iter().map(|part| part.faces.len()).sum();
        assert_eq!(faces, 6, "{text} {:?}", model.diagnostics);
    }
    // Alone it is drawn, whatever contains it.
    let alone = model(&tetrahedron(solid));
    assert_eq!(alone.parts[0].faces.len(), 4, "{:?}", alone.diagnostics);
}

#[test]
fn broken_bodies_cost_only_themselves() {
    for bad in [
        "#60=BLOCK('',#20,2.,-3.,4.);",
        "#60=SPHERE('',2.,#99);",
        "#60=TORUS('',#20,1.,2.);",
        "#60=RIGHT_CIRCULAR_CONE('',#20,3.,1.,1.6);",
        "#60=RIGHT_ANGULAR_WEDGE('',#20,4.,3.,2.,5.);",
        "#60=EXTRUDED_AREA_SOLID('',#20,#22,3.);",
        "#60=REVOLVED_FACE_SOLID('',#60,#20,3.);",
        "#60=SWEPT_DISK_SOLID('',#20,1.,$,0.,1.);",
        "#60=CSG_SOLID('',#60);",
        "#60=SOLID_REPLICA('',#60,#20);",
    ] {
        let model = model(&(world() + bad + "#64=BLOCK('',#20,1.,1.,1.);" + &holding("#60,#64")));
        assert_eq!(model.parts[0].faces.len(), 6, "{bad}");
        let told = model.diagnostics.iter().filter(|d| d.severity >= Severity::Warning && d.entity == 60).count();
        assert_eq!(told, 1, "{bad}: {:?}", model.diagnostics);
    }
    // A shell that is not there costs neither its siblings nor their unit.
    for model_of in [
        "#64=SHELL_BASED_SURFACE_MODEL('',(#999,#65));#65=OPEN_SHELL('',(#66));",
        "#64=BREP_WITH_VOIDS('',#65,(#999));#65=CLOSED_SHELL('',(#66));",
        "#64=BREP_WITH_VOIDS('',#999,(#67));#67=ORIENTED_CLOSED_SHELL('',*,#65,.F.);#65=CLOSED_SHELL('',(#66));",
    ] {
        let ball = "#66=ADVANCED_FACE('',(),#68,.T.);#68=SPHERICAL_SURFACE('',#20,1.);";
        let model = model(&(world() + model_of + ball + "#92=SHAPE_REPRESENTATION('',(#64),#3);"));
        let Surface::Sphere { radius, .. } = model.parts[0].faces[0].surface else { panic!("no sphere") };
        assert!((model.parts.len(), radius) == (1, 25.4), "{model_of}: {radius}");
        let told: Vec<_> = model.diagnostics.iter().filter(|d| d.severity == Severity::Error).collect();
        assert!(told.len() == 1 && told[0].kind.to_string().contains("#999"), "{model_of}: {told:?}");
    }
    for bad in [
        "#60=TESSELLATED_SOLID('',(),$);",
        "#60=TRIANGULATED_FACE('',#61,1,(),$,(),((1,2,3)));#61=COORDINATES_LIST('',1,((0.,0.,0.)));",
        "#60=TRIANGULATED_FACE('',#61,1,(),$,(),((1,1)));#61=COORDINATES_LIST('',1,((0.,0.,0.)));",
        "#60=TRIANGULATED_FACE('',#60,1,(),$,(),((1,1,1)));",
    ] {
        let model = model(&(world() + bad + &holding("#60")));
        let told = model.diagnostics.iter().filter(|d| d.severity == Severity::Error && d.entity == 60).count();
        assert_eq!(told, 1, "{bad}: {:?}", model.diagnostics);
    }
}

#[test]
fn a_broken_triangle_or_face_of_a_tessellation_costs_only_itself() {
    let sound = "#50=TESSELLATED_SHELL('',(#41,#42),$);";
    let cubic = "#43=CUBIC_BEZIER_TRIANGULATED_FACE('',#40,4,(),$,(2,3,4,5),((1,2,3)));";
    let wires = "#43=TESSELLATED_EDGE('',#40,$,(1,2));";
    for (text, triangles, lost) in [
        (sound.to_owned(), 4, None),
        (sound.replace("#42)", "#42,#43)") + wires, 4, None),
        (sound.replace("#42)", "#42,#43)") + cubic, 4, Some("#43: tessellated faces of type CUBIC")),
        (
            sound.replace("#42)", "#42,#43)") + "#43=FOO_FACE('',#40,4);",
            4,
            Some("#43: tessellated faces of type FOO_FACE"),
        ),
        (sound.replace("#42)", "#42,#77)"), 4, Some("#77 is referred to but not in the file")),
        (
            sound.replace("#42)", "#43)") + "#43=TRIANGULATED_FACE('',#40,4,(),$,(),((2,4,3),(2,4,9)));",
            4,
            Some("#43: 1 triangles"),
        ),
        (sound.replace("#42)", "#43)") + "#43=TESSELLATED_SHELL('',(#42),$);", 4, None),
    ] {
        let model = model(&(tetrahedron(&text) + &holding("#50")));
        assert_eq!(model.parts[0].faces.len(), triangles, "{text}: {:?}", model.diagnostics);
        let told: Vec<_> = model.diagnostics.iter().filter(|d| d.severity == Severity::Error).collect();
        assert_eq!(told.len(), usize::from(lost.is_some()), "{text}: {told:?}");
        assert!(
            lost.is_none_or(|lost| told[0].entity == 50 && told[0].kind.to_string().contains(lost)),
            "{text}: {told:?}"
        );
    }
}

#[test]
fn triangles_without_height_leave_no_slit() {
    // Two large triangles on the left of a line with two points on it, three small ones on its right. In between, the
    // writer filled the line with triangles without height.
    let between = |flat: &str| {
        let text = world()
            + "#40=COORDINATES_LIST('',6,((0.,0.,0.),(1.,0.,0.),(2.,0.,0.),(3.,0.,0.),(0.,1.,0.),(0.,-1.,0.)));"
            + &format!("#41=TRIANGULATED_FACE('',#40,6,(),$,(),((1,4,5),(1,6,2),(2,6,3),(3,6,4),{flat}));")
            + "#50=TESSELLATED_SHELL('',(#41),$);";
        model(&(text + &holding("#50")))
    };
    for flat in ["(1,2,4),(2,3,4)", "(1,2,3),(1,3,4)", "(2,3,4),(1,2,4)"] {
        let model = between(flat);
        clean(&model);
        assert_eq!((model.parts[0].faces.len(), model.parts[0].edges.len()), (4, 9), "{flat}");
        let facts = facts(model);
        assert!(facts.open_edges == 4 && (facts.area - 3.0).abs() < 1e-9, "{flat}: {facts}");
    }
    // A fan over a line of 150 corners on its left, one triangle on its right. The line is filled from its ends inwards
    // or from one end: sides are split 75 and 150 deep.
    let (count, top) = (150, 151);
    let row: String = (0..count).map(|x| format!("({x}.,0.,0.),")).collect();
    let fan = (1..count).map(|k| format!("({k},{},{top})", k + 1)).collect::<Vec<_>>().join(",");
    let from_one = (2..count).map(|k| format!("(1,{k},{})", k + 1)).collect::<Vec<_>>().join(",");
    let inwards = (1..count / 2).map(|k| (k, count + 1 - k));
    let inwards = inwards.map(|(a, b)| format!("({a},{b},{}),({},{b},{})", a + 1, a + 1, b - 1));
    for flat in [from_one, inwards.collect::<Vec<_>>().join(",")] {
        let text = world()
            + &format!("#40=COORDINATES_LIST('',{},({row}(0.,1.,0.),(0.,-1.,0.)));", count + 2)
            + &format!("#41=TRIANGULATED_FACE('',#40,{},(),$,(),(({count},1,{}),{fan},{flat}));", count + 2, top + 1)
            + "#50=TESSELLATED_SHELL('',(#41),$);";
        let model = model(&(text + &holding("#50")));
        clean(&model);
        let facts = facts(model);
        assert!(facts.open_edges == 4 && (facts.area - f64::from(count - 1)).abs() < 1e-9, "{facts}");
    }
    let text = "#40=COORDINATES_LIST('',3,((0.,0.,0.),(1.,0.,0.),(2.,0.,0.)));\
                #50=TRIANGULATED_FACE('',#40,3,(),$,(),((1,2,3)));";
    let flat = model(&(world() + text + &holding("#50")));
    assert!(
        flat.parts[0].faces.is_empty()
            && is(&flat.diagnostics[0], |t| matches!(
                t,
                StepTrouble::Missing { part: "triangles that have an area", .. }
            )),
        "{:?}",
        flat.diagnostics
    );
}

#[test]
fn items_that_may_be_shapes_are_read_or_reported() {
    let ball = "#60=SPHERE('',1.,#21);";
    for bad in [
        "#61=FOO_SOLID('',#20,1.);",
        "#61=EXTRUDED_FACE_SOLID_WITH_DRAFT_ANGLE('',#70,#22,3.,0.1);",
        "#61=RULED_SURFACE_SWEPT_AREA_SOLID('',#20,1.);",
        "#61=(REPRESENTATION_ITEM('')GEOMETRIC_REPRESENTATION_ITEM()FOO(1.));",
        "#61=GEOMETRIC_SET('',(#62));#62=FOO('',1.);",
        "#61=GEOMETRIC_SET('',(#62));",
        "",
    ] {
        for items in ["#60,#61", "#61"] {
            let model = model(&(world() + ball + bad + &holding(items)));
            let told: Vec<_> = model.diagnostics.iter().filter(|d| d.severity >= Severity::Warning).collect();
            let entity = if bad.contains("SET") { 62 } else { 61 };
            assert!(told.len() == 1 && told[0].severity == Severity::Error, "{bad} {items}: {told:?}");
            assert_eq!(told[0].entity, entity, "{bad}: {told:?}");
            assert_eq!(model.parts[0].faces.len(), 1, "{bad} {items}: {:?}", model.parts[0].faces);
        }
    }
    for none in [
        "#61=AXIS2_PLACEMENT_3D('',#21,#22,#23);",
        "#61=PLANE('',#20);",
        "#61=POLYLINE('',(#21,#21));",
        "#61=COMPOSITE_CURVE_ON_SURFACE('',(),.F.);",
        "#61=GEOMETRIC_CURVE_SET('',(#21));",
        "#61=GEOMETRIC_SET('',(#21,#20));",
        "#61=SHELL_BASED_WIREFRAME_MODEL('',());",
        "#61=(LENGTH_MEASURE_WITH_UNIT()MEASURE_REPRESENTATION_ITEM()MEASURE_WITH_UNIT(LENGTH_MEASURE(1.),#5)\
         REPRESENTATION_ITEM(''));",
        "#61=(ANNOTATION_CURVE_OCCURRENCE()ANNOTATION_OCCURRENCE()GEOMETRIC_REPRESENTATION_ITEM()\
         REPRESENTATION_ITEM('')STYLED_ITEM((),#21));",
        "#61=CAMERA_MODEL_D3('',#20,$);",
    ] {
        let model = model(&(world() + ball + none + &holding("#60,#61")));
        clean(&model);
        assert_eq!(model.parts[0].faces.len(), 1, "{none}");
    }
    // Bounded surfaces are faces.
    for (surface, area) in [("#61=SPHERICAL_SURFACE('',#20,1.);", 4.0 * PI), ("", 2.0)] {
        let item = if surface.is_empty() { "#70" } else { "#61" };
        let model = model(
            &(rectangle(1.0).replace("#60,#61,#62,#63", "#60,#64,#62,#63").replace("#61=", "#64=")
                + surface
                + &holding(item)),
        );
        clean(&model);
        assert!((facts(model).area - area).abs() < 1e-3 * area, "{item}");
    }
}
