//! Keys, buttons and sliders to the settings of the view.

use crate::picture::PictureArgs;
use trimtess::glam::DVec3;
use trimtess::out::wgpu::ColourBy;
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
