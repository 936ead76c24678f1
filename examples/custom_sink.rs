//! A sink of your own: measures triangles as they stream past, keeps none, and passes them on to be saved.
//!
//! Run with `cargo run --example custom_sink -- out.ply`.

use glam::{DAffine3, DVec3};
use std::error::Error;
use trimtess::mesh::{
    Batch, EdgeLine, MemorySink, MeshLists, MeshSink, Scene, SceneInstance, ScenePart, SinkError, TileMesh,
};
use trimtess::model::{FaceId, PartId, TileId};
use trimtess::out::{Format, save};

/// Sums up each part's area, then passes the frame on to another sink.
struct Measure<S> {
    areas: Vec<f64>,
    next: S,
}

impl<S: MeshSink> MeshSink for Measure<S> {
    fn reads(&self) -> MeshLists {
        self.next.reads()
    }

    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.areas = vec![0.0; scene.parts.len()];
        self.next.begin(scene)
    }

    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError> {
        for corners in &batch.mesh.triangles {
            let [a, b, c] = corners.map(|corner| batch.mesh.positions[corner as usize]);
            self.areas[batch.part.index()] += 0.5 * (b - a).cross(c - a).length();
        }
        self.next.batch(batch)
    }

    fn edge_line(&mut self, line: EdgeLine) -> Result<(), SinkError> {
        self.next.edge_line(line)
    }

    fn end(&mut self) -> Result<(), SinkError> {
        self.next.end()
    }

    fn abort(&mut self) {
        self.areas.clear();
        self.next.abort();
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "octahedron.ply".into());
    let mut sink = Measure { areas: Vec::new(), next: MemorySink::reading(MeshLists::NONE) };

    let part =
        ScenePart { name: "octahedron".into(), face_colours: vec![None; 8], radius: 10.0, ..ScenePart::default() };
    let transform = DAffine3::from_translation(DVec3::new(0.0, 0.0, 10.0));
    let instance = SceneInstance::new(PartId(0), transform);
    sink.begin(&Scene { name: "example".into(), parts: vec![part], instances: vec![instance] })?;
    for face in 0..8 {
        if let Err(error) = sink.batch(&mut octant(face)) {
            sink.abort(); // forgets the frame
            return Err(error.into());
        }
    }
    sink.end()?;
    save(&sink.next, path.as_ref(), Format::of_path(path.as_ref())?)?;
    println!("{path}: {:.3} mm²", sink.areas[0]);
    Ok(())
}

/// One face of an octahedron that reaches 10 mm along each axis. The bits of `face` are the signs of its corners.
fn octant(face: u32) -> Batch {
    let sign = |bit: u32| if face >> bit & 1 == 0 { 10.0 } else { -10.0 };
    let positions = vec![DVec3::X * sign(0), DVec3::Y * sign(1), DVec3::Z * sign(2)];
    let outward = (positions[0] + positions[1] + positions[2]).normalize().as_vec3();
    // An odd number of mirrors reverses the order of the corners.
    let triangles = vec![if face.count_ones().is_multiple_of(2) { [0, 1, 2] } else { [0, 2, 1] }];
    let mesh = TileMesh { positions, normals: vec![outward; 3], triangles, ..TileMesh::default() };
    Batch { part: PartId(0), face: FaceId(face), tile: TileId(face), worker: 0, mesh }
}
