//! A frame to an image: one pass per chunk over a multisampled target with reversed floating-point depth.

use super::adapter::{self, NoAdapter, Opened};
use super::chunk::{Chunk, Chunks, Pen};
use super::palette::Palette;
use super::pipelines::Pipelines;
use super::target::Target;
use super::{Image, RenderOptions};
use crate::mesh::MemorySink;
use crate::out::placed::{Placement, batches_by_part, lines_by_part, placed};
use crate::out::{Camera, ViewPoint, colour};
use ::wgpu::util::{BufferInitDescriptor, DeviceExt};
use ::wgpu::{BufferUsages, LoadOp, Operations, StoreOp};
use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec3, Vec3};
use std::fmt;

/// The near plane, as a fraction of the eye's distance to the scene's centre or of the scene's radius, whichever is larger.
/// Reversed floating depth loses nothing to a near plane this close.
const NEAR: f64 = 1e-4;
/// Triangle edges: thin and translucent, so that dense meshes keep their shading.
const WIRE: Pen = Pen { colour: [24, 30, 44, 150], width: 1.0 };
/// B-rep edges stand out from the wireframe.
const EDGE: Pen = Pen { colour: [16, 18, 22, 255], width: 1.7 };

/// Why there is no picture.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum RenderError {
    /// The picture has no pixels, or more in a row or column than the adapter allows.
    Size {
        /// What was asked for.
        size: (u32, u32),
        /// The longest side.
        limit: u32,
    },
    /// The device failed, mostly for want of memory.
    Device(String),
}

impl fmt::Display for RenderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size { size, limit } => {
                write!(f, "cannot draw {} × {} pixels; each side may be 1 to {limit}", size.0, size.1)
            }
            Self::Device(cause) => write!(f, "the graphics device failed: {cause}"),
        }
    }
}

impl std::error::Error for RenderError {}

/// A graphics device with its pipelines: made once, it draws any number of pictures.
#[derive(Debug)]
pub struct Renderer {
    device: ::wgpu::Device,
    queue: ::wgpu::Queue,
    info: ::wgpu::AdapterInfo,
    pipelines: Pipelines,
}

/// As `Globals` in the shader.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Globals {
    clip: [f32; 16],
    eye: [f32; 4],
    key: [f32; 4],
    top: [f32; 4],
    bottom: [f32; 4],
    size: [f32; 2],
    near: f32,
    backfaces: f32,
}

/// What a pass does to the target.
#[derive(Clone, Copy)]
enum Step<'a> {
    /// Clears depth and paints the background.
    Backdrop,
    /// Draws on top.
    Chunk(&'a Chunk),
    /// Averages the samples.
    Resolve,
}

impl Renderer {
    /// Opens the best adapter: a real one if any, else software. Takes tenths of a second.
    ///
    /// # Errors
    /// When there is none; the message tells what to install.
    pub fn new() -> Result<Self, NoAdapter> {
        let Opened { device, queue, info, pipelines } = adapter::open()?;
        Ok(Self { device, queue, info, pipelines })
    }

    /// Name of the adapter and of its interface.
    #[must_use]
    pub fn adapter(&self) -> String {
        format!("{} ({})", self.info.name, self.info.backend)
    }

    /// Draws every instance of a frame. Colours are drawn opaque, whatever their alpha.
    ///
    /// # Errors
    /// When the picture is larger than the adapter allows, or the device fails.
    pub fn render(&self, frame: &MemorySink, options: &RenderOptions) -> Result<Image, RenderError> {
        let limit = self.device.limits().max_texture_dimension_2d;
        let (width, height) = options.size;
        if !(1..=limit).contains(&width) || !(1..=limit).contains(&height) {
            return Err(RenderError::Size { size: options.size, limit });
        }
        // Outside a scope the device reports by panicking.
        let memory = self.device.push_error_scope(::wgpu::ErrorFilter::OutOfMemory);
        let validation = self.device.push_error_scope(::wgpu::ErrorFilter::Validation);
        let internal = self.device.push_error_scope(::wgpu::ErrorFilter::Internal);
        let image = self.draw(frame, options);
        let (internal, validation, memory) = (internal.pop(), validation.pop(), memory.pop());
        let (internal, validation) = (pollster::block_on(internal), pollster::block_on(validation));
        // Memory that could not be had makes what follows invalid: the cause comes first.
        match pollster::block_on(memory).or(internal).or(validation) {
            Some(error) => Err(RenderError::Device(error.to_string())),
            None => image,
        }
    }

