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

/// What one may do at a step, and where that leads (§8.2): the same for all others whom one meets with the same body at the same place.
#[derive(Clone, Debug)]
pub struct OwnMoves {
    body: AgentBody,
    here: State,
    /// One's passage through the conflict space if one goes on, as others see it.
    passage: ConflictPassage,
    /// Of each action the first before it that leads to the same state: they are worth the same.
    same: [Option<usize>; ACTIONS],
    /// Of the others.
    moves: [AgentMove; ACTIONS],
}

impl OwnMoves {
    /// Of the road user `own` at `here`.
    fn new(reasoning: &Reasoning, plan: &ActionPlan, own: &Party, here: &State) -> Self {
        let Reasoning { valuation, .. } = reasoning;
        let destinations = plan.destinations(here.distance, here.speed);
        // Such as those of whoever stands and would slow down.
        let same = same_before(&destinations);
        let mut moves = [AgentMove::default(); ACTIONS];
        for (j, own_move) in moves.iter_mut().enumerate().filter(|(j, _)| same[*j].is_none()) {
            let to = PredictedState::new(destinations.state(j), &own.body, valuation.other_acceleration);
            *own_move = valuation.move_to(own, here, to);
        }
        let with_acceleration = valuation.other_acceleration && own.body.control == Control::Acceleration;
        let passage = ConflictPassage::of(here, own.body.half_extent, with_acceleration);
        Self { body: own.body, here: *here, passage, same, moves }
    }

    /// Whether they are those of this body at this place, to the bit.
    fn is_of(&self, body: &AgentBody, here: &State) -> bool {
        let bits = |body: &AgentBody, here: &State| {
            let AgentBody { half_extent, cosine, width, .. } = *body;
            let State { distance, speed, acceleration } = *here;
            [half_extent, cosine, width, distance, speed, acceleration].map(f64::to_bits)
        };
        self.body.control == body.control && bits(&self.body, &self.here) == bits(body, here)
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

    /// The place among the moves that are `known` of this step of one's own at `here`, who are added if they are not there.
    pub fn own_moves(
        &self,
        reasoning: &Reasoning,
        plan: &ActionPlan,
        here: &State,
        known: &mut Vec<OwnMoves>,
    ) -> usize {
        let found = known.iter().position(|moves| moves.is_of(&self.own.body, here));
        found.unwrap_or_else(|| {
            known.push(OwnMoves::new(reasoning, plan, &self.own, here));
            known.len() - 1
        })
    }

    /// One step of perception, prediction and belief; where it is `weighed`, the expected values of one's actions, too. `own` is what one may
    /// do oneself.
    #[allow(clippy::too_many_arguments, reason = "who reasons, what both publish, and what holds besides")]
    pub fn consider(
        &mut self,
        reasoning: &Reasoning,
        own: &OwnMoves,
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
        self.percept = self.perception.perceive(own.here.distance, *other, apart, draws);
        let accelerations = self.behaviours(reasoning, own);
        let Percept { distance, speed } = self.percept;
        let perceived = State { distance, speed, acceleration: other.acceleration };
        let (values, others_values) = self.values(reasoning, own, &perceived, &accelerations, rules, weighed);
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
    fn behaviours(&self, reasoning: &Reasoning, own: &OwnMoves) -> BehaviourAccelerations {
        behaviours(reasoning.estimates_behaviour, || {
            let Party { body, manner, .. } = &self.party;
            let Percept { distance, speed } = self.percept;
            access_orders(body, manner, distance, speed, &own.body, own.here.distance, &own.passage)
        })
    }

    /// V(j|b), where it is `weighed`, and W(b|j), squashed (§8.3).
    fn values(
        &self,
        reasoning: &Reasoning,
        own: &OwnMoves,
        other: &State,
        accelerations: &BehaviourAccelerations,
        rules: &Rules,
        weighed: bool,
    ) -> (PerBehaviour, PerBehaviour) {
        let valuation = &reasoning.valuation;
        let mut values = [[0.0; ACTIONS]; BEHAVIOURS];
        let mut others_values = [[0.0; ACTIONS]; BEHAVIOURS];
        let OwnMoves { same, moves, .. } = own;
        let as_no_action = same[NO_ACTION].unwrap_or(NO_ACTION);
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
            let rows = [&mut values[b], &mut others_values[b]];
            for row in rows.into_iter().skip(usize::from(!weighed)) {
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
