//! What the STEP reader left out, repaired or reinterpreted.

use super::syntax::{SyntaxError, SyntaxRepair};
use super::trouble::{StepCause, StepTrouble};
use crate::model::PartError;
use std::collections::BTreeMap;
use std::fmt;

/// Text that was removed because it breaks the syntax.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SyntaxCut {
    /// An instance, by its number with the `#`.
    Instance(String),
    /// The header.
    Header,
    /// What is no instance, up to the next one.
    Text,
    /// The end of a section, behind which its instances go on.
    SectionEnd,
    /// The incomplete end.
    End,
}

/// What the STEP reader left out, repaired or reinterpreted.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum StepOutcome {
    /// An instance was left out.
    LeftOut(StepTrouble),
    /// A signature was not verified.
    Signature,
    /// Sections were skipped.
    Sections {
        /// Their names.
        names: Vec<String>,
    },
    /// The file refers to instances of other files, which are not read.
    ForeignInstances {
        /// How many.
        count: usize,
    },
    /// Values defined outside the data sections were read as unset.
    ForeignValues {
        /// How many.
        count: usize,
        /// Their notation.
        form: &'static str,
    },
    /// The parser repaired the syntax.
    SyntaxRepaired {
        /// Line, counted from 1.
        line: usize,
        /// Column, counted from 1: a character of UTF-8.
        column: usize,
        /// The repair.
        repair: SyntaxRepair,
    },
    /// The parser repaired the syntax in more places than are listed.
    MoreRepairs {
        /// How many.
        count: usize,
    },
    /// Text that breaks the syntax was left out.
    SyntaxCut {
        /// Where, and how.
        error: SyntaxError,
        /// What was left out.
        cut: SyntaxCut,
    },
    /// Text after the end of the STEP file was left out.
    BehindEnd,
    /// Several data sections were read as one.
    DataSections,
    /// The file names no length unit; millimetres were assumed.
    NoUnit,
    /// A length unit is too large or too small; millimetres were assumed.
    UnitOutOfRange {
        /// The unit, millimetres.
        unit_mm: f64,
    },
    /// Colours stated for paths of occurrences are not applied.
    PathColours {
        /// How many.
        count: usize,
    },
    /// Bodies, shells and faces that the file hides are read like the others.
    Hidden {
        /// How many.
        items: usize,
    },
    /// The file has no faces.
    NoFaces {
        /// How many instances the file has.
        instances: usize,
    },
    /// A supplemental surface without bounds was left out.
    Endless {
        /// Its type.
        keyword: String,
    },
    /// Supplemental geometry was left out or has no faces.
    Supplemental {
        /// Whether it was left out by option; else it has no faces.
        left_out: bool,
        /// How many items of each type.
        counts: BTreeMap<String, usize>,
    },
    /// An assembly contains itself; that occurrence was left out.
    AssemblyCycle {
        /// The assembly's name.
        assembly: String,
    },
    /// Tessellated items repeat exact geometry and were left out.
    Repeated {
        /// How many.
        items: usize,
        /// The name of the repeated geometry.
        name: String,
    },
    /// Shells list faces again, which were left out.
    FacesAgain {
        /// How many.
        faces: usize,
    },
    /// The loops of a face list uses of edges again, which were left out.
    EdgesAgain {
        /// How many.
        uses: usize,
    },
    /// A part is so far from the origin that its coordinates were made relative to its centre; its instances place it.
    FarPart {
        /// Distance of its centre, millimetres.
        distance_mm: f64,
        /// Diagonal of its box, millimetres.
        size_mm: f64,
    },
    /// An occurrence has no transformation and is placed at the origin.
    AtOrigin,
    /// An occurrence was left out.
    OccurrenceLeftOut(StepCause),
    /// A face was left out.
    FaceLeftOut(StepCause),
    /// A body was left out.
    BodyLeftOut(StepCause),
    /// Something was left out of a body.
    LeftOutOfBody(StepCause),
    /// An inner loop was left out and its hole closed.
    LoopLeftOut(StepCause),
    /// An edge's curve was not read; the edge became straight.
    EdgeStraightened(StepCause),
    /// Every loop uses an edge against its direction: its vertices were swapped.
    VerticesExchanged,
    /// Edges of a loop ran against it and were reversed.
    EdgesTurned,
    /// A loop of edges without length was left out.
    LoopWithoutLength,
    /// An offset surface was approximated.
    Approximated {
        /// Largest error of the approximation, millimetres.
        error_mm: f64,
    },
    /// A half angle is out of range in the file's unit and was read as degrees.
    Degrees {
        /// The angle as stated.
        half_angle: f64,
    },
    /// A trim extends beyond its surface and was clipped.
    TrimBeyond {
        /// First and second parameter.
        range: (f64, f64),
    },
    /// A face has no surface, and its bounds lie off their best-fit plane.
    ImpliedPlane {
        /// Largest distance, millimetres.
        gap_mm: f64,
    },
    /// An edge misses its vertex; its curve was pulled to the vertex.
    EdgePulled {
        /// Distance between them, millimetres.
        gap_mm: f64,
    },
    /// The only vertex of a closed edge lay off the edge's curve and was moved onto it.
    VertexMoved {
        /// Distance between them, millimetres.
        gap_mm: f64,
    },
    /// Edges miss their vertices.
    EdgesOffVertices {
        /// How many.
        edges: usize,
        /// Largest distance, millimetres.
        gap_mm: f64,
    },
    /// The part as read is invalid.
    PartUnsound(PartError),
}

