//! How vertices and indices lie in the memory of a graphics device.

use glam::{Vec2, Vec3};

/// Meshes of up to this many vertices use 16-bit indices. The largest 16-bit value is reserved for primitive restart.
pub(crate) const SHORT_VERTICES: usize = 65_535;

/// Attributes of a vertex and their formats. They follow each other in the order of the fields, little-endian; the next
/// vertex follows without a gap. The size of every attribute is a multiple of four bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct VertexLayout {
    /// Position.
    pub position: PositionFormat,
    /// Normal.
    pub normal: NormalFormat,
    /// Whether parameters follow: `[f32; 2]`, in the natural parametrisation of the face's surface.
    pub uv: bool,
    /// Whether a tangent follows: `[f32; 3]`, of unit length, in the direction in which u increases; zero where that
    /// has none, as in poles.
    pub tangent: bool,
    /// Whether the [origin](super::Origin) follows: `[u32; 3]`, see [`Origin::words`](super::Origin::words).
    pub origin: bool,
    /// Indices.
    pub index: IndexFormat,
}

/// Format of positions. Equal positions of a part get equal values in every tile, so borders stay closed. Narrow
/// triangles may lose their area to rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PositionFormat {
    /// `[f64; 3]`, part coordinates, millimetres.
    F64,
    /// `[f32; 3]`, relative to the part's [centre](super::ScenePart::centre), millimetres.
    F32,
    /// `[u16; 4]`, the last one 0: steps of the part's grid from the tile's corner, see [`TileGrid`](super::TileGrid).
    ///
    /// The grid is as fine as the part's largest tile allows. A frame whose tolerance is so strict that rounding would
    /// take more than a tenth of it is refused.
    Grid,
}

/// Format of normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum NormalFormat {
    /// None.
    None,
    /// `[f32; 3]`, of unit length.
    F32,
    /// `[i16; 2]`, normalised: octahedral coordinates (Meyer et al.), off by less than 0.01 degrees.
    Octahedral,
}

/// Format of vertex indices, three per triangle, counted from the tile's first vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum IndexFormat {
    /// `u32`.
    U32,
    /// `u16` in tiles of up to 65 535 vertices, else `u32`. The index 65 535 is never used with 16 bits: WebGL 2
    /// restarts primitives there.
    Smallest,
}

impl VertexLayout {
    /// 16 bytes: f32 positions and octahedral normals. Short indices where they fit.
    pub const COMPACT: Self = Self {
        position: PositionFormat::F32,
        normal: NormalFormat::Octahedral,
        uv: false,
        tangent: false,
        origin: false,
        index: IndexFormat::Smallest,
    };

    setters! {
        with_position(position: PositionFormat);
        with_normal(normal: NormalFormat);
        with_uv(uv: bool);
        with_tangent(tangent: bool);
        with_origin(origin: bool);
        with_index(index: IndexFormat);
    }

    /// Bytes from one vertex to the next.
    #[must_use]
    pub const fn stride(&self) -> usize {
        let position = match self.position {
            PositionFormat::F64 => 24,
            PositionFormat::F32 => 12,
            PositionFormat::Grid => 8,
        };
        let normal = match self.normal {
            NormalFormat::None => 0,
            NormalFormat::F32 => 12,
            NormalFormat::Octahedral => 4,
        };
        let uv = if self.uv { 8 } else { 0 };
        position + normal + uv + 12 * (self.tangent as usize + self.origin as usize)
    }

    /// Whether a tile of `vertices` vertices has indices of four bytes.
    #[must_use]
    pub const fn is_wide(&self, vertices: usize) -> bool {
        matches!(self.index, IndexFormat::U32) || vertices > SHORT_VERTICES
    }
}

/// Encodes a direction in four bytes, with an error below 0.01 degrees. Zero and NaN become +z.
#[inline(always)]
pub(crate) fn octahedral(normal: Vec3) -> [i16; 2] {
    let sum = normal.abs().element_sum();
    let unfolded = match sum > 0.0 && sum.is_finite() {
        false => Vec2::ZERO,
        true if normal.z >= 0.0 => normal.truncate() / sum,
        true => (Vec2::ONE - Vec2::new(normal.y, normal.x).abs() / sum) * normal.truncate().map(|x| 1_f32.copysign(x)),
    };
    unfolded.to_array().map(|x| (x * 32_767.0).round() as i16)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The inverse, as in shaders.
    fn unfold([x, y]: [i16; 2]) -> Vec3 {
        let (x, y) = (f32::from(x) / 32_767.0, f32::from(y) / 32_767.0);
        let z = 1.0 - x.abs() - y.abs();
        let below = (-z).max(0.0);
        Vec3::new(x - below.copysign(x), y - below.copysign(y), z).normalize()
    }

    #[test]
    fn normals_survive_four_bytes() {
        for k in 0..10_000_u32 {
            let turn = k as f32 * 2.399_963;
            let z = 1.0 - 2.0 * (k as f32 + 0.5) / 10_000.0;
            let normal = Vec3::new((1.0 - z * z).sqrt() * turn.cos(), (1.0 - z * z).sqrt() * turn.sin(), z);
            // Angles of that size are lost in the rounding of a cosine.
            assert!(unfold(octahedral(normal)).distance(normal) < 0.01_f32.to_radians(), "{normal}");
        }
        for axis in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
            assert_eq!(unfold(octahedral(axis)), axis);
        }
        assert_eq!(octahedral(Vec3::ZERO), octahedral(Vec3::Z));
        assert_eq!(octahedral(Vec3::NAN), octahedral(Vec3::Z));
    }

    #[test]
    fn strides_are_sums() {
        let full = VertexLayout::COMPACT.with_position(PositionFormat::F64).with_uv(true).with_origin(true);
        let full = full.with_normal(NormalFormat::F32).with_tangent(true);
        assert_eq!([VertexLayout::COMPACT.stride(), full.stride()], [16, 68]);
        let grid = VertexLayout::COMPACT.with_position(PositionFormat::Grid);
        assert_eq!([grid.stride(), grid.with_normal(NormalFormat::None).stride()], [12, 8]);
        assert!(!grid.is_wide(65_535) && grid.is_wide(65_536) && grid.with_index(IndexFormat::U32).is_wide(1));
    }
}
