//! Planar areas and faces, extruded or revolved -> exact boundary representations.
//!
//! A profile's vertices sweep edges, and its edges sweep faces. The profile and its far copy close the solid.

use super::contents::Source;
use super::kinds::{SWEEPS, profile};
use super::place::Geometry;
use super::revolution::ends_onto_axis;
use super::spline;
use super::table::{Entity, Read, Trouble, missing, out_of_range};
use crate::model::{
    Coedge, CurveKind, Edge, EdgeId, Face, Frame3, Loop, NurbsCurve3, Part, PartBuilder, ShellKind, SolidTrouble,
    Surface, VertexId,
};
use glam::{DAffine3, DQuat, DVec3};
use std::collections::HashMap;
use std::f64::consts::TAU;

/// Points within this share of the profile's reach lie on the axis.
const ON_AXIS: f64 = 1e-9;
/// The least angle of a revolution, radians.
const LEAST: f64 = 1e-9;
/// Angles within this of a full turn are one, radians. Units of degrees are printed with eight digits and more.
const WHOLE: f64 = 1e-6;

/// A sweep, as stated.
pub(super) struct Sweep {
    /// The swept area or face.
    pub(super) profile: Source,
    entity: u64,
    motion: Motion,
}

enum Motion {
    Along(DVec3),
    About { axis: Frame3, angle: f64 },
}

impl Sweep {
    pub(super) fn read(geometry: &Geometry<'_>, item: Entity<'_>) -> Read<Self> {
        let entity = item.id;
        let name = item.first_of(SWEEPS).unwrap_or_default();
        let profile = profile(item).ok_or_else(|| Trouble::new(entity, missing(format!("a {name}"), "profile")))?;
        let profile = if name.contains("AREA") { Source::Surface(profile) } else { Source::Face(profile) };
        let own = item.fields(name, 2);
        let motion = if name.starts_with("EXTRUDED") {
            let depth = geometry.length(own.real(1)?, entity)?;
            let direction = geometry.direction(own.reference(0)?)?.try_normalize();
            let along = direction.ok_or_else(|| Trouble::new(entity, missing("an extrusion", "direction")))? * depth;
            if along == DVec3::ZERO {
                return Err(Trouble::new(entity, missing("an extrusion", "depth")));
            }
            Motion::Along(along)
        } else {
            let axis = geometry.frame(own.reference(0)?)?;
            let angle = own.real(1)? * geometry.units.angle;
            // A negative angle is a positive one about the opposite axis.
            let axis = if angle < 0.0 { Frame3 { y: -axis.y, z: -axis.z, ..axis } } else { axis };
            let angle = angle.abs();
            if angle <= LEAST || angle > TAU + WHOLE {
                return Err(Trouble::new(entity, out_of_range("a revolution", angle, "radians")));
            }
            Motion::About { axis, angle: if TAU - angle <= WHOLE { TAU } else { angle } }
        };
        Ok(Self { profile, entity, motion })
    }

    /// Sweeps the only face of `profile` to a solid.
    pub(super) fn solid(&self, profile: &Part) -> Read<Part> {
        let fail = |what: SolidTrouble| Err(Trouble::new(self.entity, what));
        let Some(face) = profile.faces.first() else {
            return Err(Trouble::new(self.entity, missing("a profile", "faces")));
        };
        let Surface::Plane { frame } = face.surface else { return fail(SolidTrouble::ProfileNotPlane) };
        let part = match self.motion {
            Motion::Along(along) => {
                if along.dot(frame.z).abs() <= 1e-9 * along.length() {
                    return fail(SolidTrouble::AlongProfile);
                }
                extruded(profile, face, &frame, along)
            }
            Motion::About { axis, angle } => {
                let Some(side) = side(profile, &axis) else { return fail(SolidTrouble::ProfileOnAxis) };
                let across = frame.z.dot(side.cross(axis.z)).abs();
                if across < 1.0 - 1e-6 {
                    return fail(SolidTrouble::AxisOffPlane);
                }
                if profile.vertices.iter().any(|p| (*p - axis.origin).dot(side) < -1e-6 * reach(profile, &axis)) {
                    return fail(SolidTrouble::AcrossAxis);
                }
                revolved(profile, face, &frame, &axis, angle, side)
            }
        };
        part.finish().map_err(|error| Trouble::new(self.entity, error))
    }
}

