//! Full disks, folders that cannot be written, closed pipes, and signals in the middle of writing.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../../tests/folders/mod.rs"]
mod folders;
mod run;

use folders::names;
use run::{BINARY, told};
use std::fs::{self, File};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

const CUBE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/data/red_cube_blue_cylinder.step");
const ALL: [&str; 4] = ["glb", "stl", "ply", "obj"];

/// As [`folders::folder`]. A test that failed may have left one that cannot be written.
fn folder(test: &str) -> PathBuf {
    let left = Path::new(env!("CARGO_TARGET_TMPDIR")).join(env!("CARGO_CRATE_NAME")).join(test);
    let _ = fs::set_permissions(left, fs::Permissions::from_mode(0o755));
    folders::folder(test)
}

/// Runs a line of the shell in `folder`; `$0` is the program and `$1` a file.
fn shell(folder: &Path, line: &str) -> Output {
    let mut shell = Command::new("sh");
    shell.args(["-c", line, BINARY, CUBE]).current_dir(folder).env_remove("RUST_LOG");
    shell.output().unwrap()
}

#[test]
fn a_file_that_may_not_grow_costs_all_files_of_the_run_and_the_previous_ones_stay() {
    let folder = folder("limit");
    let report = folder.join("report.json");
    for extension in ALL {
        let mesh = format!("mesh.{extension}");
        fs::write(folder.join(&mesh), "before").unwrap();
        fs::write(&report, "before").unwrap();
        // Blocks of 512 bytes. The signal is ignored, so that writing fails.
        for blocks in [0, 1, 7] {
            let output = shell(
                &folder,
                &format!(
                    "trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" tessellate \"$1\" -o {mesh} --report report.json"
                ),
            );
            assert_eq!(output.status.code(), Some(1), "{extension} {blocks}: {}", told(&output));
            assert!(told(&output).contains(&mesh) && told(&output).contains("too large"), "{}", told(&output));
            assert!(output.stdout.is_empty(), "nothing is told to be done");
            assert_eq!(names(&folder), [mesh.as_str(), "report.json"]);
            assert_eq!(fs::read(folder.join(&mesh)).unwrap(), b"before");
            assert_eq!(fs::read(&report).unwrap(), b"before");
        }
        fs::remove_file(folder.join(&mesh)).unwrap();
    }
}

#[test]
fn a_full_disk_leaves_the_previous_files_and_no_part_of_new_ones() {
    let folder = folder("full");
    // A disk of its own, which nobody else sees.
    let mounted = "mount -t tmpfs -o size=64k none . && cd . && cd \"$PWD\"";
    let probe = Command::new("unshare").args(["-rm", "sh", "-c", mounted]).current_dir(&folder).output();
    if !probe.as_ref().is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: no disk of one's own can be mounted here: {probe:?}");
        return;
    }
    for extension in ALL {
        let line = format!(
            "{mounted}; echo before > mesh.{extension}; \"$0\" tessellate \"$1\" --chord 1e-4 -o mesh.{extension} \
             --report r.json; echo status $?; ls -A; cat mesh.{extension}"
        );
        let mut command = Command::new("unshare");
        command.args(["-rm", "sh", "-c", &line, BINARY, CUBE]).current_dir(&folder).env_remove("RUST_LOG");
        let output = command.output().unwrap();
        let found = String::from_utf8_lossy(&output.stdout);
        assert_eq!(found, format!("status 1\nmesh.{extension}\nbefore\n"), "{}", told(&output));
        assert!(told(&output).contains("No space left"), "{}", told(&output));
    }
}

