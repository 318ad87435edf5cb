//! One road user that behaves like a person: stepped by what it and those in its sight publish, it answers with an acceleration (§2, §8, §12).

use std::cmp::Ordering;

use super::action::{ACTIONS, ActionPlan};
pub use super::affordance::Rules;
use super::belief::PerBehaviour;
use super::decision::Decider;
use super::draws::{DrawnOnce, StandardNormals};
use super::other::{Other, OwnMoves, Reasoning};
use super::parameters::Parameters;
use super::perception::Percept;
use super::state::{AgentBody, Control, State};
use super::variant::Variant;

/// Who meets whom, and how time goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AgentEncounter {
    /// The agent's own body.
    pub own: AgentBody,
    /// The other's body.
    pub other: AgentBody,
    /// Time step (s).
    pub dt: f64,
}

/// Whether one may still come in another's way (§12).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConflictState {
    /// Either may still come in the other's way.
    Open,
    /// The other does not come in the way as it behaves now (it is parked, or goes elsewhere), but may yet.
    Dormant,
    /// The other is out of sight: what was thought of it last counts.
    Remembered,
    /// One of the two has left the conflict space.
    Over,
}

/// Another road user as an agent finds it at a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Which one: its number among those that the agent was made to meet.
    pub other: usize,
    /// Its path: of those who have not entered the conflict space, only the next on a path is weighed.
    pub path: usize,
    /// The agent's own state on its way to the conflict point with this one.
    pub own: State,
    /// The other's state.
    pub state: State,
    /// True distance between the two (m), unless their ways meet at a right angle.
    pub apart: Option<f64>,
    /// How the conflict stands.
    pub conflict: ConflictState,
}

/// What an agent does at a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AgentDecision {
    /// Acceleration from now to the next step (m/s²).
    pub acceleration: f64,
    /// The action taken, if any.
    pub action: Option<usize>,
}

/// What went on in an agent's mind at its last decision, for inspection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thoughts {
    /// The number of the other that decided.
    pub other: usize,
    /// That one, as perceived.
    pub percept: Percept,
    /// P(b|j) of that one.
    pub probabilities: PerBehaviour,
    /// V̂ per action.
    pub estimates: [f64; ACTIONS],
}

/// A road user that perceives, believes, values and acts: one mind, one action buffer, one decision and one stream of
/// noise, however many others it meets.
#[derive(Clone, Debug)]
pub struct CommotionsAgent {
    reasoning: Reasoning,
    plan: ActionPlan,
    decider: Decider,
    others: Vec<Other>,
    /// What it may do at the present step, for each place that it is at on its way to somebody.
    moves: Vec<OwnMoves>,
    /// How far the next of the candidates on each path is that has not entered the conflict space at the present step: path and m.
    next: Vec<(usize, f64)>,
    /// Who decided last; whom one goes on meeting while no conflict is open.
    met: Option<usize>,
    /// Whether there was a decision yet.
    decided: bool,
    drawn: Vec<f64>,
    thoughts: Option<Thoughts>,
}

/// Deviates that one decision takes at most: of five values each for three behaviours and for the actions.
const MOST_DRAWN: usize = 20;

impl CommotionsAgent {
    /// An individual of a variant at the start of an encounter with one other.
    pub fn new(variant: &Variant, parameters: &Parameters, encounter: &AgentEncounter) -> Self {
        let AgentEncounter { own, other, dt } = *encounter;
        Self::among(variant, parameters, own.control, dt, [(own, other)])
    }

    /// An individual of a variant at the start of encounters with several others: its own body, whose extent depends
    /// on the other's width, and the other's, in the order of their numbers.
    pub fn among(
        variant: &Variant,
        parameters: &Parameters,
        control: Control,
        dt: f64,
        bodies: impl IntoIterator<Item = (AgentBody, AgentBody)>,
    ) -> Self {
        let reasoning = Reasoning::new(variant, parameters);
        let valuation = &reasoning.valuation;
        let saturated_free_value = libm::tanh(valuation.discounting.free_value() / valuation.scale);
        let others: Vec<_> =
            bodies.into_iter().map(|(own, other)| Other::new(variant, parameters, own, other, dt)).collect();
        Self {
            plan: ActionPlan::new(control, parameters.action_duration, dt),
            decider: Decider::new(variant, parameters, saturated_free_value, dt),
            reasoning,
            // The published model knows one other, who is met wherever it is.
            met: (others.len() == 1).then_some(0),
            moves: Vec::with_capacity(others.len()),
            next: Vec::with_capacity(others.len()),
            others,
            decided: false,
            drawn: Vec::with_capacity(MOST_DRAWN),
            thoughts: None,
        }
    }

