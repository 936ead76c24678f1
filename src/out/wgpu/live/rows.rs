//! Arrays on the device, in buffers and in textures, and bind groups.

use super::super::gpu::Gpu;
use ::wgpu::{
    BindGroup, BindingResource, Buffer, BufferDescriptor, BufferUsages, Extent3d, Origin3d, TexelCopyBufferLayout,
    Texture, TextureFormat, TextureUsages, TextureView, TextureViewDescriptor,
};
use bytemuck::Pod;
use std::ops::Range;

/// An array on the device that mirrors one in memory. Its capacity grows to powers of two.
pub(super) struct Rows {
    usage: BufferUsages,
    buffer: Option<Buffer>,
}

impl Rows {
    pub(super) fn new(usage: BufferUsages) -> Self {
        Self { usage, buffer: None }
    }

    /// Uploads the `changed` rows, or all rows if the buffer had to grow. Returns the number of bytes uploaded.
    pub(super) fn write<T: Pod>(&mut self, gpu: &Gpu, rows: &[T], changed: Range<usize>) -> u64 {
        let bytes: &[u8] = bytemuck::cast_slice(rows);
        let fits = self.buffer.as_ref().is_some_and(|buffer| buffer.size() >= bytes.len() as u64);
        let changed = if fits { changed } else { 0..rows.len() };
        if !fits {
            self.buffer = Some(gpu.device.create_buffer(&BufferDescriptor {
                label: Some("trimtess rows"),
                size: (bytes.len() as u64).next_power_of_two().max(256),
                usage: self.usage | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }));
        }
        let changed = changed.start * size_of::<T>()..changed.end * size_of::<T>();
        if let Some(buffer) = self.buffer.as_ref().filter(|_| !changed.is_empty()) {
            gpu.queue.write_buffer(buffer, changed.start as u64, &bytes[changed.clone()]);
        }
        changed.len() as u64
    }

    /// The buffer. `None` before the first write.
    pub(super) fn buffer(&self) -> Option<&Buffer> {
        self.buffer.as_ref()
    }

    pub(super) fn bytes(&self) -> u64 {
        self.buffer.as_ref().map_or(0, Buffer::size)
    }
}

/// Creates a bind group of resources, bound in order.
pub(super) fn bind(gpu: &Gpu, layout: &::wgpu::BindGroupLayout, resources: Vec<BindingResource<'_>>) -> BindGroup {
    let entries = resources.into_iter().enumerate();
    let entries = entries.map(|(binding, resource)| ::wgpu::BindGroupEntry { binding: binding as u32, resource });
    let entries: Vec<_> = entries.collect();
    gpu.device.create_bind_group(&::wgpu::BindGroupDescriptor { label: Some("trimtess"), layout, entries: &entries })
}

/// Texels of a row of the texture, as in the shader. No device has narrower textures.
const WIDTH: usize = 2048;

/// An array on the device, a texel per element, row by row. Its capacity grows to powers of two rows.
pub(super) struct Texels {
    format: TextureFormat,
    texture: Option<(Texture, TextureView)>,
}

impl Texels {
    pub(super) fn new(format: TextureFormat) -> Self {
        Self { format, texture: None }
    }

    /// Uploads the `changed` texels with the rest of their rows, or all if the texture had to grow. Returns the number
    /// of bytes uploaded. An empty array has one texel, to be bound.
    pub(super) fn write<T: Pod + Default>(&mut self, gpu: &Gpu, texels: &[T], changed: Range<usize>) -> u64 {
        let rows = texels.len().div_ceil(WIDTH).max(1);
        let fits = self.texture.as_ref().is_some_and(|(texture, _)| texture.height() as usize >= rows);
        let changed = if fits { changed } else { 0..texels.len() };
        if !fits {
            let texture = gpu.device.create_texture(&::wgpu::TextureDescriptor {
                label: Some("trimtess texels"),
                size: extent(WIDTH, rows.next_power_of_two()),
                mip_level_count: 1,
                sample_count: 1,
                dimension: ::wgpu::TextureDimension::D2,
                format: self.format,
                usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
                view_formats: &[],
            });
            let view = texture.create_view(&TextureViewDescriptor::default());
            self.texture = Some((texture, view));
        }
        let Some((texture, _)) = self.texture.as_ref().filter(|_| !changed.is_empty()) else { return 0 };
        let mut bytes = 0;
        let mut write = |row: usize, texels: &[T], width: usize| {
            let size = extent(width, texels.len() / width);
            let layout = TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some((width * size_of::<T>()) as u32),
                rows_per_image: None,
            };
            let origin = Origin3d { x: 0, y: row as u32, z: 0 };
            let to = ::wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() };
            gpu.queue.write_texture(to, bytemuck::cast_slice(texels), layout, size);
            bytes += size_of_val(texels) as u64;
        };
        let (first, end) = (changed.start / WIDTH, changed.end.div_ceil(WIDTH));
        let whole = end.min(texels.len() / WIDTH).max(first);
        if whole > first {
            write(first, &texels[first * WIDTH..whole * WIDTH], WIDTH);
        }
        if end > whole {
            let last = &texels[whole * WIDTH..];
            write(whole, last, last.len());
        }
        bytes
    }

    /// The texture. `None` before the first write.
    pub(super) fn view(&self) -> Option<&TextureView> {
        self.texture.as_ref().map(|(_, view)| view)
    }

    pub(super) fn bytes(&self) -> u64 {
        let of = |(texture, _): &(Texture, TextureView)| {
            let texel = self.format.block_copy_size(None).unwrap_or_default();
            u64::from(texture.width()) * u64::from(texture.height()) * u64::from(texel)
        };
        self.texture.as_ref().map_or(0, of)
    }
}

fn extent(width: usize, height: usize) -> Extent3d {
    Extent3d { width: width as u32, height: height as u32, depth_or_array_layers: 1 }
}
