//! Replays the reference numbers of the COMMOTIONS model: units to 1e-9, whole simulations action by action.
//!
//! `COMMOTIONS_REFERENCE` names another file of the same format.

use std::fmt;
use std::path::{Path, PathBuf};

use libtest_mimic::Trial;
use models::pedestrian::commotions::access::{AccessCourse, access_orders};
use models::pedestrian::commotions::affordance::{AgentMove, Party, Valuation};
use models::pedestrian::commotions::draws::RecordedDraws;
use models::pedestrian::commotions::prediction::PredictedState;
use models::pedestrian::commotions::state::AgentBody;
use models::pedestrian::commotions::timing::ConflictPassage;
use models::pedestrian::commotions::value::ActionPhase;
use models::pedestrian::commotions::{
    AgentEncounter, CommotionsAgent, Control, Parameters, Rules, State, Thoughts, Variant,
};
use serde::Deserialize;
use std::collections::BTreeMap;

use super::{shared, with};

const PEDESTRIAN: AgentBody =
    AgentBody { control: Control::Speed, half_extent: 1.3, cosine: 0.0, width: 0.8 };
const VEHICLE: AgentBody =
    AgentBody { control: Control::Acceleration, half_extent: 2.5, cosine: 0.0, width: 1.8 };
/// Distances and speeds of a simulation agree within this (m, m/s).
const STATE_TOLERANCE: f64 = 1e-9;
const PROBE_TOLERANCE: f64 = 1e-6;

/// A number, or `"nan"`, `"inf"`, `"-inf"`.
#[derive(Clone, Copy, Deserialize)]
#[serde(try_from = "NumberOrName")]
struct Real(f64);

#[derive(Deserialize)]
#[serde(untagged)]
enum NumberOrName {
    Number(f64),
    Name(String),
}

impl TryFrom<NumberOrName> for Real {
    type Error = String;

