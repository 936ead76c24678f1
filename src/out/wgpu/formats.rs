//! Texture formats that pipelines and targets agree on.

use ::wgpu::TextureFormat;

#[cfg(not(target_arch = "wasm32"))]
/// Format of pictures that are read back. Shaders write linear light; the target encodes it to sRGB.
pub(super) const COLOUR_FORMAT: TextureFormat = TextureFormat::Rgba8UnormSrgb;
/// Floating point, because with reversed depth its precision matches perspective.
pub(super) const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;
/// A record number and a distance per pixel, for picking. Of the formats of integers, OpenGL ES reads back only those
/// of four channels.
pub(super) const PICK_FORMAT: TextureFormat = TextureFormat::Rgba32Uint;
/// A row of a placement, or a point of an edge. Every device reads it in vertex shaders, where some read no buffers.
pub(super) const ROW_FORMAT: TextureFormat = TextureFormat::Rgba32Float;
/// Colour and face of a tile of an instance.
pub(super) const RECORD_FORMAT: TextureFormat = TextureFormat::Rg32Uint;
/// What is known of an instance.
pub(super) const INSTANCE_FORMAT: TextureFormat = TextureFormat::Rgba32Uint;
/// Samples per pixel. Every adapter supports 4, which suffices for smooth edges.
pub(super) const SAMPLES: u32 = 4;
