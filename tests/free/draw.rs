//! Random trimming curves from a seed, and an independent answer to what they keep.

use glam::DVec2;
use std::f64::consts::TAU;
use trimtess::model::{FreeTrims, NurbsCurve2, TrimCurve, TrimPiece, TrimRule};

/// A generator of numbers (SplitMix64).
pub(crate) struct Draw(pub(crate) u64);

impl Draw {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn range(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }

    pub(crate) fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    fn point(&mut self, a: f64, b: f64) -> DVec2 {
        DVec2::new(self.range(a, b), self.range(a, b))
    }

    /// A circle, an ellipse, a flower, a free closed cubic, or a polygon; either way round.
    pub(crate) fn curve(&mut self) -> TrimCurve {
        let centre = self.point(0.15, 0.85);
        let curve = match self.below(5) {
            0 => TrimCurve::circle(centre, self.range(0.05, 0.4)),
            1 => {
                let a = DVec2::from_angle(self.range(0.0, TAU));
                TrimCurve::ellipse(centre, a * self.range(0.1, 0.4), a.perp() * self.range(0.03, 0.3))
            }
            2 => flower(centre, self.range(0.1, 0.3), 3 + self.below(4) as usize, self.range(0.1, 0.6)),
            3 => self.cubic(),
            _ => {
                let n = 3 + self.below(6);
                let r = self.range(0.1, 0.4);
                let corner = |k: u64, draw: &mut Self| {
                    centre + DVec2::from_angle(TAU * k as f64 / n as f64) * r * draw.range(0.5, 1.0)
                };
                TrimCurve::polygon((0..n).map(|k| corner(k, self)).collect())
            }
        };
        if self.below(2) == 0 { curve.reversed() } else { curve }
    }

    /// A closed cubic of two Bézier pieces through random points: it may cross itself.
    fn cubic(&mut self) -> TrimCurve {
        let p: Vec<DVec2> = (0..6).map(|_| self.point(0.05, 0.95)).collect();
        let bezier = |q: [DVec2; 4]| TrimPiece::bezier(q.to_vec(), Vec::new());
        TrimCurve { pieces: vec![bezier([p[0], p[1], p[2], p[3]]), bezier([p[3], p[4], p[5], p[0]])] }
    }

    /// Up to `most` curves and a rule.
    pub(crate) fn trims(&mut self, most: u64) -> FreeTrims {
        let rule = [TrimRule::Handedness, TrimRule::NonZero, TrimRule::EvenOdd][self.below(3) as usize];
        let n = 1 + self.below(most);
        FreeTrims { rule, curves: (0..n).map(|_| self.curve()).collect() }
    }
}

/// A closed quadratic B-spline of `petals` petals, counter-clockwise.
pub(crate) fn flower(centre: DVec2, radius: f64, petals: usize, depth: f64) -> TrimCurve {
    let n = 4 * petals;
    let control = |k: usize| {
        let r = if k % 4 < 2 { radius } else { radius * (1.0 - depth) };
        centre + DVec2::from_angle(TAU * (k % n) as f64 / n as f64) * r
    };
    TrimCurve::nurbs(NurbsCurve2 {
        degree: 2,
        knots: (0..n + 5).map(|k| k as f64).collect(),
        points: (0..n + 2).map(control).collect(),
        weights: Vec::new(),
    })
}

/// A curve as a polygon with `n` points for each Bézier piece.
pub(crate) fn polygon(curve: &TrimCurve, n: usize) -> Vec<DVec2> {
    let of_piece = |piece: &TrimPiece| match piece {
        TrimPiece::Polyline(points) => points.clone(),
        TrimPiece::Nurbs(nurbs) => {
            let (a, b) = nurbs.domain();
            (0..=n).map(|k| nurbs.point(a + (b - a) * k as f64 / n as f64)).collect()
        }
    };
    curve.pieces.iter().flat_map(of_piece).collect()
}

/// Winding number of a closed polygon about `q`.
pub(crate) fn winding(p: &[DVec2], q: DVec2) -> i32 {
    let turn = |k: usize| {
        let (a, b) = (p[k] - q, p[(k + 1) % p.len()] - q);
        // Only what changes sides of the line to the left of `q` counts: there angles jump.
        let crosses = (a.y < 0.0) != (b.y < 0.0) && a.perp_dot(b) * (b.y - a.y) < 0.0;
        if !crosses {
            0
        } else if a.y < 0.0 {
            -1
        } else {
            1
        }
    };
    (0..p.len()).map(turn).sum()
}

/// Twice the signed area of a polygon, halved.
pub(crate) fn area(p: &[DVec2]) -> f64 {
    0.5 * (0..p.len()).map(|k| p[k].perp_dot(p[(k + 1) % p.len()])).sum::<f64>()
}

/// Whether the rule keeps `q`, by polygons of the curves.
pub(crate) fn keeps(rule: TrimRule, polygons: &[Vec<DVec2>], q: DVec2) -> bool {
    let windings = || polygons.iter().map(|p| (winding(p, q), area(p)));
    match rule {
        TrimRule::Handedness => windings().all(|(w, area)| w >= i32::from(area > 0.0)),
        TrimRule::NonZero => windings().map(|(w, _)| w).sum::<i32>() != 0,
        TrimRule::EvenOdd => windings().map(|(w, _)| w).sum::<i32>() % 2 != 0,
    }
}
