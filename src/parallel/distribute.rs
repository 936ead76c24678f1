//! Weighted tile centres -> one list of tiles per worker. Neighbouring runs of a few tiles go to different workers.
//!
//! Method: Kumar & Manocha 1995, section 6 (neighbouring patches onto different processors, statically), made concrete
//! as stratified dealing. Runs of tiles that follow each other in the model are sorted along a Hilbert curve through
//! their centres. Each window of a few consecutive runs per worker is dealt heaviest first, each run to the worker with
//! the least load so far. A zoom into one corner is a stretch of the curve and thus loads every worker.
//!
//! Tiles of a run have edges in common, which are in the caches of whoever makes them, and their results are next to
//! each other when a frame is committed.

use crate::math::sphere_tree::along_curve;
use crate::model::{PartId, TileId};
use crate::prepare::Prepared;
use crate::prepare::internals::Tile;
use glam::DVec3;
use std::ops::Range;

/// Position and expected cost of one tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// Centre of the tile, in coordinates common to all tiles. Finite.
    pub centre: DVec3,
    /// Expected cost, in any unit common to all tiles; positive and finite.
    pub weight: f64,
}

/// The load of each tile, in the order of [`Prepared::tiles`]. Tiles are placed as in their part's first instance.
#[must_use]
pub fn loads(prepared: &Prepared) -> Vec<Load> {
    let mut place = vec![None; prepared.parts.len()];
    for instance in &prepared.scene.instances {
        if let Some(place) = place.get_mut(instance.part.index()) {
            place.get_or_insert(instance.transform);
        }
    }
    let load = |(part, _, tile): (PartId, TileId, &Tile)| {
        let centre = place[part.index()].map_or(tile.centre, |place| place.transform_point3(tile.centre));
        Load { centre, weight: tile.weight }
    };
    prepared.tiles().map(load).collect()
}

/// Runs per worker in a window. With 1, a worker that got a run as heavy as a hundred others still gets another one
/// in each window that follows. With many more, the tiles of one worker would no longer be spread along the curve.
const WINDOW: usize = 4;
/// Most tiles of a run. On few threads, a small view of a large model loads only some workers if runs are longer.
const RUN: usize = 256;
/// Several tiles are a run only if they weigh no more than a thread's share divided by this,
const RUNS_PER_THREAD: usize = 16;
/// and a worker's share divided by this: threads even out what their workers differ by.
const RUNS_PER_WORKER: usize = 4;

/// Deals tiles to workers: element `w` of the result holds worker `w`'s indices into `loads`, ascending.
///
/// Every index is dealt exactly once. The workers' total weights differ by at most the largest weight, or if that is
/// more, a sixteenth of what each of `threads` threads would get, but no more than a quarter of their mean.
/// Deterministic. `O(n (log n + workers))`. 0 `workers` and `threads` are treated as 1.
#[must_use]
pub fn deal(loads: &[Load], workers: usize, threads: usize) -> Vec<Vec<usize>> {
    let workers = workers.max(1);
    let runs = runs(loads, heaviest_run(loads, workers, threads));
    let weights: Vec<f64> = runs.iter().map(|run| weight(&loads[run.clone()])).collect();
    let centre = |run: &Range<usize>| loads[run.clone()].iter().map(|l| l.centre).sum::<DVec3>() / run.len() as f64;
    let curve = along_curve(runs.iter().map(centre));
    let mut hands = vec![Vec::with_capacity(loads.len().div_ceil(workers)); workers];
    let mut sums = vec![0.0_f64; workers];
    let mut window: Vec<usize> = Vec::with_capacity(WINDOW * workers);
    for chunk in curve.chunks(WINDOW * workers) {
        window.clear();
        window.extend_from_slice(chunk);
        // Stable: runs of the same weight are dealt along the curve. By their index, every other one would go to the
        // same worker where runs lie side by side.
        window.sort_by(|&a, &b| weights[b].total_cmp(&weights[a]));
        for &run in &window {
            let least = (0..workers).min_by(|&a, &b| f64::total_cmp(&sums[a], &sums[b])).unwrap_or(0);
            hands[least].extend(runs[run].clone());
            sums[least] += weights[run];
        }
    }
    for hand in &mut hands {
        hand.sort_unstable();
    }
    hands
}

