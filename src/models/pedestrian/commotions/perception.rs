//! How the other is perceived: exactly, noisily, or through a Kalman filter from which each percept is a random draw (§3).

use nalgebra::{Matrix2, Vector2};

use super::draws::StandardNormals;
use super::parameters::Parameters;
use super::state::{State, at_least_zero};
use super::variant::{Sensing, Variant};

/// The other as perceived: distance (m) and speed (m/s, ≥ 0).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Percept {
    /// Distance to the conflict point, d̂.
    pub distance: f64,
    /// Speed, v̂.
    pub speed: f64,
}

/// What is known of the other's movement: a Kalman filter on its distance and speed.
#[derive(Clone, Debug, PartialEq)]
struct Filter {
    mean: Vector2<f64>,
    covariance: Matrix2<f64>,
    process_variance: f64,
}

impl Filter {
    /// Predicts by `dt` and corrects by the observed distance `z` of variance `observation_variance`.
    ///
    /// The roundings are those of the published results (§6, knife edge): one fused multiply-add per entry
    /// of the products with F, and nothing else fused.
    fn observe(&mut self, z: f64, observation_variance: f64, dt: f64) {
        let (x, p) = (&self.mean, &self.covariance);
        let predicted = Vector2::new(x[0] + -dt * x[1], x[1]);
        let moved = Matrix2::new(
            (-dt).mul_add(p[(1, 0)], p[(0, 0)]),
            (-dt).mul_add(p[(1, 1)], p[(0, 1)]),
            p[(1, 0)],
            p[(1, 1)],
        );
        let spread = Matrix2::new(
            (-dt).mul_add(moved[(0, 1)], moved[(0, 0)]),
            moved[(0, 1)],
            (-dt).mul_add(moved[(1, 1)], moved[(1, 0)]),
            moved[(1, 1)] + self.process_variance,
        );
        let innovation_variance = spread[(0, 0)] + observation_variance;
        let gain = Vector2::new(spread[(0, 0)] / innovation_variance, spread[(1, 0)] / innovation_variance);
        let innovation = z - predicted[0];
        self.mean = Vector2::new(predicted[0] + gain[0] * innovation, predicted[1] + gain[1] * innovation);
        let kept = 1.0 - gain[0];
        self.covariance = Matrix2::new(
            kept * spread[(0, 0)],
            kept * spread[(0, 1)],
            -gain[1] * spread[(0, 0)] + spread[(1, 0)],
            -gain[1] * spread[(0, 1)] + spread[(1, 1)],
        );
    }

    /// A random draw from what is known; the filter itself is not changed by it.
    fn draw(&self, draws: &mut impl StandardNormals) -> Percept {
        let (x, p) = (&self.mean, &self.covariance);
        // Plain comparisons: `max` would turn a NaN into 0 and hide the error.
        let c1 = at_least_zero_or_nan(p[(0, 0)]).sqrt();
        let c2 = if c1 == 0.0 { 0.0 } else { p[(1, 0)] / c1 };
        let c3 = at_least_zero_or_nan(p[(1, 1)] - c2 * c2).sqrt();
        let first = draws.next_normal();
        let second = draws.next_normal();
        Percept { distance: x[0] + c1 * first, speed: (x[1] + c2 * first) + c3 * second }
    }
}

fn square(x: f64) -> f64 {
    x * x
}

fn at_least_zero_or_nan(x: f64) -> f64 {
    if x < 0.0 { 0.0 } else { x }
}

/// The senses of one agent during one encounter.
#[derive(Clone, Debug)]
pub struct AgentPerception {
    sensing: Sensing,
    filter: Option<Filter>,
    /// Standard deviation of the distance noise (m) for constant noise.
    distance_noise: f64,
    /// Angular noise (rad).
    angular_noise: f64,
    eye_height: f64,
    last_observed: Option<f64>,
    dt: f64,
}

impl AgentPerception {
    /// The senses before an encounter with someone whose assumed free speed is `assumed_speed` (m/s).
    ///
    /// The true distance of the other at the first step becomes the other half of the filter's prior.
    pub fn new(variant: &Variant, parameters: &Parameters, dt: f64, assumed_speed: f64) -> Self {
        let filter = variant.perceptual_filtering.then(|| Filter {
            mean: Vector2::new(0.0, assumed_speed),
            covariance: Matrix2::new(0.0, 0.0, 0.0, square(2.0 * assumed_speed)),
            process_variance: square(parameters.process_noise),
        });
        let scale = if filter.is_some() { 1.0 } else { parameters.unfiltered_noise_scale };
        Self {
            sensing: variant.sensing,
            filter,
            distance_noise: scale * parameters.distance_noise,
            angular_noise: scale * parameters.angular_noise,
            eye_height: parameters.eye_height,
            last_observed: None,
            dt,
        }
    }

