//! A model, and a tolerance or a view -> the tolerance of each part, for the threads that plan it.

use crate::frame::tolerance::part_camera::{PartCamera, SightLens};
use crate::frame::tolerance::{PartTolerance, Tolerance};
use crate::math::keyed::Buckets;
use crate::mesh::SceneInstance;
use crate::prepare::Prepared;
use crate::prepare::internals::PreparedPart;
use crate::view::View;
use glam::{DAffine3, DVec3};
use std::sync::{Arc, OnceLock};

/// What plans read of a model besides its parts, in flat lists: after a frame none of it is in a cache. All plans of a
/// model can share it.
#[derive(Debug, Default)]
pub(crate) struct PlanModel {
    pub(super) parts: Arc<Vec<Arc<PreparedPart>>>,
    /// Number of tiles of each part.
    pub(super) tiles: Vec<usize>,
    /// Number of edges of each part.
    pub(super) edges: Vec<usize>,
    /// Centre and radius of each part.
    spheres: Vec<(DVec3, f64)>,
    /// Transforms of the instances of each part.
    places: Buckets<DAffine3>,
}

impl PlanModel {
    /// For plans of views.
    pub(crate) fn of(prepared: &Prepared) -> Self {
        let place = |instance: &SceneInstance| (instance.part.0, instance.transform);
        let places = Buckets::of(prepared.scene.parts.len(), prepared.scene.instances.iter().map(place));
        Self { places, ..Self::of_parts(prepared, Arc::clone(&prepared.parts), 0..prepared.parts.len()) }
    }

    /// For plans of tolerances. `rows`: where `parts` are in the scene.
    pub(super) fn of_parts(
        prepared: &Prepared,
        parts: Arc<Vec<Arc<PreparedPart>>>,
        rows: impl Iterator<Item = usize>,
    ) -> Self {
        let tiles = parts.iter().map(|part| part.tiles.len()).collect();
        let edges = parts.iter().map(|part| part.edges.len()).collect();
        let of_scene = rows.map(|row| &prepared.scene.parts[row]);
        let spheres = of_scene.map(|part| (part.centre, part.radius)).collect();
        Self { parts, tiles, edges, spheres, ..Self::default() }
    }

    /// Estimated bytes, without the parts.
    pub(crate) fn memory(&self) -> usize {
        let Self { tiles, edges, spheres, places, .. } = self;
        size_of_val(&tiles[..]) + size_of_val(&edges[..]) + size_of_val(&spheres[..]) + places.memory()
    }
}

/// What the parts of a model have to meet.
#[allow(clippy::large_enum_variant, reason = "a plan has one")]
pub(super) enum Target {
    /// Tolerances of all parts, in their own coordinates.
    Tolerances(Vec<Tolerance>),
    /// The screen-space error of a view.
    View {
        view: View,
        /// `None` for an invalid camera, which sees nothing.
        lens: Option<([DVec3; 3], SightLens)>,
        /// For each part, the camera in the coordinates of its instances, made by the first thread that needs them.
        cameras: Vec<OnceLock<Vec<PartCamera>>>,
    },
}

impl Target {
    /// That of a view, for so many parts.
    pub(super) fn of_view(view: &View, parts: usize) -> Self {
        Self::View { view: *view, lens: view.lens(), cameras: vec![OnceLock::new(); parts] }
    }
}

/// Parts, and what they have to meet.
pub(super) struct PlanTargets {
    pub(super) model: Arc<PlanModel>,
    pub(super) target: Target,
}

/// The tolerance of what a view does not see.
fn unseen(view: &View) -> Tolerance {
    Tolerance { chord: f64::INFINITY, angle: view.angle, max_edge: None }
}

impl PlanTargets {
    /// The tolerance of a part.
    pub(super) fn of_part(&self, part: usize) -> PartTolerance<'_> {
        let (places, sphere) = (self.model.places.at(part as u32), self.model.spheres[part]);
        match &self.target {
            Target::Tolerances(of) => PartTolerance::everywhere(&of[part], sphere.1),
            Target::View { view, lens: Some(lens), cameras } if !places.is_empty() => {
                let sight = |transform| view.sight(*lens, transform);
                let cameras = cameras[part].get_or_init(|| places.iter().map(sight).collect());
                let per_pixel = Tolerance { chord: view.deviation_px, angle: view.angle, max_edge: view.size_px };
                PartTolerance::seen(&per_pixel, cameras, sphere)
            }
            Target::View { view, .. } => PartTolerance::everywhere(&unseen(view), sphere.1),
        }
    }

    /// Whether a value of the target is invalid, or too small to meet. A part without tiles meets any.
    pub(super) fn is_unusable(&self) -> bool {
        let PlanModel { tiles, spheres, places, .. } = &*self.model;
        let any =
            |is_unusable: &dyn Fn(usize) -> bool| (0..tiles.len()).any(|part| tiles[part] > 0 && is_unusable(part));
        match &self.target {
            Target::Tolerances(of) => any(&|part| of[part].usable(spheres[part].1) != of[part]),
            Target::View { lens: None, .. } => any(&|_| true),
            Target::View { view, .. } => {
                let is_view_usable = view.check().is_ok();
                let is_unseen_usable = unseen(view).usable(0.0) == unseen(view);
                let is_usable = |seen| if seen { is_view_usable } else { is_unseen_usable };
                any(&|part| !is_usable(!places.at(part as u32).is_empty()))
            }
        }
    }
}
