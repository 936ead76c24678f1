//! egui's triangles to pixels, in one pass that also draws the scene's texture.

use egui::epaint::{ImageDelta, Primitive, Vertex};
use egui::{ClippedPrimitive, ImageData, TextureFilter, TextureId, TextureOptions, TexturesDelta};
use std::collections::HashMap;
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, LoadOp, Operations, RenderPipeline, StoreOp, Texture,
    TextureFormat, TextureUsages, TextureView,
};

/// Id of the texture with the scene.
pub(super) const PICTURE: TextureId = TextureId::User(0);

/// Draws egui's output.
pub(super) struct Painter {
    device: wgpu::Device,
    queue: wgpu::Queue,
    globals: Buffer,
    globals_group: BindGroup,
    image_layout: BindGroupLayout,
    widget: RenderPipeline,
    picture: RenderPipeline,
    textures: HashMap<TextureId, (Texture, BindGroup)>,
    vertices: Option<Buffer>,
    indices: Option<Buffer>,
    encoded: bool,
}

/// The target of a picture.
#[derive(Clone, Copy)]
pub(super) struct Canvas<'a> {
    pub(super) target: &'a TextureView,
    /// Width and height in pixels.
    pub(super) size: (u32, u32),
    pub(super) pixels_per_point: f32,
}

