//! Instances, and where they are -> those that each view may show.

use super::attributes::{AttributeTable, Attributes};
use super::culling::{InstanceSight, box_of_part};
use crate::frame::tolerance::part_camera::{PixelScale, sphere_around};
use crate::math::keyed::take_rows;
use crate::math::sphere_tree::{Sphere, SphereTree};
use crate::mesh::SceneInstance;
use crate::model::{Colour, PartId};
use crate::prepare::Prepared;
use crate::prepare::internals::BoundingBox;
use crate::view::View;
use glam::DAffine3;
use std::collections::{BTreeMap, BTreeSet};

/// The instances of a scene, in a tree of spheres around them. Finding what views show costs as much as they show.
#[derive(Debug, Default)]
pub struct PlacedInstances {
    /// In the colours of the model.
    instances: Vec<SceneInstance>,
    attributes: AttributeTable,
    /// By row of the prepared model.
    boxes: Vec<BoundingBox>,
    /// The model's part of each row: itself, or that of which it is another LOD.
    model_parts: Vec<PartId>,
    /// `None` after instances came or went.
    tree: Option<SphereTree>,
    /// Counts changes that plans depend on.
    version: u64,
    /// Counts changes of any kind.
    scene_version: u64,
    /// LODs selected since they were last taken: instances and their rows.
    selected: Vec<(usize, PartId)>,
    /// Looks that changed since they were last taken.
    looks: Vec<(usize, InstanceLook)>,
}

