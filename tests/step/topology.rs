//! Loops, senses, shells: topology as files state it, with all its flags.

use crate::common::prepared;
use crate::{assert_near, bounded_face, clean, edge_of, is, model, only_face, only_part, point, shell, vertex, world};
use glam::DVec3;
use trimtess::model::{Coedge, FaceId, Loop, Model, Part, PartId, Severity, ShellKind, StepTrouble};

/// A unit square in z = 0.
pub(crate) fn square() -> String {
    crate::square(1.0, 0.0)
}

fn coedges(bound: &Loop) -> &[Coedge] {
    let Loop::Edges(coedges) = bound else { panic!("no edges: {bound:?}") };
    coedges
}

/// The points at which the coedges of a loop start.
fn corners(part: &Part, bound: &Loop) -> Vec<DVec3> {
    let start = |c: &Coedge| {
        let edge = &part.edges[c.edge.index()];
        part.vertices[if c.reversed { edge.end } else { edge.start }.index()]
    };
    let points: Vec<DVec3> = coedges(bound).iter().map(start).collect();
    for (i, coedge) in coedges(bound).iter().enumerate() {
        let edge = &part.edges[coedge.edge.index()];
        let end = part.vertices[if coedge.reversed { edge.start } else { edge.end }.index()];
        assert_near(end, points[(i + 1) % points.len()]);
    }
    points
}

/// Twice the area of a loop, seen from above.
fn area(part: &Part, bound: &Loop) -> f64 {
    let points = corners(part, bound);
    (0..points.len()).map(|i| points[i].cross(points[(i + 1) % points.len()]).z).sum()
}

#[test]
fn loops_keep_to_the_left_of_the_surface_normal_whatever_the_flags() {
    for (bound, same_sense) in [('T', true), ('F', false), ('T', false), ('F', true)] {
        let sense = if same_sense { 'T' } else { 'F' };
        let square = square().replace("#75,.T.)", &format!("#75,.{bound}.)"));
        let model = model(&(square + &shell(&format!("ADVANCED_FACE('top',(#76),#60,.{sense}.)"), 1)));
        clean(&model);
        let face = only_face(&model);
        assert_eq!((face.reversed, face.name.as_str(), face.entity), (!same_sense, "top", 91));
        // The loop is counter-clockwise; each false flag reverses it once.
        let turned = (bound == 'T') != same_sense;
        assert_eq!(area(only_part(&model), &face.loops[0]), if turned { -2.0 } else { 2.0 });
    }
}

#[test]
fn an_edge_between_two_faces_is_one_edge() {
    let rest = "#77=ORIENTED_EDGE('',*,*,#70,.F.);\
                #78=ORIENTED_EDGE('',*,*,#73,.F.);#79=ORIENTED_EDGE('',*,*,#72,.F.);#80=ORIENTED_EDGE('',*,*,#71,.F.);\
                #81=EDGE_LOOP('',(#77,#78,#79,#80));#82=FACE_OUTER_BOUND('',#81,.T.);\
                #91=ADVANCED_FACE('',(#76),#60,.T.);#94=FACE_SURFACE('',(#82),#60,.F.);\
                #90=CLOSED_SHELL('',(#91,#94));#93=MANIFOLD_SOLID_BREP('',#90);\
                #92=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#93),#1);";
    let model = model(&(square() + rest));
    clean(&model);
    let part = only_part(&model);
    assert_eq!((part.faces.len(), part.edges.len(), part.vertices.len()), (2, 4, 4));
    assert_eq!(part.shells[0].kind, ShellKind::Outer);
    assert!(part.faces[1].loops.len() == 1 && part.faces[1].reversed);
    assert_eq!(area(part, &part.faces[1].loops[0]), 2.0);
}

