//! A frame to a picture, off screen, on whatever graphics adapter there is; software will do.

mod options;
pub use options::{BadColourBy, ColourBy, RenderOptions};

mod palette;

mod chunk;

mod adapter;
pub use adapter::NoAdapter;

mod pipelines;

mod target;

mod renderer;
pub use renderer::{RenderError, Renderer};

mod image;
pub use image::Image;
