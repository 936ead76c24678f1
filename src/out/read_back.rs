//! A written file back to triangles, and whether they are those of the frame.
//!
//! Reads the layouts that this folder writes, not formats in general.

use super::file_triangles::{FileTriangle, bad, by_face, moved, obj, ply, stl, unbalanced};
#[cfg(feature = "glb")]
use super::format::GlbOptions;
#[cfg(feature = "glb")]
use super::node_place::PointNumbers;
use super::placed::{distinct, placed, single};
#[cfg(feature = "glb")]
use super::read_glb::{GlbFile, Numbers};
use super::{Format, SaveOptions};
use crate::mesh::{BatchView, FrameView};
use glam::{DVec3, Vec3};
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
