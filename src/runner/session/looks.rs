//! Sequential gates while runs come in: one that fails ends its suite.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::sync::Arc;

use super::gates::{frame, gate_key, other_runs};
use super::shared::Runner;
use super::unit::{UnitKind, Units, with_needs};
use crate::baseline::record_outcome;
use crate::plan::PlannedTrial;
use crate::run::{Panicked, Remembered, Wanted};
use results::judge::baseline::Baseline;
use results::judge::gate::{LookRounds, look_at};
use results::{Cut, Event, GateReport, GateState, GateVerdict, NotJudged, Outcome, Reporter, UnitReport};
use scenario::{Case, Gate};

/// Runs between which it is told how many there are, for each that is made at the same time.
const AT_ONCE: usize = 16;

/// What came of looking.
#[derive(Default)]
pub struct Looked {
    /// The gates of suites of which one has failed.
    pub gates: BTreeMap<usize, Vec<GateReport>>,
    /// Units that are not run for that, in their order; with what there is of those of which runs were made.
    pub called_off: Vec<(usize, Option<UnitReport>)>,
    /// How many runs of a unit were told to be done.
    pub told: HashMap<usize, usize>,
}

/// A gate with what it is compared with.
struct Looking<'a> {
    gate: &'a Gate,
    base: Baseline,
}

impl<'a> Runner<'a> {
    /// Makes the runs of suites whose gates are sequential, a round after the other, until one has failed or all are made, and keeps what came of
    /// them. Which runs there are at a look does not depend on how they are made.
    pub(super) fn look(
        &self,
        units: &Units<'a>,
        chosen: &[bool],
        max_failures: Option<usize>,
        (memory, lenient): (&Remembered, bool),
        reporter: &mut dyn Reporter,
    ) -> Looked {
        let mut looked = Looked::default();
        let mut called_off: Vec<usize> = Vec::new();
        let is_enough = |looked: &Looked| max_failures.is_some_and(|most| looked.gates.len() >= most);
        for suite in 0..self.suites().len() {
            // Who gives a trial so much time measures it while the trial is run.
            if self.suites()[suite].plan.time_limit.is_some() || is_enough(&looked) {
                continue;
            }
            let gates = self.sequential_gates(suite);
            if gates.is_empty() {
                continue;
            }
            let own: Vec<usize> = (0..units.len())
                .filter(|unit| units.suite(*unit) == suite)
                .filter(|unit| matches!(units.kind(*unit), UnitKind::Trial { .. }))
                .collect();
            // Of a part of a suite no gate says anything.
            if own.is_empty() || !own.iter().all(|unit| chosen[*unit]) {
                continue;
            }
            let failed = self.look_at_suite(suite, &own, &gates, (memory, lenient), (&mut looked, reporter));
            if !failed.is_empty() {
                looked.gates.insert(suite, self.ended(suite, failed));
                // What has all its runs is judged.
                let is_open = |unit: &usize| looked.told.get(unit).copied().unwrap_or(0) < units.runs(*unit);
                let open: Vec<usize> = own.into_iter().filter(is_open).collect();
                // What needs another trial cannot be run.
                let needs_one = |unit: &usize| {
                    let mut only = vec![false; units.len()];
                    only[*unit] = true;
                    let needed = with_needs(units, only);
                    chosen[*unit] && open.iter().any(|trial| needed[*trial])
                };
                called_off.extend(units.others().filter(needs_one));
                called_off.extend(open);
            }
        }
        if is_enough(&looked) {
            let left = |unit: &usize| chosen[*unit] && !looked.gates.contains_key(&units.suite(*unit));
            let others: Vec<usize> = (0..units.len()).filter(left).collect();
            called_off.extend(others);
        }
        called_off.sort_unstable();
        called_off.dedup();
        let report = |unit: usize| {
            let finished = looked.told.get(&unit).copied().filter(|finished| *finished > 0)?;
            let trial = units.get(unit).trial()?;
            let known = (0..finished).filter_map(|run| memory.recall(&trial.cases.get(run)));
            let asked = |mut outcome: Outcome| {
                outcome.forget_unasked(&trial.criteria, self.requests());
                outcome
            };
            let outcomes = known.map(asked).collect();
            Some(Self::cut_off(&trial, outcomes, Cut::Gate { finished, runs: trial.cases.len() }))
        };
        looked.called_off = called_off.into_iter().map(|unit| (unit, report(unit))).collect();
        looked
    }

