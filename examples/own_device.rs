//! A graphics device of your own, a session, and a scene that stays on the device: a camera moves around a model, and
//! each frame sends only what changed.
//!
//! Run with `cargo run --release --features wgpu --example own_device -- out.png`.

use std::error::Error;
use std::sync::Arc;
use trimtess::out::wgpu::{ColourBy, Image, LiveScene, RenderOptions};
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare;
use trimtess::view::{View, ViewPoint};

const SIZE: (u32, u32) = (960, 720);

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "own_device.png".into());

    // Any device that the program draws with. This feature saves draw calls; no other is required.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: adapter.features() & wgpu::Features::INDIRECT_FIRST_INSTANCE,
        ..wgpu::DeviceDescriptor::default()
    }))?;
    // Any target: here a texture, otherwise a window's.
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: SIZE.0, height: SIZE.1, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });

    let model = trimtess_models::by_name("trimmed-teapot").ok_or("no teapot")?;
    let prepared = Arc::new(prepare::prepare(model, &prepare::PrepareOptions::DEFAULT)?);
    let [low, high] = prepared.bounds.ok_or("nothing is placed")?;
    let mut session = Session::start(Arc::clone(&prepared), &SessionOptions::DEFAULT)?;
    let mut scene = LiveScene::new(&device, &queue, target.format())?;

    for step in 0..=40 {
        let from = ViewPoint { yaw: 30.0 + f64::from(step), pitch: 30.0, distance: 1.0 };
        let camera = from.fit([low, high], f64::from(SIZE.0) / f64::from(SIZE.1));
        let view = View { camera, size: SIZE, deviation_px: 0.5, size_px: None, angle: 0.5 };
        let report = session.view(&[view], &mut scene)?;
        assert!(step == 0 || report.tiles < prepared.tiles().count(), "a small step changes few tiles");
        let options = RenderOptions::DEFAULT.with_size(SIZE).with_camera(Some(camera)).with_colour_by(ColourBy::Rate);
        let drew = scene.draw(&target.create_view(&wgpu::TextureViewDescriptor::default()), 0, &options)?;
        if step % 10 == 0 {
            println!(
                "{:5} tiles made, {:8} bytes sent, {:6} triangles drawn, {} bytes held",
                report.tiles,
                scene.uploaded(),
                drew.triangles,
                scene.held().total()
            );
        }
    }

    Image::read(&device, &queue, &target)?.write_png(path.as_ref())?;
    println!("{path}");
    Ok(())
}
