//! The graphics adapters of this machine to a device on the best usable one.

use super::error::NoAdapter;
use super::formats::COLOUR_FORMAT;
use super::gpu::{Gpu, WELCOME};

/// Opens a device on the first adapter that supports the pipelines, from the fastest kind to software.
/// `WGPU_BACKEND` narrows the choice.
pub(super) fn open() -> Result<(Gpu, ::wgpu::AdapterInfo), NoAdapter> {
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
