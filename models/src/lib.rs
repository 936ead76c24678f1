//! The models of Kumar & Manocha 1995, built in code: a disc brake, the Utah teapot, and teapots with free trims.
//!
//! They are larger than the library's own [`shapes`]. [`by_name`] finds both kinds, as does `builtin:NAME` on the
//! command line.
//!
//! ```
//! let brake = trimtess_models::by_name("brake-assembly").expect("a named model");
//! assert_eq!(brake.parts.len(), 10);
//! ```

use trimtess::model::{Model, shapes};

mod brake;
mod teapot;
mod trimmed_teapots;

/// The names that this crate adds to [`shapes::NAMES`].
pub const NAMES: &[&str] = &["teapot", "trimmed-teapot", "flower-teapot", "brake-hub", "brake-rotor", "brake-assembly"];

/// All names that [`by_name`] accepts, the library's shapes first.
pub fn names() -> impl Iterator<Item = &'static str> {
    shapes::NAMES.iter().chain(NAMES).copied()
}

/// Builds a model by name. `None` if the name is unknown.
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
    Some(Model { name: name.into(), ..part.into() })
}
