//! Frames to pictures on any graphics adapter, including software ones: scenes on the device, images in memory.

mod options;
pub use options::{BadColourBy, ColourBy, RenderOptions, Section};

mod palette;

mod error;
pub use error::{NoAdapter, RenderError};

mod formats;

mod layout;

mod surface_input;
pub use surface_input::SurfaceInput;

mod pipelines;

mod scopes;

mod gpu;

#[cfg(not(target_arch = "wasm32"))]
mod adapter;

mod target;

mod live;
pub use live::{DeviceMemory, DrawCall, DrawStats, LiveScene, PickHit, Picking, SceneInPass, SurfaceDraw};

mod image;
pub use image::{Image, ImageReading};

#[cfg(not(target_arch = "wasm32"))]
mod renderer;
#[cfg(not(target_arch = "wasm32"))]
pub use renderer::Renderer;
