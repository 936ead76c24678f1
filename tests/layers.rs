//! Sources -> `use`s that point the wrong way: enforces the table of docs/architecture.md.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::{Path, PathBuf};

/// Each folder of `src/` and the folders it may name, in the order of the data flow.
const MAY_USE: [(&str, &[&str]); 12] = [
    ("math", &[]),
    ("control", &[]),
    ("view", &[]),
    ("model", &["math"]),
    ("import", &["math", "control", "model"]),
    ("mesh", &["math", "model"]),
    ("prepare", &["math", "control", "model", "mesh"]),
    ("frame", &["math", "control", "view", "model", "mesh", "prepare"]),
    ("parallel", &["math", "control", "view", "model", "mesh", "prepare", "frame"]),
    ("audit", &["math", "model", "mesh", "prepare", "frame"]),
    ("draw", &["model", "mesh", "prepare", "frame"]),
    ("out", &["control", "view", "model", "mesh"]),
];

/// Libraries, and the only folders that may name them. Threads are those of the caller's `Jobs`, of which rayon is one;
/// devices belong to pictures, windows to the program (`cli/`). Hashes of content are made of parts, and of faces of a
/// file.
const CRATE_ONLY_IN: [(&str, &[&str]); 10] = [
    ("blake3", &["prepare", "import"]),
    ("pulp", &["math"]),
    ("rayon", &["control"]),
    ("cpu_time", &["parallel"]),
    ("gltf_json", &["out"]),
    ("offset_allocator", &["out"]),
    ("pollster", &["out"]),
    ("winit", &[]),
    ("egui", &[]),
    ("egui_winit", &[]),
];

/// All `.rs` files under `dir`, sorted.
fn sources(dir: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut open = vec![dir.to_path_buf()];
    while let Some(dir) = open.pop() {
        for entry in fs::read_dir(&dir).unwrap_or_else(|e| panic!("{}: {e}", dir.display())) {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

/// Code without comment lines: comments may mention any layer.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// First words reached through `crate::x` or `crate::{x, y::z}`.
fn named_layers(text: &str) -> impl Iterator<Item = &str> {
    text.split("crate::").skip(1).flat_map(|rest| {
        let grouped = rest.starts_with('{');
        let end = rest.find(|c: char| if grouped { c == ';' } else { !c.is_alphanumeric() && c != '_' });
        rest[..end.unwrap_or(rest.len())].split(|c: char| !c.is_alphanumeric() && c != '_')
    })
}

/// Whether `text` names the crate `name` at the start of a path.
fn names_crate(text: &str, name: &str) -> bool {
    text.match_indices(name).any(|(at, _)| {
        let before = text[..at].chars().next_back();
        let after = &text[at + name.len()..];
        before.is_none_or(|c| !c.is_alphanumeric() && c != '_' && c != ':') && after.starts_with("::")
    })
}

fn src() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

#[test]
fn layers_point_one_way() {
    let mut bad = Vec::new();
    for (layer, allowed) in MAY_USE {
        let forbidden: Vec<_> =
            MAY_USE.iter().map(|(l, _)| *l).filter(|l| *l != layer && !allowed.contains(l)).collect();
        for path in sources(&src().join(layer)) {
            for word in named_layers(&code(&path)).filter(|word| forbidden.contains(word)) {
                bad.push(format!("{} may not name `{word}`", path.display()));
            }
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}

#[test]
fn every_folder_of_src_is_in_the_table() {
    for entry in fs::read_dir(src()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let known = name == "lib.rs" || MAY_USE.iter().any(|(layer, _)| *layer == name);
        assert!(known, "src/{name} has no row in MAY_USE");
    }
}

#[test]
fn libraries_stay_in_their_folders() {
    let mut bad = Vec::new();
    for (layer, _) in MAY_USE {
        for path in sources(&src().join(layer)) {
            let text = code(&path);
            for (name, _) in CRATE_ONLY_IN.iter().filter(|(name, at)| !at.contains(&layer) && names_crate(&text, name))
            {
                bad.push(format!("{} may not name the crate `{name}`", path.display()));
            }
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}

#[test]
fn the_scanner_finds_layers_and_crates() {
    assert_eq!(named_layers("use crate::frame::plan; crate::out::save()").collect::<Vec<_>>(), ["frame", "out"]);
    assert!(named_layers("use crate::{mesh::Batch, parallel};").any(|word| word == "parallel"));
    assert!(names_crate("use rayon::prelude::*;", "rayon"));
    assert!(!names_crate("fn crayon::x() { rayon }", "rayon"));
}

#[test]
fn elementary_functions_are_the_same_on_every_platform() {
    let names = [
        "sin", "cos", "sin_cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "asinh", "acosh",
        "atanh", "exp", "exp2", "exp_m1", "ln", "ln_1p",
    ];
    // Not `angle_to` of glam: three places compare it with a limit, and no coordinate depends on it.
    let more =
        ["log", "log2", "log10", "powf", "hypot", "cbrt", "angle_between", "to_angle", "from_axis_angle", "powi"];
    // The order of the products of `powi` is up to the compiler. Squares and cubes have one order, and powers of a half
    // are exact in any.
    let alike = ["libm::", ".powi(2)", ".powi(3)", "0.5_f64.powi("];
    let mut bad = Vec::new();
    // Not `view`, whose paths and orbits make cameras: these are input.
    for layer in ["math", "control", "model", "import", "mesh", "prepare", "frame", "parallel"] {
        for path in sources(&src().join(layer)).iter().filter(|path| !path.ends_with("tests.rs")) {
            let code = code(path);
            let of_library = code.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
            let of_library = alike.iter().fold(of_library.to_owned(), |text, same| text.replace(same, ""));
            for name in names.iter().chain(&more) {
                let called = of_library.contains(&format!(".{name}(")) || of_library.contains(&format!("::{name}("));
                if called {
                    bad.push(format!(
                        "{} calls `{name}`, whose bits differ between platforms: see libm",
                        path.display()
                    ));
                }
            }
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}
