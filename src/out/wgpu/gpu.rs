//! A device, its own or the caller's, with what every drawing on it shares.

use super::error::RenderError;
use super::pipelines::Pipelines;

/// Cheap to clone: all of it is shared.
#[derive(Clone, Debug)]
pub(super) struct Gpu {
    pub(super) device: ::wgpu::Device,
    pub(super) queue: ::wgpu::Queue,
    /// What pictures are drawn into.
    pub(super) format: ::wgpu::TextureFormat,
    pub(super) pipelines: Pipelines,
    /// Whether draws are read from buffers; else each is a call.
    pub(super) indirect: bool,
}

/// What makes drawing cheaper where there is it.
pub(super) const WELCOME: ::wgpu::Features = ::wgpu::Features::INDIRECT_FIRST_INSTANCE;

impl Gpu {
    /// Makes the pipelines: tenths of a second.
    ///
    /// # Errors
    /// When the device does not take them.
    pub(super) fn new(
        device: ::wgpu::Device,
        queue: ::wgpu::Queue,
        format: ::wgpu::TextureFormat,
    ) -> Result<Self, RenderError> {
        let indirect = device.features().contains(WELCOME);
        let pipelines = checked(&device, |device| Pipelines::new(device, format))?;
        Ok(Self { device, queue, format, pipelines, indirect })
    }

    /// Whether there can be a picture of so many pixels.
    pub(super) fn takes(&self, size: (u32, u32)) -> Result<(), RenderError> {
        let limit = self.device.limits().max_texture_dimension_2d;
        let possible = (1..=limit).contains(&size.0) && (1..=limit).contains(&size.1);
        if possible { Ok(()) } else { Err(RenderError::Size { size, limit }) }
    }

    /// As [`checked`].
    pub(super) fn checked<T>(&self, work: impl FnOnce(&::wgpu::Device) -> T) -> Result<T, RenderError> {
        checked(&self.device, work)
    }
}

/// What `work` makes, unless the device reports an error meanwhile: outside a scope it would panic.
pub(super) fn checked<T>(device: &::wgpu::Device, work: impl FnOnce(&::wgpu::Device) -> T) -> Result<T, RenderError> {
    let memory = device.push_error_scope(::wgpu::ErrorFilter::OutOfMemory);
    let validation = device.push_error_scope(::wgpu::ErrorFilter::Validation);
    let internal = device.push_error_scope(::wgpu::ErrorFilter::Internal);
    let made = work(device);
    let (internal, validation, memory) = (internal.pop(), validation.pop(), memory.pop());
    let (internal, validation) = (pollster::block_on(internal), pollster::block_on(validation));
    // Memory that could not be had makes what follows invalid: the cause comes first.
    match pollster::block_on(memory).or(internal).or(validation) {
        Some(error) => Err(RenderError::Device(error.to_string())),
        None => Ok(made),
    }
}
