//! The kinds of numbers in a GLB.

use gltf_json::accessor::{ComponentType, Type};
use gltf_json::buffer::Target;

/// Kinds of numbers, each in one view, in the order of the file. This order keeps every view aligned: those of two bytes
/// come last.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Stream {
    /// Positions and normals, three floats.
    Vectors,
    /// Positions, three integers and a gap.
    ShortVectors,
    /// Normals, three integers and a gap.
    ShortNormals,
    /// Ids, a float.
    Features,
    /// Ids, two bytes and a gap.
    ShortFeatures,
    /// Of instances, three floats.
    Translations,
    /// Of instances, four floats.
    Rotations,
    /// Of instances, three floats.
    Scales,
    LongIndices,
    LongLines,
    ShortIndices,
    ShortLines,
}

impl Stream {
    /// Component and type of its accessors, and bytes from one value to the next.
    pub(super) fn layout(self) -> (ComponentType, Type, usize) {
        match self {
            Self::Vectors | Self::Translations | Self::Scales => (ComponentType::F32, Type::Vec3, 12),
            Self::ShortVectors | Self::ShortNormals => (ComponentType::I16, Type::Vec3, 8),
            Self::Features => (ComponentType::F32, Type::Scalar, 4),
            Self::ShortFeatures => (ComponentType::U16, Type::Scalar, 4),
            Self::Rotations => (ComponentType::F32, Type::Vec4, 16),
            Self::LongIndices | Self::LongLines => (ComponentType::U32, Type::Scalar, 4),
            Self::ShortIndices | Self::ShortLines => (ComponentType::U16, Type::Scalar, 2),
        }
    }

    pub(super) fn target(self) -> Option<Target> {
        match self {
            Self::Translations | Self::Rotations | Self::Scales => None,
            Self::LongIndices | Self::LongLines | Self::ShortIndices | Self::ShortLines => {
                Some(Target::ElementArrayBuffer)
            }
            _ => Some(Target::ArrayBuffer),
        }
    }
}
