//! One comparison: measured, then decided.

use super::measure::{Differences, difference, sign, worse_by, worst_trial};
use super::power;
use super::questions::{About, ComparisonPlace, Question, RunPair};
use crate::judge::baseline::RecordedMetric;
use crate::{ChangedRun, Check, CheckOutcome, ComparedSubject, Power};
use numbers::inference::{MeanChange, rate_change, rate_rise};
use numbers::random::derive_seed;
use scenario::Tolerance;

/// Everything but the outcome, which depends on the other comparisons; `shares` of them share the error.
/// The second is the p-value of exchanging base and candidate, where that is asked for and no other p-value is the same.
pub fn measure(
    question: &Question,
    differences: &Differences,
    shares: f64,
    seed: u64,
) -> (Check, Option<f64>) {
    let mut check = described(question, differences);
    let mut exchanged = None;
    if check.certain {
        check.power = Power::Everything;
    } else {
        let level = check.level() / shares.max(1.0);
        let seed = derive_seed(seed, &format!("{} {} {:?}", check.label, check.place, check.subject));
        exchanged = check.compare(differences, widest(question), level, seed);
    }
    if question.about == About::Existence(None) {
        (check.p_value, check.power) = (None, Power::None);
    }
    (check, exchanged)
}

/// What is compared, of which nothing is known yet but how it looks.
pub fn described(question: &Question, differences: &Differences) -> Check {
    let subject = match question.about {
        About::Mean(_) => ComparedSubject::Mean,
        About::Rate(_) | About::Holds(_) => ComparedSubject::Rate,
        About::Existence(_) => ComparedSubject::Existence,
        About::New => ComparedSubject::New,
    };
    let tolerance = match (question.tolerance, subject) {
        (Tolerance::Relative(share), ComparedSubject::Mean) => share * differences.base.abs(),
        // A quantity's tolerance says nothing of how many runs may lack it.
        (_, ComparedSubject::Existence) => 0.0,
        (Tolerance::Relative(amount) | Tolerance::Absolute(amount), _) => amount,
        (Tolerance::NoneNew { .. }, _) => 0.0,
    };
    let (place, certain) = match question.place {
        // Whether a run is new needs no statistics.
        ComparisonPlace::Scenario(name) => (name, question.about == About::New),
        ComparisonPlace::CertainTrial(key) => (key, true),
    };
    let (worse_runs, better_runs) = changed_runs(question);
    Check {
        rule: question.rule,
        metric: question.metric.name.clone(),
        label: question.label.clone(),
        notation: question.notation,
        subject,
        place: place.to_string(),
        certain,
        outcome: CheckOutcome::NotShown,
        runs: compared(question),
        units: differences.units.len(),
        base: differences.base,
        candidate: differences.candidate,
        interval: None,
        confidence: question.confidence,
        tolerance,
        larger_is_worse: sign(question.about) > 0.0,
        p_value: None,
        adjusted_p_value: None,
        power: Power::None,
        worst_trial: worst_trial(question),
        worse_runs,
        better_runs,
    }
}

impl Check {
    /// Share of error at each end of the interval.
    pub fn level(&self) -> f64 {
        (1.0 - self.confidence) / 2.0
    }

    /// Whether its outcome does not follow from its numbers, as where results were changed by hand.
    pub fn contradicts_itself(&self) -> bool {
        let has_changed = !(self.worse_runs.is_empty() && self.better_runs.is_empty());
        let is_shown_worse = self.adjusted_p_value.is_some_and(|p| p <= self.level());
        let rounding = 1e-6 * self.tolerance;
        match self.outcome {
            CheckOutcome::Same => has_changed,
            CheckOutcome::Regressed => false,
            _ if self.power == Power::None => false,
            CheckOutcome::Held | CheckOutcome::NotShown if !self.certain => has_changed && is_shown_worse,
            CheckOutcome::Held | CheckOutcome::NotShown => {
                !self.worse_runs.is_empty() && self.worse_by() > self.tolerance + rounding
            }
        }
    }

    /// By how much it is worse; negative if it is better.
    pub fn worse_by(&self) -> f64 {
        let change = difference(self.base, self.candidate);
        if self.larger_is_worse { change } else { -change }
    }

    /// How many pairs it would take to show anything; 0 if there are enough.
    pub fn needed(&self) -> usize {
        if let Power::Blind { needed } = self.power { needed } else { 0 }
    }

