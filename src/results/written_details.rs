//! What is drawn of a run besides where everybody is, as it is written down: what has a value for each time as one line of text, as courses are.
//!
//! Values of a time to collision are divided by blanks, and `-` is none. Of a person's state they are as well, after the vehicle's place in the
//! world or `-`; moments are divided by `;`, and one at which nothing is weighed is empty.

use std::fmt::Display;

use serde::{Deserialize, Serialize};

use sim::measure::{PairDetails, PassingTimes, PersonDetails, VisitTimes};
use sim::{ModelState, StateQuantity};

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
