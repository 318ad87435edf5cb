//! What would have come of a run: a change of nothing changes no bit, and what is told of a change is what a file that says so comes to.

use std::path::Path;
use std::sync::Arc;

use files::{Disk, Memory};
use models::standard;
use results::{CameOf, Otherwise, Outcome, Requests, Story};
use runner::plan::plan;
use runner::run::{MeasuredMetrics, Ran, RunBatch, Serialised, Shuffled, Stop, Threads, Wanted};
use runner::why::story;
use scenario::{Case, Criterion, Suite};
use sim::RunChange;

fn measured(suite: &Suite) -> Arc<MeasuredMetrics> {
    let mut requests = Requests::defaults(&standard());
    suite.scenarios.iter().for_each(|scenario| requests.include(&scenario.criteria));
    MeasuredMetrics::new(requests)
}

fn shipped(file: &str) -> Suite {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    lang::load(&path, &standard(), &Disk).unwrap_or_else(|_| panic!("{file} is a suite")).suite
}

fn written(text: &str) -> (Suite, Case, Vec<Criterion>) {
    let files = Memory::default().with("a.scn", text);
    let suite = lang::load(Path::new("a.scn"), &standard(), &files)
        .unwrap_or_else(|failure| panic!("{}", failure.render(lang::Style::default())))
        .suite;
    let (case, criteria) = {
        let plan = plan(&suite).unwrap();
        let trial = plan.trials().next().unwrap();
        (trial.cases.first(), trial.criteria.to_vec())
    };
    (suite, case, criteria)
}

fn timeless(outcome: &Outcome) -> Outcome {
    Outcome { wall_time: Default::default(), ..outcome.clone() }
}

fn told(text: &str) -> Story {
    let (suite, case, criteria) = written(text);
    let (measured, stop, threads) = (measured(&suite), Stop::default(), Threads::new(1));
    story(RunBatch { executor: &threads, measured: &measured, stop: &stop }, &case, &criteria).unwrap()
}

/// A change of nothing is the run itself, of everybody in suites with pedals and accelerations, bends, meetings and several people.
#[test]
fn a_change_of_nothing_changes_no_bit() {
    let (mut people, mut braked) = (0, 0);
    for file in ["zebra", "zebra_unsafe", "streets", "nhtsa_precrash", "euro_ncap_vru"] {
        let path = format!("suites/{file}.suite");
        let suite = shipped(&path);
        let (measured, stop, threads) = (measured(&suite), Stop::default(), Threads::new(1));
        let batch = RunBatch { executor: &threads, measured: &measured, stop: &stop };
        let plan = plan(&suite).unwrap();
        for trial in plan.trials().take(12) {
            let case = trial.cases.first();
            let plain = batch.one(&case, Wanted::Outcome).unwrap().outcome;
            let Ran { outcome, commands, .. } = batch.one(&case, Wanted::Commands).unwrap();
            assert_eq!(timeless(&outcome), timeless(&plain), "noting commands changes nothing: {}", case.key);
            let same = |change: RunChange| {
                let ran = batch.one_otherwise(&case, Some(&change), Wanted::Outcome).unwrap();
                assert_eq!(timeless(&ran.outcome), timeless(&plain), "{} {change:?}", case.key);
            };
            for pedestrian in 0..case.world.pedestrians.len() {
                people += 1;
                same(RunChange::AppearsLater { pedestrian, by: 0.0 });
            }
            for (vehicle, commands) in commands.into_iter().enumerate() {
                braked += usize::from(commands.iter().any(|one| sim::brakes(one.command)));
                let until = plain.ending.time;
                same(RunChange::BrakesEarlier { vehicle, from: 0.0, by: 0.0, commands, until });
                // Later than the run.
                same(RunChange::Decelerates {
                    vehicle,
                    from: until + 1.0,
                    deceleration: 9.0,
                    until_gone: None,
                });
            }
        }
    }
    assert!(people > 20 && braked > 8, "{people} people, {braked} vehicles that brake");
}

