//! One road user that behaves like a person: stepped by what both publish, it answers with an acceleration (§2, §8).

use super::access::access_orders;
use super::action::{ACTIONS, ActionPlan, NO_ACTION};
pub use super::affordance::Rules;
use super::affordance::{Move, Orders, Party, Valuation};
use super::belief::{Beliefs, PerBehaviour};
use super::decision::Decider;
use super::draws::StandardNormals;
use super::parameters::Parameters;
use super::perception::{Percept, Perception};
use super::prediction::{
    BEHAVIOUR_LIST, BEHAVIOURS, BehaviourAccelerations, PredictedState, behaviours, predict_other,
};
use super::squash::tanh_in_place;
use super::state::{Body, Control, State};
use super::timing::Passage;
use super::variant::Variant;

/// Who meets whom, and how time goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encounter {
    /// The agent's own body.
    pub own: Body,
    /// The other's body.
    pub other: Body,
    /// Time step (s).
    pub dt: f64,
}

/// What an agent does at a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Acceleration from now to the next step (m/s²).
    pub acceleration: f64,
    /// The action taken, if any.
    pub action: Option<usize>,
}

/// What went on in an agent's mind at its last decision, for inspection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thoughts {
    /// The other as perceived.
    pub percept: Percept,
    /// P(b|j).
    pub probabilities: PerBehaviour,
    /// V̂ per action.
    pub estimates: [f64; ACTIONS],
}

/// A road user that perceives, believes, values and acts.
#[derive(Clone, Debug)]
pub struct Agent {
    estimates_behaviour: bool,
    anticipates_influence: bool,
    action_duration: f64,
    own: Party,
    other: Party,
    valuation: Valuation,
    plan: ActionPlan,
    perception: Perception,
    beliefs: Beliefs,
    decider: Decider,
    thoughts: Option<Thoughts>,
}

impl Agent {
    /// An individual of a variant at the start of an encounter.
    pub fn new(variant: &Variant, parameters: &Parameters, encounter: &Encounter) -> Self {
        let Encounter { own, other, dt } = *encounter;
        let valuation = Valuation::new(variant, parameters);
        let saturated_free_value = libm::tanh(valuation.discounting.free_value() / valuation.scale);
        let other_speed = Party::wanted_speed(other.control, parameters);
        Self {
            estimates_behaviour: variant.estimates_behaviour(),
            anticipates_influence: variant.anticipated_influence,
            action_duration: parameters.action_duration,
            own: Party::new(own, parameters),
            other: Party::new(other, parameters),
            valuation,
            plan: ActionPlan::new(own.control, parameters.action_duration, dt),
            perception: Perception::new(variant, parameters, dt, other_speed),
            beliefs: Beliefs::new(variant, parameters, dt),
            decider: Decider::new(variant, parameters, saturated_free_value, dt),
            thoughts: None,
        }
    }

    /// The free speed (m/s) the agent wants.
    pub fn free_speed(&self) -> f64 {
        self.own.manner.free_speed
    }

    /// What went on at the last decision; `None` when the last step needed none.
    pub fn thoughts(&self) -> Option<&Thoughts> {
        self.thoughts.as_ref()
    }

    /// One step: what to do, given what both publish.
    ///
    /// Once out of the conflict space the agent neither perceives (draws no noise) nor decides.
    pub fn step(
        &mut self,
        own: &State,
        other: &State,
        rules: &Rules,
        draws: &mut impl StandardNormals,
    ) -> Decision {
        if own.distance < -self.own.body.half_extent {
            self.thoughts = None;
            return Decision { acceleration: 0.0, action: None };
        }
        self.plan.begin_step(own.speed);
        let percept = self.perception.perceive(own.distance, other.distance, other.speed, draws);
        let accelerations = self.behaviours(own, &percept);
        let perceived =
            State { distance: percept.distance, speed: percept.speed, acceleration: other.acceleration };
        let (values, others_values) = self.values(own, &perceived, &accelerations, rules);
        let probabilities = self.beliefs.update(&percept, &accelerations, &others_values, draws);
        let mut expected = [0.0; ACTIONS];
        for b in 0..BEHAVIOURS {
            for j in 0..ACTIONS {
                expected[j] += probabilities[b][j] * values[b][j];
            }
        }
        let action = self.decider.decide(&expected, draws);
        if let Some(j) = action {
            self.plan.take(j);
            if self.decider.forgets_by_acting() {
                self.beliefs.forget_values();
            }
        }
        self.thoughts = Some(Thoughts { percept, probabilities, estimates: *self.decider.estimates() });
        Decision { acceleration: self.plan.end_step(), action }
    }

