//! Whether the runs there will be can show what a criterion claims at its confidence: looked at before anything runs.

use std::collections::HashSet;

use super::trials::{ByFinding, TrialsAbout};
use crate::plan::{self, PlanError};
use crate::run::nothing_is_drawn;
use lang::{Code, Diagnostic, Sources, Span};
use numbers::inference::{self, ConfidenceSequence};
use results::Verdict;
use results::judge::{Bounds, decide};
use scenario::{
    AggregateBounds, Claim, Criterion, Origin, People, Relation, Rounds, Scenario, Suite, constant,
};

/// What it takes for a claim to pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Needed {
    /// At least so many runs.
    Runs(u64),
    /// No number of runs would do.
    More,
}

/// The fewest runs with which a claim with stated confidence can pass, however well they go; `None` for a claim
/// without confidence.
///
/// It asks the same bounds as the verdict does, so that both always agree.
fn runs_needed(criterion: &Criterion, bounds: Bounds) -> Option<Needed> {
    let needed = match &criterion.claim {
        Claim::Runs { share, confidence, .. } => {
            share_needs(Relation::GreaterOrEqual, (*share)?, (*confidence)?, bounds)
        }
        Claim::Aggregate { aggregate, relation, bound, confidence, .. } => {
            let confidence = (*confidence)?;
            match aggregate.bounds() {
                AggregateBounds::Share => share_needs(*relation, constant(bound), confidence, bounds),
                AggregateBounds::Quantile(level) => quantile_needs(*relation, level, confidence, bounds),
                AggregateBounds::Mean => match criterion.reach.limits {
                    Some(limits) => mean_needs(*relation, constant(bound), limits, confidence),
                    // One value has no spread, and with it no interval of its mean.
                    None => Some(2),
                },
                AggregateBounds::Unknown { .. } => None,
            }
        }
    };
    Some(needed.map_or(Needed::More, Needed::Runs))
}

/// The fewest runs after which the best that can happen shows the share.
fn share_needs(relation: Relation, bound: f64, confidence: f64, bounds: Bounds) -> Option<u64> {
    let all_hold = match relation {
        Relation::Greater | Relation::GreaterOrEqual => true,
        Relation::Less | Relation::LessOrEqual => false,
        Relation::Equal | Relation::NotEqual => return None,
    };
    let passes = |runs: u64| {
        let whose: Vec<usize> = (0..runs as usize * 2).map(|run| run / 2).collect();
        let (held, bounds) = match bounds {
            // Two runs each stand for any number but one.
            Bounds::People(_) => (vec![all_hold; runs as usize * 2], Bounds::People(&whose)),
            other => (vec![all_hold; runs as usize], other),
        };
        let interval = bounds.of_share(&held, confidence);
        decide(relation, interval, bound) == Verdict::Passed
    };
    let near = all_alike_need(if all_hold { bound } else { 1.0 - bound }, confidence, bounds)?;
    // A strict relation, or rounding, may take one run more than the formula.
    (near.saturating_sub(1).max(1)..=near + 1).find(|runs| passes(*runs))
}

/// The fewest runs that show the mean if all values are at the end of the limits that is farthest from its bound.
fn mean_needs(relation: Relation, bound: f64, (low, high): (f64, f64), confidence: f64) -> Option<u64> {
    let distance = match relation {
        Relation::Greater | Relation::GreaterOrEqual => bound - low,
        Relation::Less | Relation::LessOrEqual => high - bound,
        Relation::Equal | Relation::NotEqual => return None,
    };
    inference::runs_for_mean(distance / (high - low), confidence)
}

/// The fewest values of which the extreme one bounds the quantile.
fn quantile_needs(relation: Relation, level: f64, confidence: f64, bounds: Bounds) -> Option<u64> {
    match relation {
        Relation::Less | Relation::LessOrEqual => all_alike_need(level, confidence, bounds),
        Relation::Greater | Relation::GreaterOrEqual => all_alike_need(1.0 - level, confidence, bounds),
        Relation::Equal | Relation::NotEqual => None,
    }
}

