//! Sessions: frames for moving cameras, or by a tolerance, into a sink of callbacks.

use crate::border::handles::{Exclusive, Table};
use crate::border::{Caller, OutStruct, entry};
use crate::builder::{transform, tt_placement};
use crate::control::{control, tt_control};
use crate::jobs::{pool, tt_jobs};
use crate::layout::{layout, tt_layout};
use crate::limits::finite;
use crate::memory::{Memory, tt_memory};
use crate::mesh::{allowed, tolerance, tt_tolerance};
use crate::options::{duration, options, report, tt_report, tt_session_info, tt_session_options};
use crate::prepared::{self, instance, tt_instance, tt_prepared};
use crate::sink::{Lists, Sink, tt_sink};
use crate::status::{self, Failure, tt_status};
use crate::view::{tt_view, view};
use std::sync::{Arc, Mutex};
use trimtess::control::Alone;
use trimtess::mesh::{InstanceKey, SceneInstance};
use trimtess::model::PartId;
use trimtess::parallel::{EditError, FrameReport, Session};
use trimtess::view::View;

/// Workers for one prepared model, and one sink that they keep up to date.
///
/// One thread at a time uses it, any: a call that comes while another one is in progress, also from a callback of that
/// one, returns TT_ERROR_BUSY and does nothing.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_session {
    pub id: u64,
}

struct Row {
    session: Session,
    lists: Lists,
    diagonal: f64,
}

static SESSIONS: Table<Exclusive<Row>> = Table::new(6);

fn with<R>(session: tt_session, work: impl FnOnce(&mut Row) -> Result<R, Failure>) -> Result<R, Failure> {
    SESSIONS.with(session.id, work)
}

/// Works on a session that no other call uses.
pub(crate) fn with_session<R>(
    session: tt_session,
    work: impl FnOnce(&mut Session) -> Result<R, Failure>,
) -> Result<R, Failure> {
    with(session, |row| work(&mut row.session))
}

/// Starts a session. It keeps the prepared model alive.
///
/// `options` may be null. `jobs` may be null: then the session starts threads of its own, which end when it is freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_new(
    prepared: tt_prepared,
    options: *const tt_session_options,
    jobs: *const tt_jobs,
    session: *mut tt_session,
) -> tt_status {
    entry!(c => {
        let (prepared, out) = (prepared::get(prepared)?, c.out("session", session)?);
        let ((options, no_threads), jobs) = (self::options(c, options)?, pool(c, jobs)?);
        let (lists, diagonal) = (Lists::default(), prepared.diagonal);
        let session = match jobs {
            Some(_) if no_threads => return Err(Failure::argument("options.no_threads is 1, and there are jobs")),
            Some(_) if options.threads > 0 => {
                return Err(Failure::argument(format!("options.threads is {}, and there are jobs", options.threads)));
            }
            None if no_threads && options.threads > 0 => {
                return Err(Failure::argument(format!("options.threads is {}, and no_threads is 1", options.threads)));
            }
            Some(jobs) => Session::start_on(jobs, prepared, &options),
            None if no_threads => Session::start_on(Arc::new(Alone), prepared, &options),
            None => Session::start(prepared, &options)?,
        };
        out.give(tt_session { id: SESSIONS.add(Mutex::new(Some(Row { session, lists, diagonal }))) });
        Ok(())
    })
}

/// Goes on with another prepared model: one of a file that has changed, prepared with `tt_prepare_options.like`. The
/// next frame of views has the tiles that differ, and `tt_scene.from` tells which parts are which. Its instances
/// replace all others; keys from before name none. Cancels a frame that was begun, and waits for its tiles in progress.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_update(session: tt_session, prepared: tt_prepared) -> tt_status {
    entry!(_c => {
        let prepared = prepared::get(prepared)?;
        with(session, |row| {
            row.diagonal = prepared.diagonal;
            Ok(row.session.update(prepared)?)
        })
    })
}

/// Has workers write tiles into the caller's memory, in its layout, from the next frame on, which is a whole one. The
/// sink then gets tiles with a `place` and without arrays. `layout` may be null. Cancels a frame that was begun, and
/// waits for its tiles in progress.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_write_into(
    session: tt_session,
    layout: *const tt_layout,
    memory: *const tt_memory,
) -> tt_status {
    entry!(c => {
        let (layout, memory) = (self::layout(c, layout)?, Memory::of(c, memory)?);
        with(session, |row| {
            row.session.write_into(layout, Arc::new(memory));
            Ok(())
        })
    })
}

fn views(c: &Caller, from: *const tt_view, count: usize) -> Result<Vec<View>, Failure> {
    let from = c.structs("views", from, count)?;
    from.iter().enumerate().map(|(k, from)| view(&format!("views[{k}]"), from)).collect()
}

