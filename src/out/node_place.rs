//! Instances to nodes of glTF, points of parts to their numbers in it: metres about the centres of parts, and what
//! rounding to these numbers costs.

use super::format::GlbOptions;
use super::placed::{BeyondSingle, single};
use crate::control::Call;
use crate::mesh::{FrameView, SceneInstance, ScenePart};
use crate::model::PartId;
use glam::{DMat3, DQuat, DVec3, Vec3};
use std::collections::HashMap;

const METRES_PER_MILLIMETRE: f64 = 1e-3;

/// The numbers in which a GLB has the points of a part: metres from its centre, in single precision or as 16-bit
/// integers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PointNumbers {
    /// Size of an integer's step, metres: a power of two. `None` for single precision.
    pub(super) step: Option<f32>,
    /// Share by which the decimals of the step in JSON differ from it in double precision.
    decimal_error: f64,
}

impl PointNumbers {
    /// Those of each part. Where [`GlbOptions::quantized`] would move a point by more than half of `most` millimetres,
    /// single precision.
    pub(super) fn of(frame: &FrameView<'_>, options: GlbOptions, most: f64) -> Vec<Self> {
        let parts = &frame.scene.parts;
        if !options.quantized {
            return vec![Self { step: None, decimal_error: 0.0 }; parts.len()];
        }
        let mut furthest = vec![0.0_f64; parts.len()];
        let mut reach = |part: PartId, points: &[DVec3]| {
            if let (Some(furthest), Some(part)) = (furthest.get_mut(part.index()), parts.get(part.index())) {
                let off = points.iter().map(|point| (*point - part.centre).abs().max_element());
                *furthest = off.fold(*furthest, f64::max);
            }
        };
        frame.batches.iter().for_each(|batch| reach(batch.part, batch.mesh.positions));
        frame.edge_lines.iter().for_each(|line| reach(line.part, &line.points));
        let scales = frame.scene.largest_scales();
        let step = |(furthest, scale): (f64, f64)| {
            let step = power_of_two(furthest * METRES_PER_MILLIMETRE / f64::from(i16::MAX));
            // The distance to the nearest point of the grid.
            let moved = 0.5 * 3_f64.sqrt() * step / METRES_PER_MILLIMETRE * scale;
            let fits = (f64::from(f32::MIN_POSITIVE)..f64::from(f32::MAX)).contains(&step) && 2.0 * moved <= most;
            let step = fits.then_some(step as f32);
            let decimal_error = step.map_or(0.0, |step| (read_in_double(step) / f64::from(step) - 1.0).abs());
            Self { step, decimal_error }
        };
        furthest.into_iter().zip(scales).map(step).collect()
    }

    /// The rounded position of a part's point, metres from the part's centre.
    ///
    /// # Errors
    /// If it overflows single precision.
    pub(super) fn local(self, part: &ScenePart, point: DVec3) -> Result<Vec3, BeyondSingle> {
        let exact = (point - part.centre) * METRES_PER_MILLIMETRE;
        match self.step.map(f64::from) {
            // Exact: integers below 2^15 times a power of two.
            Some(step) => single((exact / step).round() * step),
            None => single(exact),
        }
    }

    /// Upper bound on how far [`local`](Self::local), and reading its numbers in double precision, move a point,
    /// millimetres.
    pub(super) fn moved(self, part: &ScenePart, point: DVec3, rounded: Vec3) -> f64 {
        let rounded = rounded.as_dvec3();
        let off = (rounded - (point - part.centre) * METRES_PER_MILLIMETRE).length();
        (off + self.decimal_error * rounded.length()) / METRES_PER_MILLIMETRE
    }

    /// A rounded position as integers.
    pub(super) fn integers(step: f32, rounded: Vec3) -> [i16; 3] {
        (rounded / step).to_array().map(|x| x as i16)
    }
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
    pub(super) turn: Turn,
    /// Upper bound on how far rounding these numbers moves a point of the part, millimetres.
    pub(super) moved: f64,
}

/// How a node turns and scales a part about its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Turn {
    None,
    /// Columns of a matrix.
    Axes([Vec3; 3]),
    /// A unit quaternion, and a scale: what a list of instances can have.
    Rotation([f32; 4], f32),
}

