//! What a candidate has to do to be retained: the published criteria, and users' own (§9.1).

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::pedestrian::commotions::meeting::{Meeting, MetDriver, PEDESTRIAN, VEHICLE, Waiting};
use crate::pedestrian::commotions::{Parameters, State};
use files::{self, ReadError};

/// One criterion: who meets whom, and what has to come of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RetentionCriterion {
    /// What it is called in reports.
    pub name: String,
    /// How far the pedestrian is from the conflict space at the start, in seconds at its free speed, which it walks.
    pub pedestrian_time: f64,
    /// How far the vehicle is from the conflict space at the start, in seconds at its speed.
    pub vehicle_time: f64,
    /// Who drives.
    pub driver: Drives,
    /// Whether the pedestrian has priority.
    #[serde(default)]
    pub pedestrian_priority: bool,
    /// What has to happen.
    pub demand: Demand,
    /// In at least how many of the repetitions; all if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub in_at_least: Option<u32>,
}

/// Who drives the vehicle, which starts at its free speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Drives {
    /// A COMMOTIONS agent with the candidate's parameters.
    Commotions,
    /// Nobody: the speed is constant.
    ConstantSpeed,
}

/// What has to happen in a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Demand {
    /// The two are never in the conflict space together.
    NoCollision,
    /// The pedestrian's mean speed up to the conflict space is below this share of its free speed.
    MeanSpeedBelow(f64),
    /// The pedestrian reaches the conflict space within this time (s).
    ReachesWithin(f64),
}

/// Duration of a run (s), and its time step (s).
pub const DURATION: f64 = 12.0;
const TIME_STEP: f64 = 0.025;

/// The five criteria of the published fits (§9.1).
pub fn published_criteria() -> Vec<RetentionCriterion> {
    let collision = |name: &str, vehicle_time, pedestrian_priority| RetentionCriterion {
        name: name.to_owned(),
        pedestrian_time: 3.0,
        vehicle_time,
        driver: Drives::Commotions,
        pedestrian_priority,
        demand: Demand::NoCollision,
        in_at_least: None,
    };
    let hesitation = |name: &str, demand, in_at_least| RetentionCriterion {
        name: name.to_owned(),
        pedestrian_time: 3.0,
        vehicle_time: 8.0,
        driver: Drives::ConstantSpeed,
        pedestrian_priority: false,
        demand,
        in_at_least,
    };
    vec![
        collision("no collision on equal terms", 3.0, false),
        collision("no collision with pedestrian priority", 3.0, true),
        collision("no collision with a far vehicle", 8.0, false),
        hesitation("hesitates before a far vehicle", Demand::MeanSpeedBelow(0.95), Some(4)),
        hesitation("crosses in time", Demand::ReachesWithin(DURATION), None),
    ]
}

/// Why criteria cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CriteriaError {
    /// The file cannot be read.
    #[error("cannot read the criteria {}: {error}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        error: ReadError,
    },
    /// The file is not of the format.
    #[error("{}: {error}", file.display())]
    Format {
        /// The file.
        file: PathBuf,
        /// Line, column and what was expected.
        error: serde_json::Error,
    },
    /// There are none.
    #[error("{}: no criteria; every candidate would be retained", file.display())]
    None {
        /// The file.
        file: PathBuf,
    },
    /// A number makes no sense.
    #[error("{}: criterion `{name}`: `{field}` is {found}, outside {low} .. {high}", file.display())]
    OutOfRange {
        /// The file.
        file: PathBuf,
        /// The criterion.
        name: String,
        /// The field.
        field: &'static str,
        /// Its value.
        found: f64,
        /// Least allowed.
        low: f64,
        /// Most allowed.
        high: f64,
    },
}

/// Reads criteria from a JSON file: a list of [`RetentionCriterion`].
///
/// # Errors
/// If the file cannot be read, is not of the format, or asks for what cannot be.
pub fn read_criteria(file: &Path) -> Result<Vec<RetentionCriterion>, CriteriaError> {
    let text =
        files::read_text(file).map_err(|error| CriteriaError::Read { file: file.to_owned(), error })?;
    let criteria: Vec<RetentionCriterion> = serde_json::from_str(&text)
        .map_err(|error| CriteriaError::Format { file: file.to_owned(), error })?;
    if criteria.is_empty() {
        return Err(CriteriaError::None { file: file.to_owned() });
    }
    for criterion in &criteria {
        let (field, found, low, high) = match criterion.demand {
            Demand::MeanSpeedBelow(share) => ("mean_speed_below", share, 0.0, 10.0),
            Demand::ReachesWithin(time) => ("reaches_within", time, 0.0, DURATION),
            Demand::NoCollision => ("pedestrian_time", criterion.pedestrian_time, 0.0, 60.0),
        };
        for (field, found, low, high) in [
            (field, found, low, high),
            ("pedestrian_time", criterion.pedestrian_time, 0.0, 60.0),
            ("vehicle_time", criterion.vehicle_time, 0.0, 60.0),
        ] {
            if !(low..=high).contains(&found) {
                let (file, name) = (file.to_owned(), criterion.name.clone());
                return Err(CriteriaError::OutOfRange { file, name, field, found, low, high });
            }
        }
    }
    Ok(criteria)
}

