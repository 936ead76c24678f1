//! The area that free trims keep, computed independently of the crate: closed forms for circles, and for all curves an
//! arrangement of Bézier pieces, cut at the intersections found by implicitisation and eigenvalues.

use crate::implicit::{by_eigenvalues, point};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;
use trimtess::model::{FreeTrims, NurbsCurve2, TrimCurve, TrimPiece, TrimRule};

const CORNERS: [DVec2; 4] = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];

/// A Bézier curve.
struct Piece {
    /// `(w x, w y, w)`.
    control: Vec<DVec3>,
    /// For each coordinate, the parameters between which it is monotone.
    turns: [Vec<f64>; 2],
    /// Parameters where other pieces meet it.
    cuts: Vec<f64>,
}

/// A closed curve.
struct Wire {
    pieces: Vec<Piece>,
    /// Pieces that close it along the border or beyond: they count for winding but bound nothing.
    closure: Vec<Piece>,
    /// Minimum winding number of points inside.
    least: i32,
}

impl Piece {
    fn new(control: Vec<DVec3>) -> Self {
        let turns = [0, 1].map(|axis| turns(&control, axis));
        Self { control, turns, cuts: vec![0.0, 1.0] }
    }

    fn line(a: DVec2, b: DVec2) -> Self {
        Self::new(vec![a.extend(1.0), b.extend(1.0)])
    }

    fn point(&self, t: f64) -> DVec2 {
        let n = self.control.len() - 1;
        match t {
            0.0 => self.control[0].truncate() / self.control[0].z,
            1.0 => self.control[n].truncate() / self.control[n].z,
            _ => point(&self.control, t),
        }
    }

    fn hull(&self) -> [DVec2; 2] {
        let points = || self.control.iter().map(|c| c.truncate() / c.z);
        [points().fold(DVec2::INFINITY, DVec2::min), points().fold(DVec2::NEG_INFINITY, DVec2::max)]
    }

