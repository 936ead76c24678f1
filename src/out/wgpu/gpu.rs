//! A graphics device, owned or the caller's, with the pipelines that all drawing on it shares.

use super::error::RenderError;
use super::pipelines::Pipelines;
use super::scopes::Scopes;
use std::sync::Arc;

/// Device, queue and pipelines. Cheap to clone: clones share everything.
#[derive(Clone, Debug)]
pub(super) struct Gpu {
    pub(super) device: ::wgpu::Device,
    pub(super) queue: ::wgpu::Queue,
    /// Format of the pictures.
    pub(super) format: ::wgpu::TextureFormat,
    pub(super) pipelines: Pipelines,
    /// Draws are read from buffers, one per tile. Otherwise a draw is a call, and the tiles of a part are merged.
    pub(super) indirect: bool,
    scopes: Arc<Scopes>,
}

/// Optional feature that makes drawing cheaper.
pub(super) const WELCOME: ::wgpu::Features = ::wgpu::Features::INDIRECT_FIRST_INSTANCE;

impl Gpu {
    /// Creates the pipelines. Takes tenths of a second.
    ///
    /// # Errors
    /// If the device rejects the pipelines.
    pub(super) fn new(
        device: ::wgpu::Device,
        queue: ::wgpu::Queue,
        format: ::wgpu::TextureFormat,
    ) -> Result<Self, RenderError> {
        let reads_arrays = device.limits().max_storage_buffers_per_shader_stage >= 2;
        // In browsers, a call that draws from a buffer is as many calls as there are draws.
        let indirect = device.features().contains(WELCOME) && reads_arrays && !cfg!(target_arch = "wasm32");
        let scopes = Arc::new(Scopes::default());
        let pipelines = scopes.checked(&device, |device| Pipelines::new(device, format, indirect))?;
        Ok(Self { device, queue, format, pipelines, indirect, scopes })
    }

    /// Checks that the device supports pictures of this size.
    pub(super) fn takes(&self, size: (u32, u32)) -> Result<(), RenderError> {
        let limit = self.device.limits().max_texture_dimension_2d;
        let possible = (1..=limit).contains(&size.0) && (1..=limit).contains(&size.1);
        if possible { Ok(()) } else { Err(RenderError::Size { size, limit }) }
    }

    /// See [`Scopes::checked`].
    pub(super) fn checked<T>(&self, work: impl FnOnce(&::wgpu::Device) -> T) -> Result<T, RenderError> {
        self.scopes.checked(&self.device, work)
    }
}
