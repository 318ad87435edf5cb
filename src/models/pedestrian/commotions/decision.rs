//! From values to an action: evidence and decisions accumulate until one passes its threshold (§8.5, §8.6).

use super::action::{ACTIONS, NO_ACTION};
use super::belief::Leak;
use super::draws::StandardNormals;
use super::parameters::Parameters;
use super::variant::{Accumulation, Variant};

/// What an agent has come to think of its actions.
#[derive(Clone, Debug)]
pub struct Decider {
    accumulation: Accumulation,
    leak: Leak,
    /// The surplus (or accumulated surplus) at which an action is taken.
    threshold: f64,
    dt: f64,
    /// V̂ per action.
    estimates: [f64; ACTIONS],
    /// ξ per action.
    accumulated: [f64; ACTIONS],
}

impl Decider {
    /// Nothing thought of yet. `saturated_free_value` is tanh(V_free/V_0).
    pub fn new(variant: &Variant, parameters: &Parameters, saturated_free_value: f64, dt: f64) -> Self {
        Self {
            accumulation: variant.accumulation,
            leak: Leak::of_values(variant, parameters, dt),
            threshold: match variant.accumulation {
                Accumulation::None => 0.0,
                Accumulation::Evidence => saturated_free_value * parameters.evidence_threshold,
                Accumulation::Decision => parameters.decision_threshold,
            },
            dt,
            estimates: [0.0; ACTIONS],
            accumulated: [0.0; ACTIONS],
        }
    }

    /// V̂ per action.
    pub fn estimates(&self) -> &[f64; ACTIONS] {
        &self.estimates
    }

    /// What speaks for each action, which is taken above the threshold: the surplus of its estimate over that of no new action, or what of
    /// that has accumulated (`oDA`, s); with the threshold.
    pub fn evidence(&self) -> ([f64; ACTIONS], f64) {
        let surplus = || self.estimates.map(|estimate| estimate - self.estimates[NO_ACTION]);
        let evidence = match self.accumulation {
            Accumulation::None | Accumulation::Evidence => surplus(),
            Accumulation::Decision => self.accumulated,
        };
        (evidence, self.threshold)
    }

    /// Whether acting resets what was thought before it (`oEA`).
    pub fn forgets_by_acting(&self) -> bool {
        self.accumulation == Accumulation::Evidence
    }

    /// Nothing is thought of the actions any more.
    pub fn clear(&mut self) {
        self.estimates = [0.0; ACTIONS];
        self.accumulated = [0.0; ACTIONS];
    }

    /// One step with the expected value of each action; the action to take, if any.
    pub fn decide(&mut self, values: &[f64; ACTIONS], draws: &mut impl StandardNormals) -> Option<usize> {
        self.leak.step(&mut self.estimates, values, draws);
        let standing_pat = self.estimates[NO_ACTION];
        let surplus = self.estimates.map(|estimate| estimate - standing_pat);
        match self.accumulation {
            Accumulation::None | Accumulation::Evidence => {
                let best = first_of_largest(&surplus);
                let acts = surplus[best] > self.threshold;
                if acts && self.accumulation == Accumulation::Evidence {
                    self.estimates = [0.0; ACTIONS];
                }
                acts.then_some(best)
            }
            Accumulation::Decision => {
                for (accumulated, surplus) in self.accumulated.iter_mut().zip(&surplus) {
                    let sum = *accumulated + self.dt * surplus;
                    *accumulated = if sum < 0.0 { 0.0 } else { sum };
                }
                let best = first_of_largest(&self.accumulated);
                let acts = self.accumulated[best] > self.threshold;
                if acts {
                    self.accumulated = [0.0; ACTIONS];
                }
                acts.then_some(best)
            }
        }
    }
}

fn first_of_largest(values: &[f64; ACTIONS]) -> usize {
    let mut best = 0;
    for j in 1..ACTIONS {
        if values[j] > values[best] {
            best = j;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pedestrian::commotions::draws::RecordedDraws;

    fn decider(variant: &str) -> Decider {
        let parameters = Parameters {
            evidence_time: 0.2,
            evidence_threshold: 0.1,
            decision_threshold: 0.05,
            ..Parameters::default()
        };
        Decider::new(&variant.parse().unwrap(), &parameters, 0.5, 0.1)
    }

    #[test]
    fn without_accumulation_the_best_of_the_moment_is_taken() {
        let mut plain = decider("oVA");
        let none = &mut RecordedDraws::new(&[]);
        assert_eq!(plain.decide(&[0.1, 0.3, 0.2, 0.3, 0.0], none), Some(1));
        assert_eq!(plain.decide(&[0.1; 5], none), None);
    }

    #[test]
    fn evidence_takes_time_and_is_reset_by_acting() {
        let mut evidence = decider("oVAoEA");
        let none = &mut RecordedDraws::new(&[]);
        let values = [0.0, 0.0, 0.0, 0.0, 0.08];
        // Half of the value the first step, three quarters after the second: 0.06 > 0.5 · 0.1.
        assert_eq!(evidence.decide(&values, none), None);
        assert!((evidence.estimates()[4] - 0.04).abs() < 1e-15);
        let (surplus, threshold) = evidence.evidence();
        assert!((surplus[4] - 0.04).abs() < 1e-15 && (threshold - 0.05).abs() < 1e-15, "{surplus:?}");
        assert_eq!(evidence.decide(&values, none), Some(4));
        assert_eq!(evidence.estimates(), &[0.0; 5]);
    }

    #[test]
    fn decisions_accumulate_surplus_without_resetting_values() {
        let mut decision = decider("oVAoDA");
        let none = &mut RecordedDraws::new(&[]);
        let values = [0.0, 0.0, 0.0, 0.3, 0.2];
        assert_eq!(decision.decide(&values, none), None);
        assert_eq!(decision.evidence(), ([0.0, 0.0, 0.0, 0.1 * 0.3, 0.1 * 0.2], 0.05));
        assert_eq!(decision.decide(&values, none), Some(3));
        assert_eq!(decision.evidence().0, [0.0; 5]);
        assert_eq!(decision.estimates(), &values);
        assert_eq!(decision.decide(&values, none), None);
    }

    #[test]
    fn value_noise_draws_once_per_action() {
        let mut noisy = decider("oVAoAN");
        let mut draws = RecordedDraws::new(&[0.0, 0.0, 0.0, 1.0, 0.0]);
        assert_eq!(noisy.decide(&[0.0; 5], &mut draws), Some(3));
        assert!(draws.is_used_up());
    }
}
