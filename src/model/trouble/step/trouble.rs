//! Why an instance of a STEP file cannot be read.

use super::curve::CurveTrouble;
use super::fit::FitTrouble;
use super::placement::PlacementTrouble;
use super::solid::{BodyRefusal, SolidTrouble};
use crate::model::{PartError, SplineError, SurfaceError};
use std::borrow::Cow;
use std::fmt;

/// Why an instance of a STEP file cannot be read. Keywords are the file's.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StepTrouble {
    /// A referenced instance is not in the file.
    #[error("#{entity} is referred to but not in the file")]
    NotInFile {
        /// Its number.
        entity: u64,
    },
    /// A referenced instance is in another file, which is not read.
    #[error("#{entity} is in another file, {place}, which is not read")]
    Elsewhere {
        /// Its number.
        entity: u64,
        /// The other file, as stated.
        place: String,
    },
    /// An attribute does not have the required form.
    #[error("attribute {number} of {keyword} should be {wanted}")]
    Attribute {
        /// The type that declares it.
        keyword: &'static str,
        /// Number of the attribute in that type, from 1.
        number: usize,
        /// The required form.
        wanted: &'static str,
    },
    /// An instance of another type is needed here.
    #[error("{keyword} where {wanted} is needed")]
    WrongType {
        /// Its type.
        keyword: String,
        /// What is needed.
        wanted: &'static str,
    },
    /// The reader does not support its type.
    #[error("{what} of type {keyword} are not read")]
    NotRead {
        /// What it represents, in the plural.
        what: &'static str,
        /// Its type.
        keyword: String,
    },
    /// The reader does not support bodies of its type.
    #[error("the body of type {keyword}{} is not read: {why}", in_brackets(.operator))]
    BodyNotRead {
        /// Its type.
        keyword: String,
        /// The operator of a boolean result, else empty.
        operator: String,
        /// Why bodies of its type are not read.
        why: BodyRefusal,
    },
    /// References between instances of its kind are nested too deeply, perhaps in a circle.
    #[error("{what} refer to each other too deeply")]
    TooDeep {
        /// What the instances represent, in the plural.
        what: &'static str,
    },
    /// Lists of lists name shared items too often.
    #[error("{what} are listed more than {limit} times, by lists of lists; the limit for a file of its size")]
    TooManyVisits {
        /// What the items are, in the plural.
        what: &'static str,
        /// The limit: the bytes of the file, and a constant.
        limit: usize,
    },
    /// It refers to itself.
    #[error("{what} refers to itself")]
    RefersToItself {
        /// What it represents.
        what: &'static str,
    },
    /// Something is missing, or has no length, direction or area.
    #[error("{what} without {part}")]
    Missing {
        /// What is incomplete.
        what: Cow<'static, str>,
        /// What is missing.
        part: &'static str,
    },
    /// Lists are nested in the wrong way, or do not have the same length.
    #[error("{what} are not {wanted}")]
    Layout {
        /// What they list, in the plural.
        what: &'static str,
        /// The required nesting or length.
        wanted: &'static str,
    },
    /// A number is infinite or NaN.
    #[error("{what} is not finite")]
    NotFinite {
        /// What it measures.
        what: &'static str,
    },
    /// A number is out of range.
    #[error("{what} of {value}{}{unit} is out of range", if .unit.is_empty() { "" } else { " " })]
    Measure {
        /// What it measures.
        what: Cow<'static, str>,
        /// The number.
        value: f64,
        /// Its unit, empty if none.
        unit: &'static str,
    },
    /// A cone has no apex or no slant.
    #[error("a cone of radius {radius_mm} mm and half angle {half_angle} has no apex or no slant")]
    Cone {
        /// Its radius, millimetres.
        radius_mm: f64,
        /// Its half angle, in the file's unit.
        half_angle: f64,
    },
    /// A trim leaves nothing of its surface.
    #[error(
        "a trim from {} to {}{} leaves nothing of the surface",
        .range.0, .range.1, if *.beyond { ", outside the surface," } else { "" }
    )]
    SurfaceTrim {
        /// First and second parameter.
        range: (f64, f64),
        /// Whether it lies outside the surface.
        beyond: bool,
    },
    /// An unbounded surface has no bounds.
    #[error("an unbounded surface has no bounds")]
    Unbounded,
    /// The parameters of a flipped surface or a replica are needed; the reader does not keep them.
    #[error("the parameters of flipped surfaces and replicas are not read")]
    ReplicaParameters,
    /// Something that it needs was not read; another diagnostic reports why.
    #[error("{what} was not read")]
    Unread {
        /// What was not read.
        what: &'static str,
    },
    /// A face has no surface, and its bounds enclose no planar area.
    #[error("the face has no surface, and its bounds enclose no planar area")]
    NoPlane,
    /// A B-spline, stated or derived, is invalid.
    #[error(transparent)]
    Spline(#[from] SplineError),
    /// A curve, or a point on one, cannot be read.
    #[error(transparent)]
    Curve(#[from] CurveTrouble),
    /// An offset or an approximation fails.
    #[error(transparent)]
    Fit(#[from] FitTrouble),
    /// A body without explicit faces is not a solid.
    #[error(transparent)]
    Solid(#[from] SolidTrouble),
    /// An occurrence cannot be placed.
    #[error(transparent)]
    Placement(#[from] PlacementTrouble),
    /// The resulting surface is invalid.
    #[error(transparent)]
    UnsoundSurface(#[from] SurfaceError),
    /// The resulting part is invalid.
    #[error(transparent)]
    UnsoundPart(#[from] PartError),
}

/// ` (word)`, or nothing for no word.
fn in_brackets(word: &str) -> String {
    if word.is_empty() { String::new() } else { format!(" ({word})") }
}

codes!(StepTrouble {
    Self::NotInFile { .. } => "step-not-in-file",
    Self::Elsewhere { .. } => "step-in-another-file",
    Self::Attribute { .. } => "step-attribute",
    Self::WrongType { .. } => "step-wrong-type",
    Self::NotRead { .. } => "step-type-not-read",
    Self::BodyNotRead { .. } => "step-body-not-read",
    Self::TooDeep { .. } => "step-too-deep",
    Self::TooManyVisits { .. } => "step-too-many-visits",
    Self::RefersToItself { .. } => "step-refers-to-itself",
    Self::Missing { .. } => "step-missing",
    Self::Layout { .. } => "step-layout",
    Self::NotFinite { .. } => "step-not-finite",
    Self::Measure { .. } => "step-measure",
    Self::Cone { .. } => "step-cone",
    Self::SurfaceTrim { .. } => "step-surface-trim",
    Self::Unbounded => "step-unbounded",
    Self::ReplicaParameters => "step-replica-parameters",
    Self::Unread { .. } => "step-not-read",
    Self::NoPlane => "step-no-plane",
    Self::Spline(_) => "step-spline",
    Self::Curve(_) => "step-curve",
    Self::Fit(_) => "step-fit",
    Self::Solid(_) => "step-solid",
    Self::Placement(_) => "step-placement",
    Self::UnsoundSurface(_) => "step-unsound-surface",
    Self::UnsoundPart(_) => "step-unsound-part"
});

/// The faulty instance of a STEP file, and why it cannot be read.
#[derive(Clone, Debug, PartialEq)]
pub struct StepCause {
    /// The instance's number; `None` if it is the diagnostic's own.
    pub entity: Option<u64>,
    /// Why it cannot be read.
    pub trouble: Box<StepTrouble>,
}

impl fmt::Display for StepCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(entity) = self.entity {
            write!(f, "#{entity}: ")?;
        }
        self.trouble.fmt(f)
    }
}
