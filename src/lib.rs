//! `trimtess` turns trimmed NURBS models (CAD B-reps) into crack-free triangles.
//!
//! The modules below stand in the order in which data flows through them.

/// Bernstein algebra, bounds, roots, exact predicates, tolerances. Knows no surfaces.
pub mod math;

/// What the user said: knots, curves, surfaces, trim loops, parts, instances.
pub mod model;

/// Files to [`model`]: STEP.
pub mod import;

/// Output vocabulary: patch meshes, batches, scene description, sinks, checks.
pub mod mesh;

/// Meshes to files and pictures.
pub mod out;
