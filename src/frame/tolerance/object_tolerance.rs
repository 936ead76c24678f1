//! A tolerance for the placed model -> the tolerance of a part, raised to the least that a mesh can meet.

use std::f64::consts::{PI, SQRT_2, TAU};

/// Least chord tolerance, as a fraction of the part's radius. Parameters on edges are accurate to about 1e-12 of a
/// domain: finer meshes would only show rounding.
const LEAST_CHORD: f64 = 1e-9;
/// Least angle tolerance, radians: 60 000 segments around a circle.
const LEAST_ANGLE: f64 = 1e-4;
/// Least edge length tolerance, as a fraction of the part's radius.
const LEAST_EDGE: f64 = 1e-6;

/// Object-space tolerance of a mesh.
///
/// Values that are too small to meet (zero, negative values and NaN too) are raised to the least that can be met: 1e-9
/// of a part's radius for `chord`, 1e-4 for `angle`, 1e-6 of the radius for `max_edge`. The plan reports this in
/// [`Shortfall::unusable`](crate::frame::plan::limits::Shortfall::unusable).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Tolerance {
    /// Maximum distance between triangles and surface, and between polylines and edges, millimetres. Positive; infinite
    /// = no limit.
    pub chord: f64,
    /// Maximum turn of the normal across a cell and of the tangent along a segment, radians. Positive; values above a
    /// quarter turn count as a quarter turn, so that small pins and holes never collapse.
    pub angle: f64,
    /// Maximum length of a cell's diagonal or an edge's segment, millimetres; `None` = no limit.
    pub max_edge: Option<f64>,
}

impl Tolerance {
    /// `chord` of programs unless told otherwise, as a fraction of the model's diagonal. At 1e-2 a cylinder across the
    /// model is visibly a prism; 1e-4 makes ten times as many triangles that look the same on a screen.
    pub const DEFAULT_CHORD_REL: f64 = 1e-3;
    /// `angle` of programs unless told otherwise, degrees: about 18 segments around a full circle, however small.
    pub const DEFAULT_ANGLE_DEGREES: f64 = 20.0;

    /// A chord that is a fraction of the [diagonal](crate::prepare::Prepared::diagonal) of a model, millimetres,
    /// [`DEFAULT_ANGLE_DEGREES`](Self::DEFAULT_ANGLE_DEGREES) and edges of any length. The diagonal of a model without
    /// extent counts as 1 mm: it has no triangles, whatever the tolerance is.
    #[must_use]
    pub fn relative(fraction: f64, diagonal: f64) -> Self {
        let chord = fraction * if diagonal > 0.0 { diagonal } else { 1.0 };
        Self { chord, angle: Self::DEFAULT_ANGLE_DEGREES.to_radians(), max_edge: None }
    }

    /// The tolerance in the coordinates of a part that is placed at `scale`.
    pub(crate) fn within_part(&self, scale: f64) -> Self {
        Self { chord: self.chord / scale, angle: self.angle, max_edge: self.max_edge.map(|length| length / scale) }
    }

    /// Lines that it needs around a circle of this radius, millimetres. `exact`: whether bounds of derivatives are
    /// those of plain shapes. Of splines they may be noise, and only the length of edges counts.
    pub(crate) fn around(&self, radius: f64, exact: bool) -> f64 {
        let Self { chord, angle, max_edge } = self;
        let by_length = max_edge.map_or(0.0, |length| SQRT_2 * TAU * radius / length);
        let by_shape = (PI * (0.5 * radius / chord).sqrt()).max(TAU / angle);
        if exact { by_shape.max(by_length) } else { by_length }
    }

    /// Raises values that a part of this radius cannot meet to the least that it can.
    pub(crate) fn usable(&self, radius: f64) -> Self {
        let share = |share: f64| (share * radius).max(f64::MIN_POSITIVE);
        // `max` makes NaN the least value.
        Self {
            chord: self.chord.max(share(LEAST_CHORD)),
            angle: self.angle.max(LEAST_ANGLE),
            max_edge: self.max_edge.map(|length| length.max(share(LEAST_EDGE))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_too_small_to_meet_are_raised_to_the_least_that_can_be_met() {
        let good = Tolerance { chord: 0.1, angle: 0.3, max_edge: Some(2.0) };
        assert_eq!(good.usable(1.0), good);
        let least = Tolerance { chord: LEAST_CHORD, angle: LEAST_ANGLE, max_edge: Some(LEAST_EDGE) };
        for bad in [0.0, -1.0, f64::NAN, f64::NEG_INFINITY, 1e-300] {
            let asked = Tolerance { chord: bad, angle: bad, max_edge: Some(bad) };
            assert!(asked.usable(1.0) == least && asked != least, "{bad}");
        }
        let free = Tolerance { chord: f64::INFINITY, angle: 9.0, max_edge: None };
        assert_eq!(free.usable(1.0), free);
    }
}
