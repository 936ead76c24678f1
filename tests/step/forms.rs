//! Rare forms of faces, edges and vertices: read, or refused with the number of the unread entity. Nothing is lost
//! silently.

use crate::common::prepared;
use crate::{
    assert_near, bounded_face, clean, edge_of, file, is, model, model_of_file, only_face, only_part, point, shell,
    vertex, world,
};
use glam::DVec3;
use trimtess::model::{Loop, Model, Severity, StepTrouble, Surface};

/// A square of side 2 in z = 1.
fn square() -> String {
    crate::square(2.0, 1.0)
}

fn plane(model: &Model) -> (DVec3, DVec3) {
    let Surface::Plane { frame } = only_face(model).surface else { panic!("no plane: {:?}", model.diagnostics) };
    (frame.origin, frame.z)
}

/// Severity, entity and message of diagnostics worse than a note.
fn told(model: &Model) -> Vec<(Severity, u64, String)> {
    let bad = model.diagnostics.iter().filter(|d| d.severity > Severity::Note);
    bad.map(|d| (d.severity, d.entity, d.kind.to_string())).collect()
}

#[test]
fn a_face_without_surface_lies_in_the_plane_of_its_bounds() {
    for face in [
        "FACE('',(#76))",
        "FACE_SURFACE('',(#76),$,.T.)",
        "ADVANCED_FACE('',(#76),*,.T.)",
        "(FACE((#76))REPRESENTATION_ITEM('')TOPOLOGICAL_REPRESENTATION_ITEM())",
    ] {
        let model = model(&(square() + &shell(face, 1)));
        clean(&model);
        let (origin, normal) = plane(&model);
        assert_near(normal, DVec3::Z);
        assert!((origin.z - 1.0).abs() < 1e-12, "{origin}");
        assert!(!only_face(&model).reversed && only_part(&model).edges.len() == 4);
    }
    let clockwise = model(&(square().replace("#75,.T.)", "#75,.F.)") + &shell("FACE('',(#76))", 1)));
    clean(&clockwise);
    assert_near(plane(&clockwise).1, -DVec3::Z);
}

#[test]
fn polygons_and_holes_imply_their_plane() {
    let points: String = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 3.0, 3.0], [0.0, 3.0, 3.0]]
        .into_iter()
        .zip(40..)
        .map(|(p, id)| point(id, p))
        .collect();
    let polygon = "#75=POLY_LOOP('',(#40,#41,#42,#43));#76=FACE_BOUND('',#75,.T.);";
    let model = model(&(world() + &points + polygon + &shell("FACE('',(#76))", 1)));
    clean(&model);
    assert_near(plane(&model).1, DVec3::new(0.0, -1.0, 1.0).normalize());
    // A round hole in a square; the hole alone would give the opposite normal.
    let hole = "#80=CIRCLE('',#81,0.5);#81=AXIS2_PLACEMENT_3D('',#83,#22,#23);#83=CARTESIAN_POINT('',(1.,1.,1.));\
                #84=VERTEX_POINT('',#85);#85=CARTESIAN_POINT('',(1.5,1.,1.));#86=EDGE_CURVE('',#84,#84,#80,.T.);\
                #87=ORIENTED_EDGE('',*,*,#86,.F.);#88=EDGE_LOOP('',(#87));#89=FACE_BOUND('',#88,.T.);";
    let holed = crate::model(&(square() + hole + &shell("FACE('',(#89,#76))", 1)));
    clean(&holed);
    assert_near(plane(&holed).1, DVec3::Z);
    assert_eq!(only_face(&holed).loops.len(), 2);
}

#[test]
fn a_face_without_surface_and_plane_is_reported() {
    // Bent by 0.3: read, with a warning.
    let bent = square().replace("(0.00000000000000000000,2.00000000000000000000,1.", "(0.,2.,1.3");
    let bent = model(&(bent + &shell("FACE('',(#76))", 1)));
    assert!(!only_face(&bent).lost);
    let warnings = told(&bent);
    assert!(warnings.len() == 1 && warnings[0].0 == Severity::Warning && warnings[0].1 == 91, "{warnings:?}");
    assert!(warnings[0].2.contains("mm off their plane"), "{warnings:?}");
    // A vertex loop, no bounds, and a broken bound define no plane and leave nothing to fill.
    let alone = "#77=VERTEX_LOOP('',#30);#78=FACE_BOUND('',#77,.T.);";
    let broken = "#77=EDGE_LOOP('',(#79));#79=EDGE_CURVE('',#30,#30,#99,.T.);#78=FACE_BOUND('',#77,.T.);";
    for (text, face) in [
        (alone, "FACE('',(#78))"),
        ("", "FACE('',())"),
        (broken, "FACE('',(#78))"),
        ("", "FACE()"),
        ("", "SUBFACE('',(#76),#91)"),
    ] {
        let model = model(&(square() + text + &shell(face, 1)));
        assert!(only_face(&model).lost, "{face}");
        let errors = told(&model);
        assert!(errors.len() == 1 && errors[0].0 == Severity::Error && errors[0].1 == 91, "{face}: {errors:?}");
    }
}

