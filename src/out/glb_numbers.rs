//! Faces of one colour, and edges, of parts -> the numbers of their primitives in a GLB, made in runs on all threads.

use super::format::GlbOptions;
#[cfg(feature = "meshopt")]
use super::glb_buffers::filtered;
use super::making::Making;
use super::node_place::PointNumbers;
use super::placed::{BeyondSingle, cut, distinct};
use super::rounding::RoundingCount;
use crate::control::Call;
use crate::mesh::{BatchView, EdgeLine, SHORT_VERTICES, ScenePart};
use crate::model::Colour;
use glam::{DVec3, Vec3};

/// What one primitive shows: faces of one colour, or edges.
pub(super) struct Group<'a> {
    pub(super) part: &'a ScenePart,
    pub(super) numbers: PointNumbers,
    pub(super) colour: Option<Colour>,
    pub(super) faces: Vec<&'a BatchView<'a>>,
    pub(super) edges: Vec<&'a EdgeLine>,
}

/// The numbers of one primitive, each kind in pieces.
#[derive(Default)]
pub(super) struct Numbers {
    pub(super) vertices: usize,
    pub(super) corners: usize,
    /// Different faces or edges.
    pub(super) features: usize,
    /// Whether ids have 16 bits.
    pub(super) short_ids: bool,
    /// Whether indices have 16 bits.
    pub(super) short_indices: bool,
    /// The corners of the box around all positions, as stored.
    pub(super) bounds: [Vec3; 2],
    pub(super) positions: Vec<Vec<u8>>,
    pub(super) normals: Vec<Vec<u8>>,
    pub(super) ids: Vec<Vec<u8>>,
    pub(super) indices: Vec<Vec<u8>>,
}

/// Rounds the vertices of groups, and leaves out triangles and segments whose corners coincide then. Returns the
/// numbers of each group, empty if nothing is left, and what rounding its faces costs. All are empty once cancelled.
///
/// # Errors
/// If a position overflows single precision.
pub(super) fn numbers(
    making: &Making<'_>,
    groups: &[Group<'_>],
    options: GlbOptions,
) -> Result<Vec<(Numbers, RoundingCount)>, BeyondSingle> {
    let mut runs = Vec::new();
    for (k, group) in groups.iter().enumerate() {
        let faces = cut(&group.faces, |batch| batch.mesh.positions.len());
        let edges = cut(&group.edges, |line| line.points.len());
        runs.extend(faces.map(|faces| (k, Run { group, faces, edges: &[] })));
        runs.extend(edges.map(|edges| (k, Run { group, faces: &[], edges })));
    }
    let mut out: Vec<(Numbers, RoundingCount)> = groups.iter().map(|_| Default::default()).collect();
    let call = making.call;
    let made = call.each(1, runs, |(k, run)| {
        let piece = if call.is_cancelled() { Piece::with_room([0; 2], 0) } else { run.piece(call, options)? };
        making.made(run.faces.len());
        Ok::<_, BeyondSingle>((k, piece))
    });
    if call.is_cancelled() {
        call.discard(made);
        return Ok(out);
    }
    let (mut pieces, mut features) = (Vec::with_capacity(made.len()), vec![Vec::new(); groups.len()]);
    for made in made {
        let (k, mut piece) = made?;
        let (numbers, count) = &mut out[k];
        let [low, high] = if numbers.vertices > 0 { numbers.bounds } else { NOWHERE };
        numbers.bounds = [low.min(piece.bounds[0]), high.max(piece.bounds[1])];
        features[k].extend(piece.features.iter().map(|&(feature, _)| feature));
        numbers.positions.push(std::mem::take(&mut piece.positions));
        numbers.normals.push(std::mem::take(&mut piece.normals));
        count.add(std::mem::take(&mut piece.count));
        let first = numbers.vertices;
        numbers.vertices += piece.vertices;
        numbers.corners += piece.indices.len();
        pieces.push((k, first, piece));
    }
    for ((numbers, _), features) in out.iter_mut().zip(&mut features) {
        features.sort_unstable();
        features.dedup();
        numbers.features = features.len();
        numbers.short_ids = options.quantized && features.last().is_none_or(|&last| last <= u32::from(u16::MAX));
        numbers.short_indices = numbers.vertices <= SHORT_VERTICES;
    }
    let stored = call.each(1, pieces, |(k, first, piece)| match call.is_cancelled() {
        true => (k, Vec::new(), Vec::new()),
        false => (k, piece.ids(&out[k].0), piece.indices(call, first, &out[k].0)),
    });
    for (k, ids, indices) in stored {
        out[k].0.ids.push(ids);
        out[k].0.indices.push(indices);
    }
    Ok(out)
}

/// Some faces or edges of a group.
struct Run<'a> {
    group: &'a Group<'a>,
    faces: &'a [&'a BatchView<'a>],
    edges: &'a [&'a EdgeLine],
}

