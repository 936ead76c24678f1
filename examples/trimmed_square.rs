//! A square with a round hole, stated by hand, to a mesh file.
//!
//! Run with `cargo run --release --example trimmed_square -- OUT.obj`.

use std::{f64::consts::PI, path::PathBuf, sync::Arc};
use trimtess::frame::{self, Tolerance};
use trimtess::glam::DVec3;
use trimtess::model::{Frame3, Loop, Model, PartBuilder, ShellKind, Surface};
use trimtess::{mesh, out, parallel, prepare};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = PathBuf::from(std::env::args_os().nth(1).ok_or("usage: trimmed_square OUT.obj")?);

    // Millimetres. The kept side lies left of every loop: the outer one runs counter-clockwise, the hole is traversed
    // in reverse.
    let mut part = PartBuilder::new("square with a hole");
    let corners = [(-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0)];
    let outer = part.polygon(&corners.map(|(x, y)| DVec3::new(x, y, 0.0)));
    let hole = vec![part.circle(&Frame3::WORLD, 6.0).against()];
    let shell = part.plain_shell(ShellKind::Open);
    part.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, vec![Loop::Edges(outer), Loop::Edges(hole)], false);
    let model = Model::from(part.finish()?);

    let prepared = Arc::new(prepare::prepare(model, &prepare::PrepareOptions::DEFAULT)?);
    let plan = frame::plan(&prepared, &Tolerance { chord: 0.01, angle: 0.2, max_edge: None }).require_full()?;
    let mut frame = mesh::MemorySink::default();
    parallel::serial(&prepared, &Arc::new(plan), false, &mut frame)?;

    let (area, exact) = (mesh::check_scene(&frame).total.area, 400.0 - 36.0 * PI);
    assert!((area - exact).abs() < 0.01 * 12.0 * PI, "the chord tolerance holds: area {area}, exact {exact}");
    out::save(&frame, &path, out::Format::of_path(&path)?)?;
    Ok(())
}
