//! Baselines from outcomes.

use std::collections::BTreeMap;

use serde::Serialize;
use sha2::{Digest, Sha256};
use thiserror::Error;

use crate::plan::{Plan, PlannedTrial};
use crate::run::{Executor, departures, nothing_is_drawn};
use files::hexadecimal;
use results::judge::baseline::{Baseline, Parts, RecordedMetric, RecordedTrial, TestedVehicle};
use results::judge::gate::vehicle_changes;
use results::{AgainstBaseline, MetricThen, Outcome, Requests};
use scenario::registry::Registry;
use scenario::{
    ANOTHER_MODEL, Case, DeclaredProgram, MetricKind, MetricReference, PedestrianSetup, Road, Suite,
    VehicleSetup, VehicleStart, World,
};
use sim::StopReason;

/// Digits of a value that are kept: enough for any comparison, and short enough to read.
const DIGITS: usize = 9;

/// The baseline of the trials of a plan that were run to their end, each with its outcomes in the order of its cases.
pub fn record(plan: &Plan, trials: &[(&PlannedTrial, &[Outcome])], requests: &Requests) -> Baseline {
    let mut outcomes = trials.to_vec();
    outcomes.sort_by(|left, right| left.0.key.cmp(&right.0.key));
    let mut recorded = frame(plan, outcomes.iter().map(|(trial, _)| *trial), requests);
    for (index, (_, outcomes)) in outcomes.iter().enumerate() {
        recorded.trials[index].fingerprint = courses(*outcomes);
        for (run, outcome) in outcomes.iter().enumerate() {
            record_outcome(&mut recorded, (index, run), outcome, requests);
        }
    }
    recorded
}

/// Writes down what a run came to: that of so many in the trial with this index.
pub fn record_outcome(
    recorded: &mut Baseline,
    (trial, run): (usize, usize),
    outcome: &Outcome,
    requests: &Requests,
) {
    let Baseline { metrics, trials, .. } = recorded;
    trials[trial].cut_off += usize::from(is_cut_off(outcome));
    for (row, metric) in trials[trial].values.iter_mut().zip(metrics) {
        let measured = requests.iter().position(|one| one.label() == metric.label);
        row[run] = outcome.metrics[measured.expect("it was measured")].map(rounded);
    }
}

/// Whether it is not known what it would have come to. What ended it by a contact was seen, if nobody else was about to touch.
fn is_cut_off(outcome: &Outcome) -> bool {
    outcome.cut_off.as_ref().is_some_and(|cut| {
        !cut.on_course.is_empty()
            || (outcome.ending.reason == StopReason::Horizon && !cut.unfinished.is_empty())
    })
}

/// The baseline of trials of a plan of which no run was made yet.
pub fn frame<'t>(
    plan: &Plan,
    trials: impl Iterator<Item = &'t PlannedTrial>,
    requests: &Requests,
) -> Baseline {
    let suite = plan.suite.as_str();
    let mut trials: Vec<&PlannedTrial> = trials.collect();
    let what_runs = what_runs(trials.iter().copied());
    trials.sort_by(|left, right| left.key.cmp(&right.key));
    let mut vehicles: Vec<Vec<TestedVehicle>> = Vec::new();
    let mut recorded = Vec::with_capacity(trials.len());
    for trial in trials {
        // Of drawn runs each is another; the one in the middle stands for all that they do not draw.
        let middle = trial.cases.middle();
        let tested = tested_vehicles(middle.as_ref().unwrap_or(&trial.cases.first()));
        let place = vehicles.iter().position(|known| *known == tested).unwrap_or_else(|| {
            vehicles.push(tested);
            vehicles.len() - 1
        });
        let label = |run: usize| {
            let key = trial.cases.key(run);
            key.strip_prefix(&trial.key).unwrap_or(&key).trim_start_matches('/').to_string()
        };
        recorded.push(RecordedTrial {
            key: trial.key.strip_prefix(&format!("{}{suite}/", plan.apart)).unwrap_or(&trial.key).to_string(),
            scenario: trial.scenario.clone(),
            certain: nothing_is_drawn(&trial.cases),
            fingerprint: String::new(),
            seeds: Some(seeds(trial)),
            cut_off: 0,
            warnings: departures(trial),
            parts: trial_parts(trial, middle),
            vehicles: place,
            runs: (0..trial.cases.len()).map(label).collect(),
            values: vec![vec![None; trial.cases.len()]; requests.iter().count()],
        });
    }
    Baseline {
        suite: suite.to_string(),
        apart: plan.apart.clone(),
        seed: plan.seed,
        set: plan.set.clone(),
        tool: env!("CARGO_PKG_VERSION").to_string(),
        populations: plan.populations.clone(),
        population_versions: versions(&plan.populations),
        programs: BTreeMap::new(),
        what_runs,
        nondeterministic: BTreeMap::new(),
        metrics: requests.iter().map(metric).collect(),
        vehicles,
        trials: recorded,
    }
}