impl Run<'_> {
    /// Some of it, once cancelled.
    fn piece(&self, call: Call<'_>, options: GlbOptions) -> Result<Piece, BeyondSingle> {
        let Self { group: Group { part, numbers, .. }, faces, edges } = *self;
        let vertices = faces.iter().map(|batch| batch.mesh.positions.len()).sum::<usize>();
        let corners = faces.iter().map(|batch| 3 * batch.mesh.triangles.len()).sum::<usize>();
        let points = edges.iter().map(|line| line.points.len()).sum::<usize>();
        let mut piece = Piece::with_room([vertices, vertices + points], corners + 2 * points);
        let mut rounded = Vec::new();
        let round = |points: &[DVec3], rounded: &mut Vec<Vec3>| {
            rounded.clear();
            call.while_wanted(points.iter())
                .try_for_each(|&point| numbers.local(part, point).map(|position| rounded.push(position)))
        };
        for batch in faces {
            round(batch.mesh.positions, &mut rounded)?;
            for (&point, &position) in call.while_wanted(batch.mesh.positions.iter().zip(&rounded)) {
                piece.count.point(point, numbers.moved(part, point, position));
            }
            let (first, before) = (piece.vertices as u32, piece.indices.len());
            let kept = call.while_wanted(distinct(&batch.mesh, &rounded));
            kept.for_each(|corners| piece.indices.extend(corners.map(|corner| first + corner)));
            let kept = (piece.indices.len() - before) / 3;
            piece.count.triangles(batch.face, batch.mesh.triangles.len(), kept);
            if kept > 0 {
                let normals = call.while_wanted(0..rounded.len()).map(|index| {
                    let normal = batch.mesh.normals.get(index).copied().unwrap_or_default();
                    normal.as_dvec3().normalize_or(DVec3::Z).as_vec3()
                });
                store_normals(normals, options, &mut piece.normals);
                piece.place(call, batch.face.0, &rounded, *numbers);
            }
        }
        for line in edges {
            round(&line.points, &mut rounded)?;
            let (first, before) = (piece.vertices as u32, piece.indices.len());
            let segments = (1..).zip(rounded.windows(2)).filter(|(_, ends)| ends[0] != ends[1]);
            piece.indices.extend(segments.flat_map(|(end, _)| [first + end - 1, first + end]));
            if piece.indices.len() > before {
                piece.place(call, line.edge.0, &rounded, *numbers);
            }
        }
        Ok(piece)
    }
}

/// The box around no positions.
const NOWHERE: [Vec3; 2] = [Vec3::INFINITY, Vec3::NEG_INFINITY];

/// The numbers of a run, with indices from its own first vertex on.
struct Piece {
    vertices: usize,
    bounds: [Vec3; 2],
    positions: Vec<u8>,
    normals: Vec<u8>,
    /// Faces or edges, each with its number of vertices.
    features: Vec<(u32, usize)>,
    indices: Vec<u32>,
    count: RoundingCount,
}

impl Piece {
    /// `normals` and `vertices`: numbers of them.
    fn with_room([normals, vertices]: [usize; 2], corners: usize) -> Self {
        Self {
            vertices: 0,
            bounds: NOWHERE,
            positions: Vec::with_capacity(vertices * size_of::<Vec3>()),
            normals: Vec::with_capacity(normals * size_of::<Vec3>()),
            features: Vec::new(),
            indices: Vec::with_capacity(corners),
            count: RoundingCount::default(),
        }
    }

    /// Appends the vertices of a face or an edge.
    fn place(&mut self, call: Call<'_>, feature: u32, rounded: &[Vec3], numbers: PointNumbers) {
        let [mut low, mut high] = self.bounds;
        let mut within = |stored: Vec3| (low, high) = (low.min(stored), high.max(stored));
        for &position in call.while_wanted(rounded.iter()) {
            if let Some(step) = numbers.step {
                let integers = PointNumbers::integers(step, position);
                within(Vec3::from_array(integers.map(f32::from)));
                let [x, y, z] = integers.map(i16::to_le_bytes);
                self.positions.extend_from_slice([x, y, z, [0; 2]].as_flattened());
            } else {
                within(position);
                self.positions.extend_from_slice(position.to_array().map(f32::to_le_bytes).as_flattened());
            }
        }
        self.bounds = [low, high];
        self.features.push((feature, rounded.len()));
        self.vertices += rounded.len();
    }

    /// The ids of all vertices.
    fn ids(&self, Numbers { short_ids, .. }: &Numbers) -> Vec<u8> {
        let stored = |feature: u32| if *short_ids { feature.to_le_bytes() } else { (feature as f32).to_le_bytes() };
        let mut ids = Vec::with_capacity(self.vertices);
        for &(feature, count) in &self.features {
            ids.extend(std::iter::repeat_n(stored(feature), count));
        }
        ids.into_flattened()
    }

    /// The indices, `first` being that of the first vertex.
    fn indices(&self, call: Call<'_>, first: usize, Numbers { short_indices, .. }: &Numbers) -> Vec<u8> {
        let indices = call.while_wanted(self.indices.iter()).map(|index| first as u32 + index);
        match short_indices {
            true => bytes(indices.map(|index| (index as u16).to_le_bytes())),
            false => bytes(indices.map(u32::to_le_bytes)),
        }
    }
}

/// Appends the bytes of normals.
fn store_normals(normals: impl Iterator<Item = Vec3>, options: GlbOptions, to: &mut Vec<u8>) {
    if !options.quantized {
        normals.for_each(|normal| to.extend_from_slice(normal.to_array().map(f32::to_le_bytes).as_flattened()));
        return;
    }
    #[cfg(feature = "meshopt")]
    if options.compressed {
        let rows = filtered(normals.map(|normal| normal.to_array()));
        to.extend_from_slice(&bytes(rows.into_iter().flatten().map(i16::to_le_bytes)));
        return;
    }
    let short = |x: f32| ((x * f32::from(i16::MAX)).round() as i16).to_le_bytes();
    let row = |normal: Vec3| [short(normal.x), short(normal.y), short(normal.z), [0; 2]];
    normals.for_each(|normal| to.extend_from_slice(row(normal).as_flattened()));
}

pub(super) fn bytes<const N: usize>(numbers: impl Iterator<Item = [u8; N]>) -> Vec<u8> {
    numbers.collect::<Vec<_>>().into_flattened()
}
