//! A graphics device, owned or the caller's, with the pipelines that all drawing on it shares.

use super::error::RenderError;
use super::pipelines::Pipelines;

/// Device, queue and pipelines. Cheap to clone: clones share everything.
#[derive(Clone, Debug)]
pub(super) struct Gpu {
    pub(super) device: ::wgpu::Device,
    pub(super) queue: ::wgpu::Queue,
    /// Format of the pictures.
    pub(super) format: ::wgpu::TextureFormat,
    pub(super) pipelines: Pipelines,
    /// Draws are read from buffers. Otherwise each draw is a call.
    pub(super) indirect: bool,
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
        let indirect = device.features().contains(WELCOME);
        let pipelines = checked(&device, |device| Pipelines::new(device, format))?;
        Ok(Self { device, queue, format, pipelines, indirect })
    }

    /// Checks that the device supports pictures of this size.
    pub(super) fn takes(&self, size: (u32, u32)) -> Result<(), RenderError> {
        let limit = self.device.limits().max_texture_dimension_2d;
        let possible = (1..=limit).contains(&size.0) && (1..=limit).contains(&size.1);
        if possible { Ok(()) } else { Err(RenderError::Size { size, limit }) }
    }

    /// See [`checked`].
    pub(super) fn checked<T>(&self, work: impl FnOnce(&::wgpu::Device) -> T) -> Result<T, RenderError> {
        checked(&self.device, work)
    }
}

/// Runs `work` and returns the device errors it causes. Without error scopes wgpu would panic on them.
pub(super) fn checked<T>(device: &::wgpu::Device, work: impl FnOnce(&::wgpu::Device) -> T) -> Result<T, RenderError> {
    let memory = device.push_error_scope(::wgpu::ErrorFilter::OutOfMemory);
    let validation = device.push_error_scope(::wgpu::ErrorFilter::Validation);
    let internal = device.push_error_scope(::wgpu::ErrorFilter::Internal);
    let made = work(device);
    let (internal, validation, memory) = (internal.pop(), validation.pop(), memory.pop());
    let (internal, validation) = (pollster::block_on(internal), pollster::block_on(validation));
    // A failed allocation causes validation errors later on: report the cause first.
    match pollster::block_on(memory).or(internal).or(validation) {
        Some(error) => Err(RenderError::Device(error.to_string())),
        None => Ok(made),
    }
}
