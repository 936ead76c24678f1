//! Entities defined by other geometry: replicas, offset curves, points on curves and surfaces, trimmed surfaces.

use crate::{
    assert_near, bounded_face, clean, edge_of, file, is, model, only_face, only_part, point, shell, vertex, world,
};
use glam::DVec3;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};
use trimtess::import::step::{StepOptions, read};
use trimtess::model::{CurveKind, CurveTrouble, Edge, FitTrouble, Model, Part, Severity, StepTrouble, Surface};

/// The edge #50 from `start` to `end` on curve #60, in a face with a straight second edge.
fn edge(start: [f64; 3], end: [f64; 3], curve: &str) -> Edge {
    let text = world()
        + &vertex(30, start)
        + &vertex(32, end)
        + "#50=EDGE_CURVE('',#30,#32,#60,.T.);#51=EDGE_CURVE('',#32,#30,#55,.T.);#55=LINE('',#31,#56);\
           #56=VECTOR('',#57,1.);#57=DIRECTION('',(1.,0.,0.));#77=PLANE('',#20);"
        + curve
        + &bounded_face(&[50, 51], 77, 1);
    let model = model(&text);
    clean(&model);
    edge_of(only_part(&model), 50).clone()
}

fn middle(edge: &Edge) -> DVec3 {
    edge.curve.point(0.5 * (edge.range.0 + edge.range.1))
}

#[test]
fn offsets_of_lines_and_circles_are_exact() {
    let up = "#80=DIRECTION('',(0.,0.,1.));";
    let circle = |sign: &str| format!("{up}#60=OFFSET_CURVE_3D('',#61,{sign}0.5,.F.,#80);#61=CIRCLE('',#20,2.);");
    // Up × tangent points to the centre.
    let inner = edge([1.5, 0.0, 0.0], [0.0, 1.5, 0.0], &circle(""));
    assert_near(middle(&inner), DVec3::new(1.5, 1.5, 0.0) * FRAC_1_SQRT_2);
    let outer = edge([2.5, 0.0, 0.0], [0.0, 2.5, 0.0], &circle("-"));
    assert_near(middle(&outer), DVec3::new(2.5, 2.5, 0.0) * FRAC_1_SQRT_2);
    let line = format!("{up}#60=OFFSET_CURVE_3D('',#61,2.,.F.,#80);#61=LINE('',#21,#62);#62=VECTOR('',#23,1.);");
    assert_eq!(edge([0.0, 2.0, 0.0], [5.0, 2.0, 0.0], &line).curve.points.len(), 2);
}

#[test]
fn offsets_of_trimmed_curves_keep_their_ends() {
    // A quarter of a circle, then a line along y, both moved towards the left of their direction.
    let curve = "#80=DIRECTION('',(0.,0.,1.));\
        #60=COMPOSITE_CURVE('',(#81,#82),.F.);#81=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#83);\
        #82=COMPOSITE_CURVE_SEGMENT(.DISCONTINUOUS.,.T.,#84);\
        #83=OFFSET_CURVE_3D('',#85,0.5,.F.,#80);#84=OFFSET_CURVE_3D('',#86,0.5,.F.,#80);\
        #85=TRIMMED_CURVE('',#87,(PARAMETER_VALUE(0.)),(PARAMETER_VALUE(1.5707963267948966)),.T.,.PARAMETER.);\
        #86=TRIMMED_CURVE('',#88,(PARAMETER_VALUE(1.5)),(PARAMETER_VALUE(5.)),.T.,.PARAMETER.);\
        #87=CIRCLE('',#20,2.);#88=LINE('',#89,#62);#62=VECTOR('',#63,1.);#63=DIRECTION('',(0.,1.,0.));"
        .to_owned()
        + &point(89, [0.5, 0.0, 0.0]);
    let edge = edge([1.5, 0.0, 0.0], [0.0, 5.0, 0.0], &curve);
    let corner = edge.range.0 + FRAC_PI_2;
    assert_near(edge.curve.point(edge.range.0 + 0.5 * FRAC_PI_2), DVec3::new(1.5, 1.5, 0.0) * FRAC_1_SQRT_2);
    assert_near(edge.curve.point(corner), DVec3::Y * 1.5);
    assert_near(edge.curve.point(0.5 * (corner + edge.range.1)), DVec3::Y * 3.25);
    // Against the direction of the circle, the left is outside.
    let reversed = curve
        .replace("(0.)),(PARAMETER_VALUE(1.5707963267948966)),.T.", "(1.5707963267948966)),(PARAMETER_VALUE(0.)),.F.")
        .replace(".T.,#83", ".F.,#83")
        .replace(&point(89, [0.5, 0.0, 0.0]), &point(89, [0.5, 1.0, 0.0]));
    let outer = self::edge([2.5, 0.0, 0.0], [0.0, 6.0, 0.0], &reversed);
    assert_near(outer.curve.point(outer.range.0 + FRAC_PI_2), DVec3::Y * 2.5);
}

