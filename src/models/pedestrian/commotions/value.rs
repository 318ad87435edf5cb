//! The value of a course of action: what moving is worth, discounted over an anticipated future in phases (§7), in closed form (§11).

use super::access::AccessCourse;
use super::sums::{PowerSumTable, STRIDE, power_sums_to_fourth};

/// Time between the samples of an anticipated future (s).
pub const SAMPLE_TIME: f64 = 0.025;

/// Half-lives after which a future is no longer looked at.
const HORIZON_IN_HALF_LIVES: f64 = 6.0;

/// What moving is worth per second to one kind of road user: `g(v, a) = k_g v − k_dv v² − k_da a²`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// k_g, per metre.
    pub progress: f64,
    /// k_dv, s/m².
    pub speed_discomfort: f64,
    /// k_da, s³/m².
    pub acceleration_discomfort: f64,
    /// The speed (m/s) at which moving is worth most: k_g / (2 k_dv).
    free_speed: f64,
}

impl Gains {
    /// The gains of someone whose wanted speed is `free_speed`, so that g(free speed, 0) is 1.
    pub fn for_free_speed(free_speed: f64, acceleration_discomfort: f64) -> Self {
        let (progress, speed_discomfort) = (2.0 / free_speed, 1.0 / (free_speed * free_speed));
        let free_speed = progress / (2.0 * speed_discomfort);
        Self { progress, speed_discomfort, acceleration_discomfort, free_speed }
    }

    /// The speed (m/s) at which moving is worth most. Its last bit can differ from the wanted one.
    pub fn free_speed(&self) -> f64 {
        self.free_speed
    }

    /// The value rate of moving at `speed` with `acceleration`.
    #[inline]
    pub fn rate(&self, speed: f64, acceleration: f64) -> f64 {
        speed * (self.progress - self.speed_discomfort * speed)
            - self.acceleration_discomfort * acceleration * acceleration
    }
}

/// How a road user moves during its action: the first phase of every anticipated future.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ActionPhase {
    /// Speed now (m/s).
    pub speed: f64,
    /// Acceleration at the start of the action (m/s²), α₀.
    pub acceleration: f64,
    /// Jerk (m/s³).
    pub jerk: f64,
}

/// What is left after the action phase: its value, and the speed it ends with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AfterAction {
    /// Discounted value of the action phase.
    pub value: f64,
    /// Speed of the first sample after it (m/s).
    pub speed: f64,
}

/// The phases of an anticipated future, cut into samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phases {
    /// First samples of the phases achieve, wait, regain, and one past the last of regain. Entries beyond
    /// the last phase mean nothing.
    pub starts: [usize; 4],
    /// How many phases are integrated: 0 for none, 1 for the action alone, 4 for all up to regaining speed.
    pub integrated: usize,
    /// Whether one sample is left over, which belongs to no phase.
    pub left_over: bool,
    /// When the free travelling starts (s): s₄.
    pub free_from: f64,
    /// When the last phase ends, in samples.
    last_sample: f64,
    /// Whether there is a wait phase, at exactly zero speed.
    pub waits: bool,
}

impl Phases {
    /// The sample after the last one that belongs to a phase.
    #[inline]
    pub fn end(&self) -> usize {
        if self.integrated == 0 { 0 } else { self.starts[self.integrated - 1] }
    }

    /// Whether the wait is integrated to its end, and so at exactly zero speed.
    #[inline]
    pub fn stands_while_waiting(&self) -> bool {
        self.waits && self.integrated == 4
    }
}

/// How one individual values the future: its discounting, with the sums that depend on nothing else.
#[derive(Clone, Debug)]
pub struct Discounting {
    half_life: f64,
    /// See [`Self::free_value`].
    free_value: f64,
    horizon: f64,
    action_duration: f64,
    action_samples: usize,
    action_sums: [f64; 5],
    action_weight: f64,
    /// ln r < 0, per sample.
    log_ratio: f64,
    table: PowerSumTable,
}

impl Discounting {
    /// Discounting with `half_life` (s) for actions of `action_duration` (s).
    pub fn new(half_life: f64, action_duration: f64) -> Self {
        let ratio = libm::exp2(-SAMPLE_TIME / half_life);
        let horizon = HORIZON_IN_HALF_LIVES * half_life;
        let action_samples = (action_duration / SAMPLE_TIME) as usize;
        let largest = (horizon / SAMPLE_TIME) as usize + 1;
        let table = PowerSumTable::new(ratio, largest.max(action_samples));
        Self {
            half_life,
            free_value: half_life / std::f64::consts::LN_2,
            horizon,
            action_duration,
            action_samples,
            action_sums: power_sums_to_fourth(ratio, action_samples),
            action_weight: table.weight(action_samples),
            log_ratio: -std::f64::consts::LN_2 * (SAMPLE_TIME / half_life),
            table,
        }
    }

