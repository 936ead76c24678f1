//! A written file back to triangles, and whether they are those of the frame.
//!
//! Reads the layouts that this folder writes, not formats in general.

use super::bytes::{FileTriangle, bad, bytes_at, vector};
#[cfg(feature = "glb")]
use super::glb_options::GlbOptions;
#[cfg(feature = "glb")]
use super::node_place::PointNumbers;
use super::placed::{distinct, placed};
#[cfg(feature = "glb")]
use super::read_glb::{GlbFile, Numbers};
use super::single::single;
use super::{Format, SaveOptions};
use crate::mesh::{BatchView, FrameView};
use glam::{DVec3, Vec3};
use std::collections::HashMap;
use std::io;
use std::path::Path;

/// What a written file holds, compared with the frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadBack {
    /// Triangles in the file.
    pub triangles: u64,
    /// Largest distance between a corner in the file and in the frame, millimetres.
    pub moved: f64,
    /// Edges whose directed uses do not cancel, over the positions in the file compared bit by bit.
    pub unbalanced_edges: u64,
}

/// Reads a file that [`save_on`](super::save_on) wrote for one frame, or [`Outputs::save_on`](super::Outputs::save_on)
/// for levels of detail, with these options, and compares each level.
///
/// # Errors
/// If the file cannot be read or does not have the layout, has fewer levels, or has another number of triangles than a
/// level has after rounding.
pub fn read_back(levels: &[FrameView<'_>], path: &Path, options: &SaveOptions) -> io::Result<Vec<ReadBack>> {
    let bytes = std::fs::read(path)?;
    let found = match options.format {
        #[cfg(feature = "glb")]
        Format::Glb(glb) => return compare_levels(levels, &GlbFile::open(&bytes)?, (glb, options.max_rounding)),
        Format::Stl => stl(&bytes)?,
        Format::Ply => ply(&bytes)?,
        Format::Obj => obj(&bytes)?,
    };
    let [frame] = levels else {
        return Err(bad(&format!("one level of detail, and not {}", levels.len())));
    };
    let expected = match options.format {
        Format::Stl => expected(frame, |batch, world| {
            let rounded: Vec<Vec3> = world.iter().map(|&point| single(point)).collect::<Result<_, _>>()?;
            Ok(distinct(&batch.mesh, &rounded).collect())
        })?,
        _ => by_face(expected(frame, |batch, world| Ok(distinct(&batch.mesh, world).collect()))?),
    };
    Ok(vec![compare(found, &expected)?])
}

#[cfg(feature = "glb")]
fn compare_levels(levels: &[FrameView<'_>], file: &GlbFile<'_>, with: (GlbOptions, f64)) -> io::Result<Vec<ReadBack>> {
    let (mut read, mut before) = (Vec::with_capacity(levels.len()), None);
    for (k, frame) in levels.iter().enumerate() {
        let mut written = WrittenLevel::of(frame, with);
        if let Some(before) = &before {
            written.fill(before)?;
        }
        read.push(compare_level(&written, file, k, with)?);
        before = Some(written);
    }
    Ok(read)
}

/// A level as a GLB holds it.
#[cfg(feature = "glb")]
struct WrittenLevel<'a> {
    frame: FrameView<'a>,
    numbers: Vec<PointNumbers>,
}

#[cfg(feature = "glb")]
impl<'a> WrittenLevel<'a> {
    fn of(frame: &FrameView<'a>, (options, most): (GlbOptions, f64)) -> Self {
        Self { numbers: PointNumbers::of(frame, options, most), frame: frame.clone() }
    }

    /// Gives parts that have no triangles after rounding those of the level before.
    fn fill(&mut self, before: &Self) -> io::Result<()> {
        let mut batches = Vec::with_capacity(self.frame.batches.len());
        let parts = self.frame.batches_by_part().into_iter().zip(before.frame.batches_by_part());
        for ((own, finer), (numbers, of_finer)) in parts.zip(self.numbers.iter_mut().zip(&before.numbers)) {
            let mut is_empty = true;
            for batch in &own {
                is_empty = is_empty && kept(&self.frame, *numbers, batch)?.is_empty();
            }
            if is_empty {
                *numbers = *of_finer;
            }
            batches.extend(if is_empty { finer } else { own }.into_iter().copied());
        }
        self.frame.batches = batches;
        Ok(())
    }
}

/// A batch's triangles whose corners stay apart in a GLB.
#[cfg(feature = "glb")]
fn kept(frame: &FrameView<'_>, numbers: PointNumbers, batch: &BatchView<'_>) -> io::Result<Vec<[u32; 3]>> {
    let part = &frame.scene.parts[batch.part.index()];
    let rounded = batch.mesh.positions.iter().map(|&point| numbers.local(part, point));
    let rounded: Vec<Vec3> = rounded.collect::<Result<_, _>>()?;
    Ok(distinct(&batch.mesh, &rounded).collect())
}

/// Compares a level of a GLB with its frame, as readers in single and in double precision take it.
#[cfg(feature = "glb")]
fn compare_level(
    WrittenLevel { frame, numbers }: &WrittenLevel<'_>,
    file: &GlbFile<'_>,
    level: usize,
    with: (GlbOptions, f64),
) -> io::Result<ReadBack> {
    let found = |numbers| file.triangles(frame, (level, numbers), with);
    // Colours change the order of faces. Within a face, order is kept.
    let expected = by_face(expected(frame, |batch, _| kept(frame, numbers[batch.part.index()], batch))?);
    let single = compare(found(Numbers::Single)?, &expected)?;
    let moved = single.moved.max(moved(found(Numbers::Double)?, &expected)?);
    Ok(ReadBack { moved, ..single })
}

fn compare(found: Vec<FileTriangle>, expected: &[FileTriangle]) -> io::Result<ReadBack> {
    let unbalanced_edges = unbalanced(&found);
    let moved = moved(found, expected)?;
    Ok(ReadBack { triangles: expected.len() as u64, moved, unbalanced_edges })
}

/// Largest distance between a corner and where it is expected. `expected` is sorted by face where formats store it.
fn moved(mut found: Vec<FileTriangle>, expected: &[FileTriangle]) -> io::Result<f64> {
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

/// The frame's triangles in the order of writing, with unrounded corners. `kept` returns those of a batch whose corners
/// stay apart after rounding, given its placed points.
fn expected(
    frame: &FrameView<'_>,
    kept: impl Fn(&BatchView<'_>, &[DVec3]) -> io::Result<Vec<[u32; 3]>>,
) -> io::Result<Vec<FileTriangle>> {
    let by_part = frame.batches_by_part();
    let mut out = Vec::new();
    for (instance, placement, batches) in placed(frame, &by_part) {
        for batch in batches {
            let world: Vec<DVec3> = batch.mesh.positions.iter().map(|&point| placement.position(point)).collect();
            let face = instance.face_number(batch.face);
            let triangle = |corners: [u32; 3]| {
                let corners = placement.winding(corners).map(|corner| world[corner as usize]);
                FileTriangle { face, corners }
            };
            out.extend(kept(batch, &world)?.into_iter().map(triangle));
        }
    }
    Ok(out)
}

/// Sorts triangles as formats that store faces do.
fn by_face(mut triangles: Vec<FileTriangle>) -> Vec<FileTriangle> {
    triangles.sort_by_key(|triangle| triangle.face);
    triangles
}

/// Number of edges whose directed uses do not cancel.
fn unbalanced(triangles: &[FileTriangle]) -> u64 {
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

fn stl(bytes: &[u8]) -> io::Result<Vec<FileTriangle>> {
    let count = u32::from_le_bytes(bytes_at(bytes, 80)?) as usize;
    if bytes.len() != 84 + 50 * count {
        return Err(bad("an STL of another length than its header says"));
    }
    let corner = |row: usize, corner: usize| vector(bytes, 84 + 50 * row + 12 * (corner + 1)).map(|p| p.as_dvec3());
    let triangle =
        |row: usize| Ok(FileTriangle { face: 0, corners: [corner(row, 0)?, corner(row, 1)?, corner(row, 2)?] });
    (0..count).map(triangle).collect()
}

fn ply(bytes: &[u8]) -> io::Result<Vec<FileTriangle>> {
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

fn obj(bytes: &[u8]) -> io::Result<Vec<FileTriangle>> {
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
