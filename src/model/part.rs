//! Parts (B-reps), instances and models.

use super::diagnostic::Diagnostic;
use super::trouble::StepCause;
use super::{Colour, EdgeId, FreeTrims, NurbsCurve3, PartId, Surface, VertexId};
use glam::{DAffine3, DVec3};
use std::fmt;
use std::sync::Arc;

/// Kind of an edge's curve before its conversion to NURBS. Lets straight edges stay two points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveKind {
    /// A straight segment.
    Line,
    /// A circular arc.
    Circle,
    /// An elliptic, hyperbolic or parabolic arc.
    Conic,
    /// A B-spline.
    Spline,
    /// A polyline.
    Polyline,
}

/// A B-rep edge: one curve in space over `range`, from vertex `start` to vertex `end`.
///
/// The curve's ends may miss the vertices by the file's tolerance. Meshes use the vertex points.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// The curve in space. All pcurves follow it.
    pub curve: NurbsCurve3,
    /// Parameter at `start` and at `end`; `range.0 < range.1`, inside the curve's domain.
    pub range: (f64, f64),
    /// First vertex.
    pub start: VertexId,
    /// Last vertex; equal to `start` for a closed edge.
    pub end: VertexId,
    /// Kind of curve in the source file.
    pub kind: CurveKind,
    /// Entity number in the source file, 0 if none.
    pub entity: u64,
}

impl Edge {
    /// Start and end vertex of the edge, or of its reverse.
    pub(crate) fn ends(&self, reversed: bool) -> [VertexId; 2] {
        if reversed { [self.end, self.start] } else { [self.start, self.end] }
    }
}

/// One use of an edge by a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coedge {
    /// The edge.
    pub edge: EdgeId,
    /// Whether the loop runs against the edge.
    pub reversed: bool,
}

/// One boundary of a face.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Loop {
    /// Coedges head to tail, closed. The face lies left of them, seen from the tip of the *surface* normal.
    Edges(Vec<Coedge>),
    /// A single point: an apex or a pole.
    Vertex(VertexId),
}

/// A trimmed surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// The surface to trim.
    pub surface: Surface,
    /// Boundaries; empty for a whole surface (closed, or with a bounded natural domain).
    pub loops: Vec<Loop>,
    /// Free trimming curves in (u,v), as an alternative to `loops`. A face cannot have both.
    pub trims: Option<FreeTrims>,
    /// Whether the face's outward normal is opposite to the surface's `S_u × S_v`.
    pub reversed: bool,
    /// Index into [`Part::shells`]. Faces of one shell are oriented together.
    pub shell: u32,
    /// Colour, where the file gives one.
    pub colour: Option<Colour>,
    /// Name, empty if none.
    pub name: String,
    /// Entity number in the source file, 0 if none.
    pub entity: u64,
    /// Whether the reader could not read this face. It keeps its index and name, so that it counts as a face without
    /// triangles; `surface` and `loops` are meaningless. The reader reports the cause in a diagnostic.
    pub lost: bool,
    /// Why the surface could not be read, if only the loops could. `surface` is meaningless then. The loops are filled
    /// in space, and a diagnostic reports this cause.
    pub refused: Option<StepCause>,
}

impl Face {
    /// A face without colour or name. `reversed`: its outward normal is opposite to the surface's.
    #[must_use]
    pub fn new(surface: Surface, shell: u32, loops: Vec<Loop>, reversed: bool) -> Self {
        let name = String::new();
        Self { surface, loops, trims: None, reversed, shell, colour: None, name, entity: 0, lost: false, refused: None }
    }

    /// The coedges of each loop of edges, in the order of the loops.
    pub fn wires(&self) -> impl Iterator<Item = &[Coedge]> {
        self.loops.iter().filter_map(|l| match l {
            Loop::Edges(coedges) => Some(&coedges[..]),
            Loop::Vertex(_) => None,
        })
    }
}

/// What a shell bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShellKind {
    /// The outer boundary of a solid: normals point outwards, the volume is positive.
    Outer,
    /// A void of a solid, that of the last outer shell before it: normals point into the void, the volume is negative.
    Void,
    /// A shell that is open or not known to be closed, or loose faces.
    Open,
}

/// A group of faces that are oriented together.
#[derive(Clone, Debug, PartialEq)]
pub struct Shell {
    /// What it bounds.
    pub kind: ShellKind,
    /// Entity number in the source file, 0 if none.
    pub entity: u64,
}

