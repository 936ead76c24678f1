//! How compact a GLB is.

/// What a GLB asks of its readers, so that it is smaller.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[non_exhaustive]
pub struct GlbOptions {
    /// Whether all instances of a part and colour are one node (EXT_mesh_gpu_instancing), which a picture draws at once.
    /// Mirrored instances have nodes of their own. Names of instances are in `extras`. There are no B-rep edges: readers do
    /// not draw lists of lines.
    pub instanced: bool,
    /// Whether positions are integers of 16 bits on a grid of each part, and normals of 16 bits (KHR_mesh_quantization).
    /// Equal positions stay equal, so parts stay closed. A part for which the grid is too coarse keeps single precision:
    /// where it takes more than half of what a vertex may move.
    pub quantized: bool,
    /// Whether buffers are compressed (EXT_meshopt_compression, feature `meshopt`). Lossless, but for normals that are
    /// quantized, too: they keep 12 bits.
    #[cfg(feature = "meshopt")]
    pub compressed: bool,
}

impl Default for GlbOptions {
    fn default() -> Self {
        Self::PLAIN
    }
}

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
    }

    /// Sets [`compressed`](Self::compressed).
    #[cfg(feature = "meshopt")]
    #[must_use]
    pub const fn with_compressed(self, compressed: bool) -> Self {
        Self { compressed, ..self }
    }

    pub(super) const fn is_compressed(self) -> bool {
        #[cfg(feature = "meshopt")]
        return self.compressed;
        #[cfg(not(feature = "meshopt"))]
        false
    }
}
