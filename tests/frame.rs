//! Plans and tiles: tolerances are kept at every size and scale; absurd ones are reported and limited.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::prepared_clean;
use glam::{DAffine3, DQuat, DVec2, DVec3};
use std::sync::Arc;
use trimtess::audit::{DeviationReport, deviation};
use trimtess::frame::internals::evaluate::evaluate_points;
use trimtess::frame::internals::{Scratch, tessellate_tile};
use trimtess::frame::{self, Degradation, Plan, PlanLimits, Rung, Tolerance};
use trimtess::mesh::{MemorySink, MeshLists, Origin, check_scene};
use trimtess::model::{
    EdgeId, FaceId, Frame3, Loop, ModelBuilder, PartBuilder, PartId, RowId, ShellKind, Surface, SurfaceKind, TileId,
    shapes,
};
use trimtess::parallel::internals::{Load, deal, loads};
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::{PrepareOptions, Prepared, prepare};

const CHORD: Tolerance = Tolerance { chord: 0.1, angle: 1.5, max_edge: None };

fn shape(name: &str) -> Arc<Prepared> {
    prepared_clean(shapes::by_name(name).unwrap())
}

fn mesh(prepared: &Arc<Prepared>, plan: &Plan) -> MemorySink {
    let (sink, report) = common::frame(prepared, plan, true);
    assert!(report.degraded.is_empty() && report.lost_lines.is_empty(), "{:?}", report.degraded);
    sink
}

fn assert_kept(name: &str, report: &DeviationReport) {
    assert!(report.beyond_gap.worst <= 1.0 && report.edges.worst <= 1.0, "{name}: {report}");
    assert!(report.beyond_gap.samples > 100, "{name}: {report}");
}

#[test]
fn every_halving_of_the_tolerance_is_kept() {
    for name in ["sphere", "torus", "cylinder", "cone"] {
        let prepared = shape(name);
        let mut triangles = 0;
        for k in 0..8 {
            let tolerance = Tolerance { chord: 0.5 * 0.5_f64.powi(k), ..CHORD };
            let plan = frame::plan(&prepared, &tolerance);
            assert_eq!(plan.shortfall, None, "{name}");
            let mesh = mesh(&prepared, &plan);
            let report = deviation(&prepared, &mesh, tolerance.chord);
            assert_kept(name, &report);
            assert!(check_scene(&mesh).total.is_closed(), "{name} at {}", tolerance.chord);
            assert!(report.triangles >= triangles, "{name}: {report}");
            triangles = report.triangles;
        }
    }
}

#[test]
fn a_scaled_part_keeps_the_tolerance_where_it_stands() {
    let size = 100.0;
    let mut model = shapes::by_name("cylinder").unwrap();
    let turn = DQuat::from_rotation_x(0.3);
    let large = DAffine3::from_scale_rotation_translation(DVec3::splat(size), turn, DVec3::X * 7.0);
    let small = model.instances[0].clone();
    model.instances.push(trimtess::model::Instance { transform: large, ..small });
    let prepared = prepared_clean(model);
    let plan = frame::plan(&prepared, &Tolerance { max_edge: Some(300.0), ..CHORD });
    let alone = frame::plan(&shape("cylinder"), &Tolerance { chord: 0.1 / size, max_edge: Some(3.0), ..CHORD });
    assert_eq!(plan.parts[0].edges.len(), alone.parts[0].edges.len());
    let most = |plan: &Plan| plan.parts[0].edges.iter().map(|e| e.ts.len()).max().unwrap();
    assert_eq!(most(&plan), most(&alone));
    let mesh = mesh(&prepared, &plan);
    let report = deviation(&prepared, &mesh, CHORD.chord);
    assert_kept("scaled cylinder", &report);
    // The audit measures in part coordinates; in the world, measure by the radius.
    let radius = |p: DVec3| size * p.truncate().length();
    let sides = mesh.batches.iter().flat_map(|b| b.mesh.triangles.iter().map(move |t| (b, t)));
    let low = sides
        .map(|(b, t)| t.map(|v| b.mesh.positions[v as usize]))
        .filter(|t| t.iter().all(|&p| radius(p) > 0.999_999 * size * 5.0))
        .map(|[a, b, c]| radius((a + b) / 2.0).min(radius((b + c) / 2.0)).min(radius((c + a) / 2.0)))
        .fold(f64::INFINITY, f64::min);
    let sagitta = size * 5.0 - low;
    assert!(sagitta <= CHORD.chord && sagitta > 0.5 * CHORD.chord, "{sagitta}");
}

