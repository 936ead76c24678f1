//! Edges that are single points, as some files state them at poles and apexes, and small ones that are not.

use crate::bodies::facts;
use crate::common::{prepared, prepared_clean};
use crate::topology::square;
use crate::{clean, model, only_part, point, shell, vertex, world};
use std::f64::consts::{FRAC_PI_4, PI};
use trimtess::model::{Loop, Model, Part, SurfaceKind};

/// A cone on the unit circle with its apex at (0, 0, 1), and its base. The slanted face has a third edge #52 with
/// `third` as geometry #65, from the apex #32 to vertex `end`. The vertices at the apex are `off` to the side.
fn cone(end: u32, third: &str, off: f64) -> Model {
    let text = world()
        + &vertex(30, [1.0, 0.0, 0.0])
        + &vertex(32, [off, 0.0, 1.0])
        + &vertex(34, [off, 0.0, 1.0])
        + &point(40, [0.0, 0.0, 1.0])
        + &point(41, [0.0, 0.0, 1.0])
        + &format!(
            "#59=CARTESIAN_POINT('',(0.,0.,1.));#58=AXIS2_PLACEMENT_3D('',#59,$,$);\
            #57=DIRECTION('',(0.,0.,-1.));#56=AXIS2_PLACEMENT_3D('',#21,#57,$);\
            #60=CONICAL_SURFACE('',#56,1.,{FRAC_PI_4:?});#61=PLANE('',#56);#62=CIRCLE('',#20,1.);\
            #63=LINE('',#31,#64);#64=VECTOR('',#66,1.);#66=DIRECTION('',(-1.,0.,1.));{third}\
            #50=EDGE_CURVE('',#30,#30,#62,.T.);#51=EDGE_CURVE('',#30,#32,#63,.T.);\
            #52=EDGE_CURVE('',#32,#{end},#65,.T.);\
            #70=ORIENTED_EDGE('',*,*,#50,.T.);#71=ORIENTED_EDGE('',*,*,#51,.T.);\
            #72=ORIENTED_EDGE('',*,*,#52,.T.);#73=ORIENTED_EDGE('',*,*,#51,.F.);\
            #74=ORIENTED_EDGE('',*,*,#50,.F.);#75=EDGE_LOOP('',(#70,#71,#72,#73));#76=EDGE_LOOP('',(#74));\
            #77=FACE_OUTER_BOUND('',#75,.T.);#78=FACE_OUTER_BOUND('',#76,.T.);\
            #80=ADVANCED_FACE('',(#77),#60,.T.);#81=ADVANCED_FACE('',(#78),#61,.T.);\
            #90=CLOSED_SHELL('',(#80,#81));#93=MANIFOLD_SOLID_BREP('',#90);\
            #92=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#93),#1);"
        );
    model(&text)
}

fn loop_lengths(part: &Part) -> Vec<usize> {
    let loops = part.faces.iter().flat_map(|face| &face.loops);
    loops.map(|bound| if let Loop::Edges(edges) = bound { edges.len() } else { 0 }).collect()
}

#[test]
fn an_edge_that_is_a_point_is_left_out_whatever_its_curve() {
    for third in [
        "#65=B_SPLINE_CURVE_WITH_KNOTS('',1,(#40,#41),.UNSPECIFIED.,.F.,.F.,(2,2),(0.,1.),.UNSPECIFIED.);",
        "#65=BEZIER_CURVE('',3,(#40,#41,#40,#41),.UNSPECIFIED.,.F.,.F.);",
        "#65=POLYLINE('',(#40,#41));",
        "#65=POLYLINE('',(#40,#40));",
        "#65=CIRCLE('',#58,0.);",
        "#65=CIRCLE('',#58,1.E-9);",
        "#65=LINE('',#40,#67);#67=VECTOR('',#68,0.);#68=DIRECTION('',(0.,0.,0.));",
        "#65=TRIMMED_CURVE('',#67,(#40),(#41),.T.,.CARTESIAN.);#67=LINE('',#40,#64);",
        "#65=SURFACE_CURVE('',#67,(),.CURVE_3D.);#67=POLYLINE('',(#40,#41));",
    ] {
        for (end, off) in [(32, 0.0), (34, 0.0), (32, 8e-6)] {
            let model = cone(end, third, off);
            clean(&model);
            assert_eq!((only_part(&model).edges.len(), loop_lengths(&model.parts[0])), (2, vec![3, 1]), "{third}");
            prepared_clean(model);
        }
    }
}

