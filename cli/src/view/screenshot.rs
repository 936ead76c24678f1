//! The window's content to a PNG, without a window.

use super::ViewArgs;
use super::load::Loader;
use super::looks::Looks;
use super::paint::{Canvas, texture};
use super::viewer::Viewer;
use crate::Failure;
use crate::input::Input;
use crate::picture::require_png;
use std::path::Path;
use trimtess::out::wgpu::{Image, Renderer};
use wgpu::{TextureFormat, TextureUsages};

/// Runs the frames and the click in `args`, then returns the screenshot.
pub(super) fn draw(
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
