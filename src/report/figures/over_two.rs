//! What came of trials over two variations.

use super::super::chart::{FAILED, Heat, HeatCell};
use super::{Data, Figure, charted};
use results::{TrialReport, Verdict};
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
            let criteria = || trials.iter().flat_map(|trial| &trial.trial.criteria);
            // What ratings count may have no criteria.
            let asked = |index: &&usize| {
                let about = |metric: &MetricReference| metric == self.reference(**index);
                criteria().next().is_none() || criteria().any(|criterion| about(criterion.claim.metric()))
            };
            let shown = |index: &&usize| {
                matches!(self.kind(**index), Some(MetricKind::Flag | MetricKind::Quantity(_)))
            };
            let mut others: Vec<String> = trials.iter().map(|trial| other_values(trial, x.0, y.0)).collect();
            others.dedup();
            others.sort();
            others.dedup();
            for index in charted.iter().filter(asked).filter(shown).take(MOST_METRICS) {
                let known = self.known(trials, *index);
                for other in &others {
                    if maps.len() == MOST_MAPS {
                        left_out += 1;
                        continue;
                    }
                    let own = trials.iter().zip(&known).filter(|(trial, _)| {
                        other_values(trial, x.0, y.0) == *other && !trial.outcomes.is_empty()
                    });
                    let title = [*name, other].join(" ").trim_end().to_string();
                    maps.extend(self.map(title, (x, y), own, (*index, badness(&known, self.worst(*index)))));
                }
            }
        }
        let mut note = "A cell is a trial: the worst value of its runs, or the share of those in which it happened; the stronger its \
                        colour the worse, and ✗ (or ?) where the trial failed (or is inconclusive), whichever criterion that was because of. It leads to the trial's line."
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
        match self.kind(index) {
            Some(MetricKind::Flag) => Worst::Largest,
            _ => self.reference(index).known().map_or(Worst::Largest, |metric| metric.worst),
        }
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
        own: impl Iterator<Item = (&'t &'t TrialReport, &'t Option<f64>)>,
        (index, badness): (usize, impl Fn(f64) -> f64),
    ) -> Option<Heat> {
        let is_flag = self.kind(index) == Some(&MetricKind::Flag);
        let quantity = self.quantity(index);
        let of = if is_flag {
            format!("{}, % of runs", quantity.name)
        } else {
            format!("worst {}", quantity.label())
        };
        let cell = |(trial, value): (&&TrialReport, &Option<f64>)| {
            let place = |(name, values): &Values| {
                let own = trial.trial.variation.iter().find(|one| one.name == *name)?;
                values.iter().position(|value| *value == own.label)
            };
            let text = value.map_or_else(|| "–".into(), |value| scenario::significant(value, 3));
            let words = format!("{}: {of} {text}", trial.trial.key);
            let verdict = trial.verdict();
            let (mark, said) = match verdict {
                Some(Verdict::Failed) => (FAILED, ", ✗ failed"),
                Some(Verdict::Inconclusive) => ("?", ", ? inconclusive"),
                _ => ("", ""),
            };
            Some(HeatCell {
                column: place(x)?,
                row: place(y)?,
                badness: value.map(&badness),
                text,
                mark,
                title: words + said,
                target: format!("#{}", trial.trial.key.replace('%', "%25")),
            })
        };
        let cells: Vec<HeatCell> = own.filter_map(cell).collect();
        let names = |(name, values): &Values| {
            (name.to_string(), values.iter().map(|value| value.to_string()).collect())
        };
        // Most places of a grid have a trial; others are no grid.
        let is_grid = 2 * cells.len() > x.1.len() * y.1.len();
        is_grid.then(|| Heat { title, quantity: of, x: names(x), y: names(y), cells })
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
    use super::*;

    #[test]
    fn the_worst_is_the_darkest() {
        let known = [Some(1.0), None, Some(3.0), Some(2.0)];
        assert_eq!([1.0, 2.0, 3.0].map(badness(&known, Worst::Smallest)), [1.0, 0.5, 0.0]);
        assert_eq!([1.0, 2.0, 3.0].map(badness(&known, Worst::Largest)), [0.0, 0.5, 1.0]);
        assert_eq!(badness(&[Some(1.0), Some(1.0)], Worst::Largest)(1.0), 0.0, "all are alike");
    }
}
