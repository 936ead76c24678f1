//! A camera to shader globals and placements relative to the eye, subtracted in f64 so that large worlds do not jitter.

use super::super::RenderOptions;
use super::super::formats::ROW_FORMAT;
use super::super::gpu::Gpu;
use super::device_scene::DeviceScene;
use super::rows::{Rows, bind};
use super::texels::Texels;
use crate::out::colour;
use crate::view::{Camera, Projection};
use ::wgpu::{BindGroup, BindingResource, Buffer, BufferUsages};
use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec3, Vec3};

/// Distance of the near plane, as a fraction of the scene's radius or of its distance from the eye, whichever is
/// larger. With reversed floating-point depth, a near plane this close costs no precision.
const NEAR: f64 = 1e-4;

/// Depth bias of lines, as a factor of distance: lines lie on surfaces and are drawn as if this much nearer to the eye.
const NEARER: f64 = 1.0008;

/// Line style: sRGB colour with opacity, width in pixels.
struct Pen {
    colour: [f32; 4],
    width: f32,
}

/// Triangle edges: thin and translucent, so that dense meshes keep their shading. Both adjacent triangles draw each
/// edge.
const WIRE: Pen = Pen { colour: [0.094, 0.118, 0.173, 0.358], width: 1.0 };
/// Lattice lines stand out from triangle edges and shading.
const LATTICE: Pen = Pen { colour: [0.02, 0.16, 0.42, 0.9], width: 1.3 };
/// B-rep edges stand out from the wireframe.
const EDGE: Pen = Pen { colour: [0.063, 0.071, 0.086, 1.0], width: 1.7 };

/// `Globals` in the shader.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Globals {
    clip: [f32; 16],
    key: [f32; 4],
    top: [f32; 4],
    bottom: [f32; 4],
    edge: [f32; 4],
    wire: [f32; 4],
    lattice: [f32; 4],
    eye: [f32; 4],
    nearer: [f32; 2],
    size: [f32; 2],
    edge_width: f32,
    wire_width: f32,
    near: f32,
    backfaces: f32,
    lattice_width: f32,
    rest: [f32; 3],
}

/// A row of the transform from part to world, relative to the eye.
type PlaceRow = [f32; 4];

/// A camera, and the only pixel to draw when picking.
pub(super) struct Aim<'a> {
    pub(super) camera: &'a Camera,
    pub(super) pixel: Option<(u32, u32)>,
}

/// Globals and placements on the device.
pub(super) struct SceneSight {
    globals: Rows,
    places: Texels,
    /// Three per place.
    rows: Vec<PlaceRow>,
}

impl SceneSight {
    pub(super) fn new() -> Self {
        Self { globals: Rows::new(BufferUsages::UNIFORM), places: Texels::new(ROW_FORMAT), rows: Vec::new() }
    }

    /// Uploads globals and placements. Returns their bind group, the projection and the number of bytes uploaded.
    pub(super) fn refresh(
        &mut self,
        gpu: &Gpu,
        shown: &DeviceScene,
        aim: &Aim<'_>,
        options: &RenderOptions,
    ) -> (BindGroup, DMat4, u64) {
        let eye = aim.camera.eye;
        self.rows.clear();
        self.rows.extend(shown.places.iter().flat_map(|place| {
            let centre = shown.parts[place.part as usize].centre;
            let (m, at) = (place.transform.matrix3, place.transform.transform_point3(centre) - eye);
            [0, 1, 2].map(|row| m.row(row).as_vec3().extend(at[row] as f32).to_array())
        }));
        let (globals, clip) = globals(shown, aim, options);
        let mut bytes = self.globals.write(gpu, &[globals], 0..1);
        bytes += self.places.write(gpu, &self.rows, 0..self.rows.len());
        let globals = self.globals.buffer().map(Buffer::as_entire_binding);
        let places = self.places.view().map(BindingResource::TextureView);
        (bind(gpu, &gpu.pipelines.view, globals.into_iter().chain(places).collect()), clip, bytes)
    }

    pub(super) fn bytes(&self) -> u64 {
        self.globals.bytes() + self.places.bytes()
    }
}

fn globals(shown: &DeviceScene, aim: &Aim<'_>, options: &RenderOptions) -> (Globals, DMat4) {
    let (width, height) = (f64::from(options.size.0), f64::from(options.size.1));
    let camera = aim.camera;
    let (centre, radius) = shown.extent;
    let radius = radius.clamp(1e-3, f64::MAX);
    let depth = (camera.eye - centre).dot(camera.axes()[2]);
    let (near, far, nearer, parallel) = match camera.projection {
        Projection::Perspective { near, .. } => {
            // The nearest part may be far beyond. OpenGL maps depth to -1 to 1, and has no precision to spare.
            let near = near.max(NEAR * camera.eye.distance(centre).max(radius)).max(shown.nearest(camera));
            (near, f64::INFINITY, [NEARER, 0.0], 0.0)
        }
        Projection::Orthographic { height } => {
            let reach = 1.01 * radius;
            (depth - reach, depth + reach, [1.0, (NEARER - 1.0) * height / reach], 1.0)
        }
    };
    // The eye is the origin.
    let view = Camera { eye: DVec3::ZERO, ..*camera }.view_matrix();
    let mut clip = camera.projection_matrix(width / height, near, far) * view;
    if let Some((x, y)) = aim.pixel {
        // Zoom in until the pixel fills the picture.
        let (x, y) = (2.0 * f64::from(x) + 1.0 - width, height - 2.0 * f64::from(y) - 1.0);
        let wide = DMat4::from_scale(DVec3::new(width, height, 1.0));
        clip = wide * DMat4::from_translation(DVec3::new(-x / width, -y / height, 0.0)) * clip;
    }
    let [right, up, back] = [view.row(0), view.row(1), view.row(2)].map(|row| row.truncate().as_vec3());
    let key: Vec3 = (0.75 * up + 0.65 * back - 0.55 * right).normalize_or_zero();
    let [top, bottom] = options.background.map(colour::linear);
    let globals = Globals {
        clip: clip.as_mat4().to_cols_array(),
        key: key.extend(0.0).to_array(),
        top,
        bottom,
        edge: EDGE.colour,
        wire: WIRE.colour,
        lattice: LATTICE.colour,
        eye: back.extend(parallel).to_array(),
        nearer: nearer.map(|x| x as f32),
        size: [width as f32, height as f32],
        edge_width: EDGE.width,
        wire_width: WIRE.width,
        // Lines need no near clipping in orthographic projection.
        near: if parallel > 0.0 { 0.0 } else { near as f32 },
        backfaces: if options.backfaces { 1.0 } else { 0.0 },
        lattice_width: LATTICE.width,
        rest: [0.0; 3],
    };
    (globals, clip)
}
