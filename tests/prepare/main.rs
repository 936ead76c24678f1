//! Smallest inputs for each difficulty of prepare: poles, apexes, seams, wraps, creases, faces without area.

#[path = "../common/mod.rs"]
mod common;
mod narrow;

use common::{frame, prepared, prepared_clean, whole, whole_frame};
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use trimtess::frame::{Rung, Tolerance, plan};
use trimtess::mesh::{MeshFacts, check_scene};
use trimtess::model::{
    CurveKind, DiagnosticKind, FaceError, FaceTrouble, Frame3, Loop, Model, NurbsCurve3, NurbsSurface, Part,
    PartBuilder, PartId, RegionError, Severity, ShellKind, ShellTrouble, Surface, WireTrouble,
};
use trimtess::prepare::Prepared;

pub(crate) const CHORDS: [f64; 4] = [0.5, 0.05, 5e-3, 5e-4];

pub(crate) fn mesh(prepared: &Arc<Prepared>, chord: f64) -> MeshFacts {
    let plan = plan(prepared, &Tolerance { chord, angle: 0.6, max_edge: None });
    check_scene(&whole_frame(prepared, &plan, false)).total
}

/// Asserts that a part is closed and has the given volume and area at all chords.
fn is_closed(part: Part, volume: f64, area: f64) {
    closes(&prepared_clean(part), volume, area);
}

fn closes(prepared: &Arc<Prepared>, volume: f64, area: f64) {
    for chord in CHORDS {
        let facts = mesh(prepared, chord);
        assert!(facts.is_well_formed() && facts.is_closed(), "chord {chord}: {facts} {:?}", facts.examples);
        let slack = chord * area;
        assert!((facts.volume - volume).abs() <= slack, "chord {chord}: volume {} of {volume}", facts.volume);
    }
}

/// A frame whose circles lie in the plane of x and z.
fn upright() -> Frame3 {
    Frame3::from_axis(DVec3::ZERO, -DVec3::Y, DVec3::X).expect("an axis")
}

#[test]
fn a_circle_through_both_poles_of_a_sphere() {
    // The half with y > 0, bounded by one closed edge through both poles, and its flat side.
    let mut part = PartBuilder::new("half ball");
    let circle = part.circle(&upright(), 5.0);
    let shell = part.plain_shell(ShellKind::Outer);
    // Seen from outside, the kept half lies left if the circle runs from +x over -z.
    part.plain_face(
        Surface::Sphere { frame: Frame3::WORLD, radius: 5.0 },
        shell,
        vec![Loop::Edges(vec![circle.against()])],
        false,
    );
    part.plain_face(Surface::Plane { frame: upright() }, shell, vec![Loop::Edges(vec![circle.along()])], false);
    is_closed(part.finish().expect("a valid part"), 2.0 / 3.0 * PI * 125.0, 3.0 * PI * 25.0);
}

#[test]
fn an_apex_bounds_a_cone_that_has_only_its_base_circle() {
    let (radius, height) = (4.0, 6.0);
    let mut part = PartBuilder::new("cone");
    let circle = part.circle(&Frame3::WORLD, radius);
    let apex = part.vertex(DVec3::new(0.0, 0.0, height));
    let shell = part.plain_shell(ShellKind::Outer);
    let half_angle = -(radius / height).atan();
    let side = Surface::Cone { frame: Frame3::WORLD, radius, half_angle };
    part.plain_face(side, shell, vec![Loop::Edges(vec![circle.along()]), Loop::Vertex(apex)], false);
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, vec![Loop::Edges(vec![circle.against()])], true);
    let slant = radius.hypot(height);
    is_closed(
        part.finish().expect("a valid part"),
        PI * radius * radius * height / 3.0,
        PI * radius * (radius + slant),
    );
}

