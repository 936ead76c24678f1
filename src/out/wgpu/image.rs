//! Textures to draw to, and pictures read back from them.

use super::gpu::{Gpu, RenderError, Scopes};
use super::pipelines::{DEPTH_FORMAT, SAMPLES};
use crate::mesh::SinkError;
use crate::out::pending::write_whole;
use ::wgpu::{
    CommandEncoder, Extent3d, LoadOp, Operations, RenderPass, RenderPassColorAttachment, StoreOp, Texture,
    TextureFormat, TextureUsages, TextureView,
};
use std::fmt;
use std::io::{self, Write};
use std::path::Path;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// Creates a texture to draw to, with one mip level.
pub(super) fn texture(
    gpu: &Gpu,
    (width, height): (u32, u32),
    format: TextureFormat,
    samples: u32,
    usage: TextureUsages,
) -> Texture {
    gpu.device.create_texture(&::wgpu::TextureDescriptor {
        label: Some("picture"),
        size: Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: samples,
        dimension: ::wgpu::TextureDimension::D2,
        format,
        usage: TextureUsages::RENDER_ATTACHMENT | usage,
        view_formats: &[],
    })
}

/// A view of the whole texture.
pub(super) fn whole(texture: &Texture) -> TextureView {
    texture.create_view(&::wgpu::TextureViewDescriptor::default())
}

/// Begins a pass with one colour target. Depth is reversed: it starts at 0, and is not kept.
pub(super) fn begin_pass<'a>(
    encoder: &'a mut CommandEncoder,
    label: &str,
    colour: RenderPassColorAttachment<'_>,
    depth: &TextureView,
) -> RenderPass<'a> {
    encoder.begin_render_pass(&::wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(colour)],
        depth_stencil_attachment: Some(::wgpu::RenderPassDepthStencilAttachment {
            view: depth,
            depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Discard }),
            stencil_ops: None,
        }),
        ..::wgpu::RenderPassDescriptor::default()
    })
}

/// Multisampled colour and depth targets.
pub(super) struct SampleTargets {
    pub(super) size: (u32, u32),
    pub(super) colour: TextureView,
    pub(super) depth: TextureView,
}

impl SampleTargets {
    pub(super) fn new(gpu: &Gpu, size: (u32, u32)) -> Self {
        let of = |format| whole(&texture(gpu, size, format, SAMPLES, TextureUsages::empty()));
        Self { size, colour: of(gpu.format), depth: of(DEPTH_FORMAT) }
    }
}

/// The pixels of a texture on their way from the device.
pub(super) struct Reading {
    buffer: ::wgpu::Buffer,
    mapped: Receiver<Result<(), ::wgpu::BufferAsyncError>>,
    /// Bytes of a row of pixels, and from one row to the next.
    row: [u32; 2],
}

impl Reading {
    /// Begins to read the pixels of a texture, `bytes` each.
    pub(super) fn begin(
        device: &::wgpu::Device,
        queue: &::wgpu::Queue,
        texture: &Texture,
        bytes: u32,
    ) -> Result<Self, RenderError> {
        let Extent3d { width, height, .. } = texture.size();
        let row = bytes * width;
        let padded = row.next_multiple_of(::wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let (sender, mapped) = channel();
        let buffer = Scopes::default().checked(device, |device| {
            let buffer = device.create_buffer(&::wgpu::BufferDescriptor {
                label: Some("pixels"),
                size: u64::from(padded) * u64::from(height),
                usage: ::wgpu::BufferUsages::COPY_DST | ::wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            });
            let layout = ::wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: None };
            let mut encoder = device.create_command_encoder(&::wgpu::CommandEncoderDescriptor::default());
            encoder.copy_texture_to_buffer(
                texture.as_image_copy(),
                ::wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
                texture.size(),
            );
            queue.submit([encoder.finish()]);
            buffer
        })?;
        buffer.map_async(::wgpu::MapMode::Read, .., move |result| {
            // The caller may have dropped the receiver.
            let _ = sender.send(result);
        });
        Ok(Self { buffer, mapped, row: [row, padded] })
    }

