//! What the STEP reader left out, repaired or reinterpreted.

use super::step::{StepCause, StepTrouble, SyntaxError, SyntaxRepair};
use crate::model::PartError;
use std::collections::BTreeMap;

/// Text that was removed because it breaks the syntax.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SyntaxCut {
    /// An instance, by its number with the `#`.
    #[error("instance {0} was left out")]
    Instance(String),
    /// The header.
    #[error("the header was left out")]
    Header,
    /// What is no instance, up to the next one.
    #[error("the text up to the next instance was left out")]
    Text,
    /// The end of a section, behind which its instances go on.
    #[error("the end of the section before it was passed over")]
    SectionEnd,
    /// The incomplete end.
    #[error("the incomplete end was left out")]
    End,
}

/// What the STEP reader left out, repaired or reinterpreted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StepOutcome {
    /// An instance was left out.
    #[error(transparent)]
    LeftOut(StepTrouble),
    /// A signature was not verified.
    #[error("a signature was not verified")]
    Signature,
    /// Sections were skipped.
    #[error("sections skipped: {}", .names.join(", "))]
    Sections {
        /// Their names.
        names: Vec<String>,
    },
    /// The file refers to instances of other files, which are not read.
    #[error("{count} instances of other files are referred to; they are not read")]
    ForeignInstances {
        /// How many.
        count: usize,
    },
    /// The file names other STEP files as documents, as assemblies do for components without a shape. They are not
    /// read.
    #[error("{count} other STEP files are referred to; they are not read: {}", names(.first, *.count))]
    ForeignFiles {
        /// How many.
        count: usize,
        /// Names of the first ones, sorted.
        first: Vec<String>,
    },
    /// Values defined outside the data sections were read as unset.
    #[error("{count} values defined elsewhere ({form}) were read as unset")]
    ForeignValues {
        /// How many.
        count: usize,
        /// Their notation.
        form: &'static str,
    },
    /// The parser repaired the syntax.
    #[error("line {line}, column {column}: {repair}")]
    SyntaxRepaired {
        /// Line, counted from 1.
        line: usize,
        /// Column, counted from 1: a character of UTF-8.
        column: usize,
        /// The repair.
        repair: SyntaxRepair,
    },
    /// The parser repaired the syntax in more places than are listed.
    #[error("{count} more repairs of the syntax")]
    MoreRepairs {
        /// How many.
        count: usize,
    },
    /// Text that breaks the syntax was left out.
    #[error("{error}; {cut}")]
    SyntaxCut {
        /// Where, and how.
        error: SyntaxError,
        /// What was left out.
        cut: SyntaxCut,
    },
    /// Text after the end of the STEP file was left out.
    #[error("text after the end of the STEP file was left out")]
    BehindEnd,
    /// Several data sections were read as one.
    #[error("data sections were read as one, without their names")]
    DataSections,
    /// The file names no length unit; millimetres were assumed.
    #[error("the file states no length unit; millimetres assumed")]
    NoUnit,
    /// A length unit is too large or too small; millimetres were assumed.
    #[error("a length unit of {unit_mm:e} mm is out of range; millimetres assumed")]
    UnitOutOfRange {
        /// The unit, millimetres.
        unit_mm: f64,
    },
    /// A unit of lengths or angles cannot be read; millimetres or radians were assumed.
    #[error("a unit of lengths or angles cannot be read; millimetres or radians assumed")]
    UnitNotRead,
    /// Colours stated for paths of occurrences are not applied.
    #[error("{count} colours for paths of occurrences are not applied")]
    PathColours {
        /// How many.
        count: usize,
    },
    /// Bodies, shells and faces that the file hides are read like the others.
    #[error("{items} bodies, shells or faces are hidden in the file; they are read")]
    Hidden {
        /// How many.
        items: usize,
    },
    /// The file has no faces.
    #[error("no faces among the file's {instances} instances")]
    NoFaces {
        /// How many instances the file has.
        instances: usize,
    },
    /// A supplemental surface without bounds was left out.
    #[error("a {keyword} without bounds cannot be meshed and was left out")]
    Endless {
        /// Its type.
        keyword: String,
    },
    /// Supplemental geometry was left out or has no faces.
    #[error("supplemental geometry {}", supplemental(*.left_out, .counts))]
    Supplemental {
        /// Whether it was left out by option; else it has no faces.
        left_out: bool,
        /// How many items of each type.
        counts: BTreeMap<String, usize>,
    },
    /// An assembly contains itself; that occurrence was left out.
    #[error("assembly '{assembly}' contains itself; the inner occurrence was left out")]
    AssemblyCycle {
        /// The assembly's name.
        assembly: String,
    },
    /// Tessellated items repeat exact geometry and were left out.
    #[error("{items} tessellated items of '{name}' repeat its exact geometry and were left out")]
    Repeated {
        /// How many.
        items: usize,
        /// The name of the repeated geometry.
        name: String,
    },
    /// Shells list faces again, which were left out.
    #[error("{faces} faces that shells list again were left out; this is the first such shell")]
    FacesAgain {
        /// How many.
        faces: usize,
    },
    /// Faces that belong to no shape copy faces of shapes. They were left out, and gave these their colours.
    #[error("{faces} faces that belong to no shape were left out: they copy faces of shapes, which got their colours")]
    FacesCopied {
        /// How many.
        faces: usize,
    },
    /// The loops of a face list uses of edges again, which were left out.
    #[error("its loops list {uses} uses of edges again, which were left out")]
    EdgesAgain {
        /// How many.
        uses: usize,
    },
    /// A part is so far from the origin that its coordinates were made relative to its centre; its instances place it.
    #[error(
        "the part is {distance_mm:.3e} mm from the origin and {size_mm:.3e} mm across; its coordinates are relative to \
         its centre"
    )]
    FarPart {
        /// Distance of its centre, millimetres.
        distance_mm: f64,
        /// Diagonal of its box, millimetres.
        size_mm: f64,
    },
    /// An occurrence has no transformation and is placed at the origin.
    #[error("an occurrence without transformation is placed at the origin")]
    AtOrigin,
    /// An occurrence was left out.
    #[error("an occurrence was left out: {0}")]
    OccurrenceLeftOut(StepCause),
    /// A face was left out.
    #[error("face left out: {0}")]
    FaceLeftOut(StepCause),
    /// A body was left out.
    #[error("body left out: {0}")]
    BodyLeftOut(StepCause),
    /// Something was left out of a body.
    #[error("left out of the body: {0}")]
    LeftOutOfBody(StepCause),
    /// An inner loop was left out and its hole closed.
    #[error("an inner loop was left out and its hole closed: {0}")]
    LoopLeftOut(StepCause),
    /// An edge's curve was not read; the edge became straight.
    #[error("an edge's curve was not read; the edge became straight: {0}")]
    EdgeStraightened(StepCause),
    /// Every loop uses an edge against its direction: its vertices were swapped.
    #[error("every loop uses the edge against its direction: swapping its vertices made it the other arc")]
    VerticesExchanged,
    /// Edges of a loop ran against it and were reversed.
    #[error("edges of a loop ran against it and were reversed")]
    EdgesTurned,
    /// A loop of edges without length was left out.
    #[error("a loop of edges without length was left out")]
    LoopWithoutLength,
    /// An offset surface was approximated.
    #[error("offset surface approximated within {error_mm:.2e} mm")]
    Approximated {
        /// Largest error of the approximation, millimetres.
        error_mm: f64,
    },
    /// A half angle is out of range in the file's unit and was read as degrees.
    #[error("a half angle of {half_angle} is out of range in the file's unit and was read as degrees")]
    Degrees {
        /// The angle as stated.
        half_angle: f64,
    },
    /// A trim extends beyond its surface and was clipped.
    #[error("a trim from {} to {} extends beyond the surface and was clipped", .range.0, .range.1)]
    TrimBeyond {
        /// First and second parameter.
        range: (f64, f64),
    },
    /// A face has no surface, and its bounds lie off their best-fit plane.
    #[error("the face has no surface; its bounds lie up to {gap_mm:.3e} mm off their plane")]
    ImpliedPlane {
        /// Largest distance, millimetres.
        gap_mm: f64,
    },
    /// An edge misses its vertex; its curve was pulled to the vertex.
    #[error("an edge misses its vertex by {gap_mm:.3e} mm; its curve was pulled to the vertex")]
    EdgePulled {
        /// Distance between them, millimetres.
        gap_mm: f64,
    },
    /// A vertex of a closed edge lay off the end of the edge's curve and was moved there.
    #[error("a vertex of a closed edge lies {gap_mm:.3e} mm off the end of its curve and was moved there")]
    VertexMoved {
        /// The largest distance between them, millimetres.
        gap_mm: f64,
    },
    /// Edges miss their vertices.
    #[error("{edges} edges miss their vertices, this one by {gap_mm:.3e} mm")]
    EdgesOffVertices {
        /// How many.
        edges: usize,
        /// Largest distance, millimetres.
        gap_mm: f64,
    },
    /// The part as read is invalid.
    #[error("the part as read is invalid: {0}")]
    PartUnsound(PartError),
}

