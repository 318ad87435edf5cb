//! A vehicle that drives by a scripted timeline.

use super::hazard::{half_size, keep_speed};
use super::period::period;
use super::red_light::LOOKS_AT_NOTHING;
use super::{CommandKind, ControllerContext, ControllerModel};
use scenario::agent::ScriptStep;
use scenario::{Attention, Chance, Declaration, Dimension, Parameter, TextError};
use sim::script::{Action, Script, ScriptQuantity, parameters};
use sim::{Command, Controller, ControllerError, Mode, ModelError, Observation, Schedule};

pub fn timeline() -> ControllerModel {
    let declaration = Declaration::new(
        "timeline",
        "Drives by scripted steps; `when` compares distance, distance_to_crossing, time_to_arrival or speed.",
    )
    .source("conditions and actions after ASAM OpenSCENARIO")
    .parameters(parameters(check))
    .parameters([
        Parameter::number(
            "acceleration",
            Dimension::ACCELERATION,
            1.5,
            (0.1, 20.0),
            "Acceleration of `speed` and `resume`.",
            "free choice",
        ),
        Parameter::number(
            "deceleration",
            Dimension::ACCELERATION,
            3.0,
            (0.1, 20.0),
            "Deceleration of `speed` and `stop`.",
            "free choice",
        ),
        period(),
    ]);
    ControllerModel::new(declaration, CommandKind::Acceleration, build)
        .driving("ideal")
        .chance(Chance::Never)
        .signals(LOOKS_AT_NOTHING)
        .attention(Attention::Scripted)
}

/// `distance`: from the front bumper along the road to the near edge of the nearest pedestrian ahead.
/// `distance_to_crossing`: of the front. `time_to_arrival`: of the centre at the middle of the crossing. Of several crossings it is the
/// first of the road.
const QUANTITIES: &[ScriptQuantity] = &[
    ("distance", Dimension::LENGTH),
    ("distance_to_crossing", Dimension::LENGTH),
    ("time_to_arrival", Dimension::TIME),
    ("speed", Dimension::SPEED),
];

fn check(steps: &str, given: &dyn Fn(&str) -> bool) -> Vec<TextError> {
    Script::check(steps, "timeline", QUANTITIES, given)
}

struct ByTimeline {
    period: f64,
    script: Script,
    acceleration: f64,
    deceleration: f64,
    action: Action,
}

fn build(context: &ControllerContext) -> Result<Box<dyn Controller>, ModelError> {
    let settings = context.settings;
    Ok(Box::new(ByTimeline {
        period: settings.number("period"),
        script: Script::from_settings(settings, "timeline", QUANTITIES)?,
        acceleration: settings.number("acceleration"),
        deceleration: settings.number("deceleration"),
        action: Action::Resume,
    }))
}

fn quantity(observation: &Observation, index: usize) -> f64 {
    let ego = &observation.ego;
    match QUANTITIES[index].0 {
        "distance" => observation
            .pedestrians
            .iter()
            .map(|seen| seen.position.x - ego.length / 2.0 - half_size(seen.shape))
            .filter(|distance| *distance >= 0.0)
            .fold(f64::INFINITY, f64::min),
        "distance_to_crossing" => -ego.travelled - ego.length / 2.0,
        "time_to_arrival" if ego.speed > 0.0 => -ego.travelled / ego.speed,
        "time_to_arrival" => f64::INFINITY.copysign(-ego.travelled),
        _ => ego.speed,
    }
}

impl Controller for ByTimeline {
    fn schedule(&self) -> Schedule {
        Schedule::every(self.period)
    }

    fn act(&mut self, observation: &Observation) -> Result<Command, ControllerError> {
        if let Some(action) = self.script.due(observation.time, |index| quantity(observation, index)) {
            self.action = action;
        }
        let speed = observation.ego.speed;
        let toward = |wanted| keep_speed(speed, wanted, self.acceleration, self.deceleration);
        Ok(Command::Acceleration(match self.action {
            Action::Speed(wanted) => toward(wanted),
            Action::Accelerate(acceleration) => acceleration,
            Action::Stop => -self.deceleration,
            Action::Resume => toward(observation.cruise_speed),
        }))
    }

    fn waiting_steps(&self) -> Vec<ScriptStep> {
        self.script.waiting_steps()
    }

    fn mode(&self) -> Mode {
        Mode::new(match self.action {
            Action::Speed(_) => "speed",
            Action::Accelerate(_) => "accelerate",
            Action::Stop => "stop",
            Action::Resume => "cruise",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::test_track::{CRUISE, Track};
    use scenario::{Settings, Value};

    fn track(steps: &str, numbers: &[(&str, f64)]) -> Track {
        let mut settings = Settings::from([("steps", Value::Word(steps.into()))]);
        for (name, value) in numbers {
            settings.set(*name, Value::Number(*value));
        }
        Track::new(&timeline(), settings, "ideal")
    }

    #[test]
    fn slows_stops_for_somebody_and_goes_on() {
        let steps = "at t1 speed v1; when distance < d1 stop; after t2 resume";
        let numbers = [("t1", 2.0), ("v1", 20.0 / 3.6), ("d1", 15.0), ("t2", 6.0)];
        let mut track = track(steps, &numbers);
        track.place_pedestrian(100.0, -3.0);
        let samples = track.drive(40.0);
        let at = |time: f64| samples[(time / 0.025) as usize].clone();
        assert_eq!(at(1.9).speed, CRUISE);
        assert!((at(8.0).speed - 20.0 / 3.6).abs() < 0.01);
        let stop = samples.iter().position(|sample| sample.mode == "stop").unwrap() as f64 * 0.025;
        assert_eq!(at(stop + 5.0).speed, 0.0);
        assert!(at(stop + 6.5).speed > 0.0 && (samples.last().unwrap().speed - CRUISE).abs() < 0.01);
    }

    #[test]
    fn accelerates_at_its_crossing_triggers() {
        let mut near = track("when distance_to_crossing < d1 accelerate a1", &[("d1", 30.0), ("a1", 1.0)]);
        near.crossing = 60.0;
        let samples = near.drive(5.0);
        let begin = samples.iter().position(|sample| sample.mode == "accelerate").unwrap();
        assert!((begin as f64 * 0.025 * CRUISE - (60.0 - 30.0 - 2.25)).abs() < 0.22);
        let mut soon = track("when time_to_arrival < t1 stop", &[("t1", 4.0)]);
        soon.crossing = 60.0;
        let samples = soon.drive(5.0);
        let begin = samples.iter().position(|sample| sample.mode == "stop").unwrap();
        assert!((60.0 / CRUISE - 4.0 - begin as f64 * 0.025).abs() < 0.026);
    }
}
