//! Scenes that stay on the graphics device: frames of changes, pages, picking. Skipped where there is no adapter.
#![cfg(feature = "wgpu")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../adapter/mod.rs"]
mod adapter;
mod attributes;
mod failures;
mod lists;
#[path = "../out_fixture/mod.rs"]
mod out_fixture;
mod own_pipelines;
mod section;
#[path = "../sequence/random.rs"]
mod random;
mod update;

use adapter::renderer;
use glam::{DAffine3, DVec3, Vec2, Vec3};
use out_fixture::{box_frame, play};
use own_pipelines::{OURS, pass_over};
use random::SplitMix;
use trimtess::mesh::{
    Batch, DrawnTiles, EdgeLine, MemorySink, MeshSink, Origin, Scene, SceneChanges, SceneInstance, ScenePart,
    SinkError, TileMesh,
};
use trimtess::model::{EdgeId, FaceId, InstanceId, PartId, TileId};
use trimtess::out::wgpu::{ColourBy, DrawCall, Image, LiveScene, RenderOptions, Renderer, SurfaceDraw};
use trimtess::view::{Camera, Projection, ViewPoint};

const SIZE: (u32, u32) = (240, 180);
const SIDE: u32 = 8;

/// A tile of a flat sheet of `SIDE` by `SIDE` squares, with `cells` by `cells` cells; empty if `cells` is 0.
fn square(part: u32, tile: u32, cells: u32) -> Batch {
    let (x, y) = (f64::from(tile % SIDE), f64::from(tile / SIDE));
    let lines = || 0..if cells == 0 { 0 } else { cells + 1 };
    let at = |k: u32| f64::from(k) / f64::from(cells);
    let corners = (0..cells).flat_map(|j| (0..cells).map(move |i| j * (cells + 1) + i));
    let positions: Vec<DVec3> = lines()
        .flat_map(|j| lines().map(move |i| (i, j)))
        .map(|(i, j)| DVec3::new(x + at(i), y + at(j), 0.0))
        .collect();
    Batch {
        part: PartId(part),
        face: FaceId(tile / 4),
        tile: TileId(tile),
        worker: tile % 3,
        mesh: TileMesh {
            normals: vec![Vec3::Z; positions.len()],
            uvs: positions.iter().map(|p| Vec2::new((p.x - x) as f32, (p.y - y) as f32)).collect(),
            lines: [0, 1].map(|_| lines().map(|k| at(k) as f32).collect()),
            origins: lines().flat_map(|j| lines().map(move |i| Origin::Lattice { i, j })).collect(),
            triangles: corners.flat_map(|a| [[a, a + 1, a + cells + 2], [a, a + cells + 2, a + cells + 1]]).collect(),
            positions,
        },
    }
}

/// The polyline of the outline's edge `edge`, with so many segments.
fn outline(part: u32, edge: u32, segments: u32) -> EdgeLine {
    let side = f64::from(SIDE);
    let corner = |k: u32| [DVec3::ZERO, DVec3::X * side, DVec3::new(side, side, 0.0), DVec3::Y * side][k as usize % 4];
    let point = |k: u32| corner(edge).lerp(corner(edge + 1), f64::from(k) / f64::from(segments));
    EdgeLine { part: PartId(part), edge: EdgeId(edge), points: (0..=segments).map(point).collect() }
}

/// Two sheets. The second is placed twice, once mirrored.
fn scene() -> Scene {
    let side = f64::from(SIDE);
    let part = ScenePart {
        face_colours: vec![Some([0.8, 0.3, 0.2, 1.0]); 16],
        centre: DVec3::new(0.5, 0.5, 0.0) * side,
        radius: side,
        ..ScenePart::default()
    };
    let instance = |part: u32, offset: DVec3, scale: DVec3| SceneInstance {
        colour: (part == 0).then_some([0.3, 0.5, 0.8, 1.0]),
        first_face: 16 * part,
        ..SceneInstance::new(PartId(part), DAffine3::from_translation(offset) * DAffine3::from_scale(scale))
    };
    let instances = vec![
        instance(1, DVec3::new(9.0, 0.0, 0.0), DVec3::ONE),
        instance(0, DVec3::ZERO, DVec3::ONE),
        instance(1, DVec3::new(8.0, 9.0, 0.0), DVec3::new(-1.0, 1.0, 1.0)),
    ];
    Scene { name: "sheets".into(), parts: vec![part.clone(), part], instances }
}

