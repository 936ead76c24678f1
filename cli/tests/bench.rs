//! The contract of `trimtess bench`: fields of its JSON, recorded paths, complete timelines.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../../tests/folders/mod.rs"]
mod folders;
mod run;

use folders::folder;
use run::{command, told};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Output;

/// Runs `trimtess bench` in a folder.
fn bench(folder: &Path, args: &[&str]) -> Output {
    command(folder, &["bench"]).args(args).output().unwrap()
}

/// Runs `trimtess bench` in a folder and returns its JSON.
fn measured(folder: &Path, args: &[&str]) -> Value {
    let output = bench(folder, &[args, &["--json", "bench.json"]].concat());
    assert_eq!(output.status.code(), Some(0), "{args:?}: {}", told(&output));
    assert!(!output.stdout.is_empty());
    read(&folder.join("bench.json"))
}

fn read(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn number(value: &Value, field: &str) -> f64 {
    value.pointer(field).and_then(Value::as_f64).unwrap_or_else(|| panic!("no {field} in {value}"))
}

#[test]
fn each_number_of_workers_is_measured() {
    let folder = folder("teapot");
    let args = ["builtin:teapot", "--path", "glu", "--frames", "8", "--workers", "1,3", "--coherence", "off"];
    let report = measured(&folder, &[&args[..], &["--replay=2,32", "--plot", "bench.svg"]].concat());
    assert_eq!((report["model"].as_str(), report["tiles"].as_u64()), (Some("builtin:teapot"), Some(32)));
    assert!(number(&report, "/machine/cores") >= 1.0 && report["machine"]["processor"].is_string());
    let runs = report["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 2);
    for (run, workers) in runs.iter().zip([1, 3]) {
        assert_eq!((run["path"].as_str(), run["coherence"].as_str()), (Some("glu"), Some("off")));
        assert_eq!((run["workers"].as_u64(), run["frames"].as_u64()), (Some(workers), Some(8)));
        for field in
            ["/frames_per_s", "/triangles_mean", "/bytes_uploaded_mean", "/bytes_held", "/first_ms", "/seconds"]
        {
            assert!(number(run, field) > 0.0, "{field} of {run}");
        }
        for stage in ["", "/plan", "/make", "/commit"] {
            let at = |quantile| {
                let field =
                    if stage.is_empty() { format!("/{quantile}_ms") } else { format!("/stages_ms{stage}/{quantile}") };
                number(run, &field)
            };
            assert!(at("p50") > 0.0 && at("p50") <= at("p99"), "{stage} of {run}");
        }
        assert_eq!(run["stages_ms"]["workers"].as_array().unwrap().len() as u64, workers);
        assert_eq!(number(run, "/tiles_remade_mean"), 32.0);
        let efficiency = number(run, "/efficiency");
        assert!(efficiency > 0.0 && efficiency <= 1.0 + 1e-12 && (workers > 1 || efficiency == 1.0), "{run}");
    }
    // The mesh is the same for any number of workers.
    for field in ["/triangles_mean", "/bytes_uploaded_mean", "/bytes_held"] {
        assert_eq!(number(&runs[0], field), number(&runs[1], field));
    }
    assert_eq!(report["replay"].as_array().unwrap().len(), 1);
    let rows = report["replay"][0]["rows"].as_array().unwrap();
    assert_eq!(rows.iter().map(|row| row["workers"].as_u64().unwrap()).collect::<Vec<_>>(), [2, 32]);
    for row in rows {
        for policy in ["windows", "epoch", "dynamic"] {
            let efficiency = number(row, &format!("/efficiency/{policy}"));
            assert!(efficiency > 0.0 && efficiency <= 1.0 + 1e-12, "{row}");
        }
    }
    assert!(fs::read_to_string(folder.join("bench.svg")).unwrap().ends_with("</svg>\n"));
}

#[test]
fn coherence_saves_tiles_and_bytes_and_is_simulated() {
    let args = ["builtin:brake-hub", "--frames", "40", "--workers", "2", "--coherence", "off,plan,on", "--replay=8"];
    let report = measured(&folder("coherence"), &args);
    let [off, plan, on] = &report["runs"].as_array().unwrap()[..] else { panic!("{report}") };
    let of = |run: &Value| ["/tiles_remade_mean", "/bytes_uploaded_mean"].map(|field| number(run, field));
    let ([tiles, _], [drawn, bytes], [changed, sent]) = (of(off), of(plan), of(on));
    assert_eq!(tiles, number(&report, "/tiles"));
    assert!(drawn <= tiles && changed < 0.5 * drawn && sent < 0.5 * bytes, "{report}");
    // Both hold the same mesh.
    assert_eq!(number(plan, "/triangles_mean"), number(on, "/triangles_mean"));
    let replays = report["replay"].as_array().unwrap();
    let told = |k: usize| (replays[k]["coherence"].as_str().unwrap(), replays[k]["frames"].as_u64().unwrap());
    assert_eq!((replays.len(), told(0), told(1)), (2, ("off", 20), ("on", 39)));
}

#[test]
fn saved_paths_can_be_flown_again() {
    let folder = folder("path");
    let picture = ["--size", "640x480", "--deviation-px", "1.5", "--angle", "20"];
    let args = ["builtin:torus", "--path", "walk", "--frames", "5", "--coherence", "off", "--save-path"];
    let flown = measured(&folder, &[&args[..], &["walk.json"], &picture[..]].concat());
    let views = read(&folder.join("walk.json"));
    assert_eq!(views.as_array().unwrap().len(), 5);
    assert_eq!((&views[0]["size"][0], number(&views[0], "/deviation_px")), (&640.into(), 1.5));

    let recorded = ["builtin:torus", "--path", "walk.json", "--coherence", "off"];
    let again = measured(&folder, &[&recorded[..], &["--save-path", "again.json"]].concat());
    assert_eq!(views, read(&folder.join("again.json")));
    let triangles = |report: &Value| number(report, "/runs/0/triangles_mean");
    assert_eq!(triangles(&flown), triangles(&again));
    assert_eq!(again["runs"][0]["path"].as_str(), Some("walk.json"));
    assert_eq!((&again["size"], &again["deviation_px"]), (&flown["size"], &flown["deviation_px"]));

    let finer = measured(&folder, &[&recorded[..], &["--deviation-px", "0.1", "--frames", "7"]].concat());
    assert!(triangles(&finer) > triangles(&flown));
    assert_eq!(finer["runs"][0]["frames"].as_u64(), Some(7));
}

#[test]
fn bad_paths_are_rejected() {
    let folder = folder("no_path");
    fs::write(folder.join("empty.json"), "[]").unwrap();
    fs::write(folder.join("other.json"), "[{\"size\": [640, 480]}]").unwrap();
    fs::write(folder.join("unknown.json"), "[{\"eye\": [0, 0, 0]}]").unwrap();
    for (path, why) in [
        ("spiral", "orbit, zoom, walk, glu"),
        ("empty.json", "no views"),
        ("other.json", "missing field"),
        ("unknown.json", "unknown field"),
    ] {
        let output = bench(&folder, &["builtin:torus", "--path", path]);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{told}");
        assert!(told.contains(path) && told.contains(why), "{path}: {told}");
    }
    let output = bench(&folder, &["builtin:torus", "--frames", "0"]);
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn timelines_contain_every_stage_of_every_frame() {
    let folder = folder("trace");
    let args = ["builtin:washer", "--frames", "3", "--workers", "2", "--coherence", "off", "--trace", "trace.json"];
    let report = measured(&folder, &args);
    let events = read(&folder.join("trace.json"));
    let count = |name: &str| {
        let is = |event: &&Value| event["name"].as_str() == Some(name) && event["ph"].as_str() == Some("B");
        events.as_array().unwrap().iter().filter(is).count() as u64
    };
    assert_eq!([count("frame"), count("plan"), count("commit"), count("worker")], [3, 3, 3, 6]);
    assert_eq!(count("tile"), 3 * report["tiles"].as_u64().unwrap());
}

#[test]
fn glu_scene_and_tile_costs_print_their_tables() {
    let folder = folder("other");
    let told = |args: &[&str]| {
        let output = bench(&folder, args);
        assert_eq!(output.status.code(), Some(0), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let points = told(&["glu-scene", "points"]);
    assert!(points.starts_with("512 32\n"), "{}", points.lines().next().unwrap_or_default());
    assert_eq!(points.lines().count(), 1 + 512 + 32);
    let table = told(&["glu-scene", "4"]);
    assert!(table.lines().last().unwrap().starts_with("  4.00 | "), "{table}");
    let path = told(&["glu-scene", "path", "4"]);
    assert_eq!(path.lines().count(), 2, "rebuilt, and coherent: {path}");
    let costs = told(&["tile-costs", "builtin:washer", "builtin:brake-hub"]);
    assert!(costs.lines().count() == 4 && costs.contains("builtin:brake-hub"), "{costs}");

    for wrong in [&["tile-costs"][..], &["glu-scene", "path"], &["glu-scene", "-1"], &[]] {
        assert_eq!(bench(&folder, wrong).status.code(), Some(2), "{wrong:?}");
    }
    // 16 numbers per triangle. The first is a patch, and patch 32 does not exist.
    fs::write(folder.join("triangles"), [32.0_f32; 16].map(f32::to_le_bytes).as_flattened()).unwrap();
    assert_eq!(bench(&folder, &["glu-scene", "triangles", "triangles"]).status.code(), Some(1));
}

#[test]
fn stages_are_measured_on_more_and_more_threads() {
    let folder = folder("scaling");
    let args = ["builtin:brake-hub", "--scaling", "--workers", "1,2,3", "--frames", "3", "--copies", "2"];
    let report = measured(&folder, &[&args[..], &["--plot", "scaling.svg"]].concat());
    assert_eq!(report["threads"], serde_json::json!([1, 2, 3]));
    let stages = report["stages"].as_array().unwrap();
    for name in ["read", "prepare", "cold frame", "coherent frame"] {
        let stage = stages.iter().find(|stage| stage["name"] == name).unwrap_or_else(|| panic!("no {name}"));
        for field in ["ms", "speedup"] {
            let all: Vec<f64> = stage[field].as_array().unwrap().iter().filter_map(Value::as_f64).collect();
            assert!(all.len() == 3 && all.iter().all(|x| *x > 0.0), "{name}: {stage}");
        }
        assert!(stage["serial_fraction"][0].is_null() && stage["serial_fraction"][2].is_f64(), "{name}: {stage}");
    }
    let replayed = report["replayed"].as_array().unwrap();
    for (frames, coherence) in replayed.iter().zip(["cold", "coherent"]) {
        assert_eq!(frames["coherence"], coherence);
        let all = |field: &str| frames[field].as_array().unwrap().iter().filter_map(Value::as_f64).collect::<Vec<_>>();
        let (whole, alone, work) = (all("frame_ms"), all("not_divided_ms"), all("work_ms"));
        assert_eq!((whole.len(), all("speedup")[0], all("measured_ms").len()), (6, 1.0, 2));
        assert!(whole.iter().zip(&alone).all(|(whole, alone)| alone < whole), "{frames}");
        // Steps are cut for several threads: these are done before the sum of their work. How much earlier is a matter
        // of what else the machine does.
        assert!(whole.iter().zip(&work).skip(1).all(|(whole, work)| whole < work), "{frames}");
        let of_step = |name: &str| {
            let step = frames["steps"].as_array().unwrap().iter().find(|step| step["name"] == name);
            number(step.unwrap_or_else(|| panic!("no step {name}")), "/ms/0")
        };
        let steps = ["lattices", "tessellants", "tiles", "commit", "rest"];
        assert!(steps.iter().map(|name| of_step(name)).sum::<f64>() <= whole[0] * (1.0 + 1e-9), "{frames}");
    }
    let hashes = report["hashes"].as_array().unwrap();
    assert!(hashes.len() == 3 && hashes.iter().all(|row| *row == hashes[0]), "{hashes:?}");
    assert_ne!(hashes[0][0], hashes[0][1], "a cold frame has tiles that no view draws");
    let weak = report["weak"].as_array().unwrap();
    assert_eq!(number(&weak[2], "/faces"), 3.0 * number(&weak[0], "/faces"));
    assert_eq!(number(&report, "/faces"), 2.0 * number(&weak[0], "/faces"));
    assert!(fs::read_to_string(folder.join("scaling.svg")).unwrap().contains("<polyline"));
    let refused = bench(&folder, &["builtin:teapot", "--scaling", "--replay"]);
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn the_hash_of_a_flight_is_that_of_its_path_for_any_number_of_workers() {
    let folder = folder("hash");
    let hash = |path: &str, workers: &str| {
        let args = ["builtin:brake-assembly", "--hash", "--frames", "6", "--path", path, "--workers", workers];
        let output = bench(&folder, &args);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let orbit = hash("orbit", "1");
    let words: Vec<&str> = orbit.split_whitespace().collect();
    assert!(matches!(words[..], ["triangles", count, "hash", hash] if count != "0" && hash.len() == 16), "{orbit}");
    assert_eq!(orbit, hash("orbit", "3"));
    assert_ne!(orbit, hash("zoom", "1"));
    assert_eq!(bench(&folder, &["builtin:teapot", "--hash", "--json", "x.json"]).status.code(), Some(2));
}
