//! What a pedestrian's model makes of the situation, for whoever looks at a run.

use serde::{Deserialize, Serialize};

/// A quantity that a pedestrian's model works with, such as the value of an action.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StateQuantity {
    /// What it is one of, such as `value of each action`. Quantities of one group stand one after the other, and have one unit.
    pub group: String,
    /// Which one of them it is.
    pub name: String,
    /// From where to where it usually lies, for drawing.
    pub range: (f64, f64),
}

/// The quantities of a pedestrian's model after a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModelState {
    /// The vehicle (its place in the world) that they are about, if they are about one.
    pub about: Option<usize>,
    /// One for each quantity, in their order.
    pub values: Vec<f64>,
}
