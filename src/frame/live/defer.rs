//! Tiles that should change, and a budget of time -> those that change now. The others keep their rates until a later
//! frame, so the plan is closed whatever is deferred.
//!
//! When a tile changes, its neighbours are rebuilt, because they share its edges. So tiles are taken in clusters: from the
//! most urgent one outwards, through neighbours that should change, too. Only the rim of a cluster is rebuilt twice.

use super::draft::WantedRate;
use crate::frame::plan::budget::predicted;
use crate::frame::plan::output::Plan;
use crate::math::BitMix;
use crate::prepare::Prepared;
use std::collections::{HashMap, HashSet, VecDeque};
use std::hash::BuildHasherDefault;
use std::time::Duration;

/// Steps by which a tile of a cluster may be less urgent than the one that began it: a quarter of its error.
const LESS_URGENT: f64 = 4.0;

/// A part and a tile.
type Row = (usize, usize);

type Rows<T> = HashMap<Row, T, BuildHasherDefault<BitMix>>;

/// Takes those of `wanted` that the budget allows, the most urgent first, at least one. `page`: the plan before they
/// change.
pub(super) fn within(budget: Duration, wanted: Vec<WantedRate>, prepared: &Prepared, page: &Plan) -> Vec<WantedRate> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    let row = |k: usize| (wanted[k].part, wanted[k].tile);
    order.sort_by(|&a, &b| wanted[b].urgency.total_cmp(&wanted[a].urgency).then(row(a).cmp(&row(b))));
    let of_row: Rows<usize> = (0..wanted.len()).map(|k| (row(k), k)).collect();

    let mut left = budget.as_secs_f64() * 1e9;
    let cost = |(p, t): Row, growth: f64| predicted(&page.parts[p], &prepared.parts[p].tiles[t], t, growth);
    let mut now = vec![false; wanted.len()];
    let mut rebuilt: HashSet<Row, BuildHasherDefault<BitMix>> = HashSet::default();
    let mut cluster = VecDeque::new();
    'seeds: for seed in order {
        cluster.push_back(seed);
        while let Some(k) = cluster.pop_front() {
            if std::mem::replace(&mut now[k], true) {
                continue;
            }
            let (part, tile) = row(k);
            let before = if rebuilt.insert((part, tile)) { 0.0 } else { cost((part, tile), 1.0) };
            left -= cost((part, tile), wanted[k].growth) - before;
            let part_of = &prepared.parts[part];
            let uses = part_of.tiles[tile].loops.iter().flatten();
            for place in uses.flat_map(|u| &part_of.edges[u.edge.index()].uses) {
                let neighbour = (part, place.tile.index());
                if rebuilt.insert(neighbour) {
                    left -= cost(neighbour, 1.0);
                }
                let joins = |&&k: &&usize| !now[k] && wanted[k].urgency >= wanted[seed].urgency - LESS_URGENT;
                cluster.extend(of_row.get(&neighbour).filter(joins));
            }
            if left <= 0.0 {
                break 'seeds;
            }
        }
    }
    let mut now = now.into_iter();
    wanted.into_iter().filter(|_| now.next() == Some(true)).collect()
}
