//! A scene on the graphics device: tiles to buffer ranges, to draws, to pictures.

mod encode;
mod lists;
mod pages;
mod pending;
mod records;
mod shown;
mod sight;
mod staging;
mod store;

mod scene;
pub use scene::{BytesHeld, Drew, LiveScene};

mod sink;

mod pick;
pub use pick::Picked;