    /// The ways of oneself and of one other meet elsewhere or at another angle from now on, so that their bodies have other extents in
    /// the conflict space.
    pub fn meet(&mut self, other: usize, own: AgentBody, body: AgentBody) {
        self.others[other].meet(own, body);
    }

    /// What went on at the last decision; `None` when the last step needed none.
    pub fn thoughts(&self) -> Option<&Thoughts> {
        self.thoughts.as_ref()
    }

    /// What speaks for each action since the last decision, and above which threshold it is taken, as [`Decider::evidence`] has it.
    pub fn evidence(&self) -> ([f64; ACTIONS], f64) {
        self.decider.evidence()
    }

    /// One step with one other: what to do, given what both publish.
    ///
    /// Once out of the conflict space the agent neither perceives (draws no noise) nor decides.
    pub fn step(
        &mut self,
        own: &State,
        other: &State,
        rules: &Rules,
        draws: &mut impl StandardNormals,
    ) -> AgentDecision {
        let sight = self.only_sight(own, other);
        self.step_among(&[sight], rules, draws).unwrap_or(AgentDecision { acceleration: 0.0, action: None })
    }

    /// As [`Self::look_among`] with one other.
    pub fn look(&mut self, own: &State, other: &State, rules: &Rules, draws: &mut impl StandardNormals) {
        let sight = self.only_sight(own, other);
        self.look_among(&[sight], rules, draws);
    }

    fn only_sight(&self, own: &State, other: &State) -> Sight {
        let conflict = if self.others[0].is_left_behind(own.distance) {
            ConflictState::Over
        } else {
            ConflictState::Open
        };
        Sight { other: 0, path: 0, own: *own, state: *other, apart: None, conflict }
    }

    /// One step among several others: what to do, given what all publish. `None` where there is nobody to decide about:
    /// no conflict was ever open, or all who are in one are out of sight.
    ///
    /// Everybody whose conflict is open is perceived, with the same deviates. Weighed are, on each path, those inside
    /// the conflict space and the next that has not entered it. The values of the actions are those of whoever
    /// constrains most: whose best action is worth least (of equals, whose other actions are worth less, then who is nearer). What would lead
    /// in front of somebody who is still inside is worth nothing, however much the next one hurries.
    pub fn step_among(
        &mut self,
        sights: &[Sight],
        rules: &Rules,
        draws: &mut impl StandardNormals,
    ) -> Option<AgentDecision> {
        let (met, read) = match self.think(sights, rules, draws)? {
            Thinking::Finished => {
                self.plan.clear();
                self.decider.clear();
                return self.decided.then_some(AgentDecision { acceleration: 0.0, action: None });
            }
            Thinking::Weighed { met, read } => (met, read),
        };
        let mut deviates = DrawnOnce::from(&mut self.drawn, read, draws);
        let values = values_of_actions(&self.others, &self.plan, met, sights);
        let action = self.decider.decide(&values, &mut deviates);
        deviates.forget_read();
        if let Some(j) = action {
            self.plan.take(j);
            if self.decider.forgets_by_acting() {
                self.others.iter_mut().for_each(Other::forget_values);
            }
        }
        (self.met, self.decided) = (Some(met), true);
        self.note_thoughts(met);
        Some(AgentDecision { acceleration: self.plan.end_step(), action })
    }

