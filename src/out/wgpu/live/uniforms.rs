//! A camera to uniforms and placements relative to the eye, subtracted in f64 so that large worlds do not jitter.

use super::super::gpu::Gpu;
use super::super::pipelines::ROW_FORMAT;
use super::super::{RenderOptions, Section};
use super::device_scene::DeviceScene;
use super::records::RecordRows;
use super::rows::{Rows, Texels, bind};
use crate::out::placed::linear;
use crate::view::{Camera, Projection, box_corners};
use ::wgpu::{BindGroup, BindingResource, Buffer, BufferUsages};
use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec3, Vec3};
use std::sync::Arc;

/// Distance of the near plane, as a fraction of the scene's radius or of its distance from the eye, whichever is
/// larger. With reversed floating-point depth, a near plane this close costs no precision.
const NEAR: f64 = 1e-4;

/// Depth bias of lines, as a factor of distance: lines lie on surfaces and are drawn as if this much nearer to the eye.
const NEARER: f64 = 1.0008;

/// `SceneView` in the shader.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct SceneView {
    clip: [f32; 16],
    eye: [f32; 4],
    section: [f32; 4],
    size: [f32; 2],
    near: f32,
    rest: f32,
}

/// `Style` in the shader.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Style {
    key: [f32; 4],
    top: [f32; 4],
    bottom: [f32; 4],
    nearer: [f32; 2],
    backfaces: f32,
    rest: f32,
}

/// A row of the transform from part to world, relative to the eye.
type PlaceRow = [f32; 4];

/// A camera, and the only pixel to draw when picking.
pub(super) struct Aim<'a> {
    pub(super) camera: &'a Camera,
    pub(super) pixel: Option<(u32, u32)>,
}

/// A camera and the placements that it sees, on the device.
struct Sight {
    view: Rows,
    style: Rows,
    places: Texels,
    lease: Lease,
}

/// While there is a second one, the sight is in use.
pub(super) type Lease = Arc<()>;

/// As many sights as pictures are under way.
#[derive(Default)]
pub(super) struct Sights {
    all: Vec<Sight>,
    /// Three per place.
    rows: Vec<PlaceRow>,
}

/// A sight that was uploaded.
pub(super) struct UploadedSight {
    /// Bind group 0.
    pub(super) group: BindGroup,
    pub(super) lease: Lease,
    /// The projection relative to the eye.
    pub(super) clip: DMat4,
    /// Bytes uploaded.
    pub(super) bytes: u64,
}

impl Sights {
    /// Uploads a camera and placements to a sight that is free, or a new one. `records` are bound with them.
    pub(super) fn upload(
        &mut self,
        gpu: &Gpu,
        shown: &DeviceScene,
        records: &RecordRows,
        aim: &Aim<'_>,
        options: &RenderOptions,
    ) -> UploadedSight {
        let eye = aim.camera.eye;
        self.rows.clear();
        self.rows.extend(shown.places.iter().flat_map(|place| {
            let centre = shown.parts[place.part as usize].centre;
            let (m, at) = (place.transform.matrix3, place.transform.transform_point3(centre) - eye);
            [0, 1, 2].map(|row| m.row(row).as_vec3().extend(at[row] as f32).to_array())
        }));
        let free = self.all.iter().position(|sight| Arc::strong_count(&sight.lease) == 1);
        let number = free.unwrap_or(self.all.len());
        if free.is_none() {
            let uniform = || Rows::new(BufferUsages::UNIFORM);
            let places = Texels::new(ROW_FORMAT);
            self.all.push(Sight { view: uniform(), style: uniform(), places, lease: Lease::default() });
        }
        let Sight { view, style, places, lease } = &mut self.all[number];
        let (of_view, of_style, clip) = uniforms(shown, aim, options);
        let bytes = view.write(gpu, &[of_view], 0..1)
            + style.write(gpu, &[of_style], 0..1)
            + places.write(gpu, &self.rows, 0..self.rows.len());
        let uniforms = [view.buffer(), style.buffer()].into_iter().flatten().map(Buffer::as_entire_binding);
        let textures = places.view().into_iter().chain(records.views()).map(BindingResource::TextureView);
        let group = bind(gpu, &gpu.pipelines.input.bind_group, uniforms.chain(textures).collect());
        UploadedSight { group, lease: Arc::clone(lease), clip, bytes }
    }

    pub(super) fn bytes(&self) -> u64 {
        self.all.iter().map(|sight| sight.view.bytes() + sight.style.bytes() + sight.places.bytes()).sum()
    }
}

/// Least and greatest depth of what the caller draws besides the scene.
fn other_depths(camera: &Camera, options: &RenderOptions) -> (f64, f64) {
    let finite = options.other_bounds.filter(|bounds| bounds.iter().all(|corner| corner.is_finite()));
    let Some(bounds) = finite else { return (f64::INFINITY, f64::NEG_INFINITY) };
    let back = camera.axes()[2];
    let depths = box_corners(bounds).map(|corner| (camera.eye - corner).dot(back));
    depths.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), depth| (low.min(depth), high.max(depth)))
}

/// The plane that cuts: its unit normal, and its distance from the eye along it.
fn section(camera: &Camera, options: &RenderOptions) -> [f32; 4] {
    let plane = options.section.and_then(|Section { point, normal }| {
        let normal = normal.try_normalize()?;
        let off = normal.dot(point - camera.eye);
        off.is_finite().then(|| normal.as_vec3().extend(off as f32).to_array())
    });
    plane.unwrap_or([0.0, 0.0, 0.0, 1.0])
}

fn uniforms(shown: &DeviceScene, aim: &Aim<'_>, options: &RenderOptions) -> (SceneView, Style, DMat4) {
    let (width, height) = (f64::from(options.size.0), f64::from(options.size.1));
    let camera = aim.camera;
    let (centre, radius) = shown.extent;
    let radius = radius.clamp(1e-3, f64::MAX);
    let depth = (camera.eye - centre).dot(camera.axes()[2]);
    let (nearest, furthest) = other_depths(camera, options);
    let (near, far, nearer, parallel) = match camera.projection {
        Projection::Perspective { near, .. } => {
            // The nearest part may be far beyond. A margin keeps faces of the others' box out of the plane. OpenGL maps
            // depth to -1 to 1, and has no precision to spare.
            let nearest = shown.nearest(camera).min(0.999 * nearest);
            let near = near.max(NEAR * camera.eye.distance(centre).max(radius)).max(nearest);
            (near, f64::INFINITY, [NEARER, 0.0], 0.0)
        }
        Projection::Orthographic { height } => {
            let reach = 1.01 * radius;
            // The others get a margin, too, so that none of them lies in a plane that clips.
            let (near, far) =
                ((depth - reach).min(nearest - 0.01 * reach), (depth + reach).max(furthest + 0.01 * reach));
            (near, far, [1.0, (NEARER - 1.0) * 2.0 * height / (far - near)], 1.0)
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
    let [top, bottom] = options.background.map(linear);
    let scene_view = SceneView {
        clip: clip.as_mat4().to_cols_array(),
        eye: back.extend(parallel).to_array(),
        section: section(camera, options),
        size: [width as f32, height as f32],
        // Lines need no near clipping in orthographic projection.
        near: if parallel > 0.0 { 0.0 } else { near as f32 },
        rest: 0.0,
    };
    let style = Style {
        key: key.extend(0.0).to_array(),
        top,
        bottom,
        nearer: nearer.map(|x| x as f32),
        backfaces: if options.backfaces { 1.0 } else { 0.0 },
        rest: 0.0,
    };
    (scene_view, style, clip)
}
