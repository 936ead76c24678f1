//! The tiles of a model drawn by pipelines of the example's own: a material, a shadow map seen from the light, and a
//! floor and a block in the same depth buffer. Asserts what it shows.
//!
//! Run with `cargo run --release --features wgpu --example own_material -- out.png [FILE.step]`.

mod material;
mod stage;

use glam::{DMat4, DVec3};
use material::{COLOUR, DEPTH, Material, SAMPLES, SHADOW, SIZE, texture};
use stage::Stage;
use std::error::Error;
use std::sync::Arc;
use trimtess::import::step::{StepOptions, read_file};
use trimtess::out::wgpu::{Image, LiveScene, RenderOptions, SceneInPass};
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::{PrepareOptions, prepare};
use trimtess::view::{Camera, View, ViewPoint};
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{LoadOp, Operations, StoreOp, TextureUsages, TextureView};

const BACKGROUND: wgpu::Color = wgpu::Color { r: 0.780, g: 0.800, b: 0.826, a: 0.0 };
/// The alpha of pixels that show nothing but the model, the block, or the floor.
const MODEL: u8 = 255;
const BLOCK: u8 = 102;
const FLOOR: u8 = 51;

fn main() -> Result<(), Box<dyn Error>> {
    let mut told = std::env::args().skip(1);
    let path = told.next().unwrap_or_else(|| "own_material.png".into());
    let model = match told.next() {
        Some(file) => read_file(file.as_ref(), &StepOptions::default())?,
        None => trimtess_models::by_name("brake-assembly").ok_or("no brake")?,
    };
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: adapter.features() & wgpu::Features::INDIRECT_FIRST_INSTANCE,
        required_limits: wgpu::Limits::downlevel_defaults(),
        ..wgpu::DeviceDescriptor::default()
    }))?;

    // The light's view is one of the frame's: what it sees and the camera does not is there, to cast shadows.
    let prepared = Arc::new(prepare(model, &PrepareOptions::DEFAULT)?);
    let bounds = prepared.bounds.ok_or("nothing is placed")?;
    let from = ViewPoint { yaw: 35.0, pitch: 24.0, distance: 1.25 };
    let camera = from.fit(bounds, f64::from(SIZE.0) / f64::from(SIZE.1));
    let stage = Stage::of(bounds, &camera);
    let light = stage.light(bounds);
    let view = |camera, size| View { camera, size, deviation_px: 0.35, size_px: None, angle: 0.5 };
    let mut session = Session::start(prepared, &SessionOptions::DEFAULT)?;
    let mut scene = LiveScene::new(&device, &queue, COLOUR)?;
    session.view(&[view(camera, SIZE), view(light, (SHADOW, SHADOW))], &mut scene)?;

    let material = Material::new(&device, &scene);
    // The near plane is before the block.
    let options =
        RenderOptions::DEFAULT.with_size(SIZE).with_camera(Some(camera)).with_other_bounds(Some(stage.bounds()));
    let of_light = options.with_size((SHADOW, SHADOW)).with_camera(Some(light));
    let (seen, from_light) = (scene.upload(0, &options)?, scene.upload(1, &of_light)?);
    let corners = stage.corners(camera.eye);
    let others = device.create_buffer_init(&BufferInitDescriptor {
        label: Some("floor and block"),
        contents: &bytes(corners.as_flattened().as_flattened()),
        usage: wgpu::BufferUsages::VERTEX,
    });
    queue.write_buffer(&material.light, 0, &bytes(&light_numbers(&stage, &light, &seen, &from_light)));

    let target = texture(&device, SIZE, COLOUR, 1, TextureUsages::COPY_SRC);
    let drawing = Drawing { scene: &scene, material: &material, others: &others, count: corners.len() as u32 };
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    drawing.shadow_map(&mut encoder, &from_light);
    drawing.picture(&mut encoder, &seen, &device, &whole(&target));
    queue.submit([encoder.finish()]);
    let image = Image::read(&device, &queue, &target)?;
    let mut opaque = image.clone();
    opaque.pixels.chunks_exact_mut(4).for_each(|pixel| pixel[3] = 255);
    opaque.write_png(path.as_ref())?;
    println!("{path}");

    let (of_picture, of_map) = (seen.stats(), from_light.stats());
    println!("{} triangles of {} tiles in {} draws", of_picture.triangles, of_picture.tiles, of_picture.draws);
    println!("{} of {} in {} into the shadow map", of_map.triangles, of_map.tiles, of_map.draws);
    check_model(&mut scene, &options, &image)?;
    check_shadow(&mut scene, &of_light, &image, &stage, [&camera, &light])?;
    Ok(())
}

/// `Light` in the shader.
fn light_numbers(stage: &Stage, light: &Camera, seen: &SceneInPass, from_light: &SceneInPass) -> [f32; 24] {
    // Both matrices start at their eye. The difference is taken in double precision.
    let clip = from_light.clip() * DMat4::from_translation(seen.eye() - from_light.eye());
    let texel = 2.0 / (f64::from(SHADOW) * from_light.clip().row(0).truncate().length());
    let floor = stage.middle - seen.eye();
    let mut numbers = [0.0; 24];
    numbers[..16].copy_from_slice(&clip.as_mat4().to_cols_array());
    numbers[16..20].copy_from_slice(&light.axes()[2].extend(texel).as_vec4().to_array());
    numbers[20..].copy_from_slice(&floor.extend(stage.floor()).as_vec4().to_array());
    numbers
}

