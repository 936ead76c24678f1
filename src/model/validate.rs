//! Curves, surfaces, parts and models -> nothing, or the first reason why they are rejected.
//!
//! Evaluation and preparation rely on these conditions and do not check them again.

use super::nurbs_surface::extent;
use super::{
    Coedge, ControlPoint, EdgeId, Face, FaceId, Frame3, InstanceId, Loop, MAX_DEGREE, Model, ModelError, NurbsCurve,
    NurbsSurface, Part, PartError, PartId, SplineError, Surface, SurfaceError, VertexId, bad_colour,
};
use glam::{DAffine3, DMat3};
use std::f64::consts::FRAC_PI_2;
use std::ops::RangeInclusive;

/// Largest error of orthonormality of frames and placements: files print directions with as few as six digits.
const NOT_ORTHONORMAL: f64 = 1e-4;

/// Shortest domain, as a share of its parameters. Points on a shorter one would be off by a millionth of the spline.
const COARSE: f64 = 1e-10;

/// The range of weights. Bounds of derivatives have sixth powers of weights, which must not leave the range of `f64`.
const WEIGHTS: RangeInclusive<f64> = 1e-30..=1e30;

/// Largest gap between an edge's end and its vertex, as a share of the part's size.
const EDGE_GAP: f64 = 1e-4;

impl<P: ControlPoint> NurbsCurve<P> {
    /// Checks degree, knots, points and weights.
    ///
    /// # Errors
    /// The first condition of [`NurbsCurve`] that does not hold.
    pub fn check(&self) -> Result<(), SplineError> {
        knots(self.degree, &self.knots, self.points.len())?;
        net(&self.points, &self.weights)
    }
}

impl NurbsSurface {
    /// Checks degrees, knots, points and weights.
    ///
    /// # Errors
    /// The first condition of [`NurbsSurface`] that does not hold.
    pub fn check(&self) -> Result<(), SurfaceError> {
        let along = |direction: char| move |error| SurfaceError::Spline { direction, error };
        let (count_u, count_v) = (self.count_u(), self.count_v());
        knots(self.degree_u, &self.knots_u, count_u).map_err(along('u'))?;
        knots(self.degree_v, &self.knots_v, count_v).map_err(along('v'))?;
        if count_u.checked_mul(count_v) != Some(self.points.len()) {
            let points = self.points.len() / count_v;
            let error = SplineError::Count { degree: self.degree_u, knots: self.knots_u.len(), points };
            return Err(along('u')(error));
        }
        net(&self.points, &self.weights).map_err(along('u'))
    }
}

/// Checks degree, number of points and knots in one direction.
fn knots(degree: usize, knots: &[f64], points: usize) -> Result<(), SplineError> {
    if !(1..=MAX_DEGREE).contains(&degree) {
        return Err(SplineError::Degree { degree });
    }
    if points <= degree || knots.len() != points + degree + 1 {
        return Err(SplineError::Count { degree, knots: knots.len(), points });
    }
    if let Some(index) = knots.iter().position(|k| !k.is_finite()) {
        return Err(SplineError::Knot { index, knot: knots[index] });
    }
    if let Some(index) = (1..knots.len()).find(|&i| knots[i] < knots[i - 1]) {
        return Err(SplineError::Decreasing { index, before: knots[index - 1], knot: knots[index] });
    }
    let (a, b) = super::knots::domain(degree, knots);
    if a >= b {
        return Err(SplineError::Empty { at: a });
    }
    if b - a < COARSE * a.abs().max(b.abs()) {
        return Err(SplineError::Coarse { domain: (a, b) });
    }
    for run in knots.chunk_by(|a, b| a == b) {
        let most = if run[0] > a && run[0] < b { degree } else { degree + 1 };
        if run.len() > most {
            return Err(SplineError::Multiplicity { knot: run[0], multiplicity: run.len(), most });
        }
    }
    Ok(())
}