#[test]
fn an_octant_meets_the_pole_at_a_vertex() {
    // An eighth of a ball: three quarter circles, one of the corners at the pole of the sphere's parametrisation.
    let r = 5.0;
    let mut part = PartBuilder::new("octant");
    let corner = [DVec3::X, DVec3::Y, DVec3::Z].map(|p| part.vertex(p * r));
    let centre = part.vertex(DVec3::ZERO);
    let arc = |a: DVec3, b: DVec3| {
        let frame = Frame3 { origin: DVec3::ZERO, x: a, y: b, z: a.cross(b) };
        NurbsCurve3::arc(&frame, r, r, 0.0, 0.5 * PI)
    };
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let arcs = [0, 1, 2].map(|k| {
        let (a, b) = (k, (k + 1) % 3);
        part.curve(arc(axes[a], axes[b]), CurveKind::Circle, corner[a], corner[b])
    });
    let spokes = [0, 1, 2].map(|k| part.line(centre, corner[k]));
    let shell = part.plain_shell(ShellKind::Outer);
    let round = Loop::Edges(arcs.iter().map(|e| e.along()).collect());
    part.plain_face(Surface::Sphere { frame: Frame3::WORLD, radius: r }, shell, vec![round], false);
    for (k, arc) in arcs.iter().enumerate() {
        let (a, b) = (k, (k + 1) % 3);
        let frame = Frame3 { origin: DVec3::ZERO, x: axes[b], y: axes[a], z: axes[b].cross(axes[a]) };
        let side = Loop::Edges(vec![spokes[b].along(), arc.against(), spokes[a].against()]);
        part.plain_face(Surface::Plane { frame }, shell, vec![side], false);
    }
    is_closed(part.finish().expect("a valid part"), PI * r.powi(3) / 6.0, 5.0 / 4.0 * PI * r * r);
}

#[test]
fn a_hole_in_a_whole_sphere_leaves_the_rest() {
    let (r, h): (f64, f64) = (5.0, 3.0);
    let ring = (r * r - h * h).sqrt();
    for axis in [DVec3::Z, DVec3::X, DVec3::new(1.0, 2.0, -0.5).normalize()] {
        let frame = Frame3::from_axis(axis * h, axis, DVec3::Y).expect("an axis");
        let mut part = PartBuilder::new("bowl");
        let circle = part.circle(&frame, ring);
        let shell = part.plain_shell(ShellKind::Outer);
        let ball = Surface::Sphere { frame: Frame3::WORLD, radius: r };
        part.plain_face(ball, shell, vec![Loop::Edges(vec![circle.against()])], false);
        part.plain_face(Surface::Plane { frame }, shell, vec![Loop::Edges(vec![circle.along()])], false);
        let cap = PI * (r - h).powi(2) * (2.0 * r + h) / 3.0;
        is_closed(part.finish().expect("a valid part"), 4.0 / 3.0 * PI * r.powi(3) - cap, 4.0 * PI * r * r);
    }
}

#[test]
fn wrong_orientation_flags_are_corrected() {
    // The same half ball with every flag of the plane reversed: the shell still closes, with positive volume.
    let mut part = PartBuilder::new("half ball");
    let circle = part.circle(&upright(), 5.0);
    let shell = part.plain_shell(ShellKind::Outer);
    let ball = Surface::Sphere { frame: Frame3::WORLD, radius: 5.0 };
    part.plain_face(ball, shell, vec![Loop::Edges(vec![circle.against()])], false);
    part.plain_face(Surface::Plane { frame: upright() }, shell, vec![Loop::Edges(vec![circle.against()])], false);
    let prepared = prepared(part.finish().expect("a valid part"));
    // Flags of the ball that are wrong could be the cause as well.
    let [told] = &prepared.diagnostics[..] else { panic!("{:?}", prepared.diagnostics) };
    assert!(matches!(told.kind, DiagnosticKind::Wire(WireTrouble::SideUnsure)), "{told:?}");
    closes(&prepared, 2.0 / 3.0 * PI * 125.0, 3.0 * PI * 25.0);
}

