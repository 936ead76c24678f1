//! Two patches with one border, stated in all the ways in which two curves can coincide.

use crate::common::elevated;
use crate::patches::{
    ends_where_it_is_open, left, mesh, open, part, patch, prepared, prepared_within, reversed_v, right, shared,
    transposed,
};
use glam::{DVec2, DVec3};
use trimtess::model::{BorderTrouble, DiagnosticKind, NurbsSurface};

/// Asserts that two patches have one common edge and three open edges each.
fn joins(surfaces: [NurbsSurface; 2]) {
    let prepared = prepared(part(surfaces));
    assert_eq!((shared(&prepared), open(&prepared).count), (1, 6), "{:?}", prepared.diagnostics);
    ends_where_it_is_open(&prepared);
}

#[test]
fn equal_borders_are_one_edge() {
    joins([left(), right()]);
}

#[test]
fn borders_of_other_directions_and_sides_are_one_edge() {
    joins([left(), reversed_v(&right())]);
    joins([left(), transposed(&right())]);
    joins([transposed(&left()), reversed_v(&right())]);
}

#[test]
fn borders_of_another_degree_are_one_edge() {
    let right = right();
    let rows: Vec<Vec<DVec3>> = right.points.chunks(4).map(|row| elevated(&elevated(row))).collect();
    joins([left(), patch(&rows)]);
}

#[test]
fn borders_with_other_knots_are_one_edge() {
    // Cut in two in the same patch: a knot of multiplicity 3 at 0.3, and the other patch with parameters twice as
    // large.
    let right = right();
    let cut = |row: &[DVec3]| {
        let (a, b) = (crate::patches::blossom(row, 0.0, 0.3), crate::patches::blossom(row, 0.3, 1.0));
        [a, b[1..].to_vec()].concat()
    };
    let points = right.points.chunks(4).flat_map(cut).collect();
    let knots_v = [vec![0.0; 4], vec![0.6; 3], vec![2.0; 4]].concat();
    joins([left(), NurbsSurface { points, knots_v, ..right }]);
}

/// The same surface with v reparametrised: v' = cv / (1 + (c - 1) v).
fn rational(s: &NurbsSurface, c: f64) -> NurbsSurface {
    let weights = s.points.chunks(4).flat_map(|row| (0..row.len()).map(|k| c.powi(k as i32))).collect();
    NurbsSurface { weights, ..s.clone() }
}

#[test]
fn borders_with_another_parameter_are_one_edge() {
    for c in [0.2, 1.7, 6.0] {
        joins([left(), rational(&right(), c)]);
        joins([rational(&left(), c), reversed_v(&rational(&right(), c))]);
    }
}

#[test]
fn a_parameter_with_zero_speed_at_an_end_is_handled() {
    // v = w²: of degree 6, with coincident control points.
    let square = |row: &[DVec3]| {
        let polynomial = |t: f64| {
            let s = t * t;
            let r = 1.0 - s;
            row[0] * (r * r * r) + row[1] * (3.0 * r * r * s) + row[2] * (3.0 * r * s * s) + row[3] * (s * s * s)
        };
        interpolated(polynomial, 6)
    };
    let right = right();
    let rows: Vec<Vec<DVec3>> = right.points.chunks(4).map(square).collect();
    joins([left(), patch(&rows)]);
    joins([patch(&left().points.chunks(4).map(square).collect::<Vec<_>>()), right]);
}

/// Bernstein coefficients of a polynomial of the given degree, by Gaussian elimination.
fn interpolated(polynomial: impl Fn(f64) -> DVec3, degree: usize) -> Vec<DVec3> {
    let n = degree + 1;
    let binomial = |k: usize| (1..=k).fold(1.0, |b, i| b * (degree + 1 - i) as f64 / i as f64);
    let mut rows: Vec<(Vec<f64>, DVec3)> = (0..n)
        .map(|i| {
            let t = i as f64 / degree as f64;
            let basis = |k: usize| binomial(k) * t.powi(k as i32) * (1.0 - t).powi((degree - k) as i32);
            ((0..n).map(basis).collect(), polynomial(t))
        })
        .collect();
    for k in 0..n {
        let pivot = (k..n).max_by(|&a, &b| rows[a].0[k].abs().total_cmp(&rows[b].0[k].abs())).unwrap();
        rows.swap(k, pivot);
        let (lead, right) = rows[k].clone();
        for (i, row) in rows.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let factor = row.0[k] / lead[k];
            assert!(i != k && factor.is_finite());
            row.0.iter_mut().zip(&lead).for_each(|(x, y)| *x -= factor * y);
            row.1 -= right * factor;
        }
    }
    rows.iter().enumerate().map(|(k, (row, right))| *right / row[k]).collect()
}

