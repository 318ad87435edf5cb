//! Who is to meet a vehicle is hit where the scenario says, whatever the step, the sides, the speeds and the starts are.

use files::Memory;
use models::standard;
use proptest::prelude::*;
use results::Requests;
use runner::plan::plan;
use runner::run::{FreeFlows, Unwatched, run_case};

/// A scenario with these, and the value of a metric in its only run.
fn measured(text: &str, metric: &str) -> Option<f64> {
    let files = Memory::default().with("meets.scn", text);
    let loaded = lang::load("meets.scn".as_ref(), &standard(), &files);
    let suite = loaded.unwrap_or_else(|failure| panic!("{text}\n{:?}", failure.diagnostics)).suite;
    let plan = plan(&suite).unwrap_or_else(|errors| panic!("{text}\n{}", errors[0]));
    let trial = plan.trial(0);
    let case = &trial.cases.first();
    let requests = Requests::defaults(&standard());
    let outcome = run_case(case, &requests, &FreeFlows::default(), &mut Unwatched).unwrap();
    let index = requests.iter().position(|request| request.metric.name() == metric).expect("it is a metric");
    outcome.metrics[index]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_vehicle_that_keeps_its_speed_hits_where_it_is_said(
        speed in 2.0..25.0_f64,
        pace in 0.5..6.0_f64,
        share in 0.0..1.0_f64,
        accelerates in prop::option::of(0.1..2.0_f64),
        delay in 0.0..2.0_f64,
        start in 3.5..12.0_f64,
        far in any::<bool>(),
        lane in 0..2_usize,
        along in -30.0..30.0_f64,
        reference in -0.2..0.2_f64,
        given in prop::option::of(0.0..100.0_f64),
        step in prop::sample::select(vec![0.01, 0.025, 0.05]),
        disc in any::<bool>(),
    ) {
        // A disc that is not hit by its middle is hit at the corner.
        let reference = if disc { 0.0 } else { reference };
        // Far enough out for the slowest to be in time.
        let needed = speed * (start + 10.0 + 2.0) / pace + 2.0 * speed + speed * 2.0 * accelerates.unwrap_or(0.0) / pace + 40.0;
        let starts = given.map_or(String::new(), |more| format!("start {} m before crossing;", needed + more));
        prop_assume!(needed + given.unwrap_or(0.0) < 3000.0);
        let accelerates = accelerates.map_or(String::new(), |way| format!(", acceleration_way: {way} m"));
        let side = if far { "from far side;" } else { "" };
        let shape = if disc { "radius 0.3 m" } else { "size 0.6 m x 0.5 m" };
        let behind = if reference < 0.0 { "behind" } else { "ahead of" };
        let text = format!("
scenario meets {{
  road {{ lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked }}
  vehicle av {{ controller constant_speed; speed {speed} m/s; size 4.4 m x 1.8 m; lane {lane}; {starts} }}
  pedestrian dummy {{
    model scripted {{ speed: {pace} m/s, delay: {delay} s{accelerates} }}
    {shape}; {side}
    start {start} m from lane centre
    along {along} m
    goal 10 m beyond kerb
    reference {} m {behind} centre
    meets av at {}
  }}
  horizon 3000 s
  step {step} s
  end on collision
}}", reference.abs(), share);
        let point = measured(&text, "impact_point").expect("it is hit at the front");
        prop_assert!((point - share).abs() < 1e-3, "{point} instead of {share}\n{text}");
    }
}

#[test]
fn a_flank_is_no_front() {
    let text = "
scenario walks_into_it {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing unmarked }
  vehicle av { controller constant_speed; speed 20 km/h; size 4.4 m x 1.8 m }
  pedestrian walker { model scripted { speed: 1.4 m/s }; start 4 m from lane centre; appears when time_to_arrival(av.front) = 2.1 s }
}";
    assert_eq!(measured(text, "collision"), Some(1.0));
    assert_eq!(measured(text, "impact_point"), None);
    assert!(measured(text, "impact_speed").is_some_and(|speed| speed > 1.4));
}
