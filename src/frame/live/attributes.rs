//! What a caller says of parts and instances -> what frames of views make of each instance.

use crate::math::keyed::take_rows;
use crate::model::{Colour, PartId};
use std::collections::BTreeMap;

/// How views draw a part, or an instance. Attributes of an instance and of its part are combined.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Attributes {
    /// Whether views draw it. An instance is drawn if it and its part are visible. What is not drawn asks for no tiles;
    /// those that are resident stay as if they were off-screen.
    pub visible: bool,
    /// Red, green, blue (sRGB) and opacity, each 0 to 1, instead of the colours of the model. An instance's overrides
    /// its part's. `None`: the part's, or the model's.
    pub colour: Option<Colour>,
    /// Factor on [`deviation_px`](crate::view::View::deviation_px) and [`size_px`](crate::view::View::size_px) of all
    /// views: 0.5 is twice as fine. Finite and above 0. Those of an instance and its part are multiplied; products
    /// below 1e-6 and above 1e6 count as these. [`angle`](crate::view::View::angle) stays.
    ///
    /// Instances that share an LOD share its tiles, which are as fine as the strictest of them needs.
    pub tolerance_scale: f64,
    /// Factor on the error by which tiles are ordered while a [budget](super::rates::PlannerOptions::budget) defers
    /// some. Finite and above 0. Those of an instance and its part are multiplied. Instances that share an LOD share
    /// the largest of those in view.
    pub priority: f64,
}

impl Attributes {
    /// Visible, in the colours of the model, with the tolerance of the views and priority 1.
    pub const DEFAULT: Self = Self { visible: true, colour: None, tolerance_scale: 1.0, priority: 1.0 };

    /// Those of an instance that has these, of a part that has `of_part`.
    fn combined(self, of_part: &Self) -> Self {
        /// Bounds on the scale, far beyond what meshes need: the inverse of a tolerance stays finite.
        const SCALES: [f64; 2] = [1e-6, 1e6];
        Self {
            visible: self.visible && of_part.visible,
            colour: self.colour.or(of_part.colour),
            tolerance_scale: (self.tolerance_scale * of_part.tolerance_scale).clamp(SCALES[0], SCALES[1]),
            priority: (self.priority * of_part.priority).clamp(f64::MIN_POSITIVE, f64::MAX),
        }
    }
}

options! {
    Attributes:
    with_visible(visible: bool);
    with_colour(colour: Option<Colour>);
    with_tolerance_scale(tolerance_scale: f64);
    with_priority(priority: f64);
}

/// Attributes of an instance.
#[derive(Clone, Copy, Debug)]
struct Row {
    own: Attributes,
    /// With those of its part.
    combined: Attributes,
}

impl Row {
    const DEFAULT: Self = Self { own: Attributes::DEFAULT, combined: Attributes::DEFAULT };
}

/// Attributes of the parts of a model, and of its instances. Takes no room while nothing is said of any.
#[derive(Debug, Default)]
pub(crate) struct AttributeTable {
    /// Without those that have the default.
    parts: BTreeMap<PartId, Attributes>,
    /// By instance; empty while nothing was said.
    rows: Vec<Row>,
}

impl AttributeTable {
    /// Those of an instance together with its part's.
    pub(crate) fn of(&self, instance: usize) -> &Attributes {
        self.rows.get(instance).map_or(&Attributes::DEFAULT, |row| &row.combined)
    }

    /// The parts whose attributes are not the default.
    pub(crate) fn parts(&self) -> &BTreeMap<PartId, Attributes> {
        &self.parts
    }

    /// Sets those of a part. [`combine`](Self::combine) its instances after that.
    pub(crate) fn set_part(&mut self, part: PartId, attributes: Attributes) {
        if attributes == Attributes::DEFAULT {
            self.parts.remove(&part);
        } else {
            self.parts.insert(part, attributes);
        }
    }

    /// Sets those of an instance, one of `count`. [`combine`](Self::combine) it after that.
    pub(crate) fn set_instance(&mut self, (instance, count): (usize, usize), attributes: Attributes) {
        self.rows.resize(count, Row::DEFAULT);
        self.rows[instance].own = attributes;
    }

    /// Combines the attributes of an instance, one of `count`, with those of its part. Returns what it had before, if
    /// that was different.
    pub(crate) fn combine(&mut self, (instance, count): (usize, usize), part: PartId) -> Option<Attributes> {
        self.rows.resize(count, Row::DEFAULT);
        let row = &mut self.rows[instance];
        let now = row.own.combined(self.parts.get(&part).unwrap_or(&Attributes::DEFAULT));
        let before = std::mem::replace(&mut row.combined, now);
        (before != now).then_some(before)
    }

    /// Removes instances, whose numbers ascend. Those of later ones decrease.
    pub(crate) fn remove(&mut self, instances: &[usize]) {
        take_rows(&mut self.rows, instances);
    }

    /// Its memory, bytes.
    pub(crate) fn memory(&self) -> usize {
        size_of::<Row>() * self.rows.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: Colour = [1.0, 0.0, 0.0, 1.0];
    const BLUE: Colour = [0.0, 0.0, 1.0, 1.0];

    #[test]
    fn an_instance_and_its_part_hold_together() {
        let part = Attributes::DEFAULT.with_colour(Some(RED)).with_tolerance_scale(0.5).with_priority(3.0);
        let own = Attributes::DEFAULT.with_tolerance_scale(4.0).with_priority(2.0);
        let both = own.combined(&part);
        assert_eq!((both.visible, both.colour, both.tolerance_scale, both.priority), (true, Some(RED), 2.0, 6.0));
        assert_eq!(own.with_colour(Some(BLUE)).combined(&part).colour, Some(BLUE));
        let visible = [[true, true], [true, false], [false, true], [false, false]]
            .map(|[a, b]| own.with_visible(a).combined(&part.with_visible(b)).visible);
        assert_eq!(visible, [true, false, false, false]);
        for far in [1e-300, 1e300, f64::MIN_POSITIVE, f64::MAX] {
            let far = Attributes::DEFAULT.with_tolerance_scale(far).with_priority(far);
            let both = far.combined(&far);
            assert!((1e-6..=1e6).contains(&both.tolerance_scale) && both.priority > 0.0 && both.priority.is_finite());
        }
    }

    #[test]
    fn the_table_is_as_long_as_the_instances_once_anything_is_said() {
        let mut table = AttributeTable::default();
        table.remove(&[3]);
        assert_eq!((table.memory(), table.of(7)), (0, &Attributes::DEFAULT));
        let hidden = Attributes::DEFAULT.with_visible(false);
        table.set_instance((1, 3), hidden);
        assert_eq!(table.combine((1, 3), PartId(0)), Some(Attributes::DEFAULT));
        assert_eq!(table.combine((1, 3), PartId(0)), None);
        table.set_part(PartId(4), hidden);
        assert_eq!(table.combine((2, 3), PartId(4)), Some(Attributes::DEFAULT));
        table.remove(&[0]);
        assert_eq!([0, 1, 2, 9].map(|row| table.of(row).visible), [false, false, true, true]);
        table.set_part(PartId(4), Attributes::DEFAULT);
        assert!(table.parts().is_empty() && table.combine((1, 2), PartId(4)) == Some(hidden));
    }
}
