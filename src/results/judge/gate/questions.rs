//! From rules to questions: which metric is compared in what, over which pairs of runs.

use crate::judge::baseline::{Incompatible, Pairing, RecordedMetric, RecordedTrial};
use scenario::{
    Absence, GateRate, GateRule, Metric, MetricKind, MetricReference, Notation, Relation, Tolerance,
    WhenUndefined, Worst,
};

/// One comparison to make.
pub struct Question<'a> {
    pub rule: usize,
    pub confidence: f64,
    pub tolerance: Tolerance,
    /// The unit that the rule says its tolerance in.
    pub notation: Option<Notation>,
    pub metric: &'a RecordedMetric,
    /// As reports call what is compared: `pet`, `rate(pet < 1.5 s)`.
    pub label: String,
    pub about: About,
    pub place: ComparisonPlace<'a>,
    pub pairs: Vec<RunPair<'a>>,
    /// Whether there are several people: then only whole people are independent, whose runs are alike.
    pub by_people: bool,
    /// Whether pairs are of different people.
    pub other_people: bool,
}

/// What of a metric is compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum About {
    /// Its mean over the runs that have it on both sides.
    Mean(WorseDirection),
    /// The share of runs with a yes, over the runs that have it on both sides.
    Rate(RunFlag),
    /// The share of runs in which its value compares so.
    Holds(RunCondition),
    /// The share of runs that have it. `None`: neither way is worse for sure.
    Existence(Option<RunFlag>),
    /// The runs with a yes that had a no on the same seed.
    New,
}

/// Which way a quantity gets worse.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WorseDirection {
    pub larger_is_worse: bool,
}

/// An event that a run has or has not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunFlag {
    /// Whether having it is what is bad.
    pub bad: bool,
}

/// How the value of a run compares to a bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunCondition {
    pub relation: Relation,
    /// SI units.
    pub bound: f64,
    /// Whether it holds in a run that has no value; `None`: nobody can say.
    pub without_value: Option<bool>,
    /// Whether it is bad that it holds.
    pub bad: bool,
}

impl RunCondition {
    fn of(rate: &GateRate, absence: Absence) -> Self {
        let GateRate { relation, bound, when_undefined, bad, text: _ } = *rate;
        let without_value = match (when_undefined, absence) {
            (WhenUndefined::Passes, _) => Some(true),
            (WhenUndefined::Fails, _) => Some(false),
            // Better than any value, or worse.
            (WhenUndefined::AsDeclared, Absence::Good) => Some(!bad),
            (WhenUndefined::AsDeclared, Absence::Bad) => Some(bad),
            (WhenUndefined::AsDeclared, Absence::Open) => None,
        };
        Self { relation, bound, without_value, bad }
    }

    /// Whether it holds in a run; `None` where nobody can say.
    pub fn holds(self, value: Option<f64>) -> Option<bool> {
        value.map_or(self.without_value, |value| Some(self.relation.holds(value, self.bound)))
    }
}

/// Where a comparison is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ComparisonPlace<'a> {
    /// All trials of a scenario in which chance plays a part; for what is new, all of them.
    Scenario(&'a str),
    /// One trial without chance.
    CertainTrial(&'a str),
}

/// The same run on both sides.
#[derive(Debug, Clone, PartialEq)]
pub struct RunPair<'a> {
    /// The candidate's key.
    pub key: String,
    /// The trial's.
    pub trial: &'a str,
    /// Number of the person in the scenario, in order of appearance.
    pub person: usize,
    /// The same person in all scenarios.
    pub who: &'a str,
    pub base: Option<f64>,
    pub candidate: Option<f64>,
}

pub struct Questions<'a> {
    pub asked: Vec<Question<'a>>,
    /// Metrics that no run has.
    pub without_values: Vec<String>,
    /// Metrics that the base lacks.
    pub new_metrics: Vec<String>,
    /// Metrics that are true or false, which a rule about every metric leaves out, and no rule names.
    pub unnamed_flags: Vec<String>,
}

impl Question<'_> {
    /// Whether chance can make it fail.
    pub fn shares_the_error(&self) -> bool {
        matches!(self.place, ComparisonPlace::Scenario(_))
            && !matches!(self.about, About::Existence(None) | About::New)
    }

    /// Whether nothing worse is tolerated, so that base and candidate might be exchanged if nothing is.
    pub fn tolerates_nothing(&self) -> bool {
        let of_existence = matches!(self.about, About::Existence(_));
        of_existence || matches!(self.tolerance, Tolerance::Relative(0.0) | Tolerance::Absolute(0.0))
    }
}