#[test]
fn absurd_tolerances_stay_within_the_limits_and_are_reported() {
    let limits = PlanLimits::DEFAULT.with_triangles_per_tile(2000).with_triangles(40_000);
    let cost = |plan: &Plan| {
        let cells = |p: &frame::internals::PartPlan| -> u64 {
            let tiles = p.tiles.iter().map(|t| u64::from(t.cells().0) * u64::from(t.cells().1)).sum::<u64>();
            tiles + p.edges.iter().map(|e| e.ts.len() as u64).sum::<u64>()
        };
        plan.parts.iter().map(cells).sum::<u64>()
    };
    for name in ["sphere", "torus", "cylinder", "cone", "washer"] {
        let prepared = shape(name);
        let bad = [0.0, -1.0, f64::NAN, 1e-300];
        let all = bad.map(|x| [(x, 0.3, None), (0.1, x, None), (0.1, 0.3, Some(x))]).concat();
        for (chord, angle, max_edge) in all {
            let plan = frame::plan_within(&prepared, &Tolerance { chord, angle, max_edge }, &limits);
            let short = plan.shortfall.as_ref().unwrap();
            assert!(short.unusable, "{name}: {short}");
            assert!(2 * cost(&plan) <= limits.triangles, "{name}: {}", cost(&plan));
            for tile in plan.parts.iter().flat_map(|p| &p.tiles) {
                let (nu, nv) = tile.cells();
                assert!(2 * u64::from(nu) * u64::from(nv) <= limits.triangles_per_tile, "{name}: {nu} × {nv}");
                assert!(tile.us.is_sorted_by(|a, b| a < b) && tile.vs.is_sorted_by(|a, b| a < b));
            }
            assert!(check_scene(&mesh(&prepared, &plan)).total.is_closed(), "{name}: {short}");
        }
        // Small, but usable: only the number of cells is reported.
        let plan = frame::plan_within(&prepared, &Tolerance { chord: 1e-7, ..CHORD }, &limits);
        let short = plan.shortfall.as_ref().unwrap();
        assert!(
            !short.unusable && (short.density < 1.0 || !short.tiles.is_empty() || !short.lines.is_empty()),
            "{name}: {short}"
        );
        let triangles = 2 * cost(&plan);
        assert!(triangles <= limits.triangles && triangles > limits.triangles_per_tile / 4, "{name}: {}", cost(&plan));
        assert_eq!(frame::plan(&prepared, &Tolerance { chord: f64::INFINITY, ..CHORD }).shortfall, None);
    }
}

