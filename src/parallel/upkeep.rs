//! What plans change and what is drawn -> the tiles that a sink has to get anew. Counted from the last frame that was committed,
//! tile by tile: a frame that is left costs nothing but its time.

use crate::frame::PlanChanges;
use crate::mesh::{Drawn, SceneInstance, TileId};
use crate::model::{EdgeId, FaceId, PartId};
use crate::prepare::{Prepared, PreparedPart};
use glam::DAffine3;
use std::collections::BTreeSet;

/// Bits of the tiles of a part.
struct PartTiles {
    /// What the sink has of them is not what the plan says, or nothing.
    stale: Vec<u64>,
    /// The sink has triangles of them.
    present: Vec<u64>,
    /// Drawn in some view, for some instance; while a frame is made.
    drawn: Vec<u64>,
    tiles: usize,
}

impl PartTiles {
    fn new(part: &PreparedPart) -> Self {
        let words = vec![0; part.tiles.len().div_ceil(64)];
        let mut new = Self { stale: words.clone(), present: words.clone(), drawn: words, tiles: part.tiles.len() };
        new.forget();
        new
    }

    fn forget(&mut self) {
        self.present.fill(0);
        self.stale.fill(u64::MAX);
        if let Some(last) = self.stale.last_mut()
            && !self.tiles.is_multiple_of(64)
        {
            *last = (1 << (self.tiles % 64)) - 1;
        }
    }
}

/// The state of one sink.
pub(super) struct Upkeep {
    parts: Vec<PartTiles>,
    edges: BTreeSet<(PartId, EdgeId)>,
    /// Whether the sink has nothing that holds.
    whole: bool,
    /// What the sink was told to draw, and where.
    shown: Drawn,
    placed: Vec<(u32, DAffine3)>,
}

fn placed(instances: &[SceneInstance]) -> impl Iterator<Item = (u32, DAffine3)> + '_ {
    instances.iter().map(|instance| (instance.part, instance.transform))
}

/// What a frame has to bring.
#[derive(Debug, Default)]
pub(super) struct Due {
    /// Whether that is all there is.
    pub(super) whole: bool,
    /// Tiles to make, ascending.
    pub(super) tiles: Vec<(PartId, TileId)>,
    /// Tiles that the sink has, that are not drawn, and that are not what the plan says: it cannot draw them again. Ascending.
    pub(super) forgotten: Vec<(PartId, TileId, FaceId)>,
    /// Edges whose lines to make; all there are in whole frames. Ascending.
    pub(super) edges: Vec<(PartId, EdgeId)>,
}

impl Upkeep {
    pub(super) fn new(prepared: &Prepared) -> Self {
        let parts = prepared.parts.iter().map(|part| PartTiles::new(part)).collect();
        Self { parts, edges: BTreeSet::new(), whole: true, shown: Drawn::default(), placed: Vec::new() }
    }

    /// The sink has nothing any more.
    pub(super) fn forget(&mut self) {
        self.whole = true;
        self.edges.clear();
        self.parts.iter_mut().for_each(PartTiles::forget);
    }

    /// A plan differs from the one before.
    pub(super) fn outdate(&mut self, prepared: &Prepared, changes: &PlanChanges) {
        for &(part, TileId(tile)) in &changes.tiles {
            self.parts[part.index()].stale[tile as usize >> 6] |= 1 << (tile & 63);
        }
        let of_model = |&&(part, edge): &&(PartId, u32)| (edge as usize) < prepared.parts[part.index()].brep_edges;
        self.edges.extend(changes.edges.iter().filter(of_model).map(|&(part, edge)| (part, EdgeId(edge))));
    }

    /// What the sink needs to draw.
    pub(super) fn due(&mut self, prepared: &Prepared, instances: &[SceneInstance], drawn: &Drawn) -> Due {
        for part in &mut self.parts {
            part.drawn.fill(0);
        }
        for view in 0..drawn.views() {
            for (i, instance) in instances.iter().enumerate() {
                let Some(part) = self.parts.get_mut(instance.part as usize) else { continue };
                for (k, word) in part.drawn.iter_mut().enumerate() {
                    *word |= drawn.word(view, i, k);
                }
            }
        }
        let mut due = Due { whole: self.whole, ..Due::default() };
        for (p, part) in self.parts.iter().enumerate() {
            for (k, (&stale, &drawn)) in part.stale.iter().zip(&part.drawn).enumerate() {
                due.tiles.extend(bits(stale & drawn, k).map(|tile| (PartId::new(p), tile)));
                let face = |tile: TileId| prepared.parts[p].tiles[tile.0 as usize].face;
                let gone = bits(stale & !drawn & part.present[k], k);
                due.forgotten.extend(gone.map(|tile| (PartId::new(p), tile, face(tile))));
            }
        }
        due.edges = if self.whole { prepared.brep_edges().collect() } else { self.edges.iter().copied().collect() };
        due
    }

    /// Whether the sink was last told to draw just that of instances that stood there.
    pub(super) fn shows(&self, drawn: &Drawn, instances: &[SceneInstance]) -> bool {
        self.shown == *drawn && self.placed.iter().copied().eq(placed(instances))
    }

    /// The sink has what was due.
    pub(super) fn committed(&mut self, due: &Due, drawn: &Drawn, instances: &[SceneInstance]) {
        self.whole = false;
        self.edges.clear();
        self.shown.clone_from(drawn);
        self.placed.clear();
        self.placed.extend(placed(instances));
        for &(part, TileId(tile)) in &due.tiles {
            let (part, word, bit) = (&mut self.parts[part.index()], tile as usize >> 6, 1 << (tile & 63));
            part.stale[word] &= !bit;
            part.present[word] |= bit;
        }
        for &(part, TileId(tile), _) in &due.forgotten {
            self.parts[part.index()].present[tile as usize >> 6] &= !(1 << (tile & 63));
        }
    }
}

/// The tiles of word `k`.
fn bits(mut word: u64, k: usize) -> impl Iterator<Item = TileId> {
    std::iter::from_fn(move || {
        let bit = (word != 0).then(|| word.trailing_zeros())?;
        word &= word - 1;
        Some(TileId(64 * k as u32 + bit))
    })
}