/// The fewest runs that show at least `share` if all of them hold.
fn all_alike_need(share: f64, confidence: f64, bounds: Bounds) -> Option<u64> {
    match bounds {
        Bounds::Fixed => inference::runs_needed(share, confidence),
        Bounds::People(_) => inference::runs_for_mean(share, confidence),
        Bounds::Sequential => ConfidenceSequence { confidence }.runs_needed(share),
    }
}

/// What is wrong with the criteria of a suite once its trials are known: those that can never pass, as errors, and those
/// whose `when` holds in no trial, as warnings. What keeps a scenario from being planned is left to planning.
pub fn examine_criteria(suite: &Suite, sources: &Sources) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let mut bare = Vec::new();
    let mut undecided = Vec::new();
    let mut idle: Vec<&Criterion> = Vec::new();
    let mut applying: HashSet<Origin> = HashSet::new();
    let asks =
        |scenario: &&Scenario| scenario.runs.is_some() || scenario.criteria.iter().any(depends_on_trials);
    for scenario in suite.scenarios.iter().filter(asks) {
        let Ok(examined) = examine_trials(suite, scenario) else { continue };
        undecided.extend(nothing_to_decide(scenario, &examined, sources));
        bare.extend(nothing_claimed(scenario, &examined, sources));
        idle.extend(scenario.criteria.iter().filter(|criterion| !criterion.when.is_empty()));
        let ExaminedTrials { trials, runs, rounds, people, certain, short, applying: here, .. } = examined;
        applying.extend(here);
        for (criterion, about) in certain {
            let diagnostic = leaves_nothing_to_chance(scenario, &criterion, people, sources);
            found.push(about.note(diagnostic, scenario, trials));
        }
        for ((criterion, needed), about) in short {
            let diagnostic = match needed {
                Needed::Runs(needed) if is_of_chosen_people(&criterion) => {
                    too_few_people(&criterion, needed, people, sources)
                }
                needed => never_passes(scenario, &criterion, needed, runs, rounds, sources),
            };
            found.push(about.note(diagnostic, scenario, trials));
        }
    }
    found.extend(undecided);
    found.extend(bare);
    let mut said: HashSet<&Origin> = HashSet::new();
    for criterion in idle {
        if !applying.contains(&criterion.origin) && said.insert(&criterion.origin) {
            let message = "this applies to none of the values drawn";
            found.push(
                at(Code::NeverSampled, &criterion.origin, message, sources)
                    .label("never checked")
                    .note(format!("with seed {}", suite.seed))
                    .hint("draw more values, or let its `when` hold for more of them"),
            );
        }
    }
    found
}

/// What is asked of a scenario's trials, in a size that does not depend on how many they are.
#[derive(Default)]
struct ExaminedTrials {
    trials: usize,
    /// Of each trial, all that there may be.
    runs: usize,
    /// Of each trial.
    rounds: Option<Rounds>,
    /// How many groups of people walk.
    people: usize,
    /// What states a confidence where nothing is left to chance.
    certain: ByFinding<Criterion>,
    /// What has too few runs to pass.
    short: ByFinding<(Criterion, Needed)>,
    /// The trials to which no criterion applies.
    bare: Option<TrialsAbout>,
    /// Whether some criterion decides how many runs there are.
    decides: bool,
    /// The criteria that apply to some trial.
    applying: HashSet<Origin>,
}

