//! A vehicle that answers acceleration commands after a dead time and with a first-order lag.

use std::collections::VecDeque;

use crate::vehicle::{CommandKind, DynamicsModel};
use scenario::{Declaration, Dimension, Ground, Parameter, Settings};
use sim::{Command, Dynamics, Longitudinal, ModelError};

const AUTOWARE: &str = "Autoware sample vehicle, simulator_model.param.yaml (DELAY_STEER_ACC_GEARED)";

pub fn delay_lag() -> DynamicsModel {
    let declaration = Declaration::new(
        "delay_lag",
        "Takes acceleration commands after a dead time and with a first-order lag, as \
         Autoware's simulator does.",
    )
    .source(AUTOWARE)
    .parameters([
        Parameter::number(
            "dead_time",
            Dimension::TIME,
            0.1,
            (0.0, 5.0),
            "Time before a command has any effect.",
            AUTOWARE,
        ),
        Parameter::number(
            "time_constant",
            Dimension::TIME,
            0.1,
            (0.0, 5.0),
            "Time constant of the lag; 0 is no lag.",
            AUTOWARE,
        ),
        Parameter::number(
            "max_acceleration",
            Dimension::ACCELERATION,
            7.0,
            (0.1, 50.0),
            "Limit of acceleration and of deceleration.",
            AUTOWARE,
        ),
        Parameter::number("max_speed", Dimension::SPEED, 50.0, (1.0, 100.0), "Limit of speed.", AUTOWARE),
    ]);
    DynamicsModel::new(declaration, &[CommandKind::Acceleration], (4.89, 1.896), build)
}

/// Room for this many commands in the dead time before one costs an allocation.
const COMMANDS_AT_FIRST: usize = 64;

struct DelayLag {
    dead_time: f64,
    time_constant: f64,
    limit: f64,
    max_speed: f64,
    /// Commands given but not yet in effect, the oldest first, each with the time until it is, s.
    pending: VecDeque<(f64, f64)>,
    /// The newest command, m/s².
    newest: f64,
    /// The command in effect, m/s².
    effective: f64,
    /// m/s²
    acceleration: f64,
}

/// Absorbs the rounding of sums of steps, s.
const TIME_TOLERANCE: f64 = 1e-9;

fn build(settings: &Settings) -> Result<Box<dyn Dynamics>, ModelError> {
    Ok(Box::new(DelayLag {
        dead_time: settings.number("dead_time"),
        time_constant: settings.number("time_constant"),
        limit: settings.number("max_acceleration"),
        max_speed: settings.number("max_speed"),
        pending: VecDeque::with_capacity(COMMANDS_AT_FIRST),
        newest: 0.0,
        effective: 0.0,
        acceleration: 0.0,
    }))
}

/// What a command comes to over a while on level, dry ground.
struct Response {
    /// At its end, m/s².
    acceleration: f64,
    /// m/s
    gained: f64,
    /// m
    covered: f64,
}

impl DelayLag {
    /// The exact solution of da/dt = (command - a) / T over `duration` s, from a speed (m/s).
    fn response(&self, speed: f64, duration: f64) -> Response {
        let command = self.effective;
        let start = self.acceleration;
        if self.time_constant > 0.0 {
            let tau = self.time_constant;
            let left = libm::exp(-duration / tau);
            let gap = start - command;
            let gained = command * duration + gap * tau * (1.0 - left);
            let covered = speed * duration
                + command * duration * duration / 2.0
                + gap * tau * (duration - tau * (1.0 - left));
            Response { acceleration: command + gap * left, gained, covered }
        } else {
            let covered = speed * duration + command * duration * duration / 2.0;
            Response { acceleration: command, gained: command * duration, covered }
        }
    }

    /// Moves on by `duration` s with one command in effect.
    fn respond(&mut self, motion: &mut Longitudinal, duration: f64) {
        if duration <= 0.0 {
            return;
        }
        let response = self.response(motion.speed, duration);
        self.follow(motion, duration, response);
    }

    fn follow(&mut self, motion: &mut Longitudinal, duration: f64, response: Response) {
        let Response { acceleration: end, gained, covered } = response;
        let speed = motion.speed + gained;
        self.acceleration = end;
        if speed < 0.0 {
            // Came to rest inside: the acceleration is nearly constant over what is left of it.
            motion.travelled += motion.speed * motion.speed / (motion.speed - speed) * duration / 2.0;
            motion.speed = 0.0;
            self.acceleration = 0.0;
        } else if speed > self.max_speed {
            motion.travelled += self.max_speed * duration;
            motion.speed = self.max_speed;
            self.acceleration = 0.0;
        } else {
            motion.travelled += covered.max(0.0);
            motion.speed = speed;
        }
    }

