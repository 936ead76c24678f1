//! Levels of detail in a GLB: each reads back as its frame, and readers that do not know them read the finest.
#![cfg(feature = "glb")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod folders;
mod out_fixture;

use folders::folder;
use glam::{DAffine3, DVec3};
use gltf_json::Value;
use out_fixture::box_frame;
use std::path::Path;
use trimtess::control::{Control, Rayon};
use trimtess::mesh::MemorySink;
use trimtess::out::{
    Format, GlbOptions, MeshLevel, Outputs, ReadBack, SaveError, SaveOptions, Saved, UnfitLevel, read_back, save_on,
};

const SIZE: DVec3 = DVec3::new(100.0, 20.0, 30.0);
const MOST: f64 = 0.01;
/// Of the finest level.
const CHORD: f64 = 0.1;

/// Boxes that turn and move, one mirrored, one so far away that it needs nodes around its node.
fn places() -> Vec<DAffine3> {
    let at = |x: f64| {
        DAffine3::from_translation(DVec3::new(x, 0.3 * x, -x))
            * DAffine3::from_axis_angle(DVec3::new(0.3, 0.5, 0.8).normalize(), 0.7 * x)
    };
    vec![at(0.0), at(1.0), at(2.0), at(3.0) * DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)), at(1e7 / 3.0)]
}

/// The box with other triangles and one more vertex: faces before `first` are divided the other way.
fn level(first: usize) -> MemorySink {
    let mut frame = box_frame(SIZE, &places());
    for batch in &mut frame.batches[..first] {
        batch.mesh.triangles = vec![[1, 2, 3], [1, 3, 0]];
    }
    frame
}

fn with(options: GlbOptions) -> SaveOptions {
    SaveOptions::new(Format::Glb(options)).with_max_rounding(MOST)
}

fn levels<'a>(finest: &'a MemorySink, coarser: &'a [(MemorySink, f64)]) -> Vec<MeshLevel<'a>> {
    let coarser = coarser.iter().map(|(frame, chord)| MeshLevel { frame: frame.into(), chord: *chord });
    std::iter::once(MeshLevel { frame: finest.into(), chord: CHORD }).chain(coarser).collect()
}