    /// The pixels, row by row from the top, if they have arrived. `None` until then. Does not wait.
    pub(super) fn poll(&self, device: &::wgpu::Device) -> Option<Result<Vec<u8>, RenderError>> {
        if let Err(error) = device.poll(::wgpu::PollType::Poll) {
            return Some(Err(failed(&error)));
        }
        match self.mapped.try_recv() {
            Ok(mapped) => Some(mapped.map_err(|error| failed(&error)).and_then(|()| self.pixels())),
            Err(TryRecvError::Empty) => None,
            Err(gone @ TryRecvError::Disconnected) => Some(Err(failed(&gone))),
        }
    }

    /// Waits for all submitted work, and returns the pixels.
    pub(super) fn wait(&self, device: &::wgpu::Device) -> Result<Vec<u8>, RenderError> {
        device.poll(::wgpu::PollType::wait_indefinitely()).map_err(|error| failed(&error))?;
        self.mapped.recv().map_err(|error| failed(&error))?.map_err(|error| failed(&error))?;
        self.pixels()
    }

    fn pixels(&self) -> Result<Vec<u8>, RenderError> {
        let [row, padded] = self.row.map(|bytes| bytes as usize);
        let rows = self.buffer.get_mapped_range(..).map_err(|error| failed(&error))?;
        Ok(rows.chunks(padded).flat_map(|line| &line[..row]).copied().collect())
    }
}

fn failed(cause: &dyn std::fmt::Display) -> RenderError {
    RenderError::Device(cause.to_string())
}

/// A picture on its way from the device.
pub struct ImageReading {
    device: ::wgpu::Device,
    size: (u32, u32),
    of: Reading,
}

impl ImageReading {
    /// The picture, if it has arrived; `None` until then. Does not wait. Not to be called again after an answer.
    ///
    /// # Errors
    /// If the device fails.
    pub fn poll(&self) -> Option<Result<Image, RenderError>> {
        let (width, height) = self.size;
        Some(self.of.poll(&self.device)?.map(|pixels| Image { width, height, pixels }))
    }
}

impl fmt::Debug for ImageReading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ImageReading").field("size", &self.size).finish_non_exhaustive()
    }
}

/// A picture in memory.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Image {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue (sRGB) and alpha, row by row from the top left: 4 × width × height bytes.
    pub pixels: Vec<u8>,
}

impl Image {
    /// Reads a texture of four bytes per pixel back from the device, after waiting for all submitted work.
    /// The texture needs `COPY_SRC` usage.
    ///
    /// # Errors
    /// If the device fails, or cannot copy the texture.
    pub fn read(
        device: &::wgpu::Device,
        queue: &::wgpu::Queue,
        texture: &::wgpu::Texture,
    ) -> Result<Self, RenderError> {
        let ::wgpu::Extent3d { width, height, .. } = texture.size();
        Ok(Self { width, height, pixels: Reading::begin(device, queue, texture, 4)?.wait(device)? })
    }

    /// Begins to [`read`](Self::read) a texture, without waiting. Browsers let no caller wait.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn begin_read(
        device: &::wgpu::Device,
        queue: &::wgpu::Queue,
        texture: &::wgpu::Texture,
    ) -> Result<ImageReading, RenderError> {
        let ::wgpu::Extent3d { width, height, .. } = texture.size();
        Ok(ImageReading {
            device: device.clone(),
            size: (width, height),
            of: Reading::begin(device, queue, texture, 4)?,
        })
    }

    /// The pixel `x` from the left and `y` from the top. `None` outside of the picture.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> Option<[u8; 4]> {
        let at = 4 * (y as usize * self.width as usize + x as usize);
        let inside = x < self.width && y < self.height;
        inside.then(|| self.pixels.get(at..at + 4)?.try_into().ok()).flatten()
    }

    /// Writes a PNG file atomically.
    ///
    /// # Errors
    /// If the file cannot be created, written or renamed, or the length of `pixels` does not match `width` and
    /// `height`.
    pub fn write_png(&self, path: &Path) -> Result<(), SinkError> {
        write_whole(path, |file| self.encode(file))
    }

    /// Writes a PNG to `file`.
    ///
    /// # Errors
    /// I/O errors of `file`, or a length of `pixels` that does not match `width` and `height`.
    pub fn encode(&self, file: impl Write) -> io::Result<()> {
        let mut encoder = png::Encoder::new(file, self.width, self.height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.pixels)?;
        writer.finish()?;
        Ok(())
    }
}
