//! Meshes with a known distance to their surface -> the audit measures that distance and finds damage.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{prepared_clean, whole};
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use trimtess::audit::{DeviationReport, deviation, economy};
use trimtess::frame::{self, Tolerance};
use trimtess::mesh::{Batch, EdgeLine, MemorySink, Origin, TileMesh, check_scene};
use trimtess::model::{
    EdgeId, FaceId, Frame3, Loop, NurbsCurve3, NurbsSurface, Part, PartBuilder, PartId, ShellKind, Surface,
    SurfaceKind, TileId, VertexId,
};
use trimtess::prepare::Prepared;
use trimtess::prepare::internals::PreparedFace;

const RADIUS: f64 = 10.0;
const HEIGHT: f64 = 15.0;

/// A solid cylinder: edges 0 and 1 are its circles (bottom, top), edge 2 its seam; faces bottom, top, wall.
fn cylinder() -> Part {
    let mut part = PartBuilder::new("cylinder");
    let shell = part.plain_shell(ShellKind::Outer);
    let [bottom, top] = [0.0, HEIGHT].map(|z| Frame3 { origin: DVec3::Z * z, ..Frame3::WORLD });
    let [low, high] = [bottom, top].map(|frame| part.circle(&frame, RADIUS));
    let seam = part.line(VertexId(0), VertexId(1));
    for (surface, wire, reversed) in [
        (Surface::Plane { frame: bottom }, vec![low.along()], true),
        (Surface::Plane { frame: top }, vec![high.along()], false),
        (
            Surface::Cylinder { frame: bottom, radius: RADIUS },
            vec![low.along(), seam.along(), high.against(), seam.against()],
            false,
        ),
    ] {
        part.plain_face(surface, shell, vec![Loop::Edges(wire)], reversed);
    }
    part.finish().expect("a sound part")
}

/// z = `bow` (x² + y²) over [-1, 1]², as a bicubic.
fn paraboloid(bow: f64) -> Surface {
    let at = [-1.0, -1.0 / 3.0, 1.0 / 3.0, 1.0];
    let squares = [1.0, -1.0 / 3.0, -1.0 / 3.0, 1.0];
    let point = |i: usize, j: usize| DVec3::new(at[i], at[j], bow * (squares[i] + squares[j]));
    let points = (0..16).map(|k| point(k / 4, k % 4)).collect();
    Surface::Nurbs(NurbsSurface::bezier((3, 3), points, Vec::new()))
}

/// The face's parameter box in natural parameters.
fn natural_box(face: &PreparedFace) -> (DVec2, DVec2) {
    let ends = |axis: usize, breaks: &[f64]| {
        (face.maps[axis].to_natural(breaks[0]), face.maps[axis].to_natural(breaks[breaks.len() - 1]))
    };
    let ((u0, u1), (v0, v1)) = (ends(0, &face.patches.breaks_u), ends(1, &face.patches.breaks_v));
    (DVec2::new(u0, v0), DVec2::new(u1, v1))
}

/// A uniform lattice of `n` × `m` cells over a face in natural parameters, as one batch.
fn lattice(prepared: &Prepared, number: u32, surface: &Surface, n: u32, m: u32) -> MemorySink {
    let part = &prepared.parts[0];
    let row = part.face_rows[number as usize].unwrap() as usize;
    let (low, high) = natural_box(&part.faces[row]);
    let mut mesh = TileMesh::default();
    for j in 0..=m {
        for i in 0..=n {
            let uv = low + (high - low) * DVec2::new(f64::from(i) / f64::from(n), f64::from(j) / f64::from(m));
            mesh.positions.push(surface.point(uv.x, uv.y));
            mesh.normals.push(Vec3::Z);
            mesh.uvs.push(Vec2::new(uv.x as f32, uv.y as f32));
            mesh.origins.push(Origin::Lattice { i, j });
        }
    }
    for (i, j) in (0..m).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let corner = |i: u32, j: u32| j * (n + 1) + i;
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        for t in [[a, b, c], [a, c, d]] {
            let distinct =
                |x: usize, y: usize| mesh.positions[t[x] as usize].distance(mesh.positions[t[y] as usize]) > 1e-9;
            if distinct(0, 1) && distinct(1, 2) && distinct(2, 0) {
                mesh.triangles.push(t);
            }
        }
    }
    let tile = TileId(part.faces[row].tiles.start);
    let batch = Batch { part: PartId(0), face: FaceId(number), tile, worker: 0, mesh };
    MemorySink::of(prepared.scene.clone(), vec![batch], Vec::new())
}