#[test]
fn offsets_of_other_curves_keep_the_tolerance() {
    let curve = "#60=OFFSET_CURVE_3D('',#61,0.25,.F.,#80);#80=DIRECTION('',(0.,0.,1.));#61=ELLIPSE('',#20,4.,2.);";
    let half = edge([3.75, 0.0, 0.0], [-3.75, 0.0, 0.0], curve);
    for k in 1..200 {
        let p = half.curve.point(half.range.0 + (half.range.1 - half.range.0) * f64::from(k) / 200.0);
        // The distance from the ellipse, by dense sampling.
        let on = |t: f64| DVec3::new(4.0 * t.cos(), 2.0 * t.sin(), 0.0);
        let nearest = (0..20_000).map(|i| on(std::f64::consts::PI * f64::from(i) / 20_000.0).distance(p));
        let distance = nearest.fold(f64::INFINITY, f64::min);
        assert!((distance - 0.25).abs() < 1.1e-3, "{distance} at {p}");
    }
    // At a corner of the basis curve the offset would jump.
    let points: String =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]].into_iter().zip(40..).map(|(p, id)| point(id, p)).collect();
    let text = world()
        + &points
        + &vertex(30, [0.0, 0.0, 0.0])
        + "#60=OFFSET_CURVE_3D('',#61,0.25,.F.,#22);#61=POLYLINE('',(#40,#41,#42));#50=EDGE_CURVE('',#30,#30,#60,.T.);\
           #77=PLANE('',#20);"
        + &bounded_face(&[50], 77, 1);
    let told = model(&text).diagnostics;
    assert!(
        told.iter()
            .any(|d| d.severity == Severity::Error
                && is(d, |t| matches!(t, StepTrouble::Fit(FitTrouble::Corner { .. })))),
        "{told:?}"
    );
}

#[test]
fn replicas_of_curves_and_surfaces_are_moved_exactly() {
    let operator = point(80, [1.0, 0.0, 0.0]) + "#81=CARTESIAN_TRANSFORMATION_OPERATOR_3D('','',$,$,$,#80,2.,$);";
    let circle = operator.clone() + "#60=CURVE_REPLICA('',#61,#81);#61=CIRCLE('',#20,1.);";
    let arc = edge([3.0, 0.0, 0.0], [1.0, 2.0, 0.0], &circle);
    assert_near(middle(&arc), DVec3::X + DVec3::new(2.0, 2.0, 0.0) * FRAC_1_SQRT_2);
    let text = world()
        + &vertex(30, [1.0, 0.0, 4.0])
        + &operator
        + "#60=SURFACE_REPLICA('',#61,#81);#61=SPHERICAL_SURFACE('',#20,2.);#75=VERTEX_LOOP('',#30);\
           #76=FACE_BOUND('',#75,.T.);"
        + &shell("ADVANCED_FACE('',(#76),#60,.T.)", 1);
    let model = model(&text);
    clean(&model);
    let Surface::Sphere { frame, radius } = only_face(&model).surface else { panic!("no sphere") };
    assert_eq!((frame.origin, radius), (DVec3::X, 4.0));
}

