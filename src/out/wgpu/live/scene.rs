//! Frames to a scene on the graphics device, and to its pictures.

use super::super::gpu::{Gpu, RenderError};
use super::super::image::{SampleTargets, begin_pass};
use super::super::options::RenderOptions;
use super::super::pipelines::{CellPlace, DEPTH_FORMAT, SAMPLES, SurfaceInput};
use super::device_scene::{DeviceScene, Pending};
use super::draws::{Edges, SurfaceDraw, Tiles, encode_all};
use super::pages::Companion;
use super::records::{RecordRows, Records};
use super::store::Store;
use super::uniforms::{Aim, Lease, Sights, UploadedSight};
use crate::model::{FaceId, InstanceId};
use crate::view::{Camera, ViewPoint};
use ::wgpu::{
    BindGroup, LoadOp, Operations, RenderPass, RenderPassColorAttachment, StoreOp, TextureFormat, TextureView,
};
use glam::{DMat4, DVec3};
use std::fmt;

/// A [`MeshSink`](crate::mesh::MeshSink) that keeps the last complete frame on the graphics device and draws it from
/// any camera.
///
/// Each tile owns ranges of the vertex and index buffers, so a frame of changes uploads only the tiles it contains.
/// A frame is uploaded next to the one that is drawn and replaces it when it ends. An aborted frame leaves the last one
/// drawable, but the next frame must be a whole one. A whole frame needs room for both.
///
/// Instances share the tiles of their part. Vertices are relative to the centre of the part, and placements to the eye,
/// so that large parts and large worlds do not jitter.
///
/// Drawn by the scene's own pipelines ([`draw`](Self::draw), [`encode`](Self::encode)), or by the caller's
/// ([`draw_surfaces`](Self::draw_surfaces)).
///
/// Memory, in bytes:
///
/// | | tiles drawn one by one | [merged](Self::new) |
/// |---|---|---|
/// | a vertex | 16 | 20 |
/// | an index | 2; 4 in tiles of more than 65 535 vertices | 4 |
/// | a tile of an instance | 40 | 8 |
/// | an instance | 16, and 48 for each picture under way at once | the same |
///
/// Adjacent instances that show the same tiles share merged indices. The caller's memory holds as much again of these.
/// Buffers grow by pages; nothing is moved. Only [`pick`](Self::pick) waits for the device.
pub struct LiveScene {
    pub(super) gpu: Gpu,
    pub(super) store: Store,
    pub(super) shown: DeviceScene,
    /// The last frame ended, so that changes may follow. Cleared by an abort.
    pub(super) whole: bool,
    pub(super) pending: Option<Pending>,
    /// Counts frames. Draw lists compare it to know whether they are up to date.
    pub(super) version: u64,
    /// Counts frames that change edges.
    pub(super) edges_version: u64,
    pub(super) records: Records,
    record_rows: RecordRows,
    /// By view.
    pub(super) tiles: Vec<Tiles>,
    edges: Edges,
    sights: Sights,
    samples: Option<SampleTargets>,
    pub(super) uploaded: u64,
}

impl fmt::Debug for LiveScene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LiveScene").field("held", &self.held()).finish_non_exhaustive()
    }
}

/// Size of the scene's buffers on the device, in bytes.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[non_exhaustive]
pub struct DeviceMemory {
    /// Pages of vertices.
    pub vertices: u64,
    /// Pages of indices.
    pub indices: u64,
    /// Points of edges, once they were drawn.
    pub edges: u64,
    /// Draws and their data: records of tiles per instance, placements.
    pub draws: u64,
    /// Staging buffer for uploads.
    pub staging: u64,
    /// Number of pages.
    pub pages: usize,
}

impl DeviceMemory {
    /// Sum of all buffers, in bytes.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.vertices + self.indices + self.edges + self.draws + self.staging
    }
}

/// Counts of one picture.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[non_exhaustive]
pub struct DrawStats {
    /// Triangles, summed over instances.
    pub triangles: u64,
    /// Tiles, summed over instances.
    pub tiles: usize,
    /// Draw commands: surfaces, and the lines that the options ask for.
    pub draws: usize,
    /// Bytes uploaded for this picture, without tiles: placements, and changed records and draw lists.
    pub bytes: u64,
}

/// What a picture of a scene needs of the device, from [`LiveScene::upload`] on. Any number may be in use, of several
/// cameras. Keep it until the commands that draw it are submitted: then its buffers are used again.
#[derive(Clone, Debug)]
pub struct SceneInPass {
    group: BindGroup,
    /// Held as long as the group's buffers are in use.
    _lease: Lease,
    view: usize,
    /// The version of the scene that was uploaded.
    version: u64,
    clip: DMat4,
    eye: DVec3,
    lattice: bool,
    wireframe: bool,
    edges: bool,
    stats: DrawStats,
}

