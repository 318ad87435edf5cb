//! The cost of looming: how fast the other grows in the eye on an anticipated collision course (§7.1).

use super::state::Body;
use super::value::{ActionPhase, Discounting, Phases, SAMPLE_TIME};

/// Samples worked on together.
const BLOCK: usize = 64;

/// What looming costs one individual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoomingCost {
    /// Optical expansion rate at which the cost begins (rad/s).
    pub onset: f64,
    /// Optical expansion rate whose cost cancels travelling freely (rad/s).
    pub full: f64,
}

/// The anticipated movement of the one who looks.
#[derive(Clone, Copy, Debug)]
pub struct OwnTrack<'a> {
    /// Distance now (m).
    pub distance: f64,
    /// Its extent.
    pub body: &'a Body,
    /// Its action.
    pub action: &'a ActionPhase,
    /// Acceleration of the achieve phase (m/s²).
    pub achieve: f64,
    /// The phases.
    pub phases: &'a Phases,
    /// Free speed (m/s).
    pub free_speed: f64,
    /// Time to regain it (s).
    pub regain_time: f64,
}

/// The anticipated movement of the one looked at.
#[derive(Clone, Copy, Debug)]
pub struct OtherTrack<'a> {
    /// Distance now (m).
    pub distance: f64,
    /// Speed now (m/s).
    pub speed: f64,
    /// Its extent.
    pub body: &'a Body,
    /// Acceleration of the first sample (m/s²).
    pub first_acceleration: f64,
    /// Acceleration of every later sample (m/s²).
    pub later_acceleration: f64,
}

/// One block of samples.
struct Block {
    own_distance: [f64; BLOCK],
    own_speed: [f64; BLOCK],
    other_distance: [f64; BLOCK],
    other_speed: [f64; BLOCK],
}

impl Discounting {
    /// The looming part of the value: never positive.
    pub fn looming(&self, cost: &LoomingCost, own: &OwnTrack, other: &OtherTrack) -> f64 {
        let samples = own.phases.end() + usize::from(own.phases.left_over);
        let mut block = Block {
            own_distance: [0.0; BLOCK],
            own_speed: [0.0; BLOCK],
            other_distance: [0.0; BLOCK],
            other_speed: [0.0; BLOCK],
        };
        let (mut d, mut u) = (own.distance, own.action.speed);
        let (mut e, mut w_sum) = (other.distance, other.speed);
        let stands = own.phases.stands_while_waiting();
        let starts = &own.phases.starts;
        let (mut regain, mut regain_from) = (0.0, usize::MAX);
        let mut sum = 0.0;
        let mut start = 0;
        while start < samples {
            let count = BLOCK.min(samples - start);
            for l in 0..count {
                let n = start + l;
                let integrated = own.phases.integrated;
                if integrated == 4 && n == starts[1] {
                    if stands {
                        u = 0.0;
                    }
                    regain = (own.free_speed - u) / own.regain_time;
                    regain_from = starts[2];
                }
                let a = if n < starts[0] {
                    own.action.acceleration + own.action.jerk * (n as f64 * SAMPLE_TIME)
                } else if integrated >= 2 && n < starts[1] {
                    own.achieve
                } else if n >= regain_from && n < starts[3] {
                    regain
                } else {
                    0.0
                };
                block.own_distance[l] = d;
                block.own_speed[l] = u;
                d = d - u * SAMPLE_TIME - a * (SAMPLE_TIME * SAMPLE_TIME) / 2.0;
                u += SAMPLE_TIME * a;
                let w = if w_sum > 0.0 { w_sum } else { 0.0 };
                block.other_distance[l] = e;
                block.other_speed[l] = w;
                e -= w * SAMPLE_TIME;
                let b = if n == 0 { other.first_acceleration } else { other.later_acceleration };
                w_sum += SAMPLE_TIME * b;
            }
            for l in 0..count {
                sum += self.weight(start + l)
                    * excess(
                        block.own_distance[l],
                        block.own_speed[l],
                        block.other_distance[l],
                        block.other_speed[l],
                        own.body.half_extent,
                        other.body.half_extent,
                        other.body.width,
                        cost.onset,
                    );
            }
            start += BLOCK;
        }
        -SAMPLE_TIME * sum / (cost.full - cost.onset)
    }
}

