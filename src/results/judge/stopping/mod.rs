//! When a trial whose runs are added a round at a time has enough of them.
//!
//! Runs are looked at in the order of the plan and only after whole rounds, so it does not matter who runs them when. A
//! criterion is decided by bounds that hold however often one looks; what it is found to be then stays.

#[cfg(test)]
mod tests;

use std::sync::Arc;

use super::confidence::Bounds;
use super::criteria::find;
use super::possible::bounded_above;
use super::seen::{Evidence, Seen};
use crate::{Finding, Outcome, Reason, Requests, RunsTaken, TrialVerdict, Verdict};
use numbers::inference::{ConfidenceSequence, IndependentUnit, MeanWatch, ShareDecision};
use scenario::{
    Aggregate, AggregateBounds, Claim, Comparison, Criterion, MetricReference, Relation, Trial,
    WhenUndefined, constant,
};

/// Follows the outcomes of a trial to see when they are enough.
pub struct Watch<'a> {
    trial: Arc<Trial>,
    requests: &'a Requests,
    /// One per criterion with stated confidence.
    tests: Vec<Test>,
    seen: usize,
    enough: Option<usize>,
}

/// A criterion with stated confidence, followed from run to run.
struct Test {
    /// Index of the criterion.
    criterion: usize,
    /// Index of the metric in the outcomes.
    metric: usize,
    about: About,
    /// What was found when it was decided.
    finding: Option<Finding>,
}

/// What is followed.
enum About {
    /// A claim about the share of runs in which an event happens.
    Share(Share),
    /// A claim about the mean of a metric that has limits, and its relation: what a run counts as that has no value.
    Mean(Box<MeanWatch>, MetricReference, Relation),
}

struct Share {
    event: Comparison,
    /// Whether the event counts as having happened where nobody can know.
    unknown: bool,
    /// Of a quantile, the relation that is claimed: what a run counts as that has no value.
    claimed: Option<Relation>,
    share: f64,
    sequence: ConfidenceSequence,
    runs: u64,
    happened: u64,
}

impl<'a> Watch<'a> {
    /// `requests` says which metric is where in the outcomes.
    pub fn new(trial: &Arc<Trial>, requests: &'a Requests) -> Self {
        let tests = match trial.rounds {
            Some(_) => {
                let criteria = trial.criteria.iter().enumerate();
                criteria.filter_map(|(index, criterion)| Test::new(index, criterion, requests)).collect()
            }
            None => Vec::new(),
        };
        Self { trial: trial.clone(), requests, tests, seen: 0, enough: None }
    }

    /// Looks at what the trial's first runs came to, of which there are more at every call. If fewer of them are
    /// enough, says how many: the others do not count.
    pub fn enough(&mut self, outcomes: &[Outcome]) -> Option<usize> {
        let rounds = self.trial.rounds?;
        while self.enough.is_none() && self.seen < outcomes.len() {
            let outcome = &outcomes[self.seen];
            self.tests.iter_mut().for_each(|test| test.count(outcome));
            self.seen += 1;
            if self.seen >= rounds.least && self.seen.is_multiple_of(rounds.size) {
                let bounds = Bounds::Sequential;
                let evidence = Evidence { outcomes: &outcomes[..self.seen], requests: self.requests, bounds };
                self.tests.iter_mut().for_each(|test| test.look(&self.trial.criteria, &evidence));
                if self.tests.iter().all(|test| test.finding.is_some()) {
                    self.enough = Some(self.seen);
                }
            }
        }
        self.enough
    }

    /// The verdict on the trial's runs, without those that do not count.
    pub fn verdict(mut self, outcomes: &[Outcome]) -> TrialVerdict {
        let outcomes = &outcomes[..self.enough(outcomes).unwrap_or(outcomes.len())];
        let Trial { criteria, rounds, .. } = &*self.trial;
        let bounds = if rounds.is_some() { Bounds::Sequential } else { Bounds::Fixed };
        let evidence = Evidence { outcomes, requests: self.requests, bounds };
        let finding = |(index, criterion)| {
            let decided = self.tests.iter().find(|test| test.criterion == index);
            decided.and_then(|test| test.finding.clone()).unwrap_or_else(|| find(criterion, &evidence))
        };
        let findings = criteria.iter().enumerate().map(finding).collect();
        let stopping = rounds.map(|rounds| RunsTaken {
            least: rounds.least,
            most: rounds.most,
            runs: outcomes.len(),
            reason: match self.enough {
                _ if self.tests.is_empty() => Reason::NothingToDecide,
                Some(_) => Reason::Decided,
                None => Reason::Budget,
            },
        });
        TrialVerdict { stopping, ..TrialVerdict::of(findings, criteria, &evidence) }
    }
}

