//! Input to the next picture of the window: requests a frame from the session, draws the scene, paints the panel.

use super::paint::{Canvas, PICTURE, Painter, texture};
use super::panel::{self, Action, Looks, PanelText};
use super::{Loaded, Loader, Loading, session_of};
use crate::Failure;
use crate::input::Input;
use std::sync::Arc;
use std::time::{Duration, Instant};
use trimtess::glam::DVec3;
use trimtess::out::wgpu::{LiveScene, PickHit, RenderOptions};
use trimtess::parallel::{FrameError, Session, SessionOptions};
use trimtess::prepare::Prepared;
use trimtess::view::{View, ViewPoint};
use wgpu::{Texture, TextureFormat, TextureUsages, TextureViewDescriptor};

/// Format of the texture that the scene is drawn to.
const PICTURE_FORMAT: TextureFormat = TextureFormat::Rgba8UnormSrgb;

/// How long a picture waits for workers before it shows the last frame again.
const AWAITED: Duration = Duration::from_millis(8);

/// The content of the window. Works without a window, too.
pub(super) struct Viewer {
    device: wgpu::Device,
    egui: egui::Context,
    painter: Painter,
    scene: LiveScene,
    picture: Option<Texture>,
    loader: Loader,
    loading: Option<Loading>,
    model: Option<Model>,
    pub(super) looks: Looks,
    told: PanelText,
    last: Instant,
    /// Last position of the pointer during a drag.
    hand: Option<egui::Pos2>,
    /// Wait for every frame, so that screenshots show the camera they were made for.
    patient: bool,
}

/// The model that is shown.
struct Model {
    prepared: Arc<Prepared>,
    session: Session,
    workers: usize,
    /// View of the frame in progress.
    underway: Option<View>,
    /// View of the last complete frame.
    shown: Option<View>,
    /// The last frame deferred changes of level.
    deferred: bool,
    picked: Option<PickHit>,
    /// The point that drags orbit about, or move along.
    pivot: DVec3,
}

/// Result of a picture.
pub(super) struct Shown {
    pub(super) platform: egui::PlatformOutput,
    /// Another picture must follow at once.
    pub(super) again: bool,
}

