//! The input model: parts (B-reps) made of faces, edges and vertices, and their placed instances.

mod ids;
pub(crate) use ids::bad_colour;
pub use ids::{Colour, EdgeId, FaceId, InstanceId, PartId, RowId, TileId, VertexId};

mod knots;
#[cfg(feature = "step")]
pub(crate) use knots::breaks;
pub(crate) use knots::{MOST_TURNS, MOST_TURNS_BOTH_WAYS, knots_of_pieces, to_bezier};

mod curve;
pub use curve::{ControlPoint, CurveDerivatives, Frame3, NurbsCurve, NurbsCurve2, NurbsCurve3};

mod surface;
pub use surface::{NurbsSurface, Surface, SurfaceKind};

mod nurbs_surface;
pub use nurbs_surface::SurfaceDerivatives;
pub(crate) use nurbs_surface::quotient;

mod evaluate;

mod natural;
pub use natural::Pole;

mod axis_map;
pub use axis_map::AxisMap;

mod to_nurbs;
#[cfg(feature = "step")]
pub(crate) use to_nurbs::euclidean;
pub(crate) use to_nurbs::{homogeneous, of_pieces};

mod spline_error;
pub use spline_error::{MAX_DEGREE, SplineError, SurfaceError};

mod trim;
pub use trim::{FreeTrims, TrimCurve, TrimError, TrimPiece, TrimRule};

mod error;
pub(crate) use error::transform_fault;
pub use error::{ModelError, PartError};

#[macro_use]
mod trouble;
pub use trouble::{
    BodyRefusal, BorderTrouble, CurveTrouble, FaceError, FaceTrouble, FitTrouble, PlacementTrouble, RegionError,
    ShellTrouble, SolidTrouble, StepCause, StepOutcome, StepTrouble, SyntaxCut, SyntaxError, SyntaxFault, SyntaxRepair,
    TileTrouble, TrimTrouble, WireTrouble,
};

mod diagnostic;
pub use diagnostic::{Diagnostic, DiagnosticKind, Severity};

mod part;
pub use part::{Assembly, Coedge, CurveKind, Edge, Face, Instance, Loop, Model, Part, Shell, ShellKind};

mod extent;
pub(crate) use extent::surface_points;

mod validate;
#[cfg(feature = "step")]
pub(crate) use validate::check_weights;
pub(crate) use validate::not_rigid;

mod builder;
pub use builder::{ModelBuilder, PartBuilder};

/// Small built-in models.
pub mod shapes;
