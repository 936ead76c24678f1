//! A sink of one's own: what an engine would upload. `cargo run --release --example custom_sink`

use std::sync::Arc;
use trimtess::frame::{self, Tolerance};
use trimtess::mesh::{Batch, EdgeLine, MeshSink, Scene, SinkError};
use trimtess::model::shapes;
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::{PrepareOptions, prepare};

/// One vertex buffer and one index buffer for everything: position and normal interleaved, f32.
#[derive(Default)]
struct Buffers {
    centres: Vec<trimtess::glam::DVec3>,
    vertices: Vec<[f32; 6]>,
    indices: Vec<u32>,
}

impl MeshSink for Buffers {
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        *self = Self { centres: scene.parts.iter().map(|part| part.centre).collect(), ..Self::default() };
        Ok(())
    }

    fn batch(&mut self, batch: Batch) -> Result<(), SinkError> {
        let too_many =
            |_| SinkError { context: "index buffer".into(), cause: std::io::Error::other("over 2^32 vertices") };
        let base = u32::try_from(self.vertices.len()).map_err(too_many)?;
        // Relative to the part's centre, so that f32 is fine far from the origin; the same for all faces, so that nothing cracks.
        let centre = self.centres[batch.part.index()];
        let placed = batch.mesh.positions.iter().map(|&p| (p - centre).as_vec3());
        self.vertices.extend(placed.zip(&batch.mesh.normals).map(|(p, n)| [p.x, p.y, p.z, n.x, n.y, n.z]));
        self.indices.extend(batch.mesh.triangles.iter().flatten().map(|index| base + index));
        Ok(())
    }

    fn edge_line(&mut self, _: EdgeLine) -> Result<(), SinkError> {
        Ok(())
    }

    fn end(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    fn abort(&mut self) {
        *self = Self::default();
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = shapes::NAMES[0];
    let model = shapes::by_name(name).ok_or("no such shape")?;
    let prepared = Arc::new(prepare(model, &PrepareOptions::DEFAULT));
    let mut session = Session::start(Arc::clone(&prepared), &SessionOptions::DEFAULT.with_edge_lines(false))?;
    let mut buffers = Buffers::default();
    for relative in [1e-2, 1e-3, 1e-4] {
        let tolerance = Tolerance { chord: relative * prepared.diagonal, angle: 0.35, max_edge: None };
        let report = session.frame(&Arc::new(frame::plan(&prepared, &tolerance)), &mut buffers)?;
        assert_eq!(buffers.indices.len() as u64, 3 * report.triangles);
        println!("{name} at {relative:.0e}: {} vertices, {} triangles", buffers.vertices.len(), report.triangles);
    }
    Ok(())
}
