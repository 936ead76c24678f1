//! Triangles of written files: those of STL, PLY and OBJ, and how far they are from those that were written.

use glam::{DVec3, Vec3};
use std::collections::HashMap;
use std::io;

/// A triangle in a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct FileTriangle {
    /// The face's number across all instances; 0 in formats that do not store it.
    pub(super) face: u32,
    /// Millimetres, world coordinates, +Z up, counter-clockwise seen from outside.
    pub(super) corners: [DVec3; 3],
}

pub(super) fn bad(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, format!("the file reads back as {what}"))
}

/// The `N` bytes at `at`.
pub(super) fn bytes_at<const N: usize>(bytes: &[u8], at: usize) -> io::Result<[u8; N]> {
    let found = bytes.get(at..).and_then(|rest| rest.first_chunk::<N>());
    found.copied().ok_or_else(|| bad("shorter than its header says"))
}

/// Three single-precision numbers at `at`.
fn vector(bytes: &[u8], at: usize) -> io::Result<Vec3> {
    let number = |axis: usize| bytes_at(bytes, at + 4 * axis).map(f32::from_le_bytes);
    Ok(Vec3::new(number(0)?, number(1)?, number(2)?))
}

pub(super) fn stl(bytes: &[u8]) -> io::Result<Vec<FileTriangle>> {
    let count = u32::from_le_bytes(bytes_at(bytes, 80)?) as usize;
    if bytes.len() != 84 + 50 * count {
        return Err(bad("an STL of another length than its header says"));
    }
    let corner = |row: usize, corner: usize| vector(bytes, 84 + 50 * row + 12 * (corner + 1)).map(|p| p.as_dvec3());
    let triangle =
        |row: usize| Ok(FileTriangle { face: 0, corners: [corner(row, 0)?, corner(row, 1)?, corner(row, 2)?] });
    (0..count).map(triangle).collect()
}

pub(super) fn ply(bytes: &[u8]) -> io::Result<Vec<FileTriangle>> {
    const END: &[u8] = b"end_header\n";
    const VERTEX: usize = 3 * 8 + 3 * 4;
    const FACE: usize = 1 + 3 * 4 + 4;
    let head =
        bytes.windows(END.len()).position(|window| window == END).ok_or_else(|| bad("a PLY without a header"))?;
    let header = String::from_utf8_lossy(&bytes[..head]);
    let count = |element: &str| {
        let line = header.lines().find_map(|line| line.strip_prefix(element));
        line.and_then(|number| number.trim().parse::<usize>().ok()).ok_or_else(|| bad("a PLY without counts"))
    };
    let (vertices, faces) = (count("element vertex ")?, count("element face ")?);
    let start = head + END.len();
    if bytes.len() != start + VERTEX * vertices + FACE * faces {
        return Err(bad("a PLY of another length than its header says"));
    }
    let position = |index: u32| {
        let at = start + VERTEX * index as usize;
        let number = |axis: usize| bytes_at(bytes, at + 8 * axis).map(f64::from_le_bytes);
        if index as usize >= vertices {
            return Err(bad("a PLY with an index out of range"));
        }
        Ok(DVec3::new(number(0)?, number(1)?, number(2)?))
    };
    let triangle = |row: usize| {
        let at = start + VERTEX * vertices + FACE * row + 1;
        let word = |k: usize| bytes_at(bytes, at + 4 * k).map(u32::from_le_bytes);
        let corners = [position(word(0)?)?, position(word(1)?)?, position(word(2)?)?];
        Ok(FileTriangle { face: word(3)?, corners })
    };
    (0..faces).map(triangle).collect()
}

pub(super) fn obj(bytes: &[u8]) -> io::Result<Vec<FileTriangle>> {
    let text = std::str::from_utf8(bytes).map_err(|_| bad("an OBJ that is not UTF-8"))?;
    let (mut points, mut out, mut face) = (Vec::new(), Vec::new(), 0);
    let broken = || bad("an OBJ with a broken line");
    for line in text.lines() {
        if let Some(row) = line.strip_prefix("v ") {
            let numbers: Vec<f64> = row.split(' ').filter_map(|number| number.parse().ok()).collect();
            points.push(DVec3::from_array(numbers.try_into().map_err(|_| broken())?));
        } else if let Some(number) = line.strip_prefix("g face_") {
            face = number.parse().map_err(|_| broken())?;
        } else if let Some(row) = line.strip_prefix("f ") {
            let index = |corner: &str| corner.split('/').next().and_then(|index| index.parse::<usize>().ok());
            let point = |corner| points.get(index(corner)?.checked_sub(1)?).copied();
            let corners: Vec<DVec3> = row.split(' ').filter_map(point).collect();
            out.push(FileTriangle { face, corners: corners.try_into().map_err(|_| broken())? });
        }
    }
    Ok(out)
}

/// Largest distance between a corner and where it is expected. `expected` is sorted by face where formats store it.
pub(super) fn moved(mut found: Vec<FileTriangle>, expected: &[FileTriangle]) -> io::Result<f64> {
    if found.len() != expected.len() {
        return Err(bad(&format!("{} triangles, and not {}", found.len(), expected.len())));
    }
    found = by_face(found);
    // NaN must not pass as near.
    let worse = |most: f64, distance: f64| if distance.is_nan() { f64::INFINITY } else { most.max(distance) };
    let off = |(a, b): (&FileTriangle, &FileTriangle)| {
        // Compression may begin a triangle with another corner.
        let from = |first: usize| (0..3).map(|k| a.corners[(first + k) % 3].distance(b.corners[k])).fold(0.0, worse);
        (0..3).map(from).fold(f64::INFINITY, f64::min)
    };
    Ok(found.iter().zip(expected).map(off).fold(0.0, worse))
}

/// Sorts triangles as formats that store faces do.
pub(super) fn by_face(mut triangles: Vec<FileTriangle>) -> Vec<FileTriangle> {
    triangles.sort_by_key(|triangle| triangle.face);
    triangles
}

/// Number of edges whose directed uses do not cancel.
pub(super) fn unbalanced(triangles: &[FileTriangle]) -> u64 {
    let bits = |point: DVec3| point.to_array().map(f64::to_bits);
    let mut sums: HashMap<[[u64; 3]; 2], i64> = HashMap::new();
    for triangle in triangles {
        let [a, b, c] = triangle.corners.map(bits);
        // Corners that stay apart about their part's centre may coincide far from the origin. Skip such sides.
        for (from, to) in [(a, b), (b, c), (c, a)].into_iter().filter(|(from, to)| from != to) {
            let (key, use_of) = if from < to { ([from, to], 1) } else { ([to, from], -1) };
            *sums.entry(key).or_insert(0) += use_of;
        }
    }
    sums.values().filter(|&&sum| sum != 0).count() as u64
}
