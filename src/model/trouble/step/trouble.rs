//! Why an instance of a STEP file cannot be read.

use super::curve::CurveTrouble;
use super::fit::FitTrouble;
use super::placement::PlacementTrouble;
use super::solid::{BodyRefusal, SolidTrouble};
use super::spline::SplineTrouble;
use crate::model::{PartError, SplineError, SurfaceError};
use std::borrow::Cow;
use std::fmt;

/// Why an instance of a STEP file cannot be read. Keywords are those of the file.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum StepTrouble {
    /// It is referred to and not in the file.
    NotInFile {
        /// Its number.
        entity: u64,
    },
    /// It is in another file, which is not read.
    Elsewhere {
        /// Its number.
        entity: u64,
        /// Where, as the file says.
        place: String,
    },
    /// An attribute is not what its type asks for.
    Attribute {
        /// The type that declares it.
        keyword: &'static str,
        /// Which attribute of that type, counted from 1.
        number: usize,
        /// What it should be.
        wanted: &'static str,
    },
    /// It is of a type that has no use where it is referred to.
    WrongType {
        /// Its type.
        keyword: String,
        /// What is needed there.
        wanted: &'static str,
    },
    /// It is of a type that the reader does not know.
    NotRead {
        /// What it stands for, in the plural.
        what: &'static str,
        /// Its type.
        keyword: String,
    },
    /// It is a body of a type that is not read.
    BodyNotRead {
        /// Its type.
        keyword: String,
        /// The operator of a boolean result, empty for others.
        operator: String,
        /// Why bodies of that type are not read.
        why: BodyRefusal,
    },
    /// Instances of its kind refer to one another too deeply, perhaps in a circle.
    TooDeep {
        /// What they stand for, in the plural.
        what: &'static str,
    },
    /// It refers to itself.
    RefersToItself {
        /// What it stands for.
        what: &'static str,
    },
    /// Something is missing, or has no length, direction or area.
    Missing {
        /// Of what.
        what: Cow<'static, str>,
        /// What is missing.
        part: &'static str,
    },
    /// Lists are not nested as they should be.
    Layout {
        /// What they list, in the plural.
        what: &'static str,
        /// What they should be.
        wanted: &'static str,
    },
    /// A number is infinite or NaN.
    NotFinite {
        /// What it measures.
        what: &'static str,
    },
    /// A number is out of its range.
    Measure {
        /// What it measures.
        what: Cow<'static, str>,
        /// The number.
        value: f64,
        /// Its unit, empty if none.
        unit: &'static str,
    },
    /// A cone without apex, or without slant.
    Cone {
        /// Its radius, millimetres.
        radius_mm: f64,
        /// Its half angle, in the file's unit.
        half_angle: f64,
    },
    /// A trim of a surface that leaves nothing of it.
    SurfaceTrim {
        /// First and second parameter.
        range: (f64, f64),
        /// Whether it lies beyond the surface.
        beyond: bool,
    },
    /// A closed profile meets its axis, and the face's boundary does not tell which sheet it bounds.
    Sheets {
        /// How many sheets the surface has.
        sheets: usize,
    },
    /// A surface without ends, and no bounds.
    Unbounded,
    /// The parameters of a surface that is turned over or a replica.
    ReplicaParameters,
    /// Something that it needs was not read, which is told there.
    Unread {
        /// What.
        what: &'static str,
    },
    /// It states no surface, and its bounds enclose no plane area.
    NoPlane,
    /// A B-spline.
    Spline(SplineTrouble),
    /// A curve, or a point on one.
    Curve(CurveTrouble),
    /// An offset or an approximation.
    Fit(FitTrouble),
    /// A body without stated faces.
    Solid(SolidTrouble),
    /// An occurrence.
    Placement(PlacementTrouble),
    /// The curve that it makes is unsound.
    UnsoundCurve(SplineError),
    /// The surface that it makes is unsound.
    UnsoundSurface(SurfaceError),
    /// The part that it makes is unsound.
    UnsoundPart(PartError),
}

