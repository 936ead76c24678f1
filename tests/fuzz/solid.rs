//! A few numbers -> a solid of any size at any place, whose volume has a closed form.

use crate::draw::{List, below, log_range, range, repeat};
use crate::judge::Meshed;
use arbitrary::{Result, Unstructured};
use glam::{DAffine3, DQuat, DVec2, DVec3, EulerRot};
use std::f64::consts::{PI, TAU};
use trimtess::model::{
    Coedge, EdgeId, Frame3, Loop, Model, ModelBuilder, Part, PartBuilder, ShellKind, Surface, VertexId,
};

/// A solid and its placement.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Solid {
    pub(crate) shape: Shape,
    /// Angles about z, y, x of the solid within its part, radians.
    pub(crate) turn: [f64; 3],
    /// Position of the solid within its part.
    pub(crate) at: [f64; 3],
    /// Angles and uniform scale of the part's instance.
    pub(crate) placed: ([f64; 3], f64),
    /// Whether curved sides are B-splines instead of analytic surfaces.
    pub(crate) nurbs: bool,
    /// Whether faces are stated inside out.
    pub(crate) inverted: bool,
    /// Chord tolerance as a fraction of the diagonal.
    pub(crate) chord_rel: f64,
}

/// Sizes are millimetres.
#[derive(Clone, PartialEq, Debug)]
pub(crate) enum Shape {
    /// Over a star-shaped polygon, by its radii at even angles.
    Prism {
        radii: List<f64>,
        height: f64,
    },
    /// With a seam edge or two loops.
    Cylinder {
        radius: f64,
        height: f64,
        seam: bool,
    },
    /// With a hole.
    Washer {
        inner: f64,
        outer: f64,
        height: f64,
    },
    /// By its radii below and above; 0 above is an apex.
    Cone {
        low: f64,
        high: f64,
        height: f64,
    },
    /// Whole, or the part above a height given as a fraction of the radius.
    Sphere {
        radius: f64,
        above: Option<f64>,
    },
    Torus {
        major: f64,
        minor: f64,
    },
}

impl Solid {
    pub(crate) fn draw(u: &mut Unstructured<'_>) -> Result<Self> {
        let shape = Shape::draw(u)?;
        let angles = |u: &mut Unstructured<'_>| -> Result<[f64; 3]> {
            let any = u.arbitrary::<bool>()?;
            let limit = if any { PI } else { 0.0 };
            Ok([range(u, -limit, limit)?, range(u, -limit, limit)?, range(u, -limit, limit)?])
        };
        let turn = angles(u)?;
        let far = if below(u, 3)? == 0 { 1e4 } else { 10.0 } * shape.size();
        let at = [range(u, -far, far)?, range(u, -far, far)?, range(u, -far, far)?];
        let placed = (angles(u)?, if u.arbitrary()? { log_range(u, 1e-3, 1e3)? } else { 1.0 });
        let chord_rel = *u.choose(&[1e-2, 1e-3, 1e-1, 3e-4])?;
        let inverted = u.arbitrary()? && shape.is_thick();
        Ok(Self { shape, turn, at, placed, nurbs: u.arbitrary()?, inverted, chord_rel })
    }

    pub(crate) fn judge(&self) -> std::result::Result<(), String> {
        let meshed = Meshed::new(self.model().map_err(|error| format!("not buildable: {error}"))?, self.chord_rel)?;
        meshed.is_sound(self.inverted)?;
        let scale = self.placed.1;
        let exact = self.shape.volume() * scale.powi(3);
        let total = &meshed.facts.total;
        // Far from its origin a solid is rounded to fewer digits.
        let rounding = 1e-14 * scale * DVec3::from(self.at).length();
        let slack = (1.05 * meshed.chord + rounding) * total.area + 1e-9 * exact;
        if meshed.short || (total.volume - exact).abs() <= slack {
            Ok(())
        } else {
            Err(format!("volume {} instead of {exact}, allowed {slack:.3e}: {total}", total.volume))
        }
    }

    fn model(&self) -> std::result::Result<Model, Box<dyn std::error::Error>> {
        let [z, y, x] = self.turn;
        let frame = |height: f64| {
            let turn = DQuat::from_euler(EulerRot::ZYX, z, y, x);
            let at = |local: DVec3| DVec3::from(self.at) + turn * local;
            Frame3 { origin: at(DVec3::Z * height), x: turn * DVec3::X, y: turn * DVec3::Y, z: turn * DVec3::Z }
        };
        let mut part = PartBuilder::new("solid");
        part.plain_shell(ShellKind::Outer);
        self.shape.build(&mut part, &frame, self.nurbs);
        let mut part: Part = part.finish()?;
        if self.inverted {
            // Loops are stated relative to the surface's normal, so they stay as they are.
            part.faces.iter_mut().for_each(|face| face.reversed = !face.reversed);
        }
        let mut model = ModelBuilder::new("solid");
        let id = model.part(part);
        let ([z, y, x], scale) = self.placed;
        let turn = DQuat::from_euler(EulerRot::ZYX, z, y, x);
        let transform = DAffine3::from_scale_rotation_translation(DVec3::splat(scale), turn, DVec3::ZERO);
        model.place(id, transform);
        Ok(model.finish()?)
    }
}