codes!(StepOutcome {
    Self::Signature => "step-signature",
    Self::Sections { .. } => "step-sections-skipped",
    Self::ForeignInstances { .. } => "step-foreign-instances",
    Self::ForeignValues { .. } => "step-foreign-values",
    Self::SyntaxRepaired { .. } => "step-syntax-repaired",
    Self::MoreRepairs { .. } => "step-more-syntax-repairs",
    Self::SyntaxCut { .. } => "step-syntax-cut",
    Self::BehindEnd => "step-text-behind-end",
    Self::DataSections => "step-data-sections-joined",
    Self::NoUnit => "step-no-unit",
    Self::UnitOutOfRange { .. } => "step-unit-out-of-range",
    Self::PathColours { .. } => "step-path-colours",
    Self::Hidden { .. } => "step-hidden-items",
    Self::NoFaces { .. } => "step-no-faces",
    Self::Endless { .. } => "step-surface-without-bounds",
    Self::Supplemental { .. } => "step-supplemental",
    Self::AssemblyCycle { .. } => "step-assembly-cycle",
    Self::Repeated { .. } => "step-repeated-geometry",
    Self::FacesAgain { .. } => "step-faces-listed-again",
    Self::EdgesAgain { .. } => "step-edges-listed-again",
    Self::FarPart { .. } => "step-part-far",
    Self::AtOrigin => "step-occurrence-at-origin",
    Self::OccurrenceLeftOut(_) => "step-occurrence-left-out",
    Self::FaceLeftOut(_) => "step-face-left-out",
    Self::BodyLeftOut(_) => "step-body-left-out",
    Self::LeftOutOfBody(_) => "step-left-out-of-body",
    Self::LoopLeftOut(_) => "step-loop-left-out",
    Self::EdgeStraightened(_) => "step-edge-straightened",
    Self::VerticesExchanged => "step-vertices-exchanged",
    Self::EdgesTurned => "step-edges-turned",
    Self::LoopWithoutLength => "step-loop-without-length",
    Self::Approximated { .. } => "step-offset-approximated",
    Self::Degrees { .. } => "step-angle-in-degrees",
    Self::TrimBeyond { .. } => "step-trim-beyond-surface",
    Self::ImpliedPlane { .. } => "step-implied-plane",
    Self::EdgePulled { .. } => "step-edge-pulled",
    Self::VertexMoved { .. } => "step-vertex-moved",
    Self::EdgesOffVertices { .. } => "step-edges-off-vertices",
    Self::PartUnsound(_) => "step-part-unsound";
    StepTrouble in Self::LeftOut(trouble) => trouble
});

impl StepOutcome {
    /// Why an instance was not read, if that is the outcome.
    #[must_use]
    pub fn trouble(&self) -> Option<&StepTrouble> {
        match self {
            Self::LeftOut(trouble) => Some(trouble),
            Self::OccurrenceLeftOut(cause)
            | Self::FaceLeftOut(cause)
            | Self::BodyLeftOut(cause)
            | Self::LeftOutOfBody(cause)
            | Self::LoopLeftOut(cause)
            | Self::EdgeStraightened(cause) => Some(&cause.trouble),
            _ => None,
        }
    }
}

