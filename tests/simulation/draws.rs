//! What every run draws: the same values whatever stands beside it and however runs are made; runs as functions of their points; a
//! probability that is known in closed form; whom claims speak of.

use std::collections::BTreeMap;

use files::Memory;
use models::standard;
use numbers::distributions::normal::cumulative;
use numbers::inference::{lower_bound, upper_bound};
use results::{Requests, SuiteReport, TrialReport, Unheard};
use runner::plan::{Plan, plan};
use runner::project::Project;
use runner::run::{FreeFlows, Shuffled, Threads, Unwatched, run_case};
use runner::session::{Selection, Session};
use scenario::{Case, Suite, Value};

use crate::support::text::{checked, loaded};

/// People who draw, on a street, with `draws` and `wanted`.
fn scenario(draws: &str, wanted: &str) -> String {
    format!(
        "scenario walk {{
  road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }}
  vehicle av {{ controller carla_behavior; start 45 m before crossing; speed pace }}
  pedestrian walker {{
    model commotions
    individuals drawn from standard
    start far from kerb
    appears at late
  }}
{draws}
  repeat 12
  horizon 20 s
  expect {{ {wanted} }}
}}
"
    )
}

const PACE: &str = "  draw pace from truncated_normal(30 km/h, 4 km/h, 15 km/h, 50 km/h)\n";
const FAR: &str = "  draw far from triangular(0.5 m, 1 m, 4 m)\n";
const LATE: &str = "  draw late from exponential(0.8 s)\n";
const NO_COLLISION: &str = "no collision";

fn planned(text: &str) -> (Suite, Plan) {
    let suite = loaded(text);
    let plan = plan(&suite).unwrap_or_else(|errors| panic!("{text}: {errors:?}"));
    (suite, plan)
}

/// What is drawn in each run of the first trial, by the runs' keys.
fn drawn(text: &str) -> BTreeMap<String, BTreeMap<String, (Value, u64)>> {
    let (_, plan) = planned(text);
    let of = |case: Case| {
        let draws = case.drawn.into_iter().map(|one| (one.name, (one.value, one.share.to_bits())));
        (case.key, draws.collect())
    };
    plan.trial(0).cases.iter().map(of).collect()
}

#[test]
fn what_else_is_drawn_changes_no_draw() {
    let all = drawn(&scenario(&format!("{PACE}{FAR}{LATE}"), NO_COLLISION));
    assert_eq!(all.len(), 12);
    assert!(all.values().all(|draws| draws.len() == 4), "{all:?}");
    let mut different: Vec<_> = all.values().map(|draws| draws["pace"].1).collect();
    different.dedup();
    assert_eq!(different.len(), 12);
    // In another order.
    assert_eq!(drawn(&scenario(&format!("{LATE}{PACE}{FAR}"), NO_COLLISION)), all);
    // Without some of them, and with another distribution: the coordinates of the others stay.
    let fewer = scenario(&format!("  let far = 2 m\n{LATE}{PACE}"), NO_COLLISION);
    let other = scenario(&format!("{LATE}{FAR}  draw pace from uniform(20 km/h, 30 km/h)\n"), NO_COLLISION);
    for text in [&fewer, &other] {
        for (key, draws) in drawn(text) {
            assert!(draws.iter().all(|(name, (_, share))| *share == all[&key][name].1), "{key}");
        }
    }
    // Others are drawn under another seed.
    let other = scenario(&format!("  seed 4\n{PACE}{FAR}{LATE}"), NO_COLLISION);
    let shares = |all: &BTreeMap<String, BTreeMap<String, (Value, u64)>>| -> Vec<u64> {
        all.values().flat_map(|draws| draws.values().map(|one| one.1)).collect()
    };
    assert!(shares(&drawn(&other)).iter().all(|share| !shares(&all).contains(share)));
}

fn report(text: &str, session: impl Fn(Session) -> Session, selection: &Selection) -> SuiteReport {
    let files = Memory::default().with("text.scn", text);
    let project = Project::open("text.scn", &standard(), &files).unwrap_or_else(|error| panic!("{error}"));
    let session = session(Session::new(&project).courses(false).every_trial(true));
    session.run(selection, &mut Unheard).unwrap().suites.remove(0)
}

fn bits(trial: &TrialReport) -> Vec<(String, u64, Vec<u64>)> {
    let of = |one: &results::Outcome| {
        (one.key.clone(), one.fingerprint, one.drawn.iter().map(|draw| draw.share.to_bits()).collect())
    };
    trial.outcomes.iter().map(of).collect()
}

