//! A scene on the graphics device: tiles to buffer ranges, to draws, to pictures.

mod encode;
mod pages;
mod staging;
mod store;
mod device_scene;
mod pending;
mod records;
mod rows;
mod texels;

mod surface_draw;
pub use surface_draw::{DrawCall, SurfaceDraw};

mod tile_draws;
mod merged;
mod lists;
mod edges;
mod record_rows;
mod uniforms;

mod scene;
pub use scene::{DeviceMemory, DrawStats, LiveScene, SceneInPass};

mod sink;

mod pick;
pub use pick::{PickHit, Picking};
