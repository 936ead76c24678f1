//! What was repaired, approximated or lost, as data.

use crate::border::{Caller, versioned};
use crate::status::{Failure, row};
use crate::version::TT_NONE;
use std::ffi::c_char;
use trimtess::model::{Diagnostic, Severity};

/// How bad a diagnostic is.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum tt_severity {
    /// Nothing is lost; something was repaired or approximated.
    TT_SEVERITY_NOTE = 0,
    /// Something other than geometry is lost (a colour, a name), a face differs from the file, or the mesh is coarser
    /// than asked.
    TT_SEVERITY_WARNING = 1,
    /// Geometry is lost or may be wrong: a face, a hole, an occurrence, the unit, or the mesh fails its check.
    TT_SEVERITY_ERROR = 2,
}

/// Tells of something that was not understood, repaired or lost.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_diagnostic {
    /// `sizeof(tt_diagnostic)`.
    pub size: u32,
    /// A `tt_severity`.
    pub severity: u32,
    /// 1 if the mesh is not what the file states: an error, or a warning about a face. Else 0.
    pub is_fault: u32,
    /// The part concerned, or TT_NONE.
    pub part: u32,
    /// The face concerned, within the part, or TT_NONE.
    pub face: u32,
    /// The edge concerned, within the part, or TT_NONE.
    pub edge: u32,
    /// Number of the entity in the file, or 0.
    pub entity: u64,
    /// 1 if `place` is one.
    pub has_place: u32,
    /// 0.
    pub reserved: u32,
    /// Where, in the part's coordinates, millimetres.
    pub place: [f64; 3],
    /// Stable name of its kind, as "face-off-surface", with a zero byte at the end. docs/diagnostics.md lists them.
    pub code: [c_char; 64],
}
versioned!(tt_diagnostic);

fn as_data(told: &Diagnostic) -> tt_diagnostic {
    let severity = match told.severity {
        Severity::Note => tt_severity::TT_SEVERITY_NOTE,
        Severity::Warning => tt_severity::TT_SEVERITY_WARNING,
        Severity::Error => tt_severity::TT_SEVERITY_ERROR,
    };
    let mut code = [0; 64];
    code.iter_mut().zip(told.kind.code().bytes().take(63)).for_each(|(to, byte)| *to = byte as c_char);
    tt_diagnostic {
        size: 0,
        severity: severity as u32,
        is_fault: told.is_fault().into(),
        part: told.part.map_or(TT_NONE, |part| part.0),
        face: told.face.map_or(TT_NONE, |face| face.0),
        edge: told.edge.map_or(TT_NONE, |edge| edge.0),
        entity: told.entity,
        has_place: told.place.is_some().into(),
        reserved: 0,
        place: told.place.unwrap_or_default().to_array(),
        code,
    }
}

/// Gives one of `all`, and its message.
pub(crate) fn give(
    c: &Caller,
    (all, index): (&[Diagnostic], u32),
    diagnostic: *mut tt_diagnostic,
    (text, capacity, length): (*mut c_char, usize, *mut usize),
) -> Result<(), Failure> {
    let told = row(all, "diagnostic", index)?;
    let out = c.out_struct_if("diagnostic", diagnostic)?;
    c.give_text(&told.to_string(), text, capacity, length)?;
    out.into_iter().for_each(|out| out.give(&as_data(told)));
    Ok(())
}