#[test]
fn drawn_runs_are_the_same_however_they_are_made() {
    let text = scenario(&format!("{PACE}{FAR}{LATE}  vary gap in [1, 2]\n"), NO_COLLISION)
        .replace("at late", "at gap * late");
    let all = Selection::all();
    let alone = report(&text, |session| session.executor(Threads::new(1)), &all);
    for other in [
        report(&text, |session| session.executor(Threads::new(3)), &all),
        report(&text, |session| session.executor(Shuffled::seeded(7)), &all),
    ] {
        assert!(alone.trials.iter().zip(&other.trials).all(|(one, other)| bits(one) == bits(other)));
    }
    // One trial without the other, and the beginning of more runs.
    let half = report(&text, |session| session, &Selection::containing("gap=2"));
    assert_eq!(bits(&half.trials[1]), bits(&alone.trials[1]));
    let more = report(&text.replace("repeat 12", "repeat 20"), |session| session, &all);
    assert_eq!(bits(&more.trials[0])[..12], bits(&alone.trials[0]));
    assert_ne!(bits(&alone.trials[0])[0].2, bits(&alone.trials[1])[0].2, "another trial draws others");
}

#[test]
fn a_run_is_a_function_of_its_point() {
    let (_, plan) = planned(&scenario(&format!("{PACE}{FAR}{LATE}"), NO_COLLISION));
    let cases = plan.trial(0).cases;
    let names: Vec<_> = cases.axes().into_iter().flat_map(|axis| axis.names).collect();
    assert_eq!(names, ["pace", "far", "late", "walker.individual"]);
    let (requests, flows) = (Requests::defaults(&standard()), FreeFlows::default());
    let run = |case: &Case| run_case(case, &requests, &flows, &mut Unwatched).unwrap();
    for index in 0..3 {
        let point = cases.point(index).unwrap();
        let (own, at) = (cases.get(index), cases.at(index, &point).unwrap());
        assert_eq!(run(&own).fingerprint, run(&at).fingerprint);
        assert_eq!((own.drawn, own.world, own.seed), (at.drawn.clone(), at.world.clone(), at.seed));
        // Its name is enough to make it again, bit for bit.
        assert_eq!(cases.named(&at.key), Some(at));
        // One coordinate is one value.
        let mut moved = point.clone();
        moved[1] = 0.999;
        let other = cases.at(index, &moved).unwrap();
        let changed = |place: usize| other.drawn[place] != cases.get(index).drawn[place];
        assert_eq!([0, 1, 2, 3].map(changed), [false, true, false, false]);
        assert_ne!(run(&other).fingerprint, run(&cases.get(index)).fingerprint);
        assert_eq!(cases.named(&other.key).unwrap().drawn, other.drawn);
    }
    assert_eq!(cases.named("text/walk/rep=1/u=0.5,0.5"), None);
    assert_eq!(cases.named("text/walk/rep=1/u=0.5,0.5,0.5,1"), None);
}

/// Where the centre of a car of 4 m x 2 m at 10 m/s starts before the crossing, m, with that mean and a standard deviation of 4 m; a person
/// of radius 0.3 m who walks at 1 m/s, 4.75 m from the middle of the lane.
fn meeting(mean: f64, runs: usize, seed: u64) -> String {
    format!(
        "scenario walk {{
  road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }}
  vehicle av {{ controller constant_speed; size 4 m x 2 m; speed 10 m/s; start far before crossing }}
  pedestrian walker {{ model scripted {{ speed: 1 m/s }}; radius 0.3 m; start 3 m from kerb; appears at 0 s }}
  draw far from normal({mean} m, 4 m)
  repeat {runs}
  seed {seed}
  horizon 12 s
  end on collision
  expect {{ rate(collision) <= 50 % with 95 % confidence }}
}}
"
    )
}

/// In the car's frame the person moves along a straight line, which meets the rounded rectangle that their bodies make together if it is
/// no farther from its middle than that reaches across the line: |s - 47.5 m| < 2 m + 10 · 1 m + √101 · 0.3 m.
fn probability(mean: f64) -> f64 {
    let reach = 2.0 + 10.0 + 101.0_f64.sqrt() * 0.3;
    let below = |s: f64| cumulative((s - mean) / 4.0);
    below(47.5 + reach) - below(47.5 - reach)
}

