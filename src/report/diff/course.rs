//! What two runs do over time, whom they touch and how they end.

use super::sides::RunDiff;
use crate::format::with_unit;
use crate::why::cut_off;
use crate::wording::ending_words;
use results::{ContactMoment, Doing, OneOfTwo, Outcome, SharedMoment, TwoRuns};
use scenario::Dimension;

/// Moments that are nearer than this are the same, s.
const SAME: f64 = 1e-9;

/// Whom the table is about: those of the earliest contact, else whoever parts, with the first pedestrian.
fn about(run: &RunDiff) -> Vec<String> {
    let world = &run.sides[0].case.world;
    let contacts = run.two.a.contacts.iter().chain(&run.two.b.contacts);
    let earliest = contacts.min_by(|one, other| {
        one.time
            .total_cmp(&other.time)
            .then_with(|| (&one.vehicle, &one.with).cmp(&(&other.vehicle, &other.with)))
    });
    let is_there =
        |name: &String| run.two.moments.iter().any(|one| one.each.iter().any(|one| one.who == *name));
    if let Some(contact) = earliest {
        return [contact.vehicle.clone(), contact.with.clone()].into_iter().filter(is_there).collect();
    }
    let parts = run.two.apart.iter().chain(&run.two.first).flat_map(|parting| &parting.by);
    let parts: Vec<&String> = parts.map(|one| &one.who).collect();
    let cars = || world.vehicles.iter().map(|car| &car.name);
    let people = || world.pedestrians.iter().map(|person| &person.name);
    let car = cars().find(|name| parts.contains(name)).or_else(|| cars().next());
    let person = people().find(|name| parts.contains(name)).or_else(|| people().next());
    car.into_iter().chain(person).cloned().collect()
}

/// What they do over time: the headings, then a row for each moment, whose last column says what happens then.
pub fn course(run: &RunDiff) -> (Vec<String>, Vec<Vec<String>>) {
    let who = about(run);
    let mut headings = vec!["time".to_string()];
    for name in &who {
        headings.extend([format!("{name} A"), format!("{name} B")]);
    }
    if who.len() == 2 {
        headings.extend(["apart A".to_string(), "apart B".to_string()]);
    }
    headings.push(String::new());
    let row = |moment: &SharedMoment| {
        let SharedMoment { time, each } = moment;
        let of = |name: &String| each.iter().find(|one| one.who == *name);
        let mut row = vec![format!("{time:.2} s")];
        for name in &who {
            row.extend(
                [of(name).and_then(|one| one.a.as_ref()), of(name).and_then(|one| one.b.as_ref())].map(cell),
            );
        }
        if let [one, other] = &who[..] {
            let both = [of(one), of(other)];
            let apart = |side: fn(&results::InBoth) -> Option<&Doing>| {
                let [one, other] = both.map(|one| one.and_then(side));
                match (one, other) {
                    (Some(one), Some(other)) => {
                        let (dx, dy) = (one.x - other.x, one.y - other.y);
                        format!("{:.1} m", (dx * dx + dy * dy).sqrt())
                    }
                    _ => "–".to_string(),
                }
            };
            row.extend([apart(|one| one.a.as_ref()), apart(|one| one.b.as_ref())]);
        }
        row.push(happens(run.two, *time));
        row
    };
    (headings, run.two.moments.iter().map(row).collect())
}

/// What a row of the table is there for, besides the course.
fn happens(two: &TwoRuns, time: f64) -> String {
    let is_now = |other: f64| (other - time).abs() < SAME;
    let mut said = Vec::new();
    if two.apart.as_ref().or(two.first.as_ref()).is_some_and(|parting| is_now(parting.time)) {
        said.push("they part".to_string());
    }
    let contact = |letter: &str, one: &OneOfTwo| {
        let contact = one.contacts.first().filter(|contact| is_now(contact.time))?;
        let ends = if is_now(one.outcome.ending.time) { ", and the run ends" } else { "" };
        Some(format!("contact in {letter}: {} with {}{ends}", contact.vehicle, contact.with))
    };
    said.extend([("A", &two.a), ("B", &two.b)].into_iter().filter_map(|(letter, one)| contact(letter, one)));
    said.join("; ")
}

/// The table in columns of equal width.
pub fn table(run: &RunDiff) -> Vec<String> {
    let (headings, moments) = course(run);
    let rows: Vec<Vec<String>> = [headings].into_iter().chain(moments).collect();
    let columns = rows[0].len();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let padded = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}"));
        cells.collect::<Vec<_>>().join("  ")
    };
    rows.iter().map(padded).collect()
}

/// `8.33 m/s follow`; `–` where somebody is not there or the run is over.
fn cell(doing: Option<&Doing>) -> String {
    let Some(Doing { speed, activity, .. }) = doing else { return "–".to_string() };
    format!("{speed:.2} m/s {activity}").trim_end().to_string()
}

/// `av with walker at 2.31 s, 8.33 m/s`.
pub fn contact_words(contact: &ContactMoment) -> String {
    let ContactMoment { time, vehicle, with, relative_speed, .. } = contact;
    format!("{vehicle} with {with} at {time:.2} s, {}", with_unit(*relative_speed, Dimension::SPEED))
}

/// Every contact of a vehicle, of the one and of the other.
pub fn contacts(two: &TwoRuns) -> String {
    let of = |one: &OneOfTwo| {
        let each: Vec<String> = one.contacts.iter().map(contact_words).collect();
        if each.is_empty() { "none".to_string() } else { each.join(", ") }
    };
    match (two.a.contacts.is_empty(), two.b.contacts.is_empty()) {
        (true, true) => "no contact of a vehicle in either".to_string(),
        _ => format!("contacts: in A {}; in B {}", of(&two.a), of(&two.b)),
    }
}

pub fn endings([a, b]: [&Outcome; 2]) -> String {
    let of = |outcome: &Outcome| {
        let words = ending_words(outcome.ending.reason);
        format!("at {:.2} s, {words}{}", outcome.ending.time, cut_off(outcome))
    };
    match of(a) == of(b) {
        true => format!("both end {}", of(a)),
        false => format!("A ends {}; B ends {}", of(a), of(b)),
    }
}
