//! File extensions to formats, and formats to their writers.

#[cfg(feature = "glb")]
use super::glb::Glb;
#[cfg(feature = "glb")]
use super::glb_options::GlbOptions;
use super::{write_obj, write_ply, write_stl};
#[cfg(feature = "glb")]
use crate::control::{Alone, Call, Control};
use crate::mesh::FrameView;
use std::fmt;
use std::io::{self, Write};
use std::path::Path;

/// A mesh file format.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Format {
    /// Binary glTF, see [`write_glb`](super::write_glb).
    #[cfg(feature = "glb")]
    Glb(GlbOptions),
    /// Binary STL, see [`write_stl`].
    Stl,
    /// Stanford PLY, see [`write_ply`].
    Ply,
    /// Wavefront OBJ, see [`write_obj`].
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

    /// Writes `frame` on the caller's thread.
    pub(super) fn write(self, frame: &FrameView<'_>, file: &mut impl Write) -> io::Result<()> {
        match self {
            #[cfg(feature = "glb")]
            Self::Glb(options) => {
                let control = Control::default();
                Glb::of(Call::new(&Alone, &control), frame, &[], (options, f64::INFINITY))?.0.write(file)
            }
            Self::Stl => write_stl(frame, file),
            Self::Ply => write_ply(frame, file),
            Self::Obj => write_obj(frame, file),
        }
    }
}

/// A file name whose extension is missing or not that of a format that can be written.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct UnknownFormat {
    /// The extension in lower case, without its dot. Empty if missing.
    pub extension: String,
}

impl fmt::Display for UnknownFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.extension.as_str() {
            "" => f.write_str("the file name has no extension")?,
            extension => write!(f, "cannot write .{extension} files")?,
        }
        f.write_str("; known are")?;
        for (index, (name, _)) in Format::ALL.iter().enumerate() {
            write!(f, "{} .{name}", if index == 0 { "" } else { "," })?;
        }
        Ok(())
    }
}

impl std::error::Error for UnknownFormat {}
