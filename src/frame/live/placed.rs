//! Instances, and where they are -> those that each view may show.

use super::culling::{InstanceSight, PartBoxes};
use crate::frame::tolerance::part_camera::{PixelScale, sphere_around};
use crate::math::sphere_tree::{Sphere, SphereTree};
use crate::mesh::SceneInstance;
use crate::model::PartId;
use crate::prepare::Prepared;
use crate::prepare::internals::BoundingBox;
use crate::view::View;
use glam::DAffine3;

/// The instances of a scene, in a tree of spheres around them. Finding what views show costs as much as they show.
#[derive(Debug, Default)]
pub struct PlacedInstances {
    instances: Vec<SceneInstance>,
    /// By row of the prepared model.
    boxes: Vec<BoundingBox>,
    /// `None` after instances came or went.
    tree: Option<SphereTree>,
    /// Counts changes of any kind.
    version: u64,
    /// LODs selected since they were last taken: instances and their rows.
    selected: Vec<(usize, PartId)>,
}

/// What views may show.
#[derive(Default)]
pub(crate) struct Shown {
    /// Number of valid views.
    pub(crate) views: usize,
    /// Ascending by (view, instance).
    pub(crate) sights: Vec<InstanceSight>,
}

impl PlacedInstances {
    /// The instances of `prepared`. Cost: a few nanoseconds per tile, about 100 ns per instance.
    #[must_use]
    pub fn of(prepared: &Prepared) -> Self {
        let mut placed = Self { version: 1, ..Self::default() };
        placed.add_parts(prepared);
        placed.instances.clone_from(&prepared.scene.instances);
        placed
    }

    /// Goes on with the instances of another model.
    pub(crate) fn update(&mut self, prepared: &Prepared) {
        *self = Self { version: self.version + 1, ..Self::of(prepared) };
    }

    /// Goes on with a model that has further parts after those known.
    pub(crate) fn add_parts(&mut self, prepared: &Prepared) {
        for (part, of_scene) in prepared.parts.iter().zip(&prepared.scene.parts).skip(self.boxes.len()) {
            let lod_of = of_scene.mesh_of.and_then(|part| self.boxes.get(part.index()).copied());
            self.boxes.push(lod_of.unwrap_or_else(|| PartBoxes::whole(part)));
        }
    }

    /// The instances. Each names the LOD that was selected for it last.
    #[must_use]
    pub fn instances(&self) -> &[SceneInstance] {
        &self.instances
    }

    /// Changes whenever anything else does.
    pub(crate) fn version(&self) -> u64 {
        self.version
    }

    /// The box of the part of an instance; empty if there is no such part.
    fn box_of(&self, instance: &SceneInstance) -> BoundingBox {
        self.boxes.get(instance.part.index()).copied().unwrap_or(BoundingBox::EMPTY)
    }

    fn sphere(&self, instance: &SceneInstance) -> Sphere {
        sphere_around(&self.box_of(instance), &instance.transform)
    }

    /// Appends an instance.
    pub(crate) fn push(&mut self, instance: SceneInstance) {
        (self.tree, self.version) = (None, self.version + 1);
        self.instances.push(instance);
    }

    /// Removes an instance. The indices of later ones decrease by one.
    pub(crate) fn remove(&mut self, row: usize) {
        (self.tree, self.version) = (None, self.version + 1);
        self.instances.remove(row);
    }

    /// Moves an instance.
    pub(crate) fn move_to(&mut self, row: usize, transform: DAffine3) {
        self.version += 1;
        self.instances[row].transform = transform;
        let sphere = self.sphere(&self.instances[row]);
        if let Some(tree) = &mut self.tree {
            tree.replace(row, sphere);
        }
    }

    /// Selects the LOD of an instance: another row of the same part.
    pub(crate) fn select(&mut self, row: usize, part: PartId) {
        if self.instances[row].part != part {
            self.version += 1;
            self.instances[row].part = part;
            self.selected.push((row, part));
        }
    }

    /// The LODs selected since the last call: instances and their rows, in order.
    pub(crate) fn take_selected(&mut self) -> Vec<(usize, PartId)> {
        std::mem::take(&mut self.selected)
    }

    /// What the views may show, without those that are invalid.
    ///
    /// Cost: about 100 ns per instance that a view shows, and some of those beside it. After instances came or went,
    /// as much for all of them, once.
    pub(crate) fn shown_by(&mut self, views: &[View]) -> Shown {
        if self.tree.is_none() {
            let spheres: Vec<Sphere> = self.instances.iter().map(|instance| self.sphere(instance)).collect();
            self.tree = Some(SphereTree::new(&spheres));
        }
        let (mut shown, mut found) = (Shown::default(), Vec::new());
        for (view, of) in views.iter().enumerate() {
            let Some(lens) = of.usable_lens() else { continue };
            shown.views += 1;
            self.tree.iter().for_each(|tree| tree.find(|sphere| of.may_show(lens, sphere), &mut found));
            for instance in found.drain(..).map(|number| number as usize) {
                let placed = &self.instances[instance];
                let sight = of.sight(lens, placed).weighed(1.0 / of.deviation_px);
                if let Some(PixelScale { most, .. }) = sight.look(&self.box_of(placed)) {
                    shown.sights.push(InstanceSight { view, instance, sight, most });
                }
            }
        }
        shown
    }
}
