//! A frame to what its positions lose where they are rounded to the numbers of a file format.
//!
//! Positions that are equal stay equal, so rounding cannot open a closed mesh: a triangle whose corners round together
//! takes two uses of an edge with it that cancel.

use super::Format;
#[cfg(feature = "glb")]
use super::glb_options::GlbOptions;
#[cfg(feature = "glb")]
use super::node_place::{NodePlace, PointNumbers, moved};
use super::placed::{Placement, batches_by_part, distinct, placed};
use super::single::{BeyondSingle, single};
use crate::mesh::{BatchView, FrameView, SceneInstance};
use crate::model::FaceId;
use glam::{DAffine3, DVec3};
use std::{error, fmt, io};

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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoundedTooFar {
    /// Upper bound on the distance, millimetres.
    pub moved: f64,
    /// The largest distance allowed, millimetres.
    pub most: f64,
    /// The vertex, millimetres, world coordinates.
    pub place: DVec3,
}

impl fmt::Display for RoundedTooFar {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { moved, most, place: DVec3 { x, y, z } } = self;
        write!(
            f,
            "the file format's numbers move the vertex ({x:.3e}, {y:.3e}, {z:.3e}) by up to {moved:.3e} mm, and \
             {most:.3e} mm are allowed"
        )
    }
}

impl error::Error for RoundedTooFar {}

impl From<RoundedTooFar> for io::Error {
    fn from(too_far: RoundedTooFar) -> Self {
        Self::new(io::ErrorKind::InvalidData, too_far)
    }
}

/// What happens to one part, in its own file coordinates or as placed by one instance.
#[derive(Default)]
struct RoundingCount {
    kept: u64,
    collapsed: u64,
    faces: Vec<FaceId>,
    moved: f64,
    place: DVec3,
}

impl Rounding {
    /// Share of the chord tolerance that the program and the Python package let rounding cost.
    pub const SHARE: f64 = 0.1;

    /// Measures what writing `frame` as `format` costs. `most` is the limit that the file is written with, infinite for
    /// no limit: nodes of a GLB depend on it.
    ///
    /// # Errors
    /// If a position overflows the format's single precision.
    pub fn of<'a>(frame: impl Into<FrameView<'a>>, format: Format, most: f64) -> Result<Self, BeyondSingle> {
        let frame = &frame.into();
        match format {
            #[cfg(feature = "glb")]
            Format::Glb(options) => Self::of_nodes(frame, (options, most)),
            Format::Stl => Self::of_placed(frame, true),
            Format::Ply | Format::Obj => {
                let _ = most;
                Self::of_placed(frame, false)
            }
        }
    }

    /// Checks that no vertex moves by more than `most` millimetres.
    ///
    /// # Errors
    /// If one does.
    pub fn within(&self, most: f64) -> Result<(), RoundedTooFar> {
        let Self { moved, place, .. } = *self;
        if moved <= most { Ok(()) } else { Err(RoundedTooFar { moved, most, place }) }
    }

    /// Whether `frame` would be written within `most` if its scene were moved by `by`.
    #[must_use]
    pub fn fits_moved<'a>(frame: impl Into<FrameView<'a>>, by: DVec3, format: Format, most: f64) -> bool {
        let frame = frame.into();
        let mut scene = frame.scene.clone();
        scene.translate(by);
        let moved = FrameView { scene: &scene, ..frame };
        Self::of(&moved, format, most).is_ok_and(|rounding| rounding.within(most).is_ok())
    }

    /// Points relative to the centres of parts, in nodes.
    #[cfg(feature = "glb")]
    fn of_nodes(frame: &FrameView<'_>, with: (GlbOptions, f64)) -> Result<Self, BeyondSingle> {
        let mut tallies = Vec::with_capacity(frame.scene.parts.len());
        let numbers = PointNumbers::of(frame, with.0, with.1);
        for ((part, batches), numbers) in frame.scene.parts.iter().zip(batches_by_part(frame)).zip(numbers) {
            tallies.push(RoundingCount::of(&batches, |point| {
                let rounded = numbers.local(part, point)?;
                Ok((rounded, moved(part, point, rounded)))
            })?);
        }
        let mut out = Self::default();
        for instance in &frame.scene.instances {
            let place = instance.part.index();
            if let (Some(part), Some(tally)) = (frame.scene.parts.get(place), tallies.get(place)) {
                let node = NodePlace::new(part, instance, with)?;
                let place = instance.transform.transform_point3(tally.place);
                out.add(instance, tally, instance.scale() * tally.moved + node.moved, place);
            }
        }
        Ok(out)
    }

    /// Points in world coordinates.
    fn of_placed(frame: &FrameView<'_>, as_single: bool) -> Result<Self, BeyondSingle> {
        let mut out = Self::default();
        let by_part = batches_by_part(frame);
        for (instance, batches) in placed(frame, &by_part) {
            let placement = Placement::new(&instance.transform);
            let arithmetic = Arithmetic::of(&instance.transform);
            let tally = if as_single {
                RoundingCount::of(batches, |point| {
                    let exact = placement.position(point);
                    let rounded = single(exact)?;
                    Ok((rounded, (rounded.as_dvec3() - exact).length() + arithmetic.moved(point)))
                })?
            } else {
                RoundingCount::of(batches, |point| Ok((placement.position(point), arithmetic.moved(point))))?
            };
            out.add(instance, &tally, tally.moved, placement.position(tally.place));
        }
        Ok(out)
    }

    fn add(&mut self, instance: &SceneInstance, tally: &RoundingCount, moved: f64, place: DVec3) {
        self.triangles += tally.kept;
        self.collapsed += tally.collapsed;
        let number = |face: &FaceId| u64::from(instance.first_face) + u64::from(face.0);
        self.collapsed_faces.extend(tally.faces.iter().map(number));
        if moved > self.moved {
            (self.moved, self.place) = (moved, place);
        }
    }
}