    /// Perceives the other at its true distance and speed from one's own true distance. `apart` is the true distance between the two
    /// (m), unless their paths meet at a right angle: then it follows from the others.
    ///
    /// Draws, per step: the observation, then with filtering the two of the percept; none if exact.
    pub fn perceive(
        &mut self,
        own_distance: f64,
        State { distance, speed, .. }: State,
        apart: Option<f64>,
        draws: &mut impl StandardNormals,
    ) -> Percept {
        let noise = match self.sensing {
            Sensing::Exact => return Percept { distance, speed: at_least_zero(speed) },
            Sensing::ConstantNoise => self.distance_noise,
            Sensing::AngularNoise => self.noise_of_angle(own_distance, distance, apart),
        };
        let observed = distance + noise * draws.next_normal();
        let percept = match &mut self.filter {
            Some(filter) => {
                if self.last_observed.is_none() {
                    filter.mean[0] = distance;
                    filter.covariance[(0, 0)] = square(2.0 * distance);
                }
                filter.observe(observed, noise * noise, self.dt);
                filter.draw(draws)
            }
            None => Percept {
                distance: observed,
                speed: self.last_observed.map_or(0.0, |last| -(observed - last) / self.dt),
            },
        };
        self.last_observed = Some(observed);
        Percept { distance: percept.distance, speed: if percept.speed < 0.0 { 0.0 } else { percept.speed } }
    }

    /// The standard deviation (m) that the angular noise means at this distance.
    fn noise_of_angle(&self, own_distance: f64, distance: f64, apart: Option<f64>) -> f64 {
        if distance == 0.0 {
            return 0.0;
        }
        let at_right_angle = || (own_distance * own_distance + distance * distance).sqrt();
        let range = apart.unwrap_or_else(at_right_angle);
        let h = self.eye_height;
        let angle = libm::atan(h / range) + self.angular_noise;
        let noise = distance.abs() * (1.0 - h / (range * libm::tan(angle)));
        if noise < 0.0 { 0.0 } else { noise }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pedestrian::commotions::draws::RecordedDraws;

    fn senses(variant: &str, change: impl Fn(&mut Parameters)) -> AgentPerception {
        let mut parameters = Parameters::default();
        change(&mut parameters);
        AgentPerception::new(&variant.parse().unwrap(), &parameters, 0.025, 50.0 / 3.6)
    }

    fn seen(distance: f64, speed: f64) -> State {
        State { distance, speed, acceleration: 0.0 }
    }

    #[test]
    fn exact_senses_draw_nothing() {
        let mut draws = RecordedDraws::new(&[]);
        let percept = senses("oVA", |_| ()).perceive(3.0, seen(20.0, 8.0), None, &mut draws);
        assert_eq!(percept, Percept { distance: 20.0, speed: 8.0 });
        assert!(draws.is_used_up());
    }

    #[test]
    fn without_a_filter_speed_is_the_change_of_what_is_seen() {
        let mut senses = senses("oVAoSNc", |p| p.distance_noise = 100.0);
        let mut draws = RecordedDraws::new(&[0.0, -1.0, 3.0]);
        assert_eq!(senses.perceive(3.0, seen(20.0, 8.0), None, &mut draws).speed, 0.0);
        // c_tau makes the noise 0.1 m.
        let second = senses.perceive(3.0, seen(19.8, 8.0), None, &mut draws);
        assert!((second.distance - 19.7).abs() < 1e-12 && (second.speed - 12.0).abs() < 1e-9);
        // Seen further away than before: the speed is clipped.
        assert_eq!(senses.perceive(3.0, seen(19.6, 8.0), None, &mut draws).speed, 0.0);
        assert!(draws.is_used_up());
    }

    #[test]
    fn angular_noise_grows_with_distance_and_vanishes_at_the_conflict_point() {
        let senses = senses("oVAoSNvoPF", |p| p.angular_noise = 0.01);
        let noise = |distance| senses.noise_of_angle(3.0, distance, None);
        assert!(noise(10.0) < noise(20.0) && noise(20.0) < noise(80.0));
        assert_eq!(noise(0.0), 0.0);
        assert_eq!(senses.noise_of_angle(0.0, 0.0, None), 0.0);
        let away = f64::hypot(3.0, 20.0);
        assert_eq!(senses.noise_of_angle(3.0, 20.0, Some(away)), noise(20.0));
        assert!(senses.noise_of_angle(3.0, 20.0, Some(2.0 * away)) > noise(20.0));
    }

    #[test]
    fn the_filter_learns_distance_and_speed_under_constant_noise() {
        let mut senses = senses("oVAoSNcoPF", |p| p.distance_noise = 1.0);
        let mut draws = numbers::random::Stream::seeded(5);
        let mut percept = Percept::default();
        for k in 0..240 {
            percept = senses.perceive(3.0, seen(60.0 - 10.0 * 0.025 * f64::from(k), 10.0), None, &mut draws);
        }
        assert!((percept.distance - 0.25).abs() < 1.5 && (percept.speed - 10.0).abs() < 2.5, "{percept:?}");
        let filter = senses.filter.unwrap();
        assert!((filter.mean[1] - 10.0).abs() < 1.5, "{}", filter.mean);
        // A drawn percept leaves the filter alone, and draws three per step: here none is left over.
        let p = filter.covariance;
        assert!(p[(0, 0)] > 0.0 && p[(1, 1)] > 0.0 && (p[(0, 1)] - p[(1, 0)]).abs() < 1e-9);
    }

    #[test]
    fn a_percept_of_something_impossible_stays_not_a_number() {
        let mut senses = senses("oVAoSNvoPF", |p| p.angular_noise = f64::NAN);
        let percept = senses.perceive(3.0, seen(20.0, 8.0), None, &mut RecordedDraws::new(&[0.0; 3]));
        assert!(percept.distance.is_nan());
    }
}
