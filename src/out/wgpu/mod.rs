//! Frames to pictures on any graphics adapter, including software ones: scenes on the device, images in memory.

mod options;
pub use options::{BadColourBy, ColourBy, RenderOptions};

mod palette;

mod error;
pub use error::{NoAdapter, RenderError};

mod formats;
mod layout;

mod adapter;

mod gpu;

mod pipelines;

mod target;

mod live;
pub use live::{DeviceMemory, DrawStats, LiveScene, PickHit};

mod renderer;
pub use renderer::Renderer;

mod image;
pub use image::Image;
