//! STEP files (ISO 10303-21 text of AP203, AP214, AP242, …) to a [`Model`](crate::model::Model); syntax by the crate `step-io`.
//!
//! The steps are the files of this folder: `sections` passes over sections without data, `text` parses (and cuts out what
//! breaks the syntax), `table` gives typed access to instances, `units` and `place` turn numbers into millimetres and frames,
//! `curve` and `surface` read geometry, `loops`, `shells` and `part` topology, `carried` the surface of each face, `style`
//! colours, `product` the assembly.
//!
//! Rare forms, and what comes of them. What is refused is told with its number; a face keeps its number and is `lost`.
//!
//! | form | read as |
//! |---|---|
//! | `FACE`; `FACE_SURFACE` without a surface (`$`) | face in the plane of its bounds, with a warning where these are not flat; refused where they enclose no area |
//! | `SUBFACE`, `EDGE` without a curve, `VERTEX` without a point | refused |
//! | `SEAM_EDGE` | its oriented edge; which parameter curve it names does not matter |
//! | `SUBEDGE` | an edge of its own on its parent's curve; it is not joined to faces that use the parent |
//! | `POINT_ON_CURVE`, `POINT_ON_SURFACE`, `DEGENERATE_PCURVE`, `POINT_REPLICA` | points; refused beyond the ends of what they are on, and on composite curves |
//! | `CONSTRUCTIVE_GEOMETRY_REPRESENTATION`, surfaces next to shapes | left out with a note; see [`StepOptions::supplemental`] |
//! | sections `ANCHOR`, `REFERENCE`, `SIGNATURE` | passed over with a note; an instance of another file costs what uses it |
//! | several `DATA` sections | one |
//! | values `@n`, `#NAME`, `<resource>` | unset, with a warning |

mod options;
pub use options::{BYTES_PER_BYTE, StepError, StepOptions};

mod place;
mod replica;
mod sections;
mod table;
mod text;
mod units;

mod boundary;
mod conic;
mod curve;
mod derived;
mod spline;
mod trimmed;

mod offset;
mod stated;
mod surface;
mod turned;

mod gathered;
mod kinds;
mod product;
mod shells;
mod style;
mod tree;

mod body;
mod carried;
mod corners;
mod csg;
mod draft;
mod loops;
mod part;
mod reader;
mod sweep;
mod tessellated;

mod read;
pub use read::{read, read_file};
