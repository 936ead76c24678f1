//! View points: names, numbers, and cameras that exactly hold what they are fitted to.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::{DVec3, DVec4};
use trimtess::view::{Camera, Projection, ViewPoint};

fn corners(low: DVec3, high: DVec3) -> Vec<DVec3> {
    (0..8).map(|k| DVec3::select(glam::BVec3::new(k & 1 > 0, k & 2 > 0, k & 4 > 0), high, low)).collect()
}

#[test]
fn fitted_cameras_touch_the_margin_and_nothing_more() {
    let points = corners(DVec3::new(-3.0, 100.0, 5.0), DVec3::new(40.0, 130.0, 6.0));
    for (aspect, view) in [(1.5, "iso"), (0.5, "front"), (1.0, "top"), (2.0, "bottom"), (1.2, "-30,20"), (1.0, "left")]
    {
        let camera = view.parse::<ViewPoint>().unwrap().fit(points.clone(), aspect);
        let clip = camera.projection_matrix(aspect, 1e-3, f64::INFINITY) * camera.view_matrix();
        let seen: Vec<DVec4> = points.iter().map(|p| clip * p.extend(1.0)).map(|c| c / c.w).collect();
        let reach = |axis: fn(&DVec4) -> f64| {
            let values = || seen.iter().map(axis);
            (values().fold(f64::MAX, f64::min), values().fold(f64::MIN, f64::max))
        };
        let ((left, right), (below, above)) = (reach(|p| p.x), reach(|p| p.y));
        let widest = right.max(above);
        assert!((widest - 1.0 / 1.06).abs() < 1e-9, "{view}: {left} {right} {below} {above}");
        assert!(left >= -widest - 1e-9 && below >= -widest - 1e-9);
        assert!(seen.iter().all(|p| p.z > 0.0 && p.z < 1.0));
    }
}

#[test]
fn fitted_parallel_cameras_touch_the_margin_and_nothing_more() {
    let points = corners(DVec3::new(-3.0, 100.0, 5.0), DVec3::new(40.0, 130.0, 6.0));
    for (aspect, view) in [(1.5, "iso"), (0.5, "front"), (1.0, "top"), (2.0, "bottom"), (1.2, "-30,20"), (1.0, "left")]
    {
        let camera = view.parse::<ViewPoint>().unwrap().fit_orthographic(points.clone(), aspect);
        let depths = points.iter().map(|p| -camera.view_matrix().transform_point3(*p).z);
        let (near, far) = depths.fold((f64::MAX, f64::MIN), |(near, far), z| (near.min(z), far.max(z)));
        let clip = camera.projection_matrix(aspect, near - 1.0, far + 1.0) * camera.view_matrix();
        let seen: Vec<DVec4> = points.iter().map(|p| clip * p.extend(1.0)).collect();
        let widest = seen.iter().map(|p| p.x.abs().max(p.y.abs())).fold(0.0, f64::max);
        assert!((widest - 1.0 / 1.06).abs() < 1e-9 && near > 0.0, "{view}: {widest} {near}");
        assert!(seen.iter().all(|p| p.z > 0.0 && p.z < 1.0 && p.w == 1.0));
    }
    let [one, three] =
        ["10,20,1", "10,20,3"].map(|view| view.parse::<ViewPoint>().unwrap().fit_orthographic(points.clone(), 1.0));
    let height = |camera: &Camera| match camera.projection {
        Projection::Orthographic { height } => height,
        Projection::Perspective { .. } => f64::NAN,
    };
    assert!((height(&three) / height(&one) - 3.0).abs() < 1e-12 && one.target().distance(three.target()) < 1e-12);
}

#[test]
fn named_views_look_along_their_axes() {
    let points = corners(DVec3::splat(-1.0), DVec3::ONE);
    let towards_eye = |name: &str| {
        let camera = name.parse::<ViewPoint>().unwrap().fit(points.clone(), 1.0);
        ((camera.eye - camera.target()).normalize(), camera.up)
    };
    let close = |a: DVec3, b: DVec3| a.distance(b) < 1e-12;
    for (name, eye, up) in [
        ("front", DVec3::NEG_Y, DVec3::Z),
        ("back", DVec3::Y, DVec3::Z),
        ("right", DVec3::X, DVec3::Z),
        ("left", DVec3::NEG_X, DVec3::Z),
        ("top", DVec3::Z, DVec3::Y),
        ("bottom", DVec3::NEG_Z, DVec3::NEG_Y),
    ] {
        let (seen_eye, seen_up) = towards_eye(name);
        assert!(close(seen_eye, eye) && close(seen_up, up), "{name}: {seen_eye} {seen_up}");
    }
    assert!(close(towards_eye("iso").0, DVec3::new(1.0, -1.0, 1.0).normalize()));
}

#[test]
fn distance_is_a_multiple() {
    let points = corners(DVec3::splat(-1.0), DVec3::ONE);
    let [near, far] = ["10,20,1", "10,20,3"].map(|view| view.parse::<ViewPoint>().unwrap().fit(points.clone(), 1.0));
    assert!(near.target().distance(far.target()) < 1e-12);
    assert!((far.eye.distance(far.target()) / near.eye.distance(near.target()) - 3.0).abs() < 1e-12);
}

#[test]
fn a_point_or_nothing_still_makes_a_camera() {
    for points in [vec![], vec![DVec3::new(5.0, 6.0, 7.0)]] {
        let camera = ViewPoint::ISO.fit(points, 1.0);
        assert!(camera.eye.distance(camera.target()) > 0.0 && camera.view_matrix().is_finite());
    }
}

#[test]
fn an_invalid_view_point_is_refused_with_help() {
    for text in ["", "isometric", "1", "1,2,0", "1,2,-1", "nan,0", "1,2,3,4"] {
        let error = text.parse::<ViewPoint>().unwrap_err();
        assert_eq!(error.text, text);
        assert!(error.to_string().contains("iso") && error.to_string().contains("yaw"));
    }
}