    /// Those that have something to be compared with.
    fn sequential_gates(&self, suite: usize) -> Vec<Looking<'a>> {
        let set = &self.identity(suite).set;
        let gates = self.suites()[suite].suite.gates.iter().filter(|gate| gate.sequential);
        let comparable = gates.filter(|gate| other_runs(gate, set, self.files()).is_none());
        comparable
            .filter_map(|gate| {
                let base = Baseline::read_named(Path::new(&gate.baseline), self.files()).ok()?;
                Some(Looking { gate, base })
            })
            .collect()
    }

    /// The gates that failed at the first look at which any did.
    fn look_at_suite(
        &self,
        suite: usize,
        own: &[usize],
        gates: &[Looking<'a>],
        (memory, lenient): (&Remembered, bool),
        (looked, reporter): (&mut Looked, &mut dyn Reporter),
    ) -> Vec<(&'a Gate, GateVerdict)> {
        let prepared = &self.suites()[suite];
        // In the order of baselines.
        let mut planned: Vec<(usize, PlannedTrial)> =
            own.iter().copied().zip(prepared.plan.trials()).collect();
        planned.sort_by(|(_, left), (_, right)| left.key.cmp(&right.key));
        let mut seen = frame(self, suite, planned.iter().map(|(_, trial)| trial));
        let rounds = LookRounds::of(&seen);
        let mut before = 0;
        for after in rounds.looks() {
            let mut wanted: Vec<(usize, usize)> = Vec::new();
            for trial in 0..planned.len() {
                wanted
                    .extend((rounds.runs(trial, before)..rounds.runs(trial, after)).map(|run| (trial, run)));
            }
            before = after;
            for some in wanted.chunks(AT_ONCE * self.executor().parallelism()) {
                let cases: Vec<Case> =
                    some.iter().map(|(trial, run)| planned[*trial].1.cases.get(*run)).collect();
                let (wanted, mut outcomes) = (self.wanted(Wanted::Outcome), Vec::with_capacity(some.len()));
                let made = Panicked::catch(|| {
                    self.batch().each(
                        cases.len(),
                        wanted,
                        |index| cases[index].clone(),
                        |case, ran| {
                            self.watched(&case, &ran);
                            outcomes.push(ran.outcome);
                        },
                    )
                });
                for (((trial, run), case), outcome) in some.iter().zip(cases).zip(outcomes) {
                    record_outcome(&mut seen, (*trial, *run), &outcome, self.requests());
                    memory.keep(case, outcome);
                    let unit = planned[*trial].0;
                    *looked.told.entry(unit).or_default() += 1;
                    reporter.tell(&Event::RunDone { unit });
                }
                reporter.tell(&Event::Tick);
                reporter.flush();
                // Somebody wishes to stop; or a run's own trial says what is wrong with it.
                if !matches!(made, Ok(Ok(()))) {
                    return Vec::new();
                }
            }
            let failing = |looking: &Looking<'a>| {
                let verdict = look_at(looking.gate, &looking.base, &seen, lenient, after).ok()??;
                Some((looking.gate, verdict.written_as(&prepared.suite)))
            };
            let failed: Vec<_> = gates.iter().filter_map(failing).collect();
            if !failed.is_empty() {
                return failed;
            }
        }
        Vec::new()
    }

    /// All gates of a suite of which some failed before all runs were made.
    fn ended(&self, suite: usize, mut failed: Vec<(&'a Gate, GateVerdict)>) -> Vec<GateReport> {
        let first = failed[0].0.name.clone();
        let identity = self.identity(suite);
        let report = |gate: &Gate| {
            let own = failed.iter().position(|(one, _)| one.name == gate.name);
            let state = match own.map(|place| failed.swap_remove(place)) {
                Some((_, verdict)) => GateState::Judged(Box::new(verdict)),
                None => GateState::NotJudged(NotJudged::Ended(first.clone())),
            };
            GateReport { gate: Arc::new(gate.clone()), key: gate_key(&identity.suite, gate), state }
        };
        self.suites()[suite].suite.gates.iter().map(report).collect()
    }
}
