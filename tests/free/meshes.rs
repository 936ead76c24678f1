//! Free trims down to triangles: watertight inside, true to the surface and to the exact area in (u,v).

use crate::common::{self, frame};
use crate::draw::{each_configuration, flower};
use crate::polylines::{crossings, refine, segments};
use crate::random::SplitMix;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use std::sync::Arc;
use trimtess::audit::deviation;
use trimtess::frame::internals::edge_line;
use trimtess::frame::{Plan, Tolerance, plan};
use trimtess::mesh::{MemorySink, check_scene};
use trimtess::model::{
    Diagnostic, EdgeId, FaceError, FaceTrouble, FreeTrims, NurbsSurface, PartBuilder, PartId, Severity, ShellKind,
    Surface, TrimCurve, TrimRule, TrimTrouble,
};
use trimtess::parallel::FrameReport;
use trimtess::prepare::{FreeRegion, Prepared, UvDomain};

/// The unit square in space; space coordinates equal its parameters.
pub(crate) fn sheet() -> NurbsSurface {
    let points = vec![DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::new(1.0, 1.0, 0.0)];
    NurbsSurface::bezier((1, 1), points, Vec::new())
}

/// A bicubic sheet over the unit square with an inner knot in v.
fn wave() -> NurbsSurface {
    let height = |i: usize, j: usize| 0.1 * f64::from((i * 7 + j * 5) as u32 % 4);
    let points =
        (0..4).flat_map(|i| (0..5).map(move |j| DVec3::new(i as f64 / 3.0, j as f64 / 4.0, height(i, j)))).collect();
    let knots_u = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    let knots_v = vec![0.0, 0.0, 0.0, 0.0, 0.4, 1.0, 1.0, 1.0, 1.0];
    NurbsSurface { degree_u: 3, degree_v: 3, knots_u, knots_v, points, weights: Vec::new() }
}

pub(crate) fn prepared(surface: Surface, trims: FreeTrims) -> Arc<Prepared> {
    let mut part = PartBuilder::new("part");
    let shell = part.plain_shell(ShellKind::Open);
    part.trimmed_face(surface, shell, trims, false);
    common::prepared(part.finish().unwrap())
}

pub(crate) fn mesh(prepared: &Arc<Prepared>, chord: f64) -> (MemorySink, FrameReport) {
    let plan = plan(prepared, &Tolerance { chord, angle: 0.3, max_edge: None });
    frame(prepared, &plan, false)
}

/// Length of the tessellated boundary of a one-tile sheet, and the area of its polygons.
fn outline(prepared: &Prepared, plan: &Plan) -> (f64, f64) {
    let part = &prepared.parts[0];
    let (mut length, mut area) = (0.0, 0.0);
    for uses in part.tiles.iter().flat_map(|tile| &tile.loops) {
        let mut polygon: Vec<DVec2> = Vec::new();
        for u in uses {
            let points = edge_line(prepared, plan, PartId(0), EdgeId(u.edge.0)).points;
            let breaks = &plan.parts[0].edges[u.edge.index()].breaks;
            let [from, to] = [u.from, u.to].map(|k| breaks[k as usize] as usize);
            let steps: Vec<usize> = if from < to { (from..to).collect() } else { (to + 1..=from).rev().collect() };
            polygon.extend(steps.into_iter().map(|k| points[k].truncate()));
        }
        area += crate::draw::area(&polygon);
        length += (0..polygon.len()).map(|k| polygon[k].distance(polygon[(k + 1) % polygon.len()])).sum::<f64>();
    }
    (length, area)
}

#[test]
fn a_plane_sheet_has_the_area_of_its_region() {
    let circle = TrimCurve::circle(DVec2::splat(0.5), 0.3);
    let trims = FreeTrims { rule: TrimRule::Handedness, curves: vec![circle.reversed()] };
    let prepared = prepared(Surface::Nurbs(sheet()), trims);
    assert!(prepared.diagnostics.is_empty(), "{:?}", prepared.diagnostics);
    for chord in [1e-2, 1e-3, 1e-4, 1e-5] {
        let (sink, report) = mesh(&prepared, chord);
        assert!(report.degraded.is_empty(), "{:?}", report.degraded);
        let facts = check_scene(&sink).total;
        assert!(facts.is_well_formed(), "{facts}");
        assert!((facts.area - (1.0 - PI * 0.09)).abs() <= 2.0 * chord, "{facts}");
        // Only the border and the hole are open.
        let open = 4.0 + 2.0 * PI * 0.3;
        assert!((facts.unbalanced_length - open).abs() <= 0.05 * open, "{facts}");
    }
}

