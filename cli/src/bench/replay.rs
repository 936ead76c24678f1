//! Costs of tiles in the frames of a path -> load balance of a way of dealing tiles, for any number of workers.
//!
//! Workers do not exchange work, so a frame ends with its most loaded worker. Efficiency is the mean load of the
//! workers over the maximum, both summed over frames.

use trimtess::parallel::internals::{Load, deal};

/// A way of dealing tiles to workers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Policy {
    /// By weight in windows along the Hilbert curve, as sessions do.
    Windows,
    /// By cost in the last epoch, heaviest first to the least loaded worker. The first epoch is as [`Policy::Windows`].
    Epoch,
    /// By actual cost in each frame, heaviest first. No other way of dealing whole tiles is much better.
    Dynamic,
}

/// Frames of an epoch.
pub(super) const EPOCH: usize = 60;

impl Policy {
    /// Every policy with its name.
    pub(super) const ALL: [(&'static str, Self); 3] =
        [("windows", Self::Windows), ("epoch", Self::Epoch), ("dynamic", Self::Dynamic)];
}

/// Loads of workers in milliseconds, summed over frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Share {
    /// Mean load.
    pub(super) mean: f64,
    /// Maximum load.
    pub(super) most: f64,
}

impl Share {
    /// Mean over maximum; 1 for equal loads.
    pub(super) fn efficiency(&self) -> f64 {
        if self.most > 0.0 { self.mean / self.most } else { 1.0 }
    }

    fn add(&mut self, loads: &[f64]) {
        self.mean += loads.iter().sum::<f64>() / loads.len() as f64;
        self.most += loads.iter().copied().fold(0.0, f64::max);
    }
}

/// Simulates `workers` (at least one) on `frames`: rows of milliseconds per tile. `epoch` (at least one) is the number
/// of rows per epoch.
pub(super) fn replay(policy: Policy, tiles: &[Load], frames: &[Vec<f64>], workers: usize, epoch: usize) -> Share {
    let mut share = Share::default();
    let mut owners = owners(&deal(tiles, workers, workers), tiles.len());
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

fn owners(hands: &[Vec<usize>], tiles: usize) -> Vec<usize> {
    let mut owners = vec![0; tiles];
    for (worker, hand) in hands.iter().enumerate() {
        hand.iter().for_each(|&tile| owners[tile] = worker);
    }
    owners
}

/// Deals the heaviest tiles first, each to the least loaded worker.
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
    fn equal_tiles_give_equal_loads() {
        let (tiles, frames) = (line(64), vec![vec![0.02; 64]; 3]);
        for (name, policy) in Policy::ALL {
            for workers in [1, 2, 4, 32, 64] {
                let share = replay(policy, &tiles, &frames, workers, 1);
                assert!((share.efficiency() - 1.0).abs() < 1e-12, "{name} {workers}: {share:?}");
                assert!((share.mean - 3.0 * 64.0 * 0.02 / workers as f64).abs() < 1e-12);
            }
        }
        assert_eq!(efficiency(Policy::Windows, &[], &[vec![]], 3), 1.0);
    }

    #[test]
    fn a_zoom_into_one_end_loads_all_workers() {
        let tiles = line(64);
        let mut costs = vec![0.0; 64];
        costs[..16].fill(0.01);
        let frames = [costs];
        assert!(efficiency(Policy::Windows, &tiles, &frames, 4) > 0.9);
        assert!((efficiency(Policy::Dynamic, &tiles, &frames, 4) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn one_expensive_tile_bounds_every_policy() {
        let mut costs = vec![0.01; 16];
        costs[7] = 0.32;
        let mut tiles = line(16);
        tiles.iter_mut().zip(&costs).for_each(|(tile, cost)| tile.weight = *cost);
        let frames = [costs];
        let bound = (0.15 + 0.32) / 4.0 / 0.32;
        for (name, policy) in Policy::ALL {
            assert!(efficiency(policy, &tiles, &frames, 4) <= bound + 1e-12, "{name}");
        }
        assert!((efficiency(Policy::Dynamic, &tiles, &frames, 4) - bound).abs() < 1e-12);
    }

    #[test]
    fn an_epoch_is_dealt_by_the_costs_of_the_last_one() {
        let tiles = line(8);
        let costs: Vec<f64> = [8.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.0].to_vec();
        let first = replay(Policy::Epoch, &tiles, std::slice::from_ref(&costs), 2, 1);
        assert_eq!(first, replay(Policy::Windows, &tiles, std::slice::from_ref(&costs), 2, 1));
        let both = replay(Policy::Epoch, &tiles, &[costs.clone(), costs], 2, 1);
        assert_eq!(both.most - first.most, 8.0);
    }
}
