//! Geometry from code -> checked parts and models.

use super::{
    Coedge, Colour, CurveKind, Edge, EdgeId, Face, FaceId, Frame3, FreeTrims, Instance, InstanceId, Loop, Model,
    ModelError, NurbsCurve3, Part, PartError, PartId, Shell, ShellKind, Surface, VertexId,
};
use glam::{DAffine3, DVec3};
use std::f64::consts::TAU;

/// Builds one part from vertices, edges, shells and faces. [`finish`](Self::finish) checks them.
///
/// ```
/// use trimtess::model::{Frame3, Loop, PartBuilder, ShellKind, Surface};
///
/// let mut disk = PartBuilder::new("disk");
/// let rim = disk.circle(&Frame3::WORLD, 5.0);
/// let shell = disk.plain_shell(ShellKind::Open);
/// disk.plain_face(Surface::Plane { frame: Frame3::WORLD }, shell, vec![Loop::Edges(vec![rim.along()])], false);
/// let part = disk.finish()?;
/// assert_eq!((part.edges.len(), part.faces.len()), (1, 1));
/// # Ok::<(), trimtess::model::PartError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct PartBuilder {
    part: Part,
}

impl PartBuilder {
    /// Starts an empty part.
    #[must_use]
    pub fn new(name: impl Into<String>) -> Self {
        Self { part: Part { name: name.into(), ..Part::default() } }
    }

    /// Sets the colour of faces that have none.
    pub fn colour(&mut self, colour: Colour) {
        self.part.colour = Some(colour);
    }

    /// Adds a vertex.
    pub fn vertex(&mut self, point: DVec3) -> VertexId {
        self.part.vertices.push(point);
        VertexId::new(self.part.vertices.len() - 1)
    }

    /// Adds an edge.
    pub fn edge(&mut self, edge: Edge) -> EdgeId {
        self.part.edges.push(edge);
        EdgeId::new(self.part.edges.len() - 1)
    }

    /// Adds an edge along the whole of `curve`.
    pub fn curve(&mut self, curve: NurbsCurve3, kind: CurveKind, start: VertexId, end: VertexId) -> EdgeId {
        let range = curve.domain();
        self.edge(Edge { curve, range, start, end, kind, entity: 0 })
    }

    /// Adds a straight edge.
    ///
    /// # Panics
    /// If this builder has no such vertex.
    pub fn line(&mut self, start: VertexId, end: VertexId) -> EdgeId {
        let [a, b] = [start, end].map(|v| self.part.vertices[v.index()]);
        self.curve(NurbsCurve3::line(a, b), CurveKind::Line, start, end)
    }

    /// Adds a closed polygon of straight edges with new vertices, and returns its loop.
    pub fn polygon(&mut self, corners: &[DVec3]) -> Vec<Coedge> {
        let vertices: Vec<VertexId> = corners.iter().map(|&corner| self.vertex(corner)).collect();
        let next = |k: usize| vertices[(k + 1) % vertices.len()];
        (0..vertices.len()).map(|k| self.line(vertices[k], next(k)).along()).collect()
    }

    /// Adds a full circle about the frame's z axis, with a new vertex on its x axis.
    pub fn circle(&mut self, frame: &Frame3, radius: f64) -> EdgeId {
        let vertex = self.vertex(frame.place(DVec3::X * radius));
        self.curve(NurbsCurve3::arc(frame, radius, radius, 0.0, TAU), CurveKind::Circle, vertex, vertex)
    }

    /// Adds a shell and returns its index, for [`Face::shell`].
    pub fn shell(&mut self, shell: Shell) -> u32 {
        self.part.shells.push(shell);
        u32::try_from(self.part.shells.len() - 1).unwrap_or(u32::MAX)
    }

    /// Adds a shell without an entity number.
    pub fn plain_shell(&mut self, kind: ShellKind) -> u32 {
        self.shell(Shell { kind, entity: 0 })
    }

    /// Adds a face.
    pub fn face(&mut self, face: Face) -> FaceId {
        self.part.faces.push(face);
        FaceId::new(self.part.faces.len() - 1)
    }

    /// Adds a face without colour or name. `reversed`: its outward normal is opposite to the surface's.
    pub fn plain_face(&mut self, surface: Surface, shell: u32, loops: Vec<Loop>, reversed: bool) -> FaceId {
        self.face(Face::new(surface, shell, loops, reversed))
    }

    /// Adds a face without colour or name, trimmed by free curves in (u,v). On an unbounded surface (a plane, say), the
    /// curves must bound the face.
    ///
    /// ```
    /// use glam::DVec2;
    /// use trimtess::model::{FreeTrims, PartBuilder, ShellKind, Surface, Frame3, TrimCurve, TrimRule};
    ///
    /// let mut part = PartBuilder::new("half a ring");
    /// let shell = part.plain_shell(ShellKind::Open);
    /// let torus = Surface::Torus { frame: Frame3::WORLD, major: 3.0, minor: 1.0 };
    /// // From the bottom of the domain to its top: what lies left of u = 3 is kept.
    /// let cut = TrimCurve::polyline(vec![DVec2::new(3.0, 0.0), DVec2::new(3.0, 2.0 * std::f64::consts::PI)]);
    /// part.trimmed_face(torus, shell, FreeTrims { rule: TrimRule::Handedness, curves: vec![cut] }, false);
    /// assert_eq!(part.finish()?.faces.len(), 1);
    /// # Ok::<(), trimtess::model::PartError>(())
    /// ```
    pub fn trimmed_face(&mut self, surface: Surface, shell: u32, trims: FreeTrims, reversed: bool) -> FaceId {
        self.face(Face { trims: Some(trims), ..Face::new(surface, shell, Vec::new(), reversed) })
    }

    /// Returns the part as built so far.
    #[must_use]
    pub fn part(&self) -> &Part {
        &self.part
    }

    /// Checks and returns the part.
    ///
    /// # Errors
    /// The first fault that [`Part::check`] finds.
    pub fn finish(self) -> Result<Part, PartError> {
        self.part.check()?;
        Ok(self.part)
    }
}

impl EdgeId {
    /// A coedge in the edge's own direction.
    #[must_use]
    pub fn along(self) -> Coedge {
        Coedge { edge: self, reversed: false }
    }

    /// A coedge against the edge's direction.
    #[must_use]
    pub fn against(self) -> Coedge {
        Coedge { edge: self, reversed: true }
    }
}

/// Builds a model from parts and instances. [`finish`](Self::finish) checks them.
#[derive(Clone, Debug)]
pub struct ModelBuilder {
    model: Model,
}

impl ModelBuilder {
    /// Starts an empty model in millimetres.
    #[must_use]
    pub fn new(name: impl Into<String>) -> Self {
        Self { model: Model { name: name.into(), ..Model::default() } }
    }

    /// Adds a part without placing it.
    pub fn part(&mut self, part: Part) -> PartId {
        self.model.parts.push(part);
        PartId::new(self.model.parts.len() - 1)
    }

    /// Adds an instance of a part.
    pub fn instance(&mut self, instance: Instance) -> InstanceId {
        self.model.instances.push(instance);
        InstanceId::new(self.model.instances.len() - 1)
    }

    /// Adds an instance without colour or name of its own.
    pub fn place(&mut self, part: PartId, transform: DAffine3) -> InstanceId {
        self.instance(Instance::new(part, transform))
    }

    /// Checks and returns the model.
    ///
    /// # Errors
    /// The first fault that [`Model::check`] finds.
    pub fn finish(self) -> Result<Model, ModelError> {
        self.model.check()?;
        Ok(self.model)
    }
}