/// A bilinear-by-linear sheet over the given profile points, degree 1 in u.
fn sheet(profile: &[DVec3]) -> NurbsSurface {
    let n = profile.len();
    let mut knots_u = vec![0.0];
    knots_u.extend((0..n).map(|k| k as f64));
    knots_u.push((n - 1) as f64);
    NurbsSurface {
        degree_u: 1,
        degree_v: 1,
        knots_u,
        knots_v: vec![0.0, 0.0, 1.0, 1.0],
        points: profile.iter().flat_map(|p| [*p, *p + DVec3::Z * 10.0]).collect(),
        weights: Vec::new(),
    }
}

#[test]
fn creases_are_kept_at_every_tolerance() {
    // A folded sheet: its area is exact only if lines and borders break at the folds.
    let profile =
        [0.0, 1.0, 2.0, 3.5, 4.0, 7.0].map(|x: f64| DVec3::new(x, if x as i32 % 2 == 0 { 0.0 } else { 2.0 }, 0.0));
    let exact: f64 = profile.windows(2).map(|w| 10.0 * w[0].distance(w[1])).sum();
    let prepared = prepared(whole(Surface::Nurbs(sheet(&profile))));
    for chord in [100.0, 1.0, 0.01] {
        let facts = mesh(&prepared, chord);
        assert!((facts.area / exact - 1.0).abs() < 1e-12, "chord {chord}: area {} of {exact}", facts.area);
    }
}

#[test]
fn a_surface_without_area_is_reported_and_has_no_tiles() {
    let mut sheet = sheet(&[DVec3::ZERO, DVec3::X]);
    sheet.points.fill(DVec3::new(1.0, 2.0, 3.0));
    let prepared = prepared(whole(Surface::Nurbs(sheet)));
    assert_eq!(prepared.diagnostics.len(), 1, "{:?}", prepared.diagnostics);
    let why = prepared.diagnostics[0].kind.face_error();
    assert!(matches!(why, Some(FaceError::NoArea { .. })), "{why:?}");
    assert_eq!(prepared.tiles().count(), 0);
    let plan = plan(&prepared, &Tolerance { chord: 0.1, angle: 0.5, max_edge: None });
    let made = frame(&prepared, &plan, false).1;
    assert_eq!((made.ladder.count(Rung::NoArea), made.ladder.count(Rung::Lost)), (1, 0), "{}", made.ladder);
}

#[test]
fn a_full_circle_closes_wherever_its_vertex_is() {
    // A closed circle edge whose vertex lies anywhere on a cylinder without a seam edge.
    for start in [0.0, 1.0, 3.0, 6.0] {
        let mut part = PartBuilder::new("tube");
        let mut ring = |z: f64, turn: f64| {
            let frame = Frame3 { origin: DVec3::Z * z, ..Frame3::WORLD };
            let v = part.vertex(frame.place(DVec3::new(3.0 * (start + turn).cos(), 3.0 * (start + turn).sin(), 0.0)));
            let curve = NurbsCurve3::arc(&frame, 3.0, 3.0, start + turn, start + turn + TAU);
            part.curve(curve, CurveKind::Circle, v, v)
        };
        let (low, high) = (ring(0.0, 0.0), ring(7.0, 2.0));
        let shell = part.plain_shell(ShellKind::Outer);
        let top = Frame3 { origin: DVec3::Z * 7.0, ..Frame3::WORLD };
        let side = Surface::Cylinder { frame: Frame3::WORLD, radius: 3.0 };
        part.plain_face(side, shell, vec![Loop::Edges(vec![low.along()]), Loop::Edges(vec![high.against()])], false);
        part.plain_face(Surface::Plane { frame: top }, shell, vec![Loop::Edges(vec![high.along()])], false);
        part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, vec![Loop::Edges(vec![low.against()])], true);
        is_closed(part.finish().expect("a valid part"), PI * 9.0 * 7.0, TAU * 3.0 * 7.0 + TAU * 9.0);
    }
}

