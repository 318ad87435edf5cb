//! Why a run came out as it did: its story in ten to twenty lines, and the same as JSON.

use std::fmt::Write;

use serde_json::{Value, json};

use super::format::with_unit;
use super::replay::{RunReason, describe, introduced, run_reasons};
use results::{
    CameOf, Neighbour, Otherwise, OtherwiseRun, Outcome, Requests, Story, TriedDeceleration, WhatIf,
};
use scenario::{Case, Criterion, Dimension};
use sim::{Happening, StopReason, TimelineEvent};

/// So many events are told; the first ones and the last ones.
const EVENTS: usize = 7;

/// A run whose story is told.
pub struct WhyRun<'a> {
    /// The run.
    pub case: &'a Case,
    /// What it has of its own, as a scenario writes it.
    pub values: &'a [(String, String)],
    /// What is asked of it.
    pub criteria: &'a [Criterion],
    /// What is measured in it.
    pub requests: &'a Requests,
    /// What happened.
    pub story: &'a Story,
    /// The nearest run that passed, or why none is told.
    pub nearest: Result<&'a Neighbour, &'a str>,
}

/// How a run stands to what is asked of it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Standing {
    Failed,
    SpokenAgainst,
    CutOff,
    Passed,
    NotJudged,
}

impl Standing {
    fn of(reasons: &[RunReason], outcome: &Outcome) -> Self {
        if reasons.iter().any(RunReason::fails) {
            Self::Failed
        } else if reasons.iter().any(|reason| !reason.fulfils()) {
            Self::SpokenAgainst
        } else if outcome.cut_off.is_some() {
            Self::CutOff
        } else if reasons.is_empty() {
            Self::NotJudged
        } else {
            Self::Passed
        }
    }

    fn word(self) -> &'static str {
        match self {
            Self::Failed => "failed",
            Self::SpokenAgainst => "spoken_against",
            Self::CutOff => "cut_off",
            Self::Passed => "passed",
            Self::NotJudged => "not_judged",
        }
    }

    fn sentence(self) -> &'static str {
        match self {
            Self::Failed => "this run fails",
            Self::SpokenAgainst => {
                "this run speaks against what its trial is to have; other runs may outweigh it"
            }
            Self::CutOff => {
                "nothing in this run speaks against what is asked of it, but it was cut off: what would have come was not seen"
            }
            Self::Passed => "this run passes",
            Self::NotJudged => "nothing is asked of this run by itself",
        }
    }
}

/// The story of a run in words.
pub fn render_why(run: &WhyRun) -> String {
    let mut text = String::new();
    let mut line = |content: &str| {
        text.push_str(content.trim_end());
        text.push('\n');
    };
    let WhyRun { case, story, .. } = run;
    let reasons = run_reasons(run.criteria, &story.outcome, run.requests);
    let standing = Standing::of(&reasons, &story.outcome);
    line(&format!("{}: {}", case.key, standing.sentence()));
    let mut values: Vec<String> = run.values.iter().map(|(name, value)| format!("{name} {value}")).collect();
    let people = case.individuals.iter();
    values.extend(
        people.map(|one| format!("{} is individual {} of {}", one.pedestrian, one.number, one.population)),
    );
    values.push(format!("seed {}", case.seed));
    line(&format!("  with {}", values.join(", ")));
    for seen in &story.first_seen {
        let car = introduced(&case.world, &seen.vehicle);
        let person = introduced(&case.world, &seen.pedestrian);
        let (Some(time), Some(distance), Some(speed)) = (seen.time, seen.distance, seen.speed) else {
            line(&format!("  {car} is never shown {person}"));
            continue;
        };
        let sees = if seen.sees_everything { "sees at once" } else { "is first shown" };
        line(&format!(
            "  {time:>7.2} s  {car} {sees} {person}: {} away, at {}",
            with_unit(distance, Dimension::LENGTH),
            with_unit(speed, Dimension::SPEED)
        ));
    }
    events(run).iter().for_each(|said| line(&format!("  {said}")));
    if let Some(contact) = &story.contact {
        line(&format!(
            "  {:>7.2} s  contact of {} with {} at {} (vehicle {}), at x {:.2} m, y {:.2} m",
            contact.time,
            contact.vehicle,
            contact.with,
            with_unit(contact.relative_speed, Dimension::SPEED),
            with_unit(contact.speed, Dimension::SPEED),
            contact.place.0,
            contact.place.1
        ));
    }
    let reason = match story.outcome.ending.reason {
        StopReason::Completed => "everybody has passed",
        StopReason::Collision => "the run ends at the collision",
        StopReason::Horizon => "time is up",
    };
    line(&format!("  {:>7.2} s  {reason}{}", story.outcome.ending.time, cut_off(&story.outcome)));
    for reason in &reasons {
        line(&format!("  {} `{}`: {}", reason.verb, reason.criterion, reason.words));
    }
    for what_if in &story.otherwise {
        line(&format!("  {}", sentence(run, what_if)));
    }
    match (standing, run.nearest) {
        (Standing::Passed, _) => {}
        (_, Ok(neighbour)) => line(&format!("  nearest run that passed: {}", neighbour_words(neighbour))),
        (_, Err(why)) => line(&format!("  nearest run that passed: {why}")),
    }
    text
}

