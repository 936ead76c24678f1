//! Texture formats that pipelines and targets agree on.

use ::wgpu::TextureFormat;

/// Format of pictures that are read back. Shaders write linear light; the target encodes it to sRGB.
pub(super) const COLOUR_FORMAT: TextureFormat = TextureFormat::Rgba8UnormSrgb;
/// Floating point, because with reversed depth its precision matches perspective.
pub(super) const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;
/// A record number and a distance per pixel, for picking.
pub(super) const PICK_FORMAT: TextureFormat = TextureFormat::Rg32Uint;
/// Samples per pixel. Every adapter supports 4, which suffices for smooth edges.
pub(super) const SAMPLES: u32 = 4;