    /// One step in which the agent stands and only looks: it perceives and believes as in [`Self::step_among`], but takes no action, and no
    /// action gathers evidence.
    pub fn look_among(&mut self, sights: &[Sight], rules: &Rules, draws: &mut impl StandardNormals) {
        if let Some(Thinking::Weighed { met, read }) = self.think(sights, rules, draws) {
            DrawnOnce::from(&mut self.drawn, read, draws).forget_read();
            self.note_thoughts(met);
        }
    }

    /// Perceives all others and thinks about them; `None` where there is nobody to decide about.
    fn think(
        &mut self,
        sights: &[Sight],
        rules: &Rules,
        draws: &mut impl StandardNormals,
    ) -> Option<Thinking> {
        self.thoughts = None;
        for sight in sights.iter().filter(|sight| sight.conflict == ConflictState::Over) {
            if self.met != Some(sight.other) {
                self.others[sight.other].lapse();
            }
        }
        let candidates = self.candidates(sights)?;
        if let Candidates::Met(met) = candidates
            && self.others[met].is_left_behind(sights.iter().find(|sight| sight.other == met)?.own.distance)
        {
            return Some(Thinking::Finished);
        }
        self.plan.begin_step(sights.first()?.own.speed);
        self.moves.clear();
        self.find_next(sights, candidates);
        let mut decisive: Option<(&Sight, usize)> = None;
        for sight in sights {
            let weighed = self.is_weighed(sight, candidates);
            let mut read = 0;
            match sight.conflict {
                _ if weighed && sight.conflict != ConflictState::Remembered => {
                    read = self.consider(sight, rules, true, draws);
                }
                ConflictState::Open | ConflictState::Dormant => {
                    read = self.consider(sight, rules, false, draws)
                }
                ConflictState::Over | ConflictState::Remembered => {}
            }
            if weighed && decisive.is_none_or(|(most, _)| self.constrains_more(sight, most)) {
                decisive = Some((sight, read));
            }
        }
        let (&Sight { other: met, .. }, read) = decisive?;
        Some(Thinking::Weighed { met, read })
    }

    fn note_thoughts(&mut self, met: usize) {
        let Other { percept, probabilities, .. } = self.others[met];
        self.thoughts =
            Some(Thoughts { other: met, percept, probabilities, estimates: *self.decider.estimates() });
    }

    /// Perceives one other and thinks about it; how many of the moment's deviates that took.
    fn consider(
        &mut self,
        sight: &Sight,
        rules: &Rules,
        weighed: bool,
        draws: &mut impl StandardNormals,
    ) -> usize {
        let Self { reasoning, plan, others, moves, drawn, .. } = self;
        let mut deviates = DrawnOnce::from(drawn, 0, draws);
        let other = &mut others[sight.other];
        let Sight { own, state, apart, .. } = sight;
        let own = other.own_moves(reasoning, plan, own, moves);
        other.consider(reasoning, &moves[own], state, *apart, rules, weighed, &mut deviates);
        deviates.read()
    }

    /// Who may decide.
    fn candidates(&self, sights: &[Sight]) -> Option<Candidates> {
        let any = |conflict| sights.iter().any(|sight| sight.conflict == conflict);
        if any(ConflictState::Open) {
            Some(Candidates::Open)
        } else if any(ConflictState::Remembered) {
            None
        } else if let Some(met) = self.met {
            Some(Candidates::Met(met))
        } else {
            any(ConflictState::Dormant).then_some(Candidates::Dormant)
        }
    }

    /// Finds the next of the candidates on each path.
    fn find_next(&mut self, sights: &[Sight], candidates: Candidates) {
        self.next.clear();
        for sight in sights {
            let distance = sight.state.distance;
            // What is no number is before nobody.
            let enters = !distance.is_nan() && !self.others[sight.other].is_inside(distance);
            if !enters || !candidates.include(sight) {
                continue;
            }
            match self.next.iter_mut().find(|(path, _)| *path == sight.path) {
                Some((_, nearest)) if distance < *nearest => *nearest = distance,
                Some(_) => {}
                None => self.next.push((sight.path, distance)),
            }
        }
    }