impl NodePlace {
    /// Rounds an instance's transform. Nodes are nested as long as rounding the translation moves the part by more than
    /// half of `most` millimetres.
    ///
    /// # Errors
    /// If a number overflows single precision.
    pub(super) fn new(
        part: &ScenePart,
        instance: &SceneInstance,
        (options, most): (GlbOptions, f64),
    ) -> Result<Self, BeyondSingle> {
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
        let exact = instance.transform.matrix3;
        let mut turn = Turn::None;
        let mut turned = 0.0;
        if exact != DMat3::IDENTITY || options.instanced && around.is_empty() {
            let columns = [exact.x_axis, exact.y_axis, exact.z_axis];
            let axes = [single(columns[0])?, single(columns[1])?, single(columns[2])?];
            turned = columns.iter().zip(&axes).map(|(exact, axis)| off(*exact, *axis).powi(2)).sum::<f64>().sqrt();
            turn = Turn::Axes(axes);
            if let Some((rotation, off)) = rotation(exact).filter(|_| options.instanced && around.is_empty()) {
                (turn, turned) = (rotation, off);
            }
        }
        Ok(Self { moved: millimetres(off(rest, centre)) + turned * part.radius, around, centre, turn })
    }

    /// Whether it fits into a list of instances.
    fn is_listed(&self) -> bool {
        matches!(self.turn, Turn::Rotation(..)) && self.around.is_empty()
    }
}

/// Rounds `x` up to a power of two, infinity above the largest; 0 stays 0. Exact: a platform's logarithm would decide
/// the bytes of files. `x` is 0, or positive and not subnormal.
fn power_of_two(x: f64) -> f64 {
    const MANTISSA: u64 = (1 << (f64::MANTISSA_DIGITS - 1)) - 1;
    let below = f64::from_bits(x.to_bits() & !MANTISSA);
    if below < x { 2.0 * below } else { below }
}

/// A matrix as rotation and scale, and how far that moves a point at distance 1. `None` if it mirrors.
fn rotation(exact: DMat3) -> Option<(Turn, f64)> {
    let scale = libm::cbrt(exact.determinant());
    if !(scale > 0.0 && scale.is_finite()) {
        return None;
    }
    let rotation = DQuat::from_mat3(&(exact * scale.recip())).normalize().as_quat();
    let rounded = DMat3::from_quat(rotation.as_dquat()) * f64::from(scale as f32);
    // Readers compute the matrix in single precision.
    let arithmetic = 4.0 * f64::from(f32::EPSILON) * scale;
    let columns = [rounded.x_axis - exact.x_axis, rounded.y_axis - exact.y_axis, rounded.z_axis - exact.z_axis];
    let off = columns.map(|column| (column.length() + arithmetic).powi(2)).iter().sum::<f64>().sqrt();
    Some((Turn::Rotation(rotation.to_array(), scale as f32), off))
}

/// Instances that are one node of a GLB: rows of the scene, ascending, each with its place. Several only if all can be
/// listed.
pub(super) type NodeGroup = Vec<(usize, NodePlace)>;

/// The nodes of a frame. With [`GlbOptions::instanced`], the instances of a part that have one colour are one node,
/// where none of them is mirrored or needs nested nodes. In the order of their first instances. Some, once cancelled.
///
/// # Errors
/// If a number overflows single precision.
pub(super) fn groups(
    call: Call<'_>,
    frame: &FrameView<'_>,
    with: (GlbOptions, f64),
) -> Result<Vec<NodeGroup>, BeyondSingle> {
    let mut groups: Vec<NodeGroup> = Vec::new();
    let mut listed = HashMap::new();
    for (row, instance) in frame.scene.instances.iter().enumerate().take_while(|_| !call.is_cancelled()) {
        let Some(part) = frame.scene.parts.get(instance.part.index()) else { continue };
        let place = NodePlace::new(part, instance, with)?;
        let key = (instance.part, instance.colour.map(|colour| colour.map(f32::to_bits)));
        let known = if place.is_listed() { *listed.entry(key).or_insert(groups.len()) } else { groups.len() };
        match groups.get_mut(known) {
            Some(group) => group.push((row, place)),
            None => groups.push(vec![(row, place)]),
        }
    }
    Ok(groups)
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
    let is_same = |number: &f32| read_in_double(*number) == f64::from(*number);
    let bits = number.to_bits();
    (0..f32::MANTISSA_DIGITS).map(|k| f32::from_bits(bits >> k << k)).find(is_same).unwrap_or(0.0)
}

/// What a reader in double precision gets from the JSON of `number`; NaN if that is no number.
fn read_in_double(number: f32) -> f64 {
    gltf_json::serialize::to_string(&number).ok().and_then(|text| text.parse().ok()).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::power_of_two;

    #[test]
    fn a_power_of_two_is_the_least_that_is_not_below() {
        for exponent in -1000..1000 {
            let power = 2_f64.powi(exponent);
            let cases = [power, power.next_down(), 0.7 * power, (0.5 * power).next_up()];
            assert_eq!(cases.map(power_of_two), [power; 4]);
        }
        assert_eq!([0.0, f64::MAX].map(power_of_two), [0.0, f64::INFINITY]);
    }
}
