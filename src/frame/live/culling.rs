//! Bounding boxes and normal cones of a part's tiles -> the tiles that a camera shows, and their pixels per millimetre.
//! Frustum and back-face culling.

use crate::frame::plan::lattice::strips_under;
use crate::frame::plan::tile_bounds::surface_box;
use crate::frame::tolerance::part_camera::{PartCamera, PartEye, PixelScale};
use crate::math::sphere_tree::along_curve;
use crate::prepare::internals::{BoundingBox, PreparedFace, PreparedPart, Tile};
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;

/// Tiles that are culled together, and that one call of a job looks at.
pub(crate) const RANGE: usize = 512;
/// Tiles of a range, near each other, that are judged together where nothing can change for any of them.
pub(crate) const GROUP: usize = 16;
/// Words of one bit per tile of a range.
pub(crate) const WORDS: usize = RANGE / 64;
/// Groups of a range: a bit each of a word.
pub(crate) const GROUPS: usize = RANGE / GROUP;

/// One instance as one view sees it.
#[derive(Clone, Debug)]
pub(crate) struct InstanceSight {
    pub(crate) view: usize,
    pub(crate) instance: usize,
    /// In units of the deviation that the view allows the instance, instead of pixels.
    pub(crate) sight: PartCamera,
    /// If tiles that show it their backs are skipped.
    pub(crate) eye: Option<PartEye>,
    /// The largest such scale within the box of the part.
    pub(crate) most: f64,
    /// Of the instance and its part: [`Attributes::priority`](super::attributes::Attributes::priority).
    pub(crate) priority: f64,
}

/// A normal cone.
#[derive(Clone, Copy, Debug)]
struct Cone {
    axis: DVec3,
    half_angle: f64,
}

impl Cone {
    /// Contains all directions.
    const ALL: Self = Self { axis: DVec3::Z, half_angle: f64::INFINITY };
}

/// Around the tiles of a group.
#[derive(Debug)]
struct Group {
    place: BoundingBox,
    /// Whether each tile has a box. What has none is never seen.
    is_full: bool,
    /// A bit for each tile.
    bits: [u64; WORDS],
}

/// Bounding boxes of [`RANGE`] consecutive tiles, and their normal cones.
#[derive(Debug)]
pub(super) struct RangeBoxes {
    /// Of all of them.
    place: BoundingBox,
    groups: Vec<Group>,
    /// The tiles of each group, as numbers within the range.
    members: Vec<u16>,
    tiles: Vec<BoundingBox>,
    /// Cones of outward normals. Empty where nothing is culled by them: back faces of open parts may be visible.
    cones: Vec<Cone>,
}

impl RangeBoxes {
    /// Reads the tables of derivative bounds of the tiles of a range. Cones only if `may_cull`.
    pub(super) fn of(part: &PreparedPart, range: usize, may_cull: bool) -> Self {
        let rows = &part.tiles[RANGE * range..part.tiles.len().min(RANGE * (range + 1))];
        let tiles: Vec<BoundingBox> = rows.iter().map(|tile| tile_box(part.face_of(tile), tile)).collect();
        let members = along_curve(tiles.iter().map(|tile| 0.5 * (tile.low + tile.high)));
        let group = |members: &[usize]| {
            let place = members.iter().fold(BoundingBox::EMPTY, |all, &tile| all.with(&tiles[tile]));
            let is_full = members.iter().all(|&tile| tiles[tile].low.cmple(tiles[tile].high).all());
            let mut bits = [0; WORDS];
            members.iter().for_each(|&tile| bits[tile / 64] |= 1 << (tile % 64));
            Group { place, is_full, bits }
        };
        let groups = members.chunks(GROUP).map(group).collect();
        let place = tiles.iter().fold(BoundingBox::EMPTY, |all, tile| all.with(tile));
        let cones = rows.iter().filter(|_| may_cull).map(|tile| normals(part.face_of(tile), tile)).collect();
        let members = members.into_iter().map(|tile| tile as u16).collect();
        Self { place, groups, members, tiles, cones }
    }
}

/// Bounding boxes of a part's tiles, and their normal cones: one range after the other.
#[derive(Debug, Default)]
pub(super) struct PartBoxes(pub(super) Vec<RangeBoxes>);

impl PartBoxes {
    /// Number of tiles.
    pub(super) fn len(&self) -> usize {
        self.0.iter().map(|range| range.tiles.len()).sum()
    }

