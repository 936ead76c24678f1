//! A mesh, or levels of detail, to bytes and files.

#[cfg(feature = "glb")]
use super::glb::{glb, tiles as glb_tiles};
use super::making::{Making, MeshLevel, Pieces, SaveError, UnfitLevel, checked};
#[cfg(feature = "glb")]
use super::node_place::NodePlace;
use super::pending::{Outputs, cannot_write};
use super::plain::{obj, ply, stl, tiles};
use super::rounding::Rounding;
use super::{Format, SaveOptions};
use crate::control::{Call, Control, Jobs, Rayon};
use crate::mesh::{FrameView, Scene, SceneInstance};
use glam::DVec3;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Writes a finished frame to `path` atomically, whatever rounding costs, and returns what it cost. Runs on [`Rayon`]'s
/// threads.
///
/// # Errors
/// As [`save_on`], but for limits and cancelling.
pub fn save<'a>(frame: impl Into<FrameView<'a>>, path: &Path, format: Format) -> Result<Rounding, SaveError> {
    save_on(&Rayon, frame, path, &SaveOptions::new(format), &Control::default())
}

/// Writes a finished frame to `path` atomically, on the threads of `jobs`, with progress and cancellation. Returns what
/// rounding to the format's numbers cost. The bytes do not depend on the number of threads. They are all in memory
/// before the file is created.
///
/// Each thread looks for a cancel after some thousand vertices or triangles, and a MiB that is written. Compressing a
/// stream of a GLB is not interrupted.
///
/// # Errors
/// If the file cannot be created, written or renamed, the format's numbers do not suffice, or when cancelled. An
/// existing file at `path` is then unchanged, and no other file is left. Devices and pipes are written in place.
pub fn save_on<'a>(
    jobs: &dyn Jobs,
    frame: impl Into<FrameView<'a>>,
    path: &Path,
    options: &SaveOptions,
    control: &Control,
) -> Result<Rounding, SaveError> {
    let mut outputs = Outputs::default();
    let Saved { mut roundings, .. } = outputs.save_on(jobs, &single(frame), path, options, control)?;
    outputs.publish()?;
    Ok(roundings.swap_remove(0))
}

/// Writes the bytes of a finished frame to `file`, whatever rounding costs, and returns what it cost. Runs on
/// [`Rayon`]'s threads.
///
/// # Errors
/// As [`write_on`], but for limits and cancelling.
pub fn write<'a>(
    frame: impl Into<FrameView<'a>>,
    file: &mut impl Write,
    format: Format,
) -> Result<Rounding, SaveError> {
    write_on(&Rayon, frame, file, &SaveOptions::new(format), &Control::default())
}

/// As [`save_on`], to anything that takes bytes. A call on this thread passes it at most a MiB at a time.
///
/// # Errors
/// If `file` refuses, the format's numbers do not suffice (nothing is written then), or when cancelled.
pub fn write_on<'a>(
    jobs: &dyn Jobs,
    frame: impl Into<FrameView<'a>>,
    file: &mut impl Write,
    options: &SaveOptions,
    control: &Control,
) -> Result<Rounding, SaveError> {
    let mut made = Made::of(Call::new(jobs, control), &single(frame), options)?;
    made.making.write(made.pieces, file)?;
    made.making.goes_on()?;
    Ok(made.roundings.swap_remove(0))
}