    /// As [`Self::respond`], on such ground: in parts over which tyres hold all of the acceleration or none of its change.
    fn respond_on(&mut self, ground: &Ground, motion: &mut Longitudinal, duration: f64) {
        let grip = ground.grip();
        let (start, command) = (self.acceleration, self.effective);
        let reaches = |limit: f64| match self.time_constant > 0.0 {
            true => -self.time_constant * libm::log((limit - command) / (start - command)),
            false => f64::NAN,
        };
        let (one, other) = (reaches(grip), reaches(-grip));
        let mut done = 0.0;
        for end in [one.min(other), one.max(other), duration] {
            // Comparing with what is not a number fails: then the limit is never reached.
            if end > done && end <= duration {
                self.respond_within(ground, motion, end - done);
                done = end;
            }
        }
    }

    /// As [`Self::respond_on`], for a while over which the acceleration does not cross what tyres hold.
    fn respond_within(&mut self, ground: &Ground, motion: &mut Longitudinal, duration: f64) {
        let (grip, slope) = (ground.grip(), ground.slope());
        let mut response = self.response(motion.speed, duration);
        let mean = response.gained / duration;
        if mean.abs() > grip {
            let held = mean.clamp(-grip, grip);
            (response.gained, response.covered) =
                (held * duration, motion.speed * duration + held * duration * duration / 2.0);
        }
        let built_up = response.acceleration;
        let pulls = response.gained > 0.0;
        if motion.speed == 0.0 && !pulls {
            // Held by its brake.
            self.acceleration = 0.0;
            return;
        }
        response.gained -= slope * duration;
        response.covered -= slope * duration * duration / 2.0;
        self.follow(motion, duration, response);
        if motion.speed == 0.0 && pulls {
            // What gravity still holds back goes on building up.
            self.acceleration = built_up;
        }
    }

    /// Moves on by `step` s; `respond` is what the command in effect does for a while.
    fn obey(
        &mut self,
        motion: &mut Longitudinal,
        command: Command,
        step: f64,
        mut respond: impl FnMut(&mut Self, &mut Longitudinal, f64),
    ) {
        let Command::Acceleration(wanted) = command else {
            panic!("`delay_lag` takes accelerations, not pedals");
        };
        let before = motion.speed;
        let command = wanted.clamp(-self.limit, self.limit);
        if command != self.newest {
            self.newest = command;
            self.pending.push_back((self.dead_time, command));
        }
        let mut done = 0.0;
        while let Some(&(left, command)) =
            self.pending.front().filter(|(left, _)| *left < step - TIME_TOLERANCE)
        {
            if left > done + TIME_TOLERANCE {
                respond(self, motion, left - done);
                done = left;
            }
            self.effective = command;
            self.pending.pop_front();
        }
        respond(self, motion, step - done);
        self.pending.iter_mut().for_each(|(left, _)| *left -= step);
        motion.acceleration = (motion.speed - before) / step;
    }
}

impl Dynamics for DelayLag {
    fn advance(&mut self, motion: &mut Longitudinal, command: Command, step: f64) {
        self.obey(motion, command, step, Self::respond);
    }