/// The largest distance of a profile's curves from the axis.
fn reach(profile: &Part, axis: &Frame3) -> f64 {
    let points = profile.edges.iter().flat_map(|edge| &edge.curve.points);
    points.map(|p| axis.radial(*p).length()).fold(0.0, f64::max)
}

/// The unit direction from the axis to the profile; `None` if the profile lies on the axis.
fn side(profile: &Part, axis: &Frame3) -> Option<DVec3> {
    let points = profile.edges.iter().flat_map(|edge| &edge.curve.points).map(|p| axis.radial(*p));
    points.max_by(|p, q| p.length_squared().total_cmp(&q.length_squared()))?.try_normalize()
}

/// A profile and its moved copy, in the part under construction.
struct Copies {
    part: PartBuilder,
    near: Vec<EdgeId>,
    far: Vec<EdgeId>,
    near_vertices: Vec<VertexId>,
    far_vertices: Vec<VertexId>,
}

/// The edge's curve, cut to the edge's range.
fn trimmed(edge: &Edge) -> NurbsCurve3 {
    spline::piece(&edge.curve, edge.range.0, edge.range.1)
}

impl Copies {
    /// `stays`: whether the motion leaves a vertex, or an edge, in place.
    fn new(
        profile: &Part,
        motion: &DAffine3,
        whole: bool,
        stays: (impl Fn(usize) -> bool, impl Fn(usize) -> bool),
    ) -> Self {
        let mut part = PartBuilder::new(String::new());
        part.plain_shell(ShellKind::Outer);
        let near_vertices: Vec<VertexId> = profile.vertices.iter().map(|p| part.vertex(*p)).collect();
        let far_vertices: Vec<VertexId> = (0..profile.vertices.len())
            .map(|i| {
                let moved = motion.transform_point3(profile.vertices[i]);
                if stays.0(i) { near_vertices[i] } else { part.vertex(moved) }
            })
            .collect();
        let copy = |part: &mut PartBuilder, edge: &Edge, vertices: &[VertexId], moved: bool| {
            let mut curve = trimmed(edge);
            if moved {
                curve.points.iter_mut().for_each(|p| *p = motion.transform_point3(*p));
            }
            let range = curve.domain();
            let (start, end) = (vertices[edge.start.index()], vertices[edge.end.index()]);
            part.edge(Edge { curve, range, start, end, kind: edge.kind, entity: edge.entity })
        };
        // After a full turn the profile lies inside the solid.
        let kept = if whole { &[][..] } else { &profile.edges[..] };
        let near: Vec<EdgeId> = kept.iter().map(|edge| copy(&mut part, edge, &near_vertices, false)).collect();
        let far = kept.iter().enumerate();
        let far = far
            .map(|(i, edge)| if stays.1(i) { near[i] } else { copy(&mut part, edge, &far_vertices, true) })
            .collect();
        Self { part, near, far, near_vertices, far_vertices }
    }

    /// Adds the profile at one end of the sweep.
    fn cap(&mut self, face: &Face, frame: Frame3, far: bool, reversed: bool) {
        let edges = if far { &self.far } else { &self.near };
        let bound = |uses: &[Coedge]| {
            Loop::Edges(uses.iter().map(|use_| Coedge { edge: edges[use_.edge.index()], ..*use_ }).collect())
        };
        let loops = face.wires().map(bound).collect();
        self.part.plain_face(Surface::Plane { frame }, 0, loops, reversed);
    }
}

fn extruded(profile: &Part, face: &Face, frame: &Frame3, along: DVec3) -> PartBuilder {
    let motion = DAffine3::from_translation(along);
    let mut copies = Copies::new(profile, &motion, false, (|_| false, |_| false));
    let rising = along.dot(frame.z) > 0.0;
    copies.cap(face, *frame, false, rising);
    copies.cap(face, Frame3 { origin: frame.origin + along, ..*frame }, true, !rising);
    let mut risers: HashMap<usize, EdgeId> = HashMap::new();
    for coedge in face.wires().flatten() {
        let index = coedge.edge.index();
        let edge = &profile.edges[index];
        let mut riser = |vertex: VertexId| {
            let i = vertex.index();
            let (from, to) = (copies.near_vertices[i], copies.far_vertices[i]);
            *risers.entry(i).or_insert_with(|| copies.part.line(from, to))
        };
        let (first, last) = (riser(edge.start), riser(edge.end));
        let curve = trimmed(edge);
        // The normal of both surfaces is the edge's direction × the direction of the sweep.
        let surface = match (edge.kind, Frame3::from_axis(curve.points[0], ends(&curve).cross(along), ends(&curve))) {
            (CurveKind::Line, Some(frame)) => Surface::Plane { frame },
            _ => Surface::Extrusion { curve, direction: along },
        };
        let bound = vec![copies.near[index].along(), last.along(), copies.far[index].against(), first.against()];
        copies.part.plain_face(surface, 0, vec![Loop::Edges(bound)], coedge.reversed == rising);
    }
    copies.part
}