/// `; not over for walker` of a run that was cut off.
fn cut_off(outcome: &Outcome) -> String {
    let Some(cut_off) = &outcome.cut_off else { return String::new() };
    let who: Vec<&str> = cut_off.stranded.iter().map(|one| &**one).collect();
    match who.is_empty() {
        true => "; not everything was decided by then".to_string(),
        false => format!("; it was not over for {}", who.join(", ")),
    }
}

/// What happened, a line each, without what is told elsewhere.
fn events(run: &WhyRun) -> Vec<String> {
    let is_told = |event: &&TimelineEvent| {
        !matches!(
            event.what,
            Happening::Appears | Happening::ComesIntoSight { .. } | Happening::Collides { .. }
        )
    };
    let lines: Vec<String> = run
        .story
        .events
        .iter()
        .filter(is_told)
        .map(|event| format!("{:>7.2} s  {} {}", event.time, event.who, describe(&event.what)))
        .collect();
    if lines.len() <= EVENTS + 1 {
        return lines;
    }
    // The moment of the failure is among the last ones before it.
    let (first, left_out) = (EVENTS / 2, lines.len() - EVENTS);
    let mut shown = lines[..first].to_vec();
    shown.push(format!("      …    {left_out} more events: `replay` and `--json` have them all"));
    shown.extend_from_slice(&lines[first + left_out..]);
    shown
}

/// What would have come of something, in a sentence.
fn sentence(run: &WhyRun, what_if: &WhatIf) -> String {
    let WhatIf { what, came } = what_if;
    let question = match what {
        Otherwise::BrakesEarlier { vehicle, by, from: None } => format!("{vehicle} braking {by} s earlier"),
        Otherwise::BrakesEarlier { vehicle, by, from: Some(from) } => {
            format!("{vehicle} braking {by} s earlier, from {from:.2} s on")
        }
        Otherwise::BrakesHarder { vehicle, from: None, .. } => format!("{vehicle} braking harder"),
        Otherwise::BrakesHarder { vehicle, from: Some(from), is_first_braking } => format!(
            "{vehicle} braking harder, from {from:.2} s on, when it {}",
            if *is_first_braking { "began to brake" } else { "was shown them" }
        ),
        Otherwise::AppearsLater { pedestrian, by } => format!("{pedestrian} {by} s later"),
        Otherwise::NobodyAppears => "nobody there".to_string(),
    };
    let answer = match came {
        CameOf::DoesNotApply { because } => format!("does not apply: {because}"),
        CameOf::Run(one) => run_answer(run, one),
        CameOf::Decelerations(tried) => deceleration_answer(run, tried),
    };
    format!("with {question}: {answer}")
}

/// How a run went in which something went otherwise.
fn run_answer(run: &WhyRun, one: &OtherwiseRun) -> String {
    let Some(outcome) = &one.outcome else {
        return format!("the run does not come to its end: {}", one.error.as_deref().unwrap_or("?"));
    };
    let mut said = match one.contact {
        Some(speed) => format!("contact at {}", with_unit(speed, Dimension::SPEED)),
        None => "no contact".to_string(),
    };
    let reasons = run_reasons(run.criteria, outcome, run.requests);
    let against: Vec<String> = reasons
        .iter()
        .filter(|reason| !reason.fulfils())
        .map(|reason| format!("{} `{}`: {}", reason.verb, reason.criterion, reason.words))
        .collect();
    match (against.is_empty(), one.cut_off) {
        (false, _) => write!(said, ", {}", against.join("; ")),
        (true, true) => write!(said, ", nothing speaks against it, but it was cut off"),
        (true, false) if reasons.is_empty() => Ok(()),
        (true, false) => write!(said, ", passes"),
    }
    .expect("writing to a string cannot fail");
    said
}

