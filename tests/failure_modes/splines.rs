//! B-spline faces: helices, closed faces with seams anywhere, trims along knots, creases and natural borders.

use crate::body::{Body, frame, integral, level, through};
use crate::common::{prepared_clean, whole_frame};
use crate::ladder::Ladder;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use trimtess::audit;
use trimtess::frame::{Tolerance, plan};
use trimtess::model::{Coedge, CurveKind, Edge, EdgeId, Frame3, NurbsCurve3, NurbsSurface, Surface};

/// The unit circle as nine points of a rational quadratic; `true` marks the corners of a square.
const RING: [(f64, f64, bool); 9] = [
    (1.0, 0.0, false),
    (1.0, 1.0, true),
    (0.0, 1.0, false),
    (-1.0, 1.0, true),
    (-1.0, 0.0, false),
    (-1.0, -1.0, true),
    (0.0, -1.0, false),
    (1.0, -1.0, true),
    (1.0, 0.0, false),
];

fn ring_weight(corner: bool) -> f64 {
    if corner { 0.5_f64.sqrt() } else { 1.0 }
}

fn ring_knots() -> Vec<f64> {
    [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4].map(f64::from).to_vec()
}

/// A tube of the given radius along a helix about z: u along it, v around it. Also returns its length.
fn coil(wide: f64, pitch: f64, turns: f64, radius: f64) -> (NurbsSurface, f64) {
    let rise = pitch / TAU;
    let per_radian = wide.hypot(rise);
    let spine = |t: f64| DVec3::new(wide * t.cos(), wide * t.sin(), rise * t);
    let tangent = |t: f64| DVec3::new(-wide * t.sin(), wide * t.cos(), rise) / per_radian;
    let out = |t: f64| DVec3::new(t.cos(), t.sin(), 0.0);
    let count = (24.0 * turns) as u32;
    let mut surface = NurbsSurface {
        degree_u: 3,
        degree_v: 2,
        knots_u: Vec::new(),
        knots_v: ring_knots(),
        points: Vec::new(),
        weights: Vec::new(),
    };
    let rows: Vec<NurbsCurve3> = RING
        .iter()
        .map(|&(x, y, _)| {
            through(|t| spine(t) + radius * (x * out(t) + y * tangent(t).cross(out(t))), (0.0, TAU * turns), count)
        })
        .collect();
    surface.knots_u = rows[0].knots.clone();
    for i in 0..rows[0].points.len() {
        surface.points.extend(rows.iter().map(|row| row.points[i]));
        surface.weights.extend(RING.iter().map(|r| ring_weight(r.2)));
    }
    (surface, per_radian * TAU * turns)
}

/// The line of constant u of a coil.
fn rib(surface: &NurbsSurface, i: usize) -> NurbsCurve3 {
    let points = surface.points[i * RING.len()..(i + 1) * RING.len()].to_vec();
    NurbsCurve3 { degree: 2, knots: ring_knots(), points, weights: RING.map(|r| ring_weight(r.2)).to_vec() }
}

/// The line of constant v of a coil, where it is a row of control points.
fn stringer(surface: &NurbsSurface, j: usize) -> NurbsCurve3 {
    let points = surface.points.iter().skip(j).step_by(RING.len()).copied().collect();
    NurbsCurve3 { degree: 3, knots: surface.knots_u.clone(), points, weights: Vec::new() }
}

