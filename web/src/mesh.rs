//! A prepared model -> typed arrays, and files.

use crate::diagnostic::{Diagnostic, listed};
use crate::instance::{Instance, placed};
use crate::model::is_owned;
use crate::told;
use js_sys::{Float32Array, Uint32Array};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use trimtess::control::{Alone, Control};
use trimtess::frame::{self, PlanLimits, plan_on};
use trimtess::glam::DVec3;
use trimtess::mesh::PackedFrame;
use trimtess::model::{self, PartId};
use trimtess::out::{Format, GlbOptions, Rounding, SaveOptions, write_on};
use trimtess::parallel::tessellate_on;
use trimtess::prepare::Prepared;
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::*;

/// Limits of a mesh. `chord` or `chordRel`, not both.
#[derive(Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct Tolerance {
    /// Largest distance between triangles and surface, millimetres.
    #[tsify(optional)]
    chord: Option<f64>,
    /// The same as a fraction of the diagonal. Default 1e-3.
    #[tsify(optional)]
    chord_rel: Option<f64>,
    /// Largest turning of the normal across a lattice cell, degrees. Default 20.
    #[tsify(optional)]
    angle: Option<f64>,
    /// Longest diagonal of a lattice cell, millimetres.
    #[tsify(optional)]
    max_edge: Option<f64>,
}

impl Tolerance {
    fn resolve(&self, diagonal: f64) -> Result<frame::Tolerance, JsError> {
        let Self { chord, chord_rel, angle, max_edge } = *self;
        if chord.is_some() && chord_rel.is_some() {
            return Err(told("chord and chordRel are given; pass one of them"));
        }
        for (name, number) in [("chord", chord), ("chordRel", chord_rel), ("angle", angle), ("maxEdge", max_edge)] {
            if let Some(number) = number.filter(|number| !(number.is_finite() && *number > 0.0)) {
                return Err(told(format!("{name} is {number}; it must be a finite number above 0")));
            }
        }
        let fraction = chord_rel.unwrap_or(frame::Tolerance::DEFAULT_CHORD_REL);
        let chord = chord.unwrap_or(frame::Tolerance::relative(fraction, diagonal).chord);
        let angle = angle.unwrap_or(frame::Tolerance::DEFAULT_ANGLE_DEGREES);
        Ok(frame::Tolerance { chord, angle: angle.to_radians(), max_edge })
    }
}

/// A mesh within a tolerance.
#[wasm_bindgen]
pub struct Mesh {
    pub(crate) frame: PackedFrame,
    /// Parts that this instance of the module made.
    pub(crate) owned: Vec<bool>,
    /// Those of tessellating, by part.
    diagnostics: Vec<model::Diagnostic>,
    /// Largest distance that a file's numbers may move a vertex, millimetres.
    rounding: f64,
}

impl Mesh {
    /// `diagonal` is that of the whole model.
    pub(crate) fn make(
        (prepared, owned): (&Arc<Prepared>, &[bool]),
        (asked, diagonal, limits): (&Tolerance, f64, &PlanLimits),
        control: &Control,
    ) -> Result<Self, JsError> {
        let tolerance = asked.resolve(diagonal)?;
        let plan = plan_on(&Alone, prepared, &tolerance, limits, control).map_err(told)?.require_full();
        let plan = plan.map_err(|short| told(format!("{short}; use a larger tolerance")))?;
        let mut frame = PackedFrame::default();
        let report = tessellate_on(&Alone, prepared, &Arc::new(plan), true, control, &mut frame).map_err(told)?;
        let mut diagnostics = report.diagnostics(&frame, prepared).split_off(prepared.diagnostics.len());
        diagnostics.retain(|told| is_owned(owned, told.part));
        diagnostics.sort_by_key(|told| told.part);
        Ok(Self { frame, owned: owned.to_vec(), diagnostics, rounding: Rounding::SHARE * tolerance.chord })
    }
}

#[wasm_bindgen]
impl Mesh {
    /// Triangles of all parts, each part counted once.
    #[must_use]
    pub fn triangles(&self) -> usize {
        self.frame.parts.iter().map(|part| part.triangles.len()).sum()
    }

    /// Number of parts.
    #[wasm_bindgen(js_name = partCount)]
    #[must_use]
    pub fn part_count(&self) -> usize {
        self.frame.parts.len()
    }

    /// The mesh of a part, as arrays of its own.
    ///
    /// # Errors
    /// If there is no such part.
    pub fn part(&self, part: usize) -> Result<Ts<MeshPart>, JsError> {
        let (Some(mesh), Some(scene)) = (self.frame.parts.get(part), self.frame.scene.parts.get(part)) else {
            return Err(told(format!("there is no part {part}; the mesh has {}", self.frame.parts.len())));
        };
        let centre = scene.centre;
        let lines = self.frame.edge_lines_of(PartId::new(part)).iter();
        let edges = lines.map(|line| Edge { edge: line.edge.0, points: relative(&line.points, centre) }).collect();
        let normals: Vec<f32> = mesh.normals.iter().flat_map(|normal| normal.to_array()).collect();
        let part = MeshPart {
            name: scene.name.clone(),
            centre: centre.into(),
            positions: relative(&mesh.positions, centre),
            normals: Float32Array::from(normals.as_slice()),
            indices: Uint32Array::from(mesh.triangles.as_flattened()),
            faces: groups(&mesh.face_ids, &scene.face_colours),
            edges,
        };
        Ok(part.into_ts()?)
    }