/// How far the optical expansion rate is above the onset; 0 off a collision course.
#[inline]
#[allow(clippy::too_many_arguments)]
fn excess(
    d: f64,
    u: f64,
    e: f64,
    w: f64,
    own_half_extent: f64,
    other_half_extent: f64,
    width: f64,
    onset: f64,
) -> f64 {
    let own_entry = (d - own_half_extent) / u;
    let own_exit = (d + own_half_extent) / u;
    let other_entry = (e - other_half_extent) / w;
    let other_exit = (e + other_half_extent) / w;
    let hit = (own_entry < other_entry && other_entry < own_exit && other_entry > 0.0)
        || (other_entry < own_entry && own_entry < other_exit && own_entry > 0.0)
        || (own_entry == other_entry && own_entry > 0.0);
    if !hit {
        return 0.0;
    }
    let range_squared = d * d + e * e;
    let rate = (width / range_squared.sqrt()) * (d * u + e * w) / (range_squared + width * width / 4.0);
    (rate - onset).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::super::access::{Course, Manner};
    use super::super::sampled;
    use super::super::state::Control;
    use super::super::value::Gains;
    use super::*;
    use proptest::prelude::*;

    const PEDESTRIAN: Body = Body { control: Control::Speed, half_extent: 1.3, width: 0.8 };
    const VEHICLE: Body = Body { control: Control::Acceleration, half_extent: 2.5, width: 1.8 };

    prop_compose! {
        fn a_course()(
            acceleration in -5.0..5.0,
            duration in prop_oneof![Just(0.0), 0.0..20.0, Just(f64::INFINITY)],
            wait in prop_oneof![2 => Just(0.0), 2 => 0.0..100.0, 1 => Just(f64::INFINITY)],
        ) -> Course {
            Course { acceleration, duration, wait }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn looming_is_the_sampled_sum(
            half_life in 5.0..100.0f64,
            onset in prop_oneof![Just(0.0), 0.0..0.1],
            is_vehicle: bool,
            (distance, other_distance) in (-8.0..80.0, -8.0..80.0),
            speed in prop_oneof![Just(0.0), 0.0..15.0],
            other_speed in prop_oneof![Just(0.0), 0.0..15.0],
            (acceleration, jerk) in (-5.0..5.0, -4.0..4.0),
            first_acceleration in prop_oneof![Just(0.0), -4.0..4.0],
            later_acceleration in prop_oneof![Just(0.0), -4.0..4.0],
            course in a_course(),
        ) {
            let (body, other_body) = if is_vehicle { (VEHICLE, PEDESTRIAN) } else { (PEDESTRIAN, VEHICLE) };
            let free_speed = if is_vehicle { 50.0 / 3.6 } else { 1.3 };
            let gains = Gains::for_free_speed(free_speed, 0.5);
            let regain_time = Manner::regain_time(body.control, 0.5);
            let cost = LoomingCost { onset, full: onset + 0.01 };
            let action = ActionPhase { speed, acceleration, jerk: if is_vehicle { jerk } else { 0.0 } };
            let other = OtherTrack {
                distance: other_distance,
                speed: other_speed,
                body: &other_body,
                first_acceleration,
                later_acceleration,
            };
            let samples = sampled::future(half_life, 0.5, &gains, &action, &course, regain_time);
            let expected = sampled::looming(&samples, &cost, distance, &body, &other);
            let discounting = Discounting::new(half_life, 0.5);
            let phases = discounting.phases(&course, regain_time);
            let own = OwnTrack {
                distance,
                body: &body,
                action: &action,
                achieve: course.acceleration,
                phases: &phases,
                free_speed: gains.free_speed(),
                regain_time,
            };
            let found = discounting.looming(&cost, &own, &other);
            prop_assert!((found - expected).abs() <= 1e-9 * expected.abs().max(1.0), "{found} is not {expected}");
        }
    }
}
