//! Small files that ask for much: each is answered, or refused by name, in bounded time and memory.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../../../tests/attacks/mod.rs"]
mod files;
#[path = "../../../tests/folders/mod.rs"]
mod folders;
#[path = "../../../tests/process/mod.rs"]
mod process;

use folders::folder;
use process::{Ended, watched};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Files of attacks that are not part of this repository.
const SHARED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared");

/// Peak resident memory allowed, bytes. A file of a kilobyte takes at most a tenth of it, name and occurrences a half.
const MEMORY: u64 = 300 << 20;

/// Peak resident memory allowed with `--max-memory 500`, bytes.
const MEMORY_OF_500: u64 = 600_000_000;

/// Processor time allowed: many times what any of these files takes.
const TIME: Duration = Duration::from_secs(30);

/// Virtual memory of a run, KiB, beyond which it aborts rather than the machine.
const ADDRESSES: u64 = 8 << 20;

/// How a run ended.
#[derive(Debug)]
struct Run {
    status: Option<i32>,
    /// Console and report.
    said: String,
    /// Peak resident memory, bytes.
    peak: u64,
}

/// Tessellates a file. Panics if it takes longer than [`TIME`].
fn tessellate(file: &Path, options: &[&str]) -> Run {
    let [mesh, report, log] = ["glb", "json", "log"].map(|extension| file.with_extension(extension));
    let limited = format!("ulimit -v {ADDRESSES}; exec \"$@\"");
    let mut command = Command::new("sh");
    command
        .args(["-c", &limited, "sh", env!("CARGO_BIN_EXE_trimtess"), "tessellate", "--report"])
        .args([&report, Path::new("-o"), &mesh, file])
        .args(options)
        .env_remove("RUST_LOG")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(fs::File::create(&log).unwrap());
    let ended = watched(&mut command, TIME);
    let Ended { status, peak, .. } = ended.unwrap_or_else(|fault| panic!("{} {options:?}: {fault}", file.display()));
    let told = fs::read_to_string(&report).unwrap_or_default();
    let own = serde_json::from_str::<serde_json::Value>(&told).ok().and_then(|told| told["peak_memory_bytes"].as_u64());
    // The console lists the first diagnostics only.
    let said = fs::read_to_string(&log).unwrap() + &told;
    Run { status: status.code(), said, peak: peak.max(own.unwrap_or(0)) }
}

/// Asserts that a run ended as it should, within `memory`.
fn ends_well(run: &Run, memory: u64, what: &str) {
    assert!(matches!(run.status, Some(0 | 1 | 3)), "{what}: {:?} {}", run.status, run.said);
    let said = run.said.get(..2000).unwrap_or(&run.said);
    assert!(!run.said.contains("panicked") && !run.said.contains("internal error"), "{what}: {said}");
    assert!(run.peak <= memory, "{what}: {} MiB, {:?}, {said}", run.peak >> 20, run.status);
}

/// Tessellates a text with default limits and with `--max-memory 500`. It must end with `status`, and a message that
/// contains `why`.
fn assert_answers(name: &str, text: &str, status: i32, why: &str) {
    let file = folder(name).join("attack.step");
    fs::write(&file, text).unwrap();
    for options in [&[][..], &["--max-memory", "500"]] {
        let run = tessellate(&file, options);
        ends_well(&run, MEMORY, &format!("{name}, {} bytes, {options:?}", text.len()));
        let said = run.said.get(..2000).unwrap_or(&run.said);
        assert_eq!(run.status, Some(status), "{name} {options:?}: {said}");
        assert!(run.said.contains(why), "{name} {options:?}: {said}");
    }
}

#[test]
fn lists_of_lists_are_visited_once_or_name_the_limit() {
    assert_answers("tessellated sets", &files::tessellated_sets(20), 0, "");
    assert_answers("composites of 4096", &files::composites(3), 3, "");
    assert_answers("composites of 10^8", &files::composites(8), 3, "segments of curves are listed more than");
    assert_answers("composites of 10^20", &files::composites(20), 3, "segments of curves are listed more than");
    assert_answers("shells", &files::repeated_shells(1000), 0, "");
    assert_answers(
        "missing elements",
        &files::missing_elements(3000),
        3,
        "elements of geometric sets are listed more than",
    );
    let shared = "items of representations that products share are listed more than";
    assert_answers("representations", &files::shared_representation(1000), 3, shared);
    assert_answers("one use of an edge", &files::repeated_use(8000), 0, "7999 uses of edges again");
    assert_answers("one edge", &files::repeated_edge(8000), 3, "crosses or overlaps itself");
}

#[test]
fn assemblies_share_names_or_name_the_limit() {
    assert_answers("names", &files::named_assemblies(5, 20_000), 0, "");
    assert_answers("assemblies", &files::named_assemblies(6, 10), 1, "assemblies nested in each other place more than");
}

#[test]
fn a_curve_that_many_edges_share_names_the_limit() {
    assert_answers("curve", &files::shared_curve(200, 300), 3, "points of shared curves are listed more than");
}

#[test]
fn extreme_numbers_are_named() {
    assert_answers("unit", &files::huge_unit(), 3, "out of range; millimetres assumed");
    assert_answers("far", &files::far_away(), 1, "--recenter moves the scene to the origin");
}

#[test]
fn a_limit_on_memory_is_held_or_named() {
    let cases = [
        ("numbers", files::numbers(10_000_000), "--max-memory"),
        ("blanks", files::numbers(4_000_000).replace("1,", ","), "--max-memory"),
        ("triangles", files::triangulation(300), "--max-memory"),
        ("surfaces", files::shared_surface(40, 400), "--max-memory"),
    ];
    for (name, text, why) in cases {
        let file = folder(name).join("attack.step");
        fs::write(&file, text).unwrap();
        let run = tessellate(&file, &["--max-memory", "100"]);
        ends_well(&run, 250_000_000, name);
        assert!(run.status == Some(1) && run.said.contains(why), "{name}: {run:?}");
        let run = tessellate(&file, &["--max-memory", "500"]);
        ends_well(&run, MEMORY_OF_500, name);
        assert!(run.status != Some(1) || run.said.contains(why), "{name}: {run:?}");
    }
}

#[test]
fn known_attacks_end_well() {
    let folder = folder("known");
    let Ok(known) = fs::read_dir(Path::new(SHARED).join("attack")) else {
        println!("no folder {SHARED}/attack");
        return;
    };
    for path in known.flatten().map(|entry| entry.path()).filter(|path| path.extension().is_some_and(|e| e == "step")) {
        let file = folder.join(path.file_name().unwrap());
        fs::copy(&path, &file).unwrap();
        for memory in [&[][..], &["--max-memory", "500"]] {
            for chord in [&[][..], &["--chord-rel", "1e-4", "--workers", "1"]] {
                let options = [memory, chord].concat();
                ends_well(&tessellate(&file, &options), MEMORY, &format!("{} {options:?}", path.display()));
            }
        }
    }
}
