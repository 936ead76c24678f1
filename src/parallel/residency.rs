//! Residency: plan changes and drawn tiles -> the tiles that a sink needs. Tracked per tile since the last committed
//! frame, so that a cancelled frame loses nothing but time.

use super::handoff::MadeTile;
use crate::frame::internals::PlanChanges;
use crate::mesh::{DrawnTiles, SceneInstance, tiles_of_word};
use crate::model::{EdgeId, FaceId, PartId, RowId, TileId};
use crate::prepare::Prepared;
use crate::prepare::internals::PreparedPart;
use std::collections::BTreeSet;
use std::sync::Arc;

/// State of a part's tiles, one bit each.
struct PartTiles {
    /// Not resident, or resident and outdated.
    stale: Vec<u64>,
    /// Resident in the sink.
    present: Vec<u64>,
    /// Drawn in some view by some instance of the frame in progress.
    drawn: Vec<u64>,
    /// Drawn in the current epoch, and in the one before.
    recent: [Vec<u64>; 2],
    /// Triangle count of each tile, when it was last sent.
    triangles: Vec<u32>,
    /// Bytes of each tile that is resident; of others 0.
    bytes: Vec<u32>,
    /// Whether `drawn` has any tile.
    is_drawn: bool,
    /// Whether tiles turned stale since the last committed frame.
    is_outdated: bool,
    /// Whether there is a plan for its edges.
    is_planned: bool,
}

/// Frames between evictions. Tiles that were not drawn in the last two epochs may be evicted.
const EPOCH: u32 = 64;
/// Tiles are evicted when the resident triangles exceed this multiple of the drawn ones.
const KEPT: u64 = 2;

impl PartTiles {
    /// Whether it is drawn, or tiles turned stale.
    fn is_active(&self) -> bool {
        self.is_drawn || self.is_outdated
    }

    fn new(part: &PreparedPart) -> Self {
        let words = vec![0; part.tiles.len().div_ceil(64)];
        let mut new = Self {
            stale: words.clone(),
            present: words.clone(),
            recent: [words.clone(), words.clone()],
            drawn: words,
            triangles: vec![0; part.tiles.len()],
            bytes: vec![0; part.tiles.len()],
            is_drawn: false,
            is_outdated: true,
            is_planned: false,
        };
        new.forget();
        new
    }

    fn forget(&mut self) {
        self.is_outdated = true;
        self.present.fill(0);
        self.bytes.fill(0);
        self.freshen();
    }

    /// Marks those tiles stale that are not resident, as they are between committed frames.
    fn freshen(&mut self) {
        self.stale.iter_mut().zip(&self.present).for_each(|(stale, present)| *stale = !present);
        let tiles = self.triangles.len();
        if let Some(last) = self.stale.last_mut()
            && !tiles.is_multiple_of(64)
        {
            *last &= (1 << (tiles % 64)) - 1;
        }
    }
}

/// What one sink has of the model.
pub(super) struct Residency {
    parts: Vec<PartTiles>,
    /// Parts that are drawn or outdated, each once; ascending after [`due`](Self::due). A frame looks only at these: in
    /// a large scene most parts are neither.
    active: Vec<usize>,
    /// Bytes of all resident tiles.
    held: u64,
    /// Limit of `held`.
    most: u64,
    /// Whether the sink wants lines of edges.
    edge_lines: bool,
    /// Edges whose lines are outdated. None before a whole frame, which has all of them.
    edges: BTreeSet<(PartId, EdgeId)>,
    /// Whether the next frame must be a whole one.
    whole: bool,
    /// After an update: for each part, the one that the sink has for it.
    from: Option<Vec<Option<PartId>>>,
    /// Number of parts that the sink knows: those of the last committed frame.
    known: usize,
    /// The drawn tiles of the last committed frame, with instances in the rows that they have now. Empty before a whole
    /// frame.
    shown: DrawnTiles,
    /// The version of the instances then.
    placed: u64,
    /// Frames in the current epoch.
    frames: u32,
}