/// The renderer, the two sheets, and an empty scene on the device. `None` without an adapter.
fn set_up() -> Option<(&'static Renderer, Scene, LiveScene)> {
    renderer().map(|renderer| (renderer, scene(), renderer.live()))
}

fn whole(scene: &Scene, cells: u32) -> MemorySink {
    let batches = (0..2).flat_map(|part| (0..SIDE * SIDE).map(move |tile| square(part, tile, cells))).collect();
    let lines = (0..2).flat_map(|part| (0..4).map(move |edge| outline(part, edge, 3))).collect();
    MemorySink::of(scene.clone(), batches, lines)
}

/// The contents of a frame of changes.
#[derive(Default)]
struct Changes {
    batches: Vec<Batch>,
    lines: Vec<EdgeLine>,
    /// Rows of instances that differ. `None` if any may.
    instances: Option<Vec<usize>>,
}

impl Changes {
    fn random(draw: &mut SplitMix, tiles: u64) -> Self {
        let mut changes = Self::default();
        for part in 0..2 {
            for tile in 0..SIDE * SIDE {
                if draw.below(u64::from(SIDE * SIDE)) < tiles {
                    changes.batches.push(square(part, tile, draw.below(7) as u32));
                }
            }
            changes.lines.push(outline(part, draw.below(4) as u32, 1 + draw.below(9) as u32));
        }
        changes
    }

    fn play(&self, scene: &Scene, sink: &mut dyn MeshSink) -> Result<(), SinkError> {
        let changed = |rows| SceneChanges {
            changed: rows,
            first_instance: scene.instances.len(),
            first_part: scene.parts.len(),
            ..SceneChanges::default()
        };
        sink.begin_changes(scene, &self.instances.as_deref().map_or_else(SceneChanges::default, changed))?;
        for batch in &self.batches {
            sink.batch(&mut batch.clone())?;
        }
        for line in &self.lines {
            sink.edge_line(line.clone())?;
        }
        Ok(())
    }
}

fn options(colour_by: ColourBy) -> RenderOptions {
    let camera = "10,60".parse::<ViewPoint>().unwrap();
    let points = [DVec3::ZERO, DVec3::new(17.0, 0.0, 0.0), DVec3::new(0.0, 17.0, 0.0), DVec3::new(17.0, 17.0, 0.0)];
    let camera = Some(camera.fit(points, f64::from(SIZE.0) / f64::from(SIZE.1)));
    RenderOptions::DEFAULT.with_size(SIZE).with_camera(camera).with_colour_by(colour_by)
}

fn picture(renderer: &Renderer, live: &mut LiveScene, options: &RenderOptions) -> Image {
    renderer.picture(live, 0, options).unwrap().0
}

fn send(frame: &MemorySink, scene: &mut LiveScene) {
    play(frame, scene).unwrap();
    scene.end().unwrap();
}

#[test]
fn frames_of_changes_draw_the_same_as_whole_frames() {
    let Some((renderer, mut scene, mut live)) = set_up() else { return };
    let mut memory = whole(&scene, 2);
    send(&memory, &mut live);
    let mut draw = SplitMix(7);
    let mut pictures = Vec::new();
    for frame in 0..24 {
        let by = ColourBy::ALL[frame % ColourBy::ALL.len()];
        let options = options(by).with_wireframe(frame % 3 == 0).with_edges(frame % 2 == 0).with_backfaces(true);
        let incremental = picture(renderer, &mut live, &options);
        let from_scratch = renderer.render(&memory, &options).unwrap();
        assert!(incremental == from_scratch, "frame {frame} by {by:?}");
        pictures.push(incremental);
        let mut changes = Changes { instances: Some(Vec::new()), ..Changes::random(&mut draw, 12) };
        if frame % 5 == 4 {
            scene.instances[0].transform.translation.z += 0.5;
            scene.instances[1].visible = frame % 10 == 4;
            scene.instances[2].colour = Some([0.2, 0.9, 0.1 * (frame % 7) as f32, 1.0]);
            changes.instances = (frame % 3 > 0).then(|| vec![0, 1, 2]);
        }
        changes.play(&scene, &mut live).unwrap();
        live.end().unwrap();
        changes.play(&scene, &mut memory).unwrap();
        memory.end().unwrap();
    }
    pictures.dedup();
    assert_eq!(pictures.len(), 24, "every frame changes the picture");
}