/// A square that lies at `height` above its plane.
fn hanging(height: f64) -> Arc<Prepared> {
    let mut part = PartBuilder::new("square");
    let corners = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)];
    let boundary = part.polygon(&corners.map(|(x, y)| DVec3::new(x, y, height)));
    let shell = part.plain_shell(ShellKind::Open);
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, vec![Loop::Edges(boundary)], false);
    prepared(part.finish().expect("a valid part"))
}

#[test]
fn edges_far_from_their_surface_are_filled_in_space() {
    let prepared = hanging(4.0);
    assert_eq!(prepared.tiles().count(), 1);
    let told = &prepared.diagnostics[0];
    let DiagnosticKind::Face(FaceTrouble::Filled { cause, area_mm2 }) = &told.kind else { panic!("{told:?}") };
    let off = |cause: &FaceError| matches!(cause, FaceError::OffSurface { gap_mm, .. } if (gap_mm - 4.0).abs() < 1e-9);
    assert!(told.severity == Severity::Warning && off(cause) && (area_mm2 - 100.0).abs() < 1e-9, "{told:?}");
    assert!(prepared.parts[0].faces[0].filled);
    let facts = mesh(&prepared, 0.1);
    assert!(facts.area == 100.0 && facts.open_edges == 4, "{facts}");
}

#[test]
fn edges_off_their_surface_that_bound_a_face_keep_it_repaired() {
    let prepared = hanging(3.0);
    assert_eq!(prepared.tiles().count(), 1);
    assert!(prepared.parts[0].faces[0].repaired);
    let told = &prepared.diagnostics[0];
    let off = matches!(
        told.kind,
        DiagnosticKind::Face(FaceTrouble::EdgesOffSurface { gap_mm }) if (gap_mm - 3.0).abs() < 1e-9
    );
    assert!(told.severity == Severity::Warning && off, "{told:?}");
}

/// Number of faces with triangles.
fn mesh_of(prepared: &Arc<Prepared>) -> usize {
    let plan = plan(prepared, &Tolerance { chord: 0.1, angle: 0.6, max_edge: None });
    let sink = frame(prepared, &plan, false).0;
    sink.batches.iter().filter(|batch| !batch.mesh.triangles.is_empty()).count()
}

#[test]
fn an_edge_without_a_range_is_straight() {
    let mut part = PartBuilder::new("disc and ball");
    let circle = part.circle(&Frame3::WORLD, 5.0);
    let other = part.circle(&Frame3 { origin: DVec3::Z * 20.0, ..Frame3::WORLD }, 5.0);
    let shell = part.plain_shell(ShellKind::Open);
    for (edge, z) in [(circle, 0.0), (other, 20.0)] {
        let frame = Frame3 { origin: DVec3::Z * z, ..Frame3::WORLD };
        part.plain_face(Surface::Plane { frame }, shell, vec![Loop::Edges(vec![edge.along()])], false);
    }
    let mut model = Model::from(part.finish().expect("a valid part"));
    // The builder refuses this; the public fields allow it.
    model.parts[0].edges[circle.index()].kind = CurveKind::Spline;
    for range in [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0)] {
        model.parts[0].edges[circle.index()].range = range;
        let prepared = prepared(model.clone());
        // From its vertex to itself, so nothing remains of the disc.
        assert_eq!(prepared.tiles().count(), 2, "{range:?}");
        assert_eq!(mesh_of(&prepared), 1, "{range:?}");
        let why = prepared.diagnostics[0].kind.face_error();
        let empty = matches!(why, Some(FaceError::Region(RegionError::EmptyEdge { edge, .. })) if *edge == circle);
        assert!(empty, "{:?}", prepared.diagnostics);
    }
}