/// Every comparison that the rules ask for.
pub fn ask<'a>(rules: &[GateRule], pairing: &Pairing<'a>) -> Result<Questions<'a>, Vec<Incompatible>> {
    let mut questions = Questions {
        asked: Vec::new(),
        without_values: Vec::new(),
        new_metrics: Vec::new(),
        unnamed_flags: Vec::new(),
    };
    let mut missing = Vec::new();
    // What holds by default says nothing where the base has it.
    let said = rules.iter().filter(|rule| rule.tolerance != Tolerance::NoneNew { where_none_was: true });
    // A rate of runs says nothing of the mean of a quantity, and all of what is true or false.
    let is_flag =
        |metric: &MetricReference| metric.known().is_some_and(|known| known.kind == MetricKind::Flag);
    let says_all = |rule: &&GateRule| rule.rate.is_none() || rule.metric.as_ref().is_some_and(is_flag);
    let named: Vec<&MetricReference> =
        said.filter(says_all).filter_map(|rule| rule.metric.as_ref()).collect();
    for (index, rule) in rules.iter().enumerate() {
        let label = rule.metric.as_ref().map(MetricReference::label);
        missing.extend(
            label
                .filter(|label| !pairing.candidate.metrics.iter().any(|one| one.label == *label))
                .map(Incompatible::MetricMissing),
        );
        for (column, recorded) in pairing.candidate.metrics.iter().enumerate() {
            let Some(metric) = recorded.name.known() else { continue };
            let wanted = match &rule.metric {
                Some(reference) => reference.label() == recorded.label,
                None => !named.iter().any(|named| named.label() == recorded.label),
            };
            // Words and places have no order.
            if !wanted || matches!(metric.kind, MetricKind::Category(_)) || metric.worst == Worst::Neither {
                continue;
            }
            // So many percent would be so many points of its rate: far too much, and nobody said so.
            if rule.metric.is_none() && metric.kind == MetricKind::Flag {
                questions.unnamed_flags.push(recorded.label.clone());
                continue;
            }
            let Some(base_column) = pairing.base.metrics.iter().position(|one| one.label == recorded.label)
            else {
                if pairing.lenient && rule.metric.is_none() {
                    questions.new_metrics.push(recorded.label.clone());
                } else {
                    missing.push(Incompatible::MetricMissing(recorded.label.clone()));
                }
                continue;
            };
            let columns = (base_column, column);
            let exists = |(base, candidate): &(&RecordedTrial, &RecordedTrial)| {
                base.values[columns.0].iter().chain(&candidate.values[columns.1]).any(Option::is_some)
            };
            let condition = rule.rate.as_ref().map(|rate| RunCondition::of(rate, metric.absence));
            let counts_without = condition.is_some_and(|one| one.without_value.is_some());
            if !counts_without && !pairing.trials.iter().any(exists) {
                questions.without_values.push(recorded.label.clone());
                continue;
            }
            let asker = Asker { rule: index, terms: rule, recorded, metric, condition, columns, pairing };
            questions.asked.extend(asker.questions());
        }
    }
    questions.asked.sort_by_key(|question| question.place.rank(pairing));
    if missing.is_empty() { Ok(questions) } else { Err(missing) }
}

impl ComparisonPlace<'_> {
    /// Scenarios in the order of the trials, each followed by its trials without chance.
    fn rank(&self, pairing: &Pairing) -> (usize, usize) {
        let trials = &pairing.candidate.trials;
        let first_of = |scenario: &str| trials.iter().position(|trial| trial.scenario == scenario);
        match self {
            Self::Scenario(name) => (first_of(name).unwrap_or(0), 0),
            Self::CertainTrial(key) => {
                let place = trials.iter().position(|trial| trial.key == *key).unwrap_or(0);
                (first_of(&trials[place].scenario).unwrap_or(0), place + 1)
            }
        }
    }
}

struct Asker<'a, 'b> {
    rule: usize,
    terms: &'b GateRule,
    recorded: &'a RecordedMetric,
    metric: &'a Metric,
    /// What is counted, if the rule is about a rate.
    condition: Option<RunCondition>,
    /// Of the metric, in the base and in the candidate.
    columns: (usize, usize),
    pairing: &'b Pairing<'a>,
}

type TrialPair<'a> = (&'a RecordedTrial, &'a RecordedTrial);

