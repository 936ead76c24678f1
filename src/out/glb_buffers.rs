//! Numbers to the buffers, views and accessors of a GLB: one view per kind of numbers, compressed if asked for
//! (EXT_meshopt_compression).

use super::format::GlbOptions;
use super::making::{Making, Pieces, SaveError};
use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Stride, Target, View};
use gltf_json::validation::Checked::Valid;
use gltf_json::validation::USize64;
use gltf_json::{Accessor, Buffer, Index, Root, extensions};
#[cfg(feature = "meshopt")]
use meshopt::{encode_filter_oct, encode_index_buffer, encode_index_sequence, encode_vertex_buffer_level};
use std::collections::BTreeMap;
use std::io;

/// Kinds of numbers, each in one view, in the order of the file. This order keeps every view aligned: those of two
/// bytes come last.
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

/// Bits of a compressed normal's octahedral coordinates: off by less than 0.04 degrees.
#[cfg(feature = "meshopt")]
const NORMAL_BITS: i32 = 12;
/// The version of the vertex codec that the extension has. Its levels do not apply.
#[cfg(feature = "meshopt")]
const VERSION: Option<i32> = Some(0);

/// Normals as the stream [`Stream::ShortNormals`] has them once it is compressed.
#[cfg(feature = "meshopt")]
pub(super) fn filtered(normals: impl Iterator<Item = [f32; 3]>) -> Vec<[i16; 4]> {
    let normals: Vec<[f32; 4]> = normals.map(|[x, y, z]| [x, y, z, 0.0]).collect();
    encode_filter_oct(&normals, NORMAL_BITS)
}

