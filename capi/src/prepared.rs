//! Models -> models that are ready for tessellation, once per model.

use crate::border::handles::Table;
use crate::border::{entry, versioned};
use crate::control::{control, tt_control};
use crate::diagnostic::{self, tt_diagnostic};
use crate::jobs::tt_jobs;
use crate::limits::set;
use crate::model::{self, tt_model};
use crate::status::{Failure, row, tt_status};
use crate::threads::Workplace;
use std::ffi::c_char;
use std::sync::Arc;
use trimtess::mesh::SceneInstance;
use trimtess::prepare::{PrepareLimits, PrepareOptions, Prepared};

/// A model that is ready for tessellation at any tolerance. It does not change, and any number of threads and sessions
/// may use it at the same time.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_prepared {
    pub id: u64,
}

/// Options of preparing. Zeros are the defaults.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_prepare_options {
    /// `sizeof(tt_prepare_options)`.
    pub size: u32,
    /// Number of threads, which end with the call, at most 1024; 0 = one per core, see "Threads" at the head of this
    /// file.
    pub threads: u32,
    /// Bezier patches at most; 0 = 16 million.
    pub max_patches: u64,
    /// Memory at most, bytes, estimated; 0 = 16 GiB.
    pub max_memory: u64,
    /// Distance up to which borders of faces without edges, and edges of faces in open shells, become one, as a
    /// fraction of the part's diagonal, up to 1; 0 = 1e-6, below 0 = they never do, which 0 says in Rust and Python.
    pub border_tolerance: f64,
    /// A pool that prepares, instead of threads that end with the call; or null.
    pub jobs: *const tt_jobs,
    /// Another prepared model, of which parts that both have are taken over: faster, and the same. Or a null handle.
    pub like: tt_prepared,
    /// Whether to keep the drafts of faces, and to take over those of `like` for faces of a changed part, 0 or 1. Costs
    /// memory: a seventh of the prepared model.
    pub keep_faces: u32,
    /// 0.
    pub reserved: u32,
}
versioned!(tt_prepare_options, reserved);

/// What a prepared model has.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_prepared_info {
    /// `sizeof(tt_prepared_info)`.
    pub size: u32,
    /// Number of parts.
    pub parts: u32,
    /// Number of placed parts.
    pub instances: u32,
    /// Number of diagnostics, those of reading included.
    pub diagnostics: u32,
    /// Number of tiles, each part once.
    pub tiles: u64,
    /// 1 if something is placed, so that there are bounds.
    pub has_bounds: u32,
    /// 0.
    pub reserved: u32,
    /// Lower corner of the box of the placed model, millimetres, to about 0.1 %.
    pub low: [f64; 3],
    /// Upper corner.
    pub high: [f64; 3],
    /// Diagonal of that box.
    pub diagonal: f64,
}
versioned!(tt_prepared_info);

/// A part.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_part {
    /// `sizeof(tt_part)`.
    pub size: u32,
    /// Number of faces.
    pub faces: u32,
    /// Number of tiles.
    pub tiles: u32,
    /// 1 if it is closed, so that its meshes are, else 0.
    pub closed: u32,
    /// Centre of its box, in its own coordinates, millimetres. f32 positions count from it.
    pub centre: [f64; 3],
    /// Half the diagonal of that box.
    pub radius: f64,
}
versioned!(tt_part);

/// A placed part. Will not grow.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_instance {
    /// The part, or the level of detail of it that this frame draws.
    pub part: u32,
    /// Index of its first face where faces are numbered across all instances.
    pub first_face: u32,
    /// Part to world, millimetres: x, y and z axis, then the origin, 3 numbers each.
    pub transform: [f64; 12],
    /// 1 if `colour` overrides the colours of the faces.
    pub has_colour: u32,
    /// Red, green, blue (sRGB) and opacity, 0 to 1.
    pub colour: [f32; 4],
    /// 1 if views do not draw it: `tt_session_set_instance`, `tt_session_set_part`.
    pub hidden: u32,
}

static PREPARED: Table<Arc<Prepared>> = Table::new(4);

pub(crate) fn get(prepared: tt_prepared) -> Result<Arc<Prepared>, Failure> {
    Ok(Arc::clone(PREPARED.get(prepared.id)?.as_ref()))
}

