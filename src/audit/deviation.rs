//! Triangles -> distances to the exact surfaces of their faces, by dense sampling and foot points; edge polylines ->
//! distances to the exact curves, and of the curves to them.

use super::foot::{parameter_box, search_curve, search_surface, walk_curve, walk_surface};
use super::report::{DeviationReport, EdgePlace, Place, Tally};
use crate::mesh::{BatchView, FrameView, Origin, TileView};
use crate::model::{FaceId, PartId, SurfaceKind};
use crate::prepare::Prepared;
use crate::prepare::internals::{BezierPatches, BezierSpline3, EdgeShape, PreparedEdge, PreparedFace};
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;

/// Inner samples per segment in each direction. Odd, to include the middle.
const EDGE_SAMPLES: u32 = 5;
/// Starts per Bézier segment of a search along a curve, if following the polyline did not find the foot point.
const STARTS: u32 = 32;

/// Fraction of the chord tolerance within which a tessellant counts as on its curve.
const ON_CURVE: f64 = 1e-3;

/// Measures all edges: ratios of distances to the chord tolerance of their part, and the worst place of each edge.
fn measure_edges(prepared: &Prepared, mesh: &FrameView<'_>, chords: &[f64]) -> (Tally, Vec<EdgePlace>) {
    let mut tally = Tally::default();
    let mut places = Vec::new();
    for line in mesh.edge_lines {
        let edge = prepared.parts.get(line.part.index()).and_then(|part| part.edges.get(line.edge.index()));
        let (Some(edge), Some(&chord)) = (edge, chords.get(line.part.index())) else { continue };
        let EdgeShape::Curve(curve) = &edge.shape else { continue };
        let mut place = EdgePlace { part: line.part, edge: line.edge, point: DVec3::ZERO, over_tolerance: -1.0 };
        let (start, end) = curve.range();
        let stride = (end - start) / (line.points.len().max(2) - 1) as f64;
        Follower { edge, curve, chord, stride }.measure(&line.points, &mut |distance, point| {
            let ratio = distance / chord;
            tally.add(ratio);
            if ratio > place.over_tolerance {
                place = EdgePlace { point, over_tolerance: ratio, ..place };
            }
        });
        if place.over_tolerance >= 0.0 {
            places.push(place);
        }
    }
    (tally, places)
}

/// Maximum distance in the file between the vertices of an edge and the ends of its curve.
fn miss(edge: &PreparedEdge) -> f64 {
    match &edge.shape {
        EdgeShape::Curve(curve) => ends_missed(edge, curve).into_iter().fold(0.0, f64::max),
        EdgeShape::Point(_) => 0.0,
    }
}

/// Distances between vertices and curve at the first and the last parameter.
fn ends_missed(edge: &PreparedEdge, curve: &BezierSpline3) -> [f64; 2] {
    [edge.breaks.first(), edge.breaks.last()].map(|end| end.map_or(0.0, |end| end.point.distance(curve.point(end.t))))
}

/// Follows a curve along its polyline. Polylines have no parameters, so they are recovered: at breaks exactly, between
/// them by walking from the last sample.
struct Follower<'a> {
    edge: &'a PreparedEdge,
    curve: &'a BezierSpline3,
    chord: f64,
    /// Mean parameter length of a segment.
    stride: f64,
}

impl Follower<'_> {
    fn measure(&self, points: &[DVec3], add: &mut impl FnMut(f64, DVec3)) {
        let (t0, t1) = self.curve.range();
        let [start, end] = ends_missed(self.edge, self.curve);
        let breaks = &self.edge.breaks;
        let mut next_break = 1;
        let mut from = t0;
        for (k, ends) in points.windows(2).enumerate() {
            let limit = breaks.get(next_break).map_or(t1, |b| b.t);
            // Vertices may be off the curve in the file, which affects the first and the last segment.
            let first = if k == 0 { start } else { 0.0 };
            let last = if k + 2 == points.len() { end } else { 0.0 };
            let gap = first.max(last);
            let mut t = from;
            for i in 1..=EDGE_SAMPLES {
                let p = ends[0].lerp(ends[1], f64::from(i) / f64::from(EDGE_SAMPLES + 1));
                let (distance, at) = self.foot(p, t, (from, limit), self.chord + gap);
                t = at;
                add((distance - gap).max(0.0), p);
            }
            let to = if breaks.get(next_break).is_some_and(|b| b.point == ends[1]) {
                next_break += 1;
                limit
            } else {
                // A tessellant is on its curve. A point that is merely near may be on another leg of a curve that turns
                // back.
                self.foot(ends[1], t, (from, limit), ON_CURVE * self.chord + gap).1
            };
            for i in 1..=EDGE_SAMPLES {
                let p = self.curve.point(from + (to - from) * f64::from(i) / f64::from(EDGE_SAMPLES + 1));
                add((distance_to_segment(p, ends[0], ends[1]) - gap).max(0.0), p);
            }
            from = to;
        }
    }

    /// Distance from `p` to the curve within `range`, and the parameter of the foot point. Walks from `t`; searches the
    /// whole range if the result is farther than `near`.
    fn foot(&self, p: DVec3, t: f64, range: (f64, f64), near: f64) -> (f64, f64) {
        let enough = 1e-4 * self.chord;
        let found = walk_curve(self.curve, p, t, range, enough);
        if found.distance <= near {
            return (found.distance, found.at);
        }
        // A walk may stop at a sharp turn. Search nearby first, because another part of the curve may come as close.
        let segments = u32::try_from(self.curve.segments()).unwrap_or(u32::MAX).min(64);
        let (low, high) = range;
        let mut best = (found.distance, found.at);
        for end in [low + 4.0 * self.stride, low + 64.0 * self.stride, high] {
            let searched = search_curve(self.curve, p, (low, end.min(high)), STARTS * segments, enough);
            if searched.distance < best.0 {
                best = (searched.distance, searched.at);
            }
            if best.0 <= near {
                break;
            }
        }
        best
    }
}

/// Distance from `p` to the segment from `a` to `b`. Infinite if a point is not finite.
fn distance_to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let squared = along.length_squared();
    let s = if squared > 0.0 { ((p - a).dot(along) / squared).clamp(0.0, 1.0) } else { 0.0 };
    let distance = p.distance(a + along * s);
    if distance.is_nan() { f64::INFINITY } else { distance }
}

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
    let sizes = |mesh: &TileView<'_>| -> f64 {
        mesh.triangles.iter().map(|t| squared_size(t.map(|v| mesh.positions[v as usize]))).sum()
    };
    let size: f64 = mesh.batches.iter().map(|b| sizes(&b.mesh)).sum();
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
    let misses: Vec<Vec<f64>> = prepared.parts.iter().map(|part| part.edges.iter().map(miss).collect()).collect();
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
    let (edges, edge_places) = measure_edges(prepared, mesh, &chords);
    audit.report(triangles, &edges, edge_places)
}

/// Squared length of a triangle's longest side.
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
