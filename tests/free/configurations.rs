//! Random configurations of up to twelve curves: exact area against closed forms and the independent arrangement, and
//! the kept points one by one.

use crate::common::winding;
use crate::draw::{each_configuration, keeps, polygon};
use crate::other;
use crate::random::SplitMix;
use glam::DVec2;
use trimtess::model::{FreeTrims, TrimCurve, TrimPiece};
use trimtess::prepare::{FreeRegion, UvDomain};

/// Centre, radius and direction of each curve, if all are circles.
fn circles(trims: &FreeTrims) -> Option<Vec<(DVec2, f64, bool)>> {
    let of_curve = |curve: &TrimCurve| match &curve.pieces[..] {
        [TrimPiece::Nurbs(c)] if c.weights.len() == 9 => {
            let [a, b, centre] = [c.points[0], c.points[2], c.points[0].midpoint(c.points[4])];
            let (r, s) = (a - centre, b - centre);
            let is_round = (r.length() - s.length()).abs() <= 1e-12 && r.dot(s).abs() <= 1e-12;
            is_round.then_some((centre, r.length(), r.perp_dot(s) > 0.0))
        }
        _ => None,
    };
    trims.curves.iter().map(of_curve).collect()
}

/// The area of each region equals that of the arrangement by implicitisation and eigenvalues, and for circles the
/// closed form.
#[test]
fn random_regions_have_the_area_of_closed_forms_and_of_the_independent_arrangement() {
    let domain = UvDomain::new(DVec2::ZERO, DVec2::ONE);
    each_configuration(|seed| {
        let trims = SplitMix(seed).configuration();
        let got = FreeRegion::new(&trims, &domain).unwrap_or_else(|e| panic!("seed {seed}: {e}")).area();
        let want = other::area(&trims);
        assert!((got - want).abs() <= 1e-9, "seed {seed}: area {got}, by eigenvalues {want}, {:e}", got - want);
        if let Some(circles) = circles(&trims) {
            let want = other::area_of_circles(trims.rule, &circles);
            assert!((got - want).abs() <= 1e-9, "seed {seed}: area {got}, in closed form {want}, {:e}", got - want);
        }
    });
}

/// Every region of random curves keeps the points that the rule keeps, as decided by polygons.
#[test]
fn random_regions_keep_what_the_rule_says() {
    const POINTS: usize = 100;
    let domain = UvDomain::new(DVec2::ZERO, DVec2::ONE);
    for seed in 0..300 {
        let mut draw = SplitMix(seed);
        let trims = draw.trims(12);
        let region = FreeRegion::new(&trims, &domain).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
        let loops = region.polygons(64);
        let curves: Vec<Vec<DVec2>> = trims.curves.iter().map(|c| polygon(c, 1024)).collect();
        let near = |q: DVec2| {
            let segment = |w: &[DVec2]| {
                let d = w[1] - w[0];
                let s = ((q - w[0]).dot(d) / d.length_squared()).clamp(0.0, 1.0);
                w[0].distance(q) < 2e-3 || (w[0] + d * s).distance(q) < 2e-3
            };
            curves.iter().any(|c| c.windows(2).any(segment))
        };
        for _ in 0..POINTS {
            let q = DVec2::new(draw.unit(), draw.unit());
            let got = loops.iter().map(|l| winding(l, q)).sum::<i32>();
            let want = i32::from(keeps(trims.rule, &curves, q));
            assert!(got == want || near(q), "seed {seed}: {q} winds {got}, wanted {want}, {:?}", trims.rule);
        }
        let polygons: f64 = loops.iter().map(|l| crate::draw::area(l)).sum();
        let exact = region.area();
        assert!((polygons - exact).abs() <= 2e-3, "seed {seed}: polygons {polygons}, exact {exact}");
    }
}
