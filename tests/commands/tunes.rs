//! What a tune answers: never worse than what it saw, what is declared unless something is better, and red where a constraint breaks.

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::support::program::{code, scenario_runner, stderr, stdout};

/// The pedestrian walks on whatever comes; the car brakes where it comes within its distance. With noise, or without.
fn street(perceived: &str) -> String {
    format!(
        "road street {{ lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }}
scenario walks {{
  road street
  vehicle av {{ controller carla_behavior {{ braking_distance: 14 m }}; speed 40 km/h; {perceived} }}
  pedestrian walker {{ model scripted {{ speed: 1.4 m/s }}; start 2 m from kerb; appears when time_to_arrival(av) = tta }}
  vary tta in [4 s, 6 s, 8 s]
  repeat 4
}}
"
    )
}

const NOISE: &str = "sees { range: 60 m, position_noise: 0.3 m }";

struct Place(TempDir);

impl Place {
    fn new(text: &str) -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        place.write(text);
        place
    }

    fn write(&self, text: &str) {
        fs::write(self.0.path().join("street.scn"), text).unwrap();
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    /// The tune's result, what is said of it, and the exit code.
    fn tune(&self, name: &str) -> (Value, String, i32) {
        let output = scenario_runner(self.path(), &["tune", name, "street.scn", "--json", "tune.json"]);
        let text = fs::read_to_string(self.path().join("tune.json"))
            .unwrap_or_else(|_| panic!("{}{}", stdout(&output), stderr(&output)));
        (serde_json::from_str(&text).unwrap(), stdout(&output) + &stderr(&output), code(&output))
    }
}

fn objective(candidate: &Value) -> f64 {
    candidate["objectives"][0].as_f64().unwrap()
}

/// The smallest objective of the candidates that are feasible.
fn best(tune: &Value) -> f64 {
    let all = tune["evaluations"].as_array().unwrap();
    let feasible = all.iter().filter(|one| one["feasible"] == true);
    feasible.map(objective).fold(f64::INFINITY, f64::min)
}

/// A car that brakes late loses no time, so that most candidates are on a plateau, whose values differ in their last bits.
#[test]
fn on_a_plateau_the_answer_is_as_good_as_the_best_that_was_seen() {
    let tune = "tune late { on walks; over av.controller.braking_distance in 1 m .. 60 m; \
                over av.controller.safety_time in 0.5 s .. 8 s; minimise mean(time_lost); \
                budget 24 evaluations, 8 random first }";
    for perceived in ["", NOISE] {
        let place = Place::new(&(street(perceived) + tune));
        let (result, said, exit) = place.tune("late");
        assert_eq!(exit, 0, "{said}");
        let (chosen, best) = (objective(&result["chosen"]), best(&result));
        assert!(chosen - best < 0.05, "{chosen} was chosen, and {best} seen: {said}");
        let all = result["evaluations"].as_array().unwrap();
        // What is declared comes on top of the budget.
        assert_eq!((all.len(), &all[0]["origin"]), (25, &"declared".into()));
        assert_eq!(all[0]["point"][0], 14.0);
    }
}

#[test]
fn nothing_better_than_what_is_declared_is_said_and_passes() {
    let tune = "tune far { on walks; over av.controller.braking_distance in 13 m .. 60 m; \
                minimise mean(time_lost); subject to no collision; budget 4 evaluations, 4 random first }";
    let place = Place::new(&(street("").replace("14 m", "8 m") + tune));
    // 8 m is not even in the range.
    let (result, said, exit) = place.tune("far");
    assert_eq!(exit, 0, "{said}");
    assert_eq!(result["chosen"]["point"][0], 8.0, "{said}");
    assert!(said.contains("nothing better than what is declared"), "{said}");
    assert_eq!(result["evaluations"].as_array().unwrap().len(), 5);
    let saved = scenario_runner(place.path(), &["tune", "far", "street.scn", "--save", "tuned.scn"]);
    assert_eq!(code(&saved), 0);
    let saved = fs::read_to_string(place.path().join("tuned.scn")).unwrap();
    assert!(saved.contains("let av_controller_braking_distance = 8 m"), "{saved}");
}

