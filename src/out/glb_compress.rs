//! Streams of a GLB to the bytes of EXT_meshopt_compression, and back.

use super::bytes::bad;
use super::glb_stream::Stream;
use gltf_json::Value;
use meshopt::{
    decode_filter_oct, decode_index_buffer, decode_index_sequence, decode_vertex_buffer, encode_filter_oct,
    encode_index_buffer, encode_index_sequence, encode_vertex_buffer_level,
};
use std::io;

/// Bits of a compressed normal's octahedral coordinates: off by less than 0.04 degrees.
const NORMAL_BITS: i32 = 12;
/// The version of the vertex codec that the extension has. Its levels do not apply.
const VERSION: Option<i32> = Some(0);

/// Normals as the stream [`Stream::ShortNormals`] has them once it is compressed.
pub(super) fn filtered(normals: impl Iterator<Item = [f32; 3]>) -> Vec<[i16; 4]> {
    let normals: Vec<[f32; 4]> = normals.map(|[x, y, z]| [x, y, z, 0.0]).collect();
    encode_filter_oct(&normals, NORMAL_BITS)
}

/// Compresses a stream. Also returns the members of its view's extension that tell how.
pub(super) fn compress(stream: Stream, bytes: &[u8], stride: usize) -> io::Result<(Vec<u8>, String)> {
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

fn attributes(bytes: &[u8], stride: usize) -> meshopt::Result<Vec<u8>> {
    match stride {
        4 => encode_vertex_buffer_level(bytes.as_chunks::<4>().0, 2, VERSION),
        8 => encode_vertex_buffer_level(bytes.as_chunks::<8>().0, 2, VERSION),
        12 => encode_vertex_buffer_level(bytes.as_chunks::<12>().0, 2, VERSION),
        _ => encode_vertex_buffer_level(bytes.as_chunks::<16>().0, 2, VERSION),
    }
}

/// Decompresses what a view's extension describes.
pub(super) fn decompress(extension: &Value, data: &[u8]) -> io::Result<Vec<u8>> {
    let number = |name: &str| extension[name].as_u64().map_or(0, |number| number as usize);
    let (offset, length, stride, count) =
        (number("byteOffset"), number("byteLength"), number("byteStride"), number("count"));
    let encoded = offset.checked_add(length).and_then(|end| data.get(offset..end));
    let encoded = encoded.ok_or_else(|| bad("a GLB with a view beyond its data"))?;
    let decoded = match (extension["mode"].as_str(), stride) {
        (Some("TRIANGLES"), 2) => decode_index_buffer::<u16>(encoded, count).map(short),
        (Some("TRIANGLES"), _) => decode_index_buffer::<u32>(encoded, count).map(long),
        (Some("INDICES"), 2) => decode_index_sequence::<u16>(encoded, count).map(short),
        (Some("INDICES"), _) => decode_index_sequence::<u32>(encoded, count).map(long),
        (_, 4) => decode_vertex_buffer::<[u8; 4]>(encoded, count).map(|rows| rows.as_flattened().to_vec()),
        (_, 8) if extension["filter"] == "OCTAHEDRAL" => decode_vertex_buffer::<[i16; 4]>(encoded, count).map(normals),
        (_, 8) => decode_vertex_buffer::<[u8; 8]>(encoded, count).map(|rows| rows.as_flattened().to_vec()),
        (_, 12) => decode_vertex_buffer::<[u8; 12]>(encoded, count).map(|rows| rows.as_flattened().to_vec()),
        _ => decode_vertex_buffer::<[u8; 16]>(encoded, count).map(|rows| rows.as_flattened().to_vec()),
    };
    decoded.map_err(|_| bad("a GLB with a view that cannot be decompressed"))
}

fn short(words: Vec<u16>) -> Vec<u8> {
    words.into_iter().flat_map(u16::to_le_bytes).collect()
}

fn long(words: Vec<u32>) -> Vec<u8> {
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

fn normals(mut rows: Vec<[i16; 4]>) -> Vec<u8> {
    decode_filter_oct(&mut rows);
    rows.into_iter().flatten().flat_map(i16::to_le_bytes).collect()
}
