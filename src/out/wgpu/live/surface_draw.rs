//! A draw command of surfaces: what to bind, and what to call.

use ::wgpu::{Buffer, IndexFormat, RenderPass};
use std::ops::Range;

/// One draw command of a scene's surfaces, for the caller's passes and render bundles. Its pipeline has the layouts
/// of [`SurfaceInput`](crate::out::wgpu::SurfaceInput), bind group 0 is
/// [`SceneInPass::bind_group`](super::SceneInPass::bind_group). Valid until the next frame ends or an instance is hidden
/// or shown.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SurfaceDraw<'a> {
    /// Vertex buffers 0 and 1, from their beginning.
    pub vertices: [&'a Buffer; 2],
    /// The index buffer, from its beginning.
    pub indices: &'a Buffer,
    /// Width of the indices.
    pub format: IndexFormat,
    /// The call.
    pub call: DrawCall<'a>,
    /// Page of `vertices[0]`.
    pub(super) page: u32,
}

/// The call of a [`SurfaceDraw`].
#[derive(Clone, Debug)]
pub enum DrawCall<'a> {
    /// `multi_draw_indexed_indirect`, a draw per tile of each instance. Render bundles take them one by one, by
    /// `draw_indexed_indirect`.
    Indirect {
        /// The draws, of 20 bytes each.
        draws: &'a Buffer,
        /// Bytes before the first of this call.
        offset: u64,
        /// Number of draws.
        count: u32,
    },
    /// `draw_indexed` without a base vertex: all tiles of a part that are in a page, for instances that show the same.
    Direct {
        /// Range of the index buffer.
        indices: Range<u32>,
        /// Range of instances, which shaders need as it is.
        instances: Range<u32>,
    },
}

impl SurfaceDraw<'_> {
    /// Sets what has changed since the draw `before`, and calls.
    pub(super) fn encode(&self, pass: &mut RenderPass<'_>, before: Option<&Self>) {
        for (slot, buffer) in self.vertices.into_iter().enumerate() {
            if before.is_none_or(|before| before.vertices[slot] != buffer) {
                pass.set_vertex_buffer(slot as u32, buffer.slice(..));
            }
        }
        if before.is_none_or(|before| before.indices != self.indices || before.format != self.format) {
            pass.set_index_buffer(self.indices.slice(..), self.format);
        }
        match &self.call {
            DrawCall::Indirect { draws, offset, count } => pass.multi_draw_indexed_indirect(draws, *offset, *count),
            DrawCall::Direct { indices, instances } => pass.draw_indexed(indices.clone(), 0, instances.clone()),
        }
    }
}

/// Encodes draws one after the other.
pub(super) fn encode_all<'a>(pass: &mut RenderPass<'_>, draws: impl Iterator<Item = SurfaceDraw<'a>>) {
    let mut before = None;
    for draw in draws {
        draw.encode(pass, before.as_ref());
        before = Some(draw);
    }
}