fn ends(curve: &NurbsCurve3) -> DVec3 {
    let (a, b) = curve.domain();
    curve.point(b) - curve.point(a)
}

fn revolved(profile: &Part, face: &Face, frame: &Frame3, axis: &Frame3, angle: f64, side: DVec3) -> PartBuilder {
    let (sine, cosine) = libm::sincos(0.5 * angle);
    let turn = DAffine3::from_quat(DQuat::from_vec4((sine * axis.z).extend(cosine)));
    let motion = DAffine3::from_translation(axis.origin) * turn * DAffine3::from_translation(-axis.origin);
    let none = ON_AXIS * reach(profile, axis);
    let on_axis = |p: DVec3| axis.radial(p).length() <= none;
    let fixed: Vec<bool> = profile.vertices.iter().map(|p| on_axis(*p)).collect();
    let still: Vec<bool> = profile.edges.iter().map(|edge| edge.curve.points.iter().all(|p| on_axis(*p))).collect();
    let whole = angle == TAU;
    let stays = (|i: usize| whole || fixed[i], |i: usize| still[i]);
    let mut copies = Copies::new(profile, &motion, whole, stays);
    // Whether the profile moves along its normal. The normal of swept surfaces is the motion × the edge's direction.
    let ahead = frame.z.dot(axis.z.cross(side)) > 0.0;
    if !whole {
        let turned = |v: DVec3| motion.transform_vector3(v);
        let far = Frame3 {
            origin: motion.transform_point3(frame.origin),
            x: turned(frame.x),
            y: turned(frame.y),
            z: turned(frame.z),
        };
        copies.cap(face, *frame, false, ahead);
        copies.cap(face, far, true, !ahead);
    }
    let mut rings: HashMap<usize, EdgeId> = HashMap::new();
    for coedge in face.wires().flatten() {
        let index = coedge.edge.index();
        if still[index] {
            continue;
        }
        let edge = &profile.edges[index];
        let mut ring = |vertex: VertexId| {
            let i = vertex.index();
            (!fixed[i]).then(|| {
                *rings.entry(i).or_insert_with(|| {
                    let p = profile.vertices[i];
                    let out = axis.radial(p);
                    let radius = out.length();
                    let x = out / radius;
                    let about = Frame3 { origin: p - out, x, y: axis.z.cross(x), z: axis.z };
                    let arc = NurbsCurve3::arc(&about, radius, radius, 0.0, angle);
                    copies.part.curve(arc, CurveKind::Circle, copies.near_vertices[i], copies.far_vertices[i])
                })
            })
        };
        let closed = edge.start == edge.end;
        let (first, last) = if whole && closed { (None, None) } else { (ring(edge.start), ring(edge.end)) };
        let (first, last) = (first.map(EdgeId::along), last.map(EdgeId::against));
        let loops: Vec<Vec<Coedge>> = if !whole {
            let far = Some(copies.far[index].along());
            vec![first.into_iter().chain(far).chain(last).chain([copies.near[index].against()]).collect()]
        } else {
            first.into_iter().chain(last).map(|ring| vec![ring]).collect()
        };
        let mut loops: Vec<Loop> = loops.into_iter().map(Loop::Edges).collect();
        if whole && !closed {
            // An end on the axis is a pole. A face between two poles is a whole surface, without loops.
            let poles = [edge.start, edge.end].into_iter().filter(|v| fixed[v.index()]);
            let poles: Vec<Loop> = poles.map(|v| Loop::Vertex(copies.near_vertices[v.index()])).collect();
            if poles.len() == 1 {
                loops.extend(poles);
            }
        }
        let mut curve = trimmed(edge);
        ends_onto_axis(&mut curve, axis, none);
        let surface = Surface::Revolution { curve, frame: *axis };
        copies.part.plain_face(surface, 0, loops, coedge.reversed != ahead);
    }
    copies.part
}
