//! A hand-made frame: one box part of six faces, one batch per face, placed by given transforms.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(dead_code, reason = "not every test program uses all of it")]

use glam::{DAffine3, DVec3, Vec2, Vec3};
use trimtess::mesh::{
    Batch, EdgeLine, MemorySink, MeshSink, Origin, Scene, SceneInstance, ScenePart, SinkError, TileMesh,
};
use trimtess::model::{EdgeId, FaceId, PartId, TileId};

/// Corner of the box: bit 0 is x, bit 1 y, bit 2 z.
fn corner(size: DVec3, bits: usize) -> DVec3 {
    DVec3::new((bits & 1) as f64, (bits >> 1 & 1) as f64, (bits >> 2 & 1) as f64) * size
}

/// Corners of each face, counter-clockwise from outside, and its normal.
pub(crate) const FACES: [([usize; 4], Vec3); 6] = [
    ([0, 2, 3, 1], Vec3::NEG_Z),
    ([4, 5, 7, 6], Vec3::Z),
    ([0, 1, 5, 4], Vec3::NEG_Y),
    ([2, 6, 7, 3], Vec3::Y),
    ([0, 4, 6, 2], Vec3::NEG_X),
    ([1, 3, 7, 5], Vec3::X),
];

pub(crate) fn box_batches(size: DVec3) -> Vec<Batch> {
    let face = |(index, (corners, normal)): (usize, &([usize; 4], Vec3))| Batch {
        part: PartId(0),
        face: FaceId::new(index),
        tile: TileId(index as u32),
        worker: 0,
        mesh: TileMesh {
            positions: corners.map(|bits| corner(size, bits)).to_vec(),
            normals: vec![*normal; 4],
            uvs: vec![Vec2::ZERO; 4],
            lines: Default::default(),
            origins: (0..4).map(|k| Origin::Border { border: 0, k }).collect(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        },
    };
    FACES.iter().enumerate().map(face).collect()
}

/// The box, placed once per transform, with the four edges along z.
pub(crate) fn box_frame(size: DVec3, transforms: &[DAffine3]) -> MemorySink {
    let part = ScenePart {
        name: "box".into(),
        face_colours: vec![Some([1.0, 0.0, 0.0, 1.0]), None, None, None, None, None],
        centre: 0.5 * size,
        radius: 0.5 * size.length(),
        ..ScenePart::default()
    };
    let instances = transforms.iter().enumerate().map(|(index, &transform)| SceneInstance {
        name: format!("box {index}").into(),
        first_face: 6 * index as u32,
        ..SceneInstance::new(PartId(0), transform)
    });
    let line = |k: usize| EdgeLine {
        part: PartId(0),
        edge: EdgeId::new(k),
        points: vec![corner(size, k), corner(size, k + 4)],
    };
    let scene = Scene { name: "test".into(), parts: vec![part], instances: instances.collect() };
    MemorySink::of(scene, box_batches(size), (0..4).map(line).collect())
}

/// Sends a frame through a sink, without the final `end`.
pub(crate) fn play(frame: &MemorySink, sink: &mut dyn MeshSink) -> Result<(), SinkError> {
    sink.begin(&frame.scene)?;
    for batch in &frame.batches {
        sink.batch(&mut batch.clone())?;
    }
    for line in &frame.edge_lines {
        sink.edge_line(line.clone())?;
    }
    Ok(())
}
