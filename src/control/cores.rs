//! Pins threads to cores. Without the feature `affinity` no cores are known and nothing is pinned.

#[cfg(feature = "affinity")]
pub(super) use core_affinity::CoreId;

#[cfg(not(feature = "affinity"))]
#[derive(Clone, Copy)]
pub(super) enum CoreId {}

/// All cores, or none if the system does not list them.
#[cfg(feature = "affinity")]
pub(super) fn cores() -> Vec<CoreId> {
    core_affinity::get_core_ids().unwrap_or_default()
}

/// No cores.
#[cfg(not(feature = "affinity"))]
pub(super) fn cores() -> Vec<CoreId> {
    Vec::new()
}

/// Pins this thread to a core. Has no effect if the system refuses.
pub(super) fn stay_on(core: CoreId) {
    #[cfg(feature = "affinity")]
    core_affinity::set_for_current(core);
    #[cfg(not(feature = "affinity"))]
    match core {}
}
