//! Numbers to distinct colours: hues a golden section apart in Ottosson's OKLab, at three levels of lightness.

use super::ColourBy;
use crate::mesh::{Batch, Origin};
use crate::model::Colour;
use crate::out::placed::{DEFAULT_COLOUR, srgb};

/// An 8-bit sRGB colour and its opacity.
pub(super) type Srgb = [u8; 4];

/// Colour of the highlighted face. More saturated than any hue.
pub(super) const MARKED: Srgb = [255, 176, 0, 255];

/// Heat map from blue over green to red.
const RAMP: [[f32; 3]; 5] =
    [[0.23, 0.37, 0.85], [0.20, 0.70, 0.85], [0.42, 0.80, 0.40], [0.95, 0.80, 0.28], [0.85, 0.26, 0.21]];

/// The properties of an instance's tile that it may be coloured by.
pub(super) struct TileColours {
    pub(super) part: u32,
    /// The face, numbered across all instances.
    pub(super) face: u32,
    /// The tile within the part.
    pub(super) tile: u32,
    pub(super) worker: u32,
    /// See [`rate`].
    pub(super) rate: f32,
    /// The colour from the model.
    pub(super) own: Option<Colour>,
}

/// Chooses the colour of each tile of each instance.
#[derive(Clone, Copy, PartialEq, Default)]
pub(super) struct Palette {
    by: ColourBy,
    /// The lowest and the highest rate.
    rates: (f32, f32),
}

impl Palette {
    /// A palette for tiles of these rates. Only [`ColourBy::Rate`] consumes `rates`.
    pub(super) fn new(by: ColourBy, rates: impl Iterator<Item = f32>) -> Self {
        let rates = match by {
            ColourBy::Rate => {
                rates.fold((f32::INFINITY, 0.0), |(low, high), rate| (f32::min(low, rate), f32::max(high, rate)))
            }
            _ => (0.0, 0.0),
        };
        Self { by, rates }
    }

    pub(super) fn of(&self, painted: &TileColours) -> Srgb {
        match self.by {
            ColourBy::Model => bytes(painted.own.unwrap_or(DEFAULT_COLOUR)),
            ColourBy::Part => hue(painted.part),
            ColourBy::Face => hue(painted.face),
            // Neighbouring parts start at different hues.
            ColourBy::Tile => hue(painted.tile.wrapping_add(painted.part.wrapping_mul(7))),
            ColourBy::Worker => hue(painted.worker),
            ColourBy::Rate => {
                let (low, high) = self.rates;
                ramp(if high > low { (painted.rate - low) / (high - low) } else { 0.0 })
            }
        }
    }
}

/// Logarithm of the tile's number of lattice cells, from the largest lattice indices of its vertices. Lines outside the
/// trimmed region have no vertices and are not counted.
pub(super) fn rate(batch: &Batch) -> f32 {
    let lines = batch.mesh.origins.iter().filter_map(|origin| match origin {
        Origin::Lattice { i, j } => Some((*i, *j)),
        _ => None,
    });
    let (u, v) = lines.fold((0, 0), |(u, v), (i, j)| (i.max(u), j.max(v)));
    ((u as f32 + 1.0) * (v as f32 + 1.0)).ln()
}

fn ramp(position: f32) -> Srgb {
    let scaled = position.clamp(0.0, 1.0) * (RAMP.len() - 1) as f32;
    let stop = (scaled as usize).min(RAMP.len() - 2);
    let part = scaled - stop as f32;
    let [r, g, b] = std::array::from_fn(|k| RAMP[stop][k] + part * (RAMP[stop + 1][k] - RAMP[stop][k]));
    bytes([r, g, b, 1.0])
}

fn hue(number: u32) -> Srgb {
    let turn = (f64::from(number) * 0.618_033_988_749_894_9 + 0.05).fract() as f32 * std::f32::consts::TAU;
    let lightness = [0.80, 0.70, 0.86][(number % 3) as usize];
    let (a, b) = (0.11 * turn.cos(), 0.11 * turn.sin());
    let l = (lightness + 0.396_337_78 * a + 0.215_803_76 * b).powi(3);
    let m = (lightness - 0.105_561_346 * a - 0.063_854_17 * b).powi(3);
    let s = (lightness - 0.089_484_18 * a - 1.291_485_5 * b).powi(3);
    bytes(srgb([
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_4 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
        1.0,
    ]))
}

fn bytes(colour: [f32; 4]) -> Srgb {
    let [r, g, b, _] = colour.map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8);
    [r, g, b, 255]
}
