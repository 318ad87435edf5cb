//! The competent and careful human driver of UN R157, adapted from vehicles that cut in to pedestrians.
//!
//! The regulation's driver perceives a risk, evaluates it for 0.4 s, starts to brake 0.75 s later and reaches 0.774 g
//! within 0.6 s. What counts as a risk is adapted here: a pedestrian on the road who is on a collision course, or the vehicle ahead, at a
//! time to collision below 2 s or too near for the driver to stop later.

use super::hazard::{
    Ramp, TIE, VehicleAhead, collision_course, keep_speed, met_when_setting_off, vehicle_ahead,
};
use super::period::period;
use super::red_light::{self, RedLight};
use super::{CommandKind, ControllerContext, ControllerModel};
use scenario::{Attention, Chance, Declaration, Dimension, LooksAt, Parameter, SignalConduct};
use sim::{Command, Controller, ControllerError, Mode, ModelError, Observation, Schedule, SeenPedestrian};

const R157: &str = "UN R157 annex 3 (annex 4 appendix 3 of the original version), performance \
                    model of a careful driver";
const ADAPTED: &str = "adaptation to pedestrians";
const FREE: &str = "free choice";

pub fn careful_human() -> ControllerModel {
    let declaration = Declaration::new(
        "careful_human",
        "The competent and careful human driver of UN R157: reacts 1.15 s after a risk \
         and brakes with 0.774 g.",
    )
    .source(
        "UN Regulation No. 157, performance model for a careful driver; risk adapted \
         to pedestrians",
    )
    .parameters([
        Parameter::number(
            "risk_evaluation",
            Dimension::TIME,
            0.4,
            (0.0, 10.0),
            "Time for which a risk is evaluated once perceived.",
            R157,
        ),
        Parameter::number(
            "reaction_delay",
            Dimension::TIME,
            0.75,
            (0.0, 10.0),
            "Time from the end of the evaluation to the beginning of braking.",
            R157,
        ),
        Parameter::number(
            "deceleration",
            Dimension::ACCELERATION,
            0.774 * 9.80665,
            (0.1, 15.0),
            "Full deceleration.",
            R157,
        ),
        Parameter::number(
            "ramp_time",
            Dimension::TIME,
            0.6,
            (0.0, 10.0),
            "Time from the beginning of braking to full deceleration.",
            R157,
        ),
        Parameter::number(
            "risk_time",
            Dimension::TIME,
            2.0,
            (0.0, 60.0),
            "Time to collision below which a collision course is a risk.",
            "UN R157 takes 2 s for cutting in",
        ),
        Parameter::flag(
            "anticipates",
            true,
            "Whether a collision course is also a risk when the driver could not stop any \
             later.",
            ADAPTED,
        ),
        Parameter::number(
            "standstill_gap",
            Dimension::LENGTH,
            1.0,
            (0.0, 20.0),
            "Gap that an anticipating driver wants to keep before the pedestrian.",
            ADAPTED,
        ),
        Parameter::number(
            "risk_line",
            Dimension::LENGTH,
            0.0,
            (-20.0, 5.0),
            "How far beyond the kerb a pedestrian must be to be a risk; negative: on the \
             pavement already.",
            ADAPTED,
        ),
        Parameter::number(
            "margin",
            Dimension::LENGTH,
            0.25,
            (-1.0, 5.0),
            "Widens the swept strip on each side.",
            ADAPTED,
        ),
        Parameter::number(
            "acceleration",
            Dimension::ACCELERATION,
            1.5,
            (0.1, 10.0),
            "Acceleration back to the wanted speed.",
            FREE,
        ),
        period(),
    ]);
    ControllerModel::new(declaration, CommandKind::Acceleration, build)
        .driving("ideal")
        .chance(Chance::Never)
        .signals(SignalConduct::Obeys)
        .attention(Attention::Reacts(|_| LooksAt::OWN_LANE))
}

