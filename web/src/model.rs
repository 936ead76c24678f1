//! Bytes of a file, or a built-in model -> a prepared model.

use crate::diagnostic::{Diagnostic, listed};
use crate::instance::{Assembly, Instance, placed};
use crate::limits::MEMORY;
use crate::mesh::{Mesh, Tolerance};
use crate::progress::{self, Progress};
use crate::told;
use serde::Serialize;
use std::path::Path;
use std::sync::Arc;
use trimtess::control::Alone;
use trimtess::frame::PlanLimits;
use trimtess::import::step::{self, StepError, StepOptions};
use trimtess::model::{self, PartId};
use trimtess::prepare::{self, PrepareLimits, PrepareOptions};
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::*;

/// Reading takes about ten bytes of memory for each byte of a file.
const READ: StepOptions = StepOptions::DEFAULT.with_max_bytes(MEMORY / 10).with_max_memory(MEMORY);

/// Bytes of the module's memory. It never shrinks.
#[wasm_bindgen(js_name = memoryBytes)]
#[must_use]
pub fn memory_bytes() -> f64 {
    let pages = core::arch::wasm32::memory_size(0);
    65_536.0 * pages as f64
}

/// The words with which a file of so many bytes is refused before it is read, if it is.
#[wasm_bindgen]
#[must_use]
pub fn refusal(bytes: f64) -> Option<String> {
    // Sizes of files are integers far below 2^53.
    let (bytes, limit) = (bytes as u64, READ.max_bytes);
    (bytes > limit).then(|| StepError::TooLarge { bytes, limit }.to_string())
}

/// Reads a STEP file. The model has the file's name, without extension.
///
/// # Errors
/// Those of the reader.
#[wasm_bindgen]
pub fn read(bytes: &[u8], name: &str, progress: Option<Progress>) -> Result<Model, JsError> {
    let mut model = step::read_on(&Alone, bytes, &READ, &progress::control(progress)).map_err(told)?;
    model.name = Path::new(name).file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    Ok(model.into())
}

/// Makes a built-in model.
///
/// # Errors
/// If there is none of that name.
#[wasm_bindgen]
pub fn sample(name: &str) -> Result<Model, JsError> {
    let model = trimtess_models::by_name(name);
    model.map(Model::from).ok_or_else(|| told(format!("unknown model builtin:{name}")))
}

/// A model as the file states it.
#[wasm_bindgen]
pub struct Model {
    pub(crate) model: model::Model,
    /// Parts that this instance of the module prepares. The others are empty.
    pub(crate) owned: Vec<bool>,
    /// Instances that share the parts.
    pub(crate) shares: usize,
}

impl From<model::Model> for Model {
    fn from(model: model::Model) -> Self {
        Self { owned: vec![true; model.parts.len()], shares: 1, model }
    }
}

#[wasm_bindgen]
impl Model {
    /// Prepares the model for tessellation, and consumes it.
    ///
    /// # Errors
    /// If a limit is exceeded.
    pub fn prepare(self, progress: Option<Progress>) -> Result<Prepared, JsError> {
        let limits = PrepareLimits::DEFAULT.with_bytes(MEMORY);
        let options = PrepareOptions::DEFAULT.with_limits(limits);
        let Self { model, owned, shares } = self;
        let mut prepared = prepare::prepare_on(&Alone, &model, &options, &progress::control(progress)).map_err(told)?;
        // What preparing says of parts without faces of their own, their owners know better.
        let of_reading = model.diagnostics.len();
        let of_preparing = prepared.diagnostics.split_off(of_reading);
        prepared.diagnostics.extend(of_preparing.into_iter().filter(|told| is_owned(&owned, told.part)));
        Ok(Prepared { prepared: Arc::new(prepared), owned, shares, of_reading })
    }
}

/// A model that is ready for tessellation.
#[wasm_bindgen]
pub struct Prepared {
    prepared: Arc<prepare::Prepared>,
    owned: Vec<bool>,
    shares: usize,
    /// Number of diagnostics of reading, which come first.
    of_reading: usize,
}

impl Prepared {
    pub(crate) fn of(&self) -> &Arc<prepare::Prepared> {
        &self.prepared
    }
}

/// Whether the worker owns the part. True where no part is named.
pub(crate) fn is_owned(owned: &[bool], part: Option<PartId>) -> bool {
    part.is_none_or(|part| owned.get(part.index()).is_some_and(|owned| *owned))
}

#[wasm_bindgen]
impl Prepared {
    /// What was read: parts, instances, counts, box.
    ///
    /// # Errors
    /// Those of making objects.
    pub fn info(&self) -> Result<Ts<Info>, JsError> {
        let prepared = &*self.prepared;
        let parts = prepared.scene.parts.iter();
        let parts: Vec<PartInfo> =
            parts.map(|part| PartInfo { name: part.name.clone(), faces: part.face_colours.len() }).collect();
        let (instances, assemblies) = placed(&prepared.scene);
        let info = Info {
            name: prepared.scene.name.clone(),
            faces: parts.iter().map(|part| part.faces).sum(),
            parts,
            instances,
            assemblies,
            tiles: prepared.tiles().count(),
            bounds: prepared.bounds.map(|corners| corners.map(Into::into)),
            diagonal: prepared.diagonal,
        };
        Ok(info.into_ts()?)
    }

    /// What reading and preparing repaired, approximated or lost.
    ///
    /// # Errors
    /// Those of making objects.
    pub fn diagnostics(&self) -> Result<Vec<Ts<Diagnostic>>, JsError> {
        listed(&self.prepared.diagnostics)
    }

    /// Number of diagnostics of reading, which come first among [`diagnostics`](Self::diagnostics) and are the same in
    /// all instances of the module.
    #[wasm_bindgen(js_name = ofReading)]
    #[must_use]
    pub fn of_reading(&self) -> usize {
        self.of_reading
    }

    /// Tessellates the parts of this instance of the module within a tolerance. They are those of the program, bit by
    /// bit. `diagonal` is that of the whole model, if this instance has a share of it.
    ///
    /// # Errors
    /// If the tolerance cannot be met, or a limit is exceeded.
    pub fn tessellate(
        &self,
        tolerance: Ts<Tolerance>,
        progress: Option<Progress>,
        diagonal: Option<f64>,
    ) -> Result<Mesh, JsError> {
        let diagonal = diagonal.unwrap_or(self.prepared.diagonal);
        let tolerance = tolerance.to_rust()?;
        // One instance gathers what all of them make.
        let limits = PlanLimits::DEFAULT.with_bytes(MEMORY / self.shares as u64);
        Mesh::make((&self.prepared, &self.owned), (&tolerance, diagonal, &limits), &progress::control(progress))
    }
}

/// What was read.
#[derive(Serialize, Tsify)]
pub struct Info {
    name: String,
    parts: Vec<PartInfo>,
    instances: Vec<Instance>,
    /// What instances stand in. Parents come before what stands in them.
    assemblies: Vec<Assembly>,
    /// Faces of all parts, each part counted once.
    faces: usize,
    /// Tiles of all parts, each part counted once.
    tiles: usize,
    /// Lowest and highest corner of the trimmed, placed model, millimetres.
    #[tsify(optional)]
    bounds: Option<[[f64; 3]; 2]>,
    /// Diagonal of that box, millimetres.
    diagonal: f64,
}

/// A part.
#[derive(Serialize, Tsify)]
pub struct PartInfo {
    name: String,
    faces: usize,
}