/// Checks points and weights.
fn net<P: ControlPoint>(points: &[P], weights: &[f64]) -> Result<(), SplineError> {
    if !weights.is_empty() && weights.len() != points.len() {
        return Err(SplineError::Weights { weights: weights.len(), points: points.len() });
    }
    if let Some(index) = points.iter().position(|p| !p.finite()) {
        return Err(SplineError::Point { index });
    }
    check_weights(weights)
}

/// Checks that the weights are in range.
pub(crate) fn check_weights(weights: &[f64]) -> Result<(), SplineError> {
    match weights.iter().position(|w| !WEIGHTS.contains(w)) {
        Some(index) => Err(SplineError::Weight { index, weight: weights[index] }),
        None => Ok(()),
    }
}

impl Surface {
    /// Checks that the surface's numbers are in their ranges.
    ///
    /// # Errors
    /// The first condition of [`Surface`] that does not hold.
    pub fn check(&self) -> Result<(), SurfaceError> {
        let measure = |what: &'static str, value: f64, holds: bool| {
            if holds && value.is_finite() { Ok(()) } else { Err(SurfaceError::Measure { what, value }) }
        };
        let positive = |what, value: f64| measure(what, value, value > 0.0);
        match self {
            Self::Plane { frame } => orthonormal(frame),
            Self::Cylinder { frame, radius } => {
                orthonormal(frame)?;
                positive("a cylinder's radius must be positive", *radius)
            }
            Self::Cone { frame, radius, half_angle } => {
                orthonormal(frame)?;
                measure("a cone's radius must not be negative", *radius, *radius >= 0.0)?;
                let holds = half_angle.abs() < FRAC_PI_2 && *half_angle != 0.0;
                measure("a cone's half angle must be in (-π/2, π/2) and not 0", *half_angle, holds)
            }
            Self::Sphere { frame, radius } => {
                orthonormal(frame)?;
                positive("a sphere's radius must be positive", *radius)
            }
            Self::Torus { frame, major, minor } => {
                orthonormal(frame)?;
                measure("a torus's major radius must not be negative", *major, *major >= 0.0)?;
                positive("a torus's minor radius must be positive", *minor)
            }
            Self::Extrusion { curve, direction } => {
                curve.check().map_err(SurfaceError::Curve)?;
                positive("the length of an extrusion's direction must be positive", direction.length())
            }
            Self::Revolution { curve, frame } => {
                curve.check().map_err(SurfaceError::Curve)?;
                orthonormal(frame)
            }
            Self::Nurbs(surface) => surface.check(),
        }
    }
}

fn orthonormal(frame: &Frame3) -> Result<(), SurfaceError> {
    let axes = DMat3::from_cols(frame.x, frame.y, frame.z);
    if !(axes.is_finite() && frame.origin.is_finite()) {
        return Err(SurfaceError::Frame { error: f64::NAN });
    }
    let error = (axes.transpose() * axes - DMat3::IDENTITY)
        .to_cols_array()
        .into_iter()
        .chain((frame.x.cross(frame.y) - frame.z).to_array())
        .fold(0.0_f64, |most, x| if x.is_nan() { f64::INFINITY } else { most.max(x.abs()) });
    if error <= NOT_ORTHONORMAL { Ok(()) } else { Err(SurfaceError::Frame { error }) }
}

impl Part {
    /// Checks that everything in the part is valid and fits together: splines, ranges, ids and colours. Loops must
    /// close within the part's tolerance, and edges must reach their vertices within 10⁻⁴ of the part's size.
    ///
    /// Does not compare geometry with topology beyond that: loops may cross, edges may leave their surface. Linear in
    /// the size of the part.
    ///
    /// # Errors
    /// The first fault, in the order tolerance, colour, vertices, edges, faces.
    pub fn check(&self) -> Result<(), PartError> {
        if !(self.tolerance >= 0.0 && self.tolerance.is_finite()) {
            return Err(PartError::Tolerance(self.tolerance));
        }
        if let Some(colour) = bad_colour(self.colour) {
            return Err(PartError::Colour { colour });
        }
        if let Some(index) = self.vertices.iter().position(|p| !p.is_finite()) {
            return Err(PartError::Vertex(VertexId::new(index)));
        }
        let size = self.edges.iter().fold(2.0 * extent(&self.vertices), |s, e| s.max(2.0 * extent(&e.curve.points)));
        for index in 0..self.edges.len() {
            self.check_edge(EdgeId::new(index), EDGE_GAP * size)?;
        }
        for (index, face) in self.faces.iter().enumerate() {
            self.check_face(FaceId::new(index), face)?;
        }
        Ok(())
    }

