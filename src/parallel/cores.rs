//! The cores of this machine -> threads that stay on one of them. Without the feature `affinity` no core is known.

/// A core.
#[cfg(feature = "affinity")]
pub(super) use core_affinity::CoreId;

/// A core.
#[cfg(not(feature = "affinity"))]
#[derive(Clone, Copy)]
pub(super) enum CoreId {}

/// All cores; empty where they are not known.
#[cfg(feature = "affinity")]
pub(super) fn cores() -> Vec<CoreId> {
    core_affinity::get_core_ids().unwrap_or_default()
}

/// All cores; empty where they are not known.
#[cfg(not(feature = "affinity"))]
pub(super) fn cores() -> Vec<CoreId> {
    Vec::new()
}

/// Keeps this thread on a core. Where that is refused, the system goes on choosing.
pub(super) fn stay_on(core: CoreId) {
    #[cfg(feature = "affinity")]
    core_affinity::set_for_current(core);
    #[cfg(not(feature = "affinity"))]
    match core {}
}
