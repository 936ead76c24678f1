//! Which worker makes which tile: dealt when the session starts, optionally rebalanced by measured times.

use super::distribute::{deal, loads};
use super::handoff::{Hand, Seat};
use super::residency::Due;
use crate::model::{PartId, TileId};
use crate::prepare::Prepared;
use std::num::NonZeroU32;
use std::time::Duration;

/// Number of workers on `threads` threads, unless the caller says otherwise. What a tile costs is known only roughly,
/// and with few tiles per thread that does not average out. More workers take more hand-offs.
pub(super) const fn workers_on(threads: usize) -> usize {
    const PER_THREAD: usize = 4;
    if threads > 1 { PER_THREAD * threads } else { 1 }
}

/// Deals the model to workers of `threads` threads: tiles by weight, edges (far cheaper) round-robin.
pub(super) fn hands(prepared: &Prepared, (workers, threads): (usize, usize), edge_lines: bool) -> Vec<Hand> {
    let tiles: Vec<_> = prepared.tiles().map(|(part, tile, row)| (part, tile, row.face)).collect();
    let mut hands: Vec<Hand> = deal(&loads(prepared), workers, threads)
        .into_iter()
        .map(|hand| Hand { tiles: hand.into_iter().map(|index| tiles[index]).collect(), edges: Vec::new() })
        .collect();
    if edge_lines {
        for (index, edge) in prepared.brep_edges().enumerate() {
            hands[index % workers.max(1)].edges.push(edge);
        }
    }
    hands
}

/// Which worker owns each tile.
pub(super) struct Owners {
    parts: Vec<Vec<u32>>,
    workers: usize,
    /// Threads that make what workers own.
    pub(super) threads: usize,
    epoch: Option<Epoch>,
}

/// Times measured since tiles were last dealt.
struct Epoch {
    /// Frames between rebalances.
    length: u32,
    frames: u32,
    /// Microseconds of each tile, by part.
    spent: Vec<Vec<f64>>,
}

impl Owners {
    /// The owners as dealt in `hands` for so many threads, rebalanced every `rebalance_every` frames.
    pub(super) fn of(
        prepared: &Prepared,
        (hands, threads): (&[Hand], usize),
        rebalance_every: Option<NonZeroU32>,
    ) -> Self {
        let mut parts: Vec<Vec<u32>> = prepared.parts.iter().map(|part| vec![0; part.tiles.len()]).collect();
        for (worker, hand) in hands.iter().enumerate() {
            for (part, tile, _) in &hand.tiles {
                parts[part.index()][tile.0 as usize] = worker as u32;
            }
        }
        let nothing = || prepared.parts.iter().map(|part| vec![0.0; part.tiles.len()]).collect();
        let epoch = rebalance_every.map(|length| Epoch { length: length.get(), frames: 0, spent: nothing() });
        Self { parts, workers: hands.len(), threads, epoch }
    }

    /// Appends an LOD of a part: its tiles have the owners of the part's.
    pub(super) fn add_level(&mut self, part: PartId) {
        self.parts.push(self.parts[part.index()].clone());
        if let Some(epoch) = &mut self.epoch {
            epoch.spent.push(vec![0.0; self.parts[part.index()].len()]);
        }
    }

    /// Whether workers have to measure each tile.
    pub(super) fn wants_times(&self) -> bool {
        self.epoch.is_some()
    }

