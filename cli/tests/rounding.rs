//! What the numbers of a file format cost is counted, told or refused, and measured in the written file.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../../tests/folders/mod.rs"]
mod folders;
mod run;

use folders::folder;
use run::{CHECKOUT, CUBE, command, told};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

/// A cube of 10 mm and a cylinder next to it, moved along each axis by `offset` metres.
fn moved(folder: &Path, offset: &str) -> PathBuf {
    let text = fs::read_to_string(Path::new(CHECKOUT).join(CUBE)).unwrap();
    let by: f64 = offset.parse().unwrap();
    let moved = |row: &str| {
        let (head, rest) = row.split_once("CARTESIAN_POINT( '', ( ")?;
        let numbers = rest.strip_suffix(" ) );")?.split(", ").map(|number| number.trim().parse::<f64>());
        let numbers: Vec<String> =
            numbers.map(|number| Some(format!("{:?}", number.ok()? + by))).collect::<Option<_>>()?;
        Some(format!("{head}CARTESIAN_POINT( '', ( {} ) );", numbers.join(", ")))
    };
    let rows: Vec<String> = text.lines().map(|row| moved(row).unwrap_or_else(|| row.to_owned())).collect();
    let file = folder.join(format!("cube_{offset}.step"));
    fs::write(&file, rows.join("\n")).unwrap();
    file
}

fn tessellate(file: &Path, mesh: &Path, more: &[&str]) -> Output {
    let mut command = command(CHECKOUT, &["tessellate", "--check", "--json", "-o"]);
    command.arg(mesh).arg(file).args(more).output().unwrap()
}

fn report(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", told(output)))
}

#[test]
fn a_part_far_from_the_origin_is_refused_by_formats_in_single_precision_and_recentred_on_demand() {
    let folder = folder("far");
    for offset in ["0.001", "1.0", "100.0", "10000.0"] {
        let file = moved(&folder, offset);
        for format in ["stl", "obj", "ply", "glb"] {
            let mesh = folder.join(format!("cube.{format}"));
            let _ = fs::remove_file(&mesh);
            let output = tessellate(&file, &mesh, &["--chord", "0.01"]);
            let far = format == "stl" && offset.parse::<f64>().unwrap() > 10.0;
            if far {
                let told = told(&output);
                assert_eq!(output.status.code(), Some(1), "{offset} {format}: {told}");
                assert!(told.contains("--recenter") && told.contains("1.000e-3 mm are allowed"), "{told}");
                assert!(!mesh.exists());
                let output = tessellate(&file, &mesh, &["--chord", "0.01", "--recenter"]);
                let result = report(&output);
                assert_eq!(output.status.code(), Some(0), "{result}");
                let x = result["offset_mm"][0].as_f64().unwrap();
                assert!((x - 1e3 * offset.parse::<f64>().unwrap()).abs() < 50.0, "{result}");
                assert!(result["read_back"]["moved_mm"].as_f64().unwrap() < 1e-5, "{result}");
                continue;
            }
            let result = report(&output);
            assert_eq!(output.status.code(), Some(0), "{offset} {format}: {result}");
            assert_eq!(result["read_back"]["triangles"], result["triangles"], "{result}");
            assert_eq!(result["read_back"]["unbalanced_edges"], 0, "{result}");
            assert_eq!(result["collapsed_triangles"], 0, "{result}");
            let moved = result["read_back"]["moved_mm"].as_f64().unwrap();
            assert!(moved <= 1e-3, "{offset} {format}: {result}");
        }
    }
}

#[test]
fn triangles_that_collapse_are_counted_and_the_count_is_that_of_the_file() {
    let folder = folder("collapse");
    let mesh = folder.join("cube.stl");
    // At ten kilometres numbers are a millimetre apart, and the edges of the cylinder's facets shorter.
    let file = moved(&folder, "10000.0");
    let output = tessellate(&file, &mesh, &["--chord", "11", "--angle", "1"]);
    let result = report(&output);
    let triangles = u64::from(u32::from_le_bytes(fs::read(&mesh).unwrap()[80..84].try_into().unwrap()));
    assert!(result["collapsed_triangles"].as_u64().unwrap() > 100, "{result}");
    assert_eq!((&result["triangles"], &result["read_back"]["unbalanced_edges"]), (&triangles.into(), &0.into()));
    let told = |entry: &Value| entry["code"] == "triangles-rounded-away";
    assert!(result["diagnostics"].as_array().unwrap().iter().any(told), "{result}");
}

#[test]
fn levels_of_detail_are_made_checked_and_told_one_by_one() {
    let folder = folder("levels");
    let file = Path::new(CHECKOUT).join(CUBE);
    let mesh = folder.join("cube.glb");
    for more in [&[][..], &["--recenter"], &["--glb", "instanced,quantized,compressed"]] {
        let output = tessellate(&file, &mesh, &[&["--chord", "0.001", "--angle", "5", "--levels", "3"], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let result = report(&output);
        let levels = result["levels"].as_array().unwrap();
        assert_eq!(levels.len(), 3, "{result}");
        let mut before = result["triangles"].as_u64().unwrap();
        for (level, chord) in levels.iter().zip([0.004, 0.016, 0.064]) {
            let triangles = level["triangles"].as_u64().unwrap();
            assert!(triangles < before && level["read_back"]["triangles"] == triangles, "{result}");
            assert_eq!((&level["chord_mm"], &level["unbalanced_edges"]), (&chord.into(), &0.into()), "{result}");
            assert_eq!(level["read_back"]["unbalanced_edges"], 0, "{result}");
            assert!(level["p999_deviation_over_tolerance"].as_f64().unwrap() <= 1.0, "{result}");
            before = triangles;
        }
    }
    // A file without faces has no extent, and its levels no triangles.
    let none = folder.join("none.step");
    let text = fs::read_to_string(&file).unwrap();
    let (head, _) = text.split_once("DATA;").unwrap();
    fs::write(&none, format!("{head}DATA;\n#1=CARTESIAN_POINT('',(0.,0.,0.));\nENDSEC;\nEND-ISO-10303-21;\n")).unwrap();
    let output = tessellate(&none, &mesh, &["--levels", "2"]);
    assert_eq!(output.status.code(), Some(3), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(report(&output)["levels"].as_array().unwrap().len(), 2);
    let output = tessellate(&file, &folder.join("cube.ply"), &["--levels", "1"]);
    let told = told(&output);
    assert!(output.status.code() == Some(2) && told.contains("--levels is for .glb files"), "{told}");
}

#[test]
fn the_shared_part_a_hundred_metres_away_is_not_written_as_stl_with_holes() {
    let file = Path::new(CHECKOUT).join("../shared/attack/stl_far_1e5.step");
    if !file.exists() {
        eprintln!("skipped: {} is absent", file.display());
        return;
    }
    let mesh = folder("shared").join("x.stl");
    assert_eq!(tessellate(&file, &mesh, &[]).status.code(), Some(1));
    assert!(!mesh.exists());
    let result = report(&tessellate(&file, &mesh, &["--recenter"]));
    assert!(result["triangles"].as_u64().unwrap() > 680 && result["collapsed_triangles"] == 0, "{result}");
}