impl Shape {
    fn draw(u: &mut Unstructured<'_>) -> Result<Self> {
        let size = if below(u, 3)? == 0 { log_range(u, 1e-4, 1e5)? } else { 10.0 };
        let length = |u: &mut Unstructured<'_>| -> Result<f64> { Ok(size * log_range(u, 0.05, 20.0)?) };
        Ok(match below(u, 6)? {
            0 => {
                let count = 3 + below(u, 9)?;
                let height = length(u)?;
                Self::Prism { radii: repeat(count, || Ok(size * range(u, 0.2, 1.0)?))?, height }
            }
            1 => Self::Cylinder { radius: length(u)?, height: length(u)?, seam: u.arbitrary()? },
            2 => {
                let outer = length(u)?;
                Self::Washer { inner: outer * range(u, 0.02, 0.98)?, outer, height: length(u)? }
            }
            3 => {
                let low = length(u)?;
                let high = if u.arbitrary()? { 0.0 } else { low * range(u, 0.05, 0.95)? };
                Self::Cone { low, high, height: length(u)? }
            }
            4 => Self::Sphere {
                radius: length(u)?,
                above: if u.arbitrary()? { Some(range(u, -0.95, 0.95)?) } else { None },
            },
            _ => {
                let major = length(u)?;
                Self::Torus { major, minor: major * range(u, 0.02, 0.95)? }
            }
        })
    }

    /// A typical length.
    fn size(&self) -> f64 {
        match self {
            Self::Prism { radii, height } => radii.iter().fold(*height, |m, r| m.max(*r)),
            Self::Cylinder { radius, height, .. } => radius.max(*height),
            Self::Washer { outer, height, .. } => outer.max(*height),
            Self::Cone { low, height, .. } => low.max(*height),
            Self::Sphere { radius, .. } => *radius,
            Self::Torus { major, minor } => major + minor,
        }
    }

    /// Whether the sign of its volume is beyond doubt: a thin wall keeps its stated orientation.
    fn is_thick(&self) -> bool {
        match self {
            Self::Washer { inner, outer, .. } => *inner < 0.4 * outer,
            Self::Torus { major, minor } => *minor > 0.6 * major,
            _ => true,
        }
    }

    fn volume(&self) -> f64 {
        match self {
            Self::Prism { radii, height } => {
                let corners = star(radii);
                let next = corners.iter().cycle().skip(1);
                0.5 * corners.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>() * height
            }
            Self::Cylinder { radius, height, .. } => PI * radius * radius * height,
            Self::Washer { inner, outer, height } => PI * (outer * outer - inner * inner) * height,
            Self::Cone { low, high, height } => PI * height / 3.0 * (low * low + low * high + high * high),
            Self::Sphere { radius, above } => {
                let cap = radius * (1.0 - above.unwrap_or(-1.0));
                PI * cap * cap * (radius - cap / 3.0)
            }
            Self::Torus { major, minor } => TAU * major * PI * minor * minor,
        }
    }

