//! Failures of one cause together: one criterion that did not hold in trials of one scenario whose values are neighbours.

use std::collections::{BTreeSet, HashMap, VecDeque};

use results::{Finding, SuiteReport, TrialReport, Verdict};
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
pub fn groups<'r>(report: &'r SuiteReport) -> Vec<Group<'r>> {
    groups_of(&report.trials.iter().collect::<Vec<_>>())
}

/// Of some trials of a suite.
pub fn groups_of<'r>(trials: &[&'r TrialReport]) -> Vec<Group<'r>> {
    let mut groups = Vec::new();
    let mut scenarios: Vec<(&str, Vec<&TrialReport>)> = Vec::new();
    for trial in trials {
        let name = trial.trial.scenario.as_str();
        // From the end: trials of a scenario stand together.
        match scenarios.iter_mut().rev().find(|(known, _)| *known == name) {
            Some((_, trials)) => trials.push(trial),
            None => scenarios.push((name, vec![trial])),
        }
    }
    for (scenario, trials) in scenarios {
        let mut criteria: Vec<&str> = Vec::new();
        for finding in trials.iter().flat_map(|trial| trial.findings()) {
            if finding.verdict != Verdict::Passed && !criteria.contains(&finding.criterion.as_str()) {
                criteria.push(&finding.criterion);
            }
        }
        for criterion in criteria {
            of_criterion(&mut groups, scenario, criterion, &trials);
        }
    }
    let failing = |group: &Group| group.trials.len() as f64 / group.of as f64;
    groups.sort_by(|left, right| {
        right.verdict.cmp(&left.verdict).then(failing(right).total_cmp(&failing(left)))
    });
    groups
}

fn of_criterion<'r>(
    groups: &mut Vec<Group<'r>>,
    scenario: &'r str,
    criterion: &'r str,
    trials: &[&'r TrialReport],
) {
    let judged: Vec<(&TrialReport, &Finding)> = trials
        .iter()
        .filter_map(|trial| {
            // The scenario and a claim about it may both state it.
            let same = trial.findings().iter().filter(|finding| finding.criterion == criterion);
            Some((*trial, same.max_by_key(|finding| finding.verdict)?))
        })
        .collect();
    let plan = Grid::new(judged.iter().map(|(trial, _)| variation(trial)).collect());
    for verdict in [Verdict::Failed, Verdict::Inconclusive] {
        let bad: Vec<usize> = (0..judged.len()).filter(|index| judged[*index].1.verdict == verdict).collect();
        for members in plan.neighbours(&bad) {
            let worst =
                members.iter().copied().min_by(|left, right| worse(judged[*left].1, judged[*right].1));
            let Some(worst) = worst else { continue };
            groups.push(Group {
                scenario,
                criterion,
                verdict,
                trials: members.iter().map(|index| judged[*index].0.trial.key.as_str()).collect(),
                of: judged.len(),
                values: plan.values(&members),
                worst: (&judged[worst].0.trial.key, judged[worst].1),
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

fn variation(trial: &TrialReport) -> &[Assignment] {
    &trial.trial.variation
}

/// Trials by the ranks of their values among those that there are.
struct Grid<'r> {
    axes: Vec<Axis<'r>>,
    /// Of every trial, a rank per axis.
    places: Vec<Vec<usize>>,
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
    fn new(trials: Vec<&'r [Assignment]>) -> Self {
        let first = trials.first().copied().unwrap_or_default();
        let mut axes = Vec::new();
        let mut places = vec![Vec::new(); trials.len()];
        for (column, assignment) in first.iter().enumerate() {
            let taken: Vec<&Assignment> = trials.iter().filter_map(|one| one.get(column)).collect();
            if taken.len() < trials.len() || taken.iter().any(|one| one.name != assignment.name) {
                continue;
            }
            let ordered = taken.iter().all(|one| one.value.as_number().is_some());
            let mut distinct: Vec<&Assignment> = Vec::new();
            let mut ranks: HashMap<String, usize> = HashMap::new();
            let mut sorted = taken.clone();
            if ordered {
                let number = |one: &&Assignment| one.value.as_number().unwrap_or(0.0);
                sorted.sort_by(|left, right| number(left).total_cmp(&number(right)));
            }
            for one in sorted {
                ranks.entry(identity(&one.value)).or_insert_with(|| {
                    distinct.push(one);
                    distinct.len() - 1
                });
            }
            for (place, one) in places.iter_mut().zip(&taken) {
                place.push(ranks[&identity(&one.value)]);
            }
            let labels = distinct.iter().map(|one| one.label.split('#').next().unwrap_or_default()).collect();
            axes.push(Axis { name: &assignment.name, labels, ordered });
        }
        let combinations =
            axes.iter().try_fold(1_usize, |all, axis: &Axis| all.checked_mul(axis.labels.len()));
        let different: BTreeSet<&Vec<usize>> = places.iter().collect();
        let is_full = combinations == Some(places.len()) && different.len() == places.len();
        Self { axes, places, is_full }
    }

    /// The trials in groups of those that are reached from each other by steps to a neighbouring value of one variation.
    fn neighbours(&self, trials: &[usize]) -> Vec<Vec<usize>> {
        if !self.is_full {
            return if trials.is_empty() { Vec::new() } else { vec![trials.to_vec()] };
        }
        let mut left: HashMap<&[usize], usize> =
            trials.iter().map(|index| (self.places[*index].as_slice(), *index)).collect();
        let mut groups = Vec::new();
        for start in trials {
            let Some(start) = left.remove(self.places[*start].as_slice()) else { continue };
            let (mut group, mut waiting) = (Vec::new(), VecDeque::from([start]));
            while let Some(index) = waiting.pop_front() {
                group.push(index);
                for place in self.around(&self.places[index]) {
                    waiting.extend(left.remove(place.as_slice()));
                }
            }
            group.sort_unstable();
            groups.push(group);
        }
        groups
    }

    fn around(&self, place: &[usize]) -> Vec<Vec<usize>> {
        let mut around = Vec::new();
        for (column, axis) in self.axes.iter().enumerate() {
            let rank = place[column];
            let ranks: Vec<usize> = if axis.ordered {
                rank.checked_sub(1).into_iter().chain([rank + 1]).collect()
            } else {
                (0..axis.labels.len()).filter(|other| *other != rank).collect()
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
            let ranks: BTreeSet<usize> = trials.iter().map(|index| self.places[*index][column]).collect();
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

    fn told(plan: &[Vec<Assignment>], bad: &[usize]) -> Vec<String> {
        let grid = Grid::new(plan.iter().map(Vec::as_slice).collect());
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
            let grid = Grid::new(plan.iter().map(Vec::as_slice).collect());
            let mut all: Vec<usize> = grid.neighbours(&bad).concat();
            all.sort_unstable();
            prop_assert_eq!(all, bad);
        }
    }
}