#[test]
fn helical_pipes_of_many_turns() {
    for (turns, with_seam) in [(0.75, false), (3.0, true), (25.0, false)] {
        let (wide, pitch, radius) = (10.0, 4.0, 1.0);
        let (surface, length) = coil(wide, pitch, turns, radius);
        let last = surface.points.len() / RING.len() - 1;
        let mut body = Body::solid();
        let [first, end] = [0, last].map(|i| body.spline(rib(&surface, i)));
        // S_u × S_v points inwards: u runs along the helix, v from outside upwards.
        let loops = if with_seam {
            let seam = body.spline(stringer(&surface, 0));
            vec![vec![seam.along(), end.along(), seam.against(), first.against()]]
        } else {
            vec![vec![first.against()], vec![end.along()]]
        };
        let caps = [0, last].map(|i| {
            let row = &surface.points[i * RING.len()..(i + 1) * RING.len()];
            (0.5 * (row[0] + row[4]), (row[0] - row[4]).cross(row[2] - row[6]))
        });
        body.face(Surface::Nurbs(surface), loops, true);
        for (k, (circle, (centre, normal))) in [first, end].into_iter().zip(caps).enumerate() {
            let along = frame(centre, normal, DVec3::X);
            body.face(Surface::Plane { frame: along }, vec![vec![circle.along()]], k == 0);
        }
        let volume = PI * radius * radius * length;
        // The spline is a thousandth of a radius off the helix.
        let ladder = Ladder::solid(body.finish(), volume, TAU * radius * length + TAU * radius * radius);
        ladder.chord(0.3).named((turns, with_seam)).assert_climbs();
    }
}

#[test]
fn a_ribbon_of_three_hundred_turns_on_a_cylinder() {
    let (radius, pitch, wide, turns) = (5.0, 1.0, 0.5, 300.0);
    let mut body = Body::sheet();
    let helix = |foot: f64| move |t: f64| DVec3::new(radius * t.cos(), radius * t.sin(), foot + pitch * t / TAU);
    let [low, high] = [0.0, wide].map(|foot| body.spline(through(helix(foot), (0.0, turns * TAU), 9600)));
    let [start, end] = [0.0, turns * TAU].map(|t| body.line(helix(0.0)(t), helix(wide)(t)));
    let back = Coedge { reversed: !start.reversed, ..start };
    let side = Surface::Cylinder { frame: Frame3::WORLD, radius };
    body.face(side, vec![vec![low.along(), end, high.against(), back]], false);
    Ladder::sheet(body.finish(), turns * TAU * radius * wide).chord(0.5).assert_climbs();
}

/// Half of the range of `t` in one span of [`whirl`].
const REACH: f64 = 0.9;
/// Half of the turns' exponent in [`whirl`].
const POWER: i32 = 4;

/// Angle of one span of [`whirl`]: nearly two turns.
fn whirl_angle() -> f64 {
    4.0 * f64::from(POWER) * REACH.atan()
}

/// Four spans of degree 9 around the unit cylinder, each by [`whirl_angle`] and up by 1.
///
/// With `n` = [`POWER`], the point `(1 + i t)^2n / (1 + t²)^n` of the plane is on the unit circle at the angle
/// `2 n atan t`. Numerator and denominator are powers of linear functions: their Bernstein coefficients are products of
/// powers of the values at both ends.
fn whirl(foot: f64) -> NurbsCurve3 {
    let n = POWER;
    let angle = 2.0 * REACH.atan();
    let size = (1.0 + REACH * REACH).powi(n);
    let choose = |n: i32, k: i32| (0..k).map(|i| f64::from(n - i) / f64::from(i + 1)).product::<f64>();
    let weight = |k: i32| {
        let ways = (0..=k).filter(|&j| j <= n && k - j <= n);
        let terms = ways.map(|j| choose(n, j) * choose(n, k - j) * (f64::from(2 * j - k) * angle).cos());
        size * terms.sum::<f64>() / choose(2 * n, k)
    };
    let m = 2 * n + 1;
    let raised = |c: &dyn Fn(i32) -> f64, k: i32| {
        let (below, above) = (f64::from(k) / f64::from(m), f64::from(m - k) / f64::from(m));
        let [below, above] = [(k > 0).then(|| below * c(k - 1)), (k < m).then(|| above * c(k))];
        below.unwrap_or(0.0) + above.unwrap_or(0.0)
    };
    let mut curve = NurbsCurve3 { degree: 9, knots: vec![0.0], points: Vec::new(), weights: Vec::new() };
    for span in 0..4 {
        let turned = |k: i32| f64::from(k - n) * angle + f64::from(span) * whirl_angle();
        for k in i32::from(span > 0)..=m {
            let w = raised(&weight, k);
            let x = raised(&|k| size * turned(k).cos(), k);
            let y = raised(&|k| size * turned(k).sin(), k);
            let climb = if k > 0 { f64::from(k) * weight(k - 1) / f64::from(m) } else { 0.0 };
            curve.points.push(DVec3::new(x, y, (foot + f64::from(span)) * w + climb) / w);
            curve.weights.push(w);
        }
        curve.knots.extend([f64::from(span); 9]);
    }
    curve.knots.extend([4.0; 10]);
    curve
}

