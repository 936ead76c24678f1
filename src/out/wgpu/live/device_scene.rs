//! A scene description to the scene on the device: parts with their tiles, instances sorted by part. The frame that is
//! being uploaded.

use super::store::{Line, StoredTile};
use crate::mesh::{DrawnTiles, Scene, SceneChanges, SceneInstance};
use crate::model::{Colour, EdgeId, InstanceId, PartId, TileId};
use crate::view::{Camera, box_corners};
use glam::{DAffine3, DVec3};
use std::collections::BTreeSet;
use std::ops::Range;

/// A part and its tiles and edges on the device.
#[derive(Default)]
pub(super) struct DevicePart {
    /// Its number in the model. All LODs of a part share it.
    pub(super) number: u32,
    /// Centre of the part's box. Vertices are relative to it.
    pub(super) centre: DVec3,
    radius: f64,
    pub(super) face_colours: Vec<Option<Colour>>,
    /// Indexed by tile. `None` without triangles.
    pub(super) tiles: Vec<Option<StoredTile>>,
    /// Indexed by edge.
    pub(super) lines: Vec<Option<Line>>,
    /// The part's instances: a range of [`DeviceScene::places`].
    pub(super) places: Range<u32>,
}

/// A placed instance.
#[derive(Clone, Debug)]
pub(super) struct DevicePlace {
    /// Its number in the scene.
    pub(super) instance: u32,
    pub(super) part: u32,
    pub(super) transform: DAffine3,
    pub(super) colour: Option<Colour>,
    pub(super) visible: bool,
    pub(super) first_face: u32,
}

/// Whether two lists of instances have the same records and draws.
pub(super) fn look_like(a: &[DevicePlace], b: &[DevicePlace]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.looks_like(b))
}

impl DevicePlace {
    /// The instance in this row.
    fn of(row: usize, instance: &SceneInstance) -> Self {
        Self {
            instance: row as u32,
            part: instance.part.0,
            transform: instance.transform,
            colour: instance.colour,
            visible: instance.visible,
            first_face: instance.first_face,
        }
    }

    /// Whether the two have the same records and draws. Transforms may differ.
    pub(super) fn looks_like(&self, other: &Self) -> bool {
        (self.instance, self.part, self.colour, self.visible, self.first_face)
            == (other.instance, other.part, other.colour, other.visible, other.first_face)
    }
}

/// The frame that is drawn.
#[derive(Default)]
pub(super) struct DeviceScene {
    pub(super) parts: Vec<DevicePart>,
    /// Instances sorted by part, without those of unknown parts.
    pub(super) places: Vec<DevicePlace>,
    pub(super) drawn: DrawnTiles,
    /// Instances that are not drawn, whatever the scene and `drawn` say.
    pub(super) hidden: BTreeSet<InstanceId>,
    /// Centre and half diagonal of the box of all [`corners`](Self::corners).
    pub(super) extent: (DVec3, f64),
}

impl DeviceScene {
    /// Creates a scene with the parts, still without tiles, and the instances of `scene`.
    pub(super) fn of(scene: &Scene) -> Self {
        let mut shown = Self::default();
        shown.add_parts(scene);
        let places = shown.places_of(scene);
        shown.place(places);
        shown
    }

    /// Appends the parts of `scene` that come after those known, without tiles.
    pub(super) fn add_parts(&mut self, scene: &Scene) {
        let new = scene.parts.iter().enumerate().skip(self.parts.len()).map(|(row, part)| DevicePart {
            number: part.mesh_of.map_or(row as u32, |of| of.0),
            centre: part.centre,
            radius: part.radius,
            face_colours: part.face_colours.clone(),
            ..DevicePart::default()
        });
        self.parts.extend(new);
    }

    /// The instances of `scene`, which must have the same parts.
    pub(super) fn places_of(&self, scene: &Scene) -> Vec<DevicePlace> {
        let of = |(row, instance)| DevicePlace::of(row, instance);
        let mut places: Vec<DevicePlace> = scene.instances.iter().enumerate().map(of).collect();
        places.retain(|place| (place.part as usize) < self.parts.len());
        places.sort_by_key(|place| place.part);
        places
    }

    /// The places that change, with their indices. `None` if others shift: where instances come, go, or have another
    /// LOD.
    pub(super) fn changed_places(
        &self,
        scene: &Scene,
        changes: &SceneChanges<'_>,
    ) -> Option<Vec<(usize, DevicePlace)>> {
        if !changes.removed.is_empty() || changes.first_instance < scene.instances.len() {
            return None;
        }
        let place = |&row: &usize| {
            let place = DevicePlace::of(row, &scene.instances[row]);
            let Range { start, end } = self.parts.get(place.part as usize)?.places.clone();
            let of_part = &self.places[start as usize..end as usize];
            let at = of_part.binary_search_by_key(&place.instance, |place| place.instance).ok()?;
            Some((start as usize + at, place))
        };
        changes.changed.iter().map(place).collect()
    }

