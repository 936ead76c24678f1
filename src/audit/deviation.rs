//! Triangles -> distances to the exact surfaces of their faces, by dense sampling and foot points.

use super::edges;
use super::foot::{parameter_box, search_surface, walk_surface};
use super::report::{DeviationReport, EdgePlace, Place, Tally};
use crate::mesh::{BatchView, FrameView, Origin, TileView};
use crate::model::{FaceId, PartId, SurfaceKind};
use crate::prepare::Prepared;
use crate::prepare::internals::{BezierPatches, PreparedFace};
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;

/// Target number of samples. Small meshes get more per triangle, to find faces that were taken for flat by mistake.
const SAMPLES: f64 = 2e6;
/// Maximum number of measured triangles. Of larger meshes, every k-th is measured.
const MOST_TRIANGLES: u64 = 4_000_000;
/// Steps of the barycentric lattices of samples, finest last. Even numbers include the midpoints of edges, where a
/// triangle is farthest from a cylinder or a sphere.
const STEPS: [u32; 5] = [2, 4, 6, 8, 10];
/// Fraction of the tolerance below which a distance is not improved.
const ENOUGH: f64 = 1e-4;
/// Maximum number of searches. Enough to show that a mesh is wrong everywhere.
const SEARCHES: u32 = 50_000;

/// Measures the triangles and edge polylines of `mesh`, which was made from `prepared`. Batches and edges that are not
/// in `prepared` are skipped, and tiles without parameters or origins, or with indices beyond their vertices.
///
/// Each triangle is sampled at 4 to 64 points, more in larger triangles and smaller meshes: midpoints of edges and
/// inner points, never corners. A sample's distance is that to its foot point on the untrimmed surface within the
/// face's parameter box, found by Newton's method from the interpolated parameters, and by a search around the triangle
/// if that result is over the tolerance. Both yield points of the surface, so distances are never too small.
///
/// `chord` is in millimetres of the placed model. A scaled part is measured in its own coordinates against `chord`
/// divided by its largest scale.
///
/// Cost: about 1 s per two million samples; O(faces) memory.
#[must_use]
pub fn deviation<'a>(prepared: &Prepared, mesh: impl Into<FrameView<'a>>, chord: f64) -> DeviationReport {
    let mesh = mesh.into();
    let triangles = mesh.batches.iter().map(|b| b.mesh.triangles.len() as u64).sum();
    measure(prepared, &mesh.measurable(), triangles, chord)
}

/// `triangles`: how many the whole mesh has, with the tiles that were left out.
fn measure(prepared: &Prepared, mesh: &FrameView<'_>, triangles: u64, chord: f64) -> DeviationReport {
    let size: f64 = mesh.batches.iter().map(|b| squared_sizes(&b.mesh).sum::<f64>()).sum();
    let patterns = STEPS.map(pattern);
    let chords: Vec<f64> = prepared.scene.largest_scales().iter().map(|scale| chord / scale).collect();
    let mut audit = Audit {
        asked: chord,
        chord,
        mean_size: size / triangles.max(1) as f64,
        share: (SAMPLES / triangles.max(1) as f64).max(4.0),
        stride: triangles.div_ceil(MOST_TRIANGLES).max(1),
        searches: SEARCHES,
        patterns: &patterns,
        raw: Tally::default(),
        kinds: BTreeMap::new(),
        faces: BTreeMap::new(),
        measured: 0,
        seen: 0,
        uvs: Vec::new(),
    };
    let misses: Vec<Vec<f64>> =
        prepared.parts.iter().map(|part| part.edges.iter().map(edges::miss).collect()).collect();
    for batch in &mesh.batches {
        let found = prepared
            .parts
            .get(batch.part.index())
            .and_then(|part| Some((part.face(batch.face)?, part.tiles.get(batch.tile.0 as usize)?)));
        if let Some((face, tile)) = found {
            let edges = tile.loops.iter().flatten().map(|edge_use| edge_use.edge.index());
            let miss = edges.fold(0.0_f64, |most, edge| most.max(misses[batch.part.index()][edge]));
            audit.chord = chords.get(batch.part.index()).copied().unwrap_or(chord);
            audit.batch(batch, face, face.gap + miss);
        }
    }
    let (edges, edge_places) = edges::measure(prepared, mesh, &chords);
    audit.report(triangles, &edges, edge_places)
}

/// Squared length of each triangle's longest side.
fn squared_sizes<'a>(mesh: &TileView<'a>) -> impl Iterator<Item = f64> + use<'a> {
    let positions = mesh.positions;
    mesh.triangles.iter().map(move |t| squared_size(t.map(|v| positions[v as usize])))
}

fn squared_size([a, b, c]: [DVec3; 3]) -> f64 {
    a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a))
}

/// Barycentric coordinates of a lattice of `steps` per side, without the corners and always with the centre.
fn pattern(steps: u32) -> Vec<DVec3> {
    let n = f64::from(steps);
    let mut points = Vec::new();
    for i in 0..=steps {
        for j in 0..=steps - i {
            let k = steps - i - j;
            if i.max(j).max(k) < steps {
                points.push(DVec3::new(f64::from(i), f64::from(j), f64::from(k)) / n);
            }
        }
    }
    if !steps.is_multiple_of(3) {
        points.push(DVec3::splat(1.0 / 3.0));
    }
    points
}

