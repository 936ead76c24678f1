//! The committed header equals what cbindgen makes of the sources; and what the sources promise of themselves.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn made() -> String {
    let config = cbindgen::Config::from_file(root().join("cbindgen.toml")).unwrap();
    // The crate alone, without `cargo metadata`, which a test may not be able to run.
    let bindings = cbindgen::Builder::new().with_config(config).with_src(root().join("src/lib.rs"));
    let mut header = Vec::new();
    bindings.generate().unwrap().write(&mut header);
    String::from_utf8(header).unwrap()
}

#[test]
fn the_header_is_that_of_the_sources() {
    let (path, made) = (root().join("include/trimtess.h"), made());
    if std::env::var_os("TRIMTESS_WRITE_HEADER").is_some() {
        fs::write(&path, &made).unwrap();
    }
    let committed = fs::read_to_string(&path).unwrap_or_default();
    let differs = committed.lines().zip(made.lines()).position(|(a, b)| a != b);
    let line = differs.unwrap_or(committed.lines().count().min(made.lines().count())) + 1;
    assert!(
        committed == made,
        "{} differs from the sources at line {line}; renew it by\n\
         TRIMTESS_WRITE_HEADER=1 cargo test --package trimtess-capi --test header",
        path.display()
    );
}

#[test]
fn the_header_has_the_version_of_the_package() {
    let [major, minor, patch] = ["MAJOR", "MINOR", "PATCH"].map(|name| {
        let line = format!("#define TT_VERSION_{name} ");
        made().lines().find_map(|text| Some(text.strip_prefix(&line)?.to_owned())).unwrap()
    });
    assert_eq!(format!("{major}.{minor}.{patch}"), env!("CARGO_PKG_VERSION"));
}

/// All `.rs` files of the package's sources.
fn sources() -> Vec<PathBuf> {
    let (mut files, mut open) = (Vec::new(), vec![root().join("src")]);
    while let Some(dir) = open.pop() {
        for entry in fs::read_dir(dir).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { open.push(path) } else { files.push(path) }
        }
    }
    files
}

/// `memory.rs` lends what C gave for a tile, by the border's own function.
#[test]
fn pointers_are_followed_at_the_border_alone() {
    for path in sources() {
        let inside = path.strip_prefix(root().join("src")).unwrap().to_owned();
        if inside.starts_with("border") || inside == Path::new("tests.rs") {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        let blocks = code.filter(|line| line.contains("unsafe {") || line.contains("unsafe impl")).count();
        let allowed = usize::from(inside == Path::new("memory.rs"));
        assert_eq!(blocks, allowed, "unsafe code in {}", inside.display());
    }
}

/// Without an entry, a panic would reach C, and an error would have no words.
#[test]
fn every_function_is_an_entry() {
    let no_entry = ["tt_last_error", "tt_version", "tt_live_handles"];
    let mut count = 0;
    for path in sources() {
        let text = fs::read_to_string(&path).unwrap();
        for function in text.split("#[unsafe(no_mangle)]\n").skip(1) {
            let name = function.split("fn ").nth(1).unwrap().split('(').next().unwrap().to_owned();
            let body = function.split_once(" {\n").unwrap().1.trim_start();
            assert!(body.starts_with("entry!(") != no_entry.contains(&&*name), "{name}");
            count += 1;
        }
    }
    assert!(count > 60, "{count} functions");
}
