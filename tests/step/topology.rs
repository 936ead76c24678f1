//! Loops, senses, shells: the topology that files state, with all its flags.

use crate::{clean, model, near, only_face, only_part, point, shell, vertex, world};
use glam::DVec3;
use trimtess::model::{Coedge, Loop, Model, Part, Severity, ShellKind};

/// Corners of a unit square in z = 0: vertices #30, #32, #34, #36 counterclockwise, edges #50..#53 from each to the next,
/// oriented edges #70..#73 along them.
fn square() -> String {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut text =
        world() + "#60=PLANE('',#20);#61=VECTOR('',#62,1.);#62=DIRECTION('',(1.,0.,0.));#63=LINE('',#21,#61);";
    for (i, [x, y]) in corners.into_iter().enumerate() {
        text += &vertex(30 + 2 * u32::try_from(i).expect("small"), [x, y, 0.0]);
        let (from, to) = (30 + 2 * i, 30 + 2 * ((i + 1) % 4));
        text += &format!("#{}=EDGE_CURVE('',#{from},#{to},#63,.T.);", 50 + i);
        text += &format!("#{}=ORIENTED_EDGE('',*,*,#{},.T.);", 70 + i, 50 + i);
    }
    text
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
        near(end, points[(i + 1) % points.len()]);
    }
    points
}

/// Twice the area that a loop encloses, seen from above.
fn area(part: &Part, bound: &Loop) -> f64 {
    let points = corners(part, bound);
    (0..points.len()).map(|i| points[i].cross(points[(i + 1) % points.len()]).z).sum()
}

#[test]
fn loops_keep_to_the_left_of_the_surface_normal_whatever_the_flags() {
    for (bound, same_sense) in [('T', true), ('F', false), ('T', false), ('F', true)] {
        let sense = if same_sense { 'T' } else { 'F' };
        let rest = format!("#75=EDGE_LOOP('',(#70,#71,#72,#73));#76=FACE_OUTER_BOUND('',#75,.{bound}.);");
        let model = model(&(square() + &rest + &shell(&format!("ADVANCED_FACE('top',(#76),#60,.{sense}.)"), 1)));
        clean(&model);
        let face = only_face(&model);
        assert_eq!((face.reversed, face.name.as_str(), face.entity), (!same_sense, "top", 91));
        // The loop is counterclockwise; each flag that is false turns it once.
        let turned = (bound == 'T') != same_sense;
        assert_eq!(area(only_part(&model), &face.loops[0]), if turned { -2.0 } else { 2.0 });
    }
}

#[test]
fn an_edge_between_two_faces_is_one_edge() {
    let rest = "#75=EDGE_LOOP('',(#70,#71,#72,#73));#76=FACE_OUTER_BOUND('',#75,.T.);#77=ORIENTED_EDGE('',*,*,#70,.F.);\
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
    let faces = "#75=EDGE_LOOP('',(#70,#71,#72,#73));#76=FACE_OUTER_BOUND('',#75,.T.);\
                 #91=ADVANCED_FACE('',(#76),#60,.T.);#90=CLOSED_SHELL('',(#91));#94=ADVANCED_FACE('',(#76),#60,.T.);\
                 #95=CLOSED_SHELL('',(#94));#96=ORIENTED_CLOSED_SHELL('',*,#95,.F.);#93=BREP_WITH_VOIDS('',#90,(#96));\
                 #92=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#93),#1);";
    let model = model(&(square() + faces));
    clean(&model);
    let part = only_part(&model);
    assert_eq!(part.shells.iter().map(|s| s.kind).collect::<Vec<_>>(), [ShellKind::Outer, ShellKind::Void]);
    assert_eq!(part.faces.iter().map(|f| (f.shell, f.reversed)).collect::<Vec<_>>(), [(0, false), (1, true)]);
    // Turning a face over does not change its surface, nor where the kept side lies.
    assert_eq!(area(part, &part.faces[1].loops[0]), 2.0);
}

