//! A face without a usable region -> a face filled in space: its stated loops, projected to their best-fit plane.
//!
//! The neighbours use the same loops, so the mesh stays closed. The projected loops decide where triangles lie. They
//! need not be simple, disjoint, or on a surface.

use crate::math::boxes::around;
use crate::math::solve::equal_pieces;
use crate::model::{CurveKind, EdgeId, Frame3, NurbsCurve3, Part, Surface};
use crate::prepare::surface::arc_bounds;
use crate::prepare::surface::decompose::BezierPatches;
use crate::prepare::tiles::draft::{DraftAlong, DraftTile, DraftUse, FaceDraft};
use crate::prepare::tiles::extent::Patched;
use crate::prepare::uv::uv_curve::{UvCurve, UvSample};
use crate::prepare::wires::boundary::of_boundary;
use crate::prepare::wires::heal::ends;
use glam::{DVec2, DVec3};
use std::borrow::Cow;
use std::sync::Arc;

/// A filled face, and the area that its loops enclose in their plane, mm².
pub(crate) struct FilledFace {
    pub(crate) draft: FaceDraft,
    pub(crate) area: f64,
    /// Diagonal of its box in the plane, mm.
    pub(crate) size: f64,
}

/// Curves of fewer spans get [`SAMPLES`] samples per span, others one.
const FEW_SPANS: usize = 32;
const SAMPLES: usize = 4;

/// Fills loops of edges. `None` if there are none, or if an edge or a vertex is missing or not finite.
pub(crate) fn fill(part: &Part, boundary: &[Vec<(u32, bool)>]) -> Option<FilledFace> {
    if boundary.is_empty() {
        return None;
    }
    let mut outlines: Vec<Vec<Outline>> = Vec::with_capacity(boundary.len());
    for l in boundary {
        outlines.push(l.iter().map(|&(edge, reversed)| Outline::of(part, edge, reversed)).collect::<Option<_>>()?);
    }
    let polygons: Vec<Vec<DVec3>> = outlines.iter().map(|l| l.iter().flat_map(Outline::polyline).collect()).collect();
    let (frame, area) = plane(&polygons)?;
    let points = || polygons.iter().flatten().map(|&p| frame.local(p));
    let [low, high] = around(points().map(|p| p.truncate()));
    let gap = points().map(|p| p.z.abs()).fold(0.0, f64::max);
    // Curved edges stay within the margin between samples, and a line or a point gets a box.
    let coordinates = polygons.iter().flatten().fold(0.0_f64, |most, p| most.max(p.abs().max_element()));
    let longest = (high - low).max_element().max(1e-9 * coordinates);
    let margin = 0.0625 * if longest > 0.0 { longest } else { 1.0 };
    let (min, max) = (low - margin, high + margin);
    let surface = Surface::Plane { frame };
    let (nurbs, maps) = surface.to_nurbs((min.x, max.x), (min.y, max.y));
    let patches = BezierPatches::over(&nurbs, (min.x, max.x), (min.y, max.y));
    if !patches.control.iter().all(|c| c.is_finite()) {
        return None;
    }
    let bounds = arc_bounds::analytic(&surface, &maps, &patches)?;
    let loops = outlines.iter().map(|l| l.iter().map(|o| o.seen_in(&frame)).collect()).collect();
    let (patches, bounds, creases) = (Arc::new(patches), Arc::new(bounds), [Vec::new(), Vec::new()]);
    let draft = FaceDraft {
        surface: Patched { patches, bounds, maps, creases, sharp: false },
        gap,
        critical: 0,
        meetings: 0,
        tiles: vec![DraftTile { min, max, loops, entangled: true }],
        borders: Vec::new(),
        chain: of_boundary(boundary),
        breaks: Vec::new(),
        joints: Vec::new(),
        notes: Vec::new(),
        repairs: Vec::new(),
        crosses: false,
        tangles: Vec::new(),
        filled: true,
        lobed: Vec::new(),
        ends_with_surface: false,
    };
    Some(FilledFace { draft, area, size: (high - low).length() })
}

/// Replaces the curves of a boundary that cannot be evaluated by straight lines.
pub(crate) fn straighten(part: &mut Cow<'_, Part>, boundary: &[Vec<(u32, bool)>]) {
    for &(edge, _) in boundary.iter().flatten() {
        let Some(e) = part.edges.get(edge as usize) else { continue };
        let (t0, t1) = e.range;
        let sound = t0.is_finite() && t1.is_finite() && t0 < t1 && e.curve.check().is_ok() && {
            let (low, high) = e.curve.domain();
            t0 < high && t1 > low && [t0, 0.5 * (t0 + t1), t1].iter().all(|&t| e.curve.point(t).is_finite())
        };
        let ends = [e.start, e.end].map(|v| part.vertices.get(v.index()).copied());
        let ([Some(a), Some(b)], false) = (ends, sound) else { continue };
        let e = &mut part.to_mut().edges[edge as usize];
        e.curve = NurbsCurve3::line(a, b);
        e.range = e.curve.domain();
        e.kind = CurveKind::Line;
    }
}