/// The content of a frame.
#[derive(Debug, Default)]
pub(super) struct Due {
    /// Whether it is a whole frame rather than changes.
    pub(super) whole: bool,
    /// Tiles to make: stale and drawn. Ascending.
    pub(super) tiles: Vec<(PartId, TileId)>,
    /// Tiles to evict: resident, stale and not drawn. They are outdated, or marked so to evict them. Ascending.
    pub(super) evicted: Vec<(PartId, TileId, FaceId)>,
    /// Edges whose lines to make, if the sink wants them; in a whole frame, all of parts that have a plan. Ascending.
    pub(super) edges: Vec<(PartId, EdgeId)>,
    /// For [`MeshSink::begin_update`](crate::mesh::MeshSink::begin_update), if the sink has another model and the frame
    /// is not a whole one.
    pub(super) from: Option<Vec<Option<PartId>>>,
}

impl Residency {
    /// `most`: bytes that resident tiles may take. `edge_lines`: whether the sink wants lines of edges.
    pub(super) fn new(prepared: &Prepared, most: Option<u64>, edge_lines: bool) -> Self {
        let mut new = Self {
            parts: Vec::new(),
            active: Vec::new(),
            held: 0,
            most: most.unwrap_or(u64::MAX),
            edge_lines,
            edges: BTreeSet::new(),
            whole: true,
            from: None,
            known: 0,
            shown: DrawnTiles::NONE,
            placed: 0,
            frames: 0,
        };
        new.add_parts(prepared);
        new
    }

    /// Appends the parts of `prepared` that came after those here.
    pub(super) fn add_parts(&mut self, prepared: &Prepared) {
        let first = self.parts.len();
        self.parts.extend(prepared.parts.iter().skip(first).map(|part| PartTiles::new(part)));
        self.from.iter_mut().for_each(|from| from.resize(self.parts.len(), None));
        self.find_active();
    }

    /// Finds the active parts. Cost: one pass over all.
    fn find_active(&mut self) {
        self.active.clear();
        self.active.extend((0..self.parts.len()).filter(|&part| self.parts[part].is_active()));
    }

    /// Switches to another model, whose part `p` was `from[p]`. Its tiles in the sink stay resident.
    pub(super) fn update(&mut self, prepared: &Prepared, from: &[Option<PartId>]) {
        let mut old: Vec<Option<PartTiles>> = std::mem::take(&mut self.parts).into_iter().map(Some).collect();
        let state = |(part, from): (&Arc<PreparedPart>, &Option<PartId>)| {
            let kept = from.and_then(|from| old[from.index()].take());
            kept.unwrap_or_else(|| PartTiles::new(part))
        };
        self.parts = prepared.parts.iter().zip(from).map(state).collect();
        self.held = self.parts.iter().flat_map(|part| &part.bytes).map(|&bytes| u64::from(bytes)).sum();
        if !self.whole {
            let before = self.from.take();
            let in_sink = |part: PartId| match &before {
                Some(before) => before[part.index()],
                None => (part.index() < self.known).then_some(part),
            };
            self.from = Some(from.iter().map(|part| part.and_then(in_sink)).collect());
        }
        self.placed = 0;
        self.shown.reset(0);
        self.find_active();
    }

    /// Removes instances, whose rows ascend.
    pub(super) fn remove_instances(&mut self, rows: &[usize]) {
        self.shown.remove_instances(rows);
    }

    /// Its memory, bytes.
    pub(super) fn memory(&self) -> usize {
        /// Of a tile: its triangles and bytes, and five bits.
        const TILE: usize = 9;
        self.parts.iter().map(|part| size_of::<PartTiles>() + TILE * part.triangles.len()).sum()
    }

    /// Marks everything as not resident.
    pub(super) fn forget(&mut self) {
        self.whole = true;
        self.from = None;
        self.edges.clear();
        self.shown.reset(0);
        self.held = 0;
        self.parts.iter_mut().for_each(PartTiles::forget);
        self.find_active();
    }

