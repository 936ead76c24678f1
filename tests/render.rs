//! Pictures of a small box: what is covered, from where, in which colours. Skipped without an adapter.
#![cfg(feature = "wgpu")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod adapter;
mod folders;
mod out_fixture;

use adapter::renderer;
use folders::folder;
use glam::{DAffine3, DVec3};
use out_fixture::box_frame;
use trimtess::mesh::MemorySink;
use trimtess::out::wgpu::{ColourBy, Image, NoAdapter, RenderError, RenderOptions};
use trimtess::view::{Camera, ViewPoint};

const SIZE: (u32, u32) = (240, 180);
const PLAIN: RenderOptions = RenderOptions::DEFAULT.with_size(SIZE);

fn cube() -> MemorySink {
    box_frame(DVec3::splat(20.0), &[DAffine3::IDENTITY])
}

fn from(view: &str, frame: &MemorySink) -> Camera {
    let points = frame.batches.iter().flat_map(|batch| batch.mesh.positions.clone());
    view.parse::<ViewPoint>().unwrap().fit(points, f64::from(SIZE.0) / f64::from(SIZE.1))
}

fn centre(image: &Image) -> [u8; 4] {
    image.pixel(image.width / 2, image.height / 2).unwrap()
}

/// Whether a pixel shows the backdrop, which depends on the row alone.
fn is_backdrop(image: &Image, x: u32, y: u32) -> bool {
    image.pixel(x, y) == image.pixel(0, y)
}

#[test]
fn a_cube_covers_the_centre_and_leaves_the_corners() {
    let Some(renderer) = renderer() else { return };
    let image = renderer.render(&cube(), &PLAIN).unwrap();
    assert_eq!((image.width, image.height, image.pixels.len()), (240, 180, 240 * 180 * 4));
    assert!(!is_backdrop(&image, 120, 90));
    for x in [0, 239] {
        let (top, bottom) = (image.pixel(x, 0).unwrap(), image.pixel(x, 179).unwrap());
        assert!(top[0] > 240 && bottom[0] < 220 && bottom[0] > 200, "{top:?} {bottom:?}");
    }
    // The fit leaves a margin of 6 %: the outline nearly touches the picture's top and bottom.
    let covered: Vec<u32> = (0..180).filter(|&y| (0..240).any(|x| !is_backdrop(&image, x, y))).collect();
    assert!((4..8).contains(&covered[0]) && (172..176).contains(covered.last().unwrap()), "{covered:?}");
}

#[test]
fn view_points_show_their_side() {
    let Some(renderer) = renderer() else { return };
    let frame = cube(); // face 0, the bottom, is red
    for (view, _) in ViewPoint::NAMED {
        let image = renderer.render(&frame, &PLAIN.with_camera(Some(from(view, &frame)))).unwrap();
        let [r, g, ..] = centre(&image);
        assert_eq!(r > g.saturating_mul(2), *view == "bottom", "{view}: {:?}", centre(&image));
    }
}

#[test]
fn a_turned_face_is_magenta() {
    let Some(renderer) = renderer() else { return };
    let mut frame = cube();
    let camera = Some(from("top", &frame));
    let plain = renderer.render(&frame, &PLAIN.with_camera(camera).with_backfaces(true)).unwrap();
    frame.batches[1].mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
    let turned = renderer.render(&frame, &PLAIN.with_camera(camera).with_backfaces(true)).unwrap();
    let hidden = renderer.render(&frame, &PLAIN.with_camera(camera)).unwrap();
    let [r, g, b, _] = centre(&turned);
    assert!(r / 2 > g && b / 2 > g, "{:?}", centre(&turned));
    assert_eq!(centre(&plain), centre(&hidden));
}

#[test]
fn a_mirrored_cube_shows_its_front() {
    let Some(renderer) = renderer() else { return };
    let mut frame = cube();
    frame.scene.instances[0].transform = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let image = renderer.render(&frame, &PLAIN.with_backfaces(true)).unwrap();
    assert!(image.pixels.chunks(4).all(|pixel| i32::from(pixel[0]) - i32::from(pixel[1]) < 100));
}

