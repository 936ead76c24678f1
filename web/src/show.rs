//! A prepared model that is shown: its session, and what is picked.

use crate::limits::MEMORY;
use serde::Serialize;
use std::sync::Arc;
use std::time::Duration;
use trimtess::control::Alone;
use trimtess::frame::{PlanLimits, PlannerOptions};
use trimtess::glam::DVec3;
use trimtess::model::{FaceId, InstanceId, PartId};
use trimtess::out::wgpu::PickHit;
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::Prepared;
use trimtess::view::{Camera, box_corners};
use tsify::Tsify;

/// Time for the tiles of a picture, as the library predicts it for native code. The rest comes with the next pictures.
const BUDGET: Duration = Duration::from_millis(8);

/// A model on show.
pub(crate) struct Show {
    pub(crate) prepared: Arc<Prepared>,
    pub(crate) session: Session,
    pub(crate) picked: Option<Picked>,
    /// The point that drags orbit about, or move along.
    pub(crate) pivot: DVec3,
}

/// A picked face, or a place that a diagnostic names.
#[derive(Clone, Copy)]
pub(crate) struct Picked {
    pub(crate) face: Option<(InstanceId, FaceId)>,
    pub(crate) point: DVec3,
}

/// A face under a pixel.
#[derive(Serialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct Pick {
    /// Index into the instances.
    instance: u32,
    /// What the face is, as names and values.
    facts: Vec<(String, String)>,
}

impl Show {
    pub(crate) fn new(prepared: Arc<Prepared>) -> Self {
        let limits = PlanLimits::DEFAULT.with_bytes(MEMORY);
        let planner = PlannerOptions::DEFAULT.with_budget(Some(BUDGET)).with_limits(limits);
        let options = SessionOptions::DEFAULT.with_planner(planner);
        let session = Session::start_on(Arc::new(Alone), Arc::clone(&prepared), &options);
        Self { pivot: prepared.centre(), prepared, session, picked: None }
    }

    /// Corners of the model's box.
    pub(crate) fn corners(&self) -> impl Iterator<Item = DVec3> + use<> {
        self.prepared.bounds.into_iter().flat_map(box_corners)
    }

    /// What the picked face is.
    pub(crate) fn pick(&self, hit: &PickHit) -> Pick {
        let of_face = self.prepared.face_facts(hit.part, hit.face).map(|facts| facts.rows());
        let facts = hit.facts(self.session.scene(), of_face.unwrap_or_default());
        let facts = facts.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
        Pick { instance: hit.instance.0, facts }
    }

    /// Picks what a diagnostic is about. Returns a camera that shows it, or `None` if it has no place.
    pub(crate) fn show_diagnostic(&mut self, k: usize, camera: &Camera, aspect: f64) -> Option<Camera> {
        let told = self.prepared.diagnostics.get(k)?;
        let part = told.part?;
        let instances = &self.prepared.scene.instances;
        let number = instances.iter().position(|instance| instance.part == part)?;
        let face = told.face.map(|face| (InstanceId(number as u32), face));
        let transform = instances[number].transform;
        let of_face: Vec<DVec3> = told.face.map(|face| self.boundary(part, face)).unwrap_or_default();
        let place = told.place.or_else(|| {
            let count = of_face.len() as f64;
            (count > 0.0).then(|| of_face.iter().sum::<DVec3>() / count)
        })?;
        let point = transform.transform_point3(place);
        self.picked = Some(Picked { face, point });
        self.pivot = point;
        // Some of what is around it, however small it is.
        let around = DVec3::splat(0.02 * self.prepared.diagonal);
        let placed = of_face.iter().map(|&point| transform.transform_point3(point));
        let points = placed.chain(box_corners([point - around, point + around]));
        Some(camera.view_point().fit_as(camera.is_orthographic(), points, aspect))
    }

    /// Points on the boundary of a face, part coordinates.
    fn boundary(&self, part: PartId, face: FaceId) -> Vec<DVec3> {
        let Some(part) = self.prepared.parts.get(part.index()) else { return Vec::new() };
        let tiles = part.tiles.iter().filter(|tile| tile.face == face);
        let uses = tiles.flat_map(|tile| tile.loops.iter().flatten());
        uses.filter_map(|used| Some(part.edges[used.edge.index()].breaks.get(used.from as usize)?.point)).collect()
    }
}
