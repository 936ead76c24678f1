//! Diagnostics of the library -> objects with fields.

use pyo3::prelude::*;
use trimtess::model;

/// Reports something that was not understood, repaired or lost.
#[pyclass(frozen, get_all, module = "trimtess")]
pub(crate) struct Diagnostic {
    /// "note", "warning" or "error".
    severity: &'static str,
    /// Stable code, listed in docs/diagnostics.md.
    code: &'static str,
    /// What happened and why, with numbers.
    message: String,
    /// Index of the part concerned.
    part: Option<u32>,
    /// Index of the face concerned, within the part.
    face: Option<u32>,
    /// Index of the edge concerned, within the part.
    edge: Option<u32>,
    /// Number of the entity in the file.
    entity: Option<u64>,
    /// Where, in the part's coordinates, millimetres.
    place: Option<(f64, f64, f64)>,
    /// Whether it means that the mesh is not what the file states: an error, or a warning about a face.
    is_fault: bool,
}

impl From<&model::Diagnostic> for Diagnostic {
    fn from(told: &model::Diagnostic) -> Self {
        Self {
            severity: told.severity.name(),
            code: told.kind.code(),
            message: told.kind.to_string(),
            part: told.part.map(|part| part.0),
            face: told.face.map(|face| face.0),
            edge: told.edge.map(|edge| edge.0),
            entity: Some(told.entity).filter(|&entity| entity != 0),
            place: told.place.map(Into::into),
            is_fault: told.is_fault(),
        }
    }
}

#[pymethods]
impl Diagnostic {
    fn __repr__(&self) -> String {
        let of = |name: &str, number: Option<u64>| number.map_or(String::new(), |number| format!(" {name}={number}"));
        let (part, face) = (of("part", self.part.map(u64::from)), of("face", self.face.map(u64::from)));
        format!("<Diagnostic {} {}{part}{face}: {}>", self.severity, self.code, self.message)
    }
}

/// All diagnostics, in their order.
pub(crate) fn list(all: &[model::Diagnostic]) -> Vec<Diagnostic> {
    all.iter().map(Diagnostic::from).collect()
}

/// "2 errors, 1 warning, 0 notes", for representations.
pub(crate) fn counts(all: &[model::Diagnostic]) -> String {
    let count = |severity: model::Severity| {
        let count = all.iter().filter(|told| told.severity == severity).count();
        format!("{count} {}{}", severity.name(), if count == 1 { "" } else { "s" })
    };
    [model::Severity::Error, model::Severity::Warning, model::Severity::Note].map(count).join(", ")
}

/// A table of facts for notebooks.
pub(crate) fn html(title: &str, facts: &[(&str, String)]) -> String {
    let escape = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let row = |(name, value): &(&str, String)| {
        format!("<tr><th style=\"text-align:left\">{}</th><td>{}</td></tr>", escape(name), escape(value))
    };
    let rows: String = facts.iter().map(row).collect();
    format!("<table><caption>{}</caption>{rows}</table>", escape(title))
}