#[test]
fn turned_shells_turn_their_faces() {
    let faces = "#91=ADVANCED_FACE('',(#76),#60,.T.);#90=CLOSED_SHELL('',(#91));#94=ADVANCED_FACE('',(#76),#60,.T.);\
                 #95=CLOSED_SHELL('',(#94));#96=ORIENTED_CLOSED_SHELL('',*,#95,.F.);#93=BREP_WITH_VOIDS('',#90,(#96));\
                 #92=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#93),#1);";
    let model = model(&(square() + faces));
    clean(&model);
    let part = only_part(&model);
    assert_eq!(part.shells.iter().map(|s| s.kind).collect::<Vec<_>>(), [ShellKind::Outer, ShellKind::Void]);
    assert_eq!(part.faces.iter().map(|f| (f.shell, f.reversed)).collect::<Vec<_>>(), [(0, false), (1, true)]);
    // Reversing a face changes neither its surface nor the kept side.
    assert_eq!(area(part, &part.faces[1].loops[0]), 2.0);
}

#[test]
fn two_solids_on_one_shell_get_its_faces_each() {
    let rest = "#91=ADVANCED_FACE('',(#76),#60,.T.);#90=CLOSED_SHELL('',(#91));#93=MANIFOLD_SOLID_BREP('',#90);\
                #94=MANIFOLD_SOLID_BREP('',#90);#92=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#93,#94,#90),#1);";
    let model = model(&(square() + rest));
    clean(&model);
    assert_eq!(only_part(&model).faces.len(), 2);
}

#[test]
fn a_polygon_makes_edges_that_neighbours_share() {
    let points = point(40, [0.0, 0.0, 0.0])
        + &point(41, [1.0, 0.0, 0.0])
        + &point(42, [1.0, 1.0, 0.0])
        + &point(43, [0.0, 1.0, 0.0]);
    let rest = "#60=PLANE('',#20);#75=POLY_LOOP('',(#40,#41,#42));#76=FACE_BOUND('',#75,.T.);\
                #77=POLY_LOOP('',(#40,#42,#43));\
                #78=FACE_BOUND('',#77,.T.);#91=FACE_SURFACE('',(#76),#60,.T.);#94=FACE_SURFACE('',(#78),#60,.T.);\
                #90=CLOSED_SHELL('',(#91,#94));#93=FACETED_BREP('',#90);\
                #92=FACETED_BREP_SHAPE_REPRESENTATION('',(#93),#1);";
    let model = model(&(world() + &points + rest));
    clean(&model);
    let part = only_part(&model);
    assert_eq!((part.faces.len(), part.edges.len(), part.vertices.len()), (2, 5, 4));
    assert!(part.faces.iter().all(|face| area(part, &face.loops[0]) == 1.0));
}

#[test]
fn wrong_senses_are_corrected_and_reported() {
    let wrong = square().replace("#72=ORIENTED_EDGE('',*,*,#52,.T.)", "#72=ORIENTED_EDGE('',*,*,#52,.F.)");
    let model = model(&(wrong + &shell("ADVANCED_FACE('',(#76),#60,.T.)", 1)));
    assert_eq!(area(only_part(&model), &only_face(&model).loops[0]), 2.0);
    let warnings: Vec<_> = model.diagnostics.iter().filter(|d| d.severity == Severity::Warning).collect();
    assert!(warnings.len() == 1 && warnings[0].entity == 91, "{warnings:?}");
}