#[test]
fn only_what_changed_is_sent() {
    let Some((renderer, scene, mut live)) = set_up() else { return };
    send(&whole(&scene, 2), &mut live);
    // 16 bytes for each of 9 vertices and 2 for each of 24 corners.
    assert_eq!(live.uploaded(), 2 * 64 * (9 * 16 + 8 * 6));
    let view = options(ColourBy::Part);
    let first = live_bytes(renderer, &mut live, &view);
    assert_eq!(
        live_bytes(renderer, &mut live, &view),
        first - records_and_draws(3 * 64) - 3 * 16,
        "the same again: only placements, nothing of records, draws and instances"
    );
    let changes = Changes { batches: vec![square(0, 3, 4), square(1, 5, 0)], ..Changes::default() };
    changes.play(&scene, &mut live).unwrap();
    live.end().unwrap();
    assert_eq!(live.uploaded(), 25 * 16 + 32 * 6);
    assert_eq!(picture(renderer, &mut live, &view).width, SIZE.0);
    // 16 bytes for each of 4 points of 4 edges of 2 parts, once they are drawn, and only if they changed.
    let plain = live_bytes(renderer, &mut live, &view);
    let with_edges = view.with_edges(true);
    assert_eq!(live_bytes(renderer, &mut live, &with_edges), plain + 2 * 4 * 4 * 16);
    assert_eq!(live_bytes(renderer, &mut live, &with_edges), plain);
}

fn live_bytes(renderer: &Renderer, live: &mut LiveScene, view: &RenderOptions) -> u64 {
    renderer.picture(live, 0, view).unwrap().1.bytes
}

/// Size of the records and draws of so many tiles, bytes.
fn records_and_draws(tiles: u64) -> u64 {
    tiles * (20 + 20)
}

#[test]
fn a_frame_that_is_not_ended_changes_nothing() {
    let Some((renderer, scene, mut live)) = set_up() else { return };
    let view = options(ColourBy::Tile);
    assert!(live.begin_changes(&scene, &SceneChanges::default()).is_err(), "there is no frame to change yet");
    assert!(live.batch(&mut square(0, 0, 1)).is_err() && live.end().is_err());
    send(&whole(&scene, 2), &mut live);
    let shown = picture(renderer, &mut live, &view);
    let held = live.held();
    Changes::random(&mut SplitMix(3), 30).play(&scene, &mut live).unwrap();
    assert!(picture(renderer, &mut live, &view) == shown, "before the frame ends");
    live.abort();
    assert!(picture(renderer, &mut live, &view) == shown);
    assert!(live.begin_changes(&scene, &SceneChanges::default()).is_err(), "the sender does not know what is shown");
    play(&whole(&scene, 5), &mut live).unwrap();
    live.abort();
    assert!(picture(renderer, &mut live, &view) == shown);
    send(&MemorySink::of(scene, vec![square(0, 9, 1)], Vec::new()), &mut live);
    assert!(picture(renderer, &mut live, &view) != shown);
    assert!(live.held().total() <= 2 * held.total());
}

#[test]
fn memory_stays_flat() {
    let Some((renderer, scene, mut live)) = set_up() else { return };
    send(&whole(&scene, 6), &mut live);
    let view = options(ColourBy::Rate).with_edges(true);
    let mut draw = SplitMix(11);
    let mut held = Vec::new();
    for frame in 0..200 {
        if frame % 50 == 49 {
            send(&whole(&scene, 6), &mut live);
        } else {
            Changes::random(&mut draw, 16).play(&scene, &mut live).unwrap();
            live.end().unwrap();
        }
        if frame % 20 == 0 {
            picture(renderer, &mut live, &view);
            held.push(live.held().total());
        }
    }
    assert!(held.iter().all(|&bytes| bytes == held[0]), "{held:?}");
}

