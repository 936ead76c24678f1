//! Plans for cameras: they keep the screen-space error from any camera, at no more than the necessary cost.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod attributes;
#[path = "../common/blocks.rs"]
mod blocks;
mod budget;
mod cancelled;
#[path = "../common/mod.rs"]
mod common;
mod corpus;
mod counted;
mod culling;
mod flights;
#[cfg(feature = "step")]
#[path = "../corpus/folder.rs"]
mod folder;
mod frames;
mod instances;
mod pixels;
#[path = "../common/pools.rs"]
mod pools;
mod reads;
#[path = "../sequence/random.rs"]
mod random;
#[cfg(feature = "serde")]
mod recorded;
mod resident;

use common::{prepared, whole_frame};
use glam::{DAffine3, DQuat, DVec2, DVec3};
use pixels::measured;
use random::SplitMix;
use std::sync::Arc;
use trimtess::frame::plan_for_view;
use trimtess::mesh::check_scene;
use trimtess::model::ModelBuilder;
use trimtess::prepare::Prepared;
use trimtess::view::{Camera, Projection, View};

/// A file of the corpus, if it exists and can be read.
#[cfg(feature = "step")]
fn of_corpus(name: &str) -> Option<Arc<Prepared>> {
    use trimtess::import::step;
    let file = folder::corpus()?.join(name);
    Some(prepared(step::read_file(&file, &step::StepOptions::DEFAULT).unwrap()))
}

#[cfg(not(feature = "step"))]
fn of_corpus(_: &str) -> Option<Arc<Prepared>> {
    println!("skipped: files are not read without the feature step");
    None
}

fn shape(name: &str) -> Arc<Prepared> {
    prepared(trimtess_models::by_name(name).unwrap())
}

/// A part placed twice, once rotated and three times as large.
fn two_sizes(name: &str) -> Arc<Prepared> {
    let mut model = ModelBuilder::new("two");
    let part = model.part(trimtess_models::by_name(name).unwrap().parts.swap_remove(0));
    model.place(part, DAffine3::IDENTITY);
    let turn = DQuat::from_rotation_y(1.0);
    let transform = DAffine3::from_scale_rotation_translation(DVec3::splat(3.0), turn, DVec3::new(60.0, 10.0, -20.0));
    model.place(part, transform);
    prepared(model.finish().unwrap())
}

#[test]
fn every_tile_keeps_the_screen_space_error_and_no_border_opens() {
    let mut draw = SplitMix(1);
    for name in ["torus", "sphere", "cylinder", "wave", "flower", "teapot"] {
        let prepared = shape(name);
        let (mut most, mut all) = (0.0_f64, 0);
        for _ in 0..8 {
            let view = draw.view(prepared.bounds.unwrap(), (0.9, 4.0));
            let plan = plan_for_view(&prepared, &view);
            assert_eq!(plan.shortfall, None, "{name} {view:?}");
            let frame = whole_frame(&prepared, &plan, false);
            let (share, seen) = measured(&prepared, &view, 0.05 * prepared.scene.parts[0].radius, &frame);
            assert!(share <= 1.0, "{name}: {share} times the tolerance of {view:?}");
            let facts = check_scene(&frame).total;
            assert_eq!(facts.is_closed(), !["wave", "flower", "teapot"].contains(&name), "{name} {view:?}");
            (most, all) = (most.max(share), all + seen);
        }
        assert!(most > 0.3 && all > 10_000, "{name}: at most {most} of the tolerance at {all} points");
    }
}

#[test]
fn the_instance_with_the_largest_screen_space_error_decides() {
    let mut draw = SplitMix(2);
    let prepared = two_sizes("torus");
    for _ in 0..12 {
        let view = draw.view(prepared.bounds.unwrap(), (0.5, 3.0));
        let frame = whole_frame(&prepared, &plan_for_view(&prepared, &view), false);
        let (share, _) = measured(&prepared, &view, 0.15 * prepared.scene.parts[0].radius, &frame);
        assert!(share <= 1.0, "{share} times the tolerance of {view:?}");
    }
}