#[test]
fn a_ribbon_whose_edges_turn_twice_in_each_span() {
    let wide = 0.3;
    let mut body = Body::sheet();
    let curves = [0.0, wide].map(whirl);
    let [start, end] = [0.0, 4.0].map(|t| {
        let [low, high] = [0, 1].map(|k: usize| curves[k].point(t));
        (low, high)
    });
    let [low, high] = curves.map(|curve| body.spline(curve));
    let [start, end] = [start, end].map(|(a, b)| body.line(a, b));
    let back = Coedge { reversed: !start.reversed, ..start };
    let side = Surface::Cylinder { frame: Frame3::WORLD, radius: 1.0 };
    body.face(side, vec![vec![low.along(), end, high.against(), back]], false);
    let part = body.finish();
    for chord in [0.05, 1.6e-3, 4e-4] {
        Ladder::sheet(part.clone(), 4.0 * whirl_angle() * wide).chord(chord).assert_climbs();
    }
}

/// The exact NURBS form of an analytic surface over a box.
fn as_nurbs(surface: &Surface, u: (f64, f64), v: (f64, f64)) -> Surface {
    Surface::Nurbs(surface.to_nurbs(u, v).0)
}

#[test]
fn cylinders_as_splines_with_the_seam_anywhere() {
    let (radius, height) = (3.0, 7.0);
    for start in [0.0, 1.0, -2.5] {
        for with_seam in [false, true] {
            let mut body = Body::solid();
            let [low, high] = [0.0, height].map(|z| body.circle(&level(z), radius));
            let loops = if with_seam {
                // Its vertex is that of the circles, not where the spline begins.
                let seam = body.line(DVec3::X * radius, DVec3::new(radius, 0.0, height));
                let down = seam.edge.against();
                vec![vec![low.along(), seam, high.against(), down]]
            } else {
                vec![vec![low.along()], vec![high.against()]]
            };
            let round = Surface::Cylinder { frame: Frame3::WORLD, radius };
            body.face(as_nurbs(&round, (start, start + TAU), (-1.0, height + 1.0)), loops, false);
            body.face(Surface::Plane { frame: Frame3::WORLD }, vec![vec![low.along()]], true);
            body.flat(level(height), vec![vec![high.along()]]);
            let area = TAU * radius * (radius + height);
            Ladder::solid(body.finish(), PI * radius * radius * height, area).named((start, with_seam)).assert_climbs();
        }
    }
}

#[test]
fn whole_tori_and_balls_as_splines() {
    let (major, minor) = (8.0, 3.0);
    for start in [0.0, 1.0] {
        let mut body = Body::solid();
        let torus = Surface::Torus { frame: Frame3::WORLD, major, minor };
        body.face(as_nurbs(&torus, (start, start + TAU), (start, start + TAU)), Vec::new(), false);
        let ladder = Ladder::solid(body.finish(), TAU * PI * major * minor * minor, TAU * TAU * major * minor);
        ladder.pieces(1).named(start).assert_climbs();

        let mut body = Body::solid();
        let ball = Surface::Sphere { frame: Frame3::WORLD, radius: 5.0 };
        let half = 0.5 * PI;
        body.face(as_nurbs(&ball, (start, start + TAU), (-half, half)), Vec::new(), false);
        Ladder::solid(body.finish(), 500.0 / 3.0 * PI, 100.0 * PI).pieces(1).named(start).assert_climbs();
    }
}