#[test]
fn a_known_probability_is_found_and_bounded_as_often_as_stated() {
    let (trials, runs, mean) = (60_u64, 50_usize, 63.0);
    let known = probability(mean);
    let (mut collisions, mut covered) = (0, 0);
    for seed in 0..trials {
        let report = report(&meeting(mean, runs, 100 * seed), |session| session, &Selection::all());
        let finding = &report.trials[0].findings()[0];
        let hits = runs - finding.holding.min(runs);
        let held = (finding.observed.unwrap() * runs as f64).round() as usize;
        assert!(hits == held || finding.holding == held, "{finding:?}");
        collisions += held;
        let (low, high) = finding.interval.unwrap();
        assert!((low - lower_bound(held as u64, runs as u64, 0.95)).abs() < 1e-12);
        assert!((high - upper_bound(held as u64, runs as u64, 0.95)).abs() < 1e-12);
        covered += u64::from(known <= high);
    }
    let all = (trials as usize * runs) as f64;
    let (rate, error) = (collisions as f64 / all, (known * (1.0 - known) / all).sqrt());
    assert!((rate - known).abs() < 3.5 * error, "{rate}, not {known} ± {error}");
    // 95 % minus three standard errors of 60 repetitions.
    assert!(covered as f64 >= 60.0 * 0.95 - 3.0 * (60.0_f64 * 0.05 * 0.95).sqrt(), "{covered} of {trials}");
}

/// The boundaries by bisection over points: a second derivation of the same probability, without chance.
#[test]
fn the_share_that_fails_lies_between_two_points() {
    let (_, plan) = planned(&meeting(50.0, 1, 3));
    let cases = plan.trial(0).cases;
    let (requests, flows) = (Requests::defaults(&standard()), FreeFlows::default());
    let collision = requests.iter().position(|one| one.name() == "collision").unwrap();
    let hits = |share: f64| {
        let case = cases.at(0, &[share]).unwrap();
        run_case(&case, &requests, &flows, &mut Unwatched).unwrap().metrics[collision] == Some(1.0)
    };
    let boundary = |mut hit: f64, mut miss: f64| {
        for _ in 0..24 {
            let middle = 0.5 * (hit + miss);
            if hits(middle) { hit = middle } else { miss = middle }
        }
        hit
    };
    let share = boundary(0.5, 1.0 - 1e-9) - boundary(0.5, 1e-9);
    assert!((share - probability(50.0)).abs() < 2e-3, "{share}, not {}", probability(50.0));
}

#[test]
fn drawn_people_are_all_people() {
    let wanted = "rate(pet < 1 s) <= 80 % with 95 % confidence of all people; rate(pet < 1 s) <= 81 % with 95 % confidence";
    let text = scenario(&format!("{PACE}{FAR}{LATE}"), wanted).replace("repeat 12", "repeat 40");
    let all = Selection::all();
    let trial = report(&text, |session| session, &all).trials.remove(0);
    for finding in trial.findings() {
        let regarding = finding.people.unwrap();
        assert_eq!((regarding.whom, regarding.drawn), (scenario::People::All, true));
        // Every run counts by itself, though some may be of one person.
        let (low, high) = finding.interval.unwrap();
        let hits = (finding.observed.unwrap() * 40.0).round() as u64;
        assert_eq!((low, high), (lower_bound(hits, 40, 0.95), upper_bound(hits, 40, 0.95)));
    }
    // Of people who come back nothing can be said, and of all people while runs are added everything.
    let these = checked(&text.replace("of all people", "of these people")).unwrap_err();
    assert!(these.contains("BadPeople"), "{these}");
    let trial =
        report(&text.replace("repeat 40", "runs 20 .. 400"), |session| session, &all).trials.remove(0);
    assert!(trial.stopping().unwrap().runs < 400, "{:?}", trial.stopping());
}

