//! Sequential gates: what leaves no doubt before all runs are there.
//!
//! Of chance only what is true or false in a run is looked at along the way, by [`evidence_of_worse`] on the pairs of runs that differ; means
//! are compared at the end. What needs no statistics is judged as soon as it is there.

use std::collections::HashSet;

use super::changes;
use super::check;
use super::measure::differences;
use super::questions::{self, About, ComparisonPlace, Question};
use super::rules::with_default;
use crate::judge::baseline::{Baseline, Incompatible, Pairing, RecordedMetric, RecordedTrial, pair};
use crate::{Check, CheckOutcome, GateVerdict, Looks, Power, Verdict};
use numbers::inference::evidence_of_worse;
use scenario::{Gate, GateRule, MetricReference, Tolerance};

/// Of the error of a sequential gate what is spent on looks along the way; the rest is for the end.
pub const ALONG_THE_WAY: f64 = 0.1;

/// In which order the runs of a suite are looked at: in rounds of one run, or one person's runs, of each trial.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LookRounds {
    /// Per trial: how many runs it has, and how many of them a round takes.
    trials: Vec<(usize, usize)>,
}

impl LookRounds {
    /// Of all runs of a suite.
    pub fn of(all: &Baseline) -> Self {
        Self { trials: all.trials.iter().map(|trial| (trial.runs.len(), at_once(trial))).collect() }
    }

    /// How many rounds there are.
    pub fn len(&self) -> usize {
        self.trials.iter().map(|(runs, at_once)| runs.div_ceil(*at_once)).max().unwrap_or(0)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How many runs there are of the trial with this index after so many rounds.
    pub fn runs(&self, trial: usize, rounds: usize) -> usize {
        let (runs, at_once) = self.trials[trial];
        runs.min(rounds.saturating_mul(at_once))
    }

    /// After how many rounds one looks: with a fourth more each time, so that all looks together cost little more than the last.
    pub fn looks(&self) -> impl Iterator<Item = usize> + use<> {
        let all = self.len();
        std::iter::successors(Some(1_usize), |last| Some(last + (last / 4).max(1)))
            .take_while(move |rounds| *rounds < all)
    }
}

/// Who walks first walks all of his runs in one round, if it is one of several people and they follow each other.
fn at_once(trial: &RecordedTrial) -> usize {
    let first = (0..trial.runs.len()).take_while(|run| trial.person(*run) == trial.person(0)).count();
    if first == trial.runs.len() { 1 } else { first }
}

/// What a sequential gate says of a suite after so many rounds of its runs: that it failed, or nothing. What stands in the candidate in place of
/// other runs does not matter.
///
/// # Errors
/// Every reason why the two may not be compared.
pub fn look_at(
    gate: &Gate,
    base: &Baseline,
    candidate: &Baseline,
    lenient: bool,
    after: usize,
) -> Result<Option<GateVerdict>, Vec<Incompatible>> {
    look(gate, &pair(base, candidate, lenient)?, &LookRounds::of(candidate), after)
}

/// The same of baselines that belong together.
pub fn look(
    gate: &Gate,
    all: &Pairing,
    rounds: &LookRounds,
    after: usize,
) -> Result<Option<GateVerdict>, Vec<Incompatible>> {
    let rules = &with_default(&gate.rules, all);
    let named: Vec<&MetricReference> = rules.iter().filter_map(|rule| rule.metric.as_ref()).collect();
    let bases = bases(all);
    let made = Made::of(all, &bases, (rounds, after), &named);
    let trials = bases.iter().zip(&made.candidate.trials);
    let trials = trials.filter_map(|(base, trial)| Some(((*base)?, trial))).collect();
    let pairing = Pairing { candidate: &made.candidate, trials, ..all.clone() };
    let shares = Shares::of(rules, all);
    let asked = questions::ask(rules, &pairing)?.asked;
    let checks: Vec<Check> = asked
        .into_iter()
        .filter_map(|question| {
            let shares = shares.of_rule(&rules[question.rule]);
            made.regressed(question, shares)
        })
        .collect();
    if checks.is_empty() {
        return Ok(None);
    }
    Ok(Some(GateVerdict {
        gate: gate.name.clone(),
        verdict: Verdict::Failed,
        checks,
        rules: rules.iter().map(|rule| rule.text.clone()).collect(),
        family: shares.primary + shares.others,
        primary: shares.primary,
        blind_rules: Vec::new(),
        blind_places: Vec::new(),
        unnamed_flags: Vec::new(),
        without_values: Vec::new(),
        new_metrics: Vec::new(),
        new_trials: all.new_trials.iter().map(|key| key.to_string()).collect(),
        runs: made.keys.len(),
        same_seeds: all.same_seeds,
        same_people: all.same_people,
        nothing_changed: false,
        changes: changes::changes(all),
        nondeterministic: changes::nondeterministic(all),
        cut_off: 0,
        looks: Some(Looks {
            made: rounds.looks().take_while(|look| *look <= after).count(),
            ended_it_of: Some(all.trials.iter().map(|(_, trial)| trial.runs.len()).sum()),
        }),
    }))
}

/// What each trial of the candidate is compared with; `None` of one that the base lacks.
fn bases<'a>(all: &Pairing<'a>) -> Vec<Option<&'a RecordedTrial>> {
    let mut pairs = all.trials.iter().peekable();
    let trials = all.candidate.trials.iter();
    trials.map(|trial| pairs.next_if(|(_, own)| own.key == trial.key).map(|(base, _)| *base)).collect()
}

