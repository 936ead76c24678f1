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

/// Maximum number of nodes around a node. Each adds at least three digits.
const AROUND: usize = 4;

/// Where a node puts a part's rounded points.
#[derive(Clone, Debug)]
pub(super) struct NodePlace {
    /// Translations of the nodes around the node, metres, outermost first, where one translation has too few digits.
    pub(super) around: Vec<Vec3>,
    /// Where the part's centre goes, metres.
    pub(super) centre: Vec3,
    /// Columns of the matrix that turns and scales the part about its centre. `None` for the identity.
    axes: Option<[Vec3; 3]>,
    /// Upper bound on how far rounding these numbers moves a point of the part, millimetres.
    pub(super) moved: f64,
}

impl NodePlace {
    /// Rounds an instance's transform. Nodes are nested as long as rounding the translation moves the part by more than
    /// half of `most` millimetres.
    ///
    /// # Errors
    /// If a number overflows single precision.
    pub(super) fn new(part: &ScenePart, instance: &SceneInstance, most: f64) -> Result<Self, BeyondSingle> {
        let millimetres = |metres: f64| metres / METRES_PER_MILLIMETRE;
        let mut rest = instance.transform.transform_point3(part.centre) * METRES_PER_MILLIMETRE;
        let mut centre = single(rest)?;
        let mut around = Vec::new();
        while around.len() < AROUND && 2.0 * millimetres(off(rest, centre)) > most {
            let outer = Vec3::from_array(centre.to_array().map(same_in_double));
            if outer == Vec3::ZERO {
                break;
            }
            around.push(outer);
            rest -= outer.as_dvec3();
            centre = single(rest)?;
        }
        let moved = millimetres(off(rest, centre));
        let turn = instance.transform.matrix3;
        if turn == DMat3::IDENTITY {
            return Ok(Self { around, centre, axes: None, moved });
        }
        let columns = [turn.x_axis, turn.y_axis, turn.z_axis];
        let axes = [single(columns[0])?, single(columns[1])?, single(columns[2])?];
        let turned = columns.iter().zip(&axes).map(|(exact, axis)| off(*exact, *axis).powi(2)).sum::<f64>().sqrt();
        Ok(Self { around, centre, axes: Some(axes), moved: moved + turned * part.radius })
    }

    /// The node's matrix by columns; `None` if it only translates.
    pub(super) fn matrix(&self) -> Option<[f32; 16]> {
        let [x, y, z] = self.axes?.map(|axis| axis.extend(0.0).to_array());
        [x, y, z, self.centre.extend(1.0).to_array()].as_flattened().try_into().ok()
    }
}

/// Upper bound on the distance between `exact` and what readers get from the JSON of `rounded`, its shortest decimal:
/// `rounded` in single precision, and up to half a unit in its last place away in double precision.
fn off(exact: DVec3, rounded: Vec3) -> f64 {
    let half = 0.5 * f64::from(f32::EPSILON);
    ((rounded.as_dvec3() - exact).abs() + half * rounded.as_dvec3().abs()).length()
}

/// The number of as many leading bits of `number` as possible whose JSON is the same number in single and in double
/// precision. 0 if no leading bits are.
fn same_in_double(number: f32) -> f32 {
    let is_same = |number: &f32| {
        let text = gltf_json::serialize::to_string(number).unwrap_or_default();
        text.parse() == Ok(f64::from(*number))
    };
    let bits = number.to_bits();
    (0..f32::MANTISSA_DIGITS).map(|k| f32::from_bits(bits >> k << k)).find(is_same).unwrap_or(0.0)
}
