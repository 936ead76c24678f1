//! Calls of a page to pictures of a model on its canvas.

use crate::canvas::Canvas;
use crate::looks::{self, Looks, Settings};
use crate::model::Prepared;
use crate::show::{Pick, Picked, Show};
use serde::Serialize;
use std::cell::RefCell;
use std::f64::consts::PI;
use std::rc::Rc;
use std::sync::Arc;
use trimtess::model::InstanceId;
use trimtess::out::wgpu::{DrawStats, Image, LiveScene, PickHit, Picking, RenderOptions};
use trimtess::parallel::FrameReport;
use trimtess::view::{Camera, ViewPoint};
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;
use wasm_bindgen::{JsCast, JsError, JsValue};
use wasm_bindgen_futures::JsFuture;
use web_sys::OffscreenCanvas;

/// Draws models on a canvas. All calls are made on the thread that made it.
#[wasm_bindgen]
pub struct Viewer {
    state: Rc<RefCell<State>>,
}

struct State {
    canvas: Canvas,
    scene: LiveScene,
    show: Option<Show>,
    /// Number of models that were shown.
    shown: u64,
    camera: Camera,
    looks: Looks,
    /// A look for the pivot that is on its way.
    press: Option<Picking>,
    drawn: DrawStats,
}

/// The graphics device.
#[derive(Serialize, Tsify)]
pub struct Adapter {
    #[tsify(type = "\"webgpu\" | \"webgl2\"")]
    backend: &'static str,
    name: String,
}

/// What a picture cost.
#[derive(Default, Serialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct Step {
    /// Another picture must follow.
    again: bool,
    plan_ms: f64,
    make_ms: f64,
    /// Tiles made for this picture.
    tiles: usize,
    /// Tiles that get finer in later pictures.
    deferred: u32,
    /// Triangles of the picture, instances counted.
    triangles: u64,
    /// Tiles of the picture, instances counted.
    drawn_tiles: usize,
    sent_bytes: u64,
    held_bytes: u64,
    /// Where the picked point is, pixels.
    #[tsify(optional)]
    #[serde(skip_serializing_if = "Option::is_none")]
    mark: Option<[f64; 2]>,
}

#[wasm_bindgen]
impl Viewer {
    /// Opens a graphics device on a canvas: `webgpu`, `webgl2`, or the better one there is for an empty text.
    pub async fn create(canvas: OffscreenCanvas, gpu: String) -> Result<Viewer, JsError> {
        let canvas = Canvas::open(canvas, &gpu).await?;
        let scene = LiveScene::new(&canvas.device, &canvas.queue, canvas.format).map_err(crate::told)?;
        let state = State {
            canvas,
            scene,
            show: None,
            shown: 0,
            camera: ViewPoint::ISO.fit([], 1.0),
            looks: Looks::default(),
            press: None,
            drawn: DrawStats::default(),
        };
        Ok(Self { state: Rc::new(RefCell::new(state)) })
    }

    /// The device that draws.
    pub fn adapter(&self) -> Result<Ts<Adapter>, JsError> {
        let state = self.state.borrow();
        Ok(Adapter { backend: state.canvas.backend, name: state.canvas.name.clone() }.into_ts()?)
    }

    /// Shows a model, seen as a whole.
    pub fn show(&self, prepared: &Prepared) -> Result<(), JsError> {
        let state = &mut *self.state.borrow_mut();
        // The scene stays: another one compiles its shaders again, a quarter of a second in software.
        let before = state.show.as_ref().map_or(0, |show| show.session.scene().instances.len());
        (0..before).for_each(|row| state.scene.set_visible(InstanceId::new(row), true));
        state.show = Some(Show::new(Arc::clone(prepared.of())));
        state.shown += 1;
        state.press = None;
        state.fit(&ViewPoint::ISO);
        Ok(())
    }

    /// Changes the size of the canvas, in its pixels.
    pub fn resize(&self, width: u32, height: u32) {
        self.state.borrow_mut().canvas.resize(width, height);
    }

    /// Why the graphics device is lost, if it is: it needs a new canvas and a new viewer.
    #[must_use]
    pub fn lost(&self) -> Option<String> {
        self.state.borrow().canvas.lost()
    }

    /// Draws a picture: changes that fit in its time, then the rest with the next ones.
    pub fn step(&self) -> Result<Ts<Step>, JsError> {
        Ok(self.state.borrow_mut().step()?.into_ts()?)
    }

    /// Looks for the point under a pixel, which orbits and pans are about.
    pub fn press(&self, x: f64, y: f64) -> Result<(), JsError> {
        let state = &mut *self.state.borrow_mut();
        state.press = state.begin_pick(x, y)?;
        Ok(())
    }

    /// Turns the camera. A drag over the height of the picture is half a turn.
    pub fn orbit(&self, dx: f64, dy: f64) {
        let state = &mut *self.state.borrow_mut();
        if !(dx.is_finite() && dy.is_finite()) {
            return;
        }
        let angle = PI / f64::from(state.canvas.size().1);
        let pivot = state.pivot();
        state.camera = state.camera.orbit(pivot, angle * dx, -angle * dy);
    }

