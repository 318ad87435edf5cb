//! The longitudinal controller: feed-forward and PID while driving, a gentle stop, holding still (§3.1).

use super::profile::ProfileReference;
use scenario::Settings;

/// Share of the old speed error that is kept per step.
const ERROR_SMOOTHING: f64 = 0.9;

/// Limit of the integral's part of the feedback, m/s², and the speed above which it integrates, m/s.
const INTEGRAL_LIMIT: f64 = 0.3;
const INTEGRATES_ABOVE: f64 = 0.5;

/// Distances to the stop at which it starts to stop, drives on, and starts from standstill, m.
const STOPPING_WITHIN: f64 = 0.49;
const DRIVING_BEYOND: f64 = 1.5;
const STARTING_BEYOND: f64 = 0.5;

/// It stands once it was slower than this (m/s) for so long (s).
const STANDING_SPEED: f64 = 0.01;
const STANDING_TIME: f64 = 0.1;

/// The gentle stop: accelerations in m/s², overruns in m, time in s.
const STRONG: (f64, f64) = (-0.8, -0.5);
const WEAK: f64 = -0.3;
const WEAK_WITHIN: f64 = 0.8;
const OVERRUN: (f64, f64) = (0.3, -0.8);
const FAR_OVERRUN: (f64, f64) = (0.5, -3.4);
const HOLD: f64 = -3.4;

/// The plan's speed is at least this where it divides, m/s.
const LEAST_REFERENCE: f64 = 0.1;

/// Absorbs the rounding of differences of times, s.
const TOLERANCE: f64 = 1e-6;

#[derive(Debug, Clone, Copy)]
struct Constants {
    proportional: f64,
    integral: f64,
    feedback: f64,
    scale: (f64, f64),
    command: (f64, f64),
    /// Downward (negative) and upward, m/s³.
    jerk: (f64, f64),
    delay: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DriveState {
    Driving,
    Stopping,
    Stopped,
}

/// What the controller knows at a step.
#[derive(Debug, Clone, Copy)]
pub struct Situation {
    /// s
    pub time: f64,
    /// Since the step before, s.
    pub elapsed: f64,
    /// m/s
    pub speed: f64,
    /// m/s²
    pub acceleration: f64,
    pub reference: ProfileReference,
    /// From the bumper to the end of the plan; infinite without a stop, m.
    pub stop_distance: f64,
}

#[derive(Debug, Clone, Copy)]
pub struct LongitudinalController {
    constants: Constants,
    state: DriveState,
    /// Smoothed, m/s.
    error: f64,
    /// Of the smoothed error, m.
    error_sum: f64,
    /// The strong acceleration of the stop under way, m/s².
    strong: f64,
    slow_since: Option<f64>,
    /// The last command, m/s².
    command: f64,
}

impl LongitudinalController {
    pub fn new(settings: &Settings) -> Self {
        let constants = Constants {
            proportional: settings.number("proportional_gain"),
            integral: settings.number("integral_gain"),
            feedback: settings.number("feedback_limit"),
            scale: (settings.number("feedforward_scale_min"), settings.number("feedforward_scale_max")),
            command: (
                -settings.number("command_deceleration_limit"),
                settings.number("command_acceleration_limit"),
            ),
            jerk: (
                -settings.number("command_negative_jerk_limit"),
                settings.number("command_positive_jerk_limit"),
            ),
            delay: settings.number("delay_compensation"),
        };
        Self {
            constants,
            state: DriveState::Driving,
            error: 0.0,
            error_sum: 0.0,
            strong: 0.0,
            slow_since: None,
            command: 0.0,
        }
    }

    pub fn state(&self) -> DriveState {
        self.state
    }

    /// The last command, m/s².
    pub fn command(&self) -> f64 {
        self.command
    }

    /// Takes note of a command that another gave in its place.
    pub fn overridden(&mut self, command: f64) {
        self.command = command;
        self.error = 0.0;
        self.error_sum = 0.0;
        self.state = DriveState::Driving;
        self.slow_since = None;
    }

    /// The acceleration to command, m/s².
    pub fn step(&mut self, situation: &Situation) -> f64 {
        self.change_state(situation);
        let wanted = match self.state {
            DriveState::Driving => self.drive(situation),
            DriveState::Stopping => self.stop(situation),
            DriveState::Stopped => HOLD,
        };
        let Constants { command: (least, most), jerk: (down, up), .. } = self.constants;
        let elapsed = situation.elapsed;
        self.command =
            wanted.clamp(least, most).clamp(self.command + down * elapsed, self.command + up * elapsed);
        self.command
    }

    fn change_state(&mut self, situation: &Situation) {
        let distance = situation.stop_distance;
        if situation.speed.abs() < STANDING_SPEED {
            self.slow_since.get_or_insert(situation.time);
        } else {
            self.slow_since = None;
        }
        let stands = self.slow_since.is_some_and(|since| situation.time - since >= STANDING_TIME - TOLERANCE);
        let next = match self.state {
            DriveState::Driving if distance < STOPPING_WITHIN => DriveState::Stopping,
            DriveState::Stopping if distance > DRIVING_BEYOND => DriveState::Driving,
            DriveState::Stopping if stands => DriveState::Stopped,
            DriveState::Stopped if distance > STARTING_BEYOND => DriveState::Driving,
            same => same,
        };
        if next == self.state {
            return;
        }
        match next {
            DriveState::Driving => {
                self.error = 0.0;
                self.error_sum = 0.0;
            }
            DriveState::Stopping => {
                let needed = if distance > 0.0 {
                    -situation.speed * situation.speed / (2.0 * distance)
                } else {
                    f64::NEG_INFINITY
                };
                self.strong = needed.clamp(STRONG.0, STRONG.1);
            }
            DriveState::Stopped => {}
        }
        self.state = next;
    }