/// The vertex of a face on a sphere, bounded by a vertex at point #40.
fn vertex_at(context: u32, stated: &str) -> DVec3 {
    let text = world()
        + stated
        + "#30=VERTEX_POINT('',#40);#60=SPHERICAL_SURFACE('',#20,2.);#75=VERTEX_LOOP('',#30);\
           #76=FACE_BOUND('',#75,.T.);"
        + &shell("ADVANCED_FACE('',(#76),#60,.T.)", context);
    let model = model(&text);
    clean(&model);
    only_part(&model).vertices[0]
}

#[test]
fn points_may_be_defined_by_others() {
    assert_near(vertex_at(2, "#40=POINT_ON_CURVE('',#41,90.);#41=CIRCLE('',#20,3.);"), DVec3::Y * 3.0);
    assert_near(
        vertex_at(2, "#40=POINT_ON_SURFACE('',#41,90.,5.);#41=CYLINDRICAL_SURFACE('',#20,3.);"),
        DVec3::new(0.0, 3.0, 5.0),
    );
    let moved = point(42, [1.0, 1.0, 1.0])
        + "#40=POINT_REPLICA('',#42,#43);#43=CARTESIAN_TRANSFORMATION_OPERATOR_3D('','',$,$,$,#42,3.,$);";
    assert_near(vertex_at(1, &moved), DVec3::splat(4.0));
    // The image of v = 90 degrees on a sphere is its pole.
    let pole = "#40=DEGENERATE_PCURVE('',#41,#43);#41=SPHERICAL_SURFACE('',#20,3.);\
                #43=DEFINITIONAL_REPRESENTATION('',(#44),#2);#44=POLYLINE('',(#45,#46));\
                #45=CARTESIAN_POINT('',(0.,90.));#46=CARTESIAN_POINT('',(360.,90.));";
    assert_near(vertex_at(2, pole), DVec3::Z * 3.0);
    let circle = "#40=POINT_REPLICA('',#40,#20);";
    let text = world()
        + circle
        + "#30=VERTEX_POINT('',#40);#60=SPHERICAL_SURFACE('',#20,2.);#75=VERTEX_LOOP('',#30);\
           #76=FACE_BOUND('',#75,.T.);"
        + &shell("ADVANCED_FACE('',(#76),#60,.T.)", 1);
    let told = model(&text).diagnostics;
    assert!(
        told.iter().any(|d| d.severity == Severity::Error && is(d, |t| matches!(t, StepTrouble::TooDeep { .. }))),
        "{told:?}"
    );
}

#[test]
fn an_edge_may_be_given_in_parameters_only() {
    // On the cylinder: a quarter turn while rising by 3.
    let curve = "#60=PCURVE('',#61,#62);#61=CYLINDRICAL_SURFACE('',#20,2.);\
                 #62=DEFINITIONAL_REPRESENTATION('',(#63),#1);\
                 #63=POLYLINE('',(#64,#65));#64=CARTESIAN_POINT('',(0.,0.));\
                 #65=CARTESIAN_POINT('',(1.5707963267948966,3.));";
    let helix = edge([2.0, 0.0, 0.0], [0.0, 2.0, 3.0], curve);
    for k in 0..=50 {
        let s = f64::from(k) / 50.0;
        let (sin, cos) = (FRAC_PI_2 * s).sin_cos();
        let p = helix.curve.point(helix.range.0 + (helix.range.1 - helix.range.0) * s);
        assert!(p.distance(DVec3::new(2.0 * cos, 2.0 * sin, 3.0 * s)) < 1e-3, "{p}");
    }
}

#[test]
fn a_line_in_the_parameters_of_a_plane_ends_at_the_vertices() {
    let curve = "#60=PCURVE('',#61,#62);#61=PLANE('',#20);#62=DEFINITIONAL_REPRESENTATION('',(#63),#1);\
                 #63=LINE('',#64,#65);#64=CARTESIAN_POINT('',(0.,0.));#65=VECTOR('',#66,1.);\
                 #66=DIRECTION('',(1.,2.));";
    let line = edge([1.0, 2.0, 0.0], [3.0, 6.0, 0.0], curve);
    assert_eq!((line.kind, line.range), (CurveKind::Line, (0.0, 1.0)));
    assert_near(middle(&line), DVec3::new(2.0, 4.0, 0.0));
}