/// Changes when any bit of any run's course does.
fn courses<'o>(outcomes: impl IntoIterator<Item = &'o Outcome>) -> String {
    hash(&outcomes.into_iter().map(|outcome| outcome.fingerprint).collect::<Vec<_>>(), 16)
}

/// Changes when the seed of any run does.
fn seeds(trial: &PlannedTrial) -> String {
    hash(&trial.cases.iter().map(|case| case.seed).collect::<Vec<_>>(), 12)
}

/// What decides a trial's runs besides what is tested; of drawn runs the one in the middle stands for all.
fn trial_parts(trial: &PlannedTrial, middle: Option<Case>) -> Parts {
    match middle {
        Some(middle) => Parts {
            simulation: hash(&(trial.cases.declared_draws(), simulation(&middle.world)), 12),
            ..parts(&[Case { individuals: Vec::new(), ..middle }])
        },
        None => parts(&trial.cases.iter().collect::<Vec<_>>()),
    }
}

/// Why a run cannot be laid beside what a baseline keeps.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum NotKept {
    /// It is of another suite.
    #[error("it is the baseline of the suite `{0}`")]
    Suite(String),
    /// It has no such run.
    #[error("it has no run `{0}`")]
    Run(String),
    /// The run has another seed now.
    #[error("its runs of `{trial}` have other seeds than now: the suite's was {seed}")]
    Noise {
        /// The trial's name.
        trial: String,
        /// The seed of the suite then.
        seed: u64,
    },
}

/// A run of a trial, laid beside what a baseline keeps of it; `outcome` is what it came to now.
///
/// # Errors
/// If the baseline does not have it, or not on the same noise.
pub fn against_baseline(
    baseline: &Baseline,
    suite: &str,
    trial: &PlannedTrial,
    outcome: &Outcome,
    requests: &Requests,
) -> Result<AgainstBaseline, NotKept> {
    if baseline.suite != suite {
        return Err(NotKept::Suite(baseline.suite.clone()));
    }
    let place = baseline.trials.iter().find_map(|kept| {
        let run = (0..kept.runs.len()).find(|run| baseline.run_key(kept, *run) == outcome.key)?;
        Some((kept, run))
    });
    let (kept, run) = place.ok_or_else(|| NotKept::Run(outcome.key.clone()))?;
    if !kept.certain && kept.seeds.as_ref().is_some_and(|kept| *kept != seeds(trial)) {
        return Err(NotKept::Noise { trial: trial.key.clone(), seed: baseline.seed });
    }
    let middle = trial.cases.middle();
    let tested = tested_vehicles(middle.as_ref().unwrap_or(&trial.cases.first()));
    let (then, now) = (&kept.parts, trial_parts(trial, middle));
    let mut differs: Vec<String> = Vec::new();
    let before = &baseline.vehicles[kept.vehicles];
    if before.len() != tested.len() {
        differs.push(format!("{} vehicles -> {}", before.len(), tested.len()));
    }
    for (before, after) in before.iter().zip(&tested) {
        differs.extend(vehicle_changes(before, after).iter().map(ToString::to_string));
    }
    differs.extend(part_words(then, &now));
    let mut metrics = Vec::new();
    let mut new = Vec::new();
    for (index, reference) in requests.iter().enumerate() {
        let known = metric(reference);
        match baseline.metrics.iter().position(|one| one.is_as(&known)) {
            Some(row) => metrics.push(MetricThen {
                index,
                then: kept.values[row][run],
                now: outcome.metrics[index].map(rounded),
            }),
            None => new.push(known.label),
        }
    }
    let same_course = (kept.runs.len() == 1).then(|| kept.fingerprint == courses([outcome]));
    Ok(AgainstBaseline { differs, same_course, metrics, new })
}

