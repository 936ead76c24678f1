//! What the builder refuses in free trims.

use glam::{DVec2, DVec3};
use trimtess::model::{
    Frame3, FreeTrims, Loop, Model, NurbsCurve2, PartBuilder, PartError, ShellKind, SplineError, Surface, TrimCurve,
    TrimError, TrimPiece, TrimRule, VertexId,
};

fn fault(curve: TrimCurve) -> (TrimError, String) {
    let mut part = PartBuilder::new("part");
    let shell = part.plain_shell(ShellKind::Open);
    let torus = Surface::Torus { frame: Frame3::WORLD, major: 3.0, minor: 1.0 };
    let sound = TrimCurve::circle(DVec2::splat(1.0), 0.5);
    part.trimmed_face(torus, shell, FreeTrims { rule: TrimRule::EvenOdd, curves: vec![sound, curve] }, false);
    match part.finish().unwrap_err() {
        e @ PartError::Trim { curve: 1, error, .. } => (error, e.to_string()),
        e => panic!("{e}"),
    }
}

fn circle() -> NurbsCurve2 {
    match TrimCurve::circle(DVec2::splat(1.0), 0.5).pieces.remove(0) {
        TrimPiece::Nurbs(curve) => curve,
        TrimPiece::Polyline(_) => panic!("a circle is NURBS"),
    }
}

#[test]
fn faulty_curves_are_refused_with_numbers() {
    let spline = |change: fn(&mut NurbsCurve2)| {
        let mut curve = circle();
        change(&mut curve);
        match fault(TrimCurve::nurbs(curve)) {
            (TrimError::Spline { piece: 0, error }, _) => error,
            (e, _) => panic!("{e}"),
        }
    };
    assert_eq!(spline(|c| c.points[3].x = f64::NAN), SplineError::Point { index: 3 });
    assert_eq!(spline(|c| c.points[2].y = f64::INFINITY), SplineError::Point { index: 2 });
    assert_eq!(spline(|c| c.weights[1] = 0.0), SplineError::Weight { index: 1, weight: 0.0 });
    assert_eq!(spline(|c| c.weights[1] = -1.0), SplineError::Weight { index: 1, weight: -1.0 });
    assert!(matches!(spline(|c| c.weights[4] = f64::NAN), SplineError::Weight { index: 4, .. }));
    assert_eq!(spline(|c| c.knots[3] = 1.5), SplineError::Decreasing { index: 4, before: 1.5, knot: 1.0 });
    let (error, text) = fault(TrimCurve::polyline(vec![DVec2::ONE]));
    assert_eq!(error, TrimError::TooFewPoints { piece: 0, points: 1 });
    assert_eq!(text, "free trimming curve 1 of face 0: piece 0: a polyline of 1 points; at least 2 are needed");
    let (error, _) = fault(TrimCurve::polyline(vec![DVec2::ONE, DVec2::NAN]));
    assert_eq!(error, TrimError::Spline { piece: 0, error: SplineError::Point { index: 1 } });
    assert_eq!(fault(TrimCurve { pieces: Vec::new() }).0, TrimError::NoPieces);
    let gap = TrimCurve {
        pieces: vec![
            TrimPiece::Polyline(vec![DVec2::ZERO, DVec2::X]),
            TrimPiece::Polyline(vec![DVec2::new(1.0, 0.001), DVec2::ONE]),
        ],
    };
    let (error, text) = fault(gap);
    assert!(matches!(error, TrimError::Gap { piece: 1, .. }), "{error}");
    assert!(text.contains("starts at (1, 0.001), 1.000e-3 from the end of the previous piece"), "{text}");
}

#[test]
fn unbounded_surfaces_and_two_kinds_of_boundary_are_refused() {
    let plane = Surface::Plane { frame: Frame3::WORLD };
    let mut part = PartBuilder::new("part");
    let shell = part.plain_shell(ShellKind::Open);
    let face = part.trimmed_face(plane.clone(), shell, FreeTrims::default(), false);
    let error = part.finish().unwrap_err();
    assert_eq!(error, PartError::Unbounded(face));
    assert_eq!(error.to_string(), "face 0 has neither loops nor trimming curves, and its surface is unbounded");
    let mut part = PartBuilder::new("part");
    let shell = part.plain_shell(ShellKind::Open);
    let trims = FreeTrims { rule: TrimRule::NonZero, curves: vec![TrimCurve::circle(DVec2::ZERO, 1.0)] };
    part.trimmed_face(plane, shell, trims, false);
    let mut part = part.finish().unwrap();
    part.vertices.push(DVec3::ZERO);
    part.faces[0].loops.push(Loop::Vertex(VertexId(0)));
    let error = Model::from(part).check().unwrap_err().to_string();
    assert!(error.contains("face 0 has 1 loops and 1 free trimming curves; it cannot have both"), "{error}");
}

#[test]
fn curves_know_whether_they_are_closed() {
    let circle = TrimCurve::circle(DVec2::new(0.3, 0.4), 0.2);
    assert!(circle.is_closed() && circle.reversed().is_closed() && circle.check().is_ok());
    assert!(!TrimCurve::polyline(vec![DVec2::ZERO, DVec2::X, DVec2::ONE]).is_closed());
    assert!(TrimCurve::polygon(vec![DVec2::ZERO, DVec2::X, DVec2::ONE]).is_closed());
    assert!(!TrimCurve::bezier(vec![DVec2::ZERO, DVec2::X, DVec2::ONE], Vec::new()).is_closed());
}
