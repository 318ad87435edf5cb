//! Which runs of two baselines belong together, and why some may not be compared at all.

use serde::Serialize;
use std::fmt;

use super::{Baseline, Parts, RecordedTrial};

/// Two baselines trial by trial.
#[derive(Debug, Clone)]
pub struct Pairing<'a> {
    /// What is compared with.
    pub base: &'a Baseline,
    /// What is compared.
    pub candidate: &'a Baseline,
    /// Trials of both, in the order of the candidate's keys.
    pub trials: Vec<(&'a RecordedTrial, &'a RecordedTrial)>,
    /// Keys of trials that only the candidate has.
    pub new_trials: Vec<&'a str>,
    /// Whether what the base lacks is left out instead of being a reason not to compare.
    pub lenient: bool,
    /// Whether runs of the same key have the same seed, so that they differ by what is tested only.
    pub same_seeds: bool,
    /// Whether runs of the same key are of the same people.
    pub same_people: bool,
}

/// One reason not to compare.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Incompatible {
    /// A gate's baseline is of another suite.
    OtherSuite {
        /// The base's suite.
        base: String,
        /// The candidate's suite.
        candidate: String,
    },
    /// What was set on the command line is not the same for both.
    OtherValues {
        /// What was set for the base: `av.speed=40km/h`.
        base: Vec<String>,
        /// What was set for the candidate.
        candidate: Vec<String>,
    },
    /// They have no trial in common.
    NothingInCommon {
        /// The base's suite.
        base: String,
        /// The candidate's suite.
        candidate: String,
    },
    /// Trials that the candidate lacks.
    Vanished(Vec<String>),
    /// Trials that the base lacks.
    New(Vec<String>),
    /// A metric that is asked for, which the base has not.
    MetricMissing(String),
    /// A metric of the same name that is measured otherwise.
    MetricDiffers(String),
    /// Trials whose runs are other ones, or more or fewer.
    Runs(Vec<String>),
    /// Populations that are not what they were, whoever was drawn.
    Populations(Vec<String>),
    /// The base does not say what its populations were, and the seeds differ.
    PopulationsUnknown,
    /// Trials in which something besides what is tested differs.
    Part {
        /// Which part of the world.
        part: WorldPart,
        /// The keys of those trials.
        trials: Vec<String>,
    },
}

/// What of a world decides its runs besides what is tested.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WorldPart {
    /// Lanes, kerbs, crossing, speed limit and boxes.
    Road,
    /// Models with their settings, sizes, ways and when they appear.
    Pedestrians,
    /// The individuals drawn from populations.
    People,
    /// How fast, in which lane and from where the vehicles come.
    Traffic,
    /// Step, horizon, finish line, and what every run draws.
    Simulation,
}

/// A sentence.
impl fmt::Display for Incompatible {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let in_trials = |trials: &[String]| match trials {
            [one] => format!("in {one}"),
            many => format!("in {} trials: {}", many.len(), some(many)),
        };
        let text = match self {
            Incompatible::OtherSuite { base, candidate } => {
                format!("it is of suite `{base}`, and this is suite `{candidate}`")
            }
            Incompatible::NothingInCommon { base, candidate } => {
                format!("suite `{base}` and suite `{candidate}` have no trial in common")
            }
            Incompatible::OtherValues { base, candidate } => {
                let with = |set: &[String]| match set {
                    [] => "as the files say".to_string(),
                    set => format!("with {}", set.join(", ")),
                };
                format!("the base was run {}, the candidate {}", with(base), with(candidate))
            }
            Incompatible::Vanished(trials) => format!("trials are gone: {}", some(trials)),
            Incompatible::New(trials) => format!("trials are new: {}", some(trials)),
            Incompatible::MetricMissing(label) => format!("the base has no metric `{label}`"),
            Incompatible::MetricDiffers(label) => format!("`{label}` was measured with other parameters"),
            Incompatible::Runs(trials) => {
                format!("there are other runs (`repeat` or individuals) {}", in_trials(trials))
            }
            Incompatible::Populations(names) => {
                format!("the people of {} are not those of the base, whoever is drawn from them", some(names))
            }
            Incompatible::PopulationsUnknown => {
                "the seeds and so the people differ, and the base does not say which population its own came from"
                    .to_string()
            }
            Incompatible::Part { part, trials } => {
                let what = match part {
                    WorldPart::Road => "the road differs",
                    WorldPart::Pedestrians => {
                        "the pedestrians differ (model, parameters, start, goal or when they appear)"
                    }
                    WorldPart::People => "the individuals differ (the population's file)",
                    WorldPart::Traffic => "the vehicles' speed, lane or start differs",
                    WorldPart::Simulation => "step, horizon, finish line or what runs draw differs",
                };
                format!("{what} {}", in_trials(trials))
            }
        };
        out.write_str(&text)
    }
}

/// The first few names, and how many more there are.
pub fn some(names: &[String]) -> String {
    let shown: Vec<_> = names.iter().take(3).map(String::as_str).collect();
    let more = names.len() - shown.len();
    let shown = shown.join(", ");
    if more > 0 { format!("{shown} and {more} more") } else { shown }
}

impl WorldPart {
    const ALL: [Self; 5] = [Self::Road, Self::Pedestrians, Self::People, Self::Traffic, Self::Simulation];

    fn of(self, parts: &Parts) -> &str {
        match self {
            Self::Road => &parts.road,
            Self::Pedestrians => &parts.pedestrians,
            Self::People => &parts.people,
            Self::Traffic => &parts.traffic,
            Self::Simulation => &parts.simulation,
        }
    }
}

