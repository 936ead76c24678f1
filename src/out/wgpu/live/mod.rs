//! A scene on the graphics device: tiles to buffer ranges, to draws, to pictures.

mod device_scene;
mod encode;
mod lists;
mod pages;
mod pending;
mod records;
mod staging;
mod store;
mod uniforms;

mod scene;
pub use scene::{DeviceMemory, DrawStats, LiveScene};

mod sink;

mod pick;
pub use pick::PickHit;