    fn check_edge(&self, id: EdgeId, limit: f64) -> Result<(), PartError> {
        let edge = &self.edges[id.index()];
        edge.curve.check().map_err(|error| PartError::Curve { edge: id, error })?;
        let (a, b) = edge.range;
        let domain = edge.curve.domain();
        // Rounding in the file may put an end beyond the last knot.
        let slack = 1e-9 * (domain.1 - domain.0);
        if !(a < b && a >= domain.0 - slack && b <= domain.1 + slack) {
            return Err(PartError::Range { edge: id, range: edge.range, domain });
        }
        for (vertex, t) in [(edge.start, a), (edge.end, b)] {
            let count = self.vertices.len();
            let Some(&point) = self.vertices.get(vertex.index()) else {
                return Err(PartError::NoVertex { edge: id, vertex, count });
            };
            let distance = point.distance(edge.curve.point(t));
            if distance > limit {
                return Err(PartError::EdgeEnd { edge: id, vertex, distance, limit });
            }
        }
        Ok(())
    }

    fn check_face(&self, id: FaceId, face: &Face) -> Result<(), PartError> {
        if face.shell as usize >= self.shells.len() {
            return Err(PartError::NoShell { face: id, shell: face.shell, count: self.shells.len() });
        }
        if let Some(colour) = bad_colour(face.colour) {
            return Err(PartError::FaceColour { face: id, colour });
        }
        if face.lost {
            return Ok(());
        }
        let refused = face.refused.is_some();
        if !refused {
            face.surface.check().map_err(|error| PartError::Surface { face: id, error })?;
        }
        let finite = |(a, b): (f64, f64)| a.is_finite() && b.is_finite();
        let edges = face.wires().next().is_some();
        let is_bounded =
            edges || !refused && !face.loops.is_empty() || face.trims.as_ref().is_some_and(|t| !t.curves.is_empty());
        if !is_bounded && refused {
            return Err(PartError::NoBoundary(id));
        }
        if !is_bounded && !face.surface.natural_domain().into_iter().all(finite) {
            return Err(PartError::Unbounded(id));
        }
        if let Some(trims) = &face.trims {
            if !face.loops.is_empty() {
                let (loops, curves) = (face.loops.len(), trims.curves.len());
                return Err(PartError::TwoBoundaries { face: id, loops, curves });
            }
            for (curve, stated) in trims.curves.iter().enumerate() {
                stated.check().map_err(|error| PartError::Trim { face: id, curve, error })?;
            }
        }
        for (index, boundary) in face.loops.iter().enumerate() {
            match boundary {
                Loop::Vertex(vertex) if vertex.index() >= self.vertices.len() => {
                    let count = self.vertices.len();
                    return Err(PartError::NoLoopVertex { face: id, vertex: *vertex, count });
                }
                Loop::Vertex(_) => {}
                Loop::Edges(coedges) => self.check_loop(id, index, coedges)?,
            }
        }
        Ok(())
    }

    fn check_loop(&self, face: FaceId, index: usize, coedges: &[Coedge]) -> Result<(), PartError> {
        let Some(last) = coedges.last() else { return Err(PartError::EmptyLoop { face, index }) };
        for coedge in coedges {
            if coedge.edge.index() >= self.edges.len() {
                return Err(PartError::NoEdge { face, edge: coedge.edge, count: self.edges.len() });
            }
        }
        let ends = |coedge: &Coedge| self.edges[coedge.edge.index()].ends(coedge.reversed);
        let [_, mut end] = ends(last);
        for coedge in coedges {
            let [start, next] = ends(coedge);
            let distance = self.vertices[end.index()].distance(self.vertices[start.index()]);
            if start != end && distance > self.tolerance {
                return Err(PartError::OpenLoop { face, index, end, start, distance });
            }
            end = next;
        }
        Ok(())
    }
}