impl RoundingCount {
    /// Rounds all points by `round`, which returns the rounded point and the distance.
    fn of<P: PartialEq>(
        batches: &[&BatchView<'_>],
        round: impl Fn(DVec3) -> Result<(P, f64), BeyondSingle>,
    ) -> Result<Self, BeyondSingle> {
        let mut tally = Self::default();
        let mut rounded = Vec::new();
        let (mut faces, mut kept_faces) = (Vec::new(), Vec::new());
        for batch in batches {
            rounded.clear();
            for &point in batch.mesh.positions {
                let (position, moved) = round(point)?;
                if moved > tally.moved {
                    (tally.moved, tally.place) = (moved, point);
                }
                rounded.push(position);
            }
            let kept = distinct(&batch.mesh, &rounded).count() as u64;
            let all = batch.mesh.triangles.len() as u64;
            tally.kept += kept;
            tally.collapsed += all - kept;
            if kept > 0 {
                kept_faces.push(batch.face);
            } else if all > 0 {
                faces.push(batch.face);
            }
        }
        kept_faces.sort_unstable();
        faces.sort_unstable();
        faces.dedup();
        faces.retain(|face| kept_faces.binary_search(face).is_err());
        tally.faces = faces;
        Ok(tally)
    }
}

/// Bounds the error of transforming points in double precision.
struct Arithmetic {
    /// Error per length of a point, and of the translation.
    per_length: f64,
    translation: f64,
}

impl Arithmetic {
    fn of(transform: &DAffine3) -> Self {
        if *transform == DAffine3::IDENTITY {
            return Self { per_length: 0.0, translation: 0.0 };
        }
        // Three products and three sums, each rounded by half an epsilon.
        const ROUNDED: f64 = 4.0 * f64::EPSILON;
        let m = transform.matrix3;
        let norm = m.x_axis.length() + m.y_axis.length() + m.z_axis.length();
        Self { per_length: ROUNDED * norm, translation: ROUNDED * transform.translation.length() }
    }

    fn moved(&self, point: DVec3) -> f64 {
        self.per_length * point.length() + self.translation
    }
}
