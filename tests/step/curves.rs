//! Edges on every kind of curve: from vertex to vertex, in the stated sense, exactly.

use crate::{
    assert_near, bounded_face, clean, edge_of, is, model, only_face, only_part, placement, point, vertex, world,
};
use glam::DVec3;
use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};
use trimtess::model::{CurveKind, CurveTrouble, Edge, Part, StepTrouble};

/// Reads edge #50 from `start` to `end` on curve #60, closed by a straight edge #51 in a plane.
fn edge(start: [f64; 3], end: [f64; 3], same_sense: bool, curve: &str) -> (Part, Edge) {
    let sense = if same_sense { 'T' } else { 'F' };
    let (edges, vertices) = if start == end {
        (&[50][..], format!("{}#50=EDGE_CURVE('',#30,#30,#60,.{sense}.);", vertex(30, start)))
    } else {
        let back = "#51=EDGE_CURVE('',#32,#30,#55,.T.);#55=LINE('',#31,#56);#56=VECTOR('',#57,1.);\
                    #57=DIRECTION('',(1.,0.,0.));";
        let forth = format!("#50=EDGE_CURVE('',#30,#32,#60,.{sense}.);");
        (&[50, 51][..], vertex(30, start) + &vertex(32, end) + &forth + back)
    };
    let model = model(&(world() + &vertices + curve + "#77=PLANE('',#20);" + &bounded_face(edges, 77, 2)));
    clean(&model);
    let part = only_part(&model).clone();
    let edge = edge_of(&part, 50).clone();
    assert!(edge.range.0 < edge.range.1);
    // A short edge far from the origin is a part far from it.
    let placed = |t: f64| model.instances[0].transform.transform_point3(edge.curve.point(t));
    assert_near(placed(edge.range.0), DVec3::from(start));
    assert!(placed(edge.range.1).distance(DVec3::from(end)) < 1e-8);
    assert_eq!(edge.start == edge.end, start == end);
    (part, edge)
}

/// The point at a fraction of the edge's range.
fn at(edge: &Edge, fraction: f64) -> DVec3 {
    edge.curve.point(edge.range.0 + (edge.range.1 - edge.range.0) * fraction)
}

const CIRCLE: &str = "#60=CIRCLE('',#20,2.);";

#[test]
fn a_line_is_two_points() {
    let line = "#60=LINE('',#31,#61);#61=VECTOR('',#62,5.);#62=DIRECTION('',(0.,1.,0.));";
    let (_, edge) = edge([0.0, 0.0, 0.0], [0.0, 3.0, 0.0], true, line);
    assert_eq!((edge.kind, edge.curve.degree, edge.curve.points.len()), (CurveKind::Line, 1, 2));
}

#[test]
fn the_sense_of_a_circle_tells_the_short_arc_from_the_long_one() {
    let (_, short) = edge([2.0, 0.0, 0.0], [0.0, 2.0, 0.0], true, CIRCLE);
    assert_near(at(&short, 0.5), DVec3::new(2.0, 2.0, 0.0) * FRAC_1_SQRT_2);
    assert_eq!((short.kind, short.curve.points.len()), (CurveKind::Circle, 3));
    let (_, long) = edge([2.0, 0.0, 0.0], [0.0, 2.0, 0.0], false, CIRCLE);
    assert_near(at(&long, 0.5), DVec3::new(-2.0, -2.0, 0.0) * FRAC_1_SQRT_2);
    assert_eq!(long.curve.points.len(), 7);
}

#[test]
fn a_closed_circle_starts_at_its_vertex() {
    for same_sense in [true, false] {
        let (_, edge) = edge([0.0, 2.0, 0.0], [0.0, 2.0, 0.0], same_sense, CIRCLE);
        assert!((edge.range.1 - edge.range.0 - TAU).abs() < 1e-12);
        let side = if same_sense { -2.0 } else { 2.0 };
        assert_near(at(&edge, 0.25), DVec3::new(side, 0.0, 0.0));
        assert_near(at(&edge, 0.5), DVec3::new(0.0, -2.0, 0.0));
    }
}