/// Every trial declares a value of its own, so that what is declared is not a point of the space.
#[test]
fn declared_values_that_vary_are_a_candidate_too() {
    let varied = street("")
        .replace("braking_distance: 14 m", "braking_distance: near")
        .replace("  repeat 4", "  vary near in [5 m, 7 m]\n  repeat 1");
    let tune = "tune far { on walks; over av.controller.braking_distance in 30 m .. 60 m; \
                minimise mean(time_lost); budget 3 evaluations, 3 random first; compare with default }";
    let (result, said, exit) = Place::new(&(varied + tune)).tune("far");
    assert_eq!(exit, 0, "{said}");
    assert_eq!(
        (&result["chosen"]["origin"], result["chosen"]["point"].as_array().unwrap().len()),
        (&"declared".into(), 0)
    );
    assert!(
        said.contains("chosen: what is declared gives") && said.contains("nothing better than"),
        "{said}"
    );
}

#[test]
fn a_result_that_breaks_a_constraint_is_not_passed() {
    let tune = |rest: &str| {
        format!(
            "tune close {{ on walks; over av.controller.braking_distance in 1 m .. 6 m; \
             minimise mean(time_lost); {rest}; budget 4 evaluations, 4 random first }}\n"
        )
    };
    // No distance of the range keeps it, and what is declared does not either.
    let hopeless = street("").replace("14 m", "2 m");
    let place = Place::new(&(hopeless.clone() + &tune("subject to pet >= 50 s")));
    let (result, said, exit) = place.tune("close");
    assert_eq!((exit, &result["chosen"]), (100, &Value::Null), "{said}");
    assert!(said.contains("no candidate keeps every constraint: nothing is chosen"), "{said}");
    // The fewest violations are violations, though others can build on the result.
    let with = "evaluate after { on walks; with default, close; measure mean(pet) }";
    let fewest = tune("subject to pet >= 50 s; otherwise fewest violations");
    place.write(&(hopeless + &fewest + with));
    let (result, said, exit) = place.tune("close");
    assert_eq!((exit, result["violations"]["runs"].as_u64()), (100, Some(12)), "{said}");
    let all = scenario_runner(place.path(), &["street.scn"]);
    assert_eq!(code(&all), 100);
    assert!(stdout(&all).contains("evaluate after: 12 cases"), "{}", stdout(&all));
}

/// With noise some seed breaks what the seeds of the cases kept: by how much a bound lies inside is found by trying.
#[test]
fn a_result_that_breaks_a_constraint_with_fresh_seeds_is_not_passed() {
    let tune = |bound: &str| {
        format!(
            "tune edge {{ on walks; over av.controller.braking_distance in 10 m .. 20 m; \
             minimise mean(time_lost); subject to min_distance >= {bound} m; budget 3 evaluations, 3 random first }}\n"
        )
    };
    let place = Place::new(&(street(NOISE) + &tune("0")));
    let (result, said, exit) = place.tune("edge");
    assert_eq!((exit, result["fresh_violations"][0]["runs"].as_u64()), (0, Some(0)), "{said}");
    // A bound just below the smallest distance of what was chosen is kept on its own seeds, and by luck alone.
    let least = result["chosen"]["margins"][0].as_f64().unwrap();
    place.write(&(street(NOISE) + &tune(&(least - 1e-9).to_string())));
    let (result, said, exit) = place.tune("edge");
    let broken = result["fresh_violations"][0]["runs"].as_u64().unwrap();
    assert!(result["chosen"]["feasible"] == true && broken > 0, "{said}");
    assert_eq!(exit, 100, "{said}");
    assert!(said.contains("breaks a constraint on the fresh seeds"), "{said}");
    let junit = ["street.scn", "tune=edge", "--junit", "junit.xml", "--json", "all.json"];
    assert_eq!(code(&scenario_runner(place.path(), &junit)), 100);
    let reported = scenario_runner(place.path(), &["report", "all.json"]);
    assert_eq!(code(&reported), 100, "{}", stderr(&reported));
    assert!(fs::read_to_string(place.path().join("junit.xml")).unwrap().contains("failures=\"1\""));
}