    /// Placed parts.
    ///
    /// # Errors
    /// Those of making objects.
    pub fn instances(&self) -> Result<Vec<Ts<Instance>>, JsError> {
        placed(&self.frame.scene).0.iter().map(|instance| Ok(instance.into_ts()?)).collect()
    }

    /// What tessellating the parts of this instance of the module repaired, approximated or lost, by part.
    ///
    /// # Errors
    /// Those of making objects.
    pub fn diagnostics(&self) -> Result<Vec<Ts<Diagnostic>>, JsError> {
        listed(&self.diagnostics)
    }

    /// A hash over positions (in double precision), normals, indices, faces and edges of all parts, as 16 hexadecimal
    /// digits. Equal bytes have equal hashes, on every machine.
    #[must_use]
    pub fn hash(&self) -> String {
        let mut hash = Fnv::default();
        for mesh in &self.frame.parts {
            mesh.positions.iter().for_each(|position| hash.doubles(&position.to_array()));
            let normals = mesh.normals.iter().flat_map(|normal| normal.to_array());
            normals.for_each(|number| hash.bytes(&number.to_le_bytes()));
            mesh.triangles.as_flattened().iter().for_each(|index| hash.bytes(&index.to_le_bytes()));
            mesh.face_ids.iter().for_each(|face| hash.bytes(&face.to_le_bytes()));
        }
        for line in &self.frame.edge_lines {
            hash.bytes(&line.edge.0.to_le_bytes());
            line.points.iter().for_each(|point| hash.doubles(&point.to_array()));
        }
        format!("{:016x}", hash.0)
    }

    /// The mesh as binary glTF.
    ///
    /// # Errors
    /// If the model is so far from the origin that the format's numbers would move a vertex by more than a tenth of the
    /// chord tolerance.
    pub fn glb(&self) -> Result<Vec<u8>, JsError> {
        let mut bytes = Vec::new();
        let options = SaveOptions::new(Format::Glb(GlbOptions::PLAIN)).with_max_rounding(self.rounding);
        write_on(&Alone, &self.frame, &mut bytes, &options, &Control::default()).map_err(told)?;
        Ok(bytes)
    }
}

/// Positions in single precision, relative to the centre of their part.
fn relative(points: &[DVec3], centre: DVec3) -> Float32Array {
    let numbers: Vec<f32> = points.iter().flat_map(|&point| (point - centre).as_vec3().to_array()).collect();
    Float32Array::from(numbers.as_slice())
}

/// Runs of triangles of one face.
fn groups(faces: &[u32], colours: &[Option<model::Colour>]) -> Vec<Group> {
    let mut start = 0;
    let runs = faces.chunk_by(|one, next| one == next).map(|run| {
        let group =
            Group { face: run[0], start, count: run.len(), colour: colours.get(run[0] as usize).copied().flatten() };
        start += run.len();
        group
    });
    runs.collect()
}

/// The mesh of a part.
#[derive(Serialize, Tsify)]
pub struct MeshPart {
    name: String,
    /// What positions are relative to, in the part's coordinates, millimetres.
    centre: [f64; 3],
    /// Three numbers a vertex.
    #[serde(with = "serde_wasm_bindgen::preserve")]
    #[tsify(type = "Float32Array<ArrayBuffer>")]
    positions: Float32Array,
    /// Three numbers a vertex, of length 1, outwards.
    #[serde(with = "serde_wasm_bindgen::preserve")]
    #[tsify(type = "Float32Array<ArrayBuffer>")]
    normals: Float32Array,
    /// Three vertices a triangle, counter-clockwise seen from outside.
    #[serde(with = "serde_wasm_bindgen::preserve")]
    #[tsify(type = "Uint32Array<ArrayBuffer>")]
    indices: Uint32Array,
    /// Triangles by face.
    faces: Vec<Group>,
    /// Edges of the model.
    edges: Vec<Edge>,
}

/// Triangles of one face.
#[derive(Serialize, Tsify)]
pub struct Group {
    /// Number within the part.
    face: u32,
    /// The first triangle.
    start: usize,
    /// Number of triangles.
    count: usize,
    /// The face's own colour, else the part's.
    #[tsify(optional)]
    colour: Option<model::Colour>,
}

/// An edge of the model as a polyline.
#[derive(Serialize, Tsify)]
pub struct Edge {
    /// Number within the part.
    edge: u32,
    /// Three numbers a point, relative to the part's centre.
    #[serde(with = "serde_wasm_bindgen::preserve")]
    #[tsify(type = "Float32Array<ArrayBuffer>")]
    points: Float32Array,
}

/// FNV-1a (Fowler, Noll, Vo), 64 bits.
struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    fn bytes(&mut self, bytes: &[u8]) {
        self.0 = bytes.iter().fold(self.0, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    }

    fn doubles(&mut self, numbers: &[f64]) {
        numbers.iter().for_each(|number| self.bytes(&number.to_le_bytes()));
    }
}