/// The edge between two points along a line of a surface's parameters, and a point of it.
fn along(surface: &str, at: [f64; 2], direction: [f64; 2], [start, end]: [[f64; 3]; 2], middle: [f64; 3]) -> CurveKind {
    let numbers = |[u, v]: [f64; 2]| format!("({u:?},{v:?})");
    let line = format!(
        "#60=PCURVE('',#61,#62);#62=DEFINITIONAL_REPRESENTATION('',(#63),#1);#63=LINE('',#64,#65);\
         #64=CARTESIAN_POINT('',{});#65=VECTOR('',#66,1.);#66=DIRECTION('',{});{surface}",
        numbers(at),
        numbers(direction)
    );
    let edge = edge(start, end, &line);
    assert_near(edge.curve.point(edge.range.0), start.into());
    assert_near(self::middle(&edge), middle.into());
    assert_near(edge.curve.point(edge.range.1), end.into());
    edge.kind
}

#[test]
fn lines_along_one_parameter_of_a_surface_end_at_the_vertices() {
    let r = FRAC_1_SQRT_2;
    let ball = "#61=SPHERICAL_SURFACE('',#20,3.);";
    let kind = along(ball, [0.0, -1.0], [0.0, 1.0], [[3.0, 0.0, 0.0], [0.0, 0.0, 3.0]], [3.0 * r, 0.0, 3.0 * r]);
    assert_eq!(kind, CurveKind::Circle);
    let tube = "#61=CYLINDRICAL_SURFACE('',#20,2.);";
    let kind = along(tube, [7.0, 3.0], [-1.0, 0.0], [[0.0, 2.0, 3.0], [2.0, 0.0, 3.0]], [2.0 * r, 2.0 * r, 3.0]);
    assert_eq!(kind, CurveKind::Circle);
    let kind = along(tube, [FRAC_PI_2, 0.0], [0.0, 1.0], [[0.0, 2.0, 3.0], [0.0, 2.0, 1.0]], [0.0, 2.0, 2.0]);
    assert_eq!(kind, CurveKind::Line);
    let ring = "#61=TOROIDAL_SURFACE('',#20,5.,1.);";
    let ends = [[0.0, 6.0, 0.0], [0.0, 5.0, 1.0]];
    assert_eq!(along(ring, [FRAC_PI_2, 0.0], [0.0, 2.0], ends, [0.0, 5.0 + r, r]), CurveKind::Circle);
    let swept = "#61=SURFACE_OF_LINEAR_EXTRUSION('',#82,#83);#82=CIRCLE('',#20,2.);#83=VECTOR('',#22,1.);";
    along(swept, [0.0, 3.0], [1.0, 0.0], [[2.0, 0.0, 3.0], [0.0, 2.0, 3.0]], [2.0 * r, 2.0 * r, 3.0]);
    let profile = [[2.0, 0.0, 0.0], [4.0, 0.0, 2.0]].into_iter().zip(84..).map(|(p, id)| point(id, p));
    let turned = "#61=SURFACE_OF_REVOLUTION('',#82,#83);#82=POLYLINE('',(#84,#85));#83=AXIS1_PLACEMENT('',#21,#22);"
        .to_owned()
        + &profile.collect::<String>();
    along(&turned, [FRAC_PI_2, 0.0], [0.0, 1.0], [[0.0, 2.0, 0.0], [0.0, 4.0, 2.0]], [0.0, 3.0, 1.0]);
    // A saddle; its lines along either parameter are straight, the diagonal is not.
    let corners = [[0.0, 0.0, 0.0], [0.0, 2.0, 2.0], [2.0, 0.0, 2.0], [2.0, 2.0, 0.0]];
    let net = "#61=B_SPLINE_SURFACE_WITH_KNOTS('',1,1,((#84,#85),(#86,#87)),.UNSPECIFIED.,.F.,.F.,.F.,(2,2),(2,2),\
               (0.,1.),(0.,1.),.UNSPECIFIED.);"
        .to_owned()
        + &corners.into_iter().zip(84..).map(|(p, id)| point(id, p)).collect::<String>();
    along(&net, [0.0, 0.25], [1.0, 0.0], [[0.0, 0.5, 0.5], [2.0, 0.5, 1.5]], [1.0, 0.5, 1.0]);
    along(&net, [1.0, 0.0], [0.0, -1.0], [[2.0, 2.0, 0.0], [2.0, 0.0, 2.0]], [2.0, 1.0, 1.0]);
    along(&net, [0.5, 0.5], [1.0, 1.0], [[0.0, 0.0, 0.0], [2.0, 2.0, 0.0]], [1.0, 1.0, 1.0]);
}