impl SceneInPass {
    /// What the picture will draw, and what was uploaded for it.
    #[must_use]
    pub fn stats(&self) -> DrawStats {
        self.stats
    }

    /// Bind group 0 of [`SurfaceInput`]: the camera, placements and records.
    #[must_use]
    pub fn bind_group(&self) -> &BindGroup {
        &self.group
    }

    /// World relative to [`eye`](Self::eye), to clip space with reversed depth. Large worlds jitter in single precision
    /// unless the eye is subtracted first.
    #[must_use]
    pub fn clip(&self) -> DMat4 {
        self.clip
    }

    /// The camera's eye, world coordinates.
    #[must_use]
    pub fn eye(&self) -> DVec3 {
        self.eye
    }
}

impl LiveScene {
    /// Depth format of the passes that [`encode`](Self::encode) takes.
    pub const DEPTH: TextureFormat = DEPTH_FORMAT;

    /// Samples per pixel of the passes that [`encode`](Self::encode) takes.
    pub const SAMPLES: u32 = SAMPLES;

    /// Creates an empty scene on the caller's device, for pictures of `format`.
    ///
    /// Shaders write linear light, so a format that does not encode sRGB looks too dark. The device needs no features:
    /// that of OpenGL ES 3.0 or WebGL 2 suffices. With `Features::INDIRECT_FIRST_INSTANCE`, and two storage buffers in
    /// vertex shaders, all draws from a page are one call of wgpu's; otherwise the tiles of a part are merged into one
    /// draw per page, again where an instance shows other tiles than the one before, and the wireframe has lines of a
    /// pixel that do not fade out.
    ///
    /// # Errors
    /// If the device rejects the shaders.
    pub fn new(device: &::wgpu::Device, queue: &::wgpu::Queue, format: TextureFormat) -> Result<Self, RenderError> {
        Ok(Self::with(Gpu::new(device.clone(), queue.clone(), format)?))
    }

    pub(in super::super) fn with(gpu: Gpu) -> Self {
        Self {
            store: Store::new(&gpu),
            record_rows: RecordRows::new(&gpu),
            gpu,
            shown: DeviceScene::default(),
            whole: false,
            pending: None,
            version: 1,
            edges_version: 1,
            records: Records::default(),
            tiles: Vec::new(),
            edges: Edges::new(),
            sights: Sights::default(),
            samples: None,
            uploaded: 0,
        }
    }

    /// Draws the last complete frame into `target`, which must have this scene's format and the size in `options`.
    ///
    /// Draws the tiles of the frame's view number `view`, or all tiles if the frame has fewer views. Submits its own
    /// commands. Colours are drawn opaque; alpha is ignored. Without a camera in `options`, one is fitted to a box
    /// around all instances from [`ViewPoint::ISO`].
    ///
    /// Cost: [`DrawStats::draws`]. Uploads the records of changed tiles, and the draw list if it changed.
    ///
    /// # Errors
    /// If the picture is larger than the adapter allows, or the device fails. The scene stays; the next picture uploads
    /// again what this one needs besides tiles.
    pub fn draw(
        &mut self,
        target: &TextureView,
        view: usize,
        options: &RenderOptions,
    ) -> Result<DrawStats, RenderError> {
        let drawn = self.upload(view, options)?;
        self.checked(|scene, gpu| {
            if scene.samples.as_ref().is_none_or(|samples| samples.size != options.size) {
                scene.samples = Some(SampleTargets::new(gpu, options.size));
            }
            let Some(samples) = &scene.samples else { return DrawStats::default() };
            let mut encoder = gpu.device.create_command_encoder(&::wgpu::CommandEncoderDescriptor::default());
            let colour = RenderPassColorAttachment {
                view: &samples.colour,
                depth_slice: None,
                resolve_target: Some(target),
                ops: Operations { load: LoadOp::Clear(::wgpu::Color::BLACK), store: StoreOp::Discard },
            };
            let mut pass = begin_pass(&mut encoder, "trimtess", colour, &samples.depth);
            pass.set_bind_group(0, &drawn.group, &[]);
            pass.set_pipeline(&gpu.pipelines.backdrop);
            pass.draw(0..3, 0..1);
            scene.encode(&mut pass, &drawn);
            drop(pass);
            gpu.queue.submit([encoder.finish()]);
            drawn.stats
        })
    }