#[test]
fn a_face_whose_surface_is_not_read_keeps_its_loops() {
    // The surface is missing from the entity, unsupported or invalid, or missing from the file.
    for (text, face, reason) in [
        ("", "FACE_SURFACE('',(#76))", ""),
        ("", "ADVANCED_FACE('',(#76),.T.,.F.)", ""),
        ("#59=FOO_SURFACE('',#20);", "ADVANCED_FACE('',(#76),#59,.F.)", "FOO_SURFACE"),
        ("#59=CYLINDRICAL_SURFACE('',#20,-1.);", "ADVANCED_FACE('',(#76),#59,.T.)", "radius"),
        ("", "ADVANCED_FACE('',(#76),#99,.T.)", "#99"),
    ] {
        let model = model(&(square() + text + &shell(face, 1)));
        assert!(told(&model).is_empty(), "{face}: {:?}", model.diagnostics);
        let read = only_face(&model);
        assert!(
            !read.lost && read.refused.as_ref().is_some_and(|why| why.to_string().contains(reason)),
            "{face}: {read:?}"
        );
        assert!(!read.reversed && read.loops.len() == 1, "{face}: the loops have the face's orientation");
        assert!(only_part(&model).check().is_ok());
        let prepared = prepared(model);
        assert_eq!(prepared.parts[0].face_rows, [Some(0)]);
        let [told] = &prepared.diagnostics[..] else { panic!("{face}: {:?}", prepared.diagnostics) };
        assert!(told.severity == Severity::Warning && told.entity == 91 && told.face.is_some(), "{told:?}");
        assert!(
            told.kind.to_string().contains(reason) && told.kind.to_string().contains("about 4.000e0 mm²"),
            "{told:?}"
        );
    }
    // Nothing defines the face between a line and its reverse: it is lost.
    let back = "#74=ORIENTED_EDGE('',*,*,#50,.F.);#77=EDGE_LOOP('',(#70,#74));#78=FACE_OUTER_BOUND('',#77,.T.);";
    let model = model(&(square() + back + &shell("FACE('',(#78))", 1)));
    let prepared = prepared(model);
    assert_eq!(prepared.parts[0].face_rows, [None]);
    let [told] = &prepared.diagnostics[..] else { panic!("{:?}", prepared.diagnostics) };
    assert!(
        told.severity == Severity::Error && told.entity == 91 && is(told, |t| *t == StepTrouble::NoPlane),
        "{told:?}"
    );
    assert!(!prepared.scene.parts[0].closed);
}

#[test]
fn an_edge_whose_curve_is_not_read_is_straight() {
    let face = shell("ADVANCED_FACE('',(#76),#60,.T.)", 1);
    let sound = square().replace("#50=EDGE_CURVE('',#30,#32,#63,.T.);", "");
    for (edge, reason) in [
        ("#50=EDGE_CURVE('',#30,#32,#99,.T.);", "#99"),
        ("#50=EDGE_CURVE('',#30,#32,$,.T.);", "straight"),
        ("#50=EDGE_CURVE('',#30,#32,#98,.T.);#98=FOO_CURVE();", "FOO_CURVE"),
        ("#50=EDGE('',#30,#32);", "straight"),
        // Both ends lie at one parameter of the curve, which is a short line from (5,5,1) away from both.
        (
            "#50=EDGE_CURVE('',#30,#32,#98,.T.);#98=B_SPLINE_CURVE_WITH_KNOTS('',1,(#96,#97),.UNSPECIFIED.,.F.,.F.,\
             (2,2),(0.,1.),.UNSPECIFIED.);#96=CARTESIAN_POINT('',(5.,5.,1.));#97=CARTESIAN_POINT('',(6.,6.,1.));",
            "same parameter",
        ),
    ] {
        let model = model(&(sound.clone() + edge + &face));
        assert!(!only_face(&model).lost && only_face(&model).refused.is_none(), "{edge}");
        let straight = edge_of(only_part(&model), 50);
        assert_eq!(straight.curve.points, [DVec3::new(0.0, 0.0, 1.0), DVec3::new(2.0, 0.0, 1.0)]);
        let told = told(&model);
        assert!(told.len() == 1 && told[0].0 == Severity::Warning && told[0].1 == 50, "{edge}: {told:?}");
        assert!(told[0].2.contains(reason), "{edge}: {told:?}");
        assert!(model.diagnostics.iter().all(|d| d.face.is_some() && d.place.is_some()));
    }
    // If it starts and ends in one vertex, nothing defines its path.
    let model = model(&(sound + "#50=EDGE_CURVE('',#30,#30,#99,.T.);" + &face));
    assert!(only_face(&model).lost);
}

