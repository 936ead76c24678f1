//! Every file of both corpora, unchanged and with moved points.

use crate::chains::all_faults;
use crate::common::prepared;
use crate::parts::{CORPORA, step_files};
use crate::points::Points;
use crate::random::SplitMix;
use glam::DVec3;
use std::path::Path;
use trimtess::import::step::{StepError, StepOptions, read, read_file};
use trimtess::model::{DiagnosticKind, Model, Part};
use trimtess::prepare::{Prepared, Shells};

/// A point in the cube from -1 to 1.
fn within_cube(random: &mut SplitMix) -> DVec3 {
    DVec3::from([(); 3].map(|()| random.range(-1.0, 1.0)))
}

/// Moves vertices and control points of edges by up to a fraction of their part's size per coordinate.
fn shaken(mut model: Model, share: f64, seed: u64) -> Model {
    let mut noise = SplitMix(seed);
    for part in &mut model.parts {
        let by = share * size(part);
        part.vertices.iter_mut().for_each(|p| *p += within_cube(&mut noise) * by);
        part.edges.iter_mut().flat_map(|e| &mut e.curve.points).for_each(|p| *p += within_cube(&mut noise) * by);
    }
    model
}

fn size(part: &Part) -> f64 {
    let points = || part.vertices.iter().chain(part.edges.iter().flat_map(|e| &e.curve.points));
    let low = points().fold(DVec3::INFINITY, |low, p| low.min(*p));
    let high = points().fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
    if low.is_finite() { (high - low).length() } else { 0.0 }
}

/// Faults of one input; counts of closed parts, filled faces and faces without tiles.
fn judge(prepared: &Prepared) -> (Vec<String>, [usize; 3]) {
    let faces = || prepared.parts.iter().flat_map(|part| &part.faces);
    let closed = prepared.scene.parts.iter().filter(|part| part.closed).count();
    let lost = prepared.parts.iter().flat_map(|part| &part.face_rows).filter(|row| row.is_none()).count();
    (all_faults(prepared), [closed, faces().filter(|face| face.filled).count(), lost])
}

#[test]
fn the_edges_of_every_file_sum_to_what_its_shells_say() {
    let mut wrong = Vec::new();
    let mut all = [0; 3];
    for path in step_files(&CORPORA) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let model = read_file(&path, &StepOptions::default()).unwrap_or_else(|error| panic!("{name}: {error}"));
        let prepared = prepared(model);
        let (faults, counts) = judge(&prepared);
        (0..3).for_each(|k| all[k] += counts[k]);
        wrong.extend(faults.into_iter().map(|fault| format!("{name}: {fault}")));
        let told = prepared.diagnostics.iter().filter(|d| changed(&d.kind));
        told.for_each(|d| println!("{name}: part {:?} face {:?} #{}: {}", d.part, d.face, d.entity, d.kind));
        for (k, part) in prepared.scene.parts.iter().enumerate().filter(|(_, part)| !part.closed) {
            let (free, not) = (part.free_edges.len(), part.not_orientable.len());
            println!("{name}: part {k} is open: {free} free edges, {not} not orientable");
        }
    }
    println!("{} parts closed, {} faces filled, {} without tiles", all[0], all[1], all[2]);
    assert!(wrong.is_empty(), "{} faults: {:#?}", wrong.len(), &wrong[..wrong.len().min(20)]);
}

/// Whether a diagnostic reports closed or filled loops, or a shell that cannot be oriented.
fn changed(kind: &DiagnosticKind) -> bool {
    use trimtess::model::{FaceTrouble, ShellTrouble, WireTrouble};
    match kind {
        DiagnosticKind::Face(face) => matches!(
            face,
            FaceTrouble::Filled { .. }
                | FaceTrouble::TilesClosed { .. }
                | FaceTrouble::EndsJoined { .. }
                | FaceTrouble::TilesFilled
        ),
        DiagnosticKind::Wire(wire) => matches!(wire, WireTrouble::BridgesFilled { .. }),
        DiagnosticKind::Shell(shell) => matches!(shell, ShellTrouble::NotOrientable { .. }),
        _ => false,
    }
}