#[test]
fn lines_lie_on_the_surface_and_hidden_ones_do_not_show() {
    let Some(renderer) = renderer() else { return };
    let mut frame = cube();
    let camera = Some(from("front", &frame));
    let inked = |options: &RenderOptions, frame: &MemorySink| {
        let plain = renderer.render(frame, &options.with_edges(false).with_wireframe(false)).unwrap();
        let image = renderer.render(frame, options).unwrap();
        let pixels = image.pixels.chunks(4).zip(plain.pixels.chunks(4));
        pixels.filter(|(pixel, plain)| pixel[0] < plain[0].saturating_sub(20)).count()
    };
    // Two of the four edges along z are in front, each 160 pixels long and 1.7 wide.
    let edges = inked(&PLAIN.with_camera(camera).with_edges(true), &frame);
    assert!((320..800).contains(&edges), "{edges}");
    frame.edge_lines.retain(|line| line.points[0].y > 0.0);
    assert_eq!(inked(&PLAIN.with_camera(camera).with_edges(true), &frame), 0, "the edges behind are hidden");
    // Four sides and a diagonal.
    let wires = inked(&PLAIN.with_camera(camera).with_wireframe(true), &frame);
    assert!((4 * 150 + 210..4 * 320 + 460).contains(&wires), "{wires}");
}

#[test]
fn colours_show_the_requested_property() {
    let Some(renderer) = renderer() else { return };
    let mut frame = cube();
    frame.batches.iter_mut().for_each(|batch| batch.worker = batch.tile.0 % 2);
    let hues = |colour_by| {
        let mut hues: Vec<[f32; 2]> = Vec::new();
        for (view, _) in &ViewPoint::NAMED[1..] {
            let options = PLAIN.with_camera(Some(from(view, &frame))).with_colour_by(colour_by);
            let [r, g, b, _] = centre(&renderer.render(&frame, &options).unwrap()).map(f32::from);
            let hue = [r / b, g / b]; // lighting differs between sides, these ratios hardly
            if hues.iter().all(|known| (known[0] - hue[0]).abs() + (known[1] - hue[1]).abs() > 0.1) {
                hues.push(hue);
            }
        }
        hues.len()
    };
    let counts: Vec<_> = ColourBy::ALL.iter().map(|by| (by.name(), hues(*by))).collect();
    let counted = |name: &str| counts.iter().find(|(known, _)| *known == name).unwrap().1;
    assert_eq!((counted("face"), counted("tile"), counted("worker")), (6, 6, 2), "{counts:?}");
    assert_eq!((counted("model"), counted("part"), counted("rate")), (2, 1, 1), "{counts:?}");
}

#[test]
fn pictures_are_stable_far_from_the_origin() {
    let Some(renderer) = renderer() else { return };
    let near = renderer.render(&cube(), &PLAIN).unwrap();
    let mut frame = cube();
    frame.scene.instances[0].transform = DAffine3::from_translation(DVec3::new(1e8, -3e8, 2e8));
    assert_eq!(renderer.render(&frame, &PLAIN).unwrap(), near);
}

#[test]
fn impossible_pictures_are_refused() {
    let Some(renderer) = renderer() else { return };
    for size in [(0, 10), (10, 1 << 30)] {
        let refused = renderer.render(&cube(), &PLAIN.with_size(size));
        assert!(matches!(refused, Err(RenderError::Size { .. })));
    }
    let empty = renderer.render(&MemorySink::default(), &PLAIN).unwrap();
    assert!(is_backdrop(&empty, 120, 90));
}

#[test]
fn messages_state_what_to_do() {
    let none = NoAdapter { found: vec!["Some GPU: too old".into()] }.to_string();
    assert!(none.contains("Some GPU: too old") && none.contains("mesa-vulkan-drivers"), "{none}");
    let unknown = "depth".parse::<ColourBy>().unwrap_err().to_string();
    assert!(ColourBy::ALL.iter().all(|by| unknown.contains(by.name())), "{unknown}");
}

#[test]
fn png_files_carry_the_pixels() {
    let Some(renderer) = renderer() else { return };
    let folder = folder("render_png");
    let path = folder.join("cube.png");
    let options = PLAIN.with_size((241, 180)).with_wireframe(true);
    let image = renderer.render(&cube(), &options).unwrap();
    image.write_png(&path).unwrap();
    let file = std::fs::read(&path).unwrap();
    assert_eq!(&file[1..4], b"PNG");
    assert_eq!(file[16..24], [[0, 0, 0, 241], [0, 0, 0, 180]].concat());
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
}
