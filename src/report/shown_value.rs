//! Values of ranges and objectives as tables of the terminal show them.

use optimise::Coordinate;
use scenario::{ShownIn, significant};

/// Why an objective has no value.
pub(super) const WITHOUT_VALUE: &str =
    "no run has one, or some run without one could be as far from the goal as anything";

/// A value of a range in the unit that the range is written in.
pub(super) fn value(shown_in: Option<&ShownIn>, value: &Coordinate) -> String {
    match (shown_in, value.number()) {
        (Some(unit), Some(number)) => unit.show(number),
        _ => short(value),
    }
}

/// A coordinate without a unit.
fn short(value: &Coordinate) -> String {
    value.number().map_or_else(|| value.to_string(), digits)
}

/// A number without a unit.
pub(super) fn digits(value: f64) -> String {
    significant(value, 4)
}