struct CarefulHuman {
    period: f64,
    risk_evaluation: f64,
    reaction_delay: f64,
    deceleration: f64,
    ramp_time: f64,
    risk_time: f64,
    anticipates: bool,
    standstill_gap: f64,
    risk_line: f64,
    margin: f64,
    acceleration: f64,
    state: State,
    /// `None`: it ignores signals.
    red_light: Option<RedLight>,
    /// Its braking for a signal, if it does.
    for_red: Option<Ramp>,
    standing_at_red: bool,
    last_time: Option<f64>,
}

#[derive(Clone, Copy)]
enum State {
    Driving,
    /// Perceived a risk at this time, s.
    Evaluating(f64),
    /// Found it to be one at this time, s.
    Reacting(f64),
    Braking(Ramp),
}

fn build(context: &ControllerContext) -> Result<Box<dyn Controller>, ModelError> {
    let settings = context.settings;
    Ok(Box::new(CarefulHuman {
        period: settings.number("period"),
        risk_evaluation: settings.number("risk_evaluation"),
        reaction_delay: settings.number("reaction_delay"),
        deceleration: settings.number("deceleration"),
        ramp_time: settings.number("ramp_time"),
        risk_time: settings.number("risk_time"),
        anticipates: settings.flag("anticipates"),
        standstill_gap: settings.number("standstill_gap"),
        risk_line: settings.number("risk_line"),
        margin: settings.number("margin"),
        acceleration: settings.number("acceleration"),
        state: State::Driving,
        // It takes as long to react to a signal as to a risk.
        red_light: RedLight::new(
            context,
            settings.number("risk_evaluation") + settings.number("reaction_delay"),
            red_light::DECELERATION,
        ),
        for_red: None,
        standing_at_red: false,
        last_time: None,
    }))
}

/// Absorbs the rounding of summed times, s.
const TIME_TOLERANCE: f64 = 1e-9;

/// So much farther (m) than where it is a risk the vehicle ahead has to be before the driver speeds up towards it; free choice.
const NOT_PRESSING_ON: f64 = 1.0;

impl CarefulHuman {
    /// Whether anybody is on a collision course (`near`: and near enough to be a risk).
    fn any_conflict(&self, observation: &Observation, near: bool) -> bool {
        let ego = &observation.ego;
        let people = observation.pedestrians.iter().any(|seen| {
            self.on_the_road(observation, seen)
                && collision_course(ego, seen, self.margin).is_some_and(|hazard| {
                    !near
                        || hazard.time_to_collision < self.risk_time - TIE
                        || self.anticipates
                            && hazard.gap - self.standstill_gap < self.stopping_distance(ego.speed) - TIE
                })
        });
        let is_conflict = |ahead: VehicleAhead| {
            ahead.time_to_collision.is_finite()
                && (!near
                    || ahead.time_to_collision < self.risk_time - TIE
                    || self.anticipates && self.room_behind(&ahead, ego.speed) < -TIE)
        };
        people || observation.vehicles.iter().filter_map(|seen| vehicle_ahead(ego, seen)).any(is_conflict)
    }

    /// What is left (m) of the gap to the vehicle ahead if that brakes now as hard as the driver can, and the driver reacts to it.
    fn room_behind(&self, ahead: &VehicleAhead, speed: f64) -> f64 {
        let own = self.stopping_distance(speed);
        // At once: it may be braking already.
        let others = ahead.speed.max(0.0);
        let others = others * others / (2.0 * self.deceleration);
        ahead.gap - self.standstill_gap - own + others
    }

    /// Whether the driver leaves the speed as it is, since something is before the vehicle: from standstill people who are in
    /// its strip or will be, near enough that it would have to brake for them before it is at its wanted speed; always the vehicle ahead.
    fn holds(&self, observation: &Observation) -> bool {
        let ego = &observation.ego;
        let reach = self.standstill_gap + self.stopping_distance(observation.cruise_speed);
        let person = |seen: &SeenPedestrian| {
            let gap = met_when_setting_off(ego, seen, self.margin, self.acceleration);
            self.on_the_road(observation, seen) && gap.is_some_and(|gap| gap < reach)
        };
        let too_near = |ahead: VehicleAhead| self.room_behind(&ahead, ego.speed) < NOT_PRESSING_ON;
        ego.speed == 0.0 && observation.pedestrians.iter().any(person)
            || observation.vehicles.iter().filter_map(|seen| vehicle_ahead(ego, seen)).any(too_near)
    }