fn examine_trials(suite: &Suite, scenario: &Scenario) -> Result<ExaminedTrials, PlanError> {
    let outlines = plan::outline(suite, scenario)?;
    let without_chance = without_chance(suite, scenario);
    let people = plan::select_people(suite.seed, scenario).map_or(1, |people| people.len());
    let mut found = ExaminedTrials { people, ..Default::default() };
    for trial in outlines {
        let trial = trial?;
        found.trials += 1;
        (found.runs, found.rounds) = (trial.runs, trial.rounds);
        if trial.criteria.is_empty() {
            TrialsAbout::add(&mut found.bare, &trial);
        }
        for criterion in trial.criteria.iter() {
            if !found.applying.contains(&criterion.origin) {
                found.applying.insert(criterion.origin.clone());
            }
            let decides = criterion.claim.confidence().is_some();
            found.decides |= decides;
            let all_people = is_of_chosen_people(criterion);
            if decides && !all_people && without_chance.contains(&trial.key) {
                let same = |known: &Criterion| known.origin == criterion.origin;
                found.certain.add(&trial, same, || criterion.clone());
                continue;
            }
            let bounds = match trial.rounds {
                Some(_) => Bounds::Sequential,
                // Each run of another person, whose shares are bounded by betting unless there is one run each.
                None if all_people && trial.runs > people => Bounds::People(&[]),
                None => Bounds::Fixed,
            };
            let Some(needed) = runs_needed(criterion, bounds) else { continue };
            let units = if all_people { people } else { trial.runs };
            if matches!(needed, Needed::Runs(needed) if needed <= units as u64) {
                continue;
            }
            let same = |known: &(Criterion, Needed)| known.0.origin == criterion.origin && known.1 == needed;
            found.short.add(&trial, same, || (criterion.clone(), needed));
        }
    }
    Ok(found)
}

/// Whether it speaks of all people, from those who were chosen beforehand; where runs draw people each run is somebody.
fn is_of_chosen_people(criterion: &Criterion) -> bool {
    criterion.reach.people == Some(People::All) && !criterion.reach.drawn_people
}

/// A budget of runs that nothing decides about.
fn nothing_to_decide(
    scenario: &Scenario,
    examined: &ExaminedTrials,
    sources: &Sources,
) -> Option<Diagnostic> {
    let budget = scenario.runs.as_ref().filter(|_| !examined.decides)?;
    let message = format!(
        "no criterion of scenario `{}` has a confidence, so there are always {} runs",
        scenario.name,
        examined.rounds.map_or(0, |rounds| rounds.least),
    );
    Some(
        at(Code::NothingToDecide, &budget.origin, message, sources)
            .label("nothing to decide")
            .hint("say `repeat`, or give a criterion a confidence: `with 95 % confidence`"),
    )
}

/// A scenario with criteria, none of which applies to some of its trials.
fn nothing_claimed(scenario: &Scenario, examined: &ExaminedTrials, sources: &Sources) -> Option<Diagnostic> {
    let bare = examined.bare.as_ref().filter(|_| !scenario.criteria.is_empty())?;
    let of = match examined.trials {
        1 => "the only trial".to_string(),
        all => format!("{} of {all} trials", bare.count()),
    };
    let message = format!("no criterion applies to {of} of scenario `{}`", scenario.name);
    let diagnostic = at(Code::NothingClaimed, &scenario.origin, message, sources)
        .label("run, but not judged")
        .hint("add a criterion without `when`, such as `no collision`, or leave these values out");
    Some(bare.note(diagnostic, scenario, examined.trials))
}

/// Whether it takes the trials to know if a criterion can pass or applies.
fn depends_on_trials(criterion: &Criterion) -> bool {
    criterion.claim.confidence().is_some() || !criterion.when.is_empty()
}

/// The keys of a scenario's trials in which nothing can be drawn; none of a scenario that cannot be planned.
fn without_chance(suite: &Suite, scenario: &Scenario) -> HashSet<String> {
    if !scenario.criteria.iter().any(|criterion| criterion.claim.confidence().is_some()) {
        return HashSet::new();
    }
    let trials = plan::probe_scenario(suite, scenario).unwrap_or_default();
    let certain = |trial: &plan::PlannedTrial| nothing_is_drawn(&trial.cases);
    trials.into_iter().filter(certain).map(|trial| trial.key.clone()).collect()
}

fn leaves_nothing_to_chance(
    scenario: &Scenario,
    criterion: &Criterion,
    people: usize,
    sources: &Sources,
) -> Diagnostic {
    let message =
        format!("`{}` states a confidence, but nothing is left to chance: all runs are one", criterion.text);
    let hint = if people > 1 {
        "say `of all people` if they stand for others, or leave out the confidence".to_string()
    } else {
        format!(
            "leave out the confidence, or let runs of scenario `{}` differ: by a model that draws, noise, people",
            scenario.name
        )
    };
    at(Code::WithoutChance, &criterion.origin, message, sources).label("nothing to be sure of").hint(hint)
}

