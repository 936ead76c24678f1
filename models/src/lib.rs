//! The models of Kumar & Manocha 1995, stated by hand: a disc brake, the Utah teapot, and teapots with free trims.
//!
//! They are larger than [`shapes`], the models of the library itself. [`by_name`] knows both; `builtin:NAME` on the command
//! line is one of them.
//!
//! ```
//! let brake = trimtess_models::by_name("brake-assembly").expect("a named model");
//! assert_eq!(brake.parts.len(), 10);
//! ```

use glam::DAffine3;
use trimtess::model::{Model, ModelBuilder, shapes};

mod brake;
mod teapot;
mod trimmed_teapots;

/// The names that this crate adds to [`shapes::NAMES`].
pub const NAMES: [&str; 6] =
    ["teapot", "trimmed-teapot", "flower-teapot", "brake-hub", "brake-rotor", "brake-assembly"];

/// All names that [`by_name`] knows: the library's shapes first.
pub fn names() -> impl Iterator<Item = &'static str> {
    shapes::NAMES.into_iter().chain(NAMES)
}

/// The model of that name; `None` if there is none.
///
/// ```
/// assert!(trimtess_models::names().all(|name| trimtess_models::by_name(name).is_some()));
/// assert!(trimtess_models::by_name("kettle").is_none());
/// ```
#[must_use]
pub fn by_name(name: &str) -> Option<Model> {
    let part = match name {
        "teapot" => teapot::teapot(),
        "trimmed-teapot" => trimmed_teapots::unc(),
        "flower-teapot" => trimmed_teapots::flowers(),
        "brake-hub" => brake::hub(),
        "brake-rotor" => brake::rotor(),
        "brake-assembly" => return Some(brake::assembly()),
        _ => return shapes::by_name(name),
    };
    let mut model = ModelBuilder::new(name);
    let part = model.part(part);
    model.place(part, DAffine3::IDENTITY);
    Some(model.finish().expect("the models are stated soundly"))
}
