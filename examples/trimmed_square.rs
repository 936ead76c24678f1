//! A square with a round hole, stated by hand, to a mesh file: `cargo run --release --example trimmed_square -- OUT.obj`

use std::path::PathBuf;
use std::sync::Arc;
use trimtess::frame::{self, Tolerance};
use trimtess::model::{
    Coedge, CurveKind, Edge, EdgeId, Face, Frame3, Instance, Loop, Model, NurbsCurve3, Part, PartId, Shell, ShellKind,
    Surface, VertexId,
};
use trimtess::{glam::DAffine3, glam::DVec3, mesh, out, parallel, prepare};

/// An edge over the whole domain of its curve.
fn edge(curve: NurbsCurve3, kind: CurveKind, start: usize, end: usize) -> Edge {
    let range = curve.domain();
    Edge { curve, range, start: VertexId::new(start), end: VertexId::new(end), kind, entity: 0 }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = PathBuf::from(std::env::args_os().nth(1).ok_or("usage: trimmed_square OUT.obj")?);

    // Four corners in order, then the point where the circle starts and ends. Millimetres.
    let corners = [(-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let vertices = [&corners[..], &[DVec3::new(6.0, 0.0, 0.0)]].concat();
    let side = |k: usize| edge(NurbsCurve3::line(corners[k], corners[(k + 1) % 4]), CurveKind::Line, k, (k + 1) % 4);
    let circle = NurbsCurve3::arc(&Frame3::WORLD, 6.0, 6.0, 0.0, std::f64::consts::TAU);
    let edges = vec![side(0), side(1), side(2), side(3), edge(circle, CurveKind::Circle, 4, 4)];

    // The kept side lies left of every loop: the outer one runs counter-clockwise, the hole against its edge.
    let coedge = |k: usize, reversed: bool| Coedge { edge: EdgeId::new(k), reversed, pcurve: None };
    let outer = Loop::Edges((0..4).map(|k| coedge(k, false)).collect());
    let hole = Loop::Edges(vec![coedge(4, true)]);
    let face = Face {
        surface: Surface::Plane { frame: Frame3::WORLD },
        loops: vec![outer, hole],
        reversed: false,
        shell: 0,
        colour: None,
        name: "square with a hole".into(),
        entity: 0,
    };
    let shells = vec![Shell { kind: ShellKind::Open, entity: 0 }];
    let part = Part { name: "square".into(), vertices, edges, faces: vec![face], shells, colour: None };
    let instance = Instance { part: PartId(0), transform: DAffine3::IDENTITY, colour: None, name: String::new() };
    let model = Model { parts: vec![part], instances: vec![instance], millimetres_per_unit: 1.0, ..Model::default() };

    let prepared = Arc::new(prepare::prepare(model, &prepare::PrepareOptions::DEFAULT));
    let plan = frame::plan(&prepared, &Tolerance { chord: 0.01, angle: 0.2, max_edge: None });
    let mut frame = mesh::MemorySink::default();
    parallel::serial(&prepared, &plan, false, &mut frame)?;
    let facts = mesh::check_scene(&frame).total;
    let exact = 400.0 - 36.0 * std::f64::consts::PI;
    assert!((facts.area - exact).abs() < 0.01 * 12.0 * std::f64::consts::PI, "area {}, exact {exact}", facts.area);
    println!("{facts}");
    out::save(&frame, &path, out::Format::of_path(&path)?)?;
    Ok(())
}
