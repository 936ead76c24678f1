//! A GLB that [`save_on`](super::save_on) wrote, back to triangles in millimetres and +Z up.

use super::file_triangles::{FileTriangle, bad, bytes_at};
use super::format::GlbOptions;
use super::node_place::groups;
use crate::control::{Alone, Call, Control};
use crate::mesh::{FrameView, SceneInstance};
use crate::model::FaceId;
use glam::{DMat3, DMat4, DQuat, DVec3, Mat4, Quat, Vec3};
use gltf_json::accessor::{ComponentType, GenericComponentType};
use gltf_json::buffer::View;
use gltf_json::mesh::{Mode, Semantic};
use gltf_json::validation::Checked::Valid;
use gltf_json::{Accessor, Index, Mesh, Node, Root, Value};
#[cfg(feature = "meshopt")]
use meshopt::{decode_filter_oct, decode_index_buffer, decode_index_sequence, decode_vertex_buffer};
use std::borrow::Cow;
use std::io;

/// How a reader takes the numbers of nodes, which JSON has as decimals.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Numbers {
    Single,
    Double,
}

/// The node of a level.
fn coarse<'a>(root: &'a Root, id: &Value) -> io::Result<(Index<Node>, &'a Node)> {
    let index = id.as_u64().and_then(|id| u32::try_from(id).ok()).map(Index::new);
    index.and_then(|index| Some((index, root.get(index)?))).ok_or_else(|| bad("a GLB without that level of detail"))
}

/// The transform of a node as stored in single precision. Products are in double precision, so that translations of
/// nested nodes add up.
fn single_matrix(node: &Node) -> DMat4 {
    if let Some(columns) = node.matrix {
        return Mat4::from_cols_array(&columns).as_dmat4();
    }
    let of = |numbers: Option<[f32; 3]>, default| numbers.map_or(default, |x| Vec3::from_array(x).as_dvec3());
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |rotation| Quat::from_array(rotation.0).as_dquat());
    placed(of(node.scale, DVec3::ONE), rotation, of(node.translation, DVec3::ZERO))
}

/// The transform of a node as its decimals say.
fn double_matrix(node: &Value) -> DMat4 {
    let numbers = |value: &Value, default: &[f64]| -> Vec<f64> {
        let found = value.as_array().map(|list| list.iter().map(|x| x.as_f64().unwrap_or(f64::NAN)).collect());
        found.filter(|list: &Vec<f64>| list.len() == default.len()).unwrap_or_else(|| default.to_vec())
    };
    if node["matrix"].is_array() {
        return DMat4::from_cols_slice(&numbers(&node["matrix"], &DMat4::IDENTITY.to_cols_array()));
    }
    placed(
        DVec3::from_slice(&numbers(&node["scale"], &[1.0; 3])),
        DQuat::from_slice(&numbers(&node["rotation"], &[0.0, 0.0, 0.0, 1.0])),
        DVec3::from_slice(&numbers(&node["translation"], &[0.0; 3])),
    )
}

/// A transform of which the rotation need not be of unit length to the last digit.
fn placed(scale: DVec3, rotation: DQuat, translation: DVec3) -> DMat4 {
    let turned = DMat3::from_quat(rotation) * DMat3::from_diagonal(scale);
    DMat4::from_translation(translation) * DMat4::from_mat3(turned)
}

/// A GLB with its views, decompressed.
pub(super) struct GlbFile<'a> {
    root: Root,
    /// The JSON again, with all digits of its numbers, and extensions that [`Root`] does not have.
    decimals: Value,
    views: Vec<Cow<'a, [u8]>>,
}

impl<'a> GlbFile<'a> {
    pub(super) fn open(bytes: &'a [u8]) -> io::Result<Self> {
        let json = u32::from_le_bytes(bytes_at(bytes, 12)?) as usize;
        let length = u32::from_le_bytes(bytes_at(bytes, 8)?) as usize;
        let text = bytes.get(20..20 + json).ok_or_else(|| bad("a GLB shorter than its header says"))?;
        if length != bytes.len() {
            return Err(bad("a GLB of another length than its header says"));
        }
        let root: Root = gltf_json::deserialize::from_slice(text)?;
        let decimals: Value = gltf_json::deserialize::from_slice(text)?;
        let data = bytes.get(28 + json..).unwrap_or_default();
        let view = |(view, index): (&View, usize)| {
            #[cfg(feature = "meshopt")]
            if let told @ Value::Object(_) = &decimals["bufferViews"][index]["extensions"]["EXT_meshopt_compression"] {
                return Ok(Cow::Owned(decompress(told, data)?));
            }
            #[cfg(not(feature = "meshopt"))]
            let _ = index;
            let offset = view.byte_offset.map_or(0, |offset| offset.0 as usize);
            let end = offset.checked_add(view.byte_length.0 as usize);
            let bytes = end.and_then(|end| data.get(offset..end));
            bytes.map(Cow::Borrowed).ok_or_else(|| bad("a GLB with a view beyond its data"))
        };
        let views = root.buffer_views.iter().zip(0..).map(view).collect::<io::Result<_>>()?;
        Ok(Self { root, decimals, views })
    }