    /// Whether `sight` is one of the candidates and inside the conflict space, or the next of them on its path.
    fn is_weighed(&self, sight: &Sight, candidates: Candidates) -> bool {
        let distance = sight.state.distance;
        let is_next = || !self.next.iter().any(|(path, nearest)| *path == sight.path && *nearest < distance);
        match sight.conflict {
            ConflictState::Remembered => candidates == Candidates::Open,
            _ => candidates.include(sight) && (self.others[sight.other].is_inside(distance) || is_next()),
        }
    }

    /// Whether the other in sight as `one` constrains more than `most`. It does not depend on who is named first: where all
    /// values are the same, as saturated ones are, it is who is nearer (who is as near and as fast is the same to the mind).
    fn constrains_more(&self, one: &Sight, most: &Sight) -> bool {
        let best = |values: &[f64; ACTIONS]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let by_value = || {
            let (one, most) = (&self.others[one.other].expected, &self.others[most.other].expected);
            let each = one.iter().zip(most).map(|(one, most)| one.total_cmp(most));
            best(one).total_cmp(&best(most)).then(each.fold(Ordering::Equal, Ordering::then))
        };
        let by_place = || {
            let place = |sight: &Sight| [sight.state.distance, sight.own.distance, sight.state.speed];
            let each = place(one).into_iter().zip(place(most)).map(|(one, most)| one.total_cmp(&most));
            each.fold(Ordering::Equal, Ordering::then)
        };
        by_value().then_with(by_place).is_lt()
    }
}

/// What an action is worth that achieves nothing, as impossible access orders are (§7, squashed).
const WORTHLESS: f64 = -1.0;

/// The values of the actions as far as `met` is concerned, who decides.
///
/// While another is inside the conflict space on the path on which `met` is the next, entry is inhibited (§7, early entry)
/// for as long as that takes: an action that leads in before it has left is worthless. Values look at where everybody is
/// one action duration ahead, when that other may have left, so that nothing else says that it is still there.
fn values_of_actions(others: &[Other], plan: &ActionPlan, met: usize, sights: &[Sight]) -> [f64; ACTIONS] {
    let mut values = others[met].expected;
    let inside = |sight: &Sight| others[sight.other].is_inside(sight.state.distance);
    let Some(next) = sights.iter().find(|sight| sight.other == met && !inside(sight)) else { return values };
    let still_there = |sight: &&Sight| {
        sight.path == next.path
            && sight.conflict == ConflictState::Open
            && inside(sight)
            && !others[sight.other].is_entered(sight.own.distance)
    };
    for sight in sights.iter().filter(still_there) {
        let other = &others[sight.other];
        let steps = plan.steps_of(other.leaves_in(&sight.state));
        let distances = plan.distances_after(steps, sight.own.distance, sight.own.speed);
        for (value, distance) in values.iter_mut().zip(distances) {
            if other.is_entered(distance) {
                *value = WORTHLESS;
            }
        }
    }
    values
}

/// What comes of thinking at a step.
enum Thinking {
    /// The one that is met is left behind: nothing is to be decided any more.
    Finished,
    /// The one that decides, and how many of the moment's deviates that took.
    Weighed { met: usize, read: usize },
}

/// Who may decide at a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Candidates {
    /// Those whose conflict is open.
    Open,
    /// None is, and nobody decided yet: those who may come in the way yet.
    Dormant,
    /// None is: the one who decided last.
    Met(usize),
}

impl Candidates {
    fn include(self, sight: &Sight) -> bool {
        match self {
            Self::Open => sight.conflict == ConflictState::Open,
            Self::Dormant => sight.conflict == ConflictState::Dormant,
            Self::Met(met) => sight.other == met,
        }
    }
}

#[cfg(test)]
mod tests {
    //! What the reference runs do not exercise, checked against the text and by reason (§10).
    use super::super::action::NO_ACTION;
    use super::super::draws::RecordedDraws;
    use super::super::meeting::{PEDESTRIAN, VEHICLE};
    use super::*;
    use numbers::random::Stream;

    const DT: f64 = 0.025;

    fn agent(variant: &str, own: AgentBody, other: AgentBody) -> CommotionsAgent {
        let parameters =
            Parameters { value_noise: 0.1, observation_deviation: 1e-4, ..Parameters::default() };
        CommotionsAgent::new(&variant.parse().unwrap(), &parameters, &AgentEncounter { own, other, dt: DT })
    }

