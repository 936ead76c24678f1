//! A frame to binary glTF 2.0: metres, +Y up, one mesh per part, one node per instance, one primitive per colour.
//!
//! Positions are single precision relative to the centre of the part's bounding box, which the node's translation adds
//! back, so parts far from the origin keep their precision. Where one translation has too few digits for the tolerance,
//! nested nodes add up to the place. Each vertex stores the index of its face in `_FEATURE_ID_0`
//! (EXT_mesh_features). B-rep edges are lines whose points store the index of the edge.

use super::colour;
use super::node_place::{NodePlace, local};
use super::placed::{batches_by_part, by_part, distinct, instance_name};
use super::single::BeyondSingle;
use crate::mesh::{BatchView, EdgeLine, FrameView, ScenePart};
use crate::model::Colour;
use glam::{DVec3, Vec3};
use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Stride, Target, View};
use gltf_json::material::{AlphaMode, PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked::Valid;
use gltf_json::validation::USize64;
use gltf_json::{Accessor, Asset, Buffer, Index, Material, Mesh, Node, Root, Scene, Value};
use std::collections::{BTreeMap, HashMap};
use std::io::{self, Write};

/// Rotation from +Z up to +Y up, by columns.
const Y_UP: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
/// The colour of B-rep edges.
const EDGE_COLOUR: Colour = [0.08, 0.09, 0.1, 1.0];
/// Meshes of up to this many vertices use 16-bit indices. The largest 16-bit value is reserved for primitive restart.
const SHORT_VERTICES: usize = 65_535;

/// Writes a frame as binary glTF. Each part is stored once and placed by nodes.
///
/// An instance with its own colour gets its own mesh, which shares the part's data. Triangles whose rounded corners
/// coincide are left out.
///
/// # Errors
/// I/O errors of `file`. More than 4 GiB of data, or a position [beyond single precision](BeyondSingle); nothing is
/// written then.
pub fn write_glb<'a>(frame: impl Into<FrameView<'a>>, file: &mut impl Write) -> io::Result<()> {
    write_glb_within(&frame.into(), f64::INFINITY, file)
}

/// As [`write_glb`]. A node whose translation is rounded by more than half of `most` millimetres is put into others, and
/// the translations add up to the place.
pub(super) fn write_glb_within(frame: &FrameView<'_>, most: f64, file: &mut impl Write) -> io::Result<()> {
    let mut glb = Glb::default();
    let mut shapes = Vec::new();
    for ((part, batches), lines) in
        frame.scene.parts.iter().zip(batches_by_part(frame)).zip(by_part(frame, frame.edge_lines, |line| line.part))
    {
        shapes.push(glb.shape(part, &batches, &lines)?);
    }
    let mut meshes = HashMap::new();
    let mut children = Vec::new();
    for instance in &frame.scene.instances {
        let place = instance.part.index();
        if let (Some(part), Some(shape)) = (frame.scene.parts.get(place), shapes.get(place)) {
            let key = (instance.part, instance.colour.map(|colour| colour.map(f32::to_bits)));
            let mesh = match meshes.get(&key) {
                Some(mesh) => *mesh,
                None => *meshes.entry(key).or_insert(glb.mesh(part, shape, instance.colour)),
            };
            let name = named(instance_name(&part.name, instance));
            children.push(glb.node(&NodePlace::new(part, instance, most)?, name, mesh));
        }
    }
    let world = glb.root.push(Node {
        name: named(&frame.scene.name),
        matrix: Some(Y_UP),
        children: (!children.is_empty()).then_some(children),
        ..Node::default()
    });
    let scene = Scene { extensions: None, extras: None, name: named(&frame.scene.name), nodes: vec![world] };
    glb.root.scene = Some(glb.root.push(scene));
    glb.write(file)
}

/// The bytes of one buffer view, and its accessors.
#[derive(Default)]
struct Pool {
    bytes: Vec<u8>,
    accessors: Vec<Index<Accessor>>,
}

/// The primitives of a part without materials, shared by its colour variants.
struct PartShape {
    faces: Vec<(Option<Colour>, Primitive)>,
    edges: Option<Primitive>,
}

#[derive(Default)]
struct Glb {
    root: Root,
    materials: HashMap<[u32; 4], Index<Material>>,
    /// Vec3 floats.
    vectors: Pool,
    /// Float scalars.
    features: Pool,
    long_indices: Pool,
    short_indices: Pool,
}