    /// What the other may do (§8.1).
    fn behaviours(&self, own: &State, percept: &Percept) -> BehaviourAccelerations {
        behaviours(self.estimates_behaviour, || {
            let with_acceleration =
                self.valuation.other_acceleration && self.own.body.control == Control::Acceleration;
            let passage = Passage::of(own, self.own.body.half_extent, with_acceleration);
            let Party { body, manner, .. } = &self.other;
            access_orders(
                body,
                manner,
                percept.distance,
                percept.speed,
                &self.own.body,
                own.distance,
                &passage,
            )
        })
    }

    /// V(j|b) and W(b|j), squashed (§8.3).
    fn values(
        &self,
        own: &State,
        other: &State,
        accelerations: &BehaviourAccelerations,
        rules: &Rules,
    ) -> (PerBehaviour, PerBehaviour) {
        let valuation = &self.valuation;
        let mut values = [[0.0; ACTIONS]; BEHAVIOURS];
        let mut others_values = [[0.0; ACTIONS]; BEHAVIOURS];
        let destinations = self.plan.destinations(own.distance, own.speed);
        let mut moves = [Move::default(); ACTIONS];
        for (j, own_move) in moves.iter_mut().enumerate() {
            let to = PredictedState::new(destinations.state(j), &self.own.body, valuation.other_acceleration);
            *own_move = valuation.move_to(&self.own, own, to);
        }
        for behaviour in BEHAVIOUR_LIST {
            let b = behaviour as usize;
            let Some(acceleration) = accelerations[b] else { continue };
            let to = predict_other(other, acceleration, self.action_duration);
            let to = PredictedState::new(to, &self.other.body, valuation.other_acceleration);
            let theirs = valuation.move_to(&self.other, other, to);
            for (j, mine) in moves.iter().enumerate() {
                if let Some(same) = (0..j).find(|&same| moves[same].to.state == mine.to.state) {
                    values[b][j] = values[b][same];
                    others_values[b][j] = others_values[b][same];
                    continue;
                }
                values[b][j] =
                    valuation.of_move(&self.own, mine, &self.other, &theirs, Orders::Better, rules);
                if self.anticipates_influence || j == NO_ACTION {
                    let counting = Orders::of(behaviour);
                    others_values[b][j] =
                        valuation.of_move(&self.other, &theirs, &self.own, mine, counting, rules);
                }
            }
            if !self.anticipates_influence {
                others_values[b] = [others_values[b][NO_ACTION]; ACTIONS];
            }
            for row in [&mut values[b], &mut others_values[b]] {
                for value in row.iter_mut() {
                    *value /= valuation.scale;
                }
                tanh_in_place(row);
            }
        }
        (values, others_values)
    }
}

#[cfg(test)]
mod tests {
    //! What the reference runs do not exercise, checked against the text and by reason (§10).
    use super::super::draws::RecordedDraws;
    use super::super::meeting::{PEDESTRIAN, VEHICLE};
    use super::*;
    use crate::sim::random::Stream;

    const DT: f64 = 0.025;

    fn agent(variant: &str, own: Body, other: Body) -> Agent {
        let parameters =
            Parameters { value_noise: 0.1, observation_deviation: 1e-4, ..Parameters::default() };
        Agent::new(&variant.parse().unwrap(), &parameters, &Encounter { own, other, dt: DT })
    }

    fn state(distance: f64, speed: f64, acceleration: f64) -> State {
        State { distance, speed, acceleration }
    }

    /// What a pedestrian at 5 m thinks of a car at 30 m after one step with these draws.
    fn thoughts(variant: &str, draws: &[f64]) -> Thoughts {
        let mut draws = RecordedDraws::new(draws);
        let mut walker = agent(variant, PEDESTRIAN, VEHICLE);
        walker.step(&state(5.0, 1.0, 0.0), &state(30.0, 10.0, 0.0), &Rules::default(), &mut draws);
        assert!(draws.is_used_up(), "{} draws were taken", draws.taken());
        *walker.thoughts().unwrap()
    }

    #[test]
    fn value_noise_goes_to_beliefs_about_each_behaviour_and_then_to_the_actions() {
        let quiet = thoughts("oVAoBEvoAIoAN", &[0.0; 15]);
        for place in 0..15 {
            let mut draws = [0.0; 15];
            draws[place] = 1.0;
            let noisy = thoughts("oVAoBEvoAIoAN", &draws);
            let j = place % 5;
            match place / 5 {
                // More value for passing first makes it likelier, for passing second less; for that action alone.
                0 => assert!(noisy.probabilities[1][j] > quiet.probabilities[1][j]),
                1 => assert!(noisy.probabilities[1][j] < quiet.probabilities[1][j]),
                _ => {
                    let by = noisy.estimates[j] - quiet.estimates[j];
                    assert!((by - 0.1 * DT.sqrt()).abs() < 1e-12, "{by}");
                    assert_eq!(noisy.probabilities, quiet.probabilities);
                }
            }
            for other in (0..5).filter(|&other| other != j) {
                assert_eq!(noisy.probabilities[1][other], quiet.probabilities[1][other]);
                assert_eq!(noisy.estimates[other], quiet.estimates[other]);
            }
        }
    }