/// Prepares a model for tessellation, once for all tolerances. The model stays. About 20 to 200 microseconds per face,
/// divided among threads.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_prepare(
    model: tt_model,
    options: *const tt_prepare_options,
    control: tt_control,
    prepared: *mut tt_prepared,
) -> tt_status {
    entry!(c => {
        let (model, out) = (model::get(model)?, c.out("prepared", prepared)?);
        let (from, control) = (c.read_or_zeros("options", options)?, self::control(control)?);
        let border = match from.border_tolerance {
            0.0 => PrepareOptions::DEFAULT.border_tolerance,
            share if share <= 1.0 => share.max(0.0),
            share => return Err(Failure::argument(format!("options.border_tolerance is {share}, not up to 1"))),
        };
        let mut limits = PrepareLimits::DEFAULT;
        set(&mut limits.patches, from.max_patches);
        set(&mut limits.bytes, from.max_memory);
        let options = PrepareOptions::DEFAULT.with_limits(limits).with_border_tolerance(border);
        let options = options.with_keep_faces(from.keep_faces != 0);
        let like = if from.like.id == 0 { Arc::default() } else { get(from.like)? };
        let place = Workplace::of(c, from.threads, from.jobs)?;
        let made = place.run(|jobs| like.update_on(jobs, &model, &options, &control))??;
        out.give(tt_prepared { id: PREPARED.add(Arc::new(made)) });
        Ok(())
    })
}

/// Counts and measures a prepared model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_prepared_get_info(prepared: tt_prepared, info: *mut tt_prepared_info) -> tt_status {
    entry!(c => {
        let (prepared, out) = (get(prepared)?, c.out_struct("info", info)?);
        let [low, high] = prepared.bounds.unwrap_or_default();
        out.give(&tt_prepared_info {
            size: 0,
            parts: prepared.scene.parts.len() as u32,
            instances: prepared.scene.instances.len() as u32,
            diagnostics: prepared.diagnostics.len() as u32,
            tiles: prepared.tiles().count() as u64,
            has_bounds: prepared.bounds.is_some().into(),
            reserved: 0,
            low: low.to_array(),
            high: high.to_array(),
            diagonal: prepared.diagonal,
        });
        Ok(())
    })
}

pub(crate) fn instance(placed: &SceneInstance) -> tt_instance {
    tt_instance {
        part: placed.part.0,
        first_face: placed.first_face,
        transform: placed.transform.to_cols_array(),
        has_colour: placed.colour.is_some().into(),
        colour: placed.colour.unwrap_or_default(),
        hidden: (!placed.visible).into(),
    }
}

/// Describes a part.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_prepared_get_part(prepared: tt_prepared, index: u32, part: *mut tt_part) -> tt_status {
    entry!(c => {
        let (prepared, out) = (get(prepared)?, c.out_struct("part", part)?);
        let found = row(&prepared.scene.parts, "part", index)?;
        out.give(&tt_part {
            size: 0,
            faces: found.face_colours.len() as u32,
            tiles: prepared.parts[index as usize].tiles.len() as u32,
            closed: found.closed.into(),
            centre: found.centre.to_array(),
            radius: found.radius,
        });
        Ok(())
    })
}

/// Copies the name of a part into `text`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_prepared_get_part_name(
    prepared: tt_prepared,
    index: u32,
    text: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> tt_status {
    entry!(c => c.give_text(&row(&get(prepared)?.scene.parts, "part", index)?.name, text, capacity, length))
}

/// Gives the colour of a face, its own or its part's: red, green, blue (sRGB) and opacity, 0 to 1. `colour` has room
/// for 4 numbers. `has_colour` gets 0 where the file states none; `colour` is not written then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_prepared_get_face_colour(
    prepared: tt_prepared,
    part: u32,
    face: u32,
    has_colour: *mut u32,
    colour: *mut f32,
) -> tt_status {
    entry!(c => {
        let prepared = get(prepared)?;
        let (has, to) = (c.out("has_colour", has_colour)?, c.out("colour", colour.cast::<[f32; 4]>())?);
        let colours = &row(&prepared.scene.parts, "part", part)?.face_colours;
        let found = row(colours, "face", face)?;
        has.give(found.is_some().into());
        if let Some(colour) = *found {
            to.give(colour);
        }
        Ok(())
    })
}

/// Describes an instance. `instance` need not be set before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_prepared_get_instance(
    prepared: tt_prepared,
    index: u32,
    instance: *mut tt_instance,
) -> tt_status {
    entry!(c => {
        let (prepared, out) = (get(prepared)?, c.out("instance", instance)?);
        out.give(self::instance(row(&prepared.scene.instances, "instance", index)?));
        Ok(())
    })
}

/// Copies the name of an instance into `text`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_prepared_get_instance_name(
    prepared: tt_prepared,
    index: u32,
    text: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> tt_status {
    entry!(c => c.give_text(&row(&get(prepared)?.scene.instances, "instance", index)?.name, text, capacity, length))
}

/// Gives a diagnostic of reading and preparing, and copies its message into `text`. `diagnostic` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_prepared_get_diagnostic(
    prepared: tt_prepared,
    index: u32,
    diagnostic: *mut tt_diagnostic,
    text: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> tt_status {
    entry!(c => diagnostic::give(c, (&get(prepared)?.diagnostics, index), diagnostic, (text, capacity, length)))
}

/// Frees a prepared model. Calls and sessions that use it go on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_prepared_free(prepared: tt_prepared) -> tt_status {
    entry!(_c => PREPARED.free(prepared.id))
}