/// Where and how sinks draw an instance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InstanceLook {
    pub(crate) transform: DAffine3,
    pub(crate) visible: bool,
    pub(crate) colour: Option<Colour>,
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
        let mut placed = Self { version: 1, scene_version: 1, ..Self::default() };
        placed.add_parts(prepared);
        placed.instances.clone_from(&prepared.scene.instances);
        let hidden = |(row, instance): (usize, &SceneInstance)| {
            (!instance.visible).then_some((row, Attributes::DEFAULT.with_visible(false)))
        };
        let hidden: Vec<_> = placed.instances.iter().enumerate().filter_map(hidden).collect();
        placed.set_attributes(&[], &hidden);
        placed
    }

    /// Switches to the instances of another model, whose row `p` was `from[p]`. Parts keep their
    /// attributes.
    pub(crate) fn update(&mut self, prepared: &Prepared, from: &[Option<PartId>]) {
        let known = |(row, old): (usize, &Option<PartId>)| {
            let is_model = prepared.scene.parts[row].mesh_of.is_none();
            let attributes = self.attributes.parts().get(&old.filter(|_| is_model)?)?;
            Some((PartId::new(row), *attributes))
        };
        let parts: Vec<_> = from.iter().enumerate().filter_map(known).collect();
        let (version, scene_version) = (self.version + 1, self.scene_version + 1);
        *self = Self { version, scene_version, ..Self::of(prepared) };
        self.set_attributes(&parts, &[]);
    }

    /// Goes on with a model that has further parts after those known.
    pub(crate) fn add_parts(&mut self, prepared: &Prepared) {
        for (part, of_scene) in prepared.parts.iter().zip(&prepared.scene.parts).skip(self.boxes.len()) {
            let lod_of = of_scene.mesh_of.and_then(|part| self.boxes.get(part.index()).copied());
            self.boxes.push(lod_of.unwrap_or_else(|| box_of_part(part)));
            self.model_parts.push(of_scene.mesh_of.unwrap_or(PartId::new(self.model_parts.len())));
        }
    }

    /// Sets the attributes of parts of the model, and of instances. Cost: about 100 ns for each instance that it
    /// changes; where there are `parts`, a look at all instances.
    pub(crate) fn set_attributes(&mut self, parts: &[(PartId, Attributes)], instances: &[(usize, Attributes)]) {
        let count = self.instances.len();
        parts.iter().for_each(|(part, attributes)| self.attributes.set_part(*part, *attributes));
        instances.iter().for_each(|(row, attributes)| self.attributes.set_instance((*row, count), *attributes));
        let changed: BTreeSet<PartId> = parts.iter().map(|(part, _)| *part).collect();
        let looked_at = if changed.is_empty() { 0 } else { count };
        let of_parts = (0..looked_at).filter(|&row| changed.contains(&self.model_part(row)));
        let rows: Vec<usize> = of_parts.chain(instances.iter().map(|(row, _)| *row)).collect();
        rows.into_iter().for_each(|row| self.combine(row));
    }

    /// Combines the attributes of an instance with those of its part.
    fn combine(&mut self, row: usize) {
        let part = self.model_part(row);
        let Some(before) = self.attributes.combine((row, self.instances.len()), part) else { return };
        let now = *self.attributes.of(row);
        if now.visible != before.visible || now.colour != before.colour {
            self.scene_version += 1;
            self.tell(row);
        }
        if now.visible != before.visible || now.tolerance_scale != before.tolerance_scale {
            self.version += 1;
            self.replace_sphere(row);
        }
    }

    /// Notes the look of an instance for whoever takes it.
    fn tell(&mut self, row: usize) {
        let (instance, attributes) = (&self.instances[row], self.attributes.of(row));
        let (visible, colour) = (attributes.visible, attributes.colour.or(instance.colour));
        self.looks.push((row, InstanceLook { transform: instance.transform, visible, colour }));
    }

    /// The model's part of an instance, whatever its current LOD.
    fn model_part(&self, row: usize) -> PartId {
        let part = self.instances[row].part;
        self.model_parts.get(part.index()).copied().unwrap_or(part)
    }

    /// Attributes of parts of the model that are not the default.
    pub(crate) fn part_attributes(&self) -> &BTreeMap<PartId, Attributes> {
        self.attributes.parts()
    }

    /// The looks that changed since the last call, in order.
    pub(crate) fn take_looks(&mut self) -> Vec<(usize, InstanceLook)> {
        std::mem::take(&mut self.looks)
    }

    /// Memory of attributes, bytes.
    pub(crate) fn memory(&self) -> usize {
        self.attributes.memory()
    }

    /// The instances. Each names the LOD that was selected for it last.
    #[must_use]
    pub fn instances(&self) -> &[SceneInstance] {
        &self.instances
    }

    /// Grows with every change that plans depend on.
    pub(crate) fn version(&self) -> u64 {
        self.version
    }

    /// Grows with every change that sinks are told of.
    pub(crate) fn scene_version(&self) -> u64 {
        self.scene_version
    }

    fn changed(&mut self) {
        self.version += 1;
        self.scene_version += 1;
    }

    /// The box of the part of an instance; empty if there is no such part.
    fn box_of(&self, instance: &SceneInstance) -> BoundingBox {
        self.boxes.get(instance.part.index()).copied().unwrap_or(BoundingBox::EMPTY)
    }

    /// A sphere around an instance; an empty one if it is hidden.
    fn sphere(&self, row: usize) -> Sphere {
        let instance = &self.instances[row];
        let sphere = sphere_around(&self.box_of(instance), &instance.transform);
        if self.attributes.of(row).visible { sphere } else { sphere.emptied() }
    }

    fn replace_sphere(&mut self, row: usize) {
        let sphere = self.sphere(row);
        self.tree.iter_mut().for_each(|tree| tree.replace(row, sphere));
    }

    /// Appends an instance, in the colour of the model. It is visible if it says so, and its part is.
    pub(crate) fn push(&mut self, instance: SceneInstance) {
        self.tree = None;
        self.changed();
        let (row, visible) = (self.instances.len(), instance.visible);
        self.instances.push(instance);
        if !visible || self.attributes.parts().contains_key(&self.model_part(row)) {
            self.set_attributes(&[], &[(row, Attributes::DEFAULT.with_visible(visible))]);
        }
    }

    /// Removes instances, whose indices ascend, and returns them in the colours of the model. The indices of later ones
    /// decrease.
    pub(crate) fn remove(&mut self, rows: &[usize]) -> Vec<SceneInstance> {
        self.tree = None;
        self.changed();
        self.attributes.remove(rows);
        take_rows(&mut self.instances, rows)
    }

    /// Moves an instance.
    pub(crate) fn move_to(&mut self, row: usize, transform: DAffine3) {
        self.changed();
        self.instances[row].transform = transform;
        self.tell(row);
        self.replace_sphere(row);
    }

    /// Selects the LOD of an instance: another row of the same part. Returns the one before if that changes it.
    pub(crate) fn select(&mut self, row: usize, part: PartId) -> Option<PartId> {
        let before = std::mem::replace(&mut self.instances[row].part, part);
        if before == part {
            return None;
        }
        self.changed();
        self.selected.push((row, part));
        Some(before)
    }

    /// Takes back the last [`select`](Self::select) that changed an instance: it had this LOD before. Nothing changed
    /// since.
    pub(crate) fn unselect(&mut self, row: usize, before: PartId) {
        self.version -= 1;
        self.scene_version -= 1;
        self.instances[row].part = before;
        self.selected.push((row, before));
    }

    /// The LODs selected since the last call: instances and their rows, in order.
    pub(crate) fn take_selected(&mut self) -> Vec<(usize, PartId)> {
        std::mem::take(&mut self.selected)
    }

    /// What the views may show, without those that are invalid. `cull_back_faces`: whether tiles that show their backs
    /// are to be skipped.
    ///
    /// Cost: about 100 ns per instance that a view shows, and some of those beside it. After instances came or went,
    /// as much for all of them, once.
    pub(crate) fn shown_by(&mut self, views: &[View], cull_back_faces: bool) -> Shown {
        if self.tree.is_none() {
            let spheres: Vec<Sphere> = (0..self.instances.len()).map(|row| self.sphere(row)).collect();
            self.tree = Some(SphereTree::new(&spheres));
        }
        let (mut shown, mut found) = (Shown::default(), Vec::new());
        for (view, of) in views.iter().enumerate() {
            let Some(lens) = of.usable_lens() else { continue };
            shown.views += 1;
            self.tree.iter().for_each(|tree| tree.find(|sphere| of.may_show(lens, sphere), &mut found));
            shown.sights.reserve(found.len());
            for instance in found.drain(..).map(|number| number as usize) {
                let placed = &self.instances[instance];
                let Attributes { tolerance_scale, priority, .. } = *self.attributes.of(instance);
                let sight = of.sight(lens, &placed.transform).weighed(1.0 / (of.deviation_px * tolerance_scale));
                if let Some(PixelScale { most, .. }) = sight.look(&self.box_of(placed)) {
                    let eye = cull_back_faces.then(|| of.eye(lens, placed));
                    shown.sights.push(InstanceSight { view, instance, sight, eye, most, priority });
                }
            }
        }
        shown
    }
}
