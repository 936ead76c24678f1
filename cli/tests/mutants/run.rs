//! A file -> the outcome of `trimtess tessellate`, or a fault.

use crate::process::{Ended, watched};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Limits of a run.
pub(crate) struct Limits {
    /// Processor time of all threads, for [`watched`].
    pub(crate) time: Duration,
    /// Peak resident memory, bytes, besides [`PER_TRIANGLE`] of the mesh.
    pub(crate) memory: u64,
    /// Peak resident memory, bytes, all included; also of a mesh that is refused when it is written, because nothing
    /// says how large it is.
    pub(crate) most: u64,
}

/// Memory that a triangle of the mesh may take, bytes: in batches, and in the file that is written from them. A mutant
/// may need a thousand times the triangles of the intact file, which has 150 to 160 bytes for each.
const PER_TRIANGLE: u64 = 192;

/// A run without fault.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outcome {
    pub(crate) status: i32,
    /// Processor time, or wall time if unknown.
    pub(crate) time: Duration,
    pub(crate) peak: u64,
}

/// Tessellates `file`, with all output in `folder`.
pub(crate) fn run(file: &Path, folder: &Path, limits: &Limits) -> Result<Outcome, String> {
    fs::create_dir_all(folder).map_err(|error| error.to_string())?;
    let [mesh, report, log] = ["mesh.glb", "report.json", "log"].map(|name| folder.join(name));
    let stderr = fs::File::create(&log).map_err(|error| error.to_string())?;
    let mut command = Command::new(env!("CARGO_BIN_EXE_trimtess"));
    command
        .args(["tessellate", "--chord-rel", "1e-3", "--report"])
        .args([&report, Path::new("-o"), &mesh, file])
        .env_remove("RUST_LOG")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(stderr);
    let Ended { status, time, peak } = watched(&mut command, limits.time)?;
    let said = String::from_utf8_lossy(&fs::read(&log).unwrap_or_default()).into_owned();
    let Some(status) = status.code() else { return Err(format!("killed: {status}\n{said}")) };
    let told: Option<Value> = fs::read(&report).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
    // The process's own report covers the end.
    let peak = peak.max(told.as_ref().and_then(|told| told["peak_memory_bytes"].as_u64()).unwrap_or(0));
    let faults = faults(status, &said, &mesh, told.as_ref());
    let others = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let stray = others.into_iter().find(|path| ![&mesh, &report, &log].contains(&path));
    let stray = stray.map(|path| format!("{} was left behind", path.display()));
    let triangles = told.as_ref().and_then(|told| told["triangles"].as_u64()).unwrap_or(0);
    let refused = status == 1 && said.contains("error: cannot write");
    let allowed = if refused { limits.most } else { limits.most.min(limits.memory + PER_TRIANGLE * triangles) };
    let hungry = (peak > allowed).then(|| format!("{} MiB of {} allowed", peak >> 20, allowed >> 20));
    match faults.into_iter().chain(stray).chain(hungry).next() {
        Some(fault) => Err(format!("status {status}, {fault}\n{said}")),
        None => fs::remove_dir_all(folder).map(|()| Outcome { status, time, peak }).map_err(|error| error.to_string()),
    }
}

/// Violations of the command line's contract: statuses, files, messages.
fn faults(status: i32, said: &str, mesh: &Path, report: Option<&Value>) -> Option<String> {
    let internal = |text: &str| text.contains("internal error") || text.contains("panicked");
    if internal(said) || report.is_some_and(|report| internal(&report.to_string())) {
        let reasons = report.map(|report| report["diagnostics"].to_string()).unwrap_or_default();
        return Some(format!("a panic: {}", reasons.chars().take(1000).collect::<String>()));
    }
    match (status, report) {
        (1, None) if mesh.exists() => Some("status 1, but a file was written".into()),
        (1, None) => {
            let errors = said.lines().filter(|line| line.starts_with("error: ")).count();
            (errors != 1).then(|| format!("{errors} errors instead of one"))
        }
        (0 | 3, Some(report)) => {
            let diagnostics = report["diagnostics"].as_array().map_or(0, Vec::len);
            let triangles = report["triangles"].as_u64().unwrap_or(0);
            let lost = report["faces_without_triangles"].as_u64().unwrap_or(0) as usize;
            if lost > diagnostics || (triangles == 0 && diagnostics == 0) {
                return Some(format!("{triangles} triangles, {lost} faces lost, but only {diagnostics} diagnostics"));
            }
            if report["diagnostics"].to_string().contains("no stage said why") {
                return Some("a face is lost without explanation".into());
            }
            if status == 3 && diagnostics == 0 {
                return Some("no diagnostics, but status 3".into());
            }
            let whole = fs::read(mesh).is_ok_and(|bytes| is_whole_glb(&bytes));
            (!whole).then(|| "the mesh file is incomplete".into())
        }
        (1, Some(_)) => Some("a report, but no mesh".into()),
        (0 | 3, None) => Some("a mesh, but no report".into()),
        _ => Some("an undocumented status".into()),
    }
}

/// Checks the length in the header.
fn is_whole_glb(bytes: &[u8]) -> bool {
    let length = bytes.get(8..12).and_then(|four| four.try_into().ok()).map(u32::from_le_bytes);
    bytes.starts_with(b"glTF") && length.map(|length| length as usize) == Some(bytes.len())
}