    /// Number of groups. All ranges but the last have [`GROUPS`].
    pub(super) fn groups(&self) -> usize {
        self.0.iter().map(|range| range.groups.len()).sum()
    }

    /// Whether a tile of a range may be back-facing and not drawn for that.
    pub(super) fn may_cull(&self, range: usize) -> bool {
        !self.0[range].cones.is_empty()
    }

    /// The tiles of a group of a range, as numbers within the range.
    pub(super) fn members(&self, range: usize, group: usize) -> &[u16] {
        let members = &self.0[range].members;
        &members[GROUP * group..members.len().min(GROUP * (group + 1))]
    }

    /// A bit for each of these tiles.
    pub(super) fn word_bits(&self, range: usize, group: usize) -> &[u64; WORDS] {
        &self.0[range].groups[group].bits
    }

    /// Calls `each` with the groups of a range of which tiles may be in the view frustum. With bounds on their scales
    /// if all are certainly.
    pub(super) fn groups_seen_by(
        &self,
        sight: &PartCamera,
        range: usize,
        mut each: impl FnMut(usize, Option<PixelScale>),
    ) {
        let RangeBoxes { place, groups, .. } = &self.0[range];
        if sight.look(place).is_none() {
            return;
        }
        for (k, Group { place, is_full, .. }) in groups.iter().enumerate() {
            let all = if *is_full { sight.look_within(place) } else { None };
            if all.is_some() || sight.look(place).is_some() {
                each(k, all);
            }
        }
    }

    /// Calls `each` with the tiles of a group of a range that are in the view frustum, as numbers within the range.
    /// With an eye, skips back-facing tiles of closed parts.
    pub(super) fn seen_by(
        &self,
        InstanceSight { sight, eye, .. }: &InstanceSight,
        (range, group): (usize, usize),
        mut each: impl FnMut(usize, PixelScale),
    ) {
        let RangeBoxes { tiles, cones, .. } = &self.0[range];
        for k in self.members(range, group).iter().map(|&k| usize::from(k)) {
            let place = &tiles[k];
            let Some(seen) = sight.look(place) else { continue };
            let cone = || cones.get(k);
            let is_back = |eye: &PartEye| cone().is_some_and(|cone| eye.sees_back(place, cone.axis, cone.half_angle));
            if !eye.as_ref().is_some_and(is_back) {
                each(k, seen);
            }
        }
    }
}

/// The bounding box of all tiles of a part.
pub(crate) fn box_of_part(part: &PreparedPart) -> BoundingBox {
    boxes(part).fold(BoundingBox::EMPTY, |all, tile| all.with(&tile))
}

/// The longest side of any tile's bounding box.
pub(crate) fn largest_tile(part: &PreparedPart) -> f64 {
    boxes(part).map(|tile| (tile.high - tile.low).max_element()).fold(0.0, f64::max)
}

fn boxes(part: &PreparedPart) -> impl Iterator<Item = BoundingBox> + '_ {
    part.tiles.iter().map(|tile| tile_box(part.face_of(tile), tile))
}

/// The bounding box of a tile's surface, enlarged by the gap between surface and edges.
fn tile_box(face: &PreparedFace, tile: &Tile) -> BoundingBox {
    let all = surface_box(face, tile);
    BoundingBox { low: all.low - face.gap, high: all.high + face.gap }
}

/// The cone of a tile's outward normals: around the normal in the middle, by the bound on how far normals turn.
fn normals(face: &PreparedFace, tile: &Tile) -> Cone {
    if face.creases.iter().any(|creases| !creases.is_empty()) {
        return Cone::ALL;
    }
    let (table, [su, sv]) = (&face.bounds, strips_under(face, tile));
    let most = |of: &mut dyn Iterator<Item = f64>| of.fold(0.0, f64::max);
    let along_u: f64 = su.clone().map(|i| most(&mut sv.clone().map(|j| table.cell(i, j).turn_u))).sum();
    let along_v: f64 = sv.clone().map(|j| most(&mut su.clone().map(|i| table.cell(i, j).turn_v))).sum();
    let half_angle = along_u + along_v;
    let middle = 0.5 * (tile.min + tile.max);
    let [_, du, dv] = face.patches.tangents(middle.x, middle.y);
    match (du.cross(dv) * if face.reversed { -1.0 } else { 1.0 }).try_normalize() {
        Some(axis) if half_angle < FRAC_PI_2 => Cone { axis, half_angle },
        _ => Cone::ALL,
    }
}