fn too_few_people(criterion: &Criterion, needed: u64, people: usize, sources: &Sources) -> Diagnostic {
    let message = format!("`{}` needs at least {needed} people; this trial has {people}", criterion.text);
    at(Code::TooFewRuns, &criterion.origin, message, sources)
        .label("can never pass")
        .hint("take more `individuals`, or claim less, or at less confidence")
}

fn never_passes(
    scenario: &Scenario,
    criterion: &Criterion,
    needed: Needed,
    runs: usize,
    rounds: Option<Rounds>,
    sources: &Sources,
) -> Diagnostic {
    let text = &criterion.text;
    let counted = |count: u64| if count == 1 { "1 run".to_string() } else { format!("{count} runs") };
    match needed {
        Needed::Runs(needed) => {
            let (has, enough) = match (&scenario.runs, rounds) {
                (Some(budget), Some(rounds)) => {
                    let most = needed.div_ceil(rounds.size as u64) * rounds.size as u64;
                    (format!("at most {runs}"), format!("runs {} .. {most}", budget.least))
                }
                _ => {
                    let people = (runs / scenario.repeat as usize).max(1) as u64;
                    (runs.to_string(), format!("repeat {}", needed.div_ceil(people)))
                }
            };
            let message = format!("`{text}` needs at least {}; this trial has {has}", counted(needed));
            at(Code::TooFewRuns, &criterion.origin, message, sources).label("can never pass").hint(format!(
                "say `{enough}` in scenario `{}`, or claim less, or at less confidence",
                scenario.name
            ))
        }
        Needed::More => at(
            Code::TooFewRuns,
            &criterion.origin,
            format!("`{text}` can pass with no number of runs"),
            sources,
        )
        .label("can never pass")
        .hint("claim a little less, such as 99 % instead of 100 %, or leave out the confidence"),
    }
}

/// Adds a finding unless it is known: what a template or a suite says of several scenarios is said once.
pub(super) fn add_once(found: &mut Vec<Diagnostic>, finding: Diagnostic) {
    let same = |one: &Diagnostic| (one.span(), &one.message) == (finding.span(), &finding.message);
    if !found.iter().any(same) {
        found.push(finding);
    }
}

pub(super) fn at(code: Code, origin: &Origin, message: impl Into<String>, sources: &Sources) -> Diagnostic {
    let span = sources.span(origin).unwrap_or_else(|| {
        let (first, _) = sources.iter().next().expect("a suite was read from somewhere");
        Span::beginning(first)
    });
    Diagnostic::new(code, span, message)
}

#[cfg(test)]
mod tests {
    use statrs::distribution::{Binomial, DiscreteCDF};

    use super::*;
    use numbers::inference::quantile_interval;

    const AT_LEAST: Relation = Relation::GreaterOrEqual;

    fn share(relation: Relation, bound: f64, confidence: f64) -> Option<u64> {
        share_needs(relation, bound, confidence, Bounds::Fixed)
    }

    fn quantile(relation: Relation, level: f64, confidence: f64) -> Option<u64> {
        quantile_needs(relation, level, confidence, Bounds::Fixed)
    }

    #[test]
    fn looking_again_and_again_takes_more_runs() {
        let needs = |share| share_needs(AT_LEAST, share, 0.95, Bounds::Sequential);
        assert_eq!((needs(0.95), needs(0.99), needs(0.999)), (Some(88), Some(449), Some(4512)));
        assert_eq!(quantile_needs(Relation::LessOrEqual, 0.95, 0.95, Bounds::Sequential), Some(88));
        assert_eq!(needs(1.0), None);
    }

