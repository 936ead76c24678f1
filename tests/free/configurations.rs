//! Random configurations of up to twelve curves: the exact area against polygons, point by point and in sum.

use crate::draw::{Draw, keeps, polygon, winding};
use glam::DVec2;
use trimtess::prepare::{FreeRegion, UvDomain};

/// Every region of random curves keeps the points that the rule keeps, asked of polygons.
#[test]
fn random_regions_keep_what_the_rule_says() {
    const POINTS: usize = 100;
    let domain = UvDomain::new(DVec2::ZERO, DVec2::ONE);
    for seed in 0..300 {
        let mut draw = Draw(seed);
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
