//! The panel: settings of the viewer, costs of the last frame, facts of the picked face.

use crate::render::{Cut, PictureArgs};
use egui::{Grid, RichText, Slider, Ui};
use std::time::Duration;
use trimtess::glam::DVec3;
use trimtess::out::wgpu::{ColourBy, DeviceMemory, DrawStats};
use trimtess::parallel::{FrameReport, WorkerMetrics};
use trimtess::view::{Camera, ViewPoint, box_corners};

/// The user's settings.
#[derive(Clone, Debug)]
pub(super) struct Looks {
    pub(super) camera: Camera,
    /// Picture options. The camera above replaces `camera` and `orthographic`.
    pub(super) picture: PictureArgs,
    pub(super) workers: usize,
    /// The model turns by itself.
    pub(super) turning: bool,
    pub(super) panel: bool,
}

/// Degrees per frame by which the model turns by itself.
const TURN: f64 = 0.5;

/// A one-time action.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Action {
    /// Fits the model in the picture, seen from this side.
    Fit(ViewPoint),
    /// Fits the model in the picture, seen from the current side.
    FitHere,
    /// Clears the picked face.
    Unpick,
}

impl Looks {
    /// The standard view points with their names and keys, 1 to 7: "front" first, "iso" last.
    pub(super) fn sides() -> impl Iterator<Item = (&'static str, usize, ViewPoint)> {
        let named = ViewPoint::NAMED.iter().cycle().skip(1).zip(1..=ViewPoint::NAMED.len());
        named.map(|(&(name, from), key)| (name, key, from))
    }

    /// Fits the camera to a box.
    pub(super) fn fit(&mut self, from: &ViewPoint, bounds: Option<[DVec3; 2]>, aspect: f64) {
        if let Some(bounds) = bounds {
            self.camera = from.fit_as(self.camera.is_orthographic(), box_corners(bounds), aspect);
        }
    }

    /// Switches between orthographic and perspective. Objects at the depth of the target keep their size.
    pub(super) fn set_orthographic(&mut self, orthographic: bool) {
        self.camera = if orthographic { self.camera.orthographic() } else { self.camera.perspective() };
    }

    /// Turns the model by one frame's angle if `turning` is set.
    pub(super) fn turn(&mut self, bounds: Option<[DVec3; 2]>) {
        if let Some([low, high]) = bounds.filter(|_| self.turning) {
            self.camera = self.camera.orbit(0.5 * (low + high), TURN.to_radians(), 0.0);
        }
    }

    /// Applies the pressed keys. Returns the actions they trigger.
    pub(super) fn keys(&mut self, input: &egui::InputState) -> Vec<Action> {
        use egui::Key;
        let mut actions = Vec::new();
        let toggle = |key, what: &mut bool| *what ^= input.key_pressed(key);
        toggle(Key::W, &mut self.picture.wireframe);
        toggle(Key::L, &mut self.picture.lattice);
        toggle(Key::E, &mut self.picture.edges);
        toggle(Key::B, &mut self.picture.backfaces);
        toggle(Key::T, &mut self.turning);
        toggle(Key::P, &mut self.panel);
        if input.key_pressed(Key::O) {
            self.set_orthographic(!self.camera.is_orthographic());
        }
        if input.key_pressed(Key::C) {
            let now = ColourBy::ALL.iter().position(|by| *by == self.picture.color_by).unwrap_or(0);
            self.picture.color_by = ColourBy::ALL[(now + 1) % ColourBy::ALL.len()];
        }
        if input.key_pressed(Key::F) {
            actions.push(Action::FitHere);
        }
        if input.key_pressed(Key::Escape) {
            actions.push(Action::Unpick);
        }
        let digits = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7];
        for (_, number, from) in Self::sides() {
            if input.key_pressed(digits[number - 1]) {
                actions.push(Action::Fit(from));
            }
        }
        actions
    }
}

/// Width of the panel in points.
pub(super) const WIDTH: f32 = 260.0;

/// Costs of the last frame that changed something, by stage.
#[derive(Clone, Debug, Default)]
pub(super) struct Costs {
    pub(super) frame: FrameReport,
    /// Bytes of its tiles.
    pub(super) sent: u64,
    pub(super) drawn: Duration,
    /// Time between two pictures of the window.
    pub(super) between: Duration,
    pub(super) drew: DrawStats,
    pub(super) held: DeviceMemory,
}

