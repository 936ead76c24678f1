//! A pixel to the triangle under it: draws the scene into a single pixel, with record numbers for colours.

use super::scene::LiveScene;
use super::uniforms::Aim;
use crate::mesh::Scene;
use crate::model::{FaceId, InstanceId, PartId, TileId};
use crate::out::wgpu::gpu::RenderError;
use crate::out::wgpu::image::{Reading, begin_pass, texture, whole};
use crate::out::wgpu::options::RenderOptions;
use crate::out::wgpu::pipelines::{DEPTH_FORMAT, PICK_FORMAT};
use crate::view::Camera;
use ::wgpu::{LoadOp, Operations, RenderPassColorAttachment, StoreOp, TextureUsages};
use glam::DVec3;
use std::fmt;

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

impl PickHit {
    /// What viewers tell of the face, as names and values. `scene` is that of the session. `of_face` are the
    /// [facts](crate::prepare::FaceFacts::rows) of the face.
    #[must_use]
    pub fn facts(&self, scene: &Scene, of_face: Vec<(&'static str, String)>) -> Vec<(&'static str, String)> {
        let named = |name: Option<&str>, number: usize| match name {
            Some(name) if !name.is_empty() => format!("{number} {name:?}"),
            _ => number.to_string(),
        };
        let (part, instance) = (self.part.index(), self.instance.index());
        let [x, y, z] = self.point.to_array();
        let mut rows = vec![
            ("part", named(scene.parts.get(part).map(|part| part.name.as_str()), part)),
            ("instance", named(scene.instances.get(instance).map(|placed| &*placed.name), instance)),
            ("face", self.face.index().to_string()),
        ];
        rows.extend(of_face);
        rows.push(("tile", self.tile.0.to_string()));
        rows.push(("triangles", format!("{} in the tile", self.triangles)));
        rows.push(("point", format!("{x:.3}, {y:.3}, {z:.3}")));
        rows
    }
}

/// A pick on its way from the device.
pub struct Picking {
    reading: Reading,
    camera: Camera,
    pixel: (u32, u32),
    size: (u32, u32),
    /// [`Records::layout`](super::records::Records) when the pixel was drawn.
    layout: u64,
}

impl fmt::Debug for Picking {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Picking").field("pixel", &self.pixel).finish_non_exhaustive()
    }
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
        pixel: (u32, u32),
        view: usize,
        options: &RenderOptions,
    ) -> Result<Option<PickHit>, RenderError> {
        let Some(picking) = self.begin_pick(pixel, view, options)? else { return Ok(None) };
        let seen = picking.reading.wait(&self.gpu.device)?;
        Ok(self.hit(&picking, &seen))
    }

    /// Begins to [`pick`](Self::pick), without waiting. Browsers let no caller wait. `None` for pixels outside of the
    /// picture.
    ///
    /// # Errors
    /// If the device fails, as [`draw`](Self::draw).
    pub fn begin_pick(
        &mut self,
        (x, y): (u32, u32),
        view: usize,
        options: &RenderOptions,
    ) -> Result<Option<Picking>, RenderError> {
        let (width, height) = options.size;
        if x >= width || y >= height {
            return Ok(None);
        }
        let view = self.known(view);
        let camera = self.camera(options);
        let aim = Aim { camera: &camera, pixel: Some((x, y)) };
        let seen = self.checked(|scene, gpu| {
            let seen = scene.refresh(view, options, &aim);
            let target = texture(gpu, (1, 1), PICK_FORMAT, 1, TextureUsages::COPY_SRC);
            let depth = texture(gpu, (1, 1), DEPTH_FORMAT, 1, TextureUsages::empty());
            let mut encoder = gpu.device.create_command_encoder(&::wgpu::CommandEncoderDescriptor::default());
            let colour = RenderPassColorAttachment {
                view: &whole(&target),
                depth_slice: None,
                resolve_target: None,
                ops: Operations { load: LoadOp::Clear(::wgpu::Color::TRANSPARENT), store: StoreOp::Store },
            };
            let mut pass = begin_pass(&mut encoder, "trimtess pick", colour, &whole(&depth));
            pass.set_pipeline(&gpu.pipelines.pick);
            pass.set_bind_group(0, &seen.group, &[]);
            scene.draw_tiles(&mut pass, view);
            drop(pass);
            gpu.queue.submit([encoder.finish()]);
            target
        })?;
        let reading = Reading::begin(&self.gpu.device, &self.gpu.queue, &seen, 16)?;
        Ok(Some(Picking { reading, camera, pixel: (x, y), size: options.size, layout: self.records.layout }))
    }

    /// The answer of a pick, if it has arrived; `None` until then. Does not wait. Not to be called again after an
    /// answer.
    ///
    /// Where instances came or went since the pick began, nothing is found.
    ///
    /// # Errors
    /// If the device fails.
    pub fn poll_pick(&self, picking: &Picking) -> Option<Result<Option<PickHit>, RenderError>> {
        Some(picking.reading.poll(&self.gpu.device)?.map(|seen| self.hit(picking, &seen)))
    }

    /// What the pixel's numbers name.
    fn hit(&self, picking: &Picking, seen: &[u8]) -> Option<PickHit> {
        let word = |k: usize| seen.get(4 * k..4 * k + 4).map_or(0, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let row = word(0).checked_sub(1).filter(|_| picking.layout == self.records.layout)?;
        let (place, tile) = self.records.tile_of(row);
        let place = &self.shown.places[place as usize];
        let part = &self.shown.parts[place.part as usize];
        let of_tile = part.tiles.get(tile as usize)?.as_ref()?;
        let (start, direction) = picking.camera.ray(picking.pixel, picking.size);
        Some(PickHit {
            instance: InstanceId(place.instance),
            part: PartId(part.number),
            face: of_tile.face,
            tile: TileId(tile),
            triangles: of_tile.triangles,
            point: start + f64::from(f32::from_bits(word(1))) * direction,
        })
    }
}
