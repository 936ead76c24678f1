//! Faces with free trims -> faces bounded by edges: each arc of the region becomes an edge in space, with its pcurve in
//! the edge's parameter.
//!
//! No later stage knows how a face was trimmed. Arcs that meet share a vertex. Sides of the domain that are one line of
//! the surface share their edges; sides that are a pole have none. An edge in space follows the trimming curve on the
//! surface by cubic Hermite pieces, halved until they are within [`FIT`]. (The exact composition has degree p(m + n),
//! 18 for cubics on bicubics: too costly.)

use super::chains::StretchPart;
use super::free_region::{BORDER, FreeArc, FreeRegion, TrimNote};
use super::spans::{Span, UvDomain};
use crate::control::Call;
use crate::model::{
    CurveKind, Edge, EdgeId, Face, FaceError, FaceTrouble, FreeTrims, NurbsCurve3, Part, Pole, Surface, VertexId,
    knots_of_pieces,
};
use crate::prepare::report::{Finding, guarded};
use crate::prepare::uv::uv_curve::{SampledCurve, UvSample};
use crate::prepare::uv::uv_loop::{Along, Piece, Region, UvLoop, loops_box};
use glam::{DVec2, DVec3};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Accuracy of cubic pieces, as a share of the domain in (u,v) and of the part's size in space.
const FIT: f64 = 1e-8;

/// Halvings of one arc, for at most 4096 pieces. Curves that need more have unbounded derivatives.
const MAX_DEPTH: u32 = 12;

/// A face's region, with notes and repairs to report.
#[derive(Clone, Debug)]
pub(crate) struct FreeFace {
    pub(crate) region: Region,
    /// Largest distance of its edges from the surface. Shared edges may be curves of another face.
    pub(crate) gap: f64,
    pub(crate) notes: Vec<FaceTrouble>,
    pub(crate) repairs: Vec<Finding>,
}

/// The region or error of each face; `None` for a face without free trims.
pub(crate) type FreeFaces = Vec<Option<Result<FreeFace, FaceError>>>;

/// What was made of a face's free trims; `None` without free trims, or if it failed.
pub(crate) fn free_face(free: &FreeFaces, face: usize) -> Option<&FreeFace> {
    free.get(face)?.as_ref()?.as_ref().ok()
}

/// Adds vertices and edges for the free trims of a part's faces. `size` is the size of the part.
pub(crate) fn free_faces<'a>(call: Call<'_>, part: &'a Part, size: f64) -> (Cow<'a, Part>, FreeFaces) {
    let untrimmed = FreeTrims::default();
    let trims_of = |face: &'a Face| {
        let trims = face.trims.as_ref().or_else(|| is_bordered(face).then_some(&untrimmed));
        trims.filter(|_| !face.lost)
    };
    if part.faces.iter().all(|f| trims_of(f).is_none()) {
        return (Cow::Borrowed(part), vec![None; part.faces.len()]);
    }
    let of_face = |face: &'a Face| {
        let trims = trims_of(face).filter(|_| !call.is_cancelled())?;
        Some(guarded(|| EdgeMaker::of(call, face, trims, size)))
    };
    let (made, mut whole) = call.both(|| call.each(1, &part.faces, of_face), || part.clone());
    let faces = made.into_iter().map(|made| {
        let mut made = match made? {
            Ok(made) => made,
            Err(e) => return Some(Err(e)),
        };
        let first = [whole.vertices.len(), whole.edges.len()];
        whole.vertices.append(&mut made.vertices);
        whole.edges.extend(made.edges.drain(..).map(|e| {
            let [start, end] = [e.start, e.end].map(|v| VertexId::new(first[0] + v.index()));
            Edge { start, end, ..e }
        }));
        for piece in made.loops.iter_mut().flat_map(|l| &mut l.pieces) {
            if let Along::Edge(e) = &mut piece.along {
                *e = EdgeId::new(first[1] + *e as usize).0;
            }
        }
        Some(Ok(made.into_face()))
    });
    let faces = faces.collect();
    (Cow::Owned(whole), faces)
}

