//! Neighbours with trims across their common border: the border pieces that both keep are shared.

use crate::patches::{bicubic, ends_where_it_is_open, left, open, prepared, reversed_v, right, shared, trimmed};
use glam::DVec2;
use trimtess::model::{FreeTrims, TrimCurve, TrimRule};

/// A hole around a point of the domain.
fn hole(x: f64, y: f64, radius: f64) -> TrimCurve {
    TrimCurve::circle(DVec2::new(x, y), radius).reversed()
}

fn trims(curves: Vec<TrimCurve>) -> FreeTrims {
    FreeTrims { rule: TrimRule::Handedness, curves }
}

#[test]
fn a_loop_over_the_border_from_both_sides() {
    // The same circle in both domains; the patches continue each other in parameters too.
    let (a, b) = (trims(vec![hole(1.0, 0.5, 0.2)]), trims(vec![hole(0.0, 0.5, 0.2)]));
    let prepared = prepared(trimmed([(left(), a), (right(), b)]));
    assert_eq!(shared(&prepared), 2);
    // Three sides of each patch, and the loop's halves, one of which contains the circle's start.
    assert_eq!(open(&prepared).count, 6 + 1 + 2);
    ends_where_it_is_open(&prepared);
}

#[test]
fn loops_that_keep_different_pieces() {
    for (y, radius, pieces, alone) in [
        // Overlapping, one within the other, apart, side by side, on one side only.
        (0.6, 0.2, 2, 2),
        (0.5, 0.1, 2, 2),
        (0.85, 0.1, 3, 2),
        (0.8, 0.1, 2, 2),
        (0.5, 0.0, 2, 1),
    ] {
        let a = trims(vec![hole(1.0, 0.5, 0.2)]);
        let b = if radius > 0.0 { trims(vec![hole(0.0, y, radius)]) } else { trims(Vec::new()) };
        let half = if radius > 0.0 { 2 } else { 0 };
        let prepared = prepared(trimmed([(left(), a.clone()), (right(), b.clone())]));
        assert_eq!(shared(&prepared), pieces, "{y}, {radius}");
        assert_eq!(open(&prepared).count, 6 + 1 + half + alone, "{y}, {radius}");
        ends_where_it_is_open(&prepared);
    }
}

#[test]
fn a_loop_over_a_border_that_runs_in_the_other_direction() {
    let (a, b) = (trims(vec![hole(1.0, 0.3, 0.2)]), trims(vec![hole(0.0, 0.7, 0.2)]));
    let prepared = prepared(trimmed([(left(), a), (reversed_v(&right()), b)]));
    assert_eq!((shared(&prepared), open(&prepared).count), (2, 9));
    ends_where_it_is_open(&prepared);
}

#[test]
fn polylines_and_flowers_over_the_corner_of_four() {
    let at = |i: f64, j: f64| bicubic(DVec2::new(i, j) * 3.0, DVec2::new(i + 1.0, j + 1.0) * 3.0);
    let petal = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / 40.0;
        DVec2::from_angle(angle) * (0.3 + 0.1 * (5.0 * angle).cos())
    };
    let faces = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(i, j)| {
        let centre = DVec2::new(1.0 - i, 1.0 - j);
        let flower = TrimCurve::polygon((0..40).rev().map(|k| centre + petal(k)).collect());
        (at(i, j), trims(vec![flower]))
    });
    let prepared = prepared(trimmed(faces));
    // The remaining pieces of the four common borders.
    assert_eq!(shared(&prepared), 4);
    ends_where_it_is_open(&prepared);
    let open = open(&prepared);
    assert!(open.count > 8 + 36, "{open:?}");
}

#[test]
fn trimming_curves_that_are_one_curve_in_space_are_one_edge() {
    // Two planes intersect. On each, the line of intersection is stated with its own parameters, and one half is kept.
    let sheet = |normal: bool| {
        let at = |s: f64, t: f64| {
            let (x, y, z) = if normal { (s * 3.0, t * 5.0 - 1.0, 0.0) } else { (t * 4.0, 1.0, s * 2.0 - 1.0) };
            glam::DVec3::new(x, y, z)
        };
        crate::patches::patch(&[vec![at(0.0, 0.0), at(0.0, 1.0)], vec![at(1.0, 0.0), at(1.0, 1.0)]])
    };
    // On the first along t = 0.4, from x = 0 to 3; on the second along s = 0.5, from x = 4 to 0.
    let a = trims(vec![TrimCurve::polyline(vec![DVec2::new(0.0, 0.4), DVec2::new(1.0, 0.4)])]);
    let b =
        trims(vec![TrimCurve::bezier(vec![DVec2::new(0.5, 1.0), DVec2::new(0.5, 0.2), DVec2::new(0.5, 0.0)], vec![])]);
    let prepared = prepared(trimmed([(sheet(true), a), (sheet(false), b)]));
    assert_eq!(shared(&prepared), 1);
    // The second continues from x = 3 to 4.
    assert_eq!(open(&prepared).count, 3 + 3 + 1);
    ends_where_it_is_open(&prepared);
}
