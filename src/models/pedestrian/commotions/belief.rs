//! Beliefs about what the other will do, from what is good for it and from how it moves (§8.4).

use super::action::ACTIONS;
use super::draws::StandardNormals;
use super::parameters::Parameters;
use super::perception::Percept;
use super::prediction::{BEHAVIOURS, BehaviourAccelerations};
use super::squash::logistic;
use super::variant::{Accumulation, Variant};

/// Something by behaviour and own action.
pub type PerBehaviour = [[f64; ACTIONS]; BEHAVIOURS];

/// How a leaky integral of a value moves in one step: `x ← keep·x + gain·input + noise·N(0,1)`.
#[derive(Clone, Copy, Debug)]
pub struct Leak {
    keep: f64,
    gain: f64,
    noise: Option<f64>,
}

impl Leak {
    /// The leak of value estimates: no memory without evidence accumulation.
    pub fn of_values(variant: &Variant, parameters: &Parameters, dt: f64) -> Self {
        let time = match variant.accumulation {
            Accumulation::Evidence => parameters.evidence_time,
            Accumulation::None | Accumulation::Decision => dt,
        };
        Self {
            keep: 1.0 - dt / time,
            gain: dt / time,
            noise: variant.value_noise.then(|| parameters.value_noise * dt.sqrt()),
        }
    }

    /// One step of all the estimates, one draw each if there is noise.
    #[inline]
    pub fn step(
        &self,
        estimates: &mut [f64; ACTIONS],
        inputs: &[f64; ACTIONS],
        draws: &mut impl StandardNormals,
    ) {
        for (estimate, input) in estimates.iter_mut().zip(inputs) {
            *estimate = self.keep * *estimate + self.gain * input;
        }
        if let Some(noise) = self.noise {
            for estimate in estimates {
                *estimate += noise * draws.next_normal();
            }
        }
    }
}

/// How observations of the other's movement become evidence.
#[derive(Clone, Copy, Debug)]
struct Observing {
    keep: f64,
    gain: f64,
    deviation: f64,
    /// ln of the density at no deviation.
    log_peak: f64,
    dt: f64,
}

impl Observing {
    fn new(parameters: &Parameters, dt: f64) -> Self {
        let deviation = parameters.observation_deviation;
        Self {
            keep: 1.0 - dt / parameters.observation_forgetting_time,
            gain: dt / parameters.observation_sampling_time,
            deviation,
            log_peak: -libm::log(deviation * (2.0 * std::f64::consts::PI).sqrt()),
            dt,
        }
    }

    /// ln max(p, ε) of having moved from `before` with `acceleration` to `distance`; p = 0 if the behaviour was invalid.
    fn log_likelihood(&self, before: &Percept, acceleration: Option<f64>, distance: f64) -> f64 {
        let floor = libm::log(f64::EPSILON);
        let Some(acceleration) = acceleration else { return floor };
        let expected = before.distance - before.speed * self.dt - acceleration * (self.dt * self.dt) / 2.0;
        let surprise = (distance - expected) / self.deviation;
        (self.log_peak - surprise * surprise / 2.0).max(floor)
    }
}

/// Beliefs about the other's behaviour, and the evidence for them.
#[derive(Clone, Debug)]
pub struct Beliefs {
    leak: Leak,
    value_weight: Option<f64>,
    observation: Option<(f64, Observing)>,
    /// Â_V by behaviour and own action.
    value_evidence: PerBehaviour,
    /// Â_O by behaviour.
    observation_evidence: [f64; BEHAVIOURS],
    /// What was perceived and expected in the step before.
    before: Option<(Percept, BehaviourAccelerations)>,
}

impl Beliefs {
    /// No evidence yet.
    pub fn new(variant: &Variant, parameters: &Parameters, dt: f64) -> Self {
        Self {
            leak: Leak::of_values(variant, parameters, dt),
            value_weight: variant.value_beliefs.then_some(parameters.value_belief_weight),
            observation: variant
                .observation_beliefs
                .then(|| (parameters.observation_belief_weight, Observing::new(parameters, dt))),
            value_evidence: [[0.0; ACTIONS]; BEHAVIOURS],
            observation_evidence: [0.0; BEHAVIOURS],
            before: None,
        }
    }

    /// P(b|j) of every behaviour and own action, after one step of evidence: what was perceived, the
    /// accelerations of the valid behaviours, and W(b|j), the value of each for the other.
    pub fn update(
        &mut self,
        percept: &Percept,
        accelerations: &BehaviourAccelerations,
        values: &PerBehaviour,
        draws: &mut impl StandardNormals,
    ) -> PerBehaviour {
        let mut activations = [[0.0; ACTIONS]; BEHAVIOURS];
        for b in 0..BEHAVIOURS {
            if accelerations[b].is_none() {
                self.value_evidence[b] = [0.0; ACTIONS];
                self.observation_evidence[b] = 0.0;
                continue;
            }
            if let Some(weight) = self.value_weight {
                self.leak.step(&mut self.value_evidence[b], &values[b], draws);
                activations[b] = self.value_evidence[b].map(|evidence| weight * evidence);
            }
            if let Some((weight, observing)) = &self.observation {
                let evidence = &mut self.observation_evidence[b];
                *evidence *= observing.keep;
                if let Some((before, expected)) = &self.before {
                    *evidence +=
                        observing.gain * observing.log_likelihood(before, expected[b], percept.distance);
                }
                for activation in &mut activations[b] {
                    *activation += weight * *evidence;
                }
            }
        }
        self.before = Some((*percept, *accelerations));
        probabilities(accelerations, &activations)
    }

    /// Forgets what is good for the other, as acting does with `oEA` (§8.6).
    pub fn forget_values(&mut self) {
        self.value_evidence = [[0.0; ACTIONS]; BEHAVIOURS];
    }
}

/// Softmax over the valid behaviours, of which there are one, or the two orders of passing.
fn probabilities(accelerations: &BehaviourAccelerations, activations: &PerBehaviour) -> PerBehaviour {
    let mut result = [[0.0; ACTIONS]; BEHAVIOURS];
    match accelerations {
        [_, Some(_), Some(_)] => {
            let mut odds = [0.0; ACTIONS];
            for j in 0..ACTIONS {
                odds[j] = activations[1][j] - activations[2][j];
            }
            result[1] = logistic(&odds);
            result[2] = logistic(&odds.map(|odd| -odd));
        }
        only => {
            for (row, acceleration) in result.iter_mut().zip(only) {
                if acceleration.is_some() {
                    *row = [1.0; ACTIONS];
                }
            }
        }
    }
    result
}
