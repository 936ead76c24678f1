//! What the builders refuse, with the numbers in the messages.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use glam::{DAffine3, DMat3, DVec3};
use trimtess::model::{
    CurveKind, Edge, EdgeId, Frame3, Loop, ModelBuilder, ModelError, NurbsCurve3, NurbsSurface, Part, PartBuilder,
    PartError, PartId, ShellKind, SplineError, StepCause, StepTrouble, Surface, SurfaceError, VertexId,
};

/// A unit square in the plane.
fn square() -> PartBuilder {
    let mut part = PartBuilder::new("square");
    let outer = part.polygon(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0)));
    let shell = part.plain_shell(ShellKind::Open);
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, vec![Loop::Edges(outer)], false);
    part
}

/// The error for the sound square after a change.
fn broken(change: impl FnOnce(&mut Part)) -> PartError {
    let mut part = square().finish().unwrap();
    change(&mut part);
    part.check().unwrap_err()
}

fn curve() -> NurbsCurve3 {
    NurbsCurve3 {
        degree: 2,
        knots: vec![0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0],
        points: (0..4).map(|i| DVec3::splat(f64::from(i))).collect(),
        weights: vec![1.0; 4],
    }
}

#[test]
fn splines_are_refused_with_numbers() {
    type Change = fn(&mut NurbsCurve3);
    let cases: [(Change, SplineError, &str); 11] = [
        (|c| c.degree = 0, SplineError::Degree { degree: 0 }, "degree 0 is not in 1..=60"),
        (|c| c.degree = 61, SplineError::Degree { degree: 61 }, "degree 61 is not in 1..=60"),
        (
            |c| c.knots.truncate(6),
            SplineError::Count { degree: 2, knots: 6, points: 4 },
            "6 knots do not fit 4 control points of degree 2: 7 knots and at least 3 points are needed",
        ),
        (|c| c.weights.truncate(3), SplineError::Weights { weights: 3, points: 4 }, "3 weights for 4 control points"),
        (|c| c.points[2].y = f64::NAN, SplineError::Point { index: 2 }, "control point 2 is not finite"),
        (
            |c| c.weights[1] = -0.5,
            SplineError::Weight { index: 1, weight: -0.5 },
            "weight 1 is -0.5, not within 1e-30 to 1e30",
        ),
        (
            |c| c.weights[3] = 2e30,
            SplineError::Weight { index: 3, weight: 2e30 },
            "weight 3 is 2000000000000000000000000000000, not within 1e-30 to 1e30",
        ),
        (
            |c| c.knots[3] = 3.0,
            SplineError::Decreasing { index: 4, before: 3.0, knot: 2.0 },
            "knot 4 is 2, less than 3 before it",
        ),
        (
            |c| {
                c.knots = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0];
                c.points.extend([DVec3::ONE, DVec3::X]);
                c.weights.clear();
            },
            SplineError::Multiplicity { knot: 1.0, multiplicity: 3, most: 2 },
            "knot 1 has multiplicity 3; at most 2 is allowed",
        ),
        (
            |c| c.knots.iter_mut().for_each(|k| *k += 1e12),
            SplineError::Coarse { domain: (1e12, 1e12 + 2.0) },
            "the domain from 1000000000000 to 1000000000002 is too short for the spacing of numbers of that size",
        ),
        (|c| c.knots = vec![4.0; 7], SplineError::Empty { at: 4.0 }, "the domain is the single parameter 4"),
    ];
    assert_eq!(curve().check(), Ok(()));
    for (change, error, message) in cases {
        let mut wrong = curve();
        change(&mut wrong);
        assert_eq!(wrong.check(), Err(error));
        assert_eq!(error.to_string(), message);
    }
    let mut infinite = curve();
    infinite.knots[6] = f64::INFINITY;
    assert_eq!(infinite.check(), Err(SplineError::Knot { index: 6, knot: f64::INFINITY }));
}

