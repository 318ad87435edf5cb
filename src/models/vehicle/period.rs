//! The parameter of how often a controller decides.

use scenario::{Dimension, Parameter};

/// How often a controller decides for which no period was published. Declared by each of them, so that their results
/// do not depend on the simulation step.
pub(super) fn period() -> Parameter {
    Parameter::number(
        "period",
        Dimension::TIME,
        0.025,
        (0.001, 1.0),
        "Time between decisions; the command is held in between.",
        "free choice: 40 Hz; nothing published",
    )
}