#[test]
fn two_vertices_in_one_place_close_a_circle_but_a_short_arc_stays_short() {
    let (_, short) = edge([2.0, 0.0, 0.0], [2.0 * 1e-4f64.cos(), 2.0 * 1e-4f64.sin(), 0.0], true, CIRCLE);
    assert!((short.range.1 - short.range.0 - 1e-4).abs() < 1e-9);
    let (_, whole) = edge([2.0, 0.0, 0.0], [2.0 * 1e-9f64.cos(), 2e-9, 0.0], true, CIRCLE);
    assert!((whole.range.1 - whole.range.0 - TAU).abs() < 1e-12);
}

#[test]
fn a_circle_alone_in_its_loop_closes_where_corners_join() {
    // The ends are nine tolerances apart: along the circle, and across it. On the larger one they are 50 apart.
    for (radius, end) in [
        (2.0, [2.0 * 4.5e-5f64.cos(), 2.0 * 4.5e-5f64.sin(), 0.0]),
        (2.0, [2.0 + 9e-5, 0.0, 0.0]),
        (100.0, [100.0, 5e-4, 0.0]),
        (100.0, [100.0, -5e-4, 0.0]),
        (100.0, [100.0 + 5e-4, 0.0, 0.0]),
    ] {
        for curve in [
            format!("#60=CIRCLE('',#20,{radius:?});"),
            "#60=POLYLINE('',(#61,#62,#63,#61));".to_owned()
                + &point(61, [radius, 0.0, 0.0])
                + &point(62, [0.0, radius, 0.0])
                + &point(63, [-radius, -radius, 0.0]),
        ] {
            let text = world()
                + &vertex(30, [radius, 0.0, 0.0])
                + &vertex(32, end)
                + &curve
                + "#50=EDGE_CURVE('',#30,#32,#60,.T.);#77=PLANE('',#20);"
                + &bounded_face(&[50], 77, 1);
            let model = model(&text);
            let edge = edge_of(only_part(&model), 50);
            let middle = at(edge, 0.5);
            assert!(middle.x < 0.0 && edge.start == edge.end && !only_face(&model).lost, "{end:?}: {edge:?}");
            // The second vertex is moved by less than ten tolerances, or that is told.
            let told = model.diagnostics.iter().filter(|told| told.kind.code() == "step-vertex-moved").count();
            assert_eq!(told, usize::from(radius > 2.0), "{end:?}: {:?}", model.diagnostics);
        }
    }
}

#[test]
fn conics_are_exact() {
    let (_, ellipse) = edge([3.0, 0.0, 0.0], [0.0, 1.0, 0.0], true, "#60=ELLIPSE('',#20,3.,1.);");
    assert_near(at(&ellipse, 0.5), DVec3::new(3.0, 1.0, 0.0) * FRAC_1_SQRT_2);
    assert_eq!(ellipse.kind, CurveKind::Conic);
    let ends = |t: f64| [3.0 * t.cosh(), 2.0 * t.sinh(), 0.0];
    // On an open curve the sense has no effect.
    for same_sense in [true, false] {
        let (_, hyperbola) = edge(ends(-0.7), ends(1.9), same_sense, "#60=HYPERBOLA('',#20,3.,2.);");
        for i in 0..=10 {
            let p = at(&hyperbola, f64::from(i) / 10.0);
            assert!(((p.x / 3.0).powi(2) - (p.y / 2.0).powi(2) - 1.0).abs() < 1e-10, "{p}");
        }
        let (_, parabola) = edge([1.0, -2.0, 0.0], [4.0, 4.0, 0.0], same_sense, "#60=PARABOLA('',#20,1.);");
        assert_near(at(&parabola, 0.5), DVec3::new(0.25, 1.0, 0.0));
    }
}

/// Control points #61.. of an arch.
fn arch() -> String {
    [[0.0, 0.0, 0.0], [1.0, 2.0, 0.0], [3.0, 2.0, 0.0], [4.0, 0.0, 0.0]]
        .into_iter()
        .zip(61..)
        .map(|(p, id)| point(id, p))
        .collect()
}