/// Whether a face is a whole surface with a border. Never for unsound and unbounded surfaces.
fn is_bordered(face: &Face) -> bool {
    let surface = &face.surface;
    if face.lost || !face.loops.is_empty() || face.trims.is_some() || surface.check().is_err() {
        return false;
    }
    let is_bounded = |&(a, b): &(f64, f64)| a.is_finite() && b.is_finite() && a < b;
    surface.natural_domain().iter().all(is_bounded) && surface.has_border()
}

/// The rectangle of a surface's parameters in which it is trimmed, and its open sides as (axis, is upper): where the
/// surface is unbounded, the rectangle ends somewhat beyond the curves.
fn domain(surface: &Surface, trims: &FreeTrims) -> Result<(UvDomain, Vec<(usize, bool)>), FaceError> {
    /// Margin beyond the curves, as a share of their extent.
    const BEYOND: f64 = 0.125;
    let [(u0, u1), (v0, v1)] = surface.natural_domain();
    let (mut low, mut high) = (DVec2::new(u0, v0), DVec2::new(u1, v1));
    let [first, last] = trims.bounds();
    let mut open_sides = Vec::new();
    for axis in 0..2 {
        let beyond = BEYOND * (last[axis] - first[axis]);
        if low[axis] == f64::NEG_INFINITY {
            low[axis] = first[axis] - beyond;
            open_sides.push((axis, false));
        }
        if high[axis] == f64::INFINITY {
            high[axis] = last[axis] + beyond;
            open_sides.push((axis, true));
        }
    }
    if !(low.is_finite() && high.is_finite() && low.cmplt(high).all()) {
        return Err(FaceError::NoDomain { low, high });
    }
    Ok((UvDomain { low, high, periodic: surface.period().map(|p| p.is_some()) }, open_sides))
}

/// Makes the edges and vertices of one face, numbered from 0.
struct EdgeMaker<'a> {
    surface: &'a Surface,
    domain: UvDomain,
    poles: Vec<Pole>,
    /// Knots in u and v. Curves on the surface are smooth between them.
    knots: [Vec<f64>; 2],
    tolerance: f64,
    told: Vec<TrimNote>,
    vertices: Vec<DVec3>,
    edges: Vec<Edge>,
    loops: Vec<UvLoop>,
    /// By place in the unit square; of two sides that are one line, the lower one.
    known_vertices: BTreeMap<[u64; 2], VertexId>,
    /// By constant axis, its value, and both ends.
    known_borders: BTreeMap<(usize, [u64; 3]), u32>,
}

impl<'a> EdgeMaker<'a> {
    fn of(call: Call<'_>, face: &'a Face, trims: &FreeTrims, size: f64) -> Result<Self, FaceError> {
        let surface = &face.surface;
        surface.check().map_err(FaceError::Surface)?;
        for (curve, stated) in trims.curves.iter().enumerate() {
            stated.check().map_err(|error| FaceError::Trim { curve, error })?;
        }
        let (domain, open_sides) = domain(surface, trims)?;
        let mut region = FreeRegion::of(call, trims, &domain)
            .map_err(|e| FaceError::TrimsTangled { at: e.at, place: surface.point(e.at.x, e.at.y) })?;
        if region.is_empty() {
            return Err(FaceError::NothingKept);
        }
        if let Some(&(axis, _)) = open_sides.iter().find(|&&(axis, upper)| region.reaches(axis, upper)) {
            return Err(FaceError::Unbounded { axis });
        }
        let mut maker = Self {
            surface,
            domain,
            poles: surface.poles(),
            knots: surface.breaks(),
            tolerance: FIT * size,
            told: std::mem::take(&mut region.notes),
            vertices: Vec::new(),
            edges: Vec::new(),
            loops: Vec::new(),
            known_vertices: BTreeMap::new(),
            known_borders: BTreeMap::new(),
        };
        for arcs in &region.loops {
            let pieces: Vec<Piece> = arcs.iter().flat_map(|arc| maker.pieces(&region, arc)).collect();
            if !pieces.is_empty() {
                maker.loops.push(UvLoop { pieces, winding: [0, 0] });
            }
        }
        Ok(maker)
    }

