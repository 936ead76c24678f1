//! Random nets and polygons -> a trimmed B-spline sheet, sound or broken.

use crate::draw::{List, below, log_range, range, repeat, round};
use crate::judge::Meshed;
use arbitrary::{Result, Unstructured};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;
use trimtess::model::{
    Coedge, CurveKind, Loop, Model, ModelError, NurbsCurve, NurbsSurface, PartBuilder, ShellKind, Surface, VertexId,
};

/// A face on a B-spline surface.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Sheet {
    pub(crate) net: Net,
    /// Corners as fractions of the domain, joined by straight lines in parameters; empty for the whole surface.
    pub(crate) loops: List<List<[f64; 2]>>,
    /// Cubic pieces per side of the curve in space; 0 is a straight segment from corner to corner.
    pub(crate) pieces: usize,
    pub(crate) reversed: bool,
    /// Whether it is stated soundly; its mesh must then be within the tolerance and without cracks.
    pub(crate) sound: bool,
    /// Chord tolerance as a fraction of the diagonal.
    pub(crate) chord_rel: f64,
}

/// Degrees, knots and points of a surface.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Net {
    pub(crate) degrees: [usize; 2],
    /// In u and v, with multiplicities written out.
    pub(crate) knots: [List<f64>; 2],
    /// u-major.
    pub(crate) points: List<[f64; 3]>,
    pub(crate) weights: List<f64>,
}

impl Sheet {
    pub(crate) fn draw(u: &mut Unstructured<'_>, wild: bool) -> Result<Self> {
        let net = Net::draw(u, wild)?;
        let broken = wild || below(u, 3)? == 0;
        let loops = match below(u, 4)? {
            0 => List::default(),
            _ if broken => broken_loops(u)?,
            _ => sound_loops(u)?,
        };
        let pieces = if wild { below(u, 5)? } else { 4 + below(u, 5)? };
        let chord_rel = *u.choose(&[1e-2, 1e-3, 3e-4])?;
        let sound = !wild && (!broken || loops.is_empty());
        Ok(Self { net, loops, pieces, reversed: u.arbitrary()?, sound, chord_rel })
    }

    pub(crate) fn judge(&self) -> std::result::Result<(), String> {
        let model = match self.model() {
            Ok(model) => model,
            Err(error) if self.sound => return Err(format!("refused: {error}")),
            // A clear refusal is a valid answer.
            Err(_) => return Ok(()),
        };
        let meshed = Meshed::new(model, self.chord_rel)?;
        if self.sound { meshed.is_sound(false) } else { meshed.is_whole() }
    }

    fn model(&self) -> std::result::Result<Model, ModelError> {
        let surface = self.net.surface();
        let mut part = PartBuilder::new("sheet");
        let shell = part.plain_shell(ShellKind::Open);
        // An invalid surface is refused when the part is finished; it must not be evaluated before.
        let usable = surface.check().is_ok();
        let loops = self.loops.iter().filter(|_| usable).map(|l| self.boundary(&mut part, &surface, l)).collect();
        part.plain_face(Surface::Nurbs(surface), shell, loops, self.reversed);
        let part = part.finish().map_err(|error| ModelError::Part { part: trimtess::model::PartId(0), error })?;
        Ok(part.into())
    }

    fn boundary(&self, part: &mut PartBuilder, surface: &NurbsSurface, corners: &[[f64; 2]]) -> Loop {
        let ((u0, u1), (v0, v1)) = surface.domain();
        let at = |[s, t]: [f64; 2]| DVec2::new(u0 + (u1 - u0) * s, v0 + (v1 - v0) * t);
        let uvs: Vec<DVec2> = corners.iter().map(|&corner| at(corner)).collect();
        let vertices: Vec<VertexId> = uvs.iter().map(|uv| part.vertex(surface.point(uv.x, uv.y))).collect();
        let side = |k: usize| -> Coedge {
            let next = (k + 1) % uvs.len();
            if self.pieces == 0 {
                return part.line(vertices[k], vertices[next]).along();
            }
            let curve = lifted(surface, uvs[k], uvs[next], self.pieces);
            part.curve(curve, CurveKind::Spline, vertices[k], vertices[next]).along()
        };
        Loop::Edges((0..uvs.len()).map(side).collect())
    }
}

