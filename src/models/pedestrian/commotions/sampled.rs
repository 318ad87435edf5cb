//! The published sampling of a future, one sample at a time: the oracle of the closed form and of looming.

use super::access::AccessCourse;
use super::looming::{LoomingCost, OtherTrack};
use super::state::AgentBody;
use super::value::{ActionPhase, Gains, SAMPLE_TIME};

/// The samples of a future, and its value without looming and priority.
pub struct Samples {
    speeds: Vec<f64>,
    accelerations: Vec<f64>,
    half_life: f64,
    pub value: f64,
}

/// Samples a future (§7).
pub fn future(
    half_life: f64,
    action_duration: f64,
    gains: &Gains,
    action: &ActionPhase,
    course: &AccessCourse,
    regain_time: f64,
) -> Samples {
    let achieve = if course.duration == 0.0 { 0.0 } else { course.duration.max(SAMPLE_TIME) };
    let mut s = [0.0; 5];
    for (p, length) in [action_duration, achieve, course.wait, regain_time].into_iter().enumerate() {
        s[p + 1] = s[p] + length;
    }
    // Phases 0..last are integrated.
    let integrated = s.iter().position(|&t| t > 6.0 * half_life).map_or(4, |j| j - 1);
    let end = s[integrated];
    let count = (end / SAMPLE_TIME).ceil() as usize;
    let index = |p: usize| (s[p] / SAMPLE_TIME).floor() as usize;
    let mut accelerations = vec![0.0; count];
    if integrated > 0 {
        for (n, a) in accelerations[..index(1)].iter_mut().enumerate() {
            *a = action.acceleration + action.jerk * (n as f64 * SAMPLE_TIME);
        }
    }
    if integrated > 1 {
        accelerations[index(1)..index(2)].fill(course.acceleration);
    }
    if integrated == 4 {
        let before: f64 = accelerations[..index(2)].iter().sum();
        let speed = if course.wait > 0.0 { 0.0 } else { action.speed + SAMPLE_TIME * before };
        accelerations[index(3)..index(4)].fill((gains.free_speed() - speed) / regain_time);
    }
    let mut speeds = Vec::with_capacity(count);
    let mut speed = action.speed;
    for a in &accelerations {
        speeds.push(speed);
        speed += SAMPLE_TIME * a;
    }
    if integrated == 4 && course.wait > 0.0 {
        let at_wait = speeds[index(2)];
        speeds[index(2)..].iter_mut().for_each(|u| *u -= at_wait);
    }
    let moving: f64 = (0..count)
        .map(|n| SAMPLE_TIME * gains.rate(speeds[n], accelerations[n]) * discount(n, half_life))
        .sum();
    let free = half_life / std::f64::consts::LN_2;
    Samples { value: moving + free * (-s[4] / half_life).exp2(), speeds, accelerations, half_life }
}

fn discount(sample: usize, half_life: f64) -> f64 {
    (-(sample as f64) * SAMPLE_TIME / half_life).exp2()
}

/// The looming part of that future (§7.1).
pub fn looming(
    samples: &Samples,
    cost: &LoomingCost,
    distance: f64,
    body: &AgentBody,
    other: &OtherTrack,
) -> f64 {
    let (mut d, mut e, mut w_sum) = (distance, other.distance, other.speed);
    let mut sum = 0.0;
    for (n, (&u, &a)) in samples.speeds.iter().zip(&samples.accelerations).enumerate() {
        let w = w_sum.max(0.0);
        let own = ((d - body.half_extent) / u, (d + body.half_extent) / u);
        let their = ((e - other.body.half_extent) / w, (e + other.body.half_extent) / w);
        let collides = (own.0 < their.0 && their.0 < own.1 && their.0 > 0.0)
            || (their.0 < own.0 && own.0 < their.1 && own.0 > 0.0)
            || (own.0 == their.0 && own.0 > 0.0);
        if collides {
            // By where the two are in the plane, the conflict point in its origin.
            let way = |angle: f64| nalgebra::Vector2::new(libm::cos(angle), libm::sin(angle));
            let (own_way, their_way) = (way(0.0), way(libm::acos(other.body.cosine)));
            let apart = their_way * -e - own_way * -d;
            let (range, width) = (apart.norm(), other.body.width);
            let closing = -apart.dot(&(their_way * w - own_way * u)) / range;
            let rate = width * closing / (range * range + width * width / 4.0);
            sum += SAMPLE_TIME * (rate - cost.onset).max(0.0) * discount(n, samples.half_life);
        }
        d = d - u * SAMPLE_TIME - a * SAMPLE_TIME * SAMPLE_TIME / 2.0;
        e -= w * SAMPLE_TIME;
        w_sum += SAMPLE_TIME * if n == 0 { other.first_acceleration } else { other.later_acceleration };
    }
    -sum / (cost.full - cost.onset)
}