#[test]
fn a_folder_that_cannot_be_written_is_named_and_nothing_changes() {
    let folder = folder("read-only");
    fs::write(folder.join("mesh.ply"), "before").unwrap();
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o555)).unwrap();
    let mut command = Command::new(BINARY);
    command.args(["tessellate", CUBE, "-o", "mesh.ply"]).current_dir(&folder).env_remove("RUST_LOG");
    if File::create(folder.join("probe")).is_ok() {
        // The superuser writes everywhere; nobody does not.
        fs::remove_file(folder.join("probe")).unwrap();
        command.uid(65534);
    }
    match command.output() {
        Ok(output) => {
            assert_eq!(output.status.code(), Some(1), "{}", told(&output));
            assert!(told(&output).contains("mesh.ply") && told(&output).contains("ermission"), "{}", told(&output));
        }
        Err(error) => eprintln!("skipped: another user cannot run the program: {error}"),
    }
    assert_eq!(names(&folder), ["mesh.ply"]);
    assert_eq!(fs::read(folder.join("mesh.ply")).unwrap(), b"before");
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn closed_and_full_standard_streams_do_not_change_the_status() {
    let folder = folder("streams");
    let run = "\"$0\" tessellate \"$1\" -o mesh.ply -v";
    for (line, status) in [
        (format!("{run} 2>/dev/full"), 0),
        (format!("{run} 2>&-"), 0),
        (format!("{run} >&-"), 0),
        ("\"$0\" tessellate none.step -o mesh.ply 2>/dev/full".to_owned(), 1),
        ("\"$0\" tessellate none.step -o mesh.ply -vv 2>&-".to_owned(), 1),
        // What was asked for and cannot be told is an error.
        ("\"$0\" info \"$1\" --json >/dev/full".to_owned(), 1),
        ("\"$0\" tessellate \"$1\" -o mesh.ply --nonsense 2>/dev/full".to_owned(), 2),
    ] {
        let output = shell(&folder, &line);
        assert_eq!(output.status.code(), Some(status), "{line}: {}", told(&output));
    }
    // A reader that has gone.
    for line in ["\"$0\" info \"$1\" -v", "\"$0\" bench builtin:list", "\"$0\" tessellate \"$1\" -v -o mesh.ply 2>&1"] {
        let output = shell(&folder, &format!("({line}; echo $? > status) | true"));
        assert!(output.status.success(), "{line}");
        assert_eq!(fs::read_to_string(folder.join("status")).unwrap(), "0\n", "{line}");
    }
    assert_eq!(names(&folder), ["mesh.ply", "status"]);
}

/// A run that writes for long.
fn long_run(folder: &Path, mesh: &str) -> Command {
    let mut command = Command::new(BINARY);
    command.args(["tessellate", "builtin:torus", "--chord-rel", "1e-5", "-o", mesh]).current_dir(folder);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    command
}

/// What the run writes if nobody stops it.
fn whole(folder: &Path, mesh: &str) -> Vec<u8> {
    assert!(long_run(folder, mesh).status().unwrap().success());
    fs::read(folder.join(mesh)).unwrap()
}

/// Starts long runs until one is seen while its temporary file has content: a busy machine may look away for all the
/// time that a run writes.
fn writing(folder: &Path, mesh: &str) -> Child {
    let is_part =
        |entry: fs::DirEntry| entry.file_name() != mesh && entry.metadata().is_ok_and(|known| known.len() > 0);
    for _ in 0..20 {
        fs::write(folder.join(mesh), "before").unwrap();
        let mut child = long_run(folder, mesh).spawn().unwrap();
        while child.try_wait().unwrap().is_none() {
            if fs::read_dir(folder).unwrap().any(|entry| entry.is_ok_and(is_part)) {
                return child;
            }
            std::thread::sleep(Duration::from_micros(200));
        }
    }
    panic!("twenty runs had ended before they were seen");
}

#[test]
fn a_run_that_is_killed_while_it_writes_leaves_the_previous_file() {
    for (signal, number) in [("TERM", 15), ("INT", 2), ("KILL", 9)] {
        for mesh in ["mesh.obj", "mesh.stl"] {
            let folder = folder(&format!("killed-{signal}"));
            let mut child = writing(&folder, mesh);
            assert!(Command::new("kill").args(["-s", signal, &child.id().to_string()]).status().unwrap().success());
            let status = child.wait().unwrap();
            let left: Vec<String> = names(&folder).into_iter().filter(|name| name != mesh).collect();
            if status.success() {
                eprintln!("{mesh} was written before SIG{signal}");
                assert_eq!(left, [""; 0]);
                continue;
            }
            assert_eq!(status.signal(), Some(number), "{mesh}");
            let found = fs::read(folder.join(mesh)).unwrap();
            if found == b"before" {
                // SIGKILL cannot be handled. The file that stays is hidden and hinders no later run.
                assert!(left.iter().all(|name| signal == "KILL" && name.ends_with(".part")), "SIG{signal}: {left:?}");
            } else {
                // The signal came after the file had its name, and before the process had ended.
                assert_eq!(left, [""; 0]);
                assert!(found == whole(&folder, mesh), "SIG{signal}: {} bytes of {mesh}", found.len());
            }
            let output = shell(&folder, &format!("\"$0\" tessellate \"$1\" -o {mesh}"));
            assert_eq!(output.status.code(), Some(0), "{}", told(&output));
        }
    }
}
