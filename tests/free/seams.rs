//! Free trims on closed surfaces, across their seams, and on unbounded surfaces.

use crate::meshes::{mesh, prepared};
use glam::DVec2;
use std::f64::consts::{PI, TAU};
use trimtess::mesh::check_scene;
use trimtess::model::{FaceError, Frame3, FreeTrims, Severity, Surface, TrimCurve, TrimRule, TrimTrouble};
use trimtess::prepare::{FreeRegion, UvDomain};

const RULES: [TrimRule; 3] = [TrimRule::Handedness, TrimRule::NonZero, TrimRule::EvenOdd];

fn torus() -> UvDomain {
    UvDomain { low: DVec2::ZERO, high: DVec2::splat(TAU), periodic: [true; 2] }
}

fn region(rule: TrimRule, curves: Vec<TrimCurve>) -> FreeRegion {
    FreeRegion::new(&FreeTrims { rule, curves }, &torus()).unwrap()
}

#[test]
fn loops_continue_across_seams() {
    let whole = TAU * TAU;
    for centre in [(3.0, 3.0), (0.1, 3.0), (6.2, 3.0), (3.0, -0.2), (0.0, TAU), (0.3, 0.2), (7.0, -9.0)] {
        let disk = TrimCurve::circle(centre.into(), 0.5);
        let area = PI * 0.25;
        for rule in RULES {
            let kept = region(rule, vec![disk.clone()]);
            assert!((kept.area() - area).abs() <= 1e-9, "{centre:?} {rule:?}: {}", kept.area());
            assert!(kept.notes.is_empty(), "{:?}", kept.notes);
        }
        let pierced = region(TrimRule::Handedness, vec![disk.reversed()]);
        assert!((pierced.area() - whole + area).abs() <= 1e-9, "{centre:?}: {}", pierced.area());
        // Two circles that intersect across a seam.
        let other = TrimCurve::circle(DVec2::from(centre) + DVec2::X * 0.5, 0.5);
        let lens = 0.25 * (TAU / 3.0 - (TAU / 3.0).sin());
        let both = region(TrimRule::Handedness, vec![disk.clone(), other]);
        assert!((both.area() - lens).abs() <= 1e-9, "{centre:?}: {}", both.area());
    }
    // Wider than the period: its ends overlap.
    let wide = region(TrimRule::NonZero, vec![TrimCurve::ellipse(DVec2::splat(3.0), DVec2::X * 4.0, DVec2::Y * 0.5)]);
    let beyond = PI / 4.0_f64;
    let end = 2.0 * (beyond.acos() - beyond * (1.0 - beyond * beyond).sqrt());
    assert!((wide.area() - (TAU - 2.0 * end)).abs() <= 1e-9, "{} {end}", wide.area());
    assert!(wide.notes.iter().any(|n| n.what == TrimTrouble::CrossesItself { curve: 0 }), "{:?}", wide.notes);
}

#[test]
fn curves_around_a_closed_surface_keep_their_left() {
    for start in [0.0, 2.0, 6.0, -1.0] {
        let at = |u: f64, v: f64| DVec2::new(start + u, v);
        let around = TrimCurve::polyline(vec![at(0.0, 1.0), at(2.0, 1.5), at(TAU, 1.0)]);
        let below = TAU * 1.25;
        for rule in RULES {
            let kept = region(rule, vec![around.clone()]);
            assert!((kept.area() - (TAU * TAU - below)).abs() <= 1e-9, "{start} {rule:?}: {}", kept.area());
            let kept = region(rule, vec![around.reversed()]);
            assert!((kept.area() - below).abs() <= 1e-9, "{start} {rule:?}: {}", kept.area());
        }
        let ring = vec![around.clone(), TrimCurve::polyline(vec![at(TAU, 2.0), at(0.0, 2.0)])];
        let kept = region(TrimRule::Handedness, ring);
        assert!((kept.area() - (2.0 * TAU - below)).abs() <= 1e-9, "{start}: {}", kept.area());
    }
}

#[test]
fn holes_leave_nothing_else_open_over_seams_and_away_from_them() {
    let sphere = Surface::Sphere { frame: Frame3::WORLD, radius: 1.0 };
    let torus = Surface::Torus { frame: Frame3::WORLD, major: 3.0, minor: 1.0 };
    // The boundary of a hole is at most `rim` times as long in space as in (u,v).
    for (surface, centre, rim) in [
        (sphere.clone(), (3.0, 0.3), 1.0),
        (sphere, (0.1, 0.3), 1.0),
        (torus.clone(), (3.0, 2.0), 3.5),
        (torus.clone(), (0.1, 2.0), 3.5),
        (torus.clone(), (3.0, 6.2), 4.2),
        (torus, (0.1, 0.2), 4.2),
    ] {
        let hole = TrimCurve::circle(centre.into(), 0.4).reversed();
        let prepared = prepared(surface, FreeTrims { rule: TrimRule::Handedness, curves: vec![hole] });
        assert!(prepared.diagnostics.is_empty(), "{:?}", prepared.diagnostics);
        for chord in [1e-1, 1e-2, 1e-3] {
            let (sink, report) = mesh(&prepared, chord);
            assert!(report.degraded.is_empty(), "{:?}", report.degraded);
            let facts = check_scene(&sink).total;
            assert!(facts.is_well_formed(), "{facts}");
            let open = facts.unbalanced_length;
            assert!(open <= TAU * 0.4 * rim && open >= 0.4, "{centre:?}: {facts}");
        }
    }
}

#[test]
fn curves_bound_what_they_keep_of_a_surface_that_does_not_end() {
    let plane = || Surface::Plane { frame: Frame3::WORLD };
    let curves =
        vec![TrimCurve::circle(DVec2::new(7.0, -3.0), 2.0), TrimCurve::circle(DVec2::new(7.5, -3.0), 1.0).reversed()];
    let disk = prepared(plane(), FreeTrims { rule: TrimRule::Handedness, curves: curves.clone() });
    assert!(disk.diagnostics.is_empty(), "{:?}", disk.diagnostics);
    let (sink, _) = mesh(&disk, 1e-5);
    let facts = check_scene(&sink).total;
    assert!(facts.is_well_formed() && (facts.area - 3.0 * PI).abs() <= 1e-3, "{facts}");
    // Around a cylinder between two rings, one of them oblique.
    let cylinder = Surface::Cylinder { frame: Frame3::WORLD, radius: 2.0 };
    let ring = |v: f64| TrimCurve::polyline(vec![DVec2::new(0.0, v), DVec2::new(TAU, v)]);
    let curves_around = vec![ring(0.0), ring(3.0).reversed()];
    let tube = prepared(cylinder, FreeTrims { rule: TrimRule::Handedness, curves: curves_around });
    assert!(tube.diagnostics.is_empty(), "{:?}", tube.diagnostics);
    let (sink, _) = mesh(&tube, 1e-4);
    let facts = check_scene(&sink).total;
    assert!(facts.is_well_formed() && (facts.area - 6.0 * TAU).abs() <= 1e-2, "{facts}");
    assert!((facts.unbalanced_length - 4.0 * TAU).abs() <= 1e-2, "{facts}");
    // A hole in a plane bounds nothing.
    let hole = prepared(plane(), FreeTrims { rule: TrimRule::Handedness, curves: vec![curves[1].clone()] });
    assert_eq!(hole.diagnostics[0].severity, Severity::Error, "{:?}", hole.diagnostics);
    let why = hole.diagnostics[0].kind.face_error();
    assert_eq!(why, Some(&FaceError::Unbounded { axis: 0 }));
}