/// How it could be wrongly green: chance that is only said to be there.
#[test]
fn what_only_looks_like_chance_is_refused() {
    let walk = |draw: &str, speed: &str| {
        format!(
            "scenario walk {{
  road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }}
  vehicle av {{ controller constant_speed; start 40 m before crossing; speed 10 m/s }}
  pedestrian walker {{ model scripted {{ speed: {speed} }}; start 3 m from kerb; appears at 1 s }}
  {draw}
  repeat 100
  expect {{ rate(collision) <= 50 % with 95 % confidence }}
}}
"
        )
    };
    let opened = |text: &str| {
        let files = Memory::default().with("text.scn", text).with("one.csv", "v [m/s],weight\n1,0\n1.4,2\n");
        Project::open("text.scn", &standard(), &files).map(|_| ()).map_err(|error| error.to_string())
    };
    for (draw, speed, said) in [
        ("", "1.4 m/s", "nothing is left to chance"),
        ("draw v from normal(1.4 m/s, 0.1 m/s)", "1.4 m/s", "changes nothing"),
        (
            "draw v from normal(1.4 m/s, 0.1 m/s); draw w from normal(v, 0.1 m/s)",
            "1.4 m/s",
            "changes nothing",
        ),
        ("draw v from normal(1.4 m/s, 0 m/s)", "v", "the same in every run"),
        ("vary s in [0.1 m/s, 0 m/s]; draw v from normal(1.4 m/s, s)", "v", "the same in every run"),
        ("draw v from choice(1.4 m/s: 1, 1.2 m/s: 0)", "v", "the same in every run"),
        ("draw together from \"one.csv\"", "v", "the same in every run"),
        ("draw v from normal(1.4 m/s, 0.4 m/s)", "v", "cannot be run"),
    ] {
        let error = opened(&walk(draw, speed)).expect_err(draw);
        assert!(error.contains(said), "{draw}: {error}");
    }
    opened(&walk("draw v from normal(1.4 m/s, 0.1 m/s)", "v")).unwrap();
}

/// A draw that cannot be run, though nothing showed it beforehand, is an error and neither a pass nor left out.
#[test]
fn an_impossible_draw_is_an_error() {
    let (_, plan) = planned(&meeting(47.5, 3, 1));
    let cases: Vec<Case> = plan.trial(0).cases.iter().collect();
    let refused = Case { impossible: Some("its speed is below 0".into()), ..cases[1].clone() };
    let error = run_case(&refused, &Requests::defaults(&standard()), &FreeFlows::default(), &mut Unwatched);
    assert!(error.unwrap_err().to_string().contains("its speed is below 0"));
}

/// Each of the two is possible with the other in the middle, and not together: nothing shows it beforehand.
#[test]
fn a_trial_with_an_impossible_run_is_an_error_and_no_pass() {
    let text = "scenario walk {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller constant_speed; start 40 m before crossing; speed fast - slower }
  pedestrian walker { model scripted { speed: 1 m/s }; start 3 m from kerb; appears at 30 s }
  draw fast from choice(5 m/s, 10 m/s, 12 m/s)
  draw slower from choice(1 m/s, 2 m/s, 7 m/s)
  repeat 60
  expect { no collision }
}
";
    let all = Selection::all();
    let trial = report(text, |session| session, &all).trials.remove(0);
    let error = trial.error().expect("a ninth of its runs cannot be made").to_string();
    assert!(error.contains("what was drawn for it cannot be run") && error.contains("-2 m/s"), "{error}");
    assert_eq!(trial.verdict(), None);
    // And so is one that a point asks for.
    let (_, plan) = planned(text);
    assert!(plan.trial(0).cases.at(0, &[0.1, 0.9]).is_err());
}

/// What is cut off lies farther out than any run, and is no run.
#[test]
fn what_reaches_out_by_next_to_nothing_is_cut_off() {
    let text = meeting(47.5, 3, 1)
        .replace("speed: 1 m/s", "speed: pace")
        .replace("  draw far", "  draw pace from normal(1.4 m/s, 0.23 m/s)\n  draw far");
    let (_, plan) = planned(&text);
    let cases = plan.trial(0).cases;
    assert!(cases.at(0, &[1e-10, 0.5]).is_err(), "0.23 m/s below 0");
    assert!(cases.at(0, &[1e-7, 0.5]).is_ok());
    assert!(cases.iter().all(|case| case.impossible.is_none()));
    // Of all seeds below 2365452 this is the only one whose first run would be so far out: it is drawn again.
    let seed = 2_365_451;
    let share = |attempt| sim::random::declared(seed, "pace", attempt).uniform();
    assert!(share(0) < 5e-8);
    let text = text
        .replace("0.23 m/s", "0.269 m/s")
        .replace("repeat 3\n  seed 1", &format!("repeat 2\n  seed {seed}"));
    let (_, plan) = planned(&text);
    let cases = plan.trial(0).cases;
    assert_eq!(cases.get(0).seed, seed);
    assert_eq!((cases.point(0).unwrap()[0], cases.get(0).impossible), (share(1), None));
    assert!(cases.at(0, &[share(0), 0.5]).is_err());
}
