//! Placed parts -> objects of JavaScript.

use serde::Serialize;
use trimtess::glam::{DAffine3, DMat4};
use trimtess::mesh::Scene;
use tsify::Tsify;

/// A placed part.
#[derive(Serialize, Tsify)]
pub struct Instance {
    name: String,
    part: u32,
    /// From the part's coordinates to the world, by columns.
    #[tsify(type = "number[]")]
    matrix: [f64; 16],
    /// Overrides the colours of all faces.
    #[tsify(optional)]
    colour: Option<[f32; 4]>,
}

/// The instances of a scene.
pub(crate) fn instances(scene: &Scene) -> Vec<Instance> {
    let matrix = |transform: &DAffine3| DMat4::from(*transform).to_cols_array();
    let instances = scene.instances.iter().map(|placed| Instance {
        name: placed.name.to_string(),
        part: placed.part.0,
        matrix: matrix(&placed.transform),
        colour: placed.colour,
    });
    instances.collect()
}
