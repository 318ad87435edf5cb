//! Numbers are shown to people in the units that the user wrote, and in SI units to programs.

use std::fs;
use std::path::Path;

use crate::support::program::{code, scenario_runner, stderr, stdout};
use serde_json::Value;

/// Somebody stands in the lane and is hit at the speed of the car.
const HIT: &str = "scenario hit {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller constant_speed; speed v; start 60 m before crossing }
  pedestrian walker { model scripted { stop_after: 2.75 m }; start 1 m from kerb; appears at 0 s }
  vary v in [20 km/h, 33.3 km/h]
  expect { impact_speed <= 30 km/h }
}
";

const BLOCKS: &str = "search fastest {
  in hit
  maximise impact_speed
  over v in 30 km/h .. 60 km/h
  budget 3 evaluations, by random
  keep impact_speed > 50 km/h
}
evaluate known {
  on hit
  with default, { av.controller.period: 40 ms } as slow_ticks
  measure mean(impact_speed), rate(impact_speed > 10 mph), max(impact_speed)
  reported default: 25 km/h, 100 %, 40 km/h
}
tune ticks {
  on hit
  over av.controller.period in 20 ms .. 50 ms
  minimise mean(impact_speed)
  subject to impact_speed <= 40 km/h
  budget 3 evaluations, by random
  compare with default
}
statement harmless {
  \"They drive slowly.\"
  claim max(impact_speed) of hit <= 40 km/h
}
";

fn place(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("hit.scn"), text).unwrap();
    folder
}

/// What is said from the line that begins with `first` to the next empty one, without spaces at the ends of lines.
fn paragraph(text: &str, first: &str) -> String {
    let lines =
        text.lines().skip_while(|line| !line.starts_with(first)).take_while(|line| !line.trim().is_empty());
    lines.map(str::trim_end).collect::<Vec<_>>().join("\n")
}

fn run(folder: &Path, arguments: &[&str], expected: i32) -> String {
    let output = scenario_runner(folder, arguments);
    assert_eq!(code(&output), expected, "{}{}", stdout(&output), stderr(&output));
    stdout(&output)
}

