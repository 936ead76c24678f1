//! Edits of parts and instances between two frames of views -> what the job of the next one applies.

use super::error::EditError;
use super::scene_keys::SceneKeys;
use crate::frame::Attributes;
use crate::math::keyed::take_rows;
use crate::mesh::{InstanceKey, Scene, SceneInstance};
use crate::model::{PartId, bad_colour};
use glam::DAffine3;
use std::collections::{BTreeMap, BTreeSet};

/// Attributes as the caller set them, and edits since the last frame of views was begun.
pub(super) struct Edits {
    /// Without those that have the default.
    parts: BTreeMap<PartId, Attributes>,
    instances: BTreeMap<InstanceKey, Attributes>,
    /// The place of each instance as the caller set it, by row.
    places: Vec<DAffine3>,
    /// Rows of instances that moved.
    moved: BTreeSet<usize>,
    changed_parts: BTreeSet<PartId>,
    changed_instances: BTreeSet<InstanceKey>,
}

/// Edits for an engine, by row.
#[derive(Default)]
pub(super) struct Edited {
    pub(super) moved: Vec<(usize, DAffine3)>,
    pub(super) parts: Vec<(PartId, Attributes)>,
    pub(super) instances: Vec<(usize, Attributes)>,
}

impl Edited {
    pub(super) fn is_empty(&self) -> bool {
        self.moved.is_empty() && self.parts.is_empty() && self.instances.is_empty()
    }
}

impl Edits {
    /// Nothing edited yet, of a scene whose parts have these attributes.
    pub(super) fn of(scene: &Scene, parts: BTreeMap<PartId, Attributes>) -> Self {
        let (moved, changed_parts, changed_instances) = Default::default();
        let places = scene.instances.iter().map(|instance| instance.transform).collect();
        let mut new = Self { parts, instances: BTreeMap::new(), places, moved, changed_parts, changed_instances };
        for instance in scene.instances.iter().filter(|instance| !instance.visible) {
            instance.key.into_iter().for_each(|key| new.show(key, instance.visible));
        }
        new
    }

    /// Adds an instance that the engine has already, in the last row.
    pub(super) fn add(&mut self, key: InstanceKey, instance: &SceneInstance) {
        self.places.push(instance.transform);
        self.show(key, instance.visible);
    }

    fn show(&mut self, key: InstanceKey, visible: bool) {
        if !visible {
            self.instances.insert(key, Attributes::DEFAULT.with_visible(false));
        }
    }

    /// Removes the places of instances that did not move since the last [`take`](Self::take). Their rows ascend.
    pub(super) fn remove_rows(&mut self, rows: &[usize]) {
        take_rows(&mut self.places, rows);
    }

    /// Removes the attributes of an instance, and returns them.
    pub(super) fn remove(&mut self, key: InstanceKey) -> Attributes {
        self.instances.remove(&key).unwrap_or_default()
    }

    /// Those of a part, which there is.
    pub(super) fn part(&self, part: PartId) -> Attributes {
        self.parts.get(&part).copied().unwrap_or_default()
    }

    /// Those of an instance, which there is.
    pub(super) fn instance(&self, key: InstanceKey) -> Attributes {
        self.instances.get(&key).copied().unwrap_or_default()
    }

    pub(super) fn set_part(&mut self, part: PartId, attributes: Attributes) {
        if set(&mut self.parts, part, attributes) {
            self.changed_parts.insert(part);
        }
    }

    pub(super) fn set_instance(&mut self, key: InstanceKey, attributes: Attributes) {
        if set(&mut self.instances, key, attributes) {
            self.changed_instances.insert(key);
        }
    }

    pub(super) fn move_row(&mut self, row: usize, transform: DAffine3) {
        if self.places[row] != transform {
            self.places[row] = transform;
            self.moved.insert(row);
        }
    }

    /// Whether nothing was edited since the last frame of views was begun.
    pub(super) fn is_empty(&self) -> bool {
        self.moved.is_empty() && self.changed_parts.is_empty() && self.changed_instances.is_empty()
    }

    /// What was edited since the last call.
    pub(super) fn take(&mut self, keys: &SceneKeys) -> Edited {
        let Self { parts, instances, places, moved, changed_parts, changed_instances } = self;
        let of_part = |part: PartId| (part, parts.get(&part).copied().unwrap_or_default());
        let of_key = |key: InstanceKey| Some((keys.row(key)?, instances.get(&key).copied().unwrap_or_default()));
        Edited {
            moved: std::mem::take(moved).into_iter().map(|row| (row, places[row])).collect(),
            parts: std::mem::take(changed_parts).into_iter().map(of_part).collect(),
            instances: std::mem::take(changed_instances).into_iter().filter_map(of_key).collect(),
        }
    }
}

/// Sets a row. Whether that changes it.
fn set<K: Ord>(rows: &mut BTreeMap<K, Attributes>, key: K, attributes: Attributes) -> bool {
    let is_default = attributes == Attributes::DEFAULT;
    let before = if is_default { rows.remove(&key) } else { rows.insert(key, attributes) };
    before.unwrap_or_default() != attributes
}

/// Whether frames can use them.
pub(super) fn check(attributes: &Attributes) -> Result<(), EditError> {
    let Attributes { colour, tolerance_scale, priority, .. } = *attributes;
    for (name, value) in [("tolerance_scale", tolerance_scale), ("priority", priority)] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(EditError::Factor { name, value });
        }
    }
    bad_colour(colour).map_or(Ok(()), |colour| Err(EditError::Colour { colour }))
}
