//! A tolerance, or views of a scene -> the tolerance that applies in each box of a part.

pub(super) mod part_camera;

use crate::math::lanes::{larger, smaller};
use crate::prepare::internals::BoundingBox;
use glam::DVec3;
use part_camera::{PartCamera, PixelScale};
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

/// Tolerances of boxes that are at least this fraction of each other count as equal: the number of lines differs by a
/// twentieth at most.
const ALIKE: f64 = 0.9;
/// If the pixels per millimetre differ by less within the box around all of them, the largest stands for each: the
/// tolerance is stricter than needed by 4 % at most. Most tiles are small from where they are seen, and one look is
/// enough.
const SAME: f64 = 0.96;

/// Tolerance of one tile or edge, box by box.
#[derive(Clone, Debug)]
pub(crate) struct BoxTolerances {
    /// The strictest tolerance of any of its boxes.
    pub(crate) tolerance: Tolerance,
    /// By box, `tolerance` as a fraction of the box's own: at most 1, and 0 for a box behind every camera. Empty if all
    /// boxes have the same.
    pub(crate) shares: Vec<f64>,
    /// The part's radius.
    pub(crate) radius: f64,
}

impl Default for BoxTolerances {
    /// No boxes and no limit.
    fn default() -> Self {
        let tolerance = Tolerance { chord: f64::INFINITY, angle: f64::INFINITY, max_edge: None };
        Self { tolerance, shares: Vec::new(), radius: 0.0 }
    }
}

impl BoxTolerances {
    /// Whether all boxes have the same tolerance.
    pub(crate) fn is_even(&self) -> bool {
        self.shares.is_empty()
    }

    /// The loosest chord tolerance of any of the boxes.
    pub(crate) fn loosest_chord(&self) -> f64 {
        self.tolerance.chord / self.shares.iter().fold(1.0, |least, &share| smaller(share, least))
    }
}

/// Tolerance of a part: the same everywhere, or in each box by the screen-space error of its instances.
pub(crate) struct PartTolerance<'a> {
    /// In part coordinates; with cameras, the tolerance where one millimetre covers one pixel.
    tolerance: Tolerance,
    /// In the coordinates of each instance; none for the same tolerance everywhere.
    cameras: &'a [PartCamera],
    centre: DVec3,
    radius: f64,
}

impl<'a> PartTolerance<'a> {
    /// The same tolerance everywhere, for a part of this radius.
    pub(crate) fn everywhere(tolerance: &Tolerance, radius: f64) -> Self {
        Self { tolerance: tolerance.usable(radius), cameras: &[], centre: DVec3::ZERO, radius }
    }

    /// Screen-space error for `cameras`, of a part with this centre and radius. `per_pixel`: the tolerance where one
    /// millimetre of the part covers one pixel.
    pub(crate) fn seen(per_pixel: &Tolerance, cameras: &'a [PartCamera], (centre, radius): (DVec3, f64)) -> Self {
        Self { tolerance: *per_pixel, cameras, centre, radius }
    }

    /// See [`Tolerance::around`]; the fewest lines that any place of the part needs. Cost: a look at each camera.
    pub(crate) fn around(&self, exact: bool) -> f64 {
        let least = || {
            let whole = BoundingBox { low: self.centre - self.radius, high: self.centre + self.radius };
            self.cameras.iter().map(|camera| camera.pixel_scale(&whole).least).fold(0.0, larger)
        };
        let loosest = if self.cameras.is_empty() { self.tolerance } else { self.at(least()) };
        loosest.around(self.radius, exact)
    }

    /// Whether the length of edges is limited.
    pub(crate) fn limits_length(&self) -> bool {
        self.tolerance.max_edge.is_some()
    }

    /// Writes the tolerance of a tile or an edge with these boxes to `need`.
    pub(crate) fn over<'b>(&self, places: impl Iterator<Item = &'b BoundingBox> + Clone, need: &mut BoxTolerances) {
        let BoxTolerances { tolerance, shares, radius } = need;
        *radius = self.radius;
        shares.clear();
        if self.cameras.is_empty() {
            *tolerance = self.tolerance;
            return;
        }
        let whole = places.clone().fold(BoundingBox::EMPTY, |all, place| all.with(place));
        let scales = self.cameras.iter().map(|camera| camera.pixel_scale(&whole));
        let PixelScale { mut most, least } = scales.fold(PixelScale { most: 0.0, least: 0.0 }, PixelScale::max);
        if least < SAME * most {
            let nearest = |place: &BoundingBox| {
                self.cameras.iter().map(|camera| camera.pixels_per_length(place)).fold(0.0, |most, x| larger(x, most))
            };
            shares.extend(places.map(nearest));
            most = shares.iter().fold(0.0, |most, &x| larger(x, most));
            if shares.iter().all(|&pixels| pixels >= ALIKE * most) {
                shares.clear();
            }
            shares.iter_mut().for_each(|pixels| *pixels /= most);
        }
        *tolerance = self.at(most);
    }

    /// A tolerance that is at most that of any tile or edge with boxes within this one. `None` unless it is certainly
    /// in the picture of each camera, and without cameras.
    pub(crate) fn strictest(&self, whole: &BoundingBox) -> Option<Tolerance> {
        if self.cameras.is_empty() {
            return None;
        }
        let scales = self.cameras.iter().map(|camera| camera.look_within(whole));
        let most = scales.reduce(|a, b| Some(a?.max(b?)))??.most;
        Some(self.at(most))
    }

    /// The tolerance where one millimetre covers so many pixels.
    fn at(&self, most: f64) -> Tolerance {
        let Tolerance { chord, angle, max_edge } = self.tolerance;
        let seen = Tolerance { chord: chord / most, angle, max_edge: max_edge.map(|m| m / most) };
        seen.usable(self.radius)
    }
}

