//! A pixel to the triangle under it: draws the scene into a single pixel, with record numbers for colours.

use super::scene::LiveScene;
use super::uniforms::Aim;
use crate::model::{FaceId, InstanceId, PartId, TileId};
use crate::out::wgpu::error::RenderError;
use crate::out::wgpu::formats::{DEPTH_FORMAT, PICK_FORMAT};
use crate::out::wgpu::options::RenderOptions;
use crate::out::wgpu::target::{read_back, texture, whole};
use ::wgpu::{LoadOp, Operations, StoreOp, TextureUsages};
use glam::DVec3;

/// The surface point under a pixel, and what it belongs to.
#[derive(Clone, Copy, PartialEq, Debug)]
#[non_exhaustive]
pub struct PickHit {
    /// The instance in the scene.
    pub instance: InstanceId,
    /// Its part in the model.
    pub part: PartId,
    /// The face within the part.
    pub face: FaceId,
    /// The tile within the part.
    pub tile: TileId,
    /// Number of triangles of the tile.
    pub triangles: u32,
    /// The surface point at the pixel's centre, world coordinates, millimetres. Its distance from the eye is an f32.
    pub point: DVec3,
}

impl LiveScene {
    /// Finds the surface under the centre of a pixel, `x` from the left and `y` from the top, in a picture as
    /// [`draw`](Self::draw) makes it. `None` for the background and for pixels outside of the picture.
    ///
    /// Waits for the device, about a millisecond.
    ///
    /// # Errors
    /// If the device fails.
    pub fn pick(
        &mut self,
        (x, y): (u32, u32),
        view: usize,
        options: &RenderOptions,
    ) -> Result<Option<PickHit>, RenderError> {
        let (width, height) = options.size;
        if x >= width || y >= height {
            return Ok(None);
        }
        let view = self.known(view);
        let camera = self.camera(options);
        let aim = Aim { camera: &camera, pixel: Some((x, y)) };
        let gpu = self.gpu.clone();
        let seen = gpu.checked(|device| {
            let (sight, _) = self.refresh(view, options, &aim);
            let target = texture(&gpu, (1, 1), PICK_FORMAT, 1, TextureUsages::COPY_SRC);
            let depth = texture(&gpu, (1, 1), DEPTH_FORMAT, 1, TextureUsages::empty());
            let mut encoder = device.create_command_encoder(&::wgpu::CommandEncoderDescriptor::default());
            let mut pass = encoder.begin_render_pass(&::wgpu::RenderPassDescriptor {
                label: Some("trimtess pick"),
                color_attachments: &[Some(::wgpu::RenderPassColorAttachment {
                    view: &whole(&target),
                    depth_slice: None,
                    resolve_target: None,
                    ops: Operations { load: LoadOp::Clear(::wgpu::Color::BLACK), store: StoreOp::Store },
                })],
                depth_stencil_attachment: Some(::wgpu::RenderPassDepthStencilAttachment {
                    view: &whole(&depth),
                    depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Discard }),
                    stencil_ops: None,
                }),
                ..::wgpu::RenderPassDescriptor::default()
            });
            pass.set_bind_group(0, &sight, &[]);
            pass.set_pipeline(&gpu.pipelines.pick);
            self.draw_tiles(&mut pass, view);
            drop(pass);
            gpu.queue.submit([encoder.finish()]);
            target
        })?;
        let seen = read_back(&self.gpu.device, &self.gpu.queue, &seen, 8)?;
        let word = |k: usize| seen.get(4 * k..4 * k + 4).map_or(0, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let Some(row) = word(0).checked_sub(1) else { return Ok(None) };
        let (place, tile) = self.records.tile_of(row);
        let place = &self.shown.places[place as usize];
        let part = &self.shown.parts[place.part as usize];
        let Some(of_tile) = part.tiles[tile as usize] else { return Ok(None) };
        let (start, direction) = camera.ray((x, y), options.size);
        Ok(Some(PickHit {
            instance: InstanceId(place.instance),
            part: PartId(part.number),
            face: of_tile.face,
            tile: TileId(tile),
            triangles: of_tile.triangles,
            point: start + f64::from(f32::from_bits(word(1))) * direction,
        }))
    }
}
