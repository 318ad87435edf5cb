//! Who comes into the sight of a vehicle, and who is lost from it.

use super::solid::Solid;

/// A vehicle's controller is shown somebody from a decision on whom it was not shown at the one before, or the other way round. With latency that is
/// later than they came into view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// The index of the vehicle.
    pub vehicle: usize,
    /// Whom it is about: another vehicle, or a pedestrian.
    pub who: Solid,
    /// Whether they are shown now.
    pub seen: bool,
    /// Of the decision, from the beginning of the step on, s.
    pub moment: f64,
}