    /// Whether the instances have the same records and draws, and are of the same parts.
    pub(super) fn has_instances_of(&self, other: &Self) -> bool {
        let [here, there] = [self, other].map(|scene| scene.parts.iter().map(|part| part.number));
        look_like(&self.places, &other.places) && here.eq(there)
    }

    /// Replaces the instances.
    pub(super) fn place(&mut self, places: Vec<DevicePlace>) {
        self.places = places;
        let mut end = 0;
        for (number, part) in self.parts.iter_mut().enumerate() {
            let start = end;
            end +=
                self.places[start as usize..].iter().take_while(|place| place.part as usize == number).count() as u32;
            part.places = start..end;
        }
        self.measure();
    }

    /// Finds the extent again, after instances moved.
    pub(super) fn measure(&mut self) {
        let outside = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = self.corners().fold(outside, |(low, high), point| (low.min(point), high.max(point)));
        self.extent =
            if low.x <= high.x { (0.5 * (low + high), 0.5 * (high - low).length()) } else { (DVec3::ZERO, 0.0) };
    }

    /// All tiles that have triangles.
    pub(super) fn tiles(&self) -> impl Iterator<Item = &StoredTile> {
        self.parts.iter().flat_map(|part| part.tiles.iter().flatten())
    }

    fn is_visible(&self, place: &DevicePlace) -> bool {
        place.visible && (self.hidden.is_empty() || !self.hidden.contains(&InstanceId(place.instance)))
    }

    /// The places in a range that are drawn, as ranges.
    pub(super) fn visible(&self, places: Range<u32>) -> Vec<Range<u32>> {
        let mut ranges: Vec<Range<u32>> = Vec::new();
        for place in places.filter(|&place| self.is_visible(&self.places[place as usize])) {
            match ranges.last_mut().filter(|range| range.end == place) {
                Some(range) => range.end = place + 1,
                None => ranges.push(place..place + 1),
            }
        }
        ranges
    }

    /// Place, number and data of each tile that a view draws, by place; all tiles past the last view.
    pub(super) fn drawn_tiles(&self, view: usize) -> impl Iterator<Item = (u32, u32, &StoredTile)> {
        let places = self.places.iter().enumerate().filter(|(_, at)| self.is_visible(at));
        places.flat_map(move |(place, at)| {
            let tiles = &self.parts[at.part as usize].tiles;
            let listed = (view < self.drawn.views()).then(|| self.drawn.tiles(view, at.instance as usize));
            let all = if listed.is_none() { 0..tiles.len() as u32 } else { 0..0 };
            let numbers = listed.into_iter().flatten().map(|tile| tile.0).chain(all);
            numbers.filter_map(move |number| Some((place as u32, number, tiles.get(number as usize)?.as_ref()?)))
        })
    }

    /// Least depth of the spheres around the instances, which may be negative; 0 without any.
    pub(super) fn nearest(&self, camera: &Camera) -> f64 {
        let back = camera.axes()[2];
        let depth = |place: &DevicePlace| {
            let part = &self.parts[place.part as usize];
            let columns = place.transform.matrix3;
            let scale = columns.x_axis.length().max(columns.y_axis.length()).max(columns.z_axis.length());
            // A little less, for what rounding adds.
            (camera.eye - place.transform.transform_point3(part.centre)).dot(back) - 1.001 * scale * part.radius
        };
        let nearest = self.places.iter().map(depth).fold(f64::INFINITY, f64::min);
        if nearest.is_finite() { nearest } else { 0.0 }
    }

    /// Corners of a bounding box of each instance, in world coordinates.
    pub(super) fn corners(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.places.iter().flat_map(|place| {
            let (centre, radius) = (self.parts[place.part as usize].centre, self.parts[place.part as usize].radius);
            let corners = box_corners([centre - radius, centre + radius]);
            corners.map(|corner| place.transform.transform_point3(corner))
        })
    }
}

/// A frame that has begun and not ended, with what it has uploaded so far.
pub(super) struct Pending {
    pub(super) base: Base,
    /// Rows of the part's number, the tile, and its data.
    pub(super) tiles: Vec<(u32, TileId, Option<StoredTile>)>,
    pub(super) lines: Vec<(u32, EdgeId, Option<Line>)>,
    pub(super) drawn: DrawnTiles,
}

/// What a frame builds on.
pub(super) enum Base {
    /// A new scene. Each of its parts starts with the tiles and lines of a part that is drawn, or with none; all start
    /// with none where the list is empty.
    New(DeviceScene, Vec<Option<PartId>>),
    /// The frame that is drawn, with these instances.
    Instances(Vec<DevicePlace>),
    /// The frame that is drawn, with its instances but these: indices of [`DeviceScene::places`].
    Changes(Vec<(usize, DevicePlace)>),
}

impl Base {
    /// The parts of the frame. `shown` is the one that is drawn.
    pub(super) fn parts<'a>(&'a self, shown: &'a DeviceScene) -> &'a [DevicePart] {
        match self {
            Self::New(shown, _) => &shown.parts,
            Self::Instances(_) | Self::Changes(_) => &shown.parts,
        }
    }
}
