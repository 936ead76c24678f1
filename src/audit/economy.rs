//! Triangles made -> triangles that a uniform lattice needs for the same tolerance, per tile, by trying lattices out.

use super::foot::walk_surface;
use crate::mesh::{BatchView, FrameView};
use crate::model::{FaceId, PartId, SurfaceKind, TileId};
use crate::prepare::Prepared;
use crate::prepare::internals::{BezierPatches, PreparedFace, Tile};
use glam::{DVec2, DVec3};
use std::collections::{HashMap, HashSet};
use std::fmt;

/// Maximum number of tiles tried, spread evenly over the curved ones.
const TILES: usize = 64;

/// Triangles made and needed for one tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileEconomy {
    /// The part.
    pub part: PartId,
    /// The face within the part.
    pub face: FaceId,
    /// The tile within the part.
    pub tile: TileId,
    /// The surface's kind.
    pub kind: SurfaceKind,
    /// Triangles made.
    pub made: f64,
    /// Triangles of the smallest uniform lattice within the tolerance, times the kept fraction of the tile; at least 2.
    pub lattice: f64,
    /// Triangles needed for the boundary alone, without vertices inside the tile.
    pub boundary: f64,
}

impl TileEconomy {
    /// Triangles needed: the maximum of lattice and boundary. The boundary is shared with neighbours, so it is given.
    #[must_use]
    pub fn needed(&self) -> f64 {
        self.lattice.max(self.boundary)
    }

    /// Triangles made per triangle needed.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.made / self.needed()
    }
}

/// Triangles made and needed on a sample of the curved tiles of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct EconomyReport {
    /// The tiles tried, most wasteful first.
    pub tiles: Vec<TileEconomy>,
}

impl EconomyReport {
    /// Triangles made per triangle needed, over all tiles tried; 1 without tiles.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.sum_ratio(TileEconomy::needed)
    }

    /// Triangles made per triangle of the lattices, over all tiles tried; 1 without tiles. Ignores what boundaries
    /// need.
    #[must_use]
    pub fn lattice_mean(&self) -> f64 {
        self.sum_ratio(|tile| tile.lattice)
    }

    fn sum_ratio(&self, needed: impl Fn(&TileEconomy) -> f64) -> f64 {
        let (made, needed) = self.tiles.iter().fold((0.0, 0.0), |(m, n), tile| (m + tile.made, n + needed(tile)));
        if needed > 0.0 { made / needed } else { 1.0 }
    }

    /// The maximum ratio of a tile; 1 without tiles.
    #[must_use]
    pub fn worst(&self) -> f64 {
        self.tiles.first().map_or(1.0, TileEconomy::ratio)
    }
}

impl fmt::Display for EconomyReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (mean, tiles, worst, lattices) = (self.mean(), self.tiles.len(), self.worst(), self.lattice_mean());
        write!(
            f,
            "economy: {mean:.2} triangles made per triangle needed on {tiles} curved tiles, worst {worst:.2}; \
             {lattices:.2} per triangle of the smallest uniform lattices"
        )?;
        for of_tile in self.tiles.iter().take(4) {
            let (ratio, TileEconomy { part, face, tile, kind, made, lattice, boundary }) = (of_tile.ratio(), of_tile);
            let (part, face, kind, tile) = (part.0, face.0, kind.name(), tile.0);
            write!(
                f,
                "\n  {ratio:.2} at part {part} face {face} ({kind}) tile {tile}: {made} made, {lattice:.0} needed by the \
                 lattice, {boundary:.0} by the boundary"
            )?;
        }
        Ok(())
    }
}

/// Compares up to 64 curved tiles of `mesh`, which was made from `prepared`, with the smallest uniform lattices within
/// `chord`, in millimetres of the placed model. Skips tiles that [`deviation`](super::deviation()) skips.
///
/// Lattices are uniform in the parameters of the tile's patches, and their distance from the surface is sampled. The
/// comparison ignores the angle tolerance, so meshes made for one look less economical. Cost: milliseconds per tile, up
/// to a second.
#[must_use]
pub fn economy<'a>(prepared: &Prepared, mesh: impl Into<FrameView<'a>>, chord: f64) -> EconomyReport {
    try_out(prepared, &mesh.into().measurable(), chord)
}

