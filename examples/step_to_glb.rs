//! A STEP file to a mesh file.
//!
//! Run with `cargo run --release --features glb --example step_to_glb -- IN.step OUT.glb`.

use std::path::PathBuf;
use std::sync::Arc;
use trimtess::frame::{self, Tolerance};
use trimtess::import::step::{self, StepOptions};
use trimtess::mesh::{MemorySink, MeshLists};
use trimtess::out::{Format, save};
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::{PrepareOptions, prepare};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let paths: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let [input, output] = &paths[..] else { return Err("usage: step_to_glb IN.step OUT.glb".into()) };

    let model = step::read_file(input, &StepOptions::default())?;
    let prepared = Arc::new(prepare(model, &PrepareOptions::DEFAULT)?);
    for diagnostic in &prepared.diagnostics {
        eprintln!("{:?}: #{}: {}", diagnostic.severity, diagnostic.entity, diagnostic.kind);
    }

    // A thousandth of the model's diagonal, and at least 18 segments per full circle.
    let tolerance = Tolerance::relative(1e-3, prepared.diagonal);
    let plan = frame::plan(&prepared, &tolerance).require_full()?;
    let mut session = Session::start(Arc::clone(&prepared), &SessionOptions::DEFAULT)?;
    let mut mesh = MemorySink::reading(MeshLists::NONE);
    let report = session.frame(plan, &mut mesh)?;
    let rounding = save(&mesh, output, Format::of_path(output)?)?;

    assert!(rounding.triangles > 0, "no triangles in {}", input.display());
    println!("{} triangles, made in {:?}", rounding.triangles, report.made_in);
    println!("rounding to the file's numbers moves vertices by up to {:.1e} mm", rounding.moved);
    Ok(())
}