#[test]
fn as_many_lines_as_a_tolerance_needs_are_made_or_missed_by_limits() {
    // More than 4096 lines between two creases are noise at other tolerances.
    let cylinder = shape("cylinder");
    let mut part = PartBuilder::new("strip");
    let corners = [(0.0, 0.0), (12_000.0, 0.0), (12_000.0, 2.0), (0.0, 2.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let shell = part.plain_shell(ShellKind::Open);
    let boundary = vec![Loop::Edges(part.polygon(&corners))];
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, boundary, false);
    let strip = prepared_clean(part.finish().unwrap());
    let fine = |max_edge: f64| Tolerance { chord: 0.1, angle: 0.3, max_edge: Some(max_edge) };
    for (prepared, tolerance) in
        [(&cylinder, Tolerance { chord: 1e-7, ..CHORD }), (&strip, fine(4.0)), (&strip, fine(0.6))]
    {
        let plan = frame::plan(prepared, &tolerance);
        assert_eq!(plan.shortfall, None, "{tolerance:?}");
        let lines = plan.parts[0].tiles.iter().map(|tile| tile.us.len().max(tile.vs.len())).max().unwrap();
        assert!(lines > 4097, "{lines} lines at {tolerance:?}");
    }
    let short = frame::plan(&strip, &fine(0.3)).shortfall.unwrap();
    assert!(short.unusable && short.by_limits() && short.lines.len() == 1 && !short.edges.is_empty(), "{short}");
}

#[test]
fn a_closed_edge_has_at_least_three_segments() {
    let prepared = shape("cylinder");
    let plan = frame::plan(&prepared, &Tolerance { chord: f64::INFINITY, angle: 9.0, max_edge: None });
    let closed: Vec<usize> = prepared.parts[0]
        .edges
        .iter()
        .zip(&plan.parts[0].edges)
        .filter(|(edge, _)| edge.breaks[0].point == edge.breaks[edge.breaks.len() - 1].point)
        .map(|(_, line)| line.ts.len() - 1)
        .collect();
    assert!(!closed.is_empty() && closed.iter().all(|&segments| segments >= 3), "{closed:?}");
}

#[test]
fn a_tile_whose_boundary_cancels_is_empty() {
    let mut prepared = prepare(shapes::by_name("box").unwrap(), &PrepareOptions::DEFAULT).expect("within the limits");
    let plan = frame::plan(&prepared, &CHORD);
    let tile = |prepared: &Prepared| {
        let outcome = tessellate_tile(prepared, &plan, (PartId(0), TileId(0)), MeshLists::ALL, &mut Scratch::default());
        assert!(outcome.mesh.triangles.is_empty());
        (outcome.rung, outcome.degradation)
    };
    // The first face folded to its diagonal: its parameters enclose an area, its edges cancel.
    let part = Arc::make_mut(&mut Arc::make_mut(&mut prepared.parts)[0]);
    let uses: Vec<usize> = part.tiles[0].loops.iter().flatten().map(|u| u.edge.index()).collect();
    for edge in uses {
        let breaks = &mut part.edges[edge].breaks;
        breaks.iter_mut().for_each(|b| b.point = if b.point == DVec3::ZERO { DVec3::X } else { DVec3::ONE });
    }
    for used in part.tiles[0].loops.iter_mut().flatten() {
        used.start.0 = part.edges[used.edge.index()].breaks[used.from as usize].point;
    }
    assert_eq!(tile(&prepared), (Rung::NoArea, Some(Degradation::Empty)));
    // A face without loops is no loss.
    let part = Arc::make_mut(&mut Arc::make_mut(&mut prepared.parts)[0]);
    part.tiles[0].loops.clear();
    part.edges.iter_mut().for_each(|e| e.uses.retain(|u| u.tile != TileId(0)));
    assert_eq!(tile(&prepared), (Rung::NoArea, Some(Degradation::Empty)));
}

#[test]
fn a_panic_costs_the_inside_of_its_tile_or_a_line_and_neither_frame_nor_session() {
    let frames = |broken: Prepared, plan: &Plan, workers: usize| {
        let options = SessionOptions::DEFAULT.with_workers(workers);
        let mut session = Session::start(Arc::new(broken), &options).unwrap();
        [0, 1].map(|_| {
            let mut sink = MemorySink::default();
            let report = session.frame(plan.clone(), &mut sink).unwrap();
            (sink, report)
        })
    };
    // The last have more workers than tiles.
    for (name, workers) in [("cylinder", 1), ("cone", 3), ("sphere", 64), ("torus", 64)] {
        let prepared = shape(name);
        let plan = frame::plan(&prepared, &CHORD);
        let sound = mesh(&prepared, &plan);
        // Tiles of planes are made of their edges alone.
        let is_curved = |&face: &usize| prepared.parts[0].faces[face].kind != SurfaceKind::Plane;
        for face in (0..prepared.parts[0].faces.len()).filter(is_curved) {
            // Half of the surface is missing: the boundaries of its tiles are filled, and join their neighbours.
            let mut broken = Prepared::clone(&prepared);
            let patches =
                Arc::make_mut(&mut Arc::make_mut(&mut Arc::make_mut(&mut broken.parts)[0]).faces[face].patches);
            patches.control.truncate(patches.control.len() / 2);
            for (sink, report) in frames(broken, &plan, workers) {
                assert!(check_scene(&sink).total.is_closed(), "{name}, face {face}");
                assert!(!report.degraded.is_empty() && report.lost_lines.is_empty(), "{name}, face {face}");
                for tile in &report.degraded {
                    let Degradation::Filled(why) = &tile.degradation else { panic!("{name}: {tile:?}") };
                    assert!(tile.face == FaceId::new(face) && why.starts_with("internal error: "), "{name}: {why}");
                }
                for sound in &sound.batches {
                    let is_filled = report.degraded.iter().any(|tile| tile.tile == sound.tile);
                    let made = sink.batches.iter().find(|made| made.tile == sound.tile);
                    assert!(is_filled || made.is_some_and(|made| made.mesh == sound.mesh), "{name}, face {face}");
                }
            }
        }
    }
    // A tile whose edges are missing too is lost; an edge without ends has no polyline.
    let prepared = shape("box");
    let mut broken = Prepared::clone(&prepared);
    let part = Arc::make_mut(&mut Arc::make_mut(&mut broken.parts)[0]);
    part.tiles[2].loops[0][0].edge = RowId(99);
    part.edges[0].breaks.clear();
    for (sink, report) in frames(broken, &frame::plan(&prepared, &CHORD), 3) {
        assert_eq!((report.ladder.count(Rung::Lost), sink.batches.len(), sink.edge_lines.len()), (1, 5, 11));
        let [lost] = &report.lost_lines[..] else { panic!("{:?}", report.lost_lines) };
        assert!(lost.edge == EdgeId(0) && lost.why.starts_with("internal error: "), "{lost:?}");
        let [lost] = &report.degraded[..] else { panic!("{:?}", report.degraded) };
        let Degradation::Failed(why) = &lost.degradation else { panic!("{lost:?}") };
        assert!(lost.tile == TileId(2) && why.starts_with("internal error: "), "{lost:?}");
    }
}

#[test]
fn tiles_are_weighed_and_dealt_where_they_are_placed() {
    // A wave among boxes, all along x.
    let mut model = ModelBuilder::new("row");
    let mut x = 0.0;
    for part in [shapes::cuboid(), shapes::wave(), shapes::cuboid(), shapes::cuboid()] {
        x += 100.0;
        let part = model.part(part);
        model.place(part, DAffine3::from_translation(DVec3::X * x));
    }
    let prepared = prepared_clean(model.finish().unwrap());
    let loads = loads(&prepared);
    let places = prepared.tiles().map(|(part, _, tile)| tile.centre + DVec3::X * 100.0 * f64::from(part.0 + 1));
    assert!(loads.iter().map(|load| load.centre).eq(places));
    // All squares weigh the same, a bicubic patch much more.
    let flat = loads[0].weight;
    let (waves, boxes): (Vec<&Load>, Vec<&Load>) = loads.iter().partition(|load| load.weight > 3.0 * flat);
    assert!(flat > 0.0 && waves.len() == 1 && boxes.iter().all(|load| load.weight == flat), "{loads:?}");
    // The worker with the patch gets no box before the other has as much weight.
    let hands = deal(&loads, 2, 2);
    let sums = hands.iter().map(|hand| hand.iter().map(|&k| loads[k].weight).sum::<f64>());
    let (least, most) = sums.fold((f64::INFINITY, 0.0_f64), |(least, most), sum| (least.min(sum), most.max(sum)));
    assert!(most - least <= flat, "{hands:?}");
}

#[test]
fn lattice_vertices_have_the_bits_of_single_points() {
    for name in ["torus", "wave", "washer"] {
        let prepared = shape(name);
        let plan = frame::plan(&prepared, &Tolerance { chord: 1e-3, ..CHORD });
        let mut seen = 0;
        for batch in &mesh(&prepared, &plan).batches {
            let part = &prepared.parts[batch.part.index()];
            let face = part.face_of(&part.tiles[batch.tile.0 as usize]);
            let lattice = &plan.parts[batch.part.index()].tiles[batch.tile.0 as usize];
            for (k, origin) in batch.mesh.origins.iter().enumerate() {
                let Origin::Lattice { i, j } = *origin else { continue };
                let at = [DVec2::new(lattice.us[i as usize], lattice.vs[j as usize])];
                let side = if face.reversed { -1.0 } else { 1.0 };
                evaluate_points(&face.patches, &at, &mut |_, points| {
                    let on_mesh = (batch.mesh.positions[k], batch.mesh.normals[k]);
                    let on_surface = points.iter().map(|(position, normal)| (position, (normal * side).as_vec3()));
                    assert!(on_surface.eq([on_mesh]), "{name}");
                });
                seen += 1;
            }
        }
        assert!(name == "washer" || seen > 100, "{name}: {seen}");
    }
}
