//! Why the STEP reader refuses text, curves, bodies, placements and other instances.

use crate::model::{PartError, SplineError, SurfaceError};
use std::borrow::Cow;
use std::fmt;

/// Where the text of a STEP file breaks the syntax, and how.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}, column {column}: {what}")]
#[non_exhaustive]
pub struct SyntaxError {
    /// Line, counted from 1.
    pub line: usize,
    /// Column, counted from 1: a character of UTF-8.
    pub column: usize,
    /// What is wrong there.
    pub what: SyntaxFault,
}

/// How a text breaks the syntax.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SyntaxFault {
    /// No token starts with this character.
    #[error("no value or name starts with {found:?}")]
    Character {
        /// The character.
        found: char,
    },
    /// A string has no end.
    #[error("the string has no end")]
    UnterminatedString,
    /// A comment has no end.
    #[error("the comment has no end")]
    UnterminatedComment,
    /// A binary value is not hexadecimal.
    #[error("the binary value is not hexadecimal")]
    Binary,
    /// A number is out of range.
    #[error("the number is out of range")]
    Number,
    /// Something else is expected.
    #[error("{wanted} expected, {found} found")]
    Unexpected {
        /// What is expected.
        wanted: &'static str,
        /// The text that stands there, or its beginning.
        found: String,
    },
    /// Lists are nested too deeply.
    #[error("lists are nested more than {limit} deep")]
    Nesting {
        /// The most levels that are read.
        limit: usize,
    },
    /// An instance has too many types, or does not fit into 32 bits of addresses.
    #[error("the instance is too long")]
    TooLong,
    /// The text ends too early.
    #[error("the text ends here")]
    EndOfText,
    /// The header lacks an entity.
    #[error("the header has no {name}")]
    NotInHeader {
        /// Its type.
        name: &'static str,
    },
    /// An instance has the number of an earlier one.
    #[error("#{id} is the instance of line {first_line} already")]
    Repeated {
        /// The number.
        id: u64,
        /// Line of the earlier one, counted from 1.
        first_line: usize,
    },
}

/// What it took to read a text that breaks the rules. Nothing is lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SyntaxRepair {
    /// An empty value was read as unset.
    #[error("an empty value was read as unset ($)")]
    EmptyValue,
    /// An escape sequence was read as it is written.
    #[error("an escape sequence was read as it is written")]
    Escape,
    /// Hexadecimal digits in small letters were read.
    #[error("hexadecimal digits in small letters were read")]
    LowercaseHexadecimal,
    /// A missing semicolon in the header was added.
    #[error("a missing semicolon in the header was added")]
    Semicolon,
}

/// Why a curve of a file, or a point on one, cannot be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CurveTrouble {
    /// Both ends of an edge lie at the same parameter of its curve.
    #[error("both ends of the edge lie at the same parameter of its curve")]
    SameParameter,
    /// The curve's ends are in the wrong order.
    #[error("the curve's ends are in the wrong order")]
    WrongOrder,
    /// A bounded curve is needed, but the curve has no ends of its own.
    #[error("{keyword} has no ends of its own")]
    Endless {
        /// The curve's type.
        keyword: String,
    },
    /// A polyline has fewer than two distinct points, a circle has no radius, or a line is trimmed to no length.
    #[error("the curve is a single point")]
    OnePoint,
    /// A trim is neither a point nor a parameter.
    #[error("a trim is neither a point nor a parameter")]
    Trim,
    /// A point's parameter lies outside the domain of its curve or surface.
    #[error("a point at parameter {parameter} is outside the domain from {} to {}", .domain.0, .domain.1)]
    Beyond {
        /// The parameter.
        parameter: f64,
        /// First and last parameter.
        domain: (f64, f64),
    },
    /// A point or a trim is stated by its parameter on a composite curve, or on a polyline that repeats points; the
    /// reader does not keep these.
    #[error("parameters on composite curves and on polylines that repeat points are not read")]
    OnComposite,
    /// A line is extruded along itself.
    #[error("a line is extruded along itself")]
    AlongItself,
}

