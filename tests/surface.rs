//! Surfaces against closed forms, finite differences and their own inversion.
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "common/bumpy.rs"]
mod bumpy;

use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use trimtess::model::{Frame3, NurbsCurve3, NurbsSurface, Surface};

fn frame() -> Frame3 {
    Frame3::from_axis(DVec3::new(4.0, -2.0, 7.0), DVec3::new(1.0, 2.0, 3.0), DVec3::Y).unwrap()
}

/// A bumpy NURBS surface of degrees (3, 2) with uneven knots.
fn bumpy(rational: bool) -> NurbsSurface {
    let knots_u = vec![0.0, 0.0, 0.0, 0.0, 0.7, 1.1, 2.0, 2.0, 2.0, 2.0];
    let knots_v = vec![-1.0, -0.8, -0.5, 0.0, 0.7, 1.0, 1.5, 2.0];
    let uneven = |x: f64, y: f64| 1.0 + 0.5 * (2.1 * x - y).cos();
    bumpy::bumpy([3, 2], [knots_u, knots_v], if rational { Some(&uneven) } else { None })
}

/// Every kind of surface, with a box of natural parameters to sample.
fn zoo() -> Vec<(Surface, [(f64, f64); 2])> {
    let frame = frame();
    let curve = NurbsCurve3::arc(&frame, 2.0, 3.0, 0.3, 2.8);
    let turn = (0.0, TAU);
    let aside = Frame3 { origin: frame.origin + frame.x * 9.0, x: frame.y, y: frame.z, z: frame.x };
    let meridian = NurbsCurve3::arc(&Frame3 { z: -frame.y, y: frame.z, ..aside }, 2.0, 3.0, 0.3, 2.8);
    vec![
        (Surface::Plane { frame }, [(-3.0, 2.0), (1.0, 5.0)]),
        (Surface::Cylinder { frame, radius: 2.5 }, [turn, (-1.0, 4.0)]),
        (Surface::Cone { frame, radius: 1.5, half_angle: 0.4 }, [turn, (-2.0, 4.0)]),
        (Surface::Cone { frame, radius: 1.5, half_angle: -0.7 }, [turn, (-5.0, 1.0)]),
        (Surface::Sphere { frame, radius: 2.0 }, [turn, (-1.5, 1.5)]),
        (Surface::Torus { frame, major: 5.0, minor: 1.5 }, [turn, turn]),
        (Surface::Torus { frame, major: 1.0, minor: 1.5 }, [turn, (-2.2, 2.2)]),
        (Surface::Extrusion { curve, direction: DVec3::new(0.1, -2.0, 0.7) }, [(0.3, 2.8), (-3.0, 2.0)]),
        (Surface::Revolution { curve: meridian, frame }, [turn, (0.3, 2.8)]),
        (Surface::Nurbs(bumpy(false)), bumpy(false).domain().into()),
        (Surface::Nurbs(bumpy(true)), bumpy(true).domain().into()),
    ]
}

/// Parameters inside a box, off its borders and off round fractions.
fn inside([(u0, u1), (v0, v1)]: [(f64, f64); 2]) -> impl Iterator<Item = (f64, f64)> {
    (0..9).flat_map(move |i| {
        (0..9).map(move |j| (u0 + (u1 - u0) * (i as f64 + 0.47) / 9.0, v0 + (v1 - v0) * (j as f64 + 0.53) / 9.0))
    })
}

#[test]
fn derivatives_match_finite_differences() {
    let h = 1e-5;
    for (surface, area) in zoo() {
        for (u, v) in inside(area) {
            let d = surface.derivatives(u, v);
            let (left, right) = (surface.derivatives(u - h, v), surface.derivatives(u + h, v));
            let (down, up) = (surface.derivatives(u, v - h), surface.derivatives(u, v + h));
            for (exact, difference) in [
                (d.du, right.point - left.point),
                (d.dv, up.point - down.point),
                (d.duu, right.du - left.du),
                (d.duv, up.du - down.du),
                (d.duv, right.dv - left.dv),
                (d.dvv, up.dv - down.dv),
            ] {
                let error = exact.distance(difference / (2.0 * h));
                assert!(error < 2e-6 * (1.0 + exact.length()), "{surface:?} at {u} {v}: {error}");
            }
        }
    }
}

#[test]
fn points_and_tangents_have_the_bits_of_derivatives() {
    for (surface, domain) in zoo() {
        for (u, v) in inside(domain) {
            let d = surface.derivatives(u, v);
            assert_eq!(surface.point(u, v), d.point, "{surface:?}");
            assert_eq!(surface.tangents(u, v), [d.point, d.du, d.dv], "{surface:?}");
        }
    }
}

