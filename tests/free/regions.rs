//! Regions against closed forms, and the paper's own configurations.

use crate::common::winding;
use crate::draw::flower;
use glam::DVec2;
use std::f64::consts::{FRAC_PI_2, PI};
use trimtess::model::{FreeTrims, TrimCurve, TrimRule, TrimTrouble};
use trimtess::prepare::{FreeRegion, UvDomain};

const RULES: [TrimRule; 3] = [TrimRule::Handedness, TrimRule::NonZero, TrimRule::EvenOdd];

fn unit() -> UvDomain {
    UvDomain::new(DVec2::ZERO, DVec2::ONE)
}

fn region(rule: TrimRule, curves: &[TrimCurve]) -> FreeRegion {
    FreeRegion::new(&FreeTrims { rule, curves: curves.to_vec() }, &unit()).unwrap()
}

fn circle(x: f64, y: f64, r: f64) -> TrimCurve {
    TrimCurve::circle(DVec2::new(x, y), r)
}

#[track_caller]
fn assert_area(region: &FreeRegion, loops: usize, want: f64) {
    let got = region.area();
    assert!((got - want).abs() <= 1e-9, "area {got}, exact {want}, {} loops", region.polygons(4).len());
    assert_eq!(region.polygons(4).len(), loops);
}

/// Area of the intersection of two circles of radius `r` at distance `d`.
fn lens(r: f64, d: f64) -> f64 {
    2.0 * r * r * (d / (2.0 * r)).acos() - 0.5 * d * (4.0 * r * r - d * d).sqrt()
}

#[test]
fn a_loop_keeps_its_left() {
    let disk = PI * 0.09;
    for rule in RULES {
        assert_area(&region(rule, &[]), 1, 1.0);
        assert_area(&region(rule, &[circle(0.5, 0.5, 0.3)]), 1, disk);
    }
    let clockwise = [circle(0.5, 0.5, 0.3).reversed()];
    assert_area(&region(TrimRule::Handedness, &clockwise), 2, 1.0 - disk);
    assert_area(&region(TrimRule::NonZero, &clockwise), 1, disk);
    assert_area(&region(TrimRule::EvenOdd, &clockwise), 1, disk);
}

#[test]
fn rules_differ_on_nested_and_overlapping_circles() {
    let (big, small) = (circle(0.5, 0.5, 0.4), circle(0.55, 0.5, 0.2));
    let [a, b] = [0.16, 0.04].map(|r2| PI * r2);
    let nested = [big.clone(), small.clone()];
    assert_area(&region(TrimRule::Handedness, &nested), 1, b);
    assert_area(&region(TrimRule::NonZero, &nested), 1, a);
    assert_area(&region(TrimRule::EvenOdd, &nested), 2, a - b);
    let ring = [big, small.reversed()];
    for rule in RULES {
        assert_area(&region(rule, &ring), 2, a - b);
    }
    for d in [0.05, 0.2, 0.399] {
        let pair = [circle(0.3, 0.4, 0.2), circle(0.3 + d, 0.4, 0.2)];
        let (disk, lens) = (PI * 0.04, lens(0.2, d));
        assert_area(&region(TrimRule::Handedness, &pair), 1, lens);
        assert_area(&region(TrimRule::NonZero, &pair), 1, 2.0 * disk - lens);
        assert_area(&region(TrimRule::EvenOdd, &pair), 2, 2.0 * (disk - lens));
        let holes = pair.map(|c| c.reversed());
        assert_area(&region(TrimRule::Handedness, &holes), 2, 1.0 - 2.0 * disk + lens);
    }
}

/// Curve D of the paper's Figure 5: a loop inside another that already trims it, or tangent to it from inside.
#[test]
fn redundant_loops_inside_trimmed_ones_vanish_as_in_figure_5() {
    for inner in [circle(0.55, 0.45, 0.1), circle(0.7, 0.5, 0.1)] {
        let holes = [circle(0.5, 0.5, 0.3).reversed(), inner.reversed()];
        assert_area(&region(TrimRule::Handedness, &holes), 2, 1.0 - PI * 0.09);
    }
    // Also beyond an open curve's trim.
    let cut = TrimCurve::polyline(vec![DVec2::new(0.6, 0.0), DVec2::new(0.6, 1.0)]);
    assert_area(&region(TrimRule::Handedness, &[cut, circle(0.8, 0.5, 0.1).reversed()]), 1, 0.6);
}

