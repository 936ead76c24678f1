//! A frame to STL, PLY and OBJ: every instance in world coordinates, made in runs on all threads, and what rounding
//! costs.

use super::making::{Making, Pieces, SaveError, counted};
use super::placed::{BeyondSingle, cut, distinct, instance_name, placed, single};
use super::rounding::{Rounding, RoundingCount};
use crate::control::Call;
use crate::mesh::{BatchView, FrameView, Placement, Scene, SceneInstance};
use crate::model::FaceId;
use glam::{DAffine3, DVec3, Vec3};
use std::fmt::Write as _;

/// Batches of an instance that follow each other.
struct Run<'a> {
    call: Call<'a>,
    instance: &'a SceneInstance,
    placement: Placement,
    batches: &'a [&'a BatchView<'a>],
    /// The face of the batch before these, of the same instance.
    before: Option<FaceId>,
    /// Number of vertices in the file before these.
    first: u64,
}

impl Run<'_> {
    /// Rounds the positions of each batch by `round`, which also returns the distance, and passes them to `write` with
    /// the triangles whose corners stay apart, all of which it takes. Passes fewer, once cancelled.
    fn round<P: PartialEq>(
        &self,
        round: impl Fn(DVec3) -> Result<(P, f64), BeyondSingle>,
        mut write: impl FnMut(&BatchView<'_>, &[P], &mut dyn Iterator<Item = [u32; 3]>),
    ) -> Result<RoundingCount, BeyondSingle> {
        let arithmetic = Arithmetic::of(&self.instance.transform);
        let (mut count, mut rounded) = (RoundingCount::default(), Vec::new());
        for batch in self.batches {
            rounded.clear();
            for &point in self.call.while_wanted(batch.mesh.positions.iter()) {
                let (position, moved) = round(self.placement.position(point))?;
                count.point(point, moved + arithmetic.moved(point));
                rounded.push(position);
            }
            let mut kept = 0;
            let triangles = self.call.while_wanted(distinct(&batch.mesh, &rounded)).inspect(|_| kept += 1);
            write(batch, &rounded, &mut triangles.map(|corners| self.placement.winding(corners)));
            count.triangles(batch.face, batch.mesh.triangles.len(), kept);
        }
        Ok(count)
    }
}

/// Number of tiles that [`pieces`] makes the bytes of.
pub(super) fn tiles(frame: &FrameView<'_>) -> usize {
    let by_part = frame.batches_by_part();
    placed(frame, &by_part).map(|(_, _, batches)| batches.len()).sum()
}