codes!(StepTrouble {
    Self::NotInFile { .. } => "step-not-in-file",
    Self::Elsewhere { .. } => "step-in-another-file",
    Self::Attribute { .. } => "step-attribute",
    Self::WrongType { .. } => "step-wrong-type",
    Self::NotRead { .. } => "step-type-not-read",
    Self::BodyNotRead { .. } => "step-body-not-read",
    Self::TooDeep { .. } => "step-too-deep",
    Self::RefersToItself { .. } => "step-refers-to-itself",
    Self::Missing { .. } => "step-missing",
    Self::Layout { .. } => "step-layout",
    Self::NotFinite { .. } => "step-not-finite",
    Self::Measure { .. } => "step-measure",
    Self::Cone { .. } => "step-cone",
    Self::SurfaceTrim { .. } => "step-surface-trim",
    Self::Sheets { .. } => "step-sheets",
    Self::Unbounded => "step-unbounded",
    Self::ReplicaParameters => "step-replica-parameters",
    Self::Unread { .. } => "step-not-read",
    Self::NoPlane => "step-no-plane",
    Self::Spline(_) => "step-spline",
    Self::Curve(_) => "step-curve",
    Self::Fit(_) => "step-fit",
    Self::Solid(_) => "step-solid",
    Self::Placement(_) => "step-placement",
    Self::UnsoundCurve(_) => "step-unsound-curve",
    Self::UnsoundSurface(_) => "step-unsound-surface",
    Self::UnsoundPart(_) => "step-unsound-part"
});

impl fmt::Display for StepTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotInFile { entity } => write!(f, "#{entity} is referred to but not in the file"),
            Self::Elsewhere { entity, place } => {
                write!(f, "#{entity} is in another file, {place}, which is not read")
            }
            Self::Attribute { keyword, number, wanted } => {
                write!(f, "attribute {number} of {keyword} should be {wanted}")
            }
            Self::WrongType { keyword, wanted } => write!(f, "{keyword} where {wanted} is needed"),
            Self::NotRead { what, keyword } => write!(f, "{what} of type {keyword} are not read"),
            Self::BodyNotRead { keyword, operator, why } => {
                write!(f, "the body of type {keyword}")?;
                if !operator.is_empty() {
                    write!(f, " ({operator})")?;
                }
                write!(f, " is not read: {why}")
            }
            Self::TooDeep { what } => write!(f, "{what} refer to one another too deeply"),
            Self::RefersToItself { what } => write!(f, "{what} refers to itself"),
            Self::Missing { what, part } => write!(f, "{what} without {part}"),
            Self::Layout { what, wanted } => write!(f, "{what} that are no {wanted}"),
            Self::NotFinite { what } => write!(f, "{what} is not finite"),
            Self::Measure { what, value, unit: "" } => write!(f, "{what} of {value}"),
            Self::Measure { what, value, unit } => write!(f, "{what} of {value} {unit}"),
            Self::Cone { radius_mm, half_angle } => {
                write!(f, "a cone of radius {radius_mm} mm and half angle {half_angle}")
            }
            Self::SurfaceTrim { range: (first, second), beyond } => {
                write!(f, "a trim from {first} to {second}{}", if *beyond { ", beyond the surface" } else { "" })
            }
            Self::Sheets { sheets } => write!(
                f,
                "the turned curve is closed and meets its axis: the face's boundary does not tell which of its {sheets} sheets it \
                 bounds"
            ),
            Self::Unbounded => write!(f, "no bounds on a surface that has none of its own"),
            Self::ReplicaParameters => {
                write!(f, "the parameters of a surface that is turned over or a replica are not used")
            }
            Self::Unread { what } => write!(f, "{what} was not read"),
            Self::NoPlane => write!(f, "it states no surface, and its bounds enclose no plane area"),
            Self::Spline(spline) => spline.fmt(f),
            Self::Curve(curve) => curve.fmt(f),
            Self::Fit(fit) => fit.fmt(f),
            Self::Solid(solid) => solid.fmt(f),
            Self::Placement(placement) => placement.fmt(f),
            Self::UnsoundCurve(error) => error.fmt(f),
            Self::UnsoundSurface(error) => error.fmt(f),
            Self::UnsoundPart(error) => error.fmt(f),
        }
    }
}

/// `From` for what a trouble may be made of.
macro_rules! from {
    ($($variant:ident($inner:ident)),*) => {
        $(impl From<$inner> for StepTrouble {
            fn from(inner: $inner) -> Self {
                Self::$variant(inner)
            }
        })*
    };
}
from!(
    Spline(SplineTrouble),
    Curve(CurveTrouble),
    Fit(FitTrouble),
    Solid(SolidTrouble),
    Placement(PlacementTrouble),
    UnsoundCurve(SplineError),
    UnsoundSurface(SurfaceError),
    UnsoundPart(PartError)
);

/// Which instance of a STEP file is at fault, and why it cannot be read.
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
