//! Rounding to a format's numbers is measured, limited, and read back from the file.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod folders;
mod out_fixture;

use folders::folder;
use glam::{DAffine3, DVec3};
use out_fixture::box_frame;
use std::path::Path;
use trimtess::control::{Control, Rayon};
use trimtess::mesh::MemorySink;
#[cfg(feature = "glb")]
use trimtess::out::GlbOptions;
use trimtess::out::{Format, ReadBack, Rounding, SaveError, SaveOptions, read_back, save, save_on, write};

fn within(format: Format, most: f64) -> SaveOptions {
    SaveOptions::new(format).with_max_rounding(most)
}

/// Saves, where rounding moves no vertex by more than `most` millimetres.
fn limited(frame: &MemorySink, path: &Path, format: Format, most: f64) -> Result<Rounding, SaveError> {
    save_on(&Rayon, frame, path, &within(format, most), &Control::default())
}

/// What a file of one mesh holds.
fn read_alone(frame: &MemorySink, path: &Path, options: &SaveOptions) -> std::io::Result<ReadBack> {
    Ok(read_back(&[frame.into()], path, options)?.swap_remove(0))
}

/// All formats, and GLB in all its forms.
fn formats() -> Vec<(String, Format)> {
    let plain = Format::ALL.iter().map(|(name, format)| ((*name).to_owned(), *format));
    plain.chain(compact()).collect()
}

#[cfg(feature = "glb")]
fn compact() -> impl Iterator<Item = (String, Format)> {
    (1..8).map(|k| {
        let options = GlbOptions::PLAIN.with_instanced(k & 1 > 0).with_quantized(k & 2 > 0);
        #[cfg(feature = "meshopt")]
        let options = options.with_compressed(k & 4 > 0);
        (format!("{k}.glb"), Format::Glb(options))
    })
}

#[cfg(not(feature = "glb"))]
fn compact() -> impl Iterator<Item = (String, Format)> {
    std::iter::empty()
}

fn turned_at(x: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, 0.3 * x, -x))
        * DAffine3::from_axis_angle(DVec3::new(0.3, 0.5, 0.8).normalize(), 0.7)
}

#[test]
fn a_file_reads_back_as_the_frame_and_no_vertex_moves_further_than_told() {
    let folder = folder("read_back");
    for x in [0.0, 1.0, 1e3, 1e5, 1e7] {
        let mirrored = turned_at(x) * DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let frame = box_frame(DVec3::new(100.0, 20.0, 30.0), &[turned_at(x), mirrored, DAffine3::IDENTITY]);
        for (extension, format) in formats() {
            let path = folder.join(format!("box.{extension}"));
            let told = save(&frame, &path, format).unwrap();
            let read = read_alone(&frame, &path, &SaveOptions::new(format)).unwrap();
            assert_eq!((told.triangles, told.collapsed, read.triangles), (36, 0, 36), "{x} {extension}");
            assert_eq!(read.unbalanced_edges, 0, "{x} {extension}");
            assert!(read.moved <= told.moved + 1e-14 * x.max(100.0), "{x} {extension}: {read:?} {told:?}");
        }
    }
}

#[cfg(feature = "glb")]
#[test]
fn nodes_are_nested_where_one_translation_has_too_few_digits() {
    let folder = folder("nested");
    let path = folder.join("box.glb");
    let frame = box_frame(DVec3::ONE, &[turned_at(12_345.678_9), turned_at(1e7 / 3.0), DAffine3::IDENTITY]);
    let plain = save(&frame, &path, Format::Glb(GlbOptions::PLAIN)).unwrap();
    assert!(plain.moved > 0.1, "{plain:?}");
    let fine = limited(&frame, &path, Format::Glb(GlbOptions::PLAIN), 1e-4).unwrap();
    assert!(fine.moved <= 0.5e-4, "{fine:?}");
    // Readers take the decimals of nodes as single or as double precision, and both are read.
    let read = read_alone(&frame, &path, &within(Format::Glb(GlbOptions::PLAIN), 1e-4)).unwrap();
    assert!(read.moved <= fine.moved + 1e-8, "{read:?} {fine:?}");
    // A micrometre a hundred metres away, and an instance beyond all digits.
    let tiny = box_frame(DVec3::splat(1e-3), &[turned_at(1e5 / 3.0), turned_at(1e5 / 7.0)]);
    let fine = limited(&tiny, &path, Format::Glb(GlbOptions::PLAIN), 1e-7).unwrap();
    let read = read_alone(&tiny, &path, &within(Format::Glb(GlbOptions::PLAIN), 1e-7)).unwrap();
    assert!(fine.moved <= 1e-7 && read.moved <= fine.moved + 1e-9, "{read:?} {fine:?}");
    let beyond = box_frame(DVec3::ONE, &[turned_at(1.234_567e25)]);
    assert!(limited(&beyond, &path, Format::Glb(GlbOptions::PLAIN), 1e-4).is_err());
}

