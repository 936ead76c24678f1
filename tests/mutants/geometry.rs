//! Files with moved or rounded points -> parts as closed as before: what is closed in the file is closed in the mesh,
//! whatever its geometry.
//!
//! A plain run tries a few files, one mutant per size of the noise. The long run is
//!
//! ```text
//! TRIMTESS_GEOMETRY=20 cargo test --release --test mutants -- --nocapture geometry
//! ```
//!
//! | variable | meaning |
//! |---|---|
//! | `TRIMTESS_GEOMETRY` | mutants per file and size of the noise; tries all files |
//! | `TRIMTESS_GEOMETRY_FIRST` | number of the first mutant |
//! | `TRIMTESS_GEOMETRY_FILES` | substrings of file names, separated by commas |
//! | `TRIMTESS_GEOMETRY_KEEP` | a folder to save the mutants to |
//!
//! A mutant depends only on the file's name, the noise and its number. Times are printed and never judged.

use crate::parts::{CORPORA, Made, closed_by_reference, is_asked, make, name, number, on_all_cores, said, step_files};
use crate::points::Points;
use crate::random::SplitMix;
use cpu_time::ThreadTime;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use trimtess::control::{Alone, Control};
use trimtess::frame::Tolerance;
use trimtess::import::step::{StepOptions, read_on};
use trimtess::model::{FaceId, PartId, Severity};
use trimtess::prepare::{PrepareOptions, Prepared, Shells, prepare_on};

/// How far points move, as fractions of the size of their part.
const SHARES: [f64; 4] = [1e-6, 1e-5, 1e-4, 1e-3];

/// Up to this noise no face may be filled in space.
const SMALL: f64 = 1e-5;

/// Step to which the points of edges are rounded, as a fraction of the size of their part.
const STEP: f64 = 1e-3;

/// Files of a plain run: one of each kind, each within half a second.
const FEW: [&str; 7] = [
    "cutter_male.step",
    "koch_shoulder_rotation.step",
    "mxm_package.step",
    "tie_rod.step",
    "mini_heatsink.stp",
    "periodic_pole_solid.stp",
    "screw.step",
];

/// A mutant may take ten times as long as its file, or this much longer.
const SLACK: Duration = Duration::from_millis(200);

/// A file that was read, prepared and meshed on this thread.
struct Run {
    /// Whether each part must be closed in its mutants: closed by its edges both as read and as prepared, or by the
    /// reference.
    stated: Vec<bool>,
    closed: Vec<bool>,
    made: Made,
    /// Processor time of this thread, which other processes do not add to.
    took: Duration,
}

impl Run {
    /// `stated` are the parts that must be closed whatever the geometry of this file.
    fn of(bytes: &[u8], stated: Option<&[bool]>) -> Result<Self, String> {
        let work = || {
            let start = ThreadTime::now();
            let model = read_on(&Alone, bytes, &StepOptions::default(), &Control::default())
                .map_err(|error| error.to_string())?;
            let by_edges: Vec<bool> = model.parts.iter().map(|part| Shells::of(part).open == 0).collect();
            let prepared = prepare_on(&Alone, &model, &PrepareOptions::DEFAULT, &Control::default());
            let prepared = Arc::new(prepared.map_err(|error| error.to_string())?);
            let tolerance = Tolerance::relative(1e-3, prepared.diagonal);
            let closed: Vec<bool> = prepared.scene.parts.iter().map(|part| part.closed).collect();
            let must_close = |part: usize| closed[part] || stated.is_some_and(|stated| stated.get(part) == Some(&true));
            let mut made = make(&prepared, &tolerance, must_close);
            let took = start.elapsed();
            let silent = |(part, face): &&_| !is_told(&prepared, *part, *face);
            let silent: Vec<String> = made.filled.iter().filter(silent).map(|face| format!("{face:?}")).collect();
            made.faults.extend(silent.into_iter().map(|face| format!("filled in space without a warning: {face}")));
            let stated = by_edges.iter().zip(&closed).map(|(by_edges, closed)| *by_edges && *closed).collect();
            Ok(Self { stated, closed, made, took })
        };
        catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| Err(format!("a panic: {}", said(&*panic))))
    }
}

impl Run {
    fn secs(&self) -> f64 {
        self.took.as_secs_f64()
    }

    /// Time limit for a mutant, beyond which it counts as slow.
    fn most(&self) -> Duration {
        (10 * self.took).max(self.took + SLACK)
    }
}

/// Whether a warning names the face.
fn is_told(prepared: &Prepared, part: PartId, face: FaceId) -> bool {
    let mut about = prepared.diagnostics.iter().filter(|d| (d.part, d.face) == (Some(part), Some(face)));
    about.any(|d| d.severity >= Severity::Warning)
}

/// Results of the mutants with noise of one size.
#[derive(Default)]
struct Sum {
    mutants: usize,
    open: usize,
    /// Sums over all mutants.
    repaired: u64,
    filled: u64,
    lost: u64,
    /// The mutants with filled faces.
    with_filled: Vec<String>,
    slivers: u64,
    slow: usize,
    /// Largest ratio of time to limit, and its mutant.
    slowest: (f64, String),
    faults: Vec<String>,
}