#[test]
fn a_b_spline_is_kept_and_reversed_where_the_sense_says_so() {
    let spline = arch()
        + "#60=B_SPLINE_CURVE_WITH_KNOTS('',3,(#61,#62,#63,#64),.UNSPECIFIED.,.F.,.F.,(4,4),(0.,2.),.UNSPECIFIED.);";
    let (_, forth) = edge([0.0; 3], [4.0, 0.0, 0.0], true, &spline);
    assert_eq!((forth.kind, forth.range), (CurveKind::Spline, (0.0, 2.0)));
    assert_eq!(forth.curve.knots, [0.0, 0.0, 0.0, 0.0, 2.0, 2.0, 2.0, 2.0]);
    let (_, back) = edge([4.0, 0.0, 0.0], [0.0; 3], false, &spline);
    assert_near(back.curve.points[0], DVec3::new(4.0, 0.0, 0.0));
    // A flag that contradicts the vertices is ignored.
    let (_, wrong) = edge([4.0, 0.0, 0.0], [0.0; 3], true, &spline);
    assert_near(at(&wrong, 0.25), at(&back, 0.25));
}

#[test]
fn an_edge_may_use_a_part_of_its_curve() {
    let spline = arch() + "#60=BEZIER_CURVE('',3,(#61,#62,#63,#64),.UNSPECIFIED.,.F.,.F.);";
    let (_, whole) = edge([0.0; 3], [4.0, 0.0, 0.0], true, &spline);
    let (start, end) = (at(&whole, 0.25), at(&whole, 0.75));
    let (_, part) = edge(start.into(), end.into(), true, &spline);
    assert!((part.range.0 - 0.25).abs() < 1e-9 && (part.range.1 - 0.75).abs() < 1e-9, "{:?}", part.range);
    assert_near(at(&part, 0.5), at(&whole, 0.5));
}

#[test]
fn forms_imply_their_knots() {
    let quasi = arch() + "#60=QUASI_UNIFORM_CURVE('',2,(#61,#62,#63,#64),.UNSPECIFIED.,.F.,.F.);";
    let (_, edge_quasi) = edge([0.0; 3], [4.0, 0.0, 0.0], true, &quasi);
    assert_eq!(edge_quasi.curve.knots, [0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0]);
    let uniform = arch() + "#60=UNIFORM_CURVE('',1,(#61,#62,#63,#64),.UNSPECIFIED.,.F.,.F.);";
    let (_, edge_uniform) = edge([0.0; 3], [4.0, 0.0, 0.0], true, &uniform);
    assert_eq!(edge_uniform.curve.knots, [-1.0, 0.0, 1.0, 2.0, 3.0, 4.0]);
}

const QUARTER: &str = "#60=(BOUNDED_CURVE()B_SPLINE_CURVE(2,(#61,#62,#63),.CIRCULAR_ARC.,.F.,.F.)\
    B_SPLINE_CURVE_WITH_KNOTS((3,3),(0.,1.),.UNSPECIFIED.)CURVE()GEOMETRIC_REPRESENTATION_ITEM()\
    RATIONAL_B_SPLINE_CURVE((1.,0.7071067811865476,1.))REPRESENTATION_ITEM(''));";

#[test]
fn a_rational_b_spline_is_complex() {
    let points = point(61, [2.0, 0.0, 0.0]) + &point(62, [2.0, 2.0, 0.0]) + &point(63, [0.0, 2.0, 0.0]);
    let (_, edge) = edge([2.0, 0.0, 0.0], [0.0, 2.0, 0.0], true, &(points + QUARTER));
    assert_near(at(&edge, 0.5), DVec3::new(2.0, 2.0, 0.0) * FRAC_1_SQRT_2);
    assert_eq!(edge.curve.weights.len(), 3);
}

/// Curve `id`: four quadratic arches over the sides of a square, closed at (0,0). A corner every 1 from 0 to 4.
fn arches(id: u32) -> String {
    let corners =
        [[0.0, 0.0], [2.0, -1.0], [4.0, 0.0], [5.0, 2.0], [4.0, 4.0], [2.0, 5.0], [0.0, 4.0], [-1.0, 2.0], [0.0, 0.0]];
    let points: String = corners.iter().zip(61..).map(|(p, id)| point(id, [p[0], p[1], 0.0])).collect();
    let list = (61..70).map(|id| format!("#{id}")).collect::<Vec<_>>().join(",");
    format!(
        "{points}#{id}=B_SPLINE_CURVE_WITH_KNOTS('',2,({list}),.UNSPECIFIED.,.T.,.F.,(3,2,2,2,3),(0.,1.,2.,3.,4.),\
         .UNSPECIFIED.);"
    )
}

