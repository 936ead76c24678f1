//! A list of numbers in an order that only a search knows: it inserts and removes without moving many.

/// Most numbers of a run.
const MOST: usize = 64;

/// A list of numbers, each once, as runs in the order of the list. There is always a first run, and no other is empty.
pub(crate) struct Runs {
    /// The runs, by their place in the list: indices into `runs`.
    order: Vec<u32>,
    runs: Vec<Vec<u32>>,
    /// By number, its run.
    run_of: Vec<u32>,
    /// Where the last number came or went: the next is often near.
    recent: Place,
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
        Self { order: vec![0], runs: vec![Vec::new()], run_of: Vec::new(), recent: Place { run: 0, at: 0 } }
    }
}

impl Runs {
    pub(crate) fn clear(&mut self) {
        self.order.truncate(1);
        self.order[0] = 0;
        self.runs.truncate(1);
        self.runs[0].clear();
        self.run_of.clear();
        self.recent = Place { run: 0, at: 0 };
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.run(0).is_empty()
    }

    fn run(&self, place: usize) -> &[u32] {
        &self.runs[self.order[place] as usize]
    }

    /// The place after the numbers that are `below`, which are the first of the list.
    #[inline(always)]
    pub(crate) fn after(&self, below: impl Fn(u32) -> bool) -> Place {
        let Place { mut run, at } = self.recent;
        let count = self.order.len();
        if run > 0 && !below(self.run(run)[0]) || run + 1 < count && below(self.run(run + 1)[0]) {
            run = self.order.partition_point(|&run| below(self.runs[run as usize][0])).saturating_sub(1);
        }
        let numbers = self.run(run);
        let at = at.min(numbers.len());
        let low = if at > 0 && below(numbers[at - 1]) { at } else { 0 };
        let high = if at < numbers.len() && !below(numbers[at]) { at } else { numbers.len() };
        Place { run, at: low + numbers[low..high.max(low)].partition_point(|&number| below(number)) }
    }

    /// The number before a place; `None` if it is the first place.
    pub(crate) fn before(&self, Place { run, at }: Place) -> Option<u32> {
        Some(self.run(run)[at.checked_sub(1)?])
    }

    /// Inserts the number after the largest so far, at a place of this list.
    pub(crate) fn insert(&mut self, Place { mut run, mut at }: Place, number: u32) {
        let mut index = self.order[run];
        if self.runs[index as usize].len() == MOST {
            let rest = self.runs[index as usize].split_off(MOST / 2);
            let new = self.runs.len() as u32;
            rest.iter().for_each(|&number| self.run_of[number as usize] = new);
            self.runs.push(rest);
            self.order.insert(run + 1, new);
            if at > MOST / 2 {
                (run, at, index) = (run + 1, at - MOST / 2, new);
            }
        }
        self.runs[index as usize].insert(at, number);
        self.run_of.push(index);
        self.recent = Place { run, at: at + 1 };
    }

    /// Removes a number. Returns whether the list had it.
    pub(crate) fn remove(&mut self, number: u32) -> bool {
        let index = self.run_of[number as usize];
        let run = &mut self.runs[index as usize];
        let Some(at) = run.iter().position(|&other| other == number) else { return false };
        run.remove(at);
        let is_empty = run.is_empty();
        let next = [self.recent.run, self.recent.run + 1].into_iter().find(|&run| self.order.get(run) == Some(&index));
        if let Some(run) = next {
            self.recent = Place { run, at };
        }
        if is_empty && self.order.len() > 1 {
            self.order.retain(|&other| other != index);
            self.recent.run = self.recent.run.min(self.order.len() - 1);
        }
        true
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
            let place = runs.after(|other| key(other) < key(number));
            assert_eq!(runs.before(place), at.checked_sub(1).map(|at| list[at]));
            list.insert(at, number);
            runs.insert(place, number);
        }
        let numbers = |runs: &Runs| (0..runs.order.len()).flat_map(|k| runs.run(k).to_vec()).collect::<Vec<_>>();
        assert_eq!((runs.order.len() > 5000 / MOST, numbers(&runs)), (true, list.clone()));
        for number in (0..5000).map(|k| k * 2741 % 5000) {
            assert!(!runs.is_empty());
            assert_eq!([runs.remove(number), runs.remove(number)], [true, false]);
            list.retain(|&other| other != number);
            let place = runs.after(|other| key(other) < key(number));
            assert_eq!(runs.before(place), list.iter().copied().rfind(|&other| key(other) < key(number)));
        }
        assert_eq!((runs.is_empty(), runs.order.len()), (true, 1));
    }
}
