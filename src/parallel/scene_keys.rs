//! Keys of a session's instances and parts, and what of its scene the sink does not know yet.

use crate::math::keyed::take_rows;
use crate::mesh::{InstanceKey, PartKey, Scene, SceneChanges, SceneInstance, ScenePart};
use crate::model::PartId;
use slotmap::{DefaultKey, SlotMap};
use std::num::NonZeroU64;

/// The scene has the keys by row.
pub(super) struct SceneKeys {
    /// Rows of instances by key.
    rows: SlotMap<DefaultKey, usize>,
    /// Number of keys that parts were given.
    parts: u64,
    /// Number of instances that the sink knows: those in the first rows.
    known: usize,
    /// Number of parts that it knows.
    known_parts: usize,
    /// Instances that it knows, and that were removed.
    removed: Vec<InstanceKey>,
    /// Rows that it knows, and that have changed. Ascending.
    changed: Vec<usize>,
}

impl SceneKeys {
    /// Gives keys to a scene that no sink knows.
    pub(super) fn of(scene: &mut Scene) -> Self {
        let (known, known_parts, removed, changed) = Default::default();
        let mut new = Self { rows: SlotMap::new(), parts: 0, known, known_parts, removed, changed };
        new.name_all(scene);
        new
    }

    /// Replaces the scene `before`, of which part `from[p]` is part `p` now. Keys of its instances name none from now
    /// on.
    pub(super) fn update(&mut self, before: &Scene, scene: &mut Scene, from: &[Option<PartId>]) {
        for (part, from) in scene.parts.iter_mut().zip(from) {
            part.key = from.and_then(|from| before.parts[from.index()].key);
        }
        self.removed.extend(before.instances[..self.known].iter().filter_map(|instance| instance.key));
        self.changed.clear();
        self.rows.clear();
        (self.known, self.known_parts) = (0, 0);
        self.name_all(scene);
    }

    /// Gives keys to all instances, and to parts that have none.
    fn name_all(&mut self, scene: &mut Scene) {
        scene.parts.iter_mut().filter(|part| part.key.is_none()).for_each(|part| self.name(part));
        for (row, instance) in scene.instances.iter_mut().enumerate() {
            instance.key = Some(InstanceKey(self.rows.insert(row)));
        }
    }

    /// Gives a key to the last part.
    pub(super) fn name_part(&mut self, scene: &mut Scene) {
        scene.parts.last_mut().into_iter().for_each(|part| self.name(part));
    }

    fn name(&mut self, part: &mut ScenePart) {
        self.parts += 1;
        part.key = NonZeroU64::new(self.parts).map(PartKey);
    }

    /// Appends an instance.
    pub(super) fn push(&mut self, scene: &mut Scene, instance: SceneInstance) -> InstanceKey {
        let key = InstanceKey(self.rows.insert(scene.instances.len()));
        scene.instances.push(SceneInstance { key: Some(key), ..instance });
        key
    }

    /// Removes the instances in these rows, which ascend, and returns them. The rows of later ones decrease.
    pub(super) fn remove(&mut self, scene: &mut Scene, rows: &[usize]) -> Vec<SceneInstance> {
        let gone = take_rows(&mut scene.instances, rows);
        gone.iter().filter_map(|instance| instance.key).for_each(|key| _ = self.rows.remove(key.0));
        let first = rows.first().map_or(scene.instances.len(), |first| *first);
        for (row, instance) in scene.instances.iter().enumerate().skip(first) {
            let known = instance.key.and_then(|key| self.rows.get_mut(key.0));
            known.into_iter().for_each(|known| *known = row);
        }
        let known = rows.partition_point(|row| *row < self.known);
        self.known -= known;
        self.removed.extend(gone[..known].iter().filter_map(|instance| instance.key));
        self.changed.retain_mut(|row| {
            let below = rows.partition_point(|gone| gone < row);
            let stays = rows.get(below) != Some(row);
            *row -= below;
            stays
        });
        gone
    }

    /// Notes that instances look different, or have another LOD.
    pub(super) fn change(&mut self, rows: impl Iterator<Item = usize>) {
        let before = self.changed.len();
        self.changed.extend(rows.filter(|row| *row < self.known));
        if self.changed.len() > before {
            self.changed.sort_unstable();
            self.changed.dedup();
        }
    }

