//! Pieces for many buffers to one write and a copy each: the way of changed tiles onto the device.

use super::super::error::RenderError;
use super::super::gpu::Gpu;
use ::wgpu::{Buffer, BufferDescriptor, BufferUsages, CommandEncoderDescriptor};

/// What is gathered before it goes: some hundred tiles.
const CAPACITY: usize = 1 << 18;

/// Bytes on their way. They are gathered in memory, written at once into a buffer of the device, and copied from there: the
/// queue makes (and takes back) a staging buffer for each write, so a write for each tile would cost more than the tile.
pub(super) struct Staging {
    inbox: Option<Buffer>,
    bytes: Vec<u8>,
    copies: Vec<Copy>,
    /// Bytes handed over since the last [`Staging::take_count`].
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

    /// Puts `bytes` on their way to `offset` of a buffer; both multiples of 4.
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

    /// Submits what is under way.
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
        flushed
    }

    /// Forgets what has not been submitted.
    pub(super) fn discard(&mut self) {
        self.bytes.clear();
        self.copies.clear();
    }

    /// Bytes submitted since this was last asked.
    pub(super) fn take_count(&mut self) -> u64 {
        std::mem::take(&mut self.count)
    }

    /// Bytes of the device's buffer.
    pub(super) fn held(&self) -> u64 {
        self.inbox.as_ref().map_or(0, Buffer::size)
    }
}