/// Texts shown in the panel.
#[derive(Clone, Debug, Default)]
pub(super) struct PanelText {
    pub(super) name: String,
    pub(super) counts: Vec<(&'static str, String)>,
    pub(super) picked: Vec<(&'static str, String)>,
    /// Work in progress.
    pub(super) underway: Option<String>,
    /// The last error.
    pub(super) trouble: Option<String>,
    pub(super) costs: Costs,
}

/// Draws the panel. Returns the actions that its buttons trigger.
pub(super) fn panel(ui: &mut Ui, looks: &mut Looks, told: &PanelText) -> Vec<Action> {
    let mut actions = Vec::new();
    ui.add_space(4.0);
    ui.label(RichText::new(&told.name).strong().size(15.0));
    rows(ui, "counts", &told.counts);
    if let Some(underway) = &told.underway {
        ui.label(RichText::new(underway).italics());
    }
    if let Some(trouble) = &told.trouble {
        ui.label(RichText::new(trouble).color(egui::Color32::from_rgb(240, 130, 90)));
    }
    ui.separator();
    ui.horizontal_wrapped(|ui| {
        for (name, key, from) in Looks::sides() {
            if ui.button(name).on_hover_text(format!("key {key}")).clicked() {
                actions.push(Action::Fit(from));
            }
        }
        if ui.button("fit").on_hover_text("key F").clicked() {
            actions.push(Action::FitHere);
        }
    });
    let mut orthographic = looks.camera.is_orthographic();
    if ui.checkbox(&mut orthographic, "orthographic").on_hover_text("key O").changed() {
        looks.set_orthographic(orthographic);
    }
    ui.separator();
    ui.spacing_mut().item_spacing = egui::vec2(6.0, 3.0);
    ui.horizontal_wrapped(|ui| {
        for by in ColourBy::ALL {
            ui.selectable_value(&mut looks.picture.color_by, *by, by.name());
        }
    });
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(&mut looks.picture.wireframe, "wireframe");
        ui.checkbox(&mut looks.picture.lattice, "lattice");
        ui.checkbox(&mut looks.picture.edges, "edges");
        ui.checkbox(&mut looks.picture.backfaces, "backfaces");
        ui.checkbox(&mut looks.turning, "turn");
    });
    section(ui, &mut looks.picture.section);
    ui.separator();
    ui.add(Slider::new(&mut looks.picture.deviation_px, 0.1..=20.0).logarithmic(true).suffix(" px").text("deviation"));
    let mut limited = looks.picture.size_px.is_some();
    ui.checkbox(&mut limited, "limit the size of triangles");
    if limited {
        let mut size = looks.picture.size_px.unwrap_or(24.0);
        ui.add(Slider::new(&mut size, 2.0..=200.0).logarithmic(true).suffix(" px").text("size"));
        looks.picture.size_px = Some(size);
    } else {
        looks.picture.size_px = None;
    }
    let most = looks.workers.max(2 * std::thread::available_parallelism().map_or(1, usize::from));
    ui.add(Slider::new(&mut looks.workers, 1..=most).text("threads"));
    ui.separator();
    rows(ui, "costs", &costs(&told.costs));
    if !told.picked.is_empty() {
        ui.separator();
        rows(ui, "picked", &told.picked);
    }
    ui.separator();
    let hint = "drag: orbit · right drag: pan · wheel: zoom\nclick: pick a face · drop a file: open it\n\
                keys: W L E B T C P F O 1–7 Esc";
    ui.label(RichText::new(hint).weak().small());
    actions
}

/// Where the model is cut open.
fn section(ui: &mut Ui, section: &mut Option<Cut>) {
    ui.horizontal(|ui| {
        ui.label("section");
        ui.selectable_value(section, None, "none");
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let chosen = section.is_some_and(|cut| cut.axis == axis);
            if ui.selectable_label(chosen, name).clicked() {
                *section = Some(Cut { axis, ..section.unwrap_or(Cut::MIDDLE) });
            }
        }
        if let Some(cut) = section {
            ui.checkbox(&mut cut.flipped, "flip");
        }
    });
    if let Some(cut) = section {
        ui.add(Slider::new(&mut cut.share, 0.0..=1.0).text("cut at"));
    }
}

/// The table of a frame's costs.
fn costs(costs: &Costs) -> Vec<(&'static str, String)> {
    let ms = |time: Duration| format!("{:.2} ms", 1e3 * time.as_secs_f64());
    let FrameReport { planned_in, made_in, committed_in, tiles, workers, .. } = &costs.frame;
    let busy = || workers.iter().map(WorkerMetrics::busy);
    let busiest = busy().max().unwrap_or_default();
    let mean = busy().sum::<Duration>().checked_div(workers.len() as u32).unwrap_or_default();
    let between = costs.between.as_secs_f64();
    vec![
        ("plan", ms(*planned_in)),
        ("tiles made", format!("{tiles} in {}", ms(*made_in))),
        ("busiest worker", ms(busiest)),
        ("mean worker", ms(mean)),
        ("commit", ms(*committed_in)),
        ("draws", format!("{} of {} tiles in {}", costs.drew.draws, costs.drew.tiles, ms(costs.drawn))),
        ("pictures", if between > 0.0 { format!("{:.0} / s", 1.0 / between) } else { "–".to_owned() }),
        ("triangles", thousands(costs.drew.triangles)),
        ("sent", bytes(costs.sent + costs.drew.bytes)),
        ("held", bytes(costs.held.total())),
    ]
}

fn rows(ui: &mut Ui, id: &str, rows: &[(&'static str, String)]) {
    Grid::new(id).num_columns(2).spacing([10.0, 1.0]).min_row_height(0.0).show(ui, |ui| {
        for (name, value) in rows {
            ui.label(RichText::new(*name).weak());
            ui.add(egui::Label::new(value).wrap());
            ui.end_row();
        }
    });
}

fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().filter_map(|group| std::str::from_utf8(group).ok()).collect();
    groups.join(" ")
}

fn bytes(count: u64) -> String {
    match count {
        0..10_000 => format!("{count} B"),
        10_000..10_000_000 => format!("{:.1} kB", count as f64 / 1e3),
        _ => format!("{:.1} MB", count as f64 / 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped_and_bytes_have_units() {
        assert_eq!([0, 999, 1_000, 1_234_567].map(thousands), ["0", "999", "1 000", "1 234 567"]);
        assert_eq!([17, 12_345, 12_345_678].map(bytes), ["17 B", "12.3 kB", "12.3 MB"]);
    }
}
