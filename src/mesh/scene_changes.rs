//! What differs between a scene and the one before it.

use super::{InstanceKey, Scene, SceneInstance};

/// What differs between a scene and that of the last completed frame, however many frames were cancelled in between.
/// The default is for a sink that has nothing: all is new.
///
/// Instances that both scenes have are in the same order. New ones follow them.
#[derive(Clone, Copy, Debug, Default)]
pub struct SceneChanges<'a> {
    /// Keys of instances that are gone, each once.
    pub removed: &'a [InstanceKey],
    /// Rows of instances that both scenes have and whose LOD, transform, colour or visibility may differ. Ascending. The
    /// numbers of first faces differ after removed ones, too; these are not listed.
    pub changed: &'a [usize],
    /// Row of the first new instance. All rows from there on are new, and no others.
    pub first_instance: usize,
    /// First new part; 0 after an update to another model.
    pub first_part: usize,
}

impl SceneChanges<'_> {
    /// Whether the instances of `scene` are those of the last frame, and look the same.
    #[must_use]
    pub fn keep_instances(&self, scene: &Scene) -> bool {
        self.removed.is_empty() && self.changed.is_empty() && self.first_instance == scene.instances.len()
    }

    /// Brings a list that has `row(instance)` of each instance of the last frame up to date. Cost: a call for each
    /// instance that is new or has changed; for all of them if any were removed, as rows shift then.
    pub fn apply<T>(&self, scene: &Scene, list: &mut Vec<T>, row: impl Fn(&SceneInstance) -> T) {
        let Self { removed, changed, first_instance, .. } = *self;
        if !removed.is_empty() {
            list.clear();
        }
        let kept = list.len().min(first_instance);
        list.truncate(kept);
        for &changed in changed.iter().take_while(|changed| **changed < kept) {
            list[changed] = row(&scene.instances[changed]);
        }
        list.extend(scene.instances[kept..].iter().map(row));
    }
}