/// Two faces on one quarter disc, back to back. The arc #50 from #30 at (1,0) to #32 at (0,1) is the quarter; from #32
/// to #30 it is the other three quarters. `arc` states the edge, `uses` how each face's loop uses it on the way from
/// #30 to #32.
fn quarter(arc: &str, uses: [char; 2]) -> Model {
    let text = world()
        + &vertex(30, [1.0, 0.0, 0.0])
        + &vertex(32, [0.0, 1.0, 0.0])
        + &vertex(34, [0.0, 0.0, 0.0])
        + "#60=PLANE('',#20);#61=VECTOR('',#62,1.);#62=DIRECTION('',(1.,0.,0.));#63=LINE('',#21,#61);\
           #64=CIRCLE('',#20,1.);#51=EDGE_CURVE('',#32,#34,#63,.T.);#52=EDGE_CURVE('',#34,#30,#63,.T.);"
        + arc;
    let [first, second] = uses;
    let back = if second == 'T' { 'F' } else { 'T' };
    let rest = format!(
        "#70=ORIENTED_EDGE('',*,*,#50,.{first}.);#71=ORIENTED_EDGE('',*,*,#51,.T.);#72=ORIENTED_EDGE('',*,*,#52,.T.);\
         #73=ORIENTED_EDGE('',*,*,#50,.{back}.);#74=ORIENTED_EDGE('',*,*,#51,.F.);#75=ORIENTED_EDGE('',*,*,#52,.F.);\
         #80=EDGE_LOOP('',(#70,#71,#72));#81=FACE_BOUND('',#80,.T.);#82=EDGE_LOOP('',(#75,#74,#73));\
         #83=FACE_BOUND('',#82,.T.);#91=ADVANCED_FACE('',(#81),#60,.T.);#94=ADVANCED_FACE('',(#83),#60,.F.);\
         #90=CLOSED_SHELL('',(#91,#94));#93=MANIFOLD_SOLID_BREP('',#90);\
         #92=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#93),#1);"
    );
    model(&(text + &rest))
}

/// The midpoint of an edge's curve, from its start.
fn middle(model: &Model, entity: u64) -> DVec3 {
    let edge = edge_of(only_part(model), entity);
    edge.curve.point(0.5 * (edge.range.0 + edge.range.1))
}

#[test]
fn swapped_vertices_of_an_arc_are_exchanged_when_all_loops_say_so() {
    let at = 0.5_f64.sqrt();
    let near_side = DVec3::new(at, at, 0.0);
    let sound = quarter("#50=EDGE_CURVE('',#30,#32,#64,.T.);", ['T', 'T']);
    clean(&sound);
    assert_near(middle(&sound, 50), near_side);
    let swapped = quarter("#50=EDGE_CURVE('',#32,#30,#64,.T.);", ['T', 'T']);
    assert_near(middle(&swapped, 50), near_side);
    let told: Vec<_> = swapped.diagnostics.iter().map(|d| (d.severity, d.entity)).collect();
    assert_eq!(told, [(Severity::Warning, 50)], "{:?}", swapped.diagnostics);
    for face in &only_part(&swapped).faces {
        assert_eq!(corners(only_part(&swapped), &face.loops[0]).len(), 3);
    }
    // One loop alone does not overrule the edge: there the use is reversed.
    let doubtful = quarter("#50=EDGE_CURVE('',#32,#30,#64,.T.);", ['T', 'F']);
    assert_near(middle(&doubtful, 50), -near_side);
    // Exchanging the vertices of an edge on an open curve has no effect.
    let straight = quarter("#50=EDGE_CURVE('',#32,#30,#63,.T.);", ['T', 'T']);
    assert_near(middle(&straight, 50), DVec3::new(0.5, 0.5, 0.0));
}

#[test]
fn an_arc_and_the_wrapped_line_between_its_ends_are_a_whole_turn() {
    for line in ["#63", "#65"] {
        let text = world()
            + &vertex(30, [1.0, 0.0, 0.0])
            + &vertex(32, [1.0, 5e-6, 0.0])
            + "#60=PLANE('',#20);#64=CIRCLE('',#20,1.);#61=VECTOR('',#62,1.);#62=DIRECTION('',(0.,1.,0.));\
               #63=LINE('',#31,#61);#65=SURFACE_CURVE('',#63,(#60),.CURVE_3D.);#50=EDGE_CURVE('',#32,#30,#64,.T.);"
            + &format!("#51=EDGE_CURVE('',#30,#32,{line},.T.);");
        let model = model(&(text + &bounded_face(&[50, 51], 60, 1)));
        clean(&model);
        let arc = edge_of(only_part(&model), 50);
        assert!(arc.range.1 - arc.range.0 > 6.0, "{line}: {arc:?}");
    }
}

