//! What a road user keeps of each other in sight: how it is perceived, what it may do, and what one's own actions are worth as far as it is concerned (§3 to §8).

use std::array;

use super::access::access_orders;
use super::action::{ACTIONS, ActionPlan, Destinations, NO_ACTION};
use super::affordance::{AgentMove, AgentOrders, Party, Rules, Valuation};
use super::belief::{Beliefs, PerBehaviour};
use super::draws::StandardNormals;
use super::parameters::Parameters;
use super::perception::{AgentPerception, Percept};
use super::prediction::{
    BEHAVIOUR_LIST, BEHAVIOURS, BehaviourAccelerations, PredictedState, behaviours, predict_other,
};
use super::squash::tanh_in_place;
use super::state::{AgentBody, Control, State};
use super::timing::ConflictPassage;
use super::variant::Variant;

/// How a road user reasons about others: what is the same whoever they are.
#[derive(Clone, Debug)]
pub struct Reasoning {
    /// Whether the behaviour of others is estimated (`oBEo`, `oBEv`).
    estimates_behaviour: bool,
    /// Whether others are thought to react to one's own actions (`oAI`).
    anticipates_influence: bool,
    /// s
    action_duration: f64,
    /// What moving is worth.
    pub valuation: Valuation,
}

impl Reasoning {
    /// The reasoning of an individual of a variant.
    pub fn new(variant: &Variant, parameters: &Parameters) -> Self {
        Self {
            estimates_behaviour: variant.estimates_behaviour(),
            anticipates_influence: variant.anticipated_influence,
            action_duration: parameters.action_duration,
            valuation: Valuation::new(variant, parameters),
        }
    }
}

/// Another road user in one's mind.
#[derive(Clone, Debug)]
pub struct Other {
    /// Oneself in this conflict, whose extent depends on the other's width.
    own: Party,
    party: Party,
    perception: AgentPerception,
    beliefs: Beliefs,
    /// Both as they were before the other was seen.
    unseen: (AgentPerception, Beliefs),
    /// Whether it was out of mind since it was last considered.
    lapsed: bool,
    /// The other as perceived last.
    pub percept: Percept,
    /// P(b|j) of the last decision.
    pub probabilities: PerBehaviour,
    /// Ṽ(j): the expected values of the actions as far as this other is concerned, when it was last weighed.
    pub expected: [f64; ACTIONS],
}

impl Other {
    /// Nothing is known yet of somebody with the body `other`, met with the body `own`. `dt` is the time step (s).
    pub fn new(
        variant: &Variant,
        parameters: &Parameters,
        own: AgentBody,
        other: AgentBody,
        dt: f64,
    ) -> Self {
        let assumed_speed = Party::wanted_speed(other.control, parameters);
        let perception = AgentPerception::new(variant, parameters, dt, assumed_speed);
        let beliefs = Beliefs::new(variant, parameters, dt);
        Self {
            own: Party::new(own, parameters),
            party: Party::new(other, parameters),
            unseen: (perception.clone(), beliefs.clone()),
            perception,
            beliefs,
            lapsed: false,
            percept: Percept::default(),
            probabilities: PerBehaviour::default(),
            expected: [0.0; ACTIONS],
        }
    }

    /// The conflict space of the two is another: their ways meet elsewhere, or at another angle.
    pub fn meet(&mut self, own: AgentBody, other: AgentBody) {
        (self.own.body, self.party.body) = (own, other);
    }

    /// Whether one has left the conflict space at the distance `own` (m) to the conflict point.
    pub fn is_left_behind(&self, own: f64) -> bool {
        own < -self.own.body.half_extent
    }

    /// Whether the other is in the conflict space at its distance (m) to the conflict point.
    pub fn is_inside(&self, distance: f64) -> bool {
        self.party.body.occupies(distance)
    }

    /// Whether one is in the conflict space or past it at the distance `own` (m) to the conflict point.
    pub fn is_entered(&self, own: f64) -> bool {
        own < self.own.body.half_extent
    }

    /// Until the other leaves the conflict space if it keeps its speed (s); infinite while it stands.
    pub fn leaves_in(&self, other: &State) -> f64 {
        (other.distance + self.party.body.half_extent) / other.speed
    }

    /// It is not considered for a while: when it is again, it is as new, since what was perceived is out of date.
    pub fn lapse(&mut self) {
        self.lapsed = true;
    }

    /// Forgets what is good for the other, as acting does with `oEA` (§8.6).
    pub fn forget_values(&mut self) {
        self.beliefs.forget_values();
    }