fn save(levels: &[MeshLevel<'_>], path: &Path, options: GlbOptions) {
    let mut outputs = Outputs::default();
    let saved = outputs.save_on(&Rayon, levels, path, &with(options), &Control::default()).unwrap();
    let Saved { roundings, temporary, .. } = saved;
    assert!(roundings.len() == levels.len() && roundings.iter().all(|told| told.moved <= MOST), "{roundings:?}");
    assert!(temporary.exists() && temporary.parent() == path.parent(), "{temporary:?}");
    outputs.publish().unwrap();
    assert!(path.exists() && !temporary.exists());
}

fn read_levels(frames: &[&MemorySink], path: &Path, options: GlbOptions) -> std::io::Result<Vec<ReadBack>> {
    let levels: Vec<_> = frames.iter().map(|&frame| frame.into()).collect();
    read_back(&levels, path, &with(options))
}

fn json(path: &Path) -> Value {
    let bytes = std::fs::read(path).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    gltf_json::deserialize::from_slice(&bytes[20..20 + length]).unwrap()
}

#[test]
fn every_level_reads_back_as_its_frame() {
    let folder = folder("levels");
    let finest = level(0);
    let mut coarse = vec![(level(3), 0.4), (level(6), 1.6)];
    coarse[1].0.batches.iter_mut().for_each(|batch| batch.mesh.triangles.truncate(1));
    for k in 0..8 {
        let options = GlbOptions::PLAIN.with_instanced(k & 1 > 0).with_quantized(k & 2 > 0);
        #[cfg(feature = "meshopt")]
        let options = options.with_compressed(k & 4 > 0);
        let path = folder.join(format!("{k}.glb"));
        save(&levels(&finest, &coarse), &path, options);
        let all = [&finest, &coarse[0].0, &coarse[1].0];
        let read = read_levels(&all, &path, options).unwrap();
        assert_eq!(read.len(), 3);
        for (number, (read, triangles)) in read.iter().zip([60, 60, 30]).enumerate() {
            // Corners far from the origin are read as decimals.
            assert!(read.triangles == triangles && read.moved <= MOST, "{k} {number}: {read:?}");
            assert_eq!(read.unbalanced_edges == 0, number < 2, "{k} {number}");
        }
        // The second level has triangles of its own.
        assert!(read_levels(&[&finest; 2], &path, options).unwrap()[1].moved > 1.0, "{k}");
        assert!(read_levels(&[all[0], all[1], all[2], all[2]], &path, options).is_err(), "{k}");
    }
}

#[test]
fn nodes_name_their_coarser_nodes_and_the_shares_of_the_screen_below_which_those_are_drawn() {
    let path = folder("level_nodes").join("box.glb");
    let finest = level(0);
    let coarse = [(level(1), 0.4), (level(2), 1.6)];
    save(&levels(&finest, &coarse), &path, GlbOptions::PLAIN);
    let json = json(&path);
    assert!(json["extensionsUsed"].as_array().unwrap().contains(&"MSFT_lod".into()), "{json}");
    assert!(json["extensionsRequired"].is_null(), "who does not know levels draws the finest: {json}");
    let nodes = json["nodes"].as_array().unwrap();
    let detailed: Vec<_> = nodes.iter().filter(|node| !node["extensions"]["MSFT_lod"].is_null()).collect();
    assert_eq!(detailed.len(), places().len());
    // A sphere of the box's diagonal covers this share of the screen when the chord is a pixel.
    let share = |chord: f64| std::f64::consts::FRAC_PI_4 * (SIZE.length() / chord).powi(2) / (1920.0 * 1080.0);
    for node in detailed {
        let ids: Vec<usize> =
            gltf_json::deserialize::from_value(node["extensions"]["MSFT_lod"]["ids"].clone()).unwrap();
        assert_eq!(ids.len(), 2);
        for coarser in ids.iter().map(|&id| &nodes[id]) {
            let place = |node: &Value| ["translation", "rotation", "scale", "matrix"].map(|k| node[k].clone());
            assert_eq!(place(coarser), place(node));
            assert_ne!(coarser["mesh"], node["mesh"]);
        }
        let shares: Vec<f64> =
            gltf_json::deserialize::from_value(node["extras"]["MSFT_screencoverage"].clone()).unwrap();
        assert!(
            (shares[0] / share(0.4) - 1.0).abs() < 1e-6 && (shares[1] / share(1.6) - 1.0).abs() < 1e-6,
            "{shares:?}"
        );
        assert_eq!(shares[2], 0.0, "the last is drawn however small it is");
    }
}

#[test]
fn a_level_with_nothing_coarser_shares_the_data() {
    let folder = folder("shared_levels");
    let finest = level(0);
    let (one, two) = (folder.join("one.glb"), folder.join("two.glb"));
    save(&levels(&finest, &[]), &one, GlbOptions::PLAIN);
    save(&levels(&finest, &[(level(0), 0.4), (level(0), 1.6)]), &two, GlbOptions::PLAIN);
    let bytes = |path: &Path| json(path)["buffers"][0]["byteLength"].as_u64().unwrap();
    assert_eq!(bytes(&one), bytes(&two));
    let read = read_levels(&[&finest; 3], &two, GlbOptions::PLAIN).unwrap();
    assert!(read.iter().all(|level| level.triangles == 60), "{read:?}");
}

#[test]
fn a_part_without_triangles_in_a_level_has_those_of_the_level_before() {
    let path = folder("empty_level").join("box.glb");
    let finest = level(0);
    let mut empty = level(0);
    empty.batches.clear();
    let mut tiny = level(0);
    for batch in &mut tiny.batches {
        // Single precision rounds all its points to one.
        batch.mesh.positions.iter_mut().for_each(|point| *point = SIZE + 1e-9 * *point);
    }
    let coarser = [(empty, 0.4), (tiny, 1.6)];
    for options in [GlbOptions::PLAIN, GlbOptions::PLAIN.with_quantized(true)] {
        let mut outputs = Outputs::default();
        let levels = levels(&finest, &coarser);
        let saved = outputs.save_on(&Rayon, &levels, &path, &with(options), &Control::default()).unwrap();
        outputs.publish().unwrap();
        let told = saved.roundings;
        assert!(told.iter().all(|told| (told.triangles, told.collapsed) == (60, 0)), "{told:?}");
        let read = read_levels(&[&finest, &coarser[0].0, &coarser[1].0], &path, options).unwrap();
        assert!(read.iter().all(|read| (read.triangles, read.unbalanced_edges) == (60, 0)), "{read:?}");
    }
}

#[test]
fn without_levels_a_file_has_the_bytes_of_a_plain_one() {
    let folder = folder("no_levels");
    let finest = level(0);
    for options in [GlbOptions::PLAIN, GlbOptions::PLAIN.with_instanced(true)] {
        let (one, other) = (folder.join("one.glb"), folder.join("other.glb"));
        save(&levels(&finest, &[]), &one, options);
        save_on(&Rayon, &finest, &other, &with(options), &Control::default()).unwrap();
        assert!(std::fs::read(one).unwrap() == std::fs::read(other).unwrap());
    }
}

#[test]
fn meshes_that_are_not_levels_of_one_scene_are_refused_and_nothing_is_written() {
    let folder = folder("unfit_levels");
    let finest = level(0);
    let moved = box_frame(SIZE, &places()[1..]);
    let other = box_frame(DVec3::ONE, &places());
    let mut edited = level(1);
    edited.scene.parts[0].face_colours[2] = Some([0.0, 1.0, 0.0, 1.0]);
    let inf = f64::INFINITY;
    let cases = [
        (vec![(moved, 1.0)], UnfitLevel::OtherScene { level: 1 }),
        (vec![(edited, 1.0)], UnfitLevel::OtherScene { level: 1 }),
        (vec![(level(1), 1.0), (other, 2.0)], UnfitLevel::OtherScene { level: 2 }),
        (vec![(level(1), CHORD)], UnfitLevel::Chord { level: 1, chord: CHORD, before: CHORD }),
        (vec![(level(1), inf)], UnfitLevel::Chord { level: 1, chord: inf, before: CHORD }),
        (vec![(level(1), 1.0), (level(2), 1.0)], UnfitLevel::Chord { level: 2, chord: 1.0, before: 1.0 }),
    ];
    for (frames, expected) in cases {
        assert_eq!(refused(&folder, &levels(&finest, &frames), with(GlbOptions::PLAIN)), expected);
    }
    let two = [(level(1), 1.0)];
    let stl = SaveOptions::new(Format::Stl);
    assert_eq!(refused(&folder, &levels(&finest, &two), stl), UnfitLevel::Format { levels: 2 });
    assert_eq!(refused(&folder, &[], stl), UnfitLevel::Missing);
}

/// What is wrong with the levels. Nothing is in the folder then.
fn refused(folder: &Path, levels: &[MeshLevel<'_>], options: SaveOptions) -> UnfitLevel {
    let mut outputs = Outputs::default();
    let saved = outputs.save_on(&Rayon, levels, &folder.join("box"), &options, &Control::default());
    let Err(SaveError::UnfitLevel(told)) = saved else { panic!("{saved:?}") };
    outputs.publish().unwrap();
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), 0);
    told
}