#[test]
fn curved_sheets_keep_the_chord_tolerance_on_surface_and_trim() {
    let curves = vec![
        flower(DVec2::new(0.45, 0.5), 0.3, 5, 0.5).reversed(),
        TrimCurve::circle(DVec2::new(0.8, 0.8), 0.15).reversed(),
        TrimCurve::circle(DVec2::new(0.75, 0.2), 0.22).reversed(),
    ];
    let prepared = prepared(Surface::Nurbs(wave()), FreeTrims { rule: TrimRule::Handedness, curves });
    // One of the circles leaves the domain.
    assert_eq!(prepared.diagnostics.len(), 1);
    let clipped = FaceTrouble::Trim(TrimTrouble::Clipped { curve: 2 });
    assert!(prepared.diagnostics.iter().any(|d| d.kind == clipped.clone().into()), "{:?}", prepared.diagnostics);
    for chord in [1e-2, 1e-3, 1e-4] {
        let (sink, report) = mesh(&prepared, chord);
        assert!(report.degraded.is_empty(), "{:?}", report.degraded);
        assert!(check_scene(&sink).total.is_well_formed());
        let measured = deviation(&prepared, &sink, chord);
        assert!(measured.beyond_gap.worst <= 1.0, "{chord}: {measured}");
        assert!(measured.edges.worst <= 1.0, "{chord}: {measured}");
    }
}

#[test]
fn an_empty_region_has_no_triangles_and_is_no_error() {
    let curves = vec![TrimCurve::circle(DVec2::splat(0.2), 0.1), TrimCurve::circle(DVec2::splat(0.8), 0.1)];
    let prepared = prepared(Surface::Nurbs(sheet()), FreeTrims { rule: TrimRule::Handedness, curves });
    assert_eq!(prepared.diagnostics.len(), 1);
    assert_eq!(prepared.diagnostics[0].severity, Severity::Note);
    assert!(prepared.diagnostics[0].kind.face_error() == Some(&FaceError::NothingKept), "{:?}", prepared.diagnostics);
    assert_eq!(prepared.tiles().count(), 0);
}

/// A thousand small holes in one patch, and one hole of twenty thousand segments.
#[test]
fn crowds_are_meshed() {
    let hole = |k: usize| {
        let cell = DVec2::new((k % 32) as f64 + 0.5, (k / 32) as f64 + 0.5) / 32.0;
        TrimCurve::circle(cell, 0.01).reversed()
    };
    let many = FreeTrims { rule: TrimRule::Handedness, curves: (0..1000).map(hole).collect() };
    let corner = |k: usize| {
        let turn = 2.0 * PI * k as f64 / 20_000.0;
        DVec2::splat(0.5) + DVec2::from_angle(-turn) * (0.3 + 0.1 * (9.0 * turn).sin())
    };
    let long = TrimCurve::polygon((0..20_000).map(corner).collect());
    for (trims, tessellants) in [(many, 4000), (FreeTrims { rule: TrimRule::Handedness, curves: vec![long] }, 20_000)] {
        let exact = FreeRegion::new(&trims, &UvDomain::new(DVec2::ZERO, DVec2::ONE)).unwrap().area();
        let prepared = prepared(Surface::Nurbs(sheet()), trims);
        assert!(prepared.diagnostics.is_empty(), "{:?}", prepared.diagnostics);
        let (sink, report) = mesh(&prepared, 1e-4);
        assert!(report.degraded.is_empty(), "{:?}", report.degraded);
        let facts = check_scene(&sink).total;
        assert!(facts.is_well_formed() && facts.vertices >= tessellants, "{facts}");
        assert!((facts.area - exact).abs() <= 0.01, "{facts}, exact {exact}");
    }
}