    /// One step of perception, prediction and belief; where it is `weighed`, the expected values of one's actions, too.
    #[allow(clippy::too_many_arguments, reason = "who reasons, what both publish, and what holds besides")]
    pub fn consider(
        &mut self,
        reasoning: &Reasoning,
        plan: &ActionPlan,
        own: &State,
        other: &State,
        apart: Option<f64>,
        rules: &Rules,
        weighed: bool,
        draws: &mut impl StandardNormals,
    ) {
        if self.lapsed {
            (self.perception, self.beliefs) = self.unseen.clone();
            self.lapsed = false;
        }
        self.percept = self.perception.perceive(own.distance, *other, apart, draws);
        let accelerations = self.behaviours(reasoning, own);
        let Percept { distance, speed } = self.percept;
        let perceived = State { distance, speed, acceleration: other.acceleration };
        let (values, others_values) =
            self.values(reasoning, plan, own, &perceived, &accelerations, rules, weighed);
        self.probabilities = self.beliefs.update(&self.percept, &accelerations, &others_values, draws);
        if weighed {
            self.expected = [0.0; ACTIONS];
            for (values, probabilities) in values.iter().zip(&self.probabilities) {
                for j in 0..ACTIONS {
                    self.expected[j] += probabilities[j] * values[j];
                }
            }
        }
    }

    /// What the other may do (§8.1).
    fn behaviours(&self, reasoning: &Reasoning, own: &State) -> BehaviourAccelerations {
        behaviours(reasoning.estimates_behaviour, || {
            let with_acceleration =
                reasoning.valuation.other_acceleration && self.own.body.control == Control::Acceleration;
            let passage = ConflictPassage::of(own, self.own.body.half_extent, with_acceleration);
            let Party { body, manner, .. } = &self.party;
            let Percept { distance, speed } = self.percept;
            access_orders(body, manner, distance, speed, &self.own.body, own.distance, &passage)
        })
    }

    /// V(j|b), where it is `weighed`, and W(b|j), squashed (§8.3).
    #[allow(clippy::too_many_arguments, reason = "who reasons, what both publish, and what holds besides")]
    fn values(
        &self,
        reasoning: &Reasoning,
        plan: &ActionPlan,
        own: &State,
        other: &State,
        accelerations: &BehaviourAccelerations,
        rules: &Rules,
        weighed: bool,
    ) -> (PerBehaviour, PerBehaviour) {
        let valuation = &reasoning.valuation;
        let mut values = [[0.0; ACTIONS]; BEHAVIOURS];
        let mut others_values = [[0.0; ACTIONS]; BEHAVIOURS];
        let destinations = plan.destinations(own.distance, own.speed);
        // Actions that lead to the same state, as of whoever stands and would slow down, are worth the same.
        let same = same_before(&destinations);
        let as_no_action = same[NO_ACTION].unwrap_or(NO_ACTION);
        let mut moves = [AgentMove::default(); ACTIONS];
        for (j, own_move) in moves.iter_mut().enumerate().filter(|(j, _)| same[*j].is_none()) {
            let to = PredictedState::new(destinations.state(j), &self.own.body, valuation.other_acceleration);
            *own_move = valuation.move_to(&self.own, own, to);
        }
        for behaviour in BEHAVIOUR_LIST {
            let b = behaviour as usize;
            let Some(acceleration) = accelerations[b] else { continue };
            let to = predict_other(other, acceleration, reasoning.action_duration);
            let to = PredictedState::new(to, &self.party.body, valuation.other_acceleration);
            let theirs = valuation.move_to(&self.party, other, to);
            for (j, mine) in moves.iter().enumerate() {
                if let Some(same) = same[j] {
                    values[b][j] = values[b][same];
                    others_values[b][j] = others_values[b][same];
                    continue;
                }
                if weighed {
                    values[b][j] =
                        valuation.of_move(&self.own, mine, &self.party, &theirs, AgentOrders::Better, rules);
                }
                if reasoning.anticipates_influence || j == as_no_action {
                    let counting = AgentOrders::of(behaviour);
                    others_values[b][j] =
                        valuation.of_move(&self.party, &theirs, &self.own, mine, counting, rules);
                }
            }
            if !reasoning.anticipates_influence {
                others_values[b] = [others_values[b][as_no_action]; ACTIONS];
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

/// For each action the first before it that leads to the same state.
fn same_before(destinations: &Destinations) -> [Option<usize>; ACTIONS] {
    array::from_fn(|j| (0..j).find(|&other| destinations.state(other) == destinations.state(j)))
}
