//! STL and OBJ files read back.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod out_fixture;

use glam::{DAffine3, DVec3, Vec3};
use out_fixture::box_frame;
use std::collections::BTreeSet;
use trimtess::mesh::MemorySink;
use trimtess::out::{Format, write};

fn placement() -> DAffine3 {
    DAffine3::from_axis_angle(DVec3::new(0.3, 0.5, 0.8).normalize(), 0.7)
        * DAffine3::from_translation(DVec3::new(10.0, -7.3, 0.1))
}

/// Normal and corners of each triangle.
fn stl(frame: &MemorySink) -> Vec<[Vec3; 4]> {
    let mut bytes = Vec::new();
    write(frame, &mut bytes, Format::Stl).unwrap();
    assert!(!bytes.starts_with(b"solid"));
    let count = u32::from_le_bytes(bytes[80..84].try_into().unwrap()) as usize;
    assert_eq!(bytes.len(), 84 + 50 * count);
    let float = |row: &[u8], k: usize| f32::from_le_bytes(row[4 * k..4 * k + 4].try_into().unwrap());
    let vector = |row: &[u8], k: usize| Vec3::from_array([0, 1, 2].map(|axis| float(row, 3 * k + axis)));
    bytes[84..].chunks(50).map(|row| [0, 1, 2, 3].map(|k| vector(row, k))).collect()
}

#[test]
fn stl_closes_and_its_normals_point_out() {
    let size = DVec3::new(0.1, 0.7, 1.3);
    let triangles = stl(&box_frame(size, &[placement(), DAffine3::IDENTITY]));
    assert_eq!(triangles.len(), 24);
    let points = |of: &[[Vec3; 4]]| {
        of.iter().flat_map(|t| &t[1..]).map(|p| p.to_array().map(f32::to_bits)).collect::<BTreeSet<_>>()
    };
    assert_eq!((points(&triangles[..12]).len(), points(&triangles[12..]).len()), (8, 8));
    for (index, &[normal, a, b, c]) in triangles.iter().enumerate() {
        let centre = if index < 12 { placement().transform_point3(0.5 * size) } else { 0.5 * size }.as_vec3();
        assert!((normal.length() - 1.0).abs() < 1e-6);
        assert!(normal.dot(a - centre) > 0.04 && (b - a).cross(c - a).dot(normal) > 0.0);
    }
}

#[test]
fn stl_drops_triangles_whose_corners_round_together() {
    let far = DAffine3::from_translation(DVec3::new(1e8, 0.0, 0.0)); // single-precision numbers are 8 mm apart there
    let triangles = stl(&box_frame(DVec3::ONE, &[far]));
    assert_eq!(triangles.len(), 4, "only the two faces across x survive");
}

#[test]
fn obj_carries_every_bit() {
    let frame = box_frame(DVec3::new(0.1, 1e-7, 1.3), &[DAffine3::IDENTITY, placement()]);
    let mut text = Vec::new();
    write(&frame, &mut text, Format::Obj).unwrap();
    let text = String::from_utf8(text).unwrap();
    let rows = |key: &str| -> Vec<Vec<&str>> {
        let rows = text.lines().filter_map(|line| line.strip_prefix(key)?.strip_prefix(' '));
        rows.map(|row| row.split(' ').collect()).collect()
    };
    let points: Vec<DVec3> =
        rows("v").iter().map(|row| DVec3::from_array([0, 1, 2].map(|k| row[k].parse().unwrap()))).collect();
    let expected = frame.scene.instances.iter().flat_map(|instance| {
        let batches = frame.batches.iter().flat_map(|batch| &batch.mesh.positions);
        batches.map(|&point| instance.transform.transform_point3(point))
    });
    assert_eq!(points, expected.collect::<Vec<_>>());
    assert_eq!(rows("vn").len(), points.len());
    assert_eq!(rows("o"), [["box_0"], ["box_1"]]);
    assert_eq!(rows("g").len(), 12);
    assert_eq!(rows("g")[11], ["face_11"]);
    let faces = rows("f");
    assert_eq!(faces.len(), 24);
    assert_eq!(faces[0], ["1//1", "2//2", "3//3"]);
    assert_eq!(faces[23], ["45//45", "47//47", "48//48"]);
}
