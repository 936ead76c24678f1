//! The contract of the command line: exit statuses, report keys, files written atomically.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../../tests/folders/mod.rs"]
mod folders;
mod run;

use folders::folder;
use run::{CHECKOUT, CUBE, command};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Output;

const FORMS: &str = "tests/fuzz/seeds/forms.step";

fn name(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn trimtess(args: &[&str]) -> Output {
    command(CHECKOUT, args).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn json(bytes: &[u8]) -> Value {
    serde_json::from_slice(bytes).unwrap_or_else(|e| panic!("{e}: {}", text(bytes)))
}

/// Asserts that the command fails with this status and a message that contains `why`.
fn refuses(args: &[&str], status: i32, why: &str) {
    let output = trimtess(args);
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{args:?}: {stderr}");
    assert!(stderr.contains(why), "{args:?}: {stderr}");
    assert!(!stderr.contains("panicked") && !stderr.contains("internal error"), "{args:?}: {stderr}");
}

#[test]
fn a_file_has_the_same_bytes_whatever_registers_the_processor_has() {
    let folder = folder("lanes");
    let [wide, scalar] = ["wide.glb", "scalar.glb"].map(|name| folder.join(name));
    for input in ["tests/data/nist_ctc05.step", "builtin:trimmed-teapot", "builtin:wave"] {
        let run = |out: &Path, lanes: &str| {
            let mut command = command(CHECKOUT, &["tessellate", input, "--chord-rel", "3e-4", "-o"]);
            command.arg(out).env("TRIMTESS_LANES", lanes);
            assert!(command.output().unwrap().status.success(), "{input} {lanes}");
            fs::read(out).unwrap()
        };
        assert!(run(&wide, "widest") == run(&scalar, "scalar"), "{input}");
    }
}

#[test]
fn wrong_usage_is_status_2() {
    let out = folder("usage").join("x.glb");
    let out = out.to_str().unwrap();
    refuses(&[], 2, "Usage");
    refuses(&["tessellate", CUBE], 2, "--output");
    refuses(&["tessellate", CUBE, "-o", "mesh.xyz"], 2, ".xyz");
    refuses(&["tessellate", CUBE, "-o", out, "--chord=-1"], 2, "positive");
    refuses(&["tessellate", CUBE, "-o", out, "--chord", "nan"], 2, "positive");
    refuses(&["tessellate", CUBE, "-o", out, "--chord", "1", "--chord-rel", "1"], 2, "--chord-rel");
    refuses(&["tessellate", CUBE, "-o", out, "--workers", "0"], 2, "--workers");
    refuses(&["info", "builtin:no-such-shape"], 2, "builtin:list");
    refuses(&["info", "builtin:wave", "--border-tolerance=-1"], 2, "from 0 to 1");
    assert!(!Path::new(out).exists());
}

#[test]
fn failures_are_status_1_and_name_the_file() {
    let folder = folder("cannot");
    let (text_file, mesh) = (folder.join("letter.step"), folder.join("x.ply"));
    fs::write(&text_file, "Dear Sir or Madam").unwrap();
    let mesh = mesh.to_str().unwrap();
    refuses(&["tessellate", "no/such/file.step", "-o", mesh], 1, "no/such/file.step");
    refuses(&["tessellate", text_file.to_str().unwrap(), "-o", mesh], 1, "letter.step");
    refuses(&["info", text_file.to_str().unwrap()], 1, "letter.step");
    refuses(&["tessellate", CUBE, "-o", "no/such/folder/x.ply"], 1, "no/such/folder");
    assert!(!Path::new(mesh).exists());
}

#[test]
fn a_report_has_the_promised_keys_and_its_seconds_sum() {
    let folder = folder("report");
    let (mesh, report) = (folder.join("cube.ply"), folder.join("cube.json"));
    let output = trimtess(&["tessellate", CUBE, "-o", name(&mesh), "--check", "--json", "--report", name(&report)]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let result = json(&output.stdout);
    assert_eq!(result, json(&fs::read(&report).unwrap()), "standard output and the report file are equal");
    assert_eq!(result["faces"], 9);
    assert_eq!(result["faces_without_triangles"], 0);
    assert_eq!((&result["open_edges"], &result["slivers"]), (&0.into(), &0.into()));
    assert!(result["max_deviation_over_tolerance"].as_f64().unwrap() <= 1.0);
    let edges = result["max_edge_deviation_over_tolerance"].as_f64().unwrap();
    assert!(edges > 0.1 && edges <= 1.0, "the edge polylines are measured whatever the format: {edges}");
    assert!(result["diagnostics"].is_array());
    assert!(result["triangles"].as_u64().unwrap() >= 12 + 12);
    assert!(result["vertices"].as_u64().unwrap() > 0);
    let seconds = &result["seconds"];
    let second = |stage: &str| seconds[stage].as_f64().unwrap_or_else(|| panic!("{stage} in {seconds}"));
    let sum: f64 = ["read", "prepare", "tessellate", "check", "write"].into_iter().map(second).sum();
    assert!((sum - second("total")).abs() < 1e-6, "{seconds}");
    if cfg!(target_os = "linux") {
        assert!(result["peak_memory_bytes"].as_u64().unwrap() > 1 << 20);
    }
}

/// Runs `tessellate --check` on a modified cube file; returns the status, the report and the summary.
fn check(test: &str, change: impl Fn(&str) -> String) -> (Option<i32>, Value, String) {
    let folder = folder(test);
    let (file, mesh) = (folder.join("part.step"), folder.join("part.ply"));
    let whole = fs::read_to_string(Path::new(CHECKOUT).join(CUBE)).unwrap();
    fs::write(&file, change(&whole)).unwrap();
    let args = ["tessellate", file.to_str().unwrap(), "-o", mesh.to_str().unwrap()];
    let output = trimtess(&[&args[..], &["--check", "--json"]].concat());
    let table = text(&trimtess(&[&args[..], &["--check"]].concat()).stdout);
    (output.status.code(), json(&output.stdout), table)
}

#[test]
fn a_face_off_its_surface_is_reported_and_opens_nothing() {
    // Edges pair up as in the intact file, but the side of the cylinder lies on a plane that its loop does not bound.
    let (status, result, table) = check("off_surface", |file| {
        let surface = "CYLINDRICAL_SURFACE( '', #143, 0.00500000000000000 );";
        assert!(file.contains(surface));
        file.replace(surface, "PLANE( '', #143 );")
    });
    assert_eq!(status, Some(3));
    let named = |entry: &Value| {
        entry["face"] == 2 && entry["code"].is_string() && entry["reason"].as_str().unwrap().contains("filled in space")
    };
    assert!(result["diagnostics"].as_array().unwrap().iter().any(named), "{result}");
    assert_eq!((&result["unbalanced_edges"], &result["defects"]), (&0.into(), &0.into()), "{result}");
    let parts = result["closedness"].as_array().unwrap();
    assert_eq!(parts.len(), 2);
    assert!(parts.iter().all(|part| part["closed_in_file"] == true && part["closed_in_mesh"] == true), "{result}");
    assert!(table.contains("parts 0–1: closed in the file, closed in the mesh"), "{table}");
    assert!(table.contains("99.9%") && table.contains("  plane  "), "{table}");
}

#[test]
fn a_face_whose_surface_cannot_be_read_is_filled_and_named() {
    let (status, result, _) = check("lost_face", |file| {
        let surface = "CYLINDRICAL_SURFACE( '', #143, 0.00500000000000000 );";
        assert!(file.contains(surface));
        file.replace(surface, "CYLINDRICAL_SURFACE( '', #143, -1. );")
    });
    assert_eq!(status, Some(3));
    assert_eq!((&result["faces"], &result["faces_without_triangles"]), (&9.into(), &0.into()), "{result}");
    assert_eq!((&result["ladder"]["filled"], &result["defects"]), (&1.into(), &0.into()), "{result}");
    let named = |entry: &Value| entry["face"] == 2 && entry["code"] == "face-surface-not-read";
    assert_eq!(result["diagnostics"].as_array().unwrap().iter().filter(|entry| named(entry)).count(), 1, "{result}");
}

#[test]
fn measurements_of_an_empty_mesh_are_null() {
    let (status, result, table) = check("nothing", |file| {
        file.replace("MANIFOLD_SOLID_BREP", "X_BREP")
            .replace("CLOSED_SHELL", "X_SHELL")
            .replace("ADVANCED_FACE", "X_FACE")
    });
    assert_eq!((status, &result["triangles"]), (Some(3), &0.into()), "{result}");
    for key in ["max_deviation_over_tolerance", "p999_deviation_over_tolerance", "max_edge_deviation_over_tolerance"] {
        assert!(result.get(key).is_some_and(Value::is_null), "{key} in {result}");
    }
    assert!(!table.contains("at worst"), "{table}");
}

#[test]
fn all_formats_are_written_and_do_not_depend_on_workers() {
    let folder = folder("formats");
    for extension in ["glb", "stl", "ply", "obj"] {
        let mut seen: Option<Vec<u8>> = None;
        for workers in ["1", "2", "3"] {
            let mesh = folder.join(format!("cube{workers}.{extension}"));
            let output = trimtess(&["tessellate", CUBE, "-o", mesh.to_str().unwrap(), "--workers", workers, "-q"]);
            assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
            assert!(output.stderr.is_empty(), "-q: {}", text(&output.stderr));
            let bytes = fs::read(&mesh).unwrap();
            assert!(*seen.get_or_insert_with(|| bytes.clone()) == bytes, "{extension} with {workers} workers differs");
        }
    }
}

#[test]
fn info_counts() {
    let output = trimtess(&["info", CUBE, "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let info = json(&output.stdout);
    assert_eq!(info["placed_faces"], 9);
    assert_eq!(info["surfaces"]["plane"], 8);
    assert_eq!(info["surfaces"]["cylinder"], 1);
    assert_eq!(info["millimetres_per_unit"], 1000.0);
    assert_eq!(info["shells"]["open"], 0);
    let list = info["part_list"].as_array().unwrap();
    let sum = |key: &str| list.iter().map(|part| part[key].as_u64().unwrap()).sum::<u64>();
    assert_eq!((list.len() as u64, sum("faces"), sum("instances")), (info["parts"].as_u64().unwrap(), 9, 2), "{info}");
    assert!(list.iter().all(|part| part["closed"] == true && part["name"] != ""), "{info}");
    // The box of a 10 mm cube at the origin and a cylinder of radius 5 mm next to it.
    assert!((info["diagonal"].as_f64().unwrap() - 28.722_813).abs() < 1e-2, "{info}");
    let people = text(&trimtess(&["info", CUBE]).stdout);
    assert!(people.contains("8 plane") && people.contains("closed"), "{people}");
}

/// Statistics of preparing add up, and match the known shapes.
#[test]
fn info_reports_patches_and_trimming_curves() {
    let result = json(&trimtess(&["info", "builtin:washer", "--patches", "--json"]).stdout);
    let patches = &result["patches"];
    let rows = patches["faces"].as_array().unwrap();
    assert_eq!((rows.len() as u64, patches["parts"].as_array().unwrap().len()), (result["faces"].as_u64().unwrap(), 1));
    for key in ["patches", "tiles", "trims", "edges", "stretches", "meetings", "critical"] {
        let sum: u64 = rows.iter().map(|row| row[key].as_u64().unwrap()).sum();
        assert_eq!(patches["sum"][key], sum, "{key}");
    }
    for row in rows {
        let (round, spans) = (row["kind"] == "cylinder", &row["spans"]);
        assert_eq!(
            (row["patches"].as_u64(), row["rational"].as_bool()),
            (Some(if round { 4 } else { 1 }), Some(round))
        );
        assert_eq!(spans[0].as_u64().unwrap() * spans[1].as_u64().unwrap(), row["patches"].as_u64().unwrap());
        // Two circles bound each of the four faces.
        assert_eq!((row["trims"].as_u64(), row["edges"].as_u64()), (Some(2), Some(2)));
        let bend = row["bounds"]["uu"]["lift"].as_f64().unwrap();
        assert_eq!(bend > 0.0, round, "{row}");
    }
    // Two petals cross, so more edges bound the region than curves were given.
    let flower = json(&trimtess(&["info", "builtin:flower", "--patches", "--json"]).stdout);
    let sum = &flower["patches"]["sum"];
    assert!(sum["edges"].as_u64() > sum["trims"].as_u64(), "{sum}");
    let people = text(&trimtess(&["info", "builtin:washer", "--patches"]).stdout);
    assert!(people.contains("stretches") && people.contains("all  4 faces"), "{people}");
    assert!(!text(&trimtess(&["info", "builtin:washer", "--json"]).stdout).contains("patches"));
}

/// Number of closed figures in the path of this class.
fn figures(svg: &str, class: &str) -> u64 {
    let attribute = format!("class=\"{class}\"");
    let element = svg.split('<').find(|element| element.starts_with("path") && element.contains(&attribute));
    let data = element.and_then(|element| element.split(" d=\"").nth(1)).and_then(|data| data.split('"').next());
    data.map_or(0, |data| data.matches('z').count() as u64)
}

/// Counts in a diagram match its figures and the mesh.
#[test]
fn a_tile_is_drawn_as_it_is_meshed() {
    let folder = folder("svg");
    let (drawing, mesh) = (folder.join("tile.svg"), folder.join("flower.ply"));
    let (out, mesh) = (drawing.to_str().unwrap(), mesh.to_str().unwrap());
    let tolerance = ["--chord-rel", "3e-3", "--json"];
    let args = [&["info", "builtin:flower", "--svg", out][..], &tolerance].concat();
    let output = trimtess(&args);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let drawn = json(&output.stdout)["drawn"].clone();
    let report = json(&trimtess(&[&["tessellate", "builtin:flower", "-o", mesh][..], &tolerance].concat()).stdout);
    // The face is one tile.
    assert_eq!(drawn["triangles"], report["triangles"], "{drawn}");
    let svg = fs::read_to_string(&drawing).unwrap();
    let class_of = [
        ("triangles", "triangles"),
        ("full_cells", "full"),
        ("prime_active_cells", "prime"),
        ("pseudo_active_cells", "pseudo"),
        ("crossings", "crossings"),
        ("in_points", "in-points"),
        ("exit_points", "exit-points"),
    ];
    for (key, class) in class_of {
        assert!(drawn[key].as_u64().unwrap() > 0, "{key}: {drawn}");
        assert_eq!(drawn[key].as_u64().unwrap(), figures(&svg, class), "{key}");
    }
    assert!((1..drawn["kept_corners"].as_u64().unwrap()).contains(&figures(&svg, "kept-corners")), "{drawn}");
    let points = drawn["in_points"].as_u64().unwrap() + drawn["exit_points"].as_u64().unwrap();
    let vertices = points + drawn["kept_corners"].as_u64().unwrap() - drawn["moved_corners"].as_u64().unwrap();
    assert_eq!(report["vertices"].as_u64().unwrap(), vertices + drawn["other_points"].as_u64().unwrap(), "{drawn}");
    // Elements are nested properly.
    let mut open = Vec::new();
    for tag in svg.split('<').skip(1).map(|rest| rest.split('>').next().unwrap()) {
        match tag.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name)),
            None if tag.ends_with('/') => {}
            None => open.push(tag.split_whitespace().next().unwrap()),
        }
    }
    assert!(open.is_empty() && svg.starts_with("<svg "), "{open:?}");

    let cell = json(&trimtess(&[&args[..], &["--cell", "0,0"]].concat()).stdout)["drawn"].clone();
    assert!(cell["exit_points"].as_u64() > Some(0) && cell["external_points"].as_u64() > Some(0), "{cell}");
    assert!(cell["triangles"].as_u64() < drawn["triangles"].as_u64(), "{cell}");
    let people = text(&trimtess(&["info", "builtin:washer", "--face", "2", "--svg", out]).stdout);
    assert!(people.contains("face 2 tile 0"), "{people}");
}

#[test]
fn an_unknown_tile_is_wrong_usage() {
    let folder = folder("svg-usage");
    let drawing = folder.join("tile.svg");
    let out = drawing.to_str().unwrap();
    let with = |more: &[&'static str]| [&["info", "builtin:washer", "--svg", out], more].concat();
    refuses(&with(&["--part", "1"]), 2, "1 parts");
    refuses(&with(&["--face", "4"]), 2, "4 faces");
    refuses(&with(&["--tile", "1"]), 2, "1 tiles");
    refuses(&with(&["--cell", "7"]), 2, "as in 3,7");
    refuses(&with(&["--cell", "1000000,0"]), 2, "cells");
    refuses(&["info", "builtin:washer", "--face", "2"], 2, "--svg");
    refuses(&["info", "builtin:washer", "--svg", "no/such/folder/x.svg"], 1, "no/such/folder");
    assert!(!drawing.exists());
}

#[test]
fn every_builtin_can_be_tessellated() {
    let list = text(&trimtess(&["info", "builtin:list"]).stdout);
    assert!(list.lines().count() > 0);
    let mesh = folder("builtin").join("shape.stl");
    for name in list.lines() {
        let output = trimtess(&["tessellate", name, "-o", mesh.to_str().unwrap(), "--check", "--json"]);
        assert_eq!(output.status.code(), Some(0), "{name}: {}", text(&output.stderr));
        assert!(json(&output.stdout)["triangles"].as_u64().unwrap() > 0, "{name}");
    }
}

/// A truncated file is read as far as it goes, or rejected with a message.
#[test]
fn truncated_files_are_read_or_rejected() {
    let folder = folder("truncated");
    let whole = fs::read(Path::new(CHECKOUT).join(CUBE)).unwrap();
    let (file, mesh) = (folder.join("cut.step"), folder.join("cut.ply"));
    for tenths in 0..10 {
        fs::write(&file, &whole[..whole.len() * tenths / 10]).unwrap();
        let output = trimtess(&["tessellate", file.to_str().unwrap(), "-o", mesh.to_str().unwrap()]);
        let stderr = text(&output.stderr);
        assert!(matches!(output.status.code(), Some(0 | 1 | 3)), "{tenths}: {:?} {stderr}", output.status);
        assert!(!stderr.contains("internal error"), "{tenths}: {stderr}");
        assert!(output.status.code() != Some(1) || stderr.contains("cut.step"), "{tenths}: {stderr}");
    }
}

/// Exceeding a limit gives one message with the need, the limit and the option, and no file.
#[test]
fn limits_are_errors_that_name_the_option() {
    let folder = folder("limits");
    let mesh = folder.join("mesh.ply");
    let out = mesh.to_str().unwrap();
    let bytes = fs::metadata(Path::new(CHECKOUT).join(CUBE)).unwrap().len();
    let refused = |option: &str, value: &str, why: &str| {
        let args = ["tessellate", CUBE, "-o", out, "--chord-rel", "1e-3", option, value];
        refuses(&args, 1, why);
        refuses(&args, 1, option);
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 0, "{option}");
    };
    refused("--max-bytes", "1000", &bytes.to_string());
    refused("--max-entities", "10", "instances, the limit is 10");
    refused("--max-instances", "1", "more than 1 parts");
    refused("--max-memory", "0", "the limit is 0");
    refused("--max-patches", "3", "patches, the limit is 3");
    refused("--max-triangles", "20", "the limit is 20 (PlanLimits::triangles)");
    refused("--max-tile-triangles", "4", "limit of 4 triangles");
    refuses(&["bench", CUBE, "--hash", "--frames", "2", "--max-triangles", "10"], 1, "the limit is 10");
    let coarse = ["tessellate", CUBE, "-o", out, "--max-tile-triangles", "4", "--coarsen", "--json"];
    let output = trimtess(&coarse);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let result = json(&output.stdout)["diagnostics"].to_string();
    assert!(result.contains("coarser than the tolerance asks"), "{result}");
    assert!(mesh.exists());
}

#[test]
fn the_report_is_written_atomically() {
    let folder = folder("report-whole");
    let (mesh, report) = (folder.join("mesh.ply"), folder.join("missing").join("report.json"));
    let args = ["tessellate", "builtin:box", "-o", mesh.to_str().unwrap(), "--report", report.to_str().unwrap()];
    refuses(&args, 1, "report.json");
    let output = trimtess(&[&args[..4], &["--report", "/dev/null"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(!Path::new("/dev/null").is_file(), "a device stays one");
}

/// Without a graphics adapter, one message says what to install.
#[cfg(feature = "wgpu")]
#[test]
fn render_draws_or_names_the_missing_driver() {
    let folder = folder("render");
    let picture = folder.join("cube.png");
    let out = picture.to_str().unwrap();
    refuses(&["render", CUBE, "-o", "cube.jpg"], 2, ".png");
    refuses(&["render", CUBE, "-o", out, "--size", "100"], 2, "WIDTHxHEIGHT");
    refuses(&["render", CUBE, "-o", out, "--camera", "upside-down"], 2, "iso");
    refuses(&["render", CUBE, "-o", out, "--color-by", "mood"], 2, "worker");
    for extra in
        [&["--camera", "-30,20,1.2"][..], &["--wireframe", "--edges"], &["--color-by", "tile", "--size-px", "9"]]
    {
        let args = [&["render", CUBE, "-o", out, "--size", "160x120", "--json"], extra].concat();
        let output = trimtess(&args);
        match output.status.code() {
            Some(0) => {
                let bytes = fs::read(&picture).unwrap();
                assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
                assert_eq!(&bytes[16..24], &[0, 0, 0, 160, 0, 0, 0, 120], "width and height");
                assert!(json(&output.stdout)["triangles"].as_u64().unwrap() > 0);
                fs::remove_file(&picture).unwrap();
            }
            Some(1) => {
                assert!(text(&output.stderr).contains("mesa-vulkan-drivers"), "{}", text(&output.stderr));
                assert!(!picture.exists());
            }
            other => panic!("{args:?}: {other:?} {}", text(&output.stderr)),
        }
    }
}

/// The content of the window, without a window.
#[cfg(feature = "view")]
#[test]
fn view_writes_screenshots() {
    let folder = folder("view");
    let picture = folder.join("window.png");
    let out = picture.to_str().unwrap();
    refuses(&["view", CUBE, "--screenshot", "window.jpg"], 2, ".png");
    refuses(&["view", CUBE, "--frames", "3"], 2, "--screenshot");
    refuses(&["view", "--screenshot", out], 2, "FILE");
    refuses(&["view", CUBE, "--screenshot", out, "--click", "5"], 2, "X,Y");
    let window = ["--size", "480x320", "--screenshot", out];
    let drawn = trimtess(&[&["view", CUBE], &window[..]].concat());
    if drawn.status.code() == Some(1) {
        assert!(text(&drawn.stderr).contains("mesa-vulkan-drivers"), "{}", text(&drawn.stderr));
        return;
    }
    let mut pictures = Vec::new();
    for extra in
        [&[][..], &["--frames", "9"], &["--click", "110,160"], &["--color-by", "face", "--edges", "--wireframe"]]
    {
        let args = [&["view", CUBE], &window[..], extra].concat();
        let output = trimtess(&args);
        assert_eq!(output.status.code(), Some(0), "{args:?}: {}", text(&output.stderr));
        let bytes = fs::read(&picture).unwrap();
        assert_eq!(&bytes[16..24], &[0, 0, 1, 224, 0, 0, 1, 64], "width and height");
        pictures.push(bytes);
    }
    pictures.dedup();
    assert_eq!(pictures.len(), 4);
    refuses(&[&["view", "no.step"], &window[..]].concat(), 1, "no.step");
    refuses(&[&["view", "builtin:none"], &window[..]].concat(), 2, "none");
    fs::remove_file(&picture).unwrap();
    refuses(&[&["view", CUBE, "--max-triangles", "10"], &window[..]].concat(), 1, "the limit is 10");
    assert!(!picture.exists());
}

#[cfg(all(feature = "view", target_os = "linux"))]
#[test]
fn without_a_display_view_suggests_a_screenshot() {
    let mut command = command(CHECKOUT, &["view", CUBE]);
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("--screenshot"), "{}", text(&output.stderr));
}

/// A smaller screen-space error needs more triangles, a more distant camera fewer.
#[cfg(feature = "wgpu")]
#[test]
fn screen_space_error_controls_the_number_of_triangles() {
    let picture = folder("pixels").join("cylinder.png");
    let triangles = |args: &[&str]| {
        let base = ["render", "builtin:torus", "-o", picture.to_str().unwrap(), "--size", "320x240", "--json"];
        let output = trimtess(&[&base[..], args].concat());
        (output.status.code() == Some(0)).then(|| json(&output.stdout)["triangles"].as_u64().unwrap())
    };
    let Some(usual) = triangles(&[]) else { return };
    let counted = |args: &[&str]| triangles(args).unwrap_or_else(|| panic!("{args:?} drew nothing"));
    assert!(counted(&["--deviation-px", "0.05"]) > 2 * usual);
    assert!(counted(&["--camera", "45,35,8", "--deviation-px", "0.05"]) < counted(&["--deviation-px", "0.05"]));
    assert!(counted(&["--size-px", "4"]) > 2 * usual);
}

#[test]
fn open_edges_are_counted_after_sewing() {
    let open = |args: &[&str]| json(&trimtess(&[&["info", "--json"], args].concat()).stdout)["open_edges"].clone();
    // Rim and lid, and the ends of handle and spout.
    assert_eq!(open(&["builtin:teapot"]), 16);
    assert_eq!(open(&["builtin:box"]), 0);
    let apart = open(&["builtin:trimmed-teapot", "--border-tolerance", "0"]).as_u64().unwrap();
    assert!(open(&["builtin:trimmed-teapot"]).as_u64().unwrap() + 100 < apart, "{apart}");
}

#[test]
fn supplemental_geometry_is_read_on_demand() {
    let text = fs::read_to_string(Path::new(CHECKOUT).join(FORMS)).unwrap();
    let ball = "#95=SPHERICAL_SURFACE('',#20,9.)";
    let path = folder("supplemental").join("ball.step");
    fs::write(&path, text.replace("#95=PLANE('',#20)", ball)).unwrap();
    let file = path.to_str().unwrap();
    let faces = |args: &[&str]| json(&trimtess(args).stdout)["faces"].as_u64().unwrap();
    assert_eq!(faces(&["info", file, "--json"]), 3);
    assert_eq!(faces(&["info", file, "--json", "--supplemental"]), 4);
}

/// Paths of the keys in a value: `a.b` of an object in an object, `a[].b` of an object in a list.
fn keys(value: &Value, at: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(fields) if at != "surfaces" => {
            let dot = if at.is_empty() { "" } else { "." };
            fields.iter().for_each(|(key, value)| keys(value, &format!("{at}{dot}{key}"), found));
        }
        Value::Array(list) if list.iter().any(Value::is_object) => {
            list.iter().for_each(|value| keys(value, &format!("{at}[]"), found));
        }
        _ => drop(found.insert(at.to_owned())),
    }
}

#[test]
fn docs_have_every_key_of_the_reports_and_no_other() {
    let text = fs::read_to_string(Path::new(CHECKOUT).join("docs/report.md")).unwrap();
    let (of_mesh, of_info) = text.split_once("## `info`").unwrap();
    let documented = |text: &str| -> BTreeSet<String> {
        let rows = text.lines().filter_map(|line| line.strip_prefix("| `")?.split(" | ").next());
        rows.flat_map(|names| names.split(['`', ',']))
            .map(str::trim)
            .filter(|n| !n.is_empty())
            .map(Into::into)
            .collect()
    };
    let file = "tests/data/nist_ctc05.step";
    let out = folder("keys").join("x.glb");
    let mut mesh = BTreeSet::new();
    keys(
        &json(&trimtess(&["tessellate", file, "-o", name(&out), "--check", "--levels", "1", "--json"]).stdout),
        "",
        &mut mesh,
    );
    // This file has no such faces.
    assert!(mesh.remove("fills"));
    mesh.extend(["face_id", "slivers", "rewound"].map(|key| format!("fills[].{key}")));
    assert_eq!(mesh, documented(of_mesh));
    let mut info = BTreeSet::new();
    keys(&json(&trimtess(&["info", file, "--json"]).stdout), "", &mut info);
    assert_eq!(info, documented(of_info));
}