#[test]
fn a_conic_in_the_parameters_of_a_plane_is_a_conic() {
    let curve = "#60=PCURVE('',#61,#62);#61=PLANE('',#20);#62=DEFINITIONAL_REPRESENTATION('',(#63),#1);\
                 #63=PARABOLA('',#64,1.);#64=AXIS2_PLACEMENT_2D('',#65,#66);#65=CARTESIAN_POINT('',(1.,0.));\
                 #66=DIRECTION('',(0.,1.));";
    // x = 1 - 2t, y = t²
    let arc = edge([3.0, 1.0, 0.0], [-1.0, 1.0, 0.0], curve);
    assert_eq!(arc.kind, CurveKind::Conic);
    assert_near(middle(&arc), DVec3::new(1.0, 0.0, 0.0));
}

/// A geometric set of one rectangular trimmed surface #60 over surface #61.
fn rectangle(context: u32, surface: &str, trims: &str) -> Model {
    let text = world()
        + surface
        + &format!(
            "#60=RECTANGULAR_TRIMMED_SURFACE('',#61,{trims});#70=GEOMETRIC_SET('',(#60));\
             #92=GEOMETRICALLY_BOUNDED_SURFACE_SHAPE_REPRESENTATION('',(#70),#{context});"
        );
    read(file(&text).as_bytes(), &StepOptions::default()).expect("a readable file")
}

/// Corners and middle of the face, in the order of its parameters.
fn corners(model: &Model) -> [DVec3; 5] {
    clean(model);
    let part: &Part = only_part(model);
    assert!(part.edges.is_empty() && part.faces[0].loops.is_empty());
    let surface = &part.faces[0].surface;
    let [(a, b), (c, d)] = surface.natural_domain();
    [(a, c), (b, c), (a, d), (b, d), (0.5 * (a + b), 0.5 * (c + d))].map(|(u, v)| surface.point(u, v))
}

#[test]
fn trimmed_surfaces_without_faces_end_where_they_are_trimmed() {
    let plane = rectangle(3, "#61=PLANE('',#20);", "1.,2.,3.,5.,.T.,.T.");
    for (p, (x, y)) in corners(&plane).into_iter().zip([(1.0, 3.0), (2.0, 3.0), (1.0, 5.0), (2.0, 5.0), (1.5, 4.0)]) {
        assert_near(p, DVec3::new(x, y, 0.0) * 25.4);
    }
    let tube = rectangle(2, "#61=CYLINDRICAL_SURFACE('',#20,2.);", "350.,10.,0.,4.,.T.,.T.");
    let at = |degrees: f64, z: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        DVec3::new(2.0 * cos, 2.0 * sin, z)
    };
    for (p, q) in corners(&tube).into_iter().zip([at(350., 0.), at(10., 0.), at(350., 4.), at(10., 4.), at(0., 2.)]) {
        assert_near(p, q);
    }
    let swept = "#61=SURFACE_OF_LINEAR_EXTRUSION('',#62,#63);#62=CIRCLE('',#20,2.);#63=VECTOR('',#22,1.);";
    let swept = rectangle(2, swept, "20.,50.,0.,4.,.T.,.T.");
    for (p, q) in corners(&swept).into_iter().zip([at(20., 0.), at(50., 0.), at(20., 4.), at(50., 4.)]) {
        assert_near(p, q);
    }
    let turned = rectangle(1, "#61=PLANE('',#20);", "2.,1.,3.,5.,.F.,.T.");
    assert_near(corners(&turned)[0], DVec3::new(1.0, 3.0, 0.0));
    assert!(only_face(&turned).reversed);
    let empty = rectangle(1, "#61=PLANE('',#20);", "2.,1.,3.,5.,.T.,.T.");
    assert!(
        only_face(&empty).lost
            && empty
                .diagnostics
                .iter()
                .any(|d| is(d, |t| *t == StepTrouble::SurfaceTrim { range: (2.0, 1.0), beyond: false }))
    );
}