#[test]
fn windows_in_a_torus_of_splines_across_its_seams() {
    let (major, minor): (f64, f64) = (8.0, 3.0);
    let torus = Surface::Torus { frame: Frame3::WORLD, major, minor };
    for (u0, v0) in [(1.0, 1.0), (-0.3, 1.0), (1.0, -0.4), (-0.3, -0.4)] {
        let (u1, v1) = (u0 + 0.8, v0 + 0.9);
        let mut body = Body::sheet();
        let edge = |body: &mut Body, from: (f64, f64), to: (f64, f64)| -> EdgeId {
            let at = |t: f64| torus.point(from.0 + (to.0 - from.0) * t, from.1 + (to.1 - from.1) * t);
            body.spline(through(at, (0.0, 1.0), 16))
        };
        let (south, north) = (edge(&mut body, (u0, v0), (u1, v0)), edge(&mut body, (u0, v1), (u1, v1)));
        let (west, east) = (edge(&mut body, (u0, v0), (u0, v1)), edge(&mut body, (u1, v0), (u1, v1)));
        let window = vec![west.along(), north.along(), east.against(), south.against()];
        body.face(as_nurbs(&torus, (0.0, TAU), (0.0, TAU)), vec![window], false);
        let hole = (u1 - u0) * minor * (major * (v1 - v0) + minor * (v1.sin() - v0.sin()));
        Ladder::sheet(body.finish(), TAU * TAU * major * minor - hole).named((u0, v0)).assert_climbs();
    }
}

#[test]
fn a_tube_with_unclamped_periodic_knots() {
    // Uniform cubic, nine control points of which the last three repeat the first: no knot where the ends meet.
    let count = 6;
    let knots_u: Vec<f64> = (-3..=count + 3).map(f64::from).collect();
    let ring = |k: i32| DVec3::new(4.0, 0.0, 0.0).rotate_z(TAU * f64::from(k) / f64::from(count));
    let points = (0..count + 3).flat_map(|k| [ring(k), ring(k) + DVec3::Z * 10.0]).collect();
    let tube = NurbsSurface {
        degree_u: 3,
        degree_v: 1,
        knots_u: knots_u.clone(),
        knots_v: vec![0.0, 0.0, 10.0, 10.0],
        points,
        weights: Vec::new(),
    };
    let rim = |z: f64| NurbsCurve3 {
        degree: 3,
        knots: knots_u.clone(),
        points: (0..count + 3).map(|k| ring(k) + DVec3::Z * z).collect(),
        weights: Vec::new(),
    };
    let (from, to) = rim(0.0).domain();
    let (mut around, mut twice) = (0.0, 0.0);
    let steps = 40_000;
    for k in 0..steps {
        let t = |k: i32| from + (to - from) * f64::from(k) / f64::from(steps);
        let (a, b) = (rim(0.0).point(t(k)), rim(0.0).point(t(k + 1)));
        around += a.distance(b);
        twice += a.truncate().perp_dot(b.truncate());
    }
    for (with_window, with_seam) in [(false, false), (false, true), (true, false)] {
        let mut body = Body::solid();
        let [low, high] = [0.0, 10.0].map(|z| body.spline(rim(z)));
        let mut loops = vec![vec![low.along()], vec![high.against()]];
        if with_seam {
            let start = rim(0.0).point(from);
            let seam = body.line(start, start + DVec3::Z * 10.0);
            let down = seam.edge.against();
            loops = vec![vec![low.along(), seam, high.against(), down]];
        }
        if with_window {
            // A round window across the seam makes it an open shell.
            let mut sheet = Body::sheet();
            let [low, high] = [0.0, 10.0].map(|z| sheet.spline(rim(z)));
            let at = |t: f64| {
                let u = from + (0.7 * t.cos()).rem_euclid(to - from);
                rim(0.0).point(u) + DVec3::Z * (5.0 + 2.0 * t.sin())
            };
            let hole = sheet.spline(through(at, (0.5 * PI, 2.5 * PI), 96));
            sheet.face(
                Surface::Nurbs(tube.clone()),
                vec![vec![low.along()], vec![high.against()], vec![hole.against()]],
                false,
            );
            let mut missing = 0.0;
            for k in 0..4000 {
                let t = PI * (f64::from(k) + 0.5) / 4000.0;
                let u = from + (0.7 * t.cos()).rem_euclid(to - from);
                missing += rim(0.0).derivatives(u).d1.length() * 0.7 * t.sin() * 4.0 * t.sin() * (PI / 4000.0);
            }
            Ladder::sheet(sheet.finish(), around * 10.0 - missing).named("window").assert_climbs();
            continue;
        }
        body.face(Surface::Nurbs(tube.clone()), loops, false);
        let flat = |body: &mut Body, rim: EdgeId, z: f64| {
            body.face(Surface::Plane { frame: level(z) }, vec![vec![rim.along()]], z == 0.0);
        };
        flat(&mut body, low, 0.0);
        flat(&mut body, high, 10.0);
        Ladder::solid(body.finish(), 5.0 * twice, around * 10.0 + twice).named(with_seam).assert_climbs();
    }
}