#[test]
fn a_bound_without_length_is_no_whole_surface() {
    let text = world()
        + &vertex(30, [1.0, 0.0, 0.0])
        + &vertex(32, [1.0, 0.0, 0.0])
        + "#60=SPHERICAL_SURFACE('',#20,1.);#61=VECTOR('',#62,1.);#62=DIRECTION('',(1.,0.,0.));#63=LINE('',#21,#61);\
           #50=EDGE_CURVE('',#30,#32,#63,.T.);";
    let model = model(&(text + &bounded_face(&[50], 60, 1)));
    assert!(only_face(&model).lost);
    let lost = errors(&model);
    assert!(lost.len() == 1 && lost[0].0 == 91 && lost[0].1.contains("length"), "{lost:?}");
}

#[test]
fn a_lost_face_keeps_its_index() {
    let rest = "#91=ADVANCED_FACE('',(#76),#60,.T.);\
                #94=ADVANCED_FACE('second',(#76),#99,.T.);#95=POLY_LOOP('',());#96=ORIENTED_FACE('',*,#96,.T.);\
                #90=OPEN_SHELL('',(#98,#95,#96,#94,#91));#93=SHELL_BASED_SURFACE_MODEL('',(#90));\
                #92=MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',(#93),#1);";
    let model = model(&(square() + rest));
    let part = only_part(&model);
    let rows: Vec<_> = part.faces.iter().map(|face| (face.entity, face.lost)).collect();
    assert_eq!(rows, [(98, true), (95, true), (96, true), (94, false), (91, false)]);
    assert_eq!(part.faces[3].name, "second");
    let mut told: Vec<_> = model.diagnostics.iter().map(|d| (d.part, d.face, d.entity, d.severity)).collect();
    told.sort_by_key(|at| at.1);
    let expected = [98, 95, 96].into_iter().enumerate();
    let expected: Vec<_> =
        expected.map(|(row, entity)| (Some(PartId(0)), Some(FaceId::new(row)), entity, Severity::Error)).collect();
    assert_eq!(told, expected, "{:?}", model.diagnostics);
    assert!(part.check().is_ok());
    let prepared = prepared(model);
    assert_eq!(prepared.parts[0].face_rows, [None, None, None, Some(0), Some(1)]);
    assert_eq!(prepared.diagnostics.len(), 4, "reported once");
}

#[test]
fn an_open_loop_is_closed_straight_and_reported_with_its_place() {
    let rest = "#77=EDGE_LOOP('',(#70,#71));#78=FACE_BOUND('',#77,.T.);#91=ADVANCED_FACE('',(#76),#60,.T.);\
                #94=ADVANCED_FACE('',(#78),#60,.T.);#90=OPEN_SHELL('',(#94,#91));\
                #93=SHELL_BASED_SURFACE_MODEL('',(#90));\
                #92=MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',(#93),#1);";
    let model = model(&(square() + rest));
    let rows: Vec<_> = only_part(&model).faces.iter().map(|face| (face.entity, face.lost)).collect();
    assert_eq!(rows, [(94, false), (91, false)]);
    assert_eq!(errors(&model), []);
    let prepared = prepared(model);
    assert_eq!(prepared.parts[0].face_rows, [Some(0), Some(1)]);
    let told: Vec<_> = prepared.diagnostics.iter().filter(|d| d.severity == Severity::Warning).collect();
    assert!(told.len() == 1 && told[0].entity == 94 && told[0].kind.code() == "wire-gap-bridged", "{told:?}");
    assert!(told[0].place.is_some());
}

fn errors(model: &Model) -> Vec<(u64, String)> {
    let lost = model.diagnostics.iter().filter(|d| d.severity == Severity::Error);
    lost.map(|d| (d.entity, d.kind.to_string())).collect()
}