#[test]
fn surfaces_are_refused_with_numbers() {
    let frame = Frame3::WORLD;
    let skew = Frame3 { x: DVec3::new(1.0, 0.5, 0.0), ..frame };
    let left_handed = Frame3 { z: -frame.z, ..frame };
    let cases = [
        (Surface::Cylinder { frame, radius: 0.0 }, "a cylinder's radius must be positive, but is 0"),
        (Surface::Sphere { frame, radius: f64::NAN }, "a sphere's radius must be positive, but is NaN"),
        (Surface::Torus { frame, major: -1.0, minor: 1.0 }, "a torus's major radius must not be negative, but is -1"),
        (
            Surface::Cone { frame, radius: 1.0, half_angle: 0.0 },
            "a cone's half angle must be in (-π/2, π/2) and not 0, but is 0",
        ),
        (Surface::Plane { frame: skew }, "the frame is not orthonormal and right-handed (off by 5.0e-1)"),
        (Surface::Plane { frame: left_handed }, "the frame is not orthonormal and right-handed (off by 2.0e0)"),
        (
            Surface::Extrusion { curve: curve(), direction: DVec3::ZERO },
            "the length of an extrusion's direction must be positive, but is 0",
        ),
        (
            Surface::Revolution { curve: NurbsCurve3 { weights: vec![1.0], ..curve() }, frame },
            "swept curve: 1 weights for 4 control points",
        ),
    ];
    for (surface, message) in cases {
        assert_eq!(surface.check().unwrap_err().to_string(), message);
    }
    for far in [Frame3 { origin: DVec3::INFINITY, ..frame }, Frame3 { x: DVec3::NAN, ..frame }] {
        assert_eq!(Surface::Plane { frame: far }.check().unwrap_err().to_string(), "the frame is not finite");
    }
    let mut net = NurbsSurface::bezier((1, 1), vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE], Vec::new());
    assert_eq!(net.check(), Ok(()));
    net.knots_v[1] = 2.0;
    let error = SplineError::Decreasing { index: 2, before: 2.0, knot: 1.0 };
    assert_eq!(net.check(), Err(SurfaceError::Spline { direction: 'v', error }));
    net.knots_v[1] = 0.0;
    net.points.pop();
    assert!(net.check().unwrap_err().to_string().starts_with("in u: 4 knots do not fit"));
}

#[test]
fn parts_are_refused_with_numbers() {
    assert!(square().finish().is_ok());
    assert_eq!(broken(|p| p.vertices[1].x = f64::INFINITY).to_string(), "vertex 1 is not finite");
    assert_eq!(broken(|p| p.edges[2].range.1 = 1.5).to_string(), "edge 2 runs from 0 to 1.5, its curve from 0 to 1");
    assert_eq!(
        broken(|p| p.edges[2].range = (0.5, 0.5)).to_string(),
        "edge 2 runs from 0.5 to 0.5, its curve from 0 to 1"
    );
    assert_eq!(broken(|p| p.edges[3].end = VertexId(9)).to_string(), "edge 3 refers to vertex 9; the part has 4");
    assert_eq!(
        broken(|p| p.vertices[0].z = 0.25).to_string(),
        "edge 0 misses its vertex 0 by 2.500e-1 mm (limit 1.436e-4 mm)"
    );
    assert_eq!(broken(|p| p.faces[0].shell = 3).to_string(), "face 0 refers to shell 3; the part has 1");
    assert_eq!(
        broken(|p| p.faces[0].loops = vec![Loop::Edges(Vec::new())]).to_string(),
        "loop 0 of face 0 has no edges"
    );
    assert_eq!(
        broken(|p| p.faces[0].loops.clear()).to_string(),
        "face 0 has neither loops nor trimming curves, and its surface is unbounded"
    );
    assert_eq!(
        broken(|p| p.faces[0].loops = vec![Loop::Edges(vec![EdgeId(7).along()])]).to_string(),
        "face 0 refers to edge 7; the part has 4"
    );
    assert_eq!(
        broken(|p| p.faces[0].loops.push(Loop::Vertex(VertexId(4)))).to_string(),
        "face 0 refers to vertex 4; the part has 4"
    );
    let open = broken(|p| {
        if let Loop::Edges(coedges) = &mut p.faces[0].loops[0] {
            coedges.remove(2);
        }
    });
    assert_eq!(
        open.to_string(),
        "loop 0 of face 0 is open: a coedge ends at vertex 2, the next starts at vertex 3, 1.000e0 mm away"
    );
    let turned = broken(|p| {
        if let Loop::Edges(coedges) = &mut p.faces[0].loops[0] {
            coedges[1].reversed = true;
        }
    });
    assert!(matches!(turned, PartError::OpenLoop { end: VertexId(1), start: VertexId(2), .. }), "{turned}");
}

