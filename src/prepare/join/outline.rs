//! Loops of a tile before breaks are numbered -> polygons.

use crate::prepare::tiles::draft::{DraftTile, DraftUse, FaceDraft};
use crate::prepare::uv::polygon::{TileRegion, points_along};
use glam::DVec2;

/// Points along a loop in (u,v), at most `most` per use; one where it is straight, if `flat`.
pub(super) fn plane_polygon(uses: &[DraftUse], most: usize, flat: bool) -> Vec<DVec2> {
    let mut out = Vec::with_capacity(2 * uses.len());
    for u in uses {
        points_along(&u.uv, (u.from, u.to), most, flat, &mut out);
    }
    out
}

/// The region of a tile, with at most `most` points per use.
pub(super) fn region<'a>(draft: &'a FaceDraft, tile: &DraftTile, most: usize) -> TileRegion<'a> {
    let loops = tile.loops.iter().map(|l| plane_polygon(l, most, true)).collect();
    TileRegion { patches: &draft.surface.patches, min: tile.min, max: tile.max, loops }
}
