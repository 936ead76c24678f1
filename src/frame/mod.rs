//! Per frame, one tile, one thread, no locks: from rates to triangles.