    /// All triangles of a level, node by node. Faces are numbered as in `frame`, which was written with `with`.
    pub(super) fn triangles(
        &self,
        frame: &FrameView<'_>,
        (level, numbers): (usize, Numbers),
        with: (GlbOptions, f64),
    ) -> io::Result<Vec<FileTriangle>> {
        let Self { root, decimals, .. } = self;
        let matrix = |index: Index<Node>| match numbers {
            Numbers::Single => root.get(index).map_or(DMat4::IDENTITY, single_matrix),
            Numbers::Double => double_matrix(&decimals["nodes"][index.value()]),
        };
        let mut out = Vec::new();
        let top = root.scenes.first().and_then(|scene| scene.nodes.first());
        let (top, world) =
            top.and_then(|&top| Some((top, root.get(top)?))).ok_or_else(|| bad("a GLB without a scene"))?;
        let control = Control::default();
        for (&child, group) in world.children.iter().flatten().zip(groups(Call::new(&Alone, &control), frame, with)?) {
            let mut at = matrix(top);
            let mut node = Some(child);
            // An instance is a node, a node in nodes, or a row of a node's list.
            while let Some((index, here)) = node.and_then(|index| Some((index, root.get(index)?))) {
                let coarser = &decimals["nodes"][index.value()]["extensions"]["MSFT_lod"]["ids"];
                let (index, here) = match level.checked_sub(1).filter(|_| here.mesh.is_some()) {
                    Some(row) => coarse(root, &coarser[row])?,
                    None => (index, here),
                };
                at *= matrix(index);
                if let Some(mesh) = here.mesh {
                    let list = &decimals["nodes"][index.value()]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
                    for (k, (row, _)) in group.iter().enumerate() {
                        let placed = if list.is_null() { DMat4::IDENTITY } else { self.listed(list, k)? };
                        self.mesh(mesh, at * placed, &frame.scene.instances[*row], &mut out)?;
                    }
                }
                node = here.children.as_ref().and_then(|children| children.first().copied());
            }
        }
        Ok(out)
    }

    /// The transform of row `k` of a node's list.
    fn listed(&self, list: &Value, k: usize) -> io::Result<DMat4> {
        let values = |name: &str| {
            let index = list[name].as_u64().map(|index| Index::<Accessor>::new(index as u32));
            self.values(index).ok_or_else(|| bad("a GLB with a list without numbers"))
        };
        let (scales, by, to) = (values("SCALE")?, values("ROTATION")?, values("TRANSLATION")?);
        let rotation = DQuat::from_vec4(by.vector(k)?.extend(by.number(k, 3)?));
        Ok(placed(scales.vector(k)?, rotation, to.vector(k)?))
    }

    fn mesh(
        &self,
        mesh: Index<Mesh>,
        at: DMat4,
        instance: &SceneInstance,
        out: &mut Vec<FileTriangle>,
    ) -> io::Result<()> {
        let mesh = self.root.get(mesh).ok_or_else(|| bad("a GLB with a node of no mesh"))?;
        let mirrored = at.determinant() < 0.0;
        for primitive in mesh.primitives.iter().filter(|primitive| primitive.mode == Valid(Mode::Triangles)) {
            let attribute = |semantic: Semantic| {
                let values = self.values(primitive.attributes.get(&Valid(semantic)).copied());
                values.ok_or_else(|| bad("a GLB without an attribute"))
            };
            let (points, faces) =
                (attribute(Semantic::Positions)?, attribute(Semantic::Extras("FEATURE_ID_0".into()))?);
            let indices = self.values(primitive.indices).ok_or_else(|| bad("a GLB without indices"))?;
            for row in 0..indices.count / 3 {
                let corner = |k: usize| Ok::<_, io::Error>(indices.number(3 * row + k, 0)? as usize);
                let [a, b, c] =
                    [corner(0)?, corner(if mirrored { 2 } else { 1 })?, corner(if mirrored { 1 } else { 2 })?];
                let place = |index: usize| {
                    let DVec3 { x, y, z } = at.transform_point3(points.vector(index)?);
                    // From metres and +Y up.
                    Ok::<_, io::Error>(DVec3::new(x, -z, y) * 1e3)
                };
                let face = instance.face_number(FaceId(faces.number(a, 0)? as u32));
                out.push(FileTriangle { face, corners: [place(a)?, place(b)?, place(c)?] });
            }
        }
        Ok(())
    }