    fn state(distance: f64, speed: f64, acceleration: f64) -> State {
        State { distance, speed, acceleration }
    }

    /// What a pedestrian at 5 m and 1 m/s thinks of a car at 30 m after one step with these draws.
    fn thoughts(variant: &str, draws: &[f64]) -> Thoughts {
        thoughts_at(1.0, variant, draws)
    }

    /// The same at that speed, m/s.
    fn thoughts_at(speed: f64, variant: &str, draws: &[f64]) -> Thoughts {
        let mut draws = RecordedDraws::new(draws);
        let mut walker = agent(variant, PEDESTRIAN, VEHICLE);
        walker.step(&state(5.0, speed, 0.0), &state(30.0, 10.0, 0.0), &Rules::default(), &mut draws);
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
        // Standing, doing nothing new leads to the same as slowing down.
        for speed in [1.0, 0.0] {
            let alone = thoughts_at(speed, "oVAoBEv", &[]).probabilities;
            assert!(alone[1].iter().all(|p| *p == alone[1][0]));
            let influential = thoughts_at(speed, "oVAoBEvoAI", &[]).probabilities;
            assert!(influential[1].iter().any(|p| *p != influential[1][0]));
            // Doing nothing new is what the other is assumed to reckon with.
            assert_eq!(alone[1][NO_ACTION], influential[1][NO_ACTION], "at {speed} m/s");
        }
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

    /// A pedestrian at 5 m among two cars: one at 60 m, and a faster one at 70 m on the path `path`.
    fn walker_among_two(path: usize) -> (CommotionsAgent, [Sight; 2]) {
        let variant = "oVAoBEvoAIoEA".parse().unwrap();
        let bodies = [(PEDESTRIAN, VEHICLE); 2];
        let agent = CommotionsAgent::among(&variant, &Parameters::default(), Control::Speed, DT, bodies);
        let sight = |other, path, car| Sight {
            apart: None,
            other,
            path,
            own: state(5.0, 0.0, 0.0),
            state: car,
            conflict: ConflictState::Open,
        };
        (agent, [sight(0, 0, state(60.0, 5.0, 0.0)), sight(1, path, state(70.0, 15.0, 0.0))])
    }

    #[test]
    fn who_follows_on_a_path_does_not_decide() {
        // By their speeds alone the second would be there first, after 4.7 s instead of 12 s. On another path it decides;
        // behind the first it does not, since it cannot pass it.
        for (path, decides) in [(1, 1), (0, 0)] {
            let (mut walker, sights) = walker_among_two(path);
            let draws = &mut RecordedDraws::new(&[]);
            walker.step_among(&sights, &Rules::default(), draws).unwrap();
            let percept = walker.thoughts().unwrap().percept;
            assert_eq!(percept.distance, sights[decides].state.distance, "on path {path}");
        }
    }

    #[test]
    fn who_is_inside_and_the_next_on_its_path_are_both_weighed() {
        // The car inside, which has all but passed, leaves room to go soon; the next, 1 s away, does not.
        let (mut walker, mut sights) = walker_among_two(0);
        sights[0].state = state(-2.0, 10.0, 0.0);
        sights[1].state = state(10.0, 10.0, 0.0);
        for sight in &mut sights {
            sight.own = state(2.4, 0.0, 0.0);
        }
        walker.step_among(&sights, &Rules::default(), &mut RecordedDraws::new(&[])).unwrap();
        assert_eq!(walker.thoughts().unwrap().percept.distance, 10.0);
    }

    #[test]
    fn past_the_conflict_space_nothing_is_drawn_or_decided() {
        let mut draws = RecordedDraws::new(&[]);
        let mut walker = agent("oVAoBEvoAIoEAoSNvoPF", PEDESTRIAN, VEHICLE);
        let own = state(-1.301, 1.0, 0.5);
        let decision = walker.step(&own, &state(9.0, 9.0, 0.0), &Rules::default(), &mut draws);
        assert_eq!(decision, AgentDecision { acceleration: 0.0, action: None });
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
