//! Planes that cut pictures and picks.

use super::own_pipelines::devices;
use super::*;
use trimtess::out::wgpu::Section;

const BOX: DVec3 = DVec3::new(3.0, 2.0, 1.0);

#[test]
fn a_section_cuts_pictures_and_picks() {
    let bounds = [DVec3::ZERO, BOX];
    let camera = "0,0".parse::<ViewPoint>().unwrap().fit(bounds, f64::from(SIZE.0) / f64::from(SIZE.1));
    let axis = (0..3).max_by(|a, b| camera.forward[*a].abs().total_cmp(&camera.forward[*b].abs())).unwrap();
    let middle = (SIZE.0 / 2, SIZE.1 / 2);
    for (device, queue) in devices() {
        let mut live = LiveScene::new(&device, &queue, wgpu::TextureFormat::Rgba8UnormSrgb).unwrap();
        send(&box_frame(BOX, &[DAffine3::IDENTITY]), &mut live);
        let mut seen = |section: Option<Section>, camera: Camera| {
            let view = RenderOptions::DEFAULT.with_size(SIZE).with_camera(Some(camera)).with_section(section);
            live.pick(middle, 0, &view).unwrap().map(|hit| hit.point[axis])
        };
        for camera in [camera, camera.orthographic()] {
            let away = if camera.forward[axis] > 0.0 { [0.0, BOX[axis]] } else { [BOX[axis], 0.0] };
            let is = |found: Option<f64>, wanted: f64| found.is_some_and(|at| (at - wanted).abs() < 1e-3);
            assert!(is(seen(None, camera), away[0]));
            let across = Section::across(bounds, axis, 0.5);
            let (near, far) = if away[0] == 0.0 { (across.flipped(), across) } else { (across, across.flipped()) };
            // Without its near half the box shows the inside of its far face; without the other half its near face.
            assert!(is(seen(Some(near), camera), away[1]) && is(seen(Some(far), camera), away[0]), "{camera:?}");
            let all = Section { point: DVec3::splat(-1.0), normal: DVec3::ONE };
            assert_eq!(seen(Some(all), camera), None);
            for nothing in [Section { normal: DVec3::ZERO, ..all }, Section { point: DVec3::NAN, ..all }] {
                assert!(is(seen(Some(nothing), camera), away[0]));
            }
        }
    }
}

#[test]
fn what_is_cut_shows_its_inside_flat_and_no_lines() {
    let Some(renderer) = renderer() else { return };
    let mut live = renderer.live();
    send(&box_frame(BOX, &[DAffine3::IDENTITY]), &mut live);
    let camera = ViewPoint::ISO.fit([DVec3::ZERO, BOX], f64::from(SIZE.0) / f64::from(SIZE.1));
    let view = RenderOptions::DEFAULT.with_size(SIZE).with_camera(Some(camera));
    let across = Section::across([DVec3::ZERO, BOX], 2, 0.5);
    let whole = picture(renderer, &mut live, &view);
    let open = picture(renderer, &mut live, &view.with_section(Some(across)));
    assert_ne!(whole.pixels, open.pixels);
    // The middle of the cut shows a side or the floor from within, the same colour all around.
    let (x, y) = pixel_of(&camera, DVec3::new(1.5, 1.0, 0.2));
    let inside = open.pixel(x, y).unwrap();
    assert!((0..9).all(|k| open.pixel(x + k % 3 - 1, y + k / 3 - 1) == Some(inside)));
    // Lines of what is cut away are gone: without surfaces and lines only the background is left.
    let all = view.with_section(Some(Section { point: DVec3::splat(-1.0), normal: DVec3::ONE }));
    let nothing = picture(renderer, &mut live, &all);
    let lines = picture(renderer, &mut live, &all.with_edges(true).with_wireframe(true));
    assert_eq!(nothing.pixels, lines.pixels);
}
