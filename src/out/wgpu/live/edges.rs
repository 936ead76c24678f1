//! Polylines of edges to draws, the same in every view: one per part for all its instances.

use super::super::formats::ROW_FORMAT;
use super::super::gpu::Gpu;
use super::device_scene::DeviceScene;
use super::rows::bind;
use super::texels::Texels;
use ::wgpu::{BindGroup, BindingResource, RenderPass};
use std::ops::Range;

/// A point in its part's coordinates. The fourth number is 1 where a segment goes on to the next point, else 0.
type Point = [f32; 4];

/// Points of all edges of placed parts, and the draws.
pub(super) struct Edges {
    version: u64,
    points: Vec<Point>,
    texels: Texels,
    group: Option<BindGroup>,
    /// Points and places.
    draws: Vec<(Range<u32>, Range<u32>)>,
}

impl Edges {
    pub(super) fn new() -> Self {
        Self { version: 0, points: Vec::new(), texels: Texels::new(ROW_FORMAT), group: None, draws: Vec::new() }
    }

    /// Gathers the points again if edges or instances changed. Returns the number of bytes uploaded.
    pub(super) fn refresh(&mut self, gpu: &Gpu, shown: &DeviceScene, version: u64) -> u64 {
        if self.version == version {
            return 0;
        }
        self.version = version;
        self.draws.clear();
        let before = std::mem::take(&mut self.points);
        for part in &shown.parts {
            let ranges = shown.visible(part.places.clone());
            if ranges.is_empty() {
                continue;
            }
            let start = self.points.len() as u32;
            for line in part.lines.iter().flatten() {
                self.points.extend(line.iter().map(|&[x, y, z]| [x, y, z, 1.0]));
                self.points.last_mut().into_iter().for_each(|last| last[3] = 0.0);
            }
            // The last point of a polyline begins no segment.
            let end = self.points.len() as u32;
            if end > start {
                self.draws.extend(ranges.into_iter().map(|places| (start..end - 1, places)));
            }
        }
        let bytes = self.texels.write(gpu, &self.points, changed(&before, &self.points));
        let layout = &gpu.pipelines.points;
        let points = self.texels.view().map(|view| vec![BindingResource::TextureView(view)]);
        self.group = points.map(|points| bind(gpu, layout, points));
        bytes
    }

    /// Number of calls that draw the edges.
    pub(super) fn calls(&self) -> usize {
        self.draws.len()
    }

    /// Draws the edges.
    pub(super) fn draw(&self, pass: &mut RenderPass<'_>) {
        let Some(group) = &self.group else { return };
        pass.set_bind_group(1, group, &[]);
        for (points, places) in &self.draws {
            pass.draw(6 * points.start..6 * points.end, places.clone());
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        self.texels.bytes()
    }
}

/// The range of `new` outside of which both are the same.
fn changed(old: &[Point], new: &[Point]) -> Range<usize> {
    let start = old.iter().zip(new).take_while(|(a, b)| a == b).count();
    if old.len() != new.len() {
        return start..new.len();
    }
    let same = old[start..].iter().rev().zip(new[start..].iter().rev()).take_while(|(a, b)| a == b).count();
    start..new.len() - same
}