/// A car that keeps its speed, and somebody who stands in its way.
const STANDS: &str = "scenario stands {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller constant_speed; speed 36 km/h; start 60 m before crossing }
  pedestrian walker {
    model scripted { speed: 1.5 m/s, stop_after: 2.75 m, stop_for: 12 s }
    start 1 m from kerb
    appears at 1 s
  }
  horizon 60 s
  expect { no collision }
}
";

#[test]
fn the_deceleration_that_is_enough_is_that_of_the_way_that_is_left() {
    let story = told(STANDS);
    let contact = story.contact.as_ref().expect("nobody brakes");
    let seen = &story.first_seen[0];
    let (time, speed) = (seen.time.unwrap(), seen.speed.unwrap());
    assert!((time - 1.0).abs() < 0.03 && seen.sees_everything && (speed - 10.0).abs() < 1e-9);
    // Until the contact it drives on at its speed: so much is left to stop in.
    let left = speed * (contact.time - time);
    let needed = speed * speed / (2.0 * left);
    let [earlier, harder, later, nobody] = &story.otherwise[..] else { panic!("{:?}", story.otherwise) };
    assert!(matches!(&earlier.came, CameOf::DoesNotApply { because } if because.contains("did not brake")));
    let Otherwise::Decelerates { from, is_first_braking: false, .. } = &harder.what else {
        panic!("{harder:?}")
    };
    assert_eq!(*from, seen.time);
    let CameOf::Decelerations(tried) = &harder.came else { panic!("{harder:?}") };
    for one in tried {
        assert_eq!(one.run.contact.is_none(), one.deceleration > needed, "{} of {needed}", one.deceleration);
        if let Some(speed_then) = one.run.contact {
            // v² = v₀² − 2 a s
            let square = (speed * speed - 2.0 * one.deceleration * left).sqrt();
            assert!((speed_then - square).abs() < 0.05, "{speed_then} {square}");
        }
    }
    assert!(tried.iter().any(|one| one.run.contact.is_some()) && tried.iter().any(|one| one.run.passes));
    assert!(matches!(&later.came, CameOf::Run(run) if run.contact.is_some() && !run.passes));
    assert!(matches!(&nobody.came, CameOf::Run(run) if run.contact.is_none() && run.passes && !run.cut_off));
    // Who has stopped is let go once the way is free; the others have passed.
    assert!(tried.iter().all(|one| !one.run.cut_off), "{tried:?}");
}

/// The smallest deceleration of a story with which nothing touches, m/s², and the largest below it that was tried.
fn smallest(story: &Story) -> (f64, f64) {
    let harder = story.otherwise.iter().find(|one| matches!(one.what, Otherwise::Decelerates { .. }));
    let CameOf::Decelerations(tried) = &harder.expect("it is tried").came else { panic!("{harder:?}") };
    assert!(tried.is_sorted_by_key(|one| one.deceleration));
    let found = tried.iter().position(|one| one.run.contact.is_none()).expect("one is enough");
    (tried[found].deceleration, tried[found - 1].deceleration)
}

#[test]
fn the_smallest_deceleration_is_found_to_a_hundredth() {
    let story = told(STANDS);
    let contact = story.contact.as_ref().unwrap();
    let needed = 10.0 / (2.0 * (contact.time - story.first_seen[0].time.unwrap()));
    let (enough, not) = smallest(&story);
    assert!((enough - not - 0.01).abs() < 1e-9, "{enough} {not}");
    assert!(not <= needed && needed <= enough, "{not} {needed} {enough}");
}

/// Two vehicles: the second of the file drives into the first.
fn rear_end(av: &str) -> Story {
    told(&format!(
        "scenario rear_end {{
  road {{ lane_width 3.5 m; speed_limit 80 km/h; crossing zebra }}
  vehicle first {{ controller constant_deceleration {{ deceleration: 4 m/s^2, distance: 12.5 m }}; speed 10 m/s; size 4 m x 1.8 m; start 52 m before crossing }}
  vehicle av {{ {av}; size 4 m x 1.8 m; start 122 m before crossing }}
  pedestrian p {{ model scripted; start 2 m from kerb; along 30 m; appears at 1 s }}
  horizon 40 s
  expect {{ no collision(av, first) }}
}}
"
    ))
}