impl Viewer {
    pub(super) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        format: TextureFormat,
        loader: Loader,
        looks: Looks,
    ) -> Result<Self, String> {
        let scene = LiveScene::new(device, queue, PICTURE_FORMAT).map_err(|error| error.to_string())?;
        let egui = egui::Context::default();
        egui.set_visuals(egui::Visuals {
            weak_text_color: Some(egui::Color32::from_gray(150)),
            ..egui::Visuals::dark()
        });
        Ok(Self {
            device: device.clone(),
            egui,
            painter: Painter::new(device, queue, format),
            scene,
            picture: None,
            loader,
            loading: None,
            model: None,
            looks,
            told: PanelText { name: "drop a STEP file here".to_owned(), ..PanelText::default() },
            last: Instant::now(),
            hand: None,
            patient: false,
        })
    }

    pub(super) fn egui(&self) -> &egui::Context {
        &self.egui
    }

    /// Starts loading a file. The current model stays until the file is loaded.
    pub(super) fn open(&mut self, input: Input) {
        self.told.trouble = None;
        self.loading = Some(self.loader.start(input, &self.session_options()));
    }

    /// Loads a file synchronously. From then on every frame is waited for.
    pub(super) fn open_now(&mut self, input: &Input, aspect: f64) -> Result<(), Failure> {
        self.patient = true;
        let loaded = self.loader.load(input, &self.session_options())?;
        self.show(loaded, aspect);
        Ok(())
    }

    /// Fits the camera to the model, seen from a side.
    pub(super) fn fit(&mut self, from: &ViewPoint) {
        let size = self.picture.as_ref().map_or((1, 1), |picture| (picture.width(), picture.height()));
        if let Some(model) = &self.model {
            self.looks.fit(from, model.prepared.bounds, f64::from(size.0) / f64::from(size.1));
        }
    }

    fn session_options(&self) -> SessionOptions {
        self.loader.limits.session().with_threads(self.looks.workers)
    }

    fn show(&mut self, loaded: Loaded, aspect: f64) {
        let Loaded { name, prepared, session, seconds } = loaded;
        let faces: usize = prepared.parts.iter().map(|part| part.faces.len()).sum();
        self.told = PanelText {
            name,
            counts: vec![
                ("parts", prepared.parts.len().to_string()),
                ("instances", prepared.scene.instances.len().to_string()),
                ("faces", faces.to_string()),
                ("tiles", prepared.tiles().count().to_string()),
                ("notes", prepared.diagnostics.len().to_string()),
                ("read in", format!("{seconds:.2} s")),
            ],
            ..PanelText::default()
        };
        let from = self.looks.camera.view_point();
        self.looks.fit(&from, prepared.bounds, aspect);
        self.model = Some(Model {
            workers: self.looks.workers,
            pivot: self.looks.camera.target(),
            prepared,
            session,
            underway: None,
            shown: None,
            deferred: false,
            picked: None,
        });
    }

    /// Draws the next picture of the window.
    pub(super) fn picture(&mut self, input: egui::RawInput, canvas: &Canvas<'_>) -> Result<Shown, String> {
        self.told.costs.between = self.last.elapsed();
        self.last = Instant::now();
        let mut actions = Vec::new();
        let mut area = egui::Rect::ZERO;
        let context = self.egui.clone();
        let output = context.run(input, |context| {
            if !context.wants_keyboard_input() {
                actions.extend(context.input(|input| self.looks.keys(input)));
            }
            if self.looks.panel {
                let side = egui::SidePanel::right("panel").resizable(false).exact_width(panel::WIDTH);
                side.show(context, |ui| {
                    egui::ScrollArea::vertical().show(ui, |ui| {
                        actions.extend(panel::panel(ui, &mut self.looks, &self.told));
                    });
                });
            }
            let frame = egui::CentralPanel::default().frame(egui::Frame::NONE);
            frame.show(context, |ui| {
                area = ui.max_rect();
                let response = ui.allocate_rect(area, egui::Sense::click_and_drag());
                let whole = egui::Rect::from_min_max(egui::Pos2::ZERO, egui::pos2(1.0, 1.0));
                ui.painter().image(PICTURE, area, whole, egui::Color32::WHITE);
                self.hand(ui, &response, canvas.pixels_per_point);
                self.mark(ui, area, canvas.pixels_per_point);
            });
        });
        let pixels = |points: f32| ((points * canvas.pixels_per_point).round() as u32).max(1);
        let size = (pixels(area.width()), pixels(area.height()));
        let aspect = f64::from(size.0) / f64::from(size.1);
        if let Some(path) = context.input(|input| input.raw.dropped_files.iter().find_map(|file| file.path.clone())) {
            self.open(Input::File(path));
        }
        self.told.underway = None;
        self.load(aspect);
        self.act(&actions, aspect);
        let done = self.advance(size).and_then(|again| self.draw(size).map(|()| again));
        let again = match done {
            Ok(again) => again,
            Err(error) if self.patient => return Err(error),
            Err(error) => {
                self.told.trouble = Some(error);
                false
            }
        };
        let primitives = context.tessellate(output.shapes, output.pixels_per_point);
        self.painter.paint(canvas, &primitives, &output.textures_delta);
        let soon = output.viewport_output.values().any(|viewport| viewport.repaint_delay.is_zero());
        Ok(Shown { platform: output.platform_output, again: again || soon })
    }

    /// Handles the pointer: orbit, pan, zoom, pick.
    fn hand(&mut self, ui: &egui::Ui, response: &egui::Response, pixels_per_point: f32) {
        let Some(model) = &mut self.model else { return };
        let Some(shown) = model.shown else { return };
        let scale = f64::from(pixels_per_point);
        let place = |at: egui::Pos2| {
            let at = (at - response.rect.min) * pixels_per_point;
            [f64::from(at.x), f64::from(at.y)]
        };
        let size = [f64::from(response.rect.width()) * scale, f64::from(response.rect.height()) * scale];
        let pixels = (size[0].round() as u32, size[1].round() as u32);
        let options = self.looks.picture.options(shown.camera, pixels, model.prepared.bounds);
        let mut under = |at: egui::Pos2| {
            let [x, y] = place(at);
            let picked = self.scene.pick((x.max(0.0) as u32, y.max(0.0) as u32), 0, &options);
            picked.map_err(|error| self.told.trouble = Some(error.to_string())).ok().flatten()
        };
        if let Some(at) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            // At a low frame rate, pressing the button and moving the pointer may arrive in the same picture.
            let held = response.drag_started() || self.hand.is_none();
            let start = ui.input(|input| input.pointer.press_origin()).unwrap_or(at);
            if held {
                model.pivot = under(start).map_or(self.looks.camera.target(), |picked| picked.point);
            }
            let moved = at - self.hand.filter(|_| !held).unwrap_or(start);
            self.hand = Some(at);
            let sliding = response.dragged_by(egui::PointerButton::Secondary)
                || response.dragged_by(egui::PointerButton::Middle)
                || ui.input(|input| input.modifiers.shift);
            if moved != egui::Vec2::ZERO {
                let camera = self.looks.camera;
                self.looks.camera = if sliding {
                    camera.pan(model.pivot, place(at - moved), place(at), size)
                } else {
                    // A drag over the height of the picture is half a turn.
                    let angle = |points: f32| std::f64::consts::PI * f64::from(points) * scale / size[1];
                    camera.orbit(model.pivot, angle(moved.x), -angle(moved.y))
                };
            }
        } else {
            self.hand = None;
        }
        if let Some(at) = response.interact_pointer_pos().filter(|_| response.clicked()) {
            model.picked = under(at);
            self.told.picked = model.picked.map_or(Vec::new(), |picked| {
                let of_face = model.prepared.face_facts(picked.part, picked.face).map(|facts| facts.rows());
                picked.facts(model.session.scene(), of_face.unwrap_or_default())
            });
        }
        let turned = ui.input(|input| input.smooth_scroll_delta.y + 200.0 * (input.zoom_delta() - 1.0));
        if let Some(at) = response.hover_pos().filter(|_| turned != 0.0) {
            let camera = self.looks.camera;
            let point = match under(at) {
                Some(picked) => picked.point,
                None => camera.at_depth_of(camera.target(), place(at), size),
            };
            self.looks.camera = camera.zoom(point, (-f64::from(turned) / 300.0).exp());
        }
    }

    /// Draws a circle around the picked point.
    fn mark(&self, ui: &egui::Ui, area: egui::Rect, pixels_per_point: f32) {
        let Some(model) = &self.model else { return };
        let (Some(picked), Some(shown)) = (model.picked, model.shown) else { return };
        let size = [area.width(), area.height()].map(|side| f64::from(side * pixels_per_point));
        if let Some([x, y]) = shown.camera.pixel_of(picked.point, size) {
            let at = area.min + egui::vec2(x as f32, y as f32) / pixels_per_point;
            let pen = |width, colour| egui::Stroke::new(width, colour);
            ui.painter().circle_stroke(at, 6.0, pen(3.0, egui::Color32::BLACK));
            ui.painter().circle_stroke(at, 6.0, pen(1.5, egui::Color32::from_rgb(255, 210, 60)));
        }
    }

    /// Shows a file that has finished loading.
    fn load(&mut self, aspect: f64) {
        let Some(loading) = &self.loading else { return };
        match loading.poll() {
            None => {
                let seconds = loading.since.elapsed().as_secs();
                self.told.underway = Some(format!("reading {} … {seconds} s", loading.name));
            }
            Some(Ok(loaded)) => {
                self.loading = None;
                self.show(loaded, aspect);
            }
            Some(Err(error)) => {
                self.loading = None;
                self.told.trouble = Some(error);
            }
        }
    }

    fn act(&mut self, actions: &[Action], aspect: f64) {
        let Some(model) = &mut self.model else { return };
        for action in actions {
            match action {
                Action::Fit(from) => self.looks.fit(from, model.prepared.bounds, aspect),
                Action::FitHere => {
                    let from = self.looks.camera.view_point();
                    self.looks.fit(&from, model.prepared.bounds, aspect);
                }
                Action::Unpick => {
                    model.picked = None;
                    self.told.picked.clear();
                }
            }
        }
        self.looks.turn(model.prepared.bounds);
    }

    /// Requests and collects frames of the session. Returns whether another picture must follow at once.
    fn advance(&mut self, size: (u32, u32)) -> Result<bool, String> {
        let waiting = self.loading.is_some();
        let options = self.session_options();
        let Some(model) = &mut self.model else { return Ok(waiting) };
        if model.workers != self.looks.workers {
            model.session = session_of(&model.prepared, &options).map_err(|error| error.to_string())?;
            (model.workers, model.underway) = (self.looks.workers, None);
        }
        if self.scene.keep_lattice(self.looks.picture.lattice).map_err(|error| error.to_string())? {
            // Send all tiles again, with or without lattice positions.
            model.session.forget();
            (model.underway, model.shown) = (None, None);
        }
        let failed = |error: FrameError| error.to_string();
        let wanted = self.looks.picture.view(&self.looks.camera, size);
        if model.underway.is_none() {
            model.session.begin(&[wanted]).map_err(failed)?;
        }
        // None again if the frame fails: it is not shown.
        let view = model.underway.take().unwrap_or(wanted);
        // Most frames of a moving camera are finished within this time.
        let report = if self.patient {
            model.session.finish(&mut self.scene).map(Some)
        } else {
            model.session.finish_within(AWAITED, &mut self.scene)
        };
        if let Some(report) = report.map_err(failed)? {
            (model.shown, model.deferred) = (Some(view), report.deferred > 0);
            if report.batches > 0 {
                (self.told.costs.frame, self.told.costs.sent) = (report, self.scene.uploaded());
            }
            if let Err(short) = self.loader.limits.check(model.session.shortfall()) {
                if self.patient {
                    return Err(short.to_string());
                }
                self.told.trouble = Some(short.to_string());
            }
        } else {
            model.underway = Some(view);
            if model.shown.is_none() {
                self.told.underway = Some("tessellating …".to_owned());
            }
        }
        let is_old = model.shown != Some(wanted);
        Ok(waiting || model.underway.is_some() || model.deferred || is_old || self.looks.turning)
    }

    /// Draws the last complete frame to the scene texture.
    fn draw(&mut self, size: (u32, u32)) -> Result<(), String> {
        let picture = match self.picture.take().filter(|picture| (picture.width(), picture.height()) == size) {
            Some(picture) => picture,
            None => {
                let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
                let picture = texture(&self.device, size, PICTURE_FORMAT, usage);
                self.painter.show(&picture);
                picture
            }
        };
        let picked = self.model.as_ref().and_then(|model| model.picked);
        self.scene.highlight(picked.map(|picked| (picked.instance, picked.face)));
        let camera = self.model.as_ref().and_then(|model| model.shown).map_or(self.looks.camera, |view| view.camera);
        let bounds = self.model.as_ref().and_then(|model| model.prepared.bounds);
        let options: RenderOptions = self.looks.picture.options(camera, size, bounds);
        let start = Instant::now();
        let drew = self.scene.draw(&picture.create_view(&TextureViewDescriptor::default()), 0, &options);
        self.told.costs.drawn = start.elapsed();
        self.told.costs.drew = drew.map_err(|error| error.to_string())?;
        self.told.costs.held = self.scene.held();
        self.picture = Some(picture);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Common;
    use crate::render::PictureArgs;
    use clap::Parser;
    use std::path::PathBuf;
    use trimtess::out::wgpu::Renderer;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        common: Common,
        #[command(flatten)]
        picture: PictureArgs,
    }

    /// An off-screen viewer of 400 by 300 points; `None` without a graphics adapter.
    fn viewer() -> Option<(Viewer, Renderer, Texture)> {
        let renderer = Renderer::new().ok()?;
        let target = texture(renderer.device(), (400, 300), PICTURE_FORMAT, TextureUsages::RENDER_ATTACHMENT);
        let line = Line::parse_from(["trimtess"]);
        let looks = Looks {
            camera: ViewPoint::ISO.fit([], 1.0),
            picture: line.picture,
            workers: 1,
            turning: false,
            panel: true,
        };
        let loader = Loader::new(&line.common);
        let viewer = Viewer::new(renderer.device(), renderer.queue(), PICTURE_FORMAT, loader, looks);
        Some((viewer.unwrap_or_else(|error| panic!("{error}")), renderer, target))
    }

    fn step(
        viewer: &mut Viewer,
        target: &Texture,
        time: &mut f64,
        events: Vec<egui::Event>,
        dropped: &[&str],
    ) -> Shown {
        *time += 0.1;
        let file = |path: &&str| egui::DroppedFile { path: Some(PathBuf::from(path)), ..egui::DroppedFile::default() };
        let input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(400.0, 300.0))),
            time: Some(*time),
            events,
            dropped_files: dropped.iter().map(file).collect(),
            ..egui::RawInput::default()
        };
        let view = target.create_view(&TextureViewDescriptor::default());
        let canvas = Canvas { target: &view, size: (400, 300), pixels_per_point: 1.0 };
        viewer.picture(input, &canvas).unwrap_or_else(|error| panic!("{error}"))
    }

    fn pressed(key: egui::Key) -> egui::Event {
        egui::Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: egui::Modifiers::NONE }
    }

    /// Draws pictures until no other must follow.
    fn settle(viewer: &mut Viewer, target: &Texture, time: &mut f64) {
        let start = Instant::now();
        while step(viewer, target, time, Vec::new(), &[]).again {
            assert!(start.elapsed() < Duration::from_secs(60), "{:?}", viewer.told);
        }
    }

    #[test]
    fn dropped_files_are_opened_and_errors_keep_the_last_model() {
        let Some((mut viewer, _renderer, target)) = viewer() else { return };
        let mut time = 0.0;
        settle(&mut viewer, &target, &mut time);
        assert_eq!(viewer.told.costs.drew.triangles, 0);
        viewer.open(Input::Builtin("torus".to_owned()));
        settle(&mut viewer, &target, &mut time);
        assert_eq!(viewer.told.name, "builtin:torus");
        let drawn = viewer.told.costs.drew.triangles;
        assert!(drawn > 100);
        step(&mut viewer, &target, &mut time, Vec::new(), &["no such file.step"]);
        settle(&mut viewer, &target, &mut time);
        let trouble = viewer.told.trouble.clone().unwrap_or_default();
        assert!(trouble.contains("no such file"), "{trouble}");
        assert_eq!((viewer.told.name.as_str(), viewer.told.costs.drew.triangles), ("builtin:torus", drawn));
        let cube = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/data/red_cube_blue_cylinder.step");
        step(&mut viewer, &target, &mut time, Vec::new(), &[cube]);
        settle(&mut viewer, &target, &mut time);
        assert_eq!((viewer.told.name.as_str(), &viewer.told.trouble), ("red_cube_blue_cylinder.step", &None));
    }

    #[test]
    fn the_pointer_orbits_pans_zooms_and_picks() {
        let Some((mut viewer, _renderer, target)) = viewer() else { return };
        let mut time = 0.0;
        viewer.open(Input::Builtin("box".to_owned()));
        viewer.looks.panel = false;
        settle(&mut viewer, &target, &mut time);
        let start = viewer.looks.camera;
        let at = egui::pos2(200.0, 150.0);
        let button = |pos, button, pressed| egui::Event::PointerButton {
            pos,
            button,
            pressed,
            modifiers: egui::Modifiers::NONE,
        };
        let mut drag = |viewer: &mut Viewer, which| {
            let to = at + egui::vec2(40.0, 0.0);
            for events in [
                vec![egui::Event::PointerMoved(at)],
                vec![button(at, which, true)],
                vec![egui::Event::PointerMoved(to)],
                vec![button(to, which, false)],
            ] {
                step(viewer, &target, &mut time, events, &[]);
            }
            settle(viewer, &target, &mut time);
            viewer.looks.camera
        };
        let turned = drag(&mut viewer, egui::PointerButton::Primary);
        assert!((turned.view_point().yaw - start.view_point().yaw + 24.0).abs() < 0.5, "{:?}", turned.view_point());
        let slid = drag(&mut viewer, egui::PointerButton::Secondary);
        assert!(slid.view_point().yaw - turned.view_point().yaw < 1e-6 && slid.eye.distance(turned.eye) > 0.1);
        assert!(viewer.told.picked.is_empty(), "a drag is no click");

        for events in [
            vec![egui::Event::PointerMoved(at)],
            vec![button(at, egui::PointerButton::Primary, true)],
            vec![button(at, egui::PointerButton::Primary, false)],
        ] {
            step(&mut viewer, &target, &mut time, events, &[]);
        }
        assert!(viewer.told.picked.contains(&("surface", "plane".to_owned())), "{:?}", viewer.told.picked);
        let wheel = egui::Event::MouseWheel {
            unit: egui::MouseWheelUnit::Point,
            delta: egui::vec2(0.0, 100.0),
            modifiers: egui::Modifiers::NONE,
        };
        step(&mut viewer, &target, &mut time, vec![wheel], &[]);
        (0..10).for_each(|_| drop(step(&mut viewer, &target, &mut time, Vec::new(), &[])));
        let closer = viewer.looks.camera;
        assert!(closer.eye.distance(closer.target()) < 0.9 * slid.eye.distance(slid.target()));

        let keys = [egui::Key::Num5, egui::Key::W, egui::Key::Escape].map(pressed).to_vec();
        step(&mut viewer, &target, &mut time, keys, &[]);
        settle(&mut viewer, &target, &mut time);
        assert!(viewer.looks.picture.wireframe && viewer.told.picked.is_empty());
        assert!((viewer.looks.camera.view_point().pitch - 90.0).abs() < 1e-3);
    }

    #[test]
    fn lattices_are_stored_while_shown_and_cameras_become_orthographic() {
        let Some((mut viewer, _renderer, target)) = viewer() else { return };
        let mut time = 0.0;
        viewer.open(Input::Builtin("torus".to_owned()));
        settle(&mut viewer, &target, &mut time);
        let (held, triangles) = (viewer.told.costs.held.vertices, viewer.told.costs.drew.triangles);
        let mut press = |viewer: &mut Viewer, key| {
            step(viewer, &target, &mut time, vec![pressed(key)], &[]);
            settle(viewer, &target, &mut time);
            (viewer.told.costs.held.vertices, viewer.told.costs.drew.triangles)
        };
        assert_eq!(press(&mut viewer, egui::Key::L), (held / 2 * 3, triangles));
        assert_eq!(press(&mut viewer, egui::Key::L), (held, triangles));
        let seen_from = viewer.looks.camera;
        press(&mut viewer, egui::Key::O);
        assert!(
            viewer.looks.camera.is_orthographic() && viewer.model.as_ref().is_some_and(|model| model.shown.is_some())
        );
        press(&mut viewer, egui::Key::Num1);
        assert!(viewer.looks.camera.is_orthographic());
        press(&mut viewer, egui::Key::O);
        assert_eq!(viewer.looks.camera.projection, seen_from.projection);
    }

    #[test]
    fn changing_the_number_of_workers_restarts_the_session() {
        let Some((mut viewer, _renderer, target)) = viewer() else { return };
        let mut time = 0.0;
        viewer.open(Input::Builtin("washer".to_owned()));
        settle(&mut viewer, &target, &mut time);
        let triangles = viewer.told.costs.drew.triangles;
        viewer.looks.workers = 3;
        settle(&mut viewer, &target, &mut time);
        // Four workers on each of three threads.
        assert_eq!(viewer.model.as_ref().map(|model| model.session.workers()), Some(12));
        assert_eq!(viewer.told.costs.drew.triangles, triangles);
    }
}
