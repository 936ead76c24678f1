//! Tessellated curves cross only where the exact ones do: critical parameters hold at any rate.

use crate::draw::flower;
use crate::meshes::{judge, prepared, sheet};
use crate::random::SplitMix;
use glam::DVec2;
use std::f64::consts::TAU;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use trimtess::frame::internals::{EdgePolyline, edge_line};
use trimtess::frame::{Plan, Tolerance, plan};
use trimtess::math::predicates::orient2d;
use trimtess::model::{Diagnostic, EdgeId, FreeTrims, PartId, Severity, Surface, TrimCurve, TrimRule};
use trimtess::prepare::Prepared;
use trimtess::prepare::internals::PreparedEdge;

/// A segment of a tessellated edge of a sheet over its own parameters, and its place on the edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    pub(crate) ends: [DVec2; 2],
    /// The edge and the range of parameters, for messages about crossings.
    #[allow(dead_code, reason = "for messages")]
    edge: (u32, [f64; 2]),
}

/// The segments of all edges that bound tiles.
pub(crate) fn segments(prepared: &Prepared, plan: &Plan) -> Vec<Segment> {
    let part = &prepared.parts[0];
    let mut out = Vec::new();
    for (edge, _) in part.edges.iter().enumerate().filter(|(_, row)| !row.uses.is_empty()) {
        let points = edge_line(prepared, plan, PartId(0), EdgeId(edge as u32)).points;
        let ts = &plan.parts[0].edges[edge].ts;
        out.extend((1..points.len()).map(|k| Segment {
            ends: [points[k - 1].truncate(), points[k].truncate()],
            edge: (edge as u32, [ts[k - 1], ts[k]]),
        }));
    }
    out
}

/// Pairs of segments that cross in a point that is an end of neither.
pub(crate) fn crossings(segments: &[Segment]) -> Vec<[Segment; 2]> {
    let mut order: Vec<Segment> = segments.to_vec();
    let low = |s: &Segment| s.ends[0].min(s.ends[1]);
    let high = |s: &Segment| s.ends[0].max(s.ends[1]);
    order.sort_by(|a, b| low(a).x.total_cmp(&low(b).x));
    let mut out = Vec::new();
    for (k, a) in order.iter().enumerate() {
        for b in order[k + 1..].iter().take_while(|b| low(b).x <= high(a).x) {
            if low(b).y > high(a).y || low(a).y > high(b).y {
                continue;
            }
            let ([p, q], [r, s]) = (a.ends, b.ends);
            let sides = [orient2d(p, q, r) * orient2d(p, q, s), orient2d(r, s, p) * orient2d(r, s, q)];
            if sides.iter().all(|&side| side < 0.0) {
                out.push([*a, *b]);
            }
        }
    }
    out
}

/// The plan with `count()` segments over each edge's whole range, even in its parameter, on the coarsest lattice.
/// Between two breaks there are never fewer segments than in the coarsest plan.
pub(crate) fn evenly(prepared: &Prepared, mut count: impl FnMut() -> f64) -> Plan {
    let mut plan = plan(prepared, &Tolerance { chord: f64::INFINITY, angle: f64::INFINITY, max_edge: None });
    for (part, planned) in prepared.parts.iter().zip(&mut plan.parts) {
        for (edge, line) in part.edges.iter().zip(&mut planned.edges).filter(|(edge, _)| !edge.uses.is_empty()) {
            let whole = edge.breaks[edge.breaks.len() - 1].t - edge.breaks[0].t;
            let rate = count() / whole;
            refine(edge, Arc::make_mut(line), |length, least| ((length * rate).ceil() as usize).max(least));
        }
    }
    plan
}

/// Spaces points evenly between breaks. `count` maps the length of a parameter range and its present number of segments
/// to the new number.
pub(crate) fn refine(edge: &PreparedEdge, line: &mut EdgePolyline, count: impl Fn(f64, usize) -> usize) {
    let mut ts = vec![line.ts[0]];
    let mut breaks = vec![0];
    for (stops, ends) in edge.breaks.windows(2).zip(line.breaks.windows(2)) {
        let [a, b] = [stops[0].t, stops[1].t];
        let n = count(b - a, (ends[1] - ends[0]) as usize);
        ts.extend((1..n).map(|k| a + (b - a) * k as f64 / n as f64));
        ts.push(b);
        breaks.push(ts.len() as u32 - 1);
    }
    (line.ts, line.breaks) = (ts.into(), breaks.into());
}

