//! GLB files read back: chunks, JSON valid by the format's rules, and the bytes behind every accessor.
#![cfg(feature = "glb")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod folders;
mod out_fixture;

use folders::folder;
use glam::{DAffine3, DMat4, DVec3, Mat4, Vec3};
use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::{Checked, Validate};
use gltf_json::{Index, Root};
use out_fixture::box_frame;
use std::collections::BTreeSet;
use std::fs;
use trimtess::control::{Alone, Control};
use trimtess::mesh::MemorySink;
use trimtess::model::{EdgeId, FaceId};
use trimtess::out::{Format, GlbOptions, SaveOptions, save, write, write_on};

struct Glb {
    root: Root,
    binary: Vec<u8>,
}

const PLAIN: Format = Format::Glb(GlbOptions::PLAIN);

fn written(frame: &MemorySink) -> Glb {
    let mut bytes = Vec::new();
    write(frame, &mut bytes, PLAIN).unwrap();
    read(&bytes)
}

fn read(bytes: &[u8]) -> Glb {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!(&bytes[..4], b"glTF");
    assert_eq!((word(4), word(8)), (2, bytes.len()));
    let json_end = 20 + word(12);
    assert_eq!(&bytes[16..20], b"JSON");
    assert_eq!(json_end % 4, 0);
    let root = Root::from_slice(&bytes[20..json_end]).unwrap();
    let binary = if json_end == bytes.len() {
        Vec::new()
    } else {
        assert_eq!(&bytes[json_end + 4..json_end + 8], b"BIN\0");
        assert_eq!(json_end + 8 + word(json_end), bytes.len());
        bytes[json_end + 8..].to_vec()
    };
    let mut faults = Vec::new();
    root.validate(&root, gltf_json::Path::new, &mut |path, error| faults.push(format!("{} {error:?}", path())));
    assert!(faults.is_empty(), "{faults:?}");
    let glb = Glb { root, binary };
    glb.check_layout();
    glb
}

impl Glb {
    /// Asserts that views lie inside the buffer and accessors inside their views, and that all are aligned.
    fn check_layout(&self) {
        for view in &self.root.buffer_views {
            let (start, length) = (view.byte_offset.unwrap().0, view.byte_length.0);
            assert!(start % 4 == 0 && length > 0 && (start + length) as usize <= self.binary.len());
        }
        for accessor in &self.root.accessors {
            let view = &self.root.buffer_views[accessor.buffer_view.unwrap().value()];
            let Checked::Valid(GenericComponentType(component)) = accessor.component_type else { panic!() };
            let Checked::Valid(kind) = accessor.type_ else { panic!() };
            let element = component.size() * kind.multiplicity();
            let stride = view.byte_stride.map_or(element, |stride| stride.0);
            let offset = accessor.byte_offset.unwrap().0 as usize;
            assert_eq!(offset % component.size(), 0);
            assert!(accessor.count.0 > 0);
            assert!(offset + stride * (accessor.count.0 as usize - 1) + element <= view.byte_length.0 as usize);
        }
    }

    fn bytes(&self, accessor: usize) -> (&[u8], ComponentType, Type) {
        let accessor = &self.root.accessors[accessor];
        let view = &self.root.buffer_views[accessor.buffer_view.unwrap().value()];
        let start = (view.byte_offset.unwrap().0 + accessor.byte_offset.unwrap().0) as usize;
        let Checked::Valid(GenericComponentType(component)) = accessor.component_type else { panic!() };
        let Checked::Valid(kind) = accessor.type_ else { panic!() };
        let length = component.size() * kind.multiplicity() * accessor.count.0 as usize;
        (&self.binary[start..start + length], component, kind)
    }

    fn floats(&self, primitive: &Primitive, semantic: Semantic) -> Vec<f32> {
        let (bytes, component, _) = self.bytes(primitive.attributes[&Checked::Valid(semantic)].value());
        assert_eq!(component, ComponentType::F32);
        bytes.chunks(4).map(|chunk| f32::from_le_bytes(chunk.try_into().unwrap())).collect()
    }

    fn vectors(&self, primitive: &Primitive, semantic: Semantic) -> Vec<Vec3> {
        self.floats(primitive, semantic).chunks(3).map(Vec3::from_slice).collect()
    }

    fn indices(&self, primitive: &Primitive) -> Vec<u32> {
        let (bytes, component, _) = self.bytes(primitive.indices.unwrap().value());
        match component {
            ComponentType::U16 => {
                bytes.chunks(2).map(|chunk| u32::from(u16::from_le_bytes(chunk.try_into().unwrap()))).collect()
            }
            ComponentType::U32 => bytes.chunks(4).map(|chunk| u32::from_le_bytes(chunk.try_into().unwrap())).collect(),
            other => panic!("{other:?}"),
        }
    }

