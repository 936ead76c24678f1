//! Meshes to files and pictures: [`save`](crate::out::save) for all files, in the format that the caller names, or the
//! file extension ([`Format::of_path`](crate::out::Format::of_path)).
//!
//! Files are written atomically. Positions that are equal in a part stay equal in the file, whatever the format.

mod pending;
pub use pending::{Outputs, remove_temporaries, target_of, write_whole};

mod placed;

mod single;
pub use single::BeyondSingle;

#[cfg(any(feature = "glb", feature = "wgpu"))]
mod colour;

#[cfg(feature = "glb")]
mod glb_options;
#[cfg(feature = "glb")]
pub use glb_options::GlbOptions;

#[cfg(feature = "glb")]
mod node_place;

mod rounding;
pub use rounding::{RoundedTooFar, Rounding};

mod levels;
pub use levels::{MeshLevel, UnfitLevel};

mod save_error;
pub use save_error::SaveError;

mod making;

mod plain;

mod ply;

mod stl;

mod obj;

mod bytes;

#[cfg(feature = "glb")]
mod glb_stream;

#[cfg(feature = "meshopt")]
mod glb_compress;

#[cfg(feature = "glb")]
mod glb_buffers;

#[cfg(feature = "glb")]
mod glb_numbers;

#[cfg(feature = "glb")]
mod glb_levels;

#[cfg(feature = "glb")]
mod glb;

mod format;
pub use format::{Format, SaveOptions, UnknownFormat};

mod save;
pub use save::{Saved, save, save_on, write, write_on};

#[cfg(feature = "glb")]
mod read_glb;

mod read_back;
pub use read_back::{ReadBack, read_back};

/// Pictures through wgpu.
#[cfg(feature = "wgpu")]
pub mod wgpu;