/// A bowl of outer radius 100 mm, and its volume.
fn bowl(wall: f64, inside_out: bool) -> (Model, f64) {
    let (outer, inner) = (100.0, 100.0 - wall);
    let mut part = PartBuilder::new("bowl");
    let rims = [outer, inner].map(|r| part.circle(&Frame3::WORLD, r));
    let shell = part.plain_shell(ShellKind::Outer);
    for (rim, radius, reversed) in [(rims[0], outer, inside_out), (rims[1], inner, !inside_out)] {
        let ball = Surface::Sphere { frame: Frame3::WORLD, radius };
        part.plain_face(ball, shell, vec![Loop::Edges(vec![rim.along()])], reversed);
    }
    let rim = vec![Loop::Edges(vec![rims[0].along()]), Loop::Edges(vec![rims[1].against()])];
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, rim, !inside_out);
    (part.finish().expect("a valid part").into(), 2.0 / 3.0 * PI * (outer.powi(3) - inner.powi(3)))
}

#[test]
fn thin_bowls_look_outwards_whichever_way_they_are_stated() {
    // The volume of the thinnest is the difference of two that are a thousand times larger.
    for wall in [0.2, 1.0, 5.0] {
        let (model, volume) = bowl(wall, false);
        let facts = mesh(&prepared_clean(model), 1e-3);
        assert!(facts.is_closed() && (facts.volume / volume - 1.0).abs() < 0.02, "{wall}: {facts}");
    }
    for wall in [0.2, 2.0, 5.0, 20.0] {
        let (model, volume) = bowl(wall, true);
        let prepared = common::prepared(model);
        let facts = mesh(&prepared, 1e-3);
        assert!(facts.is_closed() && (facts.volume / volume - 1.0).abs() < 0.02, "{wall}: {facts}");
        let told = &prepared.diagnostics[0].kind;
        assert!(matches!(told, DiagnosticKind::Shell(ShellTrouble::InsideOut { faces: 3, .. })), "{wall}: {told:?}");
    }

    // A half ball whose faces are consistently inside out.
    let mut part = PartBuilder::new("half ball");
    let outer = 100.0;
    let rim = part.circle(&Frame3::WORLD, outer);
    let shell = part.plain_shell(ShellKind::Outer);
    let ball = Surface::Sphere { frame: Frame3::WORLD, radius: outer };
    part.plain_face(ball, shell, vec![Loop::Edges(vec![rim.along()])], true);
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, vec![Loop::Edges(vec![rim.along()])], false);
    let prepared = common::prepared(part.finish().expect("a valid part"));
    let turned =
        matches!(prepared.diagnostics[0].kind, DiagnosticKind::Shell(ShellTrouble::InsideOut { faces: 2, .. }));
    assert!(turned, "{:?}", prepared.diagnostics);
    assert!(mesh(&prepared, 0.1).volume > 0.0);
}

/// Three quarters of a ring. Its seam makes the side one loop, so the cones over the boundaries span the missing
/// quarter.
#[test]
fn rings_with_a_gap_look_outwards_whichever_way_they_are_stated() {
    let (major, minor, end) = (20.0, 2.0, 0.75 * TAU);
    for inside_out in [false, true] {
        let mut part = PartBuilder::new("three quarters of a ring");
        let shell = part.plain_shell(ShellKind::Outer);
        let frames = [0.0, end].map(|u| {
            let out = DVec3::new(u.cos(), u.sin(), 0.0);
            Frame3 { origin: major * out, x: out, y: DVec3::Z, z: out.cross(DVec3::Z) }
        });
        let [first, last] = frames.map(|frame| {
            let vertex = part.vertex(frame.origin + minor * frame.x);
            let curve = NurbsCurve3::arc(&frame, minor, minor, 0.0, TAU);
            (vertex, part.curve(curve, CurveKind::Circle, vertex, vertex))
        });
        let outer = NurbsCurve3::arc(&Frame3::WORLD, major + minor, major + minor, 0.0, end);
        let seam = part.curve(outer, CurveKind::Circle, first.0, last.0);
        let side = vec![seam.along(), last.1.along(), seam.against(), first.1.against()];
        let torus = Surface::Torus { frame: Frame3::WORLD, major, minor };
        part.plain_face(torus, shell, vec![Loop::Edges(side)], inside_out);
        let caps = [(frames[0], first.1.along(), false), (frames[1], last.1.against(), true)];
        for (frame, cap, reversed) in caps {
            part.plain_face(Surface::Plane { frame }, shell, vec![Loop::Edges(vec![cap])], reversed != inside_out);
        }
        let prepared = prepared(part.finish().expect("a valid part"));
        let told =
            |kind: &DiagnosticKind| matches!(kind, DiagnosticKind::Shell(ShellTrouble::InsideOut { faces: 3, .. }));
        assert_eq!(prepared.diagnostics.iter().filter(|d| told(&d.kind)).count(), usize::from(inside_out));
        let facts = mesh(&prepared, 1e-3);
        let volume = end * major * PI * minor * minor;
        assert!(facts.is_closed() && (facts.volume / volume - 1.0).abs() < 0.01, "{inside_out}: {facts}");
    }
}

