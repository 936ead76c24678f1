//! Tiles that should change, and a budget of time -> those that change now. The others keep their rates until a later
//! frame, so the plan is closed whatever is deferred.
//!
//! When a tile changes, its neighbours are rebuilt, because they share its edges. So tiles are taken in clusters: from
//! the most urgent one outwards, through neighbours that should change, too. Only the rim of a cluster is rebuilt
//! twice.

use super::draft::WantedRate;
use crate::control::{Call, map};
use crate::frame::plan::output::{PartPlan, Plan, cells};
use crate::math::BitMix;
use crate::math::bits::ordered;
use crate::prepare::Prepared;
use crate::prepare::internals::{EdgeUse, Tile, nanoseconds};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashSet, VecDeque};
use std::hash::BuildHasherDefault;
use std::time::Duration;

/// Steps by which a tile of a cluster may be less urgent than the one that began it: a quarter of its error.
const LESS_URGENT: f64 = 4.0;

/// Two numbers: a part and a tile, or a list and a place in it.
type Pair = (usize, usize);

type Pairs = HashSet<Pair, BuildHasherDefault<BitMix>>;

/// A list of tiles that should change, ascending.
struct Waiting {
    rates: Vec<WantedRate>,
    /// Places of those that have not begun a cluster. The last one is the most urgent; of several, the first tile.
    order: Vec<u32>,
}

impl Waiting {
    fn of(rates: Vec<WantedRate>) -> Self {
        let mut order: Vec<u32> = (0..rates.len() as u32).collect();
        order.sort_unstable_by_key(|&k| (ordered(rates[k as usize].urgency), Reverse(k)));
        Self { rates, order }
    }

    /// Takes the place of the most urgent tile, with its urgency. `list`: the number of this list.
    fn next(&mut self, list: usize) -> Option<(i64, Reverse<Pair>)> {
        let place = self.order.pop()? as usize;
        Some((ordered(self.rates[place].urgency), Reverse((list, place))))
    }
}

/// Takes those of `wanted` that the budget allows, the most urgent first, at least one. Returns them ascending, and how
/// many wait; `None` once cancelled. `page`: the plan before they change. The lists are not empty, and all together
/// ascend by part and tile.
///
/// Threads order lists side by side. The rest runs on one thread: its cost follows the number of lists and the tiles
/// that are taken.
pub(super) fn within(
    call: Call<'_>,
    budget: Duration,
    wanted: Vec<Vec<WantedRate>>,
    (prepared, page): (&Prepared, &Plan),
) -> Option<(Vec<WantedRate>, usize)> {
    let count: usize = wanted.iter().map(Vec::len).sum();
    let mut lists = map(call.jobs, wanted, Waiting::of);
    let mut seeds: BinaryHeap<_> = lists.iter_mut().enumerate().filter_map(|(k, list)| list.next(k)).collect();

    let mut left = budget.as_secs_f64() * 1e9;
    let cost = |(p, t): Pair, growth: f64| predicted(&page.parts[p], &prepared.parts[p].tiles[t], t, growth);
    let (mut now, mut rebuilt) = (Pairs::default(), Pairs::default());
    let mut cluster = VecDeque::new();
    'seeds: while let Some((_, Reverse(seed))) = seeds.pop() {
        seeds.extend(lists[seed.0].next(seed.0));
        call.goes_on()?;
        let least = lists[seed.0].rates[seed.1].urgency - LESS_URGENT;
        cluster.push_back(seed);
        while let Some(place) = cluster.pop_front() {
            if !now.insert(place) {
                continue;
            }
            let wanted = &lists[place.0].rates[place.1];
            let (part, tile) = (wanted.part, wanted.tile);
            let before = if rebuilt.insert((part, tile)) { 0.0 } else { cost((part, tile), 1.0) };
            left -= cost((part, tile), wanted.growth) - before;
            let part_of = &prepared.parts[part];
            let uses = part_of.tiles[tile].loops.iter().flatten();
            for place in uses.flat_map(|u| &part_of.edges[u.edge.index()].uses) {
                let neighbour = (part, place.tile.index());
                if rebuilt.insert(neighbour) {
                    left -= cost(neighbour, 1.0);
                }
                let joins = |place: &Pair| !now.contains(place) && lists[place.0].rates[place.1].urgency >= least;
                cluster.extend(place_of(&lists, neighbour).filter(joins));
            }
            if left <= 0.0 {
                break 'seeds;
            }
        }
    }
    // From the end: none of those before it moves.
    let mut places: Vec<Pair> = now.into_iter().collect();
    places.sort_unstable_by_key(|&place| Reverse(place));
    let mut taken: Vec<_> = places.into_iter().map(|(list, k)| lists[list].rates.swap_remove(k)).collect();
    taken.reverse();
    // On all threads: what waits may be many times what was taken.
    map(call.jobs, lists, drop);
    let waiting = count - taken.len();
    Some((taken, waiting))
}

/// Where a tile is, if it should change.
fn place_of(lists: &[Waiting], tile: Pair) -> Option<Pair> {
    let row = |wanted: &WantedRate| (wanted.part, wanted.tile);
    let list = lists.partition_point(|list| row(&list.rates[0]) <= tile).checked_sub(1)?;
    Some((list, lists[list].rates.binary_search_by_key(&tile, row).ok()?))
}