    /// The integral of x dy, by four-point Gauss-Legendre quadrature on each of 64 stretches.
    fn green(&self, from: f64, to: f64) -> f64 {
        const N: usize = 64;
        let ends = |k: usize| from + (to - from) * k as f64 / N as f64;
        const NODES: [(f64, f64); 4] = [
            (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
            (-0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
            (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
            (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        ];
        if self.control.len() == 2 {
            let (a, b) = (self.point(from), self.point(to));
            return 0.5 * (a.x + b.x) * (b.y - a.y);
        }
        let stretch = |k: usize| -> f64 {
            let (a, b) = (ends(k), ends(k + 1));
            let node = |&(x, w): &(f64, f64)| {
                let t = 0.5 * (a + b) + 0.5 * (b - a) * x;
                0.5 * (b - a) * w * self.point(t).x * self.tangent(t).y
            };
            NODES.iter().map(node).sum()
        };
        (0..N).map(stretch).sum()
    }

    fn tangent(&self, t: f64) -> DVec2 {
        let n = self.control.len() - 1;
        let rises: Vec<DVec3> = self.control.windows(2).map(|w| (w[1] - w[0]) * n as f64).collect();
        let value = |mut rest: Vec<DVec3>| {
            while rest.len() > 1 {
                rest = rest.windows(2).map(|w| w[0].lerp(w[1], t)).collect();
            }
            rest[0]
        };
        let (c, d) = (value(self.control.clone()), value(rises));
        (d.truncate() - c.truncate() * (d.z / c.z)) / c.z
    }

    /// Its crossings with the line through `q` parallel to `axis`: the stretch, the coordinate `axis`, and the sign: 1
    /// if it winds counter-clockwise about the points before that place on the line, else -1.
    fn crossings(&self, q: DVec2, axis: usize) -> Vec<(usize, f64, i32)> {
        let across = 1 - axis;
        let turns = &self.turns[across];
        let mut out = Vec::new();
        for k in 0..turns.len() - 1 {
            let (mut low, mut high) = (turns[k], turns[k + 1]);
            let above = [low, high].map(|t| self.point(t)[across] > q[across]);
            if above[0] == above[1] {
                continue;
            }
            for _ in 0..80 {
                let middle = 0.5 * (low + high);
                if (self.point(middle)[across] > q[across]) == above[0] {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            out.push((k, self.point(low)[axis], if above[1] == (axis == 0) { 1 } else { -1 }));
        }
        out
    }
}

/// 0, 1, and the parameters between them at which a coordinate of a curve has an extremum.
fn turns(control: &[DVec3], axis: usize) -> Vec<f64> {
    let c: Vec<[f64; 2]> = control.iter().map(|c| [c[axis], c.z]).collect();
    let minor = |i: usize, j: usize| c[j][0] * c[i][1] - c[j][1] * c[i][0];
    // Bernstein coefficients of the derivative's numerator.
    let b = match c.len() {
        3 => [2.0 * minor(0, 1), minor(0, 2), 2.0 * minor(1, 2)],
        4 => [minor(0, 1), minor(1, 2), minor(2, 3)],
        _ => return vec![0.0, 1.0],
    };
    let (p, q, r) = (b[0] - 2.0 * b[1] + b[2], 2.0 * (b[1] - b[0]), b[0]);
    let far = -0.5 * (q + (q * q - 4.0 * p * r).sqrt().copysign(q));
    let mut out = vec![0.0, 1.0];
    out.extend([far / p, r / far].into_iter().filter(|t| *t > 0.0 && *t < 1.0));
    out.sort_by(f64::total_cmp);
    out
}

/// Bézier pieces of a NURBS curve; control points are blossom values.
fn beziers(curve: &NurbsCurve2) -> Vec<Vec<DVec3>> {
    let (p, knots) = (curve.degree, &curve.knots);
    let blossom = |span: usize, at: &[f64]| {
        let weight = |j: usize| curve.weights.get(j).copied().unwrap_or(1.0);
        let mut d: Vec<DVec3> = (span - p..=span).map(|j| (curve.points[j] * weight(j)).extend(weight(j))).collect();
        for (r, &u) in at.iter().enumerate() {
            for j in (r + 1..=p).rev() {
                let k = span - p + j;
                let share = (u - knots[k]) / (knots[k + p - r] - knots[k]);
                d[j] = d[j - 1].lerp(d[j], share);
            }
        }
        d[p]
    };
    let spans = (p..curve.points.len()).filter(|&k| knots[k] < knots[k + 1]);
    let control = |k: usize, i: usize| {
        let at: Vec<f64> = (0..p).map(|j| knots[k + usize::from(j < i)]).collect();
        blossom(k, &at)
    };
    spans.map(|k| (0..=p).map(|i| control(k, i)).collect()).collect()
}

/// The point of the unit square's border at a distance along it from the origin. [`border_distance`] is the inverse.
fn along_border(at: f64) -> DVec2 {
    let side = at.floor() as usize % 4;
    CORNERS[side].lerp(CORNERS[(side + 1) % 4], at.fract())
}

fn border_distance(p: DVec2) -> f64 {
    let to_side = |k: usize| {
        let (a, b) = (CORNERS[k], CORNERS[(k + 1) % 4]);
        let s = (p - a).dot(b - a).clamp(0.0, 1.0);
        (k as f64 + s, p.distance(a.lerp(b, s)))
    };
    (0..4).map(to_side).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap().0
}

fn wire(curve: &TrimCurve) -> Wire {
    let of_piece = |piece: &TrimPiece| match piece {
        TrimPiece::Polyline(points) => points.windows(2).map(|w| vec![w[0].extend(1.0), w[1].extend(1.0)]).collect(),
        TrimPiece::Nurbs(nurbs) => beziers(nurbs),
    };
    let mut controls: Vec<Vec<DVec3>> = curve.pieces.iter().flat_map(of_piece).collect();
    let count = controls.len();
    let is_closed = curve.is_closed();
    // Adjacent pieces have bit-identical ends.
    for k in (0..count).filter(|&k| is_closed || k > 0) {
        let before = &controls[(k + count - 1) % count];
        controls[k][0] = before[before.len() - 1];
    }
    let mut pieces: Vec<Piece> = controls.into_iter().map(Piece::new).collect();
    let mut closure = Vec::new();
    let mut least = i32::from(pieces.iter().map(|p| p.green(0.0, 1.0)).sum::<f64>() > 0.0);
    if !is_closed {
        least = 1;
        let (start, end) = (pieces[0].point(0.0), pieces[count - 1].point(1.0));
        let [mut to, from] = [start, end].map(border_distance);
        for (p, at) in [(start, to), (end, from)] {
            let line = if p == start { Piece::line(along_border(at), p) } else { Piece::line(p, along_border(at)) };
            let is_inside = p.min_element() > 0.0 && p.max_element() < 1.0;
            if is_inside { pieces.push(line) } else { closure.push(line) }
        }
        if to < from {
            to += 4.0;
        }
        let mut stops = vec![from];
        stops.extend((0..8).map(f64::from).filter(|&k| k > from && k < to));
        stops.push(to);
        closure.extend(stops.windows(2).map(|w| Piece::line(along_border(w[0]), along_border(w[1]))));
    }
    Wire { pieces, closure, least }
}

/// The two parameters at which a polynomial cubic passes through one point.
fn double_point(c: &[DVec3]) -> Option<[f64; 2]> {
    let [p0, p1, p2, p3] = <[DVec3; 4]>::try_from(c).ok()?.map(DVec3::truncate);
    let (a3, a2, a1) = (p3 - p2 * 3.0 + p1 * 3.0 - p0, (p2 - p1 * 2.0 + p0) * 3.0, (p1 - p0) * 3.0);
    // With the sum p and the product q of both: a3 (p² - q) + a2 p + a1 = 0.
    let p = a3.perp_dot(a1) / -a3.perp_dot(a2);
    let q = p * p - a2.perp_dot(a1) / -a2.perp_dot(a3);
    let root = (0.25 * p * p - q).sqrt();
    let both = [0.5 * p - root, 0.5 * p + root];
    both.iter().all(|t| (0.0..=1.0).contains(t)).then_some(both)
}

/// Cuts all pieces where they meet others.
fn cut(wires: &mut [Wire]) {
    let names: Vec<(usize, usize)> =
        wires.iter().enumerate().flat_map(|(w, wire)| (0..wire.pieces.len()).map(move |k| (w, k))).collect();
    let hulls: Vec<[DVec2; 2]> = names.iter().map(|&(w, k)| wires[w].pieces[k].hull()).collect();
    for (i, &a) in names.iter().enumerate() {
        if let Some(both) = double_point(&wires[a.0].pieces[a.1].control) {
            wires[a.0].pieces[a.1].cuts.extend(both);
        }
        for (j, &b) in names.iter().enumerate().skip(i + 1) {
            let apart = hulls[i][0].cmpgt(hulls[j][1]).any() || hulls[j][0].cmpgt(hulls[i][1]).any();
            let [x, y] = [a, b].map(|(w, k)| &wires[w].pieces[k].control);
            // Quarters of one ellipse are one conic.
            let is_conic = |c: &[DVec3]| c.iter().any(|c| c.z != 1.0);
            if apart || (a.0 == b.0 && is_conic(x) && is_conic(y)) {
                continue;
            }
            let turned = x.len() > y.len();
            let met = if turned { by_eigenvalues(y, x) } else { by_eigenvalues(x, y) };
            for [s, t] in met {
                let (s, t) = if turned { (t, s) } else { (s, t) };
                wires[a.0].pieces[a.1].cuts.push(s);
                wires[b.0].pieces[b.1].cuts.push(t);
            }
        }
    }
}

/// The area of the unit square that free trims keep.
pub(crate) fn area(trims: &FreeTrims) -> f64 {
    let side = |k: usize| Piece::line(CORNERS[k], CORNERS[(k + 1) % 4]);
    let mut wires = vec![Wire { pieces: (0..4).map(side).collect(), closure: Vec::new(), least: 1 }];
    wires.extend(trims.curves.iter().map(wire));
    cut(&mut wires);
    let ends: Vec<DVec2> =
        wires[1..].iter().flat_map(|w| &w.closure).flat_map(|p| [p.point(0.0), p.point(1.0)]).collect();
    for side in &mut wires[0].pieces {
        let (a, b) = (side.point(0.0), side.point(1.0));
        side.cuts.extend(ends.iter().map(|&p| (p - a).dot(b - a)).filter(|t| (0.0..=1.0).contains(t)));
    }
    let keeps = |windings: &[i32]| {
        let curves = || windings.iter().zip(&wires).skip(1);
        windings[0] > 0
            && match trims.rule {
                TrimRule::Handedness => curves().all(|(&w, wire)| w >= wire.least),
                TrimRule::NonZero => curves().map(|(w, _)| w).sum::<i32>() != 0,
                TrimRule::EvenOdd => curves().map(|(w, _)| w).sum::<i32>() % 2 != 0,
            }
    };
    let mut sum = 0.0;
    for (number, wire) in wires.iter().enumerate() {
        for (k, piece) in wire.pieces.iter().enumerate() {
            let mut cuts = piece.cuts.clone();
            cuts.sort_by(f64::total_cmp);
            for w in cuts.windows(2).filter(|w| w[1] - w[0] > 1e-12) {
                let t = 0.5 * (w[0] + w[1]);
                let (q, d) = (piece.point(t), piece.tangent(t));
                let axis = usize::from(d.x.abs() > d.y.abs());
                let own = piece.turns[1 - axis].windows(2).position(|w| w[0] <= t && t <= w[1]).unwrap();
                let mut sides = [vec![0; wires.len()], vec![0; wires.len()]];
                let mut turned = 0;
                for (n, other) in wires.iter().enumerate() {
                    for (j, p) in other.pieces.iter().chain(&other.closure).enumerate() {
                        for (stretch, at, sign) in p.crossings(q, axis) {
                            if (n, j, stretch) == (number, k, own) {
                                sides[1][n] += sign;
                                turned = sign;
                            } else if number == 0 && (at - q[axis]).abs() <= 1e-12 {
                                // The closing piece along the border.
                                sides[1][n] += sign;
                            } else if at > q[axis] {
                                sides[0][n] += sign;
                                sides[1][n] += sign;
                            }
                        }
                    }
                }
                let [ahead, behind] = sides.map(|s| i32::from(keeps(&s)));
                // The area lies on the left of pieces that go around it counter-clockwise.
                sum += f64::from(turned * (behind - ahead)) * piece.green(w[0], w[1]);
            }
        }
    }
    sum
}

/// The area kept by circles, in closed form, from centres, radii, and whether they run counter-clockwise.
pub(crate) fn area_of_circles(rule: TrimRule, circles: &[(DVec2, f64, bool)]) -> f64 {
    let keeps = |q: DVec2, own: Option<(usize, bool)>| {
        let is_in = |k: usize| match own {
            Some((own, inside)) if own == k => inside,
            _ => q.distance(circles[k].0) < circles[k].1,
        };
        let winding = |k: usize| i32::from(is_in(k)) * if circles[k].2 { 1 } else { -1 };
        let windings = || (0..circles.len()).map(winding);
        match rule {
            TrimRule::Handedness => windings().zip(circles).all(|(w, c)| w >= i32::from(c.2)),
            TrimRule::NonZero => windings().sum::<i32>() != 0,
            TrimRule::EvenOdd => windings().sum::<i32>() % 2 != 0,
        }
    };
    let mut sum = 0.0;
    for (k, &(c, r, _)) in circles.iter().enumerate() {
        let mut cuts = vec![0.0, TAU];
        let mut cut = |middle: f64, half: f64| {
            cuts.extend(
                [middle - half, middle + half].into_iter().filter(|a| a.is_finite()).map(|a| a.rem_euclid(TAU)),
            );
        };
        for &(other, s, _) in circles.iter().filter(|o| o.0 != c) {
            let d = other - c;
            let cosine = (d.length_squared() + r * r - s * s) / (2.0 * r * d.length());
            cut(d.to_angle(), cosine.acos());
        }
        for (across, at) in [(DVec2::X, 0.0), (DVec2::X, 1.0), (DVec2::Y, 0.0), (DVec2::Y, 1.0)] {
            cut(across.to_angle(), ((at - c.dot(across)) / r).acos());
        }
        cuts.sort_by(f64::total_cmp);
        for w in cuts.windows(2) {
            let q = c + DVec2::from_angle(0.5 * (w[0] + w[1])) * r;
            if q.min_element() < 0.0 || q.max_element() > 1.0 {
                continue;
            }
            let [inside, outside] = [true, false].map(|side| f64::from(u8::from(keeps(q, Some((k, side))))));
            let [(s0, c0), (s1, c1)] = [w[0], w[1]].map(f64::sin_cos);
            let green = 0.5 * r * (r * (w[1] - w[0]) + c.x * (s1 - s0) - c.y * (c1 - c0));
            sum += (inside - outside) * green;
        }
    }
    for (k, a) in CORNERS.into_iter().enumerate() {
        let b = CORNERS[(k + 1) % 4];
        let mut cuts = vec![0.0, 1.0];
        for &(c, r, _) in circles {
            let (middle, off) = ((c - a).dot(b - a), (c - a).perp_dot(b - a));
            let half = (r * r - off * off).sqrt();
            cuts.extend([middle - half, middle + half].into_iter().filter(|t| *t > 0.0 && *t < 1.0));
        }
        cuts.sort_by(f64::total_cmp);
        for w in cuts.windows(2) {
            if keeps(a.lerp(b, 0.5 * (w[0] + w[1])), None) {
                sum += 0.5 * a.lerp(b, w[0]).perp_dot(a.lerp(b, w[1]));
            }
        }
    }
    sum
}
