//! A scene on the graphics device: tiles to buffer ranges, to draws, to pictures.

mod pages;
mod store;
mod device_scene;
mod rows;
mod records;

mod draws;
pub use draws::{DrawCall, SurfaceDraw};

mod uniforms;

mod scene;
pub use scene::{DeviceMemory, DrawStats, LiveScene, SceneInPass};

mod sink;

mod pick;
pub use pick::{PickHit, Picking};