    fn drive(&mut self, situation: &Situation) -> f64 {
        let Constants { proportional, integral, feedback, scale, .. } = self.constants;
        let Situation { speed, reference, elapsed, .. } = *situation;
        let error = reference.speed - speed;
        self.error = ERROR_SMOOTHING * self.error + (1.0 - ERROR_SMOOTHING) * error;
        if speed > INTEGRATES_ABOVE && integral > 0.0 {
            let limit = INTEGRAL_LIMIT / integral;
            self.error_sum = (self.error_sum + self.error * elapsed).clamp(-limit, limit);
        }
        let factor = (speed / reference.speed.max(LEAST_REFERENCE)).clamp(scale.0, scale.1);
        let correction = proportional * self.error + integral * self.error_sum;
        reference.acceleration * factor + correction.clamp(-feedback, feedback)
    }

    fn stop(&self, situation: &Situation) -> f64 {
        let overrun = -situation.stop_distance;
        if overrun > FAR_OVERRUN.0 {
            return FAR_OVERRUN.1;
        }
        if overrun > OVERRUN.0 {
            return OVERRUN.1;
        }
        // The measured acceleration stands for the slope that the original fits to the last speeds.
        let braking = -situation.acceleration;
        let time_left = if braking > 0.0 { situation.speed / braking } else { f64::INFINITY };
        if time_left > WEAK_WITHIN + self.constants.delay { self.strong } else { WEAK }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::autoware::autoware;

    fn controller() -> LongitudinalController {
        LongitudinalController::new(&autoware().declaration.resolve(&Settings::default()).unwrap())
    }

    fn situation(speed: f64, reference: ProfileReference, stop_distance: f64) -> Situation {
        Situation { time: 0.0, elapsed: 0.03, speed, acceleration: 0.0, reference, stop_distance }
    }

    #[test]
    fn feed_forward_scales_with_speed_and_the_error_is_smoothed() {
        let mut controller = controller();
        controller.command = -1.0;
        // Error 8 - 8.4 = -0.4, smoothed -0.04; sum -0.04 * 0.03; factor 1.05.
        let reference = ProfileReference { speed: 8.0, acceleration: -1.0 };
        let command = controller.step(&situation(8.4, reference, f64::INFINITY));
        let expected = -1.05 - 0.04 - 0.1 * 0.04 * 0.03;
        assert!((command - expected).abs() < 1e-12, "{command}");
    }

    #[test]
    fn commands_and_their_jerk_are_limited() {
        let mut controller = controller();
        let hard = ProfileReference { speed: 8.0, acceleration: -9.0 };
        let commands: Vec<_> =
            (0..60).map(|_| controller.step(&situation(8.0, hard, f64::INFINITY))).collect();
        assert!((commands[0] + 0.15).abs() < 1e-12);
        assert_eq!(commands[59], -5.0);
        let fast = ProfileReference { speed: 8.0, acceleration: 9.0 };
        assert!((controller.step(&situation(8.0, fast, f64::INFINITY)) + 4.94).abs() < 1e-12);
    }

    #[test]
    fn feedback_is_limited() {
        let mut controller = controller();
        let reference = ProfileReference { speed: 8.0, acceleration: 0.0 };
        for _ in 0..400 {
            controller.step(&situation(2.0, reference, f64::INFINITY));
        }
        assert_eq!(controller.command(), 1.0);
    }

    #[test]
    fn stops_in_three_states() {
        let mut controller = controller();
        let slow = ProfileReference { speed: 0.5, acceleration: -0.5 };
        controller.step(&situation(0.6, slow, 0.5));
        assert_eq!(controller.state(), DriveState::Driving);
        controller.step(&situation(0.6, slow, 0.48));
        assert_eq!(controller.state(), DriveState::Stopping);
        // 0.36 / 0.96 = 0.375, so the weaker end of the strong range.
        assert_eq!(controller.strong, -0.5);
        controller.step(&situation(0.6, slow, 1.4));
        assert_eq!(controller.state(), DriveState::Stopping);
        let standing = |time| Situation { time, ..situation(0.0, ProfileReference::default(), 0.2) };
        controller.step(&standing(1.0));
        controller.step(&standing(1.05));
        assert_eq!(controller.state(), DriveState::Stopping);
        controller.step(&standing(1.1));
        assert_eq!(controller.state(), DriveState::Stopped);
        for k in 0..60 {
            controller.step(&standing(1.1 + 0.03 * f64::from(k)));
        }
        assert_eq!(controller.command(), -3.4);
        controller.step(&situation(0.0, ProfileReference::default(), 0.6));
        assert_eq!(controller.state(), DriveState::Driving);
    }

    #[test]
    fn the_gentle_stop_weakens_at_the_end_and_hardens_past_the_line() {
        let mut controller = controller();
        controller.state = DriveState::Stopping;
        controller.strong = -0.6;
        let at = |speed: f64, acceleration: f64, distance: f64| {
            controller
                .stop(&Situation { acceleration, ..situation(speed, ProfileReference::default(), distance) })
        };
        assert_eq!(at(0.6, -0.6, 0.3), -0.6);
        assert_eq!(at(0.5, -0.6, 0.3), -0.3);
        assert_eq!(at(0.5, 0.1, 0.3), -0.6);
        assert_eq!(at(0.5, -0.6, -0.35), -0.8);
        assert_eq!(at(0.5, -0.6, -0.55), -3.4);
    }
}
