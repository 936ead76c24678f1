//! Mutated CAD files (syntax, references, numbers, lists, units, places) -> the command line must write a mesh, with
//! diagnostics for everything lost, or print one error; within ten seconds, and within four times the memory of the
//! intact file besides that of the triangles it makes; within a gigabyte.
//!
//! `TRIMTESS_MUTANTS` is the number of mutants per file (default 1), `TRIMTESS_MUTANTS_SEED` shifts the random seed,
//! and only mutants of the operator `TRIMTESS_MUTANTS_OF` run if it is set.
//! Files: tests/data, and the corpora if present. The same numbers give the same mutants.

mod mutate;
#[path = "../../../tests/parts/mod.rs"]
mod parts;
#[path = "../../../tests/mutants/points.rs"]
mod points;
#[path = "../../../tests/process/mod.rs"]
mod process;
#[path = "../../../tests/sequence/random.rs"]
mod random;
mod run;

use mutate::Mutation;
use parts::{CORPORA, number, on_all_cores, step_files};
use random::SplitMix;
use run::{Limits, Outcome, run};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Memory that every mutant may take. For small files the program itself dominates, and a mutant may need a finer mesh.
const FLOOR: u64 = 64 << 20;
/// Memory that a mutant may take, as a multiple of the intact file's.
const TIMES: u64 = 4;
/// Memory that no mutant may exceed.
const MOST: u64 = 1 << 30;
/// Processor time that a mutant may take.
const TIME: Duration = Duration::from_secs(10);

/// STEP files, in a fixed order.
fn files() -> Vec<PathBuf> {
    step_files(&[&["tests/data"][..], &CORPORA].concat())
}

#[derive(Default)]
struct Found {
    /// Mutants by mutation and exit status.
    outcomes: BTreeMap<(Mutation, i32), u32>,
    faults: Vec<String>,
    slowest: (Duration, String),
    /// Maximum peak memory as a multiple of the intact file's, and the mutant.
    hungriest: (f64, String),
}

/// Runs `count` mutants of a file.
fn mutants_of(path: &Path, folder: &Path, count: u64, shift: u64, found: &Mutex<Found>) {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let folder = folder.join(&name);
    fs::create_dir_all(&folder).expect("a folder for mutants");
    let bytes = fs::read(path).expect("a readable file");
    let whole =
        run(path, &folder.join("out"), &Limits { time: 6 * TIME, memory: MOST, most: MOST }).expect("the intact file");
    for number in 0..count {
        let mut random = SplitMix::of(&name, shift.wrapping_mul(1_000_003).wrapping_add(number));
        let mutation = Mutation::ALL[(random.below(u64::MAX) % Mutation::ALL.len() as u64) as usize];
        if std::env::var("TRIMTESS_MUTANTS_OF").is_ok_and(|only| only != format!("{mutation:?}")) {
            continue;
        }
        let mutant = mutation.of(&bytes, &mut random);
        let file = folder.join(format!("{number}_{mutation:?}.step"));
        fs::write(&file, mutant).expect("a writable mutant");
        let memory = FLOOR.max(TIMES * whole.peak).min(MOST);
        let limits = Limits { time: TIME, memory, most: MOST };
        let outcome = run(&file, &folder.join(format!("out{number}")), &limits);
        let mut found = found.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        match outcome {
            Ok(Outcome { status, time, peak }) => {
                *found.outcomes.entry((mutation, status)).or_default() += 1;
                if time > found.slowest.0 {
                    found.slowest = (time, format!("{name} {number} {mutation:?}"));
                }
                let share = peak as f64 / whole.peak.max(1) as f64;
                if share > found.hungriest.0 {
                    found.hungriest = (share, format!("{name} {number} {mutation:?}, {} MiB", peak >> 20));
                }
                fs::remove_file(&file).expect("a removable mutant");
            }
            Err(fault) => found.faults.push(format!("{fault}\n  trimtess tessellate {} -o /tmp/x.glb", file.display())),
        }
    }
}

#[test]
fn mutants_end_in_a_mesh_or_one_error() {
    let only = std::env::var("TRIMTESS_MUTANTS_OF").ok();
    let is_operator = |only: &String| Mutation::ALL.iter().any(|mutation| format!("{mutation:?}") == *only);
    assert!(only.as_ref().is_none_or(is_operator), "no operator is {only:?}");
    let (count, shift) = (number("TRIMTESS_MUTANTS", 1), number("TRIMTESS_MUTANTS_SEED", 0));
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mutants");
    let _ = fs::remove_dir_all(&folder);
    let (files, found) = (files(), Mutex::new(Found::default()));
    let start = Instant::now();
    on_all_cores(&files, |path| mutants_of(path, &folder, count, shift, &found));
    let Found { outcomes, faults, slowest, hungriest } = found.into_inner().expect("no thread panicked");
    println!("{} files, {count} mutants each, in {:.1?}", files.len(), start.elapsed());
    for ((mutation, status), mutants) in &outcomes {
        println!("  {mutation:?}: {mutants} ended with status {status}");
    }
    println!("slowest: {:.2?}, {}; hungriest: {:.2} times, {}", slowest.0, slowest.1, hungriest.0, hungriest.1);
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
    if std::env::var_os("TRIMTESS_MUTANTS_OF").is_none() {
        assert_eq!(outcomes.values().sum::<u32>() as u64, files.len() as u64 * count);
    }
}