#[test]
fn dangling_indices_cause_no_panic() {
    let whole = || {
        let mut part = PartBuilder::new("disc");
        let circle = part.circle(&Frame3::WORLD, 5.0);
        let shell = part.plain_shell(ShellKind::Open);
        let boundary = vec![Loop::Edges(vec![circle.along()])];
        part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, boundary, false);
        Model::from(part.finish().expect("a valid part"))
    };
    let mut model = whole();
    model.instances[0].part = PartId(7);
    let prepared = prepared(model);
    let no_part = matches!(prepared.diagnostics[0].kind, DiagnosticKind::NoPart { part: PartId(7), parts: 1, .. });
    assert!(no_part, "{:?}", prepared.diagnostics);

    let mut edges = whole();
    edges.parts[0].edges[0].end = trimtess::model::VertexId(99);
    let mut empty = whole();
    empty.parts[0].faces[0].loops = vec![Loop::Edges(Vec::new())];
    for broken in [edges, empty] {
        let prepared = common::prepared(broken);
        assert_eq!(prepared.tiles().count(), 0);
        assert_eq!(prepared.diagnostics[0].face, Some(trimtess::model::FaceId(0)), "{:?}", prepared.diagnostics);
    }

    // An edge that no face uses, with a vertex that does not exist, is harmless.
    let mut loose = whole();
    let mut edge = loose.parts[0].edges[0].clone();
    edge.start = trimtess::model::VertexId(99);
    loose.parts[0].edges.push(edge);
    let prepared = common::prepared(loose);
    assert!(prepared.diagnostics.is_empty() && prepared.tiles().count() == 1, "{:?}", prepared.diagnostics);
}

#[test]
fn a_turned_surface_without_edges_is_kept_whole() {
    // A ball as a half circle turned about its diameter: only the surface states its size.
    let upright = Frame3 { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Z, z: -DVec3::Y };
    let curve = NurbsCurve3::arc(&upright, 5.0, 5.0, -0.5 * PI, 0.5 * PI);
    let mut part = whole(Surface::Nurbs(sheet(&[DVec3::ZERO, DVec3::X])));
    part.faces[0].surface = Surface::Revolution { curve, frame: Frame3::WORLD };
    let prepared = prepared_clean(part);
    let facts = mesh(&prepared, 1e-3);
    assert!(facts.is_closed() && (facts.volume.abs() / (4.0 / 3.0 * PI * 125.0) - 1.0).abs() < 1e-2, "{facts}");
}

