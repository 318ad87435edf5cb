//! Where road users are, and courses of that as text: a road user a line of its own, which takes a tenth of the room that numbers one by one would.
//!
//! A place is `x y speed heading`, places are divided by `;`, and `-` is somebody who is not there. For
//! `#[serde(with = "…")]`.

use std::fmt::Write;

use nalgebra::Vector2;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serializer};

/// Where a road user is at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// World frame, m.
    pub x: f64,
    /// World frame, m.
    pub y: f64,
    /// m/s
    pub speed: f64,
    /// rad, counter-clockwise from the x axis.
    pub heading: f64,
}

impl Place {
    pub(super) fn at(&self) -> Vector2<f64> {
        Vector2::new(self.x, self.y)
    }
}

const STRING: &str = "writing to a string cannot fail";

pub fn serialize<S: Serializer>(users: &[Vec<Option<Place>>], serializer: S) -> Result<S::Ok, S::Error> {
    let text = |places: &Vec<Option<Place>>| {
        let mut text = String::new();
        for (index, place) in places.iter().enumerate() {
            if index > 0 {
                text.push(';');
            }
            match place {
                Some(Place { x, y, speed, heading }) => {
                    write!(text, "{x} {y} {speed} {heading}").expect(STRING)
                }
                None => text.push('-'),
            }
        }
        text
    };
    serializer.collect_seq(users.iter().map(text))
}

pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Vec<Option<Place>>>, D::Error> {
    let place = |text: &str| match text {
        "-" => Ok(None),
        text => match numbers(text, ' ')?[..] {
            [x, y, speed, heading] => Ok(Some(Place { x, y, speed, heading })),
            _ => Err(format!("`{text}` is no place")),
        },
    };
    let user = |text: String| match text.as_str() {
        "" => Ok(Vec::new()),
        text => text.split(';').map(place).collect(),
    };
    let users = Vec::<String>::deserialize(deserializer)?;
    users.into_iter().map(user).collect::<Result<_, _>>().map_err(D::Error::custom)
}

fn numbers(text: &str, between: char) -> Result<Vec<f64>, String> {
    text.split(between).map(|one| one.parse().map_err(|_| format!("`{one}` is no number"))).collect()
}

/// Times as text, divided by blanks.
pub mod times {
    use super::{Deserialize, Deserializer, Error, Serializer};

    pub fn serialize<S: Serializer>(times: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
        let times: Vec<_> = times.iter().map(ToString::to_string).collect();
        serializer.serialize_str(&times.join(" "))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
        let text = String::deserialize(deserializer)?;
        if text.is_empty() { Ok(Vec::new()) } else { super::numbers(&text, ' ').map_err(D::Error::custom) }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use serde::{Deserialize, Serialize};

    use super::Place;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Course {
        #[serde(with = "super::times")]
        times: Vec<f64>,
        #[serde(with = "super")]
        users: Vec<Vec<Option<Place>>>,
    }

    fn number() -> impl Strategy<Value = f64> {
        any::<f64>().prop_filter("a number", |number| number.is_finite())
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back(
            times in prop::collection::vec(number(), 0..5),
            users in prop::collection::vec(
                prop::collection::vec(prop::option::of((number(), number(), number(), number())), 0..5), 0..4)
        ) {
            let place = |(x, y, speed, heading)| Place { x, y, speed, heading };
            let users = users.into_iter().map(|user| user.into_iter().map(|one| one.map(place)).collect()).collect();
            let course = Course { times, users };
            let text = serde_json::to_string(&course).unwrap();
            prop_assert_eq!(serde_json::from_str::<Course>(&text).unwrap(), course);
        }
    }

    #[test]
    fn what_is_no_place_is_refused() {
        for users in ["1 2 3", "1 2 3 x", ";"] {
            let text = format!(r#"{{"times":"0 0.1","users":["{users}"]}}"#);
            assert!(serde_json::from_str::<Course>(&text).is_err(), "{users}");
        }
    }
}
