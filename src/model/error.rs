//! What [`Part::check`](super::Part::check) and [`Model::check`](super::Model::check) refuse, with the numbers that show why.

use super::{EdgeId, FaceId, InstanceId, PartId, SplineError, SurfaceError, TrimError, VertexId};
use std::error::Error;
use std::fmt;

/// Why a part is not one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PartError {
    /// A vertex has a coordinate that is infinite or not a number.
    Vertex(VertexId),
    /// An edge's curve is not one.
    Curve {
        /// The edge.
        edge: EdgeId,
        /// Why.
        error: SplineError,
    },
    /// An edge's range is empty, backwards or outside its curve's domain.
    Range {
        /// The edge.
        edge: EdgeId,
        /// As given.
        range: (f64, f64),
        /// What the curve has.
        domain: (f64, f64),
    },
    /// An edge names a vertex that does not exist.
    NoVertex {
        /// The edge, if an edge names it.
        edge: Option<EdgeId>,
        /// The face, if a vertex loop names it.
        face: Option<FaceId>,
        /// The vertex.
        vertex: VertexId,
        /// How many there are.
        count: usize,
    },
    /// An end of an edge's curve misses its vertex.
    EdgeEnd {
        /// The edge.
        edge: EdgeId,
        /// The vertex.
        vertex: VertexId,
        /// By how much, millimetres.
        distance: f64,
        /// What is allowed.
        limit: f64,
    },
    /// A face's surface is not one.
    Surface {
        /// The face.
        face: FaceId,
        /// Why.
        error: SurfaceError,
    },
    /// A face names a shell that does not exist.
    NoShell {
        /// The face.
        face: FaceId,
        /// The shell.
        shell: u32,
        /// How many there are.
        count: usize,
    },
    /// A loop names an edge that does not exist.
    NoEdge {
        /// The face.
        face: FaceId,
        /// The edge.
        edge: EdgeId,
        /// How many there are.
        count: usize,
    },
    /// A coedge's pcurve is not one.
    Pcurve {
        /// The face.
        face: FaceId,
        /// The coedge's edge.
        edge: EdgeId,
        /// Why.
        error: SplineError,
    },
    /// A loop without edges.
    EmptyLoop {
        /// The face.
        face: FaceId,
        /// Which of its loops.
        index: usize,
    },
    /// A coedge does not start at the vertex where the one before it ends.
    OpenLoop {
        /// The face.
        face: FaceId,
        /// Which of its loops.
        index: usize,
        /// Where a coedge ends.
        end: VertexId,
        /// Where the next one starts.
        start: VertexId,
        /// How far apart, millimetres.
        distance: f64,
    },
    /// A face without loops and free trimming curves on a surface that does not end.
    Unbounded(FaceId),
    /// A free trimming curve is none.
    Trim {
        /// The face.
        face: FaceId,
        /// Which of its curves.
        curve: usize,
        /// Why.
        error: TrimError,
    },
    /// A face has both loops and free trims.
    TwoBoundaries {
        /// The face.
        face: FaceId,
        /// Number of its loops.
        loops: usize,
        /// Number of its free curves.
        curves: usize,
    },
}

impl fmt::Display for PartError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Vertex(v) => write!(f, "vertex {} is not finite", v.0),
            Self::Curve { edge, error } => write!(f, "curve of edge {}: {error}", edge.0),
            Self::Range { edge, range: (a, b), domain: (c, d) } => {
                write!(f, "edge {} runs from {a} to {b}, its curve from {c} to {d}", edge.0)
            }
            Self::NoVertex { edge, face, vertex, count } => {
                match (edge, face) {
                    (Some(edge), _) => write!(f, "edge {}", edge.0)?,
                    (None, Some(face)) => write!(f, "face {}", face.0)?,
                    (None, None) => {}
                }
                write!(f, " names vertex {} of {count}", vertex.0)
            }
            Self::EdgeEnd { edge, vertex, distance, limit } => write!(
                f,
                "edge {} misses its vertex {} by {distance:.3e} mm, more than {limit:.3e} mm",
                edge.0, vertex.0
            ),
            Self::Surface { face, error } => write!(f, "surface of face {}: {error}", face.0),
            Self::NoShell { face, shell, count } => write!(f, "face {} names shell {shell} of {count}", face.0),
            Self::NoEdge { face, edge, count } => write!(f, "face {} names edge {} of {count}", face.0, edge.0),
            Self::Pcurve { face, edge, error } => write!(f, "pcurve of edge {} on face {}: {error}", edge.0, face.0),
            Self::EmptyLoop { face, index } => write!(f, "loop {index} of face {} has no edges", face.0),
            Self::OpenLoop { face, index, end, start, distance } => write!(
                f,
                "loop {index} of face {} is open: a coedge ends at vertex {}, the next starts at vertex {}, {distance:.3e} mm \
                 away",
                face.0, end.0, start.0
            ),
            Self::Unbounded(face) => {
                write!(f, "face {} has neither loops nor trimming curves, and its surface does not end", face.0)
            }
            Self::Trim { face, curve, error } => write!(f, "free trimming curve {curve} of face {}: {error}", face.0),
            Self::TwoBoundaries { face, loops, curves } => {
                write!(
                    f,
                    "face {} has {loops} loops and {curves} free trimming curves: a face has one or the other",
                    face.0
                )
            }
        }
    }
}

impl Error for PartError {}

/// Why a model is not one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ModelError {
    /// A part is not one.
    Part {
        /// Which.
        part: PartId,
        /// Why.
        error: PartError,
    },
    /// An instance names a part that does not exist.
    NoPart {
        /// The instance.
        instance: InstanceId,
        /// The part.
        part: PartId,
        /// How many there are.
        count: usize,
    },
    /// An instance's transform is not a rigid motion with a uniform scale.
    Transform {
        /// The instance.
        instance: InstanceId,
        /// How far `MᵀM / scale²` is from the identity (not a number for transforms that are not finite).
        error: f64,
    },
    /// Millimetres per unit are not positive and finite.
    Unit {
        /// As given.
        millimetres: f64,
    },
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Part { part, error } => write!(f, "part {}: {error}", part.0),
            Self::NoPart { instance, part, count } => {
                write!(f, "instance {} names part {} of {count}", instance.0, part.0)
            }
            Self::Transform { instance, error } => {
                write!(f, "instance {} is not placed by a rigid motion and a uniform scale, by {error:.1e}", instance.0)
            }
            Self::Unit { millimetres } => write!(f, "a unit of {millimetres} mm"),
        }
    }
}

impl Error for ModelError {}