#[test]
fn a_table_and_a_failure_are_in_the_unit_of_the_criterion() {
    let folder = place(HIT);
    let said = run(folder.path(), &["hit.scn", "--junit", "junit.xml"], 100);
    insta::assert_snapshot!(paragraph(&said, "hit/hit"), @r"
    hit/hit
      v                       impact_speed
                           km/h mean (max)
      20km/h    ✓ passed                20
      33.3km/h  ✗ failed              33.3
    ");
    insta::assert_snapshot!(paragraph(&said, "error: "), @r"
    error: `impact_speed <= 30 km/h` failed in 1 of 1 runs
     --> hit.scn:6:12
      |
    6 |   expect { impact_speed <= 30 km/h }
      |            ^^^^^^^^^^^^^^^^^^^^^^^ worst: impact_speed 33.3 km/h
      |
      = note: impact_speed 33.3 km/h (-3.3 km/h) at 6.22 s, av and walker  hit/hit/v=33.3km/h/rep=1
      = help: replay: scenario-runner replay 'hit/hit/v=33.3km/h/rep=1' hit.scn --seed 1
    ");
    let junit = fs::read_to_string(folder.path().join("junit.xml")).unwrap();
    assert!(junit.contains("<property name=\"impact_speed\" value=\"33.3 km/h\"/>"), "{junit}");
}

#[test]
fn blocks_are_in_the_units_of_their_ranges_and_comparisons() {
    let folder = place(&[HIT, BLOCKS].concat());
    let said = run(folder.path(), &["hit.scn", "--json", "all.json"], 100);
    insta::assert_snapshot!(paragraph(&said, "search fastest: "), @r"
    search fastest: maximise mean(impact_speed)
                 where   observed                model     fresh seeds       first  evaluations
      all  v 56.7 km/h  56.7 km/h  56.63 ± 0.1193 km/h  56.7 km/h (20)  pedestrian            3
    1 of 1 kept
    ");
    insta::assert_snapshot!(paragraph(&said, "evaluate known: "), @r"
    evaluate known: 2 cases, each once under its own seed
                  period  mean(impact_speed)  rate(impact_speed > 10 mph)  max(impact_speed)
      default      25 ms          26.65 km/h                        100 %          33.3 km/h
        reported                     25 km/h                        100 %            40 km/h
      slow_ticks   40 ms          26.65 km/h                        100 %          33.3 km/h
        change                        0 km/h            0 % [-84.2, 84.2]             0 km/h
      change: from default, case by case, with an interval at 95 % where there is one
    ");
    let tune = paragraph(&said, "tune ticks: ");
    insta::assert_snapshot!(tune.lines().take(8).collect::<Vec<_>>().join("\n"), @r"
    tune ticks: minimise mean(impact_speed) over 2 cases
      subject to impact_speed <= 40 km/h
      4 of 4 candidates are feasible
      chosen: av.controller.period 25 ms gives 26.65 km/h, margins 6.7 km/h
      nothing better than what is declared
                                                   before                      after              before, fresh               after, fresh
      collision                                     100 %                      100 %                      100 %                      100 %
      impact_speed                26.65 km/h (20 .. 33.3)    26.65 km/h (20 .. 33.3)    26.65 km/h (20 .. 33.3)    26.65 km/h (20 .. 33.3)
    ");
    insta::assert_snapshot!(paragraph(&said, "statement harmless: "), @r"
    statement harmless: reproduced
      “They drive slowly.”
      ✓ max(impact_speed) of hit <= 40 km/h: 33.3 km/h <= 40 km/h
    ");

    // For programs everything stays in SI units, with all digits.
    let all: Value =
        serde_json::from_str(&fs::read_to_string(folder.path().join("all.json")).unwrap()).unwrap();
    let block = |kind: &str| {
        let blocks = all["suites"][0]["blocks"].as_array().unwrap();
        &blocks.iter().find(|one| one["kind"] == kind).unwrap()["result"][kind]
    };
    let found = &block("search")["found"][0];
    let speed = found["best"][0][1].as_f64().unwrap();
    assert!((speed * 3.6 - 56.7).abs() < 0.05 && speed.to_string().len() > 12, "{speed}");
    assert!((found["observed"].as_f64().unwrap() - speed).abs() < 1e-9);
    let fast = block("evaluate")["conditions"][0]["measured"][2].as_f64().unwrap();
    assert!((fast - 33.3 / 3.6).abs() < 1e-9, "{fast}");
}

#[test]
fn charts_are_in_the_units_of_the_criteria() {
    let folder = place(&[HIT, BLOCKS].concat());
    run(folder.path(), &["hit.scn", "--html", "all.html"], 100);
    let page = fs::read_to_string(folder.path().join("all.html")).unwrap();
    assert!(page.contains("impact_speed (km/h)") && page.contains("≤ 30 km/h"), "no chart is in km/h");
    assert!(!page.contains("m/s)") && !page.contains(" m/s<"), "something is in m/s");
}

/// Somebody is hit by a car that brakes a little; `more` statements of the suite.
fn braking(deceleration: &str, more: &str) -> String {
    format!(
        "suite braking {{
  seed 1
  scenario hit {{
    road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }}
    vehicle av {{
      controller constant_deceleration {{ time: 5.5 s, deceleration: {deceleration} }}
      speed 33.3 km/h
      start 60 m before crossing
    }}
    pedestrian walker {{ model scripted {{ stop_after: 2.75 m }}; start 1 m from kerb; appears at 0 s }}
    expect {{ impact_speed <= 50 km/h }}
  }}
{more}}}
"
    )
}

#[test]
fn comparisons_and_gates_are_in_the_units_of_the_suite() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("was.suite", &braking("0.1 g", ""));
    write("now.suite", &braking("0.05 g", ""));
    let said = run(folder.path(), &["compare", "was.suite", "now.suite", "--tolerance", "1"], 104);
    let lines = |part: &str| -> Vec<String> {
        said.lines().filter(|line| line.contains(part)).map(|line| line.trim().to_string()).collect()
    };
    insta::assert_snapshot!([lines("tested: "), lines("impact_speed")].concat().join("\n"), @r"
    tested: av.controller.deceleration: 0.1 g -> 0.05 g
    ✗ impact_speed  30.67 km/h  32.01 km/h  +4.38 %        1 %      anything more
    impact_speed in hit: 30.67 km/h -> 32.01 km/h, worse by 4.38 % where 1 % is tolerated; there is no chance in it
    ");
    // Of all metrics the time by which it follows is worse by more than 5 %.
    let json = run(folder.path(), &["compare", "was.suite", "now.suite", "--format", "json"], 104);
    let json: Value = serde_json::from_str(&json).unwrap();
    let checks = json[0]["checks"].as_array().unwrap();
    let speed = checks.iter().find(|check| check["label"] == "impact_speed").unwrap();
    assert!(speed["base"].as_f64().is_some_and(|base| base < 9.25) && speed["notation"]["symbol"] == "km/h");
    assert!((json[0]["changes"][0]["before"].as_f64().unwrap() - 0.980_665).abs() < 1e-12);

    // A gate's rule that says its tolerance in another unit is shown in that.
    run(folder.path(), &["baseline", "save", "was.suite", "--out", "was.json"], 0);
    let gate = "  gate slower { baseline \"was.json\"; impact_speed not worse by more than 0.1 mph }\n";
    write("now.suite", &braking("0.05 g", gate));
    let said = run(folder.path(), &["now.suite"], 104);
    insta::assert_snapshot!(paragraph(&said, "  impact_speed in "), @r"
    impact_speed in hit: 19.06 mph -> 19.89 mph, worse by 4.38 % where 0.525 % is tolerated; there is no chance in it
        1 of 1 runs got worse
          19.06 mph -> 19.89 mph  braking/hit/rep=1
        replay: scenario-runner replay 'braking/hit/rep=1' now.suite --seed 1
    ");
    let gate = gate.replace("0.1 mph", "1 %");
    write("now.suite", &braking("0.05 g", &gate));
    let said = run(folder.path(), &["now.suite"], 104);
    insta::assert_snapshot!(paragraph(&said, "  impact_speed in "), @r"
    impact_speed in hit: 30.67 km/h -> 32.01 km/h, worse by 4.38 % where 1 % is tolerated; there is no chance in it
        1 of 1 runs got worse
          30.67 km/h -> 32.01 km/h  braking/hit/rep=1
        replay: scenario-runner replay 'braking/hit/rep=1' now.suite --seed 1
    ");
}

#[test]
fn models_refuse_in_the_units_of_the_scenario() {
    let scenario = |model: &str, start: &str, step: &str| {
        format!(
            "scenario hasty {{
  road {{ lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }}
  vehicle av {{ controller constant_speed; speed 30 km/h }}
  pedestrian walker {{ model {model}; start {start} from kerb; appears when time_to_arrival(av) = 4 s }}
  step {step}
  expect {{ no collision }}
}}
"
        )
    };
    let slow = "commotions { variant: oVAoEA, T: 15 ms }";
    for (model, start, step, said) in [
        (slow, "1 m", "25 ms", "is 15 ms, shorter than its time step `dt` of 0.025 s"),
        (
            "commotions { dt: 25 ms }",
            "1 m",
            "10 ms",
            "every 25 ms, which is no multiple of the simulation step of 10 ms",
        ),
        ("jaywalker", "-50 cm", "20 ms", "starts 50 cm inside the kerb"),
        ("interceptor", "-1 ft", "20 ms", "starts 1 ft inside the kerb"),
    ] {
        let folder = place(&scenario(model, start, step));
        let output = scenario_runner(folder.path(), &["check", "hit.scn"]);
        assert!(stderr(&output).contains(said), "{}", stderr(&output));
    }
}

#[test]
fn models_refuse_in_few_digits() {
    let text = "scenario hasty {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller constant_speed; speed 30 km/h }
  pedestrian walker {
    model commotions { variant: oVAoEA, T: 1 s / 60 }
    start 1 m from kerb
    appears when time_to_arrival(av) = 4 s
  }
  expect { no collision }
}
";
    let folder = place(text);
    let output = scenario_runner(folder.path(), &["check", "hit.scn"]);
    let said = stderr(&output);
    assert!(
        said.contains("`T` of `commotions` is 0.01667 s, shorter than its time step `dt` of 0.025 s"),
        "{said}"
    );
}