#[test]
fn a_closed_spline_is_passed_through_its_seam() {
    let spline = arches(60);
    let (_, across) = edge([0.0, 4.0, 0.0], [4.0, 0.0, 0.0], true, &spline);
    assert!((across.range.1 - across.range.0 - 2.0).abs() < 1e-9);
    assert_near(at(&across, 0.5), DVec3::ZERO);
    let (_, whole) = edge([4.0, 4.0, 0.0], [4.0, 4.0, 0.0], true, &spline);
    assert_near(at(&whole, 0.5), DVec3::ZERO);
    assert_near(at(&whole, 0.25), DVec3::new(0.0, 4.0, 0.0));
    let (_, against) = edge([4.0, 4.0, 0.0], [4.0, 4.0, 0.0], false, &spline);
    assert_near(at(&against, 0.25), DVec3::new(4.0, 0.0, 0.0));
}

#[test]
fn a_spline_is_closed_up_to_rounding() {
    // Nearer than a hundred thousandth of its size, and farther than the file's 1e-5.
    for gap in [2e-5, 4e-5] {
        let spline = arches(60).replace(&point(69, [0.0; 3]), &point(69, [gap, 0.0, 0.0]));
        let (_, across) = edge([0.0, 4.0, 0.0], [4.0, 0.0, 0.0], true, &spline);
        assert!(at(&across, 0.5).length() <= gap);
    }
}

#[test]
fn a_closed_spline_is_trimmed_up_to_its_seam_and_from_it() {
    let (seam, far) = ([0.0; 3], [4.0, 4.0, 0.0]);
    for (start, end, trims, middle) in [
        (far, seam, "(#65),(#61),.T.,.CARTESIAN.", [0.0, 4.0]),
        (far, seam, "(PARAMETER_VALUE(2.)),(PARAMETER_VALUE(4.)),.T.,.PARAMETER.", [0.0, 4.0]),
        (far, seam, "(PARAMETER_VALUE(2.)),(PARAMETER_VALUE(0.)),.T.,.PARAMETER.", [0.0, 4.0]),
        (seam, far, "(#61),(#65),.T.,.CARTESIAN.", [4.0, 0.0]),
        (seam, far, "(PARAMETER_VALUE(4.)),(PARAMETER_VALUE(2.)),.T.,.PARAMETER.", [4.0, 0.0]),
        (seam, far, "(#61),(#65),.F.,.CARTESIAN.", [0.0, 4.0]),
    ] {
        // The ends of a composite curve are stated by nothing else.
        let text = arches(80)
            + &format!("#81=TRIMMED_CURVE('',#80,{trims});")
            + "#82=COMPOSITE_CURVE_SEGMENT(.DISCONTINUOUS.,.T.,#81);#60=COMPOSITE_CURVE('',(#82),.F.);";
        let (_, half) = edge(start, end, true, &text);
        assert_near(at(&half, 0.5), DVec3::new(middle[0], middle[1], 0.0));
    }
}

#[test]
fn wrapped_curves_are_unwrapped() {
    let trimmed =
        "#61=CIRCLE('',#20,2.);#60=TRIMMED_CURVE('',#61,(PARAMETER_VALUE(0.)),(PARAMETER_VALUE(90.)),.F.,.PARAMETER.);";
    // The trimmed curve is opposite to the circle, and the edge to the trimmed curve.
    let (_, arc) = edge([2.0, 0.0, 0.0], [0.0, 2.0, 0.0], false, trimmed);
    assert_near(at(&arc, 0.5), DVec3::new(2.0, 2.0, 0.0) * FRAC_1_SQRT_2);
    let surface_curve = "#61=CIRCLE('',#20,2.);#60=SURFACE_CURVE('',#61,(#77),.CURVE_3D.);";
    let (_, arc) = edge([2.0, 0.0, 0.0], [0.0, 2.0, 0.0], true, surface_curve);
    assert_eq!(arc.kind, CurveKind::Circle);
    let complex = "#61=CIRCLE('',#20,2.);#60=(BOUNDED_CURVE()CURVE()GEOMETRIC_REPRESENTATION_ITEM()\
                   REPRESENTATION_ITEM('')\
        SURFACE_CURVE(#61,(#77),.CURVE_3D.));";
    let (_, arc) = edge([2.0, 0.0, 0.0], [0.0, 2.0, 0.0], true, complex);
    assert_eq!(arc.kind, CurveKind::Circle);
}

