//! One run again: the command for it and the timeline that it prints.

use std::fmt::Write;

use super::format::{quantity, with_unit};
use super::wording::{ending_of, run_words};
use results::judge::per_run;
use results::{Outcome, Requests};
use scenario::{Assignment, Case, Criterion, Dimension, Scenario, Value, World, Written, show};
use sim::{Happening, TimelineEvent};

/// The values that a case has of its own, in the units that they are written in: what its scenario varies.
pub fn case_values(case: &Case, scenario: &Scenario) -> Vec<(String, String)> {
    let shown = |one: &Assignment| match (&one.value, scenario.written.get(&one.name)) {
        (Value::Number(si), Some(Written { notation: Some(unit), .. })) => {
            show(*si, Some(*unit), Dimension::NUMBER)
        }
        _ => one.label.clone(),
    };
    // Who was drawn is told with their parameters.
    let drawn: Vec<Assignment> = case.drawn_values().collect();
    case.variation.iter().chain(&drawn).map(|one| (one.name.clone(), shown(one))).collect()
}

/// A parameter of a person in SI units: few digits where it was fitted or drawn.
fn as_written(value: &Value) -> String {
    match value {
        Value::Number(number) => show(*number, None, Dimension::NUMBER),
        other => other.to_string(),
    }
}

/// How a run stands to one thing that is asked of it.
pub(crate) struct RunReason {
    pub verb: &'static str,
    /// In canonical words, such as `pet >= 1.5 s`.
    pub criterion: String,
    /// The run's value, its distance from the bound, when and for whom.
    pub words: String,
    /// When the value was taken, s.
    pub time: Option<f64>,
    rank: u8,
}

impl RunReason {
    /// Whether the run alone breaks the criterion.
    pub fn fails(&self) -> bool {
        self.rank == 0
    }

    /// Whether it is no reason against the criterion.
    pub fn fulfils(&self) -> bool {
        self.rank == 2
    }
}

/// How a run stands to what is asked of it, what it fails first.
pub(crate) fn run_reasons(criteria: &[Criterion], outcome: &Outcome, requests: &Requests) -> Vec<RunReason> {
    let mut reasons: Vec<RunReason> = Vec::new();
    for one in criteria.iter().filter_map(per_run) {
        let (rank, verb) = match (one.standing(outcome, requests).holds, one.decisive) {
            (false, true) => (0, "FAILS"),
            // Other runs of the trial may outweigh it.
            (false, false) => (1, "speaks against"),
            (true, _) => (2, "fulfils"),
        };
        let index = requests.index(one.criterion.claim.metric());
        let critical = index.and_then(|index| outcome.critical.get(index));
        reasons.push(RunReason {
            verb,
            criterion: one.criterion.text.clone(),
            words: run_words(&one, outcome, requests),
            time: critical.and_then(|critical| critical.time),
            rank,
        });
    }
    reasons.sort_by_key(|reason| reason.rank);
    reasons
}

/// How a run stands to what is asked of it, a line each, what it fails first: the criterion, with the bound, and the run's value,
/// its distance from the bound, when and for whom.
pub fn replay_reasons(criteria: &[Criterion], outcome: &Outcome, requests: &Requests) -> Vec<String> {
    let reasons = run_reasons(criteria, outcome, requests);
    reasons.into_iter().map(|one| format!("{} `{}`: {}", one.verb, one.criterion, one.words)).collect()
}

/// What stands before the course of a run: the values that it has, and how it stands to what is asked of it.
#[derive(Debug, Clone, Default)]
pub struct ReplayIntroduction {
    /// Names with values, as a scenario writes them.
    pub values: Vec<(String, String)>,
    /// How it stands to what is asked of it, a line each.
    pub reasons: Vec<String>,
}

