//! What is drawn of runs over time is what metrics measure, on straight roads and in bends: times to collision, and who is in a shared area when.
//! Recording it changes nothing.

use std::path::Path;

use files::Disk;
use models::standard;
use results::{Outcome, Recording, Requests};
use runner::plan::plan;
use runner::run::{MeasuredMetrics, RunBatch, Serialised, Stop, Threads, Wanted};
use scenario::{MetricReference, Settings, Value, Worst};
use sim::measure::{PairDetails, RunDetails, StepReadings, difference};

/// Whose sample may be higher than the metric by so much, s: the metric looks at every step, and times to collision fall by about a second
/// each second.
const BETWEEN_SAMPLES: f64 = 0.12;

fn straight() -> MetricReference {
    let registry = standard();
    let mut reference = MetricReference::plain(registry.metrics().get("min_ttc").unwrap());
    reference.settings = Settings([("prediction".into(), Value::Word("straight".into()))].into());
    reference
}

/// The least time to collision over all pairs that did not touch, and 0 if one did.
fn least<'p>(
    pairs: &'p [PairDetails],
    of: impl Fn(&'p PairDetails) -> &'p [Option<f64>],
) -> Option<(f64, usize, usize)> {
    let each = pairs.iter().filter_map(|pair| {
        let least = of(pair).iter().flatten().copied().reduce(f64::min);
        let least = if pair.contact.is_some() { Some(0.0) } else { least };
        Some((least?, pair.vehicle, pair.pedestrian))
    });
    each.reduce(|one, other| if other.0 < one.0 { other } else { one })
}

fn along(pair: &PairDetails) -> &[Option<f64>] {
    &pair.time_to_collision
}

fn straight_on(pair: &PairDetails) -> &[Option<f64>] {
    if pair.straight_on.is_empty() { &pair.time_to_collision } else { &pair.straight_on }
}

/// Post-encroachment time by the recorded passings, s.
fn pet(pair: &PairDetails) -> Option<f64> {
    let between =
        pair.passings.iter().filter_map(|one| Some(difference(one.vehicle.time()?, one.pedestrian).abs()));
    if pair.contact.is_some() { Some(0.0) } else { between.reduce(f64::min) }
}

/// The same by the recorded stays.
fn pet_area(pair: &PairDetails) -> Option<f64> {
    let between = pair.visits.iter().filter_map(|visit| {
        let (enters, leaves) = (visit.enters.moment(), visit.leaves.moment());
        let to = visit.to.unwrap_or(f64::INFINITY);
        let is_there = enters < f64::INFINITY && leaves > f64::NEG_INFINITY;
        is_there.then(|| difference(enters, to).max(difference(visit.from, leaves)).max(0.0))
    });
    if pair.contact.is_some() { Some(0.0) } else { between.reduce(f64::min) }
}

/// Metrics that are the worst over time of something.
const OVER_TIME: [&str; 9] = [
    "min_ttc",
    "min_distance",
    "drac",
    "time_headway",
    "max_deceleration",
    "max_jerk",
    "lateral_acceleration",
    "vehicle_ttc",
    "vehicle_distance",
];