#[test]
fn self_contained_loops_count_once_and_may_keep_nothing() {
    // A loop given twice.
    let twice = [circle(0.5, 0.5, 0.3), circle(0.5, 0.5, 0.3)];
    assert_area(&region(TrimRule::Handedness, &twice), 1, PI * 0.09);
    assert_area(&region(TrimRule::NonZero, &twice), 1, PI * 0.09);
    assert!(region(TrimRule::EvenOdd, &twice).is_empty());
    // An empty region.
    let apart = [circle(0.2, 0.5, 0.1), circle(0.8, 0.5, 0.1)];
    assert!(region(TrimRule::Handedness, &apart).is_empty());
    assert_area(&region(TrimRule::NonZero, &apart), 2, 2.0 * PI * 0.01);
}

/// Ends and corners on other curves, on the border, in its corners, and on each other.
#[test]
fn end_points_on_curves_are_crossings_like_others() {
    let p = |x: f64, y: f64| DVec2::new(x, y);
    let disk = PI * 0.04;
    let hole = circle(0.5, 0.5, 0.2).reversed();
    // A corner on a circle, from outside and from inside.
    let outside = TrimCurve::polygon(vec![p(0.7, 0.5), p(0.9, 0.6), p(0.9, 0.4)]);
    let area = region(TrimRule::Handedness, &[hole.clone(), outside]).area();
    assert!((area - (1.0 - disk - 0.02)).abs() <= 1e-9, "{area}");
    let within = TrimCurve::polygon(vec![p(0.7, 0.5), p(0.5, 0.4), p(0.5, 0.6)]);
    let area = region(TrimRule::EvenOdd, &[hole, within]).area();
    assert!((area - (disk - 0.02)).abs() <= 1e-9, "{area}");
    // From corner to corner.
    assert_area(&region(TrimRule::Handedness, &[TrimCurve::polyline(vec![p(0.0, 0.0), p(1.0, 1.0)])]), 1, 0.5);
    // Two curves that end at one point of the border.
    let line = |a: DVec2, b: DVec2| TrimCurve::polyline(vec![a, b]);
    let ends = [line(p(0.0, 0.5), p(0.5, 0.0)), line(p(0.5, 0.0), p(1.0, 0.5))];
    assert_area(&region(TrimRule::Handedness, &ends), 1, 1.0 - 0.25);
    // A curve that ends on another, on the border.
    let half = circle(0.5, 0.0, 0.25).reversed();
    let onto = line(p(0.0, 1.0), p(0.25, 0.0));
    assert_area(&region(TrimRule::Handedness, &[half, onto]), 1, 1.0 - 0.125 - PI * 0.03125);
}

#[test]
fn tangential_meetings_share_a_point_and_nothing_is_cut() {
    let pair = [circle(0.3, 0.5, 0.15).reversed(), circle(0.6, 0.5, 0.15).reversed()];
    assert_area(&region(TrimRule::Handedness, &pair), 3, 1.0 - 2.0 * PI * 0.0225);
    let inner = [circle(0.5, 0.5, 0.3), circle(0.65, 0.5, 0.15).reversed()];
    let got = region(TrimRule::Handedness, &inner).area();
    assert!((got - PI * (0.09 - 0.0225)).abs() <= 1e-9, "{got}");
}