#[test]
fn distant_tiles_are_coarser_than_near_ones() {
    let prepared = shape("teapot");
    let [low, high] = prepared.bounds.unwrap();
    let height = 0.5 * (low.z + high.z);
    let view = View {
        camera: Camera {
            eye: DVec3::new(high.x + 20.0, 0.0, height),
            forward: -DVec3::X,
            up: DVec3::Z,
            projection: Projection::Perspective { fov_y: 1.0, near: 1.0 },
        },
        size: (1000, 800),
        deviation_px: 0.5,
        size_px: None,
        angle: 1.5,
    };
    let plan = plan_for_view(&prepared, &view);
    let depth = |tile: usize| view.camera.eye.x - prepared.parts[0].tiles[tile].centre.x;
    let chord = |tile: usize| plan.parts[0].tiles[tile].chord;
    let by_depth = |a: &usize, b: &usize| depth(*a).total_cmp(&depth(*b));
    let all = 0..prepared.parts[0].tiles.len();
    let (near, far) = (all.clone().min_by(by_depth).unwrap(), all.max_by(by_depth).unwrap());
    let (ratio, depths) = (chord(far) / chord(near), depth(far) / depth(near));
    assert!(ratio > 0.7 * depths && depths > 4.0, "{ratio} at {depths} times the distance");
    // In an orthographic view distance does not matter.
    let mut parallel = view;
    parallel.camera.projection = Projection::Orthographic { height: 100.0 };
    let mut back = parallel;
    back.camera.eye += DVec3::X * 1e4;
    let plan = plan_for_view(&prepared, &parallel);
    assert!(plan.parts[0].tiles.iter().all(|tile| tile.chord == 0.5 * 100.0 / 800.0));
    assert_eq!(plan, plan_for_view(&prepared, &back));
}

#[test]
fn a_camera_inside_does_not_explode_the_cost() {
    let mut draw = SplitMix(3);
    for name in ["teapot", "torus", "flower"] {
        let prepared = shape(name);
        let bounds = prepared.bounds.unwrap();
        let mut most = 0;
        for k in 0..24 {
            let mut view = draw.view(bounds, (0.0, 0.7));
            view.camera.projection = Projection::Perspective { fov_y: 1.0, near: 0.0 };
            view.size = (1920, 1080);
            (view.deviation_px, view.size_px) = (0.5, None);
            if k % 2 == 0 {
                // On the surface.
                let tile = &prepared.parts[0].tiles[draw.range(0.0, prepared.parts[0].tiles.len() as f64) as usize];
                let face = prepared.parts[0].face_of(tile);
                let uv = tile.min + (tile.max - tile.min) * DVec2::new(draw.unit(), draw.unit());
                view.camera.eye = face.patches.point(uv.x, uv.y);
            }
            let plan = plan_for_view(&prepared, &view);
            assert_eq!(plan.shortfall, None, "{name} {view:?}");
            let cells = plan.parts[0].tiles.iter().map(|tile| u64::from(tile.cells().0) * u64::from(tile.cells().1));
            most = most.max(cells.sum());
        }
        assert!(most < 500_000, "{name}: {most} cells");
        assert!(most > 1000, "{name}: {most} cells");
    }
}

#[test]
fn invalid_cameras_are_reported() {
    let prepared = shape("teapot");
    let view = SplitMix(4).view(prepared.bounds.unwrap(), (1.0, 1.5));
    let camera = view.camera;
    let projected = |projection| View { camera: Camera { projection, ..camera }, ..view };
    for broken in [
        View { camera: Camera { eye: DVec3::NAN, ..camera }, ..view },
        View { camera: Camera { forward: DVec3::ZERO, ..camera }, ..view },
        View { camera: Camera { up: camera.forward, ..camera }, ..view },
        View { size: (0, 100), ..view },
        projected(Projection::Perspective { fov_y: f64::NAN, near: 0.0 }),
        projected(Projection::Perspective { fov_y: 1.0, near: f64::INFINITY }),
        projected(Projection::Orthographic { height: 0.0 }),
    ] {
        let plan = plan_for_view(&prepared, &broken);
        assert!(plan.shortfall.is_some_and(|s| s.unusable), "{broken:?}");
        let cells = plan.parts[0].tiles.iter().map(|tile| tile.cells().0 * tile.cells().1);
        assert!(cells.max() < Some(100));
    }
}

#[test]
fn pixels_too_small_for_any_mesh_are_reported() {
    let prepared = shape("box");
    let view = View { angle: 0.5, ..SplitMix(4).view(prepared.bounds.unwrap(), (2.0, 2.5)) };
    for (size_px, unusable) in [(4.0, false), (1e-3, true), (1e-6, true), (1e-9, true)] {
        let short = plan_for_view(&prepared, &View { size_px: Some(size_px), ..view }).shortfall;
        assert_eq!(short.is_some_and(|s| s.unusable && s.by_limits()), unusable, "{size_px} pixels");
    }
    // Close to a face, lines end at their limit without being too fine for the rest of the part.
    let eye = prepared.bounds.unwrap().map(|corner| corner * 0.999)[1];
    let near = View { camera: Camera { eye, ..view.camera }, size_px: Some(1.0), ..view };
    assert!(!plan_for_view(&prepared, &near).shortfall.is_some_and(|s| s.unusable), "{near:?}");
}