fn framed(prepared: &Arc<Prepared>, chord: f64) -> MemorySink {
    let tolerance = Tolerance { chord, angle: 1.5, max_edge: None };
    let sink = common::frame(prepared, &frame::plan(prepared, &tolerance), true).0;
    assert!(!sink.batches.is_empty() && sink.batches.iter().all(|b| !b.mesh.triangles.is_empty()));
    sink
}

/// Asserts that the worst distance is `expected` millimetres: at most 2 % more, and no less up to rounding.
fn assert_worst(report: &DeviationReport, expected: f64) {
    let worst = report.raw.worst * report.chord;
    assert!(worst >= expected * (1.0 - 1e-6) && worst <= 1.02 * expected, "{worst} for {expected}\n{report}");
}

#[test]
fn sphere_lattice_has_its_sagitta() {
    let surface = Surface::Sphere { frame: Frame3::WORLD, radius: RADIUS };
    let prepared = prepared_clean(whole(surface.clone()));
    for (n, m) in [(12, 7), (48, 21), (120, 61)] {
        // The row across the equator consists of rectangles, which are farthest from the sphere in their middle.
        let (half_u, half_v) = (PI / f64::from(n), 0.5 * PI / f64::from(m));
        let sagitta = RADIUS * (1.0 - half_u.cos() * half_v.cos());
        let report = deviation(&prepared, &lattice(&prepared, 0, &surface, n, m), 0.7 * sagitta);
        assert_worst(&report, sagitta);
        assert_eq!((report.kinds[0].0, report.kinds.len(), report.faces_over), (SurfaceKind::Sphere, 1, 1));
        assert_eq!(report.measured, report.triangles);
        assert!((4.0..=64.0).contains(&report.samples_per_triangle()));
    }
}

#[test]
fn cylinder_lattice_and_circle_have_their_sagitta() {
    let part = cylinder();
    let surface = part.faces[2].surface.clone();
    let circle = part.edges[1].curve.clone();
    let prepared = prepared_clean(part);
    for n in [5_u32, 16, 97, 1000] {
        let sagitta = RADIUS * (1.0 - (PI / f64::from(n)).cos());
        let mut mesh = lattice(&prepared, 2, &surface, n, 1);
        let points = (0..=n).map(|k| {
            let (s, c) = (TAU * f64::from(k) / f64::from(n)).sin_cos();
            if k % n == 0 { circle.point(0.0) } else { DVec3::new(RADIUS * c, RADIUS * s, HEIGHT) }
        });
        mesh.edge_lines = vec![EdgeLine { part: PartId(0), edge: EdgeId(1), points: points.collect() }];
        let report = deviation(&prepared, &mesh, sagitta);
        assert_worst(&report, sagitta);
        let edge = report.edges.worst;
        assert!((edge - 1.0).abs() < 0.02, "edge {edge}\n{report}");
        assert_eq!(report.worst_edges[0].edge, EdgeId(1));
    }
}

#[test]
fn bicubic_lattice_has_its_sagitta() {
    let bow = 0.1;
    let surface = paraboloid(bow);
    let prepared = prepared_clean(whole(surface.clone()));
    for n in [10, 50, 120] {
        let step = 2.0 / f64::from(n);
        let sagitta = 0.5 * bow * step * step;
        let report = deviation(&prepared, &lattice(&prepared, 0, &surface, n, n), sagitta);
        assert!((report.raw.worst - 1.0).abs() < 0.02, "{report}");
        assert_eq!(report.kinds[0].0, SurfaceKind::Nurbs);
    }
}

#[test]
fn frames_keep_their_tolerance_here() {
    for part in [cylinder(), whole(Surface::Sphere { frame: Frame3::WORLD, radius: RADIUS }), whole(paraboloid(0.4))] {
        let prepared = prepared_clean(part);
        for chord in [0.5, 0.05, 0.005] {
            let report = deviation(&prepared, &framed(&prepared, chord), chord);
            assert!(report.beyond_gap.worst <= 1.0 && report.faces_over == 0, "{report}");
            assert!(report.edges.worst <= 1.0, "{report}");
            assert!(report.beyond_gap.samples > 100 && report.beyond_gap.worst > 0.1, "{report}");
        }
    }
}

