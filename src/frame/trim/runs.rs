//! A list of numbers in an order that only a search knows: it inserts and removes without moving many.

use super::input::NONE;

/// Most numbers of a run.
const MOST: usize = 64;

/// A list of numbers, each once, as runs in the order of the list. There is always a first run, and no other is empty.
///
/// Each number has a key, which says about where it is. A search finds the run by the first keys of runs, and the place
/// by the keys in it, which are close together in memory. It asks about numbers themselves only to prove the place, or
/// to find it if the keys are wrong.
pub(crate) struct Runs {
    /// The runs, by their place in the list.
    order: Vec<u32>,
    runs: Vec<Run>,
    /// By number, its run, or [`NONE`] if it is not in the list.
    run_of: Vec<u32>,
    /// Where the last insertion was. The next one is often near.
    recent: Place,
}

#[derive(Clone, Copy)]
struct Run {
    count: usize,
    /// Keys and numbers.
    entries: [(f32, u32); MOST],
}

/// A place between the numbers of a list.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    /// Index into `order`.
    run: usize,
    at: usize,
}

impl Default for Runs {
    fn default() -> Self {
        Self { order: vec![0], runs: vec![Run::EMPTY], run_of: Vec::new(), recent: Place { run: 0, at: 0 } }
    }
}

impl Run {
    const EMPTY: Self = Self { count: 0, entries: [(0.0, 0); MOST] };

    #[inline(always)]
    fn entries(&self) -> &[(f32, u32)] {
        &self.entries[..self.count]
    }

    fn insert(&mut self, at: usize, entry: (f32, u32)) {
        self.entries.copy_within(at..self.count, at + 1);
        self.entries[at] = entry;
        self.count += 1;
    }

    fn remove(&mut self, at: usize) {
        self.entries.copy_within(at + 1..self.count, at);
        self.count -= 1;
    }

    /// Takes the second half of a full run.
    fn split(&mut self) -> Self {
        let mut rest = *self;
        rest.entries.rotate_left(MOST / 2);
        (self.count, rest.count) = (MOST / 2, MOST / 2);
        rest
    }
}

impl Runs {
    pub(crate) fn clear(&mut self) {
        self.order.truncate(1);
        self.order[0] = 0;
        self.runs.truncate(1);
        self.runs[0].count = 0;
        self.run_of.clear();
        self.recent = Place { run: 0, at: 0 };
    }

    fn run(&self, place: usize) -> &Run {
        &self.runs[self.order[place] as usize]
    }

    /// The place after the numbers that are `below`, which are the first of the list, and about where numbers have
    /// this key.
    #[inline(always)]
    pub(crate) fn after(&self, key: f32, below: impl Fn(u32) -> bool) -> Place {
        let Place { run, at } = self.by_keys(key);
        let entries = self.run(run).entries();
        let is_after = if at > 0 { below(entries[at - 1].1) } else { run == 0 };
        let first_of = |run: usize| self.order.get(run).map(|_| self.run(run).entries[0].1);
        let next = if at < entries.len() { Some(entries[at].1) } else { first_of(run + 1) };
        if is_after && next.is_none_or(|number| !below(number)) {
            return Place { run, at };
        }
        let run = self.order[1..].partition_point(|&run| below(self.runs[run as usize].entries[0].1));
        Place { run, at: self.run(run).entries().partition_point(|&(_, number)| below(number)) }
    }

    /// The place by keys alone.
    #[inline(always)]
    fn by_keys(&self, key: f32) -> Place {
        let Place { run, at } = self.recent;
        if let Some(&index) = self.order.get(run) {
            let entries = self.runs[index as usize].entries();
            let at = at + usize::from(entries.get(at).is_some_and(|&(other, _)| other < key));
            let low = if at > 0 { entries.get(at - 1).map(|e| e.0) } else { (run == 0).then_some(f32::NEG_INFINITY) };
            let next =
                entries.get(at).or_else(|| self.order.get(run + 1).map(|&run| &self.runs[run as usize].entries[0]));
            if low.is_some_and(|low| low < key) && next.is_none_or(|&(high, _)| key <= high) {
                return Place { run, at };
            }
        }
        let run = self.order[1..].partition_point(|&run| self.runs[run as usize].entries[0].0 < key);
        Place { run, at: self.run(run).entries().partition_point(|&(other, _)| other < key) }
    }

    /// The number before a place; `None` if it is the first place.
    pub(crate) fn before(&self, Place { run, at }: Place) -> Option<u32> {
        Some(self.run(run).entries[at.checked_sub(1)?].1)
    }

    /// Inserts a number that the list does not have, at a place of this list.
    pub(crate) fn insert(&mut self, Place { mut run, mut at }: Place, number: u32, key: f32) {
        let mut index = self.order[run];
        if self.runs[index as usize].count == MOST {
            let rest = self.runs[index as usize].split();
            let new = self.runs.len() as u32;
            rest.entries().iter().for_each(|&(_, number)| self.run_of[number as usize] = new);
            self.runs.push(rest);
            self.order.insert(run + 1, new);
            if at > MOST / 2 {
                (run, at, index) = (run + 1, at - MOST / 2, new);
            }
        }
        self.runs[index as usize].insert(at, (key, number));
        if self.run_of.len() <= number as usize {
            self.run_of.resize(number as usize + 1, NONE);
        }
        self.run_of[number as usize] = index;
        self.recent = Place { run, at };
    }

    /// Removes a number, if the list has it.
    pub(crate) fn remove(&mut self, number: u32) {
        let Some(run) = self.run_of.get_mut(number as usize) else { return };
        let index = std::mem::replace(run, NONE);
        if index == NONE {
            return;
        }
        let run = &mut self.runs[index as usize];
        if let Some(at) = run.entries().iter().position(|&(_, other)| other == number) {
            run.remove(at);
        }
        if run.count == 0 && self.order.len() > 1 {
            self.order.retain(|&other| other != index);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_of_many_runs_is_the_list_of_one() {
        let (mut runs, mut list) = (Runs::default(), Vec::new());
        // In order of their multiples of a prime: neighbours come far apart, some one after the other.
        let key = |number: u32| number / 4 * 1873 % 5003 * 4 + number % 4;
        for number in 0..5000 {
            let at = list.partition_point(|&other| key(other) < key(number));
            // Every eighth number has a key that is wrong.
            let guess = |number: u32| (if number.is_multiple_of(8) { number } else { key(number) }) as f32;
            let place = runs.after(guess(number), |other| key(other) < key(number));
            assert_eq!(runs.before(place), at.checked_sub(1).map(|at| list[at]));
            list.insert(at, number);
            runs.insert(place, number, guess(number));
        }
        let numbers = |runs: &Runs| {
            (0..runs.order.len()).flat_map(|k| runs.run(k).entries().iter().map(|e| e.1)).collect::<Vec<_>>()
        };
        assert_eq!((runs.order.len() > 5000 / MOST, numbers(&runs)), (true, list.clone()));
        for number in (0..5000).map(|k| k * 2741 % 5000) {
            runs.remove(number);
            // What the list does not have any more, and what it never had.
            runs.remove(number);
            runs.remove(5000);
            list.retain(|&other| other != number);
            let place = runs.after(key(number) as f32, |other| key(other) < key(number));
            assert_eq!(runs.before(place), list.iter().copied().rfind(|&other| key(other) < key(number)));
        }
        assert_eq!((numbers(&runs), runs.order.len()), (vec![], 1));
    }
}