/// The course of one run in words: who it is about, the events in order of time, every metric.
pub fn render_replay(
    case: &Case,
    introduction: &ReplayIntroduction,
    outcome: &Outcome,
    events: &[TimelineEvent],
    requests: &Requests,
) -> String {
    let mut text = String::new();
    let mut line = |content: String| {
        text.push_str(content.trim_end());
        text.push('\n');
    };
    line(case.key.clone());
    line(format!("  seed         {}", case.seed));
    for (name, value) in &introduction.values {
        line(format!("  {name:<12} {value}"));
    }
    for person in &case.individuals {
        let parameters: Vec<_> =
            person.parameters.0.iter().map(|(name, value)| format!("{name} {}", as_written(value))).collect();
        line(format!("  {:<12} individual {} of {}", person.pedestrian, person.number, person.population));
        line(format!("               {}", parameters.join(", ")));
    }
    line(String::new());
    if !introduction.reasons.is_empty() {
        introduction.reasons.iter().for_each(|reason| line(format!("  {reason}")));
        line(String::new());
    }
    let width = events.iter().map(|event| event.who.chars().count()).max().unwrap_or(0);
    for event in events {
        line(format!("  {:>8.3} s  {:<width$}  {}", event.time, event.who, describe(&event.what)));
    }
    let reason = ending_of(outcome.ending.reason, &case.world);
    line(format!("  {:>8.3} s  {reason}", outcome.ending.time));
    line(String::new());
    for (reference, value) in requests.iter().zip(&outcome.metrics) {
        let Some(metric) = reference.known() else { continue };
        let mut name = reference.name().to_string();
        for (setting, value) in &reference.settings.0 {
            write!(name, " {setting}={value}").expect("writing to a string cannot fail");
        }
        line(format!("  {name:<28} {}", quantity(metric, *value)));
    }
    line(String::new());
    line(format!("  fingerprint  {:016x}", outcome.fingerprint));
    text
}

/// A road user with the model that decides for it: `av (carla_behavior)`.
pub(crate) fn introduced(world: &World, name: &str) -> String {
    let cars = world.vehicles.iter().map(|car| (&car.name, car.controller.model.name()));
    let people = world.pedestrians.iter().map(|person| (&person.name, person.model.model.name()));
    let model = cars.chain(people).find(|(known, _)| *known == name).map(|(_, model)| model);
    model.map_or_else(|| name.to_string(), |model| format!("{name} ({model})"))
}

/// An event in words, without when and who.
pub fn describe(what: &Happening) -> String {
    let speed = |value: f64| with_unit(value, Dimension::SPEED);
    match what {
        Happening::Appears => "appears".to_string(),
        Happening::Mode(mode) => format!("is now `{mode}`"),
        Happening::StartsWalking => "starts walking".to_string(),
        Happening::EntersCarriageway => "crosses the near kerb line".to_string(),
        Happening::PassesConflictPoint => "passes the conflict point".to_string(),
        Happening::LeavesCarriageway => "crosses the far kerb line".to_string(),
        Happening::PassesCrossing { speed: at } => {
            format!("passes the middle of the crossing at {}", speed(*at))
        }
        Happening::Brakes { speed: from } => format!("brakes from {}", speed(*from)),
        Happening::Swerves { left } => format!("swerves to the {}", if *left { "left" } else { "right" }),
        Happening::LeavesLane { left } => {
            format!("leaves its lane over the {} edge", if *left { "left" } else { "right" })
        }
        Happening::ReturnsToLane => "is back in its lane".to_string(),
        Happening::Stops => "stands still".to_string(),
        Happening::Resumes => "moves off".to_string(),
        Happening::PassesFinishLine { speed: at } => format!("passes the finish line at {}", speed(*at)),
        Happening::Collides { with, relative_speed } => {
            format!("COLLIDES with {with} at a relative speed of {}", speed(*relative_speed))
        }
        Happening::ComesIntoSight { of } => format!("comes into the sight of {of}"),
        Happening::IsLostFromSight { of } => format!("is lost from the sight of {of}"),
        Happening::Touches { with, relative_speed } => {
            format!("touches {with} at a relative speed of {}", speed(*relative_speed))
        }
    }
}
