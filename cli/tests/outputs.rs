//! Files of one run appear together or not at all, and no two are the same file.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../../tests/folders/mod.rs"]
mod folders;
mod run;

use folders::{folder, names};
use run::{BINARY, command, told};
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

const CUBE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/data/red_cube_blue_cylinder.step");

fn trimtess(folder: &Path, args: &[&str]) -> Output {
    command(folder, args).output().unwrap()
}

#[test]
fn links_to_each_other_are_kept() {
    let folder = folder("loop");
    symlink("b.ply", folder.join("a.ply")).unwrap();
    symlink("a.ply", folder.join("b.ply")).unwrap();
    let output = trimtess(&folder, &["tessellate", "builtin:box", "-o", "a.ply"]);
    assert_eq!(output.status.code(), Some(1), "{}", told(&output));
    assert!(told(&output).contains("cannot create a.ply"), "{}", told(&output));
    assert_eq!(fs::read_link(folder.join("a.ply")).unwrap().as_os_str(), "b.ply");
}

#[test]
fn an_output_is_no_other_output_and_no_input_by_link_either() {
    let folder = folder("same");
    fs::copy(CUBE, folder.join("cube.step")).unwrap();
    symlink("cube.step", folder.join("soft.ply")).unwrap();
    fs::hard_link(folder.join("cube.step"), folder.join("hard.ply")).unwrap();
    symlink("later.ply", folder.join("dangling.json")).unwrap();
    let before = names(&folder);
    let input = fs::read(CUBE).unwrap();
    for args in [
        &["tessellate", "cube.step", "-o", "soft.ply"][..],
        &["tessellate", "cube.step", "-o", "hard.ply"],
        &["tessellate", "cube.step", "-o", "x.ply", "--report", "./x.ply"],
        &["tessellate", "cube.step", "-o", "later.ply", "--report", "dangling.json"],
        &["tessellate", "cube.step", "-o", "x.ply", "--report", "t.json", "--trace", "t.json"],
        &["tessellate", "cube.step", "-o", "x.ply", "--trace", "cube.step"],
        &["info", "cube.step", "--svg", "hard.ply"],
        &["bench", "cube.step", "--json", "x.json", "--plot", "x.json"],
        &["bench", "builtin:box", "--path", "cube.step", "--save-path", "soft.ply"],
        &["bench", "tile-costs", "builtin:box", "cube.step", "--trace", "soft.ply"],
        &["bench", "glu-scene", "triangles", "cube.step", "--trace", "hard.ply"],
    ] {
        let output = trimtess(&folder, args);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", told(&output));
        assert!(told(&output).contains("cannot be the same file"), "{args:?}: {}", told(&output));
        assert_eq!(names(&folder), before, "{args:?}");
        assert_eq!(fs::read(folder.join("cube.step")).unwrap(), input, "{args:?}");
    }
}

#[test]
fn a_report_that_cannot_be_written_costs_the_mesh_and_the_timeline() {
    let folder = folder("together");
    fs::write(folder.join("x.ply"), "before").unwrap();
    for args in [&["--report", "/dev/full"][..], &["--trace", "/dev/full", "--report", "r.json"]] {
        let output = trimtess(&folder, &[&["tessellate", CUBE, "-o", "x.ply"], args].concat());
        assert_eq!(output.status.code(), Some(1), "{args:?}: {}", told(&output));
        assert!(output.stdout.is_empty(), "nothing is told to be done");
        assert_eq!((names(&folder), fs::read(folder.join("x.ply")).unwrap()), (vec!["x.ply".into()], b"before".into()));
    }
    let all = ["tessellate", CUBE, "-o", "x.ply", "--report", "r.json", "--trace", "t.json"];
    assert_eq!(trimtess(&folder, &all).status.code(), Some(0));
    assert_eq!(names(&folder), ["r.json", "t.json", "x.ply"]);
}

#[test]
fn signals_leave_nothing_behind() {
    for (signal, number) in [("TERM", 15), ("INT", 2)] {
        let folder = folder(signal);
        assert!(Command::new("mkfifo").arg(folder.join("report")).status().unwrap().success());
        // The mesh waits for the report, and the report for a reader.
        let mut command = command(&folder, &["tessellate", CUBE, "-o", "x.ply", "--report", "report"]);
        let mut child = command.stdout(Stdio::null()).spawn().unwrap();
        let start = Instant::now();
        while names(&folder).len() < 2 {
            assert!(start.elapsed() < Duration::from_secs(20), "no temporary file");
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(Duration::from_millis(50));
        let killed = Command::new("kill").args(["-s", signal, &child.id().to_string()]).status().unwrap();
        assert!(killed.success());
        assert_eq!(child.wait().unwrap().signal(), Some(number));
        assert_eq!(names(&folder), ["report"]);
    }
}

#[test]
fn a_replaced_mesh_keeps_its_mode_and_a_long_name_is_no_obstacle() {
    let folder = folder("mode");
    let name = format!("{}.ply", "x".repeat(251));
    fs::write(folder.join(&name), "before").unwrap();
    fs::set_permissions(folder.join(&name), fs::Permissions::from_mode(0o640)).unwrap();
    let output = trimtess(&folder, &["tessellate", CUBE, "-o", &name]);
    assert_eq!(output.status.code(), Some(0), "{}", told(&output));
    assert_eq!(fs::metadata(folder.join(&name)).unwrap().permissions().mode() & 0o7777, 0o640);
    assert_eq!(names(&folder), [name]);
}

#[test]
fn a_pipe_that_closes_early_is_no_crash() {
    let folder = folder("pipe");
    symlink("/dev/stdout", folder.join("out.obj")).unwrap();
    let line = "\"$0\" tessellate builtin:torus --chord-rel 1e-4 -o out.obj; echo $? > status";
    let mut shell = Command::new("sh");
    shell.args(["-c", &format!("({line}) | head -c 10 > first")]).arg(BINARY);
    assert!(shell.current_dir(&folder).stderr(Stdio::null()).status().unwrap().success());
    let status = fs::read_to_string(folder.join("status")).unwrap();
    assert!(matches!(status.trim(), "0" | "1" | "141"), "{status}");
    assert_eq!(names(&folder), ["first", "out.obj", "status"]);
}