#[test]
fn without_any_value_a_tune_says_only_that() {
    let tune = "tune nothing { on walks; over av.controller.braking_distance in 10 m .. 20 m; \
                minimise mean(pet); budget 3 evaluations, 3 random first }";
    // The pedestrian stops at the kerb.
    let text = street("").replace("speed: 1.4 m/s", "speed: 1.4 m/s, stop_after: 0.5 m");
    let (result, said, exit) = Place::new(&(text + tune)).tune("nothing");
    assert_eq!((exit, &result["chosen"]), (100, &Value::Null), "{said}");
    assert!(said.contains("no candidate has a value"), "{said}");
    assert!(!said.contains("feasible") && !said.contains("keeps every constraint"), "{said}");
}

#[test]
fn candidates_of_the_users_own_come_after_what_is_declared() {
    let tune = "tune far { on walks; over av.controller.braking_distance in 1 m .. 60 m; minimise mean(time_lost); \
                budget 2 evaluations, 2 random first; try { braking_distance: 9 m }; \
                try { av.controller.braking_distance: 6 m } }";
    let (result, said, exit) = Place::new(&(street("") + tune)).tune("far");
    assert_eq!(exit, 0, "{said}");
    let all = result["evaluations"].as_array().unwrap();
    let of = |index: usize| (all[index]["point"][0].as_f64().unwrap(), all[index]["origin"].as_str());
    assert_eq!([of(0), of(1), of(2)], [(14.0, Some("declared")), (9.0, Some("tried")), (6.0, Some("tried"))]);
    assert_eq!((all.len(), of(3).1), (5, None));
    let outside = tune.replace("braking_distance: 9 m", "braking_distance: 90 m");
    let place = Place::new(&(street("") + &outside));
    assert_eq!(code(&scenario_runner(place.path(), &["check", "street.scn"])), 3);
}

/// Evaluations in the journals that are there.
fn recorded(folder: &Path) -> Vec<usize> {
    let files = fs::read_dir(folder.join(".scenario-runner/journal")).unwrap();
    let mut all: Vec<usize> =
        files.map(|file| fs::read_to_string(file.unwrap().path()).unwrap().lines().count() - 1).collect();
    all.sort_unstable();
    all
}

#[test]
fn a_larger_budget_goes_on_from_the_journal_where_nothing_else_changed() {
    let tune = |rest: &str| {
        format!(
            "{}tune far {{ on walks; over av.controller.braking_distance in 1 m .. 60 m; minimise mean(time_lost); {rest} }}\n",
            street(NOISE)
        )
    };
    let place = Place::new(&tune("budget 6 evaluations, 3 random first"));
    let small = place.tune("far").0;
    assert_eq!(recorded(place.path()), [6]);
    place.write(&tune("budget 10 evaluations, 3 random first"));
    let large = place.tune("far").0;
    assert_eq!(recorded(place.path()), [10]);
    let points = |result: &Value| result["evaluations"].as_array().unwrap().clone();
    assert_eq!(points(&large)[..7], points(&small)[..]);
    // It ends as one that was never cut off.
    let undisturbed = Place::new(&tune("budget 10 evaluations, 3 random first")).tune("far").0;
    assert_eq!(large, undisturbed);
    // Where something else changed it begins anew.
    place.write(&tune("budget 12 evaluations, 3 random first; subject to no collision"));
    place.tune("far");
    assert_eq!(recorded(place.path()), [10, 12]);
}

/// A car that hits at some braking distances and at others does not; the declared one does not.
fn hits(tune: &str) -> Place {
    Place::new(&format!(
        "scenario s {{
  road {{ lanes forward, backward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra {{ width: 4 m }} }}
  vehicle av {{ controller carla_behavior {{ braking_distance: 8 m }}; speed 30 km/h }}
  pedestrian p {{ model scripted {{ speed: 1.4 m/s }}; start 2 m from kerb; appears when time_to_arrival(av) = 3 s }}
}}
tune g {{ on s; over av.controller.braking_distance in 1 m .. 30 m; {tune}; budget 8 evaluations, 8 random first, by sobol }}
"
    ))
}

