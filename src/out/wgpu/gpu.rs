//! A graphics device, the caller's or that of the best adapter, with the pipelines that all drawing on it shares, and
//! its errors as those of the calls that caused them.

#[cfg(not(target_arch = "wasm32"))]
use super::pipelines::COLOUR_FORMAT;
use super::pipelines::Pipelines;
use ::wgpu::{Error, ErrorFilter};
use std::fmt;
use std::future::Future;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};

/// No usable graphics adapter was found.
#[derive(Clone, Debug, thiserror::Error)]
#[error(
    "no usable graphics adapter{}. Install the graphics driver, or a software one: on Debian and Ubuntu \
     `apt install mesa-vulkan-drivers`, on Fedora `dnf install mesa-vulkan-drivers`, on Arch `pacman -S vulkan-swrast`",
    .found.iter().flat_map(|refusal| ["; ", refusal.as_str()]).collect::<String>()
)]
pub struct NoAdapter {
    /// The adapters found, each with the reason why it was rejected.
    pub found: Vec<String>,
}

/// A picture could not be drawn.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The picture is empty, or larger than the adapter allows.
    #[error("cannot draw {} × {} pixels; each side may be 1 to {limit}", .size.0, .size.1)]
    Size {
        /// Requested width and height in pixels.
        size: (u32, u32),
        /// Largest width or height that the adapter allows.
        limit: u32,
    },
    /// The device failed, mostly because it ran out of memory.
    #[error("the graphics device failed: {0}")]
    Device(String),
}

type Answer = Pin<Box<dyn Future<Output = Option<Error>> + Send>>;

/// Errors that the device has still to tell. Natively it answers at once. In browsers it answers between calls, so that
/// the error of a call is returned by a later one.
#[derive(Default)]
pub(super) struct Scopes(Mutex<Vec<Answer>>);

impl Scopes {
    /// Runs `work` and returns the device errors it causes. Without error scopes wgpu would panic on them.
    pub(super) fn checked<T>(
        &self,
        device: &::wgpu::Device,
        work: impl FnOnce(&::wgpu::Device) -> T,
    ) -> Result<T, RenderError> {
        let memory = device.push_error_scope(ErrorFilter::OutOfMemory);
        let validation = device.push_error_scope(ErrorFilter::Validation);
        let internal = device.push_error_scope(ErrorFilter::Internal);
        let made = work(device);
        let (internal, validation, memory) = (internal.pop(), validation.pop(), memory.pop());
        let mut awaited = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // A failed allocation causes validation errors later on: report the cause first.
        let answers: [Answer; 3] = [Box::pin(memory), Box::pin(internal), Box::pin(validation)];
        awaited.extend(answers);
        let mut found = None;
        awaited.retain_mut(|answer| match answer.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(error) => {
                found = found.take().or(error);
                false
            }
            Poll::Pending => true,
        });
        found.map_or(Ok(made), |error| Err(RenderError::Device(error.to_string())))
    }
}

impl fmt::Debug for Scopes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Scopes")
    }
}

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
const WELCOME: ::wgpu::Features = ::wgpu::Features::INDIRECT_FIRST_INSTANCE;

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

/// Opens a device on the first adapter that supports the pipelines, from the fastest kind to software.
/// `WGPU_BACKEND` narrows the choice.
#[cfg(not(target_arch = "wasm32"))]
pub(super) fn open_adapter() -> Result<(Gpu, ::wgpu::AdapterInfo), NoAdapter> {
    let wanted = ::wgpu::Backends::all().with_env();
    let mut found = Vec::new();
    // Try OpenGL last: it needs a display, or a driver that does without.
    for backends in [wanted & ::wgpu::Backends::PRIMARY, wanted & ::wgpu::Backends::SECONDARY] {
        if backends.is_empty() {
            continue;
        }
        let instance = ::wgpu::Instance::new(::wgpu::InstanceDescriptor {
            backends,
            flags: ::wgpu::InstanceFlags::empty(),
            ..::wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
        adapters.sort_by_key(|adapter| match adapter.get_info().device_type {
            ::wgpu::DeviceType::DiscreteGpu => 0,
            ::wgpu::DeviceType::IntegratedGpu => 1,
            ::wgpu::DeviceType::VirtualGpu => 2,
            ::wgpu::DeviceType::Other => 3,
            ::wgpu::DeviceType::Cpu => 4,
        });
        for adapter in adapters {
            let (info, limits) = (adapter.get_info(), adapter.limits());
            // Large pictures are read back whole.
            let required_limits = ::wgpu::Limits {
                max_buffer_size: limits.max_buffer_size,
                ..::wgpu::Limits::downlevel_defaults().using_resolution(limits)
            };
            let descriptor = ::wgpu::DeviceDescriptor {
                label: Some("trimtess"),
                required_features: adapter.features() & WELCOME,
                required_limits,
                ..::wgpu::DeviceDescriptor::default()
            };
            let (device, queue) = match pollster::block_on(adapter.request_device(&descriptor)) {
                Ok(granted) => granted,
                Err(error) => {
                    found.push(format!("{}: {error}", info.name));
                    continue;
                }
            };
            match Gpu::new(device, queue, COLOUR_FORMAT) {
                Ok(gpu) => return Ok((gpu, info)),
                Err(error) => found.push(format!("{}: {error}", info.name)),
            }
        }
    }
    Err(NoAdapter { found })
}