#[test]
fn two_solids_on_one_shell_get_its_faces_each() {
    let rest = "#75=EDGE_LOOP('',(#70,#71,#72,#73));#76=FACE_OUTER_BOUND('',#75,.T.);\
                #91=ADVANCED_FACE('',(#76),#60,.T.);#90=CLOSED_SHELL('',(#91));#93=MANIFOLD_SOLID_BREP('',#90);\
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
    let rest = "#60=PLANE('',#20);#75=POLY_LOOP('',(#40,#41,#42));#76=FACE_BOUND('',#75,.T.);#77=POLY_LOOP('',(#40,#42,#43));\
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
fn wrong_senses_are_put_right_and_reported() {
    let wrong = square().replace("#72=ORIENTED_EDGE('',*,*,#52,.T.)", "#72=ORIENTED_EDGE('',*,*,#52,.F.)");
    let rest = "#75=EDGE_LOOP('',(#70,#71,#72,#73));#76=FACE_OUTER_BOUND('',#75,.T.);";
    let model = model(&(wrong + rest + &shell("ADVANCED_FACE('',(#76),#60,.T.)", 1)));
    assert_eq!(area(only_part(&model), &only_face(&model).loops[0]), 2.0);
    let warnings: Vec<_> = model.diagnostics.iter().filter(|d| d.severity == Severity::Warning).collect();
    assert!(warnings.len() == 1 && warnings[0].entity == 91, "{warnings:?}");
}

#[test]
fn an_open_loop_costs_its_face_only() {
    let rest = "#75=EDGE_LOOP('',(#70,#71,#72,#73));#76=FACE_OUTER_BOUND('',#75,.T.);\
                #77=EDGE_LOOP('',(#70,#71));#78=FACE_BOUND('',#77,.T.);#91=ADVANCED_FACE('',(#76),#60,.T.);\
                #94=ADVANCED_FACE('',(#78),#60,.T.);#90=OPEN_SHELL('',(#94,#91));#93=SHELL_BASED_SURFACE_MODEL('',(#90));\
                #92=MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',(#93),#1);";
    let model = model(&(square() + rest));
    assert_eq!(only_face(&model).entity, 91);
    let lost = errors(&model);
    assert!(lost.len() == 1 && lost[0].0 == 94 && lost[0].1.contains("open"), "{lost:?}");
}

fn errors(model: &Model) -> Vec<(u64, String)> {
    let lost = model.diagnostics.iter().filter(|d| d.severity == Severity::Error);
    lost.map(|d| (d.entity, d.reason.clone())).collect()
}

#[test]
fn vertices_in_one_place_join_and_edges_without_length_go() {
    // A fifth edge without length between two vertices at the corner (0,0).
    let split = square().replace("#53=EDGE_CURVE('',#36,#30,", "#53=EDGE_CURVE('',#36,#38,")
        + &vertex(38, [0.0, 0.0, 0.0])
        + "#54=EDGE_CURVE('',#38,#30,#63,.T.);#74=ORIENTED_EDGE('',*,*,#54,.T.);\
           #75=EDGE_LOOP('',(#70,#71,#72,#73,#74));#76=FACE_OUTER_BOUND('',#75,.T.);";
    let model = model(&(split + &shell("ADVANCED_FACE('',(#76),#60,.T.)", 1)));
    clean(&model);
    let part = only_part(&model);
    assert_eq!((part.edges.len(), part.vertices.len()), (4, 4));
    assert_eq!(area(part, &part.faces[0].loops[0]), 2.0);
}

#[test]
fn a_bounded_surface_takes_its_ends_from_parameter_curves() {
    // The unit square of a plane, bounded by unbounded lines that only their pcurves cut to length.
    let mut text = world()
        + "#60=PLANE('',#20);#59=(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()REPRESENTATION_CONTEXT('',''));";
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    for (i, [x, y]) in corners.into_iter().enumerate() {
        let [dx, dy] = [corners[(i + 1) % 4][0] - x, corners[(i + 1) % 4][1] - y];
        let id = 100 + 20 * i;
        text += &format!(
            "#{}=LINE('',#{},#{});#{}=VECTOR('',#{},1.);#{}=DIRECTION('',({dx:?},{dy:?},0.));#{}=CARTESIAN_POINT('',({:?},{:?},0.));\
             #{}=CARTESIAN_POINT('',({x:?},{y:?}));#{}=DIRECTION('',({dx:?},{dy:?}));#{}=VECTOR('',#{},1.);#{}=LINE('',#{},#{});\
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
}
