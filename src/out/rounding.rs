//! A frame to what its positions lose where they are rounded to the numbers of a file format.
//!
//! Positions that are equal stay equal, so rounding cannot open a closed mesh: a triangle whose corners round together
//! takes two uses of an edge with it that cancel.

#[cfg(feature = "glb")]
use super::format::GlbOptions;
#[cfg(feature = "glb")]
use super::node_place::NodePlace;
#[cfg(feature = "glb")]
use super::placed::BeyondSingle;
#[cfg(feature = "glb")]
use crate::control::Call;
#[cfg(feature = "glb")]
use crate::mesh::FrameView;
use crate::mesh::{Placement, SceneInstance};
use crate::model::FaceId;
use glam::DVec3;

/// What rounding to a format's numbers costs. Counts are over all instances.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rounding {
    /// Triangles that the file holds.
    pub triangles: u64,
    /// Triangles that the file leaves out, because corners of them round to one position.
    pub collapsed: u64,
    /// Faces all of whose triangles collapse, numbered across all instances, ascending per instance.
    pub collapsed_faces: Vec<u64>,
    /// Upper bound on the distance that rounding moves a vertex, millimetres.
    pub moved: f64,
    /// The vertex that is moved furthest, millimetres, world coordinates.
    pub place: DVec3,
}

/// Rounding to a format's numbers moves a vertex too far.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the file format's numbers move the vertex ({:.3e}, {:.3e}, {:.3e}) by up to {moved:.3e} mm, and {most:.3e} mm are \
     allowed",
    .place.x, .place.y, .place.z
)]
pub struct RoundedTooFar {
    /// Upper bound on the distance, millimetres.
    pub moved: f64,
    /// The largest distance allowed, millimetres.
    pub most: f64,
    /// The vertex, millimetres, world coordinates.
    pub place: DVec3,
}

/// What happens to one part or some of its faces, in its own file coordinates or as placed by one instance.
#[derive(Default)]
pub(super) struct RoundingCount {
    kept: u64,
    collapsed: u64,
    /// The face of each batch that keeps triangles, and of each that keeps none.
    kept_faces: Vec<FaceId>,
    other_faces: Vec<FaceId>,
    moved: f64,
    place: DVec3,
}

impl Rounding {
    /// Share of the chord tolerance that the program and the Python package let rounding cost.
    pub const SHARE: f64 = 0.1;

    /// Checks that no vertex moves by more than `most` millimetres.
    ///
    /// # Errors
    /// If one does.
    pub fn within(&self, most: f64) -> Result<(), RoundedTooFar> {
        let Self { moved, place, .. } = *self;
        if moved <= most { Ok(()) } else { Err(RoundedTooFar { moved, most, place }) }
    }

    /// The parts' counts, as nodes place the parts. Of some instances, once cancelled.
    #[cfg(feature = "glb")]
    pub(super) fn of_counts(
        call: Call<'_>,
        frame: &FrameView<'_>,
        counts: &[RoundingCount],
        with: (GlbOptions, f64),
    ) -> Result<Self, BeyondSingle> {
        let collapsed: Vec<Vec<FaceId>> = counts.iter().map(RoundingCount::collapsed_faces).collect();
        let mut out = Self::default();
        for instance in frame.scene.instances.iter().take_while(|_| !call.is_cancelled()) {
            let place = instance.part.index();
            if let (Some(part), Some(count)) = (frame.scene.parts.get(place), counts.get(place)) {
                let node = NodePlace::new(part, instance, with)?;
                let at = instance.transform.transform_point3(count.place);
                out.add(instance, (count, &collapsed[place]), instance.scale() * count.moved + node.moved, at);
            }
        }
        Ok(out)
    }

    /// Adds an instance whose part's counts are in world coordinates.
    pub(super) fn add_placed(&mut self, instance: &SceneInstance, count: &RoundingCount, placement: &Placement) {
        self.add(instance, (count, &count.collapsed_faces()), count.moved, placement.position(count.place));
    }

    fn add(&mut self, instance: &SceneInstance, (count, faces): (&RoundingCount, &[FaceId]), moved: f64, place: DVec3) {
        self.triangles += count.kept;
        self.collapsed += count.collapsed;
        let number = |&face: &FaceId| u64::from(instance.face_number(face));
        self.collapsed_faces.extend(faces.iter().map(number));
        if moved > self.moved {
            (self.moved, self.place) = (moved, place);
        }
    }
}

impl RoundingCount {
    /// Counts a point that is moved so far.
    pub(super) fn point(&mut self, point: DVec3, moved: f64) {
        if moved > self.moved {
            (self.moved, self.place) = (moved, point);
        }
    }

    /// Counts triangles of a face, of which some are kept.
    pub(super) fn triangles(&mut self, face: FaceId, all: usize, kept: usize) {
        self.kept += kept as u64;
        self.collapsed += (all - kept) as u64;
        if kept > 0 {
            self.kept_faces.push(face);
        } else if all > 0 {
            self.other_faces.push(face);
        }
    }

    /// Counts what `other` has counted.
    pub(super) fn add(&mut self, mut other: Self) {
        self.kept += other.kept;
        self.collapsed += other.collapsed;
        self.kept_faces.append(&mut other.kept_faces);
        self.other_faces.append(&mut other.other_faces);
        self.point(other.place, other.moved);
    }

    /// Faces all of whose triangles collapse, ascending.
    fn collapsed_faces(&self) -> Vec<FaceId> {
        if self.other_faces.is_empty() {
            return Vec::new();
        }
        let (mut kept, mut others) = (self.kept_faces.clone(), self.other_faces.clone());
        kept.sort_unstable();
        others.sort_unstable();
        others.dedup();
        others.retain(|face| kept.binary_search(face).is_err());
        others
    }
}