impl RetentionCriterion {
    /// The meeting for a candidate.
    pub fn meeting(&self, candidate: &Parameters) -> Meeting {
        let (walks, drives) = (candidate.pedestrian_free_speed, candidate.vehicle_free_speed);
        Meeting {
            pedestrian: (PEDESTRIAN.half_extent + self.pedestrian_time * walks, walks),
            vehicle: (VEHICLE.half_extent + self.vehicle_time * drives, drives),
            driver: match self.driver {
                Drives::Commotions => MetDriver::Commotions,
                Drives::ConstantSpeed => MetDriver::Timetable(Vec::new()),
            },
            pedestrian_priority: self.pedestrian_priority,
            waiting: Waiting::Inhibited(0.0),
            dt: TIME_STEP,
            end_time: DURATION,
        }
    }

    /// Whether two criteria are about the same meeting, and so about the same runs.
    pub fn shares_runs_with(&self, other: &Self) -> bool {
        (self.pedestrian_time, self.vehicle_time, self.driver, self.pedestrian_priority)
            == (other.pedestrian_time, other.vehicle_time, other.driver, other.pedestrian_priority)
    }
}

/// What a run of a meeting showed of the pedestrian.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Showing {
    start: f64,
    /// Time and distance when the pedestrian entered the conflict space, or when last seen before it.
    last: (f64, f64),
    entered: bool,
    collided: bool,
}

impl Showing {
    /// Takes in one step.
    pub fn see(&mut self, time: f64, pedestrian: &State, collides: bool) {
        if time == 0.0 {
            self.start = pedestrian.distance;
        }
        self.collided |= collides;
        if !self.entered {
            self.last = (time, pedestrian.distance);
            self.entered = pedestrian.distance < PEDESTRIAN.half_extent;
        }
    }

    /// Whether the run showed what is demanded of someone whose free speed (m/s) is `free_speed`.
    pub fn meets(&self, demand: Demand, free_speed: f64) -> bool {
        let (time, distance) = self.last;
        match demand {
            Demand::NoCollision => !self.collided,
            Demand::MeanSpeedBelow(share) => (self.start - distance) / time < share * free_speed,
            Demand::ReachesWithin(within) => self.entered && time <= within,
        }
    }
}

/// Which criterion, if any, a candidate failed first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RetentionVerdict {
    /// It met all of them.
    Retained,
    /// The first criterion it failed, counted from 0.
    Failed(usize),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(distance: f64) -> State {
        State { distance, ..State::default() }
    }

    #[test]
    fn demands_are_about_the_way_up_to_the_conflict_space() {
        let mut showing = Showing::default();
        showing.see(0.0, &at(5.2), false);
        showing.see(4.0, &at(1.2), false);
        showing.see(9.0, &at(-3.0), true);
        // 4 m in 4 s.
        assert!(showing.meets(Demand::MeanSpeedBelow(0.8), 1.3));
        assert!(!showing.meets(Demand::MeanSpeedBelow(0.75), 1.3));
        assert!(
            showing.meets(Demand::ReachesWithin(4.0), 1.3) && !showing.meets(Demand::ReachesWithin(3.9), 1.3)
        );
        assert!(!showing.meets(Demand::NoCollision, 1.3));
    }

    #[test]
    fn criteria_survive_the_round_trip_and_bad_ones_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("criteria.json");
        let published = published_criteria();
        std::fs::write(&file, serde_json::to_string_pretty(&published).unwrap()).unwrap();
        assert_eq!(read_criteria(&file).unwrap(), published);
        let mut late = published.clone();
        late[4].demand = Demand::ReachesWithin(13.0);
        for (text, expected) in [
            (
                serde_json::to_string(&late).unwrap(),
                "`crosses in time`: `reaches_within` is 13, outside 0 .. 12",
            ),
            ("[]".to_owned(), "no criteria"),
            ("[{\"name\": 3}]".to_owned(), "line 1 column 11"),
        ] {
            std::fs::write(&file, text).unwrap();
            let error = read_criteria(&file).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
