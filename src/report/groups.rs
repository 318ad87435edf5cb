//! Failures of one cause together: one criterion that did not hold in trials of one scenario whose values are neighbours.

use std::collections::{BTreeSet, HashMap, VecDeque};

use results::{AppliedCriteria, Finding, ScenarioSummary, SuiteReport, TrialReport, Verdict};
use scenario::{Assignment, Value};

/// Trials in which a criterion did not hold.
#[derive(Debug, Clone)]
pub struct Group<'r> {
    pub scenario: &'r str,
    pub criterion: &'r str,
    pub verdict: Verdict,
    /// Keys of its trials, in the order of the suite.
    pub trials: Vec<&'r str>,
    /// How many trials of the scenario were judged by the criterion.
    pub of: usize,
    /// Which values its trials have: `speed from 40km/h on, tta 2s to 4s`; empty if there is nothing to tell.
    pub values: String,
    /// What was found where it is worst, and the key of that trial.
    pub worst: (&'r str, &'r Finding),
}

impl Group<'_> {
    /// `failed in 9 of 12 trials, speed from 40km/h on`, to be put behind the criterion.
    pub fn in_words(&self) -> String {
        let verb = match self.verdict {
            Verdict::Inconclusive => "could not be decided",
            _ => "failed",
        };
        let values = if self.values.is_empty() { String::new() } else { format!(", {}", self.values) };
        format!("{verb} in {} of {} trials{values}", self.trials.len(), self.of)
    }

    /// The run to see again, if there is one.
    pub fn run(&self) -> Option<&str> {
        Some(&self.worst.1.worst.first()?.key)
    }
}

/// Every criterion that did not hold, grouped: what failed before what could not be decided, then by the share of the
/// trials that it failed in. Every trial in which something did not hold is in a group.
pub fn groups(report: &SuiteReport) -> Vec<Group<'_>> {
    let counted = report.summary.iter().flat_map(|summary| &summary.scenarios);
    grouped(report.placed_trials(), &counted.collect::<Vec<_>>())
}

/// Of trials with their places, and of those besides that are only counted.
fn grouped<'r>(
    trials: impl Iterator<Item = (usize, &'r TrialReport)>,
    counted: &[&'r ScenarioSummary],
) -> Vec<Group<'r>> {
    let mut groups = Vec::new();
    let mut scenarios: Vec<(&str, Vec<(usize, &TrialReport)>)> = Vec::new();
    for (place, trial) in trials {
        let name = trial.trial.scenario.as_str();
        // From the end: trials of a scenario stand together.
        match scenarios.iter_mut().rev().find(|(known, _)| *known == name) {
            Some((_, trials)) => trials.push((place, trial)),
            None => scenarios.push((name, vec![(place, trial)])),
        }
    }
    for (scenario, trials) in scenarios {
        let mut criteria: Vec<&str> = Vec::new();
        for finding in trials.iter().flat_map(|(_, trial)| trial.findings()) {
            if finding.verdict != Verdict::Passed && !criteria.contains(&finding.criterion.as_str()) {
                criteria.push(&finding.criterion);
            }
        }
        let counted = counted.iter().find(|known| known.scenario == scenario);
        for criterion in criteria {
            of_criterion(&mut groups, scenario, criterion, &trials, counted.copied());
        }
    }
    let failing = |group: &Group| group.trials.len() as f64 / group.of as f64;
    groups.sort_by(|left, right| {
        right.verdict.cmp(&left.verdict).then(failing(right).total_cmp(&failing(left)))
    });
    groups
}

/// A trial that was judged by a criterion.
#[derive(Clone, Copy)]
struct JudgedTrial<'r> {
    place: usize,
    values: TrialValues<'r>,
    /// Its name and what was found; `None` where no more is known than that the criterion held.
    held: Option<(&'r str, &'r Finding)>,
}