/// Corners of a rectangle over the surface #61 in degrees, compared with `at` at the stated parameters.
fn assert_corners_at(surface: &str, trims: [f64; 4], at: impl Fn(f64, f64) -> DVec3) {
    let [u0, u1, v0, v1] = trims;
    let found = corners(&rectangle(2, surface, &format!("{u0:?},{u1:?},{v0:?},{v1:?},.T.,.T.")));
    for (p, (u, v)) in found.into_iter().zip([(u0, v0), (u1, v0), (u0, v1), (u1, v1)]) {
        assert!(p.distance(at(u, v)) < 1e-9, "{surface} at {u}, {v}: {p}, not {}", at(u, v));
    }
}

/// A trimmed curve #62 of #64 from the first parameter to the second.
fn trimmed(from: f64, to: f64, sense: char) -> String {
    format!("#62=TRIMMED_CURVE('',#64,(PARAMETER_VALUE({from:?})),(PARAMETER_VALUE({to:?})),.{sense}.,.PARAMETER.);")
}

fn on_circle(degrees: f64, radius: f64, z: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    DVec3::new(radius * cos, radius * sin, z)
}

const CIRCLE: &str = "#62=CIRCLE('',#20,2.);";
const EXTRUSION: &str = "#61=SURFACE_OF_LINEAR_EXTRUSION('',#62,#63);#63=VECTOR('',#22,1.);";
/// The circle of radius 1 about (5, 0, 0) in the plane y = 0, from its outermost point upwards, about z.
const RING: &str = "#62=CIRCLE('',#74,1.);#61=SURFACE_OF_REVOLUTION('',#62,#71);#71=AXIS1_PLACEMENT('',#21,#22);\
    #74=AXIS2_PLACEMENT_3D('',#72,#73,#23);#72=CARTESIAN_POINT('',(5.,0.,0.));#73=DIRECTION('',(0.,-1.,0.));";

#[test]
fn parameters_on_swept_curves_are_those_of_the_curve() {
    let arc = |of: String| of + "#64=CIRCLE('',#20,2.);" + EXTRUSION;
    assert_corners_at(&arc(trimmed(30.0, 150.0, 'T')), [10.0, 70.0, 0.0, 4.0], |u, v| on_circle(30.0 + u, 2.0, v));
    assert_corners_at(&arc(trimmed(150.0, 30.0, 'F')), [10.0, 70.0, 0.0, 4.0], |u, v| on_circle(150.0 - u, 2.0, v));
    let line = |of: String| of + "#64=LINE('',#21,#65);#65=VECTOR('',#23,3.);" + EXTRUSION;
    let along = |u: f64, v: f64| DVec3::new(3.0 * u, 0.0, v);
    assert_corners_at(&line(trimmed(1.0, 5.0, 'T')), [1.0, 3.0, 0.0, 4.0], |u, v| along(1.0 + u, v));
    assert_corners_at(&line(trimmed(5.0, 1.0, 'F')), [1.0, 3.0, 0.0, 4.0], |u, v| along(5.0 - u, v));
    let torus = |u: f64, v: f64| {
        let (sin, cos) = v.to_radians().sin_cos();
        on_circle(u, 5.0 + cos, sin)
    };
    assert_corners_at(RING, [20.0, 50.0, 100.0, 130.0], torus);
    assert_corners_at(RING, [20.0, 50.0, 370.0, 430.0], torus);
}

