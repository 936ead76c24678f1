//! Context shared by all parts of a file.

use super::options::StepOptions;
use super::place::Geometry;
use super::style::Styles;
use super::table::Table;
use super::units::Units;
use super::values::Map;
use crate::control::Call;
use crate::model::Colour;

/// Context shared by all parts of a file.
#[derive(Clone, Copy)]
pub(super) struct Reader<'a> {
    pub(super) call: Call<'a>,
    pub(super) table: &'a Table,
    pub(super) styles: &'a Styles,
    /// Colours for faces without one, from copies of them.
    pub(super) colours_of_copies: &'a Map<u64, Colour>,
    pub(super) options: &'a StepOptions,
}

impl Reader<'_> {
    /// The colour of a face, else that of a copy of it.
    pub(super) fn colour(&self, face: u64) -> Option<Colour> {
        self.styles.of(face).or_else(|| self.colours_of_copies.get(&face).copied())
    }

    /// Access to geometry in `units`.
    pub(super) fn geometry(&self, units: Units) -> Geometry<'_> {
        Geometry::new(self.table, units, self.options.fit_tolerance)
    }
}