/// Compresses a stream. Also returns the members of its view's extension that tell how.
#[cfg(feature = "meshopt")]
fn compress(stream: Stream, bytes: &[u8], stride: usize) -> io::Result<(Vec<u8>, String)> {
    let words: Vec<u32> = match stride {
        2 => bytes.chunks_exact(2).map(|b| u32::from(u16::from_le_bytes([b[0], b[1]]))).collect(),
        _ => bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect(),
    };
    let vertices = || words.iter().max().map_or(0, |last| *last as usize + 1);
    let (encoded, mode) = match stream {
        Stream::LongIndices | Stream::ShortIndices => (encode_index_buffer(&words, vertices()), "TRIANGLES"),
        Stream::LongLines | Stream::ShortLines => (encode_index_sequence(&words, vertices()), "INDICES"),
        _ => (attributes(bytes, stride), "ATTRIBUTES"),
    };
    let filter = if stream == Stream::ShortNormals { r#","filter":"OCTAHEDRAL""# } else { "" };
    let count = bytes.len() / stride;
    let how = format!(r#""byteStride":{stride},"count":{count},"mode":"{mode}"{filter}"#);
    Ok((encoded.map_err(io::Error::other)?, how))
}

#[cfg(feature = "meshopt")]
fn attributes(bytes: &[u8], stride: usize) -> meshopt::Result<Vec<u8>> {
    match stride {
        4 => encode_vertex_buffer_level(bytes.as_chunks::<4>().0, 2, VERSION),
        8 => encode_vertex_buffer_level(bytes.as_chunks::<8>().0, 2, VERSION),
        12 => encode_vertex_buffer_level(bytes.as_chunks::<12>().0, 2, VERSION),
        _ => encode_vertex_buffer_level(bytes.as_chunks::<16>().0, 2, VERSION),
    }
}

#[derive(Default)]
struct Pool {
    pieces: Vec<Vec<u8>>,
    length: usize,
    accessors: Vec<Index<Accessor>>,
}

/// The numbers of a GLB.
#[derive(Default)]
pub(super) struct Buffers {
    streams: BTreeMap<Stream, Pool>,
}

impl Buffers {
    /// Appends `count` values, whose bytes are in pieces. Returns their accessor; [`finish`](Self::finish) sets its
    /// view.
    pub(super) fn push(
        &mut self,
        root: &mut Root,
        stream: Stream,
        count: usize,
        pieces: Vec<Vec<u8>>,
    ) -> Index<Accessor> {
        let pool = self.streams.entry(stream).or_default();
        let offset = pool.length;
        pool.length += pieces.iter().map(Vec::len).sum::<usize>();
        pool.pieces.extend(pieces);
        let (component, kind, _) = stream.layout();
        let accessor = root.push(Accessor {
            buffer_view: None,
            byte_offset: Some(USize64(offset as u64)),
            count: USize64(count as u64),
            component_type: Valid(GenericComponentType(component)),
            extensions: None,
            extras: None,
            type_: Valid(kind),
            min: None,
            max: None,
            name: None,
            normalized: stream == Stream::ShortNormals,
            sparse: None,
        });
        pool.accessors.push(accessor);
        accessor
    }

    /// Adds views and buffers. Returns the pieces of the binary chunk.
    pub(super) fn finish(self, making: &Making<'_>, root: &mut Root, options: GlbOptions) -> Result<Pieces, SaveError> {
        let mut stored = Vec::new();
        let mut ends = Ends::default();
        for (stream, Pool { mut pieces, mut length, accessors }) in self.streams {
            making.goes_on()?;
            let (stride, target) = (stream.layout().2, stream.target());
            let is_attribute = matches!(target, Some(Target::ArrayBuffer));
            let mut view = View {
                buffer: Index::new(0),
                byte_length: USize64(length as u64),
                byte_offset: Some(USize64(ends.stored)),
                byte_stride: is_attribute.then_some(Stride(stride)),
                name: None,
                target: target.map(Valid),
                extensions: None,
                extras: None,
            };
            if options.is_compressed() {
                let whole = std::mem::take(&mut pieces).concat();
                let compressed = ends.compress(stream, &whole, &mut view)?;
                length = compressed.len();
                pieces = vec![compressed];
            }
            let view = root.push(view);
            for accessor in accessors {
                root.accessors[accessor.value()].buffer_view = Some(view);
            }
            ends.stored += length as u64;
            stored.append(&mut pieces);
        }
        let mut buffer = |length: u64, extensions: Option<extensions::buffer::Buffer>| {
            root.push(Buffer { byte_length: USize64(length), name: None, uri: None, extensions, extras: None });
        };
        if ends.stored > 0 {
            buffer(ends.stored, None);
        }
        if ends.decompressed > 0 {
            // Holds nothing: it gives views their places.
            let fallback = r#"{"EXT_meshopt_compression":{"fallback":true}}"#;
            buffer(ends.decompressed, Some(gltf_json::deserialize::from_str(fallback).map_err(io::Error::from)?));
        }
        Ok(stored)
    }
}

/// Ends of the streams so far, bytes.
#[derive(Default)]
struct Ends {
    /// In the file.
    stored: u64,
    /// In what readers decompress to.
    decompressed: u64,
}

impl Ends {
    /// Compresses a stream, and tells its view.
    #[cfg(feature = "meshopt")]
    fn compress(&mut self, stream: Stream, bytes: &[u8], view: &mut View) -> io::Result<Vec<u8>> {
        let (compressed, how) = compress(stream, bytes, stream.layout().2)?;
        view.buffer = Index::new(1);
        view.byte_offset = Some(USize64(self.decompressed));
        let place = format!(r#""buffer":0,"byteOffset":{},"byteLength":{}"#, self.stored, compressed.len());
        let extension = format!(r#"{{"EXT_meshopt_compression":{{{place},{how}}}}}"#);
        view.extensions = Some(gltf_json::deserialize::from_str(&extension)?);
        self.decompressed = (self.decompressed + bytes.len() as u64).next_multiple_of(4);
        Ok(compressed)
    }

    #[cfg(not(feature = "meshopt"))]
    fn compress(&mut self, _: Stream, bytes: &[u8], _: &mut View) -> io::Result<Vec<u8>> {
        Ok(bytes.to_vec())
    }
}
