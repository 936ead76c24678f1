//! A GLB that [`write_glb`](super::write_glb) wrote, back to triangles in millimetres and +Z up.

use super::bytes::{FileTriangle, bad, bytes_at, vector};
use crate::mesh::FrameView;
use glam::{DMat4, DVec3, Mat4, Vec3};
use gltf_json::accessor::ComponentType;
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked::Valid;
use gltf_json::{Accessor, Index, Mesh, Node, Root, Value};
use std::io;

/// How a reader takes the numbers of nodes, which JSON has as decimals.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Numbers {
    Single,
    Double,
}

/// Reads all triangles, instance by instance. Faces are numbered as in `frame`.
pub(super) fn read_glb(frame: &FrameView<'_>, bytes: &[u8], numbers: Numbers) -> io::Result<Vec<FileTriangle>> {
    let json = u32::from_le_bytes(bytes_at(bytes, 12)?) as usize;
    let length = u32::from_le_bytes(bytes_at(bytes, 8)?) as usize;
    let text = bytes.get(20..20 + json).ok_or_else(|| bad("a GLB shorter than its header says"))?;
    if length != bytes.len() {
        return Err(bad("a GLB of another length than its header says"));
    }
    let root: Root = gltf_json::deserialize::from_slice(text)?;
    let decimals: Value = gltf_json::deserialize::from_slice(text)?;
    let glb = File { root: &root, data: bytes.get(28 + json..).unwrap_or_default() };
    let matrix = |index: Index<Node>| match numbers {
        Numbers::Single => root.get(index).map_or(DMat4::IDENTITY, single_matrix),
        Numbers::Double => double_matrix(&decimals["nodes"][index.value()]),
    };
    let mut out = Vec::new();
    let top = root.scenes.first().and_then(|scene| scene.nodes.first());
    let (top, world) = top.and_then(|&top| Some((top, root.get(top)?))).ok_or_else(|| bad("a GLB without a scene"))?;
    let known = frame.scene.instances.iter().filter(|instance| instance.part.index() < frame.scene.parts.len());
    for (&child, instance) in world.children.iter().flatten().zip(known) {
        let mut at = matrix(top);
        let mut node = Some(child);
        // An instance is a node, or a node in nodes.
        while let Some((index, here)) = node.and_then(|index| Some((index, root.get(index)?))) {
            at *= matrix(index);
            if let Some(mesh) = here.mesh {
                glb.mesh(mesh, at, u64::from(instance.first_face), &mut out)?;
            }
            node = here.children.as_ref().and_then(|children| children.first().copied());
        }
    }
    Ok(out)
}

/// The transform of a node as stored in single precision. Products are in double precision, so that translations of
/// nested nodes add up.
fn single_matrix(node: &Node) -> DMat4 {
    match (node.matrix, node.translation) {
        (Some(columns), _) => Mat4::from_cols_array(&columns).as_dmat4(),
        (None, Some(translation)) => DMat4::from_translation(Vec3::from_array(translation).as_dvec3()),
        (None, None) => DMat4::IDENTITY,
    }
}

/// The transform of a node as its decimals say.
fn double_matrix(node: &Value) -> DMat4 {
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    match (&node["matrix"], &node["translation"]) {
        (Value::Array(columns), _) if columns.len() == 16 => {
            DMat4::from_cols_array(&std::array::from_fn(|k| number(&columns[k])))
        }
        (_, Value::Array(to)) if to.len() == 3 => {
            DMat4::from_translation(DVec3::from_array(std::array::from_fn(|k| number(&to[k]))))
        }
        _ => DMat4::IDENTITY,
    }
}

struct File<'a> {
    root: &'a Root,
    data: &'a [u8],
}

impl File<'_> {
    fn mesh(&self, mesh: Index<Mesh>, at: DMat4, first: u64, out: &mut Vec<FileTriangle>) -> io::Result<()> {
        let mesh = self.root.get(mesh).ok_or_else(|| bad("a GLB with a node of no mesh"))?;
        let mirrored = at.determinant() < 0.0;
        for primitive in mesh.primitives.iter().filter(|primitive| primitive.mode == Valid(Mode::Triangles)) {
            let (points, faces) = (self.accessor(primitive, &Semantic::Positions)?, self.faces(primitive)?);
            let indices = self.indices(primitive)?;
            for row in indices.chunks_exact(3) {
                let place = |index: usize| {
                    let point = vector(self.data, points.0 + 12 * index)?;
                    let DVec3 { x, y, z } = at.transform_point3(point.as_dvec3());
                    // From metres and +Y up.
                    Ok::<_, io::Error>(DVec3::new(x, -z, y) * 1e3)
                };
                let [a, b, c] = if mirrored { [row[0], row[2], row[1]] } else { [row[0], row[1], row[2]] };
                if row.iter().any(|&index| index >= points.1) {
                    return Err(bad("a GLB with an index out of range"));
                }
                let face = f32::from_le_bytes(bytes_at(self.data, faces.0 + 4 * a)?);
                out.push(FileTriangle { face: first + face as u64, corners: [place(a)?, place(b)?, place(c)?] });
            }
        }
        Ok(())
    }

    fn faces(&self, primitive: &Primitive) -> io::Result<(usize, usize)> {
        self.accessor(primitive, &Semantic::Extras("FEATURE_ID_0".into()))
    }

    /// Offset and number of an attribute's values.
    fn accessor(&self, primitive: &Primitive, semantic: &Semantic) -> io::Result<(usize, usize)> {
        let accessor = primitive.attributes.get(&Valid(semantic.clone())).and_then(|index| self.root.get(*index));
        accessor.and_then(|accessor| self.place(accessor)).ok_or_else(|| bad("a GLB without an attribute"))
    }

    fn place(&self, accessor: &Accessor) -> Option<(usize, usize)> {
        let view = self.root.get(accessor.buffer_view?)?;
        let offset = view.byte_offset.map_or(0, |offset| offset.0) + accessor.byte_offset.map_or(0, |offset| offset.0);
        Some((offset as usize, accessor.count.0 as usize))
    }

    fn indices(&self, primitive: &Primitive) -> io::Result<Vec<usize>> {
        let accessor = primitive.indices.and_then(|index| self.root.get(index));
        let found = accessor.and_then(|accessor| Some((accessor, self.place(accessor)?)));
        let (accessor, (offset, count)) = found.ok_or_else(|| bad("a GLB without indices"))?;
        let long = matches!(accessor.component_type, Valid(kind) if kind.0 == ComponentType::U32);
        let index = |k: usize| {
            Ok(if long {
                u32::from_le_bytes(bytes_at(self.data, offset + 4 * k)?) as usize
            } else {
                usize::from(u16::from_le_bytes(bytes_at(self.data, offset + 2 * k)?))
            })
        };
        (0..count).map(index).collect()
    }
}
