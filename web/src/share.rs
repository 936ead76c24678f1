//! A share of a model: several instances of the module read one file, each prepares and tessellates the parts that it
//! owns, and one gathers their triangles.

use crate::mesh::Mesh;
use crate::model::Model;
use crate::told;
use js_sys::{Float32Array, Float64Array, Uint32Array};
use serde::{Deserialize, Serialize};
use trimtess::glam::{DVec3, Vec3};
use trimtess::mesh::{Batch, EdgeLine, FrameView, MeshSink, TileMesh};
use trimtess::model::{self, EdgeId, FaceId, Loop, PartId, Surface, TileId};
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::*;

/// Expected cost of a face apart from its edges and control points, in units of an edge that it uses.
const FACE: usize = 4;

/// The owner of each part among so many: the costliest first, each to the owner with the least. Depends on the model
/// alone, so that all instances agree.
fn deal(parts: &[model::Part], owners: usize) -> Vec<usize> {
    let mut order: Vec<(usize, usize)> = parts.iter().map(cost).zip(0..).collect();
    order.sort_unstable_by_key(|&(cost, part)| (std::cmp::Reverse(cost), part));
    let (mut loads, mut owner) = (vec![0; owners.max(1)], vec![0; parts.len()]);
    for (cost, part) in order {
        let least = (0..loads.len()).min_by_key(|&owner| (loads[owner], owner)).unwrap_or(0);
        loads[least] += cost;
        owner[part] = least;
    }
    owner
}

/// Expected cost of a part: uses of edges, faces, and control points of spline surfaces.
fn cost(part: &model::Part) -> usize {
    let of_face = |face: &model::Face| {
        let uses = face.loops.iter().map(|around| if let Loop::Edges(uses) = around { uses.len() } else { 1 });
        let poles = if let Surface::Nurbs(surface) = &face.surface { surface.points.len() } else { 0 };
        FACE + uses.sum::<usize>() + poles
    };
    part.faces.iter().map(of_face).sum()
}

/// Empties the parts that others own, which keep their names and the colours and numbers of their faces. Returns which
/// parts are owned.
pub(crate) fn keep(model: &mut model::Model, share: usize, shares: usize) -> Vec<bool> {
    let owned: Vec<bool> =
        deal(&model.parts, shares).into_iter().map(|owner| share < shares && owner == share).collect();
    for (part, _) in model.parts.iter_mut().zip(&owned).filter(|(_, owned)| !**owned) {
        part.edges = Vec::new();
        for face in &mut part.faces {
            face.lost = true;
            face.loops = Vec::new();
            face.trims = None;
        }
    }
    owned
}

#[wasm_bindgen]
impl Model {
    /// Leaves all parts but one of so many shares to other instances of the module, which read the same file. Returns
    /// whether any part is left: of a share that is not below `shares`, none is.
    #[wasm_bindgen(js_name = keepShare)]
    pub fn keep_share(&mut self, share: usize, shares: usize) -> bool {
        self.owned = keep(&mut self.model, share, shares);
        self.shares = shares;
        self.owned.contains(&true)
    }
}

/// The triangles of a part in double precision, on their way to another instance of the module.
#[derive(Serialize, Deserialize, Tsify)]
pub struct SharedPart {
    part: u32,
    /// Centre and radius of the part.
    sphere: [f64; 4],
    #[serde(with = "serde_wasm_bindgen::preserve")]
    #[tsify(type = "Float64Array<ArrayBuffer>")]
    positions: Float64Array,
    #[serde(with = "serde_wasm_bindgen::preserve")]
    #[tsify(type = "Float32Array<ArrayBuffer>")]
    normals: Float32Array,
    /// Indices within tiles.
    #[serde(with = "serde_wasm_bindgen::preserve")]
    #[tsify(type = "Uint32Array<ArrayBuffer>")]
    triangles: Uint32Array,
    /// Face, tile, and numbers of vertices and triangles, for each tile.
    #[serde(with = "serde_wasm_bindgen::preserve")]
    #[tsify(type = "Uint32Array<ArrayBuffer>")]
    tiles: Uint32Array,
    /// Number and points, for each edge.
    #[serde(with = "serde_wasm_bindgen::preserve")]
    #[tsify(type = "Uint32Array<ArrayBuffer>")]
    edges: Uint32Array,
    #[serde(with = "serde_wasm_bindgen::preserve")]
    #[tsify(type = "Float64Array<ArrayBuffer>")]
    points: Float64Array,
}

#[wasm_bindgen]
impl Mesh {
    /// The parts that this instance owns, for the instance that gathers them.
    ///
    /// # Errors
    /// Those of making objects.
    pub fn share(&self) -> Result<Vec<Ts<SharedPart>>, JsError> {
        let view = FrameView::from(&self.frame);
        let owned = (0..self.owned.len()).filter(|&part| self.owned[part]);
        owned.map(|part| Ok(self.shared(&view, PartId::new(part)).into_ts()?)).collect()
    }