    fn try_from(value: NumberOrName) -> Result<Self, String> {
        Ok(Self(match value {
            NumberOrName::Number(number) => number,
            NumberOrName::Name(name) => match name.as_str() {
                "nan" => f64::NAN,
                "inf" => f64::INFINITY,
                "-inf" => f64::NEG_INFINITY,
                _ => return Err(format!("`{name}` is no number; expected \"nan\", \"inf\" or \"-inf\"")),
            },
        }))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Reference {
    units: Units,
    simulations: Vec<Simulation>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Units {
    entry_exit: Vec<EntryExit>,
    access: Vec<Access>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EntryExit {
    d: f64,
    v: f64,
    a: f64,
    coll_dist: f64,
    speed: [Real; 2],
    acceleration: [Real; 2],
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct ReferenceState {
    d: f64,
    v: f64,
    a: f64,
}

impl From<ReferenceState> for State {
    fn from(state: ReferenceState) -> Self {
        Self { distance: state.d, speed: state.v, acceleration: state.a }
    }
}

#[derive(Clone, Copy, Deserialize, PartialEq, Eq, Debug)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Pedestrian,
    Vehicle,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Orders<T> {
    #[serde(rename = "EGOFIRST")]
    first: T,
    #[serde(rename = "EGOSECOND")]
    second: T,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Access {
    ego: Kind,
    params: BTreeMap<String, f64>,
    ego_current: ReferenceState,
    ego_predicted: ReferenceState,
    action_acc0: f64,
    action_jerk: f64,
    other_current: ReferenceState,
    other_predicted: ReferenceState,
    other_first_acc: f64,
    other_cont_acc: f64,
    consider_other_acc: bool,
    consider_looming: bool,
    implications: Orders<[Real; 3]>,
    values: Orders<Real>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Simulation {
    model: String,
    params: BTreeMap<String, f64>,
    pedestrian_priority: bool,
    dt: f64,
    end_time: f64,
    n_steps: usize,
    ped: Run,
    vehicle: Run,
    draws: Draws,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Draws {
    ped: Vec<f64>,
    vehicle: Vec<f64>,
}

#[derive(Clone, Copy, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
enum Driver {
    Commotions,
    ConstantAcceleration,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Run {
    kind: Option<Driver>,
    #[serde(default)]
    profile: Vec<(f64, f64)>,
    d0: f64,
    v0: f64,
    d: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    #[serde(default)]
    actions: Vec<(usize, usize)>,
    #[serde(default)]
    probe_steps: Vec<usize>,
    #[serde(default)]
    action_value_estimates: Vec<[Real; 5]>,
    #[serde(default)]
    behaviour_probabilities: Vec<[Real; 15]>,
    #[serde(default)]
    perceived: Vec<[Real; 2]>,
}

pub fn tests() -> Vec<Trial> {
    let file = match std::env::var_os("COMMOTIONS_REFERENCE") {
        Some(path) => Some(PathBuf::from(path)),
        None => shared("data/commotions_reference.json"),
    };
    with(
        file.as_deref(),
        &[
            ("entry_and_exit_times", entry_and_exit_times),
            ("access_orders_and_their_values", access_orders_and_their_values),
            ("simulations", simulations),
        ],
    )
}

fn reference(path: &Path) -> Reference {
    let text =
        std::fs::read_to_string(path).unwrap_or_else(|e| panic!("cannot read {}: {e}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn parameters(given: &BTreeMap<String, f64>, place: impl fmt::Display) -> Parameters {
    let mut parameters = Parameters::default();
    for (name, value) in given {
        *parameters.get_mut(name).unwrap_or_else(|| panic!("{place}: unknown parameter `{name}`")) = *value;
    }
    parameters
}

/// Whether `found` is the reference number to `tolerance`, relative above 1; infinities exactly, NaN for NaN.
fn agrees(found: f64, expected: f64, tolerance: f64) -> bool {
    found == expected
        || (found.is_nan() && expected.is_nan())
        || (found - expected).abs() <= tolerance * expected.abs().max(1.0)
}

/// Relative to the reference number, with no floor.
fn agrees_relatively(found: f64, expected: f64) -> bool {
    found == expected
        || (found.is_nan() && expected.is_nan())
        || (found - expected).abs() <= 1e-9 * expected.abs()
}

fn entry_and_exit_times(path: &Path) {
    let reference = reference(path);
    let units = &reference.units.entry_exit;
    for (i, unit) in units.iter().enumerate() {
        let state = State { distance: unit.d, speed: unit.v, acceleration: unit.a };
        for (with_acceleration, expected) in [(false, unit.speed), (true, unit.acceleration)] {
            let found = ConflictPassage::of(&state, unit.coll_dist, with_acceleration);
            assert!(
                agrees_relatively(found.entry, expected[0].0) && agrees_relatively(found.exit, expected[1].0),
                "entry_exit {i}: {found:?} is not {:?}",
                expected.map(|e| e.0),
            );
        }
    }
    println!("{}: compared {} entry and exit times", path.display(), 4 * units.len());
}

fn access_orders_and_their_values(path: &Path) {
    let reference = reference(path);
    let mut compared = 0;
    let mut worst: f64 = 0.0;
    for (i, unit) in reference.units.access.iter().enumerate() {
        let parameters = parameters(&unit.params, format_args!("access {i}"));
        let (own, other) = match unit.ego {
            Kind::Pedestrian => (PEDESTRIAN, VEHICLE),
            Kind::Vehicle => (VEHICLE, PEDESTRIAN),
        };
        let (own, other) = (Party::new(own, &parameters), Party::new(other, &parameters));
        let variant = Variant {
            other_acceleration: unit.consider_other_acc,
            looming: unit.consider_looming,
            ..Variant::default()
        };
        let valuation = Valuation::new(&variant, &parameters);
        let to = State::from(unit.ego_predicted);
        let other_to = State::from(unit.other_predicted);
        let passage = ConflictPassage::of(&other_to, other.body.half_extent, unit.consider_other_acc);
        let orders = access_orders(
            &own.body,
            &own.manner,
            to.distance,
            to.speed,
            &other.body,
            other_to.distance,
            &passage,
        );
        let here = State::from(unit.ego_current);
        let phase = ActionPhase { speed: here.speed, acceleration: unit.action_acc0, jerk: unit.action_jerk };
        let action = valuation.discounting.action(&own.gains, &phase);
        let mine = AgentMove {
            here,
            phase,
            action,
            to: PredictedState { state: to, ..Default::default() },
            ..Default::default()
        };
        let theirs = AgentMove {
            here: unit.other_current.into(),
            to: PredictedState { state: other_to, passage },
            first_acceleration: unit.other_first_acc,
            later_acceleration: unit.other_cont_acc,
            ..Default::default()
        };
        let rules = Rules { pedestrian_priority: true, entry_inhibited: false };
        let value_of = |course: &AccessCourse, is_first| {
            valuation.of_course(&own, &mine, course, is_first, &other, &theirs, &rules)
        };
        for (name, course, implication, expected, is_first) in [
            ("first", orders.first, &unit.implications.first, unit.values.first.0, true),
            ("second", orders.second, &unit.implications.second, unit.values.second.0, false),
        ] {
            let found = course.map_or([f64::NAN; 2], |c| [c.acceleration, c.duration]);
            for (found, expected) in found.iter().zip(implication) {
                assert!(
                    agrees_relatively(*found, expected.0),
                    "access {i}: passing {name} takes {course:?}, not {:?}",
                    implication.map(|x| x.0)
                );
            }
            if let Some(course) = course {
                assert!(
                    agrees_relatively(course.wait, implication[2].0),
                    "access {i}: passing {name} waits {}, not {}",
                    course.wait,
                    implication[2].0
                );
            }
            let value = course.map_or(f64::NEG_INFINITY, |course| value_of(&course, is_first));
            if value.is_finite() {
                worst = worst.max((value / expected - 1.0).abs());
            }
            assert!(
                agrees_relatively(value, expected),
                "access {i}: passing {name} is worth {value}, not {expected} ({unit_kind:?}, looming {})",
                unit.consider_looming,
                unit_kind = unit.ego,
            );
            compared += 4;
        }
    }
    println!(
        "{}: compared {compared} numbers of {} access orders; largest relative deviation of a value {worst:.1e}",
        path.display(),
        2 * reference.units.access.len()
    );
}

/// One road user of a replayed simulation.
struct Replayed<'a> {
    name: &'static str,
    run: &'a Run,
    agent: Option<CommotionsAgent>,
    draws: RecordedDraws<'a>,
    state: State,
    actions: Vec<(usize, usize)>,
    next_probe: usize,
}

impl<'a> Replayed<'a> {
    fn new(name: &'static str, run: &'a Run, draws: &'a [f64], agent: Option<CommotionsAgent>) -> Self {
        Self {
            name,
            run,
            agent,
            draws: RecordedDraws::new(draws),
            state: State { distance: run.d0, speed: run.v0, acceleration: 0.0 },
            actions: Vec::new(),
            next_probe: 0,
        }
    }

    fn acceleration(&mut self, k: usize, dt: f64, other: &State, rules: &Rules) -> f64 {
        match &mut self.agent {
            Some(agent) => {
                let decision = agent.step(&self.state, other, rules, &mut self.draws);
                self.actions.extend(decision.action.map(|j| (k, j)));
                decision.acceleration
            }
            None => {
                let time = k as f64 * dt;
                let last = self.run.profile.iter().rev().find(|&&(from, _)| from <= time + 1e-9);
                last.map_or(0.0, |&(_, acceleration)| acceleration)
            }
        }
    }

    /// What differs from the reference at step k, if anything.
    fn differs(&self, k: usize) -> Option<String> {
        let (d, v) = (self.run.d[k], self.run.v[k]);
        if !agrees_absolutely(self.state.distance, d) || !agrees_absolutely(self.state.speed, v) {
            let State { distance, speed, .. } = self.state;
            return Some(format!("{}: d, v = {distance}, {speed} and not {d}, {v}", self.name));
        }
        None
    }

    /// How many probes were compared at step k, and how many of them differ.
    fn probe(&mut self, k: usize) -> (usize, usize) {
        let run = self.run;
        if run.probe_steps.get(self.next_probe) != Some(&k) {
            return (0, 0);
        }
        let p = self.next_probe;
        self.next_probe += 1;
        let Some(agent) = &self.agent else { return (0, 0) };
        let thoughts = agent.thoughts();
        let mut pairs = Vec::new();
        let probability = |t: &Thoughts, i: usize| t.probabilities[i / 5][i % 5];
        for i in 0..15 {
            let found = thoughts.map_or(f64::NAN, |t| probability(t, i));
            pairs.push((found, run.behaviour_probabilities[p][i].0));
        }
        // Neither estimates nor percepts mean anything at steps that are not decided.
        if let Some(t) = thoughts {
            pairs.extend((0..5).map(|j| (t.estimates[j], run.action_value_estimates[p][j].0)));
            let [d, v] = run.perceived[p];
            pairs.extend([(t.percept.distance, d.0), (t.percept.speed, v.0)]);
        }
        let wrong = pairs.iter().filter(|&&(f, e)| !agrees(f, e, PROBE_TOLERANCE)).count();
        (pairs.len(), wrong)
    }
}

fn agrees_absolutely(found: f64, expected: f64) -> bool {
    (found - expected).abs() <= STATE_TOLERANCE
}

/// How a simulation compares: where it parts from the reference, and how its probes do before that.
#[derive(Default)]
struct Comparison {
    parts: Option<(usize, String)>,
    steps: usize,
    probes: usize,
    wrong_probes: usize,
}

fn replay(i: usize, simulation: &Simulation) -> Comparison {
    let place = format!("simulation {i} ({})", simulation.model);
    let variant: Variant = simulation.model.parse().unwrap_or_else(|e| panic!("{place}: {e}"));
    let parameters = parameters(&simulation.params, &place);
    let Simulation { dt, ped, vehicle, draws, n_steps, .. } = simulation;
    let rules = Rules { pedestrian_priority: simulation.pedestrian_priority, entry_inhibited: false };
    let steps = (simulation.end_time / dt).round() as usize;
    assert_eq!(*n_steps, steps, "{place}: n_steps is not end_time/dt");
    for run in [ped, vehicle] {
        let lengths = [run.d.len(), run.v.len(), run.a.len()];
        assert_eq!(lengths, [steps; 3], "{place}: d, v and a must have n_steps numbers");
        let probes = run.probe_steps.len();
        let lengths =
            [run.action_value_estimates.len(), run.behaviour_probabilities.len(), run.perceived.len()];
        assert_eq!(lengths, [probes; 3], "{place}: every probe step needs its numbers");
    }
    let encounter = |own, other| AgentEncounter { own, other, dt: *dt };
    let walker = CommotionsAgent::new(&variant, &parameters, &encounter(PEDESTRIAN, VEHICLE));
    let driver = (vehicle.kind == Some(Driver::Commotions))
        .then(|| CommotionsAgent::new(&variant, &parameters, &encounter(VEHICLE, PEDESTRIAN)));
    let mut both = [
        Replayed::new("pedestrian", ped, &draws.ped, Some(walker)),
        Replayed::new("vehicle", vehicle, &draws.vehicle, driver),
    ];
    let mut comparison = Comparison::default();
    for k in 0..steps {
        if k > 0 {
            both.iter_mut().for_each(|one| one.state = one.state.step(*dt));
        }
        if let Some(difference) = both.iter().find_map(|one| one.differs(k)) {
            comparison.parts = Some((k, difference));
            return comparison;
        }
        let states = [both[0].state, both[1].state];
        for (one, other) in both.iter_mut().zip([states[1], states[0]]) {
            let acceleration = one.acceleration(k, *dt, &other, &rules);
            one.state.acceleration = acceleration;
        }
        for one in &mut both {
            let expected: Vec<_> = one.run.actions.iter().filter(|&&(step, _)| step == k).collect();
            let found: Vec<_> = one.actions.iter().filter(|&&(step, _)| step == k).collect();
            if found != expected {
                let said = format!("{}: [step, action] {found:?} and not {expected:?}", one.name);
                comparison.parts = Some((k, said));
                return comparison;
            }
            let (probes, wrong) = one.probe(k);
            comparison.probes += probes;
            comparison.wrong_probes += wrong;
        }
        comparison.steps += 1;
    }
    for one in &both {
        assert!(
            one.draws.is_used_up(),
            "{place}: the {} took {} draws of those recorded",
            one.name,
            one.draws.taken()
        );
        for (k, &a) in one.run.a.iter().enumerate().filter(|_| one.agent.is_none()) {
            let last = one.run.profile.iter().rev().find(|&&(from, _)| from <= k as f64 * dt + 1e-9);
            let expected = last.map_or(0.0, |&(_, a)| a);
            assert!(agrees(a, expected, 1e-9), "{place}: the profile gives {expected} at step {k}, not {a}");
        }
    }
    comparison
}

fn simulations(path: &Path) {
    let reference = reference(path);
    let total = reference.simulations.len();
    let (mut steps, mut probes, mut wrong_probes, mut parted) = (0, 0, 0, 0);
    for (i, simulation) in reference.simulations.iter().enumerate() {
        let comparison = replay(i, simulation);
        steps += comparison.steps;
        probes += comparison.probes;
        wrong_probes += comparison.wrong_probes;
        if comparison.wrong_probes > 0 {
            println!("simulation {i} ({}): {} probes differ", simulation.model, comparison.wrong_probes);
        }
        if let Some((step, difference)) = comparison.parts {
            parted += 1;
            println!("simulation {i} ({}) parts at step {step}: {difference}", simulation.model);
        }
    }
    println!(
        "{}: compared {total} simulations, {steps} steps and {probes} probes; {parted} part, {wrong_probes} probes differ",
        path.display()
    );
    // What parts does so at the knife edge of the specification's section 6.
    assert!(parted * 20 <= total, "{parted} of {total} simulations part from the reference");
    assert!(wrong_probes * 10_000 <= probes, "{wrong_probes} of {probes} probes differ");
}
