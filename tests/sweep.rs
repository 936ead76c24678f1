//! Real files at many tolerances: a part closed in the file is closed in the mesh in every run.
//!
//! Reads and prepares each file once. Prints each run that leaves a part open, with the part, its faces and their
//! diagnostics, and ends with a table of all files. A plain run tries 12 chords from 3e-2 to 3e-5 of the diagonal with
//! the angles 5 and 28.65 degrees. The command below tries 5, 12, 20, 28.65 and 45 degrees, in half a minute on two
//! cores:
//! ```text
//! TRIMTESS_SWEEP=all cargo test --release --test sweep -- --nocapture
//! ```
//!
//! Other inputs:
//!
//! | variable | meaning | example |
//! |---|---|---|
//! | `TRIMTESS_SWEEP_FOLDERS` | folders, separated by colons | `../shared/corpus:/data/parts` |
//! | `TRIMTESS_SWEEP_FILES` | substrings of file names, separated by commas | `odrive,tie_rod` |
//! | `TRIMTESS_SWEEP_CHORDS` | fractions of the diagonal, or millimetres | `1e-3,0.008mm` |
//! | `TRIMTESS_SWEEP_ANGLES` | degrees | `20,28.65` |
#![cfg(feature = "step")]

mod common;
mod parts;

use common::prepared;
use parts::{CORPORA, Made, closed_by_reference, is_asked, make, name, on_all_cores, step_files};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};
use trimtess::frame::Tolerance;
use trimtess::import::step::{StepOptions, read_file};

/// A chord tolerance.
#[derive(Clone, Copy, Debug)]
enum Chord {
    /// Fraction of the diagonal.
    Share(f64),
    Millimetres(f64),
}

/// Angles of the long run, degrees.
const ANGLES: [f64; 5] = [5.0, 12.0, 20.0, 28.65, 45.0];

/// Angles of a plain run: one fine enough for fillets, and the usual one.
const FEW_ANGLES: [f64; 2] = [5.0, 28.65];

/// Runs that once left a part open: file, chord in millimetres, angle in degrees.
const FOUND: [(&str, f64, f64); 1] = [("odrive_pcb_v35.step", 0.008, 28.65)];

/// Chords of the long run, evenly spaced in their logarithm.
fn chords() -> Vec<Chord> {
    (0..12).map(|k| Chord::Share(3e-2 * 10.0_f64.powf(-3.0 * f64::from(k) / 11.0))).collect()
}

/// Every chord and angle to try on each file.
fn grid() -> Vec<(Chord, f64)> {
    let all = std::env::var("TRIMTESS_SWEEP").is_ok_and(|which| which == "all");
    let chord = |text: &str| {
        let (number, unit): (&str, fn(f64) -> Chord) = match text.strip_suffix("mm") {
            Some(number) => (number, Chord::Millimetres),
            None => (text, Chord::Share),
        };
        unit(number.trim().parse().unwrap_or_else(|_| panic!("{text} is not a chord")))
    };
    let angle = |text: &str| text.trim().parse().unwrap_or_else(|_| panic!("{text} is not an angle"));
    let chords = match std::env::var("TRIMTESS_SWEEP_CHORDS") {
        Ok(asked) => asked.split(',').map(chord).collect(),
        Err(_) => chords(),
    };
    let angles: Vec<f64> = match std::env::var("TRIMTESS_SWEEP_ANGLES") {
        Ok(asked) => asked.split(',').map(angle).collect(),
        Err(_) if all => ANGLES.to_vec(),
        Err(_) => FEW_ANGLES.to_vec(),
    };
    chords.iter().flat_map(|&chord| angles.iter().map(move |&angle| (chord, angle))).collect()
}

/// All runs of one file.
#[derive(Default)]
struct Row {
    name: String,
    parts: usize,
    closed: usize,
    runs: usize,
    open: usize,
    /// Maximum over all runs, as for the next four fields.
    repaired: u64,
    filled: u64,
    lost: u64,
    slivers: u64,
    triangles: u64,
    faults: Vec<String>,
    took: Duration,
}