#[test]
fn pages_are_added_and_taken_back() {
    let Some((renderer, scene, mut live)) = set_up() else { return };
    let view = options(ColourBy::Part);
    send(&whole(&scene, 1), &mut live);
    let coarse = picture(renderer, &mut live, &view);
    let held = live.held();
    send(&whole(&scene, 70), &mut live);
    let full = live.held();
    assert!(full.pages > held.pages + 2 && full.vertices >= 2 * 64 * 71 * 71 * 16, "{full:?}");
    let fine = picture(renderer, &mut live, &view);
    let off = coarse.pixels.iter().zip(&fine.pixels).filter(|(a, b)| a.abs_diff(**b) > 2).count();
    assert!(off < 20, "the sheet is flat, whatever its triangles: {off} bytes differ");
    // One tile of more than 65 536 vertices: indices of four bytes.
    let changes = Changes { batches: vec![square(0, 0, 300)], ..Changes::default() };
    changes.play(&scene, &mut live).unwrap();
    live.end().unwrap();
    let wide = picture(renderer, &mut live, &view);
    let off = coarse.pixels.iter().zip(&wide.pixels).filter(|(a, b)| a.abs_diff(**b) > 2).count();
    assert!(off < 20, "{off} bytes differ");
    send(&whole(&scene, 1), &mut live);
    assert!(live.held().total() < full.total() / 2, "{:?} after {full:?}", live.held());
}

#[test]
fn tiles_outside_the_drawn_set_are_not_drawn() {
    let Some((renderer, scene, mut live)) = set_up() else { return };
    let frame = whole(&scene, 2);
    let by = options(ColourBy::Tile);
    let mut drawn = DrawnTiles::default();
    drawn.reset(2);
    for (view, instance) in [(0, 1), (1, 0), (1, 2)] {
        drawn.push(view, instance, 0, &[u64::MAX]); // part 0 is the second instance
    }
    play(&frame, &mut live).unwrap();
    live.drawn(&drawn, &DrawnTiles::NONE).unwrap();
    live.end().unwrap();
    let pictures = [0, 1].map(|view| renderer.picture(&mut live, view, &by).unwrap().0);
    let all = renderer.picture(&mut live, usize::MAX, &by).unwrap().0;
    let only = |part: u32| {
        let batches = frame.batches.iter().filter(|batch| batch.part.0 == part).cloned().collect();
        renderer.render(&MemorySink::of(scene.clone(), batches, Vec::new()), &by).unwrap()
    };
    assert!(pictures[0] == only(0) && pictures[1] == only(1) && all == renderer.render(&frame, &by).unwrap());
    let mut kept = frame;
    kept.drawn = drawn;
    assert!(renderer.render(&kept, &by).unwrap() == pictures[0], "the sink in memory shows the same");
}

fn pixel_of(camera: &Camera, point: DVec3) -> (u32, u32) {
    let [x, y] = camera.pixel_of(point, [f64::from(SIZE.0), f64::from(SIZE.1)]).unwrap();
    (x as u32, y as u32)
}