/// Samples along an edge, in order of its parameter.
struct Outline {
    edge: u32,
    reversed: bool,
    /// Parameter, point and derivative.
    samples: Vec<(f64, DVec3, DVec3)>,
}

impl Outline {
    fn of(part: &Part, edge: u32, reversed: bool) -> Option<Self> {
        let [start, end] =
            ends(part, EdgeId(edge), false)?.map(|v| part.vertices.get(v.index()).copied().filter(|p| p.is_finite()));
        let (start, end, e) = (start?, end?, part.edges.get(edge as usize)?);
        let (t0, t1) = e.range;
        let mut stops = vec![t0];
        stops.extend(e.curve.knots.iter().copied().filter(|&t| t > t0 && t < t1));
        stops.push(t1);
        stops.dedup_by(|b, a| *b <= *a);
        let parts = if stops.len() <= FEW_SPANS { SAMPLES } else { 1 };
        let mut ts: Vec<f64> = equal_pieces(&stops, parts).chain([t1]).collect();
        ts.dedup_by(|b, a| *b <= *a);
        let mut samples: Vec<(f64, DVec3, DVec3)> = ts
            .into_iter()
            .map(|t| {
                let [point, d] = e.curve.tangent(t);
                (t, point, d)
            })
            .collect();
        let last = samples.len().checked_sub(1).filter(|&last| last > 0)?;
        // The mesh ends at the vertices.
        (samples[0].1, samples[last].1) = (start, end);
        samples.iter().all(|s| s.1.is_finite()).then_some(Self { edge, reversed, samples })
    }

    /// Points in loop direction, without the last.
    fn polyline(&self) -> impl Iterator<Item = DVec3> + '_ {
        let n = self.samples.len();
        (0..n - 1).map(move |k| self.samples[if self.reversed { n - 1 - k } else { k }].1)
    }

    /// The edge's use by a loop in the plane of `frame`.
    fn seen_in(&self, frame: &Frame3) -> DraftUse {
        let samples: Arc<[UvSample]> = self
            .samples
            .iter()
            .map(|&(t, point, d)| {
                let d = DVec2::new(d.dot(frame.x), d.dot(frame.y));
                UvSample { t, uv: frame.local(point).truncate(), d: if d.is_finite() { d } else { DVec2::ZERO } }
            })
            .collect();
        let ends = [samples[0].t, samples[samples.len() - 1].t];
        let [from, to] = if self.reversed { [ends[1], ends[0]] } else { ends };
        DraftUse { along: DraftAlong::Edge(self.edge), from, to, uv: UvCurve::Hermite(samples) }
    }
}

/// The plane in which loops enclose most area, oriented so that they run counter-clockwise, and that area. Loops that
/// enclose almost nothing lie along a line or cancel; they get the plane of the points that are furthest apart.
fn plane(polygons: &[Vec<DVec3>]) -> Option<(Frame3, f64)> {
    /// Share of the loops' squared size above which their area decides the plane.
    const FLAT: f64 = 0.02;
    let points = || polygons.iter().flatten();
    let count = points().count() as f64;
    let origin = points().map(|p| *p / count).sum::<DVec3>();
    let size = points().map(|p| (*p - origin).abs().max_element()).fold(0.0, f64::max);
    if !(origin.is_finite() && size.is_finite()) {
        return None;
    }
    if size == 0.0 {
        return Some((Frame3 { origin, ..Frame3::WORLD }, 0.0));
    }
    let unit = |p: DVec3| (p - origin) / size;
    let sides = |l: &Vec<DVec3>| (0..l.len()).map(|k| unit(l[k]).cross(unit(l[(k + 1) % l.len()]))).sum::<DVec3>();
    let enclosed = 0.5 * polygons.iter().map(sides).sum::<DVec3>();
    let furthest = |off: &dyn Fn(DVec3) -> DVec3| {
        points().map(|&p| off(unit(p))).max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
    };
    let along = furthest(&|p| p)?.normalize_or_zero();
    let z = if enclosed.length() > FLAT {
        enclosed.normalize()
    } else {
        let across = furthest(&|p| p - along * p.dot(along))?;
        let z = if across.length() > 1e-9 { along.cross(across) } else { along.any_orthogonal_vector() };
        if z.dot(enclosed) < 0.0 { -z } else { z }
    };
    let frame = Frame3::from_axis(origin, z, along)?;
    Some((frame, enclosed.dot(frame.z).abs() * size * size))
}