#[test]
fn gaps_up_to_the_tolerance_are_closed_and_reported_and_wider_ones_stay_open() {
    let moved = |by: f64| {
        let mut right = right();
        right.points.iter_mut().for_each(|p| p.z += by);
        part([left(), right])
    };
    // The part measures about 7; the default tolerance is a millionth of it.
    for (by, tolerance, joined) in [(3e-6, 1e-6, 1), (3e-5, 1e-6, 0), (3e-5, 1e-5, 1), (1e-2, 1e-2, 1), (1e-9, 0.0, 0)]
    {
        let prepared = prepared_within(moved(by), tolerance);
        assert_eq!(shared(&prepared), joined, "{by} of {tolerance}");
        assert_eq!(open(&prepared).count, 8 - 2 * joined);
        let told = prepared.diagnostics.iter().find(|d| d.face.is_none());
        assert_eq!(told.is_some(), joined > 0, "{by} of {tolerance}: {:?}", prepared.diagnostics);
        assert!(
            told.is_none_or(|d| matches!(d.kind, DiagnosticKind::Border(BorderTrouble::Joined { pairs: 1, .. }))),
            "{told:?}"
        );
        ends_where_it_is_open(&prepared);
    }
}

#[test]
fn borders_with_only_their_ends_in_common_are_two() {
    let mut right = right();
    right.points[1].z += 0.01;
    let prepared = prepared(part([left(), right]));
    assert_eq!((shared(&prepared), open(&prepared).count), (0, 8));
}

#[test]
fn three_patches_may_have_one_border() {
    let mut third = right();
    // Rotated upwards about the common border, whose points stay in place.
    third.points[4..].iter_mut().for_each(|p| *p = DVec3::new(3.0, p.y, p.z + p.x - 3.0));
    let prepared = prepared(part([left(), right(), third]));
    // Three uses: neither open nor an ordinary pair.
    assert_eq!((shared(&prepared), open(&prepared).count), (1, 10));
    ends_where_it_is_open(&prepared);
}

#[test]
fn a_patch_narrower_than_the_tolerance_keeps_its_sides() {
    let flat = |from: f64, to: f64| patch(&[from, to].map(|y| [0.0, 1.0].map(|x| DVec3::new(x, y, 0.0)).to_vec()));
    let mut part = part([flat(0.0, 5e-3), flat(5e-3, 1.0)]);
    part.tolerance = 1e-2;
    let prepared = prepared(part);
    assert_eq!((shared(&prepared), open(&prepared).count), (1, 6), "{:?}", prepared.diagnostics);
    let (_, facts) = mesh(&prepared, 1e-3);
    assert!(facts.is_well_formed() && (facts.area - 1.0).abs() < 1e-9, "{facts}");
}

#[test]
fn any_number_of_equal_borders_is_one() {
    // The same patch repeated, and patches with a small offset each.
    for (count, off) in [(600, 0.0), (90, 1e-9)] {
        let moved = |k: usize| {
            let mut s = left();
            s.points.iter_mut().for_each(|p| p.z += off * k as f64);
            s
        };
        let prepared = prepared(part((0..count).map(moved)));
        assert_eq!((shared(&prepared), open(&prepared).count), (4, 0), "{count}");
        let not_compared = |kind| matches!(kind, &DiagnosticKind::Border(BorderTrouble::NotCompared { .. }));
        let told = prepared.diagnostics.iter().any(|d| not_compared(&d.kind));
        assert_eq!(told, off > 0.0, "{:?}", prepared.diagnostics);
    }
}

#[test]
fn borders_of_many_straight_pieces_are_one_wherever_they_start() {
    // The second ring starts elsewhere; a foot point is found among all of its pieces.
    let count = 2000;
    let ring = |first: usize, inner: f64| {
        let at = |k: usize| DVec2::from_angle(std::f64::consts::TAU * ((first + k) % count) as f64 / count as f64);
        let row = |radius: f64| (0..=count).map(|k| (radius * at(k)).extend(0.0)).collect::<Vec<_>>();
        let knots = (0..=count).map(|k| k as f64);
        NurbsSurface {
            degree_v: 1,
            knots_v: [0.0].into_iter().chain(knots).chain([count as f64]).collect(),
            points: [row(inner), row(inner + 1.0)].concat(),
            ..patch(&[row(inner), row(inner + 1.0)])
        }
    };
    let prepared = prepared(part([ring(0, 1.0), ring(count / 3, 2.0)]));
    let open = open(&prepared);
    assert!(
        open.count == 2 && (open.length - std::f64::consts::TAU * 4.0).abs() < 1e-3,
        "{open:?}, {:?}",
        prepared.diagnostics
    );
}

#[test]
fn a_patch_may_be_sewn_to_itself() {
    // A tube of one patch. Its ends coincide but run at different speeds: not a period, but one edge.
    let ring: Vec<Vec<DVec3>> = [(2.0, 0.0), (2.0, 5.0), (-4.0, 5.0), (-4.0, -5.0), (2.0, -5.0), (2.0, 0.0)]
        .into_iter()
        .map(|(x, z)| [0.0, 1.0, 2.0, 3.0].map(|y| DVec3::new(x, y, z)).to_vec())
        .collect();
    let mut tube = patch(&ring);
    tube.weights = vec![1.0; 24];
    (0..4).for_each(|k| tube.weights[20 + k] = 2.0_f64.powi(k as i32));
    let prepared = prepared(part([tube]));
    assert_eq!(open(&prepared).count, 2, "{:?}", open(&prepared));
    ends_where_it_is_open(&prepared);
}