#[test]
fn coincident_vertices_are_joined_and_edges_without_length_are_removed() {
    // A fifth edge without length between two vertices at the corner (0,0).
    let split =
        square().replace("#53=EDGE_CURVE('',#36,#30,", "#53=EDGE_CURVE('',#36,#38,").replace("#73))", "#73,#74))")
            + &vertex(38, [0.0, 0.0, 0.0])
            + "#54=EDGE_CURVE('',#38,#30,#63,.T.);#74=ORIENTED_EDGE('',*,*,#54,.T.);";
    let model = model(&(split + &shell("ADVANCED_FACE('',(#76),#60,.T.)", 1)));
    clean(&model);
    let part = only_part(&model);
    assert_eq!((part.edges.len(), part.vertices.len()), (4, 4));
    assert_eq!(area(part, &part.faces[0].loops[0]), 2.0);
}

#[test]
fn edges_without_length_may_have_composite_curves() {
    let trimmed = "#80=TRIMMED_CURVE('',#63,(#31),(#31),.T.,.CARTESIAN.);";
    let segment = "#81=COMPOSITE_CURVE_SEGMENT(.DISCONTINUOUS.,.T.,#80);#82=COMPOSITE_CURVE('',(#81),.F.);";
    for curve in ["#80", "#82"] {
        let text = square()
            + trimmed
            + segment
            + &format!("#54=EDGE_CURVE('',#30,#30,{curve},.T.);")
            + "#74=ORIENTED_EDGE('',*,*,#54,.T.);#77=EDGE_LOOP('',(#70,#71,#72,#73,#74));\
               #78=FACE_OUTER_BOUND('',#77,.T.);";
        let model = model(&(text + &shell("ADVANCED_FACE('',(#78),#60,.T.)", 1)));
        clean(&model);
        let part = only_part(&model);
        assert_eq!((part.edges.len(), area(part, &part.faces[0].loops[0])), (4, 2.0), "{curve}");
    }
}

#[test]
fn a_bounded_surface_takes_its_ends_from_parameter_curves() {
    // The unit square of a plane, bounded by unbounded lines that only their pcurves trim.
    let mut text = world()
        + "#60=PLANE('',#20);#59=(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()\
           REPRESENTATION_CONTEXT('',''));";
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    for (i, [x, y]) in corners.into_iter().enumerate() {
        let [dx, dy] = [corners[(i + 1) % 4][0] - x, corners[(i + 1) % 4][1] - y];
        let id = 100 + 20 * i;
        text += &format!(
            "#{}=LINE('',#{},#{});#{}=VECTOR('',#{},1.);#{}=DIRECTION('',({dx:?},{dy:?},0.));\
             #{}=CARTESIAN_POINT('',({:?},{:?},0.));\
             #{}=CARTESIAN_POINT('',({x:?},{y:?}));#{}=DIRECTION('',({dx:?},{dy:?}));#{}=VECTOR('',#{},1.);\
             #{}=LINE('',#{},#{});\
             #{}=TRIMMED_CURVE('',#{},(PARAMETER_VALUE(0.)),(PARAMETER_VALUE(1.)),.T.,.PARAMETER.);\
             #{}=DEFINITIONAL_REPRESENTATION('',(#{}),#59);#{}=PCURVE('',#60,#{});\
             #{}=SURFACE_CURVE('',#{},(#{}),.CURVE_3D.);#{}=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#{});",
            id,
            id + 1,
            id + 2,
            id + 2,
            id + 3,
            id + 3,
            id + 1,
            x - 3.0 * dx,
            y - 3.0 * dy,
            id + 4,
            id + 5,
            id + 6,
            id + 5,
            id + 7,
            id + 4,
            id + 6,
            id + 8,
            id + 7,
            id + 9,
            id + 8,
            id + 10,
            id + 9,
            id + 11,
            id,
            id + 10,
            id + 12,
            id + 11,
        );
    }
    text += "#70=OUTER_BOUNDARY_CURVE('',(#112,#132,#152,#172),.F.);#71=CURVE_BOUNDED_SURFACE('',#60,(#70),.F.);\
             #72=GEOMETRIC_SET('',(#71));#92=GEOMETRICALLY_BOUNDED_SURFACE_SHAPE_REPRESENTATION('',(#72),#1);";
    let model = model(&text);
    clean(&model);
    let part = only_part(&model);
    assert_eq!((part.edges.len(), part.vertices.len()), (4, 4));
    assert_eq!(area(part, &only_face(&model).loops[0]), 2.0);
    // With an outer boundary of the surface's own sides, the stated one is a hole.
    let implicit = crate::model(&text.replace("(#70),.F.);#72", "(#70),.T.);#72"));
    let told = |t: &StepTrouble| matches!(t, StepTrouble::NotRead { what: "implicit outer bounds", .. });
    assert!(implicit.diagnostics.iter().any(|d| is(d, told)), "{:?}", implicit.diagnostics);
}

