//! Why parts and models are rejected, with the offending numbers.

use super::{Colour, EdgeId, FaceId, InstanceId, PartId, SplineError, SurfaceError, TrimError, VertexId};

/// Why [`Part::check`](super::Part::check) rejects a part.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PartError {
    /// The tolerance is negative, infinite or NaN.
    #[error("a tolerance of {0} mm is negative or not finite")]
    Tolerance(f64),
    /// A share of the part's colour is not from 0 to 1.
    #[error("the part has the colour {colour:?}; its numbers must be from 0 to 1")]
    Colour {
        /// The colour.
        colour: Colour,
    },
    /// A share of a face's colour is not from 0 to 1.
    #[error("face {} has the colour {colour:?}; its numbers must be from 0 to 1", .face.0)]
    FaceColour {
        /// The face.
        face: FaceId,
        /// The colour.
        colour: Colour,
    },
    /// A vertex has an infinite or NaN coordinate.
    #[error("vertex {} is not finite", .0.0)]
    Vertex(VertexId),
    /// An edge's curve is invalid.
    #[error("curve of edge {}: {error}", .edge.0)]
    Curve {
        /// The edge.
        edge: EdgeId,
        /// Why.
        error: SplineError,
    },
    /// An edge's range is empty, backwards or outside its curve's domain.
    #[error("edge {} runs from {} to {}, its curve from {} to {}", .edge.0, .range.0, .range.1, .domain.0, .domain.1)]
    Range {
        /// The edge.
        edge: EdgeId,
        /// As given.
        range: (f64, f64),
        /// The curve's domain.
        domain: (f64, f64),
    },
    /// An edge refers to a vertex that does not exist.
    #[error("edge {} refers to vertex {}; the part has {count}", .edge.0, .vertex.0)]
    NoVertex {
        /// The edge.
        edge: EdgeId,
        /// The vertex.
        vertex: VertexId,
        /// How many vertices there are.
        count: usize,
    },
    /// An end of an edge's curve misses its vertex.
    #[error("edge {} misses its vertex {} by {distance:.3e} mm (limit {limit:.3e} mm)", .edge.0, .vertex.0)]
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
    #[error("surface of face {}: {error}", .face.0)]
    Surface {
        /// The face.
        face: FaceId,
        /// Why.
        error: SurfaceError,
    },
    /// A face refers to a shell that does not exist.
    #[error("face {} refers to shell {shell}; the part has {count}", .face.0)]
    NoShell {
        /// The face.
        face: FaceId,
        /// The shell.
        shell: u32,
        /// How many shells there are.
        count: usize,
    },
    /// A vertex loop refers to a vertex that does not exist.
    #[error("face {} refers to vertex {}; the part has {count}", .face.0, .vertex.0)]
    NoLoopVertex {
        /// The face.
        face: FaceId,
        /// The vertex.
        vertex: VertexId,
        /// How many vertices there are.
        count: usize,
    },
    /// A loop refers to an edge that does not exist.
    #[error("face {} refers to edge {}; the part has {count}", .face.0, .edge.0)]
    NoEdge {
        /// The face.
        face: FaceId,
        /// The edge.
        edge: EdgeId,
        /// How many edges there are.
        count: usize,
    },
    /// A loop has no edges.
    #[error("loop {index} of face {} has no edges", .face.0)]
    EmptyLoop {
        /// The face.
        face: FaceId,
        /// Which of its loops.
        index: usize,
    },
    /// A coedge does not start where the previous one ends.
    #[error(
        "loop {index} of face {} is open: a coedge ends at vertex {}, the next starts at vertex {}, {distance:.3e} mm \
         away",
        .face.0, .end.0, .start.0
    )]
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
    #[error("face {} has neither loops nor trimming curves, and its surface is unbounded", .0.0)]
    Unbounded(FaceId),
    /// A face without edges and free trimming curves, whose surface the reader refused.
    #[error("face {} has neither edges nor trimming curves, and its surface could not be read", .0.0)]
    NoBoundary(FaceId),
    /// A free trimming curve is invalid.
    #[error("free trimming curve {curve} of face {}: {error}", .face.0)]
    Trim {
        /// The face.
        face: FaceId,
        /// Which of its curves.
        curve: usize,
        /// Why.
        error: TrimError,
    },
    /// A face has both loops and free trims.
    #[error("face {} has {loops} loops and {curves} free trimming curves; it cannot have both", .face.0)]
    TwoBoundaries {
        /// The face.
        face: FaceId,
        /// Number of its loops.
        loops: usize,
        /// Number of its free trimming curves.
        curves: usize,
    },
}

/// What is wrong with a transform of an instance that is off by `error` from one that is allowed.
pub(crate) fn transform_fault(error: f64) -> String {
    if error.is_nan() {
        return "singular or not finite".to_owned();
    }
    format!("not a rigid motion with a uniform scale (off by {error:.1e})")
}

/// Why [`Model::check`](super::Model::check) rejects a model.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A part is invalid.
    #[error("part {}: {error}", .part.0)]
    Part {
        /// The part.
        part: PartId,
        /// Why.
        error: PartError,
    },
    /// An instance refers to a part that does not exist.
    #[error("instance {} refers to part {}; the model has {count}", .instance.0, .part.0)]
    NoPart {
        /// The instance.
        instance: InstanceId,
        /// The part.
        part: PartId,
        /// How many parts there are.
        count: usize,
    },
    /// An instance's transform is not a rigid motion with an optional reflection and uniform scale.
    #[error("the transform of instance {} is {}", .instance.0, transform_fault(*.error))]
    Transform {
        /// The instance.
        instance: InstanceId,
        /// Largest absolute entry of `MᵀM / scale² - 1`; NaN if the matrix is singular, or the transform not finite.
        error: f64,
    },
    /// A share of an instance's colour is not from 0 to 1.
    #[error("instance {} has the colour {colour:?}; its numbers must be from 0 to 1", .instance.0)]
    Colour {
        /// The instance.
        instance: InstanceId,
        /// The colour.
        colour: Colour,
    },
    /// The length unit is not positive and finite.
    #[error("the length unit of {millimetres} mm is not positive and finite")]
    Unit {
        /// Millimetres per unit, as given.
        millimetres: f64,
    },
}
