//! Sessions: workers that own tiles and never talk to each other, and one thread that commits their batches. The
//! protocol is described in `README.md` of this folder.

mod distribute;

mod metrics;
pub use metrics::{SessionMemory, WorkerMetrics, balance};

mod writer;

mod handoff;
pub use handoff::{DegradedTile, FaceFill, FaceRung, LostLine};

mod scene_keys;

mod error;
pub use error::{EditError, FrameError};

mod edits;

mod commit;
pub use commit::FrameReport;

mod diagnose;

mod residency;

mod owners;

mod flight;

mod worker;

mod engine;
pub use engine::SessionOptions;

mod once;
pub use once::{coarse_points, serial, tessellate_on};

mod session;
pub use session::Session;

mod placing;

/// What this project's own program, benches and tests use of the stages. Not part of the stable interface.
#[doc(hidden)]
pub mod internals {
    pub use super::distribute::{Load, deal, loads};
}