#[test]
fn a_broken_inner_loop_costs_only_itself() {
    for (bad, loop_) in [
        ("#77=FACE_BOUND('',#78,.T.);#78=EDGE_LOOP('',());", 78),
        ("#77=FACE_BOUND('',#78,.T.);", 78),
        ("", 77),
        (
            "#77=FACE_BOUND('',#78,.T.);#78=EDGE_LOOP('',(#79));#79=ORIENTED_EDGE('',*,*,#80,.T.);\
          #80=EDGE_CURVE('',#30,#30,#81,.T.);#81=FOO_CURVE();",
            81,
        ),
    ] {
        for bounds in ["#76,#77", "#77,#76"] {
            let model = model(&(square() + bad + &shell(&format!("ADVANCED_FACE('',({bounds}),#60,.T.)"), 1)));
            assert!(!only_face(&model).lost, "{bad}");
            assert_eq!(area(only_part(&model), &only_face(&model).loops[0]), 2.0);
            let told: Vec<_> = model.diagnostics.iter().filter(|d| d.severity >= Severity::Warning).collect();
            assert!(told.len() == 1 && told[0].severity == Severity::Error && told[0].entity == 91, "{told:?}");
            assert!(told[0].face.is_some() && told[0].place.is_some(), "{told:?}");
            assert!(told[0].kind.to_string().contains(&format!("#{loop_}")), "{told:?}");
        }
        // A broken outer loop costs the face; the diagnostic has a place.
        let model = model(
            &(square()
                + "#79=FACE_BOUND('',#75,.T.);"
                + &bad.replace("FACE_BOUND", "FACE_OUTER_BOUND").replace("#79", "#89")
                + &shell("ADVANCED_FACE('',(#77,#79),#60,.T.)", 1)),
        );
        assert!(only_face(&model).lost, "{bad}");
        let told: Vec<_> = model.diagnostics.iter().filter(|d| d.severity == Severity::Error).collect();
        assert!(told.len() == 1 && told[0].place.is_some(), "{told:?}");
    }
}

/// A quarter of a disc in a context, whose arc #50 of radius 1 starts `off` inside of its vertex #30.
fn quarter_off(off: f64, context: u32) -> Model {
    let text = world()
        + &vertex(30, [1.0 + off, 0.0, 0.0])
        + &vertex(32, [0.0, 1.0, 0.0])
        + &vertex(34, [0.0, 0.0, 0.0])
        + "#60=PLANE('',#20);#61=VECTOR('',#62,1.);#62=DIRECTION('',(1.,0.,0.));#63=LINE('',#21,#61);\
           #64=CIRCLE('',#20,1.);#50=EDGE_CURVE('',#30,#32,#64,.T.);#51=EDGE_CURVE('',#32,#34,#63,.T.);\
           #52=EDGE_CURVE('',#34,#30,#63,.T.);";
    let fine = "#900=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#901))\
                GLOBAL_UNIT_ASSIGNED_CONTEXT((#5,#6,#7))REPRESENTATION_CONTEXT('',''));#901=\
                UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-8),#5,'distance_accuracy_value','');";
    model(&(text + fine + &bounded_face(&[50, 51, 52], 60, context)))
}

