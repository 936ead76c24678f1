//! Parts (B-reps), instances and the model that holds them.

use super::diagnostic::Diagnostic;
use super::trouble::StepCause;
use super::{EdgeId, FreeTrims, NurbsCurve2, NurbsCurve3, PartId, Surface, VertexId};
use glam::{DAffine3, DVec3};

/// Linear RGBA, 0..1. Files' sRGB values are stored as given.
pub type Colour = [f32; 4];

/// What kind of curve an edge was before it became NURBS; lets straight edges stay two points.
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

/// A B-rep edge: one 3-D curve over `range`, from vertex `start` to vertex `end`.
///
/// The curve's ends may miss the vertices by the file's tolerance; meshes use the vertex points.
#[derive(Clone, Debug)]
pub struct Edge {
    /// The curve in space; the master of all pcurves.
    pub curve: NurbsCurve3,
    /// Parameter at `start` and at `end`; `range.0 < range.1`, inside the curve's domain.
    pub range: (f64, f64),
    /// Where the edge starts.
    pub start: VertexId,
    /// Where it ends; equal to `start` for a closed edge.
    pub end: VertexId,
    /// What the file called it.
    pub kind: CurveKind,
    /// Entity number in the source file, 0 if none.
    pub entity: u64,
}

/// An edge as one face uses it.
#[derive(Clone, Debug)]
pub struct Coedge {
    /// The edge.
    pub edge: EdgeId,
    /// Whether the loop runs against the edge.
    pub reversed: bool,
    /// The curve in the face's (u,v), in the edge's parameter, if the user gave one.
    pub pcurve: Option<NurbsCurve2>,
}

/// One boundary of a face.
#[derive(Clone, Debug)]
pub enum Loop {
    /// Coedges head to tail, closed. Oriented so that the kept side lies left, seen from the tip of the *surface* normal.
    Edges(Vec<Coedge>),
    /// A single point (an apex or a pole) bounds the face.
    Vertex(VertexId),
}

/// A trimmed surface.
#[derive(Clone, Debug)]
pub struct Face {
    /// Its surface.
    pub surface: Surface,
    /// Its boundaries; empty for a surface that is kept whole (closed, or with a bounded natural domain).
    pub loops: Vec<Loop>,
    /// Curves in (u,v) that trim it freely, instead of `loops`: a face has one or the other.
    pub trims: Option<FreeTrims>,
    /// Whether the face's outward normal is opposite to the surface's `S_u × S_v`.
    pub reversed: bool,
    /// The shell it belongs to: faces of one shell are oriented together.
    pub shell: u32,
    /// Colour, where the file gives one.
    pub colour: Option<Colour>,
    /// Name, empty if none.
    pub name: String,
    /// Entity number in the source file, 0 if none.
    pub entity: u64,
    /// Whether the source has a face here that could not be read. It keeps its number and its name, so that it is counted
    /// among the faces without triangles; its surface and loops say nothing. Whoever sets it tells why in a diagnostic.
    pub lost: bool,
    /// Why the source's surface could not be read, where the loops could: `surface` says nothing then, and the loops are filled
    /// in space, which is told with this reason.
    pub refused: Option<StepCause>,
}

/// What a group of faces is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShellKind {
    /// The outer boundary of a solid: normals point outwards, the volume is positive.
    Outer,
    /// A void of a solid: normals point into the void, the volume is negative.
    Void,
    /// An open (or not known to be closed) shell, or loose faces.
    Open,
}

/// A group of faces.
#[derive(Clone, Debug)]
pub struct Shell {
    /// What it bounds.
    pub kind: ShellKind,
    /// Entity number in the source file, 0 if none.
    pub entity: u64,
}

/// A B-rep in its own coordinates (millimetres).
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// Name, empty if none.
    pub name: String,
    /// Vertex points.
    pub vertices: Vec<DVec3>,
    /// Edges.
    pub edges: Vec<Edge>,
    /// Faces.
    pub faces: Vec<Face>,
    /// Shells that the faces name.
    pub shells: Vec<Shell>,
    /// Colour of faces that have none.
    pub colour: Option<Colour>,
    /// Length up to which the source calls two points one, millimetres; 0 if it does not say. Wires may leave gaps as wide.
    pub tolerance: f64,
}

/// A placed part.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Which part.
    pub part: PartId,
    /// Part to world; a rigid motion, perhaps with a uniform scale.
    pub transform: DAffine3,
    /// Overrides the part's and faces' colours.
    pub colour: Option<Colour>,
    /// Name, empty if none.
    pub name: String,
}

/// A whole scene as stated.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Name (the file's, usually).
    pub name: String,
    /// Parts.
    pub parts: Vec<Part>,
    /// Placed parts.
    pub instances: Vec<Instance>,
    /// What the file's lengths were measured in: millimetres per file unit. Model lengths are already millimetres.
    pub millimetres_per_unit: f64,
    /// What was repaired or lost on the way here.
    pub diagnostics: Vec<Diagnostic>,
}