#[test]
fn a_moved_vertex_is_found_on_its_face() {
    let prepared = prepared_clean(cylinder());
    let chord = 0.01;
    let mut mesh = framed(&prepared, chord);
    let wall = mesh.batches.iter().position(|b| b.face == FaceId(2)).unwrap();
    let batch = &mut mesh.batches[wall];
    let triangle = batch.mesh.triangles.len() / 2;
    let vertex = batch.mesh.triangles[triangle][0] as usize;
    let outwards = batch.mesh.normals[vertex].as_dvec3();
    batch.mesh.positions[vertex] += 4.0 * chord * outwards;
    let (tile, place) = (batch.tile, batch.mesh.positions[vertex]);
    let report = deviation(&prepared, &mesh, chord);
    assert_eq!((report.faces_over, report.worst[0].face, report.worst[0].tile), (1, FaceId(2), tile), "{report}");
    assert!(report.worst[0].over_tolerance > 1.5 && report.worst[0].point.distance(place) < HEIGHT, "{report}");
    let uses = |t: &[u32; 3]| t.iter().any(|&v| v as usize == vertex);
    assert!(uses(&mesh.batches[wall].mesh.triangles[report.worst[0].triangle]));
}

#[test]
fn a_moved_edge_point_and_a_nan_are_found() {
    let prepared = prepared_clean(cylinder());
    let chord = 0.01;
    let mut mesh = framed(&prepared, chord);
    let line = mesh.edge_lines.iter_mut().find(|line| line.edge == EdgeId(0)).unwrap();
    let middle = line.points.len() / 2;
    line.points[middle] += DVec3::Z * (5.0 * chord);
    let report = deviation(&prepared, &mesh, chord);
    assert_eq!((report.worst_edges[0].edge, report.faces_over), (EdgeId(0), 0));
    assert!(report.worst_edges[0].over_tolerance > 2.0 && report.edges.over > 0, "{report}");
    mesh.batches[0].mesh.positions[0] = DVec3::NAN;
    let report = deviation(&prepared, &mesh, chord);
    assert_eq!((report.beyond_gap.worst, report.worst[0].face), (f64::INFINITY, mesh.batches[0].face), "{report}");
}

#[test]
fn tiles_of_which_nothing_can_be_measured_are_left_out() {
    let prepared = prepared_clean(cylinder());
    let whole = framed(&prepared, 0.01);
    let measured = |mesh: &MemorySink| {
        let report = deviation(&prepared, mesh, 0.01);
        let all: usize = mesh.batches.iter().map(|batch| batch.mesh.triangles.len()).sum();
        assert_eq!(report.triangles, all as u64);
        report.measured
    };
    let wall = whole.batches.iter().position(|b| b.face == FaceId(2)).unwrap();
    let damage: [fn(&mut TileMesh); 4] = [
        |mesh| mesh.uvs.clear(),
        |mesh| mesh.origins.clear(),
        |mesh| mesh.positions.truncate(1),
        |mesh| mesh.triangles[0][2] = u32::MAX,
    ];
    for damage in damage {
        let mut mesh = whole.clone();
        damage(&mut mesh.batches[wall].mesh);
        let left = measured(&whole) - whole.batches[wall].mesh.triangles.len() as u64;
        assert_eq!(measured(&mesh), left);
        assert!(left > 0 && economy(&prepared, &mesh, 0.01).tiles.len() < economy(&prepared, &whole, 0.01).tiles.len());
    }
}

#[test]
fn economy_knows_the_smallest_lattice() {
    let surface = Surface::Cylinder { frame: Frame3::WORLD, radius: RADIUS };
    let prepared = prepared_clean(cylinder());
    // 24 columns are the fewest; the mesh has twice as many, and four rows where one would do.
    let chord = RADIUS * (1.0 - (PI / 24.0).cos()) * 1.05;
    let report = economy(&prepared, &lattice(&prepared, 2, &surface, 48, 4), chord);
    let [tile] = report.tiles[..] else { panic!("{report}") };
    assert_eq!((tile.face, tile.made, tile.kind), (FaceId(2), 384.0, SurfaceKind::Cylinder));
    assert!((48.0..=52.0).contains(&tile.lattice), "{report}");
    // Both circles and both sides of the seam.
    assert_eq!((tile.boundary, tile.needed()), (48.0 + 48.0 + 8.0 - 2.0, tile.boundary), "{report}");
    assert!((report.mean() - report.worst()).abs() < 1e-12);
}

