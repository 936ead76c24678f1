//! Why a frame is not made, or a scene not edited.

use crate::frame::{DamagedPlan, PlanError};
use crate::mesh::{GridTooCoarse, InstanceKey, SinkError};
use crate::model::{Colour, PartId, transform_fault};
use crate::view::InvalidView;

/// An internal error ended the session. Holds the message of the panic.
pub(super) struct Lost(pub(super) String);

impl From<Lost> for FrameError {
    fn from(Lost(why): Lost) -> Self {
        Self::Lost { why }
    }
}

impl From<PlanError> for FrameError {
    fn from(_: PlanError) -> Self {
        Self::Cancelled
    }
}

impl From<Lost> for EditError {
    fn from(Lost(why): Lost) -> Self {
        Self::Lost { why }
    }
}

/// Why a frame was not committed. If the sink was fed, [`MeshSink::abort`](crate::mesh::MeshSink::abort) was called.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FrameError {
    /// No frame was begun: nothing can be drawn for a view.
    #[error("view {view}: {why}")]
    View {
        /// Index of the view.
        view: usize,
        /// What is wrong with it.
        why: InvalidView,
    },
    /// The sink refused, or panicked, or [reads](crate::mesh::MeshSink::reads) more than was made.
    #[error(transparent)]
    Sink(#[from] SinkError),
    /// A tile does not fit the grid that the sink's layout asks for. The sink was not touched.
    #[error(transparent)]
    Grid(#[from] GridTooCoarse),
    /// The plan is one of another model, as after an [update](super::Session::update), or was changed since it was
    /// made. The sink was not touched.
    #[error(transparent)]
    Plan(#[from] DamagedPlan),
    /// An internal error. The session cannot be used any more.
    #[error("an internal error ended the session: {why}")]
    Lost {
        /// The message of the panic.
        why: String,
    },
    /// The work was [cancelled](crate::control::Control::cancel).
    #[error("tessellating was cancelled")]
    Cancelled,
}

/// Why an instance was not added, moved or removed, or attributes were not set. Nothing changes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EditError {
    /// There is no such part in the model.
    #[error("no part {}; the model has {count}", .part.0)]
    NoPart {
        /// The part.
        part: PartId,
        /// Number of parts.
        count: usize,
    },
    /// The instance was removed, or never was in this session.
    #[error("no instance {key:?}: it was removed, or never added")]
    NoInstance {
        /// Its key.
        key: InstanceKey,
    },
    /// The transform is not a rigid motion with an optional reflection and uniform scale.
    #[error("the transform is {}", transform_fault(*.error))]
    Transform {
        /// Largest absolute entry of `MᵀM / scale² - 1`; NaN if the matrix is singular, or the transform not finite.
        error: f64,
    },
    /// A factor of attributes is not finite, or not above 0.
    #[error("{name} is {value}; it must be finite and above 0")]
    Factor {
        /// The field.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A share of the colour is not from 0 to 1.
    #[error("the colour is {colour:?}; its numbers must be from 0 to 1")]
    Colour {
        /// The colour.
        colour: Colour,
    },
    /// An internal error ended the session.
    #[error("an internal error ended the session: {why}")]
    Lost {
        /// The message of the panic.
        why: String,
    },
}