/// Calls `piece` with each run, and returns its results in order, with what rounding costs: none once cancelled. An
/// instance without batches has a run without any: there are files that name it.
fn pieces<T: Default + Send>(
    making: &Making<'_>,
    frame: &FrameView<'_>,
    piece: impl Fn(&Run<'_>) -> Result<(T, RoundingCount), BeyondSingle> + Sync,
) -> Result<(Vec<T>, Rounding), BeyondSingle> {
    let by_part = frame.batches_by_part();
    let vertices = |batch: &&BatchView<'_>| batch.mesh.positions.len();
    let (mut runs, mut first) = (Vec::new(), 0);
    for (instance, placement, batches) in placed(frame, &by_part) {
        let mut before = None;
        for batches in cut(batches, vertices).chain(batches.is_empty().then_some(batches)) {
            runs.push(Run { call: making.call, instance, placement, batches, before, first });
            before = batches.last().map(|batch| batch.face);
            first += batches.iter().map(vertices).sum::<usize>() as u64;
        }
    }
    let made = making.call.each(1, &runs, |run| {
        if making.call.is_cancelled() {
            return Ok(Default::default());
        }
        let made = piece(run);
        making.made(run.batches.len());
        made
    });
    if making.call.is_cancelled() {
        making.call.discard(made);
        return Ok(Default::default());
    }
    let (mut pieces, mut rounding) = (Vec::with_capacity(runs.len()), Rounding::default());
    let mut count = RoundingCount::default();
    for (k, (run, made)) in runs.iter().zip(made).enumerate() {
        let (piece, of_run) = made?;
        pieces.push(piece);
        count.add(of_run);
        if runs.get(k + 1).is_none_or(|next| next.before.is_none()) {
            rounding.add_placed(run.instance, &std::mem::take(&mut count), &run.placement);
        }
    }
    Ok((pieces, rounding))
}

/// Rounds to single precision.
fn to_single(exact: DVec3) -> Result<(Vec3, f64), BeyondSingle> {
    let rounded = single(exact)?;
    Ok((rounded, (rounded.as_dvec3() - exact).length()))
}

/// Keeps double precision.
fn to_double(exact: DVec3) -> Result<(DVec3, f64), BeyondSingle> {
    Ok((exact, 0.0))
}

/// Bounds the error of transforming points in double precision.
struct Arithmetic {
    /// Error per length of a point, and of the translation.
    per_length: f64,
    translation: f64,
}

impl Arithmetic {
    fn of(transform: &DAffine3) -> Self {
        if *transform == DAffine3::IDENTITY {
            return Self { per_length: 0.0, translation: 0.0 };
        }
        // Three products and three sums, each rounded by half an epsilon.
        const ROUNDED: f64 = 4.0 * f64::EPSILON;
        let m = transform.matrix3;
        let norm = m.x_axis.length() + m.y_axis.length() + m.z_axis.length();
        Self { per_length: ROUNDED * norm, translation: ROUNDED * transform.translation.length() }
    }

    fn moved(&self, point: DVec3) -> f64 {
        self.per_length * point.length() + self.translation
    }
}

/// Bytes of a vertex.
const VERTEX: usize = 3 * 8 + 3 * 4;

pub(super) fn ply(making: &Making<'_>, frame: &FrameView<'_>) -> Result<(Pieces, Rounding), SaveError> {
    let (pieces, rounding) = pieces(making, frame, |run| {
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        // Too many vertices are refused below.
        let mut first = run.first as u32;
        let count = run.round(to_double, |batch, world, triangles| {
            for (index, point) in making.call.while_wanted(world.iter().enumerate()) {
                let normal = batch.mesh.normals.get(index).copied().unwrap_or_default();
                for coordinate in point.to_array() {
                    vertices.extend_from_slice(&coordinate.to_le_bytes());
                }
                for coordinate in run.placement.normal(normal).as_vec3().to_array() {
                    vertices.extend_from_slice(&coordinate.to_le_bytes());
                }
            }
            let face_id = run.instance.face_number(batch.face);
            for corners in triangles {
                faces.push(3);
                for corner in corners {
                    faces.extend_from_slice(&first.wrapping_add(corner).to_le_bytes());
                }
                faces.extend_from_slice(&face_id.to_le_bytes());
            }
            first = first.wrapping_add(world.len() as u32);
        })?;
        Ok(((vertices, faces), count))
    })?;
    let vertices = pieces.iter().map(|(vertices, _)| (vertices.len() / VERTEX) as u64).sum::<u64>();
    counted(vertices, "vertices")?;
    let head = format!(
        "ply\nformat binary_little_endian 1.0\ncomment millimetres\n\
         element vertex {vertices}\nproperty double x\nproperty double y\nproperty double z\n\
         property float nx\nproperty float ny\nproperty float nz\n\
         element face {}\nproperty list uchar uint vertex_indices\nproperty uint face_id\nend_header\n",
        rounding.triangles
    );
    let (vertices, faces): (Pieces, Pieces) = pieces.into_iter().unzip();
    Ok((std::iter::once(head.into_bytes()).chain(vertices).chain(faces).collect(), rounding))
}

pub(super) fn stl(making: &Making<'_>, frame: &FrameView<'_>) -> Result<(Pieces, Rounding), SaveError> {
    let (mut pieces, rounding) = pieces(making, frame, |run| {
        let mut bytes = Vec::new();
        let count = run.round(to_single, |_, world, triangles| {
            for corners in triangles {
                let [a, b, c] = corners.map(|corner| world[corner as usize]);
                let normal = (b - a).as_dvec3().cross((c - a).as_dvec3()).normalize_or_zero().as_vec3();
                for coordinate in [normal, a, b, c].iter().flat_map(Vec3::to_array) {
                    bytes.extend_from_slice(&coordinate.to_le_bytes());
                }
                bytes.extend_from_slice(&[0, 0]);
            }
        })?;
        Ok((bytes, count))
    })?;
    let count = counted(rounding.triangles, "triangles")?;
    // The header must not start with "solid": readers would take the file for text STL.
    let mut head = vec![b' '; 80];
    let title = b"binary STL, millimetres, written by trimtess";
    head[..title.len()].copy_from_slice(title);
    head.extend_from_slice(&count.to_le_bytes());
    pieces.insert(0, head);
    Ok((pieces, rounding))
}

pub(super) fn obj(making: &Making<'_>, frame: &FrameView<'_>) -> Result<(Pieces, Rounding), SaveError> {
    let (mut pieces, rounding) = pieces(making, frame, |run| {
        let mut text = String::new();
        if run.before.is_none() {
            line(&mut text, format_args!("o {}", object_name(frame.scene, run.instance)));
        }
        // Numbers begin with 1.
        let (mut face, mut first) = (run.before, run.first + 1);
        let count = run.round(to_double, |batch, world, triangles| {
            if face.replace(batch.face) != Some(batch.face) {
                let number = run.instance.face_number(batch.face);
                line(&mut text, format_args!("g face_{number}"));
            }
            for p in making.call.while_wanted(world.iter()) {
                line(&mut text, format_args!("v {:?} {:?} {:?}", p.x, p.y, p.z));
            }
            for index in making.call.while_wanted(0..world.len()) {
                let normal = batch.mesh.normals.get(index).copied().unwrap_or_default();
                let n = run.placement.normal(normal).as_vec3();
                line(&mut text, format_args!("vn {:?} {:?} {:?}", n.x, n.y, n.z));
            }
            for corners in triangles {
                let [a, b, c] = corners.map(|corner| first + u64::from(corner));
                line(&mut text, format_args!("f {a}//{a} {b}//{b} {c}//{c}"));
            }
            first += world.len() as u64;
        })?;
        Ok((text.into_bytes(), count))
    })?;
    let head = format!("# {}: millimetres, written by trimtess\n", word(&frame.scene.name));
    pieces.insert(0, head.into_bytes());
    Ok((pieces, rounding))
}

/// Formatting into a `String` cannot fail.
fn line(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    let _ = writeln!(text, "{arguments}");
}

fn object_name(scene: &Scene, instance: &SceneInstance) -> String {
    let part = scene.parts.get(instance.part.index()).map_or("", |part| part.name.as_str());
    match word(instance_name(part, instance)) {
        name if name.is_empty() => format!("part_{}", instance.part.0),
        name => name,
    }
}

/// Replaces white space and control characters by `_`, because names end at blanks in OBJ.
fn word(name: &str) -> String {
    name.chars().map(|c| if c.is_whitespace() || c.is_control() { '_' } else { c }).collect()
}