    fn on_the_road(&self, observation: &Observation, seen: &SeenPedestrian) -> bool {
        let y = seen.position.y;
        (y - observation.road.right_kerb).min(observation.road.left_kerb - y) >= self.risk_line - TIE
    }

    /// From the perception of a risk to standstill, m.
    fn stopping_distance(&self, speed: f64) -> f64 {
        let reacting = speed * (self.risk_evaluation + self.reaction_delay);
        let lost_in_ramp = self.deceleration * self.ramp_time / 2.0;
        if lost_in_ramp >= speed {
            // Stands within the ramp, after sqrt(2 v / jerk): two thirds of the way at full speed.
            let time =
                if speed == 0.0 { 0.0 } else { (2.0 * speed * self.ramp_time / self.deceleration).sqrt() };
            return reacting + 2.0 / 3.0 * speed * time;
        }
        let ramp = speed * self.ramp_time - self.deceleration * self.ramp_time * self.ramp_time / 6.0;
        let left = speed - lost_in_ramp;
        reacting + ramp + left * left / (2.0 * self.deceleration)
    }

    fn next_state(&self, observation: &Observation) -> State {
        let now = observation.time;
        let conflict = |near| self.any_conflict(observation, near);
        let over = |since: f64, duration: f64| now - since >= duration - TIME_TOLERANCE;
        let mut state = match self.state {
            State::Driving if conflict(true) => State::Evaluating(now),
            State::Evaluating(_) if !conflict(true) => State::Driving,
            State::Reacting(_) | State::Braking(_) if !conflict(false) => State::Driving,
            state => state,
        };
        if let State::Evaluating(since) = state
            && over(since, self.risk_evaluation)
        {
            state = State::Reacting(now);
        }
        if let State::Reacting(since) = state
            && over(since, self.reaction_delay)
        {
            state = State::Braking(Ramp::from(observation.ego.acceleration.min(0.0)));
        }
        state
    }
}

impl Controller for CarefulHuman {
    fn schedule(&self) -> Schedule {
        Schedule::every(self.period)
    }

    fn act(&mut self, observation: &Observation) -> Result<Command, ControllerError> {
        let now = observation.time;
        let duration = now - self.last_time.replace(now).unwrap_or(now);
        self.state = self.next_state(observation);
        let speed = observation.ego.speed;
        let jerk = if self.ramp_time > 0.0 { self.deceleration / self.ramp_time } else { f64::INFINITY };
        let acceleration = if let State::Braking(ramp) = &mut self.state {
            // The first decision after the delay begins the ramp.
            ramp.toward(-self.deceleration, jerk, duration)
        } else {
            let wanted = keep_speed(speed, observation.cruise_speed, self.acceleration, self.deceleration);
            if wanted > 0.0 && self.holds(observation) { 0.0 } else { wanted }
        };
        let red = self.red_light.as_mut().and_then(|rule| rule.braking(observation));
        let Some(braking) = red else {
            (self.for_red, self.standing_at_red) = (None, false);
            return Ok(Command::Acceleration(acceleration));
        };
        let ramp = self.for_red.get_or_insert(Ramp::from(observation.ego.acceleration.min(0.0)));
        let for_red = ramp.toward(-braking.min(self.deceleration), jerk, duration);
        self.standing_at_red = red_light::stands(speed);
        Ok(Command::Acceleration(acceleration.min(for_red)))
    }