#[test]
fn a_turned_curve_without_ends_is_cut_at_the_trims() {
    let turned = |profile: &str| {
        format!(
            "#61=SURFACE_OF_REVOLUTION('',#62,#63);#63=AXIS1_PLACEMENT('',#21,#22);#64=CARTESIAN_POINT('',(5.,0.,1.));\
             {profile}"
        )
    };
    let line = turned("#62=LINE('',#64,#65);#65=VECTOR('',#66,2.);#66=DIRECTION('',(3.,0.,4.));");
    assert_corners_at(&line, [20.0, 50.0, -1.0, 4.0], |u, v| on_circle(u, 5.0 + 1.2 * v, 1.0 + 1.6 * v));
    let parabola =
        turned("#62=PARABOLA('',#65,0.5);#65=AXIS2_PLACEMENT_3D('',#64,#66,#23);#66=DIRECTION('',(0.,-1.,0.));");
    assert_corners_at(&parabola, [20.0, 50.0, -1.0, 2.0], |u, v| on_circle(u, 5.0 + 0.5 * v * v, 1.0 + v));
}

#[test]
fn a_swept_line_keeps_the_units_of_both_directions() {
    let skew = "#61=SURFACE_OF_LINEAR_EXTRUSION('',#62,#63);#62=LINE('',#21,#64);#64=VECTOR('',#23,3.);\
                #63=VECTOR('',#65,2.);#65=DIRECTION('',(3.,0.,4.));";
    let at = |u: f64, v: f64| DVec3::new(3.0 * u + 1.2 * v, 0.0, 1.6 * v);
    assert_corners_at(skew, [-1.0, 5.0, 2.0, 4.0], at);
    assert_near(vertex_at(2, &format!("#40=POINT_ON_SURFACE('',#61,-2.,5.);{skew}")), at(-2.0, 5.0));
    let nested = skew.replace("#61=", "#66=") + "#61=RECTANGULAR_TRIMMED_SURFACE('',#66,-1.,5.,2.,4.,.T.,.T.);";
    assert_corners_at(&nested, [1.0, 2.0, 0.5, 1.0], |u, v| at(u - 1.0, v + 2.0));
}

#[test]
fn parameters_on_derived_surfaces_are_those_of_their_basis() {
    let circle = CIRCLE.to_owned() + &EXTRUSION.replace("#61=", "#66=");
    let wider = circle.clone() + "#61=OFFSET_SURFACE('',#66,1.,.F.);";
    for (p, (u, v)) in corners(&rectangle(2, &wider, "20.,50.,0.,4.,.T.,.T.")).into_iter().zip([(20., 0.), (50., 0.)]) {
        assert!(p.distance(on_circle(u, 3.0, v)) < 2e-3, "{p}");
    }
    let nested = circle + "#61=RECTANGULAR_TRIMMED_SURFACE('',#66,20.,100.,1.,5.,.T.,.T.);";
    assert_corners_at(&nested, [10.0, 70.0, 1.0, 2.0], |u, v| on_circle(20.0 + u, 2.0, v + 1.0));
    let back = nested.replace("20.,100.,1.,5.,.T.,.T.", "100.,20.,5.,1.,.F.,.F.");
    let found = corners(&rectangle(2, &back, "10.,70.,1.,2.,.T.,.T."));
    assert_near(found[0], on_circle(30.0, 2.0, 3.0));
    assert_near(found[3], on_circle(90.0, 2.0, 4.0));
    let spindle = "#61=DEGENERATE_TOROIDAL_SURFACE('',#20,1.,2.,.T.);";
    let at = |u: f64, v: f64| {
        let (sin, cos) = v.to_radians().sin_cos();
        on_circle(u, 1.0 + 2.0 * cos, 2.0 * sin)
    };
    assert_corners_at(spindle, [20.0, 50.0, -70.0, 25.0], at);
    assert_near(vertex_at(2, &format!("#40=POINT_ON_SURFACE('',#61,20.,25.);{spindle}")), at(20.0, 25.0));
}

