//! Limits of preparing and planning: within them nothing changes, beyond them an error names the limit and the need.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use glam::{DVec2, DVec3};
use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use trimtess::control::{Alone, Control};
use trimtess::frame::{self, BYTES_PER_TRIANGLE, PlanLimits, Tolerance};
use trimtess::model::{
    Coedge, Frame3, FreeTrims, Loop, Model, NurbsSurface, PartBuilder, ShellKind, Surface, TrimCurve, TrimRule, shapes,
};
use trimtess::prepare::{PrepareError, PrepareLimits, PrepareOptions, Prepared, prepare, prepare_on};

const FINE: Tolerance = Tolerance { chord: 1e-3, angle: 0.3, max_edge: None };

fn within(limits: PrepareLimits) -> Result<Prepared, PrepareError> {
    prepare(shapes::by_name("torus").unwrap(), &PrepareOptions::DEFAULT.with_limits(limits))
}

#[test]
fn patches_and_their_memory_are_limited() {
    let patches = |patches| within(PrepareLimits::DEFAULT.with_patches(patches));
    assert!(patches(16).unwrap().diagnostics.is_empty());
    let error = patches(15).unwrap_err();
    assert_eq!(error, PrepareError::TooManyPatches { limit: 15, needed: 16 });
    assert!(error.to_string().contains("16 B") && error.to_string().contains("PrepareLimits::patches"), "{error}");
    // 16 biquadratic patches of 9 control points of 32 bytes, the model, tiles and their borders.
    let bytes = |bytes| within(PrepareLimits::DEFAULT.with_bytes(bytes));
    assert!(bytes(1_000_000).is_ok());
    let error = bytes(16 * 9 * 32).unwrap_err();
    assert_eq!(error, PrepareError::TooMuchMemory { limit: 4608, patches: 16 });
    assert!(error.to_string().contains("PrepareLimits::bytes"), "{error}");
}

#[test]
fn options_out_of_range_are_refused() {
    for asked in [f64::NAN, -1e-6, 1.5, f64::INFINITY] {
        let options = PrepareOptions::DEFAULT.with_border_tolerance(asked);
        let error = prepare(shapes::by_name("torus").unwrap(), &options).unwrap_err();
        assert_eq!(error.to_string(), PrepareError::BorderTolerance { asked }.to_string());
    }
}

#[test]
fn a_surface_of_more_patches_than_memory_holds_is_refused_before_it_is_cut() {
    // 40 000 bilinear patches: a megabyte in the model, eighty once they are cut.
    let side = 200;
    let grid = (0..side).flat_map(|i| (0..side).map(move |j| (f64::from(i), f64::from(j))));
    let points = grid.map(|(x, y)| DVec3::new(x, y, (x * y).sin())).collect();
    let knots: Vec<f64> = (0..side + 2).map(|k| f64::from((k - 1).clamp(0, side - 1))).collect();
    let net =
        NurbsSurface { degree_u: 1, degree_v: 1, knots_u: knots.clone(), knots_v: knots, points, weights: vec![] };
    let model = Model::from(common::whole(Surface::Nurbs(net)));
    let options = PrepareOptions::DEFAULT.with_limits(PrepareLimits::DEFAULT.with_bytes(20 << 20));
    let error = prepare(model, &options).unwrap_err();
    assert_eq!(error, PrepareError::TooMuchMemory { limit: 20 << 20, patches: 199 * 199 });
}

#[test]
fn free_trims_that_need_more_memory_than_the_limit_are_refused_before_they_are_cut() {
    // 2000 corners: 32 kB in the model, a hundred times that as edges.
    let corners = 2000_u32;
    let corner = |k: u32| DVec2::from_angle(TAU * f64::from(k) / f64::from(corners));
    let trims =
        FreeTrims { rule: TrimRule::NonZero, curves: vec![TrimCurve::polygon((0..corners).map(corner).collect())] };
    let mut part = PartBuilder::new("disk");
    let shell = part.plain_shell(ShellKind::Open);
    part.trimmed_face(Surface::Plane { frame: Frame3::WORLD }, shell, trims, false);
    let model = Model::from(part.finish().unwrap());
    let within = |bytes: u64| {
        let drafted = Arc::new(AtomicU64::new(0));
        let told = drafted.clone();
        let control = Control::observed_by(move |progress| {
            told.fetch_max(progress.done, Ordering::Relaxed);
        });
        let options = PrepareOptions::DEFAULT.with_limits(PrepareLimits::DEFAULT.with_bytes(bytes));
        (prepare_on(&Alone, &model, &options, &control), drafted.load(Ordering::Relaxed))
    };
    let (error, drafted) = within(500_000);
    assert_eq!((error.unwrap_err(), drafted), (PrepareError::TooMuchMemory { limit: 500_000, patches: 1 }, 0));
    let (prepared, drafted) = within(20_000_000);
    assert!(prepared.unwrap().diagnostics.is_empty() && drafted == 1);
}