#[test]
fn a_constraint_is_kept_where_what_it_bounds_never_arose() {
    for constraint in ["impact_speed <= 3 m/s", "impact_speed <= 3 m/s undefined passes", "no ran_red"] {
        let (tune, said, code) =
            hits(&format!("minimise mean(time_lost); subject to {constraint}")).tune("g");
        let declared = &tune["evaluations"][0];
        assert_eq!((&declared["feasible"], &declared["margins"][0]), (&true.into(), &Value::Null), "{said}");
        assert_eq!(code, 0, "{said}");
        assert!(!said.contains("breaks a constraint"), "{said}");
    }
    // With fresh seeds as well, and where a candidate is given up at the first run that breaks one.
    let (tune, said, code) =
        hits("minimise mean(time_lost); subject to min_ttc >= 0.1 s; stop early").tune("g");
    assert_eq!(code, 0, "{said}");
    assert_eq!(tune["fresh_violations"][0]["runs"], 0);
}

/// The pedestrian stays at the kerb: every candidate keeps every constraint, and nothing shows that it would with a pedestrian in its way.
#[test]
fn a_constraint_that_nothing_put_to_the_test_is_said_and_can_be_denied() {
    let tune = |people: &str, constraint: &str| {
        let text = street("").replace("speed: 1.4 m/s", people);
        let tune = format!(
            "tune far {{ on walks; over av.controller.braking_distance in 12 m .. 60 m; \
             minimise mean(max_deceleration); subject to {constraint}; budget 2 evaluations, 2 random first }}"
        );
        Place::new(&(text + &tune))
    };
    let denied = |place: &Place| {
        let run =
            ["street.scn", "tune=far", "--deny", "untested", "--json", "all.json", "--html", "all.html"];
        let first = code(&scenario_runner(place.path(), &run));
        let reported = scenario_runner(place.path(), &["report", "all.json"]);
        assert_eq!(code(&reported), first, "{}", stderr(&reported));
        first
    };
    for constraint in ["impact_speed <= 3 m/s", "no collision", "pet >= 1 s undefined passes"] {
        let unmet = tune("speed: 1.4 m/s, stop_after: 0.5 m", constraint);
        let (result, said, exit) = unmet.tune("far");
        assert_eq!((exit, result["untested"][0]["reason"]["reason"].as_str()), (0, Some("pairs")), "{said}");
        let why = "untested: with fresh seeds `walker` did not come into the way of `av`";
        assert!(said.contains(why), "{said}");
        assert_eq!(denied(&unmet), 102, "{constraint}");
        let page = fs::read_to_string(unmet.path().join("all.html")).unwrap();
        assert!(page.contains("kept untested"), "{constraint}");
    }
    let met = tune("speed: 1.4 m/s", "impact_speed <= 3 m/s");
    let (result, said, exit) = met.tune("far");
    assert_eq!((exit, &result["untested"]), (0, &Value::Null), "{said}");
    assert_eq!(denied(&met), 0);
}

#[test]
fn no_hit_is_better_than_any() {
    let (tune, said, code) = hits("minimise mean(impact_speed)").tune("g");
    assert_eq!(code, 0, "{said}");
    assert_eq!(objective(&tune["chosen"]), 0.0, "{said}");
    assert!(tune["evaluations"].as_array().unwrap().iter().any(|one| objective(one) > 1.0), "{said}");
}

#[test]
fn a_try_that_leaves_a_parameter_open_is_refused() {
    let text = "scenario s {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller carla_behavior { braking_distance: far }; speed 30 km/h }
  pedestrian p { model scripted; start 2 m from kerb; appears when time_to_arrival(av) = 5 s }
  vary far in [6 m, 9 m]
}
tune g {
  on s
  over av.controller.braking_distance in 1 m .. 30 m, av.controller.safety_time in 1 s .. 4 s
  minimise mean(time_lost)
  try { safety_time: 2 s }
  budget 2 evaluations, by random
}
";
    let output = scenario_runner(Place::new(text).path(), &["tune", "g", "street.scn"]);
    assert_ne!(code(&output), 0);
    let said = stderr(&output);
    assert!(
        said.contains("leaves a tuned parameter without one value") && said.contains("every parameter"),
        "{said}"
    );
}