    fn into_face(self) -> FreeFace {
        let bounds = loops_box(&self.loops);
        let region = Region { loops: self.loops, wraps: [false; 2], bounds, base: 0, unbounded: None };
        let (mut notes, mut repairs) = (Vec::new(), Vec::new());
        for note in self.told {
            if note.repaired {
                let place = Some(self.surface.point(note.at.x, note.at.y));
                repairs.push(Finding::new(place, FaceTrouble::Trim(note.what)));
            } else {
                notes.push(FaceTrouble::Trim(note.what));
            }
        }
        FreeFace { region, gap: 0.0, notes, repairs }
    }

    /// The pieces of an arc, in loop order.
    fn pieces(&mut self, region: &FreeRegion, arc: &FreeArc) -> Vec<Piece> {
        let runs = runs(region, arc);
        let count = runs.len();
        let joint = |k: usize| -> DVec2 {
            match arc.nodes {
                Some([a, _]) if k == 0 => region.nodes[a],
                Some([_, b]) if k == count => region.nodes[b],
                _ => {
                    let part = runs[k % count][0];
                    region.span(arc.chain, part.span).point(part.from)
                }
            }
        };
        let mut out: Vec<Piece> = runs
            .iter()
            .enumerate()
            .filter_map(|(k, parts)| {
                let ends = [joint(k), joint(k + 1)];
                if arc.chain == BORDER {
                    return self.border(ends, region.span(BORDER, parts[0].span), arc.reversed);
                }
                let stretches: Vec<(&Span, StretchPart)> =
                    parts.iter().map(|p| (region.span(arc.chain, p.span), *p)).collect();
                Some(self.free(ends, &stretches, arc.reversed))
            })
            .collect();
        if arc.reversed {
            out.reverse();
        }
        out
    }

    /// Makes an edge along a trimming curve.
    fn free(&mut self, ends: [DVec2; 2], stretches: &[(&Span, StretchPart)], reversed: bool) -> Piece {
        let size = self.domain.high - self.domain.low;
        let mut samples: Vec<UvSample> = Vec::new();
        let mut curve = Fit::default();
        for &(span, part) in stretches {
            let per = 1.0 / (span.range.1 - span.range.0);
            let sample = |s: f64| {
                let [_, d, _] = span.derivatives(s);
                UvSample { t: span.parameter(s), uv: span.point(s), d: d * per }
            };
            let place = |s: f64| (span.parameter(s), span.point(s));
            let [first, last] = [part.from, part.to].map(sample);
            if samples.is_empty() {
                samples.push(first);
            }
            let image = SampledCurve { sample, place, tolerance: FIT, max_depth: MAX_DEPTH };
            image.follow([part.from, part.to], [&first, &last], 0, &mut samples);
            let mut stops = vec![part.from, part.to];
            for axis in 0..2 {
                let (a, b) = (span.point(part.from)[axis], span.point(part.to)[axis]);
                let knots = self.knots[axis].iter().map(|&k| (k - self.domain.low[axis]) / size[axis]);
                stops.extend(knots.filter(|&x| x > a.min(b) && x < a.max(b)).map(|x| span.at(axis, x)));
            }
            stops.sort_by(f64::total_cmp);
            stops.dedup_by(|b, a| *b - *a <= 1e-9 * (part.to - part.from));
            if let Some(last) = stops.last_mut() {
                *last = part.to;
            }
            let place = |s: f64| self.domain.of_unit(span.point(s));
            let course = Course {
                point: &|s| {
                    let at = place(s);
                    self.surface.point(at.x, at.y)
                },
                slope: &|s, inside| {
                    let [_, d, _] = span.derivatives(s);
                    let near = place(inside);
                    let [_, du, dv] = self.surface.tangents(near.x, near.y);
                    let d = d * size * per;
                    du * d.x + dv * d.y
                },
                parameter: &|s| span.parameter(s),
                tolerance: self.tolerance,
                is_cubic: false,
            };
            curve.follow(&course, &stops);
        }
        let last = samples.len() - 1;
        samples[0].uv = ends[0];
        samples[last].uv = ends[1];
        for s in &mut samples {
            s.uv = self.domain.of_unit(s.uv);
            s.d *= size;
        }
        let [start, end] = ends.map(|p| self.vertex(p));
        let edge = self.edge(curve, [start, end]);
        Piece { along: Along::Edge(edge), reversed, samples }
    }

