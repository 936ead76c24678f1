//! Window events to pictures of the viewer, one per requested redraw; a screenshot without a window.

use super::paint::{Canvas, texture};
use super::panel::Looks;
use super::viewer::Viewer;
use super::{Loader, ViewArgs};
use crate::Failure;
use crate::input::Input;
use crate::render::require_png;
use std::path::Path;
use std::sync::Arc;
use trimtess::out::wgpu::{Image, Renderer};
use wgpu::{CurrentSurfaceTexture, PresentMode, SurfaceConfiguration, TextureFormat, TextureUsages};
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::window::{Window, WindowId};

/// Shows the window until it is closed.
pub(super) fn run(input: Option<Input>, size: (u32, u32), loader: Loader, looks: Looks) -> Result<(), Failure> {
    let no_window = |error: &dyn std::fmt::Display| {
        // The text before the cause is a position in winit's sources.
        let error = error.to_string();
        let cause = error.rsplit(": ").next().unwrap_or(&error).trim_end_matches('.');
        Failure::Cannot(format!("cannot open a window: {cause}; --screenshot OUT.png works without one"))
    };
    let events = EventLoop::new().map_err(|error| no_window(&error))?;
    events.set_control_flow(ControlFlow::Wait);
    let mut app = App { start: Some(Start { input, size, loader, looks }), open: None, failure: None };
    events.run_app(&mut app).map_err(|error| no_window(&error))?;
    app.failure.map_or(Ok(()), Err)
}

/// Arguments of the window, until it is created.
struct Start {
    input: Option<Input>,
    size: (u32, u32),
    loader: Loader,
    looks: Looks,
}

/// The application, with its only window.
struct App {
    start: Option<Start>,
    open: Option<Open>,
    failure: Option<Failure>,
}

/// An open window and its content.
struct Open {
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    configuration: SurfaceConfiguration,
    device: wgpu::Device,
    queue: wgpu::Queue,
    input: egui_winit::State,
    viewer: Viewer,
}

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        let Some(start) = self.start.take() else { return };
        match Open::new(start, events) {
            Ok(open) => {
                open.window.request_redraw();
                self.open = Some(open);
            }
            Err(error) => {
                self.failure = Some(Failure::Cannot(error));
                events.exit();
            }
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = &mut self.open else { return };
        let response = open.input.on_window_event(&open.window, &event);
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(size) => {
                open.resize(size.width, size.height);
                open.window.request_redraw();
            }
            WindowEvent::RedrawRequested => {
                if let Err(error) = open.redraw() {
                    self.failure = Some(Failure::Cannot(error));
                    events.exit();
                }
            }
            _ if response.repaint => open.window.request_redraw(),
            _ => {}
        }
    }
}

