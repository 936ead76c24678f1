//! Meshes to files and pictures: [`save`](crate::out::save) for all files, in the format that the caller names, or the
//! file extension ([`Format::of_path`](crate::out::Format::of_path)).
//!
//! Files are written atomically. Positions that are equal in a part stay equal in the file, whatever the format.

mod pending;
pub use pending::{Outputs, remove_temporaries, target_of, write_whole};

mod placed;
pub use placed::BeyondSingle;

mod format;
#[cfg(feature = "glb")]
pub use format::GlbOptions;
pub use format::{Format, SaveOptions, UnknownFormat};

#[cfg(feature = "glb")]
mod node_place;

mod rounding;
pub use rounding::{RoundedTooFar, Rounding};

mod making;
pub use making::{MeshLevel, SaveError, UnfitLevel};

mod plain;

#[cfg(feature = "glb")]
mod glb_buffers;

#[cfg(feature = "glb")]
mod glb_numbers;

#[cfg(feature = "glb")]
mod glb;

mod save;
pub use save::{Saved, save, save_on, write, write_on};

mod file_triangles;

#[cfg(feature = "glb")]
mod read_glb;

mod read_back;
pub use read_back::{ReadBack, read_back};

/// Pictures through wgpu.
#[cfg(feature = "wgpu")]
pub mod wgpu;