    /// Uploads what [`encode`](Self::encode) and [`draw_surfaces`](Self::draw_surfaces) need for a picture, as
    /// [`draw`](Self::draw) does. Colours and the highlight are those of the last call, in all pictures.
    ///
    /// # Errors
    /// As [`draw`](Self::draw).
    pub fn upload(&mut self, view: usize, options: &RenderOptions) -> Result<SceneInPass, RenderError> {
        self.gpu.takes(options.size)?;
        let view = self.known(view);
        let camera = self.camera(options);
        self.checked(|scene, gpu| {
            let UploadedSight { group, lease, clip, mut bytes } =
                scene.refresh(view, options, &Aim { camera: &camera, pixel: None });
            let RenderOptions { lattice, wireframe, edges, .. } = *options;
            let Self { store, shown, version, edges_version, record_rows, tiles, edges: lines, .. } = scene;
            let tiles = &mut tiles[view];
            let mut draws = tiles.calls();
            if lattice {
                draws += tiles.lattice_draws(store, record_rows.buffer()).count();
            }
            if wireframe {
                draws += tiles.calls();
                bytes += tiles.refresh_wires(gpu, store);
            }
            if edges {
                bytes += lines.refresh(gpu, shown, *edges_version);
                draws += lines.calls();
            }
            let stats = DrawStats { triangles: tiles.triangles, tiles: tiles.count, draws, bytes };
            let (version, eye) = (*version, camera.eye);
            SceneInPass { group, _lease: lease, view, version, clip, eye, lattice, wireframe, edges, stats }
        })
    }

    /// Runs work for a picture, and returns the device errors that it causes. Then what it left on the device may be
    /// half written: all but the tiles is dropped, and the next picture uploads it again.
    pub(super) fn checked<T>(&mut self, work: impl FnOnce(&mut Self, &Gpu) -> T) -> Result<T, RenderError> {
        let gpu = self.gpu.clone();
        let made = gpu.checked(|_| work(self, &gpu));
        if made.is_err() {
            self.record_rows = RecordRows::new(&gpu);
            self.tiles.clear();
            self.edges = Edges::new();
            self.sights = Sights::default();
            self.samples = None;
            // Pictures that were uploaded before draw from what is gone.
            self.version += 1;
        }
        made
    }

    /// Encodes the scene into the caller's pass: surfaces first, then lines over them. No backdrop.
    ///
    /// The pass has one colour target of this scene's format and depth of [`DEPTH`](Self::DEPTH), both with
    /// [`SAMPLES`](Self::SAMPLES) samples. Depth is reversed: cleared to 0, greater is nearer. What the caller draws
    /// with [`SceneInPass::clip`] shares it. Changes pipeline, bind groups, vertex and index buffers of the pass.
    ///
    /// Draws nothing if a frame ended, [`set_visible`](Self::set_visible) was called, or another picture or pick
    /// failed, after `drawn` was uploaded.
    pub fn encode(&self, pass: &mut RenderPass<'_>, drawn: &SceneInPass) {
        let Some(tiles) = self.tiles.get(drawn.view).filter(|_| drawn.version == self.version) else { return };
        let pipelines = &self.gpu.pipelines;
        pass.set_pipeline(&pipelines.surface);
        self.draw_surfaces(pass, drawn);
        if drawn.lattice {
            pass.set_pipeline(&pipelines.lattice);
            for (draw, cells) in tiles.lattice_draws(&self.store, self.record_rows.buffer()) {
                pass.set_vertex_buffer(2, cells.slice(..));
                draw.encode(pass, None);
            }
        }
        // Lines come after all surfaces, to be drawn over the surface they lie on.
        if drawn.wireframe {
            pass.set_pipeline(&pipelines.wire);
            if let Some(records) = self.record_rows.buffer() {
                pass.set_vertex_buffer(0, records.slice(..));
            }
            tiles.draw_wires(pass, &self.store);
        }
        if drawn.edges {
            pass.set_pipeline(&pipelines.edge);
            self.edges.draw(pass);
        }
    }

    /// What a pipeline needs for [`draw_surfaces`](Self::draw_surfaces).
    #[must_use]
    pub fn surface_input(&self) -> &SurfaceInput {
        &self.gpu.pipelines.input
    }

    /// Draws the surfaces with the pipeline and the bind groups from 1 on that the caller has set, in a pass of any
    /// formats and samples: with a material of the caller's, or depth alone for shadows.
    ///
    /// The pipeline is made for [`surface_input`](Self::surface_input). Sets bind group 0, vertex buffers 0 and 1, and
    /// the index buffer. Makes [`DrawStats::draws`] calls, if the options ask for no lines. Draws nothing where
    /// [`encode`](Self::encode) would not.
    pub fn draw_surfaces(&self, pass: &mut RenderPass<'_>, drawn: &SceneInPass) {
        pass.set_bind_group(0, &drawn.group, &[]);
        encode_all(pass, self.surface_draws(drawn));
    }