    /// The instance nodes with their world transforms.
    fn nodes(&self) -> Vec<(&gltf_json::Node, Mat4)> {
        let scene = &self.root.scenes[self.root.scene.unwrap().value()];
        let top = &self.root.nodes[scene.nodes[0].value()];
        let local = |node: &gltf_json::Node| match node.matrix {
            Some(matrix) => Mat4::from_cols_array(&matrix),
            None => Mat4::from_translation(node.translation.map_or(Vec3::ZERO, Vec3::from_array)),
        };
        let children = top.children.iter().flatten().map(|child| &self.root.nodes[child.value()]);
        children.map(|node| (node, local(top) * local(node))).collect()
    }
}

fn feature() -> Semantic {
    Semantic::Extras("FEATURE_ID_0".into())
}

#[test]
fn one_mesh_per_part_one_primitive_per_colour() {
    let glb = written(&box_frame(DVec3::splat(1000.0), &[DAffine3::IDENTITY; 3]));
    assert_eq!(glb.root.meshes.len(), 1);
    assert_eq!(glb.nodes().len(), 3);
    let mesh = &glb.root.meshes[0];
    assert_eq!(mesh.name.as_deref(), Some("box"));
    assert_eq!(glb.nodes()[2].0.name.as_deref(), Some("box 2"));
    let modes: Vec<_> = mesh.primitives.iter().map(|primitive| primitive.mode.unwrap()).collect();
    assert_eq!(modes, [Mode::Triangles, Mode::Triangles, Mode::Lines]);
    let [red, grey, lines] = mesh.primitives.as_slice() else { panic!() };
    assert_eq!(glb.floats(red, feature()), [0.0; 4]);
    assert_eq!(glb.floats(grey, feature()), [1, 2, 3, 4, 5].map(|face| [face as f32; 4]).as_flattened());
    assert_eq!(glb.floats(lines, feature()), [0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0]);
    assert_eq!(glb.indices(grey).len(), 30);
    assert_eq!(glb.indices(lines), (0..8).collect::<Vec<_>>());
    let features = gltf_json::serialize::to_string(&grey.extensions).unwrap();
    assert_eq!(features, r#"{"EXT_mesh_features":{"featureIds":[{"attribute":0,"featureCount":5,"label":"face"}]}}"#);
    assert_eq!(glb.root.extensions_used, ["EXT_mesh_features"]);
    let material = |primitive: &Primitive| &glb.root.materials[primitive.material.unwrap().value()];
    assert_eq!(material(red).pbr_metallic_roughness.base_color_factor.0, [1.0, 0.0, 0.0, 1.0]);
}

#[test]
fn positions_are_metres_about_the_centre_and_bounds_are_exact() {
    let glb = written(&box_frame(DVec3::new(1000.0, 200.0, 30.0), &[DAffine3::IDENTITY]));
    for primitive in &glb.root.meshes[0].primitives {
        let positions = glb.vectors(primitive, Semantic::Positions);
        assert!(positions.iter().all(|p| p.abs() == Vec3::new(0.5, 0.1, 0.015)), "{positions:?}");
        let accessor = &glb.root.accessors[primitive.attributes[&Checked::Valid(Semantic::Positions)].value()];
        let bound = |value: &Option<gltf_json::Value>| -> [f32; 3] {
            gltf_json::deserialize::from_value(value.clone().unwrap()).unwrap()
        };
        let low = positions.iter().fold(Vec3::INFINITY, |low, &p| low.min(p));
        let high = positions.iter().fold(Vec3::NEG_INFINITY, |high, &p| high.max(p));
        assert_eq!((bound(&accessor.min), bound(&accessor.max)), (low.to_array(), high.to_array()));
    }
}

#[test]
fn nodes_turn_z_up_into_y_up() {
    let placement = DAffine3::from_rotation_z(0.5) * DAffine3::from_translation(DVec3::new(3000.0, 20.0, 100.0));
    let size = DVec3::new(1000.0, 200.0, 30.0);
    let glb = written(&box_frame(size, &[DAffine3::IDENTITY, placement]));
    let y_up = DMat4::from_cols(DVec3::X.extend(0.0), DVec3::NEG_Z.extend(0.0), DVec3::Y.extend(0.0), glam::DVec4::W);
    for (index, expected) in [DAffine3::IDENTITY, placement].into_iter().enumerate() {
        let (node, world) = glb.nodes()[index];
        let primitive = &glb.root.meshes[node.mesh.unwrap().value()].primitives[0];
        let origin = glb.vectors(primitive, Semantic::Positions)[0]; // face 0 begins at corner 0
        let found = world.transform_point3(origin).as_dvec3() * 1000.0;
        let wanted = y_up.transform_point3(expected.transform_point3(DVec3::ZERO));
        assert!(found.distance(wanted) < 1e-3, "{found} {wanted}");
        let normal = world.transform_vector3(glb.vectors(primitive, Semantic::Normals)[0]);
        assert!(normal.distance(Vec3::NEG_Y) < 1e-6, "the bottom looks down");
    }
}

#[test]
fn an_instance_colour_makes_a_variant_that_shares_the_data() {
    let mut frame = box_frame(DVec3::ONE, &[DAffine3::IDENTITY; 3]);
    frame.scene.instances[1].colour = Some([0.0, 0.0, 1.0, 0.5]);
    frame.scene.instances[2].colour = Some([0.0, 0.0, 1.0, 0.5]);
    let glb = written(&frame);
    assert_eq!(glb.root.meshes.len(), 2);
    let [own, blue] = [0, 1].map(|mesh| &glb.root.meshes[mesh].primitives);
    let used: Vec<_> = glb.nodes().iter().map(|(node, _)| node.mesh.unwrap().value()).collect();
    assert_eq!(used, [0, 1, 1]);
    for (own, blue) in own.iter().zip(blue) {
        assert_eq!(own.attributes, blue.attributes);
        assert_eq!(own.indices.map(|index: Index<_>| index.value()), blue.indices.map(|index| index.value()));
    }
    let material = &glb.root.materials[blue[1].material.unwrap().value()];
    assert_eq!(material.pbr_metallic_roughness.base_color_factor.0, [0.0, 0.0, 1.0, 0.5]);
    assert_eq!(gltf_json::serialize::to_value(material).unwrap()["alphaMode"], "BLEND");
}

#[test]
fn triangles_whose_corners_round_together_are_not_written() {
    let mut frame = box_frame(DVec3::ONE, &[DAffine3::IDENTITY]);
    let mesh = &mut frame.batches[0].mesh;
    mesh.positions.push(mesh.positions[0] + DVec3::splat(1e-12));
    mesh.normals.push(mesh.normals[0]);
    mesh.triangles.push([0, 4, 1]);
    let glb = written(&frame);
    assert_eq!(glb.indices(&glb.root.meshes[0].primitives[0]).len(), 6);
}

#[test]
fn edges_whose_points_round_together_are_not_written() {
    let mut frame = box_frame(DVec3::ONE, &[DAffine3::IDENTITY]);
    let points = &mut frame.edge_lines[1].points;
    points[1] = points[0] + DVec3::splat(1e-12);
    let glb = written(&frame);
    let lines = &glb.root.meshes[0].primitives[2];
    assert_eq!(glb.floats(lines, feature()), [0.0, 0.0, 2.0, 2.0, 3.0, 3.0]);
    assert_eq!(glb.indices(lines), (0..6).collect::<Vec<_>>());
    let features = gltf_json::serialize::to_string(&lines.extensions).unwrap();
    assert!(features.contains(r#""featureCount":3,"#), "{features}");
}

#[test]
fn coinciding_corners_stay_bit_identical() {
    let mut frame = box_frame(DVec3::new(0.1, 0.7, 1.3), &[DAffine3::IDENTITY]);
    frame.scene.parts[0].centre = DVec3::new(1.0 / 3.0, 1e6 / 7.0, -1.0 / 9.0);
    let glb = written(&frame);
    let faces = glb.root.meshes[0].primitives.iter();
    let points = faces.flat_map(|primitive| glb.vectors(primitive, Semantic::Positions));
    assert_eq!(points.map(|p| p.to_array().map(f32::to_bits)).collect::<BTreeSet<_>>().len(), 8);
}

#[test]
fn many_vertices_take_wide_indices() {
    let mut frame = box_frame(DVec3::ONE, &[DAffine3::IDENTITY]);
    let mesh = &mut frame.batches[2].mesh;
    mesh.positions.resize(70_000, DVec3::ONE);
    mesh.normals.resize(70_000, Vec3::X);
    mesh.positions.push(DVec3::new(0.5, -1.0, 0.5));
    mesh.normals.push(Vec3::X);
    mesh.triangles.push([0, 1, 70_000]);
    let glb = written(&frame);
    let primitives = &glb.root.meshes[0].primitives;
    assert_eq!(glb.bytes(primitives[0].indices.unwrap().value()).1, ComponentType::U16);
    assert_eq!(glb.bytes(primitives[1].indices.unwrap().value()).1, ComponentType::U32);
    assert_eq!(
        glb.indices(&primitives[1])[12..15],
        [4, 5, 70_004],
        "batch 1 has four vertices, batch 2 the wide triangle"
    );
}

/// A part with one batch per face, and one line per face. Every third face has triangles without area only.
fn many_faces(faces: usize, corners: usize) -> MemorySink {
    let mut frame = box_frame(DVec3::ONE, &[DAffine3::IDENTITY]);
    let (batch, line) = (frame.batches.swap_remove(0), frame.edge_lines.swap_remove(0));
    frame.scene.parts[0].face_colours = vec![None; faces];
    frame.batches.clear();
    frame.edge_lines.clear();
    for face in 0..faces {
        let (mut batch, mut line) = (batch.clone(), line.clone());
        batch.face = FaceId::new(face);
        let place = |k: usize| DVec3::new(k as f64, face as f64, (k * k % 7) as f64);
        batch.mesh.positions = (0..corners).map(place).collect();
        batch.mesh.normals = (0..corners).map(|k| Vec3::new(k as f32, 1.0, face as f32).normalize()).collect();
        let step = u32::from(face % 3 != 1);
        batch.mesh.triangles = (2..corners as u32).map(|k| [k, k - step, k - 2]).collect();
        line.edge = EdgeId::new(face);
        line.points.clone_from(&batch.mesh.positions);
        frame.batches.push(batch);
        frame.edge_lines.push(line);
    }
    frame
}

#[test]
fn long_lists_of_batches_keep_their_corners() {
    let frame = many_faces(400, 64);
    let glb = written(&frame);
    let primitive = &glb.root.meshes[0].primitives[0];
    let positions = glb.vectors(primitive, Semantic::Positions);
    let ids = glb.floats(primitive, feature());
    let kept = frame.batches.iter().filter(|batch| batch.face.0 % 3 != 1);
    let wanted = kept.flat_map(|batch| {
        let corner = |k: &u32| (batch.face.0 as f32, batch.mesh.positions[*k as usize]);
        batch.mesh.triangles.iter().flatten().map(corner).collect::<Vec<_>>()
    });
    let centre = frame.scene.parts[0].centre;
    let wanted: Vec<_> = wanted.map(|(face, point)| (face, ((point - centre) * 1e-3).as_vec3() + Vec3::ZERO)).collect();
    let found: Vec<_> = glb.indices(primitive).iter().map(|&k| (ids[k as usize], positions[k as usize])).collect();
    assert!(positions.len() > 16_000 && found == wanted);
}

#[test]
fn rounding_far_from_the_origin_is_bounded_or_refused() {
    let mut frame = many_faces(3, 3);
    frame.scene.parts[0].centre = DVec3::new(1e6 / 3.0, -2e6 / 7.0, 0.0);
    let far = glam::DAffine3::from_translation(DVec3::splat(1e7 / 3.0));
    frame.scene.instances.iter_mut().for_each(|instance| instance.transform = far * instance.transform);
    let (mut plain, mut nested, mut none) = (Vec::new(), Vec::new(), Vec::new());
    let moved = write(&frame, &mut plain, PLAIN).unwrap().moved;
    let most = 0.1 * moved;
    let within = |most, bytes: &mut Vec<u8>| {
        let options = SaveOptions::new(PLAIN).with_max_rounding(most);
        write_on(&Alone, &frame, bytes, &options, &Control::default())
    };
    assert!(moved > 1e-2 && within(most, &mut nested).unwrap().moved <= most);
    assert!(within(1e-15, &mut none).is_err() && none.is_empty());
}

#[test]
fn one_thread_and_three_write_the_same_file() {
    let (frame, path) = (many_faces(1_500, 64), folder("out_glb_threads").join("faces.glb"));
    let options: Vec<GlbOptions> = [GlbOptions::PLAIN, GlbOptions::PLAIN.with_instanced(true)]
        .into_iter()
        .flat_map(|options| [options, options.with_quantized(true)])
        .collect();
    #[cfg(feature = "meshopt")]
    let options: Vec<_> = options.into_iter().flat_map(|options| [options, options.with_compressed(true)]).collect();
    let mut plain = Vec::new();
    write(&frame, &mut plain, PLAIN).unwrap();
    for options in options {
        let [alone, shared] = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let rounding = pool.install(|| save(&frame, &path, Format::Glb(options))).unwrap();
            (rounding, fs::read(&path).unwrap())
        });
        assert!(alone == shared, "{options:?}");
        assert!(options != GlbOptions::PLAIN || alone.1 == plain);
    }
}

#[test]
fn an_empty_scene_is_still_a_file() {
    let folder = folder("out_glb_empty");
    let path = folder.join("empty.glb");
    save(&MemorySink::default(), &path, PLAIN).unwrap();
    let glb = read(&fs::read(path).unwrap());
    assert!(glb.root.buffers.is_empty() && glb.root.meshes.is_empty());
}