/// Which versions those populations are that ship.
fn versions(populations: &BTreeMap<String, String>) -> BTreeMap<String, u32> {
    let version = |name: &String| Some((name.clone(), scenario::population::shipped_version(name)?));
    populations.keys().filter_map(version).collect()
}

/// What runs as each of the declared controllers of the trials, by what files call them.
fn what_runs<'t>(trials: impl Iterator<Item = &'t PlannedTrial>) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    for trial in trials {
        for world in trial.cases.worlds() {
            let programs =
                world.vehicles.iter().filter_map(|car| car.controller.model.known()?.program.as_ref());
            programs.for_each(|one| _ = found.insert(one.name.clone(), one.identity()));
        }
    }
    found
}

/// What the programs under test of a suite say of themselves, by what its files call them.
pub fn program_titles(executor: &dyn Executor, suite: &Suite) -> BTreeMap<String, String> {
    let scenarios = suite.scenarios.iter().chain(&suite.supporting);
    let models: Vec<_> =
        scenarios.flat_map(|one| &one.vehicles).flat_map(|car| car.controller.all()).collect();
    let is_named = |program: &DeclaredProgram| {
        let programs = models.iter().filter_map(|model| model.known()?.program.as_deref());
        programs.into_iter().any(|named| named == program)
    };
    let uses = executor.program_uses().into_iter();
    let said = uses.filter(|one| !one.title.is_empty() && is_named(&one.program));
    said.map(|one| (one.program.name.clone(), one.title)).collect()
}

/// Every metric that is kept of a suite's runs: those there are, and what its criteria and gates are about.
pub fn measured_metrics(suite: &Suite, registry: &Registry) -> Requests {
    let mut requests = Requests::defaults(registry);
    suite.scenarios.iter().for_each(|scenario| requests.include(&scenario.criteria));
    let rules = suite.gates.iter().flat_map(|gate| &gate.rules);
    rules.filter_map(|rule| rule.metric.as_ref()).for_each(|metric| requests.add(metric));
    requests
}

fn metric(reference: &MetricReference) -> RecordedMetric {
    let metric = reference.known().expect("requests were checked against the registry");
    RecordedMetric {
        label: reference.label(),
        name: reference.metric.clone(),
        unit: match &metric.kind {
            MetricKind::Quantity(dimension) => dimension.si_unit(),
            MetricKind::Flag => "yes or no".to_string(),
            MetricKind::Category(words) => words.join(" or "),
        },
        settings: metric.declaration.resolve(&reference.settings).expect("settings were checked"),
        pair: reference.pair.clone(),
    }
}

fn tested_vehicles(case: &Case) -> Vec<TestedVehicle> {
    let tested = |vehicle: &VehicleSetup| {
        let VehicleSetup {
            name,
            controller,
            dynamics,
            length,
            width,
            road: _,
            lane: _,
            speed: _,
            initial_speed: _,
            start: _,
            behind: _,
            sees,
            obeys_signals,
        } = vehicle.clone();
        TestedVehicle { name, controller, dynamics, sees, length, width, obeys_signals }
    };
    case.world.vehicles.iter().map(tested).collect()
}

/// What stands around the tested vehicles. All of a world is in here or in [`tested_vehicles`]: whoever adds something to it
/// decides where.
fn parts(cases: &[Case]) -> Parts {
    let World {
        road,
        other_roads,
        streams: _,
        vehicles,
        pedestrians: _,
        step: _,
        horizon: _,
        finish: _,
        end_on_collision: _,
    } = &*cases[0].world;
    let traffic: Vec<_> = vehicles
        .iter()
        .map(|vehicle| {
            let VehicleSetup {
                name,
                controller: _,
                dynamics: _,
                length: _,
                width: _,
                road,
                lane,
                speed,
                initial_speed,
                start,
                behind,
                sees: _,
                obeys_signals: _,
            } = vehicle;
            // Of whom nothing is said about it is known by the hash of before that could be said.
            if let Some(initial) = initial_speed {
                return Traffic::Starting(name, (*road, *lane), (*initial, *speed), *start, *behind);
            }
            match (*road, *behind) {
                (0, 0.0) => Traffic::ByCentre(name, *lane, *speed, *start),
                (0, behind) => Traffic::Behind(name, *lane, *speed, *start, behind),
                (road, behind) => Traffic::Elsewhere(name, (road, *lane), *speed, *start, behind),
            }
        })
        .collect();
    let people: Vec<_> = cases.iter().map(|case| &case.individuals).collect();
    Parts {
        road: match other_roads.is_empty() {
            true => hash(&road.unnamed(), 12),
            false => hash(&(road.unnamed(), other_roads.iter().map(Road::unnamed).collect::<Vec<_>>()), 12),
        },
        pedestrians: hash(&cases.iter().map(impersonal).collect::<Vec<_>>(), 12),
        people: hash(&people, 12),
        traffic: hash(&traffic, 12),
        simulation: hash(&simulation(&cases[0].world), 12),
    }
}