    /// Makes an edge along a side of the domain, or reuses it. Its parameter is the coordinate that varies. `None` if
    /// it has no extent in (u,v).
    fn border(&mut self, ends: [DVec2; 2], side: &Span, reversed: bool) -> Option<Piece> {
        let axis = usize::from(side.ends[0].x != side.ends[1].x);
        let run = 1 - axis;
        let rising = ends[1][run] > ends[0][run];
        let [low, high] = if rising { ends } else { [ends[1], ends[0]] };
        let [from, to] = [low, high].map(|p| self.domain.of_unit(p));
        if from[run] >= to[run] {
            return None;
        }
        let samples = [from, to].map(|uv| UvSample::along(run, uv)).to_vec();
        let reversed = rising == reversed;
        if let Some(pole) = self.pole(low).filter(|&k| self.poles[k].axis == axis) {
            return Some(Piece { along: Along::Pole(pole), reversed, samples });
        }
        let at = if self.domain.periodic[axis] { 0.0 } else { low[axis] };
        let key = (axis, [at, from[run], to[run]].map(f64::to_bits));
        if let Some(&edge) = self.known_borders.get(&key) {
            return Some(Piece { along: Along::Edge(edge), reversed, samples });
        }
        let mut fixed = low;
        fixed[axis] = at;
        let fixed = self.domain.of_unit(fixed);
        let mut stops = vec![from[run], to[run]];
        stops.extend(self.knots[run].iter().copied().filter(|&k| k > from[run] && k < to[run]));
        stops.sort_by(f64::total_cmp);
        let mut curve = Fit::default();
        let (parameter, tolerance) = (&|t: f64| t, self.tolerance);
        if let Surface::Nurbs(surface) = self.surface {
            let line = surface.iso_line(axis, fixed[axis]);
            let (point, slope) = (&|t: f64| line.point(t), &|t: f64, inside: f64| line.slope(t, inside));
            let is_cubic = line.is_cubic();
            curve.follow(&Course { point, slope, parameter, tolerance, is_cubic }, &stops);
        } else {
            let at = |t: f64| if run == 0 { DVec2::new(t, fixed.y) } else { DVec2::new(fixed.x, t) };
            let point = &|t: f64| self.surface.point(at(t).x, at(t).y);
            let slope = &|_: f64, inside: f64| self.surface.tangents(at(inside).x, at(inside).y)[1 + run];
            curve.follow(&Course { point, slope, parameter, tolerance, is_cubic: false }, &stops);
        }
        let vertices = [low, high].map(|p| self.vertex(p));
        let edge = self.edge(curve, vertices);
        self.known_borders.insert(key, edge);
        Some(Piece { along: Along::Edge(edge), reversed, samples })
    }

    fn edge(&mut self, mut curve: Fit, [start, end]: [VertexId; 2]) -> u32 {
        let range = (curve.ts[0], curve.ts[curve.ts.len() - 1]);
        let last = curve.points.len() - 1;
        curve.points[0] = self.vertices[start.index()];
        curve.points[last] = self.vertices[end.index()];
        let knots = knots_of_pieces(3, &curve.ts);
        let curve = NurbsCurve3 { degree: 3, knots, points: curve.points, weights: Vec::new() };
        self.edges.push(Edge { curve, range, start, end, kind: CurveKind::Spline, entity: 0 });
        EdgeId::new(self.edges.len() - 1).0
    }