    /// What the sink does not know.
    pub(super) fn changes(&self) -> SceneChanges<'_> {
        let Self { known, known_parts, removed, changed, .. } = self;
        SceneChanges { removed, changed, first_instance: *known, first_part: *known_parts }
    }

    /// Notes that the sink knows the scene.
    pub(super) fn committed(&mut self, scene: &Scene) {
        (self.known, self.known_parts) = (scene.instances.len(), scene.parts.len());
        self.removed.clear();
        self.changed.clear();
    }

    pub(super) fn row(&self, key: InstanceKey) -> Option<usize> {
        self.rows.get(key.0).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;

    fn scene(count: usize) -> Scene {
        Scene { instances: vec![SceneInstance::new(PartId(0), DAffine3::IDENTITY); count], ..Scene::default() }
    }

    fn keys(scene: &Scene) -> Vec<InstanceKey> {
        scene.instances.iter().map(|instance| instance.key.expect("a key")).collect()
    }

    fn push(keys: &mut SceneKeys, scene: &mut Scene) -> InstanceKey {
        keys.push(scene, SceneInstance::new(PartId(0), DAffine3::IDENTITY))
    }

    #[test]
    fn keys_stay_while_rows_shift_and_are_not_given_twice() {
        let mut scene = scene(4);
        let mut table = SceneKeys::of(&mut scene);
        let before = keys(&scene);
        table.remove(&mut scene, &[1]);
        let row = |table: &SceneKeys, key: &InstanceKey| table.row(*key);
        let rows: Vec<_> = before.iter().map(|key| row(&table, key)).collect();
        assert_eq!(rows, [Some(0), None, Some(1), Some(2)]);
        let new = push(&mut table, &mut scene);
        assert_eq!([row(&table, &new), row(&table, &before[1])], [Some(3), None]);
        assert!(!before.contains(&new));
        for key in before.iter().chain([&new]) {
            assert_eq!(InstanceKey::from_bits(key.to_bits()), *key);
        }
        let mut next = self::scene(2);
        table.update(&scene, &mut next, &[]);
        assert!(before.iter().chain([&new]).all(|key| row(&table, key).is_none()));
        assert!(keys(&next).iter().map(|key| row(&table, key)).eq([Some(0), Some(1)]));
        assert_eq!([0, 1, u64::MAX].map(|bits| table.row(InstanceKey::from_bits(bits))), [None; 3]);
    }

    #[test]
    fn changes_are_relative_to_what_the_sink_knows() {
        let mut scene = scene(5);
        let mut table = SceneKeys::of(&mut scene);
        table.committed(&scene);
        let before = keys(&scene);
        assert!(table.changes().keep_instances(&scene));
        // One that comes and goes is no news, and one that has changed may go.
        let short = push(&mut table, &mut scene);
        table.change([4, 1, 4, 5].into_iter());
        assert_eq!(table.changes().changed, [1, 4]);
        table.remove(&mut scene, &[1, 2, 5]);
        push(&mut table, &mut scene);
        let SceneChanges { removed, changed, first_instance, .. } = table.changes();
        assert_eq!((removed, changed, first_instance), (&before[1..3], &[2][..], 3));
        assert!(table.row(short).is_none());
        let mut next = self::scene(1);
        table.update(&scene, &mut next, &[]);
        let SceneChanges { removed, changed, first_instance, .. } = table.changes();
        assert_eq!((removed, changed, first_instance), ([1, 2, 0, 3, 4].map(|k| before[k]).as_slice(), &[][..], 0));
        table.committed(&next);
        assert!(table.changes().keep_instances(&next));
    }
    #[test]
    fn parts_keep_their_keys_under_other_numbers() {
        let of = |count: usize| Scene { parts: vec![ScenePart::default(); count], ..Scene::default() };
        let part_keys = |scene: &Scene| scene.parts.iter().map(|part| part.key.expect("a key")).collect::<Vec<_>>();
        let mut scene = of(3);
        let mut table = SceneKeys::of(&mut scene);
        scene.add_level(PartId(1));
        table.name_part(&mut scene);
        let before = part_keys(&scene);
        let mut next = of(4);
        table.update(&scene, &mut next, &[Some(PartId(3)), None, Some(PartId(0)), None]);
        let now = part_keys(&next);
        assert_eq!([now[0], now[2]], [before[3], before[0]]);
        let mut all: Vec<u64> = before.iter().chain([&now[1], &now[3]]).map(|key| key.to_bits()).collect();
        all.sort_unstable();
        assert_eq!(all, [1, 2, 3, 4, 5, 6]);
    }
}