    /// Marks what the plan changed as stale.
    pub(super) fn outdate(&mut self, prepared: &Prepared, changes: &PlanChanges) {
        for &(part, TileId(tile)) in &changes.tiles {
            let row = &mut self.parts[part.index()];
            row.stale[tile as usize >> 6] |= 1 << (tile & 63);
            if !row.is_active() {
                self.active.push(part.index());
            }
            row.is_outdated = true;
        }
        changes.parts.iter().for_each(|part| self.parts[part.index()].is_planned = true);
        if self.whole || !self.edge_lines {
            return;
        }
        for &part in &changes.parts {
            self.edges.extend(prepared.parts[part.index()].edges_of_faces().map(|edge| (part, edge)));
        }
        let of_model = |&&(part, edge): &&(PartId, RowId)| edge.index() < prepared.parts[part.index()].brep_edges;
        self.edges.extend(changes.edges.iter().filter(of_model).map(|&(part, edge)| (part, EdgeId(edge.0))));
    }

    /// What the sink needs in order to draw `drawn`. [`keep`](Self::keep) or [`revert`](Self::revert) comes before the
    /// next frame.
    pub(super) fn due(&mut self, prepared: &Prepared, instances: &[SceneInstance], drawn: &DrawnTiles) -> Due {
        let Self { parts, active, .. } = self;
        for &part in &*active {
            parts[part].drawn.fill(0);
            parts[part].is_drawn = false;
        }
        active.retain(|&part| parts[part].is_outdated);
        for (_, instance, words) in drawn.rows() {
            let number = instances[instance].part.index();
            let part = &mut parts[number];
            part.drawn.iter_mut().zip(words).for_each(|(word, more)| *word |= more);
            if !part.is_active() {
                active.push(number);
            }
            part.is_drawn = true;
        }
        active.sort_unstable();
        if self.frames + 1 == EPOCH {
            self.age();
        }
        if self.held > self.most {
            self.shed();
            self.find_active();
        }
        let mut due = Due { whole: self.whole, from: self.from.clone(), ..Due::default() };
        for &p in &self.active {
            let part = &self.parts[p];
            for (k, (&stale, &drawn)) in part.stale.iter().zip(&part.drawn).enumerate() {
                due.tiles.extend(tiles_of_word(stale & drawn, k).map(|tile| (PartId::new(p), tile)));
                let face = |tile: TileId| prepared.parts[p].tiles[tile.0 as usize].face;
                let gone = tiles_of_word(stale & !drawn & part.present[k], k);
                due.evicted.extend(gone.map(|tile| (PartId::new(p), tile, face(tile))));
            }
        }
        let is_planned = |&(part, _): &(PartId, EdgeId)| self.parts[part.index()].is_planned;
        let all = || prepared.brep_edges().filter(is_planned).collect();
        due.edges = if self.whole && self.edge_lines { all() } else { self.edges.iter().copied().collect() };
        due
    }

    /// Marks tiles stale that were drawn neither in this epoch nor in the one before, if too much is resident. That
    /// evicts them.
    fn age(&mut self) {
        let sum = |part: &PartTiles, words: &[u64]| -> u64 {
            let tiles = words.iter().enumerate().flat_map(|(k, &word)| tiles_of_word(word & part.present[k], k));
            tiles.map(|TileId(tile)| u64::from(part.triangles[tile as usize])).sum()
        };
        let drawn: u64 = self.parts.iter().map(|part| sum(part, &part.drawn)).sum();
        let held: u64 = self.parts.iter().map(|part| sum(part, &part.present)).sum();
        if held <= KEPT * drawn {
            return;
        }
        for part in &mut self.parts {
            part.is_outdated = true;
            for (k, stale) in part.stale.iter_mut().enumerate() {
                *stale |= part.present[k] & !(part.drawn[k] | part.recent[0][k] | part.recent[1][k]);
            }
        }
        self.find_active();
    }

    /// Counts the last frame, which was committed, as one of the epoch.
    pub(super) fn keep(&mut self) {
        for &part in &self.active {
            let part = &mut self.parts[part];
            part.recent[0].iter_mut().zip(&part.drawn).for_each(|(recent, drawn)| *recent |= drawn);
        }
        self.frames = (self.frames + 1) % EPOCH;
        if self.frames == 0 {
            for part in &mut self.parts {
                part.recent.swap(0, 1);
                part.recent[0].fill(0);
            }
        }
    }

