//! Textures that are drawn to, and their pixels back in memory.

use super::{Image, RenderError};

/// Shaders write linear light; the target encodes and resolves it.
pub(super) const COLOUR_FORMAT: ::wgpu::TextureFormat = ::wgpu::TextureFormat::Rgba8UnormSrgb;
/// Floating point: with reversed depth its precision lies where perspective needs it.
pub(super) const DEPTH_FORMAT: ::wgpu::TextureFormat = ::wgpu::TextureFormat::Depth32Float;
/// What every adapter offers, and enough for smooth edges.
pub(super) const SAMPLES: u32 = 4;

pub(super) struct Target {
    size: ::wgpu::Extent3d,
    resolved: ::wgpu::Texture,
    pub(super) samples: ::wgpu::TextureView,
    pub(super) depth: ::wgpu::TextureView,
    pub(super) image: ::wgpu::TextureView,
}

impl Target {
    pub(super) fn new(device: &::wgpu::Device, width: u32, height: u32) -> Self {
        let size = ::wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let texture = |format, sample_count, usage| {
            device.create_texture(&::wgpu::TextureDescriptor {
                label: Some("picture"),
                size,
                mip_level_count: 1,
                sample_count,
                dimension: ::wgpu::TextureDimension::D2,
                format,
                usage: ::wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            })
        };
        let view = |texture: &::wgpu::Texture| texture.create_view(&::wgpu::TextureViewDescriptor::default());
        let resolved = texture(COLOUR_FORMAT, 1, ::wgpu::TextureUsages::COPY_SRC);
        Self {
            size,
            samples: view(&texture(COLOUR_FORMAT, SAMPLES, ::wgpu::TextureUsages::empty())),
            depth: view(&texture(DEPTH_FORMAT, SAMPLES, ::wgpu::TextureUsages::empty())),
            image: view(&resolved),
            resolved,
        }
    }

    /// Waits for everything submitted, then copies the resolved picture.
    pub(super) fn read_back(&self, device: &::wgpu::Device, queue: &::wgpu::Queue) -> Result<Image, RenderError> {
        let ::wgpu::Extent3d { width, height, .. } = self.size;
        let row = 4 * width;
        let padded = row.next_multiple_of(::wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = device.create_buffer(&::wgpu::BufferDescriptor {
            label: Some("pixels"),
            size: u64::from(padded) * u64::from(height),
            usage: ::wgpu::BufferUsages::COPY_DST | ::wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&::wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_buffer(
            self.resolved.as_image_copy(),
            ::wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: ::wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: None },
            },
            self.size,
        );
        queue.submit([encoder.finish()]);
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.map_async(::wgpu::MapMode::Read, .., move |result| {
            // The receiver outlives the wait below.
            let _ = sender.send(result);
        });
        let failed = |cause: &dyn std::fmt::Display| RenderError::Device(cause.to_string());
        device.poll(::wgpu::PollType::wait_indefinitely()).map_err(|error| failed(&error))?;
        receiver.recv().map_err(|error| failed(&error))?.map_err(|error| failed(&error))?;
        let rows = buffer.get_mapped_range(..).map_err(|error| failed(&error))?;
        let mut pixels = Vec::with_capacity(row as usize * height as usize);
        for line in rows.chunks(padded as usize) {
            pixels.extend_from_slice(&line[..row as usize]);
        }
        Ok(Image { width, height, pixels })
    }
}
