//! Random trimming curves from a seed, and an independent decision of which points they keep.

use crate::common::winding;
use crate::random::SplitMix;
use glam::DVec2;
use std::f64::consts::TAU;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use trimtess::model::{FreeTrims, NurbsCurve2, TrimCurve, TrimPiece, TrimRule};

impl SplitMix {
    fn point(&mut self, a: f64, b: f64) -> DVec2 {
        DVec2::new(self.range(a, b), self.range(a, b))
    }

    /// A circle, an ellipse, a flower, a free closed cubic, or a polygon, in either direction.
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

    /// A closed cubic of two Bézier pieces through random points; it may cross itself.
    fn cubic(&mut self) -> TrimCurve {
        let p: Vec<DVec2> = (0..6).map(|_| self.point(0.05, 0.95)).collect();
        let bezier = |q: [DVec2; 4]| TrimPiece::bezier(q.to_vec(), Vec::new());
        TrimCurve { pieces: vec![bezier([p[0], p[1], p[2], p[3]]), bezier([p[3], p[4], p[5], p[0]])] }
    }

    /// An open cubic or polyline. Most of its ends are on the border of the unit square, some beyond it, some inside.
    pub(crate) fn open_curve(&mut self) -> TrimCurve {
        let mut points = vec![self.end()];
        match self.below(3) {
            0 => points.extend((0..=self.below(4)).map(|_| self.point(0.05, 0.95))),
            _ => points.extend([self.point(0.0, 1.0), self.point(0.0, 1.0)]),
        }
        points.push(self.end());
        if points.len() == 4 && self.below(2) == 0 {
            TrimCurve::bezier(points, Vec::new())
        } else {
            TrimCurve::polyline(points)
        }
    }

    fn end(&mut self) -> DVec2 {
        let kind = self.below(8);
        if kind == 0 {
            return self.point(0.05, 0.95);
        }
        let along = self.range(0.01, 0.99);
        let beyond = if kind == 1 { self.range(0.01, 0.3) } else { 0.0 };
        match self.below(4) {
            0 => DVec2::new(along, -beyond),
            1 => DVec2::new(1.0 + beyond, along),
            2 => DVec2::new(along, 1.0 + beyond),
            _ => DVec2::new(-beyond, along),
        }
    }

    fn rule(&mut self) -> TrimRule {
        [TrimRule::Handedness, TrimRule::NonZero, TrimRule::EvenOdd][self.below(3) as usize]
    }

    /// Up to `most` closed curves and a rule.
    pub(crate) fn trims(&mut self, most: u64) -> FreeTrims {
        let rule = self.rule();
        let n = 1 + self.below(most);
        FreeTrims { rule, curves: (0..n).map(|_| self.curve()).collect() }
    }

    /// Up to twelve circles, one time in eight; otherwise up to twelve curves of all kinds, closed and open.
    pub(crate) fn configuration(&mut self) -> FreeTrims {
        let rule = self.rule();
        let only_circles = self.below(8) == 0;
        let curve = |draw: &mut Self| {
            if only_circles {
                let circle = TrimCurve::circle(draw.point(0.0, 1.0), draw.range(0.05, 0.4));
                if draw.below(2) == 0 { circle.reversed() } else { circle }
            } else if draw.below(5) == 0 {
                draw.open_curve()
            } else {
                draw.curve()
            }
        };
        let n = 1 + self.below(12);
        FreeTrims { rule, curves: (0..n).map(|_| curve(self)).collect() }
    }
}

/// Calls `check` with the seed of each configuration, on all cores: 200 of them, or `TRIMTESS_CONFIGURATIONS`.
pub(crate) fn each_configuration(check: impl Fn(u64) + Sync) {
    let count = std::env::var("TRIMTESS_CONFIGURATIONS").map_or(200, |n| n.parse().unwrap());
    let next = AtomicU64::new(0);
    let failed = Mutex::new(Vec::new());
    let work = || {
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= count {
                break;
            }
            if catch_unwind(AssertUnwindSafe(|| check(seed))).is_err() {
                failed.lock().unwrap().push(seed);
            }
        }
    };
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| (0..workers).for_each(|_| drop(scope.spawn(work))));
    let failed = failed.into_inner().unwrap();
    assert!(failed.is_empty(), "seeds {failed:?} of {count}");
}

/// A closed quadratic B-spline with `petals` petals, counter-clockwise.
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

/// Signed area of a polygon.
pub(crate) fn area(p: &[DVec2]) -> f64 {
    0.5 * (0..p.len()).map(|k| p[k].perp_dot(p[(k + 1) % p.len()])).sum::<f64>()
}

/// Whether the rule keeps `q`, decided by polygons of the curves.
pub(crate) fn keeps(rule: TrimRule, polygons: &[Vec<DVec2>], q: DVec2) -> bool {
    let windings = || polygons.iter().map(|p| (winding(p, q), area(p)));
    match rule {
        TrimRule::Handedness => windings().all(|(w, area)| w >= i32::from(area > 0.0)),
        TrimRule::NonZero => windings().map(|(w, _)| w).sum::<i32>() != 0,
        TrimRule::EvenOdd => windings().map(|(w, _)| w).sum::<i32>() % 2 != 0,
    }
}
