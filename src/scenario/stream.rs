//! Traffic: vehicles of one lane that arrive one after the other.

use serde::{Deserialize, Serialize};

/// The vehicles of a stream in one run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stream {
    /// As the scenario calls it.
    pub name: String,
    /// Indices into [`World::vehicles`](crate::World::vehicles), in the order in which they arrive; at least 1. All drive on one lane.
    pub vehicles: Vec<usize>,
    /// When the centre of each would be at the middle of the crossing if it kept its cruise, s: one for each vehicle, rising.
    pub arrivals: Vec<f64>,
}

impl Stream {
    /// What the member with this index from 0 is called: `cars_1` is the first of `cars`.
    pub fn member_name(name: &str, index: usize) -> String {
        format!("{name}_{}", index + 1)
    }

    /// The name of the stream that a vehicle of this name would be a member of; `None` if no member is called so. A vehicle that a
    /// scenario declares by itself may be called so, too.
    pub fn of_member(member: &str) -> Option<&str> {
        let (stream, number) = member.rsplit_once('_')?;
        let is_number = number.bytes().all(|digit| digit.is_ascii_digit()) && !number.is_empty();
        (is_number && !number.starts_with('0') && !stream.is_empty()).then_some(stream)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_are_known_by_their_names() {
        assert_eq!(Stream::of_member(&Stream::member_name("cars", 0)), Some("cars"));
        assert_eq!(Stream::of_member(&Stream::member_name("near_2", 199)), Some("near_2"));
        for other in ["cars", "cars_", "cars_0", "cars_01", "cars_a", "_1", "cars_1b"] {
            assert_eq!(Stream::of_member(other), None, "{other}");
        }
    }
}