/// The paper's §4.1: a point of tangency is recorded, and is a common tessellant of both curves.
#[test]
fn points_of_tangency_are_shared_tessellants() {
    let touch = DVec2::new(0.45, 0.5);
    for other in [TrimCurve::circle(DVec2::new(0.6, 0.5), 0.15), TrimCurve::circle(DVec2::new(0.4, 0.5), 0.05)] {
        let curves = vec![TrimCurve::circle(DVec2::new(0.3, 0.5), 0.15).reversed(), other.reversed()];
        for rule in [TrimRule::Handedness, TrimRule::EvenOdd] {
            let prepared = prepared(Surface::Nurbs(sheet()), FreeTrims { rule, curves: curves.clone() });
            let near = |p: &DVec3| p.truncate().distance(touch) <= 1e-6;
            let part = &prepared.parts[0];
            let at: Vec<DVec3> = part.edges.iter().flat_map(|e| &e.breaks).map(|b| b.point).filter(near).collect();
            // Four arcs end there, or two if the inner loop is redundant.
            assert!(at.len() == 4 || at.len() == 2, "{rule:?}: {at:?}");
            assert!(at.iter().all(|p| p == &at[0]), "{at:?}");
            for chord in [1e-2, 1e-3, 1e-4] {
                let plan = plan(&prepared, &Tolerance { chord, angle: 0.3, max_edge: None });
                judge(&prepared, &plan, &format!("{rule:?} at {chord}"));
            }
        }
    }
}

/// The plan with `n` segments for each segment of the coarsest plan, on its lattice.
fn divided(prepared: &Prepared, n: usize) -> Plan {
    let mut plan = plan(prepared, &Tolerance { chord: f64::INFINITY, angle: f64::INFINITY, max_edge: None });
    for (part, planned) in prepared.parts.iter().zip(&mut plan.parts) {
        for (edge, line) in part.edges.iter().zip(&mut planned.edges).filter(|(edge, _)| !edge.uses.is_empty()) {
            refine(edge, Arc::make_mut(line), |_, least| n * least);
        }
    }
    plan
}

/// Asserts that a sheet's triangles cover the polygons of the tessellants up to rounding and are open only along these.
/// Returns the polygons' length and area.
pub(crate) fn judge(prepared: &Arc<Prepared>, plan: &Plan, case: &str) -> (f64, f64) {
    let (sink, report) = frame(prepared, plan, false);
    assert!(report.degraded.is_empty(), "{case}: {:?}", report.degraded);
    let facts = check_scene(&sink).total;
    assert!(facts.is_well_formed(), "{case}: {facts}");
    let (length, area) = outline(prepared, plan);
    assert!((facts.area - area).abs() <= 1e-12, "{case}: polygons {area}, {facts}");
    assert!((facts.unbalanced_length - length).abs() <= 1e-9, "{case}: outline {length}, {facts}");
    (length, area)
}

/// In every random configuration the triangles cover the polygons of the tessellants up to rounding and are open only
/// along these. The polygons' area converges to the exact area with the square of the number of chords.
#[test]
fn random_configurations_are_meshed_exactly() {
    let domain = UvDomain::new(DVec2::ZERO, DVec2::ONE);
    each_configuration(|seed| {
        let trims = SplitMix(seed).configuration();
        let exact = FreeRegion::new(&trims, &domain).unwrap().area();
        let prepared = prepared(Surface::Nurbs(sheet()), trims);
        let is_told = |d: &&Diagnostic| d.severity == Severity::Note || d.kind.code() == "trim-extended";
        assert!(prepared.diagnostics.iter().all(|d| is_told(&d)), "seed {seed}: {:?}", prepared.diagnostics);
        for chord in [1e-2, 1e-3] {
            let plan = plan(&prepared, &Tolerance { chord, angle: 0.3, max_edge: None });
            let crossings = crossings(&segments(&prepared, &plan));
            assert!(crossings.is_empty(), "seed {seed} at {chord}: {crossings:?}");
            let (length, area) = judge(&prepared, &plan, &format!("seed {seed} at {chord}"));
            // On average two thirds of the tolerance lie between a chord and its curve.
            let slack = chord * length + 1e-6;
            assert!((area - exact).abs() <= slack, "seed {seed} at {chord}: area {area}, exact {exact}");
        }
        let mut errors = Vec::new();
        for n in [1, 2, 8, 16, 32] {
            let plan = divided(&prepared, n);
            let crossings = crossings(&segments(&prepared, &plan));
            assert!(crossings.is_empty(), "seed {seed}, {n} times: {crossings:?}");
            let (length, area) = judge(&prepared, &plan, &format!("seed {seed}, {n} times"));
            errors.push((area - exact) * (n * n) as f64 / length.max(1.0));
        }
        // From some number on, the error times the square of the number is constant.
        let [a, b, c] = [errors[2], errors[3], errors[4]];
        assert!((a - b).abs() <= 0.02 && (b - c).abs() <= 0.02, "seed {seed}: {errors:?}");
    });
}