/// Whether any two neighbours in a grid of `columns` columns differ by more than a factor of two.
pub(crate) fn is_steep(of: &[f64], columns: usize) -> bool {
    let apart = |a: f64, b: f64| a > 2.0 * b || b > 2.0 * a;
    let in_rows = of.chunks(columns).any(|row| row.windows(2).any(|w| apart(w[0], w[1])));
    in_rows || of.iter().zip(&of[columns.min(of.len())..]).any(|(&a, &b)| apart(a, b))
}

/// Writes a grid of `columns` columns to `out`, each value replaced by the largest at most `reach` rows and columns
/// away.
pub(crate) fn dilate(of: &[f64], columns: usize, reach: usize, out: &mut Vec<f64>) {
    out.clear();
    if reach == 0 {
        out.extend_from_slice(of);
        return;
    }
    let window = |k: usize, n: usize| k.saturating_sub(reach)..(k + reach + 1).min(n);
    // Along rows, then across them.
    for row in of.chunks(columns) {
        out.extend((0..row.len()).map(|j| row[window(j, row.len())].iter().fold(0.0, |most, &x| larger(x, most))));
    }
    let rows = of.len() / columns;
    if rows > 1 {
        for k in 0..of.len() {
            let near = window(k / columns, rows).map(|i| out[i * columns + k % columns]);
            out.push(near.fold(0.0, |most, x| larger(x, most)));
        }
        out.drain(..of.len());
    }
}

/// The largest number of strips under a gap between two `lines`.
pub(crate) fn most_touched(breaks: &[f64], lines: &[f64]) -> usize {
    let strips = breaks.len() - 1;
    let mut first = 0;
    let mut most = 1;
    for gap in lines.windows(2) {
        while first + 1 < strips && breaks[first + 1] <= gap[0] {
            first += 1;
        }
        let under = breaks[first + 1..strips].iter().take_while(|&&b| b < gap[1]).count();
        most = most.max(1 + under);
    }
    most
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

    #[test]
    fn dilate_takes_the_largest_value_nearby() {
        let of = [0.1, 0.2, 0.3, 0.9, 0.1, 0.1];
        let dilated = |of: &[f64], columns, reach| {
            let mut out = vec![7.0];
            dilate(of, columns, reach, &mut out);
            out
        };
        assert_eq!(dilated(&of, 3, 0), of);
        assert_eq!(dilated(&of, 3, 1), [0.9, 0.9, 0.3, 0.9, 0.9, 0.3]);
        assert_eq!(dilated(&of, 1, 1), [0.2, 0.3, 0.9, 0.9, 0.9, 0.1]);
        assert_eq!(dilated(&of, 3, 9), [0.9; 6]);
    }

    #[test]
    fn neighbours_are_compared_along_and_across_rows() {
        assert!(!is_steep(&[0.5, 1.0, 0.5, 0.5, 0.5, 0.5], 3) && !is_steep(&[0.0; 4], 2) && !is_steep(&[1.0], 1));
        assert!(is_steep(&[0.4, 1.0, 0.5, 0.5, 0.5, 0.5], 3));
        assert!(is_steep(&[0.5, 1.0, 0.5, 0.5, 0.5, 0.2], 3));
        assert!(!is_steep(&[0.5, 0.5, 1.0, 0.3, 0.6, 0.7], 3) && is_steep(&[0.1, 0.3, 0.3, 0.4], 1));
    }

    #[test]
    fn most_touched_counts_the_strips_under_a_gap() {
        let breaks = [0.0, 1.0, 2.0, 3.0, 4.0];
        assert_eq!(most_touched(&breaks, &[0.0, 1.0, 2.0, 2.5, 4.0]), 2);
        assert_eq!(most_touched(&breaks, &[0.0, 0.5, 3.5, 4.0]), 4);
        assert_eq!(most_touched(&breaks, &[1.0, 1.5, 2.0]), 1);
        // Edges may be longer than their table, by rounding.
        assert_eq!(most_touched(&breaks, &[-1e-9, 4.0 + 1e-9]), 4);
    }
}
