//! Triangles of a frame against the exact normals of their faces: which of them look inwards? And faces against their
//! neighbours: which of them traverse a common edge in the same direction?

use glam::DVec3;
use std::collections::BTreeMap;
use trimtess::mesh::{Batch, MemorySink, Origin};
use trimtess::model::{EdgeId, Model, PartId};
use trimtess::parallel::FaceFill;
use trimtess::prepare::Prepared;
use trimtess::prepare::internals::PreparedFace;

/// How many triangles look to the other side than their face, and the one of greatest height; `None` if there are none.
/// Skips faces with `fills`: where loops wind backwards triangles are reversed, and triangles that only close the
/// boundary look anywhere. Skips triangles that the boundary [forces](is_forced).
pub(crate) fn flipped(prepared: &Prepared, sink: &MemorySink, fills: &[FaceFill]) -> Option<(usize, String)> {
    let mut count = 0;
    let mut worst = (0.0, String::new());
    for batch in sink.batches.iter().filter(|batch| !is_filled(batch, fills)) {
        let part = &prepared.parts[batch.part.index()];
        let Some(row) = part.face_rows[batch.face.index()] else { continue };
        for t in &batch.mesh.triangles {
            let face = &part.faces[row as usize];
            let Some((cosine, height)) = cosine(face, batch, *t) else { continue };
            if cosine <= 0.0 && !is_forced(face, batch, *t) {
                count += 1;
                if height > worst.0 {
                    let at = t.map(|v| (batch.mesh.positions[v as usize], batch.mesh.origins[v as usize]));
                    let whose = format!("part {} face {}", batch.part.0, batch.face.0);
                    worst = (height, format!("{whose}: {at:?}, height {height:.2e}, cosine {cosine:.2e}"));
                }
            }
        }
    }
    (count > 0).then_some((count, worst.1))
}

fn is_filled(batch: &Batch, fills: &[FaceFill]) -> bool {
    fills.binary_search_by_key(&(batch.part, batch.face), |fill| (fill.part, fill.face)).is_ok()
}

/// Cosine between a triangle's normal and its face's normal at its middle, and the triangle's height. `None` if the
/// triangle is a line up to rounding and the gap that the file leaves.
fn cosine(face: &PreparedFace, batch: &Batch, corners: [u32; 3]) -> Option<(f64, f64)> {
    let [a, b, c] = corners.map(|v| batch.mesh.positions[v as usize]);
    let normal = (b - a).cross(c - a);
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let size = [a, b, c].iter().fold(0.0_f64, |size, p| size.max(p.abs().max_element()));
    let height = normal.length() / longest;
    if height <= 1e-12 * size + 4.0 * face.gap {
        return None;
    }
    Some((normal.normalize().dot(outwards(face, batch, corners)), height))
}

/// The face's normal in the middle of a triangle.
fn outwards(face: &PreparedFace, batch: &Batch, corners: [u32; 3]) -> DVec3 {
    let at = |k: usize| batch.mesh.uvs[corners[k] as usize].as_dvec2();
    let uv = face.to_patches((at(0) + at(1) + at(2)) / 3.0);
    let d = face.patches.derivatives(uv.x, uv.y);
    (d.du.cross(d.dv) * if face.reversed { -1.0 } else { 1.0 }).normalize_or_zero()
}

/// Whether every triangulation of this boundary looks inwards there. This is so if all corners lie on the boundary and
/// it winds negatively around a point of the triangle, seen along the surface normal: chords of two of its edges cross
/// there.
///
/// The winding number of a point is the number of the tile's triangles that cover it, reversed ones negative. It is the
/// same for all triangulations of the boundary. Where it is not negative the mesh is folded without need.
fn is_forced(face: &PreparedFace, batch: &Batch, corners: [u32; 3]) -> bool {
    /// Sample points along each side.
    const POINTS: u32 = 32;
    let on_boundary = |v: u32| matches!(batch.mesh.origins[v as usize], Origin::Edge { .. } | Origin::Border { .. });
    if !corners.into_iter().all(on_boundary) {
        return false;
    }
    let place = |t: [u32; 3]| t.map(|v| batch.mesh.positions[v as usize]);
    let ([a, b, c], view) = (place(corners), outwards(face, batch, corners));
    // A sheet that turns by 30° within a triangle is a fifteenth of the triangle's length off it. Triangles further
    // away are another turn of a thread.
    let near = 0.25 * a.distance(b).max(b.distance(c)).max(c.distance(a));
    let covers = |&t: &[u32; 3], p: DVec3| {
        let [a, b, c] = place(t);
        let sides = [(a, b), (b, c), (c, a)].map(|(a, b)| (a - p).cross(b - p).dot(view));
        let normal = (b - a).cross(c - a);
        let covers = sides.iter().all(|side| *side > 0.0) || sides.iter().all(|side| *side < 0.0);
        let off = (a - p).dot(normal) / view.dot(normal);
        if covers && off.abs() <= near { sides[0].signum() as i32 } else { 0 }
    };
    let share = |k: u32| (f64::from(k) + 0.5) / f64::from(POINTS);
    let mut points = (0..POINTS).flat_map(|i| (0..POINTS).map(move |j| (share(i), share(j))));
    points.any(|(s, t)| {
        let p = a + s * (b + t * (c - b) - a);
        batch.mesh.triangles.iter().map(|other| covers(other, p)).sum::<i32>() < 0
    })
}

/// The two ends of a segment, the smaller first.
type Segment = [[u64; 3]; 2];

fn segment(part: PartId, a: DVec3, b: DVec3) -> (bool, (PartId, Segment)) {
    let [a, b] = [a, b].map(|p| (p + DVec3::ZERO).to_array().map(f64::to_bits));
    (a < b, (part, [a.min(b), a.max(b)]))
}

/// Edges that two faces of one shell traverse in the same direction, and that no third face of the shell uses.
///
/// Skips segments on several edges: there faces of other shells, or unsewn edges, coincide. Skips faces with `fills`:
/// several of their triangles may use one boundary segment.
pub(crate) fn disagreeing(model: &Model, sink: &MemorySink, fills: &[FaceFill]) -> Vec<(PartId, EdgeId)> {
    let mut edges: BTreeMap<_, Option<EdgeId>> = BTreeMap::new();
    for line in &sink.edge_lines {
        for w in line.points.windows(2) {
            let owner = edges.entry(segment(line.part, w[0], w[1]).1).or_insert(Some(line.edge));
            *owner = owner.filter(|edge| *edge == line.edge);
        }
    }
    let mut uses: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for batch in sink.batches.iter().filter(|batch| !is_filled(batch, fills)) {
        let shell = model.parts[batch.part.index()].faces[batch.face.index()].shell;
        for t in &batch.mesh.triangles {
            for k in 0..3 {
                let [a, b] = [t[k], t[(k + 1) % 3]].map(|v| batch.mesh.positions[v as usize]);
                let (forward, key) = segment(batch.part, a, b);
                if let Some(Some(edge)) = edges.get(&key) {
                    uses.entry((key, shell, *edge)).or_default().push((batch.face, forward));
                }
            }
        }
    }
    let mut out: Vec<_> = uses
        .into_iter()
        .filter(|(_, uses)| matches!(uses[..], [(f, a), (g, b)] if f != g && a == b))
        .map(|(((part, _), _, edge), _)| (part, edge))
        .collect();
    out.dedup();
    out
}
