//! What tiles cost in the frames of a path -> how evenly a way to deal them loads any number of workers.
//!
//! Workers never talk to each other, so that a frame's work is over when the one with the most has done it: efficiency is the mean
//! of the workers' loads over the largest, both summed over the frames.

use trimtess::parallel::internals::{Load, along_curve, deal};

/// A way to deal tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Policy {
    /// Windows along the Hilbert curve, by weight: what sessions do.
    Windows,
    /// The same, were tiles cut so that none ever costs more than [`CAP`].
    Capped,
    /// One stretch of the Hilbert curve each, of equal weight.
    Contiguous,
    /// By lot.
    Random,
    /// By what they cost in the epoch before, heaviest first to the least loaded; the first as [`Policy::Windows`].
    Epoch,
    /// By what they are about to cost, frame by frame: no order of dealing whole tiles does much better.
    Dynamic,
}

/// Most milliseconds of a tile of [`Policy::Capped`].
pub(super) const CAP: f64 = 0.03;
/// Frames of an epoch.
pub(super) const EPOCH: usize = 60;

impl Policy {
    pub(super) const ALL: [Self; 6] =
        [Self::Windows, Self::Capped, Self::Contiguous, Self::Random, Self::Epoch, Self::Dynamic];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Windows => "windows",
            Self::Capped => "capped",
            Self::Contiguous => "contiguous",
            Self::Random => "random",
            Self::Epoch => "epoch",
            Self::Dynamic => "dynamic",
        }
    }
}

/// Milliseconds of workers, summed over frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Share {
    /// Of all workers' loads the mean.
    pub(super) mean: f64,
    /// The largest load.
    pub(super) most: f64,
}

impl Share {
    /// 1 when all have the same to do.
    pub(super) fn efficiency(&self) -> f64 {
        if self.most > 0.0 { self.mean / self.most } else { 1.0 }
    }

    fn add(&mut self, loads: &[f64]) {
        self.mean += loads.iter().sum::<f64>() / loads.len() as f64;
        self.most += loads.iter().copied().fold(0.0, f64::max);
    }
}

/// Deals `tiles` to `workers` (at least one) and has them work through `frames`: rows of milliseconds, one for each tile. An epoch
/// is `epoch` rows (at least one).
pub(super) fn replay(policy: Policy, tiles: &[Load], frames: &[Vec<f64>], workers: usize, epoch: usize) -> Share {
    let mut share = Share::default();
    if policy == Policy::Capped {
        let (tiles, frames) = capped(tiles, frames);
        return replay(Policy::Windows, &tiles, &frames, workers, epoch);
    }
    let mut owners = match policy {
        Policy::Windows | Policy::Epoch | Policy::Capped | Policy::Dynamic => {
            owners(&deal(tiles, workers), tiles.len())
        }
        Policy::Contiguous => stretches(tiles, workers),
        Policy::Random => lots(tiles.len(), workers),
    };
    for (k, costs) in frames.iter().enumerate() {
        match policy {
            Policy::Dynamic => owners = heaviest_first(costs, workers),
            Policy::Epoch if k >= epoch && k % epoch == 0 => {
                owners = heaviest_first(&sums(&frames[k - epoch..k]), workers)
            }
            _ => {}
        }
        let mut loads = vec![0.0; workers];
        for (&owner, cost) in owners.iter().zip(costs) {
            loads[owner] += cost;
        }
        share.add(&loads);
    }
    share
}

/// The owner of each tile.
fn owners(hands: &[Vec<usize>], tiles: usize) -> Vec<usize> {
    let mut owners = vec![0; tiles];
    for (worker, hand) in hands.iter().enumerate() {
        hand.iter().for_each(|&tile| owners[tile] = worker);
    }
    owners
}

fn stretches(tiles: &[Load], workers: usize) -> Vec<usize> {
    let total: f64 = tiles.iter().map(|tile| tile.weight).sum();
    let mut owners = vec![0; tiles.len()];
    let mut before = 0.0;
    for tile in along_curve(tiles) {
        let middle = before + 0.5 * tiles[tile].weight;
        owners[tile] = ((middle / total * workers as f64) as usize).min(workers - 1);
        before += tiles[tile].weight;
    }
    owners
}

/// Tiles in an order of their own, one to each worker in turn. The same in every run.
fn lots(tiles: usize, workers: usize) -> Vec<usize> {
    // A step of Knuth's MMIX generator; its upper bits are good.
    let next = |state: &mut u64| {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        *state >> 33
    };
    let mut state = 1;
    let mut owners: Vec<usize> = (0..tiles).map(|k| k % workers).collect();
    for k in (1..tiles).rev() {
        owners.swap(k, next(&mut state) as usize % (k + 1));
    }
    owners
}

