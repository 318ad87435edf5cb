//! What somebody outside the crate adds to a registry is named by suites, run, tuned and shown like what ships.

#![allow(clippy::duplicate_mod, reason = "every example has what they share as a module of its own")]

#[path = "../../examples/own_controller.rs"]
mod own_controller;
#[path = "../../examples/own_metric.rs"]
mod own_metric;
#[path = "../../examples/own_pedestrian.rs"]
mod own_pedestrian;

/// How many trials of a table passed; none may have failed.
fn passed(table: &str) -> usize {
    assert!(!table.contains("✗"), "{table}");
    table.matches("✓ passed").count()
}

#[test]
fn a_controller_of_ones_own_is_run_and_tuned() {
    let table = own_controller::table().unwrap();
    assert_eq!(passed(&table), 3, "{table}");
    assert!(table.contains("9 of 9 candidates are feasible"), "{table}");
    // The gentlest that there is: it begins early enough to stop.
    assert!(table.contains("chosen: av.controller.comfort 1 m/s^2 gives"), "{table}");
}

#[test]
fn a_pedestrian_of_ones_own_is_run() {
    let table = own_pedestrian::table().unwrap();
    assert_eq!(passed(&table), 3, "{table}");
}

#[test]
fn a_metric_of_ones_own_is_measured() {
    let table = own_metric::table().unwrap();
    assert_eq!(passed(&table), 3, "{table}");
    assert!(table.contains("slow_time(below=2.7777777777777777)"), "{table}");
}
