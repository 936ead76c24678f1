//! Draw calls and milliseconds of a picture, with a small shader: draws from a buffer, tiles merged per part, and a
//! call per tile. The median of all pictures.
//!
//! `cargo bench --features wgpu --bench draws -- FILE [PICTURES]`

use std::error::Error;
use std::num::NonZeroU32;
use std::sync::Arc;
use std::time::{Duration, Instant};
use trimtess::import::step::{StepOptions, read};
use trimtess::out::wgpu::{DrawCall, LiveScene, RenderOptions, SceneInPass};
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::{PrepareOptions, Prepared, prepare};
use trimtess::view::{View, ViewPoint};

const SIZE: (u32, u32) = (1920, 1080);
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// A head light.
const SHADER: &str = "
struct Out {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) colour: vec3<f32>,
};

@vertex
fn vertex(in: SceneVertex) -> Out {
    let it = scene_surface(in);
    return Out(it.clip, it.position, it.normal, it.colour);
}

@fragment
fn fragment(in: Out) -> @location(0) vec4<f32> {
    return vec4(in.colour * abs(dot(normalize(in.normal), scene_to_eye(in.position))), 1.0);
}
";

fn main() -> Result<(), Box<dyn Error>> {
    // Cargo passes `--bench`.
    let mut told = std::env::args().skip(1).filter(|word| word != "--bench");
    let path = told.next().unwrap_or_else(|| "tests/data/nist_ctc05.step".into());
    let pictures = told.next().map_or(Ok(NonZeroU32::MIN.saturating_add(29)), |word| word.parse())?.get();
    let model = read(&std::fs::read(&path)?, &StepOptions::default())?;
    let prepared = Arc::new(prepare(model, &PrepareOptions::DEFAULT)?);

    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    let (name, placed) = (adapter.get_info().name, &prepared.scene);
    println!("{path}, {} parts in {} instances, {SIZE:?} pixels, {name}\n", placed.parts.len(), placed.instances.len());
    println!("| | draw calls | tiles | triangles | ms to encode | ms a picture |\n|---|---|---|---|---|---|");
    let limits = wgpu::Limits::downlevel_webgl2_defaults().using_resolution(adapter.limits());
    let plain = wgpu::DeviceDescriptor { required_limits: limits, ..wgpu::DeviceDescriptor::default() };
    let wide = wgpu::DeviceDescriptor {
        required_features: adapter.features() & wgpu::Features::INDIRECT_FIRST_INSTANCE,
        ..wgpu::DeviceDescriptor::default()
    };
    for (name, descriptor, each) in
        [("from a buffer", &wide, false), ("merged", &plain, false), ("a call per tile", &wide, true)]
    {
        if name != "merged" && descriptor.required_features.is_empty() {
            println!("| {name} | this adapter draws nothing from buffers | | | | |");
            continue;
        }
        let (device, queue) = pollster::block_on(adapter.request_device(descriptor))?;
        measure(name, &device, &queue, &prepared, each, pictures)?;
    }
    Ok(())
}

/// Prints the row of a device. `each`: the draws of a buffer one by one.
fn measure(
    name: &str,
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    prepared: &Arc<Prepared>,
    each: bool,
    pictures: u32,
) -> Result<(), Box<dyn Error>> {
    let mut scene = LiveScene::new(device, queue, FORMAT)?;
    let bounds = prepared.bounds.ok_or("nothing is placed")?;
    let camera = ViewPoint::ISO.fit(bounds, f64::from(SIZE.0) / f64::from(SIZE.1));
    let mut session = Session::start(Arc::clone(prepared), &SessionOptions::DEFAULT)?;
    session.view(&[View { camera, size: SIZE, deviation_px: 0.5, size_px: None, angle: 0.5 }], &mut scene)?;
    let [colour, depth, resolved] = [(FORMAT, 4), (LiveScene::DEPTH, 4), (FORMAT, 1)].map(|(format, sample_count)| {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: SIZE.0, height: SIZE.1, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    });
    let pipeline = pipeline(device, &scene);
    let options = RenderOptions::DEFAULT.with_size(SIZE).with_camera(Some(camera));
    let mut times = Vec::new();
    let mut calls = 0;
    let mut stats = scene.upload(0, &options)?.stats();
    for _ in 0..pictures {
        let start = Instant::now();
        let drawn = scene.upload(0, &options)?;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &colour,
                depth_slice: None,
                resolve_target: Some(&resolved),
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::WHITE), store: wgpu::StoreOp::Discard },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(&pipeline);
        if each {
            calls = draw_each(&mut pass, &scene, &drawn);
        } else {
            calls = drawn.stats().draws;
            scene.draw_surfaces(&mut pass, &drawn);
        }
        drop(pass);
        let commands = encoder.finish();
        let encoded = start.elapsed();
        queue.submit([commands]);
        device.poll(wgpu::PollType::wait_indefinitely())?;
        times.push((encoded, start.elapsed()));
        stats = drawn.stats();
    }
    let median = |of: &dyn Fn(&(Duration, Duration)) -> Duration| {
        let mut all: Vec<f64> = times.iter().map(|time| 1e3 * of(time).as_secs_f64()).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    let (encoded, drawn) = (median(&|time| time.0), median(&|time| time.1));
    println!("| {name} | {calls} | {} | {} | {encoded:.2} | {drawn:.1} |", stats.tiles, stats.triangles);
    Ok(())
}

fn pipeline(device: &wgpu::Device, scene: &LiveScene) -> wgpu::RenderPipeline {
    let input = scene.surface_input();
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl([input.wgsl, SHADER].concat().into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(&input.bind_group)],
        immediate_size: 0,
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &input.vertex_buffers,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: LiveScene::DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState { count: 4, ..wgpu::MultisampleState::default() },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(FORMAT.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// A call per tile of each instance. Returns their number.
fn draw_each(pass: &mut wgpu::RenderPass<'_>, scene: &LiveScene, drawn: &SceneInPass) -> usize {
    let mut calls = 0;
    pass.set_bind_group(0, drawn.bind_group(), &[]);
    for draw in scene.surface_draws(drawn) {
        pass.set_vertex_buffer(0, draw.vertices[0].slice(..));
        pass.set_vertex_buffer(1, draw.vertices[1].slice(..));
        pass.set_index_buffer(draw.indices.slice(..), draw.format);
        if let DrawCall::Indirect { draws, offset, count } = draw.call {
            for number in 0..u64::from(count) {
                pass.draw_indexed_indirect(draws, offset + 20 * number);
                calls += 1;
            }
        }
    }
    calls
}
