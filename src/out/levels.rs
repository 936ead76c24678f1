//! Meshes of a scene with different tolerances, as levels of detail of one file.

use crate::mesh::{FrameView, Scene};

/// A mesh of a scene, and its tolerance, for [`Outputs::save_on`](super::Outputs::save_on).
#[derive(Clone, Debug)]
pub struct MeshLevel<'a> {
    /// The mesh. That of a coarser level has the same parts and instances.
    pub frame: FrameView<'a>,
    /// The chord tolerance of the mesh, millimetres. Larger than that of the level before. Decides when the level is
    /// drawn; means nothing where there is one level.
    pub chord: f64,
}

/// Meshes that are not levels of detail of one scene.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UnfitLevel {
    /// There is no level.
    #[error("there is no level of detail to write")]
    Missing,
    /// The format stores one level. GLB stores more.
    #[error("there are {levels} levels of detail; only a GLB has more than one")]
    Format {
        /// Number of levels.
        levels: usize,
    },
    /// It has other parts or instances.
    #[error("level {level} has other parts or instances than level 0")]
    OtherScene {
        /// Its number. The finest level is 0.
        level: usize,
    },
    /// Its chord tolerance is not finite, or not larger than that of the level before.
    #[error("level {level} has a chord tolerance of {chord} mm, which is not larger than {before} mm")]
    Chord {
        /// Its number. The finest level is 0.
        level: usize,
        /// Its chord tolerance, millimetres.
        chord: f64,
        /// That of the level before, millimetres.
        before: f64,
    },
}

/// The levels, if they are of one scene, finest first.
pub(super) fn checked<'a, 'b>(levels: &'b [MeshLevel<'a>]) -> Result<&'b [MeshLevel<'a>], UnfitLevel> {
    let [finest, coarser @ ..] = levels else { return Err(UnfitLevel::Missing) };
    let (scene, mut before): (&Scene, f64) = (finest.frame.scene, finest.chord);
    for (level, MeshLevel { frame, chord }) in (1..).zip(coarser) {
        let parts = frame.scene.parts.iter().zip(&scene.parts);
        let instances = frame.scene.instances.iter().zip(&scene.instances);
        let is_same = (frame.scene.parts.len(), frame.scene.instances.len())
            == (scene.parts.len(), scene.instances.len())
            && parts.clone().all(|(a, b)| (&a.name, &a.face_colours) == (&b.name, &b.face_colours))
            && parts.clone().all(|(a, b)| (a.centre, a.radius) == (b.centre, b.radius))
            && instances.clone().all(|(a, b)| (a.part, a.first_face) == (b.part, b.first_face))
            && instances.clone().all(|(a, b)| (a.transform, a.colour) == (b.transform, b.colour));
        if !is_same {
            return Err(UnfitLevel::OtherScene { level });
        }
        if !(chord.is_finite() && *chord > before) {
            return Err(UnfitLevel::Chord { level, chord: *chord, before });
        }
        before = *chord;
    }
    Ok(levels)
}
