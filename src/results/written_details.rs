//! What is drawn of a run besides where everybody is, as it is written down: what has a value for each time as one line of text, as courses are.
//!
//! Values of a time to collision are divided by blanks, and `-` is none. Of a person's state they are as well, after the vehicle's place in the
//! world or `-`; moments are divided by `;`, and one at which nothing is weighed is empty. What a controller was told that was not so is a line a
//! decision: the vehicle's place in the world, time and age or `-`, and for each of the others who it is, x, y, how far off, and the speed.

use std::fmt::Display;

use serde::{Deserialize, Serialize};

use nalgebra::Vector2;
use sim::measure::{PairDetails, PassingTimes, PersonDetails, StepReadings, VisitTimes};
use sim::{ModelState, PerceivedOther, PerceivedView, StateQuantity};

#[derive(Serialize, Deserialize)]
struct WrittenPair {
    vehicle: usize,
    pedestrian: usize,
    time_to_collision: String,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    straight_on: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    contact: Option<f64>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    passings: Vec<PassingTimes>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    visits: Vec<VisitTimes>,
}

#[derive(Default, Serialize, Deserialize)]
struct WrittenPerson {
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    quantities: Vec<StateQuantity>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    states: Option<String>,
}

#[derive(Serialize, Deserialize)]
struct WrittenReadings {
    metric: usize,
    is_smallest: bool,
    worst: String,
}

fn joined(values: impl IntoIterator<Item = impl Display>, between: &str) -> String {
    let values: Vec<String> = values.into_iter().map(|value| value.to_string()).collect();
    values.join(between)
}

fn maybe(value: Option<impl Display>) -> String {
    value.map_or_else(|| "-".into(), |value| value.to_string())
}

fn number<T: std::str::FromStr>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| format!("`{text}` is no number"))
}

fn optional<T: std::str::FromStr>(text: &str) -> Result<Option<T>, String> {
    if text == "-" { Ok(None) } else { number(text).map(Some) }
}

fn values(text: &str) -> Result<Vec<Option<f64>>, String> {
    if text.is_empty() { Ok(Vec::new()) } else { text.split(' ').map(optional).collect() }
}

fn state(text: &str) -> Result<Option<ModelState>, String> {
    if text.is_empty() {
        return Ok(None);
    }
    let mut parts = text.split(' ');
    let about = optional(parts.next().unwrap_or_default())?;
    Ok(Some(ModelState { about, values: parts.map(number).collect::<Result<_, _>>()? }))
}

fn other(other: &PerceivedOther) -> String {
    let PerceivedOther { who, position, off, speed } = other;
    format!("{who} {} {} {off} {speed}", position.x, position.y)
}

fn view(text: &str) -> Result<PerceivedView, String> {
    let words: Vec<&str> = text.split(' ').collect();
    let ([vehicle, time, age], others) =
        words.split_first_chunk().ok_or_else(|| format!("`{text}` is nothing that is perceived"))?;
    let other = |words: &[&str]| {
        let &[who, x, y, off, speed] = words else { return Err(format!("`{text}` ends within somebody")) };
        let position = Vector2::new(number(x)?, number(y)?);
        Ok(PerceivedOther { who: number(who)?, position, off: number(off)?, speed: number(speed)? })
    };
    Ok(PerceivedView {
        vehicle: number(vehicle)?,
        time: number(time)?,
        age: optional(age)?,
        others: others.chunks(5).map(other).collect::<Result<_, _>>()?,
    })
}

/// Pairs, for `#[serde(with = "…")]`.
pub mod pairs {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    use super::{PairDetails, WrittenPair, joined, maybe, values};

    pub fn serialize<S: Serializer>(pairs: &[PairDetails], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(pairs.iter().map(|pair| WrittenPair {
            vehicle: pair.vehicle,
            pedestrian: pair.pedestrian,
            time_to_collision: joined(pair.time_to_collision.iter().map(|one| maybe(*one)), " "),
            straight_on: joined(pair.straight_on.iter().map(|one| maybe(*one)), " "),
            contact: pair.contact,
            passings: pair.passings.clone(),
            visits: pair.visits.clone(),
        }))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<PairDetails>, D::Error> {
        let pair = |pair: WrittenPair| {
            Ok(PairDetails {
                vehicle: pair.vehicle,
                pedestrian: pair.pedestrian,
                time_to_collision: values(&pair.time_to_collision)?,
                straight_on: values(&pair.straight_on)?,
                contact: pair.contact,
                passings: pair.passings,
                visits: pair.visits,
            })
        };
        let written = Vec::<WrittenPair>::deserialize(deserializer)?;
        written.into_iter().map(pair).collect::<Result<_, String>>().map_err(D::Error::custom)
    }
}

/// What people make of a run, for `#[serde(with = "…")]`.
pub mod people {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    use super::{ModelState, PersonDetails, WrittenPerson, joined, maybe, state};

    pub fn serialize<S: Serializer>(people: &[PersonDetails], serializer: S) -> Result<S::Ok, S::Error> {
        let state = |state: &Option<ModelState>| {
            let Some(state) = state else { return String::new() };
            let values = state.values.iter().map(f64::to_string);
            joined([maybe(state.about)].into_iter().chain(values), " ")
        };
        serializer.collect_seq(people.iter().map(|person| WrittenPerson {
            quantities: person.quantities.clone(),
            states: (!person.states.is_empty()).then(|| joined(person.states.iter().map(state), ";")),
        }))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<PersonDetails>, D::Error> {
        let person = |person: WrittenPerson| {
            let states = person.states.as_deref().map_or_else(
                || Ok(Vec::new()),
                |text| text.split(';').map(state).collect::<Result<_, String>>(),
            )?;
            Ok(PersonDetails { quantities: person.quantities, states })
        };
        let written = Vec::<WrittenPerson>::deserialize(deserializer)?;
        written.into_iter().map(person).collect::<Result<_, String>>().map_err(D::Error::custom)
    }
}

/// What controllers were told that was not so, for `#[serde(with = "…")]`.
pub mod perceived {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    use super::{PerceivedView, joined, maybe, other, view};

    pub fn serialize<S: Serializer>(views: &[PerceivedView], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(views.iter().map(|view| {
            let first = [view.vehicle.to_string(), view.time.to_string(), maybe(view.age)];
            joined(first.into_iter().chain(view.others.iter().map(other)), " ")
        }))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<PerceivedView>, D::Error> {
        let written = Vec::<String>::deserialize(deserializer)?;
        written.iter().map(|text| view(text)).collect::<Result<_, String>>().map_err(D::Error::custom)
    }
}

/// What metrics are the worst of, for `#[serde(with = "…")]`.
pub mod readings {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    use super::{StepReadings, WrittenReadings, joined, maybe, values};

    pub fn serialize<S: Serializer>(readings: &[StepReadings], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(readings.iter().map(|one| WrittenReadings {
            metric: one.metric,
            is_smallest: one.is_smallest,
            worst: joined(one.worst.iter().map(|one| maybe(*one)), " "),
        }))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<StepReadings>, D::Error> {
        let readings = |written: WrittenReadings| {
            let WrittenReadings { metric, is_smallest, worst } = written;
            Ok(StepReadings { metric, is_smallest, worst: values(&worst)? })
        };
        let written = Vec::<WrittenReadings>::deserialize(deserializer)?;
        written.into_iter().map(readings).collect::<Result<_, String>>().map_err(D::Error::custom)
    }
}
