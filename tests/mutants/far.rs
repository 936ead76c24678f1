//! Files far from the origin -> the meshes that they have at it. In coordinates of 1e10 mm a part has eight
//! digits; no surface may be computed in them.

use crate::parts::{Made, checkout, make};
use crate::points::Points;
use glam::DVec3;
use std::sync::Arc;
use trimtess::frame::Tolerance;
use trimtess::import::step::{StepOptions, read};
use trimtess::model::{DiagnosticKind, Severity, StepOutcome};
use trimtess::prepare::{PrepareOptions, Prepared, prepare};

fn is_far(kind: &DiagnosticKind) -> bool {
    matches!(kind, DiagnosticKind::Step(StepOutcome::FarPart { .. }))
}

/// A file as read, prepared and meshed at a thousandth of its size. Everything must close.
struct Whole {
    unit: f64,
    prepared: Arc<Prepared>,
    made: Made,
    /// Number of diagnostics worse than notes.
    worse: usize,
}

impl Whole {
    fn of(bytes: &[u8]) -> Self {
        let model = read(bytes, &StepOptions::default()).expect("a readable file");
        let unit = model.millimetres_per_unit;
        let prepared = Arc::new(prepare(model, &PrepareOptions::DEFAULT).expect("within the limits"));
        let tolerance = Tolerance { chord: 1e-3 * prepared.diagonal, angle: 0.35, max_edge: None };
        let made = make(&prepared, &tolerance, |_| true);
        assert!(made.faults.is_empty(), "{:?}", made.faults);
        let worse = prepared.diagnostics.iter().filter(|d| d.severity > Severity::Note).count();
        Self { unit, prepared, made, worse }
    }

    fn is_far(&self) -> bool {
        self.prepared.diagnostics.iter().any(|told| is_far(&told.kind))
    }
}

#[test]
fn files_far_from_the_origin_have_the_meshes_that_they_have_at_it() {
    for file in ["nist_ctc05.step", "red_cube_blue_cylinder.step"] {
        let bytes = std::fs::read(checkout().join("tests/data").join(file)).expect("a readable file");
        let near = Whole::of(&bytes);
        assert!(!near.is_far(), "{file}");
        for distance in [1e7, 1e9, 1e10] {
            let shift = distance * DVec3::new(0.9, -0.6, 0.3);
            let far = Whole::of(&Points::of(&bytes).shifted(shift.to_array()));
            assert!(far.is_far() && far.worse <= near.worse, "{file} {distance:e}: {:?}", far.prepared.diagnostics);
            for rung in ["whole tile", "repaired", "filled", "lost"] {
                assert_eq!(far.made.on(rung), near.made.on(rung), "{file} {distance:e}: {rung}");
            }
            let share = far.made.triangles as f64 / near.made.triangles as f64;
            assert!((0.95..1.05).contains(&share), "{file} {distance:e}: {share}");
            let spacing = f64::EPSILON * distance * far.unit;
            let corners = far.prepared.bounds.expect("a box").into_iter().zip(near.prepared.bounds.expect("a box"));
            for (there, here) in corners {
                let off = there.distance(here + shift * far.unit);
                // The box is measured to a thousandth.
                assert!(off < 4.0 * spacing + 1e-3 * near.prepared.diagonal, "{file} {distance:e}: {off}");
            }
        }
    }
}
