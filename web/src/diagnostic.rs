//! Diagnostics of the library -> objects of JavaScript.

use serde::Serialize;
use trimtess::model;
use tsify::{Ts, Tsify};
use wasm_bindgen::JsError;

/// The largest whole number up to which JavaScript has all. A larger one would become another.
const MAX_SAFE_INTEGER: u64 = (1 << 53) - 1;

/// What was not understood, repaired or lost.
#[derive(Serialize, Tsify)]
pub struct Diagnostic {
    #[tsify(type = "\"note\" | \"warning\" | \"error\"")]
    severity: &'static str,
    /// Stable name of its kind.
    code: &'static str,
    /// What happened and why, with numbers.
    text: String,
    /// The mesh is not what the file states.
    fault: bool,
    #[tsify(optional)]
    part: Option<u32>,
    /// Number within the part.
    #[tsify(optional)]
    face: Option<u32>,
    /// Number within the part.
    #[tsify(optional)]
    edge: Option<u32>,
    /// Number of the entity in the file, if JavaScript can name it.
    #[tsify(optional)]
    entity: Option<u64>,
    /// Where, in the part's coordinates, millimetres.
    #[tsify(optional)]
    place: Option<[f64; 3]>,
    /// A viewer finds something to show: a face or a place of a part.
    shown: bool,
}

impl From<&model::Diagnostic> for Diagnostic {
    fn from(told: &model::Diagnostic) -> Self {
        Self {
            severity: told.severity.name(),
            code: told.kind.code(),
            text: told.kind.to_string(),
            fault: told.is_fault(),
            part: told.part.map(|part| part.0),
            face: told.face.map(|face| face.0),
            edge: told.edge.map(|edge| edge.0),
            entity: Some(told.entity).filter(|entity| (1..=MAX_SAFE_INTEGER).contains(entity)),
            place: told.place.map(Into::into),
            shown: told.part.is_some() && (told.face.is_some() || told.place.is_some()),
        }
    }
}

/// All diagnostics, in their order.
pub(crate) fn listed(all: &[model::Diagnostic]) -> Result<Vec<Ts<Diagnostic>>, JsError> {
    all.iter().map(|told| Ok(Diagnostic::from(told).into_ts()?)).collect()
}
