//! Textures to draw to, and reading their pixels back.

use super::error::RenderError;
use super::formats::{DEPTH_FORMAT, SAMPLES};
use super::gpu::{Gpu, checked};
use ::wgpu::{Extent3d, Texture, TextureFormat, TextureUsages, TextureView};

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

/// Waits for all submitted work, then reads the pixels of a texture, `bytes` each, row by row from the top.
pub(super) fn read_back(
    device: &::wgpu::Device,
    queue: &::wgpu::Queue,
    texture: &Texture,
    bytes: u32,
) -> Result<Vec<u8>, RenderError> {
    let Extent3d { width, height, .. } = texture.size();
    let row = bytes * width;
    let padded = row.next_multiple_of(::wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = checked(device, |device| {
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
    Ok(pixels)
}