/// What is drawn of a metric over time comes to its value to the last bit, also where it is thinned out; and nothing is of what is known at the end
/// alone. How many there are.
fn compare_readings(
    requests: &Requests,
    outcome: &Outcome,
    details: &RunDetails,
    recording: &Recording,
) -> usize {
    let mut compared = 0;
    for (index, request) in requests.iter().enumerate() {
        let of = |all: &[StepReadings]| -> Option<Vec<Option<f64>>> {
            let found = all.iter().find(|one| one.metric == index)?;
            Some(found.worst_so_far().collect())
        };
        let (exact, thinned) = (of(&details.readings), of(&recording.readings));
        let value = outcome.metrics[index];
        let known = OVER_TIME.contains(&request.name()) && value.is_some();
        assert_eq!((exact.is_some(), thinned.is_some()), (known, known), "{}", request.name());
        let (Some(exact), Some(thinned)) = (exact, thinned) else { continue };
        compared += 1;
        assert_eq!((exact.len(), thinned.len()), (details.times.len(), recording.times.len()));
        for so_far in [&exact, &thinned] {
            assert_eq!(*so_far.last().unwrap(), value, "{}", request.name());
            // It only gets worse, and is there from when it is known on.
            let smallest = request.known().unwrap().worst == Worst::Smallest;
            assert!(so_far.windows(2).all(|pair| match (pair[0], pair[1]) {
                (Some(one), Some(other)) =>
                    if smallest {
                        other <= one
                    } else {
                        other >= one
                    },
                (before, _) => before.is_none(),
            }));
        }
        // What is drawn at a time is what was so until then.
        for (time, known) in recording.times.iter().zip(&thinned) {
            let steps = details.times.partition_point(|end| end <= time);
            let is_last = Some(time) == recording.times.last();
            assert!(
                is_last || *known == steps.checked_sub(1).and_then(|last| exact[last]),
                "{}",
                request.name()
            );
        }
    }
    compared
}

fn timeless(outcome: &Outcome) -> Outcome {
    Outcome { wall_time: Default::default(), ..outcome.clone() }
}

#[test]
fn what_is_drawn_is_what_metrics_measure() {
    let mut readings = 0;
    let (mut urgent, mut bent, mut differ, mut gaps, mut samples, mut worst) = (0, 0, 0, 0, 0, 0.0_f64);
    for file in ["zebra_unsafe", "zebra", "streets", "euro_ncap_vru", "nhtsa_precrash"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("suites/{file}.suite"));
        let suite = lang::load(&path, &standard(), &Disk).unwrap_or_else(|_| panic!("{file}")).suite;
        let mut requests = Requests::defaults(&standard());
        requests.add(&straight());
        for name in ["vehicle_ttc", "vehicle_distance"] {
            requests.add(&MetricReference::plain(standard().metrics().get(name).unwrap()));
        }
        let index = |name: &str| requests.iter().position(|one| one.name() == name).unwrap();
        let (ttc, ttc_straight) = (index("min_ttc"), requests.index(&straight()).unwrap());
        let (by_centres, by_areas) = (index("pet"), index("pet_area"));
        let (measured, stop, threads) = (MeasuredMetrics::new(requests), Stop::default(), Threads::new(1));
        let batch = RunBatch { executor: &threads, measured: &measured, stop: &stop };
        for trial in plan(&suite).unwrap().trials().take(40) {
            let case = trial.cases.first();
            let Ok(ran) = batch.one(&case, Wanted::Details) else { continue };
            let plain = batch.one(&case, Wanted::Outcome).unwrap().outcome;
            assert_eq!(timeless(&ran.outcome), timeless(&plain), "{}", case.key);
            let metric = |index: usize| ran.outcome.metrics[index];
            let details = ran.details.as_deref().unwrap();
            // Of every step it is the metric to the last bit, and of the same pair.
            let found = least(&details.pairs, along);
            assert_eq!(found.map(|(value, ..)| value), metric(ttc), "{}", case.key);
            assert_eq!(
                least(&details.pairs, straight_on).map(|(value, ..)| value),
                metric(ttc_straight),
                "{}",
                case.key
            );
            if let (Some((_, car, person)), Some(critical)) = (found, ran.outcome.critical.get(ttc)) {
                let names = (&*case.world.vehicles[car].name, &*case.world.pedestrians[person].name);
                let critical = (critical.vehicle.as_deref(), critical.pedestrian.as_deref());
                assert_eq!((Some(names.0), Some(names.1)), critical, "{}", case.key);
            }
            let smallest =
                |of: fn(&PairDetails) -> Option<f64>| details.pairs.iter().filter_map(of).reduce(f64::min);
            assert_eq!(smallest(pet), metric(by_centres), "{}", case.key);
            assert_eq!(smallest(pet_area), metric(by_areas), "{}", case.key);
            // Samples are never lower than it, and near it.
            let recording = Recording::new(&case, &ran.trace, ran.events.clone()).with(Some(details));
            assert!(
                recording.meetings.iter().all(|pair| pair.time_to_collision.len() == recording.times.len())
            );
            readings += compare_readings(&measured.requests, &ran.outcome, details, &recording);
            for (drawn, exact) in recording.meetings.iter().zip(&details.pairs) {
                let of =
                    |pair: &PairDetails| pair.time_to_collision.iter().flatten().copied().reduce(f64::min);
                let (Some(drawn), Some(exact)) = (of(drawn), of(exact)) else { continue };
                assert!(drawn >= exact, "{} {drawn} {exact}", case.key);
                (samples, worst) = (samples + 1, worst.max(drawn - exact));
            }
            urgent += usize::from(metric(ttc).is_some_and(|time| time > 0.0));
            bent += usize::from(details.pairs.iter().any(|pair| !pair.straight_on.is_empty()));
            differ += usize::from(metric(ttc) != metric(ttc_straight));
            gaps += usize::from(metric(by_areas).is_some_and(|time| time > 0.0));
            let written = serde_json::to_string(&recording).unwrap();
            assert_eq!(serde_json::from_str::<Recording>(&written).unwrap(), recording);
        }
    }
    println!(
        "{urgent} urgent, {bent} in bends, {differ} otherwise straight on, {gaps} gaps, {samples} samples, worst {worst}"
    );
    assert!(urgent > 20 && bent > 10 && differ > 2 && gaps > 20 && samples > 20);
    assert!(readings > 500, "{readings}");
    assert!(worst < BETWEEN_SAMPLES, "{worst}");
}