impl fmt::Display for StepOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LeftOut(trouble) => trouble.fmt(f),
            Self::Signature => write!(f, "a signature was not verified"),
            Self::Sections { names } => write!(f, "sections skipped: {}", names.join(", ")),
            Self::ForeignInstances { count } => {
                write!(f, "{count} instances of other files are referred to; they are not read")
            }
            Self::ForeignValues { count, form } => {
                write!(f, "{count} values defined elsewhere ({form}) were read as unset")
            }
            Self::SyntaxRepaired { line, column, repair } => write!(f, "line {line}, column {column}: {repair}"),
            Self::MoreRepairs { count } => write!(f, "{count} more repairs of the syntax"),
            Self::SyntaxCut { error, cut } => match cut {
                SyntaxCut::Instance(number) => write!(f, "{error}; instance {number} was left out"),
                SyntaxCut::Header => write!(f, "{error}; the header was left out"),
                SyntaxCut::Text => write!(f, "{error}; the text up to the next instance was left out"),
                SyntaxCut::SectionEnd => write!(f, "{error}; the end of the section before it was passed over"),
                SyntaxCut::End => write!(f, "{error}; the incomplete end was left out"),
            },
            Self::BehindEnd => write!(f, "text after the end of the STEP file was left out"),
            Self::DataSections => write!(f, "data sections were read as one, without their names"),
            Self::NoUnit => write!(f, "the file states no length unit; millimetres assumed"),
            Self::UnitOutOfRange { unit_mm } => {
                write!(f, "a length unit of {unit_mm:e} mm is out of range; millimetres assumed")
            }
            Self::PathColours { count } => {
                write!(f, "{count} colours for paths of occurrences are not applied")
            }
            Self::Hidden { items } => {
                write!(f, "{items} bodies, shells or faces are hidden in the file; they are read")
            }
            Self::NoFaces { instances } => write!(f, "no faces among the file's {instances} instances"),
            Self::Endless { keyword } => write!(f, "a {keyword} without bounds cannot be meshed and was left out"),
            Self::Supplemental { left_out, counts } => {
                let counts: Vec<String> = counts.iter().map(|(keyword, count)| format!("{count} {keyword}")).collect();
                let why = if *left_out { "was left out (see --supplemental)" } else { "has no faces" };
                write!(f, "supplemental geometry {why}: {}", counts.join(", "))
            }
            Self::AssemblyCycle { assembly } => {
                write!(f, "assembly '{assembly}' contains itself; the inner occurrence was left out")
            }
            Self::Repeated { items, name } => {
                write!(f, "{items} tessellated items of '{name}' repeat its exact geometry and were left out")
            }
            Self::FacesAgain { faces } => {
                write!(f, "{faces} faces that shells list again were left out; this is the first such shell")
            }
            Self::EdgesAgain { uses } => write!(f, "its loops list {uses} uses of edges again, which were left out"),
            Self::FarPart { distance_mm, size_mm } => write!(
                f,
                "the part is {distance_mm:.3e} mm from the origin and {size_mm:.3e} mm across; its coordinates are \
                 relative to its centre"
            ),
            Self::AtOrigin => write!(f, "an occurrence without transformation is placed at the origin"),
            Self::OccurrenceLeftOut(cause) => write!(f, "an occurrence was left out: {cause}"),
            Self::FaceLeftOut(cause) => write!(f, "face left out: {cause}"),
            Self::BodyLeftOut(cause) => write!(f, "body left out: {cause}"),
            Self::LeftOutOfBody(cause) => write!(f, "left out of the body: {cause}"),
            Self::LoopLeftOut(cause) => write!(f, "an inner loop was left out and its hole closed: {cause}"),
            Self::EdgeStraightened(cause) => {
                write!(f, "an edge's curve was not read; the edge became straight: {cause}")
            }
            Self::VerticesExchanged => {
                write!(f, "every loop uses the edge against its direction: swapping its vertices made it the other arc")
            }
            Self::EdgesTurned => write!(f, "edges of a loop ran against it and were reversed"),
            Self::LoopWithoutLength => write!(f, "a loop of edges without length was left out"),
            Self::Approximated { error_mm } => write!(f, "offset surface approximated within {error_mm:.2e} mm"),
            Self::Degrees { half_angle } => {
                write!(f, "a half angle of {half_angle} is out of range in the file's unit and was read as degrees")
            }
            Self::TrimBeyond { range: (first, second) } => {
                write!(f, "a trim from {first} to {second} extends beyond the surface and was clipped")
            }
            Self::ImpliedPlane { gap_mm } => {
                write!(f, "the face has no surface; its bounds lie up to {gap_mm:.3e} mm off their plane")
            }
            Self::EdgePulled { gap_mm } => {
                write!(f, "an edge misses its vertex by {gap_mm:.3e} mm; its curve was pulled to the vertex")
            }
            Self::VertexMoved { gap_mm } => {
                write!(f, "the only vertex of a closed edge lies {gap_mm:.3e} mm off its curve and was moved onto it")
            }
            Self::EdgesOffVertices { edges, gap_mm } => {
                write!(f, "{edges} edges miss their vertices, this one by {gap_mm:.3e} mm")
            }
            Self::PartUnsound(error) => write!(f, "the part as read is invalid: {error}"),
        }
    }
}