    /// Takes the triangles of a part that another instance owns. [`complete`](Self::complete) the mesh after the last.
    ///
    /// # Errors
    /// If the arrays do not belong together, or vertices are too many for 32-bit indices.
    pub fn gather(&mut self, part: Ts<SharedPart>) -> Result<(), JsError> {
        self.take(part.to_rust()?).ok_or_else(|| told("the arrays of a shared part do not belong together"))?
    }

    /// Puts the lines of all parts in their order.
    pub fn complete(&mut self) {
        self.frame.edge_lines.sort_by_key(|line| (line.part, line.edge));
    }
}

impl Mesh {
    fn shared(&self, view: &FrameView<'_>, part: PartId) -> SharedPart {
        let mesh = &self.frame.parts[part.index()];
        let scene = &self.frame.scene.parts[part.index()];
        // Batches come by part.
        let first = view.batches.partition_point(|batch| batch.part < part);
        let batches = view.batches[first..].iter().take_while(|batch| batch.part == part);
        let (mut tiles, mut triangles) = (Vec::new(), Vec::with_capacity(3 * mesh.triangles.len()));
        for batch in batches {
            let counts = [batch.mesh.positions.len(), batch.mesh.triangles.len()].map(|count| count as u32);
            tiles.extend([batch.face.0, batch.tile.0, counts[0], counts[1]]);
            triangles.extend(batch.mesh.triangles.iter().flatten());
        }
        let lines = self.frame.edge_lines_of(part);
        let edges: Vec<u32> = lines.iter().flat_map(|line| [line.edge.0, line.points.len() as u32]).collect();
        let points: Vec<f64> = lines.iter().flat_map(|line| &line.points).flat_map(|point| point.to_array()).collect();
        let positions: Vec<f64> = mesh.positions.iter().flat_map(|point| point.to_array()).collect();
        let normals: Vec<f32> = mesh.normals.iter().flat_map(|normal| normal.to_array()).collect();
        let [x, y, z] = scene.centre.to_array();
        SharedPart {
            part: part.0,
            sphere: [x, y, z, scene.radius],
            positions: Float64Array::from(positions.as_slice()),
            normals: Float32Array::from(normals.as_slice()),
            triangles: Uint32Array::from(triangles.as_slice()),
            tiles: Uint32Array::from(tiles.as_slice()),
            edges: Uint32Array::from(edges.as_slice()),
            points: Float64Array::from(points.as_slice()),
        }
    }

    /// `None` if lists are shorter than others say, or name vertices that are not there.
    fn take(&mut self, shared: SharedPart) -> Option<Result<(), JsError>> {
        let part = PartId(shared.part);
        let scene = self.frame.scene.parts.get_mut(part.index())?;
        let [x, y, z, radius] = shared.sphere;
        (scene.centre, scene.radius) = (DVec3::new(x, y, z), radius);
        let (positions, normals) = (shared.positions.to_vec(), shared.normals.to_vec());
        let (triangles, points) = (shared.triangles.to_vec(), shared.points.to_vec());
        let mut positions = positions.as_chunks().0.iter().map(|&point| DVec3::from_array(point));
        let mut normals = normals.as_chunks().0.iter().map(|&normal| Vec3::from_array(normal));
        let mut triangles = triangles.as_chunks().0.iter().copied();
        let mut points = points.as_chunks().0.iter().map(|&point| DVec3::from_array(point));
        for &[face, tile, vertices, corners] in shared.tiles.to_vec().as_chunks().0 {
            let (vertices, corners) = (vertices as usize, corners as usize);
            let mesh = TileMesh {
                positions: some(&mut positions, vertices)?,
                normals: some(&mut normals, vertices)?,
                triangles: some(&mut triangles, corners)?,
                ..TileMesh::default()
            };
            if mesh.triangles.iter().flatten().any(|&corner| corner as usize >= vertices) {
                return None;
            }
            let mut batch = Batch { part, face: FaceId(face), tile: TileId(tile), worker: 0, mesh };
            if let Err(error) = self.frame.batch(&mut batch) {
                return Some(Err(told(error)));
            }
        }
        for &[edge, count] in shared.edges.to_vec().as_chunks().0 {
            let points = some(&mut points, count as usize)?;
            self.frame.edge_lines.push(EdgeLine { part, edge: EdgeId(edge), points });
        }
        Some(Ok(()))
    }
}

/// The next `count` items; `None` if there are fewer.
fn some<T>(items: &mut impl Iterator<Item = T>, count: usize) -> Option<Vec<T>> {
    let taken: Vec<T> = items.take(count).collect();
    (taken.len() == count).then_some(taken)
}