/// Which parts are closed by their edges alone. Edges that merely coincide within a tolerance may separate when moved.
fn closed(model: &Model) -> Vec<bool> {
    let stated = model.parts.iter().map(|part| Shells::of(part).open == 0);
    let prepared = prepared(model.clone());
    stated.zip(&prepared.scene.parts).map(|(stated, part)| stated && part.closed).collect()
}

/// Results of changed models whose originals are closed.
#[derive(Default)]
struct Shaken {
    wrong: Vec<String>,
    /// Parts closed, faces filled, faces without tiles.
    all: [usize; 3],
}

impl Shaken {
    /// Judges a changed model; `closed` marks the parts that were closed before.
    fn add(&mut self, whose: &str, closed: &[bool], model: Model) {
        let after = prepared(model);
        let (faults, counts) = judge(&after);
        (0..3).for_each(|k| self.all[k] += counts[k]);
        self.wrong.extend(faults.into_iter().map(|fault| format!("{whose}: {fault}")));
        for (k, (was_closed, part)) in closed.iter().zip(&after.scene.parts).enumerate() {
            if *was_closed && !part.closed {
                let (free, not) = (part.free_edges.len(), part.not_orientable.len());
                let open =
                    format!("{whose}: part {k} is no longer closed: {free} edges are free, {not} not orientable");
                self.wrong.push(open);
                let told = after.diagnostics.iter().filter(|d| d.part.is_none_or(|p| p.index() == k));
                self.wrong.extend(told.take(4).map(|d| format!("  face {:?}: {}", d.face, d.kind)));
            }
        }
    }

    fn report(&self, share: f64) {
        let [closed, filled, lost] = self.all;
        println!("{share}: {closed} parts closed, {filled} faces filled, {lost} without tiles");
    }
}

/// Seeds per file and share. Without `TRIMTESS_SHAKES`, one per small file and none per large one, since those take a
/// second each.
fn seeds(path: &Path) -> std::ops::Range<u64> {
    match std::env::var("TRIMTESS_SHAKES").ok().and_then(|text| text.parse().ok()) {
        Some(count) => 0..count,
        None => 0..u64::from(std::fs::metadata(path).is_ok_and(|m| m.len() < 300_000)),
    }
}

/// Asserts that closed parts of the corpora stay closed when `change` makes other models of a file, its name and its
/// model, by a share of the size and a seed.
fn stay_closed(shares: &[f64], change: impl Fn((&str, &[u8], &Model), f64, u64) -> Result<Model, StepError>) {
    let mut wrong = Vec::new();
    for &share in shares {
        let mut shaken = Shaken::default();
        for path in step_files(&CORPORA).into_iter().filter(|path| !seeds(path).is_empty()) {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let bytes = std::fs::read(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
            let model = read(&bytes, &StepOptions::default()).unwrap_or_else(|error| panic!("{name}: {error}"));
            let closed = closed(&model);
            for seed in seeds(&path) {
                let case = format!("{name}, {share}, seed {seed}");
                match change((&name, &bytes, &model), share, seed) {
                    Ok(model) => shaken.add(&case, &closed, model),
                    Err(error) => wrong.push(format!("{case}: {error}")),
                }
            }
        }
        shaken.report(share);
        wrong.append(&mut shaken.wrong);
    }
    assert!(wrong.is_empty(), "{} faults: {:#?}", wrong.len(), &wrong[..wrong.len().min(40)]);
}

#[test]
fn parts_that_are_closed_stay_closed_when_their_edges_are_shaken() {
    stay_closed(&[1e-6, 1e-4, 1e-3], |(_, _, model), share, seed| Ok(shaken(model.clone(), share, seed)));
}

#[test]
fn parts_that_are_closed_stay_closed_when_the_points_of_their_file_are_moved() {
    stay_closed(&[1e-6, 1e-5, 1e-4, 1e-3], |(name, bytes, _), share, seed| {
        read(&Points::of(bytes).moved(share, &mut SplitMix::of(name, seed)), &StepOptions::default())
    });
}