#[test]
fn coincident_stretches_cancel_in_opposite_directions_and_count_once_in_the_same() {
    let rectangle = |x0: f64, x1: f64, y0: f64, y1: f64| {
        TrimCurve::polygon([(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| DVec2::new(x, y)).to_vec())
    };
    // Side by side: the common side is traversed in both directions.
    let pair = [rectangle(0.1, 0.4, 0.2, 0.6), rectangle(0.4, 0.8, 0.3, 0.9)];
    assert_area(&region(TrimRule::NonZero, &pair), 1, 0.12 + 0.24);
    assert_area(&region(TrimRule::EvenOdd, &pair), 1, 0.12 + 0.24);
    assert!(region(TrimRule::Handedness, &pair).is_empty());
    // One inside the other, with a common part of a side: traversed in one direction.
    let pair = [rectangle(0.1, 0.7, 0.1, 0.9), rectangle(0.1, 0.3, 0.4, 0.6)];
    assert_area(&region(TrimRule::Handedness, &pair), 1, 0.04);
    assert_area(&region(TrimRule::NonZero, &pair), 1, 0.48);
    assert_area(&region(TrimRule::EvenOdd, &pair), 1, 0.44);
    // A curve along the border of the domain.
    let half = [rectangle(0.0, 0.5, 0.0, 1.0)];
    for rule in RULES {
        assert_area(&region(rule, &half), 1, 0.5);
    }
    // Arcs of one circle with different ends.
    let arc = |a: f64, b: f64| circle_arc(DVec2::splat(0.5), 0.3, a, b);
    let chord = |a: f64, b: f64| {
        let p = |t: f64| DVec2::splat(0.5) + DVec2::from_angle(t) * 0.3;
        trimtess::model::TrimPiece::Polyline(vec![p(b), p(a)])
    };
    let segment = |a: f64, b: f64| TrimCurve { pieces: vec![arc(a, b), chord(a, b)] };
    let area = |sweep: f64| 0.045 * (sweep - sweep.sin());
    let pair = [segment(0.2, 1.4), segment(0.5, 1.7)];
    let got = region(TrimRule::NonZero, &pair);
    let both = region(TrimRule::Handedness, &pair);
    assert!((got.area() + both.area() - 2.0 * area(1.2)).abs() <= 1e-9, "{} {}", got.area(), both.area());
}

fn circle_arc(centre: DVec2, r: f64, a: f64, b: f64) -> trimtess::model::TrimPiece {
    let half = 0.5 * (b - a);
    let at = |t: f64, r: f64| centre + DVec2::from_angle(t) * r;
    let points = vec![at(a, r), at(a + half, r / half.cos()), at(b, r)];
    trimtess::model::TrimPiece::bezier(points, vec![1.0, half.cos(), 1.0])
}

#[test]
fn open_curves_are_closed_along_the_border() {
    let line = |a: (f64, f64), b: (f64, f64)| TrimCurve::polyline(vec![a.into(), b.into()]);
    for rule in RULES {
        // Upwards: its left is the part with smaller u.
        assert_area(&region(rule, &[line((0.3, 0.0), (0.3, 1.0))]), 1, 0.3);
        assert_area(&region(rule, &[line((0.3, 1.0), (0.3, 0.0))]), 1, 0.7);
        assert_area(&region(rule, &[line((0.0, 0.25), (1.0, 0.25))]), 1, 0.75);
        // From a side to itself.
        let cap = TrimCurve {
            pieces: vec![
                circle_arc(DVec2::new(0.5, 0.0), 0.2, 0.0, FRAC_PI_2),
                circle_arc(DVec2::new(0.5, 0.0), 0.2, FRAC_PI_2, PI),
            ],
        };
        assert_area(&region(rule, std::slice::from_ref(&cap)), 1, 0.02 * PI);
        assert_area(&region(rule, &[cap.reversed()]), 1, 1.0 - 0.02 * PI);
        // Beyond the border on both sides: clipped and reported.
        let clipped = region(rule, &[line((0.3, -0.5), (0.3, 1.5))]);
        assert_area(&clipped, 1, 0.3);
        assert!(clipped.notes.iter().any(|n| n.what == TrimTrouble::Clipped { curve: 0 }), "{:?}", clipped.notes);
        // Ends inside: extended and reported.
        let short = region(rule, &[line((0.3, 0.1), (0.3, 0.95))]);
        assert_area(&short, 1, 0.3);
        assert!(
            short.notes.iter().any(|n| matches!(n.what, TrimTrouble::Extended { curve: 0, .. })),
            "{:?}",
            short.notes
        );
    }
    // Two that cross: the paper keeps the intersection of their left sides.
    let cross = [line((0.0, 0.4), (1.0, 0.4)), line((0.3, 0.0), (0.3, 1.0))];
    assert_area(&region(TrimRule::Handedness, &cross), 1, 0.18);
    assert_area(&region(TrimRule::NonZero, &cross), 1, 1.0 - 0.7 * 0.4);
}

#[test]
fn loops_that_leave_the_domain_are_clipped() {
    let half = region(TrimRule::Handedness, &[circle(0.0, 0.5, 0.2)]);
    assert_area(&half, 1, 0.02 * PI);
    let hole = region(TrimRule::Handedness, &[circle(1.0, 1.0, 0.2).reversed()]);
    assert_area(&hole, 1, 1.0 - 0.01 * PI);
    let around = region(TrimRule::Handedness, &[circle(0.5, 0.5, 3.0)]);
    assert_area(&around, 1, 1.0);
    assert!(region(TrimRule::Handedness, &[circle(0.5, 3.0, 1.0)]).is_empty());
}

/// Figure 6 of the paper: two loops that meet in two points; whatever either trims is trimmed.
#[test]
fn intersecting_loops_merge_as_in_figure_6() {
    let c1 = circle(0.4, 0.5, 0.2).reversed();
    let c2 = TrimCurve::ellipse(DVec2::new(0.6, 0.5), DVec2::X * 0.25, DVec2::Y * 0.1).reversed();
    let merged = region(TrimRule::Handedness, &[c1, c2]);
    let loops = merged.polygons(64);
    assert_eq!(loops.len(), 2);
    for (q, kept) in
        [((0.4, 0.5), false), ((0.8, 0.5), false), ((0.5, 0.5), false), ((0.65, 0.65), true), ((0.05, 0.05), true)]
    {
        let q = DVec2::from(q);
        assert_eq!(loops.iter().map(|l| winding(l, q)).sum::<i32>(), i32::from(kept), "{q}");
    }
}

#[test]
fn a_self_intersecting_curve_is_reported_and_resolved_by_winding() {
    // A figure of eight: one lobe in each direction.
    let p = |x: f64, y: f64| DVec2::new(x, y);
    let eight = TrimCurve::polygon(vec![p(0.2, 0.3), p(0.8, 0.7), p(0.8, 0.3), p(0.2, 0.7)]);
    let both = region(TrimRule::NonZero, std::slice::from_ref(&eight));
    assert_area(&both, 2, 0.12);
    assert!(both.notes.iter().any(|n| matches!(n.what, TrimTrouble::CrossesItself { .. })), "{:?}", both.notes);
    assert_area(&region(TrimRule::EvenOdd, &[eight]), 2, 0.12);
}

#[test]
fn flowers_keep_their_area_under_scaled_domains() {
    let curve = flower(DVec2::new(0.5, 0.5), 0.3, 5, 0.5);
    let unit = region(TrimRule::Handedness, std::slice::from_ref(&curve)).area();
    let scale = |p: DVec2| DVec2::new(-3.0 + 7.0 * p.x, 100.0 + 0.01 * p.y);
    let trimtess::model::TrimPiece::Nurbs(mut nurbs) = curve.pieces[0].clone() else { panic!("a flower is NURBS") };
    nurbs.points.iter_mut().for_each(|p| *p = scale(*p));
    let domain = UvDomain::new(scale(DVec2::ZERO), scale(DVec2::ONE));
    let trims = FreeTrims { rule: TrimRule::Handedness, curves: vec![TrimCurve::nurbs(nurbs)] };
    let scaled = FreeRegion::new(&trims, &domain).unwrap().area();
    assert!((scaled / 0.07 - unit).abs() <= 1e-9, "{scaled} {unit}");
}
