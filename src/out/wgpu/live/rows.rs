//! Arrays in buffers, and bind groups.

use super::super::gpu::Gpu;
use ::wgpu::{BindGroup, BindingResource, Buffer, BufferDescriptor, BufferUsages};
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