impl Glb {
    fn shape(&mut self, part: &ScenePart, batches: &[&BatchView<'_>], lines: &[&EdgeLine]) -> io::Result<PartShape> {
        let round = |points: &[DVec3]| -> Result<Vec<Vec3>, BeyondSingle> {
            points.iter().map(|&point| local(part, point)).collect()
        };
        let mut groups: Vec<(Option<Colour>, Vec<&BatchView<'_>>)> = Vec::new();
        let mut of_colour = HashMap::new();
        for batch in batches {
            let colour = part.face_colours.get(batch.face.index()).copied().flatten();
            let group = *of_colour.entry(colour.map(|colour| colour.map(f32::to_bits))).or_insert_with(|| {
                groups.push((colour, Vec::new()));
                groups.len() - 1
            });
            groups[group].1.push(batch);
        }
        let mut faces = Vec::new();
        for (colour, batches) in groups {
            let mut vertices = Vertices::default();
            let mut normals = Vec::new();
            for batch in batches {
                let base = vertices.positions.len() as u32;
                let rounded = round(batch.mesh.positions)?;
                let kept = vertices.indices.len();
                vertices.indices.extend(distinct(&batch.mesh, &rounded).flatten().map(|corner| base + corner));
                if vertices.indices.len() > kept {
                    normals.extend((0..rounded.len()).map(|index| {
                        let normal = batch.mesh.normals.get(index).copied().unwrap_or_default();
                        normal.as_dvec3().normalize_or(DVec3::Z).as_vec3()
                    }));
                    vertices.add(&rounded, batch.face.0);
                }
            }
            if !vertices.indices.is_empty() {
                let normals = Some(normals.as_slice());
                faces.push((colour, self.primitive(&vertices, normals, Mode::Triangles, "face")?));
            }
        }
        let mut vertices = Vertices::default();
        for line in lines {
            let base = vertices.positions.len() as u32;
            let rounded = round(&line.points)?;
            let segments = (1..rounded.len()).filter(|&end| rounded[end - 1] != rounded[end]);
            vertices.indices.extend(segments.flat_map(|end| [base + end as u32 - 1, base + end as u32]));
            vertices.add(&rounded, line.edge.0);
        }
        let edges = if vertices.indices.is_empty() {
            None
        } else {
            Some(self.primitive(&vertices, None, Mode::Lines, "edge")?)
        };
        Ok(PartShape { faces, edges })
    }

    fn primitive(
        &mut self,
        vertices: &Vertices,
        normals: Option<&[Vec3]>,
        mode: Mode,
        label: &str,
    ) -> io::Result<Primitive> {
        let count = vertices.positions.len();
        let (low, high) = vertices
            .positions
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &point| (low.min(point), high.max(point)));
        let bounds = |corner: Vec3| Some(Value::from(corner.to_array().to_vec()));
        let Self { root, vectors, features, .. } = self;
        let positions = vectors.push(root, floats(&vertices.positions), count, ComponentType::F32, Type::Vec3);
        root.accessors[positions.value()].min = bounds(low);
        root.accessors[positions.value()].max = bounds(high);
        let ids = vertices.features.iter().map(|feature| *feature as f32).flat_map(f32::to_le_bytes);
        let ids = features.push(root, ids, count, ComponentType::F32, Type::Scalar);
        let mut attributes = BTreeMap::from([
            (Valid(Semantic::Positions), positions),
            (Valid(Semantic::Extras("FEATURE_ID_0".into())), ids),
        ]);
        if let Some(normals) = normals {
            let normals = vectors.push(root, floats(normals), count, ComponentType::F32, Type::Vec3);
            attributes.insert(Valid(Semantic::Normals), normals);
        }
        let indices = &vertices.indices;
        let indices = if count <= SHORT_VERTICES {
            let bytes = indices.iter().flat_map(|&index| (index as u16).to_le_bytes());
            self.short_indices.push(root, bytes, indices.len(), ComponentType::U16, Type::Scalar)
        } else {
            let bytes = indices.iter().flat_map(|&index| index.to_le_bytes());
            self.long_indices.push(root, bytes, indices.len(), ComponentType::U32, Type::Scalar)
        };
        let mut distinct = vertices.features.clone();
        distinct.sort_unstable();
        distinct.dedup();
        let extensions = gltf_json::deserialize::from_str(&format!(
            r#"{{"EXT_mesh_features":{{"featureIds":[{{"featureCount":{},"attribute":0,"label":"{label}"}}]}}}}"#,
            distinct.len()
        ))?;
        Ok(Primitive {
            attributes,
            extensions: Some(extensions),
            extras: None,
            indices: Some(indices),
            material: None,
            mode: Valid(mode),
            targets: None,
        })
    }

    fn material(&mut self, colour: Colour) -> Index<Material> {
        let Self { root, materials, .. } = self;
        *materials.entry(colour.map(f32::to_bits)).or_insert_with(|| {
            let linear = colour::linear(colour);
            root.push(Material {
                alpha_mode: Valid(if linear[3] < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque }),
                double_sided: true, // sheets show both sides, and files may contain reversed faces
                pbr_metallic_roughness: PbrMetallicRoughness {
                    base_color_factor: PbrBaseColorFactor(linear),
                    metallic_factor: StrengthFactor(0.0),
                    roughness_factor: StrengthFactor(0.5),
                    ..PbrMetallicRoughness::default()
                },
                ..Material::default()
            })
        })
    }