    #[test]
    fn without_value_beliefs_value_noise_goes_to_the_actions_alone() {
        thoughts("oVAoBEooAIoAN", &[0.0; 5]);
        thoughts("oVAoAN", &[0.0; 5]);
    }

    #[test]
    fn without_anticipated_influence_beliefs_do_not_depend_on_ones_own_action() {
        let alone = thoughts("oVAoBEv", &[]).probabilities;
        assert!(alone[1].iter().all(|p| *p == alone[1][0]));
        let influential = thoughts("oVAoBEvoAI", &[]).probabilities;
        assert!(influential[1].iter().any(|p| *p != influential[1][0]));
        // Doing nothing new is what the other is assumed to reckon with.
        assert_eq!(alone[1][NO_ACTION], influential[1][NO_ACTION]);
    }

    #[test]
    fn without_behaviour_estimation_the_other_keeps_its_speed() {
        let plain = thoughts("oVA", &[]).probabilities;
        assert_eq!(plain, [[1.0; 5], [0.0; 5], [0.0; 5]]);
    }

    #[test]
    fn from_movement_alone_yielding_is_recognised() {
        let after = |acceleration: f64| {
            let mut walker = agent("oVAoBEo", PEDESTRIAN, VEHICLE);
            let draws = &mut RecordedDraws::new(&[]);
            let mut car = state(40.0, 10.0, 0.0);
            let mut first = None;
            for _ in 0..40 {
                walker.step(&state(5.0, 0.0, 0.0), &car, &Rules::default(), draws);
                first.get_or_insert(walker.thoughts().unwrap().probabilities);
                car = State { acceleration, ..car }.step(DT);
            }
            (first.unwrap(), walker.thoughts().unwrap().probabilities)
        };
        // Stopping 3.5 m before the conflict point takes −10²/(2·36.5) m/s², regaining 50 km/h in 10 s +0.39 m/s².
        let (before, yielding) = after(-1.37);
        assert_eq!(before, [[0.0; 5], [0.5; 5], [0.5; 5]]);
        assert!(yielding[2].iter().all(|&p| p > 0.9), "{yielding:?}");
        let (_, going) = after(0.39);
        assert!(going[1].iter().all(|&p| p > 0.9), "{going:?}");
    }

    #[test]
    fn nobody_enters_while_entry_is_inhibited_but_cars_do() {
        let draws = &mut Stream::seeded(1);
        let mut walker = agent("oVAoBEvoAIoEAoSNvoPF", PEDESTRIAN, VEHICLE);
        let mut driver = agent("oVAoBEvoAIoEAoSNvoPF", VEHICLE, PEDESTRIAN);
        let (mut own, far) = (state(2.3, 0.0, 0.0), state(400.0, 10.0, 0.0));
        let (mut car, waiting) = (state(20.0, 10.0, 0.0), state(2.3, 0.0, 0.0));
        let inhibited = Rules { pedestrian_priority: false, entry_inhibited: true };
        for _ in 0..200 {
            own.acceleration = walker.step(&own, &far, &inhibited, draws).acceleration;
            car.acceleration = driver.step(&car, &waiting, &inhibited, draws).acceleration;
            (own, car) = (own.step(DT), car.step(DT));
        }
        assert_eq!((own.distance, own.speed), (2.3, 0.0));
        assert!(car.distance < -2.5, "{car:?}");
        for _ in 0..400 {
            own.acceleration = walker.step(&own, &far, &Rules::default(), draws).acceleration;
            own = own.step(DT);
        }
        assert!(own.distance < -1.3, "{own:?}");
    }

    #[test]
    fn past_the_conflict_space_nothing_is_drawn_or_decided() {
        let mut draws = RecordedDraws::new(&[]);
        let mut walker = agent("oVAoBEvoAIoEAoSNvoPF", PEDESTRIAN, VEHICLE);
        let own = state(-1.301, 1.0, 0.5);
        let decision = walker.step(&own, &state(9.0, 9.0, 0.0), &Rules::default(), &mut draws);
        assert_eq!(decision, Decision { acceleration: 0.0, action: None });
        assert!(draws.is_used_up() && walker.thoughts().is_none());
    }

    #[test]
    fn the_other_standing_in_its_conflict_space_is_perceived_without_noise() {
        // At distance 0 the angular noise is 0, and so may be the filter's variance.
        let mut walker = agent("oVAoBEvoAIoEAoSNvoPF", PEDESTRIAN, VEHICLE);
        let draws = &mut Stream::seeded(2);
        for _ in 0..100 {
            let decision =
                walker.step(&state(4.0, 0.0, 0.0), &state(0.0, 0.0, 0.0), &Rules::default(), draws);
            let percept = walker.thoughts().unwrap().percept;
            assert!(decision.acceleration.is_finite());
            assert!(percept.distance.is_finite() && percept.speed.is_finite(), "{percept:?}");
        }
    }
}
