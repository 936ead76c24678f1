//! Pipelines of the caller's own: the same pixels as the scene's, whatever the formats, on devices with and without
//! draws in buffers; several cameras in one submission.

use super::*;
use wgpu::{CompareFunction, TextureFormat};

/// A colour per part, face and instance, so that a wrong number shows.
const NUMBERS: &str = "
struct Out {
    @builtin(position) clip: vec4<f32>,
    @location(0) colour: vec3<f32>,
    @location(1) @interpolate(flat) numbers: vec4<u32>,
};

@vertex
fn vertex(in: SceneVertex) -> Out {
    let it = scene_surface(in);
    return Out(it.clip, it.colour, vec4(it.instance + 1u, it.part + 1u, it.face, u32(it.mirrored)));
}

@fragment
fn colours(in: Out) -> @location(0) vec4<f32> {
    return vec4(in.colour, 1.0);
}

@fragment
fn numbers(in: Out) -> @location(0) vec4<f32> {
    return vec4<f32>(in.numbers) / 255.0;
}
";

/// Formats of a pass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Formats {
    colour: TextureFormat,
    depth: TextureFormat,
    samples: u32,
}

/// A pipeline whose fragments are those of the entry point of [`NUMBERS`].
fn pipeline(device: &wgpu::Device, live: &LiveScene, formats: Formats, fragment: &str) -> wgpu::RenderPipeline {
    pipeline_with(device, live, formats, fragment, None)
}

/// The same with a third vertex buffer.
fn pipeline_with(
    device: &wgpu::Device,
    live: &LiveScene,
    formats: Formats,
    fragment: &str,
    third: Option<wgpu::VertexBufferLayout<'static>>,
) -> wgpu::RenderPipeline {
    let input = live.surface_input();
    let [vertices, rest] = input.vertex_buffers.clone();
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl([input.wgsl, NUMBERS].concat().into()),
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
            entry_point: Some("vertex"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[vertices, rest, third],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: formats.depth,
            depth_write_enabled: Some(true),
            depth_compare: Some(CompareFunction::Greater),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState { count: formats.samples, ..wgpu::MultisampleState::default() },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(fragment),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(formats.colour.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Runs `draw` in a pass of these formats, and returns the target that it leaves.
fn pass(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    formats: Formats,
    draw: impl FnOnce(&mut wgpu::RenderPass<'_>),
) -> wgpu::Texture {
    pass_over(device, encoder, formats, 0.0, draw)
}

/// The same with a depth that is there before.
pub(crate) fn pass_over(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    formats: Formats,
    depth_before: f32,
    draw: impl FnOnce(&mut wgpu::RenderPass<'_>),
) -> wgpu::Texture {
    let target = texture(device, formats.colour, 1);
    let samples = (formats.samples > 1).then(|| all(&texture(device, formats.colour, formats.samples)));
    let (resolved, depth) = (all(&target), all(&texture(device, formats.depth, formats.samples)));
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: samples.as_ref().unwrap_or(&resolved),
            depth_slice: None,
            resolve_target: samples.is_some().then_some(&resolved),
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &depth,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(depth_before),
                store: wgpu::StoreOp::Discard,
            }),
            stencil_ops: None,
        }),
        ..wgpu::RenderPassDescriptor::default()
    });
    draw(&mut pass);
    drop(pass);
    target
}

pub(crate) const OURS: Formats =
    Formats { colour: TextureFormat::Rgba8UnormSrgb, depth: LiveScene::DEPTH, samples: LiveScene::SAMPLES };
const OTHER: Formats = Formats { colour: TextureFormat::Rgba8Unorm, depth: TextureFormat::Depth24Plus, samples: 1 };

/// A device that reads draws from buffers, one without features that has the limits of WebGL 2, and one with the
/// limits alone.
pub(crate) fn devices() -> Vec<(wgpu::Device, wgpu::Queue)> {
    let own = renderer().map(|renderer| (renderer.device().clone(), renderer.queue().clone()));
    own.into_iter().chain(plain_device()).chain(webgl_device(wgpu::Features::INDIRECT_FIRST_INSTANCE)).collect()
}

fn begin(device: &wgpu::Device) -> wgpu::CommandEncoder {
    device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
}

