//! STEP files -> models.

use crate::border::{Caller, entry, versioned};
use crate::control::{control, tt_control};
use crate::jobs::tt_jobs;
use crate::limits::{positive, set};
use crate::model::{add, tt_model};
use crate::status::{Failure, tt_status};
use crate::threads::Workplace;
use std::ffi::{c_char, c_void};
use std::path::Path;
use trimtess::import::step::{StepOptions, read_file_on, read_on};

/// Options of reading. Zeros are the defaults.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_read_options {
    /// `sizeof(tt_read_options)`.
    pub size: u32,
    /// Number of threads, which end with the call, at most 1024; 0 = one per core, see "Threads" at the head of this
    /// file.
    pub threads: u32,
    /// 1 reads construction geometry that has bounds, too.
    pub supplemental: u32,
    /// Syntax errors that are cut out before the file is refused; 0 = 16.
    pub max_syntax_repairs: u32,
    /// Largest error of curves and surfaces that have no exact form, millimetres; 0 = 0.001.
    pub fit_tolerance: f64,
    /// Length of the file at most; 0 = 2 GiB.
    pub max_bytes: u64,
    /// Memory of reading at most, bytes, estimated before it is taken; 0 = 16 GiB.
    pub max_memory: u64,
    /// Instances (`#n=`) in the file at most; 0 = 50 million.
    pub max_entities: u64,
    /// Placed parts and assemblies at most; 0 = 1 million.
    pub max_instances: u64,
    /// A pool that reads, instead of threads that end with the call; or null.
    pub jobs: *const tt_jobs,
}
versioned!(tt_read_options);

fn options(c: &Caller, from: *const tt_read_options) -> Result<(StepOptions, Workplace), Failure> {
    let from = c.read_or_zeros("options", from)?;
    let mut options = StepOptions::DEFAULT.with_supplemental(from.supplemental != 0);
    if let Some(tolerance) = positive("options.fit_tolerance", from.fit_tolerance)? {
        options = options.with_fit_tolerance(tolerance);
    }
    if from.max_syntax_repairs > 0 {
        options = options.with_max_syntax_repairs(from.max_syntax_repairs as usize);
    }
    set(&mut options.max_bytes, from.max_bytes);
    set(&mut options.max_memory, from.max_memory);
    set(&mut options.max_entities, from.max_entities);
    set(&mut options.max_instances, from.max_instances);
    Ok((options, Workplace::of(c, from.threads, from.jobs)?))
}

/// Reads a STEP file. What cannot be read is left out and told in diagnostics; the rest is read all the same.
///
/// `path` is UTF-8. `options` may be null, `control` a handle of zeros.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_read_file(
    path: *const c_char,
    options: *const tt_read_options,
    control: tt_control,
    model: *mut tt_model,
) -> tt_status {
    entry!(c => {
        let (path, out) = (c.text("path", path)?, c.out("model", model)?);
        let ((options, place), control) = (self::options(c, options)?, self::control(control)?);
        out.give(add(place.run(|jobs| read_file_on(jobs, Path::new(path), &options, &control))??));
        Ok(())
    })
}

/// Reads the content of a STEP file, as `tt_read_file`. `name` becomes the model's; it may be null. The bytes may be
/// freed once this returns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_read_memory(
    bytes: *const c_void,
    count: usize,
    name: *const c_char,
    options: *const tt_read_options,
    control: tt_control,
    model: *mut tt_model,
) -> tt_status {
    entry!(c => {
        let bytes: &[u8] = c.slice("bytes", bytes.cast(), count)?;
        let (name, out) = (c.text_or_empty("name", name)?, c.out("model", model)?);
        let ((options, place), control) = (self::options(c, options)?, self::control(control)?);
        let mut read = place.run(|jobs| read_on(jobs, bytes, &options, &control))??;
        if !name.is_empty() {
            name.clone_into(&mut read.name);
        }
        out.give(add(read));
        Ok(())
    })
}
