//! Requested units to ranges of buffers: pages that never move, sub-allocated by Aaltonen's two-level bins.

use super::super::gpu::{Gpu, RenderError};
use ::wgpu::{Buffer, BufferDescriptor, BufferUsages};
use offset_allocator::{Allocation, Allocator};

/// What companion buffers hold per vertex.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Companion {
    /// Its place in the lattice.
    Cells,
    /// The number of its tile.
    Tiles,
}

/// A range of a page, in units.
#[derive(Clone, Copy)]
pub(super) struct Range {
    pub(super) page: u32,
    allocation: Allocation,
}

impl Range {
    /// Its first unit within the page.
    pub(super) fn start(&self) -> u32 {
        self.allocation.offset
    }
}

struct Page {
    buffer: Buffer,
    /// Companion buffers: as many units of other sizes.
    companions: [Option<Buffer>; 2],
    bytes: u64,
    allocator: Allocator,
    /// Number of allocated ranges.
    ranges: usize,
}

/// Buffers for one kind of content. Growing adds a page and leaves the others alone.
///
/// Each new page is half as large as all pages before it together, within bounds: few pages, and little spare space.
pub(super) struct Pages {
    label: &'static str,
    usage: BufferUsages,
    unit: u64,
    /// Units of the first page.
    first: u32,
    /// Page size over maximum number of ranges. Bookkeeping for more ranges would take more memory than it saves.
    per_range: u32,
    /// Bytes per unit of the companion buffers, by [`Companion`]; `None` without them.
    companions: [Option<u64>; 2],
    pages: Vec<Option<Page>>,
}

/// Largest page, except for a single larger range. Within the storage buffer binding size that every adapter supports.
const MOST_BYTES: u64 = 64 << 20;

impl Pages {
    /// Creates a set without pages. `unit` is in bytes and a multiple of 4, `first` and `per_range` in units.
    pub(super) fn new(label: &'static str, usage: BufferUsages, unit: u64, first: u32, per_range: u32) -> Self {
        Self {
            label,
            usage: usage | BufferUsages::COPY_DST,
            unit,
            first,
            per_range,
            companions: [None; 2],
            pages: Vec::new(),
        }
    }

    /// Adds companion buffers to a set without pages.
    pub(super) fn with(mut self, what: Companion, unit: Option<u64>) -> Self {
        self.companions[what as usize] = unit;
        self
    }

    /// Whether there are such companion buffers, or will be.
    pub(super) fn has_companion(&self, what: Companion) -> bool {
        self.companions[what as usize].is_some()
    }

    /// Adds a zeroed companion buffer to each page, with units of `unit` bytes (a multiple of 4), or removes them. If
    /// one fails, none changes.
    pub(super) fn keep_companion(
        &mut self,
        gpu: &Gpu,
        what: Companion,
        unit: Option<u64>,
    ) -> Result<bool, RenderError> {
        let kind = what as usize;
        if self.companions[kind] == unit {
            return Ok(false);
        }
        let companions = self.pages.iter().flatten().map(|page| self.new_companion(gpu, unit, page.bytes));
        let companions = companions.collect::<Result<Vec<_>, _>>()?;
        self.companions[kind] = unit;
        for (page, companion) in self.pages.iter_mut().flatten().zip(companions) {
            page.companions[kind] = companion;
        }
        Ok(true)
    }

    /// Creates a companion of a page of `bytes` bytes, with units of `unit` bytes. `None` without a unit.
    fn new_companion(&self, gpu: &Gpu, unit: Option<u64>, bytes: u64) -> Result<Option<Buffer>, RenderError> {
        unit.map(|unit| gpu.checked(|_| self.buffer_of(gpu, bytes / self.unit * unit))).transpose()
    }

    fn buffer_of(&self, gpu: &Gpu, size: u64) -> Buffer {
        gpu.device.create_buffer(&BufferDescriptor {
            label: Some(self.label),
            size,
            usage: self.usage,
            mapped_at_creation: false,
        })
    }