/// A sphere in two halves, between half circles from one pole to the other. Each half has an edge #54 to #57 at each
/// pole.
fn halves(uses: [u32; 4]) -> Model {
    let pole = |id: u32, vertex: u32| {
        format!("#{id}=EDGE_CURVE('',#{vertex},#{vertex},#{},.T.);", vertex + 30)
            + &format!("#{}=ORIENTED_EDGE('',*,*,#{id},.T.);", id + 50)
    };
    let [south, north, south_again, north_again] = uses.map(|id| id + 50);
    let text = world()
        + &vertex(30, [0.0, 0.0, -1.0])
        + &vertex(32, [0.0, 0.0, 1.0])
        + "#40=DIRECTION('',(0.,-1.,0.));#41=DIRECTION('',(0.,1.,0.));#42=DIRECTION('',(0.,0.,-1.));\
           #43=AXIS2_PLACEMENT_3D('',#21,#40,#42);#44=AXIS2_PLACEMENT_3D('',#21,#41,#42);\
           #45=CIRCLE('',#43,1.);#46=CIRCLE('',#44,1.);#47=SPHERICAL_SURFACE('',#20,1.);\
           #60=BEZIER_CURVE('',3,(#31,#31,#31,#31),.UNSPECIFIED.,.F.,.F.);\
           #62=BEZIER_CURVE('',3,(#33,#33,#33,#33),.UNSPECIFIED.,.F.,.F.);\
           #50=EDGE_CURVE('',#30,#32,#45,.T.);#51=EDGE_CURVE('',#30,#32,#46,.T.);\
           #100=ORIENTED_EDGE('',*,*,#50,.T.);#101=ORIENTED_EDGE('',*,*,#50,.F.);\
           #102=ORIENTED_EDGE('',*,*,#51,.T.);#103=ORIENTED_EDGE('',*,*,#51,.F.);"
        + &pole(54, 30)
        + &pole(55, 32)
        + &pole(56, 30)
        + &pole(57, 32)
        + &format!(
            "#110=EDGE_LOOP('',(#{south},#102,#{north},#101));\
             #111=EDGE_LOOP('',(#{south_again},#100,#{north_again},#103));\
             #112=FACE_OUTER_BOUND('',#110,.T.);#113=FACE_OUTER_BOUND('',#111,.T.);\
             #114=ADVANCED_FACE('',(#112),#47,.T.);#115=ADVANCED_FACE('',(#113),#47,.T.);\
             #90=CLOSED_SHELL('',(#114,#115));#93=MANIFOLD_SOLID_BREP('',#90);\
             #92=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#93),#1);"
        );
    model(&text)
}

#[test]
fn edges_at_poles_join_no_faces() {
    // Each half has its own, or both have the same.
    for uses in [[54, 55, 56, 57], [54, 55, 54, 55]] {
        let model = halves(uses);
        clean(&model);
        assert_eq!((only_part(&model).edges.len(), loop_lengths(&model.parts[0])), (2, vec![2, 2]));
        prepared_clean(model);
    }
}