    #[test]
    fn the_known_numbers() {
        assert_eq!(share(AT_LEAST, 0.95, 0.95), Some(59));
        assert_eq!(share(AT_LEAST, 0.99, 0.95), Some(299));
        assert_eq!(share(AT_LEAST, 0.999, 0.95), Some(2995));
        assert_eq!(share(Relation::LessOrEqual, 0.01, 0.95), Some(299));
        assert_eq!(share(Relation::Less, 0.05, 0.99), Some(90));
        assert_eq!(share(AT_LEAST, 0.0, 0.95), Some(1));
        assert_eq!(share(Relation::LessOrEqual, 1.0, 0.95), Some(1));
        // Two of two show half at exactly 75 %: not more than half.
        assert_eq!(share(Relation::Greater, 0.5, 0.75), Some(3));
    }

    #[test]
    fn means_need_as_many_runs_as_their_limits_are_wide() {
        let needs = |relation, bound| mean_needs(relation, bound, (0.0, 60.0), 0.95);
        // 4.7 s of 60 s are about as far from the end as 92 % are from all.
        let needed = needs(Relation::LessOrEqual, 4.8).unwrap();
        assert!((36..=60).contains(&needed), "{needed}");
        assert_eq!(needs(AT_LEAST, 55.2), Some(needed));
        assert_eq!(needs(AT_LEAST, 60.0), None);
        assert_eq!(needs(Relation::LessOrEqual, 60.0), Some(1));
        assert!(needs(Relation::LessOrEqual, 0.001).unwrap() > 100_000);
    }

    #[test]
    fn what_no_number_of_runs_shows() {
        assert_eq!(share(AT_LEAST, 1.0, 0.95), None);
        assert_eq!(share(Relation::LessOrEqual, 0.0, 0.95), None);
        assert_eq!(share(Relation::Less, 0.0, 0.95), None);
        assert_eq!(share(Relation::Greater, 1.0, 0.95), None);
        assert_eq!(share(Relation::Equal, 0.5, 0.95), None);
        assert_eq!(quantile(Relation::LessOrEqual, 1.0, 0.95), None);
        assert_eq!(quantile(AT_LEAST, 0.0, 0.95), None);
    }

    #[test]
    fn fewer_runs_never_pass_and_so_many_can() {
        for confidence in [0.5, 0.8, 0.95, 0.99] {
            for least in [0.05, 0.1, 0.5, 0.8, 0.9, 0.95, 0.99, 0.9975] {
                let needed = share(AT_LEAST, least, confidence).unwrap();
                let verdict = |runs: u64, holding: u64| {
                    decide(
                        AT_LEAST,
                        Bounds::Fixed
                            .of_share(&(0..runs).map(|run| run < holding).collect::<Vec<_>>(), confidence),
                        least,
                    )
                };
                assert_eq!(verdict(needed, needed), Verdict::Passed, "{least} at {confidence}");
                for runs in 1..needed {
                    assert_ne!(verdict(runs, runs), Verdict::Passed, "{least} at {confidence}: {runs}");
                }
                // As another implementation has it: were the share just `share`, so many would hold this seldom.
                let luck = |runs: u64| 1.0 - Binomial::new(least, runs).unwrap().cdf(runs - 1);
                assert!(luck(needed) <= (1.0 - confidence) * (1.0 + 1e-9));
                assert!(needed == 1 || luck(needed - 1) > (1.0 - confidence) * (1.0 - 1e-9));
            }
        }
    }

    #[test]
    fn quantiles_are_bounded_from_the_number_on_that_is_needed() {
        for confidence in [0.75, 0.9, 0.95, 0.99] {
            for level in [0.05, 0.25, 0.5, 0.9, 0.95] {
                let bounded = |runs: u64, above: bool| {
                    let values: Vec<f64> = (0..runs).map(|k| k as f64).collect();
                    let (low, high) = quantile_interval(&values, level, 2.0 * confidence - 1.0);
                    if above { high.is_some() } else { low.is_some() }
                };
                for (relation, above) in [(Relation::LessOrEqual, true), (AT_LEAST, false)] {
                    let needed = quantile(relation, level, confidence).unwrap();
                    assert!(bounded(needed, above), "{level} at {confidence}: {needed}");
                    assert!(!bounded(needed - 1, above), "{level} at {confidence}: {needed}");
                }
            }
        }
    }
}