#[test]
fn beyond_the_limit_nothing_is_written_and_the_distance_is_told() {
    let path = folder("beyond_limit").join("box.stl");
    let frame = box_frame(DVec3::ONE, &[turned_at(1e7 / 3.0)]);
    let error = limited(&frame, &path, Format::Stl, 0.01).unwrap_err();
    let SaveError::RoundedTooFar(told) = error else { panic!("{error}") };
    assert!(told.moved > 0.1 && told.moved < 0.5 && told.most == 0.01, "{told:?}");
    assert!(!path.exists());
}

#[test]
fn collapsed_triangles_and_faces_are_counted() {
    let far = DAffine3::from_translation(DVec3::new(1e8, 0.0, 0.0)); // single-precision numbers are 8 mm apart there
    let frame = box_frame(DVec3::ONE, &[DAffine3::IDENTITY, far]);
    let told = write(&frame, &mut Vec::new(), Format::Stl).unwrap();
    assert_eq!((told.triangles, told.collapsed), (12 + 4, 8));
    assert_eq!(told.collapsed_faces, [6, 7, 8, 9], "the faces along x of the second instance");
}

#[test]
fn a_damaged_file_does_not_read_back() {
    let folder = folder("damaged");
    let frame = box_frame(DVec3::new(1.0, 2.0, 3.0), &[turned_at(10.0), DAffine3::IDENTITY]);
    for (extension, format) in formats() {
        let path = folder.join(format!("box.{extension}"));
        save(&frame, &path, format).unwrap();
        let whole = std::fs::read(&path).unwrap();
        for length in [0, 10, 30, 100, whole.len() / 2, whole.len() - 20] {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert!(read_alone(&frame, &path, &SaveOptions::new(format)).is_err(), "{extension} cut to {length}");
        }
    }
}

#[cfg(feature = "glb")]
#[test]
fn triangles_that_are_apart_in_their_node_and_coincide_in_the_world_are_balanced() {
    let path = folder("coincide").join("box.glb");
    let frame = box_frame(DVec3::splat(1e-10), &[DAffine3::from_translation(DVec3::splat(1e7))]);
    save(&frame, &path, Format::Glb(GlbOptions::PLAIN)).unwrap();
    let read = read_alone(&frame, &path, &SaveOptions::new(Format::Glb(GlbOptions::PLAIN))).unwrap();
    assert_eq!((read.triangles, read.unbalanced_edges), (12, 0));
}

#[cfg(feature = "glb")]
#[test]
fn a_grid_keeps_to_what_a_vertex_may_move_and_instances_become_one_node() {
    let folder = folder("compact");
    let places: Vec<DAffine3> = (0..50).map(|k| turned_at(f64::from(k))).collect();
    let frame = box_frame(DVec3::new(100.0, 20.0, 30.0), &places);
    let plain = GlbOptions::PLAIN;
    let size = |name: &str, options: GlbOptions, most: f64| {
        let path = folder.join(name);
        let told = limited(&frame, &path, Format::Glb(options), most).unwrap();
        let read = read_alone(&frame, &path, &within(Format::Glb(options), most)).unwrap();
        assert!(told.moved <= most && read.moved <= told.moved * (1.0 + 1e-9), "{name}: {told:?} {read:?}");
        assert_eq!((read.triangles, read.unbalanced_edges), (50 * 12, 0), "{name}");
        let bytes = std::fs::read(&path).unwrap();
        let json = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        (bytes.len(), String::from_utf8_lossy(&bytes[20..20 + json]).into_owned(), told.moved)
    };
    let (whole, text, moved) = size("plain.glb", plain, 0.01);
    assert!(!text.contains("extensionsRequired") && moved < 1e-4);
    let (listed, text, _) = size("instanced.glb", plain.with_instanced(true), 0.01);
    assert!(
        text.contains(r#""extensionsRequired":["EXT_mesh_gpu_instancing"]"#) && 2 * listed < whole,
        "{listed} {whole}"
    );
    // A step of 2^-9 mm moves a point by up to 0.0017 mm. That is too much for the last one.
    for (most, is_quantized) in [(0.01, true), (0.0036, true), (0.003, false)] {
        let (_, text, moved) = size("quantized.glb", plain.with_quantized(true), most);
        assert!(text.contains(r#""extensionsRequired":["KHR_mesh_quantization"]"#), "{text}");
        assert_eq!(moved > 1e-4, is_quantized, "{most}: {moved}");
    }
}

#[cfg(feature = "glb")]
#[test]
fn what_double_precision_makes_of_the_step_of_a_grid_is_told() {
    let path = folder("grid_step").join("box.glb");
    let format = Format::Glb(GlbOptions::PLAIN.with_quantized(true));
    for size in [1.0, 5.0, 10.0, 30.0, 100.0] {
        let frame = box_frame(DVec3::new(1.03, 0.77, 0.91) * size, &[DAffine3::IDENTITY]);
        let told = save(&frame, &path, format).unwrap();
        let read = read_alone(&frame, &path, &SaveOptions::new(format)).unwrap();
        assert!(read.moved <= told.moved * (1.0 + 1e-9) + 1e-14 * size, "{size}: {read:?} {told:?}");
    }
}