    /// Adds its faces; `frame` gives the axes at a height.
    fn build(&self, part: &mut PartBuilder, frame: &dyn Fn(f64) -> Frame3, nurbs: bool) {
        let free = |surface: Surface, v: (f64, f64)| {
            if nurbs { Surface::Nurbs(surface.to_nurbs((0.0, TAU), v).0) } else { surface }
        };
        let base = frame(0.0);
        let face = |part: &mut PartBuilder, surface: Surface, loops: Vec<Vec<Coedge>>, reversed: bool| {
            part.plain_face(surface, 0, loops.into_iter().map(Loop::Edges).collect(), reversed);
        };
        match self {
            Self::Prism { radii, height } => prism(part, &base, &star(radii), *height),
            Self::Cylinder { radius, height, seam } => {
                let (low, high) = (part.circle(&base, *radius), part.circle(&frame(*height), *radius));
                let side = if *seam {
                    let seam = part.line(start(part, low), start(part, high));
                    vec![vec![low.along(), seam.along(), high.against(), seam.against()]]
                } else {
                    vec![vec![low.along()], vec![high.against()]]
                };
                face(part, free(Surface::Cylinder { frame: base, radius: *radius }, (0.0, *height)), side, false);
                face(part, Surface::Plane { frame: base }, vec![vec![low.along()]], true);
                face(part, Surface::Plane { frame: frame(*height) }, vec![vec![high.along()]], false);
            }
            Self::Washer { inner, outer, height } => {
                let rings = |part: &mut PartBuilder, r: f64| (part.circle(&base, r), part.circle(&frame(*height), r));
                let sides = |(low, high): (EdgeId, EdgeId)| vec![vec![low.along()], vec![high.against()]];
                let (inside, outside) = (rings(part, *inner), rings(part, *outer));
                let side = |radius: f64| free(Surface::Cylinder { frame: base, radius }, (0.0, *height));
                face(part, side(*outer), sides(outside), false);
                face(part, side(*inner), sides(inside), true);
                let low = vec![vec![outside.0.along()], vec![inside.0.against()]];
                face(part, Surface::Plane { frame: base }, low, true);
                let high = vec![vec![outside.1.along()], vec![inside.1.against()]];
                face(part, Surface::Plane { frame: frame(*height) }, high, false);
            }
            Self::Cone { low, high, height } => {
                let half_angle = ((high - low) / height).atan();
                let side = free(Surface::Cone { frame: base, radius: *low, half_angle }, (0.0, *height));
                let foot = part.circle(&base, *low);
                face(part, Surface::Plane { frame: base }, vec![vec![foot.along()]], true);
                let top = if *high == 0.0 {
                    Loop::Vertex(part.vertex(frame(*height).origin))
                } else {
                    let rim = part.circle(&frame(*height), *high);
                    face(part, Surface::Plane { frame: frame(*height) }, vec![vec![rim.along()]], false);
                    Loop::Edges(vec![rim.against()])
                };
                part.plain_face(side, 0, vec![Loop::Edges(vec![foot.along()]), top], false);
            }
            Self::Sphere { radius, above } => {
                let half = PI / 2.0;
                let whole = free(Surface::Sphere { frame: base, radius: *radius }, (-half, half));
                let Some(above) = above else {
                    face(part, whole, Vec::new(), false);
                    return;
                };
                let cut = frame(above * radius);
                let rim = part.circle(&cut, radius * (1.0 - above * above).sqrt());
                face(part, whole, vec![vec![rim.along()]], false);
                face(part, Surface::Plane { frame: cut }, vec![vec![rim.along()]], true);
            }
            Self::Torus { major, minor } => {
                let whole = Surface::Torus { frame: base, major: *major, minor: *minor };
                face(part, free(whole, (0.0, TAU)), Vec::new(), false);
            }
        }
    }
}

fn start(part: &PartBuilder, edge: EdgeId) -> VertexId {
    part.part().edges[edge.index()].start
}

/// Corners at these distances from the origin, at even angles.
fn star(radii: &[f64]) -> Vec<DVec2> {
    let step = TAU / radii.len() as f64;
    radii.iter().enumerate().map(|(k, r)| DVec2::from_angle(step * k as f64) * r).collect()
}

fn prism(part: &mut PartBuilder, base: &Frame3, corners: &[DVec2], height: f64) {
    let n = corners.len();
    let mut ring = |z: f64| -> Vec<VertexId> { corners.iter().map(|c| part.vertex(base.place(c.extend(z)))).collect() };
    let (low, high) = (ring(0.0), ring(height));
    let mut around =
        |ring: &[VertexId]| -> Vec<EdgeId> { (0..n).map(|k| part.line(ring[k], ring[(k + 1) % n])).collect() };
    let (bottom, top) = (around(&low), around(&high));
    let posts: Vec<EdgeId> = (0..n).map(|k| part.line(low[k], high[k])).collect();
    let along = |edges: &[EdgeId]| edges.iter().map(|edge| edge.along()).collect::<Vec<_>>();
    let lid = Frame3 { origin: base.place(DVec3::Z * height), ..*base };
    part.plain_face(Surface::Plane { frame: *base }, 0, vec![Loop::Edges(along(&bottom))], true);
    part.plain_face(Surface::Plane { frame: lid }, 0, vec![Loop::Edges(along(&top))], false);
    for k in 0..n {
        let side = corners[(k + 1) % n] - corners[k];
        let across = base.x * side.x + base.y * side.y;
        let out = across.cross(base.z);
        let Some(frame) = Frame3::from_axis(base.place(corners[k].extend(0.0)), out, across) else { continue };
        let coedges = vec![bottom[k].along(), posts[(k + 1) % n].along(), top[k].against(), posts[k].against()];
        part.plain_face(Surface::Plane { frame }, 0, vec![Loop::Edges(coedges)], false);
    }
}