struct Audit<'a> {
    /// Chord tolerance in the placed model.
    asked: f64,
    /// Chord tolerance in the current part.
    chord: f64,
    /// Mean squared longest side.
    mean_size: f64,
    /// Number of samples for a triangle of mean size.
    share: f64,
    stride: u64,
    searches: u32,
    patterns: &'a [Vec<DVec3>],
    raw: Tally,
    kinds: BTreeMap<SurfaceKind, Tally>,
    faces: BTreeMap<(PartId, FaceId), Place>,
    measured: u64,
    seen: u64,
    uvs: Vec<DVec2>,
}

impl Audit<'_> {
    /// Measures a batch of `face`, whose edges and vertices may be up to `file_gap` away from its surface.
    fn batch(&mut self, batch: &BatchView<'_>, face: &PreparedFace, file_gap: f64) {
        let mesh = &batch.mesh;
        let mut uvs = std::mem::take(&mut self.uvs);
        uvs.clear();
        uvs.extend(mesh.uvs.iter().map(|uv| face.to_patches(uv.as_dvec2())));
        let patterns = self.patterns;
        let mut worst: Option<(f64, usize, DVec3)> = None;
        let mut tally = self.kinds.remove(&face.kind).unwrap_or_default();
        for (number, corners) in mesh.triangles.iter().enumerate() {
            self.seen += 1;
            if !self.seen.is_multiple_of(self.stride) {
                continue;
            }
            self.measured += 1;
            let points = corners.map(|v| mesh.positions[v as usize]);
            let parameters = corners.map(|v| uvs[v as usize]);
            let on_lattice = corners.iter().all(|&v| matches!(mesh.origins[v as usize], Origin::Lattice { .. }));
            let gap = if on_lattice { 0.0 } else { file_gap };
            let wanted = self.share * squared_size(points) / self.mean_size;
            let flat = face.kind == SurfaceKind::Plane;
            let finest = patterns.len() - 1;
            let pattern =
                if flat { 0 } else { patterns.iter().position(|p| p.len() as f64 >= wanted).unwrap_or(finest) };
            for weights in &patterns[pattern] {
                let p = points[0] * weights.x + points[1] * weights.y + points[2] * weights.z;
                let uv = parameters[0] * weights.x + parameters[1] * weights.y + parameters[2] * weights.z;
                let distance = self.distance(&face.patches, p, uv, parameters, gap);
                self.raw.add(distance / self.chord);
                let beyond = (distance - gap).max(0.0) / self.chord;
                tally.add(beyond);
                if worst.is_none_or(|(most, ..)| beyond > most) {
                    worst = Some((beyond, number, p));
                }
            }
        }
        self.kinds.insert(face.kind, tally);
        self.uvs = uvs;
        if let Some((over_tolerance, triangle, point)) = worst {
            let (part, face_id, tile) = (batch.part, batch.face, batch.tile);
            let place =
                Place { part, face: face_id, tile, triangle, kind: face.kind, point, over_tolerance, gap: file_gap };
            let known = self.faces.entry((part, face_id)).or_insert(place);
            if place.over_tolerance > known.over_tolerance {
                *known = place;
            }
        }
    }

    /// Distance of a sample to the surface.
    fn distance(&mut self, patches: &BezierPatches, p: DVec3, uv: DVec2, corners: [DVec2; 3], gap: f64) -> f64 {
        let enough = ENOUGH * self.chord;
        let walked = walk_surface(patches, p, uv, enough).distance;
        if walked <= self.chord + gap || self.searches == 0 {
            return walked;
        }
        self.searches -= 1;
        let [a, b, c] = corners;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        // Meshes store (u,v) in single precision.
        let around = 0.5 * (high - low) + f64::from(f32::EPSILON) * low.abs().max(high.abs());
        let (start, end) = parameter_box(patches);
        let ends = ((low - around).max(start), (high + around).min(end));
        walked.min(search_surface(patches, p, ends, enough).distance)
    }

    fn report(self, triangles: u64, edges: &Tally, mut worst_edges: Vec<EdgePlace>) -> DeviationReport {
        let mut beyond = Tally::default();
        self.kinds.values().for_each(|tally| beyond.join(tally));
        let mut worst: Vec<Place> = self.faces.into_values().collect();
        worst.sort_by(|a, b| b.over_tolerance.total_cmp(&a.over_tolerance));
        let faces_over = worst.iter().take_while(|place| place.over_tolerance > 1.0).count();
        worst.truncate(DeviationReport::PLACES);
        worst_edges.sort_by(|a, b| b.over_tolerance.total_cmp(&a.over_tolerance));
        worst_edges.truncate(DeviationReport::PLACES);
        DeviationReport {
            chord: self.asked,
            raw: self.raw.spread(),
            beyond_gap: beyond.spread(),
            kinds: self.kinds.iter().map(|(&kind, tally)| (kind, tally.spread())).collect(),
            worst,
            faces_over,
            edges: edges.spread(),
            worst_edges,
            triangles,
            measured: self.measured,
        }
    }
}
