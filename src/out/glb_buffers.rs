//! Numbers of a GLB to accessors, views and the bytes of its binary chunk, compressed if asked for.

#[cfg(feature = "meshopt")]
use super::glb_compress::compress;
use super::glb_options::GlbOptions;
use super::glb_stream::Stream;
use super::making::{Making, Pieces};
use super::save_error::SaveError;
use gltf_json::accessor::GenericComponentType;
use gltf_json::buffer::{Stride, Target, View};
use gltf_json::validation::Checked::Valid;
use gltf_json::validation::USize64;
use gltf_json::{Accessor, Buffer, Index, Root, extensions};
use std::collections::BTreeMap;
use std::io;

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