impl<'a> Asker<'a, '_> {
    fn questions(&self) -> Vec<Question<'a>> {
        let mut asked = Vec::new();
        if let Tolerance::NoneNew { where_none_was } = self.terms.tolerance {
            // Under other seeds it is other runs that are paired.
            if self.pairing.same_seeds {
                asked.extend(self.pairing.candidate.scenarios().into_iter().filter_map(|scenario| {
                    let question = self.news(scenario)?;
                    let was = question.pairs.iter().any(|pair| pair.base.is_some_and(|value| value != 0.0));
                    (!where_none_was || !was).then_some(question)
                }));
            }
            return asked;
        }
        for scenario in self.pairing.candidate.scenarios() {
            let of_scenario = |(_, trial): &&TrialPair<'a>| trial.scenario == scenario;
            let trials: Vec<TrialPair<'a>> =
                self.pairing.trials.iter().filter(of_scenario).copied().collect();
            let is_certain = |(base, candidate): &TrialPair| base.certain && candidate.certain;
            let (certain, chancy): (Vec<_>, Vec<_>) = trials.into_iter().partition(is_certain);
            for pair in certain {
                asked.extend(self.about(ComparisonPlace::CertainTrial(&pair.1.key), &[pair]));
            }
            asked.extend(self.about(ComparisonPlace::Scenario(scenario), &chancy));
        }
        asked
    }

    /// What is new in a scenario that both sides have.
    fn news(&self, scenario: &'a str) -> Option<Question<'a>> {
        let trials: Vec<TrialPair<'a>> =
            self.pairing.trials.iter().filter(|(_, trial)| trial.scenario == scenario).copied().collect();
        let pairs = self.pairs(&trials);
        (!pairs.is_empty()).then_some(Question {
            rule: self.rule,
            confidence: self.terms.confidence,
            tolerance: self.terms.tolerance,
            notation: self.terms.notation,
            metric: self.recorded,
            label: self.recorded.label.clone(),
            about: About::New,
            place: ComparisonPlace::Scenario(scenario),
            pairs,
            by_people: false,
            other_people: false,
        })
    }

    /// The value itself, and whether it exists where it does not exist in every run.
    fn about(&self, place: ComparisonPlace<'a>, trials: &[TrialPair<'a>]) -> Vec<Question<'a>> {
        let pairs = self.pairs(trials);
        let label = self.terms.rate.as_ref().map_or(&self.recorded.label, |rate| &rate.text);
        let exists = |pair: &RunPair| pair.base.is_some() || pair.candidate.is_some();
        let in_both = |pair: &RunPair| pair.base.is_some() && pair.candidate.is_some();
        let by_people = pairs.iter().any(|pair| pair.person > 0);
        let other_people =
            by_people && trials.iter().any(|(base, candidate)| base.parts.people != candidate.parts.people);
        let question = |about| Question {
            rule: self.rule,
            confidence: self.terms.confidence,
            tolerance: self.terms.tolerance,
            notation: self.terms.notation,
            metric: self.recorded,
            label: match about {
                // Of the value, whatever is asked of it.
                About::Existence(_) => self.recorded.label.clone(),
                _ => label.clone(),
            },
            about,
            place,
            pairs: pairs.clone(),
            by_people,
            other_people,
        };
        let larger_is_worse = self.metric.worst == Worst::Largest;
        if let Some(condition) = self.condition.filter(|condition| condition.without_value.is_some()) {
            return if pairs.is_empty() { Vec::new() } else { vec![question(About::Holds(condition))] };
        }
        let mut asked = Vec::new();
        if pairs.iter().any(in_both) {
            asked.push(question(match (self.condition, &self.metric.kind) {
                (Some(condition), _) => About::Holds(condition),
                (None, MetricKind::Flag) => About::Rate(RunFlag { bad: larger_is_worse }),
                (None, _) => About::Mean(WorseDirection { larger_is_worse }),
            }));
        }
        if pairs.iter().any(exists) && !pairs.iter().all(in_both) {
            asked.push(question(About::Existence(match self.metric.absence {
                // Of a rate there is one question only where nobody can say what a run without the metric is.
                _ if self.condition.is_some() => None,
                Absence::Good => Some(RunFlag { bad: true }),
                Absence::Bad => Some(RunFlag { bad: false }),
                Absence::Open => None,
            })));
        }
        asked
    }

    fn pairs(&self, trials: &[TrialPair<'a>]) -> Vec<RunPair<'a>> {
        let mut people: Vec<&str> = Vec::new();
        let mut pairs = Vec::new();
        for (base, candidate) in trials {
            for run in 0..candidate.runs.len() {
                let name = candidate.person(run);
                let person = people.iter().position(|known| *known == name).unwrap_or(people.len());
                pairs.push(RunPair {
                    key: self.pairing.candidate.run_key(candidate, run),
                    trial: &candidate.key,
                    person,
                    who: name,
                    base: base.values[self.columns.0][run],
                    candidate: candidate.values[self.columns.1][run],
                });
                if person == people.len() {
                    people.push(name);
                }
            }
        }
        pairs
    }
}