#[test]
fn bodies_that_share_an_edge_keep_their_orientation() {
    // Two cubes of one part that touch along an edge. It has four uses, two per shell.
    let mut part = PartBuilder::new("touching cubes");
    let mut vertices = std::collections::BTreeMap::new();
    let mut edges = std::collections::BTreeMap::new();
    for origin in [[0, 0, 0], [1, 1, 0]] {
        let shell = part.plain_shell(ShellKind::Outer);
        for axis in 0..3 {
            for side in 0..2 {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let corner = |i: i32, j: i32| {
                    let mut p = origin;
                    p[axis] += side;
                    p[u] += i;
                    p[v] += j;
                    p
                };
                let corners = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                let at = |p: [i32; 3]| DVec3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]));
                let frame = Frame3 {
                    origin: at(corners[0]),
                    x: at(corners[1]) - at(corners[0]),
                    y: at(corners[3]) - at(corners[0]),
                    z: (at(corners[1]) - at(corners[0])).cross(at(corners[3]) - at(corners[0])),
                };
                // Counter-clockwise about the surface normal; the lower side looks the other way.
                let reversed = side == 0;
                let mut boundary = Vec::new();
                for k in 0..4 {
                    let ends = [corners[k], corners[(k + 1) % 4]];
                    let [a, b] = ends.map(|p| *vertices.entry(p).or_insert_with(|| part.vertex(at(p))));
                    let key = (ends[0].min(ends[1]), ends[0].max(ends[1]));
                    let (first, edge) = *edges.entry(key).or_insert_with(|| (ends[0], part.line(a, b)));
                    boundary.push(if first == ends[0] { edge.along() } else { edge.against() });
                }
                part.plain_face(Surface::Plane { frame }, shell, vec![Loop::Edges(boundary)], reversed);
            }
        }
    }
    let part = part.finish().expect("a valid part");
    assert_eq!(part.edges.len(), 23, "one edge is common");
    is_closed(part, 2.0, 12.0);
}

#[test]
fn tiles_are_cut_between_creases() {
    const SIDE: u32 = 41;
    let at = |i: u32, j: u32| {
        DVec3::new(f64::from(i), f64::from(j), (0.7 * f64::from(i)).sin() + (0.9 * f64::from(j)).cos())
    };
    let knots: Vec<f64> = [0].into_iter().chain(0..SIDE).chain([SIDE - 1]).map(f64::from).collect();
    let points = (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| at(i, j))).collect();
    let facets =
        NurbsSurface { degree_u: 1, degree_v: 1, knots_u: knots.clone(), knots_v: knots, points, weights: Vec::new() };
    let prepared = prepared_clean(whole(Surface::Nurbs(facets)));
    let tiles = &prepared.parts[0].tiles;
    let lines = tiles.iter().flat_map(|tile| [tile.min, tile.max]).flat_map(|corner| corner.to_array());
    let inner: Vec<f64> = lines.filter(|x| *x > 0.0 && *x < f64::from(SIDE - 1)).collect();
    assert!(tiles.len() == 16 && inner.iter().all(|x| (x - x.round()).abs() > 0.25), "{inner:?}");
}

#[test]
fn a_curved_face_of_many_holes_has_many_tiles() {
    const HOLES: [u32; 2] = [80, 15];
    let (radius, small) = (10.0_f64, 0.02_f64);
    let mut part = PartBuilder::new("perforated ball");
    let shell = part.plain_shell(ShellKind::Open);
    let places = (0..HOLES[0]).flat_map(|i| (0..HOLES[1]).map(move |j| (f64::from(i) * TAU / 80.0, f64::from(j))));
    let mut hole = |(u, row): (f64, f64)| {
        let v = 0.14 * (row - 7.0);
        let out = DVec3::new(u.cos() * v.cos(), u.sin() * v.cos(), v.sin());
        let frame = Frame3::from_axis(out * radius * small.cos(), out, DVec3::Z).expect("an axis");
        Loop::Edges(vec![part.circle(&frame, radius * small.sin()).against()])
    };
    let holes: Vec<Loop> = places.map(&mut hole).collect();
    let count = holes.len();
    part.plain_face(Surface::Sphere { frame: Frame3::WORLD, radius }, shell, holes, false);
    let prepared = prepared_clean(part.finish().expect("a sound part"));
    let tiles = &prepared.parts[0].tiles;
    let most = tiles.iter().map(|tile| tile.loops.len()).max().unwrap();
    assert!(tiles.len() >= 9 && most < count / 4, "{} tiles, {most} of {count} loops in one", tiles.len());
    let left = TAU * radius * radius * (2.0 - count as f64 * (1.0 - small.cos()));
    let facts = mesh(&prepared, 5e-3);
    assert!((facts.area - left).abs() < 0.005 * left, "{} is not {left}", facts.area);
}
