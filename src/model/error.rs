//! Why parts and models are rejected, with the offending numbers.

use super::{EdgeId, FaceId, InstanceId, PartId, SplineError, SurfaceError, TrimError, VertexId};
use std::error::Error;
use std::fmt;

/// Why [`Part::check`](super::Part::check) rejects a part.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PartError {
    /// A vertex has an infinite or NaN coordinate.
    Vertex(VertexId),
    /// An edge's curve is invalid.
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
        /// The curve's domain.
        domain: (f64, f64),
    },
    /// An edge refers to a vertex that does not exist.
    NoVertex {
        /// The edge.
        edge: EdgeId,
        /// The vertex.
        vertex: VertexId,
        /// How many vertices there are.
        count: usize,
    },
    /// An end of an edge's curve misses its vertex.
    EdgeEnd {
        /// The edge.
        edge: EdgeId,
        /// The vertex.
        vertex: VertexId,
        /// Distance between them, millimetres.
        distance: f64,
        /// Largest allowed distance, millimetres.
        limit: f64,
    },
    /// A face's surface is invalid.
    Surface {
        /// The face.
        face: FaceId,
        /// Why.
        error: SurfaceError,
    },
    /// A face refers to a shell that does not exist.
    NoShell {
        /// The face.
        face: FaceId,
        /// The shell.
        shell: u32,
        /// How many shells there are.
        count: usize,
    },
    /// A vertex loop refers to a vertex that does not exist.
    NoLoopVertex {
        /// The face.
        face: FaceId,
        /// The vertex.
        vertex: VertexId,
        /// How many vertices there are.
        count: usize,
    },
    /// A loop refers to an edge that does not exist.
    NoEdge {
        /// The face.
        face: FaceId,
        /// The edge.
        edge: EdgeId,
        /// How many edges there are.
        count: usize,
    },
    /// A loop has no edges.
    EmptyLoop {
        /// The face.
        face: FaceId,
        /// Which of its loops.
        index: usize,
    },
    /// A coedge does not start where the previous one ends.
    OpenLoop {
        /// The face.
        face: FaceId,
        /// Which of its loops.
        index: usize,
        /// End of a coedge.
        end: VertexId,
        /// Start of the next coedge.
        start: VertexId,
        /// Distance between them, millimetres.
        distance: f64,
    },
    /// A face without loops and free trimming curves, on an unbounded surface.
    Unbounded(FaceId),
    /// A face without edges and free trimming curves, whose surface the reader refused.
    NoBoundary(FaceId),
    /// A free trimming curve is invalid.
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
        /// Number of its free trimming curves.
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
            Self::NoVertex { edge, vertex, count } => {
                write!(f, "edge {} refers to vertex {}; the part has {count}", edge.0, vertex.0)
            }
            Self::NoLoopVertex { face, vertex, count } => {
                write!(f, "face {} refers to vertex {}; the part has {count}", face.0, vertex.0)
            }
            Self::EdgeEnd { edge, vertex, distance, limit } => {
                write!(f, "edge {} misses its vertex {} by {distance:.3e} mm (limit {limit:.3e} mm)", edge.0, vertex.0)
            }
            Self::Surface { face, error } => write!(f, "surface of face {}: {error}", face.0),
            Self::NoShell { face, shell, count } => {
                write!(f, "face {} refers to shell {shell}; the part has {count}", face.0)
            }
            Self::NoEdge { face, edge, count } => {
                write!(f, "face {} refers to edge {}; the part has {count}", face.0, edge.0)
            }
            Self::EmptyLoop { face, index } => write!(f, "loop {index} of face {} has no edges", face.0),
            Self::OpenLoop { face, index, end, start, distance } => write!(
                f,
                "loop {index} of face {} is open: a coedge ends at vertex {}, the next starts at vertex {}, \
                 {distance:.3e} mm away",
                face.0, end.0, start.0
            ),
            Self::Unbounded(face) => {
                write!(f, "face {} has neither loops nor trimming curves, and its surface is unbounded", face.0)
            }
            Self::NoBoundary(face) => {
                write!(f, "face {} has neither edges nor trimming curves, and its surface could not be read", face.0)
            }
            Self::Trim { face, curve, error } => write!(f, "free trimming curve {curve} of face {}: {error}", face.0),
            Self::TwoBoundaries { face, loops, curves } => {
                write!(f, "face {} has {loops} loops and {curves} free trimming curves; it cannot have both", face.0)
            }
        }
    }
}

impl Error for PartError {}

/// Why [`Model::check`](super::Model::check) rejects a model.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ModelError {
    /// A part is invalid.
    Part {
        /// The part.
        part: PartId,
        /// Why.
        error: PartError,
    },
    /// An instance refers to a part that does not exist.
    NoPart {
        /// The instance.
        instance: InstanceId,
        /// The part.
        part: PartId,
        /// How many parts there are.
        count: usize,
    },
    /// An instance's transform is not a rigid motion with an optional uniform scale.
    Transform {
        /// The instance.
        instance: InstanceId,
        /// Largest absolute entry of `MᵀM / scale² - 1`; NaN if the matrix is singular, or the transform not finite.
        error: f64,
    },
    /// The length unit is not positive and finite.
    Unit {
        /// Millimetres per unit, as given.
        millimetres: f64,
    },
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Part { part, error } => write!(f, "part {}: {error}", part.0),
            Self::NoPart { instance, part, count } => {
                write!(f, "instance {} refers to part {}; the model has {count}", instance.0, part.0)
            }
            Self::Transform { instance, error } if error.is_nan() => {
                write!(f, "the transform of instance {} is singular or not finite", instance.0)
            }
            Self::Transform { instance, error } => {
                write!(
                    f,
                    "the transform of instance {} is not a rigid motion with a uniform scale (off by {error:.1e})",
                    instance.0
                )
            }
            Self::Unit { millimetres } => write!(f, "the length unit of {millimetres} mm is not positive and finite"),
        }
    }
}

impl Error for ModelError {}