    /// Interval, p-value and power where chance plays a part; `level` is the smallest p-value that matters.
    fn compare(
        &mut self,
        differences: &Differences,
        widest: Option<f64>,
        level: f64,
        seed: u64,
    ) -> Option<f64> {
        let mut exchanged = None;
        let worse = match differences.one_sided {
            Some((only_base, only_candidate)) => {
                let pairs = differences.units.len() as u64;
                self.p_value = Some(rate_rise(only_base, only_candidate, pairs, self.tolerance));
                self.power = power::of_rate(pairs, self.tolerance, level);
                rate_change(only_base, only_candidate, pairs, self.confidence)
            }
            None => {
                let change = MeanChange::stratified(differences.worse.clone(), seed);
                let change = change.expect("a question has a pair to compare").limited(widest);
                let beyond = change.above(self.tolerance, level);
                // What chance alone explains is no regression, whatever an approximate interval says.
                exchanged = (beyond < 1.0).then(|| change.exchange(level));
                self.p_value = Some(exchanged.map_or(1.0, |exchanged| beyond.max(exchanged)));
                self.power = power::of_mean(&change, self.tolerance, level);
                change.interval(self.confidence)
            }
        };
        self.interval =
            Some(if self.larger_is_worse { (worse.low, worse.high) } else { (-worse.high, -worse.low) });
        exchanged
    }

    /// Once the p-values of all comparisons are adjusted for each other.
    pub fn decide(&mut self, question: &Question) {
        // Between different people no runs belong together, so that none is known to be the same.
        let same = self.worse_runs.is_empty() && self.better_runs.is_empty() && !question.other_people;
        self.outcome = if question.about == About::Existence(None) {
            if same { CheckOutcome::Same } else { CheckOutcome::NotShown }
        } else if same {
            CheckOutcome::Same
        } else if question.about == About::New {
            if self.worse_runs.is_empty() { CheckOutcome::Held } else { CheckOutcome::Regressed }
        } else if self.certain {
            let rounding = 1e-6 * self.tolerance;
            if self.worse_by() > self.tolerance + rounding {
                CheckOutcome::Regressed
            } else {
                CheckOutcome::Held
            }
        } else if self.adjusted_p_value.is_some_and(|p| p <= self.level()) {
            CheckOutcome::Regressed
        } else if self.shown_to_hold() {
            CheckOutcome::Held
        } else {
            CheckOutcome::NotShown
        };
    }

    /// Whether the whole interval is within the tolerance, of a comparison that sees something.
    fn shown_to_hold(&self) -> bool {
        let Some((low, high)) = self.interval else { return false };
        let worst = if self.larger_is_worse { high } else { -low };
        !matches!(self.power, Power::Blind { .. }) && worst <= self.tolerance
    }
}

/// How far two runs can be apart in what is compared, where that does not depend on how long they last: a baseline does not
/// say that.
fn widest(question: &Question) -> Option<f64> {
    let About::Mean(_) = question.about else { return Some(1.0) };
    let RecordedMetric { name, settings, .. } = question.metric;
    let (low, high) = name.known()?.limits(settings, f64::INFINITY)?;
    Some(high - low).filter(|widest| widest.is_finite())
}

/// Pairs that count.
fn compared(question: &Question) -> usize {
    match question.about {
        About::Existence(_) | About::New => question.pairs.len(),
        about => question.pairs.iter().filter(|pair| worse_by(about, pair).is_some()).count(),
    }
}

/// The runs that got worse and those that got better, the largest changes first; none between different people, whose
/// runs have nothing to do with each other.
fn changed_runs(question: &Question) -> (Vec<ChangedRun>, Vec<ChangedRun>) {
    if question.other_people {
        return (Vec::new(), Vec::new());
    }
    let worse_by = |pair: &RunPair| worse_by(question.about, pair).unwrap_or(0.0);
    let mut changed: Vec<(f64, &RunPair)> =
        question.pairs.iter().map(|pair| (worse_by(pair), pair)).collect();
    changed.retain(|(worse, _)| *worse != 0.0);
    changed.sort_by(|left, right| right.0.abs().total_cmp(&left.0.abs()));
    let (worse, better): (Vec<_>, Vec<_>) = changed.into_iter().partition(|(worse, _)| *worse > 0.0);
    let runs = |all: Vec<(f64, &RunPair)>| {
        let run = |(_, pair): (f64, &RunPair)| ChangedRun {
            key: pair.key.clone(),
            base: pair.base,
            candidate: pair.candidate,
        };
        all.into_iter().map(run).collect()
    };
    (runs(worse), runs(better))
}
