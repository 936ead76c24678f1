//! Instances to nodes of glTF: metres in single precision, relative to the centres of parts, and what that costs.

use super::single::{BeyondSingle, single};
use crate::mesh::{SceneInstance, ScenePart};
use glam::{DMat3, DVec3, Vec3};

const METRES_PER_MILLIMETRE: f64 = 1e-3;

/// The rounded position of a part's point, metres from the part's centre.
///
/// # Errors
/// If it overflows single precision.
pub(super) fn local(part: &ScenePart, point: DVec3) -> Result<Vec3, BeyondSingle> {
    single((point - part.centre) * METRES_PER_MILLIMETRE)
}

/// The distance by which [`local`] moves a point, millimetres.
pub(super) fn moved(part: &ScenePart, point: DVec3, rounded: Vec3) -> f64 {
    (rounded.as_dvec3() - (point - part.centre) * METRES_PER_MILLIMETRE).length() / METRES_PER_MILLIMETRE
}

/// Where a node puts a part's rounded points.
#[derive(Clone, Copy, Debug)]
pub(super) struct NodePlace {
    /// Translation of a node around the node, metres, where one translation has too few digits.
    pub(super) around: Option<Vec3>,
    /// Where the part's centre goes, metres.
    pub(super) centre: Vec3,
    /// Columns of the matrix that turns and scales the part about its centre. `None` for the identity.
    axes: Option<[Vec3; 3]>,
    /// Upper bound on how far rounding these numbers moves a point of the part, millimetres.
    pub(super) moved: f64,
}

impl NodePlace {
    /// Rounds an instance's transform. Two nodes are used if rounding one translation moves the part by more than half
    /// of `most` millimetres.
    ///
    /// # Errors
    /// If a number overflows single precision.
    pub(super) fn new(part: &ScenePart, instance: &SceneInstance, most: f64) -> Result<Self, BeyondSingle> {
        let exact = instance.transform.transform_point3(part.centre) * METRES_PER_MILLIMETRE;
        let nearest = single(exact)?;
        let rest = exact - nearest.as_dvec3();
        let millimetres = |metres: DVec3| metres.length() / METRES_PER_MILLIMETRE;
        let (around, centre, moved) = if 2.0 * millimetres(rest) > most {
            let inner = single(rest)?;
            (Some(nearest), inner, millimetres(rest - inner.as_dvec3()))
        } else {
            (None, nearest, millimetres(rest))
        };
        let turn = instance.transform.matrix3;
        if turn == DMat3::IDENTITY {
            return Ok(Self { around, centre, axes: None, moved });
        }
        let columns = [turn.x_axis, turn.y_axis, turn.z_axis];
        let axes = [single(columns[0])?, single(columns[1])?, single(columns[2])?];
        let off = columns.iter().zip(&axes).map(|(exact, axis)| (*exact - axis.as_dvec3()).length_squared());
        let turned = off.sum::<f64>().sqrt() * part.radius;
        Ok(Self { around, centre, axes: Some(axes), moved: moved + turned })
    }

    /// The node's matrix by columns; `None` if it only translates.
    pub(super) fn matrix(&self) -> Option<[f32; 16]> {
        let [x, y, z] = self.axes?.map(|axis| axis.extend(0.0).to_array());
        [x, y, z, self.centre.extend(1.0).to_array()].as_flattened().try_into().ok()
    }
}