#[test]
fn a_composite_curve_joins_its_segments() {
    // From (4,0) straight to (2,0), then a quarter circle given in degrees; the line is stated in reverse.
    let curve = point(64, [2.0, 0.0, 0.0])
        + "#65=LINE('',#64,#66);#66=VECTOR('',#67,1.);#67=DIRECTION('',(1.,0.,0.));\
           #68=TRIMMED_CURVE('',#65,(PARAMETER_VALUE(0.)),(PARAMETER_VALUE(2.)),.T.,.PARAMETER.);\
           #69=CIRCLE('',#20,2.);#80=TRIMMED_CURVE('',#69,(PARAMETER_VALUE(0.)),(PARAMETER_VALUE(90.)),.T.,\
           .PARAMETER.);\
           #81=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.F.,#68);#82=COMPOSITE_CURVE_SEGMENT(.DISCONTINUOUS.,.T.,#80);\
           #60=COMPOSITE_CURVE('',(#81,#82),.F.);";
    let (_, edge) = edge([4.0, 0.0, 0.0], [0.0, 2.0, 0.0], true, &curve);
    assert_eq!(edge.curve.degree, 2);
    let (a, joint) = (edge.range.0, edge.curve.knots[3]);
    assert_near(edge.curve.point(joint), DVec3::new(2.0, 0.0, 0.0));
    assert_near(edge.curve.point(0.5 * (a + joint)), DVec3::new(3.0, 0.0, 0.0));
    assert_near(edge.curve.point(0.5 * (joint + edge.range.1)), DVec3::new(2.0, 2.0, 0.0) * FRAC_1_SQRT_2);
}

#[test]
fn a_composite_curve_is_trimmed_by_points_only() {
    // A line of length 2, then a quarter circle in degrees, from the middle of one to that of the other.
    let composite = point(64, [4.0, 0.0, 0.0])
        + "#65=LINE('',#64,#66);#66=VECTOR('',#67,1.);#67=DIRECTION('',(-1.,0.,0.));\
           #68=TRIMMED_CURVE('',#65,(PARAMETER_VALUE(0.)),(PARAMETER_VALUE(2.)),.T.,.PARAMETER.);\
           #69=CIRCLE('',#20,2.);#80=TRIMMED_CURVE('',#69,(PARAMETER_VALUE(0.)),(PARAMETER_VALUE(90.)),.T.,\
           .PARAMETER.);\
           #81=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#68);#82=COMPOSITE_CURVE_SEGMENT(.DISCONTINUOUS.,.T.,#80);\
           #83=COMPOSITE_CURVE('',(#81,#82),.F.);#84=COMPOSITE_CURVE_SEGMENT(.DISCONTINUOUS.,.T.,#85);\
           #60=COMPOSITE_CURVE('',(#84),.F.);"
        + &point(86, [3.0, 0.0, 0.0])
        + &point(87, [2.0 * FRAC_1_SQRT_2, 2.0 * FRAC_1_SQRT_2, 0.0]);
    let (start, end) = ([3.0, 0.0, 0.0], [2.0 * FRAC_1_SQRT_2, 2.0 * FRAC_1_SQRT_2, 0.0]);
    let trims = "(PARAMETER_VALUE(1.),#86),(PARAMETER_VALUE(47.),#87),.T.,.PARAMETER.";
    let (_, half) = edge(start, end, true, &format!("{composite}#85=TRIMMED_CURVE('',#83,{trims});"));
    assert!(half.curve.points.iter().all(|p| p.x < 3.0 + 1e-9 && p.y < 2.0 * FRAC_1_SQRT_2 + 1e-9), "{half:?}");
    let trims = "(PARAMETER_VALUE(1.)),(PARAMETER_VALUE(47.)),.T.,.PARAMETER.";
    let back = "#50=EDGE_CURVE('',#30,#32,#60,.T.);#51=EDGE_CURVE('',#32,#30,#65,.T.);#77=PLANE('',#20);";
    let text = world() + &vertex(30, start) + &vertex(32, end) + &composite + back;
    let text = text + &format!("#85=TRIMMED_CURVE('',#83,{trims});") + &bounded_face(&[50, 51], 77, 2);
    let told = model(&text).diagnostics;
    let refused = |t: &StepTrouble| matches!(t, StepTrouble::Curve(CurveTrouble::OnComposite));
    assert!(told.iter().any(|d| d.entity == 50 && is(d, refused)), "{told:?}");
}