#[test]
fn of_two_vehicles_it_is_about_the_one_that_strikes() {
    let story = rear_end("controller constant_speed; speed 20 m/s");
    let contact = story.contact.as_ref().expect("nothing slows it");
    assert_eq!((&*contact.vehicle, &*contact.with), ("av", "first"));
    assert!((contact.speed - 20.0).abs() < 1e-9);
    // The first stands with its front at the crossing, 120 m ahead of the other's front less its own length.
    let (enough, not) = smallest(&story);
    let needed = 20.0 * 20.0 / (2.0 * 116.0);
    assert!(not <= needed && needed <= enough + 1e-9, "{not} {needed} {enough}");
    let Otherwise::Decelerates { vehicle, from, is_first_braking: false } = &story.otherwise[1].what else {
        panic!("{:?}", story.otherwise[1])
    };
    assert_eq!((&**vehicle, *from), ("av", Some(0.0)));
}

/// From when it began to brake on, instead of its own braking and beyond what its dynamics can.
#[test]
fn what_would_be_enough_takes_the_place_of_its_own_braking() {
    let story = rear_end("controller idm_aeb; speed 20 m/s; dynamics ideal { max_deceleration: 1 m/s^2 }");
    let contact = story.contact.as_ref().expect("it brakes too little");
    assert_eq!((&*contact.vehicle, &*contact.with), ("av", "first"));
    let Otherwise::Decelerates { vehicle, from: Some(from), is_first_braking: true } =
        &story.otherwise[1].what
    else {
        panic!("{:?}", story.otherwise[1])
    };
    assert_eq!(vehicle, "av");
    let index = story.trace.samples.iter().filter(|sample| sample.who == 1);
    let began =
        index.min_by(|one, other| (one.time - from).abs().total_cmp(&(other.time - from).abs())).unwrap();
    // Its front until the rear of the one that stands.
    let (way, speed) = (-4.0 - (began.position.x + 2.0), began.velocity.norm());
    let needed = speed * speed / (2.0 * way);
    let (enough, not) = smallest(&story);
    assert!(not - 0.02 <= needed && needed <= enough + 0.02, "{not} {needed} {enough}");
}

/// A steered vehicle that swerves out of its lane and comes back says so.
#[test]
fn swerves_and_lane_departures_are_events() {
    let story = told(
        "scenario swerves {
  road { lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked }
  vehicle av { controller idm_aes; speed 50 km/h; start 60 m before crossing }
  pedestrian walker {
    model scripted { speed: 1.4 m/s }
    size 0.5 m x 0.4 m
    start 3.2 m from lane centre
    appears when time_to_arrival(av.front) = 1.5 s
  }
  expect { no collision }
}
",
    );
    let of_av: Vec<_> =
        story.events.iter().filter(|event| event.who == "av").map(|event| &event.what).collect();
    let place = |wanted: fn(&sim::Happening) -> bool| of_av.iter().position(|what| wanted(what));
    let swerves = place(|what| matches!(what, sim::Happening::Swerves { left: true }));
    let leaves = place(|what| matches!(what, sim::Happening::LeavesLane { left: true }));
    let returns = place(|what| matches!(what, sim::Happening::ReturnsToLane));
    assert!(swerves.is_some() && swerves < leaves && leaves < returns, "{of_av:?}");
}