    /// Moves what is under the first pixel to the second.
    pub fn pan(&self, from_x: f64, from_y: f64, to_x: f64, to_y: f64) {
        let state = &mut *self.state.borrow_mut();
        if ![from_x, from_y, to_x, to_y].iter().all(|pixel| pixel.is_finite()) {
            return;
        }
        let (pivot, size) = (state.pivot(), state.size());
        state.camera = state.camera.pan(pivot, [from_x, from_y], [to_x, to_y], size);
    }

    /// Multiplies the distance to what is under a pixel.
    pub fn zoom(&self, x: f64, y: f64, factor: f64) -> Result<(), JsError> {
        if !(x.is_finite() && y.is_finite() && factor.is_finite() && factor > 0.0) {
            return Ok(());
        }
        let state = &mut *self.state.borrow_mut();
        if state.press.is_none() {
            state.press = state.begin_pick(x, y)?;
        }
        // The point that was found last is as deep as what is there, or nearly so.
        let point = state.camera.at_depth_of(state.pivot(), [x, y], state.size());
        state.camera = state.camera.zoom(point, factor);
        Ok(())
    }

    /// Shows the whole model from a side by name.
    pub fn side(&self, name: &str) -> Result<(), JsError> {
        let from: ViewPoint = name.parse().map_err(crate::told)?;
        self.state.borrow_mut().fit(&from);
        Ok(())
    }

    /// Shows the whole model from the present side.
    pub fn fit(&self) {
        let state = &mut *self.state.borrow_mut();
        state.fit(&state.camera.view_point());
    }

    /// Chooses parallel lines of sight, or perspective.
    pub fn orthographic(&self, on: bool) {
        let state = &mut *self.state.borrow_mut();
        state.camera = if on { state.camera.orthographic() } else { state.camera.perspective() };
    }

    /// The camera as eleven numbers: eye, direction, up, 1 for an orthographic one, and its height or angle.
    #[wasm_bindgen(js_name = cameraState)]
    pub fn camera_state(&self) -> Vec<f64> {
        looks::numbers(&self.state.borrow().camera)
    }

    /// Takes over a camera of `cameraState`. Returns whether the numbers are one's.
    #[wasm_bindgen(js_name = setCameraState)]
    pub fn set_camera_state(&self, numbers: &[f64]) -> bool {
        let camera = looks::camera(numbers);
        camera.into_iter().for_each(|camera| self.state.borrow_mut().camera = camera);
        camera.is_some()
    }

    /// Changes settings of the picture.
    pub fn set(&self, settings: Ts<Settings>) -> Result<(), JsError> {
        self.state.borrow_mut().looks.set(settings.to_rust()?).map_err(crate::told)
    }

    /// Shows or hides an instance.
    #[wasm_bindgen(js_name = setVisible)]
    pub fn set_visible(&self, instance: u32, visible: bool) {
        self.state.borrow_mut().scene.set_visible(InstanceId(instance), visible);
    }

    /// Finds the face under a pixel, and has it stand out. Nothing stands out where there is none.
    #[wasm_bindgen(unchecked_return_type = "Pick | undefined")]
    pub async fn pick(&self, x: f64, y: f64) -> Result<Option<Ts<Pick>>, JsError> {
        let state = Rc::clone(&self.state);
        let (picking, shown) = {
            let mut state = state.borrow_mut();
            (state.begin_pick(x, y)?, state.shown)
        };
        let hit = match picking {
            Some(picking) => answer(|| state.borrow().scene.poll_pick(&picking)).await?.map_err(crate::told)?,
            None => None,
        };
        let state = &mut *state.borrow_mut();
        // The answer is of the model that was shown then.
        let Some(show) = state.show.as_mut().filter(|_| state.shown == shown) else { return Ok(None) };
        show.picked = hit.map(|PickHit { instance, face, point, .. }| Picked { face: Some((instance, face)), point });
        Ok(hit.map(|hit| show.pick(&hit).into_ts()).transpose()?)
    }

    /// Nothing is picked any more.
    pub fn unpick(&self) {
        self.state.borrow_mut().show.iter_mut().for_each(|show| show.picked = None);
    }

    /// Shows the face or the place of a diagnostic, by its number. Returns whether it has one.
    #[wasm_bindgen(js_name = showDiagnostic)]
    pub fn show_diagnostic(&self, number: usize) -> bool {
        let state = &mut *self.state.borrow_mut();
        let aspect = state.aspect();
        let Some(show) = &mut state.show else { return false };
        let camera = show.show_diagnostic(number, &state.camera, aspect);
        state.camera = camera.unwrap_or(state.camera);
        camera.is_some()
    }

    /// Draws the picture once more and reads it back: red, green, blue (sRGB) and alpha, row by row from the top.
    pub async fn pixels(&self) -> Result<Vec<u8>, JsError> {
        let reading = self.state.borrow_mut().begin_read()?;
        let Image { mut pixels, .. } = answer(|| reading.poll()).await?.map_err(crate::told)?;
        let is_blue_first = self.state.borrow().canvas.format == wgpu::TextureFormat::Bgra8UnormSrgb;
        pixels.chunks_exact_mut(4).filter(|_| is_blue_first).for_each(|pixel| pixel.swap(0, 2));
        Ok(pixels)
    }
}