#[test]
fn a_trim_of_a_curve_against_its_circle_runs_along_that_curve() {
    // A quarter of a circle from the top to the right, its second half, and a line on from there.
    let composite = point(64, [2.0, 0.0, 0.0])
        + &point(86, [2.0 * FRAC_1_SQRT_2, 2.0 * FRAC_1_SQRT_2, 0.0])
        + "#65=LINE('',#64,#66);#66=VECTOR('',#67,1.);#67=DIRECTION('',(1.,0.,0.));\
           #68=TRIMMED_CURVE('',#65,(PARAMETER_VALUE(0.)),(PARAMETER_VALUE(2.)),.T.,.PARAMETER.);\
           #69=CIRCLE('',#20,2.);#80=TRIMMED_CURVE('',#69,(PARAMETER_VALUE(90.)),(PARAMETER_VALUE(0.)),.F.,\
           .PARAMETER.);#81=TRIMMED_CURVE('',#80,(#86),(#64),.T.,.CARTESIAN.);\
           #82=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#81);#83=COMPOSITE_CURVE_SEGMENT(.DISCONTINUOUS.,.T.,#68);\
           #60=COMPOSITE_CURVE('',(#82,#83),.F.);";
    let (start, end) = ([2.0 * FRAC_1_SQRT_2, 2.0 * FRAC_1_SQRT_2, 0.0], [4.0, 0.0, 0.0]);
    let (_, edge) = edge(start, end, true, &composite);
    let (a, b) = edge.range;
    for k in 0..=100 {
        let p = edge.curve.point(a + (b - a) * f64::from(k) / 100.0);
        assert!((p.length() - 2.0).abs() < 1e-9 || p.y.abs() < 1e-9 && p.x > 2.0, "{p}");
    }
    assert_near(edge.curve.point(a), DVec3::from(start));
}

#[test]
fn a_polyline_keeps_its_kind() {
    let line = arch() + "#60=POLYLINE('',(#61,#62,#63,#64));";
    let (_, edge) = edge([0.0; 3], [4.0, 0.0, 0.0], true, &line);
    assert_eq!((edge.kind, edge.curve.degree), (CurveKind::Polyline, 1));
    assert_near(edge.curve.point(1.0), DVec3::new(1.0, 2.0, 0.0));
}

#[test]
fn a_polyline_that_repeats_points_is_trimmed_by_points_only() {
    let told = |trims: &str| {
        let text = arch()
            + &format!("#65=POLYLINE('',(#61,#62,#62,#63,#64));#66=TRIMMED_CURVE('',#65,{trims});")
            + "#67=COMPOSITE_CURVE_SEGMENT(.DISCONTINUOUS.,.T.,#66);#60=COMPOSITE_CURVE('',(#67),.F.);\
               #50=EDGE_CURVE('',#30,#32,#60,.T.);#51=EDGE_CURVE('',#32,#30,#65,.T.);#77=PLANE('',#20);";
        let text = world() + &vertex(30, [1.0, 2.0, 0.0]) + &vertex(32, [3.0, 2.0, 0.0]) + &text;
        model(&(text + &bounded_face(&[50, 51], 77, 2))).diagnostics
    };
    let refused = |t: &StepTrouble| matches!(t, StepTrouble::Curve(CurveTrouble::OnComposite));
    let by_parameters = told("(PARAMETER_VALUE(1.)),(PARAMETER_VALUE(3.)),.T.,.PARAMETER.");
    assert!(by_parameters.iter().any(|d| d.entity == 50 && is(d, refused)), "{by_parameters:?}");
    let by_points = told("(#62),(#63),.T.,.CARTESIAN.");
    assert!(!by_points.iter().any(|d| d.entity == 50), "{by_points:?}");
}