fn of_criterion<'r>(
    groups: &mut Vec<Group<'r>>,
    scenario: &'r str,
    criterion: &'r str,
    trials: &[(usize, &'r TrialReport)],
    counted: Option<&'r ScenarioSummary>,
) {
    let held = trials.iter().filter_map(|(place, trial)| {
        // The scenario and a claim about it may both state it.
        let same = trial.findings().iter().filter(|finding| finding.criterion == criterion);
        let finding = same.max_by_key(|finding| finding.verdict)?;
        let values = TrialValues::Held(&trial.trial.variation);
        Some(JudgedTrial { place: *place, values, held: Some((trial.trial.key.as_str(), finding)) })
    });
    let mut judged: Vec<JudgedTrial> = held.collect();
    if let Some(counted) = counted {
        let applies = |applied: &AppliedCriteria| applied.criteria.iter().any(|one| one.text == criterion);
        let applied: Vec<bool> = counted.criteria.iter().map(applies).collect();
        let passed = counted.passed.iter().filter(|passed| applied[passed.criteria as usize]);
        judged.extend(passed.map(|passed| JudgedTrial {
            place: passed.place,
            values: TrialValues::Counted(&counted.varied, &passed.values),
            held: None,
        }));
        judged.sort_by_key(|one| one.place);
    }
    let plan = Grid::new(&judged);
    for verdict in [Verdict::Failed, Verdict::Inconclusive] {
        let is_so = |one: &JudgedTrial| one.held.is_some_and(|(_, finding)| finding.verdict == verdict);
        let bad: Vec<usize> = (0..judged.len()).filter(|index| is_so(&judged[*index])).collect();
        for members in plan.neighbours(&bad) {
            let found: Vec<_> = members.iter().filter_map(|index| judged[*index].held).collect();
            let worst = found.iter().copied().min_by(|left, right| worse(left.1, right.1));
            let Some(worst) = worst else { continue };
            groups.push(Group {
                scenario,
                criterion,
                verdict,
                trials: found.iter().map(|(key, _)| *key).collect(),
                of: judged.len(),
                values: plan.values(&members),
                worst,
            });
        }
    }
}

/// The finding farther on the wrong side first; where there is no margin, that with more runs against it.
fn worse(left: &Finding, right: &Finding) -> std::cmp::Ordering {
    let margin = |finding: &Finding| finding.margin.unwrap_or(f64::INFINITY);
    let holding = |finding: &Finding| finding.holding as f64 / finding.runs.max(1) as f64;
    margin(left).total_cmp(&margin(right)).then(holding(left).total_cmp(&holding(right)))
}

/// What varies in a trial.
#[derive(Clone, Copy)]
enum TrialValues<'r> {
    Held(&'r [Assignment]),
    /// Names, with label and value of each.
    Counted(&'r [String], &'r [(Box<str>, Value)]),
}

/// A value that varies.
#[derive(Clone, Copy)]
struct Varied<'r> {
    name: &'r str,
    label: &'r str,
    value: &'r Value,
}

impl<'r> TrialValues<'r> {
    fn get(self, column: usize) -> Option<Varied<'r>> {
        match self {
            Self::Held(variation) => {
                let Assignment { name, label, value } = variation.get(column)?;
                Some(Varied { name, label, value })
            }
            Self::Counted(names, values) => {
                let (label, value) = values.get(column)?;
                Some(Varied { name: names.get(column)?, label, value })
            }
        }
    }

    fn len(self) -> usize {
        match self {
            Self::Held(variation) => variation.len(),
            Self::Counted(_, values) => values.len(),
        }
    }
}

/// Trials by the ranks of their values among those that there are.
struct Grid<'r> {
    axes: Vec<Axis<'r>>,
    /// Of every trial, a rank per axis: there may be millions.
    places: Vec<u32>,
    trials: usize,
    /// Whether there is exactly one trial for every combination: only then are trials next to each other.
    is_full: bool,
}

struct Axis<'r> {
    name: &'r str,
    /// Of every rank.
    labels: Vec<&'r str>,
    /// Whether one rank after another means something: not for words.
    ordered: bool,
}