#[test]
fn a_pipeline_of_the_callers_covers_the_same_pixels() {
    for (device, queue) in devices() {
        let mut live = LiveScene::new(&device, &queue, OURS.colour).unwrap();
        send(&whole(&scene(), 3), &mut live);
        let view = options(ColourBy::Face);
        let drawn = live.upload(0, &view).unwrap();
        for formats in [OURS, OTHER, Formats { samples: 4, ..OTHER }, Formats { samples: 1, ..OURS }] {
            let own = pipeline(&device, &live, formats, "colours");
            let mut encoder = begin(&device);
            let mine = pass(&device, &mut encoder, formats, |pass| {
                pass.set_pipeline(&own);
                live.draw_surfaces(pass, &drawn);
            });
            let listed = pass(&device, &mut encoder, formats, |pass| {
                pass.set_pipeline(&own);
                pass.set_bind_group(0, drawn.bind_group(), &[]);
                assert_eq!(
                    live.surface_draws(&drawn).map(|draw| call(pass, &draw)).sum::<usize>(),
                    drawn.stats().draws
                );
            });
            let theirs = (formats.samples == OURS.samples)
                .then(|| pass(&device, &mut encoder, OURS, |pass| live.encode(pass, &drawn)));
            queue.submit([encoder.finish()]);
            let read = |of: &wgpu::Texture| Image::read(&device, &queue, of).unwrap();
            let (mine, listed) = (read(&mine), read(&listed));
            assert!(mine == listed, "{formats:?}");
            let cover = |image: &Image| image.pixels.chunks(4).map(|pixel| pixel[3]).collect::<Vec<u8>>();
            let covered = cover(&mine).iter().filter(|&&alpha| alpha == 255).count();
            assert!(covered > (SIZE.0 * SIZE.1 / 4) as usize, "{formats:?}: {covered} pixels");
            if let Some(theirs) = theirs {
                assert_eq!(cover(&mine), cover(&read(&theirs)), "{formats:?}");
            }
        }
    }
}

/// Makes a call as the caller would. Returns 1.
fn call(pass: &mut wgpu::RenderPass<'_>, draw: &SurfaceDraw<'_>) -> usize {
    pass.set_vertex_buffer(0, draw.vertices[0].slice(..));
    pass.set_vertex_buffer(1, draw.vertices[1].slice(..));
    pass.set_index_buffer(draw.indices.slice(..), draw.format);
    match &draw.call {
        DrawCall::Indirect { draws, offset, count } => pass.multi_draw_indexed_indirect(draws, *offset, *count),
        DrawCall::Direct { indices, instances } => pass.draw_indexed(indices.clone(), 0, instances.clone()),
    }
    1
}

#[test]
fn vertices_know_what_they_belong_to() {
    for (device, queue) in devices() {
        let mut live = LiveScene::new(&device, &queue, OURS.colour).unwrap();
        let mut scene = scene();
        send(&whole(&scene, 2), &mut live);
        let view = options(ColourBy::Model);
        let camera = view.camera.unwrap();
        let own = pipeline(&device, &live, OTHER, "numbers");
        for _ in 0..2 {
            let drawn = live.upload(0, &view).unwrap();
            let mut encoder = begin(&device);
            let target = pass(&device, &mut encoder, OTHER, |pass| {
                pass.set_pipeline(&own);
                live.draw_surfaces(pass, &drawn);
            });
            queue.submit([encoder.finish()]);
            let image = Image::read(&device, &queue, &target).unwrap();
            for (instance, placed) in scene.instances.iter().enumerate() {
                for tile in 0..SIDE * SIDE {
                    let local = DVec3::new(f64::from(tile % SIDE) + 0.5, f64::from(tile / SIDE) + 0.5, 0.0);
                    let (x, y) = pixel_of(&camera, placed.transform.transform_point3(local));
                    let mirrored = placed.transform.matrix3.determinant() < 0.0;
                    let numbers = [instance as u32 + 1, placed.part.0 + 1, tile / 4, u32::from(mirrored)];
                    assert_eq!(image.pixel(x, y).map(|pixel| pixel.map(u32::from)), Some(numbers), "tile {tile}");
                }
            }
            // The same tiles with other instances.
            scene.instances.swap(0, 1);
            live.begin_changes(&scene, &SceneChanges::default()).unwrap();
            live.end().unwrap();
        }
    }
}

#[test]
fn cameras_of_one_submission_do_not_disturb_each_other() {
    for (device, queue) in devices() {
        let mut live = LiveScene::new(&device, &queue, OURS.colour).unwrap();
        send(&whole(&scene(), 3), &mut live);
        let above = options(ColourBy::Tile);
        let camera = above.camera.unwrap();
        let aside = above.with_camera(Some(camera.zoom(DVec3::ZERO, 0.5).orthographic()));
        let one = |live: &mut LiveScene, view: &RenderOptions| {
            let target = texture(&device, OURS.colour, 1);
            live.draw(&all(&target), 0, view).unwrap();
            Image::read(&device, &queue, &target).unwrap()
        };
        let expected = [above, aside].map(|view| one(&mut live, &view));
        let mut held = Vec::new();
        for _ in 0..5 {
            let both = [above, aside].map(|view| live.upload(0, &view).unwrap());
            let middle = pixel_of(&camera, DVec3::new(4.4, 4.4, 0.0));
            assert_eq!(live.pick(middle, 0, &above).unwrap().unwrap().tile, TileId(36), "a pick between");
            let mut encoder = begin(&device);
            let targets = [0, 1].map(|k| pass(&device, &mut encoder, OURS, |pass| live.encode(pass, &both[k])));
            queue.submit([encoder.finish()]);
            for (target, expected) in targets.iter().zip(&expected) {
                let image = Image::read(&device, &queue, target).unwrap();
                // The scene's own picture has a backdrop.
                let off = image.pixels.chunks(4).zip(expected.pixels.chunks(4)).filter(|(a, b)| a[3] == 255 && a != b);
                assert_eq!(off.count(), 0);
            }
            held.push(live.held());
        }
        assert!(held.iter().all(|bytes| *bytes == held[0]), "{held:?}");
    }
}

