//! `trimtess` turns trimmed NURBS models (CAD B-reps) into crack-free triangles: within a chord and angle tolerance or a
//! deviation in pixels, on all cores, with the same bytes whatever their number.
//!
//! Five words. A *part* is a B-rep: faces that share *edges*, each one curve in space. A *tile* is a rectangle of a face's
//! (u,v) plane with its own lattice and trim loops. A *tessellant* is a point of an edge's polyline; both faces of the edge use
//! it bit by bit, so nothing cracks and nothing is welded. A *plan* says, for one frame, how fine every lattice and every edge
//! is. A *batch* is one tile's triangles on their way to a *sink*.
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
//!     let plan = Arc::new(frame::plan(&prepared, &tolerance).as_asked()?); // once per frame
//!     let report = session.frame(&plan, &mut sink)?;
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
//! A model comes from [`import::step`](import), from the [builders](model::PartBuilder), or is one of the
//! [named shapes](model::shapes). Triangles go to a file ([`out::open`]), to a picture (`out::wgpu`), to
//! memory ([`mesh::MemorySink`]) or to [a sink of your own](mesh::MeshSink). Lengths are millimetres throughout.
//!
//! The modules below stand in the order in which data flows through them; each may name only those above it
//! (`tests/layers.rs`), as `docs/architecture.md` tells.

/// Random tests that are the same in every run.
#[cfg(test)]
#[path = "../tests/sequence/mod.rs"]
mod sequence;

/// The vector types of this crate's interface.
pub use glam;

/// Bernstein algebra, derivative bounds, exact predicates. Knows no surfaces.
#[doc(hidden)]
pub mod math;

/// What the user said: knots, curves, surfaces, trim loops, parts, instances.
pub mod model;

/// Files to [`model`]: STEP.
pub mod import;

/// Paid once per model: Bézier patches, pcurves, tiles, shared edges, bounds.
pub mod prepare;

/// Output vocabulary: patch meshes, batches, scene description, sinks, checks.
pub mod mesh;

/// Paid every frame: from a tolerance or a view to the triangles of one tile.
pub mod frame;

/// The oracle's second half: meshes measured densely against the exact surfaces and edges.
pub mod audit;

/// Diagrams in the parameter plane as SVG: how a tile came to its triangles, what trimming curves keep.
#[cfg(feature = "svg")]
pub mod draw;

/// The same stages on all cores: tiles dealt once, workers that never talk to each other, one committing thread.
pub mod parallel;

/// The door out: PLY, OBJ, STL, GLB, pictures, scenes on the graphics device.
pub mod out;

/// The examples of the README, kept compiling.
#[cfg(all(doctest, feature = "step"))]
#[doc = include_str!("../README.md")]
pub struct Readme;
