//! Placed parts -> objects of JavaScript.

use serde::Serialize;
use std::collections::HashMap;
use std::sync::Arc;
use trimtess::glam::{DAffine3, DMat4};
use trimtess::mesh::Scene;
use trimtess::model;
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
    /// Index of the assembly that it stands in.
    #[tsify(optional)]
    assembly: Option<u32>,
}

/// An assembly of the product structure, at one place in it.
#[derive(Serialize, Tsify)]
pub struct Assembly {
    name: String,
    /// Index of the assembly that it stands in: a smaller one.
    #[tsify(optional)]
    parent: Option<u32>,
}

/// The instances of a scene, and the assemblies that they stand in: parents first, in the order of their instances.
pub(crate) fn placed(scene: &Scene) -> (Vec<Instance>, Vec<Assembly>) {
    let matrix = |transform: &DAffine3| DMat4::from(*transform).to_cols_array();
    let mut assemblies = Assemblies::default();
    let instances = scene.instances.iter().map(|placed| Instance {
        name: placed.name.to_string(),
        part: placed.part.0,
        matrix: matrix(&placed.transform),
        colour: placed.colour,
        assembly: placed.assembly.as_ref().map(|assembly| assemblies.index(assembly)),
    });
    (instances.collect(), assemblies.rows)
}

/// Assemblies that were met, by their allocation.
#[derive(Default)]
struct Assemblies {
    known: HashMap<*const model::Assembly, u32>,
    rows: Vec<Assembly>,
}

impl Assemblies {
    /// The row of an assembly. Recursion is as deep as assemblies are nested: the reader limits that.
    fn index(&mut self, assembly: &Arc<model::Assembly>) -> u32 {
        let key = Arc::as_ptr(assembly);
        if let Some(&row) = self.known.get(&key) {
            return row;
        }
        let parent = assembly.parent.as_ref().map(|parent| self.index(parent));
        let row = self.rows.len() as u32;
        self.rows.push(Assembly { name: assembly.name.to_string(), parent });
        self.known.insert(key, row);
        row
    }
}
