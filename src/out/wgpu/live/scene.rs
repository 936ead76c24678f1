//! A scene that stays on the graphics device from frame to frame, and its pictures.

use super::super::error::RenderError;
use super::super::gpu::Gpu;
use super::super::options::RenderOptions;
use super::super::target::SampleTargets;
use super::lists::{Edges, Rows, Tiles};
use super::pending::Pending;
use super::records::Records;
use super::shown::ShownScene;
use super::sight::{Aim, SceneSight};
use super::store::Store;
use crate::model::{FaceId, InstanceId};
use crate::out::{Camera, ViewPoint};
use ::wgpu::{BindGroup, BufferUsages, LoadOp, Operations, RenderPass, StoreOp, TextureFormat, TextureView};
use std::fmt;

/// The last frame that ended, on the graphics device, ready to be drawn from anywhere: a [`MeshSink`](crate::mesh::MeshSink) for
/// sessions and a picture for every camera.
///
/// Each tile has ranges of vertex and index buffers of its own; a frame of changes sends the tiles that it has and touches no
/// others. What a frame sends is put beside what is drawn and takes its place when the frame ends, all at once: a frame that
/// is aborted leaves the last one as it was (the next must be a whole one). A whole frame therefore needs room for both.
/// Instances share their part's tiles. Coordinates on the device are relative to the part's centre, and the world is seen from the
/// eye, so that neither large parts nor large worlds tremble.
///
/// A vertex has 16 bytes, an index 2 (4 in tiles of more than 65 536 vertices), a tile of an instance 16 and its draw 20.
/// Buffers grow by pages: nothing is moved. Nothing waits for the device but [`pick`](Self::pick).
pub struct LiveScene {
    pub(super) gpu: Gpu,
    pub(super) store: Store,
    pub(super) shown: ShownScene,
    /// Whether what is shown is what the last frame left: changes build on it.
    pub(super) whole: bool,
    pub(super) pending: Option<Pending>,
    /// Counts frames, so that each list knows whether it is up to date.
    pub(super) version: u64,
    /// The same for frames that change what there is of edges.
    pub(super) edges_version: u64,
    pub(super) records: Records,
    pub(super) record_rows: Rows,
    /// By view.
    pub(super) tiles: Vec<Tiles>,
    pub(super) edges: Edges,
    pub(super) sight: SceneSight,
    pub(super) samples: Option<SampleTargets>,
    pub(super) uploaded: u64,
}

impl fmt::Debug for LiveScene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LiveScene").field("held", &self.held()).finish_non_exhaustive()
    }
}

/// Bytes of the device's buffers.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[non_exhaustive]
pub struct BytesHeld {
    /// Pages of vertices.
    pub vertices: u64,
    /// Pages of indices.
    pub indices: u64,
    /// Pages of edges.
    pub edges: u64,
    /// What draws are made from: a row for each tile of each instance, draws, placements.
    pub draws: u64,
    /// What tiles pass through on their way.
    pub staging: u64,
    /// How many pages there are.
    pub pages: usize,
}

impl BytesHeld {
    /// All of them.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.vertices + self.indices + self.edges + self.draws + self.staging
    }
}

/// What a picture was made of.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[non_exhaustive]
pub struct Drew {
    /// Triangles, each instance's counted.
    pub triangles: u64,
    /// Draws of tiles.
    pub tiles: usize,
    /// Bytes that went to the device beside tiles: placements, and rows and draws that have changed.
    pub bytes: u64,
}

impl LiveScene {
    /// An empty scene on the caller's device, for pictures of `format`. Shaders write linear light: a format that does not encode
    /// sRGB shows it too dark.
    ///
    /// The device needs storage buffers in vertex shaders (`DownlevelFlags::VERTEX_STORAGE`, three of them) and no feature;
    /// with `Features::INDIRECT_FIRST_INSTANCE` the draws of a page are one call.
    ///
    /// # Errors
    /// When the device does not take the shaders.
    pub fn new(device: &::wgpu::Device, queue: &::wgpu::Queue, format: TextureFormat) -> Result<Self, RenderError> {
        Ok(Self::with(Gpu::new(device.clone(), queue.clone(), format)?))
    }

    pub(in super::super) fn with(gpu: Gpu) -> Self {
        Self {
            gpu,
            store: Store::new(),
            shown: ShownScene::default(),
            whole: false,
            pending: None,
            version: 1,
            edges_version: 1,
            records: Records::default(),
            record_rows: Rows::new(BufferUsages::VERTEX),
            tiles: Vec::new(),
            edges: Edges::new(),
            sight: SceneSight::new(),
            samples: None,
            uploaded: 0,
        }
    }