/// Why an offset, or the approximation of a curve or surface without exact form, fails.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitTrouble {
    /// The reference direction of an offset curve is parallel to its basis.
    #[error("the reference direction of the offset is parallel to its basis")]
    AlongBasis,
    /// The offset leaves nothing, or a point.
    #[error("an offset by {distance_mm} mm leaves {leaves}")]
    Vanishes {
        /// The offset's distance, millimetres.
        distance_mm: f64,
        /// What remains.
        leaves: &'static str,
    },
    /// The basis of an offset curve has a corner.
    #[error("the basis of the offset has a corner at its parameter {parameter}")]
    Corner {
        /// Parameter of the corner.
        parameter: f64,
    },
    /// An offset curve has no direction at some parameter.
    #[error("the offset curve has no direction somewhere")]
    NoDirection,
    /// The surface to offset has no normal at some point.
    #[error("the surface to offset has no normal somewhere")]
    NoNormal,
    /// The approximation misses the tolerance after refinement.
    #[error("{what} is still {error_mm:.2e} mm off after refinement")]
    Inexact {
        /// The approximation.
        what: &'static str,
        /// Its error, millimetres.
        error_mm: f64,
    },
    /// The approximation needs too many control points.
    #[error("the offset surface needs more than {limit} control points; allow a larger tolerance")]
    TooManyPoints {
        /// Maximum number of control points.
        limit: usize,
    },
}

/// Why bodies of a type are not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BodyRefusal {
    /// Its faces are intersections of surfaces, which are not computed.
    #[error("its faces are intersections of surfaces, which are not computed; export a boundary representation")]
    Intersects,
    /// It is unbounded.
    #[error("it is unbounded")]
    Unbounded,
    /// Its faces have no exact form.
    #[error("its faces have no exact form; export a boundary representation")]
    NotExact,
}

/// Why a primitive, a sweep or a triangulation of a file is not a solid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolidTrouble {
    /// A torus meets its own axis.
    #[error("a torus of radii {major_mm} and {minor_mm} mm meets its own axis")]
    Torus {
        /// Its major radius, millimetres.
        major_mm: f64,
        /// Its minor radius, millimetres.
        minor_mm: f64,
    },
    /// The top of a wedge is not shorter than its foot.
    #[error("a wedge is {foot_mm} mm long at its foot and {top_mm} mm, no less, at its top")]
    Wedge {
        /// Length of the foot, millimetres.
        foot_mm: f64,
        /// Length of the top, millimetres.
        top_mm: f64,
    },
    /// A side of a hexahedron is not planar.
    #[error("corners {corners:?} of the hexahedron are not in one plane")]
    SideNotPlane {
        /// The side's corners, by their numbers in the hexahedron.
        corners: [usize; 4],
    },
    /// A polyhedron has too few or too many corners.
    #[error("a {keyword} has {count} corners")]
    Corners {
        /// Its type.
        keyword: &'static str,
        /// How many corners it has.
        count: usize,
    },
    /// The swept face is not planar.
    #[error("the swept face is not planar")]
    ProfileNotPlane,
    /// The profile is extruded along its own plane.
    #[error("the profile is extruded along its own plane")]
    AlongProfile,
    /// The whole profile lies on its axis.
    #[error("the whole profile lies on its axis")]
    ProfileOnAxis,
    /// The axis is not in the plane of the profile.
    #[error("the axis is not in the plane of the profile")]
    AxisOffPlane,
    /// The profile lies on both sides of its axis.
    #[error("the profile lies on both sides of its axis")]
    AcrossAxis,
    /// Triangles refer to coordinates that do not exist.
    #[error("{count} triangles refer to coordinates that do not exist")]
    Triangles {
        /// How many triangles.
        count: usize,
    },
}

/// Why an occurrence of a file cannot be placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PlacementTrouble {
    /// The product definition to place is not in the file.
    #[error("the product definition to place is not in the file")]
    NoDefinition,
    /// The mapped representation has no bodies.
    #[error("the mapped representation #{representation} has no bodies")]
    NoBodies {
        /// The representation's entity number.
        representation: u64,
    },
    /// The transformation is not invertible.
    #[error("the transformation is not invertible")]
    NotInvertible,
}

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
