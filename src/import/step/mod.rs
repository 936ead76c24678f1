//! STEP files (ISO 10303-21 text of AP203, AP214, AP242, …) -> a [`Model`](crate::model::Model).
//!
//! The files of this folder are the steps: `token` reads tokens and strings, `records` instances, `sections` what lies
//! around them, `text` all of it, within its limits and on all threads. `table` gives typed access to the `values` of
//! instances, `units` and `place` convert numbers to millimetres and frames, `stated_spline`, `curve` and `surface`
//! read geometry, `loops`, `draft`, `shells` and `part` topology, `face_surface` the surface of each face, `style`
//! colours, `product` the assembly.
//!
//! Rare forms and how they are read. A diagnostic names each refused instance; a refused face keeps its index and is
//! `lost`.
//!
//! | form | read as |
//! |---|---|
//! | `FACE`; `FACE_SURFACE` with surface `$` | face in the plane of its bounds; warning if not planar |
//! | `SUBFACE`, `VERTEX` without a point | refused |
//! | `EDGE` without a curve | straight, with a warning |
//! | edge whose curve is a single point, up to the tolerance and a millionth of the part | left out, as at a pole |
//! | `EDGE_CURVE` on a `PCURVE` along an oblique `LINE` of a surface without ends | straight; with a warning off planes |
//! | `SEAM_EDGE` | its oriented edge; the parameter curve is ignored |
//! | `SUBEDGE` | a separate edge on its parent's curve, not shared with faces that use the parent |
//! | `POINT_ON_CURVE`, `POINT_ON_SURFACE` | points; refused outside the domain, and on composite curves |
//! | `DEGENERATE_PCURVE`, `POINT_REPLICA` | points |
//! | transformation with a negative scale | a reflection in its origin, too; a scale of 0 is refused |
//! | `CONSTRUCTIVE_GEOMETRY_REPRESENTATION`, surfaces next to shapes | left out; see [`StepOptions::supplemental`] |
//! | sections `ANCHOR`, `REFERENCE`, `SIGNATURE` | skipped with a note; users of instances of other files are refused |
//! | several `DATA` sections | one section |
//! | values `@n`, `#NAME`, `<resource>` | unset, with a warning |

mod options;
pub use options::{BYTES_PER_BYTE, StepError, StepOptions};

mod budget;
mod token;
mod values;
mod records;
mod sections;
mod table;
mod text;
mod units;
mod place;

mod spline;
mod stated_spline;
mod curve;
mod replica;

mod face_location;
mod revolution;
mod parameters;
mod weld;
mod offset;
mod derived;
mod surface;

mod kinds;
mod contents;
mod style;
mod product;
mod shells;
mod tree;

mod csg;
mod loops;
mod draft;
mod face_surface;
mod sweep;
mod tessellated;
mod body;
mod part;

mod read;
pub use read::{read, read_file, read_file_on, read_on};
