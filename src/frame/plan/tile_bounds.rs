//! A tile -> the box that its triangles are in, at every tolerance.

use super::lattice::{places, strips};
use crate::math::boxes::around;
use crate::model::{PartId, TileId};
use crate::prepare::Prepared;
use crate::prepare::internals::{BoundingBox, EdgeUse, PreparedFace, PreparedPart, Tile};
use glam::DVec3;

/// Boxes are larger by this share of the largest coordinate: evaluating a surface rounds.
const ROUNDING: f64 = 1e-14;

impl Prepared {
    /// Lower and upper corner of a box around a tile, millimetres, part coordinates. All triangles of the tile are in
    /// it, at every tolerance and in every frame, and so are the surface and the curves that they stand for. It is
    /// aligned to the axes and not the smallest: it is made of the boxes of Bézier pieces, also where trims cut them
    /// off.
    ///
    /// `None` if there is no such tile. In frames of views, part and tile are those of a batch, and the model is
    /// [`Session::prepared`](crate::parallel::Session::prepared). LODs of a part have the same boxes.
    ///
    /// Cost: some hundred nanoseconds. Nothing is stored: keep the boxes that are asked for in each frame.
    #[must_use]
    pub fn tile_bounds(&self, part: PartId, tile: TileId) -> Option<[DVec3; 2]> {
        let rows = self.parts.get(part.index())?;
        corners(of_tile(rows, rows.tiles.get(tile.index())?))
    }

    /// Lower and upper corner of the box around all tiles of a part, as [`tile_bounds`](Self::tile_bounds). `None` if
    /// there is no such part, or if it has no tiles. Cost: that of all its tiles.
    #[must_use]
    pub fn part_bounds(&self, part: PartId) -> Option<[DVec3; 2]> {
        let rows = self.parts.get(part.index())?;
        corners(rows.tiles.iter().fold(BoundingBox::EMPTY, |all, tile| all.with(&of_tile(rows, tile))))
    }
}

fn corners(of: BoundingBox) -> Option<[DVec3; 2]> {
    let rounding = DVec3::splat(ROUNDING * of.low.abs().max(of.high.abs()).max_element());
    of.low.cmple(of.high).all().then(|| [of.low - rounding, of.high + rounding])
}

/// The box of a tile's surface and of its edges, but for rounding.
fn of_tile(part: &PreparedPart, tile: &Tile) -> BoundingBox {
    let of_edges = tile.loops.iter().flatten().map(|used| of_stretch(part, used));
    of_edges.fold(surface_box(part.face_of(tile), tile), |all, edge| all.with(&edge))
}

/// The box of a tile's surface.
pub(crate) fn surface_box(face: &PreparedFace, tile: &Tile) -> BoundingBox {
    places(face, tile).fold(BoundingBox::EMPTY, |all, place| all.with(place))
}

/// The box of a stretch of an edge.
fn of_stretch(part: &PreparedPart, used: &EdgeUse) -> BoundingBox {
    let edge = &part.edges[used.edge.index()];
    let (first, last) = (used.from.min(used.to) as usize, used.from.max(used.to) as usize);
    let breaks = &edge.breaks[first..=last];
    let [low, high] = around(breaks.iter().map(|end| end.point));
    let of_points = BoundingBox { low, high };
    if edge.straight {
        return of_points;
    }
    let under = strips(&edge.bounds.breaks, edge.breaks[first].t, edge.breaks[last].t);
    edge.bounds.strips[under].iter().fold(of_points, |all, strip| all.with(&strip.place))
}