/// Begins a frame for all these views together: one picture, both eyes, shadow maps. A job plans and makes it; this
/// returns at once, unless `no_threads` is 1 or `tt_jobs.spawn` runs the job itself: then it makes the frame. Cancels a
/// frame that was begun and not finished; its changes become part of this one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_begin(session: tt_session, views: *const tt_view, count: usize) -> tt_status {
    entry!(c => {
        let views = self::views(c, views, count)?;
        with(session, |row| Ok(row.session.begin(&views)?))
    })
}

/// What runs a frame to its end.
type Finish<'a> = &'a dyn Fn(&mut Session, &mut Sink<'_>) -> Result<Option<tt_report>, Failure>;

/// The report of a frame of views.
fn seen(session: &Session, made: &FrameReport) -> tt_report {
    report(made, session.shortfall())
}

/// Runs a frame into a sink of C, and gives its report.
fn frame(
    c: &Caller,
    session: tt_session,
    (sink, report): (*const tt_sink, *mut tt_report),
    finish: Finish<'_>,
) -> Result<tt_status, Failure> {
    let out: Option<OutStruct<'_, tt_report>> = c.out_struct_if("report", report)?;
    with(session, |row| {
        let made = finish(&mut row.session, &mut Sink::of(c, sink, &mut row.lists)?)?;
        let Some(made) = made else { return Ok(tt_status::TT_PENDING) };
        out.into_iter().for_each(|out| out.give(&made));
        Ok(tt_status::TT_OK)
    })
}

/// Makes the frame that was begun, or helps those that make it, then brings the sink up to date. Without a frame that
/// was begun, does nothing. `report` may be null.
///
/// The sink must be that of the frames before; after another one, or an emptied one, call `tt_session_forget`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_finish(
    session: tt_session,
    sink: *const tt_sink,
    report: *mut tt_report,
) -> tt_status {
    entry!(c => frame(c, session, (sink, report), &|session, sink| {
        let made = session.finish(sink)?;
        Ok(Some(seen(session, &made)))
    }))
}

/// As `tt_session_finish`, but waits no longer than so many seconds: TT_PENDING if the frame is not made by then, and
/// the sink keeps the last one. Makes no part of the frame on this thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_finish_within(
    session: tt_session,
    seconds: f64,
    sink: *const tt_sink,
    report: *mut tt_report,
) -> tt_status {
    entry!(c => {
        if seconds.is_nan() || seconds < 0.0 {
            return Err(Failure::argument(format!("seconds is {seconds}; it must be 0 or more")));
        }
        frame(c, session, (sink, report), &|session, sink| {
            let made = session.finish_within(duration(seconds), sink)?;
            Ok(made.map(|made| seen(session, &made)))
        })
    })
}

/// `tt_session_begin` and `tt_session_finish`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_view(
    session: tt_session,
    views: *const tt_view,
    count: usize,
    sink: *const tt_sink,
    report: *mut tt_report,
) -> tt_status {
    entry!(c => {
        let views = self::views(c, views, count)?;
        frame(c, session, (sink, report), &|session, sink| {
            let made = session.view(&views, sink)?;
            Ok(Some(seen(session, &made)))
        })
    })
}

/// Tessellates the whole model within a tolerance, as `tt_tessellate`, into a sink, and into the caller's memory if the
/// session writes there. The next frame of views is a whole one. `report` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_tessellate(
    session: tt_session,
    tolerance: *const tt_tolerance,
    control: tt_control,
    sink: *const tt_sink,
    report: *mut tt_report,
) -> tt_status {
    entry!(c => {
        let control = self::control(control)?;
        let diagonal = with(session, |row| Ok(row.diagonal))?;
        let (tolerance, limits, coarsen) = self::tolerance(c, tolerance, diagonal)?;
        frame(c, session, (sink, report), &|session, sink| {
            let plan = allowed(session.plan_within(&tolerance, &limits), coarsen)?;
            let short = plan.shortfall.clone();
            let made = session.frame_controlled(plan, &control, sink)?;
            Ok(Some(self::report(&made, short.as_ref())))
        })
    })
}

/// Cancels the frame that was begun, if any, after the tile in hand. Does not wait.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_cancel(session: tt_session) -> tt_status {
    entry!(_c => with(session, |row| {
        row.session.cancel();
        Ok(())
    }))
}

/// Makes the next frame of views a whole one, for a new or emptied sink. Cancels a frame that was begun, and waits for
/// its tiles in progress.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_forget(session: tt_session) -> tt_status {
    entry!(_c => with(session, |row| {
        row.session.forget();
        Ok(())
    }))
}

