//! Numbers on the command line that nobody can have meant: refused where they stand, and never a bug of ours.

use std::fs;

use crate::support::program::{code, scenario_runner, stderr};

const WALK: &str = "scenario walk {
  road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
  vehicle av { controller constant_speed; speed 30 km/h }
  pedestrian walker { model scripted; start 1 m from kerb; appears when time_to_arrival(av) = 4 s }
  horizon 20 s
  expect { min_distance >= 0 m undefined passes }
}
";

const VALUES: [&str; 12] = [
    "0",
    "1",
    "-1",
    "",
    " 1",
    "1.5",
    "1e3",
    "NaN",
    "inf",
    "4294967296",
    "1000000000000000000",
    "99999999999999999999",
];

/// Where a number is expected: the command around it, and which of the values are good.
const FLAGS: [(&[&str], &str, &[&str]); 12] = [
    (&["walk.scn"], "--test-threads=", &["1"]),
    (&["walk.scn"], "-j", &["1"]),
    (&["walk.scn"], "--max-fail=", &["1", "4294967296", "1000000000000000000"]),
    (&["walk.scn"], "--seed=", &["0", "1", "4294967296", "1000000000000000000"]),
    (&["walk.scn"], "--repeat=", &["1"]),
    (&["walk.scn", "--no-tests=pass"], "--partition=slice:1/", &["1", "4294967296", "1000000000000000000"]),
    (&["walk.scn", "--no-tests=pass"], "--partition=hash:1/", &["1", "4294967296", "1000000000000000000"]),
    (&["compare", "walk.scn", "walk.scn"], "--tolerance=", &["0", "1", "1.5", " 1"]),
    (&["compare", "walk.scn", "walk.scn"], "--confidence=", &[]),
    (&["baseline", "save", "walk.scn"], "--seed=", &["0", "1", "4294967296", "1000000000000000000"]),
    (&["calibrate", "--print-criteria"], "--threads=", &["1"]),
    (&["calibrate", "--print-criteria"], "--count=", &["1", "4294967296", "1000000000000000000"]),
];

#[test]
fn none_is_taken_that_cannot_be_meant() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("walk.scn"), WALK).unwrap();
    for (command, flag, good) in FLAGS {
        for value in VALUES {
            let said = format!("{flag}{value}");
            let output = scenario_runner(folder.path(), &[command, &[&said]].concat());
            let allowed: &[i32] = if good.contains(&value) { &[0, 100] } else { &[2] };
            assert!(
                allowed.contains(&code(&output)),
                "{} {said:?} ends with {}: {}",
                command.join(" "),
                code(&output),
                stderr(&output)
            );
        }
    }
}

/// As many threads as may be asked for, whatever the machine gives.
#[test]
fn the_most_threads_that_may_be_asked_for_are_no_trouble() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("walk.scn"), WALK).unwrap();
    assert_eq!(code(&scenario_runner(folder.path(), &["walk.scn", "-j", "1024"])), 0);
    let refused = scenario_runner(folder.path(), &["walk.scn", "-j", "1025"]);
    assert_eq!(code(&refused), 2, "{}", stderr(&refused));
    assert!(stderr(&refused).contains("1..=1024"), "{}", stderr(&refused));
}