    fn mode(&self) -> Mode {
        Mode::new(match self.state {
            State::Driving if self.for_red.is_some() => red_light::mode(self.standing_at_red),
            State::Driving => "cruise",
            State::Evaluating(_) => "evaluating",
            State::Reacting(_) => "reacting",
            State::Braking(_) => "braking",
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;
    use crate::vehicle::test_track::{CRUISE, Sample, Track};
    use scenario::{Settings, Value};

    const G: f64 = 9.80665;

    fn track(pairs: &[(&str, Value)]) -> Track {
        Track::new(&careful_human(), Settings::from(pairs), "ideal")
    }

    /// Drives towards somebody who jumps into the lane `gap` m before the bumper after 1 s.
    fn surprised(pairs: &[(&str, Value)], gap: f64) -> (Vec<Sample>, f64) {
        let mut track = track(pairs);
        let place = CRUISE + 2.25 + gap + 0.1875;
        track.script_pedestrian(move |time| {
            let y = if time < 1.0 - 1e-9 { -4.0 } else { 0.0 };
            Some((Vector2::new(place, y), Vector2::zeros()))
        });
        let samples = track.drive(6.0);
        (samples, place - 0.1875 - track.front())
    }

    fn first(samples: &[Sample], mode: &str) -> f64 {
        samples.iter().position(|sample| sample.mode == mode).unwrap() as f64 * 0.025
    }

    #[test]
    fn reacts_after_the_regulations_times() {
        let (samples, _) = surprised(&[], 15.0);
        assert!((first(&samples, "evaluating") - 1.0).abs() < 0.026);
        assert!((first(&samples, "reacting") - 1.4).abs() < 0.026);
        let braking = first(&samples, "braking");
        assert!((braking - 2.15).abs() < 0.026, "{braking}");
        let at = |time: f64| match samples[(time / 0.025).round() as usize].command {
            Command::Acceleration(acceleration) => acceleration,
            Command::Pedals { .. } => unreachable!(),
        };
        // Half of 0.774 g halfway through the ramp, all of it after 0.6 s.
        assert!((at(braking + 0.3) + 0.387 * G).abs() < 0.35, "{}", at(braking + 0.3));
        assert!((at(braking + 0.65) + 0.774 * G).abs() < 1e-9);
    }

    #[test]
    fn stops_in_the_distance_that_the_numbers_give() {
        // 1.15 s of reaction, 0.6 s of ramp (4.54 m, 2.28 m/s) and 0.774 g for the rest (2.42 m).
        let expected = CRUISE * 1.15 + 4.5446 + (CRUISE - 0.774 * G * 0.3f64).powi(2) / (2.0 * 0.774 * G);
        let (_, left) = surprised(&[], 30.0);
        let needed = surprised(&[], 16.6);
        assert!((16.6 - needed.1 - expected).abs() < 0.25, "{} {expected}", 16.6 - needed.1);
        assert!(left > 0.0 && needed.1 > 0.0);
        // Below that distance nobody could have stopped.
        assert!(surprised(&[], 15.0).1 < 0.0);
    }

    #[test]
    fn its_own_estimate_is_what_it_needs() {
        let driver = |speed: f64| {
            let mut track = track(&[]);
            track.motion.speed = speed;
            track.observation.cruise_speed = speed;
            let place = 400.0;
            track.place_pedestrian(place, 0.0);
            track.drive(400.0 / speed + 20.0);
            (track.motion.speed, place - 0.1875 - track.front())
        };
        for speed in [1.5, 5.0, 8.0, 14.0, 25.0] {
            let (rest, left) = driver(speed);
            // At low speeds the 2 s time to collision comes first, which leaves more or less than the wanted metre.
            assert!(rest == 0.0 && left > 0.0, "{speed}: {rest} {left}");
            if speed > 10.0 {
                assert!((left - 1.0).abs() < 0.7, "{speed}: {left}");
            }
        }
    }

    #[test]
    fn without_anticipation_a_standing_pedestrian_is_too_near_at_50() {
        let mut track = track(&[("anticipates", Value::Flag(false))]);
        track.motion.speed = 50.0 / 3.6;
        track.observation.cruise_speed = 50.0 / 3.6;
        track.place_pedestrian(200.0, 0.0);
        track.drive(30.0);
        assert!(track.front() > 200.0);
    }

    #[test]
    fn those_on_the_pavement_or_soon_gone_are_no_risk() {
        let modes = |script: fn(f64) -> (Vector2<f64>, Vector2<f64>)| {
            let mut track = track(&[]);
            track.script_pedestrian(move |time| Some(script(time)));
            track.drive(8.0).iter().all(|sample| sample.mode == "cruise")
        };
        assert!(modes(|_| (Vector2::new(50.0, -2.5), Vector2::new(0.0, 1.4))));
        assert!(modes(|time| (Vector2::new(50.0, -2.0 + 1.4 * time), Vector2::new(0.0, 1.4))));
        assert!(!modes(|_| (Vector2::new(50.0, 0.0), Vector2::zeros())));
    }

    /// Drives for a while (s) behind a vehicle whose place (m) and speed (m/s) are functions of time, once it is there; the gap, the speed and
    /// the mode after each step.
    fn behind(lead: impl Fn(f64) -> Option<(f64, f64)>, duration: f64) -> Vec<(f64, f64, Mode)> {
        let mut track = track(&[]);
        let step = |index: usize| {
            track.observation.vehicles.clear();
            let ahead = lead(index as f64 * 0.025);
            if let Some((place, speed)) = ahead {
                track.see_vehicle(place - track.motion.travelled, speed);
            }
            let sample = track.advance();
            let gap = ahead.map_or(f64::INFINITY, |(place, _)| place - track.motion.travelled - 4.5);
            (gap, sample.speed, sample.mode)
        };
        (0..(duration / 0.025) as usize).map(step).collect()
    }

    #[test]
    fn a_vehicle_that_stands_before_it_is_a_risk_with_the_same_times() {
        let place = CRUISE + 4.5 + 17.2;
        let samples = behind(|time| (time >= 1.0 - 1e-9).then_some((place, 0.0)), 8.0);
        let first = |mode: &str| samples.iter().position(|sample| sample.2 == mode).unwrap() as f64 * 0.025;
        assert!((first("evaluating") - 1.0).abs() < 0.026);
        assert!((first("braking") - 2.15).abs() < 0.026, "{}", first("braking"));
        let last = samples.last().unwrap();
        assert!(last.1 == 0.0 && last.0 > 0.0, "{last:?}");
    }

    #[test]
    fn a_slower_vehicle_is_followed_and_nothing_is_done_beyond_its_reach() {
        let samples = behind(|time| Some((60.0 + 5.0 * time, 5.0)), 60.0);
        // 1.15 s at 5 m/s and the metre that it keeps, and up to one more.
        let settled = &samples[1600..];
        assert!(settled.iter().all(|(gap, ..)| (6.0..9.5).contains(gap)), "{:?}", settled[0]);
        assert!(settled.iter().all(|(_, speed, _)| (speed - 5.0).abs() < 0.5), "{:?}", settled[0]);
        let far = behind(|time| Some((60.0 + 9.0 * time, 9.0)), 30.0);
        assert!(far.iter().all(|sample| sample.2 == "cruise" && sample.1 == CRUISE));
    }

    #[test]
    fn it_waits_behind_a_queue_and_goes_with_it() {
        let place = |time: f64| {
            let driven = (time - 20.0_f64).max(0.0);
            Some((50.0 + driven * driven / 2.0, driven))
        };
        let samples = behind(place, 30.0);
        assert!(samples[790].1 == 0.0 && (0.0..2.1).contains(&samples[790].0), "{:?}", samples[790]);
        assert!(samples.iter().all(|(gap, ..)| *gap > 0.0) && samples.last().unwrap().1 > 5.0);
    }

    #[test]
    fn drives_on_when_the_way_is_clear() {
        let mut track = track(&[]);
        track.script_pedestrian(|time| {
            let y = if time < 15.0 { 0.0 } else { 4.0 };
            Some((Vector2::new(60.0, y), Vector2::zeros()))
        });
        let samples = track.drive(30.0);
        assert_eq!(samples[(14.0 / 0.025) as usize].speed, 0.0);
        assert!((samples.last().unwrap().speed - CRUISE).abs() < 0.01);
    }
}
