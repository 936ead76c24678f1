//! Meshes to files and pictures: one [`FileSink`](crate::out::FileSink) for all formats, chosen by the file extension.
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

mod plain;

mod ply;
pub use ply::write_ply;

mod stl;
pub use stl::write_stl;

mod obj;
pub use obj::write_obj;

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
pub use glb_levels::{GlbLevel, UnfitLevel};

#[cfg(feature = "glb")]
mod glb;
#[cfg(feature = "glb")]
pub use glb::{write_glb, write_glb_within};

mod format;
pub use format::{Format, UnknownFormat};

#[cfg(feature = "glb")]
mod read_glb;

mod read_back;
#[cfg(feature = "glb")]
pub use read_back::read_back_levels;
pub use read_back::{ReadBack, read_back};

mod file_sink;
#[cfg(feature = "glb")]
pub use file_sink::save_levels;
pub use file_sink::{FileSink, open, save, save_pending, save_within};

/// Pictures through wgpu.
#[cfg(feature = "wgpu")]
pub mod wgpu;