/// A roof over x from 0 to 6: quadratic spans with a knot at 2 and a crease at 4, extruded along y from 0 to 5.
fn roof() -> NurbsSurface {
    let profile = [(0.0, 0.0), (1.0, 1.0), (3.0, 1.0), (4.0, 0.0), (5.0, 2.0), (6.0, 1.0)];
    NurbsSurface {
        degree_u: 2,
        degree_v: 1,
        knots_u: vec![0.0, 0.0, 0.0, 2.0, 4.0, 4.0, 6.0, 6.0, 6.0],
        knots_v: vec![0.0, 0.0, 5.0, 5.0],
        points: profile.iter().flat_map(|&(x, z)| [DVec3::new(x, 0.0, z), DVec3::new(x, 5.0, z)]).collect(),
        weights: Vec::new(),
    }
}

/// The roof's profile at the given y.
fn ridge(y: f64) -> NurbsCurve3 {
    let roof = roof();
    let points = roof.points.iter().step_by(2).map(|&p| DVec3::new(p.x, y, p.z)).collect();
    NurbsCurve3 { degree: 2, knots: roof.knots_u, points, weights: Vec::new() }
}

/// An edge along a part of the roof's profile at the given y.
fn stretch(body: &mut Body, y: f64, from: f64, to: f64) -> Coedge {
    let curve = ridge(y);
    let (start, end) = (body.vertex(curve.point(from)), body.vertex(curve.point(to)));
    body.part.edge(Edge { curve, range: (from, to), start, end, kind: CurveKind::Spline, entity: 0 }).along()
}

#[test]
fn trims_along_knots_creases_and_natural_borders() {
    // The roof cut into strips between u = 0, a knot, a crease, and its natural border: neighbours on one surface.
    let surface = Surface::Nurbs(roof());
    let cuts: [&[f64]; 5] =
        [&[0.0, 6.0], &[0.0, 2.0, 6.0], &[0.0, 4.0, 6.0], &[0.0, 2.0, 4.0, 6.0], &[1.0, 2.0, 3.0, 4.0, 5.0]];
    for us in cuts {
        let mut body = Body::sheet();
        let ends: Vec<[DVec3; 2]> = us.iter().map(|&u| [surface.point(u, 0.0), surface.point(u, 5.0)]).collect();
        let mut length = 0.0;
        for (k, w) in us.windows(2).enumerate() {
            let (south, north) = (stretch(&mut body, 0.0, w[0], w[1]), stretch(&mut body, 5.0, w[0], w[1]));
            let east = body.line(ends[k + 1][0], ends[k + 1][1]);
            let west = body.line(ends[k][1], ends[k][0]);
            body.face(surface.clone(), vec![vec![south, east, Coedge { reversed: true, ..north }, west]], false);
            let curve = ridge(0.0);
            let steps = 4000;
            let t = |k: i32| w[0] + (w[1] - w[0]) * f64::from(k) / f64::from(steps);
            length += (0..steps).map(|k| curve.point(t(k)).distance(curve.point(t(k + 1)))).sum::<f64>();
        }
        Ladder::sheet(body.finish(), 5.0 * length).pieces(1).named(us).assert_climbs();
    }
}

