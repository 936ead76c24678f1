//! Models: parts and their instances, as read or built.

use crate::border::handles::Table;
use crate::border::{entry, versioned};
use crate::diagnostic::{self, tt_diagnostic};
use crate::status::{Failure, row, tt_status};
use std::ffi::c_char;
use std::sync::Arc;
use trimtess::model::{Model, Part, shapes};

/// A model: parts (B-reps) in their own coordinates, and their instances. It does not change, and any number of threads
/// may use it at the same time.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_model {
    pub id: u64,
}

/// What a model has.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_model_info {
    /// `sizeof(tt_model_info)`.
    pub size: u32,
    /// Number of parts.
    pub parts: u32,
    /// Number of placed parts.
    pub instances: u32,
    /// Number of diagnostics of reading.
    pub diagnostics: u32,
    /// Number of faces, each part once.
    pub faces: u64,
    /// Number of edges, each part once.
    pub edges: u64,
    /// Length unit of the file. Lengths of the model are already millimetres.
    pub millimetres_per_unit: f64,
}
versioned!(tt_model_info);

static MODELS: Table<Model> = Table::new(2);

pub(crate) fn add(model: Model) -> tt_model {
    tt_model { id: MODELS.add(model) }
}

pub(crate) fn get(model: tt_model) -> Result<Arc<Model>, Failure> {
    MODELS.get(model.id)
}

/// Makes a small model by name: "square", "box", "cylinder", "washer", "cone", "sphere", "torus", "wave", "pair" (two
/// parts, three instances) or "flower". For tests and examples.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_model_shape(name: *const c_char, model: *mut tt_model) -> tt_status {
    entry!(c => {
        let (name, out) = (c.text("name", name)?, c.out("model", model)?);
        let known = || Failure::argument(format!("no shape {name:?}; there are {}", shapes::NAMES.join(", ")));
        out.give(add(shapes::by_name(name).ok_or_else(known)?));
        Ok(())
    })
}

/// Counts what a model has.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_model_get_info(model: tt_model, info: *mut tt_model_info) -> tt_status {
    entry!(c => {
        let (model, out) = (get(model)?, c.out_struct("info", info)?);
        let sum = |of: fn(&Part) -> usize| model.parts.iter().map(|part| of(part) as u64).sum();
        out.give(&tt_model_info {
            size: 0,
            parts: model.parts.len() as u32,
            instances: model.instances.len() as u32,
            diagnostics: model.diagnostics.len() as u32,
            faces: sum(|part| part.faces.len()),
            edges: sum(|part| part.edges.len()),
            millimetres_per_unit: model.millimetres_per_unit,
        });
        Ok(())
    })
}

/// Copies the name of a model into `text`, see "Texts" at the head of this file.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_model_get_name(
    model: tt_model,
    text: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> tt_status {
    entry!(c => c.give_text(&get(model)?.name, text, capacity, length))
}

/// Copies the name of a part into `text`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_model_get_part_name(
    model: tt_model,
    part: u32,
    text: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> tt_status {
    entry!(c => {
        let model = get(model)?;
        c.give_text(&row(&model.parts, "part", part)?.name, text, capacity, length)
    })
}

/// Copies the name of an instance into `text`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_model_get_instance_name(
    model: tt_model,
    instance: u32,
    text: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> tt_status {
    entry!(c => {
        let model = get(model)?;
        c.give_text(&row(&model.instances, "instance", instance)?.name, text, capacity, length)
    })
}

/// Gives a diagnostic of reading, and copies its message into `text`. `diagnostic` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_model_get_diagnostic(
    model: tt_model,
    index: u32,
    diagnostic: *mut tt_diagnostic,
    text: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> tt_status {
    entry!(c => diagnostic::give(c, (&get(model)?.diagnostics, index), diagnostic, (text, capacity, length)))
}

/// Frees a model. Calls that use it, and what was prepared from it, go on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_model_free(model: tt_model) -> tt_status {
    entry!(_c => MODELS.free(model.id))
}