#[test]
fn normals_are_the_cross_product() {
    for (surface, area) in zoo() {
        for (u, v) in inside(area) {
            let d = surface.derivatives(u, v);
            let expected = d.du.cross(d.dv).normalize();
            assert!(surface.normal(u, v).unwrap().distance(expected) < 1e-12, "{surface:?} at {u} {v}");
        }
    }
}

#[test]
fn normals_at_poles_are_limits() {
    let frame = frame();
    let sphere = Surface::Sphere { frame, radius: 2.0 };
    assert!(sphere.normal(1.0, FRAC_PI_2).unwrap().distance(frame.z) < 1e-15);
    // The same half circle as a revolution, so that the limit is evaluated.
    let upright = Frame3 { y: frame.z, z: -frame.y, ..frame };
    let curve = NurbsCurve3::arc(&upright, 2.0, 2.0, -FRAC_PI_2, FRAC_PI_2);
    let turned = Surface::Revolution { curve, frame };
    assert!(turned.normal(1.0, FRAC_PI_2).unwrap().distance(frame.z) < 1e-5);
    assert!(turned.normal(1.0, -FRAC_PI_2).unwrap().distance(-frame.z) < 1e-5);
    assert_eq!(turned.poles().iter().map(|p| (p.axis, p.at)).collect::<Vec<_>>(), [(1, -FRAC_PI_2), (1, FRAC_PI_2)]);
    // A net collapsed to a line has no normal.
    let mut flat = bumpy(false);
    flat.points.iter_mut().for_each(|p| *p = DVec3::X * p.x);
    assert_eq!(Surface::Nurbs(flat).normal(0.5, 0.5), None);
}

#[test]
fn closed_forms_invert() {
    for (surface, area) in zoo() {
        let kept = matches!(surface, Surface::Extrusion { .. } | Surface::Revolution { .. } | Surface::Nurbs(_));
        for (u, v) in inside(area) {
            let found = surface.invert(surface.point(u, v));
            assert_eq!(found.is_none(), kept);
            let Some(found) = found else { continue };
            let wrapped = DVec2::new(
                if surface.period()[0].is_some() { u.rem_euclid(TAU) } else { u },
                if surface.period()[1].is_some() { v.rem_euclid(TAU) } else { v },
            );
            assert!(found.distance(wrapped) < 1e-11, "{surface:?} at {u} {v}: {found}");
        }
    }
}

#[test]
fn inversion_finds_the_nearest_sheet() {
    let frame = Frame3::WORLD;
    // Both nappes of a cone.
    let cone = Surface::Cone { frame, radius: 1.0, half_angle: PI / 4.0 };
    for (u, v) in [(0.5, 3.0), (0.5, -0.5), (0.5, -4.0), (4.0, -1.5)] {
        let found = cone.invert(cone.point(u, v)).unwrap();
        assert!(found.distance(DVec2::new(u, v)) < 1e-12, "{u} {v}: {found}");
    }
    // The lemon of a self-intersecting torus.
    let torus = Surface::Torus { frame, major: 1.0, minor: 1.5 };
    for (u, v) in [(1.0, 0.2), (1.0, 3.0), (5.0, 3.5), (6.0, 1.2)] {
        let found = torus.invert(torus.point(u, v)).unwrap();
        assert!(found.distance(DVec2::new(u, v)) < 1e-12, "{u} {v}: {found}");
    }
    assert_eq!(cone.invert(DVec3::NAN), None);
}

#[test]
fn poles_are_points() {
    let frame = frame();
    let mut pinched = bumpy(true);
    pinched.knots_v = vec![0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 3.0, 3.0];
    for i in 0..pinched.count_u() {
        pinched.points[i * 5 + 4] = DVec3::new(1.0, 9.0, 0.0);
    }
    let cases = [
        (Surface::Cone { frame, radius: 1.5, half_angle: -0.7 }, 1),
        (Surface::Sphere { frame, radius: 2.0 }, 2),
        (Surface::Torus { frame, major: 5.0, minor: 1.5 }, 0),
        (Surface::Torus { frame, major: 1.0, minor: 1.5 }, 2),
        (Surface::Torus { frame, major: 1.0, minor: 1.0 }, 1),
        (Surface::Nurbs(pinched), 1),
        (Surface::Nurbs(bumpy(true)), 0),
    ];
    for (surface, count) in cases {
        let poles = surface.poles();
        assert_eq!(poles.len(), count, "{surface:?}");
        let [(u0, u1), _] = surface.natural_domain();
        for pole in poles {
            assert_eq!(pole.axis, 1);
            for i in 0..=8 {
                let there = surface.point(u0 + (u1 - u0) * i as f64 / 8.0, pole.at);
                assert!(there.distance(pole.point) < 1e-12);
            }
        }
    }
}