    /// Draws the last frame that ended into `target`, which must be of this scene's format and of the size that `options` has, with
    /// the tiles that the frame's view number `view` draws; all of them where the frame was not made for so many views.
    /// Submits its own commands. Instances are drawn opaque, whatever the alpha of their colours. Without a camera, a box around
    /// all parts is seen from [`ViewPoint::ISO`].
    ///
    /// Cost: a draw for each tile of each instance; rows of tiles that changed and, if the tiles to draw have changed, the
    /// list of them go to the device before.
    ///
    /// # Errors
    /// When the picture is larger than the adapter allows, or the device fails.
    pub fn draw(&mut self, target: &TextureView, view: usize, options: &RenderOptions) -> Result<Drew, RenderError> {
        self.gpu.takes(options.size)?;
        let view = self.known(view);
        let camera = self.camera(options);
        let gpu = self.gpu.clone();
        gpu.checked(|device| {
            if self.samples.as_ref().is_none_or(|samples| samples.size != options.size) {
                self.samples = Some(SampleTargets::new(&gpu, options.size));
            }
            let (sight, mut bytes) = self.refresh(view, options, &Aim { camera: &camera, pixel: None });
            if options.wireframe {
                bytes += self.tiles[view].refresh_wires(&gpu, &self.store);
            }
            if options.edges {
                bytes += self.edges.refresh(&gpu, &self.shown, &self.store, self.edges_version);
            }
            let Some(samples) = &self.samples else { return Drew::default() };
            let mut encoder = device.create_command_encoder(&::wgpu::CommandEncoderDescriptor::default());
            let mut pass = encoder.begin_render_pass(&::wgpu::RenderPassDescriptor {
                label: Some("trimtess"),
                color_attachments: &[Some(::wgpu::RenderPassColorAttachment {
                    view: &samples.colour,
                    depth_slice: None,
                    resolve_target: Some(target),
                    ops: Operations { load: LoadOp::Clear(::wgpu::Color::BLACK), store: StoreOp::Discard },
                })],
                depth_stencil_attachment: Some(::wgpu::RenderPassDepthStencilAttachment {
                    view: &samples.depth,
                    depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Discard }),
                    stencil_ops: None,
                }),
                ..::wgpu::RenderPassDescriptor::default()
            });
            pass.set_bind_group(0, &sight, &[]);
            pass.set_pipeline(&gpu.pipelines.backdrop);
            pass.draw(0..3, 0..1);
            pass.set_pipeline(&gpu.pipelines.surface);
            self.draw_tiles(&mut pass, view);
            if options.lattice {
                pass.set_pipeline(&gpu.pipelines.lattice);
                self.draw_lattice(&mut pass, view);
            }
            // Lines come after all surfaces: each is drawn over the surface it lies on.
            if let Some(records) = self.record_rows.buffer().filter(|_| options.wireframe) {
                pass.set_pipeline(&gpu.pipelines.wire);
                pass.set_vertex_buffer(0, records.slice(..));
                self.tiles[view].draw_wires(&mut pass);
            }
            if options.edges {
                pass.set_pipeline(&gpu.pipelines.edge);
                self.edges.draw(&mut pass);
            }
            drop(pass);
            gpu.queue.submit([encoder.finish()]);
            Drew { triangles: self.tiles[view].triangles, tiles: self.tiles[view].count(), bytes }
        })
    }

    /// Whether vertices know their places in their tile's lattice, 8 bytes each: what pictures with [`RenderOptions::lattice`] need.
    /// They do not, unless it is asked for. Tiles that are there already get theirs when they come again, with the next whole frame
    /// at the latest (`Session::forget` makes the next one whole).
    ///
    /// # Errors
    /// When the device has no room.
    pub fn keep_lattice(&mut self, keep: bool) -> Result<(), RenderError> {
        self.store.keep_cells(&self.gpu, keep)
    }

    /// Has a face of an instance stand out in a colour of its own from the next picture on, as long as there are both; `None` for no
    /// face.
    pub fn highlight(&mut self, face: Option<(InstanceId, FaceId)>) {
        self.records.mark(face);
    }

    /// What the device holds for this scene, beside the textures that pictures are drawn in.
    #[must_use]
    pub fn held(&self) -> BytesHeld {
        let Store { vertices, indices, points, staging, .. } = &self.store;
        let lists: u64 = self.tiles.iter().map(Tiles::bytes).sum();
        BytesHeld {
            vertices: vertices.bytes(),
            indices: indices.bytes(),
            edges: points.bytes(),
            draws: self.record_rows.bytes() + lists + self.edges.bytes() + self.sight.bytes(),
            staging: staging.held(),
            pages: vertices.count() + indices.count() + points.count(),
        }
    }

    /// Bytes of tiles and edges that the last frame sent to the device.
    #[must_use]
    pub fn uploaded(&self) -> u64 {
        self.uploaded
    }

    /// The view, or the one past all that the frame was made for, which draws everything.
    pub(super) fn known(&self, view: usize) -> usize {
        view.min(self.shown.drawn.views())
    }

    /// The camera of a picture.
    pub(super) fn camera(&self, options: &RenderOptions) -> Camera {
        let aspect = f64::from(options.size.0) / f64::from(options.size.1);
        options.camera.unwrap_or_else(|| ViewPoint::ISO.fit(self.shown.corners(), aspect))
    }

    /// Brings everything that a view's tiles are drawn from up to date.
    pub(super) fn refresh(&mut self, view: usize, options: &RenderOptions, aim: &Aim<'_>) -> (BindGroup, u64) {
        let changed = self.records.refresh(&self.shown, options.colour_by);
        let mut bytes = self.record_rows.write(&self.gpu, &self.records.rows, changed);
        while self.tiles.len() <= view {
            self.tiles.push(Tiles::new());
        }
        bytes += self.tiles[view].refresh(&self.gpu, &self.shown, &self.records, view, self.version);
        let (sight, seen) = self.sight.refresh(&self.gpu, &self.shown, aim, options);
        (sight, bytes + seen)
    }

    pub(super) fn draw_tiles(&self, pass: &mut RenderPass<'_>, view: usize) {
        if let Some(records) = self.record_rows.buffer() {
            pass.set_vertex_buffer(1, records.slice(..));
            self.tiles[view].draw(pass, &self.store);
        }
    }

    fn draw_lattice(&self, pass: &mut RenderPass<'_>, view: usize) {
        if let Some(records) = self.record_rows.buffer() {
            pass.set_vertex_buffer(1, records.slice(..));
            self.tiles[view].draw_lattice(pass, &self.store);
        }
    }
}
