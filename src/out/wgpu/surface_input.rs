//! A device to what pipelines need that draw surfaces of a scene: those here, and the caller's.

use super::layout::{SURFACE_RECORDS, TILES, VERTICES};
use ::wgpu::{BindGroupLayout, VertexBufferLayout};

/// What the caller's pipeline needs to draw a [`LiveScene`](super::LiveScene): shader text, vertex buffers, and
/// bind group 0. Scenes on one device have the same.
///
/// The pipeline draws lists of triangles, which are counter-clockwise seen from outside, clockwise where an instance is
/// mirrored. Colour targets, depth format and comparison, samples, and bind groups from 1 on are the caller's.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SurfaceInput {
    /// WGSL to put before the caller's, which may name what it declares: `SceneVertex`, the input of a vertex function;
    /// `scene_surface`, which turns it into a `SceneSurface`: position relative to the eye and in clip space, normal,
    /// linear colour, numbers of instance, part, face and tile; `scene_view`, the camera; `scene_to_eye` and
    /// `scene_linear`. All its names begin with `scene`, `Scene` or `SCENE`. It depends on the device. The scene's own pipelines
    /// have the same text.
    pub wgsl: &'static str,
    /// Layout of bind group 0: camera, placements and records, for vertex and fragment shaders.
    pub bind_group: BindGroupLayout,
    /// Layouts of vertex buffers 0 and 1, of the locations that `SceneVertex` has.
    pub vertex_buffers: [Option<VertexBufferLayout<'static>>; 2],
}

impl SurfaceInput {
    /// That of a device that reads draws from buffers (`indirect`), or of one that merges tiles.
    pub(super) fn new(bind_group: &BindGroupLayout, indirect: bool) -> Self {
        let wgsl = if indirect {
            concat!(include_str!("scene.wgsl"), include_str!("scene_per_tile.wgsl"))
        } else {
            concat!(include_str!("scene.wgsl"), include_str!("scene_merged.wgsl"))
        };
        let vertex_buffers = [Some(VERTICES), Some(if indirect { SURFACE_RECORDS } else { TILES })];
        Self { wgsl, bind_group: bind_group.clone(), vertex_buffers }
    }
}
