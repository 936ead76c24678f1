//! Attributes of parts and instances in frames of views.

use crate::errors;
use crate::model::{Rgba, rgba};
use pyo3::prelude::*;
use trimtess::frame;
use trimtess::model::Colour;
use trimtess::parallel::EditError;

/// What a colour is.
const SHARES: &str = "three or four numbers from 0 to 1";

/// How views draw a part, or an instance. Attributes of an instance and of its part are combined.
#[pyclass(frozen, get_all, module = "trimtess")]
pub(crate) struct Attributes {
    /// Whether views draw it.
    visible: bool,
    /// Red, green, blue (sRGB) and opacity, 0 to 1, instead of the colours of the model; None keeps them.
    colour: Option<Rgba>,
    /// Factor on `deviation_px` and `size_px` of all views.
    tolerance_scale: f64,
    /// Factor on the error by which tiles are ordered while a budget defers some.
    priority: f64,
}

impl From<frame::Attributes> for Attributes {
    fn from(frame::Attributes { visible, colour, tolerance_scale, priority, .. }: frame::Attributes) -> Self {
        Self { visible, colour: rgba(colour), tolerance_scale, priority }
    }
}

#[pymethods]
impl Attributes {
    fn __repr__(&self) -> String {
        let Self { visible, tolerance_scale, priority, .. } = self;
        let visible = if *visible { "visible" } else { "hidden" };
        format!("<Attributes: {visible}, tolerance times {tolerance_scale}, priority {priority}>")
    }
}

/// What Python gave as keywords.
pub(crate) fn attributes(
    py: Python<'_>,
    (visible, colour): (bool, Option<Vec<f32>>),
    (tolerance_scale, priority): (f64, f64),
) -> PyResult<frame::Attributes> {
    let attributes = frame::Attributes::DEFAULT
        .with_visible(visible)
        .with_colour(colour.map(|shares| colour_of(py, &shares)).transpose()?)
        .with_tolerance_scale(tolerance_scale)
        .with_priority(priority);
    Ok(attributes)
}

/// A colour of three numbers is opaque.
fn colour_of(py: Python<'_>, shares: &[f32]) -> PyResult<Colour> {
    match *shares {
        [red, green, blue] => Ok([red, green, blue, 1.0]),
        [red, green, blue, opacity] => Ok([red, green, blue, opacity]),
        _ => Err(errors::out_of_range(py, "colour", format!("{shares:?}"), SHARES)),
    }
}

/// Why a scene was not edited.
pub(crate) fn edit_error(py: Python<'_>, failure: &EditError) -> PyErr {
    match failure {
        EditError::NoPart { part, count } => {
            errors::out_of_range(py, "part", part.0, &format!("below {count}, the number of parts"))
        }
        EditError::NoInstance { key } => errors::out_of_range(py, "key", key.to_bits(), "that of an instance"),
        EditError::Transform { .. } => errors::unfit(py, "transform", failure, "a rigid motion with a uniform scale"),
        EditError::Factor { name, value } => errors::out_of_range(py, name, value, "a finite number above 0"),
        EditError::Colour { colour } => errors::out_of_range(py, "colour", format!("{colour:?}"), SHARES),
        _ => errors::internal(py, failure.to_string()),
    }
}
