//! A frame's batches to placed batches: each instance's triangles in world coordinates.

pub(super) use crate::mesh::Placement;
use crate::mesh::{BatchView, FrameView, SceneInstance, TileView};

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