    /// The value of travelling freely for ever: `T_δ / ln 2` times the rate at free speed, which is 1.
    pub fn free_value(&self) -> f64 {
        self.free_value
    }

    /// The discount r^n of sample n.
    #[inline]
    pub fn weight(&self, sample: usize) -> f64 {
        self.table.weight(sample)
    }

    /// The discounts of the first samples.
    #[inline]
    pub fn first_weights(&self) -> &[f64; STRIDE] {
        self.table.first_weights()
    }

    /// The samples of the phases of `course` (§7).
    #[inline]
    pub fn phases(&self, course: &AccessCourse, regain_time: f64) -> Phases {
        let achieve = if course.duration == 0.0 {
            0.0
        } else if course.duration > SAMPLE_TIME {
            course.duration
        } else {
            SAMPLE_TIME
        };
        let achieve_from = self.action_duration;
        let wait_from = achieve_from + achieve;
        let regain_from = wait_from + course.wait;
        let free_from = regain_from + regain_time;
        let mut phases = Phases {
            starts: [self.action_samples, 0, 0, 0],
            integrated: 4,
            left_over: false,
            free_from,
            last_sample: 0.0,
            waits: course.wait > 0.0,
        };
        let horizon = self.horizon;
        let samples = |time: f64| time / SAMPLE_TIME;
        // Without a wait one phase ends where the other does.
        let until_regain = |wait: f64| if course.wait == 0.0 { wait } else { samples(regain_from) };
        phases.last_sample = if free_from <= horizon {
            let (wait, free) = (samples(wait_from), samples(free_from));
            let regain = until_regain(wait);
            phases.starts = [self.action_samples, wait as usize, regain as usize, free as usize];
            free
        } else if achieve_from > horizon {
            phases.integrated = 0;
            return phases;
        } else if wait_from > horizon {
            phases.integrated = 1;
            samples(achieve_from)
        } else if regain_from > horizon {
            phases.integrated = 2;
            let wait = samples(wait_from);
            phases.starts[1] = wait as usize;
            wait
        } else {
            phases.integrated = 3;
            let wait = samples(wait_from);
            let regain = until_regain(wait);
            (phases.starts[1], phases.starts[2]) = (wait as usize, regain as usize);
            regain
        };
        phases.left_over = phases.last_sample > phases.end() as f64;
        phases
    }

    /// The value of the action phase and the speed after it.
    #[inline]
    pub fn action(&self, gains: &Gains, action: &ActionPhase) -> AfterAction {
        let [s0, s1, s2, s3, s4] = self.action_sums;
        let n = self.action_samples as f64;
        let Gains { progress: kg, speed_discomfort: kdv, acceleration_discomfort: kda, .. } = *gains;
        let (u, a) = (action.speed, action.acceleration);
        // u_n = u + b n + c n², a_n = a + j n.
        let j = action.jerk * SAMPLE_TIME;
        let c = j * SAMPLE_TIME / 2.0;
        let b = SAMPLE_TIME * a - c;
        let constant = u * (kg - kdv * u) - kda * a * a;
        let linear = b * (kg - 2.0 * kdv * u) - 2.0 * kda * a * j;
        let square = c * (kg - 2.0 * kdv * u) - kdv * b * b - kda * j * j;
        let cube = -2.0 * kdv * b * c;
        let fourth = -kdv * c * c;
        AfterAction {
            value: SAMPLE_TIME * (constant * s0 + linear * s1 + square * s2 + cube * s3 + fourth * s4),
            speed: u + n * (b + c * n),
        }
    }

    /// The value of everything after the action phase, given what it ended with: the kinematic part of the
    /// other phases and the continue part. Add [`AfterAction::value`] where [`Phases::integrated`] > 0.
    #[inline]
    pub fn after_action(
        &self,
        gains: &Gains,
        speed: f64,
        course: &AccessCourse,
        regain_time: f64,
        phases: &Phases,
    ) -> f64 {
        let mut sum = 0.0;
        let mut speed = speed;
        if phases.integrated == 4 {
            let [achieve, wait, regain, end] = phases.starts;
            let samples = wait - achieve;
            sum += self.phase(gains, speed, course.acceleration, achieve, samples);
            speed += SAMPLE_TIME * course.acceleration * samples as f64;
            if phases.waits {
                speed = 0.0;
            }
            let acceleration = (gains.free_speed() - speed) / regain_time;
            let samples = end - regain;
            sum += self.phase(gains, speed, acceleration, regain, samples);
            speed += SAMPLE_TIME * acceleration * samples as f64;
        } else {
            let starts = &phases.starts;
            if phases.integrated >= 2 {
                let samples = starts[1] - starts[0];
                sum += self.phase(gains, speed, course.acceleration, starts[0], samples);
                speed += SAMPLE_TIME * course.acceleration * samples as f64;
            }
            if phases.integrated == 3 {
                sum += self.phase(gains, speed, 0.0, starts[1], starts[2] - starts[1]);
            }
        }
        if phases.left_over {
            sum += self.weight(phases.end()) * gains.rate(speed, 0.0);
        }
        SAMPLE_TIME * sum + self.free_value() * self.discount_of_free_travelling(phases)
    }