#[test]
fn an_edge_off_its_vertex_is_reported_once_with_face_and_place() {
    let prepared = prepared(quarter_off(0.2, 1));
    let told: Vec<_> = prepared
        .diagnostics
        .iter()
        .filter(|d| matches!(d.kind.code(), "edge-misses-vertex" | "step-edge-pulled"))
        .collect();
    assert!(told.len() == 1 && told[0].severity == Severity::Warning && told[0].entity == 50, "{told:?}");
    assert_eq!((told[0].face, told[0].place), (Some(FaceId::new(0)), Some(DVec3::X * 1.2)));
    assert!(told[0].kind.to_string().contains("2.000e-1 mm"), "{told:?}");
}

#[test]
fn an_edge_off_its_vertex_by_what_programs_round_is_a_note() {
    // Context 900 has a tolerance of 1e-8 mm.
    for (off, severity) in [(1.2e-6, Severity::Note), (1e-5, Severity::Warning)] {
        let model = quarter_off(off, 900);
        let told: Vec<_> = model.diagnostics.iter().map(|d| (d.kind.code(), d.severity)).collect();
        assert_eq!(told, [("step-edges-off-vertices", severity)], "{off}");
    }
}

/// A disc of radius 2 whose circle #50 starts and ends at a vertex `off` inside of it; with further bounds and their
/// entities.
fn disc(off: f64, bounds: &str, rest: &str) -> Model {
    let circle = "#60=CIRCLE('',#20,2.);#50=EDGE_CURVE('',#30,#30,#60,.T.);#70=ORIENTED_EDGE('',*,*,#50,.T.);\
                  #75=EDGE_LOOP('',(#70));#76=FACE_OUTER_BOUND('',#75,.T.);#77=PLANE('',#20);";
    let face = shell(&format!("ADVANCED_FACE('',(#76{bounds}),#77,.T.)"), 1);
    model(&(world() + &vertex(30, [2.0 - off, 0.0, 0.0]) + circle + rest + &face))
}

#[test]
fn a_vertex_that_ends_one_closed_edge_is_moved_onto_its_curve() {
    let model = disc(0.01, "", "");
    clean(&model);
    let (part, edge) = (only_part(&model), edge_of(only_part(&model), 50));
    assert_near(part.vertices[edge.start.index()], DVec3::X * 2.0);
    for i in 0..=20 {
        let t = edge.range.0 + (edge.range.1 - edge.range.0) * f64::from(i) / 20.0;
        assert!((edge.curve.point(t).length() - 2.0).abs() < 1e-12);
    }
    let told: Vec<_> = model.diagnostics.iter().filter(|d| d.entity == 50).collect();
    assert!(told.len() == 1 && told[0].kind.code() == "step-vertex-moved", "{told:?}");
}

#[test]
fn a_vertex_that_ends_another_edge_or_is_a_loop_stays_where_it_is() {
    let slit = vertex(32, [1.0, 0.0, 0.0])
        + "#51=EDGE_CURVE('',#30,#32,#63,.T.);#63=LINE('',#31,#61);#61=VECTOR('',#62,1.);#62=DIRECTION('',(1.,0.,0.));\
           #71=ORIENTED_EDGE('',*,*,#51,.T.);#72=ORIENTED_EDGE('',*,*,#51,.F.);#78=EDGE_LOOP('',(#71,#72));\
           #79=FACE_BOUND('',#78,.T.);";
    let point = "#78=VERTEX_LOOP('',#30);#79=FACE_BOUND('',#78,.T.);";
    for rest in [slit.as_str(), point] {
        let model = disc(0.01, ",#79", rest);
        let (part, edge) = (only_part(&model), edge_of(only_part(&model), 50));
        assert_near(part.vertices[edge.start.index()], DVec3::X * 1.99);
        assert_near(edge.curve.point(edge.range.0), DVec3::X * 1.99);
        let told: Vec<_> = model.diagnostics.iter().filter(|d| d.entity == 50).collect();
        assert!(told.len() == 1 && told[0].kind.code() == "step-edge-pulled", "{told:?}");
    }
}
