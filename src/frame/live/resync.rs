//! Frame numbers -> tiles to resynchronise: tiles with incrementally updated lines take turns to replace all of them.

use super::split::{LastLines, LinePlacement, SplitRule};
use crate::prepare::internals::{PreparedEdge, PreparedPart};
use std::num::NonZeroU32;

/// The schedule of resynchronisation.
#[derive(Clone, Copy)]
pub(crate) struct Turns {
    split: Option<(SplitRule, f64)>,
    every: Option<NonZeroU32>,
    frame: u64,
    /// Frames since the last movement.
    still: u64,
}

impl Turns {
    pub(crate) fn of(lines: LinePlacement) -> Self {
        let (split, every) = match lines {
            LinePlacement::Spread => (None, None),
            LinePlacement::Split { intensive, most, resync } => (Some((intensive, most)), resync),
        };
        Self { split, every, frame: 0, still: 0 }
    }

    /// Advances to the next frame.
    pub(crate) fn pass(&mut self, is_still: bool) {
        self.frame += 1;
        self.still = if is_still { self.still + 1 } else { 0 };
    }

    /// Whether turns are pending while nothing moves. Every tile takes two turns: edges depend on the adjacent
    /// lattices, so they are free of history only once these are.
    pub(crate) fn are_left(&self) -> bool {
        self.every.is_some_and(|every| self.still < 2 * u64::from(every.get()))
    }

    /// Whether tiles take turns at all.
    pub(crate) fn are_taken(&self) -> bool {
        self.every.is_some()
    }

    fn has(&self, part: usize, tile: usize) -> bool {
        // Multiples of the golden ratio are spread evenly.
        let scattered = ((part as u64) << 32 | tile as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
        self.every.is_some_and(|every| (self.frame + scattered).is_multiple_of(u64::from(every.get())))
    }

    /// The lines to update incrementally; `None` if all lines are replaced.
    pub(crate) fn follow<'a, T: ?Sized>(&self, last: &'a T, replace: bool) -> Option<LastLines<'a, T>> {
        self.split.filter(|_| !replace).map(|(intensive, most)| LastLines { last, intensive, most })
    }
}

/// Tiles and edges of a part whose lines depend on history: updated incrementally since they were last all replaced.
#[derive(Default)]
pub(crate) struct LineHistory {
    pub(crate) tiles: Vec<bool>,
    pub(crate) edges: Vec<bool>,
    /// Tiles whose turn has come and is not done.
    pub(crate) due: Vec<bool>,
}

impl LineHistory {
    pub(crate) fn none(part: &PreparedPart) -> Self {
        let (tiles, edges) = (part.tiles.len(), part.edges.len());
        Self { tiles: vec![false; tiles], edges: vec![false; edges], due: vec![false; tiles] }
    }

    /// Whether a drawn tile has to be resynchronised. If so, its `due` is to be set until it is done.
    pub(crate) fn is_due(
        &self,
        turns: &Turns,
        part: &PreparedPart,
        (p, t): (usize, usize),
        is_drawn: impl Fn(usize) -> bool,
    ) -> bool {
        let mut uses = part.tiles[t].loops.iter().flatten().map(|u| u.edge.index());
        let mut owns = || uses.any(|e| self.edges[e] && owner(&part.edges[e], &is_drawn) == Some(t));
        self.due[t] || turns.has(p, t) && (self.tiles[t] || owns())
    }
}

/// The tile whose turn resynchronises an edge: the first one that is drawn.
pub(crate) fn owner(edge: &PreparedEdge, is_drawn: impl Fn(usize) -> bool) -> Option<usize> {
    edge.uses.iter().map(|place| place.tile.index()).find(|&tile| is_drawn(tile))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_take_evenly_spread_turns() {
        let mut turns = Turns::of(LinePlacement::Split {
            intensive: SplitRule::LongestFirst,
            most: 2.0,
            resync: NonZeroU32::new(10),
        });
        let mut count = vec![0; 1000];
        for _ in 0..10 {
            turns.pass(false);
            let now: Vec<usize> = (0..1000).filter(|&tile| turns.has(3, tile)).collect();
            assert!((80..120).contains(&now.len()), "{}", now.len());
            now.into_iter().for_each(|tile| count[tile] += 1);
        }
        assert!(count.iter().all(|&turns| turns == 1));
        let left = (0..100).take_while(|_| {
            turns.pass(true);
            turns.are_left()
        });
        assert_eq!(left.count(), 19);
        let mut never = Turns::of(LinePlacement::Split { intensive: SplitRule::Criterion, most: 2.0, resync: None });
        never.pass(true);
        assert!(!never.are_left() && !never.has(0, 0) && !Turns::of(LinePlacement::Spread).are_left());
    }
}