impl Test {
    /// `None` for a criterion without confidence, and for one that cannot be followed.
    fn new(index: usize, criterion: &Criterion, requests: &Requests) -> Option<Self> {
        let about = match &criterion.claim {
            Claim::Runs { comparison, share, confidence } => {
                About::Share(Share::new(comparison.clone(), (false, None), (*share)?, (*confidence)?))
            }
            Claim::Aggregate { aggregate, relation, bound, confidence, .. } => {
                let confidence = (*confidence)?;
                let claimed = *relation;
                let quantile = |level: f64| {
                    // Whether the quantile is at least so large is a matter of how many values are smaller.
                    let relation = match relation {
                        Relation::Greater | Relation::LessOrEqual => Relation::LessOrEqual,
                        _ => Relation::Less,
                    };
                    let metric = aggregate.metric().clone();
                    let event = Comparison {
                        metric,
                        relation,
                        bound: bound.clone(),
                        when_undefined: WhenUndefined::Fails,
                    };
                    About::Share(Share::new(event, (false, Some(claimed)), level, confidence))
                };
                match aggregate {
                    Aggregate::Rate(comparison) => {
                        let unknown = bounded_above(*relation);
                        let share = constant(bound);
                        About::Share(Share::new(comparison.clone(), (unknown, None), share, confidence))
                    }
                    of_values => match of_values.bounds() {
                        AggregateBounds::Quantile(level) => quantile(level),
                        AggregateBounds::Mean => {
                            let watch = MeanWatch::new(constant(bound), criterion.reach.limits?, confidence);
                            About::Mean(Box::new(watch), of_values.metric().clone(), claimed)
                        }
                        AggregateBounds::Share | AggregateBounds::Unknown { .. } => return None,
                    },
                }
            }
        };
        let metric = requests.index(criterion.claim.metric())?;
        Some(Self { criterion: index, metric, about, finding: None })
    }

    fn count(&mut self, outcome: &Outcome) {
        let seen = Seen::of(outcome, self.metric);
        match &mut self.about {
            About::Mean(watch, metric, claimed) => {
                watch.take(IndependentUnit::of_run(seen.worst(metric, *claimed)))
            }
            About::Share(share) => share.count(seen),
        }
    }

    /// Decides if it can.
    fn look(&mut self, criteria: &[Criterion], evidence: &Evidence) {
        let decided = match &self.about {
            About::Mean(watch, ..) => watch.decided(),
            About::Share(share) => share.decided(),
        };
        if self.finding.is_some() || !decided {
            return;
        }
        // The interval that is shown decides in the end, so that nothing contradicts it.
        let finding = find(&criteria[self.criterion], evidence);
        if finding.verdict != Verdict::Inconclusive {
            self.finding = Some(finding);
        }
    }
}

impl Share {
    fn new(
        event: Comparison,
        (unknown, claimed): (bool, Option<Relation>),
        share: f64,
        confidence: f64,
    ) -> Self {
        let sequence = ConfidenceSequence { confidence };
        Self { event, unknown, claimed, share, sequence, runs: 0, happened: 0 }
    }

    fn count(&mut self, seen: Seen) {
        let happened = match self.claimed {
            None => Some(seen.holds(&self.event, self.unknown)),
            Some(claimed) => {
                let value = seen.worst(&self.event.metric, claimed);
                value.map(|value| self.event.relation.holds(value, self.event.constant_bound()))
            }
        };
        if let Some(happened) = happened {
            self.runs += 1;
            self.happened += u64::from(happened);
        }
    }

    fn decided(&self) -> bool {
        self.runs > 0 && self.sequence.decide(self.happened, self.runs, self.share) != ShareDecision::Open
    }
}
