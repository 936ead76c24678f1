//! What a sink needs to know beside triangles: parts, instances, names, colours.

use crate::model::{Colour, EdgeId, FaceId, PartId};
use glam::{DAffine3, DVec3};

/// A part as output sees it.
#[derive(Clone, Debug, Default)]
pub struct ScenePart {
    /// Name, possibly empty.
    pub name: String,
    /// Colour of each face (already resolved: face, else part); `None` = the viewer's default.
    pub face_colours: Vec<Option<Colour>>,
    /// Faces on surfaces without any area, ascending: there is nothing to mesh, and nothing is lost.
    pub without_area: Vec<FaceId>,
    /// Edges that the file leaves free: the faces of their shell use them an odd number of times. Ascending; the mesh is open there.
    pub free_edges: Vec<EdgeId>,
    /// Edges whose faces cannot be turned so that they cancel, though there is an even number of uses. Ascending; the mesh is
    /// unbalanced there.
    pub not_orientable: Vec<EdgeId>,
    /// Whether the part is closed as stated: after healing and orientation the coedges of each shell sum to 0 on every edge, and
    /// every loop is a closed chain of vertices. Then the mesh is closed too.
    pub closed: bool,
    /// Centre of the part's box: f32 positions are relative to it. Stored once, the same for all faces.
    pub centre: DVec3,
    /// Half the diagonal of that box.
    pub radius: f64,
    /// The part that this is a further mesh of, finer or coarser, for some of its instances; `None` for a part of the model.
    pub mesh_of: Option<PartId>,
}

/// A placed part as output sees it.
#[derive(Clone, Debug)]
pub struct SceneInstance {
    /// Index into [`Scene::parts`].
    pub part: PartId,
    /// Part to world, millimetres.
    pub transform: DAffine3,
    /// Overrides all face colours.
    pub colour: Option<Colour>,
    /// Name, possibly empty.
    pub name: String,
    /// Number of the instance's first face in the count that runs over all instances.
    pub first_face: u32,
}

/// Everything beside triangles.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Name of the model.
    pub name: String,
    /// Parts; batches name them by index ([`PartId`]).
    pub parts: Vec<ScenePart>,
    /// Placed parts.
    pub instances: Vec<SceneInstance>,
}

impl SceneInstance {
    /// How much larger the part is in the world than in its own millimetres.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.transform.matrix3.determinant().abs().cbrt()
    }
}

impl Scene {
    /// The largest scale at which each part is placed; 1 for parts that are not placed.
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
