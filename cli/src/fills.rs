//! Faces whose loops do not bound a simple region -> slivers and rewound area per placed face.

use crate::report::rows_of;
use serde::Serialize;
use trimtess::mesh::Scene;
use trimtess::parallel::{FaceFill, FrameReport};

/// A face with slivers or rewound area. `face_id` is numbered across all instances, as in a PLY file.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Fill {
    pub(crate) face_id: u64,
    /// Triangles that only close the face.
    pub(crate) slivers: u32,
    /// Area whose winding number is not 1, mm² of the part.
    pub(crate) rewound: f64,
}

/// Fills of all faces, instance by instance.
pub(crate) fn placed(made: &FrameReport, scene: &Scene) -> Vec<Fill> {
    let placed = scene.instances.iter().flat_map(|instance| {
        rows_of(&made.fills, instance.part, |fill| fill.part).iter().map(
            |&FaceFill { face, slivers, rewound, .. }| Fill {
                face_id: instance.face_number(face).into(),
                slivers,
                rewound,
            },
        )
    });
    placed.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Report;
    use std::sync::Arc;
    use trimtess::frame::{Tolerance, plan};
    use trimtess::mesh::MemorySink;
    use trimtess::model::{FaceId, PartId, Severity, shapes};
    use trimtess::parallel::serial;
    use trimtess::prepare::{PrepareOptions, prepare};

    #[test]
    fn slivers_are_counted_per_face_and_rewound_area_is_a_warning() {
        let model = shapes::by_name("box").expect("a shape");
        let prepared = Arc::new(prepare(model, &PrepareOptions::DEFAULT).expect("within the limits"));
        let plan = plan(&prepared, &Tolerance { chord: 0.1, angle: 0.5, max_edge: None });
        let mut frame = MemorySink::default();
        let mut made = serial(&prepared, &Arc::new(plan), false, &mut frame).expect("a frame");
        let mut instance = frame.scene.instances[0].clone();
        instance.first_face = 6;
        frame.scene.instances.push(instance);
        let fill =
            |face: u32, slivers: u32, rewound: f64| FaceFill { part: PartId(0), face: FaceId(face), slivers, rewound };
        made.fills = vec![fill(1, 3, 0.0), fill(2, 0, 1e-9), fill(4, 2, 1e3)];
        let report = Report::of(&frame, &prepared, &made);
        assert_eq!(report.slivers, 10, "each instance counts");
        let text = report.summary();
        assert!(text.contains("10 slivers that only close 4 faces"), "{text}");
        let faces: Vec<(u64, u32)> = report.fills.iter().map(|fill| (fill.face_id, fill.slivers)).collect();
        assert_eq!(faces, [(1, 3), (2, 0), (4, 2), (7, 3), (8, 0), (10, 2)]);
        let told: Vec<_> = report.diagnostics.iter().map(|e| (e.severity, e.face_id, e.place.is_some())).collect();
        assert_eq!(
            told,
            [(Severity::Warning, Some(4), true), (Severity::Warning, Some(10), true)],
            "{:?}",
            report.diagnostics
        );
    }
}