    /// Σ g·r^n over a phase of constant acceleration.
    #[inline]
    fn phase(&self, gains: &Gains, speed: f64, acceleration: f64, from: usize, samples: usize) -> f64 {
        let weight = if from == self.action_samples { self.action_weight } else { self.weight(from) };
        let sums = self.table.up_to(samples);
        let h = SAMPLE_TIME * acceleration;
        weight
            * (gains.rate(speed, acceleration) * sums.s0
                + h * (gains.progress - 2.0 * gains.speed_discomfort * speed) * sums.s1
                - gains.speed_discomfort * h * h * sums.s2)
    }

    /// 2^(−t/T_δ) when the free travelling starts.
    #[inline]
    fn discount_of_free_travelling(&self, phases: &Phases) -> f64 {
        if phases.integrated == 4 {
            // Within the horizon it starts where the last phase ends.
            let samples = phases.last_sample;
            let whole = phases.starts[3];
            self.weight(whole) * exp_of_small(self.log_ratio * (samples - whole as f64))
        } else if phases.free_from == f64::INFINITY {
            0.0
        } else {
            libm::exp2(-phases.free_from / self.half_life)
        }
    }
}

/// e^x by its series where six terms are exact, which they are for every half-life above 2 s.
#[inline]
fn exp_of_small(x: f64) -> f64 {
    if x.abs() < 0.01 {
        1.0 + x * (1.0 + x / 2.0 * (1.0 + x / 3.0 * (1.0 + x / 4.0 * (1.0 + x / 5.0 * (1.0 + x / 6.0)))))
    } else {
        libm::exp(x)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::sampled;
    use super::*;

    fn closed(
        half_life: f64,
        gains: &Gains,
        action: &ActionPhase,
        course: &AccessCourse,
        regain_time: f64,
    ) -> f64 {
        let discounting = Discounting::new(half_life, 0.5);
        let phases = discounting.phases(course, regain_time);
        let after = discounting.action(gains, action);
        let rest = discounting.after_action(gains, after.speed, course, regain_time, &phases);
        if phases.integrated > 0 { rest + after.value } else { rest }
    }

    fn assert_agrees(
        half_life: f64,
        free_speed: f64,
        action: ActionPhase,
        course: AccessCourse,
        regain_time: f64,
    ) {
        let gains = Gains::for_free_speed(free_speed, 0.5);
        let expected = sampled::future(half_life, 0.5, &gains, &action, &course, regain_time).value;
        let found = closed(half_life, &gains, &action, &course, regain_time);
        assert!(
            (found - expected).abs() <= 1e-9 * expected.abs().max(1.0),
            "{found} is not {expected} for {action:?} {course:?} T_delta {half_life}"
        );
    }

    prop_compose! {
        fn a_course()(
            acceleration in -5.0..5.0,
            duration in prop_oneof![Just(0.0), 0.0..0.05, 0.0..60.0, Just(f64::INFINITY), Just(0.025), Just(0.5)],
            wait in prop_oneof![2 => Just(0.0), 2 => 0.0..100.0, 1 => Just(f64::INFINITY)],
        ) -> AccessCourse {
            AccessCourse { acceleration, duration, wait }
        }
    }

    proptest! {
        #[test]
        fn the_closed_form_is_the_sampled_sum(
            half_life in prop_oneof![0.05..2.0, 5.0..100.0],
            vehicle: bool,
            speed in prop_oneof![Just(0.0), 0.0..15.0],
            acceleration in -5.0..5.0,
            jerk in prop_oneof![Just(0.0), -4.0..4.0],
            course in a_course(),
        ) {
            let (free_speed, regain_time) = if vehicle { (50.0 / 3.6, 10.0) } else { (1.3, 0.5) };
            assert_agrees(half_life, free_speed, ActionPhase { speed, acceleration, jerk }, course, regain_time);
        }
    }

    #[test]
    fn a_future_at_free_speed_is_worth_the_free_value() {
        let gains = Gains::for_free_speed(1.3, 0.5);
        let standing_still = ActionPhase { speed: 1.3, acceleration: 0.0, jerk: 0.0 };
        let course = AccessCourse { acceleration: 0.0, duration: 0.0, wait: 0.0 };
        let value = closed(40.0, &gains, &standing_still, &course, 0.5);
        let free = 40.0 / std::f64::consts::LN_2;
        // The samples are a left Riemann sum, a little above the integral.
        assert!((value / free - 1.0).abs() < 1e-3);
        assert!((gains.rate(1.3, 0.0) - 1.0).abs() < 1e-15);
    }
}