fn bytes(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

fn whole(texture: &wgpu::Texture) -> TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// The scene, and what the example draws with it.
struct Drawing<'a> {
    scene: &'a LiveScene,
    material: &'a Material,
    others: &'a wgpu::Buffer,
    count: u32,
}

impl Drawing<'_> {
    fn shadow_map(&self, encoder: &mut wgpu::CommandEncoder, from_light: &SceneInPass) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            depth_stencil_attachment: Some(cleared(&self.material.shadow_map, StoreOp::Store)),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.material.model_shadow);
        pass.set_bind_group(1, &self.material.lit, &[]);
        self.scene.draw_surfaces(&mut pass, from_light);
        // Bind group 0 is still the scene's.
        pass.set_pipeline(&self.material.other_shadow);
        pass.set_vertex_buffer(0, self.others.slice(..));
        // The floor is behind all that it could shade.
        pass.draw(6..self.count, 0..1);
    }

    fn picture(&self, encoder: &mut wgpu::CommandEncoder, seen: &SceneInPass, device: &wgpu::Device, to: &TextureView) {
        let samples = |format| whole(&texture(device, SIZE, format, SAMPLES, TextureUsages::empty()));
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &samples(COLOUR),
                depth_slice: None,
                resolve_target: Some(to),
                ops: Operations { load: LoadOp::Clear(BACKGROUND), store: StoreOp::Discard },
            })],
            depth_stencil_attachment: Some(cleared(&samples(DEPTH), StoreOp::Discard)),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.material.model);
        pass.set_bind_group(1, &self.material.lit, &[]);
        pass.set_bind_group(2, &self.material.shadowed, &[]);
        self.scene.draw_surfaces(&mut pass, seen);
        pass.set_pipeline(&self.material.other);
        pass.set_vertex_buffer(0, self.others.slice(..));
        pass.draw(0..self.count, 0..1);
    }
}

/// Depth is reversed: 0 is farthest.
fn cleared(view: &TextureView, store: StoreOp) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    let depth_ops = Some(Operations { load: LoadOp::Clear(0.0), store });
    wgpu::RenderPassDepthStencilAttachment { view, depth_ops, stencil_ops: None }
}

/// Where the scene has a surface, the picture shows the model, or the block before it.
fn check_model(scene: &mut LiveScene, options: &RenderOptions, image: &Image) -> Result<(), Box<dyn Error>> {
    let (mut model, mut block, mut mixed) = (0, 0, 0);
    for (x, y) in (16..SIZE.0).step_by(48).flat_map(|x| (16..SIZE.1).step_by(48).map(move |y| (x, y))) {
        let what = image.pixel(x, y).ok_or("a pixel")?[3];
        match scene.pick((x, y), 0, options)? {
            None => assert_ne!(what, MODEL, "{x}, {y}: there is no model"),
            Some(_) if what == MODEL => model += 1,
            Some(_) if what == BLOCK => block += 1,
            Some(_) => mixed += 1,
        }
    }
    println!("{model} pixels of the model, {block} with the block before it, {mixed} of edges");
    assert!(model > 20 && block > 0 && mixed <= model / 8);
    Ok(())
}

/// The floor is darker where the model is before the light.
fn check_shadow(
    scene: &mut LiveScene,
    of_light: &RenderOptions,
    image: &Image,
    stage: &Stage,
    [camera, light]: [&Camera; 2],
) -> Result<(), Box<dyn Error>> {
    let mut means = [(0.0, 0); 2];
    for (i, j) in (-8..=8).flat_map(|i| (-8..=8).map(move |j| (i, j))) {
        let point = stage.middle + 0.2 * stage.reach * DVec3::new(f64::from(i), f64::from(j), 0.0);
        let at = camera.pixel_of(point, [SIZE.0, SIZE.1].map(f64::from)).filter(|at| at[0] >= 0.0 && at[1] >= 0.0);
        let Some([r, g, b, FLOOR]) = at.and_then(|[x, y]| image.pixel(x as u32, y as u32)) else { continue };
        let Some([x, y]) = light.pixel_of(point, [f64::from(SHADOW); 2]) else { continue };
        let shadow = x >= 0.0 && y >= 0.0 && scene.pick((x as u32, y as u32), 1, of_light)?.is_some();
        let mean = &mut means[usize::from(shadow)];
        *mean = (mean.0 + f64::from(r) + f64::from(g) + f64::from(b), mean.1 + 3);
    }
    let [lit, dark] = means.map(|(sum, count)| sum / f64::from(count));
    println!("the floor is {lit:.0} of 255 in the light, {dark:.0} in the shadow");
    assert!(dark < 0.8 * lit);
    Ok(())
}