#[test]
fn picking_a_pixel_finds_what_it_shows() {
    let Some((_, scene, mut live)) = set_up() else { return };
    let view = options(ColourBy::Model);
    assert_eq!(live.pick((120, 90), 0, &view).unwrap(), None, "nothing there");
    send(&whole(&scene, 3), &mut live);
    let perspective = view.camera.unwrap();
    for camera in [perspective, perspective.orthographic()] {
        let view = view.with_camera(Some(camera));
        for (instance, placed) in scene.instances.iter().enumerate() {
            for tile in [0, 5, 27, 63] {
                let local = DVec3::new(f64::from(tile % SIDE) + 0.4, f64::from(tile / SIDE) + 0.6, 0.0);
                let point = placed.transform.transform_point3(local);
                let picked = live.pick(pixel_of(&camera, point), 0, &view).unwrap().unwrap();
                assert_eq!((picked.instance, picked.part), (InstanceId(instance as u32), placed.part));
                assert_eq!((picked.tile, picked.face, picked.triangles), (TileId(tile), FaceId(tile / 4), 18));
                assert!(picked.point.distance(point) < 0.5, "{} is not {point}", picked.point);
                assert!(picked.point.z.abs() < 1e-4, "{} is off the sheet", picked.point);
            }
        }
    }
    for outside in [(0, 0), (SIZE.0, 0), (0, SIZE.1), (u32::MAX, u32::MAX)] {
        assert_eq!(live.pick(outside, 0, &view).unwrap(), None);
    }
    // An answer that arrives after a frame with fewer instances.
    let first = scene.instances[0].transform.transform_point3(DVec3::new(0.4, 0.6, 0.0));
    let picking = live.begin_pick(pixel_of(&perspective, first), 0, &view).unwrap().unwrap();
    let fewer = Scene { instances: scene.instances[..1].to_vec(), ..scene.clone() };
    send(&whole(&fewer, 3), &mut live);
    let answer = loop {
        if let Some(answer) = live.poll_pick(&picking) {
            break answer.unwrap();
        }
    };
    assert_eq!(answer, None, "the instances are others");
    // On a box, the nearest side.
    let boxed = box_frame(DVec3::splat(20.0), &[DAffine3::from_translation(DVec3::splat(1e6))]);
    send(&boxed, &mut live);
    let middle = DVec3::splat(1e6 + 10.0);
    let projection = Projection::Perspective { fov_y: 0.5, near: 0.0 };
    let above = Camera::looking_at(middle + DVec3::Z * 80.0, middle, DVec3::Y, projection);
    let view = view.with_camera(Some(above));
    let picked = live.pick((120, 90), 0, &view).unwrap().unwrap();
    assert_eq!(picked.face, FaceId(1));
    assert!((picked.point.z - 1e6 - 20.0).abs() < 1e-4 && live.uploaded() > 0);
}

#[test]
fn only_the_highlighted_face_stands_out() {
    let Some((renderer, scene, mut live)) = set_up() else { return };
    send(&whole(&scene, 2), &mut live);
    let view = options(ColourBy::Model);
    let plain = picture(renderer, &mut live, &view);
    live.highlight(Some((InstanceId(2), FaceId(3))));
    let marked = picture(renderer, &mut live, &view);
    let camera = view.camera.unwrap();
    for (instance, placed) in scene.instances.iter().enumerate() {
        for tile in 0..SIDE * SIDE {
            let local = DVec3::new(f64::from(tile % SIDE) + 0.5, f64::from(tile / SIDE) + 0.5, 0.0);
            let (x, y) = pixel_of(&camera, placed.transform.transform_point3(local));
            let expected = instance == 2 && tile / 4 == 3;
            assert_eq!(plain.pixel(x, y) != marked.pixel(x, y), expected, "instance {instance}, tile {tile}");
        }
    }
    live.highlight(None);
    assert!(picture(renderer, &mut live, &view) == plain);
}

/// A device of the test's own. `None` if there is no adapter with these limits and features.
fn device(required_limits: wgpu::Limits, required_features: wgpu::Features) -> Option<(wgpu::Device, wgpu::Queue)> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default())).ok()?;
    let wanted = wgpu::DeviceDescriptor { required_limits, required_features, ..wgpu::DeviceDescriptor::default() };
    pollster::block_on(adapter.request_device(&wanted)).ok()
}

/// A device with the limits of WebGL 2: no arrays in buffers.
fn webgl_device(features: wgpu::Features) -> Option<(wgpu::Device, wgpu::Queue)> {
    device(wgpu::Limits::downlevel_webgl2_defaults(), features)
}

/// As [`webgl_device`], without any features.
fn plain_device() -> Option<(wgpu::Device, wgpu::Queue)> {
    webgl_device(wgpu::Features::empty())
}

/// A texture of `SIZE` with so many samples. It can be read back if that is one.
fn texture(device: &wgpu::Device, format: wgpu::TextureFormat, samples: u32) -> wgpu::Texture {
    let read = if samples == 1 { wgpu::TextureUsages::COPY_SRC } else { wgpu::TextureUsages::empty() };
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: SIZE.0, height: SIZE.1, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | read,
        view_formats: &[],
    })
}

