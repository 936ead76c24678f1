//! What plans change and what is drawn -> the tiles that a sink has to get anew. Counted from the last frame that was committed,
//! tile by tile: a frame that is left costs nothing but its time.

use crate::frame::internals::PlanChanges;
use crate::mesh::{Drawn, SceneInstance};
use crate::model::{EdgeId, FaceId, PartId, RowId, TileId};
use crate::prepare::Prepared;
use crate::prepare::internals::PreparedPart;
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
    /// Drawn in this epoch, and in the one before.
    recent: [Vec<u64>; 2],
    /// What the sink has of each tile that is present.
    triangles: Vec<u32>,
    tiles: usize,
}

/// Frames of an epoch: what was not drawn for one or two of them may be forgotten.
const EPOCH: u32 = 64;
/// Triangles that a sink may have, as a multiple of those of the tiles that are drawn, before it is told to forget others.
const KEPT: u64 = 2;

impl PartTiles {
    fn new(part: &PreparedPart) -> Self {
        let words = vec![0; part.tiles.len().div_ceil(64)];
        let mut new = Self {
            stale: words.clone(),
            present: words.clone(),
            recent: [words.clone(), words.clone()],
            drawn: words,
            triangles: vec![0; part.tiles.len()],
            tiles: part.tiles.len(),
        };
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
    placed: Vec<(PartId, DAffine3)>,
    /// Frames of this epoch.
    frames: u32,
}

fn placed(instances: &[SceneInstance]) -> impl Iterator<Item = (PartId, DAffine3)> + '_ {
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
        Self { parts, edges: BTreeSet::new(), whole: true, shown: Drawn::default(), placed: Vec::new(), frames: 0 }
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
        let of_model = |&&(part, edge): &&(PartId, RowId)| edge.index() < prepared.parts[part.index()].brep_edges;
        self.edges.extend(changes.edges.iter().filter(of_model).map(|&(part, edge)| (part, EdgeId(edge.0))));
    }

    /// What the sink needs to draw.
    pub(super) fn due(&mut self, prepared: &Prepared, instances: &[SceneInstance], drawn: &Drawn) -> Due {
        for part in &mut self.parts {
            part.drawn.fill(0);
        }
        for view in 0..drawn.views() {
            for (i, instance) in instances.iter().enumerate() {
                let Some(part) = self.parts.get_mut(instance.part.index()) else { continue };
                for (k, word) in part.drawn.iter_mut().enumerate() {
                    *word |= drawn.word(view, i, k);
                }
            }
        }
        self.age();
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

    /// Marks tiles stale that were not drawn for long, where the sink has much more than is drawn: they are forgotten then.
    fn age(&mut self) {
        for part in &mut self.parts {
            part.recent[0].iter_mut().zip(&part.drawn).for_each(|(recent, drawn)| *recent |= drawn);
        }
        self.frames += 1;
        if self.frames < EPOCH {
            return;
        }
        self.frames = 0;
        let sum = |part: &PartTiles, words: &[u64]| -> u64 {
            let tiles = words.iter().enumerate().flat_map(|(k, &word)| bits(word & part.present[k], k));
            tiles.map(|TileId(tile)| u64::from(part.triangles[tile as usize])).sum()
        };
        let drawn: u64 = self.parts.iter().map(|part| sum(part, &part.drawn)).sum();
        let held: u64 = self.parts.iter().map(|part| sum(part, &part.present)).sum();
        for part in &mut self.parts {
            if held > KEPT * drawn {
                let recent = part.recent[0].iter().zip(&part.recent[1]).map(|(now, before)| now | before);
                part.stale
                    .iter_mut()
                    .zip(&part.present)
                    .zip(recent)
                    .for_each(|((stale, present), r)| *stale |= present & !r);
            }
            part.recent.swap(0, 1);
            part.recent[0].fill(0);
        }
    }

    /// Whether the sink was last told to draw just that of instances that stood there.
    pub(super) fn shows(&self, drawn: &Drawn, instances: &[SceneInstance]) -> bool {
        self.shown == *drawn && self.placed.iter().copied().eq(placed(instances))
    }

    /// The sink has what was due; `made` is how many triangles each of the tiles has.
    pub(super) fn committed(
        &mut self,
        due: &Due,
        made: &[(PartId, TileId, u32)],
        drawn: &Drawn,
        instances: &[SceneInstance],
    ) {
        self.whole = false;
        for &(part, TileId(tile), triangles) in made {
            self.parts[part.index()].triangles[tile as usize] = triangles;
        }
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
