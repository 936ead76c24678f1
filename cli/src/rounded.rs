//! What the numbers of a file format cost: told, refused beyond a tenth of the tolerance, and checked in the file.

use crate::Failure;
use crate::report::Report;
use glam::DVec3;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::Path;
use trimtess::mesh::Scene;
use trimtess::model::Severity;
use trimtess::out::{Format, ReadBack, Rounding, SaveError, SaveOptions};
use trimtess::prepare::Prepared;

/// What the written file holds.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct ReadBackRow {
    triangles: u64,
    /// Largest distance between a corner in the file and in the mesh, millimetres.
    moved_mm: f64,
    /// Edges whose directed uses do not cancel, over the positions in the file.
    unbalanced_edges: u64,
}

/// The message of a file that was not written. Names what helps if rounding costs too much.
pub(crate) fn unwritten(
    failure: &SaveError,
    path: &Path,
    (scene, recentred): (&Scene, bool),
    prepared: &Prepared,
    options: &SaveOptions,
) -> Failure {
    let why = match failure {
        SaveError::RoundedTooFar(_) => " (a tenth of the tolerance)",
        SaveError::BeyondSingle(_) => "",
        SaveError::File(failure) => return Failure::cannot(failure),
        other => return Failure::Cannot(format!("cannot write {}: {other}", path.display())),
    };
    let format = options.format;
    let fits = |by, format| Rounding::fits_moved(scene, by, &options.with_format(format));
    let centre = prepared.centre();
    let helps = !recentred && centre != DVec3::ZERO && fits(-centre, format);
    let recenter = if helps { "--recenter moves the scene to the origin" } else { "use a larger tolerance" };
    let single = !matches!(format, Format::Ply | Format::Obj);
    let finer =
        if single && fits(DVec3::ZERO, Format::Ply) { ", or write .ply, which has double precision" } else { "" };
    Failure::Cannot(format!("cannot write {}: {failure}{why}; {recenter}{finer}", path.display()))
}

/// Adds what rounding cost to the report.
pub(crate) fn tell(rounding: &Rounding, report: &mut Report) {
    report.triangles = rounding.triangles;
    report.collapsed_triangles = rounding.collapsed;
    report.rounding_mm = rounding.moved;
    for &face in &rounding.collapsed_faces {
        let reason = "all its triangles collapse where positions are rounded to the file's numbers".to_owned();
        report.add(Severity::Warning, Some(face), "face-rounded-away", reason);
    }
    report.faces_without_triangles += rounding.collapsed_faces.len() as u64;
    if rounding.collapsed > 0 {
        let reason = format!(
            "{} triangles collapse in the file's numbers, which move vertices by {:.3e} mm at most",
            rounding.collapsed, rounding.moved
        );
        report.add(Severity::Note, None, "triangles-rounded-away", reason);
    }
}

/// Adds what the written file holds to the report of its mesh, made within `chord`.
pub(crate) fn check(prepared: &Prepared, read: &ReadBack, chord: f64, report: &mut Report) {
    /// Share of the tolerance that rounding may take of a mesh that needs all of it.
    const NOISE: f64 = 1e-3;
    // Reading multiplies by the numbers of nodes and units, in double precision.
    let reach = prepared.bounds.map_or(0.0, |[low, high]| low.length().max(high.length()));
    let explained = report.rounding_mm * (1.0 + 1e-6) + 1e-14 * (reach + DVec3::from(report.offset_mm).length());
    let inexact = read.moved > explained;
    if inexact {
        report.add_error(format!(
            "a vertex in the file is {:.3e} mm off, and rounding explains {explained:.3e} mm",
            read.moved
        ));
    }
    if report.unbalanced_edges.is_some_and(|mesh| read.unbalanced_edges > mesh) {
        report.add_error(format!("the file has {} unbalanced edges", read.unbalanced_edges));
    }
    let off = report.p999_deviation_over_tolerance.unwrap_or(0.0) + read.moved / chord;
    if off > 1.0 + NOISE && report.p999_deviation_over_tolerance.is_some_and(|mesh| mesh <= 1.0) {
        report.add_error(format!("rounding takes the deviation to {off:.3} of the tolerance"));
    }
    let &ReadBack { triangles, moved: moved_mm, unbalanced_edges } = read;
    report.read_back = Some(ReadBackRow { triangles, moved_mm, unbalanced_edges });
}

/// Words for the summary, empty if nothing collapsed and nothing was moved.
pub(crate) fn words(report: &Report) -> String {
    let mut text = String::new();
    if report.collapsed_triangles > 0 {
        let _ = write!(text, " ({} more collapse in the file's numbers)", report.collapsed_triangles);
    }
    if report.offset_mm != [0.0; 3] {
        let [x, y, z] = report.offset_mm;
        let _ = write!(text, ", moved: add ({x:?}, {y:?}, {z:?}) mm for the model's coordinates");
    }
    text
}