#[test]
fn tolerances_are_finite_and_not_negative() {
    for tolerance in [-1e-3, f64::INFINITY] {
        assert_eq!(broken(|p| p.tolerance = tolerance), PartError::Tolerance(tolerance));
    }
    let told = broken(|p| p.tolerance = f64::NAN).to_string();
    assert_eq!(told, "a tolerance of NaN mm is negative or not finite");
}

#[test]
fn a_face_whose_surface_was_refused_needs_edges_or_trimming_curves() {
    let refused = broken(|p| {
        p.faces[0].refused = Some(StepCause { entity: None, trouble: Box::new(StepTrouble::Unbounded) });
        p.faces[0].loops.clear();
    });
    assert_eq!(refused.to_string(), "face 0 has neither edges nor trimming curves, and its surface could not be read");
}

#[test]
fn an_edge_may_miss_its_vertex_a_little() {
    let mut part = square().finish().unwrap();
    part.vertices[0].z = 1e-5;
    assert_eq!(part.check(), Ok(()));
}

#[test]
fn models_are_refused_with_numbers() {
    let model = |transform: DAffine3, which: u32| {
        let mut model = ModelBuilder::new("model");
        model.part(square().finish().unwrap());
        model.place(PartId(which), transform);
        model.finish()
    };
    let turned = DMat3::from_rotation_y(0.3) * 2.5;
    assert!(model(DAffine3::from_mat3_translation(turned, DVec3::ONE), 0).is_ok());
    assert_eq!(model(DAffine3::IDENTITY, 2).unwrap_err().to_string(), "instance 0 refers to part 2; the model has 1");
    let squeezed = DAffine3::from_scale(DVec3::new(1.0, 1.0, 2.0));
    assert!(matches!(model(squeezed, 0), Err(ModelError::Transform { error, .. }) if (error - 1.0).abs() < 1e-12));
    for none in [DAffine3::ZERO, DAffine3::from_translation(DVec3::Y * f64::INFINITY)] {
        let error = model(none, 0).unwrap_err();
        assert!(matches!(error, ModelError::Transform { error, .. } if error.is_nan()));
        assert_eq!(error.to_string(), "the transform of instance 0 is singular or not finite");
    }
    let mut inner = ModelBuilder::new("model");
    let mut part = square().finish().unwrap();
    part.edges.push(Edge {
        curve: curve(),
        range: (0.0, 2.0),
        start: VertexId(0),
        end: VertexId(1),
        kind: CurveKind::Spline,
        entity: 0,
    });
    inner.part(part);
    assert!(inner.finish().unwrap_err().to_string().starts_with("part 0: edge 4 misses its vertex 1 by"));
}

#[test]
fn a_bounded_surface_may_be_kept_whole() {
    let mut part = PartBuilder::new("ball");
    let shell = part.plain_shell(ShellKind::Outer);
    let surface = Surface::Sphere { frame: Frame3::WORLD, radius: 2.0 };
    part.plain_face(surface, shell, Vec::new(), false);
    part.colour([1.0, 0.0, 0.0, 1.0]);
    let part = part.finish().unwrap();
    assert_eq!((part.faces.len(), part.colour), (1, Some([1.0, 0.0, 0.0, 1.0])));
}
