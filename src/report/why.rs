//! Why a run came out as it did: its story in ten to twenty lines, and the same as JSON.

use std::fmt::Write;

use serde_json::{Value, json};

use super::drawing::moment_text;
use super::format::with_unit;
use super::perceived::{perceived_words, road_user};
use super::replay::{RunReason, describe, introduced, run_reasons};
use super::wording::ending_of;
use results::{
    CameOf, FirstSeen, Neighbour, Otherwise, OtherwiseRun, Outcome, Requests, Story, TriedDeceleration,
    WhatIf,
};
use scenario::{Case, Criterion, Dimension};
use sim::{Happening, PerceivedView, TimelineEvent};

/// So many events are told besides who is shown whom and the contact.
const EVENTS: usize = 6;

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
pub(super) enum Standing {
    Failed,
    SpokenAgainst,
    CutOff,
    Passed,
    NotJudged,
}

impl Standing {
    pub fn of(reasons: &[RunReason], outcome: &Outcome) -> Self {
        if reasons.iter().any(RunReason::fails) {
            Self::Failed
        } else if reasons.iter().any(|reason| !reason.fulfils()) {
            Self::SpokenAgainst
        } else if outcome.hides_meetings() {
            Self::CutOff
        } else if reasons.is_empty() {
            Self::NotJudged
        } else {
            Self::Passed
        }
    }

    pub fn word(self) -> &'static str {
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
                "nothing in this run speaks against what is asked of it, but it ended before somebody was met: what would have come was not seen"
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
    course(run, moment(story, &reasons)).iter().for_each(|said| line(&format!("  {said}")));
    let reason = ending_of(story.outcome.ending.reason, &case.world);
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

/// A picture is no larger, columns and rows.
const PICTURE: (usize, usize) = (72, 7);

/// Who was where when the run failed, from above; nothing of one that did not.
pub fn render_moment(run: &WhyRun) -> String {
    let reasons = run_reasons(run.criteria, &run.story.outcome, run.requests);
    let Some(time) = moment(run.story, &reasons) else { return String::new() };
    let lines = moment_text(run.case, &run.story.trace, time, PICTURE.0, PICTURE.1);
    let lines: String = lines.iter().map(|line| format!("  {line}").trim_end().to_string() + "\n").collect();
    format!("  from above, after {time:.2} s:\n{lines}")
}

/// `; not over for walker` of a run that was cut off.
pub(super) fn cut_off(outcome: &Outcome) -> String {
    let Some(cut_off) = &outcome.cut_off else { return String::new() };
    let who: Vec<&str> = cut_off.stranded.iter().map(|one| &**one).collect();
    match who.is_empty() {
        true => "; not everything was decided by then".to_string(),
        false => format!("; it was not over for {}", who.join(", ")),
    }
}

/// When the run failed, s: at its first contact, or when the first criterion that it does not have had its value.
fn moment(story: &Story, reasons: &[RunReason]) -> Option<f64> {
    let failing = || reasons.iter().find(|reason| !reason.fulfils());
    story.contact.as_ref().map(|contact| contact.time).or_else(|| failing()?.time)
}

/// What happened, a line each in the order of time: all sights and the contact, and of the other events the first ones and the last ones
/// until the run failed.
fn course(run: &WhyRun, moment: Option<f64>) -> Vec<String> {
    let story = run.story;
    let stamp = |time: f64, said: String| (time, format!("{time:>7.2} s  {said}"));
    let seen = story.first_seen.iter().filter(|seen| is_of_interest(run, seen));
    let seen = seen.map(|seen| first_sight(run, seen));
    let (seen, never): (Vec<_>, Vec<_>) = seen.partition(|(time, _)| time.is_some());
    let mut lines: Vec<(f64, String)> =
        seen.into_iter().filter_map(|(time, said)| Some(stamp(time?, said))).collect();
    let is_told = |event: &&TimelineEvent| {
        let is_elsewhere = matches!(
            event.what,
            Happening::Appears | Happening::ComesIntoSight { .. } | Happening::Collides { .. }
        );
        !is_elsewhere && moment.is_none_or(|moment| event.time <= moment)
    };
    let events: Vec<&TimelineEvent> = story.events.iter().filter(is_told).collect();
    let left_out = events.len().saturating_sub(EVENTS);
    let shown =
        events.iter().enumerate().filter(|(place, _)| *place < EVENTS / 2 || *place >= EVENTS / 2 + left_out);
    lines.extend(
        shown.map(|(_, event)| stamp(event.time, format!("{} {}", event.who, describe(&event.what)))),
    );
    lines.extend(story.contact.as_ref().map(|contact| {
        let said = format!(
            "contact of {} with {}: they move against each other at {}, {} drives at {}; at x {:.2} m, y {:.2} m",
            contact.vehicle,
            contact.with,
            with_unit(contact.relative_speed, Dimension::SPEED),
            contact.vehicle,
            with_unit(contact.speed, Dimension::SPEED),
            contact.place.0,
            contact.place.1
        );
        stamp(contact.time, said)
    }));
    let perceived = misperceived(run, moment);
    let told = perceived.iter().flat_map(|view| {
        perceived_words(&run.case.world, view).map(|said| stamp(view.time, format!("{said} (last decision)")))
    });
    lines.extend(told);
    lines.sort_by(|one, other| one.0.total_cmp(&other.0));
    let mut lines: Vec<String> = lines.into_iter().map(|(_, line)| line).collect();
    lines.extend(never.into_iter().map(|(_, said)| said));
    let later = story.events.iter().filter(|event| moment.is_some_and(|moment| event.time > moment)).count();
    if left_out + later > 0 {
        lines.push(format!("      …    {} more events: `replay` and `--json` have them", left_out + later));
    }
    lines
}

/// What controllers were told last until the run failed and was not so.
fn misperceived<'r>(run: &WhyRun<'r>, moment: Option<f64>) -> Vec<&'r PerceivedView> {
    let Some(moment) = moment else { return Vec::new() };
    let views = &run.story.trace.perceived;
    let vehicles = 0..run.case.world.vehicles.len();
    vehicles.filter_map(|vehicle| PerceivedView::last(views, vehicle, moment)).collect()
}