#[test]
fn a_hole_that_runs_along_a_crease() {
    // A slot whose long side is the crease, and one across it.
    let surface = Surface::Nurbs(roof());
    for (u0, u1) in [(4.0, 5.0), (3.0, 4.0), (3.2, 4.7)] {
        let mut body = Body::sheet();
        let turned = |c: Coedge| Coedge { reversed: !c.reversed, ..c };
        let rectangle = |body: &mut Body, (u0, u1): (f64, f64), (v0, v1): (f64, f64)| {
            let (south, north) = (stretch(body, v0, u0, u1), stretch(body, v1, u0, u1));
            let east = body.line(surface.point(u1, v0), surface.point(u1, v1));
            let west = body.line(surface.point(u0, v1), surface.point(u0, v0));
            vec![south, east, turned(north), west]
        };
        let outer = rectangle(&mut body, (0.0, 6.0), (0.0, 5.0));
        let hole = rectangle(&mut body, (u0, u1), (1.0, 4.0)).into_iter().rev().map(turned).collect();
        body.face(surface.clone(), vec![outer, hole], false);
        let curve = ridge(0.0);
        let length = |from: f64, to: f64| {
            let t = |k: i32| from + (to - from) * f64::from(k) / 4000.0;
            (0..4000).map(|k| curve.point(t(k)).distance(curve.point(t(k + 1)))).sum::<f64>()
        };
        Ladder::sheet(body.finish(), 5.0 * length(0.0, 6.0) - 3.0 * length(u0, u1)).named((u0, u1)).assert_climbs();
    }
}

