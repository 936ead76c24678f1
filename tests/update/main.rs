//! Models that are edited at run time: an updated prepared model equals one that is prepared from nothing, and the sink
//! of an updated session one of a session that starts with the new model.
//!
//! A plain run makes some hundreds of edits. The long run is
//!
//! ```text
//! TRIMTESS_EDITS=10000 cargo test --release --test update -- --nocapture
//! ```
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../common/blocks.rs"]
mod blocks;
#[path = "../common/mod.rs"]
mod common;
mod edits;
mod faces;
#[cfg(feature = "step")]
#[path = "../corpus/folder.rs"]
mod folder;
mod lists;
mod prepared;
#[path = "../sequence/random.rs"]
mod random;
mod sessions;

use glam::{DAffine3, DVec3};
use trimtess::model::{Instance, Model, Part, PartId};

/// Edits of this run, in all models together.
fn edits() -> u64 {
    std::env::var("TRIMTESS_EDITS").ok().and_then(|text| text.parse().ok()).unwrap_or(240)
}

/// Small parts of all kinds, also with free trims and without holes.
fn pool() -> Vec<Part> {
    let names = ["box", "cylinder", "washer", "cone", "sphere", "torus", "square", "wave", "flower"];
    names.iter().map(|name| trimtess::model::shapes::by_name(name).unwrap().parts.remove(0)).collect()
}

/// Parts in a row, and a few instances of one of them, far and near.
fn built() -> Model {
    let parts = pool();
    let place = |part: u32, at: DVec3| Instance {
        name: format!("{part}").into(),
        ..Instance::new(PartId(part), DAffine3::from_translation(at))
    };
    let mut instances: Vec<Instance> =
        (0..parts.len() as u32).map(|k| place(k, DVec3::new(12.0 * f64::from(k) - 40.0, 0.0, 0.0))).collect();
    instances.extend((1..6).map(|k| place(2, DVec3::new(0.0, 3.0 * f64::from(k * k), 3.0))));
    Model { name: "built".into(), parts, instances, ..Model::default() }
}

#[cfg(feature = "step")]
fn read(path: &std::path::Path) -> Model {
    use trimtess::import::step;
    step::read_file(path, &step::StepOptions::DEFAULT).unwrap()
}

/// The built model, and files: solids with holes, and assemblies of the corpus, if that is there.
#[cfg(feature = "step")]
fn models() -> Vec<Model> {
    let data = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let mut models = vec![built(), read(&data.join("red_cube_blue_cylinder.step"))];
    if let Some(corpus) = folder::corpus() {
        models.extend(["as1_oc_214.stp", "mini_heatsink.stp", "screw.step"].map(|name| read(&corpus.join(name))));
    }
    models
}

#[cfg(not(feature = "step"))]
fn models() -> Vec<Model> {
    vec![built()]
}
