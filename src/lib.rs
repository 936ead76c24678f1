//! `trimtess` turns trimmed NURBS models (CAD B-reps) into crack-free triangles, within a chord and angle tolerance or
//! a screen-space error. It runs on all cores; the output is the same, byte for byte, for any number of them.
//!
//! Five terms:
//!
//! * A *part* is a B-rep: faces that share *edges*. Each edge is one curve in space.
//! * A *tile* is a rectangle of a face's (u,v) plane with its own lattice and trim loops.
//! * A *tessellant* is a point of an edge's polyline. All faces of the edge use the same bits, so there are no cracks
//!   and nothing has to be welded.
//! * A *plan* sets the resolution of every lattice and every edge for one frame.
//! * A *batch* is one tile's triangles, ready for a *sink*.
//!
//! ```
//! use std::sync::Arc;
//! use trimtess::{frame, mesh, model::shapes, parallel, prepare};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let model = shapes::by_name("washer").ok_or("no washer")?;
//! let prepared = Arc::new(prepare::prepare(model, &prepare::PrepareOptions::DEFAULT)?); // once per model
//! assert!(prepared.diagnostics.is_empty(), "every face could be used");
//!
//! let mut session = parallel::Session::start(Arc::clone(&prepared), &parallel::SessionOptions::DEFAULT)?;
//! let mut sink = mesh::MemorySink::default();
//! for chord in [0.1, 0.01, 0.001] {
//!     let tolerance = frame::Tolerance { chord, angle: 0.5, max_edge: None }; // millimetres, radians
//!     let plan = frame::plan(&prepared, &tolerance).require_full()?; // once per frame
//!     let report = session.frame(plan, &mut sink)?;
//!     assert!(report.degraded.is_empty());
//!
//!     let facts = mesh::check_scene(&sink).total;
//!     assert!(facts.is_closed(), "at every tolerance: {facts}");
//!     let exact = std::f64::consts::PI * (100.0 - 36.0) * 3.0;
//!     assert!((facts.volume - exact).abs() < chord * facts.area);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! A model comes from [`import::step`](import), from the [builders](model::PartBuilder), or is one of the [named
//! shapes](model::shapes). Triangles go to memory ([`mesh::MemorySink`]), from there to a file ([`out::save`]), to a
//! picture (`out::wgpu`), or to [a sink of your own](mesh::MeshSink). All lengths are in millimetres.
//!
//! The message of an error is one line that includes its causes. They are public fields;
//! [`source`](std::error::Error::source) does not repeat them.
//!
//! The modules below are listed in the order in which data flows through them. Each may `use` only modules above it;
//! `docs/architecture.md` has the exact table and `tests/layers.rs` checks it.

/// Methods of options that each set one field, to be chained: `setters! { with_size(size: (u32, u32)); }`.
macro_rules! setters {
    ($($(#[$attribute:meta])* $with:ident($field:ident: $type:ty);)+) => {
        $(
            $(#[$attribute])*
            #[doc = concat!("Sets [`", stringify!($field), "`](Self::", stringify!($field), ").")]
            #[must_use]
            pub const fn $with(mut self, $field: $type) -> Self {
                self.$field = $field;
                self
            }
        )+
    };
}

/// [`setters`] of a type whose default is its `DEFAULT`: `options! { Size: with_width(width: u32); }`.
macro_rules! options {
    ($options:ident: $($setters:tt)+) => {
        impl $options {
            setters! { $($setters)+ }
        }

        impl Default for $options {
            fn default() -> Self {
                Self::DEFAULT
            }
        }
    };
}

/// Random tests with the same inputs in every run.
#[cfg(test)]
#[path = "../tests/sequence/mod.rs"]
mod sequence;

/// The vector types of this crate's interface.
pub use glam;

/// Bernstein algebra, derivative bounds, exact predicates. Knows no surfaces.
#[doc(hidden)]
pub mod math;

/// Progress of long work, and a way to stop it.
pub mod control;

/// The input model: knots, curves, surfaces, trim loops, parts, instances.
pub mod model;

/// Reads files into a [`model`]: STEP.
pub mod import;

/// Output types: batches, scene description, sinks, mesh checks.
pub mod mesh;

/// Preprocessing, once per model: Bézier patches, pcurves, tiles, shared edges, bounds.
pub mod prepare;

/// Cameras, views and camera paths.
pub mod view;

/// Work per frame: from a tolerance or a view to the triangles of one tile.
pub mod frame;

/// Measures meshes against the exact surfaces and edges by dense sampling.
pub mod audit;

/// SVG diagrams of the parameter plane: how a tile is triangulated, and which region trimming curves keep.
#[cfg(feature = "svg")]
pub mod draw;

/// Runs the frame stages on all cores: tiles dealt to workers once, no communication between workers, one thread that
/// commits.
pub mod parallel;

/// Output: PLY, OBJ, STL, GLB, pictures, scenes on the graphics device.
pub mod out;

/// Compiles the examples of the README as doctests.
#[cfg(all(doctest, feature = "step"))]
#[doc = include_str!("../README.md")]
pub struct Readme;
