//! Levels of detail of a GLB (MSFT_lod): coarser meshes of a scene, and from which size on the screen each is drawn.

use crate::mesh::{FrameView, Scene};
use std::f64::consts::FRAC_PI_4;

/// Pixels of the screen on which a level is drawn as soon as its chord tolerance is a pixel or less.
const SCREEN: f64 = 1920.0 * 1080.0;

/// A coarser mesh of a scene, for [`save_levels`](super::save_levels).
#[derive(Clone, Debug)]
pub struct GlbLevel<'a> {
    /// A frame of the same parts and instances.
    pub frame: FrameView<'a>,
    /// The chord tolerance of the mesh, millimetres. Larger than that of the level before.
    pub chord: f64,
}

/// A level of detail that cannot stand for the finest one.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UnfitLevel {
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

/// Checks that `coarser` are levels of `scene`, finest first, and coarser than `chord`.
pub(super) fn check(scene: &Scene, chord: f64, coarser: &[GlbLevel<'_>]) -> Result<(), UnfitLevel> {
    let mut before = chord;
    for (level, GlbLevel { frame, chord }) in (1..).zip(coarser) {
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
    Ok(())
}

/// The nodes of the coarser levels of a node, and when they are drawn.
#[derive(Debug, Default)]
pub(super) struct Detail {
    /// Indices of nodes, finest first.
    nodes: Vec<u32>,
    /// The share of the screen below which each node replaces the level before it.
    shares: Vec<f32>,
}

impl Detail {
    /// Adds a node with a mesh of this chord tolerance, for a part whose sphere has this diameter, both millimetres.
    pub(super) fn add(&mut self, node: u32, diameter: f64, chord: f64) {
        let pixels = diameter / chord;
        self.nodes.push(node);
        self.shares.push((FRAC_PI_4 * pixels * pixels / SCREEN).min(1.0) as f32);
    }

    /// The node's extension, if there are levels.
    pub(super) fn extension(&self) -> Option<String> {
        (!self.nodes.is_empty()).then(|| format!(r#""MSFT_lod":{{"ids":{:?}}}"#, self.nodes))
    }

    /// What goes with the extension.
    pub(super) fn extra(&self) -> Option<String> {
        let shares = self.shares.iter().map(|share| format!("{share},"));
        (!self.nodes.is_empty()).then(|| format!(r#""MSFT_screencoverage":[{}0]"#, shares.collect::<String>()))
    }
}
