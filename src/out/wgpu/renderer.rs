//! A frame in memory to an image: upload, draw, read back.

use super::gpu::{Gpu, NoAdapter, RenderError, open_adapter};
use super::image::{texture, whole};
use super::live::{DrawStats, LiveScene};
use super::pipelines::COLOUR_FORMAT;
use super::{Image, RenderOptions};
use crate::mesh::{DrawnTiles, FrameView, MemorySink, MeshSink, SinkError};
use crate::out::placed::placed;
use crate::view::ViewPoint;
use ::wgpu::TextureUsages;

/// A graphics device with its pipelines. Create it once and draw any number of pictures.
#[derive(Debug)]
pub struct Renderer {
    gpu: Gpu,
    info: ::wgpu::AdapterInfo,
}

impl Renderer {
    /// Opens the best adapter: hardware if any, else software. Takes tenths of a second.
    ///
    /// # Errors
    /// If no adapter is usable. The message says what to install.
    pub fn new() -> Result<Self, NoAdapter> {
        let (gpu, info) = open_adapter()?;
        Ok(Self { gpu, info })
    }

    /// Name of the adapter and its graphics API.
    #[must_use]
    pub fn adapter(&self) -> String {
        format!("{} ({})", self.info.name, self.info.backend)
    }

    /// The device, for the caller's own drawing.
    #[must_use]
    pub fn device(&self) -> &::wgpu::Device {
        &self.gpu.device
    }

    /// Its queue.
    #[must_use]
    pub fn queue(&self) -> &::wgpu::Queue {
        &self.gpu.queue
    }

    /// Creates an empty scene on this device, to be drawn by [`picture`](Self::picture).
    #[must_use]
    pub fn live(&self) -> LiveScene {
        LiveScene::with(self.gpu.clone())
    }

    /// Draws one view of a scene created by [`live`](Self::live) and waits for the picture.
    ///
    /// # Errors
    /// See [`LiveScene::draw`].
    pub fn picture(
        &self,
        scene: &mut LiveScene,
        view: usize,
        options: &RenderOptions,
    ) -> Result<(Image, DrawStats), RenderError> {
        self.gpu.takes(options.size)?;
        let target =
            self.gpu.checked(|_| texture(&self.gpu, options.size, COLOUR_FORMAT, 1, TextureUsages::COPY_SRC))?;
        let drew = scene.draw(&whole(&target), view, options)?;
        Ok((Image::read(&self.gpu.device, &self.gpu.queue, &target)?, drew))
    }

    /// Draws a frame: every instance, with the tiles of the frame's first view.
    ///
    /// Colours are drawn opaque; alpha is ignored. Without a camera in `options`, one is fitted to the vertices.
    ///
    /// # Errors
    /// If the picture is larger than the adapter allows, or the device fails.
    pub fn render(&self, frame: &MemorySink, options: &RenderOptions) -> Result<Image, RenderError> {
        let mut scene = self.live();
        scene.keep_lattice(options.lattice)?;
        let sent = send(frame, &mut scene);
        sent.map_err(|error| RenderError::Device(error.cause.to_string()))?;
        let aspect = f64::from(options.size.0) / f64::from(options.size.1.max(1));
        let camera = options.camera.unwrap_or_else(|| {
            let whole = FrameView::from(frame);
            let batches = whole.batches_by_part();
            let points = placed(&whole, &batches).flat_map(|(_, placement, batches)| {
                let points = batches.iter().flat_map(|batch| batch.mesh.positions);
                points.map(move |&point| placement.position(point))
            });
            ViewPoint::ISO.fit(points, aspect)
        });
        let options = RenderOptions { camera: Some(camera), ..*options };
        self.picture(&mut scene, 0, &options).map(|(image, _)| image)
    }
}

fn send(frame: &MemorySink, scene: &mut LiveScene) -> Result<(), SinkError> {
    scene.begin(&frame.scene)?;
    frame.batches.iter().try_for_each(|batch| scene.add(batch))?;
    frame.edge_lines.iter().try_for_each(|line| scene.add_line(line))?;
    scene.drawn(&frame.drawn, &DrawnTiles::NONE)?;
    scene.end()
}
