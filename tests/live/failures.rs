//! Buffers that the device refuses: the next picture is whole.

use super::{SIZE, all, device, options, scene, send, texture, unlike, whole};
use glam::DAffine3;
use trimtess::mesh::Scene;
use trimtess::out::wgpu::{ColourBy, Image, LiveScene, RenderOptions};

/// Bytes of the largest buffer: enough for pages of tiles.
const MOST: u64 = 1 << 20;

/// A device that takes buffers of [`MOST`] bytes, with these features, which the adapter must have.
fn small_device(features: wgpu::Features) -> Option<(wgpu::Device, wgpu::Queue)> {
    let (max_buffer_size, max_storage_buffer_binding_size) = (MOST, MOST);
    let max_uniform_buffer_binding_size = 1 << 14;
    let limits = wgpu::Limits::default();
    let limits =
        wgpu::Limits { max_buffer_size, max_storage_buffer_binding_size, max_uniform_buffer_binding_size, ..limits };
    device(limits, features)
}

/// As the scene of two sheets, with many instances more of one of them.
fn crowd() -> Scene {
    let mut crowd = scene();
    let placed = crowd.instances[0].clone();
    crowd.instances.extend((0..900).map(|k| {
        let mut placed = placed.clone();
        placed.transform = DAffine3::from_translation(glam::DVec3::Z * f64::from(k));
        placed
    }));
    crowd
}

#[test]
fn pictures_after_one_that_failed_are_whole() {
    for features in [wgpu::Features::INDIRECT_FIRST_INSTANCE, wgpu::Features::empty()] {
        let Some((device, queue)) = small_device(features) else { return };
        let target = texture(&device, wgpu::TextureFormat::Rgba8UnormSrgb, 1);
        let view = options(ColourBy::Part).with_edges(true).with_wireframe(true);
        let drawn = |live: &mut LiveScene, view: &RenderOptions| {
            live.draw(&all(&target), 0, view).map(|_| Image::read(&device, &queue, &target).unwrap())
        };
        let new = || LiveScene::new(&device, &queue, wgpu::TextureFormat::Rgba8UnormSrgb).unwrap();
        let small = whole(&scene(), 2);
        // Too many records and draws where draws are read from buffers, too many indices where they are merged.
        let large = whole(&crowd(), 20);
        let mut known = new();
        send(&small, &mut known);
        let expected = drawn(&mut known, &view).unwrap();
        let middle = (SIZE.0 / 3, SIZE.1 / 2);
        let hit = known.pick(middle, 0, &view).unwrap();
        assert!(hit.is_some());

        let mut live = new();
        send(&small, &mut live);
        let before = live.upload(0, &view).unwrap();
        assert!(live.surface_draws(&before).next().is_some());
        for picks in [false, true] {
            send(&large, &mut live);
            let error = if picks {
                live.begin_pick(middle, 0, &view).map(|_| ()).unwrap_err()
            } else {
                drawn(&mut live, &view).map(|_| ()).unwrap_err()
            };
            assert!(error.to_string().contains("buffer"), "{error}");
            assert!(live.surface_draws(&before).next().is_none());
            // The scene is still too large.
            assert!(live.upload(0, &view).is_err());
            send(&small, &mut live);
            let seen = drawn(&mut live, &view).unwrap();
            assert!(unlike(&seen, &expected) == 0, "{features:?}, {picks}");
            assert_eq!(live.pick(middle, 0, &view).unwrap(), hit);
        }
    }
}