/// The first of `count` names.
fn names(first: &[String], count: usize) -> String {
    first.join(", ") + if first.len() < count { ", …" } else { "" }
}

/// What became of supplemental geometry: so many items of each type.
fn supplemental(is_left_out: bool, counts: &BTreeMap<String, usize>) -> String {
    let counts: Vec<String> = counts.iter().map(|(keyword, count)| format!("{count} {keyword}")).collect();
    let why = if is_left_out { "was left out (see --supplemental)" } else { "has no faces" };
    format!("{why}: {}", counts.join(", "))
}

codes!(StepOutcome {
    Self::Signature => "step-signature",
    Self::Sections { .. } => "step-sections-skipped",
    Self::ForeignInstances { .. } => "step-foreign-instances",
    Self::ForeignFiles { .. } => "step-foreign-files",
    Self::ForeignValues { .. } => "step-foreign-values",
    Self::SyntaxRepaired { .. } => "step-syntax-repaired",
    Self::MoreRepairs { .. } => "step-more-syntax-repairs",
    Self::SyntaxCut { .. } => "step-syntax-cut",
    Self::BehindEnd => "step-text-behind-end",
    Self::DataSections => "step-data-sections-joined",
    Self::NoUnit => "step-no-unit",
    Self::UnitOutOfRange { .. } => "step-unit-out-of-range",
    Self::UnitNotRead => "step-unit-not-read",
    Self::PathColours { .. } => "step-path-colours",
    Self::Hidden { .. } => "step-hidden-items",
    Self::NoFaces { .. } => "step-no-faces",
    Self::Endless { .. } => "step-surface-without-bounds",
    Self::Supplemental { .. } => "step-supplemental",
    Self::AssemblyCycle { .. } => "step-assembly-cycle",
    Self::Repeated { .. } => "step-repeated-geometry",
    Self::FacesAgain { .. } => "step-faces-listed-again",
    Self::FacesCopied { .. } => "step-faces-copied",
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