#[test]
fn a_plan_beyond_its_limits_is_refused_or_coarser_as_the_caller_chooses() {
    let prepared = within(PrepareLimits::DEFAULT).unwrap();
    let free = frame::plan(&prepared, &FINE).require_full().unwrap();
    let cells = |plan: &frame::Plan| -> u64 {
        let tiles = plan.parts.iter().flat_map(|part| &part.tiles).map(|lattice| lattice.cells());
        tiles.map(|(nu, nv)| u64::from(nu) * u64::from(nv)).sum()
    };
    // Boundaries make triangles too.
    let tessellants: usize = free.parts.iter().flat_map(|part| &part.edges).map(|edge| edge.ts.len()).sum();
    let (all, most) = (2 * (cells(&free) + tessellants as u64), free.parts[0].tiles.iter().map(|t| t.cells()));
    let most = 2 * most.map(|(nu, nv)| u64::from(nu) * u64::from(nv)).max().unwrap();
    let short = |limits: PlanLimits| frame::plan_within(&prepared, &FINE, &limits).require_full().unwrap_err();

    let triangles = short(PlanLimits::DEFAULT.with_triangles(all / 3));
    assert!(triangles.density < 1.0 && triangles.needed == all, "{triangles}");
    let told = triangles.to_string();
    assert!(told.contains(&all.to_string()) && told.contains("PlanLimits::triangles)"), "{told}");

    // The prepared model stays in memory next to the mesh.
    let held = u64::from(triangles.held_mib) << 20;
    let memory = short(PlanLimits::DEFAULT.with_bytes(held + all / 3 * BYTES_PER_TRIANGLE));
    assert!(memory.density < 1.0 && memory.to_string().contains("PlanLimits::bytes"), "{memory}");
    let enough = PlanLimits::DEFAULT.with_bytes(held + all * BYTES_PER_TRIANGLE);
    assert!(frame::plan_within(&prepared, &FINE, &enough).shortfall.is_none());

    let limits = PlanLimits::DEFAULT.with_triangles_per_tile(most / 3);
    let tile = short(limits);
    assert!(!tile.tiles.is_empty() && tile.density == 1.0, "{tile}");
    assert!(tile.to_string().contains("PlanLimits::triangles_per_tile"), "{tile}");

    // A caller that accepts the plan gets a coarser mesh within the limits.
    let coarse = frame::plan_within(&prepared, &FINE, &limits);
    assert!(2 * cells(&coarse) < all && coarse.shortfall.is_some());
}

#[test]
fn a_surface_that_no_number_of_lines_follows_has_a_million_cells_at_most() {
    let mut model = shapes::by_name("wave").unwrap();
    let Surface::Nurbs(net) = &mut model.parts[0].faces[0].surface else { panic!("a wave is a spline") };
    net.points[5].z = 1e5;
    let prepared = prepare(model, &PrepareOptions::DEFAULT).unwrap();
    let plan = frame::plan(&prepared, &FINE);
    let cells = plan.parts[0].tiles[0].cells();
    assert!(u64::from(cells.0) * u64::from(cells.1) <= 1 << 20, "{cells:?}");
    let short = plan.shortfall.expect("a coarser plan");
    assert!(!short.lines.is_empty() && !short.by_limits(), "{short}");
}

/// A unit square whose loop lists its first edge `again` times more, there and back or always there.
fn square_with_a_repeated_edge(again: usize, back: bool) -> Model {
    let mut model = shapes::by_name("square").unwrap();
    let Loop::Edges(uses) = &mut model.parts[0].faces[0].loops[0] else { panic!("a square has edges") };
    let first = uses[0];
    let use_of = |k: usize| Coedge { reversed: first.reversed != (back && k.is_multiple_of(2)), ..first };
    uses.splice(1..1, (0..again).map(use_of));
    model
}

#[test]
fn an_edge_listed_thousands_of_times_costs_no_more_than_as_many_edges() {
    for back in [false, true] {
        let start = std::time::Instant::now();
        let prepared = prepare(square_with_a_repeated_edge(8000, back), &PrepareOptions::default()).expect("no limit");
        assert!(!prepared.diagnostics.is_empty(), "a loop that lists an edge again is not sound");
        // It takes one second of a processor; without bounds it took forty and 2.4 GB.
        assert!(start.elapsed().as_secs() < 30, "{back}: {:?}", start.elapsed());
    }
}