/// What there is after some rounds.
struct Made {
    /// With the base's values for all other runs, as if those had not changed.
    candidate: Baseline,
    /// The runs that were made.
    keys: HashSet<String>,
}

impl Made {
    fn of(
        all: &Pairing,
        bases: &[Option<&RecordedTrial>],
        (rounds, after): (&LookRounds, usize),
        named: &[&MetricReference],
    ) -> Self {
        let mut candidate = all.candidate.clone();
        let columns: Vec<Option<usize>> = candidate
            .metrics
            .iter()
            .map(|metric| all.base.metrics.iter().position(|known| known.label == metric.label))
            .collect();
        let mut keys = HashSet::new();
        for (index, (base, trial)) in bases.iter().zip(&mut candidate.trials).enumerate() {
            let Some(base) = base else { continue };
            let runs = rounds.runs(index, after);
            for (row, column) in trial.values.iter_mut().zip(&columns) {
                let unchanged = |run: usize| column.and_then(|column| base.values[column][run]);
                (runs..row.len()).for_each(|run| row[run] = unchanged(run));
            }
            keys.extend((0..runs).map(|run| all.candidate.run_key(trial, run)));
        }
        let mut made = Self { candidate, keys };
        made.leave_out(all, bases, named);
        made
    }

    /// Leaves out what can show nothing yet: metrics that no rule names, of which no run gained or lost the value, where chance plays a part in
    /// all trials.
    fn leave_out(&mut self, all: &Pairing, bases: &[Option<&RecordedTrial>], named: &[&MetricReference]) {
        if all.trials.iter().any(|(base, trial)| base.certain && trial.certain) {
            return;
        }
        let Baseline { metrics, trials, .. } = &mut self.candidate;
        let tells = |(column, metric): (usize, &RecordedMetric)| {
            let is_named = named.iter().any(|one| one.label() == metric.label);
            let before = all.base.metrics.iter().position(|known| known.label == metric.label);
            // One that is missing is said to be.
            let Some(before) = before.filter(|_| !is_named) else { return true };
            let lost_or_gained = |(base, trial): (&Option<&RecordedTrial>, &RecordedTrial)| {
                base.is_some_and(|base| {
                    let both = base.values[before].iter().zip(&trial.values[column]);
                    both.into_iter().any(|(was, is)| was.is_some() != is.is_some())
                })
            };
            bases.iter().zip(&*trials).any(lost_or_gained)
        };
        let kept: Vec<bool> = metrics.iter().enumerate().map(tells).collect();
        let mut keep = kept.iter();
        metrics.retain(|_| keep.next() == Some(&true));
        for trial in trials {
            let mut keep = kept.iter();
            trial.values.retain(|_| keep.next() == Some(&true));
        }
    }