    fn advance_on(&mut self, ground: &Ground, motion: &mut Longitudinal, command: Command, step: f64) {
        self.obey(motion, command, step, |car, motion, duration| car.respond_on(ground, motion, duration));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::dynamics::tests::{built, cruising, stop};
    use scenario::Value;

    fn after(time: f64, step: f64, settings: Settings) -> Longitudinal {
        let mut car = built(&delay_lag(), settings);
        let mut motion = cruising();
        for _ in 0..(time / step).round() as usize {
            car.advance(&mut motion, Command::Acceleration(-2.0), step);
        }
        motion
    }

    #[test]
    fn follows_the_exact_step_response_at_any_step() {
        // Dead time 0.1 s and lag 0.1 s: after t the speed has dropped by 2 (t - 0.1 - 0.1 (1 - exp(-(t - 0.1)/0.1))).
        let dropped = 2.0 * (0.9 - 0.1 * (1.0 - (-9.0f64).exp()));
        for step in [0.0125, 0.025, 0.04, 0.1] {
            let motion = after(1.0, step, Settings::default());
            assert!((motion.speed - (30.0 / 3.6 - dropped)).abs() < 1e-12, "step {step}: {}", motion.speed);
        }
    }

    /// The world divides its steps where a controller decides, so steps differ in length.
    #[test]
    fn steps_of_any_lengths_come_to_the_same() {
        let commands = [(0.4, -2.0), (0.3, 1.0), (0.05, -7.0), (0.5, -1.0), (0.7, 0.5)];
        let slippery = |gradient| Some(Ground { gradient: Some(gradient), friction: Some(0.15) });
        let drive = |steps: &[f64], ground: Option<Ground>| {
            let settings = Settings::from([("dead_time", Value::Number(0.13))]);
            let mut car = built(&delay_lag(), settings);
            let mut motion = cruising();
            let mut lengths = steps.iter().cycle();
            for (duration, command) in commands {
                let mut left: f64 = duration;
                while left > 1e-12 {
                    let step = lengths.next().unwrap().min(left);
                    let command = Command::Acceleration(command);
                    match &ground {
                        None => car.advance(&mut motion, command, step),
                        Some(ground) => car.advance_on(ground, &mut motion, command, step),
                    }
                    left -= step;
                }
            }
            (motion.travelled, motion.speed)
        };
        for ground in [None, slippery(0.0), slippery(0.05), slippery(-0.05)] {
            let (place, speed) = drive(&[0.025], ground);
            for steps in [&[0.01][..], &[0.005, 0.02], &[0.1], &[0.001, 0.033, 0.0125]] {
                let (other_place, other_speed) = drive(steps, ground);
                let apart = (place - other_place).abs().max((speed - other_speed).abs());
                assert!(apart < 1e-9, "{steps:?} on {ground:?}: {apart}");
            }
        }
    }

    #[test]
    fn nothing_happens_within_the_dead_time() {
        assert_eq!(after(0.1, 0.025, Settings::default()).speed, 30.0 / 3.6);
        assert!(after(0.125, 0.025, Settings::default()).speed < 30.0 / 3.6);
    }

    #[test]
    fn without_delay_and_lag_it_is_a_point_mass() {
        let none = [("dead_time", Value::Number(0.0)), ("time_constant", Value::Number(0.0))];
        let motion = after(1.0, 0.025, Settings::from(none));
        assert!((motion.speed - (30.0 / 3.6 - 2.0)).abs() < 1e-12);
        assert!((motion.travelled - (30.0 / 3.6 - 1.0)).abs() < 1e-12);
    }

    #[test]
    fn braking_distance_has_the_delay_in_it() {
        // Dead time and lag each cost about 0.1 s at cruise speed.
        let (distance, _) =
            stop(&mut *built(&delay_lag(), Settings::default()), Command::Acceleration(-2.5), 0.025);
        let speed = 30.0 / 3.6;
        let expected = speed * speed / 5.0 + speed * 0.2 - 2.5 * 0.1 * 0.1 / 2.0;
        assert!((distance - expected).abs() < 1e-3, "{distance} {expected}");
    }

    #[test]
    fn a_standing_vehicle_keeps_standing_and_starts_without_a_debt() {
        let mut car = built(&delay_lag(), Settings::default());
        let mut motion = cruising();
        for _ in 0..400 {
            car.advance(&mut motion, Command::Acceleration(-3.4), 0.025);
        }
        let place = motion.travelled;
        assert_eq!((motion.speed, motion.acceleration), (0.0, 0.0));
        for _ in 0..40 {
            car.advance(&mut motion, Command::Acceleration(1.0), 0.025);
        }
        assert!(motion.travelled > place);
        let expected = 0.9 - 0.1 * (1.0 - (-9.0f64).exp());
        assert!((motion.speed - expected).abs() < 1e-9, "{}", motion.speed);
    }

    #[test]
    fn it_sets_off_uphill_once_it_pulls_more_than_gravity() {
        let ground = Ground { gradient: Some(0.08), friction: None };
        let slope = ground.slope();
        let after = |command: f64| {
            let mut car = built(&delay_lag(), Settings::default());
            let mut motion = Longitudinal { travelled: 0.0, speed: 0.0, acceleration: 0.0 };
            for _ in 0..160 {
                car.advance_on(&ground, &mut motion, Command::Acceleration(command), 0.025);
            }
            motion.speed
        };
        // What pulls is 1 - exp(-(t - 0.1) / 0.1) of it, and gravity is held by the brake until then.
        let moves_from = 0.1 - 0.1 * (1.0 - slope).ln();
        let lasts = 4.0 - moves_from;
        let expected = (1.0 - slope) * lasts - 0.1 * (1.0 - slope) * (1.0 - (-lasts / 0.1).exp());
        let found = after(1.0);
        assert!((found - expected).abs() < 5e-3, "{found}, not {expected}");
        assert_eq!(after(0.99 * slope), 0.0);
    }
}
