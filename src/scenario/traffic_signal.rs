//! The signal of a crossing: one cycle from which what people have and what vehicles have both follow.

use serde::{Deserialize, Serialize};

use super::{Dimension, Expression, Origin, show};

/// How far before the edge of a crossing vehicles stop where nothing is said, m.
pub const STOP_LINE: f64 = 1.2;

/// A signal of two phases. In every cycle people have green from [`Self::pedestrian_green_from`] for [`Self::pedestrian_green`] seconds.
/// Vehicles have red while people have green and for [`Self::clearance`] seconds after it, amber in the last [`Self::amber`] seconds
/// before that red, and green in the rest. Where people never have green, vehicles always have.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TrafficSignal {
    /// s
    pub cycle: f64,
    /// Within a cycle, s; cycles begin at time 0.
    pub pedestrian_green_from: f64,
    /// s
    pub pedestrian_green: f64,
    /// s
    #[serde(default, skip_serializing_if = "is_zero")]
    pub amber: f64,
    /// s
    #[serde(default, skip_serializing_if = "is_zero")]
    pub clearance: f64,
    /// From the edge of the crossing back to the line before which vehicles stop, m.
    #[serde(default = "usual_line", skip_serializing_if = "is_usual_line")]
    pub stop_line: f64,
}

fn is_zero(duration: &f64) -> bool {
    *duration == 0.0
}

fn usual_line() -> f64 {
    STOP_LINE
}

fn is_usual_line(distance: &f64) -> bool {
    *distance == STOP_LINE
}

/// What a signal shows to vehicles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SignalState {
    /// They stop.
    Red,
    /// Red is next: they stop if they can.
    Amber,
    /// They go.
    Green,
}

/// The signal of a crossing as a controller knows it. How long it will show that nobody is told.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SeenSignal {
    /// What it shows to vehicles.
    pub state: SignalState,
    /// From the near edge of the crossing back to the line before which vehicles stop, m.
    pub stop_line: f64,
}

/// What is wrong with a signal: a message and a cure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SignalError {
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub hint: String,
}

impl TrafficSignal {
    /// A signal without amber and clearance; all in s.
    pub fn new(cycle: f64, pedestrian_green_from: f64, pedestrian_green: f64) -> Self {
        Self {
            cycle,
            pedestrian_green_from,
            pedestrian_green,
            amber: 0.0,
            clearance: 0.0,
            stop_line: STOP_LINE,
        }
    }

    /// How long it is at `time` (s) since people got green last, s.
    fn since_green(&self, time: f64) -> f64 {
        (time - self.pedestrian_green_from).rem_euclid(self.cycle)
    }

    /// Whether people have green at `time` (s).
    pub fn people_have_green(&self, time: f64) -> bool {
        self.since_green(time) < self.pedestrian_green
    }

    /// What vehicles have at `time` (s).
    pub fn state(&self, time: f64) -> SignalState {
        let since = self.since_green(time);
        if self.pedestrian_green <= 0.0 {
            SignalState::Green
        } else if since < self.pedestrian_green + self.clearance {
            SignalState::Red
        } else if self.amber > 0.0 && since >= self.cycle - self.amber {
            SignalState::Amber
        } else {
            SignalState::Green
        }
    }

    /// How long after `time` (s) vehicles next have green, s; 0 while they have it.
    pub fn until_green(&self, time: f64) -> f64 {
        let red = self.pedestrian_green + self.clearance;
        match self.state(time) {
            SignalState::Green => 0.0,
            SignalState::Red => red - self.since_green(time),
            SignalState::Amber => self.cycle - self.since_green(time) + red,
        }
    }

    /// What drivers see of it at `time` (s).
    pub fn seen(&self, time: f64) -> SeenSignal {
        SeenSignal { state: self.state(time), stop_line: self.stop_line }
    }

