//! Records on the device: a buffer with a row per draw, or a texture where tiles are merged.

use super::super::formats::{INSTANCE_FORMAT, RECORD_FORMAT};
use super::super::gpu::Gpu;
use super::super::layout::Record;
use super::records::Records;
use super::rows::Rows;
use super::texels::Texels;
use ::wgpu::{Buffer, BufferUsages, TextureView};
use std::ops::Range;

/// Records on the device, and what is known of instances.
pub(super) struct RecordRows {
    rows: RowsOfTiles,
    instances: Texels,
    /// [`Records::layout`] that `instances` has; `None` before the first.
    layout: Option<u64>,
}

enum RowsOfTiles {
    /// Read as an attribute of the draw.
    PerDraw(Rows),
    /// Colours and faces, read by the instance's first row and the tile of the vertex.
    Merged(Texels),
}

impl RecordRows {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let rows = if gpu.indirect {
            RowsOfTiles::PerDraw(Rows::new(BufferUsages::VERTEX))
        } else {
            RowsOfTiles::Merged(Texels::new(RECORD_FORMAT))
        };
        Self { rows, instances: Texels::new(INSTANCE_FORMAT), layout: None }
    }

    /// Uploads the `changed` records, and instances if any changed. Returns the number of bytes uploaded.
    pub(super) fn write(&mut self, gpu: &Gpu, records: &Records, changed: Range<usize>) -> u64 {
        let mut bytes = 0;
        if self.layout.replace(records.layout) != Some(records.layout) {
            bytes += self.instances.write(gpu, &records.instances, 0..records.instances.len());
        }
        bytes += match &mut self.rows {
            RowsOfTiles::PerDraw(rows) => rows.write(gpu, &records.rows, changed),
            RowsOfTiles::Merged(texels) if changed.is_empty() && texels.view().is_some() => 0,
            RowsOfTiles::Merged(texels) => {
                let row = |record: &Record| [u32::from_le_bytes(record.colour), record.face];
                let rows: Vec<[u32; 2]> = records.rows.iter().map(row).collect();
                texels.write(gpu, &rows, changed)
            }
        };
        bytes
    }

    /// The records of draws, a vertex buffer. `None` where tiles are merged.
    pub(super) fn buffer(&self) -> Option<&Buffer> {
        match &self.rows {
            RowsOfTiles::PerDraw(rows) => rows.buffer(),
            RowsOfTiles::Merged(_) => None,
        }
    }

    /// What is bound: instances, and records where tiles are merged.
    pub(super) fn views(&self) -> impl Iterator<Item = &TextureView> {
        let records = match &self.rows {
            RowsOfTiles::PerDraw(_) => None,
            RowsOfTiles::Merged(texels) => texels.view(),
        };
        self.instances.view().into_iter().chain(records)
    }

    pub(super) fn bytes(&self) -> u64 {
        let rows = match &self.rows {
            RowsOfTiles::PerDraw(rows) => rows.bytes(),
            RowsOfTiles::Merged(texels) => texels.bytes(),
        };
        rows + self.instances.bytes()
    }
}