    /// Allocates `units` (above 0). The contents are unspecified.
    pub(super) fn allocate(&mut self, gpu: &Gpu, units: u32) -> Result<Range, RenderError> {
        for (number, page) in self.pages.iter_mut().enumerate() {
            let Some(page) = page else { continue };
            if let Some(allocation) = page.allocator.allocate(units) {
                page.ranges += 1;
                return Ok(Range { page: number as u32, allocation });
            }
        }
        let most = (MOST_BYTES / self.unit) as u32;
        let bytes: u64 = self.pages.iter().flatten().map(|page| page.bytes).sum();
        let half = (bytes / self.unit / 2).min(u64::from(most)) as u32;
        let size = findable(half.clamp(self.first, most).max(units));
        let bytes = u64::from(size) * self.unit;
        let limits = gpu.device.limits();
        let storage = self.usage.contains(BufferUsages::STORAGE);
        let bound = if storage { limits.max_storage_buffer_binding_size } else { u64::MAX };
        let limit = limits.max_buffer_size.min(bound);
        let too_large = || RenderError::Device(format!("{} of {bytes} bytes; the device takes {limit}", self.label));
        if bytes > limit {
            return Err(too_large());
        }
        let buffer = gpu.checked(|_| self.buffer_of(gpu, bytes))?;
        let companion = |what: Companion| self.new_companion(gpu, self.companions[what as usize], bytes);
        let companions = [companion(Companion::Cells)?, companion(Companion::Tiles)?];
        let mut allocator = Allocator::with_max_allocs(size, (size / self.per_range).max(64));
        let allocation = allocator.allocate(units).ok_or_else(too_large)?;
        let page = Some(Page { buffer, companions, bytes, allocator, ranges: 1 });
        let number = self.pages.iter().position(Option::is_none).unwrap_or_else(|| {
            self.pages.push(None);
            self.pages.len() - 1
        });
        self.pages[number] = page;
        Ok(Range { page: number as u32, allocation })
    }

    /// Frees a range. Submitted draws may still read it: the device executes in order, so later writes come after them.
    /// One empty page is kept, so that small changes in size do not create and drop pages.
    pub(super) fn free(&mut self, range: Range) {
        if let Some(page) = &mut self.pages[range.page as usize] {
            page.allocator.free(range.allocation);
            page.ranges -= 1;
            if page.ranges > 0 {
                return;
            }
        }
        let is_empty = |page: &Option<Page>| page.as_ref().is_some_and(|page| page.ranges == 0);
        if self.pages.iter().filter(|page| is_empty(page)).count() > 1 {
            self.pages[range.page as usize] = None;
        }
    }

    /// The buffer of a page that has ranges.
    pub(super) fn buffer(&self, page: u32) -> &Buffer {
        &self.pages[page as usize].as_ref().expect("a page with ranges exists").buffer
    }

    /// The companion buffer of a range, and the range's byte offset there.
    pub(super) fn companion_at(&self, what: Companion, range: &Range) -> Option<(&Buffer, u64)> {
        let buffer = self.companion_of_page(what, range.page)?;
        Some((buffer, u64::from(range.start()) * self.companions[what as usize]?))
    }

    /// The companion buffer of a page.
    pub(super) fn companion_of_page(&self, what: Companion, page: u32) -> Option<&Buffer> {
        self.pages[page as usize].as_ref()?.companions[what as usize].as_ref()
    }

    /// Byte offset of a range in its buffer.
    pub(super) fn offset(&self, range: &Range) -> u64 {
        u64::from(range.start()) * self.unit
    }

    /// Bytes of all pages and their companions.
    pub(super) fn bytes(&self) -> u64 {
        let of = |page: &Page| page.bytes + page.companions.iter().flatten().map(Buffer::size).sum::<u64>();
        self.pages.iter().flatten().map(of).sum()
    }

    /// Number of pages.
    pub(super) fn count(&self) -> usize {
        self.pages.iter().flatten().count()
    }
}

/// Rounds up to four significant bits, like the bins of the allocator: a page of such a size can be allocated whole.
fn findable(units: u32) -> u32 {
    let shift = units.checked_ilog2().unwrap_or(0).saturating_sub(3);
    (units.div_ceil(1 << shift)) << shift
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_of_any_size_can_be_allocated_whole() {
        for units in (1..5_000).chain([65_537, 1_000_003, 4_194_304, 16_000_001]) {
            let size = findable(units);
            assert!(size >= units && size <= units + units / 8 + 1, "{units} {size}");
            assert!(Allocator::<u32>::with_max_allocs(size, 64).allocate(size).is_some(), "{units} {size}");
        }
    }
}
