//! An `OffscreenCanvas` to a graphics device that draws on it: WebGPU where there is one, else WebGL 2.

use std::sync::{Arc, Mutex, PoisonError};
use wasm_bindgen::JsError;
use web_sys::OffscreenCanvas;
use wgpu::{Backends, CurrentSurfaceTexture, SurfaceConfiguration, Texture, TextureFormat, TextureUsages, TextureView};

/// A canvas and its device.
pub(crate) struct Canvas {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    /// `webgpu` or `webgl2`.
    pub(crate) backend: &'static str,
    /// The adapter's name.
    pub(crate) name: String,
    /// Format of pictures, which encodes sRGB.
    pub(crate) format: TextureFormat,
    /// The last picture, where the canvas itself takes no format that encodes sRGB.
    picture: Option<Texture>,
    surface: wgpu::Surface<'static>,
    configuration: SurfaceConfiguration,
    /// Why the device is lost.
    lost: Arc<Mutex<Option<String>>>,
}

impl Canvas {
    /// Opens a device on a backend by name; on the better one there is for an empty name.
    pub(crate) async fn open(canvas: OffscreenCanvas, gpu: &str) -> Result<Self, JsError> {
        match gpu {
            "webgpu" => Self::on(&canvas, Backends::BROWSER_WEBGPU).await,
            "webgl2" => Self::on(&canvas, Backends::GL).await,
            "" => {
                // A canvas stays with the first kind of context that was asked for: ask without it.
                let instance = instance(Backends::BROWSER_WEBGPU);
                let there = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await.is_ok();
                Self::on(&canvas, if there { Backends::BROWSER_WEBGPU } else { Backends::GL }).await
            }
            _ => Err(JsError::new(&format!("unknown graphics interface {gpu:?}; known are webgpu and webgl2"))),
        }
    }

    async fn on(canvas: &OffscreenCanvas, backends: Backends) -> Result<Self, JsError> {
        let instance = instance(backends);
        let surface = instance.create_surface(wgpu::SurfaceTarget::OffscreenCanvas(canvas.clone()));
        let surface = surface.map_err(crate::told)?;
        let wanted = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            compatible_surface: Some(&surface),
            ..wgpu::RequestAdapterOptions::default()
        };
        let adapter = instance.request_adapter(&wanted).await.map_err(crate::told)?;
        let limits = wgpu::Limits::downlevel_webgl2_defaults().using_resolution(adapter.limits());
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("trimtess"),
            required_limits: limits,
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) = adapter.request_device(&descriptor).await.map_err(crate::told)?;
        let lost = Arc::<Mutex<Option<String>>>::default();
        let told = Arc::clone(&lost);
        device.set_device_lost_callback(move |_, why| {
            *told.lock().unwrap_or_else(PoisonError::into_inner) = Some(why);
        });
        let size = (canvas.width().max(1), canvas.height().max(1));
        let mut configuration = surface
            .get_default_config(&adapter, size.0, size.1)
            .ok_or_else(|| JsError::new("the adapter cannot draw on the canvas"))?;
        let formats = surface.get_capabilities(&adapter).formats;
        configuration.format = formats.iter().copied().find(TextureFormat::is_srgb).unwrap_or(configuration.format);
        let format = configuration.format.add_srgb_suffix();
        if format != configuration.format {
            configuration.usage |= TextureUsages::COPY_DST;
        }
        surface.configure(&device, &configuration);
        let backend = if backends == Backends::GL { "webgl2" } else { "webgpu" };
        let name = adapter.get_info().name;
        Ok(Self { device, queue, backend, name, format, picture: None, surface, configuration, lost })
    }

    /// Width and height, pixels.
    pub(crate) fn size(&self) -> (u32, u32) {
        (self.configuration.width, self.configuration.height)
    }

    /// Changes the size, within what the device can do.
    pub(crate) fn resize(&mut self, width: u32, height: u32) {
        let most = self.device.limits().max_texture_dimension_2d;
        let size = (width.clamp(1, most), height.clamp(1, most));
        if size != self.size() {
            (self.configuration.width, self.configuration.height) = size;
            self.surface.configure(&self.device, &self.configuration);
        }
    }

    /// Why the device is lost, if it is.
    pub(crate) fn lost(&self) -> Option<String> {
        self.lost.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Has `draw` draw the next picture. `None` where the browser shows none now.
    pub(crate) fn present<T>(
        &mut self,
        draw: impl FnOnce(&TextureView) -> Result<T, JsError>,
    ) -> Result<Option<T>, JsError> {
        let texture = match self.surface.get_current_texture() {
            CurrentSurfaceTexture::Success(texture) | CurrentSurfaceTexture::Suboptimal(texture) => texture,
            CurrentSurfaceTexture::Outdated | CurrentSurfaceTexture::Lost => {
                self.surface.configure(&self.device, &self.configuration);
                return Ok(None);
            }
            CurrentSurfaceTexture::Timeout | CurrentSurfaceTexture::Occluded => return Ok(None),
            CurrentSurfaceTexture::Validation => return Err(JsError::new("the canvas' texture is not valid")),
        };
        let whole = wgpu::TextureViewDescriptor::default();
        let drawn = if self.format == self.configuration.format {
            draw(&texture.texture.create_view(&whole))?
        } else {
            // A view of the canvas in another format would do, but software devices ignore it when they resolve
            // samples.
            let size = texture.texture.size();
            let picture = self.picture.take().filter(|picture| picture.size() == size);
            let picture = picture.unwrap_or_else(|| self.texture(TextureUsages::COPY_SRC));
            let drawn = draw(&picture.create_view(&whole))?;
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_texture_to_texture(picture.as_image_copy(), texture.texture.as_image_copy(), size);
            self.queue.submit([encoder.finish()]);
            self.picture = Some(picture);
            drawn
        };
        self.queue.present(texture);
        Ok(Some(drawn))
    }

    /// A texture to draw to, as large as the canvas.
    pub(crate) fn texture(&self, usage: TextureUsages) -> Texture {
        let (width, height) = self.size();
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: self.format,
            usage: TextureUsages::RENDER_ATTACHMENT | usage,
            view_formats: &[],
        })
    }
}

fn instance(backends: Backends) -> wgpu::Instance {
    wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        flags: wgpu::InstanceFlags::empty(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    })
}