#[test]
fn outdated_uploads_draw_nothing() {
    for (device, queue) in devices() {
        let mut live = LiveScene::new(&device, &queue, OURS.colour).unwrap();
        send(&whole(&scene(), 40), &mut live);
        let drawn = live.upload(0, &options(ColourBy::Part).with_wireframe(true).with_edges(true)).unwrap();
        assert!(live.surface_draws(&drawn).count() > 0);
        // The pages that the upload speaks of are freed.
        send(&whole(&scene(), 1), &mut live);
        let mut encoder = begin(&device);
        let target = pass(&device, &mut encoder, OURS, |pass| {
            live.encode(pass, &drawn);
            live.draw_surfaces(pass, &drawn);
        });
        queue.submit([encoder.finish()]);
        let image = Image::read(&device, &queue, &target).unwrap();
        assert!(image.pixels.iter().all(|&byte| byte == 0));
        assert_eq!(live.surface_draws(&drawn).count(), 0);
    }
}

#[test]
fn draws_are_few() {
    for (device, queue) in devices() {
        let mut live = LiveScene::new(&device, &queue, OURS.colour).unwrap();
        send(&whole(&scene(), 2), &mut live);
        let view = options(ColourBy::Model);
        let stats = live.upload(0, &view).unwrap().stats();
        let reads_draws = device.features().contains(wgpu::Features::INDIRECT_FIRST_INSTANCE)
            && device.limits().max_storage_buffers_per_shader_stage >= 2;
        // One for all, or one per part: both instances of the second part show the same tiles.
        assert_eq!((stats.tiles, stats.draws), (3 * 64, if reads_draws { 1 } else { 2 }));
        // Edges are one per part.
        let lines = live.upload(0, &view.with_wireframe(true).with_edges(true)).unwrap().stats();
        assert_eq!(lines.draws, 2 * stats.draws + 2);
        // Without the first part there is one draw for the second; without an instance of the second, as many as
        // before.
        for (hidden, draws) in [(InstanceId(1), 1), (InstanceId(0), stats.draws)] {
            live.set_visible(hidden, false);
            assert_eq!(live.upload(0, &view).unwrap().stats().draws, draws);
            live.set_visible(hidden, true);
        }
    }
}

#[test]
fn locations_from_five_on_are_the_callers() {
    const MORE: [wgpu::VertexAttribute; 1] = wgpu::vertex_attr_array![5 => Uint32];
    for (device, queue) in devices() {
        let live = LiveScene::new(&device, &queue, OURS.colour).unwrap();
        let third =
            wgpu::VertexBufferLayout { array_stride: 4, step_mode: wgpu::VertexStepMode::Instance, attributes: &MORE };
        // A clash of locations would be an error of the device, which panics.
        pipeline_with(&device, &live, OURS, "colours", Some(third));
    }
}

#[test]
fn what_the_caller_draws_is_not_cut_by_the_near_plane() {
    let Some(renderer) = renderer() else { return };
    let mut live = renderer.live();
    send(&whole(&scene(), 2), &mut live);
    let view = options(ColourBy::Model);
    let camera = view.camera.unwrap();
    // A face of the box is across the line of sight.
    let straight = "0,0".parse::<ViewPoint>().unwrap().fit([DVec3::ZERO, DVec3::new(17.0, 17.0, 0.0)], 1.3);
    for camera in [camera, camera.orthographic(), straight, straight.orthographic()] {
        // Almost at the eye, and as far behind.
        let middle = DVec3::new(8.0, 8.0, 0.0);
        let ends = [0.95, -0.95].map(|part| middle.lerp(camera.eye, part));
        let view = view.with_camera(Some(camera));
        let bounds = Some([ends[0].min(ends[1]), ends[0].max(ends[1])]);
        let is_inside = |live: &mut LiveScene, view: &RenderOptions, point: DVec3| {
            let drawn = live.upload(0, view).unwrap();
            let clip = drawn.clip() * (point - drawn.eye()).extend(1.0);
            (0.0..=1.0).contains(&(clip.z / clip.w))
        };
        assert!(is_inside(&mut live, &view, middle) && !is_inside(&mut live, &view, ends[0]), "{camera:?}");
        let wide = view.with_other_bounds(bounds);
        assert!([middle, ends[0], ends[1]].into_iter().all(|point| is_inside(&mut live, &wide, point)), "{camera:?}");
    }
}