    /// Takes back the last frame, which was not committed, and planned these parts first: the sink has what it had.
    pub(super) fn revert(&mut self, planned: &[PartId]) {
        self.edges.clear();
        planned.iter().for_each(|part| self.parts[part.index()].is_planned = false);
        for &part in &self.active {
            let part = &mut self.parts[part];
            if std::mem::take(&mut part.is_outdated) {
                part.freshen();
            }
        }
        let Self { parts, active, .. } = self;
        active.retain(|&part| parts[part].is_drawn);
    }

    /// Marks tiles stale that no view draws, by the epoch that drew them last, until the others take no more than they
    /// may. That evicts them.
    fn shed(&mut self) {
        let going = |part: &PartTiles| -> u64 {
            let words = part.stale.iter().zip(&part.drawn).zip(&part.present).enumerate();
            let tiles = words.flat_map(|(k, ((stale, drawn), present))| tiles_of_word(stale & present & !drawn, k));
            tiles.map(|TileId(tile)| u64::from(part.bytes[tile as usize])).sum()
        };
        let mut held = self.held - self.parts.iter().map(going).sum::<u64>();
        // Drawn neither in this epoch nor in the one before, drawn in that one, drawn in this one.
        for age in (0..3).rev() {
            for part in &mut self.parts {
                for (k, &present) in part.present.iter().enumerate() {
                    let [now, before] = [&part.recent[0], &part.recent[1]].map(|recent| recent[k]);
                    let of_age = [now, before & !now, !(now | before)][age];
                    for TileId(tile) in tiles_of_word(present & of_age & !part.drawn[k] & !part.stale[k], k) {
                        if held <= self.most {
                            return;
                        }
                        held -= u64::from(part.bytes[tile as usize]);
                        part.stale[k] |= 1 << (tile & 63);
                        part.is_outdated = true;
                    }
                }
            }
        }
    }

    /// Whether tiles take more than they may.
    pub(super) fn is_full(&self) -> bool {
        self.held > self.most
    }

    /// The drawn tiles of the last committed frame, with instances in the rows that they have now.
    pub(super) fn shown(&self) -> &DrawnTiles {
        &self.shown
    }

    /// Whether the last committed frame had the same drawn tiles, and instances of this version.
    pub(super) fn shows(&self, drawn: &DrawnTiles, placed: u64) -> bool {
        self.placed == placed && self.shown == *drawn
    }

    /// Records that `due` was committed. `made`: what was sent of each tile.
    pub(super) fn committed(
        &mut self,
        due: &Due,
        made: impl Iterator<Item = MadeTile>,
        (drawn, placed): (&DrawnTiles, u64),
    ) {
        (self.whole, self.placed) = (false, placed);
        for MadeTile { part, tile: TileId(tile), triangles, bytes } in made {
            let part = &mut self.parts[part.index()];
            part.triangles[tile as usize] = triangles;
            let before = std::mem::replace(&mut part.bytes[tile as usize], bytes);
            self.held = self.held - u64::from(before) + u64::from(bytes);
        }
        (self.from, self.known) = (None, self.parts.len());
        self.edges.clear();
        self.shown.clone_from(drawn);
        let Self { parts, active, .. } = self;
        active.iter().for_each(|&part| parts[part].is_outdated = false);
        active.retain(|&part| parts[part].is_drawn);
        for &(part, TileId(tile)) in &due.tiles {
            let (part, word, bit) = (&mut self.parts[part.index()], tile as usize >> 6, 1 << (tile & 63));
            part.stale[word] &= !bit;
            part.present[word] |= bit;
        }
        for &(part, TileId(tile), _) in &due.evicted {
            let part = &mut self.parts[part.index()];
            part.present[tile as usize >> 6] &= !(1 << (tile & 63));
            self.held -= u64::from(std::mem::take(&mut part.bytes[tile as usize]));
        }
    }
}