/// The image of a segment of the parameter plane as cubics with the surface's tangents at their ends, equally many
/// between any two knot lines.
fn lifted(surface: &NurbsSurface, a: DVec2, b: DVec2, pieces: usize) -> NurbsCurve<DVec3> {
    let share = |knot: f64, from: f64, to: f64| (knot - from) / (to - from);
    let of_u = surface.knots_u.iter().map(|&k| share(k, a.x, b.x));
    let of_v = surface.knots_v.iter().map(|&k| share(k, a.y, b.y));
    let mut stops: Vec<f64> = of_u.chain(of_v).filter(|&t| t > 1e-6 && t < 1.0 - 1e-6).chain([0.0, 1.0]).collect();
    stops.sort_by(f64::total_cmp);
    stops.dedup_by(|x, y| *x - *y < 1e-6);
    let spans = stops.windows(2).flat_map(|w| {
        let stop = move |k: usize| w[0] + (w[1] - w[0]) * (k as f64 / pieces as f64);
        (0..pieces).map(move |k| (stop(k), if k + 1 == pieces { w[1] } else { stop(k + 1) }))
    });
    let spans: Vec<(f64, f64)> = spans.collect();
    let at = |t: f64| a + (b - a) * t;
    let point = |t: f64| surface.point(at(t).x, at(t).y);
    // A third of the tangent along a piece, on its own side of a crease.
    let tangent = |t: f64, (from, to): (f64, f64)| {
        let p = at(t + 1e-9 * (0.5 * (from + to) - t));
        let d = surface.derivatives(p.x, p.y);
        (d.du * (b - a).x + d.dv * (b - a).y) * ((to - from) / 3.0)
    };
    let mut points = vec![point(0.0)];
    let mut knots = vec![0.0; 4];
    for &span in &spans {
        let (from, to) = span;
        let end = point(to);
        points.extend([point(from) + tangent(from, span), end - tangent(to, span), end]);
        knots.extend([to; 3]);
    }
    knots.push(1.0);
    NurbsCurve { degree: 3, knots, points, weights: Vec::new() }
}

impl Net {
    pub(crate) fn surface(&self) -> NurbsSurface {
        NurbsSurface {
            degree_u: self.degrees[0],
            degree_v: self.degrees[1],
            knots_u: self.knots[0].to_vec(),
            knots_v: self.knots[1].to_vec(),
            points: self.points.iter().map(|&p| DVec3::from(p)).collect(),
            weights: self.weights.to_vec(),
        }
    }

    /// A graph over a perturbed grid; if `wild`, anything.
    fn draw(u: &mut Unstructured<'_>, wild: bool) -> Result<Self> {
        let degrees = [1 + below(u, 5)?, 1 + below(u, 5)?];
        let counts = [degrees[0] + 1 + below(u, 4)?, degrees[1] + 1 + below(u, 4)?];
        let knots = [knots(u, degrees[0], counts[0], wild)?, knots(u, degrees[1], counts[1], wild)?];
        let size = if below(u, 3)? == 0 { log_range(u, 1e-4, 1e6)? } else { 10.0 };
        let aspect = if below(u, 4)? == 0 { log_range(u, 1e-2, 1e2)? } else { 1.0 };
        let height = *u.choose(&[0.3, 0.0, 0.05, 1.0])?;
        let chaos = wild && u.arbitrary()?;
        let mut points = Vec::with_capacity(counts[0] * counts[1]);
        for i in 0..counts[0] {
            for j in 0..counts[1] {
                let shaken = DVec2::new(range(u, -0.2, 0.2)?, range(u, -0.2, 0.2)?);
                let grid = DVec2::new(i as f64, j as f64) + shaken;
                // Sound folds are at most about as sharp as a right angle.
                let steep = if wild { counts[0].max(counts[1]) as f64 } else { 1.0 };
                let z = range(u, -height, height)? * steep;
                let p = if chaos {
                    DVec3::new(range(u, -1.0, 1.0)?, range(u, -1.0, 1.0)?, range(u, -1.0, 1.0)?)
                } else {
                    grid.extend(z)
                };
                let flat = if wild { 1.0 } else { aspect.min(1.0) };
                let p = p * DVec3::new(size, size * aspect, size * flat);
                points.push(p.to_array().map(round));
            }
        }
        if wild {
            spoil(u, &mut points, counts)?;
        }
        let weights = match (u.arbitrary()?, wild) {
            (false, _) => List::default(),
            (true, false) => repeat(points.len(), || log_range(u, 0.5, 2.0))?,
            (true, true) => repeat(points.len(), || log_range(u, 1e-6, 1e6))?,
        };
        Ok(Self { degrees, knots, points: List(points), weights })
    }
}