#[test]
fn a_faceted_solid_may_imply_all_its_planes() {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut text: String = corners.into_iter().zip(40..).map(|(p, id)| point(id, p)).collect();
    for (k, [a, b, c]) in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].into_iter().enumerate() {
        let id = 50 + 3 * k;
        text += &format!("#{id}=POLY_LOOP('',(#{},#{},#{}));", 40 + a, 40 + b, 40 + c);
        text += &format!("#{}=FACE_OUTER_BOUND('',#{id},.T.);#{}=FACE('',(#{}));", id + 1, id + 2, id + 1);
    }
    text += "#90=CLOSED_SHELL('',(#52,#55,#58,#61));#93=FACETED_BREP('',#90);\
             #92=FACETED_BREP_SHAPE_REPRESENTATION('',(#93),#1);";
    let model = model(&(world() + &text));
    clean(&model);
    assert_eq!((only_part(&model).faces.len(), only_part(&model).edges.len()), (4, 6));
    for face in &only_part(&model).faces {
        let Surface::Plane { frame } = face.surface else { panic!("no plane") };
        let out = frame.origin - DVec3::splat(0.25);
        assert!(frame.z.dot(out) > 0.0 && !face.reversed, "#{}", face.entity);
    }
}

#[test]
fn a_seam_edge_is_an_oriented_edge() {
    // A cylinder of height 1, cut open along its seam.
    let text = world()
        + &vertex(30, [2.0, 0.0, 0.0])
        + &vertex(32, [2.0, 0.0, 1.0])
        + &crate::placement(24, [0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
        + "#60=CYLINDRICAL_SURFACE('',#20,2.);#61=CIRCLE('',#20,2.);#62=CIRCLE('',#24,2.);#63=LINE('',#31,#64);\
           #64=VECTOR('',#22,1.);#50=EDGE_CURVE('',#30,#30,#61,.T.);#51=EDGE_CURVE('',#30,#32,#63,.T.);\
           #52=EDGE_CURVE('',#32,#32,#62,.T.);#70=ORIENTED_EDGE('',*,*,#50,.T.);#71=SEAM_EDGE('',*,*,#51,.T.,#98);\
           #72=ORIENTED_EDGE('',*,*,#52,.F.);#73=SEAM_EDGE('',*,*,#51,.F.,#99);\
           #75=EDGE_LOOP('',(#70,#71,#72,#73));#76=FACE_BOUND('',#75,.T.);";
    let model = model(&(text + &shell("ADVANCED_FACE('',(#76),#60,.T.)", 1)));
    clean(&model);
    let Loop::Edges(coedges) = &only_face(&model).loops[0] else { panic!("no edges") };
    assert_eq!(coedges.iter().map(|c| c.reversed).collect::<Vec<_>>(), [false, false, true, true]);
    assert_eq!(only_part(&model).edges.len(), 3);
}

#[test]
fn a_subedge_is_part_of_its_parents_curve() {
    // The half circle from (1,0) over (0,1) to (-1,0) as two subedges, one of a subedge of an oriented edge.
    let text = world()
        + &vertex(30, [1.0, 0.0, 0.0])
        + &vertex(32, [0.0, 1.0, 0.0])
        + &vertex(34, [-1.0, 0.0, 0.0])
        + "#60=PLANE('',#20);#61=VECTOR('',#23,1.);#63=LINE('',#21,#61);#64=CIRCLE('',#20,1.);\
           #50=EDGE_CURVE('',#30,#34,#64,.T.);#51=SUBEDGE('',#30,#32,#50);#52=SUBEDGE('',#34,#32,#53);\
           #53=SUBEDGE('',#34,#30,#54);#54=ORIENTED_EDGE('',*,*,#50,.F.);#55=EDGE_CURVE('',#34,#30,#63,.T.);";
    let face = bounded_face(&[51, -52, 55], 60, 1);
    let sound = model(&(text.clone() + &face));
    clean(&sound);
    let at = 0.5_f64.sqrt();
    for (entity, x) in [(51, at), (52, -at)] {
        let edge = edge_of(only_part(&sound), entity);
        assert_near(edge.curve.point(0.5 * (edge.range.0 + edge.range.1)), DVec3::new(x, at, 0.0));
    }
    // Parents that form a cycle, do not exist, or have no geometry cost the curve, neither the face nor the file.
    for (bad, reason) in [
        ("#53=SUBEDGE('',#34,#30,#52);", "too deeply"),
        ("#53=SUBEDGE('',#34,#30,#99);", "#99"),
        ("#53=EDGE('',#34,#30);", "#53"),
        ("#53=SUBEDGE('',#34,#30,$);", "#53"),
    ] {
        let model = model(&(text.replace("#53=SUBEDGE('',#34,#30,#54);", bad) + &face));
        assert!(!only_face(&model).lost, "{bad}");
        assert_eq!(edge_of(only_part(&model), 52).curve.points.len(), 2, "{bad}");
        let errors = told(&model);
        assert!(errors.len() == 1 && errors[0].1 == 52, "{bad}: {errors:?}");
        assert!(errors[0].2.contains(reason), "{bad}: {errors:?}");
    }
}

#[test]
fn vertices_may_be_points_on_curves_and_surfaces() {
    // The corners of the square as points on a line, on a plane, on a spline and of a degenerate parameter curve.
    let on = square()
        .replace("#30=VERTEX_POINT('',#31)", "#30=VERTEX_POINT('',#100)")
        .replace("#32=VERTEX_POINT('',#33)", "#32=VERTEX_POINT('',#101)")
        .replace("#34=VERTEX_POINT('',#35)", "#34=VERTEX_POINT('',#102)")
        .replace("#36=VERTEX_POINT('',#37)", "#36=VERTEX_POINT('',#103)")
        + "#100=POINT_ON_CURVE('',#110,0.);#110=LINE('',#31,#61);#101=POINT_ON_SURFACE('',#111,2.,0.);\
           #111=PLANE('',#112);\
           #112=AXIS2_PLACEMENT_3D('',#31,#22,#23);#102=POINT_ON_CURVE('',#113,1.);#113=POLYLINE('',(#33,#35,#37));\
           #103=DEGENERATE_PCURVE('',#111,#114);#114=DEFINITIONAL_REPRESENTATION('',(#115),#1);\
           #115=POLYLINE('',(#116,#117));#116=CARTESIAN_POINT('',(0.,2.));#117=CARTESIAN_POINT('',(0.,2.5));";
    let face = shell("FACE('',(#76))", 1);
    let sound = model(&(on.clone() + &face));
    clean(&sound);
    let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
    for (p, [x, y]) in only_part(&sound).vertices.iter().zip(corners) {
        assert_near(*p, DVec3::new(x, y, 1.0));
    }
    // A vertex without a place costs the face; the message names the point.
    for (good, bad, entity) in [
        ("#102=POINT_ON_CURVE('',#113,1.)", "#102=POINT_ON_CURVE('',#113,5.)", 102),
        ("#102=POINT_ON_CURVE('',#113,1.)", "#102=POINT_ON_CURVE('',#99,1.)", 99),
        ("#102=POINT_ON_CURVE('',#113,1.)", "#102=POINT_IN_VOLUME('',#99,1.,1.,1.)", 102),
        ("#113=POLYLINE('',(#33,#35,#37))", "#113=COMPOSITE_CURVE('',(),.F.)", 102),
        ("#101=POINT_ON_SURFACE('',#111,2.,0.)", "#101=POINT_ON_SURFACE('',#111,2.)", 101),
        ("#34=VERTEX_POINT('',#102)", "#34=VERTEX('')", 34),
    ] {
        let model = model(&(on.replace(good, bad) + &face));
        assert!(only_face(&model).lost, "{bad}");
        let errors = told(&model);
        assert!(errors.len() == 1 && errors[0].1 == 91, "{bad}: {errors:?}");
        assert!(errors[0].2.contains(&format!("#{entity}")), "{bad}: {errors:?}");
    }
}

#[test]
fn edges_on_one_long_curve_and_faces_on_one_surface_are_separate() {
    // A polyline of 401 points on a parabola, cut into ten edges. Each bounds, with a chord, a face on one spline
    // surface.
    let mut text = world();
    let mut ids = Vec::new();
    for i in 0..=400_u32 {
        text += &point(1000 + i, [f64::from(i), 1e-3 * f64::from(i * i), 0.0]);
        ids.push(format!("#{}", 1000 + i));
    }
    text += &format!("#60=POLYLINE('',({}));#62=VECTOR('',#23,1.);#63=LINE('',#21,#62);", ids.join(","));
    text += "#61=B_SPLINE_SURFACE_WITH_KNOTS('',1,1,((#900,#901),(#902,#903)),.U.,.F.,.F.,.F.,(2,2),(2,2),\
             (0.,1.),(0.,1.),.U.);";
    for (id, [x, y]) in (900..).zip([[-1.0, -1.0], [-1.0, 200.0], [500.0, -1.0], [500.0, 200.0]]) {
        text += &point(id, [x, y, 0.0]);
    }
    let mut faces = Vec::new();
    for k in 0..=10_u32 {
        text += &format!("#{}=VERTEX_POINT('',#{});", 2000 + k, 1000 + 40 * k);
    }
    for k in 0..10_u32 {
        let (a, b, id) = (2000 + k, 2001 + k, 3000 + 10 * k);
        text += &format!(
            "#{id}=EDGE_CURVE('',#{a},#{b},#60,.T.);#{}=EDGE_CURVE('',#{b},#{a},#63,.T.);\
             #{}=ORIENTED_EDGE('',*,*,#{id},.T.);\
             #{}=ORIENTED_EDGE('',*,*,#{},.T.);#{}=EDGE_LOOP('',(#{},#{}));#{}=FACE_OUTER_BOUND('',#{},.T.);\
             #{}=ADVANCED_FACE('',(#{}),#61,.T.);",
            id + 1,
            id + 2,
            id + 3,
            id + 1,
            id + 4,
            id + 2,
            id + 3,
            id + 5,
            id + 4,
            id + 6,
            id + 5
        );
        faces.push(format!("#{}", id + 6));
    }
    text += &format!(
        "#90=OPEN_SHELL('',({}));#93=SHELL_BASED_SURFACE_MODEL('',(#90));\
         #92=MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',(#93),#1);",
        faces.join(",")
    );
    let model = model(&text);
    clean(&model);
    let part = only_part(&model);
    assert_eq!((part.faces.len(), part.edges.len(), part.vertices.len()), (10, 20, 11));
    for k in 0..10 {
        let edge = edge_of(part, 3000 + 10 * k);
        // Each edge keeps only the control points that it needs.
        assert!(edge.curve.points.len() < 50, "{}", edge.curve.points.len());
        let ends = [edge.range.0, edge.range.1].map(|t| edge.curve.point(t));
        assert_near(ends[0], part.vertices[edge.start.index()]);
        assert_near(ends[1], part.vertices[edge.end.index()]);
        assert!((edge.range.1 - edge.range.0 - 40.0).abs() < 1e-9);
    }
    let first = &part.faces[0].surface;
    assert!(part.faces.iter().all(|face| face.surface == *first));
}

#[test]
fn reals_are_read_as_programs_print_them() {
    let model = model(
        &(world()
            + "#60=SPHERICAL_SURFACE('',#61,+.2e+1);#61=AXIS2_PLACEMENT_3D('',#62,$,$);\
        #62=CARTESIAN_POINT('',(-.5,1e-16,2E0));"
            + &shell("ADVANCED_FACE('',(),#60,.T.)", 1)),
    );
    clean(&model);
    let Surface::Sphere { frame, radius } = only_face(&model).surface else { panic!("no sphere") };
    assert_eq!((frame.origin, radius), (DVec3::new(-0.5, 1e-16, 2.0), 2.0));
}

#[test]
fn words_may_be_in_small_letters() {
    let text = file(&(world() + "#60=SPHERICAL_SURFACE('',#20,2.);" + &shell("ADVANCED_FACE('',(),#60,.f.)", 1)));
    assert!(text.contains("SI_UNIT(.MILLI.,.METRE.)"), "{text}");
    let model = model_of_file(&text.replace(".MILLI.,.METRE.", ".centi.,.Metre."));
    clean(&model);
    let face = only_face(&model);
    let Surface::Sphere { radius, .. } = face.surface else { panic!("no sphere") };
    assert_eq!((radius, face.reversed), (20.0, true));
}
