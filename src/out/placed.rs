//! What files and pictures share: each instance's triangles in world coordinates, positions in single precision, or an
//! error where they overflow, and colours in linear light.

use crate::mesh::{BatchView, FrameView, Placement, SceneInstance, TileView};
#[cfg(any(feature = "glb", feature = "wgpu"))]
use crate::model::Colour;
use glam::{DVec3, Vec3};
use std::io;

/// A position that overflows single precision (3.4e38).
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
#[error(
    "the position ({:e}, {:e}, {:e}) overflows the file format's single precision (up to {:e})",
    .position.x, .position.y, .position.z, f32::MAX
)]
pub struct BeyondSingle {
    /// The position, in the file's units and axes.
    pub position: DVec3,
}

impl From<BeyondSingle> for io::Error {
    fn from(beyond: BeyondSingle) -> Self {
        Self::new(io::ErrorKind::InvalidData, beyond)
    }
}

/// Rounds to the nearest position in single precision. Never -0.0.
///
/// # Errors
/// If a coordinate is not finite before or after rounding.
pub(super) fn single(position: DVec3) -> Result<Vec3, BeyondSingle> {
    let rounded = position.as_vec3() + Vec3::ZERO;
    if rounded.is_finite() { Ok(rounded) } else { Err(BeyondSingle { position }) }
}

/// Vertices of a run.
const RUN: usize = 1 << 13;
/// Maximum length of the name of an instance in a file, bytes: an assembly of 100 000 parts may state 20 KB for each.
const MAX_NAME: usize = 100;

/// The name of an instance, else of its part; its beginning if it is longer than [`MAX_NAME`].
pub(super) fn instance_name<'a>(part: &'a str, instance: &'a SceneInstance) -> &'a str {
    let name = if instance.name.is_empty() { part } else { &instance.name };
    let end = (0..=MAX_NAME.min(name.len())).rev().find(|&end| name.is_char_boundary(end));
    &name[..end.unwrap_or(0)]
}

/// Each instance with its placement and the batches of its part. Instances of unknown parts are skipped.
pub(super) fn placed<'a>(
    frame: &'a FrameView<'a>,
    by_part: &'a [Vec<&'a BatchView<'a>>],
) -> impl Iterator<Item = (&'a SceneInstance, Placement, &'a [&'a BatchView<'a>])> {
    let of = |instance: &'a SceneInstance| {
        let batches = by_part.get(instance.part.index())?;
        Some((instance, Placement::new(&instance.transform), &batches[..]))
    };
    frame.scene.instances.iter().filter_map(of)
}

/// The triangles of `mesh` whose corners are three different points of `rounded`. Triangles with a missing vertex are
/// skipped.
pub(super) fn distinct<'a, P: PartialEq>(
    mesh: &TileView<'a>,
    rounded: &'a [P],
) -> impl Iterator<Item = [u32; 3]> + use<'a, P> {
    mesh.triangles.iter().filter(|corners| match corners.map(|corner| rounded.get(corner as usize)) {
        [Some(a), Some(b), Some(c)] => a != b && b != c && c != a,
        _ => false,
    })
}

/// Cuts a list into runs of about [`RUN`] vertices.
pub(super) fn cut<T>(items: &[T], vertices: impl Fn(&T) -> usize) -> impl Iterator<Item = &[T]> {
    let mut rest = items;
    std::iter::from_fn(move || {
        let mut count = 0;
        let is_last = |item: &T| {
            count += vertices(item);
            count >= RUN
        };
        let length = rest.iter().position(is_last).map_or(rest.len(), |last| last + 1);
        let (run, after) = rest.split_at(length);
        rest = after;
        (!run.is_empty()).then_some(run)
    })
}

/// Colour of faces without one: a light grey that leaves room for highlights.
#[cfg(any(feature = "glb", feature = "wgpu"))]
pub(super) const DEFAULT_COLOUR: Colour = [0.76, 0.78, 0.81, 1.0];

/// Converts red, green and blue from sRGB to linear (IEC 61966-2-1) and keeps alpha. Values are clamped to 0..1;
/// non-finite values become 1.
#[cfg(any(feature = "glb", feature = "wgpu"))]
pub(super) fn linear(colour: Colour) -> Colour {
    let [r, g, b, alpha] = colour.map(|value| if value.is_finite() { value.clamp(0.0, 1.0) } else { 1.0 });
    let decode = |value: f32| if value <= 0.04045 { value / 12.92 } else { libm::powf((value + 0.055) / 1.055, 2.4) };
    [decode(r), decode(g), decode(b), alpha]
}

/// The inverse of [`linear`].
#[cfg(feature = "wgpu")]
pub(super) fn srgb(colour: Colour) -> Colour {
    let [r, g, b, alpha] = colour.map(|value| value.clamp(0.0, 1.0));
    let encode =
        |value: f32| if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * libm::powf(value, 1.0 / 2.4) - 0.055 };
    [encode(r), encode(g), encode(b), alpha]
}
