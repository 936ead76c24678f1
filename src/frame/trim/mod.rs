//! Lattice and trim loops of one tile -> full cells, and triangles of the cells the loops pass through.
//!
//! The vertices are lattice corners and tessellants, and every tessellant segment is one edge of one triangle: neighbouring
//! tiles and faces that share the tessellants share the edges, and no crack can open.
//!
//! Method: each crossing of a segment with a lattice line is replaced, in both cells alike, by the nearer end of the segment.
//! Cell polygons are then runs of tessellants and kept corners. Replacing vertices commutes with taking boundaries, so if
//! every triangle of every cell is strictly positive (exact signs) and their boundary is the loops, they cover each point as
//! often as the loops wind around it. What fails is merged with a neighbour, then triangulated by a constrained Delaunay
//! triangulation. The scheme descends from Kumar and Manocha, "Efficient Rendering of Trimmed NURBS Surfaces",
//! Computer-Aided Design 27(7), 1995, section 4; the certificate replaces its case analysis.
//!
//! Loops that cross themselves or each other are triangulated all the same, by winding numbers, and what then is missing for
//! the boundary to be the loops is added in space (`TrimOutput::closing`): the boundary is the loops for every input.

pub(crate) mod bits;
pub(crate) mod input;
pub(crate) mod output;
pub(crate) mod cdt;
pub(crate) mod chain;
mod cleanup;
pub(crate) mod climb;
mod close;
mod distinct;
/// The whole tile at once by a constrained Delaunay triangulation: slow, proven, and the oracle of the tests.
pub mod reference;
pub(crate) mod rings;
mod slits;
pub(crate) mod trace;
pub(crate) mod triangulate;
pub(crate) mod record;
