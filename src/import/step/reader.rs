//! Context shared by all parts of a file.

use super::options::StepOptions;
use super::place::Geometry;
use super::style::Styles;
use super::table::Table;
use super::units::Units;
use crate::control::Call;

/// Context shared by all parts of a file.
#[derive(Clone, Copy)]
pub(super) struct Reader<'a> {
    pub(super) call: Call<'a>,
    pub(super) table: &'a Table,
    pub(super) styles: &'a Styles,
    pub(super) options: &'a StepOptions,
}

impl Reader<'_> {
    /// Access to geometry in `units`.
    pub(super) fn geometry(&self, units: Units) -> Geometry<'_> {
        Geometry::new(self.table, units, self.options.fit_tolerance)
    }
}
