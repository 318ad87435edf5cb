//! What came of trials over two variations.

use std::collections::BTreeMap;

use super::super::chart::{Heat, HeatCell};
use super::super::wording::standing_words;
use super::{Data, Figure, charted};
use results::{Standing, TrialReport, Verdict};
use scenario::{MetricKind, MetricReference, Worst};

/// More values of a variation than this are no grid.
const MOST_VALUES: usize = 16;
/// More metrics of a scenario than this are in its table only.
const MOST_METRICS: usize = 3;
/// More maps than this are not looked at.
const MOST_MAPS: usize = 12;

/// A variation and what it takes, in order.
type Values<'a> = (&'a str, Vec<&'a str>);

impl Data<'_> {
    /// A cell per trial of each scenario that varies two things, or more: then a map for each combination of the others.
    pub(super) fn over_two(&self, charted: &[usize]) -> Option<Figure> {
        let mut maps = Vec::new();
        let mut left_out = 0;
        for (name, trials) in &self.scenarios {
            let varied = varied(trials);
            let [x, y, ..] = &varied[..] else { continue };
            if x.1.len().max(y.1.len()) > MOST_VALUES {
                continue;
            }
            let criteria = || trials.iter().flat_map(|trial| trial.trial.criteria.iter());
            // What ratings count may have no criteria.
            let asked = |index: &&usize| {
                let about = |metric: &MetricReference| metric == self.reference(**index);
                criteria().next().is_none() || criteria().any(|criterion| about(criterion.claim.metric()))
            };
            // Of what is neither better nor worse no place is worse than another.
            let shown = |index: &&usize| {
                let has_order =
                    matches!(self.kind(**index), Some(MetricKind::Flag | MetricKind::Quantity(_)));
                has_order && self.worst(**index) != Worst::Neither
            };
            // By the values of all other variations: the indices of trials.
            let mut grids: BTreeMap<String, Vec<usize>> = BTreeMap::new();
            for (index, trial) in trials.iter().enumerate().filter(|(_, trial)| !trial.skipped()) {
                grids.entry(other_values(trial, x.0, y.0)).or_default().push(index);
            }
            // Most places of a grid have a trial; others are no grid.
            grids.retain(|_, own| 2 * own.len() > x.1.len() * y.1.len());
            for index in charted.iter().filter(asked).filter(shown).take(MOST_METRICS) {
                let known = self.known(trials, *index);
                let badness = badness(&known, self.worst(*index));
                for (other, own) in &grids {
                    if maps.len() == MOST_MAPS {
                        left_out += 1;
                        continue;
                    }
                    let own = own.iter().map(|place| (trials[*place], known[*place]));
                    let title = [*name, other].join(" ").trim_end().to_string();
                    maps.push(self.map(title, (x, y), own, (*index, &badness)));
                }
            }
        }
        let mut note = "A cell is a trial: the worst value of its runs, or the share of those in which it happened; the stronger its \
                        colour the worse, and a mark (✗ failed, ? inconclusive, ■ not finished, ! error, – not judged) where the trial did not pass, whichever criterion \
                        that was because of. It leads to the trial's line."
            .to_string();
        if left_out > 0 {
            note += &format!(" {left_out} more are in the tables only.");
        }
        (!maps.is_empty()).then(|| Figure {
            title: "Over two variations".into(),
            note,
            legend: Vec::new(),
            panels: maps.iter().map(Heat::to_svg).collect(),
        })
    }

    fn worst(&self, index: usize) -> Worst {
        self.reference(index).known().map_or(Worst::Neither, |metric| metric.worst)
    }

    /// Of each trial the worst value of its runs, in the unit of charts, or the share of runs with a yes in per cent.
    fn known(&self, trials: &[&TrialReport], index: usize) -> Vec<Option<f64>> {
        let (unit, worst) = (self.notation(index), self.worst(index));
        let of = |trial: &&TrialReport| {
            let values = || trial.outcomes.iter().filter_map(|outcome| charted(outcome, index, unit));
            if self.kind(index) == Some(&MetricKind::Flag) {
                let (all, yes) = (values().count(), values().filter(|value| *value != 0.0).count());
                return (all > 0).then(|| 100.0 * yes as f64 / all as f64);
            }
            values().reduce(if worst == Worst::Smallest { f64::min } else { f64::max })
        };
        trials.iter().map(of).collect()
    }

    fn map<'t>(
        &self,
        title: String,
        (x, y): (&Values, &Values),
        own: impl Iterator<Item = (&'t TrialReport, Option<f64>)>,
        (index, badness): (usize, &dyn Fn(f64) -> f64),
    ) -> Heat {
        let is_flag = self.kind(index) == Some(&MetricKind::Flag);
        let quantity = self.quantity(index);
        let of = if is_flag {
            format!("{}, % of runs", quantity.name)
        } else {
            format!("worst {}", quantity.label())
        };
        let cell = |(trial, value): (&TrialReport, Option<f64>)| {
            let place = |(name, values): &Values| {
                let own = trial.trial.variation.iter().find(|one| one.name == *name)?;
                values.iter().position(|value| *value == own.label)
            };
            let text = value.map_or_else(|| "–".into(), |value| scenario::significant(value, 3));
            let words = format!("{}: {of} {text}", trial.trial.key);
            // Nothing that is not known to have passed looks so.
            let (word, mark) = standing_words(trial.standing());
            let has_passed = trial.standing() == Standing::Judged(Verdict::Passed);
            let (mark, said) =
                if has_passed { ("", String::new()) } else { (mark, format!(", {mark} {word}")) };
            Some(HeatCell {
                column: place(x)?,
                row: place(y)?,
                badness: value.map(badness),
                text,
                mark,
                title: words + &said,
                target: format!("#{}", trial.trial.key.replace('%', "%25")),
            })
        };
        let cells: Vec<HeatCell> = own.filter_map(cell).collect();
        let names = |(name, values): &Values| {
            (name.to_string(), values.iter().map(|value| value.to_string()).collect())
        };
        Heat { title, quantity: of, x: names(x), y: names(y), cells }
    }
}