/// Counts what a session has.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_get_info(session: tt_session, info: *mut tt_session_info) -> tt_status {
    entry!(c => {
        let out = c.out_struct("info", info)?;
        out.give(&with(session, |row| Ok(tt_session_info {
            size: 0,
            workers: row.session.workers() as u32,
            parts: row.session.scene().parts.len() as u32,
            instances: row.session.scene().instances.len() as u32,
            is_made: row.session.is_made().into(),
            degraded: row.session.degraded().count() as u32,
        }))?);
        Ok(())
    })
}

/// Describes an instance, with the level of detail, the colour and `hidden` of the last frame that a call has waited
/// for, cancelled or not, or of the last call since then that added or removed an instance or updated the model.
/// `instance` need not be set before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_get_instance(
    session: tt_session,
    index: u32,
    instance: *mut tt_instance,
) -> tt_status {
    entry!(c => {
        let out = c.out("instance", instance)?;
        out.give(with(session, |row| {
            Ok(self::instance(status::row(&row.session.scene().instances, "instance", index)?))
        })?);
        Ok(())
    })
}

/// The key of an instance, which stays the same when other instances come and go. Keys of removed instances are not
/// given again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_get_instance_key(session: tt_session, index: u32, key: *mut u64) -> tt_status {
    entry!(c => {
        let out = c.out("key", key)?;
        out.give(with(session, |row| {
            status::row(&row.session.scene().instances, "instance", index)?;
            row.session.instance_key(index as usize).ok_or_else(lost)
        })?.to_bits());
        Ok(())
    })
}

/// The index of the instance of a key, from the next frame of views on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_find_instance(session: tt_session, key: u64, index: *mut u32) -> tt_status {
    entry!(c => {
        let (out, key) = (c.out("index", index)?, InstanceKey::from_bits(key));
        let gone = || EditError::NoInstance { key };
        out.give(with(session, |row| Ok(row.session.instance_row(key).ok_or_else(gone)?))? as u32);
        Ok(())
    })
}

/// Adds an instance of a part of the prepared model, from the next frame of views on. Its index is the last. Cancels a
/// frame that was begun, and waits for its tiles in progress. `key` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_add_instance(
    session: tt_session,
    placement: *const tt_placement,
    key: *mut u64,
) -> tt_status {
    entry!(c => {
        let from = c.read("placement", placement)?;
        let out = c.out_if("key", key)?;
        let placed = SceneInstance {
            colour: (from.has_colour != 0).then_some(from.colour),
            name: c.text_or_empty("placement.name", from.name)?.into(),
            ..SceneInstance::new(PartId(from.part), transform(&from.transform))
        };
        let key = with(session, |row| Ok(row.session.add_instance(placed)?))?;
        out.into_iter().for_each(|out| out.give(key.to_bits()));
        Ok(())
    })
}

/// Removes an instance from the next frame of views on. Indices of later ones decrease by one. Cancels a frame that was
/// begun, and waits for its tiles in progress.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_remove_instance(session: tt_session, key: u64) -> tt_status {
    entry!(_c => with(session, |row| {
        row.session.remove_instance(InstanceKey::from_bits(key))?;
        Ok(())
    }))
}

/// Removes `count` instances in one pass, as tt_session_remove_instance removes one. If one was removed before, or is
/// named twice, nothing changes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_remove_instances(session: tt_session, keys: *const u64, count: usize) -> tt_status {
    entry!(c => {
        let keys: Vec<_> = c.slice("keys", keys, count)?.iter().map(|key| InstanceKey::from_bits(*key)).collect();
        with(session, |row| {
            row.session.remove_instances(&keys)?;
            Ok(())
        })
    })
}

/// Moves an instance from the next frame of views on: `transform` has 12 numbers, as in `tt_placement`. A frame that
/// was begun goes on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_move_instance(session: tt_session, key: u64, transform: *const f64) -> tt_status {
    entry!(c => {
        let numbers = c.slice("transform", transform, 12)?;
        let numbers = finite("transform", std::array::from_fn(|k| numbers[k]))?;
        with(session, |row| {
            Ok(row.session.move_instance(InstanceKey::from_bits(key), self::transform(&numbers))?)
        })
    })
}

fn lost() -> Failure {
    Failure::new(tt_status::TT_ERROR_LOST, "an internal error ended the session")
}

/// Frees a session, unless another call uses it. Cancels and awaits a frame that was begun. Once this returned TT_OK,
/// no callback of the session is called any more. Jobs of it that a pool still has free memory at most, and end their
/// handles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_session_free(session: tt_session) -> tt_status {
    entry!(_c => SESSIONS.end(session.id))
}