fn try_out(prepared: &Prepared, mesh: &FrameView<'_>, chord: f64) -> EconomyReport {
    let curved: Vec<(&BatchView<'_>, &PreparedFace, &Tile)> = mesh
        .batches
        .iter()
        .filter(|batch| !batch.mesh.triangles.is_empty())
        .filter_map(|batch| {
            let part = prepared.parts.get(batch.part.index())?;
            Some((batch, part.face(batch.face)?, part.tiles.get(batch.tile.0 as usize)?))
        })
        .filter(|(_, face, _)| face.kind != SurfaceKind::Plane)
        .collect();
    let scales = prepared.scene.largest_scales();
    let least = |batch: &BatchView<'_>, face: &PreparedFace, tile: &Tile| {
        let chord = chord / scales.get(batch.part.index()).copied().unwrap_or(1.0);
        (2.0 * f64::from(least_cells(&face.patches, tile, batch, chord)) * kept(batch, face, tile)).max(2.0)
    };
    let mut tiles: Vec<TileEconomy> = curved
        .iter()
        .step_by(curved.len().div_ceil(TILES).max(1))
        .map(|&(batch, face, tile)| TileEconomy {
            part: batch.part,
            face: batch.face,
            tile: batch.tile,
            kind: face.kind,
            made: batch.mesh.triangles.len() as f64,
            lattice: least(batch, face, tile),
            boundary: boundary(batch),
        })
        .collect();
    tiles.sort_by(|a, b| b.ratio().total_cmp(&a.ratio()));
    EconomyReport { tiles }
}

/// Triangles left after removing every inner vertex, by Euler's formula.
fn boundary(batch: &BatchView<'_>) -> f64 {
    let mesh = &batch.mesh;
    let mut uses: HashMap<[u32; 2], u32> = HashMap::new();
    for t in mesh.triangles.iter() {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            *uses.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    let mut inside = vec![true; mesh.positions.len()];
    let once = uses.into_iter().filter(|(_, count)| *count == 1).map(|(edge, _)| edge);
    once.flatten().for_each(|vertex| inside[vertex as usize] = false);
    let used: HashSet<u32> = mesh.triangles.iter().flatten().filter(|&v| inside[v as usize]).collect();
    mesh.triangles.len() as f64 - 2.0 * used.len() as f64
}

/// Fraction of the tile's rectangle that its triangles cover.
fn kept(batch: &BatchView<'_>, face: &PreparedFace, tile: &Tile) -> f64 {
    let mesh = &batch.mesh;
    let place = |vertex: u32| face.to_patches(mesh.uvs[vertex as usize].as_dvec2());
    let area: f64 = mesh
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(place);
            0.5 * (b - a).perp_dot(c - a).abs()
        })
        .sum();
    (area / (tile.max - tile.min).element_product()).clamp(0.0, 1.0)
}

/// Number of cells of the smallest uniform lattice that passes, at most the number of triangles made.
fn least_cells(patches: &BezierPatches, tile: &Tile, batch: &BatchView<'_>, chord: f64) -> u32 {
    let mut best = u32::try_from(batch.mesh.triangles.len()).unwrap_or(u32::MAX).max(1);
    let mut across = 1;
    while across <= best {
        // The fewest rows that pass and beat the best, by doubling, then bisection.
        let limit = best / across;
        let mut high = 1;
        while high < limit && !passes(patches, tile, (across, high), chord) {
            high = (2 * high).min(limit);
        }
        let mut low = high / 2;
        if passes(patches, tile, (across, high), chord) {
            while high - low > 1 {
                let middle = low.midpoint(high);
                if passes(patches, tile, (across, middle), chord) { high = middle } else { low = middle }
            }
            best = best.min(across * high);
        }
        across = (across + 1).max(across * 6 / 5);
    }
    best
}

/// Whether all cells are within `chord`, sampled at the midpoints of the shorter diagonal and of two sides.
fn passes(patches: &BezierPatches, tile: &Tile, (across, along): (u32, u32), chord: f64) -> bool {
    let step = (tile.max - tile.min) / DVec2::new(f64::from(across), f64::from(along));
    let place = |i: u32, j: u32| {
        let uv = tile.min + step * DVec2::new(f64::from(i), f64::from(j));
        (uv, patches.point(uv.x, uv.y))
    };
    let near = |(a, p): (DVec2, DVec3), (b, q): (DVec2, DVec3)| {
        walk_surface(patches, p.midpoint(q), a.midpoint(b), chord).distance <= chord
    };
    let line = |i: u32| (0..=along).map(|j| place(i, j)).collect::<Vec<_>>();
    let mut left = line(0);
    for i in 1..=across {
        let right = line(i);
        for j in 0..along as usize {
            let [a, b, c, d] = [left[j], right[j], right[j + 1], left[j + 1]];
            let falling = b.1.distance_squared(d.1) < a.1.distance_squared(c.1);
            let diagonal = if falling { near(b, d) } else { near(a, c) };
            if !(diagonal && near(a, b) && near(a, d)) {
                return false;
            }
        }
        left = right;
    }
    true
}