    fn draw(&self, frame: &MemorySink, options: &RenderOptions) -> Result<Image, RenderError> {
        let (width, height) = options.size;
        let (batches, lines) = (batches_by_part(frame), lines_by_part(frame));
        let points = || {
            placed(frame, &batches).flat_map(|(instance, batches)| {
                let placement = Placement::new(&instance.transform);
                let points = batches.iter().flat_map(|batch| &batch.mesh.positions);
                points.map(move |&point| placement.position(point))
            })
        };
        let outside = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = points().fold(outside, |(low, high), point| (low.min(point), high.max(point)));
        let centre = if low.x <= high.x { 0.5 * (low + high) } else { DVec3::ZERO };
        let aspect = f64::from(width) / f64::from(height);
        let camera = options.camera.unwrap_or_else(|| ViewPoint::ISO.fit(points(), aspect));
        let near = NEAR * camera.eye.distance(centre).max(0.5 * (high - low).length()).clamp(1e-3, f64::MAX);
        let globals = self.bind(&globals(&camera, centre, near, options));

        let target = Target::new(&self.device, width, height);
        self.pass(&target, &globals, Step::Backdrop)?;
        let palette = Palette::new(options.colour_by, frame);
        let mut draw = |chunk: &Chunk| self.pass(&target, &globals, Step::Chunk(chunk));
        let mut chunks = Chunks::new(centre, &mut draw);
        for (instance, batches) in placed(frame, &batches) {
            let placement = Placement::new(&instance.transform);
            for batch in batches {
                chunks.surface(&batch.mesh, &placement, palette.of(instance, batch))?;
            }
        }
        // Lines come after all surfaces: each is drawn over the surface it lies on.
        for (instance, batches) in placed(frame, &batches).filter(|_| options.wireframe) {
            let placement = Placement::new(&instance.transform);
            for batch in batches {
                chunks.wireframe(&batch.mesh, &placement, WIRE)?;
            }
        }
        for instance in frame.scene.instances.iter().filter(|_| options.edges) {
            let placement = Placement::new(&instance.transform);
            for line in lines.get(instance.part as usize).into_iter().flatten() {
                chunks.polyline(&line.points, &placement, EDGE)?;
            }
        }
        chunks.finish()?;
        self.pass(&target, &globals, Step::Resolve)?;
        target.read_back(&self.device, &self.queue)
    }

    fn bind(&self, globals: &Globals) -> ::wgpu::BindGroup {
        let buffer = self.buffer(std::slice::from_ref(globals), BufferUsages::UNIFORM);
        self.device.create_bind_group(&::wgpu::BindGroupDescriptor {
            label: Some("globals"),
            layout: &self.pipelines.bindings,
            entries: &[::wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }],
        })
    }

    fn buffer<T: Pod>(&self, contents: &[T], usage: BufferUsages) -> ::wgpu::Buffer {
        let contents = bytemuck::cast_slice(contents);
        self.device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage })
    }

    /// Records one pass, submits it and waits, so that only one chunk's buffers live at a time.
    fn pass(&self, target: &Target, globals: &::wgpu::BindGroup, step: Step<'_>) -> Result<(), RenderError> {
        let first = matches!(step, Step::Backdrop);
        let last = matches!(step, Step::Resolve);
        let store = if last { StoreOp::Discard } else { StoreOp::Store };
        let mut encoder = self.device.create_command_encoder(&::wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_render_pass(&::wgpu::RenderPassDescriptor {
            label: Some("trimtess"),
            color_attachments: &[Some(::wgpu::RenderPassColorAttachment {
                view: &target.samples,
                depth_slice: None,
                resolve_target: last.then_some(&target.image),
                ops: Operations { load: if first { LoadOp::Clear(::wgpu::Color::BLACK) } else { LoadOp::Load }, store },
            })],
            depth_stencil_attachment: Some(::wgpu::RenderPassDepthStencilAttachment {
                view: &target.depth,
                depth_ops: Some(Operations { load: if first { LoadOp::Clear(0.0) } else { LoadOp::Load }, store }),
                stencil_ops: None,
            }),
            ..::wgpu::RenderPassDescriptor::default()
        });
        pass.set_bind_group(0, globals, &[]);
        match step {
            Step::Backdrop => {
                pass.set_pipeline(&self.pipelines.backdrop);
                pass.draw(0..3, 0..1);
            }
            Step::Chunk(chunk) => {
                if !chunk.indices.is_empty() {
                    pass.set_pipeline(&self.pipelines.surface);
                    pass.set_vertex_buffer(0, self.buffer(&chunk.vertices, BufferUsages::VERTEX).slice(..));
                    let indices = self.buffer(&chunk.indices, BufferUsages::INDEX);
                    pass.set_index_buffer(indices.slice(..), ::wgpu::IndexFormat::Uint32);
                    pass.draw_indexed(0..chunk.indices.len() as u32, 0, 0..1);
                }
                if !chunk.segments.is_empty() {
                    pass.set_pipeline(&self.pipelines.line);
                    pass.set_vertex_buffer(0, self.buffer(&chunk.segments, BufferUsages::VERTEX).slice(..));
                    pass.draw(0..6, 0..chunk.segments.len() as u32);
                }
            }
            Step::Resolve => {}
        }
        drop(pass);
        self.queue.submit([encoder.finish()]);
        let waited = self.device.poll(::wgpu::PollType::wait_indefinitely());
        waited.map(|_| ()).map_err(|error| RenderError::Device(error.to_string()))
    }
}

fn globals(camera: &Camera, centre: DVec3, near: f64, options: &RenderOptions) -> Globals {
    let (width, height) = options.size;
    let view = camera.view();
    let projection = camera.projection(f64::from(width) / f64::from(height), near);
    // Products and differences of large world coordinates are taken in f64, here.
    let clip = projection * view * DMat4::from_translation(centre);
    let [right, up, back] = [view.row(0), view.row(1), view.row(2)].map(|row| row.truncate().as_vec3());
    let key: Vec3 = (0.75 * up + 0.65 * back - 0.55 * right).normalize_or_zero();
    let [top, bottom] = options.background.map(colour::linear);
    Globals {
        clip: clip.as_mat4().to_cols_array(),
        eye: (camera.eye - centre).as_vec3().extend(1.0).to_array(),
        key: key.extend(0.0).to_array(),
        top,
        bottom,
        size: [width as f32, height as f32],
        near: near as f32,
        backfaces: if options.backfaces { 1.0 } else { 0.0 },
    }
}
