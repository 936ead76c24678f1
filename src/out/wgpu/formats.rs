//! What textures hold, on which pipelines and targets agree.

use ::wgpu::TextureFormat;

/// What pictures are read back from: shaders write linear light; the target encodes and resolves it.
pub(super) const COLOUR_FORMAT: TextureFormat = TextureFormat::Rgba8UnormSrgb;
/// Floating point: with reversed depth its precision lies where perspective needs it.
pub(super) const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;
/// What is under a pixel: a number and a distance.
pub(super) const PICK_FORMAT: TextureFormat = TextureFormat::Rg32Uint;
/// What every adapter offers, and enough for smooth edges.
pub(super) const SAMPLES: u32 = 4;