/// Whether more than the place in a stream is to be told of a vehicle: of each stream of the one that touched, and of the nearest.
fn is_of_interest(run: &WhyRun, seen: &FirstSeen) -> bool {
    let (world, story) = (&run.case.world, run.story);
    let stream = |name: &str| {
        let index = world.vehicles.iter().position(|car| car.name == name)?;
        world.streams.iter().position(|stream| stream.vehicles.contains(&index))
    };
    let own = stream(&seen.vehicle);
    let touched = story.contact.as_ref().is_some_and(|contact| contact.vehicle == seen.vehicle);
    let distance = |one: &FirstSeen| one.distance.unwrap_or(f64::INFINITY);
    let mut alike = story
        .first_seen
        .iter()
        .filter(|one| one.pedestrian == seen.pedestrian && stream(&one.vehicle) == own);
    own.is_none() || touched || alike.all(|one| distance(seen) <= distance(one))
}

/// When somebody was first shown whom, s, and that in words.
fn first_sight(run: &WhyRun, seen: &FirstSeen) -> (Option<f64>, String) {
    let world = &run.case.world;
    let (car, person) = (introduced(world, &seen.vehicle), introduced(world, &seen.pedestrian));
    let (Some(distance), Some(speed)) = (seen.distance, seen.speed) else {
        return (None, format!("{car} is never shown {person}"));
    };
    let distance = with_unit(distance, Dimension::LENGTH);
    let speed = with_unit(speed, Dimension::SPEED);
    let said = match seen.sees_everything {
        true => {
            format!("{person} appears {distance} from {car}, which sees everything and drives at {speed}")
        }
        false => format!("{car} is first shown {person}, {distance} away, and drives at {speed}"),
    };
    (seen.time, said)
}