/// A person's state is recorded of runs that are drawn, is the same through bytes, and changes nothing.
#[test]
fn what_a_person_makes_of_it_is_recorded() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("suites/zebra.suite");
    let suite = lang::load(&path, &standard(), &Disk).unwrap_or_else(|_| panic!("a suite")).suite;
    let measured = MeasuredMetrics::new(Requests::defaults(&standard()));
    let (stop, threads) = (Stop::default(), Threads::new(1));
    let bytes = Serialised::new(Threads::new(1), standard());
    let mut seen = 0;
    for trial in plan(&suite).unwrap().trials().take(30) {
        let case = trial.cases.first();
        let batch = RunBatch { executor: &threads, measured: &measured, stop: &stop };
        let ran = batch.one(&case, Wanted::Details).unwrap();
        let there = RunBatch { executor: &bytes, ..batch }.one(&case, Wanted::Details).unwrap();
        assert_eq!(ran.details, there.details, "{}", case.key);
        let recording = Recording::new(&case, &ran.trace, ran.events).with(ran.details.as_deref());
        let cars = case.world.vehicles.len();
        for (person, (setup, state)) in
            case.world.pedestrians.iter().zip(&ran.details.as_ref().unwrap().people).enumerate()
        {
            let is_commotions = setup.model.model.name() == "commotions";
            assert_eq!(!state.quantities.is_empty(), is_commotions, "{}", case.key);
            if !is_commotions {
                assert!(state.states.is_empty());
                continue;
            }
            seen += 1;
            let drawn = &recording.states[person];
            assert_eq!((drawn.quantities.len(), drawn.states.len()), (13, recording.times.len()));
            assert!(drawn.states.iter().any(Option::is_some), "{}", case.key);
            for (index, state) in drawn.states.iter().enumerate() {
                let Some(state) = state else { continue };
                assert!(recording.users[cars + person][index].is_some());
                assert!(state.about.is_some_and(|car| car < cars) && state.values.len() == 13);
                // Beliefs are probabilities of what is possible.
                let sum: f64 = state.values[10..].iter().sum();
                assert!(
                    (sum - 1.0).abs() < 1e-3
                        && state.values[10..].iter().all(|one| (0.0..=1.0).contains(one))
                );
            }
        }
    }
    assert!(seen >= 4, "{seen}");
}
