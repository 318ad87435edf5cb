//! Values are checked when they are known: whichever way a number comes into a world, one out of range is refused, one in
//! range is taken, and no world that is planned has a number that nobody can calculate with.

use files::Disk;
use lang::{self, Override};
use models::standard;
use proptest::prelude::*;
use runner::experiment::{Context, Silent, run_search};
use runner::plan::{self, PlanError};
use runner::run::Threads;
use scenario::Suite;

/// A statement whose number is given as `X`, its unit and the range that it must keep, in that unit.
struct Statement {
    vehicle: &'static str,
    pedestrian: &'static str,
    unit: &'static str,
    range: (f64, f64),
    /// What the message about it says.
    says: &'static str,
}

const STATEMENTS: [Statement; 11] = [
    Statement { vehicle: "speed X", pedestrian: "", unit: "km/h", range: (0.0, 360.0), says: "the speed of" },
    Statement {
        vehicle: "start X before crossing",
        pedestrian: "",
        unit: "m",
        range: (0.0, 10_000.0),
        says: "the start of",
    },
    Statement {
        vehicle: "start X before crossing",
        pedestrian: "",
        unit: "s",
        range: (0.0, 600.0),
        says: "the start of",
    },
    Statement {
        vehicle: "size X x 2 m",
        pedestrian: "",
        unit: "cm",
        range: (10.0, 3000.0),
        says: "the length of",
    },
    Statement {
        vehicle: "",
        pedestrian: "appears at X",
        unit: "s",
        range: (0.0, 3600.0),
        says: "the time at which",
    },
    Statement {
        vehicle: "",
        pedestrian: "appears when time_to_arrival(av) = X",
        unit: "s",
        range: (0.0, 600.0),
        says: "the time to arrival at which",
    },
    Statement { vehicle: "", pedestrian: "radius X", unit: "cm", range: (1.0, 500.0), says: "the radius of" },
    Statement { vehicle: "", pedestrian: "along X", unit: "m", range: (-100.0, 100.0), says: "the place" },
    Statement {
        vehicle: "",
        pedestrian: "goal X beyond kerb",
        unit: "m",
        range: (-10.0, 100.0),
        says: "the goal of",
    },
    Statement {
        vehicle: "",
        pedestrian: "start X from kerb",
        unit: "m",
        range: (-100.0, 100.0),
        says: "the start of",
    },
    Statement {
        vehicle: "",
        pedestrian: "model scripted { speed: X }",
        unit: "m/s",
        range: (0.0, 12.0),
        says: "`speed` of",
    },
];

/// The ways in which a number comes in.
const WAYS: [&str; 9] =
    ["written", "let", "listed", "drawn", "chosen", "calculated", "template", "set", "searched"];

/// A file in which the statement's number is `value`, with no other statement of its kind.
fn file(statement: &Statement, way: &str, value: f64) -> String {
    let Statement { vehicle, pedestrian, unit, .. } = statement;
    // What is set from outside takes the place of another value.
    let value = if way == "set" { middle(statement) } else { value };
    let written = format!("{value} {unit}");
    let (before, vary, number) = match way {
        "let" => (format!("let given = {written}\n"), String::new(), "given"),
        "listed" => (String::new(), format!("vary x in [{written}]"), "x"),
        "drawn" => (String::new(), format!("vary x in normal({written}, 0.001 {unit}) 3 times"), "x"),
        "chosen" => (String::new(), format!("vary x in choice({written}) 2 times"), "x"),
        "calculated" => {
            let one = format!("vary x in [{written}]\n  vary y in [0 {unit}, 0.0001 {unit}]");
            (String::new(), one, "x + y")
        }
        "searched" => (String::new(), format!("vary x in [{} {unit}]", middle(statement)), "x"),
        _ => (String::new(), String::new(), written.as_str()),
    };
    let number = if way == "template" { "given" } else { number };
    let put = |text: &str| text.replace('X', number);
    let default = |said: &str, word: &str, usual: &'static str| {
        if said.starts_with(word) { "" } else { usual }
    };
    let body = format!(
        "
  road {{ lane_width 4 m; speed_limit 30 km/h; crossing zebra }}
  {vary}
  vehicle av {{
    controller constant_speed
    {}
    {}
    {}
  }}
  pedestrian walker {{
    {}
    {}
    {}
  }}
  expect {{ no collision }}
",
        default(vehicle, "speed", "speed 30 km/h"),
        // A time to arrival decides where the vehicle starts.
        if pedestrian.starts_with("appears when") {
            ""
        } else {
            default(vehicle, "start", "start 60 m before crossing")
        },
        put(vehicle),
        default(pedestrian, "model", "model scripted { speed: 1.4 m/s }"),
        default(pedestrian, "start", "start 2 m from kerb"),
        put(pedestrian),
    );
    let search = if way == "searched" {
        format!(
            "search it {{ in a; minimise pet; over x in {written} .. {} {unit}; budget 1 evaluations, 1 random first, by random }}\n",
            value + 0.001
        )
    } else {
        String::new()
    };
    match way {
        "template" => format!("define base(given) {{{body}}}\nscenario a : base(given: {written}) {{ }}\n"),
        _ => format!("{before}scenario a {{{body}}}\n{search}"),
    }
}