impl Painter {
    pub(super) fn new(device: &wgpu::Device, queue: &wgpu::Queue, format: TextureFormat) -> Self {
        let layout = |entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("panel"), entries })
        };
        let entry = |binding, visibility, ty| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
        let both = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let image = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let globals_layout = layout(&[entry(0, both, uniform)]);
        let image_layout = layout(&[entry(0, both, image), entry(1, both, sampler)]);
        let globals = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("panel"),
            size: 16,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let globals_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("panel"),
            layout: &globals_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: globals.as_entire_binding() }],
        });
        let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("panel"),
            source: wgpu::ShaderSource::Wgsl(include_str!("paint.wgsl").into()),
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("panel"),
            bind_group_layouts: &[Some(&globals_layout), Some(&image_layout)],
            immediate_size: 0,
        });
        let attributes = wgpu::vertex_attr_array![0 => Float32x2, 1 => Float32x2, 2 => Unorm8x4];
        let pipeline = |fragment| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(fragment),
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &shader,
                    entry_point: Some("vertex"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[Some(wgpu::VertexBufferLayout {
                        array_stride: size_of::<Vertex>() as u64,
                        step_mode: wgpu::VertexStepMode::Vertex,
                        attributes: &attributes,
                    })],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &shader,
                    entry_point: Some(fragment),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(wgpu::ColorTargetState {
                        blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                        ..format.into()
                    })],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        Self {
            widget: pipeline("widget"),
            picture: pipeline("picture"),
            globals,
            globals_group,
            image_layout,
            textures: HashMap::new(),
            vertices: None,
            indices: None,
            encoded: !format.is_srgb(),
            device: device.clone(),
            queue: queue.clone(),
        }
    }

    /// Sets the texture with the scene.
    pub(super) fn show(&mut self, picture: &Texture) {
        let group = self.group(picture, TextureOptions::NEAREST);
        self.textures.insert(PICTURE, (picture.clone(), group));
    }

    /// Paints the whole window.
    pub(super) fn paint(&mut self, canvas: &Canvas<'_>, primitives: &[ClippedPrimitive], textures: &TexturesDelta) {
        textures.set.iter().for_each(|(id, delta)| self.set(*id, delta));
        let (width, height) = (canvas.size.0 as f32, canvas.size.1 as f32);
        let encoded = if self.encoded { 1.0 } else { 0.0 };
        let globals = [width / canvas.pixels_per_point, height / canvas.pixels_per_point, encoded, 0.0];
        self.queue.write_buffer(&self.globals, 0, bytemuck::cast_slice(&globals));
        let (mut vertices, mut indices, mut draws) = (Vec::<Vertex>::new(), Vec::<u32>::new(), Vec::new());
        for ClippedPrimitive { clip_rect, primitive } in primitives {
            let Primitive::Mesh(mesh) = primitive else { continue };
            let clip = *clip_rect * canvas.pixels_per_point;
            let pixel = |x: f32, most: u32| (x.round().max(0.0) as u32).min(most);
            let (left, top) = (pixel(clip.min.x, canvas.size.0), pixel(clip.min.y, canvas.size.1));
            let (right, bottom) = (pixel(clip.max.x, canvas.size.0), pixel(clip.max.y, canvas.size.1));
            let (first, base) = (indices.len() as u32, vertices.len() as i32);
            vertices.extend_from_slice(&mesh.vertices);
            indices.extend_from_slice(&mesh.indices);
            if left < right && top < bottom {
                let scissor = [left, top, right - left, bottom - top];
                draws.push((scissor, mesh.texture_id, first..indices.len() as u32, base));
            }
        }
        let Self { device, queue, vertices: vertex_buffer, indices: index_buffer, .. } = self;
        let vertices = fill(device, queue, vertex_buffer, BufferUsages::VERTEX, bytemuck::cast_slice(&vertices));
        let indices = fill(device, queue, index_buffer, BufferUsages::INDEX, bytemuck::cast_slice(&indices));

        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("panel"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: canvas.target,
                depth_slice: None,
                resolve_target: None,
                ops: Operations { load: LoadOp::Clear(wgpu::Color::BLACK), store: StoreOp::Store },
            })],
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_bind_group(0, &self.globals_group, &[]);
        pass.set_vertex_buffer(0, vertices.slice(..));
        pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
        for ([x, y, width, height], id, range, base) in draws {
            let Some((_, group)) = self.textures.get(&id) else { continue };
            pass.set_pipeline(if id == PICTURE { &self.picture } else { &self.widget });
            pass.set_bind_group(1, group, &[]);
            pass.set_scissor_rect(x, y, width, height);
            pass.draw_indexed(range, base, 0..1);
        }
        drop(pass);
        self.queue.submit([encoder.finish()]);
        for id in &textures.free {
            self.textures.remove(id);
        }
    }

    /// Creates a texture, or updates part of one.
    fn set(&mut self, id: TextureId, delta: &ImageDelta) {
        let ImageData::Color(image) = &delta.image;
        let [width, height] = image.size.map(|side| side as u32);
        if delta.pos.is_none() {
            let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
            let texture = texture(&self.device, (width, height), TextureFormat::Rgba8Unorm, usage);
            let group = self.group(&texture, delta.options);
            self.textures.insert(id, (texture, group));
        }
        let Some((texture, _)) = self.textures.get(&id) else { return };
        let [x, y] = delta.pos.unwrap_or_default().map(|at| at as u32);
        self.queue.write_texture(
            wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x, y, z: 0 }, ..texture.as_image_copy() },
            bytemuck::cast_slice(&image.pixels),
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * width), rows_per_image: None },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
    }

    fn group(&self, texture: &Texture, options: TextureOptions) -> BindGroup {
        let filter = |filter| match filter {
            TextureFilter::Nearest => wgpu::FilterMode::Nearest,
            TextureFilter::Linear => wgpu::FilterMode::Linear,
        };
        let sampler = self.device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: filter(options.magnification),
            min_filter: filter(options.minification),
            ..wgpu::SamplerDescriptor::default()
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("panel"),
            layout: &self.image_layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Sampler(&sampler) },
            ],
        })
    }
}

/// Creates a texture with one mip level.
pub(super) fn texture(
    device: &wgpu::Device,
    (width, height): (u32, u32),
    format: TextureFormat,
    usage: TextureUsages,
) -> Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("viewer"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

/// Writes `bytes` to the buffer, replacing it by a larger one if needed.
fn fill(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &mut Option<Buffer>,
    usage: BufferUsages,
    bytes: &[u8],
) -> Buffer {
    let needed = bytes.len() as u64;
    let made = buffer.take().filter(|buffer| buffer.size() >= needed).unwrap_or_else(|| {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("panel"),
            size: needed.next_power_of_two().max(4096),
            usage: usage | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    });
    queue.write_buffer(&made, 0, bytes);
    buffer.insert(made).clone()
}