impl Rounding {
    /// Whether every frame of `scene` would be written within the limit on rounding if the scene were moved by `by`.
    /// Tells it from the spheres around the placed parts, so `false` may mean that an upper bound is too large.
    /// O(instances).
    #[must_use]
    pub fn fits_moved(scene: &Scene, by: DVec3, options: &SaveOptions) -> bool {
        let moved = |instance: &SceneInstance| -> Option<f64> {
            let part = scene.parts.get(instance.part.index())?;
            let mut transform = instance.transform;
            transform.translation += by;
            let (scale, single) = (instance.scale(), f64::from(f32::EPSILON));
            let (centre, radius) = (transform.transform_point3(part.centre), scale * part.radius);
            let numbers = transform.translation.length() + scale * part.centre.length() + radius;
            let rounded = match options.format {
                Format::Stl => single * (centre.length() + radius),
                Format::Ply | Format::Obj => 0.0,
                #[cfg(feature = "glb")]
                Format::Glb(glb) => {
                    let most = options.max_rounding;
                    let place = NodePlace::new(part, &SceneInstance { transform, ..instance.clone() }, (glb, most));
                    let points = if glb.quantized { (single * radius).max(0.5 * most) } else { single * radius };
                    points + place.map_or(f64::INFINITY, |place| place.moved)
                }
            };
            Some(rounded + 16.0 * f64::EPSILON * numbers)
        };
        scene.instances.iter().filter_map(moved).all(|moved| moved <= options.max_rounding)
    }
}

/// A file that was written and has a temporary name.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Saved {
    /// What rounding to the format's numbers costs in each level.
    pub roundings: Vec<Rounding>,
    /// Where the file is until its [`Outputs`] are published: next to its final place, or that place if it is a device
    /// or a pipe.
    pub temporary: PathBuf,
}

impl Outputs {
    /// Writes a mesh, or levels of detail of a GLB (MSFT_lod), finest first, to a file that appears when these outputs
    /// are published. Otherwise as [`super::save_on`].
    ///
    /// With levels, each node has coarser nodes, and the share of the screen below which each replaces it: that at
    /// which the chord tolerance of a level is a pixel on a screen of 1920 by 1080. Readers that do not know the
    /// extension draw the finest level. Where a part has no triangles in a level, it has those of the level before.
    ///
    /// # Errors
    /// As [`super::save_on`]; rounding is limited in each level. [`UnfitLevel`] if the levels are not of one
    /// scene, or the format has no levels. Earlier files of these outputs are not affected.
    pub fn save_on(
        &mut self,
        jobs: &dyn Jobs,
        levels: &[MeshLevel<'_>],
        path: &Path,
        options: &SaveOptions,
        control: &Control,
    ) -> Result<Saved, SaveError> {
        let Made { making, pieces, roundings } =
            Made::of(Call::new(jobs, control), levels, options).map_err(|failure| match failure {
                SaveError::Io(cause) => SaveError::File(cannot_write(path, cause)),
                other => other,
            })?;
        let temporary = self.write(path, |file| making.write(pieces, file))?;
        making.goes_on().inspect_err(|_| self.remove_last())?;
        Ok(Saved { roundings, temporary })
    }
}

/// A level whose tolerance decides nothing.
fn single<'a>(frame: impl Into<FrameView<'a>>) -> [MeshLevel<'a>; 1] {
    [MeshLevel { frame: frame.into(), chord: 0.0 }]
}

/// The bytes of a file.
struct Made<'a> {
    making: Making<'a>,
    pieces: Pieces,
    /// Of each level.
    roundings: Vec<Rounding>,
}