/// What is not the same in two cases, a few words each: of every vehicle what is tested, and else only which part of the world.
pub fn differences(before: &Case, after: &Case) -> Vec<String> {
    let vehicles = [tested_vehicles(before), tested_vehicles(after)];
    let mut found: Vec<String> = Vec::new();
    if vehicles[0].len() != vehicles[1].len() {
        found.push(format!("{} vehicles -> {}", vehicles[0].len(), vehicles[1].len()));
    }
    for (before, after) in vehicles[0].iter().zip(&vehicles[1]) {
        found.extend(vehicle_changes(before, after).iter().map(ToString::to_string));
    }
    let one_of = |case: &Case| parts(std::slice::from_ref(case));
    found.extend(part_words(&one_of(before), &one_of(after)));
    found
}

/// What is not the same of what stands around the tested vehicles.
fn part_words(before: &Parts, after: &Parts) -> impl Iterator<Item = String> + use<> {
    let rest = [
        ("the road", before.road != after.road),
        ("pedestrians", before.pedestrians != after.pedestrians),
        ("people", before.people != after.people),
        ("how fast vehicles drive and from where", before.traffic != after.traffic),
        ("how long and in which steps is simulated", before.simulation != after.simulation),
    ];
    rest.into_iter().filter(|(_, differs)| *differs).map(|(what, _)| what.to_string())
}

/// How a world is simulated, and until when.
fn simulation(world: &World) -> (f64, f64, f64, bool) {
    (world.step, world.horizon, world.finish, world.end_on_collision)
}

/// Where a tested vehicle drives.
#[derive(Serialize)]
#[serde(untagged)]
enum Traffic<'a> {
    ByCentre(&'a str, usize, f64, VehicleStart),
    Behind(&'a str, usize, f64, VehicleStart, f64),
    /// On another road than the first, with its number before that of the lane.
    Elsewhere(&'a str, (usize, usize), f64, VehicleStart, f64),
    /// With the speed that it starts with before that of its cruise.
    Starting(&'a str, (usize, usize), (f64, f64), VehicleStart, f64),
}

/// A case's pedestrians without what their individuals bring, and without the flag that changes no run.
fn impersonal(case: &Case) -> Vec<PedestrianSetup> {
    let mut pedestrians = case.world.pedestrians.clone();
    for setup in &mut pedestrians {
        setup.model.settings.0.remove(ANOTHER_MODEL);
        for person in case.individuals.iter().filter(|person| person.pedestrian == setup.name) {
            setup.model.settings.0.retain(|name, _| !person.parameters.0.contains_key(name));
        }
    }
    pedestrians
}

fn hash(value: &impl Serialize, digits: usize) -> String {
    let text = serde_json::to_vec(value).expect("plain data serialises");
    let mut all = hexadecimal(&Sha256::digest(text));
    all.truncate(digits);
    all
}

/// With few enough digits to read. What is nearer to 0 than a thousand-millionth of a unit is the rounding of a 0.
fn rounded(value: f64) -> f64 {
    if value.abs() < 1e-9 {
        return 0.0;
    }
    format!("{value:.*e}", DIGITS - 1).parse().expect("a number that was just written")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_keep_nine_digits() {
        assert_eq!(rounded(3.420_195_823_746_1), 3.420_195_82);
        assert_eq!(rounded(-1.0e-8 / 3.0), -3.333_333_33e-9);
        assert_eq!(rounded(-2.7e-15), 0.0);
        assert!(rounded(-0.0).is_sign_positive());
        assert_eq!(rounded(123_456_789_123.0), 123_456_789_000.0);
    }
}
