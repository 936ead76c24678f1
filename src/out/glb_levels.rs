//! Levels of detail of a GLB (MSFT_lod): from which size on the screen each is drawn.

use std::f64::consts::FRAC_PI_4;

/// Pixels of the screen on which a level is drawn as soon as its chord tolerance is a pixel or less.
const SCREEN: f64 = 1920.0 * 1080.0;

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