impl<'a> Made<'a> {
    fn of(call: Call<'a>, levels: &[MeshLevel<'_>], options: &SaveOptions) -> Result<Self, SaveError> {
        let levels = checked(levels)?;
        #[cfg(feature = "glb")]
        if let Format::Glb(glb_options) = options.format {
            let making = Making::start(call, glb_tiles(levels));
            let (pieces, roundings) = glb(&making, levels, (glb_options, options.max_rounding))?;
            return Ok(Self { making, pieces, roundings });
        }
        let [MeshLevel { frame, .. }] = levels else {
            return Err(UnfitLevel::Format { levels: levels.len() }.into());
        };
        let making = Making::start(call, tiles(frame));
        let (pieces, rounding) = match options.format {
            Format::Ply => ply(&making, frame)?,
            Format::Obj => obj(&making, frame)?,
            _ => stl(&making, frame)?,
        };
        making.goes_on()?;
        rounding.within(options.max_rounding)?;
        Ok(Self { making, pieces, roundings: vec![rounding] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{Alone, assert_each_cancels};
    use crate::mesh::{Batch, EdgeLine, MemorySink, ScenePart, TileMesh};
    use crate::model::{EdgeId, FaceId, PartId, TileId};
    use glam::{DAffine3, Vec3};

    /// A square with so many vertices along a side.
    fn square(part: u32, tile: u32, side: u32) -> Batch {
        let vertices = (0..side * side).map(|k| (k % side, k / side));
        let corner = |k: u32| k / (side - 1) * side + k % (side - 1);
        let cells = (0..(side - 1).pow(2)).map(corner);
        let triangles = cells.flat_map(|k| [[k, k + 1, k + side], [k + 1, k + side + 1, k + side]]).collect();
        let positions: Vec<DVec3> =
            vertices.map(|(x, y)| DVec3::new(f64::from(x), f64::from(y), 0.1 * f64::from(tile))).collect();
        let normals = vec![Vec3::Z; positions.len()];
        let mesh = TileMesh { positions, normals, triangles, ..TileMesh::default() };
        Batch { part: PartId(part), face: FaceId(tile), tile: TileId(tile), worker: 0, mesh }
    }

    /// Two parts, one placed twice. A tile has more vertices than those between two looks.
    fn frame(side: u32) -> MemorySink {
        let part = || ScenePart { face_colours: vec![None; 3], radius: 100.0, ..ScenePart::default() };
        let instances = [0, 1, 1].map(|part| SceneInstance::new(PartId(part), DAffine3::IDENTITY)).to_vec();
        let scene = Scene { name: String::new(), parts: vec![part(), part()], instances };
        let batches = vec![square(0, 0, side), square(0, 1, 2), square(1, 0, side), square(1, 1, 3), square(1, 2, 4)];
        let line = EdgeLine { part: PartId(1), edge: EdgeId(0), points: vec![DVec3::ZERO, DVec3::X, DVec3::Y] };
        MemorySink::of(scene, batches, vec![line])
    }

    #[test]
    fn what_fits_where_it_is_moved_is_written() {
        let frame = frame(70);
        let mut told = [0; 2];
        for (&(extension, format), k) in Format::ALL.iter().flat_map(|format| (-8..8).map(move |k| (format, k))) {
            // No coordinate is exact in single precision.
            for by in [0.0, 1e3, 1e6].map(|far| DVec3::splat(far + 1.0 / 3.0)) {
                let options = SaveOptions::new(format).with_max_rounding(libm::exp10(f64::from(k)));
                let fits = Rounding::fits_moved(&frame.scene, by, &options);
                let mut moved = frame.clone();
                moved.scene.translate(by);
                let written = write_on(&Alone, &moved, &mut Vec::new(), &options, &Control::default()).is_ok();
                assert!(written || !fits, "{extension} {k} {by}");
                told[usize::from(fits)] += 1;
                // The bound is not far from what is needed.
                let larger = options.with_max_rounding(100.0 * options.max_rounding);
                assert!(!written || Rounding::fits_moved(&frame.scene, by, &larger), "{extension} {k} {by}");
            }
        }
        // Both happen often enough.
        let formats = Format::ALL.len();
        assert!(told[0] > 5 * formats && told[1] > 25 * formats, "{told:?}");
    }

    #[test]
    fn files_are_cancelled_wherever_they_look() {
        let frames = [100, 10, 10].map(frame);
        let levels: Vec<_> =
            (1..).zip(&frames).map(|(k, frame)| MeshLevel { frame: frame.into(), chord: f64::from(k) }).collect();
        for &(extension, format) in Format::ALL {
            let levels = if extension == "glb" { &levels[..] } else { &levels[..1] };
            assert_each_cancels(extension, 1000, |control| {
                let made = Made::of(Call::new(&Alone, control), levels, &SaveOptions::new(format));
                let written = made.and_then(|made| {
                    made.making.write(made.pieces, &mut Vec::new())?;
                    made.making.goes_on()
                });
                matches!(written, Err(SaveError::Cancelled))
            });
        }
    }
}