#[test]
fn weights_do_not_ask_for_triangles() {
    // Weights from 0.03 to 30.
    let grid = || (0..16).map(|k| (f64::from(k / 4), f64::from(k % 4)));
    let points = grid().map(|(x, y)| DVec3::new(x, y, 0.5 * (1.7 * x + 2.9 * y + 2.0).sin())).collect();
    let weights = grid().map(|(x, y)| 10.0_f64.powf(1.5 * (2.1 * x - 4.3 * y + 2.0).cos())).collect();
    let patch = NurbsSurface::bezier((3, 3), points, weights);
    let prepared = prepared_clean(whole(Surface::Nurbs(patch)));
    for (chord, most) in [(0.03, 30.0), (0.003, 3.5)] {
        let mesh = framed(&prepared, chord);
        let (economy, deviation) = (economy(&prepared, &mesh, chord), deviation(&prepared, &mesh, chord));
        assert!(economy.worst() <= most, "{chord}: {economy}");
        assert!(deviation.raw.worst <= 1.0, "{chord}: {deviation}");
    }
}

#[test]
fn bends_do_not_ask_for_triangles() {
    // One polynomial piece with two bends, as a surface of revolution and fitted.
    let profile = [(4.0, 0.0), (24.0, 2.0), (-25.0, 12.0), (29.0, 17.0), (4.0, 20.0)];
    let points: Vec<DVec3> = profile.iter().map(|&(x, z)| DVec3::new(x, 0.0, z)).collect();
    let curve = NurbsCurve3::bezier(points, Vec::new());
    let revolved = Surface::Revolution { frame: Frame3::WORLD, curve };
    let chord = 0.03;
    let mesh_of = |surface: Surface| {
        let prepared = prepared_clean(whole(surface));
        let mesh = framed(&prepared, chord);
        let (economy, deviation) = (economy(&prepared, &mesh, chord), deviation(&prepared, &mesh, chord));
        assert!(economy.worst() <= 1.25 && deviation.raw.worst <= 1.0, "{economy} {deviation}");
    };
    let (fitted, _) = revolved.to_nurbs((0.0, TAU), (0.0, 1.0));
    mesh_of(revolved);
    mesh_of(Surface::Nurbs(fitted));
}

/// A surface that is straight along u, twisted, and bent along v by about `bend`.
fn twisted(bend: f64) -> Surface {
    let points =
        [(0.0, 0.0, 0.0), (0.0, 5.0, bend), (0.0, 10.0, 0.0), (4.0, 0.0, -3.0), (4.0, 5.0, bend), (4.0, 10.0, 3.0)];
    Surface::Nurbs(NurbsSurface::bezier((1, 2), points.map(DVec3::from).to_vec(), Vec::new()))
}

#[test]
fn rows_know_of_cells_that_angles_ask_for() {
    let prepared = prepared_clean(whole(twisted(8.0)));
    let chord = 0.01;
    let [coarse, fine, finest] = [1.5, 0.2, 0.1].map(|angle| {
        let plan = frame::plan(&prepared, &Tolerance { chord, angle, max_edge: None });
        let mesh = common::frame(&prepared, &plan, true).0;
        let deviation = deviation(&prepared, &mesh, chord);
        assert!(deviation.raw.worst <= 1.0, "{angle}: {deviation}");
        check_scene(&mesh).total.triangles
    });
    // Rows for cells as long as the tile would be three and six times as many triangles.
    assert!(fine * 5 <= coarse * 6 && finest * 2 <= coarse * 3, "{coarse} {fine} {finest}");
}

#[test]
fn areas_of_twisted_strips_converge() {
    // One cell along u has normals that are wrong by a constant.
    let surface = twisted(0.2);
    let steps = 200;
    let middle = |k: i32| (f64::from(k) + 0.5) / f64::from(steps);
    let places = (0..steps).flat_map(|i| (0..steps).map(move |j| (middle(i), middle(j))));
    let element = |(u, v)| {
        let d = surface.derivatives(u, v);
        d.du.cross(d.dv).length()
    };
    let exact = places.map(element).sum::<f64>() / f64::from(steps * steps);
    let prepared = prepared_clean(whole(surface));
    for chord in [1e-2, 1e-3, 1e-4] {
        let mesh = framed(&prepared, chord);
        let area = check_scene(&mesh).total.area;
        assert!((area - exact).abs() <= 0.2 * chord * exact, "{chord}: {area} of {exact}");
    }
}
