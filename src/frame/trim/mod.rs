//! Lattice and trim loops of one tile -> full cells, and triangles of the cells that the loops pass through.
//!
//! The vertices are lattice corners and tessellants, and every tessellant segment is one edge of one triangle.
//! Neighbouring tiles and faces that share the tessellants share the edges, so no crack can open.
//!
//! Method: each crossing of a segment with a lattice line is replaced, in both cells alike, by the nearer end of the
//! segment. Cell polygons are then runs of tessellants and kept corners. Replacing vertices commutes with taking
//! boundaries. So if every triangle of every cell is strictly positive (exact signs) and their boundary is the loops,
//! they cover each point as often as the loops wind around it. Polygons that fail join those of the cells around them
//! in a constrained Delaunay triangulation. The scheme descends from Kumar and Manocha, "Efficient Rendering of Trimmed
//! NURBS Surfaces", Computer-Aided Design 27(7), 1995, section 4; the certificate replaces its case analysis.
//!
//! Loops that cross themselves or each other are triangulated by winding numbers. Triangles in space
//! (`TrimOutput::closing`) then complete the boundary to the loops: the boundary is the loops for every input.

pub(crate) mod input;
pub(crate) mod output;
mod bits;
mod trace;
mod runs;
mod order;
mod flip;
mod sweep;
mod levels;
mod triangulate;
mod rings;
pub(crate) mod cdt;
pub(crate) mod chain;
mod close;
mod cleanup;
mod distinct;
/// Triangulates the whole tile by one constrained Delaunay triangulation: slow, proven, and the oracle of the tests.
pub mod reference;
pub(crate) mod climb;
pub(crate) mod record;