/// Predicted time of a tile in nanoseconds, with its number of cells scaled by `growth` and its boundary tessellants by
/// √`growth`.
fn predicted(plan: &PartPlan, tile: &Tile, t: usize, growth: f64) -> f64 {
    let tessellants = |u: &EdgeUse| {
        let breaks = &plan.edges[u.edge.index()].breaks;
        let at = |k: u32| breaks.get(k as usize).copied().unwrap_or(0);
        f64::from(at(u.from).abs_diff(at(u.to)))
    };
    let boundary: f64 = tile.loops.iter().flatten().map(tessellants).sum();
    nanoseconds(growth * cells(&plan.tiles[t]) as f64, growth.sqrt() * boundary)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{Alone, Control, Jobs, Threads};
    use crate::frame::live::rate::Rate;
    use crate::frame::plan::limits::PlanLimits;
    use crate::frame::plan::make::plan_within;
    use crate::frame::tolerance::Tolerance;
    use crate::model::{ModelBuilder, shapes};
    use crate::prepare::{PrepareOptions, prepare};
    use crate::sequence::random::SplitMix;
    use glam::DAffine3;

    fn a_scene() -> (Prepared, Plan) {
        let mut model = ModelBuilder::new("many");
        for name in ["box", "torus", "washer", "flower", "wave", "sphere"].into_iter().cycle().take(60) {
            let part = model.part(shapes::by_name(name).expect("a shape").parts.swap_remove(0));
            model.place(part, DAffine3::IDENTITY);
        }
        let prepared = prepare(model.finish().expect("a model"), &PrepareOptions::DEFAULT).expect("within the limits");
        let tolerance = Tolerance { chord: 0.01 * prepared.diagonal, angle: 0.5, max_edge: None };
        let plan = plan_within(&prepared, &tolerance, &PlanLimits::DEFAULT);
        (prepared, plan)
    }

    /// Some tiles in lists. Few different urgencies, so that many are the same.
    fn some(prepared: &Prepared, draw: &mut SplitMix) -> Vec<Vec<WantedRate>> {
        let mut lists = vec![Vec::new()];
        for (part, tile, _) in prepared.tiles() {
            if draw.unit() < 0.3 {
                continue;
            }
            let (urgency, growth) = (draw.below(9) as f64 - 2.0, 1.0 + draw.unit());
            let (part, tile, rate) = (part.index(), tile.index(), Rate::Even(None));
            let wanted = WantedRate { urgency, growth, part, tile, rate, band: (0.0, 0.0), chord: 1.0 };
            lists.last_mut().expect("not empty").push(wanted);
            if draw.unit() < 0.1 {
                lists.push(Vec::new());
            }
        }
        lists.retain(|list| !list.is_empty());
        lists
    }

    /// As [`within`], in one sort of all.
    fn sorted(budget: Duration, wanted: &[&WantedRate], prepared: &Prepared, page: &Plan) -> Vec<Pair> {
        let mut order: Vec<&WantedRate> = wanted.to_vec();
        order.sort_by(|a, b| b.urgency.total_cmp(&a.urgency).then((a.part, a.tile).cmp(&(b.part, b.tile))));
        let mut left = budget.as_secs_f64() * 1e9;
        let cost = |(p, t): Pair, growth: f64| predicted(&page.parts[p], &prepared.parts[p].tiles[t], t, growth);
        let (mut now, mut rebuilt) = (Vec::new(), Vec::new());
        'seeds: for seed in &order {
            let mut cluster = VecDeque::from([*seed]);
            while let Some(WantedRate { part, tile, growth, .. }) = cluster.pop_front() {
                let row = (*part, *tile);
                if now.contains(&row) {
                    continue;
                }
                now.push(row);
                left -= cost(row, *growth) - if rebuilt.contains(&row) { cost(row, 1.0) } else { 0.0 };
                rebuilt.push(row);
                let part_of = &prepared.parts[*part];
                let uses = part_of.tiles[*tile].loops.iter().flatten();
                for place in uses.flat_map(|u| &part_of.edges[u.edge.index()].uses) {
                    let neighbour = (*part, place.tile.index());
                    if !rebuilt.contains(&neighbour) {
                        rebuilt.push(neighbour);
                        left -= cost(neighbour, 1.0);
                    }
                    let joins = |with: &&&WantedRate| {
                        (with.part, with.tile) == neighbour && with.urgency >= seed.urgency - LESS_URGENT
                    };
                    cluster.extend(order.iter().find(joins));
                }
                if left <= 0.0 {
                    break 'seeds;
                }
            }
        }
        now.sort_unstable();
        now
    }

    #[test]
    fn lists_by_urgency_take_what_one_sort_of_all_takes() {
        let (prepared, page) = a_scene();
        let pools: [&dyn Jobs; 2] = [&Alone, &Threads::start(3).expect("threads")];
        let (mut draw, mut between, control) = (SplitMix(7), 0, Control::default());
        for round in 0..60 {
            let lists = some(&prepared, &mut draw);
            let all: Vec<&WantedRate> = lists.iter().flatten().collect();
            let (count, budget) = (all.len(), Duration::from_nanos(1 << (round % 25)));
            let expected = sorted(budget, &all, &prepared, &page);
            let call = Call::new(pools[round % 2], &control);
            let (taken, waiting) = within(call, budget, lists, (&prepared, &page)).expect("not cancelled");
            assert_eq!(taken.iter().map(|wanted| (wanted.part, wanted.tile)).collect::<Vec<_>>(), expected, "{round}");
            assert!(!taken.is_empty() && taken.len() + waiting == count);
            between += usize::from(waiting > 0 && taken.len() > 1);
        }
        assert!(between > 9, "{between}");
    }
}