/// A B-rep in its own coordinates (millimetres).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// Name, empty if none.
    pub name: String,
    /// Vertex positions.
    pub vertices: Vec<DVec3>,
    /// Edges, indexed by [`EdgeId`].
    pub edges: Vec<Edge>,
    /// Faces, indexed by [`FaceId`](super::FaceId).
    pub faces: Vec<Face>,
    /// Shells, indexed by [`Face::shell`].
    pub shells: Vec<Shell>,
    /// Colour of faces that have none.
    pub colour: Option<Colour>,
    /// Distance within which the source treats two points as one, millimetres, finite; 0 if not stated. Gaps in wires
    /// up to this width are closed.
    pub tolerance: f64,
}

/// An assembly of a product structure, at one place in it. Chains of parents may be of any length.
#[derive(Clone)]
pub struct Assembly {
    /// Name, empty if none.
    pub name: Arc<str>,
    /// The assembly that it stands in; `None` for a root.
    pub parent: Option<Arc<Self>>,
}

impl Assembly {
    /// This assembly and those that it stands in, from the innermost to the root.
    pub fn ancestors(&self) -> impl Iterator<Item = &Self> {
        std::iter::successors(Some(self), |assembly| assembly.parent.as_deref())
    }

    fn names(&self) -> impl Iterator<Item = &str> {
        self.ancestors().map(|assembly| &*assembly.name)
    }
}

// Derived traits would call themselves once per parent, and a chain that a caller makes may be longer than the stack.
impl PartialEq for Assembly {
    fn eq(&self, other: &Self) -> bool {
        self.names().eq(other.names())
    }
}

impl Eq for Assembly {}

impl fmt::Debug for Assembly {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.names()).finish()
    }
}

impl Drop for Assembly {
    fn drop(&mut self) {
        let mut parent = self.parent.take();
        while let Some(mut last) = parent.and_then(Arc::into_inner) {
            parent = last.parent.take();
        }
    }
}

/// A placed part.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// The part to place.
    pub part: PartId,
    /// Part to world: a rigid motion, with an optional reflection and uniform scale.
    pub transform: DAffine3,
    /// Overrides the colours of the part and its faces.
    pub colour: Option<Colour>,
    /// Name, empty if none. Shared: an assembly may place a part many thousand times.
    pub name: Arc<str>,
    /// The assembly that it stands in; `None` for a root. Instances of one assembly share it: two assemblies of one
    /// name are two allocations.
    pub assembly: Option<Arc<Assembly>>,
}

impl Instance {
    /// The part, placed, without colour or name, in no assembly.
    #[must_use]
    pub fn new(part: PartId, transform: DAffine3) -> Self {
        Self { part, transform, colour: None, name: "".into(), assembly: None }
    }
}

/// A scene: parts and their placements.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Name, usually that of the file.
    pub name: String,
    /// Parts, indexed by [`PartId`].
    pub parts: Vec<Part>,
    /// Placed parts, indexed by [`InstanceId`](super::InstanceId).
    pub instances: Vec<Instance>,
    /// Length unit of the source file. Lengths in the model are already millimetres.
    pub millimetres_per_unit: f64,
    /// What the reader repaired or lost.
    pub diagnostics: Vec<Diagnostic>,
}

/// No parts; lengths in millimetres.
impl Default for Model {
    fn default() -> Self {
        let (name, parts) = (String::new(), Vec::new());
        Self { name, parts, instances: Vec::new(), millimetres_per_unit: 1.0, diagnostics: Vec::new() }
    }
}

impl From<Part> for Model {
    /// The part, placed once, in a model of its name. Unchecked, as all that is not built by
    /// [`ModelBuilder`](super::ModelBuilder).
    fn from(part: Part) -> Self {
        let instances = vec![Instance::new(PartId(0), DAffine3::IDENTITY)];
        Self { name: part.name.clone(), parts: vec![part], instances, ..Self::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_of_assemblies_may_be_longer_than_the_stack() {
        let of = |count: u32| {
            let mut last = None;
            for k in 0..count {
                last = Some(Arc::new(Assembly { name: format!("{k}").into(), parent: last }));
            }
            last.expect("a chain")
        };
        let (long, same, short) = (of(1_000_000), of(1_000_000), of(3));
        assert!(long == same && long != short && *long.ancestors().last().expect("a root").name == *"0");
        assert_eq!(format!("{short:?}"), r#"["2", "1", "0"]"#);
        assert_eq!(format!("{long:?}").matches(',').count(), 999_999);
        // The innermost goes, and its parents stay with whoever has them.
        let inner = Arc::clone(short.parent.as_ref().expect("a parent"));
        drop(short);
        assert_eq!(inner.ancestors().count(), 2);
    }
}