#[test]
fn a_pole_may_have_a_loop_of_its_own() {
    let cap = |axis: &str, surface: &str, pole: [f64; 3]| {
        world()
            + &vertex(30, [1.0, 0.0, 0.0])
            + &vertex(32, pole)
            + &format!("#39=DIRECTION('',{axis});#40=AXIS2_PLACEMENT_3D('',#21,#39,$);#60={surface};")
            + "#61=CIRCLE('',#20,1.);#62=POLYLINE('',(#33,#33));\
               #50=EDGE_CURVE('',#30,#30,#61,.T.);#51=EDGE_CURVE('',#32,#32,#62,.T.);\
               #70=ORIENTED_EDGE('',*,*,#50,.T.);#71=ORIENTED_EDGE('',*,*,#51,.T.);\
               #72=EDGE_LOOP('',(#70));#73=EDGE_LOOP('',(#71));\
               #75=FACE_OUTER_BOUND('',#72,.T.);#76=FACE_BOUND('',#73,.T.);"
            + &shell("ADVANCED_FACE('',(#75,#76),#60,.T.)", 1)
    };
    let cone = format!("CONICAL_SURFACE('',#40,1.,{FRAC_PI_4:?})");
    let line = "SURFACE_OF_REVOLUTION('',#64,#41);#41=AXIS1_PLACEMENT('',#21,#39);#64=LINE('',#31,#65);\
                #65=VECTOR('',#66,1.);#66=DIRECTION('',(-1.,0.,1.))";
    for text in [
        cap("(0.,0.,1.)", "SPHERICAL_SURFACE('',#40,1.)", [0.0, 0.0, 1.0]),
        cap("(0.,0.,-1.)", &cone, [0.0, 0.0, 1.0]),
        cap("(0.,0.,1.)", line, [0.0, 0.0, 1.0]),
    ] {
        let model = model(&text);
        clean(&model);
        assert_eq!(loop_lengths(only_part(&model)), [1], "{text}");
        let prepared = prepared(model);
        let told: Vec<_> = prepared.diagnostics.iter().map(|of| of.kind.code()).collect();
        assert_eq!(
            (told.as_slice(), prepared.parts[0].face_rows.as_slice()),
            (["step-loop-without-length"].as_slice(), [Some(0)].as_slice())
        );
    }
}

#[test]
fn short_edges_and_small_holes_stay() {
    // Both are smaller than the tolerance of 1e-5, which some files state far too large.
    let far = [1.0 - 2e-6, 0.0, 0.0];
    let short =
        square().replace("#51=EDGE_CURVE('',#32,#34,", "#51=EDGE_CURVE('',#38,#34,").replace("(#70,", "(#70,#74,")
            + &vertex(38, far)
            + &point(46, far)
            + "#47=POLYLINE('',(#33,#46));#54=EDGE_CURVE('',#32,#38,#47,.T.);#74=ORIENTED_EDGE('',*,*,#54,.T.);";
    let model_of =
        |text: String, bounds: &str| model(&(text + &shell(&format!("ADVANCED_FACE('',({bounds}),#60,.T.)"), 1)));
    assert_eq!(only_part(&model_of(short, "#76")).edges.len(), 5);
    let hole = square()
        + &vertex(38, [0.500_003, 0.5, 0.0])
        + &point(46, [0.5, 0.5, 0.0])
        + "#47=AXIS2_PLACEMENT_3D('',#46,$,$);#48=CIRCLE('',#47,3.E-6);#54=EDGE_CURVE('',#38,#38,#48,.T.);\
           #74=ORIENTED_EDGE('',*,*,#54,.F.);#77=EDGE_LOOP('',(#74));#78=FACE_BOUND('',#77,.T.);";
    let model = model_of(hole, "#76,#78");
    clean(&model);
    assert_eq!(loop_lengths(only_part(&model)), [4, 1]);
}

