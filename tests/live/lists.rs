//! Lists of instances that differ: what is uploaded follows them.

use super::{Changes, live_bytes, options, renderer, scene, send, whole};
use trimtess::mesh::MeshSink;
use trimtess::out::wgpu::ColourBy;

#[test]
fn an_instance_that_changes_has_its_own_records_written_again() {
    let Some(renderer) = renderer() else { return };
    let (mut scene, mut live) = (scene(), renderer.live());
    send(&whole(&scene, 2), &mut live);
    let view = options(ColourBy::Model);
    live_bytes(renderer, &mut live, &view);
    let mut bytes = |scene: &_, rows: &[usize]| {
        Changes { instances: Some(rows.to_vec()), ..Changes::default() }.play(scene, &mut live).unwrap();
        live.end().unwrap();
        live_bytes(renderer, &mut live, &view)
    };
    // The draws, and no records.
    let none = bytes(&scene, &[]);
    scene.instances[1].colour = None;
    // 20 bytes for each of 64 tiles.
    assert_eq!(bytes(&scene, &[1]), none + 64 * 20);
    scene.instances[1].transform.translation.z += 1.0;
    assert_eq!(bytes(&scene, &[1]), none, "placements go with each picture");
}
