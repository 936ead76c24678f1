//! Faces whose loops do not bound a simple region -> what it took to close them, and a warning where it shows.

use crate::report::{entity_of, tile_centre};
use serde::Serialize;
use std::collections::BTreeMap;
use trimtess::mesh::{MemorySink, Scene};
use trimtess::model::{Diagnostic, FaceId, PartId, Severity};
use trimtess::parallel::{FaceFill, FrameReport};
use trimtess::prepare::Prepared;

/// Share of a face's area that may be wound other than once before it is a warning. Noise of a boundary stays far below.
const TOLERATED: f64 = 1e-4;

/// A face that took more than its own triangles to close. `face` runs over all instances, as `face_id` does in a PLY.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Fill {
    pub(crate) face: u64,
    /// Triangles that only close it.
    pub(crate) slivers: u32,
    /// Area that its loops wind around other than once, mm² of the part.
    pub(crate) rewound: f64,
}

/// All such faces, instance by instance.
pub(crate) fn placed(made: &FrameReport, scene: &Scene) -> Vec<Fill> {
    let fills = |part: u32| made.fills.iter().filter(move |fill| fill.part.0 == part);
    let placed = scene.instances.iter().flat_map(|instance| {
        fills(instance.part).map(|&FaceFill { face, slivers, rewound, .. }| Fill {
            face: u64::from(instance.first_face) + u64::from(face.0),
            slivers,
            rewound,
        })
    });
    placed.collect()
}

/// A warning for each face of which more than a ten-thousandth is wound other than once.
pub(crate) fn add_rewound(all: &mut Vec<Diagnostic>, made: &FrameReport, frame: &MemorySink, prepared: &Prepared) {
    let rewound = || made.fills.iter().filter(|fill| fill.rewound > 0.0);
    let mut areas: BTreeMap<(PartId, FaceId), f64> = rewound().map(|fill| ((fill.part, fill.face), 0.0)).collect();
    for batch in &frame.batches {
        let Some(area) = areas.get_mut(&(batch.part, batch.face)) else { continue };
        let at = |corner: u32| batch.mesh.positions[corner as usize];
        let triangles = batch.mesh.triangles.iter().map(|corners| corners.map(at));
        *area += triangles.map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum::<f64>();
    }
    let visible = rewound().map(|fill| (fill, areas[&(fill.part, fill.face)]));
    all.extend(visible.filter(|(fill, area)| fill.rewound > TOLERATED * area).map(|(fill, area)| Diagnostic {
        severity: Severity::Warning,
        part: Some(fill.part),
        face: Some(fill.face),
        entity: entity_of(prepared, fill.part, fill.face),
        place: tile_centre(prepared, fill.part, fill.face),
        reason: format!("{:.3e} mm² of its {area:.3e} mm² are wound other than once", fill.rewound),
    }));
}