/// A torus of radii 1 and 1, stated as `surface`. Its rim is #50, #51 is a circle of the tube from there.
fn horn(surface: &str, faces: &str) -> Model {
    let text = world()
        + &vertex(30, [2.0, 0.0, 0.0])
        + &point(40, [1.0, 0.0, 0.0])
        + "#41=DIRECTION('',(0.,-1.,0.));#42=AXIS2_PLACEMENT_3D('',#40,#41,#23);#43=CIRCLE('',#42,1.);\
           #44=CIRCLE('',#20,2.);#45=AXIS1_PLACEMENT('',#21,#22);\
           #50=EDGE_CURVE('',#30,#30,#44,.T.);#51=EDGE_CURVE('',#30,#30,#43,.T.);\
           #70=ORIENTED_EDGE('',*,*,#50,.T.);#71=ORIENTED_EDGE('',*,*,#51,.T.);\
           #72=ORIENTED_EDGE('',*,*,#50,.F.);#73=ORIENTED_EDGE('',*,*,#51,.F.);"
        + &format!("#60={surface};{faces}")
        + "#93=MANIFOLD_SOLID_BREP('',#90);#92=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#93),#1);";
    model(&text)
}

#[test]
fn a_torus_that_touches_its_axis_ends_there_unless_an_edge_comes_there() {
    let halves = "#75=EDGE_LOOP('',(#70));#76=EDGE_LOOP('',(#72));\
                  #77=FACE_OUTER_BOUND('',#75,.T.);#78=FACE_OUTER_BOUND('',#76,.T.);\
                  #80=ADVANCED_FACE('',(#77),#60,.T.);#81=ADVANCED_FACE('',(#78),#60,.T.);\
                  #90=CLOSED_SHELL('',(#80,#81));";
    let whole = "#75=EDGE_LOOP('',(#70,#71,#72,#73));#77=FACE_OUTER_BOUND('',#75,.T.);\
                 #80=ADVANCED_FACE('',(#77),#60,.T.);#90=CLOSED_SHELL('',(#80));";
    for surface in ["TOROIDAL_SURFACE('',#20,1.,1.)", "SURFACE_OF_REVOLUTION('',#43,#45)"] {
        for (faces, kind) in [(halves, SurfaceKind::Revolution), (whole, SurfaceKind::Torus)] {
            let model = horn(surface, faces);
            clean(&model);
            assert!(only_part(&model).faces.iter().all(|face| face.surface.kind() == kind), "{surface}");
            let facts = facts(model);
            assert!(facts.is_closed() && (facts.volume - 2.0 * PI * PI).abs() < 1e-3 * 20.0, "{surface}: {facts}");
        }
    }
}

/// A circle rotated about a chord sweeps an outer and an inner sheet, which meet in two points. Its writer drops the
/// ends of the arc that it rotated.
#[test]
fn a_vertex_and_the_sense_of_a_face_tell_which_sheet_of_a_rotated_circle_it_is() {
    for (sense, volume) in [("T", 57.2996), ("F", 1537.74)] {
        for tip in [4.0, -4.0] {
            let text = world()
                + &vertex(30, [0.0, 0.0, tip])
                + &point(40, [-3.0, 0.0, 0.0])
                + &format!(
                    "#41=DIRECTION('',(0.,-1.,0.));#42=AXIS2_PLACEMENT_3D('',#40,#41,$);#43=CIRCLE('',#42,5.);\
                    #44=AXIS1_PLACEMENT('',#21,$);#45=SURFACE_OF_REVOLUTION('',#43,#44);#46=VERTEX_LOOP('',#30);\
                    #47=FACE_BOUND('',#46,.T.);#80=ADVANCED_FACE('',(#47),#45,.{sense}.);\
                    #90=CLOSED_SHELL('',(#80));#93=MANIFOLD_SOLID_BREP('',#90);\
                    #92=ADVANCED_BREP_SHAPE_REPRESENTATION('',(#93),#1);"
                );
            let model = model(&text);
            clean(&model);
            let facts = facts(model);
            assert!((facts.volume - volume).abs() < 2e-3 * volume, "{sense} {tip}: {}", facts.volume);
        }
    }
}