#[test]
fn periods_are_found() {
    let frame = frame();
    let circle = NurbsCurve3::arc(&frame, 2.0, 2.0, 0.5, 0.5 + TAU);
    let around = |curve: NurbsCurve3| Surface::Extrusion { curve, direction: frame.z };
    assert_eq!(around(circle.clone()).period(), [Some(TAU), None]);
    assert_eq!(around(NurbsCurve3::arc(&frame, 2.0, 2.0, 0.0, 3.0)).period(), [None, None]);
    let far = Frame3 { origin: frame.origin + frame.x * 20.0, ..frame };
    assert_eq!(Surface::Revolution { curve: circle, frame: far }.period(), [Some(TAU), Some(TAU)]);
    // A horn torus: its circle closes on the axis, and the surface ends at its poles.
    let meridian = Frame3 { origin: frame.origin + frame.x * 2.0, x: frame.x, y: frame.z, z: -frame.y };
    let horn = Surface::Revolution { curve: NurbsCurve3::arc(&meridian, 2.0, 2.0, -PI, PI), frame };
    assert_eq!((horn.period(), horn.poles().len()), ([Some(TAU), None], 2));
    let (splines, _) = horn.to_nurbs((0.0, TAU), (-PI, PI));
    let horn = Surface::Nurbs(splines);
    assert_eq!((horn.period().map(|p| p.is_some()), horn.poles().len()), ([true, false], 2));
    // However low a tube is, its seam is no pole, and its ends are two.
    for height in [1.0, 1e-5, 1e-7] {
        let (tube, _) = Surface::Cylinder { frame, radius: 2.0 }.to_nurbs((0.0, TAU), (0.0, height));
        let tube = Surface::Nurbs(tube);
        assert_eq!((tube.period().map(|p| p.is_some()), tube.poles().len()), ([true, false], 0), "{height}");
    }
    let mut tube = bumpy(true);
    assert!(!tube.is_closed(0, 1e-9));
    for j in 0..5 {
        tube.points[5 * 5 + j] = tube.points[j];
        tube.weights[5 * 5 + j] = tube.weights[j];
    }
    assert!(tube.is_closed(0, 1e-9) && !tube.is_closed(1, 1e-9));
    assert_eq!(Surface::Nurbs(tube).period(), [Some(2.0), None]);
}

#[test]
fn nurbs_forms_are_exact() {
    for (surface, [u, v]) in zoo() {
        let (nurbs, [map_u, map_v]) = surface.to_nurbs(u, v);
        let size = nurbs.points.iter().fold(0.0_f64, |size, p| size.max(p.distance(nurbs.points[0])));
        let ((u0, u1), (v0, v1)) = nurbs.domain();
        assert_eq!((map_u.to_nurbs(u.0), map_u.to_nurbs(u.1)), (u0, u1));
        assert_eq!((map_v.to_nurbs(v.0), map_v.to_nurbs(v.1)), (v0, v1));
        let corners = [(u.0, v.0), (u.1, v.1), (u.0, v.1)];
        for (a, b) in inside([u, v]).chain(corners) {
            let error = nurbs.point(map_u.to_nurbs(a), map_v.to_nurbs(b)).distance(surface.point(a, b));
            assert!(error <= 1e-13 * (size + surface.point(a, b).length()), "{surface:?} at {a} {b}: {error}");
        }
        assert_eq!(nurbs.points.len(), nurbs.count_u() * nurbs.count_v());
    }
}

#[test]
fn a_lattice_has_the_points_of_its_pairs() {
    for net in [bumpy(false), bumpy(true)] {
        // Beyond the domain, at knots and between them.
        let us = [-0.5, 0.0, 0.3, 0.7, 1.1, 1.9, 2.0];
        let vs = [-0.5, -0.1, 0.7, 1.0, 2.5];
        let points = net.lattice(&us, &vs);
        let pairs = us.iter().flat_map(|&u| vs.iter().map(move |&v| (u, v)));
        assert_eq!(points, pairs.map(|(u, v)| net.point(u, v)).collect::<Vec<_>>());
    }
}