#[test]
fn superfluous_knots_are_removed() {
    // The inner knot has multiplicity degree + 1, and its two control points are equal.
    let points = point(61, [0.0, 0.0, 0.0]) + &point(62, [1.0, 1.0, 0.0]) + &point(63, [4.0, 0.0, 0.0]);
    let curve = points
        + "#60=B_SPLINE_CURVE_WITH_KNOTS('',1,(#61,#62,#62,#63),.UNSPECIFIED.,.F.,.F.,(2,2,2),(0.,1.,2.),\
           .UNSPECIFIED.);";
    let (_, edge) = edge([0.0; 3], [4.0, 0.0, 0.0], true, &curve);
    assert_eq!(edge.curve.knots, [0.0, 0.0, 1.0, 2.0, 2.0]);
    assert_eq!(edge.curve.points.len(), 3);
}

#[test]
fn trims_by_point_and_placed_circles() {
    // A circle about (1,0,0) whose angle 0 points along -x, trimmed by points.
    let curve = placement(61, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0])
        + &point(65, [0.0, 0.0, 0.0])
        + &point(66, [1.0, -1.0, 0.0])
        + "#67=CIRCLE('',#61,1.);#68=TRIMMED_CURVE('',#67,(#65),(#66),.T.,.CARTESIAN.);\
           #69=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#68);#60=COMPOSITE_CURVE('',(#69),.F.);";
    let (_, edge) = edge([0.0, 0.0, 0.0], [1.0, -1.0, 0.0], true, &curve);
    assert_near(at(&edge, 0.5), DVec3::new(1.0 - (PI / 4.0).cos(), -(PI / 4.0).sin(), 0.0));
}

#[test]
fn a_short_arc_of_a_large_circle_is_no_whole_turn() {
    for (radius, length) in [(1e5, 0.005), (1e4, 5e-4), (1e3, 5e-5)] {
        let curve = placement(63, [0.0, -radius, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]);
        for curve in [
            curve.clone() + &format!("#60=CIRCLE('',#63,{radius:.1});"),
            curve + &format!("#60=ELLIPSE('',#63,{radius:.1},{radius:.1});"),
        ] {
            let (_, edge) = edge([length, 0.0, 0.0], [0.0, 0.0, 0.0], true, &curve);
            assert!(at(&edge, 0.5).distance(DVec3::X * 0.5 * length) < 1e-7 * length.max(1.0), "{radius}: {edge:?}");
        }
    }
}

#[test]
fn different_vertices_in_one_place_make_a_turn_where_the_loop_says_so() {
    let arc = |end: [f64; 3], edges: &[i32]| {
        let text = world()
            + &vertex(30, [2.0, 0.0, 0.0])
            + &vertex(32, end)
            + &vertex(34, [0.0, 0.0, 0.0])
            + &vertex(36, [0.0, 2.0, 0.0])
            + CIRCLE
            + "#61=LINE('',#21,#62);#62=VECTOR('',#63,1.);#63=DIRECTION('',(1.,0.,0.));\
               #50=EDGE_CURVE('',#30,#32,#60,.T.);\
               #51=EDGE_CURVE('',#32,#36,#61,.T.);#52=EDGE_CURVE('',#36,#34,#61,.T.);\
               #53=EDGE_CURVE('',#34,#30,#61,.T.);#77=PLANE('',#20);";
        let model = model(&(text + &bounded_face(edges, 77, 1)));
        clean(&model);
        only_part(&model).clone()
    };
    for end in [[2.0, 0.0, 0.0], [2.0, 1e-6, 0.0]] {
        let alone = arc(end, &[50]);
        assert_near(at(edge_of(&alone, 50), 0.5), DVec3::X * -2.0);
    }
    // Among other edges it is an edge without length.
    let triangle = arc([2.0, 0.0, 0.0], &[50, 51, 52, 53]);
    assert_eq!((triangle.edges.len(), triangle.vertices.len()), (3, 3));
}