/// Two curves within `gap` of each other (or touching, or equal up to rounding), with a kept side between them.
fn pair(draw: &mut SplitMix, kind: u64, gap: f64) -> Vec<TrimCurve> {
    let centre = DVec2::new(draw.range(0.4, 0.6), draw.range(0.4, 0.6));
    let way = DVec2::from_angle(draw.range(0.0, TAU));
    let r = draw.range(0.1, 0.3);
    let circle = |c: DVec2, r: f64| {
        // Seams in different places.
        let (a, b) = (way.rotate(DVec2::from_angle(1.0)), way.rotate(DVec2::from_angle(1.0)).perp());
        TrimCurve::ellipse(c, a * r, b * r)
    };
    match kind {
        // Concentric.
        0 => vec![circle(centre, r), TrimCurve::circle(centre, r - gap).reversed()],
        // Touching from inside.
        1 => {
            let s = r * draw.range(0.1, 0.95);
            vec![circle(centre, r), TrimCurve::circle(centre + way * (r - s - gap), s).reversed()]
        }
        // Touching from outside.
        2 => {
            let s = r * draw.range(0.1, 0.6);
            vec![
                circle(centre, r * 0.6).reversed(),
                TrimCurve::circle(centre + way * (r * 0.6 + s + gap), s).reversed(),
            ]
        }
        // An ellipse and its circle of curvature at the end of an axis: four points of contact in one.
        3 => {
            let b = r * draw.range(0.5, 0.9);
            let s = b * b / r;
            let circle = TrimCurve::circle(centre + way * (r - s - gap), s);
            vec![TrimCurve::ellipse(centre, way * r, way.perp() * b), circle.reversed()]
        }
        // A line next to a circle.
        4 => {
            let p = centre + way * (r + gap);
            let side = way.perp();
            vec![
                circle(centre, r).reversed(),
                TrimCurve::polygon(vec![p - side * 0.1, p + way * 0.05, p + side * 0.1]).reversed(),
            ]
        }
        // A flower in a slightly larger one.
        5 => {
            let outer = flower(centre, r, 5, 0.4);
            let scaled = flower(centre, r - gap, 5, 0.4);
            vec![outer, scaled.reversed()]
        }
        // A band between a free cubic and its copy.
        _ => {
            let inner: Vec<f64> = (0..2).map(|_| draw.range(0.2, 0.7)).collect();
            let cubic = |lift: f64| {
                let at = |x: f64, y: f64| DVec2::new(x, y + lift);
                TrimCurve::bezier(vec![at(0.0, 0.4), at(0.3, inner[0]), at(0.6, inner[1]), at(1.0, 0.5)], Vec::new())
            };
            vec![cubic(0.0), cubic(gap).reversed()]
        }
    }
}

/// The polylines of curves that touch, or nearly touch, do not cross at any rates.
#[test]
fn curves_that_touch_or_nearly_touch_are_apart_at_any_rates() {
    let seeds = std::env::var("TRIMTESS_PAIRS").map_or(1, |n| n.parse().unwrap());
    let gaps = [0.0, 1e-9, 1e-8, 3e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2];
    let case = |seed: u64, kind: u64, gap: f64| {
        let mut draw = SplitMix(1000 * seed + kind);
        let case = format!("seed {seed}, kind {kind}, gap {gap:e}");
        let trims = FreeTrims { rule: TrimRule::Handedness, curves: pair(&mut draw, kind, gap) };
        let prepared = prepared(Surface::Nurbs(sheet()), trims);
        let is_told = |d: &Diagnostic| d.severity == Severity::Note;
        assert!(prepared.diagnostics.iter().all(is_told), "{case}: {:?}", prepared.diagnostics);
        for most in [0.0, 1.0, 2.0, 3.0] {
            let plan = evenly(&prepared, || 10.0_f64.powf(draw.range(0.0, most)));
            let case = format!("{case}, up to 10^{most} segments");
            let crossings = crossings(&segments(&prepared, &plan));
            assert!(crossings.is_empty(), "{case}: {} crossings, {:?}", crossings.len(), crossings[0]);
            judge(&prepared, &plan, &case);
        }
    };
    let cases = (0..seeds).flat_map(|seed| (0..7).flat_map(move |kind| gaps.map(|gap| (seed, kind, gap))));
    // Osculating curves are closer than a billionth, hence merged, along a stretch: the region between them is a cusp.
    let cases = cases.filter(|&(_, kind, gap)| kind != 3 || gap >= 1e-8);
    let failed: Vec<_> =
        cases.filter(|&(seed, kind, gap)| catch_unwind(AssertUnwindSafe(|| case(seed, kind, gap))).is_err()).collect();
    assert!(failed.is_empty(), "seed, kind, gap: {failed:?}");
}