    fn has(&self, question: &Question) -> bool {
        question.pairs.iter().all(|pair| self.keys.contains(&pair.key))
    }

    /// The comparison, if it leaves no doubt that something got worse.
    fn regressed(&self, question: Question, shares: f64) -> Option<Check> {
        let is_certain = matches!(question.place, ComparisonPlace::CertainTrial(_));
        if question.about == About::New || is_certain && self.has(&question) {
            let question = self.of_made(question)?;
            let mut check = check::described(&question, &differences(&question));
            check.power = Power::Everything;
            check.decide(&question);
            return (check.outcome == CheckOutcome::Regressed).then_some(check);
        }
        if is_certain || matches!(question.about, About::Mean(_) | About::Existence(None)) {
            return None;
        }
        let question = self.seen_of(question)?;
        let found = differences(&question);
        let mut check = check::described(&question, &found);
        let evidence = evidence_of_worse(found.worse.iter().flatten().copied(), check.tolerance.min(1.0));
        check.p_value = Some((1.0 / evidence).min(1.0));
        check.adjusted_p_value = Some((shares / ALONG_THE_WAY / evidence).min(1.0));
        check.decide(&question);
        (check.outcome == CheckOutcome::Regressed).then_some(check)
    }

    /// The question of the pairs of runs that are there.
    fn of_made<'a>(&self, mut question: Question<'a>) -> Option<Question<'a>> {
        question.pairs.retain(|pair| self.keys.contains(&pair.key));
        (!question.pairs.is_empty()).then_some(question)
    }

    /// The same as far as evidence is of them. It is of whole rounds: of people, whoever has walked all of his runs counts; where trials are
    /// strata, each has to have as many runs as the others.
    fn seen_of<'a>(&self, mut question: Question<'a>) -> Option<Question<'a>> {
        if question.by_people {
            let missing = question.pairs.iter().filter(|pair| !self.keys.contains(&pair.key));
            let open: HashSet<usize> = missing.map(|pair| pair.person).collect();
            question.pairs.retain(|pair| !open.contains(&pair.person));
            return (!question.pairs.is_empty()).then_some(question);
        }
        let mut trials = question.pairs.chunk_by(|one, next| one.trial == next.trial).map(<[_]>::len);
        let first = trials.next()?;
        if trials.any(|other| other != first) { None } else { self.of_made(question) }
    }
}

/// How many comparisons there may be along the way, whatever comes of the runs: so many share what is spent there.
struct Shares {
    primary: usize,
    others: usize,
}

impl Shares {
    fn of(rules: &[GateRule], pairing: &Pairing) -> Self {
        let scenarios = pairing.candidate.scenarios().len();
        let count = |primary: bool| -> usize {
            let own = rules.iter().filter(|rule| {
                rule.primary == primary && !matches!(rule.tolerance, Tolerance::NoneNew { .. })
            });
            own.map(|rule| match rule.metric {
                // Whether it holds, and whether the metric exists.
                Some(_) => 2 * scenarios,
                // Whether each of them exists.
                None => pairing.candidate.metrics.len() * scenarios,
            })
            .sum()
        };
        Self { primary: count(true), others: count(false) }
    }

    fn of_rule(&self, rule: &GateRule) -> f64 {
        let kinds = usize::from(self.primary > 0) + usize::from(self.others > 0);
        (kinds * if rule.primary { self.primary } else { self.others }) as f64
    }
}
