//! Frames to pictures on any graphics adapter, including software ones: scenes on the device, images in memory.

mod options;
pub use options::{BadColourBy, ColourBy, RenderOptions, Section};

mod palette;

mod pipelines;
pub use pipelines::SurfaceInput;

mod gpu;
pub use gpu::{NoAdapter, RenderError};

mod image;
pub use image::{Image, ImageReading};

mod live;
pub use live::{DeviceMemory, DrawCall, DrawStats, LiveScene, PickHit, Picking, SceneInPass, SurfaceDraw};

#[cfg(not(target_arch = "wasm32"))]
mod renderer;
#[cfg(not(target_arch = "wasm32"))]
pub use renderer::Renderer;
