//! `trimtess` turns trimmed NURBS models (CAD B-reps) into crack-free triangles.
//!
//! The modules below stand in the order in which data flows through them.

/// The vector types of this crate's interface.
pub use glam;

/// Bernstein algebra, bounds, roots, exact predicates, tolerances. Knows no surfaces.
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

/// The same stages on all cores: tiles dealt once, workers that never talk to each other, one committing thread.
pub mod parallel;

/// The door out: PLY, OBJ, STL, GLB, pictures.
pub mod out;