impl State {
    fn size(&self) -> [f64; 2] {
        let (width, height) = self.canvas.size();
        [f64::from(width), f64::from(height)]
    }

    fn aspect(&self) -> f64 {
        let [width, height] = self.size();
        width / height
    }

    fn options(&self) -> RenderOptions {
        let bounds = self.show.as_ref().and_then(|show| show.prepared.bounds);
        self.looks.options(self.camera, self.canvas.size(), bounds)
    }

    fn pivot(&self) -> trimtess::glam::DVec3 {
        self.show.as_ref().map_or(self.camera.target(), |show| show.pivot)
    }

    fn fit(&mut self, from: &ViewPoint) {
        let aspect = self.aspect();
        let Some(show) = &mut self.show else { return };
        self.camera = from.fit_as(self.camera.is_orthographic(), show.corners(), aspect);
        show.pivot = self.camera.target();
    }

    fn begin_pick(&mut self, x: f64, y: f64) -> Result<Option<Picking>, JsError> {
        let options = self.options();
        if self.show.is_none() || x < 0.0 || y < 0.0 {
            return Ok(None);
        }
        self.scene.begin_pick((x as u32, y as u32), 0, &options).map_err(crate::told)
    }

    fn begin_read(&mut self) -> Result<trimtess::out::wgpu::ImageReading, JsError> {
        let options = self.options();
        let texture = self.canvas.texture(wgpu::TextureUsages::COPY_SRC);
        let target = texture.create_view(&wgpu::TextureViewDescriptor::default());
        self.scene.draw(&target, 0, &options).map_err(crate::told)?;
        Image::begin_read(&self.canvas.device, &self.canvas.queue, &texture).map_err(crate::told)
    }

    fn step(&mut self) -> Result<Step, JsError> {
        self.land_press()?;
        let report = self.advance()?;
        let options = self.options();
        let Self { canvas, scene, show, .. } = self;
        let picked = show.as_ref().and_then(|show| show.picked);
        scene.highlight(picked.and_then(|picked| picked.face));
        let drawn = canvas.present(|target| scene.draw(target, 0, &options).map_err(crate::told))?;
        let ms = |time: std::time::Duration| 1e3 * time.as_secs_f64();
        let hidden = drawn.is_none();
        self.drawn = drawn.unwrap_or(self.drawn);
        Ok(Step {
            again: hidden || report.deferred > 0 || self.press.is_some(),
            plan_ms: ms(report.planned_in),
            make_ms: ms(report.made_in),
            tiles: report.tiles,
            deferred: report.deferred,
            triangles: self.drawn.triangles,
            drawn_tiles: self.drawn.tiles,
            sent_bytes: self.drawn.bytes + if report.batches > 0 { self.scene.uploaded() } else { 0 },
            held_bytes: self.scene.held().total(),
            mark: picked.and_then(|picked| self.camera.pixel_of(picked.point, self.size())),
        })
    }

    /// Takes the point that a press found.
    fn land_press(&mut self) -> Result<(), JsError> {
        let Some(found) = self.press.as_ref().and_then(|press| self.scene.poll_pick(press)) else { return Ok(()) };
        self.press = None;
        let hit = found.map_err(crate::told)?;
        if let (Some(show), Some(hit)) = (&mut self.show, hit) {
            show.pivot = hit.point;
        }
        Ok(())
    }

    /// Has the session bring the scene up to date.
    fn advance(&mut self) -> Result<FrameReport, JsError> {
        let view = self.looks.view(self.camera, self.canvas.size());
        let Some(show) = &mut self.show else { return Ok(FrameReport::default()) };
        if self.scene.keep_lattice(self.looks.options.lattice).map_err(crate::told)? {
            // Send all tiles again, with or without lattice positions.
            show.session.forget();
        }
        show.session.begin(&[view]).map_err(crate::told)?;
        show.session.finish(&mut self.scene).map_err(crate::told)
    }
}

/// Waits for what comes between two tasks of the browser.
async fn answer<T>(mut poll: impl FnMut() -> Option<T>) -> Result<T, JsError> {
    loop {
        if let Some(found) = poll() {
            return Ok(found);
        }
        let global = js_sys::global();
        let timer = js_sys::Reflect::get(&global, &"setTimeout".into()).ok();
        let timer = timer.and_then(|timer| timer.dyn_into::<js_sys::Function>().ok());
        let timer = timer.ok_or_else(|| JsError::new("there is no setTimeout here"))?;
        let pause = js_sys::Promise::new(&mut |resolve, _| {
            // Without a timer the promise stays open, as in a page that is closed.
            let _ = timer.call2(&global, &resolve, &JsValue::from(1));
        });
        JsFuture::from(pause).await.map_err(|_| JsError::new("the timer failed"))?;
    }
}