    /// The calls of [`draw_surfaces`](Self::draw_surfaces), with their buffers.
    pub fn surface_draws(&self, drawn: &SceneInPass) -> impl Iterator<Item = SurfaceDraw<'_>> {
        let tiles = self.tiles.get(drawn.view).filter(|_| drawn.version == self.version);
        tiles.into_iter().flat_map(|tiles| tiles.draws(&self.store, self.record_rows.buffer()))
    }

    /// Shows or hides an instance of the scene in all views, if the scene does not hide it. Frames do not change it,
    /// until one of [another model](crate::mesh::MeshSink::begin_update), which shows all of its instances. An unknown
    /// number is kept for an instance to come.
    ///
    /// Instances are rows of the scene, which shift when [`Session::remove_instance`] removes one before them. Where
    /// instances come and go, hide them by key in [`Session::set_instance`].
    ///
    /// Tiles of an instance hidden here are made and sent. One that a scene hides
    /// ([`SceneInstance::visible`](crate::mesh::SceneInstance::visible)) asks for none.
    ///
    /// [`Session::remove_instance`]: crate::parallel::Session::remove_instance
    /// [`Session::set_instance`]: crate::parallel::Session::set_instance
    pub fn set_visible(&mut self, instance: InstanceId, visible: bool) {
        let hidden = &mut self.shown.hidden;
        if if visible { hidden.remove(&instance) } else { hidden.insert(instance) } {
            self.version += 1;
            self.edges_version += 1;
        }
    }

    /// Stores the lattice position of each vertex (8 bytes), which [`RenderOptions::lattice`] needs. Off by default.
    /// Returns whether this changes anything.
    ///
    /// Tiles already on the device get theirs when they are sent again. Call [`Session::forget`] after a change: it
    /// makes the next frame whole. Without that, a session does not know that the scene now
    /// [reads](crate::mesh::MeshSink::reads) more, and its next frame of views fails.
    ///
    /// [`Session::forget`]: crate::parallel::Session::forget
    ///
    /// # Errors
    /// If the device runs out of memory. Nothing changes.
    pub fn keep_lattice(&mut self, keep: bool) -> Result<bool, RenderError> {
        let unit = keep.then_some(size_of::<CellPlace>() as u64);
        self.store.vertices.keep_companion(&self.gpu, Companion::Cells, unit)
    }

    /// Highlights a face of an instance from the next picture on. `None` removes the highlight, and so does a frame of
    /// another model. An unknown face or instance highlights nothing. The instance is a row of the scene, which shifts
    /// when [`Session::remove_instance`](crate::parallel::Session::remove_instance) removes one before it.
    pub fn highlight(&mut self, face: Option<(InstanceId, FaceId)>) {
        self.records.mark(face);
    }

    /// Size of this scene's buffers on the device, without the textures that pictures are drawn to.
    #[must_use]
    pub fn held(&self) -> DeviceMemory {
        let Store { vertices, indices, staging, .. } = &self.store;
        let lists: u64 = self.tiles.iter().map(Tiles::bytes).sum();
        DeviceMemory {
            vertices: vertices.bytes(),
            indices: indices.bytes(),
            edges: self.edges.bytes(),
            draws: self.record_rows.bytes() + lists + self.sights.bytes(),
            staging: staging.held(),
            pages: vertices.count() + indices.count(),
        }
    }

    /// Bytes of tiles that the last complete frame uploaded.
    #[must_use]
    pub fn uploaded(&self) -> u64 {
        self.uploaded
    }

    /// Clamps a view number. One past the last view of the frame draws everything.
    pub(super) fn known(&self, view: usize) -> usize {
        view.min(self.shown.drawn.views())
    }

    /// The camera in `options`, or one fitted to the scene.
    pub(super) fn camera(&self, options: &RenderOptions) -> Camera {
        let aspect = f64::from(options.size.0) / f64::from(options.size.1);
        options.camera.unwrap_or_else(|| ViewPoint::ISO.fit(self.shown.corners(), aspect))
    }

    /// Updates records, draw list and uniforms for a view. The bytes are those of all that was uploaded.
    pub(super) fn refresh(&mut self, view: usize, options: &RenderOptions, aim: &Aim<'_>) -> UploadedSight {
        let changed = self.records.refresh(&self.shown, options.colour_by);
        let mut bytes = self.record_rows.write(&self.gpu, &self.records, changed);
        while self.tiles.len() <= view {
            self.tiles.push(Tiles::new(&self.gpu));
        }
        bytes += self.tiles[view].refresh(&self.gpu, &self.shown, &self.records, view, self.version);
        let seen = self.sights.upload(&self.gpu, &self.shown, &self.record_rows, aim, options);
        UploadedSight { bytes: bytes + seen.bytes, ..seen }
    }

    /// Draws the tiles of a view that was refreshed.
    pub(super) fn draw_tiles(&self, pass: &mut RenderPass<'_>, view: usize) {
        encode_all(pass, self.tiles[view].draws(&self.store, self.record_rows.buffer()));
    }
}