    /// Adds the part's mesh, in its own colours or all in `colour`. `None` if it is empty.
    fn mesh(&mut self, part: &ScenePart, shape: &PartShape, colour: Option<Colour>) -> Option<Index<Mesh>> {
        let mut primitives = Vec::new();
        for (own, primitive) in &shape.faces {
            let material = self.material(colour.or(*own).unwrap_or(colour::DEFAULT));
            primitives.push(Primitive { material: Some(material), ..primitive.clone() });
        }
        if let Some(edges) = &shape.edges {
            let material = self.material(EDGE_COLOUR);
            primitives.push(Primitive { material: Some(material), ..edges.clone() });
        }
        if primitives.is_empty() {
            return None;
        }
        let mesh = Mesh { extensions: None, extras: None, name: named(&part.name), primitives, weights: None };
        Some(self.root.push(mesh))
    }

    /// Adds the node of an instance, and those around it where one translation has too few digits.
    fn node(&mut self, place: &NodePlace, name: Option<String>, mesh: Option<Index<Mesh>>) -> Index<Node> {
        let node = Node { name, mesh, ..Node::default() };
        let inner = self.root.push(match place.matrix() {
            Some(matrix) => Node { matrix: Some(matrix), ..node },
            None => Node { translation: Some(place.centre.to_array()), ..node },
        });
        place.around.iter().rev().fold(inner, |inner, around| {
            let (translation, children) = (Some(around.to_array()), Some(vec![inner]));
            self.root.push(Node { translation, children, ..Node::default() })
        })
    }

    fn write(mut self, file: &mut impl Write) -> io::Result<()> {
        self.root.asset =
            Asset { generator: Some(concat!("trimtess ", env!("CARGO_PKG_VERSION")).into()), ..Asset::default() };
        // This order keeps every pool aligned: 16-bit indices come last.
        let pools = [
            (self.vectors, Some(12), Target::ArrayBuffer),
            (self.features, Some(4), Target::ArrayBuffer),
            (self.long_indices, None, Target::ElementArrayBuffer),
            (self.short_indices, None, Target::ElementArrayBuffer),
        ];
        let total: u64 = pools.iter().map(|(pool, ..)| pool.bytes.len() as u64).sum();
        let padding = (total.next_multiple_of(4) - total) as usize;
        let mut offset = 0_u64;
        for (pool, stride, target) in &pools {
            if pool.bytes.is_empty() {
                continue;
            }
            let view = self.root.push(View {
                buffer: Index::new(0),
                byte_length: USize64(pool.bytes.len() as u64),
                byte_offset: Some(USize64(offset)),
                byte_stride: stride.map(Stride),
                name: None,
                target: Some(Valid(*target)),
                extensions: None,
                extras: None,
            });
            for accessor in &pool.accessors {
                self.root.accessors[accessor.value()].buffer_view = Some(view);
            }
            offset += pool.bytes.len() as u64;
        }
        if total > 0 {
            self.root.extensions_used = vec!["EXT_mesh_features".into()];
            let byte_length = USize64(total);
            self.root.push(Buffer { byte_length, name: None, uri: None, extensions: None, extras: None });
        }
        let mut json = self.root.to_vec()?;
        json.resize(json.len().next_multiple_of(4), b' ');
        let binary = total + padding as u64;
        let chunk = if total > 0 { 8 + binary } else { 0 };
        let length = 12 + 8 + json.len() as u64 + chunk;
        let length = u32::try_from(length)
            .map_err(|_| io::Error::other(format!("{length} bytes exceed the glTF limit of {}", u32::MAX)))?;
        file.write_all(b"glTF")?;
        for word in [2, length, json.len() as u32] {
            file.write_all(&word.to_le_bytes())?;
        }
        file.write_all(b"JSON")?;
        file.write_all(&json)?;
        if total > 0 {
            file.write_all(&(binary as u32).to_le_bytes())?;
            file.write_all(b"BIN\0")?;
            for (pool, ..) in &pools {
                file.write_all(&pool.bytes)?;
            }
            file.write_all(&[0; 3][..padding])?;
        }
        Ok(())
    }
}

impl Pool {
    fn push(
        &mut self,
        root: &mut Root,
        bytes: impl Iterator<Item = u8>,
        count: usize,
        component: ComponentType,
        kind: Type,
    ) -> Index<Accessor> {
        let offset = self.bytes.len() as u64;
        self.bytes.extend(bytes);
        let accessor = root.push(Accessor {
            buffer_view: None, // set by `write`, once all pools are full
            byte_offset: Some(USize64(offset)),
            count: USize64(count as u64),
            component_type: Valid(GenericComponentType(component)),
            extensions: None,
            extras: None,
            type_: Valid(kind),
            min: None,
            max: None,
            name: None,
            normalized: false,
            sparse: None,
        });
        self.accessors.push(accessor);
        accessor
    }
}

/// One primitive's vertices.
#[derive(Default)]
struct Vertices {
    positions: Vec<Vec3>,
    features: Vec<u32>,
    indices: Vec<u32>,
}

impl Vertices {
    fn add(&mut self, positions: &[Vec3], feature: u32) {
        self.positions.extend_from_slice(positions);
        self.features.resize(self.positions.len(), feature);
    }
}

fn floats(vectors: &[Vec3]) -> impl Iterator<Item = u8> {
    vectors.iter().flat_map(Vec3::to_array).flat_map(f32::to_le_bytes)
}

fn named(name: &str) -> Option<String> {
    (!name.is_empty()).then(|| name.to_owned())
}