    fn values(&self, accessor: Option<Index<Accessor>>) -> Option<Values<'_>> {
        let accessor = self.root.get(accessor?)?;
        let index = accessor.buffer_view?;
        let Valid(GenericComponentType(component)) = accessor.component_type else { return None };
        let Valid(kind) = accessor.type_ else { return None };
        let tight = component.size() * kind.multiplicity();
        let stride = self.root.get(index)?.byte_stride.map_or(tight, |stride| stride.0);
        let start = accessor.byte_offset.map_or(0, |offset| offset.0 as usize);
        let bytes = self.views.get(index.value())?.get(start..)?;
        Some(Values { bytes, stride, component, count: accessor.count.0 as usize })
    }
}

/// The values of an accessor.
struct Values<'a> {
    bytes: &'a [u8],
    stride: usize,
    component: ComponentType,
    count: usize,
}

impl Values<'_> {
    /// Component `axis` of value `k`.
    fn number(&self, k: usize, axis: usize) -> io::Result<f64> {
        if k >= self.count {
            return Err(bad("a GLB with an index out of range"));
        }
        let at = self.stride * k + self.component.size() * axis;
        Ok(match self.component {
            ComponentType::F32 => f64::from(f32::from_le_bytes(bytes_at(self.bytes, at)?)),
            ComponentType::U32 => f64::from(u32::from_le_bytes(bytes_at(self.bytes, at)?)),
            ComponentType::U16 => f64::from(u16::from_le_bytes(bytes_at(self.bytes, at)?)),
            ComponentType::I16 => f64::from(i16::from_le_bytes(bytes_at(self.bytes, at)?)),
            ComponentType::I8 | ComponentType::U8 => return Err(bad("a GLB with numbers of one byte")),
        })
    }

    /// The first three components of value `k`.
    fn vector(&self, k: usize) -> io::Result<DVec3> {
        Ok(DVec3::new(self.number(k, 0)?, self.number(k, 1)?, self.number(k, 2)?))
    }
}

/// Decompresses what a view's extension describes.
#[cfg(feature = "meshopt")]
fn decompress(extension: &Value, data: &[u8]) -> io::Result<Vec<u8>> {
    let number = |name: &str| extension[name].as_u64().map_or(0, |number| number as usize);
    let (offset, length, stride, count) =
        (number("byteOffset"), number("byteLength"), number("byteStride"), number("count"));
    let encoded = offset.checked_add(length).and_then(|end| data.get(offset..end));
    let encoded = encoded.ok_or_else(|| bad("a GLB with a view beyond its data"))?;
    let decoded = match (extension["mode"].as_str(), stride) {
        (Some("TRIANGLES"), 2) => decode_index_buffer::<u16>(encoded, count).map(short),
        (Some("TRIANGLES"), _) => decode_index_buffer::<u32>(encoded, count).map(long),
        (Some("INDICES"), 2) => decode_index_sequence::<u16>(encoded, count).map(short),
        (Some("INDICES"), _) => decode_index_sequence::<u32>(encoded, count).map(long),
        (_, 4) => decode_vertex_buffer::<[u8; 4]>(encoded, count).map(|rows| rows.as_flattened().to_vec()),
        (_, 8) if extension["filter"] == "OCTAHEDRAL" => decode_vertex_buffer::<[i16; 4]>(encoded, count).map(normals),
        (_, 8) => decode_vertex_buffer::<[u8; 8]>(encoded, count).map(|rows| rows.as_flattened().to_vec()),
        (_, 12) => decode_vertex_buffer::<[u8; 12]>(encoded, count).map(|rows| rows.as_flattened().to_vec()),
        _ => decode_vertex_buffer::<[u8; 16]>(encoded, count).map(|rows| rows.as_flattened().to_vec()),
    };
    decoded.map_err(|_| bad("a GLB with a view that cannot be decompressed"))
}

#[cfg(feature = "meshopt")]
fn short(words: Vec<u16>) -> Vec<u8> {
    words.into_iter().flat_map(u16::to_le_bytes).collect()
}

#[cfg(feature = "meshopt")]
fn long(words: Vec<u32>) -> Vec<u8> {
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

#[cfg(feature = "meshopt")]
fn normals(mut rows: Vec<[i16; 4]>) -> Vec<u8> {
    decode_filter_oct(&mut rows);
    rows.into_iter().flatten().flat_map(i16::to_le_bytes).collect()
}
