//! PLY files read back byte by byte.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod folders;
mod out_fixture;

use folders::folder;
use glam::{DAffine3, DVec3};
use out_fixture::box_frame;
use std::collections::BTreeSet;
use trimtess::mesh::MemorySink;
use trimtess::out::{Format, UnknownFormat, save, write};

struct Ply {
    header: String,
    vertices: Vec<([f64; 3], [f32; 3])>,
    faces: Vec<([u32; 3], u32)>,
}

fn read(bytes: &[u8]) -> Ply {
    let end = b"end_header\n";
    let at = bytes.windows(end.len()).position(|window| window == end).unwrap() + end.len();
    let header = String::from_utf8(bytes[..at].to_vec()).unwrap();
    let count = |element: &str| -> usize {
        header.lines().find_map(|line| line.strip_prefix(&format!("element {element} "))).unwrap().parse().unwrap()
    };
    let (rows, list) = bytes[at..].split_at(36 * count("vertex"));
    let f64_at = |row: &[u8], k: usize| f64::from_le_bytes(row[8 * k..8 * k + 8].try_into().unwrap());
    let f32_at = |row: &[u8], k: usize| f32::from_le_bytes(row[24 + 4 * k..28 + 4 * k].try_into().unwrap());
    let vertices =
        rows.chunks(36).map(|row| ([0, 1, 2].map(|k| f64_at(row, k)), [0, 1, 2].map(|k| f32_at(row, k)))).collect();
    assert_eq!(list.len(), 17 * count("face"));
    let faces = list
        .chunks(17)
        .map(|row| {
            assert_eq!(row[0], 3);
            let word = |k: usize| u32::from_le_bytes(row[1 + 4 * k..5 + 4 * k].try_into().unwrap());
            ([word(0), word(1), word(2)], word(3))
        })
        .collect();
    Ply { header, vertices, faces }
}

fn written(frame: &MemorySink) -> Ply {
    let mut bytes = Vec::new();
    write(frame, &mut bytes, Format::Ply).unwrap();
    read(&bytes)
}

fn volume(ply: &Ply) -> f64 {
    let corner = |index: u32| DVec3::from_array(ply.vertices[index as usize].0);
    ply.faces.iter().map(|(t, _)| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0).sum()
}

#[test]
fn header_is_the_documented_one() {
    let ply = written(&box_frame(DVec3::ONE, &[DAffine3::IDENTITY]));
    assert_eq!(
        ply.header,
        "ply\nformat binary_little_endian 1.0\ncomment millimetres\nelement vertex 24\nproperty double x\n\
         property double y\nproperty double z\nproperty float nx\nproperty float ny\nproperty float nz\n\
         element face 12\nproperty list uchar uint vertex_indices\nproperty uint face_id\nend_header\n"
    );
}

#[test]
fn instances_are_placed_and_faces_run_over_all() {
    let moved = DAffine3::from_translation(DVec3::new(10.0, 0.0, -0.0));
    let ply = written(&box_frame(DVec3::ONE, &[DAffine3::IDENTITY, moved]));
    assert_eq!((ply.vertices.len(), ply.faces.len()), (48, 24));
    assert_eq!(ply.faces.iter().map(|(_, id)| *id).collect::<BTreeSet<_>>(), (0..12).collect());
    assert_eq!(ply.faces[12].0, [24, 25, 26]);
    assert_eq!(ply.vertices[24].0, [10.0, 0.0, 0.0]);
    assert_eq!(ply.vertices[24].1, [0.0, 0.0, -1.0]);
    assert!((volume(&ply) - 2.0).abs() < 1e-12);
}

#[test]
fn coinciding_corners_stay_bit_identical_under_any_placement() {
    let placement = DAffine3::from_axis_angle(DVec3::new(0.3, 0.5, 0.8).normalize(), 0.7)
        * DAffine3::from_translation(DVec3::new(1e3, -7.3, 0.1));
    let ply = written(&box_frame(DVec3::new(0.1, 0.7, 1.3), &[placement]));
    let distinct: BTreeSet<_> = ply.vertices.iter().map(|(p, _)| p.map(f64::to_bits)).collect();
    assert_eq!(distinct.len(), 8);
    for (_, normal) in &ply.vertices {
        assert!((normal.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-6);
    }
}

#[test]
fn a_mirrored_instance_keeps_its_outside() {
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let ply = written(&box_frame(DVec3::ONE, &[mirror]));
    assert!((volume(&ply) - 1.0).abs() < 1e-14);
    let (corners, normal) = (ply.faces[10].0, ply.vertices[20].1);
    assert_eq!(ply.vertices[corners[0] as usize].0[0], -1.0);
    assert_eq!(normal, [-1.0, 0.0, 0.0]);
}

#[test]
fn triangles_that_collapse_in_the_world_are_dropped() {
    // At 1e17 mm doubles are 16 mm apart.
    let ply = written(&box_frame(DVec3::ONE, &[DAffine3::from_translation(DVec3::splat(1e17))]));
    assert_eq!(ply.faces.len(), 0);
}

#[test]
fn a_saved_file_has_the_bytes_that_are_written_and_is_alone() {
    let folder = folder("out_ply_saved");
    let frame = box_frame(DVec3::ONE, &[DAffine3::IDENTITY]);
    let path = folder.join("a.PLY");
    save(&frame, &path, Format::of_path(&path).unwrap()).unwrap();
    let mut bytes = Vec::new();
    write(&frame, &mut bytes, Format::Ply).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), bytes);
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
}

#[test]
fn a_missing_folder_is_an_error_that_names_the_file() {
    let path = folder("out_ply_missing").join("no/such/a.ply");
    let error = save(&box_frame(DVec3::ONE, &[]), &path, Format::Ply).unwrap_err();
    assert!(error.to_string().contains("a.ply"), "{error}");
}

#[test]
fn unknown_extensions_list_the_known() {
    let error = Format::of_path("part.xyz".as_ref()).unwrap_err();
    assert_eq!(error, UnknownFormat { extension: "xyz".into() });
    for (name, _) in Format::ALL {
        assert!(error.to_string().contains(&format!(".{name}")), "{error}");
    }
    assert!(Format::of_path("part".as_ref()).is_err());
}