impl Sum {
    /// Adds a mutant of the file whose unchanged run is `whole`.
    fn add(&mut self, mutant: &str, run: Result<Run, String>, whole: &Run) {
        self.mutants += 1;
        let mut faults = match &run {
            Ok(run) => run.made.faults.clone(),
            Err(error) => vec![error.clone()],
        };
        if let Ok(run) = run {
            self.repaired += run.made.on("repaired");
            self.filled += run.made.filled.len() as u64;
            self.lost += run.made.on("lost");
            if !run.made.filled.is_empty() {
                self.with_filled.push(format!("{mutant}: {:?}", run.made.filled));
            }
            self.slivers += run.made.slivers;
            self.slow += usize::from(run.took > whole.most());
            let share = run.secs() / whole.most().as_secs_f64();
            if share > self.slowest.0 {
                self.slowest = (share, format!("{mutant}, {:.0?} instead of {:.0?}", run.took, whole.took));
            }
            if run.closed.len() != whole.closed.len() {
                faults.push(format!("{} parts instead of {}", run.closed.len(), whole.closed.len()));
            }
            let opened = whole.stated.iter().zip(&run.closed).filter(|(before, after)| **before && !**after).count();
            if opened > 0 {
                faults.push(format!("{opened} parts are no longer closed"));
            }
        }
        self.open += usize::from(!faults.is_empty());
        self.faults.extend(faults.into_iter().map(|fault| format!("{mutant}: {fault}")));
    }
}

/// Saves a mutant, if requested.
fn keep(mutant: &str, bytes: &[u8]) {
    let Ok(folder) = std::env::var("TRIMTESS_GEOMETRY_KEEP") else { return };
    let path = Path::new(&folder).join(format!("{}.step", mutant.replace(' ', "_")));
    std::fs::write(&path, bytes).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}

/// The files to try, the largest first.
fn files() -> Vec<PathBuf> {
    let asked = |variable: &str| std::env::var(variable).is_ok();
    let few = !asked("TRIMTESS_GEOMETRY") && !asked("TRIMTESS_GEOMETRY_FILES");
    let mut files = step_files(&CORPORA);
    files.retain(|path| is_asked("TRIMTESS_GEOMETRY_FILES", path) && (!few || FEW.contains(&&*name(path))));
    files.sort_by_key(|path| std::cmp::Reverse(std::fs::metadata(path).map_or(0, |file| file.len())));
    files
}

/// Runs the mutants of all files. `of` makes those of one file: the name of the noise, the mutant's name, its bytes.
fn mutants(of: impl Fn(&str, &Points<'_>, &mut dyn FnMut(String, String, Vec<u8>)) + Sync) -> BTreeMap<String, Sum> {
    let sums = Mutex::new(BTreeMap::<String, Sum>::new());
    on_all_cores(&files(), |path| {
        let (name, bytes) = (name(path), std::fs::read(path).expect("a readable file"));
        // The second run finds everything in memory.
        let whole = Run::of(&bytes, None).and_then(|_| Run::of(&bytes, None));
        let Ok(mut whole) = whole else {
            println!("skipped: {name} cannot be read");
            return;
        };
        if closed_by_reference(path) {
            whole.stated.fill(true);
        }
        let (mut count, mut longest) = (0, Duration::ZERO);
        of(&name, &Points::of(&bytes), &mut |noise, mutant, bytes| {
            keep(&mutant, &bytes);
            let again = || Run::of(&bytes, Some(&whole.stated));
            let mut run = again();
            // Other processes take caches away: they make a run longer, never shorter.
            if let Ok(first) = &mut run
                && first.took > whole.most()
                && let Ok(second) = again()
            {
                first.took = first.took.min(second.took);
            }
            count += 1;
            longest = longest.max(run.as_ref().map_or(Duration::ZERO, |run| run.took));
            let mut sums = sums.lock().expect("no thread panicked");
            sums.entry(noise).or_default().add(&mutant, run, &whole);
        });
        println!("{name}: {:.3} s, the longest of {count} mutants {:.3} s", whole.secs(), longest.as_secs_f64());
    });
    sums.into_inner().expect("no thread panicked")
}

/// Prints a line per size of the noise, and fails if there is a fault.
fn judge(sums: &BTreeMap<String, Sum>) {
    for (noise, sum) in sums {
        let Sum { mutants, open, repaired, filled, lost, slivers, slow, slowest, .. } = sum;
        println!(
            "{noise}: {mutants} mutants, {open} at fault; faces: {repaired} repaired, {filled} filled in space, \
             {lost} lost; {slivers} slivers; {slow} took more than ten times the file's time and 0.2 s, at worst {:.1} \
             times as much as that: {}",
            slowest.0, slowest.1
        );
    }
    let faults: Vec<&str> = sums.values().flat_map(|sum| &sum.faults).map(String::as_str).collect();
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn parts_whose_points_are_moved_stay_closed() {
    let (count, first) = (number("TRIMTESS_GEOMETRY", 1), number("TRIMTESS_GEOMETRY_FIRST", 0));
    let mut sums = mutants(|name, points, run| {
        for (size, share) in (0_u64..).zip(SHARES) {
            for seed in first..first + count {
                let bytes = points.moved(share, &mut SplitMix::of(name, seed << 8 | size));
                run(format!("moved by {share:.0e}"), format!("{name} moved {share:.0e} {seed}"), bytes);
            }
        }
    });
    for share in SHARES.into_iter().filter(|share| *share <= SMALL) {
        let Some(sum) = sums.get_mut(&format!("moved by {share:.0e}")).filter(|sum| sum.filled > 0) else { continue };
        let (filled, of) = (sum.filled, sum.with_filled.join("\n"));
        sum.faults.push(format!("{filled} faces are filled in space where points move by {share:.0e}:\n{of}"));
    }
    judge(&sums);
}

#[test]
fn parts_whose_edges_are_rounded_stay_closed() {
    judge(&mutants(|name, points, run| {
        run(format!("rounded to {STEP:.0e}"), format!("{name} rounded"), points.rounded(STEP));
    }));
}