/// What would have come of something, in a sentence.
fn sentence(run: &WhyRun, what_if: &WhatIf) -> String {
    let WhatIf { what, came } = what_if;
    let question = match what {
        Otherwise::BrakesEarlier { vehicle, by, from: None } => format!("{vehicle} braking {by} s earlier"),
        Otherwise::BrakesEarlier { vehicle, by, from: Some(from) } => {
            format!("{vehicle} braking {by} s earlier, from {from:.2} s on")
        }
        Otherwise::Decelerates { vehicle, from: None, .. } => format!("{vehicle} decelerating evenly"),
        Otherwise::Decelerates { vehicle, from: Some(from), is_first_braking } => format!(
            "{vehicle} decelerating evenly, from {from:.2} s on{}",
            match *is_first_braking {
                true => ", when it began to brake",
                false if *from > 0.0 => ", when it was shown them",
                false => "",
            }
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
        .filter(|reason| !reason.fulfils() && one.against.contains(&reason.criterion))
        .map(|reason| format!("{} `{}`: {}", reason.verb, reason.criterion, reason.words))
        .collect();
    match (against.is_empty(), one.cut_off) {
        (false, _) => write!(said, ", {}", against.join("; ")),
        (true, true) => write!(said, ", nothing speaks against it, but it ended before somebody was met"),
        (true, false) if one.criteria == 0 => write!(said, ", and nothing that is asked applies then"),
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
    let is_enough = |one: &&TriedDeceleration| {
        let run = &one.run;
        run.error.is_none() && run.against.is_empty() && !run.cut_off && run.contact.is_none()
    };
    let avoids = |one: &&TriedDeceleration| one.run.error.is_none() && one.run.contact.is_none();
    let enough = tried.iter().find(is_enough);
    let would_be_enough = |one: &TriedDeceleration| {
        let but = but_not(tried, one, &is_enough);
        format!("{} would have been enough{but}", number(one.deceleration))
    };
    let first = tried.iter().find(avoids).filter(|one| run.story.contact.is_some() && !is_enough(one));
    let said = match (first, enough) {
        (Some(one), enough) => {
            let avoided = format!(
                "{} would have avoided the contact{}, and still speaks against {}",
                number(one.deceleration),
                but_not(tried, one, &avoids),
                quoted(&one.run.against)
            );
            match enough {
                Some(enough) => format!("{avoided}; {}", would_be_enough(enough)),
                None => format!("{avoided}; none would have been enough for all that is asked"),
            }
        }
        (None, Some(enough)) => would_be_enough(enough),
        (None, None) if run.story.contact.is_some() => {
            "none would have been enough for all that is asked, nor avoided the contact".to_string()
        }
        (None, None) => "none would have been enough for all that is asked".to_string(),
    };
    format!("{said} ({range})")
}

/// `, but not 7 m/s^2` of what is harder than `least` and does not do.
fn but_not(
    tried: &[TriedDeceleration],
    least: &TriedDeceleration,
    does: &impl Fn(&&TriedDeceleration) -> bool,
) -> String {
    let harder = tried.iter().filter(|one| one.deceleration > least.deceleration && !does(one));
    let not: Vec<String> = harder.map(|one| with_unit(one.deceleration, Dimension::ACCELERATION)).collect();
    if not.is_empty() { String::new() } else { format!(", but not {}", not.join(", ")) }
}

fn quoted(criteria: &[String]) -> String {
    if criteria.is_empty() {
        return "nothing, but ended before somebody was met".to_string();
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

/// What a controller was told that was not so, with names.
fn perceived_json(run: &WhyRun, view: &PerceivedView) -> Value {
    let world = &run.case.world;
    let name = |who: usize| road_user(world, who);
    let others = view.others.iter().map(|one| {
        json!({ "who": name(one.who), "place": [one.position.x, one.position.y], "off": one.off, "speed": one.speed })
    });
    json!({ "vehicle": name(view.vehicle), "time": view.time, "age": view.age, "others": others.collect::<Vec<_>>() })
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
        "perceived": misperceived(run, moment(story, &reasons)).iter().map(|view| perceived_json(run, view)).collect::<Vec<_>>(),
        "otherwise": story.otherwise,
        "nearest_passing": nearest,
    })
}
