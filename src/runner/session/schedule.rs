//! Which unit is next: each after what it needs, and none whose needs came to nothing.

use std::collections::{BTreeSet, HashMap};

/// Who begins before others that could begin as well.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Turn {
    First,
    Later,
}

/// The units that are still to run.
#[derive(Debug)]
pub struct UnitSchedule {
    /// Units that could begin now: those that come first, then the others, each in their order.
    ready: BTreeSet<(Turn, usize)>,
    /// Whether each unit comes before those that do not; empty if none does.
    first: Vec<bool>,
    /// How many needs of each unit are unfinished; `None` for one that has left the schedule.
    outstanding: Vec<Option<u32>>,
    /// Who waits for a unit.
    waiting: HashMap<usize, Vec<usize>>,
    /// Units that are being run.
    running: usize,
}

impl UnitSchedule {
    /// Of the units that are `chosen`, with all that they need; `needs` gives for a unit those that it needs.
    pub fn new<'n>(needs: impl Fn(usize) -> &'n [usize], chosen: &[bool]) -> Self {
        let mut schedule = Self {
            ready: BTreeSet::new(),
            first: Vec::new(),
            outstanding: vec![None; chosen.len()],
            waiting: HashMap::new(),
            running: 0,
        };
        for (index, _) in chosen.iter().enumerate().filter(|(_, chosen)| **chosen) {
            let needs = needs(index);
            schedule.outstanding[index] = Some(needs.len() as u32);
            needs.iter().for_each(|need| schedule.waiting.entry(*need).or_default().push(index));
            if needs.is_empty() {
                schedule.ready.insert((Turn::Later, index));
            }
        }
        schedule
    }

    /// Those of `first` begin before the others, and so does what they need.
    pub fn first<'n>(mut self, needs: impl Fn(usize) -> &'n [usize], first: &[bool]) -> Self {
        self.first = first.to_vec();
        // Needs come before those who need them.
        for index in (0..self.first.len()).rev() {
            if self.first[index] {
                needs(index).iter().for_each(|need| self.first[*need] = true);
            }
        }
        let ready = std::mem::take(&mut self.ready);
        self.ready = ready.into_iter().map(|(_, unit)| (self.turn(unit), unit)).collect();
        self
    }

    fn turn(&self, unit: usize) -> Turn {
        if self.first.get(unit).is_some_and(|first| *first) { Turn::First } else { Turn::Later }
    }

    /// The unit that is to begin next, if one can.
    pub fn next(&self) -> Option<usize> {
        self.ready.first().map(|(_, unit)| *unit)
    }

    /// Takes the unit that is to begin next, if one can.
    pub fn begin(&mut self) -> Option<usize> {
        let (_, unit) = self.ready.pop_first()?;
        self.outstanding[unit] = None;
        self.running += 1;
        Some(unit)
    }

    /// Whether nothing is running and nothing can begin.
    pub fn is_over(&self) -> bool {
        self.running == 0 && self.ready.is_empty()
    }

    /// A unit that had begun is done. If others can use it they may begin; if not, they are called off, with all who
    /// need them: returns those with the unit that each of them misses.
    pub fn end(&mut self, unit: usize, usable: bool) -> Vec<(usize, usize)> {
        self.running -= 1;
        let mut off = Vec::new();
        let mut missing = vec![];
        for waiting in self.waiting.remove(&unit).unwrap_or_default() {
            let Some(outstanding) = &mut self.outstanding[waiting] else { continue };
            if !usable {
                missing.push((waiting, unit));
                continue;
            }
            *outstanding -= 1;
            if *outstanding == 0 {
                let turn = self.turn(waiting);
                self.ready.insert((turn, waiting));
            }
        }
        while let Some((waiting, need)) = missing.pop() {
            if self.outstanding[waiting].take().is_some() {
                off.push((waiting, need));
                missing.extend(self.waiting.get(&waiting).into_iter().flatten().map(|next| (*next, waiting)));
            }
        }
        off.sort_unstable();
        off
    }

    /// Nothing that has not begun ever will: returns it all.
    pub fn call_off(&mut self) -> Vec<usize> {
        self.ready.clear();
        let left = |(index, one): (usize, &mut Option<u32>)| one.take().map(|_| index);
        self.outstanding.iter_mut().enumerate().filter_map(left).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 3 needs 0 and 1, 4 needs 3; 2 stands alone.
    const NEEDS: [&[usize]; 5] = [&[], &[], &[], &[0, 1], &[3]];
    const NOTHING: [usize; 0] = [];

    fn begun(schedule: &mut UnitSchedule) -> Vec<usize> {
        std::iter::from_fn(|| schedule.begin()).collect()
    }

    #[test]
    fn everything_begins_after_what_it_needs() {
        let mut schedule = UnitSchedule::new(|unit| NEEDS[unit], &[true; 5]);
        assert_eq!(begun(&mut schedule), [0, 1, 2]);
        assert!(!schedule.is_over());
        assert_eq!(schedule.end(1, true), []);
        assert_eq!(begun(&mut schedule), NOTHING);
        assert_eq!(schedule.end(0, true), []);
        assert_eq!(begun(&mut schedule), [3]);
        schedule.end(2, false);
        schedule.end(3, true);
        assert_eq!(begun(&mut schedule), [4]);
        schedule.end(4, true);
        assert!(schedule.is_over());
    }

    #[test]
    fn what_comes_first_begins_before_what_could_begin_as_well() {
        let order = |first: [bool; 5]| {
            let needs = |unit: usize| NEEDS[unit];
            let mut schedule = UnitSchedule::new(needs, &[true; 5]).first(needs, &first);
            let mut order = Vec::new();
            while let Some(next) = schedule.next() {
                assert_eq!(schedule.begin(), Some(next));
                order.push(next);
                schedule.end(next, true);
            }
            assert!(schedule.is_over());
            order
        };
        assert_eq!(order([false; 5]), [0, 1, 2, 3, 4]);
        assert_eq!(order([false, true, true, false, false]), [1, 2, 0, 3, 4]);
        assert_eq!(order([false, false, true, false, true]), [0, 1, 2, 3, 4], "with what it needs");
        assert_eq!(order([false, false, false, true, false]), [0, 1, 3, 2, 4]);
    }

    #[test]
    fn what_comes_to_nothing_takes_along_all_that_need_it() {
        let mut schedule = UnitSchedule::new(|unit| NEEDS[unit], &[true; 5]);
        begun(&mut schedule);
        assert_eq!(schedule.end(0, false), [(3, 0), (4, 3)]);
        assert_eq!(schedule.end(1, true), []);
        schedule.end(2, true);
        assert_eq!(begun(&mut schedule), NOTHING);
        assert!(schedule.is_over() && schedule.call_off().is_empty());
    }

    #[test]
    fn what_has_not_begun_can_be_called_off() {
        let mut schedule = UnitSchedule::new(|unit| NEEDS[unit], &[true, true, true, true, false]);
        assert_eq!(schedule.begin(), Some(0));
        assert_eq!(schedule.call_off(), [1, 2, 3]);
        assert_eq!(begun(&mut schedule), NOTHING);
        assert_eq!(schedule.end(0, true), []);
        assert_eq!(begun(&mut schedule), NOTHING, "nothing that was called off ever begins");
    }
}