impl Model {
    /// Checks the unit, all parts, and that instances place existing parts by rigid motions, with an optional
    /// reflection and uniform scale, in colours from 0 to 1.
    ///
    /// # Errors
    /// The first fault, in the order unit, parts, instances.
    pub fn check(&self) -> Result<(), ModelError> {
        if !(self.millimetres_per_unit > 0.0 && self.millimetres_per_unit.is_finite()) {
            return Err(ModelError::Unit { millimetres: self.millimetres_per_unit });
        }
        for (index, part) in self.parts.iter().enumerate() {
            part.check().map_err(|error| ModelError::Part { part: PartId::new(index), error })?;
        }
        for (index, instance) in self.instances.iter().enumerate() {
            let id = InstanceId::new(index);
            let count = self.parts.len();
            if instance.part.index() >= count {
                return Err(ModelError::NoPart { instance: id, part: instance.part, count });
            }
            if let Some(error) = not_rigid(&instance.transform) {
                return Err(ModelError::Transform { instance: id, error });
            }
            if let Some(colour) = bad_colour(instance.colour) {
                return Err(ModelError::Colour { instance: id, colour });
            }
        }
        Ok(())
    }
}

/// How far a transform is from a rigid motion with a uniform scale, as [`ModelError::Transform`] tells it; `None` if it
/// is one.
pub(crate) fn not_rigid(transform: &DAffine3) -> Option<f64> {
    let m = transform.matrix3;
    let square = m.transpose() * m;
    let scale = (square.x_axis.x + square.y_axis.y + square.z_axis.z) / 3.0;
    let off = (square * (1.0 / scale) - DMat3::IDENTITY).to_cols_array().into_iter();
    let start = if transform.translation.is_finite() { 0.0 } else { f64::NAN };
    let error = off.fold(start, |most: f64, x| if most.is_nan() || x.is_nan() { f64::NAN } else { most.max(x.abs()) });
    (error.is_nan() || error > NOT_ORTHONORMAL).then_some(error)
}

#[cfg(test)]
mod tests {
    use super::super::{Colour, shapes};
    use super::*;
    use glam::DVec3;

    #[test]
    fn an_empty_model_is_sound() {
        assert_eq!(Model::default().check(), Ok(()));
    }

    #[test]
    fn instances_may_be_reflected() {
        let mut model = shapes::by_name("box").expect("a shape");
        let scale = DVec3::new(-2.0, 2.0, 2.0);
        model.instances[0].transform = DAffine3::from_scale(scale);
        assert_eq!(model.check(), Ok(()));
        model.instances[0].transform = DAffine3::from_scale(-scale.with_y(1.0));
        let refused = model.check();
        assert!(matches!(refused, Err(ModelError::Transform { .. })), "{refused:?}");
    }

    #[test]
    fn colours_have_shares_from_0_to_1() {
        let model = shapes::by_name("pair").expect("a shape");
        for share in [f32::NAN, f32::INFINITY, -0.01, 1.01, 2.0] {
            let colour = [0.0, share, 1.0, 1.0];
            let told = |change: fn(&mut Model) -> &mut Option<Colour>| {
                let mut bad = model.clone();
                *change(&mut bad) = Some([0.0, 0.5, 1.0, 1.0]);
                assert_eq!(bad.check(), Ok(()));
                *change(&mut bad) = Some(colour);
                bad.check().expect_err("a colour that is none").to_string()
            };
            let words = format!("colour {colour:?}; its numbers must be from 0 to 1");
            assert_eq!(told(|model| &mut model.parts[0].colour), format!("part 0: the part has the {words}"));
            assert_eq!(told(|model| &mut model.parts[1].faces[2].colour), format!("part 1: face 2 has the {words}"));
            assert_eq!(told(|model| &mut model.instances[1].colour), format!("instance 1 has the {words}"));
        }
    }
}