/// Somebody later is somebody whose file says so.
#[test]
fn who_comes_later_is_who_appears_later_in_a_file() {
    let outcome = |text: &str, change: Option<RunChange>| {
        let (suite, case, _) = written(text);
        let (measured, stop, threads) = (measured(&suite), Stop::default(), Threads::new(1));
        let batch = RunBatch { executor: &threads, measured: &measured, stop: &stop };
        batch.one_otherwise(&case, change.as_ref(), Wanted::Outcome).unwrap().outcome
    };
    let change = RunChange::AppearsLater { pedestrian: 0, by: 0.2 };
    let later = outcome(STANDS, Some(change.clone()));
    assert_eq!(later.fingerprint, outcome(&STANDS.replace("at 1 s", "at 1.2 s"), None).fingerprint);
    assert_ne!(later.fingerprint, outcome(STANDS, None).fingerprint);
    // Whose moment depends on a car that keeps its speed appears as much later as if less time were left.
    let waits =
        |time: &str| STANDS.replace("appears at 1 s", &format!("appears when time_to_arrival(av) = {time}"));
    let later = outcome(&waits("3 s"), Some(change));
    assert_eq!(later.fingerprint, outcome(&waits("2.8 s"), None).fingerprint);
    let nobody = outcome(STANDS, Some(RunChange::NobodyAppears));
    assert_eq!(
        nobody.fingerprint,
        outcome(&STANDS.replace("at 1 s", "at 59 s"), Some(RunChange::NobodyAppears)).fingerprint
    );
}

/// A vehicle with its own brake is told earlier what it was told.
#[test]
fn who_brakes_earlier_is_slower_at_every_moment() {
    let (suite, case, criteria) = {
        let suite = shipped("suites/zebra_unsafe.suite");
        let plan = plan(&suite).unwrap();
        let trial = plan.trials().find(|trial| trial.cases.first().scenario == "stands_in_lane").unwrap();
        let (case, criteria) = (trial.cases.first(), trial.criteria.clone());
        drop(plan);
        (suite, case, criteria)
    };
    let (measured, stop, threads) = (measured(&suite), Stop::default(), Threads::new(1));
    let batch = RunBatch { executor: &threads, measured: &measured, stop: &stop };
    let story = story(batch, &case, &criteria).unwrap();
    let Otherwise::BrakesEarlier { by, from: Some(from), .. } = &story.otherwise[0].what else { panic!() };
    let CameOf::Run(run) = &story.otherwise[0].came else { panic!() };
    let contact = story.contact.as_ref().expect("it brakes too late").relative_speed;
    assert!(run.contact.is_none_or(|earlier| earlier < contact - 0.5), "{:?} {contact}", run.contact);
    // Its own speed falls so much earlier, no more and no less.
    let first = batch.one(&case, Wanted::Commands).unwrap();
    let change = RunChange::BrakesEarlier {
        vehicle: 0,
        from: *from,
        by: *by,
        commands: first.commands[0].clone(),
        until: first.outcome.ending.time,
    };
    let second = batch.one_otherwise(&case, Some(&change), Wanted::Commands).unwrap();
    let began = |ran: &Ran| ran.commands[0].iter().find(|one| sim::brakes(one.command)).unwrap().time;
    assert!((began(&first) - began(&second) - by).abs() < 1e-9, "{} {}", began(&first), began(&second));
}

/// Nothing depends on who makes the runs, or on their being written down in between.
#[test]
fn a_story_is_the_same_on_any_executor() {
    let suite = shipped("suites/zebra_unsafe.suite");
    let plan = plan(&suite).unwrap();
    let (measured, stop) = (measured(&suite), Stop::default());
    for trial in plan.trials().take(4) {
        let case = trial.cases.first();
        let told = |executor: &dyn runner::run::Executor| {
            let batch = RunBatch { executor, measured: &measured, stop: &stop };
            let story = story(batch, &case, &trial.criteria).unwrap();
            (story.outcome.fingerprint, serde_json::to_string(&story).unwrap())
        };
        let one = told(&Threads::new(1));
        assert_eq!(told(&Threads::new(4)), one);
        assert_eq!(told(&Serialised::new(Threads::new(2), standard())), one);
        assert_eq!(told(&Shuffled::seeded(7)), one);
    }
}