#[test]
fn lines_that_bend_within_a_plane() {
    // Four flat pieces around a lattice point that is inside in (u,v) and beyond an edge in space. Lines bend there, as
    // at a crease, but the normal does not turn.
    let steps = [0.0, 1.0, 2.0];
    let mut points: Vec<DVec3> = steps.iter().flat_map(|&x| steps.map(|y| DVec3::new(x, y, 0.0))).collect();
    points[4] = DVec3::new(1.2, 1.1, 0.0);
    let knots = vec![0.0, 0.0, 1.0, 2.0, 2.0];
    let (knots_u, knots_v) = (knots.clone(), knots);
    let surface = NurbsSurface { degree_u: 1, degree_v: 1, knots_u, knots_v, points, weights: Vec::new() };
    let mut body = Body::sheet();
    let corners = [(0.2, 0.5), (1.18, 0.5), (1.18, 1.5), (0.2, 1.5)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let wire = body.polygon(&corners);
    body.face(Surface::Nurbs(surface), vec![wire], false);
    Ladder::sheet(body.finish(), 0.98).pieces(1).assert_climbs();
}

#[test]
fn a_sheet_folded_back_onto_itself() {
    // Two legs that meet in a crease at a sharp angle: edges across it must not be projected onto the wrong leg. Edges
    // and surface have the crease at different fractions of their ranges, with the edges in both directions.
    for angle in [0.5_f64, 0.1, 0.02, 4e-3] {
        for (crease, knot) in [(0.5, 0.5), (0.5, 0.2), (0.3, 0.9)] {
            let profile =
                [DVec3::ZERO, DVec3::X * 10.0, DVec3::new(10.0 * (1.0 - angle.cos()), 0.0, 10.0 * angle.sin())];
            let surface = Surface::Nurbs(NurbsSurface {
                degree_u: 1,
                degree_v: 1,
                knots_u: vec![0.0, 0.0, crease, 1.0, 1.0],
                knots_v: vec![0.0, 0.0, 5.0, 5.0],
                points: profile.iter().flat_map(|&p| [p, p + DVec3::Y * 5.0]).collect(),
                weights: Vec::new(),
            });
            let mut body = Body::sheet();
            let [south, north] = [0.0, 5.0].map(|y| {
                let points = profile.iter().map(|&p| p + DVec3::Y * y).collect();
                let knots = vec![0.0, 0.0, knot, 1.0, 1.0];
                body.spline(NurbsCurve3 { degree: 1, knots, points, weights: Vec::new() })
            });
            let across = DVec3::Y * 5.0;
            let (east, west) = (body.line(profile[2], profile[2] + across), body.line(across, DVec3::ZERO));
            body.face(surface, vec![vec![south.along(), east, north.against(), west]], false);
            Ladder::sheet(body.finish(), 100.0).pieces(1).named((angle, crease, knot)).assert_climbs();
        }
    }
}

#[test]
fn a_sheet_bent_back_onto_itself() {
    // Two legs close together, with a bend between them. Edges run through the bend at another speed than the surface.
    for gap in [1.0, 0.1] {
        for weight in [1.0, 0.3, 3.0] {
            let profile = [DVec3::ZERO, DVec3::new(20.0, 0.0, 0.5 * gap), DVec3::Z * gap];
            let bend = |y: f64, weight: f64| {
                NurbsCurve3::bezier(
                    profile.iter().map(|&p| p + DVec3::Y * y).collect(),
                    vec![1.0, weight, weight * weight],
                )
            };
            let surface = Surface::Extrusion { curve: bend(0.0, 1.0), direction: DVec3::Y };
            for as_spline in [false, true] {
                let surface = if as_spline {
                    Surface::Nurbs(surface.to_nurbs((0.0, 1.0), (0.0, 5.0)).0)
                } else {
                    surface.clone()
                };
                let mut body = Body::sheet();
                let [south, north] = [0.0, 5.0].map(|y| body.spline(bend(y, weight)));
                let across = DVec3::Y * 5.0;
                let (east, west) = (body.line(profile[2], profile[2] + across), body.line(across, DVec3::ZERO));
                body.face(surface, vec![vec![south.along(), east, north.against(), west]], false);
                let length = integral(|t| bend(0.0, 1.0).derivatives(t).d1.length(), (0.0, 1.0));
                Ladder::sheet(body.finish(), 5.0 * length)
                    .chord(0.1 * gap)
                    .pieces(1)
                    .named((gap, weight, as_spline))
                    .assert_climbs();
            }
        }
    }
}

#[test]
fn a_patch_whose_whole_border_is_one_point() {
    // It lies in a plane and is folded onto itself. It has no period, although every line of it is closed.
    let inner = |k: usize| k == 1 || k == 2;
    let net = (0..16).map(|k| (k / 4, k % 4));
    let point = |(i, j)| if inner(i) && inner(j) { DVec3::new(i as f64, j as f64, 0.0) } else { DVec3::ZERO };
    let bag = NurbsSurface::bezier((3, 3), net.map(point).collect(), Vec::new());
    let mut body = Body::sheet();
    body.face(Surface::Nurbs(bag), Vec::new(), false);
    let prepared = prepared_clean(body.finish());
    for chord in [1e-2, 1e-3] {
        let plan = plan(&prepared, &Tolerance { chord, angle: 0.5, max_edge: None });
        let sink = whole_frame(&prepared, &plan, true);
        let deviation = audit::deviation(&prepared, &sink, chord);
        assert!(deviation.beyond_gap.samples > 0 && deviation.beyond_gap.worst <= 1.0, "{deviation}");
    }
}

/// A circle about z of rational arcs, each over one unit of the parameter, that turn by as many degrees.
fn uneven_circle(radius: f64, z: f64, turns: [f64; 3]) -> NurbsCurve3 {
    let mut circle = NurbsCurve3 {
        degree: 2,
        knots: [0, 0, 0, 1, 1, 2, 2, 3, 3, 3].map(f64::from).to_vec(),
        points: vec![DVec3::new(radius, 0.0, z)],
        weights: vec![1.0],
    };
    let mut at = 0.0;
    for half in turns.map(|turn| 0.5 * turn.to_radians()) {
        let weight = half.cos();
        for (angle, weight) in [(at + half, weight), (at + 2.0 * half, 1.0)] {
            let [x, y] = [angle.cos(), angle.sin()].map(|x| radius / weight * x);
            circle.points.push(DVec3::new(x, y, z));
            circle.weights.push(weight);
        }
        at += 2.0 * half;
    }
    circle.points[6] = circle.points[0];
    circle
}

#[test]
fn speeds_differ_by_decades_across_knots_and_across_the_seam() {
    let (radius, height) = (5.0, 8.0);
    for turns in [[176.0, 176.0, 8.0], [178.0, 178.0, 4.0], [2.0, 179.0, 179.0], [178.0, 4.0, 178.0]] {
        let rows = [0.0, height].map(|z| uneven_circle(radius, z, turns));
        let pairs = |k: usize| [rows[0].points[k], rows[1].points[k]];
        let surface = NurbsSurface {
            degree_u: 2,
            degree_v: 1,
            knots_u: rows[0].knots.clone(),
            knots_v: vec![0.0, 0.0, 1.0, 1.0],
            points: (0..7).flat_map(pairs).collect(),
            weights: rows[0].weights.iter().flat_map(|&w| [w, w]).collect(),
        };
        let mut body = Body::solid();
        let [foot, head] = rows.map(|row| body.spline(row));
        let seam = body.line(DVec3::X * radius, DVec3::new(radius, 0.0, height));
        let loops = vec![vec![foot.along(), seam, head.against(), seam.edge.against()]];
        body.face(Surface::Nurbs(surface), loops, false);
        body.flat(level(height), vec![vec![head.along()]]);
        body.face(Surface::Plane { frame: Frame3::WORLD }, vec![vec![foot.along()]], true);
        let base = PI * radius * radius;
        Ladder::solid(body.finish(), base * height, 2.0 * base + TAU * radius * height).named(turns).assert_climbs();
    }
}

/// A wavy outline and a wavy hole of two edges, both of many spans, on a cylinder: which one is halved to keep their
/// chords apart takes a long search, and both are far from each other.
#[test]
fn wavy_outlines_far_apart_do_not_count_as_near() {
    const RADIUS: f64 = 5.0;
    let on = |p: DVec2| DVec3::new(RADIUS * (p.x / RADIUS).cos(), RADIUS * (p.x / RADIUS).sin(), p.y);
    let wavy = |size: f64| move |t: f64| on(DVec2::from_angle(t) * size * (1.0 + 0.1 * (12.0 * t).cos()));
    let mut body = Body::sheet();
    let outer = body.spline(through(wavy(2.0), (0.0, TAU), 600));
    let hole = [(0.0, PI), (PI, TAU)].map(|range| body.spline(through(wavy(0.7), range, 150)));
    let [first, second] = hole.map(|edge| Coedge { edge, reversed: true });
    let loops = vec![vec![Coedge { edge: outer, reversed: false }], vec![second, first]];
    body.face(Surface::Cylinder { frame: Frame3::WORLD, radius: RADIUS }, loops, false);
    // The cylinder unrolls without stretching.
    let area = PI * (2.0 * 2.0 - 0.7 * 0.7) * (1.0 + 0.5 * 0.1 * 0.1);
    Ladder::sheet(body.finish(), area).assert_climbs();
}
