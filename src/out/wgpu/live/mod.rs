//! A scene on the graphics device: tiles to buffer ranges, to draws, to pictures.

mod encode;
mod pages;
mod staging;
mod store;
mod device_scene;
mod pending;
mod records;
mod lists;
mod uniforms;

mod scene;
pub use scene::{DeviceMemory, DrawStats, LiveScene};

mod sink;

mod pick;
pub use pick::PickHit;