/// The most that several tiles of a run weigh.
fn heaviest_run(loads: &[Load], workers: usize, threads: usize) -> f64 {
    let count = (RUNS_PER_THREAD * threads.max(1)).max(RUNS_PER_WORKER * workers);
    weight(loads) / count as f64
}

/// Cuts the tiles into runs that weigh `most`, or have one tile.
fn runs(loads: &[Load], most: f64) -> Vec<Range<usize>> {
    let (mut runs, mut first, mut sum) = (Vec::new(), 0, 0.0);
    for (tile, load) in loads.iter().enumerate() {
        if tile > first && (tile - first == RUN || sum + load.weight > most) {
            runs.push(first..tile);
            (first, sum) = (tile, 0.0);
        }
        sum += load.weight;
    }
    runs.extend((first < loads.len()).then_some(first..loads.len()));
    runs
}

fn weight(loads: &[Load]) -> f64 {
    loads.iter().map(|load| load.weight).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::judge;
    use arbitrary::Unstructured;

    #[test]
    fn every_tile_is_dealt_once_and_sums_differ_by_one_run_at_most() {
        let property = |u: &mut Unstructured<'_>| -> arbitrary::Result<()> {
            let count = u.int_in_range(0..=400_usize)?;
            let mut loads = Vec::with_capacity(count);
            for _ in 0..count {
                let mut coordinate = || Ok(f64::from(u.int_in_range(-1000..=1000_i32)?));
                let centre = DVec3::new(coordinate()?, coordinate()?, coordinate()?);
                loads.push(Load { centre, weight: f64::from(u.int_in_range(1..=100_u32)?) });
            }
            let (workers, threads) = (u.int_in_range(1..=9_usize)?, u.int_in_range(0..=9_usize)?);
            let hands = deal(&loads, workers, threads);
            assert_eq!(hands, deal(&loads, workers, threads));
            assert_eq!(hands.len(), workers);
            assert!(hands.iter().all(|hand| hand.is_sorted()));
            let mut all = hands.concat();
            all.sort_unstable();
            assert!(all.iter().copied().eq(0..count));
            let sums: Vec<f64> = hands.iter().map(|h| h.iter().map(|&i| loads[i].weight).sum()).collect();
            let spread = sums.iter().copied().fold(0.0, f64::max) - sums.iter().copied().fold(f64::INFINITY, f64::min);
            let run = heaviest_run(&loads, workers, threads);
            assert!(run <= 0.25 * weight(&loads) / workers as f64);
            assert!(spread <= loads.iter().map(|l| l.weight).fold(run, f64::max), "{sums:?}");
            Ok(())
        };
        judge!(1_000, 8192, |bytes: &[u8]| property(&mut Unstructured::new(bytes)).is_ok());
    }

    #[test]
    fn any_corner_of_a_grid_loads_every_worker() {
        let at = |x: u32, y: u32| DVec3::new(f64::from(x), f64::from(y), 0.0);
        let cells: Vec<(u32, u32)> = (0..32).flat_map(|x| (0..32).map(move |y| (x, y))).collect();
        let loads: Vec<Load> = cells.iter().map(|&(x, y)| Load { centre: at(x, y), weight: 1.0 }).collect();
        for workers in [2, 4, 8] {
            let hands = deal(&loads, workers, workers);
            for corner in [(0, 0), (0, 24), (24, 0), (24, 24), (12, 12)] {
                let inside = |i: usize| {
                    (corner.0..corner.0 + 8).contains(&cells[i].0) && (corner.1..corner.1 + 8).contains(&cells[i].1)
                };
                let shares: Vec<usize> = hands.iter().map(|h| h.iter().filter(|&&i| inside(i)).count()).collect();
                let fair = 64 / workers;
                assert!(
                    shares.iter().all(|&s| s >= fair / 2 && s <= fair * 2),
                    "{workers} workers, {corner:?}: {shares:?}"
                );
            }
        }
    }
}