/// Pairs the trials of two baselines. With `lenient`, trials that only the candidate has are named, but no reason not
/// to compare.
///
/// # Errors
/// Every reason not to compare.
pub fn pair<'a>(
    base: &'a Baseline,
    candidate: &'a Baseline,
    lenient: bool,
) -> Result<Pairing<'a>, Vec<Incompatible>> {
    let find = |all: &'a Baseline, key: &str| all.trials.iter().find(|trial| trial.key == key);
    let trials: Vec<_> =
        candidate.trials.iter().filter_map(|trial| Some((find(base, &trial.key)?, trial))).collect();
    let mut reasons = Vec::new();
    if !base.has_values(&candidate.set) {
        let (base, candidate) = (base.set.clone(), candidate.set.clone());
        reasons.push(Incompatible::OtherValues { base, candidate });
    }
    if trials.is_empty() {
        let (base, candidate) = (base.suite.clone(), candidate.suite.clone());
        reasons.push(Incompatible::NothingInCommon { base, candidate });
        return Err(reasons);
    }
    let only_in = |one: &'a Baseline, other: &'a Baseline| -> Vec<&'a str> {
        let keys = one.trials.iter().map(|trial| trial.key.as_str());
        keys.filter(|key| find(other, key).is_none()).collect()
    };
    let owned = |keys: &[&str]| keys.iter().map(|key| key.to_string()).collect::<Vec<_>>();
    let vanished = only_in(base, candidate);
    if !vanished.is_empty() {
        reasons.push(Incompatible::Vanished(owned(&vanished)));
    }
    let new_trials = only_in(candidate, base);
    if !new_trials.is_empty() && !lenient {
        reasons.push(Incompatible::New(owned(&new_trials)));
    }
    // Seeds come from the suite's seed and the run's key, which begins with the suite's name.
    let same_seeds = base.seed == candidate.seed && base.suite == candidate.suite;
    let same_people = trials.iter().all(|(base, candidate)| base.parts.people == candidate.parts.people);
    for metric in &candidate.metrics {
        let known = base.metrics.iter().find(|known| known.label == metric.label);
        if known.is_some_and(|known| !known.is_as(metric)) {
            reasons.push(Incompatible::MetricDiffers(metric.label.clone()));
        }
    }
    let runs_fit = |base: &RecordedTrial, candidate: &RecordedTrial| {
        if same_people { base.runs == candidate.runs } else { base.runs.len() == candidate.runs.len() }
    };
    let (fitting, unfitting): (Vec<_>, Vec<_>) =
        trials.iter().copied().partition(|(base, candidate)| runs_fit(base, candidate));
    if !unfitting.is_empty() {
        let keys = unfitting.iter().map(|(_, trial)| trial.key.clone());
        reasons.push(Incompatible::Runs(keys.collect()));
    }
    for part in WorldPart::ALL {
        // Another seed draws other people.
        if part == WorldPart::People && !same_seeds {
            continue;
        }
        let differing =
            fitting.iter().filter(|(base, candidate)| part.of(&base.parts) != part.of(&candidate.parts));
        let keys: Vec<_> = differing.map(|(_, trial)| trial.key.clone()).collect();
        if !keys.is_empty() {
            reasons.push(Incompatible::Part { part, trials: keys });
        }
    }
    reasons.extend(other_populations(base, candidate, same_seeds));
    if reasons.is_empty() {
        Ok(Pairing { base, candidate, trials, new_trials, lenient, same_seeds, same_people })
    } else {
        Err(reasons)
    }
}

/// People of two populations are not compared, whatever the seed. Under the same seed it shows in the people themselves.
fn other_populations(base: &Baseline, candidate: &Baseline, same_seeds: bool) -> Option<Incompatible> {
    if base.populations.is_empty() && !candidate.populations.is_empty() {
        return (!same_seeds).then_some(Incompatible::PopulationsUnknown);
    }
    let gone = base.populations.iter().filter(|(name, digest)| match candidate.populations.get(*name) {
        Some(now) => now != *digest,
        None => !candidate.populations.values().any(|now| now == *digest),
    });
    // Of one that ships it is said which version is which: nobody has changed a file.
    let in_words = |name: &String| {
        let (then, now) = (base.population_versions.get(name), candidate.population_versions.get(name));
        match then.zip(now) {
            Some((then, now)) if then != now => {
                let older = scenario::population::shipped_older(name, *then);
                let older = older.map_or_else(String::new, |older| format!("; `{older}` is version {then}"));
                format!("{name} (version {then} there, {now} here{older})")
            }
            _ => name.clone(),
        }
    };
    let gone: Vec<String> = gone.map(|(name, _)| in_words(name)).collect();
    (!gone.is_empty()).then_some(Incompatible::Populations(gone))
}

impl Pairing<'_> {
    /// Whether every run took the same course as before, bit for bit.
    pub fn nothing_changed(&self) -> bool {
        !self.trials.iter().any(changed)
    }

    /// Whether some run of a scenario took another course.
    pub fn changed_in(&self, scenario: &str) -> bool {
        self.trials.iter().filter(|(_, trial)| trial.scenario == scenario).any(changed)
    }
}

fn changed((base, candidate): &(&RecordedTrial, &RecordedTrial)) -> bool {
    base.fingerprint != candidate.fingerprint || base.values != candidate.values
}
