//! Options of a picture: size, camera, colours, line overlays.

use crate::model::Colour;
use crate::view::Camera;
use glam::DVec3;
use std::str::FromStr;

/// What triangles are coloured by.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[non_exhaustive]
pub enum ColourBy {
    /// The model's own colours.
    #[default]
    Model,
    /// One colour per part.
    Part,
    /// One colour per face of each instance.
    Face,
    /// One colour per tile.
    Tile,
    /// One colour per worker, which owns tiles.
    Worker,
    /// Lattice cells of the tile on a logarithmic scale, from blue (fewest in the frame) to red (most).
    Rate,
}

impl ColourBy {
    /// All choices, in the order of declaration.
    pub const ALL: &'static [Self] = &[Self::Model, Self::Part, Self::Face, Self::Tile, Self::Worker, Self::Rate];

    /// The choice as one lower-case word, which [`ColourBy::from_str`] parses.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Model => "model",
            Self::Part => "part",
            Self::Face => "face",
            Self::Tile => "tile",
            Self::Worker => "worker",
            Self::Rate => "rate",
        }
    }
}

/// A text that is not a [`ColourBy`].
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error(
    "cannot colour by {text:?}; known are {}",
    ColourBy::ALL.iter().map(|by| by.name()).collect::<Vec<_>>().join(", ")
)]
pub struct BadColourBy {
    /// The text.
    pub text: String,
}

impl FromStr for ColourBy {
    type Err = BadColourBy;

    fn from_str(text: &str) -> Result<Self, BadColourBy> {
        let known = Self::ALL.iter().find(|by| by.name() == text);
        known.copied().ok_or_else(|| BadColourBy { text: text.to_owned() })
    }
}

/// A plane that cuts a picture.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Section {
    /// A point of the plane, world coordinates.
    pub point: DVec3,
    /// Towards what is cut away. Of any length but 0.
    pub normal: DVec3,
}

impl Section {
    /// A plane across an axis (0 to 2) of a box, at a share of the box: 0 where it begins, 1 where it ends. Cuts away
    /// what lies beyond.
    ///
    /// # Panics
    /// If there is no such axis.
    #[must_use]
    pub fn across([low, high]: [DVec3; 2], axis: usize, share: f64) -> Self {
        Self { point: low.lerp(high, share), normal: DVec3::AXES[axis] }
    }

    /// The same plane, cutting away the other side.
    #[must_use]
    pub fn flipped(self) -> Self {
        Self { normal: -self.normal, ..self }
    }
}

/// Options of a picture. [`RenderOptions::DEFAULT`] is a plain shaded picture.
#[derive(Clone, Copy, PartialEq, Debug)]
#[non_exhaustive]
pub struct RenderOptions {
    /// Width and height in pixels. Limited by the adapter's texture size, often 16384. Default 1280 × 960.
    pub size: (u32, u32),
    /// The camera. `None` (the default) fits the whole frame from [`ViewPoint::ISO`](crate::view::ViewPoint::ISO).
    pub camera: Option<Camera>,
    /// What triangles are coloured by. Default [`ColourBy::Model`].
    pub colour_by: ColourBy,
    /// Draws triangle edges over the surface. They fade out below 6 pixels of length. Default off.
    pub wireframe: bool,
    /// Draws the lattice lines of tiles over the surface. They fade out where they are only a few pixels apart. A
    /// [`LiveScene`](super::LiveScene) needs [`keep_lattice`](super::LiveScene::keep_lattice) for it. Default off.
    pub lattice: bool,
    /// Draws the edge lines of the frame (B-rep edges) over the surface. Default off.
    pub edges: bool,
    /// Paints back-facing surfaces magenta, which shows reversed faces and holes in solids. Default off.
    pub backfaces: bool,
    /// Cuts away what lies beyond a plane, for picks, too. Surfaces that are then seen from behind are flat and darker,
    /// so that solids look cut through. A plane that is not finite cuts nothing. Default `None`.
    pub section: Option<Section>,
    /// Box around what the caller draws into the same depth, world coordinates. Moves the near plane before it, but no
    /// nearer than the camera's own and 1e-4 of the scene's size or distance; in orthographic projection the far plane
    /// behind it, too. `None` (the default), or a box that is not finite: there is only the scene.
    pub other_bounds: Option<[DVec3; 2]>,
    /// Background colours (sRGB) at the top and bottom of the picture. Default light greys.
    pub background: [Colour; 2],
}

impl RenderOptions {
    /// The defaults documented at the fields.
    pub const DEFAULT: Self = Self {
        size: (1280, 960),
        camera: None,
        colour_by: ColourBy::Model,
        wireframe: false,
        lattice: false,
        edges: false,
        backfaces: false,
        section: None,
        other_bounds: None,
        background: [[0.97, 0.98, 0.99, 1.0], [0.83, 0.86, 0.9, 1.0]],
    };
}

options! {
    RenderOptions:
    with_size(size: (u32, u32));
    with_camera(camera: Option<Camera>);
    with_colour_by(colour_by: ColourBy);
    with_wireframe(wireframe: bool);
    with_lattice(lattice: bool);
    with_edges(edges: bool);
    with_backfaces(backfaces: bool);
    with_section(section: Option<Section>);
    with_other_bounds(other_bounds: Option<[DVec3; 2]>);
    with_background(background: [Colour; 2]);
}