#[test]
fn points_and_curves_on_swept_curves_use_the_angle_of_a_circle() {
    let extrusion = CIRCLE.to_owned() + EXTRUSION;
    assert_near(vertex_at(2, &format!("#40=POINT_ON_SURFACE('',#61,20.,3.);{extrusion}")), on_circle(20.0, 2.0, 3.0));
    assert_near(vertex_at(2, &format!("#40=POINT_ON_SURFACE('',#61,380.,3.);{extrusion}")), on_circle(20.0, 2.0, 3.0));
    assert_near(
        vertex_at(2, &format!("#40=POINT_ON_SURFACE('',#61,90.,60.);{RING}")),
        DVec3::new(0.0, 5.5, 0.75_f64.sqrt()),
    );
    let helix = "#60=PCURVE('',#61,#66);#66=DEFINITIONAL_REPRESENTATION('',(#67),#1);\
                 #67=POLYLINE('',(#68,#69));#68=CARTESIAN_POINT('',(0.,0.));\
                 #69=CARTESIAN_POINT('',(1.5707963267948966,3.));"
        .to_owned()
        + &extrusion;
    let helix = edge([2.0, 0.0, 0.0], [0.0, 2.0, 3.0], &helix);
    for k in 0..=50 {
        let s = f64::from(k) / 50.0;
        let p = helix.curve.point(helix.range.0 + (helix.range.1 - helix.range.0) * s);
        assert!(p.distance(on_circle(90.0 * s, 2.0, 3.0 * s)) < 1e-3, "{p}");
    }
}

#[test]
fn parameters_that_are_not_kept_are_refused() {
    let composite = "#62=COMPOSITE_CURVE('',(#64),.F.);#64=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#65);\
                     #65=CIRCLE('',#20,2.);";
    let hyperbola = trimmed(0.0, 2.0, 'T') + "#64=HYPERBOLA('',#20,2.,1.);";
    for profile in [composite, &hyperbola] {
        let model = rectangle(2, &(profile.to_owned() + EXTRUSION), "0.,1.,0.,1.,.T.,.T.");
        assert!(only_face(&model).lost, "{profile}");
        let refused =
            |t: &StepTrouble| matches!(t, StepTrouble::Curve(CurveTrouble::OnComposite) | StepTrouble::NotRead { .. });
        assert!(model.diagnostics.iter().any(|d| d.severity == Severity::Error && is(d, refused)), "{profile}");
    }
}

#[test]
fn trims_beyond_the_surface_end_with_it() {
    for (surface, trims) in [
        ("#61=SPHERICAL_SURFACE('',#20,4.);", "0.,1.,0.,9.,.T.,.T."),
        ("#61=SPHERICAL_SURFACE('',#20,4.);", "0.,9.,0.,1.,.T.,.T."),
        ("#61=TOROIDAL_SURFACE('',#20,4.,1.);", "0.,1.,0.,9.,.T.,.T."),
    ] {
        let model = rectangle(1, surface, trims);
        let told: Vec<_> = model.diagnostics.iter().filter(|d| d.severity >= Severity::Warning).collect();
        assert!(told.len() == 1 && told[0].severity == Severity::Warning && told[0].face.is_some(), "{told:?}");
        let face = &only_part(&model).faces[0];
        let ((u0, u1), (v0, v1)) = match &face.surface {
            Surface::Nurbs(net) => net.domain(),
            other => panic!("{other:?}"),
        };
        // No place occurs twice: the middles of the domain's quarters are distinct.
        let at = |i: f64, j: f64| face.surface.point(u0 + (u1 - u0) * i, v0 + (v1 - v0) * j);
        assert!(at(0.05, 0.05).distance(at(0.9, 0.9)) > 0.1 && at(0.1, 0.1).distance(at(0.1, 0.8)) > 0.1);
    }
    let model = rectangle(1, "#61=SPHERICAL_SURFACE('',#20,4.);", "0.,1.,2.,9.,.T.,.T.");
    assert!(model.diagnostics.iter().any(
        |d| d.severity == Severity::Error && is(d, |t| matches!(t, StepTrouble::SurfaceTrim { beyond: true, .. }))
    ));
}

#[test]
fn a_replica_of_a_turned_line_ends_with_its_own_face() {
    // Moved by 10; the face's ring is on the replica.
    let moved = "#60=SURFACE_REPLICA('',#65,#80);#65=SURFACE_OF_REVOLUTION('',#62,#66);\
        #80=CARTESIAN_TRANSFORMATION_OPERATOR_3D('',$,$,#81,1.,$);#81=CARTESIAN_POINT('',(0.,0.,10.));";
    let curve = crate::surfaces::turned_cone(10.0, moved);
    assert_near(curve.points[0], DVec3::Z * 10.0);
    assert!(curve.points[1].z > 12.0);
}