impl Row {
    fn of(path: &Path, grid: &[(Chord, f64)]) -> Self {
        let start = Instant::now();
        let mut row = Self { name: name(path), ..Self::default() };
        let model = match read_file(path, &StepOptions::default()) {
            Ok(model) => model,
            Err(error) => {
                row.faults.push(format!("{}: {error}", row.name));
                return row;
            }
        };
        let prepared = prepared(model);
        // Prepare may call the part open where a face is lost; the reference does not.
        let whole = closed_by_reference(path);
        let must_close = |part: usize| whole || prepared.scene.parts[part].closed;
        row.parts = prepared.parts.len();
        row.closed = (0..row.parts).filter(|&part| must_close(part)).count();
        let found = FOUND.iter().filter(|(file, ..)| *file == row.name);
        let found: Vec<_> = found.map(|&(_, chord, angle)| (Chord::Millimetres(chord), angle)).collect();
        for (chord, angle) in grid.iter().copied().chain(found) {
            let (millimetres, said) = match chord {
                Chord::Share(share) => (share * prepared.diagonal, format!("{share:.3e} of the diagonal")),
                Chord::Millimetres(chord) => (chord, format!("{chord} mm")),
            };
            let tolerance = Tolerance { chord: millimetres, angle: angle.to_radians(), max_edge: None };
            let made = make(&prepared, &tolerance, must_close);
            for fault in &made.faults {
                let fault = format!("{}, chord {said}, angle {angle}: {fault}", row.name);
                println!("{fault}");
                row.faults.push(fault);
            }
            row.add(&made);
        }
        row.took = start.elapsed();
        row
    }

    fn add(&mut self, made: &Made) {
        self.runs += 1;
        self.open += usize::from(!made.faults.is_empty());
        self.repaired = self.repaired.max(made.on("repaired"));
        self.filled = self.filled.max(made.on("filled"));
        self.lost = self.lost.max(made.on("lost"));
        self.slivers = self.slivers.max(made.slivers);
        self.triangles = self.triangles.max(made.triangles);
    }
}

/// One line per file; faces and triangles are the maximum over its runs.
fn table(rows: &[Row]) -> String {
    let mut text = format!(
        "{:<34} {:>5} {:>6} {:>5} {:>5} {:>8} {:>6} {:>4} {:>8} {:>10} {:>7}\n",
        "file", "parts", "closed", "runs", "open", "repaired", "filled", "lost", "slivers", "triangles", "s"
    );
    for row in rows {
        let Row { name, parts, closed, runs, open, repaired, filled, lost, slivers, triangles, took, .. } = row;
        let _ = writeln!(
            text,
            "{name:<34} {parts:>5} {closed:>6} {runs:>5} {open:>5} {repaired:>8} {filled:>6} {lost:>4} {slivers:>8} \
             {triangles:>10} {:>7.2}",
            took.as_secs_f64()
        );
    }
    let sum = |of: fn(&Row) -> usize| rows.iter().map(of).sum::<usize>();
    let faces = |of: fn(&Row) -> u64| rows.iter().map(of).sum::<u64>();
    let _ = writeln!(
        text,
        "{} files, {} runs, {} of them open; most faces in one run: {} repaired, {} filled, {} lost",
        rows.len(),
        sum(|row| row.runs),
        sum(|row| row.open),
        faces(|row| row.repaired),
        faces(|row| row.filled),
        faces(|row| row.lost)
    );
    text
}

#[test]
fn what_is_closed_in_the_file_is_closed_in_the_mesh_at_every_tolerance() {
    let folders = match std::env::var("TRIMTESS_SWEEP_FOLDERS") {
        Ok(folders) => folders.split(':').map(PathBuf::from).collect(),
        Err(_) => CORPORA.map(PathBuf::from).to_vec(),
    };
    let mut files = step_files(&folders);
    files.retain(|path| is_asked("TRIMTESS_SWEEP_FILES", path));
    // The largest files first, so that no core is left with one at the end.
    files.sort_by_key(|path| std::cmp::Reverse(std::fs::metadata(path).map_or(0, |file| file.len())));
    let (grid, rows) = (grid(), Mutex::new(Vec::new()));
    on_all_cores(&files, |path| {
        let row = Row::of(path, &grid);
        rows.lock().expect("no thread panicked").push(row);
    });
    let mut rows = rows.into_inner().expect("no thread panicked");
    rows.sort_by(|a, b| a.name.cmp(&b.name));
    print!("{}", table(&rows));
    let faults: Vec<&str> = rows.iter().flat_map(|row| &row.faults).map(String::as_str).collect();
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}
