//! Sessions: workers that own tiles and never talk to each other, and one thread that commits their batches. The
//! protocol is described in `README.md` of this folder.

pub mod distribute;

mod cores;

mod crew;
pub use crew::StartError;

mod handoff;
pub use handoff::{DegradedTile, FaceFill, FaceRung, LostLine};

mod master;
pub use master::{Session, SessionOptions, serial};

mod metrics;
pub use metrics::{WorkerMetrics, balance};

mod owners;

mod commit;
pub use commit::{FrameError, FrameReport};

mod upkeep;

mod worker;
