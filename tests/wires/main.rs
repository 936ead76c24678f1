//! Faces with faulty wires: crossing, overlapping, doubled, reversed, without area, not closed. Each yields the
//! triangles of the region of positive winding and a diagnostic with a place. No face is lost.

#[path = "../common/mod.rs"]
mod common;
mod crossing;
mod gaps;
#[path = "../sequence/random.rs"]
mod random;
mod sewing;
mod turns;

use common::{frame, prepared};
use glam::DVec3;
use std::sync::Arc;
use trimtess::frame::{Tolerance, plan};
use trimtess::mesh::{MeshFacts, check_scene};
use trimtess::model::{
    DiagnosticKind, FaceTrouble, Frame3, Loop, Part, PartBuilder, Severity, ShellKind, Surface, WireTrouble,
};
use trimtess::parallel::FrameReport;
use trimtess::prepare::Prepared;

/// Chords: base, /4, /16, /32.
pub(crate) const CHORDS: [f64; 4] = [0.2, 0.05, 0.0125, 0.00625];

pub(crate) fn mesh(prepared: &Arc<Prepared>, chord: f64) -> (MeshFacts, FrameReport) {
    let plan = plan(prepared, &Tolerance { chord, angle: 0.5, max_edge: None });
    let (sink, report) = frame(prepared, &plan, false);
    let facts = check_scene(&sink);
    assert_eq!(facts.faces_without_triangles, [], "chord {chord}: {:?} {:?}", prepared.diagnostics, report.degraded);
    assert!(facts.total.is_well_formed(), "chord {chord}: {}", facts.total);
    (facts.total, report)
}

/// Severity and kind of all diagnostics. Asserts that each names its face and a place.
pub(crate) fn told(prepared: &Prepared) -> Vec<(Severity, DiagnosticKind)> {
    prepared
        .diagnostics
        .iter()
        .map(|d| {
            assert!(d.face.is_some() && d.place.is_some_and(DVec3::is_finite), "{d:?}");
            (d.severity, d.kind.clone())
        })
        .collect()
}

pub(crate) fn warned(prepared: &Prepared, of: impl Fn(&DiagnosticKind) -> bool) -> bool {
    told(prepared).iter().any(|(severity, kind)| *severity == Severity::Warning && of(kind))
}

pub(crate) fn crosses(kind: &DiagnosticKind) -> bool {
    matches!(kind, DiagnosticKind::Face(FaceTrouble::Crosses | FaceTrouble::LobesTurned { .. }))
}

pub(crate) fn gaps(kind: &DiagnosticKind) -> bool {
    matches!(kind, DiagnosticKind::Wire(WireTrouble::VerticesMoved { .. } | WireTrouble::Bridged { .. }))
}

pub(crate) fn one_lobe(kind: &DiagnosticKind) -> bool {
    matches!(kind, DiagnosticKind::Face(FaceTrouble::LobesTurned { lobes: 1, .. }))
}

pub(crate) fn out_of_order(kind: &DiagnosticKind) -> bool {
    matches!(kind, DiagnosticKind::Wire(WireTrouble::Reordered { .. }))
}

pub(crate) fn one_turned(kind: &DiagnosticKind) -> bool {
    matches!(kind, DiagnosticKind::Wire(WireTrouble::Reordered { turned: 1, .. }))
}

pub(crate) fn flat(points: &[(f64, f64)]) -> Vec<DVec3> {
    points.iter().map(|&(x, y)| DVec3::new(x, y, 0.0)).collect()
}

/// A plane face with one wire per polygon.
pub(crate) fn sheet(wires: &[&[(f64, f64)]]) -> Part {
    let mut part = PartBuilder::new("sheet");
    let shell = part.plain_shell(ShellKind::Open);
    let loops = wires.iter().map(|w| Loop::Edges(part.polygon(&flat(w)))).collect();
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, loops, false);
    part.finish().expect("a sound part")
}

/// Asserts that a plane face has this area at all chords. Returns the prepared part and the report of the finest frame.
pub(crate) fn assert_area(part: Part, area: f64) -> (Arc<Prepared>, FrameReport) {
    let prepared = prepared(part);
    let mut last = FrameReport::default();
    for chord in CHORDS {
        let (facts, report) = mesh(&prepared, chord);
        assert!((facts.area - area).abs() <= 1e-9 * area, "chord {chord}: area {} of {area}", facts.area);
        last = report;
    }
    (prepared, last)
}

pub(crate) const PLATE: [(f64, f64); 4] = [(0.0, 0.0), (10.0, 0.0), (10.0, 8.0), (0.0, 8.0)];