fn middle(statement: &Statement) -> f64 {
    let (low, high) = statement.range;
    if low < 0.0 { 1.0 } else { low + (high - low) / 10.0 }
}

/// The statement's value as it is set from outside.
fn set(statement: &Statement, value: f64) -> Override {
    let Statement { vehicle, pedestrian, unit, .. } = statement;
    let (who, said) = if vehicle.is_empty() { ("walker", *pedestrian) } else { ("av", *vehicle) };
    let name = match said.split(' ').next().unwrap() {
        "model" => "model.speed",
        word => word,
    };
    let more = if name == "size" { " x 2 m" } else { "" };
    format!("{who}.{name}={value} {unit}{more}").parse().unwrap()
}

/// What keeps the file from being run; nothing if it is planned, and every number of every world is then looked at.
fn refusal(text: &str, set: &[Override]) -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("values.scn");
    std::fs::write(&path, text).unwrap();
    let outside = lang::Outside { set: set.to_vec(), ..lang::Outside::default() };
    let loaded = lang::load_otherwise(&path, &outside, &standard(), &Disk)
        .map_err(|failure| failure.render(lang::Style::default()))?;
    let plan = plan::plan(&loaded.suite).map_err(|errors| {
        let PlanError { case, .. } = &errors[0];
        assert!(case.as_ref().is_some_and(|case| case.starts_with("values/a")), "{errors:?}");
        errors[0].to_string()
    })?;
    for case in plan.trials().flat_map(|trial| trial.cases.iter().collect::<Vec<_>>()) {
        only_numbers(&serde_json::to_value(&*case.world).unwrap());
    }
    searched(&loaded.suite)
}

fn refused(statement: &Statement, way: &str, value: f64) -> Result<(), String> {
    let set = if way == "set" { vec![set(statement, value)] } else { Vec::new() };
    refusal(&file(statement, way, value), &set)
}

fn searched(suite: &Suite) -> Result<(), String> {
    let threads = Threads::new(1);
    let context = Context::new(suite, &threads, &standard());
    suite.searches.iter().try_for_each(|search| {
        run_search(&context, search, &Silent).map(|_| ()).map_err(|error| error.to_string())
    })
}

/// JSON has no numbers that are none: they are written as null, which no world has otherwise (except for what may be absent).
fn only_numbers(value: &serde_json::Value) {
    match value {
        serde_json::Value::Object(fields) => {
            for (name, field) in fields {
                assert!(!field.is_null() || name == "sees", "{name} in {fields:?}");
                only_numbers(field);
            }
        }
        serde_json::Value::Array(values) => values.iter().for_each(|value| {
            assert!(!value.is_null());
            only_numbers(value);
        }),
        _ => {}
    }
}

fn number(text: f64) -> f64 {
    (text * 1e4).round() / 1e4
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn what_is_out_of_range_is_refused_however_it_comes_in(
        statement in 0..STATEMENTS.len(),
        way in 0..WAYS.len(),
        beyond in 0.02..3.0_f64,
        above in any::<bool>(),
    ) {
        let (statement, way) = (&STATEMENTS[statement], WAYS[way]);
        let (low, high) = statement.range;
        let size = high - low;
        let value = number(if above { high + beyond * size } else { low - beyond * size });
        let said = refused(statement, way, value).expect_err(way);
        prop_assert!(said.contains(statement.says), "{way} {value}: {said}");
        prop_assert!(said.contains(statement.unit), "{way} {value}: {said}");
    }

    #[test]
    fn what_is_in_range_is_taken_however_it_comes_in(
        statement in 0..STATEMENTS.len(),
        way in 0..WAYS.len() - 1,
        share in 0.05..0.6_f64,
    ) {
        let (statement, way) = (&STATEMENTS[statement], WAYS[way]);
        let (low, high) = statement.range;
        // Somebody who starts on the far side of the road cannot walk across it.
        let low = if statement.pedestrian.starts_with("start") { -1.0 } else { low };
        let low = if statement.pedestrian.starts_with("goal") { -1.0 } else { low };
        let value = number(low + share * (high - low));
        let taken = refused(statement, way, value);
        prop_assert!(taken.is_ok(), "{way} {value}: {}", taken.unwrap_err());
    }
}

/// The example of the audit: at four of twelve drawn times nobody would ever have appeared, and the run passed.
#[test]
fn a_drawn_time_to_arrival_below_zero_names_the_case_and_the_range() {
    let statement = &STATEMENTS[5];
    let text = file(statement, "drawn", 4.0).replace("0.001 s", "4 s").replace("3 times", "12 times");
    let said = refusal(&text, &[]).unwrap_err();
    assert!(said.starts_with("the time to arrival at which pedestrian `walker` appears is -"), "{said}");
    assert!(said.contains(" s, but must be between 0 and 600 s, in values/a/x=-"), "{said}");
}
