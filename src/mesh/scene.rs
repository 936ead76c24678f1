//! The scene: parts with their colours and open edges, placed instances, the keys that name them, and what an update
//! changed.

use crate::model::{Assembly, Colour, EdgeId, FaceId, Instance, PartId};
use glam::{DAffine3, DVec3};
use slotmap::{DefaultKey, Key, KeyData};
use std::fmt;
use std::num::NonZeroU64;
use std::sync::Arc;

/// Names an instance of a session. Stays the same when other instances come and go. Once the instance is removed, its
/// key names none, also after others were added; a key is given again only after 2³¹ instances had its place.
///
/// Means nothing to other sessions.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct InstanceKey(pub(crate) DefaultKey);

impl InstanceKey {
    /// The key as a number, for other languages. Never 0.
    #[must_use]
    pub fn to_bits(self) -> u64 {
        self.0.data().as_ffi()
    }

    /// The key that this number stands for. Any number is allowed: most name no instance.
    #[must_use]
    pub fn from_bits(bits: u64) -> Self {
        let key = KeyData::from_ffi(bits);
        Self(if key.as_ffi() == bits { key.into() } else { DefaultKey::null() })
    }
}

/// Place and generation.
impl fmt::Debug for InstanceKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.data().fmt(f)
    }
}

/// Names a part of a session's scene, or one of its LODs: the same as long as the session has the part's content, also
/// after an [update](crate::parallel::Session::update) that gives it another row. It is not given twice.
///
/// Means nothing to other sessions.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct PartKey(pub(crate) NonZeroU64);

impl PartKey {
    /// The key as a number, for other languages. Never 0.
    #[must_use]
    pub fn to_bits(self) -> u64 {
        self.0.get()
    }

    /// The key that this number stands for; `None` for 0. Most others name no part.
    #[must_use]
    pub fn from_bits(bits: u64) -> Option<Self> {
        NonZeroU64::new(bits).map(Self)
    }
}

/// A part, as sinks see it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScenePart {
    /// Name, possibly empty.
    pub name: String,
    /// Colour of each face: its own, else the part's. `None` = the viewer's default.
    pub face_colours: Vec<Option<Colour>>,
    /// Faces on surfaces without area, ascending. They have no triangles but those that close them, and that is no
    /// loss.
    pub without_area: Vec<FaceId>,
    /// Free edges of the file, ascending: their shell uses them an odd number of times. The mesh is open there.
    pub free_edges: Vec<EdgeId>,
    /// Edges with an even number of uses that no orientation of the faces cancels, ascending. Unbalanced in the mesh.
    pub not_orientable: Vec<EdgeId>,
    /// Whether the part is closed after healing and orientation: the coedges of each shell sum to 0 on every edge, and
    /// every loop is a closed chain of vertices. Then the mesh is closed too.
    pub closed: bool,
    /// Centre of the part's bounding box. f32 positions are relative to it.
    pub centre: DVec3,
    /// Half the diagonal of that box.
    pub radius: f64,
    /// The model's part of which this is another level of detail. `None` for the model's parts themselves.
    pub mesh_of: Option<PartId>,
    /// Set by a session for its frames of views; `None` in other scenes.
    pub key: Option<PartKey>,
}

/// A placed part, as sinks see it.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneInstance {
    /// Index into [`Scene::parts`].
    pub part: PartId,
    /// Part to world, millimetres.
    pub transform: DAffine3,
    /// Overrides all face colours.
    pub colour: Option<Colour>,
    /// Whether views draw it. Files and checks have it in any case.
    pub visible: bool,
    /// Name, possibly empty. Shared with the model's instance.
    pub name: Arc<str>,
    /// The assembly that it stands in. Shared with the model's instance.
    pub assembly: Option<Arc<Assembly>>,
    /// The [number](Self::face_number) of its first face, when faces are numbered across all instances. Set by
    /// `prepare`; a session renumbers when instances come and go.
    pub first_face: u32,
    /// Set by a session for its frames of views; `None` in other scenes.
    pub key: Option<InstanceKey>,
}

/// Everything a sink gets besides triangles and lines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Name of the model.
    pub name: String,
    /// Parts; batches name them by index ([`PartId`]).
    pub parts: Vec<ScenePart>,
    /// Placed parts.
    pub instances: Vec<SceneInstance>,
}

impl SceneInstance {
    /// A visible instance without colour, name and assembly.
    #[must_use]
    pub fn new(part: PartId, transform: DAffine3) -> Self {
        Self { part, transform, colour: None, visible: true, name: "".into(), assembly: None, first_face: 0, key: None }
    }

