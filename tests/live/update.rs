//! Frames of another model: parts that go on keep their tiles on the device, under other numbers.

use super::random::SplitMix;
use super::{Changes, SIDE, options, picture, renderer, scene, send, square, whole};
use trimtess::mesh::{MeshSink, Scene, SceneChanges};
use trimtess::model::PartId;
use trimtess::out::wgpu::ColourBy;

/// The scene with its parts swapped and a third one before them, where the second was.
fn other() -> Scene {
    let mut other = scene();
    let mut new = other.parts[0].clone();
    new.face_colours[3] = None;
    other.parts.insert(1, new);
    other.instances.iter_mut().for_each(|instance| instance.part = PartId([2, 0][instance.part.index()]));
    other.instances[1].part = PartId(1);
    other
}

#[test]
fn parts_that_go_on_are_drawn_from_the_tiles_that_the_device_has() {
    let Some(renderer) = renderer() else { return };
    let mut live = renderer.live();
    assert!(
        live.begin_update(&other(), &SceneChanges::default(), &[None; 3]).is_err(),
        "there is no frame to go on from"
    );
    let mut memory = whole(&scene(), 2);
    send(&memory, &mut live);
    let shown = picture(renderer, &mut live, &options(ColourBy::Part));
    let update = |sink: &mut dyn MeshSink| {
        sink.begin_update(&other(), &SceneChanges::default(), &[Some(PartId(1)), None, Some(PartId(0))]).unwrap();
        (0..SIDE).for_each(|tile| sink.batch(&mut square(1, tile, 4)).unwrap());
    };
    update(&mut live);
    assert!(picture(renderer, &mut live, &options(ColourBy::Part)) == shown, "before the frame ends");
    live.abort();
    assert!(picture(renderer, &mut live, &options(ColourBy::Part)) == shown);
    send(&memory, &mut live);
    update(&mut live);
    live.end().unwrap();
    assert_eq!(live.uploaded(), u64::from(SIDE) * (25 * 16 + 32 * 6), "the tiles of the new part alone");
    update(&mut memory);
    memory.end().unwrap();
    for &by in ColourBy::ALL {
        let options = options(by).with_edges(true).with_backfaces(true);
        assert!(picture(renderer, &mut live, &options) == renderer.render(&memory, &options).unwrap(), "{by:?}");
    }
    assert!(picture(renderer, &mut live, &options(ColourBy::Part)) != shown);
    // Changes build on it, and parts that are not named go.
    let changes = Changes::random(&mut SplitMix(5), 20);
    for sink in [&mut live as &mut dyn MeshSink, &mut memory] {
        changes.play(&other(), sink).unwrap();
        sink.end().unwrap();
    }
    let options = options(ColourBy::Part).with_edges(true);
    assert!(picture(renderer, &mut live, &options) == renderer.render(&memory, &options).unwrap());
    for sink in [&mut live as &mut dyn MeshSink, &mut memory] {
        sink.begin_update(&other(), &SceneChanges::default(), &[None; 3]).unwrap();
        sink.end().unwrap();
    }
    assert!(memory.batches.is_empty() && memory.edge_lines.is_empty());
    assert!(picture(renderer, &mut live, &options) == renderer.render(&memory, &options).unwrap(), "nothing is left");
}
