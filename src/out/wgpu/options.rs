//! What a picture shall look like.

use crate::model::Colour;
use crate::out::Camera;
use std::fmt;
use std::str::FromStr;

/// What the colour of a triangle tells.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum ColourBy {
    /// The model's own colours.
    #[default]
    Model,
    /// One colour per part.
    Part,
    /// One colour per face, counted over all instances.
    Face,
    /// One colour per tile.
    Tile,
    /// One colour per worker that made it.
    Worker,
    /// Lattice cells of the tile, from blue (fewest in the frame) to red (most), by their logarithm.
    Rate,
}

impl ColourBy {
    /// Every choice with its name.
    pub const ALL: [(&'static str, Self); 6] = [
        ("model", Self::Model),
        ("part", Self::Part),
        ("face", Self::Face),
        ("tile", Self::Tile),
        ("worker", Self::Worker),
        ("rate", Self::Rate),
    ];
}

/// What is not a [`ColourBy`].
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct BadColourBy {
    /// The text.
    pub text: String,
}

impl fmt::Display for BadColourBy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "nothing to colour by: {:?}; known are", self.text)?;
        for (index, (name, _)) in ColourBy::ALL.iter().enumerate() {
            write!(f, "{} {name}", if index == 0 { "" } else { "," })?;
        }
        Ok(())
    }
}

impl std::error::Error for BadColourBy {}

impl FromStr for ColourBy {
    type Err = BadColourBy;

    fn from_str(text: &str) -> Result<Self, BadColourBy> {
        let known = Self::ALL.iter().find(|(name, _)| *name == text);
        known.map(|(_, by)| *by).ok_or_else(|| BadColourBy { text: text.to_owned() })
    }
}

/// How to draw a frame. [`RenderOptions::DEFAULT`] is a plain shaded picture.
#[derive(Clone, Copy, PartialEq, Debug)]
#[non_exhaustive]
pub struct RenderOptions {
    /// Width and height in pixels, 1280 × 960. At most what the adapter's textures hold, often 16384.
    pub size: (u32, u32),
    /// The camera; `None` (the default) sees the whole frame from [`ViewPoint::ISO`](crate::out::ViewPoint::ISO).
    pub camera: Option<Camera>,
    /// What colours tell, [`ColourBy::Model`].
    pub colour_by: ColourBy,
    /// Whether triangle edges are drawn over the surface, off. They fade where they are only a few pixels long.
    pub wireframe: bool,
    /// Whether the lattice lines of tiles are drawn over the surface, off. They fade where they are only a few pixels apart. In a
    /// [`LiveScene`](super::LiveScene) that keeps them.
    pub lattice: bool,
    /// Whether B-rep edges are drawn over the surface, off. Draws the edge lines that the frame has.
    pub edges: bool,
    /// Whether surfaces seen from behind are magenta, off: turned faces and holes in solids show.
    pub backfaces: bool,
    /// Colours (sRGB) behind the scene at the picture's top and bottom; light greys.
    pub background: [Colour; 2],
}

impl RenderOptions {
    /// Every default, as the fields tell.
    pub const DEFAULT: Self = Self {
        size: (1280, 960),
        camera: None,
        colour_by: ColourBy::Model,
        wireframe: false,
        lattice: false,
        edges: false,
        backfaces: false,
        background: [[0.97, 0.98, 0.99, 1.0], [0.83, 0.86, 0.9, 1.0]],
    };

    /// Sets [`size`](Self::size).
    #[must_use]
    pub const fn with_size(mut self, size: (u32, u32)) -> Self {
        self.size = size;
        self
    }

    /// Sets [`camera`](Self::camera).
    #[must_use]
    pub const fn with_camera(mut self, camera: Option<Camera>) -> Self {
        self.camera = camera;
        self
    }

    /// Sets [`colour_by`](Self::colour_by).
    #[must_use]
    pub const fn with_colour_by(mut self, colour_by: ColourBy) -> Self {
        self.colour_by = colour_by;
        self
    }

    /// Sets [`wireframe`](Self::wireframe).
    #[must_use]
    pub const fn with_wireframe(mut self, wireframe: bool) -> Self {
        self.wireframe = wireframe;
        self
    }

    /// Sets [`lattice`](Self::lattice).
    #[must_use]
    pub const fn with_lattice(mut self, lattice: bool) -> Self {
        self.lattice = lattice;
        self
    }

    /// Sets [`edges`](Self::edges).
    #[must_use]
    pub const fn with_edges(mut self, edges: bool) -> Self {
        self.edges = edges;
        self
    }

    /// Sets [`backfaces`](Self::backfaces).
    #[must_use]
    pub const fn with_backfaces(mut self, backfaces: bool) -> Self {
        self.backfaces = backfaces;
        self
    }

    /// Sets [`background`](Self::background).
    #[must_use]
    pub const fn with_background(mut self, background: [Colour; 2]) -> Self {
        self.background = background;
        self
    }
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}
