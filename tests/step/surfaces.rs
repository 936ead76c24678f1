//! Faces on every kind of surface, against the formulas of ISO 10303-42.

use crate::common::prepared;
use crate::{assert_near, bounded_face, clean, model, only_face, only_part, placement, point, shell, vertex, world};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};
use trimtess::model::{
    Diagnostic, DiagnosticKind, Face, FaceTrouble, Loop, NurbsCurve3, NurbsSurface, Severity, Surface,
};

/// Reads a face on surface #60, bounded by a vertex loop at `anchor`.
fn face_in(context: u32, anchor: [f64; 3], surface: &str) -> Face {
    let bound = "#75=VERTEX_LOOP('',#30);#76=FACE_BOUND('',#75,.T.);";
    let text = world() + &vertex(30, anchor) + surface + bound + &shell("ADVANCED_FACE('',(#76),#60,.T.)", context);
    let model = model(&text);
    clean(&model);
    assert!(matches!(only_face(&model).loops[..], [Loop::Vertex(_)]));
    only_face(&model).clone()
}

fn face(surface: &str) -> Face {
    face_in(1, [0.0; 3], surface)
}

#[test]
fn elementary_surfaces_stay_what_they_are() {
    let tilted = placement(61, [1.0, 2.0, 3.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let plane = face(&format!("{tilted}#60=PLANE('',#61);")).surface;
    assert_near(plane.point(2.0, 5.0), DVec3::new(6.0, 2.0, 5.0));
    assert_eq!(plane.normal(0.0, 0.0), Some(DVec3::Y));
    let cylinder = face(&format!("{tilted}#60=CYLINDRICAL_SURFACE('',#61,2.);")).surface;
    assert_near(cylinder.point(0.0, 4.0), DVec3::new(1.0, 6.0, 5.0));
    assert_near(cylinder.point(FRAC_PI_2, 0.0), DVec3::new(3.0, 2.0, 3.0));
    let sphere = face("#60=SPHERICAL_SURFACE('',#20,2.);").surface;
    assert_near(sphere.point(0.0, FRAC_PI_2), DVec3::new(0.0, 0.0, 2.0));
    let torus = face("#60=TOROIDAL_SURFACE('',#20,5.,2.);").surface;
    assert_near(torus.point(PI, 0.0), DVec3::new(-7.0, 0.0, 0.0));
}

#[test]
fn units_reach_radii_and_half_angles() {
    let cone = |context| face_in(context, [0.0; 3], "#60=CONICAL_SURFACE('',#20,2.,0.25);").surface;
    // Context 2 has angles in degrees, context 3 lengths in inches.
    let Surface::Cone { radius, half_angle, .. } = cone(2) else { panic!("no cone") };
    assert_eq!(radius, 2.0);
    assert!((half_angle - 0.25f64.to_radians()).abs() < 1e-15);
    let Surface::Cone { radius, half_angle, .. } = cone(3) else { panic!("no cone") };
    assert!((radius - 50.8).abs() < 1e-12 && half_angle == 0.25);
    assert_near(cone(1).point(0.0, 4.0), DVec3::new(2.0 + 4.0 * 0.25f64.tan(), 0.0, 4.0));
}

#[test]
fn a_half_angle_that_must_be_degrees_is_taken_for_degrees() {
    let cone = face("#60=CONICAL_SURFACE('',#20,2.,45.);").surface;
    assert_near(cone.point(0.0, 1.0), DVec3::new(3.0, 0.0, 1.0));
}

#[test]
fn a_degenerate_torus_is_its_outer_or_inner_part() {
    let part = |outer| face(&format!("#60=DEGENERATE_TOROIDAL_SURFACE('',#20,1.,2.,.{outer}.);")).surface;
    for (surface, far) in [(part('T'), 3.0), (part('F'), -1.0)] {
        let [_, (v0, v1)] = surface.natural_domain();
        let middle = 0.5 * (v0 + v1);
        assert_near(surface.point(0.0, middle), DVec3::new(far, 0.0, 0.0));
        // Both ends lie on the axis, where the tube crosses it.
        let height = 3.0f64.sqrt();
        assert!((surface.point(1.0, v0) - DVec3::Z * (-height * far.signum())).length() < 1e-12);
        assert!((surface.point(1.0, v1) - DVec3::Z * (height * far.signum())).length() < 1e-12);
        // S_u × S_v according to the torus formula.
        let d = surface.derivatives(0.0, middle);
        assert!(d.du.cross(d.dv).x * far * far.signum() > 0.0);
    }
}

#[test]
fn a_swept_line_is_a_plane_and_a_swept_circle_a_tube() {
    let line = "#61=LINE('',#21,#62);#62=VECTOR('',#63,1.);#63=DIRECTION('',(1.,0.,0.));\
                #64=VECTOR('',#65,3.);#65=DIRECTION('',(0.,1.,0.));#60=SURFACE_OF_LINEAR_EXTRUSION('',#61,#64);";
    let Surface::Plane { frame } = face(line).surface else { panic!("no plane") };
    assert_near(frame.z, DVec3::Z);
    let tube = "#61=CIRCLE('',#20,2.);#64=VECTOR('',#65,3.);#65=DIRECTION('',(0.,0.,1.));\
                #60=SURFACE_OF_LINEAR_EXTRUSION('',#61,#64);";
    let surface = face(tube).surface;
    assert_near(surface.point(PI, 2.0), DVec3::new(-2.0, 0.0, 6.0));
}

#[test]
fn a_swept_parabola_reaches_the_whole_boundary() {
    // Boundary: a straight edge at height 5 from one arm to the other, and the parabola moved up by 5.
    let arm = |y: f64, z: f64| [0.25 * y * y, y, z];
    let text = world()
        + &vertex(30, arm(-4.0, 5.0))
        + &vertex(32, arm(6.0, 5.0))
        + &placement(40, [0.0, 0.0, 5.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
        + "#61=PARABOLA('',#20,1.);#62=VECTOR('',#63,1.);#63=DIRECTION('',(0.,0.,1.));\
           #60=SURFACE_OF_LINEAR_EXTRUSION('',#61,#62);#64=PARABOLA('',#40,1.);\
           #50=EDGE_CURVE('',#30,#32,#64,.T.);#51=EDGE_CURVE('',#32,#30,#65,.T.);#65=LINE('',#31,#62);"
        + &bounded_face(&[50, 51], 60, 1);
    let model = model(&text);
    clean(&model);
    let Surface::Extrusion { curve, .. } = &only_face(&model).surface else { panic!("no extrusion") };
    let (a, b) = curve.domain();
    assert!(curve.point(a).y < -4.0 && curve.point(b).y > 6.0);
    assert!(curve.point(a).y > -5.0 && curve.point(b).y < 7.0);
    assert_near(curve.point(0.3), DVec3::new(0.09, 0.6, 0.0));
}

#[test]
fn a_turned_line_is_bounded_by_its_face() {
    // A circle of radius 2 at height 3 bounds the face of a cylinder, stated as a revolved line.
    let ring = placement(40, [0.0, 0.0, 3.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
    let text = world()
        + &ring
        + &vertex(30, [2.0, 0.0, 3.0])
        + &point(61, [2.0, 0.0, 0.0])
        + "#62=LINE('',#61,#63);#63=VECTOR('',#64,1.);#64=DIRECTION('',(0.,0.,1.));#66=AXIS1_PLACEMENT('',#21,#22);\
           #60=SURFACE_OF_REVOLUTION('',#62,#66);#67=CIRCLE('',#40,2.);#50=EDGE_CURVE('',#30,#30,#67,.T.);\
           #70=ORIENTED_EDGE('',*,*,#50,.T.);#75=EDGE_LOOP('',(#70));#76=FACE_BOUND('',#75,.T.);\
           #69=FACE_BOUND('',#79,.T.);#79=VERTEX_LOOP('',#80);"
        + &vertex(80, [2.0, 0.0, 1.0])
        + &shell("ADVANCED_FACE('',(#76,#69),#60,.T.)", 1);
    let model = model(&text);
    clean(&model);
    let Surface::Revolution { curve, .. } = &only_face(&model).surface else { panic!("no revolution") };
    let (a, b) = curve.domain();
    assert!(curve.point(a).z < 1.0 && curve.point(b).z > 3.0, "{curve:?}");
    assert!(curve.point(a).z > 0.9 && curve.point(b).z < 3.1, "{curve:?}");
    assert_near(curve.point(0.5 * (a + b)) * DVec3::new(1.0, 1.0, 0.0), DVec3::new(2.0, 0.0, 0.0));
}

/// Profile of the line through `at` along `direction`, turned about z. Circles with these radii and heights bound its
/// face.
fn turned_line(at: [f64; 3], direction: [f64; 3], rings: [[f64; 2]; 2]) -> NurbsCurve3 {
    let [x, y, z] = direction;
    let mut text = world() + &point(61, at);
    for (k, [radius, height]) in (0..).zip(rings) {
        let (place, start, bound) = (40 + 4 * k, 30 + 2 * k, 70 + 5 * k);
        text += &(placement(place, [0.0, 0.0, height], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
            + &vertex(start, [radius, 0.0, height])
            + &format!(
                "#{bound}=CIRCLE('',#{place},{radius:?});#{}=EDGE_CURVE('',#{start},#{start},#{bound},.T.);\
                 #{}=ORIENTED_EDGE('',*,*,#{},.T.);#{}=EDGE_LOOP('',(#{}));#{}=FACE_BOUND('',#{},.T.);",
                bound + 1,
                bound + 2,
                bound + 1,
                bound + 3,
                bound + 2,
                bound + 4,
                bound + 3
            ));
    }
    text += &format!(
        "#62=LINE('',#61,#63);#63=VECTOR('',#64,1.);#64=DIRECTION('',({x:.20},{y:.20},{z:.20}));\
         #66=AXIS1_PLACEMENT('',#21,#22);#60=SURFACE_OF_REVOLUTION('',#62,#66);"
    );
    let model = model(&(text + &shell("ADVANCED_FACE('',(#74,#79),#60,.T.)", 1)));
    clean(&model);
    let Surface::Revolution { curve, .. } = &only_face(&model).surface else { panic!("no revolution") };
    curve.clone()
}

#[test]
fn a_turned_line_ends_with_its_face_however_little_it_is_tilted() {
    for tilt in [0.0, 1e-16, 1e-12, 1e-9, 1e-7, 3e-6] {
        let curve = turned_line([2.0, 0.0, 0.0], [tilt, 0.0, 1.0], [[2.0, 1.0], [2.0, 3.0]]);
        let [low, high] = [curve.points[0].z, curve.points[1].z];
        assert!(low > 0.9 && low < 1.0 && high > 3.0 && high < 3.1, "{tilt}: {curve:?}");
        // Heights are rounded, too.
        let rings = [[1.0, 1.0 - tilt], [3.0, 1.0 + tilt + 1e-9]];
        let curve = turned_line([2.0, 0.0, 1.0], [1.0, 0.0, tilt], rings);
        let [low, high] = [curve.points[0].x, curve.points[1].x];
        // The hull of a circle is larger than the circle.
        assert!(low <= 1.0 && high > 3.0 && high < 4.3, "{tilt}: {curve:?}");
    }
}

#[test]
fn parameter_curves_tell_coinciding_sheets_apart() {
    // A quarter of a sphere, between half circles at -x and -y. The surface is a circle turned about its diameter z:
    // its normal points outwards for parameters up to PI, and inwards beyond.
    let pcurve = |id: u32, u: f64, v: f64| {
        let ends = [(1, v), (2, v + PI)].map(|(k, v)| format!("#{}=CARTESIAN_POINT('',({u:?},{v:?}));", id + k));
        ends.concat()
            + &format!(
                "#{id}=B_SPLINE_CURVE_WITH_KNOTS('',1,(#{},#{}),.UNSPECIFIED.,.F.,.F.,(2,2),(0.,1.),.UNSPECIFIED.);\
                 #{}=DEFINITIONAL_REPRESENTATION('',(#{id}),#1);#{}=PCURVE('',#60,#{});",
                id + 1,
                id + 2,
                id + 3,
                id + 4,
                id + 3
            )
    };
    let is_reversed = |curves: [&str; 2], v: f64, start: f64| {
        let text = world()
            + &placement(40, [0.0; 3], [0.0, -1.0, 0.0], [start.sin(), 0.0, -start.cos()])
            + &placement(44, [0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0])
            + &(vertex(30, [0.0, 0.0, 2.0]) + &vertex(32, [0.0, 0.0, -2.0]))
            + &(pcurve(100, 0.0, v) + &pcurve(110, FRAC_PI_2, v))
            + "#61=CIRCLE('',#40,2.);#62=CIRCLE('',#44,2.);#66=AXIS1_PLACEMENT('',#21,#22);\
               #60=SURFACE_OF_REVOLUTION('',#61,#66);#63=SURFACE_CURVE('',#61,(#104),.PCURVE_S1.);\
               #64=SURFACE_CURVE('',#62,(#114),.PCURVE_S1.);"
            + &format!("#50=EDGE_CURVE('',#30,#32,{},.T.);#51=EDGE_CURVE('',#30,#32,{},.T.);", curves[0], curves[1]);
        let model = model(&(text + &bounded_face(&[51, -50], 60, 1)));
        clean(&model);
        assert!(matches!(only_face(&model).surface, Surface::Sphere { .. }));
        only_face(&model).reversed
    };
    assert!(is_reversed(["#63", "#64"], PI, 0.0));
    assert!(!is_reversed(["#63", "#64"], 0.0, 0.0));
    // Without parameter curves it is less than half of the sphere, wherever the circle starts.
    for start in [0.0, 0.35, 1.2, 2.0, 4.0] {
        assert!(is_reversed(["#61", "#62"], 0.0, start), "{start}");
    }
}

#[test]
fn a_vertex_on_two_coinciding_sheets_chooses_the_first() {
    // An ellipse turned about its major axis, as OpenCASCADE writes whole spheroids. The vertex is off the axis by
    // rounding, and so are ends of the sheets.
    let text = world()
        + &point(31, [-1.836_970_146_529e-16, 0.0, -5.0])
        + "#30=VERTEX_POINT('',#31);#60=SURFACE_OF_REVOLUTION('',#61,#62);#61=ELLIPSE('',#63,5.,3.);\
           #62=AXIS1_PLACEMENT('',#21,#22);#63=AXIS2_PLACEMENT_3D('',#21,#64,#22);#64=DIRECTION('',(0.,-1.,0.));\
           #75=VERTEX_LOOP('',#30);#76=FACE_BOUND('',#75,.F.);"
        + &shell("ADVANCED_FACE('',(#76),#60,.F.)", 1);
    let model = model(&text);
    clean(&model);
    let Surface::Revolution { curve, .. } = &only_face(&model).surface else { panic!("no revolution") };
    assert_eq!(curve.domain(), (0.0, PI));
}

#[test]
fn a_profile_that_ends_near_its_axis_ends_on_it() {
    // The file's points are accurate to 1e-5.
    let poles = |(off, size): (f64, f64)| {
        let profile =
            point(162, [off, 0.0, 0.0]) + &point(163, [size, 0.0, 0.0]) + &point(164, [2.0 * size, 0.0, 2.0 * size]);
        let surface = "#61=BEZIER_CURVE('',2,(#162,#163,#164),.UNSPECIFIED.,.F.,.F.);#66=AXIS1_PLACEMENT('',#21,#22);\
                       #60=SURFACE_OF_REVOLUTION('',#61,#66);";
        face_in(1, [2.0 * size, 0.0, 2.0 * size], &(profile + surface)).surface.poles().len()
    };
    assert_eq!([0.0, 1e-9, 4e-6, -4e-6, 1e-4].map(|off| poles((off, 1.0))), [1, 1, 1, 1, 0]);
    // Two metres wide, and less than a millionth of that.
    assert_eq!([1e-3, -1e-3, 1e-2].map(|off| poles((off, 1e3))), [1, 1, 0]);
}

/// The profile of a face on #60, a cone about z of 45° with its apex at `apex`, bounded by its ring of radius 2.
pub(crate) fn turned_cone(apex: f64, surface: &str) -> NurbsCurve3 {
    let text = world()
        + &vertex(30, [2.0, 0.0, apex + 2.0])
        + &placement(40, [0.0, 0.0, apex + 2.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
        + &point(61, [1.0, 0.0, 1.0])
        + "#62=LINE('',#61,#63);#63=VECTOR('',#64,1.);#64=DIRECTION('',(1.,0.,1.));#66=AXIS1_PLACEMENT('',#21,#22);\
           #67=CIRCLE('',#40,2.);#50=EDGE_CURVE('',#30,#30,#67,.T.);"
        + surface
        + &bounded_face(&[50], 60, 1);
    let model = model(&text);
    clean(&model);
    let Surface::Revolution { curve, .. } = &only_face(&model).surface else { panic!("no revolution") };
    curve.clone()
}

#[test]
fn a_turned_line_bounded_by_one_ring_reaches_the_apex() {
    let curve = turned_cone(0.0, "#60=SURFACE_OF_REVOLUTION('',#62,#66);");
    assert_near(curve.points[0], DVec3::ZERO);
    assert!(curve.points[1].z > 2.0);
}

/// Points #61..#66 of a net of 3 × 2, bent like a roof.
fn roof() -> String {
    let points = [[0.0, 0.0, 0.0], [0.0, 4.0, 0.0], [2.0, 0.0, 2.0], [2.0, 4.0, 2.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0]];
    points.into_iter().zip(61..).map(|(p, id)| point(id, p)).collect()
}

const NET: &str = "((#61,#62),(#63,#64),(#65,#66))";

#[test]
fn b_spline_surfaces_of_every_form() {
    let knots = roof()
        + &format!(
            "#60=B_SPLINE_SURFACE_WITH_KNOTS('',2,1,{NET},.UNSPECIFIED.,.F.,.F.,.F.,(3,3),(2,2),(0.,2.),(0.,1.),\
             .UNSPECIFIED.);"
        );
    let Surface::Nurbs(net) = face(&knots).surface else { panic!("no net") };
    assert_eq!((net.degree_u, net.degree_v, net.knots_u.len(), net.knots_v.len()), (2, 1, 6, 4));
    assert_near(net.point(1.0, 0.5), DVec3::new(2.0, 2.0, 1.0));
    for form in ["BEZIER", "QUASI_UNIFORM"] {
        let text = roof() + &format!("#60={form}_SURFACE('',2,1,{NET},.UNSPECIFIED.,.F.,.F.,.F.);");
        assert_near(face(&text).surface.point(0.5, 0.5), DVec3::new(2.0, 2.0, 1.0));
    }
    let uniform = roof() + &format!("#60=UNIFORM_SURFACE('',1,1,{NET},.UNSPECIFIED.,.F.,.F.,.F.);");
    assert_near(face(&uniform).surface.point(1.0, 0.5), DVec3::new(2.0, 2.0, 2.0));
    let rational = |weights: &str| {
        let net = format!(
            "#60=(BOUNDED_SURFACE()B_SPLINE_SURFACE(2,1,{NET},.UNSPECIFIED.,.F.,.F.,.F.)\
             B_SPLINE_SURFACE_WITH_KNOTS((3,3),(2,2),(0.,1.),(0.,1.),.UNSPECIFIED.)GEOMETRIC_REPRESENTATION_ITEM()\
             RATIONAL_B_SPLINE_SURFACE(({weights}))REPRESENTATION_ITEM('')SURFACE());"
        );
        face(&(roof() + &net)).surface.point(0.5, 0.5)
    };
    assert_near(rational("(1.,1.),(3.,3.),(1.,1.)"), DVec3::new(2.0, 2.0, 1.5));
    // Equal weights cancel, however large.
    assert_near(rational("(1.E200,1.E200),(1.E200,1.E200),(1.E200,1.E200)"), DVec3::new(2.0, 2.0, 1.0));
}

#[test]
fn offsets_are_exact_where_the_kind_allows_and_close_elsewhere() {
    let offset = |basis: &str| face(&format!("{basis}#60=OFFSET_SURFACE('',#61,0.5,.F.);")).surface;
    let Surface::Sphere { radius, .. } = offset("#61=SPHERICAL_SURFACE('',#20,2.);") else { panic!("no sphere") };
    assert_eq!(radius, 2.5);
    let cone = offset("#61=CONICAL_SURFACE('',#20,2.,0.25);");
    let base = Surface::Cone { frame: trimtess::model::Frame3::WORLD, radius: 2.0, half_angle: 0.25 };
    let moved = base.point(0.3, 1.0) + base.normal(0.3, 1.0).expect("a normal") * 0.5;
    let back = cone.invert(moved).expect("a cone");
    assert_near(cone.point(back.x, back.y), moved);
    let net = roof().replace("#61=", "#161=")
        + "#61=BEZIER_SURFACE('',2,1,((#161,#62),(#63,#64),(#65,#66)),.UNSPECIFIED.,.F.,.F.,.F.);";
    let bent = offset(&net);
    let basis = face(&net.replace("#61=BEZIER", "#60=BEZIER")).surface;
    for i in 0..=20 {
        let (u, v) = (f64::from(i) / 20.0, f64::from(i * 7 % 21) / 20.0);
        let exact = basis.point(u, v) + basis.normal(u, v).expect("a normal") * 0.5;
        // A hundred-thousandth of the size, which is less than the tolerance.
        assert!(bent.point(u, v).distance(exact) < 1e-4);
    }
}

#[test]
fn an_offset_of_an_offset_closes_like_its_profile() {
    // The tangents of an approximated profile differ at its ends.
    for way in [1.0, -1.0] {
        let [first, then] = [5.08 * way, 2.54 * way];
        let surface = face(&format!(
            "#60=OFFSET_SURFACE('',#61,{then:?},.F.);#61=OFFSET_SURFACE('',#62,{:?},.F.);\
             #62=OFFSET_SURFACE('',#63,{:?},.F.);#63=OFFSET_SURFACE('',#64,{first:?},.F.);\
             #64=SURFACE_OF_LINEAR_EXTRUSION('',#65,#66);#65=ELLIPSE('',#20,86.868720,106.974161);\
             #66=VECTOR('',#22,1.);",
            -then, -first
        ))
        .surface;
        assert!(surface.period()[0].is_some(), "{way}: {surface:?}");
    }
}

#[test]
fn an_offset_has_one_sheet_even_if_its_profile_narrowly_misses_the_axis() {
    // A circle about (4, y, 0), revolved about z. It meets z twice if y is 0; otherwise rounding has moved it off the
    // axis.
    for y in [0.0, 1e-5, -1e-3] {
        let basis = format!(
            "#61=SURFACE_OF_REVOLUTION('',#62,#63);#62=CIRCLE('',#64,5.);#64=AXIS2_PLACEMENT_3D('',#65,#66,#23);\
             #65=CARTESIAN_POINT('',(4.,{y:.9},0.));#66=DIRECTION('',(0.,-1.,0.));#63=AXIS1_PLACEMENT('',#21,#22);"
        );
        let surface = face_in(1, [9.0, 0.0, 0.0], &format!("{basis}#60=OFFSET_SURFACE('',#61,0.5,.F.);")).surface;
        let [(u0, u1), (v0, v1)] = surface.natural_domain();
        for k in 0..=20 {
            let share = f64::from(k) / 20.0;
            let u = u0 + 0.3 * (u1 - u0);
            let p = surface.point(u, v0 + share * (v1 - v0));
            let out = p.x * u.cos() + p.y * u.sin();
            let off = (out - 4.0).hypot(p.z);
            assert!((off - 5.5).abs().min((off - 4.5).abs()) < 1e-2, "{y}: {off} at {p}");
            assert!(out > -0.5, "{y}: the other sheet at {p}");
        }
    }
}

#[test]
fn a_trimmed_surface_reversed_in_one_direction_reverses_the_face() {
    let text = |v: char| format!("#61=PLANE('',#20);#60=RECTANGULAR_TRIMMED_SURFACE('',#61,0.,1.,0.,1.,.T.,.{v}.);");
    assert!(!face(&text('T')).reversed);
    assert!(face(&text('F')).reversed);
}

#[test]
fn whole_surfaces_need_bounds_of_their_own() {
    let set = |surface: &str| {
        let rest = "#70=GEOMETRIC_SET('',(#60));#92=GEOMETRICALLY_BOUNDED_SURFACE_SHAPE_REPRESENTATION('',(#70),#1);";
        model(&(world() + &roof() + surface + rest))
    };
    let net = set(&format!("#60=BEZIER_SURFACE('',2,1,{NET},.UNSPECIFIED.,.F.,.F.,.F.);"));
    clean(&net);
    assert!(only_face(&net).loops.is_empty());
    let swept = "#60=SURFACE_OF_LINEAR_EXTRUSION('',#162,#161);#161=VECTOR('',#22,1.);#162=CIRCLE('',#20,2.);";
    let swept = set(swept);
    assert!(only_face(&swept).lost);
    let lost: Vec<_> = swept.diagnostics.iter().filter(|d| d.severity == Severity::Error).collect();
    assert!(lost.len() == 1 && lost[0].entity == 60, "{lost:?}");
    // An infinite surface is construction geometry: there is no face to lose.
    let plane = set("#60=PLANE('',#20);");
    assert!(
        plane.parts.is_empty()
            && plane
                .diagnostics
                .iter()
                .any(|d| d.kind.code() == "step-supplemental" && d.to_string().contains("1 PLANE"))
    );
}

#[test]
fn loose_surfaces_form_one_shell() {
    let surface = |id: u32| format!("#{id}=BEZIER_SURFACE('',2,1,{NET},.UNSPECIFIED.,.F.,.F.,.F.);");
    let text = world() + &roof() + &surface(160) + &surface(161) + &surface(162) + &surface(163);
    let rest = "#170=GEOMETRIC_SET('',(#160));#171=GEOMETRIC_SET('',(#161,#162));\
                #92=GEOMETRICALLY_BOUNDED_SURFACE_SHAPE_REPRESENTATION('',(#170,#171,#163),#1);";
    let model = model(&(text + rest));
    clean(&model);
    let part = only_part(&model);
    assert_eq!(part.faces.iter().map(|face| face.shell).collect::<Vec<_>>(), [0; 4]);
    assert_eq!((part.shells.len(), part.shells[0].entity), (1, 170));
}

#[test]
fn open_shells_of_one_face_form_one_shell() {
    let face = |id: u32| {
        format!(
            "#{id}=BEZIER_SURFACE('',2,1,{NET},.UNSPECIFIED.,.F.,.F.,.F.);#{}=ADVANCED_FACE('',(),#{id},.T.);",
            id + 10
        )
    };
    let faces: String = (160..164).map(face).collect();
    let rest = "#180=OPEN_SHELL('',(#170));#181=OPEN_SHELL('',(#171,#172));#182=OPEN_SHELL('',(#173));\
                #183=SHELL_BASED_SURFACE_MODEL('',(#180,#181,#182));\
                #92=MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',(#183),#1);";
    let model = model(&(world() + &roof() + &faces + rest));
    clean(&model);
    let part = only_part(&model);
    assert_eq!(part.faces.iter().map(|face| face.shell).collect::<Vec<_>>(), [0, 1, 1, 0]);
    assert_eq!(part.shells.iter().map(|shell| shell.entity).collect::<Vec<_>>(), [180, 181]);
}

#[test]
fn a_row_of_points_rounded_apart_is_a_pole() {
    let poles = |apart: f64| {
        let points = vec![DVec3::ZERO, DVec3::Y, DVec3::X * apart, DVec3::new(1.0, 1.0, 0.0)];
        Surface::Nurbs(NurbsSurface::bezier((1, 1), points, Vec::new())).poles().len()
    };
    assert_eq!([0.0, 1e-6, 1e-3].map(poles), [1, 1, 0]);
}

#[test]
fn a_seam_rounded_apart_closes_unless_the_file_calls_the_surface_open() {
    for (flag, closes) in [("T", true), ("U", true), ("F", false)] {
        let rows = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [3e-5, 0.0]];
        let ends = rows.iter().flat_map(|[x, y]| [0.0, 2.0].map(|z| [*x, *y, z]));
        let points: String = ends.zip(40..).map(|(p, id)| point(id, p)).collect();
        let tube = format!(
            "#60=B_SPLINE_SURFACE_WITH_KNOTS('',1,1,((#40,#41),(#42,#43),(#44,#45),(#46,#47),(#48,#49)),.UNSPECIFIED.,\
             .{flag}.,.F.,.U.,(2,1,1,1,2),(2,2),(0.,1.,2.,3.,4.),(0.,1.),.UNSPECIFIED.);"
        );
        let model = model(&(world() + &points + &tube + &shell("ADVANCED_FACE('',(),#60,.T.)", 1)));
        assert_eq!(only_face(&model).surface.period()[0].is_some(), closes, "{flag}");
    }
}

/// A strip of a torus that touches itself, between two circles of two arcs each through the point of contact. Points
/// are displaced by 2e-6, so that the circles change places near that point.
const STRIP: &str = "
#101=CARTESIAN_POINT('',(-2.14672683900023,-7.96006487595572,-9.74167524950238));#105=VERTEX_POINT('',#101);
#102=CARTESIAN_POINT('',(-1.88939145861165,-6.84296548044077,-9.01354716611325));#106=VERTEX_POINT('',#102);
#103=CARTESIAN_POINT('',(-1.96487243996037,-7.97518538497543,-9.75965908231963));#107=VERTEX_POINT('',#103);
#104=CARTESIAN_POINT('',(-1.88939164254262,-6.84296530726313,-9.01354772646896));#108=VERTEX_POINT('',#104);
#110=CARTESIAN_POINT('',(-2.09750958488669,-6.99024862393333,-9.98049764874158));
#111=DIRECTION('',(0.975900072948533,-0.0975900072948533,-0.195180014589707));
#112=DIRECTION('',(-0.0492169663402102,-0.969815132711543,0.23882273465472));
#113=AXIS2_PLACEMENT_3D('',#110,#111,#112);#130=CIRCLE('',#113,1.);
#114=CARTESIAN_POINT('',(-2.09750938434321,-6.99024848047921,-9.98049810142913));
#116=DIRECTION('',(0.208118578122772,0.147283916825347,0.966950932201185));
#117=AXIS2_PLACEMENT_3D('',#114,#111,#116);#131=CIRCLE('',#117,1.);
#118=CARTESIAN_POINT('',(-1.9003035355638,-7.00664702289174,-9.9999993445149));
#119=DIRECTION('',(0.997785157856609,-0.0665190105237725,0.));
#120=DIRECTION('',(-0.0645692409139518,-0.968538613709295,0.24034093883871));
#121=AXIS2_PLACEMENT_3D('',#118,#119,#120);#132=CIRCLE('',#121,1.);
#122=CARTESIAN_POINT('',(-1.9003033010939,-7.0066463708382,-10.0000001478468));
#124=DIRECTION('',(0.0109120897108884,0.163681345663343,0.986452909864419));
#125=AXIS2_PLACEMENT_3D('',#122,#119,#124);#133=CIRCLE('',#125,1.);
#140=EDGE_CURVE('',#105,#106,#130,.T.);#141=EDGE_CURVE('',#106,#105,#131,.T.);
#142=EDGE_CURVE('',#107,#108,#132,.T.);#143=EDGE_CURVE('',#108,#107,#133,.T.);
#144=ORIENTED_EDGE('',*,*,#141,.T.);#145=ORIENTED_EDGE('',*,*,#140,.T.);
#146=ORIENTED_EDGE('',*,*,#142,.F.);#147=ORIENTED_EDGE('',*,*,#143,.F.);
#148=EDGE_LOOP('',(#144,#145,#146,#147));#149=FACE_BOUND('',#148,.T.);
#150=CARTESIAN_POINT('',(-1.88939190719629,-6.84296500548913,-9.0135469823121));
#151=DIRECTION('',(-0.0656178714924774,-0.98426807238718,0.164044678731197));
#152=DIRECTION('',(-0.208118578122769,-0.147283916825346,-0.966950932201185));
#153=AXIS2_PLACEMENT_3D('',#150,#151,#152);#154=DEGENERATE_TOROIDAL_SURFACE('',#153,0.999999999999996,1.,.T.);
";

#[test]
fn edges_that_change_places_at_a_touching_point_do_not_go_around() {
    let model = model(&(STRIP.to_owned() + &shell("ADVANCED_FACE('',(#149),#154,.T.)", 1)));
    clean(&model);
    let prepared = prepared(model);
    let is_filled = |d: &&Diagnostic| matches!(d.kind, DiagnosticKind::Face(FaceTrouble::Filled { .. }));
    let filled: Vec<_> = prepared.diagnostics.iter().filter(is_filled).collect();
    assert!(filled.is_empty(), "{filled:?}");
}