/// Knots from 0 on, with multiplicities; clamped, or (if `wild`) perhaps not.
fn knots(u: &mut Unstructured<'_>, degree: usize, count: usize, wild: bool) -> Result<List<f64>> {
    let clamped = !wild || u.arbitrary()?;
    let steps = if wild { &[1.0, 0.0, 1e-9, 1e9, 0.3][..] } else { &[1.0, 0.0, 0.25, 3.0][..] };
    let mut all = vec![0.0; if clamped { degree + 1 } else { 1 }];
    let mut at = 0.0;
    while all.len() < count {
        at += *u.choose(steps)?;
        // A knot occurs at most `degree` times, the first `degree + 1` times.
        let equal = all.iter().filter(|&&k| k == at).count();
        let most = if at == 0.0 { degree + 1 } else { degree };
        if equal >= most {
            at += 1.0;
        }
        all.push(at);
    }
    at += 1.0;
    while all.len() < count + degree + 1 {
        all.push(at);
        if !clamped {
            at += 1.0;
        }
    }
    Ok(List(all))
}

/// Makes degenerate poles, coincident rows, folds.
fn spoil(u: &mut Unstructured<'_>, points: &mut [[f64; 3]], [nu, nv]: [usize; 2]) -> Result<()> {
    for _ in 0..below(u, 4)? {
        let (i, j) = (below(u, nu)?, below(u, nv)?);
        match below(u, 5)? {
            0 => (0..nv).for_each(|k| points[i * nv + k] = points[i * nv]),
            1 => (0..nu).for_each(|k| points[k * nv + j] = points[j]),
            2 => (0..nv).for_each(|k| points[i * nv + k] = points[(nu - 1 - i) * nv + k]),
            3 => points[i * nv + j] = points[(i + 1) % nu * nv + (j + 1) % nv],
            _ => points[i * nv + j] = points[i * nv + j].map(|x| 1e3 * x),
        }
    }
    Ok(())
}

/// A star-shaped polygon around a point, counter-clockwise.
fn star(u: &mut Unstructured<'_>, centre: DVec2, radius: f64) -> Result<Vec<DVec2>> {
    let count = 3 + below(u, 8)?;
    (0..count)
        .map(|k| Ok(centre + DVec2::from_angle(TAU * k as f64 / count as f64) * radius * range(u, 0.35, 1.0)?))
        .collect()
}

fn list_of(points: Vec<DVec2>) -> List<[f64; 2]> {
    points.into_iter().map(|p| p.to_array().map(round)).collect()
}

/// An outer loop and holes in it, well apart.
fn sound_loops(u: &mut Unstructured<'_>) -> Result<List<List<[f64; 2]>>> {
    let mut loops = Vec::new();
    let rectangle = u.arbitrary()?;
    if rectangle {
        let (a, b) = (range(u, 0.02, 0.2)?, range(u, 0.8, 0.98)?);
        let (c, d) = (range(u, 0.02, 0.2)?, range(u, 0.8, 0.98)?);
        loops.push(list_of(vec![DVec2::new(a, c), DVec2::new(b, c), DVec2::new(b, d), DVec2::new(a, d)]));
    } else {
        loops.push(list_of(star(u, DVec2::splat(0.5), 0.48)?));
    }
    if rectangle {
        // Each hole stays in its cell of a 3 × 3 grid between 0.2 and 0.8.
        for cell in 0..9_u32 {
            if u.ratio(1, 4)? {
                let centre = DVec2::new(0.3 + 0.2 * f64::from(cell % 3), 0.3 + 0.2 * f64::from(cell / 3));
                let mut hole = star(u, centre, 0.08)?;
                hole.reverse();
                loops.push(list_of(hole));
            }
        }
    }
    Ok(List(loops))
}

/// Loops that cross, touch or repeat themselves, have spikes or zero-length sides, or leave the domain.
fn broken_loops(u: &mut Unstructured<'_>) -> Result<List<List<[f64; 2]>>> {
    let mut loops: Vec<Vec<DVec2>> = Vec::new();
    for _ in 0..1 + below(u, 4)? {
        let centre = DVec2::new(range(u, -0.1, 1.1)?, range(u, -0.1, 1.1)?);
        let radius = range(u, 0.0, 0.7)?;
        let mut points = star(u, centre, radius)?;
        for _ in 0..below(u, 4)? {
            let (k, l) = (below(u, points.len())?, below(u, points.len())?);
            match below(u, 6)? {
                // A zero-length side.
                0 => points.insert(k, points[k]),
                // A spike.
                1 => {
                    let tip = points[k] + DVec2::new(range(u, -0.3, 0.3)?, range(u, -0.3, 0.3)?);
                    points.splice(k..k, [points[k], tip]);
                }
                // A self-intersection.
                2 => points.swap(k, l),
                // A self-contact.
                3 => points[k] = points[l],
                // On the border of the domain, or beyond it.
                4 => points[k] = points[k].round(),
                _ => points.reverse(),
            }
        }
        loops.push(points);
        if u.ratio(1, 5)? {
            let again = loops[below(u, loops.len())?].clone();
            loops.push(again);
        }
    }
    Ok(List(loops.into_iter().map(list_of).collect()))
}
