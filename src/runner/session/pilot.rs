//! Pilot runs: a few runs of trials before these begin, so that it can be told how long everything takes. They are those of the trials, kept until
//! these ask for them: no run is made twice, and nothing but the order in which runs are made depends on them.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use super::shared::Runner;
use super::unit::{UnitKind, Units};
use crate::plan::PlannedTrial;
use crate::run::{Panicked, Remembered};
use results::{Event, Reporter};
use scenario::Case;

/// Of more trials, so many that are spread over all.
const MOST_TRIALS: usize = 64;
/// Runs of each, as far as there is time.
const MOST_RUNS: usize = 64;
/// After that no more are made.
const BUDGET: Duration = Duration::from_millis(1500);

impl<'a> Runner<'a> {
    /// Makes pilot runs of the chosen trials, and returns how many of each unit.
    pub(super) fn pilot(
        &self,
        units: &Units<'a>,
        chosen: &[bool],
        memory: &Remembered,
        reporter: &mut dyn Reporter,
    ) -> HashMap<usize, usize> {
        let mut made = HashMap::new();
        let all: Vec<usize> =
            (0..units.len()).filter(|unit| chosen[*unit] && self.takes_pilots(units, *unit)).collect();
        if all.len() < 2 {
            return made;
        }
        let trials: Vec<(usize, PlannedTrial)> = spread(all.len(), MOST_TRIALS)
            .map(|place| (all[place], units.get(all[place]).trial().expect("those of trials are chosen")))
            .collect();
        let begun = Instant::now();
        for round in 0..MOST_RUNS {
            let wanted: Vec<(usize, Case)> = trials
                .iter()
                .filter_map(|(unit, trial)| {
                    let run = spread(trial.certain_runs(), MOST_RUNS).nth(round)?;
                    Some((*unit, trial.cases.get(run)))
                })
                .collect();
            for some in wanted.chunks(self.executor().parallelism()) {
                if begun.elapsed() > BUDGET || self.stop().is_requested() {
                    return made;
                }
                let cases = some.iter().map(|(_, case)| case.clone());
                let outcomes = Panicked::catch(|| self.batch().outcomes(cases, || ()));
                // Its own trial says what is wrong with it.
                let Ok(Ok(outcomes)) = outcomes else { continue };
                for ((unit, case), outcome) in some.iter().zip(outcomes) {
                    let took = outcome.wall_time;
                    memory.keep(case.clone(), outcome);
                    *made.entry(*unit).or_default() += 1;
                    reporter.tell(&Event::PilotRun { unit: *unit, runs: units.runs(*unit), took });
                    reporter.tell(&Event::RunDone { unit: *unit });
                }
                reporter.tell(&Event::Tick);
                reporter.flush();
            }
        }
        made
    }

    /// Whether pilot runs are made of a unit: of a trial in whose suite no program decides, which may remember what it did, no gate looks at runs
    /// as they come, and no time is measured.
    fn takes_pilots(&self, units: &Units, unit: usize) -> bool {
        let prepared = &self.suites()[units.suite(unit)];
        matches!(units.kind(unit), UnitKind::Trial { .. })
            && prepared.suite.controllers.is_empty()
            && prepared.plan.time_limit.is_none()
            && !prepared.suite.gates.iter().any(|gate| gate.sequential)
    }
}

/// At most so many `wanted` of `all` places, each once, of which the first ones are spread over all, too: halves, quarters and so on.
fn spread(all: usize, wanted: usize) -> impl Iterator<Item = usize> {
    let wanted = wanted.min(all);
    let bits = wanted.next_power_of_two().trailing_zeros();
    let reversed = move |index: usize| match bits {
        0 => 0,
        bits => index.reverse_bits() >> (usize::BITS - bits),
    };
    (0..1_usize << bits)
        .map(reversed)
        .filter(move |place| *place < wanted)
        .map(move |place| place * all / wanted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_spread_and_each_comes_once() {
        let places = |all, wanted| spread(all, wanted).collect::<Vec<_>>();
        assert_eq!(places(4, 8), [0, 2, 1, 3]);
        assert_eq!(places(6, 64), [0, 4, 2, 1, 5, 3]);
        assert_eq!(places(1, 8), [0]);
        assert_eq!(places(0, 8), [0_usize; 0]);
        assert_eq!(places(1000, 4), [0, 500, 250, 750]);
        for (all, wanted) in [(7, 8), (64, 64), (65, 64), (1_000_000, 64), (3, 2)] {
            let mut places = places(all, wanted);
            assert_eq!(places.len(), wanted.min(all));
            places.sort_unstable();
            places.dedup();
            assert_eq!(places.len(), wanted.min(all));
            assert!(places.iter().all(|place| *place < all));
        }
    }
}