    /// The pole on whose parameter line a point of the unit square lies.
    fn pole(&self, p: DVec2) -> Option<usize> {
        let uv = self.domain.of_unit(p);
        let size = self.domain.high - self.domain.low;
        self.poles.iter().position(|pole| (uv[pole.axis] - pole.at).abs() <= 1e-12 * size[pole.axis])
    }

    fn vertex(&mut self, mut p: DVec2) -> VertexId {
        let pole = self.pole(p);
        let key = match pole {
            Some(pole) => [u64::MAX, pole as u64],
            None => {
                let wraps = |axis: usize| self.domain.periodic[axis] && p[axis] == 1.0;
                let upper = [wraps(0), wraps(1)];
                (0..2).filter(|&axis| upper[axis]).for_each(|axis| p[axis] = 0.0);
                p.to_array().map(|x| (x + 0.0).to_bits())
            }
        };
        let (poles, surface, uv, vertices) = (&self.poles, self.surface, self.domain.of_unit(p), &mut self.vertices);
        *self.known_vertices.entry(key).or_insert_with(|| {
            vertices.push(pole.map_or_else(|| surface.point(uv.x, uv.y), |k| poles[k].point));
            VertexId::new(vertices.len() - 1)
        })
    }
}

/// Groups the parts of an arc into runs that are smooth and lie on one piece of the curve.
fn runs(region: &FreeRegion, arc: &FreeArc) -> Vec<Vec<StretchPart>> {
    /// The curve is smooth at a joint if its derivatives on both sides differ by at most this share.
    const SMOOTH: f64 = 1e-9;
    let mut out: Vec<Vec<StretchPart>> = Vec::new();
    for &part in &arc.parts {
        let span = region.span(arc.chain, part.span);
        let slope = |span: &Span, s: f64| span.derivatives(s)[1] / (span.range.1 - span.range.0);
        let goes_on = out.last().and_then(|run| run.last()).is_some_and(|before| {
            let other = region.span(arc.chain, before.span);
            let (d, e) = (slope(other, before.to), slope(span, part.from));
            other.piece == span.piece
                && other.parameter(before.to) == span.parameter(part.from)
                && d.distance(e) <= SMOOTH * d.length().max(e.length())
        });
        match out.last_mut() {
            Some(run) if goes_on => run.push(part),
            _ => out.push(vec![part]),
        }
    }
    out
}

/// A curve in space.
struct Course<'a> {
    point: &'a dyn Fn(f64) -> DVec3,
    /// `slope(s, inside)` is the derivative at `s` by the parameter, of the piece of the surface that has `inside`.
    slope: &'a dyn Fn(f64, f64) -> DVec3,
    /// The parameter of the cubics at `s`.
    parameter: &'a dyn Fn(f64) -> f64,
    /// Largest distance of the cubics.
    tolerance: f64,
    /// Whether it is a cubic between stops, with exact slopes: pieces between these are exact.
    is_cubic: bool,
}

/// A curve in space, as cubic Bézier pieces.
#[derive(Default)]
struct Fit {
    ts: Vec<f64>,
    points: Vec<DVec3>,
}

/// A place of a [`Course`].
#[derive(Clone, Copy)]
struct Place {
    at: f64,
    point: DVec3,
    slope: DVec3,
}