    /// Adds the times of a frame, and rebalances when that is due. The weight of a tile is its time since the last
    /// rebalance, plus a little of its expected cost, so that idle tiles are spread too.
    pub(super) fn book(&mut self, prepared: &Prepared, times: impl Iterator<Item = (PartId, TileId, Duration)>) {
        /// Microseconds per expected nanosecond: counts expected costs as if a tenth of a frame had been measured.
        const EXPECTED: f64 = 1e-4;
        let Some(epoch) = &mut self.epoch else { return };
        for (part, tile, time) in times {
            epoch.spent[part.index()][tile.0 as usize] += 1e6 * time.as_secs_f64();
        }
        epoch.frames += 1;
        if epoch.frames < epoch.length {
            return;
        }
        epoch.frames = 0;
        let mut loads = loads(prepared);
        for (load, spent) in loads.iter_mut().zip(epoch.spent.iter_mut().flatten()) {
            load.weight = EXPECTED * load.weight + std::mem::take(spent);
        }
        let mut owners = vec![0; loads.len()];
        for (worker, hand) in deal(&loads, self.workers, self.threads).into_iter().enumerate() {
            hand.into_iter().for_each(|tile| owners[tile] = worker as u32);
        }
        for ((part, tile, _), worker) in prepared.tiles().zip(owners) {
            self.parts[part.index()][tile.0 as usize] = worker;
        }
    }

    /// Distributes what is due: tiles to their owners, edges round-robin. Returns where each tile is made, too.
    pub(super) fn share(&self, prepared: &Prepared, due: &Due) -> (Vec<Hand>, Vec<Seat>) {
        let mut hands = vec![Hand::default(); self.workers];
        let mut seats = Vec::new();
        for &(part, tile) in &due.tiles {
            let worker = self.parts[part.index()][tile.0 as usize];
            let face = prepared.parts[part.index()].tiles[tile.0 as usize].face;
            let hand = &mut hands[worker as usize].tiles;
            Seat::push(&mut seats, worker, hand.len() as u32);
            hand.push((part, tile, face));
        }
        for (k, &edge) in due.edges.iter().enumerate() {
            hands[k % self.workers].edges.push(edge);
        }
        (hands, seats)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{ModelBuilder, shapes};
    use crate::prepare::{PrepareOptions, prepare};
    use glam::DAffine3;

    #[test]
    fn rebalances_tiles_by_measured_times() {
        let mut model = ModelBuilder::new("boxes");
        for _ in 0..20 {
            let part = model.part(shapes::cuboid());
            model.place(part, DAffine3::IDENTITY);
        }
        let prepared = prepare(model.finish().unwrap(), &PrepareOptions::DEFAULT).unwrap();
        let hands = hands(&prepared, (2, 2), false);
        let mut owners = Owners::of(&prepared, (&hands, 2), NonZeroU32::new(3));
        let before = owners.parts.clone();
        // One worker's tiles take a hundred times as long.
        let owner = before.clone();
        let time = |part: PartId, tile: TileId| {
            let slow = owner[part.index()][tile.0 as usize] == 0;
            Duration::from_micros(if slow { 1000 } else { 10 })
        };
        let load = |owners: &Owners, worker: u32| -> Duration {
            let own = prepared.tiles().filter(|(p, t, _)| owners.parts[p.index()][t.0 as usize] == worker);
            own.map(|(part, tile, _)| time(part, tile)).sum()
        };
        for frame in 1..=3 {
            owners.book(&prepared, prepared.tiles().map(|(part, tile, _)| (part, tile, time(part, tile))));
            assert_eq!(owners.parts == before, frame < 3);
        }
        let [a, b] = [0, 1].map(|worker| load(&owners, worker).as_secs_f64());
        assert!((a / b - 1.0).abs() < 0.05, "{a} {b}");
        let (hands, seats) = owners.share(&prepared, &all_due(&prepared));
        let found = seats.iter().flat_map(|seat| &hands[seat.worker as usize].tiles[seat.rows()]).copied();
        assert!(found.eq(prepared.tiles().map(|(part, tile, row)| (part, tile, row.face))));
    }

    #[test]
    fn four_workers_per_thread_or_one() {
        assert_eq!([0, 1, 2, 8].map(workers_on), [1, 1, 8, 32]);
    }

    fn all_due(prepared: &Prepared) -> Due {
        Due { tiles: prepared.tiles().map(|(part, tile, _)| (part, tile)).collect(), ..Due::default() }
    }
}
