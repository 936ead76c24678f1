//! Hostile and unlucky arguments: numbers out of range, devices without end, names that are not UTF-8.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../../tests/folders/mod.rs"]
mod folders;
mod run;

use folders::folder;
use run::{CHECKOUT, CUBE, told};
use std::fs;
use std::path::Path;
use std::process::Command;

fn command(args: &[&str]) -> Command {
    run::command(CHECKOUT, args)
}

#[test]
fn tolerances_of_a_drawing_need_one() {
    for option in ["--chord", "--chord-rel", "--angle", "--max-edge"] {
        let output = command(&["info", CUBE, option, "1"]).output().unwrap();
        assert!(output.status.code() == Some(2) && told(&output).contains("--svg"), "{option}: {}", told(&output));
    }
}

#[test]
fn numbers_out_of_range_are_wrong_usage_and_the_range_is_told() {
    let cases: [(&[&str], &str); 6] = [
        (&["bench", "builtin:box", "--frames", "4294967295"], "1..=1000000"),
        (&["bench", "builtin:box", "--rounds", "1001"], "1..=1000"),
        (&["bench", "builtin:box", "--replay=65535"], "1..=1024"),
        (&["bench", "builtin:box", "--size", "4294967295x4294967295"], "32768x32768"),
        (&["info", "builtin:box", "--workers", "65535"], "1..=1024"),
        (&["bench", "builtin:box", "--workers", "1,1025"], "1..=1024"),
    ];
    for (args, range) in cases {
        let output = command(args).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", told(&output));
        assert!(told(&output).contains(range), "{args:?}: {}", told(&output));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn devices_without_end_are_refused_at_their_first_bytes() {
    let mesh = folder("endless").join("x.ply");
    let mesh = mesh.to_str().unwrap();
    for args in [
        &["bench", "builtin:box", "--path", "/dev/zero"][..],
        &["bench", "glu-scene", "triangles", "/dev/zero"],
        &["info", "/dev/zero"],
        &["tessellate", "/dev/urandom", "-o", mesh],
    ] {
        let start = std::time::Instant::now();
        let output = command(args).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{args:?}: {}", told(&output));
        assert!(told(&output).contains("/dev/"), "{args:?}: {}", told(&output));
        assert!(start.elapsed().as_secs() < 10, "{args:?}: {:?}", start.elapsed());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_large_file_that_is_not_step_is_not_read_whole() {
    let path = folder("large").join("film.step");
    // A gibibyte of nothing, which takes no space on the disk.
    fs::File::create(&path).unwrap().set_len(1 << 30).unwrap();
    let start = std::time::Instant::now();
    let output = command(&["info"]).arg(&path).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", told(&output));
    assert!(start.elapsed().as_secs_f64() < 0.5, "{:?}", start.elapsed());
}

#[cfg(target_os = "linux")]
#[test]
fn names_that_are_not_utf_8_work() {
    use std::os::unix::ffi::OsStrExt;
    let folder = folder("names");
    let name = |bytes: &[u8]| folder.join(std::ffi::OsStr::from_bytes(bytes));
    let (file, mesh, report) = (name(b"w\xfcrfel.step"), name(b"w\xfcrfel.ply"), name(b"w\xfcrfel.json"));
    fs::copy(Path::new(CHECKOUT).join(CUBE), &file).unwrap();
    let output =
        command(&["tessellate", "--check"]).arg(&file).arg("-o").arg(&mesh).arg("--report").arg(&report).output();
    let output = output.unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", told(&output));
    assert!(mesh.exists() && report.exists());
}

#[test]
fn quiet_prints_nothing_but_errors_and_what_is_asked_for() {
    let folder = folder("quiet");
    let mesh = folder.join("x.ply");
    let mesh = mesh.to_str().unwrap();
    let output = command(&["tessellate", CUBE, "-o", mesh, "--check", "-q"]).output().unwrap();
    assert_eq!((output.status.code(), output.stdout.len(), output.stderr.len()), (Some(0), 0, 0), "{}", told(&output));
    let output = command(&["tessellate", CUBE, "-o", mesh, "-q", "--json"]).output().unwrap();
    assert!(output.stdout.starts_with(b"{") && output.stderr.is_empty(), "{}", told(&output));
    let output = command(&["tessellate", "no.step", "-o", mesh, "-q"]).output().unwrap();
    assert!(output.stdout.is_empty() && told(&output).starts_with("error: "), "{}", told(&output));
}

#[test]
fn a_file_without_faces_is_status_3() {
    let folder = folder("no_faces");
    let (file, mesh) = (folder.join("empty.step"), folder.join("empty.ply"));
    let text = "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n\
                FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n#1=CARTESIAN_POINT('',(0.,0.,0.));\nENDSEC;\n\
                END-ISO-10303-21;\n";
    fs::write(&file, text).unwrap();
    for args in [&["info"][..], &["tessellate", "-o", mesh.to_str().unwrap()]] {
        let output = command(args).arg(&file).output().unwrap();
        assert_eq!(output.status.code(), Some(3), "{args:?}: {}", told(&output));
    }
    let output = command(&["tessellate", "-o", mesh.to_str().unwrap(), "-v"]).arg(&file).output().unwrap();
    assert!(told(&output).contains("no faces"), "{}", told(&output));
}

#[test]
fn a_face_that_is_filled_is_status_3_in_every_command() {
    let folder = folder("filled");
    let (file, mesh) = (folder.join("filled.step"), folder.join("filled.stl"));
    let (text, surface) = (fs::read_to_string(Path::new(CHECKOUT).join(CUBE)).unwrap(), "0.00500000000000000 );");
    assert!(text.contains(surface));
    fs::write(&file, text.replace(surface, "-1. );")).unwrap();
    for args in [&["info"][..], &["tessellate", "-q", "-o", mesh.to_str().unwrap()], &["bench", "--frames", "1"]] {
        let output = command(args).arg(&file).output().unwrap();
        assert_eq!(output.status.code(), Some(3), "{args:?}: {}", told(&output));
    }
}