    /// Whether its times fit into each other.
    ///
    /// # Errors
    /// Phases that are longer than the cycle.
    pub fn check(&self) -> Result<(), SignalError> {
        let seconds = |time: f64| show(time, None, Dimension::TIME);
        let error = |message: String, hint: String| Err(SignalError { message, hint });
        for (name, found) in [
            ("pedestrian_green", self.pedestrian_green),
            ("pedestrian_green_from", self.pedestrian_green_from),
        ] {
            if found > self.cycle {
                return error(
                    format!(
                        "`{name}` of the signal is {}, its cycle only {}",
                        seconds(found),
                        seconds(self.cycle)
                    ),
                    format!("let `{name}` be at most {}, or `cycle` longer", seconds(self.cycle)),
                );
            }
        }
        let together = self.pedestrian_green + self.clearance + self.amber;
        // Sums of what was written in decimals may be off by their rounding.
        if together > self.cycle + 1e-9 {
            return error(
                format!(
                    "the signal's pedestrian_green of {}, clearance of {} and amber of {} are longer together than its cycle of {}",
                    seconds(self.pedestrian_green),
                    seconds(self.clearance),
                    seconds(self.amber),
                    seconds(self.cycle)
                ),
                format!("let `cycle` be longer than {}, so that vehicles get green", seconds(together)),
            );
        }
        Ok(())
    }
}

/// What of a signal depends on variations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeclaredSignal {
    /// By the names of [`TrafficSignal`]'s fields, each once; what is not there is as the road says.
    pub varied: Vec<(String, Expression)>,
    /// Where the first of them is said.
    pub origin: Origin,
}

impl TrafficSignal {
    /// The number of that name.
    pub fn number_mut(&mut self, name: &str) -> Option<&mut f64> {
        Some(match name {
            "cycle" => &mut self.cycle,
            "pedestrian_green" => &mut self.pedestrian_green,
            "pedestrian_green_from" => &mut self.pedestrian_green_from,
            "amber" => &mut self.amber,
            "clearance" => &mut self.clearance,
            "stop_line" => &mut self.stop_line,
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn signal(amber: f64, clearance: f64) -> TrafficSignal {
        TrafficSignal { amber, clearance, ..TrafficSignal::new(60.0, 40.0, 10.0) }
    }

    #[test]
    fn vehicles_have_red_with_peoples_green_and_after_it_and_amber_before_it() {
        use SignalState::{Amber, Green, Red};
        let states = |signal: TrafficSignal| {
            [36.9, 37.0, 39.9, 40.0, 49.9, 50.0, 53.9, 54.0, 96.9, 97.0].map(|time| signal.state(time))
        };
        let full = [Green, Amber, Amber, Red, Red, Red, Red, Green, Green, Amber];
        assert_eq!(states(signal(3.0, 4.0)), full);
        let plain = [Green, Green, Green, Red, Red, Green, Green, Green, Green, Green];
        assert_eq!(states(signal(0.0, 0.0)), plain);
        let waits = [36.0, 37.0, 39.5, 40.0, 53.0, 54.0].map(|time| signal(3.0, 4.0).until_green(time));
        assert_eq!(waits, [0.0, 17.0, 14.5, 14.0, 1.0, 0.0]);
    }

    #[test]
    fn a_green_of_no_length_is_no_red() {
        let none = TrafficSignal { pedestrian_green: 0.0, ..signal(3.0, 4.0) };
        assert!((0..1200).all(|tenth| none.state(f64::from(tenth) / 10.0) == SignalState::Green));
    }

    #[test]
    fn phases_that_do_not_fit_are_refused() {
        assert_eq!(signal(3.0, 4.0).check(), Ok(()));
        assert_eq!(TrafficSignal { cycle: 40.0, ..signal(26.0, 4.0) }.check(), Ok(()));
        let error = TrafficSignal { cycle: 40.0, ..signal(26.5, 4.0) }.check().unwrap_err();
        assert!(error.message.contains("26.5 s") && error.hint.contains("40.5 s"), "{error:?}");
        assert!(TrafficSignal { pedestrian_green_from: 61.0, ..signal(0.0, 0.0) }.check().is_err());
    }

    proptest! {
        #[test]
        fn nobody_drives_into_peoples_green(
            cycle in 1.0..100.0, from in 0.0..1.0, green in 0.0..1.0, amber in 0.0..1.0, clearance in 0.0..1.0, time in -50.0..500.0,
        ) {
            let (green, from) = (green * cycle, from * cycle);
            let left = cycle - green;
            let (clearance, amber) = (clearance * left, amber * (left - clearance * left));
            let signal = TrafficSignal { amber, clearance, ..TrafficSignal::new(cycle, from, green) };
            prop_assert_eq!(signal.check(), Ok(()));
            if signal.people_have_green(time) {
                prop_assert_eq!(signal.state(time), SignalState::Red);
            }
            let plain = TrafficSignal { amber: 0.0, clearance: 0.0, ..signal };
            prop_assert_eq!(plain.state(time) == SignalState::Green, !plain.people_have_green(time));
        }
    }
}
