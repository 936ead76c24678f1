//! Triangles of a frame against the exact normals of their faces: which of them look inwards? And faces against their
//! neighbours: which of them run along a common edge in the same direction?

use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use trimtess::mesh::{Batch, MemorySink};
use trimtess::model::{EdgeId, Model, PartId};
use trimtess::parallel::FaceFill;
use trimtess::prepare::{Prepared, PreparedFace};

/// How many triangles look to the other side than their face, and the largest of them; `None` if there are none. Not of faces
/// with `fills`: where loops wind backwards triangles are reversed, and those that only close look anywhere.
/// Nor of the faces that are `excused`.
pub(crate) fn flipped(
    prepared: &Prepared,
    sink: &MemorySink,
    fills: &[FaceFill],
    excused: &[(u32, u32)],
) -> Option<(usize, String)> {
    let mut count = 0;
    let mut worst = (0.0, String::new());
    let is_judged = |batch: &&Batch| !is_filled(batch, fills) && !excused.contains(&(batch.part.0, batch.face.0));
    for batch in sink.batches.iter().filter(is_judged) {
        let part = &prepared.parts[batch.part.index()];
        let Some(row) = part.face_rows[batch.face.index()] else { continue };
        for t in &batch.mesh.triangles {
            let Some((cosine, height)) = cosine(&part.faces[row as usize], batch, *t) else { continue };
            if cosine <= 0.0 {
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

/// Cosine between a triangle's normal and its face's at its middle, and its height; `None` for triangles that are lines but
/// for rounding and for the gap that the file leaves.
fn cosine(face: &PreparedFace, batch: &Batch, corners: [u32; 3]) -> Option<(f64, f64)> {
    let [a, b, c] = corners.map(|v| batch.mesh.positions[v as usize]);
    let normal = (b - a).cross(c - a);
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let size = [a, b, c].iter().fold(0.0_f64, |size, p| size.max(p.abs().max_element()));
    let height = normal.length() / longest;
    if height <= 1e-12 * size + 4.0 * face.gap {
        return None;
    }
    let at = |k: usize| batch.mesh.uvs[corners[k] as usize].as_dvec2();
    let middle = (at(0) + at(1) + at(2)) / 3.0;
    let uv = DVec2::new(face.maps[0].to_nurbs(middle.x), face.maps[1].to_nurbs(middle.y));
    let d = face.patches.derivatives(uv.x, uv.y);
    let outwards = d.du.cross(d.dv) * if face.reversed { -1.0 } else { 1.0 };
    Some((normal.normalize().dot(outwards.normalize_or_zero()), height))
}

/// The two ends of a segment, the lesser first.
type Segment = [[u64; 3]; 2];

fn segment(part: PartId, a: DVec3, b: DVec3) -> (bool, (PartId, Segment)) {
    let [a, b] = [a, b].map(|p| (p + DVec3::ZERO).to_array().map(f64::to_bits));
    (a < b, (part, [a.min(b), a.max(b)]))
}

/// Edges that two faces of one shell run along in the same direction, where no third face of the shell has them.
///
/// Segments that lie on several edges are left out: there faces of other shells, or edges that were never sewn, coincide. So are
/// faces with `fills`, of which a boundary segment may have several triangles.
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
