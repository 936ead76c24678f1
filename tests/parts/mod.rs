//! STEP files beside the checkout, and the parts of a frame that are closed in the file and open in the mesh.
#![allow(dead_code, reason = "not every test uses all of it")]

use std::any::Any;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use trimtess::frame::{Rung, Tolerance, plan};
use trimtess::mesh::{MemorySink, check_scene};
use trimtess::model::{FaceId, PartId, Severity};
use trimtess::parallel::{FrameReport, serial};
use trimtess::prepare::Prepared;

/// Folders of real files, relative to the checkout, each with a reference.jsonl.
pub(crate) const CORPORA: [&str; 2] = ["../shared/corpus", "../shared/corpus-closed"];

/// The STEP files of some folders, in a fixed order. Prints which folders are absent. Paths are relative to the
/// checkout.
pub(crate) fn step_files(folders: &[impl AsRef<Path>]) -> Vec<PathBuf> {
    let root = checkout();
    let mut files = Vec::new();
    for folder in folders.iter().map(|folder| root.join(folder)) {
        let Ok(entries) = std::fs::read_dir(&folder) else {
            println!("skipped: no folder {}", folder.display());
            continue;
        };
        let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
        let is_step = |path: &PathBuf| path.extension().is_some_and(|e| e == "stp" || e == "step");
        let mut found: Vec<PathBuf> = paths.filter(is_step).collect();
        found.sort();
        files.extend(found);
    }
    files
}

/// The checkout: the package's folder, or the one above it that holds `tests/data`.
pub(crate) fn checkout() -> &'static Path {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.ancestors().find(|folder| folder.join("tests/data").is_dir()).unwrap_or(package)
}

/// A file's name without its folder.
pub(crate) fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Whether the reference.jsonl beside a file calls it closed; false without a reference.
pub(crate) fn closed_by_reference(path: &Path) -> bool {
    let reference = std::fs::read_to_string(path.with_file_name("reference.jsonl")).unwrap_or_default();
    let start = format!("{{\"file\": \"{}\"", name(path));
    reference.lines().any(|line| line.starts_with(&start) && line.contains("\"closed\": true"))
}

/// Results of a frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Made {
    pub(crate) triangles: u64,
    /// Triangles that only close a face's boundary.
    pub(crate) slivers: u64,
    /// Number of faces per rung, each part counted once.
    pub(crate) rungs: BTreeMap<String, u64>,
    /// A line for each part that should be closed but is open, and for each malformed part.
    pub(crate) faults: Vec<String>,
    /// Faces filled in space.
    pub(crate) filled: Vec<(PartId, FaceId)>,
}

impl Made {
    /// Number of faces that ended on the named rung; 0 if it does not exist.
    pub(crate) fn on(&self, rung: &str) -> u64 {
        self.rungs.get(rung).copied().unwrap_or(0)
    }
}

/// Makes a frame on this thread and checks it. Parts for which `must_close` holds must be closed; others may be open
/// only at the edges that are free in the file. A panic is a fault.
pub(crate) fn make(prepared: &Arc<Prepared>, tolerance: &Tolerance, must_close: impl Fn(usize) -> bool) -> Made {
    let mut sink = MemorySink::default();
    let report =
        catch_unwind(AssertUnwindSafe(|| serial(prepared, &Arc::new(plan(prepared, tolerance)), true, &mut sink)));
    let report = match report {
        Ok(report) => report.expect("the memory sink accepts every frame"),
        Err(panic) => return Made { faults: vec![format!("a panic: {}", said(&*panic))], ..Made::default() },
    };
    let facts = check_scene(&sink);
    let mut made = Made { triangles: report.triangles, slivers: report.slivers, ..Made::default() };
    for rung in Rung::ALL {
        made.rungs.insert(rung.to_string(), report.ladder.count(*rung));
    }
    let is_filled = |rung: Rung| rung.to_string().starts_with("filled");
    made.filled = report.rungs.iter().filter(|f| is_filled(f.rung)).map(|f| (f.part, f.face)).collect();
    for (number, part) in facts.parts.iter().enumerate() {
        if part.unbalanced_edges > 0 && must_close(number) {
            let (edges, length) = (part.unbalanced_edges, part.unbalanced_length);
            let faces = culprits(prepared, &report, PartId::new(number), &part.defect_faces);
            made.faults.push(format!("part {number}: {edges} open or unbalanced edges, {length:.2e} mm; {faces}"));
        }
        if part.defects > 0 && !must_close(number) {
            let faces = culprits(prepared, &report, PartId::new(number), &part.defect_faces);
            let (edges, length) = (part.defects, part.defect_length);
            made.faults.push(format!("part {number}: {edges} cracks in an open part, {length:.2e} mm; {faces}"));
        }
        if !part.is_well_formed() {
            made.faults.push(format!("part {number} is malformed: {part}"));
        }
    }
    made
}

/// The faces along cracks that left the normal rung, with their diagnostics; all faces along cracks if none did.
fn culprits(prepared: &Prepared, report: &FrameReport, part: PartId, faces: &[FaceId]) -> String {
    const NAMED: usize = 4;
    let rung = |face: FaceId| report.rungs.iter().find(|f| (f.part, f.face) == (part, face)).map(|f| f.rung);
    let (odd, other): (Vec<FaceId>, Vec<FaceId>) =
        faces.iter().partition(|face| rung(**face).is_some_and(|rung| rung >= Rung::Repaired));
    let faces = if odd.is_empty() { other } else { odd };
    let told = |face: FaceId| {
        let mut about = prepared.diagnostics.iter().filter(|d| (d.part, d.face) == (Some(part), Some(face)));
        let worst = about.clone().find(|d| d.severity > Severity::Note).or_else(|| about.next());
        let rung = rung(face).unwrap_or_default();
        worst.map_or_else(|| format!("face {} ({rung})", face.0), |d| format!("face {} ({rung}: {})", face.0, d.kind))
    };
    let mut text: Vec<String> = faces.iter().take(NAMED).map(|&face| told(face)).collect();
    if faces.len() > NAMED {
        text.push(format!("and {} faces more", faces.len() - NAMED));
    }
    text.join(", ")
}

/// The message of a panic.
pub(crate) fn said(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    text.unwrap_or("without a message").to_owned()
}

/// Calls `work` for each item, on all cores.
pub(crate) fn on_all_cores<T: Sync>(items: &[T], work: impl Fn(&T) + Sync) {
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, |n| n.get()) {
            scope.spawn(|| {
                while let Some(item) = items.get(next.fetch_add(1, Ordering::Relaxed)) {
                    work(item);
                }
            });
        }
    });
}

/// A number from the environment.
pub(crate) fn number(variable: &str, default: u64) -> u64 {
    std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// Whether a file's name contains one of the comma-separated strings of an environment variable; true if it is unset.
pub(crate) fn is_asked(variable: &str, path: &Path) -> bool {
    let Ok(asked) = std::env::var(variable) else { return true };
    asked.split(',').any(|part| name(path).contains(part))
}
