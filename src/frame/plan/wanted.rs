//! A model, and what is asked of it -> the tolerance of each part, for the threads that plan it.

use super::lists::Lists;
use crate::frame::tolerance::part_camera::SightLens;
use crate::frame::tolerance::{PartTolerance, Tolerance};
use crate::math::keyed::Buckets;
use crate::mesh::SceneInstance;
use crate::prepare::Prepared;
use crate::prepare::internals::PreparedPart;
use crate::view::View;
use glam::{DAffine3, DVec3};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// What plans read of a model before they read its parts, side by side: a frame leaves nothing of it in caches. The
/// same for all plans of a model.
#[derive(Debug, Default)]
pub(crate) struct PlanModel {
    pub(super) parts: Arc<Vec<Arc<PreparedPart>>>,
    /// Parts and their numbers of tiles, then of edges.
    pub(super) counts: [Vec<(usize, usize)>; 2],
    /// Centre and radius of each part.
    spheres: Vec<(DVec3, f64)>,
    /// Transforms of the instances of each part, and their scales.
    places: Buckets<(DAffine3, f64)>,
    /// All tiles and edges, for as many threads as the first plan had.
    lists: OnceLock<(usize, [Arc<Lists>; 2])>,
}

impl PlanModel {
    /// For plans of views.
    pub(crate) fn of(prepared: &Prepared) -> Self {
        let place = |instance: &SceneInstance| (instance.part.0, (instance.transform, instance.scale()));
        let places = Buckets::of(prepared.parts.len(), prepared.scene.instances.iter().map(place));
        Self { places, ..Self::of_parts(prepared, Arc::clone(&prepared.parts), 0..prepared.parts.len()) }
    }

    /// For plans of tolerances: `parts`, which are those in `rows`.
    pub(super) fn of_parts(
        prepared: &Prepared,
        parts: Arc<Vec<Arc<PreparedPart>>>,
        rows: impl Iterator<Item = usize>,
    ) -> Self {
        let count = |of: fn(&PreparedPart) -> usize| parts.iter().map(|part| of(part)).enumerate().collect();
        let counts = [count(|part| part.tiles.len()), count(|part| part.edges.len())];
        let of_scene = rows.map(|row| &prepared.scene.parts[row]);
        let spheres = of_scene.map(|part| (part.centre, part.radius)).collect();
        Self { parts, counts, spheres, ..Self::default() }
    }

    /// The tiles, then the edges, of some parts, for so many threads.
    pub(super) fn lists(&self, threads: usize, parts: &Range<usize>) -> [Arc<Lists>; 2] {
        let lists = || self.counts.each_ref().map(|counts| Arc::new(Lists::of(threads, &counts[parts.clone()])));
        if parts.len() < self.parts.len() {
            return lists();
        }
        match self.lists.get_or_init(|| (threads, lists())) {
            (of, kept) if *of == threads => kept.clone(),
            _ => lists(),
        }
    }

    /// Estimated bytes, without the parts.
    pub(crate) fn memory(&self) -> usize {
        let Self { counts, spheres, places, .. } = self;
        counts.iter().map(|counts| size_of_val(&counts[..])).sum::<usize>()
            + size_of_val(&spheres[..])
            + size_of_val(places.all())
    }
}

/// What is asked of the parts of a model.
#[allow(clippy::large_enum_variant, reason = "a plan has one")]
pub(super) enum Asked {
    /// Tolerances of all parts, in their own coordinates.
    Parts(Vec<Tolerance>),
    /// The screen-space error of a view; without a lens, that of no view.
    View(View, Option<([DVec3; 3], SightLens)>),
}

/// Parts, and what is asked of each.
pub(super) struct Wanted {
    pub(super) model: Arc<PlanModel>,
    pub(super) asked: Asked,
}

/// The tolerance of what a view does not see.
fn unseen(view: &View) -> Tolerance {
    Tolerance { chord: f64::INFINITY, angle: view.angle, max_edge: None }
}

impl Wanted {
    /// Writes the tolerance of a part to `tolerance`.
    pub(super) fn of_part(&self, part: usize, tolerance: &mut PartTolerance) {
        let (places, sphere) = (self.model.places.at(part as u32), self.model.spheres[part]);
        match &self.asked {
            Asked::Parts(of) => tolerance.set(&of[part], sphere),
            Asked::View(view, Some(lens)) if !places.is_empty() => {
                let per_pixel = Tolerance { chord: view.deviation_px, angle: view.angle, max_edge: view.size_px };
                let cameras = places.iter().map(|(transform, scale)| view.sight(*lens, (transform, *scale)));
                tolerance.set_seen(&per_pixel, cameras, sphere);
            }
            Asked::View(view, _) => tolerance.set(&unseen(view), sphere),
        }
    }

    /// Whether a value that is asked of a part is invalid or too small to meet. A part without tiles meets any.
    pub(super) fn is_unusable(&self) -> bool {
        let PlanModel { counts: [tiles, _], spheres, places, .. } = &*self.model;
        let any = |unusable: &dyn Fn(usize) -> bool| tiles.iter().any(|&(part, tiles)| tiles > 0 && unusable(part));
        match &self.asked {
            Asked::Parts(of) => any(&|part| of[part].usable(spheres[part].1) != of[part]),
            Asked::View(_, None) => any(&|_| true),
            Asked::View(view, Some(_)) => {
                let known = |x: f64| x > 0.0;
                let seen = known(view.deviation_px) && known(view.angle) && view.size_px.is_none_or(known);
                let usable = [unseen(view).usable(0.0) == unseen(view), seen];
                usable != [true; 2] && any(&|part| !usable[usize::from(!places.at(part as u32).is_empty())])
            }
        }
    }
}
