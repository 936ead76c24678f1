//! Why a frame is not made.

use super::instances::InstanceKey;
use crate::mesh::{GridTooCoarse, SinkError};
use crate::model::{Colour, PartId};
use crate::view::InvalidView;
use std::fmt;

/// An internal error ended the session. Holds the message of the panic.
pub(super) struct Lost(pub(super) String);

impl From<Lost> for FrameError {
    fn from(Lost(why): Lost) -> Self {
        Self::Lost { why }
    }
}

impl From<Lost> for InstanceError {
    fn from(Lost(why): Lost) -> Self {
        Self::Lost { why }
    }
}

/// Why a frame was not committed. If the sink was fed, [`MeshSink::abort`](crate::mesh::MeshSink::abort) was called.
#[derive(Debug)]
#[non_exhaustive]
pub enum FrameError {
    /// No frame was begun: nothing can be drawn for a view.
    View {
        /// Index of the view.
        view: usize,
        /// What is wrong with it.
        why: InvalidView,
    },
    /// The sink refused, or panicked, or [reads](crate::mesh::MeshSink::reads) more than was made.
    Sink(SinkError),
    /// A tile does not fit the grid that the sink's layout asks for. The sink was not touched.
    Grid(GridTooCoarse),
    /// The plan is one of another model: it was made before an [update](super::Session::update), perhaps.
    Plan {
        /// The first part that differs.
        part: PartId,
        /// Its tiles and edges in the plan; 0 of each if there are none.
        planned: [usize; 2],
        /// Its tiles and edges in the model.
        stated: [usize; 2],
    },
    /// An internal error. The session cannot be used any more.
    Lost {
        /// The message of the panic.
        why: String,
    },
    /// The work was [cancelled](crate::control::Control::cancel).
    Cancelled,
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::View { view, why } => write!(f, "view {view}: {why}"),
            Self::Sink(error) => error.fmt(f),
            Self::Grid(error) => error.fmt(f),
            Self::Plan { part, planned: [tiles, edges], stated } => write!(
                f,
                "the plan is one of another model: part {} has {tiles} tiles and {edges} edges instead of {} and {}",
                part.0, stated[0], stated[1]
            ),
            Self::Lost { why } => write!(f, "an internal error ended the session: {why}"),
            Self::Cancelled => f.write_str("tessellating was cancelled"),
        }
    }
}

impl std::error::Error for FrameError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::View { why, .. } => Some(why),
            Self::Sink(error) => Some(error),
            Self::Grid(error) => Some(error),
            Self::Plan { .. } | Self::Lost { .. } | Self::Cancelled => None,
        }
    }
}

/// Why an instance was not added, moved or removed.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum InstanceError {
    /// There is no such part in the model.
    NoPart {
        /// The part.
        part: PartId,
        /// Number of parts.
        count: usize,
    },
    /// The instance was removed, or never was in this session.
    NoInstance {
        /// Its key.
        key: InstanceKey,
    },
    /// The transform is not a rigid motion with an optional uniform scale.
    Transform {
        /// Largest absolute entry of `MᵀM / scale² - 1`; NaN if the matrix is singular, or the transform not finite.
        error: f64,
    },
    /// An internal error ended the session.
    Lost {
        /// The message of the panic.
        why: String,
    },
}

impl fmt::Display for InstanceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoPart { part, count } => write!(f, "no part {}; the model has {count}", part.0),
            Self::NoInstance { key } => write!(f, "no instance {key:?}: it was removed, or never added"),
            Self::Transform { error } if error.is_nan() => f.write_str("the transform is singular or not finite"),
            Self::Transform { error } => {
                write!(f, "the transform is not a rigid motion with a uniform scale (off by {error:.1e})")
            }
            Self::Lost { why } => write!(f, "an internal error ended the session: {why}"),
        }
    }
}

impl std::error::Error for InstanceError {}

/// Why attributes were not set. Nothing changes.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum AttributeError {
    /// There is no such part in the model.
    NoPart {
        /// The part.
        part: PartId,
        /// Number of parts.
        count: usize,
    },
    /// The instance was removed, or never was in this session.
    NoInstance {
        /// Its key.
        key: InstanceKey,
    },
    /// A factor is not finite, or not above 0.
    Factor {
        /// The field.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A share of the colour is not from 0 to 1.
    Colour {
        /// The colour.
        colour: Colour,
    },
}

impl fmt::Display for AttributeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoPart { part, count } => write!(f, "no part {}; the model has {count}", part.0),
            Self::NoInstance { key } => write!(f, "no instance {key:?}: it was removed, or never added"),
            Self::Factor { name, value } => write!(f, "{name} is {value}; it must be finite and above 0"),
            Self::Colour { colour } => write!(f, "the colour is {colour:?}; its numbers must be from 0 to 1"),
        }
    }
}

impl std::error::Error for AttributeError {}