impl<'r> Grid<'r> {
    fn new(trials: &[JudgedTrial<'r>]) -> Self {
        let columns = trials.first().map_or(0, |first| first.values.len());
        let ranked = (0..columns).filter_map(|column| Axis::new(trials, column));
        let (axes, ranks): (Vec<Axis>, Vec<Vec<u32>>) = ranked.unzip();
        let places: Vec<u32> =
            (0..trials.len()).flat_map(|trial| ranks.iter().map(move |ranks| ranks[trial])).collect();
        drop(ranks);
        let mut grid = Self { axes, places, trials: trials.len(), is_full: false };
        let combinations = grid.axes.iter().try_fold(1_usize, |all, axis| all.checked_mul(axis.labels.len()));
        grid.is_full = combinations == Some(grid.trials) && {
            let mut all: Vec<u32> = (0..grid.trials as u32).collect();
            all.sort_unstable_by_key(|trial| grid.place(*trial as usize));
            all.windows(2).all(|pair| grid.place(pair[0] as usize) != grid.place(pair[1] as usize))
        };
        grid
    }

    /// The ranks of a trial, one per axis.
    fn place(&self, trial: usize) -> &[u32] {
        let width = self.axes.len();
        &self.places[trial * width..(trial + 1) * width]
    }

    /// The trials in groups of those that are reached from each other by steps to a neighbouring value of one variation.
    fn neighbours(&self, trials: &[usize]) -> Vec<Vec<usize>> {
        if !self.is_full {
            return if trials.is_empty() { Vec::new() } else { vec![trials.to_vec()] };
        }
        let mut left: HashMap<&[u32], usize> =
            trials.iter().map(|index| (self.place(*index), *index)).collect();
        let mut groups = Vec::new();
        for start in trials {
            let Some(start) = left.remove(self.place(*start)) else { continue };
            let (mut group, mut waiting) = (Vec::new(), VecDeque::from([start]));
            while let Some(index) = waiting.pop_front() {
                group.push(index);
                for place in self.around(self.place(index)) {
                    waiting.extend(left.remove(place.as_slice()));
                }
            }
            group.sort_unstable();
            groups.push(group);
        }
        groups
    }

    fn around(&self, place: &[u32]) -> Vec<Vec<u32>> {
        let mut around = Vec::new();
        for (column, axis) in self.axes.iter().enumerate() {
            let rank = place[column];
            let ranks: Vec<u32> = if axis.ordered {
                rank.checked_sub(1).into_iter().chain([rank + 1]).collect()
            } else {
                (0..axis.labels.len() as u32).filter(|other| *other != rank).collect()
            };
            for rank in ranks {
                let mut other = place.to_vec();
                other[column] = rank;
                around.push(other);
            }
        }
        around
    }

    /// Where the trials lie on every axis on which they do not take everything.
    fn values(&self, trials: &[usize]) -> String {
        let mut said = Vec::new();
        for (column, Axis { name, labels, ordered }) in self.axes.iter().enumerate() {
            let ranks: BTreeSet<usize> =
                trials.iter().map(|index| self.place(*index)[column] as usize).collect();
            let (Some(low), Some(high), last) = (ranks.first(), ranks.last(), labels.len() - 1) else {
                continue;
            };
            if ranks.len() == labels.len() {
                continue;
            }
            let (from, to) = (labels[*low], labels[*high]);
            said.push(match (*low, *high) {
                (low, high) if low == high => format!("{name} {from}"),
                _ if !ordered => {
                    let words: Vec<_> = ranks.iter().map(|rank| labels[*rank]).collect();
                    format!("{name} {}", words.join(", "))
                }
                (low, high) if ranks.len() < high - low + 1 => {
                    format!("{} of {} values of {name} from {from} to {to}", ranks.len(), labels.len())
                }
                (_, high) if high == last => format!("{name} from {from} on"),
                (0, _) => format!("{name} up to {to}"),
                _ => format!("{name} {from} to {to}"),
            });
        }
        said.join(", ")
    }
}

impl<'r> Axis<'r> {
    /// What varies in this column, with the rank of every trial; `None` if it does not vary in all of them.
    fn new(trials: &[JudgedTrial<'r>], column: usize) -> Option<(Self, Vec<u32>)> {
        let name = trials.first()?.values.get(column)?.name;
        let value = |trial: usize| trials[trial].values.get(column);
        if !(0..trials.len()).all(|trial| value(trial).is_some_and(|one| one.name == name)) {
            return None;
        }
        let of = |trial: usize| value(trial).expect("all of them have it").value;
        let number = |trial: usize| of(trial).as_number();
        let ordered = (0..trials.len()).all(|trial| number(trial).is_some());
        let mut sorted: Vec<u32> = (0..trials.len() as u32).collect();
        if ordered {
            let number = |trial: u32| number(trial as usize).unwrap_or(0.0);
            sorted.sort_by(|left, right| number(*left).total_cmp(&number(*right)));
        }
        let mut labels: Vec<&str> = Vec::new();
        let mut ranks = vec![0; trials.len()];
        let mut known: HashMap<String, u32> = HashMap::new();
        let mut last: Option<u64> = None;
        for trial in sorted {
            let trial = trial as usize;
            let is_new = match of(trial) {
                // The same numbers follow each other, and there may be millions.
                Value::Number(number) if ordered => last.replace(number.to_bits()) != Some(number.to_bits()),
                other => {
                    let next = labels.len() as u32;
                    let rank = *known.entry(identity(other)).or_insert(next);
                    ranks[trial] = rank;
                    if rank != next {
                        continue;
                    }
                    true
                }
            };
            if is_new {
                let label = value(trial).map_or("", |one| one.label);
                labels.push(label.split('#').next().unwrap_or_default());
            }
            ranks[trial] = labels.len() as u32 - 1;
        }
        Some((Self { name, labels, ordered }, ranks))
    }
}

/// What tells values apart: numbers by their bits.
fn identity(value: &Value) -> String {
    match value {
        Value::Number(number) => format!("{:x}", number.to_bits()),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::fixture::Session;

    fn assignment(name: &str, value: Value) -> Assignment {
        Assignment { name: name.into(), label: format!("{value}"), value }
    }

    /// Trials over numbers and words, all combinations.
    fn plan(speeds: &[f64], profiles: &[&str]) -> Vec<Vec<Assignment>> {
        let both = speeds.iter().flat_map(|speed| profiles.iter().map(move |profile| (*speed, *profile)));
        both.map(|(speed, profile)| {
            let profile = assignment("profile", Value::Word(profile.into()));
            vec![assignment("speed", Value::Number(speed)), profile]
        })
        .collect()
    }

    fn judged(plan: &[Vec<Assignment>]) -> Vec<JudgedTrial<'_>> {
        let trials = plan.iter().enumerate();
        let judged =
            trials.map(|(place, one)| JudgedTrial { place, values: TrialValues::Held(one), held: None });
        judged.collect()
    }

    fn told(plan: &[Vec<Assignment>], bad: &[usize]) -> Vec<String> {
        let grid = Grid::new(&judged(plan));
        grid.neighbours(bad).iter().map(|group| format!("{}: {}", group.len(), grid.values(group))).collect()
    }

    #[test]
    fn neighbouring_values_are_one_cause() {
        let speeds = plan(&[50.0, 10.0, 20.0, 30.0, 40.0], &["normal"]);
        assert_eq!(told(&speeds, &[0, 3, 4]), ["3: speed from 30 on"]);
        assert_eq!(told(&speeds, &[1, 2]), ["2: speed up to 20"]);
        assert_eq!(told(&speeds, &[2, 3]), ["2: speed 20 to 30"]);
        assert_eq!(told(&speeds, &[1, 0]), ["1: speed 10", "1: speed 50"]);
        assert_eq!(told(&speeds, &[0, 1, 2, 3, 4]), ["5: "]);
        let both = plan(&[10.0, 20.0, 30.0], &["calm", "normal", "rash"]);
        // 20 normal, 20 rash, 30 rash: reached from each other; words have no order.
        assert_eq!(told(&both, &[4, 5, 8]), ["3: speed from 20 on, profile normal, rash"]);
        assert_eq!(told(&both, &[0, 8]), ["1: speed 10, profile calm", "1: speed 30, profile rash"]);
    }

    #[test]
    fn samples_have_no_neighbours_and_are_one_group() {
        let sample: Vec<Vec<Assignment>> = [(1.0, 9.0), (2.0, 3.0), (4.0, 1.0), (5.0, 2.0)]
            .iter()
            .map(|(a, b)| vec![assignment("a", Value::Number(*a)), assignment("b", Value::Number(*b))])
            .collect();
        assert_eq!(
            told(&sample, &[0, 2]),
            ["2: 2 of 4 values of a from 1 to 4, 2 of 4 values of b from 1 to 9"]
        );
        assert_eq!(told(&sample, &[2, 3]), ["2: a from 4 on, b up to 2"]);
    }

    #[test]
    fn every_failing_trial_is_in_a_group_with_a_run_to_replay() {
        let session = Session::new();
        let report = session.report();
        let groups = groups(&report);
        let grouped: BTreeSet<&str> = groups.iter().flat_map(|group| group.trials.iter().copied()).collect();
        let failing =
            report.trials.iter().filter(|trial| trial.verdict().is_some_and(|one| one != Verdict::Passed));
        assert_eq!(grouped, failing.map(|trial| trial.trial.key.as_str()).collect());
        assert!(!groups.is_empty());
        for group in &groups {
            assert!(group.trials.contains(&group.worst.0));
            assert!(group.run().is_some_and(|run| run.starts_with(group.worst.0)));
        }
        let said: Vec<_> = groups
            .iter()
            .map(|group| format!("{} {} {}", group.scenario, group.criterion, group.in_words()))
            .collect();
        insta::assert_snapshot!(said.join("\n"));
    }

    proptest! {
        #[test]
        fn nothing_is_lost_and_nothing_is_twice(
            speeds in 1_usize..6, words in 1_usize..4, bad in proptest::collection::btree_set(0_usize..24, 0..12),
        ) {
            let speeds: Vec<f64> = (0..speeds).map(|speed| 10.0 * speed as f64).collect();
            let plan = plan(&speeds, &["a", "b", "c", "d"][..words]);
            let bad: Vec<usize> = bad.into_iter().filter(|index| *index < plan.len()).collect();
            let grid = Grid::new(&judged(&plan));
            let mut all: Vec<usize> = grid.neighbours(&bad).concat();
            all.sort_unstable();
            prop_assert_eq!(all, bad);
        }
    }
}