    /// Uniform scale of the transform: the cube root of its determinant's absolute value.
    #[must_use]
    pub fn scale(&self) -> f64 {
        uniform_scale(&self.transform)
    }

    /// The number of one of its faces, of those of all instances. Beyond 2³² faces, numbers begin again.
    #[must_use]
    pub const fn face_number(&self, face: FaceId) -> u32 {
        self.first_face.wrapping_add(face.0)
    }
}

impl From<&Instance> for SceneInstance {
    fn from(stated: &Instance) -> Self {
        let Instance { part, transform, colour, name, assembly } = stated.clone();
        Self { part, transform, colour, visible: true, name, assembly, first_face: 0, key: None }
    }
}

impl Scene {
    /// Whether prepare found that a face is a point or a curve.
    pub(crate) fn has_no_area(&self, part: PartId, face: FaceId) -> bool {
        self.parts.get(part.index()).is_some_and(|part| part.without_area.binary_search(&face).is_ok())
    }

    /// Numbers the faces of instance `from` and all later ones, one instance after the other.
    pub(crate) fn number_faces(&mut self, from: usize) {
        let count = |instance: &SceneInstance| self.parts[instance.part.index()].face_colours.len() as u32;
        let before = self.instances[..from].last();
        let mut first = before.map_or(0, |before| before.first_face.wrapping_add(count(before)));
        for instance in &mut self.instances[from..] {
            instance.first_face = first;
            first = first.wrapping_add(count(instance));
        }
    }

    /// Appends an LOD of a part of the model, without a key.
    pub(crate) fn add_level(&mut self, part: PartId) {
        self.parts.push(ScenePart { mesh_of: Some(part), key: None, ..self.parts[part.index()].clone() });
    }

    /// The model's part of a part, which may be one of its LODs: both have the same tiles.
    pub(crate) fn of_model(&self, part: PartId) -> PartId {
        self.parts[part.index()].mesh_of.unwrap_or(part)
    }

    /// Moves all instances.
    pub fn translate(&mut self, by: DVec3) {
        for instance in &mut self.instances {
            instance.transform = DAffine3::from_translation(by) * instance.transform;
        }
    }

    /// The largest scale at which each part is placed. 1 for unplaced parts, and where that is not positive and finite.
    #[must_use]
    pub fn largest_scales(&self) -> Vec<f64> {
        let mut scales = vec![0.0_f64; self.parts.len()];
        for instance in &self.instances {
            if let Some(scale) = scales.get_mut(instance.part.index()) {
                *scale = scale.max(instance.scale());
            }
        }
        let usable = |scale: f64| if scale > 0.0 && scale.is_finite() { scale } else { 1.0 };
        scales.into_iter().map(usable).collect()
    }
}

/// See [`SceneInstance::scale`].
pub(crate) fn uniform_scale(transform: &DAffine3) -> f64 {
    /// Up to here the next term of the series is below half of the last digit.
    const RIGID: f64 = 1e-8;
    let volume = transform.matrix3.determinant().abs();
    // Most instances, but for rounding. A frame asks for all of them.
    let beyond = volume - 1.0;
    if beyond.abs() <= RIGID { 1.0 + beyond / 3.0 } else { libm::cbrt(volume) }
}

/// What differs between a scene and that of the last completed frame, however many frames were cancelled in between.
/// The default is for a sink that has nothing: all is new.
///
/// Instances that both scenes have are in the same order. New ones follow them.
#[derive(Clone, Copy, Debug, Default)]
pub struct SceneChanges<'a> {
    /// Keys of instances that are gone, each once.
    pub removed: &'a [InstanceKey],
    /// Rows of instances that both scenes have and whose LOD, transform, colour or visibility may differ. Ascending.
    /// The numbers of first faces differ after removed ones, too; these are not listed.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::PartId;
    use crate::sequence::random::SplitMix;
    use glam::{DAffine3, DMat3, DVec3};

    #[test]
    fn scales_near_one_are_cube_roots_to_the_bit() {
        let mut draw = SplitMix(9);
        for _ in 0..20_000 {
            // Both sides of where the series ends.
            let beyond = draw.range(-2e-8, 2e-8);
            let transform = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(1.0 + beyond, 1.0, 1.0)));
            let placed = SceneInstance::new(PartId(0), transform);
            let volume = transform.matrix3.determinant();
            assert_eq!(placed.scale().to_bits(), libm::cbrt(volume).to_bits(), "{volume}");
        }
    }
}