/// The variations that take several values, as they are written.
fn varied<'a>(trials: &[&'a TrialReport]) -> Vec<Values<'a>> {
    let mut all: Vec<Values> = Vec::new();
    for one in trials.iter().flat_map(|trial| &trial.trial.variation) {
        let place = all.iter().position(|(name, _)| *name == one.name).unwrap_or_else(|| {
            all.push((&one.name, Vec::new()));
            all.len() - 1
        });
        let values = &mut all[place].1;
        if !values.contains(&one.label.as_str()) {
            values.push(&one.label);
        }
    }
    all.retain(|(_, values)| values.len() > 1);
    all
}

/// All variations but two: `profile=cautious`.
fn other_values(trial: &TrialReport, x: &str, y: &str) -> String {
    let others = trial.trial.variation.iter().filter(|one| one.name != x && one.name != y);
    others.map(|one| format!("{}={}", one.name, one.label)).collect::<Vec<_>>().join(" ")
}

/// How bad values are between the best and the worst of all, 0..1.
fn badness(known: &[Option<f64>], worst: Worst) -> impl Fn(f64) -> f64 {
    let of = move |value: f64| if worst == Worst::Smallest { -value } else { value };
    let all = || known.iter().flatten().map(|value| of(*value)).filter(|value| value.is_finite());
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    move |value| if low < high { ((of(value) - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::time::Duration;

    use super::*;
    use crate::figures::figures;
    use crate::fixture::Session;
    use results::{Cut, Skip, Stopping, SuiteReport, TrialState};
    use scenario::{Assignment, Value};

    #[test]
    fn the_worst_is_the_darkest() {
        let known = [Some(1.0), None, Some(3.0), Some(2.0)];
        assert_eq!([1.0, 2.0, 3.0].map(badness(&known, Worst::Smallest)), [1.0, 0.5, 0.0]);
        assert_eq!([1.0, 2.0, 3.0].map(badness(&known, Worst::Largest)), [0.0, 0.5, 1.0]);
        assert_eq!(badness(&[Some(1.0), Some(1.0)], Worst::Largest)(1.0), 0.0, "all are alike");
    }

    fn of(report: &SuiteReport, session: &Session) -> Option<Figure> {
        let all = figures(report, &session.requests, &[]);
        all.into_iter().find(|figure| figure.title == "Over two variations")
    }

    /// Four trials over two variations, and over more if it says so.
    fn grid(report: &SuiteReport, more: bool) -> Vec<TrialReport> {
        let assignment =
            |name: &str, label: String| Assignment { name: name.into(), label, value: Value::Number(1.0) };
        let trial = |index: usize| {
            let mut trial = report.trials[0].clone();
            let planned = Arc::make_mut(&mut trial.trial);
            planned.key = format!("zebra/late/{index}");
            planned.variation = vec![
                assignment("v", format!("{}km/h", index / 2)),
                assignment("tta", format!("{}s", index % 2)),
            ];
            planned.variation.extend(more.then(|| assignment("more", format!("{index}"))));
            trial
        };
        (0..4).map(trial).collect()
    }

    #[test]
    fn what_did_not_come_to_its_end_does_not_look_passed() {
        let session = Session::new();
        let mut report = session.report();
        let mut trials = grid(&report, false);
        let TrialState::Judged(judged) = &mut trials[0].state else { panic!("it was judged") };
        judged.verdict = Verdict::Passed;
        let limit = Duration::from_secs(10);
        trials[1].state = TrialState::NotFinished(Cut::TimeLimit { limit, finished: 3, runs: 6 });
        trials[2].state = TrialState::Errored("it cannot be run".to_string().into());
        trials[2].outcomes.clear();
        trials[3].state = TrialState::Skipped(Skip::Stopped(Stopping::MaxFail(1)));
        report.trials = trials;
        let panel = of(&report, &session).unwrap().panels.remove(0);
        assert_eq!(panel.matches("<rect").count(), 3, "what was not run has no cell: {panel}");
        assert!(panel.contains(", ■ not finished</title>") && panel.contains(", ! error</title>"), "{panel}");
        assert!(panel.contains(">! –</text>") && panel.matches(">■ ").count() == 1, "{panel}");
    }

    #[test]
    fn places_that_are_no_grid_make_no_map() {
        let session = Session::new();
        let mut report = session.report();
        report.trials = grid(&report, false);
        assert!(of(&report, &session).is_some());
        report.trials = grid(&report, true);
        assert!(of(&report, &session).is_none(), "a map for each trial");
    }
}
