//! Points, directions and placements of ISO 10303-42 -> vectors in millimetres and orthonormal frames.

use super::table::{Entity, Read, Table, Trouble, missing, out_of_range};
use super::units::Units;
use super::values::List;
use crate::model::{Frame3, StepTrouble};
use glam::{DAffine3, DMat3, DVec3};
use std::collections::{HashSet, VecDeque};

/// Access to the geometry of one representation: the table and its units.
#[derive(Clone, Copy)]
pub(super) struct Geometry<'a> {
    pub(super) table: &'a Table,
    pub(super) units: Units,
    /// Tolerance of approximations ([`fit_tolerance`](super::StepOptions::fit_tolerance)), millimetres.
    pub(super) fit: f64,
    /// Current nesting of derived points.
    pub(super) nesting: u8,
}

impl<'a> Geometry<'a> {
    pub(super) fn new(table: &'a Table, units: Units, fit: f64) -> Self {
        Self { table, units, fit, nesting: 0 }
    }

    pub(super) fn get(&self, id: u64) -> Read<Entity<'a>> {
        self.table.get(id)
    }

    /// A point of any kind, in millimetres.
    pub(super) fn point(&self, id: u64) -> Read<DVec3> {
        let instance = self.get(id)?;
        if !instance.is("CARTESIAN_POINT") {
            let point = self.derived_point(instance)?;
            return point.ok_or_else(|| {
                Trouble::new(id, StepTrouble::WrongType { keyword: instance.keyword(), wanted: "a point" })
            });
        }
        self.millimetres(self.triple(instance.fields("CARTESIAN_POINT", 1).list(0)?, id)?, id)
    }

    /// Coordinates of instance `id` in millimetres, if they are finite.
    pub(super) fn millimetres(&self, stated: DVec3, id: u64) -> Read<DVec3> {
        let point = stated * self.units.length;
        point.is_finite().then_some(point).ok_or_else(|| not_finite("a coordinate", id))
    }

    /// A length of instance `id` in millimetres, if it is finite.
    pub(super) fn length(&self, stated: f64, id: u64) -> Read<f64> {
        let length = stated * self.units.length;
        length.is_finite().then_some(length).ok_or_else(|| not_finite("a length", id))
    }

    pub(super) fn points(&self, ids: impl Iterator<Item = u64>) -> Read<Vec<DVec3>> {
        ids.map(|id| self.point(id)).collect()
    }

    /// A place for an instance that cannot be read: the first readable point that it refers to, directly or not.
    /// Prefers vertices.
    pub(super) fn place_near(&self, id: u64) -> Option<DVec3> {
        /// Maximum number of instances to visit.
        const SEEN: usize = 1000;
        let (mut queue, mut known, mut other) = (VecDeque::from([id]), HashSet::from([id]), None);
        while let Some(id) = queue.pop_front() {
            let Some(instance) = self.table.find(id) else { continue };
            let vertex = instance.is("VERTEX_POINT");
            if vertex || instance.is("CARTESIAN_POINT") {
                // Points of parameter curves have two coordinates.
                let flat = !vertex && instance.fields("CARTESIAN_POINT", 1).list(0).is_ok_and(|list| list.len() < 3);
                let point = self.vertex(id).ok().filter(|_| !flat);
                if vertex && point.is_some() {
                    return point;
                }
                other = other.or(point);
                continue;
            }
            instance.references(&mut |next| {
                if known.len() < SEEN && known.insert(next) {
                    queue.push_back(next);
                }
            });
        }
        other
    }

    /// Up to three numbers; missing ones are 0.
    pub(super) fn triple(&self, list: List<'_>, id: u64) -> Read<DVec3> {
        let mut out = [0.0; 3];
        for (slot, value) in out.iter_mut().zip(list.iter()) {
            *slot = value.number().ok_or_else(|| not_finite("a coordinate", id))?;
        }
        Ok(DVec3::from_array(out))
    }

    /// A `DIRECTION`, not normalised.
    pub(super) fn direction(&self, id: u64) -> Read<DVec3> {
        self.triple(self.get(id)?.fields("DIRECTION", 1).list(0)?, id)
    }

    /// A `VECTOR`, in millimetres.
    pub(super) fn vector(&self, id: u64) -> Read<DVec3> {
        let fields = self.get(id)?.fields("VECTOR", 1);
        let direction = self.direction(fields.reference(0)?)?;
        let direction = direction.try_normalize().ok_or_else(|| Trouble::new(id, missing("a VECTOR", "direction")))?;
        let magnitude = fields.real(1)?;
        self.millimetres(direction * magnitude, id)
    }

    /// An `AXIS2_PLACEMENT_3D`, an `AXIS1_PLACEMENT` (with an arbitrary first axis) or an `AXIS2_PLACEMENT_2D`.
    pub(super) fn frame(&self, id: u64) -> Read<Frame3> {
        let instance = self.get(id)?;
        let (fields, axis, reference) = if instance.is("AXIS2_PLACEMENT_2D") {
            let fields = instance.fields("AXIS2_PLACEMENT_2D", 1);
            (fields, None, fields.optional(1))
        } else if instance.is("AXIS2_PLACEMENT_3D") || instance.is("AXIS1_PLACEMENT") {
            let fields = instance.fields("AXIS2_PLACEMENT_3D", 1);
            (fields, fields.optional(1), fields.optional(2))
        } else {
            return Err(not_a_placement(instance));
        };
        let origin = self.point(fields.reference(0)?)?;
        let (axis, reference) = (self.axis(axis, DVec3::Z)?, self.axis(reference, DVec3::X)?);
        Frame3::from_axis(origin, axis, reference)
            .ok_or_else(|| Trouble::new(id, missing("an axis of the placement", "direction")))
    }

    fn axis(&self, id: Option<u64>, default: DVec3) -> Read<DVec3> {
        id.map_or(Ok(default), |id| self.direction(id))
    }

    /// The motion of an `AXIS2_PLACEMENT_3D` or a `CARTESIAN_TRANSFORMATION_OPERATOR_3D`.
    ///
    /// ISO 10303-42 has positive scales only, but OpenCASCADE writes mirrored occurrences with negative ones. It
    /// divides by the scale, also the origin, unless the axes are the world's: it writes a reflection in a point as the
    /// standard reads it.
    pub(super) fn motion(&self, id: u64) -> Read<DAffine3> {
        let instance = self.get(id)?;
        if instance.is("AXIS2_PLACEMENT_3D") {
            let frame = self.frame(id)?;
            let turn = DMat3::from_cols(frame.x, frame.y, frame.z);
            return Ok(DAffine3::from_mat3_translation(turn, frame.origin));
        }
        if instance.is("CARTESIAN_TRANSFORMATION_OPERATOR_3D") {
            // Simple instances list name, axis 1, axis 2, origin, scale, axis 3. The name and description of the
            // functionally defined transformation may follow the first name.
            let before = if instance.fields("CARTESIAN_TRANSFORMATION_OPERATOR", 0).len() >= 8 { 3 } else { 1 };
            let own = instance.fields("CARTESIAN_TRANSFORMATION_OPERATOR", before);
            let third = instance.fields("CARTESIAN_TRANSFORMATION_OPERATOR_3D", before + 4);
            let frame = Frame3::from_axis(
                self.point(own.reference(2)?)?,
                self.axis(third.optional(0), DVec3::Z)?,
                self.axis(own.optional(0), DVec3::X)?,
            );
            let frame = frame.ok_or_else(|| Trouble::new(id, missing("an axis of the transformation", "direction")))?;
            let y = self.axis(own.optional(1), frame.y)?;
            // A reflection shows in the second axis.
            let y = if y.dot(frame.y) < 0.0 { -frame.y } else { frame.y };
            let scale = own.real(3).unwrap_or(1.0);
            // The sign of the determinant tells whether the motion is a reflection.
            if !(scale * scale * scale).is_normal() {
                return Err(Trouble::new(id, out_of_range("a transformation scale", scale, "")));
            }
            let turn = DMat3::from_cols(frame.x, y, frame.z);
            if scale < 0.0 && !turn.abs_diff_eq(DMat3::IDENTITY, 1e-12) {
                return Ok(DAffine3::from_mat3_translation(turn / scale, frame.origin / scale));
            }
            return Ok(DAffine3::from_mat3_translation(turn * scale, frame.origin));
        }
        Err(not_a_placement(instance))
    }
}

fn not_a_placement(instance: Entity<'_>) -> Trouble {
    Trouble::new(instance.id, StepTrouble::WrongType { keyword: instance.keyword(), wanted: "a placement" })
}

fn not_finite(what: &'static str, id: u64) -> Trouble {
    Trouble::new(id, StepTrouble::NotFinite { what })
}
