//! Parts and models -> prepared, and frames of them.
#![allow(dead_code, reason = "not every test uses all of it")]

use glam::{DVec2, DVec3};
use std::sync::Arc;
use trimtess::frame::Plan;
use trimtess::math::predicates::orient2d;
use trimtess::mesh::MemorySink;
use trimtess::model::{Diagnostic, Model, Part, PartBuilder, ShellKind, Surface};
use trimtess::parallel::{FrameReport, serial};
use trimtess::prepare::{PrepareOptions, Prepared, prepare};

/// An open part of one face: the surface, whole.
pub(crate) fn whole(surface: Surface) -> Part {
    let mut part = PartBuilder::new("whole");
    let shell = part.plain_shell(ShellKind::Open);
    part.plain_face(surface, shell, Vec::new(), false);
    part.finish().expect("a sound part")
}

/// Asserts that `docs/diagnostics.md` has the code of each with its severity.
pub(crate) fn documented(diagnostics: &[Diagnostic]) {
    const TABLE: &str = include_str!("../../docs/diagnostics.md");
    for told in diagnostics {
        let row = TABLE.lines().find_map(|line| line.strip_prefix(&format!("| `{}` | ", told.kind.code())));
        let severities = row.and_then(|row| row.split('|').next());
        let severity = told.severity.name();
        assert!(
            severities.is_some_and(|all| all.contains(severity)),
            "{severity} {}: {severities:?}",
            told.kind.code()
        );
    }
}

/// The model, prepared with the default options. Asserts that its diagnostics are documented.
pub(crate) fn prepared(model: impl Into<Model>) -> Arc<Prepared> {
    let prepared = prepare(model.into(), &PrepareOptions::DEFAULT).expect("within the limits");
    documented(&prepared.diagnostics);
    Arc::new(prepared)
}

/// The same. Asserts that there are no diagnostics.
pub(crate) fn prepared_clean(model: impl Into<Model>) -> Arc<Prepared> {
    let prepared = prepared(model);
    assert!(prepared.diagnostics.is_empty(), "{:?}", prepared.diagnostics);
    prepared
}

/// A frame made by one thread.
pub(crate) fn frame(prepared: &Arc<Prepared>, plan: &Plan, edge_lines: bool) -> (MemorySink, FrameReport) {
    let mut sink = MemorySink::default();
    let report = serial(prepared, &Arc::new(plan.clone()), edge_lines, &mut sink).expect("a frame");
    (sink, report)
}

/// The same. Asserts that no tile is degraded.
pub(crate) fn whole_frame(prepared: &Arc<Prepared>, plan: &Plan, edge_lines: bool) -> MemorySink {
    let (sink, report) = frame(prepared, plan, edge_lines);
    assert!(report.degraded.is_empty(), "{:?}", report.degraded);
    sink
}

/// The same Bézier curve with its degree raised by one.
pub(crate) fn elevated(points: &[DVec3]) -> Vec<DVec3> {
    let n = points.len();
    let at = |k: usize| {
        let share = k as f64 / n as f64;
        points[k.saturating_sub(1)] * share + points[k.min(n - 1)] * (1.0 - share)
    };
    (0..=n).map(at).collect()
}

/// Winding number of a closed polygon about `q`, exact.
pub(crate) fn winding(points: &[DVec2], q: DVec2) -> i32 {
    let turn = |(a, b): (&DVec2, &DVec2)| {
        if a.y <= q.y {
            i32::from(b.y > q.y && orient2d(*a, *b, q) > 0.0)
        } else {
            -i32::from(b.y <= q.y && orient2d(*a, *b, q) < 0.0)
        }
    };
    points.iter().zip(points.iter().cycle().skip(1)).map(turn).sum()
}
