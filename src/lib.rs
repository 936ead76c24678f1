//! `trimtess` turns trimmed NURBS models (CAD B-reps) into crack-free triangles.
//!
//! The modules below stand in the order in which data flows through them.

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

/// Master, workers and the render thread.
pub mod parallel;
