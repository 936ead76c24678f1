//! Readers of CAD files.
#[cfg(feature = "step")]
pub mod step;
