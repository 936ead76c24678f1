//! Frames to pictures on any graphics adapter, including software ones: scenes on the device, images in memory.

mod options;
pub use options::{BadColourBy, ColourBy, RenderOptions};

mod palette;

mod error;
pub use error::{NoAdapter, RenderError};

mod formats;

mod layout;

mod pipelines;

mod gpu;

mod adapter;

mod target;

mod live;
pub use live::{DeviceMemory, DrawStats, LiveScene, PickHit};

mod image;
pub use image::Image;

mod renderer;
pub use renderer::Renderer;