/// Heaviest first, each to the worker with the least so far.
fn heaviest_first(costs: &[f64], workers: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..costs.len()).collect();
    order.sort_by(|&a, &b| costs[b].total_cmp(&costs[a]));
    let mut loads = vec![0.0; workers];
    let mut owners = vec![0; costs.len()];
    for tile in order {
        let least = (0..workers).min_by(|&a, &b| f64::total_cmp(&loads[a], &loads[b])).unwrap_or(0);
        owners[tile] = least;
        loads[least] += costs[tile];
    }
    owners
}

fn sums(frames: &[Vec<f64>]) -> Vec<f64> {
    let mut sums = vec![0.0; frames.first().map_or(0, Vec::len)];
    for costs in frames {
        sums.iter_mut().zip(costs).for_each(|(sum, cost)| *sum += cost);
    }
    sums
}

/// Tiles in equal pieces, as many as it takes that none costs more than [`CAP`] in any frame.
fn capped(tiles: &[Load], frames: &[Vec<f64>]) -> (Vec<Load>, Vec<Vec<f64>>) {
    let most = |tile: usize| frames.iter().map(|costs| costs[tile]).fold(0.0, f64::max);
    let pieces: Vec<usize> = (0..tiles.len()).map(|tile| ((most(tile) / CAP).ceil() as usize).max(1)).collect();
    let cut = |whole: &dyn Fn(usize) -> f64| -> Vec<f64> {
        pieces.iter().enumerate().flat_map(|(tile, &n)| std::iter::repeat_n(whole(tile) / n as f64, n)).collect()
    };
    let weights = cut(&|tile| tiles[tile].weight);
    let centres = pieces.iter().zip(tiles).flat_map(|(&n, tile)| std::iter::repeat_n(tile.centre, n));
    let loads = centres.zip(weights).map(|(centre, weight)| Load { centre, weight }).collect();
    (loads, frames.iter().map(|costs| cut(&|tile| costs[tile])).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use trimtess::glam::DVec3;

    /// Tiles along a line, of equal weight.
    fn line(count: usize) -> Vec<Load> {
        (0..count).map(|k| Load { centre: DVec3::X * k as f64, weight: 1.0 }).collect()
    }

    fn efficiency(policy: Policy, tiles: &[Load], frames: &[Vec<f64>], workers: usize) -> f64 {
        replay(policy, tiles, frames, workers, 1).efficiency()
    }

    #[test]
    fn equal_tiles_are_equal_loads_and_one_worker_is_always_even() {
        let (tiles, frames) = (line(64), vec![vec![0.02; 64]; 3]);
        for policy in Policy::ALL {
            for workers in [1, 2, 4, 32, 64] {
                let share = replay(policy, &tiles, &frames, workers, 1);
                assert!((share.efficiency() - 1.0).abs() < 1e-12, "{policy:?} {workers}: {share:?}");
                assert!((share.mean - 3.0 * 64.0 * 0.02 / workers as f64).abs() < 1e-12);
            }
        }
        assert_eq!(efficiency(Policy::Windows, &[], &[vec![]], 3), 1.0);
    }

    #[test]
    fn a_zoom_into_one_end_loads_one_worker_of_those_with_stretches() {
        let tiles = line(64);
        let mut costs = vec![0.0; 64];
        costs[..16].fill(0.01);
        let frames = [costs];
        assert!((efficiency(Policy::Contiguous, &tiles, &frames, 4) - 0.25).abs() < 1e-12);
        assert!(efficiency(Policy::Windows, &tiles, &frames, 4) > 0.9);
        assert!((efficiency(Policy::Dynamic, &tiles, &frames, 4) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn one_costly_tile_bounds_everything_but_what_cuts_it() {
        let mut costs = vec![0.01; 16];
        costs[7] = 0.32;
        let mut tiles = line(16);
        tiles.iter_mut().zip(&costs).for_each(|(tile, cost)| tile.weight = *cost);
        let frames = [costs];
        let bound = (0.15 + 0.32) / 4.0 / 0.32;
        for policy in [Policy::Windows, Policy::Random, Policy::Epoch, Policy::Dynamic] {
            assert!(efficiency(policy, &tiles, &frames, 4) <= bound + 1e-12, "{policy:?}");
        }
        assert!((efficiency(Policy::Dynamic, &tiles, &frames, 4) - bound).abs() < 1e-12);
        assert!(efficiency(Policy::Capped, &tiles, &frames, 4) > 2.0 * bound);
    }

    #[test]
    fn an_epoch_is_dealt_by_what_the_one_before_cost() {
        let tiles = line(8);
        let costs: Vec<f64> = [8.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.0].to_vec();
        let first = replay(Policy::Epoch, &tiles, std::slice::from_ref(&costs), 2, 1);
        assert_eq!(first, replay(Policy::Windows, &tiles, std::slice::from_ref(&costs), 2, 1));
        let both = replay(Policy::Epoch, &tiles, &[costs.clone(), costs], 2, 1);
        assert_eq!(both.most - first.most, 8.0);
    }
}
