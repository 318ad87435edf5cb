//! What is said of a recorded run: what became of it in a sentence, when, and how it stands to what is asked of it.

use serde::Serialize;

use crate::format::with_unit;
use crate::replay::{RunReason, introduced, run_reasons};
use results::{Outcome, Recording, Requests, SuiteReport, TrialReport};
use scenario::Dimension;
use sim::Happening;

/// What is said of one run.
#[derive(Debug, Serialize)]
pub struct RunTold {
    /// What became of it, for whom and when.
    pub sentence: String,
    /// When that was, s; `None` for what has no instant.
    pub moment: Option<f64>,
    /// Its standing to each criterion, what it fails first.
    pub why: Vec<Why>,
    /// How fast two bodies met, m/s; `None` if none did.
    pub contact: Option<f64>,
}

/// A line of [`RunTold::why`].
#[derive(Debug, Serialize)]
pub struct Why {
    /// `failed` where the run alone breaks the criterion, `inconclusive` where others may outweigh it, `passed` where it fulfils it.
    pub class: &'static str,
    pub text: String,
    /// s
    pub time: Option<f64>,
}

impl RunTold {
    pub fn new(reports: &[SuiteReport], requests: &Requests, recording: &Recording) -> Self {
        let found = find(reports, &recording.case.key);
        let reasons = found
            .map(|(trial, outcome)| run_reasons(&trial.trial.criteria, outcome, requests))
            .unwrap_or_default();
        let place = found.map_or_else(String::new, |(trial, _)| {
            let values = trial.trial.variation.iter().map(|one| format!(", {} {}", one.name, one.label));
            format!(" In {}{}.", trial.trial.scenario, values.collect::<String>())
        });
        Self::of(reasons, &place, recording)
    }

    /// Of a run that stands so to what is asked of it; `place` is said of where that was.
    pub fn of(reasons: Vec<RunReason>, place: &str, recording: &Recording) -> Self {
        let contact = first_contact(recording);
        let failing = reasons.iter().find(|reason| !reason.fulfils());
        let (sentence, moment) = match (&contact, failing) {
            (Some((time, _, words)), _) => (format!("{words}.{place}"), Some(*time)),
            (None, Some(reason)) => {
                let verb = if reason.fails() { "fails" } else { "is spoken against" };
                (format!("“{}” {verb}: {}.{place}", reason.criterion, reason.words), reason.time)
            }
            (None, None) => (format!("Nothing in this run speaks against what is asked of it.{place}"), None),
        };
        let sentence = if reasons.is_empty() && contact.is_none() {
            format!("Nothing is asked of this run by itself.{place}")
        } else {
            sentence
        };
        Self {
            sentence,
            moment,
            contact: contact.map(|(_, speed, _)| speed),
            why: reasons.into_iter().map(why).collect(),
        }
    }
}

fn why(reason: RunReason) -> Why {
    let class = match (reason.fails(), reason.fulfils()) {
        (true, _) => "failed",
        (_, true) => "passed",
        _ => "inconclusive",
    };
    let RunReason { verb, criterion, words, time, .. } = reason;
    Why { class, text: format!("{verb} “{criterion}”: {words}"), time }
}

/// A run with its trial.
pub fn find<'r>(reports: &'r [SuiteReport], key: &str) -> Option<(&'r TrialReport, &'r Outcome)> {
    let mut trials = reports.iter().flat_map(|report| &report.trials);
    trials.find_map(|trial| Some((trial, trial.outcomes.iter().find(|outcome| outcome.key == key)?)))
}

/// When the first two bodies met, how fast, and that in words.
fn first_contact(recording: &Recording) -> Option<(f64, f64, String)> {
    let world = &recording.case.world;
    recording.events.iter().find_map(|event| {
        let (verb, with, speed) = match &event.what {
            Happening::Collides { with, relative_speed } => ("collide", with, *relative_speed),
            Happening::Touches { with, relative_speed } => ("touch", with, *relative_speed),
            _ => return None,
        };
        // Vehicles are named first, whoever ran into whom.
        let is_vehicle = |name: &str| world.vehicles.iter().any(|car| car.name == name);
        let (one, other) = match is_vehicle(&event.who) || !is_vehicle(with) {
            true => (&event.who, with),
            false => (with, &event.who),
        };
        let words = format!(
            "{} and {} {verb} after {:.2} s, at a relative speed of {}",
            introduced(world, one),
            introduced(world, other),
            event.time,
            with_unit(speed, Dimension::SPEED)
        );
        Some((event.time, speed, words))
    })
}

/// Names between quotation marks, where a terminal has backticks.
pub fn quoted(sentence: &str) -> String {
    let parts = sentence.split('`').enumerate();
    let marked = parts.map(|(index, part)| match index {
        0 => part.to_string(),
        _ if index % 2 == 1 => format!("“{part}"),
        _ => format!("”{part}"),
    });
    marked.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::Session;
    use results::choose_runs;
    use sim::TimelineEvent;

    #[test]
    fn a_contact_is_told_before_anything_else_and_nothing_is_told_to_be_well_that_is_not() {
        let session = Session::new();
        let report = session.report();
        let (_, mut recording) = session.record(choose_runs(&report)).remove(0);
        let reports = [report];
        let told = RunTold::new(&reports, &session.requests, &recording);
        assert!(told.sentence.starts_with("“pet >= 1.5 s” fails: pet "), "{}", told.sentence);
        assert!(told.contact.is_none() && told.moment.is_some() && told.why[0].class == "failed");
        let what = Happening::Collides { with: "av".into(), relative_speed: 8.0 };
        recording.events.push(TimelineEvent { time: 6.5, who: "walker".into(), what });
        let told = RunTold::new(&reports, &session.requests, &recording);
        let begin = "av (carla_behavior) and walker (scripted) collide after 6.50 s, at a relative speed of";
        assert!(told.sentence.starts_with(begin), "{}", told.sentence);
        assert_eq!((told.moment, told.contact), (Some(6.5), Some(8.0)));
        // A run that nothing is known of is not said to be well.
        let told =
            RunTold::new(&[], &session.requests, &session.record(choose_runs(&reports[0])).remove(0).1);
        assert_eq!(told.sentence, "Nothing is asked of this run by itself.");
    }

    #[test]
    fn names_stand_between_quotation_marks() {
        assert_eq!(quoted("usual in `tta` and `speed` together."), "usual in “tta” and “speed” together.");
        assert_eq!(quoted("nothing"), "nothing");
    }
}