fn all(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Bytes in which two pictures differ by more than rounding.
fn unlike(a: &Image, b: &Image) -> usize {
    a.pixels.iter().zip(&b.pixels).filter(|(a, b)| a.abs_diff(**b) > 2).count()
}

#[test]
fn a_device_without_features_draws_the_same_from_frame_to_frame() {
    let (Some(renderer), Some((device, queue))) = (renderer(), plain_device()) else { return };
    let mut live = LiveScene::new(&device, &queue, wgpu::TextureFormat::Rgba8UnormSrgb).unwrap();
    live.keep_lattice(true).unwrap();
    let mut scene = scene();
    let mut memory = whole(&scene, 3);
    send(&memory, &mut live);
    let target = texture(&device, wgpu::TextureFormat::Rgba8UnormSrgb, 1);
    let drawn = |live: &mut LiveScene, view: &RenderOptions| {
        let drew = live.draw(&all(&target), 0, view).unwrap();
        (drew, Image::read(&device, &queue, &target).unwrap())
    };
    let first = drawn(&mut live, &options(ColourBy::Face));
    assert_eq!((first.0.triangles, first.0.tiles), (3 * 64 * 18, 3 * 64));
    let mut draw = SplitMix(5);
    for frame in 0..12 {
        let by = ColourBy::ALL[frame % ColourBy::ALL.len()];
        let view = options(by).with_lattice(frame % 3 == 0).with_edges(frame % 2 == 0).with_backfaces(true);
        let (_, picture) = drawn(&mut live, &view);
        assert_eq!(unlike(&picture, &renderer.render(&memory, &view).unwrap()), 0, "frame {frame} by {by:?}");
        if frame % 4 == 3 {
            scene.instances[0].transform.translation.z += 0.5;
        }
        let changes = Changes::random(&mut draw, 12);
        changes.play(&scene, &mut live).unwrap();
        live.end().unwrap();
        changes.play(&scene, &mut memory).unwrap();
        memory.end().unwrap();
    }
    // Lines of triangles are a pixel wide and as dark where they are long.
    send(&whole(&scene, 1), &mut live);
    let view = options(ColourBy::Model);
    let (without, with) = (drawn(&mut live, &view).1, drawn(&mut live, &view.with_wireframe(true)).1);
    let same = renderer.render(&whole(&scene, 1), &view.with_wireframe(true)).unwrap();
    assert!(unlike(&without, &same) > 2 * unlike(&with, &same), "{} {}", unlike(&without, &same), unlike(&with, &same));
    let camera = view.camera.unwrap();
    for (instance, placed) in scene.instances.iter().enumerate() {
        let point = placed.transform.transform_point3(DVec3::new(3.4, 5.6, 0.0));
        let picked = live.pick(pixel_of(&camera, point), 0, &view).unwrap().unwrap();
        assert_eq!((picked.instance, picked.tile), (InstanceId(instance as u32), TileId(43)));
        assert!(picked.point.distance(point) < 0.5);
    }
}

#[test]
fn hidden_instances_are_not_drawn() {
    let (Some(renderer), Some((device, queue))) = (renderer(), plain_device()) else { return };
    let mut merged = LiveScene::new(&device, &queue, wgpu::TextureFormat::Rgba8UnormSrgb).unwrap();
    let target = texture(&device, wgpu::TextureFormat::Rgba8UnormSrgb, 1);
    let mut live = renderer.live();
    let frame = whole(&scene(), 2);
    send(&frame, &mut live);
    send(&frame, &mut merged);
    let view = options(ColourBy::Model).with_edges(true);
    let shown = picture(renderer, &mut live, &view);
    let hide = InstanceId(2);
    let mut others = scene();
    others.instances.pop();
    let expected = renderer.render(&whole(&others, 2), &view).unwrap();
    for scene in [&mut live, &mut merged] {
        scene.set_visible(hide, false);
        // Whole frames keep what is hidden.
        send(&frame, scene);
    }
    assert!(picture(renderer, &mut live, &view) == expected && expected != shown);
    merged.draw(&all(&target), 0, &view).unwrap();
    assert_eq!(unlike(&Image::read(&device, &queue, &target).unwrap(), &expected), 0);
    live.set_visible(hide, true);
    assert!(picture(renderer, &mut live, &view) == shown);
}

#[test]
fn a_scene_in_the_callers_pass_shares_its_depth() {
    let Some(renderer) = renderer() else { return };
    let (device, queue) = (renderer.device(), renderer.queue());
    let mut live = renderer.live();
    send(&whole(&scene(), 3), &mut live);
    let view = options(ColourBy::Face).with_wireframe(true).with_edges(true);
    let expected = picture(renderer, &mut live, &view);
    // Depth is reversed: what is nearer than everything hides the scene, 0 hides nothing.
    for (nearest, hidden) in [(0.0, false), (1.0, true)] {
        let drawn = live.upload(0, &view).unwrap();
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let target = pass_over(device, &mut encoder, OURS, nearest, |pass| live.encode(pass, &drawn));
        queue.submit([encoder.finish()]);
        let image = Image::read(device, queue, &target).unwrap();
        let camera = view.camera.unwrap();
        assert_eq!(drawn.eye(), camera.eye);
        for tile in 0..SIDE * SIDE {
            let point = DVec3::new(f64::from(tile % SIDE) + 0.4, f64::from(tile / SIDE) + 0.6, 0.0);
            let (x, y) = pixel_of(&camera, point);
            let pixel = if hidden { Some([0; 4]) } else { expected.pixel(x, y) };
            assert_eq!(image.pixel(x, y), pixel, "tile {tile}");
            // The matrix is the one that the scene is drawn with.
            let clip = drawn.clip() * (point - drawn.eye()).extend(1.0);
            let at = [(1.0 + clip.x / clip.w) * 0.5, (1.0 - clip.y / clip.w) * 0.5];
            assert_eq!(((at[0] * f64::from(SIZE.0)) as u32, (at[1] * f64::from(SIZE.1)) as u32), (x, y));
            assert!(clip.z / clip.w > 0.0 && clip.z / clip.w <= 1.0);
        }
    }
}

#[test]
fn lattice_lines_are_drawn_in_their_places() {
    let Some((renderer, scene, mut live)) = set_up() else { return };
    let plain = options(ColourBy::Model);
    let ruled = plain.with_lattice(true);
    send(&whole(&scene, 3), &mut live);
    let without = picture(renderer, &mut live, &plain);
    assert_eq!(picture(renderer, &mut live, &ruled), without, "no lattice lines are kept yet");
    let held = live.held().vertices;
    live.keep_lattice(true).unwrap();
    assert_eq!(live.held().vertices, held / 2 * 3);
    assert_eq!(picture(renderer, &mut live, &ruled), without, "no tile was sent again yet");
    send(&whole(&scene, 3), &mut live);
    assert_eq!(picture(renderer, &mut live, &plain), without);
    let with = picture(renderer, &mut live, &ruled);
    let placed = &scene.instances[0].transform;
    let close = plain.camera.unwrap().zoom(placed.transform_point3(DVec3::new(2.0, 1.0, 0.0)), 0.25);
    for camera in [close, close.orthographic()] {
        let view = plain.with_camera(Some(camera));
        let without = picture(renderer, &mut live, &view);
        let with_lines = picture(renderer, &mut live, &view.with_lattice(true));
        let changed = |x: f64, y: f64| {
            let (x, y) = pixel_of(&camera, placed.transform_point3(DVec3::new(x, y, 0.0)));
            with_lines.pixel(x, y) != without.pixel(x, y)
        };
        // Tiles are squares of three by three cells.
        for k in 4..8 {
            let line = f64::from(k) / 3.0;
            assert!(changed(line, 0.5) && !changed(line + 1.0 / 6.0, 0.5), "{camera:?}: {line}");
        }
        assert!(changed(1.5, 1.0 / 3.0) && changed(1.5, 2.0 / 3.0) && !changed(1.5, 0.5));
    }
    live.keep_lattice(false).unwrap();
    assert_eq!((live.held().vertices, with != without), (held, true));
}
