//! Progress of long calls, and a way to stop them.

use crate::border::handles::Table;
use crate::border::{User, entry, versioned};
use crate::status::{Failure, tt_status};
use std::ffi::c_void;
use trimtess::control::{Control, Progress, Stage};

/// Hears of the progress of calls, and stops them from another thread. One may serve several calls.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_control {
    pub id: u64,
}

/// What a call is at.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum tt_stage {
    /// Reading. Counts parts, once the syntax is parsed.
    TT_STAGE_READ = 0,
    /// Preparing. Counts faces, each part once.
    TT_STAGE_PREPARE = 1,
    /// Tessellating. Counts tiles, each part once.
    TT_STAGE_TESSELLATE = 2,
}

/// Who hears of progress.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_progress {
    /// `sizeof(tt_progress)`.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// Passed to `report`. Valid until the control is freed and the calls that have it returned.
    pub user: *mut c_void,
    /// Called at most once per part, face or tile, from the threads that do the work: with 0 first, then with larger
    /// and larger numbers, and last with `total`. Calls come one at a time; those of several calls of the library that
    /// have the same control may overlap. `stage` is a `tt_stage`; `done` is from 0 to `total`. It returns at once.
    pub report: Option<extern "C" fn(user: *mut c_void, stage: u32, done: u64, total: u64)>,
}
versioned!(tt_progress, reserved);

static CONTROLS: Table<Control> = Table::new(1);

/// Makes a control. `progress` may be null: then it only stops work.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_control_new(progress: *const tt_progress, control: *mut tt_control) -> tt_status {
    entry!(c => {
        let out = c.out("control", control)?;
        let progress = c.read_or_zeros("progress", progress)?;
        let made = match progress.report {
            None => Control::default(),
            Some(report) => {
                let user = User::of(progress.user);
                Control::observed_by(move |Progress { stage, done, total, .. }| {
                    report(user.get(), number(stage), done, total);
                })
            }
        };
        out.give(tt_control { id: CONTROLS.add(made) });
        Ok(())
    })
}

fn number(stage: Stage) -> u32 {
    let stage = match stage {
        Stage::Read => tt_stage::TT_STAGE_READ,
        Stage::Prepare => tt_stage::TT_STAGE_PREPARE,
        _ => tt_stage::TT_STAGE_TESSELLATE,
    };
    stage as u32
}

/// Asks the calls that have this control to stop, those to come too. They end with TT_ERROR_CANCELLED after the part,
/// face or tile in hand. May be called from any thread, also from within a callback.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_control_cancel(control: tt_control) -> tt_status {
    entry!(_c => {
        CONTROLS.get(control.id)?.cancel();
        Ok(())
    })
}

/// Frees a control. Calls that have it go on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tt_control_free(control: tt_control) -> tt_status {
    entry!(_c => CONTROLS.free(control.id))
}

/// The control of a handle; one that nobody hears if it is null.
pub(crate) fn control(handle: tt_control) -> Result<Control, Failure> {
    Ok(CONTROLS.get_if(handle.id)?.map_or_else(Control::default, |control| Control::clone(&control)))
}