impl Open {
    fn new(start: Start, events: &ActiveEventLoop) -> Result<Self, String> {
        let Start { input, size, loader, looks } = start;
        let attributes =
            Window::default_attributes().with_title("trimtess").with_inner_size(LogicalSize::new(size.0, size.1));
        let window = Arc::new(events.create_window(attributes).map_err(|error| error.to_string())?);
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends: wgpu::Backends::all().with_env(),
            flags: wgpu::InstanceFlags::empty(),
            ..wgpu::InstanceDescriptor::new_with_display_handle(Box::new(events.owned_display_handle()))
        });
        let surface = instance.create_surface(Arc::clone(&window)).map_err(|error| error.to_string())?;
        let wanted = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            compatible_surface: Some(&surface),
            ..wgpu::RequestAdapterOptions::default()
        };
        let adapter = pollster::block_on(instance.request_adapter(&wanted)).map_err(|error| error.to_string())?;
        tracing::info!("drawn by {}", adapter.get_info().name);
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("trimtess"),
            required_features: adapter.features() & wgpu::Features::INDIRECT_FIRST_INSTANCE,
            required_limits: wgpu::Limits::downlevel_defaults().using_resolution(adapter.limits()),
            ..wgpu::DeviceDescriptor::default()
        }))
        .map_err(|error| error.to_string())?;
        let at = window.inner_size();
        let mut configuration = surface
            .get_default_config(&adapter, at.width.max(1), at.height.max(1))
            .ok_or("the adapter cannot draw into the window")?;
        let formats = surface.get_capabilities(&adapter).formats;
        configuration.format = formats.into_iter().find(|format| format.is_srgb()).unwrap_or(configuration.format);
        configuration.present_mode = PresentMode::AutoVsync;
        surface.configure(&device, &configuration);
        let mut viewer = Viewer::new(&device, &queue, configuration.format, loader, looks)?;
        let most = device.limits().max_texture_dimension_2d as usize;
        let scale = Some(window.scale_factor() as f32);
        let state = egui_winit::State::new(
            viewer.egui().clone(),
            egui::ViewportId::ROOT,
            &window,
            scale,
            window.theme(),
            Some(most),
        );
        if let Some(input) = input {
            viewer.open(input);
        }
        Ok(Self { window, surface, configuration, device, queue, input: state, viewer })
    }

    fn resize(&mut self, width: u32, height: u32) {
        if width > 0 && height > 0 {
            (self.configuration.width, self.configuration.height) = (width, height);
            self.surface.configure(&self.device, &self.configuration);
        }
    }

    fn redraw(&mut self) -> Result<(), String> {
        let texture = match self.surface.get_current_texture() {
            CurrentSurfaceTexture::Success(texture) | CurrentSurfaceTexture::Suboptimal(texture) => texture,
            CurrentSurfaceTexture::Outdated | CurrentSurfaceTexture::Lost => {
                self.surface.configure(&self.device, &self.configuration);
                self.window.request_redraw();
                return Ok(());
            }
            // The window is not visible: wait for the next event.
            CurrentSurfaceTexture::Timeout | CurrentSurfaceTexture::Occluded => return Ok(()),
            CurrentSurfaceTexture::Validation => return Err("the window's surface texture is not valid".to_owned()),
        };
        let target = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let canvas = Canvas {
            target: &target,
            size: (self.configuration.width, self.configuration.height),
            pixels_per_point: egui_winit::pixels_per_point(self.viewer.egui(), &self.window),
        };
        let input = self.input.take_egui_input(&self.window);
        let shown = self.viewer.picture(input, &canvas)?;
        self.input.handle_platform_output(&self.window, shown.platform);
        self.window.pre_present_notify();
        self.queue.present(texture);
        if shown.again {
            self.window.request_redraw();
        }
        Ok(())
    }
}

/// Runs the frames and the click in `args`, then returns the screenshot.
pub(super) fn screenshot(
    output: &Path,
    input: &Input,
    args: &ViewArgs,
    loader: Loader,
    looks: Looks,
) -> Result<Image, Failure> {
    require_png(output)?;
    let renderer = Renderer::new().map_err(Failure::cannot)?;
    let (device, queue) = (renderer.device(), renderer.queue());
    let most = device.limits().max_texture_dimension_2d;
    let size = args.size;
    if size.0 > most || size.1 > most {
        return Err(Failure::Usage(format!(
            "cannot draw a window of {} × {} pixels; each side may be 1 to {most}",
            size.0, size.1
        )));
    }
    let format = TextureFormat::Rgba8UnormSrgb;
    let target = texture(device, size, format, TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC);
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    let canvas = Canvas { target: &view, size, pixels_per_point: 1.0 };
    let mut viewer = Viewer::new(device, queue, format, loader, looks).map_err(Failure::cannot)?;
    viewer.open_now(input, f64::from(size.0) / f64::from(size.1))?;

    let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(size.0 as f32, size.1 as f32));
    let mut time = 0.0;
    let mut step = |viewer: &mut Viewer, events: Vec<egui::Event>| {
        time += 0.1;
        let input = egui::RawInput { screen_rect: Some(screen), time: Some(time), events, ..egui::RawInput::default() };
        viewer.picture(input, &canvas).map_err(Failure::cannot)
    };
    // The first frame lays out the panel; then the camera can be fitted to the remaining area.
    step(&mut viewer, Vec::new())?;
    viewer.fit(&args.picture.camera);
    step(&mut viewer, Vec::new())?;
    viewer.looks.turning = args.frames > 1;
    for _ in 1..args.frames {
        step(&mut viewer, Vec::new())?;
    }
    viewer.looks.turning = false;
    if let Some((x, y)) = args.click {
        let pos = egui::pos2(x, y);
        let button = egui::PointerButton::Primary;
        let press = |pressed| egui::Event::PointerButton { pos, button, pressed, modifiers: egui::Modifiers::NONE };
        for event in [egui::Event::PointerMoved(pos), press(true), press(false)] {
            step(&mut viewer, vec![event])?;
        }
        step(&mut viewer, vec![egui::Event::PointerGone])?;
    }
    step(&mut viewer, Vec::new())?;
    Image::read(device, queue, &target).map_err(Failure::cannot)
}
