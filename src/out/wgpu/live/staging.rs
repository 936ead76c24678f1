//! Small writes to many buffers, batched into one upload and device-side copies.

use super::super::error::RenderError;
use super::super::gpu::Gpu;
use ::wgpu::{Buffer, BufferDescriptor, BufferUsages, CommandEncoderDescriptor};

/// Bytes gathered before a flush: some hundred tiles.
const CAPACITY: usize = 1 << 18;

/// Gathers writes in memory, uploads them to one buffer on the device, and copies them from there.
///
/// `Queue::write_buffer` allocates a staging buffer per call, which would cost more than the tile it uploads.
pub(super) struct Staging {
    inbox: Option<Buffer>,
    bytes: Vec<u8>,
    copies: Vec<Copy>,
    /// Bytes submitted since the last [`Staging::take_count`].
    count: u64,
}

struct Copy {
    to: Buffer,
    offset: u64,
    size: u64,
}

impl Staging {
    pub(super) fn new() -> Self {
        Self { inbox: None, bytes: Vec::new(), copies: Vec::new(), count: 0 }
    }

    /// Queues a write of `bytes` to `offset` of a buffer. Offset and length must be multiples of 4.
    pub(super) fn write(&mut self, gpu: &Gpu, to: &Buffer, offset: u64, bytes: &[u8]) -> Result<(), RenderError> {
        let mut at = offset;
        for piece in bytes.chunks(CAPACITY) {
            if self.bytes.len() + piece.len() > CAPACITY {
                self.flush(gpu)?;
            }
            self.bytes.extend_from_slice(piece);
            let size = piece.len() as u64;
            match self.copies.last_mut() {
                Some(last) if last.offset + last.size == at && last.to == *to => last.size += size,
                _ => self.copies.push(Copy { to: to.clone(), offset: at, size }),
            }
            at += size;
        }
        Ok(())
    }

    /// Submits all queued writes.
    pub(super) fn flush(&mut self, gpu: &Gpu) -> Result<(), RenderError> {
        if self.bytes.is_empty() {
            return Ok(());
        }
        let copies = std::mem::take(&mut self.copies);
        let flushed = gpu.checked(|device| {
            let inbox = self.inbox.get_or_insert_with(|| {
                device.create_buffer(&BufferDescriptor {
                    label: Some("trimtess inbox"),
                    size: CAPACITY as u64,
                    usage: BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                })
            });
            gpu.queue.write_buffer(inbox, 0, &self.bytes);
            let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
            let mut from = 0;
            for copy in &copies {
                encoder.copy_buffer_to_buffer(inbox, from, &copy.to, copy.offset, copy.size);
                from += copy.size;
            }
            gpu.queue.submit([encoder.finish()]);
        });
        self.count += self.bytes.len() as u64;
        self.bytes.clear();
        if flushed.is_err() {
            // It may be the buffer that failed.
            self.inbox = None;
        }
        flushed
    }

    /// Drops all queued writes, and counts from 0.
    pub(super) fn discard(&mut self) {
        self.bytes.clear();
        self.copies.clear();
        self.count = 0;
    }

    /// Returns the number of bytes submitted since the last call.
    pub(super) fn take_count(&mut self) -> u64 {
        std::mem::take(&mut self.count)
    }

    /// Size of the buffer on the device, in bytes.
    pub(super) fn held(&self) -> u64 {
        self.inbox.as_ref().map_or(0, Buffer::size)
    }
}
