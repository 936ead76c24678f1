//! Records on the device: a buffer with a row per draw, or textures where the tiles of an instance are one draw.

use super::super::formats::{COLOUR_ROW_FORMAT, FIRST_ROW_FORMAT};
use super::super::gpu::Gpu;
use super::records::Records;
use super::rows::{Rows, bind};
use super::texels::Texels;
use ::wgpu::{BindGroup, BindingResource, Buffer, BufferUsages};
use std::ops::Range;

/// Records on the device.
pub(super) enum RecordRows {
    /// Read as an attribute of the draw.
    PerDraw(Rows),
    /// Read by the instance's first row and the tile of the vertex.
    Merged(Box<RecordTexels>),
}

/// Colours by row, and the first row of each place.
pub(super) struct RecordTexels {
    colours: Texels,
    firsts: Texels,
    group: Option<BindGroup>,
}

impl RecordRows {
    pub(super) fn new(gpu: &Gpu) -> Self {
        if gpu.indirect {
            return Self::PerDraw(Rows::new(BufferUsages::VERTEX));
        }
        let (colours, firsts) = (Texels::new(COLOUR_ROW_FORMAT), Texels::new(FIRST_ROW_FORMAT));
        Self::Merged(Box::new(RecordTexels { colours, firsts, group: None }))
    }

    /// Uploads the `changed` records. Returns the number of bytes uploaded.
    pub(super) fn write(&mut self, gpu: &Gpu, records: &Records, changed: Range<usize>) -> u64 {
        match self {
            Self::PerDraw(rows) => rows.write(gpu, &records.rows, changed),
            Self::Merged(_) if changed.is_empty() => 0,
            Self::Merged(texels) => {
                let RecordTexels { colours, firsts, group } = &mut **texels;
                let row_colours: Vec<[u8; 4]> = records.rows.iter().map(|record| record.colour).collect();
                let bytes = colours.write(gpu, &row_colours, changed)
                    + firsts.write(gpu, &records.firsts, 0..records.firsts.len());
                let views = [colours.view(), firsts.view()].into_iter().flatten().map(BindingResource::TextureView);
                *group = gpu.pipelines.records.as_ref().map(|layout| bind(gpu, layout, views.collect()));
                bytes
            }
        }
    }

    /// The buffer of [`PerDraw`](Self::PerDraw).
    pub(super) fn buffer(&self) -> Option<&Buffer> {
        match self {
            Self::PerDraw(rows) => rows.buffer(),
            Self::Merged(_) => None,
        }
    }

    /// The bind group of [`Merged`](Self::Merged).
    pub(super) fn group(&self) -> Option<&BindGroup> {
        match self {
            Self::PerDraw(_) => None,
            Self::Merged(texels) => texels.group.as_ref(),
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        match self {
            Self::PerDraw(rows) => rows.bytes(),
            Self::Merged(texels) => texels.colours.bytes() + texels.firsts.bytes(),
        }
    }
}