/// Which deceleration would have been enough.
fn deceleration_answer(run: &WhyRun, tried: &[TriedDeceleration]) -> String {
    let number = |value: f64| with_unit(value, Dimension::ACCELERATION);
    let (Some(least), Some(most)) = (tried.first(), tried.last()) else {
        return "nothing was tried".to_string();
    };
    let range =
        format!("{} to {}, {} tried", number(least.deceleration), number(most.deceleration), tried.len());
    let is_enough =
        |one: &&TriedDeceleration| one.run.passes && !one.run.cut_off && one.run.contact.is_none();
    let avoids = |one: &&TriedDeceleration| one.run.error.is_none() && one.run.contact.is_none();
    if let Some(enough) = tried.iter().find(is_enough) {
        let later: Vec<String> = tried
            .iter()
            .filter(|one| one.deceleration > enough.deceleration && !is_enough(one))
            .map(|one| number(one.deceleration))
            .collect();
        let but = match &later[..] {
            [] => String::new(),
            not => format!(", but not {}", not.join(", ")),
        };
        return format!("{} would have been enough{but} ({range})", number(enough.deceleration));
    }
    let mut said = "none would have been enough for all that is asked".to_string();
    if run.story.contact.is_some() {
        match tried.iter().find(avoids) {
            Some(one) => write!(
                said,
                "; {} would have avoided the contact, and still speaks against {}",
                number(one.deceleration),
                quoted(&one.run.against)
            ),
            None => write!(said, ", nor avoided the contact"),
        }
        .expect("writing to a string cannot fail");
    }
    format!("{said} ({range})")
}

fn quoted(criteria: &[String]) -> String {
    if criteria.is_empty() {
        return "nothing, but it was cut off".to_string();
    }
    criteria.iter().map(|one| format!("`{one}`")).collect::<Vec<_>>().join(", ")
}

fn neighbour_words(neighbour: &Neighbour) -> String {
    let differences = neighbour.differences.iter();
    let differences: Vec<String> =
        differences.map(|(name, there, here)| format!("{name} {there} instead of {here}")).collect();
    match differences.is_empty() {
        true => format!("{}, which differs in nothing but its noise", neighbour.key),
        false => format!("{}, with {}", neighbour.key, differences.join(", ")),
    }
}

/// The same as JSON: SI units, everything that happened, every deceleration that was tried.
pub fn why_json(run: &WhyRun) -> Value {
    let WhyRun { case, story, .. } = run;
    let reasons = run_reasons(run.criteria, &story.outcome, run.requests);
    let values: serde_json::Map<String, Value> =
        run.values.iter().map(|(name, value)| (name.clone(), value.clone().into())).collect();
    let criteria: Vec<Value> = reasons
        .iter()
        .map(|one| json!({ "criterion": one.criterion, "standing": one.verb.to_lowercase(), "words": one.words, "time": one.time }))
        .collect();
    let nearest = match run.nearest {
        Ok(neighbour) => json!({
            "key": neighbour.key,
            "differences": neighbour.differences.iter().map(|(name, there, here)| json!({ "name": name, "there": there, "here": here })).collect::<Vec<_>>(),
        }),
        Err(why) => json!({ "key": null, "because": why }),
    };
    json!({
        "layout": 1,
        "key": case.key,
        "scenario": case.scenario,
        "seed": case.seed,
        "fingerprint": format!("{:016x}", story.outcome.fingerprint),
        "standing": Standing::of(&reasons, &story.outcome).word(),
        "values": values,
        "individuals": case.individuals,
        "criteria": criteria,
        "ending": story.outcome.ending,
        "cut_off": story.outcome.cut_off,
        "first_seen": story.first_seen,
        "events": story.events,
        "contact": story.contact,
        "otherwise": story.otherwise,
        "nearest_passing": nearest,
    })
}