impl Fit {
    /// Appends pieces between `stops`, between which the course is smooth.
    fn follow(&mut self, course: &Course, stops: &[f64]) {
        /// Slopes at stops are those this share inside the stretch: on a knot they would be those of the next one.
        const INSIDE: f64 = 1e-8;
        let points: Vec<DVec3> = stops.iter().map(|&s| (course.point)(s)).collect();
        for (w, p) in stops.windows(2).zip(points.windows(2)) {
            let step = INSIDE * (w[1] - w[0]);
            let inside = [w[0] + step, w[1] - step];
            let ends = [0, 1].map(|k| Place { at: w[k], point: p[k], slope: (course.slope)(w[k], inside[k]) });
            // Unless the piece is so short that its slopes may be those of its neighbours.
            if course.is_cubic && inside[0] > w[0] && inside[1] < w[1] {
                self.push(&Cubic::of(course, ends));
            } else {
                self.follow_between(course, ends, 0);
            }
        }
    }

    /// Appends pieces between two places.
    fn follow_between(&mut self, course: &Course, ends: [Place; 2], depth: u32) {
        let cubic = Cubic::of(course, ends);
        let [from, to] = ends.map(|end| end.at);
        let at = 0.5 * (from + to);
        let point = (course.point)(at);
        let follows = |x: f64, point: DVec3| cubic.point(x).distance(point) <= course.tolerance;
        // The middle first: a cubic with these ends and slopes is farthest off there.
        let fits = || {
            follows(0.5, point) && [0.25, 0.75].into_iter().all(|x| follows(x, (course.point)(from + (to - from) * x)))
        };
        if depth == MAX_DEPTH || fits() {
            self.push(&cubic);
            return;
        }
        let middle = Place { at, point, slope: (course.slope)(at, at) };
        self.follow_between(course, [ends[0], middle], depth + 1);
        self.follow_between(course, [middle, ends[1]], depth + 1);
    }

    fn push(&mut self, cubic: &Cubic) {
        let Cubic { range: [a, b], points: [p, r, s, q] } = *cubic;
        if self.ts.is_empty() {
            self.ts.push(a);
            self.points.push(p);
        }
        self.ts.push(b);
        self.points.extend([r, s, q]);
    }
}

/// The cubic Bézier piece between two places that has their slopes.
struct Cubic {
    range: [f64; 2],
    points: [DVec3; 4],
}

impl Cubic {
    fn of(course: &Course, [p, q]: [Place; 2]) -> Self {
        let range = [p.at, q.at].map(course.parameter);
        let third = (range[1] - range[0]) / 3.0;
        Self { range, points: [p.point, p.point + p.slope * third, q.point - q.slope * third, q.point] }
    }

    fn point(&self, x: f64) -> DVec3 {
        let ([p, r, s, q], y) = (self.points, 1.0 - x);
        p * (y * y * y) + (r * (3.0 * y) + s * (3.0 * x)) * (x * y) + q * (x * x * x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn curves_are_followed_with_one_slope_per_halving() {
        const TOLERANCE: f64 = 1e-6;
        let slopes = Cell::new(0);
        let point = |t: f64| DVec3::new(t.cos(), t.sin(), t);
        let slope = |t: f64, _: f64| {
            slopes.set(slopes.get() + 1);
            DVec3::new(-t.sin(), t.cos(), 1.0)
        };
        let course = Course { point: &point, slope: &slope, parameter: &|t| t, tolerance: TOLERANCE, is_cubic: false };
        let stops = [0.0, 2.0, 3.0];
        let mut fit = Fit::default();
        fit.follow(&course, &stops);
        let pieces = fit.ts.len() - 1;
        assert!(pieces > 10, "{pieces}");
        assert_eq!(slopes.get(), 2 * (stops.len() - 1) + pieces - (stops.len() - 1));
        for (k, range) in fit.ts.windows(2).enumerate() {
            let cubic = Cubic { range: [range[0], range[1]], points: [0, 1, 2, 3].map(|i| fit.points[3 * k + i]) };
            for j in 0..=10 {
                let x = 0.1 * f64::from(j);
                let off = cubic.point(x).distance(point(range[0] + (range[1] - range[0]) * x));
                assert!(off <= 1.01 * TOLERANCE, "piece {k} at {x}: {off:e}");
            }
        }
    }
}
