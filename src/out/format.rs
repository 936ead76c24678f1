//! File extensions to formats, and how a file is written.

use std::path::Path;

/// What a GLB asks of its readers, so that it is smaller.
#[cfg(feature = "glb")]
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash, Debug)]
#[non_exhaustive]
pub struct GlbOptions {
    /// Whether all instances of a part and colour are one node (EXT_mesh_gpu_instancing), which a picture draws at
    /// once. Mirrored instances have nodes of their own. Names of instances are in `extras`. There are no B-rep edges:
    /// readers do not draw lists of lines.
    pub instanced: bool,
    /// Whether positions are integers of 16 bits on a grid of each part, and normals of 16 bits
    /// (KHR_mesh_quantization). Equal positions stay equal, so parts stay closed. A part for which the grid is too
    /// coarse keeps single precision: where it takes more than half of what a vertex may move.
    pub quantized: bool,
    /// Whether buffers are compressed (EXT_meshopt_compression, feature `meshopt`). Lossless, but for normals that are
    /// quantized, too: they keep 12 bits.
    #[cfg(feature = "meshopt")]
    pub compressed: bool,
}

#[cfg(feature = "glb")]
impl GlbOptions {
    /// A GLB that every reader takes.
    pub const PLAIN: Self = Self {
        instanced: false,
        quantized: false,
        #[cfg(feature = "meshopt")]
        compressed: false,
    };

    setters! {
        with_instanced(instanced: bool);
        with_quantized(quantized: bool);
        #[cfg(feature = "meshopt")]
        with_compressed(compressed: bool);
    }

    pub(super) const fn is_compressed(self) -> bool {
        #[cfg(feature = "meshopt")]
        return self.compressed;
        #[cfg(not(feature = "meshopt"))]
        false
    }
}

/// A mesh file format.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum Format {
    /// Binary glTF. Each part is stored once and placed by nodes; an instance with its own colour has its own mesh,
    /// which shares the part's data. Positions are single precision about the part's centre; parts far from the origin
    /// get nodes with offsets of their own if [`SaveOptions::max_rounding`] asks for it. Triangles whose rounded
    /// corners coincide are left out. Up to 4 GiB.
    #[cfg(feature = "glb")]
    Glb(GlbOptions),
    /// Binary STL: every instance, single precision, millimetres. Positions are rounded once, from world coordinates,
    /// so the file is closed wherever the mesh is. Triangles whose rounded corners coincide are left out. Up to 2³² - 1
    /// triangles.
    Stl,
    /// Stanford PLY: every instance, double precision, millimetres. Vertices are shared within a tile only. `face_id`
    /// numbers faces across all instances ([`SceneInstance::face_number`](crate::mesh::SceneInstance::face_number)). Up
    /// to 2³² - 1 vertices.
    Ply,
    /// Wavefront OBJ: every instance is an object `o`, every face a group `g`. Numbers are the shortest that parse to
    /// the same f64, so equal positions stay equal. No colours: the format keeps them in a second file.
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
}

/// How a mesh is written.
#[derive(Clone, Copy, PartialEq, Debug)]
#[non_exhaustive]
pub struct SaveOptions {
    /// The file format.
    pub format: Format,
    /// Maximum distance that rounding to the format's numbers may move a vertex, millimetres. Beyond it, nothing is
    /// written. Infinite: no limit.
    pub max_rounding: f64,
}

impl SaveOptions {
    /// No limit on rounding.
    #[must_use]
    pub const fn new(format: Format) -> Self {
        Self { format, max_rounding: f64::INFINITY }
    }

    setters! {
        with_format(format: Format);
        with_max_rounding(max_rounding: f64);
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
