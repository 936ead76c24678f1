//! Frames with arrays per part: judged, measured and written as frames with lists per tile are.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;
mod out_fixture;

use common::prepared;
use glam::{DAffine3, DVec3};
use out_fixture::{box_frame, play};
use std::sync::Arc;
use trimtess::audit;
use trimtess::frame::{Tolerance, plan};
use trimtess::mesh::{Batch, FlatMesh, FrameView, MeshSink, PackedFrame, PartMesh, Scene, SceneChanges, check_scene};
use trimtess::mesh::{MemorySink, TileMesh};
use trimtess::model::{FaceId, PartId, TileId};
use trimtess::out::{Format, write};
use trimtess::parallel::serial;

/// Mirrored, scaled and moved.
fn transforms() -> [DAffine3; 3] {
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    [
        DAffine3::IDENTITY,
        DAffine3::from_translation(DVec3::splat(7.0)) * mirror,
        DAffine3::from_scale(DVec3::splat(3.0)),
    ]
}

fn packed(frame: &MemorySink) -> PackedFrame {
    let mut packed = PackedFrame::default();
    play(frame, &mut packed).unwrap();
    packed
}

/// What each writer makes of a frame.
fn files<'a>(frame: impl Into<FrameView<'a>>) -> Vec<Vec<u8>> {
    let frame = frame.into();
    let mut files = vec![Vec::new(); 3];
    write(&frame, &mut files[0], Format::Ply).unwrap();
    write(&frame, &mut files[1], Format::Stl).unwrap();
    write(&frame, &mut files[2], Format::Obj).unwrap();
    #[cfg(feature = "glb")]
    {
        files.push(Vec::new());
        let format = Format::Glb(trimtess::out::GlbOptions::PLAIN);
        write(&frame, &mut files[3], format).unwrap();
    }
    files
}

#[test]
fn files_checks_and_audits_are_the_same_from_arrays_per_part() {
    for name in trimtess_models::names().filter(|name| !name.contains("assembly")) {
        let prepared = prepared(trimtess_models::by_name(name).unwrap());
        let chord = 1e-2 * prepared.diagonal;
        let plan = Arc::new(plan(&prepared, &Tolerance { chord, angle: 0.5, max_edge: None }));
        let (mut tiles, mut parts) = (MemorySink::default(), PackedFrame::default());
        let made = serial(&prepared, &plan, true, &mut tiles).unwrap();
        serial(&prepared, &plan, true, &mut parts).unwrap();
        assert!(files(&tiles) == files(&parts), "{name}");
        assert_eq!(check_scene(&tiles).parts, check_scene(&parts).parts, "{name}");
        assert_eq!(audit::deviation(&prepared, &tiles, chord), audit::deviation(&prepared, &parts, chord), "{name}");
        assert_eq!(audit::economy(&prepared, &tiles, chord), audit::economy(&prepared, &parts, chord), "{name}");
        assert_eq!(made.diagnostics(&tiles, &prepared), made.diagnostics(&parts, &prepared), "{name}");
    }
}

#[test]
fn arrays_of_a_part_are_its_tiles_one_after_the_other() {
    let frame = box_frame(DVec3::new(1.0, 2.0, 3.0), &transforms());
    let packed = packed(&frame);
    let part = &packed.parts[0];
    assert_eq!((part.positions.len(), part.triangles.len()), (24, 12));
    assert_eq!(part.face_ids, [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5]);
    for (batch, tile) in frame.batches.iter().zip(0..) {
        let (rows, corners) = (4 * tile..4 * tile + 4, 2 * tile..2 * tile + 2);
        assert_eq!(part.positions[rows.clone()], batch.mesh.positions[..]);
        assert_eq!(part.normals[rows], batch.mesh.normals[..]);
        let own = batch.mesh.triangles.iter().map(|corners| corners.map(|corner| corner + 4 * tile as u32));
        assert!(own.eq(part.triangles[corners].iter().copied()));
    }
    assert_eq!(packed.edge_lines_of(PartId(0)), frame.edge_lines);
    assert_eq!(packed.edge_lines_of(PartId(1)), []);
}

#[test]
fn parts_whose_lists_were_emptied_are_written_and_checked() {
    let whole = packed(&box_frame(DVec3::new(1.0, 2.0, 3.0), &transforms()));
    let damage: [fn(&mut PartMesh); 2] = [|part| part.positions.clear(), |part| part.triangles.truncate(3)];
    for damage in damage {
        let mut packed = whole.clone();
        damage(&mut packed.parts[0]);
        assert_ne!(check_scene(&packed).parts, check_scene(&whole).parts);
        write(&packed, &mut Vec::new(), Format::Ply).unwrap();
    }
}

#[test]
fn flattened_arrays_are_the_rows_of_a_ply() {
    let packed = packed(&box_frame(DVec3::new(1.0, 2.0, 3.0), &transforms()));
    let flat = FlatMesh::of(&packed).unwrap();
    let mut ply = Vec::new();
    write(&packed, &mut ply, Format::Ply).unwrap();
    let end = b"end_header\n";
    let data = ply.windows(end.len()).position(|window| window == end).unwrap() + end.len();
    let mut expected = Vec::new();
    for (position, normal) in flat.positions.iter().zip(&flat.normals) {
        expected.extend(position.to_array().iter().flat_map(|number| number.to_le_bytes()));
        expected.extend(normal.to_array().iter().flat_map(|number| number.to_le_bytes()));
    }
    for (corners, face) in flat.triangles.iter().zip(&flat.face_ids) {
        expected.push(3);
        expected.extend(corners.iter().flat_map(|corner| corner.to_le_bytes()));
        expected.extend(face.to_le_bytes());
    }
    assert!(ply[data..] == expected[..]);
    assert_eq!((flat.positions.len(), flat.triangles.len(), flat.uvs.len()), (72, 36, 72));
    let lines = packed.edge_lines.len();
    assert_eq!(flat.edge_starts.len(), 3 * lines + 1);
    assert_eq!(flat.edge_points[0], packed.edge_lines[0].points[0]);
    let second = flat.edge_starts[lines] as usize;
    assert_eq!(flat.edge_points[second], transforms()[1].transform_point3(packed.edge_lines[0].points[0]));
}

#[test]
fn indices_out_of_range_stay_out_of_range() {
    let mut frame = box_frame(DVec3::ONE, &[DAffine3::IDENTITY]);
    frame.batches[1].mesh.triangles[0] = [0, 1, 9];
    assert_eq!(check_scene(&packed(&frame)).total.bad_indices, 1);
    assert_eq!(check_scene(&packed(&frame)).parts, check_scene(&frame).parts);
}

#[test]
fn a_packed_frame_takes_whole_frames_only_and_forgets_what_is_aborted() {
    let mut packed = packed(&box_frame(DVec3::ONE, &[DAffine3::IDENTITY]));
    assert!(packed.begin_changes(&Scene::default(), &SceneChanges::default()).is_err());
    packed.abort();
    assert!(packed.parts.is_empty() && packed.edge_lines.is_empty());
    // A batch of an unknown part is dropped, as writers drop it.
    let mut batch = Batch { part: PartId(5), face: FaceId(0), tile: TileId(0), worker: 0, mesh: TileMesh::default() };
    packed.begin(&Scene::default()).unwrap();
    packed.batch(&mut batch).unwrap();
    assert!(packed.parts.is_empty());
}
