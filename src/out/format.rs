//! File extensions to formats, and formats to their writers.

#[cfg(feature = "glb")]
use super::glb::glb;
#[cfg(feature = "glb")]
use super::glb_options::GlbOptions;
use super::obj::obj;
use super::plain::{Pieces, rounding_of, to_double, to_single};
use super::ply::ply;
use super::rounding::Rounding;
use super::single::BeyondSingle;
use super::stl::stl;
use crate::control::Call;
use crate::mesh::FrameView;
use glam::DVec3;
use std::io;
use std::path::Path;

/// A mesh file format.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum Format {
    /// Binary glTF, see [`write_glb`](super::write_glb).
    #[cfg(feature = "glb")]
    Glb(GlbOptions),
    /// Binary STL, see [`write_stl`](super::write_stl).
    Stl,
    /// Stanford PLY, see [`write_ply`](super::write_ply).
    Ply,
    /// Wavefront OBJ, see [`write_obj`](super::write_obj).
    Obj,
}

impl Format {
    /// Every format with its file extension.
    pub const ALL: &'static [(&'static str, Self)] = &[
        #[cfg(feature = "glb")]
        ("glb", Self::Glb(GlbOptions::PLAIN)),
        ("stl", Self::Stl),
        ("ply", Self::Ply),
        ("obj", Self::Obj),
    ];

    /// Returns the format for the extension of `path`, ignoring case.
    ///
    /// # Errors
    /// If the extension is missing or unknown.
    pub fn of_path(path: &Path) -> Result<Self, UnknownFormat> {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let known = Self::ALL.iter().find(|(name, _)| *name == extension);
        known.map(|(_, format)| *format).ok_or(UnknownFormat { extension })
    }

    /// Makes the file, unless rounding moves a vertex by more than `most` millimetres.
    pub(super) fn make(self, call: Call<'_>, frame: &FrameView<'_>, most: f64) -> io::Result<(Pieces, Rounding)> {
        let (pieces, rounding) = match self {
            #[cfg(feature = "glb")]
            Self::Glb(options) => glb(call, frame, (options, most))?,
            Self::Stl => stl(call, frame)?,
            Self::Ply => ply(call, frame)?,
            Self::Obj => obj(call, frame)?,
        };
        rounding.within(most)?;
        Ok((pieces, rounding))
    }
}

impl Rounding {
    /// Measures what writing `frame` as `format` costs. `most` is the limit that the file is written with, infinite for
    /// no limit: nodes of a GLB depend on it.
    ///
    /// # Errors
    /// If a position overflows the format's single precision.
    pub fn of<'a>(frame: impl Into<FrameView<'a>>, format: Format, most: f64) -> Result<Self, BeyondSingle> {
        let frame = &frame.into();
        match format {
            #[cfg(feature = "glb")]
            Format::Glb(options) => Self::of_nodes(frame, (options, most)),
            Format::Stl => rounding_of(frame, to_single),
            Format::Ply | Format::Obj => {
                let _ = most;
                rounding_of(frame, to_double)
            }
        }
    }

    /// Whether `frame` would be written within `most` if its scene were moved by `by`.
    #[must_use]
    pub fn fits_moved<'a>(frame: impl Into<FrameView<'a>>, by: DVec3, format: Format, most: f64) -> bool {
        let frame = frame.into();
        let mut scene = frame.scene.clone();
        scene.translate(by);
        let moved = FrameView { scene: &scene, ..frame };
        Self::of(&moved, format, most).is_ok_and(|rounding| rounding.within(most).is_ok())
    }
}

/// A file name whose extension is missing or not that of a format that can be written.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{}; known are .{}", self.problem(), known().join(", ."))]
pub struct UnknownFormat {
    /// The extension in lower case, without its dot. Empty if missing.
    pub extension: String,
}

impl UnknownFormat {
    fn problem(&self) -> String {
        match self.extension.as_str() {
            "" => "the file name has no extension".to_owned(),
            extension => format!("cannot write .{extension} files"),
        }
    }
}

fn known() -> Vec<&'static str> {
    Format::ALL.iter().map(|(name, _)| *name).collect()
}