#[test]
fn axis_maps_go_both_ways() {
    for (start, sweep) in [(0.0, TAU), (-0.3, 0.1), (1.0, 4.0), (-7.0, 3.0 * TAU)] {
        let cylinder = Surface::Cylinder { frame: Frame3::WORLD, radius: 1.0 };
        let (nurbs, [map, _]) = cylinder.to_nurbs((start, start + sweep), (0.0, 1.0));
        for &knot in &nurbs.knots_u {
            assert_eq!(map.to_nurbs(knot), knot);
            assert_eq!(map.to_natural(knot), knot);
        }
        let mut before = f64::NEG_INFINITY;
        for i in -20..=120 {
            let angle = start + sweep * i as f64 / 100.0;
            let nurbs = map.to_nurbs(angle);
            assert!(nurbs > before);
            before = nurbs;
            assert!((map.to_natural(nurbs) - angle).abs() < 1e-13 * (1.0 + angle.abs()));
            let h = 1e-6;
            let slope = (map.to_nurbs(angle + h) - map.to_nurbs(angle - h)) / (2.0 * h);
            assert!((slope - map.rate(angle)).abs() < 1e-6, "{angle}: {slope} {}", map.rate(angle));
            assert!(map.rate(angle) > 0.785 && map.rate(angle) < 1.28);
        }
    }
}

#[test]
fn pole_rows_are_one_point() {
    let sphere = Surface::Sphere { frame: frame(), radius: 3.0 };
    let (nurbs, _) = sphere.to_nurbs((0.0, TAU), (-FRAC_PI_2, FRAC_PI_2));
    let nv = nurbs.count_v();
    for i in 0..nurbs.count_u() {
        assert_eq!(nurbs.points[i * nv], nurbs.points[0]);
        assert_eq!(nurbs.points[i * nv + nv - 1], nurbs.points[nv - 1]);
    }
    let cone = Surface::Cone { frame: frame(), radius: 1.5, half_angle: 0.4 };
    let apex = cone.poles()[0].at;
    let (nurbs, _) = cone.to_nurbs((0.0, 1.0), (apex, 2.0));
    assert_eq!(nurbs.points[0], nurbs.points[2]);
}

#[test]
fn closed_nets_unroll() {
    // A tube closed in u: clamped (the bumpy net with equal border rows) and unclamped (wrapped rows, even knots).
    let mut clamped = bumpy(true);
    for j in 0..5 {
        clamped.points[5 * 5 + j] = clamped.points[j];
        clamped.weights[5 * 5 + j] = 2.0 * clamped.weights[j];
    }
    let mut wrapped = bumpy(true);
    wrapped.knots_u = (0..10).map(f64::from).collect();
    for j in 0..15 {
        wrapped.points[15 + j] = wrapped.points[j];
        wrapped.weights[15 + j] = wrapped.weights[j];
    }
    for tube in [clamped, wrapped] {
        let surface = Surface::Nurbs(tube.clone());
        let ((u0, u1), v) = tube.domain();
        let period = u1 - u0;
        assert_eq!(surface.period(), [Some(period), None]);
        let (unrolled, _) = surface.to_nurbs((u0 - 0.4 * period, u1 + 1.2 * period), v);
        let ((a, b), _) = unrolled.domain();
        assert!((a - (u0 - period)).abs() < 1e-12 && (b - (u1 + 2.0 * period)).abs() < 1e-12);
        for i in 0..100 {
            let u = u0 + period * (3.99 * i as f64 / 100.0 - 0.99);
            let once = u0 + (u - u0).rem_euclid(period);
            let w = 0.3 * v.0 + 0.7 * v.1;
            assert!(unrolled.point(u, w).distance(tube.point(once, w)) < 1e-12, "{u}");
        }
        assert_eq!(surface.to_nurbs((u0, u1), v).0, tube);
    }
    // A closed extruded curve and a closed meridian.
    let circle = NurbsCurve3::arc(&frame(), 2.0, 2.0, 0.0, TAU);
    let tube = Surface::Extrusion { curve: circle.clone(), direction: frame().z };
    let (unrolled, _) = tube.to_nurbs((-1.0, 7.0), (0.0, 1.0));
    assert!(unrolled.point(-1.0, 0.5).distance(tube.point(TAU - 1.0, 0.5)) < 1e-12);
    let far = Frame3 { origin: frame().origin + frame().x * 20.0, ..frame() };
    let ring = Surface::Revolution { curve: circle, frame: far };
    let (unrolled, [map, _]) = ring.to_nurbs((1.0, 2.0), (3.0, 9.0));
    assert!(unrolled.point(map.to_nurbs(1.3), 8.0).distance(ring.point(1.3, 8.0 - TAU)) < 1e-11);
}
